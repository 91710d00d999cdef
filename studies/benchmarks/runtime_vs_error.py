"""How much time does a given accuracy cost, here and with what a user would pick instead?

Work-precision: wall time against the relative errors of a, P, U and θ (P and U over their largest
value on the path or their own; θ over θ) for

| task        | question                                                                       |
| ----------- | ------------------------------------------------------------------------------ |
| nonadhesive | parabola, w = 0: convex, any quadratic solver can do it                        |
| adhesive    | parabola, w > 0                                                                |
| finite      | parabola, w > 0, finite slopes                                                 |
| loop        | loading and unloading of the adhesive parabola; time of one step               |
| many        | the states of the loop as states of their own; time of one                     |
| rough loop  | loading and unloading of a rough profile; its balance of energy, which is 1    |
| rough       | lowest energy of all on a rough profile; its error against the proven one      |

Every point carries its size, its success and the spread of its time; times are medians, as ratios
to one LAPACK `dptsv` of that size measured in between. Modelling (building a cvxpy problem,
matrices, the first solve of a parametrised one) is timed apart from solving.

Output: a line per point; runtime_vs_error.md, the least time to an error; runtime_vs_error.csv with
every point and the floors, one `dptsv` of each size; runtime_vs_error.png: time against the error
of a, of the rough profile against the number of nodes, for tasks with more than a point a method.
"""

# Conventions:
# - `command.parser` has the options of all studies; `command.parse` gives them and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - A `Task` is a scene with depths, exact answers and the methods that take part; `errors(answer)`
#   are the relative errors of a, P, U and θ. TASKS makes one by its name for a number of steps.
# - A `Method` prepares itself for a task and a size, number of nodes or rtol: `make(task, size)`
#   gives what solves, without arguments, and the number of unknowns. `packages` have to be
#   `installed`.
# - A `Point` is one method on one task at one size, `rows` and `table` write them, `fastest` are
#   the methods with the least time to an error, `plot` draws them, and `machine` says where.
# - `tridiagonal_seconds(n)` is the time of one dptsv of n unknowns; `middle(times)` the median of
#   times and their interquartile range over it.
# - `command.some_of` is an option that takes some of the names.

import itertools
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from studies.benchmarks.rivals.problem import Method, Task, installed
from studies.benchmarks.rivals.tasks import TASKS
from studies.benchmarks.runtime_report import (
    TITLES,
    Point,
    fastest,
    machine,
    plot,
    rows,
    table,
)
from studies.shared import command
from studies.shared.batches import each
from studies.shared.timing import middle, tridiagonal_seconds


@dataclass(frozen=True)
class Parameters:
    """What is measured.

    Attributes
    ----------
    sizes : tuple of int
        Numbers of nodes; a method stops at its own largest.
    patience : float
        Time that the repeats of a point may take [s]; a method that takes a quarter of it once
        gets no larger size.
    repeats : int
        Calls that are timed, fewer where patience runs out.
    steps : int
        Depths of the loop.
    """

    sizes: tuple[int, ...] = (1000, 2000, 4000, 10_000, 20_000, 40_000, 10**5, 10**6, 10**7)
    patience: float = 4.0
    repeats: int = 7
    steps: int = 1000


# A first call longer than this many times the patience stands alone, and no size that is expected
# to take longer is begun.
_LONGEST_REPEATED = 5
# Share of the patience that a call may take for a larger size to be begun: one ten times as large
# takes ten to a hundred times as long.
_LARGEST_BEGUN = 0.25
_FLOORS = 3  # times of dptsv of which the median is taken beside each point: they spread little
_LONGEST_NOTE = 120  # characters of what a method that failed said, a line of a table

# Every method once or twice, for a test; its times mean little.
QUICK = Parameters(sizes=(10**3, 10**4), patience=0.05, repeats=3, steps=100)


def timed(work: Callable[[], Any], repeats: int, patience: float) -> tuple[list[float], Any]:
    """Times of calls.

    Parameters
    ----------
    work : callable
    repeats : int
        Calls; fewer once patience has run out, but one at least.
    patience : float
        Seconds that all may take.

    Returns
    -------
    times : list of float
        Of each call [s].
    answer
        Of the last call.
    """
    times: list[float] = []
    while not times or (len(times) < repeats and sum(times) <= patience):
        start = time.perf_counter()
        answer = work()
        times.append(time.perf_counter() - start)
    return times, answer


