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

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.certificate import EPSILON, Certificate
from discretization.lattice.line import LINKS, Advances
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.row import Row
from energy.arrays import Array, Mask

_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class State:
    """Contacts on nodes of a row at a depth: the energy of the nodes looked at, u and g = d - f.

    g is -inf where there is no profile; passed: what lines that pass links change; closes (2m,):
    the lines that may close the next link, after which the surface is not in the indenter.
    """

    row: Row
    depth: float
    model: NodalEnergy
    u: Array
    g: Array
    passed: Advances
    closes: Mask

    @property
    def size(self) -> float:
        """δ: the largest of |d|, |u| at the lines and δ₀."""
        lines = np.abs(self.u[np.flatnonzero(self.model.contact)[[0, -1]]])
        delta0 = math.sqrt(2 * max(self.row.works) / self.row.lattice.k)
        return max(abs(self.depth), float(lines.max()), delta0)

    @property
    def moves(self) -> tuple[Array, Array, Array]:
        """v, S v²/2 and the adhesion of moves (2, 2m): lines that close a link, and that open one.

        v is the gap between the node that comes into contact and the surface, or that of the node
        let go to the surface then; nan where a line cannot be moved.
        """
        links = [-LINKS[0], -LINKS[0] - 1]
        gap, stored, _, bonds, _ = (part[0].T[links] for part in self.passed)
        gap[0, ~self.closes] = math.nan
        return gap, stored, np.reshape(self.row.works, (2, 1)) * bonds

    def pull(self, force: Array) -> float:
        """The largest pull per weight on contact nodes whose opening alone lowers the energy.

        force (n,): on all nodes. The outermost nodes of contacts are not opened here, as these are
        moves of a line; a lone node has no adhesion, unless it is a spring without tension.
        """
        model, held = self.model, np.pad(self.model.contact, 1)
        pulled = model.contact & (force < 0)
        opens = pulled & ~(held[:-2] | held[2:]) & (model.lattice.gamma1 > 0)
        inside = np.flatnonzero(pulled & held[:-2] & held[2:])
        closing, opening = self.row.works
        opens[inside] = model.released(self.u, inside, opening / closing if closing else 1.0) > 0
        i = np.flatnonzero(opens)
        return float((-force[i] / model.lattice.weight(model.first + i)).max(initial=0.0))


class Totals(NamedTuple):
    """U and P, P as the sum of the forces on contact nodes, and sums of the terms' sizes.

    penetration, imbalance, opening: the largest g - u and |∂U/∂u_i| of free nodes, and
    `State.pull`; rounding: what the sum of the forces may be off by.
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
    free = np.flatnonzero(~held)
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
        opening=state.pull(force),
        rounding=4 * EPSILON * balance.tension + 2 * EPSILON * float(ties.sum()),
    )


def judge(state: State, sums: Totals) -> Certificate:
    """Of a state in contact, with these totals."""
    lat, delta, (gap, stored, work) = state.row.lattice, state.size, state.moves
    size = max(delta, abs(state.depth - state.row.lowest))
    if size == 0:  # touching, nothing deformed
        return Certificate.undeformed()
    noise, unit = 32 * EPSILON * (lat.spring + 4 * lat.link) * size, lat.spring * (delta or size)
    unknown, relative = 32 * EPSILON * size, np.where(gap, np.abs(gap), 1.0)
    closed = work[0] - stored[0] * (1 + unknown / relative[0]) ** 2
    opened = stored[1] * (np.maximum(gap[1] - unknown, 0.0) / relative[1]) ** 2 - work[1]
    gains = np.array([closed, opened]) / (work + stored + _TINY)
    apart = abs(sums.force - sums.force_by_reactions) - sums.rounding
    return Certificate(
        penetration=float(np.fmax.reduce(-gap[0], initial=sums.penetration)) / (delta or size),
        stationarity=max(0.0, sums.imbalance - noise) / unit,
        opening=max(0.0, sums.opening - noise) / unit,
        neighbours=float(np.fmax.reduce(gains, axis=None, initial=0.0)),
        force=max(0.0, apart) / (sums.force_scale or 1.0),
    )
