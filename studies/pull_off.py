"""Does surface tension help or weaken adhesion? Pull-off of flat punch, wedge and parabola.

Under a dead load that slowly falls, the adhesion force F_A is the largest pull the contact bears,
here against γ₁ over decades at a fixed work of adhesion w. Beside it the closed forms

    flat punch  F_A = 2√(2w) (a√k + √γ₁)                       (23)
    wedge       F_A = 2w/tan δ - γ₁ tan δ,  tan δ <= √(2w/γ₁)   (30), beyond: 0
    parabola    F_A = (4/3) k √R δ₀^(3/2) + (2/3) k l³/R,  Λ <= 1;  2√(2wγ₁),  Λ >= 1

with Λ = l/b, b = √(Rδ₀); for the wedge b = δ₀/tan δ, for the punch b = a. The conclusion of the
paper (Section 9, that tension helps the flat punch and weakens the wedge) is confirmed or qualified
from the simulated numbers. For the flat punch also the pull at which the detached state gets the
lower energy: the adhered contact is only metastable beyond it.

Output: the table with errors, the conclusions, pull_off.csv, pull_off_gain.png. Exit status 1 if an
error exceeds 1e-8.
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
# - `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to
#   this depth, d positive into the layer.
# - A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁, `work_of_adhesion` w and `critical_separation` δ₀
#   = √(2w/k).
# - `loops` has three INDENTERS on LAYER whose contact is as wide as b = SIZE without tension:
#   `scene_of(shape, γ₁)` is one of them.
# - `most_tensile(path)`, `pull_off_card(scene)` and `global_pull_off(scene)` are (P, d, a),
#   simulated, in closed form, and where a flat punch has the energy of no contact; `force_scale` is
#   kδ₀(b + l), `size` b.
# - A `Form` is a number beside its closed form, with a scale for where that is 0.

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from discretization import load_path, minimise
from energy import Scene
from energy.arrays import Array
from studies.shared import command, loops
from studies.shared.batches import Show, each, silent
from studies.shared.figures import COLOURS, GREY, MARKERS, Figure, canvas
from studies.shared.loops import INDENTERS, LAYER, SIZE, WORK
from studies.shared.table import Columns, Table

BAR = 1e-8  # largest relative error, the default goal of `load_path`
SHORT = 1e-14  # of δ₀: how far short of detachment a punch is sure to be in contact, 50 roundings
ROUNDING = 1e-15  # of δ₀: the depth of equal energies is searched to all digits


@dataclass(frozen=True)
class Parameters:
    """The scenes.

    Attributes
    ----------
    ratios : tuple of float
        l/b; 0 is added: no tension.
    """

    ratios: tuple[float, ...] = (*np.geomspace(0.01, 100, 25).tolist(), 0.82, 0.92, 0.97)


FULL = Parameters()
QUICK = Parameters(ratios=(0.03, 0.3, 0.8, 1.7, 4.0))  # on both sides of l = b


class State(NamedTuple):
    """A pull.

    Attributes
    ----------
    force : float
        F_A > 0 [N/m].
    depth, half_width : float
        [m].
    """

    force: float
    depth: float
    half_width: float


class Pull(NamedTuple):
    """Pull-off of one scene.

    Attributes
    ----------
    scene : Scene
    ratio : float
        l/b.
    simulated, closed_form : State
        Where a dead load detaches the contact.
    balanced, balanced_card : State or None
        Where the detached state of a flat punch gets the lower energy, simulated and in closed
        form; None for other indenters.
    """

    scene: Scene
    ratio: float
    simulated: State
    closed_form: State
    balanced: State | None
    balanced_card: State | None

    @property
    def error(self) -> float:
        """Largest relative error, where the closed form is 0 of kδ₀(b + l), δ₀ or b."""
        scene = self.scene
        scales = (loops.force_scale(scene), scene.critical_separation, loops.size(scene))
        forms = list(zip(self.simulated, self.closed_form, scales, strict=True))
        if self.balanced is not None and self.balanced_card is not None:
            forms += zip(self.balanced, self.balanced_card, scales, strict=True)
        return max(loops.Form("", *form).error for form in forms)


@dataclass(frozen=True)
class Curve:
    """All pulls of one indenter.

    Attributes
    ----------
    shape : str
        Of the indenter.
    pulls : tuple of Pull
        Over growing tension; the first without.
    """

    shape: str
    pulls: tuple[Pull, ...]

    @property
    def ratios(self) -> Array:
        """l/b (n,)."""
        return np.array([pull.ratio for pull in self.pulls])

    @property
    def forces(self) -> Array:
        """F_A (n,), simulated."""
        return np.array([pull.simulated.force for pull in self.pulls])

    @property
    def gain(self) -> Array:
        """F_A over that without tension."""
        return self.forces / self.forces[0]

    @property
    def error(self) -> float:
        """The largest of all errors."""
        return float(np.max([pull.error for pull in self.pulls]))


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> tuple[Curve, ...]:
    """Pull every scene off in `jobs` processes; `show` gets a line for each.

    Parameters
    ----------
    parameters : Parameters
    show : callable, optional
        Gets a line of text as soon as one is there.
    jobs : int
        Number of processes.

    Returns
    -------
    tuple of Curve
    """
    show(COLUMNS.head)
    ratios = (0.0, *sorted(parameters.ratios))
    cases = list(product(INDENTERS, ratios))
    found = each(pulled, cases, jobs)
    pulls: dict[str, list[Pull]] = {shape: [] for shape in INDENTERS}
    for (shape, _), pull in zip(cases, found, strict=True):
        pulls[shape].append(pull)
        show(line(shape, pull))
    return tuple(Curve(shape, tuple(own)) for shape, own in pulls.items())


def _scene(shape: str, ratio: float) -> Scene:
    """An indenter at this l/b."""
    return loops.scene_of(shape, LAYER.stiffness * (ratio * SIZE) ** 2)


def pulled(case: tuple[str, float]) -> Pull:
    """Press to a depth of 2δ₀ under a dead load, then lower the load until the contact detaches.

    Parameters
    ----------
    case : tuple
        Indenter and l/b.

    Returns
    -------
    Pull
    """
    shape, ratio = case
    scene = _scene(shape, ratio)
    pressed = minimise(scene, 2 * scene.critical_separation).force
    beyond = -3 * loops.force_scale(scene)  # no contact bears as much
    path = load_path(scene, forces=[pressed, beyond])
    simulated = _pull(loops.most_tensile(path))
    closed_form = _pull(loops.pull_off_card(scene))
    if shape != "flat punch":
        return Pull(scene, ratio, simulated, closed_form, None, None)
    balanced_card = _pull(loops.global_pull_off(scene))
    return Pull(scene, ratio, simulated, closed_form, balanced(scene), balanced_card)


def balanced(scene: Scene) -> State:
    """Where the adhered energy U(d) passes that of the detached surface, 0 (Maxwell)."""

    def energy(depth: float) -> float:
        """U of the adhered state at a depth; that of the detached one is 0."""
        return minimise(scene, depth).energy

    delta0 = scene.critical_separation
    least = -(1 - SHORT) * delta0  # still in contact
    depth = least  # without tension the energies are equal where the contact detaches
    if energy(least) > 0:
        depth = float(brentq(energy, least, 0, xtol=ROUNDING * delta0))
    state = minimise(scene, depth)
    return _pull((state.force, depth, state.half_width))


def _pull(state: Iterable[Any]) -> State:
    """The state of P, d and a, with a pull for a positive force."""
    force, depth, a = map(float, state)
    return State(-force or 0.0, depth, a)  # 0.0 and not -0.0


COLUMNS = Columns(
    "indenter -10|l/b 8.3g|γ₁ N/m 9.3g|F_A N/m 14.9g|closed form 14.9g|d µm 9.5g|a µm 9.5g|"
    "global F_A 14.9g|error 6.0e"
)


def line(shape: str, pull: Pull) -> str:
    """One line of the table."""
    scene = pull.scene
    state = pull.simulated
    depth = state.depth if abs(state.depth) > BAR * scene.critical_separation else 0.0
    a = state.half_width if state.half_width > BAR * loops.size(scene) else 0.0
    return COLUMNS.line(
        shape,
        pull.ratio,
        scene.gamma1,
        state.force,
        pull.closed_form.force,
        1e6 * depth,
        1e6 * a,
        pull.balanced and pull.balanced.force,
        pull.error,
    )


def plot(curves: Sequence[Curve]) -> Figure:
    """F_A over its value without tension, for all indenters over l/b."""
    drawn, axes = canvas(8, 5.5)
    for curve, colour, marker in zip(curves, COLOURS, MARKERS, strict=False):
        ratios = np.geomspace(curve.ratios[1], curve.ratios[-1], 200)
        scenes = [_scene(curve.shape, ratio) for ratio in ratios.tolist()]
        force = -np.array([loops.pull_off_card(scene).force for scene in scenes])
        axes.plot(ratios, force / curve.forces[0], color=colour, lw=1.2)
        axes.plot(curve.ratios[1:], curve.gain[1:], marker, color=colour, label=curve.shape)
    axes.plot([], [], color="black", lw=1.2, label="closed forms")
    axes.axhline(1, color=GREY, lw=0.8)
    axes.axvline(1, color=GREY, lw=0.8, ls=":")
    axes.set(xscale="log", ylabel="$F_A$ / $F_A(γ_1 = 0)$  (linear below 1, logarithmic above)")
    axes.set_xlabel("elastocapillary length over half-width at pull-off without tension, l/b")
    axes.set_yscale("symlog", linthresh=1)  # from 0 to 1 linear
    most = max(float(curve.gain.max()) for curve in curves)
    plain = (0, 0.5, 1, 2, 5, 10, 20, 50, 100, 200)
    ticks = [tick for tick in plain if tick <= 1.1 * most]
    axes.set_yticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    axes.set_ylim(-0.1, 1.3 * most)
    axes.set_title(
        "Tension strengthens the adhesion of punch and parabola, and ends that of the wedge"
    )
    axes.legend()
    axes.grid(alpha=0.25)
    return drawn


def table(curves: Sequence[Curve]) -> Table:
    """Columns and a row per scene, SI; `global_*` for the flat punch."""
    names = ["indenter", "l_over_b", "gamma1", "w", "force", "depth", "half_width"]
    names += [f"{name}_closed_form" for name in State._fields]
    names += ["global_force", "global_depth", "global_force_closed_form", "error"]
    rows = []
    for curve in curves:
        for pull in curve.pulls:
            scene = pull.scene
            row = [curve.shape, pull.ratio, scene.gamma1, scene.work_of_adhesion]
            row += [*pull.simulated, *pull.closed_form]
            if pull.balanced is None or pull.balanced_card is None:
                row += ["", "", ""]
            else:
                row += [pull.balanced.force, pull.balanced.depth, pull.balanced_card.force]
            rows.append([*row, pull.error])
    return names, rows


def conclusions(curves: Sequence[Curve]) -> list[str]:
    """What tension does to each indenter, in words that follow the numbers."""
    flat, wedge, parabola = curves
    balanced = np.array([pull.balanced.force for pull in flat.pulls if pull.balanced])
    part = balanced / flat.forces
    blunt = wedge.ratios < 1
    wide = parabola.ratios >= 1
    told = [
        f"w is fixed at {WORK:g} J/m²; l/b from {flat.ratios[1]:.3g} to {flat.ratios[-1]:.3g}",
        f"flat punch (paper: tension helps): {_effect(flat.forces, 1)}; Eq. (23) is the metastable "
        f"limit: the detached state has the lower energy from {part[0]:.4g} F_A on without "
        f"tension, from {part[-1]:.4g} F_A at the largest",
        f"wedge (paper: tension weakens), tan δ < α: {_effect(wedge.forces[blunt], -1)}; F_A falls "
        f"to {wedge.gain[blunt][-1]:.4g} of its value without tension at l/b = "
        f"{wedge.ratios[blunt][-1]:.3g}",
        f"parabola (paper: open): {_effect(parabola.forces)}",
    ]
    if wide.sum() > 1:
        grown = np.log(parabola.forces[-1] / parabola.forces[-2])
        rate = grown / np.log(parabola.ratios[-1] / parabola.ratios[-2]) / 2  # γ₁ ~ (l/b)²
        told[-1] += f"; for Λ >= 1 it closes to a point before it detaches, F_A ~ γ₁^{rate:.3f}"
    return told


def trend(values: Array, rounding: float = 1e-10) -> int:
    """1 if every value is above the one before, -1 if below, else 0.

    Parameters
    ----------
    values : ndarray (n,)
    rounding : float
        What a step has to exceed, of the largest value.

    Returns
    -------
    int
    """
    steps = np.diff(values) / np.abs(values).max()
    if np.all(steps > rounding):
        return 1
    if np.all(steps < -rounding):
        return -1
    return 0


def _effect(values: Array, claimed: int | None = None) -> str:
    """What the trend of forces says, and whether that is what the paper claims."""
    found = trend(values)
    known = {1: "helps at every step", -1: "weakens at every step", 0: "has no one sign"}
    told = f"tension {known[found]}"
    if claimed is None:
        return told
    return f"{told}: confirmed" if found == claimed else f"{told}: NOT confirmed"


def main(argv: Sequence[str] | None = None) -> int:
    """Run, conclude, draw, write; 1 if an error misses its bar."""
    preset, jobs, out = command.start("pull_off", __doc__, argv, "fewer tensions", FULL, QUICK)
    curves = run(preset, command.say, jobs)
    out.table("pull_off.csv", preset, *table(curves))
    out.figure("pull_off_gain.png", plot(curves))
    error = float(np.max([curve.error for curve in curves]))
    print("\n".join(["", *conclusions(curves), ""]))
    total = sum(len(curve.pulls) for curve in curves)
    judged = f"worst relative error {error:.1e} (limit {BAR:.0e})"
    print(f"{total} scenes, {judged}; written: {out.folder}")
    gains = ", ".join(f"{curve.gain[-1]:.3g} for the {curve.shape}" for curve in curves)
    last = curves[0].ratios[-1]
    over = "the pull-off force over that without tension is"
    command.answer(f"Both: at l = {last:.3g} b {over} {gains}.")
    return 0 if error <= BAR else 1
