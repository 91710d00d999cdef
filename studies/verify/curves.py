"""Simulated curves for the figures of `verify`, each next to its closed form."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from energy import FlatPunch, Scene, cards
from studies.verify.mesh import Array, Fitted, Grid, Mesh
from studies.verify.observe import brink
from studies.verify.scenes import GAMMA1, PARABOLA, PUNCH, WEDGE, constants, gel

GRID = Grid(100, 0.23)
ANGLE_CELLS = (4, 8, 16, 32, 64, 128, 256)
ANGLE_SHIFTS = (0.0, 0.23, 0.5, 0.81)


class Meniscus(NamedTuple):
    """Surface u(x) under and beside a flat punch about to detach, and Eq. (21)."""

    scene: Scene
    half_width: float
    depth: float
    x: Array
    u: Array
    closed_form: Array

    def scaled(self, size: float) -> Meniscus:
        """All lengths in units of `size`."""
        a, d = self.half_width / size, self.depth / size
        return Meniscus(self.scene, a, d, self.x / size, self.u / size, self.closed_form / size)


class Outside(NamedTuple):
    """Free surface beside a shape: (x - a)/l, u/δ₀ simulated and by Eq. (6), u_a/δ₀."""

    name: str
    distance: Array
    u: Array
    closed_form: Array
    at_line: float


class Angles(NamedTuple):
    """Relative error of the measured π - θ for each number of links per l, and fitted."""

    gamma1: float
    cells: Array
    errors: Array
    fitted: float


class Branch(NamedTuple):
    """a(d) and P(d) of a case study: simulated at `depths`, closed forms at `dense`."""

    name: str
    sources: tuple[str, str]
    depths: Array
    half_widths: Array
    forces: Array
    dense: Array
    half_width_card: Array
    force_card: Array


class Curves(NamedTuple):
    """Everything the figures show."""

    meniscus: Meniscus
    outside: list[Outside]
    angles: list[Angles]
    branches: list[Branch]


class Study(NamedTuple):
    """A case study: name, scene, closed forms a(d) and P(d) and where they stand in the paper.

    depths: range of d/δ₀ of the branch; shown: d/δ₀ at which the free surface is drawn.
    """

    name: str
    sources: tuple[str, str]
    scene: Scene
    depths: tuple[float, float]
    shown: float
    half_width: Callable[[Any], Any]
    force: Callable[[Any], Any]


def simulate(points: int) -> Curves:
    """All curves; `points` simulated states on each branch."""
    cases = studies()
    return Curves(
        meniscus(),
        [outside(case) for case in cases],
        [angles(gamma1) for gamma1 in (0.012, GAMMA1, 0.19)],
        [branch(case, points) for case in cases],
    )


def studies() -> tuple[Study, ...]:
    """The four shapes; depths run from just before they detach."""
    return _flat_punch(), _wedge(), _parabola(), _parabola_without_adhesion()


def _flat_punch() -> Study:
    scene, a = gel(PUNCH), PUNCH.half_width
    given = {"a": a, **constants(scene)}
    card = cards.flat_punch
    sources, shown = ("edge of the punch", "Eq. (11)"), -0.98
    width, force = lambda d: a + 0 * d, partial(card.force, **given)
    return Study("flat punch", sources, scene, (-0.999, 1.5), shown, width, force)


def _wedge() -> Study:
    scene, card = gel(WEDGE), cards.wedge
    given = {"delta": WEDGE.delta, **constants(scene)}
    end = float(card.detachment_depth(**given)) / scene.critical_separation
    sources, depths = ("Eq. (25)", "Eq. (27)"), (end + 1e-3, 1.5)
    width, force = partial(card.half_width, **given), partial(card.force, **given)
    return Study("wedge", sources, scene, depths, -0.3, width, force)


def _parabola() -> Study:
    scene, card = gel(PARABOLA), cards.parabola
    given = {"R": PARABOLA.R, **constants(scene)}
    sources, depths = ("Eq. (33)", "Eq. (11)"), (-0.999, 1.5)
    width, force = partial(card.half_width, **given), partial(card.force, **given)
    return Study("parabola", sources, scene, depths, 1.2, width, force)


def _parabola_without_adhesion() -> Study:
    scene, card = gel(PARABOLA, w=0.0), cards.nonadhesive
    given = {"R": PARABOLA.R, "k": scene.stiffness, "gamma1": scene.gamma1}
    sources, depths = ("Eq. (39)", "Eq. (40)"), (0.001, 1.5)
    width = partial(card.parabola_half_width, **given)
    force = partial(card.parabola_force, **given)
    return Study("parabola, w = 0", sources, scene, depths, 0.6, width, force)


def meniscus() -> Meniscus:
    """A punch pulled upward, drawn as in Fig. 2 of the paper."""
    punch = FlatPunch(1.2e-4)
    scene = gel(punch)
    depth, a = brink(GRID, scene), punch.half_width
    x = np.linspace(-2.4e-4, 2.4e-4, 481)
    u = GRID.solve(scene, depth).displacement(x)
    closed_form = np.array(cards.flat_punch.displacement(x, a=a, **constants(scene)))
    return Meniscus(scene, a, depth, x, u, closed_form)


def outside(case: Study) -> Outside:
    """Free surface up to five decay lengths from the closed form's contact line."""
    scene, delta0 = case.scene, gel(PUNCH).critical_separation
    ell, d = scene.elastocapillary_length, case.shown * delta0
    a = float(case.half_width(d))
    distance = np.linspace(0, 5, 41)
    x = a + ell * distance
    u_a = d - float(scene.indenter.height(a))
    u = GRID.solve(scene, d).displacement(x)
    given = {"k": scene.stiffness, "gamma1": scene.gamma1}
    closed_form = np.array(cards.tail.displacement(x, a=a, u_a=u_a, **given))
    return Outside(case.name, distance, u / delta0, closed_form / delta0, u_a / delta0)


def angles(gamma1: float, cells: Sequence[int] = ANGLE_CELLS) -> Angles:
    """Error of π - θ against Eq. (15): worst over shifts of the grid; on the fitted mesh."""
    scene = gel(PARABOLA, gamma1=gamma1)
    expected = cards.contact_line.angle_deficit_small(scene.work_of_adhesion, gamma1)

    def error(mesh: Mesh) -> float:
        return math.fabs(mesh.solve(scene, 0.0).angle_deficit / expected - 1)

    errors = [max(error(Grid(n, shift)) for shift in ANGLE_SHIFTS) for n in cells]
    return Angles(gamma1, np.array(cells), np.array(errors), error(Fitted()))


def branch(case: Study, points: int) -> Branch:
    """a(d) and P(d) between the depths of the case study."""
    lo, hi = np.array(case.depths) * gel(PUNCH).critical_separation
    depths, dense = np.linspace(lo, hi, points), np.linspace(lo, hi, 301)
    states = [GRID.solve(case.scene, d) for d in depths]
    return Branch(
        case.name,
        case.sources,
        depths,
        np.array([s.half_width for s in states]),
        np.array([s.force for s in states]),
        dense,
        np.asarray(case.half_width(dense)),
        np.asarray(case.force(dense)),
    )
