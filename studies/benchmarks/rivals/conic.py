"""The w = 0 programme given to general solvers: through cvxpy, and directly."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy import sparse

from studies.benchmarks.rivals.problem import Answer, Grid, package

SOLVERS = ("CLARABEL", "OSQP", "SCS", "PIQP", "HIGHS", "PROXQP", "DAQP")
TIGHT = ("eps_abs", "eps_rel", "eps_duality_gap_abs", "eps_duality_gap_rel")  # of PIQP
Prepare = Callable[[Grid], Callable[[], Answer]]


def cvxpy_solvers() -> list[str]:
    """The open quadratic solvers cvxpy finds."""
    import cvxpy

    found = cvxpy.installed_solvers()
    return [name for name in SOLVERS if name in found]


def _modelled(grid: Grid, parametrised: bool) -> tuple[Any, Any, Any]:
    """Problem, variable, floor: as the energy reads."""
    import cvxpy as cp

    lat, u = grid.lattice, cp.Variable(grid.nodes)
    floor = cp.Parameter(grid.nodes) if parametrised else grid.g
    springs = lat.spring / 2 * cp.sum_squares(u)
    links = lat.link / 2 * cp.sum_squares(cp.diff(u))
    ends = lat.end_stiffness / 2 * (cp.square(u[0]) + cp.square(u[-1]))
    return cp.Problem(cp.Minimize(springs + links + ends), [u >= floor]), u, floor


def cold(grid: Grid, solver: str, tolerance: float | None = None) -> Callable[[], Answer]:
    """cvxpy as people write it: model and solve, default tolerances; or this one, of PIQP."""
    options = dict.fromkeys(TIGHT, tolerance) if tolerance else {}

    def solve() -> Answer:
        problem, u, _ = _modelled(grid, False)
        _solve(problem, solver, **options)
        return _read(grid, problem, u)

    return solve


def parametrised(grid: Grid, solver: str) -> Callable[[], Answer]:
    """The obstacle as a parameter: modelled and solved once before, then solved again."""
    problem, u, floor = _modelled(grid, True)
    floor.value = grid.g
    _solve(problem, solver)

    def solve() -> Answer:
        floor.value = grid.g.copy()
        _solve(problem, solver)
        return _read(grid, problem, u)

    return solve


def _solve(problem: Any, solver: str, **options: Any) -> None:
    """RuntimeError if the solver gives up."""
    import cvxpy as cp

    try:
        problem.solve(solver=solver, **options)
    except cp.error.SolverError as failure:
        raise RuntimeError(str(failure)) from None


def _read(grid: Grid, problem: Any, u: Any) -> Answer:
    if u.value is None:
        raise RuntimeError(f"status {problem.status}")
    multipliers = problem.constraints[0].dual_value
    return grid.read(u.value, multipliers, problem.status == "optimal")


def clarabel(grid: Grid) -> Callable[[], Answer]:
    """Clarabel called directly, default tolerances."""
    made = package("clarabel")
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
    made, n = package("osqp"), grid.nodes
    upper, rows = sparse.triu(grid.matrix(), format="csc"), sparse.eye_array(n, format="csc")
    tight = {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": 100_000}

    def solve() -> Answer:
        model = made.OSQP()
        options = tight if tolerance else {}
        model.setup(
            sparse.csc_matrix(upper),
            np.zeros(n),
            sparse.csc_matrix(rows),
            grid.g,
            np.full(n, np.inf),
            verbose=False,
            **options,
        )
        found = model.solve(raise_error=False)
        return grid.read(found.x, -found.y, found.info.status == "solved")

    return solve


def piqp(grid: Grid, tolerance: float | None = None) -> Callable[[], Answer]:
    """PIQP called directly, with default tolerances or with this one."""
    made, n, matrix = package("piqp"), grid.nodes, sparse.csc_matrix(grid.matrix())

    def solve() -> Answer:
        solver = made.SparseSolver()
        solver.settings.verbose = False
        for name in TIGHT if tolerance else ():
            setattr(solver.settings, name, tolerance)
        solver.setup(matrix, np.zeros(n), x_l=grid.g)
        done = solver.solve() == made.PIQP_SOLVED
        return grid.read(solver.result.x, grid.pushed(solver.result.x), done)

    return solve


def through_cvxpy() -> dict[str, Prepare]:
    """Both ways for every solver cvxpy finds."""
    ways: dict[str, Prepare] = {}
    for solver in cvxpy_solvers():
        ways[f"cvxpy {solver}"] = partial(cold, solver=solver)
        ways[f"cvxpy {solver}, parametrised"] = partial(parametrised, solver=solver)
    if "PIQP" in cvxpy_solvers():
        ways["cvxpy PIQP 1e-10"] = partial(cold, solver="PIQP", tolerance=1e-10)
    return ways
