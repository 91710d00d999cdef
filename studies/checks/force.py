"""Force on the indenter: Eqs. (9), (10), (11)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from energy import Indenter, Scene, cards
from studies.checks.convergence import Comparison, check
from studies.checks.mesh import Array, Mesh
from studies.checks.observe import (
    contact_pressure,
    energy_derivative,
    slopes_at_line,
    whole_line_force,
)
from studies.checks.scenes import GAMMA1, PARABOLA, POWER_LAWS, WEDGE, constants, gel

LEVELS = np.array([-0.55, -0.1, 1.6])  # depths over δ₀
FAINT = 2.3e-9  # w for Eq. (10): slopes of 3e-4, for which sin β = tan β to 2e-8

QUADRATURE = 1e-9  # fitted error left by the 64 points of the closed form (11) for |x|^1.5


class Case(NamedTuple):
    """A scene with the depths asked about and the half-widths that Eq. (16) gives there."""

    scene: Scene
    depths: Array
    half_widths: Array


def _case(indenter: Indenter, card: Any, shape: dict[str, float], w: float | None = None) -> Case:
    scene = gel(indenter) if w is None else gel(indenter, w=w)
    depths = LEVELS * scene.critical_separation
    return Case(scene, depths, card.half_width(depths, **shape, **constants(scene)))


def _cases() -> list[Case]:
    cases = [
        _case(WEDGE, cards.wedge, {"delta": WEDGE.delta}),
        _case(PARABOLA, cards.parabola, {"R": PARABOLA.R}),
    ]
    return cases + [_case(p, cards.power_law, {"c": p.c, "n": p.n}) for p in POWER_LAWS]


def _totals(case: Case) -> Array:
    scene, k, gamma1 = case.scene, case.scene.stiffness, case.scene.gamma1
    f = scene.indenter.height
    return np.array(cards.force.total(case.depths, case.half_widths, f=f, k=k, gamma1=gamma1))


@check(9, what="∫ pressure dx over the contact, five shapes", unit="N/m")
def elastic_force(mesh: Mesh) -> Comparison:
    measured, expected = [], []
    for scene, depths, widths in _cases():
        measured.append([contact_pressure(mesh.solve(scene, d)) for d in depths])
        f, k = scene.indenter.height, scene.stiffness
        expected.append(cards.force.elastic(depths, widths, f=f, k=k))
    return Comparison(measured, expected)


@check(10, what="-2γ₁u' from the field's slope, slopes of 3e-4", unit="N/m", fitted_bar=1e-7)
def surface_force_from_slope(mesh: Mesh) -> Comparison:
    scene, depths, expected = _faint()
    slopes = [slopes_at_line(mesh.solve(scene, d))[1] for d in depths]
    return Comparison(-2 * GAMMA1 * np.array(slopes), expected)


@check(10, what="total force less ∫ pressure dx, slopes of 3e-4", unit="N/m", fitted_bar=1e-7)
def surface_force_from_balance(mesh: Mesh) -> Comparison:
    scene, depths, expected = _faint()
    states = [mesh.solve(scene, d) for d in depths]
    return Comparison([s.force - contact_pressure(s) for s in states], expected)


def _faint() -> tuple[Scene, Array, Array]:
    """A parabola with faint adhesion, depths, and its closed form (10) with β from Eq. (6)."""
    wide = PARABOLA.__class__(R=2.3)
    scene, depths, a = _case(wide, cards.parabola, {"R": wide.R}, FAINT)
    k = scene.stiffness
    slope = cards.tail.slope_at_line(depths - wide.height(a), k=k, gamma1=GAMMA1)
    return scene, depths, np.array(cards.force.surface(np.arctan(slope), gamma1=GAMMA1))


@check(11, what="total force, five shapes", unit="N/m", fitted_bar=QUADRATURE)
def total_force(mesh: Mesh) -> Comparison:
    cases = _cases()
    measured = [mesh.sweep(c.scene, c.depths, "force") for c in cases]
    return Comparison(measured, [_totals(c) for c in cases])


@check(11, what="total force as k∫u dx over the whole line", unit="N/m")
def total_force_from_field(mesh: Mesh) -> Comparison:
    cases = _cases()
    measured = [[whole_line_force(mesh.solve(c.scene, d)) for d in c.depths] for c in cases]
    return Comparison(measured, [_totals(c) for c in cases])


@check(
    11,
    what="total force as dU/dd of the simulated energy",
    unit="N/m",
    anchored=True,
    fitted_bar=QUADRATURE,
)
def total_force_from_energy(mesh: Mesh) -> Comparison:
    cases = _cases()
    measured = [[energy_derivative(mesh, c.scene, d) for d in c.depths] for c in cases]
    return Comparison(measured, [_totals(c) for c in cases])
