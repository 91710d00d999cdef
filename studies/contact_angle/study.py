"""Is the contact angle a constant set by the surface energies alone? Section 3 of the paper.

    γ₁₂ + γ₁ cos θ - γ₂ = 0,  that is  cos θ = w/γ₁ - 1   (8);   π - θ ≈ √(2w/γ₁)            (15)

What is imposed is an energy of springs, surface and adhesion; no angle stands in it. The angle is
measured (12), between the indenter and the free surface at the contact line, and compared with
Young's (8) where the energy has true surface lengths (slopes="finite"), with (15) where slopes are
small. Two comparisons, of different weight:

- on nodes energies of contact sets are compared and nothing else. Here the law *emerges*: the error
  of θ falls with the square of the spacing;
- on the mesh a line rests where ∂U/∂x = 0, which has been worked out by hand and is the law in
  other words. What agrees there is that states are stationary, for any indenter and depth, on a
  loading path, along a line and around an axis.

Lines that mirror each other count once. A line that is pinned at a corner has no law to obey and is
left out; how far the angle varies there is measured at the edge of a flat punch.

Output: contact_angle.png and .csv, angle_on_nodes.png and .csv, loading_path.png, the numbers on
the screen; exit status 1 if a law is missed.
"""

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - A `Table` is the names of its columns, and its rows.
# - `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to
#   this depth, d positive into the layer; with method="lattice" it is that on nodes of a spacing.
# - A scene has `gamma1` γ₁, `work_of_adhesion` w and `critical_separation` δ₀ = √(2w/k).
# - `FlatPunch(half_width)` has f = 0 up to its edges; `PowerLaw(c, n)` is f = c|x|ⁿ.
# - `surfaces.small_slope_deficit` is π - θ = √(2w/γ₁) (15); `surfaces.angle_deficit` is that of
#   Young's law (8); `angle_deficit` of a state is its own π - θ.
# - `scene(body, γ₁, w, slopes, geometry)` has k = 1.
# - `depth_by_16(scene, a)` is the depth at which (16) has the half-width a, `simulated` the
#   equilibrium, or None where its surface would turn over, and `detachment` the depth at which the
#   contact is lost.
# - Of a state `line_slopes` are the slopes f' and u' outwards, `angle_deficits` π - θ, and `pinned`
#   whether a corner holds the line: each (m, 2), at the left and right ends of m contacts.
# - `apex` is the x of the lowest point.

import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from discretization import Equilibrium, minimise
from energy import FlatPunch, Indenter, Parabola, PowerLaw, Scene, Wedge
from studies.contact_angle.record import (
    FULL,
    QUICK,
    Angle,
    Loop,
    OnNodes,
    Parameters,
    Record,
    plot,
    plot_nodes,
    plot_path,
)
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.small_slopes import depth_by_16, detachment, scene, simulated
from studies.shared.table import Table

# Lengths are in l (k = γ₁ = 1). Flanks are gentle and steep, straight and curved, so that the
# inclinations of indenter and surface share the angle in many ways; TILTED have two unlike lines.
INDENTERS: dict[str, Indenter] = {
    "wedge": Wedge(math.atan(0.1)),
    "steep wedge": Wedge(math.atan(1.0)),
    "parabola": Parabola(4.0),
    "cubic": PowerLaw(0.1, 3.0),
    "wedge + parabola": (Wedge(0.05) + Parabola(6.0)).shifted(0.3),
}
TILTED: dict[str, Indenter] = {
    "tilted parabola": Parabola(4.0).tilted(0.1),
    "parabola + shifted one": Parabola(5.0) + Parabola(9.0).shifted(0.7),
}
ROUND: dict[str, Indenter] = {
    "sphere": Parabola(4.0),
    "cone": Wedge(math.atan(0.1)),
    "cubic of revolution": PowerLaw(0.1, 3.0),
}
SHAPES = {**INDENTERS, **TILTED, **ROUND}
ON_NODES = ("wedge", "parabola", "cubic", "wedge + parabola")
NODE_WIDTHS = np.linspace(1.0, 2.0, 4)  # a/l: the line lies anywhere between its nodes
MIRRORED = 1e-9  # relative difference of two inclinations that mirror each other
STEEPEST = 0.75  # w/γ₁ of finite slopes with rotational symmetry: no surfaces beyond 86°


def given(shape: str, ratio: float, slopes: str) -> Scene:
    """The scene of one of the SHAPES at this w/γ₁.

    Parameters
    ----------
    shape : str
    ratio : float
        w/γ₁.
    slopes : {"small", "finite"}

    Returns
    -------
    Scene
    """
    geometry = "axisymmetric" if shape in ROUND else "line"
    return scene(SHAPES[shape], 1.0, ratio, slopes, geometry)


