"""The lines of a contact where there can be no other, at a depth and on the way to another.

A line advances where the depth D at which it would be at rest (../surfaces) is less than the depth
d, and recedes where it is greater. Of a convex indenter D grows outwards of a line contact, so that
there is one place where it rests; at a corner D may jump past d and hold the line.
About an axis D falls from the depth of touching to its least value and grows from there on, for
the shapes of routes.UNIMODAL: where the depth is less than that of touching, the line rests in
the growing part. There D = f + l f' q - δ₀ q with q = 1/S, S(s) the stiffness beside a radius of
s = a/l, and

    dD/ds = (q' / l) {[l f' + l² f'' q]/q' + l f' - δ₀}    (f', f'' by x),

in which f', f'' q and 1/q' grow with s, so that the brace changes sign once.

So a line has one place at every depth of a way: nothing happens on it but at its end, where a line
comes to a corner or comes free of one, or the contact is lost.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from discretization.certificate import ROUNDING, NotCertifiedError
from discretization.fitted.rest_depths import TIE, surfaces_of
from discretization.roots import bracketed, crossings, least
from discretization.surfaces.protocol import At, Free, Surfaces
from energy import Indenter, Scene
from energy.arrays import Array, Indices, Mask

_NEUTRAL = ROUNDING  # of D - d where moving a line costs nothing
_LOST = 5e-15  # of the size of depths: so much earlier a contact is lost, D is not known better
_KNOWN = 1e-16  # of the size of depths: a D - d that is rounding; a line need not be known better
_NEAR = 1e-11  # of the same: D - d of lines that are read next to where they disappear
_DEEP = 30.0  # as far inwards the least D about an axis is looked for, in powers of e


@dataclass(frozen=True, eq=False)
class Alone:
    """The one contact of a scene; touch: the depth at which it begins, at x = apex."""

    scene: Scene
    surfaces: Surfaces
    apex: float
    touch: float

    @classmethod
    def of(cls, scene: Scene) -> Alone:
        """With the free surfaces of the scene."""
        apex = scene.indenter.apex
        if apex is None:
            apex = lowest_point(scene.indenter, scene.elastocapillary_length)
        return cls(scene, surfaces_of(scene), apex, float(scene.indenter.height(apex)))

    @property
    def sides(self) -> tuple[int, ...]:
        """Of the left and the right line; about an axis there is one line."""
        return (1,) if self.scene.axisymmetric else (-1, 1)

    def size(self, *depths: float) -> float:
        """A displacement to measure others by: the largest of these depths, and δ₀."""
        return max(map(abs, depths)) + self.scene.opened.critical_separation

    def rest_depth(
        self, side: Any, x: Any, beside: Any = None, *, way: int = 1, adhesive: Any = True
    ) -> Any:
        """D of a line at x that advances (way 1) or recedes (-1); or D₀ without adhesion.

        beside: just outwards (1) or inwards (-1) of x, which differ at a corner; beyond the edge of
        a body D is infinite.
        """
        scene, indenter = self.scene if way > 0 else self.scene.opened, self.scene.indenter
        beyond = indenter.slope(x) if beside is None else indenter.slope_beside(x, side * beside)
        w = scene.work_of_adhesion * adhesive
        found = self.surfaces.rest_depth(side, x, indenter.height(x), beyond, None, w)
        if beside is None or not indenter.walls:
            return found
        end = np.where(np.greater(side, 0), *indenter.extent[::-1])
        edge = np.isin(x, indenter.walls) & np.equal(x, end) & np.greater(beside, 0)
        return np.where(edge, math.inf, found)

    def solve(self, side: int, x: float, depth: float) -> Free:
        """The free surface beyond a line. ValueError where it would turn over."""
        line = At(x, float(self.scene.indenter.height(x)))
        left, right = (line, None) if side > 0 else (None, line)
        return self.surfaces.solve(left, right, depth)

    def lines(self, depth: float) -> tuple[float, ...]:
        """Both ends of the contact, 0 at the axis; () where it has let go."""
        right, body = self.find(1, depth), self.scene.indenter
        if self.scene.axisymmetric:
            left = 0.0
        else:
            left = -right if body.symmetric and not body.apex else self.find(-1, depth)
        held = left < right or (left == right and depth >= self.touch)
        return (left, right) if held else ()

    @functools.cached_property
    def lowest(self) -> dict[int, tuple[float, float]]:
        """For both ways the innermost place where a line may rest, and D there.

        At that depth the contact is lost. About an axis it is the least D.
        """
        receding = self._lowest(-1)
        return {-1: receding, 1: self._lowest(1) if self.scene.hysteretic else receding}

    def _lowest(self, way: int) -> tuple[float, float]:
        """The same for one way, about an axis by golden sections in log r."""
        if not self.scene.axisymmetric:
            ahead = self.rest_depth(np.array(self.sides), self.apex, 1, way=way)
            return self.apex, min(self.touch, *ahead.tolist())
        outer = self.find(1, self.touch, way)
        if not outer:
            return 0.0, self.touch
        last = float(self.rest_depth(1, outer, -1, way=way))
        deep, value = least(lambda t: self.rest_depth(1, outer * math.exp(-t), way=way), 0.0, _DEEP)
        places = (outer * math.exp(-deep), float(value)), (outer, last), (0.0, self.touch)
        return min(places, key=lambda found: found[1])

    def find(self, side: int, depth: float, way: int = 1) -> float:
        """A line outwards of the innermost place, which it is itself where nothing beyond holds.

        nan about an axis where it rests nowhere.
        """
        start = self.apex
        if self.scene.axisymmetric and depth < self.touch:
            start, low = self.lowest[way]
            if low > depth:
                return math.nan

        @functools.cache
        def h(x: float, beside: int | None = None) -> float:
            return float(self.rest_depth(side, x, beside, way=way)) - depth

        places = np.append(start, self.corners(side, start))
        beyond = self.rest_depth(side, places, 1, way=way) - depth
        tie = _NEUTRAL * self.size(depth, self.touch)
        for inside, x, held in zip([start, *places], places.tolist(), beyond > tie, strict=False):
            if held:
                return bracketed(h, float(inside), x) if inside != x and h(x, -1) > tie else x
        last = float(places[-1])
        return last if beyond[-1] >= 0 else bracketed(h, *self._around(h, side, last, depth))

    def corners(self, side: int, start: float) -> Array:
        """Of the indenter, outwards of a place."""
        corners = np.asarray(self.scene.indenter.corners, float)[::side]
        return np.asarray(corners[side * corners > side * start])

    def _around(
        self, h: Callable[[float], float], side: int, start: float, depth: float
    ) -> tuple[float, float]:
        """Points on both sides of a line, or ValueError where the known profile ends before it."""
        indenter, finite = self.scene.indenter, self.scene.slopes == "finite"
        x, limit = start, indenter.extent[0 if side < 0 else 1]
        for inside, x in _further(start, side * self.scene.elastocapillary_length, limit):
            if h(x) > 0:
                return inside, x
            if finite and depth < indenter.height(x):  # pulled up, and further out even more
                self.solve(side, x, depth)
        raise ValueError(
            f"depth = {depth!r} spreads the contact to x = {x!r}, where the profile is not known "
            "any more; give a wider profile, a smaller depth, or add a FlatPunch whose edge ends "
            "the indenter there"
        )


def _further(start: float, step: float, limit: float) -> Iterator[tuple[float, float]]:
    """Intervals from a place on, each to four times as far from it, up to a limit."""
    x, side = start, math.copysign(1.0, step)
    while x != limit and math.isfinite(step):
        inside, x = x, side * min(side * (start + step), side * limit)
        yield inside, x
        step *= 4


def lowest_point(indenter: Indenter, size: float) -> float:
    """Where the slope of a convex profile changes sign, or the end of its extent it falls to."""
    start = min(max(0.0, indenter.extent[0]), indenter.extent[1])
    side = 1 if indenter.slope(start) < 0 else -1
    x, limit = start, indenter.extent[0 if side < 0 else 1]

    def rise(z: float) -> float:
        return side * float(indenter.slope(z))

    for _, x in _further(start, side * size, limit) if rise(start) else ():
        if rise(x) >= 0:
            break
    if not math.isfinite(x) or abs(x - start) > 1e30 * size:
        raise ValueError(f"indenter = {indenter!r} has no lowest point; give it a finite extent")
    if rise(x) > 0 and x != start:
        x = bracketed(rise, start, x)
    corners = np.asarray(indenter.corners, float)
    near = corners[np.abs(corners - x) <= 1e-12 * size].tolist()
    return min([*near, x], key=lambda z: float(indenter.height(z)))


@dataclass(frozen=True, eq=False)
class LoneTrack:
    """The lines of the contact at the start of a way and at its end.

    lost: whether the contact is lost at the end.
    """

    alone: Alone
    way: int
    depths: tuple[float, float]
    first: Array
    last: Array
    lost: bool = False

    @classmethod
    def of(
        cls, alone: Alone, lines: tuple[float, ...], start: float, end: float
    ) -> LoneTrack | None:
        """The way towards a depth up to its first event; None where that is a jump of a line."""
        way, first = (1 if end >= start else -1), np.array(lines[-len(alone.sides) :])
        sides, size, lost = np.array(alone.sides), alone.size(start, end), False
        ahead = alone.rest_depth(sides, first, way, way=way)
        (place, low), axis = alone.lowest[way], alone.scene.axisymmetric
        if axis and way > 0 and first[0] < place:
            return None
        held, coming = way * (ahead - start) > TIE * size, way * ahead
        if way < 0:
            if lines[0] == lines[1]:  # a tip lets go where it is pulled
                low, held = alone.touch, np.ones_like(held)
            elif axis and first[0] <= place:
                low = float(ahead[0])
            early = (ahead > low + TIE * size) & (lines[0] < lines[1])
            coming = np.where(early, coming, math.inf)
        end = way * float(min(way * end, coming[held].min(initial=math.inf)))
        if way < 0 and low - end > (TIE if held.any() else -_LOST) * size:
            end, lost = min(low + _LOST * size, start), True
        return cls(alone, way, (start, end), first, first, lost)._moved(~held)

    def _moved(self, moves: Mask) -> LoneTrack:
        """With the lines that move at the end, which is no further than the next corner."""
        (start, end), last, stops = self.depths, self.first.copy(), [(math.inf, -1, math.nan)]
        for i in (own := np.flatnonzero(moves).tolist()):
            side = self.alone.sides[i] * self.way
            passed = self.alone.corners(side, float(self.first[i]))
            passed = passed[side * passed <= side * self._place(i, end)]
            rest = self.alone.rest_depth(self.alone.sides[i], passed, -self.way, way=self.way)
            later, tie = self.way * (rest - start), TIE * self.alone.size(start, end)
            stops += [(later[k], i, passed[k]) for k in np.flatnonzero(later > tie)[:1]]
        first_zero, stopped, corner = min(stops)
        end = self.way * float(min(self.way * end, self.way * start + first_zero))
        for i in own:
            last[i] = corner if i == stopped else self._place(i, end)
        lost = self.lost and end == self.depths[1]
        return replace(self, depths=(start, end), last=last, lost=lost)

    def _place(self, i: int, depth: float) -> float:
        """Where a line that moves is at a depth."""
        side, first = self.alone.sides[i], float(self.first[i])
        found = self.alone.find(side, depth, self.way)
        return side * self.way * max(side * self.way * first, side * self.way * found)

    @property
    def ends(self) -> tuple[float, float]:
        """Both ends of the contact at the end of the way; 0 at the axis."""
        left, right = [0.0, *self.last.tolist()][-2:]
        return left, right

    def at(self, depths: Array) -> Array:
        """The lines (k, 2) at depths on the way; 0 at the axis."""
        sides, found = np.array(self.alone.sides), np.zeros((depths.size, 2))
        found[:, -sides.size :] = self.first
        moves = np.flatnonzero(self.first != self.last)
        line, goal = np.repeat(moves, depths.size), np.tile(depths, moves.size)
        start, end = self.first[line], self.last[line]

        def off(x: Array, own: Indices) -> Array:
            beside = np.where(x == end[own], -self.way, self.way)
            rest = self.alone.rest_depth(sides[line[own]], x, beside, way=self.way)
            return np.asarray(rest - goal[own])

        span = self.depths[1] - self.depths[0]
        guess, rise = start + (end - start) * ((goal - self.depths[0]) / span), span / (end - start)
        x, own = end.copy(), np.flatnonzero(self.way * off(end, np.arange(end.size)) > 0)
        lo, hi = np.minimum(start, end)[own], np.maximum(start, end)[own]
        enough = _KNOWN * self.alone.size(*self.depths)
        x[own] = crossings(lambda z, k: off(z, own[k]), lo, hi, guess[own], rise[own], enough)
        if (np.abs(off(x[own], own)) > _NEAR * self.alone.size(*self.depths)).any():
            raise NotCertifiedError(
                f"the contact between depth = {self.depths[0]!r} and {self.depths[1]!r} does not "
                "come to rest; try other depths, or method='lattice'"
            )
        found[:, moves - sides.size] = x.reshape(moves.size, depths.size).T
        return found
