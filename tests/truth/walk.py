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
"""

import math

import numpy as np
from scipy.optimize import brentq

from .ground import Ground, refined_minima
from .surfaces import surface_of

MOVE = 1 / 4  # of the feature: the farthest a line moves before touching is looked for
SINK = 1 / 3  # of δ₀: the farthest the depth grows at once
ROUGHLY, CLOSELY = 1e-6, 1e-11  # of the feature: what counts as moved, on the way and at its end
TIE = 1e-13  # of the depths of the scene: rounding of v
MET = 1e-9  # of the feature: lines closer than that have met
BESIDE = 1e-5  # of the feature: nearer to a line, it is the line that moves
CLUSTER = 0.5 ** np.arange(40.0, 0.0, -1.0)


class Outside(Exception):
    """A contact line has reached an end of the profile that is not the end of the body."""


class Walk:
    """Lines [left, right, left, right, ...] at rest, from first touch on.

    feature: the shortest length on which the profile varies, the elastocapillary length included.
    """

    def __init__(self, scene, feature):
        self.scene = scene
        self.surface = surface_of(scene)
        feature = min(feature, self.surface.length)
        self.ground, self.feature = Ground(scene.indenter, feature), feature
        self.delta = scene.critical_separation
        self.tie = TIE * (
            self.delta + np.ptp(self.ground.heights[np.isfinite(self.ground.heights)])
        )
        self.touch, self.first = self.ground.lowest(self.tie)
        self.lines, self.depth = [x for x in self.first for _ in range(2)], self.touch
        self._settle(+1, ROUGHLY)

    def to(self, depth):
        """Walk to this depth; the lines at rest there. Outside if one leaves the profile."""
        while self.depth < depth:
            self._sink(min(depth, self.depth + SINK * self.delta))
        if depth < self.depth:
            self.depth = depth
            self._settle(-1, CLOSELY)
        else:
            self._settle(+1, CLOSELY)
        return tuple(self.lines)

    def _sink(self, depth):
        """Grow the depth with the lines fixed until something touches, then let it move."""
        before = self.depth

        def clearance(d):
            self.depth = d
            return min((v for v, _ in self._touches()), default=math.inf) + self.tie

        if not clearance(depth) < 0:
            self.depth = depth
        elif clearance(before) < 0:
            self.depth = before
        else:
            self.depth = self._first(clearance, before, depth)
        self._begin()
        self._settle(+1, ROUGHLY)

    def _first(self, clearance, good, bad):
        """A depth or position at which something touches and hardly more than that.

        clearance >= 0 at `good` and < 0 at `bad`; secants between the two, bisection in turn.
        """
        size, high, low = max(abs(good), abs(bad)), clearance(good), clearance(bad)
        for turn in range(200):
            if low >= -self.tie or abs(bad - good) <= 4e-16 * size:
                break
            share = 0.5 if turn % 3 == 2 or not math.isfinite(high) else low / (low - high)
            middle = bad + min(max(share, 1e-3), 0.999) * (good - bad)
            value = clearance(middle)
            if value >= 0:
                good, high = middle, value
            else:
                bad, low = middle, value
        clearance(bad)
        return bad

    def _begin(self, surfaces=None):
        """A contact begins where a free surface touches. Whether there is one."""
        touches = sorted(self._touches(surfaces))
        if not touches or touches[0][0] + self.tie >= 0:
            return False
        at = touches[0][1]
        place = int(np.searchsorted(self.lines, at))
        self.lines[place:place] = [at, at]
        return True

    def _touches(self, surfaces=None):
        """(v, x) at the local minima of v that may be below 0, of these free surfaces or all."""
        if surfaces is None:
            surfaces = range(len(self.lines) // 2 + 1)
        return [touch for i in surfaces for touch in self._dips(i)]

    def _dips(self, i):
        """(v, x) of the i-th free surface from the left where it may touch."""
        left = self.lines[2 * i - 1] if i else -math.inf
        right = self.lines[2 * i] if 2 * i < len(self.lines) else math.inf
        x = self._within(left, right)
        if not x.size:
            return
        ends = tuple(-math.inf if math.isfinite(line) else math.inf for line in (left, right))
        v = self._v(x, left, right)
        for at, value in refined_minima(
            lambda at: self._v(np.asarray(at), left, right), x, v, -self.tie, ends
        ):
            if min(at - left, right - at) > BESIDE * self.feature:
                yield value, at

    def _within(self, left, right):
        """Nodes of a free surface, clustered at its lines."""
        step, ground = self.ground.step, self.ground
        parts = [ground.between(left, right)]
        if math.isfinite(left):
            parts.append(left + step * CLUSTER)
        if math.isfinite(right):
            parts.append(right - step * CLUSTER)
        x = np.unique(np.concatenate(parts))
        return x[(x > left) & (x < right) & (x >= ground.lo) & (x <= ground.hi)]

    def _v(self, x, left, right):
        """u - g of the free surface between two lines, -inf and inf where there is none."""
        g = [self.depth - float(self.ground.height(line)) for line in (left, right)
             if math.isfinite(line)]  # fmt: skip
        if len(g) == 2:
            u = self.surface.gap_shape(x - left, right - left, *g)
        elif g:
            u = self.surface.tail_shape(x - left if math.isfinite(left) else right - x, *g)
        else:
            u = np.zeros_like(x)
        return u - (self.depth - self.ground.height(x))

    # -- lines ---------------------------------------------------------------------------------

    def _settle(self, way, least):
        """Move lines by turns until none moves by more than `least` of the feature.

        way: +1 outwards, -1 inwards.
        """
        moved = True
        while moved:
            moved, i = False, 0
            while i < len(self.lines):
                before = len(self.lines)
                far = self._advance(i) if way > 0 else self._recede(i)
                changed = len(self.lines) != before
                moved |= changed or far > least * self.feature
                i = 0 if changed else i + 1

    def _advance(self, i):
        """How far a line moves outwards: to its first rest, by MOVE, or until something touches."""
        start, side = self.lines[i], 1 if i % 2 else -1
        limit, facing = self._facing(i, side)
        if start == limit and facing is None:
            return 0.0
        rest, met = limit, True
        if abs(limit - start) > MET * self.feature:
            rest, met = self._rest(i, side, start, limit, +1)
        if abs(rest - start) > MOVE * self.feature:
            rest, met = start + side * MOVE * self.feature, False
        if met:
            del self.lines[min(i, i + side) : max(i, i + side) + 1]
            return abs(rest - start)
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
        if clearance(rest) < 0:
            if clearance(start) >= 0:
                self._first(clearance, start, rest)
            self._begin([(i + 1) // 2])
        return abs(rest - start)

    def _movable(self, i, facing):
        """Whether a line would advance if the one it faces were here."""
        x, side = self.lines[i], 1 if i % 2 else -1
        tilt = self.surface.lean(side * self.ground.slope(x, side)) + self._tilt(x, facing)
        return float(tilt) < self.surface.deficit - 1e-6 * self.surface.deficit

    def _facing(self, i, side):
        """How far a line may advance, and the line it faces or None."""
        if 0 <= i + side < len(self.lines):
            return self.lines[i + side], self.lines[i + side]
        return (self.ground.hi if side > 0 else self.ground.lo), None

    def _recede(self, i):
        """Move one line inwards to its first rest; a contact that closes is gone: how far."""
        start, side = self.lines[i], 1 if i % 2 else -1
        limit = self.lines[i - side]
        rest, met = (start, True) if start == limit else self._rest(i, side, start, limit, -1)
        self.lines[i] = limit if met else rest
        if met and not self._pressed(i, side):
            del self.lines[min(i, i - side) : max(i, i - side) + 1]
        return abs(rest - start)

    def _pressed(self, i, side):
        """Whether a contact of no width presses on the layer: without it, there would be v < 0."""
        first = min(i, i - side)
        left = self.lines[first - 1] if first else -math.inf
        right = self.lines[first + 2] if first + 2 < len(self.lines) else math.inf
        return float(self._v(np.asarray(self.lines[i]), left, right)) < -self.tie

    def _rest(self, i, side, start, limit, way):
        """First rest of a line moving from start towards limit, and whether it met the limit.

        At the end of the profile there is nothing to meet: the line is then at rest at the limit.
        """
        other = self._facing(i, side)[1]
        move = side * way
        ends = way < 0 or other is not None

        def drive(x, ahead):  # >= 0: the line does not move on
            f1 = side * self.ground.slope(x, ahead * move)
            return way * (self.surface.lean(f1) + self._tilt(x, other) - self.surface.deficit)

        if float(drive(start, 1)) >= 0:
            return start, False
        low = start
        for x, ahead in self._entries(start, limit, move, ends):
            values = drive(x, ahead)
            stop = int(np.argmax(values >= 0)) if (values >= 0).any() else values.size
            hump = self._hump(drive, x, ahead, values, stop)
            if hump is not None:
                return hump, False
            if stop < values.size:
                before = x[stop - 1] if stop else low
                if before == x[stop]:  # a corner holds it
                    return float(x[stop]), False
                return self._root(drive, float(before), float(x[stop]), move), False
            low = float(x[-1])
            if abs(low - start) > 2 * MOVE * self.feature:
                return low, False
        return limit, ends

    def _tilt(self, x, other):
        """Tilt of the free surface at a line put at x."""
        g = self.depth - self.ground.height(x)
        if other is None:
            return self.surface.tail(g)
        width = np.maximum(np.abs(other - x), 1e-300)
        return self.surface.facing(g, self.depth - float(self.ground.height(other)), width)

    def _entries(self, start, limit, move, ends):
        """Chunks of places on the way, (x, ±1): at a corner first behind it, then ahead of it."""
        low, high = min(start, limit), max(start, limit)
        reach = min(high - low, 4 * MOVE * self.feature)
        near = self.ground.between(*sorted((start, start + move * reach)))
        parts = [near, start + move * self.ground.step * CLUSTER]
        if ends:
            parts.append(limit - move * self.ground.step * CLUSTER)
            least = MET * self.feature
            inside = high - low > 2 * least
            parts.append(np.array([limit - move * least] if inside else []))
        x = np.unique(np.concatenate(parts))
        x = x[(x > low) & (x < high) & (np.abs(x - start) <= reach)]
        if ends:
            x = x[np.abs(limit - x) >= MET * self.feature]
        if not ends and reach == high - low:
            x = np.append(x, limit) if move > 0 else np.append(limit, x)
        corner = np.isin(x, self.ground.corners)
        x = np.concatenate([x, x[corner]])
        ahead = np.concatenate([-np.ones(corner.size), np.ones(int(corner.sum()))])
        order = np.lexsort((ahead, move * x))
        x, ahead = x[order], ahead[order]
        ahead[~np.isin(x, self.ground.corners)] = -1
        if x.size:
            yield x, ahead

    def _root(self, drive, low, high, move):
        """Where drive vanishes between two places without a corner in between."""
        ends = [float(drive(low, 1)), float(drive(high, -1))]
        if ends[0] >= 0 or ends[1] <= 0:
            return low if ends[0] >= 0 else high
        size = max(abs(low), abs(high))
        return brentq(lambda x: float(drive(x, 1)), low, high, xtol=1e-17 * size, rtol=1e-15)

    def _hump(self, drive, x, ahead, values, stop):
        """A rest between nodes at which the line would move on, where drive has a maximum."""
        if stop < 3:
            return None
        y = values[:stop]
        tops = np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] >= y[2:])) + 1
        for j in tops.tolist():
            rise = max(y[j] - y[j - 1], y[j] - y[j + 1])
            if y[j] + rise < 0 or x[j - 1] == x[j] or x[j + 1] == x[j]:
                continue
            found = refined_minima(
                lambda at: -drive(at, -1), *_ascending(x[j - 1 : j + 2], -y[j - 1 : j + 2]), 0.0
            )
            for at, value in found:
                if value <= 0:
                    move = 1 if x[j + 1] > x[j] else -1
                    return self._root(drive, float(x[j - 1]), at, move)
        return None


def _ascending(x, values):
    return (x, values) if x[0] < x[-1] else (x[::-1], values[::-1])
