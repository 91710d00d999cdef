"""Load paths without surface tension, γ₁ = 0, of any profile: independent springs.

Each spring attaches when it is touched and lets go at u = -δ₀, so that the contact is what lies
below a level of the profile. Pressed, the level is the depth where that is higher; retracted, it is
d + δ₀ where that is lower. Nothing jumps: what attaches loses its work of adhesion, as it had to be
touched, and no energy is released at once.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.springs import at_level, lines_below
from discretization.paths.branch import Branch, Leg, Point
from discretization.profile import Resolved, resolve
from discretization.quadrature import Integrals
from energy import Scene

Array = NDArray[np.float64]
_APART = 1e-15  # of the depths: two places that close are one


@dataclass(eq=False)
class Levels(Leg):
    """A leg between two depths at which the contact begins, ends or meets a corner somewhere."""

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the way (n,)."""
        return list(self.branch.moved(self.start, depths))


@dataclass(frozen=True, eq=False)
class SpringsBranch(Branch):
    """Independent springs under a prescribed depth; what a point remembers is its level."""

    scene: Scene
    profile: Resolved

    @classmethod
    def of(cls, scene: Scene, deepest: float) -> SpringsBranch:
        """deepest: the largest depth of the programme. ValueError for a pattern."""
        if scene.pattern is not None:
            raise ValueError(
                f"pattern = {scene.pattern!r} with gamma1 = 0: springs that let go at different "
                "heights are not followed; give gamma1 > 0, or leave the pattern out"
            )
        return cls(scene, resolve(scene, deepest))

    @property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return self.profile.touch

    @functools.cached_property
    def integrals(self) -> Integrals:
        """What contacts cost up to a line."""
        return Integrals.of(self.scene, self.profile, float(self.profile.f.max()))

    @functools.cached_property
    def heights(self) -> Array:
        """Levels at which contacts begin, end, or meet a corner, in their order."""
        f, steps = self.profile.f, np.diff(self.profile.f)
        turns = np.flatnonzero(steps[1:] * steps[:-1] <= 0) + 1  # corners stand twice
        return np.unique(np.concatenate([f[:1], f[turns], f[-1:]]))

    @property
    def first(self) -> Point:
        """The contacts at first touch."""
        (lines,) = lines_below(self.profile, np.array([self.touch]))
        return Point(self.touch, tuple(lines.tolist()), self.touch)

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with lines here; nan: detached."""
        if math.isnan(lines[0]):
            return Point(depth, None)
        level = float(np.max(self.profile.indenter.height(np.array(lines))))
        return Point(depth, lines, level)

    def moved(self, before: Point, depths: Array) -> list[Point]:
        """The points at depths (n,) on one way from a point."""
        levels = np.clip(before.memory, depths, depths + self.holding_range)
        levels = np.maximum(levels, self.touch)  # but for rounding it is
        found = lines_below(self.profile, levels)
        return [
            Point(d, before.lines if level == before.memory else tuple(lines.tolist()), level)
            for d, level, lines in zip(depths.tolist(), levels.tolist(), found, strict=True)
        ]

    def leg(self, point: Point, goal: float) -> Levels:
        """The way from a point towards another depth, up to the next change of the contact."""
        here, level, way = point.depth, point.memory, (1 if goal > point.depth else -1)
        reach = self.holding_range
        off, lowest = (0.0, -math.inf) if way > 0 else (reach, self.touch - reach)
        least = _APART * (abs(here) + abs(goal) + abs(self.touch) + reach)
        ahead = np.append(self.heights[way * (self.heights - level) > 0], level) - off
        ahead = ahead[way * (ahead - here) > least]
        end = way * min(way * goal, float((way * ahead).min(initial=math.inf)))
        lost = end <= lowest + least
        end = lowest if lost else end
        (there,) = self.moved(point, np.array([end]))
        return Levels(self, point, there, Point(end, None) if lost else None, False)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points with as many lines as each other."""
        lines = np.array([point.lines for point in points])
        depths = np.repeat([point.depth for point in points], lines.shape[1])
        parts = self.integrals.contact(lines.ravel(), depths, self.scene.work_of_adhesion)
        parts = parts[::2].reshape(2, *lines.shape)
        return np.asarray((parts[..., 1::2] - parts[..., ::2]).sum(axis=2))

    def friction(self, before: Point, after: Point) -> float:
        """w of what closes, which had to be touched, and w_opening - w of what opens."""
        opened = self.opened(before, after)
        closing, opening = self.scene.work_of_adhesion, self.scene.opened.work_of_adhesion
        return (opening - closing) * opened if opened > 0 else -closing * opened

    def opened(self, before: Point, after: Point) -> float:
        """The length that opens between two points, or minus what closes."""
        one, other = (
            float(np.diff(self.integrals.at(np.array(p.lines or ()))[4].reshape(-1, 2)).sum())
            for p in (before, after)
        )
        return one - other

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the springs are in equilibrium."""
        if point.lines is not None:
            depth, level = point.depth, point.memory
            at_level(self.scene, self.profile, depth, level, branch="adhered")
