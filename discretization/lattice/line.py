"""Contact lines between the nodes, and what that adds to U and P: of states, and on paths.

A contact that ends at node m has the energy E(m). Let ζ count links outwards from there. A line
that passes link j, from ζ = j to j + 1, stores S v²/2 in the surface and gains the adhesion W
(`Lattice`), so that it does where e_j < 0,

    e = v/|v| √(S v²/2) - √W.

Between the nodes a line is where e, taken at the middles of the links, is zero: by the cubic
through the links -2..1. Where the profile or the pattern has a corner within two links, it is by
the straight line through -1 and 0. A corner that is less than a link away holds the line if e
changes sign there by a jump; what is inside and what is outside then continue straight. U and P are
interpolated between the same contact sets, beside a corner those on one side of it. Raw lattice
values are off by up to Δx/2 in the line; these are off by O(Δx²).

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
from discretization.lattice.closing import closes_smoothly
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
    factor. The first three are nan where there is no link to pass.
    """

    gap: Array
    stored: Array
    force: Array
    bonds: Array

    def excess(self, works: Sequence[float]) -> Array:
        """e, with each of these works of adhesion (n, s, 2m, 6)."""
        taken, held = np.copysign(np.sqrt(self.stored), self.gap), np.sqrt(self.bonds)
        return np.array([taken - math.sqrt(work) * held for work in works])


class Corners(NamedTuple):
    """The only corner within a link of each line, as ζ; nan: none, or several.

    smooth: whether all four links about the node are without any; narrow: whether the node, a lone
    one, stands for a contact narrower than a link.
    """

    zeta: Array
    smooth: Mask
    narrow: Mask

    def middle(self, outside: Mask | bool) -> Nodes:
        """The node between the two nearest links on one side of the corner; 0 without a corner."""
        middle = np.where(outside, np.ceil(self.zeta) + 1, np.floor(self.zeta) - 1)
        return np.where(np.isnan(middle), 0, middle).astype(int)

    def cubic(self, parts: Array, middle: Nodes) -> tuple[Array, Array, Array, Array]:
        """Parts (n, s, 2m, 6) of links over their middles, near a node, as a cubic of t from there.

            p(t) = mean + rise t + (bend + turn t)(t² - 1/4)

        through four links, or three, or two beside the node; a missing one is like the other, or
        inside a narrow contact continues those outside.
        """
        links = np.arange(-2, 2) - LINKS[0]
        if middle.any():
            own = (middle[None, ..., None] + links) % LINKS.size
            parts, links = np.take_along_axis(parts, own, -1), np.arange(4)
        first, inner, outer, last = (parts[..., i] for i in links)
        beyond = np.where(self.narrow & ~np.isnan(last), 2 * outer - last, outer)
        inner, outer = (
            np.where(np.isnan(inner), beyond, inner),
            np.where(np.isnan(outer), inner, outer),
        )
        rise, mean = outer - inner, (inner + outer) / 2
        one = np.where(np.isnan(first), last - 3 * rise, first)
        other = np.where(np.isnan(last), first + 3 * rise, last)
        bend, turn = (one + other - 2 * mean) / 4, (other - one - 3 * rise) / 6
        known = self.smooth & ~np.isnan(bend)
        return mean, rise, np.where(known, bend, 0.0), np.where(known, turn, 0.0)


@functools.lru_cache
def outwards(lines: int) -> Nodes:
    """Which way so many lines face."""
    return np.resize([-1, 1], lines)


