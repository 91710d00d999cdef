"""What does a real layer change: the angle, Eq. (16), a sphere's pull-off? Where do springs serve?

Springs are the limit q → 0 of the stiffness k(q) of a bonded elastic layer with ν < ½. It is asked:

- Is the contact angle π - θ = √(2w/γ₁) whatever ν and h? It is measured on nodes and extrapolated.
- Which length stands in Eq. (16), f(a) + ℓ f'(a) + ... = d + δ₀, of a wide contact? Measured from
  two states of the fitted side, next to ℓ = (1/π) ∫ ln[(k(q) + γ₁q²)/k] dq/q².
- Is a sphere pulled off by 3/2 πwR (half-space), 2 (thin, ν < ½), 3 (ν = ½), 1 (tension dominates)?
- How far off are springs in force and radius at pull-off of a sphere, at the worst Λ = l/√(Rδ₀)?
  `energy/validity.py` has the numbers of layer_springs_worst.csv.
- What does a state cost? layer_accuracy.csv: errors and times for three rtol, and over springs.

Output: four figures and tables. Exit status 1: an angle is off by over 1 %, or a length by 1e-4 h.
"""

import math
import statistics
import time
import timeit
from collections import namedtuple
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby, product, takewhile
from typing import Any

from discretization import load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import COLOURS, GREY, LINE, MARKERS, Figure, canvas, plain_ticks
from studies.shared.loops import arguments

layer_of = partial(ElasticLayer, 1.0, h=1.0, response="layer")  # of this Poisson's ratio
GENTLE = 1e-6  # w/γ₁, which only sets the scale of displacements; units: h = E = 1
SLOPE = math.sqrt(2 * GENTLE)  # at the line
DEPTHS = [SLOPE * part / 10 for part in range(-1, 10)]
RTOL = 1e-4
FINE = 1e-7
EXACT = 1e-10
WIDE = 15.0  # half-width in h from which Eq. (16) is read
WEAK = 1e-3
STRONG = 1e2  # γ₁ over the least and the most that can withstand it
TENSIONS = {"weak": "γ₁ = 10⁻³ E min(a, h)", "strong": "γ₁ = 100 E a max(a/h, 1)"}
BEYOND = 3.3  # of πwR: no sphere bears as much
LIMITS = {
    1: "tension dominates",
    1.5: "half-space, γ₁ = 0 (JKR)",
    2: "thin, ν < ½",
    3: "thin, ν = ½",
}  # F/πwR
LAMBDAS = (0.05, 0.1, 0.15, 0.25, 0.4, 0.6, 1.0, 2.5)  # among them the worst for springs
LARGEST = (1e-2, 1e-4)  # errors of angles, relative, and of lengths, over h

# The rows of the tables: lengths over h, angles over √(2w/γ₁), thickness over √(γ₁h/G), forces of
# pull-off over πwR; of springs, what they put too high; of accuracy, the largest errors.
Angle = namedtuple("Angle", "nu thickness measured error")
Length = namedtuple("Length", "nu ratio measured effective")
Pull = namedtuple("Pull", "nu tension radius force")
Springs = namedtuple("Springs", "nu ratio Lambda force radius")
Accuracy = namedtuple("Accuracy", "geometry rtol half_width force milliseconds over_springs")
Record = dict[str, list[Any]]  # rows of each question
Parameters = dict[str, tuple[tuple[Any, ...], ...]]  # values that the cases of a question combine

