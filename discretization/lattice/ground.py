"""The nodes there are under an indenter, its heights there, and how they adhere."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import fronts
from discretization.lattice.nodes import Lattice
from energy import Indenter

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Ground:
    """The nodes there are, the profile over them, and how it adheres.

    works: of adhesion [energy/area] of contacts that are being closed, and of those being opened;
    f (n,): heights of all nodes of the region, where they are kept; bonds (n - 1,): length or area
    of each link there, times the pattern's factor on the work of adhesion.
    """

    lattice: Lattice
    indenter: Indenter
    where: fronts.Region
    works: tuple[float, float]
    f: Array | None = None
    bonds: Array | None = None

    @classmethod
    def of(cls, lattice: Lattice, indenter: Indenter, depth: float) -> Ground:
        """Where contact is possible; of one work of adhesion everywhere."""
        where = fronts.region(lattice, indenter, depth)
        return cls(lattice, indenter, where, (lattice.w, lattice.w))

    @functools.cached_property
    def lowest(self) -> float:
        """f at the node that touches first."""
        return float(self.heights(self.where.lowest, self.where.lowest)[0])

    def heights(self, start: int, stop: int) -> Array:
        """f at all nodes from one to another, upwards or downwards."""
        if self.f is not None:
            low = min(start, stop) - self.where.first
            own = self.f[low : low + abs(stop - start) + 1]
            return own if stop >= start else own[::-1]
        way = 1 if stop >= start else -1
        return fronts.heights(
            self.lattice, self.indenter, np.arange(start, stop + way, way, dtype=float)
        )

    def at(self, nodes: Array) -> Array:
        """f at some nodes."""
        if self.f is not None:
            return self.f[np.asarray(nodes, np.int64) - self.where.first]
        return fronts.heights(self.lattice, self.indenter, nodes)

    def work(self, node: int, other: int, *, opening: bool = False) -> float:
        """Adhesion of the links from one node to another."""
        first, last = sorted((node, other))
        if self.bonds is None:
            return self.works[opening] * self.lattice.cell * self.lattice.bound(first, last)
        own = self.bonds[first - self.where.first : last - self.where.first]
        return self.works[opening] * float(own.sum())
