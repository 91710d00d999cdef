"""The certificate of contacts on nodes: are they an equilibrium, whoever found them?

The conditions of ../certificate.py, by the energy of all nodes (`NodalEnergy`) and its gradient at
the displacements of a state, and by single moves away from it:

    penetration   max (g_i - u_i)/δ over the free nodes,                          <= tolerance
    stationarity  max |∂U/∂u_i| / kΔxδ over the free nodes,                       <= tolerance
    opening       a contact node pulled (∂U/∂u_i < 0) may only be kept by its adhesion: opening
                  that node alone, the others as they are, must not lower the energy; a lone
                  node has no adhesion, unless on a path it stands for a contact narrower than a
                  link, both lines of which pull with √(2wγ₁) at most
    neighbours    no line gains energy by one link in or out, after which the surface stays clear
                  of the indenter, as a fraction of the terms of that change
    force         dU/dd (sum of nodal forces on the contacts) against kΔx Σ u_i over the whole line

δ is the largest of |d|, |u| at the two outermost lines and δ₀ = √(2w/k), so that no unit enters.
Other lines are not looked at: with a smaller δ the conditions are only stricter.

Not counted is what double precision leaves in a nodal force, 32 ε (kΔx + 4t) δ, as t is taken
1 + 2 + 1 times in t (u_{i-1} - 2u_i + u_{i+1}), in the sum of these forces, and in the gap at a
node that a line closes or opens, 32 ε δ; for these |u| at the lowest node counts for δ, too. A
penetration is compared with its tolerance as it is, since 32 ε is far less.

In the sum of the forces over the contacts the tension T of every link enters at both its ends.
Either is rounded by 2 ε T at most (a difference, a quotient, a product and a sum, ε/2 each), at
random from link to link: 4 ε √ΣT² together. The tension of the few links beside a contact does not
cancel, and is known to the rounding of both displacements that it is the difference of, ε t |u|
for either, which may be alike in all of them: these are added, 2 ε t |u| each.

Conventions
-----------
u, d and g = d - f are positive down into the layer. A nodal force is ∂U/∂u_i: on a contact node
what the indenter presses with, negative if adhesion pulls the node up. Nodes of contacts are those
of the row (`Row`); arrays (n,) are over the nodes that are looked at, which begin with node 0 of
`State.model`. Lines, arrays (2m,), are in the order left and right line of the first contact, of
the second, .... `Advances` has arrays (1, 2m, 6): of one state, its lines, and the links j = -3
... 2 beside them, `LINKS`; the line closes link 0 next and opens link -1. `row.works` are the works
of adhesion of closing and of opening, `row.bonds` lengths or areas of links times the factor of the
pattern. δ₀ and weights of nodes are those of `row.lattice`: its `spring_stiffness` is kΔx, its
`link_stiffness` t, and its `cell` the length or area of a node of weight 1.

What `State.model`, a `NodalEnergy`, has of the nodes that are looked at: `first`, the lattice's
number of the first of them; `contact`, which are in contact; `cells` and `links`, the lengths or
areas of nodes and of the links after them; `value(u)`, the energy, and `relaxed(u)`, the
displacements of least energy with those of contact nodes as they are in u. Its fourth and fifth
argument are the adhesion of each link of contact nodes, positive [energy/length], and whether
there is a tail on the left and on the right. Of `Balance`, `forces` are ∂U/∂u_i; `force` is
kΔx Σ u_i over the whole line, those under the tails among them; `sizes` is the same sum of absolute
values, to which a mismatch of the forces is relative; `tension` is √ΣT².

Of `Advances`, `gap` is v, how far the free surface is below the indenter at the node beyond a link
while that is open, u - g, less than 0 in the indenter; `stored` is S v²/2, what the surface stores
when the link is closed, and `bonds` are those of the link.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import EPSILON, Certificate, worst
from discretization.lattice.subgrid import LINKS, Advances, advances, facing_sides
from discretization.nodes.nodal_energy import Balance, NodalEnergy
from discretization.nodes.obstacle import surface
from discretization.nodes.row import Contacts, Row
from energy.arrays import Array, Indices, Mask

# Of δ: rounding of a gap, and with the stiffness of a nodal force, each a sum of a dozen terms.
# Half or twice as much changes no result (`python -m tests.sensitivity
# discretization.lattice.certificate _ROUNDINGS`).
_ROUNDINGS = 32 * EPSILON
_TINY = float(np.finfo(float).tiny)  # added to what is divided by, so that 0/0 is 0
_CLOSING = -LINKS[0]  # place among LINKS of link 0, which a line closes next,
_OPENING = _CLOSING - 1  # and of link -1, which it opens next


@dataclass(frozen=True, eq=False)
class State:
    """Contacts on nodes of a row at a depth.

    Attributes
    ----------
    row : Row
    nodes : Contacts
        First and last nodes of m contacts.
    depth : float
        [length].
    work : float
        Work of adhesion by which lines rest [energy/area].
    model : NodalEnergy
        Of the n nodes that are looked at.
    u, g : ndarray (n,)
        Their displacements, and d - f, -∞ where there is no profile [length].
    passed : Advances
        Changes as lines pass the links beside them.
    closes : ndarray of bool (2m,)
        Which lines may close the next link, and leave the surface out of the indenter: only of
        these it is judged whether that gains energy.
    narrow : bool
        Whether lone nodes stand for contacts narrower than a link.
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
        """Energy and forces of the model at u; the module says which."""
        return self.model.balance(self.u)

    @functools.cached_property
    def size(self) -> float:
        """δ [length]: the largest of |d|, |u| at the two outermost lines and δ₀."""
        outermost = [self.nodes[0][0], self.nodes[-1][1]]
        lines = self.depth - self.row.f[outermost]
        delta0 = math.sqrt(2 * max(self.row.works) / self.row.lattice.k)
        return max(abs(self.depth), float(np.abs(lines).max()), delta0)

    def pull(self, noise: float) -> float:
        """The largest pull, -∂U/∂u_i, on nodes whose opening lowers the energy; 0 if there is none.

        It is that over the weight of the node, so that nodes about an axis compare.

        The outermost nodes of contacts are not opened here, as these are moves of a line; a lone
        node has no adhesion, unless it is a spring without tension.

        Parameters
        ----------
        noise : float
            Rounding of a force: smaller pulls are none [force/length].

        Returns
        -------
        float
            As of a node of weight 1 [force/length]. The noise is not subtracted.
        """
        model = self.model
        lattice = model.lattice
        forces = self.balance.forces
        in_contact = np.concatenate([[False], model.contact, [False]])  # node i at i + 1
        pulled = self._pulled(in_contact, noise)
        before = in_contact[pulled]
        after = in_contact[pulled + 2]
        opens = self._inner_that_open(pulled[before & after], noise)
        if lattice.gamma1:
            opens = self._lone_that_open(pulled[~(before | after)]) + opens
        return float((-forces[opens] / model.cells[opens]).max(initial=0.0)) * lattice.cell

    def _opening_adhesion(self, at: Indices) -> Array:
        """Adhesion of links of a contact, or without tension of its nodes, by the work of opening.

        at: numbers of the links, or nodes, in the model; all within contacts, and so in the row.
        """
        opening = self.row.works[1]
        if not self.model.lattice.gamma1:
            return np.asarray(opening * self.model.cells[at])
        links = at + self.model.first - self.row.first
        return np.asarray(opening * self.row.bonds[links])

    @property
    def _two_links(self) -> float:
        """Half the least stiffness of the links on both sides of a node, per area of it.

        That is γ₁/Δx², what one link adds to the stiffness against u of the node, its tension
        γ₁ (u_{i+1} - u_i)/Δx over u_i and Δx. With finite slopes a steep link has hardly any, so
        that the least is 0.
        """
        lattice = self.model.lattice
        return lattice.gamma1 / lattice.spacing**2 * (lattice.slopes == "small")

    def _pulled(self, in_contact: Mask, noise: float) -> Indices:
        """Contact nodes that are pulled above noise; of inner ones those that may open.

        An inner node opens if its force squared exceeds 2 S W, S its stiffness and W the adhesion
        of both its links: here first S and W at their least, W of one link, in one pass over all.

        in_contact (n + 2,): one more node, which is free, on either side. `Lattice.sizes(first, n,
        unit)` are the areas of n nodes times the unit.
        """
        model = self.model
        lattice = model.lattice
        forces = self.balance.forces
        # The least of a pattern is not known.
        work = 0.0 if self.row.scene.pattern else self.row.works[1]
        stiffness = lattice.k + 2 * self._two_links
        strength = math.sqrt(2 * stiffness * work)
        hard = forces < lattice.sizes(model.first, forces.size, -strength)
        is_inner = in_contact[2:] & in_contact[:-2]
        nodes = np.flatnonzero(model.contact & (hard | ~is_inner))
        return np.asarray(nodes[forces[nodes] * -lattice.cell > noise * model.cells[nodes]])

    def _lone_that_open(self, nodes: Indices) -> list[int]:
        """Lone nodes that open: all, but for those that stand for a contact narrower than a link.

        These are held as long as they are pulled by no more than both lines may pull, each √(2wγ₁),
        as the surface turns by √(2w/γ₁) there. Of a node that is √(1 + κ/4) < 1 + κ times as much,
        κ = kΔx/t = (Δx/l)²: its spring and both tails have the stiffness 2t sinh μ, those of the
        continuum 2√(kγ₁). The contact is within a link of its node, on a profile that may be
        inclined there: it is held, too, if it is pulled less somewhere there. Only line contacts
        have such nodes: around an axis there is no second line.
        """
        if not self.narrow:
            return list(nodes.tolist())
        lattice = self.model.lattice
        strength = 2 * math.sqrt(2 * lattice.gamma1 * max(self.row.works))
        strength *= 1 + lattice.spring_stiffness / lattice.link_stiffness
        suspects = nodes[self.balance.forces[nodes] < -strength]
        return [i for i in suspects.tolist() if self._force_near(i) < -strength]

    def _force_near(self, node: int) -> float:
        """The largest force on a lone node if it were less than a link away [force/length].

        It is that of the parabola through ∂U/∂u_j of the node and of both nodes next to it, each
        alone in its place with the other contacts as they are; of the node itself where one of
        these is in another contact, or beyond the row.
        """
        own = node + self.model.first - self.row.first  # in the row
        ends: list[int | None] = [None, *np.ravel(self.nodes).tolist(), None]
        place = ends.index(own)
        left = ends[place - 1]
        right = ends[place + 2]
        here = float(self.balance.forces[node])
        start = 0 if left is None else left + 1
        stop = self.row.size if right is None else right
        if not start < own < stop - 1:
            return here
        before = self._force_alone(own - 1, left, right)
        after = self._force_alone(own + 1, left, right)
        rise = (after - before) / 2
        bend = (after + before) / 2 - here
        if bend >= 0 or abs(rise) >= -2 * bend:  # the largest is at an end of the two links
            return max(before, here, after)
        return here - rise**2 / (4 * bend)

    def _force_alone(self, node: int, left: int | None, right: int | None) -> float:
        """∂U/∂u of a node of the row in contact between two free surfaces [force/length].

        left, right: contact nodes at the other ends of these, None where there is none.
        """
        lattice = self.row.lattice
        u = self.depth - float(self.row.f[node])
        force = lattice.spring_stiffness * u
        for side, other in ((-1, left), (1, right)):
            if other is None:
                force += float(lattice.tail_stiffness(self.row.first + node, side)) * u
                continue
            tie, ground = lattice.surface_stiffnesses(float(abs(other - node)))
            u_other = self.depth - float(self.row.f[other])
            force += float(tie) * (u - u_other) + float(ground) * u
        return force

    def _inner_that_open(self, nodes: Indices, noise: float) -> list[int]:
        """Nodes between contact links whose opening alone, others as they are, lowers the energy.

        A node that is pulled by F and opens moves by F/S and gains F²/2S, where it loses the
        adhesion W of both its links, of itself without tension. So it may open if F² > 2 S W with
        the least stiffness S, F less the rounding of a force; whether it does is found by relaxing
        these nodes one by one. At the depth of an event a node is on the verge of it.
        """
        model = self.model
        lattice = model.lattice
        adhesion = self._opening_adhesion(nodes)
        if lattice.gamma1:  # link i is the one after node i
            adhesion = adhesion + self._opening_adhesion(nodes - 1)
        both_links = model.links[nodes] + model.links[nodes - 1]
        stiffness = lattice.k * model.cells[nodes] + self._two_links * both_links
        pulls = -self.balance.forces[nodes] - noise * model.cells[nodes] / lattice.cell
        suspects = pulls**2 > 2 * stiffness * adhesion
        return [i for i in nodes[suspects].tolist() if self._opening_pays(i)]

    def _opening_pays(self, node: int) -> bool:
        """Whether the energy is less with this node free, and both beside it as they are.

        Judged by the energy of these three nodes and the two links between them alone, in which the
        free node comes to rest between both others. What is beyond these does not change.
        """
        u = self.u[node - 1 : node + 2]
        bonds = self._opening_adhesion(np.array([node - 1, node]))
        first = self.model.first + node - 1
        no_tails = (False, False)
        lattice = self.model.lattice
        closed = NodalEnergy(lattice, (True, True, True), first, bonds, no_tails)
        opened = NodalEnergy(lattice, (True, False, True), first, bonds, no_tails)
        return bool(closed.value(u) > opened.value(opened.relaxed(u)))

    @functools.cached_property
    def certificate(self) -> Certificate:
        """The violations of the conditions of the module.

        `worst` is the largest of its arguments and 0, nan if one is nan. Without adhesion `size` is
        0 where d = 0 and both outermost lines are at height 0. Contacts in between may be pressed:
        |u| at the lowest node is the size then.
        """
        delta = self.size or self._size_of_rounding
        if delta == 0:  # touching, nothing deformed
            return Certificate.undeformed()
        lattice = self.row.lattice
        unit = lattice.spring_stiffness * delta  # of forces
        noise = (lattice.spring_stiffness + 4 * lattice.link_stiffness) * self._unknown_gap
        free = np.flatnonzero(~self.model.contact)
        # The nodes beside the contact need not be among those that are looked at; g - u there.
        beside = -self._next_link(_CLOSING).gap
        penetrations = np.append(self.g[free] - self.u[free], beside)
        forces = np.abs(self.balance.forces[free]) / self.model.cells[free] * lattice.cell
        return Certificate(
            penetration=float(np.fmax.reduce(penetrations, initial=0.0)) / delta,
            stationarity=worst(float(forces.max(initial=0.0)) - noise) / unit,
            opening=worst(self.pull(noise) - noise) / unit,
            neighbours=self._gain_of_neighbours(),
            force=self._mismatch_of_forces(free) / (self.balance.sizes or 1.0),
        )

    @property
    def _size_of_rounding(self) -> float:
        """δ, but at least |d - f| at the lowest node: by it rounding is judged [length]."""
        return max(self.size, abs(self.depth - self.row.lowest))

    @property
    def _unknown_gap(self) -> float:
        """What double precision leaves of a gap [length]."""
        return _ROUNDINGS * self._size_of_rounding

    def _next_link(self, link: int) -> Advances:
        """Changes (2m,) as each line passes the link at this place among LINKS.

        link: _CLOSING or _OPENING. Of the link that a line would close the gap is nan where it may
        not; see `closes`.
        """
        found = Advances(*(part[0, :, link] for part in self.passed))
        if link == _OPENING:
            return found
        return found._replace(gap=np.where(self.closes, found.gap, math.nan))

    def _gain_of_neighbours(self) -> float:
        """The largest gain of energy by closing or opening a link, over the terms of that change.

        Closing stores S v²/2 and gains the adhesion, opening the reverse. The gap v is known up to
        rounding: it is taken as large when closing, and as small when opening, as it may be. nan,
        where there is no such link or it may not close, counts as no gain.
        """
        unknown = self._unknown_gap
        works = self.row.works
        closing = self._next_link(_CLOSING)
        adhesion = works[0] * closing.bonds
        relative = unknown / np.where(closing.gap, np.abs(closing.gap), 1.0)
        by_closing = adhesion - closing.stored * (1 + relative) ** 2
        by_closing = by_closing / (adhesion + closing.stored + _TINY)

        opening = self._next_link(_OPENING)
        adhesion = works[1] * opening.bonds
        size = np.where(opening.gap, np.abs(opening.gap), 1.0)
        least = np.maximum(opening.gap - unknown, 0.0) / size  # of the gap, over the gap
        by_opening = opening.stored * least**2 - adhesion
        by_opening = by_opening / (adhesion + opening.stored + _TINY)
        return float(np.fmax.reduce([by_closing, by_opening], axis=None, initial=0.0))

    def _mismatch_of_forces(self, free: Indices) -> float:
        """|dU/dd - kΔx Σ u_i| beyond rounding; dU/dd is the sum of forces on the contact nodes.

        free: the nodes that are not in contact. Of both ends of a link beside a contact, one of
        which is free, the right one stands for both: they are alike in size where nodes resolve l.
        """
        balance = self.balance
        model = self.model
        lattice = model.lattice
        beside = np.flatnonzero(model.contact[1:] != model.contact[:-1])  # links at the lines
        stiffness = lattice.gamma1 / lattice.spacing**2 * model.links[beside]
        ties = stiffness @ np.abs(self.u[beside + 1])
        rounding = EPSILON * (4 * balance.tension + 2 * float(ties))
        pressed = balance.forces.sum() - balance.forces[free].sum()
        return max(0.0, abs(balance.force - float(pressed)) - rounding)


