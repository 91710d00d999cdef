"""Contact lines, force and energy between the nodes, from the depths at which links are passed.

A line is where the depth at which it passes a link, taken at the middles of the links, equals d.
Where opening takes another work of adhesion than closing there are two such positions, and a line
between them stays where it last moved:

    x = min(max(x before, x of closing at d), x of opening at d)    (outwards; a play operator)

so that a state has to remember the positions of its lines, too, not their nodes alone. Force and
energy are interpolated there between those of neighbouring contact sets: linear in each line, hence
continuous in d where a link is passed. Raw lattice values are off by up to Δx/2 in the line; these
are off by O(Δx²).
"""

from __future__ import annotations

import functools
from bisect import bisect_right
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import EPSILON
from discretization.nodes.row import Contacts, Row
from discretization.nodes.rules import Rules

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_INTERIOR = 0.4999  # links: an interpolated line keeps the node it belongs to
_BEYOND = 1e-4  # by which what is further away is shortened
_ROUNDING = 16 * EPSILON  # of x: by less no line has moved
Lines = tuple[float, ...]  # x of all lines
_Pair = tuple[float, float]
_Row = tuple[float, float, float]


def interpolated(
    row: Row, nodes: Nodes, depth: Array, lines: Array | None = None
) -> tuple[Array, Array, Array]:
    """Lines (s, 2m), P and U (s,) of s states with m contacts each, between these nodes (s, 2m).

    lines: where they are known, as they have to be where a line resists both ways.
    """
    if lines is None:
        offset = offsets(row, nodes, depth, np.zeros(nodes.shape))
        lines = _positions(row, nodes, offset)
    else:
        offset = offsets_of(row, nodes, lines)
    energy, force = at_offsets(row, nodes, offset, depth)
    return lines, force, energy


def moved_lines(
    row: Row,
    nodes: Contacts,
    depth: float,
    before: tuple[Contacts, Lines] | None,
) -> Lines:
    """Where the lines of contacts with these nodes are that came from others; None: from none.

    A line that is still at its node comes from where it was, to the last bit if it has not moved;
    others come from the side on which their contacts were.
    """
    at, facing = np.reshape(nodes, (1, -1)), _facing(nodes)
    came, known = np.full(at.shape, -1.0), {}
    if before is not None:
        known = dict(zip(_facing(before[0]), before[1], strict=True))
        held = offsets_of(row, np.reshape(before[0], (1, -1)), np.array(before[1]))[0].tolist()
        there = dict(zip(known, held, strict=True))
        inside = [1.0 if _in_contact(before[0], node) else -1.0 for _, node in facing]
        came[0] = [there.get(*each) for each in zip(facing, inside, strict=True)]
    offset = offsets(row, at, np.array([depth]), came)
    found = zip(facing, _positions(row, at, offset)[0].tolist(), strict=True)
    rounding = _ROUNDING * float(np.abs(row.lattice.x(row.first + np.array([0, row.size]))).max())
    return tuple(
        known[line] if abs(known.get(line, np.inf) - x) <= rounding else x for line, x in found
    )


def _facing(nodes: Contacts) -> list[tuple[int, int]]:
    """Which way the lines of contacts face, and their nodes."""
    return [each for first, last in nodes for each in ((-1, first), (1, last))]


def _in_contact(nodes: Contacts, node: int) -> bool:
    i = bisect_right(nodes, (node, node)) - 1
    beside = nodes[max(i, 0) : i + 2]
    return any(first <= node <= last for first, last in beside)


def offsets_of(row: Row, nodes: Nodes, lines: Array) -> Array:
    """How far the lines at these positions are from their nodes, in links outwards."""
    kept = (
        (lines - row.lattice.x(row.first + nodes)) * _outwards(nodes.shape[1]) / row.lattice.spacing
    )
    beyond = np.maximum(np.abs(kept) - _INTERIOR, 0.0)
    whole = np.where(beyond > 0, np.copysign(_INTERIOR + beyond / _BEYOND, kept), kept)
    return np.where(_at_edge(row, nodes), kept, whole)


def _positions(row: Row, nodes: Nodes, offset: Array) -> Array:
    """x of lines that far from their nodes, each less than half a link from its node.

    As two lines that face each other feel each other, one may be somewhat further from its node:
    that is kept within the last part of the half link.
    """
    beyond = np.maximum(np.abs(offset) - _INTERIOR, 0.0)
    kept = np.where(beyond > 0, np.copysign(_INTERIOR + beyond * _BEYOND, offset), offset)
    kept = np.where(_at_edge(row, nodes), offset, kept)
    return np.clip(
        row.lattice.x(row.first + nodes + _outwards(nodes.shape[1]) * kept), *row.indenter.extent
    )


@functools.lru_cache
def _outwards(lines: int) -> Nodes:
    """Which way so many lines face."""
    return np.resize([-1, 1], lines)


def _at_edge(row: Row, nodes: Nodes) -> NDArray[np.bool_]:
    """Whether lines are at an edge beyond the last node."""
    return np.asarray((nodes == row.size - 1) & (row.overhang > 0))


