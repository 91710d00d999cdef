"""The w = 0 programme given to general solvers: through cvxpy, directly, and to scipy."""

import importlib
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy import optimize, sparse

from studies.benchmarks.rivals.problem import Answer, Array, Grid, Solve

SOLVERS = ("CLARABEL", "OSQP", "SCS", "PIQP", "HIGHS", "PROXQP", "DAQP")
TIGHT = ("eps_abs", "eps_rel", "eps_duality_gap_abs", "eps_duality_gap_rel")  # of PIQP


def through_cvxpy() -> dict[str, Callable[[Grid], Solve]]:
    """Every open quadratic solver that cvxpy finds, with its default tolerances."""
    import cvxpy

    found = cvxpy.installed_solvers()
    return {f"cvxpy {name}": partial(modelled, solver=name) for name in SOLVERS if name in found}


def modelled(grid: Grid, solver: str) -> Solve:
    """cvxpy as people write it: the obstacle is a parameter; solved once before, then again."""
    import cvxpy as cp

    lat, u, floor = grid.lattice, cp.Variable(grid.nodes), cp.Parameter(grid.nodes)
    springs = lat.spring / 2 * cp.sum_squares(u)
    links = lat.link / 2 * cp.sum_squares(cp.diff(u))
    ends = lat.end_stiffness / 2 * (cp.square(u[0]) + cp.square(u[-1]))
    problem = cp.Problem(cp.Minimize(springs + links + ends), [u >= floor])

    def solve() -> Answer:
        floor.value = grid.g.copy()
        try:
            problem.solve(solver=solver)
        except cp.error.SolverError as failure:
            raise RuntimeError(str(failure)) from None
        if u.value is None:
            raise RuntimeError(f"status {problem.status}")
        multipliers = problem.constraints[0].dual_value
        return grid.read(u.value, multipliers, problem.status == "optimal")

    solve()
    return solve


def piqp(grid: Grid, tolerance: float = 1e-10) -> Solve:
    """PIQP called directly."""
    made: Any = importlib.import_module("piqp")
    matrix = sparse.csc_matrix(grid.matrix())

    def solve() -> Answer:
        solver = made.SparseSolver()
        solver.settings.verbose = False
        for name in TIGHT:
            setattr(solver.settings, name, tolerance)
        solver.setup(matrix, np.zeros(grid.nodes), x_l=grid.g)
        done = solver.solve() == made.PIQP_SOLVED
        return grid.read(solver.result.x, grid.pushed(solver.result.x), done)

    return solve


def bounded(grid: Grid) -> Solve:
    """scipy's L-BFGS-B with u >= g as bounds, tolerances as tight as they go."""
    options = {"ftol": 1e-16, "gtol": 1e-12, "maxiter": 10**5, "maxfun": 10**6, "maxcor": 20}

    def energy(u: Array) -> tuple[float, Array]:
        force = grid.pushed(u)
        return float(u @ force) / 2, force

    def solve() -> Answer:
        start, bounds = np.maximum(grid.g, 0), optimize.Bounds(grid.g, np.inf)
        given = {"jac": True, "bounds": bounds, "method": "L-BFGS-B", "options": options}
        found = optimize.minimize(energy, start, **given)
        return grid.read(found.x, np.maximum(grid.pushed(found.x), 0), bool(found.success))

    return solve
