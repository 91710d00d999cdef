"""The depths of changes with finite slopes: those of rules.py where two contact lines face.

The free surface between two contacts is not linear in the depth there (finite_spans.py). A free
node touches where its clearance is zero, which falls with the depth. Lines pass links where that
leaves the energy as it is,

    Σ E(parts after) + Σ kΔx (d - f_new)²/2 - E(span before) = Σ (w Δx √(1+s²)) of links that close,

whose left side less the right one falls with d up to where the first of the new nodes touches. Both
depths are found as roots, from those of small slopes.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from typing import cast

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.bracket import falling_root
from discretization.lattice.finite_nodes import FiniteLattice
from discretization.lattice.finite_spans import ENDLESS
from discretization.lattice.rules import Nodes, Rules
from discretization.roots import bracketed

Array = NDArray[np.float64]
_NEAR = 1e-2  # of δ₀ and d: first width beside the depth of small slopes


class FiniteRules(Rules):
    """The depths of changes for nodes of heights f (n,), on a `FiniteLattice`."""

    @property
    def _on(self) -> FiniteLattice:
        return cast(FiniteLattice, self.lattice)

    @functools.cached_property
    def torn(self) -> Array:
        """By how far z the open node stands off, of which the depth is a function."""
        lat, f = self._on, self.f
        if f.size < 3 or self.clear:
            return np.full(f.size, -math.inf)
        work, sides = self.bonds[1:] + self.bonds[:-1], (f[:-2] - f[1:-1], f[2:] - f[1:-1])

        def depth(z: Array) -> Array:
            pull = sum(lat.tension(side + z) for side in sides)
            return np.asarray(f[1:-1] - z - pull / lat.spring)

        def left_over(z: Array) -> Array:
            closed, opened = depth(z) - f[1:-1], depth(z) - f[1:-1] + z
            gain = lat.spring / 2 * (closed - opened) * (closed + opened)
            for side in sides:
                gain = gain + lat.link_energies(side) - lat.link_energies(side + z)
            return np.asarray(work - gain)

        guess = np.sqrt(2 * work / (lat.spring + 2 * lat.link))
        z = falling_root(lambda at: left_over(np.maximum(at, 0.0)), guess, _NEAR * guess)
        return np.pad(depth(np.maximum(z, 0.0)), 1, constant_values=-math.inf)

    def _root(self, excess: Callable[[float], float], guess: float) -> float:
        """Where a function of the depth that falls is zero."""
        size = self.lift + abs(guess)
        low, high, width = guess, guess, _NEAR * size
        while excess(low) < 0:
            low, width = low - width, 4 * width
        while excess(high) > 0:
            high, width = high + width, 4 * width
        if low == high:
            return guess
        return float(bracketed(lambda depth: -excess(depth), low, high))

    def _clearance(self, left: int | None, right: int | None, m: Nodes, depth: float) -> Array:
        """u - g at free nodes between two contacts (None: none there)."""
        lat, end, u = self._on, right if left is None else left, np.zeros(m.size)
        if left is not None and right is not None:
            ends = depth - self.f[left], depth - self.f[right]
            u = lat.length * lat.between(*ends, right - left).u[m - left]
        elif end is not None:
            links = np.abs(m - end)
            u = lat.tail_nodes(depth - self.f[end], int(links.max()))[links]
        return np.asarray(u - depth + self.f[m])

    def _touch(self, left: int | None, right: int | None, start: int, stop: int) -> float:
        """Depth at which the first of the free nodes start..stop-1 touches."""
        guess, m = super()._first(left, right, start, stop)[0], np.arange(start, stop)
        return self._root(lambda d: self._clearance(left, right, m, d).min(), guess)

    def _first(
        self, left: int | None, right: int | None, start: int, stop: int
    ) -> tuple[float, int]:
        free = np.arange(start, stop)
        depth = self._touch(left, right, start, stop)
        return depth, int(free[np.argmin(self._clearance(left, right, free, depth))])

    def pulled(self, left: int | None, node: int, right: int | None) -> float:
        linear = super()._first(left, right, node, node + 1)[0]
        rounding = linear - super().pulled(left, node, right)
        return self._touch(left, right, node, node + 1) - rounding

    def _cost(self, left: int, right: int, new: tuple[int, ...], depth: float) -> float:
        """Energy by which contact at new nodes changes that of the span."""
        parts = itertools.pairwise([left, *new, right])
        gained = sum(self.adhesion(*part) for part in parts if part[1] - part[0] == 1)
        return self.cost(left, right, new, depth) - gained

    def _rate(self, left: int, right: int, new: tuple[int, ...], depth: float) -> float:
        """The change of that energy with the depth."""

        def pull(one: int, other: int) -> float:
            return float(self.lattice.gap_force(one, other, self.f[one], self.f[other], depth))

        pulls = sum(itertools.starmap(pull, itertools.pairwise([left, *new, right])))
        squeezed = self.lattice.spring * float(np.sum(depth - self.f[list(new)]))
        return pulls - pull(left, right) + squeezed

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def passes(self, node: int, side: int, other: int | None) -> float:
        if other is None:
            return super().passes(node, side, other)
        left, right, after = min(node, other), max(node, other), node + side
        touch = self._touch(left, right, after, after + 1)
        if not self.adhesion(node, other if right - left == 2 else after):
            return touch
        guess = super().passes(node, side, other)
        return self._root(
            lambda d: self._cost(left, right, (after,), min(d, touch)), min(guess, touch)
        )

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def passes_both(self, left: int, right: int) -> float:
        if right - left < 3:
            return math.inf
        if self.lattice.log_decay * (right - left) > ENDLESS:
            return min(self.passes(left, 1, right), self.passes(right, -1, left))
        new = left + 1, right - 1
        touches = sorted(self._touch(left, right, node, node + 1) for node in new)
        best = touches[0]
        if touches[1] > touches[0]:
            best = bracketed(lambda d: self._rate(left, right, new, d), *touches)
        if self._cost(left, right, new, best) > 0:
            return math.inf
        return self._root(lambda d: self._cost(left, right, new, min(d, best)), best)