def on_row(row: Row, nodes: Contacts, depth: float, *, narrow: bool = False) -> State:
    """The state with these contacts: u = d - f in contact, and exact beside it.

    Parameters
    ----------
    row : Row
    nodes : Contacts
        First and last nodes of the contacts, from left to right.
    depth : float
        [length].
    narrow : bool
        Whether lone nodes stand for contacts narrower than a link.

    Returns
    -------
    State
        Looked at are the contact's own nodes if f is convex, else all.
    """
    own = slice(nodes[0][0], nodes[-1][1] + 1) if row.clear else slice(0, row.size)
    contact = np.zeros(own.stop - own.start, bool)
    for first, last in nodes:
        contact[first - own.start : last - own.start + 1] = True
    work = row.works[0] * row.bonds[own.start : own.stop - 1] if row.scene.pattern else None
    model = NodalEnergy(row.lattice, contact, row.first + own.start, work)
    g = depth - row.f[own]
    u = g
    lines = np.reshape(nodes, (1, -1))
    closes = np.full(lines.size, True)
    if not row.clear:
        u = np.where(contact, g, _free_surface(row, nodes, depth))
        closes = _clear_beyond(row, lines[0].tolist(), depth)
    passed = advances(row, lines, np.array([depth]))
    _close_last_links_together(passed, lines[0])
    return State(row, nodes, depth, row.works[0], model, u, g, passed, closes, narrow)