FULL: Parameters = {
    "angle": ((0.0, 0.3, 0.45, 0.5), (0.3, 0.55, 1.0, 1.7, 3.0), (40,)),
    "length": ((0.0, 0.3, 0.4, 0.45), (0.05, 0.15, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0)),
    "weak": ((0.3, 0.45, 0.49, 0.5), (0.03, 0.1, 0.3, 0.6, 1, 1.7, 3, 6, 12, 30, 100), ("weak",)),
    "strong": ((0.3,), (0.03, 0.3, 3, 30, 100), ("strong",)),
    "springs": ((0.0, 0.3, 0.4, 0.45, 0.48, 0.49), (0.25, 0.5, 1.0, 2.0, 4.0, 8.0), LAMBDAS),
    "accuracy": (("line", "axisymmetric"), (1e-4, 1e-6, 1e-8)),
}
QUICK: Parameters = FULL | {
    "angle": ((0.3, 0.5), (0.3, 1.0), (24,)),
    "length": ((0.3, 0.45), (0.3, 1.0)),
    "weak": ((0.3, 0.5), (0.03, 1, 30), ("weak",)),
    "strong": ((0.3,), (0.1,), ("strong",)),
    "springs": ((0.45,), (0.5, 2.0), (0.15, 1.0)),
    "accuracy": (("line",), (1e-4, 1e-6)),
}


def scene_of(nu: float, gamma1: float, R: float, geometry: str = "axisymmetric") -> Scene:
    """A parabola, or the sphere it is about an axis, on the layer."""
    surfaces = SurfaceEnergies.from_work(gamma1, GENTLE * gamma1)
    return Scene(layer_of(nu), surfaces, Parabola(R), geometry=geometry)


def angle(case: tuple[float, float, int]) -> Angle:
    """ν, thickness, and nodes on each side of a cylinder that is about as wide as h."""
    nu, thickness, nodes = case
    scene = scene_of(nu, 1 / (2 * (1 + nu) * thickness**2), 1 / SLOPE, "line")
    a = minimise(scene, SLOPE, rtol=RTOL).half_width
    states = (minimise(scene, SLOPE, method="lattice", spacing=a * n / nodes) for n in (4, 2, 1))
    first, second, third = (state.angle_deficit / SLOPE for state in states)
    before = 2 * second - first
    last = 2 * third - second
    return Angle(nu, thickness, last, abs(last - before))


def length(case: tuple[float, float]) -> Length:
    """ν and l/h: a cylinder moved between two depths, L = R Δd/Δa - a."""
    nu, ratio = case
    R = WIDE**2 / SLOPE
    d = SLOPE / 2
    scene = scene_of(nu, layer_of(nu).stiffness * ratio**2, R, "line")
    narrow, wide = (minimise(scene, depth, rtol=FINE).half_width for depth in (d, 2 * d))
    return Length(*case, R * d / (wide - narrow) - (wide + narrow) / 2, scene.effective_length)


def pull(case: tuple[float, float, str]) -> Pull:
    """ν, about which a/h, and tension: there a = R √(w/2γ₁) if strong, else wR²/(Eh³) is known."""
    nu, about, tension = case
    gamma1 = STRONG * about * max(about, 1.0)
    R = 2 * about / SLOPE
    if tension == "weak":  # of the half-space and the thin layer in sum
        gamma1 = WEAK * min(about, 1.0)
        thin = min(about**6 / 288, about**4 * layer_of(nu).modulus / 8)
        R = math.sqrt((about**3 / 3 + thin) / (GENTLE * gamma1))
    off, unit = pulled(scene_of(nu, gamma1, R))
    return Pull(nu, tension, off.half_width, -off.force / unit)


def pulled(scene: Scene) -> tuple[Any, float]:
    """The state with the largest pull that a sphere bears under a dead load, and πwR."""
    unit = math.pi * scene.work_of_adhesion * arguments(scene)["R"]
    return load_path(scene, forces=[0.0, -BEYOND * unit], rtol=RTOL).pull_off, unit


def springs(case: tuple[float, float, float]) -> Springs:
    """ν, l/h and Λ = l/√(Rδ₀) of a sphere that is pulled off."""
    nu, ratio, Lambda = case
    scene = scene_of(nu, layer_of(nu).stiffness * ratio**2, ratio / (SLOPE * Lambda**2))
    (off, _), card = pulled(scene), cards.axisymmetric.sphere.pull_off(**arguments(scene))
    force = card.force / off.force
    radius = card.half_width / off.half_width
    return Springs(*case, float(force) - 1, float(radius) - 1)


