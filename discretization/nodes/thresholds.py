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

Conventions
-----------
Depths d and displacements u are positive down into the layer, heights f upwards; g = d - f. Nodes
are numbered from 0 in the row, from left to right; link i is between the nodes i and i + 1, and W
of it is its work of adhesion times its length or area and the factor of a pattern.

A line is named by its contact node and a `side`, -1 or 1, on which its free surface is; `other` is
the contact node at the other end of that surface, and None means that it has no other end: it is a
tail. Likewise `left` and `right` are the contact nodes at both ends of a surface, one of them None
for a tail.

Each threshold is one depth for both directions: a link closes, or a node touches, once d is as
large, and the same link opens, from the contact with this link back to the one without, once d is
less. ∞ stands for what never closes, -∞ for what never opens. A, B and S are those of
`Lattice.free_node_response`, C and G are `tie` and `ground` of `Lattice.surface_stiffnesses`, a and
b are `shares`; c is `Lattice.spring_stiffness`, t `Lattice.link_stiffness`, and `log_decay` μ, by
which a tail decays per link. `Spans` has these responses of gaps from tables, by their number of
links T: `far[T]` is B, `remainder[T]` 1 - A - B, `stiffness[T]` S, `tie[T]` and `ground[T]` C and
G, for T < `count`; `tail` is (B, 1 - A - B, S) of a tail, `decays` are λᵖ and λᵖ - 1 of its p-th
node, and `shares(T)` are a, b and 1 - a - b of all free nodes of a gap, for T <= LONGEST.
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

