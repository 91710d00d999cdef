"""Equilibria on a lattice: which method finds the contacts, and the end of a path from first touch.

Contacts of a convex profile are alone all the way, and found without following the path.
"""

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.lattice import line
from discretization.lattice.accuracy import estimated
from discretization.lattice.judge import State, on_row
from discretization.lattice.lowest import on_lowest
from discretization.lattice.plain import SteepTail, on_plain, overhang, refuse_turning, turning
from discretization.lattice.unresolved import unseen, warn_state, warn_unresolved
from discretization.lattice.walk import Walk
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Contacts, Row
from discretization.routes import LOWEST, route
from energy import Plane, Scene

_TIE = 1e-12  # of δ₀: a line stays where both sides cost the same
_INDIFFERENT = 1e-10  # of wΔx: what a line may pay for a link if it rests anywhere at no cost


def on_lattice(
    scene: Scene,
    depth: float,
    spacing: float,
    *,
    branch: str = "adhered",
    origin: float | None = None,
    method: str = "lattice",
    row: Row | None = None,
    lattice: Lattice | None = None,
) -> Equilibrium:
    """Certified equilibrium at an imposed depth on nodes `spacing` apart, one of them on `origin`.

    min U[u] s.t. u_i >= d - f(x_i), U that of `NodalEnergy`; a, P and U are interpolated between
    the nodes. branch, and method "lattice", "shortest_path" or "oracle", are those of `minimise`,
    which looks at its arguments first; origin: by default that of `Lattice.of`; row, lattice: where
    they are known.

    ValueError for a spacing too large for the body, and for a contact that would leave the profile;
    NotCertifiedError if no equilibrium was found.
    """
    lattice = lattice or Lattice.of(scene, spacing, origin)
    if isinstance(scene.indenter, Plane):
        if method != "lattice":
            raise ValueError(f"method = {method!r} needs an end to the plane: use 'lattice'")
        return _plane(scene, depth, branch, lattice)
    way = route(scene, "search" if method in LOWEST else branch, nodes=True)
    row = row or Row.of(lattice.seen(scene), lattice, depth)
    state = answered(row, depth, way, branch, method)
    return replace(state, scene=scene, errors=functools.partial(estimated, on_lattice))


def answered(
    row: Row, depth: float, way: str, branch: str = "adhered", method: str = "lattice"
) -> Equilibrium:
    """The certified state that a way of `route` finds on a row of nodes. Errors as `on_lattice`."""
    lattice, scene, known, proof = row.lattice, row.scene, None, None
    if way == "plain":
        found = on_plain(row, depth, branch)
    else:
        if way == "lowest":
            nodes, proof = on_lowest(row, depth, method)
            method = "shortest_path" if lattice.w and proof else method
        else:
            nodes, known = on_path(row, depth)
        if nodes:
            row.refuse_unknown(depth, nodes)
        found = on_row(row, nodes, depth) if nodes else None
    if found and branch == "global" and way != "lowest" and depth <= row.lowest:
        found = None if found.balance.energy > 0 else found
    if found is None:
        scale, read = max(abs(depth), scene.critical_separation) or 1.0, {}
        certificate = Certificate.undeformed(max(0.0, (depth - row.lowest) / scale))
    else:
        certificate, read = found.certificate, _read(found, known)
    certificate.demand(
        f"the state found at depth = {depth!r}",
        "rounding has spoilt it, or the solver's tolerance, or a profile that is said to be convex "
        "is not; try another spacing or method",
    )
    flat = detached(scene, depth, branch, lattice.tail, certificate, lattice.spacing)
    return replace(flat, method=method, proof=proof, **read)


