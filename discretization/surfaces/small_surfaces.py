"""Free surfaces with small slopes.

Everything is linear in the depth: in units of l, with the stiffness s of a tail, and B and A of the
halves of a gap (gap.py),

    D = f + (f' - √(2w/γ₁))/s,       D = (f + f_other)/2 + (f' - √(2w/γ₁) - A (f_other - f)/2)/B.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces import gap
from discretization.surfaces.protocol import MET, At, Free, alone
from discretization.surfaces.response import Response
from energy import Scene

Array = NDArray[np.float64]
_FAR = 60.0  # elastocapillary lengths: longer parts of a surface are as stiff as an endless one


@dataclass(frozen=True, eq=False)
class SmallSurfaces:
    """Free surfaces of a scene, with the elements of a response."""

    scene: Scene
    response: Response

    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D: linear in the heights and the slope."""
        length = self.scene.elastocapillary_length
        excess = length * (side * f1 - np.sqrt(2 * w / self.scene.gamma1))
        if facing is None:
            return f + excess / self.response.reactions[0]
        apart = np.maximum(side * (facing.x - x) / length, MET)
        even, odd = gap.half(self.response.degree, apart if np.ndim(apart) else float(apart))
        rise = (facing.f - f) / 2
        return f + rise + (excess - rise * odd) / even

    def pull(self, side: int, line: At, depth: float) -> float:
        """S of a tail."""
        u = (depth - line.f) / self.scene.elastocapillary_length
        return float(self.scene.gamma1 * self.response.reaction(u))

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

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """F: of two halves; S of both lines together is that of the even half."""
        scene, response = self.scene, self.response
        length, gamma1 = scene.elastocapillary_length, scene.gamma1
        if left is None or right is None:
            u = (depth - alone(left, right).f) / length
            return gamma1 * length * u * u * response.energies[0], gamma1 * response.reaction(u)
        even = (depth - left.f / 2 - right.f / 2) / length
        odd = (right.f - left.f) / (2 * length)
        found = gap.half(response.degree, np.maximum((right.x - left.x) / length, MET))
        energy = even * even * found.even + odd * odd * found.odd
        return gamma1 * length * energy, 2 * gamma1 * even * found.even

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """A tail is a multiple of one; a gap falls into two halves, even and odd."""
        response, length = self.response, self.scene.elastocapillary_length
        gamma1 = self.scene.gamma1
        if left is None or right is None:
            tail = response.tail((depth - alone(left, right).f) / length)
            pull = gamma1 * tail.reaction
            pulls = (0.0, pull) if left is None else (pull, 0.0)
            return Free(gamma1 * length * tail.energy, pulls, gamma1 * tail.area, tail.residual)
        even = (depth - left.f / 2 - right.f / 2) / length
        odd, apart = (right.f - left.f) / (2 * length), (right.x - left.x) / length
        found = gap.half(response.degree, apart)
        one, other = even * found.even + odd * found.odd, even * found.even - odd * found.odd
        energy = even * even * found.even + odd * odd * found.odd
        area, residual = 2 * even * response.area(1.0), abs(response.reaction(1.0) - 1)
        if apart <= 2 * gap.FAR:
            shapes = gap.shapes(response.degree, apart)
            area = 2 * even * float(shapes.areas[0])
            residual = max(self._unequal(even, odd, one, apart), shapes.residual / (1 + found.odd))
        pulls = gamma1 * one, gamma1 * other
        return Free(gamma1 * length * energy, pulls, gamma1 * area, residual)

    def _unequal(self, even: float, odd: float, pull: float, apart: float) -> float:
        """How far 2 ∂F/∂L is from u² - S² at a line, over the mean u² of both and S²."""
        even_rate, odd_rate = gap.rates(self.response.degree, apart)
        rate, own = even * even * even_rate + odd * odd * odd_rate, even + odd
        size = even * even + odd * odd + pull * pull
        return float(abs(2 * rate - own * own + pull * pull) / (size or 1.0))
