"""The self-test of `fit`: synthetic curves with noise, fitted from a wrong start."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from discretization import load_path
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
from studies.scenes.fit import failures as fit_failures
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve
from studies.scenes.fit.model import DEFAULT, astray, parameters_of
from studies.shared.batches import Progress, each, tell
from studies.shared.command import Output
from studies.shared.table import Table

NEEDED = 0.9  # of the intervals hold the truth
SCENE = Scene(  # a very soft film, whose tension is felt: l = 43 µm, a(0) = 140 µm, δ₀ = 0.32 µm
    ElasticLayer(E=50.0, nu=0.45, h=5e-6),
    SurfaceEnergies.from_work(gamma1=0.07, w=2e-6),
    Parabola(R=0.05),
)


@dataclass(frozen=True)
class Parameters:
    """Scene with the true parameters, what is fitted, trials, steps per branch, noise, start.

    noise: standard deviation over the largest force; wrong: how far off the search starts, as a
    factor; reach: the curve goes from -reach to reach times δ₀; offset: true, in units of δ₀.
    """

    scene: Scene = SCENE
    names: tuple[str, ...] = DEFAULT
    trials: int = 100
    steps: int = 40
    noise: float = 0.01
    wrong: float = 1.5
    reach: float = 1.1
    offset: float = 0.05
    profile: bool = True
    seed: int = 11


class Trial(NamedTuple):
    """One estimate, its linearised interval, and whether that and the profile hold the truth."""

    value: float
    interval: tuple[float, float] | None
    holds: bool
    profile_holds: bool


@dataclass(frozen=True)
class Record:
    """Trials, each a tuple over the parameters fitted, and the truth by name."""

    parameters: Parameters
    truth: dict[str, float]
    trials: tuple[tuple[Trial, ...], ...]

    def share(self, i: int) -> tuple[float, float]:
        """Of trials whose interval of parameter i holds the truth: linearised, profile."""
        held = [(trial[i].holds, trial[i].profile_holds) for trial in self.trials]
        linear, profile = np.mean(held, axis=0).tolist()
        return linear, profile

    @property
    def passed(self) -> bool:
        """Whether every share is enough, of linearised and of profile intervals."""
        return all(min(self.share(i)) >= NEEDED for i in range(len(self.parameters.names)))


def clean_curve(p: Parameters) -> Curve:
    """The simulated curve without noise, its depths off by the true offset if that is fitted."""
    far = p.reach * p.scene.critical_separation
    depths = np.concatenate([np.linspace(-far, far, p.steps), np.linspace(far, -far, p.steps)])
    force = load_path(p.scene, depths=depths).force
    return Curve(depths + _truth(p)["offset"], force)


def _truth(p: Parameters) -> dict[str, float]:
    shift = p.offset * p.scene.critical_separation if "offset" in p.names else 0.0
    return parameters_of(p.scene) | {"offset": shift}


def wrong_start(p: Parameters) -> Scene:
    """The scene with the fitted parameters off by a factor, w downwards and γ₁ upwards."""
    return astray(p.scene, p.names, p.wrong)


def run(p: Parameters, show: Callable[[Progress], object] = tell, jobs: int = 1) -> Record:
    """All trials, in `jobs` processes; ValueError for a scene that cannot be fitted."""
    if p.trials < 1:
        raise ValueError(f"trials = {p.trials!r} must be at least 1: give the number of curves")
    curve, truth, start = clean_curve(p), _truth(p), wrong_start(p)
    rng, sigma = np.random.default_rng(p.seed), p.noise * float(np.abs(curve.force).max())
    noise = sigma * rng.standard_normal((p.trials, curve.force.size))
    noisy = [Curve(curve.depth, curve.force + own) for own in noise]
    return Record(p, truth, tuple(each(partial(_tried, p, start, truth), noisy, jobs, show)))


def _tried(p: Parameters, start: Scene, truth: dict[str, float], curve: Curve) -> tuple[Trial, ...]:
    found, trials = fit(start, curve, p.names, profiles=False), []
    for i, one in enumerate(found.estimates):
        low, high = one.interval or (math.inf, -math.inf)  # withheld: it holds nothing
        holds = low <= truth[one.name] <= high
        inside = found.inside_profile(i, truth[one.name]) if p.profile else holds
        trials.append(Trial(one.value, one.interval, holds, inside))
    return tuple(trials)


def told(record: Record) -> str:
    """A line per parameter."""
    p = record.parameters
    lines = [
        f"{'parameter':12s}{'truth':>12s}{'mean':>12s}{'spread':>10s}{'linearised':>12s}{'profile':>10s}"
    ]
    for i, name in enumerate(p.names):
        values, true = np.array([trial[i].value for trial in record.trials]), record.truth[name]
        spread = float(values.std()) / abs(true) if true else math.nan
        linear, profile = record.share(i)
        text = f"{name:12s}{true:>12.5g}{values.mean():>12.5g}{spread:>10.1%}"
        lines.append(f"{text}{linear:>12.0%}{profile:>10.0%}")
    count = f"{len(record.trials)} curves; share of the 95 % intervals that hold the truth"
    return "\n".join([count, *lines, f"needed: {NEEDED:.0%}"])


def table(record: Record) -> Table:
    """Columns and a row per trial and parameter, SI."""
    rows = [
        [number, name, record.truth[name], one.value, *(one.interval or ("", "")), *one[2:]]
        for number, trial in enumerate(record.trials, 1)
        for name, one in zip(record.parameters.names, trial, strict=True)
    ]
    columns = ["trial", "parameter", "truth", "estimate", "low", "high"]
    return [*columns, "holds_truth", "profile_holds_truth"], rows


def report(p: Parameters, out: Output, jobs: int = 1) -> int:
    """Run, print, write; 1 if too few intervals hold the truth, or a failure is not called."""
    record = run(p, jobs=jobs)
    written = [out.table("fit_self_test.csv", p, *table(record))]
    print(told(record))
    failures = fit_failures.run(fit_failures.Parameters(p.scene, p.trials), jobs=jobs)
    rows = fit_failures.table(failures)
    written.append(out.table("fit_self_test_failures.csv", failures.parameters, *rows))
    print(fit_failures.told(failures))
    print(f"written: {', '.join(map(str, written))}")
    return 0 if record.passed and failures.passed else 1
