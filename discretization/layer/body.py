"""The profile of a scene with an exact layer, by the distance from its lowest point.

The only contact of such a scene is mirror-symmetric about the lowest point of the profile, or lies
around the axis. So one number describes it: its half-width or radius a, measured from there.

Heights f are positive upwards, depths d and displacements u = d - f downwards; distances x from the
lowest point are >= 0, and positions those of the scene. A side is 1 for what is further out, -1 for
what is further in.
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
        for, and far above the rounding of positions, 2e-16 h.
    local : float
        Distance over h at which the power of f' beside the lowest point is read: higher powers of
        the profile change it by 1e-6 or less there.
    integer_power : float
        By how much a power that is read there may differ from an integer: sharper than any profile
        with a power of its own, such as 2.001, and blunter than rounding.
    """

    point_contact: float = 1e-12
    local: float = 1e-6
    integer_power: float = 1e-9


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
        Distances at which the slope jumps, or is no integer power of the distance (at 0 alone).
    breaks : list of float
        Distances > 0 at which the slope or any derivative of it jumps.
    corners : list of float
        Distances > 0 at which a line may be pinned; the edge of a body is the last of them.
    """

    def __init__(self, scene: Scene) -> None:
        h = scene.layer.h
        indenter = scene.indenter
        self.scene = scene
        self.power = int(scene.axisymmetric)
        self.symmetry_factor = 2 * math.pi if self.power else 2.0
        self.apex = 0.0 if self.power else scene.mirror or 0.0
        self.tip = _RULES.point_contact * h
        self.touch = float(self.height(0.0))

        self.edge = float(indenter.extent[1]) - self.apex
        self.walled = indenter.extent[1] in indenter.walls
        if math.isfinite(self.edge) and np.isinf(indenter.slope(indenter.extent[1])):
            self.edge *= BEFORE_VERTICAL

        kinks = set(self._distances(indenter.corners))
        if not self._has_integer_power(min(_RULES.local * h, self.edge / 4)):
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
        """Whether f' grows as an integer power of the distance between x and 2x [length].

        It is if the profile is flat there.
        """
        slope = self.slope(x * np.array([1.0, 2.0]))
        if slope[0] <= 0:
            return True
        power = math.log2(slope[1] / slope[0])
        return abs(power - round(power)) <= _RULES.integer_power

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
        """Work of adhesion times the contact area.

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

        A line at the edge of the profile does not advance, whatever the depth: D is infinite. A
        contact with the lowest point alone opens at the depth of first touch.

        Parameters
        ----------
        a : float or ndarray (m,)
            Half-widths [length].
        reaction : ndarray (2, ...)
            σ [1/length] and s₀ of the line; see `Contact`.
        excess : float
            √(2w/γ₁), by which the slopes of indenter and free surface differ at the line.
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
