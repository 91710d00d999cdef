"""Nodes in a row that may come into contact: their heights, adhesion, and running sums of both.

The energy of contacts is a sum over their nodes and links and over the free surfaces between and
beside them. With sums from the node that touches first up to every node, that of a whole contact
is a difference of two numbers, so that force and energy cost O(1) per contact line. Each line
carries the sums of the contact up to it; those of both lines of a contact differ by its own.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.nodes import ground
from discretization.nodes.ground import Region
from discretization.nodes.lattice import Lattice
from discretization.nodes.rules import Rules, rest_depth
from energy import Indenter, Scene

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Contacts = tuple[tuple[int, int], ...]  # first and last node of each
Part = tuple[int | None, int | None]  # contact nodes on both sides of a free surface; None: none
_SPARE = 64  # links beyond the last that holds: for interpolation, and to see what is met there
_SLACK = 1e-9  # of δ₀


class Sums(NamedTuple):
    """From the node that touches first, that one included, up to each of n + 1 node ends.

    Number of nodes, of their heights above it, of the squares of these (n + 1,), with the nodes'
    weights; from that node to each node, of the energies of the links as free surface, and of their
    lengths or areas times the pattern's factor on the work of adhesion (n,).
    """

    nodes: Array
    heights: Array
    squares: Array
    stretch: Array
    bonds: Array


@dataclass(frozen=True, eq=False)
class Row:
    """Nodes in a row under an indenter.

    scene: as far as it has nodes (`Lattice.seen`); where: the lattice's numbers of the first and
    the last node, and of the one that touches first; widest: first and last node of the contact
    when the indenter is pressed to `Row.of`'s depth, of a convex profile.
    """

    lattice: Lattice
    scene: Scene
    where: Region
    widest: tuple[int, int] | None = None

    @classmethod
    def of(cls, scene: Scene, lattice: Lattice, depth: float) -> Row:
        """The nodes that may be in contact at depths up to this one.

        Of a convex profile they end some links beyond the last that holds when the indenter is
        pressed to this depth, or touches; of others they are all nodes of the region. ValueError if
        the profile ends before.
        """
        where = ground.region(lattice, scene.indenter, depth)
        if not scene.indenter.convex:
            return cls(lattice, scene, where)
        (left, low), (right, high) = (
            _outwards(scene, lattice, where, way, depth) for way in (-1, 1)
        )
        whole = Region(where.lowest - low, where.lowest + high, where.lowest)
        return cls(lattice, scene, whole, (low - left, low + right))

    @property
    def indenter(self) -> Indenter:
        """The indenter."""
        return self.scene.indenter

    @property
    def first(self) -> int:
        """The lattice's number of node 0."""
        return self.where.first

    @property
    def touch(self) -> int:
        """The node that touches first."""
        return self.where.lowest - self.where.first

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.where.last - self.where.first + 1

    @property
    def clear(self) -> bool:
        """Whether there is one contact, and no outer surface can touch any node but the next."""
        return self.indenter.convex and self.scene.pattern is None

    @functools.cached_property
    def works(self) -> tuple[float, float]:
        """Of adhesion, of a contact that is being closed, and of one that is being opened."""
        opening, w = self.scene.opening, self.lattice.w
        return w, w if opening is None else opening.work_of_adhesion

    @functools.cached_property
    def corners(self) -> Array:
        """x where the slope of the profile or the factor of the pattern jumps, increasing."""
        places, pattern = list(self.indenter.corners), self.scene.pattern
        if pattern is not None:
            places += np.array(pattern.edges)[np.diff(pattern.factors) != 0].tolist()
        return np.unique(np.asarray(places, float))

    @functools.cached_property
    def breaks(self) -> Array:
        """These corners, counted in nodes of the row; those on a node exactly there."""
        at = (self.corners - self.lattice.origin) / self.lattice.spacing - self.first
        return np.where(np.abs(at - np.rint(at)) < 1e-9, np.rint(at), at)

    @functools.cached_property
    def f(self) -> Array:
        """Heights of all nodes. ValueError if these are too many."""
        if self.size > ground.MOST:
            raise ValueError(
                f"spacing = {self.lattice.spacing!r} puts more than {ground.MOST} nodes in contact;"
                " give a larger spacing"
            )
        nodes = np.arange(self.first, self.where.last + 1.0)
        return ground.heights(self.lattice, self.indenter, nodes)

    @functools.cached_property
    def lowest(self) -> float:
        """f at the node that touches first."""
        return float(self.f[self.touch])

    @functools.cached_property
    def bonds(self) -> Array:
        """Of all links; see `bond`."""
        return self.bond(np.arange(self.size - 1))

    def bond(self, links: Nodes) -> Array:
        """Length or area of links, link i after node i, times the pattern's factor on adhesion."""
        middles, pattern = self.first + links + 0.5, self.scene.pattern
        own = np.broadcast_to(self.lattice.cell * self.lattice.weight(middles), links.shape)
        return own if pattern is None else own * pattern.factor(self.lattice.x(middles))

    def alone(self, depth: float, tie: float) -> Contacts:
        """The contact of a convex profile that has been pressed to `Row.of`'s depth, or touched.

        It has come back from there to this depth, or is still there. tie: what a line that stays
        where both sides cost the same may be off by. Outwards the depths at which links open
        fall, but not about an axis.
        """
        assert self.widest is not None
        if depth >= self.lowest:
            return (self.widest,)
        ends = []
        for way, widest in zip((-1, 1), self.widest, strict=True):
            asked = self.scene, self.lattice, self.where.lowest, way
            most = abs(widest - self.touch)
            if self.lattice.axis == 0:
                own = np.flatnonzero(_holds(*asked, np.arange(most), depth + tie))
                held = int(np.max(own + 1, initial=0))
            else:
                holds = functools.partial(_holds, *asked, depth=depth + tie)
                held = ground.first_failing(holds, most)
            ends.append(self.touch + way * held)
        return ((ends[0], ends[1]),) if ends[1] > ends[0] else ()

    @functools.cached_property
    def rules(self) -> tuple[Rules, Rules]:
        """The rules of contacts that are being closed, and of those that are being opened."""
        closing, opening = self.works
        first = Rules(self.lattice, self.f, closing * self.bonds, self.clear, self.first)
        if opening == closing:
            return first, first
        return first, replace(first, work=opening * self.bonds)

    @functools.cached_property
    def sums(self) -> Sums:
        """The running sums."""
        h, touch = self.f - self.f[self.touch], self.touch
        steps, nodes = np.diff(self.f), self.first + np.arange(h.size)
        weights = self.lattice.weight(nodes)
        stretch = self.lattice.link / 2 * steps * steps * self.lattice.weight(nodes[:-1] + 0.5)
        parts = (part * weights for part in (np.ones_like(h), h, h * h))
        whole = (_running(part, touch) for part in parts)
        return Sums(*whole, *(_running(part, touch) for part in (stretch, self.bonds)))

    def totals(self, nodes: Nodes, depth: Array) -> Array:
        """U and P (2, s) of s states with m contacts each at these nodes (s, 2m).

        With the digits of the running sums.
        """
        gaps = self.gap(nodes[:, 1:-1:2], nodes[:, 2::2], depth[:, None]).sum(axis=2)
        tails = self.tail(nodes[:, 0], -1, depth) + self.tail(nodes[:, -1], 1, depth)
        return np.asarray(tails + gaps)

    def bonded(self, nodes: Contacts) -> float:
        """Length or area of contacts, weighted with the pattern's factor."""
        bonds = self.sums.bonds
        return float(sum(bonds[last] - bonds[first] for first, last in nodes))

    def _held(self, before: Nodes, node: Nodes, depth: Array) -> Array:
        """Energy and force of the springs up to node ends, and of the links up to nodes."""
        sums, d = self.sums, depth - self.f[self.touch]
        count, h, spring = sums.nodes[before], sums.heights[before], self.lattice.spring
        energy = spring / 2 * ((count * d - 2 * h) * d + sums.squares[before])
        links = sums.stretch[node] - self.works[0] * sums.bonds[node]
        return np.array([energy + links, spring * (count * d - h)])

    def tail(self, node: Nodes, side: int, depth: Array) -> Array:
        """What outermost lines at these nodes add to U and P, with the surface beyond them."""
        held, u = self._held(node + (side > 0), node, depth), depth - self.f[node]
        pull = self.lattice.pull(self.first + node, side) * u
        return side * held + np.array([pull * u / 2, pull])

    def gap(self, left: Nodes, right: Nodes, depth: Array) -> Array:
        """What both lines of free surfaces between contacts add, with these surfaces."""
        held = self._held(left + 1, left, depth) - self._held(right, right, depth)
        ends = self.first + left, self.first + right
        return held + self.lattice.gap(*ends, depth - self.f[left], depth - self.f[right])


