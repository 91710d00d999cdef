"""The metastable branch of one contact on the fitted mesh, followed from state to state.

At a new depth every contact line moves downhill in energy from where it was: outwards while dU/dq
of a contact that closes is negative, inwards while that of one that opens is positive, else it
stays. With one work of adhesion both change sign at the same place.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.kinds import surfaces_of
from discretization.fitted.lines import (
    AXIS,
    FittedLine,
    Problem,
    find_line,
    least_shortfall,
    lowest_point,
    mirrored,
)
from discretization.fitted.quadrature import along, arc_length, pressing, totals
from discretization.fitted.state import certify_lines
from discretization.fitted.surfaces import Surfaces
from discretization.paths.balance import integral
from discretization.paths.branch import FollowerBase, Point
from energy import Scene

Array = NDArray[np.float64]
_SECANTS = 12  # steps; a step of a path takes four or five
_WIDER = 8.0  # times as wide: farther off a height may overflow
_NUDGE = 1e-6  # of the distance from the apex: the first step of a secant
_CLOSED = 1e-15  # of the same: rounding
_STALLED = 1e-12  # of the same: a step that shrinks no more is rounding of D
_LOCAL = 1e-3  # of the same: points so close that their secant is a tangent
_REDUCED = 1e-10  # of the first shortfall: the next step makes it rounding


class Contact(NamedTuple):
    """A contact between two lines."""

    left: FittedLine
    right: FittedLine

    @property
    def ends(self) -> tuple[float, float]:
        """x of both lines."""
        return self.left.x, self.right.x

    @property
    def lines(self) -> tuple[float, float]:
        """The same."""
        return self.ends


State = Contact | None


@dataclass(frozen=True, eq=False)
class FittedBranch(FollowerBase):
    """States of one contact of a convex indenter under a prescribed depth; None: detached.

    About an axis the left line is the axis, and below a least depth the right one is not held.
    """

    scene: Scene
    surfaces: Surfaces
    apex: float
    touch: float
    rtol: float

    @classmethod
    def of(cls, scene: Scene, rtol: float, deepest: float = math.inf) -> FittedBranch:
        """For any depth; ValueError for an indenter without a lowest point."""
        indenter = scene.indenter
        apex = indenter.apex
        if apex is None:
            apex = lowest_point(indenter, scene.elastocapillary_length)
        return cls(scene, surfaces_of(scene, rtol), apex, float(indenter.height(apex)), rtol)

    def _problems(self, depth: float) -> tuple[Problem, Problem]:
        """That of a contact that closes, and that of one that opens."""
        closing = Problem(self.scene, depth, self.touch, self.surfaces)
        if self.scene.opening is None:
            return closing, closing
        return closing, Problem(self.scene.opened, depth, self.touch, self.surfaces)

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        if before is None:
            if depth < self.touch:
                return None
            seed = FittedLine(self.apex, True, False)
            before = Contact(seed, seed)
        problems = self._problems(depth)
        if self.scene.axisymmetric:
            return self._turned(problems, before.right)
        right = self._moved(problems, 1, before.right)
        if self.scene.indenter.symmetric and self.apex == self.scene.indenter.apex:
            left = right._replace(x=mirrored(self.scene.indenter, right.x))
        else:
            left = self._moved(problems, -1, before.left)
        if left.x > right.x or (left.x == right.x and depth < self.touch):
            return None
        for line in (left, right):
            problems[1].refuse_overhang(line.x)
        return Contact(left, right)

    def _moved(self, problems: tuple[Problem, Problem], side: int, line: FittedLine) -> FittedLine:
        closing, opening = problems
        if closing is opening:
            near = _near(closing, side, line, self.apex)
            return near or find_line(closing, side, self.apex)
        outer = find_line(closing, side, self.apex)
        if side * (outer.x - line.x) > 0:
            return outer
        inner = find_line(opening, side, self.apex)
        return inner if side * (inner.x - line.x) <= 0 else line

    def _turned(self, problems: tuple[Problem, Problem], line: FittedLine) -> State:
        """The state of a contact about an axis; None below the fold of its line."""
        closing, opening = problems
        if closing is opening and closing.depth >= self._fold[1]:
            near = _near(closing, 1, line, self._fold[0])
            if near is not None:
                closing.refuse_overhang(near.x)
                return Contact(AXIS, near)
        beside = 1 if line.pinned else 0
        if closing.shortfall(1, line.x, beside) < 0:
            found = find_line(closing, 1, line.x)
        elif opening.shortfall(1, line.x, -beside) <= 0:
            found = line
        elif opening.depth < self._fold[1]:
            return None
        else:
            found = find_line(opening, 1, self._fold[0])
        if not found.x and closing.depth < self.touch:
            return None
        closing.refuse_overhang(found.x)
        return Contact(AXIS, found)

    @functools.cached_property
    def _fold(self) -> tuple[float, float]:
        """The radius at which D of a line that recedes about an axis is least, and that depth."""
        opening = self._problems(self.touch)[1]
        outer = find_line(opening, 1, self.apex).x
        if not outer:
            return 0.0, self.touch
        x, least = least_shortfall(opening, outer, -math.inf)
        return x, self.touch + least

    def contact(self, depth: float, *lines: float) -> State:
        """The state with lines at these positions; nan: detached."""
        if math.isnan(lines[0]):
            return None
        corners = self.scene.indenter.corners
        ends = (FittedLine(x, bool(np.any(np.equal(corners, x))), False) for x in lines)
        return Contact(*ends)

    def jump(self, state: State, start: float, end: float) -> tuple[float, State, State] | None:
        """A line contact of a convex profile has no jumps; one about an axis ends at a fold."""
        if not self.scene.axisymmetric or state is None:
            return None
        x, least = self._fold
        if not x or end >= least:
            return None
        return least, self.follow(state, least), None

    def pinned(self, state: State) -> tuple[str, str]:
        """What holds each line: "edge", "tip" or "" where it is free."""
        if state is None:
            return ("", "")
        walls, corners = self.scene.indenter.walls, self.scene.indenter.corners
        held = []
        for line in state:
            tip = line.x == self.apex and line.x in corners and not self.scene.axisymmetric
            held.append("edge" if line.x in walls else "tip" if tip else "")
        return held[0], held[1]

    def force(self, state: State, depth: float) -> float:
        """P."""
        if state is None:
            return 0.0
        return pressing(self.surfaces, depth, *state.ends, self.rtol)

    def energy(self, state: State, depth: float) -> float:
        """U, with the work of adhesion of `surfaces`."""
        if state is None:
            return 0.0
        return totals(self.surfaces, depth, *state.ends, 1e-15)[1].energy

    def friction(self, before: State, after: State) -> float:
        """Lost to adhesion hysteresis, w_opening - w per length of the indenter that opens."""
        if before is None or after is None or self.scene.opening is None:
            return 0.0
        ends = zip((-1, 1), before.ends, after.ends, strict=True)
        opened = sum(
            arc_length(self.scene, *at) for side, *at in ends if side * at[1] < side * at[0]
        )
        return (self.scene.opened.work_of_adhesion - self.scene.work_of_adhesion) * opened

    def work(self, point: Point, depth: float) -> float:
        """∫P dd from one depth to another without a jump on the way, by adaptive Lobatto rules."""
        (start, before), end = point, depth
        if before is None:
            return 0.0

        def force(depths: Array) -> Array:
            return np.array([self.force(self.follow(before, d), d) for d in depths.tolist()])

        if not self.scene.axisymmetric or not self._fold[0]:
            return integral(force, start, end)
        least = self._fold[1]  # where P ends like a root of d - least
        ends = (math.sqrt(max(depth - least, 0.0)) for depth in (start, end))
        return integral(lambda t: 2 * t * force(least + t * t), *ends)

    def observed(self, depths: Array, states: Sequence[Contact]) -> tuple[Array, Array, Array]:
        """Lines (n, 2), P and U (n,)."""
        lines = np.array([state.ends for state in states])
        found, change = along(self.surfaces, depths, lines)
        if change <= self.rtol / 10:
            return lines, found.force, found.energy
        finer = [
            totals(self.surfaces, depth, left, right, self.rtol)[1]
            for depth, (left, right) in zip(depths.tolist(), lines.tolist(), strict=True)
        ]
        return lines, *np.array([(one.force, one.energy) for one in finer]).T

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError unless the state is in equilibrium."""
        if state is None:
            return
        closing, opening = self._problems(depth)
        found = totals(self.surfaces, depth, *state.ends, 1e-15)[1]
        certificate = certify_lines(closing, state, found, opening)
        certificate.demand(f"the state at depth = {depth!r}", "the path stops before it")


