"""The tasks of runtime_vs_error: scenes with known answers, and who takes part in each.

Conventions:

- `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the states
  at these values one after the other: a `History` with arrays `depth`, `force` (positive where it
  presses), `half_width`; `dissipated`, the energy that it loses; `work()`, the ∮ P dd.
- A scene has `elastocapillary_length` l = √(γ₁/k).
- `AccuracyWarning` says that the estimated error of a state exceeds its rtol.
- `elastic(w, R)` is a parabola with k = γ₁ = 1, `rough(n)` one with waves and n nodes,
  `waves(contacts)` a rough profile with about so many, its samples WAVES_SPACING apart.
- A `Grid` is n nodes under a scene, a `Solve` has no arguments and returns an `Answer`, a, P, U and
  θ.
- `knots` are the samples of a profile.
- `steep_totals(scene, d, a)` are P and U with finite slopes.
- `certificate.ok`: the state has passed its own checks; `stable` does so for each of many.
"""

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from discretization import AccuracyWarning, Equilibrium, load_path, minimise, minimise_many
from energy import Scene, cards
from studies.benchmarks.rivals import by_hand, solvers
from studies.benchmarks.rivals.problem import (
    RADIUS,
    WAVES_SPACING,
    Answer,
    Grid,
    Method,
    Solve,
    Task,
    elastic,
    rough,
    waves,
)
from studies.shared.random_cases import steep_totals

Made = tuple[Solve, int]  # what solves, and its unknowns

# Units are k = γ₁ = l = 1. The scenes are chosen so that lengths differ by no more than a factor
# of ten and nothing vanishes: with a radius of 10 and this depth the half-width is 9.2 l.
DEPTH = 5.0
WORK = 0.02  # √(2w/γ₁) = 0.2
# With finite slopes: so steep that small slopes would be off by some per cent.
STEEP_RADIUS = 5.0
STEEP_WIDTH = 2.0  # half-width of the contact: f'(a) = 0.4
STEEP_WORK = 0.3  # a contact angle of 134°

# Nodes of the rough profile; the largest number takes 1.4 s by shortest paths.
ROUGH_NODES = (60, 200, 500, 1000, 2000, 4000, 10_000, 20_000, 40_000, 10**5)
# Those for an integer programme: 60 take 1 to 2 s, 100 take 5 s, and 150 more than a minute.
INTEGER_NODES = (20, 30, 60)

# Lengths l of free surface that a rival's grid covers on each side. The ends are exact: with 5 or
# 10 all errors of a, P and U change by less than 4e-8 at the same spacing of l/1000.
MARGIN = 15.0

# Unknowns of a dptsv that takes about as long as a method without nodes: 0.6 ms, `minimise` 1 ms.
SIMILAR = 50_000

# Largest numbers of nodes. With 3·10⁶ rounding makes the force by hand worse, 9e-10 after 5e-11
# with 10⁶; with finite slopes 10⁶ take a minute. Of cvxpy's solvers OSQP takes 15 s for 10⁵, and
# L-BFGS-B fails after a minute at 3·10⁴.
LARGEST_BY_HAND = 10**6
LARGEST_STEEP = 10**5
LARGEST_CVXPY = 10**5
LARGEST_BOUNDED = 10**4

CONTACTS = (1, 3, 10, 30, 100)  # about, of the rough profiles of load paths
# Depths of these in rms heights; at the last one, below -δ₀ = -√0.6, nothing touches any more.
ROUGH_TOP = 3.0
ROUGH_BOTTOM = -2.5


