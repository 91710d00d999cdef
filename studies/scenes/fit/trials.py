"""The self-test of `fit`: synthetic curves with noise, fitted from a wrong start."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from discretization import load_path
from energy import Scene
from studies.scenes.fit import failures as fit_failures
from studies.scenes.fit import figure as fit_figure
from studies.scenes.fit.estimate import Fit, fit
from studies.scenes.fit.force_curve import Curve
from studies.scenes.fit.model import parameters_of, scene_with
from studies.scenes.fit.trial_record import NEEDED, Parameters, Record, Trial
from studies.shared.batches import Progress, each, tell
from studies.shared.command import Output
from studies.shared.types import Table


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
    found = fit(start, curve, p.names, profiles=False)
    return tuple(_judged(p, found, i, truth) for i in range(len(p.names)))


def _judged(p: Parameters, found: Fit, i: int, truth: dict[str, float]) -> Trial:
    estimate, true = found.estimates[i], truth[p.names[i]]
    low, high = estimate.interval or (math.inf, -math.inf)  # withheld: it holds nothing
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


def table(record: Record) -> Table:
    """Columns and a row per trial and parameter, SI."""
    rows = [
        [
            number,
            name,
            record.truth[name],
            one.value,
            *(one.interval or ("", "")),
            one.holds,
            one.profile_holds,
        ]
        for number, trial in enumerate(record.trials, 1)
        for name, one in zip(record.parameters.names, trial, strict=True)
    ]
    columns = ["trial", "parameter", "truth", "estimate", "low", "high"]
    return [*columns, "holds_truth", "profile_holds_truth"], rows


def report(p: Parameters, out: Output, jobs: int = 1) -> int:
    """Run, print, write; 1 if too few intervals hold the truth, or a failure is not called."""
    record = run(p, jobs=jobs)
    written = [out.table("fit_self_test.csv", p, *table(record))]
    written += out.figure("fit_self_test", fit_figure.plot_trials(record))
    print(told(record))
    failures = fit_failures.run(fit_failures.Parameters(p.scene, p.trials), jobs=jobs)
    rows = fit_failures.table(failures)
    written.append(out.table("fit_self_test_failures.csv", failures.parameters, *rows))
    print(fit_failures.told(failures))
    print(f"written: {', '.join(map(str, written))}")
    return 0 if record.passed and failures.passed else 1
