"""Contact without surface tension, γ₁ = 0, of any profile: independent springs.

Each spring attaches when it is touched and lets go at u = -δ₀, so that the contact is what lies
below a level of the profile. Pressed, the level is the depth where that is higher; retracted, it is
d + δ₀ where that is lower. So from first touch, and with the least energy, it is

    adhered:  f <= min(max(d, min f), d + δ₀),        global:  f <= d + δ₀    (18).

Nothing jumps on a path: what attaches loses its work of adhesion, as it had to be touched, and no
energy is released at once.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import ROUNDING, Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.contacts import estimated
from discretization.paths.branch import Branch, Leg, Point
from discretization.profile import Resolved, resolve
from discretization.quadrature import Integrals, Interval, refined
from discretization.roots import crossings
from discretization.surfaces.small import SmallSurfaces
from energy import Scene
from energy.arrays import Array, Mask

_TIE = 1e-14  # of the level and δ₀: how far above the level a lowest point may lie by rounding
_APART = 1e-15  # of the depths: two places that close are one


def on_springs(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """The certified state of independent springs.

    ValueError for a contact off the known profile; NotCertifiedError if it touched free springs.
    """
    springs, reach = SpringsBranch(scene, resolve(scene, depth)), scene.critical_separation
    level = depth + reach if branch == "global" else min(max(depth, springs.touch), depth + reach)
    return springs.state(depth, level, branch)


def lines_below(profile: Resolved, levels: Array) -> list[Array]:
    """The ends (2m,) of the parts of the profile at or below each level (k,), all at once.

    ValueError where one goes on beyond the known profile.
    """
    x, f = np.pad(profile.x, 1, mode="edge"), np.pad(profile.f, 1, constant_values=math.inf)
    ends = [np.flatnonzero(np.diff(f <= z)) for z in levels]
    at, level = np.concatenate(ends), np.repeat(levels, [z.size for z in ends])
    lo, hi, inside = x[at], x[at + 1], at + 1 - np.arange(at.size) % 2
    unknown = lo[(lo == hi) & ~np.isin(lo, profile.indenter.walls)]
    if unknown.size:
        raise ValueError(
            f"the contact spreads to x = {float(unknown[0])!r}, where the profile is not known any "
            "more; give a wider profile or a smaller depth"
        )
    with np.errstate(divide="ignore"):  # beyond a wall it rises at once
        rise = (f[at + 1] - f[at]) / (hi - lo)
    found = crossings(
        lambda z, k: np.asarray(profile.indenter.height(z), float) - level[k],
        *(lo, hi, x[inside] + (level - f[inside]) / rise, rise, 0.0),
    )
    return np.split(found, np.cumsum([z.size for z in ends])[:-1])


@dataclass(frozen=True, eq=False)
class SpringsBranch(Branch):
    """Independent springs under a prescribed depth; what a point remembers is its level."""

    scene: Scene
    profile: Resolved

    @classmethod
    def of(cls, scene: Scene, deepest: float) -> SpringsBranch:
        """deepest: the largest depth of the programme."""
        return cls(scene, resolve(scene, deepest))

    touch = property(lambda self: self.profile.touch)

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
        return self.moved(Point(self.touch, None, self.touch), np.array([self.touch]))[0]

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with lines here."""
        level = float(np.max(self.profile.indenter.height(np.array(lines))))
        return Point(depth, lines, level)

    def moved(self, before: Point, depths: Array) -> list[Point]:
        """The points at depths (n,) on one way from a point."""
        levels = np.clip(before.memory, depths, depths + self.holding_range)
        levels = np.maximum(levels, self.touch)  # but for rounding it is
        found = lines_below(self.profile, levels)
        return [
            Point(d, tuple(lines.tolist()), level)
            for d, level, lines in zip(depths.tolist(), levels.tolist(), found, strict=True)
        ]

    def leg(self, point: Point, goal: float) -> Leg:
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
        return Leg(self, point, there, Point(end, None) if lost else None, False)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points with as many lines as each other."""
        lines = np.array([point.lines for point in points])
        depths = np.repeat([point.depth for point in points], lines.shape[1])
        parts = self.integrals.contact(lines.ravel(), depths, self.scene.work_of_adhesion)
        parts = parts[::2].reshape(2, *lines.shape)
        return np.asarray((parts[..., 1::2] - parts[..., ::2]).sum(axis=2))

    def opened(self, before: Point, after: Point) -> float:
        """The length that opens between two points, or minus what closes as it is touched."""
        held, left = (self.integrals.at(np.array(p.lines or ()))[4] for p in (before, after))
        return float((held[1::2] - held[::2]).sum() - (left[1::2] - left[::2]).sum())

    def state(self, depth: float, level: float, branch: str) -> Equilibrium:
        """The certified state in which what lies below a level is in contact."""
        scene, touch, lift = self.scene, self.touch, max(abs(depth), self.holding_range) or 1.0
        given: dict[str, Any] = {"scene": scene, "depth": depth, "branch": branch}
        given |= {"surfaces": SmallSurfaces(scene)}
        if touch > level + _TIE * lift:
            through = max(0.0, (depth - touch) / lift)
            return detached(**given, certificate=Certificate.undeformed(through))
        level = max(level, touch)
        lines = lines_below(self.profile, np.array([level]))[0].reshape(-1, 2)
        pinned = np.isin(lines, self.profile.indenter.walls)
        found = refined(scene, depth, lines, ())
        judged = _judged(self.profile, lines, pinned, (depth, level, lift))
        judged.demand(f"the state at depth = {depth!r}", "try another depth")
        errors = estimated(scene, depth, lines, _moves(scene, lines, pinned, depth, found), found)
        given |= {"pinned": pinned, "certificate": judged, "errors": errors, "nodes": lines}
        return Equilibrium(contacts=lines, method="fitted", **given, **found.of_state)

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the springs are in equilibrium."""
        if point.lines is not None:
            self.state(point.depth, point.memory, "adhered")


def _judged(profile: Resolved, lines: Array, pinned: Mask, at: tuple[float, ...]) -> Certificate:
    """penetration: of free springs; opening: none is held beyond δ₀; neighbours: of lines.

    The force is that of the pressure alone, the same by both routes. at: the depth, the level up to
    which springs are in contact, and a length to measure them by.
    """
    (depth, level, lift), (x, f) = at, (profile.x, profile.f)
    free = (np.searchsorted(lines.ravel(), x) % 2 == 0) & ~np.isin(x, lines)
    through = float((depth - f[free]).max(initial=0.0))
    off = np.abs(np.asarray(profile.indenter.height(lines)) - level)[~pinned].max(initial=0.0)
    torn = float((f[~free] - max(level, depth)).max(initial=0.0))
    return Certificate(through / lift, 0.0, torn / lift, float(off) / lift, 0.0)


def _moves(scene: Scene, lines: Array, pinned: Mask, depth: float, found: Interval) -> Array:
    """How far lines (m, 2) may be off: rounding of the heights times the condition of the lines."""
    height, slope = scene.indenter.height(lines), np.abs(scene.indenter.slope(lines))
    with np.errstate(divide="ignore", invalid="ignore"):
        moves = (ROUNDING * (np.abs(height) + abs(depth)) + found.rounding) / slope
    return np.where(pinned, 0.0, np.fmin(moves, np.diff(lines, axis=1).sum()))
