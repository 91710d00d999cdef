"""Least squares on the simulator: the nearest parameters, and how well they are conditioned."""

import math
import sys
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from studies.scenes.fit.model import Model
from studies.shared import Array

BLUNT = ((100.0, 1e-2), (10.0, 1e-2))  # straight ends of branches at first, relative gains
FINE, ROUGH, HOPELESS = (
    1e-6,
    1e-2,
    5.0,
)  # gains at last; rough where so many times the noise is left
STEPS, DAMPED = 25, (1e-3, 1e6)  # at most; Levenberg's damping after a failure, when it is over
FAIR = 0.75  # of the gain that was predicted: the Jacobian served
CHORDS, ENOUGH = 4, 1e-3  # steps with one Jacobian, and the relative gain that needs no other
LOWER = 0.01  # of the sum of squares: by less another minimum is no better
DEAD = 1e-5  # of the longest column: what simulated forces do not tell
ROUNDING = 1e-10  # of a force, relative to the largest


class Best(NamedTuple):
    """A minimum: coordinates (m,), residuals (n,), their Jacobian (n, m), half their squares."""

    x: Array
    fun: Array
    jac: Array
    cost: float


def sought(model: Model) -> Best:
    """The minimum from the start, or from where straight ends of branches lead if that is lower.

    At an end the force may vary as a root: from far off, steps along its slope lead nowhere. From
    close by, straight ends may lead away.
    """
    x = model.start
    for times, gain in BLUNT:
        found = minimum(replace(model, blunt=times * model.blunt), x, None, gain, False)
        x, left = found.x, math.sqrt(2 * found.cost / found.fun.size)
    hopeless = left > HOPELESS * max(model.data.sigma, 1e-4 * model.size)
    gain = ROUGH if hopeless else FINE
    near, far = (minimum(model, at, None, gain) for at in (model.start, x))
    return far if far.cost < (1 - LOWER) * near.cost else near


def minimum(
    model: Model,
    start: Array,
    fixed: int | None = None,
    ftol: float = 1e-6,
    final: bool = True,
) -> Best:
    """Least squares from `start` by Levenberg and Marquardt; coordinate `fixed` stays.

    A Jacobian with which a step gained what it promised is brought up to date by Broyden's formula.
    It ends where a step with a fresh one gains less than ftol of the sum of squares; final: the
    Jacobian given is that of the minimum.
    """
    free = [i for i in range(start.size) if i != fixed]
    x, fun = start.copy(), model.residuals(start)
    if not np.isfinite(fun).all():
        raise ValueError(
            f"scene = {model.scene!r} has no equilibria along the measured depths to start from; "
            "start from other parameters"
        )
    jac, fresh, damping, least = model.jacobian(x, free), True, 0.0, ROUNDING * model.size
    for _ in range(STEPS):
        new, moved = _moved(model, x, free, jac, fun, damping)
        trial, before = model.residuals(new), float(fun @ fun)
        gained, promised = -math.inf, before - float(np.sum((fun + jac @ moved) ** 2))
        if np.isfinite(trial).all():
            gained = before - float(trial @ trial)
        if gained > 0:
            change = trial - fun - jac @ moved
            jac = jac + np.outer(change, moved) / max(float(moved @ moved), sys.float_info.min)
            x, fun, damping = new, trial, damping / 10 if damping > DAMPED[0] else 0.0
        small = damping <= DAMPED[0] and max(promised, gained) <= ftol * before + least**2
        if (small and fresh) or damping > DAMPED[1]:
            break
        served, wasted = gained > FAIR * promised and not small, gained <= 0 and fresh
        if wasted:
            damping = max(10 * damping, DAMPED[0])
        elif not served:
            jac = model.jacobian(x, free)
        fresh = not served
    if final and not fresh:
        jac = model.jacobian(x, free)
    whole = np.zeros((fun.size, x.size))
    whole[:, free] = jac
    return Best(x, fun, whole, float(fun @ fun) / 2 + fun.size * least**2)