def _judged_by_its_error(scene: Scene, depth: float, **options: Any) -> Equilibrium:
    """`minimise` without its warnings of accuracy, which is measured here."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        return minimise(scene, depth, **options)


def default(task: Task, rtol: float) -> Made:
    """`minimise` with its defaults but rtol."""

    def solve() -> Answer:
        """The answer at the depth of the task, or at all of them: what is timed."""
        return _answer(_judged_by_its_error(task.scene, task.depth, rtol=rtol))

    return solve, SIMILAR


def _answer(state: Equilibrium) -> Answer:
    """What is compared of a state."""
    done = state.certificate.ok
    return Answer(state.half_width, state.force, state.energy, state.contact_angle, done)


def lattice(task: Task, size: float) -> Made:
    """`minimise` on the lattice, with as many nodes in contact."""
    dx = 2 * task.half_width / size

    def solve() -> Answer:
        """The answer at the depth of the task, or at all of them: what is timed."""
        return _answer(minimise(task.scene, task.depth, method="lattice", spacing=dx))

    return solve, int(size)


def path(task: Task, rtol: float) -> Made:
    """`load_path` with its defaults but rtol."""
    return _followed(task, rtol=rtol), SIMILAR


def lattice_path(task: Task, size: float) -> Made:
    """`load_path` on as many nodes in the largest contact."""
    dx = 2 * task.largest_half_width / size
    return _followed(task, method="lattice", spacing=dx), int(size)


def _followed(task: Task, **options: Any) -> Solve:
    """The whole path, by `load_path` with these options."""

    def solve() -> Answer:
        """The answer at the depth of the task, or at all of them: what is timed."""
        found = load_path(task.scene, depths=task.depths, **options)
        angle = np.full(task.depths.size, math.nan)
        return Answer(found.half_width, found.force, found.energy, angle)

    return solve


def many(task: Task, size: float) -> Made:
    """`minimise_many` at all depths."""

    def solve() -> Answer:
        """The answer at the depth of the task, or at all of them: what is timed."""
        found = minimise_many(task.scene, task.depths)
        done = bool(found.stable.all())
        return Answer(found.half_width, found.force, found.energy, found.contact_angle, done)

    return solve, SIMILAR


def one_by_one(task: Task, size: float) -> Made:
    """`minimise` at one depth after the other."""

    def solve() -> Answer:
        """The answer at the depth of the task, or at all of them: what is timed."""
        each = [_answer(minimise(task.scene, depth)) for depth in task.depths.tolist()]
        a, force, energy, angle, done = map(np.array, zip(*each, strict=True))
        return Answer(a, force, energy, angle, bool(done.all()))

    return solve, SIMILAR


def rough_path(**options: Any) -> Callable[[Task, float], Made]:
    """`load_path` over rough profiles; in place of U its external work over the energy it loses.

    Parameters
    ----------
    **options
        Of `load_path`.

    Returns
    -------
    callable
        Prepares a path for a task and about so many contacts; the unknowns are the samples of
        the profile.
    """

    def make(task: Task, contacts: float) -> Made:
        """What solves, and its unknowns, for a task and a size."""
        scene = waves(int(contacts))

        def solve() -> Answer:
            """The answer at the depth of the task, or at all of them: what is timed."""
            found = load_path(scene, depths=task.depths, **options)
            return Answer(math.nan, math.nan, found.work() / found.dissipated, math.nan)

        return solve, len(scene.indenter.knots)

    return make


def shortest(task: Task, size: float) -> Made:
    """`minimise` by shortest paths; in place of U 1 + the violation of its proof, which is 0."""
    scene, options = rough(int(size))

    def solve() -> Answer:
        """The answer at the depth of the task, or at all of them: what is timed."""
        state = minimise(scene, task.depth, method="shortest_path", **options)
        violation = state.proof.violation if state.proof else math.inf
        return Answer(math.nan, math.nan, 1 + violation, math.nan)

    return solve, int(size)


def integers(task: Task, size: float) -> Made:
    """The same nodes as a mixed-integer programme; in place of U its energy over the proven one."""
    scene, options = rough(int(size))
    proven = _judged_by_its_error(scene, task.depth, method="shortest_path", **options).energy

    def solve() -> Answer:
        """The answer at the depth of the task, or at all of them: what is timed."""
        state = _judged_by_its_error(scene, task.depth, method="oracle", **options)
        return Answer(math.nan, math.nan, state.energy / proven, math.nan)

    return solve, int(size)


def on_grid(prepare: Callable[[Grid], Solve]) -> Callable[[Task, float], Made]:
    """What is given nodes over the contact and the free surface beside it.

    Parameters
    ----------
    prepare : callable
        Makes of a grid what solves.

    Returns
    -------
    callable
        Prepares it for a task and a number of nodes, which is made odd: one is at x = 0.
    """

    def make(task: Task, size: float) -> Made:
        """What solves, and its unknowns, for a task and a size."""
        reach = task.largest_half_width + MARGIN * task.scene.elastocapillary_length
        odd = int(size) // 2 * 2 + 1
        grid = Grid(task.scene, task.depth, odd, reach)
        return prepare(grid), grid.nodes

    return make


def boundary_value(task: Task, rtol: float) -> Made:
    """scipy's solve_bvp, started a tenth too wide."""
    guess = 1.1 * task.half_width
    return by_hand.boundary_value(task.scene, task.depth, rtol, guess), SIMILAR


