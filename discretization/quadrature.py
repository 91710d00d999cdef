"""Energy and force of a fitted contact, integrated by Gauss points until fewer points agree."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.fitted import Problem
from energy import terms

Array = NDArray[np.float64]
_FEW_PANELS = 50
_MOST_PANELS = 1 << 16
_HALVINGS = 8
_PLAIN = 6  # Gauss points of an ungraded panel
_PART = 0.1  # of rtol for the quadrature


class Interval(NamedTuple):
    """Totals over a fitted contact and its free surfaces, with the force by two routes."""

    energy: float
    force: float
    force_by_field: float
    energy_scale: float
    force_scale: float
    weakest: float


@functools.lru_cache(maxsize=16)
def _gauss(order: int, power: int) -> tuple[Array, Array]:
    """Gauss points on [0, 1], crowded at 0 by x = t^power for what is not smooth there."""
    t, weights = np.polynomial.legendre.leggauss(order)
    t = (t + 1) / 2
    return t**power, weights * power / 2 * t ** (power - 1)


def integrate(problem: Problem, left: float, right: float, panels: Array, order: int) -> Interval:
    """Energy and force of the contact left..right with its two free surfaces."""
    scene, depth, response = problem.scene, problem.depth, problem.response
    k, gamma1, w = scene.stiffness, scene.gamma1, scene.work_of_adhesion
    near, far = panels
    points, weights = _gauss(order, 4 if order > _PLAIN else 1)
    x, span = near[:, None] + (far - near)[:, None] * points, np.abs(far - near)[:, None] * weights
    g = depth - scene.indenter.height(x)
    springs = float(np.sum(span * terms.spring(g, k=k).value))
    slope = scene.indenter.slope(x)
    stretch = terms.surface(slope, gamma1=gamma1, slopes=scene.slopes).value
    bound = stretch - terms.contact(slope, gamma1=gamma1, w=w, slopes=scene.slopes)
    tension, adhesion = float(np.sum(span * stretch)), float(np.sum(span * bound))
    force, size = float(np.sum(span * (k * g))), float(np.sum(span * np.abs(k * g)))
    length = scene.elastocapillary_length
    lifted = [problem.displaced(end) / length for end in (left, right)] if gamma1 else []
    stored = gamma1 * length * sum(map(response.energy, lifted))
    pulls = [gamma1 * response.reaction(u0) for u0 in lifted]
    return Interval(
        springs + tension + stored - adhesion,
        force + sum(pulls),
        force + gamma1 * sum(map(response.area, lifted)),
        springs + tension + stored + adhesion,
        size + sum(map(abs, pulls)),
        float(g.min(initial=0.0)),
    )


def totals(problem: Problem, left: float, right: float, rtol: float) -> tuple[Interval, Interval]:
    """`integrate` with fewer and with more Gauss points, on panels halved until both agree.

    Panels end at corners, knots and the apex; where they are few they are graded towards both
    ends, because a power law is not smooth there.
    """
    indenter = problem.scene.indenter
    apex = () if indenter.apex is None else (indenter.apex,)
    cuts = np.concatenate([indenter.corners, indenter.knots, apex, [left, right]])
    ends = np.unique(np.clip(cuts, left, right))
    orders = (28, 40) if ends.size < _FEW_PANELS else (4, _PLAIN)
    for _ in range(_HALVINGS):
        near, far = ends[:-1], ends[1:]
        middle = (near + far) / 2
        if orders[0] > _PLAIN:
            near, far = np.concatenate([near, far]), np.concatenate([middle, middle])
        coarse, fine = (integrate(problem, left, right, np.array([near, far]), n) for n in orders)
        change = max(
            abs(fine.energy - coarse.energy) / (fine.energy_scale or 1.0),
            abs(fine.force - coarse.force) / (fine.force_scale or 1.0),
        )
        if change <= _PART * rtol or ends.size > _MOST_PANELS:
            break
        ends = np.sort(np.concatenate([ends, middle]))
    return coarse, fine
