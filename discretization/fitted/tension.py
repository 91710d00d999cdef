"""Where a profile in contact would pull at the surface: -g - l² f'' > 0, around an axis (r f')'/r.

With finite slopes it is f'/√(1+f'²) for f'. Without adhesion nothing holds the surface there, and a
gap opens. Between two lines v = u - g obeys l² v'' = v + g + l² f'' with v = v' = 0 at both, so
there is no gap where nothing pulls, and one around every place that does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.profile import Resolved
from discretization.rounding import EPSILON
from energy import Scene

Array = NDArray[np.float64]
_PARTS = 8  # of an interval between samples, of each of which the mean pull is taken
_CLOSER = 2  # times the parts around the largest pull are taken apart again
_SHORT = 1e-9  # of l: in shorter intervals f' is not known well enough
_ROUNDING = 4 * EPSILON  # of slopes


class Pull(NamedTuple):
    """The largest pull of a part of the contact over k [length], and both ends of where it pulls.

    Beyond what may be rounding of f'; ends: nan if nothing pulls.
    """

    worst: float
    ends: tuple[float, float]


class _Parts(NamedTuple):
    """Intervals of the contact (n,): ends, and f' at them, inside."""

    lo: Array
    hi: Array
    one: Array
    other: Array

    def among(self, keep: slice | NDArray[np.bool_]) -> _Parts:
        """Some of them."""
        return _Parts(*(column[keep] for column in self))


def pull(scene: Scene, profile: Resolved, one: float, other: float, depth: float) -> Pull:
    """The largest pull in contact between two positions, in either order."""
    length, ends = scene.elastocapillary_length, (math.nan, math.nan)
    lo, hi = sorted((one, other))
    own, worst = profile.beyond(lo, hi), -math.inf
    x = np.concatenate([[lo], profile.x[own], [hi]])
    inner = profile.slope[own]
    left = np.concatenate([[profile.at(lo, 1)[1]], inner])
    right = np.concatenate([inner, [profile.at(hi, -1)[1]]])
    parts = _Parts(x[:-1], x[1:], left, right)
    parts = parts.among(parts.hi - parts.lo > _SHORT * length)
    for _ in range(1 + _CLOSER if parts.lo.size else 0):
        parts = _halved(profile, parts)
        pulls = _pulls(scene, profile, parts, depth)
        i = int(np.argmax(pulls))
        if pulls[i] > 0 >= worst:
            stays = np.flatnonzero(pulls <= 0)
            first, last = np.searchsorted(stays, i), stays.size
            begin = stays[first - 1] + 1 if first else 0
            end = stays[first] - 1 if first < last else -1
            ends = float(parts.lo[begin]), float(parts.hi[end])
        worst = max(worst, float(pulls[i]))
        parts = parts.among(slice(max(i - 1, 0), i + 2))
    return Pull(max(worst, 0.0), ends)


def _halved(profile: Resolved, parts: _Parts) -> _Parts:
    """Every interval in _PARTS."""
    t = np.arange(_PARTS + 1) / _PARTS
    x = parts.lo[:, None] + (parts.hi - parts.lo)[:, None] * t
    x[:, -1] = parts.hi
    slope = np.asarray(profile.indenter.slope(x.ravel()), float).reshape(x.shape)
    slope[:, 0], slope[:, -1] = parts.one, parts.other
    return _Parts(
        *(column.ravel() for column in (x[:, :-1], x[:, 1:], slope[:, :-1], slope[:, 1:]))
    )


def _pulls(scene: Scene, profile: Resolved, parts: _Parts, depth: float) -> Array:
    """The mean pull of every interval, less what may be rounding."""
    width, height = parts.hi - parts.lo, profile.indenter.height
    f = (height(parts.lo) + height(parts.hi)) / 2 - width * (parts.other - parts.one) / 12
    one, other = parts.one, parts.other
    if scene.slopes == "finite":
        one, other = (slope / np.sqrt(1 + slope * slope) for slope in (one, other))
    one, other = one * scene.measure(parts.lo), other * scene.measure(parts.hi)
    noise = _ROUNDING * (np.abs(one) + np.abs(other))
    bend = (other - one + noise) / (width * scene.measure((parts.lo + parts.hi) / 2))
    return np.asarray(f - depth - scene.elastocapillary_length**2 * bend)
