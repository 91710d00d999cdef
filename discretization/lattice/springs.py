"""γ₁ = 0 with any number of contacts: every node is a spring of its own.

branch "global"    attached iff g >= 0 or k g²/2 <= w, that is g >= -δ₀
branch "adhered"   touched first, then moved to this depth: attached iff g >= 0; below touching
                   only the nodes touched, those of least f, while they are pulled by <= δ₀
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.equilibrium import Equilibrium
from discretization.lattice import fronts, line, span
from discretization.lattice.assembly import Pair, Question, of_contacts, without_contact
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.ground import Ground
from discretization.lattice.lowest import window
from discretization.lattice.nodes import Lattice

Nodes = NDArray[np.int64]
_TIE = 1e-12  # of the level: springs that rounding alone keeps from attaching


def on_springs(asked: Question, ground: Ground) -> Equilibrium:
    """Certified state of independent springs on this branch; see the module."""
    lattice, body, depth = ground.lattice, ground.indenter, asked.depth
    reach = _reach(lattice, asked.branch, depth - ground.lowest)
    level = depth + reach * (1 + _TIE)
    if level < ground.lowest:
        return without_contact(asked, ground)
    if body.convex:
        nodes = np.array([fronts.below(lattice, body, ground.where, level)])
    else:
        first, g = window(lattice, body, depth)
        nodes = span.runs(depth - g <= level) + first
    return of_contacts(asked, ground, nodes, _lines(ground, depth, nodes, reach))


def _reach(lattice: Lattice, branch: str, highest: float) -> float:
    """How far attached nodes may be pulled; -inf if there are none. highest: the largest g."""
    most = lattice.critical_gap
    pulled = most if branch == "global" else max(0.0, -highest)
    return pulled if -highest <= most * (1 + _TIE) else -math.inf


def _lines(ground: Ground, depth: float, nodes: Nodes, reach: float) -> list[Pair]:
    """Left and right line of each contact, each found as if it were alone."""
    if len(nodes) == 1:
        return [line.outer(ground, reach, ContactSet(ground, nodes.tolist(), depth).outer)]
    before = np.append(ground.where.first, nodes[:-1, 1] + 1).tolist()
    after = np.append(nodes[1:, 0] - 1, ground.where.last).tolist()
    return [
        (
            line.recover(ground, depth, (lo, hi), first, -1, reach),
            line.recover(ground, depth, (lo, hi), last, 1, reach),
        )
        for (first, last), lo, hi in zip(nodes.tolist(), before, after, strict=True)
    ]
