"""Surface in contact and outside: Eqs. (4), (5), (6).

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, and `gel(indenter, ...)` the indenter on the film that all
checks share, with other values where given. `case(shape, LEVELS)` is such a scene with its depths,
LEVELS times δ₀, and the arguments of its cards; displacements u are positive into the layer.
`curvature` is u'' by differences of the field.

- A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁, `elastocapillary_length` l = √(γ₁/k) and
  `critical_separation` δ₀ = √(2w/k).
- `state.displacement(x)` is u, positive into the layer.
- `contacts` has a row (left, right) for each contact.
- What a function below `@check` measures stands in its `what`.
- PUNCH, WEDGE, PARABOLA and POWER_LAWS are indenters that the checks share.
- `constants(scene)` are k, γ₁ and w by the names that cards take.
- `Found` is several comparisons, one after the other.
- DIFFERENCED is the `fitted_bar` of differences of the field.
- `cards` are the closed forms of the paper.
"""

from typing import Any

import numpy as np

from energy import Indenter, cards
from studies.verify.convergence import DIFFERENCED, EXACT, Comparison, Found, check
from studies.verify.mesh import Grid, Mesh
from studies.verify.observe import curvature, membrane
from studies.verify.scenes import (
    PARABOLA,
    POWER_LAWS,
    PUNCH,
    WEDGE,
    case,
    constants,
    gel,
    uneven_profiles,
)

LEVELS = np.array([-0.55, 0.2, 1.1])  # depths over δ₀


@check(4, what="u = d - f across the contact, eight profiles", order=EXACT, unit="m")
def contact_field(mesh: Mesh) -> Found:
    for indenter in (PUNCH, WEDGE, PARABOLA, POWER_LAWS[0], *uneven_profiles()):
        scene = gel(indenter)
        state = mesh.solve(scene, 0.4 * scene.critical_separation)
        left, right = state.contacts[0]
        x = np.linspace(left, right, 41)[1:-1]
        g = state.depth - indenter.height(x)
        yield Comparison(state.displacement(x), g, scene.critical_separation)


@check(
    4,
    what="u = d - f, w = 0: least energy over all u >= d - f",
    order=EXACT,
    unit="m",
    lattice_only="a quadratic programme over nodes fixed in space",
)
def contact_field_by_programme(grid: Grid) -> Comparison:
    """w = 0; the contact (39) has to come out, to within the link at either end."""
    scene = gel(PARABOLA, w=0.0)
    d = 1.3e-7
    R = PARABOLA.R
    a = float(cards.nonadhesive.parabola_half_width(d, R=R, **constants(scene)))
    x, u = membrane(grid, scene, d, 1.5 * a)
    inside = np.abs(x) <= a - (x[1] - x[0])
    return Comparison(u[inside], d - PARABOLA.height(x[inside]), d)


@check(
    5,
    what="γ₁u'' of the free surface by differences, against ku",
    unit="Pa",
    fitted_bar=DIFFERENCED,
)
def surface_equation(mesh: Mesh) -> Found:
    for indenter in (PUNCH, WEDGE, PARABOLA, POWER_LAWS[1]):
        scene = gel(indenter)
        state = mesh.solve(scene, -0.4 * scene.critical_separation)
        x = state.contacts[0, 1] + scene.elastocapillary_length * np.array([0.1, 0.7, 1.9])
        bent = scene.gamma1 * curvature(state, x)
        yield Comparison(bent, scene.stiffness * state.displacement(x))


def _outside(mesh: Mesh, shape: Indenter, card: Any) -> Found:
    """Free surface up to three decay lengths from the closed form's contact line."""
    scene, depths, given = case(shape, LEVELS)
    spring = {"k": scene.stiffness, "gamma1": scene.gamma1}
    half_widths = np.asarray(card.half_width(depths, **given))
    at_line = depths - shape.height(half_widths)
    for d, a, u_a in zip(depths, half_widths, at_line, strict=True):
        x = a + scene.elastocapillary_length * np.linspace(0, 3, 7)
        u = cards.tail.displacement(x, a=a, u_a=u_a, **spring)
        yield Comparison(mesh.solve(scene, d).displacement(x), u, abs(u_a))


@check(6, what="free surface -C exp(-x/l) beside a wedge", unit="m")
def outside_wedge(mesh: Mesh) -> Found:
    return _outside(mesh, WEDGE, cards.wedge)


@check(6, what="free surface -C exp(-x/l) beside a parabola", unit="m")
def outside_parabola(mesh: Mesh) -> Found:
    return _outside(mesh, PARABOLA, cards.parabola)


@check(6, what="free surface -C exp(-x/l) beside |x|³", unit="m")
def outside_power_law(mesh: Mesh) -> Found:
    return _outside(mesh, POWER_LAWS[1], cards.power_law)