def offsets(row: Row, nodes: Nodes, depth: Array, before: Array) -> Array:
    """How far the lines are from their nodes (s, 2m), in links outwards: -1/2..1/2.

    before: how far they were. A line at an edge is there, up to one link beyond the last node.
    """
    offset = before.copy()
    for column, side in ((0, -1), (-1, 1)):
        node = nodes[:, column]
        lone = node == nodes[:, column - side]
        found = _outer_offset(row, node, side, depth, before[:, column])
        offset[:, column] = np.where(lone, 0.0, found)
    if nodes.shape[1] > 2:
        offset[:, 1:-1] = [
            [
                zeta
                for i in range(0, len(ends) - 2, 2)
                for zeta in _facing_offsets(
                    *row.rules, ends[i : i + 4], d, (came[i + 1], came[i + 2])
                )
            ]
            for ends, d, came in zip(nodes.tolist(), depth.tolist(), before.tolist(), strict=True)
        ]
    return offset


def at_offsets(row: Row, nodes: Nodes, offset: Array, depth: Array) -> Array:
    """U and P (2, s) with lines that far from their nodes: linear in each of them."""
    total, steps, share = np.zeros((2, depth.size)), np.sign(offset).astype(int), np.abs(offset)
    for column, side in ((0, -1), (-1, 1)):
        node = nodes[:, column]
        own = row.tail(node, side, depth)
        beside = node + side * steps[:, column]
        past = beside > row.size - 1  # as far from the last node as the one before
        other = np.clip(np.where(past, node - 1, beside), 0, row.size - 1)
        more = share[:, column] * (row.tail(other, side, depth) - own)
        total = total + own + np.where(past, -more, more)  # with all digits of the sums
    if nodes.shape[1] == 2:
        return np.asarray(total, float)
    left, right, d = nodes[:, 1:-1:2], nodes[:, 2::2], depth[:, None]
    (zeta, eta), near = (
        share[:, 1:-1].reshape(-1, left.shape[1], 2).transpose(2, 0, 1),
        left + steps[:, 1:-1:2],
    )
    far = right - steps[:, 2::2]
    whole, one, two = row.gap(left, right, d), row.gap(near, right, d), row.gap(left, far, d)
    more = zeta * (one - whole) + eta * (two - whole)
    more = more + zeta * eta * (row.gap(near, far, d) - one - two + whole)
    return np.asarray(total + (whole + more).sum(axis=2), float)


def _outer_offset(row: Row, node: Nodes, side: int, depth: Array, before: Array) -> Array:
    """How far an outermost line is from its node, in links outwards: -1/2..1/2.

    before: how far it was.
    """
    at = node if side > 0 else row.size - 1 - node
    free = (at > 0) & np.isfinite(row.rules[0].outwards[side][at])
    lowest = node == row.touch
    if lowest.any():
        free &= ~(lowest & np.isin(row.lattice.x(row.first + row.touch), row.indenter.corners))
    found = np.where(free, before, 0.0)
    for rules, further in zip(row.rules, (np.maximum, np.minimum), strict=True):
        outer, inner = rules.outwards[side][at], rules.outwards[side][np.maximum(at - 1, 0)]
        moves = free & (outer > inner)
        width = np.where(moves, outer - inner, 1.0)
        rests = np.where(moves, (depth - inner) / width - 0.5, 0.0)
        rests = np.minimum(np.maximum(rests, -0.5), 0.5)
        found = np.where(moves, further(found, rests), found)
    edge = row.overhang if side > 0 else 0.0
    return np.where(node == row.size - 1, edge, found) if edge else found


def _facing_offsets(
    closing: Rules, opening: Rules, ends: Sequence[int], depth: float, before: _Pair
) -> _Pair:
    """Where both lines of a gap are between the nodes, in links towards each other: -1..1.

    ends: first and last node of the contact on the left, and of the one on the right; before: where
    the lines were. Where a line moves its depth of passing equals d; that depends on where the
    other one is, so both are found together: linear in both. Lone nodes, and lines three links
    apart or less, stay on their nodes.
    """
    first, left, right, last = ends
    if right - left <= 3:
        return 0.0, 0.0
    at = (0.0 if first == left else before[0], 0.0 if right == last else before[1])
    for rules, way in ((closing, 1), (opening, -1)):
        one = (1.0, 0.0, 0.0) if first == left else _line_row(rules, left, 1, right, depth)
        two = (1.0, 0.0, 0.0) if right == last else _line_row(rules, right, -1, left, depth)
        at = _pushed(one, two, way, at)
    return min(max(at[0], -1.0), 1.0), min(max(at[1], -1.0), 1.0)


def _line_row(rules: Rules, node: int, side: int, other: int, depth: float) -> _Row:
    """By how much the depth of passing grows as this line and the other one advance by a link.

    Also d less the depth of passing with both lines on their nodes.
    """
    inner, outer = rules.passes(node - side, side, other), rules.passes(node, side, other)
    beyond = other + side
    felt = outer - rules.passes(node, side, beyond) if 0 <= beyond < rules.f.size else 0.0
    return outer - inner, felt, depth - (outer + inner) / 2


def _pushed(one: _Row, two: _Row, way: int, at: _Pair) -> _Pair:
    """Two lines pushed one way, as far as they must: both, or one of them, or none.

    A line that advances lowers the depth at which the other one does (felt <= 0), so that where
    not both move that one alone does which would move if the other one stayed.
    """
    (own, felt, off), (own2, felt2, off2) = one, two
    whole = own * own2 - felt * felt2
    if min(own, own2, whole) <= 0:
        return at
    both = (off * own2 - felt * off2) / whole, (off2 * own - felt2 * off) / whole
    if way * (both[0] - at[0]) >= 0 and way * (both[1] - at[1]) >= 0:
        return both
    alone = (off - felt * at[1]) / own, (off2 - felt2 * at[0]) / own2
    further = max if way > 0 else min
    return further(at[0], alone[0]), further(at[1], alone[1])
