"""How long does a default equilibrium take, against one tridiagonal solve, and how wrong is it?

`minimise(scene, depth)` with its defaults (contact lines, energy, force by two routes, certificate,
error estimate) for random scenes of every built-in indenter over eight decades of length and of
stress, small and finite slopes: wall time over that of one LAPACK `dptsv` with 10⁵ unknowns in the
same process, next to the true errors against energy.cards,

    |a - a*|/a*,   |P - P*|/ΣP,   |U - U*|/ΣU,   |θ - θ*|,

ΣP and ΣU being the sums of the terms' absolute values (a force may pass through zero). Every scene
is new and solved once; what is kept between scenes are the free surfaces for finite slopes, in
units of l and γ₁ the same for all. The time limit is for the 95th percentile. Finite slopes have
convex indenters only.

Output: a line per indenter, fitted_speed.csv with a row per scene. Exit status 1 if an error misses
its limit, with --strict also if a time does: machines may be shared.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization import minimise
from energy import Plane, Profile, Sampled, cards
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import BLUE, COLOURS, MARKERS, ORANGE, Figure, canvas
from studies.shared.random_cases import SHAPES, Case, random_case, random_steep_case
from studies.shared.table import Columns, Table
from studies.shared.timing import tridiagonal_seconds

SAMPLES = 201
NAMES = {"flat": "flat punch", "power": "power law"}


@dataclass(frozen=True)
class Parameters:
    """Scenes of each indenter with small and with finite slopes, unknowns of dptsv, seed."""

    small: int = 200
    finite: int = 60
    unknowns: int = 10**5
    seed: int = 1


class Bar(NamedTuple):
    """Largest time in dptsv, relative error of a, P and U, error of θ in rad."""

    ratio: float
    error: float
    angle: float


BARS = {"small": Bar(1.0, 1e-10, 1e-9), "finite": Bar(10.0, 1e-9, 1e-9)}


class Trial(NamedTuple):
    """One scene: time in s, time of the dptsv beside it, errors; why it was not solved.

    errors: relative, of a, P and U; of θ in rad, nan where the line is pinned to an edge; inf where
    there is no answer.
    """

    case: Case
    seconds: float
    floor: float
    errors: tuple[float, float, float, float]
    failure: str


@dataclass(frozen=True)
class Row:
    """All trials of one indenter."""

    slopes: str
    shape: str
    trials: tuple[Trial, ...]

    @property
    def bar(self) -> Bar:
        """What is demanded of these slopes."""
        return BARS[self.slopes]

    def ratio(self, percentile: float) -> float:
        """Percentile of the times over the median of the dptsv's between them."""
        floor = np.median([trial.floor for trial in self.trials])
        return float(np.percentile([trial.seconds for trial in self.trials], percentile) / floor)

    @property
    def worst(self) -> NDArray[np.float64]:
        """Largest errors of a, P, U and θ, (4,)."""
        return np.max([trial.errors for trial in self.trials], axis=0)

    @property
    def accurate(self) -> bool:
        """Whether every scene was solved with its errors below the limits."""
        *relative, angle = self.worst
        return max(relative) <= self.bar.error and (math.isnan(angle) or angle <= self.bar.angle)

    @property
    def fast(self) -> bool:
        """Whether 95 of 100 scenes stay below the limit of time."""
        return self.ratio(95) <= self.bar.ratio


def plane_case(rng: np.random.Generator) -> Case:
    """An endless plane: it holds everywhere down to -δ₀, Eq. (19), and nowhere below."""
    case = random_case(rng, "flat")
    k, w = case.scene.stiffness, case.scene.work_of_adhesion
    d = case.scene.critical_separation * rng.uniform(-2, 2)
    held = d >= cards.plane.critical_depth(k, w)
    force, energy = (math.copysign(math.inf, v) if held else 0.0 for v in (d, k * d * d / 2 - w))
    scene = replace(case.scene, indenter=Plane())
    return Case(scene, d, math.inf if held else 0.0, force, energy, "plane")


