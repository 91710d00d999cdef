"""What does a closed loop of touching, pressing and pulling off cost, and where is it lost?

Flat punch, wedge and parabola go through closed load paths, for several surface tensions γ₁ and
works of adhesion w, under imposed depth, a dead load, and machines of finite stiffness K:

    ∮P dd = Σ energy released in the instabilities.

The left side comes from the forces along the path, the right side from the energies beside the
events. Jump-in, pull-off, end of the contact and loop area stand beside the closed forms
(energy.cards); where a closed form is 0 the error is in units of kδ₀(b + l), δ₀ and b, see
shared/loops.py. A loop depends (small slopes) on two groups: l/b, which is √(γ₁/k)/b, or
√(γ₁/2w) tan δ for the wedge, and K/(kb).

Output: a line per loop and its worst error, hysteresis.csv with all numbers, figures. Exit status 1
if an error exceeds 1e-8 or the energy balance does not close within 1e-9.
"""

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `command.answer` says the answer, in the last line of the screen.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - A `Table` is the names of its columns, and its rows.
# - `Columns` writes tables on the screen: `head` is the first line, `line(*cells)` any other.
# - `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
# - `quantity(value, unit)` is a text such as 20 mN/m.
# - `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the
#   states at these values one after the other: a `History` with arrays `depth`, `force` (positive
#   where it presses), `half_width`; `dissipated`, the energy that it loses; `work()`, the ∮ P dd.
# - A scene has `gamma1` γ₁, `work_of_adhesion` w and `critical_separation` δ₀ = √(2w/k).
# - `loops` has three INDENTERS on LAYER whose contact is as wide as b = SIZE without tension, with
#   the work of adhesion WORK: `depth_loop` goes down and back by the depth, `driven_loop(path, K)`
#   through the same states with a machine, or with a dead load for K = 0; `compared` are the
#   numbers of a loop with closed forms, and `imbalance` how far work and lost energy differ.
# - `legs` are the parts of a path between its turns and jumps.

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from discretization import History
from discretization.plots import draw_path, legs, units
from energy import cards
from energy.arrays import Array
from energy.units import quantity
from studies.shared import command, loops
from studies.shared.batches import Show, each, silent
from studies.shared.figures import BLUE, ORANGE, Figure, canvas
from studies.shared.loops import INDENTERS, LAYER, SIZE, WORK
from studies.shared.table import Columns, Table

BAR = 1e-8  # largest relative error against a closed form
BALANCE_BAR = 1e-9  # largest relative imbalance of energy
MODERATE = 0.02  # N/m, the tension whose loops are drawn
# What is printed, and its unit: μm for lengths, else SI.
SHOWN = {
    "jump-in half-width": 1e6,
    "pull-off force": 1.0,
    "pull-off depth": 1e6,
    "pull-off half-width": 1e6,
    "loop area": 1.0,
}


@dataclass(frozen=True)
class Parameters:
    """The loops.

    Attributes
    ----------
    tensions : tuple of float
        γ₁ [N/m].
    works : tuple of float
        w [J/m²].
    machines : tuple of float
        Stiffnesses K/(kb).
    steps : int
        Of a loop.
    """

    tensions: tuple[float, ...] = (0.002, 0.02, 0.1, 0.4)
    works: tuple[float, ...] = (WORK / 2, WORK)
    machines: tuple[float, ...] = (0.3, 3.0)
    steps: int = 60


FULL = Parameters()
QUICK = Parameters(tensions=(0.02, 0.4), works=(WORK,), machines=(0.3,), steps=36)  # few loops