def advances(row: Row, nodes: Nodes, depth: Array, zeta: Array | None = None) -> Advances:
    """Of contacts between nodes (s, 2m) at depths (s,), of the links beside them (s, 2m, 6).

    zeta: where the lines are that inner lines face, if not on their nodes.
    """
    lattice, sides, columns = row.lattice, outwards(nodes.shape[1]), np.arange(nodes.shape[1]) + 1
    start = nodes[..., None] + sides[:, None] * LINKS
    after = start + sides[:, None]
    ends, u = np.empty((2, len(nodes), columns.size + 2))  # of all lines, and far out
    ends[:, 0], ends[:, 1:-1], ends[:, -1] = -1, nodes, row.size
    facing, other = (ends[:, columns + way * sides, None] for way in (1, -1))
    there = (sides[:, None] * (facing - after) > 0) & (sides[:, None] * (start - other) >= 0)
    there[row.first + nodes == lattice.axis] = False
    if zeta is None:
        f = row.f[nodes]
    else:
        ends[:, 1:-1] += sides * zeta
        indenter, x = row.scene.indenter, lattice.x(row.first + ends[:, 1:-1])
        f = indenter.height(np.clip(x, *indenter.extent))
    ends[:, 0], ends[:, -1], u[:, 1:-1] = -math.inf, math.inf, depth[:, None] - f
    u[:, 0] = u[:, -1] = 0.0
    faced = columns + sides
    apart = np.maximum(np.abs(ends[:, faced, None] - start), _CLOSEST)
    far, rest, stiffness = lattice.beside(row.first + start, sides[:, None], apart)
    own, beyond = (depth[:, None, None] - row.f.take(at, mode="clip") for at in (start, after))
    gap = own - beyond - rest * own + far * (u[:, faced, None] - own)
    gap = np.where(there, gap, math.nan)
    bonds = row.bonds[np.minimum(np.maximum(np.minimum(start, after), 0), row.size - 2)]
    return Advances(gap, stiffness / 2 * gap * gap, -stiffness * rest * gap, bonds)


def corners(row: Row, nodes: Nodes) -> Corners:
    """The corners beside lines at these nodes (s, 2m)."""
    wide = np.full(nodes.shape, False)
    if not row.corners.size:
        return Corners(np.full(nodes.shape, math.nan), ~wide, wide)
    known = np.append(row.breaks, math.nan)
    first, beyond = known.searchsorted(nodes - 1, "right"), known.searchsorted(nodes + 1)
    at = outwards(nodes.shape[1]) * (known[first] - nodes) - row.lattice.edge
    near = known.searchsorted(nodes + 2) - known.searchsorted(nodes - 2, "right")
    return Corners(np.where(beyond - first == 1, at, math.nan), near == 0, wide)


def placed(excess: Array, corner: Corners) -> Array:
    """ζ of lines with this excess (n, s, 2m, 6) at their links; nan where it grows nowhere."""
    inside, at = _zero(excess, corner, outside=False), corner.zeta
    if np.isnan(at).all():
        return inside
    held = np.where(inside < at, inside, np.fmax(_zero(excess, corner, outside=True), at))
    return np.where(np.isnan(at), inside, held)


def _zero(excess: Array, corner: Corners, *, outside: bool) -> Array:
    """Where e is zero as it continues from one side of a corner.

    Where it does not grow outwards there, it has its sign everywhere; without a corner nan.
    """
    middle = corner.middle(outside)
    mean, rise, bend, turn = corner.cubic(excess, middle)
    with np.errstate(invalid="ignore", divide="ignore"):
        sign = mean - rise / 2 if outside else mean + rise / 2
        far = np.where(np.isnan(corner.zeta), math.nan, -math.inf * sign)
        straight = np.where(rise > 0, -mean / rise, far)
        bend, turn, s = bend / rise, turn / rise, straight + 0.5
        s = 2 * s / (1 - bend + np.sqrt((1 - bend) ** 2 + 4 * bend * s))
        bent = s - 0.5 + turn * s * (1 - s) * (s - 0.5)
        tame = np.maximum(np.maximum(np.abs(bend), np.abs(turn)), np.abs(straight)) <= 1
    return np.asarray(middle + np.where(tame & ~np.isnan(bent), bent, straight))


def _added(steps: Array, zeta: Array, corner: Corners) -> Array:
    """What contacts that end at ζ have more than those at their nodes; steps: over links.

    ∫ (p - p''/24) dt, which over every link is p at its middle.
    """
    middle = corner.middle(zeta > corner.zeta)
    mean, rise, bend, turn = corner.cubic(steps, middle)
    t, passed = zeta - middle, (middle[..., None] > LINKS) * 1 - (LINKS < 0)
    start = (np.where(np.isnan(steps), 0.0, steps) * passed).sum(axis=-1)
    found = mean + rise / 2 * t + (t * t - 1) * (bend / 3 + turn / 4 * t)
    return start + np.where(np.isnan(found), 0.0, t * found)


