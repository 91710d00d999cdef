"""Free surfaces with small slopes, of line contacts and about an axis.

Everything is linear in the depth. In units of l, with the networks (σ, τ) of network.py, m(s) the
length of a line (1, or its radius over 2π) and σ = m S of a surface without another line,

    D = f + m (f' - √(2w/γ₁))/σ,     D = f + [m (f' - √(2w/γ₁)) - τ (f_other - f)]/σ.

The square in ∂U/∂x = m (γ₁/2 r² - w) is left because on the mesh, to rounding,

    ∂E/∂s = ±m (S² - u²)/2

where a line at s moves away from its contact, S its reaction per length: it is what `_off` checks.
"""

import functools
import math
from typing import Any

import numpy as np

from discretization.surfaces.network import Line, Network, Shape
from discretization.surfaces.protocol import ANY, NARROWEST, Free, Surfaces
from discretization.surfaces.rings import BESIDE, Axis
from energy.arrays import Array

_STEP = 1e-30  # of a width, along the imaginary axis
# on elements of the least degree whose errors are rounding
_NETS: dict[str, Line | Axis] = {"line": Line(10), "axisymmetric": Axis()}


class SmallSurfaces(Surfaces):
    """Free surfaces of a scene."""

    @property
    def net(self) -> Line | Axis:
        """The networks of its geometry."""
        return _NETS[self.scene.geometry]

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, steep: Any, w: Any) -> Any:
        """Linear in the heights and the slope."""
        net, off, turned = self.net, s, self.scene.axisymmetric
        if turned and (s.min() if isinstance(s, np.ndarray) else s) < BESIDE:
            # differences may look beyond the axis
            off = np.where(np.isinf(width) & np.greater(s, 0), s, np.maximum(s, BESIDE))[()]
        found = net.between(side, off, width)
        pull = (off if turned else 1.0) * (steep - np.sqrt(2 * w))
        u = (pull + found.tie * rise) / found.left
        if off is s or np.isfinite(width).all():
            return u
        # a line at the axis rests as just beside it, if it does not adhere as it is touched;
        # a contact around the axis has no line there: it rests at any depth
        there = np.where(np.greater(side, 0), np.minimum(u, 0.0), ANY)
        return np.where(np.less_equal(s, 0), there, u)[()]

    def held(self, side: int, s: Any, width: Any, u: Any, rise: Any) -> tuple[Any, Any]:
        """Of the networks."""
        found, v = self.net.between(side, s, np.maximum(width, NARROWEST)), u + rise
        return found.energy(u, v, -rise), found.left * u + found.right * v

    @functools.lru_cache(maxsize=64)  # noqa: B019
    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free:
        """As all nodes are balanced, k∫u over it is what it pulls."""
        found, v = self.net.between(side, s, max(width, NARROWEST)), u + rise
        one, other = map(float, found.pulls(u, v, -rise))
        off = self._off(side, s, width, u, -rise, one)
        if width < math.inf:
            off = max(off, self._off(-side, s + width, width, v, rise, other))
        return Free(float(found.energy(u, v, -rise)), (one, other), one + other, off)

    def form(self, x: Array, *lines: Any) -> Shape:
        """As the networks have it."""
        return self.net.shape(x, *lines)

    def _off(self, side: int, s: float, width: float, u: float, apart: float, pull: float) -> float:
        """How far ∂E/∂s of the part of a surface beside a line is from what is said above.

        As the surface is balanced inside, E changes as this part alone does when the line moves and
        the surface is held at the end of the part: what is stored further away, many times as much
        beside a small contact, would only round. E is a rational function of s, and Im E(s + ih)/h
        has no difference to lose digits in (W. Squire, G. Trapp, SIAM Review 40 (1998) 110).
        """
        m, net = s if self.scene.axisymmetric else 1.0, self.net
        if not m or not width:
            return 0.0
        part = min(width, s if self.scene.axisymmetric else 1.0, 1.0) / 4  # one element
        middle, h = s + side * part, _STEP * part
        moved = net.between(side, complex(s, -side * h), complex(part, h))
        mine, rest = Network(*np.real(moved)), net.between(side, middle, width - part)
        between = mine.right + rest.left
        fall = (between * u + rest.tie * apart) / (mine.tie + between + rest.tie)
        rate, S = moved.energy(u, u - fall, fall).imag / h, pull / m
        return float(abs(rate - m * (u * u - S * S) / 2) / (m * (u * u + S * S) or 1.0))
