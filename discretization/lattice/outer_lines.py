"""Both lines of a convex profile's contact pass many links at once.

Each link has a depth of its own (`Rules.outwards`), where there is nothing but a tail beyond, and
that tail can touch no node but the next.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.rules import Rules

Array = NDArray[np.float64]


def passed(
    rules: Rules, contact: tuple[int, int], depth: float, end: float, through: bool
) -> list[Array]:
    """Depths at which the left and the right line pass links on the way to a depth; or empty.

    through: also links that are passed late, with one before; else the way ends there. A contact of
    two links is left to the walk.
    """
    (first, last), sign, found, stop = contact, 1 if end >= depth else -1, [], end
    for side, at in ((-1, rules.f.size - 1 - first), (1, last)):
        ahead = rules.outwards[side][at:]
        if sign < 0:
            ahead = rules.outwards[side][at - (last - first) : at][::-1]
        own = ahead[: _reached(ahead, end, sign)]
        if through:
            further = np.maximum if sign > 0 else np.minimum
            own = further.accumulate(np.append(depth, own))[1:]
        elif (late := sign * np.diff(own, prepend=depth) <= 0).any():
            own = own[: int(late.argmax())]
            stop = sign * min(sign * stop, sign * float(own[-1] if own.size else depth))
        found.append(own)
    if stop != end:
        found = [own[sign * own < sign * stop] for own in found]
    if sign < 0:
        order = np.argsort(-np.concatenate(found), kind="stable")[: max(last - first - 2, 0)]
        left = int((order < found[0].size).sum())
        found = [found[0][:left], found[1][: order.size - left]]
    return found if any(when.size for when in found) else []


def _reached(depths: Array, end: float, sign: int) -> int:
    """How many of these depths are reached one after the other on the way to the end."""
    beyond = depths > end if sign > 0 else depths <= end
    return int(beyond.argmax()) if beyond.any() else depths.size
