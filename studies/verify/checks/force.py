"""Force on the indenter: Eqs. (9), (10), (11).

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer. `case(shape, LEVELS)` is such a scene with its depths, LEVELS
times δ₀, and the arguments of its cards; `observe` measures on the displacement of a state, without
a closed form. Forces are positive where the indenter is pressed.

- A scene has `stiffness` k = Ẽ/h and `gamma1` γ₁.
- What a function below `@check` measures stands in its `what`.
- WEDGE, PARABOLA and POWER_LAWS are indenters that the checks share.
- GAMMA1 is the tension γ₁.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from energy import Indenter, Parabola, Scene, cards
from studies.verify import observe
from studies.verify.convergence import Comparison, Found, check
from studies.verify.mesh import Array, Mesh
from studies.verify.scenes import GAMMA1, PARABOLA, POWER_LAWS, WEDGE, case

LEVELS = np.array([-0.55, -0.1, 1.6])  # depths over δ₀
FAINT = 2.3e-9  # w for Eq. (10): slopes of 3e-4, for which sin β = tan β to 2e-8

QUADRATURE = 1e-9  # fitted error left by the 64 points of the closed form (11) for |x|^1.5


def _case(indenter: Indenter, card: Any, **options: float) -> tuple[Scene, Array, Array]:
    """A scene, depths, and the half-widths that Eq. (16) gives there."""
    scene, depths, given = case(indenter, LEVELS, **options)
    return scene, depths, card.half_width(depths, **given)


def _cases() -> list[tuple[Scene, Array, Array]]:
    """Scene, depths and half-widths by (16) of a wedge, a parabola and three power laws."""
    power_laws = [_case(p, cards.power_law) for p in POWER_LAWS]
    return [_case(WEDGE, cards.wedge), _case(PARABOLA, cards.parabola), *power_laws]


@check(9, what="∫ pressure dx over the contact, five shapes", unit="N/m")
def elastic_force(mesh: Mesh) -> Found:
    for scene, depths, widths in _cases():
        force = [observe.contact_pressure(mesh.solve(scene, d)) for d in depths]
        f = scene.indenter.height
        k = scene.stiffness
        yield Comparison(force, cards.force.elastic(depths, widths, f=f, k=k))


@check(10, what="-2γ₁u' from the field's slope, slopes of 3e-4", unit="N/m", fitted_bar=1e-7)
def surface_force_from_slope(mesh: Mesh) -> Comparison:
    scene, depths, expected = _faint()
    slopes = [observe.slopes_at_line(mesh.solve(scene, d))[1] for d in depths]
    return Comparison(-2 * GAMMA1 * np.array(slopes), expected)


@check(10, what="total force less ∫ pressure dx, slopes of 3e-4", unit="N/m", fitted_bar=1e-7)
def surface_force_from_balance(mesh: Mesh) -> Comparison:
    scene, depths, expected = _faint()
    states = [mesh.solve(scene, d) for d in depths]
    return Comparison([s.force - observe.contact_pressure(s) for s in states], expected)


def _faint() -> tuple[Scene, Array, Array]:
    """A parabola with faint adhesion, depths, and its closed form (10) with β from Eq. (6)."""
    wide = Parabola(R=2.3)
    scene, depths, a = _case(wide, cards.parabola, w=FAINT)
    k = scene.stiffness
    slope = cards.tail.slope_at_line(depths - wide.height(a), k=k, gamma1=GAMMA1)
    return scene, depths, np.array(cards.force.surface(np.arctan(slope), gamma1=GAMMA1))


def _compared(measure: Callable[[Scene, float], float], some: slice = np.s_[:]) -> Found:
    """What is measured of each scene at some of its three depths, against (11)."""
    for scene, every, ends in _cases():
        depths = every[some]
        widths = ends[some]
        f = scene.indenter.height
        k = scene.stiffness
        gamma1 = scene.gamma1
        total = cards.force.total(depths, widths, f=f, k=k, gamma1=gamma1)
        yield Comparison([measure(scene, d) for d in depths], total)


@check(11, what="total force, five shapes", unit="N/m", fitted_bar=QUADRATURE)
def total_force(mesh: Mesh) -> Found:
    return _compared(lambda scene, d: mesh.solve(scene, d).force)


@check(11, what="total force as k∫u dx over the whole line", unit="N/m")
def total_force_from_field(mesh: Mesh) -> Found:
    return _compared(lambda scene, d: observe.whole_line_force(mesh.solve(scene, d)))


@check(
    11,
    what="total force as dU/dd of the simulated energy",
    unit="N/m",
    anchored=True,
    fitted_bar=QUADRATURE,
)
def total_force_from_energy(mesh: Mesh) -> Found:
    return _compared(lambda scene, d: observe.energy_derivative(mesh, scene, d), np.s_[::2])
