"""States of one contact of a layer with its exact response: certificate and error estimate.

A line is looked for with few poles, and then found with many: as few poles tell how D changes,
every step of a secant method leaves little more than their error.
"""

from __future__ import annotations

import math

import numpy as np

from discretization.certificate import ROUNDING, Certificate, NotCertifiedError
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import Body
from discretization.layer.lines import Lines
from discretization.layer.table import Table
from discretization.layer.totals import Layer
from discretization.surfaces.small import SmallSurfaces
from energy import Scene

_SAFE = 0.5  # of the relative error that is asked for: tolerance of the poles
_COARSER = 30.0  # times the tolerance: poles that tell what the others leave
_ROUGHLY = 1e-3  # tolerance of the poles with which a line is looked for
_STEPS = 20
_STILL = 1e-13  # of the half-width: a step that is none
_BESIDE = 1e-4  # of the half-width: over which D changes
_LUCKY = 0.1  # of the error of the poles: what may be left where coarser ones happen to agree


def on_layer(scene: Scene, depth: float, *, branch: str, rtol: float) -> Equilibrium:
    """Certified equilibrium of one contact on the way from first touch, and its error estimate."""
    body, tolerance, excess = Body(scene), _SAFE * rtol, scene.surfaces.small_slope_deficit
    for fit in (max(_ROUGHLY, tolerance), tolerance):  # few poles may see none, or one too many
        lines = Lines(Table(body, fit), excess)
        a, _, how = lines.settled(depth)
        if how == "corner":
            return equilibrium(Layer.of(body, a, depth, tolerance), math.inf, branch)
        if how == "rests":
            beside = a * np.array([1 - _BESIDE, 1 + _BESIDE])
            rate = float(np.diff(lines.rest_depth(beside, 1))[0] / np.diff(beside)[0])
            state = _found(body, a, depth, rate, tolerance)
            if state is not None:
                return equilibrium(state, rate, branch)
    if how == "lost":
        return detached(scene, depth, branch, SmallSurfaces(scene), Certificate.undeformed())
    raise NotCertifiedError(f"no contact line is found at depth = {depth!r}; try another depth")


def _found(body: Body, a: float, depth: float, first: float, tolerance: float) -> Layer | None:
    """The contact whose line rests at a depth, by secants from near by; first: about dD/da."""
    rate, off, move = first, math.inf, math.inf
    for _ in range(_STEPS):
        before, last = off, move
        state = Layer.of(body, a, depth, tolerance)
        off = state.rest_depth(body.scene.surfaces.small_slope_deficit, 1) - depth
        if math.isfinite(before):
            rate = (before - off) / last
        move = off / rate if rate * first > 0 else off / first
        if abs(move) <= _STILL * a or abs(last) <= abs(move) <= math.sqrt(_STILL) * a:
            return state
        a = max(a - move, a / 2)
    return None


def equilibrium(state: Layer, rate: float, branch: str) -> Equilibrium:
    """The certified state of a contact; rate: dD/da, infinite of a line that is pinned."""
    body, scene, pinned = state.body, state.body.scene, math.isinf(rate)
    certificate = certify(state)
    if rate < 0:  # D falls outwards: the line would run away
        certificate = certificate._replace(neighbours=1.0)
    named = f"the state at depth = {state.depth!r}"
    if not certificate.penetration <= certificate.tolerance:
        raise NotCertifiedError(
            f"{named} touches the indenter again beside its contact: a layer that is nearly "
            "incompressible rises there; use another depth, or response='springs'"
        )
    certificate.demand(named, "try another depth")
    stored, stretched, bound = state.energies
    x = np.array([body.ends(0.0 if state.a <= body.tip else state.a)])
    return Equilibrium(
        scene,
        state.depth,
        branch,
        "fitted",
        certificate,
        state,
        contacts=x,
        nodes=x,
        pinned=np.array([[pinned or scene.axisymmetric, pinned]]),
        force=state.force,
        energy=stored + stretched - bound,
        scales={"force": state.force_scale, "energy": stored + stretched + bound},
        errors=errors(state, rate),
    )


def certify(state: Layer) -> Certificate:
    """The conditions of ../certificate.py, depths over the largest of |d|, u and what lifts a line.

    stationarity  what the poles' fields press and pull, on two sets of elements
    neighbours    d <= D just outside the line by closing, D just inside by opening <= d
    force         P against dU/dd
    """
    body, scene = state.body, state.body.scene
    if state.touches:
        return Certificate.undeformed()
    closing = scene.surfaces.small_slope_deficit
    opening = scene.opened.surfaces.small_slope_deficit
    size = abs(state.depth - body.touch) + _displacement(state, opening) or 1.0
    beyond = state.depth - state.rest_depth(closing, 1)
    within = state.rest_depth(opening, -1) - state.depth
    pulled = 0.0
    if not opening and state.a > body.tip:
        pulled = max(0.0, -float(state.pressed.min()))
        pulled /= float(np.abs(state.pressed).max()) or 1.0
    return Certificate(
        max(0.0, state.through) / size,
        state.unbalanced,
        pulled,
        max(0.0, beyond, within) / size,
        state.rounding,
    )


def _displacement(state: Layer, excess: float = 0.0) -> float:
    """|u| at the line, and by how much its slope and adhesion lift it."""
    contact = state.contact
    lifted = abs(float(contact.slopes[0, -1, -1])) + excess
    return abs(float(state.both[0])) + lifted / float(contact.reaction[0, 0])


def errors(state: Layer, rate: float) -> dict[str, float]:
    """Of half-width, force and energy: what coarser poles change, by their tolerance, and rounding.

    The energy at a fixed contact is the least of a quadratic form, and as wrong as its stiffness.
    At rest dP/da = -m γ₁σ √(2w/γ₁), as that is what dU/da changes by with the depth.
    """
    if state.touches:
        return dict.fromkeys(QUANTITIES, 0.0)
    excess = state.body.scene.surfaces.small_slope_deficit
    fit = state.contact.poles.error
    coarse = Layer.of(state.body, state.a, state.depth, _COARSER * state.tolerance)
    force, move = abs(coarse.force - state.force), 0.0
    if math.isfinite(rate):
        move = abs(coarse.rest_depth(excess, 1) - state.rest_depth(excess, 1)) / abs(rate)
        force += move * excess * float(state.contact.lines[0, 0])
        move += _COARSER * (state.rounding + _LUCKY * fit) * _displacement(state) / abs(rate)
    least = state.rounding + ROUNDING + _LUCKY * fit
    parts = (
        move / state.a / _COARSER + least,
        force / (state.force_scale or 1.0) / _COARSER + least,
        fit + least,
    )
    return dict(zip(QUANTITIES, map(float, parts), strict=True))