def offsets(
    row: Row,
    nodes: Nodes,
    depth: Array,
    passed: Advances,
    corner: Corners,
    works: Sequence[float],
    before: Array | None = None,
) -> Array:
    """ζ of all lines (s, 2m) of s states with m contacts each, between these nodes (s, 2m).

    passed: of lines on their nodes; works: of closing, opening; before: of lines that resist.
    """
    most = np.where((nodes == 0) | (nodes == row.size - 1), 1.0, _HALF)
    least, zeta = np.full(nodes.shape, -_HALF), np.zeros(nodes.shape)
    if not row.scene.hysteretic:  # a corner holds lines up to a link away
        most = np.where(corner.zeta > _HALF, 1.0, most)
        least = np.where(corner.zeta < -_HALF, -1.0, least)
    most[:, 1:-1], least[:, 1:-1] = 1.0, -1.0  # lines that face each other feel each other
    close = np.repeat(nodes[:, 2::2] - nodes[:, 1:-1:2] < _APART, 2, axis=1)
    moving = np.arange(len(nodes))  # states whose lines are not yet found
    for _ in range(_TURNS):
        there = Corners(corner.zeta[moving], corner.smooth[moving], corner.narrow[moving])
        rests = placed(passed.excess(works), there)
        rests = np.maximum(np.minimum(rests, most[moving]), least[moving])
        came = rests[0] if before is None else np.maximum(before[moving], rests[0])
        found = np.minimum(came, rests[-1])
        found[:, 1:-1][close[moving]] = 0.0
        found = np.where(np.isnan(found), 0.0, found)
        _keep_order(there.narrow, found)
        unsettled = np.abs(found - zeta[moving]).max(axis=1) > _SETTLED
        zeta[moving] = found
        moving = moving[unsettled]
        if nodes.shape[1] == 2 or not moving.size:
            break
        passed = advances(row, nodes[moving], depth[moving], zeta[moving])
    return zeta


def _keep_order(narrow: Mask, zeta: Array) -> None:
    """Lines of narrow contacts that would pass each other are both where they would meet."""
    left, right = zeta[:, ::2], zeta[:, 1::2]
    crossed = narrow[:, ::2] & (left + right < 0)
    middle = (right - left)[crossed] / 2
    left[crossed] = -middle
    right[crossed] = middle


def between(
    row: Row,
    nodes: Nodes,
    depth: Array,
    passed: Advances,
    known: Array | None = None,
    work: float | None = None,
) -> tuple[Array, Array]:
    """x of lines (s, 2m), and U and P (2, s) that states have more than those on their nodes.

    passed: what lines change that are on their nodes; known: x of lines that resist both ways,
    where it has to be known; work: of adhesion, by which they rest, if not w.
    """
    lines, added = of_each(row, nodes, depth, passed, known, work)
    return lines, added.sum(axis=-1)


def of_each(
    row: Row,
    nodes: Nodes,
    depth: Array,
    passed: Advances,
    known: Array | None = None,
    work: float | None = None,
    *,
    narrow: bool = False,
) -> tuple[Array, Array]:
    """x of lines (s, 2m), and U and P (2, s, 2m) that each of them adds; as `between`.

    narrow: whether lone nodes that are pulled stand for contacts narrower than a link.
    """
    corner, lines = corners(row, nodes), known
    if narrow:
        lone = np.repeat(nodes[:, ::2] == nodes[:, 1::2], 2, axis=1)
        corner = corner._replace(narrow=lone & (depth[:, None] < row.f[nodes]))
    if lines is None:
        works = (row.works[0] if work is None else work,)
        zeta = offsets(row, nodes, depth, passed, corner, works)
        lines = positions(row, nodes, zeta, corner)
    else:
        zeta = offsets_of(row, nodes, lines)
    if nodes.shape[1] > 2:
        passed = advances(row, nodes, depth, zeta / 2)
    steps = np.array([passed.stored - row.works[0] * passed.bonds, passed.force])
    return lines, _added(steps, zeta, corner)