def _free_surface(row: Row, nodes: Contacts, depth: float) -> Array:
    """Displacements of all nodes of a row (n,), of which only those that are free are right.

    `surface` of nodes/obstacle.py is that through given nodes, here those at the lines, in between
    and beyond, as if all others were free.
    """
    lines = np.unique(nodes)
    every = row.first + np.arange(row.size)
    return surface(row.lattice, row.first + lines, depth - row.f[lines], every)


def _clear_beyond(row: Row, lines: list[int], depth: float) -> Mask:
    """Which lines (2m,) leave the surface nowhere in the indenter when they close another link.

    lines: contact nodes at all lines, from left to right. `row.thresholds` are those of contacts
    that close and of contacts that open; `Thresholds.clears(left, right, depth)` is whether the
    free surface between two contact nodes is out of the indenter, None where there is none on that
    side. If a line meets the one that it faces no free node is left, and the surface is clear.
    """
    ends: list[Any] = [None, *lines, None]
    found = np.full(len(lines), True)
    for i, side in enumerate(facing_sides(len(lines)).tolist()):
        moved = ends[i + 1] + side
        faced = ends[i + 1 + side]
        left, right = (moved, faced) if side > 0 else (faced, moved)
        found[i] = row.thresholds[0].clears(left, right, depth)
    return found


def _close_last_links_together(passed: Advances, lines: Array) -> None:
    """Count the bonds of both links where two are left between lines, which close at once.

    The only free node between them is in contact then. Changed in `passed`; lines (2m,) are the
    nodes of all lines, and each of both lines closes both links.
    """
    two_left = np.repeat(lines[2::2] - lines[1:-1:2] == 2, 2)
    inner = passed.bonds[0, 1:-1]
    inner[:, _CLOSING] += np.where(two_left, inner[:, _CLOSING + 1], 0.0)
