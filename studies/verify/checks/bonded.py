"""The layer with its exact response: Eq. (16) with another length, and the limits of a sphere.

Of a limit the levels are not grids: its scene goes further towards it with every level, on the
fitted mesh, and furthest in the last column. The error is how far away the limit still is.

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, and `gel(indenter, ...)` the indenter on the film that all
checks share, with other values where given. `mesh.cells` counts links per reference length, 50 on
the coarsest lattice; `_sphere` is always solved on the fitted mesh.

- `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to this
  depth, d positive into the layer.
- A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁ and `critical_separation` δ₀ = √(2w/k).
- `surfaces.small_slope_deficit` is π - θ = √(2w/γ₁) (15); `angle_deficit` of a state is its own π -
  θ.
- What a function below `@check` measures stands in its `what`.
- PARABOLA is an indenter that the checks share.
- LAYER is their film, GAMMA1 its tension γ₁, WORK the work of adhesion w.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

import math
from collections.abc import Callable
from functools import partial

from discretization import Equilibrium, minimise
from energy import ElasticLayer, cards
from studies.verify.convergence import FIRST, Comparison, Found, check
from studies.verify.mesh import Mesh
from studies.verify.scenes import GAMMA1, LAYER, PARABOLA, WORK, gel

E = LAYER.E
H = LAYER.h
R = PARABOLA.R
SPHERE = {"R": R, "w": WORK}
THIN = "sphere, ν = ½, h ≪ a, no tension: radius"
TENSION = "sphere, tension alone: P = 2πa(γ₁a/R - √(2wγ₁))"
# Bands of orders that are no whole powers: the slope beside a node, whose error is a sawtooth; a/h
# with a little tension, both of which vanish; a limit with a logarithm.
KINK = (1.0, 1.5)
JKR = (1.2, 1.7)
LOGARITHMIC = (0.5, 0.9)
unshifted = partial(check, anchored=True)
bonded = partial(ElasticLayer, response="layer")


def _size(mesh: Mesh, lowest: float) -> float:
    """How far a limit is taken, from this on the coarsest level; 100 times as far when fitted."""
    return lowest * min(mesh.cells / 50, 100)


def _sphere(layer: ElasticLayer, gamma1: float, depth: float) -> Equilibrium:
    """The sphere in contact with this layer on the fitted mesh, whatever the level."""
    scene = gel(PARABOLA, gamma1=gamma1, layer=layer, geometry="axisymmetric")
    return minimise(scene, depth, rtol=1e-6)


def _wide(mesh: Mesh, nu: float) -> tuple[Equilibrium, Callable[[float], float]]:
    """The cylinder at the depth of a = 20h by (16), with l = 3h.

    Parameters
    ----------
    mesh : Mesh
    nu : float
        Poisson's ratio of the layer.

    Returns
    -------
    state : Equilibrium
    depth : callable
        The depth by (16) at a half-width.
    """
    layer = bonded(E, nu, H)
    scene = gel(PARABOLA, gamma1=layer.stiffness * (3 * H) ** 2, layer=layer)
    given = {"E": E, "nu": nu, "h": H, "gamma1": scene.gamma1, "w": WORK}

    def depth(a: float) -> float:
        height = a**2 / (2 * R)
        slope = a / R
        bend = 1 / R
        return float(cards.layer.depth(height, slope, bend, ell=scene.effective_length, **given))

    return mesh.solve(scene, depth(20 * H), length=160 * H), depth


@unshifted(what="a layer: depth by (16) with ℓ for l, a = 20h, l = 3h", unit="m", bar=5e-4)
def effective_length(mesh: Mesh) -> Found:
    """ν = 0.3 and -0.2; nodes are a/6 to a/50 apart."""
    for nu in (0.3, -0.2):
        state, depth = _wide(mesh, nu)
        yield Comparison(depth(state.half_width), state.depth, state.scene.critical_separation)


@unshifted(what="a layer: π-θ = √(2w/γ₁), ν = 0.3", unit="rad", order=KINK, bar=5e-3)
def angle(mesh: Mesh) -> Comparison:
    """The slope beside the outermost node, by differences, is of first order or better."""
    state, _ = _wide(mesh, 0.3)
    return Comparison(state.angle_deficit, state.scene.surfaces.small_slope_deficit)


@unshifted(what="sphere, h ≫ a, no tension: JKR", unit="m", order=JKR, bar=1e-2, fitted_bar=2e-4)
def half_space(mesh: Mesh) -> Comparison:
    """h = nb and γ₁ = Ea/n² at a = 3b/2, where b is the radius at pull-off, n = 5 to 40."""
    n = _size(mesh, 5.0)
    given = {**SPHERE, "E": E, "nu": 0.4}
    a = 1.5 * float(cards.layer.half_space_pull_off(**given).half_width)
    layer = bonded(E, 0.4, n * a / 1.5)
    depth = float(cards.layer.half_space_depth(a, **given))
    return Comparison(_sphere(layer, E * a / n**2, depth).radius, a)


@unshifted(what=THIN, unit="m", order=FIRST, bar=3e-2, fitted_bar=2e-3)
def incompressible(mesh: Mesh) -> Comparison:
    """γ₁ = Eh/1000 at a = 3b/2, where b = nh is the radius at pull-off, n = 10 to 80."""
    n = _size(mesh, 10.0)
    h = (12 * R * math.sqrt(2 * WORK / E) / n**3) ** (2 / 3)
    given = {**SPHERE, "E": E, "h": h}
    a = 1.5 * float(cards.layer.incompressible_pull_off(**given).half_width)
    depth = float(cards.layer.incompressible_depth(a, **given))
    return Comparison(_sphere(bonded(E, 0.5, h), 1e-3 * E * h, depth).radius, a)


@unshifted(what="sphere, l ≫ h: force of springs", unit="N", bar=3e-5, fitted_bar=2e-7)
def springs(mesh: Mesh) -> Comparison:
    """ν = 0.3, h = l/n, n = 5 to 40; the error is c₂/n² in size."""
    k = LAYER.stiffness
    ell = 4 * H
    h = ell / _size(mesh, 5.0)
    same_stiffness = k * h / ElasticLayer(1.0, 0.3, h).modulus
    layer = bonded(same_stiffness, 0.3, h)
    depth = 1.1 * float(cards.plane.critical_separation(k, WORK))
    force = cards.axisymmetric.sphere.force(depth, k=k, gamma1=k * ell**2, **SPHERE)
    return Comparison(_sphere(layer, k * ell**2, depth).force, force)


@unshifted(what=TENSION, unit="N", order=LOGARITHMIC, bar=4e-2, fitted_bar=1e-2)
def tension(mesh: Mesh) -> Comparison:
    """γ₁ = nEa, a that of the pull-off with πwR, n = 5 to 40, on touching."""
    a = R * math.sqrt(WORK / (2 * GAMMA1))
    soft = bonded(GAMMA1 / (a * _size(mesh, 5.0)), 0.4, a)
    state = _sphere(soft, GAMMA1, 0.0)
    expected = cards.layer.tension_force(state.radius, gamma1=GAMMA1, **SPHERE)
    return Comparison(state.force, expected, cards.layer.tension_pull_off_force(**SPHERE))
