"""The lines of one contact of a convex indenter: sign changes of D - d, found by bracketing.

A line advances where the depth D at which it would be at rest (../surfaces) is less than the depth
d, and recedes where it is greater. Of a convex indenter D grows outwards of a line contact, so that
there is one place where it rests; at a corner D may jump past d and pin the line.
About an axis D falls from the depth of touching to its least value and grows from there on, for
the shapes of routes.UNIMODAL: where the depth is less than that of touching, the line rests in
the growing part. There D = f + l f' q - δ₀ q with q = 1/S, S(s) the stiffness beside a radius of
s = a/l, and

    dD/ds = (q' / l) {[l f' + l² f'' q]/q' + l f' - δ₀}    (f', f'' by x),

in which f', f'' q and 1/q' grow with s, so that the brace changes sign once.
"""

from __future__ import annotations

import bisect
import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.roots import bracketed, least
from discretization.rounding import ROUNDING
from discretization.surfaces.finite_range import OVERHANG
from discretization.surfaces.meniscus_surfaces import MeniscusSurfaces
from discretization.surfaces.protocol import At, Surfaces
from energy import Indenter, Scene

Array = NDArray[np.float64]
_TIE = ROUNDING  # a line's shortfall where moving it costs nothing
_UPRIGHT = 2e-8  # so close to turning over no double resolves the slope
_FEW_CORNERS = 8  # up to here one by one, more by halving
_HALVINGS = 64  # to the spacing of floating-point numbers
_STEP = 1e-4  # of l and of the position: the difference for a rate is good to its square


class FittedLine(NamedTuple):
    """A contact line at x; pinned by a corner; neutral if moving it costs nothing."""

    x: float
    pinned: bool
    neutral: bool


AXIS = FittedLine(0.0, True, False)  # where a contact about an axis ends on its other side


