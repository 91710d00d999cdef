"""Energy and force of a contact of a layer, and its free surface, from the fields of its poles.

The force is known from what the poles pull at the line (contact.py), and as dU/dd of the energy at
fixed contact, a parabola of the depth that the elements under the indenter give (inside.py).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import Body
from discretization.layer.contact import Condensed
from discretization.layer.inside import Fields, fields

Array = NDArray[np.float64]
_OUTSIDE = 400  # places at which the free surface is compared with the indenter
_FAR = 40.0  # decay lengths


@dataclass(frozen=True, eq=False)
class Layer:
    """A contact at a depth [h], condensed with many poles."""

    body: Body
    contact: Condensed
    depth: float
    tolerance: float

    @property
    def a(self) -> float:
        """Half-width [h]."""
        return self.contact.a

    @property
    def u(self) -> float:
        """At the line."""
        return self.depth - self.contact.f

    @functools.cached_property
    def amplitudes(self) -> Any:
        """Of the free surface."""
        return self.contact.amplitudes @ np.array([self.u, 1.0])

    def inside(self, depth: float) -> Fields:
        """Fields under the indenter with this contact at a depth."""
        own = self.body.poles(self.tolerance)
        amplitudes = self.contact.amplitudes @ np.array([depth - self.contact.f, 1.0])
        at_line = (1 - own.share) @ amplitudes
        if own.flow:
            at_line = np.append(at_line, (-own.flow / own.decays**2) @ amplitudes)
        return fields(self.body.geometry, self.body.profile, own, at_line, self.a, depth)

    @functools.cached_property
    def fields(self) -> Fields:
        """At its own depth."""
        return self.inside(self.depth)

    def stored(self, depth: float) -> float:
        """½ ∫p u + ½ S u(a): of the layer, and of the free surface's stretching."""
        inner = self.fields if depth == self.depth else self.inside(depth)
        u, under = depth - self.contact.f, depth - self.body.profile.height(inner.x)
        pressed = float((inner.weights * inner.pressure * under).sum())
        return (pressed + self.line * (self.contact.sigma * u + self.contact.rest) * u) / 2

    @property
    def line(self) -> float:
        """Γ times the length of the line."""
        return self.body.gamma * float(self.body.geometry.measure(np.array(self.a)))

    @property
    def stretched(self) -> float:
        """Γ/2 ∫ f'² in contact."""
        inner = self.fields
        return self.body.gamma * float((inner.weights * inner.slope**2).sum()) / 2

    @property
    def area(self) -> float:
        """In contact, over `whole` of its geometry."""
        return float(self.fields.weights.sum())

    @property
    def unbalanced(self) -> float:
        """By how much the pulls of the poles' fields at the line differ from both sides.

        Over all that presses; each pole with its share of the pressure.
        """
        own, geometry = self.body.poles(self.tolerance), self.body.geometry
        outside = (own.share * geometry.outside(own.decays, self.a)) @ self.amplitudes
        line = float(geometry.measure(np.array(self.a)))
        off = (own.c / own.tau * (line * outside - self.fields.pulls(own.tau))).sum()
        return geometry.whole * float(abs(off)) / (self.force_scale or 1.0)

    @functools.cached_property
    def rounding(self) -> float:
        """How far the force is from dU/dd, over the sizes of its terms: of both."""
        step = abs(self.u) + self.a * abs(self.contact.slope) or self.a
        rise = (self.stored(self.depth + step) - self.stored(self.depth - step)) / (2 * step)
        off = abs(self.body.geometry.whole * rise - self.contact.load(self.depth))
        return off / (self.force_scale or 1.0)

    @functools.cached_property
    def force_scale(self) -> float:
        """∫|p| and what the free surface pulls."""
        inner, pull = self.fields, self.contact.sigma * self.u + self.contact.rest
        parts = float((inner.weights * np.abs(inner.pressure)).sum()) + self.line * abs(pull)
        return self.body.geometry.whole * parts

    @property
    def energy_scale(self) -> float:
        """Of the stored energy and of the adhesion."""
        return self.body.geometry.whole * (self.stored(self.depth) + self.stretched + self.bound)

    @property
    def bound(self) -> float:
        """What adheres, over `whole` of its geometry."""
        return self.body.excess(self.body.scene) ** 2 * self.body.gamma / 2 * self.area

    @property
    def energy(self) -> float:
        """U."""
        return self.body.geometry.whole * (self.stored(self.depth) + self.stretched - self.bound)

    def free(self, beside: Array) -> tuple[Array, Array]:
        """u of the free surface and its slope outwards, so far from the line."""
        decays = self.body.poles(self.tolerance).decays
        found = self.body.geometry.decayed(decays, self.a, beside)
        u, slope = ((self.amplitudes @ part).real for part in found)
        return u, slope

    @property
    def reach(self) -> float:
        """How far the free surface is felt."""
        slowest = float(self.body.poles(self.tolerance).decays.real.min())
        return min(_FAR / slowest, self.body.edge - self.a)

    @functools.cached_property
    def through(self) -> float:
        """How far the free surface is inside the indenter at most."""
        part = np.concatenate([np.geomspace(1e-9, 1, _OUTSIDE), np.linspace(0, 1, _OUTSIDE)])
        beside = self.reach * part
        g = self.depth - self.body.profile.height(self.a + beside)
        return float((g - self.free(beside)[0]).max())