@dataclass(frozen=True)
class Loop:
    """One closed path beside its closed forms.

    Attributes
    ----------
    shape : str
        Of the indenter.
    history : History
    forms : tuple of Form
        Each number that has a closed form, and this.
    work : float
        ∮P dd, from the forces.
    """

    shape: str
    history: History
    forms: tuple[loops.Form, ...]
    work: float

    @property
    def imbalance(self) -> float:
        """How far the energy balance is off, relative."""
        return loops.imbalance(self.history, self.work)

    @property
    def control(self) -> str:
        """Depth, force, or the stiffness of the machine in units of kb."""
        K = self.history.machine_stiffness
        if not K:
            return self.history.control
        return f"K = {K / (LAYER.stiffness * SIZE):.3g} kb"

    @property
    def error(self) -> float:
        """The largest of all relative errors."""
        return max(form.error for form in self.forms)

    @property
    def passed(self) -> bool:
        """Whether all errors are within the limits; nan is not."""
        return self.error <= BAR and self.imbalance <= BALANCE_BAR


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> tuple[Loop, ...]:
    """Follow all loops in `jobs` processes; `show` gets a line for each.

    Parameters
    ----------
    parameters : Parameters
    show : callable, optional
        Gets a line of text as soon as one is there.
    jobs : int
        Number of processes.

    Returns
    -------
    tuple of Loop
    """
    show(COLUMNS.head)
    scenes = list(product(INDENTERS, parameters.tensions, parameters.works))
    under_all_controls = partial(_controls, parameters)

    def say(own: list[Loop]) -> None:
        """Show the lines of the loops of one scene."""
        show("\n".join(map(line, own)))

    found: list[Loop] = []
    for own in each(under_all_controls, scenes, jobs, say=say):
        found += own
    return tuple(found)


def _controls(parameters: Parameters, case: tuple[str, float, float]) -> list[Loop]:
    """The loops of one scene under imposed depth, a dead load, and each machine, in this order.

    case: indenter, γ₁ [N/m] and w [J/m²].
    """
    shape, gamma1, w = case
    scene = loops.scene_of(shape, gamma1, w)
    under_depth = loops.depth_loop(scene, parameters.steps)
    paths = [under_depth]
    for machine in (0.0, *parameters.machines):  # 0: a dead load
        stiffness = machine * (LAYER.stiffness * SIZE)
        paths.append(loops.driven_loop(under_depth, stiffness))
    return [Loop(shape, path, tuple(loops.compared(path)), path.work()) for path in paths]


COLUMNS = Columns(
    "indenter -10|γ₁ N/m 6.3g|w J/m² 6.3g|control -12|jump-in a µm 12.6g|pull-off N/m 14.6g|"
    "d µm 9.6g|a µm 9.6g|area J/m 12.6g|error 6.0e|balance 7.0e"
)


def line(loop: Loop) -> str:
    """One line of the table."""
    scene = loop.history.scene
    numbers = []
    for form in loop.forms:
        if form.name not in SHOWN:
            continue
        is_zero = abs(form.simulated) <= BAR * form.scale
        numbers.append(0.0 if is_zero else form.simulated * SHOWN[form.name])
    given = (loop.shape, scene.gamma1, scene.work_of_adhesion, loop.control)
    told = COLUMNS.line(*given, *numbers, loop.error, loop.imbalance)
    return told if loop.passed else f"{told}  FAIL"


def drawn(record: Sequence[Loop], shape: str) -> list[Loop]:
    """The loops of a shape at w = WORK and moderate tension, under one control after the other."""
    found = []
    for loop in record:
        scene = loop.history.scene
        if (loop.shape, scene.gamma1, scene.work_of_adhesion) == (shape, MODERATE, WORK):
            found.append(loop)
    return found


def plot(record: Sequence[Loop]) -> dict[str, Figure]:
    """Every figure by file name; one of the parabola's loops is looked at closely."""
    history = drawn(record, "parabola")[0].history
    title = f"Parabola, γ₁ = {quantity(MODERATE, 'N/m')}: in contact loading and unloading coincide"
    figure = history.plot(title, closed_form(history))
    shade(figure.axes[0], history)
    return {"hysteresis_control.png": over_control(record), "hysteresis_loop.png": figure}


