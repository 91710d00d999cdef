"""Contact without adhesion, w = 0: Eqs. (36)-(40).

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, `mesh.sweep(scene, depths, name)` an attribute of the
equilibria at several, and `gel(indenter, ...)` the indenter on the film that all checks share, with
other values where given. `case(shape, LEVELS)` is such a scene with its depths, LEVELS times δ₀,
and the arguments of its cards; `swept` compares an attribute of its states with a card.
`line_by_far_field` is u at the line as the field beyond it has it.

- A scene has `gamma1` γ₁.
- What a function below `@check` measures stands in its `what`.
- PARABOLA and POWER_LAWS are indenters that the checks share.
- GAMMA1 is the tension γ₁.
- `constants(scene)` are k, γ₁ and w by the names that cards take.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

import numpy as np

from energy import Scene, cards
from studies.verify.convergence import Comparison, Found, check, swept
from studies.verify.mesh import Mesh
from studies.verify.observe import line_by_far_field
from studies.verify.scenes import GAMMA1, PARABOLA, POWER_LAWS, Case, case, constants, gel

DEPTHS = np.array([2e-7, 5e-7, 9e-7])  # m: without adhesion δ₀ = 0 is no scale
TENSIONS = (0.012, GAMMA1, 0.19)  # N/m: l from half to twice that of the film


def _scenes() -> list[Scene]:
    """The parabola and the power laws on the film, without adhesion."""
    return [gel(indenter, w=0.0) for indenter in (PARABOLA, *POWER_LAWS)]


@check(36, what="no adhesion: f'(a) + (C/l)exp(-a/l), C, l from the field", unit="rad")
def slope_jump(mesh: Mesh) -> Found:
    for scene in _scenes():
        for d in DEPTHS:
            state = mesh.solve(scene, d)
            slope = float(scene.indenter.slope(state.half_width))
            u_a = line_by_far_field(state)
            jump = cards.nonadhesive.slope_jump(slope, u_a, **constants(scene))
            yield Comparison(jump, 0.0, slope)


@check(37, what="no adhesion: f(a) - d + lf'(a), |x|ⁿ, n = 1.5, 2, 3, 4", unit="m")
def line_condition(mesh: Mesh) -> Found:
    for scene in _scenes():
        a = mesh.sweep(scene, DEPTHS, "half_width")
        f = scene.indenter
        misfit = cards.nonadhesive.line_residual(
            DEPTHS, f.height(a), f.slope(a), **constants(scene)
        )
        yield Comparison(misfit, 0.0, DEPTHS)


@check(38, what="no adhesion: a² + 2al - 2Rd, three tensions", unit="m²")
def quadratic(mesh: Mesh) -> Found:
    for scene, depths, given in _cases():
        a = mesh.sweep(scene, depths, "half_width")
        misfit = cards.nonadhesive.parabola_residual(a, depths, **given)
        yield Comparison(misfit, 0.0, 2 * PARABOLA.R * DEPTHS)


def _cases() -> list[Case]:
    """The parabola without adhesion at the three tensions and the three depths."""
    cases = (case(PARABOLA, (), gamma1=gamma1, w=0.0) for gamma1 in TENSIONS)
    return [own._replace(depths=DEPTHS) for own in cases]


@check(39, what="no adhesion: half-width a(d), three tensions", unit="m")
def half_width(mesh: Mesh) -> Found:
    return swept(mesh, _cases(), "half_width", cards.nonadhesive.parabola_half_width)


@check(40, what="no adhesion: force P(d), three tensions", unit="N/m")
def force(mesh: Mesh) -> Found:
    return swept(mesh, _cases(), "force", cards.nonadhesive.parabola_force)
