"""Any number of contacts on the lattice: their surface, totals and certificate.

The free surface between and beyond the contacts is exact (span.py). The certificate's conditions
are those of judgement.py, with no shortcut for a single contact:

    penetration   over all free nodes within the outermost tails, and 16 nodes beyond
    stationarity  |∂U/∂u_i| on every free node there, of `NodalEnergy`
    opening       on every contact node: a lone one may not be pulled at all, one between two
                  contact nodes no more than its two links hold
    neighbours    every line by one link either way, where the surface then stays above the
                  indenter; ΔE = ± [(K_1 + K_{T-1} - t sinh μ) gap² - wΔx], T links to the next
                  contact, as a fraction of its terms; a gap of T = 2 closes with two links
    force         sum of the nodal forces on the contacts against kΔx Σ u_i over the whole line
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.lattice import fronts, span
from discretization.lattice.judgement import rounding
from discretization.lattice.nodal_energy import NodalEnergy
from discretization.lattice.nodes import Lattice
from discretization.lattice.row import Row
from discretization.lattice.shortest_path import window
from discretization.lattice.sums import Sums
from energy import Indenter

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]
_BEYOND = 16
_TINY = np.finfo(float).tiny


@dataclass(frozen=True, eq=False)
class ContactSet:
    """Contacts among n nodes in a row.

    g (n,): d - f, -inf where there is no indenter; ends (m, 2), m >= 1: first and last node of each
    contact, counted from the first of the row; depth d; closing, opening (n - 1,): adhesion
    [energy/length] of each link when a contact is closed over it and opened; first: the lattice's
    number of the first node.
    """

    lattice: Lattice
    g: Array
    ends: Nodes
    depth: float
    closing: Array
    opening: Array
    first: int = 0

    @classmethod
    def of(
        cls, lattice: Lattice, indenter: Indenter, depth: float, where: fronts.Region, nodes: Nodes
    ) -> ContactSet:
        """Contacts with these first and last nodes (m, 2), among all nodes where contact could be.

        These are those of `window`, and a few beyond the outermost contacts.
        """
        first, g = window(lattice, indenter, depth)
        lo = min(first, int(nodes[0, 0])) - _BEYOND
        lo = lo if math.isnan(lattice.axis) else 0
        hi = max(first + g.size - 1, int(nodes[-1, 1])) + _BEYOND
        known = np.arange(max(lo, where.first), min(hi, where.last) + 1)
        g = depth - fronts.heights(lattice, indenter, known.astype(float))
        beyond = int(known[0]) - lo, hi - int(known[-1])
        g = np.pad(g, beyond, constant_values=-math.inf)
        work = np.full(g.size - 1, lattice.w * lattice.cell)
        work = lattice.on_links(work, np.arange(lo, hi + 1))
        return cls(lattice, g, np.asarray(nodes, np.int64) - lo, depth, work, work, lo)

    @classmethod
    def on_row(cls, row: Row, depth: float, nodes: Nodes) -> ContactSet:
        """Contacts with these first and last nodes (m, 2) of a row.

        Among all its nodes, or, where no other can be touched, those near the contacts.
        """
        start, stop = 0, row.f.size
        if row.clear:
            start, stop = max(int(nodes[0, 0]) - _BEYOND, 0), int(nodes[-1, 1]) + _BEYOND
        f = row.f[start:stop]
        before = _BEYOND if math.isnan(row.lattice.axis) else min(_BEYOND, row.first + start)
        pad = before, _BEYOND
        closing, opening = (np.pad(one.bonds[start : start + f.size - 1], pad) for one in row.rules)
        g = np.pad(depth - f, pad, constant_values=-math.inf)
        ends, first = np.asarray(nodes) - start + before, row.first + start - before
        return cls(row.lattice, g, ends, depth, closing, opening, first)

    @functools.cached_property
    def mask(self) -> Mask:
        """(n,) whether a node is in contact."""
        return span.mask_of(self.g.size, self.ends)

    @functools.cached_property
    def u(self) -> Array:
        """Displacements (n,)."""
        return self.lattice.relaxed(self.g, self.mask, self.first)

    @functools.cached_property
    def force(self) -> Array:
        """∂U/∂u_i (n,): of the indenter on contact nodes, imbalance on free ones."""
        return self.model.gradient(self.u)

    @functools.cached_property
    def model(self) -> NodalEnergy:
        """The energy of these nodes."""
        return NodalEnergy(self.lattice, self.mask, self.first)

    @functools.cached_property
    def per_weight(self) -> Array:
        """`force` over the nodes' weights (n,)."""
        return np.asarray(self.lattice.per_weight(self.force, self.model.nodes))

    @property
    def scale(self) -> float:
        """δ: the largest of |d|, |u| and δ₀."""
        nodes, lattice = self.model.nodes, self.lattice
        heaviest = lattice.on_links(np.ones(nodes.size - 1), nodes)
        lift = math.sqrt(2 * float((self.opening / heaviest).max()) / lattice.spring)
        return max(abs(self.depth), float(np.abs(self.u).max()), lift)


