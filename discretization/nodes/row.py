"""Nodes in a row that may come into contact: their heights, adhesion, and running sums of both.

The energy of contacts is a sum over their nodes and links and over the free surfaces between and
beside them. With sums from the node that touches first up to every node, that of a whole contact
is a difference of two numbers, so that force and energy cost O(1) per contact line. Each line
carries the sums of the contact up to it; those of both lines of a contact differ by its own.

Conventions
-----------
Depths d and displacements u are positive down into the layer, heights f of the profile upwards;
u = d - f in contact; P is positive if compressive.

There are two ways to number nodes. The lattice's numbers are any integers, with x = `Lattice.x`.
The row's numbers are 0 ... n - 1 from left to right, less than those by `Row.first`; all contacts,
arrays and methods of `Row` use these. Link i is between the nodes i and i + 1. A node i of the row
has the weight `lattice.weight(first + i)`, link i that of its middle, `first + i + ½`: 1, or about
an axis the radius over Δr.

A contact is (first node, last node), a lone node (i, i). Arrays of s states with m contacts each
have the shape (s, 2m): first and last node of the first contact, then of the second, ....

Of a lattice, `spacing` is Δx, `origin` x of node 0, `w` the work of adhesion of closing, `cell` the
length or area of a link of weight 1, `spring_stiffness` kΔx and `link_stiffness` t = γ₁/Δx, both of
weight 1; `sizes(first, n, unit)` are lengths or areas of n nodes or links times a unit;
`tail_stiffness(node, side)` is what the tail beyond a contact node pulls with over u;
`free_node_response(node, side)` has B = 0, 1 - A and S of the node next to a line, see
lattice.py; nodes are the lattice's numbers in all of these. `deepest_contact` is how far above the
depth a node may adhere. A place counts as on a node within ON_NODE, in spacings, and PIECE nodes
are worked on at a time.

Of an indenter, `extent` is (low, high), where its profile is known, ±∞ without an end; `walls` are
those of its ends at which the body itself ends; `corners` are x at which f' jumps; `apex` is x of
the lowest point if the profile falls nowhere on the way outwards, else None. `Scene.opening` has
the surface energies of contacts that open, or is None, as of those that close. A pattern multiplies
w by `factors`, one for each stripe from left to right, between its `edges`.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from discretization import profile
from discretization.nodes.lattice import ON_NODE, PIECE, Lattice
from discretization.nodes.thresholds import Thresholds
from energy import Indenter, Scene
from energy.arrays import Array, Nodes

Contacts = tuple[tuple[int, int], ...]  # first and last node of each
# Nodes that are looked through, or kept: arrays of 80 MB. A million or 10⁸ changes no result
# (`python -m tests.sensitivity discretization.nodes.row MOST`).
MOST = 10**7


class RowLimits(NamedTuple):
    """How many nodes are looked at; MOST bounds them.

    At a tenth or ten times its value each leaves the 41 or more random states and paths that read
    it as they are to 1e-9 (`first_window` and `spare` are not read there): `python -m
    tests.sensitivity discretization.nodes.row`.

    Attributes
    ----------
    first_window : int
        Nodes on each side of x = 0 that are looked at first of a profile without ends;
        `profile.window` doubles them until contact beyond is impossible.
    endless : int
        Number of the last node of a profile without ends: as far as steps of 1.1ⁿ look.
    spare : int
        Links kept beyond the last one that may hold, for the interpolation between nodes, which
        reads three beyond a line.
    """

    first_window: int = 1 << 10
    endless: int = 1 << 31
    spare: int = 8


_LIMITS = RowLimits()


# Links from the lowest node at which it is looked how far a convex contact may reach: by steps that
# grow like 1.1ⁿ up to 1.1²²⁵ = 2.06e9, so that a row is at most a tenth longer than needed.
_AHEAD = np.append(0, np.unique((1.1 ** np.arange(226)).astype(np.int64)))


def positions(lattice: Lattice, indenter: Indenter, nodes: Array | Nodes) -> Array:
    """Positions of nodes; those on an end of the extent stay on it in spite of rounding.

    Parameters
    ----------
    lattice : Lattice
    indenter : Indenter
    nodes : ndarray
        The lattice's numbers of the nodes.

    Returns
    -------
    ndarray
        x [length].
    """
    x = np.asarray(lattice.x(nodes))
    low, high = indenter.extent  # outside of it the profile is not known
    if (low, high) == (-math.inf, math.inf):
        return x
    return np.minimum(np.maximum(x, low), high)


def heights(lattice: Lattice, indenter: Indenter, nodes: Array | Nodes) -> Array:
    """Heights of the profile at nodes.

    Parameters
    ----------
    lattice : Lattice
    indenter : Indenter
    nodes : ndarray
        The lattice's numbers of the nodes.

    Returns
    -------
    ndarray
        f [length].

    Raises
    ------
    ValueError
        Unless they are finite.
    """
    return profile.heights(indenter, positions(lattice, indenter, nodes))


def region(lattice: Lattice, indenter: Indenter, depth: float) -> tuple[int, int, int]:
    """Where contact is possible at a depth.

    Parameters
    ----------
    lattice : Lattice
    indenter : Indenter
    depth : float
        [length].

    Returns
    -------
    first, last, lowest : int
        The lattice's numbers of the first and the last node there, and of the one that touches
        first.

    Raises
    ------
    ValueError
        If there are no nodes, or too many, or the profile has no lowest point to touch with.
    """
    spacing = lattice.spacing
    apex = indenter.apex
    on_body = numbers(lattice, indenter.extent)
    if on_body[0] > on_body[1] or (on_body[0] == on_body[1] and lattice.gamma1):
        few = "no" if on_body[0] > on_body[1] else "one"
        raise ValueError(
            f"spacing = {spacing!r} leaves {few} node on the indenter; give a smaller one"
        )
    searched = on_body  # for the lowest node
    if not indenter.convex or apex is None:
        ends = indenter.extent
        if not math.isfinite(np.ptp(ends)):
            ends = profile.window(
                indenter, depth, _LIMITS.first_window * spacing, lattice.deepest_contact
            )
        searched = numbers(lattice, ends)
        if searched[1] - searched[0] > MOST:
            raise ValueError(
                f"spacing = {spacing!r} puts {searched[1] - searched[0]} nodes on the indenter: at "
                f"most {MOST} are looked through; give it a smaller extent, or a larger spacing"
            )
    first, last = on_body if indenter.convex else searched
    if apex is not None:  # the lowest node is next to it, on either side
        before_apex = math.floor((apex - lattice.origin) / spacing + ON_NODE)
        before_apex = min(max(before_apex, first), last)
        searched = (before_apex, min(before_apex + 1, last))
    nodes = np.arange(searched[0], searched[1] + 1.0)
    lowest = searched[0] + int(np.argmin(heights(lattice, indenter, nodes)))
    return first, last, lowest


def numbers(lattice: Lattice, extent: tuple[float, float]) -> tuple[int, int]:
    """The first and the last node between two places, those on a node included.

    Parameters
    ----------
    lattice : Lattice
    extent : tuple of float
        The left and the right place [length]; infinite ones count as 2³¹ nodes away.

    Returns
    -------
    first, last : int
        The lattice's numbers; first > last if there is no node in between.
    """
    low, high = ((x - lattice.origin) / lattice.spacing for x in extent)
    first = math.ceil(max(low - ON_NODE, -_LIMITS.endless))
    last = math.floor(min(high + ON_NODE, _LIMITS.endless))
    return first, last


@dataclass(frozen=True, eq=False)
class Row:
    """Nodes in a row under an indenter.

    Attributes
    ----------
    lattice : Lattice
    scene : Scene
        Its part that has nodes (`Lattice.scene_on_nodes`).
    first : int
        The lattice's number of node 0.
    size : int
        n.
    touch : int
        The node that touches first.
    """

    lattice: Lattice
    scene: Scene
    first: int
    size: int
    touch: int

    @classmethod
    def of(cls, scene: Scene, lattice: Lattice, depth: float) -> Row:
        """The nodes that may be in contact at depths up to this one [length].

        Of a convex profile they end some links beyond the last that holds when the indenter is
        pressed to this depth, or touches; of others they are all nodes of the region.

        Parameters
        ----------
        scene : Scene
            Its part that has nodes (`Lattice.scene_on_nodes`).
        lattice : Lattice
        depth : float
            [length].

        Returns
        -------
        Row

        Raises
        ------
        ValueError
            As `region`.
        """
        first, last, lowest = region(lattice, scene.indenter, depth)
        if scene.indenter.convex:
            first, last = _outermost(scene, lattice, first, last, lowest, depth)
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
        """Work of adhesion of a contact that closes, and of one that opens [energy/area]."""
        closing = self.lattice.w
        opening = self.scene.opening
        return closing, closing if opening is None else opening.work_of_adhesion

    @functools.cached_property
    def corners(self) -> Array:
        """x where the slope of the profile or the factor of the pattern jumps, increasing.

        But for a tip on an axis: there is no line at it.
        """
        places = list(self.scene.indenter.corners)
        pattern = self.scene.pattern
        if pattern is not None:
            jumps = np.diff(pattern.factors) != 0
            places += np.array(pattern.edges)[jumps].tolist()
        return np.array(sorted({*map(float, places)} - {self.lattice.axis}))

    @functools.cached_property
    def breaks(self) -> Array:
        """`corners` in numbers of nodes of the row, between nodes not whole; on a node exactly."""
        at = (self.corners - self.lattice.origin) / self.lattice.spacing - self.first
        return np.where(np.abs(at - np.rint(at)) < ON_NODE, np.rint(at), at)

    @functools.cached_property
    def f(self) -> Array:
        """Heights of all nodes (n,) [length]. ValueError if these are more than MOST."""
        if self.size > MOST:
            many = f"spacing = {self.lattice.spacing!r} puts more than {MOST} nodes in contact"
            raise ValueError(many + "; give a larger spacing")
        f = np.empty(self.size)
        nodes = np.arange(min(self.size, PIECE), dtype=float)
        for start in range(0, self.size, PIECE):
            own = f[start : start + PIECE]
            first = self.first + start
            own[:] = heights(self.lattice, self.scene.indenter, first + nodes[: own.size])
        return f

    @property
    def lowest(self) -> float:
        """Height of the node that touches first: the depth of first touch [length]."""
        return float(self.f[self.touch])

    def adhesion(self, work: float) -> Array:
        """Adhesion of links: work times their length or area, and the factor of the pattern.

        Parameters
        ----------
        work : float
            Work of adhesion [energy/area].

        Returns
        -------
        ndarray (n - 1,)
            Link i is the one after node i [energy/length], or [energy] about an axis.
        """
        links = self.lattice.sizes(self.first + 0.5, self.size - 1, work)
        pattern = self.scene.pattern
        if pattern is None:
            return links
        return links * pattern.factor(self.lattice.x(self.first + 0.5 + np.arange(links.size)))

    @functools.cached_property
    def bonds(self) -> Array:
        """Lengths or areas of links (n - 1,) times the pattern's factor."""
        return self.adhesion(1.0)

    @functools.cached_property
    def thresholds(self) -> tuple[Thresholds, Thresholds]:
        """The thresholds of contacts that close, and of those that open; one object if alike."""
        closing, opening = self.works
        first = Thresholds(self.lattice, self.f, self.adhesion(closing), self.clear, self.first)
        if opening == closing:
            return first, first
        return first, replace(first, work=self.adhesion(opening))

    @functools.cached_property
    def sums(self) -> tuple[Array, Array]:
        """Running sums from the node that touches first, in long double.

        Returns
        -------
        springs : ndarray (3, n + 1)
            Entry i is the sum of the nodes before i, less that of those before the node `touch`: so
            nodes i to j have the difference of the entries j + 1 and i. Rows: of the weights, of
            these times h, and times h², h the height above the node that touches first [length].
        links : ndarray (n,)
            Likewise of what links in contact store, less their adhesion: nodes i to j have between
            them the difference of the entries j and i [energy/length].
        """
        lattice = self.lattice
        h = self.f - self.lowest
        nodes = self.first + np.arange(h.size)
        steps = np.diff(self.f)
        springs = lattice.weight(nodes) * np.array([np.ones(h.size), h, h * h])
        links = lattice.link_stiffness / 2 * steps * steps * lattice.weight(nodes[:-1] + 0.5)
        links = links - self.works[0] * self.bonds
        return _running(springs, self.touch), _running(links, self.touch)

    def refuse_unknown(self, depth: float, nodes: Contacts) -> None:
        """Raise an error if contacts reach an end of the profile that is not the end of the body.

        Parameters
        ----------
        depth : float
            [length].
        nodes : Contacts
            First and last nodes of the contacts.

        Raises
        ------
        ValueError
        """
        low, high = self.scene.indenter.extent
        first = nodes[0][0]
        last = nodes[-1][1]
        for node, limit, end in ((first, 0, low), (last, self.size - 1, high)):
            if node == limit and end not in self.scene.indenter.walls:
                # `profile.unknown` makes the ValueError, with the depth and x of the node.
                raise profile.unknown(depth, self.lattice.x(self.first + node))

    def totals(self, nodes: Nodes, depth: Array) -> Array:
        """Energy and force of contacts whose lines are on nodes, free surfaces in equilibrium.

        Sums over the contacts and what free surfaces do as springs (`Lattice.surface_stiffnesses`):
        a tail pulls with G u, a surface between two lines with C (u - u') + G u. Adhesion is that
        of closing.

        Parameters
        ----------
        nodes : ndarray of int (s, 2m)
            First and last nodes of the m contacts of s states.
        depth : ndarray (s,)
            [length].

        Returns
        -------
        ndarray (2, s)
            U [energy/length] and P [force/length].
        """
        u = depth[:, None] - self.f[nodes]
        energy, force = self._in_contact(nodes, depth)
        lattice_nodes = self.first + nodes
        for end, side in ((0, -1), (-1, 1)):
            pull = self.lattice.tail_stiffness(lattice_nodes[:, end], side) * u[:, end]
            energy = energy + pull * u[:, end] / 2
            force = force + pull

        # Free surfaces between contacts: right line of one contact to left line of the next.
        tie, ground = self.lattice.surface_stiffnesses(
            lattice_nodes[:, 2::2] - lattice_nodes[:, 1:-1:2]
        )
        left = u[:, 1:-1:2]
        right = u[:, 2::2]
        stored = (ground * (left**2 + right**2) + tie * (left - right) ** 2) / 2
        pulls = ground * (left + right)
        of_surfaces = np.sum([stored, pulls], axis=2)
        return np.asarray(np.array([energy, force]) + of_surfaces)

    def _in_contact(self, nodes: Nodes, depth: Array) -> tuple[Array, Array]:
        """Energy and force (s,) of springs and links in contact.

        With u = d - f = d' - h, d' and h counted from the lowest node: Σ u²/2 and Σ u by sums of 1,
        h and h² over the nodes, times their weights.
        """
        first = nodes[:, ::2]
        last = nodes[:, 1::2]
        d = depth - self.lowest
        spring = self.lattice.spring_stiffness
        springs, links = self.sums
        weights, h, squares = (springs[:, last + 1] - springs[:, first]).sum(axis=2)
        energy = spring / 2 * ((weights * d - 2 * h) * d + squares)
        energy += (links[last] - links[first]).sum(axis=1)
        return energy, spring * (weights * d - h)


