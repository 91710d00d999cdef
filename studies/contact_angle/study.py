"""Is the contact angle a constant set by the surface energies alone? Section 3 of the paper.

    γ₁₂ + γ₁ cos θ - γ₂ = 0,  that is  cos θ = w/γ₁ - 1   (8);   π - θ ≈ √(2w/γ₁)            (15)

The energies that are minimised hold no angle: it is measured, at every contact line, as the angle
between the indenter and the simulated surface beside it (12). With true surface lengths
(slopes="finite") it should be Young's (8), with small slopes (15), whatever the indenter, the depth
and the way there, along a line or around an axis. (`verify` has both equations on nodes, too.)

Output: contact_angle.png and .csv, the numbers on the screen; exit status 1 if a law is missed.
"""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import chain

import numpy as np

from discretization import Equilibrium, minimise
from energy import Indenter, Parabola, PowerLaw, Scene, Wedge
from studies.contact_angle.record import FULL, QUICK, Angle, Loop, Parameters, Record, plot
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.small_slopes import depth_by_16, detachment, scene, simulated
from studies.shared.table import Table

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
STEEPEST = 0.75  # w/γ₁ of finite slopes with rotational symmetry: no surfaces beyond 86°


def given(shape: str, ratio: float, slopes: str) -> Scene:
    """The scene of one of the SHAPES at this w/γ₁."""
    geometry = "axisymmetric" if shape in ROUND else "line"
    return scene(SHAPES[shape], 1.0, ratio, slopes, geometry)


def measured(kind: str, shape: str, state: Equilibrium) -> Iterator[Angle]:
    """The angle at each contact line of a state that no corner pins."""
    scene, surfaces = state.scene, state.scene.surfaces
    law = surfaces.angle_deficit if kind == "finite" else surfaces.small_slope_deficit
    indenter, layer = (np.arctan(slope).ravel() for slope in state.line_slopes)
    ratio = scene.work_of_adhesion / scene.gamma1
    for i in np.flatnonzero(~state.pinned & np.isfinite(state.angle_deficits)):
        seen = float(state.angle_deficits.flat[i]), law, float(indenter[i]), float(layer[i])
        yield Angle(kind, shape, ratio, state.depth, state.half_width, *seen)


def single(p: Parameters, shape: str) -> list[Angle]:
    """States at many w/γ₁ and depths; those that would turn over are left out."""
    body, found = SHAPES[shape], list[Angle]()
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
    end, top = detachment(steep), 2 * steep.critical_separation
    depths = [*np.linspace(0, top, steps), *(top + (end - top) * np.linspace(0, 0.999, 2 * steps))]
    states = (minimise(steep, float(depth)) for depth in depths)
    angles = [next(measured("finite", shape, state)) for state in states]
    return Loop(shape, ratio, tuple(angles[:steps]), tuple(angles[steps:]))


def run(p: Parameters = FULL, show: Show = silent, jobs: int = 1) -> Record:
    """Measure all angles in `jobs` processes; `show` gets a line as each part begins.

    Free surfaces around an axis are read off a family that a process solves once: one process.
    """
    show(f"{len(p.ratios)} w/γ₁ x {len(SHAPES)} indenters x {len(p.widths)} depths ...")
    own, groups = partial(single, p), (([*INDENTERS, *TILTED], jobs), (list(ROUND), 1))
    found = chain.from_iterable(each(own, shapes, workers) for shapes, workers in groups)
    states = tuple(chain.from_iterable(found))
    show(f"loading paths at {len(p.path)} w/γ₁ ...")
    ways = [(shape, ratio) for shape in ("wedge", "parabola") for ratio in p.path]
    loops = tuple(each(partial(loop, p.steps), ways, jobs))
    return Record(p, states, loops)


def summary(record: Record) -> str:
    """How many contact lines of each kind obey their law, and how well."""
    finite, small = record.of("finite"), record.of("small")
    around = [angle for angle in record.states if angle.shape in ROUND]
    worst = max(angle.residual for angle in around)
    return (
        f"finite slopes: {len(finite)} contact lines: π - θ is Young's (8) within "
        f"{record.worst('finite'):.0e} of itself\n"
        f"small slopes:  {len(small)} contact lines: π - θ is (15) within "
        f"{record.worst('small'):.0e} of itself\n"
        f"of these around an axis: {len(around)} contact lines, within {worst:.0e}"
    )


def answer(record: Record) -> str:
    """Whether the angle is that of its law everywhere."""
    lines = len(record.states) + sum(len(loop.angles) for loop in record.loops)
    worst = max(record.worst("finite"), record.worst("small"))
    if record.passed:
        return (
            f"Yes: at {lines} contact lines π - θ is that of its law within {worst:.0e} of itself."
        )
    return f"Not as simulated: π - θ differs from its law by up to {worst:.0e} of itself."


def table(record: Record) -> Table:
    """Columns and a row per measured angle; lengths in l, angles in rad."""
    rows = [["state", *angle, angle.residual] for angle in record.states]
    for one in record.loops:
        for i, angle in enumerate(one.angles):
            part = "advance" if i < len(one.advance) else "retract"
            rows.append([part, *angle, angle.residual])
    return ["part", *Angle._fields, "residual"], rows


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if a measured angle misses its law."""
    preset, jobs, out = command.start("contact_angle", __doc__, argv, "fewer states", FULL, QUICK)
    record = run(preset, command.say, jobs)
    out.figure("contact_angle.png", plot(record))
    out.table("contact_angle.csv", preset, *table(record))
    print(summary(record))
    command.answer(answer(record))
    return 0 if record.passed else 1
