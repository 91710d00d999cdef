"""The metastable state of several contacts on the lattice: the end of the path that leads there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from discretization.equilibrium import Equilibrium
from discretization.lattice import fronts
from discretization.lattice.changes import pressed, retracted
from discretization.lattice.judgement import certify
from discretization.lattice.lowest import of_contacts, refuse_unknown
from discretization.lattice.nodes import Lattice
from discretization.lattice.row import Row
from discretization.lattice.rules import Rules
from discretization.lattice.sums import measured
from energy import Scene


def on_path(
    scene: Scene, depth: float, lattice: Lattice, where: fronts.Region
) -> Equilibrium | None:
    """The certified state of the contacts on this path; None where there is only one on the way.

    NotCertifiedError and ValueError as `of_contacts`.
    """
    nodes = contacts_on_path(scene, depth, lattice, where)
    if nodes is None:
        return None
    return of_contacts(scene, depth, "adhered", lattice, where, nodes)


def contacts_on_path(
    scene: Scene, depth: float, lattice: Lattice, where: fronts.Region
) -> NDArray[np.int64] | None:
    """Contacts (m, 2) of the path that touches first and then moves to this depth.

    None where there is only one contact on the way, that of fronts.py, or where the path cannot
    be followed.
    """
    if scene.indenter.convex or scene.slopes != "small" or not scene.work_of_adhesion:
        return None
    if not scene.gamma1 or scene.pattern is not None or scene.opening is not None:
        return None
    deepest = max(depth, fronts.height(lattice, scene.indenter, where.lowest))
    contact = fronts.adhered(lattice, scene.indenter, deepest, where)
    alone = contact is not None and _alone(scene, deepest, lattice, where, contact)
    if contact is not None and alone and not _torn(scene, depth, lattice, contact):
        return None
    row = Row.of(scene, lattice, where, deepest)
    closing, opening = row.rules
    nodes = pressed(closing, (), deepest, row.touch)
    refuse_unknown(scene, deepest, lattice, where, np.array(nodes) + row.first)
    if depth < deepest:
        nodes = retracted(opening, nodes, depth)
    return np.array(nodes, np.int64).reshape(-1, 2) + row.first


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
    judged = certify(lattice, scene.indenter, depth, where, contact, sums)
    return judged.ok and judged.penetration == 0
