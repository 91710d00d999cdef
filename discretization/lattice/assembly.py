"""From contact nodes to an equilibrium: totals, certificate, and lines between the nodes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.lattice import line
from discretization.lattice.between import interpolated
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.ground import unknown
from discretization.lattice.judge import Totals, judge, judge_apart, totals
from discretization.lattice.nodes import Lattice
from discretization.lattice.row import Row
from discretization.lattice.shares import LatticeTail
from energy import Scene

Pair = tuple[line.Line, line.Line]  # left and right line of a contact
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
    asked: Question,
    row: Row,
    nodes: Sequence[tuple[int, int]] | NDArray[np.int64],
) -> Equilibrium:
    """The certified state with contacts between these first and last nodes (m, 2).

    NotCertifiedError if it is no equilibrium; ValueError for a contact that reaches the end of the
    known profile.
    """
    pairs = [(int(first), int(last)) for first, last in nodes]
    if not pairs:
        return without_contact(asked, row)
    refuse_unknown(row, asked.depth, pairs[0][0], pairs[-1][1])
    contacts = ContactSet(row, pairs, asked.depth)
    return _judged(asked, contacts, _lines(contacts))


def of_row(
    asked: Question,
    row: Row,
    nodes: Sequence[tuple[int, int]],
    known: Sequence[float] | None = None,
) -> Equilibrium:
    """The same with contacts between these of its nodes, of any works of adhesion.

    known: where the lines are, which has to be known where they resist both ways.
    """
    pairs = [(row.first + first, row.first + last) for first, last in nodes]
    contacts, corners = ContactSet(row, pairs, asked.depth), row.indenter.corners
    refuse_unknown(row, asked.depth, pairs[0][0], pairs[-1][1])
    depth, held = np.array([asked.depth]), None if known is None else np.array([known])
    x, force, energy = interpolated(row, row.indenter, np.reshape(nodes, (1, -1)), depth, held)
    lines = [line.Line(at, 0.0, 0.0, at in corners) for at in x[0].tolist()]
    state = _judged(asked, contacts, list(zip(lines[::2], lines[1::2], strict=True)))
    return replace(state, force=float(force[0]), energy=float(energy[0]))


def certified(
    asked: Question,
    row: Row,
    nodes: Sequence[tuple[int, int]],
    lines: list[Pair],
    sums: Totals,
    certificate: Certificate,
    tail: LatticeTail,
    *,
    neutral: bool = False,
) -> Equilibrium:
    """The state with contacts between these nodes, whose lines are there. NotCertifiedError."""
    _demand(asked, certificate)
    lattice, ends = row.lattice, [end for pair in lines for end in pair]
    return Equilibrium(
        scene=asked.scene,
        depth=asked.depth,
        contacts=np.array([_interval(*pair) for pair in lines]),
        nodes=np.array([[lattice.x(node) for node in pair] for pair in nodes]),
        pinned=np.array([[left.pinned, right.pinned] for left, right in lines]),
        force=sum((end.force for end in ends), start=sums.force),
        energy=sum((end.energy for end in ends), start=sums.energy),
        certificate=certificate,
        tail=tail,
        scales={"force": sums.force_scale, "energy": sums.energy_scale},
        errors=_UNKNOWN,
        method="lattice",
        branch=asked.branch,
        spacing=lattice.spacing,
        neutral=neutral,
    )


def _judged(asked: Question, contacts: ContactSet, lines: list[Pair]) -> Equilibrium:
    """Of contacts with small slopes."""
    sums, alone = totals(contacts), len(contacts.nodes) == 1
    neutral = alone and is_neutral(contacts.lattice, contacts.nodes[0], contacts.outer[0])
    known = contacts.nodes, lines, sums, judge(contacts, sums), contacts.lattice.tail
    return certified(asked, contacts.row, *known, neutral=neutral)


def is_neutral(lattice: Lattice, nodes: tuple[int, int], end: line.End) -> bool:
    """Whether moving the line at this end of a single contact by several links costs nothing."""
    if nodes[1] - nodes[0] < 3 or not lattice.w:
        return False
    most = _INDIFFERENT * lattice.w * lattice.cell
    inside = zip(end.gap[: -end.start], end.energy, strict=False)
    return all(gap > 0 and abs(energy) <= most for gap, energy in inside)


def _interval(left: line.Line, right: line.Line) -> list[float]:
    """x of both lines; their middle if the contact is smaller than interpolation resolves."""
    return [left.x, right.x] if left.x <= right.x else 2 * [(left.x + right.x) / 2]


def refuse_unknown(row: Row, depth: float, first: int, last: int) -> None:
    """ValueError for a contact at an end of the profile that is not the end of the body."""
    body, where = row.indenter, row.where
    for node, limit, end in zip((first, last), where[:2], body.extent, strict=True):
        if node == limit and end not in body.walls:
            raise ValueError(unknown(row.lattice, depth, node))


def _demand(asked: Question, certificate: Certificate) -> None:
    certificate.demand(
        f"the state found at depth = {asked.depth!r}",
        "rounding has spoilt it, or the solver's tolerance, or a profile that is said to be convex "
        "is not; try another spacing or method",
    )


def _lines(contacts: ContactSet) -> list[Pair]:
    """Left and right line of each contact, those that face each other together."""
    row, depth, rows = contacts.row, contacts.depth, contacts.nodes
    reach, where = row.lattice.critical_gap, row.where
    if len(rows) == 1:
        return [line.outer(row, reach, contacts.outer)]
    (a, b), (c, d) = rows[0], rows[-1]
    found = [line.raw(row, a), line.raw(row, d)]
    if a < b:
        found[0] = line.recover(row, depth, (where.first, b), a, -1, reach)
    if c < d:
        found[1] = line.recover(row, depth, (c, where.last), d, 1, reach)
    for one, other in itertools.pairwise(rows):
        found[-1:-1] = line.between(row, depth, one, other)
    return list(zip(found[::2], found[1::2], strict=True))
