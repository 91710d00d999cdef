"""Equilibria on a lattice: contact set, certificate, contact lines between the nodes."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import NoReturn

import numpy as np

from discretization.certificate import Certificate, NotCertifiedError
from discretization.equilibrium import Equilibrium, detached
from discretization.lattice import fronts
from discretization.lattice.accuracy import estimated
from discretization.lattice.judgement import judged
from discretization.lattice.line import End, Line, ends_of, outer
from discretization.lattice.lowest import on_lowest, state_of, without_contact
from discretization.lattice.nodes import Lattice
from discretization.lattice.path_state import on_lowest_rings, on_path
from discretization.lattice.springs import on_springs
from discretization.lattice.sums import measured
from discretization.lattice.unseen import looked_at
from discretization.routes import question_of, route
from energy import Plane, Scene


def on_lattice(
    scene: Scene,
    depth: float,
    spacing: float,
    *,
    branch: str = "adhered",
    origin: float | None = None,
    method: str = "lattice",
    margin: bool = True,
) -> Equilibrium:
    """Certified equilibrium at an imposed depth on nodes `spacing` apart, one of them on `origin`.

    min U[u] s.t. u_i >= d - f(x_i), U that of `NodalEnergy`; a, P and U are interpolated between
    the nodes. branch, and method "lattice", "shortest_path" or "oracle", are those of `minimise`,
    which looks at its arguments first; origin: by default that of `Lattice.of`; margin: whether the
    proof of a global minimum says how far above it the next topology lies.

    ValueError for a spacing too large for the body, and for a contact that would leave the profile;
    NotCertifiedError if no equilibrium was found.
    """
    lattice = Lattice.of(scene, spacing, origin)
    if isinstance(scene.indenter, Plane):
        if method != "lattice":
            raise ValueError(f"method = {method!r} needs an end to the plane: use 'lattice'")
        return _plane(scene, depth, branch, lattice)
    seen = lattice.seen(scene)
    where = fronts.region(lattice, seen.indenter, depth)
    way = route(scene, question_of(method, branch), nodes=True)
    state: Equilibrium | None
    if way == "lowest":
        state = on_lowest(seen, depth, branch, lattice, where, method, margin)
    elif way == "rings":
        state = on_lowest_rings(seen, depth, lattice, where)
    elif way == "path":
        state = on_path(seen, depth, lattice, where)
    elif way == "springs":
        state = on_springs(seen, depth, branch, lattice, where)
    else:
        state = None
    if state is None:
        state = _one_contact(seen, depth, branch, lattice, where)
    return replace(state, scene=scene, errors=functools.partial(estimated, on_lattice))


def looked_at_on_lattice(
    scene: Scene, depth: float, spacing: float, *, branch: str, method: str
) -> Equilibrium:
    """`on_lattice`, looked at between the nodes: AccuracyWarning where they do not see enough."""
    state = on_lattice(scene, depth, spacing, branch=branch, method=method)
    return looked_at(state, Lattice.of(scene, spacing), stacklevel=3)


def _one_contact(
    scene: Scene, depth: float, branch: str, lattice: Lattice, where: fronts.Region
) -> Equilibrium:
    """The certified state of one contact or none. ValueError or NotCertifiedError for others."""
    indenter = scene.indenter
    find = fronts.held if branch == "global" and not scene.gamma1 else fronts.adhered
    contact = find(lattice, indenter, depth, where)
    if contact is None:
        return without_contact(scene, depth, branch, lattice, where)
    sums = measured(lattice, indenter, depth, contact)
    apart = branch == "global" and depth <= fronts.height(lattice, indenter, where.lowest)
    if apart and sums.energy > 0:
        return without_contact(scene, depth, branch, lattice, where)
    ends = ends_of(lattice, indenter, depth, where, contact)
    lines = outer(lattice, indenter, contact.reach, ends)
    _refuse_overhang(lattice, scene, depth, contact, lines)
    certificate = judged(lattice, indenter, depth, contact, sums, ends)
    if not certificate.ok:
        _refuse(scene, depth, certificate)
    nodes = [contact[:2]]
    state = state_of(scene, depth, branch, lattice, nodes, sums, certificate, [lines])
    return replace(state, neutral=_indifferent(lattice, contact, ends[0]))


def _refuse(scene: Scene, depth: float, certificate: Certificate) -> NoReturn:
    """What to say of a state that has not passed its certificate."""
    raise NotCertifiedError(
        f"the state at depth = {depth!r} violates {', '.join(certificate.failures)} "
        f"({certificate}): the surface meets or leaves the indenter elsewhere than at the two "
        "ends of one contact; try a smaller spacing, or a profile with a single contact"
    )


def _refuse_overhang(
    lattice: Lattice, scene: Scene, depth: float, contact: fronts.Contact, lines: tuple[Line, Line]
) -> None:
    """ValueError for lines at which the surface would all but turn over (finite slopes)."""
    limit = lattice.greatest_displacement
    if limit == math.inf:
        return
    u = depth - scene.indenter.height(np.array([line.x for line in lines]))
    nodes = depth - fronts.heights(lattice, scene.indenter, np.array(contact[:2], float))
    for line, lift, node in zip(lines, u.tolist(), nodes.tolist(), strict=True):
        if abs(lift) > limit or abs(node) > limit + lattice.spacing:
            raise ValueError(_overhang(lattice, depth, f" x = {line.x!r}", lift))


def _overhang(lattice: Lattice, depth: float, where: str, lift: float) -> str:
    return (
        f"depth = {depth!r}: at the contact line{where} the surface is displaced by {lift!r}, more "
        f"than 1.3 l + Δx = {lattice.greatest_displacement!r}; it is too steep for spacing = "
        f"{lattice.spacing!r} and at √2 l it would turn over; use method='fitted', a smaller "
        "|depth|, a smaller w or a blunter indenter"
    )


def _indifferent(lattice: Lattice, contact: fronts.Contact, end: End) -> bool:
    """Whether moving a line by several links costs nothing: any contact width is an equilibrium."""
    if contact.last - contact.first < 3 or not lattice.w:
        return False
    most = 1e-10 * lattice.w * lattice.cell
    inside = range(-end.start)
    return all(end.gap[link] > 0 and abs(end.energy[link]) <= most for link in inside)


def _plane(scene: Scene, depth: float, branch: str, lattice: Lattice) -> Equilibrium:
    """The endless plane: every link is alike, so one link decides for all (case study 1)."""
    gap, cost, _ = map(float, lattice.advance(0.0, 0.0, depth))
    adheres = lattice.gamma1 or branch == "global" or depth < 0
    lift = max(abs(depth), scene.critical_separation) or 1.0
    apart = Certificate.undeformed(max(0.0, depth / lift))
    state = detached(scene, depth, branch, lattice.tail, apart, lattice.spacing)
    if gap > (lattice.critical_gap * (1 + 1e-12) if adheres else 0.0):
        return state
    if gap > 0 and abs(depth) > lattice.greatest_displacement:
        raise ValueError(_overhang(lattice, depth, "", depth))
    gain = max(0.0, cost) / (lattice.w * lattice.spacing) if gap > 0 else 0.0
    balanced = abs(cost) <= 1e-10 * lattice.w * lattice.spacing
    everywhere = np.array([[-math.inf, math.inf]])
    return replace(
        state,
        contacts=everywhere,
        nodes=everywhere,
        pinned=np.zeros((1, 2), bool),
        force=math.copysign(math.inf, depth) if depth else 0.0,
        energy=0.0 if balanced else math.copysign(math.inf, cost),
        neutral=gap > 0 and balanced,
        certificate=Certificate(0.0, 0.0, 0.0, gain, 0.0),
    )
