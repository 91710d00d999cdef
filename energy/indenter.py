"""Rigid profiles f(x), measured upwards from the level f = 0.

Anything with vectorised `height(x)` and `slope(x)` is an indenter. The built-in ones also say
what a minimiser need not search for:

| attribute   | meaning                                                                      |
| ----------- | ---------------------------------------------------------------------------- |
| `apex`      | x of the lowest point if f never falls away from it on either side, or None   |
| `corners`   | increasing x where the slope jumps or the body ends: lines can be pinned      |
| `knots`     | x where only a higher derivative jumps; quadrature stops there                |
| `complete`  | between corners and knots f is smooth: quadrature need not look for more       |
| `extent`    | (lo, hi) beyond which f is not known; needed if it does not rise in the end    |
| `walls`     | the ends of `extent` at which the body itself ends (a punch, not a data set)   |
| `symmetric` | mirror-symmetric about the apex                                                |
| `convex`    | the slope never decreases: one contact, with one line on each side            |
| `noise_slope` | rms slope that noise makes between neighbouring samples; None without samples |

Arguments x are positions along the surface, of any shape; a tilt or a shift keeps the layout. With
rotational symmetry x is a radius. Where there is no profile the height is inf and the slope NaN.

Built-in shapes stand in indenters.py, measured ones in sampled.py; this file holds what they share:
the base class and the ways to compose profiles.

`finite`, `array` and `not_a_class` check an argument, whose name comes first: the first two return
it as a float or an array of floats, NaN and infinities allowed in an array alone; the last one
refuses a class.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from energy.arrays import Array
from energy.checks import array, finite, not_a_class

UNBOUNDED = (-math.inf, math.inf)
# Distance from a corner at which the slope beside it is read, over |x| and the largest corner:
# eight roundings, more than shifting a profile moves its corners by.
_BESIDE = 8 * float(np.finfo(float).eps)
# The same beside a corner at 0, in any unit: so small that it is no length of a scene, and so large
# that its square is a float (1e-300).
_BESIDE_ZERO = 1e-150


class Indenter:
    """Base of the built-in profiles: defaults of the optional attributes, and composition."""

    apex: float | None = None
    corners: Sequence[float] | Array = ()
    knots: Sequence[float] | Array = ()
    complete: bool = False
    extent: tuple[float, float] = UNBOUNDED
    walls: tuple[float, ...] = ()
    symmetric: bool = False
    convex: bool = False

    @property
    def noise_slope(self) -> float | None:
        """Rms slope that noise makes between neighbouring samples; None where none are known."""
        return None

    def height(self, x: ArrayLike) -> Array:
        """Height of the profile.

        Parameters
        ----------
        x : array_like
            Positions [length], of any shape.

        Returns
        -------
        ndarray
            f(x) [length], of the shape of x; inf where there is no profile.
        """
        raise NotImplementedError

    def slope(self, x: ArrayLike) -> Array:
        """Slope of the profile.

        Parameters
        ----------
        x : array_like
            Positions [length], of any shape.

        Returns
        -------
        ndarray
            f'(x) [1], of the shape of x; NaN where there is no profile.
        """
        raise NotImplementedError

    def height_and_slope(self, x: ArrayLike) -> tuple[Array, Array]:
        """Height and slope at the same positions, for profiles that find both faster together.

        Parameters
        ----------
        x : array_like
            Positions [length], of any shape.

        Returns
        -------
        height, slope : ndarray
            f(x) [length] and f'(x) [1], as `height` and `slope` have them.
        """
        return self.height(x), self.slope(x)

    def slope_beside(self, x: ArrayLike, side: ArrayLike) -> Array:
        """Slope on one side of x; the two sides of a corner differ.

        Parameters
        ----------
        x : array_like
            Positions [length].
        side : array_like of int
            1 for f'(x + 0), -1 for f'(x - 0), 0 for f'(x).

        Returns
        -------
        ndarray
            Slopes [1] of the common shape, read as near to x as rounding allows, inside the extent.
        """
        x = np.asarray(x, float)
        corners = np.asarray(self.corners, float)
        if not corners.size:
            return self.slope(x)
        size = np.maximum(np.abs(x), np.abs(corners[[0, -1]]).max())
        distance = np.maximum(_BESIDE * size, _BESIDE_ZERO)
        beside = x + np.asarray(side) * distance
        return self.slope(np.clip(beside, *self.extent))

    def breaks(self) -> Array:
        """x of the corners, the knots and the apex, between which a built-in profile is smooth."""
        apex = () if self.apex is None else (self.apex,)
        return np.array([*self.corners, *self.knots, *apex], float)

    def shifted(self, x0: float) -> Indenter:
        """The profile moved sideways, f(x - x0).

        Parameters
        ----------
        x0 : float
            [length]

        Returns
        -------
        Indenter
        """
        return Shifted(self, finite("x0", x0))

    def tilted(self, slope: float) -> Indenter:
        """The profile tilted by a small angle about x = 0, f(x) + slope·x.

        Parameters
        ----------
        slope : float
            [1]

        Returns
        -------
        Indenter
        """
        return Tilted(self, finite("slope", slope))

    def within(self, lo: float, hi: float) -> Indenter:
        """The profile as it is known between two places alone.

        Parameters
        ----------
        lo, hi : float
            The places [length].

        Returns
        -------
        Indenter
            Itself if it ends there already.
        """
        first = max(self.extent[0], lo)
        last = min(self.extent[1], hi)
        if (first, last) == tuple(self.extent):
            return self
        # Its ends are those of what is known, not of a body: neither walls nor corners.
        corners = [x for x in self.corners if first < x < last]
        knots = [x for x in self.knots if first < x < last]
        return Profile(self.height, self.slope, (first, last), corners, self.convex, knots)

    def __add__(self, other: object) -> Indenter:
        """Sum of two profiles, defined where both are."""
        return Sum(self, as_indenter(other))


@dataclass(frozen=True)
class Profile(Indenter):
    """Any profile from two functions that take arrays, height(x) and its derivative slope(x).

    Parameters
    ----------
    height, slope : callable
        f(x) [length] and f'(x) [1] of arrays x, made of numpy's functions.
    extent : tuple of two floats
        Where contact is looked for; needed if the profile has its lowest point far from x = 0 or
        does not rise in the end.
    corners : sequence of float
        Kinks that a contact line may be pinned at.
    convex : bool
        A promise that the slope never decreases: no other contacts are looked for.
    knots : sequence of float
        Where only a higher derivative jumps, such as the end of a rounding: integrals converge at
        once where they are given, and are refined until they do where not.

    Raises
    ------
    ValueError
        For functions that do not take arrays, and places that do not increase.

    Examples
    --------
    >>> import numpy as np
    >>> from energy import Profile
    >>> wavy = Profile(lambda x: x**2 - 0.1 * np.cos(x), lambda x: 2 * x + 0.1 * np.sin(x))
    >>> print(wavy.height(0.0))
    -0.1
    """

    height: Callable[[ArrayLike], Array] = field()  # type: ignore[assignment]
    slope: Callable[[ArrayLike], Array] = field()  # type: ignore[assignment]
    extent: tuple[float, float] = UNBOUNDED
    corners: Sequence[float] = ()
    convex: bool = False
    knots: Sequence[float] = ()

    def __post_init__(self) -> None:
        """Check that the functions take arrays, and that the places increase."""
        for name in ("height", "slope"):
            if not callable(getattr(self, name)):
                raise ValueError(f"{name} = {getattr(self, name)!r} must be a function of x")
        ends = array("extent", self.extent)
        if ends.shape != (2,) or not ends[0] < ends[1]:
            raise ValueError(f"extent = {self.extent!r} must be (lo, hi) with lo < hi")
        for name in ("height", "slope"):
            _takes_arrays(name, getattr(self, name), np.full(2, np.clip(0.0, *ends)))
        for name in ("corners", "knots"):
            x = array(name, getattr(self, name))
            if x.ndim != 1 or not (np.diff(x) > 0).all() or np.isnan(x).any():
                raise ValueError(f"{name} = {getattr(self, name)!r} must increase; sort them")


def _takes_arrays(name: str, function: Callable[[ArrayLike], Any], x: Array) -> None:
    """ValueError unless the function of x gives an array with one number for each position."""
    try:
        with np.errstate(all="ignore"):
            shape = np.shape(function(x))
    except (TypeError, ValueError, IndexError) as error:
        reason = f"{type(error).__name__}: {error}"
    else:
        if shape == x.shape:
            return
        reason = f"for {x.size} positions it gives {shape or 'one number'}"
    raise ValueError(
        f"{name} = {function!r} must take an array of x and give one number for each: write it "
        f"with numpy (np.maximum for max, np.where for if, np.zeros_like(x) for 0); {reason}"
    )


def as_indenter(profile: Any) -> Indenter:
    """The profile itself, or any object with height(x) and slope(x) as one.

    Parameters
    ----------
    profile : Indenter, or any object with these two methods

    Returns
    -------
    Indenter

    Raises
    ------
    ValueError
        For a class, and an object without these methods.
    """
    if isinstance(profile, Indenter):
        return profile
    not_a_class("indenter", profile)
    height = getattr(profile, "height", None)
    slope = getattr(profile, "slope", None)
    if not (callable(height) and callable(slope)):
        raise ValueError(
            f"indenter = {profile!r} has no methods height(x) and slope(x); "
            "use one of energy's indenters or Profile(height, slope)"
        )
    return Profile(height, slope)


@dataclass(frozen=True)
class Shifted(Indenter):
    """f(x - x0)."""

    base: Indenter
    x0: float

    def __post_init__(self) -> None:
        """Move the places of the base; promises stay as they are."""
        move = self.x0
        apex = self.base.apex
        extent = self.base.extent
        object.__setattr__(self, "apex", None if apex is None else apex + move)
        object.__setattr__(self, "corners", np.asarray(self.base.corners, float) + move)
        object.__setattr__(self, "knots", np.asarray(self.base.knots, float) + move)
        object.__setattr__(self, "extent", (extent[0] + move, extent[1] + move))
        object.__setattr__(self, "walls", tuple(c + move for c in self.base.walls))
        for name in ("symmetric", "convex", "complete"):
            object.__setattr__(self, name, getattr(self.base, name))

    @property
    def noise_slope(self) -> float | None:
        """That of the base: a shift does not change it."""
        return self.base.noise_slope

    def height(self, x: ArrayLike) -> Array:
        """f(x - x0) [length], of the shape of x."""
        return self.base.height(self._own(x))

    def slope(self, x: ArrayLike) -> Array:
        """f'(x - x0), of the shape of x."""
        return self.base.slope(self._own(x))

    def _own(self, x: ArrayLike) -> Array:
        """x in the base's frame; a place inside the extent stays inside in spite of rounding."""
        x = np.asarray(x, float)
        own = x - self.x0
        lo, hi = self.extent
        if math.isinf(lo) and math.isinf(hi):
            return own
        inside = (x >= lo) & (x <= hi)
        return np.where(inside, np.clip(own, *self.base.extent), own)


