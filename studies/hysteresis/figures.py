"""Figures of the study `hysteresis`; among them the landscape U(a; d) with the states of a path.

At a depth d, with small slopes, every half-width a has its surface of least energy: u = d - f in
the contact and free beside it. U(a; d) is its energy; its minima over a are the states of a path
under imposed depth, and what separates one from the detached surface, U = 0, is the barrier that
keeps it metastable.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization import History
from discretization.inside import FittedMany
from discretization.plots import draw_path, units
from energy import cards
from energy.units import prefixed
from energy.units import quantity as quantity_of
from studies.hysteresis.record import Loop, Record
from studies.shared import loops
from studies.shared.figures import BLUE, ORANGE, Figure, canvas, edges, plain_ticks, shades
from studies.shared.loops import INDENTERS, LAYER, SIZE, WORK
from studies.shared.types import Array

_POINTS = 160
_WIDER = 1.3
_CLOSED = 1e-3
_DEPTHS = (0.5, 0.0, -0.4, -0.75, -0.95)  # of the landscape, in δ₀


def plot(record: Record, history: History) -> dict[str, Figure]:
    """Every figure by file name; `history`: the parabola's loop to look at closely."""
    gamma1 = quantity_of(history.scene.gamma1, "N/m")
    title = f"Parabola, γ₁ = {gamma1}: in contact loading and unloading coincide"
    return {
        "hysteresis_tension.png": over_tension(record),
        "hysteresis_control.png": over_control(record),
        "hysteresis_map.png": dissipation(record),
        "hysteresis_loop.png": history.plot(title, closed_form(history)),
        "hysteresis_landscape.png": landscape(history, nearest(history)),
    }


def _grid(rows: int, height: float) -> tuple[Figure, Any]:
    return canvas(15, height, rows, len(INDENTERS), squeeze=False)


def _own(record: Record, shape: str) -> list[Loop]:
    """The loops of a shape at w = WORK."""
    own = [loop for loop in record.loops if loop.shape == shape]
    return [loop for loop in own if loop.history.scene.work_of_adhesion == WORK]


def over_tension(record: Record) -> Figure:
    """P(d) above, a(d) below, under imposed depth, a colour for each γ₁."""
    drawn, grid = _grid(2, 8.5)
    for column, shape in zip(grid.T, INDENTERS, strict=True):
        own = [loop.history for loop in _own(record, shape) if loop.control == "depth"]
        for axes, quantity in zip(column, ("force", "half_width"), strict=True):
            scale = units(own, quantity)
            for history, colour in zip(own, shades(len(own)), strict=True):
                ratio = history.scene.elastocapillary_length / SIZE
                name = f"γ₁ = {quantity_of(history.scene.gamma1, 'N/m')}, l/b = {ratio:.2g}"
                draw_path(axes, history, quantity, scale, colour, name)
            axes.axhline(0, color="black", lw=0.6, ls=":")
            axes.grid(alpha=0.25)
        column[0].set_title(shape)
        column[0].legend(fontsize=9)
    drawn.suptitle("Loops under imposed depth: energy is lost in the jumps (dashed), nowhere else")
    return drawn


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
            draw_path(axes, loop.history, "force", units([loop.history], "force"), BLUE)
            words = {"depth": "imposed depth", "force": "dead load"}
            stiffness = loop.control.removeprefix("K = ").replace(" ", "·")
            held = words.get(loop.control, f"spring of stiffness {stiffness}")
            axes.set_title(f"{shape}, {held}: loop area {area:.3g}·2wb", fontsize=11)
            axes.axhline(0, color="black", lw=0.6, ls=":")
            axes.grid(alpha=0.25)
    drawn.suptitle(
        "What holds the indenter decides where it jumps (dashed) and how much energy that costs; "
        f"γ₁ = {quantity_of(gamma1, 'N/m')}, b = {quantity_of(SIZE, 'm')}"
    )
    return drawn


def dissipation(record: Record) -> Figure:
    """Loop area over l/b and K/(kb), with the critical stiffness of the machine."""
    from matplotlib.colors import LogNorm

    drawn, grid = _grid(1, 4.8)
    areas = np.concatenate([found.area[found.area > 1e-9] for found in record.maps])
    norm = LogNorm(float(areas.min()), float(areas.max()))
    for axes, found in zip(grid[0], record.maps, strict=True):
        area = np.where(found.area > 1e-9, found.area, np.nan)
        cells = (np.exp(edges(np.log(middles))) for middles in (found.across, found.up))
        shades = axes.pcolormesh(*cells, area, norm=norm)
        axes.set_facecolor("#cccccc")
        axes.set(xscale="log", yscale="log", xlabel="tension  l/b", ylabel="machine  K/(kb)")
        low, high = axes.get_ylim()
        if not np.isfinite(area).all():
            axes.text(1.25, 1, "no loop", va="center")
        across = np.geomspace(float(found.across[0]), float(found.across[-1]), 200)
        scene = loops.scene_of(found.shape, 0.0)
        if (card := loops.known(scene).critical_stiffness) is not None:
            tension = {"gamma1": LAYER.stiffness * (across * SIZE) ** 2}
            critical = card(**loops.arguments(scene) | tension) / (LAYER.stiffness * SIZE)
            name = "critical K: above it the contact closes"
            axes.plot(across, critical, color="white", lw=5)
            axes.plot(across, critical, color=ORANGE, lw=2, label=name)
            axes.legend(loc="lower left", fontsize=9)
        plain_ticks(axes.xaxis)
        plain_ticks(axes.yaxis)
        axes.set(ylim=(low, high), title=f"{found.shape}: worst error {found.error.max():.0e}")
    drawn.colorbar(shades, ax=list(grid[0]), label="loop area / 2wb")
    drawn.suptitle("A softer machine loses more energy; so does more tension, but for the wedge")
    return drawn


