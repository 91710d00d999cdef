"""The profile resolved on its own scale: samples between which nothing happens unseen.

An indenter is given by two functions, f(x) and f'(x). Before anything is looked for on it, it is
sampled until the cubic through heights and slopes of neighbouring samples predicts the slope in
between to a part of what a contact line notices, √(2w/γ₁), or of how the slope varies there:

    |f'(x) - cubic'(x)| <= max(√(2w/γ₁)/64, range of f'/256),    at two points of every interval,

and until the slope in between is hardly steeper or flatter than at both samples. Corners are kept
twice, with the slope on either side, and the local extremes of f are samples, too.
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from discretization.certificate import AccuracyWarning
from discretization.roots import crossings, minima
from energy import Indenter, Scene
from energy.arrays import Array, Indices, Mask
from energy.axis import Radial

MOST = 200_000  # samples
LOOKS = 8  # times a profile is resolved again around what quadrature has found between its samples
_FIRST = 512  # samples of the first pass
_TESTS = (0.381966, 0.723607)  # irrational parts of an interval: no period falls on both
_PART = 1 / 64  # of √(2w/γ₁), which a slope must change by for a contact line to notice
_OF_RANGE = 1 / 256  # of how much the slope varies within an interval
_HIDDEN = 4.0  # times what samples resolve: more in between is a feature that they have missed,
_LONE = 16.0  # or so many times what the cubic is off by at both tests, if a contact line or an
_SLIGHT = 1e-3  # energy notices: of √(2w/γ₁), or without adhesion of the steepest slope
_NOISE = 1e-12  # of the steepest slope, and of an interval: they are not known better
_NAMED = 5  # places in a warning
_FINEST = 1e-10  # of the window: intervals that short are not halved again, they hold a kink
_ROUNDS = 48  # of halving, more than _FINEST allows
_MARGIN = 0.125  # of δ₀ and of the depth, by which an endless profile is followed higher
_WINDOW = 64.0  # elastocapillary lengths, the first half window of an endless profile
_WIDEST = 2.0**34  # first half windows: an endless profile that has not risen by then falls
BEFORE_VERTICAL = 1 - 2.0**-20  # of where a profile turns over: as far as it is known


@dataclass(frozen=True, eq=False)
class Resolved:
    """Samples of a profile in increasing order (n,): x, heights f, slopes.

    A corner stands twice: first with the slope on its left, then with that on its right. touch:
    the least height, at x = lowest; edges: of a pattern, on either side of which there is a sample.
    """

    indenter: Indenter
    x: Array
    f: Array
    slope: Array
    edges: Array

    @classmethod
    def of(cls, indenter: Indenter, x: Array, edges: ArrayLike = ()) -> Resolved:
        """With samples at these places, increasing, the corners among them."""
        corners, edges = (np.asarray(part, float) for part in (indenter.corners, edges))
        inner = corners[(corners > x[0]) & (corners < x[-1])]
        x = np.repeat(x, 1 + np.isin(x, inner))
        twice = x[1:] == x[:-1]
        f, slope = _read(indenter, x, np.append(1, twice) - np.append(twice, 1))
        kept = np.append(True, ~twice | (slope[1:] != slope[:-1]))
        return cls(indenter, x[kept], f[kept], slope[kept], edges)

    touch = functools.cached_property(lambda self: float(self.f.min()))
    lowest = functools.cached_property(lambda self: float(self.x[int(np.argmin(self.f))]))

    def beyond(self, start: float, limit: float) -> slice:
        """Samples strictly between two positions, increasing."""
        lo = int(np.searchsorted(self.x, min(start, limit), side="right"))
        hi = int(np.searchsorted(self.x, max(start, limit), side="left"))
        return slice(lo, max(lo, hi))

    def past(self, x: Any, side: Any) -> Any:
        """x just on this side of a pattern's edge, where adhesion is that of the next patch.

        Positions are otherwise left as they are: next to another line every rounding is felt.
        """
        if not self.edges.size:
            return x
        at_edge = np.isin(x, self.edges) | np.isin(np.nextafter(x, math.inf), self.edges)
        found = np.where(at_edge, np.nextafter(x, np.copysign(math.inf, side)), x)
        return found if np.ndim(x) else float(found)

    def beside(self, x: Array, side: Any) -> tuple[Array, Array]:
        """f and f' at x of any shape; the slope of a corner is that on this side (1: right)."""
        f = np.asarray(self.indenter.height(x), float)
        slope = np.asarray(self.indenter.slope(x), float)
        if not len(self.indenter.corners):
            return f, slope
        right, left = np.searchsorted(self.x, x, side="right") - 1, np.searchsorted(self.x, x)
        i = np.clip(np.where(np.greater(side, 0), right, left), 0, self.x.size - 1)
        known = self.x[i] == x
        return np.where(known, self.f[i], f), np.where(known, self.slope[i], slope)

    @functools.cached_property
    def corners(self) -> Array:
        """x of the corners in the window."""
        return self.x[1:][self.x[1:] == self.x[:-1]]

    @functools.cached_property
    def joints(self) -> Array:
        """Where D may jump: the corners and a pattern's edges, with the ends of the window."""
        ends, known = self.x[[0, -1]], np.append(self.corners, self.edges)
        inside = known[(known > ends[0]) & (known < ends[1])]
        return np.unique(np.append(ends, inside)) if inside.size else ends

    def hidden(self, scene: Scene, x: Array) -> Array:
        """The place in each interval between samples where a feature shows that they have missed.

        x: places at which quadrature has looked closer. There the cubic must predict the slope as
        it does at the tests of every interval, or nearly so.
        """
        i = np.clip(np.searchsorted(self.x, x, "right") - 1, 0, self.x.size - 2)
        inside = (self.x[i] < x) & (x < self.x[i + 1])
        i, x = i[inside], x[inside]
        if not x.size:
            return x
        steep = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1) if scene.gamma1 else 0.0
        steep = steep or float(np.abs(self.slope).max())
        places = self.x[i] + np.array(_TESTS)[:, None] * (self.x[i + 1] - self.x[i])
        z = np.vstack([x, places])
        slope = np.asarray(self.indenter.slope(z), float)
        off = np.abs(slope - self._cubic_slope(i, z))
        seen = np.vstack([slope[1:], self.slope[i], self.slope[i + 1]])
        resolved = np.maximum(_PART * steep, _OF_RANGE * np.ptp(seen, axis=0))
        missed = (off[0] > _HIDDEN * resolved) | (off[0] > _LONE * off[1:].max(axis=0))
        missed &= off[0] > _SLIGHT * steep
        found, off = x[missed], off[0][missed]
        order = np.lexsort((off, i[missed]))
        last = np.append(np.diff(i[missed][order]) > 0, True)[: order.size]
        return found[order][last]

    def _cubic_slope(self, i: Indices, x: Array) -> Array:
        """f' at x of the cubic through heights and slopes at the samples i and i + 1."""
        width, low, high = self.x[i + 1] - self.x[i], self.slope[i], self.slope[i + 1]
        secant, t = (self.f[i + 1] - self.f[i]) / width, (x - self.x[i]) / width
        a, b = 3 * (low + high - 2 * secant), 6 * secant - 4 * low - 2 * high
        return np.asarray(low + t * (b + a * t))

    def falls(self, slopes: str) -> Array:
        """By how much the slope falls at the corners; for finite slopes the inclination [rad]."""
        at = np.flatnonzero(np.diff(self.x) == 0)
        one, other = self.slope[at], self.slope[at + 1]
        return np.asarray(np.arctan(one) - np.arctan(other) if slopes == "finite" else one - other)


