"""The profile of a scene with an exact layer, by the distance from its lowest point.

The only contact of such a scene is mirror-symmetric about the lowest point of the profile, or lies
around the axis. So one number describes it: its half-width or radius a, measured from there.

Conventions
-----------
Heights f are positive upwards, depths d and displacements u = d - f downwards; distances x from the
lowest point are >= 0, and positions those of the scene. A side is 1 for what is further out, -1 for
what is further in. h is the thickness of the layer (`layer.h`), w its work of adhesion
(`work_of_adhesion`), and `axisymmetric` means that the profile is turned about the axis at 0.

`mirror` of a scene is the position about which its profile is its own mirror image, None if none is
known; a convex profile is lowest there. Of an indenter, `extent` is where its profile is known, low
and high end; `walls` are those of these ends at which the body itself ends; `corners` and `knots`
are the positions at which f' and a higher derivative jump. `slope_beside(x, side)` is f' read a few
roundings beside x, on that side of it. `BEFORE_VERTICAL` = 1 - 2⁻²⁰ is the part of a profile that
is used where it ends vertically, like a circle: its slope is finite there.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from discretization.profile import BEFORE_VERTICAL
from energy import Scene
from energy.arrays import Array


class ProfileRules(NamedTuple):
    """How a profile is read beside its lowest point.

    At a tenth or ten times its value each leaves 5 random states, branches and paths as they are to
    1e-9: `python -m tests.sensitivity discretization.layer.body`.

    Attributes
    ----------
    point_contact : float
        Half-width over h of a contact with the lowest point alone: far below any that is looked
        for, and far above the rounding of positions, 2e-16 of their size.
    local : float
        Distance at which the power of f' beside the lowest point is read, over h or the extent of
        the profile, whichever is less. A further term of f' that is relatively b x/h changes the
        power that is read there by b 1e-6/ln 2.
    integer_power : float
        By how much a power that is read there may differ from an integer. It leaves room for
        further terms of up to b = 7, and for the rounding of positions 1e5 h away from 0. Without
        the elements that a power n + ε needs, σ, force and energy are wrong by 6e-8 ε (n = 1), for
        this ε by 6e-13.
    """

    point_contact: float = 1e-12
    local: float = 1e-6
    integer_power: float = 1e-5


_RULES = ProfileRules()


class Body:
    """Profile of a scene by the distance x from its lowest point, and where its line may be pinned.

    Parameters
    ----------
    scene : Scene
        Its indenter is convex, and mirror-symmetric or turned about an axis.

    Attributes
    ----------
    power : {0, 1}
        Of x in the measure dm = x**power dx of integrals over x >= 0.
    symmetry_factor : float
        What such integrals are multiplied by: 2 for both sides, or 2π for all around.
    apex : float
        Position of the lowest point [length].
    touch : float
        Depth at which it touches first [length].
    tip : float
        Half-width of a contact with the lowest point alone [length].
    edge : float
        Distance at which the known profile ends [length], or infinity.
    walled : bool
        Whether the body itself ends there.
    kinks : list of float
        Distances at which the slope jumps, or (at 0 alone) is no integer power of the distance.
        Elements are graded towards them (`elements.grid`).
    breaks : list of float
        Distances > 0 at which the slope or any derivative of it jumps.
    corners : list of float
        Distances > 0 at which a line may be pinned; the edge of a body is the last of them.
    """

    def __init__(self, scene: Scene) -> None:
        """Find the lowest point, and the distances at which a line or an element has to end."""
        h = scene.layer.h
        indenter = scene.indenter
        self.scene = scene
        self.power = int(scene.axisymmetric)
        self.symmetry_factor = 2 * math.pi if self.power else 2.0
        # Line contacts without a mirror image are refused before (routes.py): their lowest point is
        # not needed.
        self.apex = 0.0 if self.power else scene.mirror or 0.0
        self.tip = _RULES.point_contact * h
        self.touch = float(self.height(0.0))

        self.edge = float(indenter.extent[1]) - self.apex
        self.walled = indenter.extent[1] in indenter.walls
        if math.isfinite(self.edge) and np.isinf(indenter.slope(indenter.extent[1])):
            self.edge *= BEFORE_VERTICAL

        kinks = set(self._distances(indenter.corners))
        if not self._has_integer_power(_RULES.local * min(h, self.edge)):
            kinks.add(0.0)
        self.kinks = sorted(kinks)
        self.breaks = sorted({*self.kinks, *self._distances(indenter.knots)} - {0.0})
        edges = [self.edge] if self.walled else []
        self.corners = sorted({*self.kinks, *edges} - {0.0})

    def _distances(self, positions: ArrayLike) -> list[float]:
        """The distances of those positions that are not on the left of the lowest point.

        What is within `tip` of that is at it, 0.
        """
        distances = np.asarray(positions, float) - self.apex
        distances[np.abs(distances) <= self.tip] = 0.0
        return list(distances[distances >= 0].tolist())

    def _has_integer_power(self, x: float) -> bool:
        """Whether f' grows from x to 2x [length] as an integer power of the distance, 1 or more.

        Polynomials of x resolve it then, as they do where the profile is flat, f' = 0. A slope that
        is the same at both has the power 0: beside the lowest point it jumps from - to +.
        """
        slope = self.slope(x * np.array([1.0, 2.0]))
        if slope[0] <= 0:
            return True
        power = math.log2(slope[1] / slope[0])
        integer = round(power)
        return integer >= 1 and abs(power - integer) <= _RULES.integer_power

    def area(self, a: Any) -> Any:
        """Contact area: 2a per length of a line contact, or πa².

        Parameters
        ----------
        a : float or ndarray
            Half-width or radius [length].

        Returns
        -------
        float or ndarray
            [length], or [area].
        """
        return math.pi * a * a if self.power else 2 * a

    def bound(self, a: Any) -> Any:
        """Energy w·area by which the work of adhesion w binds a contact.

        Parameters
        ----------
        a : float or ndarray
            Half-width or radius [length].

        Returns
        -------
        float or ndarray
            [energy/length], or [energy].
        """
        return self.scene.work_of_adhesion * self.area(a)

    def height(self, x: Any) -> Any:
        """Height f of the profile.

        Parameters
        ----------
        x : float or ndarray
            Distances from the lowest point [length].

        Returns
        -------
        ndarray
            [length].
        """
        return np.asarray(self.scene.indenter.height(self.apex + np.asarray(x)), float)

    def slope(self, x: Any, side: Any = 0) -> Any:
        """Slope f' of the profile, by x outwards.

        Parameters
        ----------
        x : float or ndarray
            Distances from the lowest point [length].
        side : {0, 1, -1}, or ndarray
            1 for the slope just outside x, -1 for that just inside, which differ at corners; 0 for
            that at x itself.

        Returns
        -------
        ndarray
        """
        position = self.apex + np.asarray(x)
        return np.asarray(self.scene.indenter.slope_beside(position, side), float)

    def ends(self, a: float) -> tuple[float, float]:
        """Positions of both ends of a contact; about the axis the first one is the axis.

        Parameters
        ----------
        a : float
            Half-width or radius [length].

        Returns
        -------
        tuple of float
            [length].
        """
        a = 0.0 if a <= self.tip else a
        return (0.0 if self.power else self.apex - a), self.apex + a

    def rest_depth(self, a: Any, reaction: Array, excess: float, side: Any) -> Any:
        """Depth at which a line rests, D = f(a) + (f'(a) - s₀ - √(2w/γ₁))/σ.

        All that is free or pressed beside the line reacts with γ₁ (σ (d - f(a)) + s₀) per length,
        s₀ being the part of the profile (contact.py); the line rests where f'(a) exceeds this over
        γ₁ by √(2w/γ₁). It advances at depths above D and recedes below.

        A line at the edge of the profile does not advance, whatever the depth: D is infinite. A
        contact with the lowest point alone has no area that adheres: it opens where it is not
        pressed any more, at the depth of first touch, with the surface undeformed.

        Parameters
        ----------
        a : float or ndarray (m,)
            Half-widths [length].
        reaction : ndarray (2, ...)
            σ [1/length] and s₀ of the line; see `Contact`.
        excess : float
            √(2w/γ₁), with the work of adhesion of the event that is looked for: that of closing, or
            of opening.
        side : {1, -1}, or ndarray (m,)
            Which slope of a corner counts: that of a line that advances (1), or recedes (-1).

        Returns
        -------
        ndarray () or (m,)
            [length].
        """
        stiffness = reaction[0]
        offset = reaction[1]
        depth = self.height(a) + (self.slope(a, side) - offset - excess) / stiffness
        depth = np.where((a <= self.tip) & (side < 0), self.touch, depth)
        return np.where((a >= self.edge) & (side > 0), math.inf, depth)