@dataclass(frozen=True, eq=False)
class Problem:
    """A scene at a depth with its free surfaces; touch: depth at which contact begins."""

    scene: Scene
    depth: float
    touch: float
    surfaces: Surfaces

    @property
    def lift(self) -> float:
        """A displacement of the scene to measure others by."""
        return max(abs(self.depth), self.scene.critical_separation) or 1.0

    def displaced(self, x: float) -> float:
        """g(x) = d - f(x)."""
        return self.depth - float(self.scene.indenter.height(x))

    def refuse_overhang(self, x: float) -> None:
        """ValueError if a line at x would incline the surface by more than π/2.

        Or, about an axis, by more than the family of its surfaces has.
        """
        scene, limit = self.scene, OVERHANG * (1 - _UPRIGHT) * self.scene.elastocapillary_length
        if isinstance(self.surfaces, MeniscusSurfaces):
            if x:
                self.surfaces.refuse(1, At(x, float(scene.indenter.height(x))), self.depth)
        elif limit and scene.slopes == "finite" and abs(self.displaced(x)) >= limit:
            raise ValueError(
                f"depth = {self.depth!r}: at the contact line x = {x!r} the surface is displaced "
                f"by {self.displaced(x)!r}, more than √2 l = {limit!r}; it would turn over and is "
                "no graph u(x); use a smaller |depth|, a smaller w or a blunter indenter"
            )

    def shortfall(self, side: int, x: float, beside: int = 0, adhesive: bool = True) -> float:
        """D - d of a line at x, or D₀ - d without adhesion; where it is negative it advances.

        beside: which slope of a corner counts, that on the outer (1) or the inner side (-1).
        """
        scene, indenter = self.scene, self.scene.indenter
        f = float(indenter.height(x))
        f1 = float(indenter.slope_beside(x, side * beside) if beside else indenter.slope(x))
        w = scene.work_of_adhesion
        rest = self.surfaces.rest_depth(side, x, f, f1, None, w if adhesive else 0.0)
        return float(rest) - self.depth

    def distinct(
        self, ends: tuple[FittedLine, FittedLine]
    ) -> tuple[tuple[int, FittedLine, int], ...]:
        """(side, line, how many like it): of a mirrored contact one line speaks for both."""
        indenter, (left, right) = self.scene.indenter, ends
        if self.scene.axisymmetric:
            return ((1, right, 1),)
        if indenter.symmetric and left.x == mirrored(indenter, right.x):
            return ((1, right, 2),)
        return (-1, left, 1), (1, right, 1)

    def scale(self, ends: tuple[FittedLine, FittedLine]) -> float:
        """Size of the terms that cancel in `shortfall`: |d|, δ₀ and l |f'|."""
        scene, lines = self.scene, self.distinct(ends)
        g = max(abs(self.displaced(end.x)) for _, end, _ in lines)
        steepest = 0.0
        for side, end, _ in lines:
            slope = float(scene.indenter.slope_beside(end.x, -side))
            steepest = max(steepest, abs(slope))
        if scene.slopes == "finite":
            steepest /= math.hypot(1.0, steepest)
        return self.lift + g + scene.elastocapillary_length * steepest

    def terms(self, side: int, x: float) -> float:
        """Sum of the terms that cancel in `shortfall`: d, f, and what f' and w add to D."""
        indenter, rest = self.scene.indenter, self.surfaces.rest_depth
        sloped = rest(side, x, 0.0, float(indenter.slope(x)), None, 0.0)
        lifted = rest(side, x, 0.0, 0.0, None, self.scene.work_of_adhesion)
        f = float(indenter.height(x))
        return abs(self.depth) + abs(f) + abs(float(sloped)) + abs(float(lifted))

    def imbalance(self, side: int, x: float) -> float:
        """Residual of the free surface beyond a line."""
        line = At(x, float(self.scene.indenter.height(x)))
        left, right = (line, None) if side > 0 else (None, line)
        return self.surfaces.free(left, right, self.depth).residual

    def force_rate(self, side: int, x: float) -> float:
        """dP/dq of one line at fixed depth: k g, and the change of the free surface's pull.

        By a short step beside where the profile ends: it may turn over there.
        """
        scene, g = self.scene, self.displaced(x)
        pressed = scene.stiffness * g * float(scene.measure(x))
        room = abs(scene.indenter.extent[0 if side < 0 else 1] - x)
        size = min(scene.elastocapillary_length, abs(x) or math.inf)
        h = _STEP * max(min(size, room), _STEP * size)
        ends = x - side * h, x + side * min(h, room)
        lines = At(np.array(ends), np.asarray(scene.indenter.height(np.array(ends)), float))
        left, right = (lines, None) if side > 0 else (None, lines)
        before, after = self.surfaces.stored(left, right, np.full(2, self.depth))[1].tolist()
        return pressed + (after - before) / (h + min(h, room))


def outer_line(problem: Problem, start: float) -> FittedLine | None:
    """The line of a contact about an axis, whose D is unimodal; None where it is not held.

    Below the depth of touching it is looked for between the least D and where it rests at touching.
    """
    if problem.depth >= problem.touch:
        return find_line(problem, 1, start)
    touching = Problem(problem.scene, problem.touch, problem.touch, problem.surfaces)
    x, over = least_shortfall(problem, find_line(touching, 1, start).x, 0.0)
    return find_line(problem, 1, x) if over <= 0 else None


def least_shortfall(problem: Problem, outer: float, enough: float) -> tuple[float, float]:
    """Where D - d is least at radii up to `outer`, by golden sections, and how much it is.

    Or a place where it is not more than `enough`.
    """
    last = problem.shortfall(1, outer, -1 if outer in problem.scene.indenter.walls else 0)
    if not outer or last <= enough:
        return outer, last
    x, low = least(lambda x: problem.shortfall(1, float(x)), 0.0, outer, enough)
    return min((float(low), float(x)), (last, outer))[::-1]


