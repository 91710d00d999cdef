"""Free surfaces of line contacts with finite slopes.

D = f + u of the tail or of the gap that is inclined by φ = β - 2 asin √(w/(2γ₁)) at its line,
tan β = f'. A gap stores

    F(u_a, u_b; L) = min over u, u(0) = u_a, u(L) = u_b, of ∫₀^L (k/2 u² + γ₁ (√(1+u'²) - 1)) dx,

and a tail is one that is flat far away, p = 2 sin(φ/2) = -u: both are those of finite_gap.py.
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
    """Free surfaces of a scene with finite slopes."""

    lost = "would turn over and be no graph u(x), as it does at √2 l beside one contact"

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, outward_slope: Any, w: Any) -> Any:
        """Displacement of a line at rest, found from its inclination, which is known.

        Where a gap would turn over its inclination is cut at ±π/2; a tail at rest there has no
        state.
        """
        phi = np.arctan(outward_slope) - 2 * np.arcsin(np.sqrt(w / 2))
        if np.ndim(width) == 0 and width == math.inf:
            return 2 * np.sin(phi / 2)
        outward_p = -2 * np.sin(np.maximum(phi, -math.pi / 2) / 2)
        return rest_displacement(outward_p, rise, width)

    def energy_and_reaction(
        self, side: int, s: Any, width: Any, u: Any, rise: Any
    ) -> tuple[Any, Any] | None:
        """Those of the mesh."""
        columns = (np.reshape(part, (-1, 1)) for part in (u, rise, width))
        found = surfaces(*columns)
        if found.upright and np.isinf(width).all():
            return None
        return found.energy, found.pulls.sum(axis=0)

    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free | None:
        """One surface from the mesh."""
        found = single(u, rise, width)
        if found.upright:
            return None
        first, other = found.pulls[:, 0].tolist()
        return Free(found.energy.item(), (first, other), found.area.item(), found.residual)

    def profile(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """That of the exponentials."""
        end = DECAYED if math.isinf(width) else width
        return single(u, rise, width).at(x, np.maximum(end - x, 0.0))
