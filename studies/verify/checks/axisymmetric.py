"""Rotational symmetry: spheres, cones, cylinders and a cubic on the same film.

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, `mesh.sweep(scene, depths, name)` an attribute of the
equilibria at several. `case(shape, LEVELS, **ROUND)` is a body on the film that all checks share,
about an axis, with its depths, LEVELS times δ₀, and the arguments of its closed forms, `card`.
`swept` compares an attribute of its states with a card. `known` and `limit` are values of cards
that are kept for the next mesh; `least_force` and `even_energy` search between two depths.

- A scene has `stiffness` k = Ẽ/h and `critical_separation` δ₀ = √(2w/k).
- `FlatPunch(half_width)` has f = 0 up to its edges; `PowerLaw(c, n)` is f = c|x|ⁿ.
- `surfaces.small_slope_deficit` is π - θ = √(2w/γ₁) (15).
- `state.displacement(x)` is u, positive into the layer.
- What a function below `@check` measures stands in its `what`.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

import math
from typing import Any

import numpy as np

from discretization import Equilibrium
from energy import FlatPunch, Indenter, Parabola, PowerLaw, Wedge, cards
from studies.verify.convergence import DIFFERENCED, Comparison, Found, check, swept
from studies.verify.mesh import Mesh
from studies.verify.observe import even_energy, integral, least_force, slopes_at_line
from studies.verify.scenes import Case, case, known, limit, pulled_parabola

axi = cards.axisymmetric
ROUND: dict[str, Any] = {"geometry": "axisymmetric"}
# The wedge and parabola of the line contacts turned about their axes, a punch of their width, and
# bodies of another curvature and exponent [m, rad].
SPHERE = Parabola(R=2.3e-2)
CONE = Wedge(delta=4.7e-3)
CYLINDER = FlatPunch(1.13e-4)
BODIES: tuple[tuple[Indenter, Any], ...] = (
    (SPHERE, axi.sphere),
    (Parabola(R=6.1e-3), axi.sphere),
    (CONE, axi.cone),
    (PowerLaw(c=1.2e5, n=3), axi.power_law),
)
RATIOS = (0.2, 0.5, 1.0)  # Λ of spheres
LEVELS = np.array([-0.15, 0.0, 0.5, 1.1])  # depths over δ₀


def _cases() -> list[tuple[Case, Any]]:
    """Each of the BODIES on the film about an axis, and its closed forms."""
    return [(case(body, LEVELS, **ROUND), card) for body, card in BODIES]


def _all(mesh: Mesh, name: str) -> Found:
    """An attribute of the states of each body, over its largest value; its card has its name."""
    for (scene, depths, given), card in _cases():
        expected = known(getattr(card, name), depths, **given)
        yield Comparison(mesh.sweep(scene, depths, name), expected, np.abs(expected).max())


@check(what="around an axis: u(r) = u_a K₀(r/l)/K₀(a/l) outside", unit="m")
def outside(mesh: Mesh) -> Found:
    for (scene, depths, given), card in _cases():
        radius = known(card.radius, depths[2], **given)
        r = radius + np.array([0.7, 2.1]) * 3e-5  # l = 3e-5 m
        measured = mesh.solve(scene, depths[2]).displacement(r)
        yield Comparison(measured, known(card.displacement, r, d=depths[2], **given), 1e-6)


@check(what="around an axis: f' + u' = √(2w/γ₁) at the line", fitted_bar=DIFFERENCED)
def angle(mesh: Mesh) -> Found:
    for (scene, depths, _), _ in _cases():
        slopes = [slopes_at_line(mesh.solve(scene, d)) for d in depths]
        measured = [outside - inside for inside, outside in slopes]
        yield Comparison(measured, scene.surfaces.small_slope_deficit)


@check(what="around an axis: radius a(d) of sphere, cone, r³", unit="m")
def place(mesh: Mesh) -> Found:
    return _all(mesh, "radius")


@check(what="around an axis: force P(d) of sphere, cone, r³", unit="N")
def force(mesh: Mesh) -> Found:
    return _all(mesh, "force")


@check(what="around an axis: energy U(d) of sphere, cone, r³", unit="J")
def energy(mesh: Mesh) -> Found:
    return _all(mesh, "energy")


@check(what="around an axis: k∫u dA over the whole surface", unit="N")
def whole_force(mesh: Mesh) -> Comparison:
    (scene, depths, given), card = _cases()[0]
    outside = np.array([0, 1e-4, 3e-4, 1.2e-3])  # up to 40 l beside the line: exp(-40) = 4e-18

    def force(state: Equilibrium) -> float:
        pieces = [0.0, *(state.radius + outside)]
        springs = integral(lambda r: r * state.displacement(r), pieces)
        return 2 * math.pi * scene.stiffness * springs

    measured = [force(mesh.solve(scene, d)) for d in depths]
    expected = known(card.force, depths, **given)
    return Comparison(measured, expected, np.abs(expected).max())


@check(what="sphere: pull-off force, Λ = 0.2, 0.5, 1", unit="N")
def sphere_pull_off(mesh: Mesh) -> Found:
    for Lambda in RATIOS:
        scene, _, given = case(pulled_parabola(Lambda), LEVELS, **ROUND)
        least = limit(axi.sphere.detachment, **given).depth
        measured = least_force(mesh, scene, 0.9 * least, 0.1 * scene.critical_separation)
        yield Comparison(measured, limit(axi.sphere.pull_off, **given).force)


@check(what="sphere: least depth under imposed depth, Λ = 0.2, 0.5, 1", unit="m")
def sphere_detachment(mesh: Mesh) -> Found:
    """Where between nodes the last radius lies is a matter of chance, other for every shift."""
    for Lambda in RATIOS:
        scene, _, given = case(pulled_parabola(Lambda), LEVELS, **ROUND)
        delta0 = scene.critical_separation
        measured = mesh.path(scene, [0.0, -2 * delta0]).events[-1].depth
        yield Comparison(measured, limit(axi.sphere.detachment, **given).depth, delta0)


@check(what="cone: pull-off force", unit="N")
def cone_pull_off(mesh: Mesh) -> Comparison:
    scene, _, given = case(CONE, LEVELS, **ROUND)
    least = limit(axi.cone.detachment, **given).depth
    measured = least_force(mesh, scene, 0.9 * least, 1.5 * scene.critical_separation)
    return Comparison(measured, limit(axi.cone.pull_off, **given).force)


@check(what="cylinder: force P(d) with the line at its edge", unit="N")
def cylinder_force(mesh: Mesh) -> Found:
    return swept(mesh, [case(CYLINDER, LEVELS[[0, 2, 3]], **ROUND)], "force", axi.flat_punch.force)


@check(what="cylinder: depth where detached has less energy", unit="m")
def cylinder_global_pull_off(mesh: Mesh) -> Comparison:
    scene, _, given = case(CYLINDER, LEVELS, **ROUND)
    expected = float(axi.flat_punch.global_pull_off_depth(**given))
    # halfway to detachment, which coarse nodes meet a little earlier: a state still in contact
    deep = (expected + float(axi.flat_punch.detachment_depth(**given))) / 2
    measured = even_energy(mesh, scene, deep)
    return Comparison(measured, expected)


@check(what="sphere without adhesion: d(a) = (a² + 2alq)/(2R)", unit="m")
def sphere_without_adhesion(mesh: Mesh) -> Comparison:
    scene, _, given = case(SPHERE, LEVELS, w=0.0, **ROUND)
    states = [mesh.solve(scene, d) for d in np.array([0.3, 1.1]) * 1e-6]
    expected = [axi.sphere.depth_without_adhesion(state.radius, **given) for state in states]
    return Comparison([state.depth for state in states], expected)
