"""The contact lines of many states at once, each of one contact of the same indenter.

The search is that of one state (single_contact.py): a line rests where D = d, or is pinned at the
corner at which D jumps past d. D is the rest depth of the same free surfaces (../surfaces), read
for arrays of states; every state has its own l, w/γ₁ and depth.

Conventions
-----------
Depths d and D are positive down into the layer, heights f of the profile upwards [length]. D grows
outwards of a line that rests: where D < d a line advances, where D > d it recedes. About an axis x
is the radius, and there are right lines only.

`side` is 1 for the right line of a contact, whose contact is on its left, and -1 for the left one;
outwards is the direction `side` along x, and `inner`, `outer` are places nearer to and further from
the apex, where the profile is lowest. `beside` says where the slope of the profile is read: 1 just
outwards of the contact, -1 just inwards, 0 at x itself.

Arrays have one entry a state. `own` are the numbers of the states to which the other arguments of a
method belong, in the arrays of the object; it is what fancy indexing takes.

`Surfaces.at_rest` is D - f in units of l; `past_wall` is whether lines are at the edge of the body,
so that there is nothing `beside` them; `crossings` finds zeros of many functions between brackets.

ROUNDING is 16 times 2⁻⁵², over the size of depths. `contact.scene` is the scene of which the states
are variants; of its indenter, `extent` are the ends of the known profile, `walls` those at which
the body itself ends, and `slope_beside(x, side)` is f' just on the right (1) or left (-1) of x. h
is the thickness of the layer, a length to step by where depths are 0. The least D about an axis is
looked for at radii e⁻ᵗ of a given one, up to t = DEEPEST_POWER, in NARROWINGS rounds: each reads D
at the seven places between EIGHTHS of an interval and keeps the two eighths around the least one.
A bracket is halved at most MOST_STEPS
times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import ROUNDING
from discretization.fitted.single_contact import DEEPEST_POWER, SingleContact
from discretization.profile import past_wall
from discretization.roots import EIGHTHS, MOST_STEPS, NARROWINGS, crossings
from energy.arrays import Array, Indices, Mask


class BracketRules(NamedTuple):
    """Where both ends of brackets of D = d are looked for.

    Halved or doubled, each leaves the 4 or more random states and paths that read it as they are to
    1e-9: `python -m tests.sensitivity discretization.fitted.many_lines`.

    Attributes
    ----------
    farther : float
        Each place at which the outer end is looked for, over the one before.
    steep : float
        Of the size of displacements: from a larger D - d secants would not move, so that brackets
        are halved first.
    holds : float
        Of δ₀: so far below touching no line holds; with a margin for rounding.
    """

    farther: float = 4.0
    steep: float = 30.0
    holds: float = 1 + 1e-9


_BRACKET = BracketRules()


@dataclass(frozen=True, eq=False)
class States:
    """The depth and the material of each of many states.

    Attributes
    ----------
    depth : ndarray (n,)
        [length].
    work : ndarray (n,)
        Works of adhesion w [energy/area].
    gamma1 : ndarray (n,)
        Tensions γ₁ [force/length].
    stiffness : ndarray (n,)
        k [force/volume].
    """

    depth: Array
    work: Array
    gamma1: Array
    stiffness: Array

    def of(self, own: Any) -> States:
        """The states with these numbers."""
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


class Brackets(NamedTuple):
    """Places on both sides of where lines rest, at which (D - d)/size has different signs.

    Attributes
    ----------
    inner, outer : ndarray (n,)
        Places nearer to the apex, where D <= d, and further from it, where D > d [length].
    at_inner, at_outer : ndarray (n,)
        (D - d)/size there.
    """

    inner: Array
    outer: Array
    at_inner: Array
    at_outer: Array

    def of(self, own: Any) -> Brackets:
        """Those with these numbers."""
        return Brackets(*(values[own] for values in self))

    def copied(self) -> Brackets:
        """The same in arrays of their own, to be changed in place."""
        return Brackets(*(values.copy() for values in self))


@dataclass(frozen=True, eq=False)
class ManyLines:
    """Contact lines of many states.

    Attributes
    ----------
    contact : SingleContact
        Their indenter and free surfaces.
    goal : ndarray (n,)
        The depth at which each line would rest, D = goal [length]. With tension it is the depth of
        the state.
    length : ndarray (n,)
        l, 0 where there is no tension: then D is the height of the profile [length].
    ratio : ndarray (n,)
        w/γ₁.
    size : ndarray (n,)
        Of displacements, to which D - goal is compared [length].
    step : ndarray (n,)
        A first distance in which a line is looked for [length].
    lowest : ndarray (n,)
        A goal below which no line rests [length].
    """

    contact: SingleContact
    goal: Array
    length: Array
    ratio: Array
    size: Array
    step: Array
    lowest: Array

    @classmethod
    def tense(cls, contact: SingleContact, states: States) -> ManyLines:
        """Lines of states with γ₁ > 0."""
        length = states.length
        separation = states.separation
        size = np.maximum(np.abs(states.depth), abs(contact.touch)) + separation
        size[size == 0] = 1.0  # a touch without adhesion: nothing is displaced
        ratio = states.work / states.gamma1
        lowest = np.full_like(size, -math.inf)
        if contact.scene.axisymmetric:
            lowest = contact.touch - _BRACKET.holds * separation
        return cls(contact, states.depth, length, ratio, size, length, lowest)

    @classmethod
    def slack(cls, contact: SingleContact, states: States) -> ManyLines:
        """Lines of states without tension: springs are in contact up to a level of the profile.

        Each attaches on touching, at f = d, and lets go where it is stretched by δ₀, f = d + δ₀.
        The adhered state has touched at max(d, min f) before it was retracted to d: so the level is
        min(max(d, min f), d + δ₀). Lines rest where f is the level; if that is below min f by more
        than rounding, nowhere.
        """
        depth = states.depth
        separation = states.separation
        level = np.minimum(np.maximum(depth, contact.touch), depth + separation)
        size = np.maximum(np.abs(depth), abs(contact.touch)) + separation
        size[size == 0] = 1.0  # a touch without adhesion: nothing is displaced
        attached = level >= contact.touch - ROUNDING * size
        goal = np.where(attached, np.maximum(level, contact.touch), level)
        none = np.zeros_like(depth)
        step = np.maximum(size, contact.scene.layer.h)
        lowest = np.where(attached, -math.inf, math.inf)
        return cls(contact, goal, none, none, size, step, lowest)

    def of(self, own: Indices) -> ManyLines:
        """The lines of the states with these numbers."""
        arrays = (self.goal, self.length, self.ratio, self.size, self.step, self.lowest)
        return ManyLines(self.contact, *(values[own] for values in arrays))

    def rest_depth(self, side: int, x: Array, own: Any, beside: int = 0) -> Array:
        """Depths D at which lines would rest.

        Parameters
        ----------
        side : {1, -1}
            1 for lines whose contacts are on their left.
        x : ndarray (m,) or (m, j)
            Positions [length].
        own : ndarray of int (m,), or slice
            The numbers of their states.
        beside : {0, 1, -1}
            Whether D is read outwards (1) or inwards (-1) of x, which differ at corners. Beyond an
            edge of the body D is infinite.

        Returns
        -------
        ndarray
            [length], in the shape of x.
        """
        indenter = self.contact.scene.indenter
        surfaces = self.contact.surfaces
        height = np.asarray(indenter.height(x), float)
        length = self.length[own]
        if length.any():
            slope = indenter.slope_beside(x, side * beside) if beside else indenter.slope(x)
            ratio = self.ratio[own]
            if x.ndim > 1:
                length = length[:, None]
                ratio = ratio[:, None]
            u = surfaces.at_rest(side, x / length, math.inf, 0.0, side * slope, ratio)
            found = height + length * u
        else:
            found = height
        if beside and indenter.walls:
            edge = past_wall(indenter, x, side, beside)
            found = np.where(edge, math.copysign(math.inf, beside), found)
        return found

    def off(self, side: int, x: Array, own: Any, beside: int = 0) -> Array:
        """(D - goal)/size: a line recedes where this is positive, and advances where negative.

        Parameters as of `rest_depth`.
        """
        rest = self.rest_depth(side, x, own, beside)
        goal = self.goal[own]
        size = self.size[own]
        if x.ndim > 1:
            goal = goal[:, None]
            size = size[:, None]
        return np.asarray((rest - goal) / size)

    def find(self, side: int) -> tuple[Array, Mask]:
        """Where the lines on one side rest.

        Parameters
        ----------
        side : {1, -1}
            1 for the right lines.

        Returns
        -------
        x : ndarray (n,)
            [length], nan where a line rests nowhere.
        lost : ndarray of bool (n,)
            Which lines leave the known profile.

        About an axis a line at a depth less than that of touching is pulled: it is searched for in
        another way, as D does not grow from the apex on there.
        """
        count = self.goal.size
        found = np.full(count, math.nan)
        lost = np.zeros(count, bool)
        pulled = np.zeros(count, bool)
        if self.contact.scene.axisymmetric:
            pulled = self.goal < self.contact.touch
        for which, search in ((~pulled, self._advanced), (pulled, self._pulled)):
            own = np.flatnonzero(which & (self.goal >= self.lowest))
            if own.size:
                found[own], lost[own] = search(side, own)
        return found, lost

    def _places(self, side: int) -> Array:
        """The apex and the corners outwards of it, in this order [length]."""
        apex = self.contact.apex
        corners = np.asarray(self.contact.scene.indenter.corners, float)
        outer = corners[side * corners > side * apex]
        return np.append(apex, outer[::side])

    def _advanced(self, side: int, own: Indices) -> tuple[Array, Mask]:
        """Lines where D grows from the apex on; which of them leave the known profile.

        A line rests at the first of the apex and the corners just outwards of which D exceeds d,
        or before it, if D reaches d before that; or beyond the last corner.
        """
        places = self._places(side)
        first = self._first_pinning(side, own, places)
        x = places[np.minimum(first, places.size - 1)]
        lost = np.zeros(own.size, bool)
        between = np.flatnonzero((first > 0) & (first < places.size))
        if between.size:
            outer = x[between]
            inner = places[first[between] - 1]
            x[between] = self._between_corners(side, own[between], inner, outer)
        beyond = np.flatnonzero(first == places.size)
        if beyond.size:
            x[beyond], lost[beyond] = self._beyond_corners(side, own[beyond], places[-1])
        return x, lost

    def _between_corners(self, side: int, own: Indices, inner: Array, outer: Array) -> Array:
        """Lines that rest between two corners or at one of them.

        D just outwards of the inner corner is not more than d, up to rounding, and D just outwards
        of the outer one is. A line is pinned at the outer corner unless D just inwards of that is
        more than d, too: then it rests before, at the inner one if D there is d up to rounding.

        side: 1 for right lines; own: numbers of their states (m,); inner, outer: both corners of
        each (m,) [length].
        """
        x = outer.copy()
        behind = self.off(side, outer, own, -1)
        free = np.flatnonzero(behind > ROUNDING)
        x[free] = inner[free]
        ahead = self.off(side, inner[free], own[free], 1)
        free = free[ahead < 0]  # D grows from less than d to more between both corners
        x[free] = self._root(side, own[free], inner[free], outer[free])
        return x

    def _beyond_corners(self, side: int, own: Indices, last: float) -> tuple[Array, Mask]:
        """Lines that rest at the last corner or beyond it; which leave the known profile.

        last: the last corner, or the apex if there is none [length].
        """
        x = np.full(own.size, last)
        lost = np.zeros(own.size, bool)
        ahead = self.off(side, x, own, 1)
        free = np.flatnonzero(ahead < 0)
        goal = self.goal[own[free]]
        brackets, gone = self._outwards(side, own[free], x[free], goal, ahead[free])
        lost[free] = gone
        free = free[~gone]
        x[free] = self._root_between(side, own[free], brackets.of(~gone))
        return x, lost

    def _first_pinning(self, side: int, own: Indices, places: Array) -> Indices:
        """The number of the first of the places just outwards of which D > d, for every state.

        It is the number of places where there is none. D grows outwards: of a convex profile
        everywhere, about an axis from where it exceeds d on; so bisection finds it.

        side: 1 for right lines; own: numbers of their states (m,); places: the apex and the corners
        outwards of it [length].
        """
        low = np.zeros(own.size, int)
        high = np.full(own.size, places.size)
        while (undecided := np.flatnonzero(low < high)).size:
            middle = (low[undecided] + high[undecided]) // 2
            pins = self.off(side, places[middle], own[undecided], 1) > ROUNDING
            high[undecided] = np.where(pins, middle, high[undecided])
            low[undecided] = np.where(pins, low[undecided], middle + 1)
        return low

    def _outwards(
        self, side: int, own: Indices, start: Array, level: Array, value: Array
    ) -> tuple[Brackets, Mask]:
        """Brackets of where D is a level, found by going outwards in growing steps.

        Parameters
        ----------
        side : {1, -1}
            1 for right lines.
        own : ndarray of int (m,)
            Numbers of their states.
        start, level : ndarray (m,)
            Where to begin, and the depths that D is to reach [length].
        value : ndarray (m,)
            (D - level)/size at the start, not positive.

        Returns
        -------
        brackets : Brackets (m,)
            With (D - level)/size.
        gone : ndarray of bool (m,)
            Where the known profile ends before.
        """
        inner = start.copy()
        outer = start.copy()
        low = value.copy()
        high = value.copy()
        limit = float(self.contact.scene.indenter.extent[0 if side < 0 else 1])
        gone = np.zeros(own.size, bool)
        span = self.step[own].copy()
        left = np.arange(own.size)
        while left.size:
            x = side * np.minimum(side * (start[left] + side * span[left]), side * limit)
            rest = self.rest_depth(side, x, own[left])
            found = (rest - level[left]) / self.size[own[left]]
            outer[left] = x
            high[left] = found
            below = ~(found > 0)  # nan, beyond what a profile gives, counts as not reached
            left = left[below]
            x = x[below]
            inner[left] = x
            low[left] = found[below]
            span[left] *= _BRACKET.farther
            ended = (x == limit) | ~np.isfinite(span[left])
            gone[left[ended]] = True
            left = left[~ended]
        return Brackets(inner, outer, low, high), gone

    def _root(self, side: int, own: Indices, inner: Array, outer: Array) -> Array:
        """Where D = d between two places (m,), D < d at the inner one and D > d at the outer."""
        if not own.size:
            return inner
        at_inner = self.off(side, inner, own)
        at_outer = self.off(side, outer, own)
        return self._root_between(side, own, Brackets(inner, outer, at_inner, at_outer))

    def _root_between(self, side: int, own: Indices, brackets: Brackets) -> Array:
        """Where D = d in brackets (m,) of the states `own`, to rounding [length].

        The brackets are narrowed first; then secants start from the straight line through their
        ends.
        """
        if not own.size:
            return brackets.inner
        inner, outer, low, high = self._narrowed(side, own, brackets)
        width = outer - inner
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            rise = (high - low) / width
            guess = inner - low / rise
        # The first guess is the zero of the secant; where that is no place between, the middle.
        usable = np.isfinite(rise) & (rise * side > 0)
        usable &= (side * guess > side * inner) & (side * guess < side * outer)
        guess = np.where(usable, guess, (inner + outer) / 2)
        with np.errstate(divide="ignore"):
            rise = np.where(usable, rise, side / np.abs(width))

        def off(x: Array, which: Indices) -> Array:
            """(D - d)/size at x for these numbers of `own`."""
            return self.off(side, x, own[which])

        first = np.minimum(inner, outer)
        last = np.maximum(inner, outer)
        return crossings(off, first, last, guess, rise, 0.0)

    def _narrowed(self, side: int, own: Indices, brackets: Brackets) -> Brackets:
        """Brackets halved until D is of the size of depths at both ends.

        Secants from where a profile such as x¹⁰⁰ has risen by orders of magnitude would not move.

        side: 1 for right lines; own: numbers of the states of the brackets (m,).
        """
        narrowed = brackets.copied()
        inner, outer, low, high = narrowed
        steep = np.flatnonzero(~(high <= _BRACKET.steep))
        for _ in range(MOST_STEPS):
            if not steep.size:
                break
            middle = (inner[steep] + outer[steep]) / 2
            value = self.off(side, middle, own[steep])
            above = value > 0
            outer[steep[above]] = middle[above]
            high[steep[above]] = value[above]
            inner[steep[~above]] = middle[~above]
            low[steep[~above]] = value[~above]
            steep = steep[~(high[steep] <= _BRACKET.steep)]
        return narrowed

    def _pulled(self, side: int, own: Indices) -> tuple[Array, Mask]:
        """Lines about an axis at depths less than that of touching, nan where contact is lost.

        D falls from the depth of touching at the axis to its least and grows from there on: the
        line rests in the growing part. At an edge of the body it is pinned. The search goes
        outwards to where D exceeds the depth of touching, and from there inwards to where it is
        less than d.

        Returns
        -------
        x : ndarray (m,)
            Radii [length].
        lost : ndarray of bool (m,)
            Which lines leave the known profile.
        """
        found = np.full(own.size, math.nan)
        edges = self._places(side)[1:]
        if edges.size:  # of these shapes only a flat punch has one: D falls up to it
            edge = np.full(own.size, edges[-1])
            pinned = self.off(side, edge, own, -1) <= ROUNDING
            found[pinned] = edge[pinned]
            return found, np.zeros(own.size, bool)
        touch = np.full(own.size, self.contact.touch)
        axis = np.zeros(own.size)
        at_axis = np.zeros(own.size)  # D is the depth of touching there
        above_touch, lost = self._outwards(side, own, axis, touch, at_axis)
        # (D - d)/size where (D - touch)/size is known.
        high = above_touch.at_outer + (touch - self.goal[own]) / self.size[own]
        brackets = self._below(side, own, above_touch.outer, high)
        rests = ~np.isnan(brackets.inner) & ~lost
        at_least = rests & (brackets.at_inner > 0)  # the least D is d, to rounding
        found[at_least] = brackets.inner[at_least]
        free = np.flatnonzero(rests & ~at_least)
        found[free] = self._root_between(side, own[free], brackets.of(free))
        return found, lost

    def _below(self, side: int, own: Indices, outer: Array, high: Array) -> Brackets:
        """Brackets of pulled lines about an axis, from outer radii inwards.

        D is read in log r, at ever closer places around its least value (as
        `roots.bracketed_minimum` does), until D at one of them is not more than d.

        Parameters
        ----------
        outer, high : ndarray (m,)
            Where D exceeds the depth of touching [length], and (D - d)/size there.

        Returns
        -------
        Brackets (m,)
            The inner place is nan where D is nowhere as little as d: contact is lost. (D - d)/size
            there is positive, by no more than rounding, where d is the least D.
        """
        inner = np.full(own.size, math.nan)
        low = np.full(own.size, math.nan)
        search = _LeastSearch.inwards(outer, high)
        outer = outer.copy()
        high = high.copy()
        left = np.arange(own.size)
        for _ in range(NARROWINGS):
            powers, x = search.places(left)
            value = self.off(side, x, own[left])
            least = value.argmin(axis=1)
            lowest = value[np.arange(left.size), least]
            below = lowest <= ROUNDING
            # The outermost place with D <= d, or that of the least D where this is d to rounding.
            reached = np.where(lowest <= 0, (value <= 0).argmax(axis=1), least)

            # The place before the one that was reached is on the other side of the line.
            hit = left[below]
            at = reached[below]
            before = np.maximum(at - 1, 0)
            inner[hit] = x[below, at]
            low[hit] = value[below, at]
            outer[hit] = np.where(at > 0, x[below, before], search.outer[hit])
            high[hit] = np.where(at > 0, value[below, before], search.at_outer[hit])

            left = left[~below]
            if not left.size:
                break
            search.narrow(left, powers[~below], x[~below], value[~below])
        return Brackets(inner, outer, low, high)


@dataclass(eq=False)
class _LeastSearch:
    """Where the least D about an axis is looked for, at radii e⁻ᵗ of a given one, t the power.

    Attributes
    ----------
    start : ndarray (n,)
        The given radii, at t = 0 [length].
    first, last : ndarray (n,)
        The powers t between which it is; larger ones are nearer to the axis.
    outer, at_outer : ndarray (n,)
        The place of the first power, and (D - d)/size there.
    """

    start: Array
    first: Array
    last: Array
    outer: Array
    at_outer: Array

    @classmethod
    def inwards(cls, start: Array, value: Array) -> _LeastSearch:
        """The search from radii with these (D - d)/size almost to the axis."""
        first = np.zeros(start.size)
        last = np.full(start.size, DEEPEST_POWER)
        return cls(start, first, last, start.copy(), value.copy())

    def places(self, own: Indices) -> tuple[Array, Array]:
        """Seven evenly spaced powers between `first` and `last`, and their radii, both (m, 7)."""
        first = self.first[own, None]
        powers = first + (self.last - self.first)[own, None] * EIGHTHS
        return powers, self.start[own, None] * np.exp(-powers)

    def narrow(self, own: Indices, powers: Array, x: Array, value: Array) -> None:
        """Keep the interval between both neighbours of the place of the least value.

        own: numbers of the searches; powers, x and value (m, 7): as of `places`, with (D - d)/size.
        """
        least = value.argmin(axis=1)
        rows = np.arange(own.size)
        before = np.maximum(least - 1, 0)
        after = np.minimum(least + 1, EIGHTHS.size - 1)
        is_first = least == 0
        is_last = least + 1 == EIGHTHS.size
        self.first[own] = np.where(is_first, self.first[own], powers[rows, before])
        self.outer[own] = np.where(is_first, self.outer[own], x[rows, before])
        self.at_outer[own] = np.where(is_first, self.at_outer[own], value[rows, before])
        self.last[own] = np.where(is_last, self.last[own], powers[rows, after])
