"""Polynomials through Chebyshev points, by which families of free surfaces are read."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]
Powers = tuple[float, ...]


def horner(powers: Powers, t: Any) -> Any:
    total = 0.0
    for power in powers:
        total = total * t + power
    return total


def powers(t: Array, values: Array) -> Array:
    """Coefficients of falling powers of the polynomials (columns) through Chebyshev points t."""
    series = chebyshev.chebfit(t, values, t.size - 1)
    convert = np.zeros((t.size, t.size))
    for order in range(t.size):
        convert[: order + 1, order] = chebyshev.cheb2poly(np.eye(t.size)[order])[: order + 1]
    return np.asarray((convert @ series)[::-1])
