"""Where a profile in contact would pull at the surface: -g - l² f'' > 0, around an axis (r f')'/r.

With finite slopes it is f'/√(1+f'²) for f'. Without adhesion nothing holds the surface there, and a
gap opens. Between two lines v = u - g obeys l² v'' = v + g + l² f'' with v = v' = 0 at both, so
there is no gap where nothing pulls, and one around every place that does.
"""

import math
from typing import NamedTuple

import numpy as np

from discretization.certificate import EPSILON
from discretization.profile import Resolved
from discretization.surfaces.protocol import ANY
from energy import Scene
from energy.arrays import Array

_PARTS = 8  # of an interval between samples, of each of which the mean pull is taken
_CLOSER = 2  # times the parts around the largest pull are taken apart again
_RISES = 4.0  # times what it differs beside its largest value: by less that falls short of 0
_SHORT = 1e-9  # of l: in shorter intervals f' is not known well enough
_ROUNDING = 4 * EPSILON  # of slopes
_TO_END = np.array([11, -7, 2]) / 6  # of three means next to an end, for the value there


class Pull(NamedTuple):
    """Where the profile pulls most in a part of the contact.

    worst: the pull over k [length], beyond what may be rounding of f'; ends: of where it pulls,
    nan if nowhere; force: at most so much it pulls there, over kl [length].
    """

    worst: float = 0.0
    ends: tuple[float, float] = (math.nan, math.nan)
    force: float = 0.0


def pull(scene: Scene, profile: Resolved, one: float, other: float, depth: float) -> Pull:
    """The largest pull in contact between two positions, in either order."""
    length, ends, worst = scene.elastocapillary_length, (math.nan, math.nan), 0.0
    lo, hi = sorted((one, other))
    own = profile.beyond(lo, hi)
    x, slope = np.concatenate([[lo], profile.x[own], [hi]]), profile.slope[own]
    first, last = profile.beside(np.array([lo, hi]), (1, -1))[1]
    cells = np.array([x[:-1], x[1:], [first, *slope], [*slope, last]])
    cells = cells[:, cells[1] - cells[0] > _SHORT * length]
    for _ in range(1 + _CLOSER if cells.size else 0):
        cells = _divided(profile, cells)
        z, values = _along(cells, _pulls(scene, profile, cells, depth))
        i = int(np.argmax(values))
        worst = float(values[i])
        if worst < -_RISES * float(np.ptp(values[max(i - 1, 0) : i + 2])):
            break
        if worst > 0:
            found = _around(z, values, i)
            seen = found[0] > z[0] or z[0] == lo, found[1] < z[-1] or z[-1] == hi
            ends = found if all(seen) or math.isnan(ends[0]) else ends
        group, at = divmod(i, _PARTS + 2)
        cell = _PARTS * group + min(max(at - 1, 0), _PARTS - 1)
        cells = cells.reshape(4, -1)[:, max(cell - 1, 0) : cell + 2]
    wide = min((ends[1] - ends[0]) / length, 1.0) if worst > 0 else 0.0
    return Pull(max(worst, 0.0), ends, max(worst, 0.0) * wide)


def bounds(scene: Scene, profile: Resolved) -> Array:
    """Safe bounds, lower and upper, of the pull at depth 0 between neighbouring samples (2, n)."""
    x, slope = profile.x, profile.slope
    parts = _divided(profile, np.array([x[:-1], x[1:], slope[:-1], slope[1:]]))
    with np.errstate(divide="ignore", invalid="ignore"):  # at a corner
        values = _along(parts, _pulls(scene, profile, parts, 0.0))[1].reshape(x.size - 1, -1)
        rise = _RISES * np.ptp(values, axis=1)
        found = np.array([values.min(axis=1) - rise, values.max(axis=1) + rise])
    return np.where(np.diff(x) > _SHORT * scene.elastocapillary_length, found, ANY)


def _divided(profile: Resolved, cells: Array) -> Array:
    """Parts (4, n, _PARTS) of intervals (4, n) of the contact: ends, and f' at them, inside."""
    lo, hi, one, other = cells
    x = lo[:, None] + (hi - lo)[:, None] * (np.arange(_PARTS + 1) / _PARTS)
    x[:, -1] = hi
    slope = np.asarray(profile.indenter.slope(x.ravel()), float).reshape(x.shape)
    slope[:, 0], slope[:, -1] = one, other
    return np.array([x[:, :-1], x[:, 1:], slope[:, :-1], slope[:, 1:]])


def _pulls(scene: Scene, profile: Resolved, parts: Array, depth: float) -> Array:
    """The mean pull of every part, less what may be rounding."""
    (lo, hi, one, other), height = parts, profile.indenter.height
    width = hi - lo
    f = (height(lo) + height(hi)) / 2 - width * (other - one) / 12
    if scene.slopes == "finite":
        one, other = (slope / np.sqrt(1 + slope * slope) for slope in (one, other))
    one, other = one * scene.measure(lo), other * scene.measure(hi)
    noise = _ROUNDING * (np.abs(one) + np.abs(other))
    bend = (other - one + noise) / (width * scene.measure((lo + hi) / 2))
    return np.asarray(f - depth - scene.elastocapillary_length**2 * bend)


def _along(parts: Array, mean: Array) -> tuple[Array, Array]:
    """Places and the pull there: at the middles of parts, and at both ends of every interval.

    At the ends, where it may be largest, that of the parabola with the means of the next three.
    """
    lo, hi = parts[:2]
    x = np.hstack([lo[:, :1], (lo + hi) / 2, hi[:, -1:]])
    first, last = mean[:, :3] @ _TO_END, mean[:, :-4:-1] @ _TO_END
    return x.ravel(), np.hstack([first[:, None], mean, last[:, None]]).ravel()


def _around(x: Array, values: Array, i: int) -> tuple[float, float]:
    """Between which places values are positive around the one with the number i."""
    found = []
    for way in (-1, 1):
        z, v = x[i::way], values[i::way]
        k = int(np.argmax(v <= 0))
        end = z[k - 1] + (z[k] - z[k - 1]) * v[k - 1] / (v[k - 1] - v[k]) if k else z[-1]
        found.append(float(end))
    return found[0], found[1]
