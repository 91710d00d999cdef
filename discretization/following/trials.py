"""Free surfaces taken from one depth to another, and the first event on the way, enclosed.

Free surfaces do not feel each other, as u = d - f is prescribed in contact. So each is followed by
itself (smooth.py), and only those to which something happens are looked at closer. The depth of an
event is enclosed as close as depths are known. What runs out there is known in between: the least
clearance of a surface, the width of a contact, and how far its line is from a corner are all but
linear in the depth; where an equilibrium disappears, the line turns back, and the depth as a
function of its position is a smooth one that has an extreme value. So the next depth to try is
where that would be. Where that does not help it is the geometric mean of the last step and of what
is left, or the middle, as the event may be as near as that step, or far.
"""

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.motion import Motion
from discretization.fitted.rest_depths import TIE
from discretization.following.smooth import Piece, Smooth
from discretization.quadrature import Integrals
from energy.arrays import Array

_CLOSE = 1e-14  # of the size of depths: depths that close enclose an event, D is not known better
_FIRST = 1 / 4  # of the range of depths: how far is tried where nothing is known
_OFF = 1 / 8  # of what is left until something runs out, and of the range: it may be off by so much
_MOST = 400  # trials
_NEVER, _NOTHING = np.full((2, 1, 2), math.inf), np.full((1, 4), math.nan)  # turns or runs out


class Tried(NamedTuple):
    """Free surfaces (n, 2) at a depth.

    reserves (n, 4): what is left of both lines' ways, the clearance and the contact on the right;
    turns: places and depths (2, n, 2) at which lines would turn back; pieces: of the way there.
    failed: surfaces to which something happens; known: what is known to one of these, if any.
    """

    depth: float
    lines: Array
    reserves: Array = _NOTHING
    turns: Array = _NEVER
    pieces: tuple[Piece, ...] = ()
    failed: frozenset[int] = frozenset()
    known: bool = False


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

    def tried(self, low: Tried, which: set[int], end: float, sure: bool = True) -> Tried:
        """Some of the surfaces taken to a depth; sure: it is asked whether energies balance."""
        lines, kept, way = low.lines.copy(), sorted(which), 1 if end > low.depth else -1
        if low.depth == end or not kept:
            return low._replace(lines=lines, reserves=_NOTHING)
        start, turns = low.lines[kept], np.array(np.broadcast_to(low.turns, (2, *lines.shape)))
        piece, smooth = self.smooth.over(tuple(kept), start, low.depth, end, turns[:, kept])
        lines[kept] = self.motion.rests.snapped(piece.lines[:, -1, -1])
        lost = set(np.array(kept)[~smooth].tolist())
        reserves = np.full((len(lines), 4), math.nan)
        reserves[kept, :2] = self.motion.rests.reach(lines[kept], end, way)
        failed = self._touching(low, lines, which - lost, end, reserves) if way > 0 else set()
        failed |= self._ending(lines, which - lost - failed, end, reserves)
        turns[:], turns[:, kept] = math.inf, turning(piece.depths[0], piece.lines[:, 0])
        if sure and not (lost or failed):
            piece, smooth = self.smooth.balanced(piece, smooth)
            lost = set(np.array(kept)[~smooth].tolist())
        pieces = (*low.pieces, piece)
        return Tried(end, lines, reserves, turns, pieces, frozenset(lost | failed), bool(failed))

    def _touching(
        self, low: Tried, lines: Array, which: set[int], depth: float, reserves: Array
    ) -> set[int]:
        """Free surfaces that touch the profile or close as they are pressed."""
        surface, found = self.motion.free_part, set()
        for i in which:
            (q, p), (left, right) = low.lines[i].tolist(), lines[i].tolist()
            clear = surface.least((left, right), depth)[0] + TIE * self.motion.rests.size
            reserves[i, 2] = clear
            closed = clear < 0 or surface.search.closed(left, right, depth)
            if closed or surface.overtakes(q, p, (left, right), low.depth, depth):
                found.add(i)
        return found

    def _ending(self, lines: Array, which: set[int], depth: float, reserves: Array) -> set[int]:
        """Free surfaces beside contacts that close, are pulled or open."""
        found = set()
        for j in which & {i - 1 for i in which}:
            (before, left), (right, beyond) = lines[j : j + 2].tolist()
            reserves[j, 3] = right - left
            if left > right or self.motion.opens(left, right, (before, beyond), depth):
                found |= {j, j + 1}
        return found


