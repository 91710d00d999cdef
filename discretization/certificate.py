"""Is it an equilibrium? One judgement of a contact set, whatever minimiser proposed it.

`measured` sums the nodal energy over the contact in one blocked pass; `certify` holds against it
what an equilibrium on the lattice must satisfy, each as a dimensionless violation:

    penetration   max (g_i - u_i)/δ over the free nodes contact could reach,      <= tolerance
    stationarity  max |∂U/∂u_i| / kΔxδ over the first free nodes of both tails,   <= tolerance
    opening       a contact node pulled (∂U/∂u_i < 0) may only be held by its adhesion: opening
                  that node alone, -r²/(2(kΔx+2t)) + 2wΔx, must not lower the energy
                  (finite slopes: t that of the steepest link, its smallest)
    neighbours    no move of one contact line by one link lowers the energy
    force         dU/dd (sum of nodal forces on the contact) against kΔx Σ u_i over the whole line

δ is the largest of |d|, |u| and δ₀ in the scene, so that no unit enters; what double precision
leaves in a nodal force, 32 ε (kΔx + 4t) δ, or in their sum, 4 ε √Σ(link tension)², is not counted.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dasum

from discretization.lattice.fronts import (
    BLOCK,
    FIRST_BLOCK,
    Contact,
    Region,
    blocks,
    height,
    heights,
    mirror_axis,
)
from discretization.lattice.line import End, ends
from discretization.lattice.nodes import Lattice
from energy import Indenter

Array = NDArray[np.float64]
TOLERANCE = 1e-9
_TAIL = np.arange(1.0, FIRST_BLOCK + 1)
_EPSILON = float(np.finfo(float).eps)


class NotCertifiedError(RuntimeError):
    """The minimiser's state failed its certificate; nothing is returned in its place."""


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


class Certificate(NamedTuple):
    """Violations of the equilibrium conditions (dimensionless, 0 is perfect) and their verdict."""

    penetration: float
    stationarity: float
    opening: float
    neighbours: float
    force: float
    tolerance: float = TOLERANCE

    @property
    def ok(self) -> bool:
        """True if no violation exceeds the tolerance."""
        return not self.failures

    @property
    def failures(self) -> tuple[str, ...]:
        """Names of the violated conditions."""
        *violations, tolerance = self
        named = zip(self._fields, violations, strict=False)
        return tuple(name for name, violation in named if not violation <= tolerance)


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


def certify(
    lattice: Lattice,
    indenter: Indenter,
    depth: float,
    where: Region,
    contact: Contact | None,
    sums: Sums | None,
) -> Certificate:
    """Judge the state with this contact set (None: detached) against its own sums."""
    if contact is None or sums is None:
        lowest = height(lattice, indenter, where.lowest)
        scale = max(abs(depth), math.sqrt(2 * lattice.w / lattice.k)) or 1.0
        return Certificate(max(0.0, (depth - lowest) / scale), 0.0, 0.0, 0.0, 0.0)
    both = ends(lattice, indenter, depth, where, contact)
    return judged(lattice, indenter, depth, contact, sums, both)


def judged(
    lattice: Lattice,
    indenter: Indenter,
    depth: float,
    contact: Contact,
    sums: Sums,
    both: list[End],
) -> Certificate:
    """Judge the state with this contact set, whose `line.ends` are these, against its own sums."""
    lat = lattice
    u_ends = [depth - end.height for end in both]
    delta = max(abs(depth), *map(abs, u_ends), math.sqrt(2 * lat.w / lat.k))
    if delta == 0:  # touching in one point, nothing deformed
        return Certificate(0.0, 0.0, 0.0, 0.0, 0.0)
    penetration = stationarity = 0.0
    distances = lat.spacing * _TAIL
    for end, u in zip(both, u_ends, strict=True):
        tail = np.concatenate([[u], lat.tail.displacement(distances, u)])
        penetration = max(penetration, _penetration(lat, indenter, depth, end, u, tail) / delta)
        excess = _imbalance(lat, tail) - rounding(lat, delta)
        stationarity = max(stationarity, excess / (lat.spring * delta))
    apart = abs(sums.force - sums.force_by_reactions) - _summed_rounding(lat, sums)
    force = max(0.0, apart) / (sums.force_scale or 1.0)
    return Certificate(
        penetration,
        stationarity,
        _opening(lat, contact, sums, delta),
        _descent(lat, contact, both) / (sums.energy_scale or 1.0),
        force,
    )


def _penetration(
    lat: Lattice, indenter: Indenter, depth: float, end: End, u: float, tail: Array
) -> float:
    """max (g_i - u_i) over the free nodes from the contact's end outwards; u of the first: tail.

    A tail pressed down is convex: where the profile is so, too, it can only be met at the line.
    """
    clear = depth + max(0.0, -u)  # beyond this height a rising profile cannot be met any more
    rising = indenter.apex is not None or indenter.convex
    deepest, near = 0.0, end.f[-end.start :]
    rest = blocks(lat, indenter, end.node + end.side * (near.size - 1), end.limit)
    for start, f in itertools.chain([(end.node, near)], rest):
        if start != end.node:
            steps = np.arange(float(f.size)) + abs(start - end.node)
            tail = lat.tail.displacement(lat.spacing * steps, u)
        through = depth - f[1:]
        through -= tail[1 : f.size]
        if through.size:
            deepest = max(deepest, float(through[through.argmax()]))
        if (rising and f[-1] >= clear) or (indenter.convex and u >= 0):
            break
    return deepest


def _imbalance(lat: Lattice, tail: Array) -> float:
    """max |∂U/∂u_i| over the free nodes of a tail, all but its first."""
    tension = lat.tension(tail[1:] - tail[:-1])
    force = lat.spring * tail[1:]
    force += tension
    force[:-1] -= tension[1:]
    force[-1] += lat.tail_reaction(tail[-1])
    size = np.abs(force)
    return float(size[size.argmax()])


def rounding(lat: Lattice, delta: float) -> float:
    """What a nodal force of displacements of size δ can be off by in double precision."""
    return 32 * _EPSILON * (lat.spring + 4 * lat.link) * delta


def _summed_rounding(lat: Lattice, sums: Sums) -> float:
    """What the nodal forces' sum can be off by: every link's tension T enters twice, 4 ε √ΣT²."""
    return 4 * _EPSILON * math.sqrt(2 * sums.surface * lat.link)


def _opening(lat: Lattice, contact: Contact, sums: Sums, delta: float) -> float:
    """Tension on the weakest contact node beyond what its adhesion holds, over kΔxδ."""
    lone = contact.first == contact.last
    weakest = sums.force_by_reactions if lone else sums.weakest
    adhesive = 2 if lat.gamma1 else 1
    if lone and lat.gamma1:
        adhesive = 0
    held = math.sqrt(2 * (lat.spring + 2 * sums.stiffness) * adhesive * lat.w * lat.spacing)
    return max(0.0, -weakest - held - rounding(lat, delta)) / (lat.spring * delta)


def _descent(lat: Lattice, contact: Contact, both: list[End]) -> float:
    """Largest energy gain among the moves of one line by one link."""
    gain = 0.0
    for end in both:
        ahead = -end.start
        back = ahead - 1
        if contact.last > contact.first and end.gap[back] > 0:  # if the surface would part
            gain = max(gain, end.energy[back])
        if end.node != end.limit and (lat.gamma1 or end.gap[ahead] < 0):  # springs: if touched
            gain = max(gain, -end.energy[ahead])
    return gain
