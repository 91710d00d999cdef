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
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

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


@dataclass(frozen=True, eq=False)
class State:
    """Contacts on nodes of a row at a depth: the energy of the nodes looked at, u and g = d - f.

    g is -inf where there is no profile.
    """

    row: Row
    depth: float
    model: NodalEnergy
    u: Array
    g: Array

    @property
    def at_lines(self) -> tuple[float, float]:
        """u of the first and the last contact node."""
        held = self.model.contact
        return float(self.u[held.argmax()]), float(self.u[::-1][held[::-1].argmax()])

    def opening(self, pulled: Nodes, force: Array) -> float:
        """By how much at most pulled contact nodes that may be opened alone are not held.

        force (n,): on all nodes; the answer is per weight, 0 if all are held.
        """
        raise NotImplementedError

    def moves(self, noise: float) -> Iterable[Move]:
        """What lines could do, but for moves after which the surface is in the indenter."""
        raise NotImplementedError


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
    """Energy and force of a state, and what is worst at its nodes.

    Every link's tension T enters the sum of forces twice, 4 ε √ΣT²; that of links beside a contact
    enters once, and is a difference of displacements, 2 ε t |u| each.
    """
    model, u, lattice, first = state.model, state.u, state.model.lattice, state.model.first
    balance, held = model.balance(u), model.contact
    force, ends = balance.force, model.pulls * u[[0, -1]]
    free, pulled = np.flatnonzero(~held), np.flatnonzero(held & (force < 0))
    beside = np.flatnonzero(held[1:] != held[:-1])
    ties = lattice.link * np.abs(u[beside + 1]) * lattice.weight(first + beside + 0.5)
    unbalanced = np.abs(force[free] / lattice.weight(first + free))
    return Totals(
        energy=balance.energy,
        force=balance.springs + float(ends.sum()),
        force_by_reactions=float(force.sum() - force[free].sum()),
        energy_scale=balance.scale,
        force_scale=balance.sizes + float(np.abs(ends).sum()),
        penetration=float((state.g[free] - u[free]).max(initial=0.0)),
        imbalance=float(unbalanced.max(initial=0.0)),
        opening=state.opening(pulled, force) if pulled.size else 0.0,
        rounding=4 * EPSILON * balance.tension + 2 * EPSILON * float(ties.sum()),
    )


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
