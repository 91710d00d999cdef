"""Free surfaces taken from one depth to another: do they move smoothly, and up to where.

Free surfaces do not feel each other, as u = d - f is prescribed in contact. So each is followed by
itself (smooth.py), and only those to which something happens are looked at closer (enclosing.py).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.motion import Motion
from discretization.fitted.resting import Pair
from discretization.fitted.rests import TIE
from discretization.following.smooth import Piece, Smooth
from discretization.quadrature import Integrals

Array = NDArray[np.float64]
Rooms = dict[tuple[str, int], float]


class Tried(NamedTuple):
    """Surfaces taken to a depth: their lines, what is left; surfaces that fail.

    known: something is known to happen to one of these; else shorter ways may succeed. pieces: the
    lines on the way.
    """

    depth: float
    lines: Array
    rooms: Rooms
    failed: set[int]
    known: bool
    pieces: tuple[Piece, ...] = ()

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

    def tried(self, surfaces: Array, which: set[int], start: float, end: float) -> Tried:
        """Surfaces taken to a depth, and what is left for each."""
        lines, kept = surfaces.copy(), sorted(which)
        found = self.smooth.over(surfaces[kept], start, end)
        lines[kept] = found.lines
        failed = {i for i, good in zip(kept, found.smooth.tolist(), strict=True) if not good}
        unknown = len(failed)
        reach = self.motion.rests.reach(found.lines, end, 1 if end > start else -1)
        rooms: Rooms = {}
        for i, margin, (q, p) in zip(kept, found.margin.tolist(), reach.tolist(), strict=True):
            rooms["stiff", i], rooms["left", i], rooms["right", i] = margin, q, p
        if end > start:
            self._pressed(surfaces, lines, set(kept) - failed, (start, end), rooms, failed)
        self._contacts(lines, which, end, rooms, failed)
        known = len(failed) > unknown
        if not failed:
            found = self.smooth.balanced(found)
            failed = {i for i, good in zip(kept, found.smooth.tolist(), strict=True) if not good}
        way = Piece(tuple(kept), found.depths, found.whole)
        return Tried(end, lines, rooms, failed, known, (way,))

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
        """Surfaces taken to a depth that may be where they are."""
        moves = start != end and which
        return self.tried(surfaces, which, start, end) if moves else unmoved(surfaces, start)

    def involved(self, tried: Tried, start: float) -> set[int]:
        """Surfaces to which something happens; of retracted lines with those beyond a contact."""
        if tried.depth > start:
            return tried.failed
        near = {i + j for i in tried.failed for j in (-1, 0, 1)}
        return {i for i in near if 0 <= i < len(tried.lines)}


def unmoved(surfaces: Array, depth: float) -> Tried:
    """Surfaces where they are."""
    return Tried(depth, surfaces.copy(), {}, set(), False)


def merge(one: Tried, own: set[int], other: Tried) -> Tried:
    """Put the lines of some surfaces in place of those of another trial."""
    kept = sorted(own)
    other.lines[kept] = one.lines[kept]
    return other._replace(pieces=other.pieces + _restricted(one.pieces, own))


def _restricted(whole: tuple[Piece, ...], own: set[int]) -> tuple[Piece, ...]:
    """The same pieces with some of their free surfaces."""
    found = []
    for piece in whole:
        kept = [k for k, i in enumerate(piece.which) if i in own]
        if kept:
            which = tuple(piece.which[k] for k in kept)
            found.append(piece._replace(which=which, lines=piece.lines[kept]))
    return tuple(found)
