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

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
# - `plain_ticks` labels a logarithmic axis with plain numbers.
# - `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the
#   states at these values one after the other: a `History` with arrays `depth`, `force` (positive
#   where it presses), `half_width`; `pull_off`, its most tensile state.
# - `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to
#   this depth, d positive into the layer; with method="lattice" it is that on nodes of a spacing.
# - A scene has `work_of_adhesion` w.
# - `each(function, cases, jobs, say=...)` gives the results in the order of the cases, whichever
#   process has them first; `say` gets each.
# - `arguments(scene)` are those of the cards of this shape: of a sphere R, gamma1, w, and k = Ẽ/h,
#   which is k(q) for q -> 0.
# - `command.answer` prints what the study has found; the fourth argument of `command.start` says in
#   the help what the quick preset does.
# - `modulus` of a layer is Ẽ = E(1-ν)/((1+ν)(1-2ν)), of uniaxial compression; inf for ν = ½.
# - δ₀ = √(2w/k) and l = √(γ₁/k), so that δ₀ = l √(2w/γ₁).
# - `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
# - `angle_deficit` of a state is its own π - θ.
# - With response="layer" a layer has its exact response; `effective_length` ℓ stands for l in (16)
#   then.
# - `scales` of a state are sums of the absolute terms of its force and energy, `error_estimate` its
#   relative errors, worked out when they are read.

import math
import statistics
import time
import timeit
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby, product, takewhile
from typing import Any, NamedTuple

from discretization import load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import COLOURS, GREY, LINE, MARKERS, Figure, canvas, plain_ticks
from studies.shared.loops import arguments

# Units are h = E = 1: Young's modulus and thickness of every layer; its Poisson's ratio is given.
layer_of = partial(ElasticLayer, 1.0, h=1.0, response="layer")
GENTLE = 1e-6  # w/γ₁: the model is linear in the displacements, of which this is only the scale
SLOPE = math.sqrt(2 * GENTLE)  # √(2w/γ₁), the kink of the surface at the line
# Of the states that are timed: half-widths from 0.4 to 1.3 h, eleven, so that the median is one.
DEPTHS = [SLOPE * part / 10 for part in range(-1, 10)]
RTOL = 1e-4  # of half-widths that nodes, and pull-off forces, are compared with to 1 %
# Of half-widths a = 15 and 21 h whose difference, 6 h, is read as a length by R Δd/Δa = 18 h: that
# is then known to 1e-5 h, a tenth of LARGEST_OF_LENGTHS.
FINE = 1e-7
EXACT = 1e-10  # of states that errors are measured against: a hundredth of the finest rtol
WIDE = 15.0  # half-width over h from which Eq. (16) is read: what it leaves out decays within h
# Over E min(a, h), the softest that the layer can be: γ₁ of weak tension. At ν = 0.3 it lowers the
# force by 0.4 % at a = 0.03 h, by 0.01 % at 100 h; ten times as much lowers it by 2.5 %.
WEAK = 1e-3
# Over E a max(a/h, 1), the stiffest that the layer is: γ₁ of strong tension. At ν = 0.3 the
# force is 0.2 % above its limit at a = 0.03 h, 1.4 % from 3 h on; with a tenth of this γ₁ it is 2 %
# at 0.03 h.
STRONG = 1e2
TENSIONS = {"weak": "γ₁ = 10⁻³ E min(a, h)", "strong": "γ₁ = 100 E a max(a/h, 1)"}
BEYOND = 3.3  # of πwR: no sphere bears as much, as the largest limit is 3
# Pull-off forces over πwR in the limits; `energy.cards.layer` derives them.
LIMITS = {
    1: "tension dominates",
    1.5: "half-space, γ₁ = 0 (JKR)",
    2: "thin, ν < ½",
    3: "thin, ν = ½",
}
# Around the worst for springs, which is inside: at ν = 0.45 radii are off by most at 0.15 for
# l/h = 0.25 and at 0.4 for l/h = 1. With 20 a decade the largest error at l/h = 1 is 0.080 in both
# in radius, and 0.043 in place of 0.037 in force.
LAMBDAS = (0.05, 0.1, 0.15, 0.25, 0.4, 0.6, 1.0, 2.5)
# Relative: what extrapolation from nodes leaves. It is off by 0.7 % with 24 nodes at ν = ½ and
# h = √(γ₁h/G), by 0.3 % with 40; an angle with 40 takes 6 to 13 s.
LARGEST_OF_ANGLES = 1e-2
LARGEST_OF_LENGTHS = 1e-4  # over h: ten times what FINE allows; in five cases 2e-7 at most
# Relative error of force and radius with which springs still serve: a choice, the table has the
# errors for another one.
SERVES = 0.05


