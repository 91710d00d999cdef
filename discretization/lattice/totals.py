"""Energy and force of contacts on the lattice: one pass over their nodes, in blocks.

The terms are those of `NodalEnergy`; beyond the outermost lines are exact tails. On the way it is
seen whether the free surfaces between contacts are in balance and above the indenter, and what
pulls at the nodes in contact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dasum

from discretization.lattice.contact_set import ContactSet, Mask
from discretization.lattice.fronts import BLOCK

Array = NDArray[np.float64]
_UNBOUND = 1e-6  # root of a pattern's factor that is as good as 0


class Totals(NamedTuple):
    """Energy terms and force by two routes of contacts, and what is worst between their ends.

    weakest: the least pull per weight (`Lattice.on_nodes`) of a node between two links in contact,
    over the root of the pattern's factor there; lone: that of a node no adhesion holds;
    penetration, imbalance: the largest of the free nodes between contacts, the latter per weight.
    """

    springs: float
    surface: float
    adhesion: float
    tails: float
    force: float
    force_by_reactions: float
    force_scale: float
    weakest: float
    lone: float
    penetration: float
    imbalance: float

    @property
    def energy(self) -> float:
        """U [energy/length]."""
        return self.springs + self.surface + self.adhesion + self.tails

    @property
    def energy_scale(self) -> float:
        """Sum of the terms' absolute values: what rounding is relative to."""
        return self.springs + self.surface - self.adhesion + self.tails


class _Part(NamedTuple):
    """Sums over nodes in a row and the links between them, and what is worst among them.

    added: of u², u and |u| with the nodes' weights, of the links' energies, and of the forces on
    nodes in contact; least: weakest, lone, -penetration and -imbalance of `Totals`;
    first, last: forces on the outermost nodes, without what is beyond them.
    """

    added: Array
    least: Array
    first: float
    last: float


def totals(contacts: ContactSet) -> Totals:
    """Energy and force with u = g in contact and exact surfaces elsewhere.

    Of a mirrored contact only one half is visited.
    """
    lat, first, last, middle = contacts.lattice, contacts.first, contacts.last, contacts.middle
    part = _between(contacts, first if middle is None else middle, last)
    added, least, pulls = part.added, part.least, [part.first, part.last]
    if middle is not None:
        u = contacts.depth - contacts.ground.lowest
        own = float(lat.on_nodes(u, middle))
        added = 2 * added - np.array([own * u, own, abs(own), 0.0, lat.spring * own])
        whole = 2 * part.first - lat.spring * own
        least[0] = min(least[0], lat.per_weight(whole, middle) if first < middle else math.inf)
        pulls[0] = part.last
    places, u_ends = (lat.at(first, -1), lat.at(last, 1)), contacts.ends[1].ravel()[[0, -1]]
    beyond = [float(p.tail_reaction(u)) for p, u in zip(places, u_ends, strict=True)]
    outside = [float(p.tail_force(u)) for p, u in zip(places, u_ends, strict=True)]
    squares, total, size, surface, reactions = added.tolist()
    weakest, least_lone, clearance, balance = least.tolist()
    return Totals(
        springs=lat.spring / 2 * squares,
        surface=surface,
        adhesion=-sum(contacts.ground.work(*pair) for pair in contacts.nodes),
        tails=sum(float(p.tail_energy(u)) for p, u in zip(places, u_ends, strict=True)),
        force=lat.spring * total + sum(outside),
        force_by_reactions=reactions + sum(beyond),
        force_scale=lat.spring * size + sum(map(abs, outside)),
        weakest=weakest,
        lone=min(least_lone, _lone(contacts, pulls, beyond)),
        penetration=-clearance,
        imbalance=-balance,
    )


