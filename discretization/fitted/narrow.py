"""Narrow gaps, whose lines feel the rounding of the profile.

The tilt of a gap of length L is the rise of the profile over L, and D of its lines varies by
(l/L) times what the tilt does. Heights are rounded by a part of themselves; so where the
slope is smooth between the lines of a narrow gap, the rise is ∫f' dx instead, rounded by a part of
itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import EPSILON
from discretization.profile import Resolved
from discretization.surfaces.protocol import At

Array = NDArray[np.float64]
_NARROW = 1e-2  # of l
_ROUNDED = {False: 16, True: 64}  # roundings of what ties the lines of a gap, and of a ring, whose
# slope on a crest is a small sum of larger terms
_POINTS, _WEIGHTS = (np.asarray(part) for part in np.polynomial.legendre.leggauss(4))


def narrow(profile: Resolved, length: float, q: Any, p: Any) -> NDArray[np.bool_]:
    """Whether lines are close to each other, with at most one sample in between, and no corner."""
    low, high = np.minimum(q, p), np.maximum(q, p)
    found = np.asarray((high - low < _NARROW * length) & (low < high))
    if found.any():
        passed = np.searchsorted(profile.x, high) - np.searchsorted(profile.x, low, "right")
        found &= passed <= 1
    return found


def rise(profile: Resolved, length: float, line: At, facing: At) -> Any:
    """By how much the profile is higher at the facing line."""
    found, near = np.asarray(facing.f - line.f, float), narrow(profile, length, line.x, facing.x)
    if near.any():
        start, end = (part[near] for part in np.broadcast_arrays(line.x, facing.x))
        low, high = np.minimum(start, end), np.maximum(start, end)
        at = np.searchsorted(profile.x, low, "right")
        between = np.clip(profile.x[np.minimum(at, profile.x.size - 1)], low, high)  # a knot
        found[near] = _risen(profile, start, between) + _risen(profile, between, end)
    return found[()]


def _risen(profile: Resolved, start: Array, end: Array) -> Array:
    """∫f' dx (n,)."""
    apart = end - start
    at = start[:, None] + apart[:, None] * (1 + _POINTS) / 2
    slope = np.asarray(profile.indenter.slope(at.ravel()), float).reshape(at.shape)
    return np.asarray(apart * (slope @ _WEIGHTS) / 2)


def noise(profile: Resolved, length: float, size: float, lines: Array, ring: bool) -> Array:
    """What rounding makes of D, of surfaces with lines (.., 2), rings or not; size: of heights."""
    q, p = lines[..., 0], lines[..., 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        steep = length / np.maximum(p - q, 0.0)
    found, near = np.asarray(size * steep**2), narrow(profile, length, q, p)
    if near.any():
        ends = lines[near]
        slope = np.asarray(profile.indenter.slope(ends.ravel()), float).reshape(ends.shape)
        bend = np.abs(np.diff(slope) / np.diff(ends))[..., 0]
        rounded = np.abs(slope).sum(axis=-1) + np.abs(ends).max(axis=-1) * bend
        found[near] = _ROUNDED[ring] * length * rounded * steep[near]
    return np.asarray(EPSILON * found)
