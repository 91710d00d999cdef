"""Energy and force of fitted contacts, integrated by Gauss points until fewer points agree.

Between its corners and knots a built-in indenter is smooth. Of a profile that does not say so
(Indenter.complete) fewer and more points on the same panel may agree by luck beside a jump of the
slope or of a higher derivative: there each panel is compared with its halves, too. Panels that
disagree are halved, so that they close in on such a jump:

    Σ_panels |many - few|, |whole - halves|  <=  max(rtol/10, 16 ε) · scale + rounding of heights.

A sum of n terms is rounded by up to n ε of their sizes: what disagrees by no more is not halved.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.rounding import EPSILON, ROUNDING, height_rounding
from discretization.surfaces.protocol import At, Surfaces
from energy import Indenter, Scene, terms

Array = NDArray[np.float64]
_FEW_PANELS = 50  # fewer are taken with many points at once, more with few points first
_MOST_PANELS = 1 << 12  # beyond those between declared corners and knots
_PART = 0.1  # of rtol for the quadrature
_SUMMED = 80 * EPSILON  # of the sizes of the 80 terms of a panel's larger sum
_PLAIN = 6  # up to so many points: an ungraded panel
_LUCK = 1 / 8  # of what the whole was off by: at a jump of f'' the halves are no better than that


class Interval(NamedTuple):
    """Totals over fitted contacts and their free surfaces, with the force by two routes.

    Numbers, or arrays (n,) of several states. rounding: what the heights are off by as measured
    [length], counted in force and energy.
    """

    energy: Any
    force: Any
    force_by_field: Any
    energy_scale: Any
    force_scale: Any
    weakest: Any
    rounding: Any = 0.0

    def change(self, other: Interval) -> float:
        """Largest of the relative differences of energy and force."""
        apart = np.abs([self.energy - other.energy, self.force - other.force])
        scale = np.array([self.energy_scale, self.force_scale])
        return float((apart / np.where(scale > 0, scale, 1.0)).max(initial=0.0))


def inside(
    scene: Scene, depth: Array, ends: Array, orders: tuple[int, int] | None = None
) -> tuple[Array, Array]:
    """Integrals over contacts at depths (n,) or (1,), and their least g (n,).

    (2, 5, n), on the panels between ends (n, m + 1) by fewer and by more points: springs, surface,
    adhesion as it binds, kg and |kg|.
    """
    gamma1, w, slopes = scene.gamma1, scene.work_of_adhesion, scene.slopes
    x, span = _points(ends, *_pair(*(orders or _orders(ends))))
    g, slope = depth[:, None] - scene.indenter.height(x), scene.indenter.slope(x)
    stretch = terms.contact(slope, gamma1=gamma1, w=0.0, slopes=slopes)
    bound = stretch - terms.contact(slope, gamma1=gamma1, w=w, slopes=slopes)
    if scene.pattern is not None:
        bound = bound * scene.pattern.factor(x)
    spring, pressure, _ = terms.spring(g, k=scene.stiffness)
    densities = np.array([spring, stretch, bound, pressure, np.abs(pressure)])
    if scene.axisymmetric:
        densities *= scene.measure(x)
    return np.einsum("rij,dij->rdi", span, densities), g.min(axis=1, initial=0.0)


def beside(
    surfaces: Surfaces, depth: float, left: float, right: float
) -> tuple[float, float, float, float]:
    """Energy, reaction, area (times k) and |reaction|, summed over the surfaces beyond lines."""
    one, other = (At(x, float(surfaces.scene.indenter.height(x))) for x in (left, right))
    last = surfaces.free(other, None, depth)
    alike = one.f == other.f and not surfaces.scene.axisymmetric  # one surface and its mirror image
    first = last if alike else surfaces.free(None, one, depth)
    pulls = first.pulls[0 if alike else 1], last.pulls[0]
    return first.energy + last.energy, sum(pulls), first.area + last.area, sum(map(abs, pulls))


def _summed(sums: Iterable[Any], free: Iterable[Any]) -> tuple[Any, Any, Any, Any, Any]:
    """The first five of an `Interval` from the integrals over contacts and the free surfaces."""
    springs, tension, adhesion, force, size = sums
    energy, pull, area, pulls = free
    stored = springs + tension + energy
    return stored - adhesion, force + pull, force + area, stored + adhesion, size + pulls


def _ends(indenter: Indenter, lines: Array) -> Array:
    """Ends of the panels (n, m + 1): corners, knots and the apex, as far as they are inside."""
    apex = () if indenter.apex is None else (indenter.apex,)
    cuts = np.unique(np.concatenate([indenter.corners, indenter.knots, apex]))
    inner = np.clip(cuts, lines[:, :1], lines[:, 1:])
    return np.concatenate([lines[:, :1], inner, lines[:, 1:]], axis=1)


def _orders(ends: Array) -> tuple[int, int]:
    """Orders to compare; a few where there are many panels."""
    return (28, 40) if ends.shape[1] < _FEW_PANELS else (4, _PLAIN)


def totals(
    surfaces: Surfaces, depth: float, left: float, right: float, rtol: float
) -> tuple[Interval, Interval]:
    """`refined` for one contact between two lines."""
    scene, free = surfaces.scene, beside(surfaces, depth, left, right)
    return refined(scene, depth, _panels(scene.indenter, left, right), free, rtol)


def refined(
    scene: Scene, depth: float, ends: Array, free: tuple[float, ...], rtol: float
) -> tuple[Interval, Interval]:
    """Energy and force at a depth, first off by the estimated error, then by more points.

    ends (n, m + 1): of the panels in contact; free: what `surfaces` says of those beyond.
    """
    allowed = max(_PART * rtol, ROUNDING)
    if scene.indenter.complete:
        sums, weakest = inside(scene, np.array([depth]), ends)
        least, parts = float(weakest.min()), sums.sum(axis=2).tolist()
        coarse, fine = (Interval(*_summed(part, free), least) for part in parts)
        if fine.change(coarse) <= allowed:
            return coarse, fine
    panels = np.column_stack([ends[:, :-1].ravel(), ends[:, 1:].ravel()])
    return _halved(scene, depth, _measured(scene, depth, panels, _orders(ends)), free, allowed)


class _Panels(NamedTuple):
    """Panels between ends (n, 2): integrals (5, n) by the more points of these orders.

    apart (2, n): how far energy and force by fewer points, or of the whole, are from these; errors
    (2, n): the same, or a part of what it was before the panel was halved; weakest (n,): least g.
    """

    ends: Array
    sums: Array
    apart: Array
    errors: Array
    weakest: Array
    orders: tuple[int, int]

    @property
    def divisible(self) -> NDArray[np.bool_]:
        """Whether there is a number between the ends (n,)."""
        middle = self.ends.mean(axis=1)
        return np.asarray((self.ends[:, 0] < middle) & (middle < self.ends[:, 1]))

    def halved(self, scene: Scene, depth: float, rough: NDArray[np.bool_]) -> _Panels:
        """The panels, the rough ones as two halves each, at the end."""
        old, at = self.ends[rough], self.ends[rough].mean(axis=1)
        ends = np.concatenate([np.column_stack([old[:, 0], at]), np.column_stack([at, old[:, 1]])])
        new, n = _measured(scene, depth, ends, self.orders), len(old)
        apart = errors = new.apart
        if not scene.indenter.complete:
            whole = _balance(new.sums[:, :n] + new.sums[:, n:] - self.sums[:, rough])
            apart = np.maximum(apart, np.tile(np.abs(whole) / 2, 2))
            errors = np.maximum(apart, np.tile(self.apart[:, rough] * _LUCK, 2))
        return _Panels(
            np.concatenate([self.ends[~rough], ends]),
            np.hstack([self.sums[:, ~rough], new.sums]),
            np.hstack([self.apart[:, ~rough], apart]),
            np.hstack([self.errors[:, ~rough], errors]),
            np.append(self.weakest[~rough], new.weakest),
            self.orders,
        )


def _measured(scene: Scene, depth: float, ends: Array, orders: tuple[int, int]) -> _Panels:
    """Integrals over panels (n, 2), and how far those by fewer points are from them."""
    (few, many), weakest = inside(scene, np.array([depth]), ends, orders)
    apart = np.abs(_balance(many - few))
    return _Panels(ends, many, apart, apart.copy(), weakest, orders)


def _balance(sums: Array) -> Array:
    """Energy and force (2, n) from the integrals over panels (5, n)."""
    return np.array([sums[0] + sums[1] - sums[2], sums[3]])


def _halved(
    scene: Scene, depth: float, panels: _Panels, free: tuple[float, ...], allowed: float
) -> tuple[Interval, Interval]:
    """`refined` from whole panels, those halved that disagree."""
    most = len(panels.ends) + _MOST_PANELS
    rounding = height_rounding(scene.indenter, panels.ends)
    felt = scene.stiffness * (np.diff(panels.ends).sum() + 2 * scene.elastocapillary_length)
    felt *= float(scene.measure(panels.ends.max(initial=0.0)))
    if not scene.indenter.complete:  # not known until there are halves
        panels.errors[:, panels.divisible] = math.inf
    while True:
        least = float(panels.weakest.min(initial=0.0))
        fine = Interval(*_summed(panels.sums.sum(axis=1).tolist(), free), least, rounding)
        lost = rounding * np.array([fine.force_scale, felt])
        limit = allowed * np.array([fine.energy_scale, fine.force_scale]) + lost
        apart, share = panels.errors.sum(axis=1), limit[:, None] / max(1, len(panels.ends))
        rounded = _SUMMED * np.array([panels.sums[:3].sum(axis=0), panels.sums[4]])
        rough = (panels.errors > np.maximum(share, rounded)).any(axis=0) & panels.divisible
        if (apart <= limit).all() or not rough.any() or len(panels.ends) > most:
            energy, force = (apart + lost).tolist()
            return fine._replace(energy=fine.energy - energy, force=fine.force - force), fine
        panels = panels.halved(scene, depth, rough)


def _panels(indenter: Indenter, left: float, right: float) -> Array:
    """`_ends` of one contact (1, m + 1), each once."""
    if len(indenter.corners) + len(indenter.knots) > _FEW_PANELS:
        return np.unique(_ends(indenter, np.array([[left, right]])))[None]
    cuts = {left, right, *indenter.corners, *indenter.knots}
    if indenter.apex is not None:
        cuts.add(indenter.apex)
    return np.array([sorted(float(x) for x in cuts if left <= x <= right)])


@functools.lru_cache(maxsize=16)
def _rule(order: int) -> tuple[Array, Array]:
    """Gauss points and weights on [0, 1]; of many, half for each half, crowded at the ends by t⁴.

    A power law is not smooth where the panels end.
    """
    t, weights = np.polynomial.legendre.leggauss(order)
    t, weights = (t + 1) / 2, weights / 2
    if order <= _PLAIN:
        return t, weights
    near, weights = t**4 / 2, 2 * weights * t**3
    return np.concatenate([near, 1 - near]), np.concatenate([weights, weights])


@functools.lru_cache(maxsize=16)
def _pair(few: int, many: int) -> tuple[Array, Array]:
    """Both rules at once: all their points (p,), and their weights (2, p)."""
    (at, weights), (more, heavier) = _rule(few), _rule(many)
    both = np.zeros((2, at.size + more.size))
    both[0, : at.size], both[1, at.size :] = weights, heavier
    return np.concatenate([at, more]), both


def _points(ends: Array, at: Array, weights: Array) -> tuple[Array, Array]:
    """Points (n, ·) and weights (2, n, ·) of both rules on the panels between ends (n, m + 1)."""
    start, stop = ends[:, :-1, None], ends[:, 1:, None]
    span = stop - start
    x = (start + span * at).reshape(len(ends), (ends.shape[1] - 1) * at.size)
    return x, (span * weights[:, None, None]).reshape(2, *x.shape)