@dataclass(eq=False)
class Enclosing:
    """An event between `low`, up to which nothing happens, and `high`, which fails.

    older: the trial before `low`; involved: the surfaces to which it happens; passed: whether
    nothing happened at the last trial; aim: the depth where something runs out, which may be `off`
    by so much; within: as far ahead the next aim may be after this trial; first: the share of the
    range that is tried as long as nothing has passed; sure: every trial asks if energies balance.
    """

    trials: Trials
    low: Tried
    high: Tried
    sure: bool = False
    passed: bool = False
    aim: float = math.nan
    off: float = math.nan
    within: float = math.inf

    def __post_init__(self) -> None:
        self.older, self.start, self.first = self.low, self.low.depth, _FIRST
        self.least = _CLOSE * self.trials.motion.rests.size
        self.involved = self._involved(self.high)

    def _involved(self, tried: Tried) -> set[int]:
        """Surfaces to which something happens; of retracted lines with those beyond a contact."""
        near = (0,) if tried.depth > self.start else (-1, 0, 1)
        return {i + j for i in tried.failed for j in near} & set(range(len(tried.lines)))

    def run(self) -> tuple[Tried, Tried, set[int]]:
        """The last depth before the first event, the first one beyond, and to what it happens.

        Or a depth to which nothing happens, or at which lines only come free, twice.
        """
        for _ in range(_MOST):
            low, width = self.low, self.high.depth - self.low.depth
            close = abs(width) <= self.least or low.depth + width / 2 == low.depth
            if close or not self.high.failed:
                return low, self.high, self.involved
            self._take(self.trials.tried(low, self.involved, self._next(width), self.sure))
        raise NotCertifiedError(
            f"the event near depth = {self.low.depth!r} is not enclosed; try other depths"
        )

    def _take(self, tried: Tried) -> None:
        """The range after a trial, and where something runs out by what is known now."""
        self.passed = not tried.failed
        if tried.failed:
            self.high, self.involved = tried, self.involved & self._involved(tried)
            self.first *= self.first
        else:
            self.older, self.low = self.low, tried
            if tried.depth == self.high.depth or self._released():
                self.high = tried
        last, self.aim = self.aim, runs_out(self.older, self.low, self.high)
        left, way = abs(self.aim - self.low.depth), abs(self.low.depth - self.older.depth)
        if self.passed and left > self.within:  # it was not there: all that is known is rounding
            self.aim, self.off = self.low.depth, 16 * way
        elif self.passed or self.aim != last:
            near = min(1.0, left / (way or left or 1.0))
            self.off = float(np.fmin(abs(self.aim - last), _OFF * left)) * near + self.least / 4
        else:
            self.off = 32 * self.off

    def _next(self, width: float) -> float:
        """The next depth to try: a little before what is aimed at, or beyond it if that is near."""
        low, high, self.within = self.low.depth, self.high.depth, math.inf
        if low == self.start:
            return low + math.copysign(max(abs(width) * self.first, self.least / 2), width)
        share, part = (self.aim - low) / width, self.off / abs(width)
        last = max(abs(low - self.older.depth), self.least)
        middle = low + width * min(0.5, math.sqrt(last / abs(width)))
        if not 0 <= share < 2:  # unknown, or far: from here nothing may happen
            return high if self.passed and not self.high.known else middle
        share, late = min(share, 1.0), share <= 2 * part
        found = low + width * (share + (2 * part if late else -part))
        if part > _OFF or not min(low, high) < found < max(low, high):
            return middle
        self.within = -math.inf if late else 8 * self.off
        return found

    def _released(self) -> bool:
        """Whether lines of these surfaces that were held on the way come free at its end."""
        way, rests = (1 if self.low.depth > self.older.depth else -1), self.trials.motion.rests
        lines, before = (tried.lines[sorted(self.involved)] for tried in (self.low, self.older))
        held = np.isfinite(lines) & (lines == before)
        left = way * (rests.ahead(lines, way) - self.low.depth)
        return bool((held & (left <= TIE * rests.size)).any())


def runs_out(older: Tried, low: Tried, high: Tried) -> float:
    """The first depth at which a line turns back, or something is used up; ±inf: not known.

    By the secant through `low` and the nearer of the other two.
    """
    ahead, behind = high.depth - low.depth, low.depth - older.depth
    room, other, before = low.reserves, high.reserves, older.reserves
    by_older = (before > room) & ((abs(behind) < abs(ahead)) | ~(other < 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        step = np.where(by_older, behind / (before - room), ahead / (room - other)) * room
    step = np.where((room > 0) & (by_older | (other < 0)), step, math.inf)
    found = np.append(low.turns[1] - low.depth, step)
    return low.depth + float(found[np.abs(found).argmin()])


def turning(depths: Array, lines: Array) -> Array:
    """The places and depths (2, n, 2) ahead at which lines (n, j, 2) at depths (j,) turn back.

    By the cubic d(x) through four of them; infinite where it has no extreme value ahead.
    """
    x = lines[:, 6::2]
    found = [np.broadcast_to(depths[6::2, None], x.shape)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for k in (1, 2, 3):  # divided differences
            found.append(np.diff(found[-1], axis=1) / (x[:, k:] - x[:, :-k]))
        (a, b, c), y, z = (each[:, -1] for each in found[1:]), x[:, 3] - x[:, 2], x[:, 3] - x[:, 1]
        slope, bend = a + y * (b + z * c), b + c * (y + z)  # at the last one
        step = -slope / (bend + np.copysign(np.sqrt(bend * bend - 3 * c * slope), bend))
        left = step * (slope + step * (bend + step * c))
        ahead = left * (depths[-1] - depths[0]) > 0
        return np.where(ahead, [x[:, 3] + step, depths[-1] + left], math.inf)