def _moved(
    model: Model, x: Array, free: list[int], jac: Array, fun: Array, damping: float
) -> tuple[Array, Array]:
    """The coordinates after a step of the free ones, and that step.

    Where some would go farther than a stride they make one, and the others are sought anew beside.
    """
    stride, step = model.strides[free], _step(jac, fun, damping)
    far = np.abs(step) > stride
    if far.any():
        step = np.clip(step, -stride, stride)
        step[~far] = _step(jac[:, ~far], fun + jac[:, far] @ step[far], damping)
        step = np.clip(step, -stride, stride)
    new = x.copy()
    new[free] = np.clip(x[free] + step, -model.limits[free], model.limits[free])
    return new, (new - x)[free]


def _step(jac: Array, fun: Array, damping: float) -> Array:
    """-(JᵀJ + λ diag JᵀJ)⁻¹ Jᵀr."""
    sizes = np.linalg.norm(jac, axis=0)
    unit = jac / np.where(sizes > 0, sizes, 1.0)
    rows = np.vstack([unit, math.sqrt(damping) * np.eye(sizes.size)])
    step = np.linalg.lstsq(rows, -np.append(fun, np.zeros(sizes.size)), rcond=1e-9)[0]
    return np.asarray(step / np.where(sizes > 0, sizes, np.inf))


def profiled(model: Model, best: Best, i: int, at: float) -> float:
    """The least sum of squares with coordinate i at a value, over that of the fit.

    The others follow by Gauss and Newton's steps with the Jacobian of the fit, and by a search of
    their own where these still gain more than ENOUGH.
    """
    others = [j for j in range(best.x.size) if j != i]
    x, reach = best.x.copy(), model.limits[others]
    step = np.linalg.pinv(best.jac[:, others])
    x[others] -= step @ best.jac[:, i] * (at - x[i])
    x[i], cost, gain = at, math.inf, math.inf
    for _ in range(CHORDS):
        new = x.copy()
        new[others] = np.clip(new[others], -reach, reach)
        residuals = model.residuals(new)
        found = float(np.sum(residuals**2)) / 2
        if not found < cost:
            gain = 0.0 if math.isfinite(cost) else math.inf
            break
        x, gain, cost = new, 1 - found / cost if math.isfinite(cost) else math.inf, found
        if gain < ENOUGH or not others:
            break
        x[others] -= step @ residuals
    if math.isinf(cost):
        return math.inf
    if gain > ENOUGH and others:
        cost = float(minimum(model, new, fixed=i, ftol=1e-4).cost)
    return cost / best.cost


def conditioning(jacobian: Array, count: int) -> tuple[float, Array, Array]:
    """Condition of the first `count` columns at unit length, their weakest direction (count,), and
    √((JᵀJ)⁻¹)ᵢᵢ of all (m,); inf for a zero column.

    Of the other columns, the baseline's, the first ones are made free: they are always well known.
    """
    sizes = np.linalg.norm(jacobian, axis=0)
    dead = sizes <= DEAD * sizes.max()
    unit = jacobian / np.where(dead, 1.0, sizes)
    spread = np.full(sizes.size, math.inf)
    _, singular, right = np.linalg.svd(unit[:, ~dead], full_matrices=False)
    spread[~dead] = np.linalg.norm(right.T / singular, axis=1) / sizes[~dead]
    line, own, sizes = unit[:, count:], unit[:, :count], sizes[:count]
    own = own - line @ np.linalg.lstsq(line, own, rcond=None)[0]
    length = np.linalg.norm(own, axis=0)
    alive = ~dead[:count] & (length > 1e-9)
    weakest = (~alive).astype(float)
    if not alive.all():
        return math.inf, weakest / np.linalg.norm(weakest), spread
    _, singular, right = np.linalg.svd(own / length, full_matrices=False)
    weakest = right[-1] / (sizes * length)
    return float(singular[0] / singular[-1]), weakest / np.linalg.norm(weakest), spread
