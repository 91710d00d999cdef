"""A scene with the exact response of its layer, in units of the thickness h and the stress G."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.layer.geometry import Axis, Geometry, Line, lowest
from discretization.layer.poles import Poles, poles
from energy import Scene

Array = NDArray[np.float64]
TIP = 1e-12  # half-width of a contact at the lowest point alone, in h
_NEAR = 1e-6  # places, in h, by which it is seen whether f' is a whole power beside 0
_SMOOTH = 1e-9  # by how much of a power it may differ


@dataclass(frozen=True, eq=False)
class Body:
    """A scene whose layer has its exact response, and the contacts it may have, by half-width."""

    scene: Scene

    @property
    def h(self) -> float:
        """Unit of lengths."""
        return self.scene.layer.h

    @property
    def unit(self) -> float:
        """Of forces: Gh per length of a line contact, Gh² about an axis; of energies h more."""
        return self.scene.layer.shear_modulus * self.h ** (2 if self.scene.axisymmetric else 1)

    @functools.cached_property
    def gamma(self) -> float:
        """Γ = γ₁/(Gh)."""
        return self.scene.gamma1 / (self.scene.layer.shear_modulus * self.h)

    def excess(self, scene: Scene) -> float:
        """√(2w/γ₁) of this scene or the one it is opened with."""
        return math.sqrt(2 * scene.work_of_adhesion / self.scene.gamma1)

    @functools.cached_property
    def geometry(self) -> Geometry:
        """Of its contact."""
        return Axis() if self.scene.axisymmetric else Line()

    @functools.cached_property
    def apex(self) -> float:
        """x of the lowest point, in units of the scene."""
        return lowest(self.scene)

    def height(self, x: Any) -> Any:
        """Of the profile, so far from its lowest point."""
        place = self.apex + np.asarray(x) * self.h
        return np.asarray(self.scene.indenter.height(place), float) / self.h

    def slope(self, x: Any, side: Any = 0) -> Any:
        """There, at a corner on this side of it."""
        place = self.apex + np.asarray(x) * self.h
        return np.asarray(self.scene.indenter.slope_beside(place, side), float)

    @functools.cached_property
    def kinks(self) -> list[float]:
        """Where the slope jumps, from the lowest point outwards."""
        return self._beyond(self.scene.indenter.corners)

    @functools.cached_property
    def breaks(self) -> list[float]:
        """Where any derivative jumps."""
        return sorted({*self.kinks, *self._beyond(self.scene.indenter.knots)} - {0.0})

    def _beyond(self, places: Any) -> list[float]:
        found = (np.asarray(places, float) - self.apex) / self.h
        return sorted(found[found >= 0].tolist())

    @functools.cached_property
    def rough(self) -> bool:
        """Whether the profile is not smooth on the way to 0 either, as a power of the distance."""
        near = self.slope(_NEAR * min(1.0, self.edge) * np.array([1.0, 2.0]))
        power = math.log2(near[1] / near[0]) if near[0] > 0 else 0.0
        return abs(power - round(power)) > _SMOOTH

    @functools.cached_property
    def touch(self) -> float:
        """Depth of first touch."""
        return float(self.height(0.0))

    @functools.cached_property
    def edge(self) -> float:
        """Where the profile ends."""
        return (self.scene.indenter.extent[1] - self.apex) / self.h

    @functools.cached_property
    def corners(self) -> list[float]:
        """Where a line may be held beside the lowest point, the edge of the body the last."""
        wall = self.scene.indenter.extent[1] in self.scene.indenter.walls
        return sorted({*self.kinks, *([self.edge] if wall else [])} - {0.0})

    def poles(self, tolerance: float) -> Poles:
        """Of the layer."""
        return poles(self.scene.layer.nu, self.gamma, tolerance)

    def rest_depth(self, a: Array, reaction: Array, excess: float, side: Any) -> Array:
        """D of half-widths (m,) with σ, s₀ (2, m); side: which slope of a corner counts.

        Beyond the edge of the body none; what touches with its lowest point alone lets go at first
        touch.
        """
        slope = self.slope(a, side)
        found = self.height(a) + (slope - reaction[1] - excess) / reaction[0]
        found = np.where((a <= TIP) & (side < 0), self.touch, found)
        return np.where((a >= self.edge) & (side > 0), math.inf, found)
