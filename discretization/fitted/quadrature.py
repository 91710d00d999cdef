"""Energy and force of fitted contacts, integrated by Gauss points until fewer points agree."""

from __future__ import annotations

import functools
from typing import NamedTuple

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
_CHUNK = 1 << 18


class Interval(NamedTuple):
    """Totals over a fitted contact and its free surfaces, with the force by two routes."""

    energy: float
    force: float
    force_by_field: float
    energy_scale: float
    force_scale: float
    weakest: float


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
        energy = np.abs(self.energy - other.energy) / _or_one(self.energy_scale)
        force = np.abs(self.force - other.force) / _or_one(self.force_scale)
        return float(max(energy.max(initial=0.0), force.max(initial=0.0)))


def _or_one(scale: Array) -> Array:
    return np.where(scale > 0, scale, 1.0)


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
    """Points (n, ·) and weights (..., n, ·) of a rule on the panels between ends (n, m + 1)."""
    span = ends[:, 1:] - ends[:, :-1]
    points = (ends[:, :-1, None] + span[..., None] * at).reshape(len(ends), -1)
    spread = span[..., None] * weights[..., None, None, :]
    return points, spread.reshape(*weights.shape[:-1], *points.shape)


def inside(scene: Scene, depth: Array, ends: Array) -> tuple[Array, Array]:
    """Integrals over contacts at depths (n,), and their least g (n,); panels between ends (n, m+1).

    (2, 5, n), by fewer and by more points: springs, surface, adhesion as it binds, kg and |kg|.
    """
    k, gamma1, w = scene.stiffness, scene.gamma1, scene.work_of_adhesion
    x, span = _points(ends, *_pair(*_orders(ends)))
    g, slope = depth[:, None] - scene.indenter.height(x), scene.indenter.slope(x)
    stretch = terms.surface(slope, gamma1=gamma1, slopes=scene.slopes).value
    bound = stretch - terms.contact(slope, gamma1=gamma1, w=w, slopes=scene.slopes)
    pressure = k * g
    densities = np.array([terms.spring(g, k=k).value, stretch, bound, pressure, np.abs(pressure)])
    return np.einsum("rij,dij->rdi", span, densities), g.min(axis=1, initial=0.0)


def integrate(
    scene: Scene, response: Response, depth: Array, lines: Array, ends: Array
) -> tuple[Intervals, Intervals]:
    """Energy and force of contacts at depths (n,), by fewer and by more points.

    lines (n, 2); panels lie between ends (n, m + 1).
    """
    gamma1 = scene.gamma1
    sums, weakest = inside(scene, depth, ends)
    energy, pull, area, pulls = np.zeros((4, depth.size))
    for u in (depth[:, None] - scene.indenter.height(lines)).T if gamma1 else ():
        u0 = (u / scene.elastocapillary_length).tolist()
        energy += gamma1 * scene.elastocapillary_length * np.array([*map(response.energy, u0)])
        reaction = gamma1 * np.array([*map(response.reaction, u0)])
        pull, pulls = pull + reaction, pulls + np.abs(reaction)
        area += gamma1 * np.array([*map(response.area, u0)])
    few, many = (
        Intervals(
            springs + tension + energy - adhesion,
            force + pull,
            force + area,
            springs + tension + energy + adhesion,
            size + pulls,
            weakest,
        )
        for springs, tension, adhesion, force, size in sums
    )
    return few, many


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
    """`integrate` for one state with fewer and more points, on panels halved until both agree."""
    lines, at = np.array([[left, right]]), np.array([depth])
    ends = _panels(scene.indenter, left, right)
    for _ in range(_HALVINGS):
        coarse, fine = integrate(scene, response, at, lines, ends)
        if fine.change(coarse) <= _PART * rtol or ends.size > _MOST_PANELS:
            break
        ends = np.sort(np.hstack([ends, (ends[:, :-1] + ends[:, 1:]) / 2]))
    first, second = ([float(part[0]) for part in found] for found in (coarse, fine))
    return Interval(*first), Interval(*second)


def along(scene: Scene, response: Response, depth: Array, lines: Array) -> tuple[Intervals, float]:
    """`integrate` for many states at once, and its change from fewer points."""
    ends, parts, change = _ends(scene.indenter, lines), [], 0.0
    step = max(1, _CHUNK // (40 * 2 * ends.shape[1]))
    for start in range(0, len(depth), step):
        own = slice(start, start + step)
        coarse, fine = integrate(scene, response, depth[own], lines[own], ends[own])
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
