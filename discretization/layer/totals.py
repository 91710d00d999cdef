"""One contact of a layer at a depth: its energy, force, pressure and free surface.

The force is known from what the poles' fields press, and as dU/dd of the energy at fixed contact,
a parabola of the depth; what these fields pull at the line is known by Green's identity, too.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import TIP, Body
from discretization.layer.contact import Contacts, contacts
from discretization.layer.elements import DEGREE
from discretization.surfaces.spectral import polynomial

Array = NDArray[np.float64]
_OUTSIDE = 200  # places at which the free surface is compared with the indenter
_NEAREST = 1e-9  # of its reach: the first of them
_FAR = 40.0  # decay lengths


@dataclass(frozen=True, eq=False)
class Layer:
    """A contact at a depth [h], the only one of `contact`, with many poles."""

    body: Body
    contact: Contacts
    depth: float
    tolerance: float

    @classmethod
    def of(cls, body: Body, a: float, depth: float, tolerance: float) -> Layer:
        """The contact of this half-width [h]."""
        return cls(body, contacts(body, np.array([a]), tolerance), depth, tolerance)

    @property
    def a(self) -> float:
        """Half-width [h]."""
        return float(self.contact.a[0])

    @property
    def both(self) -> Array:
        """u(a) and 1."""
        return np.array([self.depth - float(self.contact.f[0]), 1.0])

    @property
    def touches(self) -> bool:
        """Whether it is one with the lowest point alone, and nothing is pressed."""
        return self.a <= TIP and self.depth == self.body.touch

    @property
    def whole(self) -> float:
        """What integrals count with."""
        return self.body.geometry.whole

    @property
    def reaction(self) -> float:
        """S times the length of the line."""
        return float(
            self.body.gamma * self.contact.length[0] * self.contact.reaction[0] @ self.both
        )

    @functools.cached_property
    def amplitudes(self) -> Any:
        """Of the free surface."""
        return self.contact.amplitudes[0] @ self.both

    @functools.cached_property
    def pressure(self) -> Array:
        """At nodes (e, 13)."""
        return np.tensordot(self.both, self.contact.pressure[0], 1)

    def pressure_at(self, x: Array) -> Array:
        """The same at positions under the indenter (k,)."""
        nodes = self.a * self.contact.elements.x
        own = np.clip(np.searchsorted(nodes[:, 0], x, side="right") - 1, 0, len(nodes) - 1)
        found = np.empty(x.size)
        for i in np.unique(own).tolist():
            here, (lo, hi) = own == i, nodes[i, [0, -1]]
            found[here] = polynomial(DEGREE, (2 * x[here] - lo - hi) / (hi - lo), self.pressure[i])
        return found

    @property
    def force(self) -> float:
        """P."""
        return self.whole * float(self.both @ self.contact.form[0, :, 0])

    @functools.cached_property
    def energies(self) -> tuple[float, float, float]:
        """Stored in the layer and its free surface, in the surface in contact, and what adheres."""
        stored = float(self.both @ self.contact.form[0] @ self.both) / 2
        area = float(self.contact.weights.sum())
        bound = self.body.excess(self.body.scene) ** 2 * self.body.gamma / 2 * area
        stretched = float(self.contact.stretched[0])
        return self.whole * stored, self.whole * stretched, self.whole * bound

    @functools.cached_property
    def force_scale(self) -> float:
        """∫|p| and what the free surface pulls."""
        parts = float((self.contact.weights[0] * np.abs(self.pressure)).sum()) + abs(self.reaction)
        return self.whole * parts

    @property
    def rounding(self) -> float:
        """How far the force is from dU/dd, over the sizes of its terms."""
        form = self.contact.form[0]
        return self.whole * float(abs(form[0, 1] - form[1, 0])) / 2 / (self.force_scale or 1.0)

    @property
    def unbalanced(self) -> float:
        """By how much what the fields press differs from Green's identity, over all of it."""
        own, contact, a = self.body.poles(self.tolerance), self.contact, self.a
        root, inside = np.sqrt(own.tau), self.body.geometry.inside
        places = (a * contact.elements.x).ravel(), (a * contact.elements.beside).ravel()
        rise = a * (contact.elements.weights * contact.slopes[0]).ravel()
        t = inside(root, np.array([a]), np.zeros(1), a)[:, 0]
        exact = t * (contact.at_line[0] @ self.both) + inside(root, *places, a) @ rise
        off = contact.volumes[0] @ self.both - contact.length[0] * exact / root
        return self.whole * float(np.abs(own.c * off).sum()) / (self.force_scale or 1.0)

    def free(self, beside: Array, order: int = 0) -> Array:
        """u of the free surface, or its slope outwards (order 1), so far from the line."""
        decays = self.body.poles(self.tolerance).decays
        found = self.body.geometry.decayed(decays, self.a, beside, order)
        return np.asarray((self.amplitudes @ found).real)

    @property
    def reach(self) -> float:
        """How far the free surface is felt."""
        slowest = float(self.body.poles(self.tolerance).decays.real.min())
        return min(_FAR / slowest, self.body.edge - self.a)

    @functools.cached_property
    def through(self) -> float:
        """How far the free surface is inside the indenter at most.

        It varies the more slowly the farther from the line it is, and so do the places.
        """
        beside = self.reach * np.geomspace(_NEAREST, 1.0, _OUTSIDE)
        g = self.depth - self.body.height(self.a + beside)
        return float((g - self.free(beside)).max())
