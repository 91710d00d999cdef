"""Lines of many free surfaces taken to rest by Newton's method, each surface at its own depth.

A line is either free, F = 0 (equations.py), or pinned where F jumps past 0: at a corner of the
profile, at an edge of the body and, with two works of adhesion, where it stands. A line that is
pressed against a corner beyond which F still has the same sign passes it. Which lines are free is
found along with where they rest (an active-set method, as in J. Nocedal, S. Wright, Numerical
Optimization, 2nd ed., ch. 16.5, with one bound on either side of every line).

Conventions
-----------
A row is a free surface: its left line in column 0 and its right line in column 1, -inf or inf where
a tail has none. Positions grow to the right. The left line of a free surface is the right end of a
contact, so that it advances to the right, the right line to the left: OUTWARDS = (1, -1).

F (`Equations.values`) has the sign of D - d, D the depth at which the line would rest: where F < 0
the line advances, so that the contact grows; where F > 0 it recedes. D rises outwards of a contact
where a rest is stable. Directions are 1 where the depth grows, with the work of adhesion of
closing, and -1 where it falls, with that of opening.

Joints are the places where F may jump: corners, edges of a pattern, and both ends of the profile. A
room is a piece of the profile between two neighbouring joints; `Equations.rooms` has the lower and
upper ends of all of them, some roundings inside of the joints, so that F there is that of the room.
`rooms_of` are the numbers of the rooms in which lines are, `snapped` are lines of which those some
roundings from a joint are put on it, and `on_profile` is where lines are on the profile, found once
for F and `Equations.rates`, its derivatives ∂F_i/∂x_j.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.refine.equations import OUTWARDS, Equations
from energy.arrays import Array, Indices, Mask, Nodes

# Of Newton's method, at most: 30 or 120 changes none of 23 random states and paths (`python -m
# tests.sensitivity discretization.refine.settle ROUNDS`).
ROUNDS = 60


class NewtonRules(NamedTuple):
    """How lines are taken to rest; lengths are of l but where it says otherwise.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 2 to 23 random
    states and paths as they are to 1e-9: `python -m tests.sensitivity
    discretization.refine.settle`.

    Attributes
    ----------
    longest : float
        Of a step: the tail of a free surface decays over l, so that F is nearly linear over a tenth
        of it.
    still : int
        Roundings of a position: a step that short is the last.
    quadratic : float
        The step that quadratic convergence would make next, s²/|last s|, is at most this: it is
        rounding.
    near : float
        Shorter steps may be judged by that: convergence is quadratic so near to rest.
    trembling : float
        Steps as short as this that no longer shrink are the rounding of F.
    narrow : float
        In narrower gaps rounding of F grows like the inverse square of their width: the rise of the
        profile over the width loses digits.
    narrow_room : float
        Rooms between two corners that are narrower hold no line at rest if it goes on at both ends:
        F hardly changes over a hundredth of l.
    most_rooms : int
        Rooms that a line passes at once; more are left to the next round.
    falls : float
        Of F: by more than this, which is its rounding, it falls over a corner that a line jumps
        over.
    """

    longest: float = 0.1
    still: int = 8
    quadratic: float = 1e-15
    near: float = 1e-9
    trembling: float = 1e-12
    narrow: float = 0.1
    narrow_room: float = 1e-2
    most_rooms: int = 4096
    falls: float = 1e-12


_NEWTON = NewtonRules()


class Settled(NamedTuple):
    """Free surfaces after Newton's method.

    Attributes
    ----------
    lines : ndarray (n, 2)
        [length].
    at_rest : ndarray of bool (n,)
        Whether both lines of a surface are in stable equilibrium.
    pinned : ndarray of bool (n, 2)
        Which lines are pinned.
    jumped : ndarray of bool (n,)
        Whether a line has passed a corner over which D falls, so that it has no rest in between.
    """

    lines: Array
    at_rest: Mask
    pinned: Mask
    jumped: Mask


@dataclass(eq=False)
class _Rows:
    """Free surfaces in motion, one in each row.

    Attributes
    ----------
    lines : ndarray (n, 2)
        Where they are now [length].
    rooms : ndarray of int (n, 2)
        The rooms in which the lines are; of a tail's missing line any.
    depths, directions : ndarray (n,)
        Depths at which they are to rest [length], and 1 or -1 (see the module).
    has_line : ndarray of bool (n, 2)
        Whether there is such a line: not that of a tail far away.
    start : ndarray (n, 2)
        Where the lines began [length].
    kept : ndarray (n, 2) or None
        With two works of adhesion: where lines stand until they move in their direction [length].
    """

    lines: Array
    rooms: Nodes
    depths: Array
    directions: Array
    has_line: Mask
    start: Array
    kept: Array | None

    def of(self, own: Indices) -> _Rows:
        """Copies of some of the rows."""
        return _Rows(
            self.lines[own],
            self.rooms[own],
            self.depths[own],
            self.directions[own],
            self.has_line[own],
            self.start[own],
            None if self.kept is None else self.kept[own],
        )


class _Round(NamedTuple):
    """Free surfaces after one round.

    Attributes
    ----------
    lines : ndarray (n, 2)
        After the step [length].
    pinned : ndarray of bool (n, 2)
        Lines that were pinned and took no step.
    fell : ndarray of bool (n,)
        Whether a line has passed a joint over which F falls.
    rates : ndarray (n, 2, 2)
        ∂F_i/∂x_j before the step [1/length].
    moved : ndarray (n,)
        How long the step was, that of the line which moved further [length].
    resting : ndarray of bool (n,)
        Whether the step was so short that the lines are at rest.
    lost : ndarray of bool (n,)
        Whether the surface is given up.
    """

    lines: Array
    pinned: Mask
    fell: Mask
    rates: Array
    moved: Array
    resting: Mask
    lost: Mask


def settle(
    equations: Equations,
    lines: Array,
    depths: Array,
    directions: Array,
    *,
    kept: Array | None = None,
    reach: float = math.inf,
    rounds: int = ROUNDS,
    downhill: bool = False,
) -> Settled:
    """Take the lines of free surfaces to rest: F = 0 of every line that is free.

    Each round finds which lines are pinned, takes one step of Newton's method with the free ones,
    of l/10 at most, and stops at joints. A surface is at rest when its step s is

        |s| <= 8 roundings of a position,  or  |s| < 1e-9 l and s² <= 1e-15 l |last s|,

    or no longer shrinks and is less than 1e-12 l (of gaps narrower than l/10 times the square of
    by how much they are narrower). It is given up when its lines cross or go further than `reach`,
    and when it is not at rest after `rounds`.

    Parameters
    ----------
    equations : Equations
    lines : ndarray (n, 2)
        Where to begin, near to where they rest [length].
    depths, directions : ndarray (n,)
        As in equations.py.
    kept : ndarray (n, 2), optional
        With two works of adhesion: where lines stand until they move in their direction [length].
    reach : float
        How far lines may move [length]; surfaces with one that goes further are not at rest.
    rounds : int
        Of Newton's method at most.
    downhill : bool
        Whether lines move as their forces push them where Newton's method leads to no stable rest.

    Returns
    -------
    Settled
    """
    count = len(lines)
    rows = _Rows(
        lines.copy(), equations.rooms_of(lines), depths, directions, np.isfinite(lines), lines, kept
    )
    pinned = np.zeros((count, 2), bool)
    jumped = np.zeros(count, bool)
    at_rest = np.zeros(count, bool)
    rates = np.zeros((count, 2, 2))
    moved = np.full(count, math.inf)
    active = np.arange(count)  # surfaces that are neither at rest nor given up
    for _ in range(rounds):
        if not active.size:
            break
        own = rows.of(active)
        found = _one_round(equations, own, moved[active], reach, downhill=downhill)
        rows.lines[active] = found.lines
        rows.rooms[active] = own.rooms
        pinned[active] = found.pinned
        jumped[active] |= found.fell
        rates[active] = found.rates
        moved[active] = found.moved
        at_rest[active] = found.resting & ~found.lost
        active = active[~(found.resting | found.lost)]
    at_rest &= stable(rates, rows.has_line & ~pinned)
    return Settled(equations.snapped(rows.lines), at_rest, pinned & rows.has_line, jumped)


def _one_round(
    equations: Equations, rows: _Rows, last_moved: Array, reach: float, *, downhill: bool
) -> _Round:
    """Find which lines are pinned and take one step of Newton's method with the others.

    last_moved: how long the last step of each surface was (n,), infinite before the first. Lines
    that go on beyond a joint are put there in `rows`; the step is only in what is returned.
    """
    rows.lines = _inside(equations, rows.lines, rows)
    on_profile = equations.on_profile(rows.lines)
    values = equations.values(rows.lines, rows.depths, rows.directions, on_profile)
    joints = _against_joints(equations, rows, values)
    if joints.passed.any():  # the lines are elsewhere
        on_profile = equations.on_profile(rows.lines)
    pinned = joints.pinned
    if rows.kept is not None:
        # Where it stands a line moves in the direction of its path or not at all: pressed it may
        # only advance (F < 0), retracted only recede (F > 0). One that stands at a joint, such as
        # an edge of the body, is read a few roundings beside it.
        stands = rows.has_line & (equations.snapped(rows.lines) == rows.kept)
        pinned |= stands & (rows.directions[:, None] * values > 0)
    free = rows.has_line & ~pinned
    rates = equations.rates(rows.lines, rows.depths, rows.rooms, on_profile)
    step = _limited_step(equations, rates, values, free, downhill=downhill)
    new = _inside(equations, rows.lines + step, rows)
    cut = (rows.has_line & (new != rows.lines + step)).any(axis=1)
    new = _not_behind(new, rows, free)
    moved = _distance(new, rows.lines, rows.has_line)
    too_far = _distance(new, rows.start, rows.has_line) > reach
    crossed = rows.has_line.all(axis=1) & (new[:, 0] >= new[:, 1])
    # A step that a joint has cut short or led beyond it says nothing about convergence.
    resting = _converged(equations, new, moved, last_moved) & ~cut & ~joints.passed
    lost = crossed | too_far | ~np.isfinite(moved)
    return _Round(new, pinned, joints.fell, rates, moved, resting, lost)


def _limited_step(
    equations: Equations, rates: Array, values: Array, free: Mask, *, downhill: bool
) -> Array:
    """The step (n, 2) of Newton's method, or of the longest length in the direction of the forces.

    The latter where F does not change, and `downhill` where the equilibrium ahead is not stable:
    Newton's method would go there nevertheless. Both lines of a surface are shortened alike, so
    that the direction of Newton's step is kept.
    """
    longest = _NEWTON.longest * equations.length
    step = _newton_step(rates, values, free)
    pushed = -np.sign(values) * OUTWARDS * longest  # outwards of the contact where F < 0
    astray = ~np.isfinite(step)
    if downhill:
        astray |= ~stable(rates, free)[:, None]
    step = np.where(free & astray, pushed, step)
    length = np.asarray(np.abs(step).max(axis=1))
    shortened = np.minimum(1.0, longest / np.maximum(length, 1e-300))  # no division by 0
    return np.asarray(step * shortened[:, None])


def _distance(lines: Array, others: Array, has_line: Mask) -> Array:
    """How far lines (n, 2) are from others of the same surfaces (n, 2): the larger of both (n,)."""
    apart = np.subtract(lines, others, out=np.zeros_like(lines), where=has_line)
    return np.asarray(np.abs(apart).max(axis=1))


def stable(rates: Array, free: Mask) -> Mask:
    """Whether free lines are in stable equilibrium: the matrix of ∂²U/∂x_i∂x_j is positive.

    F has the sign of the change of U as a line advances, which a left line does to the right and a
    right one to the left. So at rest the rows of the matrix have the signs of ∂F_0/∂x_j and of
    -∂F_1/∂x_j.

    Parameters
    ----------
    rates : ndarray (n, 2, 2)
        ∂F_i/∂x_j [1/length], i and j 0 for the left and 1 for the right line.
    free : ndarray of bool (n, 2)
        Lines that are not pinned; the others do not move and make nothing unstable.

    Returns
    -------
    ndarray of bool (n,)
    """
    # Both diagonal elements and the determinant have to be positive.
    left = np.where(free[:, 0], rates[:, 0, 0], 1.0)
    right = np.where(free[:, 1], rates[:, 1, 1], -1.0)
    both = free.all(axis=1)
    coupling = np.where(both, rates[:, 0, 1] * rates[:, 1, 0], 0.0)
    return np.asarray((left > 0) & (right < 0) & (left * right - coupling < 0))


def _newton_step(rates: Array, values: Array, free: Mask) -> Array:
    """The step of Newton's method: (∂F_i/∂x_j) step = -F of the free lines.

    Parameters
    ----------
    rates : ndarray (n, 2, 2)
        ∂F_i/∂x_j [1/length].
    values : ndarray (n, 2)
        F.
    free : ndarray of bool (n, 2)
        Lines that are not pinned.

    Returns
    -------
    ndarray (n, 2)
        [length]; 0 of other lines, not finite where the equations are singular.
    """
    left_value, right_value = values.T
    left_by_left, left_by_right = rates[:, 0].T
    right_by_left, right_by_right = rates[:, 1].T
    determinant = left_by_left * right_by_right - left_by_right * right_by_left
    with np.errstate(divide="ignore", invalid="ignore"):
        # Cramer's rule where both lines are free, else each equation by itself
        left = (right_value * left_by_right - left_value * right_by_right) / determinant
        right = (left_value * right_by_left - right_value * left_by_left) / determinant
        alone = -values / rates[:, [0, 1], [0, 1]]
    together = np.stack([left, right], axis=1)
    both = np.asarray(free.all(axis=1))
    step = np.where(both[:, None], together, alone)
    return np.where(free, step, 0.0)


def _inside(equations: Equations, lines: Array, rows: _Rows) -> Array:
    """Lines (n, 2), those beyond an end of their room put on that end."""
    lower, upper = equations.rooms
    bounded = np.clip(lines, lower[rows.rooms], upper[rows.rooms])
    return np.where(rows.has_line, bounded, lines)


def _not_behind(new: Array, rows: _Rows, free: Mask) -> Array:
    """Lines (n, 2); with two works of adhesion free ones are not behind where they stood.

    Pressed lines only advance, left ones to the right; retracted lines only recede.
    """
    if rows.kept is None:
        return new
    to_the_right = rows.directions[:, None] * OUTWARDS > 0
    bounded = np.where(to_the_right, np.maximum(new, rows.kept), np.minimum(new, rows.kept))
    return np.where(free, bounded, new)


@dataclass(eq=False)
class _AtJoints:
    """What becomes of lines that would move on at an end of their room.

    Attributes
    ----------
    pinned : ndarray of bool (n, 2)
        Lines that stay at the joint.
    passed : ndarray of bool (n,)
        Whether a line of the surface has passed the joint.
    fell : ndarray of bool (n,)
        Whether F falls outwards of the contact over a joint that a line has passed, which has no
        rest there.
    """

    pinned: Mask
    passed: Mask
    fell: Mask


def _against_joints(equations: Equations, rows: _Rows, values: Array) -> _AtJoints:
    """Pin lines that are at an end of their room and would move on, or put them beyond the joint.

    Lines and rooms of `rows`, and their F, `values` (n, 2), change in place where lines pass. Of a
    surface one line passes at a time, as F of the other one changes with it.
    """
    lower, upper = equations.rooms
    none = np.zeros(len(values), bool)
    found = _AtJoints(np.zeros_like(rows.has_line), none, none.copy())
    for motion in (1, -1):  # lines that would advance (F < 0), then those that would recede (F > 0)
        to_the_right = motion * OUTWARDS > 0
        end = np.where(to_the_right, upper[rows.rooms], lower[rows.rooms])
        blocked = rows.has_line & (rows.lines == end) & (motion * values < 0)
        for column in (0, 1):
            at_end = blocked[:, column] & ~found.passed
            if at_end.any():
                _tried_beyond(equations, rows, values, found, at_end, column, motion)
    return found


def _tried_beyond(
    equations: Equations,
    rows: _Rows,
    values: Array,
    found: _AtJoints,
    at_end: Mask,
    column: int,
    motion: int,
) -> None:
    """Put lines beyond the joint that they are at if they would go on from there; else pin them.

    at_end: surfaces (n,) whose line in this column is at the end of its room; motion: 1 where it
    advances, -1 where it recedes. Written into `rows`, `values` and `found`.
    """
    lower, upper = equations.rooms
    step = int(motion * OUTWARDS[column])  # 1: to the right
    next_room = rows.rooms[:, column] + step
    exists = (next_room >= 0) & (next_room < lower.size)
    next_room = np.clip(next_room, 0, lower.size - 1)
    beyond = lower[next_room] if step > 0 else upper[next_room]
    trial = rows.lines.copy()
    trial[at_end, column] = beyond[at_end]
    value = values[:, column]
    value_beyond = equations.values(trial, rows.depths, rows.directions)[:, column]
    goes_on = at_end & exists & (motion * value_beyond < 0)
    found.pinned[at_end & ~goes_on, column] = True
    # Outwards of the contact: from here to beyond for an advancing line, else the other way round.
    fall = motion * (value - value_beyond)
    found.fell |= goes_on & (fall > _NEWTON.falls * np.maximum(1.0, np.abs(value)))
    rows.lines[goes_on, column] = beyond[goes_on]
    rows.rooms[goes_on, column] = next_room[goes_on]
    for row in np.flatnonzero(goes_on).tolist():
        found.fell[row] |= _through_narrow_rooms(equations, rows, row, column, motion)
    values[goes_on] = equations.values(rows.lines, rows.depths, rows.directions)[goes_on]
    found.passed |= goes_on


def _through_narrow_rooms(
    equations: Equations, rows: _Rows, row: int, column: int, motion: int
) -> bool:
    """Put a line at the far end of the last narrow room that it passes; whether F falls in between.

    The line, of one surface and in one column, is at the near end of a room; motion is 1 where it
    advances, -1 where it recedes. Between corners that are close to each other F hardly changes, so
    that no line rests within a room at both ends of which it goes on.
    """
    lower, upper = equations.rooms
    step = int(motion * OUTWARDS[column])  # 1: to the right
    first = int(rows.rooms[row, column])
    line = rows.lines[row, column]
    room = np.arange(first, first + step * _NEWTON.most_rooms, step)
    room = room[(room >= 0) & (room < lower.size)]
    near, far = (lower[room], upper[room]) if step > 0 else (upper[room], lower[room])

    # Rooms up to the first that is wide, too far away, or beyond the line on the other side.
    facing = rows.lines[row, 1 - column]
    usable = np.abs(far - near) <= _NEWTON.narrow_room * equations.length
    usable &= np.abs(far - line) <= _NEWTON.longest * equations.length
    if np.isfinite(facing):
        usable &= (facing - far) * OUTWARDS[column] > 0
    count = int(usable.size if usable.all() else usable.argmin())
    if not count:
        return False

    # F of the line at both ends of these rooms, with the sign that is negative where it goes on.
    trial = np.repeat(rows.lines[row][None], 2 * count, axis=0)
    trial[:count, column] = near[:count]
    trial[count:, column] = far[:count]
    depths = np.full(2 * count, rows.depths[row])
    directions = np.full(2 * count, rows.directions[row])
    values = motion * equations.values(trial, depths, directions)[:, column]
    at_near, at_far = values[:count], values[count:]
    passes = (at_near < 0) & (at_far < 0)
    passed = int(count if passes.all() else passes.argmin())
    if not passed:
        return False
    rows.lines[row, column] = far[passed - 1]
    rows.rooms[row, column] = room[passed - 1]
    falls = at_far[: passed - 1] - at_near[1:passed]
    least = _NEWTON.falls * np.maximum(1.0, np.abs(at_far[: passed - 1]))
    return bool((falls > least).any())


def _converged(equations: Equations, lines: Array, moved: Array, last_moved: Array) -> Mask:
    """Whether Newton's method has converged (n,): the three conditions that `settle` states.

    lines (n, 2) are those after the step, moved and last_moved (n,) how long this step and the one
    before it were.
    """
    length = equations.length
    furthest = np.abs(np.where(np.isfinite(lines), lines, 0.0)).max(axis=1)
    rounding = _NEWTON.still * np.spacing(length + furthest)
    still = moved <= rounding
    quadratic = moved < _NEWTON.near * length
    quadratic &= moved * moved <= _NEWTON.quadratic * length * last_moved
    with np.errstate(invalid="ignore", divide="ignore"):
        narrower = _NEWTON.narrow * length / (lines[:, 1] - lines[:, 0])  # 0 of tails
    widened = np.maximum(1.0, np.where(narrower > 0, narrower, 0.0) ** 2)
    trembling = moved < _NEWTON.trembling * length * widened
    trembling &= moved > last_moved / 2  # quadratic convergence would more than halve it
    return np.asarray(still | quadratic | trembling)
