"""The figure of `stress`: the fewest digits kept at each point of each grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from studies.benchmarks.stress.profiles import NAMES
from studies.benchmarks.stress.verdicts import Trial
from studies.shared.figures import Figure, canvas

LABELS = {
    "fitted": ("log₁₀ a/l", "log₁₀ w/γ₁"),
    "finite": ("log₁₀ a/l", "log₁₀ w/γ₁"),
    "lattice": ("log₁₀ l/Δx", "log₁₀ a/l"),
    "edge": ("j: 10⁻ʲ of the depth away", "side of letting go"),
    "profiles": ("log₁₀ unit of length in m", "profile, at two depths"),
}
TICKS = {"edge": {-1: "beyond", 1: "before"}, "profiles": dict(enumerate(NAMES))}
MARKS = {"refused": ("o", 9.0), "lost or failed": ("X", 8.0)}


def plot(trials: Sequence[Trial], grids: Sequence[str]) -> Figure:
    """Fewest digits of a, P and U over each grid; crosses: lost or failed, rings: refused."""
    columns = min(3, len(grids))
    rows = math.ceil(len(grids) / columns)
    figure, grid = canvas(4.6 * columns + 1, 4.3 * rows + 0.4, rows, columns, squeeze=False)
    panels = grid.ravel()
    for axes, name in zip(panels, grids, strict=False):
        drawn = _draw(axes, [t for t in trials if t.grid == name])
        axes.set(xlabel=LABELS[name][0], ylabel=LABELS[name][1], title=name)
        if name in TICKS:
            axes.set_yticks([*TICKS[name]], [*TICKS[name].values()])
    for axes in panels[len(grids) :]:
        axes.set_visible(False)
    style: dict[str, Any] = {"ls": "", "mfc": "none", "mec": "black"}
    for word, (marker, size) in MARKS.items():
        panels[0].plot([], [], marker=marker, ms=size, label=word, **style)
    figure.legend(loc="outside lower center", ncols=2)
    label = "digits kept (fewest of a, P, U)"
    figure.colorbar(drawn, ax=list(panels), label=label, extend="min")
    return figure


def _draw(axes: Any, own: Sequence[Trial]) -> Any:
    """Squares coloured by digits, marks on what was refused, lost or failed."""
    best: dict[tuple[float, float], float] = {}
    for t in own:
        if not math.isnan(t.digits[0]):
            best[t.x, t.y] = min(*t.digits, best.get((t.x, t.y), 16.0))
    x, y = np.array([*best]).reshape(-1, 2).T
    style: dict[str, Any] = {"marker": "s", "s": 110, "cmap": "viridis", "vmin": 6, "vmax": 16}
    drawn = axes.scatter(x, y, c=[*best.values()], **style)
    for word, (marker, size) in MARKS.items():
        bad = [(t.x, t.y) for t in own if _mark(t.verdict) == word]
        if bad:
            axes.plot(*np.transpose(bad), marker, ls="", mec="black", ms=size, mfc="none")
    axes.margins(0.08)
    return drawn


def _mark(verdict: str) -> str:
    return verdict if verdict in ("ok", "refused") else "lost or failed"
