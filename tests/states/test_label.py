"""Labels say what is known of a state among all states of its scene at its depth."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from scenes import DELTA0, L, adhesive, rough, tips

from discretization import minimise
from energy import FlatPunch, Parabola, Profile, Wedge
from studies.scenes import run as study
from studies.scenes.file import built
from studies.scenes.new import TEMPLATES
from studies.shared.random_cases import SHAPES, random_case, random_steep_case
from studies.shared.table import read

WORDS = {"global", "metastable", "adhered", "neutral", "detached"}


@pytest.mark.parametrize("draw", [random_case, random_steep_case])
def test_a_convex_state_is_global_where_the_global_search_finds_no_less(draw):
    rng, found = np.random.default_rng(5), []
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


@pytest.mark.parametrize("method", [{}, {"method": "lattice", "spacing": L / 50}])
def test_a_punch_is_metastable_between_the_global_and_the_last_depth(method):
    punch = adhesive(FlatPunch(2 * L))
    maxwell = -DELTA0 * np.sqrt(2 / 3)  # -δ₀ √(a/(a + l))
    for depth, word in (
        (DELTA0, "global"),
        (0.99 * maxwell, "global"),
        (1.01 * maxwell, "metastable"),
        (-1.01 * DELTA0, "detached"),
    ):
        assert minimise(punch, depth, **method).label == word


def test_a_profile_that_is_not_convex_is_adhered_or_known_to_be_metastable():
    body = adhesive(tips(3 * L))
    assert minimise(body, 2 * DELTA0, method="lattice", spacing=L / 40).label == "adhered"
    assert minimise(rough(1), 0.0).label == "adhered"
    dented = Profile(lambda x: 0.0 * x, lambda x: 0.0 * x, (-2 * L, 2 * L))
    punch = adhesive(dented + FlatPunch(1.9 * L))  # a punch that does not say that it is convex
    assert minimise(punch, -0.3 * DELTA0).label == "adhered"
    assert minimise(punch, -0.95 * DELTA0).label == "metastable"
    assert minimise(punch, -0.95 * DELTA0, branch="global").label == "detached"


@pytest.mark.parametrize("method", [{}, {"method": "lattice", "spacing": L / 50}])
def test_springs_that_would_gain_beside_the_contact_make_it_metastable(method):
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


def test_without_adhesion_every_state_is_global():
    for body in (Wedge(0.01), rough(2).indenter):
        state = minimise(adhesive(body, w=0.0), DELTA0)
        assert state.label == "global"


def test_the_scene_that_new_writes_is_not_called_metastable_where_it_is_lowest():
    given = built(Path("new.toml"), tomllib.loads((TEMPLATES / "template.toml").read_text("utf-8")))
    states = study.run(given).states
    assert {state.label for state in states} <= WORDS
    for state in states:
        lowest = minimise(given.scene, state.depth, branch="global")
        assert (state.label == "global") == (lowest.energy >= state.energy)
    assert sum(state.label == "global" for state in states) > len(states) / 2


def test_text_table_and_figure_use_the_same_words(tmp_path):
    path = tmp_path / "punch.toml"
    depths = [0.0, -0.95, -1.05]
    path.write_text(
        f"depth = {[d * 1e-6 for d in depths]}\n[layer]\nE = 1e3\nnu = 0.0\nh = 1e-5\n"
        '[surfaces]\ngamma1 = 0.05\nw = 5e-5\n[indenter]\nshape = "flat_punch"\n'
        "half_width = 1e-4\n",
        "utf-8",
    )
    assert study.main([str(path), "--out", str(tmp_path)]) == 0
    words = ["global", "metastable", "detached"]
    assert [row["label"] for row in read(tmp_path / "punch.csv")] == words
    record = study.run(study.built(path, study.read(path)))
    for state, word in zip(record.states, words, strict=True):
        assert f"({word}, adhered branch, fitted)" in str(state)
    told = [text.get_text() for text in study.plot(record).axes[0].get_legend().get_texts()]
    assert [text.split(",")[0] for text in told] == words
