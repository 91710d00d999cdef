"""The figure of `stress`: the fewest digits kept at each point of each grid."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from studies.benchmarks.stress.verdicts import BAD, NAMES, Trial
from studies.shared.figures import Figure, canvas, edges

PANELS = {  # title, x, y
    "fitted": ("fitted mesh, small slopes", "log₁₀ a/l", "log₁₀ w/γ₁"),
    "finite": ("fitted mesh, finite slopes", "log₁₀ a/l", "log₁₀ w/γ₁"),
    "lattice": ("lattice", "log₁₀ l/Δx", "log₁₀ a/l"),
    "edge": (
        "at the edge of detachment",
        "j: the depth is off by 10⁻ʲ of itself",
        "side of detachment",
    ),
    "profiles": (
        "profiles with several contacts",
        "log₁₀ unit of length in m",
        "profile, at two depths",
    ),
}
TICKS = {"edge": {-1: "beyond", 1: "before"}, "profiles": dict(enumerate(NAMES))}
MARKS = {"refused": ("o", 9.0), "lost or failed": ("X", 8.0)}


def plot(trials: Sequence[Trial], grids: Sequence[str]) -> Figure:
    """Fewest digits of a, P and U over each grid; crosses: lost or failed, rings: refused."""
    rows = math.ceil((len(grids) + 1) / 3)
    figure, grid = canvas(13, 4.3 * rows + 0.4, rows, 3, squeeze=False)
    panels = grid.ravel()
    for axes in panels[len(grids) :]:
        axes.set_axis_off()
    for axes, name in zip(panels, grids, strict=False):
        drawn = _draw(axes, [t for t in trials if t.grid == name])
        axes.set(**dict(zip(("title", "xlabel", "ylabel"), PANELS[name], strict=True)))
        if name in TICKS:
            axes.set_yticks([*TICKS[name]], [*TICKS[name].values()])
    style: dict[str, Any] = {"ls": "", "mfc": "none", "mec": "black"}
    key = panels[-1]
    for word, (marker, size) in MARKS.items():
        key.plot([], [], marker=marker, ms=size, label=word, **style)
    key.legend(loc="upper center")
    label = "digits kept (fewest of a, P, U); grey: nothing to compare"
    where = key.inset_axes((0.1, 0.35, 0.8, 0.12))
    figure.colorbar(drawn, cax=where, label=label, extend="min", orientation="horizontal")
    bad = sum(t.verdict not in ("ok", "refused") for t in trials)
    figure.suptitle(
        f"Digits at the ends of the range: of {len(trials)} points {bad} lose more than the "
        "problem itself does"
    )
    return figure


def _draw(axes: Any, own: Sequence[Trial]) -> Any:
    """Cells coloured by digits, marks on what was refused, lost or failed."""
    x, y = (np.unique([getattr(t, name) for t in own]) for name in "xy")
    digits = np.full((y.size, x.size), math.nan)
    for t in own:
        if not math.isnan(t.digits[0]):
            at = np.searchsorted(y, t.y), np.searchsorted(x, t.x)
            digits[at] = np.nanmin([*t.digits, digits[at], 16.0])
    drawn = axes.pcolormesh(edges(x), edges(y), digits, cmap="viridis", vmin=6, vmax=16)
    axes.set_facecolor("#dddddd")
    for word, (marker, size) in MARKS.items():
        verdicts = {"refused"} if word == "refused" else {*BAD}
        bad = [(t.x, t.y) for t in own if t.verdict in verdicts]
        if bad:
            axes.plot(
                *np.transpose(bad), marker, ls="", mec="black", ms=size, mfc="none", clip_on=False
            )
    return drawn
