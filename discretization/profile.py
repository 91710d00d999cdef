"""The profile resolved on its own scale: samples between which nothing happens unseen.

An indenter is given by two functions, f(x) and f'(x). Before anything is looked for on it, it is
sampled until the cubic through heights and slopes of neighbouring samples predicts the slope in
between to a part of what a contact line notices, √(2w/γ₁), or of how the slope varies there:

    |f'(x) - cubic'(x)| <= max(√(2w/γ₁)/64, range of f'/256),    at two points of every interval,

and until the slope in between is hardly steeper or flatter than at both samples. Corners are kept
twice, with the slope on either side, and the local extremes of f are samples, too.

Conventions
-----------
The height f is positive upwards, so that the indenter at the depth d is at d - f below the
undeformed surface; depths are positive downwards, and the least height is the depth of first touch.
Positions x increase to the right; about an axis they are radii. Slopes are df/dx. A side is 1 for
what is on the right of a place, -1 for what is on its left. Of an indenter `extent` is where its
profile is known, `walls` those ends of it where the body ends, too, `corners` where f' jumps, and
`breaks()` the corners, knots and apex; `complete` says that it is smooth in between. `scene.opened`
is the scene with the work of adhesion of a contact that opens, the larger one if there are two: its
critical separation δ₀ = √(2w/k) is how far springs are pulled up at most.

`Radial` is the half r >= 0 of a symmetric profile, with a wall at the axis. `slope_beside(x, side)`
is f' just on the right (1) or left (-1) of x, or at x (0). `minima` of a function that is known by
values and slopes at samples have, each, the ends `lo` and `hi` of where it is, equal at a corner,
its place `at`, and its second derivative `bend`. `crossings` finds zeros of many functions between
brackets: `crossings(function, lo, hi, guess, rise, enough)` takes the function of places
and numbers, both ends, the first guesses, its slopes there, and up to which |f| it is zero.

`scene.work_of_adhesion` is w of the surfaces as they come together, the smaller one if there are
two, without the factors of a pattern's patches. A length to begin with is l
(`elastocapillary_length`), δ₀ or the thickness h, the first that is not 0. D(x) is the depth at
which a contact line at x is at rest.
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from discretization.certificate import AccuracyWarning
from discretization.roots import crossings, minima
from energy import Indenter, Scene
from energy.arrays import Array, Indices, Mask
from energy.axis import Radial

MOST = 200_000  # samples at most: arrays of 1.6 MB, so that a path over them takes seconds
# Times at most that a profile is resolved again around what quadrature has found between samples:
# each adds all places that were found, and what is left is named in a warning. Of 420 states under
# parabolas with one to three random spikes, 1e-5 to 1e-2 wide, 360 took one look, 52 two, 8 three.
LOOKS = 8


class SamplingRules(NamedTuple):
    """How closely a profile is sampled.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 28 random states
    and paths as they are to 1e-9: `python -m tests.sensitivity discretization.profile`.

    Attributes
    ----------
    first : int
        Samples of the first pass.
    of_kink : float
        Of √(2w/γ₁), the kink at a contact line: the slope may change by less between samples
        without its noticing.
    of_range : float
        Of how much the slope varies within an interval: what the cubic may be off by there.
    noise : float
        Of the steepest slope, and of an interval: they are not known better.
    finest : float
        Of the window: shorter intervals are not halved again, they hold a kink.
    """

    first: int = 512
    of_kink: float = 1 / 64
    of_range: float = 1 / 256
    noise: float = 1e-12
    finest: float = 1e-10


_SAMPLING = SamplingRules()


# Where the cubic is tested in an interval, as parts of it: (3 - √5)/2 and (5 + √5)/10, which are
# irrational, so that no period of the profile falls on both.
_TESTS = (0.381966, 0.723607)


class MissedFeatures(NamedTuple):
    """When what is found between samples is a feature that they have missed.

    Halved or doubled, each leaves 28 random states and paths as they are to 1e-9: `python -m
    tests.sensitivity discretization.profile`.

    Attributes
    ----------
    over_resolved : float
        Times what samples resolve: a larger error of the cubic is a feature.
    over_tests : float
        Times the error of the cubic at both tests of its interval: a larger one is a feature,
    noticed : float
        if it is more than this part of √(2w/γ₁), or without adhesion of the steepest slope: less is
        felt by no contact line and no energy.
    named : int
        Places that are named in a warning.
    """

    over_resolved: float = 4.0
    over_tests: float = 16.0
    noticed: float = 1e-3
    named: int = 5


_MISSED = MissedFeatures()


class EndlessProfile(NamedTuple):
    """How far a profile without ends is followed.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 28 random states
    and paths as they are to 1e-9: `python -m tests.sensitivity discretization.profile`.

    Attributes
    ----------
    margin : float
        Of δ₀ and of the depth of indentation: by how much it has to be higher than contact is
        possible at both ends.
    window : float
        Half-width of the first window, in elastocapillary lengths.
    widest : float
        Largest half-width over the first one: a profile that has not risen by then falls for ever.
    """

    margin: float = 0.125
    window: float = 64.0
    widest: float = 2.0**34


_ENDLESS = EndlessProfile()


# Of where a profile turns over: as far as it is known. On a circle the slope there is 724,
# 89.9° from the horizontal, and a millionth of the half-width is left out.
BEFORE_VERTICAL = 1 - 2.0**-20


@dataclass(frozen=True, eq=False)
class Resolved:
    """A profile known by samples.

    A corner stands twice: first with the slope on its left, then with that on its right.
    Between neighbouring samples it is the cubic through both heights and slopes, but for what the
    head of this module allows.

    Attributes
    ----------
    indenter : Indenter
    x, f, slope : ndarray (n,)
        Places in increasing order, heights [length] and slopes there.
    edges : ndarray
        Those of a pattern, on either side of which there is a sample [length].
    """

    indenter: Indenter
    x: Array
    f: Array
    slope: Array
    edges: Array

    @classmethod
    def of(cls, indenter: Indenter, x: Array, edges: ArrayLike = ()) -> Resolved:
        """The profile with samples at given places.

        Parameters
        ----------
        indenter : Indenter
        x : ndarray (n,)
            Places, increasing, the corners among them [length].
        edges : array_like
            Those of a pattern [length].

        Returns
        -------
        Resolved
        """
        corners = np.asarray(indenter.corners, float)
        inner = corners[(corners > x[0]) & (corners < x[-1])]
        x = np.repeat(x, 1 + np.isin(x, inner))
        is_repeated = x[1:] == x[:-1]
        # The side on which each slope is read: -1 for the first of two, 1 for the second, at other
        # samples 0; at the ends inwards, 1 for the first sample of all and -1 for the last.
        follows_itself = np.append(1, is_repeated)
        precedes_itself = np.append(is_repeated, 1)
        side = follows_itself - precedes_itself
        f, slope = _read(indenter, x, side)
        # What was called a corner and has one slope is none, and stands once.
        kept = np.append(True, ~is_repeated | (slope[1:] != slope[:-1]))
        return cls(indenter, x[kept], f[kept], slope[kept], np.asarray(edges, float))

    @functools.cached_property
    def touch(self) -> float:
        """The least height: the depth of first touch [length]."""
        return float(self.f.min())

    @functools.cached_property
    def lowest(self) -> float:
        """Where that is [length]."""
        return float(self.x[int(np.argmin(self.f))])

    def beyond(self, start: float, limit: float) -> slice:
        """The samples strictly between two positions.

        Parameters
        ----------
        start, limit : float
            In either order [length].

        Returns
        -------
        slice
            Of x, f and slope; increasing.
        """
        first = int(np.searchsorted(self.x, min(start, limit), side="right"))
        stop = int(np.searchsorted(self.x, max(start, limit), side="left"))
        return slice(first, max(first, stop))

    def past(self, x: Any, side: Any) -> Any:
        """Positions just beside edges of a pattern, where adhesion is that of the next patch.

        At an edge itself adhesion is that of the patch on its right, so that the last place of the
        patch on its left is the number before the edge. Those at an edge, or at the number before
        it, are moved by one rounding: that number becomes the edge with side = 1. Others are left
        as they are: next to another line every rounding counts.

        Parameters
        ----------
        x : float or ndarray
            [length].
        side : {1, -1}, or ndarray
            1 to the right of an edge, -1 to the left.

        Returns
        -------
        float or ndarray
            [length].
        """
        if not self.edges.size:
            return x
        at_edge = np.isin(x, self.edges) | np.isin(np.nextafter(x, math.inf), self.edges)
        moved = np.nextafter(x, np.copysign(math.inf, side))
        found = np.where(at_edge, moved, x)
        return found if np.ndim(x) else float(found)

    def one_sided(self, x: Array, side: Any) -> tuple[Array, Array]:
        """Height and slope of the profile, at corners on one side of them.

        Parameters
        ----------
        x : ndarray
            Positions [length].
        side : {1, -1}, or ndarray
            1 for the slope on the right of a corner, -1 for that on the left.

        Returns
        -------
        f, slope : ndarray
            [length], and f', in the shape of x.
        """
        f = np.asarray(self.indenter.height(x), float)
        slope = np.asarray(self.indenter.slope(x), float)
        if not len(self.indenter.corners):
            return f, slope
        # A corner stands twice among the samples: the second time with the slope on its right.
        second = np.searchsorted(self.x, x, side="right") - 1
        first = np.searchsorted(self.x, x)
        i = np.where(np.greater(side, 0), second, first)  # the number of the sample
        i = np.clip(i, 0, self.x.size - 1)
        is_sample = self.x[i] == x
        return np.where(is_sample, self.f[i], f), np.where(is_sample, self.slope[i], slope)

    @functools.cached_property
    def corners(self) -> Array:
        """x of the corners between the first and the last sample, increasing [length]."""
        return self.x[1:][self.x[1:] == self.x[:-1]]

    @functools.cached_property
    def joints(self) -> Array:
        """Where the rest depth D(x) of a line may jump [length].

        These are the corners and a pattern's edges, and the first and the last sample; increasing.
        """
        ends = self.x[[0, -1]]
        places = np.append(self.corners, self.edges)
        inside = places[(places > ends[0]) & (places < ends[1])]
        return np.unique(np.append(ends, inside)) if inside.size else ends

    def hidden(self, scene: Scene, x: Array) -> Array:
        """Features that samples have missed.

        At places where quadrature has looked closer the cubic must predict the slope as it does at
        the tests of every interval, or nearly so (`MissedFeatures`). The kink √(2w/γ₁) that it is
        compared with is that of `scene.work_of_adhesion`, as it was when the profile was sampled.

        Parameters
        ----------
        scene : Scene
        x : ndarray
            Those places [length].

        Returns
        -------
        ndarray
            The worst place in each interval in which one is missed [length].
        """
        # The interval from sample i to i + 1 in which each is.
        i = np.clip(np.searchsorted(self.x, x, "right") - 1, 0, self.x.size - 2)
        inside = (self.x[i] < x) & (x < self.x[i + 1])
        i = i[inside]
        x = x[inside]
        if not x.size:
            return x
        kink = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1) if scene.gamma1 else 0.0
        scale = kink or float(np.abs(self.slope).max())  # of slopes
        tests = self.x[i] + np.array(_TESTS)[:, None] * (self.x[i + 1] - self.x[i])
        places = np.vstack([x, tests])  # (3, n): each place, and both tests of its interval
        slope = np.asarray(self.indenter.slope(places), float)
        off = np.abs(slope - self._cubic_slope(i, places))
        off_here = off[0]
        off_at_tests = off[1:].max(axis=0)

        known = np.vstack([slope[1:], self.slope[i], self.slope[i + 1]])
        resolved = np.maximum(_SAMPLING.of_kink * scale, _SAMPLING.of_range * np.ptp(known, axis=0))
        missed = (off_here > _MISSED.over_resolved * resolved) | (
            off_here > _MISSED.over_tests * off_at_tests
        )
        missed &= off_here > _MISSED.noticed * scale
        # By interval, and in each by how far the cubic is off: the last of each is the worst.
        interval = i[missed]
        order = np.lexsort((off_here[missed], interval))
        is_worst = np.append(np.diff(interval[order]) > 0, True)[: order.size]
        return x[missed][order][is_worst]

    def _cubic_slope(self, i: Indices, x: Array) -> Array:
        """f' at x (.., n) of the cubics through the samples i and i + 1, i (n,)."""
        width = self.x[i + 1] - self.x[i]
        secant = (self.f[i + 1] - self.f[i]) / width
        cubic = CubicSlope.of(self.slope[i], self.slope[i + 1], secant)
        return cubic.at((x - self.x[i]) / width)

    def falls(self, slopes: str) -> Array:
        """By how much the slope falls at the corners, or with finite slopes the inclination.

        From left to right: positive at notches, negative at tips and edges that stick out.

        Parameters
        ----------
        slopes : {"small", "finite"}

        Returns
        -------
        ndarray
            In the order of `corners`; [rad] with finite slopes.
        """
        left = np.flatnonzero(np.diff(self.x) == 0)
        before = self.slope[left]
        after = self.slope[left + 1]
        if slopes == "finite":
            return np.asarray(np.arctan(before) - np.arctan(after))
        return np.asarray(before - after)


