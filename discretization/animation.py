"""A load path that moves: the indenter and the surface, and P(d) with a travelling point.

Frames are states of the path, evenly spread over its length in the plane of d and P, and every jump
in slow motion. What lies between the two states of a jump is no equilibrium: there the surface is
drawn as the weighted mean of both, and the title says so.

history: a `History`, which is built on this module, not it on that.

Depths and displacements u are positive downwards, and the picture's axis points down; heights f of
the indenter are positive upwards, so that its surface is at d - f. A state of the path is a
`Snapshot` with `depth`, `force`, `lines` (both ends of each contact from left to right; radii about
an axis) and `left`, the first of them, nan without contact.

Of the scene, l = √(γ₁/k) is `elastocapillary_length`, over which free surfaces decay, h the
thickness of the layer, `extent` are the ends of the known profile, and `layer.exact` says that the
layer has its exact response, whose state `on_layer` finds again at the depth, to the accuracy
`rtol` of the path. Else `surfaces_of` are the free surfaces of the scene: their `shape(x, left,
right, depth)` is u, and du/dx, between two `LinePosition`s (x and the height f there), None for a
line that does not exist. `plots.legs` are the parts of the path, each with its kind ("loading",
"unloading", "jump" or "free" of contact) and its states. `prefixed` gives the `Unit` that suits
some numbers, whose `size` they are divided by to be drawn.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from discretization import plots
from discretization.fitted.rest_depths import surfaces_of
from discretization.layer.state import on_layer
from discretization.surfaces.protocol import LinePosition
from energy.arrays import Array
from energy.units import prefixed
from energy.units import quantity as written


class FilmRules(NamedTuple):
    """How a film is drawn.

    Attributes
    ----------
    points : int
        Places at which the surface is drawn: about two a pixel, as the surface has half of
        the picture.
    jump_frames : int
        Frames of a jump: half a second at 15 frames a second, long enough to be seen.
    colours : int
        Colours of a GIF: a picture has about eight, and their shades at edges.
    dots : int
        Dots an inch: the 8.4 inches of the picture are 672 pixels.
    margin : float
        Elastocapillary lengths of free surface beside the widest contact, after which e⁻⁴ = 2 % of
        the displacement at its line are left.
    """

    points: int = 601
    jump_frames: int = 8
    colours: int = 32
    dots: int = 80
    margin: float = 4.0


_FILM = FilmRules()


class Frame(NamedTuple):
    """What one picture shows.

    Attributes
    ----------
    depth, force : float
        [length], and [force/length] or [force].
    surface : ndarray (n,)
        Displacements at the places that are drawn [length].
    jump : str
        What the title says during a jump; "" at an equilibrium.
    """

    depth: float
    force: float
    surface: Array
    jump: str


def animate(
    history: Any, path: str | Path, *, frames: int = 90, rate: int = 15, si: bool = True
) -> Path:
    """Write the path as an animation: indenter, surface, and P(d) with a travelling point.

    Parameters
    ----------
    history : History
    path : str or Path
        The file; its ending says which kind: ".gif", ".webp" or ".png" (an animated one).
    frames, rate : int
        How many frames the states of the path get, each jump getting some more, and how many are
        shown in a second.
    si : bool
        Whether the units are those of SI.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    ValueError
        For a path without contact, a number of frames below 2 or a rate below 1, and a body
        without end.
    """
    if frames < 2 or rate < 1:
        raise ValueError(
            f"frames = {frames!r}, rate = {rate!r}: give at least 2 frames, 1 a second"
        )
    touching = history.contacts[~np.isnan(history.contacts[:, 0])]
    if not touching.size:
        raise ValueError("animate: this path has no state in contact; press the indenter deeper")
    if not np.isfinite(touching).all():
        raise ValueError("animate: the contact of a plane has no end; give a body with edges")
    x = _places(history.scene, touching)
    return _written(history, x, _frames(history, x, frames), Path(path), rate, si)


def _places(scene: Any, touching: Array) -> Array:
    """Positions at which everything is drawn (n,) [length]; about an axis along a diameter.

    touching: the outermost lines of every state in contact (k, 2) [length].
    """
    low = float(touching.min())
    high = float(touching.max())
    low = -high if scene.axisymmetric else low
    beside = _FILM.margin * scene.elastocapillary_length or scene.layer.h
    start, stop = scene.indenter.extent
    return np.linspace(max(low - beside, start), min(high + beside, stop), _FILM.points)


def displacement(history: Any, state: Any, x: Array) -> Array:
    """u(x) of a state of the path, from its depth and contact lines.

    Parameters
    ----------
    history : History
        The path.
    state : Snapshot
        One of its states; in a state out of contact, or infinitely far away, u = 0.
    x : ndarray (n,)
        Positions [length].

    Returns
    -------
    ndarray (n,)
        [length].
    """
    scene = history.scene
    r = np.abs(x) if scene.axisymmetric else x
    if math.isnan(state.left) or not math.isfinite(state.depth):
        return np.zeros_like(r)
    if scene.layer.exact:
        return on_layer(scene, state.depth, branch="adhered", rtol=history.rtol).displacement(x)
    lines = np.array(state.lines)
    ends = lines.reshape(-1, 2)
    inside = ((r[:, None] >= ends[:, 0]) & (r[:, None] <= ends[:, 1])).any(axis=1)
    u = np.where(inside, state.depth - scene.indenter.height(r), 0.0)
    if not scene.gamma1:
        return np.asarray(u)
    heights = np.asarray(scene.indenter.height(lines), float)
    known = [None, *map(LinePosition, lines.tolist(), heights.tolist()), None]
    # Free surface number i is the one beyond i contacts; its lines stand in pairs.
    number = np.where(inside, -1, np.searchsorted(ends[:, 0], r))
    surfaces = surfaces_of(scene)
    for i, (left, right) in enumerate(zip(known[::2], known[1::2], strict=True)):
        own = number == i
        if own.any():
            u[own] = surfaces.shape(r[own], left, right, state.depth)[0]
    return np.asarray(u)


def _frames(history: Any, x: Array, count: int) -> list[Frame]:
    """The pictures, in their order.

    Parameters
    ----------
    history : History
    x : ndarray (n,)
        Positions at which the surface is drawn [length].
    count : int
        How many frames all parts but the jumps get together, about.
    """
    parts = [(kind, states) for kind, states in plots.legs(history) if len(states) > 1]
    every = np.array([(s.depth, s.force) for _, states in parts for s in states])
    size = np.ptp(every, axis=0)  # ranges of depth and force
    size[size == 0] = 1.0

    def length(states: list[Any]) -> Array:
        """Length of the path from the first state to each (n,), in units of `size`."""
        at = np.array([(s.depth, s.force) for s in states]) / size
        return np.append(0.0, np.cumsum(np.hypot(*np.diff(at, axis=0).T)))

    total = sum(length(states)[-1] for kind, states in parts if kind != "jump") or 1.0
    found = list[Frame]()
    for kind, states in parts:
        if kind == "jump":
            found += _jump(history, x, states[0], states[-1])
            continue
        along = length(states)
        steps = max(2, round(count * along[-1] / total))
        # The states at or after even steps of the length, each of them once. Rounding must not take
        # a step beyond the last state: 1e-12 is more than the rounding of a sum over thousands of
        # states, and less than any step between them that can be seen.
        chosen = np.searchsorted(along, np.linspace(0, along[-1], steps) * (1 - 1e-12))
        for i in dict.fromkeys(chosen.tolist()):
            state = states[i]
            found.append(Frame(state.depth, state.force, displacement(history, state, x), ""))
    return found


def _jump(history: Any, x: Array, before: Any, after: Any) -> list[Frame]:
    """Frames of a jump in slow motion, from the snapshot before to the one after, in even steps.

    history, x: the path, and the positions at which surfaces are drawn (n,) [length]. In between
    the surface is the weighted mean of both, which is no equilibrium.
    """
    first, last = (displacement(history, state, x) for state in (before, after))
    found = []
    for part in np.linspace(0, 1, _FILM.jump_frames):
        depth = before.depth + part * (after.depth - before.depth)
        force = before.force + part * (after.force - before.force)
        found.append(Frame(depth, force, first + part * (last - first), "jump, drawn slowly"))
    return found


def _written(history: Any, x: Array, frames: list[Frame], path: Path, rate: int, si: bool) -> Path:
    """Write frames as a file of the kind that its ending names, and return its path.

    rate: frames in a second; x, si: as of `Picture`.
    """
    from PIL import Image

    picture = Picture(history, x, frames, si)
    images = [Image.fromarray(picture.drawn(frame)) for frame in frames]
    colours = [image.quantize(_FILM.colours, dither=Image.Dither.NONE) for image in images]
    shown = colours if path.suffix.lower() == ".gif" else images
    wait = round(1000 / rate)
    shown[0].save(path, save_all=True, append_images=shown[1:], duration=wait, loop=0)
    return path


class Picture:
    """Indenter and surface on the left, P(d) on the right; only what moves is drawn again.

    Parameters
    ----------
    history : History
    x : ndarray (n,)
        Positions at which the surface is drawn [length].
    frames : list of Frame
        All that will be drawn, for the limits of the axes.
    si : bool
        Whether numbers have SI units, which are then written at the axes.

    Attributes
    ----------
    canvas : FigureCanvasAgg
        The picture as colours of its pixels.
    unit : str
        Of lengths, "" for plain numbers.
    force : tuple of Unit
        The units in which depth and force are drawn.
    size : float
        The length by which displacements and heights are divided to be drawn.
    top, bottom : float
        The least and the largest displacement that is shown, so divided.
    x, height : ndarray (n,)
        Positions and heights of the indenter, divided by their units.
    layer, body, line, level, words, point : Artist
        What moves: both filled areas, the surface, the level of the undeformed surface, which only
        has to be drawn over them, the title, and the point on P(d). Together they are `moving`.
    still
        The picture without these.
    """

    def __init__(self, history: Any, x: Array, frames: list[Frame], si: bool) -> None:
        """Draw what stands still, and keep it."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        figure, (left, right) = plots.canvas(8.4, 3.6, 1, 2)
        figure.set_dpi(_FILM.dots)
        self.canvas = FigureCanvasAgg(figure)
        self.unit = "m" if si else ""
        self.force = plots.units(history, "force", si)
        plots.draw_path(right, history, "force", self.force)
        right.axhline(0, color=plots.GREY, lw=0.6, ls=":")
        (self.point,) = right.plot([], [], "o", ms=9, color="black", zorder=9)

        height = np.asarray(history.scene.indenter.height(x), float)
        shown = np.array([frame.surface for frame in frames])
        span = float(np.ptp(shown)) or history.scene.layer.h
        # Above the surface, where u is less, there is room for the indenter; below it the layer.
        ends = [float(shown.min()) - 0.7 * span, float(shown.max()) + 0.4 * span]
        across = prefixed(x, self.unit)
        up = prefixed(ends, self.unit)
        self.size = up.size
        (self.top, self.bottom) = np.array(ends) / up.size
        self.x = x / across.size
        self.height = height / up.size
        self.layer, self.body = (
            left.fill(self.x, self.height, color=colour, lw=0)[0]
            for colour in (plots.SOFT, plots.RIGID)
        )
        (self.line,) = left.plot(self.x, self.height, color=plots.BLUE, lw=2)
        self.level = left.axhline(0, color=plots.GREY, lw=0.8, ls="--")
        self.words = left.set_title(" ", fontsize=10)
        name = "radius r" if history.scene.axisymmetric else "position x"
        left.set(xlim=(self.x[0], self.x[-1]), ylim=(self.bottom, self.top))
        left.set_xlabel(plots.axis(name, across))
        left.set_ylabel(plots.axis("displacement u, downwards,", up).rstrip(","))

        self.moving = (self.layer, self.body, self.line, self.level, self.words, self.point)
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(figure.bbox)

    def drawn(self, frame: Frame) -> Array:
        """The picture of a frame, as colours (height, width, 3), a copy of its own.

        What moves is drawn over what stands still, which was kept when it was drawn once.
        """
        u = frame.surface / self.size
        depth = written(frame.depth, self.unit).replace("-", "−").rstrip()
        self.layer.set_xy(self._area(u, self.bottom))
        self.body.set_xy(self._area(frame.depth / self.size - self.height, self.top))
        self.line.set_data(self.x, u)
        self.words.set_text(frame.jump or f"d = {depth}")
        self.point.set_data([frame.depth / self.force[0].size], [frame.force / self.force[1].size])
        self.canvas.restore_region(self.still)
        for artist in self.moving:
            artist.axes.draw_artist(artist)
        return np.asarray(self.canvas.buffer_rgba())[..., :3].copy()

    def _area(self, values: Array, level: float) -> Array:
        """Corners (n + 2, 2) of what lies between values (n,) over x and a level.

        All in the units that are drawn; values beyond the picture count as its edge.
        """
        inside = np.clip(values, self.top, self.bottom)
        return np.column_stack(
            [
                np.append(self.x, [self.x[-1], self.x[0]]),
                np.append(inside, [level, level]),
            ]
        )
