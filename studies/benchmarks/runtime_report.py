"""What runtime_vs_error records: its table, CSV and figures.

Conventions:

- A `Table` is the names of its columns, and its rows.
- `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
- `plain_ticks` labels a logarithmic axis with plain numbers.
"""

from __future__ import annotations

import os
import platform
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from studies.shared.figures import BLUE, COLOURS, ORANGE, Figure, canvas, plain_ticks
from studies.shared.table import Table, markdown
from studies.shared.timing import blas_threads

MARKERS = "D^v<>phX*Pd8H"
OURS = {"default": ("o", BLUE), "lattice": ("s", ORANGE), "one by one": ("X", BLUE)}
WIDTH_OF_TITLE = 8.2  # inches that the title of the figure needs, which one panel has not
LEAST = 1e-16  # relative errors that are less, 0 among them, are drawn here
TITLES = {
    "nonadhesive": "a state without adhesion",
    "adhesive": "a state with adhesion",
    "finite": "a state with steep surfaces",
    "loop": "one step of a loop",
    "many": "one of many states",
    "rough loop": "one step of a loop over a rough profile",
    "rough": "the lowest state of a rough profile",
}
LEVELS = (1e-4, 1e-6, 1e-8, 1e-10)  # errors for which the table names the fastest method
COMMAND = "python -m studies runtime_vs_error"


class Point(NamedTuple):
    """One method on one task at one size.

    Attributes
    ----------
    task, method : str
    size : float
        Number of nodes, or a tolerance.
    unknowns : int
    modelling : float
        Time of preparing [s].
    first : float
        Time of the first call [s], which may fill caches.
    seconds : float
        Median time of further calls [s], of one step in a loop.
    spread : float
        Interquartile range of these over the median.
    ratio : float
        Median over the time of LAPACK's dptsv with as many unknowns.
    errors : tuple of four floats
        Relative, of a, P, U and θ.
    success : bool
        As the method claims.
    note : str
        Why there is no answer; "" if there is one.
    """

    task: str
    method: str
    size: float
    unknowns: int
    modelling: float
    first: float
    seconds: float
    spread: float
    ratio: float
    errors: tuple[float, float, float, float]
    success: bool
    note: str = ""

    @classmethod
    def failed(cls, task: str, method: str, size: float, note: str) -> Point:
        """Nothing measured."""
        none = float("nan")
        return cls(task, method, size, 0, *(none,) * 5, (none,) * 4, False, note)

    @property
    def ours(self) -> bool:
        """Whether it is a method of this package."""
        return self.method.startswith("ours")


def machine() -> str:
    """What it ran on, in one line."""
    name = platform.processor() or platform.machine()
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
        names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
        name = names[0] if names else name
    versions = f"Python {platform.python_version()}, numpy {np.__version__}"
    return f"{name}, {os.cpu_count()} cores, {blas_threads()} of BLAS; {versions}"


def rows(points: Sequence[Point], floors: dict[int, float]) -> Table:
    """Columns and a row per point, then the floors."""
    names = ["error_half_width", "error_force", "error_energy", "error_angle"]
    head = ["task", "method", "size", "unknowns", "modelling_seconds", "first_seconds"]
    found: list[list[object]] = [[*p[:9], *p.errors, p.success, p.note] for p in points]
    for n, seconds in floors.items():
        found.append(["floor", "dptsv", n, n, "", "", seconds, "", 1.0, *[""] * 4, True, ""])
    return [*head, "seconds", "spread", "ratio_to_dptsv", *names, "success", "note"], found


def table(points: Sequence[Point]) -> str:
    """The least times to an error, of each task in which that of a is known, in Markdown."""
    lines = [f"`{COMMAND}` on {machine()}", ""]
    for task in dict.fromkeys(p.task for p in points):
        own = [p for p in points if p.task == task]
        told = fastest([p for p in own if not p.note])
        shown = levels(own) if not task.startswith("rough") else f"{told[:1].upper()}{told[1:]}."
        lines += [f"### {TITLES[task]}", "", shown, ""]
    return "\n".join(lines)


def reached(points: Sequence[Point], level: float) -> dict[str, Point]:
    """The fastest point of each method that claims success with an error of a up to `level`."""
    found: dict[str, Point] = {}
    for p in points:
        good = not p.note and p.success and p.errors[0] <= level
        if good and (p.method not in found or p.seconds < found[p.method].seconds):
            found[p.method] = p
    return found


def levels(points: Sequence[Point]) -> str:
    """Time to a given error of a, over that of our fastest method, of one task; in Markdown."""
    methods = dict.fromkeys(p.method for p in points if not p.note)
    cells: dict[str, list[str]] = {method: [] for method in methods}
    for level in LEVELS:
        best = reached(points, level)
        ours = min((p.seconds for p in best.values() if p.ours), default=0)
        for method in methods:
            cells[method].append(_time(best.get(method), ours))
    head = ["method", *(f"a to {level:.0e}" for level in LEVELS)]
    return markdown(head, [[method, *times] for method, times in cells.items()])


def _time(point: Point | None, ours: float) -> str:
    """A time in ms, and how many times our fastest it is where that is less and not 0."""
    if point is None:
        return "never"
    milliseconds = f"{point.seconds * 1e3:.3g} ms"
    if not ours or point.seconds <= ours:
        return milliseconds
    return f"{milliseconds}, × {point.seconds / ours:.3g}"


