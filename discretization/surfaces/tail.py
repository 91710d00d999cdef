"""The free surfaces of an equilibrium on the fitted mesh, as its observables ask for them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.protocol import At, Surfaces

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FittedTail:
    """Free surfaces beyond contact lines and between two of them, at depth 0 beside lines at -u."""

    surfaces: Surfaces

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """u beyond a line."""
        return self._shape(distance, u_line, radius)[0]

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """u' outwards at each line."""
        pairs = np.broadcast(u_line, radius)
        found = [float(self._shape(np.zeros(1), u, r)[1][0]) for u, r in pairs]
        return np.reshape(found, pairs.shape)

    def between(
        self, p: Array, q: Array, width: float, left: float, right: float, radius: float = math.inf
    ) -> Array:
        """u between two lines."""
        return self._shape(np.where(p <= q, p, width - q), left, radius, width, right)[0]

    def slope_between(
        self, width: Array, own: Array, other: Array, radius: Any = math.inf
    ) -> Array:
        """u' towards the other line, at each line."""
        found = [
            float(self._shape(np.zeros(1), u, r, wide, v)[1][0])
            for wide, u, v, r in np.broadcast(width, own, other, radius)
        ]
        return np.array(found)

    def _shape(
        self, distance: Array, u: float, radius: float, width: float = math.inf, other: float = 0.0
    ) -> tuple[Array, Array]:
        """u and u' away from a line, the free surface on its left where the radius is negative."""
        x, side = (abs(radius) if math.isfinite(radius) else 0.0), (-1 if radius < 0 else 1)
        line = At(x, -u)
        beyond = At(x + side * width, -other) if math.isfinite(width) else None
        left, right = (line, beyond) if side > 0 else (beyond, line)
        found, slope = self.surfaces.shape(x + side * distance, left, right, 0.0)
        return found, side * slope
