"""The first depth on a way at which something other than smooth motion happens to the lines.

How far they move smoothly is found by trials.py, what they do there as for a state (motion.py).
"""

import functools
import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from discretization.fitted.alone import Alone
from discretization.fitted.free_part import Lines
from discretization.fitted.motion import Motion, free_parts
from discretization.fitted.rest_depths import TIE
from discretization.following.lone import LoneTrack
from discretization.following.smooth import Piece
from discretization.following.trials import Enclosing, Trials, Tried
from energy.arrays import Array

_AHEAD = (1e-10, 1e-12, 0.0)  # of the size of depths: how far beyond an event it is looked at


class Part(NamedTuple):
    """Smooth motion up to a depth: the lines there. after: beyond an event there.

    pieces, lone: the lines on the way.
    """

    depth: float
    lines: Lines
    after: Lines | None
    pieces: tuple[Piece, ...] = ()
    lone: LoneTrack | None = None


@dataclass(frozen=True, eq=False)
class Events:
    """Motion from event to event; alone: of a contact that stays so, closing (1) and opening.

    trials: what follows lines between events.
    """

    motion: Motion
    alone: dict[int, Alone] = field(default_factory=dict)
    trials = functools.cached_property(lambda self: Trials(self.motion))

    def part(self, lines: Lines, start: float, end: float) -> Part:
        """Smooth motion of all lines as far as it goes."""
        alone = self.alone.get(1 if end >= start else -1)
        if alone and len(lines) == 2 and (way := LoneTrack.of(alone, lines, start, end)):
            there = (0.0, *way.last.tolist())[-2:]
            return Part(way.end, there, None if way.end == end else (), lone=way)
        trials, begin = self.trials, Tried(start, np.array(free_parts(lines)))
        everything = set(range(len(begin.lines)))
        found = trials.tried(begin, everything, end)
        if not found.failed:
            return Part(end, _flat(found.lines), None, found.pieces)
        for sure in (False, True):  # energies are asked once, at the end, if they balance
            low, high, own = Enclosing(trials, begin, found, sure).run()
            pieces, balanced = trials.smooth.whole(low.pieces, own)
            if balanced:
                break
        found = trials.tried(begin, everything - own, low.depth)
        if found.failed:  # by a shorter way than the others
            return self.part(lines, start, (start + low.depth) / 2)
        found.lines[sorted(own)] = low.lines[sorted(own)]
        part = Part(high.depth, _flat(found.lines), None, (*pieces, *found.pieces))
        return self._beyond(part, own, low.depth, end) if high.failed else part

    def _beyond(self, part: Part, failed: set[int], low: float, end: float) -> Part:
        """What the lines do at an event, or where they only come free.

        A line that does not rest is hardly told from one that does next to where an equilibrium
        disappears. So what they do is found a little further on, and followed back to the event.
        """
        way, size = math.copysign(1.0, end - low), self.motion.rests.size
        surfaces, moved = np.array(free_parts(part.lines)), set(failed)
        behind = self.motion.rests.ahead(surfaces, int(way)) - part.depth
        with np.errstate(invalid="ignore"):
            late = np.isfinite(surfaces) & (way * behind < -TIE * size)
        moved |= set(np.flatnonzero(late.any(axis=1)).tolist())  # all at once by symmetry
        still = frozenset(pair for i, pair in enumerate(free_parts(part.lines)) if i not in moved)
        for ahead in _AHEAD[int(self.motion.scene.hysteretic) :]:  # there is no way back then
            depth = part.depth + way * min(ahead * size, abs(end - part.depth))
            if way > 0:
                after = self.motion.pressed(part.lines, low, depth, still)
            else:
                after = self.motion.relaxed(part.lines, depth, still)
            there, smooth = np.array(free_parts(after)), self.trials.smooth
            new = ~(there[:, None] == surfaces).all(axis=2).any(axis=1)
            back, good = smooth.balanced(*smooth.over((), there[new], depth, part.depth))
            if good.all():
                there[new] = self.motion.rests.snapped(back.lines[:, -1, -1])
                found = _flat(there)
                gaps, least = there[new].tolist(), self.motion.free_part.least
                clear = min((least(gap, part.depth, exact=True)[0] for gap in gaps), default=0.0)
                if clear >= -2 * TIE * size and found == self.motion.unpulled(found, part.depth):
                    return part._replace(after=found)  # nothing else has happened on the way back
        return part._replace(after=after)


def _flat(surfaces: Array) -> Lines:
    """The lines of all free surfaces; where those of a contact have passed each other, between."""
    lines = surfaces.ravel()[1:-1].reshape(-1, 2)
    passed = lines[:, 0] > lines[:, 1]
    lines = np.where(passed[:, None], lines.mean(axis=1, keepdims=True), lines)
    return tuple(lines.ravel().tolist())
