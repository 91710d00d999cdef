"""Certificate and error estimate of any number of contacts on the fitted mesh.

The conditions of ../certificate.py for lines that move continuously:

    penetration   max (g - u)/δ between the contacts and beyond them, at the samples that resolve
                  the profile and at the extremes between them; and the kink r of the surface at
                  every line is no passage through the indenter
    stationarity  residual of the free nodes, and of the energy's derivative by the gap
    opening       no corner in contact is torn open, -[f'] <= 2√(2w/γ₁) (or angles); a contact of
                  one point, which does not adhere, is not pulled; w = 0: kg + γ₁f'' >= 0
                  everywhere in contact
    neighbours    every drive is zero, or of the signs that pin the line; the energy of the lines,
                  those of a gap together, has a positive second variation
    force         dU/dd against k∫u dx
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium
from discretization.fitted.contacts import FittedContacts
from discretization.fitted.gap_lines import Gap, gap_of
from discretization.fitted.height_rounding import felt
from discretization.fitted.lines import FittedLine, Problem
from discretization.fitted.quadrature import Interval
from energy import Scene

Array = NDArray[np.float64]
_ASIDE = 1e-9
_INSIDE = 1e-3  # of an interval: how far from its ends, which may be corners, slopes are read
_ULPS = 4.0  # roundings of a position, within which a line is where it is
_GOLDEN = (math.sqrt(5) - 1) / 2
_REFINEMENTS = 45
_NEAR = 4.0
_SAMPLES = 65
_DIFFERENCE = 1e-4
_ROUNDING = 16 * float(np.finfo(float).eps)
_POSITION = _ROUNDING / 4  # of |x|, to which a line is found


def certify(
    contacts: FittedContacts, state: Equilibrium, found: Interval, points: Array
) -> Certificate:
    """Judge contacts with these totals; the state's surface is looked at in points (n,)."""
    problem = contacts.problem
    if problem.lift * problem.scene.elastocapillary_length == 0:
        return Certificate.undeformed()
    scale = max(problem.scale(pair) for pair in contacts.pairs)
    through, moves = _signs(contacts, scale)
    own = gap_of(problem)
    imbalances = [problem.imbalance(line.x) for _, line in contacts.outer]
    imbalances += [own.imbalance(q.x, p.x) for q, p in contacts.gaps]
    return Certificate(
        penetration=max(through, penetration(state, points) / problem.lift),
        stationarity=max(imbalances),
        opening=max(0.0, _tension(contacts, points)),
        neighbours=max(moves, _descent(contacts, scale)),
        force=abs(found.force - found.force_by_field) / (found.force_scale or 1.0),
    )


def _drives(contacts: FittedContacts, aside: float) -> list[tuple[FittedLine, float, float]]:
    """Every line with its drive just inside and just outside of it.

    By the rounding of its position; at a corner, the slope is read on either side.
    """
    problem, own, found = contacts.problem, gap_of(contacts.problem), []

    def beside(side: int, line: FittedLine) -> list[tuple[float, float]]:
        step = 0.0 if line.pinned else _ULPS * float(np.spacing(abs(line.x)))
        lo, hi = problem.scene.indenter.extent
        moved = (min(max(line.x + s * side * step, lo), hi) for s in (-1, 1))
        return [(x, s * aside * line.pinned) for x, s in zip(moved, (-1, 1), strict=True)]

    for side, line in contacts.outer:
        near, far = (problem.drive(side, *at) for at in beside(side, line))
        found.append((line, near, far))
    for q, p in contacts.gaps:
        near, far = (own.drive(1, x, p.x, away) for x, away in beside(1, q))
        found.append((q, near, far))
        near, far = (own.drive(-1, q.x, x, away) for x, away in beside(-1, p))
        found.append((p, near, far))
    return found


