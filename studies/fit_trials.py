"""The self-test of `fit`: synthetic curves with noise, fitted from a wrong start."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from discretization import load_path
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
from studies import fit_figure
from studies.fit_estimate import Fit, fit
from studies.fit_model import parameters_of, scene_with
from studies.force_curve import Curve

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
    names: tuple[str, ...] = ("w", "gamma1")
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
    interval: tuple[float, float]
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
    off = {"w": 1 / p.wrong, "gamma1": p.wrong, "stiffness": 1 / p.wrong}
    true = parameters_of(p.scene)
    return scene_with(
        p.scene, {n: v * off.get(n, 1) if n in p.names else v for n, v in true.items()}
    )


def run(p: Parameters, show: Callable[[str], object] = lambda line: None) -> Record:
    """All trials. ValueError for a scene that cannot be fitted; show gets the progress."""
    if p.trials < 1:
        raise ValueError(f"trials = {p.trials!r} must be at least 1: give the number of curves")
    curve, truth, start = clean_curve(p), _truth(p), wrong_start(p)
    rng, begun, trials = np.random.default_rng(p.seed), time.perf_counter(), []
    sigma = p.noise * float(np.abs(curve.force).max())
    for k in range(1, p.trials + 1):
        noisy = Curve(curve.depth, curve.force + sigma * rng.standard_normal(curve.force.size))
        found = fit(start, noisy, p.names, profiles=False)
        trials.append(tuple(_judged(p, found, i, truth) for i in range(len(p.names))))
        left = (time.perf_counter() - begun) / k * (p.trials - k)
        if k % 10 == 0 or k == p.trials:
            show(f"{k} of {p.trials} trials, {left:.0f} s to go")
    return Record(p, truth, tuple(trials))


def _judged(p: Parameters, found: Fit, i: int, truth: dict[str, float]) -> Trial:
    estimate, true = found.estimates[i], truth[p.names[i]]
    low, high = estimate.interval
    holds = low <= true <= high
    inside = found.inside_profile(i, true) if p.profile else holds
    return Trial(estimate.value, estimate.interval, holds, inside)


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


def report(p: Parameters, out: Path) -> int:
    """Run, print, draw; 1 if too few intervals hold the truth."""
    record = run(p, lambda text: print(text, flush=True))
    out.mkdir(parents=True, exist_ok=True)
    fit_figure.plot_trials(record).savefig(out / "fit_self_test.png", dpi=130)
    print(told(record))
    print(f"written: {out / 'fit_self_test.png'}")
    return 0 if record.passed else 1
