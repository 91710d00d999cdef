"""The certificate of contacts on the lattice: are they an equilibrium, whoever found them?

The conditions of ../certificate.py, of the surface itself and of single moves away from it:

    penetration   max (g_i - u_i)/δ over the free nodes contact could reach,      <= tolerance
    stationarity  max |∂U/∂u_i| / kΔxδ over the free nodes,                       <= tolerance
    opening       a contact node pulled (∂U/∂u_i < 0) may only be held by its adhesion: opening
                  that node alone, -r²/(2(kΔx+2t)) + 2wΔx, must not lower the energy; a lone
                  node has none
    neighbours    no line gains energy by one link either way, after which the surface stays above
                  the indenter: ΔE = ±[S/2 gap² - wΔx], S the stiffness of the free node that comes
                  into contact or lets go, as a fraction of both terms; a gap of two links closes
                  with both
    force         dU/dd (sum of nodal forces on the contacts) against kΔx Σ u_i over the whole line

δ is the largest of |d|, |u| at the lines and δ₀, so that no unit enters. Not counted is what double
precision leaves in a nodal force, 32 ε (kΔx + 4t) δ, in their sum, 4 ε √Σ(link tension)², and in a
gap, 32 ε δ; for these |u| at the lowest node counts for δ, too.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.fronts import FIRST_BLOCK, blocks_between
from discretization.lattice.ground import Ground
from discretization.lattice.nodes import Lattice
from discretization.lattice.totals import Totals
from discretization.rounding import EPSILON

Array = NDArray[np.float64]
_TAIL = np.arange(1.0, FIRST_BLOCK + 1)
_TINY = float(np.finfo(float).tiny)


def judge_apart(ground: Ground, depth: float) -> Certificate:
    """Of the state without contact."""
    scale = max(abs(depth), math.sqrt(2 * ground.lattice.w / ground.lattice.k)) or 1.0
    return Certificate.undeformed(max(0.0, (depth - ground.lowest) / scale))


def judge(contacts: ContactSet, sums: Totals) -> Certificate:
    """Of the state with these contacts, and these totals."""
    lat, size = contacts.lattice, _size(contacts)
    if size == 0:  # touching, nothing deformed
        return Certificate.undeformed()
    delta, noise = contacts.scale or size, rounding(lat, size)
    unit, deepest, imbalance = lat.spring * delta, sums.penetration, sums.imbalance
    for node, side, u, *_ in contacts.outer:
        through, unbalanced = _outside(contacts, node, side, u)
        deepest, imbalance = max(deepest, through), max(imbalance, unbalanced)
    held = 4 * (lat.spring + 2 * lat.link) * contacts.ground.works[1] * lat.cell
    pulled = max(-sums.weakest - math.sqrt(held), -sums.lone)
    gains = [0.0, *_gains(contacts, 32 * EPSILON * size)]
    apart = abs(sums.force - sums.force_by_reactions) - _summed_rounding(contacts, sums)
    return Certificate(
        penetration=max(0.0, deepest) / delta,
        stationarity=max(0.0, imbalance - noise) / unit,
        opening=max(0.0, pulled - noise) / unit,
        neighbours=max(gains),
        force=max(0.0, apart) / (sums.force_scale or 1.0),
    )


def _size(contacts: ContactSet) -> float:
    """What rounding is relative to: δ, and |u| at the lowest node."""
    return max(contacts.scale, abs(contacts.depth - contacts.ground.lowest))


def rounding(lat: Lattice, delta: float) -> float:
    """What a nodal force of displacements of size δ can be off by in double precision."""
    return 32 * EPSILON * (lat.spring + 4 * lat.link) * delta


def _summed_rounding(contacts: ContactSet, sums: Totals) -> float:
    """What the nodal forces' sum can be off by: every link's tension T enters twice, 4 ε √ΣT²."""
    lat = contacts.lattice
    return 4 * EPSILON * math.sqrt(2 * sums.surface * lat.link * lat.on_nodes(1.0, contacts.last))


def _outside(contacts: ContactSet, node: int, side: int, u: float) -> tuple[float, float]:
    """max (g_i - u_i) and |∂U/∂u_i| per weight of free nodes beyond an outermost line; u: there.

    A tail pressed down is convex: where the profile is so, too, it can only be met at the line.
    """
    lat, ground, deepest = contacts.lattice, contacts.ground, -math.inf
    limit = ground.where.last if side > 0 else ground.where.first
    clear = contacts.depth + max(0.0, -u)  # above it a rising profile cannot be met any more
    rising = ground.indenter.apex is not None or ground.indenter.convex
    first = _TAIL if side > 0 or math.isnan(lat.axis) else _TAIL[:node]
    tail = np.concatenate([[u], lat.beyond(node, side, first, u)])
    worst = _imbalance(lat, node, side, tail)
    for start, stop in blocks_between(node, limit):
        f = ground.heights(start, stop)
        if start != node:
            tail = lat.beyond(node, side, abs(start - node) + np.arange(float(f.size)), u)
            worst = max(worst, _imbalance(lat, start, side, tail))
        through = contacts.depth - f[1:]
        through -= tail[1 : f.size]
        if through.size:
            deepest = max(deepest, float(through[through.argmax()]))
        if (rising and f[-1] >= clear) or (ground.indenter.convex and u >= 0):
            break
    return deepest, worst


def _imbalance(lat: Lattice, node: int, side: int, tail: Array) -> float:
    """max |∂U/∂u_i| per weight over the nodes of a tail (n,) from this one on, but the first."""
    nodes = range(node, node + side * tail.size, side)
    tension = lat.on_links(lat.link * (tail[1:] - tail[:-1]), nodes)
    force = lat.spring * lat.on_nodes(tail[1:], nodes[1:])
    force += tension
    force[:-1] -= tension[1:]
    force[-1] += lat.at(nodes[-1], side).tail_reaction(tail[-1])
    size = np.abs(lat.per_weight(force, nodes[1:]))
    return float(size[size.argmax()])


class _Move(NamedTuple):
    """A line that passes the link outwards from one of its nodes, or comes back over it (opening).

    after: where the line is then; other: the node of the line it faces, if there is one; gap: of
    the node that comes into contact or lets go; stored: energy that contact there takes, without
    adhesion; work: adhesion.
    """

    opening: bool
    after: int
    side: int
    other: int | None
    gap: float
    stored: float
    work: float


def _gains(contacts: ContactSet, noise: float) -> Iterator[float]:
    """Energy gained by each line that moves by one link, over the terms of that change.

    noise: of gaps, of whose squares the stored energies are multiples.
    """
    for move in (*_outer_moves(contacts), *_facing_moves(contacts)):
        gap = abs(move.gap) or 1.0
        if move.opening:
            gain = move.stored * (max(move.gap - noise, 0.0) / gap) ** 2 - move.work
        else:
            gain = move.work - move.stored * (1 + noise / gap) ** 2
        if gain > 0 and _stays_clear(contacts, move, noise):
            yield gain / (move.work + move.stored + _TINY)


def _outer_moves(contacts: ContactSet) -> Iterator[_Move]:
    """Of the outermost lines."""
    lat, ground = contacts.lattice, contacts.ground
    for end in contacts.outer:
        a, b = contacts.nodes[-1 if end.side > 0 else 0]
        for link in (0, -1) if a < b else (0,):
            i, start = link - end.start, end.node + end.side * link
            if i == len(end.gap):
                continue  # nothing further out
            after = end.node + end.side * (1 if not link else -1)
            stored = float(lat.at(start, end.side).stored(end.gap[i]))
            work = ground.work(start, start + end.side, opening=link < 0)
            yield _Move(link < 0, after, end.side, None, end.gap[i], stored, work)


def _facing_moves(contacts: ContactSet) -> Iterator[_Move]:
    """Of the lines that face another one."""
    if len(contacts.nodes) < 2:
        return
    lat, ground, (nodes, _) = contacts.lattice, contacts.ground, contacts.ends
    for side, opening in itertools.product((1, -1), (False, True)):
        start, other = (nodes[:-1, 1], nodes[1:, 0])[::side]
        if opening:
            long = np.diff(nodes[:-1] if side > 0 else nodes[1:])[:, 0] > 0
            start, other = start[long] - side, other[long]
        at = start, start + side, other
        own, beyond, facing = (contacts.depth - ground.at(np.asarray(x, float)) for x in at)
        far, rest, stiffness = lat.beside(start, side, other)
        gaps = own - beyond + far * (facing - own) - rest * own
        rows = zip(start.tolist(), other.tolist(), gaps, stiffness / 2 * gaps**2, strict=True)
        for a, c, gap, stored in rows:
            until = c if abs(c - a) == 2 else a + side
            work = ground.work(a, until, opening=opening)
            after = a if opening else until
            yield _Move(opening, after, side, c, float(gap), float(stored), work)


def _stays_clear(contacts: ContactSet, move: _Move, noise: float) -> bool:
    """Whether the surface stays above the indenter after a move."""
    lat, ground, depth = contacts.lattice, contacts.ground, contacts.depth
    if move.other is None:
        u = depth - float(ground.heights(move.after, move.after)[0])
        return _outside(contacts, move.after, move.side, u)[0] <= noise
    left, right = min(move.after, move.other), max(move.after, move.other)
    if right - left < 2:
        return True
    g = depth - ground.heights(left, right)
    beyond = lat.free(left, right, g[0], g[-1], np.arange(left + 1, right))
    return bool((g[1:-1] - beyond <= noise).all())
