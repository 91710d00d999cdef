"""States of one contact of a layer with its exact response: totals, certificate, error estimate.

A line is looked for with few poles, and then found with many: as few poles tell how D changes,
every step of a secant method leaves little more than their error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import ROUNDING, Certificate, NotCertifiedError
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import TIP, Body
from discretization.layer.lines import Lines
from discretization.layer.table import Table
from discretization.layer.totals import Layer
from discretization.quadrature import summed
from discretization.surfaces.protocol import At, alone
from energy import Scene

Array = NDArray[np.float64]
_SAFE = 0.5  # of the relative error that is asked for: tolerance of the poles
_EXACT = 1e-11  # of the energy of the free surface
_COARSER = 30.0  # times the tolerance: poles that tell what the others leave
_ROUGHLY = 1e-3  # tolerance of the poles with which a line is looked for
_STEPS = 20
_STILL = 1e-13  # of the half-width: a step that is none
_BESIDE = 1e-4  # of the half-width: over which D and P change
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
        beside = side * (z - alone(left, right).x) / h
        return self.layer.free(beside) * h, side * self.layer.free(beside, 1)

    def pressure(self, state: Any, x: Array) -> Array:
        """p in contact at positions, sums of the fields of the poles."""
        body = self.layer.body
        found = self.layer.pressure_at(np.abs(x - body.apex).ravel() / body.h)
        return body.scene.layer.shear_modulus * found.reshape(x.shape)

    def parts(self, state: Any) -> dict[str, float]:
        """As readings.parts_of; what springs store there is stored in the layer."""
        own, body = self.layer, self.layer.body

        def density(x: Array) -> Array:
            """Γ/2 u'² of the free surface."""
            slope = own.free(x.ravel(), 1).reshape(x.shape)
            return np.array([body.gamma / 2 * slope**2 * (own.a + x) ** body.geometry.power])

        ends = np.array([[0.0], [own.reach]])
        outside = own.whole * float(
            summed(density, ends, _EXACT, np.zeros((1, 1)), smooth=True).sums.sum()
        )
        unit, lines = body.unit * body.h, own.whole * own.reaction * body.unit
        stored, stretched, bound = own.energies
        return {
            "springs": unit * (stored - outside),
            "surface": unit * (stretched + outside),
            "adhesion": -unit * bound,
            "pressure": state.force - lines,
            "lines": lines,
        }


def on_layer(scene: Scene, depth: float, *, branch: str, rtol: float) -> Equilibrium:
    """Certified equilibrium of one contact on the way from first touch, and its error estimate."""
    body = Body(scene)
    at, excess, tolerance = depth / body.h, body.excess(scene), _SAFE * rtol
    lines = Lines(Table(body, max(_ROUGHLY, tolerance)), excess)
    a, _, how = lines.settled(at)
    if how == "lost":
        return detached(scene, depth, branch, NOTHING, Certificate.undeformed())
    if how == "corner":
        return equilibrium(Layer.of(body, a, at, tolerance), lines, math.inf, branch)
    beside = a * np.array([1 - _BESIDE, 1 + _BESIDE])
    rate = float(np.diff(lines.table.rest_depth(beside, excess, 1))[0] / np.diff(beside)[0])
    return equilibrium(_found(body, a, at, rate, excess, tolerance), lines, rate, branch)


def _found(
    body: Body, a: float, depth: float, first: float, excess: float, tolerance: float
) -> Layer:
    """The contact whose line rests at a depth, by secants from near by; first: about dD/da."""
    rate, off, move = first, math.inf, math.inf
    for _ in range(_STEPS):
        before, last = off, move
        state = Layer.of(body, a, depth, tolerance)
        off = float(body.rest_depth(*_line(state), excess, 1)[0]) - depth
        if math.isfinite(before):
            rate = (before - off) / last
        move = off / rate if rate * first > 0 else off / first
        if abs(move) <= _STILL * a or abs(last) <= abs(move) <= math.sqrt(_STILL) * a:
            return state
        a = max(a - move, a / 2)
    raise NotCertifiedError(
        f"no contact line is found at depth = {depth * body.h!r}; try another depth"
    )