def warn_hidden(places: Array, stacklevel: int) -> None:
    """AccuracyWarning of features that quadrature has found between the samples."""
    named = ", ".join(f"{x!r}" for x in places[:_NAMED].tolist())
    warnings.warn(
        f"the profile has a feature near x = {named} that is narrower than its samples: it was "
        "only found by chance, and another depth, or a path in place of a state, may miss it; give "
        "Profile(..., knots=(x, ...)) with its place",
        AccuracyWarning,
        stacklevel=stacklevel + 1,
    )


def resolve(scene: Scene, depth: float, places: ArrayLike = ()) -> Resolved:
    """The profile of a scene; of an endless one what may be in contact at depths up to this one.

    places: where it is sampled besides, as it has a narrow feature there.

    AccuracyWarning where MOST samples do not resolve it; ValueError for a profile without a lowest
    point, or with heights that are not finite.
    """
    indenter = Radial(scene.indenter) if scene.axisymmetric else scene.indenter
    edges = np.array(scene.pattern.edges if scene.pattern is not None else (), float)
    size = scene.elastocapillary_length or scene.critical_separation or scene.layer.h
    lo, hi = window(indenter, depth, _WINDOW * size, scene.opened.critical_separation)
    known = np.concatenate([indenter.breaks(), edges, np.nextafter(edges, -math.inf), places])
    cuts = np.unique(np.concatenate([[lo, hi], known[(known > lo) & (known < hi)]]))
    x, resolved = _refined(scene, indenter, cuts)
    if not resolved:
        warnings.warn(
            f"the profile varies on less than {float(np.diff(x).min())!r}, which {MOST} samples do "
            "not resolve: contacts may be missed; smooth the profile, or limit its extent",
            AccuracyWarning,
            stacklevel=4,
        )
    extremes = _extremes(Resolved.of(indenter, x, edges))
    return Resolved.of(indenter, np.sort(np.append(x, extremes)), edges)


