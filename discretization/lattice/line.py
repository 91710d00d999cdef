"""Contact lines between the nodes, and what that adds to U and P: of states, and on paths.

A contact that ends at node m has the energy E(m). Let ζ count links outwards from there. A line
that passes link j, from ζ = j to j + 1, stores S v²/2 in the surface and gains the adhesion W
(`Lattice`), so that it does where e_j < 0,

    e = v/|v| √(S v²/2) - √W,    over the root of the link's length or area.

Between the nodes a line is where e, taken at the middles of the links, is zero: by the cubic
through the links -2..1, or by the straight line through -1 and 0 where the profile or the pattern
has a corner within two links. One that is less than a link away holds the line if e changes sign
there by a jump; what is inside and what is outside then continue straight. U and P are interpolated
between the same contact sets, beside a corner those on one side of it. Raw lattice values are off
by up to Δx/2 in the line; these are off by O(Δx²).

Where opening takes another work of adhesion than closing there are two such positions, and a line
between them stays where it last moved (a play operator):

    ζ = min(max(ζ before, ζ of closing at d), ζ of opening at d).

So a state has to remember the positions of its lines, too, not their nodes alone. Lines that face
each other are found in turns. Of the energy of both moves together each adds its own with the other
one half way, which is exact for a quadratic energy.
"""

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from discretization.certificate import EPSILON
from discretization.nodes.row import Contacts, Row
from energy.arrays import Array, Mask, Nodes

Lines = tuple[float, ...]  # x of all lines
LINKS = np.arange(-3, 3)  # beside a line, outwards from its node
_HALF = 0.5 - 1e-9  # links: a line keeps the node it belongs to
_NEARLY, _SHORT = 0.4999, 1e-4  # links: what is beyond is told that much shorter
_TURNS = 20  # in which lines that face each other are found; each is a contraction
_SETTLED = 1e-9  # links
_CLOSEST = 1.5  # links between two lines that are moved
_ROUNDING = 16 * EPSILON  # of x: by less no line has moved
_APART = 4  # links between two lines that are not left on their nodes


class Advances(NamedTuple):
    """What passing each of the links beside lines changes; arrays of one shape, the links last.

    gap: v; stored: S v²/2; force: ΔP; bonds: the links' lengths or areas times the pattern's
    factor; size: without it. The first three are nan where there is no link to pass.
    """

    gap: Array
    stored: Array
    force: Array
    bonds: Array
    size: Array

    def excess(self, work: float) -> Array:
        """e, with this work of adhesion."""
        taken = np.copysign(np.sqrt(self.stored / self.size), self.gap)
        return np.asarray(taken - np.sqrt(work * self.bonds / self.size))


class Corner(NamedTuple):
    """The only corner within a link of each line, as ζ; nan: none, or several.

    before, beyond: whether the two links next to it on each side are without another one; smooth:
    whether all four links about the node are without any.
    """

    zeta: Array
    before: Mask
    beyond: Mask
    smooth: Mask


@functools.lru_cache
def outwards(lines: int) -> Nodes:
    """Which way so many lines face."""
    return np.resize([-1, 1], lines)


def advances(row: Row, nodes: Nodes, depth: Array, zeta: Array | None = None) -> Advances:
    """Of contacts between nodes (s, 2m) at depths (s,), of the links beside them (s, 2m, 6).

    zeta: where the lines are that inner lines face, if not on their nodes.
    """
    lattice, sides = row.lattice, outwards(nodes.shape[1])
    start = nodes[..., None] + sides[:, None] * LINKS
    spans, end = np.diff(nodes, prepend=-1, append=row.size), row.size - 1
    inside, outside = (np.repeat(spans[:, i::2], 2, axis=1)[..., None] for i in (1, 0))
    there = (-inside <= LINKS) & (outside[:, 1:-1] > LINKS + 1)
    start, after = (np.clip(at, 0, end) for at in (start, start + sides[:, None]))
    own, beyond = (depth[:, None, None] - row.f[at] for at in (start, after))
    rest, stiffness, felt = np.zeros((3, *start.shape))
    for column, side in ((0, -1), (-1, 1)):
        _, rest[:, column], stiffness[:, column] = lattice.beside(
            row.first + start[:, column], side
        )
    if nodes.shape[1] > 2:
        at, f = nodes * 1.0, row.f[nodes]
        if zeta is not None:
            at = nodes + sides * zeta
            f = row.scene.indenter.height(lattice.x(row.first + at))
        inner, swapped = np.s_[:, 1:-1], np.arange(1, nodes.shape[1] - 1) + sides[1:-1]
        at, faced = at[:, swapped], depth[:, None] - f[:, swapped]
        apart = np.maximum(np.abs(at[..., None] - start[inner]), _CLOSEST)
        far, rest[inner], stiffness[inner] = lattice.beside(0, 1, apart)
        felt[inner] = far * (faced[..., None] - own[inner])
    gap = np.where(there, own - beyond - rest * own + felt, math.nan)
    links = np.minimum(np.minimum(start, after), end - 1)
    size = lattice.cell * lattice.weight(row.first + links + 0.5) * np.ones(links.shape)
    return Advances(gap, stiffness / 2 * gap * gap, -stiffness * rest * gap, row.bonds[links], size)


