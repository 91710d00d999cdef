"""The first place on a way along the profile where a function is no longer negative.

The function is read at the samples of the resolved profile, at corners on either side, until it is.
Between samples a maximum is looked for wherever one could reach 0, so that a stop is not missed
next to where it disappears.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.profile import Resolved
from discretization.roots import bracketed

Array = NDArray[np.float64]
Function = Callable[[Any, Any, Any], Any]  # of x, f(x), f'(x): numbers or arrays
Samples = tuple[Array, ...]  # x, f(x), f'(x)
_BLOCK = 32  # samples read at once, four times as many each time
_LEAST = 8  # samples on a way that ends at another line, however short it is
_TOWARDS = 1 - 0.25 ** np.arange(1, 6)  # samples between the last one and that line
_PLACES = 16  # parts of the interval in which a maximum is looked for
_ROUNDS = 10  # so often that interval is one of two of them
_ULPS = 4.0  # roundings of x: no maximum lies in between
_NEAR = 2.0  # times its distance from the next samples, that a maximum may rise above them


class Stop(NamedTuple):
    """A stop beyond the place `before`, at which h is still negative; guess: about where it is.

    root: finds it, None where `guess` is the stop itself, at a corner.
    """

    before: float
    guess: float
    root: Callable[[], float] | None

    @property
    def x(self) -> float:
        """The stop itself."""
        return self.guess if self.root is None else self.root()


def first_stop(
    profile: Resolved, h: Function, start: float, limit: float, closed: bool = False
) -> Stop | None:
    """First x from `start` to `limit` with h >= 0; None if there is none.

    closed: `limit` is asked as well, on this side of it; at another line it cannot be.
    """
    side = 1 if limit > start else -1
    value = float(h(profile.past(start, side), *profile.at(start, side)))
    if value >= 0:
        return Stop(start, start, None)
    last = np.array([start, start]), np.array([-math.inf, value])
    for x, f, f1 in _blocks(profile, start, limit, side):
        seen = np.concatenate([last[0], x]), np.concatenate([last[1], h(x, f, f1)])
        found = _among(profile, h, *seen)
        if found is not None:
            return found
        last = seen[0][-2:], seen[1][-2:]
    if not closed:
        return None
    value = float(h(profile.past(limit, -side), *profile.at(limit, -side)))
    return _among(profile, h, np.append(last[0], limit), np.append(last[1], value))


def _blocks(profile: Resolved, start: float, limit: float, side: int) -> Iterator[Samples]:
    """x, f and f' of the samples strictly between, in the order of the way, in growing blocks."""
    own = profile.beyond(start, limit)
    columns = np.array([profile.x[own], profile.f[own], profile.slope[own]])[:, ::side]
    first, size = 0, _BLOCK
    while columns.shape[1] - first > size:
        yield tuple(columns[:, first : first + size])
        first, size = first + size, 4 * size
    rest = columns[:, first:]
    if math.isfinite(limit):
        rest = _with_more(
            profile, rest, start if first == 0 else float(columns[0, first - 1]), limit
        )
    if rest.size:
        yield tuple(rest)


def _with_more(profile: Resolved, samples: Array, start: float, limit: float) -> Array:
    """Samples with some more: of a way that is short, and next to its end."""
    last = float(samples[0, -1]) if samples.size else start
    x = last + (limit - last) * _TOWARDS
    if samples.shape[1] < _LEAST:
        x = np.concatenate([start + (limit - start) * np.arange(1, _LEAST) / _LEAST, x])
    x = x[(x != limit) & (x != last) & ~np.isin(x, samples[0])]
    more = np.array([x, profile.indenter.height(x), profile.indenter.slope(x)])
    both = np.hstack([samples, more])
    return both[:, np.argsort(np.sign(limit - start) * both[0], kind="stable")]


def _among(profile: Resolved, h: Function, x: Array, values: Array) -> Stop | None:
    """The stop among samples, the first of which is negative."""
    stops = np.flatnonzero(values >= 0)
    end = int(stops[0]) if stops.size else values.size
    for i in _peaks(x[: end + 1], values[: end + 1]):
        before, beyond = float(x[i - 1]), float(x[i + 1])
        if abs(beyond - before) <= _ULPS * math.ulp(before):
            continue  # both sides of an edge
        top = _summit(profile, h, before, beyond)
        if top is not None:
            if abs(top - before) > abs(x[i] - before):
                before = float(x[i])
            return Stop(before, top, functools.partial(bracketed, _read(profile, h), before, top))
    if not stops.size:
        return None
    inside, outside = float(x[end - 1]), float(x[end])
    if inside == outside:
        return Stop(inside, outside, None)
    low, high = float(values[end - 1]), float(values[end])
    read = _read(profile, h, {inside: low, outside: high})
    guess = inside + (outside - inside) * low / (low - high)
    return Stop(inside, guess, functools.partial(bracketed, read, inside, outside))


def _read(
    profile: Resolved, h: Function, known: dict[float, float] | None = None
) -> Callable[[float], float]:
    """h as a function of x alone; known: at corners, on one side of them."""
    values, indenter = known or {}, profile.indenter

    def at(x: float) -> float:
        if x in values:
            return values[x]
        return float(h(x, float(indenter.height(x)), float(indenter.slope(x))))

    return at


def _peaks(x: Array, values: Array) -> list[int]:
    """Samples not less than their neighbours, beside which a maximum could reach 0."""
    steps = np.abs(np.diff(values))
    steps[~np.isfinite(steps)] = 0.0
    middle, apart = values[1:-1], np.maximum(steps[:-1], steps[1:])
    apart[:-1] = np.maximum(apart[:-1], steps[2:])  # a start may be as high as what follows
    top = (middle >= values[:-2]) & (middle >= values[2:]) & (middle < 0)
    top &= middle + _NEAR * apart >= 0
    start, corner = (
        np.isinf(values[:-2]),
        np.diff(x) == 0,
    )  # nothing lies between a corner and itself
    top &= (start | ~corner[:-1]) & ~corner[1:]
    return (np.flatnonzero(top) + 1).tolist()


def _summit(profile: Resolved, h: Function, lo: float, hi: float) -> float | None:
    """A place between where h >= 0, looked for around the highest of more and more places.

    None once it would have to rise above them by more than it falls beside the highest.
    """
    indenter, t = profile.indenter, np.arange(1, _PLACES) / _PLACES
    for _ in range(_ROUNDS):
        x = lo + (hi - lo) * t
        values = h(x, np.asarray(indenter.height(x), float), np.asarray(indenter.slope(x), float))
        i = int(np.argmax(values))
        if values[i] >= 0:
            return float(x[i])
        beside = values[max(i - 1, 0) : i + 2].min()
        if values[i] + _NEAR * (values[i] - beside) < 0:
            return None
        lo, hi = float(x[i - 1]) if i else lo, float(x[i + 1]) if i + 1 < x.size else hi
    return None
