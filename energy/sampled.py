"""Measured profiles: piecewise linear or smooth through the samples.

Conventions: x increases along the surface, heights z = f(x) are positive upwards, away from the
layer, all lengths have one unit. n samples have n - 1 intervals; interval i lies between samples i
and i + 1. Outside of the samples the height is inf and the slope NaN, which says that no profile is
known there. The attributes `corners`, `knots`, `extent`, `convex`, `apex` and `complete` are those
of `energy.indenter.Indenter`: at corners the slope jumps, at knots a higher derivative does, and
`complete` promises that f is smooth between them. `array` makes a new array of floats, and leaves
what was given as it is; `option` refuses an unknown word, `positive` what is not > 0;
`gaussian_filter.filtered(x, z, cutoff)` are evenly spaced x and z without shorter waves.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_banded

from energy import gaussian_filter
from energy.arrays import Array, Indices, Mask
from energy.checks import array, option, positive
from energy.indenter import Indenter
from energy.noise import noise_slope

# A computed lowest point that is nearer than this share of its interval to a sample is taken for
# the sample, so that a symmetric scan has its apex exactly at x = 0. The place is a root of f',
# which the spline gives to some roundings (2e-16) of the largest slope; 1e-12 is thousands of them.
_SAME = 1e-12
# A slope may decrease by this share of the largest slope in a profile that counts as convex.
# Heights are floats, off by up to 1.1e-16 |z|, so that secants over a spacing h differ by up to
# 4.4e-16 |z|/h where they should not. With |z| no more than the largest slope times the width of
# the profile, that is 4.4e-16 times the number of intervals: 1e-12 is enough for 2000 even ones.
_ROUNDING = 1e-12


class _Located(NamedTuple):
    """Where positions are among samples; numbers instead of arrays for one position.

    Attributes
    ----------
    interval : ndarray of int
        Number of the sample before, of the second last one beyond the last.
    distance : ndarray
        From that sample [length], less than 0 before the first.
    known : ndarray of bool
        Whether the position is between the first and the last sample.
    """

    interval: Indices
    distance: Array
    known: Mask


@dataclass(frozen=True, eq=False)
class Sampled(Indenter):
    """Measured profile, not known outside its samples: a contact that reaches their end is refused.

    Parameters
    ----------
    x, z : array_like
        Increasing positions, and heights there (n,) [length].
    kind : {"linear", "smooth"}
        Straight between the samples, which are corners; or the cubic spline (continuous curvature)
        whose end slopes are those of the cubic through the four samples there.

    Raises
    ------
    ValueError
        For unequal lengths, fewer than 2 (smooth: 3) samples, NaN, unsorted x.

    Notes
    -----
    A contact line rests at a corner between straight pieces over a range of depths: at a convex one
    it waits while the slope turns, a concave one it passes with a jump. Pieces whose slopes differ
    by much less than √(2w/γ₁) are as good as a curve. Noise of the heights makes slopes between
    neighbours that grow as samples come closer, with both kinds of interpolation. An rms slope of a
    twentieth of √(2w/γ₁) changes the energy lost on a path by a sixth or more, larger ones decide
    it. `noise_slope` is this rms, as far as neighbours do not explain it (energy.noise); `validity`
    of states and paths compares it with √(2w/γ₁). The remedy is a filter, not more samples.

    Examples
    --------
    >>> from energy import Sampled
    >>> print(Sampled(x=[-1.0, 0.0, 2.0], z=[1.0, 0.0, 4.0]).height(0.5))
    1.0
    """

    x: Array
    z: Array
    kind: str = "linear"
    complete = True
    # "linear": f' on each of the n - 1 intervals; "smooth": f' at each of the n samples
    _slopes: Array = field(init=False, repr=False, compare=False)

    if TYPE_CHECKING:  # the fields are arrays, what is given need not be

        def __init__(self, x: ArrayLike, z: ArrayLike, kind: str = "linear") -> None: ...

    def __post_init__(self) -> None:
        """Check the samples, find the slopes of the interpolation, and keep all read-only."""
        option("kind", self.kind, ("linear", "smooth"))
        x = array("x", self.x)
        z = array("z", self.z)
        _check_samples(x, z, least=2 if self.kind == "linear" else 3)
        slopes = np.diff(z) / np.diff(x) if self.kind == "linear" else _spline_slopes(x, z)
        for name, values in (("x", x), ("z", z), ("_slopes", slopes)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    def filtered(self, cutoff: float) -> Sampled:
        """The profile without waves shorter than a cut-off (Gaussian filter, ISO 16610-21).

        Noise of the heights decides where contact lines rest if the slopes that it makes between
        neighbouring samples are not small against √(2w/γ₁). A cut-off removes it; choose it so that
        the rms slope of what was removed tells no more of the surface than of the instrument.

        Parameters
        ----------
        cutoff : float
            Wavelength of which half the amplitude passes [length], λs of surface metrology.

        Returns
        -------
        Sampled
            Of the same kind, evenly spaced, and shorter by the cut-off at either end.

        Raises
        ------
        ValueError
            If the cut-off is shorter than two spacings or too long for the profile.
        """
        x, z = gaussian_filter.filtered(self.x, self.z, positive("cutoff", cutoff))
        return Sampled(x, z, self.kind)

    def level_at(self, sample: int) -> Sampled:
        """The same smooth profile with f' = 0 at a sample, as symmetry has it but for rounding.

        Parameters
        ----------
        sample : int
            Index of the sample, from 0.

        Returns
        -------
        Sampled
            Of kind "smooth", as this one has to be: a polygon has no slope at a sample.
        """
        levelled = replace(self)
        slopes = np.where(np.arange(self.x.size) == sample, 0, self._slopes)
        object.__setattr__(levelled, "_slopes", slopes)
        return levelled

    @property
    def extent(self) -> tuple[float, float]:  # type: ignore[override]
        """From the first sample to the last one."""
        return (float(self.x[0]), float(self.x[-1]))

    @property
    def corners(self) -> Array:  # type: ignore[override]
        """All samples but both ends if they are joined by straight lines, none if smoothly."""
        return self.x[1:-1] if self.kind == "linear" else self.x[:0]

    @property
    def knots(self) -> Array:  # type: ignore[override]
        """All samples but both ends of a spline, whose third derivative jumps; none of lines."""
        return self.x[1:-1] if self.kind == "smooth" else self.x[:0]

    @functools.cached_property
    def convex(self) -> bool:  # type: ignore[override]
        """Whether the slope of the interpolation never decreases beyond rounding."""
        slopes = self._slopes
        rounding = _ROUNDING * np.abs(slopes).max()
        if self.kind == "linear":
            return bool((np.diff(slopes) >= -rounding).all())
        # f'' is linear between two samples, so that it suffices to look at both ends of an
        # interval. These are h f''/2 there, of the cubic with these heights and slopes at its ends.
        secant = np.diff(self.z) / np.diff(self.x)
        bend_at_left = 3 * secant - 2 * slopes[:-1] - slopes[1:]
        bend_at_right = slopes[:-1] + 2 * slopes[1:] - 3 * secant
        return bool((np.minimum(bend_at_left, bend_at_right) >= -rounding).all())

    @functools.cached_property
    def apex(self) -> float | None:  # type: ignore[override]
        """x [length] of the lowest point of a convex profile, the first of several; else None."""
        if not self.convex:
            return None
        slopes = self._slopes
        lowest_at_sample = self.kind == "linear" or not slopes[0] < 0 < slopes[-1]
        if lowest_at_sample:
            return float(self.x[int(np.argmin(self.z))])
        # The slopes of a convex profile increase: f' < 0 at sample i and f' >= 0 at the next one.
        i = int(np.searchsorted(slopes, 0.0)) - 1
        h = float(self.x[i + 1] - self.x[i])
        rise = self.z[i + 1] - self.z[i]
        # f' = slopes[i] + linear s + quadratic s² with s = (x - x[i])/h between 0 and 1
        linear = 6 * rise / h - 4 * slopes[i] - 2 * slopes[i + 1]
        quadratic = 3 * (slopes[i] + slopes[i + 1] - 2 * rise / h)
        # The root at which f' increases, in the form that does not cancel where f' is near linear.
        root = math.sqrt(max(linear * linear / 4 - quadratic * slopes[i], 0.0))
        lowest = float(self.x[i] - h * slopes[i] / (linear / 2 + root))
        nearest_sample = float(self.x[np.abs(self.x - lowest).argmin()])
        return nearest_sample if abs(nearest_sample - lowest) <= _SAME * h else lowest

    @functools.cached_property
    def noise_slope(self) -> float:
        """Rms slope that noise makes between neighbouring samples; see energy.noise."""
        return noise_slope(self.x, self.z)

    def height(self, x: ArrayLike | float) -> Array:
        """f(x) [length], of the shape of x; inf outside of the samples."""
        return self._evaluated(self._located(x), self._height_coefficients, math.inf)

    def slope(self, x: ArrayLike | float) -> Array:
        """f'(x), of the shape of x, at a corner that on its right; NaN outside of the samples."""
        return self._evaluated(self._located(x), self._slope_coefficients, math.nan)

    def height_and_slope(self, x: ArrayLike | float) -> tuple[Array, Array]:
        """Both, with the positions looked up once."""
        there = self._located(x)
        height = self._evaluated(there, self._height_coefficients, math.inf)
        return height, self._evaluated(there, self._slope_coefficients, math.nan)

    @functools.cached_property
    def _height_coefficients(self) -> Array:
        """Coefficients (2 or 4, n - 1) of f in powers of the distance from the sample before.

        Rows are powers from 0 on (two of a straight piece, four of a cubic), columns are intervals.
        """
        h = np.diff(self.x)
        slopes = self._slopes
        if self.kind == "linear":
            return np.array([self.z[:-1], slopes])
        # Hermite's cubic, which has the heights and slopes of both samples of its interval.
        secant_less_slope = np.diff(self.z) / h - slopes[:-1]
        change_of_slope = np.diff(slopes)
        second = (3 * secant_less_slope - change_of_slope) / h
        third = (change_of_slope - 2 * secant_less_slope) / h**2
        return np.array([self.z[:-1], slopes[:-1], second, third])

    @functools.cached_property
    def _slope_coefficients(self) -> Array:
        """Coefficients (1 or 3, n - 1) of f', in the layout of `_height_coefficients`."""
        powers = np.arange(1, len(self._height_coefficients))
        return self._height_coefficients[1:] * powers[:, None]

    def _located(self, x: Any) -> _Located:
        """Where positions x are among the samples; at a sample the piece on its right counts."""
        x = np.asarray(x, float)[()]  # numbers, not arrays of one: faster
        interval = self.x[1:-1].searchsorted(x, side="right")
        known = (x >= self.x[0]) & (x <= self.x[-1])
        return _Located(interval, x - self.x[interval], known)

    def _evaluated(self, there: _Located, coefficients: Array, outside: float) -> Array:
        """The piecewise polynomial with these coefficients there, and `outside` where not known."""
        value = coefficients[-1][there.interval]
        for of_power in coefficients[-2::-1]:  # Horner's scheme
            value = value * there.distance + of_power[there.interval]
        if not there.known.ndim:
            return np.asarray(value if there.known else outside)
        return np.where(there.known, value, outside)


