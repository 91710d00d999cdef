"""Measured profiles: piecewise linear or smooth through the samples."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_banded

from energy import gaussian_filter
from energy.checks import array, option, positive
from energy.indenter import Array, Indenter
from energy.noise import noise_slope

_SAME = 1e-12  # of an interval: a lowest point so near to a sample is that
_ROUNDING = 1e-12


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
    _slopes: Array = field(init=False, repr=False, compare=False)

    if TYPE_CHECKING:  # the fields are arrays, what is given need not be

        def __init__(self, x: ArrayLike, z: ArrayLike, kind: str = "linear") -> None: ...

    def __post_init__(self) -> None:
        option("kind", self.kind, ("linear", "smooth"))
        x, z = (array(name, getattr(self, name)) for name in ("x", "z"))
        least = 2 if self.kind == "linear" else 3
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
            raise ValueError(
                f"x[{bad + 1}] = {x[bad + 1]} does not exceed x[{bad}]; sort the samples"
            )
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
        """The same with f' = 0 at a sample, as symmetry has it there but for rounding."""
        found = replace(self)
        slopes = np.where(np.arange(self.x.size) == sample, 0, self._slopes)
        object.__setattr__(found, "_slopes", slopes)
        return found

    @property
    def extent(self) -> tuple[float, float]:  # type: ignore[override]
        return (float(self.x[0]), float(self.x[-1]))

    @property
    def corners(self) -> Array:  # type: ignore[override]
        return self.x[1:-1] if self.kind == "linear" else self.x[:0]

    @property
    def knots(self) -> Array:  # type: ignore[override]
        return self.x[1:-1] if self.kind == "smooth" else self.x[:0]

    @functools.cached_property
    def convex(self) -> bool:  # type: ignore[override]
        """Whether the slope of the interpolation never decreases beyond rounding."""
        m = self._slopes
        rounding = _ROUNDING * np.abs(self._slopes).max()
        if self.kind == "linear":
            return bool((np.diff(m) >= -rounding).all())
        secant = np.diff(self.z) / np.diff(self.x)  # f'' is linear between samples: both its ends
        bends = 3 * secant - 2 * m[:-1] - m[1:], m[:-1] + 2 * m[1:] - 3 * secant
        return bool((np.minimum(*bends) >= -rounding).all())

    @functools.cached_property
    def apex(self) -> float | None:  # type: ignore[override]
        """The lowest point of a convex profile."""
        if not self.convex:
            return None
        lowest = int(np.argmin(self.z))
        m = self._slopes
        if self.kind == "linear" or not m[0] < 0 < m[-1]:
            return float(self.x[lowest])
        i = int(np.searchsorted(m, 0.0)) - 1
        h = float(self.x[i + 1] - self.x[i])
        bend = 6 * (self.z[i + 1] - self.z[i]) / h - 4 * m[i] - 2 * m[i + 1]
        curl = 3 * (m[i] + m[i + 1] - 2 * (self.z[i + 1] - self.z[i]) / h)
        root = math.sqrt(max(bend * bend / 4 - curl * m[i], 0.0))
        at = float(self.x[i] - h * m[i] / (bend / 2 + root))  # m + bend s + curl s² = 0
        near = float(self.x[np.abs(self.x - at).argmin()])
        return near if abs(near - at) <= _SAME * h else at

    @functools.cached_property
    def noise_slope(self) -> float:
        """Rms slope that noise makes between neighbouring samples; see energy.noise."""
        return noise_slope(self.x, self.z)

    def height(self, x: ArrayLike | float) -> Array:
        return self._read(x, self._heights, math.inf)

    def slope(self, x: ArrayLike | float) -> Array:
        return self._read(x, self._slants, math.nan)

    @functools.cached_property
    def _heights(self) -> Array:
        """Coefficients (2 or 4, n - 1) of the powers of the distance from the last sample in f."""
        h = np.diff(self.x)
        m = self._slopes
        rows = [self.z[:-1], m[: h.size]]
        if self.kind == "smooth":
            over = np.diff(self.z) / h - m[:-1], np.diff(m)
            rows += [(3 * over[0] - over[1]) / h, (over[1] - 2 * over[0]) / h**2]
        return np.array(rows)

    @functools.cached_property
    def _slants(self) -> Array:
        """The same in f'."""
        return self._heights[1:] * np.arange(1, len(self._heights))[:, None]

    def _read(self, x: Any, rows: Array, outside: float) -> Array:
        """What has these coefficients between the samples; a value for what is outside of them."""
        x = np.asarray(x, float)[()]  # numbers, not arrays of one: faster
        i = self.x[1:-1].searchsorted(x, side="right")
        t = x - self.x[i]
        value = rows[-1][i]
        for row in rows[-2::-1]:
            value = value * t + row[i]
        known = (x >= self.x[0]) & (x <= self.x[-1])
        if not x.ndim:
            return np.asarray(value if known else outside)
        return np.where(known, value, outside)


def _spline_slopes(x: Array, z: Array) -> Array:
    """Slopes at the samples that make the piecewise cubic twice differentiable.

    h_i m_{i-1} + 2(h_{i-1}+h_i) m_i + h_{i-1} m_{i+1} = 3(h_i s_{i-1} + h_{i-1} s_i), with the
    secants s and the spacings h; the two end slopes are given, by cubics through heights from the
    end on: a height of all samples would only round.
    """
    h = np.diff(x)
    secant = np.diff(z) / np.diff(x)
    near = min(4, x.size)
    ends = [
        np.polynomial.Polynomial.fit(x[i], z[i] - z[end], near - 1).deriv()(x[end])
        for i, end in ((slice(near), 0), (slice(-near, None), -1))
    ]
    band = np.zeros((3, x.size))
    rhs = np.empty_like(z)
    band[1, [0, -1]] = 1
    rhs[[0, -1]] = ends
    band[0, 2:] = h[:-1]
    band[1, 1:-1] = 2 * (h[:-1] + h[1:])
    band[2, :-2] = h[1:]
    rhs[1:-1] = 3 * (h[1:] * secant[:-1] + h[:-1] * secant[1:])
    return np.asarray(solve_banded((1, 1), band, rhs))
