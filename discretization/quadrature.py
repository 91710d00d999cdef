"""Energy and force of fitted contacts, integrated by Gauss points until fewer points agree."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.response import Response
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
def _gauss(order: int, power: int) -> tuple[Array, Array]:
    """Gauss points on [0, 1], crowded at 0 by x = t^power for what is not smooth there."""
    t, weights = np.polynomial.legendre.leggauss(order)
    t = (t + 1) / 2
    return t**power, weights * power / 2 * t ** (power - 1)


def integrate(
    scene: Scene, response: Response, depth: Array, lines: Array, panels: Array, order: int
) -> Intervals:
    """Energy and force of contacts with lines (n, 2) at depths (n,) on panels (2, n, m)."""
    k, gamma1, w = scene.stiffness, scene.gamma1, scene.work_of_adhesion
    near, far = panels[..., None]
    points, weights = _gauss(order, 4 if order > _PLAIN else 1)
    x = (near + (far - near) * points).reshape(depth.size, -1)
    span = (np.abs(far - near) * weights).reshape(depth.size, -1)
    g, slope = depth[:, None] - scene.indenter.height(x), scene.indenter.slope(x)
    stretch = terms.surface(slope, gamma1=gamma1, slopes=scene.slopes).value
    bound = stretch - terms.contact(slope, gamma1=gamma1, w=w, slopes=scene.slopes)
    densities = (terms.spring(g, k=k).value, stretch, bound, k * g, np.abs(k * g))
    springs, tension, adhesion, force, size = (np.einsum("ij,ij->i", span, y) for y in densities)
    energy, pull, area, pulls = np.zeros((4, depth.size))
    for u in (depth[:, None] - scene.indenter.height(lines)).T if gamma1 else ():
        u0 = (u / scene.elastocapillary_length).tolist()
        energy += gamma1 * scene.elastocapillary_length * np.array([*map(response.energy, u0)])
        reaction = gamma1 * np.array([*map(response.reaction, u0)])
        pull, pulls = pull + reaction, pulls + np.abs(reaction)
        area += gamma1 * np.array([*map(response.area, u0)])
    return Intervals(
        springs + tension + energy - adhesion,
        force + pull,
        force + area,
        springs + tension + energy + adhesion,
        size + pulls,
        g.min(axis=1, initial=0.0),
    )


def _ends(indenter: Indenter, lines: Array) -> Array:
    """Ends of the panels (n, m + 1): corners, knots and the apex, as far as they are inside."""
    apex = () if indenter.apex is None else (indenter.apex,)
    cuts = np.unique(np.concatenate([indenter.corners, indenter.knots, apex]))
    inner = np.clip(cuts, lines[:, :1], lines[:, 1:])
    return np.concatenate([lines[:, :1], inner, lines[:, 1:]], axis=1)


def _panels(ends: Array) -> tuple[Array, tuple[int, int]]:
    """Panels between ends (n, m + 1), and the orders to compare.

    Where there are few they are graded towards both ends: a power law is not smooth there.
    """
    near, far = ends[:, :-1], ends[:, 1:]
    if ends.shape[1] >= _FEW_PANELS:
        return np.array([near, far]), (4, _PLAIN)
    middle = (near + far) / 2
    return np.array([np.hstack([near, far]), np.hstack([middle, middle])]), (28, 40)


def totals(
    scene: Scene, response: Response, depth: float, left: float, right: float, rtol: float
) -> tuple[Interval, Interval]:
    """`integrate` for one state with fewer and more points, on panels halved until both agree."""
    lines, at = np.array([[left, right]]), np.array([depth])
    ends = np.unique(_ends(scene.indenter, lines))[None]
    for _ in range(_HALVINGS):
        panels, orders = _panels(ends)
        coarse, fine = (integrate(scene, response, at, lines, panels, n) for n in orders)
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
        panels, orders = _panels(ends[own])
        coarse, fine = (
            integrate(scene, response, depth[own], lines[own], panels, n) for n in orders
        )
        change = max(change, fine.change(coarse))
        parts.append(fine)
    return Intervals(*(np.concatenate(part) for part in zip(*parts, strict=True))), change


def pressing(scene: Scene, response: Response, depth: float, left: float, right: float) -> float:
    """The force alone: P = k∫(d - f) dx + S(left) + S(right)."""
    indenter = scene.indenter
    x, span = _points(indenter, left, right)
    force = scene.stiffness * (depth * (right - left) - float(span @ indenter.height(x)))
    if scene.gamma1:
        length = scene.elastocapillary_length
        for end in (left, right):
            u0 = (depth - float(indenter.height(end))) / length
            force += scene.gamma1 * response.reaction(u0)
    return force


def arc_length(scene: Scene, left: float, right: float) -> float:
    """Length of the indenter between two positions: |right - left| for small slopes."""
    if scene.slopes == "small" or left == right:
        return abs(right - left)
    x, span = _points(scene.indenter, min(left, right), max(left, right))
    slope = scene.indenter.slope(x)
    return float(span @ np.sqrt(1 + slope * slope))


def _points(indenter: Indenter, left: float, right: float) -> tuple[Array, Array]:
    """Points and weights of one contact (m,)."""
    cuts = {x for x in (indenter.apex,) if x is not None and left < x < right}
    for places in (indenter.corners, indenter.knots):
        if len(places):
            places = np.asarray(places)
            cuts.update(places[(places > left) & (places < right)].tolist())
    ends = np.array([left, *sorted(cuts), right])
    near, far = ends[:-1, None], ends[1:, None]
    order, power = _PLAIN, 1
    if ends.size < _FEW_PANELS:
        middle = (near + far) / 2
        near, far = np.concatenate([near, far]), np.concatenate([middle, middle])
        order, power = 40, 4
    points, weights = _gauss(order, power)
    span = far - near
    return (near + span * points).ravel(), (np.abs(span) * weights).ravel()
