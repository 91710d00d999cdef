"""Both lines of a gap on the fitted mesh that advance or recede together (small slopes)."""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from discretization.paths.line_levels import Levels
from discretization.paths.stops import Ground, first_stop

Array = NDArray[np.float64]
Pair = tuple[float, float]
_MET = 1e-9  # of l: lines closer than that have met
_NEAR = 0.5  # of a step
_NEWTON = 12
_SLACK = 1e-15
_DIFFERENCE = 1e-6


@dataclass(frozen=True, eq=False)
class GapMoves:
    """Lines q < p of a gap at rest with each other: p is at rest for every q that is tried."""

    levels: Levels
    ground: Ground

    def towards(self, q: float, p: float, depth: float) -> Pair | None:
        """Both lines of a gap advance; None: they meet."""
        least = _MET * self.levels.scene.elastocapillary_length
        if p - q <= 2 * least:
            return None
        near = self._nearby(q, p, depth, 1)
        if near is not None:
            return near
        facing, ground = self.levels.facing, self.ground
        other = _Facing(
            lambda x, y, aside: facing(-1, y, x, aside) - depth, p, lambda x: x + least, 1, ground
        )

        def excess(x: float, aside: float) -> float:
            y = other.at(x)
            return -math.inf if y is None else facing(1, x, y, aside) - depth

        found = first_stop(excess, q, p - least, ground)
        there = None if found is None else other.at(found)
        return None if found is None or there is None else (found, there)

    def apart(self, q: float, p: float, least: float, most: float, depth: float) -> Pair:
        """Both lines of a gap recede, not beyond the other lines of their contacts."""
        near = self._nearby(q, p, depth, -1)
        if near is not None and near[0] >= least and near[1] <= most:
            return near
        facing, ground = self.levels.facing, self.ground
        other = _Facing(
            lambda x, y, aside: depth - facing(-1, y, x, aside), p, lambda _: most, -1, ground
        )

        def deficit(x: float, aside: float) -> float:
            y = other.at(x)
            return depth - facing(1, x, most if y is None else y, aside)

        x = lower(deficit, q, least, ground)
        y = other.at(x)
        return x, math.nextafter(most, math.inf) if y is None else y

    def _nearby(self, q: float, p: float, depth: float, way: int) -> Pair | None:
        """Both lines of a gap in stable equilibrium close by on this way, by Newton's method.

        None where a corner is near, they are not stable, or it fails.
        """
        ground, most, x = self.ground, _NEAR * self.ground.step, np.array([q, p])
        size = np.abs(x).max() + self.levels.scene.elastocapillary_length
        for _ in range(_NEWTON):
            value, rate = self._levels(x, depth)
            if not (
                rate[0, 0] > 0
                and rate[1, 1] < 0
                and rate[0, 0] * rate[1, 1] < rate[0, 1] * rate[1, 0]
            ):
                return None
            step = np.linalg.solve(rate, value)
            x = x - step
            moved = way * (x - (q, p)) * (1, -1)
            if (moved < -_SLACK * size).any() or (moved > most).any() or x[0] >= x[1]:
                return None
            if np.abs(step).max() <= _SLACK * size:
                break
        else:
            return None
        ends = float(x[0]), float(x[1])
        h = self._stride(min(q, ends[0]), max(p, ends[1]))
        if any(
            ground.between(min(a, b) - h, max(a, b) + h) for a, b in zip((q, p), ends, strict=True)
        ):
            return None
        return ends

    def _stride(self, q: float, p: float) -> float:
        """How far differences look beyond the lines of a gap."""
        return _DIFFERENCE * min(p - q, self.ground.step)

    def _levels(self, x: Array, depth: float) -> tuple[Array, Array]:
        """D - d of both lines of a gap, and its change (rows) with the lines (columns)."""
        facing = self.levels.facing

        def at(q: float, p: float) -> Array:
            return np.array([facing(1, q, p, 0.0), facing(-1, p, q, 0.0)])

        q, p = x.tolist()
        h = self._stride(q, p)
        here = at(q, p)
        rate = np.column_stack([(at(q - h, p) - here) / -h, (at(q, p + h) - here) / h])
        return here - depth, rate


@dataclass(frozen=True, eq=False)
class _Facing:
    """The other line of a gap, at rest for every position of one: it moves on as that one does.

    h(x, y, aside) of the other line at y; start: of y; limit: of y for a position x; way: +1 where
    x grows on its way.
    """

    h: Callable[[float, float, float], float]
    start: float
    limit: Callable[[float], float]
    way: int
    ground: Ground
    seen: dict[float, float | None] = field(default_factory=dict)
    order: list[float] = field(default_factory=list)  # of way·x

    def at(self, x: float) -> float | None:
        """None: there is none before the limit."""
        seen = self.seen
        if x not in seen:
            before = bisect.bisect(self.order, self.way * x)
            near = seen[self.way * self.order[before - 1]] if before else self.start
            self.order.insert(before, self.way * x)
            limit = self.limit(x)
            if near == limit and self.way < 0:
                seen[x] = near
            elif near is None or self.way * (near - limit) <= 0 < self.way:
                seen[x] = None
            else:
                seen[x] = first_stop(lambda y, aside: self.h(x, y, aside), near, limit, self.ground)
        return seen[x]


def lower(h: Callable[[float, float], float], start: float, limit: float, ground: Ground) -> float:
    """Where a receding line rests; just beyond the other line of its contact if nowhere before."""
    if start == limit:
        return start
    found = first_stop(h, start, limit, ground)
    return math.nextafter(limit, math.copysign(math.inf, limit - start)) if found is None else found
