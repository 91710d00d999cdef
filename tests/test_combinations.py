"""Combinations of options, materials and profiles that are rarely asked for together."""

import math

import numpy as np
import pytest
from scenes import plain

from discretization import load_path, minimise
from discretization.fitted.several import parted
from discretization.paths.lattice_branch import LatticeBranch
from energy import FlatPunch, Parabola, Sampled


def summits(length=1.0):
    """Two equal ones."""
    x, z = np.array([-5.0, -2.0, 0.0, 2.0, 5.0]), np.array([1.0, 0.0, 0.15, 0.0, 1.0])
    return Sampled(x * length, z * length)


def test_springs_on_two_summits_are_not_taken_for_those_on_one():
    question = plain(summits(), w=0.02, gamma1=0.0)
    twice = minimise(question, -0.1, branch="global")  # held where f < 0.1
    assert twice.contacts == pytest.approx(
        np.array([[-2.3, -2 + 4 / 3], [2 - 4 / 3, 2.3]]), rel=0, abs=1e-13
    )
    assert twice.force == pytest.approx(-0.49, rel=1e-13, abs=0)
    found = minimise(question, 0.05, branch="global")  # where f < 0.25: once
    assert found.half_width == pytest.approx(2.75, rel=1e-13, abs=0)
    assert found.certificate.ok


def test_the_estimate_of_a_touching_contact_has_no_unit():
    estimates = []
    for length in (1.0, 2.0**-30):
        state = minimise(
            plain(Parabola(10.0 * length), w=0.0, length=length),
            0.0,
            method="lattice",
            spacing=0.07 * length,
        )
        estimates.append(state.error_estimate)
        assert abs(state.force) <= 1e-7 * length
    assert estimates[0] == estimates[1]
    assert min(estimates[0]["force"], estimates[0]["energy"]) > 0.1  # nothing is deformed: U = 0


@pytest.mark.parametrize("depth", [0.3, 1.3, -0.9])
def test_the_far_field_of_finite_slopes_is_balanced(depth):
    state = minimise(plain(FlatPunch(1.0), w=0.9, slopes="finite"), depth)
    x = np.array([2.9, 3.1, 5.0, 9.0])
    u, half = state.displacement(1 + x), np.sqrt(1 - state.displacement(1 + x) ** 2 / 4)
    potential = np.log(np.abs(u) / (1 + half)) + 2 * half  # falls by x, as u²/2 = 1 - cos φ
    assert np.allclose(np.diff(potential), -np.diff(x), rtol=1e-10, atol=0)


@pytest.mark.parametrize("gamma1", [1.0, 0.0])
def test_a_contact_that_adheres_only_when_opened_is_pulled(gamma1):
    question = plain(Parabola(10.0), w=0.0, opening=0.02, gamma1=gamma1)
    path = load_path(question, depths=[0.2, -0.1])  # it ends in tension
    assert path.half_width[-1] > 0
    assert path.force[-1] < 0
    closed = load_path(question, depths=[0.2, -0.1, -1.0])
    assert closed.work() == pytest.approx(closed.dissipated, rel=1e-9, abs=0)


def test_the_work_of_a_path_sees_a_line_that_comes_free_near_its_end():
    question = plain(Parabola(10.0), w=0.02, opening=0.05, slopes="finite")
    delta0 = question.opened.critical_separation
    path = load_path(question, depths=np.array([-0.1, 0.5, -2.0]) * delta0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-10, abs=0)


def test_a_tilted_punch_is_followed_on_a_lattice():
    question = plain(FlatPunch(1.3).tilted(0.05), w=0.02)  # touches at its edge
    depths = np.array([-0.065, 0.0, 0.3, -0.3])
    path = load_path(question, depths=depths, method="lattice", spacing=0.01)
    fitted = load_path(question, depths=depths)
    assert [event.kind for event in path.events] == [event.kind for event in fitted.events]
    assert np.allclose(path.half_width, fitted.half_width, rtol=0, atol=2e-3)
    assert np.allclose(path.force, fitted.force, rtol=0, atol=5e-3)


def measured(height=0.05):
    """A parabola, known on one side of x = 4 only."""
    x = np.linspace(-4, 4, 33)
    return Sampled(x, height * x * x)


@pytest.mark.parametrize("w", [0.02, 0.0])
@pytest.mark.parametrize("gamma1", [1.0, 0.0])
def test_a_measured_profile_under_a_load_stays_on_it(gamma1, w):
    question = plain(measured(), w=w, gamma1=gamma1)
    path = load_path(question, forces=[0.06, 1.0])  # trial depths go beyond the profile
    assert path.force == pytest.approx([0.06, 1.0], rel=1e-11, abs=0)
    assert path.half_width[-1] < 4
    springs = load_path(question, drives=[0.9], machine_stiffness=0.7)
    assert springs.force == pytest.approx(0.7 * (0.9 - springs.depth), rel=1e-12, abs=0)
    for forces in ([100.0], [0.0, 100.0]):
        with pytest.raises(ValueError, match="where the profile is not known"):
            load_path(question, forces=forces)


@pytest.mark.parametrize("depth", [0.1, -5.0])
def test_nothing_is_known_at_no_position(depth):
    state = minimise(plain(Parabola(10.0), w=0.02), depth)
    x = np.array([0.0, math.nan, 50.0])
    assert np.isnan(state.displacement(x)).tolist() == [False, True, False]
    assert np.isnan(state.pressure(x)).tolist() == [False, True, False]


def test_every_gap_at_re_entrant_corners_is_left_out():
    x, z = np.arange(-4.0, 5.0), np.abs(np.arange(-4.0, 5.0) % 2 - 1)
    question = plain(Sampled(x, 0.5 * (1 - z)), w=0.02)  # teeth: corners at every x
    found = parted(question, 2.0, np.array([[-3.9, 3.9]]))
    reach = (1.0 - 2 * math.sqrt(0.04)) / (2 * 1.5)  # f' falls by 1 where u = 2 - 1/2
    at = np.array([-3.0, -1.0, 1.0, 3.0])
    ends = np.sort(np.r_[-3.9, at - reach, at + reach, 3.9]).reshape(-1, 2)
    assert found == pytest.approx(ends, rel=1e-13, abs=0)
    raised = np.array([[-3.9, 3.9]])  # u < 0 at the re-entrant corners: none opens
    assert np.array_equal(parted(question, 0.2, raised), raised)


def test_many_contacts_know_edges_and_refuse_too_many_nodes():
    ends = Sampled(np.array([-2.0, -1.0, 0.0, 1.0, 3.0]), np.array([0.0, 0.1, 0.0, 0.1, 1.0]))
    question = plain(ends + FlatPunch(2.0), w=0.02)
    branch = LatticeBranch.of(question, 0.05, 1.0)
    assert branch.pinned(branch.contact(0.0, -2.0, -1.0)) == ("edge", "")
    assert branch.pinned(branch.contact(0.0, -1.5, 2.0)) == ("", "edge")
    with pytest.raises(ValueError, match="puts 40000000 nodes"):
        LatticeBranch.of(question, 1e-7, 1.0)
