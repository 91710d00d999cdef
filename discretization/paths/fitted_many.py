"""The metastable branch of several contacts on the fitted mesh, from event to event.

States are the lines at rest (../fitted/motion.py); between events they move continuously with the
depth. An event is where they do not: a contact begins, two become one, one closes, or a line
jumps over a part of the profile where it has no rest; see ../following.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.alone import Alone
from discretization.fitted.contacts import Contacts, certify
from discretization.fitted.free_part import Lines
from discretization.fitted.motion import Motion, free_parts
from discretization.fitted.rest_depths import LEAST, TIE
from discretization.fitted.zeros import followed
from discretization.following.events import Events
from discretization.following.lone import NEAR, LoneTrack
from discretization.following.smooth import Piece
from discretization.paths.branch import Branch, Leg, Pinned, Point
from discretization.profile import resolve, warn_hidden
from discretization.routes import one_contact
from energy import Scene
from energy.arrays import Array, Mask

_SHORT = 1e-6  # of l: where an equilibrium disappears within rounding a line is that far from it
_FELT = 1e-9  # of l: lines that jump less far do so by rounding


@dataclass(eq=False)
class Tracked(Leg):
    """A leg of lines that move smoothly, in pieces on which they are polynomials of t; or alone."""

    pieces: tuple[Piece, ...]
    lone: LoneTrack | None

    smooth = property(lambda self: self.branch.events.trials.smooth)

    def lines(self, depths: Array, *, roughly: bool = False) -> Array:
        """Lines (k, n, 2) at depths (k,) on the way; roughly: as polynomials tell."""
        if self.lone:
            return self.lone.lines(depths)
        found = np.tile(np.array(free_parts(self.start.lines or ())), (depths.size, 1, 1))
        for piece in self.pieces:
            (start, end), which = piece.ends, np.array(piece.which)
            way = 1 if end >= start else -1
            beyond, inside = way * (depths - start) > 0, way * (depths - end) < 0
            # where an equilibrium disappears at the end rounding may put its lines beyond that
            found[np.ix_(beyond, which)] = piece.lines[:, -1, -1]
            at = np.flatnonzero(beyond & inside)
            at = at[np.argsort(way * depths[at], kind="stable")]
            if at.size:
                read = self._read(piece, depths[at], way, roughly)
                found[np.ix_(at, which)] = read.transpose(1, 0, 2)
        if self.smooth.rests.scene.axisymmetric:  # where it is lost, rounding is all there is
            found = np.where(np.isfinite(found), np.maximum(found, 0.0), found)
        return found

    def _read(self, piece: Piece, depths: Array, way: int, roughly: bool) -> Array:
        """Lines (n, k, 2) at depths on the way of a piece, in their order."""
        first, guess = piece.lines[:, 0, 0], piece.drawn(depths, way)
        # lines that come free of a corner or an edge stay on the side they leave it to
        ends = piece.lines.min(axis=(1, 2))[:, None], piece.lines.max(axis=(1, 2))[:, None]
        guess = np.clip(guess, *ends)
        if roughly:
            return guess
        whole = np.append(piece.ends[0], depths)
        guess = np.concatenate([first[:, None], guess], axis=1)
        x, good = followed(self.smooth.rests, first, whole, way, guess)
        lost = np.flatnonzero(~good)
        if lost.size:  # next to where an equilibrium disappears rounding may make it unstable
            near = np.where(np.isfinite(x), np.clip(x, *ends), guess)[lost]
            still = self._at_rest(near, whole, way)[:, None, None]
            x[lost] = np.where(still, near, guess[lost])
            if not self._at_rest(x[lost], whole, way).all():
                raise NotCertifiedError(
                    f"the contacts between depth = {piece.ends[0]!r} and {float(depths[-1])!r} do "
                    "not come to rest; try other depths, or method='lattice'"
                )
        return np.asarray(self.smooth.rests.snapped(x[:, 1:]))

    def _at_rest(self, lines: Array, depths: Array, way: int) -> Mask:
        """Whether lines (n, k, 2) that move are at rest at depths (k,), as far as that is known."""
        rests = self.smooth.rests
        off = rests.ahead(lines.reshape(-1, 2), way).reshape(lines.shape) - depths[:, None]
        off[~np.isfinite(lines) | (lines == lines[:, :1])] = 0.0  # those that do not move
        known = NEAR * rests.size + rests.noise(lines)[..., None]
        return np.asarray((np.abs(off) <= known).all(axis=(1, 2)))

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the way (n,)."""
        rows = self.lines(depths).reshape(depths.size, -1)[:, 1:-1].tolist()
        return [Point(d, tuple(row) or None) for d, row in zip(depths.tolist(), rows, strict=True)]

    def forces(self, depths: Array, *, roughly: bool = False) -> Array:
        """P at depths on the way (n,); roughly: from the polynomials of the lines."""
        if not roughly:
            return super().forces(depths)
        return np.asarray(self.smooth.many(self.lines(depths, roughly=True), depths)[1])

    def external_work(self) -> float:
        """∫P dd from the start to the end; of several contacts from what has been followed."""
        return super().external_work() if self.lone else float(self.smooth.work(self.pieces))


