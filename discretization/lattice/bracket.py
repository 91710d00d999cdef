"""Where sequences and functions change sign, found with few evaluations of many terms each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_FIRST: Array = np.exp2(np.arange(32.0)) - 1
_SHARES: Array = np.arange(16.0) / 16


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
