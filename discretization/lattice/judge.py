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

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import EPSILON, Certificate
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.row import Row

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
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
    energies, sums, worst, carried = np.zeros(1), np.zeros(5), np.zeros(3), 0.0
    for part in state.parts():
        model, u = part.model, part.u
        terms, force, springs, tension = model.balance(u)
        tails, free = model.pulls * u[[0, -1]], np.flatnonzero(~model.contact[: model.own])
        force[0] += carried
        force, carried = force[: model.own], float(force[-1])
        energies = energies + list(terms.values())
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
    pulls = lattice.link * np.abs(part.u[links + 1]) * lattice.weight(nodes[links] + 0.5)
    return float(pulls.sum())


def _worst(state: State, part: Part, force: Array, free: Nodes) -> list[float]:
    """penetration, imbalance and opening of `Totals`, of the nodes of this part."""
    lattice, nodes, held = part.model.lattice, part.model.nodes, part.model.contact
    pulled = np.flatnonzero(held[: force.size] & (force < 0))
    return [
        float((part.g[free] - part.u[free]).max(initial=0.0)),
        float(np.abs(force[free] / lattice.weight(nodes[free])).max(initial=0.0)),
        float(state.opening(part, pulled, force[pulled]).max(initial=0.0)) if pulled.size else 0.0,
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
