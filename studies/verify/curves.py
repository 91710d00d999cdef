"""Simulated curves for the figures of `verify`, each next to its closed form."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from energy import FlatPunch, Indenter, Scene, cards
from studies.verify.mesh import Array, Grid
from studies.verify.observe import brink
from studies.verify.scenes import PARABOLA, PUNCH, WEDGE, case, constants, gel

GRID = Grid(100, 0.23)


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
    branches: list[Branch]


class Study(NamedTuple):
    """A case study: name, scene, closed forms a(d) and P(d) and where they stand in the paper.

    depths: range of d/δ₀ of the branch.
    """

    name: str
    sources: tuple[str, str]
    scene: Scene
    depths: tuple[float, float]
    half_width: Callable[[Any], Any]
    force: Callable[[Any], Any]


def simulate(points: int) -> Curves:
    """All curves; `points` simulated states on each branch."""
    shapes = studies()
    branches = [branch(shape, points) for shape in shapes if points]
    return Curves(meniscus(), branches)


def studies() -> tuple[Study, ...]:
    """The four shapes; depths run from just before they detach."""
    flat, wedge, parabola, dry = cards.flat_punch, cards.wedge, cards.parabola, cards.nonadhesive
    scene, _, given = case(WEDGE, ())
    end = float(wedge.detachment_depth(**given)) / scene.critical_separation + 1e-3
    laws = (
        (lambda d, a, **_: a + 0 * d, flat.force),
        (wedge.half_width, wedge.force),
        (parabola.half_width, parabola.force),
        (dry.parabola_half_width, dry.parabola_force),
    )
    return (
        _study("flat punch", ("edge of the punch", "Eq. (11)"), PUNCH, -0.999, laws[0]),
        _study("wedge", ("Eq. (25)", "Eq. (27)"), WEDGE, end, laws[1]),
        _study("parabola", ("Eq. (33)", "Eq. (11)"), PARABOLA, -0.999, laws[2]),
        _study("parabola, w = 0", ("Eq. (39)", "Eq. (40)"), PARABOLA, 0.001, laws[3], w=0.0),
    )


def _study(
    name: str,
    sources: tuple[str, str],
    indenter: Indenter,
    least: float,
    laws: Any,
    **options: float,
) -> Study:
    scene, _, given = case(indenter, (), **options)
    width, force = (partial(law, **given) for law in laws)
    return Study(name, sources, scene, (least, 1.5), width, force)


def meniscus() -> Meniscus:
    """A punch pulled upward, drawn as in Fig. 2 of the paper."""
    punch = FlatPunch(1.2e-4)
    scene = gel(punch)
    depth, a = brink(GRID, scene), punch.half_width
    x = np.linspace(-2.4e-4, 2.4e-4, 481)
    u = GRID.solve(scene, depth).displacement(x)
    closed_form = np.array(cards.flat_punch.displacement(x, a=a, **constants(scene)))
    return Meniscus(scene, a, depth, x, u, closed_form)


def branch(study: Study, points: int) -> Branch:
    """a(d) and P(d) between the depths of the case study."""
    lo, hi = np.array(study.depths) * gel(PUNCH).critical_separation
    depths, dense = np.linspace(lo, hi, points), np.linspace(lo, hi, 301)
    states = [GRID.solve(study.scene, d) for d in depths]
    half_widths = np.array([state.half_width for state in states])
    forces = np.array([state.force for state in states])
    known = np.asarray(study.half_width(dense)), np.asarray(study.force(dense))
    return Branch(study.name, study.sources, depths, half_widths, forces, dense, *known)
