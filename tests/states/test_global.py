"""The lowest energy of all states, any number of contacts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from lattices import nodes_of
from scenes import ALPHA, DELTA0, L, adhesive, rough, two

from discretization import NodalEnergy, NotCertifiedError, minimise
from discretization.equilibrium import QUANTITIES
from discretization.lattice.state import on_lattice
from discretization.nodes.ground import heights
from energy import FlatPunch, cards
from studies.shared.random_cases import SHAPES, random_case


def nodal(state):
    """The contact set itself, with its lines on the nodes, and its nodes from end to end."""
    lattice, nodes = nodes_of(state)
    every = np.arange(nodes[0, 0] - 5, nodes[-1, 1] + 6)
    held = ((every >= nodes[:, :1]) & (every <= nodes[:, 1:])).any(axis=0)
    g = state.depth - heights(lattice, state.scene.indenter, every.astype(float))
    return lattice, nodes, held, np.where(held, g, -math.inf), replace(state, contacts=state.nodes)


@pytest.mark.parametrize("shape", SHAPES)
def test_global_is_never_above_adhered_for_convex_indenters(shape):
    labels = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        case = random_case(rng, shape)
        depth = rng.uniform(-1.1, 0.5) * case.scene.critical_separation
        for options in ({}, {"method": "lattice", "spacing": case.resolved / 50}):
            lowest = minimise(case.scene, depth, branch="global", **options)
            adhered = minimise(case.scene, depth, **options)
            rounding = 1e-13 * adhered.scales["energy"]
            assert lowest.energy <= min(adhered.energy, math.inf if depth > 0 else 0.0) + rounding
            assert lowest.certificate.ok and lowest.branch == "global"
            labels.append(lowest.label)
            if lowest.label == "global":
                assert np.allclose(lowest.contacts, adhered.contacts, rtol=1e-13, atol=0)
    assert set(labels) == {"global", "detached"}


def test_global_is_never_above_adhered_for_rough_indenters():
    compared, several, lower = 0, 0, 0
    for seed in range(24):
        scene = rough(seed)
        depth = np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
        options = {"method": "lattice", "spacing": L / 40}
        lowest = minimise(scene, depth, branch="global", **options)
        assert lowest.label == ("global" if lowest.contacts.size else "detached")
        assert lowest.method == "shortest_path"
        assert lowest.proof.violation <= 1e-13
        several += len(lowest.contacts) > 1
        try:
            adhered = minimise(scene, depth, **options)
        except NotCertifiedError:
            continue
        lattice, _, held, g, _ = nodal(adhered) if adhered.contacts.size else (None,) * 5
        raw = 0.0
        if lattice is not None:
            model = NodalEnergy(lattice, held)
            raw = model.value(model.relaxed(g))
        assert lowest.proof.attained <= raw + 1e-11 * lowest.scales["energy"]
        compared += 1
        lower += lowest.proof.attained < raw - 1e-6 * abs(raw)
    assert compared >= 10 and several >= 8 and lower >= 3


@pytest.mark.parametrize("half_width", [0.3 * L, 4 * L])
def test_maxwell_point_of_the_flat_punch(half_width):
    scene = adhesive(FlatPunch(half_width))
    material = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    card = cards.displacement_control.flat_punch_global_pull_off(a=half_width, **material)
    for options, width in (({}, 1e-12), ({"method": "lattice", "spacing": half_width / 200}, 1e-4)):
        above = minimise(scene, card.depth * (1 - width), branch="global", **options)
        below = minimise(scene, card.depth * (1 + width), branch="global", **options)
        assert (above.label, below.label) == ("global", "detached")
        assert above.force == pytest.approx(card.force, rel=2 * width, abs=0)
        assert minimise(scene, card.depth * 1.01, **options).label == "metastable"


def test_mirrored_scene_gives_the_mirrored_state():
    several = 0
    for seed in range(12):
        for w in (0.0, 0.002):
            one, other = (
                minimise(
                    rough(seed, w=w, mirror=mirror),
                    0.8 * DELTA0,
                    method="lattice",
                    branch="global",
                    spacing=L / 40,
                )
                for mirror in (False, True)
            )
            assert np.allclose(one.contacts, -other.contacts[::-1, ::-1], rtol=0, atol=1e-10 * L)
            assert one.force == pytest.approx(other.force, abs=1e-10 * one.scales["force"])
            assert one.energy == pytest.approx(other.energy, abs=1e-12 * one.scales["energy"])
            several += len(one.contacts) > 1
    assert several >= 8


@pytest.mark.parametrize("seed", range(6))
def test_displacement_of_several_contacts_is_the_balanced_one(seed):
    state = minimise(
        rough(seed), 0.9 * DELTA0, method="shortest_path", branch="global", spacing=L / 40
    )
    lattice, nodes, held, g, raw = nodal(state)
    x = lattice.x(np.arange(nodes[0, 0] - 5, nodes[-1, 1] + 6))
    u, size = raw.displacement(x), np.abs(raw.displacement(x)).max()
    assert np.abs(u - NodalEnergy(lattice, held).relaxed(g)).max() <= 1e-12 * size
    balance = NodalEnergy(lattice, held).gradient(u)[~held]
    assert np.abs(balance).max() <= 1e-14 * (lattice.spring + 4 * lattice.link) * size
    # the lines between the nodes: the surface is continuous there and has the slopes reported
    for i, row in enumerate(state.contacts):
        for side, end in zip((-1, 1), row, strict=True):
            step = 1e-6 * L
            beside = state.displacement(end + side * step * np.arange(3))
            slope = (-3 * beside[0] + 4 * beside[1] - beside[2]) / (2 * step)
            own = state.line_slopes[1][i, (side + 1) // 2]
            assert slope == pytest.approx(own, rel=1e-6, abs=1e-8 * ALPHA)


def test_lines_between_two_contacts_are_recovered_to_second_order():
    """Unequal contacts 1.2 l apart; the worst over grid offsets against one eight times finer."""
    scene, depth = adhesive(two(0.6 * L, lift=5e-4)), 0.05 * DELTA0
    finest = on_lattice(scene, depth, L / 1280, branch="global")
    assert finest.contacts.shape == (2, 2)
    errors = []
    for n in (20, 40, 80, 160):
        states = [
            on_lattice(scene, depth, L / n, branch="global", origin=o * L / n)
            for o in (0.0, 0.21, 0.37, 0.5, 0.83)
        ]
        lines = max(np.abs(s.contacts - finest.contacts).max() for s in states) / L
        force = max(abs(s.force - finest.force) for s in states) / finest.scales["force"]
        energy = max(abs(s.energy - finest.energy) for s in states) / finest.scales["energy"]
        angle = max(np.abs(s.angle_deficits / ALPHA - 1).max() for s in states)
        errors.append((lines, force, energy, angle))
    orders = -np.polyfit(np.log([20, 40, 80, 160]), np.log(errors), 1)[0]
    assert (orders > 1.8).all() and (orders < 2.5).all()
    assert (np.array(errors[-1]) <= [8e-6, 4e-5, 2e-3, 3e-4]).all()


def test_no_global_result_depends_on_the_units():
    for seed in (3, 5):
        here = minimise(rough(seed), DELTA0, method="lattice", branch="global", spacing=L / 40)
        assert len(here.contacts) > 1
        for unit, stress in ((1e-6, 3e4), (1e3, 1e-7)):
            there = minimise(
                rough(seed, unit=unit, stress=stress),
                DELTA0 * unit,
                method="lattice",
                branch="global",
                spacing=L / 40 * unit,
            )
            assert np.allclose(there.contacts / unit, here.contacts, rtol=0, atol=1e-11 * L)
            force, energy = there.force / (stress * unit), there.energy / (stress * unit**2)
            assert force == pytest.approx(here.force, abs=1e-12 * here.scales["force"])
            assert energy == pytest.approx(here.energy, abs=1e-13 * here.scales["energy"])
            assert np.allclose(there.contact_angles, here.contact_angles, rtol=0, atol=1e-11)


def test_error_estimates_of_several_contacts_cover_the_error():
    scene, depth = adhesive(two(0.6 * L, lift=5e-4)), 0.05 * DELTA0
    options = {"method": "lattice", "branch": "global"}
    fine, exact = (minimise(scene, depth, spacing=L / n, **options) for n in (100, 1600))
    for name in QUANTITIES:
        scale = {"half_width": exact.half_width, **exact.scales}[name]
        error = abs(getattr(fine, name) - getattr(exact, name)) / scale
        assert error <= fine.error_estimate[name] <= 30 * error
