"""Fits of many curves: a folder, or an instrument file with several; parameters in common."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from energy.units import prefixed
from studies.scenes.curve_file import INSTRUMENT, Reading, count, read_curve
from studies.scenes.file import load
from studies.scenes.fit.estimate import UNITS, Fit, fit
from studies.scenes.fit.model import NAMES, parameters_of, scene_with
from studies.scenes.sweep.store import Record
from studies.scenes.sweep.study import sweep
from studies.scenes.sweep.study import table as swept
from studies.shared.batches import tell
from studies.shared.command import Output
from studies.shared.figures import BLUE, GREY, ORANGE, Figure, canvas

TEXT = (".csv", ".txt", ".dat", ".tsv", ".asc")


@dataclass(frozen=True)
class FittedFile:
    """The fit of one curve as a function of its name, in any process.

    fixed: parameters that are not fitted, in place of those of the scene.
    """

    scene: Path
    reading: Reading
    names: tuple[str, ...]
    alternatives: bool
    fixed: tuple[tuple[str, float], ...] = ()

    def __call__(self, point: dict[str, Any]) -> dict[str, Any]:
        """Estimates with linearised intervals, the verdict and what is warned of."""
        name, _, number = str(point["curve"]).partition("#")
        reading = replace(self.reading, number=int(number)) if number else self.reading
        scene = load(self.scene).scene
        scene = scene_with(scene, parameters_of(scene) | dict(self.fixed))
        curve = read_curve(Path(name), reading)
        return row(fit(scene, curve, self.names, profiles=False, alternatives=self.alternatives))

    def identity(self) -> Any:
        """What determines the numbers besides the curves, as plain data."""
        text = self.scene.read_text("utf-8")
        return [text, repr(self.reading), self.names, self.alternatives, self.fixed]


def row(found: Fit) -> dict[str, Any]:
    """A fit as numbers and texts."""
    values: dict[str, Any] = {}
    for one in found.estimates:
        low, high = one.interval or (math.nan, math.nan)
        values |= {one.name: one.value, f"{one.name}_low": low, f"{one.name}_high": high}
    doubts = [one.told for one in found.alternatives if one.doubtful]
    quality = {"fits": found.quality.fits, "residual_over_noise": found.quality.times}
    return values | quality | {"warnings": "; ".join(found.warnings), "doubted": bool(doubts)}


def curves(data: Path, reading: Reading) -> list[str]:
    """The curves of a folder, of an instrument file ("name#number"), or the file itself."""
    if data.is_dir():
        known = (*TEXT, *INSTRUMENT)
        files = sorted(path for path in data.iterdir() if path.suffix.lower() in known)
        if not files:
            raise ValueError(f"{data}: holds no curves; their names end in {', '.join(known)}")
        return [name for path in files for name in curves(path, reading)]
    several = data.suffix.lower() in INSTRUMENT and reading.number is None
    total = count(data) if several else 1
    return [str(data)] if total == 1 else [f"{data}#{i}" for i in range(1, total + 1)]


@dataclass(frozen=True)
class Common:
    """One value for all curves: mean of the logarithms weighted by what each curve tells.

    chance: χ² of their deviations over its mean; far above 1 they do not have it in common.
    """

    name: str
    logs: np.ndarray
    errors: np.ndarray

    @cached_property
    def value(self) -> float:
        """The parameter."""
        return math.exp(float(np.average(self.logs, weights=self.errors**-2)))

    @property
    def interval(self) -> tuple[float, float]:
        """At 95 %."""
        reach = 1.96 * float(np.sum(self.errors**-2)) ** -0.5
        return self.value * math.exp(-reach), self.value * math.exp(reach)

    @property
    def chance(self) -> float:
        """χ² over its degrees of freedom."""
        off = (self.logs - math.log(self.value)) / self.errors
        return float(off @ off) / max(off.size - 1, 1)

    def __str__(self) -> str:
        low, high = self.interval
        text = f"{self.name} = {self.value:.5g} [{low:.5g}, {high:.5g}] {UNITS[self.name]}"
        verdict = "they may have it in common"
        if self.chance > 1 + 3 * math.sqrt(2 / max(self.logs.size - 1, 1)):
            verdict = "WARNING: they do not have it in common"
        return f"{text} from {self.logs.size} curves, χ² per curve {self.chance:.2g}: {verdict}"


def common(record: Record, name: str) -> Common:
    """From the curves whose fits have an interval. ValueError if there are none."""
    value, low, high = (record.column(f"{name}{end}") for end in ("", "_low", "_high"))
    with np.errstate(divide="ignore", invalid="ignore"):
        logs, errors = np.log(value), np.log(high / low) / (2 * 1.96)
    known = np.isfinite(logs + errors) & (errors > 0)
    if not known.any():
        raise ValueError(f"shared = {name!r}: no curve has an interval of it; look at the table")
    return Common(name, logs[known], errors[known])


def plot(record: Record, names: Sequence[str], title: str) -> Figure:
    """The distribution of each parameter, and its value curve by curve with the interval."""
    figure, panels = canvas(11, 3.6 * len(names), len(names), 2, squeeze=False)
    for (left, right), name in zip(panels, names, strict=True):
        value, low, high = (record.column(f"{name}{end}") for end in ("", "_low", "_high"))
        fits = np.isfinite(low)
        unit = prefixed(value[fits], UNITS[name].partition("/")[0])
        symbol = unit.symbol + UNITS[name][1:]
        label, at = f"{name} in {symbol}", np.arange(1, value.size + 1)
        left.hist(value[fits] / unit.size, bins="auto", color=BLUE)
        left.set(xlabel=label, ylabel="curves")
        spread = np.maximum([(value - low)[fits], (high - value)[fits]], 0) / unit.size
        style = {"fmt": "o", "ms": 3, "color": BLUE, "capsize": 2, "label": "fits"}
        right.errorbar(at[fits], value[fits] / unit.size, spread, **style)
        inside = value[~fits] / unit.size
        right.plot(at[~fits], inside, "x", color=ORANGE, label="no interval")
        right.axhline(float(np.median(value[fits])) / unit.size, color=GREY, lw=0.8)
        right.set(xlabel="number of the curve", ylabel=label)
        right.legend()
    figure.suptitle(title, fontsize=12)
    return figure


def report(
    job: FittedFile,
    files: Sequence[str],
    shared: str | None,
    title: str,
    data: Path,
    out: Output,
    jobs: int,
) -> int:
    """Fit all, tell the medians, write table and figure; 1 if a curve failed or does not fit."""
    if shared is not None and (shared not in job.names or shared == "offset" or len(job.names) < 2):
        known = ", ".join(name for name in NAMES if name in job.names and name != "offset")
        raise ValueError(f"shared = {shared!r} must be one of what is fitted: {known}")
    name, written = f"{data.stem}_fits", []
    record = _swept(job, files, out.folder / f"{name}.jsonl", jobs)
    written.append(out.table(f"{name}.csv", repr(job), *swept(record)))
    if shared is not None:
        found = common(record, shared)
        print(found)
        names = tuple(one for one in job.names if one != shared)
        job = replace(job, names=names, fixed=((shared, found.value),))
        name = f"{name}_shared_{shared}"
        record = _swept(job, files, out.folder / f"{name}.jsonl", jobs)
        written.append(out.table(f"{name}.csv", repr(job), *swept(record), notes=[str(found)]))
    fits = record.column("fits") == 1
    print(f"{int(fits.sum())} of {len(files)} curves are described by the model")
    shown = [one for one in job.names if one != "offset"]
    for one in shown:
        if fits.any():
            low, middle, high = np.quantile(record.column(one)[fits], (0.16, 0.5, 0.84))
            print(
                f"{one}: median {middle:.4g} {UNITS[one]}, "
                f"68 % of curves in [{low:.4g}, {high:.4g}]"
            )
    if fits.any() and shown:
        written += out.figure(f"{name}.png", plot(record, shown, title))
    print(f"written: {', '.join(map(str, written))}")
    return 0 if fits.all() else 1


def _swept(job: FittedFile, files: Sequence[str], path: Path, jobs: int) -> Record:
    return sweep(job, {"curve": files}, path, jobs=jobs, identity=job.identity(), show=tell)