OURS = (
    Method("ours, default", default, tolerances=True),
    Method("ours, lattice", lattice),
)
PATHS = (
    Method("ours, load_path", path, tolerances=True),
    Method("ours, load_path on the lattice", lattice_path),
)
MANY = (
    Method("ours, minimise_many", many, only=(SIMILAR,)),
    Method("ours, minimise one by one", one_by_one, only=(SIMILAR,)),
)
BVP = Method("scipy solve_bvp, angle as boundary condition", boundary_value, tolerances=True)
BY_HAND = Method("one line by hand, dptsv", on_grid(by_hand.bisection), LARGEST_BY_HAND)
ROUGH = (
    Method("ours, shortest path (lattice)", shortest, only=ROUGH_NODES),
    Method("cvxpy SCIP, mixed integer", integers, packages=("pyscipopt",), only=INTEGER_NODES),
)
ROUGH_PATHS = (
    Method("ours, load_path", rough_path(), only=CONTACTS),
    Method(
        "ours, load_path on the lattice",
        rough_path(method="lattice", spacing=WAVES_SPACING),
        only=CONTACTS,
    ),
)


def convex() -> tuple[Method, ...]:
    """What can solve a quadratic programme."""
    active_set = Method("active set, nested grids", on_grid(by_hand.nested))
    found = solvers.through_cvxpy().items()
    modelled = [Method(name, on_grid(prepare), LARGEST_CVXPY) for name, prepare in found]
    bounded = Method("scipy L-BFGS-B", on_grid(solvers.bounded), LARGEST_BOUNDED)
    return active_set, *modelled, bounded


def adhesive(name: str, methods: tuple[Method, ...], w: float = WORK, steps: int = 0) -> Task:
    """A parabola at DEPTH, or on 0 -> DEPTH -> just above where the contact detaches.

    Parameters
    ----------
    name : str
    methods : tuple of Method
    w : float
        Work of adhesion over γ₁.
    steps : int
        Depths of the loop; 0: DEPTH alone.

    Returns
    -------
    Task
    """
    if steps:
        detachment = -math.sqrt(2 * w)
        loading = np.linspace(0, DEPTH, steps // 2)
        unloading = np.linspace(DEPTH, 0.99 * detachment, steps - steps // 2)
        depths = np.concatenate([loading, unloading])
    else:
        depths = np.array([DEPTH])
    given = {"R": RADIUS, "k": 1.0, "gamma1": 1.0, "w": w}
    half_width = cards.parabola.half_width(depths, **given)
    force = cards.parabola.force(depths, **given)
    energy = cards.parabola.energy(depths, **given)
    angle = np.full(depths.size, math.pi - math.sqrt(2 * w))
    exact = np.array([half_width, force, energy, angle])
    return Task(name, elastic(w, RADIUS), depths, exact, methods)


def finite() -> Task:
    """A steep parabola with finite slopes, at the depth where its line is at STEEP_WIDTH."""
    a = STEEP_WIDTH
    scene = elastic(STEEP_WORK, STEEP_RADIUS, "finite")
    height = a * a / 2 / STEEP_RADIUS
    slope = a / STEEP_RADIUS
    depth = float(cards.finite.depth(height, slope, k=1.0, gamma1=1.0, w=STEEP_WORK))
    force, energy = steep_totals(scene, depth, a)
    exact = np.array([[a], [force], [energy], [scene.surfaces.contact_angle]])
    hand = Method("one line by hand, Newton", on_grid(by_hand.bisection), LARGEST_STEEP)
    return Task("finite", scene, np.array([depth]), exact, (*OURS, hand, BVP))


def rough_loop(steps: int) -> Task:
    """A loop to ROUGH_TOP of a seventh as many steps, as one takes that much longer.

    With fewer than 600 steps it goes less deep, so that steps do not grow.
    """
    top = min(ROUGH_TOP, steps / 200)
    half = math.ceil(steps / 14)
    loading = np.linspace(0, top, half)
    unloading = np.linspace(top, ROUGH_BOTTOM, half)
    depths = np.concatenate([loading, unloading])
    return Task("rough loop", waves(CONTACTS[0]), depths, np.ones((4, 1)), ROUGH_PATHS)


TASKS: dict[str, Callable[[int], Task]] = {
    "nonadhesive": lambda steps: adhesive("nonadhesive", (*OURS, *convex()), w=0.0),
    "adhesive": lambda steps: adhesive("adhesive", (*OURS, BY_HAND, BVP)),
    "finite": lambda steps: finite(),
    "loop": lambda steps: adhesive("loop", PATHS, steps=steps),
    "many": lambda steps: adhesive("many", MANY, steps=steps),
    "rough loop": rough_loop,
    # exact is what each size proves itself, so that only U counts
    "rough": lambda steps: Task("rough", rough(60)[0], np.array([0.5]), np.ones((4, 1)), ROUGH),
}