class Angle(NamedTuple):
    """A contact angle.

    Attributes
    ----------
    nu : float
        Poisson's ratio.
    thickness : float
        h/√(γ₁h/G).
    measured : float
        (π - θ)/√(2w/γ₁).
    error : float
        How far the last two extrapolations are apart.
    """

    nu: float
    thickness: float
    measured: float
    error: float


class Length(NamedTuple):
    """The length that stands for l in Eq. (16).

    Attributes
    ----------
    nu : float
    ratio : float
        l/h.
    measured, effective : float
        Over h, from states and as the integral.
    """

    nu: float
    ratio: float
    measured: float
    effective: float


class Pull(NamedTuple):
    """A sphere at pull-off.

    Attributes
    ----------
    nu : float
    tension : {"weak", "strong"}
    radius : float
        Over h.
    force : float
        Over πwR.
    """

    nu: float
    tension: str
    radius: float
    force: float


class Springs(NamedTuple):
    """By how much springs put force and radius at pull-off too high.

    Attributes
    ----------
    nu : float
    ratio : float
        l/h.
    Lambda : float
        l/√(Rδ₀).
    force, radius : float
        Relative error of each at pull-off, positive where springs give more.
    """

    nu: float
    ratio: float
    Lambda: float
    force: float
    radius: float


class Accuracy(NamedTuple):
    """Errors and times of some states.

    Attributes
    ----------
    geometry : {"line", "axisymmetric"}
    rtol : float
    half_width, force : float
        Largest relative errors.
    milliseconds : float
        Of one state.
    over_springs : float
        That time over the one with springs.
    """

    geometry: str
    rtol: float
    half_width: float
    force: float
    milliseconds: float
    over_springs: float


Record = dict[str, list[Any]]  # rows of each question
Parameters = dict[str, tuple[tuple[Any, ...], ...]]  # values that the cases of a question combine

# Axes of the cases in the order of the arguments that the functions of MEASURES take apart. Lengths
# go from well below to well above h, ν to where the layer is nearly or wholly incompressible; l and
# springs need ν < ½. A case takes some 0.5 s, with nodes up to 13 s.
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
    """A parabola, or the sphere it is about an axis, on the layer.

    Parameters
    ----------
    nu : float
    gamma1 : float
    R : float
    geometry : {"line", "axisymmetric"}

    Returns
    -------
    Scene
    """
    surfaces = SurfaceEnergies.from_work(gamma1, GENTLE * gamma1)
    return Scene(layer_of(nu), surfaces, Parabola(R), geometry=geometry)


def angle(case: tuple[float, float, int]) -> Angle:
    """The angle under a cylinder that is about as wide as h, extrapolated from nodes.

    case: ν, thickness, and how many nodes there are on each side. Nodes are of first order, so that
    twice the angle with half the spacing less that with the spacing is of second order.
    """
    nu, thickness, nodes = case
    gamma1 = 1 / (2 * (1 + nu) * thickness**2)
    scene = scene_of(nu, gamma1, 1 / SLOPE, "line")
    finest = minimise(scene, SLOPE, rtol=RTOL).half_width / nodes

    def on_nodes(spacing: float) -> float:
        """π - θ over √(2w/γ₁) on nodes of this spacing."""
        state = minimise(scene, SLOPE, method="lattice", spacing=spacing)
        return float(state.angle_deficit / SLOPE)

    coarse = on_nodes(4 * finest)
    middle = on_nodes(2 * finest)
    fine = on_nodes(finest)
    before = 2 * middle - coarse
    last = 2 * fine - middle
    return Angle(nu, thickness, last, abs(last - before))


def length(case: tuple[float, float]) -> Length:
    """The length ℓ of Eq. (16) from a cylinder at two depths.

    case: ν and l/h. Of a cylinder Eq. (16) is a²/2R + ℓ a/R + const = d, so that between two
    states ℓ = R Δd/Δa - a with the mean a.
    """
    nu, ratio = case
    R = WIDE**2 / SLOPE
    step = SLOPE / 2
    gamma1 = layer_of(nu).stiffness * ratio**2
    scene = scene_of(nu, gamma1, R, "line")
    narrow = minimise(scene, step, rtol=FINE).half_width
    wide = minimise(scene, 2 * step, rtol=FINE).half_width
    measured = R * step / (wide - narrow) - (wide + narrow) / 2
    return Length(nu, ratio, measured, scene.effective_length)


