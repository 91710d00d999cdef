"""The plain method on nodes: against the fast one, by brute force, and its own certificate."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive, steep

from discretization import minimise
from discretization.lattice.assembly import Question
from discretization.lattice.judge import judge, totals
from discretization.lattice.plain import Plain
from discretization.lattice.plain_state import PlainState, on_plain
from discretization.lattice.state import on_lattice
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.row import Row
from energy import FlatPunch, Parabola, PowerLaw, Profile, Wedge

DX = 2e-4
BODIES = {
    "parabola": lambda x: Parabola(0.02 * x),
    "wedge": lambda x: Wedge(0.1 * x),
    "power": lambda x: PowerLaw(500.0 * x, 3.0),
    "punch": lambda x: FlatPunch(5e-3 * x),
}


def plain_state(scene, depth, spacing, change=(0, 0)):
    """The state found plainly, its outermost nodes moved by so many links."""
    lattice = Lattice.of(scene, spacing)
    plain = Plain(Row.of(lattice.seen(scene), lattice, depth), depth, lattice.critical_gap)
    found = plain.contact()
    nodes = [node + off for node, off in zip(found, change, strict=True)]
    return PlainState.of(plain, *nodes)


def judged(state):
    """Its certificate."""
    return judge(state, totals(state))


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("body", BODIES)
def test_the_fast_method_has_the_same_contacts_and_energies(geometry, body):
    rng, attached = np.random.default_rng(len(body)), 0
    for _ in range(12):
        indenter = BODIES[body](rng.uniform(0.5, 2))
        if geometry == "line" and rng.random() < 0.4:
            indenter = indenter.tilted(rng.uniform(-0.02, 0.02))
        work = rng.choice([0.0, 10 ** rng.uniform(-3, -1)], p=[0.2, 0.8])
        scene = replace(adhesive(indenter, w=0.07 * work), geometry=geometry)
        delta = scene.critical_separation or 1e-3
        depth = delta * rng.uniform(-0.6 if geometry == "line" else 0.0, 2.0)
        spacing = scene.elastocapillary_length / rng.uniform(2, 40)
        fast, lattice = on_lattice(scene, depth, spacing), Lattice.of(scene, spacing)
        seen = lattice.seen(scene)
        plain = on_plain(Question(seen, depth, "adhered"), Row.of(seen, lattice, depth))
        assert np.array_equal(plain.nodes, fast.nodes)
        if not fast.contacts.size:
            continue
        assert np.abs(plain.contacts - fast.contacts).max() <= 1e-7 * spacing
        for name, scale in fast.scales.items():
            assert plain.scales[name] == pytest.approx(scale, rel=1e-9, abs=0)
            assert abs(getattr(plain, name) - getattr(fast, name)) <= 1e-9 * scale
        attached += 1
    assert attached > 5


@pytest.mark.parametrize("change", [(0, 1), (0, -1), (1, 0), (-1, 0)])
@pytest.mark.parametrize("ratio", [0.4, 0.02])
def test_one_link_off_costs_energy(ratio, change):
    scene = steep(Parabola(0.02).tilted(0.05), ratio)
    assert judged(plain_state(scene, 2e-3, DX)).ok
    assert judged(plain_state(scene, 2e-3, DX, change)).failures == ("neighbours",)


def test_a_contact_too_small_penetrates_and_one_too_large_pulls():
    scene = adhesive(Parabola(0.02), w=0.0, slopes="finite")
    small, large = (plain_state(scene, 2e-3, DX, change) for change in ((3, -3), (-3, 3)))
    assert "penetration" in judged(small).failures
    assert "neighbours" in judged(large).failures


@pytest.mark.parametrize("seed", range(4))
def test_a_node_in_contact_may_be_pulled_as_far_as_energy_allows(seed):
    """However steep the links beside it are: of all nodes within the contact, one after another."""
    rng = np.random.default_rng(seed)
    length = steep(Parabola(0.02), 0.1).elastocapillary_length
    x = np.arange(-6, 7) * length / 3
    f = (0.14 * (np.arange(13) % 2) + rng.uniform(0, 0.04, 13)) * length
    body = Profile(
        lambda at: np.interp(at, x, f),
        lambda at: np.zeros_like(at),
        extent=(float(x[0]), float(x[-1])),
    )
    scene = steep(body, 0.1)
    lattice, opened = Lattice.of(scene, length / 3), set()
    delta = scene.critical_separation
    for depth in np.linspace(f.max() + 3 * delta, f.min() - delta, 40).tolist():
        plain = Plain(Row.of(scene, lattice, depth), depth, lattice.critical_gap)
        state = PlainState.of(plain, -5, 5)
        held, gains = np.flatnonzero(state.model.contact)[1:-1], [-math.inf]
        for node in held[state.model.gradient(state.u)[held] < 0].tolist():
            contact = np.arange(state.u.size) != node
            whole, less = NodalEnergy(lattice, contact | True), NodalEnergy(lattice, contact)
            gains.append(whole.value(state.u) - less.value(less.relaxed(state.u)))
        failed = judged(state).opening > 1e-9
        size = lattice.w * length
        if abs(max(gains)) > 1e-9 * size:
            assert failed == (max(gains) > 0)
        opened.add(failed)
    assert opened == {False, True}


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("body", BODIES)
def test_without_tension_every_spring_is_by_itself(geometry, body):
    """Attached where touched, or for the lowest energy where that pays."""
    scene = replace(adhesive(BODIES[body](1.0), gamma1=0.0), geometry=geometry)
    delta, spacing = scene.critical_separation, 1.3e-4
    for share in (1.5, 0.3, 0.0, -0.4, -0.99, -1.01):
        for branch in ("adhered", "global"):
            state = minimise(scene, share * delta, method="lattice", spacing=spacing, branch=branch)
            lowest = state.branch == "global"
            level = share * delta + (delta if lowest else 0.0)
            if share < 0 and not lowest:
                level = 0.0 if share >= -1 else -1.0  # what has touched holds
            if share < -1:
                level = -1.0
            origin = Lattice.of(scene, spacing).origin
            x = origin + spacing * np.arange(-1100, 1101)
            on = x[scene.indenter.height(x) <= level + 1e-12 * delta]
            on = on[on >= 0] if geometry == "axisymmetric" else on
            assert state.contacts.shape == (min(1, on.size), 2), (share, branch)
            if not on.size:
                assert state.label == "detached"
                continue
            assert state.nodes[0] == pytest.approx([on[0], on[-1]], rel=0, abs=1e-12)
            g = share * delta - scene.indenter.height(on)
            area = np.full(on.size, spacing)
            if geometry == "axisymmetric":
                area = 2 * math.pi * spacing * np.where(on > 0, on, spacing / 8)
            energy = area @ (scene.stiffness / 2 * g**2 - scene.work_of_adhesion)
            beside = scene.stiffness * (delta + abs(share * delta)) ** 2 + scene.work_of_adhesion
            assert abs(state.energy - energy) <= 2 * area[-1] * beside
            assert state.certificate.ok


def test_springs_of_a_profile_that_is_not_convex_are_refused_with_the_way_out():
    body = Profile(lambda x: 0.01 * (1 - np.cos(x)), np.sin, extent=(-20.0, 20.0))
    with pytest.raises(ValueError, match=r"gamma1 = 0: nodes answer.* use method='fitted'"):
        minimise(adhesive(body, gamma1=0.0), 0.008, method="lattice", spacing=0.01)


def test_the_free_surface_between_the_nodes_meets_them():
    """The cubic through them, beyond a line between two nodes, against nodes ten times finer."""
    scene = steep(Parabola(0.02), 0.6)
    x = np.linspace(-0.05, 0.05, 301)
    coarse, fine = (on_lattice(scene, 1e-3, DX / share) for share in (1, 10))
    size = np.abs(fine.displacement(x)).max()
    assert np.abs(coarse.displacement(x) - fine.displacement(x)).max() <= 3e-4 * size
    small = replace(scene, slopes="small")
    assert np.abs(on_lattice(small, 1e-3, DX).displacement(x) - fine.displacement(x)).max() > 0


def test_a_node_far_out_on_a_steep_flank_is_compared_with_too():
    """Its link is all but vertical, and has hardly a stiffness for Newton's method."""
    lattice = Lattice.of(steep(Parabola(0.02), 1.0), 1e-3)
    model = NodalEnergy(lattice, np.arange(80) < 2)
    u = model.relaxed(np.where(np.arange(80) == 1, -1e7, -1e-14))
    assert np.isfinite(model.value(u))
    assert u[1] == -1e7