def find_line(problem: Problem, side: int, start: float) -> FittedLine:
    """First contact line outwards from `start`; at `start` itself where nothing beyond holds."""
    indenter = problem.scene.indenter
    size, held = problem.scene.elastocapillary_length, problem.scene.work_of_adhesion > 0
    h = functools.cache(functools.partial(problem.shortfall, side))
    if start in indenter.walls and start == indenter.extent[0 if side < 0 else 1]:
        return FittedLine(start, True, False)
    corners = indenter.corners
    if side > 0:
        outwards = corners[bisect.bisect_right(corners, start) :]
    else:
        outwards = corners[: bisect.bisect_left(corners, start)][::-1]
    if indenter.convex and len(outwards) > _FEW_CORNERS:
        start, outwards = _skipped(problem, side, start, outwards)
    for corner in [*map(float, outwards), None]:
        first = h(start, 1 if start in corners else 0)
        tie = _TIE * (abs(first) + problem.lift)
        if first > tie or (corner is None and first >= 0):
            return FittedLine(start, True, False)
        if corner is None:
            break
        last = h(corner, -1)
        if last > tie:
            return FittedLine(bracketed(h, start, corner), False, False)
        if corner in indenter.walls:
            return FittedLine(corner, True, held and abs(last) <= tie)
        start = corner
    inside, outside = _around(problem, h, side, start, size)
    return FittedLine(bracketed(h, inside, outside), False, False)


def _skipped(
    problem: Problem, side: int, start: float, corners: Sequence[float] | Array
) -> tuple[float, Sequence[float] | Array]:
    """The last corner the line passes for sure, and the next: D of a convex profile rises."""
    passed, stops = 0, len(corners)
    while passed < stops:
        middle = (passed + stops) // 2
        corner = float(corners[middle])
        if problem.shortfall(side, corner, 1) < 0:
            passed = middle + 1
        else:
            stops = middle
    return (float(corners[passed - 1]) if passed else start), corners[passed : passed + 2]


def _around(
    problem: Problem, h: Callable[[float], float], side: int, start: float, size: float
) -> tuple[float, float]:
    """Points on both sides of the line, or ValueError where the known profile ends before it."""
    limit = problem.scene.indenter.extent[0 if side < 0 else 1]
    inside, step = start, side * size
    for _ in range(300):
        x = start + step
        if side * (x - limit) >= 0:
            x = limit
        if math.isfinite(x) and h(x) > 0:
            return inside, x
        if math.isfinite(x) and problem.displaced(x) < 0:  # pulled up, and further out even more
            problem.refuse_overhang(x)
        if x == limit or not math.isfinite(x):
            break
        inside, step = x, 4 * step
    raise ValueError(
        f"depth = {problem.depth!r} spreads the contact to x = {x!r}, where the profile is not "
        "known any more; give a wider profile, a smaller depth, or add a FlatPunch whose edge ends "
        "the indenter there"
    )


def lowest_point(indenter: Indenter, size: float) -> float:
    """Where the slope of a convex profile changes sign, or the end of its extent it falls to."""
    lo, hi = indenter.extent
    start = min(max(0.0, lo), hi)
    ends = []
    for side, limit in ((-1, lo), (1, hi)):
        x, step = start, size
        while x != limit and side * float(indenter.slope(x)) < 0 and math.isfinite(step):
            x = side * min(side * (start + side * step), side * limit)
            step *= 4
        ends.append(x)
    left, right = ends
    if not math.isfinite(left + right) or abs(right - left) > 1e30 * size:
        raise ValueError(f"indenter = {indenter!r} has no lowest point; give it a finite extent")
    for _ in range(_HALVINGS):
        middle = (left + right) / 2
        if float(indenter.slope(middle)) < 0:
            left = middle
        else:
            right = middle
    candidates = [c for c in np.asarray(indenter.corners, float) if abs(c - right) <= 1e-12 * size]
    return min([*candidates, left, right], key=lambda x: float(indenter.height(x)))


def mirrored(indenter: Indenter, x: float) -> float:
    """x mirrored about the apex; a point on one end of the extent lands on the other."""
    return max(2 * float(indenter.apex or 0.0) - x, indenter.extent[0])
