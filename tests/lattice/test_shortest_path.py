"""The lowest contacts and rings against enumeration and at size; free surfaces about an axis."""

import math

import mpmath
import numpy as np
import pytest
from support import lattices
from support.example_scenes import DELTA0, L, adhesive, roughness, turned
from support.lattices import (
    Found,
    crowded,
    enumerated,
    of_heights,
    random_lattice,
    rough_row,
    unpruned,
)

from discretization import NodalEnergy
from discretization.lattice import lowest as lowest_module
from discretization.lattice.lowest import _cheapest, global_minimum, lowest_rings, runs
from discretization.nodes.lattice import Lattice, RadialLattice
from discretization.nodes.obstacle import pressed as held_by
from discretization.nodes.obstacle import surface
from discretization.nodes.radial import outer_pull
from energy import Parabola, Sampled


def least(lattice, g, sets, energy):
    """The least energy, that of its relaxed surface, and the sum of the sizes of its terms."""
    model = NodalEnergy(lattice, sets[np.argmin(energy)])
    u = model.relaxed(g)
    size = sum(map(abs, model.balance(u).terms.values()))
    return energy.min(), model.value(u), size or lattice.spring_stiffness * np.max(g**2)


@pytest.mark.parametrize("start", range(0, 120, 40))
def test_no_contact_set_has_less_energy(start):
    """All of them, one by one; and the certificate accepts the one that is found."""
    untied = several = 0
    for seed in range(start, start + 40):
        lattice, g = random_lattice(seed)
        sets, energy = enumerated(lattice, g)
        result = Found.of(lattice, g)
        ours = np.flatnonzero((sets == result.in_contact).all(axis=1))[0]
        lowest, relaxed, scale = least(lattice, g, sets, energy)
        assert abs(relaxed - lowest) <= 1e-11 * scale, seed
        assert abs(result.energy - lowest) <= 1e-10 * scale, seed
        assert abs(energy[ours] - lowest) <= 1e-13 * scale, seed
        assert (result.u() >= g - 1e-12 * np.abs(g).max()).all(), seed
        assert result.proof.violation <= 1e-13, seed
        if np.count_nonzero(energy <= lowest + 1e-9 * scale) == 1:
            untied += 1
            assert ours == np.argmin(energy), seed
        several += len(result.contacts) > 1
        assert_certified(lattice, g, result.contacts, seed)
    assert untied >= 25 and several >= 3


def assert_certified(lattice, g, ends, seed):
    if len(ends):
        contacts = of_heights(lattice, g, ends)
        assert contacts.certificate.ok, seed


@pytest.mark.parametrize(
    ("draw", "seeds"),
    [
        (rough_row, range(8)),
        (lattices.plateaus, range(20)),
        (crowded, [1772, 3277, 3576, 4495, 5523, *range(20)]),
    ],
)
def test_no_admissible_spans_have_less_energy(draw, seeds):
    """All pairs of nodes, in an order in which nothing is left out."""
    for seed in seeds:
        lattice, g = draw(seed)
        result = Found.of(lattice, g)
        scale = result.proof.scale or lattice.w or 1.0
        assert abs(result.energy - unpruned(lattice, g)) <= 1e-12 * scale, seed
        assert (result.u() >= g - 1e-13 * np.abs(g).max()).all(), seed
        assert result.proof.violation <= 1e-13, seed
        assert_certified(lattice, g, result.contacts, seed)


@pytest.mark.parametrize(("more", "contacts"), [(2e-13, [[0, 1]]), (2e-12, [])])
def test_of_equal_energies_the_one_with_more_contact(more, contacts):
    """Two nodes with an energy of 2 more wΔx; 1e-12 wΔx are a tie."""
    lattice = Lattice(1.0, 0.0, 1.3, 1.3 * 4.0, 0.2)
    leaves = -math.sqrt(lattice.w / (lattice.spring_stiffness + lattice.end_stiffness))
    assert Found.of(lattice, np.full(2, leaves * (1 + more))).contacts.tolist() == contacts


def wavy(depth, n=801):
    """A lattice of spacing 1 in a scene with several contacts, and the scene."""
    x = np.arange(n) - n // 2 + 0.0
    f = 1e-4 * x**2 + 1.4 * (1 - np.cos(x / 10)) + 3e-3 * x
    scene = adhesive(Sampled(x, f - f.min()), k=1.3, gamma1=1.3 * 25.0, w=0.4)
    return Lattice.of(scene, 1.0, origin=0.0), scene


@pytest.mark.parametrize(("depth", "least"), [(-0.3, 1), (0.3, 3), (2.0, 4)])
def test_nodes_out_of_reach_and_mirror_images(depth, least):
    """Nodes out of reach change nothing and mirror images agree."""
    lattice, scene = wavy(depth)
    whole = Found.of(lattice, depth - scene.indenter.z)
    near = np.flatnonzero(whole.g >= -lattice.deepest_contact)
    start = near[0]
    g = whole.g[near[0] : near[-1] + 1]
    result = Found.of(lattice, g)
    scale = result.proof.scale
    assert g.size < 600
    assert len(result.contacts) >= least
    assert whole.contacts.tolist() == (result.contacts + start).tolist()
    assert abs(whole.energy - result.energy) <= 1e-13 * scale
    mirrored = Found.of(lattice, g[::-1])
    assert mirrored.contacts.tolist() == (g.size - 1 - result.contacts[::-1, ::-1]).tolist()
    assert abs(mirrored.energy - result.energy) <= 1e-13 * scale


