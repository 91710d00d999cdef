"""Is the contact angle a constant set by the surface energies alone? Section 3 of the paper.

    γ₁₂ + γ₁ cos θ - γ₂ = 0,  that is  cos θ = w/γ₁ - 1   (8);   π - θ ≈ √(2w/γ₁)            (15)

The energies that are minimised hold no angle: it is measured, at every contact line, as the angle
between the indenter and the simulated surface beside it (12). With true surface lengths
(slopes="finite") it should be Young's (8), with small slopes (15), whatever the indenter, the depth
and the way there; `method="lattice"` should recover (15) from nodes a spacing apart.

Output: contact_angle.png and .csv, the numbers on the screen; exit status 1 if a law is missed.
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from discretization import Equilibrium, minimise
from energy import Indenter, Parabola, PowerLaw, Scene, Wedge
from studies.contact_angle_figure import plot
from studies.small_slopes import depth_by_16, letting_go, scene, simulated

BAR = 1e-8  # of π - θ, for the fitted mesh
ORDER = (1.8, 2.2)  # of the lattice

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


@dataclass(frozen=True)
class Parameters:
    """ratios: w/γ₁; widths: a/l by Eq. (16); path: w/γ₁ of the loading paths, with `steps` depths
    each way; spacings: l/Δx of the lattices, each shifted sideways by offsets·Δx."""

    ratios: tuple[float, ...]
    widths: tuple[float, ...]
    path: tuple[float, ...]
    steps: int
    cells: tuple[int, ...]
    offsets: tuple[float, ...]


FULL = Parameters(
    ratios=(1e-4, 1e-3, 0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.95, 1.0, 1.2, 1.4, 1.6),
    widths=(0.2, 1.1, 5.0),
    path=(0.01, 0.1, 0.5),
    steps=24,
    cells=(25, 50, 100, 200),
    offsets=(0.0, 0.23, 0.5, 0.81),
)
QUICK = Parameters(
    ratios=(1e-4, 0.01, 0.1, 0.5, 1.2),
    widths=(0.3, 2.0),
    path=(0.1, 0.5),
    steps=6,
    cells=(25, 50, 100, 200),
    offsets=(0.0, 0.37),
)


class Angle(NamedTuple):
    """One measured angle: kind is "finite", "small" or "lattice" (small slopes).

    deficit: π - θ; law: by (8) for "finite", (15) else; half_width: simulated a; indenter, layer:
    inclinations of both at the right line [rad]; estimate: expected error of the deficit.
    """

    kind: str
    shape: str
    ratio: float
    depth: float
    half_width: float
    deficit: float
    law: float
    indenter: float
    layer: float
    spacing: float = math.nan
    estimate: float = math.nan

    @property
    def residual(self) -> float:
        """|deficit/law - 1|."""
        return abs(self.deficit / self.law - 1)


class Loop(NamedTuple):
    """Angles along touch -> press -> retract until just before the contact lets go."""

    shape: str
    ratio: float
    advance: tuple[Angle, ...]
    retract: tuple[Angle, ...]

    @property
    def angles(self) -> tuple[Angle, ...]:
        """The whole way."""
        return (*self.advance, *self.retract)

    @property
    def spread(self) -> float:
        """Largest minus least measured θ [rad] on the way."""
        deficits = [angle.deficit for angle in self.angles]
        return max(deficits) - min(deficits)


@dataclass(frozen=True)
class Record:
    """All measured angles; `lattice`: one level after the other, with the offsets of each."""

    parameters: Parameters
    states: tuple[Angle, ...]
    loops: tuple[Loop, ...]
    lattice: tuple[Angle, ...]

    def of(self, kind: str) -> list[Angle]:
        """The single states of a kind."""
        return [angle for angle in self.states if angle.kind == kind]

    def worst(self, kind: str) -> float:
        """Largest relative difference between measured π - θ and its law, loops included."""
        angles = self.of(kind)
        if kind == "finite":
            angles += [angle for loop in self.loops for angle in loop.angles]
        return max(angle.residual for angle in angles)

    def lattice_errors(self) -> dict[float, float]:
        """Worst relative error of π - θ for each spacing Δx/l."""
        spacings = sorted({angle.spacing for angle in self.lattice}, reverse=True)
        return {h: max(x.residual for x in self.lattice if x.spacing == h) for h in spacings}

    @property
    def order(self) -> float:
        """Order of convergence of the lattice's worst error, by least squares."""
        errors = self.lattice_errors()
        return float(np.polyfit(np.log(list(errors)), np.log(list(errors.values())), 1)[0])

    @property
    def overstepped(self) -> float:
        """Largest lattice error of π - θ over its estimate from twice the spacing."""
        return max(abs(x.deficit - x.law) / x.estimate for x in self.lattice)

    @property
    def passed(self) -> bool:
        """Whether every law is obeyed."""
        fitted = max(self.worst("finite"), self.worst("small")) <= BAR
        return fitted and ORDER[0] <= self.order <= ORDER[1] and self.overstepped <= 1