def measure(task: Task, method: Method, size: float, parameters: Parameters) -> Point:
    """One point; a method that fails says so in its note.

    Parameters
    ----------
    task : Task
    method : Method
    size : float
        Number of nodes, or a tolerance.
    parameters : Parameters

    Returns
    -------
    Point
    """
    try:
        start = time.perf_counter()
        solve, unknowns = method.make(task, size)
        modelling = time.perf_counter() - start
        (first,), answer = timed(solve, 1, 0.0)
        times = [first]
        if first <= _LONGEST_REPEATED * parameters.patience:
            times, answer = timed(solve, parameters.repeats, parameters.patience)
    except (ValueError, ArithmeticError, RuntimeError, MemoryError, IndexError) as problem:
        note = f"{type(problem).__name__}: {problem}".splitlines()[0][:_LONGEST_NOTE]
        return Point.failed(task.name, method.name, size, note)
    per_step = np.array(times) / task.depths.size
    median, spread = middle(per_step)
    floor = tridiagonal_seconds(unknowns, _FLOORS)
    return Point(
        task.name,
        method.name,
        size,
        unknowns,
        modelling,
        first / task.depths.size,
        median,
        spread,
        median / floor,
        task.errors(answer),
        bool(answer.success),
    )


def run(
    parameters: Parameters = Parameters(),
    tasks: Sequence[str] = tuple(TASKS),
    show: Callable[[Point], object] = lambda point: None,
) -> list[Point]:
    """Every method of every task at growing sizes until its patience is exceeded.

    Parameters
    ----------
    parameters : Parameters
    tasks : sequence of str
        Names of TASKS.
    show : callable
        Called with each point as soon as it is measured.

    Returns
    -------
    list of Point
    """
    chosen = [TASKS[name](parameters.steps) for name in tasks]
    cases = [(task, method) for task in chosen for method in task.methods]
    measured = each(partial(_grown, parameters, show), cases, 1)
    return list(itertools.chain.from_iterable(measured))


def _grown(
    parameters: Parameters, show: Callable[[Point], object], case: tuple[Task, Method]
) -> list[Point]:
    """The points of one method, at growing sizes."""
    task, method = case
    points: list[Point] = []
    if not all(map(installed, method.packages)):
        note = f"{', '.join(method.packages)} not installed"
        points.append(Point.failed(task.name, method.name, 0, note))
        show(points[-1])
        return points
    for size in method.sizes(parameters.sizes):
        if points:
            next_seconds = expected(points, size) * task.depths.size
            if not next_seconds < _LONGEST_REPEATED * parameters.patience:
                break
        point = measure(task, method, size, parameters)
        points.append(point)
        show(point)
        # a method that failed has no time (NaN), and ends here, too
        if not point.seconds * task.depths.size < parameters.patience * _LARGEST_BEGUN:
            break
    return points


def expected(points: Sequence[Point], size: float) -> float:
    """Seconds at the next size by a power law: quadratic, or through the last two points.

    Parameters
    ----------
    points : sequence of Point
        Those that a method has, one at least.
    size : float

    Returns
    -------
    float
        Of one depth; for a tolerance those of the last point.
    """
    last = points[-1]
    if size < 1:  # a tolerance
        return last.seconds
    power = 2.0
    if len(points) > 1:
        before = points[-2]
        seen = math.log(last.seconds / before.seconds) / math.log(last.size / before.size)
        power = max(1.0, seen)
    return float(last.seconds * (size / last.size) ** power)


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    parser = command.parser("runtime_vs_error", __doc__, "small sizes, under 20 s")
    command.some_of(parser, "--tasks", tuple(TASKS))
    options, out = command.parse(parser, argv)
    p = QUICK if options.preset == "quick" else Parameters()
    points = run(p, options.tasks, lambda point: command.say(line(point)))
    floors = {n: tridiagonal_seconds(n, p.repeats) for n in p.sizes}
    out.table("runtime_vs_error.csv", p, *rows(points, floors), notes=[machine()])
    text = table(points)
    out.text("runtime_vs_error.md", text)
    out.figure("runtime_vs_error.png", plot(points, floors))
    print(text)
    for name in options.tasks:
        own = [p for p in points if p.task == name and not p.note]
        command.answer(f"For {TITLES[name]}, {fastest(own)}.")
    return 0


def line(point: Point) -> str:
    """One point on the screen."""
    size = f"{point.size:9.3g}" if point.size else "         "
    if math.isnan(point.errors[0]):  # a rough profile: U alone counts
        error = f"error of U {point.errors[2]:.1e}"
    else:
        error = f"error of a {point.errors[0]:.1e}"
    says = point.note or f"{point.seconds * 1e3:10.3f} ms, {error}"
    return f"{point.task:12s} {point.method:40s} {size} {says}"
