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
    """Totals over one contact set: energy terms, force by two routes, weakest node and link."""

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
    right = _half(lat, indenter, depth, middle, last)
    mirror = mirror_axis(lat, indenter, first, last) is not None
    left = right if mirror else _half(lat, indenter, depth, middle, first)
    ends = left.end, right.end
    outside = [float(lat.tail_force(u)) for u in ends]
    surface = left.surface + right.surface
    adhesive = last - first if lat.gamma1 else last - first + 1
    weakest = min(left.weakest, right.weakest)
    if first < middle < last:
        weakest = min(weakest, left.middle_pull + right.middle_pull)
    return Sums(
        springs=lat.spring / 2 * (left.squares + right.squares),
        surface=surface,
        adhesion=lat.adhesion(adhesive, surface),
        tails=sum(float(lat.tail_energy(u)) for u in ends),
        force=lat.spring * (left.total + right.total) + sum(outside),
        force_by_reactions=left.reactions + right.reactions,
        weakest=weakest,
        force_scale=lat.spring * (left.size + right.size) + sum(map(abs, outside)),
        stiffness=min(left.stiffness, right.stiffness),
    )


def _half(lat: Lattice, indenter: Indenter, depth: float, middle: int, end: int) -> _Half:
    side, links = (1 if end >= middle else -1), abs(end - middle)
    squares = surface = total = size = reactions = middle_pull = 0.0
    weakest, stiffness = math.inf, lat.link
    for start in range(0, max(links - 1, 1), BLOCK):  # blocks share two nodes, a link and its ends
        stop = middle + side * min(start + BLOCK + 1, links)
        f = heights(lat, indenter, np.arange(middle + side * start, stop + side, side, dtype=float))
        g, step = depth - f, f[:-1] - f[1:]
        tension, own = lat.tension(step), g[1:-1]
        if start == 0:
            half = float(g[0]) / 2
            squares, total, size = 2 * half * half, half, abs(half)
            middle_pull = lat.spring * half - (float(tension[0]) if links else 0.0)
        squares += float(own.dot(own))
        surface += lat.surface_energy(step if stop == end else step[:-1])
        total += float(own.sum())
        size += dasum(own) if own.size else 0.0
        pull = lat.spring * own
        pull -= tension[1:]
        pull += tension[:-1]
        reactions += float(pull.sum())
        weakest = min(weakest, float(pull[pull.argmin()]) if links > 1 else math.inf)
        stiffness = min(stiffness, lat.least_stiffness(step))
    u = float(g[-1])
    reactions += middle_pull + float(lat.tail_reaction(u))
    if links:
        squares, total, size = squares + u * u, total + u, size + abs(u)
        reactions += lat.spring * u + float(tension[-1])
    return _Half(squares, surface, total, size, reactions, middle_pull, weakest, stiffness, u)