class CubicSlope(NamedTuple):
    """The slope low + b t + a t² of a cubic between two samples; arrays (n,).

    t is 0 at the left one, where the slope is `low`, and 1 at the right one.
    """

    low: Array
    b: Array
    a: Array

    @classmethod
    def of(cls, low: Array, high: Array, secant: Array) -> CubicSlope:
        """The cubics with these slopes at the left and right samples, and this mean slope."""
        return cls(low, 6 * secant - 4 * low - 2 * high, 3 * (low + high - 2 * secant))

    def at(self, t: Any) -> Array:
        """The slope at t."""
        return np.asarray(self.low + t * (self.b + self.a * t))


def warn_hidden(places: Array, stacklevel: int) -> None:
    """Warn of features that quadrature has found between the samples.

    Parameters
    ----------
    places : ndarray (n,)
        Where they are [length].
    stacklevel : int
        Of the warning, counted from the caller.

    Warns
    -----
    AccuracyWarning
    """
    named = ", ".join(f"{x!r}" for x in places[: _MISSED.named].tolist())
    warnings.warn(
        f"the profile has a feature near x = {named} that is narrower than its samples: it was "
        "only found by chance, and another depth, or a path in place of a state, may miss it; give "
        "Profile(..., knots=(x, ...)) with its place",
        AccuracyWarning,
        stacklevel=stacklevel + 1,
    )


