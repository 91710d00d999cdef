"""A mesh anchored at the contact lines: their positions are unknowns like the displacements.

    U(p, q, u) = ∫_p^q [k/2 g² + γ₁/2 f'² - w] dx + F(u left of p) + F(u right of q)

over the lines p <= q and the free surfaces u with u(p) = g(p), u(q) = g(q). Elimination of u leaves
F(g), the energy of the spectral free surface (response.py), with the reaction S = dF/dg, and

    dU/dq = k/2 g² + γ₁/2 f'² - w - S f' = γ₁/2 r² - w,    r = f' - S/γ₁   (small slopes),

a square because the free surface obeys S² = kγ₁ g² on the mesh to rounding. r is the jump of the
slope at the line; where it is negative the surface would pass through the indenter and the line
must advance. With finite slopes, tan β = f', sin φ = S/γ₁ and cos φ = 1 - k g²/(2γ₁), likewise

    dU/dq = k/2 g² + (γ₁-w)√(1+f'²) - γ₁ - S f' = [2γ₁ sin²((β-φ)/2) - w]/cos β,

as sin² φ + cos² φ = 1 on the mesh to rounding.

The line is the sign change of dU/dq, found by bracketing, between corners only: at a corner dU/dq
may change sign by a jump and pin the line.
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

from discretization.fitted.free_surface import OVERHANG
from discretization.fitted.response import Response
from discretization.fitted.roots import bracketed
from energy import Indenter, Scene

Array = NDArray[np.float64]
_TIE = 16 * float(np.finfo(float).eps)  # a line's drive where moving it costs nothing
_COARSE = 1e-12
_UPRIGHT = 2e-8  # so close to turning over no double resolves the slope
_FEW_CORNERS = 8
_HALVINGS = 64


class FittedLine(NamedTuple):
    """A contact line at x; pinned by a corner; neutral if moving it costs nothing."""

    x: float
    pinned: bool
    neutral: bool


@dataclass(frozen=True, eq=False)
class Problem:
    """A scene at a depth with the response of its free surfaces.

    touch: depth at which contact begins; reach: separation up to which springs without tension
    stay attached.
    """

    scene: Scene
    depth: float
    touch: float
    reach: float
    response: Response

    @classmethod
    def of(
        cls, scene: Scene, depth: float, touch: float, branch: str, response: Response
    ) -> Problem:
        """The problem of one branch."""
        reach = scene.critical_separation
        if branch == "adhered":
            reach = min(reach, max(depth, touch) - depth)
        return cls(scene, depth, touch, reach, response)

    @property
    def lift(self) -> float:
        """A displacement of the scene to measure others by."""
        return max(abs(self.depth), self.scene.critical_separation) or 1.0

    def displaced(self, x: float) -> float:
        """g(x) = d - f(x)."""
        return self.depth - float(self.scene.indenter.height(x))

    def refuse_overhang(self, x: float) -> None:
        """ValueError if a line at x would incline the surface by more than π/2."""
        limit = OVERHANG * (1 - _UPRIGHT) * self.scene.elastocapillary_length
        if limit and self.scene.slopes == "finite" and abs(self.displaced(x)) >= limit:
            raise ValueError(
                f"depth = {self.depth!r}: at the contact line x = {x!r} the surface is displaced "
                f"by {self.displaced(x)!r}, more than √2 l = {limit!r}; it would turn over and is "
                "no graph u(x); use a smaller |depth|, a smaller w or a blunter indenter"
            )

    def jump(self, side: int, x: float, aside: float) -> float:
        """r = f' - S/γ₁, or 2 sin((β-φ)/2): the kink of the surface at a line at x.

        The indenter's slope is read `aside` of x outwards, to choose the side of a corner.
        """
        scene = self.scene
        if not scene.gamma1:
            return 0.0
        f1 = side * float(scene.indenter.slope(x + side * aside))
        g = self.displaced(x) / scene.elastocapillary_length
        if scene.slopes == "small":
            return f1 - self.response.reaction(g)
        if abs(g) < OVERHANG * (1 - _UPRIGHT):
            pull = math.atan2(self.response.reaction(g), 1 - g * g / 2)
        else:  # would turn over; such a state is refused once found
            pull = math.copysign(math.pi / 2, g)
        return 2 * math.sin((math.atan(f1) - pull) / 2)

    def drive(self, side: int, x: float, aside: float) -> float:
        """√(γ₁/2) r - √w: has the sign of dU/dq, or is negative where r is; the line advances.

        γ₁ = 0: f(x) - d - reach, the springs beyond are not attached.
        """
        scene = self.scene
        if not scene.gamma1:
            return -self.displaced(x) - self.reach
        return math.sqrt(scene.gamma1 / 2) * self.jump(side, x, aside) - self.held

    @property
    def lets_go(self) -> bool:
        """Whether a line stops advancing where w is spent, and not where springs are untouched."""
        scene = self.scene
        spent = scene.gamma1 > 0 or self.reach == scene.critical_separation
        return scene.work_of_adhesion > 0 and spent

    @property
    def held(self) -> float:
        """What the adhesion holds in `drive`: √w, or the reach of springs without tension."""
        return math.sqrt(self.scene.work_of_adhesion) if self.scene.gamma1 else self.reach

    @property
    def tie(self) -> float:
        """Relative error of `drive`: rounding, and what a coarse surface's reaction is off by."""
        return _TIE + min(self.response.error, _COARSE)

    def distinct(
        self, ends: tuple[FittedLine, FittedLine]
    ) -> tuple[tuple[int, FittedLine, int], ...]:
        """(side, line, how many like it): of a mirrored contact one line speaks for both."""
        indenter, (left, right) = self.scene.indenter, ends
        if indenter.symmetric and left.x == mirrored(indenter, right.x):
            return ((1, right, 2),)
        return (-1, left, 1), (1, right, 1)

    def scale(self, ends: tuple[FittedLine, FittedLine]) -> float:
        """Size of the terms that cancel in `drive`."""
        scene, lines = self.scene, self.distinct(ends)
        g = max(abs(self.displaced(end.x)) for _, end, _ in lines)
        if not scene.gamma1:
            return abs(self.depth) + g or 1.0
        slope = max(abs(self.jump(side, end.x, -1e-9 * g)) for side, end, _ in lines)
        slope += 2 * max(g, abs(self.depth)) / scene.elastocapillary_length
        return math.sqrt(scene.gamma1 / 2) * slope + self.held or 1.0

    def imbalance(self, x: float) -> float:
        """Residual of the free surface at a line, and how far its reaction is from the response."""
        u0 = self.displaced(x) / self.scene.elastocapillary_length
        surface = self.response.surface(u0)
        apart = max(surface.residual, abs(surface.reaction - self.response.reaction(u0)))
        return apart / (abs(u0) or 1.0)

    def force_rate(self, side: int, x: float) -> float:
        """dP/dq of one line at fixed depth, k g - γ₁ S'(g) f'."""
        scene = self.scene
        f1, g = side * float(scene.indenter.slope(x)), self.displaced(x)
        if not scene.gamma1:
            return scene.stiffness * g
        at = g / scene.elastocapillary_length
        step = 1e-4 if scene.slopes == "small" else min(1e-4, (OVERHANG - abs(at)) / 2)
        stiffer = self.response.reaction(at + step) - self.response.reaction(at - step)
        return scene.stiffness * (g - scene.elastocapillary_length * stiffer / (2 * step) * f1)