@dataclass(frozen=True, eq=False)
class FittedMany(Branch):
    """Any number of contacts under a prescribed depth; known: legs, by where they begin."""

    scene: Scene
    motion: Motion
    events: Events
    known: dict[Any, Tracked] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: Scene, deepest: float) -> FittedMany:
        """deepest: the largest depth of the programme."""
        alone = one_contact(scene) and scene.pattern is None
        lone = {1: Alone.of(scene), -1: Alone.of(scene.opened)} if alone else {}
        motion = Motion.of(scene, resolve(scene, deepest), deepest)
        events = Events(motion, lone)
        if not (scene.indenter.convex or scene.indenter.complete):
            hidden = events.trials.smooth.integrals.hidden
            if hidden.size:
                warn_hidden(hidden, stacklevel=4)
        return cls(scene, motion, events)

    @property
    def resolution(self) -> float:
        """The length by which lines may be off, by rounding."""
        return _FELT * self.scene.elastocapillary_length

    touch = property(lambda self: self.motion.profile.touch)

    @functools.cached_property
    def first(self) -> Point:
        """The state at first touch."""
        lines = self.motion.first()
        if alone := self._beside_apex(lines):
            lines = alone.lines(self.touch)
        return Point(self.touch, lines)

    def _beside_apex(self, lines: Lines) -> Alone | None:
        """What finds lines closer to the apex of a lone contact than the samples of the profile."""
        alone, near = self.events.alone.get(1), LEAST * self.scene.elastocapillary_length
        if alone is None or not alone.tip or not lines:
            return None
        return alone if max(abs(x - alone.apex) for x in lines) <= near else None

    def leg(self, point: Point, goal: float) -> Tracked:
        """The way from a point towards another depth, up to the first event or free line."""
        way, at, known = 1 if goal > point.depth else -1, (point.lines, point.depth), self.known
        if (*at, way) not in known or way * (known[*at, way].end.depth - goal) > 0:
            known[*at, way] = self._followed(point, goal)
        return known[*at, way]

    def _followed(self, point: Point, goal: float) -> Tracked:
        part = self.events.part(point.lines or (), point.depth, goal)
        end = Point(part.depth, part.lines or None)
        after = None if part.after is None else Point(part.depth, part.after or None)
        jumps = after is not None and self._jumps(end, after)
        return Tracked(self, point, end, after, jumps, part.pieces, part.lone)

    def pinned(self, point: Point) -> Pinned:
        """What holds each of the outermost lines: "edge", "tip" of a convex profile, or ""."""
        tip, held = self.motion.profile.lowest, super().pinned(point)
        if not self.motion.gradual or tip not in self.scene.indenter.corners:
            return held
        first, last = (edge or "tip" * (x == tip) for edge, x in zip(held, point.ends, strict=True))
        return first, last

    def _jumps(self, before: Point, after: Point) -> bool:
        """Whether lines jump; not by what the energy changes within the rounding of a depth."""
        if not after.lines or not before.lines:
            return not self.motion.gradual
        if len(before.lines) != len(after.lines):
            return True
        apart = np.abs(np.subtract(before.lines, after.lines)).max()
        energy, force = self.totals([before, after])
        noise = TIE * self.motion.rests.size * float(np.abs(force).sum())
        far = apart > _SHORT * self.scene.elastocapillary_length
        return bool(far and energy[0] - energy[1] > noise)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points with as many lines as each other."""
        lines = np.array([free_parts(point.lines or ()) for point in points])
        return self.events.trials.smooth.many(lines, np.array([point.depth for point in points]))

    def opened(self, before: Point, after: Point) -> float:
        """The length that opens between two points, weighted with the pattern's factor."""
        if not before.lines or not after.lines:
            return 0.0
        sums = self.events.trials.smooth.integrals
        bound = [sums.at(np.array(point.lines))[4] for point in (before, after)]
        return float(np.maximum((bound[0] - bound[1]).reshape(-1, 2) * (-1, 1), 0.0).sum())

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contacts are in equilibrium."""
        if not point.lines:
            return
        judge = self._beside_apex(point.lines) or self.motion  # by the sizes of the whole path
        contacts = Contacts(judge, point.lines, point.depth)
        certify(contacts, contacts.totals()).demand(
            f"the state at depth = {point.depth!r}",
            "the path stops before it; try other depths, or method='lattice'",
        )
