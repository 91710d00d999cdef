"""The adhered state by a quasi-static walk in depth from first touch.

Contact begins at d = min f. While d grows, contacts only grow: a line advances while
lean(f') + tilt < deficit (surfaces.py), a contact begins where the free surface comes to touch the
indenter, and facing lines that meet are gone. While d falls below first touch, contacts only
shrink. Both are monotone: with v = u - g >= 0, a larger contact has a smaller v everywhere, hence
lines with less resistance. So the lines may be moved one after the other in any order, each to the
first resting place on its way, as long as v never becomes negative. The walk sees to that: the
depth grows in steps after which v >= 0 at fixed lines (shorter ones, found by bisection, where
something touches), and a line moves by at most a fraction of the profile's scale before v is looked
at again. A shrinking contact only makes v larger, so that a retraction is a single step.

With two works of adhesion lines advance against that of closing and recede against that of opening,
with a pattern against that of the patch they move over (surfaces.py). The walk may turn as often as
one likes: both rules, and the order of moves, hold from any state at rest.
"""

import itertools
import math

import numpy as np

from .ground import BESIDE, MET, Ground, Outside, Surfaces, first_rest
from .surfaces import Adhesion, breaks, surface_of

MOVE = 1 / 4  # of the feature: the farthest a line moves before touching is looked for
SINK = 0.6  # of δ₀: the farthest the depth grows at once
ROUGHLY = 1e-4
CLOSELY = 1e-11  # of the feature: what counts as moved, on the way and at its end
SLOW = 0.6
PART = 0.9  # ratio of moves that are slow, and the part of their rest gone at once
ABOUT = 1e-7  # of what holds a line: by less it is about to move
BEHIND = 0.05  # of how slow it is: by so much less some of them go
LEAP = 1e-3  # of the feature: the farthest gone at once
TIE = 1e-13  # of the depths of the scene: rounding of v


