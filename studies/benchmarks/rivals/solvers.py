"""The w = 0 programme given to general solvers: through cvxpy, and to scipy.

Conventions:

- Of a `Grid` of n nodes `g` is d - f, `pushed(u)` is Ku, the forces that hold the nodes, and
  `read(u, multipliers, success)` the `Answer`, a, P, U and θ.
- `lattice.spring_stiffness` is kΔx, `link_stiffness` γ₁/Δx, and `end_stiffness` that of the surface
  beyond the last node.
- A `Solve` has no arguments and returns an answer.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import numpy as np
from scipy import optimize

from studies.benchmarks.rivals.problem import Answer, Array, Grid, Solve

SOLVERS = ("CLARABEL", "OSQP", "SCS", "PIQP", "HIGHS", "PROXQP", "DAQP")


def through_cvxpy() -> dict[str, Callable[[Grid], Solve]]:
    """Every open quadratic solver that cvxpy finds, with its default tolerances."""
    import cvxpy

    found = cvxpy.installed_solvers()
    return {f"cvxpy {name}": partial(modelled, solver=name) for name in SOLVERS if name in found}


@contextmanager
def without_banner() -> Iterator[None]:
    """Drop what compiled code prints, such as the banner of HiGHS, which no option stops."""
    sys.stdout.flush()
    shown = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(shown, 1)
        os.close(shown)
        os.close(nowhere)


def modelled(grid: Grid, solver: str) -> Solve:
    """cvxpy as people write it: the obstacle is a parameter; solved once before, then again."""
    import cvxpy as cp

    lat = grid.lattice
    u = cp.Variable(grid.nodes)
    floor = cp.Parameter(grid.nodes)
    springs = lat.spring_stiffness / 2 * cp.sum_squares(u)
    links = lat.link_stiffness / 2 * cp.sum_squares(cp.diff(u))
    ends = lat.end_stiffness / 2 * (cp.square(u[0]) + cp.square(u[-1]))
    problem = cp.Problem(cp.Minimize(springs + links + ends), [u >= floor])

    def solve() -> Answer:
        """The programme once more, with the obstacle as given now; RuntimeError if it fails."""
        floor.value = grid.g.copy()
        try:
            with without_banner():
                problem.solve(solver=solver)
        except cp.error.SolverError as failure:
            raise RuntimeError(str(failure)) from None
        if u.value is None:
            raise RuntimeError(f"status {problem.status}")
        multipliers = problem.constraints[0].dual_value
        return grid.read(u.value, multipliers, problem.status == "optimal")

    solve()
    return solve


def bounded(grid: Grid) -> Solve:
    """scipy's L-BFGS-B with u >= g as bounds, tolerances as tight as they go."""
    options = {"ftol": 1e-16, "gtol": 1e-12, "maxiter": 10**5, "maxfun": 10**6, "maxcor": 20}

    def energy(u: Array) -> tuple[float, Array]:
        """The energy u·Ku/2 of displacements (n,), and its gradient Ku."""
        force = grid.pushed(u)
        return float(u @ force) / 2, force

    def solve() -> Answer:
        """From the least displacements that do not penetrate; the multipliers are Ku."""
        start = np.maximum(grid.g, 0)
        bounds = optimize.Bounds(grid.g, np.inf)
        given = {"jac": True, "bounds": bounds, "method": "L-BFGS-B", "options": options}
        found = optimize.minimize(energy, start, **given)
        return grid.read(found.x, np.maximum(grid.pushed(found.x), 0), bool(found.success))

    return solve
