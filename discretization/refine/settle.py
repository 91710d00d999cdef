"""Lines of many free surfaces taken to rest by Newton's method, each surface at its own depth.

A line is either free, F = 0 (equations.py), or pinned where F jumps past 0: at a corner of the
profile, at an edge of the body and, with two works of adhesion, where it stands. A line that is
pressed against a corner beyond which F still has the same sign passes it. Which lines are free is
found along with where they rest (an active-set method, as in J. Nocedal, S. Wright, Numerical
Optimization, 2nd ed., ch. 16.5, with one bound on either side of every line).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.refine.equations import OUTWARDS, Equations
from energy.arrays import Array, Indices, Mask, Nodes

ROUNDS = 60  # of Newton's method


class NewtonRules(NamedTuple):
    """How lines are taken to rest; lengths are of l but where it says otherwise.

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
    """Free surfaces in motion, rows of arrays: lines, rooms (n, 2), and what is known of each."""

    lines: Array
    rooms: Nodes
    depths: Array
    directions: Array
    has_line: Mask
    start: Array
    kept: Array | None
    fixed: Mask | None

    def of(self, own: Indices) -> _Rows:
        """Some of the rows."""
        kept = None if self.kept is None else self.kept[own]
        fixed = None if self.fixed is None else self.fixed[own]
        return _Rows(
            self.lines[own],
            self.rooms[own],
            self.depths[own],
            self.directions[own],
            self.has_line[own],
            self.start[own],
            kept,
            fixed,
        )


def settle(
    equations: Equations,
    lines: Array,
    depths: Array,
    directions: Array,
    *,
    kept: Array | None = None,
    fixed: Mask | None = None,
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
        Where to begin, near to where they rest.
    depths, directions : ndarray (n,)
        As in equations.py.
    kept : ndarray (n, 2), optional
        With two works of adhesion: where lines stand until they move in their direction.
    fixed : ndarray of bool (n, 2), optional
        Lines that are left where they are.
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
        lines.copy(), equations.rooms_of(lines), depths, directions, np.isfinite(lines),
        lines, kept, fixed,
    )  # fmt: skip
    pinned = np.zeros((count, 2), bool)
    jumped = np.zeros(count, bool)
    at_rest = np.zeros(count, bool)
    rates = np.zeros((count, 2, 2))
    last = np.full(count, math.inf)
    active = np.arange(count)
    for _ in range(rounds):
        if not active.size:
            break
        own = rows.of(active)
        own.lines = _inside(equations, own.lines, own)
        on_profile = equations.on_profile(own.lines)
        values = equations.values(own.lines, own.depths, own.directions, on_profile)
        stopped, passed, fell = _against_joints(equations, own, values)
        if passed.any():  # the lines are elsewhere
            on_profile = equations.on_profile(own.lines)
        if own.kept is not None:
            stays = own.has_line & (own.lines == own.kept)
            stopped |= stays & (own.directions[:, None] * values > 0)
        if own.fixed is not None:
            stopped = (stopped & ~own.fixed) | own.fixed
        changed = equations.rates(own.lines, own.depths, own.rooms, on_profile)
        free = own.has_line & ~stopped
        step = _limited_step(equations, changed, values, free, downhill=downhill)
        new = _inside(equations, own.lines + step, own)
        cut = (own.has_line & (new != own.lines + step)).any(axis=1)
        new = _not_behind(new, own, free)
        moved = _distance(new, own.lines, own.has_line)
        gone = _distance(new, own.start, own.has_line) > reach
        crossed = own.has_line.all(axis=1) & (new[:, 0] >= new[:, 1])
        resting = _rests(equations, new, moved, last[active], passed, cut)
        rows.lines[active] = new
        rows.rooms[active] = own.rooms
        pinned[active] = stopped
        jumped[active] |= fell
        rates[active] = changed
        last[active] = moved
        lost = crossed | gone | ~np.isfinite(moved)
        at_rest[active] = resting & ~lost
        active = active[~(resting | lost)]
    free = rows.has_line & ~pinned
    at_rest &= stable(rates, free)
    return Settled(equations.snapped(rows.lines), at_rest, pinned & rows.has_line, jumped)


def _limited_step(
    equations: Equations, rates: Array, values: Array, free: Mask, *, downhill: bool
) -> Array:
    """The step (n, 2) of Newton's method, or of the longest length in the direction of the forces.

    The latter where F does not change, and `downhill` where the equilibrium ahead is not stable.
    """
    longest = _NEWTON.longest * equations.length
    step = _newton_step(rates, values, free)
    pushed = -np.sign(values) * OUTWARDS * longest
    astray = ~np.isfinite(step)
    if downhill:
        astray |= ~stable(rates, free)[:, None]
    step = np.where(free & astray, pushed, step)
    length = np.asarray(np.abs(step).max(axis=1))
    shortened = np.minimum(1.0, longest / np.maximum(length, 1e-300))
    return np.asarray(step * shortened[:, None])


def _distance(lines: Array, others: Array, has_line: Mask) -> Array:
    """How far apart the lines of surfaces are (n,), the further one of each."""
    apart = np.subtract(lines, others, out=np.zeros_like(lines), where=has_line)
    return np.asarray(np.abs(apart).max(axis=1))


