"""Properties every equilibrium must have, on generated scenes."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import rescaled

from discretization import NodalEnergy, minimise
from discretization.lattice.state import on_lattice
from discretization.nodes.lattice import Lattice
from energy import Profile
from studies.shared.random_cases import SHAPES, random_case, random_steep_case

cases = st.builds(
    lambda seed, shape: random_case(np.random.default_rng(seed), shape),
    st.integers(0, 10**6),
    st.sampled_from(SHAPES),
)
curved = st.builds(
    lambda seed, shape: random_case(np.random.default_rng(seed), shape),
    st.integers(0, 10**6),
    st.sampled_from(SHAPES[1:]),
)
settings.register_profile("elastocap", deadline=None, derandomize=True, max_examples=40)
settings.load_profile("elastocap")


def solved(case, *, points=50, indenter=None, origin=None, shift=0.0):
    scene = case.scene if indenter is None else replace(case.scene, indenter=indenter)
    return on_lattice(scene, case.depth + shift, case.resolved / points, origin=origin)


@given(cases, st.floats(-0.5, 0.5))
def test_mirror_image_of_the_scene_gives_the_mirror_image_of_the_state(case, tilt):
    """The tilted profile and its mirror image; no symmetric shortcut is taken for either."""
    slope = tilt * case.scene.critical_separation / (2 * case.half_width)
    if case.shape == "wedge":
        slope *= 0.5 * math.tan(case.scene.indenter.delta) * 2 * case.half_width
        slope /= case.scene.critical_separation
    touched = replace(case, depth=abs(case.depth))
    one = solved(touched, indenter=case.scene.indenter.tilted(slope), origin=0.0)
    other = solved(touched, indenter=case.scene.indenter.tilted(-slope), origin=0.0)
    size = np.abs(one.contacts).max()
    assert np.allclose(one.contacts, -other.contacts[:, ::-1], rtol=0, atol=1e-13 * size)
    assert math.isclose(one.force, other.force, rel_tol=0, abs_tol=1e-12 * one.scales["force"])
    assert math.isclose(one.energy, other.energy, rel_tol=0, abs_tol=1e-12 * one.scales["energy"])


steep_cases = st.builds(
    lambda seed, shape: random_steep_case(np.random.default_rng(seed), shape),
    st.integers(0, 10**6),
    st.sampled_from(SHAPES),
)


@given(cases | steep_cases, st.floats(-9, 9), st.floats(-9, 9))
def test_no_result_depends_on_the_units(case, log_length, log_stress):
    length, stress = 10**log_length, 10**log_stress
    dx = case.resolved / 50
    one = minimise(case.scene, case.depth, method="lattice", spacing=dx)
    other = minimise(
        rescaled(case.scene, length, stress),
        case.depth * length,
        method="lattice",
        spacing=dx * length,
    )
    force, energy = stress * length, stress * length**2
    assert math.isclose(other.half_width, one.half_width * length, rel_tol=1e-10)
    assert math.isclose(
        other.force, one.force * force, rel_tol=0, abs_tol=1e-10 * one.scales["force"] * force
    )
    assert math.isclose(
        other.energy, one.energy * energy, rel_tol=0, abs_tol=1e-12 * one.scales["energy"] * energy
    )
    assert math.isclose(other.contact_angle, one.contact_angle, rel_tol=0, abs_tol=1e-10)
    assert other.label == one.label
    fitted, moved = (
        minimise(case.scene, case.depth),
        minimise(rescaled(case.scene, length, stress), case.depth * length),
    )
    assert math.isclose(moved.half_width, fitted.half_width * length, rel_tol=1e-11)
    for name in ("penetration", "stationarity", "opening", "neighbours", "force"):
        ours, theirs = (getattr(state.certificate, name) for state in (fitted, moved))
        assert abs(ours - theirs) <= {"small": 1e-13, "finite": 3e-12}[case.scene.slopes]


@given(curved, st.floats(0, 1))
def test_translating_the_grid_moves_nothing_beyond_its_error(case, offset):
    dx = case.resolved / 100
    here = solved(case, points=100)
    there = solved(case, points=100, origin=offset * dx)
    assert np.abs(here.contacts - there.contacts).max() <= 2 * dx**2 / case.resolved
    assert abs(here.force - there.force) <= 4e-4 * here.scales["force"]


@given(cases, st.floats(-1, 1))
def test_shifting_indenter_and_grid_together_shifts_the_state(case, shift):
    x0 = shift * case.half_width
    here = solved(case)
    there = solved(case, indenter=case.scene.indenter.shifted(x0))
    assert np.allclose(there.contacts - x0, here.contacts, rtol=0, atol=1e-10 * case.half_width)
    assert math.isclose(there.force, here.force, rel_tol=0, abs_tol=1e-12 * here.scales["force"])


@given(curved)
def test_half_width_grows_with_depth(case):
    step = 0.05 * (abs(case.depth) + case.scene.critical_separation)
    widths = [solved(case, shift=i * step).half_width for i in range(5)]
    assert all(np.diff(widths) > 0)


@given(cases, st.integers(0, 10**6))
def test_no_admissible_trial_state_with_one_contact_has_a_lower_energy(case, seed):
    """Random intervals, random free surfaces above the indenter: the nodal energy itself."""
    rng = np.random.default_rng(seed)
    state = solved(case, origin=0.0)
    lattice = Lattice.of(case.scene, state.spacing, origin=0.0)
    reach = int(np.ceil(state.nodes[0, 1] / state.spacing)) + 40
    x = lattice.x(np.arange(-reach, reach + 1.0))
    f = case.scene.indenter.height(
        np.where(np.isclose(abs(x), case.half_width, rtol=1e-9), case.half_width, x)
    )
    g = np.where(np.isfinite(f), case.depth - f, -np.inf)
    raw = np.round(state.nodes[0] / state.spacing).astype(int) + reach
    lowest = None
    for trial in range(30):
        spread = (0, 2, 10, 40)[trial % 4]
        i, j = raw + rng.integers(-spread, spread + 1, 2)
        if not 0 <= i < j <= 2 * reach or not np.isfinite(g[i : j + 1]).all():
            continue
        contact = np.zeros(g.size, bool)
        contact[i : j + 1] = True
        energy = NodalEnergy(lattice, contact)
        u = energy.relaxed(g)
        if trial % 3:
            u += np.where(
                contact, 0.0, rng.normal(size=g.size) * rng.choice([1e-3, 1e-1]) * abs(u).max()
            )
        u = np.where(contact, g, np.maximum(u, g))
        value = energy.value(u)
        lowest = value if lowest is None else min(lowest, value)
    raw_contact = np.zeros(g.size, bool)
    raw_contact[raw[0] : raw[1] + 1] = True
    own = NodalEnergy(lattice, raw_contact)
    mine = own.value(own.relaxed(g))
    assert lowest is not None
    assert mine <= lowest + 1e-9 * state.scales["energy"]
    assert abs(mine - state.energy) <= 0.05 * state.scales["energy"]


@given(cases)
def test_force_is_the_derivative_of_the_energy(case):
    step = 1e-3 * case.scene.critical_separation
    if case.shape == "flat" and case.depth - 2 * step < -case.scene.critical_separation:
        return
    states = [solved(case, points=200, shift=s * step) for s in (-1, 0, 1)]
    slope = (states[2].energy - states[0].energy) / (2 * step)
    assert abs(slope - states[1].force) <= 2e-4 * states[1].scales["force"]


@given(cases)
def test_the_field_carries_the_force(case):
    """k∫u dx over the contact and both tails, by quadrature of the returned displacement."""
    state = solved(case, points=200)
    left, right = state.contacts[0]
    ell = case.scene.elastocapillary_length
    nodes, weights = np.polynomial.legendre.leggauss(60)
    force = 0.0
    for lo, hi in ((left, 0.0), (0.0, right), (right, right + 40 * ell), (left - 40 * ell, left)):
        x = (lo + hi) / 2 + (hi - lo) / 2 * nodes
        force += case.scene.stiffness * (hi - lo) / 2 * float(weights @ state.displacement(x))
    assert abs(force - state.force) <= 2e-4 * state.scales["force"]


@given(curved)
def test_a_callable_profile_gives_what_the_built_in_gives(case):
    """The general search for the lowest point and the full walk against the shortcuts."""
    built_in = case.scene.indenter
    indenter = Profile(built_in.height, built_in.slope, corners=built_in.corners)
    one, other = solved(case), solved(case, indenter=indenter, origin=0.0)
    assert np.allclose(one.contacts, other.contacts, rtol=0, atol=1e-13 * case.half_width)
    assert math.isclose(one.force, other.force, rel_tol=0, abs_tol=1e-13 * one.scales["force"])
