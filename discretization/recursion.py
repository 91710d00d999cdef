"""The shortest path over contact nodes, one node after the other.

With the quantities of shortest_path.py: V_j = min_i V_i + K_T (h_j - λᵀh_i)² - wΔx·links over the
starts i of admissible spans. The starts alive are a stack: the older one is, the higher above g
(nearer to v = 0) the spans run for which it is the best start.
"""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization import span
from discretization.lattice import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_TIE = 1e-12  # of wΔx: what more contact may cost
_FAR = 60.0  # decay lengths after which the ends of a span are independent
_PRUNE = 8  # steps between two removals of starts that lost at v = 0
NOWHERE = -(1 << 62)  # node of the start "nothing precedes"


class Chain(NamedTuple):
    """Nodes where contact may pay, their depth h, links of certain contact to the one before."""

    node: Nodes
    depth: Array
    links: Array

    def reversed(self) -> Chain:
        links = np.concatenate([self.links[:1], self.links[:0:-1]])
        return Chain(-self.node[::-1], self.depth[::-1], links)


class Starts(NamedTuple):
    """Starts of spans alive at some node, oldest first: node, V, h, largest admissible slope.

    The slope, p exp(μT), is K_T (v - λᵀh) for the drop v at that node, T links from the start.
    """

    node: Nodes
    value: Array
    depth: Array
    slope: Array


class Paths(NamedTuple):
    """V_j and predecessor (-1: none) of each node of the chain, the last contact and its V.

    reached: the stack at each of the stops, just after landing there.
    """

    value: Array
    before: Nodes
    last: int
    least: float
    reached: dict[int, Stack]


def shortest(lattice: Lattice, chain: Chain, stops: Mapping[int, int] | None = None) -> Paths:
    """The recursion of statement 2, node by node. stops: where the stack is kept, and its room."""
    n, tie, stops = chain.node.size, _TIE * lattice.w * lattice.spacing, stops or {}
    stack, reached = Stack(lattice, chain), {}
    value, before = np.empty(n), np.empty(n, np.int64)
    for j, (x, h, links, growth) in enumerate(_steps(lattice, chain)):
        adhesion = lattice.w * lattice.spacing * links
        value[j], before[j] = stack.land(x, h, adhesion, growth, tie)
        if j in stops:
            reached[j] = stack.fork(stops[j])
        if j % _PRUNE == 0:
            stack.prune(x)
        stack.push(j, x, h, value[j])
    last, least = stack.detach(tie)
    return Paths(value, before, last, least, reached)


def _steps(lattice: Lattice, chain: Chain) -> Iterator[tuple[int, float, float, float]]:
    """Node, depth, links to the node before and exp(μT) to it, for each node of the chain."""
    growth = np.minimum(lattice.log_decay * np.diff(chain.node, prepend=chain.node[:1]), _FAR)
    columns = (chain.node, chain.depth, chain.links, np.exp(growth))
    return zip(*(column.tolist() for column in columns), strict=True)


def without_adhesion(
    lattice: Lattice, chain: Chain, paths: Paths, first: int, core: int
) -> tuple[float, Starts]:
    """V of the core and the starts alive there if the links first..core do not adhere."""
    stack, value = paths.reached[first], float(paths.value[first])
    part = slice(first, core + 1)
    steps = list(_steps(lattice, Chain(chain.node[part], chain.depth[part], chain.links[part])))
    for j, ((x0, h0, _, _), (x, h, _, growth)) in enumerate(itertools.pairwise(steps)):
        if j % _PRUNE == 0:
            stack.prune(x0)
        stack.push(first, x0, h0, value)
        value, _ = stack.land(x, h, 0.0, growth, 0.0)
    now = stack.live
    return value, Starts(stack.node[now], stack.value[now], stack.depth[now], stack.slope[now])


class Stack:
    """The starts alive, oldest at the bottom; the first one is "nothing precedes"."""

    def __init__(self, lattice: Lattice, chain: Chain) -> None:
        n = chain.node.size + 1
        self.index, self.node = np.full(n, -1), np.full(n, NOWHERE)
        self.value, self.depth = np.zeros(n), np.zeros(n)
        self.slope = np.full(n, math.inf)
        self.live = slice(0, 1)
        longest = min(np.ptp(chain.node) + 1 if n > 1 else 1, math.ceil(_FAR / lattice.log_decay))
        links = np.append(np.arange(longest + 1.0), math.inf)
        self.table = np.stack(
            [-np.expm1(-lattice.log_decay * links), span.stiffness(lattice, links)]
        )

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
        return value, int(self.index[now.start + best])

    def push(self, j: int, x: int, h: float, value: float) -> None:
        """Make the node landed on a start; if h = 0 no span can pass it and it is the only one."""
        top = self.live.stop
        self.index[top], self.node[top], self.depth[top] = j, x, h
        self.value[top], self.slope[top] = value, math.inf
        self.live = slice(self.live.start if h else top, top + 1)

    def prune(self, x: int) -> None:
        """Drop starts without an admissible span, and those beaten at v = 0 by a newer one."""
        loss, stiffness = self.table.take(x - self.node[self.live], axis=1, mode="clip")
        depth, start = self.depth[self.live], self.live.start
        tail = depth - loss * depth
        admissible = self.slope[self.live] >= -stiffness * tail
        total = np.where(admissible, self.value[self.live] + stiffness * tail * tail, math.inf)
        admissible[: _newest(total)] = False
        kept = start + np.flatnonzero(admissible)
        self.live = slice(start, start + kept.size)
        for row in (self.index, self.node, self.value, self.depth, self.slope):
            row[self.live] = row[kept]

    def fork(self, room: int) -> Stack:
        """A copy that can take `room` more starts."""
        twin, now = copy.copy(self), self.live
        for name in ("index", "node", "value", "depth", "slope"):
            row = getattr(self, name)[now]
            setattr(twin, name, np.append(row, np.zeros(room, row.dtype)))
        twin.live = slice(0, now.stop - now.start)
        return twin

    def detach(self, tie: float) -> tuple[int, float]:
        """The last contact, with an admissible tail beyond it, and its V."""
        total = np.where(self.slope[self.live] >= 0, self.value[self.live], math.inf)
        best = _newest(total, tie)
        return int(self.index[self.live][best]), float(total[best])


def _newest(total: Array, tie: float = 0.0) -> int:
    return int((total <= total.min() + tie).nonzero()[0][-1])
