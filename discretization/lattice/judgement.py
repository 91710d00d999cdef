"""Certificate of one contact on the lattice, or none.

The conditions of ../certificate.py, held against the contact set's own sums (sums.py):

    penetration   max (g_i - u_i)/δ over the free nodes contact could reach,      <= tolerance
    stationarity  max |∂U/∂u_i| / kΔxδ over the first free nodes of both tails,   <= tolerance
    opening       a contact node pulled (∂U/∂u_i < 0) may only be held by its adhesion: opening
                  that node alone, -r²/(2(kΔx+2t)) + 2wΔx, must not lower the energy
                  (finite slopes: t that of the steepest link, its smallest; a lone node has none)
    neighbours    no move of one contact line by one link lowers the energy
    force         dU/dd (sum of nodal forces on the contact) against kΔx Σ u_i over the whole line

δ is the largest of |d|, |u| at the lines and δ₀, so that no unit enters; what double precision
leaves in a nodal force, 32 ε (kΔx + 4t) δ, or in their sum, 4 ε √Σ(link tension)², is not counted.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.lattice.fronts import FIRST_BLOCK, Contact, Region, blocks, height
from discretization.lattice.line import End, ends_of
from discretization.lattice.nodes import Lattice
from discretization.lattice.sums import Sums
from energy import Indenter

Array = NDArray[np.float64]
_TAIL = np.arange(1.0, FIRST_BLOCK + 1)
_EPSILON = float(np.finfo(float).eps)


def detached(lattice: Lattice, indenter: Indenter, depth: float, where: Region) -> Certificate:
    """Judge the state without contact."""
    lowest = height(lattice, indenter, where.lowest)
    scale = max(abs(depth), math.sqrt(2 * lattice.w / lattice.k)) or 1.0
    return Certificate.undeformed(max(0.0, (depth - lowest) / scale))


def certify(
    lattice: Lattice, indenter: Indenter, depth: float, where: Region, contact: Contact, sums: Sums
) -> Certificate:
    """Judge the state with this contact."""
    ends = ends_of(lattice, indenter, depth, where, contact)
    return judged(lattice, indenter, depth, contact, sums, ends)


def judged(
    lattice: Lattice,
    indenter: Indenter,
    depth: float,
    contact: Contact,
    sums: Sums,
    ends: list[End],
) -> Certificate:
    """Judge the state with this contact, whose `ends_of` are these."""
    lat = lattice
    u_ends = [depth - float(end.f[0]) for end in ends]
    delta = max(abs(depth), *map(abs, u_ends), math.sqrt(2 * lat.w / lat.k))
    if delta == 0:  # touching in one point, nothing deformed
        return Certificate.undeformed()
    penetration = stationarity = 0.0
    for end, u in zip(ends, u_ends, strict=True):
        tail = np.concatenate([[u], lat.beyond(end.node, end.side, _TAIL, u)])
        penetration = max(penetration, _penetration(lat, indenter, depth, end, u, tail) / delta)
        excess = _imbalance(lat, end, tail) - rounding(lat, delta)
        stationarity = max(stationarity, excess / (lat.spring * delta))
    apart = abs(sums.force - sums.force_by_reactions) - _summed_rounding(lat, contact, sums)
    force = max(0.0, apart) / (sums.force_scale or 1.0)
    return Certificate(
        penetration,
        stationarity,
        _opening(lat, contact, sums, delta),
        _descent(lat, contact, ends) / (sums.energy_scale or 1.0),
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
    deepest = 0.0
    rest = blocks(lat, indenter, end.node + end.side * (end.f.size - 1), end.limit)
    for start, f in itertools.chain([(end.node, end.f)], rest):
        if start != end.node:
            steps = np.arange(float(f.size)) + abs(start - end.node)
            tail = lat.beyond(end.node, end.side, steps, u)
        through = depth - f[1:]
        through -= tail[1 : f.size]
        if through.size:
            deepest = max(deepest, float(through[through.argmax()]))
        if (rising and f[-1] >= clear) or (indenter.convex and u >= 0):
            break
    return deepest


def _imbalance(lat: Lattice, end: End, tail: Array) -> float:
    """max |∂U/∂u_i| per weight over the free nodes of a tail, all but its first."""
    nodes = range(end.node, end.node + end.side * tail.size, end.side)
    tension = lat.on_links(lat.tension(tail[1:] - tail[:-1]), nodes)
    force = lat.spring * lat.on_nodes(tail[1:], nodes[1:])
    force += tension
    force[:-1] -= tension[1:]
    force[-1] += lat.at(nodes[-1], end.side).tail_reaction(tail[-1])
    size = np.abs(lat.per_weight(force, nodes[1:]))
    return float(size[size.argmax()])


def rounding(lat: Lattice, delta: float) -> float:
    """What a nodal force of displacements of size δ can be off by in double precision."""
    return 32 * _EPSILON * (lat.spring + 4 * lat.link) * delta


def _summed_rounding(lat: Lattice, contact: Contact, sums: Sums) -> float:
    """What the nodal forces' sum can be off by: every link's tension T enters twice, 4 ε √ΣT²."""
    return 4 * _EPSILON * math.sqrt(2 * sums.surface * lat.link * lat.on_nodes(1.0, contact.last))


def _opening(lat: Lattice, contact: Contact, sums: Sums, delta: float) -> float:
    """Tension on the weakest contact node beyond what its adhesion holds, over kΔxδ."""
    lone = contact.first == contact.last
    weakest = sums.force_by_reactions if lone else sums.weakest
    adhesive = 2 if lat.gamma1 else 1
    if lone and lat.gamma1:
        adhesive = 0
    held = math.sqrt(2 * (lat.spring + 2 * sums.stiffness) * adhesive * lat.w * lat.cell)
    return max(0.0, -weakest - held - rounding(lat, delta)) / (lat.spring * delta)


def _descent(lat: Lattice, contact: Contact, ends: list[End]) -> float:
    """Largest energy gain among the moves of one line by one link."""
    gain = 0.0
    for end in ends:
        ahead, back = -end.start, -end.start - 1
        if contact.last > contact.first and end.gap[back] > 0:  # if the surface would part
            gain = max(gain, end.energy[back])
        if end.node != end.limit and (lat.gamma1 or end.gap[ahead] < 0):  # springs: if touched
            gain = max(gain, -end.energy[ahead])
    return gain
