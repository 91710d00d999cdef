"""The lines of one contact where there can be no other, by bracketing.

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

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import ROUNDING
from discretization.roots import bracketed, least
from discretization.surfaces import surfaces_of
from discretization.surfaces.protocol import At, Free, Surfaces
from energy import Indenter, Scene

Array = NDArray[np.float64]
_TIE = ROUNDING  # a line's shortfall where moving it costs nothing
_FEW_CORNERS = 8  # up to here one by one, more all at once


class Line(NamedTuple):
    """A contact line at x, its contact on its left for the side +1.

    pinned: by a corner; neutral: moving it costs nothing; times: 2 where it stands for its mirror
    image, too.
    """

    side: int
    x: float
    pinned: bool = False
    neutral: bool = False
    times: int = 1


@dataclass(frozen=True, eq=False)
class Single:
    """One contact of a scene at a depth; touch: the depth at which it begins, at x = apex."""

    scene: Scene
    depth: float
    touch: float
    apex: float
    surfaces: Surfaces

    @classmethod
    def of(cls, scene: Scene, depth: float) -> Single:
        """With the free surfaces of the scene."""
        apex = scene.indenter.apex
        if apex is None:
            apex = lowest_point(scene.indenter, scene.elastocapillary_length)
        return cls(scene, depth, float(scene.indenter.height(apex)), apex, surfaces_of(scene))

    @property
    def displacement_scale(self) -> float:
        """A displacement of the scene to measure others by."""
        return max(abs(self.depth), self.scene.critical_separation) or 1.0

    def shortfall(self, side: int, x: Any, beside: int = 0, adhesive: bool = True) -> Any:
        """D - d of a line at x, or D₀ - d without adhesion; where it is negative it advances.

        beside: which slope of a corner counts, that on the outer (1) or the inner side (-1).
        """
        scene, indenter = self.scene, self.scene.indenter
        f1 = indenter.slope_beside(x, side * beside) if beside else indenter.slope(x)
        w = scene.work_of_adhesion if adhesive else 0.0
        return self.surfaces.rest_depth(side, x, indenter.height(x), f1, None, w) - self.depth

    def free(self, side: int, x: float) -> Free:
        """The free surface beyond a line. ValueError where it would turn over."""
        line = At(x, float(self.scene.indenter.height(x)))
        left, right = (line, None) if side > 0 else (None, line)
        return self.surfaces.free(left, right, self.depth)

    def size(self, line: Line) -> float:
        """What violations beside a line are measured by: |d|, δ₀, g and l |f'|, or l |sin β|."""
        scene, indenter = self.scene, self.scene.indenter
        slope = abs(float(indenter.slope_beside(line.x, -line.side)))
        if scene.slopes == "finite":
            slope /= math.hypot(1.0, slope)
        g = abs(self.depth - float(indenter.height(line.x)))
        return self.displacement_scale + g + scene.elastocapillary_length * slope

    def terms(self, line: Line) -> float:
        """Sum of the terms that cancel in `shortfall`: d, f, and what f' and w add to D."""
        indenter, rest = self.scene.indenter, self.surfaces.rest_depth
        sloped = rest(line.side, line.x, 0.0, float(indenter.slope(line.x)), None, 0.0)
        lifted = rest(line.side, line.x, 0.0, 0.0, None, self.scene.work_of_adhesion)
        parts = self.depth, indenter.height(line.x), sloped, lifted
        return sum(abs(float(part)) for part in parts)


def lines_of(problem: Single) -> list[Line]:
    """The contact lines, found outwards from inside the contact; none where it has let go."""
    indenter, touches, apex = problem.scene.indenter, problem.depth >= problem.touch, problem.apex
    if problem.scene.axisymmetric:
        line = find_line(problem, 1, apex) if touches else _retracted(problem)
        return [line] if line is not None and (line.x or touches) else []
    right = find_line(problem, 1, apex)
    if indenter.symmetric and apex == indenter.apex:
        return [right._replace(times=2)] if right.x > apex or touches else []
    left = find_line(problem, -1, apex)
    return [left, right] if left.x < right.x or (left.x == right.x and touches) else []


