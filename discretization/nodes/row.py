"""Nodes in a row that may come into contact: their heights, adhesion, and running sums of both.

The energy of contacts is a sum over their nodes and links and over the free surfaces between and
beside them. With sums from the node that touches first up to every node, that of a whole contact
is a difference of two numbers, so that force and energy cost O(1) per contact line. Each line
carries the sums of the contact up to it; those of both lines of a contact differ by its own.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from discretization import profile
from discretization.nodes.lattice import PIECE, Lattice
from discretization.nodes.rules import Rules
from energy import Indenter, Scene
from energy.arrays import Array, Nodes

Contacts = tuple[tuple[int, int], ...]  # first and last node of each
MOST = 10**7  # nodes that are looked through, or kept
_WINDOW = 1 << 10  # nodes, the first half window of an endless profile
_ENDLESS = 1 << 31  # nodes of a profile without ends
_SPARE = 8  # links beyond the last that may hold, for interpolation
_AHEAD = np.append(0, np.unique((1.1 ** np.arange(226)).astype(np.int64)))  # links: growing steps


def positions(lattice: Lattice, indenter: Indenter, nodes: Array | Nodes) -> Array:
    """x of the nodes; nodes on an end of the extent stay on it in spite of rounding."""
    x, (lo, hi) = np.asarray(lattice.x(nodes)), indenter.extent
    return x if (lo, hi) == (-math.inf, math.inf) else np.minimum(np.maximum(x, lo), hi)


def heights(lattice: Lattice, indenter: Indenter, nodes: Array | Nodes) -> Array:
    """f at the nodes. ValueError unless they are finite."""
    return profile.heights(indenter, positions(lattice, indenter, nodes))


def region(lattice: Lattice, indenter: Indenter, depth: float) -> tuple[int, int, int]:
    """The lattice's numbers of the first and the last node where contact is possible.

    And of the one that touches first. ValueError if the profile has no lowest point to touch with.
    """
    dx, apex, ends = lattice.spacing, indenter.apex, indenter.extent
    whole = near = numbers(lattice, ends)
    if whole[0] > whole[1] or (whole[0] == whole[1] and lattice.gamma1):
        few = "no" if whole[0] > whole[1] else "one"
        raise ValueError(f"spacing = {dx!r} leaves {few} node on the indenter; give a smaller one")
    if not indenter.convex or apex is None:
        if not math.isfinite(np.ptp(ends)):
            ends = profile.window(indenter, depth, _WINDOW * dx, lattice.deepest_contact)
        near = numbers(lattice, ends)
        if near[1] - near[0] > MOST:
            raise ValueError(
                f"spacing = {dx!r} puts {near[1] - near[0]} nodes on the indenter: at most {MOST} "
                "are looked through; give it a smaller extent, or a larger spacing"
            )
    first, last = whole if indenter.convex else near
    if apex is not None:
        beside = min(max(math.floor((apex - lattice.origin) / dx + 1e-9), first), last)
        near = beside, min(beside + 1, last)
    lowest = near[0] + int(np.argmin(heights(lattice, indenter, np.arange(near[0], near[1] + 1.0))))
    return first, last, lowest


def numbers(lattice: Lattice, extent: tuple[float, float]) -> tuple[int, int]:
    """The first and the last node between two places."""
    lo, hi = ((x - lattice.origin) / lattice.spacing for x in extent)
    return math.ceil(max(lo - 1e-9, -_ENDLESS)), math.floor(min(hi + 1e-9, _ENDLESS))


@dataclass(frozen=True, eq=False)
class Row:
    """Nodes in a row under an indenter; scene: as far as it has nodes (`Lattice.seen`).

    first: the lattice's number of node 0; touch: the node that touches first, lowest: f there.
    """

    lattice: Lattice
    scene: Scene
    first: int
    size: int
    touch: int

    @classmethod
    def of(cls, scene: Scene, lattice: Lattice, depth: float) -> Row:
        """The nodes that may be in contact at depths up to this one.

        Of a convex profile they end some links beyond the last that holds when the indenter is
        pressed to this depth, or touches; of others they are all nodes of the region.
        """
        first, last, lowest = region(lattice, scene.indenter, depth)
        if scene.indenter.convex:
            first, last = _outermost(scene, lattice, [[first], [last]], lowest, depth)
        return cls(lattice, scene, first, last - first + 1, lowest - first)

    @functools.cached_property
    def clear(self) -> bool:
        """Whether there is one contact, and no outer surface can touch any node but the next.

        So it is of a profile whose nodes are convex, whether it says that it is or not.
        """
        if self.scene.pattern is not None:
            return False
        return self.scene.indenter.convex or bool((np.diff(self.f, 2) > 0).all())

    @functools.cached_property
    def works(self) -> tuple[float, float]:
        """Of adhesion, of a contact that is being closed, and of one that is being opened."""
        opening, w = self.scene.opening, self.lattice.w
        return w, w if opening is None else opening.work_of_adhesion

    @functools.cached_property
    def corners(self) -> Array:
        """x where the slope of the profile or the factor of the pattern jumps, increasing."""
        places, pattern = list(self.scene.indenter.corners), self.scene.pattern
        if pattern is not None:
            places += np.array(pattern.edges)[np.diff(pattern.factors) != 0].tolist()
        return np.array(sorted({*map(float, places)} - {self.lattice.axis}))

    @functools.cached_property
    def breaks(self) -> Array:
        """These corners, counted in nodes of the row; those on a node exactly there."""
        at = (self.corners - self.lattice.origin) / self.lattice.spacing - self.first
        return np.where(np.abs(at - np.rint(at)) < 1e-9, np.rint(at), at)

    @functools.cached_property
    def f(self) -> Array:
        """Heights of all nodes. ValueError if these are too many."""
        if self.size > MOST:
            many = f"spacing = {self.lattice.spacing!r} puts more than {MOST} nodes in contact"
            raise ValueError(many + "; give a larger spacing")
        f, nodes = np.empty(self.size), np.arange(min(self.size, PIECE), dtype=float)
        for start in range(0, self.size, PIECE):
            own, first = f[start : start + PIECE], self.first + start
            own[:] = heights(self.lattice, self.scene.indenter, first + nodes[: own.size])
        return f

    lowest = property(lambda self: float(self.f[self.touch]))

    def adhesion(self, work: float) -> Array:
        """Of links (n - 1,), link i after node i: work times length or area, and the pattern."""
        own, pattern = self.lattice.sizes(self.first + 0.5, self.size - 1, work), self.scene.pattern
        if pattern is None:
            return own
        return own * pattern.factor(self.lattice.x(self.first + 0.5 + np.arange(own.size)))

    bonds = functools.cached_property(lambda self: self.adhesion(1.0))

    @functools.cached_property
    def rules(self) -> tuple[Rules, Rules]:
        """The rules of contacts that are being closed, and of those that are being opened."""
        closing, opening = self.works
        first = Rules(self.lattice, self.f, self.adhesion(closing), self.clear, self.first)
        return first, replace(first, work=self.adhesion(opening)) if opening != closing else first

    @functools.cached_property
    def sums(self) -> tuple[Array, Array]:
        """Running sums from the node that touches first up to node ends, and up to nodes.

        Of weights, of these times heights above it, and squares (3, n + 1); of links' energies.
        """
        h, lattice, touch = self.f - self.lowest, self.lattice, self.touch
        nodes, steps = self.first + np.arange(h.size), np.diff(self.f)
        springs = lattice.weight(nodes) * np.array([np.ones(h.size), h, h * h])
        links = lattice.link / 2 * steps * steps * lattice.weight(nodes[:-1] + 0.5)
        return _running(springs, touch), _running(links - self.works[0] * self.bonds, touch)

    def refuse_unknown(self, depth: float, nodes: Contacts) -> None:
        """ValueError for contacts at an end of the profile that is not the end of the body."""
        ends = (nodes[0][0], 0), (nodes[-1][1], self.size - 1)
        for (node, limit), end in zip(ends, self.scene.indenter.extent, strict=True):
            if node == limit and end not in self.scene.indenter.walls:
                raise profile.unknown(depth, self.lattice.x(self.first + node))

    def totals(self, nodes: Nodes, depth: Array) -> Array:
        """U and P (2, s) of s states with m contacts each at these nodes (s, 2m).

        With the digits of the running sums.
        """
        at, u = self.first + nodes, depth[:, None] - self.f[nodes]
        left, right = nodes[:, ::2], nodes[:, 1::2]
        d, spring = depth - self.lowest, self.lattice.spring
        springs, links = self.sums
        count, h, squares = (springs[:, right + 1] - springs[:, left]).sum(axis=2)
        energy = spring / 2 * ((count * d - 2 * h) * d + squares)
        energy += (links[right] - links[left]).sum(axis=1)
        found = np.array([energy, spring * (count * d - h)])
        for end, side in ((0, -1), (-1, 1)):
            pull = self.lattice.pull(at[:, end], side) * u[:, end]
            found += np.array([pull * u[:, end] / 2, pull])
        tie, ground = self.lattice.pair(at[:, 2::2] - at[:, 1:-1:2])
        one, other = u[:, 1:-1:2], u[:, 2::2]
        stored = (ground * (one**2 + other**2) + tie * (one - other) ** 2) / 2
        return np.asarray(found + np.sum([stored, ground * (one + other)], axis=2))


def _outermost(scene: Scene, lattice: Lattice, ends: Any, lowest: int, depth: float) -> list[int]:
    """The last nodes on both sides of a convex profile: some beyond a link that does not hold."""
    body, sides, most = scene.indenter, np.array([[-1], [1]]), np.abs(np.subtract(ends, lowest))
    ahead = np.minimum(_AHEAD, most)
    strongest = lattice.w * (max(scene.pattern.factors) if scene.pattern else 1.0)
    nodes = lowest + sides * ahead
    with np.errstate(over="ignore", invalid="ignore"):
        own, after = (body.height(positions(lattice, body, at)) for at in (nodes, nodes + sides))
        top = max(depth, float(own[0, 0]))
        holds = after <= top + scene.critical_separation * (1 + 1e-9)
        if lattice.linear:
            _, remainder, stiffness = lattice.beside(nodes, sides)
            bonds = strongest * lattice.cell * lattice.weight(nodes + sides / 2)
            holds = own + (after - own - np.sqrt(2 * bonds / stiffness)) / remainder <= top
    holds[:, -1] = False
    last = ahead[[0, 1], holds.argmin(axis=1), None] + _SPARE
    return list((lowest + sides * np.minimum(last, most))[:, 0].tolist())


def _running(parts: Array, start: int) -> Array:
    """Sums (..., n + 1) of the n parts from `start` on, those before it counted negative.

    In long double: between two contacts heights may be much larger than in contact.
    """
    before, after = parts[..., :start][..., ::-1], parts[..., start:]
    found = np.zeros((*parts.shape[:-1], parts.shape[-1] + 1), np.longdouble)
    np.cumsum(after, axis=-1, out=found[..., start + 1 :])
    np.negative(np.cumsum(before, -1, np.longdouble)[..., ::-1], out=found[..., :start])
    return found
