"""Contact angle and the place of the line: Eqs. (8), (12)-(16), (18), (34), (35).

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, `mesh.sweep(scene, depths, name)` an attribute of the
equilibria at several, and `gel(indenter, ...)` the indenter on the film that all checks share, with
other values where given. `state.contacts[0]` are the left and the right end of the contact;
`slopes_at_line` are u' inside and outside of the right one, with u positive downwards: u' inside is
-f', so that the kink f' + u' is their difference. `tail` and `line_by_far_field` read l, C and u(a)
off the field beyond the line.

- A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁ and `critical_separation` δ₀ = √(2w/k).
- `angle_deficit` of a state is its own π - θ.
- `state.displacement(x)` is u, positive into the layer.
- What a function below `@check` measures stands in its `what`.
- PARABOLA and POWER_LAWS are indenters that the checks share.
- LAYER is their film, GAMMA1 its tension γ₁, WORK the work of adhesion w.
- `constants(scene)` are k, γ₁ and w by the names that cards take.
- `Found` is several comparisons, one after the other.
- FIRST is the band of first order.
- `cards` are the closed forms of the paper.
"""

from collections.abc import Iterable

import numpy as np

from discretization import Equilibrium
from energy import Indenter, Parabola, Scene, SurfaceEnergies, cards
from studies.verify import scenes
from studies.verify.convergence import DIFFERENCED, EXACT, FIRST, Comparison, Found, check
from studies.verify.mesh import Array, Mesh
from studies.verify.observe import line_by_far_field, punch_difference, slopes_at_line, tail
from studies.verify.scenes import GAMMA1, LAYER, PARABOLA, POWER_LAWS, WORK, constants, gel

LEVELS = np.array([-0.55, 0.25, 1.1])  # depths over δ₀
TENSIONS = (0.012, GAMMA1, 0.19)  # N/m: l from half to twice that of the film


def _states(mesh: Mesh, scene: Scene) -> list[Equilibrium]:
    """The states at the three depths of this module."""
    return [mesh.solve(scene, d) for d in LEVELS * scene.critical_separation]


def _lines(scene: Scene) -> tuple[Array, Array]:
    """Half-widths by Eq. (33) and displacements of the line of the shared parabola."""
    depths = LEVELS * scene.critical_separation
    a = np.array(cards.parabola.half_width(depths, R=PARABOLA.R, **constants(scene)))
    return a, depths - PARABOLA.height(a)


@check(8, what="Young's angle π-θ, w/γ₁ = 1e-6 and 4e-7", unit="rad", fitted_bar=1e-7)
def young_angle(mesh: Mesh) -> Found:
    """The small-slope energy gives (15), which is below Young's angle by w/12γ₁ < 1e-7."""
    for w in (1e-6 * GAMMA1, 4e-7 * GAMMA1):
        surfaces = SurfaceEnergies(GAMMA1, scenes.GAMMA2, GAMMA1 + scenes.GAMMA2 - w)
        scene = Scene(LAYER, surfaces, Parabola(R=0.6))
        gammas = (surfaces.gamma1, surfaces.gamma2, surfaces.gamma12)
        deficits = [state.angle_deficit for state in _states(mesh, scene)]
        yield Comparison(deficits, np.pi - cards.contact_line.angle(*gammas))


@check(
    12,
    what="kink f' + u' of the field at the line, differences",
    unit="rad",
    fitted_bar=DIFFERENCED,
)
def boundary_condition(mesh: Mesh) -> Comparison:
    scene = gel(PARABOLA)
    a, u_a = _lines(scene)
    kinks = [outer - inner for inner, outer in map(slopes_at_line, _states(mesh, scene))]
    slope = cards.tail.slope_at_line(u_a, k=scene.stiffness, gamma1=scene.gamma1)
    theta = cards.contact_line.boundary_condition(PARABOLA.slope(a), slope)
    return Comparison(kinks, np.pi - np.asarray(theta))


@check(13, what="amplitude C of the tail from the far field", unit="m")
def amplitude(mesh: Mesh) -> Comparison:
    scene = gel(PARABOLA)
    a, u_a = _lines(scene)
    measured = [tail(state).amplitude for state in _states(mesh, scene)]
    k = scene.stiffness
    gamma1 = scene.gamma1
    expected = cards.tail.amplitude(u_a, a=a, k=k, gamma1=gamma1)
    return Comparison(measured, expected)


@check(13, what="step of u at the line: the surface is continuous", order=EXACT, unit="m")
def continuity(mesh: Mesh) -> Found:
    scene = gel(PARABOLA)
    for state in _states(mesh, scene):
        a = float(state.contacts[0, 1])
        step = np.diff(state.displacement([a, np.nextafter(a, 1)]))
        yield Comparison(step, 0.0, scene.critical_separation)


@check(14, what="f'(a) + (C/l)exp(-a/l) + θ - π, C, l from the field", unit="rad")
def boundary_residual(mesh: Mesh) -> Found:
    scene = gel(PARABOLA)
    k, gamma1, w = constants(scene).values()
    alpha = cards.contact_line.angle_deficit_small(w, gamma1)
    for state in _states(mesh, scene):
        slope = PARABOLA.slope(state.half_width)
        u_a = line_by_far_field(state)
        misfit = cards.contact_line.boundary_residual(slope, u_a, np.pi - alpha, k=k, gamma1=gamma1)
        yield Comparison(misfit, 0.0, alpha)


