"""Where the free surfaces of the fitted mesh come closest to the profile."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.profile import Resolved
from discretization.roots import bracketed
from discretization.surfaces.protocol import At, Surfaces

Array = NDArray[np.float64]
_UNSURE = 1 / 16  # of the width of an interval and of how v' varies in it

_HIGHER = 1 / 16  # of δ₀


@dataclass(frozen=True, eq=False)
class Clearance:
    """The gap v = u - g of free surfaces above a resolved profile."""

    profile: Resolved
    surfaces: Surfaces

    def least(self, left: At | None, right: At | None, depth: float) -> tuple[float, float]:
        """The least v between two lines, and where; a line that is None is infinitely far away.

        Read where it is negative at samples; between two of them, where v' changes sign, at the
        minimum of the cubic through v and v'. The least of all these is solved for, unless its sign
        is certain. Towards a line v vanishes: that is no minimum, ∞.
        """
        z, f, slope = self._near(left, right, depth)
        if not z.size:
            return math.inf, math.nan
        u, u1 = self.surfaces.shape(z, left, right, depth)
        v, v1 = u - depth + f, u1 + slope
        i = int(np.argmin(v))
        best, place = (float(v[i]), float(z[i])) if v[i] < 0 else (math.inf, math.nan)
        dips = np.flatnonzero((v1[:-1] < 0) & (v1[1:] > 0))
        if dips.size:
            low, unsure = _dips(z, v, v1, dips)
            j = int(np.argmin(low))
            if low[j] < best:
                i = int(dips[j])
                if abs(low[j]) <= unsure[j]:
                    return self._bottom(left, right, depth, *z[i : i + 2].tolist())
                return float(low[j]), float(z[i] + v1[i] / (v1[i] - v1[i + 1]) * (z[i + 1] - z[i]))
        return best, place

    def _near(self, left: At | None, right: At | None, depth: float) -> Array:
        """x, f and f' of the samples between two lines that are low: v >= f - max(d, f_line).

        And of those a little higher, so that the least v changes with the depth without a jump.
        """
        ends = [
            line.x if line is not None else end * math.inf for end, line in ((-1, left), (1, right))
        ]
        own = self.profile.beyond(*ends)
        f = self.profile.f[own]
        top = max([depth, *(line.f for line in (left, right) if line is not None)])
        low = f <= top + _HIGHER * self.surfaces.scene.opened.critical_separation
        kept = low.copy()
        kept[1:] |= low[:-1]
        kept[:-1] |= low[1:]
        return np.array([self.profile.x[own][kept], f[kept], self.profile.slope[own][kept]])

    def _bottom(
        self,
        left: At | None,
        right: At | None,
        depth: float,
        start: float,
        end: float,
    ) -> tuple[float, float]:
        """The minimum between two samples, as v and its place."""
        indenter = self.profile.indenter

        def inclined(z: float) -> float:
            return float(
                self.surfaces.shape(np.array(z), left, right, depth)[1] + indenter.slope(z)
            )

        place = bracketed(inclined, start, end)
        u = float(self.surfaces.shape(np.array(place), left, right, depth)[0])
        return u - depth + float(indenter.height(place)), place


def _dips(z: Array, v: Array, v1: Array, at: NDArray[np.intp]) -> tuple[Array, Array]:
    """The least v of the cubics between samples `at` and the next, and how far it may be off."""
    width, fall, rise = z[at + 1] - z[at], -v1[at], v1[at + 1]
    t = fall / (fall + rise)
    t2, t3 = t * t, t * t * t
    low = v[at] * (2 * t3 - 3 * t2 + 1) + v[at + 1] * (3 * t2 - 2 * t3)
    low += width * (rise * (t3 - t2) - fall * (t3 - 2 * t2 + t))
    return low, _UNSURE * width * (fall + rise)
