"""The contact line between the nodes: from the energies of neighbouring contact sets.

A contact that ends at node m has the energy E(m). Between nodes the line is where the interpolated
ΔE changes sign, or at a corner of the profile if ΔE changes sign there by a jump (pinned line).
Force and energy are interpolated at that position through the values of the same contact sets: a
step changes them by `Lattice.advance_energy`, ΔE, and `advance_force`, ΔP = dΔE/dd.

Raw lattice values are off by up to Δx/2 in the line; these are off by O(Δx²).
Positions ζ below are in links outwards from the last contact node, ζ = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.fronts import Region, heights
from discretization.lattice import Lattice
from energy import Indenter

Array = NDArray[np.float64]
Nodes = NDArray[np.int_]
_STENCIL = np.arange(-3, 5)
_ROUNDING = 1e-15


class Line(NamedTuple):
    """One end of a contact: x, what its offset from the last node adds to P and U, pinning."""

    x: float
    force: float
    energy: float
    pinned: bool


def recover(
    lattice: Lattice,
    indenter: Indenter,
    depth: float,
    where: Region,
    node: int,
    side: int,
    reach: float,
) -> Line:
    """Contact line beyond `node` on `side` (+1 right, -1 left); a link holds while gap <= reach."""
    nodes = node + side * _STENCIL
    known = _STENCIL[(nodes >= where.first) & (nodes <= where.last)]
    f = heights(lattice, indenter, (node + side * known).astype(float))
    gap = lattice.gap(f[:-1], f[1:], depth)
    links = known[:-1]
    corners = _corners(lattice, indenter, node, side)
    zeta, used, pinned = _locate(lattice, links, gap - reach, corners)
    # energies and forces of the contact sets that end at the known nodes, relative to this one
    move = f[:-1], f[1:], depth
    steps = np.stack([lattice.advance_force(*move), lattice.advance_energy(*move)])
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
