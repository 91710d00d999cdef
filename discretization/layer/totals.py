"""One contact of a layer at a depth: its energy, force, pressure and free surface.

The force is known from what the poles' fields press, and as dU/dd of the energy at fixed contact,
a parabola of the depth; what these fields press and pull is known from other elements, too.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import Body
from discretization.layer.contact import Contacts, contacts, decayed
from discretization.layer.elements import DEGREE
from discretization.quadrature import summed
from discretization.readings import with_surface
from discretization.surfaces.network import polynomial
from discretization.surfaces.protocol import At, alone

Array = NDArray[np.float64]
_OUTSIDE = 200  # places at which the free surface is compared with the indenter
_NEAREST = 1e-9  # of its reach: the first of them
_FAR = 40.0  # decay lengths
_OTHER = 0.7  # of the way to the line, where elements of another set begin
_EXACT = 1e-11  # of the energy of the free surface


@dataclass(frozen=True, eq=False)
class Layer:
    """A contact at a depth, the only one of `contact`, with many poles."""

    body: Body
    contact: Contacts
    depth: float
    tolerance: float

    @classmethod
    def of(cls, body: Body, a: float, depth: float, tolerance: float, **given: float) -> Layer:
        """The contact of this half-width."""
        return cls(body, contacts(body, np.array([a]), tolerance, **given), depth, tolerance)

    @property
    def a(self) -> float:
        """Half-width."""
        return float(self.contact.a[0])

    @property
    def both(self) -> Array:
        """u(a) and 1."""
        return np.array([self.depth - float(self.contact.f[0]), 1.0])

    @property
    def touches(self) -> bool:
        """Whether it is one with the lowest point alone, and nothing is pressed."""
        return self.a <= self.body.tip and self.depth == self.body.touch

    def rest_depth(self, excess: float, side: int) -> float:
        """D of its line."""
        reaction = self.contact.reaction.T
        return float(self.body.rest_depth(self.contact.a, reaction, excess, side)[0])

    @property
    def lines(self) -> float:
        """What its lines pull."""
        return float(self.contact.lines[0] @ self.both)

    @property
    def force(self) -> float:
        """P."""
        return float(self.both @ self.contact.form[0, :, 0])

    @functools.cached_property
    def energies(self) -> tuple[float, float, float]:
        """Stored in the layer and its free surface, in the surface in contact, and what adheres."""
        stored = float(self.both @ self.contact.form[0] @ self.both) / 2
        bound = self.body.scene.work_of_adhesion * float(self.body.area(self.a))
        return stored, float(self.contact.stretched[0]), bound

    @functools.cached_property
    def pressed(self) -> Array:
        """Pressure at nodes (e, 13)."""
        return np.tensordot(self.both, self.contact.pressure[0], 1)

    @functools.cached_property
    def force_scale(self) -> float:
        """∫|p| and what the free surface pulls."""
        return float((self.contact.weights[0] * np.abs(self.pressed)).sum()) + abs(self.lines)

    @property
    def rounding(self) -> float:
        """How far the force is from dU/dd, over the sizes of its terms."""
        form = self.contact.form[0]
        return float(abs(form[0, 1] - form[1, 0])) / 2 / (self.force_scale or 1.0)

    @property
    def unbalanced(self) -> float:
        """By how much what the fields press, pull and store is different on other elements."""
        other = Layer.of(self.body, self.a, self.depth, self.tolerance, first=_OTHER)
        off = abs(other.force - self.force) + abs(other.lines - self.lines)
        stored, same = (sum(one.energies[:2]) for one in (other, self))
        return max(off / (self.force_scale or 1.0), abs(stored - same) / (same or 1.0))

    def free(self, beside: Array, order: int = 0) -> Array:
        """u of the free surface, or its slope outwards (order 1), so far from the line."""
        contact, a = self.contact, np.full(beside.size, self.a)
        found = decayed(self.body.power, contact.poles.decays, a, beside, order)
        return np.asarray((contact.amplitudes[0] @ self.both @ found).real)

    @property
    def reach(self) -> float:
        """How far the free surface is felt."""
        return _FAR / float(self.contact.poles.decays.real.min())

    @functools.cached_property
    def through(self) -> float:
        """How far the free surface is inside the indenter at most.

        It varies the more slowly the farther from the line it is, and so do the places.
        """
        reach = min(self.reach, self.body.edge - self.a)
        beside = reach * np.geomspace(_NEAREST, 1.0, _OUTSIDE)
        g = self.depth - self.body.height(self.a + beside)
        return float((g - self.free(beside)).max())

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """u and u' of the free surface at positions beside a line."""
        side = 1 if left is not None else -1
        beside = side * (z - alone(left, right).x)
        return self.free(beside), side * self.free(beside, 1)

    def pressure(self, state: Any, x: Array) -> Array:
        """p in contact at positions, sums of the fields of the poles."""
        nodes, x = self.a * self.contact.elements.x, np.abs(x - self.body.apex)
        own = np.clip(np.searchsorted(nodes[:, 0], x, side="right") - 1, 0, len(nodes) - 1)
        found = np.empty(x.shape)
        for i in np.unique(own).tolist():
            here, (lo, hi) = own == i, nodes[i, [0, -1]]
            found[here] = polynomial(DEGREE, (2 * x[here] - lo - hi) / (hi - lo), self.pressed[i])
        return found

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force in parts."""

        def density(x: Array) -> Array:
            """γ₁/2 u'² of the free surface."""
            slope = self.free(x.ravel(), 1).reshape(x.shape)
            whole = self.body.whole * (self.a + x) ** self.body.power
            return np.array([self.body.scene.gamma1 / 2 * slope**2 * whole])

        ends = np.array([[0.0], [self.reach]])
        outside = summed(density, ends, _EXACT, np.zeros((1, 1)), smooth=True)
        return with_surface(state, float(self.contact.stretched[0] + outside.sums.sum()))
