"""How far the two ends of a free surface displace it in between (small slopes)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def shares(rate: float, p: Array, q: Array) -> tuple[Array, Array, Array]:
    """a, b and 1 - a - b of the free surface u = a left + b right, p from left and q from right.

    a = sinh(rate·q)/sinh(rate·(p+q)), b = sinh(rate·p)/sinh(rate·(p+q)),
    1 - a - b = 2 sinh(rate·p/2) sinh(rate·q/2)/cosh(rate·(p+q)/2);

    p and q may be inf. A tail decays by exp(-rate): μ per link, μ/Δx per length on the lattice.
    """
    ep, eq, both = np.exp(-rate * p), np.exp(-rate * q), np.expm1(-2 * rate * (p + q))
    near, far = ep * np.expm1(-2 * rate * q) / both, eq * np.expm1(-2 * rate * p) / both
    return near, far, np.expm1(-rate * p) * np.expm1(-rate * q) / (1 + ep * eq)
