"""A load path under way: from one value of the control to the next, cut at the events it meets.

Conventions
-----------
The depth d is positive down into the layer [length], P is positive where the indenter is pressed.
C, the value of the control at which a state is in equilibrium, is d, P or d + P/K (control.py).
`side` is 1 where the values of the control rise, and with them the depth, and -1 where they fall.

A `Point` is the contacts at a depth; its `lines` are None without contact. A `PathSegment` is a
part of the path at imposed depths up to an event, with `after`, the contacts beyond the event, and
`jumps`, whether lines jump there. `Branch.segment(point, goal)` is the first segment from a point
towards a depth. A `Curve` is C along a segment, sampled: `peak(side)` is the number of the first
sample after which side · C falls, the last one if there is none, and `reached(values, side, first,
stop)` are the points at which C first reaches values.

A `Branch` has the states at imposed depths: its `points_of` are the points at depths of many
segments, `total` is U and P of a point, `snapshots` are points with these, `certify` and
`certify_all` raise NotCertifiedError for points that are no equilibria, `resolution` is how far
lines may be off, and `holding_range` is δ₀, how far below the depth of touching a contact may stay.
`hysteretic` scenes hold lines over a range of depths, so that lines lose energy as they move: the
friction. A `Snapshot` has depth, force, energy and lines, nan without contact; the lines between
the outermost ones are `inner`, two more for every further contact. On a `Curve` t grows from 0 to
1, and `refined(top, side)` is the exact peak at a sample. The stiffness K of a `Control` is None
for an imposed depth and 0 for a dead load. How far to look ahead is only a guess: a segment that
goes too far is halved.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.paths.branch import Branch, Event, PathSegment, Pinned, Point, Snapshot
from discretization.paths.control import Control, Curve
from energy.arrays import Array


class StepRules(NamedTuple):
    """How far a path looks ahead, and when it gives up; lengths are of δ₀ and the depth.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 38 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.paths.load_path`.

    Attributes
    ----------
    longer : float
        How far to look ahead next, over the length of the segment before.
    again : float
        The same at least, over what was looked ahead last.
    close : float
        So close to where the profile ends nothing is looked for.
    shortest : float
        Of a segment that raises: 39 halvings find the end of the known profile.
    creeps : float
        Segments that short are those of lines that come free by roundings.
    creeping : int
        So many of these in a row are not followed any further.
    """

    longer: float = 2.0
    again: float = 1 / 4
    close: float = 1e-9
    shortest: float = 2.0**-39
    creeps: float = 1e-11
    creeping: int = 100


_STEP = StepRules()


class Waiting(NamedTuple):
    """Steps on a segment whose points are found once the path is complete.

    Attributes
    ----------
    segment : PathSegment
    depths : ndarray (n,)
        Of the steps [length].
    first : int
        Number of the first of them in `LoadPath.points`.
    """

    segment: PathSegment
    depths: Array
    first: int


class Happened(NamedTuple):
    """What becomes an event, before energies of its states are known.

    Attributes
    ----------
    kind : str
        As of `Event`.
    control : float
        The value of the control at which it happens.
    before, after : Point
        The contacts before and after it.
    step : int
        Number of the step that follows.
    """

    kind: str
    control: float
    before: Point
    after: Point
    step: int


@dataclass(eq=False)
class LoadPath:
    """A path under way: where it is, and what has been recorded.

    Attributes
    ----------
    branch : Branch
        The states at imposed depths.
    control : Control
    point : Point
        Where the path is.
    value : float
        Of the control there.
    step : int
        How many values have been reached.
    friction : float
        Energy lost by lines that moved without a jump.
    pinned : Pinned
        Corners at which the outermost lines are.
    reach : float
        How far to look ahead [length].
    creeping : int
        How many segments in a row have been shorter than roundings.
    points, events : list
        What was recorded at the steps, and between them.
    waiting : list of Waiting
        Steps for which something else stands in `points` so far.
    happened : list of Happened
        What has happened since events were last made of it.
    """

    branch: Branch
    control: Control
    point: Point
    value: float = -math.inf
    step: int = 0
    friction: float = 0.0
    pinned: Pinned = ("", "")
    reach: float = math.inf
    creeping: int = 0
    points: list[Point] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    waiting: list[Waiting] = field(default_factory=list)
    happened: list[Happened] = field(default_factory=list)

    @property
    def dead(self) -> bool:
        """Whether a dead load is on the indenter."""
        return self.control.stiffness == 0

    @property
    def imposed(self) -> bool:
        """Whether its depth is imposed."""
        return self.control.stiffness is None

    def go(self, values: Array) -> None:
        """Follow the path to these values of the control (n,), one after the other.

        Each round does what can be done at once: it goes along one segment towards the last value
        before the control turns, or stays out of contact.
        """
        if self.dead and self.step == 0 and values[0] < 0:  # a load that pulls needs a contact
            self._touch()
            self.value = 0.0
        side = 0
        while values.size:
            steps = np.sign(np.diff(np.append(self.value, values)))
            direction = -1 if next(iter(steps[steps != 0]), 1) < 0 else 1
            if direction != side:
                self.reach = math.inf
                side = direction
            # Up to the first value that goes the other way.
            monotone = values[: int(np.argmax(np.append(side * steps, -1) < 0))]
            if self.point.lines is None:
                done = self._apart(monotone, side)
            else:
                done = self._pushed(monotone, side)
            if done:
                self.value = float(values[done - 1])
            values = values[done:]
        self._find_waiting()
        self._settle()

    def resume(self, last: Snapshot, step: int, value: float) -> None:
        """Go on after so many steps, from this state at this value of the control."""
        self.step = step
        self.value = value
        self.point = Point(last.depth, None)
        if not math.isnan(last.left):
            self.point = self.branch.contact(last.depth, *last.lines)
        self.pinned = self.branch.pinned(self.point)

    # out of contact

    def _apart(self, values: Array, side: int) -> int:
        """Record the values at which the indenter stays detached, and let it touch at the next.

        Parameters
        ----------
        values : ndarray (n,)
            Of the control, in one direction.
        side : {1, -1}
            1 where they rise.

        Returns
        -------
        int
            How many of the values are done, before one that brings it to touch.
        """
        reached = values >= self._value(Point(self.branch.touch, None))
        count = int(np.argmax(reached)) if reached.any() else values.size
        if self.dead and self.step == 0 and count:
            self._settle()
            raise ValueError(
                f"forces[0] = {float(values[0])!r} is below the pull-off force "
                f"{self.events[-1].force!r}: a path under force control starts at first touch; "
                "begin with a larger force"
            )
        if self.imposed and count and self.events and self.events[-1].step == self.step:
            lost = self.events[-1].before
            self.branch.released(float(values[0]), lost.left, lost.right)
        # A dead load pulls the indenter away; the spring of a machine without force is at d = D.
        away = [-math.inf] * count if self.dead else values[:count].tolist()
        self._add([Point(depth, None) for depth in away])
        if count < values.size:
            self._touch()
        return count

    def _touch(self) -> None:
        """Go to where the indenter, having touched, comes to rest when it is pulled in."""
        apart = Point(self.branch.touch, None)
        after = self.branch.first
        if self.branch.holding_range > 0:
            after = self._landing(after, self._value(apart), 1)
        self._jump("touch", apart, after)

    # in contact

    def _pushed(self, values: Array, side: int) -> int:
        """Go along one segment towards the last of the values, and over the event at its end.

        Returns
        -------
        int
            How many of the values are reached on the segment, and recorded.
        """
        least = abs(float(values[0]) - self.point.depth) if self.imposed else 0.0
        if self.imposed and least == 0:
            self._add([self.point])
            return 1
        ahead = self._distance(values)
        segment = self._segment(self.point, side * ahead, least)
        if self.imposed:
            return self._moved(segment, values, side)
        # C rises with the control up to its first peak, where the indenter jumps.
        curve = Curve.of(segment, self.control)
        top = curve.peak(side)
        turns = top < curve.t.size - 1
        points = curve.reached(values, side, 0, top + 1)
        done = abs(segment.end.depth - segment.start.depth)
        self.reach = max(_STEP.longer * done, _STEP.again * ahead) if done else math.inf
        self._add(points)
        if len(points) < values.size and turns:
            self._turn(curve, top, side)
        elif len(points) < values.size:
            self._end(segment, side)
        return len(points)

    def _moved(self, segment: PathSegment, depths: Array, side: int) -> int:
        """Go along a segment towards the last of imposed depths; how many are reached on it.

        A depth at the end of the segment is reached on it if nothing happens there, or if the last
        contact is lost just at the depth of touching; otherwise it is reached after the event.
        """
        beyond = side * (depths - segment.end.depth)
        lost_at_touch = segment.after is not None and segment.after.lines is None
        lost_at_touch = lost_at_touch and segment.end.depth == self.branch.touch
        stays = segment.after is None or lost_at_touch
        reached = depths[(beyond < 0) | ((beyond == 0) & stays)]
        if reached.size < depths.size:
            self._add_later(segment, reached)
            self._end(segment, side)
        else:  # the path turns round, or ends, at the last of them
            self._add_later(segment, reached[:-1])
            self._add(segment.points(reached[-1:]))
        return reached.size

    def _segment(self, point: Point, length: float, least: float = 0.0) -> PathSegment:
        """The segment from a point on, towards a depth this signed length away.

        Where the branch raises an error, such as that of a profile which is not known so far, half
        the length is tried, down to `least`, at which the error is raised.
        """
        size = self._size(point)
        least = max(least, _STEP.close * size, _STEP.shortest * abs(length))
        while True:
            try:
                segment = self.branch.segment(point, point.depth + length)
                break
            except (ValueError, NotCertifiedError):
                if abs(length) <= least:
                    raise
                length /= 2
        done = abs(segment.end.depth - point.depth)
        slow = done <= min(_STEP.creeps * size, least / 2) and not segment.jumps
        self.creeping = self.creeping + 1 if slow else 0
        if self.creeping > _STEP.creeping:
            self.branch.certify(segment.end)
            raise NotCertifiedError(
                f"the contacts at depth = {point.depth!r} do not come to rest; try other depths"
            )
        if point is self.point:
            self._hold(segment.pinned)
        return segment

    def _distance(self, values: Array) -> float:
        """How far to look ahead for the last of these values [length].

        Under a load or a machine not much further than before: the depths at which they balance
        the force are not known.
        """
        if self.imposed:
            return abs(float(values[-1]) - self.point.depth)
        if math.isfinite(self.reach):
            return self.reach
        # At first touch without adhesion no length is known: then one is guessed from the force.
        off = abs(float(values[-1]) - self._value(self.point))
        return self._size(self.point) / 2 or off / self.branch.scene.layer.modulus

    def _size(self, point: Point) -> float:
        """A length by which depths change at a point: its distance from first touch, and δ₀."""
        return abs(point.depth - self.branch.touch) + self.branch.holding_range

    def _hold(self, pinned: Pinned) -> None:
        """Record events of outermost lines that have left or reached a corner where the path is.

        pinned: where they are pinned from here on, "edge", "tip" or "" for the left and the right
        one.
        """
        changes = ((self.pinned, pinned, "depinning"), (pinned, self.pinned, "pinning"))
        for here, there, what in changes:
            both = zip(here, there, strict=True)
            # Both lines at one kind of place are one event.
            for place in dict.fromkeys(one for one, other in both if one and one != other):
                self._record(f"{place} {what}", self.point, self.point)
        self.pinned = pinned

    def _add(self, points: list[Point]) -> None:
        """Record steps of the path on one segment, along which lines move in one direction."""
        if points:
            self._slide(points[-1])
        self.points += points
        self.step += len(points)

    def _add_later(self, segment: PathSegment, depths: Array) -> None:
        """Record steps at depths (n,) on a segment; `_find_waiting` puts their points in place."""
        if depths.size:
            self.waiting.append(Waiting(segment, depths, len(self.points)))
            self.points += [segment.start] * depths.size
            self.step += depths.size

    def _find_waiting(self) -> None:
        """Find the points of the steps that wait for them, of all segments together."""
        parts = [(steps.segment, steps.depths) for steps in self.waiting]
        found = self.branch.points_of(parts)
        for steps, points in zip(self.waiting, found, strict=True):
            self.points[steps.first : steps.first + len(points)] = points
        self.waiting = []

    def _slide(self, there: Point) -> None:
        """Move on to a point along a segment; what lines lose there to hysteresis is friction."""
        if self.branch.scene.hysteretic:
            self.friction += self.branch.friction(self.point, there)
        self.point = there

    def _turn(self, curve: Curve, top: int, side: int) -> None:
        """Jump from a peak of C, at the sample `top` of the curve, to where C is this value again.

        That is further on the same segment, or beyond its end.
        """
        segment = curve.segment
        peak = curve.refined(top, side)
        self._slide(peak)
        value = self._value(peak)
        landed = curve.reached(np.array([value]), side, top + 1)
        after = landed[0] if landed else self._landing(segment.after or segment.end, value, side)
        first = peak.lines or ()
        second = after.lines or ()
        if len(first) == len(second) and np.allclose(first, second, 0.0, self.branch.resolution):
            self._slide(after)  # lines are not known well enough to call it a jump
        else:
            self._jump("jump", peak, after)

    def _end(self, segment: PathSegment, side: int) -> None:
        """Go to the end of a segment, and over the event there if there is one."""
        self._slide(segment.end)
        after = segment.after or segment.end
        if not segment.jumps and after.lines is not None:
            self._slide(after)
            return
        if not segment.jumps and self.imposed:
            self._hold(("", ""))
        kind = _kind_of_jump(segment.end, after, side > 0)
        self._jump(kind, segment.end, self._landing(after, self._value(segment.end), side))

    def _jump(self, kind: str, before: Point, after: Point) -> None:
        """Record a jump, and go to where it ends."""
        if after.lines is None and not self.imposed:
            kind = "pull-off"
        self._record(kind, before, after)
        self.point = after
        self.pinned = self.branch.pinned(after)

    def _landing(self, here: Point, value: float, side: int) -> Point:
        """The first point from here on at which side · C is not less than a value.

        Detached if contact is lost before; under a dead load it is then at the depth of the loss,
        otherwise where the control has the indenter without force. Events on the path happen:
        contacts that begin pull at an indenter that moves in, and those that close have pulled at
        one that moves out, so that no event holds it.
        """
        step = self._size(here) / 2
        while here.lines is not None:
            if side * (self._value(here) - value) >= 0:
                return here
            segment = self._segment(here, side * step)
            landed = Curve.of(segment, self.control).reached(np.array([value]), side, 0)
            if landed:
                return landed[0]
            step = 2 * abs(segment.end.depth - here.depth) or step
            here = segment.after or segment.end
        return Point(here.depth if self.dead else value, None)

    def _value(self, point: Point) -> float:
        """C at a point; a detached one has no force."""
        force = 0.0 if self.imposed else self.branch.total(point)[1]
        return float(self.control.value(point.depth, force))

    def _record(self, kind: str, before: Point, after: Point) -> None:
        """Remember what becomes an event, at the value of the control before it."""
        self.happened.append(Happened(kind, self._value(before), before, after, self.step))

    def _settle(self) -> None:
        """Make events of what has happened since the last time, certified and with energies.

        What is released is the drop of U and the work of the control.
        """
        self.branch.certify_all([each.after for each in self.happened])
        points = [point for each in self.happened for point in (each.before, each.after)]
        states = iter(self.branch.snapshots(points))
        for kind, value, before, after, step in self.happened:
            state_before = next(states)
            state_after = next(states)
            work = self.control.work(before.depth, after.depth, value)
            released = state_before.energy - state_after.energy + work
            if kind == "touch" and released > 0:
                kind = "jump-in"
            self.events.append(Event(kind, value, state_before, state_after, released, step))
        self.happened = []


def _kind_of_jump(before: Point, after: Point, rising: bool) -> str:
    """The kind of a jump, as of `Event`, by what it does to the number of contacts.

    rising: whether the control rises.

    before, after: both in contact, or `after` detached.
    """
    if after.lines is None:
        return "detachment"
    more = len(after.inner) - len(before.inner)
    if more == 0:
        return "jump"
    if rising:
        return "nucleation" if more > 0 else "coalescence"
    return "splitting" if more > 0 else "closing"