def resolve(scene: Scene, depth: float, places: ArrayLike = ()) -> Resolved:
    """The profile of a scene, resolved; of an endless one what may be in contact.

    Parameters
    ----------
    scene : Scene
    depth : float
        Contact at depths up to this one is possible [length].
    places : array_like
        Where it is sampled besides, as it has a narrow feature there [length].

    Returns
    -------
    Resolved

    Warns
    -----
    AccuracyWarning
        Where MOST samples do not resolve it.

    Raises
    ------
    ValueError
        For a profile without a lowest point, or with heights that are not finite.
    """
    indenter = Radial(scene.indenter) if scene.axisymmetric else scene.indenter
    edges = np.array(scene.pattern.edges if scene.pattern is not None else (), float)
    size = scene.elastocapillary_length or scene.critical_separation or scene.layer.h  # if not 0
    low, high = window(indenter, depth, _ENDLESS.window * size, scene.opened.critical_separation)
    beside_edges = np.nextafter(edges, -math.inf)
    known = np.concatenate([indenter.breaks(), edges, beside_edges, places])
    # Samples in any case, between which the profile is smooth as far as it says so.
    cuts = np.unique(np.concatenate([[low, high], known[(known > low) & (known < high)]]))
    x, resolved = _refined(scene, indenter, cuts)
    if not resolved:
        warnings.warn(
            f"the profile varies on less than {float(np.diff(x).min())!r}, which {MOST} samples do "
            "not resolve: contacts may be missed; smooth the profile, or limit its extent",
            AccuracyWarning,
            stacklevel=4,  # whoever called `minimise`, which calls states.py, which calls this
        )
    extremes = _extremes(Resolved.of(indenter, x, edges))
    return Resolved.of(indenter, np.sort(np.append(x, extremes)), edges)


