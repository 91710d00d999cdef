"""Contacts on nodes at a depth, and the surface between and beside them."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import fronts, line
from discretization.lattice.ground import Ground
from discretization.lattice.nodes import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class ContactSet:
    """Contacts between their first and last nodes, from left to right, at a depth.

    In contact u = g = d - f; the free surfaces are exact.
    """

    ground: Ground
    nodes: Sequence[tuple[int, int]]
    depth: float

    @property
    def lattice(self) -> Lattice:
        """The lattice."""
        return self.ground.lattice

    @property
    def first(self) -> int:
        """First node in contact."""
        return self.nodes[0][0]

    @property
    def last(self) -> int:
        """Last node in contact."""
        return self.nodes[-1][1]

    @functools.cached_property
    def middle(self) -> int | None:
        """The lowest node, if a single contact and all around is mirrored about it; else None."""
        ground = self.ground
        if len(self.nodes) > 1 or ground.bonds is not None:
            return None
        axis = fronts.mirror_axis(ground.lattice, ground.indenter, self.first, self.last)
        return None if axis is None else (self.first + self.last) // 2

    @functools.cached_property
    def ends(self) -> tuple[Nodes, Array]:
        """First and last nodes (m, 2), and u there."""
        nodes = np.array(self.nodes, np.int64)
        return nodes, self.depth - self.ground.at(nodes.ravel().astype(float)).reshape(-1, 2)

    @functools.cached_property
    def outer(self) -> list[line.End]:
        """The outermost ends that differ, the right one first.

        That one alone of a mirrored contact, and of contacts that include the axis.
        """
        ground, room = self.ground, self.ground.where[:2]
        right = line.end_of(ground, self.depth, room, self.last, 1)
        if self.middle is not None or self.lattice.x(self.first) == self.lattice.axis:
            return [right]
        return [right, line.end_of(ground, self.depth, room, self.first, -1)]

    @functools.cached_property
    def scale(self) -> float:
        """δ: the largest of |d|, |u| at the lines and δ₀."""
        lift = math.sqrt(2 * max(self.ground.works) / self.lattice.k)
        return max(abs(self.depth), float(np.abs(self.ends[1]).max()), lift)

    def surface(self, first: int, g: Array) -> tuple[Array, Mask | None]:
        """u at nodes of these g, of which `first` is in front, and which are free; None: none is.

        Of nodes between the outermost lines.
        """
        if len(self.nodes) == 1:
            return g, None
        nodes, u_ends = self.ends
        at = np.arange(first, first + g.size)
        own = np.searchsorted(nodes[:, 0], at, side="right") - 1
        free = at > nodes[own, 1]
        if not free.any():
            return g, None
        left, at = own[free], at[free]
        lines, u = (nodes[left, 1], nodes[left + 1, 0]), g.copy()
        u[free] = self.lattice.free(*lines, u_ends[left, 1], u_ends[left + 1, 0], at)
        return u, free
