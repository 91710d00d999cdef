"""The depth at which a contact line on the fitted mesh is in equilibrium where it is.

The energy of the mesh changes by dU/dq = γ₁/2 r² - w as a line moves (../fitted/lines.py). With
small slopes its r = f' - S/γ₁ is linear in the depth, so that dU/dq = 0 is solved for it: in units
of l, with the response s of a tail, and B, A, t = (f_other - f_own)/2 of a gap (../fitted/gap.py),

    D = f + (f' - √(2w/γ₁))/s,          D = (f_own + f_other)/2 + (f' - √(2w/γ₁) - t A)/B,

f' outwards of the contact. A line advances while D < d and recedes while D > d: a maximum of D on
the way out, or a minimum on the way in, is where it jumps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from discretization.fitted import gap
from discretization.fitted.response import Response
from energy import Scene


@dataclass(frozen=True, eq=False)
class Levels:
    """D of lines; the indenter's slope is read `aside` [length] of the line."""

    scene: Scene
    response: Response

    @property
    def kink(self) -> float:
        """√(2w/γ₁), the r at which dU/dq = 0."""
        return math.sqrt(2 * self.scene.work_of_adhesion / self.scene.gamma1)

    def _excess(self, side: int, x: float, aside: float) -> float:
        """f' - √(2w/γ₁), outwards on this side of a contact."""
        return side * float(self.scene.indenter.slope(x + aside)) - self.kink

    def tail(self, side: int, x: float, aside: float) -> float:
        """D of an outermost line."""
        length = self.scene.elastocapillary_length
        rise = length * self._excess(side, x, aside) / self.response.reaction(1.0)
        return float(self.scene.indenter.height(x)) + rise

    def facing(self, side: int, x: float, other: float, aside: float) -> float:
        """D of a line that faces another contact's line at `other`."""
        scene, length = self.scene, self.scene.elastocapillary_length
        found = gap.half(self.response.degree, abs(other - x) / length)
        own, far = float(scene.indenter.height(x)), float(scene.indenter.height(other))
        pull = (far - own) / 2 * found.odd
        return (own + far) / 2 + (length * self._excess(side, x, aside) - pull) / found.even
