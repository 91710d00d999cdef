"""From contact nodes to an equilibrium: totals, certificate, and lines between the nodes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.lattice import line
from discretization.lattice.judge import State, judge, totals
from discretization.nodes.lattice import LatticeTail
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.obstacle import surface
from discretization.nodes.row import Contacts, Row
from energy import Scene
from energy.arrays import Array

_INDIFFERENT = 1e-10  # of wΔx: what a line may pay for a link if it rests anywhere at no cost
_UNKNOWN = dict.fromkeys(QUANTITIES, math.nan)


@dataclass(frozen=True)
class Question:
    """What is asked of a scene as far as it has nodes; the arguments are those of `on_lattice`."""

    scene: Scene
    depth: float
    branch: str
    method: str = "lattice"


def on_row(row: Row, nodes: Contacts, depth: float) -> State:
    """Contacts between these first and last nodes of a row, from left to right, at a depth.

    In contact u = g = d - f; the free surfaces are exact. Of one contact of a convex profile its
    own nodes, with tails beyond; of others all.
    """
    own = slice(nodes[0][0], nodes[-1][1] + 1) if row.clear else slice(0, row.size)
    held = np.zeros(own.stop - own.start, bool)
    for first, last in nodes:
        held[first - own.start : last - own.start + 1] = True
    work = row.works[0] * row.bonds[own.start : own.stop - 1] if row.scene.pattern else None
    model, g = NodalEnergy(row.lattice, held, row.first + own.start, work), depth - row.f[own]
    u, at, lines = g, np.reshape(nodes, (1, -1)), np.unique(nodes)
    if not row.clear:
        every, ends = row.first + np.arange(row.size), depth - row.f[lines]
        u = np.where(held, g, surface(row.lattice, row.first + lines, ends, every))
    passed, link = line.advances(row, at, np.array([depth])), -line.LINKS[0]
    both = np.repeat(at[0, 2::2] - at[0, 1:-1:2] == 2, 2)  # the last two links of a gap
    passed.bonds[0, 1:-1, link] += np.where(both, passed.bonds[0, 1:-1, link + 1], 0.0)
    faced: list[Any] = [None, *at[0].tolist(), None]
    closes = np.full(at.size, True)
    for i, side in enumerate(line.outwards(at.size).tolist()):
        left, right = (faced[i + 1] + side, faced[i + 1 + side])[::side]  # after the next link
        closes[i] = row.rules[0].clears(left, right, depth)
    return State(row, depth, model, u, g, passed, closes)


def without_contact(asked: Question, row: Row) -> Equilibrium:
    """The certified flat surface. NotCertifiedError if the indenter would be in it."""
    scene, depth, lattice = asked.scene, asked.depth, row.lattice
    scale = max(abs(depth), scene.critical_separation) or 1.0
    certificate = Certificate.undeformed(max(0.0, (depth - row.lowest) / scale))
    _demand(asked, certificate)
    return detached(scene, depth, asked.branch, lattice.tail, certificate, lattice.spacing)


def of_contacts(
    asked: Question, row: Row, nodes: Contacts, known: Sequence[float] | None = None
) -> Equilibrium:
    """The certified state with contacts between these first and last nodes of the row.

    known: where the lines are, which has to be known where they resist both ways.
    NotCertifiedError if it is no equilibrium; ValueError for a contact that reaches the end of the
    known profile.
    """
    if not nodes:
        return without_contact(asked, row)
    row.refuse_unknown(asked.depth, nodes)
    at, depth = np.reshape(nodes, (1, -1)), np.array([asked.depth])
    found = line.between(row, at, depth, None if known is None else np.array([known]))
    return certified(asked, on_row(row, nodes, asked.depth), nodes, *found, row.lattice.tail)


def certified(
    asked: Question,
    state: State,
    nodes: Contacts,
    passed: line.Advances,
    zeta: Array,
    lines: Array,
    tail: LatticeTail,
) -> Equilibrium:
    """The state with contacts between these nodes, whose lines are ζ further, and their x (1, 2m).

    passed: what lines that pass links change. NotCertifiedError.
    """
    row, at, sums = state.row, np.reshape(nodes, (1, -1)), totals(state)
    certificate, lattice = judge(state, sums), row.lattice
    _demand(asked, certificate)
    energy, force = line.gained(row, at, passed, zeta)[:, 0].tolist()
    contacts = lines.reshape(-1, 2)
    return Equilibrium(
        scene=asked.scene,
        depth=asked.depth,
        contacts=contacts,
        nodes=lattice.x(row.first + np.array(nodes)),
        pinned=np.isin(contacts, row.scene.indenter.corners),
        force=sums.force + force,
        energy=sums.energy + energy,
        certificate=certificate,
        surfaces=tail,
        scales={"force": sums.force_scale, "energy": sums.energy_scale},
        errors=_UNKNOWN,
        method="lattice",
        branch=asked.branch,
        spacing=lattice.spacing,
        neutral=len(nodes) == 1 and not asked.scene.hysteretic and _neutral(row, passed),
    )


def _neutral(row: Row, passed: line.Advances) -> bool:
    """Whether moving a line of a single contact inwards by several links costs nothing."""
    inside = np.s_[0, -1, : -line.LINKS[0]]
    gap, energy = passed.gap[inside], (passed.stored - row.works[0] * passed.bonds)[inside]
    least = _INDIFFERENT * row.lattice.w * row.lattice.cell
    return least > 0 and bool(((gap > 0) & (np.abs(energy) <= least)).all())


def _demand(asked: Question, certificate: Certificate) -> None:
    certificate.demand(
        f"the state found at depth = {asked.depth!r}",
        "rounding has spoilt it, or the solver's tolerance, or a profile that is said to be convex "
        "is not; try another spacing or method",
    )
