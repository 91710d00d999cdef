"""The metastable state of several contacts on the lattice: the end of the path that leads there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from discretization.equilibrium import Equilibrium
from discretization.lattice import fronts
from discretization.lattice.judgement import certify
from discretization.lattice.lowest import of_contacts
from discretization.lattice.many_contacts import ManyContacts
from discretization.lattice.nodes import Lattice
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
    """Contacts (m, 2) of the path that touches first and then moves to this depth, event by event.

    None where there is only one contact on the way, that of fronts.py: where it is in equilibrium
    at the largest depth of the path, no other has begun before, as v = u - g falls with the depth
    and with every node that comes into contact. None, too, where `ManyContacts` cannot follow.
    """
    if scene.indenter.convex or scene.slopes != "small" or not scene.work_of_adhesion:
        return None
    if not scene.gamma1 or scene.pattern is not None or scene.opening is not None:
        return None
    deepest = max(depth, fronts.height(lattice, scene.indenter, where.lowest))
    contact = fronts.adhered(lattice, scene.indenter, deepest, where)
    if contact is not None:
        sums = measured(lattice, scene.indenter, deepest, contact)
        if certify(lattice, scene.indenter, deepest, where, contact, sums).ok:
            return None
    branch = ManyContacts.of(scene, lattice.spacing, deepest, lattice.origin)
    return branch.reached(depth)
