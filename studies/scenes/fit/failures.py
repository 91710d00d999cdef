"""The second half of the self-test of `fit`: is a model that does not fit called, and no other?

Curves of random scenes around the given one (w, γ₁ by a factor 2 to either side, the size of the
indenter likewise), with random noise, number of points and zero of the depth. "good": nothing is
wrong; "sign": the force is reversed; "zero": the zero of the depth is off by 0.2 to 0.6 δ₀ and not
fitted; "hysteresis": the contact opens with 2 to 5 times w, and only one w is fitted; "level": a
constant force of 0.08 to 0.2 of the largest is added. (Under a flat punch hysteresis is no failure:
its line is pinned, so that one w describes the whole curve.)
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from discretization import load_path
from energy import Parabola, Scene, SurfaceEnergies, Wedge
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve
from studies.scenes.fit.model import DEFAULT, astray, parameters_of, scene_with
from studies.scenes.fit.quality import Quality
from studies.shared.batches import Progress, each, tell
from studies.shared.table import Table

KINDS = ("good", "sign", "zero", "hysteresis", "level")
MISTAKEN = 0.05  # of the good curves may be called
SPREAD = math.log(2.0)


@dataclass(frozen=True)
class Parameters:
    """The scene varied, curves of each kind, how far off the search starts, as a factor.

    noise: least and largest standard deviation over the largest force; steps: least and largest
    number per branch; deepest: in units of δ₀.
    """

    scene: Scene
    curves: int = 100
    wrong: float = 1.5
    noise: tuple[float, float] = (0.002, 0.03)
    steps: tuple[int, int] = (20, 80)
    deepest: float = 1.1
    seed: int = 5


class Case(NamedTuple):
    """A curve, from where its fit starts and what is fitted."""

    curve: Curve
    start: Scene
    names: tuple[str, ...]


class Outcome(NamedTuple):
    """Kind, number, quality of the fit, and whether it was called no fit."""

    kind: str
    number: int
    quality: Quality
    called: bool


@dataclass(frozen=True)
class Record:
    """The outcomes, `curves` of each of KINDS."""

    parameters: Parameters
    outcomes: tuple[Outcome, ...]

    def called(self, kind: str) -> int:
        """Number of curves of a kind that were called."""
        return sum(one.called for one in self.outcomes if one.kind == kind)

    @property
    def passed(self) -> bool:
        """Whether all the failures are called, and hardly any of the good curves."""
        every = all(self.called(kind) == self.parameters.curves for kind in KINDS[1:])
        return every and self.called("good") <= MISTAKEN * self.parameters.curves


def run(p: Parameters, show: Callable[[Progress], object] = tell, jobs: int = 1) -> Record:
    """All curves, in `jobs` processes; ValueError for a scene that cannot be fitted."""
    if p.curves < 1:
        raise ValueError(f"trials = {p.curves!r} must be at least 1: give the number of curves")
    cases = [(kind, number) for number in range(1, p.curves + 1) for kind in KINDS]
    return Record(p, tuple(each(partial(_outcome, p), cases, jobs, show)))


def _outcome(p: Parameters, which: tuple[str, int]) -> Outcome:
    curve, start, names = case(p, *which)
    quality = fit(start, curve, names, profiles=False).quality
    return Outcome(*which, quality, not quality.fits)


def case(p: Parameters, kind: str, number: int) -> Case:
    """A random curve of a kind; the same for the same number and seed."""
    rng = np.random.default_rng([p.seed, KINDS.index(kind), number])
    scene = _varied(p.scene, rng)
    rise, opened = scene.critical_separation, scene
    if kind == "hysteresis":
        work = scene.work_of_adhesion * rng.uniform(2, 5)
        opened = replace(scene, opening=SurfaceEnergies.from_work(scene.gamma1, work))
    steps, far = int(rng.integers(*p.steps)), 1.1 * opened.opened.critical_separation
    down = np.linspace(-far, p.deepest * rise, steps)
    depth = np.concatenate([down, down[::-1]])
    force = load_path(opened, depths=depth).force
    share = math.exp(rng.uniform(*np.log(p.noise)))
    largest = float(np.abs(force).max())
    force = force + share * largest * rng.standard_normal(force.size)
    zero = rng.choice([-1.0, 1.0]) * (rng.uniform(0.2, 0.6) if kind == "zero" else 0.1)
    if kind == "level":
        force = force + rng.choice([-1.0, 1.0]) * rng.uniform(0.08, 0.2) * largest
    curve = Curve(depth + zero * rise, -force if kind == "sign" else force)
    names = tuple(n for n in DEFAULT if n != "offset") if kind == "zero" else DEFAULT
    return Case(curve, astray(scene, names, p.wrong), names)


def _varied(scene: Scene, rng: np.random.Generator) -> Scene:
    """The scene with w, γ₁ and the size of a parabola or wedge changed by random factors."""
    factors = np.exp(rng.uniform(-SPREAD, SPREAD, 3)).tolist()
    true, body = parameters_of(scene), scene.indenter
    if isinstance(body, Parabola):
        scene = replace(scene, indenter=Parabola(body.R * factors[2]))
    elif isinstance(body, Wedge):
        slope = min(math.tan(body.delta) * factors[2], 10.0)
        scene = replace(scene, indenter=Wedge(math.atan(slope)))
    changed = {"w": true["w"] * factors[0], "gamma1": true["gamma1"] * factors[1], "opening": 0.0}
    return scene_with(scene, true | changed)


def told(record: Record) -> str:
    """A line per kind."""
    count = record.parameters.curves
    lines = [f"{count} random curves of each kind; how many are called not to fit"]
    for kind in KINDS:
        times = [one.quality.times for one in record.outcomes if one.kind == kind]
        low, high = min(times), max(times)
        needed = f"at most {MISTAKEN * count:g}" if kind == "good" else "all"
        text = f"{kind:12s}{record.called(kind):>6d}   needed: {needed}"
        lines.append(f"{text}; residual {low:.2g} to {high:.2g} times the noise")
    return "\n".join(lines)


def table(record: Record) -> Table:
    """Columns and a row per curve."""
    rows = [[one.kind, one.number, *one.quality, one.called] for one in record.outcomes]
    return ["kind", "curve", "residual_over_noise", "runs", "zero", "called"], rows
