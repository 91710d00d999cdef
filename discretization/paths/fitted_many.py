"""The metastable branch of several contacts on the fitted mesh, from event to event (small slopes).

States are the lines at rest (fitted_moves.py); between events they move continuously with the
depth. An event is where they do not: a contact begins, two become one, one closes, or a line
jumps over a part of the profile where it has no rest. It is enclosed by halving the depths until
they are neighbouring numbers.
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.equilibrium import AccuracyWarning
from discretization.fitted.contacts import FittedContacts, totals
from discretization.fitted.lines import FittedLine, Problem
from discretization.fitted.quadrature import Interval
from discretization.fitted.response import chosen
from discretization.fitted.several import sample_points, state_of
from discretization.paths.clearance import Clearance
from discretization.paths.fitted_branch import integral
from discretization.paths.fitted_moves import Lines, Moves
from discretization.paths.gap_moves import GapMoves
from discretization.paths.line_levels import Levels
from discretization.paths.stops import Ground
from energy import Scene

Array = NDArray[np.float64]
_CLOSE = 4e-16
_TIE = 1e-14
_ASIDE = 1e-9
_RESOLVED = 1 / 16
_PER_LENGTH = 16
_FINEST = 64
_WORK = 1e-10
_MOST_CORNERS = 64
_MOST_POINTS = 200_000


class Held(NamedTuple):
    """Lines in contact, from left to right."""

    lines: Lines

    @property
    def ends(self) -> tuple[float, float]:
        """x of the outermost lines."""
        return self.lines[0], self.lines[-1]


State = Held | None


@dataclass(frozen=True, eq=False)
class FittedMany:
    """States of any number of contacts under a prescribed depth; None: detached."""

    scene: Scene
    moves: Moves
    touch: float
    rtol: float

    @classmethod
    def of(cls, scene: Scene, rtol: float, deepest: float) -> FittedMany:
        """deepest: the largest depth of the programme. ValueError for what cannot be followed."""
        _refuse(scene)
        points, step = _sampled(scene, deepest)
        indenter, length = scene.indenter, scene.elastocapillary_length
        ground = Ground(np.asarray(indenter.corners, float), step, _ASIDE * length)
        far = _FINEST * length
        ends = (max(indenter.extent[0], points[0] - far), min(indenter.extent[1], points[-1] + far))
        heights = np.asarray(indenter.height(points), float)
        levels = Levels(scene, chosen(scene.slopes, rtol))
        clearance = Clearance(scene, levels.response, points, heights)
        moves = Moves(levels, ground, GapMoves(levels, ground), clearance, ends)
        return cls(scene, moves, clearance.lowest(), rtol)

    @property
    def smooth(self) -> bool:
        """Whether P is a smooth function of d between events."""
        return True

    @property
    def lift(self) -> float:
        """How far below touching a contact can be held."""
        return self.scene.critical_separation

    @property
    def _tie(self) -> float:
        """A length below which v is rounding."""
        return _TIE * (self.lift + abs(self.touch))

    def contact(self, *lines: float) -> State:
        """The state with lines here; nan: detached."""
        return None if math.isnan(lines[0]) else Held(lines)

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        if before is None and depth < self.touch:
            return None
        if before is not None:
            near = self._at(before, depth, -self._tie, False)
            if self._alike(before, near):
                return near
        return self._at(before, depth, self._tie if before is None else -self._tie, True)

    @functools.lru_cache(maxsize=64)  # noqa: B019
    def _at(self, before: State, depth: float, tie: float, exact: bool) -> State:
        lines = () if before is None else before.lines
        found = self.moves.relaxed(lines, depth, tie, exact)
        return Held(found) if found else None

    def jump(self, state: State, start: float, end: float) -> tuple[float, State, State] | None:
        """First depth on the way at which lines do not move continuously, and the states there."""
        if state is None or start == end:
            return None
        tie = self._tie if end > start else -self._tie
        while state is not None and (found := self._broken(state, start, end)) is not None:
            start, here = found
            state = self._at(here, start, tie, True)
            if not self._alike(here, state):
                return start, here, state
        return None

    def _broken(self, state: Held, start: float, end: float) -> tuple[float, Held] | None:
        """Where lines seem to be moved on discontinuously, and the last state before."""
        parts: list[tuple[float, State, float, State]]
        parts = [(start, state, end, self._at(state, end, -self._tie, False))]
        while parts:
            low, here, high, there = parts.pop()
            if here is None or self._alike(here, there):
                continue
            middle = (low + high) / 2
            close = abs(high - low) <= _CLOSE * (abs(middle) + self.lift)
            if close or middle in (low, high):
                return high, here
            between = self._at(here, middle, -self._tie, False)
            parts += [(middle, between, high, there), (low, here, middle, between)]
        return None

    def _alike(self, here: State, there: State) -> bool:
        """Whether the lines are the same, less than a step apart, with no corner between."""
        if there is None or here is None or len(here.lines) != len(there.lines):
            return False
        pairs, ground = list(zip(here.lines, there.lines, strict=True)), self.moves.ground
        if max(abs(a - b) for a, b in pairs) > ground.step:
            return False
        return not any(a != b and self._reentrant(a, b) for a, b in pairs)

    def _reentrant(self, a: float, b: float) -> bool:
        """Whether there is a corner between at which the slope falls."""
        ground = self.moves.ground
        corners = np.array([*ground.between(a, b), *(x for x in (a, b) if ground.at_corner(x))])
        slope, aside = self.scene.indenter.slope, ground.aside
        return bool((slope(corners + aside) < slope(corners - aside)).any())

    def pinned(self, state: State) -> tuple[str, str]:
        """What holds the outermost lines: "edge" or "" where they are free."""
        if state is None:
            return ("", "")
        walls = self.scene.indenter.walls
        left, right = ("edge" if x in walls else "" for x in state.ends)
        return left, right

    def _contacts(self, state: Held, depth: float) -> FittedContacts:
        at_corner, walls = self.moves.ground.at_corner, self.scene.indenter.walls
        lines = [FittedLine(x, at_corner(x) or x in walls, False) for x in state.lines]
        reach = self.scene.critical_separation
        problem = Problem(self.scene, depth, self.touch, reach, self.moves.levels.response)
        return FittedContacts(problem, tuple(zip(lines[::2], lines[1::2], strict=True)))

    def _totals(self, state: Held, depth: float) -> Interval:
        return totals(self._contacts(state, depth), 1e-14)[1]

    def force(self, state: State, depth: float) -> float:
        """P."""
        return 0.0 if state is None else self._totals(state, depth).force

    def energy(self, state: State, depth: float) -> float:
        """U."""
        return 0.0 if state is None else self._totals(state, depth).energy

    def friction(self, before: State, after: State) -> float:
        """None: there is one work of adhesion."""
        return 0.0

    def work(self, before: State, start: float, end: float) -> float:
        """∫P dd from one depth to another without a jump on the way, by adaptive Lobatto rules."""
        if before is None:
            return 0.0
        return integral(
            lambda depth: self.force(self.follow(before, depth), depth), start, end, _WORK
        )

    def observed(self, depths: Array, states: Sequence[Held]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,)."""
        found = [self._totals(s, d) for d, s in zip(depths.tolist(), states, strict=True)]
        force, energy = np.array([(one.force, one.energy) for one in found]).T
        return np.array([state.ends for state in states]), force, energy

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError unless the state is in equilibrium."""
        if state is None:
            return
        points = self.moves.clearance.points
        try:
            state_of(self._contacts(state, depth), "adhered", points, self.rtol)
        except NotCertifiedError as problem:
            raise NotCertifiedError(
                f"{problem}: the path stops before it; try other depths, or method='lattice'"
            ) from None


def _refuse(scene: Scene) -> None:
    for name in ("opening", "pattern"):
        given = getattr(scene, name)
        if given is not None:
            raise ValueError(
                f"{name} = {given!r} with a profile that is not convex: the lines are followed on "
                "the lattice; use method='lattice' with a spacing"
            )
    if len(scene.indenter.corners) > _MOST_CORNERS:
        raise ValueError(
            f"indenter has {len(scene.indenter.corners)} corners, each of which stops a contact "
            "line: give Sampled(..., kind='smooth'), or use method='lattice' with a spacing"
        )
    if scene.slopes != "small":
        raise ValueError(
            f"slopes = {scene.slopes!r} with a profile that is not convex, which may have several "
            "contacts: use slopes='small', or a convex profile"
        )
    if not scene.gamma1:
        raise ValueError(
            "gamma1 = 0 with a profile that is not convex: a load path needs surface tension; give "
            "gamma1 > 0"
        )
    if not scene.work_of_adhesion:
        raise ValueError(
            "w = 0 with a profile that is not convex: the state does not depend on the path; use "
            "minimise at every depth"
        )


def _sampled(scene: Scene, deepest: float) -> tuple[Array, float]:
    """Points half a step apart where contact may be, and a step that resolves the slopes."""
    step = scene.elastocapillary_length / _PER_LENGTH
    least, kink = step / _FINEST, math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
    corners = np.asarray(scene.indenter.corners, float)
    while True:
        points = sample_points(scene, deepest, step)
        smooth = np.diff(np.searchsorted(corners, points, side="right")) == 0
        smooth &= np.diff(np.searchsorted(corners, points)) == 0
        slope, middle = scene.indenter.slope(points), (points[1:] + points[:-1]) / 2
        bend = np.abs(scene.indenter.slope(middle) - (slope[1:] + slope[:-1]) / 2)[smooth]
        if bend.max(initial=0.0) <= _RESOLVED * kink:
            return points, step
        if step <= least or points.size > _MOST_POINTS:
            warnings.warn(_unresolved(step), AccuracyWarning, stacklevel=6)
            return points, step
        step /= 2


def _unresolved(step: float) -> str:
    return (
        f"the slope of the profile varies within {step!r}, the least distance at which events are "
        "looked for: some may be missed; smooth the profile, or use method='lattice'"
    )
