"""Free surfaces with small slopes, of line contacts and about an axis.

Everything is linear in the depth. In units of l, with m(s) the length of a line (1, or about an
axis, where all counts per radian, its radius s), a line displaced by u is at rest beside a free
surface that pulls at it by m S = m (f' - √(2w/γ₁)) (protocol.py). What it pulls is

    m S = σ u                       of a tail, a surface without another line,
    m S = σ u + τ (u - u_other)     of a gap between two lines,

so that D = f + u, where the line rests, is

    D = f + m (f' - √(2w/γ₁))/σ,     D = f + [m (f' - √(2w/γ₁)) - τ (f_other - f)]/σ.

The square in ∂U/∂x = m (γ₁/2 r² - w) is left because on the mesh, to rounding,

    ∂E/∂s = side m (S² - u²)/2       at fixed u

for a line at s that moves towards larger s: `_imbalance` checks that.

Conventions
-----------
Lengths are in l and forces in γ₁; u is positive downwards. `side` is 1 if the surface extends from
its first line, at s, to the right (outwards about an axis), -1 if to the left; the other line is at
a distance `width`, infinite if there is none, and displaced by u + rise. f' is the slope of the
indenter outwards of its contact. A `Network` holds σ of the first line as `left`, τ as `tie`, and σ
of the other line as `right`; its E = [left u² + right u_other² + tie (u - u_other)²]/2 is `energy`
and ∂E/∂u, ∂E/∂u_other are its `pulls`, both from u, u_other and u - u_other. `Line(degree)` and
`Axis()` make them from (side, s, width); their `shape` is u and du/dx at places, a `Shape`.

Of protocol.py, `ANY` stands for the displacement of a line that rests at any depth, `NARROWEST` is
the least width of a gap, and `Surfaces` turns what is defined here into units of the scene; a
`Free` surface has its energy, pulls, ∫u and mismatch. `AXIS_RADIUS` = 2⁻⁴⁰ l is the radius that a
line at the axis is given. `axisymmetric` means rotational symmetry.
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
# By `Scene.geometry`. Elements of line contacts are of the least degree whose errors are rounding.
_NETS: dict[str, Line | Axis] = {"line": Line(10), "axisymmetric": Axis()}


class SmallSurfaces(Surfaces):
    """Free surfaces of a scene with small slopes."""

    @property
    def net(self) -> Line | Axis:
        """What gives the networks of its geometry."""
        return _NETS[self.scene.geometry]

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, outward_slope: Any, w: Any) -> Any:
        """Displacement of a line at rest, [m (f' - √(2w)) + τ rise]/σ, with rise = u_other - u.

        A contact that is a point at the axis has the u of one just beside it, or 0, at which it is
        touched, if that is less. A line at the axis whose surface were inside it is none: it rests
        at any depth.
        """
        if not self.scene.axisymmetric:
            network = self.net.between(side, s, width)
            return (outward_slope - np.sqrt(2 * w) + network.tie * rise) / network.left
        radius = s
        near_axis = (s.min() if isinstance(s, np.ndarray) else s) < AXIS_RADIUS
        if near_axis:  # or beyond it, s < 0, where differences of D by s may look
            resolved = np.isinf(width) & np.greater(s, 0)  # `stiffness` knows these radii, too
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
        """F = E and ∂E/∂u at fixed rise, of the networks; u and u + rise displace the lines.

        In the sum of both reactions what the tie takes cancels.
        """
        network = self.net.between(side, s, np.maximum(width, NARROWEST))
        v = u + rise
        return network.energy(u, v, -rise), network.left * u + network.right * v

    # The certificate, the energy and the force of a state read the same surfaces, a few of them or,
    # between many contacts, dozens; five numbers each.
    @functools.lru_cache(maxsize=64)  # noqa: B019
    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free:
        """One surface; as all its nodes are balanced, k∫u over it is the sum of both pulls."""
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
        """u and du/dx at distances x (n,) from the first line; lines: side, s, width, u, rise."""
        return self.net.shape(x, *lines)

    def _imbalance(
        self, side: int, s: float, width: float, u: float, difference: float, pull: float
    ) -> float:
        """How far ∂E/∂s at a line is from what the head of this module says, over its terms.

        As the surface is balanced inside, E changes as the part beside the line alone does when the
        line moves and the surface is fixed at the end of the part: what is stored further away,
        many times as much beside a small contact, would only round. E is a rational function of s,
        and Im E(s + ih)/h has no difference to lose digits in (W. Squire, G. Trapp, SIAM Review 40
        (1998) 110).

        Parameters
        ----------
        side, s, width, u
            Of this line, which is taken for the first one.
        difference : float
            u - u_other.
        pull : float
            m S at this line.

        Returns
        -------
        float
            Dimensionless; 0 at the axis, where there is no surface on the side of the axis.
        """
        axisymmetric = self.scene.axisymmetric
        m = s if axisymmetric else 1.0
        if not m or not width:
            return 0.0
        part = min(width, s if axisymmetric else 1.0, 1.0) / 4  # one element
        middle = s + side * part
        h = _IMAGINARY_STEP * part
        # The line moves by h towards its contact, and the part becomes longer by h.
        moved = self.net.between(side, complex(s, -side * h), complex(part, h))
        own = Network(*np.real(moved))
        rest = self.net.between(side, middle, width - part)
        ground_of_middle = own.right + rest.left
        # u at the line less u in the middle, where forces are in balance.
        fall = ground_of_middle * u + rest.tie * difference
        fall = fall / (own.tie + ground_of_middle + rest.tie)
        rate = moved.energy(u, u - fall, fall).imag / h
        reaction = pull / m
        expected = m * (u * u - reaction * reaction) / 2
        size = m * (u * u + reaction * reaction) or 1.0
        return float(abs(rate - expected) / size)
