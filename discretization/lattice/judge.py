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
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.lattice.nodal_energy import NodalEnergy
from discretization.lattice.row import Row
from discretization.rounding import EPSILON

Array = NDArray[np.float64]
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
    """U and P, P as the sum of the forces on contact nodes, and sums of the terms' sizes."""

    energy: float
    force: float
    force_by_reactions: float
    energy_scale: float
    force_scale: float


def totals(state: State) -> Totals:
    """Energy and force of a state."""
    model, u = state.model, state.u
    terms, springs = list(model.terms(u).values()), model.springs(u)
    return Totals(
        sum(terms),
        float(springs.sum()),
        float(model.gradient(u)[model.contact].sum()),
        sum(map(abs, terms)),
        float(np.abs(springs).sum()),
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
    lat, free, force = model.lattice, ~model.contact, model.gradient(u)
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