def window(indenter: Indenter, depth: float, half: float, reach: float) -> tuple[float, float]:
    """Where contact is possible: the extent, or as far as the profile is low around x = 0.

    half: the first half width that is tried; reach: how far above the depth, or first touch, a
    contact is held. An end at which the profile turns over is left out.
    """
    with np.errstate(divide="ignore"):
        turned = [math.isfinite(x) and bool(np.isinf(indenter.slope(x))) for x in indenter.extent]
    lo, hi = np.where(turned, BEFORE_VERTICAL * np.array(indenter.extent), indenter.extent).tolist()
    if math.isfinite(lo) and math.isfinite(hi):
        return lo, hi
    start, widest = min(max(0.0, lo), hi), _WIDEST * half
    while half <= widest:
        ends = max(lo, start - half), min(hi, start + half)
        x = np.linspace(*ends, 2 * _FIRST + 1)
        f = heights(indenter, x)
        low, touch = float(x[int(np.argmin(f))]), float(f.min())
        top = max(depth, touch)
        level = top + reach + _MARGIN * (reach + top - touch)
        clear = (f[0] > level or ends[0] == lo) and (f[-1] > level or ends[1] == hi)
        if clear and abs(low - start) <= half / 2:
            return ends
        half *= 2
    raise ValueError(
        f"indenter = {indenter!r} has no lowest point within {half!r} of x = {start!r}; give "
        "Profile(..., extent=(lo, hi))"
    )


def heights(indenter: Indenter, x: Array) -> Array:
    """f at x. ValueError unless they are finite."""
    f = np.asarray(indenter.height(x), float)
    if not np.isfinite(f).all():
        bad = float(x[~np.isfinite(f)][0])
        raise ValueError(
            f"indenter.height({bad!r}) is not finite; give a profile that is finite inside its "
            f"extent {indenter.extent}"
        )
    return f


class UnknownProfile(ValueError):
    """Of a contact that spreads to an end of the profile that is not the end of the body."""

    def __init__(self, depth: float, x: float, before: str = "") -> None:
        super().__init__(depth, x, before)
        self.depth = depth
        self.x = x
        self.before = before or f"depth = {depth!r}"

    def __str__(self) -> str:
        return (
            f"{self.before} spreads the contact to x = {self.x!r}, where the profile is not known "
            "any more; give a wider profile, a smaller depth, or add a FlatPunch whose edge ends "
            "the indenter there; a scan may be upside down: turn it over"
        )


def unknown(depth: float, x: float) -> UnknownProfile:
    """Of a contact that spreads at a depth to an end of the known profile."""
    return UnknownProfile(depth, x)


@contextmanager
def on_the_way_to(name: str, *given: float) -> Iterator[None]:
    """Errors of a profile that is not known far enough speak of the depths that were given, too.

    On the way to them other depths are passed, at which a contact may spread by a jump.
    """
    try:
        yield
    except UnknownProfile as error:
        if error.depth in given:
            raise
        values = " to ".join(repr(value) for value in given)
        before = f"{name} = {values} cannot be reached: d = {error.depth:.6g}, on the way there,"
        raise UnknownProfile(error.depth, error.x, before) from None