def _outwards(
    scene: Scene, lattice: Lattice, where: Region, way: int, depth: float
) -> tuple[int, int]:
    """Links outwards from the node that touches first up to one that resists, and of the row."""
    body, start, limit = scene.indenter, where.lowest, (where.last, where.first)[way < 0]
    most = abs(limit - start)
    top = max(depth, float(ground.heights(lattice, body, np.array([start]))[0]))
    held = ground.first_failing(lambda links: _holds(scene, lattice, start, way, links, top), most)
    if held == most and body.extent[0 if way < 0 else 1] not in body.walls:
        raise ValueError(ground.unknown(lattice, depth, limit))
    nodes = start + way * np.arange(held, min(most, held + 1 + _SPARE) + 1)
    with np.errstate(over="ignore", invalid="ignore"):
        known = np.isfinite(body.height(ground.positions(lattice, body, nodes)))
    return held, held - 1 + int(known.size if known.all() else known.argmin())


def _holds(
    scene: Scene, lattice: Lattice, start: int, way: int, links: Nodes, depth: float
) -> NDArray[np.bool_]:
    """Whether links outwards may be in contact; with finite slopes while u > -δ₀ beyond them."""
    nodes = start + way * links
    strongest = max(scene.pattern.factors) if scene.pattern else 1.0
    bonds = strongest * lattice.w * lattice.cell * lattice.weight(nodes + way / 2)
    with np.errstate(over="ignore", invalid="ignore"):
        f, after = (
            scene.indenter.height(ground.positions(lattice, scene.indenter, at))
            for at in (nodes, nodes + way)
        )
        if lattice.slopes == "finite":
            return np.asarray(after <= depth + scene.critical_separation * (1 + _SLACK))
        return np.asarray(rest_depth(lattice, nodes, way, f, after, bonds) <= depth)


def _running(parts: Array, start: int) -> Array:
    """Sums (n + 1,) of the n parts from `start` on, those before it counted negative.

    With the digits of long double where there is one: between two contacts the heights may be much
    larger than in contact, and with them what rounding leaves in the difference of two sums.
    """
    parts = parts.astype(np.longdouble)
    before, after = np.cumsum(parts[:start][::-1])[::-1], np.cumsum(parts[start:])
    return np.concatenate([-before, np.zeros(1, parts.dtype), after])
