"""Free surfaces with rotational symmetry and small slopes.

In units of l, with the stiffness S(s) beyond a line of radius s or on the disc inside it, and σ, τ
of a ring (axisymmetric.py),

    D = f + (f' - √(2w/γ₁))/S,     D = f + [s (f' - √(2w/γ₁)) - τ (f_other - f)]/σ.

The square in ∂U/∂x = 2πx (γ₁/2 r² - w) is left because the energies obey

    d(s S)/ds = -s + s S²  outside,    d(s S)/ds = s - s S²  inside,    ±∂E/∂q = q (u² - S²)/2

of a ring, S its reaction per length of the line, on the mesh to rounding.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.axisymmetric import FAR, Ring, ring, ring_surface, stiffness
from discretization.fitted.free_surface import decayed
from discretization.fitted.response import Response
from discretization.fitted.surfaces import MET, At, Free, alone, by_side
from energy import Scene

Array = NDArray[np.float64]
_BESIDE = 2.0**-40  # l: a line at the axis is asked for at this radius
ANY = -1e200  # below every depth
_STEP = 1e-3  # of a radius, or of the width of a ring: of fourth order, good to 1e-11
_DIFFERENCES = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))


@dataclass(frozen=True, eq=False)
class AxisymmetricSurfaces:
    """Free surfaces of a scene, with the elements of a response."""

    scene: Scene
    response: Response

    @by_side
    def rest_depth(self, side: int, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D: linear in the heights and the slope; at the axis what it is just beside it.

        A tip that does not adhere rests there as it is touched. A contact around the axis has no
        line there: it rests at any depth.
        """
        length, degree = self.scene.elastocapillary_length, self.response.degree
        s, excess = x / length, length * (side * f1 - np.sqrt(2 * w / self.scene.gamma1))
        if facing is None:
            axis = np.less_equal(s, 0)  # differences may look beyond it
            rest = f + excess / stiffness(degree, side, np.where(axis, _BESIDE, s)[()])
            there = np.where(excess < 0, rest, f) if side > 0 else ANY
            return np.where(axis, there, rest)[()]
        s = np.maximum(s, _BESIDE)
        apart = np.maximum(side * (facing.x - x) / length, MET)
        q, p = (s, s + apart) if side > 0 else (s - apart, s)
        found = ring(degree, q, p)
        ground = found.inner if side > 0 else found.outer
        rest = f + (s * excess - found.tie * (facing.f - f)) / ground
        return rest if np.ndim(x) else float(rest[0])

    def pull(self, side: int, line: At, depth: float) -> float:
        """2πa S of a tail or a disc."""
        s = line.x / self.scene.elastocapillary_length
        S = stiffness(self.response.degree, side, s) if s else 0.0
        return float(2 * math.pi * self.scene.gamma1 * s * S * (depth - line.f))

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """Of a tail and a disc with the exact decay: from the mesh it differs by rounding."""
        length, degree = self.scene.elastocapillary_length, self.response.degree
        r = np.atleast_1d(z) / length
        if left is not None and right is not None and right.x - left.x <= FAR * length:
            values, rates = ring_surface(degree, left.x / length, right.x / length).at(r)
            ends = np.array([depth - left.f, depth - right.f])
            u, u1 = ends @ values, ends @ rates / length
        else:
            u, u1 = np.zeros((2, r.size))
            for side, line in ((-1, right), (1, left)):
                if line is None or line.x == 0:  # beside a point without extent nothing is held
                    continue
                s = line.x / length
                own = (depth - line.f) * decayed(side * s, 0.0, side * (r - s))
                u, u1 = u + own, u1 - side * own * stiffness(degree, side, r) / length
        return u.reshape(np.shape(z)), u1.reshape(np.shape(z))

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """F, and S of all lines together."""
        length, degree = self.scene.elastocapillary_length, self.response.degree
        unit = 2 * math.pi * self.scene.gamma1 * length
        if left is None or right is None:
            line, side = alone(left, right), 1 if right is None else -1
            u, s = (depth - line.f) / length, line.x / length
            pull = s * stiffness(degree, side, np.where(np.equal(s, 0), _BESIDE, s)) * u
            return unit * length * u * pull / 2, unit * pull
        found = self._ring(left, right)
        one, other = (depth - left.f) / length, (depth - right.f) / length
        return unit * length * _energy(found, one, other), unit * (
            found.inner * one + found.outer * other
        )

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """One free surface, with what its energies are off by.

        As all its nodes are balanced, k∫u over a tail or a disc is what it pulls.
        """
        length, degree = self.scene.elastocapillary_length, self.response.degree
        unit = 2 * math.pi * self.scene.gamma1 * length
        if left is None or right is None:
            line, side = alone(left, right), 1 if right is None else -1
            u, s = (depth - line.f) / length, line.x / length
            if not s:
                return Free(0.0, (0.0, 0.0), 0.0, 0.0)
            pull = unit * s * stiffness(degree, side, s) * u
            pulls = (pull, 0.0) if side > 0 else (0.0, pull)
            return Free(length * pull * u / 2, pulls, pull, _imbalance(degree, side, s))
        found, one, other = self._ring(left, right), depth - left.f, depth - right.f
        one, other = one / length, other / length
        tied = found.tie * (one - other)
        pulls = float(found.inner * one + tied), float(found.outer * other - tied)
        area, residual = sum(pulls), self._unequal(found, one, other, left, right)
        if right.x - left.x <= FAR * length and left.x:
            surface = ring_surface(degree, left.x / length, right.x / length)
            area, residual = (
                float(surface.areas @ [one, other]),
                max(residual, surface.residual),
            )
        return Free(
            unit * length * float(_energy(found, one, other)),
            (unit * pulls[0], unit * pulls[1]),
            unit * area,
            residual,
        )

    def _ring(self, left: At, right: At) -> Ring:
        length = self.scene.elastocapillary_length
        found = ring(self.response.degree, left.x / length, right.x / length)
        return found if np.ndim(left.x) else Ring(*(float(part[0]) for part in found))

    def _unequal(self, found: Ring, one: float, other: float, left: At, right: At) -> float:
        """How far ∂E/∂q is from q (u² - S²)/2 at both lines, over its terms."""
        length = self.scene.elastocapillary_length
        q, p = left.x / length, right.x / length
        tied = found.tie * (one - other)
        return max(
            self._off(q, p, one, other, (found.inner * one + tied) / q) if q else 0.0,
            self._off(p, q, other, one, (found.outer * other - tied) / p),
        )

    def _off(self, s: float, far: float, u: float, beyond: float, S: float) -> float:
        """The same at a line of radius s, of the part of the ring beside it.

        As the ring is balanced inside, E changes as this part alone does when the line moves and
        the surface is held at the end of the part: what is stored further away, many times as much
        beside a small contact, would only round. The steps are powers of two, which sums keep.
        """
        degree, way = self.response.degree, 1 if far > s else -1
        wide = min(abs(far - s), s, 1.0)
        h, m = 2.0 ** math.floor(math.log2(_STEP * wide)) if wide else 0.0, s + way * wide / 2
        if h < np.spacing(s) or m in (s, far):
            return 0.0
        mine, rest = (ring(degree, *sorted(ends)) for ends in ((s, m), (m, far)))
        own, next_ = (mine.outer, rest.inner) if way > 0 else (mine.inner, rest.outer)
        at = (mine.tie * u + rest.tie * beyond) / (mine.tie + rest.tie + own + next_)
        rate = 0.0
        for count, weight in _DIFFERENCES:
            ends = (u, at) if way > 0 else (at, u)
            moved = ring(degree, *sorted((s + count * h, m)))
            rate -= way * weight * float(_energy(moved, *ends)[0]) / h
        size = s * (u * u + S * S)
        return abs(rate - s * (u * u - S * S) / 2) / (size or 1.0)


def _energy(found: Ring, one: Any, other: Any) -> Any:
    """E/(2π) of a ring displaced by this much at its inner and outer line."""
    apart = one - other
    return (found.inner * one * one + found.outer * other * other + found.tie * apart * apart) / 2


@functools.lru_cache(maxsize=64)  # the certificate asks for the line the totals have asked for
def _imbalance(degree: int, side: int, s: float) -> float:
    """How far d(s S)/ds is from side s (S² - 1), over its terms."""
    S, rate = stiffness(degree, side, s), 0.0
    for count, weight in _DIFFERENCES:
        r = s * (1 + count * _STEP)
        rate += weight * r * stiffness(degree, side, r) / (_STEP * s)
    return float(abs(rate - side * s * (S * S - 1)) / (s * (S * S + 1)))