def _check_samples(x: Array, z: Array, least: int) -> None:
    """ValueError unless x increases and both are finite, equally long, with `least` samples."""
    if x.ndim != 1 or x.shape != z.shape or x.size < least:
        raise ValueError(
            f"x and z have shapes {x.shape} and {z.shape}; give two equally long "
            f"one-dimensional arrays of at least {least} samples"
        )
    for name, values in (("x", x), ("z", z)):
        if not np.isfinite(values).all():
            bad = int(np.flatnonzero(~np.isfinite(values))[0])
            raise ValueError(f"{name}[{bad}] = {values[bad]} is not finite; remove or mend it")
    if (np.diff(x) <= 0).any():
        bad = int(np.flatnonzero(np.diff(x) <= 0)[0])
        raise ValueError(f"x[{bad + 1}] = {x[bad + 1]} does not exceed x[{bad}]; sort the samples")


def _spline_slopes(x: Array, z: Array) -> Array:
    """Slopes m (n,) at the samples that make the piecewise cubic twice differentiable.

    h_i m_{i-1} + 2(h_{i-1}+h_i) m_i + h_{i-1} m_{i+1} = 3(h_i s_{i-1} + h_{i-1} s_i) at the inner
    samples, with the secants s and the spacings h (interval i begins at sample i); the slopes at
    both ends are those of the cubics through the four samples there, or of the parabola through
    three if there are no more.
    """
    h = np.diff(x)
    secant = np.diff(z) / h
    near = min(4, x.size)
    right_hand_side = np.empty_like(z)
    right_hand_side[0] = _end_slope(x[:near], z[:near], 0)
    right_hand_side[-1] = _end_slope(x[-near:], z[-near:], -1)
    right_hand_side[1:-1] = 3 * (h[1:] * secant[:-1] + h[:-1] * secant[1:])
    # The bands of the matrix as scipy's solve_banded takes them, each by its column: row 0 is above
    # the diagonal, row 1 on it, row 2 below it. The equations of both ends are m = the slope there.
    band = np.zeros((3, x.size))
    band[0, 2:] = h[:-1]
    band[1, [0, -1]] = 1
    band[1, 1:-1] = 2 * (h[:-1] + h[1:])
    band[2, :-2] = h[1:]
    return np.asarray(solve_banded((1, 1), band, right_hand_side))


def _end_slope(x: Array, z: Array, end: int) -> float:
    """Slope at the sample of index `end` (0 or -1) of the polynomial through all of these samples.

    Heights are counted from the one there: a height that all have in common would only round.
    """
    polynomial = np.polynomial.Polynomial.fit(x, z - z[end], x.size - 1)
    return float(polynomial.deriv()(x[end]))