def accuracy(case: tuple[str, float]) -> Accuracy:
    """Geometry and rtol: a cylinder or sphere at a few depths, medians of their times."""
    geometry, rtol = case
    scene = scene_of(0.45, 0.3, 1 / SLOPE, geometry)
    springs = replace(scene, layer=replace(scene.layer, response="springs"))
    pairs = [[minimise(scene, depth, rtol=one) for one in (rtol, EXACT)] for depth in DEPTHS]
    width = max(abs(one.half_width - exact.half_width) / exact.half_width for one, exact in pairs)
    force = max(abs(one.force - exact.force) / exact.scales["force"] for one, exact in pairs)
    own, other = (statistics.median(timed(s, d, rtol) for d in DEPTHS) for s in (scene, springs))
    return Accuracy(*case, width, force, 1e3 * own, own / other)


def timed(scene: Scene, depth: float, rtol: float) -> float:
    """Processor time of a state with its error estimate [s], the least of three."""
    solve = partial(minimise, scene, depth, rtol=rtol)
    return min(timeit.repeat(lambda: solve().error_estimate, time.process_time, repeat=3, number=1))


MEASURES: dict[str, Callable[[Any], Any]] = {"weak": pull, "strong": pull}
MEASURES |= {"angle": angle, "length": length, "springs": springs, "accuracy": accuracy}


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> Record:
    """Every case, in `jobs` processes, of times in one; `show` gets a line for each."""

    def tell(row: Any) -> None:
        values = zip(row._fields, row, strict=True)
        cells = (f"{n} = {x:.5g}" if isinstance(x, float) else f"{n} = {x}" for n, x in values)
        show(f"{type(row).__name__.lower():9s} {', '.join(cells)}")

    rows: Record = {}
    for name, axes in parameters.items():
        workers = 1 if name == "accuracy" else jobs  # others would disturb the times
        rows[name] = list(each(MEASURES[name], list(product(*axes)), workers, say=tell))
    return rows | {"springs_worst": [worst(own) for own in grouped(rows["springs"], 2)]}


def grouped(rows: Iterable[Any], columns: int = 1) -> list[list[Any]]:
    """Rows that follow one another with the same first columns, by default the same ν."""
    return [list(own) for _, own in groupby(rows, lambda row: row[:columns])]


def worst(rows: Sequence[Springs]) -> Springs:
    """The largest errors of these, without sign; Λ is that of the radius."""
    most = max(rows, key=lambda row: abs(row.radius))
    return most._replace(force=max(abs(row.force) for row in rows), radius=abs(most.radius))


def errors(record: Record) -> tuple[float, float]:
    """The largest of angles, relative, and of lengths, over h."""
    lengths = max(abs(row.measured - row.effective) for row in record["length"])
    return max(abs(row.measured - 1) for row in record["angle"]), lengths


def answers(record: Record) -> dict[str, str]:
    """What each figure says; springs serve from the last l/h with 5 % at most, from above."""
    (angle, length), weak, strong = errors(record), record["weak"], record["strong"][0]
    narrow = min(weak, key=lambda row: row.radius)
    most = max(weak, key=lambda row: row.force)
    served = []
    for own in grouped(record["springs_worst"]):
        good = takewhile(lambda row: max(row.force, row.radius) <= 0.05, reversed(own))
        served += [f"{row.ratio:g} (ν = {row.nu:g})" for row in list(good)[-1:]]
    return {
        "angle": f"The angle stays √(2w/γ₁) whatever ν and h, within {100 * angle:.1g} % on nodes",
        "length": f"Eq. (16) holds with ℓ in place of l, within {length:.0e} h",
        "pull": f"A sphere sticks with {narrow.force:.3g} πwR if h ≫ a (JKR: 1.5, γ₁ = 0), "
        f"{most.force:.3g} at ν = {most.nu:g}, a = {most.radius:.2g} h, {strong.force:.3g} where "
        "tension dominates",
        "springs": f"Springs serve within 5 % from l/h = {', '.join(served)} on",
    }


