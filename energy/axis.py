"""Rotational symmetry: the profile f(r), r >= 0, turned about the axis r = 0.

Conventions: a `Scene` keeps the mirror-symmetric profile f(|x|) on x < 0 and x > 0 (`about_axis`);
solvers about the axis take its half r >= 0 (`Radial`). Heights are positive upwards, inf where
there is no profile, where slopes are NaN. The attributes are those of `energy.indenter.Indenter`:
`extent` (low, high) is where f is known, `walls` are those of its ends at which the body itself
ends, `corners` and `knots` are increasing x at which f' or a higher derivative jumps, `complete`
promises that there are no others, `convex` that f' never decreases, and `apex` is the x of the
lowest point, None if it is not known. `symmetric` is the promise of a built-in profile to be its
own mirror image: about its apex if it has one, and of a `Mirrored` always about 0. `noise_slope` is
the rms slope that noise makes between neighbouring samples, None of profiles without samples.
`slope_beside(x, side)` is f' a few roundings beside x, on the right of it for side 1, on the left
for -1; for side 0 it is f'(x).

`Plane` is f = 0 without end. `Sampled` has its samples `x` and `z` (n,), x increasing, and `kind`,
"linear" or "smooth", how they are interpolated; `level_at(i)` is the spline whose slope at sample i
is set to 0. `Patches` has `edges` (n,), increasing x [length], and between and beyond them n + 1
`factors` on the work of adhesion.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from energy.indenter import Array, Indenter
from energy.indenters import Plane
from energy.pattern import Patches
from energy.sampled import Sampled

# f(-x) may differ from f(x) by this share of how much f rises up to there, both ends of the extent
# by this share of its width, and edges of patterns by this share of themselves: numbers that are
# read from a text of twelve digits do.
_OF_RISE = 1e-12
# Or by this share of f itself, where a profile does not rise: both heights are sums and products of
# a few terms with an error of half a rounding each, eight of them on either side.
_OF_HEIGHT = 8 * float(np.finfo(float).eps)
# Places at which a profile is compared with its mirror image, over its half-width. 598 evenly
# spaced ones are three in every wave of a two-hundredth of it. As an endless profile may differ at
# its centre alone, 400 more lie in a geometric series over six decades: they meet what is as wide
# as 3.5 % of its distance from the centre, down to a thousandth of the longest length of the scene
# (`_FAR`). Of a spline all take 0.1 ms; ten times as many take 0.9 ms, as long as a state does.
_PLACES = np.sort(np.concatenate([np.geomspace(1e-6, 1, 400), np.linspace(0, 1, 600)[1:-1]]))
# How far an endless profile is compared, in the longest of the lengths l, δ₀ and h of the scene.
# Contacts of parabolas of radius R reach some √(Rδ₀), no farther than this for R up to 1e6 of that
# length; a profile that is lopsided farther out is not looked at.
_FAR = 1e3


@dataclass(frozen=True)
class Mirrored(Indenter):
    """f(|x|) of a profile that is known on x >= 0 only; a corner at 0 unless f'(0) = 0.

    Parameters
    ----------
    base : Indenter
        The half-profile, whose extent begins at 0.
    """

    base: Indenter
    symmetric = True

    def __post_init__(self) -> None:
        """Set the attributes of both halves from those of the right one."""
        base = self.base
        end = base.extent[1]
        slope_at_axis = float(base.slope(0.0))
        # A half that falls from the axis on is a peak of the whole, which is then not convex.
        convex = base.convex and slope_at_axis >= 0
        for name in ("corners", "knots"):
            right = np.asarray(getattr(base, name), float)
            both = np.concatenate([-right, right])
            # f'''(0) of the half need not be 0, so that 0 is always a knot.
            jumps_at_axis = slope_at_axis != 0 or name == "knots"
            centre = [0.0] if jumps_at_axis else []
            object.__setattr__(self, name, np.union1d(both, centre))
        object.__setattr__(self, "walls", (-end, end) if end in base.walls else ())
        object.__setattr__(self, "extent", (-end, end))
        object.__setattr__(self, "complete", base.complete)
        object.__setattr__(self, "convex", convex)
        object.__setattr__(self, "apex", 0.0 if convex else None)

    @property
    def noise_slope(self) -> float | None:
        """That of the half-profile, whose samples are mirrored with their noise."""
        return self.base.noise_slope

    def height(self, x: ArrayLike) -> Array:
        """f(|x|) [length], of the shape of x."""
        return self.base.height(np.abs(np.asarray(x, float)))

    def slope(self, x: ArrayLike) -> Array:
        """sign(x) f'(|x|), of the shape of x; 0 at x = 0, between both slopes of a corner there."""
        x = np.asarray(x, float)
        return np.sign(x) * self.base.slope(np.abs(x))


