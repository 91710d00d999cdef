"""Figures of the study `pull_off`."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from energy import Scene, cards
from energy.units import prefixed
from studies.pull_off.record import Curve
from studies.shared import loops
from studies.shared.figures import COLOURS, GREY, MARKERS, Figure, canvas, plain_ticks
from studies.shared.loops import LAYER, SIZE
from studies.shared.types import Array

LAWS = {"flat punch": "Eq. (23)", "wedge": "Eq. (30), then 0", "parabola": "parabola law"}
_DENSE = 200


def _dense(
    curve: Curve, card: Callable[[Scene], cards.PullOff] = loops.pull_off_card
) -> tuple[Array, Array, Array, Array]:
    """l/b, pull, d and a of the closed forms, densely."""
    ratios = np.geomspace(curve.ratios[1], curve.ratios[-1], _DENSE)
    force, depth, a = np.array([card(scene) for scene in _scenes(curve, ratios)], float).T
    return ratios, -force, depth, a


def _scenes(curve: Curve, ratios: Array) -> list[Scene]:
    return [loops.scene_of(curve.shape, LAYER.stiffness * (r * SIZE) ** 2) for r in ratios]


def forces(curves: Sequence[Curve]) -> Figure:
    """F_A above and the half-width at pull-off below, over γ₁."""
    drawn, grid = canvas(15, 8, 2, len(curves), sharex="col", height_ratios=(1.5, 1))
    for column, curve, colour, marker in zip(grid.T, curves, COLOURS, MARKERS, strict=False):
        _column(column, curve, {"color": colour, "marker": marker, "ls": ""})
        column[0].set_title(f"{curve.shape}: worst error {curve.error:.0e}")
    drawn.suptitle("The largest pull under a dead load, at fixed w, is that of the closed forms")
    return drawn


def _column(column: Any, curve: Curve, style: dict[str, Any]) -> None:
    ratios, force, _, a = _dense(curve)
    tension = LAYER.stiffness * (ratios * SIZE) ** 2
    mine = np.array([pull.scene.gamma1 for pull in curve.pulls])[1:]
    y, z = prefixed(force, "N/m"), prefixed(SIZE, "m")
    top, bottom = column
    top.plot(tension, force / y.size, color="black", lw=1.2, label=LAWS[curve.shape])
    top.plot(mine, curve.forces[1:] / y.size, label="simulated", **style)
    if curve.shape == "wedge":
        _beyond(top, curve, y.size)
    none = curve.forces[0] / y.size
    top.axhline(none, color=GREY, ls="--", lw=1.2, label="simulated without tension")
    widths = np.array([pull.simulated.half_width for pull in curve.pulls])[1:]
    bottom.plot(tension, a / z.size, color="black", lw=1.2)
    bottom.plot(mine, widths / z.size, **style)
    bottom.set(ylim=(-0.05 * SIZE / z.size, 1.15 * SIZE / z.size))
    bottom.set(xscale="log", xlabel="surface tension γ₁")
    plain_ticks(bottom.xaxis, "N/m", (1.0,), most=5)
    top.set_ylabel(f"adhesion force $F_A$ in {y.symbol}")
    bottom.set_ylabel(f"half-width at pull-off in {z.symbol}")
    if curve.shape != "wedge":
        top.set_yscale("log")
        plain_ticks(top.yaxis, steps=(1.0, 2.0, 3.0, 5.0))
    scale = np.sqrt(1 / LAYER.stiffness) / SIZE
    above = top.secondary_xaxis(
        "top", functions=(lambda g: scale * np.sqrt(np.abs(g)), lambda r: (r / scale) ** 2)
    )
    above.set_xlabel("l/b")
    plain_ticks(above.xaxis, steps=(1.0,))
    for axes in column:
        axes.axvline(LAYER.stiffness * SIZE**2, color=GREY, lw=0.8, ls=":")
        axes.grid(alpha=0.25)
    top.legend(fontsize=8, loc="center left" if curve.shape == "wedge" else "upper left")


def _beyond(axes: Any, curve: Curve, y: float) -> None:
    """Eq. (30) where it does not hold, as far as it is comparable."""
    ratios = np.geomspace(1, min(1.4, curve.ratios[-1]), 40)
    force = np.abs([loops.formula_30(scene) for scene in _scenes(curve, ratios)])
    style = {"color": "black", "ls": ":", "lw": 1.2, "label": "|Eq. (30)| where it does not hold"}
    axes.plot(LAYER.stiffness * (ratios * SIZE) ** 2, force / y, **style)


def gain(curves: Sequence[Curve]) -> Figure:
    """F_A over its value without tension, for all indenters over l/b."""
    drawn, axes = canvas(8, 5.5)
    for curve, colour, marker in zip(curves, COLOURS, MARKERS, strict=False):
        ratios, force, *_ = _dense(curve)
        axes.plot(ratios, force / curve.forces[0], color=colour, lw=1.2)
        axes.plot(curve.ratios[1:], curve.gain[1:], marker, color=colour, label=curve.shape)
    axes.plot([], [], color="black", lw=1.2, label="closed forms")
    axes.axhline(1, color=GREY, lw=0.8)
    axes.axvline(1, color=GREY, lw=0.8, ls=":")
    axes.set(xscale="log", xlabel="tension  l/b", ylabel="$F_A$ / $F_A(γ_1 = 0)$")
    axes.set_yscale("symlog", linthresh=1)  # from 0 to 1 linear
    most = max(float(curve.gain.max()) for curve in curves)
    ticks = [tick for tick in (0, 0.5, 1, 2, 5, 10, 20, 50, 100, 200) if tick <= 1.1 * most]
    axes.set_yticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    axes.set_ylim(-0.1, 1.3 * most)
    axes.set_title(
        "Tension strengthens the adhesion of punch and parabola, and ends that of the wedge"
    )
    axes.legend()
    axes.grid(alpha=0.25)
    return drawn


def maxwell(flat: Curve) -> Figure:
    """Flat punch: metastable limit and the pull at which detached has the lower energy."""
    drawn, panels = canvas(11, 4.8, 1, 2)
    pulls, ratios = flat.pulls[1:], flat.ratios[1:]
    known = [_dense(flat), _dense(flat, loops.global_pull_off)]
    states = [[p.simulated for p in pulls], [p.balanced for p in pulls if p.balanced]]
    names = ("metastable limit, Eq. (23)", "equal energies (Maxwell)")
    for axes, quantity, unit in zip(panels, (0, 1), ("N/m", "m"), strict=True):
        y = prefixed(known[0][1 + quantity], unit)
        for card, own, name, i in zip(known, states, names, (0, 1), strict=True):
            points = np.array([one[quantity] for one in own])
            axes.plot(card[0], card[1 + quantity] / y.size, color=COLOURS[i], lw=1.2)
            style = {"color": COLOURS[i], "marker": MARKERS[i], "ls": "", "label": name}
            axes.plot(ratios, points / y.size, **style)
        axes.set(xscale="log", xlabel="tension  l/a")
        axes.set_ylabel(f"{('pull', 'depth d')[quantity]} in {y.symbol}")
        axes.grid(alpha=0.25)
    drawn.axes[0].set_yscale("log")
    plain_ticks(drawn.axes[0].yaxis, steps=(1.0, 2.0, 3.0, 5.0))
    drawn.axes[0].legend()
    drawn.suptitle("Flat punch: between the curves the contact holds but is only metastable")
    return drawn
