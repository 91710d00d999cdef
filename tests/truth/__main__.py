"""python -m tests.truth CLASS N SEED: how many of N random cases from SEED on come out right.

With N = 1 the scene, the reference and the answer are printed.
"""

import sys
from collections import Counter

import numpy as np

from .compare import verdict
from .scenes import KINDS, case_of


def main(kind, count, seed):
    """Print the summary of a run, or one case in full."""
    if kind not in KINDS:
        raise SystemExit(f"CLASS = {kind!r} is unknown; known: {', '.join(KINDS)}")
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


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
