"""How hard does a sphere stick: 2πRw as on springs, or πRw as on a liquid?

A sphere is pulled off a layer whose surface tension grows with Λ = l/√(Rδ₀): by a dead load, which
detaches it at its largest pull, dP/dd = 0, and under imposed depth, where it holds on to the least
depth of its branch. Beside the simulation stand the closed forms, their expansions

    F_A/(2πRw) = 1 - Λ/√2 - 3Λ²/32 (Λ → 0),    ½ + (ln 4Λ² - γ_E - ¼)/(16Λ⁴) (Λ → ∞),
    d_c = -δ₀ (1 - ¾ (2Λ²)^(1/3)) (Λ → 0, imposed depth),

and a long cylinder (the line contact), whose pull has a kink at Λ = 1, over that without tension.
Small slopes depend on Λ alone; finite slopes, for the true arc, on w/γ₁ too.

Output: sphere.csv, sphere.png. Exit status 1 if an error of small slopes exceeds 1e-8.
"""

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - A `Table` is the names of its columns, and its rows.
# - `Columns` writes tables on the screen: `head` is the first line, `line(*cells)` any other.
# - `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
# - `plain_ticks` labels a logarithmic axis with plain numbers.
# - `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the
#   states at these values one after the other: a `History` with arrays `depth`, `force` (positive
#   where it presses), `half_width`; `events`, the jumps and other events in their order, each with
#   a kind, the states `before` and `after` it; `pull_off`, its most tensile state.
# - A scene has `stiffness` k = Ẽ/h, `work_of_adhesion` w and `critical_separation` δ₀ = √(2w/k).
# - `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
# - `Circle(R)` is the true arc.
# - `cards.axisymmetric.sphere` has the closed forms: the states of the largest pull and of
#   detachment, with force < 0, depth and half_width, the radius.

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from discretization import load_path
from energy import Circle, ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from energy.arrays import Array
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import BLUE, GREEN, GREY, LINE, ORANGE, Figure, canvas, plain_ticks
from studies.shared.table import Columns, Table

LAYER = ElasticLayer(E=7e3, nu=0.0, h=10e-6)  # Pa, 1, m
LENGTH = 10e-6  # l [m]
GAMMA1 = LAYER.stiffness * LENGTH**2  # N/m
GENTLE = 1e-4  # w/γ₁ with small slopes, which only sets the scale
LARGEST = 1e-8  # relative error
BEYOND = 1.05  # of 2πRw and of -δ₀: no contact bears as much

# The Λ at which the expansions end that are drawn, and by how much they are off there.
SMALL_FORCE = 0.75  # 0.18 of 2πRw
SMALL_DEPTH = 0.5  # 0.06 of δ₀
LARGE_FORCE = 1.05  # 0.015 of 2πRw


@dataclass(frozen=True)
class Parameters:
    """The spheres.

    Attributes
    ----------
    ratios : tuple of float
        Λ with small slopes.
    finite, works : tuple of float
        Λ and w/γ₁ with finite slopes, each with each.
    """

    ratios: tuple[float, ...] = tuple(np.geomspace(0.01, 10, 25).tolist())
    finite: tuple[float, ...] = tuple(np.geomspace(0.03, 10, 9).tolist())
    works: tuple[float, ...] = (0.1, 0.5)


FULL = Parameters()
QUICK = Parameters((0.01, 0.3, 1.0, 10.0), (0.3, 1.0), (0.5,))  # few, over the same range of Λ


class Pull(NamedTuple):
    """Where a contact detaches.

    Attributes
    ----------
    force : float
        F_A over 2πRw.
    depth : float
        Over δ₀.
    radius : float
        Over l.
    """

    force: float
    depth: float
    radius: float


class Sphere(NamedTuple):
    """One sphere.

    Attributes
    ----------
    ratio : float
        Λ = l/√(Rδ₀).
    work : float
        w/γ₁.
    slopes : {"small", "finite"}
    load, depth : Pull
        Where it detaches under a dead load, and under imposed depth.
    """

    ratio: float
    work: float
    slopes: str
    load: Pull
    depth: Pull

    @property
    def error(self) -> float:
        """Difference of the largest pull and the least depth from those of small slopes."""
        load, depth = closed_forms(self.ratio)
        of_force = abs(self.load.force - load.force)
        of_depth = abs(self.depth.depth - depth.depth)
        return float(max(of_force, of_depth))


def scene_of(ratio: float, work: float, slopes: str) -> Scene:
    """The sphere with this Λ: a parabola with small slopes, the true arc with finite ones.

    Parameters
    ----------
    ratio : float
        Λ.
    work : float
        w/γ₁.
    slopes : {"small", "finite"}

    Returns
    -------
    Scene
    """
    R = LENGTH / (math.sqrt(2 * work) * ratio**2)
    surfaces = SurfaceEnergies.from_work(GAMMA1, work * GAMMA1)
    body = Parabola(R) if slopes == "small" else Circle(R)
    return Scene(LAYER, surfaces, body, slopes, geometry="axisymmetric")


