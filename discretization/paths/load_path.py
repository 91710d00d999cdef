"""A load path under way: from one value of the control to the next, cut at the events it meets."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from discretization.paths.branch import Branch, Point, State
from discretization.paths.control import Control, jumped, lost_point, moved, settled
from discretization.paths.events import Event, Snapshot

Array = NDArray[np.float64]
_TINY = 4e-16  # of the depth: brackets of a change this short are closed
_LEAST = 1e-18  # for events at depth 0
_NEAR = 1e-9  # of the depth and δ₀: another event than the one that made a state unstable


@dataclass(eq=False)
class LoadPath:
    """A path under way: where it is, and what has been recorded.

    value: of the control, at which the point is in equilibrium.
    """

    branch: Branch
    control: Control
    point: Point
    value: float = 0.0
    step: int = 0
    friction: float = 0.0
    points: list[Point] = field(default_factory=list)
    trail: list[tuple[float, float]] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)

    def go(self, value: float) -> None:
        """To the next value of the control."""
        dead = self.control.stiffness == 0
        if self.point.state is None:
            self._approach(max(value, 0.0) if dead and self.step == 0 else value)
        if self.point.state is not None:
            if self.control.stiffness is None:
                self._move(value)
            else:
                self._settle(value)
        if self.step == 0 and dead and self.point.state is None:
            raise ValueError(
                f"forces[0] = {value!r} is below the pull-off force {self.events[-1].force!r}: a "
                "path under force control starts at first touch; begin with a larger force"
            )
        self.points.append(self.point)
        self.trail = [*self.trail[-1:], (value, self.point.depth)]
        self.step += 1

    def recorded(self) -> tuple[Array, list[State], list[Event], float]:
        """Depths, states, events and friction since the last call."""
        depths = np.array([point.depth for point in self.points])
        found = depths, [p.state for p in self.points], list(self.events), self.friction
        self.points.clear()
        self.events.clear()
        self.friction = 0.0
        return found

    def _approach(self, value: float) -> None:
        """Detached: touch, if the programme brings the indenter there."""
        free = self.control.value(self.branch.touch, 0.0)
        if value < free:
            depth = value if self.control.stiffness != 0 else -math.inf
            self.point = Point(depth, None)
            return
        touching = Point(self.branch.touch, self.branch.follow(None, self.branch.touch))
        after = touching
        if self.control.stiffness is not None:
            after = self._pulled_in(touching, free)
        before = Point(self.branch.touch, None)
        self._record("touch", free, before, after)
        self.point, self.value = after, free

    def _pulled_in(self, touching: Point, value: float) -> Point:
        """From touching at zero load to where the adhesion has pulled the indenter in."""
        if not self.branch.lift or self.branch.force(touching.state, touching.depth) >= 0:
            return touching
        found = jumped(self.branch, self.control, touching, value, 1.0)
        if found is None:
            raise RuntimeError(f"no equilibrium under load {value!r} after touching")
        return found

    def _rate(self) -> float:
        """P' + K between the last two steps, as a guess for the next; 0 if there is none."""
        if len(self.trail) < 2:
            return 0.0
        (value, depth), (later, deeper) = self.trail[-2:]
        rate = (later - value) / (deeper - depth) if deeper != depth else 0.0
        rate *= self.control.stiffness or 1.0
        return rate if math.isfinite(rate) else 0.0

    def _settle(self, value: float) -> None:
        """Under force or machine control: follow equilibria; jump where there is none."""
        found = settled(self.branch, self.control, self.point, self.value, value, self._rate())
        self.value = value
        if isinstance(found, Point):
            self._on(found)
            return
        side = 1.0 if found.closes.depth > self.point.depth else -1.0
        self._on(found.point)
        before, closes = self.point, found.closes
        at = self.control.value(before.depth, self.branch.force(before.state, before.depth))
        kind, after = self._left(before, closes, at, side)
        if after is not None and not self._differs(before, after):  # P fell and rose in between
            at, after = value, jumped(self.branch, self.control, before, value, side)
        if after is not None and self._differs(before, after):
            self._record(kind, at, before, after)
            self.point, self.value = after, at
            self._settle(value)
            return
        free = lost_point(self.branch, before).depth if self.control.stiffness == 0 else at
        self._record("pull-off", at, before, Point(free, None))
        self.point = Point(free, None)
        self._approach(value)

    def _differs(self, before: Point, after: Point) -> bool:
        """Whether an indenter that left a point has come to another one."""
        more = len(inner_lines(after.state)) != len(inner_lines(before.state))
        return more or abs(after.depth - before.depth) > 1e-6 * self.branch.lift

    def _on(self, found: Point) -> None:
        """To an equilibrium without an event in between, but for a line that is held otherwise."""
        if self._held(found) == self._held(self.point):
            self._slide(found)
        else:
            self._move(found.depth)

    def _left(
        self, before: Point, closes: Point, at: float, side: float
    ) -> tuple[str, Point | None]:
        """Where an indenter comes to that leaves a point at a fixed control, and what that is.

        The point is unstable, or something happens to the contact there, at `closes`.
        """
        start, kind = before, "jump"
        if before.depth == closes.depth:
            state, depth = before.state, before.depth
            near = _NEAR * (self.branch.lift + abs(depth))
            jump = self.branch.jump(state, depth, depth + 2 * side * near)
            if jump is None:
                beyond = depth + side * max(self.branch.lift, abs(depth))
                jump = self.branch.jump(state, depth, beyond)
            if jump is None or jump[2] is None:
                return kind, None
            if abs(jump[0] - depth) > near:
                return kind, jumped(self.branch, self.control, before, at, side)
            start = Point(jump[0], jump[2])
            kind = _kind(before.state, start.state, side > 0)
            off = self.branch.force(start.state, start.depth) - self.control.load(start.depth, at)
            side = -1.0 if off > 0 else 1.0
        if not self.branch.lift:  # without adhesion nothing is in equilibrium beyond
            return kind, None
        return kind, jumped(self.branch, self.control, start, at, side)

    def _move(self, depth: float) -> None:
        """To another depth, cut at the events on the way."""
        while True:
            jump = self.branch.jump(self.point.state, self.point.depth, depth)
            if jump is not None:
                at, inside, outside = (jump[0], *(Point(jump[0], state) for state in jump[1:]))
                self._slide(inside)
                self._record(_kind(inside.state, outside.state, depth > at), at, inside, outside)
                self.point = outside
                if outside.state is None:
                    self.point = Point(min(depth, at), None)
                    return
                continue
            there = moved(self.branch, self.point, depth)
            if self._held(there) == self._held(self.point):
                self._slide(there)
                return
            inside, outside = self._change(there)
            self._slide(inside)
            self._held_otherwise(inside, outside)
            self.point = outside
            if outside.state is None:
                if depth < outside.depth:
                    self.point = Point(depth, None)
                return

    def _slide(self, there: Point) -> None:
        if self.branch.scene.hysteretic:
            self.friction += self.branch.friction(self.point.state, there.state)
        self.point = there

    def _held(self, point: Point) -> tuple[bool, tuple[str, str]]:
        return point.state is not None, self.branch.pinned(point.state)

    def _change(self, there: Point) -> tuple[Point, Point]:
        """The last point held as here and the first one held otherwise."""
        inside, outside, held = self.point, there, self._held(self.point)
        size = abs(inside.depth) + abs(outside.depth) + self.branch.lift
        while True:
            depth = (inside.depth + outside.depth) / 2
            close = abs(inside.depth - outside.depth) <= _TINY * min(size, 4 * abs(depth))
            if close or abs(inside.depth - outside.depth) <= _LEAST * size:
                return inside, outside
            middle = moved(self.branch, self.point, depth)
            if self._held(middle) == held:
                inside = middle
            else:
                outside = middle

    def _held_otherwise(self, inside: Point, outside: Point) -> None:
        """Events of one change: lines that leave or reach a corner, contact lost."""
        value = self.control.value(inside.depth, self.branch.force(inside.state, inside.depth))
        (_, old), (_, new) = self._held(inside), self._held(outside)
        for place in dict.fromkeys(
            was for was, now in zip(old, new, strict=True) if was and was != now
        ):
            after = inside if outside.state is None else outside
            self._record(f"{place} depinning", value, inside, after)
        for place in dict.fromkeys(
            now for was, now in zip(old, new, strict=True) if now and was != now
        ):
            self._record(f"{place} pinning", value, inside, outside)
        if outside.state is None:
            self._record("detachment", value, inside, Point(inside.depth, None))

    def _record(self, kind: str, value: float, before: Point, after: Point) -> None:
        self.branch.certify(after.state, after.depth)
        first, second = self._snapshot(before), self._snapshot(after)
        released = first.energy - second.energy
        if before.depth != after.depth:
            released += self.control.potential(before.depth, value)
            released -= self.control.potential(after.depth, value)
        if kind == "touch" and released > 0:
            kind = "jump-in"
        self.events.append(Event(kind, value, first, second, released, self.step))

    def _snapshot(self, point: Point) -> Snapshot:
        depth, state = point
        left, right = (math.nan, math.nan) if state is None else state.ends
        force, energy = self.branch.force(state, depth), self.branch.energy(state, depth)
        turned = self.branch.scene.axisymmetric
        return Snapshot(depth, force, energy, left, right, inner_lines(state), turned)


def inner_lines(state: State) -> tuple[float, ...]:
    """The lines between the outermost ones, where there are several contacts."""
    return tuple(getattr(state, "lines", ())[1:-1])


def _kind(before: State, after: State, rising: bool) -> str:
    """What a jump does to the number of contacts."""
    if after is None:
        return "detachment"
    more = len(inner_lines(after)) - len(inner_lines(before))
    if more == 0:
        return "jump"
    if more > 0:
        return "nucleation" if rising else "splitting"
    return "coalescence" if rising else "closing"
