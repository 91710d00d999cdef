"""Free surfaces with small slopes, of line contacts and about an axis.

Everything is linear in the depth. In units of l, with the networks (σ, τ) of network.py, m(s) the
length of a line (1, or its radius over 2π) and σ = m S of a surface without another line,

    D = f + m (f' - √(2w/γ₁))/σ,     D = f + [m (f' - √(2w/γ₁)) - τ (f_other - f)]/σ.

The square in ∂U/∂x = m (γ₁/2 r² - w) is left because on the mesh, to rounding,

    ∂E/∂s = ±m (S² - u²)/2

where a line at s moves away from its contact, S its reaction per length: it is what `_off` checks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.network import FAR, Line, Network
from discretization.surfaces.protocol import ANY, MET, At, Free, alone, by_side
from discretization.surfaces.rings import BESIDE, Axis
from energy import Scene

Array = NDArray[np.float64]
_STEP = 1e-30  # of a width, along the imaginary axis
# on elements of the least degrees whose errors are rounding
_NETS: dict[str, Line | Axis] = {"line": Line(10), "axisymmetric": Axis(12)}


@dataclass(frozen=True, eq=False)
class SmallSurfaces:
    """Free surfaces of a scene."""

    scene: Scene

    @property
    def net(self) -> Line | Axis:
        """The networks of its geometry."""
        return _NETS[self.scene.geometry]

    @by_side
    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D: linear in the heights and the slope."""
        length, net = self.scene.elastocapillary_length, self.net
        excess = length * (side * f1 - np.sqrt(2 * w / self.scene.gamma1))
        if facing is None and not self.scene.axisymmetric:  # the same wherever the line is
            return f + excess / net.alone(side, 0.0)
        s = x / length
        if facing is None:
            s = np.where(np.less_equal(s, 0), BESIDE, s)[()]  # differences may look beyond it
            rest = f + net.measure(s) * excess / net.alone(side, s)
            return self._at_axis(side, x, f, excess, rest)
        s = np.maximum(s, BESIDE) if self.scene.axisymmetric else s
        apart = np.maximum(side * (facing.x - x) / length, MET)
        found = net.between(side, s, apart if np.ndim(apart) else float(apart))
        ground = found.left if not self.scene.axisymmetric or side > 0 else found.right
        return f + (net.measure(s) * excess - found.tie * (facing.f - f)) / ground

    def _at_axis(self, side: int, x: Any, f: Any, excess: Any, rest: Any) -> Any:
        """A line at the axis rests as just beside it, if it does not adhere as it is touched.

        A contact around the axis has no line there: it rests at any depth.
        """
        there = np.where(excess < 0, rest, f) if side > 0 else ANY
        return np.where(np.less_equal(x, 0), there, rest)[()]

    @property
    def _force(self) -> float:
        """Unit of forces: γ₁, or 2πγ₁l about an axis."""
        if self.scene.axisymmetric:
            return 2 * math.pi * self.scene.gamma1 * self.scene.elastocapillary_length
        return self.scene.gamma1

    def _between(self, left: At | None, right: At | None, depth: Any) -> tuple[Network, Any, Any]:
        """The network of free surfaces, u at its ends, and how far they differ."""
        length = self.scene.elastocapillary_length
        if right is None or left is None:
            line, side = alone(left, right), 1 if right is None else -1
            pull, u = self.net.alone(side, line.x / length), (depth - line.f) / length
            return Network(pull, 0.0, 0.0).seen_from(side), (u, 0.0)[::side], 0.0
        width = np.maximum((right.x - left.x) / length, MET)
        found = self.net.between(1, left.x / length, width if np.ndim(width) else float(width))
        ends = (depth - left.f) / length, (depth - right.f) / length
        return found, ends, (right.f - left.f) / length

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """F, and S of all lines together."""
        found, (u, v), apart = self._between(left, right, depth)
        energy = self.scene.elastocapillary_length * found.energy(u, v, apart)
        return self._force * energy, self._force * (found.left * u + found.right * v)

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """One free surface. As all its nodes are balanced, k∫u over it is what it pulls."""
        length, scale, far = self.scene.elastocapillary_length, self._force, math.inf
        found, (u, v), apart = self._between(left, right, depth)
        one, other = map(float, found.pulls(u, v, apart))
        if left is not None and right is not None:
            width = (right.x - left.x) / length
            far = width if self._near(left.x / length, width) else far
        ends = (1, left, u, apart, one), (-1, right, v, -apart, other)
        off = [self._off(side, line.x / length, far, *held) for side, line, *held in ends if line]
        energy = scale * length * float(found.energy(u, v, apart))
        return Free(energy, (scale * one, scale * other), scale * (one + other), max(off))

    def _near(self, q: float, width: float) -> bool:
        """Whether a line at q and another one beyond it feel each other."""
        return width <= FAR and not (self.scene.axisymmetric and not q)

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """In a gap or a ring, else what is left of every line's displacement."""
        length = self.scene.elastocapillary_length
        x, u, u1 = np.ravel(z), np.zeros(np.size(z)), np.zeros(np.size(z))
        if left is not None and right is not None:
            q, width = left.x / length, (right.x - left.x) / length
            if self._near(q, width):
                distance = (x - left.x) / length
                u, u1 = self.net.shape(q, width, distance, depth - left.f, left.f - right.f)
                return u.reshape(np.shape(z)), u1.reshape(np.shape(z)) / length
        for side, line in ((-1, right), (1, left)):
            if line is None or (self.scene.axisymmetric and not line.x):
                continue  # beside a point without extent nothing is held
            each = self.net.beyond(side, line.x / length, side * (x - line.x) / length)
            u, u1 = u + (depth - line.f) * each[0], u1 + side * (depth - line.f) * each[1]
        return u.reshape(np.shape(z)), u1.reshape(np.shape(z)) / length

    def _off(self, side: int, s: float, width: float, u: float, apart: float, pull: float) -> float:
        """How far ∂E/∂s of the part of a surface beside a line is from what is said above.

        As the surface is balanced inside, E changes as this part alone does when the line moves and
        the surface is held at the end of the part: what is stored further away, many times as much
        beside a small contact, would only round. E is a rational function of s, so that
        Im E(s + ih)/h has no difference to lose digits in (W. Squire, G. Trapp, SIAM Review 40
        (1998) 110).
        """
        m, net = self.net.measure(s), self.net
        if not m or not width:
            return 0.0
        part = min(width, s if self.scene.axisymmetric else 1.0, 1.0) / 4  # one element
        middle, h = s + side * part, _STEP * part
        mine = net.between(side, s, part).seen_from(side)
        if math.isinf(width):
            rest = Network(net.alone(side, middle), 0.0, 0.0)
        else:
            rest = net.between(side, middle, width - part).seen_from(side)
        between = mine.right + rest.left
        fall = (between * u + rest.tie * apart) / (mine.tie + between + rest.tie)
        moved = net.between(side, complex(s, -side * h), complex(part, h)).seen_from(side)
        rate = moved.energy(u, u - fall, fall).imag / h
        S = pull / m
        return float(abs(rate - m * (u * u - S * S) / 2) / (m * (u * u + S * S) or 1.0))
