"""Depths of events as roots of small systems, those of many events at once.

Unknown are both lines of a free surface, the depth and, where it touches, the place of that:

    fold     F = 0 of the free lines, and the determinant of their ∂F/∂x vanishes
    touch    F = 0 of the free lines, gap v = 0, and v' = 0 or, at a corner, the place is known
    meeting  F = 0 of both lines of the contact between two surfaces, at the same place, and of the
             free lines beyond

A line that is pinned or does not exist keeps its place: x - x₀ = 0.

Conventions
-----------
Depths grow as the indenter goes down. A row of `lines` is a free surface with its left line in
column 0 and its right line in column 1 [length], -inf and inf where a tail has none, for which 0
stands among the unknowns. Directions are 1 where the depth grows, with the work of adhesion of
closing, and -1 where it falls, with that of opening. F = `Equations.values` is 0 where a line
rests, `Equations.rates` is its ∂F_i/∂x_j, and `Equations.shape` has the gap v between a surface and
the profile, negative where the surface would be in the profile, and v'. A joint is a place where F
may jump, a room a piece of the profile between two of them: `rooms` are the lower and the upper
ends of all rooms, and `rooms_of` the numbers of those in which lines are. `length` is l, and `size`
that of depths.

Each kind of event has a function `off`: the left-hand sides (k, m) of the systems with the numbers
`own` (k,), which vanish at the root, given the unknowns (k, m) of these. They are dimensionless.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from discretization.refine.equations import Equations
from energy.arrays import Array, Indices, Mask


class RootRules(NamedTuple):
    """How roots are found; lengths are of l.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 8 to 23 random
    states and paths as they are to 1e-9: `python -m tests.sensitivity discretization.refine.roots`.

    Attributes
    ----------
    rounds : int
        Of Newton's method, which needs a handful from nearby; roots that need more are given up.
    fold_step : float
        Step of central differences of the determinant, which has f'' in it: longer than that of
        f''.
    touch_step : float
        The same of what has no second derivative in it: its error is the square, 1e-10.
    longest : float
        Of a step.
    found : float
        The last step of a root that is found.
    flat : float
        The same of a fold where rounding of the determinant makes more of it: the depth is
        stationary there, so that it is off by the square, 1e-12.
    """

    rounds: int = 25
    fold_step: float = 1e-4
    touch_step: float = 1e-5
    longest: float = 0.1
    found: float = 1e-10
    flat: float = 1e-6


_ROOT = RootRules()


class Roots(NamedTuple):
    """Depths at which something happens to free surfaces.

    Attributes
    ----------
    lines : ndarray (n, 2)
        Of the surfaces there [length]; of meetings the outer lines of both surfaces.
    depths : ndarray (n,)
        [length].
    places : ndarray (n,)
        Where a surface touches or lines meet [length]; nan of folds.
    found : ndarray of bool (n,)
        Whether Newton's method has converged.
    """

    lines: Array
    depths: Array
    places: Array
    found: Mask


def folds(
    equations: Equations, lines: Array, depths: Array, directions: Array, free: Mask
) -> Roots:
    """Folds: depths at which equilibria of free surfaces disappear, det ∂F/∂x = 0.

    Those next to a joint, at which F jumps, are left out: differences across it make roots that
    are none.

    Parameters
    ----------
    equations : Equations
    lines : ndarray (n, 2)
        Near those at the fold [length].
    depths : ndarray (n,)
        Near the fold [length].
    directions : ndarray (n,)
        1 where the depth grows, -1 where it falls.
    free : ndarray of bool (n, 2)
        Lines that are not pinned.

    Returns
    -------
    Roots
    """
    length = equations.length
    rooms = equations.rooms_of(lines)

    def off(unknown: Array, own: Indices) -> Array:
        """Of unknowns (k, 3): the left line, the right line, the depth."""
        at = np.where(free[own], unknown[:, :2], lines[own])
        values = equations.values(at, unknown[:, 2], directions[own])
        rates = equations.rates(at, unknown[:, 2], rooms[own])
        left = rates[:, 0, 0]
        right = rates[:, 1, 1]
        coupling = rates[:, 0, 1] * rates[:, 1, 0]
        of_both_lines = (left * right - coupling) * length**2
        of_one_line = np.where(free[own, 0], left, right) * length
        both_free = free[own].all(axis=1)
        singular = np.where(both_free, of_both_lines, of_one_line)
        stays = _moved(unknown[:, :2], lines[own]) / length
        return np.column_stack([np.where(free[own], values, stays), singular])

    start = np.column_stack([np.where(np.isfinite(lines), lines, 0.0), depths])
    steps = _ROOT.fold_step * np.array([length, length, equations.size])
    found, good = _newton(off, start, steps, length, rounding=_ROOT.flat)
    at = np.where(np.isfinite(lines), found[:, :2], lines)
    lower, upper = equations.rooms
    aside = _ROOT.fold_step * length
    inside = (at > lower[rooms] + aside) & (at < upper[rooms] - aside)
    good &= free.any(axis=1) & (inside | ~free).all(axis=1)
    return Roots(at, found[:, 2], np.full(len(lines), np.nan), good)


def touches(
    equations: Equations,
    lines: Array,
    depths: Array,
    directions: Array,
    free: Mask,
    places: Array,
    corner: Mask,
) -> Roots:
    """Depths at which free surfaces touch the profile: v = 0, and v' = 0 or a corner.

    Parameters
    ----------
    equations : Equations
    lines : ndarray (n, 2)
        Near those at the touch [length].
    depths : ndarray (n,)
        Near that of the touch [length].
    directions : ndarray (n,)
        1 where the depth grows, -1 where it falls.
    free : ndarray of bool (n, 2)
        Lines that are not pinned.
    places : ndarray (n,)
        Near where the surface touches [length].
    corner : ndarray of bool (n,)
        Whether the place is a corner, and so exact.

    Returns
    -------
    Roots
    """
    length = equations.length

    def off(unknown: Array, own: Indices) -> Array:
        """Of unknowns (k, 4): the left line, the right line, the place of the touch, the depth."""
        at = np.where(free[own], unknown[:, :2], lines[own])
        values = equations.values(at, unknown[:, 3], directions[own])
        place = np.where(corner[own], places[own], unknown[:, 2])
        gap, slope = equations.shape(place[:, None], at, unknown[:, 3])
        at_corner = (unknown[:, 2] - places[own]) / length
        stays = _moved(unknown[:, :2], lines[own]) / length
        return np.column_stack(
            [
                np.where(free[own], values, stays),
                np.where(corner[own], at_corner, slope[:, 0]),
                gap[:, 0] / equations.size,
            ]
        )

    start = np.column_stack([np.where(np.isfinite(lines), lines, 0.0), places, depths])
    steps = _ROOT.touch_step * np.array([length, length, length, equations.size])
    found, good = _newton(off, start, steps, length)
    at = np.where(np.isfinite(lines), found[:, :2], lines)
    with np.errstate(invalid="ignore"):
        good &= (at[:, 0] < found[:, 2]) & (found[:, 2] < at[:, 1])
    return Roots(at, found[:, 3], found[:, 2], good)


def meetings(
    equations: Equations,
    left: Array,
    right: Array,
    depths: Array,
    directions: Array,
    left_free: Mask,
    right_free: Mask,
) -> Roots:
    """Depths at which contacts disappear as both their lines meet.

    Parameters
    ----------
    equations : Equations
    left, right : ndarray (n, 2)
        Lines of the free surfaces on the left and on the right of each contact [length].
    depths : ndarray (n,)
        Near that of the meeting [length].
    directions : ndarray (n,)
        1 where the depth grows, -1 where it falls.
    left_free, right_free : ndarray of bool (n,)
        Whether the outer lines of the two surfaces, those of other contacts, are free.

    Returns
    -------
    Roots
        Its lines are the outer lines of both surfaces, its places where the inner ones meet.
    """
    length = equations.length

    def off(unknown: Array, own: Indices) -> Array:
        """Of unknowns (k, 4): the outer left line, the meeting, the outer right line, the depth."""
        left_surface = np.column_stack([unknown[:, 0], unknown[:, 1]])
        right_surface = np.column_stack([unknown[:, 1], unknown[:, 2]])
        left_surface[:, 0] = np.where(left_free[own], left_surface[:, 0], left[own, 0])
        right_surface[:, 1] = np.where(right_free[own], right_surface[:, 1], right[own, 1])
        of_left = equations.values(left_surface, unknown[:, 3], directions[own])
        of_right = equations.values(right_surface, unknown[:, 3], directions[own])
        stays_left = (unknown[:, 0] - start[own, 0]) / length
        stays_right = (unknown[:, 2] - start[own, 2]) / length
        return np.column_stack(
            [
                np.where(left_free[own], of_left[:, 0], stays_left),
                of_left[:, 1],
                of_right[:, 0],
                np.where(right_free[own], of_right[:, 1], stays_right),
            ]
        )

    outer = np.column_stack([left[:, 0], right[:, 1]])
    outer = np.where(np.isfinite(outer), outer, 0.0)
    middle = (left[:, 1] + right[:, 0]) / 2
    start = np.column_stack([outer[:, 0], middle, outer[:, 1], depths])
    steps = _ROOT.touch_step * np.array([length, length, length, equations.size])
    found, good = _newton(off, start, steps, length)
    return Roots(found[:, [0, 2]], found[:, 3], found[:, 1], good)


def _moved(unknown: Array, lines: Array) -> Array:
    """How far unknowns (k, 2) are from lines (k, 2), from 0 for lines that do not exist."""
    start = np.where(np.isfinite(lines), lines, 0.0)
    return np.asarray(unknown - start)


def _newton(
    off: Callable[[Array, Indices], Array],
    start: Array,
    steps: Array,
    length: float,
    rounding: float = _ROOT.found,
) -> tuple[Array, Mask]:
    """Roots of n systems of m equations by Newton's method with central differences.

    A root is found when the step of its positions is

        max |s_i| < 1e-10 l,

    or, after 25 steps of at most l/10, less than `rounding` l; systems that become singular are
    given up.

    Parameters
    ----------
    off : callable
        Left-hand sides (k, m) for unknowns (k, m) of the systems with numbers (k,).
    start : ndarray (n, m)
        Where to begin; the last unknown is a depth, the others are positions [length].
    steps : ndarray (m,)
        Of the differences [length].
    length : float
        l [length].
    rounding : float
        Of l: how long the last step may be where rounding lets it be no shorter.

    Returns
    -------
    unknown : ndarray (n, m)
    found : ndarray of bool (n,)
    """
    count, size = start.shape
    unknown = start.copy()
    found = np.zeros(count, bool)
    shifts = np.concatenate([np.zeros((1, size)), np.diag(steps), -np.diag(steps)])
    active = np.arange(count)
    last = np.full(count, np.inf)
    for _ in range(_ROOT.rounds):
        if not active.size:
            break
        tried = unknown[active, None] + shifts
        own = np.repeat(active, len(shifts))
        with np.errstate(all="ignore"):
            values = off(tried.reshape(-1, size), own).reshape(active.size, -1, size)
            jacobian = (values[:, 1 : size + 1] - values[:, size + 1 :]) / (2 * steps[:, None])
        jacobian = jacobian.transpose(0, 2, 1)
        usable = np.asarray(np.isfinite(jacobian).all(axis=(1, 2)))
        usable &= np.isfinite(values[:, 0]).all(axis=1)
        usable[usable] = np.abs(np.linalg.det(jacobian[usable])) > 0
        active = active[usable]
        step = -np.linalg.solve(jacobian[usable], values[usable, 0, :, None])[..., 0]
        moved = np.abs(step[:, :-1]).max(axis=1)
        # At most l/10; 1e-300 stands for a step of 0, by which nothing may be divided.
        step *= np.minimum(1.0, _ROOT.longest * length / np.maximum(moved, 1e-300))[:, None]
        unknown[active] += step
        last[active] = moved
        done = moved < _ROOT.found * length
        found[active[done]] = True
        active = active[~done]
    found[active] = last[active] < rounding * length
    return unknown, found
