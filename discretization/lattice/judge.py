"""The certificate of contacts on nodes: are they an equilibrium, whoever found them?

The conditions of ../certificate.py, by the energy of all nodes (`NodalEnergy`) and its gradient at
the displacements of a state, and by single moves away from it:

    penetration   max (g_i - u_i)/δ over the free nodes,                          <= tolerance
    stationarity  max |∂U/∂u_i| / kΔxδ over the free nodes,                       <= tolerance
    opening       a contact node pulled (∂U/∂u_i < 0) may only be held by its adhesion: opening
                  that node alone, the others as they are, must not lower the energy; a lone
                  node has no adhesion
    neighbours    no line gains energy by one link either way, after which the surface stays above
                  the indenter, as a fraction of the terms of that change
    force         dU/dd (sum of nodal forces on the contacts) against kΔx Σ u_i over the whole line

δ is the largest of |d|, |u| at the lines and δ₀, so that no unit enters. Not counted is what double
precision leaves in a nodal force, 32 ε (kΔx + 4t) δ, in their sum, and in a gap,
32 ε δ; for these |u| at the lowest node counts for δ, too.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.lattice.nodal_energy import NodalEnergy
from discretization.lattice.nodes import Lattice
from discretization.lattice.obstacle import surface
from discretization.lattice.row import Contacts, Row
from discretization.rounding import EPSILON

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]
_BLOCK = 1 << 14  # nodes looked at at once
_TINY = float(np.finfo(float).tiny)


class Move(NamedTuple):
    """A line that is moved by one link.

    gap: between the node that comes into contact and the surface, or of the node let go and the
    surface then; stored: energy that takes without adhesion; work: of adhesion, gained or lost.
    """

    opening: bool
    gap: float
    stored: float
    work: float


class Part(NamedTuple):
    """Successive nodes of a state, from the last one of the part before on: energy, u and g."""

    model: NodalEnergy
    u: Array
    g: Array


class State(Protocol):
    """Contacts on nodes at a depth."""

    @property
    def row(self) -> Row: ...

    @property
    def depth(self) -> float: ...

    @property
    def at_lines(self) -> tuple[float, float]:
        """u of the first and the last contact node."""

    def parts(self) -> Iterator[Part]:
        """The nodes that are looked at, so many at once as stay in the processor's cache."""

    def opening(self, part: Part, i: Nodes, force: Array) -> Array:
        """By how much contact nodes i of a part are pulled by these forces more than they hold.

        Per weight, and of nodes that may be opened alone.
        """

    def moves(self, noise: float) -> Iterable[Move]:
        """What lines could do, but for moves after which the surface is in the indenter."""


class Totals(NamedTuple):
    """U and P, P as the sum of the forces on contact nodes, and sums of the terms' sizes.

    penetration, imbalance, opening: the largest g - u and |∂U/∂u_i| of free nodes, and the largest
    of `State.opening`; rounding: what the sum of the forces may be off by.
    """

    energy: float
    force: float
    force_by_reactions: float
    energy_scale: float
    force_scale: float
    penetration: float
    imbalance: float
    opening: float
    rounding: float


def totals(state: State) -> Totals:
    """Energy and force of a state, and what is worst at its nodes, in one pass over them."""
    energies, sums, worst, carried = np.zeros(4), np.zeros(5), np.zeros(3), 0.0
    for part in state.parts():
        model, u = part.model, part.u
        terms, force, springs, tension = model.balance(u)
        tails, free = model.pulls * u[[0, -1]], np.flatnonzero(~model.contact[: model.own])
        force[0] += carried
        force, carried = force[: model.own], float(force[-1])
        energies += list(terms.values())
        sums += [
            float(springs.sum() + tails.sum()),
            float(force.sum() - force[free].sum()),
            float(np.abs(springs).sum() + np.abs(tails).sum()),
            float(tension @ tension),
            _at_lines(part),
        ]
        worst = np.maximum(worst, _worst(state, part, force, free))
    whole, reactions, scale, squares, beside = sums.tolist()
    rounding = 4 * EPSILON * math.sqrt(squares) + 2 * EPSILON * beside
    energy, size = float(energies.sum()), float(np.abs(energies).sum())
    penetration, imbalance, opening = worst.tolist()
    return Totals(energy, whole, reactions, size, scale, penetration, imbalance, opening, rounding)


