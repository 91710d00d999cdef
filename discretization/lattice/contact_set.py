"""Contacts on nodes of a row, with the exact free surfaces that they hold: what judge.py sees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.judge import Move, State
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.obstacle import surface
from discretization.nodes.row import Contacts, Row

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_BLOCK = 1 << 14  # nodes looked at at once: their arrays stay in the processor's cache


@dataclass(frozen=True, eq=False)
class ContactSet(State):
    """Contacts between these first and last nodes of a row, from left to right, at a depth.

    In contact u = g = d - f; the free surfaces are exact.
    """

    nodes: Contacts

    @classmethod
    def of(cls, row: Row, nodes: Contacts, depth: float) -> ContactSet:
        """Of one contact of a convex profile its own nodes, with tails beyond; of others all."""
        own = slice(nodes[0][0], nodes[-1][1] + 1) if row.clear else slice(0, row.size)
        held = np.zeros(own.stop - own.start, bool)
        for first, last in nodes:
            held[first - own.start : last - own.start + 1] = True
        work = row.works[0] * row.bonds[own.start : own.stop - 1] if row.scene.pattern else None
        model, g = NodalEnergy(row.lattice, held, row.first + own.start, work), depth - row.f[own]
        u, free = g, np.flatnonzero(~held)
        if free.size:
            u = g.copy()
            u[free] = _surface(row, np.unique(nodes), depth, free)
        return cls(row, depth, model, u, g, nodes)

    def opening(self, pulled: Nodes, force: Array) -> float:
        """What is said in judge.py: a node with links of adhesion W is held up to √(2 S W).

        S: its stiffness, its neighbours as they are. Nodes with one link, the outermost of their
        contacts, are not opened here: these are moves of a line.
        """
        row, lat, held = self.row, self.row.lattice, np.pad(self.model.contact, 1)

        def most(i: Nodes) -> float:
            i = i[held[i] == held[i + 2]]  # those before and after are in contact, or not
            nodes = self.model.first + i
            at = nodes - row.first
            work = row.works[1] * held[i] * (row.bond(at - 1) + row.bond(at))
            links = lat.weight(nodes - 0.5) + lat.weight(nodes + 0.5)
            stiffness = lat.spring * lat.weight(nodes) + lat.link * links
            pull = (-force[i] - np.sqrt(2 * stiffness * work)) / lat.weight(nodes)
            return float(pull.max(initial=0.0))

        return max(map(most, np.array_split(pulled, 1 + pulled.size // _BLOCK)))

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
        far, rest, stiffness = row.lattice.beside(first + start, side, faced)
        own, beyond = self.depth - row.f[[start, start + side]]
        gap = own - beyond - rest * own
        gap += 0.0 if other is None else far * (self.depth - row.f[other] - own)
        bonds = row.works[opening] * row.bond(np.arange(min(start, after), max(start, after)))
        return Move(opening, float(gap), float(stiffness / 2 * gap * gap), float(bonds.sum()))

    def _stays_clear(self, node: int, side: int, other: int | None, noise: float) -> bool:
        """Whether the surface beyond a line that has come to this node is above the indenter."""
        if self.row.clear or (other is not None and abs(other - node) < 2):
            return True
        held = np.array([node] if other is None else sorted((node, other)))
        end = (self.row.size if side > 0 else -1) if other is None else other
        at = np.sort(np.arange(node + side, end, side))
        u = _surface(self.row, held, self.depth, at)
        return bool((self.depth - self.row.f[at] - u <= noise).all())


def _surface(row: Row, held: Nodes, depth: float, at: Nodes) -> Array:
    """Displacements at some nodes of the surface of these contact nodes."""
    return surface(row.lattice, held + row.first, depth - row.f[held], at + row.first)
