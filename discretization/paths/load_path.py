"""A load path under way: from one value of the control to the next, cut at the events it meets."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.paths.branch import CREEPING, CREEPS, Branch, Leg, Pinned, Point
from discretization.paths.control import Control, Curve
from discretization.paths.events import Event

Array = NDArray[np.float64]
_FIRST = 1 / 2  # of δ₀ and the depth: legs under a load of unknown length
_LONGER, _LONGEST = 1.5, 4.0  # legs than what is left asks for, and than the one before
_CLOSE = 1e-9  # of δ₀ and the depth: so close to where the profile ends nothing is looked for
_SHORTEST = 40  # halvings of a leg that is refused: beyond the known profile there is none


@dataclass(eq=False)
class LoadPath:
    """A path under way: where it is, and what has been recorded.

    value: of the control, at which the point is in equilibrium.
    """

    branch: Branch
    control: Control
    point: Point
    value: float = -math.inf
    step: int = 0
    friction: float = 0.0
    pinned: Pinned = ("", "")
    reach: float = math.inf
    rate: float = 0.0
    creeping: int = 0
    points: list[Point] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)

    @property
    def dead(self) -> bool:
        """Whether the indenter is held by a dead load."""
        return self.control.stiffness == 0

    def go(self, values: Array) -> None:
        """To these values of the control (n,), one after the other."""
        if self.dead and self.step == 0 and values[0] < 0:  # a load that pulls needs a contact
            self._touch()
            self.value = 0.0
        for part in _one_way(values, self.value):
            left, side = part, 1 if part[-1] >= self.value else -1
            self.reach, self.rate = math.inf, 0.0
            while left.size:
                move = self._apart if self.point.lines is None else self._pushed
                left = left[move(left, side) :]
            self.value = float(part[-1])

    def recorded(self) -> tuple[list[Point], list[Event], float]:
        """Steps, events and friction since the last call."""
        found = list(self.points), list(self.events), self.friction
        self.points.clear()
        self.events.clear()
        self.friction = 0.0
        return found

    # out of contact

    def _apart(self, values: Array, side: int) -> int:
        """Detached until one of the values brings the indenter to touch: how many do not."""
        reached = values >= self._free
        count = int(np.argmax(reached)) if reached.any() else values.size
        if self.dead and self.step == 0 and count:
            raise ValueError(
                f"forces[0] = {float(values[0])!r} is below the pull-off force "
                f"{self.events[-1].force!r}: a path under force control starts at first touch; "
                "begin with a larger force"
            )
        for value in values[:count].tolist():
            self._add([Point(-math.inf if self.dead else value, None)])
        if count < values.size:
            self._touch()
        return count

    @property
    def _free(self) -> float:
        """The value of the control at first touch, where nothing is pressed yet."""
        return float(self.control.value(self.branch.touch, 0.0))

    def _touch(self) -> None:
        """The indenter touches, and is pulled in by adhesion."""
        after = self.branch.first
        pulled = self.branch.lift > 0 and self.branch.force(after) < 0
        if self.control.stiffness is not None and pulled:
            after = self._landing(after, self._free, 1)
        self._record("touch", self._free, Point(self.branch.touch, None), after)
        self.point, self.pinned = after, self.branch.pinned(after)

    # in contact

    def _pushed(self, values: Array, side: int) -> int:
        """Along one leg towards the last of the values: how many are reached on it."""
        if self.control.stiffness is None:
            return self._moved(values, side)
        far = self._distance(values)
        leg = self._leg(self.point, side * far)
        curve = Curve.of(leg, self.control)
        top = curve.peak(side)
        found = curve.reaches(values, side, 0, top)
        missed = np.isnan(found)
        reached = int(missed.argmax()) if missed.any() else values.size
        self._add(leg.points(leg.depths(found[:reached])))
        self._measure(leg, far, curve.value)
        if reached < values.size:
            if top < curve.t.size - 1:
                self._turn(curve, top, side)
            else:
                self._end(leg, side)
        return reached

    def _moved(self, values: Array, side: int) -> int:
        """The same under an imposed depth."""
        far = side * (values - self.point.depth)
        if far[0] == 0:
            self._add([self.point])
            return 1
        asked = min(float(far[-1]), self.reach)
        leg = self._leg(self.point, side * asked, float(far[0]))
        ahead = side * (values - leg.end.depth)
        stays = leg.after is None or (
            leg.after.lines is None and leg.end.depth == self.branch.touch
        )
        reached = int(((ahead < 0) | ((ahead == 0) & stays)).sum())
        self._add(leg.points(values[:reached]))
        self._measure(leg, asked, np.empty(0))
        if reached < values.size:
            self._end(leg, side)
        return reached

    def _leg(self, point: Point, way: float, least: float = 0.0) -> Leg:
        """A leg of that length, or shorter where the profile is not known so far.

        least: the length of which a refusal counts.
        """
        size = abs(point.depth - self.branch.touch) + self.branch.lift
        least = max(least, _CLOSE * size)
        for turn in range(_SHORTEST):
            goal = point.depth + way * 0.5**turn
            try:
                leg = self.branch.leg(point, goal)
                break
            except (ValueError, NotCertifiedError):
                if abs(way) * 0.5**turn <= least or turn == _SHORTEST - 1:
                    raise
        done = abs(leg.end.depth - point.depth)
        slow = done <= min(CREEPS * size, least / 2) and not leg.jumps
        self.creeping = self.creeping + 1 if slow else 0
        if self.creeping > CREEPING:
            self.branch.certify(leg.end)
            raise NotCertifiedError(
                f"the contacts at depth = {point.depth!r} do not come to rest; try other depths"
            )
        if point is self.point:
            self._hold(leg.pinned)
        return leg

    def _distance(self, values: Array) -> float:
        """How far to look ahead for the last of these values."""
        rate, depth = self.rate, self.point.depth
        off = abs(float(values[-1]) - self._value(self.point))
        size = _FIRST * (abs(depth - self.branch.touch) + self.branch.lift)
        first = size or off / self.branch.scene.layer.modulus
        aim = _LONGER * off / rate if rate > 0 else math.inf
        return min(aim, self.reach if math.isfinite(self.reach) else first)

    def _measure(self, leg: Leg, asked: float, value: Array) -> None:
        """What is known after a leg of how long the next one should be."""
        done = abs(leg.end.depth - leg.start.depth)
        self.reach = done * (_LONGEST if done >= asked else _LONGER)
        if value.size and done:
            self.rate = abs(float(value[-1] - value[0])) / done

    def _hold(self, pinned: Pinned) -> None:
        """Events of lines that leave or reach a corner where the path is."""
        if pinned == self.pinned:
            return
        value, changes = self._value(self.point), list(zip(self.pinned, pinned, strict=True))
        for place in dict.fromkeys(was for was, now in changes if was and was != now):
            self._record(f"{place} depinning", value, self.point, self.point)
        for place in dict.fromkeys(now for was, now in changes if now and was != now):
            self._record(f"{place} pinning", value, self.point, self.point)
        self.pinned = pinned

    def _add(self, points: list[Point]) -> None:
        """Steps of the path on one leg, along which lines move one way."""
        if points:
            self._slide(points[-1])
        self.points += points
        self.step += len(points)

    def _slide(self, there: Point) -> None:
        if self.branch.scene.hysteretic:
            self.friction += self.branch.friction(self.point, there)
        self.point = there

    def _turn(self, curve: Curve, top: int, side: int) -> None:
        """A jump from a peak of C."""
        leg, t = curve.leg, np.array([curve.refined(top, side)])
        (peak,) = leg.points(leg.depths(t))
        self._slide(peak)
        value = self._value(peak)
        landed = curve.reaches(np.array([value]), side, top + 1, curve.t.size - 1)
        if np.isnan(landed[0]):
            after = self._landing(leg.end if leg.after is None else leg.after, value, side)
        else:
            (after,) = leg.points(leg.depths(landed))
        if self._alike(peak, after):
            self._slide(after)
        elif np.isnan(landed[0]):
            self._jump("jump", peak, after, value)
        else:
            self._record("jump", value, peak, after)
            self.point = after

    def _alike(self, one: Point, other: Point) -> bool:
        """Whether lines are the same as well as they are known."""
        first, second = one.lines or (), other.lines or ()
        if not first or len(first) != len(second):
            return False
        return bool(np.abs(np.subtract(first, second)).max() <= self.branch.resolution)

    def _end(self, leg: Leg, side: int) -> None:
        """What happens at the end of a leg."""
        self._slide(leg.end)
        if leg.after is None:
            return
        if not leg.jumps and leg.after.lines is not None:
            self.point = leg.after
            return
        if not leg.jumps and self.control.stiffness is None:
            self._hold(("", ""))
        kind, value = _kind_of_jump(leg.end, leg.after, side > 0), self._value(leg.end)
        self._jump(kind, leg.end, self._landing(leg.after, value, side), value)

    def _jump(self, kind: str, before: Point, after: Point, value: float) -> None:
        """A jump at a value of the control."""
        if after.lines is None and self.control.stiffness is not None:
            kind = "pull-off"
        self._record(kind, value, before, after)
        self.point, self.pinned = after, self.branch.pinned(after)

    def _landing(self, here: Point, value: float, side: int) -> Point:
        """The first point from here on at which C is this value; detached if there is none.

        Events on the way happen: contacts that begin pull at an indenter that moves in, and those
        that close have pulled at one that moves out, so that no event holds it.
        """
        step = _FIRST * (abs(here.depth - self.branch.touch) + self.branch.lift)
        while here.lines is not None:
            if side * (self._value(here) - value) >= 0:
                return here
            leg = self._leg(here, side * step)
            curve = Curve.of(leg, self.control)
            found = curve.reaches(np.array([value]), side, 0, curve.t.size - 1)
            if not np.isnan(found[0]):
                return leg.points(leg.depths(found))[0]
            step = 2 * abs(leg.end.depth - here.depth) or step
            here = leg.end if leg.after is None else leg.after
        return Point(here.depth if self.dead else value, None)

    def _value(self, point: Point) -> float:
        return float(self.control.value(point.depth, self.branch.force(point)))

    def _record(self, kind: str, value: float, before: Point, after: Point) -> None:
        self.branch.certify(after)
        first, second = self.branch.snapshot(before), self.branch.snapshot(after)
        done = self.control.work(before.depth, after.depth, value)
        released = first.energy - second.energy + done
        if kind == "touch" and released > 0:
            kind = "jump-in"
        self.events.append(Event(kind, value, first, second, released, self.step))


def _kind_of_jump(before: Point, after: Point, rising: bool) -> str:
    """What a jump does to the number of contacts."""
    more = len(after.inner) - len(before.inner)
    if after.lines is None or more == 0:
        return "detachment" if after.lines is None else "jump"
    grown, shrunk = ("nucleation", "coalescence") if rising else ("splitting", "closing")
    return grown if more > 0 else shrunk


def _one_way(values: Array, value: float) -> Iterator[Array]:
    """The values in parts that rise or fall."""
    steps = np.sign(np.diff(np.concatenate([[value], values])))
    start, side = 0, 0.0
    for i, step in enumerate(steps.tolist()):
        if step * side < 0:
            yield values[start:i]
            start, side = i, step
        side = side or step
    yield values[start:]
