"""Zero and least value of a function between two points."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from energy.arrays import Array, Indices, Mask

Function = Callable[[float], float]
Values = Callable[[Array], Array]
Functions = Callable[[Array, Indices], Any]
_PLACES = np.arange(1, 8) / 8  # of what is between two points: there a minimum is looked for
_ROUNDS = 16  # each leaves two of these parts, in the end 5e-10 of all: a minimum is flat
_HALVINGS = 200  # secants, and halvings where those are slow
CLOSEST = 4e-16  # of a zero: a few roundings
_CLOSE = 2.0**-52  # of the position: steps of one rounding
_UNSURE = 1 / 16  # of how the slope varies between two places: what the least value is off by


def bracketed(
    h: Function, inside: float, outside: float, close: float = CLOSEST, fraction: float = 0.5
) -> float:
    """Zero of h with h(inside) <= 0 < h(outside), by Chandrupatla's method.

    Inverse quadratic steps where three points support them, halving otherwise, until the bracket is
    no wider than this part of the zero; or, of a larger part, its ends are no further from the zero
    of the straight line through them in the geometric mean: that is then the answer. fraction:
    where it looks first. T. R. Chandrupatla, Advances in Engineering Software 28 (1997) 145.
    """
    a, b = inside, outside
    fa, fb = min(h(a), 0.0), h(b)
    if not fb > 0:  # a corner whose slope is read from the other side
        fb = -fa or 1.0
    for _ in range(200):
        x = a + fraction * (b - a)
        fx = h(x)
        if (fx > 0) == (fa > 0):
            c, fc, a, fa = a, fa, x, fx
        else:
            c, fc, b, a, fb, fa = b, fb, a, x, fa, fx
        best = a if abs(fa) < abs(fb) else b
        least = close * abs(best) / (abs(b - a) or 1.0)
        straight = close > CLOSEST and a != b and fa != 0
        near = straight and -fa * fb / (fb - fa) ** 2 <= least * least
        if fa == 0 or least > 0.5 or a == b or near:
            return a - fa * (b - a) / (fb - fa) if straight else a if fa == 0 else best
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        fraction = 0.5
        if phi * phi < xi and (1 - phi) ** 2 < 1 - xi:
            fraction = fa / (fb - fa) * fc / (fb - fc)
            fraction += (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        fraction = min(max(fraction, least), 1 - least)
    return best


def least(
    h: Values, lo: float, hi: float, enough: float, rounds: int = _ROUNDS, reach: float = math.inf
) -> tuple[float, float]:
    """Where h, with one minimum between two points, is least, and h there, at ever closer places.

    Or where it is not more than `enough`, or would not be even if it fell below the lowest place by
    `reach` times what it falls towards that.
    """
    for _ in range(rounds):
        x = lo + (hi - lo) * _PLACES
        values = h(x)
        i = int(np.argmin(values))
        low, fall = float(values[i]), float(np.ptp(values[max(i - 1, 0) : i + 2]))
        if low <= enough or low - reach * fall > enough:
            break
        lo, hi = float(x[i - 1]) if i else lo, float(x[i + 1]) if i + 1 < x.size else hi
    return float(x[i]), low


def minima(x: Array, v: Array, v1: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Minima of a function known by values and slopes v1 at places (n,), corners twice.

    Those of the cubics through both: between which places, where, v'', v, and what v may be off by.
    """
    return minima_between(x, v, v1, np.ones(x.size - 1, bool))[1:]


def minima_between(
    x: Array, v: Array, v1: Array, joined: Mask
) -> tuple[Indices, Array, Array, Array, Array, Array, Array]:
    """The same between those neighbours that are joined (n - 1,), first their numbers.

    Each function has places of its own next to each other in x.
    """
    lo, hi = np.arange(x.size - 1), np.arange(1, x.size)
    turns = (v1[lo] <= 0) & (v1[hi] >= 0)
    ends = np.flatnonzero(joined & ~np.append(joined[1:], False))
    lo[ends], hi[ends] = hi[ends], lo[ends]  # a slope of 0 at an end is no minimum
    h, rise = x[hi] - x[lo], v[hi] - v[lo]
    c, end = v1[lo] * h, v1[hi] * h
    a, b = 3 * (c + end - 2 * rise), 6 * rise - 4 * c - 2 * end  # h v' = a t² + b t + c
    most = np.maximum(np.abs(c), np.abs(end))
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - 4 * a * c)
        t = np.where(b > 0, -2 * c / (b + root), (root - b) / (2 * a))
        felt = most > _CLOSE * np.abs(v).max()
        k = np.flatnonzero((turns | ((t > 0) & (t < 1) & felt)) & joined)
        a, b, c, h, t, end, start = (part[k] for part in (a, b, c, h, t, end, x[lo]))
        t, middle = np.clip([np.where(np.isnan(t), 0.5, t), -b / (2 * a)], 0.0, 1.0)
        bend = (2 * a * t + b) / (h * h)
    value = v[lo[k]] + t * (c + t * (b / 2 + t * a / 3))
    off = _UNSURE * (np.abs(c) + np.abs(end))
    one, other = start + h * np.where(c > 0, middle, 0), start + h * np.where(end < 0, middle, 1)
    low, high = np.minimum(one, other), np.maximum(one, other)
    return k, low, high, start + h * t, bend, value, off


def crossings(
    h: Functions, lo: Array, hi: Array, guess: Array, rise: Array, enough: float
) -> Array:
    """Zeros (n,) of n functions between lo and hi, all at once, by secants and halving.

    h(x, own): values of the functions of these numbers at x, or with slopes, for Newton's method.
    They change sign once, from there to hi as `rise`, a guess of slopes. Up to `enough` is zero.
    """
    x, own, at, step = guess.copy(), np.arange(guess.size), guess, np.full(guess.size, math.nan)
    value, slope, slow = h(at, own), rise, np.zeros(own.size, bool)
    if newton := isinstance(value, tuple):
        value, slope = value
    side = np.where(rise < 0, -1.0, 1.0)
    for _ in range(_HALVINGS):
        low, near = side * value <= 0, np.abs(value) <= enough
        lo, hi = np.where(low, at, lo), np.where(low, hi, at)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = at - value / slope
        inside = (new >= lo) & (new <= hi) & ~slow
        new = np.where(inside, new, (lo + hi) / 2)
        last, step, least = step, np.abs(new - at), _CLOSE * np.abs(new)
        known = near | (step <= least) | (newton & (step**3 <= least * last * last))
        x[own] = np.where(near, at, new)
        if known.any():
            own, slow = own[~known], slow[~known]
            parts = (at, new, value, lo, hi, side, step)
            at, new, value, lo, hi, side, step = (part[~known] for part in parts)
        if not own.size:
            break
        before, value = value, h(new, own)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            value, slope = value if newton else (value, (value - before) / (new - at))
        slow, at = (np.abs(value) > np.abs(before) / 2) & ~slow, new
    return x
