"""Contact lines, force and energy between the nodes, from energies of neighbouring contact sets.

A line at node m passes the next link, outwards, where the gap v there (`Lattice.beside`) falls to
√(2W/S). Its excess

    e = (v √S - √(2W))/√c,      c the weight of the link,

is known at the middles of the links beside it, and between the nodes the line is where the
polynomial through up to four of these vanishes, or at a corner of the profile if e changes sign
there by a jump (a pinned line). Raw lattice values are off by up to Δx/2 in the line; these are off
by O(Δx²). Force and energy are interpolated there likewise: a link changes them by
ΔE = S v²/2 - W and ΔP = dΔE/dd. Places ζ are in links outwards from the last contact node, ζ = 0.

Where opening takes another work of adhesion than closing there are two such places, and a line
between them stays where it last moved, ζ = min(max(ζ before, ζ closing), ζ opening): such a state
has to remember where its lines are.

Of two lines that face each other each is found with the other one where it is, in turns; of the
energy of both moves each adds its own with the other one half-way, exact for a quadratic energy.
"""

from __future__ import annotations

import functools
import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.stencil import LINKS, Stencil
from discretization.nodes.row import Contacts, Row
from discretization.rounding import EPSILON

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]
Room = Sequence[Nodes]
Positions = tuple[float, ...]  # x of all lines
_TURNS = 20  # in which two facing lines are found
_SETTLED = 1e-9  # links
_KEPT = 0.4999  # links: lines whose place has to be remembered keep the node they belong to
_SNAP = 1e-6  # links: by less a line is at a corner
_ROUNDING = 16 * EPSILON  # of x: by less no line has moved


class Ends(NamedTuple):
    """What the advance of n lines over the links beside them takes (n, 7).

    known: whether there is such a link; closing, opening: its excess by both works of adhesion;
    energy, force: what it changes.
    """

    known: Mask
    closing: Array
    opening: Array
    energy: Array
    force: Array


class Lines(NamedTuple):
    """Lines of s states with m contacts each: x and whether pinned (s, 2m).

    added (2, s): what their places between the nodes add to U and P of the contact nodes.
    """

    x: Array
    pinned: Mask
    added: Array


def ends_of(
    row: Row, depth: Array, node: Nodes, side: int, room: Room, other: Nodes | None = None
) -> Ends:
    """Of lines at these nodes of a row (n,), at these depths; other: nodes of those they face.

    room: first and last nodes that they may be at.
    """
    lattice, first, faced = row.lattice, row.first, None
    at = node[:, None] + side * LINKS
    (low, high), ahead = room, at + side
    known = (np.minimum(at, ahead) >= low[:, None]) & (np.maximum(at, ahead) <= high[:, None])
    at = np.clip(at, max(0, -side), row.size - 1 - max(0, side))
    after = at + side
    if other is not None:
        known &= side * (other[:, None] - after) > 1
        faced = first + other[:, None]
    with np.errstate(all="ignore"):  # where there is no such link
        far, rest, stiffness = lattice.beside(first + at, side, faced)
        g, beyond = depth[:, None] - row.at(at), depth[:, None] - row.at(after)
        gap = g - beyond - rest * g
        if other is not None:
            gap = gap + far * ((depth - row.at(other))[:, None] - g)
        bond, weight = row.bond(np.minimum(at, after)), lattice.weight(first + at + side / 2)
        pull = gap * np.sqrt(stiffness / weight)
        closing, opening = (pull - np.sqrt(2 * work * bond / weight) for work in row.works)
        changes = stiffness / 2 * gap * gap - row.works[0] * bond, -stiffness * rest * gap
    return Ends(known, *(np.where(known, part, 0.0) for part in (closing, opening, *changes)))


