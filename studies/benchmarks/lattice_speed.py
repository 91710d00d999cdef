"""How long does one certified lattice equilibrium take, against one tridiagonal solve?

For a parabola pressed so that n nodes are in contact: time of `minimise(method="lattice")`
(contact lines, energy, force by two routes, certificate), without and with its `error_estimate`,
which is a second equilibrium with half the nodes, over the time of one LAPACK `dptsv` with n
unknowns measured right after it, medians of 7 pairs; next to the error of a and P against Eqs. (33)
and (11); peak memory in arrays of n doubles, estimate included; and the time of
`import energy, discretization` over `import numpy, scipy.linalg`, both in fresh interpreters. The
limits hold for the largest size, and with the error estimate.

Times and errors are those of the model, in which only k, γ₁ and w of a film enter; h is arbitrary.
"""

import statistics
import tracemalloc
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from discretization import minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from studies.shared import command
from studies.shared.batches import each
from studies.shared.figures import BLUE, GREEN, ORANGE, Figure, canvas
from studies.shared.table import Columns
from studies.shared.timing import interpreter_seconds, middle, seconds, tridiagonal_seconds

K, GAMMA1, W, RADIUS, DEPTH = 1.3e6, 0.04, 2e-4, 0.02, 6e-6
REPEATS = 7
SIZES = (10**3, 10**4, 10**5, 10**6)
BARS = {"time": 1.2, "arrays": 4.0, "import": 1.5}


class Row(NamedTuple):
    """One size: seconds, ratio to dptsv and its spread without and with the error estimate.

    spread: interquartile range over the median; arrays: peak memory in arrays of n doubles.
    """

    nodes: int
    seconds: float
    ratio: float
    spread: float
    seconds_estimated: float
    ratio_estimated: float
    spread_estimated: float
    error_half_width: float
    error_force: float
    arrays: float
    certified: bool


def measure(nodes: int) -> Row:
    """Time, error and memory of one equilibrium with this many nodes in contact."""
    surfaces = SurfaceEnergies.from_work(GAMMA1, W)
    scene = Scene(ElasticLayer(K * 1e-4, 0.0, 1e-4), surfaces, Parabola(RADIUS))
    material = {"k": scene.stiffness, "gamma1": GAMMA1, "w": W, "R": RADIUS}
    a = float(cards.parabola.half_width(DEPTH, **material))
    force = float(cards.parabola.force(DEPTH, **material))

    solve = partial(minimise, scene, DEPTH, method="lattice", spacing=2 * a / nodes)
    works: tuple[Callable[[], object], ...] = solve, lambda: solve().error_estimate
    state, _ = solve(), works[1]()
    runs = [[*map(seconds, works), tridiagonal_seconds(nodes, 1)] for _ in range(REPEATS)]
    *times, floor = np.transpose(runs)
    alone, estimate = ((float(np.median(own)), *middle(own / floor)) for own in times)
    tracemalloc.start()
    works[1]()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    errors = abs(state.half_width / a - 1), abs(state.force / force - 1)
    return Row(nodes, *alone, *estimate, *errors, peak / (8 * nodes), state.certificate.ok)


COLUMNS = Columns(
    "nodes 9|alone ms 9.2f|× dptsv 8.2f|± 5.0%|estimated ms 13.2f|× dptsv 8.2f|± 5.0%|err a 8.1e|"
    "err P 8.1e|arrays 7.2f"
)


def run(sizes: Sequence[int] = SIZES) -> list[Row]:
    """Measure each size, printing as they come."""
    command.say(COLUMNS.head)
    return list(each(measure, sizes, 1, say=lambda row: command.say(line(row))))


def line(row: Row) -> str:
    """One line of the table; ±: half the interquartile range."""
    alone, estimated = ((1e3 * time, ratio, s / 2) for time, ratio, s in (row[1:4], row[4:7]))
    errors = row.error_half_width, row.error_force, row.arrays
    told = COLUMNS.line(row.nodes, *alone, *estimated, *errors)
    return told + ("" if row.certified else "  FAILED")


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; 1 if a state is not certified, with --strict also if a limit is missed."""
    parser = command.parser("lattice_speed", __doc__, "up to 10⁵ nodes")
    about = f"in contact; default: {' '.join(map(str, SIZES))}"
    parser.add_argument("--nodes", type=int, nargs="+", default=SIZES, metavar="N", help=about)
    parser.add_argument("--strict", action="store_true", help="a missed limit fails too")
    options, out = command.parse(parser, argv)
    sizes = [10**3, 10**5] if options.preset == "quick" else options.nodes
    if min(sizes) < 100:
        parser.error(f"--nodes {min(sizes)} is too small to resolve the contact; give at least 100")
    rows = run(sizes)
    largest = rows[-1]
    given = {"nodes": sizes, "k": K, "gamma1": GAMMA1, "w": W, "R": RADIUS, "depth": DEPTH}
    out.table("lattice_speed.csv", given, Row._fields, rows)
    out.figure("lattice_speed.png", plot(rows))
    codes = "import energy, discretization", "import numpy, scipy.linalg"
    pairs = [[*map(interpreter_seconds, codes)] for _ in range(REPEATS)]
    imports = statistics.median(ours / floor for ours, floor in pairs)
    results = {"time": largest.ratio_estimated, "arrays": largest.arrays, "import": imports}
    for name, value in results.items():
        told = f"{name}: {value:.2f} (limit {BARS[name]:g})"
        print(told) if value <= BARS[name] else command.missed(told)
    command.answer(
        f"{largest.ratio:.3g} of one tridiagonal solve with {largest.nodes:.0e} nodes in contact, "
        f"{largest.ratio_estimated:.3g} with its error estimate."
    )
    slow = options.strict and any(v > BARS[name] for name, v in results.items())
    return 0 if largest.certified and not slow else 1


def plot(rows: Sequence[Row]) -> Figure:
    """Time over that of dptsv with its limit, and errors, over the nodes in contact."""
    figure, (left, right) = canvas(11, 4, 1, 2)
    nodes = [row.nodes for row in rows]
    for end, fmt, colour, label in (
        ("", "o-", BLUE, "minimise"),
        ("_estimated", "s-", GREEN, "with its error estimate"),
    ):
        ratio = np.array([getattr(row, f"ratio{end}") for row in rows])
        half = ratio * [getattr(row, f"spread{end}") / 2 for row in rows]
        left.errorbar(nodes, ratio, half, fmt=fmt, color=colour, label=label, capsize=3)
    told = f"limit with estimate, 10⁶ nodes: {BARS['time']:g}"
    left.axhline(BARS["time"], color=ORANGE, ls="--", label=told)
    left.set(xscale="log", yscale="log", ylabel="time / time of one dptsv of that size")
    for name, marker, colour, label in (
        ("error_half_width", "o", BLUE, "half-width, Eq. (33)"),
        ("error_force", "s", ORANGE, "force, Eq. (11)"),
    ):
        errors = [getattr(row, name) for row in rows]
        right.loglog(nodes, errors, f"{marker}-", color=colour, label=label)
    right.set(ylabel="relative error")
    for axes in (left, right):
        axes.set_xlabel("nodes in contact")
        axes.grid(alpha=0.25)
        axes.legend(fontsize=9)
    last = rows[-1]
    figure.suptitle(
        f"A certified state with {last.nodes:.0e} nodes takes {last.ratio:.3g} tridiagonal solves"
    )
    return figure
