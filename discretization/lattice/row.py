"""Nodes in a row that may come into contact: their heights, adhesion, and running sums of both.

The energy of contacts is a sum over their nodes and links and over the free surfaces between and
beside them. With sums from the node that touches first up to every node, that of a whole contact
is a difference of two numbers, so that force and energy cost O(1) per contact line. Each line
carries the sums of the contact up to it; those of both lines of a contact differ by its own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import ground
from discretization.lattice.ground import Region
from discretization.lattice.nodes import Lattice
from discretization.lattice.rules import Rules, rest_depth
from energy import Indenter, Scene

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Contacts = tuple[tuple[int, int], ...]  # first and last node of each
Part = tuple[int | None, int | None]  # contact nodes on both sides of a free surface; None: none
Parts = tuple[Callable[[Nodes, int, Array], Array], Callable[[Nodes, Nodes, Array], Array]]
_SPARE = 64  # links beyond the last that holds: for interpolation, and to see what is met there
_FEW = 256  # nodes looked at first
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
    """n nodes in a row under an indenter.

    first: the lattice's number of node 0; touch: the node that touches first; f (n,): heights;
    bonds (n - 1,): length or area of each link times the pattern's factor on the work of adhesion;
    works: of adhesion of a contact that is being closed, and of one that is being opened; clear:
    whether an outer free surface can touch no node but the next; overhang: links from the last node
    to an edge of the body, with rotational symmetry, where nodes cannot be moved to be near it.
    """

    lattice: Lattice
    indenter: Indenter
    first: int
    touch: int
    f: Array
    bonds: Array
    works: tuple[float, float]
    clear: bool = False
    overhang: float = 0.0

    @classmethod
    def of(cls, scene: Scene, lattice: Lattice, depth: float) -> Row:
        """The nodes that may be in contact at depths up to this one.

        Of a convex profile they end some links beyond the last that holds when the indenter is
        pressed to this depth, or touches; of others they are all nodes of the region. ValueError if
        the profile ends before, or has too many nodes.
        """
        body, where = scene.indenter, ground.region(lattice, scene.indenter, depth)
        if body.convex:
            left, right = (_outwards(scene, lattice, where, way, depth) for way in (-1, 1))
            f, first = np.concatenate([left[:0:-1], right]), where.lowest - left.size + 1
        else:
            f = ground.heights(lattice, body, np.arange(where.first, where.last + 1.0))
            first = where.first
        nodes = first + np.arange(f.size)
        x = lattice.x(nodes)
        bonds = lattice.on_links(factors(scene, (x[1:] + x[:-1]) / 2) * lattice.cell, nodes)
        opening = lattice.w if scene.opening is None else scene.opened.work_of_adhesion
        clear = body.convex and scene.pattern is None
        end, beyond = body.extent[1], 0.0
        if lattice.axis == 0 and end in body.walls and nodes[-1] == where.last:
            beyond = float(end - x[-1]) / lattice.spacing
        touch = where.lowest - first
        return cls(lattice, body, first, touch, f, bonds, (lattice.w, opening), clear, beyond)

    @property
    def where(self) -> Region:
        """The lattice's numbers of the first and the last node, and of that which touches first."""
        return Region(self.first, self.first + self.f.size - 1, self.first + self.touch)

    @property
    def lowest(self) -> float:
        """f at the node that touches first."""
        return float(self.f[self.touch])

    def heights(self, start: int, stop: int) -> Array:
        """f from one of the lattice's nodes to another, upwards or downwards."""
        low = min(start, stop) - self.first
        own = self.f[low : low + abs(stop - start) + 1]
        return own if stop >= start else own[::-1]

    def adhesion(self, *, opening: bool = False) -> Array:
        """Of each link [energy/length]."""
        return self.works[opening] * self.bonds

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
        stretch = self.lattice.on_links(self.lattice.link / 2 * steps * steps, nodes)
        parts = (self.lattice.on_nodes(part, nodes) for part in (np.ones_like(h), h, h * h))
        whole = (_running(part, touch) for part in parts)
        return Sums(*whole, *(_running(part, touch) for part in (stretch, self.bonds)))

    @property
    def forces(self) -> Parts:
        """What the outermost lines add to P, and the gaps."""
        return self.tail_force, self.gap_force

    @property
    def energies(self) -> Parts:
        """What they add to U."""
        return self.tail_energy, self.gap_energy

    def total(self, parts: Parts, nodes: Nodes, depth: Array) -> Array:
        """P or U (s,) of s states with as many contacts each, their lines (s, 2m), at depths (s,).

        parts: `forces` or `energies`.
        """
        tail, gap = parts
        whole = tail(nodes[:, 0], -1, depth) + tail(nodes[:, -1], 1, depth)
        if nodes.shape[1] > 2:
            whole = whole + gap(nodes[:, 1:-1:2], nodes[:, 2::2], depth[:, None]).sum(axis=1)
        return np.asarray(whole, float)

    def _springs(self, before: Nodes, depth: Array) -> tuple[Array, Array]:
        """Force and energy of the springs up to these node ends."""
        sums, d = self.sums, depth - self.f[self.touch]
        count, h = sums.nodes[before], sums.heights[before]
        spring = self.lattice.spring
        return (
            spring * (count * d - h),
            spring / 2 * ((count * d - 2 * h) * d + sums.squares[before]),
        )

    def _links(self, node: Nodes) -> Array:
        """Energy of the links up to these nodes."""
        return self.sums.stretch[node] - self.works[0] * self.sums.bonds[node]

    def tail_force(self, node: Nodes, side: int, depth: Array) -> Array:
        """What the outermost line at these nodes adds to P, with the surface beyond it."""
        springs, _ = self._springs(node + (side > 0), depth)
        return side * springs + self.lattice.pull(self.first + node, side) * (depth - self.f[node])

    def tail_energy(self, node: Nodes, side: int, depth: Array) -> Array:
        """What the outermost line at these nodes adds to U, with the surface beyond it."""
        _, springs = self._springs(node + (side > 0), depth)
        tail = self.lattice.pull(self.first + node, side) / 2 * (depth - self.f[node]) ** 2
        return np.asarray(side * (springs + self._links(node)) + tail)

    def gap_force(self, left: Nodes, right: Nodes, depth: Array) -> Array:
        """What the two lines of a free surface between contacts add to P, with that surface."""
        springs = self._springs(left + 1, depth)[0] - self._springs(right, depth)[0]
        ends = self.first + left, self.first + right
        pull = self.lattice.gap_force(*ends, self.f[left], self.f[right], depth)
        return np.asarray(springs + pull)

    def gap_energy(self, left: Nodes, right: Nodes, depth: Array) -> Array:
        """What they add to U."""
        springs = self._springs(left + 1, depth)[1] - self._springs(right, depth)[1]
        ends = self.first + left, self.first + right
        stored = self.lattice.gap_energy(*ends, self.f[left], self.f[right], depth)
        return np.asarray(springs + self._links(left) - self._links(right) + stored)


