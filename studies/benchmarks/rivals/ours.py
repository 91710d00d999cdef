"""What this package answers to the tasks of runtime_vs_error; each is given a task and a size."""

import math
import warnings
from typing import Any

import numpy as np

from discretization import AccuracyWarning, Equilibrium, load_path, minimise
from discretization.inside import global_minimum, obstacle
from studies.benchmarks.rivals.problem import Answer, Grid, Solve, Task, rough


def _answer(state: Equilibrium) -> Answer:
    done = state.certificate.ok
    return Answer(state.half_width, state.force, state.energy, state.contact_angle, done)


def default(task: Task, rtol: float) -> tuple[Solve, int]:
    """`minimise` with its defaults but rtol."""

    def solve() -> Answer:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AccuracyWarning)
            return _answer(minimise(task.scene, task.depth, rtol=rtol))

    return solve, 50_000


def lattice(task: Task, size: float) -> tuple[Solve, int]:
    """As many nodes in contact as asked for."""
    dx = 2 * float(task.exact[0, -1]) / size
    options: dict[str, Any] = {"method": "lattice", "spacing": dx}
    return lambda: _answer(minimise(task.scene, task.depth, **options)), int(size)


def hull(grid: Grid) -> Solve:
    """w = 0 on the nodes of the rivals."""

    def solve() -> Answer:
        found = obstacle(grid.lattice, grid.g)
        read = grid.read(found.u, found.multipliers)
        return read._replace(force=found.force, energy=found.energy)

    return solve


def _followed(task: Task, **options: Any) -> Solve:
    def solve() -> Answer:
        path = load_path(task.scene, depths=task.depths, **options)
        angle = np.full(task.depths.size, math.nan)
        return Answer(path.half_width, path.force, path.energy, angle)

    return solve


def path(task: Task, rtol: float) -> tuple[Solve, int]:
    """`load_path` with its defaults but rtol."""
    return _followed(task, rtol=rtol), 50_000


def lattice_path(task: Task, size: float) -> tuple[Solve, int]:
    """`load_path` on as many nodes in the largest contact."""
    dx = 2 * float(task.exact[0].max()) / size
    return _followed(task, method="lattice", spacing=dx), int(size)


def shortest(task: Task, size: float) -> tuple[Solve, int]:
    """The proven lowest energy over itself and the violation of its proof."""
    nodes, g = rough(int(size))

    def solve() -> Answer:
        _, proof = global_minimum(nodes, g)
        return Answer(math.nan, math.nan, 1 + proof.violation, math.nan)

    return solve, int(size)
