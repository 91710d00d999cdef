"""The starts of spans alive at some node, for the recursion of shortest_path.py.

A stack: the older a start is, the higher above g (nearer to v = 0) the spans run for which it is
the best one. A few starts, the rule on rough profiles, are plain numbers; many are arrays.
"""

from __future__ import annotations

import copy
import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import span
from discretization.lattice.nodes import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
NOWHERE = -(1 << 62)  # node of the start "nothing precedes"
_MOST, _LEAST = 48, 16  # starts from which on arrays are faster, and below which they are not
_ROWS = ("place", "node", "value", "depth", "slope")


class Starts(NamedTuple):
    """Oldest first: place in the chain, node, V, h, largest admissible slope.

    The slope, p exp(μT), is K_T (v - λᵀh) for the drop v at the present node, T links from there.
    """

    place: Nodes
    node: Nodes
    value: Array
    depth: Array
    slope: Array


class Few:
    """Starts as lists, the rows of `Starts`; the first one is "nothing precedes"."""

    def __init__(self, lattice: Lattice, most: int) -> None:
        """most: links between the outermost nodes."""
        self.lattice, self.unit, self.most = lattice, span.unit(lattice), most
        self.rows: list[list[Any]] = [[-1], [NOWHERE], [0.0], [0.0], [math.inf]]

    def land(
        self, x: int, h: float, adhesion: float, growth: float, tie: float
    ) -> tuple[float, int]:
        """V and predecessor of node x; starts beaten there by an older one are dropped."""
        mu, unit = self.lattice.log_decay, self.unit
        index, nodes, values, depths, slopes = self.rows
        best = top = len(nodes) - 1
        least, won = math.inf, adhesion + tie
        for k, (node, value, depth) in enumerate(zip(nodes, values, depths, strict=True)):
            loss = -math.expm1(mu * (node - x))
            rise = h - depth + loss * depth
            pull, slope = unit / (loss * (2 - loss)) * rise, slopes[k] * growth
            if pull > slope:
                slopes[k] = slope
                continue
            slopes[k] = pull
            total = value + pull * rise - (won if k == top else 0.0)
            if total <= least:
                best, least = k, total
        if best < top:
            for row in self.rows:
                del row[best + 1 :]
        return least + (tie if best == top else 0.0), index[best]

    def push(self, j: int, x: int, h: float, value: float) -> None:
        """Make the node landed on a start; if h = 0 no span can pass it and it is the only one."""
        for row, entry in zip(self.rows, (j, x, value, h, math.inf), strict=True):
            if not h:
                row.clear()
            row.append(entry)

    def prune(self, x: int) -> None:
        """Drop starts without an admissible span, and those beaten at v = 0 by a newer one."""
        mu, unit = self.lattice.log_decay, self.unit
        least, kept, oldest = math.inf, [], 0
        _, nodes, values, depths, slopes = self.rows
        for k in range(len(nodes) - 1, -1, -1):
            loss = -math.expm1(mu * (nodes[k] - x))
            tail = depths[k] * (1 - loss)
            pull = unit / (loss * (2 - loss)) * tail
            if slopes[k] >= -pull:
                kept.append(k)
                total = values[k] + pull * tail
                if total < least:
                    least, oldest = total, len(kept)
        if oldest < len(nodes):
            kept = kept[:oldest][::-1]
            self.rows = [[row[k] for k in kept] for row in self.rows]

    def fork(self) -> Few | Many:
        """A copy."""
        twin = copy.copy(self)
        twin.rows = [row.copy() for row in self.rows]
        return twin

    def fitting(self) -> Few | Many:
        """The same starts, as arrays if they have become many."""
        return Many(self) if len(self.rows[0]) > _MOST else self

    @functools.cached_property
    def table(self) -> Array:
        """1 - λᵀ and K_T (2, T), T = ∞ the last."""
        longest = min(self.most, math.ceil(span.FAR / self.lattice.log_decay))
        links = np.append(np.arange(longest + 1.0), math.inf)
        loss = -np.expm1(-self.lattice.log_decay * links)
        return np.stack([loss, span.stiffness(self.lattice, links)])

    @property
    def starts(self) -> Starts:
        """The starts alive as arrays."""
        return Starts(*map(np.array, self.rows))


class Many:
    """Starts as arrays with room for more."""

    def __init__(self, few: Few) -> None:
        self.few, self.table = few, few.table
        self.place, self.node, self.value, self.depth, self.slope = few.starts
        self.live = slice(0, self.node.size)

    def land(
        self, x: int, h: float, adhesion: float, growth: float, tie: float
    ) -> tuple[float, int]:
        """V and predecessor of node x; starts beaten there by an older one are dropped."""
        now = self.live
        depth, slope = self.depth[now], self.slope[now]
        loss, stiffness = self.table.take(x - self.node[now], axis=1, mode="clip")
        rise = loss * depth
        rise -= depth - h
        stiffness *= rise
        slope *= growth
        total = self.value[now] + stiffness * rise
        total[stiffness > slope] = math.inf
        total[-1] -= adhesion + tie
        np.minimum(slope, stiffness, out=slope)
        best = total.size - 1 - int(total[::-1].argmin())
        value = float(total[best]) + (tie if best == total.size - 1 else 0.0)
        self.live = slice(now.start, now.start + best + 1)
        return value, int(self.place[now.start + best])

    def push(self, j: int, x: int, h: float, value: float) -> None:
        """Make the node landed on a start; if h = 0 no span can pass it and it is the only one."""
        top = self.live.stop
        if top == self.node.size:
            for name in _ROWS:
                row = getattr(self, name)
                setattr(self, name, np.concatenate([row, np.empty_like(row)]))
        self.place[top], self.node[top], self.depth[top] = j, x, h
        self.value[top], self.slope[top] = value, math.inf
        self.live = slice(self.live.start if h else top, top + 1)

    def prune(self, x: int) -> None:
        """Drop starts without an admissible span, and those beaten at v = 0 by a newer one."""
        loss, stiffness = self.table.take(x - self.node[self.live], axis=1, mode="clip")
        depth = self.depth[self.live]
        tail = depth - loss * depth
        admissible = self.slope[self.live] >= -stiffness * tail
        total = np.where(admissible, self.value[self.live] + stiffness * tail * tail, math.inf)
        admissible[: int((total <= total.min()).nonzero()[0][-1])] = False
        kept = self.live.start + np.flatnonzero(admissible)
        for name in _ROWS:
            row = getattr(self, name)
            row[: kept.size] = row[kept]
        self.live = slice(0, kept.size)

    def fork(self) -> Few | Many:
        """A copy."""
        twin = copy.copy(self)
        for name in _ROWS:
            setattr(twin, name, getattr(self, name).copy())
        return twin

    def fitting(self) -> Few | Many:
        """The same starts, as lists if they have become few."""
        if self.live.stop - self.live.start > _LEAST:
            return self
        few = copy.copy(self.few)
        few.rows = [row.tolist() for row in self.starts]
        return few

    @property
    def starts(self) -> Starts:
        """The starts alive."""
        return Starts(*(getattr(self, name)[self.live] for name in _ROWS))
