"""The profile with fine nodes and refined extremes; where lines rest on it, and surfaces touch."""

import bisect
import functools
import math

import numpy as np
from scipy.optimize import brentq

# Nodes: between two of them a wave of this length departs from its chord by (2π/48)²/8 = 0.2 % of
# its amplitude, so that no deeper dip is missed.
PER_FEATURE = 48
MOST = 400_000  # nodes of a profile: more are refused
# An extreme is sought at PLACES places between its neighbours, ROUNDS times: each round leaves two
# of sixteen intervals, so that after ten 8⁻¹⁰ = 1e-9 of the distance of nodes is left.
PLACES = 17
ROUNDS = 10
MET = 1e-9  # of the feature: lines closer than that have met
BESIDE = 1e-5  # of the feature: nearer to a line, it is the line that moves
CLUSTER = 0.5 ** np.arange(40.0, 0.0, -1.0)  # nodes that approach a line, in steps of the ground


class Outside(Exception):
    """A contact line has reached an end of the profile that is not the end of the body."""


class Ground:
    """A profile sampled PER_FEATURE times per `feature`, the shortest length on which it varies.

    breaks: where something else changes at once, seen from both sides like a corner.
    """

    def __init__(self, indenter, feature, breaks=()):
        self.indenter = indenter
        self.feature = feature
        self.lo, self.hi = (float(end) for end in indenter.extent)
        if not math.isfinite(self.hi - self.lo):
            raise ValueError(f"extent = {indenter.extent!r}: the reference needs a finite one")
        self.corners = np.union1d(np.asarray(indenter.corners, float), breaks)
        self.walls = tuple(indenter.walls)
        count = math.ceil((self.hi - self.lo) / feature * PER_FEATURE) + 1
        if count > MOST:
            raise ValueError(f"feature = {feature!r} needs {count} nodes; give a larger one")
        self.step = (self.hi - self.lo) / (count - 1)
        inside = self.corners[(self.corners > self.lo) & (self.corners < self.hi)]
        self.nodes = np.union1d(np.linspace(self.lo, self.hi, count), inside)
        self.heights = np.asarray(indenter.height(self.nodes), float)
        self._aside = 4e-15 * max(abs(self.lo), abs(self.hi))
        self._kinks = np.union1d(self.corners, [self.lo, self.hi])
        self._last = self._kinks.size - 1

    def height(self, x):
        """f(x)."""
        return np.asarray(self.indenter.height(x), float)

    def slope(self, x, side):
        """f'(x), at corners and ends on this side (±1) of them."""
        if np.ndim(x) == 0:  # quicker than for arrays
            near = bisect.bisect_left(self._kinks, x - self._aside)
            kink = self._kinks[min(near, self._last)]
            beside = kink + 2 * side * self._aside
            place = beside if abs(x - kink) <= self._aside else x
            return np.asarray(self.indenter.slope(place), float)
        x = np.asarray(x, float)
        near = np.searchsorted(self._kinks, x - self._aside)
        kink = self._kinks[np.minimum(near, self._last)]
        beside = kink + 2 * side * self._aside
        place = np.where(np.abs(x - kink) <= self._aside, beside, x)
        return np.asarray(self.indenter.slope(place), float)

    def between(self, low, high):
        """Nodes strictly inside."""
        first = np.searchsorted(self.nodes, low, side="right")
        return self.nodes[first : np.searchsorted(self.nodes, high, side="left")]

    @functools.cached_property
    def extremes(self):
        """All x at which f is least or largest among its neighbours, refined, in order."""
        x = self.nodes
        f = self.heights
        dips = [at for at, _ in refined_minima(self.height, x, f, math.inf)]
        tops = [at for at, _ in refined_minima(lambda s: -self.height(s), x, -f, math.inf)]
        return np.unique(dips + tops)

    @functools.cached_property
    def monotone(self):
        """Places between which f rises or falls, and f there."""
        x = np.union1d(self.nodes, self.extremes)
        return x, self.height(x)

    def lowest(self, tie):
        """min f and all x where f is that to within `tie`."""
        below = self.heights.min() + tie
        minima = list(refined_minima(self.height, self.nodes, self.heights, below))
        least = min(value for _, value in minima)
        return least, sorted(x for x, value in minima if value <= least + tie)


