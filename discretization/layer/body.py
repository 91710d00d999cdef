"""One contact of a scene with the exact response of its layer, in units of h and G.

A convex profile that is mirrored about 0, or turned about an axis, has one contact with one line.
From first touch the line advances while D(a) < d; withdrawn it recedes while D(a) > d. It is looked
for on a way in steps of a constant ratio, with few poles, and then found with many: as few poles
tell how D changes, every step of Newton's method leaves little more than their error.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.layer.contact import Condensed, Profile, condensed
from discretization.layer.geometry import Axis, Geometry, Line
from discretization.layer.inside import Fields, fields
from discretization.layer.poles import Poles, poles
from discretization.roots import bracketed
from energy import Scene

Array = NDArray[np.float64]
_ROUGHLY = 1e-3  # tolerance of the poles with which a line is looked for
_RATIO = 1.5  # of half-widths at which it is looked for
_NARROWEST, _WIDEST = 1e-9, 1e9  # half-widths, in h
_NEWTON = 12
_STILL = 1e-15  # of the half-width


@dataclass(frozen=True)
class Body:
    """A scene whose layer has its exact response."""

    scene: Scene

    @property
    def h(self) -> float:
        """Unit of lengths."""
        return self.scene.layer.h

    @property
    def gamma(self) -> float:
        """Γ = γ₁/(Gh)."""
        return self.scene.gamma1 / (self.scene.layer.shear_modulus * self.h)

    @property
    def excess(self) -> float:
        """√(2w/γ₁)."""
        return math.sqrt(2 * self.scene.work_of_adhesion / self.scene.gamma1)

    @property
    def geometry(self) -> Geometry:
        """Of its contact."""
        return Axis() if self.scene.axisymmetric else Line()

    @functools.cached_property
    def profile(self) -> Profile:
        """In units of h."""
        indenter, h = self.scene.indenter, self.h

        def height(x: Any) -> Any:
            return np.asarray(indenter.height(np.asarray(x) * h), float) / h

        def slope(x: Any) -> Any:
            return np.asarray(indenter.slope(np.asarray(x) * h), float)

        return Profile(height, slope, tuple(x / h for x in (*indenter.corners, *indenter.knots)))

    def poles(self, tolerance: float) -> Poles:
        """Of the layer."""
        return poles(self.scene.layer.nu, self.gamma, tolerance)

    def condensed(self, a: float, tolerance: float) -> Condensed:
        """The contact of this half-width."""
        return condensed(self.poles(tolerance), self.gamma, self.geometry, self.profile, a)

    def half_width(self, depth: float, tolerance: float) -> float:
        """a on the path from first touch; 0: detached. NotCertifiedError if none is found."""
        touch = float(self.profile.height(np.zeros(1))[0])
        outer = self._looked_for(max(depth, touch), _NARROWEST, _RATIO, 1)
        if depth < touch and outer:
            outer = self._looked_for(depth, outer, 1 / _RATIO, -1)
        return self._found(outer, depth, tolerance) if outer else 0.0

    def _off(self, a: float, depth: float) -> float:
        return self.condensed(a, _ROUGHLY).depth(self.excess) - depth

    def _looked_for(self, depth: float, start: float, ratio: float, way: int) -> float:
        """Where a line rests first that moves from here; 0: nowhere."""
        a = start
        if way * self._off(a, depth) >= 0:
            return a if way < 0 else 0.0
        while _NARROWEST <= a <= _WIDEST:
            beyond = a * ratio
            if way * self._off(beyond, depth) >= 0:
                return bracketed(lambda x: way * self._off(x, depth), a, beyond)
            a = beyond
        return 0.0

    def _found(self, a: float, depth: float, tolerance: float) -> float:
        """The same with many poles."""
        step = 1e-4 * a
        rate = (self._off(a + step, depth) - self._off(a - step, depth)) / (2 * step)
        last = math.inf
        for _ in range(_NEWTON):
            move = (self.condensed(a, tolerance).depth(self.excess) - depth) / rate
            a -= move
            if abs(move) <= _STILL * a or (last <= abs(move) <= math.sqrt(_STILL) * a):
                return a
            last = abs(move)
        raise NotCertifiedError(f"no contact line at depth = {depth!r} [h]; try another depth")

    def fields(self, found: Condensed, depth: float, tolerance: float) -> Fields:
        """Of the poles under the indenter."""
        own = self.poles(tolerance)
        amplitudes = found.amplitudes @ np.array([depth - found.f, 1.0])
        at_line = -(own.decays**2 / (own.tau[:, None] - own.decays**2)) @ amplitudes
        return fields(self.geometry, self.profile, own.tau, at_line, found.a)

    def energy(self, found: Condensed, depth: float, tolerance: float) -> float:
        """U = whole [½∫ p g dm + Γ/2 ∫ f'² dm + ½ m S u(a)] - w |contact|."""
        own, inner = self.poles(tolerance), self.fields(found, depth, tolerance)
        g = depth - self.profile.height(inner.x)
        u = depth - found.f
        pressed = (inner.weights * g * g).sum() * own.still
        pressed += np.tensordot(own.c, (inner.v * (inner.weights * g)).sum(axis=(1, 2)), 1).real
        stretched = self.gamma * (inner.weights * self.profile.slope(inner.x) ** 2).sum()
        line = float(self.geometry.measure(np.array(found.a)))
        held = self.gamma * line * (found.sigma * u + found.rest) * u
        bound = self.excess**2 * self.gamma * inner.weights.sum()
        return float(self.geometry.whole * (pressed + stretched + held - bound) / 2)
