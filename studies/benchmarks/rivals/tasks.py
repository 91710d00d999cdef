"""The tasks of runtime_vs_error: scenes with known answers, and who takes part in each."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from discretization.inside import Oracle, global_minimum
from energy import cards
from studies.benchmarks.rivals import active_set, conic, one_line, ours
from studies.benchmarks.rivals.problem import (
    RADIUS,
    Answer,
    Grid,
    Method,
    Solve,
    Task,
    elastic,
    rough,
)
from studies.shared.random_cases import steep_totals
from studies.shared.timing import tridiagonal_seconds

Make = Callable[[Task, float], tuple[Solve, int]]
TASKS = ("nonadhesive", "adhesive", "finite", "loop", "rough", "sphere", "sphere_loop")
DEPTH, WORK = 5.0, 0.02  # k = γ₁ = 1
STEEP_RADIUS, STEEP_WIDTH, STEEP_WORK = 5.0, 2.0, 0.3
ROUGH_NODES = (60, 200, 500, 1000, 2000, 4000, 10_000, 20_000, 40_000, 10**5)
MARGIN = 15.0  # elastocapillary lengths of free surface that a rival's grid covers on each side


def named(name: str, steps: int) -> Task:
    """One of TASKS; steps: of a loop."""
    known = Method("ours, default", _known(ours.default), tolerances=True), OURS[1]
    known_path = Method("ours, load_path", _known(ours.path), tolerances=True), PATHS[1]
    made: dict[str, Callable[[], Task]] = {
        "nonadhesive": lambda: _blunt(name, (*OURS, *_convex()), w=0.0),
        "adhesive": lambda: _blunt(name, (*OURS, *BY_HAND)),
        "finite": _finite,
        "loop": lambda: _blunt(name, (*PATHS, LAST), steps=steps),
        "rough": _rough,
        "sphere": lambda: _blunt(name, known, geometry="axisymmetric"),
        "sphere_loop": lambda: _blunt(name, known_path, steps=steps, geometry="axisymmetric"),
    }
    return made[name]()


def _blunt(
    name: str, methods: tuple[Method, ...], w: float = WORK, steps: int = 0, geometry: str = "line"
) -> Task:
    """A parabola or sphere at DEPTH, or on 0 -> DEPTH -> just above where the contact detaches."""
    card: Any = cards.parabola
    given = {"R": RADIUS, "k": 1.0, "gamma1": 1.0, "w": w}
    width, last = card.half_width, -math.sqrt(2 * w)
    if geometry == "axisymmetric":
        card = cards.axisymmetric.sphere
        width, last = card.radius, float(card.detachment(**given).depth)
    loading, half = np.linspace(0, DEPTH, steps // 2), steps - steps // 2
    loop = np.r_[loading, np.linspace(DEPTH, 0.99 * last, half)]
    depths = loop if steps else np.array([DEPTH])
    known = [one(depths, **given) for one in (width, card.force, card.energy)]
    exact = np.array([*known, np.full(depths.size, math.pi - math.sqrt(2 * w))])
    return Task(name, elastic(w, RADIUS, geometry=geometry), depths, exact, methods)


def _grid(task: Task, size: float, depth: float | None = None) -> Grid:
    n = int(size) // 2 * 2 + 1
    reach = float(task.exact[0].max()) + MARGIN * task.scene.elastocapillary_length
    return Grid(task.scene, task.depth if depth is None else depth, n, reach)


def _on_grid(prepare: Callable[[Grid], Solve]) -> Make:
    def make(task: Task, size: float) -> tuple[Solve, int]:
        grid = _grid(task, size)
        return prepare(grid), grid.nodes

    return make


def _bvp(task: Task, rtol: float) -> tuple[Solve, int]:
    guess = 1.1 * float(task.exact[0, -1])
    return one_line.boundary_value(task.scene, task.depth, rtol, guess), 50_000


def _known(make: Make) -> Make:
    """Solved once beforehand, as modelling: surfaces of all radii are kept from then on."""

    def made(task: Task, rtol: float) -> tuple[Solve, int]:
        solve, unknowns = make(task, rtol)
        solve()
        return solve, unknowns

    return made


def _by_hand(task: Task, size: float) -> tuple[Solve, int]:
    """Each of a few steps from its predecessor's line, which is taken as known."""
    chosen = task.chosen
    grids = [_grid(task, size, float(task.depths[i])) for i in chosen]
    before = [max(1, round(task.exact[0, max(i - 1, 0)] / grids[0].spacing)) for i in chosen]

    def solve() -> Answer:
        pairs = zip(grids, before, strict=True)
        found = [one_line.bisection(grid, m)()[:4] for grid, m in pairs]
        return Answer(*np.array(found).T)

    return solve, grids[0].nodes


