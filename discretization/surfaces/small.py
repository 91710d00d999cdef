"""Free surfaces with small slopes, of line contacts and about an axis.

Everything is linear in the depth. In units of l, with the networks (σ, τ) of network.py, m(s) the
length of a line (1, or its radius over 2π) and σ = m S of a surface without another line,

    D = f + m (f' - √(2w/γ₁))/σ,     D = f + [m (f' - √(2w/γ₁)) - τ (f_other - f)]/σ.

The square in ∂U/∂x = m (γ₁/2 r² - w) is left because on the mesh, to rounding,

    ∂E/∂s = ±m (S² - u²)/2

where a line at s moves away from its contact, S its reaction per length: `_imbalance` checks that.
"""

import functools
import math
from typing import Any

import numpy as np

from discretization.surfaces.network import Line, Network, Shape
from discretization.surfaces.protocol import ANY, NARROWEST, Free, Surfaces
from discretization.surfaces.rings import AXIS_RADIUS, Axis
from energy.arrays import Array

# Step along the imaginary axis over the width of an element: the error of Im E(s + ih)/h is h².
_IMAGINARY_STEP = 1e-30
# Line contacts on elements of the least degree whose errors are rounding.
_NETS: dict[str, Line | Axis] = {"line": Line(10), "axisymmetric": Axis()}


class SmallSurfaces(Surfaces):
    """Free surfaces of a scene with small slopes."""

    @property
    def net(self) -> Line | Axis:
        """The networks of its geometry."""
        return _NETS[self.scene.geometry]

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, outward_slope: Any, w: Any) -> Any:
        """Displacement of a line at rest, [m (f' - √(2w)) + τ rise]/σ.

        A line at the axis, where m = 0, rests as just beside it if it does not adhere as it is
        touched. A contact around the axis has no line there: it rests at any depth.
        """
        if not self.scene.axisymmetric:
            network = self.net.between(side, s, width)
            return (outward_slope - np.sqrt(2 * w) + network.tie * rise) / network.left
        radius = s
        near_axis = (s.min() if isinstance(s, np.ndarray) else s) < AXIS_RADIUS
        if near_axis:  # differences may even look beyond the axis
            resolved = np.isinf(width) & np.greater(s, 0)
            radius = np.where(resolved, s, np.maximum(s, AXIS_RADIUS))[()]
        network = self.net.between(side, radius, width)
        u = (radius * (outward_slope - np.sqrt(2 * w)) + network.tie * rise) / network.left
        if not near_axis or np.isfinite(width).all():
            return u
        at_axis = np.where(np.greater(side, 0), np.minimum(u, 0.0), ANY)
        return np.where(np.less_equal(s, 0), at_axis, u)[()]

    def energy_and_reaction(
        self, side: int, s: Any, width: Any, u: Any, rise: Any
    ) -> tuple[Any, Any]:
        """Those of the networks."""
        network = self.net.between(side, s, np.maximum(width, NARROWEST))
        v = u + rise
        return network.energy(u, v, -rise), network.left * u + network.right * v

    @functools.lru_cache(maxsize=64)  # noqa: B019
    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free:
        """As all nodes are balanced, k∫u over the surface is what its lines pull."""
        network = self.net.between(side, s, max(width, NARROWEST))
        v = u + rise
        first, other = map(float, network.pulls(u, v, -rise))
        imbalance = self._imbalance(side, s, width, u, -rise, first)
        if width < math.inf:
            at_other = self._imbalance(-side, s + width, width, v, rise, other)
            imbalance = max(imbalance, at_other)
        energy = float(network.energy(u, v, -rise))
        return Free(energy, (first, other), first + other, imbalance)

    def profile(self, x: Array, *lines: Any) -> Shape:
        """That of the networks."""
        return self.net.shape(x, *lines)

    def _imbalance(
        self, side: int, s: float, width: float, u: float, difference: float, pull: float
    ) -> float:
        """How far ∂E/∂s at a line is from what is said above, over its terms.

        As the surface is balanced inside, E changes as the part beside the line alone does when the
        line moves and the surface is fixed at the end of the part: what is stored further away,
        many times as much beside a small contact, would only round. E is a rational function of s,
        and Im E(s + ih)/h has no difference to lose digits in (W. Squire, G. Trapp, SIAM Review 40
        (1998) 110).

        difference: of the displacements of this line and the other one; pull: m S.
        """
        axisymmetric = self.scene.axisymmetric
        m = s if axisymmetric else 1.0
        if not m or not width:
            return 0.0
        part = min(width, s if axisymmetric else 1.0, 1.0) / 4  # one element
        middle = s + side * part
        h = _IMAGINARY_STEP * part
        moved = self.net.between(side, complex(s, -side * h), complex(part, h))
        own = Network(*np.real(moved))
        rest = self.net.between(side, middle, width - part)
        between = own.right + rest.left
        fall = (between * u + rest.tie * difference) / (own.tie + between + rest.tie)
        rate = moved.energy(u, u - fall, fall).imag / h
        reaction = pull / m
        expected = m * (u * u - reaction * reaction) / 2
        size = m * (u * u + reaction * reaction) or 1.0
        return float(abs(rate - expected) / size)