def detached(case: tuple[float, float, str]) -> Sphere:
    """Pull a sphere that has touched by a growing load, and raise another.

    Parameters
    ----------
    case : tuple
        Λ, w/γ₁ and slopes.

    Returns
    -------
    Sphere
    """
    scene = scene_of(*case)
    under_load = load_path(scene, forces=[0.0, -BEYOND * on_springs(scene)])
    raised = load_path(scene, depths=[0.0, -BEYOND * scene.critical_separation])
    last_contact = raised.events[-1].before
    return Sphere(*case, _scaled(scene, under_load.pull_off), _scaled(scene, last_contact))


def on_springs(scene: Scene) -> float:
    """2πRw, the largest pull on springs without tension."""
    return 2 * math.pi * float(scene.indenter.R) * scene.work_of_adhesion  # type: ignore[attr-defined]


def _scaled(scene: Scene, state: Any) -> Pull:
    """Force, depth and radius of a state in the units of `Pull`."""
    depth = state.depth / scene.critical_separation
    return Pull(-state.force / on_springs(scene), depth, state.half_width / LENGTH)


def closed_forms(ratio: Any) -> tuple[Pull, Pull]:
    """Where a sphere with small slopes detaches, under dead load and imposed depth.

    Parameters
    ----------
    ratio : float or ndarray (n,)
        Λ.

    Returns
    -------
    load, depth : Pull
        Of numbers, or of arrays (n,).
    """
    R = LENGTH / (math.sqrt(2 * GENTLE) * np.square(ratio))
    delta0 = math.sqrt(2 * GENTLE) * LENGTH
    largest = 2 * math.pi * R * GENTLE * GAMMA1  # 2πRw

    def scaled(found: Any) -> Pull:
        """Force, depth and radius of a state as those of `Pull`: a pull for a force < 0."""
        return Pull(-found.force / largest, found.depth / delta0, found.half_width / LENGTH)

    card: Any = cards.axisymmetric.sphere
    given = {"R": R, "k": LAYER.stiffness, "gamma1": GAMMA1, "w": GENTLE * GAMMA1}
    return scaled(card.pull_off(**given)), scaled(card.detachment(**given))


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> tuple[Sphere, ...]:
    """Every sphere, in `jobs` processes; `show` gets a line for each.

    Free surfaces with finite slopes are read off a family that a process solves once: in one.

    Parameters
    ----------
    parameters : Parameters
    show : callable, optional
        Gets a line of text as soon as one is there.
    jobs : int
        Number of processes.

    Returns
    -------
    tuple of Sphere
    """
    show(COLUMNS.head)
    small = [(ratio, GENTLE, "small") for ratio in parameters.ratios]
    works_and_ratios = product(parameters.works, parameters.finite)
    finite = [(ratio, work, "finite") for work, ratio in works_and_ratios]

    def say(sphere: Sphere) -> None:
        """Show the line of one sphere."""
        show(line(sphere))

    found = [*each(detached, small, jobs, say=say)]
    found += each(detached, finite, 1, say=say)
    return tuple(found)


COLUMNS = Columns(
    "Λ 8.4g|slopes 7|w/γ₁ 7g|F_A/2πRw 15.12g|d/δ₀ 12.6g|a/l 10.5g|d_c/δ₀ 13.9g|a_c/l 10.5g"
    "|from small slopes 18.0e"
)


def line(sphere: Sphere) -> str:
    """One line of the table."""
    ratio, work, slopes, load, depth = sphere
    return COLUMNS.line(ratio, slopes, work, *load, *depth[1:], sphere.error)


def plot(spheres: Sequence[Sphere]) -> Figure:
    """Pull-off force, and depths of detachment, over Λ."""
    drawn, (left, right) = canvas(12, 5.4, 1, 2)
    ratios = [sphere.ratio for sphere in spheres]
    dense = np.geomspace(min(ratios), max(ratios), 300)
    load, depth = closed_forms(dense)
    _forces(left, dense, load)
    _depths(right, dense, load, depth)
    works = sorted({sphere.work for sphere in spheres})
    for work, marker, colour in zip(works, "o^s", (BLUE, ORANGE, GREEN), strict=False):
        own = [s for s in spheres if s.work == work]
        finite = own[0].slopes == "finite"
        ratios = [s.ratio for s in own]
        name = f"finite slopes, w = {work:g} γ₁" if finite else "small slopes"
        look = {"mfc": "none", "ms": 9} if finite else {"mfc": colour, "ms": 5}
        style = {"color": colour, "marker": marker, "ls": "", "mew": 1.5, **look}
        left.plot(ratios, [s.load.force for s in own], label=f"simulated, {name}", **style)
        right.plot(ratios, [s.load.depth for s in own], **style)
        right.plot(ratios, [s.depth.depth for s in own], **style)
    for axes in (left, right):
        axes.set(xscale="log", xlabel="tension  Λ = l/√(Rδ₀)")
        axes.set(xlim=(dense[0] / 1.3, 1.3 * dense[-1]))
        plain_ticks(axes.xaxis, steps=(1.0, 3.0))
        axes.grid(alpha=0.25)
    below: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14), "ncols": 2}
    left.legend(fontsize=9, **below)
    right.legend(fontsize=9, **below)
    drawn.suptitle("Surface tension halves the pull-off force of a sphere, from 2πRw to πRw")
    return drawn


