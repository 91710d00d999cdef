"""Fits of many curves: a folder, or an instrument file with several; parameters in common.

Conventions:

- `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
- `prefixed(values, unit)` is the unit with a prefix that suits the values: they are divided by its
  `size`, and its `symbol` is written.
- `read_curve(name, reading)` reads a curve, `count` says how many an instrument file has.
- `sweep(job, points, path)` does the job at every point and keeps its results: a `Record`, whose
  `column(name)` has one of the results at all points, NaN where there is none.
- `scene_with(scene, changes)` changes parameters by name.
- `tell` shows the progress on stderr; `answer` says the last line.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from energy.arrays import Array
from energy.units import prefixed
from studies.scenes.curve_file import INSTRUMENT, NO_LOAD_PATH, Reading, count, read_curve
from studies.scenes.file import load
from studies.scenes.fit.estimate import UNITS, fit
from studies.scenes.fit.model import scene_with
from studies.scenes.sweep.store import Record
from studies.scenes.sweep.study import sweep, table
from studies.shared.batches import tell
from studies.shared.command import Output, answer
from studies.shared.figures import BLUE, Figure, canvas

NORMAL = 1.96  # standard deviations, of intervals at 95 %
CHANCE = 3.0  # standard deviations of χ²: more has a chance of 1 in 700, and is none
TEXT = (".csv", ".txt", ".dat", ".tsv", ".asc")


@dataclass(frozen=True)
class FittedFile:
    """The fit of one curve as a function of its name, in any process.

    Attributes
    ----------
    scene : Path
        Of the scene file.
    reading : Reading
        How the curves are written.
    names : tuple of str
        What is fitted.
    options : dict
        Keyword arguments of `fit`.
    fixed : tuple of (str, float)
        Parameters that are not fitted, in place of those of the scene.
    """

    scene: Path
    reading: Reading
    names: tuple[str, ...]
    options: dict[str, Any]
    fixed: tuple[tuple[str, float], ...] = ()

    def __call__(self, point: dict[str, Any]) -> dict[str, Any]:
        """Estimates with linearised intervals, whether the model fits, and the warnings."""
        name, _, number = str(point["curve"]).partition("#")
        reading = replace(self.reading, number=int(number)) if number else self.reading
        scene = scene_with(load(self.scene).scene, dict(self.fixed))
        curve = read_curve(name, reading)
        found = fit(scene, curve, self.names, profiles=False, **self.options)
        values = dict[str, Any]()
        for one in found.estimates:
            low, high = one.interval or (math.nan, math.nan)
            values |= {one.name: one.value, f"{one.name}_low": low, f"{one.name}_high": high}
        quality = {"fits": found.quality.fits, "residual_over_noise": found.quality.times}
        return values | quality | {"warnings": "; ".join(found.warnings)}

    def identity(self, names: Sequence[str]) -> Any:
        """What determines the numbers besides the names of the curves, as plain data."""
        files = sorted({name.partition("#")[0] for name in names})
        contents = [sha256(Path(file).read_bytes()).hexdigest() for file in files]
        text = self.scene.read_text("utf-8")
        return [text, repr(self.reading), self.names, self.options, self.fixed, contents]


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
    if not total:
        raise ValueError(f"{data}: holds no force-distance curve: {NO_LOAD_PATH}")
    return [str(data)] if total == 1 else [f"{data}#{i}" for i in range(1, total + 1)]


class Common(NamedTuple):
    """One value for all curves.

    Attributes
    ----------
    name : str
    value : float
    interval : (float, float)
        At 95 %.
    chance : float
        χ² of the deviations of the curves over its mean.
    curves : int
        How many have an interval.
    """

    name: str
    value: float
    interval: tuple[float, float]
    chance: float
    curves: int

    def __str__(self) -> str:
        """The value with its interval, and whether the curves agree with it.

        Of n curves that do, χ² over n - 1 has the mean 1 and the variance 2/(n - 1): they do not
        where it is more than CHANCE standard deviations above.
        """
        low, high = self.interval
        text = f"{self.name} = {self.value:.5g} [{low:.5g}, {high:.5g}] {UNITS[self.name]}"
        verdict = "consistent with one value for all"
        if self.chance > 1 + CHANCE * math.sqrt(2 / max(self.curves - 1, 1)):
            verdict = "WARNING: not consistent with one value for all"
        return f"{text} from {self.curves} curves, χ² per curve {self.chance:.2g}: {verdict}"


def common(name: str, low: Array, high: Array) -> Common:
    """The mean of the logarithms, weighted by the inverse variances, from intervals at 95 % (n,).

    nan: a curve without one. ValueError if none has one.
    """
    known = np.isfinite(low + high) & (low > 0) & (high > low)
    if not known.any():
        raise ValueError(f"shared = {name!r}: no curve has an interval of it; look at the table")
    lower = np.log(low[known])
    upper = np.log(high[known])
    middles = (lower + upper) / 2
    errors = (upper - lower) / (2 * NORMAL)
    weights = errors**-2
    mean = float(np.average(middles, weights=weights))
    half = NORMAL * float(np.sum(weights)) ** -0.5
    chance = float(np.sum(weights * (middles - mean) ** 2)) / max(middles.size - 1, 1)
    interval = math.exp(mean - half), math.exp(mean + half)
    return Common(name, math.exp(mean), interval, chance, middles.size)


def plot(record: Record, names: Sequence[str], title: str) -> Figure:
    """The distribution of each parameter over the curves that the model fits."""
    figure, panels = canvas(5.5 * len(names), 4.5, 1, len(names), squeeze=False)
    fits = record.column("fits") == 1
    for axes, name in zip(panels[0], names, strict=True):
        values = record.column(name)[fits]
        unit = prefixed(values, UNITS[name])
        median = float(np.median(values)) / unit.size
        axes.hist(values / unit.size, bins="auto", color=BLUE)
        axes.axvline(median, color="black", ls="--", label="median")
        axes.set(xlabel=f"{name} in {unit.symbol}", ylabel="curves")
        axes.yaxis.get_major_locator().set_params(integer=True)
        axes.legend()
    figure.suptitle(f"{title}: {fits.sum()} of {fits.size} curves", fontsize=12)
    return figure


def failures(record: Record, files: Sequence[str]) -> list[str]:
    """A line for each curve that could not be fitted or that the model does not describe."""
    lines = []
    for file, result in zip(files, record.results, strict=True):
        if "error" in result:
            reason = result["error"].partition(": ")[2].removeprefix(f"{file}: ")
            lines.append(f"{file}: not fitted: {reason}")
        elif not result["found"]["fits"]:
            lines.append(f"{file}: {result['found']['warnings'].partition(';')[0]}")
    return lines


def report(
    job: FittedFile,
    files: Sequence[str],
    shared: str | None,
    title: str,
    name: str,
    out: Output,
    jobs: int,
) -> int:
    """Fit all, print the medians, write table and figure; 1 if a curve failed or does not fit."""
    shown = [one for one in job.names if one != "offset"]
    if shared is not None and (shared not in shown or len(job.names) < 2):
        raise ValueError(f"shared = {shared!r} must be one of what is fitted: {', '.join(shown)}")

    def fitted(notes: Sequence[str] = ()) -> Record:
        """Fit all curves, or read the results of a run that was broken off, and write the table."""
        path = out.folder / f"{name}.jsonl"
        identity = job.identity(files)
        record = sweep(job, {"curve": files}, path, jobs=jobs, identity=identity, show=tell)
        written.append(out.table(f"{name}.csv", repr(job), *table(record), notes=notes))
        return record

    written: list[Path] = []
    record = fitted()
    if shared is not None:
        found = common(shared, *(record.column(f"{shared}_{end}") for end in ("low", "high")))
        print(found)
        shown.remove(shared)
        names = tuple(one for one in job.names if one != shared)
        job = replace(job, names=names, fixed=((shared, found.value),))
        name = f"{name}_shared_{shared}"
        record = fitted([str(found)])
    fits = record.column("fits") == 1
    for line in failures(record, files):
        print(line)
    if fits.any() and shown:
        for one in shown:
            low, middle, high = np.quantile(record.column(one)[fits], (0.16, 0.5, 0.84))
            median = f"{one}: median {middle:.4g} {UNITS[one]}"
            print(f"{median}, 68 % of curves in [{low:.4g}, {high:.4g}]")
        written += out.figure(f"{name}.png", plot(record, shown, title))
    print(f"written: {', '.join(map(str, written))}")
    answer(f"{int(fits.sum())} of {len(files)} curves are described by the model")
    return 0 if fits.all() else 1
