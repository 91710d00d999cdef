"""The figures of `applicability`: maps of the error of Eq. (16), and γ₁ alone varied."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from studies.applicability.record import TOLERANCES, Point, Record
from studies.shared import Array
from studies.shared.figures import COLOURS, MARKERS, Figure, canvas, plain_ticks, shades

FLOOR = 1e-4  # the darkest colour of the map
GONE: dict[str, Any] = {"facecolor": "white", "edgecolor": "#aaaaaa", "hatch": "///"}
LINES = (("a", "white", "-"), ("P", "black", "--"))


def grid(points: Sequence[Point], across: str) -> tuple[Array, Array, Array, Array]:
    """w/γ₁, the other coordinate, and |errors| of a and P as (other, w/γ₁) tables."""
    ratios = np.unique([point.ratio for point in points])
    other = np.unique([getattr(point, across) for point in points])
    tables = [
        np.reshape([abs(getattr(x.errors, name)) for x in points], (other.size, ratios.size))
        for name in ("half_width", "force")
    ]
    return ratios, other, tables[0], tables[1]


def worst_on_path(points: Sequence[Point], name: str) -> tuple[Array, Array]:
    """Steepness, and the largest |error| over all γ₁ at which the surface does not turn over."""
    steepness = np.unique([point.steepness for point in points])
    errors = [
        max(abs(getattr(x.errors, name)) for x in points if x.steepness == s and x.errors.exists)
        for s in steepness
    ]
    return steepness, np.array(errors)


def draw_maps(record: Record) -> Figure:
    """The larger of the errors of a and P in colour, lines of 1 % and 10 %; hatched: no state."""
    figure, panels = canvas(12.5, 5.2, 1, 3)
    for axes, (shape, points) in zip(panels, record.maps.items(), strict=True):
        across = "steepness" if shape in record.paths else "width"
        x, y, width, force = grid(points, across)
        worst = np.log10(np.maximum(np.maximum(width, force), FLOOR))
        levels = np.linspace(math.log10(FLOOR), 0, 17)
        colours = axes.contourf(x, y, worst, levels, cmap="cividis", extend="min")
        for table, (_, colour, style) in zip((width, force), LINES, strict=True):
            look = {"colors": colour, "linestyles": style, "linewidths": (1.0, 2.5)}
            if np.nanmax(table) > min(TOLERANCES):
                axes.contour(x, y, np.log10(table), np.log10(TOLERANCES), **look)
        axes.patch.set(**GONE)
        axes.set(xscale="log", yscale="log", xlim=(x[0], 2), ylim=(y[0], y[-1]), xlabel="w/γ₁")
        axes.set_title(shape + (" at a = l" if across == "steepness" else " about to detach"))
        axes.set_ylabel("steepness f'(a)" if across == "steepness" else "half-width a/l")
    for what, colour, style in LINES:
        for tolerance, size in zip(TOLERANCES, (1.0, 2.5), strict=True):
            label = f"{tolerance:.0%} error of {what}"
            panels[0].plot([], [], style, color=colour, lw=size, label=label)
    panels[0].fill_between([], [], label="turns over: no state", **GONE)
    figure.legend(loc="outside lower center", ncols=5, facecolor="#999999")
    bar = figure.colorbar(colours, ax=panels, label="larger relative error of a and P")
    bar.set_ticks([-4, -3, -2, -1, 0], labels=["$10^{-4}$", "$10^{-3}$", "1 %", "10 %", "100 %"])
    figure.suptitle("Eq. (16) against true surface lengths: good for blunt indenters and w ≪ γ₁")
    return figure


def draw_conjecture(record: Record) -> Figure:
    """Errors against γ₁/w for each steepness; the largest of them against the steepness."""
    figure, (*panels, last) = canvas(12.5, 4.8, 1, 3, sharey=True)
    for k, (axes, (shape, points)) in enumerate(zip(panels, record.paths.items(), strict=True)):
        steepness = sorted({point.steepness for point in points}, reverse=True)
        for s, colour in zip(steepness, shades(len(steepness)), strict=True):
            row = [x for x in points if x.steepness == s and x.errors.exists]
            tensions = [1 / x.ratio for x in row]
            for name, style in (("half_width", "-"), ("force", "--")):
                errors = [abs(getattr(x.errors, name)) for x in row]
                label = f"f'(a₀) = {s:g}" if style == "-" else None
                look = {"color": colour, "marker": MARKERS[steepness.index(s) % 8], "ms": 4}
                axes.loglog(tensions, errors, style, label=label, **look)
        axes.set(title=f"{shape}, only γ₁ varies, d = 0", xlabel="γ₁/w")
        plain_ticks(axes.xaxis, steps=(1.0,) if max(tensions) > 100 else (1.0, 3.0))
        axes.legend(fontsize=9, title="a solid, P dashed")
        for j, (name, style) in enumerate((("half_width", "-"), ("force", "--"))):
            label = f"{shape}, {'a' if j == 0 else 'P'}"
            marks = {"color": COLOURS[k], "marker": MARKERS[k], "label": label}
            last.loglog(*worst_on_path(points, name), style, **marks)
    for tolerance in (0.01, 0.1):
        last.axhline(tolerance, color="black", lw=0.8, ls=":")
    panels[0].set_ylabel("relative error of Eq. (16)")
    last.set(title="largest over all γ₁", xlabel="steepness f'(a₀)")
    plain_ticks(last.xaxis)
    last.legend()
    for axes in (*panels, last):
        axes.grid(alpha=0.25)
    figure.suptitle(
        "The conjecture that Eq. (16) serves for any γ₁ (Section 6) is right where the indenter is "
        "blunt: f'(a₀) ≪ 1"
    )
    return figure
