"""Where sequences and functions change sign, found with few evaluations of many terms each."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_AWAY: Array = np.exp2(np.arange(32.0))
_FIRST: Array = _AWAY - 1
_WIDER, _STEPS = 20, 80  # fourfold widenings of a bracket, and steps within it
_ROUNDING = 4e-16  # of positions: the spacing of floating-point numbers
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


def falling_root(excess: Callable[[Array], Array], guess: Array, width: Array) -> Array:
    """Where functions that fall are zero, one for each guess; the end of the search if nowhere.

    Regula falsi of the Illinois kind, from a bracket that grows from `width` about the guess until
    it holds the root.
    """
    low, high = guess - width, guess + width
    for _ in range(_WIDER):
        below, above = excess(low), excess(high)
        if (below >= 0).all() and (above <= 0).all():
            break
        width = 4 * width
        low, high = np.where(below < 0, low - width, low), np.where(above > 0, high + width, high)
    for _ in range(_STEPS):
        size = high - low
        share = np.where(below > above, below / np.where(below > above, below - above, 1.0), 0.5)
        middle = np.clip(low + size * share, low, high)
        value = excess(middle)
        over = value > 0
        low, high = np.where(over, middle, low), np.where(over, high, middle)
        below, above = np.where(over, value, below / 2), np.where(over, above / 2, value)
        if (size <= _ROUNDING * np.abs(middle)).all() or not value.any():
            break
    return middle