def _at_lines(part: Part) -> float:
    """Sum of t|u| over links beside contacts.

    Every link's tension T enters the sum of forces twice, 4 ε √ΣT²; that of links beside a contact
    enters once, and is a difference of displacements, 2 ε t |u| each.
    """
    held, lattice, nodes = part.model.contact, part.model.lattice, part.model.nodes
    links = np.flatnonzero(held[1:] != held[:-1])
    pulls = lattice.on_nodes(lattice.link * np.abs(part.u[links + 1]), nodes[links] + 0.5)
    return float(pulls.sum())


def _worst(state: State, part: Part, force: Array, free: Nodes) -> list[float]:
    """penetration, imbalance and opening of `Totals`, of the nodes of this part."""
    lattice, nodes, held = part.model.lattice, part.model.nodes, part.model.contact
    pulled = np.flatnonzero(held[: force.size] & (force < 0))
    return [
        float((part.g[free] - part.u[free]).max(initial=0.0)),
        float(np.abs(lattice.per_weight(force[free], nodes[free])).max(initial=0.0)),
        float(state.opening(part, pulled, force[pulled]).max(initial=0.0)),
    ]


def size_of(state: State) -> float:
    """δ: the largest of |d|, |u| at the lines and δ₀."""
    delta0 = math.sqrt(2 * max(state.row.works) / state.row.lattice.k)
    return max(abs(state.depth), *map(abs, state.at_lines), delta0)


def judge_apart(row: Row, depth: float) -> Certificate:
    """Of the state without contact."""
    scale = max(abs(depth), math.sqrt(2 * row.lattice.w / row.lattice.k)) or 1.0
    return Certificate.undeformed(max(0.0, (depth - row.lowest) / scale))


def judge(state: State, sums: Totals) -> Certificate:
    """Of a state in contact, with these totals."""
    lat, delta = state.row.lattice, size_of(state)
    size = max(delta, abs(state.depth - state.row.lowest))
    if size == 0:  # touching, nothing deformed
        return Certificate.undeformed()
    noise, unit = 32 * EPSILON * (lat.spring + 4 * lat.link) * size, lat.spring * (delta or size)
    moves = list(state.moves(32 * EPSILON * size))
    gains = (_gain(move, 32 * EPSILON * size) for move in moves)
    through = (-move.gap for move in moves if not move.opening)
    apart = abs(sums.force - sums.force_by_reactions) - sums.rounding
    return Certificate(
        penetration=max(sums.penetration, *through, 0.0) / (delta or size),
        stationarity=max(0.0, sums.imbalance - noise) / unit,
        opening=max(0.0, sums.opening - noise) / unit,
        neighbours=max([0.0, *gains]),
        force=max(0.0, apart) / (sums.force_scale or 1.0),
    )


def _gain(move: Move, noise: float) -> float:
    """Energy gained by a move over its terms: work and stored energy, a multiple of gap²."""
    gap = abs(move.gap) or 1.0
    if move.opening:
        gain = move.stored * (max(move.gap - noise, 0.0) / gap) ** 2 - move.work
    else:
        gain = move.work - move.stored * (1 + noise / gap) ** 2
    return gain / (move.work + move.stored + _TINY)


