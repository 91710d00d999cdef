"""How long does one certified lattice equilibrium take, against one tridiagonal solve?

For a parabola pressed so that n nodes are in contact: time of `minimise(method="lattice")`
(contact lines, energy, force by two routes, certificate), without and with its `error_estimate`,
which is a second equilibrium with half the nodes, over the time of one LAPACK `dptsv` with n
unknowns measured right after it, medians of 7 pairs; next to the error of a and P against Eqs. (33)
and (11); peak memory in arrays of n doubles, estimate included; and the time of
`import energy, discretization` over `import numpy, scipy.linalg`, both in fresh interpreters. The
bars hold for the largest size, and with the error estimate.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import lapack

from discretization import minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from studies import command
from studies.batches import each
from studies.figures import BLUE, ORANGE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

K, GAMMA1, W, RADIUS, DEPTH = 1.3e6, 0.04, 2e-4, 0.02, 6e-6
REPEATS = 7
BARS = {"time": 1.2, "arrays": 4.0, "import": 1.5}


class Row(NamedTuple):
    """One size: seconds and ratio to dptsv without and with the error estimate, relative errors,
    peak memory in arrays of n doubles.
    """

    nodes: int
    seconds: float
    ratio: float
    seconds_estimated: float
    ratio_estimated: float
    error_half_width: float
    error_force: float
    arrays: float
    certified: bool


def median_seconds(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median wall time of calling work."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def once(work: Callable[[], object]) -> float:
    """Wall time of calling work once."""
    return median_seconds(work, 1)


def tridiagonal_seconds(n: int, repeats: int = REPEATS) -> float:
    """Median wall time of one LAPACK dptsv in place, without making its inputs."""
    times = []
    for _ in range(repeats):
        system = np.full(n, 2.1), np.full(n - 1, -1.0), np.ones(n)
        times.append(median_seconds(lambda a=system: lapack.dptsv(*a, 1, 1, 1), 1))  # type: ignore[misc]
    return statistics.median(times)


def measure(nodes: int) -> Row:
    """Time, error and memory of one equilibrium with this many nodes in contact."""
    surfaces = SurfaceEnergies.from_work(GAMMA1, W)
    scene = Scene(ElasticLayer(K * 1e-4, 0.0, 1e-4), surfaces, Parabola(RADIUS))
    material = {"k": scene.stiffness, "gamma1": GAMMA1, "w": W, "R": RADIUS}
    a = float(cards.parabola.half_width(DEPTH, **material))
    force = float(cards.parabola.force(DEPTH, **material))

    def solve():
        return minimise(scene, DEPTH, method="lattice", spacing=2 * a / nodes)

    def estimated():
        return solve().error_estimate

    state = solve()
    estimated()
    works = solve, estimated
    times = np.array([[*map(once, works), tridiagonal_seconds(nodes, 1)] for _ in range(REPEATS)])
    seconds = np.median(times[:, :2], axis=0).tolist()
    ratios = np.median(times[:, :2] / times[:, 2:], axis=0).tolist()
    tracemalloc.start()
    estimated()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return Row(
        nodes,
        seconds[0],
        ratios[0],
        seconds[1],
        ratios[1],
        abs(state.half_width / a - 1),
        abs(state.force / force - 1),
        peak / (8 * nodes),
        state.certificate.ok,
    )


def import_ratio(repeats: int = REPEATS) -> float:
    """Median time to import the package over that to import numpy and scipy.linalg."""

    def interpreter(code: str) -> Callable[[], object]:
        return lambda: subprocess.run([sys.executable, "-c", code], check=True)

    ours = interpreter("import energy, discretization")
    floor = interpreter("import numpy, scipy.linalg")
    pairs = [(median_seconds(ours, 1), median_seconds(floor, 1)) for _ in range(repeats)]
    return statistics.median(a / b for a, b in pairs)


def run(sizes: Sequence[int] = (10**3, 10**4, 10**5, 10**6)) -> list[Row]:
    """Measure each size, printing as they come."""
    print("                    alone       with estimate")
    print(f"{'nodes':>9} " + f"{'ms':>9} {'x dptsv':>8} " * 2 + "    err a     err P  arrays")
    rows = []
    for n, row in zip(sizes, each(measure, sizes, 1), strict=True):
        rows.append(row)
        print(
            f"{n:9d} {row.seconds * 1e3:9.2f} {row.ratio:8.2f} "
            f"{row.seconds_estimated * 1e3:9.2f} {row.ratio_estimated:8.2f} "
            f"{row.error_half_width:9.1e} {row.error_force:9.1e} {row.arrays:7.2f}"
            + ("" if row.certified else "  FAILED"),
            flush=True,
        )
    return rows


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; 1 if a state is not certified, with --strict also if a bar is missed."""
    parser = command.parser("lattice_speed", __doc__, "up to 10⁵ nodes", timed=True)
    parser.add_argument("--nodes", type=int, nargs="+", default=[10**3, 10**4, 10**5, 10**6])
    parser.add_argument("--strict", action="store_true", help="a missed bar fails too")
    options, out = command.parse(parser, argv)
    sizes = [10**3, 10**5] if options.preset == "quick" else options.nodes
    if min(sizes) < 100:
        parser.error(f"--nodes {min(sizes)} is too small to resolve the contact; give at least 100")
    rows = run(sizes)
    largest = rows[-1]
    given = {"nodes": sizes, "k": K, "gamma1": GAMMA1, "w": W, "R": RADIUS, "depth": DEPTH}
    out.table("lattice_speed.csv", given, Row._fields, rows)
    out.figure("lattice_speed.png", plot(rows))
    imports = import_ratio()
    results = {"time": largest.ratio_estimated, "arrays": largest.arrays, "import": imports}
    for name, value in results.items():
        verdict = "pass" if value <= BARS[name] else "FAIL"
        print(f"{name:>7}: {value:.2f} (bar {BARS[name]:g}) {verdict}")
    slow = options.strict and any(v > BARS[name] for name, v in results.items())
    return 0 if largest.certified and not slow else 1


def plot(rows: Sequence[Row]) -> Figure:
    """Time over that of dptsv with its bar, and errors, over the nodes in contact."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    nodes = [row.nodes for row in rows]
    left.loglog(nodes, [row.ratio for row in rows], "o-", color=BLUE, label="minimise")
    left.axhline(BARS["time"], color=ORANGE, ls="--", label=f"bar at 10⁶ nodes, {BARS['time']:g}")
    left.set(ylabel="time / time of one dptsv of that size")
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
    return figure
