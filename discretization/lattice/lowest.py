"""States of lowest energy on the lattice, with any number of contacts (small slopes).

    method           contact set from                     proof of the minimum
    "lattice"        obstacle.py where w = 0,             the certificate: the problem is convex
                     else as "shortest_path"
    "shortest_path"  shortest_path.py                     `Proof`: bound attained, margin
    "oracle"         oracle.py, with cvxpy                the solver's

All are judged by the certificate of contact_set.py, and their lines are recovered between the
nodes, those that face each other together. A lone contact node keeps its lines.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate, NotCertifiedError, Proof
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.lattice import fronts, judgement, line, span
from discretization.lattice.contact_set import ContactSet, judged, totals
from discretization.lattice.nodes import Lattice
from discretization.lattice.obstacle import obstacle
from discretization.lattice.oracle import Oracle
from discretization.lattice.radial_lowest import lowest_rings, where_contact_pays
from discretization.lattice.shortest_path import global_minimum, window
from discretization.lattice.sums import Sums
from energy import Scene

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Pair = tuple[line.Line, line.Line]  # left and right line of a contact
_UNKNOWN = dict.fromkeys(QUANTITIES, math.nan)


def on_lowest(
    scene: Scene,
    depth: float,
    branch: str,
    lattice: Lattice,
    where: fronts.Region,
    method: str,
    margin: bool,
) -> Equilibrium:
    """Certified state of lowest energy of all contact sets on these nodes.

    ValueError for finite slopes, what the method cannot express, and a contact that reaches the end
    of the known profile.
    """
    nodes, proof = lowest_contacts(scene, depth, lattice, method, margin)
    name = "shortest_path" if method == "lattice" and proof else method
    state = of_contacts(scene, depth, branch, lattice, where, nodes)
    return replace(state, proof=proof, method=name)


def lowest_contacts(
    scene: Scene, depth: float, lattice: Lattice, method: str, margin: bool
) -> tuple[Nodes, Proof | None]:
    """First and last nodes (m, 2) of the contacts of lowest energy, and the proof if there is one.

    ValueError as `on_lowest`.
    """
    if scene.slopes != "small":
        raise ValueError(
            f"slopes = {scene.slopes!r} has no search over all contact sets: use slopes='small', "
            "or for a convex indenter method='fitted'"
        )
    if not scene.gamma1:
        raise ValueError(
            f"gamma1 = 0 leaves no links to search over: use 'lattice', not {method!r}"
        )
    if scene.axisymmetric:
        scene = lattice.seen(scene)
        row = where_contact_pays(
            scene, depth, lattice, fronts.region(lattice, scene.indenter, depth)
        )
        return lowest_rings(row, depth)[0], None
    first, g = window(lattice, scene.indenter, depth)
    nodes, proof = _search(lattice, g, method, margin)
    return nodes + first, proof


def of_contacts(
    scene: Scene, depth: float, branch: str, lattice: Lattice, where: fronts.Region, nodes: Nodes
) -> Equilibrium:
    """The certified state with contacts between these first and last nodes (m, 2).

    NotCertifiedError if it is no equilibrium; ValueError as `on_lowest`.
    """
    if not nodes.size:
        return without_contact(scene, depth, branch, lattice, where)
    refuse_unknown(scene, depth, lattice, where, nodes)
    contacts = ContactSet.of(lattice, scene.indenter, depth, where, nodes)
    sums = totals(contacts)
    certificate = passed(depth, judged(contacts, sums))
    lines = _lines(lattice, scene, depth, where, nodes)
    return state_of(scene, depth, branch, lattice, nodes.tolist(), sums, certificate, lines)


def without_contact(
    scene: Scene, depth: float, branch: str, lattice: Lattice, where: fronts.Region
) -> Equilibrium:
    """The certified flat surface. NotCertifiedError if the indenter would be in it."""
    certificate = passed(depth, judgement.detached(lattice, scene.indenter, depth, where))
    return detached(scene, depth, branch, lattice.tail, certificate, lattice.spacing)


def _search(lattice: Lattice, g: Array, method: str, margin: bool) -> tuple[Nodes, Proof | None]:
    """First and last node of each contact (m, 2), and the proof if there is one."""
    if method == "oracle":
        g = np.append(g, -math.inf)  # it needs two nodes
        kind = "integer" if lattice.w else "convex"
        return span.runs(Oracle(lattice, g.size, kind).solve(g).contact), None
    if method == "lattice" and not lattice.w:
        contact = obstacle(lattice, g).contact
        return span.runs(contact if contact.any() else g == 0), None
    found = global_minimum(lattice, g, margin=margin)
    return found.contacts, found.proof


def refuse_unknown(
    scene: Scene, depth: float, lattice: Lattice, where: fronts.Region, nodes: Nodes
) -> None:
    """ValueError for a contact at an end of the profile that is not the end of the body."""
    indenter = scene.indenter
    reached = ((nodes[0, 0], where.first), (nodes[-1, 1], where.last))
    for (node, limit), end in zip(reached, indenter.extent, strict=True):
        if node == limit and end not in indenter.walls:
            raise ValueError(fronts.unknown(lattice, depth, int(node)))


def passed(depth: float, certificate: Certificate) -> Certificate:
    """The certificate. NotCertifiedError if it failed."""
    if not certificate.ok:
        raise NotCertifiedError(
            f"the state found at depth = {depth!r} violates "
            f"{', '.join(certificate.failures)} ({certificate}): rounding has spoilt it, or the "
            "solver's tolerance; try another spacing or method"
        )
    return certificate


def state_of(
    scene: Scene,
    depth: float,
    branch: str,
    lattice: Lattice,
    nodes: Sequence[Sequence[int]],
    sums: Sums,
    certificate: Certificate,
    lines: list[Pair],
) -> Equilibrium:
    """The state with these contacts: first and last node, left and right line of each."""
    both = [end for pair in lines for end in pair]
    return Equilibrium(
        scene=scene,
        depth=depth,
        contacts=np.array([_interval(*pair) for pair in lines]),
        nodes=np.array([[lattice.x(first), lattice.x(last)] for first, last in nodes]),
        pinned=np.array([[left.pinned, right.pinned] for left, right in lines]),
        force=sum((end.force for end in both), start=sums.force),
        energy=sum((end.energy for end in both), start=sums.energy),
        certificate=certificate,
        tail=lattice.tail,
        scales={"force": sums.force_scale, "energy": sums.energy_scale},
        errors=_UNKNOWN,
        method="lattice",
        branch=branch,
        spacing=lattice.spacing,
    )


def _interval(left: line.Line, right: line.Line) -> list[float]:
    """x of both lines; their middle if the contact is smaller than interpolation resolves."""
    return [left.x, right.x] if left.x <= right.x else 2 * [(left.x + right.x) / 2]


def _lines(
    lattice: Lattice, scene: Scene, depth: float, where: fronts.Region, nodes: Nodes
) -> list[Pair]:
    """Left and right line of each contact."""
    indenter, reach, rows = scene.indenter, lattice.critical_gap, nodes.tolist()
    if len(rows) == 1:
        contact = fronts.Contact(rows[0][0], rows[0][1], reach)
        ends = line.ends_of(lattice, indenter, depth, where, contact)
        return [line.outer(lattice, indenter, reach, ends)]
    (a, b), (c, d) = rows[0], rows[-1]
    found = [line.raw(lattice, indenter, a), line.raw(lattice, indenter, d)]
    if a < b:
        found[0] = line.recover(lattice, indenter, depth, (where.first, b), a, -1, reach)
    if c < d:
        found[1] = line.recover(lattice, indenter, depth, (c, where.last), d, 1, reach)
    for one, other in itertools.pairwise(rows):
        found[-1:-1] = line.between(lattice, indenter, depth, one, other)
    return list(zip(found[::2], found[1::2], strict=True))