@dataclass(frozen=True, eq=False)
class Side:
    """n lines, with their nodes, the way they face (one, or n), and what they are found by.

    fixed: those that stay on their nodes; felt: `ends` with the lines they face one link nearer to
    their contacts than in `ends`, and one further away.
    """

    row: Row
    node: Nodes
    side: Any
    fixed: Mask
    ends: Ends
    felt: tuple[Ends, Ends] | None = None

    @classmethod
    def facing(
        cls, row: Row, depth: Array, node: Nodes, side: int, room: Room, fixed: Mask, faced: Nodes
    ) -> Side:
        """Of lines that may be on the nodes of a room and face others."""
        less, ends, more = (
            ends_of(row, depth, node, side, room, np.clip(faced + off, 0, row.size - 1))
            for off in (side, 0, -side)
        )

        def where_known(felt: Ends) -> Ends:
            """Links that are not there if what is faced is nearer do not feel it."""
            return Ends(*(np.where(more.known, *pair) for pair in zip(felt, ends, strict=True)))

        return cls(row, node, side, fixed, ends, (where_known(less), where_known(more)))

    @functools.cached_property
    def stencil(self) -> Stencil:
        """The links that the lines are found by."""
        return Stencil.of(self.row, self.node, self.side, self.ends.known)

    def at(self, faced: Array | float) -> Ends:
        """`ends` with the lines they face so many links from their nodes, outwards."""
        if self.felt is None:
            return self.ends
        s = np.reshape(faced, (-1, 1))
        parts = zip(self.felt[0][1:], self.ends[1:], self.felt[1][1:], strict=True)
        mixed = (own + s * (b - a) / 2 + s * s * (a + b - 2 * own) / 2 for a, own, b in parts)
        return Ends(self.ends.known, *mixed)

    def places(self, faced: Array | float, before: Array | None) -> Array:
        """ζ of the lines; before: what it was, where they resist both ways."""
        ends, stencil = self.at(faced), self.stencil
        found = stencil.places(ends.closing)
        if before is not None:
            found = np.minimum(np.maximum(before, found), stencil.places(ends.opening))
            found = np.where(found == stencil.corner, found, np.clip(found, -_KEPT, _KEPT))
        return np.where(self.fixed, 0.0, found)

    def given(self, x: Array) -> Array:
        """ζ of lines at these positions."""
        lattice = self.row.lattice
        found = self.side * ((x - lattice.origin) / lattice.spacing - self.row.first - self.node)
        return np.where(np.abs(found - self.stencil.corner) < _SNAP, self.stencil.corner, found)

    def positions(self, zeta: Array) -> tuple[Array, Mask]:
        """x of lines at these places, and whether a corner of the profile pins them there."""
        lattice, indenter = self.row.lattice, self.row.indenter
        pinned, corners = zeta == self.stencil.corner, np.asarray(indenter.corners, float)
        beyond = zeta + np.where(pinned, 0.0, lattice.edge)
        x = np.clip(lattice.x(self.row.first + self.node + self.side * beyond), *indenter.extent)
        if not (pinned.any() and corners.size):
            return x, np.zeros(x.shape, bool)
        nearest = corners[np.searchsorted((corners[1:] + corners[:-1]) / 2, x)]
        pinned &= np.abs(nearest - x) < _SNAP * lattice.spacing + _ROUNDING * np.abs(x)
        return np.where(pinned, nearest, x), pinned

    def added(self, zeta: Array, faced: Array | float = 0.0) -> Array:
        """Energy and force (2, n) that the lines add at these places; faced: as `at`."""
        ends, lattice = self.at(np.asarray(faced) / 2), self.row.lattice
        at = zeta - np.where(zeta == self.stencil.corner, lattice.edge, 0.0)
        return np.array([self.stencil.added(part, at) for part in (ends.energy, ends.force)])


