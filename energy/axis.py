"""Rotational symmetry: the profile f(r), r >= 0, turned about the axis r = 0."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from energy.indenter import Array, Indenter
from energy.indenters import Plane
from energy.pattern import Patches
from energy.sampled import Sampled

# f(-x) may differ from f(x) by this share of how much f rises up to there: heights that are read
# from a text of twelve digits do.
_OF_RISE = 1e-12
# Or by this share of f itself: eight roundings, where a profile does not rise.
_OF_HEIGHT = 8 * float(np.finfo(float).eps)
# Places at which a profile is compared with its mirror image, over its half-width: evenly spaced
# ones, so that no wave of some hundredths of it is missed, and others that crowd at the centre.
_PLACES = np.sort(np.concatenate([np.geomspace(1e-6, 1, 400), np.linspace(0, 1, 600)[1:-1]]))
# How far an endless profile is compared, in the longest length of the scene: contacts beyond are
# wider than any that the model is for.
_FAR = 1e3


@dataclass(frozen=True)
class Mirrored(Indenter):
    """f(|x|) of a profile that is known on x >= 0 only; a corner at 0 unless f'(0) = 0."""

    base: Indenter
    symmetric = True

    def __post_init__(self) -> None:
        base = self.base
        end = base.extent[1]
        slope_at_axis = float(base.slope(0.0))
        convex = base.convex and slope_at_axis >= 0
        for name in ("corners", "knots"):
            right = np.asarray(getattr(base, name), float)
            both = np.concatenate([-right, right])
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
        return self.base.noise_slope

    def height(self, x: ArrayLike) -> Array:
        return self.base.height(np.abs(np.asarray(x, float)))

    def slope(self, x: ArrayLike) -> Array:
        x = np.asarray(x, float)
        return np.sign(x) * self.base.slope(np.abs(x))


class Radial(Indenter):
    """The half r >= 0 of a profile that is mirror-symmetric about the axis.

    The axis is an end of it like that of a body, and the slope of a tip at r = 0 is that beside it.

    Parameters
    ----------
    whole : Indenter
        The profile, its apex at 0 if it has one.
    """

    def __init__(self, whole: Indenter) -> None:
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
        return repr(self._whole)

    @property
    def noise_slope(self) -> float | None:
        return self._whole.noise_slope

    def slope(self, x: ArrayLike) -> Array:
        x = np.asarray(x, float)
        right_of_axis = np.equal(x, 0).astype(int)
        return self._whole.slope_beside(x, right_of_axis)


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
    if indenter.symmetric and indenter.apex == 0:
        return indenter
    if unlike := difference(indenter, 0.0, length):
        raise ValueError(f"{unlike}: {_REMEDY}")
    return indenter


def difference(indenter: Indenter, centre: float, length: float) -> str:
    """Where a profile is not its own mirror image about a place, as the beginning of a message.

    Its heights are compared at the places of this module.

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
        The first two heights that differ beyond rounding; "" if there are none.
    """
    low = indenter.extent[0] - centre
    high = indenter.extent[1] - centre
    ends = math.isfinite(high - low)
    lopsided = abs(low + high) > _OF_RISE * (high - low) if ends else -low != high
    if lopsided:
        return f"extent = {indenter.extent}"
    reach = high if math.isfinite(high) else _FAR * length
    r = _PLACES * reach
    right_places = np.clip(centre + r, *indenter.extent)
    left_places = np.clip(centre - r, *indenter.extent)
    with np.errstate(all="ignore"):
        right = np.asarray(indenter.height(right_places), float)
        left = np.asarray(indenter.height(left_places), float)
        rise = np.fmax.accumulate(np.abs(right - indenter.height(centre)))
        if math.isfinite(high):
            rise[:] = rise[-1]  # rounding of samples is that of their neighbours
        rounding = np.maximum(_OF_RISE * rise, _OF_HEIGHT * np.abs(right))
        alike = (np.abs(right - left) <= rounding) | (right == left)
        unlike = ~(alike | np.isnan(right + left))
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
    x = np.concatenate([-indenter.x[:0:-1], indenter.x])
    z = np.concatenate([indenter.z[:0:-1], indenter.z])
    whole = replace(indenter, x=x, z=z)
    if whole.kind == "linear":
        return whole
    axis = indenter.x.size - 1
    return whole.level_at(axis)


def check_rings(pattern: Patches) -> None:
    """Refuse a pattern that reaches to x < 0 without being its own mirror image.

    Parameters
    ----------
    pattern : Patches

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
