"""Where a profile in contact would pull at the surface: -g - l² f'' > 0, around an axis (r f')'/r.

With finite slopes it is f'/√(1+f'²) for f'. Without adhesion nothing holds the surface there, and a
gap opens. Between two lines v = u - g obeys l² v'' = v + g + l² f'' with v = v' = 0 at both, so
there is no gap where nothing pulls, and one around every place that does.

Conventions
-----------
The pull is a traction, positive where the surface is pulled up, off the indenter; divided by k it
is a length, -g - l² f'' with g = d - f. The depth d and the displacement u are positive down into
the layer, heights f of the profile upwards. An integral of the pull along x is a force per length;
divided by kl it is a length again. f'' is taken as a difference of slopes, over an interval of the
samples of the profile (`Resolved`): so the mean pull of the interval is exact, whatever f'' does.
About an axis x is the radius, and `Scene.measure` is 2πx, in place of 1.

`Resolved.slope` is f' at the samples x, and `one_sided(x, side)` gives height and slope at any
place, at corners on its right (1) or left (-1). l = √(γ₁/k) is `Scene.elastocapillary_length`;
EPSILON is 2⁻⁵².
"""

import math
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import EPSILON
from discretization.profile import Resolved
from discretization.surfaces.protocol import ANY
from energy import Scene
from energy.arrays import Array


class PullRules(NamedTuple):
    """How closely the pull of a profile is looked at.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 4 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.fitted.tension`.

    Attributes
    ----------
    parts : int
        Parts of an interval between samples, of each of which the mean pull is taken.
    closer : int
        Times that the parts around the largest pull are divided again.
    rises : float
        Times what the pull differs beside its largest value: if it falls short of 0 by more, it is
        less than 0 between the parts, too.
    shortest : float
        Of l: in shorter intervals f' is not known well enough.
    rounding : float
        Of slopes: their rounding.
    """

    parts: int = 8
    closer: int = 2
    rises: float = 4.0
    shortest: float = 1e-9
    rounding: float = 4 * EPSILON


_RULES = PullRules()


# Of the mean values of three parts next to an end: the value at the end of the parabola with those.
_TO_END = np.array([11, -7, 2]) / 6


class Pull(NamedTuple):
    """Where the profile pulls most in a part of the contact; `Pull()` is nowhere.

    Attributes
    ----------
    worst : float
        The largest pull over k, beyond what may be rounding of f' [length]; 0 if nowhere.
    ends : tuple of float
        Both ends of where it pulls around that [length], nan if nowhere.
    force : float
        A bound of the force there, over kl: the largest pull times the width, at most l [length].
    """

    worst: float = 0.0
    ends: tuple[float, float] = (math.nan, math.nan)
    force: float = 0.0


def pull(scene: Scene, profile: Resolved, one: float, other: float, depth: float) -> Pull:
    """The largest pull in contact between two positions, in either order.

    The mean pull of parts of the intervals between samples is read, then that of parts of what is
    around the largest one, until it is clear that the pull stays below 0, or `closer` times.

    Parameters
    ----------
    scene : Scene
    profile : Resolved
    one, other : float
        [length].
    depth : float
        d [length].

    Returns
    -------
    Pull
    """
    length = scene.elastocapillary_length
    start, end = sorted((one, other))
    intervals = _between_samples(profile, start, end)
    intervals = intervals.of(intervals.width > _RULES.shortest * length)
    if not intervals.low.size:
        return Pull()
    ends = (math.nan, math.nan)
    for _ in range(1 + _RULES.closer):
        parts = intervals.divided(profile)
        x, values = _along(parts, _mean_pulls(scene, profile, parts, depth))
        i = int(np.argmax(values))
        worst = float(values[i])
        around = values[max(i - 1, 0) : i + 2]
        if worst < -_RULES.rises * float(np.ptp(around)):
            break
        if worst > 0:
            pulls_between = _around(x, values, i)
            # A closer look covers a shorter part of the contact, which the profile may pull at all
            # over: then the ends are those that a wider look has seen.
            sees_first = pulls_between[0] > x[0] or x[0] == start
            sees_last = pulls_between[1] < x[-1] or x[-1] == end
            if (sees_first and sees_last) or math.isnan(ends[0]):
                ends = pulls_between
        intervals = parts.beside(i)
    if worst <= 0:
        return Pull(0.0, ends, 0.0)
    width = min((ends[1] - ends[0]) / length, 1.0)
    return Pull(worst, ends, worst * width)


class _Intervals(NamedTuple):
    """Intervals of the contact; arrays (n,), or (n, parts) once they are divided.

    Attributes
    ----------
    low, high : ndarray
        Their ends [length].
    slope_low, slope_high : ndarray
        f' at these, inside of the interval.
    """

    low: Array
    high: Array
    slope_low: Array
    slope_high: Array

    @property
    def width(self) -> Array:
        """Their lengths."""
        return self.high - self.low

    def of(self, own: Any) -> "_Intervals":
        """The intervals with these numbers, or where a mask is true."""
        return _Intervals(*(values[own] for values in self))

    def divided(self, profile: Resolved) -> "_Intervals":
        """Each interval in equal parts: arrays (n, parts)."""
        share = np.arange(_RULES.parts + 1) / _RULES.parts
        x = self.low[:, None] + self.width[:, None] * share
        x[:, -1] = self.high
        slope = np.asarray(profile.indenter.slope(x.ravel()), float).reshape(x.shape)
        slope[:, 0] = self.slope_low
        slope[:, -1] = self.slope_high
        return _Intervals(x[:, :-1], x[:, 1:], slope[:, :-1], slope[:, 1:])

    def beside(self, i: int) -> "_Intervals":
        """Of divided intervals the part in which `_along` has its place i, and both next to it.

        `_along` has parts + 2 places for each interval: its low end, the middles of its parts, and
        its high end. Parts are counted through all intervals.
        """
        interval, place = divmod(i, _RULES.parts + 2)
        number_in_interval = min(max(place - 1, 0), _RULES.parts - 1)
        number = _RULES.parts * interval + number_in_interval
        own = slice(max(number - 1, 0), number + 2)
        return _Intervals(*(values.ravel()[own] for values in self))