def totals(contacts: ContactSet) -> Sums:
    """Energy and force of a contact set."""
    lat, u = contacts.lattice, contacts.u
    terms, (left, right) = contacts.model.terms(u), contacts.model.ends
    if lat.gamma1:
        bound = contacts.mask[1:] & contacts.mask[:-1]
        terms["adhesion"] = -float(contacts.closing[bound].sum())
    outside = [float(left.tail_force(u[0])), float(right.tail_force(u[-1]))]
    weighted = lat.on_nodes(u, contacts.model.nodes)
    return Sums(
        **terms,
        force=lat.spring * float(weighted.sum()) + sum(outside),
        force_by_reactions=float(contacts.force[contacts.mask].sum()),
        weakest=float(contacts.per_weight[contacts.mask].min()),
        force_scale=lat.spring * float(np.abs(weighted).sum()) + sum(map(abs, outside)),
        stiffness=lat.link,
    )


def judged(contacts: ContactSet, sums: Sums) -> Certificate:
    """Certificate of a contact set with these totals."""
    lat, delta = contacts.lattice, contacts.scale
    if delta == 0:  # touching, nothing deformed
        return Certificate.undeformed()
    unit, noise = lat.spring * delta, rounding(lat, delta)
    imbalance = float(np.abs(contacts.per_weight[~contacts.mask]).max()) - noise
    plain = math.isnan(lat.axis) and lat.slopes == "small"
    gain = float(_moves(contacts).max()) if plain else gained(contacts, sums)
    return Certificate(
        penetration=max(0.0, float((contacts.g - contacts.u).max()) / delta),
        stationarity=max(0.0, imbalance / unit),
        opening=max(0.0, (_pulled(contacts) - noise) / unit),
        neighbours=max(0.0, gain),
        force=abs(sums.force - sums.force_by_reactions) / (sums.force_scale or 1.0),
    )


def gained(contacts: ContactSet, sums: Sums) -> float:
    """Largest energy gained by a line that moves by one link, over that of the state's terms.

    With every surface relaxed anew; not counted where it would not stay above the indenter then.
    """
    lat, g, mask = contacts.lattice, contacts.g, contacts.mask
    own, best = sums.springs + sums.surface + sums.tails, 0.0
    noise = 32 * float(np.finfo(float).eps) * contacts.scale
    sides = ((first, -1) for first in contacts.ends[:, 0].tolist())
    for line, side in (*sides, *((last, 1) for last in contacts.ends[:, 1].tolist())):
        for node, work in ((line + side, contacts.closing), (line, contacts.opening)):
            if not 0 <= node < g.size or not np.isfinite(g[node]):
                continue
            moved = mask.copy()
            moved[node] ^= True
            u = lat.relaxed(g, moved, contacts.first)
            links = (moved[1:] & moved[:-1]) != (mask[1:] & mask[:-1])
            if moved.any() and links.any() and not (g - u > noise).any():
                terms = NodalEnergy(lat, moved, contacts.first).terms(u)
                stored = terms["springs"] + terms["surface"] + terms["tails"]
                adhesion = float(work[links].sum())
                best = max(best, own - stored + (adhesion if moved[node] else -adhesion))
    return best / (sums.energy_scale or 1.0)


