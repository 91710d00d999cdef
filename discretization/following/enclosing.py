"""The event on a way of free surfaces, enclosed between two depths as close as those are known.

What runs out at an event is known in between, and all but linear in the depth: the square of the
stiffness against moving the lines of a surface, its least clearance, the width of a contact. So the
next depth to try is where it would be zero; one in the middle, where that does not halve the range.
Where an equilibrium disappears is solved for and only tried on either side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.fitted.rests import TIE, Rests
from discretization.following.trials import Trials, Tried

Array = NDArray[np.float64]
_CLOSE = 1e-14  # of the size of depths: depths that close enclose an event, D is not known better
_WORTH = 1 / 8  # of the range of depths: an aim that may be off by more is not worth a trial
_MOST = 400  # trials: with the next rule three times as many as halvings of a double
_PATIENCE = 3  # trials after which the range must have been halved, else its middle is tried
_FOLDS = 4  # times that an equilibrium is looked for that disappears
_CURVED = 1e-4  # of the room between two lines, or of l, for the change of the stiffness
_NEAR = 1e-4  # of that: the depth of a fold is good to the square of its place
_FOLDED = 12  # steps of Newton's method to a fold


@dataclass(eq=False)
class Enclosing:
    """An event between `low`, up to which nothing happens, and `high`, which fails.

    start: where the way began; older: the trial before `low`; involved: the surfaces to which it
    happens; passed: whether nothing happened at the last trial; aim: the depth where something runs
    out; widths: of the ranges so far; folds: times that an equilibrium may yet be looked for that
    disappears, fresh: whether `low` is new since.
    """

    trials: Trials
    low: Tried
    high: Tried
    start: float
    passed: bool = False
    aim: float = math.nan
    folds: int = _FOLDS
    fresh: bool = True
    widths: list[float] = field(default_factory=lambda: [math.inf] * _PATIENCE)

    def __post_init__(self) -> None:
        self.involved = self.trials.involved(self.high, self.start)
        self.older = self.low

    @property
    def width(self) -> float:
        """Of the range of depths."""
        return self.high.depth - self.low.depth

    @property
    def least(self) -> float:
        """How close depths are known."""
        return _CLOSE * self.trials.motion.rests.size

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
            if not self.done and self.folds and self.fresh:
                self.folds, self.fresh = self.folds - 1, False
                self._beside()
            if self.done:
                return (self.low if self.high.failed else self.high), self.high, self.involved
            low, which = self.low, self.involved
            if self._take(self.trials.tried(low.lines, which, low.depth, self._next())):
                return self.low, self.low, self.involved
        raise NotCertifiedError(
            f"the event near depth = {self.low.depth!r} is not enclosed; try other depths"
        )

    def _next(self) -> float:
        """The next depth to try: a little before what is aimed at, or if that is near, beyond it.

        The middle, where neither encloses the event much closer, or that has not helped so far.
        """
        low, high, width = self.low, self.high, self.width
        last, self.aim = self.aim, _runs_out(self.older, low, high)
        self.widths.append(abs(width))
        share = (self.aim - low.depth) / width
        if self.passed and not high.known and not 0 < share < 1:
            return high.depth  # from here nothing may happen
        part = (abs(self.aim - last) + self.least / 4) / abs(width)
        near = -part < share < 1 and part < _WORTH  # not of nan
        if not near or self.widths[-1] > self.widths[-1 - _PATIENCE] / 2:
            return low.depth + width / 2
        depth = low.depth + width * (share - part if share > 2 * part else share + 2 * part)
        inside = min(low.depth, high.depth) < depth < max(low.depth, high.depth)
        return depth if inside else low.depth + width / 2

    def _take(self, tried: Tried) -> bool:
        """The range after a trial; whether lines only come free at its lower end."""
        self.passed = not tried.failed
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

    def _beside(self) -> None:
        """The range just about the first depth where an equilibrium disappears, if it is found."""
        start, least, which = self.low.depth, self.least, self.involved
        way, stiff = (1 if self.width > 0 else -1), self.high.rooms
        lost = (self.low.lines[i] for i in self.high.failed if math.isnan(stiff["stiff", i]))
        steps = (way * (fold(self.trials.motion.rests, each, way) - start) for each in lost)
        ahead = [step for step in steps if -least < step < abs(self.width)]
        if not ahead:
            return
        step = max(min(ahead), 0.0)
        if step > least / 2:
            before = self.trials.to(self.low.lines, which, start, start + way * (step - least / 2))
            if before.failed:  # something else happens before that
                self.high = before
                return
            self.low = before.after(self.low)
        beyond = start + way * (step + least / 2)
        tried = self.trials.tried(self.low.lines, which, self.low.depth, beyond)
        self.high = tried if tried.failed else self.high


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


def fold(rests: Rests, lines: Array, way: int) -> float:
    """The depth at which the equilibrium of these lines (2,) disappears ahead; nan: not found.

    There both rest at one depth, and the stiffness against moving them is zero: Newton's
    method for both, from lines not far from there. The depth is good to the square of the step.
    """
    x, inner = lines.copy(), np.isfinite(lines)
    room = rests.rooms(lines[None], way)
    h, near = _CURVED * min(float(x[1] - x[0]), rests.length), False
    for _ in range(_FOLDED):
        step, depth = _step(rests, x, room, h, way)
        if near:
            return depth
        x[inner] -= step
        if not ((room[0, 0] <= x) & (x <= room[1, 0]))[inner].all() or not x[0] < x[1]:
            break
        near = bool(np.abs(step).max() <= _NEAR * h)
    return math.nan


def _step(rests: Rests, x: Array, room: Array, h: float, way: int) -> tuple[Array, float]:
    """A step of Newton's method towards a fold (1 or 2,), nan: none, and D of the lines."""
    inner, beside = np.isfinite(x), h * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    value, rates = rests.rest_depths((x + beside)[:, None], np.repeat(room, 3, axis=1), way, True)
    assert rates is not None
    rate = rates[:, 0]
    if inner.all():
        stiff = rate[:, 0, 0] * rate[:, 1, 1] - rate[:, 0, 1] * rate[:, 1, 0]
        off = np.array([value[0, 0, 0] - value[0, 0, 1], stiff[0]])
        matrix = np.array([rate[0, 0] - rate[0, 1], (stiff[1:] - stiff[0]) / h])
    else:
        own = int(inner[1])
        stiff = rate[:, own, own]
        off, matrix = stiff[:1], (stiff[[[1 + own]]] - stiff[0]) / h
    with np.errstate(all="ignore"):
        solvable = np.isfinite(matrix).all() and np.linalg.det(matrix) != 0
    depth = float(value[0, 0][inner].mean())
    return np.linalg.solve(matrix, off) if solvable else np.full(off.size, math.nan), depth