def measured(kind: str, shape: str, state: Equilibrium) -> Iterator[Angle]:
    """The angle at each contact line of a state that no corner pins."""
    scene, surfaces = state.scene, state.scene.surfaces
    law = surfaces.angle_deficit if kind == "finite" else surfaces.small_slope_deficit
    indenter, layer = (np.arctan(slope).ravel() for slope in state.line_slopes)
    ratio = scene.work_of_adhesion / scene.gamma1
    for i in np.flatnonzero(~state.pinned):
        seen = float(state.angle_deficits.flat[i]), law, float(indenter[i]), float(layer[i])
        yield Angle(kind, shape, ratio, state.depth, state.half_width, *seen, state.spacing)


def single(p: Parameters) -> Iterator[Angle]:
    """States at many w/γ₁, indenters and depths; those that would turn over are left out."""
    for shape, body in INDENTERS.items():
        for ratio in p.ratios:
            for width in p.widths:
                small = scene(body, 1.0, ratio, "small")
                depth = depth_by_16(small, (body.apex or 0.0) + width)
                yield from measured("small", shape, minimise(small, depth))
                state = simulated(scene(body, 1.0, ratio), depth)
                if state is not None:
                    yield from measured("finite", shape, state)
    for shape, body in TILTED.items():
        for ratio in p.ratios:
            yield from measured("small", shape, minimise(scene(body, 1.0, ratio, "small"), 0.5))


def loop(shape: str, ratio: float, steps: int) -> Loop:
    """Touch, press to 2δ₀, pull until just before the contact lets go; finite slopes."""
    given = scene(INDENTERS[shape], 1.0, ratio)
    end, top = letting_go(given), 2 * given.critical_separation
    depths = [*np.linspace(0, top, steps), *(top + (end - top) * np.linspace(0, 0.999, 2 * steps))]
    states = (minimise(given, float(depth)) for depth in depths)
    angles = [next(measured("finite", shape, state)) for state in states]
    return Loop(shape, ratio, tuple(angles[:steps]), tuple(angles[steps:]))


def on_lattices(p: Parameters) -> Iterator[Angle]:
    """Small-slope angles from nodes, at the worst contact line; each with an error estimate."""
    for cells in p.cells:
        for shape, body in {**INDENTERS, **TILTED}.items():
            for ratio in p.path:
                depth = depth_by_16(scene(body, 1.0, ratio), (body.apex or 0.0) + 1.0)
                for offset in p.offsets:
                    given = scene(body.shifted(offset / cells), 1.0, ratio, "small")
                    yield lattice_angle(shape, given, depth, 1 / cells)


def lattice_angle(shape: str, given: Scene, depth: float, spacing: float) -> Angle:
    """The worst angle of a state; its error is about half its change from twice the spacing."""
    fine, coarse = (
        list(measured("lattice", shape, minimise(given, depth, method="lattice", spacing=h)))
        for h in (spacing, 2 * spacing)
    )
    worst = max(range(len(fine)), key=lambda i: fine[i].residual)
    return fine[worst]._replace(estimate=abs(fine[worst].deficit - coarse[worst].deficit) / 2)