def sampled_case(rng: np.random.Generator, shape: str, kind: str) -> Case:
    """The profile known by samples, one of them at x = 0, out to twice the widest contact.

    That is the contact at this depth or at d = 0, where the adhered branch begins.
    """
    case = random_case(rng, shape)
    touched = minimise(case.scene, max(case.depth, 0.0))
    reach = 2 * touched.half_width
    x = np.linspace(-reach, reach, SAMPLES)
    indenter = Sampled(x, case.scene.indenter.height(x), kind=kind)
    return replace(case, scene=replace(case.scene, indenter=indenter))


def callable_case(rng: np.random.Generator) -> Case:
    """A parabola known by two functions only."""
    case = random_case(rng, "parabola")
    profile = Profile(case.scene.indenter.height, case.scene.indenter.slope)
    return replace(case, scene=replace(case.scene, indenter=profile))


Maker = Callable[[np.random.Generator], Case]
SMALL: dict[str, Maker] = {
    "plane": plane_case,
    **{NAMES.get(s, s): partial(random_case, shape=s) for s in SHAPES},
    "wedge, samples": partial(sampled_case, shape="wedge", kind="linear"),
    "parabola, samples": partial(sampled_case, shape="parabola", kind="smooth"),
    "parabola, callable": callable_case,
}
FINITE: dict[str, Maker] = {NAMES.get(s, s): partial(random_steep_case, shape=s) for s in SHAPES}
MAKERS = {"small": SMALL, "finite": FINITE}


def measure(case: Case, unknowns: int) -> Trial:
    """Solve a case once; time and errors."""
    floor, failure = tridiagonal_seconds(unknowns, 1), ""
    start = time.perf_counter()
    try:
        state = minimise(case.scene, case.depth)
    except (ValueError, ArithmeticError, RuntimeError) as problem:
        failure = f"{type(problem).__name__}: {problem}"
    seconds = time.perf_counter() - start
    if failure:
        return Trial(case, seconds, floor, (math.inf,) * 4, failure)
    angle = abs(state.angle_deficit - case.angle_deficit)
    lost = math.isnan(angle) and not math.isnan(case.angle_deficit)
    errors = *case.errors(state, case.half_width), math.inf if lost else angle
    return Trial(case, seconds, floor, errors, failure)


def run(parameters: Parameters = Parameters(), show: Show = silent) -> list[Row]:
    """Measure every indenter; `show` gets a line for each."""
    show(COLUMNS.head)
    cases = [(slopes, shape) for slopes, makers in MAKERS.items() for shape in makers]
    return list(each(partial(_row, parameters), cases, 1, say=lambda row: show(line(row))))


def _row(parameters: Parameters, case: tuple[str, str]) -> Row:
    slopes, shape = case
    count: int = getattr(parameters, slopes)
    number, make = list(MAKERS[slopes]).index(shape), MAKERS[slopes][shape]
    rng = np.random.default_rng([parameters.seed, len(slopes), number])
    measure(make(rng), parameters.unknowns)  # what every process pays once
    return Row(slopes, shape, tuple(measure(make(rng), parameters.unknowns) for _ in range(count)))


COLUMNS = Columns(
    "slopes -6|indenter -18|scenes 6|dptsv 6.2f|95 % 6.2f|limit 5g|time 6|err a 6.0e|err P 6.0e|"
    "err U 6.0e|err θ 6.0e|limit 6.0e|errors 6"
)


def line(row: Row) -> str:
    """One line of the table."""
    failures = [trial.failure for trial in row.trials if trial.failure]
    times = row.ratio(50), row.ratio(95), row.bar.ratio, "ok" if row.fast else "MISSED"
    errors = *row.worst.tolist(), row.bar.error, "ok" if row.accurate else "FAIL"
    text = COLUMNS.line(row.slopes, row.shape, len(row.trials), *times, *errors)
    return text + (f"\n  {len(failures)} not solved, first: {failures[0]}" if failures else "")


