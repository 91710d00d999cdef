"""Rotational symmetry on nodes: exact ends, one disc, and the lowest rings for the fitted mesh."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from lattices import enumerated, over, random_lattice
from scenes import ALPHA, DELTA0, L, dimple, turned

from discretization import NodalEnergy, load_path, minimise
from discretization.lattice.judge import judge, totals
from discretization.lattice.lowest import lowest_rings, runs
from discretization.nodes.lattice import Lattice
from discretization.nodes.radial import RadialLattice, outer_pull
from energy import Parabola, Patches, Sampled


def on_nodes(scene, depth, spacing, **options):
    return minimise(scene, depth, method="lattice", spacing=spacing, **options)


@pytest.mark.parametrize("kappa", [1e-18, 1e-6, 3e-3, 0.4, 2.0, 1e3, 1e9])
@pytest.mark.parametrize("node", [0, 1, 7, 1023, 1024, 5000])
def test_the_outer_surface_is_a_legendre_function(kappa, node):
    with mpmath.workdps(40):
        nu, decay = mpmath.mpf(node) - 0.5, mpmath.exp(-4 * mpmath.asinh(mpmath.sqrt(kappa) / 2))
        ratio = (nu + 1) / (nu + 1.5) * mpmath.sqrt(decay)
        ratio *= mpmath.hyp2f1(0.5, nu + 2, nu + 2.5, decay) / mpmath.hyp2f1(
            0.5, nu + 1, nu + 1.5, decay
        )
        exact = float((node + 0.5) * (1 - ratio))
    assert float(outer_pull(kappa, node)) == pytest.approx(exact, rel=2e-14, abs=0)


@pytest.mark.parametrize("moved", [-1, 1])
def test_a_line_on_another_node_is_not_certified(moved):
    scene, spacing, depth = turned(Parabola(1.9 * L / ALPHA)), L / 40, 0.2 * DELTA0
    lattice = Lattice.of(scene, spacing)
    body, last = (
        lattice.seen(scene).indenter,
        round(on_nodes(scene, depth, spacing).nodes[0, 1] / spacing),
    )
    for node, fine in ((last, True), (last + moved, False)):
        contacts = over(lattice, body, depth, (0, node))
        assert judge(contacts, totals(contacts)).ok == fine


@pytest.mark.parametrize("seed", range(120))
def test_no_rings_have_less_energy(seed):
    flat, g = random_lattice(seed, most=9)
    lattice = RadialLattice(flat.spacing, 0.0, flat.k, flat.gamma1, flat.w)
    sets, energy = enumerated(lattice, g)
    ours = np.flatnonzero((sets == lowest_rings(lattice, g)).all(axis=1))[0]
    least = NodalEnergy(lattice, sets[np.argmin(energy)])
    scale = sum(map(abs, least.terms(least.relaxed(g)).values())) or lattice.spring * np.max(g**2)
    assert energy[ours] - energy.min() <= 1e-13 * scale


def test_no_surface_passes_through_a_node_far_from_its_ends():
    """l less than Δr: what a free surface does to its end depends on the other end by rounding."""
    rng, lattice = np.random.default_rng(4), Lattice.of(turned(Parabola(0.02)), L / 0.15)
    passed = 0
    for _ in range(60):
        g = DELTA0 * rng.uniform(-2, 0.6, 40)
        held = lowest_rings(lattice, g)
        assert (NodalEnergy(lattice, held).relaxed(g) >= g - 1e-12 * DELTA0).all()
        passed += len(runs(held)) > 2
    assert passed > 10


CONVEX = Sampled(np.array([0, 0.5, 0.6, 2, 9]) * L, DELTA0 * np.array([0, 0.02, 0.1, 1.6, 12]))
SPHERE = turned(Parabola(0.02))
STRIPES = Patches.stripes(0.004, 0.25, 1.0, 0.1)
REFUSED = [  # scene, options
    (turned(dimple()), {}),
    (turned(dimple(), w=0.0), {}),
    (turned(dimple()), {"branch": "global"}),
    (turned(CONVEX), {"branch": "global"}),
    (replace(SPHERE, pattern=STRIPES), {}),
    (replace(SPHERE, slopes="finite"), {}),
    (SPHERE, {"branch": "global", "method": "shortest_path"}),
    (SPHERE, {"branch": "global", "method": "oracle"}),
]


@pytest.mark.parametrize(("scene", "options"), REFUSED)
def test_more_than_one_disc_is_refused_in_words(scene, options):
    words = "geometry = 'axisymmetric': nodes answer .* use method='fitted'"
    with pytest.raises(ValueError, match=words):
        minimise(scene, 0.1 * DELTA0, **{"method": "lattice", "spacing": L / 10, **options})
    if not options and not (scene.pattern and scene.slopes == "finite"):
        with pytest.raises(ValueError, match=words):
            load_path(scene, depths=[0.1 * DELTA0], method="lattice", spacing=L / 10)
        assert minimise(scene, 0.1 * DELTA0).contacts.size  # what is said to answer does
