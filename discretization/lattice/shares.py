"""How far the two ends of a free surface displace it in between, and what it does to them.

Small slopes, of a line contact and around an axis; on the nodes, and as a line through them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Pair(NamedTuple):
    """Stiffness by which a free surface ties its two ends to each other, and to the ground.

    It pulls at an end displaced by u, the other one by u', with tie·(u - u') + left·u (or right).
    """

    tie: Any
    left: Any
    right: Any


def shares(rate: float, p: Any, q: Any) -> tuple[Array, Array, Array]:
    """a, b and 1 - a - b of the free surface u = a left + b right, p from left and q from right.

    a = sinh(rate·q)/sinh(rate·(p+q)), b = sinh(rate·p)/sinh(rate·(p+q)),
    1 - a - b = 2 sinh(rate·p/2) sinh(rate·q/2)/cosh(rate·(p+q)/2);

    p and q may be inf. A tail decays by exp(-rate): μ per link, μ/Δx per length on the lattice.
    """
    ep, eq, both = np.exp(-rate * p), np.exp(-rate * q), np.expm1(-2 * rate * (p + q))
    near, far = ep * np.expm1(-2 * rate * q) / both, eq * np.expm1(-2 * rate * p) / both
    return near, far, np.expm1(-rate * p) * np.expm1(-rate * q) / (1 + ep * eq)


@dataclass(frozen=True)
class LatticeTail:
    """Free nodes beyond a contact: u decays by exp(-rate) per length, Eq. (6) on the lattice."""

    rate: float

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """u_line exp(-rate·distance)."""
        return u_line * np.exp(-self.rate * distance)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """-rate·u_line."""
        return -self.rate * u_line

    def between(
        self, p: Array, q: Array, width: float, left: float, right: float, radius: float = math.inf
    ) -> Array:
        """[left sinh(rate·q) + right sinh(rate·p)]/sinh(rate·width), small slopes only."""
        near, far, _ = shares(self.rate, p, q)
        return near * left + far * right

    def slope_between(
        self, width: Array, own: Array, other: Array, radius: Any = math.inf
    ) -> Array:
        """Slope of `between` at a line with u = own towards the next one, `width` away."""
        once, twice = np.exp(-self.rate * width), np.expm1(-2 * self.rate * width)
        return self.rate * ((2 + twice) * own - 2 * once * other) / twice