def _line(state: Layer) -> tuple[Array, Array]:
    """a, and σ, s₀, of which D is made."""
    return state.contact.a, state.contact.reaction.T


def equilibrium(state: Layer, lines: Lines, rate: float, branch: str) -> Equilibrium:
    """The certified state of a contact; rate: dD/da, infinite of a line that is pinned."""
    body, scene, pinned = state.body, state.body.scene, math.isinf(rate)
    certificate = certify(state, lines.excess, lines.excess)
    if rate < 0:  # D falls outwards: the line would run away
        certificate = certificate._replace(neighbours=1.0)
    named = f"the state at depth = {state.depth * body.h!r}"
    if not certificate.penetration <= certificate.tolerance:
        raise NotCertifiedError(
            f"{named} touches the indenter again beside its contact: a layer that is nearly "
            "incompressible rises there; use another depth, or response='springs'"
        )
    certificate.demand(named, "try another depth")
    fields, (stored, stretched, bound) = LayerFields(state), state.energies
    unit, scales = body.unit, (state.force_scale, body.h * (stored + stretched + bound))
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
        force=state.force * unit,
        energy=(stored + stretched - bound) * unit * body.h,
        scales={"force": scales[0] * unit, "energy": scales[1] * unit},
        errors=errors(state, lines, rate),
    )


def certify(state: Layer, closing: float, opening: float) -> Certificate:
    """The conditions of ../certificate.py, depths over the largest of |d|, u and what lifts a line.

    closing, opening: √(2w/γ₁) of both works of adhesion.

    stationarity  what the poles' fields press, by elements and by Green's identity
    neighbours    d <= D just outside the line by closing, D just inside by opening <= d
    force         P against dU/dd
    """
    body, contact, depth = state.body, state.contact, state.depth
    if state.touches:
        return Certificate.undeformed()
    slope, sigma = abs(float(contact.slope[0])), float(contact.reaction[0, 0])
    size = abs(depth - body.touch) + abs(float(state.both[0])) + (opening + slope) / sigma or 1.0
    beyond = depth - float(body.rest_depth(*_line(state), closing, 1)[0])
    within = float(body.rest_depth(*_line(state), opening, -1)[0]) - depth
    pulled = 0.0
    if not opening and state.a > TIP:
        pulled = max(0.0, -float(state.pressure.min()))
        pulled /= float(np.abs(state.pressure).max()) or 1.0
    return Certificate(
        max(0.0, state.through) / size,
        state.unbalanced,
        pulled,
        max(0.0, beyond, within) / size,
        state.rounding,
    )


def errors(state: Layer, lines: Lines, rate: float) -> dict[str, float]:
    """Of half-width, force and energy: what coarser poles change, by their tolerance, and rounding.

    The energy at a fixed contact is the least of a quadratic form, and as wrong as its stiffness.
    """
    if state.touches:
        return dict.fromkeys(QUANTITIES, 0.0)
    body, a, fit = state.body, state.contact.a, state.body.poles(state.tolerance).error
    coarse = Layer.of(body, state.a, state.depth, _COARSER * state.tolerance)
    force, move = abs(coarse.force - state.force), 0.0
    if math.isfinite(rate):
        depths = [body.rest_depth(*_line(one), lines.excess, 1)[0] for one in (coarse, state)]
        move = float(abs(depths[0] - depths[1]) / abs(rate))
        beside = a[0] * np.array([1 - _BESIDE, 1 + _BESIDE])
        change = np.diff(lines.table.taken(beside, np.full(2, state.depth))[0]) / np.diff(beside)
        force += move * float(abs(change[0]))
        size = abs(float(state.both[0])) + abs(float(state.contact.slope[0])) / float(
            state.contact.reaction[0, 0]
        )
        move += _COARSER * (state.rounding + _LUCKY * fit) * size / abs(rate)
    least = state.rounding + ROUNDING + _LUCKY * fit
    parts = (
        move / state.a / _COARSER + least,
        force / (state.force_scale or 1.0) / _COARSER + least,
        fit + least,
    )
    return dict(zip(QUANTITIES, map(float, parts), strict=True))
