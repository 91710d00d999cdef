"""The event on a way of free surfaces, enclosed between two depths as close as those are known.

What runs out at an event is known in between, and all but linear in the depth: the square of the
stiffness against moving the lines of a surface, its least clearance, the width of a contact. So the
next depth to try is where it would be zero; one in the middle, where that does not halve the range.
Where an equilibrium disappears, and where the lines of a contact meet, is solved for (vanishing.py)
and only tried on either side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.rests import TIE
from discretization.following import vanishing
from discretization.following.trials import Trials, Tried

_WORTH = 1 / 8  # of the range of depths: an aim that may be off by more is not worth a trial
_MOST = 400  # trials: with the next rule three times as many as halvings of a double
_FOLDS = 4  # times that an equilibrium is looked for that disappears
_FASTEST = 3  # halvings of the range at once, where nothing was found again and again
_PATIENCE = 3  # trials after which the range must have been halved, else its middle is tried


@dataclass(eq=False)
class Enclosing:
    """An event between `low`, up to which nothing happens, and `high`, which fails.

    start: where the way began; older: the trial before `low`; involved: the surfaces to which it
    happens; aim, away: the depth where something runs out, and how far
    that was from `low`; widths: of the ranges so far; folds: times that an equilibrium may yet be
    looked for that disappears, fresh: whether `low` is new since the last time.
    """

    trials: Trials
    low: Tried
    high: Tried
    start: float
    passed: bool = False
    passes: int = 0
    aim: float = math.nan
    away: float = math.inf
    folds: int = _FOLDS
    fresh: bool = True
    widths: list[float] = field(default_factory=lambda: [math.inf] * _PATIENCE)

    def __post_init__(self) -> None:
        self.involved = self.trials.involved(self.high, self.start)
        rooms = self.low.rooms or self.trials.rooms(self.low, self.involved, self.high.depth)
        self.low = self.older = self.low._replace(rooms=rooms)

    @property
    def width(self) -> float:
        """Of the range of depths."""
        return self.high.depth - self.low.depth

    @property
    def least(self) -> float:
        """How close depths are known."""
        return vanishing.CLOSE * self.trials.motion.rests.size

    @property
    def done(self) -> bool:
        """Whether the depths are as close as they are known, or nothing happens."""
        low, width = self.low.depth, self.width
        return not self.high.failed or abs(width) <= self.least or low + width / 2 == low

    def run(self) -> tuple[Tried, Tried, set[int]]:
        """The last depth before the first event, the first one beyond, and to what it happens.

        Or a depth to which nothing happens, twice.
        """
        for _ in range(_MOST):
            self._solve()
            if self.done:
                return (self.low if self.high.failed else self.high), self.high, self.involved
            low, which = self.low, self.involved
            if self._take(self.trials.tried(low.lines, which, low.depth, self._next())):
                return self.low, self.low, self.involved
        raise NotCertifiedError(
            f"the event near depth = {self.low.depth!r} is not enclosed; try other depths"
        )

    def _solve(self) -> None:
        """Look for an equilibrium that disappears, or a contact that closes."""
        if self.high.failed and abs(self.width) > self.least and self.folds and self.fresh:
            self.folds, self.fresh = self.folds - 1, False
            self.low, self.high = self._beside(self.low, self.high, self.involved)

    def _next(self) -> float:
        """The next depth to try."""
        low, high, width = self.low, self.high, self.width
        last, self.aim = (self.aim, self.away), _runs_out(self.older, low, high)
        self.away = abs(self.aim - low.depth)
        off = abs(self.aim - last[0]) * min(1.0, self.away / (last[1] or self.away or 1.0))
        self.widths.append(abs(width))
        closing = self.away < last[1] / 8
        slow = self.widths[-1] > self.widths[-1 - _PATIENCE] / 2 and not closing
        if self.passed and not high.known and not 0 < (self.aim - low.depth) / width < 1:
            return high.depth  # from here nothing may happen
        middle = low.depth + width * (1 - 0.5 ** min(1 + self.passes, _FASTEST))
        if slow:
            return middle
        return _towards(low, high, self.aim, off + self.least / 4, middle)

    def _take(self, tried: Tried) -> bool:
        """The range after a trial; whether lines only come free at its lower end."""
        self.passed = not tried.failed
        self.passes = self.passes + 1 if self.passed else 0
        if not self.passed:
            self.high = tried
            self.involved = self.trials.involved(tried, self.start) & self.involved
            return False
        self.older, self.low, self.fresh = self.low, tried.after(self.low), True
        if self._released(self.older, self.low, sorted(self.involved)):
            return True
        if tried.depth == self.high.depth:
            self.high = self.low
        return False

    def _released(self, before: Tried, after: Tried, which: list[int]) -> bool:
        """Whether lines of these surfaces that were held on the way come free at its end."""
        way, size = (1 if after.depth > before.depth else -1), self.trials.motion.rests.size
        lines = after.lines[which]
        held = np.isfinite(lines) & (lines == before.lines[which])
        if not held.any():
            return False
        left = way * (self.trials.motion.rests.ahead(lines, way) - after.depth)
        return bool((held & (left <= TIE * size)).any())

    def _solved(self, low: Tried, high: Tried, which: set[int]) -> list[float]:
        """Depths where an equilibrium disappears or a contact closes; nan: not found."""
        way, rests = (1 if high.depth > low.depth else -1), self.trials.motion.rests
        lost = [i for i in sorted(high.failed) if math.isnan(high.rooms["stiff", i])]
        found = [vanishing.fold(rests, low.lines[i], way) for i in lost]
        if way < 0:
            both = [i for i in sorted(which) if i + 1 in which]
            found += [vanishing.closing(rests, low.lines[i : i + 2])[1] for i in both]
        return found

    def _beside(self, low: Tried, high: Tried, which: set[int]) -> tuple[Tried, Tried]:
        """Just before and beyond the first event whose depth is solved for; else these."""
        start, least = low.depth, self.least
        way = 1 if high.depth > start else -1
        steps = (way * (depth - start) for depth in self._solved(low, high, which))
        ahead = [step for step in steps if -least < step < abs(high.depth - start)]
        if not ahead:
            return low, high
        step, before = max(min(ahead), 0.0), low
        if step > least / 2:
            before = self.trials.to(low.lines, which, start, start + way * (step - least / 2))
            if before.failed:  # something else happens before that
                return low, before
            before = before.after(low)
        beyond = start + way * (step + least / 2)
        tried = self.trials.tried(before.lines, which, before.depth, beyond)
        return before, tried if tried.failed else high


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


def _towards(low: Tried, high: Tried, aim: float, off: float, middle: float) -> float:
    """The next depth to try: a little before what is aimed at, or if that is near, beyond it.

    off: how far the aim may be off. The middle, where neither encloses the event much closer.
    """
    width = high.depth - low.depth
    share, part = (aim - low.depth) / width, off / abs(width)
    if not (-part < share < 1 and part < _WORTH):  # nan: not known
        return middle
    depth = low.depth + width * (share - part if share > 2 * part else share + 2 * part)
    inside = min(low.depth, high.depth) < depth < max(low.depth, high.depth)
    return depth if inside else middle
