"""A load path as an animation: the surface and the indenter, and the point on the loop P(d)."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization import History
from discretization.paths.events import Event, Snapshot
from discretization.paths.plots import draw, mark, units
from energy.units import prefixed
from studies.shared.figures import BLUE, ORANGE, RIGID, SOFT
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
                text = _caption(event)
                found += [Frame(event.before, text), Frame(event.after, text)]
        found.append(Frame(history.at(step), ""))
    return [frame for frame in found if math.isfinite(frame.state.depth)]


def _caption(event: Event) -> str:
    unit = prefixed(event.energy_released, "J/m")
    return f"{event.kind}: {event.energy_released / unit.size:.3g} {unit.symbol} released"


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


class _Stage:
    """The two panels: what stands still is drawn once, what moves over it for every frame."""

    def __init__(self, history: History, shown: list[Frame]) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.history = history
        self.figure = Figure(figsize=FIGSIZE, dpi=DPI, layout="constrained")
        self.canvas = FigureCanvasAgg(self.figure)
        self.left, self.right = self.figure.subplots(1, 2)
        self.scale = units([history], "force")
        draw(self.right, history, "force", self.scale)
        mark(self.right, history, "force", self.scale)
        self.right.axhline(0, color="black", lw=0.6, ls=":")
        self.right.set_title("force over depth")
        self.right.grid(alpha=0.25)
        self.right.legend(fontsize=9)
        self._window(shown)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)

    def _window(self, shown: list[Frame]) -> None:
        """What the left panel shows, the same for all frames."""
        scene = self.history.scene
        lines = np.array([(one.state.left, one.state.right) for one in shown])
        depth = np.array([one.state.depth for one in shown])[~np.isnan(lines[:, 0])]
        ends, lift = (np.nanmin(lines), np.nanmax(lines)), scene.opened.critical_separation
        margin = min(_BESIDE * scene.elastocapillary_length, 1.5 * (ends[1] - ends[0]))
        margin = margin or 0.3 * (ends[1] - ends[0])
        self.x = np.linspace(ends[0] - margin, ends[1] + margin, _POINTS)
        low, high = -float(depth.max()) - lift, 2.2 * max(-float(depth.min()), lift)
        across, self.up = prefixed(self.x, "m"), prefixed([low, high], "m")
        self.across, self.low, self.high = across, low / self.up.size, high / self.up.size
        self.left.set(xlabel=f"position x in {across.symbol}", title=" ")
        self.left.set(ylabel=f"height in {self.up.symbol} (stretched)")
        self.left.set(xlim=self.x[[0, -1]] / across.size, ylim=(self.low, self.high))

    def picture(self, frame: Frame) -> NDArray[np.uint8]:
        """One frame as pixels (height, width, 4)."""
        self.canvas.restore_region(self.still)
        axes, x = self.left, self.x / self.across.size
        u, body = (-y / self.up.size for y in surface(self.history, frame.state, self.x))
        body = np.where(np.isfinite(body), body, np.nan)
        depth, force = self.scale
        at = [frame.state.depth / depth.size], [frame.state.force / force.size]
        moving = [
            axes.fill_between(x, u, self.low, color=SOFT, lw=0),
            axes.fill_between(x, body, np.maximum(body, self.high), color=RIGID, lw=0),
            *axes.plot(x, body, color="black", lw=0.8),
            *axes.plot(x, u, color=BLUE, lw=2),
            axes.axhline(0, color="black", lw=0.6, ls=":"),
            axes.set_title(frame.caption or _said(frame.state)),
            *self.right.plot(*at, "o", ms=11, color=ORANGE, mec="black", zorder=9),
        ]
        for artist in moving:
            (self.right if artist is moving[-1] else axes).draw_artist(artist)
        for artist in (*moving[:-2], moving[-1]):
            artist.remove()
        axes.set_title(" ")
        return np.array(self.canvas.buffer_rgba())


def _said(state: Snapshot) -> str:
    if math.isnan(state.left):
        return "no contact"
    unit = prefixed(state.half_width, "m")
    return f"contact of half-width a = {state.half_width / unit.size:.3g} {unit.symbol}"


def animate(history: History, path: Path, count: int = 60) -> int:
    """Write the GIF; how many frames were drawn. ValueError for a path without a contact.

    (What stands still for several frames is stored as one that lasts longer.)
    """
    from matplotlib.animation import PillowWriter
    from matplotlib.figure import Figure

    shown = frames(history, count)
    if all(math.isnan(one.state.left) for one in shown):
        raise ValueError("history has no contact: there is nothing to animate; load it further")
    stage = _Stage(history, shown)
    screen = Figure(figsize=FIGSIZE, dpi=DPI)
    image, writer = screen.figimage(stage.picture(shown[0])), PillowWriter(fps=PER_SECOND)
    with naming(path), writer.saving(screen, str(path), DPI):
        for frame in shown:
            image.set_data(stage.picture(frame))
            writer.grab_frame()
    return len(shown)