def window(indenter: Indenter, depth: float, half: float, reach: float) -> tuple[float, float]:
    """Where contact is possible: the extent, or as far as the profile is low around x = 0.

    An end at which the profile turns over, f' infinite, is left out: it is moved towards x = 0,
    which is between the ends of profiles that turn over, as round ones are centred. Without ends
    the window is doubled until the profile is higher than any contact at both ends of it, and
    lowest in its inner half: else it may be lower still outside.

    Parameters
    ----------
    indenter : Indenter
    depth : float
        [length].
    half : float
        Half width of the window that is tried first [length].
    reach : float
        How far above the depth, or first touch, the profile may be in contact: δ₀ [length].

    Returns
    -------
    low, high : float
        [length].

    Raises
    ------
    ValueError
        If there is no lowest point.
    """
    with np.errstate(divide="ignore"):
        vertical = [math.isfinite(x) and bool(np.isinf(indenter.slope(x))) for x in indenter.extent]
    shortened = BEFORE_VERTICAL * np.array(indenter.extent)
    low, high = np.where(vertical, shortened, indenter.extent).tolist()
    if math.isfinite(low) and math.isfinite(high):
        return low, high
    start = min(max(0.0, low), high)  # 0, or the end that is nearest to it
    widest = _ENDLESS.widest * half
    while half <= widest:
        left = max(low, start - half)
        right = min(high, start + half)
        x = np.linspace(left, right, 2 * _SAMPLING.first + 1)
        f = heights(indenter, x)
        lowest = float(x[int(np.argmin(f))])
        touch = float(f.min())
        pressed = max(depth, touch)
        level = pressed + reach + _ENDLESS.margin * (reach + pressed - touch)
        clear_left = f[0] > level or left == low
        clear_right = f[-1] > level or right == high
        if clear_left and clear_right and abs(lowest - start) <= half / 2:
            return left, right
        half *= 2
    raise ValueError(
        f"indenter = {indenter!r} has no lowest point within {half!r} of x = {start!r}, or does "
        "not rise in the end; give it an `extent`, as in Profile(..., extent=(lo, hi))"
    )


