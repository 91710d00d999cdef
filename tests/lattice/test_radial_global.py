"""Lowest energies with rotational symmetry on nodes: against all contact sets, one by one."""

import math
from dataclasses import replace

import numpy as np
import pytest
from lattices import mask_of, over
from scenes import ALPHA, DELTA0, SCENE, L, adhesive
from scipy.special import k0e, k1e
from test_radial_contacts import Row as Nodes
from test_radial_contacts import bumps, dimple, on_nodes, relaxed, stiffness, turned

from discretization import minimise
from discretization.lattice.judge import totals
from discretization.lattice.lowest import global_minimum
from discretization.nodes.lattice import Lattice
from energy import FlatPunch, Parabola, Profile, Sampled, Wedge

W = SCENE.work_of_adhesion


def random_row(seed, n=9):
    """A lattice and random d - f on its nodes 0..n-1, over decades."""
    rng = np.random.default_rng(seed)
    scene = replace(
        adhesive(Parabola(0.02), w=W * 10 ** rng.uniform(-2, 1)), geometry="axisymmetric"
    )
    lattice = Lattice.of(scene, L / 10 ** rng.uniform(-1, 1.5))
    f = DELTA0 * rng.uniform(0, 1, n) * 10 ** rng.uniform(-1, 1)
    return lattice, DELTA0 * rng.uniform(-1, 1.2) - f


def bonds(lattice, n):
    """Work of adhesion of each link."""
    return lattice.w * lattice.cell * lattice.weight(np.arange(n - 1) + 0.5)


def enumerated(lattice, g):
    """Least energy of all contact sets whose surface stays above the indenter."""
    matrix, adhesion = stiffness(lattice.spring / lattice.link, g.size), bonds(lattice, g.size)
    least = 0.0 if (g <= 0).all() else math.inf
    for number in range(1, 2**g.size):
        held = [i for i in range(g.size) if number >> i & 1]
        u = relaxed(matrix, g, held)
        if (u >= g - 1e-12 * DELTA0).all():
            gained = sum(adhesion[i] for i in held if i + 1 in held)
            least = min(least, lattice.link / 2 * u @ matrix @ u - gained)
    return least


@pytest.mark.parametrize("seed", range(40))
def test_no_contact_set_has_less_energy(seed):
    lattice, g = random_row(seed)
    contacts, proof = global_minimum(lattice, g)
    scale = bonds(lattice, g.size).sum() + lattice.link * float(g @ g)
    assert proof.attained == pytest.approx(enumerated(lattice, g), rel=0, abs=1e-13 * scale)
    assert proof.bound == pytest.approx(proof.attained, rel=0, abs=1e-13 * scale)
    held = [i for first, last in contacts.tolist() for i in range(first, last + 1)]
    if held:
        u = relaxed(stiffness(lattice.spring / lattice.link, g.size), g, held)
        assert (u >= g - 1e-12 * DELTA0).all()


def test_no_surface_passes_through_a_node_far_from_its_ends():
    """l less than Δr: what a free surface does to its end depends on the other end by rounding."""
    rng, l_short = np.random.default_rng(4), 0.15
    scene = replace(adhesive(Parabola(0.02)), geometry="axisymmetric")
    lattice = Lattice.of(scene, L / l_short)
    passed = 0
    for _ in range(60):
        g = DELTA0 * rng.uniform(-2, 0.6, 40)
        contacts, proof = global_minimum(lattice, g)
        held = np.flatnonzero(mask_of(g.size, contacts)).tolist()
        u = relaxed(stiffness(lattice.spring / lattice.link, g.size), g, held)
        assert (u >= g - 1e-12 * DELTA0).all()
        assert proof.violation <= 1e-12
        passed += len(contacts) > 2
    assert passed > 10


def test_some_of_these_have_rings_discs_and_none():
    found = [global_minimum(*random_row(seed))[0] for seed in range(40)]
    assert any(len(contacts) > 1 for contacts in found)
    assert any(len(contacts) and contacts[0, 0] > 0 for contacts in found)
    assert any(len(contacts) and contacts[0, 0] == 0 for contacts in found)
    assert any(not len(contacts) for contacts in found)


@pytest.mark.parametrize("depth", [-0.3, 0.1, 0.5, 1.2])
@pytest.mark.parametrize("body", [dimple(), bumps()], ids=["ring", "bumps"])
def test_the_lowest_state_has_a_proof_and_no_more_energy_than_the_adhered_one(body, depth):
    scene = turned(body)
    state = on_nodes(scene, depth * DELTA0, L / 60, branch="global")
    adhered = on_nodes(scene, depth * DELTA0, L / 60)
    assert state.energy <= adhered.energy + state.uncertainty["energy"]
    assert state.proof.violation <= 1e-12
    assert state.label in ("global", "detached")
    finer = on_nodes(scene, depth * DELTA0, L / 150, branch="global")
    assert state.contacts.shape == finer.contacts.shape
    assert state.energy == pytest.approx(finer.energy, rel=0, abs=state.uncertainty["energy"])
    fitted = minimise(scene, depth * DELTA0)
    same = fitted.contacts.shape == finer.contacts.shape
    if same and np.abs(fitted.contacts - finer.contacts).max(initial=0.0) < 0.1 * L:
        assert finer.energy == pytest.approx(fitted.energy, rel=0, abs=finer.uncertainty["energy"])
    else:
        assert finer.energy < fitted.energy


