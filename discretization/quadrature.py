"""Integrals over the profile, by Gauss points on panels that are halved until that changes nothing.

Panels end at corners, knots, the apex and the edges of a pattern, between which a built-in indenter
is smooth. Of one that does not say so (Indenter.complete) a panel and its halves may agree by luck
beside a jump of the slope or of a higher derivative. There the halves are no better than a part of
what the panel was off by: that is counted, too. What is off by the rounding of its sum, or of the
heights, is not halved.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.rounding import EPSILON, ROUNDING, height_rounding
from energy import Scene, terms

Array = NDArray[np.float64]
Density = Callable[[Array], Array]  # of places (n, p): several densities (m, n, p)
Free = tuple[float, float, float, float]  # of the free surfaces: F, what they pull, k∫u, |pull|
NONE: Free = 0.0, 0.0, 0.0, 0.0
_FEW_PANELS = 50  # of which each gets many points, crowded at its ends
_MANY, _PLAIN = 28, 12  # points of half such a panel; of one of many panels
_HALVINGS = 48  # of a panel, to the spacing of floating-point numbers
_PART = 0.1  # of rtol for the quadrature
_SUMMED = 80 * EPSILON  # of the sizes of the terms of a panel's sum
_LUCK = 1 / 8  # of what the whole was off by


class Sums(NamedTuple):
    """Integrals (m, n) over panels with ends (2, n), those of absolute values, errors (m, n)."""

    ends: Array
    sums: Array
    sizes: Array
    off: Array

    def among(self, own: NDArray[np.bool_]) -> Sums:
        """Of some panels."""
        return Sums(*(part[:, own] for part in self))


def over(density: Density, ends: Array, *, few: bool = False) -> tuple[Array, Array]:
    """Integrals (m, n) over panels with ends (2, n) as they are, and of absolute values."""
    (at, weights), (lo, hi) = _rule(few), ends[..., None]
    values, width = density(lo + (hi - lo) * at), (hi - lo)[:, 0]
    return (values @ weights) * width, (np.abs(values) @ weights) * width


def summed(density: Density, ends: Array, part: float, lost: Array, *, smooth: bool) -> Sums:
    """Integrals over panels, those halved that are off by more than a part of the whole's size.

    lost (m, 1): what they are off by however often they are halved; smooth: on each panel.
    """
    few, n = ends.shape[1] < _FEW_PANELS, ends.shape[1]
    left, done = Sums(ends, *over(density, ends, few=few), np.zeros((len(lost), n))), []
    limit = part * left.sizes.sum(axis=1, keepdims=True) + lost
    for _ in range(_HALVINGS):
        (lo, hi), n = left.ends, left.ends.shape[1]
        middle = (lo + hi) / 2
        halves = np.array([np.append(lo, middle), np.append(middle, hi)])
        sums, sizes = over(density, halves, few=few)
        apart = np.abs(sums[:, :n] + sums[:, n:] - left.sums)
        off = np.maximum(apart, left.off)
        rough = (off > np.maximum(limit, _SUMMED * left.sizes)).any(axis=0)
        rough &= (lo < middle) & (middle < hi)
        whole = sums[:, :n] + sums[:, n:], sizes[:, :n] + sizes[:, n:]
        done.append(Sums(left.ends, *whole, off).among(~rough))
        luck = np.tile(apart * (0.0 if smooth else _LUCK), 2)
        left = Sums(halves, sums, sizes, luck).among(np.tile(rough, 2))
        if not rough.any():
            break
    found = Sums(*(np.hstack(parts) for parts in zip(*done, left, strict=True)))
    found.off[:, :1] += lost
    return found


def in_contact(scene: Scene, depth: float, contacts: Array, rtol: float) -> tuple[Sums, float]:
    """Springs, surface, adhesion as it binds and pressure over contacts (m, 2).

    And what the heights are off by as measured, which is counted in what the sums are off by.
    """
    ends, smooth = _ends(scene, contacts), scene.indenter.complete
    rounding, lost = height_rounding(scene.indenter, ends.T), np.zeros((4, 1))
    if rounding:
        deepest = float(np.abs(depth - scene.indenter.height(ends)).max())
        wide = np.diff(contacts).sum() + 2 * scene.elastocapillary_length
        felt = rounding * scene.stiffness * wide * float(scene.measure(contacts.max()))
        lost[[0, 3], 0] = felt * deepest, felt
    part = max(_PART * rtol, ROUNDING) / max(1, ends.shape[1])
    found = summed(lambda x: _densities(scene, depth, x), ends, part, lost, smooth=smooth)
    return found, rounding


def _ends(scene: Scene, contacts: Array) -> Array:
    """Ends (2, n) of the panels of contacts (m, 2)."""
    indenter, pattern = scene.indenter, scene.pattern
    apex = () if indenter.apex is None else (indenter.apex,)
    edges = () if pattern is None else pattern.edges
    cuts = np.unique(np.concatenate([indenter.corners, indenter.knots, apex, edges]))
    parts = [
        np.concatenate([[left], cuts[(cuts > left) & (cuts < right)], [right]])
        for left, right in contacts.tolist()
    ]
    return np.hstack([[part[:-1], part[1:]] for part in parts])


def stretched(scene: Scene, x: Array, slope: Array) -> tuple[Array, Array]:
    """What the surface stores in contact at x, and its length as it adheres, over dx."""
    stored = terms.contact(slope, gamma1=scene.gamma1, w=0.0, slopes=scene.slopes)
    bound = np.ones_like(slope) if scene.slopes == "small" else np.sqrt(1 + slope * slope)
    return stored, bound if scene.pattern is None else bound * scene.pattern.factor(x)


def _densities(scene: Scene, depth: float, x: Array) -> Array:
    """Of what is integrated over contacts."""
    spring, pressure, _ = terms.spring(depth - scene.indenter.height(x), k=scene.stiffness)
    stored, bound = stretched(scene, x, np.asarray(scene.indenter.slope(x), float))
    found = np.array([spring, stored, scene.work_of_adhesion * bound, pressure])
    return found * scene.measure(x) if scene.axisymmetric else found


@functools.lru_cache(maxsize=2)
def _rule(few: bool) -> tuple[Array, Array]:
    """Gauss points and weights on [0, 1]; of many, half for each half, crowded at the ends by t⁴.

    A power law is not smooth where the panels end.
    """
    t, weights = np.polynomial.legendre.leggauss(_MANY if few else _PLAIN)
    t, weights = (t + 1) / 2, weights / 2
    if not few:
        return t, weights
    near, weights = t**4 / 2, 2 * weights * t**3
    return np.concatenate([near, 1 - near]), np.concatenate([weights, weights])


class Interval(NamedTuple):
    """Totals over contacts and their free surfaces, with the force by two routes.

    errors: of energy and force by the quadrature; rounding: what the heights are off by as measured
    [length], counted in these.
    """

    energy: float
    force: float
    force_by_field: float
    energy_scale: float
    force_scale: float
    errors: tuple[float, float] = (0.0, 0.0)
    rounding: float = 0.0


def refined(scene: Scene, depth: float, contacts: Array, free: Free, rtol: float) -> Interval:
    """Energy and force of contacts (m, 2); free: what the free surfaces beside them add."""
    found, rounding = in_contact(scene, depth, contacts, rtol)
    springs, tension, adhesion, force = found.sums.sum(axis=1).tolist()
    off, size = found.off.sum(axis=1), float(found.sizes[3].sum())
    energy, pull, area, pulls = free
    stored = springs + tension + energy
    totals = stored - adhesion, force + pull, force + area, stored + adhesion, size + pulls
    return Interval(*totals, (float(off[:3].sum()), float(off[3])), rounding)
