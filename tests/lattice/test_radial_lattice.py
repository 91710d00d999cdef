"""Rotational symmetry on nodes: exact ends, the lines' rules, rings, discs and the lowest state."""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from lattices import mask_of, over
from random_scenes import Dice, depth_of, scene_and_depth, within
from scenes import ALPHA, DELTA0, SCENE, L, adhesive, dimple, turned
from scipy.special import k0e, k1e

from discretization import load_path, minimise
from discretization.lattice.judge import judge, totals
from discretization.lattice.lowest import global_minimum
from discretization.nodes.lattice import Lattice
from discretization.nodes.radial_spans import ring_spans, rings
from discretization.nodes.rules import Rules
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
)

K, GAMMA1, W = SCENE.stiffness, SCENE.gamma1, SCENE.work_of_adhesion


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
    assert float(rings(kappa).pull(node, 1)) == pytest.approx(exact, rel=2e-14, abs=0)


@pytest.mark.parametrize("kappa", [1e-12, 1e-6, 3e-3, 0.4, 1e3])
def test_the_inner_surface_is_that_of_all_nodes_to_the_axis(kappa):
    with mpmath.workdps(30):
        spring, pull, exact = mpmath.mpf(kappa) / 8, mpmath.mpf(0), []
        for node in range(1, 3001):
            link, beyond = node - mpmath.mpf(0.5), spring + pull
            pull, spring = link * beyond / (link + beyond), mpmath.mpf(kappa) * node
            exact.append(float(pull))
    found = rings(kappa).pull(np.arange(1, 3001), -1)
    assert found == pytest.approx(np.array(exact), rel=2e-14, abs=0)


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


def test_a_cylinder_is_let_go_where_the_energies_are_equal():
    a = 1.3 * L
    scene = turned(FlatPunch(a))
    critical = -DELTA0 * math.sqrt(a / (a + 2 * L * k1e(a / L) / k0e(a / L)))
    for share, held in ((0.97, True), (1.03, False)):
        state = on_nodes(scene, share * critical, a / 300, branch="global")
        assert bool(state.contacts.size) == held
        assert on_nodes(scene, share * critical, a / 300).contacts.size  # the path still holds


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


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4, 8])
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


def stiffness(kappa, n):
    """Of nodes 0..n-1 in units of 2πγ₁, with the outer surface beyond them."""
    node = np.arange(n)
    links = node[:-1] + 0.5
    matrix = np.diag(np.where(node > 0, node, 1 / 8) * kappa)
    matrix[-1, -1] += float(rings(kappa).pull(n - 1, 1))
    for m, link in enumerate(links):
        matrix[m : m + 2, m : m + 2] += link * np.array([[1, -1], [-1, 1]])
    return matrix


def relaxed(matrix, g, held):
    """Displacements with these nodes held at g."""
    free = np.setdiff1d(np.arange(g.size), held)
    u = np.zeros(g.size)
    u[held] = g[held]
    u[free] = -np.linalg.solve(matrix[np.ix_(free, free)], matrix[np.ix_(free, held)] @ g[held])
    return u


def test_a_wide_surface_does_not_overflow():
    spans = ring_spans(50.0, 9000)
    assert spans.pair(3, 8990).tie == 0
    a, b, rest = spans.shape(3, 8990, np.array([4, 4000, 8989]))
    assert np.isfinite([a, b, rest]).all()
    assert rest[1] == 1
    assert spans.pair(3, 8990).left == pytest.approx(float(rings(50.0).pull(3, 1)), rel=1e-14)


def test_a_lone_node_far_inside_a_wide_surface_lets_go():
    """A ring held by one node, as the next contact is more nodes away than it is from the axis."""
    r = np.linspace(0, 40, 4001)
    z = np.minimum(np.minimum(abs(r - 5), 6), 0.05 * (r - 20) ** 2 + 0.3)
    z += 0.5 * np.maximum(r - 30, 0) ** 2
    surfaces = SurfaceEnergies.from_work(1.0, 0.05)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, Sampled(r, z), geometry="axisymmetric")
    depths = np.concatenate([np.linspace(0, 1.5, 20), np.linspace(1.5, -1, 40)])
    path = load_path(scene, depths=depths, method="lattice", spacing=1 / 25)
    kinds = [event.kind for event in path.events]
    assert kinds == ["touch", "nucleation", "closing", "detachment"]
    ring = path.events[2].before
    assert ring.lines[:2] == (5.0, 5.0)  # the kink at r = 5 does not adhere
    assert ring.depth == pytest.approx(0, abs=1e-5)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)
    lattice = Lattice.of(scene, 1 / 25)
    whole = lattice.shape(125, 458, np.arange(126, 458))
    part = lattice.shape(125, 458, np.array([126]))
    assert [each[0] for each in part] == [each[0] for each in whole]


