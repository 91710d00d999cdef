"""Zeros and least values of functions of one variable, one by one or many at once.

Those that do many at once take arrays with one element for each function. As they leave out those
that are done, a function of them is called with places (k,) and the numbers (k,) of the functions
that are meant, which count from 0 in the order of the arrays.

EPSILON is 2⁻⁵², the rounding of a double.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.certificate import EPSILON
from energy.arrays import Array, Indices, Mask

Function = Callable[[float], float]
Values = Callable[[Array], Array]
# Values (k,) of the functions with these numbers (k,) at places (k,), one each.
Functions = Callable[[Array, Indices], Array]
# Values and slopes (k,), from places, numbers, the places before these, and the values there.
Evaluation = Callable[[Array, Indices, Array, Array], tuple[Array, Array]]

# Where a minimum is looked for between two places, and how often: each time two of the eight parts
# are left, in the end 4⁻¹⁶ = 2e-10 of all. A minimum is flat. With 8 rounds 5 of 93 random states
# and paths change by up to 9e-7 of their scale, with 32 none by 1e-9 (`python -m tests.sensitivity
# discretization.roots NARROWINGS`).
EIGHTHS = np.arange(1, 8) / 8
NARROWINGS = 16
# Steps of a root finder at most: more than there are halvings between any two doubles of one size.
# 100 or 400 change no result; nor do a tenth or ten times of CLOSEST, or half or twice of
# _CUBIC_ERROR (`python -m tests.sensitivity discretization.roots`).
MOST_STEPS = 200
CLOSEST = 4e-16  # of a zero: two to four roundings, the width of the last bracket
# Of how the slope varies between two places: the least value of the cubic is off by less, where the
# function is resolved by it.
_CUBIC_ERROR = 1 / 16


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
    for _ in range(MOST_STEPS):
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
        least = close * abs(best) / (abs(b - a) or 1.0)  # of the bracket: the shortest step
        narrow = least > 0.5 or a == b
        if close > CLOSEST and a != b and fa != 0:
            if narrow or -fa * fb / (fb - fa) ** 2 <= least * least:
                return a - fa * (b - a) / (fb - fa)
        elif fa == 0 or narrow:
            return a if fa == 0 else best
        # The inverse parabola through a, b, c is used where it is monotonic between a and b:
        # Chandrupatla's condition on ξ and φ. Else the bracket is halved.
        xi = (a - b) / (c - b)
        phi = (fa - fb) / (fc - fb)
        fraction = 0.5
        if phi * phi < xi and (1 - phi) ** 2 < 1 - xi:
            fraction = fa / (fb - fa) * fc / (fb - fc)
            fraction += (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        fraction = min(max(fraction, least), 1 - least)
    return best


def bracketed_minimum(
    h: Values,
    lo: float,
    hi: float,
    enough: float,
    rounds: int = NARROWINGS,
    reach: float = math.inf,
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
        How often the interval is narrowed, fourfold each time.
    reach : float
        How far below the lowest place h may fall, over the fall towards that place; infinite if
        nothing is known of it.

    Returns
    -------
    place, value : float
        Where h is least of all that was read, and h there.
    """
    for _ in range(rounds):
        x = lo + (hi - lo) * EIGHTHS
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
    """Minima of a function v between samples; arrays (k,).

    Attributes
    ----------
    lo, hi : ndarray
        Places between which each is, and v' grows; a corner has both equal.
    at : ndarray
        Where that of the cubic is.
    bend : ndarray
        v'' there; nan at a corner.
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
    cubics = _Cubics.between(x, v, v1, joined)
    changes_sign = (v1[:-1] <= 0) & (v1[1:] >= 0)
    t = cubics.minimum()
    # Where v changes by less than its rounding, there is no minimum to be seen.
    steepest = np.maximum(np.abs(cubics.c), np.abs(cubics.end))
    with np.errstate(invalid="ignore"):
        is_inside = (t > 0) & (t < 1) & (steepest > EPSILON * np.abs(v).max())
    intervals = np.flatnonzero((changes_sign | is_inside) & joined)
    cubics = _Cubics(*(part[intervals] for part in cubics))
    t = t[intervals]
    t = np.clip(np.where(np.isnan(t), 0.5, t), 0.0, 1.0)  # a corner has no t, and any will do

    # The minimum lies where v' grows: on one side of where v' itself is least or greatest. It is
    # beyond that from an end at which v' has the wrong sign, h v' > 0 at t = 0 or < 0 at t = 1.
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = (2 * cubics.a * t + cubics.b) / (cubics.h * cubics.h)
        turning = np.clip(-cubics.b / (2 * cubics.a), 0.0, 1.0)
    one = cubics.begin + cubics.h * np.where(cubics.c > 0, turning, 0)
    other = cubics.begin + cubics.h * np.where(cubics.end < 0, turning, 1)
    found = Minima(
        lo=np.minimum(one, other),
        hi=np.maximum(one, other),
        at=cubics.begin + cubics.h * t,
        bend=bend,
        value=cubics.value + t * (cubics.c + t * (cubics.b / 2 + t * cubics.a / 3)),
        off=_CUBIC_ERROR * (np.abs(cubics.c) + np.abs(cubics.end)),
    )
    return intervals, found


class _Cubics(NamedTuple):
    """v between neighbouring places, h v' = a t² + b t + c, t from 0 to 1; arrays (n - 1,).

    Attributes
    ----------
    begin, h : ndarray
        Where t is 0, and how far from there to where it is 1, negative if it is read backwards.
    value : ndarray
        v at t = 0.
    a, b, c : ndarray
        Coefficients.
    end : ndarray
        h v' at t = 1.
    """

    begin: Array
    h: Array
    value: Array
    a: Array
    b: Array
    c: Array
    end: Array

    @classmethod
    def between(cls, x: Array, v: Array, v1: Array, joined: Mask) -> "_Cubics":
        """Through values and slopes at both places.

        The last interval of each function is read backwards, so that both ends of the function are
        t = 0: where the slope is 0 there, t is 0 to the last bit, and no minimum between places.
        """
        start = np.arange(x.size - 1)
        stop = np.arange(1, x.size)
        last = np.flatnonzero(joined & ~np.append(joined[1:], False))
        start[last] = last + 1
        stop[last] = last
        h = x[stop] - x[start]
        rise = v[stop] - v[start]
        c = v1[start] * h
        end = v1[stop] * h
        b = 6 * rise - 4 * c - 2 * end
        a = 3 * (c + end - 2 * rise)
        return cls(x[start], h, v[start], a, b, c, end)

    def minimum(self) -> Array:
        """t where v' is 0 and grows, by the formula that subtracts nothing; nan if nowhere."""
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(self.b * self.b - 4 * self.a * self.c)
            of_growing = -2 * self.c / (self.b + root)
            of_falling = (root - self.b) / (2 * self.a)
            return np.where(self.b > 0, of_growing, of_falling)


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
        The zeros, in the order of the functions. A search also ends with a step of one rounding,
        and after 200 steps, where it is then.
    """

    def evaluate(x: Array, own: Indices, last: Array, last_value: Array) -> tuple[Array, Array]:
        """Values, and slopes of the secants through the last places."""
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
    """Zeros of n functions, all at once, by Newton's method and halving. Done is also what
    converges quadratically and will be one rounding off at the next step.

    Parameters
    ----------
    h : callable
        h(x, numbers): values and slopes (k,) of the functions with these numbers at x (k,).
    lo, hi, guess, rise, enough : ndarray (n,), and float
        As of `crossings`.

    Returns
    -------
    ndarray (n,)
        As of `crossings`.
    """

    def evaluate(x: Array, own: Indices, last: Array, last_value: Array) -> tuple[Array, Array]:
        """Values and slopes; the last places do not matter."""
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

    A step that leaves the bracket is replaced by a halving, and so is the one after a step that has
    not halved the value. A zero is known once |h| <= enough, or a step is at most rounding; with
    quadratic convergence also where the next step will be: that is about step³/(last step)².

    Parameters
    ----------
    evaluate : callable
        Values and slopes of functions; see `Evaluation`.
    lo, hi, guess, rise, enough
        As of `crossings`.
    first : tuple of ndarray (n,)
        Values and slopes at the guesses.
    quadratic : bool
        Whether the slopes are derivatives, so that steps converge quadratically.
    """
    found = guess.copy()
    value, slope = first
    searched = _Searched(
        numbers=np.arange(guess.size),
        lo=lo,
        hi=hi,
        side=np.where(rise < 0, -1.0, 1.0),
        at=guess,
        value=value,
        step=np.full(guess.size, math.nan),
        halves=np.zeros(guess.size, bool),
    )
    for _ in range(MOST_STEPS):
        searched.narrow()
        new = searched.next_places(slope)
        step = np.abs(new - searched.at)  # searched.step is the one before, nan at first
        rounding = EPSILON * np.abs(new)
        is_zero = np.abs(searched.value) <= enough
        is_known = is_zero | (step <= rounding)
        if quadratic:
            is_known |= step**3 <= rounding * searched.step * searched.step
        found[searched.numbers] = np.where(is_zero, searched.at, new)

        searched.step = step
        if is_known.any():
            left = ~is_known
            searched.keep(left)
            new = new[left]
        if not searched.numbers.size:
            break
        value, slope = evaluate(new, searched.numbers, searched.at, searched.value)
        searched.move(new, value)
    return found


