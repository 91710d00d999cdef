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
Mask = NDArray[np.bool_]
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


class State(Protocol):
    """Contacts on nodes at a depth, of which u and g are known at all nodes of the energy."""

    @property
    def row(self) -> Row: ...

    @property
    def depth(self) -> float: ...

    @property
    def model(self) -> NodalEnergy: ...

    @property
    def u(self) -> Array: ...

    @property
    def g(self) -> Array: ...

    def opening(self, force: Array) -> Array:
        """By how much contact nodes, which feel these forces, are pulled more than they hold."""

    def moves(self, noise: float) -> Iterable[Move]:
        """What lines could do, but for moves after which the surface is in the indenter."""


class Totals(NamedTuple):
    """U and P, P as the sum of the forces on contact nodes, and sums of the terms' sizes.

    forces: on all nodes, ∂U/∂u_i (n,).
    """

    energy: float
    force: float
    force_by_reactions: float
    energy_scale: float
    force_scale: float
    forces: Array


def totals(state: State) -> Totals:
    """Energy and force of a state."""
    model, u = state.model, state.u
    terms, springs = list(model.terms(u).values()), model.springs(u)
    forces = model.gradient(u)
    return Totals(
        sum(terms),
        float(springs.sum()),
        float(forces[model.contact].sum()),
        sum(map(abs, terms)),
        float(np.abs(springs).sum()),
        forces,
    )


def size_of(state: State) -> float:
    """δ: the largest of |d|, |u| at the lines and δ₀."""
    held = np.flatnonzero(state.model.contact)
    delta0 = math.sqrt(2 * max(state.row.works) / state.row.lattice.k)
    return max(abs(state.depth), float(np.abs(state.u[held[[0, -1]]]).max()), delta0)


def judge_apart(row: Row, depth: float) -> Certificate:
    """Of the state without contact."""
    scale = max(abs(depth), math.sqrt(2 * row.lattice.w / row.lattice.k)) or 1.0
    return Certificate.undeformed(max(0.0, (depth - row.lowest) / scale))


def judge(state: State, sums: Totals) -> Certificate:
    """Of a state in contact, with these totals."""
    model, u, delta = state.model, state.u, size_of(state)
    size = max(delta, abs(state.depth - state.row.lowest))
    if size == 0:  # touching, nothing deformed
        return Certificate.undeformed()
    lat, free, force = model.lattice, ~model.contact, sums.forces
    pull = lat.per_weight(force, model.nodes)
    noise, unit = 32 * EPSILON * (lat.spring + 4 * lat.link) * size, lat.spring * (delta or size)
    gains = (_gain(move, 32 * EPSILON * size) for move in state.moves(32 * EPSILON * size))
    apart = abs(sums.force - sums.force_by_reactions) - _summed_rounding(model, u)
    return Certificate(
        penetration=max(0.0, float((state.g - u)[free].max(initial=0.0))) / (delta or size),
        stationarity=max(0.0, float(np.abs(pull[free]).max(initial=0.0)) - noise) / unit,
        opening=max(0.0, float(state.opening(force).max(initial=0.0)) - noise) / unit,
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


def _summed_rounding(model: NodalEnergy, u: Array) -> float:
    """What the nodal forces' sum can be off by.

    Every link's tension T enters twice, 4 ε √ΣT²; that of links beside a contact enters once, and
    is a difference of displacements, 2 ε t |u| each.
    """
    lines = model.contact[1:] != model.contact[:-1]
    apart = model.lattice.on_links(model.lattice.link * np.abs(u[1:]), model.nodes)[lines]
    return 4 * EPSILON * float(np.linalg.norm(model.tension(u))) + 2 * EPSILON * apart.sum()


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
        u, free = self.g.copy(), np.flatnonzero(~self.contact)
        u[free] = self._surface(np.unique(self.nodes), free)
        return u

    def _surface(self, held: NDArray[np.int64], at: NDArray[np.int64]) -> Array:
        """At some nodes, that of contact nodes."""
        first = self.row.first
        return surface(self.lattice, held + first, self.g[held], at + first)

    def opening(self, force: Array) -> Array:
        """What is said in judge.py: a node with links of adhesion W is held up to √(2 S W).

        S: its stiffness, its neighbours as they are. Nodes with one link, the outermost of their
        contacts, are not opened here: these are moves of a line.
        """
        lat, i = self.lattice, np.flatnonzero(self.contact & (force < 0))
        bound, nodes = np.pad(self.model.bound, 1), self.model.nodes[i]
        bonds = np.pad(self.row.adhesion(opening=True), 1)
        work = bonds[i] * bound[i] + bonds[i + 1] * bound[i + 1]
        stiffness = lat.on_nodes(np.full(i.size, lat.spring), nodes)
        stiffness += lat.on_nodes(lat.link, nodes - 0.5) * (i > 0)
        stiffness += lat.on_nodes(lat.link, nodes + 0.5) * (i < self.g.size - 1)
        pull = lat.per_weight(-force[i] - np.sqrt(2 * stiffness * work), nodes)
        return np.asarray(pull[bound[i] == bound[i + 1]])

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
