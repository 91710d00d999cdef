"""python -m tests.truth CLASS N SEED: how many of N random cases from SEED on come out right.

The classes of load paths, such as machine_opening, are counted for the fitted mesh and for nodes;
what takes more than PATIENCE seconds of processor time is counted as slow. With N = 1 the
reference and the answer are printed.
"""

import signal
import sys
from collections import Counter, defaultdict

import numpy as np

from .compare import verdict
from .paths.path_compare import path_verdicts
from .paths.path_scenes import PATH_KINDS, path_case
from .scenes import KINDS, case_of

PATIENCE = 30.0


class Slow(BaseException):
    """A case takes too long."""


def _slow(*_):
    raise Slow


def main(kind, count, seed):
    """Print what is not right, a summary for each method, and one case in full."""
    if kind not in KINDS + PATH_KINDS:
        raise SystemExit(f"CLASS = {kind!r} is unknown; known: {', '.join(KINDS + PATH_KINDS)}")
    words, seconds = defaultdict(Counter), defaultdict(list)
    signal.signal(signal.SIGVTALRM, _slow)
    for one in range(seed, seed + count):
        shape = (case_of if kind in KINDS else path_case)(kind, one).shape
        signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE)
        try:
            found = {"": verdict(kind, one)} if kind in KINDS else path_verdicts(kind, one)
        except Slow:
            print(f"seed {one} ({shape}): slow", flush=True)
            words["slow"]["slow"] += 1
            continue
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        for method, answer in found.items():
            words[method][answer.word] += 1
            seconds[method].append((answer.seconds, answer.reference_seconds))
            if answer.word != "right" or count == 1:
                print(f"seed {one} ({shape}) {method}: {answer.word}: {answer.why}", flush=True)
            if count == 1 and answer.truth is not None:
                (in_full if kind in KINDS else steps)(answer)
    for method, counted in words.items():
        own, other = np.mean(seconds[method] or [(PATIENCE, 0.0)], axis=0)
        told = ", ".join(f"{n} {word}" for word, n in counted.most_common())
        print(f"{kind} {method}: {told} of {count}; {own:.3g} s each, reference {other:.3g} s")


def in_full(found):
    """Print a state beside the reference."""
    for name, state in (("reference", found.truth), ("minimise", found.state)):
        if state is not None:
            print(f"{name:10} force {state.force!r} energy {state.energy!r}\n{state.contacts}")


def steps(found):
    """Print a path and its jumps beside the reference."""
    truth, history = found.truth, found.history
    for i, (value, place) in enumerate(zip(truth.values, truth.places, strict=True)):
        own = "" if history is None else f"{history.depth[i]:.12g} {history.force[i]:.12g}"
        print(f"{i:3} {value:.9g}: {place.depth:.12g} {truth.states[i].force:.12g} | {own}")
    for jump in truth.jumps:
        print(f"  jump {jump.step}: at {jump.value:.9g} from {jump.before.depth:.9g} "
              f"to {jump.after.depth:.9g}, released {jump.released:.9g}")  # fmt: skip
    for event in history.events if history is not None else ():
        print(f"  {event.kind} {event.step}: at {event.control:.9g} from {event.before.depth:.9g} "
              f"to {event.after.depth:.9g}, released {event.energy_released:.9g}")  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