class Row:
    """Random heights on nodes 0..n-1, and the energies of contact sets on them by elimination."""

    def __init__(self, seed, n=14):
        rng = np.random.default_rng(seed)
        self.lattice = Lattice.of(turned(Parabola(0.02)), L / 10 ** rng.uniform(0, 1.3))
        self.f = DELTA0 * rng.uniform(0, 1, n)
        self.work = W * self.lattice.on_links(np.full(n - 1, self.lattice.cell), np.arange(n))
        self.work *= rng.uniform(0.5, 2, n - 1)
        self.rules = Rules(self.lattice, self.f, self.work)
        self.kappa = self.lattice.spring / self.lattice.link
        self.matrix = stiffness(self.kappa, n)

    def energy(self, held, depth):
        u = relaxed(self.matrix, depth - self.f, held)
        stored = self.lattice.link / 2 * u @ self.matrix @ u
        return stored - sum(self.work[i] for i in held if i + 1 in held), stored + self.work.sum()

    def same(self, one, other, depth):
        """Whether two contact sets have the same energy, to what rounding leaves of a depth."""
        (before, size), (after, _) = self.energy(one, depth), self.energy(other, depth)
        return abs(before - after) <= 1e-9 * size


@pytest.mark.parametrize("seed", range(12))
def test_lines_pass_links_where_the_energy_stays_the_same(seed):
    row = Row(seed)
    for left, right in ((2, 5), (2, 4), (3, 9), (0, 6), (1, 12)):
        ring = sorted({max(left - 1, 0), left, right, right + 1})
        one = row.rules.passes(left, 1, right)
        assert row.same(ring, sorted({*ring, left + 1}), one)
        other = row.rules.passes(right, -1, left)
        assert row.same(ring, sorted({*ring, right - 1}), other)
        both = row.rules.passes_both(left, right)
        if math.isfinite(both):
            assert row.same(ring, sorted({*ring, left + 1, right - 1}), both)
        touch, node = row.rules.touches(left, right)
        u = relaxed(row.matrix, touch - row.f, ring)
        assert u[node] == pytest.approx(touch - row.f[node], rel=0, abs=1e-9 * DELTA0)
    for node in (2, 5, 11):
        assert row.same([node - 1, node, node + 1], [node - 1, node + 1], row.rules.torn[node])
    for node in (1, 2, 8):  # a disc inside, and the outer surface
        assert row.same(
            [node, node + 1], [node - 1, node, node + 1], row.rules.passes(node, -1, None)
        )
        assert row.same(
            [node - 1, node], [node - 1, node, node + 1], row.rules.passes(node, 1, None)
        )
        for ends in ((None, node), (node, None)):
            touch, there = row.rules.touches(*ends)
            if there < 0:
                continue
            u = relaxed(row.matrix, touch - row.f, [node])
            assert u[there] == pytest.approx(touch - row.f[there], rel=0, abs=1e-9 * DELTA0)
            depth = 0.3 * DELTA0
            held = [node, node + 1] if ends[0] is None else [node - 1, node]
            u, lattice = depth - row.f[held], row.lattice
            stored = lattice.gap_energy(*held, *row.f[held], depth)
            stored += lattice.pull(held[0], -1) / 2 * u[0] ** 2
            stored += lattice.pull(held[1], 1) / 2 * u[1] ** 2
            stored += lattice.spring / 2 * lattice.on_nodes(u**2, np.array(held)).sum()
            exact = row.energy(held, depth)[0] + row.work[held[0]]
            assert stored == pytest.approx(exact, rel=1e-10, abs=0)


@pytest.mark.parametrize("moved", [-1, 1])
def test_a_ring_with_a_line_on_another_node_is_not_certified(moved):
    scene = turned(dimple())
    lattice = Lattice.of(scene, L / 40)
    body = lattice.seen(scene).indenter
    state = on_nodes(scene, 0.5 * DELTA0, lattice.spacing)
    nodes = np.rint(state.nodes / lattice.spacing).astype(int)
    for column, step in ((0, 0), (0, moved), (1, moved)):
        ends = nodes.copy()
        ends[0, column] += step
        contacts = over(lattice, body, 0.5 * DELTA0, *map(tuple, ends.tolist()))
        assert judge(contacts, totals(contacts)).ok == (step == 0)


@pytest.mark.filterwarnings("ignore::discretization.AccuracyWarning")
def test_the_work_of_letting_go_of_a_plateau_is_found():
    dice = Dice(198)  # three lowest samples of one height, without adhesion
    scene, unit = scene_and_depth(dice)
    depth_of(dice, scene, unit)
    body, spacing = scene.indenter, scene.elastocapillary_length * dice.decade(-2, -0.3)
    r = np.concatenate([[0.0], body.x[body.x > 0]])
    half = Sampled(r, np.asarray(body.height(r)), kind=body.kind)
    scene = replace(scene, indenter=half, geometry="axisymmetric")
    depths = unit * np.concatenate([np.linspace(-0.2, 1, 6), np.linspace(1, -2.5, 10)])
    path = load_path(scene, depths=depths, method="lattice", spacing=spacing)
    with within(20):  # by rounding it once went back and forth
        assert path.work() == pytest.approx(
            path.dissipated, rel=0, abs=1e-9 * np.abs(path.energy).max()
        )
