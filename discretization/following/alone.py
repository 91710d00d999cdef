"""One contact that stays alone: its lines at any depths of a way, each from a bracket of its own.

Of a profile with one contact (routes.one_contact) D(x) grows outwards of each line from where the
contact is lost, so that a line has one place for every depth on the way. No event happens on it but
at its end: a line that a corner holds comes free, or the contact is lost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.rests import TIE, Rests
from discretization.following import vanishing
from discretization.following.track import demand
from discretization.roots import crossings

Array = NDArray[np.float64]
_FIRST, _GROWS = 1e-6, 4.0  # of l: the first step to where D is beyond a depth, and its growth
_SIDES = np.array([-1, 1])  # of the left and of the right line


@dataclass(frozen=True, eq=False)
class Alone:
    """The lines (2,) of a contact at the start of a way and at its end.

    lost: whether the contact is lost at the end.
    """

    rests: Rests
    way: int
    depths: tuple[float, float]
    first: Array
    last: Array
    lost: bool = False

    @classmethod
    def of(cls, rests: Rests, surfaces: Array, start: float, end: float) -> Alone | None:
        """The way towards a depth up to its first event; None where that is not known to be one."""
        surfaces = rests.snapped(surfaces)
        way, first = (1 if end >= start else -1), surfaces[[0, 1], [1, 0]]
        axis = int(rests.scene.axisymmetric)  # which is no line
        ahead = way * np.diagonal(rests.ahead(surfaces, way)[:, ::-1])[axis:]
        point = way < 0 and first[0] == first[1]  # of a tip, which lets go where it is pulled
        size = _size(rests, start, end)
        held = (ahead - way * start > TIE * size) & (not point)
        place, lost = vanishing.lost(rests, surfaces) if way < 0 else (math.nan, math.nan)
        lost += vanishing.CLOSE / 2 * size
        gone = not held.any() and lost > end
        if held.any():
            end = way * min(way * end, float(ahead[held].min()))
        elif gone:
            end = lost
        one = cls(rests, way, (start, end), first, first, gone)
        last = first.copy()
        for i in () if point else (np.flatnonzero(~held) + axis).tolist():
            last[i] = one.beyond(i, rests.rooms(surfaces, way)[:, i, 1 - i], place)
        if not np.isfinite(last).all():
            return None
        last = cls(rests, way, (start, end), first, last, gone).at(np.array([end]))[0]
        passed = not axis and last[0] > last[1]
        return None if passed else cls(rests, way, (start, end), first, last, gone)

    def rest(self, x: Array, line: NDArray[np.int64]) -> Array:
        """D of left and right lines (0, 1) at x, just ahead of a corner."""
        side, profile = _SIDES[line], self.rests.profile
        ahead = profile.beside(x, side * self.way)
        return np.asarray(self.rests.rest(side, x, *ahead, None, self.way))

    def beyond(self, line: int, room: Array, place: float) -> float:
        """Where D of a line is beyond the end: no corner lies between. nan: nowhere."""
        x, side = float(self.first[line]), self.way * float(_SIDES[line])
        limit = float(room[1] if side > 0 else room[0])
        if side * (place - x) > 0:
            limit = side * min(side * limit, side * place)
        step, which = _FIRST * self.rests.length, np.array([line])
        while side * (limit - x) > 0:
            x = side * min(side * limit, side * x + step)
            if self.way * (float(self.rest(np.array([x]), which)[0]) - self.depths[1]) >= 0:
                return x
            step *= _GROWS
        return math.nan

    def at(self, depths: Array) -> Array:
        """The lines (k, 2) at depths on the way."""
        found = np.repeat(self.first[None], depths.size, axis=0)
        moves = np.flatnonzero(self.first != self.last)
        line, goal = np.repeat(moves, depths.size), np.tile(depths, moves.size)
        start, end = self.first[line], self.last[line]

        def off(x: Array, own: NDArray[np.int64]) -> Array:
            return self.rest(x, line[own]) - goal[own]

        span = self.depths[1] - self.depths[0]
        guess = start + (end - start) * ((goal - self.depths[0]) / span)
        rise = span / (end - start)
        x = crossings(off, np.minimum(start, end), np.maximum(start, end), guess, rise, 0.0)
        found[:, moves] = x.reshape(moves.size, depths.size).T
        return found

    def lines(self, depths: Array, *, roughly: bool = False) -> Array:
        """The free surfaces (k, 2, 2) of the contact at depths (k,) on the way.

        NotCertifiedError where lines do not rest there.
        """
        x = self.at(depths)
        found = np.full((depths.size, 2, 2), (-math.inf, math.inf))
        found[:, 0, 1], found[:, 1, 0] = x.T
        moves = np.flatnonzero(self.first != self.last)
        off = self.rest(x[:, moves].ravel(), np.tile(moves, depths.size)).reshape(x[:, moves].shape)
        ends = np.array(self.depths)
        noise = self.rests.noise(found)[:, moves]
        demand(off - depths[:, None], _size(self.rests, *self.depths), noise, ends)
        return found


def _size(rests: Rests, *depths: float) -> float:
    """Of these depths: the largest, and δ₀."""
    return max(map(abs, depths)) + rests.scene.opened.critical_separation
