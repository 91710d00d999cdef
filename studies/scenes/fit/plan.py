"""Can w and γ₁ both be found with this sphere, layer and noise, and what would find them better?

A curve of the scene is simulated, from out of contact to the deepest depth of the file (or the
largest of its [path]) and back; the derivatives of its forces give the 95 % intervals that a fit
would find,

    p (1 ± t(n - m) σ √((JᵀJ)⁻¹)ᵢᵢ),

the offset of the depth and the line without contact being fitted, too. The same for other spheres,
springs, depths, layers and noises shows what to change. --checks simulated curves with noise are
fitted: their estimates must scatter as predicted. Output: SCENE_plan.csv. Exit status 1 if the
scatter of the checks exceeds the prediction by more than a factor 1.5.
"""

# Conventions:
# - `command.parser` has the options of all studies; `command.parse` gives them and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `command.answer` says the answer, in the last line of the screen.
# - `each(function, cases, jobs)` gives the values of a function for these cases in their order,
#   from several processes.
# - `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the
#   states at these values one after the other: a `History` with arrays `depth`, `force` (positive
#   where it presses), `half_width`; `events`, the jumps and other events in their order, each with
#   a kind, the states `before` and `after` it; `pull_off`, its most tensile state.
# - `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to
#   this depth, d positive into the layer.
# - A scene has `gamma1` γ₁, `work_of_adhesion` w and `critical_separation` δ₀ = √(2w/k).
# - `Circle(R)` is the true arc.
# - A `Model` has logarithms of the DEFAULT parameters, w, γ₁, and the offset as coordinates: at 0
#   `jacobian` gives the derivatives of the forces.
# - `conditioning` is its condition number, `spreads` are the standard deviations of the coordinates
#   for a unit of noise.
# - `simulated(scene, drive, K)` are the forces at positions of a machine. 1.96 standard deviations
#   make 95 %.

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from discretization import load_path, minimise
from energy import Circle, Parabola, Scene
from energy.checks import positive
from studies.scenes.file import load
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve, Data
from studies.scenes.fit.model import DEFAULT, Model
from studies.scenes.fit.search import conditioning, spreads
from studies.scenes.fit.trials import simulated
from studies.shared import command
from studies.shared.batches import each

DETERMINED = 0.2  # half-width of the interval, relatively, of a parameter that counts as determined
FACTOR = 1.5  # scatter over its prediction at most, for very many checks


@dataclass(frozen=True)
class Experiment:
    """What is to be measured.

    Attributes
    ----------
    scene : Scene
    noise : float
        Standard deviation of the force [N/m, or N around an axis].
    stiffness : float
        Of the spring of the machine, in units of force per depth.
    points : int
        On the way in, and as many on the way out.
    deepest : float
        Largest depth [m].
    """

    scene: Scene
    noise: float
    stiffness: float
    points: int
    deepest: float

    def curve(self, seed: int = 0) -> Curve:
        """In from out of contact, and out again; the free part is as long as the rest."""
        scene = self.scene
        deepest = self.deepest + minimise(scene, self.deepest).force / self.stiffness
        pull = load_path(scene, depths=[self.deepest, -9 * scene.critical_separation])
        detachment = pull.events[-1].before
        largest_pull = min(detachment.force, pull.pull_off.force)
        lowest = detachment.depth + largest_pull / self.stiffness
        start = lowest - max(0.7 * (deepest - lowest), 0.0)
        inwards = np.linspace(start, deepest, self.points)
        drive = np.concatenate([inwards, inwards[::-1]])
        error = self.noise * np.random.default_rng(seed).standard_normal(drive.size)
        force = simulated(scene, drive, self.stiffness) + error
        return Curve(drive - force / self.stiffness, force, self.stiffness)

    def predicted(self) -> tuple[float, float, float]:
        """Relative half-widths of the 95 % intervals of w and γ₁, and the condition."""
        model = Model.of(self.scene, DEFAULT, Data.of(self.curve()), 0.0)
        jacobian = model.jacobian(np.zeros(len(DEFAULT)))
        condition, _ = conditioning(jacobian, len(DEFAULT))
        w, gamma1 = (1.96 * self.noise * spreads(jacobian, len(DEFAULT))[:2]).tolist()
        return w, gamma1, condition


