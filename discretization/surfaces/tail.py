"""The free surfaces of an equilibrium on the fitted mesh, as its observables ask for them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.protocol import At, Surfaces, Tail

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FittedTail:
    """Free surfaces beyond contact lines and between two of them, at depth 0 beside lines at -u."""

    surfaces: Surfaces

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """The elements' polynomials, then the far field."""
        if not distance.size or not radius:  # a point without extent holds nothing
            return np.zeros_like(distance)
        length = self.surfaces.scene.elastocapillary_length
        return length * self._beyond(u_line, radius).displacement(distance / length)

    def _beyond(self, u_line: float, radius: float) -> Tail:
        """The surface beyond a line, in units of l."""
        length = self.surfaces.scene.elastocapillary_length
        return self.surfaces.alone(float(radius) / length, float(u_line) / length)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """Derivative of the first element's polynomial at the line."""
        u, radii = np.broadcast_arrays(u_line, radius)
        solved = [
            self._beyond(each, r).slope if r else 0.0
            for each, r in zip(u.ravel(), radii.ravel(), strict=True)
        ]
        return np.reshape(solved, np.shape(u_line))

    def between(
        self, p: Array, q: Array, width: float, left: float, right: float, radius: float = math.inf
    ) -> Array:
        """The elements' polynomials."""
        start = radius if math.isfinite(radius) else 0.0
        z = start + np.where(p <= q, p, width - q)
        return self.surfaces.between(z, At(start, -left), At(start + width, -right), 0.0)[0]

    def slope_between(
        self, width: Array, own: Array, other: Array, radius: Any = math.inf
    ) -> Array:
        """Derivative of the first element's polynomial at each line."""
        parts = np.broadcast_arrays(width, own, other, radius)
        return np.array(
            [self._facing(*each) for each in zip(*map(np.ndarray.tolist, parts), strict=True)]
        )

    def _facing(self, width: float, own: float, other: float, radius: float) -> float:
        """u' towards another line: the outer one, or the inner one where the radius is negative."""
        if not radius:
            return 0.0
        x, side = abs(radius) if math.isfinite(radius) else 0.0, 1 if radius > 0 else -1
        mine, other_line = At(x, -own), At(x + side * width, -other)
        left, right = (mine, other_line) if side > 0 else (other_line, mine)
        return side * float(self.surfaces.between(np.array(x), left, right, 0.0)[1])
