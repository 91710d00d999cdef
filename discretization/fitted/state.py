"""Equilibria on the fitted mesh: topology, contact lines, certificate, error estimate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.contacts import equilibrium, estimated
from discretization.fitted.lines import (
    AXIS,
    FittedLine,
    Problem,
    find_line,
    lowest_point,
    mirrored,
    outer_line,
)
from discretization.quadrature import Interval, refined
from discretization.rounding import ROUNDING
from discretization.surfaces import surfaces_of
from discretization.surfaces.protocol import At, Surfaces
from discretization.surfaces.tail import FittedTail
from energy import Scene

Array = NDArray[np.float64]
_UNDECIDED = 1e-7  # letting go and turning over at once
_POSITION = ROUNDING / 4  # of |x|, to which a line is found
# steps over the width of a contact, and the least rise of D - d over its rounding
_STEPS = *((10.0**n, 10) for n in range(-8, -3)), (0.5, 4)


def on_one_contact(
    scene: Scene, depth: float, *, branch: str = "adhered", rtol: float = 1e-8
) -> Equilibrium:
    """Certified equilibrium with its contact lines as unknowns, and its error estimate.

    branch "global" of a convex indenter: this state or, before it touches, the detached one,
    whichever has less energy. There is no other: the force on each line grows outwards.
    """
    indenter = scene.indenter
    apex = indenter.apex
    if apex is None:
        apex = lowest_point(indenter, scene.elastocapillary_length)
    starts, touch = (apex, apex), float(indenter.height(apex))
    problem = Problem(scene, depth, touch, surfaces_of(scene))
    state = _state(problem, starts, branch, rtol)
    if branch == "global" and state.energy > 0 and depth <= touch:
        return _detached(problem, branch)
    return state


def _detached(problem: Problem, branch: str) -> Equilibrium:
    """The flat surface without contact."""
    tail = FittedTail(problem.surfaces)
    pressed = max(0.0, problem.depth - problem.touch) / problem.lift
    certificate = Certificate(pressed, 0.0, 0.0, 0.0, 0.0)
    return detached(problem.scene, problem.depth, branch, tail, certificate)


def _state(problem: Problem, starts: tuple[float, float], branch: str, rtol: float) -> Equilibrium:
    """The certified state of a problem whose contact contains `starts`."""
    scene, depth = problem.scene, problem.depth
    ends = _lines(problem, starts)
    if ends is None:
        if abs(problem.shortfall(1, starts[1])) <= _UNDECIDED * problem.lift:
            problem.refuse_overhang(starts[1])
        return _detached(problem, branch)
    for end in ends:
        problem.refuse_overhang(end.x)
    coarse, fine = totals(problem.surfaces, depth, ends[0].x, ends[1].x, rtol)
    certificate = certify_lines(problem, ends, fine)
    certificate.demand(
        f"the state at depth = {depth!r}", "try method='lattice' with a small spacing"
    )
    return equilibrium(
        np.array([[ends[0].x, ends[1].x]]),
        fine,
        scene=scene,
        depth=depth,
        pinned=np.array([[ends[0].pinned, ends[1].pinned]]),
        certificate=certificate,
        tail=FittedTail(problem.surfaces),
        errors=_errors(problem, ends, coarse, fine),
        branch=branch,
        neutral=any(end.neutral for end in ends),
    )


def _lines(problem: Problem, starts: tuple[float, float]) -> tuple[FittedLine, FittedLine] | None:
    """Both contact lines, found outwards from inside the contact; None if it has let go."""
    indenter = problem.scene.indenter
    if problem.scene.axisymmetric:
        line = outer_line(problem, starts[1])
        lost = line is None or (not line.x and problem.depth < problem.touch)
        return None if line is None or lost else (AXIS, line)
    right = find_line(problem, 1, starts[1])
    if indenter.symmetric and starts[0] == starts[1] == indenter.apex:
        left = FittedLine(mirrored(indenter, right.x), right.pinned, right.neutral)
    else:
        left = find_line(problem, -1, starts[0])
    held = left.x < right.x or (left.x == right.x and problem.depth >= problem.touch)
    return (left, right) if held else None


def totals(
    surfaces: Surfaces, depth: float, left: float, right: float, rtol: float
) -> tuple[Interval, Interval]:
    """Energy and force of one contact between two lines."""
    scene = surfaces.scene
    one, other = (At(x, float(scene.indenter.height(x))) for x in (left, right))
    last = surfaces.free(other, None, depth)
    alike = one.f == other.f and not scene.axisymmetric  # one surface and its mirror image
    first = last if alike else surfaces.free(None, one, depth)
    pulls = first.pulls[0 if alike else 1], last.pulls[0]
    free = first.energy + last.energy, sum(pulls), first.area + last.area, sum(map(abs, pulls))
    return refined(scene, depth, np.array([[left, right]]), free, rtol)


def certify_lines(
    problem: Problem,
    ends: tuple[FittedLine, FittedLine],
    found: Interval,
    opening: Problem | None = None,
) -> Certificate:
    """The same conditions as on the lattice, for lines that move continuously.

    opening: the problem of a contact that opens, where it is another one.
    """
    penetration = neighbours = stationarity = 0.0
    scale = problem.scale(ends)
    step = 1e-7 * max(ends[1].x - ends[0].x, 1e-3 * problem.scene.elastocapillary_length)
    for side, end, _ in problem.distinct(ends):
        if ends[0].x < ends[1].x:
            receding = opening or problem  # D may fall towards an edge
            at = (end.x, -1) if end.pinned else (end.x - side * step, 0)
            inner = receding.shortfall(side, *at)
            neighbours = max(neighbours, inner / scale)
        if end.x not in problem.scene.indenter.walls:  # beyond an edge nothing can be penetrated
            beyond = end.x + side * step
            neighbours = max(neighbours, -problem.shortfall(side, beyond) / scale)
            penetration = max(penetration, -problem.shortfall(side, beyond, adhesive=False) / scale)
        stationarity = max(stationarity, problem.imbalance(side, end.x))
    force = abs(found.force - found.force_by_field) / (found.force_scale or 1.0)
    held = (opening or problem).scene.work_of_adhesion
    pulled = 0.0 if held else max(0.0, -found.weakest)
    return Certificate(penetration, stationarity, pulled / problem.lift, neighbours, force)


def _yield(problem: Problem, side: int, x: float, width: float, lost: float) -> float:
    """How far a line moves per change of its shortfall, by the shortest step that rounding leaves.

    Beside the least depth of a contact D grows outwards only from close by.
    """
    for part, least in _STEPS:
        rise = -problem.shortfall(side, x - side * part * width)
        if rise > least * lost:
            return part * width / rise
    return width / lost


def _errors(
    problem: Problem, ends: tuple[FittedLine, FittedLine], coarse: Interval, fine: Interval
) -> dict[str, float]:
    """Errors of surface and rounding times the condition of the line, and of the quadrature."""
    width, move, push = ends[1].x - ends[0].x, 0.0, 0.0
    rounding = fine.rounding
    for side, end, count in problem.distinct(ends):
        if end.pinned or not width:
            continue
        scale = problem.terms(side, end.x)
        yielding = _yield(problem, side, end.x, width, ROUNDING * scale + rounding)
        error = count * ((ROUNDING * scale + rounding) * yielding + _POSITION * abs(end.x))
        move += error
        push += error * abs(problem.force_rate(side, end.x))
    return estimated(coarse, fine, width, move, push)