def _pulled(contacts: ContactSet) -> float:
    """Largest tension on a contact node beyond what holds it; the end of a contact is a line."""
    lat, mask = contacts.lattice, contacts.mask
    links = mask[1:-1] * (mask[:-2].astype(int) + mask[2:])
    work = lat.per_weight(contacts.opening[1:] + contacts.opening[:-1], contacts.model.nodes[1:-1])
    held = np.sqrt(2 * (lat.spring + 2 * lat.link) * work)
    pull = -contacts.per_weight[1:-1] - np.where(links == 2, held, 0.0)
    return float(pull[mask[1:-1] & (links != 1)].max(initial=0.0))


def _moves(contacts: ContactSet) -> Array:
    """Energy gained by each move of a line by one link, over the move's terms; > 0 is downhill."""
    lat, g, u, ends = contacts.lattice, contacts.g, contacts.u, contacts.ends
    noise = 32 * float(np.finfo(float).eps) * contacts.scale
    mirrored = g.size - 1 - ends[::-1, ::-1]
    works = contacts.closing, contacts.opening
    right = _right_lines(lat, g, u, ends, noise, *works)
    left = _right_lines(lat, g[::-1], u[::-1], mirrored, noise, *(work[::-1] for work in works))
    return np.concatenate([*right, *left])


def _right_lines(
    lat: Lattice, g: Array, u: Array, ends: Nodes, noise: float, closing: Array, opening: Array
) -> tuple[Array, Array]:
    """The gain of each right line's moves: one link further, and one link back."""
    last = ends[:, 1]
    T = np.append(ends[1:, 0] - last[:-1], math.inf)
    facing = np.append(g[ends[1:, 0]], 0.0)

    ahead = np.isfinite(g[last + 1])
    gap = np.where(ahead, u[last + 1] - g[last + 1], 0.0)
    won = closing[last] + np.where(T == 2, closing[np.minimum(last + 1, closing.size - 1)], 0.0)
    cost, size = _lifted(lat, gap + noise, T - 1), _lifted(lat, gap, T - 1)
    allowed = ahead & _clears(lat, u - g, ends, gap, noise)
    further = np.where(allowed, (won - cost) / (won + size + _TINY), 0.0)

    before, long, lost = last - 1, last > ends[:, 0], opening[last - 1]
    gap = -span.excess(lat, np.ones(T.size), T, g[before], g[last], facing)
    gain, size = _lifted(lat, np.maximum(gap - noise, 0.0), T), _lifted(lat, gap, T)
    allowed = long & (gap >= -noise)  # else the node that is let go would be penetrated
    return further, np.where(allowed, (gain - lost) / (lost + size + _TINY), 0.0)


def _lifted(lat: Lattice, gap: Array, links: Array) -> Array:
    """(K_1 + K_T - t sinh μ) gap²: lifting a node beside a line, T links from the next one."""
    beyond = span.stiffness(lat, links) - span.unit(lat)
    return np.asarray((lat.link_over_decay / 2 + beyond) * gap * gap)


def _clears(lat: Lattice, clear: Array, ends: Nodes, gap: Array, noise: float) -> Mask:
    """(m,) whether the surface clears the indenter right of each contact if one more node is held.

    clear (n,): u - g; gap (m,): that of the node. The surface there comes down by it, at any other
    free node by the share it has of it.
    """
    nodes = np.flatnonzero(span.mask_of(clear.size, ends)[ends[0, 1] :] == 0) + ends[0, 1]
    right = np.append(ends[1:, 0], clear.size)
    line = np.repeat(np.arange(gap.size), right - ends[:, 1] - 1)
    near = (clear[nodes] < gap[line] - noise) & (nodes > ends[line, 1] + 1)
    nodes, line = nodes[near], line[near]
    q = np.append(ends[1:, 0], math.inf)[line] - nodes
    falls = gap[line] * span.shares(lat.log_decay, nodes - ends[line, 1] - 1.0, q)[0]
    allowed = np.ones(gap.size, bool)
    allowed[line[clear[nodes] < falls - noise]] = False
    return allowed
