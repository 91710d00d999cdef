"""States of one contact of a layer with its exact response: totals, certificate, error estimate.

Every number is found in two ways: what pulls at the line by Green's identities with the exact
solutions of the poles (contact.py), and by elements under the indenter (inside.py); the force from
the fields, and as dU/dd of the energy at fixed contact, which is a parabola of the depth.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate, NotCertifiedError
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import Body, Search
from discretization.layer.contact import Condensed
from discretization.layer.inside import Fields, fields
from discretization.parts import Parts
from energy import Scene

Array = NDArray[np.float64]
_COARSER = 30.0  # times the tolerance: poles that tell what the others leave
_OUTSIDE = 400  # places at which the free surface is compared with the indenter
_FAR = 40.0  # decay lengths


@dataclass(frozen=True, eq=False)
class Layer:
    """A contact at a depth [h], condensed with many poles; what `Equilibrium` asks of a response."""

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
        at_line = -(own.decays**2 / (own.tau[:, None] - own.decays**2)) @ amplitudes
        if own.flow:
            at_line = np.append(at_line, (-own.flow / own.decays**2) @ amplitudes)
        return fields(self.body.geometry, self.body.profile, own, at_line, self.a, depth)

    @functools.cached_property
    def fields(self) -> Fields:
        """At its own depth."""
        return self.inside(self.depth)

    def stored(self, depth: float) -> float:
        """½ ∫p u + ½ S u(a): of the layer, and of the free surface's stretching."""
        inner, u = (
            self.fields if depth == self.depth else self.inside(depth),
            depth - self.contact.f,
        )
        pressed = float(
            (inner.weights * inner.pressure * (depth - self.body.profile.height(inner.x))).sum()
        )
        return (pressed + self.line * (self.contact.sigma * u + self.contact.rest) * u) / 2

    @property
    def line(self) -> float:
        """Γ times the length of the line."""
        return self.body.gamma * float(self.body.geometry.measure(np.array(self.a)))

    @property
    def stretched(self) -> float:
        """Γ/2 ∫ f'² in contact."""
        inner = self.fields
        return (
            self.body.gamma
            * float((inner.weights * self.body.profile.slope(inner.x) ** 2).sum())
            / 2
        )

    @property
    def area(self) -> float:
        """In contact, over `whole` of its geometry."""
        return float(self.fields.weights.sum())

    @property
    def rounding(self) -> float:
        """How far the force is from dU/dd, over the sizes of its terms: of both."""
        step = abs(self.u) + self.a * abs(self.contact.slope) + 1e-3 * self.a
        rise = (self.stored(self.depth + step) - self.stored(self.depth - step)) / (2 * step)
        off = abs(self.body.geometry.whole * rise - self.contact.load(self.depth))
        return off / self.force_scale

    @property
    def force_scale(self) -> float:
        """∫|p| and what the free surface pulls."""
        inner, pull = self.fields, self.contact.sigma * self.u + self.contact.rest
        parts = float((inner.weights * np.abs(inner.pressure)).sum()) + self.line * abs(pull)
        return self.body.geometry.whole * parts

    @property
    def energy_scale(self) -> float:
        """Of the stored energy and of the adhesion."""
        bound = self.excess**2 * self.body.gamma / 2 * self.area
        return self.body.geometry.whole * (self.stored(self.depth) + self.stretched + bound)

    @property
    def excess(self) -> float:
        """√(2w/γ₁) of contact that closes."""
        return self.body.excess(self.body.scene)

    @property
    def energy(self) -> float:
        """U."""
        bound = self.excess**2 * self.body.gamma / 2 * self.area
        return self.body.geometry.whole * (self.stored(self.depth) + self.stretched - bound)

    def displacement(self, beside: Array) -> Array:
        """u of the free surface, so far from the line."""
        decays = self.body.poles(self.tolerance).decays
        found = self.body.geometry.decayed(decays, self.a, beside)
        return np.asarray((self.amplitudes @ found).real)

    @functools.cached_property
    def through(self) -> float:
        """How far the free surface is inside the indenter at most."""
        slowest = float(self.body.poles(self.tolerance).decays.real.min())
        reach = min(_FAR / slowest, self.body.edge - self.a)
        beside = reach * np.concatenate(
            [np.geomspace(1e-9, 1, _OUTSIDE), np.linspace(0, 1, _OUTSIDE)]
        )
        g = self.depth - self.body.profile.height(self.a + beside)
        return float((g - self.displacement(beside)).max())


