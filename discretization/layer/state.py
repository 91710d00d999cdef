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

from discretization.certificate import ROUNDING, Certificate, NotCertifiedError
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import TIP, Body, Search
from discretization.layer.contact import Condensed
from discretization.layer.inside import Fields, fields
from discretization.quadrature import summed
from discretization.surfaces.protocol import At, alone
from energy import Scene

Array = NDArray[np.float64]
_SAFE = 0.5  # of the relative error that is asked for: tolerance of the poles
_EXACT = 1e-11  # of the energy of the free surface
_COARSER = 30.0  # times the tolerance: poles that tell what the others leave
_LUCKY = 0.1  # of the error of the poles: what may be left where coarser ones happen to agree
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
        share = own.tau[:, None] / (own.tau[:, None] - own.decays**2)
        outside = (share * geometry.outside(own.decays, self.a)) @ self.amplitudes
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


class Flat:
    """A surface that nothing deforms."""

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """u and u' = 0."""
        return np.zeros_like(z), np.zeros_like(z)


NOTHING = Flat()


@dataclass(frozen=True, eq=False)
class LayerFields:
    """What an equilibrium asks of a layer: its free surface, its pressure, and parts of both."""

    layer: Layer

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """u and u' of the free surface at positions beside a line."""
        h, side = self.layer.body.h, 1 if left is not None else -1
        u, slope = self.layer.free(side * (z - alone(left, right).x) / h)
        return u * h, side * slope

    def pressure(self, state: Any, x: Array) -> Array:
        """p in contact at positions, sums of the fields of the poles."""
        body = self.layer.body
        found = self.layer.fields.at(np.abs(x - body.apex).ravel() / body.h)
        return body.scene.layer.shear_modulus * found.reshape(x.shape)

    def parts(self, state: Any) -> dict[str, float]:
        """As parts.parts_of; what springs store there is stored in the layer."""
        own, body = self.layer, self.layer.body

        def density(x: Array) -> Array:
            """Γ/2 u'² of the free surface."""
            slope = own.free(x.ravel())[1].reshape(x.shape)
            return np.array([body.gamma / 2 * slope**2 * body.geometry.measure(own.a + x)])

        ends = np.array([[0.0], [own.reach]])
        outside = float(summed(density, ends, _EXACT, np.zeros((1, 1)), smooth=True).sums.sum())
        lines = own.line * (own.contact.sigma * own.u + own.contact.rest)
        unit, whole = body.unit * body.h, body.geometry.whole
        lined = whole * lines * body.unit
        return {
            "springs": whole * unit * (own.stored(own.depth) - outside),
            "surface": whole * unit * (own.stretched + outside),
            "adhesion": -whole * unit * own.bound,
            "pressure": state.force - lined,
            "lines": lined,
        }


def on_layer(scene: Scene, depth: float, *, branch: str, rtol: float) -> Equilibrium:
    """Certified equilibrium of one contact on the way from first touch, and its error estimate."""
    body = Body(scene)
    at, excess, tolerance = depth / body.h, body.excess(scene), _SAFE * rtol
    pressed = Search(body, max(at, body.touch), excess)
    a, pinned = pressed.looked_for(pressed.start(), 1)
    search = Search(body, at, excess)
    if at < body.touch and not math.isnan(a):
        a, pinned = search.looked_for(a, -1)
    if math.isnan(a):
        return detached(scene, depth, branch, NOTHING, Certificate.undeformed())
    rate = math.inf
    if not pinned:
        a, rate = search.found(a, tolerance)
    state = Layer(body, body.condensed(a, tolerance), at, tolerance)
    return equilibrium(state, search, rate, branch)


def equilibrium(state: Layer, search: Search, rate: float, branch: str) -> Equilibrium:
    """The certified state of a contact; rate: dD/da, infinite of a line that is pinned."""
    body, scene, pinned = state.body, state.body.scene, math.isinf(rate)
    certificate = certify(state, search, rate)
    named = f"the state at depth = {state.depth * body.h!r}"
    if not certificate.penetration <= certificate.tolerance:
        raise NotCertifiedError(
            f"{named} touches the indenter again beside its contact: a layer that is nearly "
            "incompressible rises there; use another depth, or response='springs'"
        )
    certificate.demand(named, "try another depth")
    fields, energy = LayerFields(state), body.unit * body.h
    a = 0.0 if state.a <= TIP else state.a
    x = np.array([[0.0 if scene.axisymmetric else -a, a]]) * body.h + body.apex
    return Equilibrium(
        scene,
        state.depth * body.h,
        branch,
        "fitted",
        certificate,
        fields,
        contacts=x,
        nodes=x,
        pinned=np.array([[pinned or scene.axisymmetric, pinned]]),
        force=state.contact.load(state.depth) * body.unit,
        energy=state.energy * energy,
        scales={"force": state.force_scale * body.unit, "energy": state.energy_scale * energy},
        errors=errors(state, search, rate),
        elastic=fields,
    )


def certify(state: Layer, search: Search, rate: float) -> Certificate:
    """The conditions of ../certificate.py, depths over the largest of |d|, u and what lifts a line.

    stationarity  what pulls at the line from both sides of the fields of the poles
    force         P against dU/dd, by the energy of the elements
    """
    body, contact, depth = state.body, state.contact, state.depth
    if state.a <= TIP and depth == body.touch:  # nothing is pressed
        return Certificate.undeformed()
    size = abs(depth - body.touch) + abs(state.u) + search.excess / contact.sigma
    size = size + abs(contact.slope) / contact.sigma or 1.0
    if math.isinf(rate):
        off = max(
            body.rest_depth(contact, search.excess, -1) - depth,
            depth - body.rest_depth(contact, search.excess, 1),
        )
    else:
        off = abs(contact.depth(search.excess) - depth) if rate > 0 else size
    pulled = 0.0
    if not search.excess and state.a > TIP:
        pressure = state.fields.pressure
        pulled = max(0.0, -float(pressure.min())) / (float(np.abs(pressure).max()) or 1.0)
    return Certificate(
        max(0.0, state.through) / size,
        state.unbalanced,
        pulled,
        max(0.0, off) / size,
        state.rounding,
    )


def errors(state: Layer, search: Search, rate: float) -> dict[str, float]:
    """Of half-width, force and energy: what coarser poles change, by their tolerance, and rounding.

    The energy at a fixed contact is the least of a quadratic form, and as wrong as its stiffness.
    """
    body, depth, rough = state.body, state.depth, _COARSER * state.tolerance
    coarse, fit = body.condensed(state.a, rough), body.poles(state.tolerance).error
    force, move = abs(coarse.load(depth) - state.contact.load(depth)), 0.0
    if math.isfinite(rate):
        move = abs(coarse.depth(search.excess) - state.contact.depth(search.excess)) / abs(rate)
        step = 1e-4 * state.a
        pair = (body.condensed(state.a + part * step, rough).load(depth) for part in (1, -1))
        force += move * abs(next(pair) - next(pair)) / (2 * step)
        size = abs(state.u) + abs(state.contact.slope) / state.contact.sigma
        move += _COARSER * (state.rounding + _LUCKY * fit) * size / abs(rate)
    least = state.rounding + ROUNDING + _LUCKY * fit
    parts = (
        move / state.a / _COARSER + least,
        force / (state.force_scale or 1.0) / _COARSER + least,
        fit + least,
    )
    return dict(zip(QUANTITIES, map(float, parts), strict=True))
