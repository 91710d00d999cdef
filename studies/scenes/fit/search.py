"""Least squares on the simulator: the nearest parameters, and how well they are conditioned."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import optimize

from studies.scenes.fit.model import Model
from studies.shared import Array

BLUNT = 100.0, 10.0  # straight ends of branches at first
FINE, ROUGH = 1e-6, 1e-2  # gains at last, and where straight ends or HOPELESS noise are left
HOPELESS = 4.0  # times the noise
SIMULATED = 1e-6  # of the largest force: smaller residuals are those of the simulation
STEPS, SOLVED = 25, 1e-7  # where branches are known: at most, and gain of the last one
ROUNDS, SHORTER = 15, 0.25  # places at most; the reach after a failure
SHORTEST = 1e-3  # reach at least
FAIR, CLOSE = 0.75, 0.05  # of the gain that was promised, and how far off: rates serve again
CHORDS, ENOUGH = 4, 1e-3  # steps with one Jacobian, and the relative gain that needs no other
DEAD = 1e-5  # of the longest column: what simulated forces do not tell
ROUNDING = 1e-10  # of a force, relative to the largest


Box = tuple[Array, Array]  # least and largest coordinates


class Best(NamedTuple):
    """A minimum: coordinates (m,), residuals (n,), their Jacobian (n, m), half their squares."""

    x: Array
    fun: Array
    jac: Array
    cost: float


def sought(model: Model, start: Array, ftol: float = FINE) -> Best:
    """The minimum from where straight ends of branches lead, or from the start if that is lower.

    At an end the force may vary as a root: from far off, steps along its slope lead nowhere. From
    close by, straight ends may lead away.
    """
    x = start
    for times in BLUNT:
        x = followed(replace(model, blunt=times * model.blunt), x, ftol=ROUGH).x
    found = followed(model, x, ftol=ftol)
    if not hopeless(model, found):
        return found
    near = followed(model, start, ftol=ftol)
    return near if near.cost < found.cost else found


def hopeless(model: Model, best: Best) -> bool:
    """Whether so much more than the noise is left that the model cannot be right there."""
    left = math.sqrt(2 * best.cost / best.fun.size)
    return left > HOPELESS * max(model.data.sigma, SIMULATED * model.size)


def followed(model: Model, start: Array, fixed: int | None = None, ftol: float = FINE) -> Best:
    """Least squares on the simulator from `start`; coordinate `fixed` stays.

    Paths are followed at one place and beside it for the rates of their branches. Where the least
    squares of the branches that go on by these rates are is the next place, within a reach that
    becomes shorter where that is no better. It ends where they gain less than ftol.
    """
    x, fun, known = start.copy(), model.residuals(start), start
    if not np.isfinite(fun).all():
        raise ValueError(
            f"scene = {model.scene!r} has no equilibria along the measured depths to start from; "
            "start from other parameters"
        )
    (near, rates), reach, least = model.near(x), model.strides, ROUNDING * model.size
    for _ in range(ROUNDS):
        box = np.maximum(x - reach, -model.limits), np.minimum(x + reach, model.limits)
        found, before = minimum(near, x, box, fixed), float(fun @ fun)
        promised = before - 2 * found.cost
        small = promised <= max(ftol, ROUGH * hopeless(model, found)) * before + least**2
        moves, edge = found.x - x, np.where(found.x > x, box[1], box[0]) - x
        held = (moves != 0) & (np.abs(moves) > 0.99 * np.abs(edge))  # it would go farther
        if small and not (held.any() and reach.min() > SHORTEST):
            break
        trial = model.residuals(found.x)
        gained = before - float(trial @ trial) if np.isfinite(trial).all() else -math.inf
        if gained > FAIR * promised:
            reach = np.minimum(2 * reach, model.strides)
        elif not gained > 0 and known is x:
            reach = SHORTER * np.minimum(reach, np.abs(found.x - x)[: model.count].max())
        served = gained > FAIR * promised and np.abs(found.x - known)[: model.count].max() < CLOSE
        if gained > 0:
            x, fun = found.x, trial
        near, rates = model.near(x, rates if served else None)
        known = known if served else x
    jac = near.jacobian(x, range(x.size))
    return Best(x, fun, jac, float(fun @ fun) / 2 + fun.size * least**2)


def minimum(model: Model, start: Array, box: Box, fixed: int | None = None) -> Best:
    """Least squares from `start` in a box, by scipy; coordinate `fixed` stays."""
    free = [i for i in range(start.size) if i != fixed]

    def at(values: Array) -> Array:
        x = start.copy()
        x[free] = values
        return x

    found = optimize.least_squares(
        lambda values: model.residuals(at(values)),
        start[free],
        lambda values: model.jacobian(at(values), free),
        bounds=[edge[free] for edge in box],
        x_scale="jac",
        ftol=SOLVED,
        gtol=None,  # it has units
        max_nfev=STEPS,
    )
    return Best(at(found.x), found.fun, found.jac, float(found.cost))


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
        cost = followed(model, new, i, 1e-4).cost
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
