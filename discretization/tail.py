"""What an equilibrium asks of the free surfaces that its discretisation found."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Tail(Protocol):
    """The free surface beyond a contact line at which the displacement is u_line.

    Between two contacts: at distances p from the left line
    and q from the right one, where the displacements are `left` and `right`.
    radius: of the line; infinite for a line contact, and negative where the free surface is on the
    side of the axis.
    """

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """u at these distances >= 0 from the line."""

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """u' outwards at the line, for several lines."""

    def between(
        self, p: Array, q: Array, width: float, left: float, right: float, radius: float = math.inf
    ) -> Array:
        """u in a gap of this width (n,); radius: of its left line."""

    def slope_between(
        self, width: Array, own: Array, other: Array, radius: Any = math.inf
    ) -> Array:
        """u' towards the other line, at lines with u = own (n,)."""


@dataclass(frozen=True, eq=False)
class FreeSurfaces:
    """All of an equilibrium: two tails, and the gaps between m contacts.

    lines, u, radii (m, 2): where contacts end, and the displacements and radii there.
    """

    tail: Tail
    lines: Array
    u: Array
    radii: Array

    def displacement(self, x: Array) -> Array:
        """u at positions outside the contacts."""
        found, part = np.empty_like(x), np.searchsorted(self.lines[:, 0], x)
        for i in np.unique(part).tolist():
            own = part == i
            found[own] = self._of_part(i, x[own])
        return found

    def _of_part(self, i: int, x: Array) -> Array:
        """Of the free surface to the left of contact i, or to the right of the last one."""
        if i == 0:
            return self.tail.displacement(self.lines[0, 0] - x, self.u[0, 0], self.radii[0, 0])
        left, radius, one = (float(each[i - 1, 1]) for each in (self.lines, self.radii, self.u))
        if i == len(self.lines):
            return self.tail.displacement(x - left, one, radius)
        right, other = float(self.lines[i, 0]), float(self.u[i, 0])
        return self.tail.between(x - left, right - x, right - left, one, other, radius)

    def slopes(self) -> Array:
        """u' outwards at the lines (m, 2)."""
        found = self.tail.slope(self.u, self.radii)
        if len(self.lines) > 1:
            width = self.lines[1:, 0] - self.lines[:-1, 1]
            (right, left), (r, s) = ((each[:-1, 1], each[1:, 0]) for each in (self.u, self.radii))
            found[:-1, 1] = self.tail.slope_between(width, right, left, r)
            found[1:, 0] = self.tail.slope_between(width, left, right, s)
        return found
