"""The first depth on a way at which something other than smooth motion happens to the lines.

Free surfaces do not feel each other, as u = d - f is prescribed in contact. So each is followed by
itself (smooth.py), and only those to which something happens are looked at closer: the event is
enclosed between a depth up to which they move smoothly and one up to which they do not, until
these are neighbouring numbers. What the lines do there is found as for a state (motion.py).

What runs out at an event is known in between, and all but linear in the depth: the square of the
stiffness against moving the lines of a surface, its least clearance, the width of a contact. So the
next depth to try is where it would be zero; one in the middle, where that does not halve the range.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.fitted.integrals import Integrals
from discretization.fitted.motion import Motion, free
from discretization.fitted.pressed import Lines
from discretization.fitted.resting import TIE, Pair
from discretization.fitted.smooth import Smooth

Array = NDArray[np.float64]
Rooms = dict[tuple[str, int], float]
_CLOSE = 4e-16  # of the size of depths: depths that close enclose an event
_SHORT = 1e-6  # of l: where an equilibrium disappears within rounding a line is that far from it
_WORTH = 1 / 8  # of the range of depths: an aim that may be off by more is not worth a trial
_AHEAD = 1e-9  # of the size of depths: beyond an event lines that go on smoothly do so that far
_MOST = 400  # trials: with the next rule three times as many as halvings of a double
_PATIENCE = 3  # trials after which the range must have been halved, else its middle is tried
_CREEPS = 1e-12  # of the size of depths: a part that short is one of a line that comes free by
_CREEPING = 20  # roundings, and after so many in a row it is not followed any further
_PARTS = 10_000  # places on one way at which lines only come free


class Part(NamedTuple):
    """Smooth motion up to a depth: the lines there, and ∫P dd. after: beyond an event there."""

    depth: float
    lines: Lines
    work: float
    after: Lines | None


class _Tried(NamedTuple):
    """Surfaces taken to a depth: their lines, ∫P dd of each, what is left; surfaces that fail."""

    depth: float
    lines: Array
    work: Array
    rooms: Rooms
    failed: set[int]


@dataclass(frozen=True, eq=False)
class Events:
    """Motion from event to event."""

    motion: Motion

    @functools.cached_property
    def smooth(self) -> Smooth:
        """What follows lines between events."""
        resting = self.motion.resting
        level = resting.size + max(resting.size, self.motion.profile.touch)
        return Smooth(resting, Integrals.of(resting.scene, resting.profile, level))

    def next(self, lines: Lines, start: float, end: float) -> Part:
        """To the first event on the way from one depth to another, or to its end."""
        work, creeping = 0.0, 0
        for _ in range(_PARTS):
            part = self._part(lines, start, end)
            work += part.work
            slow = abs(part.depth - start) <= _CREEPS * self.motion.resting.size
            creeping = creeping + 1 if slow else 0
            if creeping > _CREEPING:
                break
            if part.after is not None and self._happens(part.lines, part.after):
                return part._replace(work=work)
            lines, start = part.lines if part.after is None else part.after, part.depth
            if start == end:
                return Part(end, lines, work, None)
        raise NotCertifiedError(f"the contacts at depth = {start!r} do not come to rest")

    def _happens(self, before: Lines, after: Lines) -> bool:
        """Whether lines have jumped, and not only come free."""
        if len(before) != len(after):
            return True
        apart = np.abs(np.subtract(before, after)).max(initial=0.0)
        return bool(apart > _SHORT * self.motion.scene.elastocapillary_length)

    def _part(self, lines: Lines, start: float, end: float) -> Part:
        """Smooth motion of all lines as far as it goes."""
        surfaces = np.array(free(lines))
        everything = set(range(len(surfaces)))
        whole = self._tried(surfaces, everything, start, end)
        if not whole.failed:
            return Part(end, _flat(whole.lines), float(whole.work.sum()), None)
        low, high, failed = self._enclosed(surfaces, whole, start)
        others = everything - failed
        rest = self._tried(surfaces, others, start, low.depth) if low.depth != start else None
        if rest is not None and rest.failed:
            return self._part(lines, start, (start + low.depth) / 2)
        before, work = low.lines.copy(), float(low.work[sorted(failed)].sum())
        if rest is not None:
            kept = sorted(others)
            before[kept], work = rest.lines[kept], work + float(rest.work[kept].sum())
        return self._beyond(Part(high, _flat(before), work, None), failed, low.depth, end)

    def _beyond(self, part: Part, failed: set[int], low: float, end: float) -> Part:
        """What the lines do at an event, or where they only come free.

        Lines count as resting by TIE longer than they do: where none jumps, and they do not go on
        smoothly either, the depth is taken further by growing steps.
        """
        way, size = math.copysign(1.0, end - low), self.motion.resting.size
        depth, step = part.depth, _CLOSE * size
        after = self._after(part.lines, failed, low, depth)
        while not self._happens(part.lines, after) and step < _AHEAD * size:
            ahead = depth + way * min(_AHEAD * size, abs(end - depth))
            if not self._tried(np.array(free(after)), failed, depth, ahead).failed:
                break
            step *= 4
            depth += way * min(step, abs(end - depth))
            after = self._after(part.lines, failed, low, depth)
        back = self.smooth.over(np.array(free(after)), depth, part.depth)
        return part._replace(after=_flat(back.lines) if back.smooth.all() else after)

    def _after(self, lines: Lines, failed: set[int], low: float, high: float) -> Lines:
        """What the lines do at an event."""
        motion = self.motion
        if high < low:
            return motion.retracted(lines, high)
        surfaces = np.array(free(lines))
        behind = self.smooth.drives.ahead(surfaces, 1) < high - TIE * motion.resting.size
        moved = failed | set(np.flatnonzero(behind.any(axis=1)).tolist())  # all at once by symmetry
        parts: list[float] = []
        for i, (q, p) in enumerate(surfaces.tolist()):
            parts += motion.surface.lines(q, p, low, high) if i in moved else (q, p)
        return motion.relaxed(tuple(parts[1:-1]), high)

    def _enclosed(
        self, surfaces: Array, whole: _Tried, start: float
    ) -> tuple[_Tried, float, set[int]]:
        """The last depth before the first event, with the lines of the surfaces it happens to."""
        involved = self._involved(whole, start)
        low = _Tried(start, surfaces, np.zeros(len(surfaces)), {}, set())
        high, older, least = whole, low, _CLOSE * self.motion.resting.size
        aim, off, widths = math.nan, math.inf, [math.inf] * _PATIENCE
        for _ in range(_MOST):
            middle = (low.depth + high.depth) / 2
            if abs(high.depth - low.depth) <= least or middle in (low.depth, high.depth):
                break
            last, aim = aim, _runs_out(older, low, high)
            off = 2 * abs(aim - last) + least if not math.isnan(aim - last) else math.inf
            widths.append(abs(high.depth - low.depth))
            slow = widths[-1] > widths[-1 - _PATIENCE] / 2
            depth = middle if slow else _next(low, high, aim, off)
            tried = self._tried(low.lines, involved, low.depth, depth)
            if tried.failed:
                high, involved = tried, self._involved(tried, start) & involved
            else:
                older, low = low, tried._replace(work=low.work + tried.work)
        else:
            raise NotCertifiedError(
                f"the event near depth = {low.depth!r} is not enclosed; try other depths"
            )
        return low, high.depth, involved

    def _involved(self, tried: _Tried, start: float) -> set[int]:
        """Surfaces to which something happens; of retracted lines with those beyond a contact."""
        if tried.depth > start:
            return tried.failed
        near = {i + j for i in tried.failed for j in (-1, 0, 1)}
        return {i for i in near if 0 <= i < len(tried.lines)}

    def _tried(self, surfaces: Array, which: set[int], start: float, end: float) -> _Tried:
        """Surfaces taken to a depth, and what is left for each."""
        kept = sorted(which)
        found = self.smooth.over(surfaces[kept], start, end)
        lines, work = surfaces.copy(), np.zeros(len(surfaces))
        lines[kept], work[kept] = found.lines, found.work
        failed = {i for i, good in zip(kept, found.smooth.tolist(), strict=True) if not good}
        reach = self.smooth.drives.reach(found.lines, end, 1 if end > start else -1)
        rooms: Rooms = {}
        for i, margin, (q, p) in zip(kept, found.margin.tolist(), reach.tolist(), strict=True):
            rooms["stiff", i], rooms["left", i], rooms["right", i] = margin, q, p
        if end > start:
            self._pressed(surfaces, lines, which - failed, (start, end), rooms, failed)
        self._contacts(lines, which, end, rooms, failed)
        return _Tried(end, lines, work, rooms, failed)

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
        surface, size = self.motion.surface, self.motion.resting.size
        for i in which:
            q, p, moved = float(old[i, 0]), float(old[i, 1]), (float(new[i, 0]), float(new[i, 1]))
            least, _ = surface.least(moved, depths[1])
            rooms["clear", i] = least + TIE * size
            if least < -TIE * size or surface.overtakes(q, p, moved, *depths):
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


def _flat(surfaces: Array) -> Lines:
    """The lines of all free surfaces."""
    return tuple(surfaces.ravel()[1:-1].tolist())


def _runs_out(older: _Tried, low: _Tried, high: _Tried) -> float:
    """The first depth at which something is used up, if it changes linearly; nan: not known."""
    found = [math.nan]
    for key, room in low.rooms.items():
        other, before = high.rooms.get(key, math.nan), older.rooms.get(key, math.nan)
        if other < 0 < room:
            found.append((high.depth - low.depth) * room / (room - other))
        elif before > room > 0:
            found.append((low.depth - older.depth) * room / (before - room))
    return low.depth + min(found, key=lambda step: math.inf if math.isnan(step) else abs(step))


def _next(low: _Tried, high: _Tried, aim: float, off: float) -> float:
    """The next depth to try: a little before what is aimed at, or if that is near, beyond it.

    off: how far the aim may be off. The middle, where neither encloses the event much closer.
    """
    width, middle = high.depth - low.depth, (low.depth + high.depth) / 2
    share, part = (aim - low.depth) / width, off / abs(width)
    if not (-part < share < 1 and part < _WORTH):
        return middle
    depth = low.depth + width * (share - part if share > 2 * part else share + 2 * part)
    inside = min(low.depth, high.depth) < depth < max(low.depth, high.depth)
    return depth if inside else middle