def _signs(contacts: FittedContacts, scale: float) -> tuple[float, float]:
    """Passage through the indenter at a line; energy gained by moving one."""
    problem, through, gain = contacts.problem, 0.0, 0.0
    for line, near, far in _drives(contacts, _aside(contacts)):
        gain = max(gain, near / scale)
        if line.x not in problem.scene.indenter.walls:
            gain = max(gain, -far / scale)
            through = max(through, -(far + problem.held) / scale)
    return through, gain


def _aside(contacts: FittedContacts) -> float:
    ends = contacts.x
    width = float(ends[-1, 1] - ends[0, 0])
    return _ASIDE * min(contacts.problem.scene.elastocapillary_length, width or math.inf)


def penetration(state: Equilibrium, points: Array) -> float:
    """max (g - u) [length] at increasing points, and between them where it may be larger."""
    indenter, lines = state.scene.indenter, state.contacts.ravel()

    def deep(x: Array) -> Array:
        return np.asarray(state.depth - indenter.height(x) - state.displacement(x))

    free = (np.searchsorted(lines, points) % 2 == 0) & ~np.isin(points, lines)
    x = np.union1d(points[free], lines)
    v = deep(x)
    if x.size < 3:
        return float(v.max(initial=0.0))
    steps = np.abs(np.diff(v))
    peak = (v[1:-1] >= v[:-2]) & (v[1:-1] >= v[2:]) & ~np.isin(x[1:-1], lines)
    peak &= v[1:-1] > -_NEAR * np.maximum(steps[:-1], steps[1:])
    lo, hi = x[:-2][peak], x[2:][peak]
    for _ in range(_REFINEMENTS if lo.size else 0):
        one, other = hi - _GOLDEN * (hi - lo), lo + _GOLDEN * (hi - lo)
        left = deep(one) > deep(other)
        lo, hi = np.where(left, lo, one), np.where(left, other, hi)
    return float(max(v.max(), deep(lo).max(initial=-math.inf), 0.0))


def _tension(contacts: FittedContacts, points: Array) -> float:
    """Largest force that would open a contact, over kδl."""
    problem, scene = contacts.problem, contacts.problem.scene
    corners, aside = np.asarray(scene.indenter.corners, float), _aside(contacts)
    held = scene.gamma1 * 2 * _deficit(scene)
    worst = 0.0
    for left, right in contacts.x.tolist():
        kinks = corners[(corners > left + aside) & (corners < right - aside)]
        beside = [scene.indenter.slope(kinks + away) for away in (aside, -aside)]
        if scene.slopes == "finite":
            beside = [np.arctan(slope) for slope in beside]
        jump = beside[0] - beside[1]
        worst = max(worst, float((-scene.gamma1 * jump - held).max(initial=0.0)))
    lone = contacts.x[:, 0] == contacts.x[:, 1]
    pulls = -scene.gamma1 * contacts.reactions.sum(axis=1)[lone]
    worst = max(worst, float(pulls.max(initial=0.0)))
    if not scene.work_of_adhesion:
        length = scene.elastocapillary_length
        pulls = [_stretched(problem, points, *pair) for pair in contacts.x.tolist()]
        worst = max([worst, *(length * pull for pull in pulls)])
    return worst / (scene.stiffness * problem.lift * scene.elastocapillary_length)


def _deficit(scene: Scene) -> float:
    """The kink r of the surface, in terms of slopes or angles, at which dU/dq = 0 at a line."""
    half = math.sqrt(scene.work_of_adhesion / (2 * scene.gamma1))
    return 2 * half if scene.slopes == "small" else 2 * math.asin(half)