def run(p: Parameters = FULL, show: Callable[[str], object] = lambda line: None) -> Record:
    """Measure all angles; `show` gets a line as each part begins."""
    show(f"{len(p.ratios)} w/γ₁ x {len(INDENTERS)} indenters x {len(p.widths)} depths ...")
    states = tuple(single(p))
    show(f"loading paths at {len(p.path)} w/γ₁ ...")
    loops = tuple(loop(shape, r, p.steps) for shape in ("wedge", "parabola") for r in p.path)
    show(f"{len(p.cells)} lattices ...")
    return Record(p, states, loops, tuple(on_lattices(p)))


def summary(record: Record) -> str:
    """The answer, from the numbers."""
    finite, small = record.of("finite"), record.of("small")
    ratios = [angle.ratio for angle in finite]
    lines = [
        f"finite slopes: {len(finite)} contact lines, w/γ₁ = {min(ratios):g} to {max(ratios):g}: "
        f"π - θ is Young's (8) within {record.worst('finite'):.0e} of itself",
        f"small slopes:  {len(small)} contact lines: π - θ is (15) within "
        f"{record.worst('small'):.0e} of itself",
    ]
    for one in record.loops:
        widths = [angle.half_width for angle in one.angles]
        turn = np.degrees(np.ptp([angle.layer for angle in one.angles]))
        lines.append(
            f"loading path, {one.shape}, w/γ₁ = {one.ratio:g}: θ = "
            f"{180 - math.degrees(one.angles[0].deficit):.6f}°, spread {one.spread:.0e} rad, while "
            f"a goes from {min(widths):.2g} l to {max(widths):.2g} l and the surface beside the "
            f"line turns by {turn:.2g}°"
        )
    lines += [
        f"lattice, Δx = {spacing:g} l: π - θ is (15) within {error:.1e} of itself"
        for spacing, error in record.lattice_errors().items()
    ]
    lines.append(f"lattice: order {record.order:.2f}, error/estimate <= {record.overstepped:.2f}")
    lines += [
        f"simulated (15) against simulated (8) at w/γ₁ = {ratio:g}: π - θ smaller by {gap:.3%}"
        for ratio, gap in law_gap(record)
    ]
    return "\n".join(lines)


def law_gap(record: Record) -> list[tuple[float, float]]:
    """(w/γ₁, how much smaller π - θ is for small slopes), both measured."""
    small, finite = ({x.ratio: x.deficit for x in record.of(k)} for k in ("small", "finite"))
    return [(r, 1 - small[r] / finite[r]) for r in sorted(finite)]


def write_csv(record: Record, path: Path) -> None:
    """contact_angle.csv: one row per measured angle."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["part", *Angle._fields, "residual"])
        for angle in (*record.states, *record.lattice):
            table.writerow(["state", *angle, angle.residual])
        for one in record.loops:
            for i, angle in enumerate(one.angles):
                part = "advance" if i < len(one.advance) else "retract"
                table.writerow([part, *angle, angle.residual])


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if a measured angle misses its law."""
    parser = argparse.ArgumentParser(prog="python -m studies contact_angle", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--out", type=Path, default=Path("results"), help="default: results/")
    parser.add_argument("--quick", action="store_true", help="fewer states")
    options = parser.parse_args(argv)
    start, out = time.perf_counter(), options.out
    out.mkdir(parents=True, exist_ok=True)
    record = run(QUICK if options.quick else FULL, lambda text: print(text, flush=True))
    plot(record).savefig(out / "contact_angle.png", dpi=150)
    write_csv(record, out / "contact_angle.csv")
    print(summary(record))
    verdict, seconds = "pass" if record.passed else "FAIL", time.perf_counter() - start
    print(f"{verdict}; figure: {out / 'contact_angle.png'}; {seconds:.1f} s")
    return 0 if record.passed else 1
