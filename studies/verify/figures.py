"""The figures of `verify`: simulated curves beside their closed forms, and how they are drawn.

Conventions:

- `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
- `prefixed(values, unit)` is the unit with a prefix that suits the values: they are divided by its
  `size`, and its `symbol` is written.
- A scene has `elastocapillary_length` l = √(γ₁/k) and `critical_separation` δ₀ = √(2w/k).
- `FlatPunch(half_width)` has f = 0 up to its edges.
- `surfaces.small_slope_deficit` is π - θ = √(2w/γ₁) (15).
- `Grid(cells)` solves on that many links in l; `brink(mesh, scene)` is a depth just short of
  detachment; `constants(scene)` are k, γ₁ and w by name.
- PUNCH, WEDGE and PARABOLA are the indenters of the checks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from energy import FlatPunch, Indenter, Scene, cards
from energy.units import Unit, prefixed
from studies.shared.figures import BLUE, COLOURS, LINE, MARKERS, ORANGE, Figure, canvas
from studies.verify.mesh import Array, Grid
from studies.verify.observe import brink
from studies.verify.scenes import PARABOLA, PUNCH, WEDGE, case, constants, gel

LAYER = "#d9d9d9"
BASE = "#7f7f7f"
BODY = "#bcd4e6"
_BESIDE = 1e-3  # how far from its end, in δ₀, a branch is drawn
GRID = Grid(100, 0.23)  # nodes in l, and their shift sideways, which no symmetry has


class Meniscus(NamedTuple):
    """The surface under and beside a flat punch that is about to detach.

    Attributes
    ----------
    scene : Scene
    half_width, depth : float
        Of the punch.
    x : ndarray (n,)
    u, closed_form : ndarray (n,)
        Displacement, simulated and by Eq. (21).
    """

    scene: Scene
    half_width: float
    depth: float
    x: Array
    u: Array
    closed_form: Array

    def scaled(self, size: float) -> Meniscus:
        """All lengths in units of `size`."""
        a = self.half_width / size
        d = self.depth / size
        return Meniscus(self.scene, a, d, self.x / size, self.u / size, self.closed_form / size)


Law = tuple[Callable[..., Any], str]  # a closed form, and where it stands in the paper


class Branch(NamedTuple):
    """a(d) and P(d) of a case study.

    Attributes
    ----------
    name : str
    depths, half_widths, forces : ndarray (n,)
        Simulated.
    half_width, force : Law
        Closed forms of a depth.
    """

    name: str
    depths: Array
    half_widths: Array
    forces: Array
    half_width: Law
    force: Law


class Curves(NamedTuple):
    """Everything the figures show."""

    meniscus: Meniscus
    branches: list[Branch]


def simulate(points: int) -> Curves:
    """All curves; `points` simulated states on each branch, from just before it detaches."""
    flat = cards.flat_punch
    wedge = cards.wedge
    parabola = cards.parabola
    dry = cards.nonadhesive
    scene, _, given = case(WEDGE, ())
    end_of_wedge = float(wedge.detachment_depth(**given)) / scene.critical_separation
    edge: Law = (lambda d, a, **_: a + 0 * d, "edge of the punch")
    force: Law = (flat.force, "Eq. (11)")
    branches = [branch(points, "flat punch", PUNCH, -1 + _BESIDE, edge, force)]

    half_width: Law = (wedge.half_width, "Eq. (25)")
    force = (wedge.force, "Eq. (27)")
    branches.append(branch(points, "wedge", WEDGE, end_of_wedge + _BESIDE, half_width, force))

    half_width = (parabola.half_width, "Eq. (33)")
    force = (parabola.force, "Eq. (11)")
    branches.append(branch(points, "parabola", PARABOLA, -1 + _BESIDE, half_width, force))

    half_width = (dry.parabola_half_width, "Eq. (39)")
    force = (dry.parabola_force, "Eq. (40)")
    branches.append(branch(points, "parabola, w = 0", PARABOLA, _BESIDE, half_width, force, w=0.0))
    return Curves(meniscus(), branches)


def branch(
    points: int,
    name: str,
    indenter: Indenter,
    least: float,
    half_width: Law,
    force: Law,
    **options: float,
) -> Branch:
    """A case study from a least depth to 3/2 of δ₀ of the gel film.

    Parameters
    ----------
    points : int
        Simulated depths.
    name : str
    indenter : Indenter
    least : float
        Least depth over δ₀ of the gel film.
    half_width, force : Law
    options : optional
        Of `gel`.

    Returns
    -------
    Branch
    """
    scene, _, given = case(indenter, (), **options)
    depths = np.linspace(least, 1.5, points) * gel(PUNCH).critical_separation
    states = [GRID.solve(scene, d) for d in depths]
    half_widths = np.array([state.half_width for state in states])
    forces = np.array([state.force for state in states])
    law_of_width = partial(half_width[0], **given)
    law_of_force = partial(force[0], **given)
    return Branch(
        name,
        depths,
        half_widths,
        forces,
        (law_of_width, half_width[1]),
        (law_of_force, force[1]),
    )


def meniscus() -> Meniscus:
    """A punch pulled upward, drawn as in Fig. 2 of the paper."""
    punch = FlatPunch(1.2e-4)
    scene = gel(punch)
    depth = brink(GRID, scene)
    a = punch.half_width
    x = np.linspace(-2.4e-4, 2.4e-4, 481)
    u = GRID.solve(scene, depth).displacement(x)
    closed_form = np.array(cards.flat_punch.displacement(x, a=a, **constants(scene)))
    return Meniscus(scene, a, depth, x, u, closed_form)


def punch_and_meniscus(data: Meniscus) -> Figure:
    """The paper's Fig. 2: punch, layer on its base, meniscus; the meniscus enlarged below."""
    figure, (whole, close) = canvas(8, 7, 2, 1, height_ratios=(1.25, 1))
    unit = prefixed(data.scene.layer.h, "m")
    drawn = data.scaled(unit.size)
    _draw_bodies(whole, drawn, data.scene.layer.h / unit.size)
    _draw_dimensions(whole, drawn, data.scene.layer.h / unit.size, unit.symbol)
    whole.set_title("Flat punch pulled upward, just before it detaches (heights stretched)")
    right = drawn.x >= 0.8 * drawn.half_width
    x = drawn.x[right]
    top = -drawn.u[right]
    close.fill_between(x, top, 0.15 * drawn.depth, color=LAYER)
    close.plot(x, top, color=BLUE, lw=3, label="simulated surface")
    close.plot(x, -drawn.closed_form[right], "--", color=ORANGE, label="Eq. (21)")
    close.axvline(drawn.half_width, color=BASE, lw=0.8, ls=":", label="edge of the punch")
    _draw_angle_and_length(close, drawn, x, unit)
    error = np.max(np.abs(data.u - data.closed_form)) / abs(data.depth)
    nodes = f"{GRID.cells:g} nodes in l, error O(Δx²)"
    close.set_title(f"Right edge: {nodes}, {error:.1e} $|d_c|$ from Eq. (21) at most")
    close.set(xlim=(x[0], x[-1]), ylim=(0.15 * drawn.depth, -1.1 * drawn.depth))
    for axes in (whole, close):
        axes.set(xlabel=f"x in {unit.symbol}", ylabel=f"height in {unit.symbol}")
    close.legend()
    return figure


