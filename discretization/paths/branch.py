"""What a load path needs to know of a discretisation: states followed from depth to depth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from energy import Scene

Array = NDArray[np.float64]
State = Any  # lines or contact nodes, with `ends` in x, of several contacts `lines`; None: detached


class Point(NamedTuple):
    """A depth and the state there."""

    depth: float
    state: State


class Branch(Protocol):
    """States under a prescribed depth.

    touch: depth at which contact begins; lift: how far below it can be held; smooth: whether P is
    a smooth function of d between events.
    """

    @property
    def smooth(self) -> bool: ...

    @property
    def scene(self) -> Scene: ...

    @property
    def touch(self) -> float: ...

    @property
    def lift(self) -> float: ...

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""

    def jump(self, state: State, start: float, end: float) -> tuple[float, State, State] | None:
        """First depth on the way to `end` at which a line jumps, and the states beside it."""

    def contact(self, depth: float, *lines: float) -> State:
        """The state at a depth whose lines are here, two for every contact; nan: detached."""

    def pinned(self, state: State) -> tuple[str, str]:
        """What holds each of the outermost lines: "edge", "tip" or "" where it is free."""

    def force(self, state: State, depth: float) -> float:
        """P."""

    def energy(self, state: State, depth: float) -> float:
        """U, with the work of adhesion of closing."""

    def friction(self, before: State, after: State) -> float:
        """Lost to adhesion hysteresis as the lines move without a jump."""

    def work(self, before: State, start: float, end: float) -> float:
        """∫P dd from one depth to another without a jump on the way."""

    def observed(self, depths: Array, states: Sequence[State]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,) to report of states in contact."""

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError unless the state is in equilibrium."""


class BranchBase:
    """What the branches of all scenes say alike."""

    scene: Scene

    @property
    def smooth(self) -> bool:
        """Whether P is a smooth function of d between events."""
        return True

    @property
    def lift(self) -> float:
        """How far below touching a contact can be held: δ₀ of opening."""
        return self.scene.opened.critical_separation


def at_edges(scene: Scene, state: State) -> tuple[str, str]:
    """Which of the outermost lines are at an edge of the body: "edge", else ""."""
    left, right = state.ends if state is not None else (math.nan, math.nan)
    walls = scene.indenter.walls
    return "edge" if left in walls else "", "edge" if right in walls else ""
