"""Table, CSV and figures of runtime_vs_error."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from studies.benchmarks.runtime_record import Floor, Point
from studies.shared.figures import COLOURS, Figure, canvas, plain_ticks
from studies.shared.types import Table

QUANTITIES = ("half-width a", "force P", "energy U", "angle θ")
MARKERS = "osD^v<>phX*"
LEAST = 1e-16
LEVELS = (1e-4, 1e-6, 1e-8, 1e-10)
COMMAND = "python -m studies runtime_vs_error"


def machine() -> str:
    """What it ran on, in one line."""
    name = platform.processor() or platform.machine()
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
        names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
        name = names[0] if names else name
    threads = os.environ.get("OMP_NUM_THREADS", "as many as BLAS takes")
    versions = f"Python {platform.python_version()}, numpy {np.__version__}"
    return f"{name}, {os.cpu_count()} cores, threads: {threads}; {versions}"


def rows(points: Sequence[Point], floors: Sequence[Floor]) -> Table:
    """Columns and a row per point, then the floors."""
    names = ["error_half_width", "error_force", "error_energy", "error_angle"]
    head = ["task", "method", "size", "unknowns", "modelling_seconds", "first_seconds"]
    found: list[list[object]] = [[*p[:9], *p.errors, p.success, p.note] for p in points]
    for floor in floors:
        n, blank = floor.unknowns, ["", 1.0, *[""] * 4, True, ""]
        found.append(["floor", "dptsv", n, n, "", "", floor.dptsv, *blank])
        found.append(["floor", "one pass", n, n, "", "", floor.one_pass, *blank])
    return [*head, "seconds", "spread", "ratio_to_dptsv", *names, "success", "note"], found


def table(points: Sequence[Point], floors: Sequence[Floor], exponents: dict[str, float]) -> str:
    """Everything measured, in Markdown."""
    lines = [f"`{COMMAND}` on {machine()}", ""]
    for task in dict.fromkeys(p.task for p in points):
        lines += [f"### {task}", "", HEAD, RULE]
        lines += [_row(p) for p in points if p.task == task] + [""]
    for task in dict.fromkeys(p.task for p in points if p.task != "rough"):
        told = "time to an error of a, and times our fastest"
        lines += [f"### {task}: {told}", "", levels([p for p in points if p.task == task]), ""]
    lines += ["### floors", "", "| n | dptsv ms | one pass ms |", "| --- | --- | --- |"]
    lines += [f"| {f.unknowns} | {f.dptsv * 1e3:.4g} | {f.one_pass * 1e3:.4g} |" for f in floors]
    lines += ["", "Cost exponents (time over unknowns):", ""]
    lines += [f"- {name}: {value:.2f}" for name, value in exponents.items()]
    return "\n".join(lines) + "\n"


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
    known = [reached(points, level) for level in LEVELS]
    ours = [min((p.seconds for m, p in f.items() if m[:4] == "ours"), default=0) for f in known]
    lines = ["| method | " + " | ".join(f"a to {level:.0e}" for level in LEVELS) + " |"]
    lines.append("| --- " * (len(LEVELS) + 1) + "|")
    for method in dict.fromkeys(p.method for p in points if not p.note):
        own = [(f.get(method), least) for f, least in zip(known, ours, strict=True)]
        cells = [_reached(p, least) for p, least in own]
        lines.append(f"| {method} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _reached(point: Point | None, least: float) -> str:
    if point is None:
        return "never"
    times = f", × {point.seconds / least:.3g}" if least and point.seconds > least else ""
    return f"{point.seconds * 1e3:.3g} ms{times}"


HEAD = (
    "| method | size or rtol | solve ms | spread | first ms | modelling ms | × dptsv "
    "| err a | err P | err U | err θ | success |"
)
RULE = "| --- " * 12 + "|"


def _row(p: Point) -> str:
    if p.note:
        return f"| {p.method} | {p.size:g} | {p.note} |" + " |" * 9
    cells = [f"{p.size:g}", f"{p.seconds * 1e3:.3g}", f"{p.spread:.0%}", f"{p.first * 1e3:.3g}"]
    cells += [f"{p.modelling * 1e3:.3g}", f"{p.ratio:.3g}"]
    cells += ["—" if np.isnan(e) else f"{e:.0e}" for e in p.errors]
    return " | ".join([f"| {p.method}", *cells, "yes |" if p.success else "NO |"])


def plot(task: str, points: Sequence[Point], floors: Sequence[Floor]) -> Figure:
    """Time against each error, a line per method; open symbols: it says it failed."""
    shown = [p for p in points if not p.note and np.isfinite(p.seconds)]
    known = [q for q in range(4) if any(np.isfinite(p.errors[q]) for p in shown)] or [0]
    rows = (len(known) + 1) // 2
    columns = min(2, len(known))
    figure, grid = canvas(13, 1 + 4 * rows, rows, columns, sharey=True, squeeze=False)
    panels = grid.ravel()
    for axes in panels[len(known) :]:
        axes.set_visible(False)
    for quantity, axes in zip(known, panels, strict=False):
        for number, method in enumerate(dict.fromkeys(p.method for p in shown)):
            own = [p for p in shown if p.method == method and np.isfinite(p.errors[quantity])]
            _draw(axes, own, quantity, number, method)
        for floor in floors:
            for seconds, style in ((floor.dptsv, "--"), (floor.one_pass, ":")):
                axes.axhline(seconds, color="0.6", lw=0.8, ls=style, zorder=0)
            place = {"xycoords": ("axes fraction", "data"), "fontsize": 7, "color": "0.35"}
            text = f"dptsv, n = {floor.unknowns:g}"
            axes.annotate(text, (0.99, floor.dptsv), ha="right", va="bottom", **place)
        axes.set(xscale="log", yscale="log", xlabel=f"relative error of {QUANTITIES[quantity]}")
        axes.grid(alpha=0.25)
        axes.set_xlim(LEAST / 3, max(axes.get_xlim()[1], 100 * LEAST))
    for axes in panels[::2]:
        axes.set_ylabel("time of one step" if task == "loop" else "time")
    plain_ticks(panels[0].yaxis, "s", (1.0,))
    handles, labels = max((a.get_legend_handles_labels() for a in panels), key=lambda h: len(h[0]))
    figure.legend(handles, labels, loc="outside lower center", fontsize=8, ncols=5)
    figure.suptitle(f"{task}: lower left is better; dashed: one dptsv, dotted: one pass over n")
    return figure


def _draw(axes: Any, own: Sequence[Point], quantity: int, number: int, method: str) -> None:
    ours, colour = method.startswith("ours"), COLOURS[number % len(COLOURS)]
    errors = [max(p.errors[quantity], LEAST) for p in own]
    seconds = [p.seconds for p in own]
    half = np.array([p.spread / 2 for p in own])
    spread = np.array(seconds) * [half / (1 + half), half]  # by a factor: the axis is logarithmic
    axes.errorbar(
        errors,
        seconds,
        yerr=spread,
        marker=MARKERS[number % len(MARKERS)],
        ms=7 if ours else 5,
        lw=2.2 if ours else 1,
        color=colour,
        label=method,
    )
    failed = [(e, p.seconds) for e, p in zip(errors, own, strict=True) if not p.success]
    if failed:
        axes.plot(*np.transpose(failed), "o", ms=11, mfc="none", mec="black")
