"""From contact nodes to an equilibrium: totals, certificate, and lines between the nodes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.lattice.between import Ends, Lines, ends_of, lines_between
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.judge import Totals, judge, judge_apart, totals
from discretization.lattice.stencil import INWARDS
from discretization.nodes.ground import unknown
from discretization.nodes.lattice import LatticeTail
from discretization.nodes.row import Contacts, Row
from energy import Scene

_INDIFFERENT = 1e-10  # of wΔx: what a line may pay for a link if it rests anywhere at no cost
_UNKNOWN = dict.fromkeys(QUANTITIES, math.nan)


@dataclass(frozen=True)
class Question:
    """What is asked of a scene as far as it has nodes; the arguments are those of `on_lattice`."""

    scene: Scene
    depth: float
    branch: str
    method: str = "lattice"


def without_contact(asked: Question, row: Row) -> Equilibrium:
    """The certified flat surface. NotCertifiedError if the indenter would be in it."""
    certificate, lattice = judge_apart(row, asked.depth), row.lattice
    _demand(asked, certificate)
    return detached(
        asked.scene, asked.depth, asked.branch, lattice.tail, certificate, lattice.spacing
    )


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
    refuse_unknown(row, asked.depth, nodes)
    contacts, depth = ContactSet(row, nodes, asked.depth), np.array([asked.depth])
    sums, held = totals(contacts), None if known is None else np.array([known])
    certificate = judge(contacts, sums)
    lines = lines_between(row, np.reshape(nodes, (1, -1)), depth, known=held, lone=held is None)
    neutral = False
    if len(nodes) == 1 and asked.depth < row.lowest and not asked.scene.hysteretic:
        first, last, end = np.array([[*nodes[0], row.size - 1]]).T
        neutral = is_neutral(row, ends_of(row, depth, last, 1, (first, end)))
    return certified(asked, row, nodes, lines, sums, certificate, row.lattice.tail, neutral=neutral)


def certified(
    asked: Question,
    row: Row,
    nodes: Contacts,
    lines: Lines,
    sums: Totals,
    certificate: Certificate,
    tail: LatticeTail,
    *,
    neutral: bool = False,
) -> Equilibrium:
    """The state with contacts between these nodes, whose lines are there. NotCertifiedError."""
    _demand(asked, certificate)
    lattice = row.lattice
    return Equilibrium(
        scene=asked.scene,
        depth=asked.depth,
        contacts=lines.x.reshape(-1, 2),
        nodes=lattice.x(row.first + np.array(nodes)),
        pinned=lines.pinned.reshape(-1, 2),
        force=sums.force + float(lines.added[1, 0]),
        energy=sums.energy + float(lines.added[0, 0]),
        certificate=certificate,
        tail=tail,
        scales={"force": sums.force_scale, "energy": sums.energy_scale},
        errors=_UNKNOWN,
        method="lattice",
        branch=asked.branch,
        spacing=lattice.spacing,
        neutral=neutral,
    )


def is_neutral(row: Row, ends: Ends) -> bool:
    """Whether moving a line inwards by several links costs nothing."""
    bond = row.lattice.w * row.lattice.cell
    costless = (np.abs(ends.energy) <= _INDIFFERENT * bond) & (ends.closing > -math.sqrt(bond))
    return bool(bond and (ends.known & costless)[0, :INWARDS].all())


def refuse_unknown(row: Row, depth: float, nodes: Contacts) -> None:
    """ValueError for contacts at an end of the profile that is not the end of the body."""
    ends = (nodes[0][0], 0), (nodes[-1][1], row.size - 1)
    for (node, limit), end in zip(ends, row.indenter.extent, strict=True):
        if node == limit and end not in row.indenter.walls:
            raise ValueError(unknown(row.lattice, depth, row.first + node))


def _demand(asked: Question, certificate: Certificate) -> None:
    certificate.demand(
        f"the state found at depth = {asked.depth!r}",
        "rounding has spoilt it, or the solver's tolerance, or a profile that is said to be convex "
        "is not; try another spacing or method",
    )
