"""Free surfaces of line contacts with finite slopes.

D = f + u of the tail or of the gap that is inclined by φ = β - 2 asin √(w/(2γ₁)) at its line,
tan β = f'. A gap stores

    F(u_a, u_b; L) = min over u, u(0) = u_a, u(L) = u_b, of ∫₀^L (k/2 u² + γ₁ (√(1+u'²) - 1)) dx,

and a tail is one that is flat far away, where 2 sin(φ/2) = u at the line: both are those of
finite_gap.py.

Conventions
-----------
Lengths are in l, forces in γ₁, energies in γ₁l, per length of the lines. u is positive downwards. A
surface extends from its first line, on `side`, to the other one at the distance `width` (infinite
for a tail), which is displaced by u + rise; line contacts are alike on both sides. φ and β are
inclinations outwards of the contact, positive upwards: -du/dx = tan φ at the first line, x the
distance from it. In finite_gap.py p = 2 sin(angle/2) of the angle with tan(angle) = +du/dx, so that
p = -2 sin(φ/2) at the first line. `surfaces(u, rise, width)` are n gaps or tails, parameters in
columns (n, 1), and `single` is one, kept: `Gaps` with `energy` (n,), ∫u dx as `area` (n,), `pulls`
(2, n), the reactions ∂F/∂u at the first and the other line, `residual`, the imbalance of forces at
the nodes of the first surface, over u and S, and `upright`, whether a surface turned over and was
cut where it is vertical.
`rest_displacement(p, rise, width)` is u of the first line. A `Shape` is u and du/dx (n,) each.
`DECAYED` = 40: e⁻⁴⁰ is less than rounding.
"""

import math
from typing import Any

import numpy as np

from discretization.certificate import DECAYED
from discretization.surfaces.finite_gap import rest_displacement, single, surfaces
from discretization.surfaces.network import Shape
from discretization.surfaces.protocol import Free, Surfaces
from energy.arrays import Array


class FiniteSurfaces(Surfaces):
    """Free surfaces of a line contact with finite slopes; its methods are those of `Surfaces`."""

    lost = "would turn over and be no graph u(x), as it does at √2 l beside one contact"

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, outward_slope: Any, w: Any) -> Any:
        """Displacement of a line at rest, found from its inclination φ, which is known.

        φ <= π/2. Where a gap would turn over, φ < -π/2, it counts as -π/2. A tail at rest there has
        no state: `solved` refuses it at this displacement.
        """
        phi = np.arctan(outward_slope) - 2 * np.arcsin(np.sqrt(w / 2))
        if np.ndim(width) == 0 and width == math.inf:
            return 2 * np.sin(phi / 2)
        p_towards_other = -2 * np.sin(np.maximum(phi, -math.pi / 2) / 2)
        return rest_displacement(p_towards_other, rise, width)

    def energy_and_reaction(
        self, side: int, s: Any, width: Any, u: Any, rise: Any
    ) -> tuple[Any, Any] | None:
        """F (n,) and ∂F/∂u (n,) at fixed rise; None if a tail would turn over.

        Gaps that would are cut where they are vertical, and have an energy.
        """
        columns = (np.reshape(part, (-1, 1)) for part in (u, rise, width))
        found = surfaces(*columns)
        if found.upright and np.isinf(width).all():
            return None
        return found.energy, found.pulls.sum(axis=0)

    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free | None:
        """One surface from the mesh; None if it, tail or gap, would turn over."""
        found = single(u, rise, width)
        if found.upright:
            return None
        first, other = found.pulls[:, 0].tolist()
        return Free(found.energy.item(), (first, other), found.area.item(), found.residual)

    def profile(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """u and du/dx at distances x (n,) from the first line, by the exponentials in τ."""
        end = DECAYED if math.isinf(width) else width  # of a tail: where it is flat
        return single(u, rise, width).at(x, np.maximum(end - x, 0.0))
