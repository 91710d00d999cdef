"""At which depths something happens to contacts on the lattice.

Between two contacts lies a free span of T links, whose first free node is displaced by
A g_i + B g_j (`span.shares`); outside are two tails, A = λ, B = 0. By the heights f of the nodes
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
import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import span
from discretization.lattice.nodes import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.int_]
_ROUNDING = 256 * float(np.finfo(float).eps)
_TIE = 64 * float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Rules:
    """The depths of changes for nodes of heights f (n,)."""

    lattice: Lattice
    f: Array

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def shares(self, links: int | None) -> tuple[float, float, float]:
        """A, B and 1 - A - B."""
        beyond = math.inf if links is None else links - 1.0
        near, far, both = span.shares(self.lattice.log_decay, np.array(1.0), np.array(beyond))
        return float(near), float(far), float(both)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def passes(self, node: int, side: int, other: int | None) -> float:
        """Depth at which a line at `node` passes the link to the next node, on this side."""
        lat, after = self.lattice, node + side
        links = None if other is None else abs(other - node)
        _, far, both = self.shares(links)
        rest = lat.loss if links is None else 1 - self.shares(links - 1)[0]
        bonds = 2 if links == 2 else 1
        stiffness = lat.spring + lat.link + lat.link * rest
        gap = math.sqrt(2 * bonds * lat.w * lat.spacing / stiffness)
        rise = float(self.f[after] - self.f[node])
        if other is not None:
            rise += far * float(self.f[node] - self.f[other])
        return float(self.f[node]) + (rise - gap) / both

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def passes_both(self, left: int, right: int) -> float:
        """Depth at which both lines of a span pass a link at once; inf if they never do."""
        lat, links = self.lattice, right - left
        if links < 3:
            return math.inf
        near, far, both = self.shares(links)
        inner = self.shares(links - 2)
        own, other = lat.spring + lat.link * (2 - inner[0]), lat.link * inner[1]
        f, g, f_next, g_next = (float(self.f[i]) for i in (left, right, left + 1, right - 1))
        one, two = f_next - near * f - far * g, g_next - near * g - far * f
        work = (3 if links == 3 else 2) * lat.w * lat.spacing - (own + other) * (one - two) ** 2 / 4
        if work < 0:
            return math.inf
        return ((one + two) / 2 - math.sqrt(work / (own - other))) / both

    def advance_both(self, left: int, right: int) -> float:
        """The same if no other node is penetrated then, else inf."""
        depth = self.passes_both(left, right)
        clear = right - left <= 3 or self._clear(left + 1, right - 1, depth)
        return depth if clear else math.inf

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def touches(self, left: int | None, right: int | None) -> tuple[float, int]:
        """Depth at which a free node between two contacts (None: none there) touches, and which."""
        lo, hi = -1 if left is None else left, self.f.size if right is None else right
        if hi - lo < 2:
            return math.inf, -1
        depths, shares = self.f[lo + 1 : hi].copy(), self._free(left, right)
        for end, share in zip((left, right), shares, strict=False):
            if end is not None:
                depths -= share * self.f[end]
        depths /= shares[2]
        best = int(np.argmin(depths))
        return float(depths[best]), lo + 1 + best

    @functools.cached_property
    def _decays(self) -> tuple[Array, Array, Array]:
        """λⁿ, λⁿ - 1 and λ²ⁿ - 1 for n = 0, 1, ..."""
        n = -self.lattice.log_decay * np.arange(self.f.size + 1.0)
        return np.exp(n), np.expm1(n), np.expm1(2 * n)

    def _free(self, left: int | None, right: int | None) -> tuple[Array, Array, Array]:
        """`span.shares` of all free nodes between two contacts (None: none there), looked up."""
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
        a, b, rest = span.shares(self.lattice.log_decay, p, q)
        return rest, a * f_left + b * f_right

    @functools.lru_cache(maxsize=1 << 12)  # noqa: B019
    def tears(self, first: int, last: int) -> tuple[float, int]:
        """Depth below which a node inside a contact is torn open, and which."""
        lat, m = self.lattice, np.arange(first + 1, last)
        near, _, both = self.shares(2)
        gap = math.sqrt(4 * lat.w * lat.spacing / (lat.spring + 2 * lat.link))
        torn = (self.f[m] - near * (self.f[m - 1] + self.f[m + 1]) - gap) / both
        best = int(np.argmax(torn))
        return float(torn[best]), int(m[best])

    def tie(self, one: float, other: float) -> float:
        """What rounding makes of the difference of two depths at which something happens.

        The largest difference quotient of heights that enters them is that of a span of two links.
        """
        size = abs(one) + abs(other) + math.sqrt(2 * self.lattice.w / self.lattice.k)
        return _TIE * size / self.shares(2)[2]

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def advances(self, node: int, side: int, other: int | None) -> float:
        """Depth at which a line passes the next link if no other node may be penetrated then.

        inf: another node touches before.
        """
        alone, after = self.passes(node, side, other), node + side
        if other is not None and abs(other - after) < 2:
            return alone
        if self._clear(*_ordered(side, after, other), alone):
            return alone
        low, high = alone, self.touches(*_ordered(side, node, other))[0]
        if self._cost(node, side, other, high) > 0:
            return math.inf
        while high - low > self.tie(low, high):
            middle = (low + high) / 2
            if self._cost(node, side, other, middle) > 0:
                low = middle
            else:
                high = middle
        return high

    def recede_both(self, left: int, right: int) -> float:
        """Depth at which both lines of a span open a link at once, none of the nodes pressed."""
        ends = left - 1, right + 1
        return min(self.passes_both(*ends), self.touches(*ends)[0])

    def _clear(self, left: int | None, right: int | None, depth: float) -> bool:
        """Whether the surface between two contact nodes (None: none there) clears the indenter."""
        touch = self.touches(left, right)[0]
        return touch == math.inf or touch >= depth - self.tie(touch, depth)

    def _cost(self, node: int, side: int, other: int | None, depth: float) -> float:
        """Energy by which passing the next link changes that of the surface above the indenter.

        Of adhesion it gains that link's alone: not what the nodes held may adhere by.
        """
        lat, after = self.lattice, node + side
        ends = _ordered(side, after, other)
        held = self._held(*ends, depth)
        new = np.array([after, *held])
        parts = itertools.pairwise([ends[0], *held, ends[1]])
        cost = sum(self.stored(*part, depth) for part in parts) + self.stored(node, after, depth)
        cost += lat.spring / 2 * float(np.sum((depth - self.f[new]) ** 2))
        cost -= self.stored(*_ordered(side, node, other), depth)
        return cost - lat.w * lat.spacing

    def _held(self, left: int | None, right: int | None, depth: float) -> list[int]:
        """The nodes that keep the surface between two contact nodes above the indenter.

        The first one to touch is among them, as they only become more with the depth.
        """
        touch, node = self.touches(left, right)
        if touch >= depth:
            return []
        return [*self._held(left, node, depth), node, *self._held(node, right, depth)]

    def pull(self, node: int, other: int | None, depth: float) -> float:
        """Force on a contact node of the free part between it and another one (None: a tail).

        t (g - A g - B g'), without cancellation.
        """
        _, far, both = self.shares(None if other is None else abs(other - node))
        apart = 0.0 if other is None else float(self.f[other] - self.f[node])
        return self.lattice.link * (both * (depth - float(self.f[node])) + far * apart)

    def stored(self, left: int | None, right: int | None, depth: float) -> float:
        """Energy of the surface between two contact nodes (None: none there), free or one link."""
        lat, f = self.lattice, self.f
        if left is not None and right is not None and right - left == 1:
            return lat.link / 2 * float(f[right] - f[left]) ** 2
        ends = ((left, right), (right, left))
        own = [(depth - float(f[i])) * self.pull(i, j, depth) for i, j in ends if i is not None]
        return sum(own) / 2

    def pulled(self, left: int | None, node: int, right: int | None) -> float:
        """Depth below which a lone node between two contacts (None: none there) is pulled.

        It is where the node would touch; less what rounding makes of that, so that a node that
        has just touched stays.
        """
        rest, shape = self._surface(left, right, np.array([node]))
        height = float(self.f[node])
        rounding = _ROUNDING * (abs(height) + abs(float(shape[0])))
        return (height - float(shape[0]) - rounding) / float(rest[0])


def _ordered(side: int, node: int, other: int | None) -> tuple[int | None, int | None]:
    """Left and right contact node of the free part on this side of a node."""
    return (node, other) if side > 0 else (other, node)
