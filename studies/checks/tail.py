"""Surface in contact and outside: Eqs. (4), (5), (6)."""

from __future__ import annotations

from typing import Any

import numpy as np

from energy import Scene, cards
from studies.checks.convergence import DIFFERENCED, EXACT, Comparison, check
from studies.checks.mesh import Array, Grid, Mesh
from studies.checks.observe import curvature, membrane
from studies.checks.scenes import (
    PARABOLA,
    POWER_LAWS,
    PUNCH,
    WEDGE,
    constants,
    gel,
    uneven_profiles,
)

LEVELS = np.array([-0.55, 0.2, 1.1])  # depths over δ₀


@check(4, what="u = d - f across the contact, eight profiles", order=EXACT, unit="m")
def contact_field(mesh: Mesh) -> Comparison:
    measured, expected = [], []
    for indenter in (PUNCH, WEDGE, PARABOLA, POWER_LAWS[0], *uneven_profiles()):
        scene = gel(indenter)
        state = mesh.solve(scene, 0.4 * scene.critical_separation)
        left, right = state.contacts[0]
        x = np.linspace(left, right, 41)[1:-1]
        measured.append(state.displacement(x))
        expected.append(state.depth - indenter.height(x))
    return Comparison(measured, expected, scene.critical_separation)


@check(
    4,
    what="u = d - f, w = 0: least energy over all u >= d - f",
    order=EXACT,
    unit="m",
    lattice_only="a quadratic programme over nodes fixed in space",
)
def contact_field_by_programme(grid: Grid) -> Comparison:
    """w = 0; the contact (39) has to come out, to within the link at either end."""
    scene, d, R = gel(PARABOLA, w=0.0), 1.3e-7, PARABOLA.R
    given = {"R": R, "k": scene.stiffness, "gamma1": scene.gamma1}
    a = float(cards.nonadhesive.parabola_half_width(d, **given))
    x, u = membrane(grid, scene, d, 1.5 * a)
    inside = np.abs(x) <= a - (x[1] - x[0])
    return Comparison(u[inside], d - PARABOLA.height(x[inside]), d)


@check(
    5,
    what="γ₁u'' of the free surface by differences, against ku",
    unit="Pa",
    fitted_bar=DIFFERENCED,
)
def surface_equation(mesh: Mesh) -> Comparison:
    measured, expected = [], []
    for indenter in (PUNCH, WEDGE, PARABOLA, POWER_LAWS[1]):
        scene = gel(indenter)
        state = mesh.solve(scene, -0.4 * scene.critical_separation)
        x = state.contacts[0, 1] + scene.elastocapillary_length * np.array([0.1, 0.7, 1.9])
        measured.append(scene.gamma1 * curvature(state, x))
        expected.append(scene.stiffness * state.displacement(x))
    return Comparison(measured, expected)


def _outside(mesh: Mesh, scene: Scene, card: Any, **shape: float) -> Comparison:
    """Free surface up to three decay lengths from the closed form's contact line."""
    ell, measured, expected = scene.elastocapillary_length, [], []
    for d in LEVELS * scene.critical_separation:
        a = card.half_width(d, **shape, **constants(scene))
        x = a + ell * np.linspace(0, 3, 7)
        measured.append(mesh.solve(scene, d).displacement(x))
        line = scene.indenter.height(np.array(a))
        u_a = d - line
        expected.append(cards.tail.displacement(x, a=a, u_a=u_a, **_spring(scene)))
    return Comparison(measured, expected, np.abs(_ends(expected))[:, None])


def _spring(scene: Scene) -> dict[str, float]:
    return {"k": scene.stiffness, "gamma1": scene.gamma1}


def _ends(fields: list[Any]) -> Array:
    return np.array([field[0] for field in fields])


@check(6, what="free surface -C exp(-x/l) beside a wedge", unit="m")
def outside_wedge(mesh: Mesh) -> Comparison:
    return _outside(mesh, gel(WEDGE), cards.wedge, delta=WEDGE.delta)


@check(6, what="free surface -C exp(-x/l) beside a parabola", unit="m")
def outside_parabola(mesh: Mesh) -> Comparison:
    return _outside(mesh, gel(PARABOLA), cards.parabola, R=PARABOLA.R)


@check(6, what="free surface -C exp(-x/l) beside |x|³", unit="m")
def outside_power_law(mesh: Mesh) -> Comparison:
    shape = POWER_LAWS[1]
    return _outside(mesh, gel(shape), cards.power_law, c=shape.c, n=shape.n)
