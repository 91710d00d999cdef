"""Figures of the study `hysteresis`: loops over tension and control, and one looked at closely."""

from typing import Any

import numpy as np

from discretization import History
from discretization.plots import draw_path, units
from energy import cards
from energy.units import quantity as quantity_of
from studies.hysteresis.record import Loop, Record
from studies.shared import Array, loops
from studies.shared.figures import BLUE, Figure, canvas
from studies.shared.loops import INDENTERS, SIZE, WORK


def plot(record: Record, history: History) -> dict[str, Figure]:
    """Every figure by file name; `history`: the parabola's loop to look at closely."""
    gamma1 = quantity_of(history.scene.gamma1, "N/m")
    title = f"Parabola, γ₁ = {gamma1}: in contact loading and unloading coincide"
    return {
        "hysteresis_control.png": over_control(record),
        "hysteresis_loop.png": history.plot(title, closed_form(history)),
    }


def _grid(rows: int, height: float) -> tuple[Figure, Any]:
    return canvas(12.5, height, rows, len(INDENTERS), squeeze=False)


def _own(record: Record, shape: str) -> list[Loop]:
    """The loops of a shape at w = WORK."""
    own = [loop for loop in record.loops if loop.shape == shape]
    return [loop for loop in own if loop.history.scene.work_of_adhesion == WORK]


def over_control(record: Record) -> Figure:
    """P(d) of one γ₁, a row for each control, each loop in a panel of its own."""
    tensions = {loop.history.scene.gamma1 for loop in record.loops}
    gamma1 = min(tensions, key=lambda one: abs(one - 0.02))
    chosen = [
        [loop for loop in _own(record, shape) if loop.history.scene.gamma1 == gamma1]
        for shape in INDENTERS
    ]
    drawn, grid = _grid(len(chosen[0]), 3.4 * len(chosen[0]))
    for column, shape, own in zip(grid.T, INDENTERS, chosen, strict=True):
        for axes, loop in zip(column, own, strict=True):
            area = loop.history.dissipated / (2 * WORK * SIZE)
            draw_path(axes, loop.history, "force", units(loop.history, "force"), BLUE)
            words = {"depth": "imposed depth", "force": "dead load"}
            stiffness = loop.control.removeprefix("K = ").replace(" ", "·")
            held = words.get(loop.control, f"spring of stiffness {stiffness}")
            axes.set_title(f"{shape}, {held},\nloop area {area:.3g}·2wb", fontsize=10)
            axes.axhline(0, color="black", lw=0.6, ls=":")
            axes.grid(alpha=0.25)
    drawn.suptitle(
        "What holds the indenter decides where it jumps (dashed) and how much energy that costs; "
        f"γ₁ = {quantity_of(gamma1, 'N/m')}, b = {quantity_of(SIZE, 'm')}"
    )
    return drawn


def closed_form(history: History) -> tuple[Array, Array, Array]:
    """(d, P, a) of a parabola's whole branch."""
    scene = history.scene
    given = loops.arguments(scene)
    d = np.linspace(-scene.critical_separation, float(history.depth.max()), 400)
    force, a = cards.parabola.force(d, **given), cards.parabola.half_width(d, **given)
    return d, np.asarray(force), np.asarray(a)
