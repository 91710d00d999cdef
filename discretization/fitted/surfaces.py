"""What contact lines feel of the free surfaces of the fitted mesh, and the shape of those.

A line rests at x at the depth D(x) at which ∂U/∂x = 0. On the mesh ∂U/∂x = γ₁/2 r² - w with
r = f' - S/γ₁ (lines.py), f' outwards of the contact and S the reaction of the free surface there.
With small slopes S is linear in the depth: in units of l, with the stiffness s of a tail, and B
and A of a gap (gap.py),

    D = f + (f' - √(2w/γ₁))/s,       D = (f + f_other)/2 + (f' - √(2w/γ₁) - A (f_other - f)/2)/B.

With finite slopes ∂U/∂x ∝ 2γ₁ sin²((β - φ)/2) - w, tan β = f', sin φ = S/γ₁: D = f + u of the tail
or of the gap (finite_gap.py) that is inclined by φ = β - 2 asin √(w/(2γ₁)) at its line.

A line advances where D < d and recedes where D > d.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from discretization.fitted import gap
from discretization.fitted.finite_gap import solved
from discretization.fitted.finite_range import UPRIGHT, rest_displacement
from discretization.fitted.free_surface import OVERHANG
from discretization.fitted.response import STEEP, Response
from energy import Scene

Array = NDArray[np.float64]
_MET = 1e-13  # elastocapillary lengths: lines that have met are no closer than that
_FAR = 60.0  # elastocapillary lengths: longer parts of a surface are as stiff as an endless one
_NEWTON = 3


class At(NamedTuple):
    """Contact lines at x and the heights f of the profile there, numbers or arrays."""

    x: Any
    f: Any


class Surfaces(Protocol):
    """Free surfaces beside contacts; a line that is None is infinitely far away."""

    def rest_depth(self, side: int, x: Any, f: Any, f1: Any, facing: At | None, w: float) -> Any:
        """D at x, numbers or arrays, with the height f and the slope f' there.

        side: +1 for a line whose contact is on its left; facing: the line beyond the free surface.
        """

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """u and u' at positions between two lines."""


@dataclass(frozen=True, eq=False)
class SmallSurfaces:
    """Free surfaces with small slopes."""

    scene: Scene
    response: Response

    def rest_depth(self, side: int, x: Any, f: Any, f1: Any, facing: At | None, w: float) -> Any:
        """D: linear in the heights and the slope."""
        length = self.scene.elastocapillary_length
        excess = length * (side * f1 - math.sqrt(2 * w / self.scene.gamma1))
        if facing is None:
            return f + excess / self.response.reactions[0]
        apart = np.maximum(side * (facing.x - x) / length, _MET)
        even, odd = gap.half(self.response.degree, apart if np.ndim(apart) else float(apart))
        rise = (facing.f - f) / 2
        return f + rise + (excess - rise * odd) / even

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """Both parts beside z are condensed to it: u balances them, u' is the pull of one."""
        length, tail = self.scene.elastocapillary_length, self.response.reactions[0]
        pull, stiff, from_left = 0.0, 0.0, (0.0, -tail)
        for side, line in ((-1, left), (1, right)):
            if line is None:
                stiff = stiff + tail
                continue
            part = gap.piece(self.response.degree, np.minimum(side * (line.x - z) / length, _FAR))
            own = part.tie * (depth - line.f)
            pull, stiff = pull + own, stiff + part.ground + part.tie
            if side < 0:
                from_left = own, part.ground + part.tie
        u = pull / stiff + np.zeros_like(z)
        if left is None:
            return u, tail * u / length
        return u, (from_left[1] * u - from_left[0]) / length


@dataclass(frozen=True, eq=False)
class FiniteSurfaces:
    """Free surfaces with finite slopes."""

    scene: Scene
    response: Response

    def rest_depth(self, side: int, x: Any, f: Any, f1: Any, facing: At | None, w: float) -> Any:
        """D: the inclination at rest is known, and the displacement that has it is solved for.

        The inclination is cut at ±π/2, where the surface would turn over.
        """
        length = self.scene.elastocapillary_length
        deficit = 2 * math.asin(math.sqrt(w / (2 * self.scene.gamma1)))
        phi = np.maximum(np.arctan(side * f1) - deficit, -math.pi / 2)
        if facing is None:
            return f + length * self._displaced(phi)
        apart, rise = np.maximum(side * (facing.x - x) / length, _MET), (f - facing.f) / length
        return f + length * rest_displacement(-2 * np.sin(phi / 2), rise, apart)

    def _displaced(self, phi: Any) -> Any:
        """u₀ with S(u₀) = sin φ and 1 - u₀²/2 = cos φ on the mesh, by Newton's method."""
        limit = OVERHANG * (1 - UPRIGHT)
        u = np.clip(np.sign(phi) * np.sqrt(2 - 2 * np.cos(phi)), -limit, limit)
        for _ in range(_NEWTON):
            pull, cos = self._reaction(u), 1 - u * u / 2
            u = u - (np.arctan2(pull, cos) - phi) * np.sqrt(np.maximum(1 - u * u / 4, 0.25))
            u = np.clip(u, -limit, limit)
        return u

    def _reaction(self, u: Any) -> Any:
        if not np.ndim(u):
            return self.response.reaction(float(u))
        mild = np.abs(u) <= STEEP
        pull = np.empty_like(u)
        pull[mild] = self.response.reaction(u[mild])
        pull[~mild] = [self.response.reaction(one) for one in u[~mild].tolist()]
        return pull

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """The gap's, or the tail's polynomials with the slope its first integral gives them."""
        length = self.scene.elastocapillary_length
        if left is not None and right is not None:
            rise = (left.f - right.f) / length
            found = solved((depth - left.f) / length, rise, (right.x - left.x) / length)
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
