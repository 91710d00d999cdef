"""The starts of spans at some node, for the recursion of shortest_path.py.

In z = λ⁻²ˣ and y = v λ⁻ˣ spans are straight lines, and from start i to the point (z, y) they cost

    E_i(z, y) = V_i + t sinh μ (y - y_i)²/(z - z_i)

unless a node between lies below the line: it blocks i. The starts are a stack, the newest on top;
when a node has been landed on, those newer than its best start are dropped. Below, a is older than
b, and b than c; a loses to b at a point where E_a >= E_b or where b blocks a.

1. Starts dropped so need not be asked whether they block. Let b be the best start of node j, seen
   from it, and c be dropped. If c blocks a at a later point then so does b, or else j: the line
   from b to j runs below c, that from a above c but below b, so it is above the former at j.
2. Where b does not block a, E_a - E_b grows with y: by 2 t sinh μ times what their slopes differ.
   So a loses to b from one y on, and not below it. It is

       y_ab(z) = y_b + s (z - z_b) - √(D (z - z_a)(z - z_b)/(t sinh μ (z_b - z_a))),

   s the slope from a to b, D = E_a(z_b, y_b) - V_b, or 0 if that is negative.
3. If y_ab <= y_bc at some z then at all before: b is the best of the three at a point between, so
   it is so along its whole span, as any detour by a or c costs more.
4. Start b is linked to an older one k if at a node ahead, the horizon, all starts older than k lose
   to it at y_kb. With 3 they do so at all nodes before. At a node seen from b where k loses to b,
   y >= y_kb, hence all that are older than k lose to k at y_kb and to b from there on: the search
   for the best start, from the top of the stack down, ends. This takes D >= 0: where another start
   blocks k from b, k may be better than b below y_kb and at it. To link, each bears M_b, from
   which on all older ones lose to it at the horizon: M_k <= y_kb is what k must fulfil, and M_b is
   the largest y_ib of those from k to b. Of starts between some i and the one it is linked to, all
   lose to b from M_i on if i does, that is if y_ib < M_i, and b does not block i there.
5. At a node where y_ab >= y_bc, and c is seen at y_bc, b is lost: with T_i the cost from i to any
   (z, y) by the taut string below all nodes, T_b >= min(T_a, T_c) for all y there, and so at all
   later z, whatever nodes are to come; and what only b blocks is no better than c where it would
   be. All starts older than the best one at y = 0 are lost as well, as no node lies below.
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
_FEW = 16  # starts that are all looked at
_AHEAD = 8  # nodes to the next horizon, and one more for two starts
_APART = 1e-200  # λᵀ of starts so far apart that their slopes cannot be compared
Start = tuple[int, int, float, float, int, float]
"""Place in the chain of nodes, node, V, h, what it is linked to in the stack (-1: nothing), M.

