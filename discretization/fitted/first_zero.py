"""The first place on a way along the profile where a function is no longer negative.

The function is read at the samples of the resolved profile, at corners on either side, until it is.
Between samples a maximum is looked for wherever one could reach 0, so that a stop is not missed
next to where it disappears.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from discretization.profile import Resolved
from discretization.roots import bracketed, least
from energy.arrays import Array

Function = Callable[..., Any]  # of x, numbers or arrays, and f(x) and f'(x) if they are known
_BLOCK = 32  # samples read at once, four times as many each time
_LEAST = 8  # samples on a way that ends at another line, however short it is
_TOWARDS = 1 - 0.25 ** np.arange(1, 6)  # samples between the last one and that line
_ULPS = 4.0  # roundings of x: no maximum lies in between
_NEAR = 2.0  # times its distance from the next samples, that a maximum may rise above them


def first_zero(
    profile: Resolved, h: Function, start: float, limit: float, closed: bool = False
) -> float | None:
    """First x from `start` to `limit` with h >= 0; None if there is none.

    closed: `limit` is asked as well, on this side of it; at another line it cannot be.
    """
    side = 1 if limit > start else -1
    value = float(h(profile.past(start, side), *profile.at(start, side)))
    if value >= 0:
        return start
    samples, first, size = _samples(profile, start, limit, side), 0, _BLOCK
    last = np.array([start, start]), np.array([-math.inf, value])
    while first < samples.shape[1]:
        x, f, f1 = samples[:, first : first + size]
        seen = np.concatenate([last[0], x]), np.concatenate([last[1], h(x, f, f1)])
        found = _among(h, *seen)
        if found is not None:
            return found
        last = seen[0][-2:], seen[1][-2:]
        first, size = first + size, 4 * size
    if not closed:
        return None
    value = float(h(profile.past(limit, -side), *profile.at(limit, -side)))
    return _among(h, np.append(last[0], limit), np.append(last[1], value))


def _samples(profile: Resolved, start: float, limit: float, side: int) -> Array:
    """x, f and f' (3, n) of the samples strictly between, in the order of the way.

    With some more where the way is short, and next to its end.
    """
    own = profile.beyond(start, limit)
    found = np.array([profile.x[own], profile.f[own], profile.slope[own]])[:, ::side]
    if not math.isfinite(limit):
        return found
    last = float(found[0, -1]) if found.size else start
    x = last + (limit - last) * _TOWARDS
    if found.shape[1] < _LEAST:
        x = np.concatenate([start + (limit - start) * np.arange(1, _LEAST) / _LEAST, x])
    x = x[(x != limit) & (x != last) & ~np.isin(x, found[0])]
    found = np.hstack([found, [x, profile.indenter.height(x), profile.indenter.slope(x)]])
    return found[:, np.argsort(side * found[0], kind="stable")]


def _among(h: Function, x: Array, values: Array) -> float | None:
    """The stop among samples, the first of which is negative."""
    stops = np.flatnonzero(values >= 0)
    end = int(stops[0]) if stops.size else values.size
    for i in _peaks(x[: end + 1], values[: end + 1]):
        before, beyond = float(x[i - 1]), float(x[i + 1])
        if abs(beyond - before) <= _ULPS * math.ulp(before):
            continue  # both sides of an edge
        top, low = least(lambda z: -h(z), before, beyond, 0.0)
        if low <= 0:
            return bracketed(
                h, float(x[i]) if abs(top - before) > abs(x[i] - before) else before, top
            )
    if not stops.size:
        return None
    inside, outside = float(x[end - 1]), float(x[end])
    known = {inside: float(values[end - 1]), outside: float(values[end])}  # on one side of a corner
    if inside == outside:
        return outside
    return bracketed(lambda x: known[x] if x in known else float(h(x)), inside, outside)


def _peaks(x: Array, values: Array) -> list[int]:
    """Samples not less than their neighbours, beside which a maximum could reach 0."""
    steps = np.abs(np.diff(values))
    steps[~np.isfinite(steps)] = 0.0
    middle, apart = values[1:-1], np.maximum(steps[:-1], steps[1:])
    apart[:-1] = np.maximum(apart[:-1], steps[2:])  # a start may be as high as what follows
    top = (middle >= values[:-2]) & (middle >= values[2:]) & (middle < 0)
    top &= middle + _NEAR * apart >= 0
    start, corner = np.isinf(values[:-2]), np.diff(x) == 0  # nothing lies between the sides of one
    top &= (start | ~corner[:-1]) & ~corner[1:]
    return (np.flatnonzero(top) + 1).tolist()