def of_states(row: Row, states: Sequence[Contacts], depths: Array) -> tuple[list[Array], Array]:
    """Lines (2m,) of each state, and U and P (2, s) that states have more than on their nodes.

    Of any number of contacts, where closing and opening are alike. Lines feel nothing but the line
    that they face, so that every gap is found once, with the contacts beside it, of all states.
    """
    if max(map(len, states)) == 1:
        lines, more = _found(row, np.reshape(states, (-1, 2)), depths)
        return list(lines), more.sum(axis=-1)
    nodes = [np.ravel(contacts) for contacts in states]
    outer = np.array([[*one[:2], *one[-2:]] for one in nodes])
    both = np.concatenate([outer[:, :2], outer[:, 2:]])
    lines, more = _found(row, both, np.tile(depths, 2))
    count = len(nodes)
    left = lines[:count, 0]
    right = lines[count:, 1]
    added = more[:, :count, 0] + more[:, count:, 1]
    gaps = [one.size // 2 - 1 for one in nodes]
    if not any(gaps):
        return list(np.column_stack([left, right])), added
    state = np.repeat(np.arange(count), gaps)
    sides = np.concatenate(
        [np.lib.stride_tricks.sliding_window_view(one, 4)[::2] for one in nodes if one.size > 2]
    )
    known, at = np.unique(depths[state], return_inverse=True)
    alike, own = np.unique(np.column_stack([sides, at]), axis=0, return_inverse=True)
    lines, inner = _found(row, alike[:, :4], known[alike[:, 4]])
    more = (inner[..., 1] + inner[..., 2])[:, own.ravel()]
    added += [np.bincount(state, each, count) for each in more]
    facing = np.split(lines[own.ravel(), 1:3].ravel(), 2 * np.cumsum(gaps)[:-1])
    of_each_state = zip(left, facing, right, strict=True)
    return [np.array([first, *between, last]) for first, between, last in of_each_state], added


def _found(row: Row, nodes: Nodes, depth: Array) -> tuple[Array, Array]:
    """`of_each` of states with as many contacts each, on a path."""
    narrow = closes_smoothly(row)
    return of_each(row, nodes, depth, advances(row, nodes, depth), narrow=narrow)


def positions(row: Row, nodes: Nodes, zeta: Array, corner: Corners) -> Array:
    """x of lines that far from their nodes; of those at a corner that of the corner.

    As lines that face each other feel each other, one may be more than half a link from its node;
    where it has to tell the node, as a line that stays where it was, it is told within half a link.
    """
    sides, held = outwards(nodes.shape[1]), zeta == corner.zeta
    told = _stretched(zeta, _SHORT) if row.scene.hysteretic else zeta
    x = row.lattice.x(row.first + nodes + sides * (told + row.lattice.edge))
    if held.any():
        x[held] = row.corners[np.abs(row.corners - x[held][:, None]).argmin(axis=1)]
    return np.clip(x, *row.scene.indenter.extent)


def offsets_of(row: Row, nodes: Nodes, lines: Array) -> Array:
    """How far the lines at these positions are from their nodes, in links outwards."""
    off = (lines - row.lattice.x(row.first + nodes)) / row.lattice.spacing
    off = outwards(nodes.shape[1]) * off
    return np.where(np.isin(lines, row.corners), off, _stretched(off, 1 / _SHORT))


def _stretched(zeta: Array, factor: float) -> Array:
    """What is beyond _NEARLY half a link, times a factor; of lines that others face."""
    found = zeta.copy()
    found[:, 1:-1] += (factor - 1) * (zeta - np.clip(zeta, -_NEARLY, _NEARLY))[:, 1:-1]
    return found


def moved(
    row: Row, contacts: Sequence[Contacts], depths: Array, before: Contacts, lines: Lines
) -> list[Lines]:
    """Where lines of contacts, equally many, are at depths (s,), when they were here `before`.

    A line that is less than a link from where one was comes from there, and keeps its x to the last
    bit if it has not moved; others come from the side on which their contacts were.
    """
    nodes, was = np.reshape(contacts, (len(contacts), -1)), np.array(before, int).reshape(1, -1)
    sides, x, corner = outwards(nodes.shape[1]), np.array(lines), corners(row, nodes)
    at = was + outwards(was.size) * offsets_of(row, was, x)
    at, x = (np.pad(part.ravel(), 1, constant_values=(-math.inf, math.inf)) for part in (at, x))
    facing = np.where(sides > 0, np.searchsorted(at, nodes, "right"), np.searchsorted(at, nodes))
    facing -= facing % 2 == (sides > 0)  # the next line, or that before: which faces the same way
    came = np.clip(sides * (at[facing] - nodes), -1.0, 1.0)
    passed = advances(row, nodes, depths)
    zeta = offsets(row, nodes, depths, passed, corner, row.works, came)
    found = positions(row, nodes, zeta, corner)
    near = np.abs(x[facing] - found) <= _ROUNDING * float(np.abs(found).max())
    return [*map(tuple, np.where(near, x[facing], found).tolist())]