@pytest.mark.parametrize("body", [Parabola(0.2), Wedge(math.atan(0.6 * ALPHA)), FlatPunch(1.3 * L)])
def test_of_a_convex_indenter_it_is_the_contact_of_the_path_or_none(body):
    scene = turned(body)
    for depth in np.array([-0.9, -0.5, -0.1, 0.0, 0.7]) * DELTA0:
        one, other = (
            minimise(scene, depth, method=method, branch="global", spacing=L / 40)
            for method in ("lattice", "shortest_path")
        )
        assert other.nodes.tolist() == one.nodes.tolist()
        assert other.proof.violation <= 1e-12


def test_a_cylinder_is_let_go_where_the_energies_are_equal():
    a = 1.3 * L
    scene = turned(FlatPunch(a))
    critical = -DELTA0 * math.sqrt(a / (a + 2 * L * k1e(a / L) / k0e(a / L)))
    for share, held in ((0.97, True), (1.03, False)):
        state = on_nodes(scene, share * critical, a / 300, branch="global")
        assert bool(state.contacts.size) == held
        assert on_nodes(scene, share * critical, a / 300).contacts.size  # the path still holds


def test_many_nodes_are_searched_too():
    coarse, fine = (
        on_nodes(turned(bumps()), 0.0, L / number, branch="global") for number in (100, 1200)
    )
    assert fine.proof.violation <= 1e-12
    assert fine.contacts == pytest.approx(coarse.contacts, rel=0, abs=coarse.spacing)


def test_rounding_of_depths_is_relative_to_the_critical_separation():
    row = Nodes(3)
    uniform = replace(
        row.rules,
        work=W * row.lattice.cell * row.lattice.weight(np.arange(row.f.size - 1) + 0.5),
    )
    assert uniform.delta0 == pytest.approx(DELTA0, rel=1e-12, abs=0)
    rest = row.lattice.shape(4, 6, np.array([5]))[2]
    assert row.rules.least_rest == pytest.approx(float(rest[0]), rel=1e-12, abs=0)


def test_a_convex_profile_that_may_have_several_stable_lines_is_searched():
    r = np.array([0, 0.5, 0.6, 2, 9]) * L
    body = Sampled(r, DELTA0 * np.array([0, 0.02, 0.1, 1.6, 12]))
    assert turned(body).indenter.convex
    for depth in (-0.2 * DELTA0, 0.1 * DELTA0):
        state = on_nodes(turned(body), depth, L / 40, branch="global")
        assert state.proof.violation <= 1e-12
        adhered, lattice = on_nodes(turned(body), depth, L / 40), Lattice.of(turned(body), L / 40)
        last = round(float(adhered.nodes[0, 1]) / lattice.spacing)
        sums = totals(over(lattice, lattice.seen(turned(body)).indenter, depth, (0, last)))
        assert state.proof.bound <= min(0.0, sums.energy + 1e-12 * sums.energy_scale)


def test_without_adhesion_the_lowest_state_is_the_only_one():
    for scene in (turned(bumps()), turned(dimple())):
        plain = replace(scene, surfaces=type(scene.surfaces).from_work(scene.gamma1, 0.0))
        for depth in (0.5 * DELTA0, 2 * DELTA0):
            path = on_nodes(plain, depth, L / 40)
            lowest = minimise(plain, depth, method="shortest_path", branch="global", spacing=L / 40)
            assert lowest.nodes.tolist() == path.nodes.tolist()
            assert path.label == "global"


@pytest.mark.parametrize("seed", range(4, 10))
def test_the_fitted_mesh_finds_the_lowest_rings_too(seed):
    rng = np.random.default_rng(seed)
    q, phase, height = rng.uniform(0.5, 3, 2) / L, rng.uniform(0, 2 * math.pi, 2), 0.5 * DELTA0
    radius = 6 * L * L / DELTA0

    def f(r):
        return r * r / (2 * radius) + height * sum(np.cos(q[i] * r + phase[i]) for i in range(2))

    def slope(r):
        return r / radius - height * sum(q[i] * np.sin(q[i] * r + phase[i]) for i in range(2))

    body = Profile(
        lambda x: f(np.abs(x)), lambda x: np.sign(x) * slope(np.abs(x)), extent=(-12 * L, 12 * L)
    )
    scene, lowest = turned(body), float(f(np.linspace(0, 12 * L, 4000)).min())
    for share in (-0.4, 0.2, 0.5):
        mesh = minimise(scene, lowest + share * DELTA0, branch="global")
        nodes = on_nodes(scene, lowest + share * DELTA0, L / 80, branch="global")
        assert mesh.contacts.shape == nodes.contacts.shape
        assert mesh.energy == pytest.approx(nodes.energy, rel=0, abs=nodes.uncertainty["energy"])
