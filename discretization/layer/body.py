"""A scene with the exact response of its layer: the contacts that it may have, by half-width.

A half-width or radius a is measured from the lowest point of a mirrored profile, or the axis.
"""

import math
from typing import Any

import numpy as np

from discretization.profile import BEFORE_VERTICAL
from energy import Scene
from energy.arrays import Array

_TIP = 1e-12  # of h: half-width of a contact at the lowest point alone
_NEAR = 1e-6  # of h: places by which it is seen whether f' is a whole power beside 0
_SMOOTH = 1e-9  # by how much of a power it may differ


class Body:
    """The profile of a scene by distances from its lowest point, and where a line may be held.

    power: of x in the measure m of integrals over 0 <= x, which count `whole` times; apex: x of the
    lowest point, touch: depth of first touch there, tip: half-width of a contact with it alone;
    edge: where the profile ends, walled: whether the body does, too; kinks: where the slope jumps,
    or is no whole power of the distance from the lowest point; breaks: where any derivative jumps;
    corners: where a line may be held beside the lowest point, the edge of a body the last.
    """

    def __init__(self, scene: Scene) -> None:
        h, indenter = scene.layer.h, scene.indenter
        self.scene, self.power, self.tip = scene, int(scene.axisymmetric), _TIP * h
        self.whole = 2 * math.pi if self.power else 2.0
        self.apex = 0.0 if self.power else scene.mirror or 0.0
        self.touch = float(self.height(0.0))
        self.edge = float(indenter.extent[1]) - self.apex
        if math.isfinite(self.edge) and np.isinf(indenter.slope(indenter.extent[1])):
            self.edge *= BEFORE_VERTICAL
        self.walled = indenter.extent[1] in indenter.walls
        near = self.slope(min(_NEAR * h, self.edge / 4) * np.array([1.0, 2.0]))
        power = math.log2(near[1] / near[0]) if near[0] > 0 else 0.0
        rough = [0.0] if abs(power - round(power)) > _SMOOTH else []
        self.kinks = sorted({*self._beyond(indenter.corners), *rough})
        self.breaks = sorted({*self.kinks, *self._beyond(indenter.knots)} - {0.0})
        self.corners = sorted({*self.kinks, *([self.edge] if self.walled else [])} - {0.0})

    def _beyond(self, places: Any) -> list[float]:
        found = np.asarray(places, float) - self.apex
        found[np.abs(found) <= self.tip] = 0.0
        return list(found[found >= 0].tolist())

    def area(self, a: Any) -> Any:
        """In contact."""
        return math.pi * a * a if self.power else 2 * a

    def bound(self, a: Any) -> Any:
        """Energy that adheres."""
        return self.scene.work_of_adhesion * self.area(a)

    def height(self, x: Any) -> Any:
        """Of the profile, so far from its lowest point."""
        return np.asarray(self.scene.indenter.height(self.apex + np.asarray(x)), float)

    def slope(self, x: Any, side: Any = 0) -> Any:
        """There, at a corner on this side of it."""
        place = self.apex + np.asarray(x)
        return np.asarray(self.scene.indenter.slope_beside(place, side), float)

    def ends(self, a: float) -> tuple[float, float]:
        """x of both ends of a contact; about an axis one of them is that."""
        a = 0.0 if a <= self.tip else a
        return (0.0 if self.power else self.apex - a), self.apex + a

    def rest_depth(self, a: Any, reaction: Array, excess: float, side: Any) -> Any:
        """D of half-widths (m,), or one, with σ, s₀ (2, m); side: which slope of a corner counts.

        Beyond the edge of the body none; what touches with one point alone lets go at first touch.
        """
        found = self.height(a) + (self.slope(a, side) - reaction[1] - excess) / reaction[0]
        found = np.where((a <= self.tip) & (side < 0), self.touch, found)
        return np.where((a >= self.edge) & (side > 0), math.inf, found)