def draw(axes: Any, rows: Iterable[Any], x: str, y: str, label: str = "", **look: Any) -> None:
    """y over x of each ν, with its error if there is any."""
    for own, colour, marker in zip(grouped(rows), COLOURS, MARKERS, strict=False):
        values = ([getattr(row, name) for row in own] for name in (x, y))
        error = [row.error for row in own] if isinstance(own[0], Angle) else None
        style = {"color": colour, "marker": marker, "ms": 5, "capsize": 3, **look}
        axes.errorbar(*values, error, label=f"{label}ν = {own[0].nu:g}", **style)
    if axes.get_xscale() == "log":
        plain_ticks(axes.xaxis, steps=(1.0, 2.0, 3.0, 5.0))
    axes.legend(fontsize=9)


def plot(record: Record) -> dict[str, Figure]:
    """The four figures by file name, each with its answer above it."""
    figures = {}
    level = {"color": GREY, "lw": 0.8, "ls": ":"}
    figures["angle"], axes = canvas(7.5, 4.8)
    axes.set(xscale="log", xlim=(0.25, 3.6), ylim=(0.97, 1.03))
    axes.set(xlabel="thickness of the layer  h / √(γ₁h/G)", ylabel="angle  (π − θ) / √(2w/γ₁)")
    axes.axhline(1, label="√(2w/γ₁)", **LINE)
    draw(axes, record["angle"], "thickness", "measured", "nodes, ", ls="", mfc="none")
    figures["length"], axes = canvas(7.5, 4.8)
    axes.set(xlabel="elastocapillary length  l / h", ylabel="length in Eq. (16), over h")
    axes.axline((0, 0), slope=1, label="l, as on springs", color=GREY, ls="--")
    draw(axes, record["length"], "ratio", "measured", "measured, ", ls="")
    draw(axes, record["length"], "ratio", "effective", "ℓ, ", marker="")
    figures["pull"], axes = canvas(9.5, 5.2)
    axes.set(xscale="log", xlabel="radius at pull-off  a / h", ylabel="pull-off force  F / πwR")
    axes.secondary_yaxis("right").set_yticks([*LIMITS], LIMITS.values())
    axes.hlines([*LIMITS], *axes.set_xlim(0.02, 150), **level)
    for tension, style in (("weak", "-"), ("strong", "--")):
        draw(axes, record[tension], "radius", "force", f"{TENSIONS[tension]}, ", ls=style)
    plain_ticks(axes.xaxis, steps=(1.0, 3.0))
    figures["springs"], panels = canvas(10.5, 4.8, 1, 2, sharey=True)
    for axes, name in zip(panels, ("force", "radius"), strict=True):
        axes.set(xscale="log", yscale="log", ylim=(1e-4, 1), xlabel="elastocapillary length  l / h")
        axes.set_ylabel(f"relative error of springs in {name} at pull-off, worst Λ")
        axes.axhline(0.05, **level)
        draw(axes, record["springs_worst"], "ratio", name)
    for name, title in answers(record).items():
        figures[name].suptitle(title)
    return {f"layer_{name}.png": figure for name, figure in figures.items()}


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if an angle or a length is not what it should be."""
    preset, jobs, out = command.start("layer", __doc__, argv, "a few of each", FULL, QUICK)
    record = run(preset, command.say, jobs)
    tables = {**record, "pull": record["weak"] + record["strong"]}
    for name in ("angle", "length", "pull", "springs", "springs_worst", "accuracy"):
        out.table(f"layer_{name}.csv", preset, tables[name][0]._fields, tables[name])
    out.figures(plot(record))
    command.answer(". ".join(answers(record).values()) + ".")
    return int(not all(one <= most for one, most in zip(errors(record), LARGEST, strict=True)))
