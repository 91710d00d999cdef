"""How does the contact of this scene change with depth, w and γ₁? Sliders in a window.

The state of the scene file, its surface beside the indenter, the force and the angle, drawn again
as a slider of the depth, of w or of γ₁ is moved. It needs a display that matplotlib knows. States
are those that `minimise` finds on the adhered branch; where there is none, the title says why.
With --picture FILE.png the window is drawn into a file instead, and nothing is shown.
"""

# Conventions:
# - `quantity(value, unit)` is a text such as 20 mN/m.
# - A scene has `gamma1` γ₁, `work_of_adhesion` w, `elastocapillary_length` l = √(γ₁/k) and
#   `critical_separation` δ₀ = √(2w/k).
# - `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
# - `state.displacement(x)` is u, positive into the layer.
# - `contacts` has a row (left, right) for each contact.
# - `load` reads a scene file: scene, depths and title. `program()` is how the command is called.
# - `extent` of an indenter are the ends of what is known of it, `height` its f, upwards.
# - `validity` of a state are assumptions of the model, with whether each `holds`.

import argparse
import math
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from discretization import Equilibrium, minimise, plots
from energy import Scene, SurfaceEnergies
from energy.arrays import Array
from energy.units import quantity
from studies.scenes.file import load
from studies.shared.program import program

POINTS = 801  # of the surface
DECADES = 1.0  # by which w and γ₁ may be changed, up and down
DEEPEST = 3.0  # depths, over the larger of δ₀ and that of the file
WIDEST = 95  # letters in a line of the title
BESIDE = 4.0  # l of free surface drawn beside the contact: 2 % of its height is left there
GROWTH = 1.5  # from one width that is tried to the next
LABELS = {"depth": "d in nm", "log₁₀ w": "log₁₀ w/(J/m²)", "log₁₀ γ₁": "log₁₀ γ₁/(N/m)"}


