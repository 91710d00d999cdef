"""Equilibria with any number of contacts on the fitted mesh (small slopes).

The lattice says which contacts there are; their lines are then found on the fitted mesh, and the
result is judged. Where lines are lost or the judgement fails, the lattice was too coarse and a
finer one is asked. With adhesion, where equilibria are not unique, the finer one has to agree.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate, NotCertifiedError
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.bubbles import parted
from discretization.fitted.contacts import FittedContacts, fitted_contacts, totals
from discretization.fitted.gap_lines import LostLineError
from discretization.fitted.judgement import certify, errors, penetration
from discretization.fitted.lines import Problem
from discretization.fitted.response import chosen, finer
from discretization.fitted.tail import FittedTail
from discretization.lattice import fronts
from discretization.lattice.lowest import lowest_contacts, refuse_unknown
from discretization.lattice.nodes import Lattice
from discretization.lattice.path_state import contacts_on_path
from discretization.lattice.shortest_path import window
from energy import Scene

Array = NDArray[np.float64]
_PER_LENGTH = 16
_DEEPEST = 64.0
_FINER = 4.0  # a path may turn another way by what a coarse lattice does not resolve
_MOST = 20_000
_SAMPLES = 65
_LINKS = 2.0
_SAME = 1e-3
_ROUNDING = 16 * float(np.finfo(float).eps)
_UNKNOWN = Certificate(*5 * (math.nan,))


def on_several(scene: Scene, depth: float, *, branch: str, rtol: float) -> Equilibrium:
    """Certified equilibrium of a profile that may have several contacts, and its error estimate.

    NotCertifiedError if no lattice fine enough to show the contacts was found; ValueError as the
    lattice's.
    """
    spacing = coarsest(scene)
    state: Equilibrium | None = None
    failure: Exception | None = None
    ratio = _FINER if branch == "adhered" and scene.work_of_adhesion else 2.0
    least = spacing / _DEEPEST
    while spacing >= least:
        try:
            near = _on_lattice(scene, depth, branch, spacing)
            if state is not None and _alike(state, near, _LINKS * spacing):
                return _lowest(state)
            before, state = state, _near(scene, depth, branch, near, spacing, rtol)
        except (LostLineError, NotCertifiedError, ValueError) as problem:
            failure, state = problem, None
        else:
            unique = state.contacts.size and not scene.work_of_adhesion
            if unique or (before is not None and _alike(before, state.contacts, _SAME * spacing)):
                return _lowest(state)
        spacing /= ratio
    if isinstance(failure, ValueError):
        raise failure
    raise NotCertifiedError(
        f"the contacts at depth = {depth!r} are not the same on lattices down to spacing = "
        f"{ratio * spacing!r}, or no equilibria between their nodes"
        + (f" ({failure})" if failure else "")
        + "; try method='lattice' with a smaller spacing, or another depth: this one may be that "
        "of an event"
    )


def coarsest(scene: Scene) -> float:
    """l/16, or what resolves the corners and knots of the profile."""
    indenter, spacing = scene.indenter, scene.elastocapillary_length / _PER_LENGTH
    cuts = np.union1d(indenter.corners, indenter.knots)
    if cuts.size < 2:
        return spacing
    typical = float(np.median(np.diff(cuts)))
    return min(spacing, max(typical, float(np.ptp(cuts)) / _MOST))


def _on_lattice(scene: Scene, depth: float, branch: str, spacing: float) -> Array:
    """The outermost nodes of each contact on a lattice (m, 2), small gaps left out."""
    lattice = Lattice.of(scene, spacing)
    where = fronts.region(lattice, scene.indenter, depth)
    if branch == "global" or not scene.work_of_adhesion:
        nodes, _ = lowest_contacts(scene, depth, lattice, "lattice", False)
    else:
        found = contacts_on_path(scene, depth, lattice, where)
        if found is None:
            one = fronts.adhered(lattice, scene.indenter, depth, where)
            found = np.array([] if one is None else [one[:2]], int).reshape(-1, 2)
        nodes = found
    if nodes.size:
        refuse_unknown(scene, depth, lattice, where, nodes)
    return parted(scene, depth, np.asarray(lattice.x(nodes.astype(float))))


def _alike(state: Equilibrium, near: Array, distance: float) -> bool:
    """Whether these are the same contacts (m, 2)."""
    if state.contacts.shape != near.shape:
        return False
    return bool(np.abs(state.contacts - near).max(initial=0.0) <= distance)


def _lowest(state: Equilibrium) -> Equilibrium:
    """Of "global" the detached state where that has less energy."""
    if state.branch != "global" or state.energy <= 0:
        return state
    within = np.linspace(state.contacts[:, 0], state.contacts[:, 1], _SAMPLES)
    if state.depth > state.scene.indenter.height(within).min():
        return state
    flat = detached(state.scene, state.depth, state.branch, state.tail, Certificate.undeformed())
    return replace(flat, method="fitted")


def _near(
    scene: Scene, depth: float, branch: str, near: Array, spacing: float, rtol: float
) -> Equilibrium:
    """The certified state with the contacts that a lattice of this spacing has."""
    points, response = sample_points(scene, depth, spacing), chosen(scene.slopes, rtol)
    touch = float(scene.indenter.height(near).min(initial=math.inf))
    if not near.size:
        return _without_contact(Problem.of(scene, depth, touch, branch, response), branch, points)
    while True:
        problem = Problem.of(scene, depth, touch, branch, response)
        contacts = fitted_contacts(problem, near, spacing)
        if contacts.pulled.any():  # a contact of one point has let go
            near = contacts.x[~contacts.pulled]
            if not near.size:
                return _without_contact(problem, branch, points)
            continue
        state = state_of(contacts, branch, points, rtol)
        better = finer(response)
        met = max(state.error_estimate.values()) <= rtol or response.error <= _ROUNDING
        if met or better is None:
            return state
        response, near = better, state.contacts


def _without_contact(problem: Problem, branch: str, points: Array) -> Equilibrium:
    """The detached state."""
    tail = FittedTail(problem.scene.elastocapillary_length, problem.response)
    flat = detached(problem.scene, problem.depth, branch, tail, _UNKNOWN)
    certificate = Certificate.undeformed(penetration(flat, points) / problem.lift)
    return _passed(replace(flat, certificate=certificate, method="fitted"))


def sample_points(scene: Scene, depth: float, spacing: float) -> Array:
    """Where penetration is looked for: where contact may be, half a node apart, and at knots."""
    lattice, indenter = Lattice.of(scene, spacing), scene.indenter
    first, g = window(lattice, indenter, depth)
    x = np.asarray(lattice.x(first - 0.5 + np.arange(2 * g.size + 1) / 2))
    parts = [np.asarray(part, float) for part in (indenter.corners, indenter.knots)]
    kinks = [part[(part >= x[0]) & (part <= x[-1])] for part in parts]
    return np.unique(np.clip(np.concatenate([x, *kinks]), *indenter.extent))


def state_of(contacts: FittedContacts, branch: str, points: Array, rtol: float) -> Equilibrium:
    """The certified state with these contacts; points (n,): where penetration is looked for.

    rtol: of energy and force. NotCertifiedError if it is no equilibrium.
    """
    problem, scene = contacts.problem, contacts.problem.scene
    coarse, fine = totals(contacts, rtol)
    lines = [line for pair in contacts.pairs for line in pair]
    state = Equilibrium(
        scene=scene,
        depth=problem.depth,
        contacts=contacts.x,
        nodes=contacts.x,
        pinned=np.array([line.pinned for line in lines]).reshape(-1, 2),
        force=fine.force,
        energy=fine.energy,
        neutral=any(line.neutral for line in lines),
        certificate=_UNKNOWN,
        tail=FittedTail(scene.elastocapillary_length, problem.response),
        scales={"force": fine.force_scale, "energy": fine.energy_scale},
        errors=errors(contacts, coarse, fine),
        method="fitted",
        branch=branch,
        spacing=math.nan,
    )
    return _passed(replace(state, certificate=certify(contacts, state, fine, points)))


def _passed(state: Equilibrium) -> Equilibrium:
    """The state. NotCertifiedError if its certificate failed."""
    if not state.certificate.ok:
        raise NotCertifiedError(
            f"the state at depth = {state.depth!r} with {len(state.contacts)} contacts violates "
            f"{', '.join(state.certificate.failures)} ({state.certificate})"
        )
    return state
