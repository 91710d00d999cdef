"""python -m tests.truth CLASS N SEED: how many of N random cases from SEED on come out right.

With N = 1 the scene, the reference and the answer are printed. The classes of load paths, such as
machine_opening, are counted for the fitted mesh and for nodes; a path that takes more than
PATIENCE seconds of processor time is counted as slow.
"""

import signal
import sys
from collections import Counter

import numpy as np

from .compare import verdict
from .paths.path_compare import path_verdicts
from .paths.path_scenes import PATH_KINDS, path_case
from .scenes import KINDS, case_of


def main(kind, count, seed):
    """Print the summary of a run, or one case in full."""
    if kind in PATH_KINDS:
        return paths(kind, count, seed)
    if kind not in KINDS:
        known = ", ".join(KINDS + PATH_KINDS)
        raise SystemExit(f"CLASS = {kind!r} is unknown; known: {known}")
    if count == 1:
        return full(kind, seed)
    words, shapes, seconds = Counter(), Counter(), []
    for one in range(seed, seed + count):
        found, shape = verdict(kind, one), case_of(kind, one).shape
        words[found.word] += 1
        seconds.append((found.seconds, found.reference_seconds))
        if found.word != "right":
            shapes[found.word, shape] += 1
            if words[found.word] <= 5:
                print(f"seed {one} ({shape}): {found.word}: {found.why}", flush=True)
    own, other = np.mean(seconds, axis=0)
    print(", ".join(f"{n} {word}" for word, n in words.most_common()), "of", count)
    for (word, shape), n in shapes.most_common():
        print(f"  {word:8} {shape:16} {n}")
    print(f"minimise {own:.3g} s per state, at most {max(s[0] for s in seconds):.3g}; "
          f"reference {other:.3g} s, at most {max(s[1] for s in seconds):.3g}")  # fmt: skip
    return None


def full(kind, seed):
    """Print one case."""
    case, found = case_of(kind, seed), verdict(kind, seed)
    print(f"{kind} {seed}: {case.shape}, k = {case.scene.stiffness!r}, "
          f"gamma1 = {case.scene.gamma1!r}, w = {case.scene.work_of_adhesion!r}, "
          f"depth = {case.depth!r}, feature = {case.feature!r}")  # fmt: skip
    for name, state in (("reference", found.truth), ("minimise", found.state)):
        if state is not None:
            print(f"{name:10} force {state.force!r} energy {state.energy!r} "
                  f"half_width {state.half_width!r}\n{state.contacts}")  # fmt: skip
    print(f"{found.word}: {found.why}")


PATIENCE = 30.0  # seconds of processor time for one path, by all methods


class Slow(BaseException):
    """A path takes too long."""


def _slow(*_):
    raise Slow


def paths(kind, count, seed):
    """Print the summary of load paths by each method, or one case in full."""
    words, seconds = {}, {}
    signal.signal(signal.SIGVTALRM, _slow)
    for one in range(seed, seed + count):
        signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE)
        try:
            verdicts = path_verdicts(kind, one)
        except Slow:
            print(f"seed {one} ({path_case(kind, one).shape}): slow", flush=True)
            words.setdefault("slow", Counter())["slow"] += 1
            seconds.setdefault("slow", []).append((PATIENCE, 0.0))
            continue
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        for method, found in verdicts.items():
            words.setdefault(method, Counter())[found.word] += 1
            seconds.setdefault(method, []).append((found.seconds, found.reference_seconds))
            if found.word != "right" or count == 1:
                shape = path_case(kind, one).shape
                print(f"seed {one} ({shape}) {method}: {found.word}: {found.why}", flush=True)
            if count == 1 and found.truth is not None:
                steps(found)
    for method, counted in words.items():
        own, other = np.mean(seconds[method], axis=0)
        print(f"{kind} {method}:", ", ".join(f"{n} {word}" for word, n in counted.most_common()),
              f"of {count}; {own:.3g} s per path, reference {other:.3g} s")  # fmt: skip


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
