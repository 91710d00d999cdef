"""Contacts on nodes with small slopes: their free surfaces, and how their lines may move."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.judge import Move
from discretization.lattice.nodal_energy import NodalEnergy
from discretization.lattice.nodes import Lattice
from discretization.lattice.obstacle import surface
from discretization.lattice.row import Contacts, Row

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


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

    @functools.cached_property
    def contact(self) -> Mask:
        """Which nodes are in contact (n,)."""
        found = np.zeros(self.row.f.size, bool)
        for first, last in self.nodes:
            found[first : last + 1] = True
        return found

    @functools.cached_property
    def model(self) -> NodalEnergy:
        """The energy of all nodes."""
        return NodalEnergy(self.lattice, self.contact, self.row.first, self.row.adhesion())

    @functools.cached_property
    def g(self) -> Array:
        """d - f (n,)."""
        return self.depth - self.row.f

    @functools.cached_property
    def u(self) -> Array:
        """Displacements (n,)."""
        held, every = np.flatnonzero(self.contact), np.arange(self.g.size)
        return np.where(self.contact, self.g, self._surface(held, every))

    def _surface(self, held: NDArray[np.int64], at: NDArray[np.int64]) -> Array:
        """At some nodes, that of contact nodes."""
        first = self.row.first
        return surface(self.lattice, held + first, self.g[held], at + first)

    def opening(self, force: Array) -> Array:
        """What is said in judge.py: a node with links of adhesion W is held up to √(2 S W).

        S: its stiffness, its neighbours as they are. Nodes with one link, the outermost of their
        contacts, are not opened here: these are moves of a line.
        """
        lat, nodes, bound = self.lattice, self.model.nodes, self.model.bound
        link = lat.link * lat.on_links(np.ones(bound.size), nodes)
        adhesion = self.row.adhesion(opening=True)
        work, stiffness = (_of_both(part) for part in (bound * adhesion, link))
        stiffness += lat.spring * lat.on_nodes(np.ones(nodes.size), nodes)
        own = self.contact & (_of_both(bound * 1.0) != 1.0)
        pull = -force[own] - np.sqrt(2 * stiffness[own] * work[own])
        return np.asarray(lat.per_weight(pull, nodes[own]))

    def moves(self, noise: float) -> Iterator[Move]:
        """Of all lines, one link outwards and, of contacts of more than one node, one inwards."""
        ends = [None, *(node for pair in self.nodes for node in pair), None]
        for i in range(1, len(ends) - 1):
            side = 1 if i % 2 == 0 else -1
            node, other, own = ends[i], ends[i + side], ends[i - side]
            assert node is not None
            if 0 <= node + side < self.g.size:
                after = other if other is not None and abs(other - node) == 2 else node + side
                if self._stays_clear(node + side, side, other, noise):
                    yield self._move(node, after, side, other, opening=False)
            if node != own:
                yield self._move(node - side, node, side, other, opening=True)

    def _move(self, start: int, after: int, side: int, other: int | None, *, opening: bool) -> Move:
        """A line at `start` that passes the next link, or has come from there."""
        g, first = self.g, self.row.first
        faced = None if other is None else first + other
        far, rest, stiffness = self.lattice.beside(first + start, side, faced)
        gap = g[start] - g[start + side] - rest * g[start]
        gap += 0.0 if other is None else far * (g[other] - g[start])
        bonds = self.row.adhesion(opening=opening)[min(start, after) : max(start, after)]
        return Move(opening, float(gap), float(stiffness / 2 * gap * gap), float(bonds.sum()))

    def _stays_clear(self, node: int, side: int, other: int | None, noise: float) -> bool:
        """Whether the surface beyond a line that has come to this node is above the indenter."""
        if self.row.clear or (other is not None and abs(other - node) < 2):
            return True
        held = np.array([node] if other is None else sorted((node, other)))
        end = (self.g.size if side > 0 else -1) if other is None else other
        at = np.sort(np.arange(node + side, end, side))
        return bool((self.g[at] - self._surface(held, at) <= noise).all())


def _of_both(links: Array) -> Array:
    """Of each node (n,), the sum of both links' (n - 1,)."""
    return np.append(links, 0.0) + np.append(0.0, links)
