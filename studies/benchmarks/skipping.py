"""What does a scene that needs less than the general one save, and does that change a digit?

Every row of the table in `discretization` is measured in pairs: the call that skips, and a general
route to the same numbers on the same scene (the same profile declared without the attribute, a
vanishing γ₁ or slope, a search that is not needed, nodes instead of an exact far field). The factor
is the median of the ratios of their times, between its quartiles; next to it the largest difference
of a, P and U, relative to each, which must be rounding. Imports are timed in fresh interpreters.

Output: a line per row, skipping.csv, a figure. Exit status 1 if a digit changed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from studies.benchmarks.skipping_routes import ROUTES
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import BLUE, GREY, Figure, canvas
from studies.shared.table import Columns
from studies.shared.timing import interpreter_seconds, seconds

ROUNDING = 1e-12
IMPORTS = "cvxpy, matplotlib"
PLAIN = "import energy, discretization"


@dataclass(frozen=True)
class Parameters:
    """Pairs of calls, and of interpreters; seconds after which a row has enough pairs."""

    pairs: int = 41
    imports: int = 7
    patience: float = 4.0


QUICK = Parameters(pairs=5, imports=1, patience=0.3)


class Row(NamedTuple):
    """Seconds with the skip and by the general route; their ratio with its quartiles; what changed.

    difference: largest of a, P and U, relative; nan where there is nothing to compare.
    """

    name: str
    seconds: float
    general: float
    factor: float
    low: float
    high: float
    difference: float

    @property
    def same(self) -> bool:
        """Whether no digit changed but by rounding."""
        return not self.difference > ROUNDING


def difference(found: Sequence[float], general: Sequence[float]) -> float:
    """Largest relative difference of numbers that correspond."""
    one, other = np.asarray(found, float), np.asarray(general, float)
    size = np.abs(other)
    return float(np.max(np.abs(one - other) / np.where(size > 0, size, 1.0)))


def measure(parameters: Parameters, name: str) -> Row:
    """One row: calls of both routes in turn, the first not timed; imports in new interpreters."""
    pairs: list[tuple[float, float]] = []
    if name == IMPORTS:
        codes, changed = (PLAIN, f"{PLAIN}, cvxpy, matplotlib.figure"), float("nan")
        for _ in range(parameters.imports):
            pairs.append((interpreter_seconds(codes[0]), interpreter_seconds(codes[1])))
    else:
        skips, general = ROUTES[name]()
        changed = difference(skips(), general())
        while len(pairs) < parameters.pairs and np.sum(pairs) <= parameters.patience:
            pairs.append((seconds(skips), seconds(general)))
    one, other = np.transpose(pairs)
    low, middle, high = np.percentile(other / one, [25, 50, 75]).tolist()
    return Row(name, float(np.median(one)), float(np.median(other)), middle, low, high, changed)


def run(parameters: Parameters = Parameters(), show: Show = silent) -> list[Row]:
    """All rows; `show` gets a line for each."""
    show(COLUMNS.head)
    names = [*ROUTES, IMPORTS]
    return list(each(partial(measure, parameters), names, 1, say=lambda row: show(line(row))))


COLUMNS = Columns(
    "not needed -21|skipped ms 11.3g|general ms 11.3g|factor 8.3g|quartiles 13|difference 11.0e"
)


def line(row: Row) -> str:
    """One row on the screen."""
    times, spread = (1e3 * row.seconds, 1e3 * row.general), f"{row.low:.3g}..{row.high:.3g}"
    return COLUMNS.line(row.name, *times, row.factor, spread, row.difference)


def plot(rows: Sequence[Row]) -> Figure:
    """Factors as bars on a logarithmic axis, with their quartiles."""
    rows = sorted(rows, key=lambda row: row.factor)
    figure, axes = canvas(9, 1.4 + 0.32 * len(rows))
    at = np.arange(len(rows))
    factor, low, high = (np.array([getattr(r, n) for r in rows]) for n in ("factor", "low", "high"))
    spread = np.array([factor - low, high - factor])
    axes.barh(at, factor - 1, left=1, color=BLUE, xerr=spread, ecolor=GREY, capsize=3)
    axes.set(xscale="log", yticks=at, yticklabels=[row.name for row in rows])
    axes.set_ylabel("not needed")
    axes.set(xlabel="time of the general route / time of the call that skips it")
    axes.set_xlim(min(0.9, low.min()), 30 * high.max())  # room for the texts
    for height, row in enumerate(rows):
        changed = "" if np.isnan(row.difference) else f"  (Δ {row.difference:.0e})"
        text = f"  × {row.factor:.3g}{changed}"
        axes.text(max(row.high, row.factor), height, text, va="center", fontsize=8)
    axes.axvline(1, color="black", lw=0.8)
    axes.grid(alpha=0.25, axis="x")
    axes.set_axisbelow(True)
    axes.set_title("What is not needed is not done, and a, P, U change by rounding only (Δ)")
    return figure


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; 1 if a digit changed."""
    given = "skipping", __doc__, argv, "few pairs, under 10 s", Parameters(), QUICK
    parameters, _, out = command.start(*given)
    rows = run(parameters, command.say)
    out.table("skipping.csv", parameters, Row._fields, rows)
    out.figure("skipping.png", plot(rows))
    changed = [row.name for row in rows if not row.same]
    told = f"these change a digit: {', '.join(changed)}" if changed else "none changes a digit"
    factors = [row.factor for row in rows]
    command.answer(
        f"{len(rows)} things that may be left out save a factor of {min(factors):.3g} to "
        f"{max(factors):.3g} each; {told}."
    )
    return 1 if changed else 0
