"""States of one contact where there can be no other: totals, certificate, error estimate."""

from __future__ import annotations

import numpy as np

from discretization.certificate import ROUNDING, Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.contacts import equilibrium, estimated, push
from discretization.fitted.single_lines import Line, Single, ends_of, lines_of
from discretization.quadrature import Interval, refined
from discretization.surfaces.protocol import Free
from energy import Scene

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
    problem = Single.of(scene, depth)
    lines = lines_of(problem)
    if lines:
        state = _state(problem, lines, branch, rtol)
        if branch != "global" or state.energy <= 0 or depth > problem.touch:
            return state
    elif abs(problem.shortfall(1, problem.apex)) <= _UNDECIDED * problem.displacement_scale:
        problem.free(1, problem.apex)
    pressed = max(0.0, depth - problem.touch) / problem.displacement_scale
    return detached(scene, depth, branch, problem.surfaces, Certificate.undeformed(pressed))


def _state(problem: Single, lines: list[Line], branch: str, rtol: float) -> Equilibrium:
    """The certified state with these lines."""
    scene, depth, ends = problem.scene, problem.depth, ends_of(problem, lines)
    free = [problem.free(line.side, line.x) for line in lines]
    found = totals(problem, lines, free, rtol)
    certificate = certify(problem, lines, free, found)
    certificate.demand(
        f"the state at depth = {depth!r}", "try method='lattice' with a small spacing"
    )
    held = [True] * scene.axisymmetric + [line.pinned for line in lines for _ in range(line.times)]
    return equilibrium(
        ends,
        found,
        scene=scene,
        depth=depth,
        pinned=np.array([held]),
        certificate=certificate,
        surfaces=problem.surfaces,
        errors=errors(problem, lines, found),
        branch=branch,
        neutral=any(line.neutral for line in lines),
    )


def totals(problem: Single, lines: list[Line], free: list[Free], rtol: float) -> Interval:
    """Energy and force of the contact."""
    parts = [
        line.times * np.array([each.energy, sum(each.pulls), each.area, abs(sum(each.pulls))])
        for line, each in zip(lines, free, strict=True)
    ]
    energy, pull, area, size = np.sum(parts, axis=0).tolist()
    ends = ends_of(problem, lines)
    return refined(problem.scene, problem.depth, ends, (energy, pull, area, size))


def certify(problem: Single, lines: list[Line], free: list[Free], found: Interval) -> Certificate:
    """The same conditions as on the lattice, for lines that move continuously."""
    scene, penetration, neighbours = problem.scene, 0.0, 0.0
    size = max(problem.size(line) for line in lines)
    ends = ends_of(problem, lines)
    width, highest = float(np.diff(ends)[0, 0]), float(np.max(scene.indenter.height(ends)))
    step = 1e-7 * max(width, 1e-3 * scene.elastocapillary_length)
    for side, x, pinned, *_ in lines:
        if width:  # D may fall towards an edge
            at = (x, -1) if pinned else (x - side * step, 0)
            neighbours = max(neighbours, problem.shortfall(side, *at) / size)
        if x not in scene.indenter.walls:  # beyond an edge nothing can be penetrated
            beyond = x + side * step
            neighbours = max(neighbours, -problem.shortfall(side, beyond) / size)
            penetration = max(penetration, -problem.shortfall(side, beyond, adhesive=False) / size)
    force = abs(found.force - found.force_by_field) / (found.force_scale or 1.0)
    pulled = 0.0 if scene.work_of_adhesion else max(0.0, highest - problem.depth)
    stationarity, opening = max(each.residual for each in free), pulled / problem.displacement_scale
    return Certificate(float(penetration), stationarity, opening, float(neighbours), force)


def errors(problem: Single, lines: list[Line], found: Interval) -> dict[str, float]:
    """Errors of surface and rounding times the condition of the line, and of the quadrature."""
    width, move, more = float(np.diff(ends_of(problem, lines))[0, 0]), 0.0, 0.0
    for line in lines:
        if line.pinned or not width:
            continue
        lost = ROUNDING * problem.terms(line) + found.rounding
        moved = lost * _yield(problem, line, width, lost) + _POSITION * abs(line.x)
        move += line.times * moved
        more += line.times * moved * float(push(problem.scene, problem.depth, np.array(line.x)))
    return estimated(found, width, move, more)


def _yield(problem: Single, line: Line, width: float, lost: float) -> float:
    """How far a line moves per change of its shortfall, by the shortest step that rounding leaves.

    Beside the least depth of a contact D grows outwards only from close by.
    """
    for part, clear in _STEPS:
        rise = -float(problem.shortfall(line.side, line.x - line.side * part * width))
        if rise > clear * lost:
            return part * width / rise
    return width / lost