def pull(case: tuple[float, float, str]) -> Pull:
    """A sphere that is pulled off, of such a radius that a/h there is about a given one.

    case: ν, a/h, and which tension. If that is strong, a = R √(w/2γ₁). If it is weak, wR² is what
    the half-space, a³/3, and the thin layer, a⁶/288 or Ẽa⁴/8, need in sum.

    These are solved for wR², with E = h = 1: JKR's a³ = 9πwR²/(8E*), of which a third of Ea³ is
    enough here; a³ = 12Rμ with μ² = 2wh³/(3G) of a layer that flows, G = E/3; and a² = 2Rδ₀ with
    δ₀² = 2wh/Ẽ of one that is compressed. A thin layer does what is softer, which is the smaller:
    it flows if ν is nearly ½, and Ẽ is infinite at ½.
    """
    nu, width, tension = case
    if tension == "strong":
        gamma1 = STRONG * width * max(width, 1.0)
        R = 2 * width / SLOPE
    else:
        gamma1 = WEAK * min(width, 1.0)
        half_space = width**3 / 3
        thin = min(width**6 / 288, width**4 * layer_of(nu).modulus / 8)
        R = math.sqrt((half_space + thin) / (GENTLE * gamma1))
    off, unit = pulled(scene_of(nu, gamma1, R))
    return Pull(nu, tension, off.half_width, -off.force / unit)


def pulled(scene: Scene) -> tuple[Any, float]:
    """The state with the largest pull that a sphere bears under a dead load, and πwR.

    The force goes from 0 to -BEYOND πwR. The sphere lets go on the way; `pull_off` is the state
    of largest pull on the whole path, that before such an event among them, not only of both ends.
    """
    unit = math.pi * scene.work_of_adhesion * arguments(scene)["R"]
    path = load_path(scene, forces=[0.0, -BEYOND * unit], rtol=RTOL)
    return path.pull_off, unit


def springs(case: tuple[float, float, float]) -> Springs:
    """What springs say of the pull-off of a sphere, beside the layer.

    case: ν, l/h and Λ = l/√(Rδ₀), so that R = l²/(Λ²δ₀) = l/(Λ² √(2w/γ₁)).
    """
    nu, ratio, Lambda = case
    gamma1 = layer_of(nu).stiffness * ratio**2
    scene = scene_of(nu, gamma1, ratio / (SLOPE * Lambda**2))
    on_layer, _ = pulled(scene)
    on_springs = cards.axisymmetric.sphere.pull_off(**arguments(scene))
    force = float(on_springs.force / on_layer.force)
    radius = float(on_springs.half_width / on_layer.half_width)
    return Springs(nu, ratio, Lambda, force - 1, radius - 1)


def accuracy(case: tuple[str, float]) -> Accuracy:
    """Largest errors of a cylinder or a sphere at a few depths, and the medians of their times.

    case: geometry and rtol.
    """
    geometry, rtol = case
    # Where all lengths are alike and springs do not serve: l = 0.28 h, √(γ₁h/G) = 0.93 h, a near h.
    scene = scene_of(0.45, 0.3, 1 / SLOPE, geometry)
    of_widths = []
    of_forces = []
    for depth in DEPTHS:
        state = minimise(scene, depth, rtol=rtol)
        exact = minimise(scene, depth, rtol=EXACT)
        of_widths.append(abs(state.half_width - exact.half_width) / exact.half_width)
        of_forces.append(abs(state.force - exact.force) / exact.scales["force"])
    on_springs = replace(scene, layer=replace(scene.layer, response="springs"))
    seconds = statistics.median(timed(scene, depth, rtol) for depth in DEPTHS)
    of_springs = statistics.median(timed(on_springs, depth, rtol) for depth in DEPTHS)
    return Accuracy(
        geometry, rtol, max(of_widths), max(of_forces), 1e3 * seconds, seconds / of_springs
    )


def timed(scene: Scene, depth: float, rtol: float) -> float:
    """Processor time of a state with its error estimate [s], the least of three.

    What else the processor does only adds to a time, and the first one has caches to fill.

    Parameters
    ----------
    scene : Scene
    depth, rtol : float

    Returns
    -------
    float
    """

    def estimated() -> Any:
        """What is timed: a state with its error estimate."""
        return minimise(scene, depth, rtol=rtol).error_estimate

    return min(timeit.repeat(estimated, time.process_time, repeat=3, number=1))


