"""Where a profile in contact would pull at the surface: -g - l² f'' > 0, around an axis (r f')'/r.

With finite slopes it is f'/√(1+f'²) for f'. Without adhesion nothing holds the surface there, and a
gap opens. Between two lines v = u - g obeys l² v'' = v + g + l² f'' with v = v' = 0 at both, so
there is no gap where nothing pulls, and one around every place that does.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.certificate import EPSILON
from discretization.profile import Resolved
from discretization.surfaces.protocol import ANY
from energy import Scene
from energy.arrays import Array


@dataclass(frozen=True)
class PullRules:
    """How closely the pull of a profile is looked at.

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
    """Where the profile pulls most in a part of the contact.

    Attributes
    ----------
    worst : float
        The pull over k, beyond what may be rounding of f' [length].
    ends : tuple of float
        Of where it pulls [length], nan if nowhere.
    force : float
        What it pulls there at most, over kl [length].
    """

    worst: float = 0.0
    ends: tuple[float, float] = (math.nan, math.nan)
    force: float = 0.0


def pull(scene: Scene, profile: Resolved, one: float, other: float, depth: float) -> Pull:
    """The largest pull in contact between two positions, in either order.

    The mean pull of parts of the intervals between samples is read, then that of parts of what is
    around the largest one, until it is clear that it falls short of 0.

    Parameters
    ----------
    scene : Scene
    profile : Resolved
    one, other : float
        [length].
    depth : float
        [length].

    Returns
    -------
    Pull
    """
    length = scene.elastocapillary_length
    start, end = sorted((one, other))
    cells = _between_samples(profile, start, end)
    cells = cells[:, cells[1] - cells[0] > _RULES.shortest * length]
    if not cells.size:
        return Pull()
    ends = (math.nan, math.nan)
    for _ in range(1 + _RULES.closer):
        cells = _divided(profile, cells)
        x, values = _along(cells, _pulls(scene, profile, cells, depth))
        i = int(np.argmax(values))
        worst = float(values[i])
        around = values[max(i - 1, 0) : i + 2]
        if worst < -_RULES.rises * float(np.ptp(around)):
            break
        if worst > 0:
            found = _around(x, values, i)
            # closer looks may not see the ends of where it pulls
            sees_first = found[0] > x[0] or x[0] == start
            sees_last = found[1] < x[-1] or x[-1] == end
            if (sees_first and sees_last) or math.isnan(ends[0]):
                ends = found
        cells = _beside_part(cells, i)
    if worst <= 0:
        return Pull(0.0, ends, 0.0)
    width = min((ends[1] - ends[0]) / length, 1.0)
    return Pull(worst, ends, worst * width)


def _between_samples(profile: Resolved, start: float, end: float) -> Array:
    """Intervals (4, n) between neighbouring samples: both ends, and f' inside at them."""
    own = profile.beyond(start, end)
    x = np.concatenate([[start], profile.x[own], [end]])
    slope = profile.slope[own]
    first, last = profile.one_sided(np.array([start, end]), (1, -1))[1]
    return np.array([x[:-1], x[1:], [first, *slope], [*slope, last]])


def _beside_part(parts: Array, i: int) -> Array:
    """The part (4, 1..3) in which `_along` has its place i, and those beside it."""
    interval, place = divmod(i, _RULES.parts + 2)
    part = _RULES.parts * interval + min(max(place - 1, 0), _RULES.parts - 1)
    return parts.reshape(4, -1)[:, max(part - 1, 0) : part + 2]


def bounds(scene: Scene, profile: Resolved) -> Array:
    """Safe bounds of the pull at depth 0 between neighbouring samples.

    Parameters
    ----------
    scene : Scene
    profile : Resolved

    Returns
    -------
    ndarray (2, n)
        Lower and upper ones over k [length]; far below any pull in intervals that are too short.
    """
    x = profile.x
    slope = profile.slope
    parts = _divided(profile, np.array([x[:-1], x[1:], slope[:-1], slope[1:]]))
    with np.errstate(divide="ignore", invalid="ignore"):  # at a corner
        _, values = _along(parts, _pulls(scene, profile, parts, 0.0))
        of_intervals = values.reshape(x.size - 1, -1)
        rise = _RULES.rises * np.ptp(of_intervals, axis=1)
        lower = of_intervals.min(axis=1) - rise
        upper = of_intervals.max(axis=1) + rise
    long_enough = np.diff(x) > _RULES.shortest * scene.elastocapillary_length
    return np.where(long_enough, np.array([lower, upper]), ANY)


def _divided(profile: Resolved, cells: Array) -> Array:
    """Parts (4, n, _PARTS) of intervals (4, n) of the contact: ends, and f' at them, inside."""
    lo, hi, one, other = cells
    x = lo[:, None] + (hi - lo)[:, None] * (np.arange(_RULES.parts + 1) / _RULES.parts)
    x[:, -1] = hi
    slope = np.asarray(profile.indenter.slope(x.ravel()), float).reshape(x.shape)
    slope[:, 0] = one
    slope[:, -1] = other
    return np.array([x[:, :-1], x[:, 1:], slope[:, :-1], slope[:, 1:]])


def _pulls(scene: Scene, profile: Resolved, parts: Array, depth: float) -> Array:
    """The mean pull of every part, less what may be rounding."""
    lo, hi, one, other = parts
    height = profile.indenter.height
    width = hi - lo
    f = (height(lo) + height(hi)) / 2 - width * (other - one) / 12
    if scene.slopes == "finite":
        one = one / np.sqrt(1 + one * one)
        other = other / np.sqrt(1 + other * other)
    one = one * scene.measure(lo)
    other = other * scene.measure(hi)
    noise = _RULES.rounding * (np.abs(one) + np.abs(other))
    bend = (other - one + noise) / (width * scene.measure((lo + hi) / 2))
    return np.asarray(f - depth - scene.elastocapillary_length**2 * bend)


def _along(parts: Array, mean: Array) -> tuple[Array, Array]:
    """Places and the pull there: at the middles of parts, and at both ends of every interval.

    At the ends, where it may be largest, that of the parabola with the means of the next three.
    """
    lo, hi = parts[:2]
    x = np.hstack([lo[:, :1], (lo + hi) / 2, hi[:, -1:]])
    first = mean[:, :3] @ _TO_END
    last = mean[:, :-4:-1] @ _TO_END
    values = np.hstack([first[:, None], mean, last[:, None]])
    return x.ravel(), values.ravel()


def _around(x: Array, values: Array, i: int) -> tuple[float, float]:
    """Between which places values are positive around the one with the number i."""
    return _last_positive(x[i::-1], values[i::-1]), _last_positive(x[i:], values[i:])


def _last_positive(x: Array, values: Array) -> float:
    """How far values are positive from the first place on: to the zero of a straight line."""
    k = int(np.argmax(values <= 0))
    if not k:
        return float(x[-1])
    step = (x[k] - x[k - 1]) * values[k - 1] / (values[k - 1] - values[k])
    return float(x[k - 1] + step)