def changes(one: Experiment) -> dict[str, Experiment]:
    """The experiment, and what else might be done."""
    scene = one.scene
    body = one.scene.indenter
    layer = one.scene.layer
    found = {"as planned": one, "half the noise": replace(one, noise=one.noise / 2)}
    found["twice as deep"] = replace(one, deepest=2 * one.deepest)
    scenes = {
        "h / 2": replace(scene, layer=replace(layer, h=layer.h / 2)),
        "2 h": replace(scene, layer=replace(layer, h=2 * layer.h)),
    }
    if isinstance(body, Parabola | Circle):
        scenes["R / 3"] = replace(scene, indenter=replace(body, R=body.R / 3))
        scenes["3 R"] = replace(scene, indenter=replace(body, R=3 * body.R))
    found |= {name: replace(one, scene=other) for name, other in scenes.items()}
    if not math.isinf(one.stiffness):
        found["a spring 4 times as stiff"] = replace(one, stiffness=4 * one.stiffness)
    return found


def checked(one: Experiment, seed: int) -> tuple[float, float]:
    """Logarithms of w and γ₁ of a simulated curve over the truth."""
    found = fit(one.scene, one.curve(seed), profiles=False, alternatives=False)
    truth = one.scene.work_of_adhesion, one.scene.gamma1
    w, gamma1 = (math.log(found[n].value / t) for n, t in zip(DEFAULT, truth, strict=False))
    return w, gamma1


def main(argv: Sequence[str] | None = None) -> int:
    """Predict what a measurement would find; 1 if simulated fits scatter otherwise."""
    parser = command.parser("plan", __doc__, "5 checks")
    parser.add_argument("--scene", type=Path, required=True, metavar="FILE.toml")
    about = "standard deviation of the force: N around an axis, else N/m"
    parser.add_argument("--noise", type=float, required=True, metavar="FORCE", help=about)
    about = "of the cantilever in N/m, for a turned body; default: rigid"
    parser.add_argument("--spring-constant", type=float, metavar="N/m", help=about)
    about = "on the way in, and as many on the way out; default: 200"
    parser.add_argument("--points", type=int, default=200, metavar="COUNT", help=about)
    about = "simulated curves that are fitted; default: 20, quick 5"
    parser.add_argument("--checks", type=int, metavar="COUNT", help=about)
    options, out = command.parse(parser, argv)
    one = _planned(options)
    rows = []
    for name, other in changes(one).items():
        w, gamma1, condition = other.predicted()
        half_widths = {"w": w, "gamma1": gamma1}
        determined = [one for one, half in half_widths.items() if half <= DETERMINED]
        verdict = f"determines {' and '.join(determined) or 'neither'}"
        rows.append([name, w, gamma1, condition, verdict])
        shown = f"w ± {_percent(w)}   gamma1 ± {_percent(gamma1)}   {verdict}"
        command.say(f"{name:26s} {shown}")
    columns = ["change", "w", "gamma1", "condition", "verdict"]
    print(f"written: {out.table(f'{options.scene.stem}_plan.csv', vars(options), columns, rows)}")
    count = (5 if options.preset == "quick" else 20) if options.checks is None else options.checks
    if count < 2:
        command.answer(f"this experiment {rows[0][-1]} to {100 * DETERMINED:.0f} %")
        return 0
    found = list(each(partial(checked, one), range(1, count + 1), options.jobs))
    off = 1.96 * np.sqrt(np.mean(np.square(found), axis=0)) / np.array(rows[0][1:3], float)
    failed = bool((off > FACTOR * (1 + math.sqrt(2 / count))).any())
    scatter = f"{off[0]:.2g} (w) and {off[1]:.2g} (gamma1) times the prediction"
    verdict = "failed" if failed else "passed"
    command.answer(f"the scatter of {count} simulated fits is {scatter}: {verdict}")
    return int(failed)


def _percent(share: float) -> str:
    """A share with two digits, 8 characters wide: no interval is ± 0.0 %."""
    percent = 100 * share
    return f"{percent:6.0f} %" if percent >= 10 else f"{percent:#6.2g} %"


def _planned(options: argparse.Namespace) -> Experiment:
    """What the command line and the scene file say. ValueError for what cannot be measured."""
    positive("noise", options.noise)
    if options.spring_constant is not None:
        positive("spring-constant", options.spring_constant)
    if options.points < 20:
        raise ValueError(f"--points = {options.points!r} must be at least 20 on each way")
    given = load(options.scene)
    depths = given.programme.values if given.programme else given.depths
    if not depths.size or not depths.max() > 0:
        raise ValueError(f"{options.scene}: depth: the largest must be > 0; give one to press to")
    stiffness = options.spring_constant or math.inf
    return Experiment(given.scene, options.noise, stiffness, options.points, float(depths.max()))