@dataclass(frozen=True)
class Tilted(Indenter):
    """f(x) + tilt·x."""

    base: Indenter
    tilt: float

    def __post_init__(self) -> None:
        """Take over what a tilt leaves as it is; the lowest point and the symmetry it does not."""
        for name in ("corners", "knots", "extent", "walls", "convex", "complete"):
            object.__setattr__(self, name, getattr(self.base, name))

    @property
    def noise_slope(self) -> float | None:
        """That of the base: neighbours are tilted alike."""
        return self.base.noise_slope

    def height(self, x: ArrayLike) -> Array:
        """f(x) + tilt·x [length], of the shape of x."""
        return self.base.height(x) + self.tilt * np.asarray(x, float)

    def slope(self, x: ArrayLike) -> Array:
        """f'(x) + tilt, of the shape of x."""
        return self.base.slope(x) + self.tilt


@dataclass(frozen=True)
class Sum(Indenter):
    """f₁(x) + f₂(x), where both are defined."""

    first: Indenter
    second: Indenter

    def __post_init__(self) -> None:
        """Join the places of both inside the common extent; ValueError where there is none."""
        one = self.first
        two = self.second
        lo = max(one.extent[0], two.extent[0])
        hi = min(one.extent[1], two.extent[1])
        if not lo < hi:
            raise ValueError(f"the profiles {one!r} and {two!r} have no common points; shift one")
        object.__setattr__(self, "extent", (lo, hi))
        for name in ("corners", "knots"):
            both = np.union1d(np.asarray(getattr(one, name)), np.asarray(getattr(two, name)))
            inside = both[(both >= lo) & (both <= hi)]
            object.__setattr__(self, name, inside.astype(float))
        walls = {*one.walls, *two.walls} & {lo, hi}  # a wall inside the other's extent ends both
        object.__setattr__(self, "walls", tuple(sorted(walls)))
        for name in ("convex", "complete"):
            object.__setattr__(self, name, getattr(one, name) and getattr(two, name))
        if one.apex is not None and one.apex == two.apex:  # else it is not known, and stays None
            object.__setattr__(self, "apex", one.apex)
            object.__setattr__(self, "symmetric", one.symmetric and two.symmetric)

    @property
    def noise_slope(self) -> float | None:
        """Of noise in either that is independent of that in the other."""
        known = [part.noise_slope for part in (self.first, self.second)]
        slopes = [slope for slope in known if slope is not None]
        return math.hypot(*slopes) if slopes else None

    def height(self, x: ArrayLike) -> Array:
        """f₁(x) + f₂(x) [length], of the shape of x."""
        return self.first.height(x) + self.second.height(x)

    def slope(self, x: ArrayLike) -> Array:
        """f₁'(x) + f₂'(x), of the shape of x."""
        return self.first.slope(x) + self.second.slope(x)
