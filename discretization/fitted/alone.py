"""The lines of a contact where there can be no other.

A line advances where the depth D at which it would be at rest (../surfaces) is less than the depth
d, and recedes where it is greater. Of a convex indenter D grows outwards of a line contact, so that
there is one place where it rests; at a corner D may jump past d and hold the line. About an axis D
falls from the depth of touching to its least value and grows from there on, for the shapes of
routes.UNIMODAL: where the depth is less than that of touching, the line rests in the growing part.
There D = f + l f' q - δ₀ q with q = 1/S, S(s) the stiffness beside a radius of s = a/l, and

    dD/ds = (q' / l) {[l f' + l² f'' q]/q' + l f' - δ₀}    (f', f'' by x),

in which f', f'' q and 1/q' grow with s, so that the brace changes sign once.

Beside an apex that is all but a tip, f = c |x|ⁿ with n next to 1, a line may rest 10⁻¹⁰⁰ l from it.
There it is looked for in log |x|. Nearer than doubles resolve D jumps past d at the apex itself:
the contact is that one point, P = 2kl (d - f), and holds like a wider one as long as D there, where
f' = 0, is not above d.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import ROUNDING
from discretization.fitted.line_search import Pair
from discretization.fitted.rest_depths import DIFFERENCE, FELT, FLAT, LEAST, ULPS, surfaces_of
from discretization.profile import past_wall, unknown
from discretization.roots import bracketed, least
from discretization.surfaces.protocol import At, Felt, Free, Surfaces
from energy import Indenter, Scene

_NEUTRAL = ROUNDING  # of D - d where moving a line costs nothing
_TIP = 2.0**-1000  # beside an apex at 0, in any unit: nearer to it doubles lose digits
_ROUNDED = 1e-6  # of the slope beside the apex: by less it does not fall towards 0, but is a kink
_RESTS = 1e-11  # of the size of depths: D - d of a line that has been found
_NARROW = 8 * DIFFERENCE  # of l: contacts as narrow as the steps of a difference
_TOUCHING = 2.0**-100  # of LEAST: beside the axis D is next to nothing whether a line rests or not
_DEEP = 30.0  # as far inwards the least D about an axis is looked for, in powers of e
_BESIDE = np.array([[1], [1], [-1], [0], [0], [0], [0]])  # on which side D judges a line


@dataclass(frozen=True, eq=False)
class Alone:
    """The one contact of a scene; touch: the depth at which it begins, at x = apex.

    sides: of the left and the right line; about an axis there is one.
    """

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

    profile = None  # it needs no samples
    sides = property(lambda self: (1,) if self.scene.axisymmetric else (-1, 1))

    def size(self, *depths: float) -> float:
        """A displacement to measure others by: the largest of these depths, and δ₀."""
        return max(map(abs, depths)) + self.scene.critical_separation

    def rest_depth(self, side: Any, x: Any, beside: Any = None, work: Any = None) -> Any:
        """D of a line at x, with another work of adhesion than that of a contact that closes.

        beside: outwards (1) or inwards (-1) of x, unlike at corners; beyond an edge D is infinite.
        """
        scene, indenter = self.scene, self.scene.indenter
        beyond = indenter.slope(x) if beside is None else indenter.slope_beside(x, side * beside)
        w = scene.work_of_adhesion if work is None else work
        found = self.surfaces.rest_depth(side, x, indenter.height(x), beyond, None, w)
        if beside is None or not indenter.walls:
            return found
        return np.where(past_wall(indenter, x, side, beside), np.copysign(math.inf, beside), found)

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
        if left == right and depth < self.touch:
            held = self.pointed(left) and float(self.rest_depth(1, left)) < depth
        else:
            held = left <= right
        return (left, right) if held else ()

    def pointed(self, x: float) -> bool:
        """Whether a contact of the one point x stands for one too narrow for doubles."""
        return x == self.apex and self.tip > 0

    @functools.cached_property
    def tip(self) -> float:
        """Distance from the apex at which a line is last told from it; 0: lines get there.

        At a corner, about an axis, and where the slope no longer changes towards the apex, as at a
        kink nobody declared, there is no such place either.
        """
        scene, indenter, apex = self.scene, self.scene.indenter, self.apex
        least = max(_TIP, ULPS * math.ulp(apex)) if apex else _TIP
        if scene.axisymmetric or apex in indenter.corners or apex in indenter.extent:
            return 0.0
        sides = np.array(self.sides)
        middle = max(least, math.sqrt(least * LEAST * scene.elastocapillary_length))
        near = sides * indenter.slope(apex + sides * least)
        far = sides * indenter.slope(apex + sides * middle)
        return least if (near < (1 - _ROUNDED) * far).all() else 0.0

    def felt(self, lines: Sequence[float], depth: float) -> list[Felt]:
        """What judges both lines, or the one about an axis; held are those at corners, and there.

        The terms of D - d are d, f, and what f' and w add to D.
        """
        scene, sides, length = self.scene, np.array(self.sides), self.scene.elastocapillary_length
        x, w = np.array(lines)[-sides.size :], scene.work_of_adhesion
        known = np.array([-math.inf, *scene.indenter.corners, math.inf])
        first, after = known.searchsorted(x), known.searchsorted(x, "right")
        loose, near = (first == after) & ((x != 0) | (sides.size > 1)), np.spacing(np.abs(x))
        span = np.minimum(np.maximum(x, LEAST * length), length) if scene.axisymmetric else length
        off, step = ULPS * near * loose * sides, np.maximum(DIFFERENCE * span, FELT * near)
        beyond = off
        if lines[1] - lines[0] <= _NARROW * length:
            # no difference looks beyond the apex, at which a contact of one point is held
            step = np.where(x == self.apex, step, np.minimum(step, np.abs(x - self.apex) / 2))
            if lines[0] == lines[1] and self.pointed(lines[0]):
                loose, beyond = np.zeros_like(loose), self.tip * sides
        ends = np.clip([x + step, x - step], (x + known[first - 1]) / 2, (x + known[after]) / 2)
        z = np.clip([x + beyond, x + beyond, x - off, x, x, *ends], *scene.indenter.extent)
        works = np.array([w, 0.0, scene.opened.work_of_adhesion, w, 0.0, w, w])[:, None]
        closing, bare, behind, *rest = self.rest_depth(sides, z, _BESIDE, works)
        f, (there, free, one, other) = np.asarray(scene.indenter.height(x), float), rest
        if lines[0] == lines[1]:
            behind -= math.inf
        size = abs(depth) + np.abs(f) + np.abs(free - f) + np.abs(free - there)
        rate = (one - other) * sides / np.where(z[5] > z[6], z[5] - z[6], math.inf)
        with np.errstate(divide="ignore"):
            moved = 1 / np.abs(rate)
        firm = ~loose | (rate + FLAT * size / span > 0)
        rows = np.array([x, loose, closing, bare, behind, size, moved, firm]).T.tolist()
        return [Felt(*row) for row in rows]

    def opening(self, lines: tuple[float, ...], depth: float) -> list[float]:
        """Forces that would open a contact without adhesion: -kg at an end, as f'' >= 0."""
        scene, f = self.scene, np.asarray(self.scene.indenter.height(np.array(lines)), float)
        unit = scene.stiffness * scene.elastocapillary_length
        return [] if scene.opened.work_of_adhesion else (unit * (f - depth)).tolist()

    def penetration(self, lines: tuple[float, ...], depth: float) -> float:
        """How far the profile sticks through; not beside a contact, as u' + f' grows outwards."""
        return 0.0 if lines else max(0.0, depth - self.touch)

    @functools.cached_property
    def lowest(self) -> tuple[float, float]:
        """The innermost place where a line may rest, and D there: at that depth contact is lost.

        About an axis it is the least D, looked for in log r.
        """
        if not self.scene.axisymmetric:
            ahead = self.rest_depth(np.array(self.sides), self.apex, 1)
            return self.apex, min(self.touch, *ahead.tolist())
        outer = self.find(1, self.touch)
        if not outer:
            return 0.0, self.touch
        last = float(self.rest_depth(1, outer, -1))
        deep, value = least(lambda t: self.rest_depth(1, outer * np.exp(-t)), 0.0, _DEEP, -math.inf)
        places = (outer * math.exp(-deep), value), (outer, last), (0.0, self.touch)
        return min(places, key=lambda found: found[1])

    def find(self, side: int, depth: float) -> float:
        """A line outwards of the innermost place, which it is itself where nothing beyond holds.

        nan about an axis where it rests nowhere.
        """
        start = self.apex
        if self.scene.axisymmetric and depth < self.touch:
            start, low = self.lowest
            if low > depth:
                return math.nan

        @functools.cache
        def h(x: float, beside: int | None = None) -> float:
            return float(self.rest_depth(side, x, beside)) - depth

        corners = [float(x) for x in self.scene.indenter.corners if side * x > side * start]
        places = [start, *corners[::side]]
        beyond = self.rest_depth(side, np.array(places) if corners else start, 1) - depth
        tie, beyond = _NEUTRAL * self.size(depth, self.touch), np.atleast_1d(beyond)
        for inside, x, held in zip([start, *places], places, beyond > tie, strict=False):
            if held:
                return bracketed(h, inside, x) if inside != x and h(x, -1) > tie else x
        last = places[-1]
        if beyond[-1] >= 0:
            return last
        found = bracketed(h, *self._around(h, side, last, depth))
        near = LEAST * self.scene.elastocapillary_length
        if last != self.apex or abs(found - last) > near:
            return found
        at_rest = abs(h(found)) <= _RESTS * self.size(depth, self.touch)
        if at_rest and not (self.scene.axisymmetric and found < _TOUCHING * near):
            return found
        return self._beside_apex(h, side, found)

    def _beside_apex(self, h: Callable[[float], float], side: int, found: float) -> float:
        """A line so near to the apex that its distance is found by its logarithm; or the apex.

        found: by the distance itself, if this does not find it.
        """
        apex, tip = self.apex, _TIP if self.scene.axisymmetric else self.tip
        if not tip:
            return found
        if h(apex + side * tip) >= 0:
            return apex
        ends = math.log(tip), math.log(LEAST * self.scene.elastocapillary_length)
        return apex + side * math.exp(bracketed(lambda t: h(apex + side * math.exp(t)), *ends))

    def _around(self, h: Callable[[float], float], side: int, start: float, depth: float) -> Pair:
        """Points on both sides of a line, or ValueError where the known profile ends before it."""
        indenter, finite = self.scene.indenter, self.scene.slopes == "finite"
        x, limit = start, indenter.extent[0 if side < 0 else 1]
        for inside, x in _further(start, side * self.scene.elastocapillary_length, limit):
            if h(x) > 0:
                return inside, x
            if finite and depth < indenter.height(x):  # pulled up, and further out even more
                self.solve(side, x, depth)
        raise unknown(depth, x)


def _further(start: float, step: float, limit: float) -> Iterator[Pair]:
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

    if rise(start):
        x = next((x for _, x in _further(start, side * size, limit) if rise(x) >= 0), limit)
    if not math.isfinite(x) or abs(x - start) > 1e30 * size:
        raise ValueError(f"indenter = {indenter!r} has no lowest point; give it a finite extent")
    if rise(x) > 0 and x != start:
        x = bracketed(rise, start, x)
    corners = np.asarray(indenter.corners, float)
    near = corners[np.abs(corners - x) <= 1e-12 * size].tolist()
    return min([*near, x], key=lambda z: float(indenter.height(z)))