def closed_form(history: History) -> tuple[Array, Array, Array]:
    """(d, P, a) of a parabola's whole branch."""
    scene = history.scene
    given = loops.arguments(scene)
    d = np.linspace(-scene.critical_separation, float(history.depth.max()), 400)
    force, a = cards.parabola.force(d, **given), cards.parabola.half_width(d, **given)
    return d, np.asarray(force), np.asarray(a)


def nearest(history: History) -> list[int]:
    """Steps in contact on unloading, nearest to some depths between 0 and the end."""
    depth, turn = history.depth, int(np.argmax(history.depth))
    held = [i for i in range(turn, depth.size) if history.half_width[i] > 0]
    wanted = np.array(_DEPTHS) * history.scene.critical_separation
    return [min(held, key=lambda i, d=d: abs(depth[i] - d)) for d in wanted.tolist()]  # type: ignore[misc]


class Curve(NamedTuple):
    """U (n,) over the half-width a (n,) at the depth of a step.

    through: the surface would pass through the indenter; state: (a, U) of the path at this step.
    """

    depth: float
    half_width: Array
    energy: Array
    through: NDArray[np.bool_]
    state: tuple[float, float]


def curves(history: History, steps: Sequence[int]) -> list[Curve]:
    """Landscapes at the depths of these steps, from almost closed to wider than the states.

    ValueError for finite slopes, an indenter that is not symmetric, and steps without contact.
    """
    if history.scene.slopes != "small":
        raise ValueError(
            f"slopes = {history.scene.slopes!r} must be 'small' for a landscape over a"
        )
    indenter, widths = history.scene.indenter, history.half_width[list(steps)]
    if not indenter.symmetric or indenter.apex is None:
        raise ValueError(f"indenter = {indenter!r} must be symmetric for a landscape over a")
    if not np.any(widths > 0):
        raise ValueError(f"steps = {list(steps)!r} must contain one with a contact")
    widest = min(_WIDER * float(widths.max()), float(np.diff(indenter.extent)[0]) / 2)
    a = widest * np.linspace(_CLOSED, 1, _POINTS)
    return [_curve(history, step, a) for step in steps]


def _curve(history: History, step: int, a: Array) -> Curve:
    """U by the quadrature with which load paths are integrated."""
    scene, depth = history.scene, float(history.depth[step])
    apex = scene.indenter.apex or 0.0
    branch = FittedMany.of(scene, 1e-8, depth + float(scene.indenter.height(apex + a[-1])))
    tails = np.full((a.size, 2, 2), [-math.inf, math.inf])
    tails[:, 0, 1], tails[:, 1, 0] = apex - a, apex + a
    energy = branch.smoothly.many(tails, np.full(a.size, depth))[0]
    end, slope = depth - scene.indenter.height(apex + a), scene.indenter.slope(apex + a)
    through = scene.elastocapillary_length * slope < end
    state = history.at(step)
    return Curve(depth, a, energy, through, (state.half_width, state.energy))


def landscape(history: History, steps: Sequence[int]) -> Figure:
    """U(a; d) at the depths of these steps; thin where the surface would pass through the indenter.

    A filled dot is the state of the path, a ring the detached surface.
    """
    (drawn, axes), found = canvas(8, 5.5), curves(history, steps)
    states = np.array([curve.state for curve in found])
    shown = np.concatenate([states[:, 1], [curve.energy[0] for curve in found]])
    depth, x = prefixed([curve.depth for curve in found], "m"), prefixed(found[0].half_width, "m")
    y = prefixed(shown, "J/m")
    for curve, colour in zip(found, shades(len(found)), strict=True):
        name = f"d = {curve.depth / depth.size:.3g} {depth.symbol}".replace("-", "−")
        a, energy = curve.half_width / x.size, curve.energy / y.size
        axes.plot(a, np.where(curve.through, np.nan, energy), color=colour, lw=2, label=name)
        axes.plot(a, energy, color=colour, lw=0.7)
        at = curve.state[0] / x.size, curve.state[1] / y.size
        axes.plot(*at, "o", color=colour, ms=9, mec="black", zorder=5, clip_on=False)
    ring: dict[str, Any] = {"ls": "", "marker": "o", "mfc": "white", "mec": "black", "ms": 9}
    axes.plot(0, 0, label="detached", clip_on=False, zorder=6, **ring)
    axes.axhline(0, color="black", lw=0.6, ls=":")
    low, high = float(shown.min()) / y.size, max(float(shown.max()), 0.0) / y.size
    axes.set(ylim=(low - 0.12 * (high - low), high + 0.25 * (high - low)))
    axes.set(xlabel=f"half-width a in {x.symbol}", ylabel=f"energy U in {y.symbol}")
    axes.set(
        xlim=(0, None), title="The path (dots) stays in a minimum of the energy until none is left"
    )
    axes.legend(fontsize=9)
    axes.grid(alpha=0.25)
    return drawn
