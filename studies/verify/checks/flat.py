"""Flat shapes: plane (19), (20) and flat punch (21)-(23).

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, `mesh.sweep(scene, depths, name)` an attribute of the
equilibria at several, and `gel(indenter, ...)` the indenter on the film that all checks share, with
other values where given. `brink` is a depth just short of detachment, `last_contact` the least
depth at which there is a contact.

- A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁ and `elastocapillary_length` l = √(γ₁/k).
- `FlatPunch(half_width)` has f = 0 up to its edges; `Plane()` is f = 0 without end.
- `state.displacement(x)` is u, positive into the layer.
- `contacts` has a row (left, right) for each contact.
- What a function below `@check` measures stands in its `what`.
- PUNCH is an indenter that the checks share.
- LAYER is their film, GAMMA1 its tension γ₁, WORK the work of adhesion w.
- `constants(scene)` are k, γ₁ and w by the names that cards take.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

import numpy as np

from energy import FlatPunch, Plane, Scene, cards
from studies.verify.convergence import EXACT, Comparison, Found, check
from studies.verify.mesh import Mesh
from studies.verify.observe import brink, last_contact
from studies.verify.scenes import GAMMA1, LAYER, PUNCH, WORK, constants, gel

TENSIONS = (0.012, GAMMA1, 0.19)  # N/m: l from half to twice that of the film
SHORT = 2e-10  # fitted error where the measure stays 1e-10 short of detachment


@check(19, what="energy per width at d = -δ₀: any width is neutral", order=EXACT, unit="J/m²")
def neutral_width(mesh: Mesh) -> Comparison:
    scenes = [gel(FlatPunch(a)) for a in (0.9e-4, 1.37e-4, 2.3e-4, 5.1e-4)]
    d_c = float(cards.plane.critical_depth(LAYER.stiffness, WORK))
    states = [mesh.solve(scene, d_c) for scene in scenes]
    energies = [state.energy if state.contacts.size else np.nan for state in states]
    widths = [2 * scene.indenter.extent[1] for scene in scenes]
    return Comparison(np.diff(energies) / np.diff(widths), 0.0, WORK)


@check(20, what="separation at which a plane detaches, by bisection", order=EXACT, unit="m")
def critical_separation(mesh: Mesh) -> Found:
    for gamma1, w in zip(TENSIONS, (WORK, 0.3 * WORK, WORK), strict=True):
        scene = gel(Plane(), gamma1=gamma1, w=w)
        delta0 = cards.plane.critical_separation(scene.stiffness, w)
        yield Comparison(-last_contact(mesh, scene), delta0)


@check(21, what="surface beside a flat punch about to detach", unit="m", fitted_bar=SHORT)
def meniscus(mesh: Mesh) -> Comparison:
    scene = gel(PUNCH)
    d_c = brink(mesh, scene)
    a = PUNCH.half_width
    x = a + scene.elastocapillary_length * np.linspace(-1, 3, 9)
    u = mesh.solve(scene, d_c).displacement(x)
    expected = cards.flat_punch.displacement(x, a=a, **constants(scene))
    return Comparison(u, expected, scene.critical_separation)


@check(
    22, what="largest pull while a flat punch is raised, three widths", unit="N/m", fitted_bar=SHORT
)
def force_at_detachment(mesh: Mesh) -> Found:
    for a in (7.3e-5, PUNCH.half_width, 4.1e-4):
        scene = gel(FlatPunch(a))
        expected = cards.flat_punch.force_at_detachment(a=a, **constants(scene))
        yield Comparison(_strongest_pull(mesh, scene), expected)


@check(23, what="largest pull while a flat punch is raised, three γ₁", unit="N/m", fitted_bar=SHORT)
def adhesion_force(mesh: Mesh) -> Found:
    for gamma1 in TENSIONS:
        scene = gel(PUNCH, gamma1=gamma1)
        expected = cards.flat_punch.adhesion_force(a=PUNCH.half_width, **constants(scene))
        yield Comparison(-_strongest_pull(mesh, scene), expected)


def _strongest_pull(mesh: Mesh, scene: Scene) -> float:
    """Least force of a punch, raised to the depth at which any detaches and a little further."""
    raised = np.array([0.0, 0.5, 1.0, 1.001]) * brink(mesh, gel(PUNCH))
    return float(mesh.sweep(scene, raised, "force").min())