def heights(indenter: Indenter, x: Array) -> Array:
    """Heights of a profile.

    Parameters
    ----------
    indenter : Indenter
    x : ndarray (n,)
        Positions [length].

    Returns
    -------
    ndarray (n,)
        f [length].

    Raises
    ------
    ValueError
        Unless they are finite.
    """
    f = np.asarray(indenter.height(x), float)
    if not np.isfinite(f).all():
        bad = float(x[~np.isfinite(f)][0])
        raise ValueError(
            f"indenter.height({bad!r}) is not finite; give a profile that is finite inside its "
            f"extent {indenter.extent}"
        )
    return f


class UnknownProfile(ValueError):
    """Of a contact that spreads to an end of the profile that is not the end of the body.

    Parameters
    ----------
    depth : float
        At which it does [length].
    x : float
        That end [length].
    before : str
        How the message begins; by default with the depth.
    """

    def __init__(self, depth: float, x: float, before: str = "") -> None:
        """The error of a contact at this depth; without `before` it names that depth."""
        super().__init__(depth, x, before)
        self.depth = depth
        self.x = x
        self.before = before or f"depth = {depth!r}"

    def __str__(self) -> str:
        """What has happened where, and what to try."""
        return (
            f"{self.before} spreads the contact to x = {self.x!r}, where the profile is not known "
            "any more; give a wider profile, a smaller depth, or add a FlatPunch whose edge ends "
            "the indenter there; a scan may be upside down: turn it over"
        )


