"""How long does an answer take, against one tridiagonal solve, and how wrong is it?

| row         | what is timed                                                     | its error      |
| ----------- | ----------------------------------------------------------------- | -------------- |
| state       | `minimise` with its defaults, of random scenes of every indenter  | a, P, U, θ     |
| nodes       | `minimise(method="lattice")` and its `error_estimate`             | a, P           |
| loop        | `load_path` in and out: depth, dead load, machine, depth on nodes | area, balance  |
| rough       | `load_path` over some, many contacts, and its `work()`            | balance        |
| import      | `import energy, discretization` over `import numpy, scipy.linalg` |                |

Times are medians over that of one LAPACK `dptsv` measured right after, with 10⁵ unknowns, or as
many as there are nodes; of the random states, each of which is new and solved once, the 95th
percentile. Errors are relative and against energy.cards: |a - a*|/a*, |P - P*|/ΣP and |U - U*|/ΣU
with ΣP and ΣU the sums of the terms' absolute values (a force may pass through zero), |θ - θ*| in
rad, the area of a loop, and ∮P dd against the energy released.

Output: a line per row, speed.csv, speed.png. Exit status 1 if an error misses its limit, with
--strict also if a time does: machines may be shared.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from discretization import load_path, minimise
from energy import ElasticLayer, Parabola, Sampled, Scene, SurfaceEnergies, cards
from studies.shared import command, timing
from studies.shared.batches import Show, each, silent
from studies.shared.figures import BLUE, ORANGE, Figure, canvas
from studies.shared.random_cases import SHAPES, Case, random_case, random_steep_case
from studies.shared.table import Columns
from studies.shared.timing import interpreter_seconds, middle, seconds, tridiagonal_seconds

UNKNOWNS = 10**5  # of the dptsv where there are no nodes
STATE = {"small": (1.0, 1e-10), "finite": (10.0, 1e-9)}  # limits of time and of error
NODES, LOOP, IMPORT = (1.2, 1e-5), (150.0, 1e-8), (1.5, math.inf)
LAST_LINK = 1e-3  # of the area of a loop on nodes, whose last link detaches early
ROUGH = {"lattice": {10: 200.0, 30: 500.0, 100: 2e3}, "fitted": {10: 1.5e3, 30: 5e3, 100: 2e4}}
BALANCE = 1e-9
PER_LENGTH = 25  # nodes in an elastocapillary length of a rough profile
LAYER, GAMMA1, W, RADIUS = ElasticLayer(3e3, 0.45, 50e-6), 0.07, 3e-4, 0.1  # Pa, m, N/m


@dataclass(frozen=True)
class Parameters:
    """Scenes of each indenter, nodes, steps of a loop and its nodes, contacts, pairs of times."""

    scenes: int = 60
    nodes: tuple[int, ...] = (10**5, 10**6)
    steps: int = 1000
    loop_nodes: int = 10**5
    contacts: tuple[tuple[str, int], ...] = tuple((m, n) for m in ROUGH for n in ROUGH[m])
    repeats: int = 7
    imports: int = 7
    seed: int = 1


QUICK = Parameters(5, (10**5,), 100, 10**4, (("lattice", 10),), 3, 0)


class Row(NamedTuple):
    """What was timed: seconds, over those of the floor, with its spread; its error; both limits.

    spread: interquartile range over the median.
    """

    name: str
    seconds: float
    ratio: float
    spread: float
    limit: float
    error: float
    allowed: float

    @property
    def accurate(self) -> bool:
        """Whether the error is within its limit; nan is not."""
        return self.error <= self.allowed

    @property
    def fast(self) -> bool:
        """Whether the time is within its limit."""
        return self.ratio <= self.limit


Times = tuple[float, float, float]


def paired(work: Callable[[], object], floor: Callable[[], float], repeats: int) -> Times:
    """Median time, its ratio to the floor measured right after it, and the spread of that."""
    pairs = [(seconds(work), floor()) for _ in range(repeats)]
    ratio, spread = middle([one / other for one, other in pairs])
    return float(np.median(pairs, axis=0)[0]), ratio, spread


def states(slopes: str, p: Parameters) -> Row:
    """Random scenes, each solved once, after one of each indenter that is not timed."""
    draw = random_case if slopes == "small" else random_steep_case
    rng, limit = np.random.default_rng([p.seed, len(slopes)]), STATE[slopes]
    times, errors = [], []
    for number in range(p.scenes + 1):
        for shape in SHAPES:
            took, error = solved(draw(rng, shape))
            errors.append(error)
            times += [(took, tridiagonal_seconds(UNKNOWNS, 1))] if number else []
    took, floor = np.transpose(times)
    _, spread = middle(took)
    ratio = float(np.percentile(took, 95) / np.median(floor))
    name = f"state, {slopes} slopes"
    return Row(name, float(np.median(took)), ratio, spread, limit[0], max(errors), limit[1])


def solved(case: Case) -> tuple[float, float]:
    """Time of one state, and the largest of its errors; infinite where there is no answer."""
    start = time.perf_counter()
    try:
        state = minimise(case.scene, case.depth)
    except (ValueError, ArithmeticError, RuntimeError):
        return math.inf, math.inf
    took, law = time.perf_counter() - start, case.angle_deficit
    turned = 0.0 if math.isnan(law) else abs(state.angle_deficit - law)
    errors = *case.errors(state, case.half_width), math.inf if math.isnan(turned) else turned
    return took, max(errors)


def scene() -> Scene:
    """The parabola of nodes and loops."""
    return Scene(LAYER, SurfaceEnergies.from_work(GAMMA1, W), Parabola(RADIUS))


def nodes(count: int, p: Parameters) -> Row:
    """A state with so many nodes in contact, and its error estimate."""
    own, given = scene(), {"R": RADIUS, "k": LAYER.stiffness, "gamma1": GAMMA1, "w": W}
    depth = 3 * own.critical_separation
    card = cards.parabola
    a, force = float(card.half_width(depth, **given)), float(card.force(depth, **given))
    solve = partial(minimise, own, depth, method="lattice", spacing=2 * a / count)
    state = solve()
    error = max(abs(state.half_width / a - 1), abs(state.force / force - 1))
    times = paired(lambda: solve().error_estimate, lambda: tridiagonal_seconds(count, 1), p.repeats)
    return Row(f"nodes, {count:.0e}", *times, NODES[0], error, NODES[1])


def loops(p: Parameters) -> dict[str, tuple[dict[str, Any], float]]:
    """Arguments of load_path and the loop area of the cards, of each loop."""
    own, half = scene(), p.steps // 2
    delta0, given = own.critical_separation, {"k": LAYER.stiffness, "gamma1": GAMMA1, "w": W}
    force = float(cards.parabola.force(3 * delta0, R=RADIUS, **given))
    stiffness = own.stiffness * own.elastocapillary_length
    far = 3 * delta0 + force / stiffness
    spacing = 2 * minimise(own, 3 * delta0).half_width / p.loop_nodes

    def through(first: float, top: float, last: float) -> Any:
        return np.r_[np.linspace(first, top, half), np.linspace(top, last, half)]

    controls = cards.displacement_control, cards.load_control, cards.machine_control
    depth, load, machine = (partial(c.parabola_loop_area, R=RADIUS, **given) for c in controls)
    depths = {"depths": through(-delta0, 3 * delta0, -1.2 * delta0)}
    drives = {"drives": through(0, far, -far), "machine_stiffness": stiffness}
    return {
        "loop, depth": (depths, float(depth())),
        "loop, dead load": ({"forces": through(0, force, -force)}, float(load())),
        "loop, machine": (drives, float(machine(K=stiffness))),
        "loop, nodes": (depths | {"method": "lattice", "spacing": spacing}, float(depth())),
    }


def loop(name: str, p: Parameters) -> Row:
    """One of the loops; its error: that of the area, and ten times that of the balance."""
    arguments, area = loops(p)[name]
    work = partial(load_path, scene(), **arguments)
    path = work()
    balance = abs(path.work() / path.dissipated - 1)
    error = max(abs(path.dissipated / area - 1), balance * LOOP[1] / BALANCE)
    allowed = LAST_LINK if "spacing" in arguments else LOOP[1]
    times = paired(work, lambda: tridiagonal_seconds(UNKNOWNS, 1), p.repeats)
    return Row(name, *times, LOOP[0], error, allowed)


def rough_scene(contacts: int, seed: int = 1) -> Scene:
    """A scene with l = 1 and about so many contacts.

    Waves between 3 l and 12 l long of random phases, in a trough whose walls end the profile.
    """
    half, rng = 4.0 * contacts + 20, np.random.default_rng(seed)
    x = np.arange(-round(half * PER_LENGTH), round(half * PER_LENGTH) + 1) / PER_LENGTH
    z = np.zeros_like(x)
    for wave in np.linspace(3, 12, 30):
        z += wave * np.cos(2 * math.pi * x / wave + rng.uniform(0, 2 * math.pi))
    z = z / z.std() + 0.3 * np.maximum(np.abs(x) - half + 15, 0) ** 2
    layer, surfaces = ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work(1.0, 0.3)
    return Scene(layer, surfaces, Sampled(x, z - z.min(), kind="smooth"))


def rough(which: tuple[str, int], p: Parameters) -> Row:
    """A loop of 150 steps over a rough profile, and its external work; followed once."""
    (method, contacts), found = which, []
    own = rough_scene(contacts)
    spacing = 1 / PER_LENGTH if method == "lattice" else None
    depths = np.r_[np.linspace(0, 3, 75), np.linspace(3, -2.5, 75)]  # of the rms height

    def follow() -> None:
        path = load_path(own, depths=depths, method=method, spacing=spacing)
        found.append(abs(path.work() / path.dissipated - 1))

    took, ratio, _ = paired(follow, lambda: tridiagonal_seconds(UNKNOWNS), 1)
    name = f"rough, {contacts} contacts, {method}"
    return Row(name, took, ratio, math.nan, ROUGH[method][contacts], found[-1], BALANCE)


def imports(p: Parameters) -> Row:
    """Imports in fresh interpreters."""
    ours, floor = "import energy, discretization", "import numpy, scipy.linalg"
    work = partial(interpreter_seconds, ours)
    times = paired(work, lambda: interpreter_seconds(floor), p.imports)
    return Row("import", *times, IMPORT[0], 0.0, IMPORT[1])


def run(p: Parameters = Parameters(), show: Show = silent) -> list[Row]:
    """All rows; `show` gets a line for each."""
    measures: list[Callable[[Parameters], Row]] = [
        *(partial(states, slopes) for slopes in STATE),
        *(partial(nodes, count) for count in p.nodes),
        *(partial(loop, name) for name in loops(p)),
        *(partial(rough, which) for which in p.contacts),
        *[imports][: p.imports],
    ]
    show(COLUMNS.head)
    return list(each(lambda one: one(p), measures, 1, say=lambda row: show(line(row))))


COLUMNS = Columns(
    "what is timed -30|s 9.3g|× floor 9.3g|± 5.0%|limit 8.4g|error 8.0e|limit 7.0e| -6| -4"
)


def line(row: Row) -> str:
    """One line of the table; ±: half the interquartile range."""
    told = "" if row.fast else "SLOW", "" if row.accurate else "FAIL"
    given = row.seconds, row.ratio, row.spread / 2, row.limit, row.error, row.allowed
    return COLUMNS.line(row.name, *given, *told)


def plot(rows: Sequence[Row]) -> Figure:
    """Time over its limit, and error beside its limit, of each row."""
    figure, (left, right) = canvas(12, 1.6 + 0.34 * len(rows), 1, 2, sharey=True)
    at = np.arange(len(rows))
    times = np.array([row.ratio / row.limit for row in rows])
    spread = times * np.nan_to_num([row.spread / 2 for row in rows])
    beside = np.minimum(spread, times), spread
    left.barh(at, times, color=BLUE, height=0.6, xerr=beside, capsize=3)
    for height, end, row in zip(at, times + spread, rows, strict=True):
        left.text(end, height, f" × {row.ratio:.3g}", va="center", fontsize=9)
    left.set(xlabel="time over its limit (×: over that of one tridiagonal solve)", yticks=at)
    left.set_yticklabels([row.name for row in rows])
    left.set_xlim(0, 1.25 * max(1.0, float((times + spread).max())))
    left.axvline(1, color=ORANGE, ls="--")
    left.invert_yaxis()
    judged = [(height, row) for height, row in enumerate(rows) if row.allowed < math.inf]
    heights = [height for height, _ in judged]
    errors = [max(row.error, 1e-17) for _, row in judged]
    right.semilogx(errors, heights, "o", color=BLUE, label="largest error")
    limits = [row.allowed for _, row in judged]
    right.semilogx(limits, heights, "|", ms=12, color=ORANGE, label="its limit")
    right.set(xlabel="relative error, of θ in rad (below 1e-17: drawn there)", xlim=(1e-18, 1))
    right.legend(fontsize=9)
    for axes in (left, right):
        axes.grid(alpha=0.25, axis="x")
        axes.set_axisbelow(True)
    accurate, fast = (sum(getattr(row, name) for row in rows) for name in ("accurate", "fast"))
    figure.suptitle(
        f"Of {len(rows)} answers {accurate} keep their limit of error, {fast} that of time"
    )
    return figure


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; 1 if an error limit is missed, with --strict also for a time limit."""
    parser = command.parser("speed", __doc__, "few scenes, 100 steps, 10 contacts")
    parser.add_argument("--strict", action="store_true", help="a missed time limit fails too")
    options, out = command.parse(parser, argv)
    p = QUICK if options.preset == "quick" else Parameters()
    found = run(p, command.say)
    out.table("speed.csv", p, Row._fields, found)
    out.figure("speed.png", plot(found))
    slow = [row.name for row in found if not row.fast]
    if slow:
        command.missed(f"longer than its limit: {', '.join(slow)}")
    ratios = [row.ratio for row in found if row.name.startswith("loop")]
    command.answer(
        f"95 of 100 states take less than {found[0].ratio:.2g} of one tridiagonal solve of 10⁵ "
        f"unknowns, a loop of {p.steps} steps {min(ratios):.3g} to {max(ratios):.3g} (BLAS: "
        f"{timing.blas_threads()})."
    )
    return 1 if not all(row.accurate for row in found) or (options.strict and slow) else 0
