"""Rings, discs around the axis and several contacts on nodes with rotational symmetry."""

import math
from dataclasses import replace

import numpy as np
import pytest
from lattices import over
from random_scenes import Dice, depth_of, scene_and_depth, within
from scenes import DELTA0, SCENE, L, adhesive

from discretization import load_path, minimise
from discretization.lattice.judge import judge, totals
from discretization.nodes.lattice import Lattice
from discretization.nodes.radial_spans import ring_spans, rings
from discretization.nodes.rules import Rules
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Patches,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
)

GAMMA1, W = SCENE.gamma1, SCENE.work_of_adhesion


def turned(body, opening=None, **options):
    return replace(adhesive(body, opening=opening), geometry="axisymmetric", **options)


def dimple(c=1.2 * L, h=DELTA0):
    """Lowest at r = c: a ring touches first."""
    return Profile(
        lambda r: h * ((np.asarray(r) / c) ** 2 - 1) ** 2,
        lambda r: h * 4 * np.asarray(r) / c**2 * ((np.asarray(r) / c) ** 2 - 1),
        extent=(0, 4 * c),
    )


def bumps(h=0.7 * DELTA0, wave=2 * L, R=0.9):
    """A sphere with rings 2 l apart."""
    q = 2 * math.pi / wave
    return Profile(
        lambda r: np.square(r) / (2 * R) + h * (1 - np.cos(q * np.asarray(r))),
        lambda r: np.asarray(r) / R + h * q * np.sin(q * np.asarray(r)),
        extent=(0, 12 * L),
    )


def on_nodes(scene, depth, spacing, **options):
    return minimise(scene, depth, method="lattice", spacing=spacing, **options)


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


@pytest.mark.parametrize("kappa", [1e-4, 0.1, 3.0])
@pytest.mark.parametrize("ends", [(0, 2), (0, 3), (1, 4), (5, 9), (3, 25), (0, 30)])
def test_a_surface_between_rings_is_that_of_its_nodes(kappa, ends):
    left, right = ends
    matrix, spans = stiffness(kappa, 40), ring_spans(kappa, 40)
    between = np.arange(left + 1, right)
    a, b, rest = spans.shape(left, right, between)
    shares = [relaxed(matrix, unit, list(ends)) for unit in np.eye(40)[list(ends)]]
    assert a == pytest.approx(shares[0][between], rel=1e-10, abs=0)
    assert b == pytest.approx(shares[1][between], rel=1e-10, abs=0)
    level = np.linalg.solve(
        matrix[np.ix_(between, between)], kappa * np.where(between > 0, between, 1 / 8)
    )
    assert rest == pytest.approx(level, rel=1e-10, abs=0)
    tie, *grounds = spans.pair(left, right)
    inner = matrix.copy()
    inner[left, left], inner[right, right] = left + 0.5, right - 0.5
    pulls = [
        inner[list(ends)] @ (u * (np.arange(40) >= left) * (np.arange(40) <= right)) for u in shares
    ]
    assert -pulls[0][1] == pytest.approx(tie, rel=1e-9, abs=0)
    assert pulls[0][0] - tie == pytest.approx(grounds[0], rel=1e-7, abs=0)
    assert pulls[1][1] - tie == pytest.approx(grounds[1], rel=1e-7, abs=0)


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
        self.work = W * self.lattice.cell * self.lattice.weight(np.arange(n - 1) + 0.5)
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
            stored = lattice.gap(*held, *(depth - row.f[held]))[0]
            stored += lattice.pull(held[0], -1) / 2 * u[0] ** 2
            stored += lattice.pull(held[1], 1) / 2 * u[1] ** 2
            stored += lattice.spring / 2 * (u**2 * lattice.weight(np.array(held))).sum()
            exact = row.energy(held, depth)[0] + row.work[held[0]]
            assert stored == pytest.approx(exact, rel=1e-10, abs=0)


@pytest.mark.slow
@pytest.mark.parametrize(("body", "depth"), [("dimple", 0.1), ("dimple", 1.2), ("bumps", 0.5)])
def test_second_order_at_the_worst_of_16_offsets(body, depth):
    scene = turned({"dimple": dimple, "bumps": bumps}[body]())
    fitted, worst = minimise(scene, depth * DELTA0), []
    for n in (20, 40, 80, 160):
        errors = []
        for offset in np.arange(16) / 16 + 0.02:
            state = on_nodes(scene, depth * DELTA0, L / (n + offset))
            off = [np.abs(state.contacts - fitted.contacts).max() / L]
            off.append(np.nanmax(np.abs(state.contact_angles - fitted.contact_angles)))
            for name in ("force", "energy"):
                error = abs(getattr(state, name) - getattr(fitted, name))
                assert error <= state.uncertainty[name]
                off.append(error / fitted.scales[name])
            errors.append(off)
        worst.append(np.max(errors, axis=0))
    orders = -np.polyfit(np.log([20, 40, 80, 160]), np.log(worst), 1)[0]
    assert orders == pytest.approx(np.full(4, 2.0), rel=0, abs=0.2)
    assert (worst[-1] <= [1e-4, 1e-3, 1.5e-3, 3e-4]).all()