def refined_minima(function, x, values, below, ends=(math.inf, math.inf)):
    """Local minima (x, value) of a function sampled at x that may be less than `below`, refined.

    A dip between three nodes is left out where it would have to be deeper below its least sample
    than the steps to these and the next ones are high. ends: values beyond the first and last node.
    """
    padded = np.concatenate([ends[:1], values, ends[1:]])
    not_above_left = padded[1:-1] <= padded[:-2]
    not_above_right = padded[1:-1] <= padded[2:]
    dips = np.flatnonzero(not_above_left & not_above_right)
    with np.errstate(invalid="ignore"):
        rise = np.diff(padded)
    steps = np.where(np.isfinite(rise), np.abs(rise), 0.0)
    steps = np.pad(steps, 1)  # those from node i - 2 to i + 2 are at i ... i + 3
    deepest = np.max([steps[dips + i] for i in range(4)], axis=0)
    dips = dips[values[dips] - deepest <= below]
    if not dips.size:
        return []
    left = x[np.maximum(dips - 1, 0)]
    right = x[np.minimum(dips + 1, x.size - 1)]
    return refined(function, left, x[dips], right, values[dips])


def refined(function, low, middle, high, value):
    """Least points between three nodes each, [(x, value)], by many places between neighbours."""
    at = middle
    least = value
    places = np.linspace(0.0, 1.0, PLACES)
    rows = np.arange(low.size)
    for _ in range(ROUNDS):
        x = low[:, None] + (high - low)[:, None] * places
        values = function(x.ravel()).reshape(x.shape)
        i = values.argmin(axis=1)
        lower = values[rows, i] < least
        at = np.where(lower, x[rows, i], at)
        least = np.where(lower, values[rows, i], least)
        low = x[rows, np.maximum(i - 1, 0)]
        high = x[rows, np.minimum(i + 1, PLACES - 1)]
    return list(zip(at.tolist(), least.tolist(), strict=True))


class Surfaces:
    """The free surfaces of a scene over its ground, at any depth."""

    def __init__(self, ground, surface, tie):
        self.ground = ground
        self.surface = surface
        self.tie = tie

    def tilt_facing(self, other, depth):
        """tilt(x): outward, of the free surface at a line at x that faces `other`, or nothing."""
        if other is None:
            return lambda x: self.surface.tail(depth - self.ground.height(x))
        held = depth - float(self.ground.height(other))

        def tilt(x):
            width = np.maximum(np.abs(other - x), 1e-300)
            return self.surface.facing(depth - self.ground.height(x), held, width)

        return tilt

    def v(self, x, left, right, depth):
        """u - g of the free surface between two lines, -inf and inf where there is none."""
        lines = [line for line in (left, right) if math.isfinite(line)]
        g = [depth - float(self.ground.height(line)) for line in lines]
        if len(g) == 2:
            u = self.surface.gap_shape(x - left, right - left, *g)
        elif g:
            u = self.surface.tail_shape(x - left if math.isfinite(left) else right - x, *g)
        else:
            u = np.zeros_like(x)
        return u - (depth - self.ground.height(x))

    def dips(self, left, right, depth):
        """(v, x) at the minima of v between two lines where it may be negative."""
        x = self._within(left, right)
        if not x.size:
            return
        ends = tuple(-math.inf if math.isfinite(line) else math.inf for line in (left, right))

        def v(place):
            return self.v(place, left, right, depth)

        for place, value in refined_minima(v, x, v(x), -self.tie, ends):
            if min(place - left, right - place) > BESIDE * self.ground.feature:
                yield value, place

    def _within(self, left, right):
        """Nodes of a free surface, clustered at its lines."""
        step = self.ground.step
        ground = self.ground
        parts = [ground.between(left, right)]
        if math.isfinite(left):
            parts.append(left + step * CLUSTER)
        if math.isfinite(right):
            parts.append(right - step * CLUSTER)
        x = np.unique(np.concatenate(parts))
        return x[(x > left) & (x < right) & (x >= ground.lo) & (x <= ground.hi)]


