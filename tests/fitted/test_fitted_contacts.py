"""Several contacts on the fitted mesh: against themselves, the lattice, single contacts, energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import ALPHA, DELTA0, L, adhesive, rough, two, wavy

from discretization import load_path, minimise
from discretization.equilibrium import QUANTITIES
from discretization.fitted.several import on_several
from discretization.surfaces import small
from discretization.surfaces.network import Line
from energy import Parabola, Sampled


def linear(seed, w):
    """A rough body with a corner at every second sample of the smooth one."""
    scene = rough(seed, w=w)
    body = scene.indenter.first
    return replace(scene, indenter=Sampled(body.x[::2], body.z[::2]) + scene.indenter.second)


DEPTH = 2.3 * DELTA0
CASES = [(0.0, "adhered"), (0.002, "adhered"), (0.002, "global")]


@pytest.fixture(scope="module")
def states():
    return {case: minimise(wavy(case[0]), DEPTH, branch=case[1]) for case in CASES}


def errors(state, exact):
    """In the lines over l, in a, P and U over their scales."""
    return {
        "lines": np.abs(state.contacts - exact.contacts).max() / L,
        "half_width": abs(state.half_width / exact.half_width - 1),
        "force": abs(state.force - exact.force) / exact.scales["force"],
        "energy": abs(state.energy - exact.energy) / exact.scales["energy"],
    }


@pytest.mark.parametrize("degree", [6, 8, 10, 12])
def test_a_gap_converges_to_rounding_at_any_width(degree):
    """σ = tanh(L/2) and σ + 2τ = coth(L/2)."""
    allowed, line = {6: 2e-12}.get(degree, 4e-15), Line(degree)
    for length in 10.0 ** np.linspace(-8, 1.8, 40):
        found = line.between(1, 0.0, float(length))
        odd = found.left + 2 * found.tie
        assert found.left == found.right == pytest.approx(math.tanh(length / 2), rel=allowed, abs=0)
        assert odd == pytest.approx(1 / math.tanh(length / 2), rel=allowed, abs=0)


def test_the_energy_of_a_gap_changes_with_its_length_by_its_derivative():
    for length in (0.01, 0.4, 3.0, 17.0):
        step = 1e-3 * min(length, 1.0)
        low, high, lower, higher = (
            Line(8).between(1, 0.0, length + n * step) for n in (-1, 1, -2, 2)
        )
        found, moved = (Line(8).between(1, 0.0, each) for each in (length, complex(length, 1e-30)))
        for name in ("left", "tie"):
            change = 8 * (getattr(high, name) - getattr(low, name))
            change -= getattr(higher, name) - getattr(lower, name)
            exact = getattr(moved, name).imag / 1e-30
            size = (found.left + 2 * found.tie) * 1e-11 / min(length, 1.0)
            assert change / (12 * step) == pytest.approx(exact, rel=1e-9, abs=size)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_twenty_contacts_are_those_of_a_higher_degree(states, case, monkeypatch):
    state = states[case]
    assert len(state.contacts) >= 17 and state.method == "fitted"
    assert state.certificate.ok and max(state.error_estimate.values()) <= 1e-8
    monkeypatch.setitem(small._NETS, "line", Line(16))
    exact = on_several(state.scene, state.depth, branch=case[1], rtol=1e-14)
    for name, error in errors(state, exact).items():
        assert error <= 1e-13
        if name in state.error_estimate:
            assert error <= state.error_estimate[name]
    free = state.angle_deficits[~state.pinned]
    alpha = ALPHA if case[0] else 0.0
    assert np.abs(free - alpha).max() <= 1e-11 * ALPHA


@pytest.mark.parametrize("case", CASES)
def test_lattices_converge_to_it_in_second_order(states, case):
    w, branch = case
    found, spacings = [], L / (24 if w else 64) / np.array([1, 2, 4, 8])  # w = 0: a narrow contact
    for spacing in spacings:
        coarse = minimise(wavy(w), DEPTH, branch=branch, method="lattice", spacing=spacing)
        assert coarse.contacts.shape == states[case].contacts.shape
        found.append(errors(coarse, states[case]))
        for name in QUANTITIES:
            assert found[-1][name] <= coarse.error_estimate[name]
    for name in ("lines", "force", "energy"):
        order = np.polyfit(np.log(spacings), np.log([each[name] for each in found]), 1)[0]
        assert 1.9 <= order <= 2.1
    assert found[-1]["lines"] <= 1e-5 and found[-1]["force"] <= 1e-6


def test_the_global_state_is_never_above_the_adhered_one(states):
    adhered, lowest = states[CASES[1]], states[CASES[2]]
    assert len(lowest.contacts) > len(adhered.contacts)
    assert lowest.energy < adhered.energy - 1e-4 * abs(adhered.energy)
    assert (adhered.label, lowest.label) == ("adhered", "global")
    compared = 0
    for seed in range(8):
        scene, depth = rough(seed), np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
        adhered, lowest = (minimise(scene, depth, branch=b) for b in ("adhered", "global"))
        assert lowest.energy <= adhered.energy + 1e-12 * adhered.scales["energy"]
        compared += lowest.energy < adhered.energy - 1e-6 * abs(adhered.energy)
    assert compared >= 2


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_force_is_the_derivative_of_the_energy(states, case):
    state, step = states[case], 1e-3 * DELTA0
    scene = state.scene
    energies = {
        n: minimise(scene, state.depth + n * step, branch=case[1]).energy for n in (-2, -1, 1, 2)
    }
    change = 8 * (energies[1] - energies[-1]) - (energies[2] - energies[-2])
    assert change / (12 * step) == pytest.approx(state.force, rel=0, abs=1e-10 * abs(state.force))


@pytest.mark.parametrize("case", CASES)
def test_the_mirror_image_has_the_mirrored_state(states, case):
    here, there = states[case], minimise(wavy(case[0], mirror=True), DEPTH, branch=case[1])
    mirrored = replace(there, contacts=-there.contacts[::-1, ::-1])
    assert errors(mirrored, here)["lines"] <= 1e-11
    assert max(errors(mirrored, here).values()) <= 1e-11
    x = np.linspace(here.contacts[2, 0], here.contacts[6, 1], 200)
    assert np.abs(there.displacement(-x) - here.displacement(x)).max() <= 1e-11 * DELTA0


@pytest.mark.parametrize(("unit", "stress"), [(1e-6, 3e4), (1e3, 1e-7)])
@pytest.mark.parametrize("case", CASES)
def test_no_unit_enters(states, case, unit, stress):
    scene = wavy(case[0], unit=unit, stress=stress)
    here, there = states[case], minimise(scene, DEPTH * unit, branch=case[1])
    assert np.abs(there.contacts / unit - here.contacts).max() <= 1e-11 * L
    force, energy = there.force / (stress * unit), there.energy / (stress * unit**2)
    assert force == pytest.approx(here.force, abs=1e-12 * here.scales["force"])
    assert energy == pytest.approx(here.energy, abs=1e-12 * here.scales["energy"])
    assert np.allclose(there.contact_angles, here.contact_angles, rtol=0, atol=1e-10)


@pytest.mark.parametrize("w", [0.0, 0.002])
@pytest.mark.parametrize("nodes", [{}, {"method": "lattice", "spacing": L / 200}])
def test_contacts_many_decay_lengths_apart_are_single_ones(w, nodes):
    c, depth = 60 * L, 0.4 * DELTA0
    both, one, other = (
        minimise(adhesive(body, w=w), d, branch="global", **nodes)
        for body, d in (
            (two(c, lift=0.1 * DELTA0), depth),
            (Parabola(0.005).shifted(-c), depth - 0.1 * DELTA0),
            (Parabola(0.003).shifted(c), depth),
        )
    )
    assert np.allclose(both.contacts, [*one.contacts, *other.contacts], rtol=0, atol=1e-10 * L)
    assert both.force == pytest.approx(one.force + other.force, rel=1e-10, abs=0)
    assert both.energy == pytest.approx(one.energy + other.energy, rel=1e-10, abs=0)
    assert np.allclose(
        both.contact_angles, [*one.contact_angles, *other.contact_angles], rtol=1e-10, atol=0
    )
    x = np.linspace(-3 * L, 3 * L, 50)
    assert np.allclose(both.displacement(c + x), other.displacement(c + x), rtol=1e-9, atol=0)
    assert np.allclose(both.pressure(x - c), one.pressure(x - c), rtol=1e-9, atol=0)


def test_the_surface_in_a_gap_is_the_sum_of_two_decays(states):
    state = states[CASES[1]]
    (_, a), (b, _) = state.contacts[5], state.contacts[6]
    x = np.linspace(a, b, 101)
    left, right = state.displacement(np.array([a, b]))
    exact = (left * np.sinh((b - x) / L) + right * np.sinh((x - a) / L)) / math.sinh((b - a) / L)
    assert np.abs(state.displacement(x) - exact).max() <= 1e-11 * DELTA0
    assert (state.displacement(x[1:-1]) > state.depth - state.scene.indenter.height(x[1:-1])).all()
    assert not state.pressure(x[1:-1]).any()


def links(lines, spacing):
    """The nodes that lines are found beside, less than half a link away."""
    return np.rint(np.ravel(lines) / spacing).astype(int)


def test_the_lattice_ends_where_its_load_path_does():
    scene, spacing = wavy(), L / 32
    for depths in ([2.0], [0.8]):
        state = minimise(scene, depths[-1] * DELTA0, method="lattice", spacing=spacing)
        path = load_path(
            scene, depths=np.array([-0.1, *depths]) * DELTA0, method="lattice", spacing=spacing
        )
        assert state.label == "adhered" and state.certificate.ok
        assert np.array_equal(links(state.nodes, spacing), links(path.at(-1).lines, spacing))
        assert len(state.contacts) >= 5


@pytest.mark.parametrize(("seed", "depth"), [(29, -0.1), (142, -0.3)])
def test_a_retraction_keeps_what_the_first_touch_has_brought(seed, depth):
    """At first touch the contact spreads, the surface rises and touches a second crest."""
    scene = rough(seed)
    path = load_path(
        scene, depths=np.array([0.0, depth]) * DELTA0, method="lattice", spacing=L / 32
    )
    coarse = minimise(scene, depth * DELTA0, method="lattice", spacing=L / 32)
    assert np.array_equal(links(coarse.nodes, L / 32), links(path.at(-1).lines, L / 32))
    state = minimise(scene, depth * DELTA0)
    assert len(coarse.contacts) == len(state.contacts) == 2
    assert errors(coarse, state)["lines"] <= 1e-3


@pytest.mark.parametrize("seed", [34, 71])
def test_a_lattice_too_coarse_for_the_path_is_not_believed(seed):
    scene, depth = rough(seed), np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
    state = minimise(scene, depth)
    fine = minimise(scene, depth, method="lattice", spacing=L / 400)
    assert errors(fine, state)["lines"] <= 1e-4


@pytest.mark.parametrize("seed", [5, 16])
@pytest.mark.parametrize("w", [0.0, 0.002])
def test_corners_hold_lines(seed, w):
    scene = linear(seed, w)
    depth = np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
    state = minimise(scene, depth, branch="global")
    assert state.pinned.any() and len(state.contacts) >= (1 if w else 4)
    corners = np.asarray(scene.indenter.corners)
    assert np.isin(state.contacts[state.pinned], corners).all()
    free = state.angle_deficits[~state.pinned]
    assert np.abs(free - (ALPHA if w else 0.0)).max(initial=0.0) <= 1e-9 * ALPHA
    coarse = minimise(scene, depth, branch="global", method="lattice", spacing=L / 80)
    assert abs(coarse.energy - state.energy) <= 2e-3 * state.scales["energy"]


def test_what_finite_slopes_refuse_of_several_contacts():
    scene, nodes = replace(wavy(), slopes="finite"), {"method": "lattice", "spacing": L / 16}
    for given in ({}, nodes):
        with pytest.raises(ValueError, match=r"slopes = 'finite'.*slopes='small'"):
            minimise(scene, DEPTH, branch="global", **given)
