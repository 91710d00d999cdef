"""Contact lines, force and energy between the nodes, from the depths at which links are passed.

A line is where the depth at which it passes a link, taken at the middles of the links, equals d.
Force and energy are interpolated there between those of neighbouring contact sets: linear in each
line, hence continuous in d where a link is passed. Raw lattice values are off by up to Δx/2 in the
line; these are off by O(Δx²).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.row import Parts, Row
from discretization.lattice.rules import Rules
from energy import Indenter

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_INTERIOR = 0.499  # links: an interpolated line keeps the node it belongs to


def interpolated(
    row: Row, indenter: Indenter, nodes: Nodes, depth: Array
) -> tuple[Array, Array, Array]:
    """Lines (s, 2m), P and U (s,) of s states with m contacts each, between these nodes (s, 2m)."""
    offset = offsets(row, indenter, nodes, depth)
    ways = np.resize([-1, 1], nodes.shape[1])
    inside = np.where(offset > 0.5, offset, np.clip(offset, -_INTERIOR, _INTERIOR))
    x = row.lattice.x(row.first + nodes + ways * inside)
    force, energy = (
        at_offsets(row, nodes, offset, depth, part) for part in (row.forces, row.energies)
    )
    return np.clip(x, *indenter.extent), force, energy


def offsets(row: Row, indenter: Indenter, nodes: Nodes, depth: Array) -> Array:
    """How far the lines are from their nodes (s, 2m), in links outwards: -1/2..1/2.

    A line at an edge is there, up to one link beyond the last node.
    """
    offset = np.zeros(nodes.shape)
    for column, side in ((0, -1), (-1, 1)):
        node = nodes[:, column]
        lone = node == nodes[:, column - side]
        offset[:, column] = np.where(lone, 0.0, _outer_offset(row, indenter, node, side, depth))
    if nodes.shape[1] > 2:
        offset[:, 1:-1] = [
            [
                zeta
                for i in range(0, len(ends) - 2, 2)
                for zeta in _facing_offsets(*row.rules, ends[i : i + 4], d)
            ]
            for ends, d in zip(nodes.tolist(), depth.tolist(), strict=True)
        ]
    return offset


def at_offsets(row: Row, nodes: Nodes, offset: Array, depth: Array, parts: Parts) -> Array:
    """P or U (s,) with lines that far from their nodes: linear in each of them.

    parts: what outermost lines and gaps add, `row.forces` or `row.energies`.
    """
    tail, gap = parts
    total, steps, share = np.zeros(depth.size), np.sign(offset).astype(int), np.abs(offset)
    for column, side in ((0, -1), (-1, 1)):
        node = nodes[:, column]
        own = tail(node, side, depth)
        beside = node + side * steps[:, column]
        past = beside > row.f.size - 1  # as far from the last node as the one before
        other = tail(np.clip(np.where(past, node - 1, beside), 0, row.f.size - 1), side, depth)
        more = share[:, column] * np.where(past, own - other, other - own)
        total = total + own + more  # with all digits of the sums
    if nodes.shape[1] == 2:
        return np.asarray(total, float)
    left, right, d = nodes[:, 1:-1:2], nodes[:, 2::2], depth[:, None]
    inner, inner_steps = share[:, 1:-1], steps[:, 1:-1]
    near, far = left + inner_steps[:, ::2], right - inner_steps[:, 1::2]
    whole, one, two = gap(left, right, d), gap(near, right, d), gap(left, far, d)
    more = inner[:, ::2] * (one - whole) + inner[:, 1::2] * (two - whole)
    more += inner[:, ::2] * inner[:, 1::2] * (gap(near, far, d) - one - two + whole)
    return np.asarray(total + (whole + more).sum(axis=1), float)


def _outer_offset(row: Row, indenter: Indenter, node: Nodes, side: int, depth: Array) -> Array:
    """How far an outermost line is from its node, in links outwards: -1/2..1/2."""
    closing, opening = row.rules
    at = node if side > 0 else row.f.size - 1 - node
    outer, inner = closing.outwards[side][at], opening.outwards[side][np.maximum(at - 1, 0)]
    touch = row.lattice.x(row.first + row.touch)
    tip = (node == row.touch) & np.isin(touch, indenter.corners)
    free = (at > 0) & ~tip & np.isfinite(outer) & (outer > inner)
    width = np.where(free, outer - inner, 1.0)
    edge = row.overhang if side > 0 else 0.0
    found = np.clip(np.where(free, (depth - inner) / width - 0.5, 0.0), -0.5, 0.5)
    return np.where(node == row.f.size - 1, edge, found) if edge else found


def _facing_offsets(
    closing: Rules, opening: Rules, ends: Sequence[int], depth: float
) -> tuple[float, float]:
    """Where both lines of a gap are between the nodes, in links towards each other: -1/2..1/2.

    ends: first and last node of the contact on the left, and of the one on the right. Each line is
    where its depth of passing equals d; that depends on where the other one is, so both are found
    together: linear in both. Lone nodes, and lines three links apart or less, stay on their nodes.
    """
    first, left, right, last = ends
    if right - left <= 3:
        return 0.0, 0.0
    rows = []
    for node, side, other, lone in (
        (left, 1, right, first == left),
        (right, -1, left, right == last),
    ):
        if lone:
            rows.append((1.0, 0.0, 0.0))
            continue
        inner, outer = opening.passes(node - side, side, other), closing.passes(node, side, other)
        beyond = other + side
        felt = outer - closing.passes(node, side, beyond) if 0 <= beyond < closing.f.size else 0.0
        rows.append((outer - inner, felt, depth - (outer + inner) / 2))
    (own, felt, off), (own2, felt2, off2) = rows
    whole = own * own2 - felt * felt2
    if min(own, own2, whole) <= 0:
        return 0.0, 0.0
    found = (off * own2 - felt * off2) / whole, (off2 * own - felt2 * off) / whole
    return min(max(found[0], -0.5), 0.5), min(max(found[1], -0.5), 0.5)