class Radial(Indenter):
    """The half r >= 0 of a profile that is mirror-symmetric about the axis.

    Its extent begins at the axis, which is one of its walls, as no contact line can pass it. The
    slope at r = 0 is f'(0 + 0), that of a cone's flank and not the 0 of its tip.

    Parameters
    ----------
    whole : Indenter
        The profile, its apex at 0 if it has one.
    """

    def __init__(self, whole: Indenter) -> None:
        """Take over what the whole profile has at r > 0, and its functions as they are there."""
        end = whole.extent[1]
        self.height = whole.height  # type: ignore[method-assign]
        self._whole = whole
        if not np.isin(0.0, whole.corners):
            self.slope = whole.slope  # type: ignore[method-assign]
        self.extent = (0.0, end)
        self.walls = (0.0, *(x for x in whole.walls if x > 0))
        self.corners = np.asarray([x for x in whole.corners if x > 0], float)
        self.knots = np.asarray([x for x in whole.knots if x > 0], float)
        self.apex = 0.0 if whole.apex == 0 else None
        self.complete = whole.complete
        self.convex = whole.convex

    def __repr__(self) -> str:
        """As the whole profile is written, since messages are about what the user gave."""
        return repr(self._whole)

    @property
    def noise_slope(self) -> float | None:
        """That of the whole profile, of which this is a half."""
        return self._whole.noise_slope

    def slope(self, x: ArrayLike) -> Array:
        """f'(x), and f'(0 + 0) at the axis; used where the whole profile has a corner there."""
        x = np.asarray(x, float)
        side = np.equal(x, 0).astype(int)  # 1, on the right of it, at the axis; 0, at x, elsewhere
        return self._whole.slope_beside(x, side)


def about_axis(indenter: Indenter, length: float) -> Indenter:
    """The indenter as a profile that is mirror-symmetric about 0.

    One that begins at r = 0 is mirrored; any other is compared with its mirror image on samples.

    Parameters
    ----------
    indenter : Indenter
    length : float
        The longest length of the scene: an endless profile is compared up to 1e3 of it.

    Returns
    -------
    Indenter
        The same one, or both halves of one whose extent begins at 0.

    Raises
    ------
    ValueError
        For a difference beyond rounding, and for a plane without end, which has neither a radius
        nor a finite energy.
    """
    if isinstance(indenter, Plane):
        raise ValueError(
            f"indenter = {indenter!r} without end has no radius when turned about the axis; use "
            "FlatPunch(half_width), or geometry='line'"
        )
    if indenter.extent[0] == 0:
        return _mirrored(indenter)
    if indenter.symmetric and indenter.apex == 0:  # mirror-symmetric about its apex, 0
        return indenter
    if unlike := difference(indenter, 0.0, length):
        raise ValueError(f"{unlike}: {_REMEDY}")
    return indenter


