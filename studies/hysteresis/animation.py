"""A load path as an animation: the surface and the indenter, and the point on the loop P(d)."""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from discretization import History, Snapshot
from discretization.plots import draw_path, mark, units
from energy.units import Unit, prefixed, quantity
from studies.shared.figures import BLUE, ORANGE, RIGID, SOFT, canvas
from studies.shared.table import naming
from studies.shared.types import Array

FIGSIZE, DPI, PER_SECOND = (11.0, 4.3), 75, 12
_POINTS = 401
_HELD = 4  # frames before and after a jump
_BESIDE = 4.0  # elastocapillary lengths drawn beside the widest contact


class Frame(NamedTuple):
    """A state and what is said of it."""

    state: Snapshot
    caption: str


def frames(history: History, count: int) -> list[Frame]:
    """About `count` states spread evenly along the loop P(d); jumps hold for some frames each.

    ValueError for fewer than two frames.
    """
    if count < 2:
        raise ValueError(f"frames = {count!r} must be at least 2")
    moments = _moments(history)
    depth, force = (
        np.array([getattr(one.state, name) for one in moments]) for name in ("depth", "force")
    )
    steps = np.hypot(np.diff(depth) / (np.ptp(depth) or 1), np.diff(force) / (np.ptp(force) or 1))
    jumps = np.array([bool(one.caption) for one in moments])
    steps[jumps[:-1] & jumps[1:]] = 0  # a jump takes no time
    at = np.concatenate([[0.0], np.cumsum(steps)])
    smooth = max(count - _HELD * int(jumps.sum()), 2)
    nearest = np.abs(at[None] - np.linspace(0, at[-1], smooth)[:, None]).argmin(axis=1)
    repeats = np.bincount(nearest, minlength=len(moments)).clip(max=1)
    repeats[jumps] = _HELD
    return [one for one, times in zip(moments, repeats, strict=True) for _ in range(times)]


def _moments(history: History) -> list[Frame]:
    """The states of the path in order, those beside a jump with a caption; of finite depth."""
    events, found = list(history.events), []
    for step in range(history.depth.size):
        while events and events[0].step == step:
            event = events.pop(0)
            if event.energy_released > 1e-9 * abs(history.dissipated):
                text = f"{event.kind}: {quantity(event.energy_released, 'J/m')} released"
                found += [Frame(event.before, text), Frame(event.after, text)]
        found.append(Frame(history.at(step), ""))
    return [frame for frame in found if math.isfinite(frame.state.depth)]


def surface(history: History, state: Snapshot, x: Array) -> tuple[Array, Array]:
    """u(x) of a state with small slopes, and the indenter d - f(x); both positive downwards."""
    scene = history.scene
    body = state.depth - scene.indenter.height(x)
    if math.isnan(state.left):
        return np.zeros_like(x), body
    u = np.where((x >= state.left) & (x <= state.right), body, 0.0)
    for side, end in ((-1, state.left), (1, state.right)) if scene.gamma1 else ():
        beside = side * (x - end)
        line, far = state.depth - float(scene.indenter.height(end)), scene.elastocapillary_length
        u = np.where(beside > 0, line * np.exp(-np.maximum(beside, 0) / far), u)
    return u, body


def _window(axes: Any, history: History, shown: list[Frame]) -> tuple[Array, Unit, Unit]:
    """Frame the surface, the same for all states: the x drawn, and the units of both axes."""
    scene = history.scene
    lines = np.array([(one.state.left, one.state.right) for one in shown])
    depth = np.array([one.state.depth for one in shown])[~np.isnan(lines[:, 0])]
    ends, lift = (np.nanmin(lines), np.nanmax(lines)), scene.opened.critical_separation
    margin = min(_BESIDE * scene.elastocapillary_length, 1.5 * (ends[1] - ends[0]))
    margin = margin or 0.3 * (ends[1] - ends[0])
    x = np.linspace(ends[0] - margin, ends[1] + margin, _POINTS)
    height = np.array([-float(depth.max()) - lift, 2.2 * max(-float(depth.min()), lift)])
    across, up = prefixed(x, "m"), prefixed(height, "m")
    axes.set(xlim=x[[0, -1]] / across.size, ylim=height / up.size)
    axes.set(xlabel=f"position x in {across.symbol}")
    axes.set_ylabel(f"height in {up.symbol} (stretched)")
    axes.axhline(0, color="black", lw=0.6, ls=":")
    return x, across, up


def _moving(axes: Any, history: History, frame: Frame, window: tuple[Array, Unit, Unit]) -> Any:
    """Draw the layer and the indenter of one frame; what was drawn."""
    (x, across, up), (low, high) = window, axes.get_ylim()
    u, body = (-y / up.size for y in surface(history, frame.state, x))
    body, s = np.where(np.isfinite(body), body, np.nan), x / across.size
    width = f"contact of half-width a = {quantity(frame.state.half_width, 'm')}"
    told = "no contact" if math.isnan(frame.state.left) else width
    axes.set_title(frame.caption or told)
    return [
        axes.fill_between(s, u, low, color=SOFT, lw=0),
        axes.fill_between(s, body, np.maximum(body, high), color=RIGID, lw=0),
        *axes.plot(s, body, color="black", lw=0.8),
        *axes.plot(s, u, color=BLUE, lw=2),
    ]


def animate(history: History, path: Path, count: int = 60) -> int:
    """Write the GIF; how many frames were drawn. ValueError for a path without a contact.

    (What stands still for several frames is stored as one that lasts longer.)
    """
    from matplotlib.animation import PillowWriter

    shown = frames(history, count)
    if all(math.isnan(one.state.left) for one in shown):
        raise ValueError("history has no contact: there is nothing to animate; load it further")
    figure, (left, right) = canvas(*FIGSIZE, 1, 2)
    depth, force = scale = units([history], "force")
    draw_path(right, history, "force", scale)
    mark(right, history, "force", scale)
    right.axhline(0, color="black", lw=0.6, ls=":")
    right.set_title("force over depth")
    right.grid(alpha=0.25)
    right.legend(fontsize=9)
    window, writer = _window(left, history, shown), PillowWriter(fps=PER_SECOND)
    with naming(path), writer.saving(figure, str(path), DPI):
        for frame in shown:
            at = [frame.state.depth / depth.size], [frame.state.force / force.size]
            point = right.plot(*at, "o", ms=11, color=ORANGE, mec="black", zorder=9)
            moving = [*_moving(left, history, frame, window), *point]
            writer.grab_frame()
            figure.set_layout_engine("none")  # as just laid out
            for artist in moving:
                artist.remove()
    return len(shown)