OURS = (
    Method("ours, default", ours.default, tolerances=True),
    Method("ours, lattice", ours.lattice),
)
PATHS = (
    Method("ours, load_path", ours.path, tolerances=True),
    Method("ours, load_path on the lattice", ours.lattice_path),
)
LAST = Method("one line by hand, from the last", _by_hand, 10**5, few=True)
BVP = Method("scipy solve_bvp (angle put in)", _bvp, tolerances=True)
BY_HAND = Method("one line by hand, dptsv", _on_grid(one_line.bisection), 10**6), BVP


def _convex() -> tuple[Method, ...]:
    return (
        Method("ours, obstacle (lattice)", _on_grid(ours.hull)),
        Method("active set, nested grids", _on_grid(active_set.nested)),
        Method("Clarabel, direct", _on_grid(conic.clarabel), 10**5),
        Method("OSQP, direct", _on_grid(conic.osqp), 10**5),
        Method("OSQP 1e-9, direct", _on_grid(partial(conic.osqp, tolerance=1e-9)), 10**4),
        Method("PIQP, direct", _on_grid(conic.piqp), 10**6, ("piqp",)),
        Method(
            "PIQP 1e-10, direct", _on_grid(partial(conic.piqp, tolerance=1e-10)), 10**5, ("piqp",)
        ),
        *(Method(n, _on_grid(p), 10**5) for n, p in conic.cvxpy_solvers().items()),
        Method("scipy L-BFGS-B", _on_grid(conic.bounded), 10**4),
        Method("scikit-fem, nested", _on_grid(active_set.scikit_fem), 10**6, ("skfem",)),
    )


def _finite() -> Task:
    a, w = STEEP_WIDTH, STEEP_WORK
    scene = elastic(w, STEEP_RADIUS, "finite")
    d = float(
        cards.finite.depth(a * a / 2 / STEEP_RADIUS, a / STEEP_RADIUS, k=1.0, gamma1=1.0, w=w)
    )
    exact = np.array([[a, *steep_totals(scene, d, a), scene.surfaces.contact_angle]]).T
    hand = Method("one line by hand, Newton", _on_grid(one_line.bisection), 10**5)
    return Task("finite", scene, np.array([d]), exact, (*OURS, hand, BVP))


def _rough() -> Task:
    """The lowest energy of all; exact is what each size proves itself, so that only U counts."""
    nothing = np.array([[1.0, 1.0, 1.0, 1.0]]).T
    methods = (
        Method("ours, shortest path (lattice)", ours.shortest, only=ROUGH_NODES),
        Method("cvxpy SCIP, mixed integer", _integers, packages=("pyscipopt",), only=(15, 30, 60)),
    )
    return Task("rough", elastic(0.05, RADIUS), np.array([0.5]), nothing, methods)


def _integers(task: Task, size: float) -> tuple[Solve, int]:
    lattice, g = rough(int(size))
    (_, proof), oracle = global_minimum(lattice, g), Oracle(lattice, int(size))
    proven = proof.attained
    return lambda: Answer(math.nan, math.nan, oracle.solve(g).energy / proven, math.nan), int(size)


def guarded() -> dict[str, tuple[Callable[[], object], Callable[[], object]]]:
    """What may not become slower, and what it is measured against."""
    flat, sticky = named("nonadhesive", 1), named("adhesive", 1)
    steep, loop = named("finite", 1), named("loop", 100)
    grid = _grid(flat, 10**5)

    def dptsv(n: int) -> Callable[[], object]:
        return partial(tridiagonal_seconds, n, 1)

    return {
        "adhesive, default / dptsv(50000)": (ours.default(sticky, 1e-8)[0], dptsv(50_000)),
        "finite, default / dptsv(50000)": (ours.default(steep, 1e-8)[0], dptsv(50_000)),
        "adhesive, lattice 1e5 / dptsv(1e5)": (ours.lattice(sticky, 1e5)[0], dptsv(10**5)),
        "adhesive, lattice 1e6 / dptsv(1e6)": (ours.lattice(sticky, 1e6)[0], dptsv(10**6)),
        "nonadhesive, obstacle 1e5 / active set 1e5": (ours.hull(grid), active_set.nested(grid)),
        "loop of 100, load_path / dptsv(1e6)": (ours.path(loop, 1e-8)[0], dptsv(10**6)),
        "loop of 100, lattice 1e4 / dptsv(1e6)": (ours.lattice_path(loop, 1e4)[0], dptsv(10**6)),
        "rough, shortest path 1e3 / dptsv(1e6)": (ours.shortest(sticky, 1e3)[0], dptsv(10**6)),
    }
