"""Where the free surfaces of the fitted mesh touch the profile (small slopes)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted import gap
from discretization.fitted.response import Response
from energy import Scene

Array = NDArray[np.float64]
_PLACES = 33
_RESOLVED = 1e-8


@dataclass(frozen=True, eq=False)
class Clearance:
    """v = u - g of the free surface between two lines, infinite where there is none.

    points (n,): where v is sampled, and refined in between; heights: f there.
    """

    scene: Scene
    response: Response
    points: Array
    heights: Array

    def lowest(self) -> float:
        """The least height of the profile."""
        level = float(self.heights.min())
        found = (v for _, v in self.minima(-math.inf, math.inf, level, math.inf))
        return level + min(0.0, *found)

    def touching(self, left: float, right: float, depth: float, tie: float) -> tuple[float, ...]:
        """Where a free surface touches the profile."""
        return tuple(x for x, v in self.minima(left, right, depth, tie) if v < tie)

    def minima(
        self, left: float, right: float, depth: float, tie: float
    ) -> Iterator[tuple[float, float]]:
        """Minima of v = u - g of a free surface: those that may be less than `tie`, refined."""
        lo = int(np.searchsorted(self.points, left, side="right"))
        hi = int(np.searchsorted(self.points, right, side="left"))
        if lo >= hi:
            return
        x = self.points[lo:hi]
        v = self._v(x, self.heights[lo:hi], left, right, depth)
        beside = np.r_[_beyond(left), v, _beyond(right)]
        least = (v <= beside[:-2]) & (v <= beside[2:])
        change = [np.abs(v - near) for near in (beside[:-2], beside[2:])]
        apart = np.max(np.where(np.isfinite(change), change, 0.0), axis=0)
        near = np.r_[max(left, x[0]), x, min(right, x[-1])]
        for i in np.flatnonzero(least & (v - apart < tie)).tolist():
            yield self._refined(near[i : i + 3], left, right, depth)

    def _refined(self, x: Array, left: float, right: float, depth: float) -> tuple[float, float]:
        """The minimum between three points, by many between the neighbours of the least."""
        height, (lo, hi) = self.scene.indenter.height, (float(x[0]), float(x[-1]))
        least = _RESOLVED * (hi - lo)
        while True:
            v = self._v(x, np.asarray(height(x), float), left, right, depth)
            i = int(np.argmin(v))
            if hi - lo <= least:
                return float(x[i]), float(v[i])
            lo, hi = float(x[max(i - 1, 0)]), float(x[min(i + 1, x.size - 1)])
            x = np.union1d(np.linspace(lo, hi, _PLACES), x[i])

    def _v(self, x: Array, f: Array, left: float, right: float, depth: float) -> Array:
        """u - g at points between two lines, infinite where there is none."""
        scene, response = self.scene, self.response
        length, height = scene.elastocapillary_length, scene.indenter.height
        g = [depth - float(height(line)) if math.isfinite(line) else 0.0 for line in (left, right)]
        u = np.zeros_like(x)
        if math.isfinite(left) and math.isfinite(right):
            at = (x - left) / length, (right - x) / length
            u = gap.displacement(response.degree, *at, (right - left) / length, *g)
        elif math.isfinite(left):
            u = g[0] * response.surface(1.0).displacement((x - left) / length)
        elif math.isfinite(right):
            u = g[1] * response.surface(1.0).displacement((right - x) / length)
        return np.asarray(u - depth + f)


def _beyond(line: float) -> float:
    """v where a free surface ends: at a contact line, or nowhere."""
    return math.inf if math.isinf(line) else 0.0