def _stretched(problem: Problem, points: Array, left: float, right: float) -> float:
    """Largest -(kg + γ₁f'') between the corners of a contact, by differences of f' at points."""
    scene, indenter = problem.scene, problem.scene.indenter
    x = np.unique(np.concatenate([[left, right], points[(points > left) & (points < right)]]))
    x = x[np.append(True, np.diff(x) > 1e-9 * scene.elastocapillary_length)]
    if x.size < 2:
        return 0.0
    away = _INSIDE * np.diff(x)
    slope = [np.asarray(indenter.slope(at)) for at in (x[:-1] + away, x[1:] - away)]
    slope = [
        part / np.sqrt(1 + part * part) if scene.slopes == "finite" else part for part in slope
    ]
    bend = (slope[1] - slope[0]) / ((1 - 2 * _INSIDE) * np.diff(x))
    g = problem.depth - indenter.height(x)
    stress = scene.stiffness * (g[1:] + g[:-1]) / 2 + scene.gamma1 * bend
    return float(-stress.min())


def _stiffness(contacts: FittedContacts) -> list[tuple[list[FittedLine], Array]]:
    """The lines that feel each other and are free, and the changes of their drives."""
    problem, own, found = contacts.problem, gap_of(contacts.problem), []
    length, (start, stop) = problem.scene.elastocapillary_length, problem.scene.indenter.extent
    for side, line in contacts.outer:
        if not line.pinned:
            step = _DIFFERENCE * _room(contacts, line)
            lo, hi = max(line.x - step, start), min(line.x + step, stop)
            change = problem.drive(side, hi, 0.0) - problem.drive(side, lo, 0.0)
            found.append(([line], np.array([[side * change / (hi - lo)]])))
    for q, p in contacts.gaps:
        free = [i for i, line in enumerate((q, p)) if not line.pinned]
        if free:
            step = _DIFFERENCE * min(p.x - q.x, length, *(_room(contacts, at) for at in (q, p)))
            whole = own.stiffness(q.x, p.x, step)
            found.append(([(q, p)[i] for i in free], whole[np.ix_(free, free)]))
    return found


def _room(contacts: FittedContacts, line: FittedLine) -> float:
    """Width of the line's contact, at most l."""
    length = contacts.problem.scene.elastocapillary_length
    widths = [b.x - a.x for a, b in contacts.pairs if line in (a, b)]
    return min(length, max(widths)) or 1e-3 * length


def _descent(contacts: FittedContacts, scale: float) -> float:
    """How far the second variation of the energy is from positive, over a contact's width."""
    worst = 0.0
    for lines, rate in _stiffness(contacts):
        least = float(np.linalg.eigvalsh((rate + rate.T) / 2)[0])
        width = min(_room(contacts, line) for line in lines)
        worst = max(worst, -least * width / scale)
    return worst


def errors(contacts: FittedContacts, coarse: Interval, fine: Interval) -> dict[str, float]:
    """Errors of surfaces and rounding times the condition of the lines, and of the quadrature."""
    problem, own = contacts.problem, gap_of(contacts.problem)
    surface, move, push = _ROUNDING + problem.response.error, 0.0, 0.0
    scale = max(problem.scale(pair) for pair in contacts.pairs)
    for lines, rate in _stiffness(contacts):
        inverse = np.abs(np.linalg.pinv(rate))
        moved = inverse.sum(axis=1) * (surface * scale + felt(problem.scene, fine.rounding))
        moved += [_POSITION * abs(line.x) for line in lines]
        move += float(moved.sum())
        push += float(sum(_rate(own, line) * m for line, m in zip(lines, moved, strict=True)))
    width = float(np.diff(contacts.x, axis=1).sum())
    force, energy = fine.force_scale or 1.0, fine.energy_scale or 1.0
    rounding = surface + 3 * _ROUNDING
    found = (
        move / width + _ROUNDING if width else 0.0,
        (abs(fine.force - coarse.force) + push) / force + rounding,
        abs(fine.energy - coarse.energy) / energy + rounding,
    )
    return dict(zip(QUANTITIES, map(float, found), strict=True))


def _rate(own: Gap, line: FittedLine) -> float:
    """A bound of |dP/dq| of a line: k|g| + k l |f'|."""
    scene = own.problem.scene
    slope = abs(float(scene.indenter.slope(line.x))) * scene.elastocapillary_length
    return scene.stiffness * (abs(own.problem.displaced(line.x)) + slope)