def measured(kind: str, shape: str, state: Equilibrium) -> Iterator[Angle]:
    """The angle at each contact line of a state that no corner pins, mirror twins once.

    Parameters
    ----------
    kind : {"finite", "small"}
        Slopes of the energy.
    shape : str
    state : Equilibrium

    Yields
    ------
    Angle
    """
    scene = state.scene
    surfaces = state.scene.surfaces
    law = surfaces.angle_deficit if kind == "finite" else surfaces.small_slope_deficit
    slopes_of_indenter, slopes_of_layer = state.line_slopes
    indenter = np.arctan(slopes_of_indenter).ravel()
    layer = np.arctan(slopes_of_layer).ravel()
    ratio = scene.work_of_adhesion / scene.gamma1
    free = np.flatnonzero(~state.pinned & np.isfinite(state.angle_deficits))
    if len(free) == 2:
        first, second = indenter[free]
        if abs(first - second) <= MIRRORED * abs(second):
            free = free[1:]
    for i in free:
        yield Angle(
            kind=kind,
            shape=shape,
            ratio=ratio,
            depth=state.depth,
            half_width=state.half_width,
            deficit=float(state.angle_deficits.flat[i]),
            law=law,
            indenter=float(indenter[i]),
            layer=float(layer[i]),
        )


def single(p: Parameters, shape: str) -> list[Angle]:
    """States at many w/γ₁ and depths; those that would turn over are left out."""
    body = SHAPES[shape]
    found = list[Angle]()
    for ratio in p.ratios:
        small = given(shape, ratio, "small")
        if shape in TILTED:
            found += measured("small", shape, minimise(small, 0.5))
            continue
        for width in p.widths:
            depth = depth_by_16(small, (body.apex or 0.0) + width)
            found += measured("small", shape, minimise(small, depth))
            steep = shape in ROUND and ratio > STEEPEST
            state = None if steep else simulated(given(shape, ratio, "finite"), depth)
            if state is not None:
                found += measured("finite", shape, state)
    return found


def loop(steps: int, case: tuple[str, float]) -> Loop:
    """Touch, press to 2δ₀, pull until just before the contact detaches; finite slopes."""
    shape, ratio = case
    steep = given(shape, ratio, "finite")
    end = detachment(steep)
    top = 2 * steep.critical_separation
    pressing = np.linspace(0, top, steps)
    pulling = top + (end - top) * np.linspace(0, 0.999, 2 * steps)
    angles = []
    for depth in np.concatenate([pressing, pulling]).tolist():
        state = minimise(steep, depth)
        angles.append(next(measured("finite", shape, state)))
    return Loop(shape, ratio, tuple(angles[:steps]), tuple(angles[steps:]))


def on_nodes(counts: Sequence[int], ratio: float, case: tuple[str, str]) -> OnNodes:
    """The largest error of θ on nodes of several distances.

    Parameters
    ----------
    counts : sequence of int
        Numbers of nodes in l.
    ratio : float
        w/γ₁.
    case : tuple of str
        Kind of slopes and shape.

    Returns
    -------
    OnNodes
    """
    kind, shape = case
    scene = given(shape, ratio, kind)
    surfaces = scene.surfaces
    law = surfaces.angle_deficit if kind == "finite" else surfaces.small_slope_deficit
    middle = scene.indenter.apex or 0.0
    depths = [depth_by_16(given(shape, ratio, "small"), middle + a) for a in NODE_WIDTHS]
    worst = []
    for count in counts:
        errors = []
        for depth in depths:
            state = minimise(scene, depth, method="lattice", spacing=1 / count)
            errors.append(float(np.abs(state.angle_deficits - law).max()))
        worst.append(math.degrees(max(errors)))
    return OnNodes(kind, shape, tuple(counts), tuple(worst))


def at_the_edge(ratio: float) -> tuple[float, ...]:
    """π - θ over √(2w/γ₁) at the edge of a flat punch, where its contact line is pinned."""
    punch = scene(FlatPunch(1.0), 1.0, ratio, "small")
    depths = punch.critical_separation * np.linspace(-0.999, 0.999, 5)
    states = (minimise(punch, float(depth)) for depth in depths)
    return tuple(one.angle_deficit / punch.surfaces.small_slope_deficit for one in states)


