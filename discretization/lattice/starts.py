"""The starts of spans at some node, for the recursion of shortest_path.py.

In z = λ⁻²ˣ and y = v λ⁻ˣ spans are straight lines, and from start i to the point (z, y) the cost is

    E_i(z, y) = V_i + t sinh μ (y - y_i)²/(z - z_i).

Nodes, (z, y) with v = h, may lie on these lines or above. The starts are a stack, the newest on
top. Whether node j, just reached, can be seen from start i, and which start is best for it, takes a
look at only a few of them. Below, a is older than b, and b older than c.

1. All starts newer than the best one for j are dropped: a span from them to a later node would
   cross one that costs less. Those left block what the dropped ones did: if c did block the line
   from a to a later point, so does j or the best start b that drops c, as the line from b to j runs
   below c. So i sees j iff its line there has at least the slope, at j, of those from newer starts.
2. Where b does not block a, E_a - E_b grows with y, by 2 t sinh μ times what the slopes differ. So
   a is better than b below some y only,

       y_ab(z) = y_b + s (z - z_b) - √(D (z - z_a)(z - z_b)/(t sinh μ (z_b - z_a))),

   s the slope from a to b, D = E_a(z_b, y_b) - V_b, 0 if negative. Thus b is the best of the three
   nowhere, or between y_ab < y_bc. If nowhere at z then nowhere later: where it is, it is along its
   whole span, since a detour costs more. For y >= 0 only: b is lost, too, once y_bc < 0.
3. The stack is linked into a chain at a node ahead, the horizon: only starts best of all somewhere
   there, and so at any node before. Coming down the stack, let b and a be neighbours in the chain,
   b seen, and E_a > E_b or a blocked by b. Then y > y_ab, and all older starts lose to b: those in
   the chain have their y between two bounds below y_ab; one that is not, and were better than b and
   all of them, would still be so at the horizon for some y.

So a few starts are looked at for a node. At the horizon starts that are lost are dropped, and the
chain is linked anew up to a horizon some part of their number ahead: a few steps per node.
"""

from __future__ import annotations

import copy
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import span
from discretization.lattice.nodes import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
NOWHERE = -(1 << 62)  # node of the start "nothing precedes"
_AHEAD = 8  # nodes to the next horizon, at least


class Start(NamedTuple):
    """Place in the chain of nodes, node, V, h; how it is linked.

    before: where in the stack the next older one of the chain is, -1: none; slope: t sinh μ times
    that of the line from this start to y_ab at the horizon, a the one before, in units with z = 1.
    """

    place: int
    node: int
    value: float
    depth: float
    before: int
    slope: float


class Ends(NamedTuple):
    """Starts as arrays, oldest first; slope: the largest K_T (v - λᵀh) that sees v at a node."""

    node: Array
    value: Array
    depth: Array
    slope: Array


