"""The w = 0 programme given to general solvers: through cvxpy, directly, and to scipy."""

import importlib
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy import optimize, sparse

from studies.benchmarks.rivals.problem import Answer, Array, Grid

SOLVERS = ("CLARABEL", "OSQP", "SCS", "PIQP", "HIGHS", "PROXQP", "DAQP")
TIGHT = ("eps_abs", "eps_rel", "eps_duality_gap_abs", "eps_duality_gap_rel")  # of PIQP
Prepare = Callable[[Grid], Callable[[], Answer]]


def through_cvxpy(
    grid: Grid, solver: str, parametrised: bool = False, tolerance: float | None = None
) -> Callable[[], Answer]:
    """cvxpy as people write it: modelled and solved, with default tolerances or this one, of PIQP.

    parametrised: the obstacle is a parameter; modelled and solved once before, then solved again.
    """
    import cvxpy as cp

    options = dict.fromkeys(TIGHT, tolerance) if tolerance else {}

    def modelled() -> tuple[Any, Any, Any]:
        lat, u = grid.lattice, cp.Variable(grid.nodes)
        floor = cp.Parameter(grid.nodes) if parametrised else grid.g
        springs = lat.spring / 2 * cp.sum_squares(u)
        links = lat.link / 2 * cp.sum_squares(cp.diff(u))
        ends = lat.end_stiffness / 2 * (cp.square(u[0]) + cp.square(u[-1]))
        return cp.Problem(cp.Minimize(springs + links + ends), [u >= floor]), u, floor

    def solved(problem: Any, u: Any) -> Answer:
        try:
            problem.solve(solver=solver, **options)
        except cp.error.SolverError as failure:
            raise RuntimeError(str(failure)) from None
        if u.value is None:
            raise RuntimeError(f"status {problem.status}")
        multipliers = problem.constraints[0].dual_value
        return grid.read(u.value, multipliers, problem.status == "optimal")

    if not parametrised:
        return lambda: solved(*modelled()[:2])
    problem, u, floor = modelled()

    def again() -> Answer:
        floor.value = grid.g.copy()
        return solved(problem, u)

    again()
    return again


def cvxpy_solvers() -> dict[str, Prepare]:
    """Both ways for every open quadratic solver that cvxpy finds."""
    import cvxpy

    ways: dict[str, Prepare] = {}
    found = cvxpy.installed_solvers()
    for solver in (name for name in SOLVERS if name in found):
        ways[f"cvxpy {solver}"] = partial(through_cvxpy, solver=solver)
        again = partial(through_cvxpy, solver=solver, parametrised=True)
        ways[f"cvxpy {solver}, parametrised"] = again
    if "PIQP" in found:
        ways["cvxpy PIQP 1e-10"] = partial(through_cvxpy, solver="PIQP", tolerance=1e-10)
    return ways


def clarabel(grid: Grid) -> Callable[[], Answer]:
    """Clarabel called directly, default tolerances."""
    made: Any = importlib.import_module("clarabel")
    upper, n = sparse.triu(grid.matrix(), format="csc"), grid.nodes
    settings = made.DefaultSettings()
    settings.verbose = False
    rows = -sparse.eye_array(n, format="csc")
    cones = [made.NonnegativeConeT(n)]

    def solve() -> Answer:
        model = (upper, np.zeros(n), rows, -grid.g, cones)
        found = made.DefaultSolver(*model, settings).solve()
        done = str(found.status) == "Solved"
        return grid.read(np.array(found.x), np.array(found.z), done)

    return solve


def osqp(grid: Grid, tolerance: float | None = None) -> Callable[[], Answer]:
    """OSQP called directly, with default tolerances or with this one."""
    made: Any = importlib.import_module("osqp")
    upper = sparse.csc_matrix(sparse.triu(grid.matrix()))
    rows = sparse.csc_matrix(sparse.eye_array(grid.nodes))
    bounds = grid.g, np.full(grid.nodes, np.inf)
    tight = {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": 100_000} if tolerance else {}

    def solve() -> Answer:
        model = made.OSQP()
        model.setup(upper, np.zeros(grid.nodes), rows, *bounds, verbose=False, **tight)
        found = model.solve(raise_error=False)
        return grid.read(found.x, -found.y, found.info.status == "solved")

    return solve


def piqp(grid: Grid, tolerance: float | None = None) -> Callable[[], Answer]:
    """PIQP called directly, with default tolerances or with this one."""
    made: Any = importlib.import_module("piqp")
    matrix = sparse.csc_matrix(grid.matrix())

    def solve() -> Answer:
        solver = made.SparseSolver()
        solver.settings.verbose = False
        for name in TIGHT if tolerance else ():
            setattr(solver.settings, name, tolerance)
        solver.setup(matrix, np.zeros(grid.nodes), x_l=grid.g)
        done = solver.solve() == made.PIQP_SOLVED
        return grid.read(solver.result.x, grid.pushed(solver.result.x), done)

    return solve


def bounded(grid: Grid) -> Callable[[], Answer]:
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