def family(method: str) -> str:
    """What a method is drawn as: ours by where the unknowns are, those of others by their name."""
    kinds = {
        "by hand": "one line by hand",
        "ours, load_path on": "ours, lattice",
        "ours, load_path": "ours, default",
        "ours, shortest": "ours, lattice",
    }
    return next((kind for word, kind in kinds.items() if word in method), method)


def curves(points: Sequence[Point]) -> list[Point]:
    """Those of tasks of which a method has been timed at two sizes or more: one point is no curve.

    The table has all of them.
    """
    timed = [p for p in points if not p.note and np.isfinite(p.seconds)]
    counts = Counter((p.task, p.method) for p in timed)
    drawn = {task for (task, _), count in counts.items() if count > 1}
    return [p for p in timed if p.task in drawn]


def plot(points: Sequence[Point], floors: dict[int, float]) -> Figure:
    """Time against the error of a of each task, or where there is none against the size.

    A ring: the method says that it failed.
    """
    shown = curves(points)
    tasks = [*dict.fromkeys(p.task for p in shown)]
    kinds = [*dict.fromkeys(family(p.method) for p in shown)]
    columns = max(1, min(3, len(tasks)))
    rows = -(-len(tasks) // columns)
    width = max(WIDTH_OF_TITLE, 0.8 + 3.9 * columns)
    height = 1.6 + 3.4 * rows
    figure, grid = canvas(width, height, rows, columns, sharey=True, squeeze=False)
    panels = grid.ravel()
    for axes in panels[len(tasks) :]:
        axes.set_axis_off()
    for task, axes in zip(tasks, panels, strict=False):
        _panel(axes, [p for p in shown if p.task == task], kinds)
        for seconds in floors.values():
            axes.axhline(seconds, color="0.6", lw=0.8, ls="--", zorder=0)
    for axes in panels[::columns]:
        axes.set_ylabel("time of one answer")
    plain_ticks(panels[0].yaxis, "s", (1.0,))
    for number, kind in enumerate(kinds):
        panels[0].plot([], [], label=kind, **_style(kind, number))
    sizes = ", ".join(f"{n:g}" for n in floors)
    solve = f"one tridiagonal solve, {sizes} unknowns"
    panels[0].plot([], [], "--", color="0.6", lw=0.8, label=solve)
    figure.legend(loc="outside lower center", fontsize=9, ncols=min(len(kinds) + 1, 3))
    figure.suptitle(
        "Time for a given error of the half-width, here and with what a user could take instead"
    )
    return figure


def _panel(axes: Any, own: Sequence[Point], kinds: Sequence[str]) -> None:
    """One task: a curve for each method."""
    known = any(np.isfinite(p.errors[0]) for p in own)
    for method in dict.fromkeys(p.method for p in own):
        style = _style(family(method), kinds.index(family(method)))
        _draw(axes, [p for p in own if p.method == method], known, style)
    axes.set(xscale="log", yscale="log", title=TITLES[own[0].task])
    axes.set_xlabel("relative error of the half-width a" if known else "number of nodes")
    if known:
        axes.set_xlim(LEAST / 3, max(axes.get_xlim()[1], 100 * LEAST))
    else:
        low, high = axes.get_xlim()
        plain_ticks(axes.xaxis, steps=(1.0, 3.0) if high > 10 * low else (1.0, 2.0, 5.0))
    axes.grid(alpha=0.25)


def fastest(points: Sequence[Point]) -> str:
    """Our fastest method and the fastest of others, to an error of a where that is known."""
    found = reached(points, 1e-6)
    known = "a to 1e-06: "
    if not found:  # each at its least size
        found = {p.method: p for p in sorted(points, key=lambda p: -p.unknowns)}
        known = ""
    said = []
    for ours in (True, False):
        side = [p for p in found.values() if p.ours == ours]
        if not side:
            continue
        best = min(side, key=lambda p: p.seconds)
        nodes = "" if known else f" with {best.unknowns} nodes"
        said.append(f"{best.seconds * 1e3:.3g} ms by {best.method}{nodes}")
    return known + ", ".join(said)


def _style(kind: str, number: int) -> dict[str, Any]:
    """How a kind of methods is drawn: no two of other authors alike, ours larger."""
    for name, (marker, colour) in OURS.items():
        if kind.startswith("ours") and name in kind:
            return {"marker": marker, "color": colour, "ms": 7, "lw": 2.2}
    others = [colour for colour in COLOURS if colour not in (BLUE, ORANGE)]
    marker = MARKERS[number % len(MARKERS)]
    return {"marker": marker, "color": others[number % len(others)], "ms": 6, "lw": 1}


def _draw(axes: Any, own: Sequence[Point], known: bool, style: dict[str, Any]) -> None:
    """One method: its times over the errors of a, or over the nodes."""
    errors = [max(p.errors[0], LEAST) for p in own]
    x = errors if known else [p.unknowns for p in own]
    seconds = np.array([p.seconds for p in own])
    half = np.array([p.spread / 2 for p in own])
    # from t/(1 + s/2) to t (1 + s/2): a factor either way, as the axis is logarithmic
    below = seconds * (half / (1 + half))
    above = seconds * half
    axes.errorbar(x, seconds, yerr=[below, above], **style)
    for place, point in zip(x, own, strict=True):
        if not point.success:
            axes.plot(place, point.seconds, "o", ms=11, mfc="none", mec="black")