class Starts:
    """The stack; the first start is "nothing precedes"."""

    def __init__(self, lattice: Lattice) -> None:
        self.mu, self.unit, self.horizon = lattice.log_decay, span.unit(lattice), -math.inf
        self.stack: list[Start] = []
        self._link(-1, NOWHERE, 0.0, 0.0)

    def land(self, x: int, h: float, adhesion: float, tie: float) -> tuple[float, int]:
        """V and predecessor of node x; newer starts than the best one are dropped."""
        if x >= self.horizon:
            self._look_ahead(x)
        top = len(self.stack) - 1
        best, least = self._best(x, h, adhesion + tie)
        del self.stack[best + 1 :]
        return least + (tie if best == top else 0.0), self.stack[best][0]

    def push(self, j: int, x: int, h: float, value: float) -> None:
        """Make the node landed on a start; if h = 0 no span can pass it and it is the only one."""
        if not h:
            self.stack.clear()
        self._link(j, x, value, h)

    def fork(self) -> Starts:
        """A copy."""
        twin = copy.copy(self)
        twin.stack = self.stack.copy()
        return twin

    def ends(self, x: int, h: float) -> Ends:
        """The starts of spans over node x."""
        n, (_, node, value, depth, _, _) = len(self.stack), zip(*self.stack, strict=True)
        nodes, depths, slope = np.array([*node, x], float), np.array([*depth, h]), np.empty(n)
        for k in range(n):
            loss = -np.expm1(self.mu * (nodes[k] - nodes[k + 1 :]))
            pull = self.unit / (loss * (2 - loss)) * (depths[k + 1 :] - depths[k] + loss * depths[k])
            slope[k] = (pull * np.exp(np.minimum(self.mu * (x - nodes[k + 1 :]), span.FAR))).min()
        return Ends(nodes[:-1], np.array(value), depths[:-1], slope)

    def last(self, tie: float) -> tuple[int, float]:
        """Place and V of the last contact node, with a tail beyond it that no other one blocks."""
        place, node, value, depth, _, _ = map(np.array, zip(*self.stack, strict=True))
        with np.errstate(divide="ignore"):  # h = 0
            y = np.log(depth) + self.mu * (node - float(node[-1]))
        lowest = np.minimum.accumulate(np.append(math.inf, y[:0:-1]))[::-1]
        total = np.where(y <= lowest, value, math.inf)
        best = int((total <= total.min() + tie).nonzero()[0][-1])
        return int(place[best]), float(total[best])

    def _span(self, start: Start, x: int, h: float) -> tuple[float, float, float]:
        """1 - λᵀ; K_T (h - λᵀ h_i), t sinh μ times the slope at node x if z = 1 there; E_i."""
        _, node, value, depth, _, _ = start
        loss = -math.expm1(self.mu * (node - x))
        rise = h - depth + loss * depth
        pull = self.unit / (loss * (2 - loss)) * rise
        return loss, pull, value + pull * rise

    def _best(self, x: int, h: float, won: float) -> tuple[int, float]:
        """Where the best start is, of equal ones the newest, and its E; `won`: by the newest."""
        k = best = top = linked = len(self.stack) - 1
        least, bound, slope, steepest = math.inf, math.inf, -math.inf, -math.inf
        while k >= 0:
            start = self.stack[k]
            _, pull, total = self._span(start, x, h)
            seen = pull >= steepest
            if k == linked:
                if total > bound or pull < slope:
                    break
                linked = start[4]
                bound, slope = (total, pull) if seen else (math.inf, -math.inf)
            if seen:
                steepest = pull
                if k == top:
                    total -= won
                if total < least:
                    best, least = k, total
            k -= 1
        return best, least

    def _link(self, j: int, x: int, value: float, h: float) -> None:
        """Put a start on the stack, linked to the newest older one that it leaves in the chain."""
        k, slope = len(self.stack) - 1, -math.inf
        ahead = math.expm1(min(2 * self.mu * (self.horizon - x), span.FAR))
        while k >= 0:
            start = self.stack[k]
            loss, pull, total = self._span(start, x, h)
            whole = loss * (2 - loss)
            bend = math.sqrt(max(total - value, 0.0) * self.unit / whole)
            ratio = math.sqrt(1 + whole / ahead)
            if start[5] < (1 - loss) * (pull - bend / ratio):
                slope = pull - bend * ratio
                break
            k = start[4]
        self.stack.append(Start(j, x, value, h, k, slope))

    def _look_ahead(self, x: int) -> None:
        """Drop the starts that are lost at node x, and link the others up to the next horizon."""
        self._relink(self.stack, x)
        k, kept = len(self.stack) - 1, []
        oldest, _ = self._best(x, 0.0, 0.0)
        while k >= oldest:
            kept.append(self.stack[k])
            k = self.stack[k][4]
        self._relink(kept[::-1], x + _AHEAD + len(kept) // 2)

    def _relink(self, starts: list[Start], horizon: int) -> None:
        self.stack, self.horizon = [], horizon
        for place, node, value, depth, _, _ in starts:
            self._link(place, node, value, depth)