def first_rest(drive, start, limit, meets, ground):
    """First rest of a line moving from start towards limit, and whether it met the limit.

    drive(x, ahead) >= 0: the line does not move on from x, with the profile's slope ahead of it
    (+1) or behind it (-1). Where there is nothing to meet, at the end of the profile, a line rests.
    A line that rests farther than a feature away is returned where it is by then.
    """
    here = float(drive(start, 1))
    if here >= 0:
        return start, False
    x, ahead = _places(start, limit, meets, ground)
    if not x.size:
        return limit, meets
    values = drive(x, ahead)
    rests = values >= 0
    stop = int(np.argmax(rests)) if rests.any() else values.size
    hump = _hump(drive, x, values[:stop])
    if hump is not None:
        return hump, False
    if stop < values.size:
        before = (float(x[stop - 1]), float(values[stop - 1])) if stop else (start, here)
        beyond = (float(x[stop]), float(values[stop]))
        if before[0] == beyond[0]:  # a corner holds it
            return before[0], False
        return _root(drive, before, beyond), False
    if abs(limit - start) > ground.feature:
        return float(x[-1]), False
    return limit, meets


def _places(start, limit, meets, ground):
    """Places on the way up to a feature away, (x, ±1): at a corner first behind it, then ahead."""
    low = min(start, limit)
    high = max(start, limit)
    move = 1 if limit > start else -1
    reach = min(high - low, ground.feature)
    parts = [ground.between(*sorted((start, start + move * reach)))]
    parts.append(start + move * ground.step * CLUSTER)
    if meets:
        near = np.concatenate([MET * ground.feature * np.ones(1), ground.step * CLUSTER])
        parts.append(limit - move * near)
    elif reach == high - low:
        parts.append(np.array([limit]))
    x = np.concatenate(parts)
    x = x[(x >= low) & (x <= high) & (x != start) & (np.abs(x - start) <= reach)]
    if meets:
        x = x[np.abs(limit - x) >= 0.999 * MET * ground.feature]
    x = np.unique(x)[::move]
    twice = 1 + (np.isin(x, ground.corners) & (x != limit))
    x = np.repeat(x, twice)
    ahead = -np.ones(twice.sum())
    ahead[1:][x[1:] == x[:-1]] = 1.0
    return x, ahead


def _root(drive, low, high):
    """Where drive vanishes between two (place, value) without a corner in between."""
    known = dict((low, high))
    if low[1] >= 0:
        return low[0]
    if high[1] <= 0:
        return high[0]

    def value(x):
        return known[x] if x in known else float(drive(x, 1))

    size = max(abs(low[0]), abs(high[0]))
    return brentq(value, low[0], high[0], xtol=1e-17 * size, rtol=1e-15)


def _hump(drive, x, values):
    """A rest between places at all of which the line would move on: drive has a maximum there."""
    if values.size < 3:
        return None
    middle = values[1:-1]
    tops = np.flatnonzero((middle >= values[:-2]) & (middle >= values[2:])) + 1
    for j in tops.tolist():
        rise = np.abs(np.diff(values[max(j - 2, 0) : j + 3])).max()  # places are not evenly spaced
        if values[j] + rise < 0 or x[j - 1] == x[j] or x[j + 1] == x[j]:
            continue
        three = np.sort(x[j - 1 : j + 2])[:, None]
        ((at, value),) = refined(lambda at: -drive(at, -1), *three, -values[j : j + 1])
        if value <= 0:
            return _root(drive, (float(x[j - 1]), float(values[j - 1])), (at, -value))
    return None