def _between_samples(profile: Resolved, start: float, end: float) -> _Intervals:
    """The intervals between neighbouring samples from one position to another, start < end.

    f' at a sample that is a corner is that on the side of the interval, as corners stand twice
    among the samples; the interval of no width between them is left out by the caller.
    """
    own = profile.beyond(start, end)
    x = np.concatenate([[start], profile.x[own], [end]])
    slope = profile.slope[own]
    _, slopes_at_ends = profile.one_sided(np.array([start, end]), (1, -1))
    first, last = slopes_at_ends
    return _Intervals(x[:-1], x[1:], np.append(first, slope), np.append(slope, last))


def bounds(scene: Scene, profile: Resolved) -> Array:
    """Safe bounds of the pull at depth 0 between neighbouring samples.

    At a depth d the pull, and with it both bounds, is less by d.

    Parameters
    ----------
    scene : Scene
    profile : Resolved

    Returns
    -------
    ndarray (2, n)
        In the first row lower, in the second upper ones, over k [length], for the intervals between
        the samples i and i + 1; ANY, far below any pull, in those that are too short to say.
    """
    x = profile.x
    slope = profile.slope
    parts = _Intervals(x[:-1], x[1:], slope[:-1], slope[1:]).divided(profile)
    with np.errstate(divide="ignore", invalid="ignore"):  # at a corner
        _, values = _along(parts, _mean_pulls(scene, profile, parts, 0.0))
        of_intervals = values.reshape(x.size - 1, -1)
        rise = _RULES.rises * np.ptp(of_intervals, axis=1)
        lower = of_intervals.min(axis=1) - rise
        upper = of_intervals.max(axis=1) + rise
    long_enough = np.diff(x) > _RULES.shortest * scene.elastocapillary_length
    return np.where(long_enough, np.array([lower, upper]), ANY)


def _mean_pulls(scene: Scene, profile: Resolved, parts: _Intervals, depth: float) -> Array:
    """The mean pull over k of each part [length], less what may be rounding of f'.

    It is the mean of f - d - l² f'', about an axis of l² (r f')'/r, with f' or the sine of its
    angle. The mean of f'' is the difference of f' at both ends over the width; that of f is that of
    the cubic through heights and slopes at both ends. Arrays in the shape of the parts.

    profile: gives f at the ends of the parts, which may be no samples; depth: d [length].
    """
    height = profile.indenter.height
    width = parts.width
    at_low = parts.slope_low
    at_high = parts.slope_high
    f = (height(parts.low) + height(parts.high)) / 2 - width * (at_high - at_low) / 12
    if scene.slopes == "finite":
        at_low = at_low / np.sqrt(1 + at_low * at_low)
        at_high = at_high / np.sqrt(1 + at_high * at_high)
    at_low = at_low * scene.measure(parts.low)
    at_high = at_high * scene.measure(parts.high)
    noise = _RULES.rounding * (np.abs(at_low) + np.abs(at_high))
    middle = (parts.low + parts.high) / 2
    bend = (at_high - at_low + noise) / (width * scene.measure(middle))
    return np.asarray(f - depth - scene.elastocapillary_length**2 * bend)


def _along(parts: _Intervals, mean: Array) -> tuple[Array, Array]:
    """Places along divided intervals (n, parts), and the pull there.

    The places are the middles of the parts, with their mean pull, and both ends of every interval,
    where the pull may be largest: that is the end of the parabola with the means of the next three.

    Returns
    -------
    x, pull : ndarray (n (parts + 2),)
        [length].
    """
    middles = (parts.low + parts.high) / 2
    x = np.hstack([parts.low[:, :1], middles, parts.high[:, -1:]])
    first = mean[:, :3] @ _TO_END
    last = mean[:, :-4:-1] @ _TO_END
    values = np.hstack([first[:, None], mean, last[:, None]])
    return x.ravel(), values.ravel()


def _around(x: Array, values: Array, i: int) -> tuple[float, float]:
    """Between which places values are positive around the one with the number i, left and right."""
    return _last_positive(x[i::-1], values[i::-1]), _last_positive(x[i:], values[i:])


def _last_positive(x: Array, values: Array) -> float:
    """How far values are positive from the first place on, where they are.

    That is the zero of the straight line between the last positive value and the first that is
    not, or the last place if all are positive. x may fall as well as grow.
    """
    k = int(np.argmax(values <= 0))
    if not k:
        return float(x[-1])
    step = (x[k] - x[k - 1]) * values[k - 1] / (values[k - 1] - values[k])
    return float(x[k - 1] + step)
