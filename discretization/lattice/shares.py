"""How far the two ends of a free surface displace it in between, and what it does to them.

Small slopes, of a line contact and around an axis.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Pair(NamedTuple):
    """Stiffness by which a free surface ties its two ends to each other, and to the ground.

    It pulls at an end displaced by u, the other one by u', with tie·(u - u') + left·u (or right).
    """

    tie: Any
    left: Any
    right: Any


def shares(rate: float, p: Array, q: Array) -> tuple[Array, Array, Array]:
    """a, b and 1 - a - b of the free surface u = a left + b right, p from left and q from right.

    a = sinh(rate·q)/sinh(rate·(p+q)), b = sinh(rate·p)/sinh(rate·(p+q)),
    1 - a - b = 2 sinh(rate·p/2) sinh(rate·q/2)/cosh(rate·(p+q)/2);

    p and q may be inf. A tail decays by exp(-rate): μ per link, μ/Δx per length on the lattice.
    """
    ep, eq, both = np.exp(-rate * p), np.exp(-rate * q), np.expm1(-2 * rate * (p + q))
    near, far = ep * np.expm1(-2 * rate * q) / both, eq * np.expm1(-2 * rate * p) / both
    return near, far, np.expm1(-rate * p) * np.expm1(-rate * q) / (1 + ep * eq)


def first_free(spring: Any, link: Any, tie: Any, ground: Any) -> tuple[Any, Any, Any]:
    """B, 1 - A - B and S of the first free node beside a contact line: A u + B u' displaces it.

    spring, link: its own, and the one to the line at u; tie, ground: what the rest of the free
    surface, to a line at u', does to it (`Pair`); S: its stiffness with both lines at rest.
    """
    whole = spring + link + tie + ground
    return tie / whole, (spring + ground) / whole, whole
