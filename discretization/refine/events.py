"""Depths of events, enclosed for many events at once.

An event ends the life of some free surfaces. Between a depth at which these are at rest and one at
which they are not, its depth is enclosed by dividing the range into equal parts, at all of which
all surfaces of all events are taken to rest together; a range shrinks by PARTS + 1 each round. That
is the same for every kind of event: an equilibrium that disappears (fold), a contact whose lines
meet, a corner that a line jumps over, a contact of one point that is pulled. Where a surface
touches the profile it stays in equilibrium: that depth is a root (roots.py). So is the depth of a
fold, next to which lines move as the root of what is left.

Conventions
-----------
Depths grow as the indenter goes down. A direction is 1 where the depth grows and -1 where it falls;
depths times the direction increase on a route, and "before", "beyond", "earlier" and "first" are
meant so. The low depths of g events are depths before them, at which all their surfaces are at
rest, the high depths those beyond, at which they are not. With falling depth the low ones are
larger.

A `Happening` is an event that ends the free surfaces `before`, each a `Life`; pressed it is one
surface, retracted several neighbours may join. The surfaces of g events stand in r rows, those of
an event next to each other from left to right; `owner` (r,) is the event of each row. A row of
lines (r, 2) is (left line, right line) [length], -inf and inf where a tail has none, and at j
depths lines are (r, j, 2). The contact between rows i and i + 1 of an event reaches from the right
line of one to the left line of the other. "Good" are surfaces at rest that have come there smoothly
(`_good`).

Of a `Happening`, `at` is its depth on nodes, `depth` the refined one and `lines_before` the lines
(n, 2) of `before` there; of a `Life`, `nodes` are the `FoundNodes` that it was found on, with their
`spacing`, x of all of them (`positions`) and their `margin`, by how much depths on them may be off;
`trace` has its depths on nodes, each with the pair of contact nodes at its ends, None of a tail;
`start` is the refined depth of its birth and `first` its lines there, nan where not known;
`guess(depth)` are the positions of its nodes, and `lines_at(pair)` those of a pair. CREEPING is how
many links lines may pass at one depth on nodes and yet move smoothly.

`settle` takes surfaces to rest by Newton's method, in at most ROUNDS rounds, each line no further
than `reach`: `Settled` has `lines`, whether they are `at_rest`, which are `pinned`, and which have
`jumped` over a corner. With two works of adhesion (`scene.hysteretic`) lines stand where they are,
`kept`, until they move in their direction. FROM_NODES, of l, is how far lines may rest from their
nodes. `dips` are the minima of the gap of surfaces with their `places` and `gaps`. `roots.folds`,
`roots.touches` and `roots.meetings` have the `lines`, `depths` and `places` of events, and which
are `found`. Of `Equations`, `size` is δ, `joints` are x where lines may be pinned with both ends of
the profile, `edges` those of these ends at which the body ends, `pulls` the forces of surfaces at
their lines over kl [length], positive where they push the contact up against the indenter, and
`shape` the gap of surfaces at places with its slope.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from discretization.refine import roots
from discretization.refine.clearance import dips
from discretization.refine.equations import OUTWARDS, Equations
from discretization.refine.lives import CREEPING, Happening, Life
from discretization.refine.nodes import FROM_NODES
from discretization.refine.settle import ROUNDS, Settled, settle
from energy.arrays import Array, Indices, Mask

# Depths in a range, at which surfaces are taken to rest together: each round is 4 bits of a depth.
# 7 or 31 changes none of 8 random paths (`python -m tests.sensitivity
# discretization.refine.events PARTS`).
PARTS = 15
# Of the size of depths: surfaces that are deeper in the profile pass through it. The certificate of
# the states tolerates as much.
PENETRATION = 1e-9


class EventRules(NamedTuple):
    """How depths of events are enclosed.

    Margins are those of the depths on nodes, δ is the size of depths.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each but `few` leaves 8 random
    paths as they are to 1e-9: `python -m tests.sensitivity discretization.refine.events`. `longer`
    is not read there, as no range was too short.

    Attributes
    ----------
    close : float
        Of δ: a range that is no wider encloses an event, some roundings of a depth.
    open : float
        Of δ: a range that is wider after all rounds does not.
    rounds : int
        Rounds at most. Each divides a range by 16, so that 14 reach rounding; more are needed where
        a range was too short.
    root_rounds : int
        Rounds before each of which the event may be a root: a fold is sharp from nearby only. With
        none of them the same paths take more than twice as long.
    left : tuple of float
        Parts of the range that are left before a root: surfaces must be at rest at all of them.
    longer : float
        Times the last range is the next one, if surfaces were at rest at all its depths.
    earlier : tuple of float
        Margins before the depth on nodes at which surfaces are looked for at rest, one after the
        other.
    later : tuple of float
        Margins beyond it at which they are looked for no longer at rest.
    jumps : float
        Of l: lines that move further from one depth to the next do not move smoothly.
    few : int
        Rounds of Newton's method from nearby: quadratic convergence needs five, from a tenth of l
        to rounding. With 4 one of 8 random paths is left to the nodes on a part, and warns.
    tie : float
        Of δ: depths and pulls that differ by less are the same but for rounding.
    same_fold : float
        Of δ: a root that near to the enclosed depth is the fold.
    near_fold : float
        Of l: the same of its lines, which move as the root of depths.
    same_touch : float
        Of l: lines that near to those of a touch are these.
    minima : int
        Least minima of the gap at which a surface may touch.
    corners : float
        Spacings of nodes from where a surface touches to a corner that it may touch: two links and
        a half.
    """

    close: float = 1e-14
    open: float = 1e-11
    rounds: int = 60
    root_rounds: int = 4
    left: tuple[float, ...] = (
        0.75,
        0.5,
        0.25,
        0.06,
        0.01,
        1e-4,
    )
    longer: float = 4.0
    earlier: tuple[float, ...] = (0.02, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
    later: tuple[float, ...] = (0.3, 1.0, 3.0, 10.0)
    jumps: float = 0.25
    few: int = 8
    tie: float = 1e-13
    same_fold: float = 1e-7
    near_fold: float = 5e-2
    same_touch: float = 1e-3
    minima: int = 3
    corners: float = 2.5


_EVENT = EventRules()


class NotRefined(Exception):
    """What nodes have found could not be taken to the continuum; the message says what.

    Attributes
    ----------
    depth : float
        Where that was [length], nan if at no depth of its own.
    """

    def __init__(self, message: str, depth: float = math.nan) -> None:
        """What the message says, and the depth; see the class."""
        super().__init__(message)
        self.depth = depth


@dataclass(eq=False)
class _Group:
    """Events that are being enclosed, with their surfaces in rows.

    Attributes
    ----------
    events : list of Happening
        g of them.
    lives : list of Life
        The r surfaces that these end.
    owner : ndarray of int (r,)
        The number of the event of each.
    directions : ndarray (g,)
        Those of the events.
    steps : ndarray (r, 2)
        How far lines may move smoothly from one depth to the next [length].
    """

    events: list[Happening]
    lives: list[Life] = field(init=False)
    owner: Indices = field(init=False)
    directions: Array = field(init=False)
    steps: Array = field(init=False)

    def __post_init__(self) -> None:
        """The surfaces that the events end in one row after the other, and whose they are."""
        self.lives = [life for event in self.events for life in event.before]
        sizes = [len(event.before) for event in self.events]
        self.owner = np.repeat(np.arange(len(sizes)), sizes)
        self.directions = np.array([float(event.direction) for event in self.events])
        self.steps = np.array([step for event in self.events for step in _steps(event)])

    def all_of(self, good: Mask) -> Mask:
        """Whether something holds for all surfaces of each event: from (r, ...) to (g, ...)."""
        found = np.ones((len(self.events), *good.shape[1:]), bool)
        np.logical_and.at(found, self.owner, good)
        return found


class _Started(NamedTuple):
    """An event, a depth before it [length], and lines (n, 2) of its surfaces at rest there."""

    event: Happening
    depth: float
    lines: Array


class _Beyond(NamedTuple):
    """Where surfaces have come to beyond their events.

    Attributes
    ----------
    high, low : ndarray (g,)
        Depths at which surfaces are no longer good, nan where they are up to the touch, and the
        last ones before at which they are, or that of the touch [length].
    lines : ndarray (r, 2)
        At the low depths [length].
    ended, missed : ndarray of bool (g,)
        Which events lie between these depths, and which have not been found: neither an end nor a
        touch.
    """

    high: Array
    low: Array
    lines: Array
    ended: Mask
    missed: Mask


class _Trial(NamedTuple):
    """A place at which a surface may touch the profile.

    Attributes
    ----------
    event : int
        Number of the event in its group.
    lines : ndarray (2,)
        Of the surface before the event [length].
    place : float
        [length].
    at_corner : bool
        Whether the place is a corner, and so exact.
    """

    event: int
    lines: Array
    place: float
    at_corner: bool


class _End(NamedTuple):
    """A fold or a meeting, at which lives of an event may end.

    Attributes
    ----------
    depth : float
        [length].
    event : int
        Number of the event in its group.
    rows : list of int
        The surfaces whose lines are known there: that of a fold, both neighbours of a meeting.
    lines : ndarray (1 or 2, 2)
        Their lines [length].
    power : float
        Lines come there like this power of what is left of the depth: 1/2 at a fold, 1 at a
        meeting.
    """

    depth: float
    event: int
    rows: list[int]
    lines: Array
    power: float


@dataclass(frozen=True, eq=False)
class Events:
    """What encloses the depths of events of free surfaces.

    Attributes
    ----------
    equations : Equations
    """

    equations: Equations

    def rest(
        self,
        lives: Sequence[Life],
        lines: Array,
        depths: Array,
        *,
        reach: float = math.inf,
        rounds: int = ROUNDS,
        downhill: bool = False,
    ) -> Settled:
        """Take free surfaces to rest, each at several depths.

        Parameters
        ----------
        lives : sequence of Life
            r of them, which give the direction and, with two works of adhesion, where lines stand.
        lines : ndarray (r, j, 2)
            Where to begin [length].
        depths : ndarray (r, j)
            [length].
        reach, rounds, downhill
            As in `settle`.

        Returns
        -------
        Settled
            With the r * j surfaces in one row after the other.
        """
        count = lines.shape[1]
        directions = np.repeat([float(life.direction) for life in lives], count)
        kept = None
        if self.equations.scene.hysteretic:
            # Lines begin where they stand or beyond: pressed lines only advance, left ones to the
            # right; retracted lines only recede. What stands nowhere yet, nan, begins where it is.
            kept = np.repeat([life.first for life in lives], count, axis=0)
            to_the_right = directions[:, None] * OUTWARDS > 0
            flat = lines.reshape(-1, 2)
            flat = np.where(to_the_right, np.maximum(flat, kept), np.minimum(flat, kept))
            lines = np.where(np.isnan(flat), lines.reshape(-1, 2), flat)
        return settle(
            self.equations,
            lines.reshape(-1, 2),
            depths.ravel(),
            directions,
            kept=kept,
            reach=reach,
            rounds=rounds,
            downhill=downhill,
        )

    def enclose(self, events: Sequence[Happening]) -> None:
        """Find the depths of events and the lines just before them.

        Between a depth at which all surfaces of an event are at rest and one at which they are not,
        the event is a root (fold, touch or meeting), if just before that all are at rest; else its
        range is divided until

            |high - low| <= 1e-14 δ,    δ the size of depths,

        or 60 times. It is missed if the range is then wider than 1e-11 δ, or if the event comes
        later than a margin after that on nodes.

        Parameters
        ----------
        events : sequence of Happening
            `depth` and `lines_before` are written; they stay nan and empty of those missed.
        """
        started = self._started(list(events))
        if not started:
            return
        group = _Group([start.event for start in started])
        low = np.array([start.depth for start in started])
        lines = np.concatenate([start.lines for start in started])
        touching = self._touching(group, low, lines)
        high, low, lines, ended, missed = self._beyond(group, low, lines, touching)
        ending = np.flatnonzero(ended)
        if ending.size:
            part = _Group([group.events[i] for i in ending])
            rows = np.isin(group.owner, ending)
            ends = self._ends(part, low[ending], high[ending], lines[rows])
            low[ending], lines[rows], missed[ending] = ends
        for i, event in enumerate(group.events):
            rows = lines[group.owner == i]
            if not missed[i] and self._clear(event, rows, float(low[i])):
                event.lines_before = rows
                event.depth = float(low[i])
            elif event.direction > 0:
                self._touched_before(event, rows[0], float(low[i]))

    def _started(self, events: list[Happening]) -> list[_Started]:
        """Those of these events before which all surfaces are found at rest.

        They are looked for from their nodes, or from their birth, ever earlier.
        """
        started = list[_Started]()
        for earlier in _EVENT.earlier:
            todo = [event for event in events if not any(event is known for known, *_ in started)]
            if not todo:
                break
            group = _Group(todo)
            depths = np.array([_before(event, earlier) for event in todo])
            rows = depths[group.owner]
            guess = np.array([life.guess(d) for life, d in zip(group.lives, rows, strict=True)])
            at_birth = np.array(
                [life.start == d for life, d in zip(group.lives, rows, strict=True)]
            )
            first = np.array([life.first for life in group.lives])
            guess = np.where(at_birth[:, None], first, guess)
            found = self.rest(
                group.lives, guess[:, None], rows[:, None], reach=FROM_NODES * self._length
            )
            good = group.all_of(self._good(group, found, depths[:, None], guess[:, None]))[:, 0]
            for i in np.flatnonzero(good):
                lines = found.lines[group.owner == i]
                started.append(_Started(todo[i], float(depths[i]), lines))
        return started

    @property
    def _length(self) -> float:
        """The elastocapillary length l [length]."""
        return self.equations.length

    def _good(self, group: _Group, found: Settled, depths: Array, before: Array) -> Mask:
        """Whether surfaces (r, j) taken to rest at depths (g, j) have moved smoothly from `before`.

        At rest, without a jump over a corner or far away, and of two neighbours with a contact
        between them that has not closed; a contact of one point must not be pulled. before
        (r, 1 or j, 2): lines one depth earlier, or those that are expected.
        """
        rows, count = len(group.lives), depths.shape[1]
        lines = found.lines.reshape(rows, count, 2)
        good = (found.at_rest & ~found.jumped).reshape(rows, count)
        with np.errstate(invalid="ignore"):
            moved = np.where(np.isfinite(lines), np.abs(lines - before), 0.0)
        limits = np.minimum(_EVENT.jumps * self._length, group.steps)[:, None]
        good &= ((moved < limits) | (moved == 0)).all(axis=2)
        same = np.flatnonzero(group.owner[1:] == group.owner[:-1])
        if same.size:
            left = lines[same, :, 1]
            right = lines[same + 1, :, 0]
            good[same] &= left <= right
            points = left == right
            if points.any():
                of_rows = depths[group.owner].ravel()
                pulls = self.equations.pulls(lines.reshape(-1, 2), of_rows)
                pulls = pulls.reshape(rows, count, 2)
                reaction = pulls[same, :, 1] + pulls[same + 1, :, 0]
                good[same] &= ~points | (reaction >= -_EVENT.tie * self.equations.size)
        return good

    def _touching(self, group: _Group, low: Array, lines: Array) -> roots.Roots:
        """The first touch of the surface of each event (g,) of growing depth beyond the low depth.

        nan where none is found, and of falling depth. A touch is no event if the life ends before.
        """
        count = len(group.events)
        depths = np.full(count, np.nan)
        places = np.full(count, np.nan)
        known = np.full((count, 2), np.nan)
        tries = list[_Trial]()
        for i, event in enumerate(group.events):
            if event.direction < 0:
                continue
            (life,) = event.before
            (row,) = lines[group.owner == i]
            for place, corner in self._touched_places(life, row, float(low[i])):
                tries.append(_Trial(i, row, place, corner))
        if tries:
            which = [trial.event for trial in tries]
            found = self._touch_roots(
                [group.events[i].before[0] for i in which],
                np.array([trial.lines for trial in tries]),
                low[which],
                np.array([group.events[i].at for i in which]),
                np.array([trial.place for trial in tries]),
                np.array([trial.at_corner for trial in tries]),
            )
            # A touch counts unless it is before the low depth, or later than events are looked for.
            margins_late = _EVENT.earlier[-1] + _EVENT.later[-1]
            for j, i in enumerate(which):
                direction = group.directions[i]
                late = direction * (found.depths[j] - low[i])
                limit = group.events[i].before[0].nodes.margin * margins_late
                if not found.found[j] or not -_EVENT.tie * self.equations.size <= late <= limit:
                    continue
                if np.isnan(depths[i]) or direction * (found.depths[j] - depths[i]) < 0:
                    depths[i] = found.depths[j]
                    places[i] = found.places[j]
                    known[i] = found.lines[j]
        return roots.Roots(known, depths, places, ~np.isnan(depths))

    def _touched_places(self, life: Life, lines: Array, depth: float) -> list[tuple[float, bool]]:
        """Where a surface may touch [length], and whether that is a corner.

        At the least minima of its gap at a depth, with lines (2,), where its nodes touch, and at
        corners next to these places.
        """
        minima = dips(self.equations, lines[None], np.array([depth]))
        least = np.argsort(minima.gaps)[: _EVENT.minima]
        chosen = minima.places[least].tolist()
        left, right = life.trace[-1][1]
        # The node of the surface between these contact nodes that touches first, -1 if none does.
        _, node = life.nodes.walk.closing.touches(left, right)
        if node >= 0:
            chosen.append(float(life.nodes.positions[node]))

        corners = np.append(self.equations.profile.corners, self.equations.edges)
        reach = _EVENT.corners * life.nodes.spacing
        near = set[float]()
        for place in chosen:
            near.update(corners[np.abs(corners - place) <= reach].tolist())
        smooth = [(place, False) for place in chosen]
        at_corners = [(corner, True) for corner in sorted(near)]
        return smooth + at_corners

    def _touch_roots(
        self, lives: list[Life], lines: Array, low: Array, at: Array, places: Array, corner: Mask
    ) -> roots.Roots:
        """Touches of n surfaces, with lines (n, 2) at the low depths (n,), near places (n,).

        at (n,): about the depth of each; corner (n,): whether the place is one, exactly. Lines that
        are pinned at the low depths stay. Not found are touches at corners at which the gap has no
        minimum.
        """
        here = self.rest(lives, lines[:, None], low[:, None], rounds=_EVENT.few)
        free = np.isfinite(lines) & ~here.pinned
        directions = np.array([float(life.direction) for life in lives])
        start = np.where(directions * (at - low) > 0, at, low)
        found = roots.touches(self.equations, lines, start, directions, free, places, corner)
        turns = np.ones(len(lines), bool)
        for i in np.flatnonzero(corner & found.found):
            turns[i] = self._turns_at_corner(found.lines[i], found.depths[i], places[i])
        return found._replace(found=found.found & turns)

    def _turns_at_corner(self, lines: Array, depth: float, corner: float) -> bool:
        """Whether the gap has a minimum at a corner: v' <= 0 on its left, v' >= 0 on its right.

        At an end of the profile, where the body ends, the side on which there is one decides.
        lines (2,): of the surface at the depth.
        """
        # Eight roundings of a position, twice as many as rooms end before their joints: the slopes
        # are those of both sides.
        aside = 8 * np.spacing(max(abs(corner), self._length))
        both_sides = np.array([[corner - aside, corner + aside]])
        _, slope = self.equations.shape(both_sides, lines[None], np.array([depth]))
        first, last = self.equations.joints[[0, -1]]
        falls = corner == first or slope[0, 0] <= 0
        rises = corner == last or slope[0, 1] >= 0
        return bool(falls and rises)

    def _beyond(self, group: _Group, low: Array, lines: Array, touching: roots.Roots) -> _Beyond:
        """Follow surfaces beyond their events, up to where they touch or are no longer good.

        Where lines come to other places by the depth of a touch, that is one of lines that do not
        rest, beyond a fold: then they are followed further.
        """
        count = len(group.events)
        touched = touching.depths.copy()  # nan once the touch is none
        high = np.full(count, np.nan)
        ended = np.zeros(count, bool)
        unknown = np.ones(count, bool)
        margins = np.array([event.before[0].nodes.margin for event in group.events])
        at = np.array([event.at for event in group.events])
        low, lines = low.copy(), lines.copy()
        for later in _EVENT.later:
            todo = np.flatnonzero(unknown)
            if not todo.size:
                break
            part = _Group([group.events[i] for i in todo])
            rows = np.isin(group.owner, todo)
            # Some margins beyond the depth on nodes, or beyond the low one if that is no further;
            # but up to where the surface touches, if it does.
            goal = at[todo] + group.directions[todo] * later * margins[todo]
            early = group.directions[todo] * (goal - low[todo]) <= 0
            goal = np.where(early, low[todo] + group.directions[todo] * later * margins[todo], goal)
            known = ~np.isnan(touched[todo])
            goal = np.where(known, touched[todo], goal)
            found, good = self._tried(part, low[todo], goal, lines[rows])
            for j, i in enumerate(todo):
                own = part.owner == j
                if good[j].all():
                    low[i] = goal[j]
                    lines[np.flatnonzero(group.owner == i)] = found[own, -1]
                    if known[j]:
                        unknown[i] = not self._near(found[own, -1], touching.lines[i])
                        touched[i] = math.nan
                    continue
                first = int(np.argmin(good[j]))
                share = np.arange(PARTS + 2) / (PARTS + 1)
                depths = low[i] + (goal[j] - low[i]) * share
                high[i] = depths[first + 1]
                if first:
                    low[i] = depths[first]
                    lines[np.flatnonzero(group.owner == i)] = found[own, first - 1]
                ended[i] = True
                unknown[i] = False
        return _Beyond(high, low, lines, ended, unknown)

    def _near(self, lines: Array, others: Array) -> bool:
        """Whether lines of a surface (1, 2) are those (2,) of a touch."""
        with np.errstate(invalid="ignore"):
            apart = np.where(np.isfinite(lines), np.abs(lines - others), 0.0)
        return bool(apart.max() <= _EVENT.same_touch * self._length)

    def _tried(self, group: _Group, low: Array, high: Array, lines: Array) -> tuple[Array, Mask]:
        """Surfaces at j = PARTS + 1 depths in equal steps up to the high ones, from the low ones.

        Their lines (r, j, 2), found from those at the low depths (r, 2), and at which depths all
        surfaces of each event are good (g, j).
        """
        count = PARTS + 1
        share = np.arange(1, count + 1) / count
        range_ = high - low
        depths = low[:, None] + range_[:, None] * share
        depths[:, -1] = high
        at_low = lines[:, None]
        guess = np.repeat(at_low, count, axis=1)
        of_surfaces = depths[group.owner]
        reach = _EVENT.jumps * self._length
        found = self.rest(group.lives, guess, of_surfaces, reach=reach, rounds=_EVENT.few)
        settled = found.lines.reshape(guess.shape)
        one_depth_before = np.concatenate([at_low, settled[:, :-1]], axis=1)
        good = self._good(group, found, depths, one_depth_before)
        return settled, group.all_of(good)

    def _ends(
        self, group: _Group, low: Array, high: Array, lines: Array
    ) -> tuple[Array, Array, Mask]:
        """Depths (g,) at which lives end between the low and the high ones, with the lines (r, 2).

        Roots where they are folds or meetings, else the last depths at which all is good; and which
        events are missed (g,). lines (r, 2): those at the low depths.
        """
        low = low.copy()
        narrower = high.copy()
        lines = lines.copy()
        missed = np.zeros(low.size, bool)
        todo = np.arange(low.size)
        for _ in range(_EVENT.root_rounds):
            part, rows = self._part(group, todo)
            at = low[todo]
            to = narrower[todo]
            there = lines[rows]
            known = self._at_roots(part, at, to, there)
            unknown = np.flatnonzero(~known)
            self._narrow(part, at, to, there, unknown)
            low[todo] = at
            narrower[todo] = to
            lines[rows] = there
            todo = todo[unknown]
            if not todo.size:
                return low, lines, missed
        part, rows = self._part(group, todo)
        found = self._narrowed(part, low[todo], narrower[todo], high[todo], lines[rows])
        low[todo], lines[rows], missed[todo] = found
        low[todo], lines[rows] = self._at_folds(part, low[todo], lines[rows])
        return low, lines, missed

    def _part(self, group: _Group, own: Indices) -> tuple[_Group, Mask]:
        """Some events of a group, and which of its rows are theirs (r,)."""
        return _Group([group.events[i] for i in own]), np.isin(group.owner, own)

    def _at_roots(self, group: _Group, low: Array, high: Array, lines: Array) -> Mask:
        """Which events (g,) are the first fold or meeting between the low and the high depths.

        Low depths and lines are put there, in place. Just before it all surfaces must be good.
        """
        first, places, power = self._first_ends(group, low, high, lines)
        known = np.flatnonzero(~np.isnan(first))
        if not known.size:
            return np.zeros(low.size, bool)
        part = _Group([group.events[i] for i in known])
        rows = np.isin(group.owner, known)
        found, good = self._led(
            part, low[known], first[known], lines[rows], places[rows], power[rows]
        )
        sure = np.zeros(low.size, bool)
        sure[known] = good.all(axis=1)
        for j, event in enumerate(known.tolist()):
            if not sure[event]:
                continue
            mine = np.flatnonzero(group.owner == event)
            low[event] = first[event]
            moved = (places[mine] != lines[mine]).any(axis=1)
            near = found[part.owner == j, -1]
            lines[mine] = np.where(moved[:, None], places[mine], near)
            if not moved.all():
                others = mine[~moved]
                depths = np.full((others.size, 1), first[event])
                lives = [group.lives[row] for row in others]
                again = self.rest(lives, lines[others][:, None], depths, rounds=_EVENT.few)
                lines[others] = np.where(again.at_rest[:, None], again.lines, lines[others])
        return sure

    def _first_ends(
        self, group: _Group, low: Array, high: Array, lines: Array
    ) -> tuple[Array, Array, Array]:
        """The first fold or meeting of each event between its low and its high depth.

        Returns
        -------
        depths : ndarray (g,)
            nan where none is [length].
        places : ndarray (r, 2)
            Lines there; of surfaces that do not end themselves those at the low depths [length].
        power : ndarray (r,)
            As that of `_End`.
        """
        here = self.rest(group.lives, lines[:, None], low[group.owner][:, None], rounds=_EVENT.few)
        free = np.isfinite(lines) & ~here.pinned
        depths = np.full(low.size, np.nan)
        places = lines.copy()
        power = np.ones(len(lines))
        for end in self._candidates(group, low, high, lines, free):
            event = end.event
            direction = group.directions[event]
            beyond_low = direction * (end.depth - low[event]) >= 0
            before_high = direction * (end.depth - high[event]) <= 0
            earlier = np.isnan(depths[event]) or direction * (end.depth - depths[event]) < 0
            if beyond_low and before_high and earlier:
                depths[event] = end.depth
                every = np.flatnonzero(group.owner == event)
                places[every] = lines[every]
                places[end.rows] = end.lines
                power[every] = 1.0
                power[end.rows] = end.power
        return depths, places, power

    def _candidates(
        self, group: _Group, low: Array, high: Array, lines: Array, free: Mask
    ) -> list[_End]:
        """Folds and meetings near lines (r, 2), which of them are free (r, 2)."""
        middle = (low + high) / 2
        directions = group.directions[group.owner]
        folds = roots.folds(self.equations, lines, middle[group.owner], directions, free)
        found = [
            _End(float(folds.depths[i]), int(group.owner[i]), [i], folds.lines[[i]], 0.5)
            for i in np.flatnonzero(folds.found).tolist()
        ]
        # Neighbours of one event, with a contact between them whose lines are free.
        same = np.flatnonzero(group.owner[1:] == group.owner[:-1])
        same = same[free[same, 1] & free[same + 1, 0]]
        if same.size:
            owner = group.owner[same]
            both = roots.meetings(
                self.equations, lines[same], lines[same + 1], middle[owner],
                group.directions[owner], free[same, 0], free[same + 1, 1],
            )  # fmt: skip
            for i in np.flatnonzero(both.found).tolist():
                row = int(same[i])
                outer_left = both.lines[i, 0] if np.isfinite(lines[row, 0]) else -math.inf
                outer_right = both.lines[i, 1] if np.isfinite(lines[row + 1, 1]) else math.inf
                at = np.array([[outer_left, both.places[i]], [both.places[i], outer_right]])
                found.append(_End(float(both.depths[i]), int(owner[i]), [row, row + 1], at, 1.0))
        return found

    def _led(
        self, group: _Group, low: Array, end: Array, lines: Array, last: Array, power: Array
    ) -> tuple[Array, Mask]:
        """Surfaces led to their ends: lines (r, j, 2) at depths in between, which are good (g, j).

        low, end (g,): depths; lines, last (r, 2): lines at these. Where a part t of the range is
        left, a line is expected at last + (line - last) t^power.
        """
        left = np.array(_EVENT.left)
        depths = end[:, None] + (low - end)[:, None] * left
        share = left ** power[:, None]
        with np.errstate(invalid="ignore"):
            guess = last[:, None] + (lines - last)[:, None] * share[..., None]
        guess = np.where(np.isfinite(guess), guess, lines[:, None])
        reach = _EVENT.jumps * self._length
        found = self.rest(group.lives, guess, depths[group.owner], reach=reach, rounds=_EVENT.few)
        return found.lines.reshape(guess.shape), group.all_of(
            self._good(group, found, depths, guess)
        )

    def _narrowed(
        self, group: _Group, low: Array, high: Array, last: Array, lines: Array
    ) -> tuple[Array, Array, Mask]:
        """The last depths (g,) at which surfaces are good, lines (r, 2) there, and what is missed.

        last (g,): the high depths before they were narrowed. Missed (g,) are events whose range is
        still wide, or that come later than a margin after both that depth and the one on nodes.
        """
        low = low.copy()
        high = high.copy()
        lines = lines.copy()
        for _ in range(_EVENT.rounds):
            middle = low + (high - low) / 2
            wide = np.abs(high - low) > _EVENT.close * self.equations.size
            wide &= (middle != low) & (middle != high)
            todo = np.flatnonzero(wide)
            if not todo.size:
                break
            self._narrow(group, low, high, lines, todo)
        at = np.array([event.at for event in group.events])
        margins = np.array([event.before[0].nodes.margin for event in group.events])
        late = group.directions * (low - np.where(group.directions * (last - at) > 0, last, at))
        still_open = np.abs(high - low) > _EVENT.open * self.equations.size
        return low, lines, (late > margins) | still_open

    def _narrow(self, group: _Group, low: Array, high: Array, lines: Array, todo: Indices) -> None:
        """Narrow the ranges of some events once, and move their lines on, in place.

        The new range is the step of `_tried` on which surfaces stop being good.
        """
        if not todo.size:
            return
        part, rows = self._part(group, todo)
        found, good = self._tried(part, low[todo], high[todo], lines[rows])
        for j, i in enumerate(todo):
            own = np.flatnonzero(group.owner == i)
            share = np.arange(PARTS + 2) / (PARTS + 1)
            depths = low[i] + (high[i] - low[i]) * share
            depths[-1] = high[i]
            if good[j].all():  # from nearer the high end is at rest: the range was too short
                low[i] = high[i]
                lines[own] = found[part.owner == j, -1]
                step = _EVENT.longer * abs(low[i] - depths[0])
                high[i] = low[i] + group.directions[i] * max(
                    step, _EVENT.close * self.equations.size
                )
                continue
            first = int(np.argmin(good[j]))
            high[i] = depths[first + 1]
            if first:
                low[i] = depths[first]
                lines[own] = found[part.owner == j, first - 1]

    def _at_folds(self, group: _Group, low: Array, lines: Array) -> tuple[Array, Array]:
        """Enclosed depths (g,) and lines (r, 2), put on the fold where one is that near.

        Of each event on the first such fold of its surfaces; where none is, they are left.
        """
        low, lines = low.copy(), lines.copy()
        depths = low[group.owner]
        here = self.rest(group.lives, lines[:, None], depths[:, None], rounds=_EVENT.few)
        free = np.isfinite(lines) & ~here.pinned
        directions = group.directions[group.owner]
        found = roots.folds(self.equations, lines, depths, directions, free)
        near = np.abs(found.depths - depths) <= _EVENT.same_fold * self.equations.size
        with np.errstate(invalid="ignore"):
            moved = np.where(np.isfinite(lines), np.abs(found.lines - lines), 0.0).max(axis=1)
        near &= found.found & (moved <= _EVENT.near_fold * self._length)
        for i in range(len(group.events)):
            own = np.flatnonzero((group.owner == i) & near)
            if own.size:
                first = own[np.argmin(group.directions[i] * found.depths[own])]
                low[i] = found.depths[first]
                lines[first] = found.lines[first]
        return low, lines

    def _touched_before(self, event: Happening, lines: Array, depth: float) -> None:
        """Find the depth at which a surface has touched before its lines (2,) came to a depth.

        Written into the event, with the lines there, if it is found and clear of other touches.
        """
        (life,) = event.before
        gap, place = self.clearance(lines, depth)
        if gap >= 0:
            return
        corners = np.append(self.equations.profile.corners, self.equations.edges)
        corner = bool(np.isin(place, corners))
        at = np.array([depth])
        found = self._touch_roots(
            [life], lines[None], at, at, np.array([place]), np.array([corner])
        )
        if not found.found[0] or event.direction * (found.depths[0] - depth) > 0:
            return
        here = self.rest([life], found.lines[:, None], found.depths[:, None], rounds=_EVENT.few)
        finite = np.isfinite(lines)
        moved = np.abs(here.lines[0, finite] - found.lines[0, finite]).max()
        at_rest = here.at_rest[0] and moved <= _EVENT.near_fold * self._length
        if at_rest and self._clear(event, found.lines, float(found.depths[0])):
            event.lines_before = found.lines
            event.depth = float(found.depths[0])

    def _clear(self, event: Happening, lines: Array, depth: float) -> bool:
        """Whether no surface is in the profile just before an event; always with falling depth.

        Then contacts only shrink, and surfaces move away from the indenter. lines (n, 2): of the
        surfaces that it ends, at this depth.
        """
        if event.direction < 0:
            return True
        least = -PENETRATION * self.equations.size
        return all(self.clearance(row, depth)[0] >= least for row in lines)

    def clearance(self, lines: Array, depth: float) -> tuple[float, float]:
        """The least minimum of the gap v of one free surface between its lines.

        Parameters
        ----------
        lines : ndarray (2,)
            [length].
        depth : float
            [length].

        Returns
        -------
        gap, place : float
            [length]; the gap is exact where it is negative, and inf where there is no minimum.
        """
        found = dips(self.equations, lines[None], np.array([depth]))
        if not found.gaps.size:
            return math.inf, math.nan
        least = int(np.argmin(found.gaps))
        return float(found.gaps[least]), float(found.places[least])


def _steps(event: Happening) -> Array:
    """How far lines (n, 2) may move smoothly: half as far as those move that jump on nodes.

    Infinite for lines that do not jump there, or where surfaces divide or join.
    """
    before = np.array([life.lines_at(life.trace[-1][1]) for life in event.before])
    steps = np.full(before.shape, math.inf)
    if len(event.after) == len(before) == 1:
        (life,) = event.after
        after = life.lines_at(life.trace[0][1])
        with np.errstate(invalid="ignore"):
            moved = np.abs(after - before[0])
        own = np.isfinite(after) & (moved > (CREEPING + 0.5) * life.nodes.spacing)
        steps[0, own] = moved[own] / 2
    return steps


def _before(event: Happening, earlier: float) -> float:
    """A depth so many margins before an event on nodes, not before its surfaces are born."""
    direction = event.direction
    depth = event.at - direction * earlier * event.before[0].nodes.margin
    for life in event.before:
        start = life.start if not math.isnan(life.start) else life.trace[0][0]
        if direction * (depth - start) < 0:
            depth = start
    return depth