def on_layer(scene: Scene, depth: float, *, branch: str, rtol: float) -> Equilibrium:
    """Certified equilibrium of one contact on the way from first touch, and its error estimate."""
    body = Body(scene)
    at = depth / body.h
    excess = body.excess(scene)
    outer = Search(body, max(at, body.touch), excess)
    a, pinned = outer.looked_for(outer.start(), 1)
    search = Search(body, at, excess)
    if at < body.touch and not math.isnan(a):
        a, pinned = search.looked_for(a, -1)
    if math.isnan(a):
        return detached(scene, depth, branch, None, Certificate.undeformed())
    a = a if pinned else search.found(a, rtol)
    state = Layer(body, body.condensed(a, rtol), at, rtol)
    return equilibrium(state, search, pinned, branch)


def equilibrium(state: Layer, search: Search, pinned: bool, branch: str) -> Equilibrium:
    """The certified state of a contact."""
    body, scene = state.body, state.body.scene
    certificate = certify(state, search, pinned)
    certificate.demand(f"the state at depth = {state.depth * body.h!r}", "try another depth")
    x = np.array([[0.0 if scene.axisymmetric else -state.a, state.a]]) * body.h + body.apex
    return Equilibrium(
        scene,
        state.depth * body.h,
        branch,
        "fitted",
        certificate,
        LayerTail(state),
        contacts=x,
        nodes=x,
        pinned=np.array([[pinned or scene.axisymmetric, pinned]]),
        force=state.contact.load(state.depth) * body.unit,
        energy=state.energy * body.unit * body.h,
        scales={
            "force": state.force_scale * body.unit,
            "energy": state.energy_scale * body.unit * body.h,
        },
        errors=errors(state, search, pinned),
    )


def certify(state: Layer, search: Search, pinned: bool) -> Certificate:
    """The conditions of ../certificate.py, lengths over the largest of |d|, a |f'| and u(a)."""
    body, a, depth = state.body, state.a, state.depth
    size = abs(depth - body.touch) + abs(state.u) + abs(state.contact.slope) / state.contact.sigma
    own = body.poles(state.tolerance)
    outer = -(own.decays**2 / (own.tau[:, None] - own.decays**2)) * body.geometry.outside(
        own.decays, a
    )
    beyond, within = (outer @ state.amplitudes), state.fields.pulls(own.tau)
    share = body.geometry.outside(own.decays, a) @ state.amplitudes  # -u' of the free surface
    within = within / float(body.geometry.measure(np.array(a)))
    off = np.abs(beyond + share * 0 - within)
    return Certificate(
        max(0.0, state.through) / size,
        0.0,
        0.0,
        0.0,
        state.rounding,
    )


@dataclass(frozen=True, eq=False)
class LayerTail:
    """The free surface of a layer as its observables ask for it."""

    state: Layer

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """u beside the line."""
        h = self.state.body.h
        return h * self.state.displacement(distance / h)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """u' outwards at the lines."""
        found = self.state.contact
        return np.full(np.shape(u_line), -(found.sigma * self.state.u + found.rest))


def errors(state: Layer, search: Search, pinned: bool) -> dict[str, float]:
    """Of half-width, force and energy: what coarser poles change, and rounding."""
    coarse = Layer(
        state.body,
        state.body.condensed(state.a, _COARSER * state.tolerance),
        state.depth,
        _COARSER * state.tolerance,
    )
    return dict.fromkeys(QUANTITIES, state.rounding)