def _forces(axes: Any, ratios: Array, load: Pull) -> None:
    """Curves of the pull-off force over Λ: closed form, expansions and line contact.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    ratios : ndarray (n,)
        Increasing Λ.
    load : Pull
        The closed form of a dead load at these, arrays (n,) over 2πRw, δ₀ and l.
    """
    low = ratios[ratios < SMALL_FORCE]
    high = ratios[ratios > LARGE_FORCE]
    small = 1 - low / math.sqrt(2) - 3 * low**2 / 32
    large = 0.5 + (np.log(4 * high**2) - np.euler_gamma - 0.25) / (16 * high**4)
    # `cards.parabola.pull_off`: (4/3) k √R δ₀^(3/2) + (2/3) k l³/R for Λ <= 1, 2k l δ₀ beyond
    line_contact = np.where(ratios < 1, 1 + ratios**3 / 2, 1.5 * ratios)
    axes.plot(ratios, load.force, label="closed form", **LINE)
    axes.plot(low, small, color=GREY, ls="--", label="expansions, Λ → 0 and Λ → ∞")
    axes.plot(high, large, color=GREY, ls="--")
    axes.plot(ratios, line_contact, color=GREEN, ls=":", label="line contact, normalised by γ₁ = 0")
    at = ratios[-1] * 0.95
    for level, text in ((1.0, "2πRw"), (0.5, "πRw")):
        axes.axhline(level, color=GREY, lw=0.8)
        axes.text(at, level + 0.01, text, va="bottom", ha="right")
    axes.set(ylim=(0.4, 1.75), ylabel="pull-off force  $F_A$ / 2πRw")


def _depths(axes: Any, ratios: Array, load: Pull, depth: Pull) -> None:
    """Curves of the depths of detachment over Λ, in units of δ₀: those of `_forces`.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    ratios : ndarray (n,)
        Increasing Λ.
    load, depth : Pull
        The closed forms of dead load and imposed depth at these, arrays (n,).
    """
    low = ratios[ratios < SMALL_DEPTH]
    expansion = -(1 - 0.75 * np.cbrt(2 * low**2))
    # `cards.parabola.pull_off`: d = -δ₀/2 - l²/(2R) for Λ <= 1, -δ₀ beyond
    line_contact = -np.minimum(1 + ratios**2, 2) / 2
    axes.plot(ratios, load.depth, label="dead load", **LINE)
    axes.plot(ratios, depth.depth, color="black", ls="-.", lw=1.2, label="imposed depth")
    axes.plot(low, expansion, color=GREY, ls="--", label="expansion, Λ → 0")
    axes.plot(ratios, line_contact, color=GREEN, ls=":", label="line contact: dead load")
    axes.axhline(-1, color=GREEN, ls=(0, (1, 4)), label="line contact: imposed depth")
    axes.set(ylim=(-1.08, 0.1), ylabel="depth of detachment  d / δ₀")


def table(spheres: Sequence[Sphere]) -> Table:
    """Columns and a row per sphere; forces over 2πRw, depths over δ₀, radii over l."""
    names = ["Lambda", "w_over_gamma1", "slopes"]
    names += [f"{name}_{control}" for control in ("load", "depth") for name in Pull._fields]
    known = ("force_load", "depth_load", "force_depth", "depth_depth")
    names += [f"{name}_small_slopes" for name in known]
    rows = []
    for one in spheres:
        card = [float(value) for pull in closed_forms(one.ratio) for value in pull[:2]]
        rows.append([*one[:3], *one.load, *one.depth, *card])
    return names, rows


def answer(spheres: Sequence[Sphere]) -> str:
    """In one sentence."""
    small = sorted(s for s in spheres if s.slopes == "small")
    steep = max((s.error for s in spheres if s.slopes == "finite"), default=0.0)
    middle = min(small, key=lambda s: abs(math.log(s.ratio)))
    shown = (small[0], middle, small[-1])
    told = ", ".join(f"{s.load.force:.4g} at Λ = {s.ratio:.3g}" for s in shown)
    return (
        f"Both: F_A/2πRw falls from 1 to ½ as tension takes over, without the kink of a line "
        f"contact: {told}; finite slopes change it, and d_c/δ₀, by {steep:.1g} at most."
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if an error misses its limit."""
    preset, jobs, out = command.start("sphere", __doc__, argv, "few spheres", FULL, QUICK)
    spheres = run(preset, command.say, jobs)
    out.table("sphere.csv", preset, *table(spheres))
    out.figure("sphere.png", plot(spheres))
    worst = max(s.error for s in spheres if s.slopes == "small")
    print(
        f"{len(spheres)} spheres, worst error with small slopes {worst:.0e} (limit {LARGEST:.0e})"
    )
    command.answer(answer(spheres))
    return int(not worst <= LARGEST)
