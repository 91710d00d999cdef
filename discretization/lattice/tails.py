"""The free surfaces of a lattice between its nodes: a factor λ per node beyond a contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.shares import shares

Array = NDArray[Any]


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