def ends_of(problem: Single, lines: list[Line]) -> Array:
    """Both ends of the contact (1, 2)."""
    right = lines[-1].x
    if problem.scene.axisymmetric:
        left = 0.0
    elif lines[0].times > 1:
        left = max(2 * problem.apex - right, problem.scene.indenter.extent[0])
    else:
        left = lines[0].x
    return np.array([[left, right]])


def _retracted(problem: Single) -> Line | None:
    """The line about an axis below the depth of touching; None where it is not held.

    Looked for between the least D, found by golden sections, and where it rests at touching.
    """
    outer = find_line(replace(problem, depth=problem.touch), 1, problem.apex).x
    edge = -1 if outer in problem.scene.indenter.walls else 0
    x, low = outer, float(problem.shortfall(1, outer, edge))
    if outer and low > 0:
        at, value = least(lambda r: problem.shortfall(1, float(r)), 0.0, outer, 0.0)
        low, x = min((float(value), float(at)), (low, outer))
    return find_line(problem, 1, x) if low <= 0 else None


def find_line(problem: Single, side: int, start: float) -> Line:
    """First contact line outwards from `start`; at `start` itself where nothing beyond holds."""
    indenter, adheres = problem.scene.indenter, problem.scene.work_of_adhesion > 0
    if start in indenter.walls and start == indenter.extent[0 if side < 0 else 1]:
        return Line(side, start, True)

    @functools.cache
    def h(x: float, beside: int = 0) -> float:
        return float(problem.shortfall(side, x, beside))

    corners = np.asarray(indenter.corners, float)[::side]
    outwards = corners[side * corners > side * start]
    if outwards.size > _FEW_CORNERS and indenter.convex:  # D rises: most are passed for sure
        passed = int(np.argmax(np.append(problem.shortfall(side, outwards, 1) >= 0, True)))
        start, outwards = float([start, *outwards][passed]), outwards[passed : passed + 2]
    for corner in outwards.tolist():
        first, last = h(start, 1 if start in corners else 0), h(corner, -1)
        tie = _TIE * (abs(first) + problem.displacement_scale)
        if first > tie:
            return Line(side, start, True)
        if last > tie:
            return Line(side, bracketed(h, start, corner))
        if corner in indenter.walls:
            return Line(side, corner, True, adheres and abs(last) <= tie)
        start = corner
    if h(start, 1 if start in corners else 0) >= 0:
        return Line(side, start, True)
    return Line(side, bracketed(h, *_around(problem, h, side, start)))


def _around(
    problem: Single, h: Callable[[float], float], side: int, start: float
) -> tuple[float, float]:
    """Points on both sides of the line, or ValueError where the known profile ends before it."""
    indenter, limit = problem.scene.indenter, problem.scene.indenter.extent[0 if side < 0 else 1]
    x, step = start, side * problem.scene.elastocapillary_length
    while x != limit and math.isfinite(step):
        inside, x = x, side * min(side * (start + step), side * limit)
        if h(x) > 0:
            return inside, x
        if problem.depth < indenter.height(x):  # pulled up, and further out even more
            problem.free(side, x)
        step *= 4
    raise ValueError(
        f"depth = {problem.depth!r} spreads the contact to x = {x!r}, where the profile is not "
        "known any more; give a wider profile, a smaller depth, or add a FlatPunch whose edge ends "
        "the indenter there"
    )


def lowest_point(indenter: Indenter, size: float) -> float:
    """Where the slope of a convex profile changes sign, or the end of its extent it falls to."""
    start = min(max(0.0, indenter.extent[0]), indenter.extent[1])
    side = 1 if indenter.slope(start) < 0 else -1
    limit, x, step = indenter.extent[0 if side < 0 else 1], start, size
    while x != limit and side * float(indenter.slope(x)) < 0 and math.isfinite(step):
        x, step = side * min(side * (start + side * step), side * limit), 4 * step
    if not math.isfinite(x) or abs(x - start) > 1e30 * size:
        raise ValueError(f"indenter = {indenter!r} has no lowest point; give it a finite extent")
    if side * float(indenter.slope(x)) > 0 and x != start:
        x = bracketed(lambda z: side * float(indenter.slope(z)), start, x)
    corners = np.asarray(indenter.corners, float)
    near = corners[np.abs(corners - x) <= 1e-12 * size].tolist()
    return min([*near, x], key=lambda z: float(indenter.height(z)))
