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

from discretization.surfaces.network import Line
from discretization.surfaces.protocol import ANY, MET, At, Free, alone
from discretization.surfaces.rings import BESIDE, Axis
from energy import Scene

Array = NDArray[np.float64]
_STEP = 1e-30  # of a width, along the imaginary axis
# on elements of the least degree whose errors are rounding
_NETS: dict[str, Line | Axis] = {"line": Line(10), "axisymmetric": Axis()}


@dataclass(frozen=True, eq=False)
class SmallSurfaces:
    """Free surfaces of a scene."""

    scene: Scene

    @property
    def net(self) -> Line | Axis:
        """The networks of its geometry."""
        return _NETS[self.scene.geometry]

    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D: linear in the heights and the slope."""
        net, scene, length = self.net, self.scene, self.scene.elastocapillary_length
        excess = length * (side * f1 - np.sqrt(2 * w / scene.gamma1))
        # differences may look beyond the axis
        s = np.maximum(x / length, BESIDE) if scene.axisymmetric else x / length
        if facing is not None:
            found = net.between(side, s, np.maximum(side * (facing.x - x) / length, MET))
            return f + (net.measure(s) * excess - found.tie * (facing.f - f)) / found.left
        rest = f + net.measure(s) * excess / net.alone(side, s)
        if not scene.axisymmetric:
            return rest
        # a line at the axis rests as just beside it, if it does not adhere as it is touched;
        # a contact around the axis has no line there: it rests at any depth
        there = np.where(np.greater(side, 0), np.where(excess < 0, rest, f), ANY)
        return np.where(np.less_equal(x, 0), there, rest)[()]

    def _lines(self, left: At | None, right: At | None, depth: Any) -> tuple[Any, ...]:
        """A free surface from its first line on, in units of l.

        The side of the line it is on, where that is, how far away the other one, u, and how much
        more at the other.
        """
        length, line = self.scene.elastocapillary_length, alone(left, right)
        s, u = line.x / length, (depth - line.f) / length
        if left is None or right is None:
            return 1 if left else -1, s, math.inf, u, -u
        return 1, s, (right.x - left.x) / length, u, (left.f - right.f) / length

    @property
    def _unit(self) -> Any:
        """Of forces: γ₁, or 2πγ₁l about an axis."""
        return self.scene.gamma1 * self.scene.measure(self.scene.elastocapillary_length)

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """F, and S of all lines together."""
        side, s, width, u, rise = self._lines(left, right, depth)
        found, v = self.net.between(side, s, np.maximum(width, MET)), u + rise
        energy = self.scene.elastocapillary_length * found.energy(u, v, -rise)
        return self._unit * energy, self._unit * (found.left * u + found.right * v)

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """One free surface. As all its nodes are balanced, k∫u over it is what it pulls."""
        side, s, width, u, rise = self._lines(left, right, depth)
        found, v, unit = self.net.between(side, s, max(width, MET)), u + rise, float(self._unit)
        one, other = map(float, found.pulls(u, v, -rise))
        off = self._off(side, s, width, u, -rise, one)
        if width < math.inf:
            off = max(off, self._off(-side, s + width, width, v, rise, other))
        pulls = (unit * one, unit * other)[::side]
        energy = self.scene.elastocapillary_length * found.energy(u, v, -rise)
        return Free(unit * float(energy), (pulls[0], pulls[1]), sum(pulls), off)

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """As the networks have it."""
        if left is None and right is None:
            return np.zeros_like(z), np.zeros_like(z)
        side, s, width, *ends = self._lines(left, right, depth)
        length = self.scene.elastocapillary_length
        x = side * (np.ravel(z) - alone(left, right).x) / length
        u, u1 = self.net.shape(side, s, width, x, *ends)
        return length * u.reshape(np.shape(z)), side * u1.reshape(np.shape(z))

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
        mine, rest = net.between(side, s, part), net.between(side, middle, width - part)
        between = mine.right + rest.left
        fall = (between * u + rest.tie * apart) / (mine.tie + between + rest.tie)
        moved = net.between(side, complex(s, -side * h), complex(part, h))
        rate = moved.energy(u, u - fall, fall).imag / h
        S = pull / m
        return float(abs(rate - m * (u * u - S * S) / 2) / (m * (u * u + S * S) or 1.0))
