"""python -m tests.truth CLASS N SEED: how many of N random cases from SEED on come out right.

The classes of load paths, such as machine_opening, are counted for the fitted mesh and for nodes;
slow is what takes more than PATIENCE seconds of processor time. N = 1 prints reference and answer.
"""

import signal
import sys
from collections import Counter, defaultdict

import numpy as np

from .compare import Verdict, verdict
from .paths.path_compare import path_verdicts
from .paths.random_paths import PATH_KINDS, path_case
from .random_states import KINDS, case_of

PATIENCE = 30.0


class Slow(BaseException):
    """A case takes too long."""


def _slow(*_):
    raise Slow


def main(kind, count, seed):
    """Print what is not right, a summary for each method, and one case in full."""
    if kind not in KINDS + PATH_KINDS:
        raise SystemExit(f"CLASS = {kind!r} is unknown; known: {', '.join(KINDS + PATH_KINDS)}")
    words = defaultdict(Counter)
    seconds = defaultdict(list)
    signal.signal(signal.SIGVTALRM, _slow)
    for one in range(seed, seed + count):
        for method, found in verdicts(kind, one).items():
            words[method][found.word] += 1
            seconds[method].append((found.seconds, found.reference_seconds))
            if found.word != "right" or count == 1:
                shape = (case_of if kind in KINDS else path_case)(kind, one).shape
                print(f"seed {one} ({shape}) {method}: {found.word}: {found.why}", flush=True)
            if count == 1:
                print(f"reference: {found.truth}\nanswer: {found.answer}")
                for event in getattr(found.answer, "events", ()):
                    print(" ", event)
    for method, counted in words.items():
        own, other = np.mean(seconds[method], axis=0)
        told = ", ".join(f"{n} {word}" for word, n in counted.most_common())
        print(f"{kind} {method}: {told} of {count}; {own:.3g} s each, reference {other:.3g} s")


def verdicts(kind, seed):
    """What each method says about a case, within PATIENCE."""
    signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE)
    try:
        return {"": verdict(kind, seed)} if kind in KINDS else path_verdicts(kind, seed)
    except Slow:
        return {"": Verdict("slow", "", None, None, PATIENCE, 0.0)}
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
