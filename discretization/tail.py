"""What an equilibrium asks of the free surfaces that its discretisation found."""

from __future__ import annotations

import math
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
