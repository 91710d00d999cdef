"""Where an increasing sequence changes sign, found with few evaluations of many terms each."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_AWAY: Array = np.exp2(np.arange(32.0))
_AROUND: Array = np.concatenate([-_AWAY[::-1], [0.0], _AWAY])


def first_positive(excess: Callable[[Array], Array], count: int) -> int:
    """The first of 0, 1, ..., count - 1 with excess > 0, as for all after it; else count.

    excess: of an array of these numbers; where it is not finite it counts as positive. Powers of
    two are tried first, then the zero of a parabola through what is known and numbers at growing
    distances on either side of it: no slower than bisection, two rounds where it is a parabola.
    """
    low, high = 0, count
    tried: Array = _AWAY[: count.bit_length()] - 1
    while low < high:
        with np.errstate(over="ignore", invalid="ignore"):
            y = excess(tried)
        positive = ~(y <= 0)  # not finite: far beyond
        first = int(positive.argmax()) if positive[-1] else y.size
        near = slice(max(first - 2, 0), first + 1)
        guess = _zero(tried[near].tolist(), y[near].tolist()) if first < y.size else high
        if first < y.size:
            high = int(tried[first])
        if first:
            low = int(tried[first - 1]) + 1
        tried = np.minimum(np.maximum(guess + _AROUND, low), high - 1)
    return low


def _zero(x: list[float], y: list[float]) -> float:
    """Left of the zero between the last two of up to three points, of the parabola through them."""
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
