"""Rotational symmetry: the profile f(r), r >= 0, turned about the axis r = 0."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from energy.indenter import Array, Indenter
from energy.indenters import Plane
from energy.pattern import Patches
from energy.sampled import Sampled

_ROUNDING = 1e-12  # of the rise of f from 0 as far out: what f(-x) may differ from f(x) by
_ROUNDINGS = 8 * float(np.finfo(float).eps)  # of f, if it does not rise
_PLACES = np.sort(np.concatenate([np.geomspace(1e-6, 1, 400), np.linspace(0, 1, 600)[1:-1]]))
_FAR = 1e3  # lengths of the scene, as far as an endless profile is compared with its mirror image


@dataclass(frozen=True)
class Mirrored(Indenter):
    """f(|x|) of a profile that is known on x >= 0 only; a corner at 0 unless f'(0) = 0."""

    base: Indenter
    symmetric = True

    def __post_init__(self) -> None:
        base = self.base
        end = self.base.extent[1]
        steep = float(base.slope(0.0))
        convex = base.convex and steep >= 0
        for name in ("corners", "knots"):
            own = np.asarray(getattr(base, name), float)
            centre = [0.0] if steep or name == "knots" else []
            object.__setattr__(self, name, np.union1d(np.concatenate([-own, own]), centre))
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
    """The half r >= 0 of a profile that is mirror-symmetric about the axis, which is its wall.

    Of a tip the slope at r = 0 is that beside it.
    """

    def __init__(self, whole: Indenter) -> None:
        end = whole.extent[1]
        self.height = whole.height  # type: ignore[method-assign]
        self._whole = whole
        if not np.isin(0.0, whole.corners):
            self.slope = whole.slope  # type: ignore[method-assign]
        self.extent = (0.0, end)
        self.walls = (0.0, *(x for x in whole.walls if x > 0))
        self.corners, self.knots = (
            np.asarray([x for x in places if x > 0], float)
            for places in (whole.corners, whole.knots)
        )
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
        return self._whole.slope_beside(x, np.equal(x, 0).astype(int))


def about_axis(indenter: Indenter, length: float) -> Indenter:
    """The indenter as a profile that is mirror-symmetric about 0.

    One that begins at r = 0 is mirrored; any other is compared with its mirror image on samples,
    an endless one from 1e-6 to 1e3 of `length`. ValueError for a difference beyond rounding, and
    for a plane without end, which has neither a radius nor a finite energy.
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
    """Where a profile is not its own mirror image about a place, in words; "" where it is.

    By its heights on samples, of an endless one from 1e-6 to 1e3 of `length`.
    """
    lo, hi = (x - centre for x in indenter.extent)
    if abs(lo + hi) > _ROUNDING * (hi - lo) if math.isfinite(hi - lo) else -lo != hi:
        return f"extent = {indenter.extent}"
    r = _PLACES * (hi if math.isfinite(hi) else _FAR * length)
    with np.errstate(all="ignore"):
        places = (np.clip(centre + x, *indenter.extent) for x in (r, -r))
        one, other = (np.asarray(indenter.height(x), float) for x in places)
        rise = np.fmax.accumulate(np.abs(one - indenter.height(centre)))
        if math.isfinite(hi):
            rise[:] = rise[-1]  # rounding of samples is that of their neighbours
        noise = np.maximum(_ROUNDING * rise, _ROUNDINGS * np.abs(one))
        off = ~((np.abs(one - other) <= noise) | (one == other) | np.isnan(one + other))
    if not off.any():
        return ""
    at = int(np.flatnonzero(off)[0])
    pair = f"f({centre + r[at]:.6g}) = {one[at]!s} and f({centre - r[at]:.6g}) = {other[at]!s}"
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
    x = indenter.x
    z = indenter.z
    whole = replace(indenter, x=np.concatenate([-x[:0:-1], x]), z=np.concatenate([z[:0:-1], z]))
    return whole if whole.kind == "linear" else whole.level_at(x.size - 1)


def check_rings(pattern: Patches) -> None:
    """ValueError for a pattern that reaches to x < 0 without being its own mirror image."""
    edges = np.asarray(pattern.edges)
    factors = np.asarray(pattern.factors)
    mirrored = np.allclose(edges, -edges[::-1], rtol=_ROUNDING, atol=0)
    if edges.size and edges[0] < 0 and not (mirrored and (factors == factors[::-1]).all()):
        raise ValueError(
            f"pattern = {pattern!r} is not mirror-symmetric about 0; for geometry='axisymmetric' "
            "give edges r >= 0 only, or both halves alike"
        )
