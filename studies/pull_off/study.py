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

Output: the table with errors, the conclusions, pull_off.csv, figures. Exit status 1 if an error
exceeds 1e-8.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import brentq

from discretization import load_path, minimise
from energy import Scene
from studies.pull_off import figures as pull_off_figures
from studies.pull_off.conclusions import conclusions
from studies.pull_off.record import Curve, Pull, State
from studies.shared import command, loops
from studies.shared.batches import Show, each, silent
from studies.shared.figures import Figure
from studies.shared.loops import INDENTERS, LAYER, SIZE
from studies.shared.table import Columns, Table

BAR = 1e-8


@dataclass(frozen=True)
class Parameters:
    """l/b of the scenes; 0 is added: no tension."""

    ratios: tuple[float, ...] = (*np.geomspace(0.01, 100, 25).tolist(), 0.82, 0.92, 0.97)


FULL = Parameters()
QUICK = Parameters(ratios=(0.03, 0.3, 0.8, 1.7, 4.0))


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> tuple[Curve, ...]:
    """Pull every scene off in `jobs` processes; `show` gets a line for each."""
    show(COLUMNS.head)
    cases = list(product(INDENTERS, (0.0, *sorted(parameters.ratios))))
    pulls: dict[str, list[Pull]] = {shape: [] for shape in INDENTERS}
    for (shape, _), pull in zip(cases, each(pulled, cases, jobs), strict=True):
        pulls[shape].append(pull)
        show(line(shape, pull))
    return tuple(Curve(shape, tuple(own)) for shape, own in pulls.items())


def pulled(case: tuple[str, float]) -> Pull:
    """Indenter, l/b: press to 2δ₀ under a dead load, then lower it until the contact detaches."""
    shape, ratio = case
    scene = loops.scene_of(shape, LAYER.stiffness * (ratio * SIZE) ** 2)
    pressed = minimise(scene, 2 * scene.critical_separation).force
    path = load_path(scene, forces=[pressed, -3 * loops.force_scale(scene)])
    flat = shape == "flat punch"
    return Pull(
        scene,
        ratio,
        _pull(loops.most_tensile(path)),
        _pull(loops.pull_off_card(scene)),
        balanced(scene) if flat else None,
        _pull(loops.global_pull_off(scene)) if flat else None,
    )


def balanced(scene: Scene) -> State:
    """Where the adhered energy U(d) passes that of the detached surface, 0 (Maxwell)."""

    def energy(depth: float) -> float:
        return minimise(scene, depth).energy

    lift = scene.critical_separation
    least = -(1 - 1e-14) * lift
    depth = least if energy(least) <= 0 else float(brentq(energy, least, 0, xtol=1e-15 * lift))
    state = minimise(scene, depth)
    return _pull((state.force, depth, state.half_width))


def _pull(state: Iterable[Any]) -> State:
    """Of P, d and a: a pull is positive."""
    force, depth, a = map(float, state)
    return State(-force or 0.0, depth, a)


COLUMNS = Columns(
    "indenter -10|l/b 8.3g|γ₁ N/m 9.3g|F_A N/m 14.9g|closed form 14.9g|d µm 9.5g|a µm 9.5g|"
    "global F_A 14.9g|error 6.0e"
)


def line(shape: str, pull: Pull) -> str:
    """One line of the table."""
    scene, state = pull.scene, pull.simulated
    depth = state.depth if abs(state.depth) > BAR * scene.critical_separation else 0.0
    a = state.half_width if state.half_width > BAR * loops.size(scene) else 0.0
    numbers = pull.ratio, scene.gamma1, state.force, pull.closed_form.force, 1e6 * depth, 1e6 * a
    return COLUMNS.line(shape, *numbers, pull.balanced and pull.balanced.force, pull.error)


def plot(curves: Sequence[Curve]) -> dict[str, Figure]:
    """The figures by file name."""
    return {
        "pull_off.png": pull_off_figures.forces(curves),
        "pull_off_gain.png": pull_off_figures.gain(curves),
        "pull_off_maxwell.png": pull_off_figures.maxwell(curves[0]),
    }


def table(curves: Sequence[Curve]) -> Table:
    """Columns and a row per scene, SI; `global_*` for the flat punch."""
    names = ["indenter", "l_over_b", "gamma1", "w", "force", "depth", "half_width"]
    names += [f"{name}_closed_form" for name in State._fields]
    names += ["global_force", "global_depth", "global_force_closed_form", "error"]
    rows = []
    for curve in curves:
        for pull in curve.pulls:
            given = (curve.shape, pull.ratio, pull.scene.gamma1, pull.scene.work_of_adhesion)
            other: tuple[float | str, ...] = ("", "", "")
            if pull.balanced is not None and pull.balanced_card is not None:
                other = (*pull.balanced[:2], pull.balanced_card.force)
            rows.append([*given, *pull.simulated, *pull.closed_form, *other, pull.error])
    return names, rows


def main(argv: Sequence[str] | None = None) -> int:
    """Run, conclude, draw, write; 1 if an error misses its bar."""
    quick = "fewer tensions"
    preset, jobs, out = command.start("pull_off", __doc__, argv, quick, FULL, QUICK)
    curves = run(preset, command.say, jobs)
    out.table("pull_off.csv", preset, *table(curves))
    out.figures(plot(curves))
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
