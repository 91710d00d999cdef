"""The layer with its exact response: Eq. (16) with another length, and the limits of a sphere.

Of a limit the levels are not grids: its scene goes further towards it with every level, on the
fitted mesh, and furthest in the last column. The error is how far away the limit still is.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from discretization import minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards
from studies.verify.convergence import FIRST, Comparison, Found, check
from studies.verify.mesh import Mesh
from studies.verify.scenes import GAMMA1, LAYER, PARABOLA, WORK

E, H, R = LAYER.E, LAYER.h, PARABOLA.R
SPHERE = {"R": R, "w": WORK}
FAR = 5e3  # links per length that stand for the fitted mesh
KINK, JKR, LOGARITHMIC = (1.0, 1.5), (1.2, 1.7), (0.5, 0.9)  # orders that are no whole powers


def _scene(nu: float, h: float, gamma1: float, geometry: str = "axisymmetric", E: float = E) -> Any:
    layer = ElasticLayer(E, nu, h, response="layer")
    return Scene(layer, SurfaceEnergies.from_work(gamma1, WORK), Parabola(R), geometry=geometry)


def _size(mesh: Mesh, lowest: float) -> float:
    """How far a limit is taken, from this on the coarsest level."""
    return lowest * min(mesh.cells, FAR) / 50


def _solved(scene: Scene, depth: float, name: str) -> float:
    return float(getattr(minimise(scene, depth, rtol=1e-6), name))


def _wide(nu: float) -> tuple[Scene, Callable[[float], float], float]:
    """The parabola on a layer with l = 3h; its depth at a half-width by (16), and at 20h."""
    gamma1 = ElasticLayer(E, nu, H).stiffness * (3 * H) ** 2
    scene = _scene(nu, H, gamma1, "line")
    given = {"E": E, "nu": nu, "h": H, "gamma1": gamma1, "w": WORK, "ell": scene.effective_length}

    def depth(a: float) -> float:
        return float(cards.layer.depth(a**2 / (2 * R), a / R, 1 / R, **given))

    return scene, depth, depth(20 * H)


@check(
    what="a layer: depth by (16) with ℓ for l, a = 20h, l = 3h", unit="m", bar=5e-4, anchored=True
)
def effective_length(mesh: Mesh) -> Found:
    """ν = 0.3 and -0.2; nodes are a/6 to a/50 apart."""
    for nu in (0.3, -0.2):
        scene, depth, d = _wide(nu)
        a = mesh.solve(scene, d, length=160 * H).half_width
        yield Comparison(depth(a), d, scene.critical_separation)


@check(what="a layer: π-θ = √(2w/γ₁), ν = 0.3", unit="rad", order=KINK, bar=5e-3, anchored=True)
def angle(mesh: Mesh) -> Comparison:
    """The slope beside the outermost node, by differences, is of first order or better."""
    scene, _, d = _wide(0.3)
    state = mesh.solve(scene, d, length=160 * H)
    return Comparison(state.angle_deficit, scene.surfaces.small_slope_deficit)


@check(what="sphere, h ≫ a, no tension: JKR", unit="m", order=JKR, bar=1e-2, fitted_bar=2e-4)
def half_space(mesh: Mesh) -> Comparison:
    """h = na and γ₁ = E*a/n², a at pull-off, n = 5 to 40; at 3/2 of that radius."""
    n, given = _size(mesh, 5.0), {**SPHERE, "E": E, "nu": 0.4}
    a = 1.5 * float(cards.layer.half_space_pull_off(**given).half_width)
    scene = _scene(0.4, n * a / 1.5, E * a / n**2)
    d = float(cards.layer.half_space_depth(a, **given))
    return Comparison(_solved(scene, d, "radius"), a)


@check(
    what="sphere, ν = ½, h ≪ a, no tension: radius",
    unit="m",
    order=FIRST,
    bar=3e-2,
    anchored=True,
    fitted_bar=2e-3,
)
def incompressible(mesh: Mesh) -> Comparison:
    """a = nh and γ₁ = Eh/1000, a at pull-off, n = 10 to 80; at 3/2 of that radius."""
    h = (12 * R * math.sqrt(2 * WORK / E) / _size(mesh, 10.0) ** 3) ** (2 / 3)
    given = {**SPHERE, "E": E, "h": h}
    a = 1.5 * float(cards.layer.incompressible_pull_off(**given).half_width)
    d = float(cards.layer.incompressible_depth(a, **given))
    return Comparison(_solved(_scene(0.5, h, 1e-3 * E * h), d, "radius"), a)


@check(what="sphere, l ≫ h: force of springs", unit="N", bar=3e-5, anchored=True, fitted_bar=2e-7)
def springs(mesh: Mesh) -> Comparison:
    """ν = 0.3, h = l/n, n = 5 to 40; the error is c₂/n² in size."""
    k, ell = LAYER.stiffness, 4 * H
    h = ell / _size(mesh, 5.0)
    scene = _scene(0.3, h, k * ell**2, E=k * h / ElasticLayer(1.0, 0.3, h).modulus)
    depths = np.array([0.2, 1.1]) * scene.critical_separation
    forces = cards.axisymmetric.sphere.force(depths, k=k, gamma1=k * ell**2, **SPHERE)
    return Comparison([_solved(scene, d, "force") for d in depths], forces, np.abs(forces).max())


@check(
    what="sphere, tension alone: P = 2πa(γ₁a/R - √(2wγ₁))",
    unit="N",
    order=LOGARITHMIC,
    bar=4e-2,
    anchored=True,
    fitted_bar=1e-2,
)
def tension(mesh: Mesh) -> Comparison:
    """γ₁ = nEa, a that of the pull-off with πwR, n = 5 to 40, on touching."""
    a = R * math.sqrt(WORK / (2 * GAMMA1))
    scene = _scene(0.4, a, GAMMA1, E=GAMMA1 / (a * _size(mesh, 5.0)))
    radius, force = (_solved(scene, 0.0, name) for name in ("radius", "force"))
    expected = cards.layer.tension_force(radius, gamma1=GAMMA1, **SPHERE)
    return Comparison(force, expected, cards.layer.tension_pull_off_force(**SPHERE))
