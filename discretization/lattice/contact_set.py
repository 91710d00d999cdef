"""Contacts on nodes of a row, with the exact free surfaces that they hold: what judge.py sees."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.judge import Move, Part
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.obstacle import surface
from discretization.nodes.row import Contacts, Row

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]
_BLOCK = 1 << 14  # nodes looked at at once: their arrays stay in the processor's cache


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
            contact, ends = self.contact(low, high), (first + low, first + high)
            g = self.depth - row.heights(*ends)
            u = g if contact.all() else self.u[low : high + 1]
            work = row.works[0] * row.bonds[low:high] if row.scene.pattern else None
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
        stiffness = lat.spring * lat.weight(nodes)
        stiffness = stiffness + lat.link * lat.weight(nodes - 0.5) * (at > 0)
        stiffness += lat.link * lat.weight(nodes + 0.5) * (at < row.size - 1)
        pull = (-force - np.sqrt(2 * stiffness * work)) / lat.weight(nodes)
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