def _near(problem: Problem, side: int, line: FittedLine, apex: float) -> FittedLine | None:
    """A free line close to where it was, by secants; None where a corner is near or they fail."""
    if line.pinned:
        return None
    size = abs(line.x - apex)
    inner, outer = side * apex, side * apex + _WIDER * size
    if len(problem.scene.indenter.corners):
        corners = side * np.asarray(problem.scene.indenter.corners, float)
        inner = float(max(inner, corners[corners < side * line.x].max(initial=-math.inf)))
        outer = float(min(outer, corners[corners > side * line.x].min(initial=math.inf)))
    x0, x1 = line.x, line.x - side * _NUDGE * size
    h0, h1, last = problem.shortfall(side, x0), problem.shortfall(side, x1), math.inf
    least = _REDUCED * abs(h0)
    for _ in range(_SECANTS):
        if not (h1 - h0) * side * (x1 - x0) > 0:
            return None
        step = -h1 * (x1 - x0) / (h1 - h0)
        # a steep far end makes any step look small
        local = abs(x1 - x0) <= _LOCAL * size or abs(h1) <= least
        if local and (abs(step) <= _CLOSED * size or last / 2 <= abs(step) <= _STALLED * size):
            return FittedLine(x1 + step, False, False)
        x0, h0, x1, last = x1, h1, x1 + step, abs(step)
        if not inner < side * x1 < outer:
            return None
        h1 = problem.shortfall(side, x1)
    return None
