"""The first place on a way where a function of one variable is no longer negative.

The way is cut at corners, where the function may jump and is read from either side, and sampled in
growing steps. Between samples a maximum is looked for where it could reach 0, so that a stop is
not missed next to where it disappears.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.roots import bracketed

Array = NDArray[np.float64]
Function = Callable[[float, float], float]
_GOLDEN = (math.sqrt(5) - 1) / 2
_REFINEMENTS = 60
_FIRST = 1 / 64
_MARGIN = 4.0


@dataclass(frozen=True, eq=False)
class Ground:
    """Corners (increasing), the largest step of samples, how far aside of a corner to read."""

    corners: Array
    step: float
    aside: float

    def between(self, start: float, end: float) -> list[float]:
        """Corners strictly between, in the order of the way."""
        lo, hi = min(start, end), max(start, end)
        first = int(np.searchsorted(self.corners, lo, side="right"))
        last = int(np.searchsorted(self.corners, hi, side="left"))
        found = [float(x) for x in self.corners[first:last]]
        return found if end > start else found[::-1]

    def at_corner(self, x: float) -> bool:
        """Whether x is a corner."""
        i = int(np.searchsorted(self.corners, x))
        return i < self.corners.size and bool(self.corners[i] == x)


def first_stop(h: Function, start: float, limit: float, ground: Ground) -> float | None:
    """First x from `start` to `limit` with h(x, aside) >= 0; None if there is none."""
    if start == limit:
        return None
    aside = math.copysign(ground.aside, limit - start)
    if h(start, aside if ground.at_corner(start) else 0.0) >= 0:
        return start
    x = start
    for end in [*ground.between(start, limit), limit]:
        kinks = {p: a for p, a in ((x, aside), (end, -aside)) if ground.at_corner(p)}
        found = _within(_beside(h, kinks), x, end, ground.step)
        if found is not None:
            return found
        if end != limit and h(end, aside) >= 0:
            return end
        x = end
    return None


def _beside(h: Function, kinks: dict[float, float]) -> Callable[[float], float]:
    """h read aside of these points, and elsewhere where it is."""
    return lambda x: h(x, kinks.get(x, 0.0))


def _within(h: Callable[[float], float], start: float, end: float, most: float) -> float | None:
    """The stop between two points with no corner in between."""
    way, length = math.copysign(1.0, end - start), abs(end - start)
    most = min(most, length)
    done, step = 0.0, _FIRST * most
    seen = [(start, h(start))]
    while done < length:
        done = length if done + step >= length * (1 - 1e-9) else done + step
        x = end if done == length else start + way * done
        value = h(x)
        if value >= 0:
            return x if value == 0 else bracketed(h, seen[-1][0], x)
        seen = [*seen[-2:], (x, value)]
        last = seen[-2:] if done == length else []
        for samples in (seen, last):
            found = _hidden(h, samples, samples is last)
            if found is not None:
                return found
        step = min(2 * step, most)
    return None


def _hidden(
    h: Callable[[float], float], seen: list[tuple[float, float]], last: bool
) -> float | None:
    """A stop beside the largest of two or three negative samples, unless the next ones show it."""
    values = [value for _, value in seen]
    best = max(range(len(seen)), key=values.__getitem__, default=0)
    if not seen or best == 2 or (best != len(seen) - 2 and not last):
        return None
    apart = max(abs(values[best] - value) for value in values)
    if len(seen) == 2:
        middle = (seen[0][0] + seen[1][0]) / 2
        apart = max(apart, _MARGIN * _rise(values[0], h(middle), values[1]))
    if values[best] + apart < 0:
        return None
    lo, hi = seen[0][0], seen[-1][0]
    for _ in range(_REFINEMENTS):
        one, other = hi - _GOLDEN * (hi - lo), lo + _GOLDEN * (hi - lo)
        low, high = h(one), h(other)
        for x, value in ((one, low), (other, high)):
            if value >= 0:
                return x if value == 0 else bracketed(h, seen[0][0], x)
        if abs(hi - lo) <= 1e-15 * (abs(lo) + abs(hi)):
            break
        if low > high:
            hi = other
        else:
            lo = one
    return None


def _rise(first: float, middle: float, last: float) -> float:
    """Above the largest of three equidistant values, the maximum of a parabola through them."""
    bend, slope = first - 2 * middle + last, (last - first) / 2
    if not (bend < 0 and abs(slope) < -bend):
        return abs(middle - max(first, last))
    return middle - slope * slope / (2 * bend) - max(first, middle, last)
