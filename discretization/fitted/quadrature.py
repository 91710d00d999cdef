"""Energy and force of fitted contacts, integrated by Gauss points until fewer points agree."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.response import Response
from energy import Indenter, Scene, terms

Array = NDArray[np.float64]
_FEW_PANELS = 50
_MOST_PANELS = 1 << 16
_HALVINGS = 8
_PLAIN = 6  # Gauss points of an ungraded panel
_PART = 0.1  # of rtol for the quadrature
_ROUNDING = 16 * float(np.finfo(float).eps)
_CHUNK = 1 << 18


class Interval(NamedTuple):
    """Totals over a fitted contact and its free surfaces, with the force by two routes."""

    energy: float
    force: float
    force_by_field: float
    energy_scale: float
    force_scale: float
    weakest: float

    def change(self, other: Interval) -> float:
        """Larger of the relative differences of energy and force."""
        energy = abs(self.energy - other.energy) / (self.energy_scale or 1.0)
        return max(energy, abs(self.force - other.force) / (self.force_scale or 1.0))


class Intervals(NamedTuple):
    """`Interval` of several contacts, arrays (n,)."""

    energy: Array
    force: Array
    force_by_field: Array
    energy_scale: Array
    force_scale: Array
    weakest: Array

    def change(self, other: Intervals) -> float:
        """Largest relative difference of energy and force."""
        apart = np.abs([self.energy - other.energy, self.force - other.force])
        scale = np.array([self.energy_scale, self.force_scale])
        return float((apart / np.where(scale > 0, scale, 1.0)).max(initial=0.0))


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
    (points, weights), (more, heavier) = _rule(few), _rule(many)
    both = np.zeros((2, points.size + more.size))
    both[0, : points.size], both[1, points.size :] = weights, heavier
    return np.concatenate([points, more]), both


def _points(ends: Array, at: Array, weights: Array) -> tuple[Array, Array]:
    """Points (n, ·) and weights (2, n, ·) of both rules on the panels between ends (n, m + 1)."""
    start, stop = ends[:, :-1, None], ends[:, 1:, None]
    span = stop - start
    points = (start + span * at).reshape(len(ends), -1)
    return points, (span * weights[:, None, None]).reshape(2, *points.shape)


def inside(scene: Scene, depth: Array, ends: Array) -> tuple[Array, Array]:
    """Integrals over contacts at depths (n,) or (1,), and their least g (n,).

    (2, 5, n), on the panels between ends (n, m + 1) by fewer and by more points: springs, surface,
    adhesion as it binds, kg and |kg|.
    """
    gamma1, w, slopes = scene.gamma1, scene.work_of_adhesion, scene.slopes
    x, span = _points(ends, *_pair(*_orders(ends)))
    g, slope = depth[:, None] - scene.indenter.height(x), scene.indenter.slope(x)
    stretch = terms.contact(slope, gamma1=gamma1, w=0.0, slopes=slopes)
    bound = stretch - terms.contact(slope, gamma1=gamma1, w=w, slopes=slopes)
    spring, pressure, _ = terms.spring(g, k=scene.stiffness)
    densities = np.array([spring, stretch, bound, pressure, np.abs(pressure)])
    return np.einsum("rij,dij->rdi", span, densities), g.min(axis=1, initial=0.0)


def surfaces(
    scene: Scene, response: Response, displaced: Iterable[float]
) -> tuple[float, float, float, float]:
    """Energy, reaction, area (times k) and |reaction|, summed over free surfaces beyond lines."""
    gamma1, length = scene.gamma1, scene.elastocapillary_length
    if not gamma1:
        return 0.0, 0.0, 0.0, 0.0
    u0 = [u / length for u in displaced]
    pulls = [gamma1 * response.reaction(u) for u in u0]
    energy, area = sum(map(response.energy, u0)), sum(map(response.area, u0))
    return gamma1 * length * energy, sum(pulls), gamma1 * area, sum(map(abs, pulls))


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
    scene: Scene, response: Response, depth: float, left: float, right: float, rtol: float
) -> tuple[Interval, Interval]:
    """`refined` for one contact between two lines."""
    indenter = scene.indenter
    displaced = [depth - float(indenter.height(x)) for x in (left, right)]
    free = surfaces(scene, response, displaced)
    return refined(scene, depth, _panels(indenter, left, right), free, rtol)


def refined(
    scene: Scene, depth: float, ends: Array, free: tuple[float, ...], rtol: float
) -> tuple[Interval, Interval]:
    """Energy and force at a depth by fewer and by more points, on panels halved until both agree.

    ends (n, m + 1): of the panels in contact; free: what `surfaces` says of those beyond.
    """
    for _ in range(_HALVINGS):
        sums, weakest = inside(scene, np.array([depth]), ends)
        least, parts = float(weakest.min()), sums.sum(axis=2).tolist()
        coarse, fine = (Interval(*_summed(part, free), least) for part in parts)
        agree = fine.change(coarse) <= max(_PART * rtol, _ROUNDING)
        if agree or ends[:, 1:].size > _MOST_PANELS:
            break
        ends, m = np.sort(np.hstack([ends, (ends[:, :-1] + ends[:, 1:]) / 2])), ends.shape[1]
        ends = np.concatenate([ends[:, :m], ends[:, m - 1 :]])
    return coarse, fine


def along(scene: Scene, response: Response, depth: Array, lines: Array) -> tuple[Intervals, float]:
    """Energy and force at depths (n,) between lines (n, 2), and their change from fewer points."""
    ends, parts, change = _ends(scene.indenter, lines), [], 0.0
    displaced = (depth[:, None] - scene.indenter.height(lines)).tolist()
    free = np.array([surfaces(scene, response, pair) for pair in displaced])
    step = max(1, _CHUNK // (40 * 2 * ends.shape[1]))
    for start in range(0, len(depth), step):
        own = slice(start, start + step)
        sums, weakest = inside(scene, depth[own], ends[own])
        coarse, fine = (Intervals(*_summed(part, free[own].T), weakest) for part in sums)
        change = max(change, fine.change(coarse))
        parts.append(fine)
    return Intervals(*(np.concatenate(part) for part in zip(*parts, strict=True))), change


def pressing(
    scene: Scene, response: Response, depth: float, left: float, right: float, rtol: float
) -> float:
    """The force alone: P = k∫(d - f) dx + S(left) + S(right); panels halved only where needed."""
    indenter, k, length = scene.indenter, scene.stiffness, scene.elastocapillary_length
    x, span = _contact(indenter, left, right)
    few, many = (span @ indenter.height(x)).tolist()
    press = k * (depth * (right - left) - many)
    pull = 0.0
    for end in (left, right) if scene.gamma1 else ():
        pull += scene.gamma1 * response.reaction((depth - float(indenter.height(end))) / length)
    if k * abs(few - many) > _PART * rtol * (abs(press) + abs(pull)):
        return totals(scene, response, depth, left, right, rtol)[1].force
    return press + pull


def arc_length(scene: Scene, left: float, right: float) -> float:
    """Length of the indenter between two positions: |right - left| for small slopes."""
    if scene.slopes == "small" or left == right:
        return abs(right - left)
    x, span = _contact(scene.indenter, min(left, right), max(left, right))
    slope = scene.indenter.slope(x)
    return float(span[1] @ np.sqrt(1 + slope * slope))


def _panels(indenter: Indenter, left: float, right: float) -> Array:
    """`_ends` of one contact (1, m + 1), each once."""
    if len(indenter.corners) + len(indenter.knots) > _FEW_PANELS:
        return np.unique(_ends(indenter, np.array([[left, right]])))[None]
    cuts = {left, right, *indenter.corners, *indenter.knots}
    if indenter.apex is not None:
        cuts.add(indenter.apex)
    return np.array([sorted(float(x) for x in cuts if left <= x <= right)])


def _contact(indenter: Indenter, left: float, right: float) -> tuple[Array, Array]:
    """Points (·,) and weights (2, ·) of one contact, by fewer and by more points."""
    ends = _panels(indenter, left, right)
    x, span = _points(ends, *_pair(*_orders(ends)))
    return x[0], span[:, 0]