def _lone(contacts: ContactSet, pulls: list[float], beyond: list[float]) -> float:
    """The least pull per weight of an outermost node that has no link; inf: none."""
    (first, _), (_, last) = outermost = contacts.nodes[0], contacts.nodes[-1]
    lat = contacts.lattice
    if first == last:
        return float(lat.per_weight(pulls[0] + sum(beyond), first))
    ends = zip(outermost, (first, last), pulls, beyond, strict=True)
    found = [lat.per_weight(pull + tail, node) for (a, b), node, pull, tail in ends if a == b]
    return float(min(found, default=math.inf))


def _between(contacts: ContactSet, start: int, stop: int) -> _Part:
    """What these nodes and those between add."""
    parts = list(_parts(contacts, start, stop))
    if len(parts) == 1:
        return parts[0]
    return _Part(
        np.sum([part.added for part in parts], axis=0),
        np.min([part.least for part in parts], axis=0),
        parts[0].first,
        parts[-1].last,
    )


def _parts(contacts: ContactSet, start: int, stop: int) -> Iterator[_Part]:
    """What blocks of them add, which stay in the cache and share two nodes, a link and its ends.

    One block's arrays are kept until the next one's are there: else their memory is given back to
    the system and asked for again, which takes as long as all the rest.
    """
    lat = contacts.lattice
    for low in range(start, max(stop - 1, start + 1), BLOCK):
        high = min(low + BLOCK + 1, stop)
        nodes = np.arange(low, high + 1, dtype=float)
        g = contacts.depth - contacts.ground.heights(low, high)
        u, free = contacts.surface(low, g)
        step = u[1:] - u[:-1]
        tension, weighted = lat.on_links(lat.link * step, nodes), lat.on_nodes(u, nodes)
        force = lat.spring * weighted
        force[:-1] -= tension
        force[1:] += tension
        own = slice(int(low > start), u.size - int(high < stop))
        whole = slice(None if high == stop else -1)  # of the links
        added = [
            float(weighted[own].dot(u[own])),
            float(weighted[own].sum()),
            dasum(weighted[own]),
            float(lat.on_links(lat.link / 2 * step * step, nodes)[whole].sum()),
            float((force[own] if free is None else force[own][~free[own]]).sum()),
        ]
        worst = _worst(contacts, low, lat.per_weight(force[1:-1], nodes[1:-1]), free)
        clearance = math.inf if free is None else float((u - g)[free].min())
        least = [*worst[:2], clearance, worst[2]]
        yield _Part(np.array(added), np.array(least), float(force[0]), float(force[-1]))


def _worst(
    contacts: ContactSet, low: int, force: Array, free: Mask | None
) -> tuple[float, float, float]:
    """Least of the weakest and of lone nodes, and least -imbalance, between the ends of a block.

    force: per weight.
    """
    lone = math.inf
    if not force.size:
        return math.inf, lone, 0.0
    pulled = force
    if contacts.ground.bonds is not None:
        share = _held(contacts, low + 1, force.size)
        bound = share > _UNBOUND
        pulled = np.where(bound, force / np.where(bound, share, 1.0), math.inf)
        lone = float(force[~bound & (True if free is None else ~free[1:-1])].min(initial=math.inf))
    if free is None:
        return float(pulled[pulled.argmin()]), lone, 0.0
    held = ~free
    inner, links = held[1:-1], held[:-2].astype(int) + held[2:]
    weakest = pulled[inner & (links == 2)].min(initial=math.inf)
    lone = min(lone, float(force[inner & (links == 0)].min(initial=math.inf)))
    return float(weakest), lone, -float(np.abs(force[~inner]).max(initial=0.0))


def _held(contacts: ContactSet, first: int, count: int) -> Array:
    """What two links hold these nodes by, over what they do where a pattern's factor is 1."""
    ground, lat = contacts.ground, contacts.lattice
    assert ground.bonds is not None
    start = first - 1 - ground.where.first
    bonds = ground.bonds[start : start + count + 1]
    both = lat.per_weight(bonds[1:] + bonds[:-1], first + np.arange(count))
    return np.asarray(np.sqrt(both / (2 * lat.cell)))
