"""Several contacts with finite slopes on nodes: against a slow walk and other limits."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from lattices import of_heights
from scenes import adhesive, steep
from scipy.linalg import solveh_banded

from discretization import load_path, minimise
from discretization.lattice.finite_rules import FiniteRules
from discretization.lattice.judge import judge
from discretization.lattice.nodal_energy import NodalEnergy
from discretization.lattice.nodes import Lattice
from discretization.lattice.totals import totals
from energy import Parabola, Patches, Profile, SurfaceEnergies

L = steep(Parabola(0.02)).elastocapillary_length
BEYOND = 18  # l of plain nodes on each side, for the walk


def rough(ratio=0.3, height=0.8, waves=3.0, phase=0.4, reach=8.0):
    """Crests on a parabola, heights in δ₀, waves per l: the same in δ₀ and l for every w/γ₁."""
    delta = steep(Parabola(0.02), ratio).critical_separation
    radius, high, q = 4 * L**2 / delta, height * delta, waves / L

    def f(x):
        return x**2 / (2 * radius) + high * (1 - np.cos(q * x + phase))

    def slope(x):
        return x / radius + high * q * np.sin(q * x + phase)

    return steep(Profile(f, slope, extent=(-reach * L, reach * L)), ratio)


class Walk:
    """Contact nodes moved one by one where that lowers the energy, every surface relaxed anew."""

    def __init__(self, scene, spacing):
        self.k, self.gamma1, self.w = scene.stiffness, scene.gamma1, scene.work_of_adhesion
        lo, hi = scene.indenter.extent
        known = np.arange(math.ceil(lo / spacing), math.floor(hi / spacing) + 1) * spacing
        pad = round(BEYOND * L / spacing)
        self.f = np.pad(scene.indenter.height(known), pad, constant_values=math.inf)
        self.x = spacing * (np.arange(self.f.size) - pad) + known[0]
        self.dx, self.held = spacing, np.zeros(self.f.size, bool)

    def relaxed(self, held, depth):
        """u and the energy with these nodes in contact."""
        u = np.where(held, depth - self.f, 0.0)
        for _ in range(60):
            slopes = np.diff(u) / self.dx
            root = np.sqrt(1 + slopes**2)
            tension, stiff = self.gamma1 * slopes / root, self.gamma1 / self.dx / root**3
            force = self.k * self.dx * u
            force[:-1] -= tension
            force[1:] += tension
            diagonal = np.full(u.size, self.k * self.dx)
            diagonal[:-1] += stiff
            diagonal[1:] += stiff
            band = np.array([diagonal, np.append(-stiff, 0.0)])
            band[0, held], force[held] = 1.0, 0.0
            band[1, :-1][held[1:] | held[:-1]] = 0.0
            step = solveh_banded(band, -force, lower=True)
            u = u + step * min(1.0, 0.3 * self.dx / max(np.abs(np.diff(step)).max(), 1e-300))
            if np.abs(step).max() <= 1e-12 * L:
                break
        root = np.sqrt(1 + (np.diff(u) / self.dx) ** 2)
        bound = held[1:] & held[:-1]
        energy = self.k * self.dx / 2 * float(u @ u) + self.gamma1 * self.dx * float(
            (root - 1).sum()
        )
        return u, energy - self.w * self.dx * float(root[bound].sum())

    def to(self, depth):
        """Move to a depth, and nodes until no move lowers the energy."""
        while True:
            u, energy = self.relaxed(self.held, depth)
            through = np.where(self.held, -math.inf, depth - self.f - u)
            if through.max() > 1e-12 * L:
                self.held[np.argmax(through)] = True
                continue
            better = min(self._moves(energy, depth), key=lambda move: move[0], default=None)
            if better is None:
                return
            self.held = better[1]

    def _moves(self, energy, depth):
        edge = np.flatnonzero(np.diff(self.held.astype(int)))
        changed = [[i] for i in np.unique([*edge, *(edge + 1)])]
        gaps = [(a, b) for a, b in itertools.pairwise(edge) if not self.held[a + 1]]
        changed += [nodes for a, b in gaps for nodes in ([a + 1, b], [a, b + 1])]
        for nodes in changed:
            held = self.held.copy()
            held[nodes] ^= True
            if not np.isfinite(self.f[held]).all():
                continue
            u, other = self.relaxed(held, depth)
            clear = (u[~held] >= depth - self.f[~held] - 1e-12 * L).all()
            if clear and other < energy - 1e-12 * self.gamma1 * L:
                yield other, held

    def contacts(self):
        edge = np.flatnonzero(np.diff(self.held.astype(int)))
        return np.column_stack([self.x[edge[::2] + 1], self.x[edge[1::2]]])


@pytest.mark.parametrize(
    ("given", "spacing"),
    [({}, 1 / 7), ({"ratio": 0.05, "height": 0.5, "waves": 4.0}, 1 / 9), ({"phase": 2.0}, 1 / 6)],
)
def test_a_slow_walk_over_plain_nodes_has_the_same_contacts(given, spacing):
    scene = rough(**given)
    walk, dx, delta = Walk(scene, spacing * L), spacing * L, scene.critical_separation
    touch, several = float(walk.f.min()), 0
    depths = np.r_[np.linspace(1e-3, 1.2, 61), np.linspace(1.2, -1.6, 141)[1:]] * delta + touch
    path = load_path(scene, depths=depths, method="lattice", spacing=dx)
    assert Lattice.of(scene, dx).origin == 0
    different = 0
    for i, depth in enumerate(depths.tolist()):
        walk.to(depth)
        inner = path.inner[i]
        found = walk.contacts()
        several = max(several, len(found))
        outer = path.contacts[i]
        lines = [] if np.isnan(outer[0]) else [outer[0], *inner, outer[1]]
        same = len(lines) == found.size and np.abs(lines - found.ravel()).max(initial=0) < 0.51 * dx
        different += not same
        if i % 40 == 20 and depth > depths[max(i - 1, 0)]:
            state = minimise(scene, depth, method="lattice", spacing=dx)
            assert np.allclose(state.nodes, found, rtol=0, atol=1e-9 * L)
    assert several > 1
    assert different == 0


@pytest.mark.parametrize("share", [0.3, 1.2])
def test_contacts_far_apart_are_the_sum_of_single_ones(share):
    radius, apart, delta = 3 * L, 50 * L, rough().critical_separation

    def f(x):
        return (np.abs(x) - apart / 2) ** 2 / (2 * radius)

    body = Profile(
        f, lambda x: np.sign(x) * (np.abs(x) - apart / 2) / radius, extent=(-apart, apart)
    )
    two, one = steep(body), steep(Parabola(radius))
    given = {"depth": share * delta, "method": "lattice", "spacing": L / 25}
    state = minimise(two, **given)
    depths = np.array([0.0, given.pop("depth")])
    single = load_path(one, depths=depths, **given)  # which interpolates as it does
    assert len(state.contacts) == 2
    assert state.force == pytest.approx(2 * single.force[-1], rel=1e-9)
    assert state.energy == pytest.approx(2 * single.energy[-1], rel=1e-9)
    assert state.half_width == pytest.approx(2 * single.half_width[-1], rel=1e-9)
    assert np.ptp(state.contact_angles) <= 1e-3


def test_it_tends_to_the_fitted_mesh_with_second_order():
    scene, errors = rough(ratio=0.2), []
    delta = scene.critical_separation
    for spacing in (1 / 12, 1 / 24, 1 / 48):
        worst = np.zeros(4)
        for share in (0.63, 0.9, 1.07):
            exact = minimise(scene, share * delta)
            state = minimise(scene, share * delta, method="lattice", spacing=spacing * L)
            assert state.contacts.shape == exact.contacts.shape
            off = (
                (state.half_width - exact.half_width) / L,
                (state.force - exact.force) / exact.scales["force"],
                (state.energy - exact.energy) / exact.scales["energy"],
                state.contact_angle - exact.contact_angle,
            )
            worst = np.maximum(worst, np.abs(off))
        assert len(exact.contacts) > 1
        errors.append(worst)
    orders = np.log2(np.array(errors)[0] / np.array(errors)[2]) / 2
    assert (orders > 1.5).all(), orders
    assert (errors[2] < [3e-4, 2e-3, 2e-3, 2e-3]).all(), errors[2]


def test_small_slopes_are_the_limit():
    differences = []
    for ratio in (1e-2, 1e-4):
        finite = rough(ratio=ratio)
        depths = np.array([0.2, 0.9]) * finite.critical_separation
        one, other = (
            load_path(scene, depths=depths, method="lattice", spacing=L / 20)
            for scene in (finite, replace(finite, slopes="small"))
        )
        assert len(one.inner[-1]) == len(other.inner[-1]) > 0
        differences.append(abs(one.force[-1] / other.force[-1] - 1))
    assert differences[1] < 3e-4
    assert differences[1] < differences[0] / 50


@pytest.mark.parametrize("kind", ["plain", "opening", "pattern", "forces", "drives", "w = 0"])
def test_the_energy_balance_of_a_loop_closes(kind):
    scene, given = rough(), {"method": "lattice", "spacing": L / 10}
    if kind == "opening":
        more = SurfaceEnergies.from_work(scene.gamma1, 1.5 * scene.work_of_adhesion)
        scene = replace(scene, opening=more)
    if kind == "pattern":
        scene = replace(scene, pattern=Patches(np.array([-1.0, 1.5]) * L, [1.0, 0.5, 0.8]))
    if kind == "w = 0":
        scene = adhesive(scene.indenter, w=0.0, slopes="finite")
    delta = rough().critical_separation
    lowest = minimise(scene, -5 * delta).range_of_heights[0]
    assert math.isnan(lowest)
    depths = np.r_[np.linspace(-0.5, 1.3, 9), np.linspace(1.3, -3, 15)] * delta
    path = load_path(scene, depths=depths, **given)
    if kind == "forces":
        least, most = 2 * path.force.min(), path.force.max()
        forces = np.r_[np.linspace(0, most, 6), np.linspace(most, least, 12)]
        path = load_path(scene, forces=forces, **given)
    if kind == "drives":
        stiffness = 5 * scene.stiffness * L
        path = load_path(
            scene, drives=np.append(depths, -9 * delta), machine_stiffness=stiffness, **given
        )
    assert any(len(inner) for inner in path.inner)
    assert np.isnan(path.contacts[-1, 0])
    size = np.abs(path.energy).max()
    assert abs(path.work() - path.dissipated) <= 1e-12 * size


def test_a_node_is_torn_open_where_it_would_be_closed():
    lattice, rng = Lattice.of(rough(), L / 3), np.random.default_rng(3)
    f = rng.uniform(0, 0.3, 12) * L
    rules = FiniteRules(lattice, f, rng.uniform(0.5, 1, 11) * lattice.w * lattice.spacing)
    for node in range(1, 11):
        closed = rules.passes(node - 1, 1, node + 1)
        assert rules.torn[node] == pytest.approx(closed, rel=0, abs=1e-12 * L)


@pytest.mark.parametrize("seed", range(6))
def test_a_node_in_contact_may_be_pulled_as_far_as_energy_allows(seed):
    """However steep the links beside it are, which then are less stiff than flat ones."""
    scene, rng = rough(ratio=0.1), np.random.default_rng(seed)
    lattice, f = Lattice.of(scene, L / 3), (0.14 * (np.arange(7) % 2) + rng.uniform(0, 0.04, 7)) * L
    torn = FiniteRules(lattice, f, np.full(6, lattice.w * lattice.spacing)).torn
    node, delta = int(np.argmax(torn)), scene.critical_separation
    for off, failed in ((1e-4, False), (-1e-4, True)):
        depth = torn[node] + off * delta
        held = np.ones((2, 7), bool)
        held[1, node] = False
        closed, opened = (
            model.value(model.relaxed(depth - f))
            for model in (NodalEnergy(lattice, h) for h in held)
        )
        assert (opened < closed) == failed
        contacts = of_heights(lattice, depth - f, [(0, 6)], depth)
        assert ("opening" in judge(contacts, totals(contacts)).failures) == failed
