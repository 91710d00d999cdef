"""A mesh anchored at the contact lines: their positions are unknowns like the displacements.

    U(p, q, u) = ∫_p^q [k/2 g² + γ₁/2 f'² - w] dx + F(u left of p) + F(u right of q)

over the lines p <= q and the free surfaces u with u(p) = g(p), u(q) = g(q). Elimination of u leaves
F = S g²/2 with the stiffness S of the spectral free surface (free_surface.py), and

    dU/dq = k/2 g² + γ₁/2 f'² - w - S g f' = γ₁/2 r² - w,    r = f' - S g/γ₁,

a square because the free surface obeys S² = kγ₁ on the mesh to rounding. r is the jump of the slope
at the line; where it is negative the surface would pass through the indenter and the line must
advance. The line is the sign change of dU/dq, found by bracketing, between corners only: at a
corner dU/dq may change sign by a jump and pin the line. The contact is integrated by Gauss points.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.free_surface import FreeSurface
from energy import Indenter, Scene, terms

Array = NDArray[np.float64]
_TIE = 1e-12
_GAUSS = 40


class FittedLine(NamedTuple):
    """A contact line at x; pinned by a corner; neutral if moving it costs nothing."""

    x: float
    pinned: bool
    neutral: bool


class Interval(NamedTuple):
    """Totals over a fitted contact and its free surfaces, with the force by two routes."""

    energy: float
    force: float
    force_by_field: float
    energy_scale: float
    force_scale: float
    weakest: float


@dataclass(frozen=True, eq=False)
class Problem:
    """A scene at a depth; reach: separation up to which springs without tension stay attached."""

    scene: Scene
    depth: float
    touch: float
    reach: float
    surface: FreeSurface

    @classmethod
    def of(
        cls, scene: Scene, depth: float, touch: float, branch: str, surface: FreeSurface
    ) -> Problem:
        """touch: depth at which contact begins."""
        reach = scene.critical_separation
        if branch == "adhered":
            reach = min(reach, max(depth, touch) - depth)
        return cls(scene, depth, touch, reach, surface)

    @property
    def stiffness(self) -> float:
        """S: reaction of a free surface to a unit displacement of its line."""
        return math.sqrt(self.scene.stiffness * self.scene.gamma1) * self.surface.stiffness

    def jump(self, side: int, x: float, aside: float) -> float:
        """r = f' - S g/γ₁ outwards; the slope read `aside` of x, to choose the side of a corner."""
        scene = self.scene
        if not scene.gamma1:
            return 0.0
        g = self.depth - float(scene.indenter.height(x))
        f1 = side * float(scene.indenter.slope(x + side * aside))
        return f1 - self.stiffness / scene.gamma1 * g

    def drive(self, side: int, x: float, aside: float) -> float:
        """Sign of dU/dq, negative where the line advances: r √(γ₁/2) - √w, a root of (… ) above.

        γ₁ = 0: f(x) - d - reach, the springs beyond are not attached.
        """
        scene = self.scene
        if not scene.gamma1:
            return float(scene.indenter.height(x)) - self.depth - self.reach
        held = math.sqrt(scene.work_of_adhesion)
        return math.sqrt(scene.gamma1 / 2) * self.jump(side, x, aside) - held

    def scale(self, ends: tuple[FittedLine, FittedLine]) -> float:
        """Size of the terms that cancel in `drive`."""
        scene, f = self.scene, self.scene.indenter
        g = max(abs(self.depth - float(f.height(end.x))) for end in ends)
        if not scene.gamma1:
            return abs(self.depth) + g or 1.0
        slope = max(
            abs(self.jump(s, e.x, -1e-9 * abs(g))) for s, e in zip((-1, 1), ends, strict=True)
        )
        slope += 2 * self.stiffness / scene.gamma1 * max(g, abs(self.depth))
        return math.sqrt(scene.gamma1 / 2) * slope + math.sqrt(scene.work_of_adhesion) or 1.0

    def force_rate(self, side: int, x: float) -> float:
        """dP/dq of one line at fixed depth: k g - S f'."""
        f = self.scene.indenter
        g = self.depth - float(f.height(x))
        return self.scene.stiffness * g - self.stiffness * side * float(f.slope(x))


