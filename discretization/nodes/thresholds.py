"""At which depths something happens to contacts on the lattice.

Between two contacts lies a free surface of T links, whose first free node is displaced by
A g_i + B g_j, its other nodes by a g_i + b g_j; outside are two tails, A = λ, B = 0. With c and t
the stiffness of a spring and of a link at the place, and C, G what the rest of the surface does to
the node beside a line (`Lattice.surface_stiffnesses`), S = c + t + C + G that of this node, by the
heights f,

    a line advances over the next link, or the last two, or opens one, of adhesion W together, at
        d = f_i + (f_1 - f_i + B (f_i - f_j) - √(2W/S))/(1 - A - B);
    both lines of a span advance at once, next to a corner where neither would alone, where
        (2 p d - q - q')²/(p + t) + (q - q')²/(p + t + 2 C) = 4 W, p = c + G of both nodes,
        q = p f_1 + t (f_1 - f_i) + C (f_1 - f_1') the pull of one at d = 0, q' of the other;
    a free node touches at  d = (f_m - a f_i - b f_j)/(1 - a - b);
    a node inside a contact opens as a line that opens two links (T = 2);
    a lone node, which has no adhesion, opens where it begins to be pulled.

v = u - g >= 0 falls with the depth and with every further contact node, and so does what a contact
node costs: the energy is submodular in v, in what is in contact and in -d (Topkis). So pressed,
contacts only grow, retracted, they only shrink. Where another node would be in the indenter once a
line has advanced, both happen at once, where together they cost no energy.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import EPSILON
from discretization.nodes.lattice import Lattice, shares
from discretization.nodes.spans import LONGEST, Spans
from energy.arrays import Array, Nodes

_ROUNDING = 256 * EPSILON  # of heights: by so much less deep a node that has touched stays
_TIE = 64 * EPSILON  # of depths at which something happens


@dataclass(frozen=True, eq=False)
class Thresholds:
    """The depths at which contacts of nodes change, for one work of adhesion.

    Nodes and links are counted from 0 in the row.

    Attributes
    ----------
    lattice : Lattice
    f : ndarray (n,)
        Heights of the nodes [length].
    work : ndarray (n - 1,)
        Adhesion of each link [energy/length].
    clear : bool
        Whether the surface beyond an outermost line can touch no node but the next.
    first : int
        The lattice's number of node 0.
    """

    lattice: Lattice
    f: Array
    work: Array
    clear: bool = False
    first: int = 0

    def advance_of_outermost(self, node: Any, side: int) -> Any:
        """Depths at which outermost lines at nodes advance over the next link on a side.

        -∞ for the inner end of a contact around the axis, which never opens there.
        """
        if side < 0 and self.lattice.axis == 0:
            return np.full(np.shape(node), -math.inf)
        return self._advance(node, side, self.work[node - (side < 0)])

    def _advance(self, node: Any, side: int, work: Any, other: int | None = None) -> Any:
        """Where lines at nodes, that face another one, advance over links of this work."""
        own = self.f[node]
        if other is None:
            distance: float = math.inf
            faced = own
        else:
            distance = abs(other - node)
            faced = self.f[other]
        far, remainder, stiffness = self.lattice.free_node_response(
            self.first + node, side, distance
        )
        rise = self.f[node + side] - own + far * (own - faced)
        return own + (rise - np.sqrt(2 * work / stiffness)) / remainder

    def advances(self, nodes: Nodes, side: int, other: int | None) -> Array:
        """Depths (n,) at which a line at each of these nodes advances over the next link.

        As `advance`, of surfaces of at least three links.

        Parameters
        ----------
        nodes : ndarray of int (n,)
            Contact nodes at the line.
        side : {1, -1}
            On which the links are.
        other : int or None
            Contact node at the line that it faces, three links away or more; None: there is none.

        Returns
        -------
        ndarray (n,)
            [length].
        """
        works = self.work[nodes if side > 0 else nodes - 1]
        return np.asarray(self._advance(nodes, side, works, other))

    def touches_next(self, nodes: Nodes, side: int, other: int | None) -> Array:
        """Depths at which the surface beside a line at each of these nodes touches the next node.

        Parameters
        ----------
        nodes : ndarray of int (n,)
            Contact nodes at the line.
        side : {1, -1}
            On which the surface is.
        other : int or None
            As of `advances`.

        Returns
        -------
        ndarray (n,)
            [length].
        """
        none = np.zeros(nodes.shape)
        return np.asarray(self._advance(nodes, side, none, other))

    @functools.cached_property
    def open(self) -> Array:
        """Depths (n,) below which a node between two contact links opens; -∞ at both ends."""
        f = self.f
        spring = self.lattice.spring_stiffness
        link = self.lattice.link_stiffness
        bound = (self.work[1:] + self.work[:-1]) * (spring + 2 * link)
        depth = f[1:-1] - (link * np.diff(f, 2) + np.sqrt(2 * bound)) / spring
        return np.pad(depth, 1, constant_values=-math.inf)

    def advance(self, node: int, side: int, other: int | None) -> float:
        """Depth at which one line advances over the link to the next node.

        If only two links are between it and the other line, over both.

        Parameters
        ----------
        node : int
            Contact node at the line.
        side : {1, -1}
            On which the link is.
        other : int or None
            Contact node at the line that it faces.

        Returns
        -------
        float
            [length].
        """
        if other is None:
            return self._advance_outwards(node, side)
        distance = abs(other - node)
        link = node if side > 0 else node - 1
        work = self._works[link]
        if distance == 2:
            work += self._works[link + side]
        spans = self.spans
        if distance >= spans.count:
            return float(self._advance(node, side, work, other))
        heights = self.heights
        own = heights[node]
        rise = heights[node + side] - own + spans.far[distance] * (own - heights[other])
        adhesion = math.sqrt(2 * work / spans.stiffness[distance])
        return own + (rise - adhesion) / spans.remainder[distance]

    def _advance_outwards(self, node: int, side: int) -> float:
        """The same of an outermost line."""
        if not 0 <= node + side < self.f.size:
            return math.inf
        if self.clear or self.lattice.axis == 0:
            return float(self.advance_of_outermost(node, side))
        _, remainder, stiffness = self.spans.tail
        own = self.heights[node]
        work = self._works[node if side > 0 else node - 1]
        rise = self.heights[node + side] - own
        return own + (rise - math.sqrt(2 * work / stiffness)) / remainder

    @functools.cached_property
    def heights(self) -> list[float]:
        """Heights of the nodes as plain numbers."""
        return [*map(float, self.f.tolist())]

    @functools.cached_property
    def _works(self) -> list[float]:
        """Adhesion of the links as plain numbers."""
        return [*map(float, self.work.tolist())]

    @functools.cached_property
    def spans(self) -> Spans:
        """The free surfaces between two contacts."""
        return Spans.of(self.lattice, self.f.size + 1)

    def advance_both(self, left: int, right: int) -> float:
        """Depth at which both lines of a gap advance at once.

        Parameters
        ----------
        left, right : int
            Contact nodes at the lines.

        Returns
        -------
        float
            [length]; ∞ if they never do.
        """
        if right - left < 3:
            return math.inf
        f = self.heights
        link = self.lattice.link_stiffness
        first = left + 1
        last = right - 1
        if last - first < self.spans.count:
            tie = self.spans.tie[last - first]
            ground = self.spans.ground[last - first]
        else:
            tie, ground = map(float, self.lattice.surface_stiffnesses(last - first))
        p = self.lattice.spring_stiffness + ground
        level = (f[left] + f[right]) / 2
        tied = tie * (f[first] - f[last])
        pull_first = p * (f[first] - level) + link * (f[first] - f[left]) + tied
        pull_last = p * (f[last] - level) + link * (f[last] - f[right]) - tied
        work = self._works[left] + self._works[last]
        if right - left == 3:
            work += self._works[first]
        work -= (pull_first - pull_last) ** 2 / (4 * (p + link + 2 * tie))
        if work < 0:
            return math.inf
        return level + (pull_first + pull_last - 2 * math.sqrt((p + link) * work)) / (2 * p)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def touches(self, left: int | None, right: int | None) -> tuple[float, int]:
        """Depth at which a free node between two contacts touches, and which node.

        Parameters
        ----------
        left, right : int or None
            Contact nodes at both ends; None: there is no contact on that side.

        Returns
        -------
        depth : float
            [length]; ∞ if none touches.
        node : int
            -1 if none touches.
        """
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
        f = self.f[nodes]
        remainder, shape = self._surface(left, right, nodes[f.argmin()])
        # What is higher than both contacts touches at no less than its height.
        bound = max((f.min() - shape) / remainder, self.f[left], self.f[right])
        nodes = nodes[f <= bound]
        remainder, shape = self._surface(left, right, nodes)
        depths = (self.f[nodes] - shape) / remainder
        best = int(np.argmin(depths))
        return float(depths[best]), int(nodes[best])

    def _touches_outside(self, left: int | None, right: int | None) -> tuple[float, int]:
        """The same of a tail: of the nodes it reaches, and of the lowest beyond."""
        decays, less = self.spans.decays
        if left is not None:
            node = left
            reach = min(self.f.size - 1 - left, self.spans.count - 1)
            f = self.f[left + 1 : left + 1 + reach]
            beyond = left + 1 + reach
            lowest = self._lowest_from[beyond]
        elif right is not None:
            node = right
            reach = min(right, self.spans.count - 1)
            f = self.f[right - reach : right][::-1]
            beyond = right - reach
            lowest = self._lowest_before[beyond]
        depths = (f - decays[:reach] * self.heights[node]) / -less[:reach]
        best = int(depths.argmin())
        depth = float(depths[best])
        if lowest < depth:
            others = self.f[beyond:] if right is None else self.f[:beyond]
            offset = beyond if right is None else 0
            return lowest, offset + int(others.argmin())
        return depth, node + 1 + best if right is None else node - 1 - best

    @functools.cached_property
    def _lowest_from(self) -> list[float]:
        """The least height of all nodes from each one on; inf beyond the last."""
        least = np.minimum.accumulate(self.f[::-1])[::-1]
        return [*least.tolist(), math.inf]

    @functools.cached_property
    def _lowest_before(self) -> list[float]:
        """The least height of all nodes before each one; inf before the first."""
        least = np.minimum.accumulate(self.f)
        return [math.inf, *least.tolist()]

    def _surface(self, left: int | None, right: int | None, nodes: Any) -> tuple[Any, Any]:
        """1 - a - b and a f_i + b f_j at free nodes between two contacts."""
        p: Any = math.inf
        q: Any = math.inf
        f_left = f_right = 0.0
        if left is not None:
            p = nodes - left
            f_left = self.f[left]
        if right is not None:
            q = right - nodes
            f_right = self.f[right]
        near, far, remainder = shares(self.lattice.log_decay, p, q)
        return remainder, near * f_left + far * f_right

    @functools.cached_property
    def delta0(self) -> float:
        """δ₀ of the link that adheres most [length]."""
        return math.sqrt(2 * float(self.work.max(initial=0.0)) / self.lattice.spring_stiffness)

    def clears(self, left: int | None, right: int | None, depth: float) -> bool:
        """Whether a free surface clears the indenter, but for rounding, which is largest in the
        slopes of a gap of two links.

        Parameters
        ----------
        left, right : int or None
            Contact nodes at its ends; None: there is none.
        depth : float
            [length].

        Returns
        -------
        bool
        """
        touch, _ = self.touches(left, right)
        steepness = 1 + 2 * self.lattice.link_stiffness / self.lattice.spring_stiffness
        tie = _TIE * (abs(touch) + abs(depth) + self.delta0) * steepness
        return touch >= depth - tie

    def pulled(self, left: int | None, node: int, right: int | None) -> float:
        """Depth below which a lone node between two contacts (None: none there) is pulled.

        Where the node would touch, less its rounding, so that one that has just touched stays.

        Parameters
        ----------
        left, right : int or None
            Contact nodes beyond the free surfaces beside it; None: there is none.
        node : int
            The lone node.

        Returns
        -------
        float
            [length].
        """
        remainder, shape = self._surface(left, right, node)
        height = self.f[node]
        rounding = _ROUNDING * (abs(height) + abs(shape))
        return float((height - shape - rounding) / remainder)