class Explorer:
    """What the window shows, and how it follows the sliders."""

    def __init__(self, scene: Scene, depth: float, title: str, figure: Any) -> None:
        """Draw the scene at a depth, and sliders for what can be changed, into a figure."""
        from matplotlib.widgets import Slider

        self.scene = scene
        self.figure = figure
        self.axes = figure.add_axes((0.13, 0.36, 0.84, 0.5))
        lift = scene.critical_separation or abs(depth)
        reach = DEEPEST * max(lift, abs(depth))
        self.x = self._places(reach)
        self.height = np.asarray(scene.indenter.height(self._radii()), float)
        across = 1e6 * self.x
        (self.surface,) = self.axes.plot(across, 0 * across, color=plots.BLUE, lw=2)
        (self.body,) = self.axes.plot(across, 0 * across, color=plots.GREY, lw=1.5)
        self.axes.axhline(0, color=plots.GREY, lw=0.8, ls="--")
        place = "radius r" if scene.axisymmetric else "position x"
        self.axes.set(xlabel=f"{place} in µm", ylabel="displacement u, downwards, in nm")
        self.axes.set(xlim=(across[0], across[-1]), ylim=(1.2e9 * reach, -1.2e9 * reach))
        figure.suptitle(title)
        w = scene.work_of_adhesion
        gamma1 = scene.gamma1
        start = {"depth": (depth, -reach, reach)}
        for name, value in (("log₁₀ w", w), ("log₁₀ γ₁", gamma1)):
            if value:
                middle = math.log10(value)
                start[name] = (middle, middle - DECADES, middle + DECADES)
        self.sliders: dict[str, Any] = {}
        for row, (name, (value, low, high)) in enumerate(start.items()):
            place = figure.add_axes((0.2, 0.19 - 0.07 * row, 0.6, 0.04))
            shown = LABELS[name]
            size = 1e9 if name == "depth" else 1.0
            slider = Slider(place, shown, size * low, size * high, valinit=size * value)
            slider.drawon = False  # it is drawn with what moves
            slider.on_changed(self.follow)
            self.sliders[name] = slider
        self.words = self.axes.set_title(" ", fontsize=9)
        self.moving = [self.surface, self.body, self.words]
        for slider in self.sliders.values():
            self.moving += [slider.poly, slider.valtext, *slider.ax.lines]
        for artist in self.moving:
            artist.set_animated(True)
        self.still: Any = None
        figure.canvas.mpl_connect("draw_event", self.drawn)
        self.follow()

    def drawn(self, _: Any = None) -> None:
        """The window has been drawn, without what moves: keep that, and add what moves."""
        self.still = self.figure.canvas.copy_from_bbox(self.figure.bbox)
        for artist in self.moving:
            self.figure.draw_artist(artist)

    def _places(self, reach: float) -> Array:
        """Positions drawn: as far as the profile rises by what the depth may be."""
        low, high = self.scene.indenter.extent
        beside = BESIDE * self.scene.elastocapillary_length or self.scene.layer.h
        size = beside
        while size < high and float(self.scene.indenter.height(size)) < reach:
            size *= GROWTH
        return np.linspace(max(low, -size - beside), min(high, size + beside), POINTS)

    def _radii(self) -> Array:
        """What the profile takes at the drawn places: distances from the axis, or places."""
        return np.abs(self.x) if self.scene.axisymmetric else self.x

    def chosen(self) -> tuple[Scene, float]:
        """The scene and the depth that the sliders say."""
        value = {name: slider.val for name, slider in self.sliders.items()}
        w = 10.0 ** value["log₁₀ w"] if "log₁₀ w" in value else self.scene.work_of_adhesion
        gamma1 = 10.0 ** value["log₁₀ γ₁"] if "log₁₀ γ₁" in value else self.scene.gamma1
        surfaces = SurfaceEnergies.from_work(gamma1, w)
        return replace(self.scene, surfaces=surfaces), 1e-9 * value["depth"]

    def follow(self, _: float = 0.0) -> None:
        """Find the state of the sliders and draw it."""
        scene, depth = self.chosen()
        try:
            state = minimise(scene, depth)
        except (ValueError, RuntimeError) as problem:
            self._say(str(problem)[: 2 * WIDEST], plots.ORANGE)
        else:
            self._show(state)
        if self.still is not None:
            self.figure.canvas.restore_region(self.still)
            for artist in self.moving:
                self.figure.draw_artist(artist)
            self.figure.canvas.blit(self.figure.bbox)

    def _say(self, text: str, colour: str) -> None:
        """Write a text below the figure, in lines of WIDEST characters."""
        self.words.set_text(textwrap.fill(text, WIDEST))
        self.words.set_color(colour)

    def _show(self, state: Equilibrium) -> None:
        """Move the curves of surface and indenter to a state, and write its numbers [nm, SI]."""
        self.surface.set_ydata(1e9 * state.displacement(self.x))
        self.body.set_ydata(1e9 * (state.depth - self.height))
        per = self.scene.per_length
        told = [f"w = {quantity(state.scene.work_of_adhesion, 'J/m²')}", state.label]
        told.insert(0, f"P = {quantity(state.force, f'N{per}')}")
        told.insert(1, f"γ₁ = {quantity(state.scene.gamma1, 'N/m')}")
        if state.contacts.size:
            told.insert(1, f"a = {quantity(state.half_width, 'm')}")
            told.insert(2, f"θ = {math.degrees(state.contact_angle):.2f}°")
        broken = [one.name for one in state.validity if not one.holds]
        told += [f"outside the model: {', '.join(broken)}"] if broken else []
        self._say(", ".join(told), plots.ORANGE if broken else "black")


def main(argv: Sequence[str] | None = None) -> int:
    """Open the window; 2 where there is no display."""
    parser = argparse.ArgumentParser(prog=f"{program()} explore", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("scene", type=Path, help="scene file, for instance studies/scenes/*.toml")
    about = "draw the window into this file instead of showing it"
    parser.add_argument("--picture", type=Path, metavar="FILE.png", help=about)
    options = parser.parse_args(argv)
    given = load(options.scene)
    depth = float(given.depths[0]) if given.depths.size else 0.0
    if options.picture:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8, 6))
        canvas = FigureCanvasAgg(figure)
        Explorer(given.scene, depth, given.title, figure)
        canvas.draw()
        canvas.print_png(options.picture)
        print(f"written: {options.picture}")
        return 0
    from matplotlib import pyplot

    if pyplot.get_backend().lower() in ("agg", "pdf", "svg", "ps", "cairo", "template"):
        raise ValueError("there is no display for a window; give --picture FILE.png")
    figure = pyplot.figure(figsize=(8, 6))
    kept = Explorer(given.scene, depth, given.title, figure)  # sliders live as long as this
    pyplot.show()
    del kept
    return 0
