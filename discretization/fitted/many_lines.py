"""The contact lines of many states at once, each of one contact of the same indenter.

The search is that of one state (alone.py): a line rests where D = d, or is pinned at the corner at
which D jumps past d. D is the rest depth of the same free surfaces (../surfaces), read for arrays
of states; every state has its own l, w/γ₁ and depth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import ROUNDING
from discretization.fitted.alone import Alone
from discretization.profile import past_wall
from discretization.roots import crossings
from energy.arrays import Array, Indices, Mask

_TIE = ROUNDING  # of the size of displacements: D - d where moving a line costs nothing
_FARTHER = 4.0  # each place at which the outer end of a bracket is looked for, over the one before
_STEEP = 30.0  # of the size of displacements: D - d from which secants find a line
_HALVINGS = 200  # of a bracket at most, as in roots.py
_DEEP = 30.0  # as far inwards the least D about an axis is looked for, in powers of e
_PARTS = np.arange(1, 8) / 8  # of what is between two places, where the least D is looked for
_SECTIONS = 16  # each leaves two of these parts, in the end 5e-10 of all: a minimum is flat
_HOLDS = 1 + 1e-9  # δ₀ below touching nothing holds; with a margin for rounding


@dataclass(frozen=True, eq=False)
class States:
    """Depths [length], works of adhesion, tensions and stiffnesses of many states (n,)."""

    depth: Array
    work: Array
    gamma1: Array
    stiffness: Array

    def of(self, own: Any) -> States:
        """Those of these numbers."""
        return States(self.depth[own], self.work[own], self.gamma1[own], self.stiffness[own])

    def parameters(self, i: int) -> tuple[float, float, float, float]:
        """Depth, w, γ₁ and k of one state."""
        numbers = (self.depth[i], self.work[i], self.gamma1[i], self.stiffness[i])
        depth, work, gamma1, stiffness = map(float, numbers)
        return depth, work, gamma1, stiffness

    @property
    def length(self) -> Array:
        """l = √(γ₁/k)."""
        return np.sqrt(self.gamma1 / self.stiffness)

    @property
    def separation(self) -> Array:
        """δ₀ = √(2w/k)."""
        return np.sqrt(2 * self.work / self.stiffness)


@dataclass(frozen=True, eq=False)
class ManyLines:
    """Contact lines of many states (n,) with the indenter and the free surfaces of `alone`.

    goal: the depth at which each line would rest, D = goal; with tension that is the depth of the
    state. length: l, 0 where there is no tension: then D is the height of the profile. ratio: w/γ₁.
    size: of displacements; step: a first distance to look for a line in; lowest: a goal below which
    no line rests.
    """

    alone: Alone
    goal: Array
    length: Array
    ratio: Array
    size: Array
    step: Array
    lowest: Array

    @classmethod
    def tense(cls, alone: Alone, states: States) -> ManyLines:
        """Lines of states with γ₁ > 0."""
        length, separation = states.length, states.separation
        size = np.maximum(np.abs(states.depth), abs(alone.touch)) + separation
        size[size == 0] = 1.0  # a touch without adhesion: nothing is displaced
        ratio = states.work / states.gamma1
        lowest = np.full_like(size, -math.inf)
        if alone.scene.axisymmetric:
            lowest = alone.touch - _HOLDS * separation
        return cls(alone, states.depth, length, ratio, size, length, lowest)

    @classmethod
    def slack(cls, alone: Alone, states: States) -> ManyLines:
        """Lines of states without tension: springs are in contact up to a level of the profile.

        Each attaches on touching and lets go at u = -δ₀: the level is min(max(d, min f), d + δ₀).
        """
        depth, separation = states.depth, states.separation
        level = np.minimum(np.maximum(depth, alone.touch), depth + separation)
        size = np.maximum(np.abs(depth), abs(alone.touch)) + separation
        size[size == 0] = 1.0  # a touch without adhesion: nothing is displaced
        attached = level >= alone.touch - _TIE * size
        goal = np.where(attached, np.maximum(level, alone.touch), level)
        none = np.zeros_like(depth)
        step = np.maximum(size, alone.scene.layer.h)
        lowest = np.where(attached, -math.inf, math.inf)
        return cls(alone, goal, none, none, size, step, lowest)

    def of(self, own: Indices) -> ManyLines:
        """The lines of these numbers."""
        arrays = (self.goal, self.length, self.ratio, self.size, self.step, self.lowest)
        return ManyLines(self.alone, *(values[own] for values in arrays))

    def rest_depth(self, side: int, x: Array, own: Any, beside: int = 0) -> Array:
        """D at x, (m,) or (m, j), for the states of these numbers (m,).

        beside: outwards (1) or inwards (-1) of x, which differ at corners; beyond an edge of the
        body D is infinite.
        """
        indenter, surfaces = self.alone.scene.indenter, self.alone.surfaces
        height = np.asarray(indenter.height(x), float)
        length = self.length[own]
        if length.any():
            slope = indenter.slope_beside(x, side * beside) if beside else indenter.slope(x)
            ratio = self.ratio[own]
            if x.ndim > 1:
                length, ratio = length[:, None], ratio[:, None]
            u = surfaces.at_rest(side, x / length, math.inf, 0.0, side * slope, ratio)
            found = height + length * u
        else:
            found = height
        if beside and indenter.walls:
            edge = past_wall(indenter, x, side, beside)
            found = np.where(edge, math.copysign(math.inf, beside), found)
        return found

    def off(self, side: int, x: Array, own: Any, beside: int = 0) -> Array:
        """(D - goal)/size: a line recedes where this is positive, and advances where negative."""
        rest = self.rest_depth(side, x, own, beside)
        return np.asarray((rest - self.goal[own]) / self.size[own])

    def find(self, side: int) -> tuple[Array, Mask]:
        """x of the lines on one side, nan where none rests; which leave the known profile."""
        count = self.goal.size
        found, lost = np.full(count, math.nan), np.zeros(count, bool)
        pulled = np.zeros(count, bool)
        if self.alone.scene.axisymmetric:
            pulled = self.goal < self.alone.touch
        for which, search in ((~pulled, self._advanced), (pulled, self._pulled)):
            own = np.flatnonzero(which & (self.goal >= self.lowest))
            if own.size:
                found[own], lost[own] = search(side, own)
        return found, lost

    def _places(self, side: int) -> Array:
        """The apex and the corners outwards of it."""
        apex, corners = self.alone.apex, np.asarray(self.alone.scene.indenter.corners, float)
        outer = corners[side * corners > side * apex]
        return np.append(apex, outer[::side])

    def _advanced(self, side: int, own: Indices) -> tuple[Array, Mask]:
        """Lines outwards of the apex, at which they are themselves where nothing beyond holds."""
        places = self._places(side)
        first = self._first_pinning(side, own, places)
        x, lost = places[np.minimum(first, places.size - 1)], np.zeros(own.size, bool)

        # Between two corners: free where D just inside the outer one is already more than d.
        between = np.flatnonzero((first > 0) & (first < places.size))
        if between.size:
            behind = self.off(side, x[between], own[between], -1)
            free = between[behind > _TIE]
            outer = x[free]
            inner = places[first[free] - 1]
            ahead = self.off(side, inner, own[free], 1)
            moves = ahead < 0
            x[free] = inner
            free, inner, outer = free[moves], inner[moves], outer[moves]
            x[free] = self._root(side, own[free], inner, outer)

        beyond = np.flatnonzero(first == places.size)
        if beyond.size:
            last = np.full(beyond.size, places[-1])
            ahead = self.off(side, last, own[beyond], 1)
            moves = ahead < 0
            free, start, ahead = beyond[moves], last[moves], ahead[moves]
            ends = self._outwards(side, own[free], start, self.goal[own[free]], ahead)
            inner, outer, low, high, gone = ends
            lost[free] = gone
            kept = ~gone
            free = free[kept]
            values = low[kept], high[kept]
            x[free] = self._root(side, own[free], inner[kept], outer[kept], values)
        return x, lost

    def _first_pinning(self, side: int, own: Indices, places: Array) -> Indices:
        """The number of the first place just outwards of which D > d, by bisection; or how many.

        D grows outwards: of a convex profile everywhere, about an axis from where it exceeds d on.
        """
        low, high = np.zeros(own.size, int), np.full(own.size, places.size)
        while (open_ := np.flatnonzero(low < high)).size:
            middle = (low[open_] + high[open_]) // 2
            pins = self.off(side, places[middle], own[open_], 1) > _TIE
            high[open_] = np.where(pins, middle, high[open_])
            low[open_] = np.where(pins, low[open_], middle + 1)
        return low

    def _outwards(
        self, side: int, own: Indices, start: Array, level: Array, value: Array
    ) -> tuple[Array, Array, Array, Array, Mask]:
        """Places on both sides of where D is `level`, from `start` on, and (D - level)/size there.

        value: that at the start; the last: where the known profile ends before.
        """
        inner, outer, low, high = start.copy(), start.copy(), value.copy(), value.copy()
        limit = float(self.alone.scene.indenter.extent[0 if side < 0 else 1])
        gone, span = np.zeros(own.size, bool), self.step[own].copy()
        left = np.arange(own.size)
        while left.size:
            x = side * np.minimum(side * (start[left] + side * span[left]), side * limit)
            rest = self.rest_depth(side, x, own[left])
            found = (rest - level[left]) / self.size[own[left]]
            above = found > 0
            outer[left], high[left] = x, found
            left, x, found = left[~above], x[~above], found[~above]
            inner[left], low[left] = x, found
            span[left] *= _FARTHER
            ended = (x == limit) | ~np.isfinite(span[left])
            gone[left[ended]] = True
            left = left[~ended]
        return inner, outer, low, high, gone

    def _root(
        self,
        side: int,
        own: Indices,
        inner: Array,
        outer: Array,
        values: tuple[Array, Array] | None = None,
    ) -> Array:
        """Where D = d between two places; values: (D - d)/size there, where they are known."""
        if not own.size:
            return inner
        if values is None:
            values = self.off(side, inner, own), self.off(side, outer, own)
        inner, outer, low, high = self._narrowed(side, own, inner, outer, *values)
        width = outer - inner
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            rise = (high - low) / width
            guess = inner - low / rise
        usable = np.isfinite(rise) & (rise * side > 0)
        usable &= (side * guess > side * inner) & (side * guess < side * outer)
        guess = np.where(usable, guess, (inner + outer) / 2)
        with np.errstate(divide="ignore"):
            rise = np.where(usable, rise, side / np.abs(width))

        def off(x: Array, which: Indices) -> Array:
            return self.off(side, x, own[which])

        ends = np.minimum(inner, outer), np.maximum(inner, outer)
        return crossings(off, *ends, guess, rise, 0.0)

    def _narrowed(
        self, side: int, own: Indices, inner: Array, outer: Array, low: Array, high: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Brackets halved until D is of the size of depths at both ends.

        Secants from where a profile such as x¹⁰⁰ has risen by orders of magnitude would not move.
        """
        inner, outer, low, high = inner.copy(), outer.copy(), low.copy(), high.copy()
        steep = np.flatnonzero(~(high <= _STEEP))
        for _ in range(_HALVINGS):
            if not steep.size:
                break
            middle = (inner[steep] + outer[steep]) / 2
            value = self.off(side, middle, own[steep])
            above = value > 0
            outer[steep[above]], high[steep[above]] = middle[above], value[above]
            inner[steep[~above]], low[steep[~above]] = middle[~above], value[~above]
            steep = steep[~(high[steep] <= _STEEP)]
        return inner, outer, low, high

    def _pulled(self, side: int, own: Indices) -> tuple[Array, Mask]:
        """Lines about an axis at depths less than that of touching, nan where contact is lost.

        D falls from the depth of touching at the axis to its least and grows from there on: the
        line rests in the growing part. At an edge of the body it is pinned.
        """
        found, lost = np.full(own.size, math.nan), np.zeros(own.size, bool)
        edges = self._places(side)[1:]
        if edges.size:  # of these shapes only a flat punch has one: D falls up to it
            edge = np.full(own.size, edges[-1])
            pinned = self.off(side, edge, own, -1) <= _TIE
            found[pinned] = edge[pinned]
            return found, lost
        touch = np.full(own.size, self.alone.touch)
        start, level = np.zeros(own.size), np.zeros(own.size)
        _, outer, _, high, lost = self._outwards(side, own, start, touch, level)
        high = high + (touch - self.goal[own]) / self.size[own]
        inner, outer, low, high = self._below(side, own, outer, high)
        rests = ~np.isnan(inner) & ~lost
        flat = rests & (low > 0)  # the least D, to rounding
        found[flat] = inner[flat]
        free = np.flatnonzero(rests & ~flat)
        values = low[free], high[free]
        found[free] = self._root(side, own[free], inner[free], outer[free], values)
        return found, lost

    def _below(
        self, side: int, own: Indices, outer: Array, high: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Places on both sides of the line, and (D - d)/size there; the inner is nan without one.

        outer: where D exceeds the depth of touching. In log r, at ever closer places around the
        least D (as `roots.least` does), until one of them is below d.
        """
        inner, low = np.full(own.size, math.nan), np.full(own.size, math.nan)
        first, last = np.zeros(own.size), np.full(own.size, _DEEP)
        edge, top, beyond = outer.copy(), high.copy(), outer.copy()
        left = np.arange(own.size)
        for _ in range(_SECTIONS):
            t = first[left, None] + (last - first)[left, None] * _PARTS
            x = edge[left, None] * np.exp(-t)
            rest = self.rest_depth(side, x, own[left])
            value = (rest - self.goal[own[left], None]) / self.size[own[left], None]
            least = value.argmin(axis=1)
            rows = np.arange(left.size)
            below = value[rows, least] <= _TIE
            reached = np.where(value[rows, least] <= 0, (value <= 0).argmax(axis=1), least)

            hit, at = left[below], reached[below]
            inner[hit], low[hit] = x[below, at], value[below, at]
            before = np.maximum(at - 1, 0)
            outer[hit] = np.where(at > 0, x[below, before], beyond[hit])
            high[hit] = np.where(at > 0, value[below, before], top[hit])

            rest_of = ~below
            left, t, x, value, least = (z[rest_of] for z in (left, t, x, value, least))
            if not left.size:
                break
            rows, inside = np.arange(left.size), least > 0
            previous, following = np.maximum(least - 1, 0), np.minimum(least + 1, _PARTS.size - 1)
            first[left] = np.where(inside, t[rows, previous], first[left])
            beyond[left] = np.where(inside, x[rows, previous], beyond[left])
            top[left] = np.where(inside, value[rows, previous], top[left])
            ends = least + 1 == _PARTS.size
            last[left] = np.where(ends, last[left], t[rows, following])
        return inner, outer, low, high