# Rounding of sums of some dozen terms, EPSILON = 2⁻⁵² being that of a number of size 1. A tenth or
# ten times of neither changes a result (`python -m tests.sensitivity
# discretization.nodes.thresholds`).
_ROUNDING = 256 * EPSILON  # of heights: a node that has touched stays in contact so much higher up
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
        The lattice's number of node 0, on which responses depend about an axis.
    """

    lattice: Lattice
    f: Array
    work: Array
    clear: bool = False
    first: int = 0

    def advance_of_outermost(self, node: Any, side: int) -> Any:
        """Depths at which outermost lines at nodes advance over the next link on a side.

        Parameters
        ----------
        node : int or ndarray of int
            Contact nodes at the lines.
        side : {1, -1}
            On which their tails are.

        Returns
        -------
        float or ndarray
            [length]; -∞ for the inner end of a contact around the axis, which never opens there.
        """
        if side < 0 and self.lattice.axis == 0:
            return np.full(np.shape(node), -math.inf)
        link = node - (side < 0)  # the one between node and node + side
        return self._advance(node, side, self.work[link])

    def _advance(self, node: Any, side: int, work: Any, other: int | None = None) -> Any:
        """Depths at which lines at nodes, that face another one, advance at this cost.

        The first formula of the module.

        Parameters
        ----------
        node : int or ndarray of int
            Contact nodes at the lines.
        side : {1, -1}
            On which their free surfaces are.
        work : float or ndarray
            W of all links that close [energy/length]; 0: depths at which the next node touches.
        other : int or None
            Contact node that they face; None: none.

        Returns
        -------
        float or ndarray
            [length].
        """
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
        gap = np.sqrt(2 * work / stiffness)  # that the adhesion closes
        return own + (rise - gap) / remainder

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
        """Depths (n,) below which a node between two contact links opens; -∞ at both ends.

        Of all nodes 1 ... n - 2 of the row, as if each had contact nodes on both sides.
        """
        # There the force t (u₋ - 2u + u₊) - c u, which pulls the node off, is √(2 W S), S = c + 2t.
        f = self.f
        spring = self.lattice.spring_stiffness
        link = self.lattice.link_stiffness
        work = self.work[1:] + self.work[:-1]
        force = np.sqrt(2 * work * (spring + 2 * link))
        depth = f[1:-1] - (link * np.diff(f, 2) + force) / spring
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
        if distance == 2:  # no free node is left, and the last link closes, too
            work += self._works[link + side]
        spans = self.spans
        if distance >= spans.count:
            return float(self._advance(node, side, work, other))
        heights = self.heights
        own = heights[node]
        rise = heights[node + side] - own + spans.far[distance] * (own - heights[other])
        gap = math.sqrt(2 * work / spans.stiffness[distance])
        return own + (rise - gap) / spans.remainder[distance]

    def _advance_outwards(self, node: int, side: int) -> float:
        """`advance` of an outermost line; ∞ at the end of the row, beyond which there is no node.

        By plain numbers, but for rows that are convex or about an axis.
        """
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
        """Heights of the nodes as plain numbers, which are faster one by one than arrays."""
        return [*map(float, self.f.tolist())]

    @functools.cached_property
    def _works(self) -> list[float]:
        """Adhesion of the links as plain numbers."""
        return [*map(float, self.work.tolist())]

    @functools.cached_property
    def spans(self) -> Spans:
        """What free surfaces between two contacts do, by their number of links, from tables."""
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
            [length]; ∞ if they never do: in gaps of one or two links, and where closing both would
            not lower the energy at any depth.
        """
        if right - left < 3:
            return math.inf
        f = self.heights
        link = self.lattice.link_stiffness
        first = left + 1
        last = right - 1
        links_between = last - first  # those of the surface that is left
        if links_between < self.spans.count:
            tie = self.spans.tie[links_between]
            ground = self.spans.ground[links_between]
        else:
            tie, ground = map(float, self.lattice.surface_stiffnesses(links_between))
        # Both pulls at d = `level` instead of d = 0, so that no digits are lost.
        p = self.lattice.spring_stiffness + ground
        level = (f[left] + f[right]) / 2
        tied = tie * (f[first] - f[last])
        pull_first = p * (f[first] - level) + link * (f[first] - f[left]) + tied
        pull_last = p * (f[last] - level) + link * (f[last] - f[right]) - tied
        work = self._works[left] + self._works[last]
        if links_between == 1:  # its only link closes, too
            work += self._works[first]
        work -= (pull_first - pull_last) ** 2 / (4 * (p + link + 2 * tie))
        if work < 0:
            return math.inf
        return level + (pull_first + pull_last - 2 * math.sqrt((p + link) * work)) / (2 * p)

    # Kept as `Walk.rise`, which asks for surfaces again and again, keeps its changes.
    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def touches(self, left: int | None, right: int | None) -> tuple[float, int]:
        """Depth at which a free node between two contacts touches, and which node.

        Parameters
        ----------
        left, right : int or None
            Contact nodes at both ends; None: there is no contact on that side. Not both.

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
        if right - left <= LONGEST:  # shapes from the tables
            near, far, remainder = self.spans.shares(right - left)
            shape = near * self.heights[left] + far * self.heights[right]
            depths = (self.f[first:stop] - shape) / remainder
            best = int(depths.argmin())
            return float(depths[best]), first + best
        nodes = np.arange(first, stop)
        f = self.f[nodes]
        # A node higher than both contacts touches at no less than its height. So above the depth at
        # which the lowest node touches, and above both contacts, none is the first.
        remainder, shape = self._surface(left, right, nodes[f.argmin()])
        bound = max((f.min() - shape) / remainder, self.f[left], self.f[right])
        nodes = nodes[f <= bound]
        remainder, shape = self._surface(left, right, nodes)
        depths = (self.f[nodes] - shape) / remainder
        best = int(np.argmin(depths))
        return float(depths[best]), int(nodes[best])

    def _touches_outside(self, left: int | None, right: int | None) -> tuple[float, int]:
        """`touches` of a tail: of the nodes it reaches, and of the lowest beyond.

        Further out than the tables have it, the tail has decayed: a node touches at its height.
        """
        decays, less = self.spans.decays  # λᵖ and λᵖ - 1 of the p-th node from the contact
        if left is not None:
            node = left
            reach = min(self.f.size - 1 - left, self.spans.count - 1)
            f = self.f[left + 1 : left + 1 + reach]
            beyond = left + 1 + reach  # the first node that is not reached
            lowest = self._lowest_from[beyond]
        elif right is not None:
            node = right
            reach = min(right, self.spans.count - 1)
            f = self.f[right - reach : right][::-1]  # outwards, as on the other side
            beyond = right - reach  # the number of nodes that are not reached
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
        """1 - a - b and a f_left + b f_right at free nodes between two contacts, or in a tail.

        So that their gap u - g is f - (a f_left + b f_right) - (1 - a - b) d.
        """
        links_to_left: Any = math.inf
        links_to_right: Any = math.inf
        f_left = f_right = 0.0
        if left is not None:
            links_to_left = nodes - left
            f_left = self.f[left]
        if right is not None:
            links_to_right = right - nodes
            f_right = self.f[right]
        a, b, remainder = shares(self.lattice.log_decay, links_to_left, links_to_right)
        return remainder, a * f_left + b * f_right

    @functools.cached_property
    def delta0(self) -> float:
        """δ₀ of the link that adheres most [length]."""
        return math.sqrt(2 * float(self.work.max(initial=0.0)) / self.lattice.spring_stiffness)

    def clears(self, left: int | None, right: int | None, depth: float) -> bool:
        """Whether a free surface is nowhere in the indenter, but for rounding.

        Rounding of the depth at which a node touches is that of heights over 1 - a - b: most of all
        in a gap of two links, where it is 1 + 2t/c times that of heights.

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

        Where the node would touch if it were free, less the rounding of that depth, so that one
        that has just touched stays.

        Parameters
        ----------
        left, right : int or None
            Contact nodes at the other ends of the free surfaces beside it; None: there is none.
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