M is given by the slope of the line to it from this start, in units with z = 1 at the start.
"""


class Ends(NamedTuple):
    """Starts as arrays, oldest first; slope: the largest K_T (v - λᵀh) that sees v at a node."""

    node: Array
    value: Array
    depth: Array
    slope: Array


class Starts:
    """The stack; the first start is "nothing precedes"."""

    def __init__(self, lattice: Lattice) -> None:
        self.lattice, self.mu, self.unit = lattice, lattice.log_decay, span.unit(lattice)
        self.horizon, self.stack = -math.inf, list[Start]()
        self._link(-1, NOWHERE, 0.0, 0.0)

    def land(self, x: int, h: float, adhesion: float, tie: float) -> tuple[float, int]:
        """V and predecessor of node x; newer starts than the best one are dropped."""
        if x >= self.horizon and len(self.stack) > _FEW:
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
            newer = nodes[k + 1 :]
            rise = depths[k + 1 :] - depths[k] - np.expm1(self.mu * (nodes[k] - newer)) * depths[k]
            pull = span.stiffness(self.lattice, newer - nodes[k]) * rise
            slope[k] = (pull * np.exp(np.minimum(self.mu * (x - newer), span.FAR))).min()
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

    def _span(self, start: Start, x: int, h: float) -> tuple[float, float, float, float]:
        """λᵀ, 1 - λ²ᵀ, E_i and the slope at node x, there in units with z = 1, less h.

        The slope of the line from z = 0 is h; what others have above it would be lost in rounding.
        """
        _, node, value, depth, _, _ = start
        decay, loss = math.exp(self.mu * (node - x)), -math.expm1(self.mu * (node - x))
        whole = loss * (1 + decay)
        above = decay * (h - depth - loss * h) / whole
        return decay, whole, value + self.unit * (h + above) * (h - depth + loss * depth), above

    def _best(self, x: int, h: float, won: float) -> tuple[int, float]:
        """Where the best start is, of equal ones the newest, and its E; `won`: by the newest."""
        k = best = top = len(self.stack) - 1
        linked = top if x <= self.horizon else -1
        least, bound, slope, steepest = math.inf, math.inf, -math.inf, -math.inf
        while k >= 0:
            start = self.stack[k]
            _, _, total, above = self._span(start, x, h)
            seen = above >= steepest
            if k == linked:
                if total > bound or above < slope:
                    break
                linked = start[4]
                bound, slope = (total, above) if seen else (math.inf, -math.inf)
            if seen:
                steepest = above
                if k == top:
                    total -= won
                if total < least:
                    best, least = k, total
            k -= 1
        return best, least

    def _ahead(self, x: int) -> float:
        """z at the horizon less that at node x, there in units with z = 1."""
        return math.expm1(min(2 * self.mu * (self.horizon - x), span.FAR))

    def _crossing(self, a: Start, x: int, value: float, h: float) -> tuple[float, ...]:
        """Slopes of the lines to y_ab at the horizon from a, and from b at node x, as in `Start`.

        Also λᵀ, the slope at b of the line from a to b, (z_b - z_a)/(z - z_b), and E_a - V_b at b.
        """
        decay, whole, total, above = self._span(a, x, h)
        bend = math.sqrt(max(total - value, 0.0) / (self.unit * whole))
        line, part = h + above, whole / self._ahead(x)
        ratio = math.sqrt(1 + part)
        ends = decay * (line - bend / ratio), line - bend * ratio
        return *ends, decay, line, part, total - value

    def _link(self, j: int, x: int, value: float, h: float) -> None:
        """Put a start on the stack, linked by statement 4; not at all beyond the horizon."""
        k, most = len(self.stack) - 1 if x < self.horizon else -1, -math.inf
        while k >= 0:
            near, far, decay, line, part, gain = self._crossing(self.stack[k], x, value, h)
            most, own = max(most, far), self.stack[k][5]
            if gain >= 0 and own <= near:
                break
            if gain >= 0 and decay > _APART and own <= decay * line:
                own /= decay
                most, k = max(most, own + (own - line) * part), self.stack[k][4]
            else:
                k -= 1
        self.stack.append((j, x, value, h, k, most))

    def _look_ahead(self, x: int) -> None:
        """Drop the starts that are lost at node x, and link the others up to the next horizon."""
        oldest, _ = self._best(x, 0.0, 0.0)
        self.horizon = x
        kept = self._not_lost(self.stack[oldest:])
        self.stack, self.horizon = [], x + _AHEAD + len(kept) // 2
        for place, node, value, depth, _, _ in kept:
            self._link(place, node, value, depth)

    def _not_lost(self, starts: list[Start]) -> list[Start]:
        """Those of the starts that are not lost at the horizon by statement 5."""
        kept: list[tuple[Start, float, float]] = []
        hull: list[Start] = []
        for a in reversed(starts):
            upper = math.inf
            while kept:
                b, sees, most = kept[-1]
                near, far, *_ = self._crossing(a, *b[1:4])
                if far < most:
                    upper = near if far <= sees else math.inf
                    break
                kept.pop()
            kept.append((a, self._sees(a, hull), upper))
        return [start for start, *_ in reversed(kept)]

    def _sees(self, start: Start, hull: list[Start]) -> float:
        """Largest slope of a line from a start that no newer one blocks, as in `Start`.

        hull: the lower convex hull of these, the oldest last; the start is added to it.
        """
        least, touched = math.inf, []
        while hull:
            decay, _, _, above = self._span(start, hull[-1][1], hull[-1][3])
            slope = decay * (hull[-1][3] + above)
            if slope >= least:
                break
            least, touched = slope, [hull.pop()]
        hull += [*touched, start]
        return least
