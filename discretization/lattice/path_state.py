"""States of the path that touches first, and then is moved to its depth.

A contact that was alone all the way is found without following the path.
"""

from __future__ import annotations

import numpy as np

from discretization.equilibrium import Equilibrium
from discretization.lattice import fronts
from discretization.lattice.assembly import (
    Question,
    of_contacts,
    of_row,
    refuse_unknown,
    without_contact,
)
from discretization.lattice.changes import Contacts, pressed, retracted
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.ground import Ground
from discretization.lattice.judge import judge
from discretization.lattice.row import Row
from discretization.lattice.rules import Rules
from discretization.lattice.totals import totals


def on_one_contact(asked: Question, ground: Ground) -> Equilibrium:
    """The certified state of one contact or none. ValueError or NotCertifiedError for others."""
    depth, where = asked.depth, ground.where
    found = fronts.adhered(ground.lattice, ground.indenter, depth, where)
    if found is None:
        return without_contact(asked, ground)
    raised = asked.branch == "global" and depth <= ground.lowest
    if raised and totals(ContactSet(ground, (found,), depth)).energy > 0:
        return without_contact(asked, ground)
    return of_contacts(asked, ground, [found])


def on_path(asked: Question, ground: Ground) -> Equilibrium:
    """The certified state of the contacts on this path. NotCertifiedError and ValueError as there.

    With adhesion that differs from link to link, or when a contact is opened, around an axis and
    with finite slopes the path is always followed.
    """
    scene, lattice = asked.scene, ground.lattice
    same = scene.pattern is None and scene.opening is None
    if lattice.axis == 0 or lattice.slopes == "finite" or not same:
        row, nodes = _followed(asked, ground)
        return of_row(asked, ground, row, nodes) if nodes else without_contact(asked, ground)
    if _alone(asked, ground):
        return on_one_contact(asked, ground)
    row, nodes = _followed(asked, ground)
    return of_contacts(asked, ground, np.array(nodes).reshape(-1, 2) + row.first)


def _followed(asked: Question, ground: Ground) -> tuple[Row, Contacts]:
    """The nodes there may be in contact, and the contacts among them on this path.

    ValueError where the path leads to an end of the known profile.
    """
    deepest = max(asked.depth, ground.lowest)
    row = Row.of(asked.scene, ground, deepest)
    closing, opening = row.rules
    nodes = pressed(closing, (), deepest, row.touch)
    refuse_unknown(ground, deepest, row.first + nodes[0][0], row.first + nodes[-1][1])
    return row, retracted(opening, nodes, asked.depth) if asked.depth < deepest else nodes


def _alone(asked: Question, ground: Ground) -> bool:
    """Whether there is only one contact, never torn, on the way from first touch to this depth.

    v = u - g falls with the depth and with every node that comes into contact. So no other contact
    has begun if v >= 0 now, and if v > 0 at each node just before the line came there: with the
    line on the node before, at the largest depth D_j it had waited for until then,

        max D_i (i < j) < f_j + (f_{j+1} - f_j)/(1 - λ).
    """
    lattice, where, deepest = ground.lattice, ground.where, max(asked.depth, ground.lowest)
    contact = fronts.adhered(lattice, ground.indenter, deepest, where)
    if contact is None:
        return False
    for end in contact:
        f = ground.heights(where.lowest, end)
        touches = f[:-1] + np.diff(f) / lattice.loss
        passes = touches - lattice.critical_gap / lattice.loss
        arrival = np.maximum.accumulate(np.append(f[0], passes))[:-1]
        if (touches <= arrival)[1:].any():
            return False
    contacts = ContactSet(ground, (contact,), deepest)
    found = judge(contacts, totals(contacts))
    if not found.ok or found.penetration:
        return False
    f = ground.heights(*contact)
    rules = Rules(lattice, f, np.full(f.size - 1, lattice.w * lattice.spacing))
    return f.size < 3 or rules.tears(0, f.size - 1)[0] <= asked.depth