@pytest.mark.parametrize("ell", [1e-3, 0.1, 1.0, 1e2, 1e4, 1e7])
def test_rough_profiles_are_certified(ell):
    f = roughness(6000, 600, 10)
    for depth, delta in ((0.4, 0.3), (-0.01, 0.5), (0.2, 1.0)):
        lattice = Lattice(1.0, 0.0, 1.0, ell**2, delta**2 / 2)
        result = Found.of(lattice, depth * f.max() - f)
        assert result.proof.violation <= 1e-13 * max(1, ell / 1e2)
        assert (result.u() - result.g).min() >= -1e-13 * f.max()
        assert result.energy <= 1e-15 * result.proof.scale or depth > 0
        assert_certified(lattice, result.g, result.contacts, ell)


def compared(n, depth, delta):
    """How many surfaces are compared for a profile of n nodes, over 100 decay lengths, per node."""
    f = roughness(n, n / 5, n / 200)
    lattice = Lattice(1.0, 0.0, 1.0, (n / 100) ** 2, delta**2 / 2)
    g = depth * f.max() - f
    held, _ = held_by(lattice, g)
    h = np.maximum(surface(lattice, held, g[held], np.arange(n)) - g, 0.0)
    h[held] = 0.0
    return _cheapest(lattice, h, h <= lattice.deepest_contact)[2] / n


@pytest.mark.parametrize(("depth", "delta"), [(0.4, 0.3), (0.1, 1.0)])
def test_closer_nodes_compare_hardly_more_surfaces_each(depth, delta):
    few, many = (compared(n, depth, delta) for n in (4_000, 64_000))
    assert many < 5 * few  # all that may be needed: 14 times as many for 16 times the nodes
    assert many < 20


def stripes(seed):
    """Many nodes per decay length under a profile of some waves."""
    rng = np.random.default_rng(seed)
    n = 120
    ell = n / rng.uniform(1, 8)
    x = np.arange(n)
    f = roughness(n, n / 2, n / rng.uniform(3, 20), seed) + rng.uniform(0, 2) * (x / n - 0.5) ** 2
    g = rng.uniform(0.2, 0.9) * f.max() - f
    return Lattice(1.0, 0.0, 1.0, ell**2, rng.uniform(0.1, 2) ** 2 / 2), g


@pytest.mark.parametrize("few", [1, 7, 64])
def test_blocks_of_any_size_leave_nothing_out(monkeypatch, few):
    search = lowest_module._SEARCH._replace(block=few)
    monkeypatch.setattr(lowest_module, "_SEARCH", search)
    several = 0
    for seed in range(8):
        lattice, g = stripes(seed)
        result = Found.of(lattice, g)
        scale = result.proof.scale or lattice.w
        assert abs(result.proof.bound - unpruned(lattice, g)) <= 1e-12 * scale, seed
        assert result.proof.violation <= 1e-13, seed
        several += len(result.contacts) > 1
    assert several >= 1


@pytest.mark.slow
def test_one_hundred_thousand_nodes():
    f = roughness(10**5, 2000, 20)
    result = Found.of(Lattice(1.0, 0.0, 1.0, 1e4, 0.045), 0.4 * f.max() - f)
    assert len(result.contacts) > 100
    assert result.proof.violation <= 1e-13


def test_what_it_cannot_answer_is_refused():
    for g in (np.zeros(0), np.array([0.0, math.nan]), np.zeros((2, 2))):
        with pytest.raises(ValueError, match="g of shape"):
            global_minimum(Lattice(1.0, 0.0, 1.0, 1.0, 0.1), g)


@pytest.mark.parametrize("kappa", [1e-18, 1e-6, 3e-3, 0.4, 2.0, 1e3, 1e9])
@pytest.mark.parametrize("node", [0, 1, 7, 1023, 1024, 5000])
def test_the_outer_surface_is_a_legendre_function(kappa, node):
    with mpmath.workdps(40):
        nu = mpmath.mpf(node) - 0.5
        decay = mpmath.exp(-4 * mpmath.asinh(mpmath.sqrt(kappa) / 2))
        ratio = (nu + 1) / (nu + 1.5) * mpmath.sqrt(decay)
        ratio *= mpmath.hyp2f1(0.5, nu + 2, nu + 2.5, decay) / mpmath.hyp2f1(
            0.5, nu + 1, nu + 1.5, decay
        )
        exact = float((node + 0.5) * (1 - ratio))
    assert float(outer_pull(kappa, node)) == pytest.approx(exact, rel=2e-14, abs=0)


def test_no_surface_passes_through_a_node_far_from_its_ends():
    """l less than Δr: what a free surface does to its end depends on the other end by rounding."""
    rng = np.random.default_rng(4)
    lattice = Lattice.of(turned(Parabola(0.02)), L / 0.15)
    passed = 0
    for _ in range(60):
        g = DELTA0 * rng.uniform(-2, 0.6, 40)
        held = lowest_rings(lattice, g)
        assert (NodalEnergy(lattice, held).relaxed(g) >= g - 1e-12 * DELTA0).all()
        passed += len(runs(held)) > 2
    assert passed > 10


@pytest.mark.parametrize("seed", range(0, 120, 40))
def test_no_rings_have_less_energy(seed):
    for one in range(seed, seed + 40):
        flat, g = random_lattice(one, most=9)
        lattice = RadialLattice(flat.spacing, 0.0, flat.k, flat.gamma1, flat.w)
        sets, energy = enumerated(lattice, g)
        ours = np.flatnonzero((sets == lowest_rings(lattice, g)).all(axis=1))[0]
        *_, scale = least(lattice, g, sets, energy)
        assert energy[ours] - energy.min() <= 1e-13 * scale, one
