"""Where an increasing sequence changes sign, found with few evaluations of many terms each."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_AWAY: Array = np.exp2(np.arange(32.0))
_FIRST: Array = _AWAY - 1
_AROUND: Array = np.concatenate([-_AWAY[::-1], [0.0], _AWAY])


def first_above(level: float, term: Callable[[Array], Array], count: int) -> int:
    """The first of 0, 1, ..., count - 1 with term > level, as for all after it; else count.

    term: of an array of these numbers; where it is not finite it counts as above. Powers of two
    are tried first, then the root of a parabola through what is known and numbers at growing
    distances on either side of it: no slower than bisection, two rounds where it is a parabola.
    """
    low, high, tried = 0.0, float(count), _FIRST[: count.bit_length()]
    with np.errstate(over="ignore", invalid="ignore"):
        while low < high:
            y = term(tried)
            first = int(y.searchsorted(level, side="right"))  # nan: far beyond
            if first < y.size:
                high = float(tried[first])
            if first:
                low = float(tried[first - 1]) + 1
            if low < high:
                known = slice(max(first - 2, 0), first + 1)
                guess = _root(tried[known], y[known] - level) if first < y.size else high
                tried = np.minimum(np.maximum(guess + _AROUND, low), high - 1)
    return int(low)


def _root(points: Array, values: Array) -> float:
    """Left of the root between the last two of up to three points, of the parabola through them."""
    x, y = points.tolist(), values.tolist()
    if len(x) < 2 or not math.isfinite(y[-1]):
        return sum(x[-2:]) // 2
    *before, x0, x1 = x
    *_, y0, y1 = y
    width = x1 - x0
    slope, bend = (y1 - y0) / width, 0.0
    if before and before[0] < x0:
        bend = (slope - (y0 - y[0]) / (x0 - before[0])) / (x1 - before[0])
        slope -= bend * width
    root = math.sqrt(max(slope * slope - 4 * bend * y0, 0.0))
    share = -2 * y0 / (slope + root) if slope + root > 0 else width / 2
    return x0 + math.floor(min(share, width))
