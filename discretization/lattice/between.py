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

from discretization.lattice.row import Row
from discretization.lattice.rules import Rules
from energy import Indenter

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_INTERIOR = 0.499  # links: an interpolated line keeps the node it belongs to


def interpolated(
    row: Row, indenter: Indenter, nodes: Nodes, depth: Array
) -> tuple[Array, Array, Array]:
    """Lines (s, 2m), P and U (s,) of s states with m contacts each, between these nodes (s, 2m)."""
    force, energy = row.force(nodes, depth), row.energy(nodes, depth)
    offset = np.zeros(nodes.shape)  # outwards
    for column, side in ((0, -1), (-1, 1)):
        node = nodes[:, column]
        lone = node == nodes[:, column - side]
        zeta = np.where(lone, 0.0, _outer_offset(row, indenter, node, side, depth))
        beside = np.clip(node + side * np.sign(zeta).astype(int), 0, row.f.size - 1)
        offset[:, column] = zeta
        for total, part in ((force, row.tail_force), (energy, row.tail_energy)):
            total += np.abs(zeta) * (part(beside, side, depth) - part(node, side, depth))
    if nodes.shape[1] > 2:
        offset[:, 1:-1] = _with_gaps(row, nodes, depth, force, energy)
    ways = np.resize([-1, 1], nodes.shape[1])
    x = row.lattice.x(row.first + nodes + ways * np.clip(offset, -_INTERIOR, _INTERIOR))
    return np.clip(x, *indenter.extent), force, energy


def _outer_offset(row: Row, indenter: Indenter, node: Nodes, side: int, depth: Array) -> Array:
    """How far an outermost line is from its node, in links outwards: -1/2..1/2."""
    closing, opening = row.rules
    at = node if side > 0 else row.f.size - 1 - node
    outer, inner = closing.outwards[side][at], opening.outwards[side][np.maximum(at - 1, 0)]
    touch = row.lattice.x(row.first + row.touch)
    tip = (node == row.touch) & np.isin(touch, indenter.corners)
    free = (at > 0) & ~tip & np.isfinite(outer) & (outer > inner)
    width = np.where(free, outer - inner, 1.0)
    return np.clip(np.where(free, (depth - inner) / width - 0.5, 0.0), -0.5, 0.5)


def _with_gaps(row: Row, nodes: Nodes, depth: Array, force: Array, energy: Array) -> Array:
    """How far facing lines are from their nodes (s, 2m - 2); added to P and U, bilinear in both."""
    zeta = np.array(
        [
            [_facing_offsets(*row.rules, ends[i : i + 4], d) for i in range(0, len(ends) - 2, 2)]
            for ends, d in zip(nodes.tolist(), depth.tolist(), strict=True)
        ]
    )
    left, right, steps = nodes[:, 1:-1:2], nodes[:, 2::2], np.sign(zeta).astype(int)
    share, d = np.abs(zeta), depth[:, None]
    left_beside, right_beside = left + steps[..., 0], right - steps[..., 1]
    for total, part in ((force, row.gap_force), (energy, row.gap_energy)):
        whole, one = part(left, right, d), part(left_beside, right, d)
        other, both = part(left, right_beside, d), part(left_beside, right_beside, d)
        more = share[..., 0] * (one - whole) + share[..., 1] * (other - whole)
        more += share[..., 0] * share[..., 1] * (both - one - other + whole)
        total += np.asarray(more.sum(axis=1), float)
    return zeta.reshape(len(nodes), -1)


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
