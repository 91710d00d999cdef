"""The figure of `stress`: digits kept minus digits expected at each point of each grid.

Conventions:

- `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
- A `Trial` is a point (x, y) of a grid with the digits that it keeps of a, P and U; its `margin` is
  digits kept less those expected, its `excess` the largest error over rounding or, of random
  scenes, over its estimate.
- BAD are the verdicts that fail, NAMES the odd profiles.
- `edges` are those of cells around middles.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from studies.benchmarks.stress.verdicts import BAD, NAMES, Trial
from studies.shared.figures import BLUE, GREY, ORANGE, Figure, canvas, edges

PANELS = {  # title, x, y
    "fitted": ("fitted mesh, small slopes", "log₁₀ a/l", "log₁₀ w/γ₁"),
    "finite": ("fitted mesh, finite slopes", "log₁₀ a/l", "log₁₀ w/γ₁"),
    "lattice": ("lattice", "log₁₀ l/Δx", "log₁₀ a/l"),
    "edge": (
        "at the edge of detachment",
        "j: the depth is 10⁻ʲ δ₀ from detachment",
        "side of detachment",
    ),
    "profiles": (
        "odd profiles",
        "log₁₀ unit of length in m",
        "profile, at two depths",
    ),
}
SCATTERED = {"random": ("fitted mesh", "o", BLUE), "nodes": ("lattice", "^", ORANGE)}
TICKS = {"edge": {-1: "beyond", 1: "before"}, "profiles": dict(enumerate(NAMES))}
MARKS = {"refused": ("o", 9.0), "lost or failed": ("X", 8.0)}  # matplotlib's marker, size in points
LEAST = 1e-4  # of an error over its estimate, drawn
MOST = 4.0  # digits more than expected: 16 where 12 are
LOST = "#b00020"  # fewer digits than expected


def plot(trials: Sequence[Trial], grids: Sequence[str]) -> Figure:
    """Digits kept minus digits expected over each grid; crosses: lost or failed, rings: refused."""
    maps = [name for name in grids if name not in SCATTERED]
    scattered = [name for name in grids if name in SCATTERED]
    count = len(maps) + bool(scattered)
    rows = math.ceil(count / 3)
    figure, grid = canvas(13, 4.3 * rows + 0.8, rows, min(count, 3), squeeze=False)
    panels = grid.ravel()
    for axes, name in zip(panels, maps, strict=False):
        drawn = _draw(axes, [t for t in trials if t.grid == name])
        axes.set(**dict(zip(("title", "xlabel", "ylabel"), PANELS[name], strict=True)))
        if name in TICKS:
            axes.set_yticks([*TICKS[name]], [*TICKS[name].values()])
    if scattered:
        _scatter(panels[len(maps)], trials, scattered)
    for axes in panels[count:]:
        axes.set_axis_off()
    if maps:
        label = (
            "digits kept minus digits expected, the least of a, P, U (red: fewer than expected; "
            "grey: nothing to compare)"
        )
        shown = panels.tolist()
        figure.colorbar(drawn, ax=shown, label=label, extend="min", location="bottom", aspect=50)
        style: dict[str, Any] = {"ls": "", "mfc": "none", "mec": "black"}
        for word, (marker, size) in MARKS.items():
            panels[0].plot([], [], marker=marker, ms=size, label=word, **style)
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower right", ncols=2)
    bad = sum(t.verdict in BAD for t in trials)
    figure.suptitle(
        f"Digits at the ends of the range: of {len(trials)} points {bad} keep fewer than expected "
        "(12, or what the problem's own condition leaves of them)"
    )
    return figure


def _scatter(axes: Any, trials: Sequence[Trial], grids: Sequence[str]) -> None:
    """Errors of random scenes over their estimates, which may be ten times too small."""
    for name in grids:
        label, marker, colour = SCATTERED[name]
        own = [t for t in trials if t.grid == name and not math.isnan(t.digits[0])]
        errors = [10 ** -min(t.digits) for t in own]
        ratios = [max(t.excess, LEAST) for t in own]
        axes.loglog(errors, ratios, marker, color=colour, ms=4, alpha=0.6, label=label)
    axes.axhline(10, color="black", ls="--", lw=1, label="limit")
    axes.axhline(1, color=GREY, lw=0.8)
    axes.set(title="random scenes", xlabel="largest relative error of a, P and U")
    axes.set(ylabel="largest error over its estimate", ylim=(LEAST / 3, 100))
    axes.legend(loc="lower right", fontsize=9)


def _draw(axes: Any, own: Sequence[Trial]) -> Any:
    """Cells coloured by their margin, marks on what was refused, lost or failed."""
    from matplotlib import colormaps

    x = np.unique([t.x for t in own])
    y = np.unique([t.y for t in own])
    margins = np.full((y.size, x.size), math.nan)
    for t in own:
        if not math.isnan(t.margin):
            at = np.searchsorted(y, t.y), np.searchsorted(x, t.x)
            margins[at] = np.nanmin([t.margin, margins[at], MOST])
    colours = colormaps["viridis"].with_extremes(under=LOST)
    drawn = axes.pcolormesh(edges(x), edges(y), margins, cmap=colours, vmin=0, vmax=MOST)
    axes.set_facecolor("#dddddd")
    for word, (marker, size) in MARKS.items():
        verdicts = {"refused"} if word == "refused" else {*BAD}
        bad = [(t.x, t.y) for t in own if t.verdict in verdicts]
        if bad:
            axes.plot(
                *np.transpose(bad), marker, ls="", mec="black", ms=size, mfc="none", clip_on=False
            )
    return drawn
