"""States of several contacts on a row of nodes: the end of the path that leads there.

Around the axis also those of lowest energy.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Proof
from discretization.equilibrium import Equilibrium
from discretization.lattice import fronts, line
from discretization.lattice.between import interpolated
from discretization.lattice.changes import pressed, retracted
from discretization.lattice.contact_set import ContactSet, judged, totals
from discretization.lattice.judgement import certify
from discretization.lattice.lowest import (
    of_contacts,
    passed,
    refuse_unknown,
    state_of,
    without_contact,
)
from discretization.lattice.nodes import Lattice
from discretization.lattice.radial_lowest import lowest_rings, where_contact_pays
from discretization.lattice.row import Row
from discretization.lattice.rules import Rules
from discretization.lattice.sums import Sums, measured
from energy import Scene


def on_path(
    scene: Scene, depth: float, lattice: Lattice, where: fronts.Region
) -> Equilibrium | None:
    """The certified state of the contacts on this path; None where there is only one on the way.

    NotCertifiedError and ValueError as `of_contacts`.
    """
    same = scene.pattern is None and scene.opening is None
    if lattice.axis == 0 or lattice.slopes == "finite" or not same:
        return _held(scene, depth, lattice, where)
    nodes = contacts_on_path(scene, depth, lattice, where)
    if nodes is None:
        return None
    return of_contacts(scene, depth, "adhered", lattice, where, nodes)


def _held(scene: Scene, depth: float, lattice: Lattice, where: fronts.Region) -> Equilibrium:
    """The state with adhesion that differs from link to link, or when a contact is opened.

    Also any with rotational symmetry, or finite slopes.
    """
    row, nodes = _followed(scene, depth, lattice, where)
    if not nodes.size:
        return without_contact(scene, depth, "adhered", lattice, where)
    return _of_row(scene, depth, "adhered", row, nodes)[0]


def on_lowest_rings(
    scene: Scene, depth: float, lattice: Lattice, where: fronts.Region
) -> Equilibrium:
    """The certified state of lowest energy of all contact sets around the axis, with its proof.

    ValueError for too many nodes, and for a contact that reaches an end of the known profile.
    """
    row = where_contact_pays(scene, depth, lattice, where)
    nodes, bound = lowest_rings(row, depth)
    if not nodes.size:
        state, attained, scale = without_contact(scene, depth, "global", lattice, where), 0.0, 0.0
    else:
        refuse_unknown(scene, depth, lattice, where, nodes + row.first)
        state, sums = _of_row(scene, depth, "global", row, nodes)
        attained, scale = sums.energy, sums.energy_scale
    proof = Proof(bound, attained, scale, margin=math.nan)
    return replace(state, proof=proof, method="shortest_path")


def _of_row(
    scene: Scene, depth: float, branch: str, row: Row, nodes: NDArray[np.int64]
) -> tuple[Equilibrium, Sums]:
    """The certified state of these contacts of a row, and its sums over the nodes."""
    contacts = ContactSet.on_row(row, depth, nodes)
    sums = totals(contacts)
    certificate = passed(depth, judged(contacts, sums))
    found = interpolated(row, scene.indenter, nodes.reshape(1, -1), np.array([depth]))
    corners = scene.indenter.corners
    lines = [line.Line(x, 0.0, 0.0, x in corners) for x in found[0][0].tolist()]
    pairs = list(zip(lines[::2], lines[1::2], strict=True))
    own = (nodes + row.first).tolist()
    state = state_of(scene, depth, branch, row.lattice, own, sums, certificate, pairs)
    return replace(state, force=float(found[1][0]), energy=float(found[2][0])), sums


def contacts_on_path(
    scene: Scene, depth: float, lattice: Lattice, where: fronts.Region
) -> NDArray[np.int64] | None:
    """Contacts (m, 2) of the path that touches first and then moves to this depth.

    None where there is only one contact on the way, that of fronts.py, or where the path cannot
    be followed.
    """
    if scene.indenter.convex or not (scene.work_of_adhesion and scene.gamma1):
        return None
    deepest = max(depth, fronts.height(lattice, scene.indenter, where.lowest))
    contact = fronts.adhered(lattice, scene.indenter, deepest, where)
    alone = contact is not None and _alone(scene, deepest, lattice, where, contact)
    if contact is not None and alone and not _torn(scene, depth, lattice, contact):
        return None
    row, nodes = _followed(scene, depth, lattice, where)
    return nodes + row.first


def _followed(
    scene: Scene, depth: float, lattice: Lattice, where: fronts.Region
) -> tuple[Row, NDArray[np.int64]]:
    """The nodes there may be in contact, and the contacts (m, 2) among them on this path.

    ValueError where the path leads to an end of the known profile.
    """
    deepest = max(depth, fronts.height(lattice, scene.indenter, where.lowest))
    row = Row.of(scene, lattice, where, deepest)
    closing, opening = row.rules
    nodes = pressed(closing, (), deepest, row.touch)
    refuse_unknown(scene, deepest, lattice, where, np.array(nodes) + row.first)
    if depth < deepest:
        nodes = retracted(opening, nodes, depth)
    return row, np.array(nodes, np.int64).reshape(-1, 2)


def _torn(scene: Scene, depth: float, lattice: Lattice, contact: fronts.Contact) -> bool:
    """Whether a node inside a contact is torn open on the way from first touch to this depth."""
    nodes = np.arange(contact.first, contact.last + 1, dtype=float)
    work = np.full(nodes.size - 1, lattice.w * lattice.spacing)
    rules = Rules(lattice, fronts.heights(lattice, scene.indenter, nodes), work)
    return nodes.size > 2 and rules.tears(0, nodes.size - 1)[0] > depth


def _alone(
    scene: Scene, depth: float, lattice: Lattice, where: fronts.Region, contact: fronts.Contact
) -> bool:
    """Whether a contact pressed from first touch to this depth was alone all the way.

    v = u - g falls with the depth and with every node that comes into contact. So no other contact
    has begun if v >= 0 now, and if v > 0 at each node just before the line came there: with the
    line on the node before, at the largest depth D_j it had waited for until then,

        max D_i (i < j) < f_j + (f_{j+1} - f_j)/(1 - λ).
    """
    for end in contact[:2]:
        side = 1 if end >= where.lowest else -1
        nodes = np.arange(where.lowest, end + side, side, dtype=float)
        f = fronts.heights(lattice, scene.indenter, nodes)
        touches = f[:-1] + np.diff(f) / lattice.loss
        passes = touches - lattice.critical_gap / lattice.loss
        arrival = np.maximum.accumulate(np.append(f[0], passes))[:-1]
        if (touches <= arrival)[1:].any():
            return False
    sums = measured(lattice, scene.indenter, depth, contact)
    found = certify(lattice, scene.indenter, depth, where, contact, sums)
    return found.ok and found.penetration == 0
