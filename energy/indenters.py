"""The built-in shapes: plane, flat punch, wedge, parabola, circle, power law.

A new indenter is a frozen dataclass here with `height` and `slope`, a `Bowl` if it is convex and
its own mirror image; what else it may say stands in energy.indenter, where to name it in README.md.

Heights f are positive upwards [length], inf where there is no profile, slopes are df/dx, NaN there;
both have the shape of x. Of an `Indenter`, `apex` is the x of the lowest point, `symmetric` that f
is its own mirror image about it, `corners` are x at which the slope jumps, `knots` those at which a
higher derivative does, `extent` is where the profile is known, and `walls` are the ends of that at
which the body itself ends. `real`, `finite` and `positive` check an argument, whose name comes
first, and return it as a float; `real` allows any size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from energy.checks import finite, positive, real
from energy.indenter import Array, Indenter

# Of a power law: up to it |x|ⁿ is a float where |x| is ten times the width of the contact, 1e300.
_LARGEST_EXPONENT = 300

__all__ = ["Circle", "FlatPunch", "Parabola", "Plane", "PowerLaw", "Wedge"]


class Bowl(Indenter):
    """A convex profile, its own mirror image about 0 and smooth between its corners and knots."""

    apex = 0.0
    symmetric = convex = complete = True


@dataclass(frozen=True)
class Plane(Bowl):
    """Rigid plane f = 0 without end, case study 1, Eq. (19).

    Examples
    --------
    >>> from energy import Plane
    >>> Plane().height([-1.0, 2.0])
    array([0., 0.])
    """

    def shifted(self, x0: float) -> Plane:
        """The same plane, wherever it is moved to."""
        finite("x0", x0)
        return self

    def height(self, x: ArrayLike) -> Array:
        """0 everywhere."""
        return np.zeros_like(np.asarray(x, float))

    def slope(self, x: ArrayLike) -> Array:
        """0 everywhere."""
        return np.zeros_like(np.asarray(x, float))


@dataclass(frozen=True)
class FlatPunch(Bowl):
    """Flat punch f = 0 for |x| <= half_width and nothing (f = +inf) beyond, case study 2.

    Parameters
    ----------
    half_width : float
        Half its width, or its radius with rotational symmetry [length]; ValueError unless > 0.

    Examples
    --------
    >>> from energy import FlatPunch
    >>> FlatPunch(half_width=1.0).height([0.0, 0.9, 1.1])
    array([ 0.,  0., inf])
    """

    half_width: float

    def __post_init__(self) -> None:
        """ValueError unless the half-width is positive."""
        positive("half_width", self.half_width)

    @property
    def corners(self) -> tuple[float, ...]:  # type: ignore[override]
        """Its two edges."""
        return (-self.half_width, self.half_width)

    @property
    def extent(self) -> tuple[float, float]:  # type: ignore[override]
        """From edge to edge."""
        return (-self.half_width, self.half_width)

    walls = corners

    def height(self, x: ArrayLike) -> Array:
        """0 on the face, inf beyond."""
        return np.where(np.abs(np.asarray(x, float)) <= self.half_width, 0.0, math.inf)

    def slope(self, x: ArrayLike) -> Array:
        """0 on the face, NaN beyond."""
        return np.where(np.abs(np.asarray(x, float)) <= self.half_width, 0.0, math.nan)


@dataclass(frozen=True)
class Wedge(Bowl):
    """Wedge f = |x| tan δ, case study 3; a cone if it is turned about its axis.

    Parameters
    ----------
    delta : float
        Angle between its flanks and the surface [rad]; ValueError unless in (0, π/2).

    Examples
    --------
    >>> import math
    >>> from energy import Wedge
    >>> Wedge(delta=math.atan(0.1)).height([-2.0, 0.0, 1.0])
    array([0.2, 0. , 0.1])
    """

    delta: float
    corners = (0.0,)

    def __post_init__(self) -> None:
        """ValueError unless the angle is between 0 and π/2."""
        if not 0 < finite("delta", self.delta) < math.pi / 2:
            raise ValueError(f"delta = {self.delta!r} is outside (0, π/2); give the angle in rad")

    def height(self, x: ArrayLike) -> Array:
        """|x| tan δ."""
        return np.abs(np.asarray(x, float)) * math.tan(self.delta)

    def slope(self, x: ArrayLike) -> Array:
        """± tan δ, and 0 at the tip, the mean of both sides."""
        return np.sign(np.asarray(x, float)) * math.tan(self.delta)


@dataclass(frozen=True)
class Parabola(Bowl):
    """Parabola f = x²/(2R), the cylinder near its lowest line, Eq. (31); or the sphere likewise.

    Parameters
    ----------
    R : float
        Radius of curvature at the apex [length]; ValueError unless > 0.

    Examples
    --------
    >>> from energy import Parabola
    >>> Parabola(R=0.5).height([-1.0, 0.0, 2.0])
    array([1., 0., 4.])
    """

    R: float

    def __post_init__(self) -> None:
        """ValueError unless the radius is positive."""
        positive("R", self.R)

    def height(self, x: ArrayLike) -> Array:
        """x²/(2R)."""
        x = np.asarray(x, float)
        return x * x / (2 * self.R)

    def slope(self, x: ArrayLike) -> Array:
        """x/R."""
        return np.asarray(x, float) / self.R


@dataclass(frozen=True)
class Circle(Bowl):
    """The true arc f = R - √(R² - x²), |x| <= R: a cylinder, or a sphere if turned about its axis.

    Parameters
    ----------
    R : float
        Radius [length]; ValueError unless > 0.

    Notes
    -----
    The slope grows without limit towards |x| = R, where the body turns over and the profile ends.
    A line cannot get there with small slopes (l f' is not bounded); with finite slopes a deep
    contact would climb the upper half, which no f(x) describes: that is refused like the end of
    measured data. `Parabola` is the same near the lowest point, relative to within x²/(4R²).

    Examples
    --------
    >>> from energy import Circle
    >>> Circle(R=5.0).height([0.0, 3.0, 4.0])
    array([0., 1., 2.])
    """

    R: float

    def __post_init__(self) -> None:
        """ValueError unless the radius is positive."""
        positive("R", self.R)

    @property
    def extent(self) -> tuple[float, float]:  # type: ignore[override]
        """Where the body turns over; what is beyond is no function f(x)."""
        return (-self.R, self.R)

    def height(self, x: ArrayLike) -> Array:
        """R - √(R² - x²), inf for |x| > R."""
        x = np.asarray(x, float)
        chord2 = (self.R - x) * (self.R + x)
        with np.errstate(invalid="ignore"):
            arc = x * x / (self.R + np.sqrt(chord2))  # R - √(R² - x²) without cancellation
        return np.where(chord2 >= 0, arc, math.inf)[()]

    def slope(self, x: ArrayLike) -> Array:
        """x/√(R² - x²), ±inf at |x| = R, NaN beyond."""
        x = np.asarray(x, float)
        with np.errstate(invalid="ignore", divide="ignore"):
            return x / np.sqrt((self.R - x) * (self.R + x))


@dataclass(frozen=True)
class PowerLaw(Bowl):
    """Power law f = c |x|ⁿ: a wedge for n = 1, a parabola for 2, towards a flat punch for n → ∞.

    Parameters
    ----------
    c : float
        Prefactor [length¹⁻ⁿ]; ValueError unless > 0.
    n : float
        Exponent; ValueError unless from 1 to 300.

    Examples
    --------
    >>> from energy import PowerLaw
    >>> PowerLaw(c=0.5, n=3).height([0.0, 1.0, -2.0])
    array([0. , 0.5, 4. ])
    """

    c: float
    n: float
    knots = (0.0,)

    def __post_init__(self) -> None:
        """ValueError unless c > 0 and 1 <= n <= 300."""
        if not real("c", self.c) > 0:
            raise ValueError(f"c = {self.c!r} must be positive; give a value > 0")
        if finite("n", self.n) < 1:
            raise ValueError(f"n = {self.n!r} makes a cusp with a vertical tip; give n >= 1")
        if self.n > _LARGEST_EXPONENT:
            raise ValueError(f"n = {self.n!r} is a punch in all but name; use FlatPunch")

    @property
    def corners(self) -> tuple[float, ...]:  # type: ignore[override]
        """The tip of a wedge, n = 1; with n > 1 the slope does not jump."""
        return (0.0,) if self.n == 1 else ()

    def height(self, x: ArrayLike) -> Array:
        """c |x|ⁿ."""
        return self.c * np.abs(np.asarray(x, float)) ** self.n

    def slope(self, x: ArrayLike) -> Array:
        """± n c |x|ⁿ⁻¹, and 0 at x = 0."""
        x = np.asarray(x, float)
        return self.c * self.n * np.sign(x) * np.abs(x) ** (self.n - 1)