@dataclass(eq=False)
class _Searched:
    """Functions whose zeros are not known yet; arrays (k,).

    Attributes
    ----------
    numbers : ndarray of int
        Which functions they are.
    lo, hi : ndarray
        Ends of the brackets.
    side : ndarray
        The sign of each function at hi.
    at, value : ndarray
        Newest places, and values there.
    step : ndarray
        Size of the last step.
    halves : ndarray of bool
        Whether the next step is a halving, as the value was not halved.
    """

    numbers: Indices
    lo: Array
    hi: Array
    side: Array
    at: Array
    value: Array
    step: Array
    halves: Mask

    def narrow(self) -> None:
        """Make the newest places ends of the brackets, by the signs of the values there."""
        is_low = self.side * self.value <= 0
        self.lo = np.where(is_low, self.at, self.lo)
        self.hi = np.where(is_low, self.hi, self.at)

    def next_places(self, slope: Array) -> Array:
        """Where the straight lines of these slopes are 0, or the middles of the brackets."""
        with np.errstate(divide="ignore", invalid="ignore"):
            new = self.at - self.value / slope
        is_inside = (new >= self.lo) & (new <= self.hi) & ~self.halves
        return np.where(is_inside, new, (self.lo + self.hi) / 2)

    def move(self, at: Array, value: Array) -> None:
        """Go to these places, at which the functions have these values."""
        is_slow = np.abs(value) > np.abs(self.value) / 2
        self.halves = is_slow & ~self.halves
        self.at = at
        self.value = value

    def keep(self, left: Mask) -> None:
        """Leave out all functions but these; left: a mask (k,)."""
        self.numbers = self.numbers[left]
        self.lo = self.lo[left]
        self.hi = self.hi[left]
        self.side = self.side[left]
        self.at = self.at[left]
        self.value = self.value[left]
        self.step = self.step[left]
        self.halves = self.halves[left]
