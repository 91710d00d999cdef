"""States of lowest energy on the lattice, with any number of contacts (small slopes).

method           contact set from                     proof of the minimum
"lattice"        obstacle.py where w = 0,             the certificate: the problem is convex
                 else as "shortest_path"
"shortest_path"  shortest_path.py, radial_lowest.py   `Proof`: bound attained, margin
"oracle"         oracle.py, with cvxpy                the solver's
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Proof
from discretization.equilibrium import Equilibrium
from discretization.lattice import span
from discretization.lattice.assembly import Question, of_contacts, of_row, without_contact
from discretization.lattice.ground import Ground
from discretization.lattice.nodes import Lattice
from discretization.lattice.obstacle import obstacle
from discretization.lattice.oracle import Oracle
from discretization.lattice.radial_lowest import lowest_rings
from discretization.lattice.row import Row
from discretization.lattice.shortest_path import global_minimum, window
from discretization.lattice.totals import totals
from energy import Scene

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]


def on_lowest(asked: Question, ground: Ground) -> Equilibrium:
    """Certified state of lowest energy of all contact sets on these nodes.

    ValueError for finite slopes, what the method cannot express, and a contact that reaches the end
    of the known profile.
    """
    scene, method = asked.scene, asked.method
    nodes, proof = lowest_contacts(scene, asked.depth, ground.lattice, method)
    name = "shortest_path" if method == "lattice" and proof else method
    return replace(of_contacts(asked, ground, nodes), proof=proof, method=name)


def on_lowest_rings(asked: Question, ground: Ground) -> Equilibrium:
    """The certified state of lowest energy of all contact sets around the axis, with its proof.

    ValueError for too many nodes, and for a contact that reaches an end of the known profile.
    """
    row = _around_axis(asked.scene, ground, asked.depth)
    nodes, bound = lowest_rings(row, asked.depth)
    attained = scale = 0.0
    if nodes.size:
        state = of_row(asked, ground, row, nodes.tolist())
        sums = totals(row.contacts(ground, nodes.tolist(), asked.depth))
        attained, scale = sums.energy, sums.energy_scale
    else:
        state = without_contact(asked, ground)
    proof = Proof(bound, attained, scale)
    return replace(state, proof=proof, method="shortest_path")


def lowest_contacts(
    scene: Scene, depth: float, lattice: Lattice, method: str
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
        seen = lattice.seen(scene)
        ground = Ground.of(lattice, seen.indenter, depth)
        return lowest_rings(_around_axis(seen, ground, depth), depth)[0], None
    first, g = window(lattice, scene.indenter, depth)
    nodes, proof = _search(lattice, g, method)
    return nodes + first, proof


def _around_axis(scene: Scene, ground: Ground, depth: float) -> Row:
    """All known nodes; of a convex profile those that a contact reaches which is only touched."""
    return Row.of(scene, ground, max(depth, ground.lowest))


def _search(lattice: Lattice, g: Array, method: str) -> tuple[Nodes, Proof | None]:
    """First and last node of each contact (m, 2), and the proof if there is one."""
    if method == "oracle":
        g = np.append(g, -math.inf)  # it needs two nodes
        kind = "integer" if lattice.w else "convex"
        return span.runs(Oracle(lattice, g.size, kind).solve(g).contact), None
    if method == "lattice" and not lattice.w:
        contact = obstacle(lattice, g).contact
        return span.runs(contact if contact.any() else g == 0), None
    found = global_minimum(lattice, g)
    return found.contacts, found.proof