def _outermost(
    scene: Scene, lattice: Lattice, first: int, last: int, lowest: int, depth: float
) -> tuple[int, int]:
    """First and last node of a row under a convex profile: some beyond a link that does not hold.

    Looked for from the lowest node outwards, on its left (row 0) and its right (row 1), at links
    that are ever farther apart; those before a link that would not close at this depth, or at first
    touch, may be in contact. With springs that are not linear, or finite slopes, so may all that
    are no more than δ₀ above the surface.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    first, last : int
        The outermost nodes on the profile; with `lowest`, the node that touches first, they are the
        lattice's numbers.
    lowest : int
    depth : float
        [length].

    Returns
    -------
    first, last : int
        The lattice's numbers.
    """
    sides = np.array([[-1], [1]])
    most = np.array([[abs(first - lowest)], [abs(last - lowest)]])
    ahead = np.minimum(_AHEAD, most)
    nodes = lowest + sides * ahead
    with np.errstate(over="ignore", invalid="ignore"):
        own = scene.indenter.height(positions(lattice, scene.indenter, nodes))
        after = scene.indenter.height(positions(lattice, scene.indenter, nodes + sides))
        pressed = max(depth, float(own[0, 0]))  # own[0, 0] is the height of the lowest node
        if lattice.linear:
            _, remainder, stiffness = lattice.free_node_response(nodes, sides)
            strongest = lattice.w * (max(scene.pattern.factors) if scene.pattern else 1.0)
            bonds = strongest * lattice.cell * lattice.weight(nodes + sides / 2)
            # The depth at which an outermost line advances, as `Thresholds.advance_of_outermost`.
            threshold = own + (after - own - np.sqrt(2 * bonds / stiffness)) / remainder
            holds = threshold <= pressed
        else:
            # Up to δ₀, but for rounding; a row that is longer by a few links changes nothing.
            holds = after <= pressed + scene.critical_separation * (1 + 1e-9)
    holds[:, -1] = False  # so that there is a first one that does not hold
    reach = ahead[[0, 1], holds.argmin(axis=1), None] + _LIMITS.spare
    outermost = (lowest + sides * np.minimum(reach, most))[:, 0].tolist()
    return int(outermost[0]), int(outermost[1])


def _running(parts: Array, start: int) -> Array:
    """Running sums (..., n + 1) of n parts: entry i less entry j is the sum of parts j to i - 1.

    0 at `start`, so that the sums stay small there, negative before it. In long double: between two
    contacts heights may be much larger than in contact.
    """
    before = parts[..., :start][..., ::-1]
    after = parts[..., start:]
    found = np.zeros((*parts.shape[:-1], parts.shape[-1] + 1), np.longdouble)
    np.cumsum(after, axis=-1, out=found[..., start + 1 :])
    backwards = np.cumsum(before, -1, np.longdouble)
    np.negative(backwards[..., ::-1], out=found[..., :start])
    return found
