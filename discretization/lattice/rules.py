"""At which depths something happens to contacts on the lattice.

Between two contacts lies a free span of T links, whose first free node is displaced by
A g_i + B g_j (`shares`); outside are two tails, A = λ, B = 0. By the heights f of the nodes
involved,

    a line passes the next link (n = 1), or closes the last two (n = 2), or opens one, at
        d = f_i + (f_1 - f_i + B (f_i - f_j) - G)/(1 - A - B),   G = √(2 n wΔx/c),
        c = kΔx + t + t(1 - A(T-1)), the stiffness of the first free node;
    both lines of a span pass a link at once (n = 2; n = 3 closes it), next to a corner where
        neither would alone, at  d = ((h + h')/2 - √((n wΔx - (s+o)(h - h')²/4)/(s-o)))/(1 - A - B),
        h = f_1 - A f_i - B f_j, s and -o the stiffness of both nodes and between them;
    a free node touches at  d = (f_m - a f_i - b f_j)/(1 - a - b), a and b the shape of the span;
    a node inside a contact is torn open as a line that opens two links (n = 2, T = 2);
    a lone node, which has no adhesion, lets go where it begins to be pulled.

The energies compared are those of surfaces that stay above the indenter: where another node would
be penetrated once a line has passed, it is held, too, and the line passes at a larger depth. With
such energies v = u - g >= 0 falls with the depth and with every further contact node, and so does
what a contact node costs: the energy is submodular in v, in what is in contact and in -d (Topkis).
So pressed, contacts only grow, retracted, they only shrink, and neither order nor steps matter.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.nodes import Lattice
from discretization.lattice.shares import shares
from discretization.rounding import EPSILON

Array = NDArray[np.float64]
Nodes = NDArray[np.int_]
_ROUNDING = 256 * EPSILON  # of heights: a node that has just touched stays
_LEAST = 1e-10  # of the adhesion of one link: rounding of U, relative to that
TIE = 64 * EPSILON  # of depths at which something happens


def ordered(side: int, node: int, other: int | None) -> tuple[int | None, int | None]:
    """Left and right contact node of the free part on this side of a node."""
    return (node, other) if side > 0 else (other, node)


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

    @functools.cached_property
    def _heights(self) -> list[float]:
        return self.f.tolist()

    @functools.cached_property
    def bonds(self) -> Array:
        """Adhesion (n - 1,) of each link along the indenter."""
        return np.asarray(self.work * self.lattice.arc(np.diff(self.f)))

    @functools.cached_property
    def _bonds(self) -> list[float]:
        return self.bonds.tolist()

    @functools.cached_property
    def outwards(self) -> dict[int, Array]:
        """Depths at which an outermost line passes each link, in the order it meets them.

        By side: +1 right, -1 left. Node i is the i-th of them, or the i-th from the end; beyond the
        last node there is no link to pass (n,).
        """
        found = {}
        for side in (1, -1):
            f, work = self.f[::side], self.work[::side]
            place = self.lattice.at(self.nodes[::side][:-1], side)
            found[side] = np.append(place.rest_depth(f[:-1], f[1:], work), math.inf)
        return found

    @property
    def nodes(self) -> range:
        """The lattice's numbers of the nodes."""
        return range(self.first, self.first + self.f.size)

    @functools.cached_property
    def meets(self) -> dict[int, Array]:
        """Depths at which the surface beyond an outermost line touches the next node (n - 1,)."""
        found = {}
        for side in (1, -1):
            f, place = self.f[::side], self.lattice.at(self.nodes[::side][:-1], side)
            found[side] = place.rest_depth(f[:-1], f[1:], 0.0)
        return found

    @functools.cached_property
    def torn(self) -> Array:
        """Depth below which each node between two contact links is torn open; -inf at the ends."""
        lat, f = self.lattice, self.f
        if f.size < 3 or self.clear:  # a convex profile is not torn open inside: its lines recede
            return np.full(f.size, -math.inf)
        near, _, both = self.shares(2)
        both_links = self.work[1:] + self.work[:-1]
        gap = np.sqrt(2 * both_links / (lat.spring + 2 * lat.link))
        depth = (f[1:-1] - near * (f[:-2] + f[2:]) - gap) / both
        return np.pad(depth, 1, constant_values=-math.inf)

    @functools.cached_property
    def most_torn(self) -> float:
        """Depth above which no node is torn open."""
        return float(self.torn.max())

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def shares(self, links: int | None) -> tuple[float, float, float]:
        """A, B and 1 - A - B."""
        beyond = math.inf if links is None else links - 1.0
        near, far, both = shares(self.lattice.log_decay, np.array(1.0), np.array(beyond))
        return float(near), float(far), float(both)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def passes(self, node: int, side: int, other: int | None) -> float:
        """Depth at which a line at `node` passes the link to the next node, on this side."""
        if other is None:
            return float(self.outwards[side][node if side > 0 else self.f.size - 1 - node])
        after, links, f = node + side, abs(other - node), self._heights
        far, both, stiffness = self.beside(node, side, other)
        work = self.adhesion(node, other if links == 2 else after)
        rise = f[after] - f[node] + far * (f[node] - f[other])
        return f[node] + (rise - math.sqrt(2 * work / stiffness)) / both

    def beside(self, node: int, side: int, other: int) -> tuple[float, float, float]:
        """B, 1 - A - B and stiffness of the first free node beside one end of a span."""
        lat, links = self.lattice, abs(other - node)
        _, far, both = self.shares(links)
        return far, both, lat.spring + lat.link + lat.link * (1 - self.shares(links - 1)[0])

    def stored(self, left: int | None, right: int | None, depth: float) -> float:
        """Energy of the surface between two contact nodes (None: none there), free or one link."""
        link, f = self.lattice.link, self.f
        if left is not None and right is not None and right - left == 1:
            return link / 2 * float(f[right] - f[left]) ** 2
        own = 0.0
        for node, other in ((left, right), (right, left)):
            if node is None:
                continue
            _, far, both = self.shares(None if other is None else abs(other - node))
            g, apart = depth - float(f[node]), 0.0 if other is None else float(f[other] - f[node])
            own += g * link * (both * g + far * apart)
        return own / 2

    def adhesion(self, one: int, other: int) -> float:
        """Adhesion of the links between two nodes."""
        return sum(self._bonds[min(one, other) : max(one, other)])

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def passes_both(self, left: int, right: int) -> float:
        """Depth at which both lines of a span pass a link at once; inf if they never do."""
        lat, links = self.lattice, right - left
        if links < 3:
            return math.inf
        near, far, both = self.shares(links)
        inner = self.shares(links - 2)
        own, other = lat.spring + lat.link * (2 - inner[0]), lat.link * inner[1]
        f, g, f_next, g_next = (self._heights[i] for i in (left, right, left + 1, right - 1))
        one, two = f_next - near * f - far * g, g_next - near * g - far * f
        work = (
            self._bonds[left]
            + self._bonds[right - 1]
            + (self._bonds[left + 1] if links == 3 else 0)
        )
        work -= (own + other) * (one - two) ** 2 / 4
        if work < 0:
            return math.inf
        return ((one + two) / 2 - math.sqrt(work / (own - other))) / both

    def advance_both(self, left: int, right: int) -> float:
        """The same if no other node is penetrated then, else inf."""
        depth = self.passes_both(left, right)
        clear = right - left <= 3 or (depth < math.inf and self.clears(left + 1, right - 1, depth))
        return depth if clear else math.inf

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def touches(self, left: int | None, right: int | None) -> tuple[float, int]:
        """Depth at which a free node between two contacts (None: none there) touches, and which."""
        if self.clear and (left is None or right is None):
            return math.inf, -1
        lo, hi = -1 if left is None else left, self.f.size if right is None else right
        if hi - lo < 2:
            return math.inf, -1
        return self._first(left, right, lo + 1, hi)

    def _first(
        self, left: int | None, right: int | None, start: int, stop: int
    ) -> tuple[float, int]:
        """The same of the free nodes start..stop-1, at least one."""
        depths, shares = self.f[start:stop].copy(), self._free(left, right)
        for end, share in zip((left, right), shares, strict=False):
            if end is not None:
                depths -= share * self.f[end]
        depths /= shares[2]
        best = int(np.argmin(depths))
        return float(depths[best]), start + best

    @functools.cached_property
    def _decays(self) -> tuple[Array, Array, Array]:
        """λⁿ, λⁿ - 1 and λ²ⁿ - 1 for n = 0, 1, ..."""
        n = -self.lattice.log_decay * np.arange(self.f.size + 1.0)
        return np.exp(n), np.expm1(n), np.expm1(2 * n)

    def _free(self, left: int | None, right: int | None) -> tuple[Array, Array, Array]:
        """`shares` of all free nodes between two contacts (None: none there), looked up."""
        decay, once, twice = self._decays
        if left is None or right is None:
            tail = slice(right, 0, -1) if right is not None else slice(1, self.f.size - (left or 0))
            return decay[tail], decay[tail], -once[tail]
        links = right - left
        p, q = slice(1, links), slice(links - 1, 0, -1)
        near, far = decay[p] * twice[q], decay[q] * twice[p]
        near /= twice[links]
        far /= twice[links]
        rest = once[p] * once[q]
        rest /= 1 + decay[links]
        return near, far, rest

    def _surface(self, left: int | None, right: int | None, m: Nodes) -> tuple[Array, Array]:
        """1 - a - b and a f_i + b f_j at free nodes m between two contacts (None: none there)."""
        f_left, f_right = (0.0 if end is None else self.f[end] for end in (left, right))
        p: Array = m - np.float64(-math.inf if left is None else left)
        q: Array = np.float64(math.inf if right is None else right) - m
        a, b, rest = shares(self.lattice.log_decay, p, q)
        return rest, a * f_left + b * f_right

    @functools.lru_cache(maxsize=1 << 12)  # noqa: B019
    def tears(self, first: int, last: int) -> tuple[float, int]:
        """Depth below which a node inside a contact is torn open, and which."""
        best = first + 1 + int(np.argmax(self.torn[first + 1 : last]))
        return float(self.torn[best]), best

    @property
    def least(self) -> float:
        """Energy [energy/length] below which a change is no jump: rounding of U.

        Without adhesion the energy is convex, and nothing is ever released.
        """
        return _LEAST * self._strongest or math.inf

    def first_touch(self, node: int, side: int) -> float:
        """Depth at which the surface beyond an outermost line at `node` touches another node."""
        return self.touches(*ordered(side, node, None))[0]

    def tie(self, one: float, other: float) -> float:
        """What rounding makes of the difference of two depths at which something happens.

        The largest difference quotient of heights that enters them is that of a span of two links.
        """
        return TIE * (abs(one) + abs(other) + self.lift) / self.least_rest

    @functools.cached_property
    def lift(self) -> float:
        """δ₀, of the link that adheres most."""
        return math.sqrt(2 * self._strongest / (self.lattice.k * self.lattice.spacing))

    @functools.cached_property
    def least_rest(self) -> float:
        """1 - A - B of a span of two links."""
        return self.shares(2)[2]

    @functools.cached_property
    def _strongest(self) -> float:
        return float(self.work.max(initial=0.0))

    def recede_both(self, left: int, right: int) -> float:
        """Depth at which both lines of a span open a link at once, none of the nodes pressed."""
        ends = left - 1, right + 1
        return min(self.passes_both(*ends), self.touches(*ends)[0])

    def clears(self, left: int | None, right: int | None, depth: float) -> bool:
        """Whether the surface between two contact nodes (None: none there) clears the indenter."""
        touch = self.touches(left, right)[0]
        return touch == math.inf or touch >= depth - self.tie(touch, depth)

    def pulled(self, left: int | None, node: int, right: int | None) -> float:
        """Depth below which a lone node between two contacts (None: none there) is pulled.

        It is where the node would touch; less what rounding makes of that, so that a node that
        has just touched stays.
        """
        rest, shape = self._surface(left, right, np.array([node]))
        height = float(self.f[node])
        rounding = _ROUNDING * (abs(height) + abs(float(shape[0])))
        return (height - float(shape[0]) - rounding) / float(rest[0])
