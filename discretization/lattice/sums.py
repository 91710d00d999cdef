"""Energy and force of one contact on the lattice: one pass over its nodes, in blocks.

In contact u = g, outside are exact tails, so both are sums over the contact alone. The terms are
those of `NodalEnergy`, which sums them over all nodes; `contact_set.totals` does so for any number
of contacts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dasum

from discretization.lattice.fronts import BLOCK, Contact, heights, mirror_axis
from discretization.lattice.nodes import Lattice
from energy import Indenter


class Sums(NamedTuple):
    """Totals over one contact set: energy terms, force by two routes, weakest node and link.

    weakest: the least pull per weight of an inner node, of `Lattice.on_nodes`.
    """

    springs: float
    surface: float
    adhesion: float
    tails: float
    force: float
    force_by_reactions: float
    weakest: float
    force_scale: float
    stiffness: float

    @property
    def energy(self) -> float:
        """U [energy/length]."""
        return self.springs + self.surface + self.adhesion + self.tails

    @property
    def energy_scale(self) -> float:
        """Sum of the terms' absolute values: what rounding is relative to."""
        return self.springs + self.surface - self.adhesion + self.tails


class _Half(NamedTuple):
    """Sums over the contact nodes from its middle (half a node there) outwards to one end."""

    squares: float
    surface: float
    total: float
    size: float
    reactions: float
    middle_pull: float
    weakest: float
    stiffness: float
    end: float


def measured(lattice: Lattice, indenter: Indenter, depth: float, contact: Contact) -> Sums:
    """Energy and force of the contact set first..last with u = g there and exact tails.

    The terms are those of `NodalEnergy`, summed in blocks that stay in the cache; of a symmetric
    contact only one half is visited.
    """
    lat, (first, last) = lattice, contact[:2]
    middle = (first + last) // 2
    right = _half(lat, indenter, depth, middle, last, 1)
    mirror = mirror_axis(lat, indenter, first, last) is not None
    left = right if mirror else _half(lat, indenter, depth, middle, first, -1)
    ends = (lat.at(first, -1), left.end), (lat.at(last, 1), right.end)
    outside = [float(end.tail_force(u)) for end, u in ends]
    surface = left.surface + right.surface
    weakest = min(left.weakest, right.weakest)
    if first < middle < last:
        pull = left.middle_pull + right.middle_pull
        weakest = min(weakest, float(lat.per_weight(pull, middle)))
    return Sums(
        springs=lat.spring / 2 * (left.squares + right.squares),
        surface=surface,
        adhesion=lat.adhesion(lat.bound(first, last), surface),
        tails=sum(float(end.tail_energy(u)) for end, u in ends),
        force=lat.spring * (left.total + right.total) + sum(outside),
        force_by_reactions=left.reactions + right.reactions,
        weakest=weakest,
        force_scale=lat.spring * (left.size + right.size) + sum(map(abs, outside)),
        stiffness=min(left.stiffness, right.stiffness),
    )


def _half(
    lat: Lattice, indenter: Indenter, depth: float, middle: int, end: int, side: int
) -> _Half:
    links = abs(end - middle)
    squares = surface = total = size = reactions = middle_pull = 0.0
    weakest, stiffness = math.inf, lat.link
    for start in range(0, max(links - 1, 1), BLOCK):  # blocks share two nodes, a link and its ends
        stop = middle + side * min(start + BLOCK + 1, links)
        nodes = np.arange(middle + side * start, stop + side, side, dtype=float)
        f, inner = heights(lat, indenter, nodes), nodes[1:-1]
        g, step = depth - f, f[:-1] - f[1:]
        tension, own = lat.on_links(lat.tension(step), nodes), g[1:-1]
        weighted = lat.on_nodes(own, inner)
        if start == 0:
            half = float(lat.on_nodes(g[0], middle)) / 2
            squares, total, size = half * float(g[0]), half, abs(half)
            middle_pull = lat.spring * half - (float(tension[0]) if links else 0.0)
        squares += float(weighted.dot(own))
        whole = slice(None if stop == end else -1)
        surface += lat.surface_energy(step[whole], nodes[whole])
        total += float(weighted.sum())
        size += dasum(weighted) if own.size else 0.0
        pull = lat.spring * weighted
        pull -= tension[1:]
        pull += tension[:-1]
        reactions += float(pull.sum())
        pull = lat.per_weight(pull, inner)
        weakest = min(weakest, float(pull[pull.argmin()]) if links > 1 else math.inf)
        stiffness = min(stiffness, lat.least_stiffness(step))
    u = float(g[-1])
    reactions += middle_pull + float(lat.at(end, side).tail_reaction(u))
    if links:
        own_u = float(lat.on_nodes(u, end))
        squares, total, size = squares + own_u * u, total + own_u, size + abs(own_u)
        reactions += lat.spring * own_u + float(tension[-1])
    return _Half(squares, surface, total, size, reactions, middle_pull, weakest, stiffness, u)