@check(15, what="π-θ = √(2w/γ₁), three tensions, two w", unit="rad")
def small_slope_angle(mesh: Mesh) -> Found:
    for gamma1, w in zip(TENSIONS, (WORK, 0.3 * WORK, WORK), strict=True):
        states = _states(mesh, gel(PARABOLA, gamma1=gamma1, w=w))
        law = cards.contact_line.angle_deficit_small(w, gamma1)
        yield Comparison([state.angle_deficit for state in states], law)


def _line_residuals(mesh: Mesh, indenters: Iterable[Indenter]) -> Found:
    """f(a) - d - δ₀ + lf'(a) at both measured ends of the contact."""
    for indenter in indenters:
        scene = gel(indenter)
        for state in _states(mesh, scene):
            ends = state.contacts[0]
            f = indenter.height(ends)
            outward_slope = np.array([-1.0, 1.0]) * indenter.slope(ends)
            misfit = cards.contact_line.line_residual(
                state.depth, f, outward_slope, **constants(scene)
            )
            yield Comparison(misfit, 0.0, scene.critical_separation)


@check(16, what="f(a) - d - δ₀ + lf'(a), |x|ⁿ, n = 1, 1.5, 2, 3, 4", unit="m")
def place_of_the_line(mesh: Mesh) -> Found:
    return _line_residuals(mesh, (scenes.WEDGE, PARABOLA, *POWER_LAWS))


@check(16, what="the same at both ends of four lopsided profiles", unit="m")
def place_of_both_lines(mesh: Mesh) -> Found:
    return _line_residuals(mesh, scenes.uneven_profiles())


@check(16, what="outermost contact node: raw half-width", unit="m", order=FIRST, bar=2e-3)
def raw_half_width(mesh: Mesh) -> Comparison:
    scene = gel(PARABOLA)
    a, _ = _lines(scene)
    ends = [np.abs(state.nodes[0]) for state in _states(mesh, scene)]
    return Comparison(ends, a[:, None])


@check(18, what="γ₁ = 0, lowest energy: f(a) = d + δ₀", order=EXACT, unit="m")
def no_tension(mesh: Mesh) -> Found:
    for indenter in (scenes.WEDGE, PARABOLA, POWER_LAWS[1]):
        scene = gel(indenter, gamma1=0.0)
        depths = LEVELS * scene.critical_separation
        options = {"length": 3e-5, "branch": "global"}
        f = indenter.height(mesh.sweep(scene, depths, "half_width", **options))
        yield Comparison(f, cards.contact_line.cut_level(depths, k=scene.stiffness, w=WORK))


@check(
    18, what="γ₁ → 0, l = 30 µm/n, 10 links each: f(a) → d + δ₀", order=FIRST, bar=1e-2, unit="m"
)
def vanishing_tension(mesh: Mesh) -> Comparison:
    """Refinement here is the tension going to zero: the distance from (18) is lf'(a), Eq. (16)."""
    ell = 3e-5 / mesh.cells
    scene = gel(PARABOLA, gamma1=LAYER.stiffness * ell**2)
    depths = LEVELS * scene.critical_separation
    a = mesh.sweep(scene, depths, "half_width", length=ell * mesh.cells / 10)
    return Comparison(
        PARABOLA.height(a), cards.contact_line.cut_level(depths, k=scene.stiffness, w=WORK)
    )


@check(34, what="γ₁₂ - γ₂ = γ₁ for w = 0, from measured k, l and w", unit="N/m")
def neutral_surfaces(mesh: Mesh) -> Found:
    for gamma1 in TENSIONS:
        surfaces = _neutral(gamma1)
        scene = Scene(LAYER, surfaces, PARABOLA)
        wider = punch_difference(mesh, LAYER, surfaces, 4e-7)
        w = wider.force * 4e-7 / 2 - wider.energy
        ell = tail(mesh.solve(scene, 4e-7)).decay_length
        gamma12 = cards.nonadhesive.interfacial_energy(gamma1, scenes.GAMMA2)
        yield Comparison(wider.force / 4e-7 * ell**2 - w, gamma12 - scenes.GAMMA2)


@check(35, what="θ = π without adhesion, three tensions", unit="rad", fitted_bar=DIFFERENCED)
def no_kink(mesh: Mesh) -> Found:
    for gamma1, d in zip(TENSIONS, (9e-7, 5e-7, 2e-7), strict=True):
        inner, outer = slopes_at_line(mesh.solve(Scene(LAYER, _neutral(gamma1), PARABOLA), d))
        yield Comparison(np.pi - (outer - inner), cards.nonadhesive.contact_angle(), -inner)


def _neutral(gamma1: float) -> SurfaceEnergies:
    """Surface energies with w = 0."""
    gamma12 = float(cards.nonadhesive.interfacial_energy(gamma1, scenes.GAMMA2))
    return SurfaceEnergies(gamma1, scenes.GAMMA2, gamma12)
