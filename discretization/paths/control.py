"""What holds the indenter: an imposed depth, a dead load, or a spring to a drive.

The load L(d; c) at control value c is c (force) or K(c - d) (a machine of stiffness K whose drive
is at c); equilibrium is P(d) = L(d; c), stable where P'(d) + K > 0 (force: K = 0). The indenter
moves towards the first equilibrium in the direction in which it is pushed; where there is none
before P' + K changes sign, the state is unstable and jumps at fixed control.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from discretization.paths.branch import Branch, Point
from discretization.roots import bracketed

_MARCH = 40  # secant steps: four or five do where P is smooth
_HALVINGS = 60  # of a bracket, to the spacing of floating-point numbers
_ROUNDING = 1e-14  # of k δ₀ times the width: forces that are no imbalance
_NUDGE = 1e-6  # of the distance from touching and δ₀: a first step without a guess
_NEAREST = 1e-5  # of the distance to a fold: the first trial beside its end
_STENCIL = ((1, 45 / 60), (2, -9 / 60), (3, 1 / 60))  # sixth order
_STRIDE = 0.006  # ε^(1/7) of the distance: where rounding and the seventh order are alike
_SAMPLES = 32  # steps per δ₀ of a march to the next equilibrium
_WIDER, _MOST_STEPS = 1.1, 200  # growth of these steps, and how many: beyond 1e6 δ₀
_LEAST = 1e-18  # of the depths, where it closes at depth 0
_LOCAL = 1e-2  # of the depths: secants drawn over less have an error known by _CLOSE
_REDUCED = 1e-10  # of the first imbalance: one more secant step makes it rounding
_CLOSE = 1e-14  # error of a secant step: itself times the distance of the points it is drawn by


@dataclass(frozen=True)
class Control:
    """stiffness K: None for an imposed depth, 0 for a dead load."""

    stiffness: float | None

    def load(self, depth: float, value: float) -> float:
        """L(d; c)."""
        return self.stiffness * (value - depth) if self.stiffness else value

    def value(self, depth: float, force: float) -> float:
        """c with L(d; c) = force; the depth itself if that is imposed."""
        if self.stiffness is None:
            return depth
        return depth + force / self.stiffness if self.stiffness else force

    def potential(self, depth: float, value: float) -> float:
        """Energy of what holds the indenter: 0, -F d or K/2 (D - d)²."""
        if self.stiffness is None:
            return 0.0
        return self.stiffness / 2 * (value - depth) ** 2 if self.stiffness else -value * depth


class Unstable(NamedTuple):
    """Where a state becomes unstable, and the last point at which there is a contact beyond it."""

    point: Point
    closes: Point


def settled(
    branch: Branch, control: Control, point: Point, old: float, value: float, rate: float
) -> Point | Unstable:
    """The equilibrium that a stable contact moves to as the control goes from `old` to `value`.

    By secants from where it was, enclosed once one of them has gone past it; rate: a guess of
    P' + K, 0 for none.
    """
    excess, remembers = _excess(branch, control, value), branch.scene.hysteretic
    here, r = point, control.load(point.depth, old) - control.load(point.depth, value)
    least = _unfelt(branch, point)
    if abs(r) <= least:
        r = excess(point)
        if abs(r) <= least:
            return point
    side, first, guess = (-1.0 if r > 0 else 1.0), abs(r), _guess(branch, point, abs(r), rate)
    held = branch.lift if branch.scene.gamma1 else 0.0  # springs alone: P is not smooth at touching
    there, beyond = _tried(branch, here, here.depth, side * guess)
    past: Point | None = None
    for _ in range(_MARCH):
        scale = held + max(abs(at.depth - branch.touch) for at in (point, there))
        q = excess(there) if there.state is not None else math.nan
        past = there if q * side > 0 else past
        if q == 0 or (there.depth == here.depth and beyond is None):
            return there
        if there.depth == here.depth:
            break
        slope = (q - r) / (there.depth - here.depth)
        if not slope > 0:
            break
        step, gap = -q / slope, abs(there.depth - here.depth)
        if past is not None and not _enclosed(there.depth + step, point, past):
            break
        near = gap <= _LOCAL * scale and abs(step) * gap <= _CLOSE * scale**2
        here, r, done = there, q, near or abs(q) <= _REDUCED * first
        there, beyond = _tried(branch, point if remembers else here, here.depth, step)
        if done and there.state is not None and beyond is None:
            return there
    if past is not None:
        return _between(branch, excess, point, past)
    if beyond is not None:
        raise beyond
    return _before_fold(branch, control, value, point, there, side)


def _before_fold(
    branch: Branch, control: Control, value: float, point: Point, there: Point, side: float
) -> Point | Unstable:
    """The equilibrium between a stable point and the fold on this side (down: -1), or that fold."""
    excess, closes = _excess(branch, control, value), there
    if there.state is None:
        closes = last_point(branch, point, there.depth)
    elif side < 0:
        closes = closing_point(branch, point)
    fold = point_of_fold(branch, control, point, closes if there.state is None else there)
    if excess(fold) * excess(point) <= 0:
        return _between(branch, excess, point, fold)
    return Unstable(fold, closes)


def _enclosed(depth: float, one: Point, other: Point) -> bool:
    """Whether it lies between the depths of two points."""
    return min(one.depth, other.depth) <= depth <= max(one.depth, other.depth)


def _guess(branch: Branch, point: Point, excess: float, rate: float) -> float:
    """Length of a first step."""
    step = _NUDGE * (abs(point.depth - branch.touch) + branch.lift)
    return (excess / rate if rate > 0 else step) or excess / branch.scene.layer.modulus


def _unfelt(branch: Branch, point: Point) -> float:
    """A change of the load that the rounding of P hides."""
    left, right = point.state.ends
    scene, lift = branch.scene, abs(point.depth - branch.touch) + branch.lift
    return _ROUNDING * scene.stiffness * lift * (right - left + scene.elastocapillary_length)


def jumped(
    branch: Branch, control: Control, point: Point, value: float, side: float
) -> Point | None:
    """The first equilibrium that an unbalanced indenter reaches, pressed in (side 1) or out (-1).

    None: there is none, or no contact any more. Events on the way happen: contacts that begin pull
    at an indenter that moves in, and those that close have pulled at one that moves out, so that
    no event holds it. It is followed by steps of a part of what a contact can be lifted by.
    """
    excess, here, step = _excess(branch, control, value), point, side * branch.lift / _SAMPLES
    for _ in range(_MOST_STEPS):
        goal, step = here.depth + step, step * _WIDER
        while here.depth != goal:
            jump = branch.jump(here.state, here.depth, goal)
            if jump is None:
                there = after = moved(branch, here, goal)
            else:
                there, after = Point(jump[0], jump[1]), Point(jump[0], jump[2])
            if there.state is not None and excess(there) * side >= 0:
                return _between(branch, excess, here, there, side)
            if after.state is None:
                return None
            here = after
    return None


def _excess(branch: Branch, control: Control, value: float) -> Callable[[Point], float]:
    """P - L at a point, as a function."""

    def excess(at: Point) -> float:
        return branch.force(at.state, at.depth) - control.load(at.depth, value)

    return excess


def moved(branch: Branch, point: Point, depth: float) -> Point:
    """The point at another depth."""
    return Point(depth, branch.follow(point.state, depth))


class Along:
    """Points on one way from a first one, each followed from the last known before it."""

    def __init__(self, branch: Branch, start: Point) -> None:
        self.branch, self.known = branch, [start]

    def at(self, depth: float) -> Point:
        """The point at a depth."""
        start = self.known[0].depth
        before = (p for p in self.known if min(start, depth) <= p.depth <= max(start, depth))
        last = max(before, key=lambda point: abs(point.depth - start))
        self.known.append(moved(self.branch, last, depth))
        return self.known[-1]


def steady(branch: Branch, point: Point, depth: float) -> Point:
    """The point at another depth; without a state if something happens on the way there."""
    if branch.jump(point.state, point.depth, depth) is not None:
        return Point(depth, None)
    return moved(branch, point, depth)


def _between(
    branch: Branch, excess: Callable[[Point], float], here: Point, there: Point, side: float = 0.0
) -> Point:
    """The equilibrium between two points at which P - L has different signs.

    side: of the second one, as far as that is known.
    """
    sign, along = side or (-1.0 if excess(here) > 0 else 1.0), Along(branch, here)
    return along.at(bracketed(lambda d: sign * excess(along.at(d)), here.depth, there.depth))


def _tried(
    branch: Branch, point: Point, depth: float, step: float
) -> tuple[Point, ValueError | None]:
    """The point a step further, halved while that is refused; with the refusal, if there was one.

    A trial depth may lie beyond the known profile while the equilibrium does not.
    """
    beyond: ValueError | None = None
    for _ in range(_HALVINGS):
        try:
            return steady(branch, point, depth + step), beyond
        except ValueError as refusal:
            beyond, step = refusal, step / 2
    return moved(branch, point, depth), beyond


def last_point(branch: Branch, point: Point, depth: float) -> Point:
    """The last point on the way to a depth before the contact is lost or something happens."""
    jump = branch.jump(point.state, point.depth, depth)
    return closing_point(branch, point) if jump is None else Point(jump[0], jump[1])


def closing_point(branch: Branch, point: Point) -> Point:
    """The last depth of a retraction from `point` before something happens or the contact ends."""
    jump = branch.jump(point.state, point.depth, _gone(branch, point))
    return lost_point(branch, point) if jump is None else Point(jump[0], jump[1])


def _gone(branch: Branch, point: Point) -> float:
    """A depth at which there is no contact any more."""
    return branch.touch - (1 + _NUDGE) * branch.lift - _NUDGE * abs(point.depth)


def lost_point(branch: Branch, point: Point) -> Point:
    """The last depth of a retraction from `point` at which there still is a contact."""
    held, gone = point, _gone(branch, point)
    while (jump := branch.jump(held.state, held.depth, gone)) is not None:
        if jump[2] is None:
            return Point(jump[0], jump[1])
        held = Point(jump[0], jump[2])
    point = held
    least = _LEAST * (abs(point.depth) + branch.lift)
    while True:
        middle = (held.depth + gone) / 2
        if not gone < middle < held.depth or held.depth - gone <= least:
            return held
        state = branch.follow(point.state, middle)
        if state is None:
            gone = middle
        else:
            held = Point(middle, state)


def point_of_fold(branch: Branch, control: Control, stable: Point, end: Point) -> Point:
    """Where P' + K changes sign between a stable point and `end`; `end` if it does not."""
    size = branch.lift or abs(stable.depth - end.depth)
    room, along = abs(stable.depth - end.depth), Along(branch, stable)

    def rate(depth: float, stride: float) -> float:
        total = control.stiffness or 0.0
        for count, weight in _STENCIL:
            ahead, behind = (along.at(depth + s * count * stride) for s in (1, -1))
            rise = branch.force(ahead.state, ahead.depth) - branch.force(behind.state, behind.depth)
            total += weight * rise / stride
        return total

    def smooth(depth: float) -> float:
        return rate(depth, _STRIDE * min(size, abs(depth - end.depth)))

    first = end.depth + math.copysign(_NEAREST * size, stable.depth - end.depth)
    if first == end.depth or abs(first - end.depth) >= room or smooth(first) >= 0:
        return end
    found = bracketed(smooth, first, stable.depth)
    for finer in (1e-3, 1e-6):  # where a pinned line comes free P' jumps: seen by short strides
        stride = finer * _STRIDE * min(size, abs(found - end.depth))
        reach = math.copysign(4 / finer * stride, stable.depth - end.depth)
        inner, outer = found - reach, found + reach
        if abs(outer - end.depth) > room or rate(inner, stride) >= 0 or rate(outer, stride) <= 0:
            break
        kink = bracketed(lambda depth: rate(depth, stride), inner, outer)  # noqa: B023
        if abs(kink - found) <= stride:  # smooth: the long stride is the more accurate
            break
        found = kink
    return along.at(found)