def _outwards(scene: Scene, lattice: Lattice, where: Region, way: int, depth: float) -> Array:
    """Heights from the node that touches first to the link that resists, and some links more."""
    body, start, limit = scene.indenter, where.lowest, (where.last, where.first)[way < 0]
    most, f, passed = abs(limit - start), np.empty(0), 0
    while True:
        nodes = start + way * np.arange(min(2 * f.size or _FEW, most + 1.0))
        with np.errstate(over="ignore", invalid="ignore"):
            more = body.height(ground.positions(lattice, body, nodes[f.size :]))
            f = np.concatenate([f, more])
            top = max(depth, float(f[0]))
            holds = _holds(scene, lattice, nodes[passed:], f[passed:], way, top)
        if not holds.all() or f.size > most:
            break
        passed = f.size - 1
        if passed > ground.MOST:
            raise ValueError(
                f"spacing = {lattice.spacing!r} puts more than {ground.MOST} nodes in contact; give"
                " a larger spacing"
            )
    if holds.all() and body.extent[0 if way < 0 else 1] not in body.walls:
        raise ValueError(ground.unknown(lattice, depth, limit))
    end = (most if holds.all() else passed + int(holds.argmin())) + 1 + _SPARE
    known = f[: end + 1]
    if not np.isfinite(known).all():
        known = known[: int(np.isfinite(known).argmin())]
    return known


def _holds(
    scene: Scene, lattice: Lattice, nodes: Array, f: Array, way: int, depth: float
) -> NDArray[np.bool_]:
    """Whether links outwards may be in contact; with finite slopes while u > -δ₀ beyond them."""
    strongest = max(scene.pattern.factors) if scene.pattern else 1.0
    if lattice.slopes == "finite":
        return np.asarray(f[1:] <= depth + scene.critical_separation * (1 + _SLACK))
    bond = strongest * lattice.w * lattice.cell * lattice.bound(nodes[:-1], nodes[1:])
    return np.asarray(rest_depth(lattice, nodes[:-1], way, f, bond) <= depth)


def _running(parts: Array, start: int) -> Array:
    """Sums (n + 1,) of the n parts from `start` on, those before it counted negative.

    With the digits of long double where there is one: between two contacts the heights may be much
    larger than in contact, and with them what rounding leaves in the difference of two sums.
    """
    parts = parts.astype(np.longdouble)
    before, after = np.cumsum(parts[:start][::-1])[::-1], np.cumsum(parts[start:])
    return np.concatenate([-before, np.zeros(1, parts.dtype), after])


def factors(scene: Scene, x: Array) -> Array:
    """The pattern's factor on w at x."""
    return np.ones_like(x) if scene.pattern is None else scene.pattern.factor(x)
