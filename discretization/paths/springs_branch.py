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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.springs import at_level, lines_below
from discretization.integrals import Integrals
from discretization.paths.balance import integral
from discretization.paths.branch import BranchBase, Pinned, Point, at_edges, legs
from discretization.profile import Resolved, resolve
from energy import Scene

Array = NDArray[np.float64]
_WORK = 1e-11  # of the integral of the force
_APART = 1e-15  # of the depths: two places that close are one


class Level(NamedTuple):
    """What lies below a level is in contact: its lines from left to right."""

    level: float
    lines: tuple[float, ...]

    @property
    def ends(self) -> tuple[float, float]:
        """x of the outermost lines."""
        return self.lines[0], self.lines[-1]


State = Level | None


@dataclass(eq=False)
class Levels:
    """A leg between two depths at which the contact begins, ends or meets a corner somewhere."""

    branch: SpringsBranch
    start: Point
    end: Point
    after: Point | None
    jumps: bool = False

    @property
    def pinned(self) -> Pinned:
        """What holds the outermost lines on the way."""
        ends = [self.branch.pinned(point.state) for point in (self.start, self.end)]
        first, last = (
            "edge" if one == other == "edge" else "" for one, other in zip(*ends, strict=True)
        )
        return first, last

    def points(self, depths: Array) -> list[Point]:
        """The states at depths on the way (n,)."""
        states = self.branch.moved(self.start.state, depths)
        return [Point(d, state) for d, state in zip(depths.tolist(), states, strict=True)]

    def forces(self, depths: Array, *, roughly: bool = False) -> Array:
        """P at depths on the way (n,)."""
        return self.branch.totals(self.branch.moved(self.start.state, depths), depths)[1]

    def work(self) -> float:
        """∫P dd, with t that is crowded where the contact begins or ends like a root of d."""
        start, length = self.start.depth, self.end.depth - self.start.depth

        def density(t: Array) -> Array:
            return self.forces(start + length * t * t * (3 - 2 * t)) * (6 * length * t * (1 - t))

        return integral(density, 0.0, 1.0, _WORK)


@dataclass(frozen=True, eq=False)
class SpringsBranch(BranchBase):
    """States of independent springs under a prescribed depth; None: detached."""

    scene: Scene
    profile: Resolved
    rtol: float

    @classmethod
    def of(cls, scene: Scene, rtol: float, deepest: float) -> SpringsBranch:
        """deepest: the largest depth of the programme. ValueError for a pattern."""
        if scene.pattern is not None:
            raise ValueError(
                f"pattern = {scene.pattern!r} with gamma1 = 0: springs that let go at different "
                "heights are not followed; give gamma1 > 0, or leave the pattern out"
            )
        return cls(scene, resolve(scene, deepest), rtol)

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

    def contact(self, depth: float, *lines: float) -> State:
        """The state with lines here; nan: detached."""
        if math.isnan(lines[0]):
            return None
        return Level(float(np.max(self.profile.indenter.height(np.array(lines)))), lines)

    def moved(self, before: Level, depths: Array) -> list[Level]:
        """The states at depths (n,) on one way from a state."""
        levels = np.clip(before.level, depths, depths + self.lift)
        levels = np.maximum(levels, self.touch)  # but for rounding it is
        found = lines_below(self.profile, levels)
        return [
            before if level == before.level else Level(level, tuple(lines.tolist()))
            for level, lines in zip(levels.tolist(), found, strict=True)
        ]

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        if before is None:
            if depth < self.touch:
                return None
            (lines,) = lines_below(self.profile, np.array([self.touch]))
            before = Level(self.touch, tuple(lines.tolist()))
        return self.moved(before, np.array([depth]))[0] if depth >= self.lost else None

    @property
    def lost(self) -> float:
        """The depth at which the last spring lets go."""
        return self.touch - self.lift

    def leg(self, point: Point, goal: float) -> Levels:
        """The way from a point towards another depth, up to the next change of the contact."""
        here, level, way = point.depth, point.state.level, (1 if goal > point.depth else -1)
        least = _APART * (abs(here) + abs(goal) + abs(self.touch) + self.lift)
        places = self.heights if way > 0 else self.heights - self.lift
        first = level if way > 0 else level - self.lift
        ahead = np.append(places[way * (places - first) > 0], first)
        ahead = ahead[way * (ahead - here) > least]
        end = goal
        if ahead.size:
            end = way * min(way * goal, float((way * ahead).min()))
        lost = way < 0 and end <= self.lost + least
        end = self.lost if lost else end
        (state,) = self.moved(point.state, np.array([end]))
        return Levels(self, point, Point(end, state), Point(end, None) if lost else None)

    def pinned(self, state: State) -> Pinned:
        """What holds the outermost lines: "edge" or "" where they are free."""
        return at_edges(self.scene, state)

    def totals(self, states: Sequence[Level], depths: Array) -> Array:
        """U and P (2, n)."""
        counts = [len(state.lines) for state in states]
        own = np.repeat(np.arange(len(states)), counts)
        lines = np.array([x for state in states for x in state.lines])
        energy, _, force = self.integrals.contact(lines, depths[own], self.scene.work_of_adhesion)
        side = np.where(np.arange(lines.size) % 2, 1.0, -1.0)
        return np.array(
            [np.bincount(own, side * part, minlength=len(states)) for part in (energy, force)]
        )

    def force(self, state: State, depth: float) -> float:
        """P."""
        return 0.0 if state is None else float(self.totals([state], np.array([depth]))[1, 0])

    def energy(self, state: State, depth: float) -> float:
        """U."""
        return 0.0 if state is None else float(self.totals([state], np.array([depth]))[0, 0])

    def friction(self, before: State, after: State) -> float:
        """w of what closes, which had to be touched, and w_opening - w of what opens."""
        if before is None or after is None or before.level == after.level:
            return 0.0
        grown = self._length(after) - self._length(before)
        w, opening = self.scene.work_of_adhesion, self.scene.opened.work_of_adhesion
        return w * grown if grown > 0 else (w - opening) * grown

    def _length(self, state: Level) -> float:
        bound = self.integrals.at(np.array(state.lines))[4]
        return float((bound[1::2] - bound[::2]).sum())

    def work(self, point: Point, depth: float) -> float:
        """∫P dd from a point to a depth without a jump on the way."""
        return sum(leg.work() for leg in legs(self, point, depth) if isinstance(leg, Levels))

    def observed(self, depths: Array, states: Sequence[Level]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,)."""
        energy, force = self.totals(states, depths)
        return np.array([state.ends for state in states]), force, energy

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError unless the springs are in equilibrium."""
        if state is not None:
            at_level(self.scene, self.profile, depth, state.level, branch="adhered", rtol=self.rtol)
