"""Integrals over contacts, by Gauss points until fewer points agree.

Panels end at corners, knots, the apex and the edges of a pattern. Between them a built-in indenter
is smooth. Of a profile that does not say so (Indenter.complete) fewer and more points on the same
panel may agree by luck beside a jump of the slope or of a higher derivative: there each panel is
compared with its halves, too. Panels that disagree are halved, so that they close in on such a
jump:

    Σ_panels |many - few|, |whole - halves|  <=  max(rtol/10, 16 ε) · scale + rounding of heights.

A sum of n terms is rounded by up to n ε of their sizes: what disagrees by no more is not halved.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.rounding import EPSILON, ROUNDING, height_rounding
from energy import Scene, terms

Array = NDArray[np.float64]
Free = tuple[float, float, float, float]  # of the free surfaces: F, what they pull, k∫u, |pull|
NONE: Free = 0.0, 0.0, 0.0, 0.0
_FEW_PANELS = 50  # fewer are taken with many points at once, more with few points first
_MOST_PANELS = 1 << 12  # beyond those between declared corners and knots
_PART = 0.1  # of rtol for the quadrature
_SUMMED = 80 * EPSILON  # of the sizes of the 80 terms of a panel's larger sum
_PLAIN = 6  # up to so many points: an ungraded panel
_LUCK = 1 / 8  # of what the whole was off by: at a jump of f'' the halves are no better than that


class Interval(NamedTuple):
    """Totals over contacts and their free surfaces, with the force by two routes.

    weakest: the least g in contact; rounding: what the heights are off by as measured [length],
    counted in force and energy.
    """

    energy: float
    force: float
    force_by_field: float
    energy_scale: float
    force_scale: float
    weakest: float
    rounding: float = 0.0

    @classmethod
    def of(cls, panels: _Panels, free: Free, rounding: float) -> Interval:
        """The integrals over contacts and what the free surfaces add."""
        springs, tension, adhesion, force, size = panels.total.tolist()
        energy, pull, area, pulls = free
        stored = springs + tension + energy
        weakest = float(panels.weakest.min(initial=0.0))
        sizes = stored + adhesion, size + pulls
        return cls(stored - adhesion, force + pull, force + area, *sizes, weakest, rounding)


def refined(
    scene: Scene, depth: float, contacts: Array, free: Free, rtol: float
) -> tuple[Interval, Interval]:
    """Energy and force of contacts (m, 2), first off by the estimated error, then by more points.

    free: what the free surfaces beside them add.
    """
    panels, lost, rounding = _halved(scene, depth, contacts, free, rtol)
    fine = Interval.of(panels, free, rounding)
    energy, force = (panels.errors.sum(axis=1) + lost).tolist()
    return fine._replace(energy=fine.energy - energy, force=fine.force - force), fine


def integrals(scene: Scene, depth: float, contacts: Array) -> Array:
    """Integrals (5,) over contacts (m, 2) to rounding: those of `_Panels`."""
    return _halved(scene, depth, contacts, NONE, ROUNDING)[0].total


class _Panels(NamedTuple):
    """Panels between ends (n, 2): integrals (5, n) by the more points of these orders.

    sums: of what springs, surface and adhesion as it binds store, of kg and |kg|.
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
    def total(self) -> Array:
        """The integrals over all panels (5,)."""
        return np.asarray(self.sums.sum(axis=1))

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


def _halved(
    scene: Scene, depth: float, contacts: Array, free: Free, rtol: float
) -> tuple[_Panels, Array, float]:
    """Panels, those halved that disagree; what rounding of heights loses, and that rounding."""
    ends = _ends(scene, contacts)
    panels = _measured(scene, depth, ends, (28, 40) if len(ends) < _FEW_PANELS else (4, _PLAIN))
    most, allowed = len(ends) + _MOST_PANELS, max(_PART * rtol, ROUNDING)
    rounding = height_rounding(scene.indenter, ends)
    felt = scene.stiffness * (np.diff(ends).sum() + 2 * scene.elastocapillary_length)
    felt *= float(scene.measure(ends.max(initial=0.0)))
    if not scene.indenter.complete:  # not known until there are halves
        panels.errors[:, panels.divisible] = math.inf
    while True:
        whole = Interval.of(panels, free, rounding)
        lost = rounding * np.array([whole.force_scale, felt])
        limit = allowed * np.array([whole.energy_scale, whole.force_scale]) + lost
        apart, share = panels.errors.sum(axis=1), limit[:, None] / max(1, len(panels.ends))
        rounded = _SUMMED * np.array([panels.sums[:3].sum(axis=0), panels.sums[4]])
        rough = (panels.errors > np.maximum(share, rounded)).any(axis=0) & panels.divisible
        if (apart <= limit).all() or not rough.any() or len(panels.ends) > most:
            return panels, lost, rounding
        panels = panels.halved(scene, depth, rough)


def _ends(scene: Scene, contacts: Array) -> Array:
    """Ends (n, 2) of the panels of contacts (m, 2)."""
    indenter, pattern = scene.indenter, scene.pattern
    apex = () if indenter.apex is None else (indenter.apex,)
    edges = () if pattern is None else pattern.edges
    cuts = np.unique(np.concatenate([indenter.corners, indenter.knots, apex, edges]))
    parts = [
        np.concatenate([[left], cuts[(cuts > left) & (cuts < right)], [right]])
        for left, right in contacts.tolist()
    ]
    return np.concatenate([np.column_stack([part[:-1], part[1:]]) for part in parts])


def _measured(scene: Scene, depth: float, ends: Array, orders: tuple[int, int]) -> _Panels:
    """Integrals over panels (n, 2), and how far those by fewer points are from them."""
    at, rules = _pair(*orders)
    span = np.diff(ends)
    x = ends[:, :1] + span * at
    g, slope = depth - scene.indenter.height(x), scene.indenter.slope(x)
    gamma1, w, slopes = scene.gamma1, scene.work_of_adhesion, scene.slopes
    stretch = terms.contact(slope, gamma1=gamma1, w=0.0, slopes=slopes)
    bound = stretch - terms.contact(slope, gamma1=gamma1, w=w, slopes=slopes)
    if scene.pattern is not None:
        bound = bound * scene.pattern.factor(x)
    spring, pressure, _ = terms.spring(g, k=scene.stiffness)
    densities = np.array([spring, stretch, bound, pressure, np.abs(pressure)])
    if scene.axisymmetric:
        densities *= scene.measure(x)
    few, many = np.einsum("rij,dij->rdi", span * rules[:, None], densities)
    apart = np.abs(_balance(many - few))
    weakest = g.min(axis=1, initial=0.0)
    return _Panels(ends, many, apart, apart.copy(), weakest, orders)


def _balance(sums: Array) -> Array:
    """Energy and force (2, n) from the integrals over panels (5, n)."""
    return np.array([sums[0] + sums[1] - sums[2], sums[3]])


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