def find_line(problem: Problem, side: int, start: float) -> FittedLine:
    """First contact line outwards from `start`; at `start` itself where nothing beyond holds."""
    indenter = problem.scene.indenter
    size = problem.scene.elastocapillary_length or problem.lift
    h = functools.cache(functools.partial(problem.drive, side))
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
        aside = 0.0
        if start in corners:
            aside = 1e-9 * (abs(corner - start) if corner is not None else size)
        first = h(start, aside)
        tie = problem.tie * (abs(first) + problem.held)
        if first > tie or (corner is None and first >= 0):
            return FittedLine(start, True, False)
        if corner is None:
            break
        last = h(corner, -aside)
        if last > tie:
            return FittedLine(bracketed(lambda x: h(x, 0.0), start, corner), False, False)
        if corner in indenter.walls:
            return FittedLine(corner, True, problem.lets_go and abs(last) <= tie)
        start = corner
    inside, outside = _around(problem, h, side, start, size)
    return FittedLine(bracketed(lambda x: h(x, 0.0), inside, outside), False, False)


def _skipped(
    problem: Problem, side: int, start: float, corners: Sequence[float] | Array
) -> tuple[float, Sequence[float] | Array]:
    """The last corner the line passes for sure, and the next: a convex drive rises all the way."""
    passed, stops = 0, len(corners)
    while passed < stops:
        middle = (passed + stops) // 2
        corner = float(corners[middle])
        beyond = problem.drive(side, corner, 1e-9 * abs(corner - start))
        if beyond < 0:
            passed = middle + 1
        else:
            stops = middle
    return (float(corners[passed - 1]) if passed else start), corners[passed : passed + 2]


def _around(
    problem: Problem, h: Callable[[float, float], float], side: int, start: float, size: float
) -> tuple[float, float]:
    """Points on both sides of the line, or ValueError where the known profile ends before it."""
    limit = problem.scene.indenter.extent[0 if side < 0 else 1]
    inside, step = start, side * size
    for _ in range(300):
        x = start + step
        if side * (x - limit) >= 0:
            x = limit
        if math.isfinite(x) and h(x, 0.0) > 0:
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