def corners(row: Row, nodes: Nodes) -> Corner:
    """The corners beside lines at these nodes (s, 2m)."""
    sides = outwards(nodes.shape[1])
    known = np.concatenate([[-math.inf], row.breaks, [math.inf]])
    i = np.searchsorted(known, nodes - 1, "right")
    last, at, following = (known[np.minimum(i + n, known.size - 1)] for n in (-1, 0, 1))
    only = (at < nodes + 1) & (following >= nodes + 1)
    zeta = np.where(only, sides * (at - nodes) - row.lattice.edge, math.nan)
    clear = at >= last + 2, following >= at + 2
    before, beyond = (np.where(sides > 0, *pair) for pair in (clear, clear[::-1]))
    return Corner(zeta, before, beyond, (last <= nodes - 2) & (at >= nodes + 2))


def _beside(parts: Array) -> tuple[Array, Array, Array, Array]:
    """Those of the links -2..1, of an outer one that is not there as a parabola continues."""
    first, before, beyond, last = np.moveaxis(parts[..., 1:5], -1, 0)
    first = np.where(np.isnan(first), last - 3 * (beyond - before), first)
    last = np.where(np.isnan(last), first + 3 * (beyond - before), last)
    return first, before, beyond, last


def placed(excess: Array, corner: Corner) -> Array:
    """ζ of lines with this excess at their links (..., 6); nan where e does not grow outwards."""
    first, inner, outer, last = _beside(excess)
    with np.errstate(invalid="ignore", divide="ignore"):
        rise = np.where(outer > inner, outer - inner, math.nan)
        t = np.minimum(np.maximum(-inner / rise, -0.5), 1.5)
        bend = (first - inner - outer + last) / (4 * rise)
        turn = (last - 3 * outer + 3 * inner - first) / (6 * rise)
        smooth = corner.smooth & (np.abs(bend) <= 1) & (np.abs(turn) <= 1)
        bend, turn = np.where(smooth, bend, 0.0), np.where(smooth, turn, 0.0)
        t = 2 * t / (1 - bend + np.sqrt((1 - bend) ** 2 + 4 * bend * t))
        zeta, at, zeros = t - 0.5 + turn * t * (1 - t) * (t - 0.5), corner.zeta, []
        if np.isnan(at).all():
            return np.asarray(zeta)
        for side, clear in enumerate((corner.before, corner.beyond)):
            middle = _middle(at, np.full(at.shape, side > 0))
            pair = _pair(excess, middle)
            rise = np.where(clear & (pair[1] > pair[0]), pair[1] - pair[0], 0.0)
            zeros.append(middle - np.where(rise, sum(pair) / 2, pair[1 - side]) / rise)
        held = np.where(zeros[0] < at, zeros[0], np.fmax(zeros[1], at))
    return np.where(np.isnan(at), zeta, np.maximum(held, -0.5))


def _middle(at: Array, outside: Mask) -> Nodes:
    """The node between the two nearest links on one side of corners at ζ; 0 where there is none."""
    middle = np.where(outside, np.ceil(at) + 1, np.floor(at) - 1)
    return np.nan_to_num(middle).astype(int)


def _pair(parts: Array, middle: Nodes) -> tuple[Array, Array]:
    """Those of the links before and beyond a node."""
    links = np.stack([middle - 1, middle], axis=-1) - LINKS[0]
    before, beyond = np.moveaxis(np.take_along_axis(parts, links, -1), -1, 0)
    return before, beyond


def _added(steps: Array, zeta: Array, corner: Corner) -> Array:
    """What contacts that end at ζ have more than those at their nodes; steps: over links."""
    middle = _middle(corner.zeta, zeta > corner.zeta)
    before, beyond = _pair(steps, middle)
    before = np.where(np.isnan(before), beyond, before)
    beyond = np.where(np.isnan(beyond), before, beyond)
    whole = np.nan_to_num(steps).cumsum(axis=-1)
    start, t = _pair(whole, middle)[0] - whole[..., -LINKS[0] - 1], zeta - middle
    found = start + t * (before + beyond) / 2 + t * t * (beyond - before) / 2
    first, before, beyond, last = _beside(steps)
    odd = (first - before - beyond + last) / 12
    even = (last - 3 * beyond + 3 * before - first) / 24
    further = t * (t * t - 1) * (odd + t * even)
    return np.nan_to_num(found + np.where(corner.smooth & np.isfinite(further), further, 0.0))