MEASURES: dict[str, Callable[[Any], Any]] = {
    "angle": angle,
    "length": length,
    "weak": pull,
    "strong": pull,
    "springs": springs,
    "accuracy": accuracy,
}


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> Record:
    """Every case, in `jobs` processes, of times in one; `show` gets a line for each.

    Parameters
    ----------
    parameters : dict
        Values that the cases of each question combine.
    show : callable, optional
        Gets a line of text as soon as one is there.
    jobs : int
        Number of processes.

    Returns
    -------
    dict
        Rows by the name of their question.
    """
    rows: Record = {}
    for name, axes in parameters.items():
        cases = list(product(*axes))
        workers = 1 if name == "accuracy" else jobs  # others would disturb the times
        rows[name] = list(each(MEASURES[name], cases, workers, say=lambda row: show(line(row))))
    rows["springs_worst"] = [worst(own) for own in grouped(rows["springs"], 2)]
    return rows


def line(row: Any) -> str:
    """One row on the screen."""
    cells = []
    for name, value in zip(row._fields, row, strict=True):
        cells.append(f"{name} = {value:.5g}" if isinstance(value, float) else f"{name} = {value}")
    return f"{type(row).__name__.lower():9s} {', '.join(cells)}"


def grouped(rows: Iterable[Any], columns: int = 1) -> list[list[Any]]:
    """Rows that follow one another with the same first columns, by default the same ν."""
    return [list(own) for _, own in groupby(rows, lambda row: row[:columns])]


def worst(rows: Sequence[Springs]) -> Springs:
    """The largest errors of these, without sign; Λ is that of the radius."""
    most = max(rows, key=lambda row: abs(row.radius))
    force = max(abs(row.force) for row in rows)
    return most._replace(force=force, radius=abs(most.radius))


def errors(record: Record) -> tuple[float, float]:
    """The largest of angles, relative, and of lengths, over h."""
    angles = max(abs(row.measured - 1) for row in record["angle"])
    lengths = max(abs(row.measured - row.effective) for row in record["length"])
    return angles, lengths


def served(record: Record) -> list[str]:
    """The l/h of each ν from which on springs serve within 5 %, in words."""
    found = []
    for of_nu in grouped(record["springs_worst"]):
        from_above = reversed(of_nu)
        good = list(takewhile(lambda row: max(row.force, row.radius) <= SERVES, from_above))
        if good:
            found.append(f"{good[-1].ratio:g} (ν = {good[-1].nu:g})")
    return found


def answers(record: Record) -> dict[str, str]:
    """What each figure says."""
    angle, length = errors(record)
    weak = record["weak"]
    strong = record["strong"][0]  # the narrowest, which is nearest to the limit, 1
    narrow = min(weak, key=lambda row: row.radius)
    most = max(weak, key=lambda row: row.force)
    return {
        "angle": f"The angle stays √(2w/γ₁) whatever ν and h, within {100 * angle:.1g} % on nodes",
        "length": f"Eq. (16) holds with ℓ in place of l, within {length:.0e} h",
        "pull": f"A sphere sticks with {narrow.force:.3g} πwR if h ≫ a (JKR: 1.5, γ₁ = 0), "
        f"{most.force:.3g} at ν = {most.nu:g}, a = {most.radius:.2g} h, {strong.force:.3g} where "
        "tension dominates",
        "springs": f"Springs serve within 5 % from l/h = {', '.join(served(record))} on",
    }


def draw(axes: Any, rows: Iterable[Any], x: str, y: str, label: str = "", **look: Any) -> None:
    """Draw a line or marks for each Poisson's ratio, with the error of what has one.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        If its x is logarithmic, it gets labels at 1, 2, 3 and 5 of each decade.
    rows : iterable of Angle, Length, Pull or Springs
        Those of one ν follow one another.
    x, y : str
        Names of the attributes that are drawn over each other.
    label : str
        Stands before "ν = ..." in the legend.
    **look
        Of `errorbar`, such as ls and mfc; colour and marker are those of the ν.
    """
    for of_nu, colour, marker in zip(grouped(rows), COLOURS, MARKERS, strict=False):
        first = of_nu[0]
        horizontal = [getattr(row, x) for row in of_nu]
        vertical = [getattr(row, y) for row in of_nu]
        error = [row.error for row in of_nu] if isinstance(first, Angle) else None
        style = {"color": colour, "marker": marker, "ms": 5, "capsize": 3, **look}
        name = f"{label}ν = {first.nu:g}"
        axes.errorbar(horizontal, vertical, yerr=error, label=name, **style)
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
        axes.axhline(SERVES, **level)
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
    angle, length = errors(record)
    good = angle <= LARGEST_OF_ANGLES and length <= LARGEST_OF_LENGTHS
    return int(not good)