def test_the_surface_between_rings_and_inside_is_that_of_the_fitted_mesh():
    scene = turned(bumps())
    fitted = minimise(scene, 1.2 * DELTA0)
    state = on_nodes(scene, 1.2 * DELTA0, L / 100)
    assert len(state.contacts) == len(fitted.contacts) == 3
    r = np.linspace(0, 6 * L, 61)
    apart = np.abs(state.displacement(r) - fitted.displacement(r)).max()
    assert apart <= 1e-3 * np.abs(fitted.displacement(r)).max()
    ring = turned(dimple())
    one, other = on_nodes(ring, 0.1 * DELTA0, L / 200), minimise(ring, 0.1 * DELTA0)
    apart = np.abs(one.displacement(r) - other.displacement(r)).max()
    assert apart <= 1e-3 * np.abs(other.displacement(r)).max()


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


LOOP = np.concatenate([np.linspace(-0.1, 2, 20), np.linspace(2, -3, 50)]) * DELTA0


def test_a_hole_closes_under_a_ring_as_on_the_fitted_mesh():
    scene = turned(dimple())
    fitted = load_path(scene, depths=LOOP)
    kinds = [event.kind for event in fitted.events]
    assert kinds == ["jump-in", "jump", "detachment"]
    for per_length, bound in ((20, 1e-2), (80, 1e-3)):
        path = load_path(scene, depths=LOOP, method="lattice", spacing=L / per_length)
        assert [event.kind for event in path.events] == kinds
        for one, other in zip(path.events, fitted.events, strict=True):
            assert one.depth == pytest.approx(other.depth, rel=0, abs=bound * DELTA0)
            assert one.energy_released == pytest.approx(other.energy_released, rel=bound, abs=0)
        assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


@pytest.mark.parametrize("spacing", [L / 20, L / 50])
@pytest.mark.parametrize(
    "scene",
    [
        turned(bumps()),
        turned(bumps(), 2 * W),
        turned(dimple(), 1.5 * W),
        turned(Parabola(0.17), pattern=Patches([0.4 * L, 0.9 * L, 1.5 * L], [1, 0.3, 1.4, 0.6])),
        turned(
            Sampled(
                np.linspace(0, 5, 11) * L,
                0.2 * DELTA0 * np.array([1, 0, 2, 0.3, 2, 0, 1, 3, 0, 1, 4.0]),
            )
            + FlatPunch(4.7 * L)
        ),
    ],
    ids=["bumps", "hysteresis", "ring with hysteresis", "pattern", "teeth"],
)
def test_a_loop_over_several_contacts_closes_its_energy_balance(scene, spacing):
    path = load_path(scene, depths=LOOP, method="lattice", spacing=spacing)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)
    assert len(path.events) >= 3
    assert all(event.energy_released >= 0 for event in path.events)
    last = np.flatnonzero(path.half_width)[-1]
    deepest = int(np.argmax(path.depth))
    state = on_nodes(scene, float(path.depth[deepest]), spacing)
    assert state.contacts[[0, -1], [0, 1]] == pytest.approx(path.contacts[deepest], rel=1e-12)
    assert state.force == pytest.approx(path.force[deepest], rel=1e-12, abs=0)
    assert path.contacts[last, 1] > 0


def test_a_pattern_on_nodes_is_that_of_the_fitted_mesh():
    patches = Patches([0.4 * L, 0.9 * L, 1.5 * L], [1, 0.3, 1.4, 0.6])
    scene = turned(Parabola(0.3), pattern=patches)
    for depth in (-0.1, 0.3, 0.8):
        fitted = minimise(scene, depth * DELTA0)
        state = on_nodes(scene, depth * DELTA0, L / 150)
        assert state.radius == pytest.approx(fitted.radius, rel=0, abs=L / 150)
        assert state.force == pytest.approx(fitted.force, rel=0, abs=0.02 * fitted.scales["force"])


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
