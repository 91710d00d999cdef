"""General-purpose minimisers of scipy on the nodal energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import optimize

from discretization import NodalEnergy
from studies.benchmarks.rivals.problem import Answer, Array, Grid

RANGE = 0.05  # of a smoothed attraction, in δ₀


def _bounded(grid: Grid, energy: Callable[[Array], tuple[float, Array]], options: Any) -> Any:
    """L-BFGS-B with u >= g as bounds; energy and its gradient."""
    start, bounds = np.maximum(grid.g, 0), optimize.Bounds(grid.g, np.inf)
    method: dict[str, Any] = {"jac": True, "method": "L-BFGS-B"}
    return optimize.minimize(energy, start, bounds=bounds, options=options, **method)


def bounded(grid: Grid) -> Callable[[], Answer]:
    """w = 0: L-BFGS-B with u >= g as bounds, tolerances as tight as they go."""
    options = {"ftol": 1e-16, "gtol": 1e-12, "maxiter": 10**5, "maxfun": 10**6, "maxcor": 20}

    def solve() -> Answer:
        def energy(u: Array) -> tuple[float, Array]:
            force = grid.pushed(u)
            return float(u @ force) / 2, force

        found = _bounded(grid, energy, options)
        return grid.read(found.x, np.maximum(grid.pushed(found.x), 0), bool(found.success))

    return solve


def trust_region(grid: Grid) -> Callable[[], Answer]:
    """w = 0: trust-constr with gradient, Hessian and bounds."""
    matrix, bounds = grid.matrix(), optimize.Bounds(grid.g, np.inf)

    def solve() -> Answer:
        found = optimize.minimize(
            lambda u: float(u @ grid.pushed(u)) / 2,
            np.maximum(grid.g, 0) + 0.1 * grid.depth,
            jac=grid.pushed,
            hess=lambda u: matrix,
            method="trust-constr",
            bounds=bounds,
            options={"gtol": 1e-10, "xtol": 1e-12, "barrier_tol": 1e-10, "maxiter": 2000},
        )
        done = found.status in (1, 2)
        return grid.read(found.x, np.maximum(grid.pushed(found.x), 0), done)

    return solve


def smoothed(grid: Grid) -> Callable[[], Answer]:
    """w > 0: L-BFGS-B with the adhesion smoothed, -w Σ Δx exp(-(u-g)/ρ), ρ = δ₀/20."""
    weight = grid.scene.work_of_adhesion * grid.spacing
    ranged = RANGE * grid.scene.critical_separation
    free = NodalEnergy(grid.lattice, np.zeros(grid.nodes, bool))

    def energy(u: Array) -> tuple[float, Array]:
        pull = weight * np.exp(-(u - grid.g) / ranged)
        return free.value(u) - float(pull.sum()), free.gradient(u) + pull / ranged

    def solve() -> Answer:
        options = {"ftol": 1e-15, "gtol": 1e-10, "maxiter": 20_000, "maxfun": 10**5}
        found = _bounded(grid, energy, options)
        u = found.x
        held = np.flatnonzero(u - grid.g < ranged)
        a = float(grid.x[held[-1]] - grid.x[held[0]]) / 2
        angle = np.pi - grid.deficit(u[held[-1] + 1 : held[-1] + 4], int(held[-1]) + 1, a)
        force = float(free.gradient(u).sum())
        return Answer(a, force, float(found.fun), float(angle), bool(found.success))

    return solve