def stable(rates: Array, free: Mask) -> Mask:
    """Whether free lines are in stable equilibrium: the matrix of ∂²U/∂x_i∂x_j is positive.

    Parameters
    ----------
    rates : ndarray (n, 2, 2)
        ∂F_i/∂x_j [1/length].
    free : ndarray of bool (n, 2)

    Returns
    -------
    ndarray of bool (n,)
    """
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
    """Lines not beyond their rooms."""
    lower, upper = equations.rooms
    kept = np.clip(lines, lower[rows.rooms], upper[rows.rooms])
    if rows.fixed is not None:
        kept = np.where(rows.fixed, lines, kept)
    return np.where(rows.has_line, kept, lines)


def _not_behind(new: Array, rows: _Rows, free: Mask) -> Array:
    """With two works of adhesion: free lines not behind where they stood."""
    if rows.kept is None:
        return new
    forwards = rows.directions[:, None] * OUTWARDS > 0
    bounded = np.where(forwards, np.maximum(new, rows.kept), np.minimum(new, rows.kept))
    return np.where(free, bounded, new)


def _against_joints(equations: Equations, rows: _Rows, values: Array) -> tuple[Mask, Mask, Mask]:
    """Lines at an end of their room that would move on: pinned there, or put beyond the joint.

    Which lines are pinned (n, 2), which surfaces have a line that has passed (n,), and which one
    over which F falls (n,). Lines and rooms of rows that pass are changed in place; of a surface
    one line at a time.
    """
    lower, upper = equations.rooms
    stopped = np.zeros_like(rows.has_line)
    passed = np.zeros(len(values), bool)
    fell = np.zeros(len(values), bool)
    for outwards in (1, -1):
        heading = outwards * OUTWARDS
        end = np.where(heading > 0, upper[rows.rooms], lower[rows.rooms])
        blocked = rows.has_line & (rows.lines == end) & (outwards * values < 0)
        if rows.fixed is not None:
            blocked &= ~rows.fixed
        if not blocked.any():
            continue
        next_room = rows.rooms + heading.astype(int)
        exists = (next_room >= 0) & (next_room < lower.size)
        next_room = np.clip(next_room, 0, lower.size - 1)
        beyond = np.where(heading > 0, lower[next_room], upper[next_room])
        for column in (0, 1):
            at_end = blocked[:, column] & ~passed
            if not at_end.any():
                continue
            trial = rows.lines.copy()
            trial[at_end, column] = beyond[at_end, column]
            there = equations.values(trial, rows.depths, rows.directions)[:, column]
            goes_on = at_end & exists[:, column] & (outwards * there < 0)
            stopped[at_end & ~goes_on, column] = True
            fall = outwards * (values[:, column] - there)
            fell |= goes_on & (fall > _NEWTON.falls * np.maximum(1.0, np.abs(values[:, column])))
            rows.lines[goes_on, column] = beyond[goes_on, column]
            rows.rooms[goes_on, column] = next_room[goes_on, column]
            for row in np.flatnonzero(goes_on).tolist():
                fell[row] |= _through_narrow_rooms(equations, rows, row, column, outwards)
            values[goes_on] = equations.values(rows.lines, rows.depths, rows.directions)[goes_on]
            passed |= goes_on
    return stopped, passed, fell


def _through_narrow_rooms(
    equations: Equations, rows: _Rows, row: int, column: int, outwards: int
) -> bool:
    """Put a line at the far end of the last narrow room that it passes; whether F falls in between.

    outwards: 1 where it advances, -1 where it recedes. Between corners that are close to each other
    F hardly changes, so that no line rests within a room at both ends of which it goes on.
    """
    lower, upper = equations.rooms
    step = int(outwards * OUTWARDS[column])
    first = int(rows.rooms[row, column])
    line = rows.lines[row, column]
    room = np.arange(first, first + step * _NEWTON.most_rooms, step)
    room = room[(room >= 0) & (room < lower.size)]
    near, far = (lower[room], upper[room]) if step > 0 else (upper[room], lower[room])
    narrow = np.abs(far - near) <= _NEWTON.narrow_room * equations.length
    within = np.abs(far - line) <= _NEWTON.longest * equations.length
    facing = rows.lines[row, 1 - column]
    apart = (facing - far) * OUTWARDS[column] > 0 if np.isfinite(facing) else True
    usable = narrow & within & apart
    count = int(usable.size if usable.all() else usable.argmin())
    if not count:
        return False
    trial = np.repeat(rows.lines[row][None], 2 * count, axis=0)
    trial[:count, column] = near[:count]
    trial[count:, column] = far[:count]
    depths = np.full(2 * count, rows.depths[row])
    directions = np.full(2 * count, rows.directions[row])
    values = outwards * equations.values(trial, depths, directions)[:, column]
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


def _rests(
    equations: Equations, lines: Array, moved: Array, before: Array, passed: Mask, cut: Mask
) -> Mask:
    """Whether Newton's method has come to rest (n,), after steps of this length and the last."""
    length = equations.length
    furthest = np.abs(np.where(np.isfinite(lines), lines, 0.0)).max(axis=1)
    rounding = _NEWTON.still * np.spacing(length + furthest)
    still = moved <= rounding
    squared = (moved < _NEWTON.near * length) & (
        moved * moved <= _NEWTON.quadratic * length * before
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        narrow = _NEWTON.narrow * length / (lines[:, 1] - lines[:, 0])
    trembles = _NEWTON.trembling * length * np.maximum(1.0, np.where(narrow > 0, narrow, 0.0) ** 2)
    trembling = (moved < trembles) & (before < 100 * trembles)
    trembling &= moved > before / 2
    return np.asarray((still | squared | trembling) & ~cut & ~passed)
