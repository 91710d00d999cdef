"""Zeros and least values of functions of one variable, one by one or many at once."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from energy.arrays import Array, Indices, Mask

Function = Callable[[float], float]
Values = Callable[[Array], Array]
Functions = Callable[[Array, Indices], Array]
Evaluation = Callable[[Array, Indices, Array, Array], tuple[Array, Array]]
_PLACES = np.arange(1, 8) / 8  # of what is between two points: there a minimum is looked for
_ROUNDS = 16  # each leaves two of these eight parts, in the end 4⁻¹⁶ = 2e-10: a minimum is flat
_STEPS = 200  # more than the halvings between any two doubles of one size
CLOSEST = 4e-16  # of a zero: a few roundings
_CLOSE = 2.0**-52  # of the position: steps of one rounding
# Of how the slope varies between two places: the least value of the cubic is off by less, where the
# function is resolved by it.
_UNSURE = 1 / 16


def bracketed(
    h: Function, inside: float, outside: float, close: float = CLOSEST, fraction: float = 0.5
) -> float:
    """Zero of a function between two places at which its signs differ, by Chandrupatla's method.

    Inverse quadratic steps where three points support them, halving otherwise, until the bracket is
    at most `close` of the zero wide. If that is more than rounding, it also stops where its ends a,
    b are that close to the zero of the straight line through them in the geometric mean,

        |f(a) f(b)| |b - a|²/(f(b) - f(a))² <= (close · zero)²,

    which is then the result. (T. R. Chandrupatla, Advances in Engineering Software 28 (1997) 145.)

    Parameters
    ----------
    h : callable
        Number of a number.
    inside, outside : float
        Where h <= 0, and where h > 0. What has another sign there, as at a corner whose slope is
        read from the other side, counts as rounding.
    close : float
        Relative width of the last bracket.
    fraction : float
        Where it looks first, from `inside` on.

    Returns
    -------
    float
        The zero, or after 200 steps the end of the bracket with the smaller value.
    """
    a = inside
    b = outside
    fa = min(h(a), 0.0)
    fb = h(b)
    if not fb > 0:
        fb = -fa or 1.0
    for _ in range(_STEPS):
        x = a + fraction * (b - a)
        fx = h(x)
        # a is the newest point, b the other end of the bracket, c the one before either.
        if (fx > 0) == (fa > 0):
            c = a
            fc = fa
        else:
            c = b
            fc = fb
            b = a
            fb = fa
        a = x
        fa = fx
        best = a if abs(fa) < abs(fb) else b
        least = close * abs(best) / (abs(b - a) or 1.0)  # step over the width of the bracket
        narrow = least > 0.5 or a == b
        if close > CLOSEST and a != b and fa != 0:
            if narrow or -fa * fb / (fb - fa) ** 2 <= least * least:
                return a - fa * (b - a) / (fb - fa)
        elif fa == 0 or narrow:
            return a if fa == 0 else best
        xi = (a - b) / (c - b)
        phi = (fa - fb) / (fc - fb)
        fraction = 0.5
        if phi * phi < xi and (1 - phi) ** 2 < 1 - xi:
            fraction = fa / (fb - fa) * fc / (fb - fc)
            fraction += (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        fraction = min(max(fraction, least), 1 - least)
    return best


def bracketed_minimum(
    h: Values, lo: float, hi: float, enough: float, rounds: int = _ROUNDS, reach: float = math.inf
) -> tuple[float, float]:
    """Where a function with one minimum between two places is least, at ever closer places.

    Parameters
    ----------
    h : callable
        Values (n,) at places (n,).
    lo, hi : float
        The two places.
    enough : float
        It stops where h is not more than this, or would not be even if it fell below the lowest
        place by `reach` times what it falls towards that.
    rounds : int
        Each narrows the interval fourfold.
    reach : float

    Returns
    -------
    place, value : float
    """
    for _ in range(rounds):
        x = lo + (hi - lo) * _PLACES
        values = h(x)
        i = int(np.argmin(values))
        low = float(values[i])
        fall = float(np.ptp(values[max(i - 1, 0) : i + 2]))
        if low <= enough or low - reach * fall > enough:
            break
        if i > 0:
            lo = float(x[i - 1])
        if i + 1 < x.size:
            hi = float(x[i + 1])
    return float(x[i]), low


class Minima(NamedTuple):
    """Minima of a function between samples; arrays (k,).

    Attributes
    ----------
    lo, hi : ndarray
        Places between which each is.
    at : ndarray
        Where that of the cubic is.
    bend : ndarray
        v'' there; nan at a corner, which is a minimum between two equal places.
    value, off : ndarray
        v there, and what it may be off by.
    """

    lo: Array
    hi: Array
    at: Array
    bend: Array
    value: Array
    off: Array


def minima(x: Array, v: Array, v1: Array) -> Minima:
    """Minima of a function that is known by values and slopes at places.

    They are those of the cubics through both, and corners at which the slope changes its sign.

    Parameters
    ----------
    x, v, v1 : ndarray (n,)
        Increasing places, corners twice; values, and slopes.

    Returns
    -------
    Minima
    """
    return minima_between(x, v, v1, np.ones(x.size - 1, bool))[1]


def minima_between(x: Array, v: Array, v1: Array, joined: Mask) -> tuple[Indices, Minima]:
    """Minima of several functions, whose places stand one after the other.

    Parameters
    ----------
    x, v, v1 : ndarray (n,)
        As of `minima`, of one function after the other.
    joined : ndarray of bool (n - 1,)
        Whether neighbours are places of the same function.

    Returns
    -------
    intervals : ndarray of int (k,)
        The number of the interval in which each minimum is.
    minima : Minima
    """
    start = np.arange(x.size - 1)
    stop = np.arange(1, x.size)
    turns = (v1[start] <= 0) & (v1[stop] >= 0)
    # The last interval of each function is read backwards, so that both ends are t = 0: where the
    # slope is 0 there t is 0 to the last bit, and no minimum between the samples.
    last = np.flatnonzero(joined & ~np.append(joined[1:], False))
    start[last] = last + 1
    stop[last] = last
    h = x[stop] - x[start]
    rise = v[stop] - v[start]
    c = v1[start] * h
    end = v1[stop] * h
    b = 6 * rise - 4 * c - 2 * end
    a = 3 * (c + end - 2 * rise)  # h v' = a t² + b t + c
    steepest = np.maximum(np.abs(c), np.abs(end))
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - 4 * a * c)
        t = np.where(b > 0, -2 * c / (b + root), (root - b) / (2 * a))
        inside = (t > 0) & (t < 1) & (steepest > _CLOSE * np.abs(v).max())
        k = np.flatnonzero((turns | inside) & joined)
        a, b, c, h, end = a[k], b[k], c[k], h[k], end[k]
        t = np.clip(np.where(np.isnan(t[k]), 0.5, t[k]), 0.0, 1.0)
        flattest = np.clip(-b / (2 * a), 0.0, 1.0)  # where v' turns back
        bend = (2 * a * t + b) / (h * h)
    begin = x[start[k]]
    value = v[start[k]] + t * (c + t * (b / 2 + t * a / 3))
    off = _UNSURE * (np.abs(c) + np.abs(end))
    one = begin + h * np.where(c > 0, flattest, 0)
    other = begin + h * np.where(end < 0, flattest, 1)
    found = Minima(np.minimum(one, other), np.maximum(one, other), begin + h * t, bend, value, off)
    return k, found


def crossings(
    h: Functions, lo: Array, hi: Array, guess: Array, rise: Array, enough: float
) -> Array:
    """Zeros of n functions, all at once, by secants and halving.

    Parameters
    ----------
    h : callable
        h(x, numbers): values (k,) of the functions with these numbers at x (k,).
    lo, hi : ndarray (n,)
        Between these each changes its sign once.
    guess : ndarray (n,)
        Where it looks first.
    rise : ndarray (n,)
        Guesses of the slopes; their signs are those of h at hi.
    enough : float
        Up to this |h| is zero.

    Returns
    -------
    ndarray (n,)
        Also done is what moves by one rounding; after 200 steps the last places count.
    """

    def evaluate(x: Array, own: Indices, last: Array, last_value: Array) -> tuple[Array, Array]:
        value = h(x, own)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return value, (value - last_value) / (x - last)

    first = h(guess, np.arange(guess.size))
    return _crossings(evaluate, lo, hi, guess, (first, rise), rise, enough, quadratic=False)


def newton_crossings(
    h: Callable[[Array, Indices], tuple[Array, Array]],
    lo: Array,
    hi: Array,
    guess: Array,
    rise: Array,
    enough: float,
) -> Array:
    """As `crossings`, by Newton's method: h gives values and slopes.

    Done is also what converges quadratically and will be one rounding off at the next step.
    """

    def evaluate(x: Array, own: Indices, last: Array, last_value: Array) -> tuple[Array, Array]:
        return h(x, own)

    first = h(guess, np.arange(guess.size))
    return _crossings(evaluate, lo, hi, guess, first, rise, enough, quadratic=True)


def _crossings(
    evaluate: Evaluation,
    lo: Array,
    hi: Array,
    guess: Array,
    first: tuple[Array, Array],
    rise: Array,
    enough: float,
    *,
    quadratic: bool,
) -> Array:
    """Zeros (n,), from values and slopes at guesses on.

    evaluate(x, numbers, last places, last values): values and slopes of functions at x. A step that
    leaves the bracket is a halving, and so is the next one where a value is not halved.
    """
    found = guess.copy()
    own = np.arange(guess.size)  # numbers of the functions whose zeros are not yet known
    at = guess
    value, slope = first
    step = np.full(guess.size, math.nan)
    slow = np.zeros(guess.size, bool)
    side = np.where(rise < 0, -1.0, 1.0)
    for _ in range(_STEPS):
        low = side * value <= 0
        lo = np.where(low, at, lo)
        hi = np.where(low, hi, at)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = at - value / slope
        inside = (new >= lo) & (new <= hi) & ~slow
        new = np.where(inside, new, (lo + hi) / 2)

        last_step = step
        step = np.abs(new - at)
        rounding = _CLOSE * np.abs(new)
        zero = np.abs(value) <= enough
        known = zero | (step <= rounding)
        if quadratic:
            known |= step**3 <= rounding * last_step * last_step
        found[own] = np.where(zero, at, new)
        if known.any():
            left = ~known
            own = own[left]
            at, new, value = at[left], new[left], value[left]
            lo, hi, side, step, slow = lo[left], hi[left], side[left], step[left], slow[left]
        if not own.size:
            break
        last_value = value
        value, slope = evaluate(new, own, at, last_value)
        slow = (np.abs(value) > np.abs(last_value) / 2) & ~slow
        at = new
    return found