@dataclass(frozen=True, eq=False)
class ContactSet:
    """Contacts between these first and last nodes of a row, from left to right, at a depth.

    In contact u = g = d - f; the free surfaces are exact.
    """

    row: Row
    nodes: Contacts
    depth: float

    @property
    def lattice(self) -> Lattice:
        """The lattice."""
        return self.row.lattice

    @property
    def at_lines(self) -> tuple[float, float]:
        """u of the outermost contact nodes."""
        return self.g(self.nodes[0][0]), self.g(self.nodes[-1][1])

    def parts(self) -> Iterator[Part]:
        """All nodes; of one contact of a convex profile its own, with tails beyond."""
        row, first = self.row, self.row.first
        start, stop = (self.nodes[0][0], self.nodes[-1][1]) if row.clear else (0, row.size - 1)
        for low in range(start, max(stop, start + 1), _BLOCK):
            high = min(low + _BLOCK, stop)
            contact, g = (
                self.contact(low, high),
                self.depth - row.heights(first + low, first + high),
            )
            u = g if contact.all() else self.u[low : high + 1]
            work = row.works[0] * row.bond(np.arange(low, high))
            tails = low == start, high == stop
            yield Part(NodalEnergy(self.lattice, contact, first + low, work, tails), u, g)

    def contact(self, low: int, high: int) -> Mask:
        """Which of the nodes low..high of the row are in contact."""
        found = np.zeros(high - low + 1, bool)
        for first, last in self.nodes:
            found[max(first - low, 0) : max(last - low + 1, 0)] = True
        return found

    def g(self, node: int) -> float:
        """d - f at a node of the row."""
        at = self.row.first + node
        return self.depth - float(self.row.heights(at, at)[0])

    @functools.cached_property
    def u(self) -> Array:
        """Displacements (n,) of all nodes."""
        u, free = self.depth - self.row.f, np.flatnonzero(~self.contact(0, self.row.size - 1))
        u[free] = self._surface(np.unique(self.nodes), free)
        return u

    def _surface(self, held: Nodes, at: Nodes) -> Array:
        """At some nodes, that of contact nodes."""
        first = self.row.first
        return surface(self.lattice, held + first, self.depth - self.row.f[held], at + first)

    def opening(self, part: Part, i: Nodes, force: Array) -> Array:
        """What is said in judge.py: a node with links of adhesion W is held up to √(2 S W).

        S: its stiffness, its neighbours as they are. Nodes with one link, the outermost of their
        contacts, are not opened here: these are moves of a line.
        """
        lat, row, nodes = self.lattice, self.row, part.model.nodes[i]
        start = int(part.model.nodes[0]) - row.first
        held, at = self.contact(start - 1, start + part.u.size), start + i
        before, after = held[i], held[i + 2]  # these are in contact
        work = row.works[1] * (before * row.bond(at - 1) + after * row.bond(at))
        stiffness = lat.on_nodes(np.full(i.size, lat.spring), nodes)
        stiffness += lat.on_nodes(lat.link, nodes - 0.5) * (at > 0)
        stiffness += lat.on_nodes(lat.link, nodes + 0.5) * (at < row.size - 1)
        pull = lat.per_weight(-force - np.sqrt(2 * stiffness * work), nodes)
        return np.asarray(pull[before == after])

    def moves(self, noise: float) -> Iterator[Move]:
        """Of all lines, one link outwards and, of contacts of more than one node, one inwards."""
        ends = [None, *(node for pair in self.nodes for node in pair), None]
        for i in range(1, len(ends) - 1):
            side = 1 if i % 2 == 0 else -1
            node, other, own = ends[i], ends[i + side], ends[i - side]
            assert node is not None
            if 0 <= node + side < self.row.size:
                after = other if other is not None and abs(other - node) == 2 else node + side
                if self._stays_clear(node + side, side, other, noise):
                    yield self._move(node, after, side, other, opening=False)
            if node != own:
                yield self._move(node - side, node, side, other, opening=True)

    def _move(self, start: int, after: int, side: int, other: int | None, *, opening: bool) -> Move:
        """A line at `start` that passes the next link, or has come from there."""
        row, first = self.row, self.row.first
        faced = None if other is None else first + other
        far, rest, stiffness = self.lattice.beside(first + start, side, faced)
        own, beyond = (self.depth - row.heights(first + start, first + start + side)).tolist()
        gap = own - beyond - rest * own
        gap += 0.0 if other is None else far * (self.g(other) - own)
        bonds = row.works[opening] * row.bond(np.arange(min(start, after), max(start, after)))
        return Move(opening, float(gap), float(stiffness / 2 * gap * gap), float(bonds.sum()))

    def _stays_clear(self, node: int, side: int, other: int | None, noise: float) -> bool:
        """Whether the surface beyond a line that has come to this node is above the indenter."""
        if self.row.clear or (other is not None and abs(other - node) < 2):
            return True
        held = np.array([node] if other is None else sorted((node, other)))
        end = (self.row.size if side > 0 else -1) if other is None else other
        at = np.sort(np.arange(node + side, end, side))
        return bool((self.depth - self.row.f[at] - self._surface(held, at) <= noise).all())
