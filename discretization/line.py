"""The contact line between the nodes: from the energies of neighbouring contact sets.

A contact that ends at node m has the energy E(m). Between nodes the line is where the interpolated
ΔE changes sign, or at a corner of the profile if ΔE changes sign there by a jump (pinned line).
Force and energy are interpolated at that position through the values of the same contact sets: a
step changes them by `Lattice.advance_energy`, ΔE, and `advance_force`, ΔP = dΔE/dd.

Raw lattice values are off by up to Δx/2 in the line; these are off by O(Δx²).
Positions ζ below are in links outwards from the last contact node, ζ = 0.

A line that faces another contact is found likewise, with the free span in place of the tail. Two
such lines are found in turns; of the energy of both moves together, each adds its own with the
other one half way, which is exact for a quadratic energy.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization import span
from discretization.fronts import Contact, Region, heights, mirror_axis
from discretization.lattice import Lattice
from energy import Indenter

Array = NDArray[np.float64]
Nodes = NDArray[np.int_]
_STENCIL = np.arange(-3, 5)
_ROUNDING = 1e-15
_TURNS = 20
_SETTLED = 1e-12  # links
_CLOSEST = 1.5  # links between two lines that are moved
_FAR = 36.0  # decay lengths across which lines do not feel each other


class Line(NamedTuple):
    """One end of a contact: x, what its offset from the last node adds to P and U, pinning."""

    x: float
    force: float
    energy: float
    pinned: bool


class Facing(NamedTuple):
    """The line across a free span: its last contact node, and its x as far as it is known."""

    node: int
    x: float


def raw(lattice: Lattice, indenter: Indenter, node: int) -> Line:
    """A line left on its node."""
    pinned = bool((np.abs(_corners(lattice, indenter, node, 1)) == 0).any())
    return Line(float(lattice.x(node)), 0.0, 0.0, pinned)


def outer(
    lattice: Lattice, indenter: Indenter, depth: float, where: Region, contact: Contact
) -> tuple[Line, Line]:
    """Both lines of a single contact."""
    first, last, reach = contact
    right = recover(lattice, indenter, depth, where, last, 1, reach)
    axis = mirror_axis(lattice, indenter, first, last)
    if axis is not None:
        return right._replace(x=max(2 * axis - right.x, indenter.extent[0])), right
    return recover(lattice, indenter, depth, where, first, -1, reach), right


def between(
    lattice: Lattice, indenter: Indenter, depth: float, ends: tuple[int, int, int, int]
) -> tuple[Line, Line]:
    """Both lines of a gap: right one of contact nodes a..b, left one of contact nodes c..d.

    A lone contact node keeps its lines.
    """
    a, b, c, d = ends
    left, right = raw(lattice, indenter, b), raw(lattice, indenter, c)
    for _ in range(_TURNS):
        before = left.x, right.x
        if b > a:
            where, facing = Region(a, c - 1, b), Facing(c, right.x)
            left = recover(lattice, indenter, depth, where, b, 1, lattice.critical_gap, facing)
        if d > c:
            where, facing = Region(b + 1, d, c), Facing(b, left.x)
            right = recover(lattice, indenter, depth, where, c, -1, lattice.critical_gap, facing)
        moved = max(abs(left.x - before[0]), abs(right.x - before[1]))
        far = c - b > _FAR / lattice.log_decay
        if far or moved <= _SETTLED * lattice.spacing + _ROUNDING * abs(left.x):
            break
    if left.x >= right.x:
        return raw(lattice, indenter, b), raw(lattice, indenter, c)
    return left, right


def recover(
    lattice: Lattice,
    indenter: Indenter,
    depth: float,
    where: Region,
    node: int,
    side: int,
    reach: float,
    facing: Facing | None = None,
) -> Line:
    """Contact line beyond `node` on `side` (+1 right, -1 left); a link holds while gap <= reach."""
    nodes = node + side * _STENCIL
    known = _STENCIL[(nodes >= where.first) & (nodes <= where.last)]
    nodes = node + side * known
    f = heights(lattice, indenter, nodes.astype(float))
    links = known[:-1]
    corners = _corners(lattice, indenter, node, side)
    gap, steps = _moves(lattice, indenter, depth, nodes, f, facing)
    zeta, used, pinned = _locate(lattice, links, gap - reach, corners)
    # energies and forces of the contact sets that end at the known nodes, relative to this one
    values = np.concatenate([np.zeros((2, 1)), np.cumsum(steps, axis=1)], axis=1)
    values -= values[:, [int(np.flatnonzero(known == 0)[0])]]
    ends = np.isin(known, np.union1d(used, used + 1) if used.size else [0])
    at = known[ends].tolist()
    force, energy = (_polynomial(at, v[ends].tolist(), zeta - lattice.edge) for v in values)
    x = float(lattice.x(node + side * zeta))
    if pinned:  # the corner itself, not its position rounded on the lattice
        corners_x = np.asarray(indenter.corners, float)
        x = float(corners_x[np.argmin(np.abs(corners_x - x))])
    return Line(min(max(x, indenter.extent[0]), indenter.extent[1]), force, energy, pinned)


def _moves(
    lattice: Lattice,
    indenter: Indenter,
    depth: float,
    nodes: Nodes,
    f: Array,
    facing: Facing | None,
) -> tuple[Array, Array]:
    """Gap of each link outwards over the nodes, heights f; force and energy of its closing (2,)."""
    if facing is None:
        move = f[:-1], f[1:], depth
        steps = lattice.advance_force(*move), lattice.advance_energy(*move)
        return lattice.gap(*move), np.stack(steps)
    x, there = lattice.x(nodes[:-1]), float(lattice.x(facing.node))
    found = []
    for end in (facing.x, (facing.x + there) / 2):
        links = np.maximum(np.abs(end - x) / lattice.spacing, _CLOSEST)
        u = depth - float(indenter.height(end))
        found.append(span.advance(lattice, depth - f, links, u))
    return found[0][0], np.stack(found[1][:0:-1])


def _corners(lattice: Lattice, indenter: Indenter, node: int, side: int) -> Array:
    """Corners within the stencil as positions ζ, those on a node exactly there."""
    corners = np.asarray(indenter.corners, float)
    middle, span = lattice.x(node), 5 * lattice.spacing
    lo, hi = np.searchsorted(corners, [middle - span, middle + span])
    zeta = np.sort(side * (corners[lo:hi] - middle) / lattice.spacing)
    return np.where(np.abs(zeta - np.round(zeta)) < 1e-9, np.round(zeta), zeta)


def _locate(
    lattice: Lattice, links: Nodes, excess: Array, corners: Array
) -> tuple[float, Nodes, bool]:
    """ζ of the line, the links whose polynomial found it, and whether a corner pins it.

    excess: (n,) gap - reach of each link; link j spans ζ = j..j+1.
    """
    near = corners[(corners > -1) & (corners < 1)]
    if near.size > 1:  # corners as dense as the nodes: secant through the two links
        used = links[(links == -1) | (links == 0)]
        return _root(lattice, used, excess[np.isin(links, used)]), used, False
    below = corners[corners <= -1].max(initial=-np.inf)
    above = corners[corners >= 1].min(initial=np.inf)
    clear = (links >= below) & (links + 1 <= above)
    if not near.size:
        chosen = clear & (links >= -2) & (links <= 1)
        return _root(lattice, links[chosen], excess[chosen]), links[chosen], False
    corner = float(near[0])
    inside = np.flatnonzero(clear & (links + 1 <= corner))[-3:]
    outside = np.flatnonzero(clear & (links >= corner))[:3]
    for face, sign in ((inside, 1), (outside, -1)):
        middles, values = (links[face] + 0.5).tolist(), excess[face].tolist()
        if values and sign * _polynomial(middles, values, corner) > 0:
            return _root(lattice, links[face], excess[face]), links[face], False
    return corner, links[inside], True


def _root(lattice: Lattice, links: Nodes, excess: Array) -> float:
    """Zero of the polynomial through the excess at the links' middles: secant steps to rounding."""
    middles = [j + 0.5 for j in links.tolist()]
    if len(middles) < 2:
        return middles[0] + lattice.edge
    values = excess.tolist()
    after = next((i for i, y in enumerate(values) if y > 0), len(values) - 1) or 1
    (x0, x1), (y0, y1) = middles[after - 1 : after + 1], values[after - 1 : after + 1]
    for _ in range(8):
        if y1 == y0:
            break
        x0, x1, y0 = x1, min(max(x1 - y1 * (x1 - x0) / (y1 - y0), -1.0), 1.0), y1
        y1 = _polynomial(middles, values, x1)
        if abs(x1 - x0) <= _ROUNDING:
            break
    return x1 + lattice.edge


def _polynomial(x: Sequence[float], y: Sequence[float], at: float) -> float:
    """Value at `at` of the polynomial through the points (Lagrange)."""
    total = 0.0
    for i, (xi, yi) in enumerate(zip(x, y, strict=True)):
        for j, xj in enumerate(x):
            if j != i:
                yi *= (at - xj) / (xi - xj)
        total += yi
    return total
