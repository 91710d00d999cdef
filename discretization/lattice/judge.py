"""The certificate of contacts on nodes: are they an equilibrium, whoever found them?

The conditions of ../certificate.py, by the energy of all nodes (`NodalEnergy`) and its gradient at
the displacements of a state, and by single moves away from it:

    penetration   max (g_i - u_i)/δ over the free nodes,                          <= tolerance
    stationarity  max |∂U/∂u_i| / kΔxδ over the free nodes,                       <= tolerance
    opening       a contact node pulled (∂U/∂u_i < 0) may only be held by its adhesion: opening
                  that node alone, the others as they are, must not lower the energy; a lone
                  node has no adhesion, unless on a path it stands for a contact narrower than a
                  link, both lines of which pull with √(2wγ₁) at most
    neighbours    no line gains energy by one link either way, after which the surface stays above
                  the indenter, as a fraction of the terms of that change
    force         dU/dd (sum of nodal forces on the contacts) against kΔx Σ u_i over the whole line

δ is the largest of |d|, |u| at the lines and δ₀, so that no unit enters. Not counted is what double
precision leaves in a nodal force, 32 ε (kΔx + 4t) δ, in their sum, and in a gap,
32 ε δ; for these |u| at the lowest node counts for δ, too. In the sum of the forces every link's
tension T enters twice, 4 ε √ΣT²; that of links beside a contact enters once, and is a difference of
displacements, 2 ε t |u| each.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import EPSILON, Certificate
from discretization.lattice.line import LINKS, Advances, advances, outwards
from discretization.nodes.nodal_energy import Balance, NodalEnergy
from discretization.nodes.obstacle import surface
from discretization.nodes.row import Contacts, Row
from energy.arrays import Array, Mask

_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class State:
    """Contacts on nodes of a row at a depth: the energy of the nodes looked at, u and g = d - f.

    g is -inf where there is no profile; passed: what lines that pass links change; closes (2m,):
    which may close the next link, and leave the surface out of the indenter; work: of adhesion;
    narrow: whether lone nodes stand for contacts narrower than a link.
    """

    row: Row
    nodes: Contacts
    depth: float
    work: float
    model: NodalEnergy
    u: Array
    g: Array
    passed: Advances
    closes: Mask
    narrow: bool = False

    @functools.cached_property
    def balance(self) -> Balance:
        """Energy and forces."""
        return self.model.balance(self.u)

    @functools.cached_property
    def size(self) -> float:
        """δ: the largest of |d|, |u| at the lines and δ₀."""
        lines = self.depth - self.row.f[[self.nodes[0][0], self.nodes[-1][1]]]
        delta0 = math.sqrt(2 * max(self.row.works) / self.row.lattice.k)
        return max(abs(self.depth), float(np.abs(lines).max()), delta0)

    def pull(self, noise: float) -> float:
        """The largest pull per weight, above noise, on nodes whose opening lowers the energy.

        The outermost nodes of contacts are not opened here, as these are moves of a line; a lone
        node has no adhesion, unless it is a spring without tension.
        """
        model, forces, lat = self.model, self.balance.forces, self.model.lattice
        held, (closing, opening) = np.concatenate([[False], model.contact, [False]]), self.row.works
        more, work = opening / closing if closing else 1.0, 0.0 if self.row.scene.pattern else lat.w
        stiff = lat.gamma1 / lat.spacing**2 * (lat.slopes == "small")  # of two links, at least
        strength = math.sqrt(2 * (lat.k + 2 * stiff) * more * work)
        hard = forces < lat.sizes(model.first, forces.size, -strength)
        pulled = np.flatnonzero(model.contact & (hard | ~(held[2:] & held[:-2])))
        pulled = pulled[forces[pulled] * -lat.cell > noise * model.cells[pulled]]
        before, after = held[pulled], held[pulled + 2]
        lone = pulled[~(before | after)]
        if self.narrow:  # held by both lines of the contact
            strength = 2 * math.sqrt(2 * lat.gamma1 * max(self.row.works))
            lone = lone[forces[lone] < -strength * (1 + lat.spring / lat.link)]
        opens = lone.tolist() if lat.gamma1 else []
        inner = pulled[before & after]
        bonds = model.bonds(inner) + (model.bonds(inner - 1) if lat.gamma1 else 0.0)
        least = lat.k * model.cells[inner] + stiff * (model.links[inner] + model.links[inner - 1])
        for i in inner[forces[inner] ** 2 > 2 * least * more * bonds].tolist():
            u, bound = self.u[i - 1 : i + 2], more * model.bonds(slice(i - 1, i + 1))
            whole, less = (
                NodalEnergy(lat, (True, middle, True), model.first + i - 1, bound, (False, False))
                for middle in (True, False)
            )
            opens += [i] * bool(whole.value(u) > less.value(less.relaxed(u)))
        return float((-forces[opens] / model.cells[opens]).max(initial=0.0)) * lat.cell

    @functools.cached_property
    def certificate(self) -> Certificate:
        """See the module. Gaps are those of the node a line comes to or leaves; nan: it cannot."""
        model, lat, balance, delta = self.model, self.row.lattice, self.balance, self.size
        held, links = model.contact, [-LINKS[0], -LINKS[0] - 1]
        free = np.flatnonzero(~held)
        gap, stored, _, bonds = (part[0].T[links] for part in self.passed)  # to close, and to open
        gap[0, ~self.closes], work = math.nan, np.reshape(self.row.works, (2, 1)) * bonds
        size = max(delta, abs(self.depth - self.row.lowest))
        if size == 0:  # touching, nothing deformed
            return Certificate.undeformed()
        unknown, unit = 32 * EPSILON * size, lat.spring * (delta or size)
        noise, relative = (lat.spring + 4 * lat.link) * unknown, np.where(gap, np.abs(gap), 1.0)
        closed = work[0] - stored[0] * (1 + unknown / relative[0]) ** 2
        opened = stored[1] * (np.maximum(gap[1] - unknown, 0.0) / relative[1]) ** 2 - work[1]
        gains = np.array([closed, opened]) / (work + stored + _TINY)
        below = np.append(self.g[free] - self.u[free], -gap[0])
        left = np.abs(balance.forces[free]) / model.cells[free] * lat.cell
        beside = np.flatnonzero(held[1:] != held[:-1])
        ties = lat.gamma1 / lat.spacing**2 * model.links[beside] @ np.abs(self.u[beside + 1])
        rounding = EPSILON * (4 * balance.tension + 2 * float(ties))
        pressed = balance.forces.sum() - balance.forces[free].sum()  # on the nodes in contact
        apart = abs(balance.force - float(pressed)) - rounding
        return Certificate(
            penetration=float(np.fmax.reduce(below, initial=0.0)) / (delta or size),
            stationarity=max(0.0, float(left.max(initial=0.0)) - noise) / unit,
            opening=max(0.0, self.pull(noise) - noise) / unit,
            neighbours=float(np.fmax.reduce(gains, axis=None, initial=0.0)),
            force=max(0.0, apart) / (balance.sizes or 1.0),
        )


def on_row(row: Row, nodes: Contacts, depth: float, *, narrow: bool = False) -> State:
    """Contacts between these first and last nodes of a row, from left to right, at a depth.

    u = g = d - f in contact, exact beside it; on the contact's nodes if f is convex, else on all.
    """
    own = slice(nodes[0][0], nodes[-1][1] + 1) if row.clear else slice(0, row.size)
    held = np.zeros(own.stop - own.start, bool)
    for first, last in nodes:
        held[first - own.start : last - own.start + 1] = True
    work = row.works[0] * row.bonds[own.start : own.stop - 1] if row.scene.pattern else None
    model, g = NodalEnergy(row.lattice, held, row.first + own.start, work), depth - row.f[own]
    u, at = g, np.reshape(nodes, (1, -1))
    passed, closes = advances(row, at, np.array([depth])), np.full(at.size, True)
    if not row.clear:
        every, lines = row.first + np.arange(row.size), np.unique(nodes)
        u = np.where(held, g, surface(row.lattice, row.first + lines, depth - row.f[lines], every))
        faced: list[Any] = [None, *at[0].tolist(), None]
        for i, side in enumerate(outwards(at.size).tolist()):
            left, right = (faced[i + 1] + side, faced[i + 1 + side])[::side]  # after the next link
            closes[i] = row.rules[0].clears(left, right, depth)
    link, both = -LINKS[0], np.repeat(at[0, 2::2] - at[0, 1:-1:2] == 2, 2)
    passed.bonds[0, 1:-1, link] += np.where(both, passed.bonds[0, 1:-1, link + 1], 0.0)
    return State(row, nodes, depth, row.works[0], model, u, g, passed, closes, narrow)
