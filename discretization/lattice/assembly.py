"""From contact nodes to an equilibrium: totals, certificate, and lines between the nodes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.lattice import line
from discretization.lattice.between import interpolated
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.judge import Totals, judge, judge_apart, totals
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
    contacts, scene = ContactSet.of(row, nodes, asked.depth), asked.scene
    sums, tail, neutral = totals(contacts), row.lattice.tail, False
    certificate = judge(contacts, sums)
    if scene.opening is not None or scene.pattern is not None:
        lines, force, energy = _between(row, asked.depth, nodes, known)
        sums = sums._replace(force=force, energy=energy)
    elif len(nodes) > 1:
        lines = line.lines_of(row, asked.depth, nodes)
    else:
        ends = _ends(contacts)
        lines = line.outer(row, row.lattice.critical_gap, ends)
        neutral = is_neutral(row, nodes, ends[0])
    return certified(asked, row, nodes, lines, sums, certificate, tail, neutral=neutral)


def _between(
    row: Row, depth: float, nodes: Contacts, known: Sequence[float] | None
) -> tuple[list[line.Line], float, float]:
    """Lines of contacts whose adhesion differs, as on paths; P and U."""
    at, held = np.reshape(nodes, (1, -1)), None if known is None else np.array([known])
    x, force, energy = interpolated(row, at, np.array([depth]), held)
    corners = row.indenter.corners
    lines = [line.Line(at, 0.0, 0.0, at in corners) for at in x[0].tolist()]
    return lines, float(force[0]), float(energy[0])


def _ends(contacts: ContactSet) -> list[line.End]:
    """The ends of a single contact, the right one first; alone if it includes the axis."""
    row, ((first, last),) = contacts.row, contacts.nodes
    alone = row.lattice.x(row.first + first) == row.lattice.axis
    sides = [(last, 1)] if alone else [(last, 1), (first, -1)]
    return [line.end_of(row, contacts.depth, *side) for side in sides]


def certified(
    asked: Question,
    row: Row,
    nodes: Contacts,
    lines: list[line.Line],
    sums: Totals,
    certificate: Certificate,
    tail: LatticeTail,
    *,
    neutral: bool = False,
) -> Equilibrium:
    """The state with contacts between these nodes, whose lines are there. NotCertifiedError."""
    _demand(asked, certificate)
    lattice, pairs = row.lattice, list(zip(lines[::2], lines[1::2], strict=True))
    return Equilibrium(
        scene=asked.scene,
        depth=asked.depth,
        contacts=np.array([_interval(*pair) for pair in pairs]),
        nodes=lattice.x(row.first + np.array(nodes)),
        pinned=np.array([[left.pinned, right.pinned] for left, right in pairs]),
        force=sum((end.force for end in lines), start=sums.force),
        energy=sum((end.energy for end in lines), start=sums.energy),
        certificate=certificate,
        surfaces=tail,
        scales={"force": sums.force_scale, "energy": sums.energy_scale},
        errors=_UNKNOWN,
        method="lattice",
        branch=asked.branch,
        spacing=lattice.spacing,
        neutral=neutral,
    )


def is_neutral(row: Row, nodes: Contacts, end: line.End) -> bool:
    """Whether moving the line at this end of a single contact by several links costs nothing."""
    ((first, last),), lattice = nodes, row.lattice
    if last - first < 3 or not lattice.w:
        return False
    most = _INDIFFERENT * lattice.w * lattice.cell
    inside = zip(end.gap[: -end.start], end.energy, strict=False)
    return all(gap > 0 and abs(energy) <= most for gap, energy in inside)


def _interval(left: line.Line, right: line.Line) -> list[float]:
    """x of both lines; their middle if the contact is smaller than interpolation resolves."""
    return [left.x, right.x] if left.x <= right.x else 2 * [(left.x + right.x) / 2]


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