def shade(axes: Any, history: History) -> None:
    """The area of the loop, ∮P dd: the energy that a cycle dissipates."""
    depth, force = units(history, "force")
    states = [state for _, leg in legs(history) for state in leg]  # jumps included
    x = np.array([state.depth for state in states]) / depth.size
    y = np.array([state.force for state in states]) / force.size
    lost = quantity(history.dissipated, "J/m")
    axes.fill(x, y, color=ORANGE, alpha=0.15, lw=0, label=f"∮P dd = {lost}, dissipated")
    axes.legend(fontsize=9)


def over_control(record: Sequence[Loop]) -> Figure:
    """P(d) of one γ₁, a row for each control, each loop in a panel of its own."""
    words = {"depth": "imposed depth", "force": "dead load"}
    chosen = [drawn(record, shape) for shape in INDENTERS]
    rows = len(chosen[0])
    figure, grid = canvas(12.5, 3.4 * rows, rows, len(INDENTERS), squeeze=False)
    for column, own in zip(grid.T, chosen, strict=True):
        for axes, loop in zip(column, own, strict=True):
            area = loop.history.dissipated / (2 * WORK * SIZE)
            draw_path(axes, loop.history, "force", units(loop.history, "force"), BLUE)
            stiffness = loop.control.removeprefix("K = ").replace(" ", "·")
            held = words.get(loop.control, f"spring of stiffness {stiffness}")
            axes.set_title(f"{loop.shape}, {held},\nloop area {area:.3g}·2wb", fontsize=10)
            axes.axhline(0, color="black", lw=0.6, ls=":")
            axes.grid(alpha=0.25)
    figure.suptitle(
        "What holds the indenter decides where it jumps (dashed) and how much energy that costs; "
        f"γ₁ = {quantity(MODERATE, 'N/m')}, b = {quantity(SIZE, 'm')}"
    )
    return figure


def closed_form(history: History) -> tuple[Array, Array, Array]:
    """d [m], P [N/m] and a [m] (400,) of a parabola's branch from its end at -δ₀ to the top."""
    scene = history.scene
    given = loops.arguments(history.scene)
    d = np.linspace(-scene.critical_separation, float(history.depth.max()), 400)
    force = cards.parabola.force(d, **given)
    a = cards.parabola.half_width(d, **given)
    return d, np.asarray(force), np.asarray(a)


def table(record: Sequence[Loop]) -> Table:
    """A row per loop: every number simulated, in closed form, and its relative error. SI."""
    names = [form.name.replace(" ", "_") for form in record[0].forms]
    columns = [f"{name}{end}" for name in names for end in ("", "_closed_form", "_error")]
    given = ["indenter", "gamma1", "w", "control", "machine_stiffness"]
    rows = []
    for loop in record:
        history = loop.history
        scene = history.scene
        row = [loop.shape, scene.gamma1, scene.work_of_adhesion, history.control]
        row.append(history.machine_stiffness or "")
        for form in loop.forms:
            row += [form.simulated, form.closed_form, form.error]
        row += [loop.work, history.dissipated, loop.imbalance]
        rows.append(row)
    return [*given, *columns, "work", "dissipated", "imbalance"], rows


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if a loop misses a limit."""
    preset, jobs, out = command.start("hysteresis", __doc__, argv, "fewer loops", FULL, QUICK)
    record = run(preset, command.say, jobs)
    out.table("hysteresis.csv", preset, *table(record))
    out.figures(plot(record))
    error = float(np.max([loop.error for loop in record]))
    imbalance = float(np.max([loop.imbalance for loop in record]))
    failed = sum(not loop.passed for loop in record)
    limits = f"limits {BAR:.0e}, of the balance {BALANCE_BAR:.0e}"
    print(f"{len(record)} loops, {failed} failed; {limits}")
    command.answer(
        f"The energy released in its jumps and nothing else: in {len(record)} loops the area "
        f"agrees with that within {imbalance:.0e}, and with the closed forms within {error:.0e}."
    )
    return int(failed > 0)
