"""At which depths something happens to contacts on the lattice.

Between two contacts lies a free span of T links, whose first free node is displaced by
A g_i + B g_j (`span.shares`); outside are two tails, A = λ, B = 0. By the heights f of the nodes
involved,

    a line passes the next link (n = 1), or closes the last two (n = 2), or opens one, at
        d = f_i + (f_1 - f_i + B (f_i - f_j) - G)/(1 - A - B),   G = √(2 n wΔx/c),
        c = kΔx + t + t(1 - A(T-1)), the stiffness of the first free node;
    a free node touches at  d = (f_m - a f_i - b f_j)/(1 - a - b), a and b the shape of the span;
    a node inside a contact is torn open as a line that opens two links (n = 2, T = 2);
    a lone node, which has no adhesion, lets go where it begins to be pulled.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import span
from discretization.lattice.nodes import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.int_]
_ROUNDING = 256 * float(np.finfo(float).eps)


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

    def pulled(self, left: int | None, node: int, right: int | None) -> float:
        """Depth below which a lone node between two contacts (None: none there) is pulled.

        It is where the node would touch; less what rounding makes of that, so that a node that
        has just touched stays.
        """
        rest, shape = self._surface(left, right, np.array([node]))
        height = float(self.f[node])
        rounding = _ROUNDING * (abs(height) + abs(float(shape[0])))
        return (height - float(shape[0]) - rounding) / float(rest[0])
