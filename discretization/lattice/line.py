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

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import span
from discretization.lattice.fronts import Contact, Region, heights, mirror_axis
from discretization.lattice.nodes import Lattice
from energy import Indenter

Array = NDArray[np.float64]
_INWARDS, _OUTWARDS = 3, 4  # nodes beside the last one of a contact
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
    return Line(lattice.x(node), 0.0, 0.0, 0.0 in _corners(lattice, indenter, node, 1))


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
    before, beyond = (node - where.first, where.last - node)[::side]
    known = range(max(-before, -_INWARDS), min(beyond, _OUTWARDS) + 1)
    nodes = np.arange(node + side * known.start, node + side * known.stop, side, dtype=float)
    f = heights(lattice, indenter, nodes)
    corners = _corners(lattice, indenter, node, side)
    gap, force, energy = _moves(lattice, indenter, depth, nodes, f, facing)
    excess = dict(zip(known, (gap - reach).tolist(), strict=False))
    zeta, used, pinned = _locate(lattice, excess, corners)
    ends = sorted({j + end for j in used for end in (0, 1)}) or [0]
    added = (_added(known, step.tolist(), ends, zeta - lattice.edge) for step in (force, energy))
    x = lattice.x(node + side * zeta)
    if pinned:  # the corner itself, not its position rounded on the lattice
        corners_x = np.asarray(indenter.corners, float)
        x = float(corners_x[np.argmin(np.abs(corners_x - x))])
    x = min(max(x, indenter.extent[0]), indenter.extent[1])
    return Line(x, next(added), next(added), pinned)


def _added(known: range, steps: list[float], ends: list[int], zeta: float) -> float:
    """What a contact set that ends at ζ has more than the one that ends at node 0.

    steps: changes from each known node to the next; ends: the nodes to interpolate between.
    """
    totals = dict(zip(known, itertools.accumulate(steps, initial=0.0), strict=True))
    return _value(_polynomial(ends, [totals[j] - totals[0] for j in ends]), zeta)


def _moves(
    lattice: Lattice,
    indenter: Indenter,
    depth: float,
    nodes: Array,
    f: Array,
    facing: Facing | None,
) -> tuple[Array, Array, Array]:
    """Gap of each link outwards over the nodes, heights f; force and energy of its closing."""
    if facing is None:
        f, f_next = f[:-1], f[1:]
        gap = lattice.gap(f, f_next, depth)
        energy = lattice.arc(f_next - f) * lattice.advance_cost(gap)
        return gap, lattice.advance_force(f, f_next, depth), energy
    x, there = lattice.x(nodes[:-1]), lattice.x(facing.node)
    found = []
    for end in (facing.x, (facing.x + there) / 2):
        links = np.maximum(np.abs(end - x) / lattice.spacing, _CLOSEST)
        u = depth - float(indenter.height(end))
        found.append(span.advance(lattice, depth - f, links, u))
    (gap, _, _), (_, energy, force) = found
    return gap, force, energy


def _corners(lattice: Lattice, indenter: Indenter, node: int, side: int) -> list[float]:
    """Corners within the stencil as positions ζ outwards, those on a node exactly there."""
    if not len(indenter.corners):
        return []
    corners = np.asarray(indenter.corners, float)
    middle, span = lattice.x(node), 5 * lattice.spacing
    lo, hi = np.searchsorted(corners, [middle - span, middle + span])
    zeta = sorted((side * (corners[lo:hi] - middle) / lattice.spacing).tolist())
    return [float(round(z)) if abs(z - round(z)) < 1e-9 else z for z in zeta]


def _locate(
    lattice: Lattice, excess: dict[int, float], corners: list[float]
) -> tuple[float, list[int], bool]:
    """ζ of the line, the links whose polynomial found it, and whether a corner pins it.

    excess: gap - reach of each link; link j spans ζ = j..j+1.
    """
    near = [corner for corner in corners if -1 < corner < 1]
    if len(near) > 1:  # corners as dense as the nodes: secant through the two links
        used = [j for j in excess if j in (-1, 0)]
        return _root(lattice, used, excess), used, False
    below = max((corner for corner in corners if corner <= -1), default=-math.inf)
    above = min((corner for corner in corners if corner >= 1), default=math.inf)
    clear = [j for j in excess if below <= j and j + 1 <= above]
    if not near:
        used = [j for j in clear if -2 <= j <= 1]
        return _root(lattice, used, excess), used, False
    corner = near[0]
    inside = [j for j in clear if j + 1 <= corner][-3:]
    outside = [j for j in clear if j >= corner][:3]
    for face, sign in ((inside, 1), (outside, -1)):
        middles, values = [j + 0.5 for j in face], [excess[j] for j in face]
        if values and sign * _value(_polynomial(middles, values), corner) > 0:
            return _root(lattice, face, excess), face, False
    return corner, inside, True


def _root(lattice: Lattice, links: list[int], excess: dict[int, float]) -> float:
    """Zero of the polynomial through the excess at the links' middles: secant steps to rounding."""
    middles = [j + 0.5 for j in links]
    if not middles:
        raise ValueError(
            f"spacing = {lattice.spacing!r} leaves no link between two corners; use a smaller one"
        )
    if len(middles) < 2:
        return middles[0] + lattice.edge
    values = [excess[j] for j in links]
    curve = _polynomial(middles, values)
    after = next((i for i, y in enumerate(values) if y > 0), len(values) - 1) or 1
    (x0, x1), (y0, y1) = middles[after - 1 : after + 1], values[after - 1 : after + 1]
    for _ in range(8):
        if y1 == y0:
            break
        x0, x1, y0 = x1, min(max(x1 - y1 * (x1 - x0) / (y1 - y0), -1.0), 1.0), y1
        y1 = _value(curve, x1)
        if abs(x1 - x0) <= _ROUNDING:
            break
    return x1 + lattice.edge


def _polynomial(x: Sequence[float], y: Sequence[float]) -> list[tuple[float, float]]:
    """The polynomial through the points in Newton's form: nodes and divided differences."""
    divided = list(y)
    for order in range(1, len(x)):
        for i in range(len(x) - 1, order - 1, -1):
            divided[i] = (divided[i] - divided[i - 1]) / (x[i] - x[i - order])
    return list(zip(x, divided, strict=True))[::-1]


def _value(polynomial: list[tuple[float, float]], at: float) -> float:
    total = 0.0
    for node, divided in polynomial:
        total = total * (at - node) + divided
    return total
