"""How long does a 1000-step loop take, against one tridiagonal solve, and how wrong is it?

A parabola is pressed in and pulled off under imposed depth, dead load and a machine on the fitted
mesh, and under imposed depth on a lattice with 10⁵ nodes in the largest contact; wall time over
that of one LAPACK `dptsv` with 10⁵ unknowns in the same process (median of several). Next to it the
error of the loop area against energy.cards, ∮P dd, and the imbalance of the energy.

Then loops of 150 steps over a smooth rough profile with 10, 30 and 100 contacts, on the lattice
with 25 nodes per l and on the fitted mesh, in seconds of the processor; the preset --quick leaves
the fitted mesh and the largest out.

The film is thicker than springs allow beside the contact, h > l: times and errors are those of the
model, in which only k, γ₁ and w of a film enter.

Output: a line per loop, path_speed.csv. Exit status 1 if an error misses its limit, with --strict
also if a time misses 150 dptsv.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from time import process_time
from typing import Any, NamedTuple

import numpy as np

from discretization import History, load_path, minimise
from energy import ElasticLayer, Parabola, Sampled, Scene, SurfaceEnergies, cards
from studies.shared import command
from studies.shared.batches import each
from studies.shared.figures import BLUE, ORANGE, Figure, canvas
from studies.shared.table import Columns
from studies.shared.timing import middle, seconds, tridiagonal_seconds

TIME_BAR = 150.0
PER_LENGTH = 25  # nodes in an elastocapillary length
ROUGH_BARS = {"lattice": {10: 0.2, 30: 0.5, 100: 2.0}, "fitted": {10: 1.5, 30: 5.0, 100: 20.0}}
_STEPS, _DEEPEST, _FARTHEST = 75, 3.0, -2.5  # steps in and out; rms heights above the lowest point


@dataclass(frozen=True)
class Parameters:
    """Scene [SI], steps of the loop, nodes of the lattice, unknowns of dptsv, repetitions."""

    E: float = 3e3
    nu: float = 0.45
    h: float = 50e-6
    gamma1: float = 0.07
    w: float = 3e-4
    R: float = 0.1
    steps: int = 1000
    nodes: int = 10**5
    unknowns: int = 10**5
    repeats: int = 5

    @property
    def scene(self) -> Scene:
        """The scene."""
        surfaces = SurfaceEnergies.from_work(self.gamma1, self.w)
        return Scene(ElasticLayer(self.E, self.nu, self.h), surfaces, Parabola(self.R))


class Row(NamedTuple):
    """One kind of loop: time in dptsv with its interquartile range over it, error of the loop area.

    ledger: imbalance of the energy; bar: limit of the error of the area.
    """

    name: str
    ratio: float
    spread: float
    error: float
    ledger: float
    bar: float

    @property
    def accurate(self) -> bool:
        """Whether loop area and energy balance meet their limits."""
        return self.error <= self.bar and self.ledger <= 1e-9


def loops(params: Parameters) -> dict[str, tuple[dict[str, Any], float, float]]:
    """Arguments of load_path, loop area of the cards, and error limit of each loop."""
    scene, half = params.scene, params.steps // 2
    k, delta0 = scene.stiffness, scene.critical_separation
    given = {"R": params.R, "k": k, "gamma1": params.gamma1, "w": params.w}
    force = float(cards.parabola.force(3 * delta0, **given))
    stiffness = k * scene.elastocapillary_length
    depths = np.r_[np.linspace(-1, 3, half), np.linspace(3, -1.2, half)] * delta0
    forces = np.r_[np.linspace(0, force, half), np.linspace(force, -force, half)]
    far = 3 * delta0 + force / stiffness
    drives = np.r_[np.linspace(0, far, half), np.linspace(far, -far, half)]
    spacing = 2 * minimise(scene, 3 * delta0).half_width / params.nodes
    area = float(cards.displacement_control.parabola_loop_area(**given))
    dead = float(cards.load_control.parabola_loop_area(**given))
    machine = float(cards.machine_control.parabola_loop_area(**given, K=stiffness))
    return {
        "imposed depth": ({"depths": depths}, area, 1e-8),
        "dead load": ({"forces": forces}, dead, 1e-8),
        "machine": ({"drives": drives, "machine_stiffness": stiffness}, machine, 1e-8),
        f"lattice, {params.nodes:g} nodes": (
            {"depths": depths, "method": "lattice", "spacing": spacing},
            area,
            1e-3,  # the last link detaches early: first order
        ),
    }


def run(params: Parameters) -> list[Row]:
    """A row per loop."""
    return list(each(partial(measured, params), list(loops(params)), 1))


def measured(params: Parameters, name: str) -> Row:
    """Time and errors of one of the loops."""
    scene, (arguments, area, bar) = params.scene, loops(params)[name]
    path: History = load_path(scene, **arguments)
    loop = partial(load_path, scene, **arguments)
    floors = partial(tridiagonal_seconds, params.unknowns)
    ratio, spread = middle([seconds(loop) / floors() for _ in range(params.repeats)])
    error = abs(path.dissipated / area - 1)
    ledger = abs(path.work() / path.dissipated - 1)
    return Row(name, ratio, spread, error, ledger, bar)


class RoughRow(NamedTuple):
    """One loop: contacts at its deepest, events, processor time and its bar [s], energy balance."""

    method: str
    contacts: int
    events: int
    seconds: float
    bar: float
    ledger: float


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


def rough_loop(method: str, contacts: int) -> RoughRow:
    """The loop with about so many contacts, and the time of it and of `History.work()`."""
    scene, spacing = rough_scene(contacts), 1 / PER_LENGTH if method == "lattice" else None
    depths = np.r_[np.linspace(0, _DEEPEST, _STEPS), np.linspace(_DEEPEST, _FARTHEST, _STEPS)]
    start = process_time()
    path = load_path(scene, depths=depths, method=method, spacing=spacing)
    balance = abs(path.work() / path.dissipated - 1)
    elapsed = process_time() - start
    found = len(path.inner[_STEPS - 1]) // 2 + 1
    return RoughRow(method, found, len(path.events), elapsed, ROUGH_BARS[method][contacts], balance)


def rough_line(row: RoughRow) -> str:
    """A line for a loop."""
    word = "ok" if row.ledger <= 1e-9 else "MISSED"
    return (
        f"{row.method:8s} {row.contacts:4d} contacts {row.events:4d} events "
        f"{row.seconds:7.2f} s (bar {row.bar:g} s)  balance {row.ledger:.0e} {word}"
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    parser = command.parser("path_speed", __doc__, "100 steps, 10⁴ nodes")
    parser.add_argument("--strict", action="store_true", help="judge the times too")
    options, out = command.parse(parser, argv)
    quick = options.preset == "quick"
    params = Parameters(steps=100, nodes=10**4, repeats=3) if quick else Parameters()
    rows = run(params)
    shown = Columns(
        f"{params.steps} steps -24|dptsv({params.unknowns:.0e}) 14.1f|± 5.0%|"
        "error of the area 18.1e|balance 7.1e| 6"
    )
    print(shown.head)
    for row in rows:
        word = "ok" if row.accurate else "MISSED"
        print(shown.line(row.name, row.ratio, row.spread / 2, row.error, row.ledger, word))
    methods, sizes = (("lattice",), (10, 30)) if quick else (("lattice", "fitted"), (10, 30, 100))
    rough = [rough_loop(method, size) for method in methods for size in sizes]
    print("\n".join(map(rough_line, rough)))
    out.table("path_speed_rough.csv", params, RoughRow._fields, rough)
    out.table("path_speed.csv", params, Row._fields, rows)
    out.figure("path_speed.png", plot(rows, params))
    slow = [row.name for row in rows if row.ratio > TIME_BAR]
    if slow:
        command.missed(f"more than {TIME_BAR:g} tridiagonal solves: {', '.join(slow)}")
    ratios, worst = [row.ratio for row in rows], max(row.ledger for row in rows)
    command.answer(
        f"A loop of {params.steps} steps takes {min(ratios):.3g} to {max(ratios):.3g} tridiagonal "
        f"solves of {params.unknowns:.0e} unknowns; its energy balance closes within {worst:.0e}."
    )
    return 0 if all(row.accurate for row in rows) and not (options.strict and slow) else 1


def plot(rows: Sequence[Row], params: Parameters) -> Figure:
    """Time of each loop, with its limit, beside the errors of loop area and energy balance."""
    figure, (left, right) = canvas(11, 3.6, 1, 2, sharey=True)
    at, names = np.arange(len(rows)), [row.name for row in rows]
    spread = [row.ratio * row.spread / 2 for row in rows]
    left.barh(at, [row.ratio for row in rows], color=BLUE, height=0.6, xerr=spread, capsize=3)
    left.axvline(TIME_BAR, color=ORANGE, ls="--", label=f"limit of 1000 steps, {TIME_BAR:g}")
    unit = f"time of {params.steps} steps / time of one dptsv, n = {params.unknowns:g}"
    left.set(xlabel=unit, yticks=at, yticklabels=names)
    left.invert_yaxis()
    least = np.finfo(float).eps
    for name, marker, colour in (("error", "o", BLUE), ("ledger", "s", ORANGE)):
        values = [max(getattr(row, name), least) for row in rows]
        label = "loop area against its closed form" if name == "error" else "∮P dd against losses"
        right.semilogx(values, at, marker, color=colour, label=label)
    right.set(xlabel=f"relative error (below {least:.0e} drawn there)", xlim=(least / 3, 1))
    for axes in (left, right):
        axes.grid(alpha=0.25, axis="x")
        axes.set_axisbelow(True)
        axes.legend(fontsize=8, loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    slowest = max(row.ratio for row in rows)
    figure.suptitle(
        f"A loop of {params.steps} steps costs at most {slowest:.3g} tridiagonal solves"
    )
    return figure
