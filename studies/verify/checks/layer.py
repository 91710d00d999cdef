"""Layer and surfaces: Eqs. (1), (2), (3), (7), (17).

Conventions: a function below `@check(equation, what=...)` is given a mesh, a lattice or the fitted
one, and returns a `Comparison(simulated, closed_form, scale)`, or yields several. Its error is the
largest |simulated - closed form| over the scale, or over the closed form where no scale is given.
On lattices it is of second order in the spacing unless `order` says otherwise; EXACT is what nodes
give but for rounding. `bar` and `fitted_bar` are the largest errors on the finest lattice and on
the fitted mesh, where the usual limits do not hold. `mesh.solve(scene, d)` is the equilibrium at
the depth d, positive into the layer, and `gel(indenter, ...)` the indenter on the film that all
checks share, with other values where given. `punch_difference` is what a wider punch adds to force
and energy, over the width that it adds; `tail` reads the decay length off the field, and
`last_contact` is the least depth at which there is a contact.

- A scene has `gamma1` γ₁, `work_of_adhesion` w and `critical_separation` δ₀ = √(2w/k).
- `Plane()` is f = 0 without end.
- What a function below `@check` measures stands in its `what`.
- PUNCH and PARABOLA are indenters that the checks share.
- LAYER is their film, GAMMA1 its tension γ₁, GAMMA2 the energy γ₂ of the indenter's surface, WORK
  the work of adhesion w.
- `Found` is several comparisons, one after the other.
- `cards` are the closed forms of the paper.
"""

from energy import ElasticLayer, Plane, Scene, SurfaceEnergies, cards
from studies.verify.convergence import EXACT, Comparison, Found, check
from studies.verify.mesh import Mesh
from studies.verify.observe import last_contact, punch_difference, tail
from studies.verify.scenes import GAMMA1, GAMMA2, LAYER, PARABOLA, PUNCH, WORK, gel

# Two more layers, and surfaces of which one has a negative energy γ₂: only the sum γ₁ + γ₂ - γ₁₂
# has to be positive.
LAYERS = (LAYER, ElasticLayer(E=1.3e3, nu=0.21, h=2.7e-5), ElasticLayer(E=87.0, nu=0.46, h=6e-6))
ENERGIES = ((GAMMA1, GAMMA2, WORK), (0.029, 0.041, 7.3e-5), (0.072, -0.013, 9e-6))  # γ₁, γ₂, w
SURFACES = tuple(SurfaceEnergies(g1, g2, g1 + g2 - w) for g1, g2, w in ENERGIES)


@check(1, what="w from the energies of two punch widths", order=EXACT, unit="J/m²")
def work_from_energy(mesh: Mesh) -> Found:
    """Per area the energy is kd²/2 - w, and its first part half the force times the depth."""
    for surfaces in SURFACES:
        d = -0.6 * Scene(LAYER, surfaces, PUNCH).critical_separation
        wider = punch_difference(mesh, LAYER, surfaces, d)
        yield Comparison(wider.force * d / 2 - wider.energy, _work(surfaces))


@check(17, what="w = kd²/2 at the depth d where a plane detaches", order=EXACT, unit="J/m²")
def work_from_separation(mesh: Mesh) -> Found:
    for surfaces in SURFACES:
        scene = Scene(LAYER, surfaces, Plane())
        d = 4e-7
        k = punch_difference(mesh, LAYER, surfaces, d).force / d
        yield Comparison(k * last_contact(mesh, scene) ** 2 / 2, _work(surfaces))


def _work(s: SurfaceEnergies) -> float:
    """w = γ₁ + γ₂ - γ₁₂ by its closed form."""
    return float(cards.contact_line.work_of_adhesion(s.gamma1, s.gamma2, s.gamma12))


@check(2, what="modulus Ẽ from the forces of two punch widths", order=EXACT, unit="Pa")
def modulus(mesh: Mesh) -> Found:
    d = 5.3e-7
    for layer in LAYERS:
        wider = punch_difference(mesh, layer, SURFACES[0], d)
        yield Comparison(layer.h * wider.force / d, cards.foundation.modulus(layer.E, layer.nu))


@check(3, what="stiffness ẼA/h of an area A, pushed and pulled", order=EXACT, unit="N/m")
def stiffness(mesh: Mesh) -> Found:
    area = 7.7e-9
    for layer, d in zip(LAYERS, (-5e-7, 2e-7, 9e-7), strict=True):
        force = punch_difference(mesh, layer, SURFACES[0], d).force
        k = cards.foundation.stiffness(layer.E, layer.nu, layer.h)
        yield Comparison(area * force / d, area * k)


@check(7, what="elastocapillary length l, logarithm of the field", unit="m")
def elastocapillary_length(mesh: Mesh) -> Found:
    scenes = [gel(PARABOLA, gamma1=gamma1) for gamma1 in (0.011, GAMMA1, 0.19)]
    scenes += [gel(PARABOLA, layer=layer) for layer in LAYERS[1:]]
    for s in scenes:
        length = tail(mesh.solve(s, 0.3 * s.critical_separation)).decay_length
        yield Comparison(length, cards.tail.elastocapillary_length(s.stiffness, s.gamma1))