def find_line(problem: Problem, side: int, start: float) -> FittedLine | None:
    """First contact line outwards from `start`; None where not even `start` is held."""
    indenter = problem.scene.indenter
    size = problem.scene.elastocapillary_length or abs(problem.depth) or 1.0
    h = functools.partial(problem.drive, side)
    corners, origin = np.asarray(indenter.corners, float), start
    outwards = corners[corners > start] if side > 0 else corners[corners < start][::-1]
    for corner in [*outwards.tolist(), None]:
        aside = 1e-9 * (abs(corner - start) if corner is not None else size)
        tie = _TIE * (abs(h(start, aside)) + math.sqrt(problem.scene.work_of_adhesion))
        if h(start, aside) > tie or (corner is None and h(start, aside) >= 0):
            lone = start == origin
            held = problem.depth >= problem.touch if lone else True
            return FittedLine(start, True, False) if held else None
        if corner is None:
            break
        last = h(corner, -aside)
        if last > tie:
            return FittedLine(_bracketed(lambda x: h(x, 0.0), start, corner), False, False)
        if corner in indenter.walls:
            neutral = problem.scene.work_of_adhesion > 0 and abs(last) <= tie
            return FittedLine(corner, True, neutral)
        start = corner
    outside = _outside(problem, h, side, start, size)
    return FittedLine(_bracketed(lambda x: h(x, 0.0), start, outside), False, False)


def _outside(
    problem: Problem, h: Callable[[float, float], float], side: int, start: float, size: float
) -> float:
    """A point beyond the line, or ValueError where the known profile ends before it."""
    limit = problem.scene.indenter.extent[0 if side < 0 else 1]
    step = side * size
    for _ in range(300):
        x = start + step
        if side * (x - limit) >= 0:
            x = limit
        if math.isfinite(x) and h(x, 0.0) > 0:
            return x
        if x == limit or not math.isfinite(x):
            break
        step *= 4
    raise ValueError(
        f"depth = {problem.depth!r} spreads the contact to x = {x!r}, where the profile is not "
        "known any more; give a wider profile, a smaller depth, or add a FlatPunch whose edge ends "
        "the indenter there"
    )


def _bracketed(h: Callable[[float], float], inside: float, outside: float) -> float:
    """Zero of h with h(inside) <= 0 < h(outside): false position, every third step a halving."""
    x0, x1, y0, y1 = inside, outside, min(h(inside), 0.0), h(outside)
    if not y1 > 0:  # a corner whose slope is read from the other side
        y1 = -y0 or 1.0
    for step in range(250):
        x = x0 + (x1 - x0) * (y0 / (y0 - y1)) if step % 3 else (x0 + x1) / 2
        if x in (x0, x1):
            break
        y = h(x)
        if y <= 0:
            x0, y0 = x, y
        else:
            x1, y1 = x, y
        if y == 0:
            return x
    return x0 if -y0 < y1 else x1


@functools.lru_cache(maxsize=8)
def _graded(order: int) -> tuple[Array, Array]:
    """Gauss points on [0, 1] crowded at 0 by x = t⁴, for what is not smooth there."""
    t, weights = np.polynomial.legendre.leggauss(order)
    t = (t + 1) / 2
    return t**4, weights * 2 * t**3


def integrate(problem: Problem, left: float, right: float, order: int = _GAUSS) -> Interval:
    """Energy and force of the contact left..right with its two free surfaces."""
    scene, depth, indenter = problem.scene, problem.depth, problem.scene.indenter
    k, gamma1, w = scene.stiffness, scene.gamma1, scene.work_of_adhesion
    corners = np.asarray(indenter.corners, float)
    middle = float(indenter.apex) if indenter.apex is not None else (left + right) / 2
    cuts = np.append(corners[(corners > left) & (corners < right)], middle)
    ends = np.unique(np.clip(np.concatenate([[left, right], cuts]), left, right))
    lo, hi = ends[:-1, None], ends[1:, None]
    near = np.where(np.abs(lo - middle) <= np.abs(hi - middle), lo, hi)
    points, weights = _graded(order)
    x, span = near + (lo + hi - 2 * near) * points, (hi - lo) * weights
    g = depth - indenter.height(x)
    springs = float(np.sum(span * terms.spring(g, k=k).value))
    tension = float(np.sum(span * terms.surface(indenter.slope(x), gamma1=gamma1).value))
    u = depth - np.array([float(indenter.height(left)), float(indenter.height(right))])
    tails, adhesion = problem.stiffness / 2 * float(u @ u), w * (right - left)
    area = k * scene.elastocapillary_length * problem.surface.area
    force = float(np.sum(span * (k * g)))
    size = float(np.sum(span * np.abs(k * g)))
    return Interval(
        springs + tension + tails - adhesion,
        force + problem.stiffness * float(u.sum()),
        force + area * float(u.sum()),
        springs + tension + tails + adhesion,
        size + problem.stiffness * float(np.abs(u).sum()),
        float(g.min(initial=0.0)),
    )


def mirrored(indenter: Indenter, x: float) -> float:
    """x mirrored about the apex; a point on one end of the extent lands on the other."""
    return max(2 * float(indenter.apex or 0.0) - x, indenter.extent[0])
