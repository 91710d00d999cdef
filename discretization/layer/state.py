"""States of one contact of a layer with its exact response: totals, certificate, error estimate.

Every number is found in two ways: what pulls at the line by Green's identities with the exact
solutions of the poles (contact.py), and by elements under the indenter (inside.py, totals.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import ROUNDING, Certificate, NotCertifiedError
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import TIP, Body, Search
from discretization.layer.totals import Layer
from discretization.quadrature import summed
from discretization.surfaces.protocol import At, alone
from energy import Scene

Array = NDArray[np.float64]
_SAFE = 0.5  # of the relative error that is asked for: tolerance of the poles
_EXACT = 1e-11  # of the energy of the free surface
_COARSER = 30.0  # times the tolerance: poles that tell what the others leave
_LUCKY = 0.1  # of the error of the poles: what may be left where coarser ones happen to agree


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
    certificate = certify(state, search.excess, search.excess)
    if rate < 0:  # D falls outwards: the line would run away
        certificate = certificate._replace(neighbours=1.0)
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


def certify(state: Layer, closing: float, opening: float) -> Certificate:
    """The conditions of ../certificate.py, depths over the largest of |d|, u and what lifts a line.

    closing, opening: √(2w/γ₁) of both works of adhesion.

    stationarity  what pulls at the line from both sides of the fields of the poles
    neighbours    d <= D just outside the line by closing, D just inside by opening <= d
    force         P against dU/dd, by the energy of the elements
    """
    body, contact, depth = state.body, state.contact, state.depth
    if state.a <= TIP and depth == body.touch:  # nothing is pressed
        return Certificate.undeformed()
    size = abs(depth - body.touch) + abs(state.u) + opening / contact.sigma
    size = size + abs(contact.slope) / contact.sigma or 1.0
    beyond = depth - body.rest_depth(contact, closing, 1)
    within = body.rest_depth(contact, opening, -1) - depth
    pulled = 0.0
    if not opening and state.a > TIP:
        pressure = state.fields.pressure
        pulled = max(0.0, -float(pressure.min())) / (float(np.abs(pressure).max()) or 1.0)
    return Certificate(
        max(0.0, state.through) / size,
        state.unbalanced,
        pulled,
        max(0.0, beyond, within) / size,
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