def table(rows: Sequence[Row]) -> Table:
    """A row per scene, lengths in the scene's own units; `number` counts within an indenter."""
    names = ["slopes", "indenter", "number", "l", "k", "w", "depth", "half_width", "seconds"]
    names += ["dptsv_seconds", "error_half_width", "error_force", "error_energy", "error_angle"]
    found: list[list[object]] = []
    for row in rows:
        for number, (case, seconds, floor, errors, failure) in enumerate(row.trials):
            scene = case.scene
            given = (scene.elastocapillary_length, scene.stiffness, scene.work_of_adhesion)
            where = (row.slopes, row.shape, number, *given, case.depth, case.half_width)
            found.append([*where, seconds, floor, *errors, failure])
    return [*names, "failure"], found


def plot(rows: Sequence[Row]) -> Figure:
    """Median time with the middle 90 % and its limit, and the largest errors, by indenter."""
    figure, (left, right) = canvas(12, 1.4 + 0.32 * len(rows), 1, 2, sharey=True)
    at = np.arange(len(rows))
    middle, low, high = (np.array([row.ratio(p) for row in rows]) for p in (50, 5, 95))
    spread = np.array([middle - low, high - middle])
    left.errorbar(middle, at, xerr=spread, fmt="o", color=BLUE, label="median, middle 90 %")
    left.plot([row.bar.ratio for row in rows], at, "|", ms=12, color=ORANGE, label="limit of 95 %")
    left.set(xscale="log", xlabel="time of minimise / time of one dptsv, n = 10⁵", yticks=at)
    left.set_yticklabels([f"{row.shape}, {row.slopes}" for row in rows])
    left.invert_yaxis()
    for k, name in enumerate(("a", "P", "U", "θ")):
        errors = [max(row.worst[k], 1e-17) for row in rows]
        right.semilogx(errors, at, MARKERS[k], color=COLOURS[k], ms=5, label=name)
    right.plot([row.bar.error for row in rows], at, "|", ms=12, color="black", label="limit")
    right.set(xlabel="largest relative error, of θ in rad (below 1e-17: drawn there)")
    for axes in (left, right):
        axes.grid(alpha=0.25, axis="x")
        axes.legend(fontsize=8, loc="lower left", bbox_to_anchor=(0, 1), ncols=5)
    accurate, fast = (sum(getattr(row, name) for row in rows) for name in ("accurate", "fast"))
    figure.suptitle(
        f"Of {len(rows)} kinds of scenes {accurate} keep their limit of error, {fast} that of time"
    )
    return figure


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; 1 if an error limit is missed, with --strict also for a time limit."""
    parser = command.parser("fitted_speed", __doc__, "10 and 5 scenes per indenter")
    preset = Parameters()
    counts = ("scenes", preset.small, "small"), ("steep", preset.finite, "finite")
    for name, default, slopes in counts:
        about = f"scenes per indenter with {slopes} slopes; default: {default}"
        parser.add_argument(f"--{name}", type=int, default=default, metavar="N", help=about)
    parser.add_argument("--strict", action="store_true", help="a missed time limit fails too")
    options, out = command.parse(parser, argv)
    if options.preset == "quick":
        options.scenes, options.steep = 10, 5
    for name, *_ in counts:
        if getattr(options, name) < 1:
            parser.error(f"--{name} {getattr(options, name)} is no sample; give at least 1")
    parameters = Parameters(small=options.scenes, finite=options.steep)
    rows = run(parameters, command.say)
    out.table("fitted_speed.csv", parameters, *table(rows))
    out.figure("fitted_speed.png", plot(rows))
    inaccurate, slow = (sum(not getattr(row, n) for row in rows) for n in ("accurate", "fast"))
    if slow:
        command.missed(f"{slow} of {len(rows)} kinds of scenes take longer than their limit")
    ratios = [row.ratio(50) for row in rows]
    worst = max(float(max(row.worst[:3])) for row in rows)
    command.answer(
        f"{min(ratios):.2g} to {max(ratios):.2g} of one tridiagonal solve of 10⁵ unknowns (medians "
        f"of {len(rows)} kinds of scenes); a, P and U are off by {worst:.0e} at most."
    )
    return 1 if inaccurate or (options.strict and slow) else 0