def past_wall(indenter: Indenter, x: Any, side: Any, aside: Any) -> Mask:
    """Whether lines at x are at the edge of the body, so that there is nothing beside them.

    Their contacts are on the left (side 1) or right (-1); beside is outwards (aside 1) or inwards.
    """
    left, right = (end if end in indenter.walls else math.nan for end in indenter.extent)
    outwards = np.multiply(side, aside)
    return np.equal(x, np.where(outwards > 0, right, left)) & (outwards != 0)


def _refined(scene: Scene, indenter: Indenter, cuts: Array) -> tuple[Array, bool]:
    """x of samples of the pieces between cuts, and whether they resolve them."""
    count = np.maximum(1, np.ceil(np.diff(cuts) / np.ptp(cuts) * _FIRST)).astype(int)
    first = np.repeat(np.cumsum(count) - count, count)
    t = (np.arange(first.size) - first) / np.repeat(count, count)
    x = np.append(np.repeat(cuts[:-1], count) + np.repeat(np.diff(cuts), count) * t, cuts[-1])
    noticed = _PART * math.sqrt(2 * scene.work_of_adhesion / scene.gamma1) if scene.gamma1 else 0.0
    lo, hi, least = x[:-1], x[1:], _FINEST * float(np.ptp(cuts))
    for i in range(_ROUNDS):
        low, high = _read(indenter, lo, 1), _read(indenter, hi, -1)
        if not i:
            noticed = max(noticed, _NOISE * float(np.abs([low[1], high[1]]).max()))
        rough = _unpredicted(indenter, lo, hi, low, high, noticed) & (hi - lo > least)
        lo, hi = lo[rough], hi[rough]
        if not lo.size or x.size + lo.size > MOST:
            break
        middle = (lo + hi) / 2
        x, lo, hi = np.append(x, middle), np.append(lo, middle), np.append(middle, hi)
    return np.sort(x), not lo.size


def _read(indenter: Indenter, x: Array, side: Any) -> Array:
    """f and f' (2, n), the slope at corners on this side of them."""
    corners = np.asarray(indenter.corners, float)
    beside = np.where(np.isin(x, corners), side, 0) if corners.size else 0
    return np.array([heights(indenter, x), indenter.slope_beside(x, beside)])


def _unpredicted(
    indenter: Indenter, lo: Array, hi: Array, low: Array, high: Array, tolerance: float
) -> Mask:
    """Intervals within which the cubic does not predict the slope, or its slope turns round."""
    width, off = hi - lo, np.zeros(lo.size)
    secant = (high[0] - low[0]) / width
    least, most = np.minimum(low[1], high[1]), np.maximum(low[1], high[1])
    a, b = 3 * (low[1] + high[1] - 2 * secant), 6 * secant - 4 * low[1] - 2 * high[1]
    with np.errstate(divide="ignore", invalid="ignore"):  # of low[1] + b t + a t²
        t, turn = -b / (2 * a), low[1] - b * b / (4 * a)
    beyond = np.where((t > 0) & (t < 1), np.maximum(turn - most, least - turn), 0.0)
    turns = beyond > np.maximum(tolerance, _OF_RANGE * np.maximum(most, -least))
    for t in _TESTS:
        slope = np.asarray(indenter.slope(lo + t * width), float)
        off = np.maximum(off, np.abs(slope - (low[1] + t * (b + a * t))))
        least, most = np.minimum(least, slope), np.maximum(most, slope)
    return np.asarray(turns | (off > np.maximum(tolerance, _OF_RANGE * (most - least))))


def _extremes(samples: Resolved) -> Array:
    """The local extremes of f between its samples."""
    found = []
    for sign in (1, -1):
        lo, hi, guess, rise, *_ = minima(samples.x, sign * samples.f, sign * samples.slope)
        own = (lo < hi) & (rise > 0)
        part = lo[own], hi[own], guess[own], sign * rise[own]
        x = crossings(lambda x, _: np.asarray(samples.indenter.slope(x), float), *part, 0.0)
        tie = _NOISE * (part[1] - part[0])  # so near to a sample it is that
        found.append(x[(part[0] + tie < x) & (x < part[1] - tie)])
    return np.concatenate(found)
