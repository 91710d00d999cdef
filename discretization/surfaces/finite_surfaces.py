"""Free surfaces with finite slopes.

D = f + u of the tail or of the gap (finite_gap.py) that is inclined by φ = β - 2 asin √(w/(2γ₁)) at
its line, tan β = f'. Of a tail p = 2 sin(φ/2) is its displacement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces import finite_gap
from discretization.surfaces.finite_gap import FiniteGap, solved, tail
from discretization.surfaces.finite_range import OVERHANG, UPRIGHT, rest_displacement
from discretization.surfaces.protocol import MET, At, Free, alone
from energy import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FiniteSurfaces:
    """Free surfaces of a scene."""

    scene: Scene

    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D: the inclination at rest is known, and the displacement that has it is solved for.

        Where a gap would turn over its inclination is cut at ±π/2; a tail is refused if its line is
        at rest there.
        """
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        phi = np.arctan(side * f1) - 2 * np.arcsin(np.sqrt(w / (2 * gamma1)))
        if facing is None:
            return f + 2 * length * np.sin(phi / 2)
        phi = np.maximum(phi, -math.pi / 2)
        apart, rise = np.maximum(side * (facing.x - x) / length, MET), (f - facing.f) / length
        return f + length * rest_displacement(-2 * np.sin(phi / 2), rise, apart)

    def _displaced(self, line: At, depth: Any) -> Any:
        """u₀ [l] of the lines of tails. ValueError if one would turn over."""
        u = (depth - line.f) / self.scene.elastocapillary_length
        if np.max(np.abs(u), initial=0.0) >= OVERHANG:
            raise ValueError(self._overhang(depth, line))
        return u

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """As the exponentials have it."""
        length = self.scene.elastocapillary_length
        if left is not None and right is not None:
            found = self._gap(left, right, depth)
            u, slope = found.at((z - left.x) / length, (right.x - z) / length)
            return length * u, slope
        line, side = (left, 1) if left is not None else (right, -1)
        if line is None:
            return np.zeros_like(z), np.zeros_like(z)
        limit, distance = OVERHANG * (1 - UPRIGHT), side * (z - line.x) / length
        found = tail(min(max((depth - line.f) / length, -limit), limit))
        u, slope = found.at(distance, np.maximum(found.length - distance, 0.0))
        return length * u, side * slope

    def _gap(self, left: At, right: At, depth: float) -> FiniteGap:
        """The surface between two lines, by its exponentials."""
        length = self.scene.elastocapillary_length
        rise = (left.f - right.f) / length
        return solved((depth - left.f) / length, rise, (right.x - left.x) / length)

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """F and S of tails and of gaps."""
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        if left is None or right is None:
            energy, pull = finite_gap.tails(self._displaced(alone(left, right), depth))
        else:
            u, rise = (depth - left.f) / length, (left.f - right.f) / length
            energy, pull = finite_gap.stored(u, rise, (right.x - left.x) / length)
        return gamma1 * length * energy, gamma1 * pull

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """One free surface."""
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        if left is None or right is None:
            line = alone(left, right)
            u0 = (depth - line.f) / length
            if abs(u0) >= OVERHANG * (1 - UPRIGHT):
                raise ValueError(self._overhang(depth, line))
            found = tail(u0)
            pull = gamma1 * found.reactions[0]
            pulls = (0.0, pull) if left is None else (pull, 0.0)
        else:
            found = self._gap(left, right, depth)
            if found.upright:
                raise ValueError(self._overhang(depth, left, right))
            one, other = found.reactions
            pulls = gamma1 * one, gamma1 * other
        return Free(gamma1 * length * found.energy, pulls, gamma1 * found.area, found.residual)

    def _overhang(self, depth: float, line: At, other: At | None = None) -> str:
        limit, place = OVERHANG * self.scene.elastocapillary_length, f"line x = {line.x!r}"
        if other is not None:
            place = f"lines x = {line.x!r} and {other.x!r}"
        return (
            f"depth = {depth!r}: {'between' if other else 'at'} the contact {place} the surface, "
            f"displaced by {depth - line.f!r}, would turn over and be no graph u(x), as it does at "
            f"√2 l = {limit!r} beside a single contact; use a smaller |depth|, a smaller w or a "
            "blunter indenter"
        )