def offsets(row: Row, nodes: Nodes, depth: Array, before: Array | None = None) -> Array:
    """ζ of all lines (s, 2m) of s states with m contacts each, between these nodes (s, 2m).

    before: how far they were, where a line resists both ways.
    """
    zeta, beside = np.zeros(nodes.shape), corners(row, nodes)
    works = row.works if before is not None else row.works[:1]
    for _ in range(_TURNS if nodes.shape[1] > 2 else 1):
        found, last = advances(row, nodes, depth, zeta), zeta
        zeta = resting(row, nodes, [found.excess(work) for work in works], beside, before)
        if np.abs(zeta - last).max() <= _SETTLED:
            break
    return zeta


def resting(
    row: Row, nodes: Nodes, excess: list[Array], corner: Corner, before: Array | None = None
) -> Array:
    """ζ with the excess of closing, and of opening where it differs, from where lines were."""
    zeta = np.full(nodes.shape, -1.0) if before is None else before
    most = np.where((nodes == 0) | (nodes == row.size - 1), 1.0, _HALF)
    least = np.full(nodes.shape, -_HALF)
    most[:, 1:-1], least[:, 1:-1] = 1.0, -1.0
    for each, further in zip(excess, (np.maximum, np.minimum), strict=False):
        rests = np.maximum(np.minimum(placed(each, corner), most), least)
        zeta = further(zeta, rests)
    close = np.repeat(nodes[:, 2::2] - nodes[:, 1:-1:2] < _APART, 2, axis=1)
    zeta[:, 1:-1][close] = 0.0
    return np.where(np.isnan(zeta), 0.0, zeta)


def between(
    row: Row, nodes: Nodes, depth: Array, known: Array | None = None
) -> tuple[Advances, Array, Array]:
    """ζ of lines, their x (s, 2m), and what passing links changes, with faced lines at ζ/2.

    known: x of lines that resist both ways, where it has to be known.
    """
    zeta = offsets(row, nodes, depth) if known is None else offsets_of(row, nodes, known)
    lines = positions(row, nodes, zeta) if known is None else known
    return advances(row, nodes, depth, zeta / 2), zeta, lines


def positions(row: Row, nodes: Nodes, zeta: Array) -> Array:
    """x of lines that far from their nodes; of those at a corner that of the corner.

    As lines that face each other feel each other, one may be more than half a link from its node;
    where it has to tell the node, as a line that stays where it was, it is told within half a link.
    """
    lattice, sides, told = row.lattice, outwards(nodes.shape[1]), zeta.copy()
    if row.scene.hysteretic:
        told[:, 1:-1] = _stretched(told[:, 1:-1], _SHORT)
    x = lattice.x(row.first + nodes + sides * (told + lattice.edge))
    held = np.argwhere(zeta == corners(row, nodes).zeta)
    for at in map(tuple, held.tolist()):
        x[at] = row.corners[np.abs(row.corners - x[at]).argmin()]
    return np.clip(x, *row.scene.indenter.extent)


def offsets_of(row: Row, nodes: Nodes, lines: Array) -> Array:
    """How far the lines at these positions are from their nodes, in links outwards."""
    off = (lines - row.lattice.x(row.first + nodes)) / row.lattice.spacing
    zeta = outwards(nodes.shape[1]) * off
    zeta[:, 1:-1] = _stretched(zeta[:, 1:-1], 1 / _SHORT)
    return np.asarray(zeta)


def _stretched(zeta: Array, factor: float) -> Array:
    """What is beyond _NEARLY half a link, times a factor."""
    beyond = np.maximum(np.abs(zeta) - _NEARLY, 0.0)
    return np.asarray(zeta + (factor - 1) * np.copysign(beyond, zeta))


def gained(row: Row, nodes: Nodes, found: Advances, zeta: Array) -> Array:
    """U and P (2, s) that states have more with lines ζ further; found: with faced ones at ζ/2."""
    corner, energy = corners(row, nodes), found.stored - row.works[0] * found.bonds
    return np.array([_added(part, zeta, corner).sum(axis=1) for part in (energy, found.force)])


def moved(
    row: Row, contacts: Sequence[Contacts], depths: Array, before: Contacts, lines: Lines
) -> list[Lines]:
    """Where lines of contacts, equally many, are at depths (s,), when they were here `before`.

    A line that is less than a link from where one was comes from there, and keeps its x to the last
    bit if it has not moved; others come from the side on which their contacts were.
    """
    nodes, was = np.reshape(contacts, (len(contacts), -1)), np.array(before, int).reshape(1, -1)
    sides, x = outwards(nodes.shape[1]), np.array(lines)
    at = was + outwards(was.size) * offsets_of(row, was, x)
    at, x = (np.pad(part.ravel(), 1, constant_values=(-math.inf, math.inf)) for part in (at, x))
    facing = np.where(sides > 0, np.searchsorted(at, nodes, "right"), np.searchsorted(at, nodes))
    facing -= facing % 2 == (sides > 0)  # the next line, or that before: which faces the same way
    came = np.clip(sides * (at[facing] - nodes), -1.0, 1.0)
    found = positions(row, nodes, offsets(row, nodes, depths, came))
    near = np.abs(x[facing] - found) <= _ROUNDING * float(np.abs(found).max())
    return [*map(tuple, np.where(near, x[facing], found).tolist())]
