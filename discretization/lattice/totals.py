"""Energy and force of contacts on the lattice: one pass over their nodes.

The terms are those of `NodalEnergy`; beyond the outermost lines are exact tails. On the way it is
seen whether the free surfaces between contacts are in balance and above the indenter, and what
pulls at the nodes in contact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dasum

from discretization.lattice.contact_set import ContactSet, Mask

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


def totals(contacts: ContactSet) -> Totals:
    """Energy and force with u = g in contact and exact surfaces elsewhere.

    Of a mirrored contact only one half is visited.
    """
    lat, first, last, middle = contacts.lattice, contacts.first, contacts.last, contacts.middle
    start = first if middle is None else middle
    nodes = np.arange(start, last + 1, dtype=float)
    g = contacts.depth - contacts.ground.heights(start, last)
    u, free = contacts.surface(start, g)
    step = u[1:] - u[:-1]
    tension, weighted = lat.on_links(lat.link * step, nodes), lat.on_nodes(u, nodes)
    force = lat.spring * weighted
    force[:-1] -= tension
    force[1:] += tension
    held = force if free is None else force[~free]
    surface = lat.on_links(lat.link / 2 * step * step, nodes).sum()
    parts = (weighted.dot(u), weighted.sum(), dasum(weighted), surface, held.sum())
    added, pulls = np.array(parts), [float(force[0]), float(force[-1])]
    weakest, least_lone, imbalance = _worst(
        contacts, start, lat.per_weight(force[1:-1], nodes[1:-1]), free
    )
    if middle is not None:
        own = float(weighted[0])
        added = 2 * added - np.array([own * u[0], own, abs(own), 0.0, lat.spring * own])
        whole = 2 * pulls[0] - lat.spring * own
        weakest = min(weakest, lat.per_weight(whole, middle) if first < middle else math.inf)
        pulls[0] = pulls[1]
    places, u_ends = (lat.at(first, -1), lat.at(last, 1)), contacts.ends[1].ravel()[[0, -1]]
    beyond = [float(p.tail_reaction(u)) for p, u in zip(places, u_ends, strict=True)]
    outside = [float(p.tail_force(u)) for p, u in zip(places, u_ends, strict=True)]
    squares, total, size, surface, reactions = added.tolist()
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
        penetration=-math.inf if free is None else float((g - u)[free].max()),
        imbalance=imbalance,
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


def _worst(
    contacts: ContactSet, first: int, force: Array, free: Mask | None
) -> tuple[float, float, float]:
    """The weakest and the least lone node, and the imbalance, between the outermost nodes.

    force: per weight, from the second node on.
    """
    lone = math.inf
    if not force.size:
        return math.inf, lone, 0.0
    pulled = force
    if contacts.ground.bonds is not None:
        share = _held(contacts, first + 1, force.size)
        bound = share > _UNBOUND
        pulled = np.where(bound, force / np.where(bound, share, 1.0), math.inf)
        lone = float(force[~bound & (True if free is None else ~free[1:-1])].min(initial=math.inf))
    if free is None:
        return float(pulled[pulled.argmin()]), lone, 0.0
    held = ~free
    inner, links = held[1:-1], held[:-2].astype(int) + held[2:]
    weakest = pulled[inner & (links == 2)].min(initial=math.inf)
    lone = min(lone, float(force[inner & (links == 0)].min(initial=math.inf)))
    return float(weakest), lone, float(np.abs(force[~inner]).max(initial=0.0))


def _held(contacts: ContactSet, first: int, count: int) -> Array:
    """What two links hold these nodes by, over what they do where a pattern's factor is 1."""
    ground, lat = contacts.ground, contacts.lattice
    assert ground.bonds is not None
    start = first - 1 - ground.where.first
    bonds = ground.bonds[start : start + count + 1]
    both = lat.per_weight(bonds[1:] + bonds[:-1], first + np.arange(count))
    return np.asarray(np.sqrt(both / (2 * lat.cell)))