def difference(indenter: Indenter, centre: float, length: float) -> str:
    """Where a profile is not its own mirror image about a place, as the beginning of a message.

    Its heights are compared at the places of this module. Two that are infinite are alike. One that
    is NaN is not compared: a function such as r**1.5 has no value on the left of the centre, and
    is used on the right alone.

    Parameters
    ----------
    indenter : Indenter
    centre : float
        x [length] of the place.
    length : float
        The longest length of the scene: an endless profile is compared up to 1e3 of it.

    Returns
    -------
    str
        The extent if its ends are not at the same distance from the centre, else the first two
        heights that differ beyond rounding; "" if there are none.
    """
    low = indenter.extent[0] - centre
    high = indenter.extent[1] - centre
    ends = math.isfinite(high - low)
    lopsided = abs(low + high) > _OF_RISE * (high - low) if ends else -low != high
    if lopsided:
        return f"extent = {indenter.extent}"
    reach = high if math.isfinite(high) else _FAR * length
    r = _PLACES * reach  # distances from the centre
    right_places = np.clip(centre + r, *indenter.extent)
    left_places = np.clip(centre - r, *indenter.extent)
    with np.errstate(all="ignore"):
        right = np.asarray(indenter.height(right_places), float)
        left = np.asarray(indenter.height(left_places), float)
        # The largest rise between the centre and each place, since terms of that size cancel there.
        risen = np.abs(right - indenter.height(centre))
        rise = np.fmax.accumulate(np.where(np.isinf(right), 0.0, risen))
        if math.isfinite(high):
            rise[:] = rise[-1]  # samples are all rounded alike, by the digits of the highest
        rounding = np.maximum(_OF_RISE * rise, _OF_HEIGHT * np.abs(right))
        close = (np.abs(right - left) <= rounding) & np.isfinite(right)
        alike = close | (right == left)  # equal ones may be infinite
        unlike = ~(alike | np.isnan(right) | np.isnan(left))
    if not unlike.any():
        return ""
    first = int(np.flatnonzero(unlike)[0])
    pair = (
        f"f({centre + r[first]:.6g}) = {right[first]!s} and "
        f"f({centre - r[first]:.6g}) = {left[first]!s}"
    )
    return f"indenter = {indenter!r}: {pair} differ"


_REMEDY = (
    "geometry='axisymmetric' turns f(r), r >= 0, about the axis, so that a profile must be "
    "mirror-symmetric about 0 or begin there; remove what shifts or tilts it, or give its half "
    "from r = 0 on"
)


def _mirrored(indenter: Indenter) -> Indenter:
    """Both halves of a profile that begins at r = 0; of smooth samples one curve with f'(0) = 0."""
    if not isinstance(indenter, Sampled):
        return Mirrored(indenter)
    # The samples in reverse order without the one at r = 0, then all samples.
    x = np.concatenate([-indenter.x[:0:-1], indenter.x])
    z = np.concatenate([indenter.z[:0:-1], indenter.z])
    whole = replace(indenter, x=x, z=z)
    if whole.kind == "linear":
        return whole
    axis = indenter.x.size - 1  # index of the sample at r = 0
    return whole.level_at(axis)


def check_rings(pattern: Patches) -> None:
    """Refuse a pattern that reaches to x < 0 without being its own mirror image.

    Parameters
    ----------
    pattern : Patches
        Of edges x and of factors between them from left to right. One whose edges are all >= 0 is
        given by radii, and its mirror image is not needed.

    Raises
    ------
    ValueError
    """
    edges = np.asarray(pattern.edges)
    factors = np.asarray(pattern.factors)
    mirrored = np.allclose(edges, -edges[::-1], rtol=_OF_RISE, atol=0)
    symmetric = mirrored and (factors == factors[::-1]).all()
    if edges.size and edges[0] < 0 and not symmetric:
        raise ValueError(
            f"pattern = {pattern!r} is not mirror-symmetric about 0; for geometry='axisymmetric' "
            "give edges r >= 0 only, or both halves alike"
        )
