"""Labels, and combinations of options, materials and profiles rarely asked for together."""

import math

import numpy as np
import pytest
from support.example_scenes import DELTA0, L, adhesive, plain, rough, tips

from discretization import load_path, minimise
from energy import FlatPunch, Parabola, Profile, Sampled
from studies.scenes import run as study
from studies.shared.random_cases import SHAPES, random_case, random_steep_case
from studies.shared.table import read


def summits(length=1.0):
    """Two equal ones."""
    x = np.array([-5.0, -2.0, 0.0, 2.0, 5.0])
    z = np.array([1.0, 0.0, 0.15, 0.0, 1.0])
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
    u = state.displacement(1 + x)
    half = np.sqrt(1 - state.displacement(1 + x) ** 2 / 4)
    potential = np.log(np.abs(u) / (1 + half)) + 2 * half  # falls by x, as u²/2 = 1 - cos φ
    assert np.allclose(np.diff(potential), -np.diff(x), rtol=1e-10, atol=0)


def measured(height=0.05):
    """A parabola, known on one side of x = 4 only."""
    x = np.linspace(-4, 4, 33)
    return Sampled(x, height * x * x)


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.02, 0.0])
@pytest.mark.parametrize("gamma1", [1.0, 0.0])
def test_a_measured_profile_under_a_load_stays_on_it(gamma1, w):
    question = plain(measured(), w=w, gamma1=gamma1)
    path = load_path(question, forces=[0.06, 1.0])  # trial depths go beyond the profile
    assert path.force == pytest.approx([0.06, 1.0], rel=1e-11, abs=0)
    assert path.half_width[-1] < 4
    springs = load_path(question, drives=[0.9], machine_stiffness=0.7)
    assert springs.force == pytest.approx(0.7 * (0.9 - springs.depth), rel=1e-12, abs=0)
    for forces in ([100.0], [0.0, 100.0]) if w else ([0.0, 100.0],):  # which takes more time
        with pytest.raises(ValueError, match="where the profile is not known"):
            load_path(question, forces=forces)


@pytest.mark.parametrize("depth", [0.1, -5.0])
def test_nothing_is_known_at_no_position(depth):
    state = minimise(plain(Parabola(10.0), w=0.02), depth)
    x = np.array([0.0, math.nan, 50.0])
    assert np.isnan(state.displacement(x)).tolist() == [False, True, False]
    assert np.isnan(state.pressure(x)).tolist() == [False, True, False]


def test_every_gap_at_re_entrant_corners_is_in_the_lowest_state():
    x = np.arange(-4.0, 5.0)
    z = np.abs(np.arange(-4.0, 5.0) % 2 - 1)
    question = plain(Sampled(x, 0.5 * (1 - z)) + FlatPunch(3.9), w=0.02)  # teeth
    found = minimise(question, 2.0, branch="global").contacts
    reach = (1.0 - 2 * math.sqrt(0.04)) / (2 * 1.5)  # f' falls by 1 where u = 2 - 1/2
    gaps = found.ravel()[1:-1].reshape(-1, 2)
    assert gaps.mean(axis=1) == pytest.approx(np.array([-3.0, -1.0, 1.0, 3.0]), abs=1e-12)
    assert np.diff(gaps) / 2 == pytest.approx(np.full((4, 1), reach), rel=0.25)


@pytest.mark.parametrize("draw", [random_case, random_steep_case])
def test_convex_state_is_global(draw):
    """A convex state is global where the global search finds no less."""
    rng = np.random.default_rng(5)
    found = []
    for i in range(60):
        case = draw(rng, SHAPES[i % len(SHAPES)])
        adhered, lowest = (
            minimise(case.scene, case.depth, rtol=1e-6, branch=branch)
            for branch in ("adhered", "global")
        )
        less = lowest.energy < adhered.energy
        assert adhered.label == ("metastable" if less else "global")
        assert (case.energy > 0 and case.depth <= 0) == less
        found.append(adhered.label)
    assert {*found} == {"global", "metastable"}


def test_nonconvex_state_adhered_or_metastable():
    """A profile that is not convex is adhered or known to be metastable."""
    body = adhesive(tips(3 * L))
    assert minimise(body, 2 * DELTA0, method="lattice", spacing=L / 40).label == "adhered"
    assert minimise(rough(1), 0.0).label == "adhered"
    dented = Profile(lambda x: 0.0 * x, lambda x: 0.0 * x, (-2 * L, 2 * L))
    punch = adhesive(dented + FlatPunch(1.9 * L))  # a punch that does not say that it is convex
    assert minimise(punch, -0.3 * DELTA0).label == "adhered"
    assert minimise(punch, -0.95 * DELTA0).label == "metastable"
    assert minimise(punch, -0.95 * DELTA0, branch="global").label == "detached"


@pytest.mark.parametrize("method", [{}, {"method": "lattice", "spacing": L / 50}])
def test_springs_beside_the_contact_make_it_metastable(method):
    """Springs that would gain beside the contact make it metastable."""
    for body, depth, word in (
        (Parabola(0.02), 0.5 * DELTA0, "metastable"),
        (FlatPunch(2 * L), 0.5 * DELTA0, "global"),
        (FlatPunch(2 * L), -0.5 * DELTA0, "global"),
    ):
        scene = adhesive(body, gamma1=0.0)
        adhered, lowest = (
            minimise(scene, depth, branch=branch, **method) for branch in ("adhered", "global")
        )
        assert adhered.label == word
        assert (lowest.energy < adhered.energy - 1e-9 * adhered.scales["energy"]) == (
            word == "metastable"
        )


@pytest.mark.slow
def test_text_table_and_figure_use_the_same_words(tmp_path):
    path = tmp_path / "punch.toml"
    layer = "E = 1e3\nnu = 0.0\nh = 1e-5"
    surfaces = "gamma1 = 0.05\nw = 5e-5"
    punch = 'shape = "flat_punch"\nhalf_width = 1e-4'
    text = f"[layer]\n{layer}\n[surfaces]\n{surfaces}\n[indenter]\n{punch}\n"
    path.write_text(f"depth = [0.0, -0.95e-6, -1.05e-6]\n{text}", "utf-8")
    assert study.main([str(path), "--out", str(tmp_path)]) == 0
    words = ["global", "metastable", "detached"]
    assert [row["label"] for row in read(tmp_path / "punch.csv")] == words
    record = study.run(study.built(path, study.read(path)))
    for state, word in zip(record.states, words, strict=True):
        assert f"({word}, adhered branch, fitted)" in str(state)
    told = [text.get_text() for text in study.plot(record).axes[0].get_legend().get_texts()]
    assert [text.split(",")[0] for text in told] == words
