"""States of the path that touches first, and then is moved to its depth.

Contacts of a convex profile are alone all the way, and found without following the path.
"""

from __future__ import annotations

import functools

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
from discretization.lattice.between import Lines, moved_lines
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.ground import Ground
from discretization.lattice.row import Contacts, Row
from discretization.lattice.totals import totals
from discretization.lattice.walk import Walk


def on_one_contact(asked: Question, ground: Ground) -> Equilibrium:
    """The certified state of one contact of a convex profile, or none; errors as `of_contacts`."""
    depth, lattice = asked.depth, ground.lattice
    found = fronts.adhered(lattice, ground.indenter, depth, ground.where)
    if found is None:
        return without_contact(asked, ground)
    raised = asked.branch == "global" and depth <= ground.lowest
    if raised and totals(ContactSet(ground, (found,), depth)).energy > 0:
        return without_contact(asked, ground)
    return of_contacts(asked, ground, [found])


def on_path(asked: Question, ground: Ground) -> Equilibrium:
    """The certified state of the contacts on this path. NotCertifiedError and ValueError as there.

    With adhesion that differs from link to link, or when a contact is opened, and around an axis
    lines are those of paths.
    """
    scene, lattice = asked.scene, ground.lattice
    row, nodes, lines = _followed(asked, ground)
    if not nodes:
        return without_contact(asked, ground)
    same = scene.pattern is None and scene.opening is None
    if lattice.axis == 0 or not same:
        return of_row(asked, ground, row, nodes, lines)
    return of_contacts(asked, ground, np.array(nodes) + row.first)


def _followed(asked: Question, ground: Ground) -> tuple[Row, Contacts, Lines | None]:
    """The nodes there may be in contact, and the contacts among them on this path.

    Also where their lines are, if that depends on the way. ValueError where the path leads to an
    end of the known profile.
    """
    deepest = max(asked.depth, ground.lowest)
    row = Row.of(asked.scene, ground, deepest)
    walk = Walk(row)
    nodes = walk.touched(deepest)
    refuse_unknown(ground, deepest, row.first + nodes[0][0], row.first + nodes[-1][1])
    moved = functools.partial(moved_lines, row, ground.indenter)
    remembers = asked.scene.hysteretic
    lines = moved(nodes, deepest, None) if remembers else None
    if asked.depth < deepest:
        before = None if lines is None else (nodes, lines)
        nodes = walk.moved(nodes, asked.depth)
        lines = moved(nodes, asked.depth, before) if remembers and nodes else None
    return row, nodes, lines
