"""The depths of changes around the axis: those of rules.py, with spans that depend on the place.

The free part on the side of the axis is a disc without another line, or nothing where the contact
includes the axis, whose node has no link to pass. With x = r d - h the heights of both nodes next
to the lines of a span above the surface held by these, and H their stiffness, both pass a link at
once where x·Hx/2 is the adhesion gained.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.radial_spans import RingSpans, ring_spans
from discretization.lattice.rules import Rules

Array = NDArray[np.float64]


class RadialRules(Rules):
    """The depths of changes for nodes 0, 1, ... of heights f (n,), on a `RadialLattice`."""

    @functools.cached_property
    def spans(self) -> RingSpans:
        """What is known of free surfaces."""
        return ring_spans(self.lattice.spring / self.lattice.link, self.f.size)

    @functools.cached_property
    def torn(self) -> Array:
        """Not the node on the axis: there the contact's inner line would begin."""
        f, n = self.f, self.f.size
        if n < 3 or self.clear:
            return np.full(n, -math.inf)
        node = np.arange(1.0, n - 1)
        kappa = self.lattice.spring / self.lattice.link
        inner, outer = (node - 0.5) / node, (node + 0.5) / node
        gap = np.sqrt(2 * (self.work[1:] + self.work[:-1]) * (kappa + 2) / node / self.lattice.link)
        rise = inner * (f[1:-1] - f[:-2]) + outer * (f[1:-1] - f[2:])
        return np.pad(f[1:-1] + (rise - gap) / kappa, 1, constant_values=-math.inf)

    def beside(self, node: int, side: int, other: int) -> tuple[float, float, float]:
        far, both, stiffness = self.spans.beside(node, side, other)
        return far, both, stiffness * self.lattice.link

    def stored(self, left: int | None, right: int | None, depth: float) -> float:
        if left is not None and right is not None:
            left, right = min(left, right), max(left, right)
            tie, one, other = map(float, self.spans.pair(left, right))
        else:
            tie, one, other = 0.0, 0.0, 0.0
            one = 0.0 if left is None else float(self.spans.outside[left])
            other = 0.0 if right is None else float(self.spans.inside[right])
        g, h = (0.0 if end is None else depth - float(self.f[end]) for end in (left, right))
        apart = 0.0 if left is None or right is None else float(self.f[right] - self.f[left])
        return self.lattice.link / 2 * (one * g * g + other * h * h + tie * apart**2)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def passes_both(self, left: int, right: int) -> float:
        if right - left < 3:
            return math.inf
        f, spans = self.f - self.f[left], self.spans
        ends = np.array([left + 1, right - 1])
        _, far, rest = spans.shape(left, right, ends)
        tie, *grounds = map(float, spans.pair(left + 1, right - 1))
        links = np.array([left + 0.5, right - 0.5])
        own = spans.spring[ends].astype(float) + links + tie + np.array(grounds)
        whole = self.lattice.link * np.array([[own[0], -tie], [-tie, own[1]]])
        height = f[ends] - far * f[right]
        rate = float(rest @ whole @ rest)
        middle = float(rest @ whole @ height) / rate
        off = rest * middle - height
        work = self._both_adhere(left, right) - float(off @ whole @ off) / 2
        if work < 0:
            return math.inf
        return float(self.f[left]) + middle - math.sqrt(2 * work / rate)

    def _both_adhere(self, left: int, right: int) -> float:
        """Adhesion of what closes when both lines of a span pass a link."""
        if right - left == 3:
            return self.adhesion(left, right)
        return self.adhesion(left, left + 1) + self.adhesion(right - 1, right)

    def _free(self, left: int | None, right: int | None) -> tuple[Array, Array, Array]:
        lo = -1 if left is None else left
        return self.spans.shape(left, right, slice(lo + 1, right))

    def _surface(
        self, left: int | None, right: int | None, m: NDArray[np.int_]
    ) -> tuple[Array, Array]:
        a, b, rest = self.spans.shape(left, right, m)
        f_left, f_right = (0.0 if end is None else self.f[end] for end in (left, right))
        return rest, a * f_left + b * f_right

    @functools.cached_property
    def lift(self) -> float:
        weights = (np.arange(self.work.size) + 0.5) * self.lattice.cell
        return math.sqrt(2 * float((self.work / weights).max(initial=0.0)) / self.lattice.k)

    @functools.cached_property
    def least_rest(self) -> float:
        kappa = self.lattice.spring / self.lattice.link
        return kappa / (kappa + 2)
