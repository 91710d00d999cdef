"""Free surfaces taken from one depth to another: do they move smoothly, and up to where.

Free surfaces do not feel each other, as u = d - f is prescribed in contact. So each is followed by
itself (smooth.py), and only those to which something happens are looked at closer: the event is
enclosed between a depth up to which they move smoothly and one up to which they do not, as close as
depths of rest are known.

What runs out at an event is known in between, and all but linear in the depth: the square of the
stiffness against moving the lines of a surface, its least clearance, the width of a contact. So the
next depth to try is where it would be zero; one in the middle, where that does not halve the range.
Where an equilibrium disappears is solved for (rests.py), and only tried on either side.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.fitted.integrals import Integrals
from discretization.fitted.motion import Motion
from discretization.fitted.resting import Pair
from discretization.fitted.rests import TIE
from discretization.fitted.smooth import DEGREE, Smooth
from discretization.fitted.track import Piece, pieces, restricted
from discretization.surfaces.spectral import coefficients

Array = NDArray[np.float64]
Rooms = dict[tuple[str, int], float]
_CLOSE = 1e-14  # of the size of depths: depths that close enclose an event, D is not known better
_WORTH = 1 / 8  # of the range of depths: an aim that may be off by more is not worth a trial
_MOST = 400  # trials: with the next rule three times as many as halvings of a double
_PARTS = (4, 16)  # of a way
_MEETS = 1e-9  # of the way: where polynomials say that lines meet
_REAL = 1e-9  # imaginary parts of their zeros that are rounding
_FOLDS = 4  # times that an equilibrium is looked for that disappears
_PATIENCE = 3  # trials after which the range must have been halved, else its middle is tried


class Tried(NamedTuple):
    """Surfaces taken to a depth: their lines, what is left; surfaces that fail.

    known: something is known to happen to one of these; else shorter ways may succeed. aim: the
    depth at which lines meet, as the polynomials of their motion tell; nan: not known. pieces: the
    lines on the way.
    """

    depth: float
    lines: Array
    rooms: Rooms
    failed: set[int]
    known: bool
    aim: float = math.nan
    pieces: tuple[Piece, ...] = ()

    @property
    def lost(self) -> bool:
        """Whether lines were not found at rest: more parts would not help."""
        return any(math.isnan(self.rooms["stiff", i]) for i in self.failed)

    def after(self, low: Tried) -> Tried:
        """The same with what led to where it began."""
        return self._replace(pieces=low.pieces + self.pieces)


@dataclass(frozen=True, eq=False)
class Trials:
    """Free surfaces taken to other depths."""

    motion: Motion

    @functools.cached_property
    def smooth(self) -> Smooth:
        """What follows lines between events."""
        rests = self.motion.rests
        level = rests.size + max(rests.size, rests.profile.touch)
        return Smooth(rests, Integrals.of(rests.scene, rests.profile, level))

    def tried(
        self, surfaces: Array, which: set[int], start: float, end: float, parts: int = 1
    ) -> Tried:
        """Surfaces taken to a depth, and what is left for each."""
        lines, kept = surfaces.copy(), sorted(which)
        found = self.smooth.over(surfaces[kept], start, end, parts)
        lines[kept] = found.lines
        failed = {i for i, good in zip(kept, found.smooth.tolist(), strict=True) if not good}
        unknown = set(failed)
        reach = self.motion.rests.reach(found.lines, end, 1 if end > start else -1)
        rooms: Rooms = {}
        for i, margin, (q, p) in zip(kept, found.margin.tolist(), reach.tolist(), strict=True):
            rooms["stiff", i], rooms["left", i], rooms["right", i] = margin, q, p
        if end > start:
            self._pressed(surfaces, lines, set(kept) - failed, (start, end), rooms, failed)
        self._contacts(lines, which, end, rooms, failed)
        way = pieces(kept, found.depths, found.whole)
        aim = _meeting(kept, lines, found.depths, found.whole) if failed != unknown else math.nan
        return Tried(end, lines, rooms, failed, failed != unknown, aim, way)

    def _pressed(
        self,
        old: Array,
        new: Array,
        which: set[int],
        depths: Pair,
        rooms: Rooms,
        failed: set[int],
    ) -> None:
        """What free surfaces touch as they are pressed."""
        surface, size = self.motion.surface, self.motion.rests.size
        for i in which:
            q, p, moved = float(old[i, 0]), float(old[i, 1]), (float(new[i, 0]), float(new[i, 1]))
            least, _ = surface.least(moved, depths[1])
            rooms["clear", i] = least + TIE * size
            closes = self.motion.resting.closed(*moved, depths[1])
            if closes or least < -TIE * size or surface.overtakes(q, p, moved, *depths):
                failed.add(i)

    def _contacts(
        self, lines: Array, which: set[int], depth: float, rooms: Rooms, failed: set[int]
    ) -> None:
        """Contacts that close, are pulled or open."""
        for j in range(len(lines) - 1):
            if not {j, j + 1} <= which or {j, j + 1} & failed:
                continue
            left, right = float(lines[j, 1]), float(lines[j + 1, 0])
            rooms["width", j] = right - left
            beside = float(lines[j, 0]), float(lines[j + 1, 1])
            if left > right or self.motion.opens(left, right, beside, depth):
                failed |= {j, j + 1}

    def to(self, surfaces: Array, which: set[int], start: float, end: float) -> Tried:
        """Surfaces taken to a depth, in parts if need be."""
        if start == end or not which:
            return unmoved(surfaces, start)
        found = self.tried(surfaces, which, start, end)
        return self._in_parts(unmoved(surfaces, start), found, which)

    def _in_parts(self, low: Tried, high: Tried, which: set[int]) -> Tried:
        """Surfaces tried again in more parts where nothing is known to happen to those that fail.

        Where a line passes a jump of a higher derivative of f, ∫P dd only converges on short ones.
        """
        for parts in _PARTS:
            if high.failed and not high.known and not high.lost:
                high = self.tried(low.lines, which, low.depth, high.depth, parts)
        return high

    def enclosed(self, low: Tried, high: Tried, start: float) -> tuple[Tried, Tried, set[int]]:
        """The last depth before the first event, the first one beyond, and to what it happens.

        Or a depth to which nothing happens, twice.
        """
        involved, parts, passed = self._involved(high, start), 1, False
        low = older = low._replace(rooms=low.rooms or self._rooms(low, involved, high.depth))
        least = _CLOSE * self.motion.rests.size
        aim, away, widths = math.nan, math.inf, [math.inf] * _PATIENCE
        tries, fresh = _FOLDS, True
        for _ in range(_MOST):
            width = high.depth - low.depth
            if high.failed and not high.known and abs(width) > least and tries and fresh:
                tries, fresh = tries - 1, False
                low, high = self._beside_fold(low, high, involved)
                width = high.depth - low.depth
            if parts == 1 and not high.known and abs(width) > least:
                high, parts = self._in_parts(low, high, involved), _PARTS[0]
                high = high if high.failed else high.after(low)
            if not high.failed or abs(width) <= least or low.depth + width / 2 == low.depth:
                break
            last, aim = (aim, away), _runs_out(older, low, high)
            meets = high.aim == high.aim
            if meets:
                aim, last = high.aim, (high.aim * (1 + _MEETS), math.inf)
                high = high._replace(aim=math.nan)
            away = abs(aim - low.depth)
            off = abs(aim - last[0]) * min(1.0, away / (last[1] or away or 1.0)) + least / 4
            widths.append(abs(width))
            closing = away < last[1] / 8
            slow = widths[-1] > widths[-1 - _PATIENCE] / 2 and not closing
            depth = low.depth + width / 2 if slow else _next(low, high, aim, off)
            if passed and not high.known and not 0 < (aim - low.depth) / width < 1:
                depth = high.depth  # from here nothing may happen
            tried = self.tried(low.lines, involved, low.depth, depth, parts)
            if meets:
                tried = self._in_parts(low, tried, involved)
            passed = not tried.failed
            if not passed:
                high, involved = tried, self._involved(tried, start) & involved
                continue
            older, low, fresh = low, tried.after(low), True
            if self._released(older, low, sorted(involved)):
                return low, low, involved
            high = low if depth == high.depth else high
        else:
            raise NotCertifiedError(
                f"the event near depth = {low.depth!r} is not enclosed; try other depths"
            )
        return (low if high.failed else high), high, involved

    def _released(self, before: Tried, after: Tried, which: list[int]) -> bool:
        """Whether lines of these surfaces that were held on the way come free at its end."""
        way, size = (1 if after.depth > before.depth else -1), self.motion.rests.size
        lines = after.lines[which]
        held = np.isfinite(lines) & (lines == before.lines[which])
        if not held.any():
            return False
        left = way * (self.motion.rests.ahead(lines, way) - after.depth)
        return bool((held & (left <= TIE * size)).any())

    def _beside_fold(self, low: Tried, high: Tried, which: set[int]) -> tuple[Tried, Tried]:
        """Just before and beyond where an equilibrium disappears, if that is found; else these."""
        start, least = low.depth, _CLOSE * self.motion.rests.size
        way = 1 if high.depth > start else -1
        lost = [i for i in sorted(high.failed) if math.isnan(high.rooms["stiff", i])]
        folds = [self.motion.rests.fold(low.lines[i], way) for i in lost]
        steps = (way * (fold - start) for fold in folds)
        ahead = [step for step in steps if -least < step < abs(high.depth - start)]
        if not ahead:
            return low, high
        step, before = max(min(ahead), 0.0), low
        if step > least / 2:
            before = self.to(low.lines, which, start, start + way * (step - least / 2))
            if before.failed:  # something else happens before that
                return low, before
            before = before.after(low)
        beyond = start + way * (step + least / 2)
        tried = self.tried(before.lines, which, before.depth, beyond)
        return before, tried if tried.failed else high

    def _rooms(self, low: Tried, which: set[int], end: float) -> Rooms:
        """What is left at first for free surfaces and contacts."""
        rooms: Rooms = {}
        if end > low.depth:
            self._pressed(low.lines, low.lines, which, (low.depth, low.depth), rooms, set())
        self._contacts(low.lines, which, low.depth, rooms, set())
        return rooms

    def _involved(self, tried: Tried, start: float) -> set[int]:
        """Surfaces to which something happens; of retracted lines with those beyond a contact."""
        if tried.depth > start:
            return tried.failed
        near = {i + j for i in tried.failed for j in (-1, 0, 1)}
        return {i for i in near if 0 <= i < len(tried.lines)}


def _meeting(kept: list[int], lines: Array, depths: Array, whole: Array) -> float:
    """The first depth at which the lines of a contact meet on a smooth way; nan: none do.

    depths (p, j), whole (n, p * j, 2): of the points of the parts of that way.
    """
    found = [math.nan]
    for k, i in enumerate(kept[:-1]):
        if kept[k + 1] != i + 1 or not lines[i, 1] > lines[i + 1, 0]:
            continue
        width = (whole[k + 1, :, 0] - whole[k, :, 1]).reshape(depths.shape)
        part = int(np.argmax(width[:, -1] < 0))
        turns = Legendre(coefficients(DEGREE, width[part])).roots()
        real = turns.real[(np.abs(turns.imag) <= _REAL) & (np.abs(turns.real) <= 1)]
        if real.size:
            start, end = depths[part, [0, -1]].tolist()
            left = (1 - float(real.min())) / 2
            found.append(end - (end - start) * left * left)
    return min(found, key=lambda depth: abs(depth - depths[0, 0]) if depth == depth else math.inf)


def unmoved(surfaces: Array, depth: float) -> Tried:
    """Surfaces where they are."""
    return Tried(depth, surfaces.copy(), {}, set(), False)


def merge(one: Tried, own: set[int], other: Tried) -> Tried:
    """Put the lines of some surfaces in place of those of another trial."""
    kept = sorted(own)
    other.lines[kept] = one.lines[kept]
    return other._replace(pieces=other.pieces + restricted(one.pieces, own))


def _runs_out(older: Tried, low: Tried, high: Tried) -> float:
    """The first depth at which something is used up, if it changes linearly; nan: not known.

    By the secant through `low` and the nearer of the other two.
    """
    found = [math.nan]
    for key, room in low.rooms.items():
        other, before = high.rooms.get(key, math.nan), older.rooms.get(key, math.nan)
        ahead, behind = high.depth - low.depth, low.depth - older.depth
        closer = abs(behind) < abs(ahead) or not other < 0
        if before > room > 0 and closer:
            found.append(behind * room / (before - room))
        elif other < 0 < room:
            found.append(ahead * room / (room - other))
    return low.depth + min(found, key=lambda step: math.inf if math.isnan(step) else abs(step))


def _next(low: Tried, high: Tried, aim: float, off: float) -> float:
    """The next depth to try: a little before what is aimed at, or if that is near, beyond it.

    off: how far the aim may be off. The middle, where neither encloses the event much closer.
    """
    width, middle = high.depth - low.depth, (low.depth + high.depth) / 2
    share, part = (aim - low.depth) / width, off / abs(width)
    if not (-part < share < 1 and part < _WORTH):  # nan: not known
        return middle
    depth = low.depth + width * (share - part if share > 2 * part else share + 2 * part)
    inside = min(low.depth, high.depth) < depth < max(low.depth, high.depth)
    return depth if inside else middle
