"""The spectral free surfaces of an equilibrium on the fitted mesh, in the scene's units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces import gap, menisci
from discretization.surfaces.axisymmetric import ring_surface
from discretization.surfaces.finite_gap import FiniteGap, solved
from discretization.surfaces.mesh import FreeSurface, linear
from discretization.surfaces.response import Response

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FittedTail:
    """Free surfaces beyond contact lines and between two of them."""

    length: float
    response: Response

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """The elements' polynomials, then the far field."""
        if not distance.size or not radius:  # a point without extent holds nothing
            return np.zeros_like(distance)
        surface = self._beyond(float(u_line) / self.length, radius / self.length)
        return self.length * surface.displacement(distance / self.length)

    def _beyond(self, u0: float, radius: float) -> FreeSurface:
        """The surface beyond a line, in units of l."""
        if math.isinf(radius):
            return self.response.surface(u0)
        if self.response.slopes == "finite":
            return menisci.surface(radius, u0)
        return linear(self.response.degree, radius).scaled(u0)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """Derivative of the first element's polynomial at the line."""
        u, radii = np.broadcast_arrays(u_line, radius)
        solved = [
            self._beyond(float(u) / self.length, float(r) / self.length).slope if r else 0.0
            for u, r in zip(u.ravel(), radii.ravel(), strict=True)
        ]
        return np.reshape(solved, np.shape(u_line))

    def between(
        self, p: Array, q: Array, width: float, left: float, right: float, radius: float = math.inf
    ) -> Array:
        """The elements' polynomials."""
        degree, at = self.response.degree, (p / self.length, q / self.length)
        if not radius:
            return self.displacement(q, right, -width)
        if math.isfinite(radius):
            ends = radius / self.length, (radius + width) / self.length
            return np.array([left, right]) @ ring_surface(degree, *ends).at(ends[0] + at[0])[0]
        if self.response.slopes == "finite":
            return self.length * self._finite(width, left, right).at(*at)[0]
        return gap.displacement(degree, *at, width / self.length, left, right)

    def slope_between(
        self, width: Array, own: Array, other: Array, radius: Any = math.inf
    ) -> Array:
        """Derivative of the first element's polynomial at each line."""
        if self.response.slopes == "finite":
            lines = zip(width.tolist(), own.tolist(), other.tolist(), strict=True)
            return np.array([self._finite(*each).slopes[0] for each in lines])
        if np.isfinite(radius).all():
            return self._between_rings(width, own, other, radius)
        degree, ends = self.response.degree, (width / self.length, own, other)
        found = [gap.slope(degree, *map(float, each)) for each in zip(*ends, strict=True)]
        return np.array(found) / self.length

    def _between_rings(self, width: Array, own: Array, other: Array, radius: Array) -> Array:
        """`slope_between` of rings: towards the outer line, or towards the inner one."""
        found = []
        for w, u, v, r in zip(
            *(part.tolist() for part in (width, own, other, radius)), strict=True
        ):
            ends = (r, r + w) if r > 0 else (-r - w, -r)
            if not ends[0]:
                found.append(float(self.slope(np.array(u), r)) * self.length if r else 0.0)
                continue
            slopes = ring_surface(self.response.degree, *(end / self.length for end in ends)).slopes
            found.append(slopes[0] @ (u, v) if r > 0 else slopes[1] @ (v, u))
        return np.array(found) / self.length

    def _finite(self, width: float, own: float, other: float) -> FiniteGap:
        """The relaxed surface of a gap with finite slopes."""
        length = self.length
        return solved(own / length, (other - own) / length, width / length).relaxed
