"""Parabola: Eqs. (31)-(33).

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer. `case(shape, LEVELS)` is such a scene with its depths, LEVELS
times δ₀, and the arguments of its cards; `swept` compares an attribute of its states with a card.
`curvature` is u'' by differences, `depth_at_width` the depth at which the half-width has a value.

- A scene has `critical_separation` δ₀ = √(2w/k).
- What a function below `@check` measures stands in its `what`.
- PARABOLA is an indenter that the checks share.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

import numpy as np

from energy import Parabola, cards
from studies.verify.convergence import EXACT, Comparison, Found, check, swept
from studies.verify.mesh import Mesh
from studies.verify.observe import curvature, depth_at_width
from studies.verify.scenes import PARABOLA, Case, case

SHAPES = (PARABOLA, Parabola(R=6.1e-3))  # m: contacts of several l, and of half as much
LEVELS = np.array([-0.55, 0.0, 0.5, 1.1])  # depths over δ₀
HALF_WIDTHS = (4.3e-5, 1.1e-4, 2.3e-4)  # at depths between -0.9 and 3 δ₀


def _cases(**options: float) -> list[Case]:
    """Both parabolas; options: of `gel`."""
    return [case(shape, LEVELS, **options) for shape in SHAPES]


@check(
    31,
    what="parabola: R = -1/u'' of the surface in contact",
    order=EXACT,
    bar=1e-7,
    unit="m",
    fitted_bar=1e-8,
)
def radius(mesh: Mesh) -> Found:
    """The limits are the rounding of a difference quotient of second order."""
    x = np.array([-2.1e-5, 0.0, 1.7e-5])
    for scene, depths, given in _cases():
        radii = [-1 / curvature(mesh.solve(scene, d), x) for d in depths[1:]]
        yield Comparison(radii, given["R"])


@check(32, what="parabola: depth d(a) of a chosen half-width, by roots", unit="m")
def depth(mesh: Mesh) -> Found:
    scene, _, given = case(PARABOLA, LEVELS)
    delta0 = scene.critical_separation
    for a in HALF_WIDTHS:
        measured = depth_at_width(mesh, scene, a, -0.9 * delta0, 3 * delta0)
        yield Comparison(measured, cards.parabola.depth(a, **given), delta0)


@check(33, what="parabola: half-width a(d)", unit="m")
def half_width(mesh: Mesh) -> Found:
    return swept(mesh, _cases(), "half_width", cards.parabola.half_width)


@check(33, what="parabola: half-width a(d) for γ₁ = 0, lowest energy", order=EXACT, unit="m")
def half_width_without_tension(mesh: Mesh) -> Found:
    """Springs without tension have no length l of which nodes could be a fraction."""
    card = cards.parabola.half_width
    options = {"length": 3e-5, "branch": "global"}
    return swept(mesh, _cases(gamma1=0.0), "half_width", card, **options)
