"""The load path of a scene file: its response, what is told of it, and its figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from discretization import Event, History, PullOff, load_path
from studies.figures import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE
from studies.scene_file import SceneFile
from studies.units import prefixed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
EVENTS = (ORANGE, GREEN, PURPLE, BLACK)
MARKERS = ("v", "^", "D", "s")
DRIVEN = {"depths": "m", "forces": "N/m", "drives": "m"}


def follow(given: SceneFile) -> History:
    """`discretization.load_path` along the file's [path]. ValueError names the file."""
    programme, options = given.programme, given.options
    if programme is None:
        raise ValueError(f"{given.path}: path is missing; add a [path] with depths to the file")
    programmed: dict[str, Any] = {programme.control: programme.values}
    lattice = options.get("method") == "lattice"
    try:
        return load_path(
            given.scene,
            **programmed,
            machine_stiffness=programme.machine_stiffness,
            method="lattice" if lattice else "fitted",
            spacing=options.get("spacing"),
            rtol=options.get("rtol", 1e-8),
        )
    except ValueError as error:
        raise ValueError(f"{given.path}: [path]: {error}") from error


def most_tensile(history: History) -> PullOff | None:
    """`History.pull_off`; None for a path without tension."""
    try:
        return history.pull_off
    except ValueError:
        return None


def told(history: History) -> str:
    """The events in their order, the most tensile state and the energy lost."""
    control = history.control
    lines = [f"load path: {history.values.size} steps of {control}, {len(history.events)} events"]
    lines.append(
        f"{'event':18s}{control:>14s}{'depth/m':>14s}{'force/(N/m)':>14s}{'lost/(J/m)':>14s}"
    )
    for event in history.events:
        values = (event.control, event.depth, event.force, event.energy_released)
        lines.append(f"{event.kind:18s}" + "".join(f"{value:>14.6g}" for value in values))
    pull = most_tensile(history)
    if pull is not None:
        force, depth, half_width = pull
        at = f"P = {force:.6g} N/m at d = {depth:.6g} m, a = {half_width:.6g} m"
        lines.append(f"most tensile: {at}")
    return "\n".join([*lines, f"energy lost on the way: {history.dissipated:.6g} J/m"])


def write_csv(history: History, path: Path, notes: Sequence[str]) -> None:
    """`History.to_csv`, which `History.from_csv` reads back; the notes follow as comments."""
    history.to_csv(path)
    with path.open("a", encoding="utf-8") as file:
        file.writelines(f"# {' '.join(note.split())}\n" for note in notes)


def plot(given: SceneFile, history: History) -> Figure:
    """P(d) and a(d) with the events; under force or machine control the depth against it."""
    from matplotlib.figure import Figure

    driven = history.control != "depth"
    figure = Figure(figsize=(15 if driven else 11, 5), layout="constrained")
    panels = figure.subplots(1, 2 + driven)
    curve, events = _curve(history), history.events
    _panel(panels[0], curve[0], curve[1], events, "force", ("force per length P", "N/m"))
    _panel(panels[1], curve[0], curve[2], events, "half_width", ("contact half-width a", "m"))
    if driven:
        _programme(panels[2], history)
    panels[0].legend()
    figure.suptitle(given.title, fontsize=14)
    return figure


def _curve(history: History) -> tuple[Array, Array, Array]:
    """Depth, force, half-width of the steps and of both sides of every event, nan between these."""
    rows: list[tuple[float, float, float]] = []
    events = list(history.events)
    for step in range(history.depth.size):
        while events and events[0].step == step:
            event = events.pop(0)
            before, after = ((s.depth, s.force, s.half_width) for s in (event.before, event.after))
            rows += [before, (math.nan,) * 3, after]
        state = history.at(step)
        rows.append((state.depth, state.force, state.half_width))
    table = np.array(rows)
    table[~np.isfinite(table[:, 0])] = math.nan
    return table[:, 0], table[:, 1], table[:, 2]


def _panel(
    axes: Any,
    depth: Array,
    values: Array,
    events: Sequence[Event],
    name: str,
    axis: tuple[str, str],
) -> None:
    x, y = prefixed(depth, "m"), prefixed(values, axis[1])
    axes.plot(depth / x.size, values / y.size, color=BLUE, lw=1.5)
    _arrows(axes, depth / x.size, values / y.size)
    for jump in [(event.before, event.after) for event in events]:
        heights = [getattr(state, name) / y.size for state in jump]
        axes.plot([state.depth / x.size for state in jump], heights, ":", color=BLUE, lw=1.2)
    kinds = list(dict.fromkeys(event.kind for event in events))
    for i, kind in enumerate(kinds):
        at = [event.before for event in events if event.kind == kind]
        heights = [getattr(state, name) / y.size for state in at]
        style = {"color": EVENTS[i % 4], "marker": MARKERS[i % 4], "zorder": 3}
        axes.plot([s.depth / x.size for s in at], heights, ls="", label=kind, **style)
    axes.axhline(0, color=GREY, lw=0.8)
    axes.set(xlabel=f"indentation depth d [{x.symbol}]", ylabel=f"{axis[0]} [{y.symbol}]")
    axes.grid(alpha=0.25)


def _arrows(axes: Any, x: Array, y: Array) -> None:
    """The direction of the path, at a fifth and four fifths of it."""
    good = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    for share in (0.2, 0.8):
        at = int(share * (good.size - 1))
        start, end = good[at : at + 2] if good.size > at + 1 else (0, 0)
        if (x[start], y[start]) != (x[end], y[end]):
            style = {"arrowstyle": "-|>", "color": BLUE, "mutation_scale": 16}
            axes.annotate("", (x[end], y[end]), (x[start], y[start]), arrowprops=style)


def _programme(axes: Any, history: History) -> None:
    """The depth against the imposed force or drive."""
    label, unit = {"force": ("imposed force", "N/m"), "drive": ("drive D", "m")}[history.control]
    depth = np.where(np.isfinite(history.depth), history.depth, math.nan)
    x, y = prefixed(history.values, unit), prefixed(depth, "m")
    axes.plot(history.values / x.size, depth / y.size, ".-", color=BLUE, lw=1, ms=4)
    axes.set(xlabel=f"{label} [{x.symbol}]", ylabel=f"indentation depth d [{y.symbol}]")
    axes.grid(alpha=0.25)