def _read(found: State, known: line.Lines | None) -> dict[str, Any]:
    """What an equilibrium with contacts has more than the flat surface; lines are between nodes.

    known: where the lines are, which has to be known where they resist both ways.
    """
    row, lattice, balance = found.row, found.row.lattice, found.balance
    at, there = np.reshape(found.nodes, (1, -1)), None if known is None else np.array([known])
    lines, more = line.between(row, at, np.array([found.depth]), found.passed, there, found.work)
    steep, single = not lattice.linear, len(found.nodes) == 1
    if steep:
        refuse_turning(found, lines[0])
    contacts = lines.reshape(-1, 2)
    return {
        "contacts": contacts,
        "nodes": lattice.x(row.first + np.array(found.nodes)),
        "pinned": np.isin(contacts, row.scene.indenter.corners),
        "energy": balance.energy + float(more[0, 0]),
        "force": balance.force + float(more[1, 0]),
        "scales": {"force": balance.sizes, "energy": balance.scale},
        "surfaces": SteepTail(lattice.tail.rate, lattice) if steep else lattice.tail,
        "neutral": single and not row.scene.hysteretic and _neutral(found),
    }


def _neutral(found: State) -> bool:
    """Whether moving a line of a single contact inwards by several links costs nothing."""
    row, inside = found.row, np.s_[0, -1, : -line.LINKS[0]]
    gap, stored, _, bonds = (part[inside] for part in found.passed)
    least, energy = _INDIFFERENT * row.lattice.w * row.lattice.cell, stored - row.works[0] * bonds
    return least > 0 and bool(((gap > 0) & (np.abs(energy) <= least)).all())


def warned_on_lattice(scene: Scene, depth: float, spacing: float, **asked: Any) -> Equilibrium:
    """`on_lattice`, looked at between the nodes: AccuracyWarning where they do not see enough."""
    lattice = Lattice.of(scene, spacing)
    state = on_lattice(scene, depth, spacing, lattice=lattice, **asked)
    places = None
    if not scene.indenter.convex:
        places = unseen(lattice.seen(scene), depth, lattice, anywhere=not state.contacts.size)
        warn_unresolved([state], places, lattice, stacklevel=3)
    warn_state(state, lattice, places and places.lowest, stacklevel=3)
    return state


def _plane(scene: Scene, depth: float, branch: str, lattice: Lattice) -> Equilibrium:
    """The endless plane: every link is alike, so one link decides for all (case study 1)."""
    work, cost = lattice.w, lattice.k / 2 * depth**2 - lattice.w  # per area
    apart = Certificate.undeformed()
    state = detached(scene, depth, branch, lattice.tail, apart, lattice.spacing)
    if depth < 0 and cost > 2e-12 * work:
        return state
    if -depth > turning(lattice):
        raise ValueError(overhang(depth, "", depth, turning(lattice)))
    gain, balanced = max(0.0, cost) / work if depth < 0 else 0.0, abs(cost) <= 1e-10 * work
    everywhere = np.array([[-math.inf, math.inf]])
    return replace(
        state,
        contacts=everywhere,
        nodes=everywhere,
        pinned=np.zeros((1, 2), bool),
        force=math.copysign(math.inf, depth) if depth else 0.0,
        energy=0.0 if balanced else math.copysign(math.inf, cost),
        neutral=depth < 0 and balanced,
        certificate=apart._replace(neighbours=gain),
    )


def on_path(row: Row, depth: float) -> tuple[Contacts, line.Lines | None]:
    """The contacts on the path from first touch on, and where lines that resist both ways are.

    ValueError for a contact that on the way reaches the end of the known profile.
    """
    deepest, walk, known = max(depth, row.lowest), Walk(row), None
    nodes = walk.touched(deepest)
    row.refuse_unknown(deepest, nodes)
    if row.scene.hysteretic:
        (known,) = line.moved(row, [nodes], np.array([deepest]), (), ())
    if depth < deepest:
        before, tie = nodes, _TIE * row.scene.opened.critical_separation
        nodes = walk.moved(nodes, deepest, depth + tie)
        if nodes and known is not None:
            (known,) = line.moved(row, [nodes], np.array([depth]), before, known)
    return nodes, known
