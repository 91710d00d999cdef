"""Figures of a load path: P(d) and a(d) with its events.

Numbers are drawn in SI units with a prefix, or, with si = False, as the plain ones of the scene.

Colours tell loading from unloading (or one path from another); an instability is drawn dashed
along the line on which the control holds it: fixed depth, fixed load, or that of the spring.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.paths.control import Control
from discretization.paths.events import Event, Snapshot
from discretization.plots import BLUE, GREEN, GREY, ORANGE, axis, canvas
from energy.units import Unit, prefixed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from discretization.paths.history import History

Array = NDArray[np.float64]
JUMPS = ("touch", "jump-in", "jump", "detachment", "pull-off")
MARKS = {"touch": "o", "jump-in": "^", "jump": "D", "detachment": "v", "pull-off": "X"}
MARKS |= {"edge depinning": "s", "tip depinning": "<", "tip pinning": ">", "edge pinning": "p"}
STYLES: dict[str, dict[str, Any]] = {
    "loading": {"color": BLUE, "lw": 3.5, "alpha": 0.55, "zorder": 2},
    "unloading": {"color": ORANGE, "lw": 1.4, "zorder": 3},
    "jump": {"color": "black", "lw": 1.1, "ls": "--", "zorder": 4},
    "free": {"color": GREY, "lw": 1.0, "zorder": 1},
}


class Leg(NamedTuple):
    """Part of a path: "loading", "unloading", "jump" or "free" (no contact); its states.

    depth, force and half_width (n,); on a jump the force is that of what holds the indenter.
    """

    kind: str
    depth: Array
    force: Array
    half_width: Array


def legs(history: History) -> list[Leg]:
    """A path in parts that go one way, jumps between them. Infinite depths are left out."""
    pairs: list[tuple[str, list[Snapshot]]] = []
    events, here = list(history.events), None
    for step in range(history.depth.size):
        while events and events[0].step == step:
            event = events.pop(0)
            pairs += _towards(here, event.before)
            if event.kind in JUMPS:
                pairs.append(("jump", _held(history, event)))
            here = event.after
        there = history.at(step)
        pairs += _towards(here, there)
        here = there
    return [_leg(kind, states) for kind, states in _joined(pairs)]


def _towards(here: Snapshot | None, there: Snapshot) -> list[tuple[str, list[Snapshot]]]:
    """One step without a jump; none where nothing moves, or comes from infinity."""
    if here is None or not math.isfinite(here.depth + there.depth) or here.depth == there.depth:
        return []
    if math.isnan(here.left) and math.isnan(there.left):
        return [("free", [here, there])]
    return [("loading" if there.depth > here.depth else "unloading", [here, there])]


def _held(history: History, event: Event) -> list[Snapshot]:
    """A jump along the line of the control: before, under the load at its end, after."""
    before, after = event.before, event.after
    if history.control == "depth":
        return [before, after]
    hold = Control(history.machine_stiffness or 0.0)
    return [before, after._replace(force=hold.load(after.depth, event.control)), after]


def _joined(pairs: list[tuple[str, list[Snapshot]]]) -> list[tuple[str, list[Snapshot]]]:
    """Steps of one kind that follow each other as one list of states."""
    runs: list[tuple[str, list[Snapshot]]] = []
    for kind, states in pairs:
        if runs and kind != "jump" and runs[-1][0] == kind:
            runs[-1][1].append(states[-1])
        else:
            runs.append((kind, list(states)))
    return runs


def _leg(kind: str, states: list[Snapshot]) -> Leg:
    rows = [(state.depth, state.force, state.half_width) for state in states]
    return Leg(kind, *np.array(rows).T)


def units(histories: Sequence[History], quantity: str, si: bool = True) -> tuple[Unit, Unit]:
    """Units of depth and of the quantity in which all these paths are drawn."""
    parts = [leg for history in histories for leg in legs(history) if leg.kind != "free"]
    depth, values = (
        np.concatenate([getattr(leg, name) for leg in parts]) for name in ("depth", quantity)
    )
    force = f"N{histories[0].scene.per_length}"
    length, other = ("m", force if quantity == "force" else "m") if si else ("", "")
    return prefixed(depth, length), prefixed(values, other)


def draw(
    axes: Any,
    history: History,
    quantity: str,
    scale: tuple[Unit, Unit],
    colour: str | None = None,
    label: str | None = None,
    width: float = 1.8,
) -> None:
    """One path over the depth; `colour` for the whole path, else by what it is doing."""
    x, y = scale
    for leg in legs(history):
        style = dict(STYLES[leg.kind])
        if colour is not None and leg.kind != "free":
            style |= {"color": colour, "lw": 1.3 if leg.kind == "jump" else width, "alpha": 1.0}
        depth, values = leg.depth / x.size, getattr(leg, quantity) / y.size
        axes.plot(depth, values, **style)
        if leg.kind in ("loading", "unloading", "jump") and np.ptp(depth) + np.ptp(values) > 0:
            _arrow(axes, depth, values, style["color"], 0.35 if leg.kind == "loading" else 0.6)
    if label is not None:
        axes.plot([], [], color=colour, lw=width, label=label)
    width_of = "radius a" if history.scene.axisymmetric else "half-width a"
    name = "force P" if quantity == "force" else width_of
    axes.set(xlabel=axis("depth d", x), ylabel=axis(name, y))
    axes.ticklabel_format(scilimits=(-3, 4))  # of plain numbers


def _arrow(axes: Any, x: Array, y: Array, colour: str, at: float) -> None:
    """An arrow head on a line, at this part of its length."""
    steps = np.hypot(np.diff(x) / (np.ptp(x) or 1.0), np.diff(y) / (np.ptp(y) or 1.0))
    length = np.concatenate([[0.0], np.cumsum(steps)])
    ends = np.array([at - 0.025, at + 0.025]) * length[-1]
    (x0, x1), (y0, y1) = np.interp(ends, length, x), np.interp(ends, length, y)
    style = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 14, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (x1, y1), (x0, y0), arrowprops=style, zorder=5)


def mark(axes: Any, history: History, quantity: str, scale: tuple[Unit, Unit]) -> None:
    """Events of a path by kind: where contact has begun, or from where the state leaves."""
    x, y = scale
    for event in history.events:
        state = event.after if event.kind in ("touch", "jump-in") else event.before
        at = state.depth / x.size, getattr(state, quantity) / y.size
        new = event.kind not in axes.get_legend_handles_labels()[1]
        axes.plot(
            *at,
            ls="",
            marker=MARKS.get(event.kind, "h"),
            ms=12 if "pinning" in event.kind else 8,
            mfc="none" if "pinning" in event.kind else GREEN,
            mec="black",
            zorder=6,
            label=event.kind if new else None,
        )


def plot(
    history: History,
    title: str = "",
    closed_form: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
    *,
    si: bool = True,
) -> Figure:
    """A matplotlib figure of P(d) and a(d) with the events, under a load also of d over the load.

    closed_form: (d, P, a) to draw beside them. Numbers are drawn in SI units with a prefix; si =
    False, for other units: as they are.
    """
    driven = history.control != "depth"
    drawn, row = canvas(16 if driven else 12, 5, 1, 2 + driven)
    for axes, quantity, i in zip(row, ("force", "half_width"), (1, 2), strict=False):
        scale = units([history], quantity, si)
        draw(axes, history, quantity, scale)
        if closed_form is not None:
            x, y = np.asarray(closed_form[0]), np.asarray(closed_form[i])
            thick = {"color": "black", "lw": 6, "alpha": 0.15, "zorder": 0}
            axes.plot(x / scale[0].size, y / scale[1].size, label="closed form", **thick)
        for kind in ("loading", "unloading", "jump", "free"):
            name = {"jump": "instability", "free": "no contact"}.get(kind, kind)
            axes.plot([], [], label=name, **STYLES[kind])
        mark(axes, history, quantity, scale)
        axes.axhline(0, color=GREY, lw=0.6, ls=":")
        axes.grid(alpha=0.25)
    row[0].legend(fontsize=9)
    if driven:
        _programme(row[2], history, si)
    drawn.suptitle(title, fontsize=14)
    return drawn


def _programme(axes: Any, history: History, si: bool) -> None:
    """The depth against the imposed force or drive."""
    force = f"N{history.scene.per_length}"
    label, unit = {"force": ("imposed force", force), "drive": ("drive D", "m")}[history.control]
    depth = np.where(np.isfinite(history.depth), history.depth, math.nan)
    x, y = prefixed(history.values, unit if si else ""), prefixed(depth, "m" if si else "")
    axes.plot(history.values / x.size, depth / y.size, ".-", color=BLUE, lw=1, ms=4)
    axes.set(xlabel=axis(label, x), ylabel=axis("depth d", y))
    axes.grid(alpha=0.25)
