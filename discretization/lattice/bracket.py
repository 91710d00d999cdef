"""Where sequences and functions change sign, found with few evaluations of many terms each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_FIRST: Array = np.exp2(np.arange(32.0)) - 1
_SHARES: Array = np.arange(16.0) / 16
_WIDER, _STEPS = 20, 80  # fourfold widenings of a bracket, and steps within it
_ROUNDING = 4e-16  # of positions: the spacing of floating-point numbers


def first_above(level: float, term: Callable[[Array], Array], count: int) -> int:
    """The first of 0, 1, ..., count - 1 with term > level, as for all after it; else count.

    term: of an array of these numbers; where it is not finite it counts as above. Powers of two
    are tried first, then numbers at equal distances between the last two of them.
    """
    low, high, tried = 0.0, float(count), _FIRST[: count.bit_length()]
    with np.errstate(over="ignore", invalid="ignore"):
        while low < high:
            first = int(term(tried).searchsorted(level, side="right"))  # nan: far beyond
            if first < tried.size:
                high = float(tried[first])
            if first:
                low = float(tried[first - 1]) + 1
            tried = np.floor(low + _SHARES * (high - low))
    return int(low)


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