def lines_between(
    row: Row,
    nodes: Nodes,
    depth: Array,
    before: Array | None = None,
    known: Array | None = None,
    ends: dict[int, Ends] | None = None,
    *,
    lone: bool = False,
) -> Lines:
    """Lines of s states with m contacts each at these nodes (s, 2m) of a row and depths (s,).

    before: ζ of lines (s, 2m) before they came here, where they resist both ways, whose energies
    are not asked for; known: x of lines (s, 2m); ends: of one contact by side, if not those of
    small slopes. Lines two links apart stay on their nodes, and lines of lone nodes, but of a
    single one if `lone`.
    """
    x, pinned = np.empty(nodes.shape), np.zeros(nodes.shape, bool)
    several, found = nodes.shape[1] > 2, dict(ends or {})
    for i, side in ((0, -1), (-1, 1)):
        room = [np.zeros_like(nodes[:, i]), np.full_like(nodes[:, i], row.size - 1)]
        if several:
            room[side < 0] = nodes[:, i - side]
        if not ends:
            found[side] = ends_of(row, depth, nodes[:, i], side, room)
    node, facing = nodes[:, [0, -1]].T.ravel(), np.repeat([-1, 1], depth.size)
    fixed = (row.first + node == 0) & (facing < 0) & (row.lattice.axis == 0)
    if several or not lone:
        fixed |= node == nodes[:, [1, -2]].T.ravel()
    both = (np.concatenate(pair) for pair in zip(found[-1], found[1], strict=True))
    lines = Side(row, node, facing, fixed, Ends(*both))
    came, given = (None if one is None else one[:, [0, -1]].T.ravel() for one in (before, known))
    zeta = lines.places(0.0, came) if given is None else lines.given(given)
    outer = [part.reshape(2, -1).T for part in lines.positions(zeta)]
    x[:, [0, -1]], pinned[:, [0, -1]] = outer
    total = np.zeros((2, depth.size))
    if before is None:
        total += lines.added(zeta).reshape(2, 2, -1).sum(axis=1)
    if several:
        four = [nodes[:, j : nodes.shape[1] - 3 + j : 2].ravel() for j in range(4)]
        gaps = nodes.shape[1] // 2 - 1
        parts = (None if one is None else one[:, 1:-1].reshape(-1, 2) for one in (before, known))
        inner = _gaps(row, four, np.repeat(depth, gaps), *parts)
        x[:, 1:-1], pinned[:, 1:-1] = (part.reshape(depth.size, -1) for part in inner[:2])
        total += inner.added.reshape(2, depth.size, gaps).sum(axis=2)
    left, right = x[:, ::2], x[:, 1::2]
    crossed = left > right  # a contact smaller than interpolation resolves
    left[crossed] = right[crossed] = (left[crossed] + right[crossed]) / 2
    return Lines(x, pinned, total)


def _gaps(
    row: Row, nodes: list[Nodes], depth: Array, before: Array | None, known: Array | None
) -> Lines:
    """Both lines of n gaps between contacts of these first and last nodes (n,) each."""
    (a, b, c, d), close = nodes, nodes[2] - nodes[1] <= 2
    left = Side.facing(row, depth, b, 1, [a, c], (a == b) | close, c)
    right = Side.facing(row, depth, c, -1, [b, d], (c == d) | close, b)
    came = [None, None] if before is None else list(before.T)
    if known is not None:
        one, other = left.given(known[:, 0]), right.given(known[:, 1])
    else:
        one, other = np.zeros((2, depth.size))
        for _ in range(_TURNS):
            found = left.places(other, came[0])
            moved, one = np.abs(found - one).max(initial=0.0), found
            found = right.places(one, came[1])
            moved, other = max(moved, np.abs(found - other).max(initial=0.0)), found
            if moved <= _SETTLED:
                break
    at = [left.positions(one), right.positions(other)]
    x, pinned = (np.transpose(part) for part in zip(*at, strict=True))
    return Lines(x, pinned, left.added(one, other) + right.added(other, one))


def moved_lines(
    row: Row, nodes: Contacts, depth: float, before: tuple[Contacts, Positions] | None
) -> Positions:
    """Where the lines of contacts with these nodes are that came from others; None: from none.

    A line that is still at its node comes from where it was, to the last bit if it has not moved;
    others come from the side on which their contacts were.
    """
    lattice, facing = row.lattice, _facing(nodes)
    known, came = {}, [-1.0] * len(facing)
    if before is not None:
        known = dict(zip(_facing(before[0]), before[1], strict=True))
        came = [1.0 if _in_contact(before[0], node) else -1.0 for _, node in facing]
        for i, (side, node) in enumerate(facing):
            if (side, node) in known:
                x = known[side, node]
                came[i] = side * (x - lattice.x(row.first + node)) / lattice.spacing
    at = np.reshape(nodes, (1, -1)), np.array([depth])
    found = zip(facing, lines_between(row, *at, np.array([came])).x[0].tolist(), strict=True)
    rounding = _ROUNDING * float(np.abs(lattice.x(row.first + np.array([0, row.size]))).max())
    return tuple(
        known[line] if abs(known.get(line, math.inf) - x) <= rounding else x for line, x in found
    )


def _facing(nodes: Contacts) -> list[tuple[int, int]]:
    """Which way the lines of contacts face, and their nodes."""
    return [each for first, last in nodes for each in ((-1, first), (1, last))]


def _in_contact(nodes: Contacts, node: int) -> bool:
    i = bisect_right(nodes, (node, node)) - 1
    beside = nodes[max(i, 0) : i + 2]
    return any(first <= node <= last for first, last in beside)
