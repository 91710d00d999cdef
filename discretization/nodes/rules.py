"""At which depths something happens to contacts on the lattice.

Between two contacts lies a free surface of T links, whose first free node is displaced by
A g_i + B g_j, its other nodes by a g_i + b g_j; outside are two tails, A = λ, B = 0. With c and t
the stiffness of a spring and of a link at the place, and C, G what the rest of the surface does to
the node beside a line (`Lattice.pair`), S = c + t + C + G that of this node, by the heights f,

    a line passes the next link, or closes the last two, or opens one, of adhesion W together, at
        d = f_i + (f_1 - f_i + B (f_i - f_j) - √(2W/S))/(1 - A - B);
    both lines of a span pass a link at once, next to a corner where neither would alone, where
        (2 p d - q - q')²/(p + t) + (q - q')²/(p + t + 2 C) = 4 W, p = c + G of both nodes,
        q = p f_1 + t (f_1 - f_i) + C (f_1 - f_1') the pull of one at d = 0, q' of the other;
    a free node touches at  d = (f_m - a f_i - b f_j)/(1 - a - b);
    a node inside a contact is torn open as a line that opens two links (T = 2);
    a lone node, which has no adhesion, lets go where it begins to be pulled.

v = u - g >= 0 falls with the depth and with every further contact node, and so does what a contact
node costs: the energy is submodular in v, in what is in contact and in -d (Topkis). So pressed,
contacts only grow, retracted, they only shrink. Where another node would be in the indenter once a
line has passed a link, both happen at once, where together they cost no energy.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import EPSILON
from discretization.nodes.lattice import Lattice, shares
from discretization.nodes.spans import LONGEST, Spans
from energy.arrays import Array, Indices, Nodes

_ROUNDING = 256 * EPSILON  # of heights: a node that has just touched stays
_TIE = 64 * EPSILON  # of depths at which something happens


@dataclass(frozen=True, eq=False)
class Rules:
    """The depths of changes for nodes of heights f (n,).

    work (n - 1,): adhesion [energy/length] of each link; clear: whether the surface beyond an
    outermost line can touch no node but the next; first: the lattice's number of the first node.
    """

    lattice: Lattice
    f: Array
    work: Array
    clear: bool = False
    first: int = 0

    def outwards(self, node: Any, side: int) -> Any:
        """Depths at which outermost lines at nodes pass the next link on a side."""
        if side < 0 and self.lattice.axis == 0:  # a contact around the axis is never opened there
            return np.full(np.shape(node), -math.inf)
        return self._passed(node, side, self.work[node - (side < 0)])

    def along(self, nodes: Indices, side: int, other: int | None) -> tuple[Array, Array]:
        """Depths (n,) at which a line at each of these nodes passes the next link, and touches it.

        other: the node of the line that it faces, three links away or more; None: there is none.
        """
        own = self.f[nodes]
        apart = math.inf if other is None else np.abs(other - nodes)
        far, remainder, stiffness = self.lattice.beside(self.first + nodes, side, apart)
        facing = own if other is None else self.f[other]
        touches = own + (self.f[nodes + side] - own + far * (own - facing)) / remainder
        adhesion = np.sqrt(2 * self.work[nodes - (side < 0)] / stiffness)
        return np.asarray(touches - adhesion / remainder), np.asarray(touches)

    def _passed(self, node: Any, side: int, work: Any, other: int | None = None) -> Any:
        """Where lines at nodes pass the next link, or the last two to another one, of this work."""
        own, apart = self.f[node], math.inf if other is None else abs(other - node)
        far, remainder, stiffness = self.lattice.beside(self.first + node, side, apart)
        rise = self.f[node + side] - own + far * (own - (own if other is None else self.f[other]))
        return own + (rise - np.sqrt(2 * work / stiffness)) / remainder

    def passed(self, nodes: Nodes, side: int, other: int | None) -> Array:
        """Depths at which a line at each of these nodes passes the next link (see `passes`).

        Of surfaces of at least three links.
        """
        works = self.work[nodes if side > 0 else nodes - 1]
        return np.asarray(self._passed(nodes, side, works, other))

    @functools.cached_property
    def torn(self) -> Array:
        """Depth below which each node between two contact links is torn open; -inf at the ends."""
        f, spring, link = self.f, self.lattice.spring, self.lattice.link
        stored = (self.work[1:] + self.work[:-1]) * (spring + 2 * link)
        depth = f[1:-1] - (link * np.diff(f, 2) + np.sqrt(2 * stored)) / spring
        return np.pad(depth, 1, constant_values=-math.inf)

    def passes(self, node: int, side: int, other: int | None) -> float:
        """Depth at which a line at `node` passes the link to the next node, on this side."""
        if other is None:
            return self._passes_outwards(node, side)
        apart = abs(other - node)
        first = node if side > 0 else node - 1
        work = self._works[first]
        if apart == 2:
            work += self._works[first + side]
        spans = self.spans
        if apart >= spans.count:
            return float(self._passed(node, side, work, other))
        heights = self.heights
        own = heights[node]
        rise = heights[node + side] - own + spans.far[apart] * (own - heights[other])
        adhesion = math.sqrt(2 * work / spans.stiffness[apart])
        return own + (rise - adhesion) / spans.remainder[apart]

    def _passes_outwards(self, node: int, side: int) -> float:
        """The same of an outermost line."""
        if not 0 <= node + side < self.f.size:
            return math.inf
        if self.clear or self.lattice.axis == 0:
            return float(self.outwards(node, side))
        _, remainder, stiffness = self.spans.tail
        own = self.heights[node]
        work = self._works[node if side > 0 else node - 1]
        rise = self.heights[node + side] - own
        return own + (rise - math.sqrt(2 * work / stiffness)) / remainder

    @functools.cached_property
    def heights(self) -> list[float]:
        """Heights of the nodes as plain numbers."""
        heights: list[float] = self.f.tolist()
        return heights

    @functools.cached_property
    def _works(self) -> list[float]:
        """Adhesion of the links as plain numbers."""
        works: list[float] = self.work.tolist()
        return works

    @functools.cached_property
    def spans(self) -> Spans:
        """What free surfaces of up to so many links do."""
        return Spans.of(self.lattice, self.f.size + 1)

    def passes_both(self, left: int, right: int) -> float:
        """Depth at which both lines of a span pass a link at once; inf if they never do."""
        if right - left < 3:
            return math.inf
        f, link = self.heights, self.lattice.link
        one, two = left + 1, right - 1
        if two - one < self.spans.count:
            tie = self.spans.tie[two - one]
            ground = self.spans.ground[two - one]
        else:
            tie, ground = map(float, self.lattice.pair(two - one))
        p = self.lattice.spring + ground
        level = (f[left] + f[right]) / 2
        apart = tie * (f[one] - f[two])
        pull = p * (f[one] - level) + link * (f[one] - f[left]) + apart
        other = p * (f[two] - level) + link * (f[two] - f[right]) - apart
        work = self._works[left] + self._works[two]
        if right - left == 3:
            work += self._works[one]
        work -= (pull - other) ** 2 / (4 * (p + link + 2 * tie))
        if work < 0:
            return math.inf
        return level + (pull + other - 2 * math.sqrt((p + link) * work)) / (2 * p)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def touches(self, left: int | None, right: int | None) -> tuple[float, int]:
        """Depth at which a free node between two contacts (None: none there) touches, and which."""
        first = 0 if left is None else left + 1
        stop = self.f.size if right is None else right
        if first >= stop or (self.clear and (left is None or right is None)):
            return math.inf, -1
        if left is None or right is None:
            return self._touches_outside(left, right)
        if right - left <= LONGEST:
            near, far, remainder = self.spans.shares(right - left)
            shape = near * self.heights[left] + far * self.heights[right]
            depths = (self.f[first:stop] - shape) / remainder
            best = int(depths.argmin())
            return float(depths[best]), first + best
        nodes = np.arange(first, stop)
        f, ends = self.f[nodes], (self.f[left], self.f[right])
        remainder, shape = self._surface(left, right, nodes[f.argmin()])
        # what is higher than both contacts touches at no less than its height
        nodes = nodes[f <= max((f.min() - shape) / remainder, *ends)]
        remainder, shape = self._surface(left, right, nodes)
        depths = (self.f[nodes] - shape) / remainder
        best = int(np.argmin(depths))
        return float(depths[best]), int(nodes[best])

    def _touches_outside(self, left: int | None, right: int | None) -> tuple[float, int]:
        """The same of a tail: of the nodes it reaches, and of the lowest beyond."""
        decays, less = self.spans.decays
        if left is not None:
            node, reach = left, min(self.f.size - 1 - left, self.spans.count - 1)
            f = self.f[left + 1 : left + 1 + reach]
            beyond = left + 1 + reach
            lowest = float(self._lowest_from[beyond])
        elif right is not None:
            node, reach = right, min(right, self.spans.count - 1)
            f = self.f[right - reach : right][::-1]
            beyond = right - reach
            lowest = float(self._lowest_before[beyond])
        depths = (f - decays[:reach] * self.heights[node]) / -less[:reach]
        best = int(depths.argmin())
        depth = float(depths[best])
        if lowest < depth:
            others = self.f[beyond:] if right is None else self.f[:beyond]
            offset = beyond if right is None else 0
            return lowest, offset + int(others.argmin())
        return depth, node + 1 + best if right is None else node - 1 - best

    @functools.cached_property
    def _lowest_from(self) -> Array:
        """The least height of all nodes from each one on; inf beyond the last."""
        return np.append(np.minimum.accumulate(self.f[::-1])[::-1], math.inf)

    @functools.cached_property
    def _lowest_before(self) -> Array:
        """The least height of all nodes before each one; inf before the first."""
        return np.append(math.inf, np.minimum.accumulate(self.f))

    def _surface(self, left: int | None, right: int | None, nodes: Any) -> tuple[Any, Any]:
        """1 - a - b and a f_i + b f_j at free nodes between two contacts."""
        p, f_left = (math.inf, 0.0) if left is None else (nodes - left, self.f[left])
        q, f_right = (math.inf, 0.0) if right is None else (right - nodes, self.f[right])
        near, far, remainder = shares(self.lattice.log_decay, p, q)
        return remainder, near * f_left + far * f_right

    @functools.cached_property
    def delta0(self) -> float:
        """δ₀, of the link that adheres most."""
        return math.sqrt(2 * float(self.work.max(initial=0.0)) / self.lattice.spring)

    def clears(self, left: int | None, right: int | None, depth: float) -> bool:
        """Whether the surface between two contact nodes (None: none there) clears the indenter.

        But for rounding, which is largest in the slopes of a span of two links.
        """
        touch, steep = self.touches(left, right)[0], 1 + 2 * self.lattice.link / self.lattice.spring
        tie = _TIE * (abs(touch) + abs(depth) + self.delta0) * steep
        return touch >= depth - tie

    def pulled(self, left: int | None, node: int, right: int | None) -> float:
        """Depth below which a lone node between two contacts (None: none there) is pulled.

        Where the node would touch, less its rounding, so that one that has just touched stays.
        """
        (remainder, shape), height = self._surface(left, right, node), self.f[node]
        return float((height - shape - _ROUNDING * (abs(height) + abs(shape))) / remainder)