def _draw_angle_and_length(axes: Any, data: Meniscus, x: Array, unit: Unit) -> None:
    """The angle at the line, and l, on the enlarged meniscus; lengths in `unit`."""
    a = data.half_width
    face = -data.depth
    length = data.scene.elastocapillary_length / unit.size
    level = -0.06 * face
    axes.axvline(a + length, color=BASE, lw=0.8, ls=":")
    axes.annotate("", (a, level), (a + length, level), arrowprops={"arrowstyle": "<->"})
    axes.text(a + length / 2, level, f"l = {length:.0f} {unit.symbol}", ha="center", va="bottom")
    axes.fill_between([x[0], a], face, 1.1 * face, color=BODY, ec=BASE)
    deficit = data.scene.surfaces.small_slope_deficit
    axes.plot([a, a + length], [face, face - deficit * length], color="black", lw=1.0)
    text = f"tangent inclined by π − θ = {np.degrees(deficit):.2g}° (15)"
    place = a + 0.5 * length, face - 0.5 * deficit * length
    axes.annotate(text, place, (a + 0.7 * length, 0.58 * face), arrowprops={"arrowstyle": "->"})


def _draw_bodies(axes: Any, data: Meniscus, h: float) -> None:
    """Base, layer with the simulated surface on top, punch; closed form dashed."""
    x = data.x
    top = -data.u
    a = data.half_width
    face = -data.depth
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
    a = data.half_width
    face = -data.depth
    both = {"arrowstyle": "<->"}
    one = {"arrowstyle": "-|>", "lw": 2.0, "color": "black"}
    in_punch = face + 0.2 * h
    axes.annotate("", (0, in_punch), (a, in_punch), arrowprops=both)
    axes.text(a / 2, face + 0.24 * h, f"a = {a:.0f} {unit}", ha="center", va="bottom")
    in_layer = -0.8 * a
    axes.annotate("", (in_layer, -h), (in_layer, 0), arrowprops=both)
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
    figure, grid = canvas(12.5, 6.2, 2, len(branches), sharex="col")
    dense = [np.linspace(data.depths[0], data.depths[-1], 301) for data in branches]
    pairs = list(zip(branches, dense, strict=True))
    widths = [np.asarray(data.half_width[0](d)) for data, d in pairs]
    forces = [np.asarray(data.force[0](d)) for data, d in pairs]
    depth = prefixed(np.concatenate(dense), "m")
    width = prefixed(np.concatenate(widths), "m")
    force = prefixed(np.concatenate(forces), "N/m")
    for i, (column, (data, d)) in enumerate(zip(grid.T, pairs, strict=True)):
        style: dict[str, Any] = {"ls": "", "color": COLOURS[i], "marker": MARKERS[i]}
        x = d / depth.size
        simulated = data.depths / depth.size
        column[0].plot(x, widths[i] / width.size, label=data.half_width[1], **LINE)
        column[1].plot(x, forces[i] / force.size, label=data.force[1], **LINE)
        column[0].plot(simulated, data.half_widths / width.size, label="simulated", **style)
        column[1].plot(simulated, data.forces / force.size, label="simulated", **style)
        column[1].axhline(0, color="black", lw=0.7, ls=":")
        column[0].set_title(data.name)
        column[0].set_ylim(np.array([-0.05, 1.15]) * widths[i].max() / width.size)
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
