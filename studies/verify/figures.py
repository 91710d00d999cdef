"""The figures of `verify`, drawn from its curves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from energy.units import prefixed
from studies.shared.figures import BLUE, COLOURS, LINE, MARKERS, ORANGE, Figure, canvas
from studies.verify.curves import Branch, Meniscus

LAYER, BASE, BODY = "#d9d9d9", "#7f7f7f", "#bcd4e6"


def punch_and_meniscus(data: Meniscus) -> Figure:
    """The paper's Fig. 2: punch, layer on its base, meniscus; the meniscus enlarged below."""
    figure, (whole, close) = canvas(8, 7, 2, 1, height_ratios=(1.25, 1))
    unit = prefixed(data.scene.layer.h, "m")
    drawn = data.scaled(unit.size)
    _draw_bodies(whole, drawn, data.scene.layer.h / unit.size)
    _draw_dimensions(whole, drawn, data.scene.layer.h / unit.size, unit.symbol)
    whole.set_title("Flat punch pulled upward, just before it detaches (heights stretched)")
    right = drawn.x >= 0.8 * drawn.half_width
    x, top = drawn.x[right], -drawn.u[right]
    close.fill_between(x, top, 0.15 * drawn.depth, color=LAYER)
    close.plot(x, top, color=BLUE, lw=3, label="simulated surface")
    close.plot(x, -drawn.closed_form[right], "--", color=ORANGE, label="Eq. (21)")
    close.axvline(drawn.half_width, color=BASE, lw=0.8, ls=":", label="edge of the punch")
    error = np.max(np.abs(data.u - data.closed_form)) / abs(data.depth)
    close.set_title(f"Meniscus at the right edge; largest difference {error:.1e} $|d_c|$")
    close.set(xlim=(x[0], x[-1]), ylim=(0.15 * drawn.depth, -1.1 * drawn.depth))
    for axes in (whole, close):
        axes.set(xlabel=f"x in {unit.symbol}", ylabel=f"height in {unit.symbol}")
    close.legend()
    return figure


def _draw_bodies(axes: Any, data: Meniscus, h: float) -> None:
    """Base, layer with the simulated surface on top, punch; closed form dashed."""
    x, top, a, face = data.x, -data.u, data.half_width, -data.depth
    axes.fill_between(x, -1.35 * h, -h, color=BASE)
    axes.fill_between(x, -h, top, color=LAYER, label="layer")
    axes.fill_between([-a, a], face, face + 0.7 * h, facecolor=BODY, edgecolor=BASE, label="punch")
    axes.plot(x, top, color=BLUE, lw=2.5, label="simulated surface")
    axes.plot(x, -data.closed_form, "--", color=ORANGE, label="Eq. (21)")
    axes.axhline(0, color="black", lw=0.7, ls=":")
    axes.text(0, -1.18 * h, "rigid base", ha="center", va="center", color="white", weight="bold")
    axes.set(xlim=(x[0], x[-1]), ylim=(-1.35 * h, 1.3 * h))
    axes.legend(loc="upper right", fontsize=9)


def _draw_dimensions(axes: Any, data: Meniscus, h: float, unit: str) -> None:
    """a, h, d_c and the direction of the pull."""
    a, face = data.half_width, -data.depth
    both, one = {"arrowstyle": "<->"}, {"arrowstyle": "-|>", "lw": 2.0, "color": "black"}
    axes.annotate("", (0, face + 0.2 * h), (a, face + 0.2 * h), arrowprops=both)
    axes.text(a / 2, face + 0.24 * h, f"a = {a:.0f} {unit}", ha="center", va="bottom")
    axes.annotate("", (-0.8 * a, -h), (-0.8 * a, 0), arrowprops=both)
    axes.text(-0.77 * a, -h / 2, f"h = {h:.0f} {unit}", va="center")
    edge = -1.45 * a
    for tip, tail in ((face, face + 0.28 * h), (0, -0.28 * h)):
        axes.annotate("", (edge, tip), (edge, tail), arrowprops={"arrowstyle": "->"})
    axes.plot([edge - 0.08 * a, -a], [face, face], color="black", lw=0.7)
    axes.text(edge, face + 0.3 * h, f"$|d_c|$ = {face:.2f} {unit}", ha="center", va="bottom")
    axes.annotate("", (0, face + 1.15 * h), (0, face + 0.65 * h), arrowprops=one)
    axes.text(0.06 * a, face + 0.95 * h, "pull", va="center")


def case_studies(branches: Sequence[Branch]) -> Figure:
    """a(d) above, P(d) below, a column for each case study."""
    figure, grid = canvas(13, 6.2, 2, len(branches), sharex="col")
    depth = prefixed(np.concatenate([data.dense for data in branches]), "m")
    width = prefixed(np.concatenate([data.half_width_card for data in branches]), "m")
    force = prefixed(np.concatenate([data.force_card for data in branches]), "N/m")
    for column, data, colour, marker in zip(grid.T, branches, COLOURS, MARKERS, strict=False):
        x, dense = data.depths / depth.size, data.dense / depth.size
        style: dict[str, Any] = {"ls": "", "color": colour, "marker": marker, "label": "simulated"}
        column[0].plot(dense, data.half_width_card / width.size, label=data.sources[0], **LINE)
        column[0].plot(x, data.half_widths / width.size, **style)
        column[1].plot(dense, data.force_card / force.size, label=data.sources[1], **LINE)
        column[1].plot(x, data.forces / force.size, **style)
        column[1].axhline(0, color="black", lw=0.7, ls=":")
        column[0].set(
            title=data.name, ylim=np.array([-0.05, 1.15]) * data.half_width_card.max() / width.size
        )
        column[1].set_xlabel(f"depth d in {depth.symbol}")
        for axes, corner in zip(column, ("lower right", "upper left"), strict=True):
            axes.grid(alpha=0.25)
            axes.legend(loc=corner)
    grid[0, 0].set_ylabel(f"half-width a in {width.symbol}")
    grid[1, 0].set_ylabel(f"force P in {force.symbol}")
    figure.suptitle(
        "Simulated half-width and force lie on the closed forms (P > 0: pressed, P < 0: pulled)"
    )
    return figure
