"""`load_path` under dead loads and machines, against the reference of tests/truth.

A random path of each class on both discretisations, twenty or more with `-m slow`; `python -m
tests.truth` counts more of them, and prints one.
"""

import numpy as np
import pytest
from truth.paths.controls import Control, reading_of
from truth.paths.depth_paths import Place, depth_path_of
from truth.paths.path_compare import answer, path_verdicts
from truth.paths.path_scenes import PATH_KINDS, path_case, programme

from discretization import load_path

REFUSED, SKIPPED = 0.005, 0.1  # of all paths, or one
ONCE_WRONG = (  # the path or the reference, or refused
    ("machine_pattern", 187),  # a line 1e-7 beside a corner, whose side is not known by its heights
    ("machine_pattern", 152),  # a surface that has touched a little before its line came free
    ("machine_opening", 217),
    ("machine_pattern", 498),  # a patch that is narrower than two of the nodes it was asked on
    ("machine_opening", 379),  # on nodes, a top of C that is found to rounding at once
    ("machine_opening", 382),  # a contact that closes just beyond the end of the programme
    ("load_opening", 146),  # a jump so short that the reference steps over it at first
    ("load_pattern", 31),  # a contact as wide as the rounding of its tip
    ("load_pattern", 128),  # a top of C where a line has just come free of an edge
    ("load_pattern", 158),  # and of a corner
    ("load_pattern", 318),  # on nodes a corner between two of them holds longer
    ("load_pattern", 23),  # a line that jumps over an edge, by little
    ("load_no_adhesion", 24),  # pulled by rounding at first touch
    ("machine_no_adhesion", 62),  # a narrow gap over a smooth crest, which is felt by its rounding
    ("machine_no_adhesion", 42),  # pressed as deep as the profile is known
    ("machine_no_adhesion", 30),  # a narrow gap at a corner that points inwards
    ("machine_small", 106),  # lines that face each other and hardly come to rest
    ("machine_no_tension", 62),  # a sharp tooth of C in every wave of a profile nearly flat there
)
# In the order of PATH_KINDS, of seeds 0 to 59 of each class the twenty or thirty that take least
# time, the quickest first, with two of each shape and all stiffnesses of machines where one takes
# less than 1.6 s of processor time; a shape that takes longer there comes from seeds 60 to 119.
# With their reference all take about 85 s; machine_opening lacks the tips.
CHEAPEST = (
    "49 0 4 6 7 9 10 12 18 19 23 24 25 29 31 33 35 37 52 58",
    "41 1 2 5 10 15 23 24 30 36 38 45 46 51 52 54 57 59 82 95",
    "5 6 7 8 10 20 24 26 28 29 33 38 39 41 42 49 51 54 57 59",
    "13 1 3 4 5 6 11 15 18 25 27 28 29 30 31 32 33 34 36 37 39 42 44 48 52 55 56 57 58 59",
    "1 0 2 3 4 5 6 7 12 13 15 16 18 21 22 23 26 27 28 29 31 32 35 37 39 42 44 45 47 54",
    "1 3 5 9 14 15 25 26 27 28 32 34 36 37 38 39 47 57 58 72",
    "13 0 2 4 5 8 15 18 19 24 26 28 29 30 42 45 46 50 55 59",
    "2 0 3 4 7 10 14 24 27 30 32 34 35 38 40 46 47 50 53 60",
    "40 3 4 5 6 7 9 12 16 18 19 21 22 26 28 29 34 35 36 37 39 41 43 46 48 51 52 54 55 58",
    "37 1 2 3 5 6 7 9 10 11 12 13 14 18 19 22 23 24 26 27 28 29 30 34 38 44 47 48 52 54 64 89",
)
SEEDS = {
    kind: [int(seed) for seed in seeds.split()]
    for kind, seeds in zip(PATH_KINDS, CHEAPEST, strict=True)
}


@pytest.mark.parametrize("kind", PATH_KINDS)
def test_a_path_is_right_or_refused(kind):
    assert_right_or_refused(kind, SEEDS[kind][:1])


@pytest.mark.slow
@pytest.mark.parametrize("kind", PATH_KINDS)
def test_many_paths_are_right_or_refused(kind):
    assert_right_or_refused(kind, SEEDS[kind][1:])


def assert_right_or_refused(kind, asked):
    """None of the paths of these seeds is wrong, and few are refused or skipped."""
    seeds = {word: {} for word in ("wrong", "refused", "skipped", "right")}
    for seed in asked:
        for method, found in path_verdicts(kind, seed).items():
            seeds[found.word][seed, method] = found.why
    assert not seeds["wrong"], f"{len(seeds['wrong'])} of {len(asked)}: {seeds['wrong']}"
    assert len(seeds["refused"]) <= max(1, REFUSED * len(asked)), seeds["refused"]
    assert len(seeds["skipped"]) <= max(2, SKIPPED * len(asked)), seeds["skipped"]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), ONCE_WRONG)
def test_paths_that_were_wrong(kind, seed):
    for method, found in path_verdicts(kind, seed).items():
        assert found.word == "right", f"{method}: {found.why}"


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["load_small", "load_opening", "load_pattern", "load_no_tension"])
def test_depth_paths_that_turn(kind):
    """What the readings are read off, against paths under imposed depth."""
    for seed in range(2):
        case = path_case(kind, seed)
        path = depth_path_of(case.scene, case.feature)
        depths = path.touch + case.scale * np.array([0.05, 0.6, 1.4, 0.3, -0.3, 0.2, 0.9, -0.6])
        history, place = load_path(case.scene, depths=depths), Place(path.touch)
        for i, depth in enumerate(depths.tolist()):
            place = path.moved(place, depth)
            state = path.totals(place)
            assert abs(history.force[i] - state.force) <= 1e-9 * (state.force_scale or 1)
            assert abs(history.energy[i] - state.energy) <= 1e-9 * (state.energy_scale or 1)


def test_a_line_that_creeps_is_refused_before_long():
    """Beside a corner, with two works of adhesion, where it comes free again and again."""
    case = path_case("machine_opening", 17)
    path = depth_path_of(case.scene, case.feature)
    reading = reading_of(path, Control(case.stiffness), case.scale)
    word, why = answer(case, programme(case, reading), None)[1:3]
    assert word == "right" or "do not come to rest" in why
