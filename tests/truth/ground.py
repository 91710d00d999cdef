"""The profile as the reference solutions see it: fine nodes, one-sided slopes, refined extremes."""

import bisect
import functools
import math

import numpy as np

PER_FEATURE = 48
MOST = 400_000
PLACES, ROUNDS = 17, 10


class Outside(Exception):
    """A contact line has reached an end of the profile that is not the end of the body."""


class Ground:
    """A profile sampled PER_FEATURE times per `feature`, the shortest length on which it varies.

    breaks: where something else changes at once, seen from both sides like a corner.
    """

    def __init__(self, indenter, feature, breaks=()):
        self.indenter, self.feature = indenter, feature
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
        if np.ndim(x) == 0:
            kink = self._kinks[min(bisect.bisect_left(self._kinks, x - self._aside), self._last)]
            at = kink + 2 * side * self._aside if abs(x - kink) <= self._aside else x
            return np.asarray(self.indenter.slope(at), float)
        x = np.asarray(x, float)
        near = np.searchsorted(self._kinks, x - self._aside)
        kink = self._kinks[np.minimum(near, self._kinks.size - 1)]
        at = np.where(np.abs(x - kink) <= self._aside, kink + 2 * side * self._aside, x)
        return np.asarray(self.indenter.slope(at), float)

    def between(self, low, high):
        """Nodes strictly inside."""
        first = np.searchsorted(self.nodes, low, side="right")
        return self.nodes[first : np.searchsorted(self.nodes, high, side="left")]

    @functools.cached_property
    def extremes(self):
        """All x at which f is least or largest among its neighbours, refined, in order."""
        x, f = self.nodes, self.heights
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
    than the steps to these and the next ones are high, as nodes are not evenly spaced. ends: what
    to take for the values beyond the first and last node.
    """
    padded = np.concatenate([ends[:1], values, ends[1:]])
    dips = np.flatnonzero((padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]))
    with np.errstate(invalid="ignore"):
        rise = np.diff(padded)
    steps = np.where(np.isfinite(rise), np.abs(rise), 0.0)
    steps = np.pad(steps, 1)
    depth = np.max([steps[dips + i] for i in range(4)], axis=0)
    for i, lower in zip(dips.tolist(), depth.tolist(), strict=True):
        if values[i] - lower <= below:
            yield refined(function, x[max(i - 1, 0)], x[i], x[min(i + 1, x.size - 1)], values[i])


def refined(function, low, middle, high, value):
    """Least point between three nodes: (x, value), by many places between the neighbours of it."""
    best, places = (float(middle), float(value)), np.linspace(0.0, 1.0, PLACES)
    for _ in range(ROUNDS):
        x = low + (high - low) * places
        values = function(x)
        i = int(np.argmin(values))
        if values[i] < best[1]:
            best = float(x[i]), float(values[i])
        low, high = x[max(i - 1, 0)], x[min(i + 1, PLACES - 1)]
    return best