class Walk:
    """Lines [left, right, left, right, ...] at rest, from first touch on.

    feature: the shortest length on which the profile varies, the elastocapillary length included.
    """

    def __init__(self, scene, feature):
        self.scene = scene
        self.surface = surface_of(scene)
        feature = min(feature, self.surface.length)
        self.ground = Ground(scene.indenter, feature, breaks(scene))
        self.feature = feature
        self.adhesion = Adhesion(scene, self.ground)
        self.delta = scene.opened.critical_separation
        self.tie = TIE * (self.delta + abs(float(self.ground.heights.min())))
        self.free = Surfaces(self.ground, self.surface, self.tie)
        self.touch, self.first = self.ground.lowest(self.tie)
        self.lines = [x for x in self.first for _ in range(2)]
        self.depth = self.touch
        self._due = []
        self.turns = 0
        self.most = math.inf
        self._close = False
        self._settle(+1, ROUGHLY)

    def to(self, depth):
        """Walk to this depth; the lines at rest there. Outside if one leaves the profile."""
        while self.depth < depth:
            self._sink(min(depth, self.depth + SINK * self.delta))
        if depth < self.depth:
            if not self._close:
                self._settle(+1, CLOSELY)  # a gap about to close may have been left open
            self.depth = depth
            self._settle(-1, CLOSELY)
        else:
            self._settle(+1, CLOSELY)
        self._close = True
        return tuple(self.lines)

    def put(self, lines, depth):
        """Go on from these lines, at rest at this depth."""
        self.lines = list(lines)
        self.depth = depth
        self._close = True

    def _sink(self, depth):
        """Grow the depth with the lines fixed until something touches, then let it move."""
        before = self.depth
        self.depth = depth
        self._close = False
        everywhere = range(len(self.lines) // 2 + 1)
        some = [i for i in everywhere if any(v + self.tie < 0 for v, _ in self._dips(i))]

        def clearance(d):
            self.depth = d
            return min((v for v, _ in self._touches(some)), default=math.inf) + self.tie

        if not some:
            self.depth = depth
        elif clearance(before) < 0:
            self.depth = before
        else:
            self.depth = self._first(clearance, before, depth)
        if some:
            self._begin(some)
        self._settle(+1, ROUGHLY)

    def _first(self, clearance, good, bad):
        """A depth or position at which something touches and hardly more than that.

        clearance >= 0 at `good` and < 0 at `bad`; secants between the two, bisection in turn.
        """
        size = max(abs(good), abs(bad))
        high = clearance(good)
        low = clearance(bad)
        for turn in range(200):
            if low >= -self.tie or abs(bad - good) <= 4e-16 * size:
                break
            share = 0.5 if turn % 3 == 2 or not math.isfinite(high) else low / (low - high)
            middle = bad + min(max(share, 1e-3), 0.999) * (good - bad)
            value = clearance(middle)
            if value >= 0:
                good = middle
                high = value
            else:
                bad = middle
                low = value
        clearance(bad)
        return bad

    def _begin(self, surfaces):
        """A contact begins where a free surface touches. Whether there is one."""
        touches = sorted(self._touches(surfaces))
        if not touches or touches[0][0] + self.tie >= 0:
            return False
        at = touches[0][1]
        self._insert(at)
        return True

    def _touches(self, surfaces):
        """(v, x) at the local minima of v that may be below 0, of these free surfaces."""
        return [touch for i in surfaces for touch in self._dips(i)]

    def _dips(self, i):
        """(v, x) of the i-th free surface from the left where it may touch."""
        left = self.lines[2 * i - 1] if i else -math.inf
        right = self.lines[2 * i] if 2 * i < len(self.lines) else math.inf
        return self.free.dips(left, right, self.depth)

    def _settle(self, way, least):
        """Move lines by turns until none moves by more than `least` of the feature.

        way: +1 outwards, -1 inwards. The facing line is due, and this one unless it rests.
        """
        self._due = [True] * len(self.lines)
        self.turns = 0
        moves = []
        while any(self._due):
            before = list(self.lines)
            i = 0
            while i < len(self.lines):
                if self._due[i]:
                    self._turn(i, way, least)
                i += 1
            if len(self.lines) != len(before):
                moves = []
                continue
            moves = [*moves[-2:], np.subtract(self.lines, before)]
            if len(moves) == 3 and self._leap(moves, way):
                moves = []

    def _turn(self, i, way, least):
        """Move one line to where it rests."""
        self._due[i] = False
        self.turns += 1
        if self.turns > self.most:
            raise Outside("two lines that face each other come to rest too slowly")
        far = self._advance(i) if way > 0 else self._recede(i)
        if far > least * self.feature:
            self._wake(i + (1 if i % 2 else -1), *([i] if far > MOVE / 2 * self.feature else []))

    def _leap(self, moves, way):
        """Whether lines whose moves are a slow geometric series went part of the rest at once.

        moves: of the last three rounds. They may where every line that moved would still move on,
        and nothing touches. Two lines that come close to moving together for good do so more
        slowly the closer they are, so that a part of the rest is never beyond it.
        """
        sizes = [float(np.abs(move).max()) for move in moves]
        if min(sizes) <= 0 or not all(
            SLOW < b / a < 1 / SLOW for a, b in itertools.pairwise(sizes)
        ):
            return False
        rested = list(self.lines)
        rate = sizes[2] / sizes[1]
        part = min(PART * rate / max(abs(1 - rate), 1e-9), LEAP * self.feature / sizes[2])
        behind = np.ones(len(rested))  # the lines that moved last are at rest
        behind[::2] -= BEHIND * min(abs(1 - rate), 1.0)
        self.lines = (np.array(rested) + part * behind * moves[-1]).tolist()
        moved = np.flatnonzero(moves[-1]).tolist()
        if (np.diff(self.lines) >= 0).all() and all(self._moves_on(i, way) for i in moved):
            everywhere = range(len(self.lines) // 2 + 1)
            if not any(v + self.tie < 0 for i in everywhere for v, _ in self._dips(i)):
                return True
        self.lines = rested
        return False

    def about(self, i, way):
        """Whether a line is about to advance (way = 1) or to recede (-1): neither, if held."""
        x = self.lines[i]
        side = 1 if i % 2 else -1
        slack = ABOUT * float(self.adhesion.deficit(x, side * way, way))
        return float(self._drive(i, side, way)(x, 1)) < slack

    def _moves_on(self, i, way):
        """Whether a line would move on from where it is."""
        x = self.lines[i]
        side = 1 if i % 2 else -1
        return float(self._drive(i, side, way)(x, 1)) < 0

    def _insert(self, at):
        """A contact of no width here."""
        place = int(np.searchsorted(self.lines, at))
        self.lines[place:place] = [at, at]
        self._due[place:place] = [True, True]
        self._wake(place - 1, place + 2)

    def _remove(self, i, j):
        """Two neighbouring lines are gone, i < j = i + 1."""
        del self.lines[i : j + 1], self._due[i : j + 1]
        self._wake(i - 1, i)

    def _wake(self, *lines):
        for i in lines:
            if 0 <= i < len(self._due):
                self._due[i] = True

    def _advance(self, i):
        """How far a line moves outwards: to its first rest, by MOVE, or until something touches."""
        start = self.lines[i]
        side = 1 if i % 2 else -1
        limit, facing = self._facing(i, side)
        if start == limit and facing is None:
            return 0.0
        rest = limit
        met = facing is not None
        if abs(limit - start) > MET * self.feature:
            rest, met = self._rest(i, side, start, limit, +1)
        if abs(rest - start) > MOVE * self.feature:
            rest = start + side * MOVE * self.feature
            met = False
        if met:
            self._remove(min(i, i + side), max(i, i + side))
            return 0.0
        if facing is None and rest == limit and limit not in self.ground.walls:
            raise Outside(f"the contact reaches {limit!r}, the end of the profile")
        if rest == start:
            return 0.0

        def clearance(x):
            self.lines[i] = x
            return min((v for v, _ in self._dips((i + 1) // 2)), default=math.inf) + self.tie

        if facing is not None and self._movable(i + side, start):  # not before the other has moved
            while clearance(rest) < 0 and abs(rest - start) > BESIDE * self.feature:
                rest = (start + rest) / 2
                self._due[i] = True
        if clearance(rest) >= 0:
            return abs(rest - start)
        if clearance(start) >= 0:
            self._first(clearance, start, rest)
        self._begin([(i + 1) // 2])
        return 0.0

    def _movable(self, i, facing):
        """Whether a line would advance if the one it faces were here."""
        x = self.lines[i]
        side = 1 if i % 2 else -1
        tilt = self.free.tilt_facing(facing, self.depth)(x)
        tilt += self.surface.lean(side * self.ground.slope(x, side))
        return float(tilt) < (1 - 1e-6) * float(self.adhesion.deficit(x, side, +1))

    def _facing(self, i, side):
        """How far a line may advance, and the line it faces or None."""
        if 0 <= i + side < len(self.lines):
            return self.lines[i + side], self.lines[i + side]
        return (self.ground.hi if side > 0 else self.ground.lo), None

    def _recede(self, i):
        """Move one line inwards to its first rest; a contact that closes is gone: how far."""
        start = self.lines[i]
        side = 1 if i % 2 else -1
        limit = self.lines[i - side]
        rest, met = (start, True) if start == limit else self._rest(i, side, start, limit, -1)
        self.lines[i] = limit if met else rest
        if met and not self._pressed(i, side):
            self._remove(min(i, i - side), max(i, i - side))
            return 0.0
        return abs(rest - start)

    def _pressed(self, i, side):
        """Whether a contact of no width presses on the layer: without it, there would be v < 0."""
        first = min(i, i - side)
        left = self.lines[first - 1] if first else -math.inf
        right = self.lines[first + 2] if first + 2 < len(self.lines) else math.inf
        return float(self.free.v(np.asarray(self.lines[i]), left, right, self.depth)) < -self.tie

    def _rest(self, i, side, start, limit, way):
        """First rest of a line moving outwards (way = 1) or inwards; whether it met the limit."""
        meets = way < 0 or self._facing(i, side)[1] is not None
        return first_rest(self._drive(i, side, way), start, limit, meets, self.ground)

    def _drive(self, i, side, way):
        """drive(x, ahead) >= 0: a line does not move on from x, as it looks ahead (1) or back."""
        ground = self.ground
        lean = self.surface.lean
        tilt = self.free.tilt_facing
        facing = tilt(self._facing(i, side)[1], self.depth)

        def drive(x, ahead):
            toward = ahead * side * way
            deficit = self.adhesion.deficit(x, toward, way)
            return way * (lean(side * ground.slope(x, toward)) + facing(x) - deficit)

        return drive
