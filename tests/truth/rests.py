"""The first resting place of a contact line on its way, and where a free surface touches."""

import math

import numpy as np
from scipy.optimize import brentq

from .ground import refined, refined_minima

MET = 1e-9  # of the feature: lines closer than that have met
BESIDE = 1e-5  # of the feature: nearer to a line, it is the line that moves
CLUSTER = 0.5 ** np.arange(40.0, 0.0, -1.0)  # nodes that approach a line, in steps of the ground


class Surfaces:
    """The free surfaces of a scene over its ground, at any depth."""

    def __init__(self, ground, surface, tie):
        self.ground, self.surface, self.tie = ground, surface, tie

    def tilt(self, x, other, depth):
        """Outward tilt of the free surface at a line put at x that faces `other`, or nothing."""
        g = depth - self.ground.height(x)
        if other is None:
            return self.surface.tail(g)
        width = np.maximum(np.abs(other - x), 1e-300)
        return self.surface.facing(g, depth - float(self.ground.height(other)), width)

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
        v = self.v(x, left, right, depth)
        for at, value in refined_minima(
            lambda at: self.v(np.asarray(at), left, right, depth), x, v, -self.tie, ends
        ):
            if min(at - left, right - at) > BESIDE * self.ground.feature:
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


def first_rest(drive, start, limit, meets, ground):
    """First rest of a line moving from start towards limit, and whether it met the limit.

    drive(x, ahead) >= 0: the line does not move on from x, with the profile's slope ahead of it
    (+1) or behind it (-1). Where there is nothing to meet, at the end of the profile, a line rests.
    A line that rests farther than a feature away is returned where it is by then.
    """
    if float(drive(start, 1)) >= 0:
        return start, False
    x, ahead = _places(start, limit, meets, ground)
    if not x.size:
        return limit, meets
    values = drive(x, ahead)
    stop = int(np.argmax(values >= 0)) if (values >= 0).any() else values.size
    hump = _hump(drive, x, values[:stop])
    if hump is not None:
        return hump, False
    if stop < values.size:
        before = float(x[stop - 1]) if stop else start
        if before == x[stop]:  # a corner holds it
            return before, False
        return _root(drive, before, float(x[stop])), False
    if abs(limit - start) > ground.feature:
        return float(x[-1]), False
    return limit, meets


def _places(start, limit, meets, ground):
    """Places on the way up to a feature away, (x, ±1): at a corner first behind it, then ahead."""
    low, high = min(start, limit), max(start, limit)
    move, reach = 1 if limit > start else -1, min(high - low, ground.feature)
    parts = [ground.between(*sorted((start, start + move * reach)))]
    parts.append(start + move * ground.step * CLUSTER)
    if meets:
        near = np.concatenate([MET * ground.feature * np.ones(1), ground.step * CLUSTER])
        parts.append(limit - move * near)
    elif reach == high - low:
        parts.append(np.array([limit]))
    x = np.unique(np.concatenate(parts))
    x = x[(x >= low) & (x <= high) & (x != start) & (np.abs(x - start) <= reach)]
    if meets:
        x = x[np.abs(limit - x) >= 0.999 * MET * ground.feature]
    corner = np.isin(x, ground.corners) & (x != limit)
    x = np.concatenate([x, x[corner]])
    ahead = np.concatenate([-np.ones(corner.size), np.ones(int(corner.sum()))])
    order = np.lexsort((ahead, move * x))
    return x[order], ahead[order]


def _root(drive, low, high):
    """Where drive vanishes between two places without a corner in between."""
    if float(drive(low, 1)) >= 0:
        return low
    if float(drive(high, -1)) <= 0:
        return high
    size = max(abs(low), abs(high))
    return brentq(
        lambda x: float(drive(x, -1 if x == high else 1)), low, high, xtol=1e-17 * size, rtol=1e-15
    )


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
        low, top, high = sorted(x[j - 1 : j + 2].tolist())
        at, value = refined(lambda at: -drive(at, -1), low, top, high, -values[j])
        if value <= 0:
            return _root(drive, float(x[j - 1]), at)
    return None


ASIDE = 4e-15  # of the places: to which side of an edge


def breaks(scene):
    """Where the work of adhesion changes."""
    return () if scene.pattern is None else scene.pattern.edges


class Adhesion:
    """The deficit at which a line rests: √(2w/γ₁), with finite slopes 2 asin √(w/(2γ₁))."""

    def __init__(self, scene, ground):
        self.gamma1, self.finite = scene.gamma1, scene.slopes == "finite"
        self.works = {+1: scene.work_of_adhesion, -1: scene.opened.work_of_adhesion}
        self.pattern, self._aside = scene.pattern, ASIDE * max(abs(ground.lo), abs(ground.hi))

    def deficit(self, x, toward, way):
        """Of a line at x that would move to this side (±1), outwards (way = 1) or inwards (-1)."""
        w = self.works[way]
        if self.pattern is not None:
            w = w * self.pattern.factor(np.asarray(x, float) + self._aside * toward)
        half = np.sqrt(w / (2 * self.gamma1))
        return 2 * np.arcsin(half) if self.finite else 2 * half
