"""The contact line between the nodes: from the energies of neighbouring contact sets.

A contact that ends at node m has the energy E(m). Between nodes the line is where the interpolated
ΔE changes sign, or at a corner of the profile if ΔE changes sign there by a jump (pinned line).
Force and energy are interpolated at that position through the values of the same contact sets: a
step changes them by ΔE = S v²/2 - w and ΔP = dΔE/dd, v the gap of `Lattice.beside`.

Raw lattice values are off by up to Δx/2 in the line; these are off by O(Δx²).
Positions ζ below are in links outwards from the last contact node, ζ = 0.

A line that faces another contact is found likewise, with the free span in place of the tail. Two
such lines are found in turns; of the energy of both moves together, each adds its own with the
other one half way, which is exact for a quadratic energy.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Contacts, Row

Array = NDArray[np.float64]
Room = tuple[int, int]  # first and last node there are for a line
_INWARDS, _OUTWARDS = 3, 4  # nodes beside the last one of a contact
_ROUNDING = 1e-15  # of positions, in links
_TURNS = 20  # in which lines that face each other are found; each is a contraction
_SETTLED = 1e-12  # links
_CLOSEST = 1.5  # links between two lines that are moved


class Line(NamedTuple):
    """One end of a contact: x, what its offset from the last node adds to P and U, pinning."""

    x: float
    force: float
    energy: float
    pinned: bool


class End(NamedTuple):
    """One end of a contact: the nodes beside it, and what its line's advance over a link changes.

    Nodes are counted outwards from the last one of the contact, node 0, which is `node` of the
    row; link j leads from node j to j + 1. gap, energy, force: of the advance over links from
    `start` <= 0 on.
    """

    node: int
    side: int
    start: int
    gap: list[float]
    energy: list[float]
    force: list[float]


class Facing(NamedTuple):
    """The line across a free span: its last contact node, and its x as far as it is known."""

    node: int
    x: float


def lines_of(row: Row, depth: float, nodes: Contacts) -> list[Line]:
    """All lines of several contacts from left to right; those of a lone node stay there."""
    ends = [node for pair in nodes for node in pair]
    found, reach = [_raw(row, node) for node in ends], row.lattice.critical_gap
    for _ in range(_TURNS):
        before = [each.x for each in found]
        for i, node in enumerate(ends):
            side, own = (1, ends[i - 1]) if i % 2 else (-1, ends[i + 1])
            faced, rim = None, row.size - 1 if side > 0 else 0
            if 0 < i < len(ends) - 1:
                faced = Facing(ends[i + side], found[i + side].x)
                rim = faced.node - side
            if node != own:
                end = end_of(row, depth, node, side, (min(own, rim), max(own, rim)), faced)
                found[i] = _line(row, end, reach)
        moved = max(abs(each.x - x) for each, x in zip(found, before, strict=True))
        if moved <= _SETTLED * row.lattice.spacing + _ROUNDING * max(map(abs, before)):
            break
    for i in range(1, len(ends) - 1, 2):
        if found[i].x >= found[i + 1].x:
            found[i : i + 2] = [_raw(row, node) for node in ends[i : i + 2]]
    return found


def outer(row: Row, reach: float, ends: list[End]) -> list[Line]:
    """Left and right line of a single contact with these ends, the right one first.

    The right one alone if the contact includes the axis.
    """
    lattice, right = row.lattice, _line(row, ends[0], reach)
    if len(ends) > 1:
        return [_line(row, ends[1], reach), right]
    return [Line(lattice.axis, 0.0, 0.0, False), right]


def _raw(row: Row, node: int) -> Line:
    """A line left on its node."""
    return Line(row.lattice.x(row.first + node), 0.0, 0.0, 0.0 in _corners(row, node, 1))


def end_of(
    row: Row,
    depth: float,
    node: int,
    side: int,
    room: Room | None = None,
    facing: Facing | None = None,
) -> End:
    """The end of a contact at a node; room: all nodes, if nothing is faced."""
    low, high = (0, row.size - 1) if room is None else room
    before, beyond = (node - low, high - node)[::side]
    start, stop = -min(before, _INWARDS), min(beyond, _OUTWARDS)
    nodes = node + side * np.arange(start, stop + 1)
    gap, *steps = _advances(row, depth, nodes, side, None if facing is None else facing.x)
    if facing is not None:  # both lines are moved: of what that takes each adds one half
        half_way = (facing.x + row.lattice.x(row.first + facing.node)) / 2
        _, *steps = _advances(row, depth, nodes, side, half_way)
    return End(node, side, start, *(part.tolist() for part in (gap, *steps)))


def _advances(
    row: Row, depth: float, nodes: NDArray[np.int64], side: int, faced: float | None
) -> tuple[Array, Array, Array]:
    """Gap, ΔE and ΔP of the advance of a line over the links between these nodes (n,).

    faced: x of a line it faces. Gaps are scaled so that all have the same reach.
    """
    lattice, at = row.lattice, row.first + nodes
    g, at = depth - row.f[nodes], at[:-1]
    if faced is None:
        (_, rest, stiffness), felt = lattice.beside(at, side), 0.0
    else:
        links = np.maximum(np.abs(faced - lattice.x(at)) / lattice.spacing, _CLOSEST)
        far, rest, stiffness = lattice.beside(0, 1, links)
        felt = far * (depth - float(row.indenter.height(faced)) - g[:-1])
    weight = lattice.weight(at + side / 2)
    gap = g[:-1] - g[1:] - rest * g[:-1] + felt
    energy = stiffness / 2 * gap * gap - lattice.w * lattice.cell * weight
    scale = np.sqrt(stiffness / (lattice.link_over_decay * weight))
    return gap * scale, energy, -stiffness * rest * gap


def _line(row: Row, end: End, reach: float) -> Line:
    """The line at this end; a link holds while gap <= reach."""
    lattice, indenter = row.lattice, row.indenter
    corners = _corners(row, end.node, end.side)
    excess = {link: gap - reach for link, gap in enumerate(end.gap, end.start)}
    zeta, links, pinned = _locate(lattice, excess, corners)
    x = lattice.x(row.first + end.node + end.side * zeta)
    if pinned:  # the corner itself, not its position rounded on the lattice
        corners_x = np.asarray(indenter.corners, float)
        x = float(corners_x[np.argmin(np.abs(corners_x - x))])
    x, at = min(max(x, indenter.extent[0]), indenter.extent[1]), zeta - lattice.edge
    force, energy = (_added(end.start, steps, links, at) for steps in (end.force, end.energy))
    return Line(x, force, energy, pinned)


def _added(start: int, steps: list[float], links: list[int], zeta: float) -> float:
    """What a contact set that ends at ζ has more than the one that ends at node 0.

    steps: changes over link `start` and those after it; links: those to interpolate over.
    """
    if not links:
        return 0.0
    totals = list(itertools.accumulate(steps, initial=0.0))
    own = [total - totals[-start] for total in totals[links[0] - start : links[-1] - start + 2]]
    return _value(_differences(own), zeta - links[0])


def _corners(row: Row, node: int, side: int) -> list[float]:
    """Corners within the stencil as positions ζ outwards, those on a node exactly there."""
    lattice, indenter = row.lattice, row.indenter
    if not len(indenter.corners):
        return []
    corners = np.asarray(indenter.corners, float)
    middle, near = lattice.x(row.first + node), 5 * lattice.spacing
    lo, hi = np.searchsorted(corners, [middle - near, middle + near])
    zeta = sorted((side * (corners[lo:hi] - middle) / lattice.spacing).tolist())
    return [float(round(z)) if abs(z - round(z)) < 1e-9 else z for z in zeta]


def _locate(
    lattice: Lattice, excess: dict[int, float], corners: list[float]
) -> tuple[float, list[int], bool]:
    """ζ of the line, the links whose polynomial found it, and whether a corner pins it.

    excess: gap - reach by link; link j spans ζ = j..j+1.
    """
    near = [corner for corner in corners if -1 < corner < 1]
    if len(near) > 1:  # corners as dense as the nodes: secant through the two links
        links = _within(excess, -1, 1)
        return _root(lattice, links, excess), links, False
    clear = _clear(excess, corners) if corners else excess
    if not near:
        links = _within(clear, -2, 2)
        return _root(lattice, links, excess), links, False
    corner, below, above = near[0], math.floor(near[0]), math.ceil(near[0])
    inside, outside = _within(clear, below - 3, below), _within(clear, above, above + 3)
    for links, sign in ((inside, 1), (outside, -1)):
        curve = _differences([excess[link] for link in links])
        if links and sign * _value(curve, corner - links[0] - 0.5) > 0:
            return _root(lattice, links, excess), links, False
    return corner, inside, True


def _clear(links: Iterable[int], corners: list[float]) -> list[int]:
    """The links about node 0 up to the first corners that are a link or more away from it."""
    below = max((math.ceil(corner) for corner in corners if corner <= -1), default=-math.inf)
    above = min((math.floor(corner) for corner in corners if corner >= 1), default=math.inf)
    return _within(links, below, above)


def _within(links: Iterable[int], first: float, stop: float) -> list[int]:
    """Those of the links that are first..stop-1."""
    return [link for link in links if first <= link < stop]


def _root(lattice: Lattice, links: list[int], excess: dict[int, float]) -> float:
    """Zero of the polynomial through the excess at the links' middles: secant steps to rounding."""
    if not links:
        raise ValueError(
            f"spacing = {lattice.spacing!r} leaves no link between two corners; use a smaller one"
        )
    middle, values = links[0] + 0.5, [excess[link] for link in links]
    curve = _differences(values)
    if len(links) < 2:
        return middle + lattice.edge
    after = next((i for i, y in enumerate(values) if y > 0), len(values) - 1) or 1
    x0, x1, y0, y1 = middle + after - 1, middle + after, values[after - 1], values[after]
    for _ in range(8):
        if y1 == y0 or abs(x1 - x0) <= _ROUNDING:
            break
        x = x1 - y1 * (x1 - x0) / (y1 - y0)
        x0, x1, y0 = x1, x if abs(x) <= 1 else math.copysign(1.0, x), y1
        y1 = _value(curve, x1 - middle)
    return x1 + lattice.edge


def _differences(values: list[float]) -> list[float]:
    """Δᵏy/k! of equidistant values y at the first of them: their polynomial in Newton's form."""
    found = values.copy()
    for order in range(1, len(found)):
        for i in range(len(found) - 1, order - 1, -1):
            found[i] = (found[i] - found[i - 1]) / order
    return found


def _value(differences: list[float], at: float) -> float:
    """The polynomial, `at` steps after the first of its points."""
    total, steps = 0.0, len(differences)
    for divided in reversed(differences):
        steps -= 1
        total = total * (at - steps) + divided
    return total
