"""What a load path needs to know of a discretisation: states followed from depth to depth."""

from __future__ import annotations

import bisect
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from energy import Scene

Array = NDArray[np.float64]
State = Any  # lines or contact nodes, with `ends` in x, of several contacts `lines`; None: detached
Pinned = tuple[str, str]
CREEPS = 1e-11  # of δ₀ and the depth: legs that short, of lines that come free by roundings,
CREEPING = 100  # and so many in a row are not followed any further
_TINY = 4e-16  # of the depth: brackets of a change this short are closed
_LEAST = 1e-18  # for changes at depth 0


class Point(NamedTuple):
    """A depth and the state there."""

    depth: float
    state: State


class Leg(Protocol):
    """States on the way from one depth to another, with nothing but smooth motion in between.

    pinned: what holds the outermost lines on the way; after: what is beyond an event at the end,
    None where nothing happens there; jumps: whether lines jump at that event.
    """

    start: Point
    end: Point
    after: Point | None
    jumps: bool

    @property
    def pinned(self) -> Pinned: ...

    def points(self, depths: Array) -> list[Point]:
        """The states at depths on the way (n,)."""

    def forces(self, depths: Array, *, roughly: bool = False) -> Array:
        """P at depths on the way (n,); roughly: good to draw it."""


class Branch(Protocol):
    """States under a prescribed depth.

    touch: depth at which contact begins; lift: how far below it can be held; smooth: whether P is
    a smooth function of d between events; resolution: the length by which lines may be off; ahead:
    whether many depths on one leg cost less than as many legs.
    """

    @property
    def ahead(self) -> bool: ...

    @property
    def smooth(self) -> bool: ...

    @property
    def resolution(self) -> float: ...

    @property
    def scene(self) -> Scene: ...

    @property
    def touch(self) -> float: ...

    @property
    def lift(self) -> float: ...

    def leg(self, point: Point, goal: float) -> Leg:
        """The way from a point towards another depth, up to the first event."""

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""

    def contact(self, depth: float, *lines: float) -> State:
        """The state at a depth whose lines are here, two for every contact; nan: detached."""

    def pinned(self, state: State) -> Pinned:
        """What holds each of the outermost lines: "edge", "tip" or "" where it is free."""

    def force(self, state: State, depth: float) -> float:
        """P."""

    def energy(self, state: State, depth: float) -> float:
        """U, with the work of adhesion of closing."""

    def friction(self, before: State, after: State) -> float:
        """Lost to adhesion hysteresis as the lines move without a jump."""

    def work(self, point: Point, depth: float) -> float:
        """∫P dd from a point to a depth without a jump on the way."""

    def observed(self, depths: Array, states: Sequence[State]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,) to report of states in contact."""

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError unless the state is in equilibrium."""


class Follower(Branch, Protocol):
    """A branch that knows one state after the other."""

    def forces(self, points: Sequence[Point]) -> Array:
        """P at points (n,)."""

    def jump(self, state: State, start: float, end: float) -> tuple[float, State, State] | None:
        """First depth on the way to `end` at which a line jumps, and the states beside it."""


@dataclass(eq=False)
class Followed:
    """A leg whose states are followed one by one, each from the last known before it."""

    branch: Follower
    start: Point
    end: Point
    after: Point | None
    jumps: bool
    known: list[tuple[float, Point]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.known = [(0.0, self.start)]

    @property
    def pinned(self) -> Pinned:
        """What holds the outermost lines on the way."""
        return self.branch.pinned(self.start.state)

    def points(self, depths: Array) -> list[Point]:
        """The states at depths on the way (n,)."""
        return [self._at(depth) for depth in depths.tolist()]

    def _at(self, depth: float) -> Point:
        if depth == self.end.depth:
            return self.end
        far = abs(depth - self.start.depth)
        i = bisect.bisect_right(self.known, far, key=lambda entry: entry[0])
        distance, last = self.known[i - 1]
        if distance == far:
            return last
        found = moved(self.branch, last, depth)
        self.known.insert(i, (far, found))
        return found

    def forces(self, depths: Array, *, roughly: bool = False) -> Array:
        """P at depths on the way (n,)."""
        return self.branch.forces(self.points(depths))


class BranchBase:
    """What the branches of all scenes say alike."""

    scene: Scene

    @property
    def smooth(self) -> bool:
        """Whether P is a smooth function of d between events."""
        return True

    @property
    def ahead(self) -> bool:
        """Whether many depths on one leg cost less than as many legs."""
        return True

    @property
    def resolution(self) -> float:
        """The length by which lines may be off."""
        return 0.0

    @property
    def lift(self) -> float:
        """How far below touching a contact can be held: δ₀ of opening."""
        return self.scene.opened.critical_separation


class FollowerBase(BranchBase):
    """What branches say alike that know one state after the other."""

    @property
    def ahead(self) -> bool:
        """Whether many depths on one leg cost less than as many legs."""
        return False

    def forces(self: Any, points: Sequence[Point]) -> Array:
        """P at points (n,)."""
        return np.array([self.force(point.state, point.depth) for point in points])

    def leg(self: Any, point: Point, goal: float) -> Followed:
        """The way from a point towards another depth, up to the first event."""
        jump = self.jump(point.state, point.depth, goal)
        if jump is not None:  # by rounding it may lie behind
            low, high = sorted((point.depth, goal))
            jump = (min(max(jump[0], low), high), *jump[1:])
        end = moved(self, point, goal) if jump is None else Point(jump[0], jump[1])
        if _held(self, end) != _held(self, point):
            return Followed(self, point, *_change(self, point, end), jumps=False)
        after = None if jump is None else Point(jump[0], jump[2])
        return Followed(self, point, end, after, jump is not None)


def legs(branch: Branch, here: Point, depth: float) -> Iterator[Leg]:
    """The legs from a point to a depth without a jump on the way."""
    while here.depth != depth and here.state is not None:
        leg = branch.leg(here, depth)
        yield leg
        if leg.jumps:  # by rounding, where the way ends
            return
        here = leg.end if leg.after is None else leg.after


def moved(branch: Branch, point: Point, depth: float) -> Point:
    """The point at another depth."""
    return Point(depth, branch.follow(point.state, depth))


def _held(branch: Branch, point: Point) -> tuple[bool, Pinned]:
    return point.state is not None, branch.pinned(point.state)


def _change(branch: Branch, start: Point, end: Point) -> tuple[Point, Point]:
    """The last point held as the start is, and the first one held otherwise."""
    inside, outside, held = start, end, _held(branch, start)
    size = abs(inside.depth) + abs(outside.depth) + branch.lift
    while True:
        depth = (inside.depth + outside.depth) / 2
        width = abs(inside.depth - outside.depth)
        if width <= max(_TINY * min(size, 4 * abs(depth)), _LEAST * size):
            return inside, outside
        middle = moved(branch, start, depth)
        if _held(branch, middle) == held:
            inside = middle
        else:
            outside = middle


def at_edges(scene: Scene, state: State) -> Pinned:
    """Which of the outermost lines are at an edge of the body: "edge", else ""."""
    left, right = state.ends if state is not None else (math.nan, math.nan)
    walls = scene.indenter.walls
    return "edge" if left in walls else "", "edge" if right in walls else ""
