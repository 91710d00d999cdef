"""What the paper leaves open: energies, power laws, pull-off, a wedge held by its tip.

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, and `gel(indenter, ...)` the indenter on the film that all
checks share, with other values where given. `case(shape, LEVELS)` is such a scene with its depths,
LEVELS times δ₀, and the arguments of its cards; `swept` compares an attribute of its states with a
card. `least_force` and `even_energy` search between two depths: for the most tensile force, and for
the depth at which the energy is that of the detached surface.

- A scene has `critical_separation` δ₀ = √(2w/k).
- `FlatPunch(half_width)` has f = 0 up to its edges.
- What a function below `@check` measures stands in its `what`.
- PUNCH, WEDGE, PARABOLA and POWER_LAWS are indenters that the checks share.
- `constants(scene)` are k, γ₁ and w by the names that cards take.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

import numpy as np

from energy import FlatPunch, cards
from studies.verify import scenes
from studies.verify.convergence import Comparison, Found, check, swept
from studies.verify.mesh import Mesh
from studies.verify.observe import even_energy, least_force
from studies.verify.scenes import PARABOLA, POWER_LAWS, PUNCH, WEDGE, case, constants, gel

LEVELS = np.array([-0.45, 0.2, 1.1])  # depths over δ₀


@check(what="energy U(d) of punch, wedge, parabola, |x|ⁿ", unit="N", anchored=True)
def energies(mesh: Mesh) -> Found:
    known = (
        (PUNCH, cards.flat_punch),
        (WEDGE, cards.wedge),
        (PARABOLA, cards.parabola),
    )
    for shape, card in *known, *((p, cards.power_law) for p in POWER_LAWS):
        yield from swept(mesh, [case(shape, LEVELS)], "energy", card.energy)


@check(what="half-width a(d) of |x|ⁿ, n = 1.5, 3, 4", unit="m")
def power_law_half_width(mesh: Mesh) -> Found:
    cases = [case(shape, LEVELS) for shape in POWER_LAWS]
    return swept(mesh, cases, "half_width", cards.power_law.half_width)


@check(what="parabola: pull-off force, Λ = 0.2, 0.5, 0.8", unit="N/m")
def smooth_pull_off(mesh: Mesh) -> Found:
    for Lambda in (0.2, 0.5, 0.8):
        shape = scenes.pulled_parabola(Lambda)
        scene = gel(shape)
        least = least_force(mesh, scene, -0.95 * scene.critical_separation, 0.0)
        yield Comparison(least, cards.parabola.pull_off(R=shape.R, **constants(scene)).force)


@check(
    what="parabola: pull-off force -2√(2wγ₁), Λ = 1.3, 2.1",
    unit="N/m",
    anchored=True,
    fitted_bar=1e-8,
)
def abrupt_pull_off(mesh: Mesh) -> Found:
    """The most tensile state is a = 0, where on nodes both lines meet between the last links.

    The fitted mesh leaves it at a = 1e-9 l, the distance at which it probes the slope outside.
    """
    for Lambda in (1.3, 2.1):
        shape = scenes.pulled_parabola(Lambda)
        scene = gel(shape)
        least = mesh.path(scene, [0.0, -2 * scene.critical_separation]).pull_off.force
        yield Comparison(least, cards.parabola.pull_off(R=shape.R, **constants(scene)).force)


@check(what="sharp wedge held at its tip: P = 2kld", unit="N/m", anchored=True)
def tip_pinned_force(mesh: Mesh) -> Found:
    shape = scenes.sharp_wedge(1.7)
    scene, _, given = case(shape, LEVELS)
    depths = np.array([0.2, 0.5, 0.8]) * cards.wedge.tip_pinned_depths(**given)[1]
    return swept(mesh, [scenes.Case(scene, depths, given)], "force", cards.wedge.force)


@check(what="flat punch: depth where detached has less energy", unit="m")
def global_pull_off(mesh: Mesh) -> Found:
    for a in (3.1e-5, 4.7e-4):
        scene = gel(FlatPunch(a))
        found = even_energy(mesh, scene, -0.999 * scene.critical_separation)
        yield Comparison(found, cards.flat_punch.global_pull_off_depth(a=a, **constants(scene)))
