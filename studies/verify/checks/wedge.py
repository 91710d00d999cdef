"""Wedge: Eqs. (24)-(30).

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, and `mesh.sweep(scene, depths, name)` an attribute of the
equilibria at several. `case(shape, LEVELS)` is such a scene with its depths, LEVELS times δ₀, and
the arguments of its cards; `swept` compares an attribute of its states with a card.
`sharp_wedge(r)` has tan δ = r √(2w/γ₁); `depth_at_width` and `least_force` search between two
depths.

- A scene has `critical_separation` δ₀ = √(2w/k).
- `state.displacement(x)` is u, positive into the layer.
- What a function below `@check` measures stands in its `what`.
- WEDGE is an indenter that the checks share.
- `constants(scene)` are k, γ₁ and w by the names that cards take.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

import math

import numpy as np

from energy import Scene, cards
from studies.verify.convergence import Comparison, Found, check, swept
from studies.verify.mesh import Mesh
from studies.verify.observe import depth_at_width, least_force
from studies.verify.scenes import WEDGE, Case, case, constants, sharp_wedge

SHAPES = (WEDGE, sharp_wedge(0.4))  # blunt: tan δ < √(2w/γ₁)
LEVELS = np.array([-0.4, 0.15, 0.6, 1.1])  # depths over δ₀
HALF_WIDTHS = (4.3e-5, 1.1e-4, 2.3e-4)  # at depths between -0.8 and 3 δ₀


def _cases() -> list[Case]:
    """Both wedges."""
    return [case(shape, LEVELS) for shape in SHAPES]


@check(24, what="wedge: a tan δ - d - δ₀ + l tan δ", unit="m")
def line_condition(mesh: Mesh) -> Found:
    for shape in SHAPES:
        scene, depths, _ = case(shape, LEVELS)
        a = mesh.sweep(scene, depths, "half_width")
        slope = math.tan(shape.delta)
        misfit = cards.contact_line.line_residual(depths, a * slope, slope, **constants(scene))
        yield Comparison(misfit, 0.0, scene.critical_separation)


@check(25, what="wedge: half-width a(d)", unit="m")
def half_width(mesh: Mesh) -> Found:
    return swept(mesh, _cases(), "half_width", cards.wedge.half_width)


@check(26, what="wedge: whole surface u(x), contact and outside", unit="m")
def surface(mesh: Mesh) -> Found:
    x = np.linspace(-4e-4, 4e-4, 37)
    for scene, depths, given in _cases():
        for d in depths:
            card = cards.wedge.displacement(x, d=d, **given)
            yield Comparison(mesh.solve(scene, d).displacement(x), card, scene.critical_separation)


@check(27, what="wedge: force P(d)", unit="N/m")
def force(mesh: Mesh) -> Found:
    return swept(mesh, _cases(), "force", cards.wedge.force)


def _depth_at_width(mesh: Mesh, scene: Scene, a: float) -> float:
    """The depth at which the simulated half-width is a, one of HALF_WIDTHS."""
    delta0 = scene.critical_separation
    return depth_at_width(mesh, scene, a, -0.8 * delta0, 3 * delta0)


@check(28, what="wedge: depth d(a) of a chosen half-width, by root finding", unit="m")
def depth(mesh: Mesh) -> Found:
    scene, _, given = case(WEDGE, LEVELS)
    for a in HALF_WIDTHS:
        found = _depth_at_width(mesh, scene, a)
        yield Comparison(found, cards.wedge.depth(a, **given), scene.critical_separation)


@check(29, what="wedge: force P(a) at a chosen half-width", unit="N/m")
def force_of_width(mesh: Mesh) -> Found:
    scene, _, given = case(WEDGE, LEVELS)
    for a in HALF_WIDTHS:
        measured = mesh.solve(scene, _depth_at_width(mesh, scene, a)).force
        yield Comparison(measured, cards.wedge.force_of_width(a, **given))


@check(30, what="wedge: largest pull, tan δ = 0.15, 0.4, 0.7 √(2w/γ₁)", unit="N/m")
def adhesion_force(mesh: Mesh) -> Found:
    for shape in (*SHAPES, sharp_wedge(0.7)):
        scene, _, given = case(shape, LEVELS)
        delta0 = scene.critical_separation
        pull = -least_force(mesh, scene, -0.2 * delta0, 0.4 * delta0)
        yield Comparison(pull, cards.wedge.adhesion_force(**given))