def unknown(depth: float, x: float) -> UnknownProfile:
    """The error of a contact that spreads to an end of the known profile.

    Parameters
    ----------
    depth : float
        At which it does [length].
    x : float
        That end [length].

    Returns
    -------
    UnknownProfile
    """
    return UnknownProfile(depth, x)


@contextmanager
def on_the_way_to(name: str, *given: float) -> Iterator[None]:
    """Errors of a profile that is not known far enough speak of the depths that were given, too.

    On the way to them other depths are passed, at which a contact may spread by a jump.

    Parameters
    ----------
    name : str
        The argument by which they were given.
    *given : float
        The first and the last of its values [length or force].

    Raises
    ------
    UnknownProfile
        For one of the block, with another beginning of its message unless its depth was given.
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
    """Whether lines are at the edge of the body, so that there is nothing beside them.

    Parameters
    ----------
    indenter : Indenter
    x : float or ndarray
        Positions of the lines [length].
    side : int or ndarray
        1 where the contact is on the left of the line, -1 where it is on the right.
    aside : int or ndarray
        1 where what is outwards of the contact is asked for, -1 inwards, 0 for neither.

    Returns
    -------
    ndarray of bool
    """
    left, right = (end if end in indenter.walls else math.nan for end in indenter.extent)
    to_the_right = np.multiply(side, aside)
    return np.equal(x, np.where(to_the_right > 0, right, left)) & (to_the_right != 0)


def _refined(scene: Scene, indenter: Indenter, cuts: Array) -> tuple[Array, bool]:
    """Samples of the pieces between cuts, and whether these resolve the profile.

    The kink √(2w/γ₁) is that of `scene.work_of_adhesion`; without adhesion slopes only count as
    the same within the noise, or within a part of how they vary in an interval. Intervals are
    halved until the cubic predicts the slope in all that are longer than 1e-10 of
    the window, or there would be more than MOST samples.

    Parameters
    ----------
    scene : Scene
        Its w and γ₁ say what slopes a contact line notices.
    indenter : Indenter
        Its profile, over r if the scene has an axis.
    cuts : ndarray (n,)
        Places that are samples, increasing, the first and the last being the ends [length].

    Returns
    -------
    x : ndarray (n,)
        Positions of the samples [length].
    resolved : bool
    """
    x = _first_samples(cuts)
    shortest = _SAMPLING.finest * float(np.ptp(cuts))
    left = x[:-1]
    right = x[1:]
    # At corners slopes are those inside the interval.
    at_left = _read(indenter, left, 1)
    at_right = _read(indenter, right, -1)
    steepest = float(np.abs([at_left[1], at_right[1]]).max())
    kink = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1) if scene.gamma1 else 0.0
    tolerance = max(_SAMPLING.of_kink * kink, _SAMPLING.noise * steepest)
    while True:
        unpredicted = _unpredicted(indenter, left, right, at_left, at_right, tolerance)
        unpredicted &= right - left > shortest
        left = left[unpredicted]
        right = right[unpredicted]
        if not left.size or x.size + left.size > MOST:
            return np.sort(x), not left.size
        middle = (left + right) / 2
        x = np.append(x, middle)
        left = np.append(left, middle)
        right = np.append(middle, right)
        at_left = _read(indenter, left, 1)
        at_right = _read(indenter, right, -1)


def _first_samples(cuts: Array) -> Array:
    """About 512 samples over all pieces between cuts, evenly in each, all cuts among them.

    A piece has as many intervals as fall to it by its width, rounded up.
    """
    widths = np.diff(cuts)
    count = np.maximum(1, np.ceil(widths / np.ptp(cuts) * _SAMPLING.first)).astype(int)
    number_of_first = np.repeat(np.cumsum(count) - count, count)  # of the piece of each sample
    number_in_piece = np.arange(number_of_first.size) - number_of_first
    part = number_in_piece / np.repeat(count, count)
    x = np.repeat(cuts[:-1], count) + np.repeat(widths, count) * part
    return np.append(x, cuts[-1])


def _read(indenter: Indenter, x: Array, side: Any) -> Array:
    """f and f' (2, n) at x (n,); at corners f' is that on this side: 1 right, -1 left.

    side: a number or (n,). Elsewhere it does not count.
    """
    corners = np.asarray(indenter.corners, float)
    side = np.where(np.isin(x, corners), side, 0) if corners.size else 0
    return np.array([heights(indenter, x), indenter.slope_beside(x, side)])


def _unpredicted(
    indenter: Indenter,
    left: Array,
    right: Array,
    at_left: Array,
    at_right: Array,
    tolerance: float,
) -> Mask:
    """Intervals (n,) within which the cubic does not predict the slope, or its slope turns back.

    Parameters
    ----------
    indenter : Indenter
    left, right : ndarray (n,)
        Ends of the intervals [length].
    at_left, at_right : ndarray (2, n)
        f and f' at these ends.
    tolerance : float
        Slopes count as the same within this, or within a part (`of_range`) of how they vary in the
        interval; where the cubic turns, within that part of the larger slope of its two ends.

    Returns
    -------
    ndarray of bool (n,)
    """
    width = right - left
    f_left, slope_left = at_left
    f_right, slope_right = at_right
    cubic = CubicSlope.of(slope_left, slope_right, (f_right - f_left) / width)
    least = np.minimum(slope_left, slope_right)
    most = np.maximum(slope_left, slope_right)
    # Where the cubic is steepest or flattest, and by how much more than at both ends. Such an
    # interval is halved however well the cubic predicts it: where the slope turns is looked for
    # among the slopes of samples alone (`slope_turns`).
    with np.errstate(divide="ignore", invalid="ignore"):
        t_extreme = -cubic.b / (2 * cubic.a)
        extreme = slope_left - cubic.b * cubic.b / (4 * cubic.a)
    inside = (t_extreme > 0) & (t_extreme < 1)
    overshoot = np.where(inside, np.maximum(extreme - most, least - extreme), 0.0)
    turns = overshoot > np.maximum(tolerance, _SAMPLING.of_range * np.maximum(most, -least))
    off = np.zeros(left.size)
    for t in _TESTS:
        slope = np.asarray(indenter.slope(left + t * width), float)
        off = np.maximum(off, np.abs(slope - cubic.at(t)))
        least = np.minimum(least, slope)
        most = np.maximum(most, slope)
    return np.asarray(turns | (off > np.maximum(tolerance, _SAMPLING.of_range * (most - least))))


def _extremes(samples: Resolved) -> Array:
    """The local extremes of f between its samples: where f' is 0, found from the cubics' [length].

    Those next to a sample are left out.
    """

    def slope(x: Array, numbers: Indices) -> Array:
        """f' at places; the numbers do not matter, as all are of the same function."""
        return np.asarray(samples.indenter.slope(x), float)

    found = []
    for sign in (1, -1):  # the minima of f, then those of -f
        cubic = minima(samples.x, sign * samples.f, sign * samples.slope)
        own = (cubic.lo < cubic.hi) & (cubic.bend > 0)
        low = cubic.lo[own]
        high = cubic.hi[own]
        x = crossings(slope, low, high, cubic.at[own], sign * cubic.bend[own], 0.0)
        tie = _SAMPLING.noise * (high - low)  # so near to a sample it is that
        found.append(x[(low + tie < x) & (x < high - tie)])
    return np.concatenate(found)