def run(p: Parameters = FULL, show: Show = silent, jobs: int = 1) -> Record:
    """Measure all angles in `jobs` processes; `show` gets a line as each part begins.

    Free surfaces around an axis are read off a family that a process solves once: one process.

    Parameters
    ----------
    p : Parameters
    show : callable, optional
        Gets a line of text as soon as one is there.
    jobs : int
        Number of processes.

    Returns
    -------
    Record
    """
    show(f"{len(p.ratios)} w/γ₁ x {len(SHAPES)} indenters x {len(p.widths)} depths ...")
    states: list[Angle] = []
    for shapes, workers in (([*INDENTERS, *TILTED], jobs), (list(ROUND), 1)):
        for angles in each(partial(single, p), shapes, workers):
            states += angles
    show(f"loading paths at {len(p.path)} w/γ₁ ...")
    paths = [(shape, ratio) for shape in ("wedge", "parabola") for ratio in p.path]
    loops = tuple(each(partial(loop, p.steps), paths, jobs))
    show(f"on nodes: {len(ON_NODES)} indenters x {len(p.nodes)} spacings ...")
    cases = [(kind, shape) for kind in ("finite", "small") for shape in ON_NODES]
    nodes = tuple(each(partial(on_nodes, p.nodes, p.node_ratio), cases, jobs))
    return Record(p, tuple(states), loops, nodes, at_the_edge(p.ratios[0]))


def summary(record: Record) -> str:
    """How many contact lines of each kind obey their law, and how well."""
    finite = record.of("finite")
    small = record.of("small")
    around = [angle for angle in record.states if angle.shape in ROUND]
    worst = max(angle.residual for angle in around)
    lines = [
        "on nodes, where energies of contact sets are compared and nothing else:",
        f"  w/γ₁ = {record.parameters.node_ratio:g}: error of θ in degrees on "
        f"{', '.join(map(str, record.parameters.nodes))} nodes in l",
    ]
    for one in record.nodes:
        errors = ", ".join(f"{error:.2g}" for error in one.errors)
        lines.append(f"  {one.kind:6s} slopes, {one.shape:17s} {errors}; order {one.order:.2f}")
    lines += [
        "on the mesh, where a line rests at ∂U/∂x = 0:",
        f"  finite slopes: {len(finite)} contact lines: π - θ is Young's (8), relative error at "
        f"most {record.worst('finite'):.0e}",
        f"  small slopes:  {len(small)} contact lines: π - θ is (15), relative error at most "
        f"{record.worst('small'):.0e}",
        f"  of these around an axis: {len(around)} contact lines, at most {worst:.0e}",
        "lines that mirror each other count once; lines pinned at corners do not count: at the",
        f"edge of a flat punch π - θ runs from {min(record.edge):.2f} to {max(record.edge):.2f} "
        "times √(2w/γ₁) with the depth",
    ]
    return "\n".join(lines)


def answer(record: Record) -> str:
    """Whether the angle is that of its law everywhere."""
    lines = len(record.states) + sum(len(loop.angles) for loop in record.loops)
    worst = max(record.worst("finite"), record.worst("small"))
    degrees, count = record.on_nodes
    if record.passed:
        return (
            "Yes. Where energies of contact sets on nodes are compared and nothing else, θ comes "
            f"out as Young's with second order, within {degrees:.1g}° on {count} nodes in l. On "
            f"the mesh, where lines rest at ∂U/∂x = 0, {lines} distinct free lines agree, relative "
            f"error of π - θ at most {worst:.0e}. A line pinned at a corner has another angle."
        )
    return (
        f"Not as simulated: on the mesh π - θ differs from its law by up to {worst:.0e} of itself, "
        f"on nodes θ by up to {degrees:.1g}° with {count} nodes in l."
    )


def table(record: Record) -> Table:
    """Columns and a row per measured angle; lengths in l, angles in rad."""
    rows = [["state", *angle, angle.residual] for angle in record.states]
    for one in record.loops:
        for i, angle in enumerate(one.angles):
            part = "advance" if i < len(one.advance) else "retract"
            rows.append([part, *angle, angle.residual])
    return ["part", *Angle._fields, "residual"], rows


def node_table(record: Record) -> Table:
    """Columns and a row per indenter and number of nodes in l; errors of θ in degrees."""
    rows = [
        [one.kind, one.shape, count, error, one.order]
        for one in record.nodes
        for count, error in zip(one.counts, one.errors, strict=True)
    ]
    return ["kind", "shape", "nodes_in_l", "error_degrees", "order"], rows


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if a measured angle misses its law."""
    preset, jobs, out = command.start("contact_angle", __doc__, argv, "fewer states", FULL, QUICK)
    record = run(preset, command.say, jobs)
    drawn = {"angle_on_nodes.png": plot_nodes(record), "contact_angle.png": plot(record)}
    out.figures({**drawn, "loading_path.png": plot_path(record)})
    out.table("contact_angle.csv", preset, *table(record))
    out.table("angle_on_nodes.csv", preset, *node_table(record))
    print(summary(record))
    command.answer(answer(record))
    return 0 if record.passed else 1
