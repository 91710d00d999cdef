"""The metastable branch of several contacts on the fitted mesh, from event to event.

States are the lines at rest (../fitted/motion.py); between events they move continuously with the
depth. An event is where they do not: a contact begins, two become one, one closes, or a line
jumps over a part of the profile where it has no rest; see ../following.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.fitted.contacts import Contacts
from discretization.fitted.motion import Lines, Motion, free
from discretization.fitted.rests import TIE
from discretization.fitted.several import certified
from discretization.following.events import Events
from discretization.following.smooth import DEGREE, Smooth
from discretization.following.track import Track
from discretization.paths.branch import (
    CREEPING,
    CREEPS,
    BranchBase,
    Pinned,
    Point,
    at_edges,
    legs,
)
from discretization.profile import resolve
from discretization.quadrature import Interval
from discretization.surfaces import surfaces_of
from discretization.surfaces.spectral import rounded
from energy import Scene

Array = NDArray[np.float64]
_MORE = 2 * DEGREE  # of the rule for ∫P dd
_KNOWN, _HALVINGS = 1e-14, 6  # of ∫|P dd|: as well as it is known, and halvings at most


class Held(NamedTuple):
    """Lines in contact from left to right, and the depth at which they are at rest."""

    lines: Lines
    depth: float

    @property
    def ends(self) -> tuple[float, float]:
        """x of the outermost lines; nan where the profile has only been touched."""
        return (self.lines[0], self.lines[-1]) if self.lines else (math.nan, math.nan)


State = Held | None


def _held(lines: Lines, depth: float) -> State:
    return Held(lines, depth) if lines else None


@dataclass(eq=False)
class Tracked:
    """A leg of lines that move smoothly."""

    branch: FittedMany
    start: Point
    end: Point
    after: Point | None
    jumps: bool
    track: Track
    known: dict[float, Array] = field(default_factory=dict)

    @property
    def pinned(self) -> Pinned:
        """What holds the outermost lines on the way."""
        first, last = (self.branch.pinned(point.state) for point in (self.start, self.end))
        if first == last:
            return first
        (between,) = self.points(np.array([(self.start.depth + self.end.depth) / 2]))
        return self.branch.pinned(between.state)

    def points(self, depths: Array) -> list[Point]:
        """The states at depths on the way (n,)."""
        if not depths.size:
            return []
        rows = self._lines(depths).reshape(depths.size, -1)[:, 1:-1].tolist()
        found = zip(depths.tolist(), rows, strict=True)
        ends = {point.depth: point for point in (self.end, self.start)}
        return [ends.get(depth) or Point(depth, _held(tuple(row), depth)) for depth, row in found]

    def forces(self, depths: Array, *, roughly: bool = False) -> Array:
        """P at depths on the way (n,); roughly: from the polynomials of the lines."""
        lines = self.track.lines(depths, roughly=True) if roughly else self._lines(depths)
        return np.asarray(self.branch.smoothly.many(lines, depths)[1])

    def _lines(self, depths: Array) -> Array:
        """Lines (n, ..) at depths, those that are not known yet solved for."""
        asked = depths.tolist()
        new = np.array([depth for depth in asked if depth not in self.known])
        if new.size:
            self.known.update(zip(new.tolist(), self.track.lines(new), strict=True))
        return np.array([self.known[depth] for depth in asked])

    def work(self) -> float:
        """∫P dd from the start to the end, on parts halved until that changes it no more."""
        ends = {self.start.depth, self.end.depth}
        for piece in self.track.pieces:
            ends |= set(piece.depths[:, [0, -1]].ravel().tolist())
        cuts = np.array(sorted(ends, key=lambda depth: abs(depth - self.start.depth)))
        up = self.end.depth > self.start.depth
        found, before = self._integral(cuts), math.nan
        for _ in range(_HALVINGS):
            if abs(found[0] - before) <= _KNOWN * found[1]:
                break
            cuts = np.sort(np.append(cuts, (cuts[1:] + cuts[:-1]) / 2))[:: 1 if up else -1]
            before, found = found[0], self._integral(cuts)
        return found[0]

    def _integral(self, cuts: Array) -> tuple[float, float]:
        """∫P dd and ∫|P| |dd| over parts by twice the points on which the energy balances."""
        steps = np.diff(cuts)[:, None]  # next to the end of a step P may be like a root
        points, weights, _ = rounded(_MORE)
        t = (1 + points) / 2
        depths = cuts[:-1, None] + steps * (t * (2 - t))
        forces = self.forces(depths.ravel()).reshape(depths.shape)
        parts = steps * (1 - t) * weights * forces
        return float(parts.sum()), float(np.abs(parts).sum())


@dataclass(frozen=True, eq=False)
class FittedMany(BranchBase):
    """States of any number of contacts under a prescribed depth; None: detached."""

    scene: Scene
    motion: Motion
    rtol: float

    @classmethod
    def of(cls, scene: Scene, rtol: float, deepest: float) -> FittedMany:
        """deepest: the largest depth of the programme."""
        surfaces = surfaces_of(scene)
        motion = Motion.of(scene, resolve(scene, deepest), surfaces, deepest)
        return cls(scene, motion, rtol)

    @functools.cached_property
    def events(self) -> Events:
        """What follows lines from event to event."""
        return Events(self.motion)

    @property
    def smoothly(self) -> Smooth:
        """What moves lines between events."""
        return self.events.trials.smooth

    @property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return self.motion.profile.touch

    def contact(self, depth: float, *lines: float) -> State:
        """The state with lines here at a depth; nan: detached."""
        return None if math.isnan(lines[0]) else Held(lines, depth)

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        if before is None and depth < self.touch:
            return None
        here: State = self._touching if before is None else before
        least, creeping = CREEPS * self.motion.rests.size, 0
        while creeping <= CREEPING:
            if here is None or here.depth == depth:
                return here
            part = self.events.part(here.lines, here.depth, depth)
            creeping = creeping + 1 if abs(part.depth - here.depth) <= least else 0
            here = _held(part.lines if part.after is None else part.after, part.depth)
        raise NotCertifiedError(f"the contacts near depth = {depth!r} do not come to rest")

    @functools.cached_property
    def _touching(self) -> Held:
        return Held(self.motion.first(), self.touch)

    def leg(self, point: Point, goal: float) -> Tracked:
        """The way from a point towards another depth, up to the first event or free line."""
        lines, start = point.state.lines, point.depth
        part = self.events.part(lines, start, goal)
        end, after, jumps = Point(part.depth, _held(part.lines, part.depth)), None, False
        if part.after is not None:
            after = Point(part.depth, _held(part.after, part.depth))
            jumps = self._jumps(end, after)
        track = Track(self.smoothly, np.array(free(lines)), part.pieces)
        return Tracked(self, point, end, after, jumps, track)

    def pinned(self, state: State) -> Pinned:
        """What holds each of the outermost lines: "edge", "tip" of a convex profile, or ""."""
        tip, held = self.motion.profile.lowest, at_edges(self.scene, state)
        if state is None or not self.motion.gradual or tip not in self.scene.indenter.corners:
            return held
        tips = (x == tip for x in state.ends)
        first, last = (edge or "tip" * at for edge, at in zip(held, tips, strict=True))
        return first, last

    def _jumps(self, before: Point, after: Point) -> bool:
        """Whether lines jump; not by what the energy changes within the rounding of a depth."""
        if after.state is None or before.state is None:
            return not self.motion.gradual
        if len(before.state.lines) != len(after.state.lines):
            return True
        (first, force), (second, other) = (self._totals(p.state, p.depth) for p in (before, after))
        noise = TIE * self.motion.rests.size * (abs(force) + abs(other))
        return self.events.happens(before.state.lines, after.state.lines) and first - second > noise

    def _totals(self, state: Held, depth: float) -> tuple[float, float]:
        return self.smoothly.totals(np.array(free(state.lines)), depth)

    def force(self, state: State, depth: float) -> float:
        """P."""
        return 0.0 if state is None else self._totals(state, depth)[1]

    def energy(self, state: State, depth: float) -> float:
        """U."""
        return 0.0 if state is None else self._totals(state, depth)[0]

    def friction(self, before: State, after: State) -> float:
        """Lost to adhesion hysteresis: w_opening - w of what opened without a jump."""
        if before is None or after is None or self.scene.opening is None:
            return 0.0
        bound = [self.smoothly.integrals.at(np.array(s.lines))[4] for s in (before, after)]
        opened = np.maximum((bound[0] - bound[1]).reshape(-1, 2) * (-1, 1), 0.0)
        more = self.scene.opened.work_of_adhesion - self.scene.work_of_adhesion
        return more * float(opened.sum())

    def work(self, point: Point, depth: float) -> float:
        """∫P dd from a point to a depth without a jump on the way."""
        return sum(leg.work() for leg in legs(self, point, depth) if isinstance(leg, Tracked))

    def observed(self, depths: Array, states: Sequence[Held]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,)."""
        found, counts = np.empty((2, depths.size)), np.array([len(s.lines) for s in states])
        for count in np.unique(counts).tolist():
            own = np.flatnonzero(counts == count)
            lines = np.array([free(states[i].lines) for i in own.tolist()])
            found[:, own] = self.smoothly.many(lines, depths[own])
        return np.array([state.ends for state in states]), found[1], found[0]

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError unless the state is in equilibrium."""
        if state is None or not state.lines:
            return
        contacts = Contacts(self.motion, state.lines, depth)
        energy, force = self._totals(state, depth)
        pulls, area = contacts.pulls, sum(each.area for each in contacts.free)
        press = force - float(pulls.sum())
        scale = abs(press) + float(np.abs(pulls).sum())
        found = Interval(energy, force, press + area, abs(energy), scale, math.nan)
        try:
            certified(contacts, found, {}, "adhered")
        except NotCertifiedError as problem:
            raise NotCertifiedError(
                f"{problem}: the path stops before it; try other depths, or method='lattice'"
            ) from None
