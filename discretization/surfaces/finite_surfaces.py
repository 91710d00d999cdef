"""Free surfaces with finite slopes.

D = f + u of the tail or of the gap (finite_gap.py) that is inclined by φ = β - 2 asin √(w/(2γ₁)) at
its line, tan β = f'.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces import finite_gap
from discretization.surfaces.finite_gap import FiniteGap, solved
from discretization.surfaces.finite_range import UPRIGHT, rest_displacement
from discretization.surfaces.mesh import OVERHANG, FreeSurface
from discretization.surfaces.protocol import MET, At, Free, alone
from discretization.surfaces.response import STEEP, Response
from energy import Scene

Array = NDArray[np.float64]
_NEWTON = 3  # steps from a table good to 1e-3: two reach rounding


@dataclass(frozen=True, eq=False)
class FiniteSurfaces:
    """Free surfaces of a scene, with the elements of a response."""

    scene: Scene
    response: Response

    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D: the inclination at rest is known, and the displacement that has it is solved for.

        Where a gap would turn over its inclination is cut at ±π/2.
        """
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        deficit = 2 * np.arcsin(np.sqrt(w / (2 * gamma1)))
        phi = np.arctan(side * f1) - deficit
        if facing is None:
            return f + length * self._displaced(phi)
        phi = np.maximum(phi, -math.pi / 2)
        apart, rise = np.maximum(side * (facing.x - x) / length, MET), (f - facing.f) / length
        return f + length * rest_displacement(-2 * np.sin(phi / 2), rise, apart)

    def _displaced(self, phi: Any) -> Any:
        """u₀ with S(u₀) = sin φ and 1 - u₀²/2 = cos φ on the mesh, by Newton's method."""
        limit = OVERHANG * (1 - UPRIGHT)
        upright = 2 * np.sin(phi / 2)  # beyond the limit refused if a line is at rest there
        u = np.clip(upright, -limit, limit)
        for _ in range(_NEWTON):
            pull, cos = self._reaction(u), 1 - u * u / 2
            u = u - (np.arctan2(pull, cos) - phi) * np.sqrt(np.maximum(1 - u * u / 4, 0.25))
            u = np.clip(u, -limit, limit)
        return np.where(np.abs(upright) < limit, u, upright)[()]

    def _reaction(self, u: Any) -> Any:
        if not np.ndim(u):
            return self.response.reaction(float(u))
        mild = np.abs(u) <= STEEP
        pull = np.empty_like(u)
        pull[mild] = self.response.reaction(u[mild])
        pull[~mild] = [self.response.reaction(one) for one in u[~mild].tolist()]
        return pull

    def pull(self, side: int, line: At, depth: float) -> float:
        """S of a tail."""
        u = (depth - line.f) / self.scene.elastocapillary_length
        return float(self.scene.gamma1 * self.response.reaction(u))

    def alone(self, radius: float, u0: float) -> FreeSurface:
        """One of the family of all tails."""
        return self.response.surface(u0)

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """The gap's, or the tail's polynomials with the slope its first integral gives them."""
        length = self.scene.elastocapillary_length
        if left is not None and right is not None:
            found = self._gap(left, right, depth)
            u, slope = found.at((z - left.x) / length, (right.x - z) / length)
            return length * u, slope
        line, side = (left, 1) if left is not None else (right, -1)
        if line is None:
            return np.zeros_like(z), np.zeros_like(z)
        limit = OVERHANG * (1 - UPRIGHT)
        u0 = min(max((depth - line.f) / length, -limit), limit)
        u = self.response.surface(u0).displacement(side * (z - line.x) / length)
        slope = -side * u * np.sqrt(1 - u * u / 4) / np.maximum(1 - u * u / 2, 1e-9)
        return length * u, slope

    def between(self, z: Array, left: At, right: At, depth: float) -> tuple[Array, Array]:
        """Of the relaxed surface."""
        length, found = self.scene.elastocapillary_length, self._gap(left, right, depth).relaxed
        u, slope = found.at((z - left.x) / length, (right.x - z) / length)
        return length * u, slope

    def _gap(self, left: At, right: At, depth: float) -> FiniteGap:
        """The surface between two lines, by its exponentials."""
        length = self.scene.elastocapillary_length
        rise = (left.f - right.f) / length
        return solved((depth - left.f) / length, rise, (right.x - left.x) / length)

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """F and S of tails and of gaps."""
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        if left is None or right is None:
            u = (depth - alone(left, right).f) / length
            energy = np.array([self.response.energy(one) for one in u.tolist()])
            pull = self._reaction(u)
        else:
            u, rise = (depth - left.f) / length, (left.f - right.f) / length
            energy, pull = finite_gap.stored(u, rise, (right.x - left.x) / length)
        return gamma1 * length * energy, gamma1 * pull

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """A tail of the family of all tails, or the relaxed surface of a gap."""
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        if left is None or right is None:
            u0 = (depth - alone(left, right).f) / length
            if abs(u0) >= OVERHANG * (1 - UPRIGHT):
                raise ValueError(self._overhang(depth, alone(left, right)))
            found = self.response.tail(u0)
            pull = gamma1 * found.reaction
            pulls = (0.0, pull) if left is None else (pull, 0.0)
            return Free(gamma1 * length * found.energy, pulls, gamma1 * found.area, found.residual)
        read = self._gap(left, right, depth)
        if read.upright:
            raise ValueError(self._overhang(depth, left, right))
        whole = read.relaxed
        one, other = whole.reactions
        residual, pulls = max(whole.residual, read.apart), (gamma1 * one, gamma1 * other)
        return Free(gamma1 * length * whole.energy, pulls, gamma1 * whole.area, residual)

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
