"""`load_path` under dead loads and machines, against the reference of tests/truth.

A random path of each class on both discretisations, six of them with `-m slow`, and with
ELASTOCAP_PATHS=500 as many of each. python -m tests.truth CLASS 1 SEED prints one.
"""

import os

import numpy as np
import pytest
from scenes import adhesive
from truth.paths.controls import Control
from truth.paths.depth_paths import Adhering, Hanging, Place, depth_path_of
from truth.paths.path_compare import answer, path_verdicts
from truth.paths.path_scenes import PATH_KINDS, STEPS, path_case, programme
from truth.paths.unique import reading_of

from discretization import load_path
from energy import ElasticLayer, Parabola, Profile, Sampled, Scene, SurfaceEnergies, cards

FEW, MANY = 1, int(os.environ.get("ELASTOCAP_PATHS", "6"))
REFUSED, SKIPPED = 0.005, 0.1  # of all paths, or one
ONCE_WRONG = (  # the path or the reference, or refused
    ("machine_pattern", 187),  # a line 1e-7 beside a corner, whose side is not known by its heights
    ("machine_pattern", 152),  # a surface that has touched a little before its line came free
    ("machine_opening", 217),
    ("load_opening", 146),  # a jump so short that the reference steps over it at first
    ("load_pattern", 31),  # a contact as wide as the rounding of its tip
    ("load_pattern", 23),  # a line that jumps over an edge, by little
    ("load_no_adhesion", 24),  # pulled by rounding at first touch
    ("machine_no_adhesion", 62),  # a narrow gap over a smooth crest, which is felt by its rounding
    ("machine_no_adhesion", 42),  # pressed as deep as the profile is known
    ("machine_no_adhesion", 30),  # a narrow gap at a corner that points inwards
    ("machine_small", 106),  # lines that face each other and hardly come to rest
    ("machine_no_tension", 62),  # a sharp tooth of C in every wave of a profile nearly flat there
)
LAYER, WORK = ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work


@pytest.mark.parametrize("kind", PATH_KINDS)
def test_a_few_paths_are_right_or_refused(kind):
    assert_right_or_refused(kind, range(FEW))


@pytest.mark.slow
@pytest.mark.parametrize("kind", PATH_KINDS)
def test_many_paths_are_right_or_refused(kind):
    assert_right_or_refused(kind, range(FEW, MANY))


def assert_right_or_refused(kind, asked):
    """None of the paths of these seeds is wrong, and few are refused or skipped."""
    seeds = {word: {} for word in ("wrong", "refused", "skipped", "right")}
    for seed in asked:
        for method, found in path_verdicts(kind, seed).items():
            seeds[found.word][seed, method] = found.why
    assert not seeds["wrong"], f"{len(seeds['wrong'])} of {len(asked)}: {seeds['wrong']}"
    assert len(seeds["refused"]) <= max(1, REFUSED * len(asked)), seeds["refused"]
    assert len(seeds["skipped"]) <= max(2, SKIPPED * len(asked)), seeds["skipped"]


@pytest.mark.parametrize(("kind", "seed"), ONCE_WRONG)
def test_paths_that_were_wrong(kind, seed):
    for method, found in path_verdicts(kind, seed).items():
        assert found.word == "right", f"{method}: {found.why}"


def body(R, far):
    """A parabola that ends."""
    return Profile(Parabola(R).height, Parabola(R).slope, extent=(-far, far))


@pytest.mark.parametrize("R", [0.005, 0.02, 0.3])
def test_a_dead_load_pulls_a_parabola_off_where_the_closed_form_does(R):
    """(a + l)² = R δ₀ and F = (4/3) k √R δ₀^(3/2) + (2/3) k l³/R for Λ <= 1, else 2√(2wγ₁)."""
    scene = adhesive(body(R, 20 * R if R < 0.1 else 2.0))
    k, length, d0 = scene.stiffness, scene.elastocapillary_length, scene.critical_separation
    reading = reading_of(Adhering(scene, length), Control(0.0), d0)
    for force in (0.1 * k * length * d0, -10 * k * (length + np.sqrt(R * d0)) * d0):
        reading.go(force)
    touching, lost = reading.jumps
    small = length / np.sqrt(R * d0) <= 1
    pull = (
        4 / 3 * k * np.sqrt(R) * d0**1.5 + 2 / 3 * k * length**3 / R
        if small
        else 2 * k * length * d0
    )
    assert abs(lost.value + pull) <= 1e-8 * pull
    a = max(np.sqrt(R * d0) - length, 0.0)
    assert abs(lost.first.half_width - a) <= 1e-4 * (a + length)
    given = {"R": R, "k": k, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    after = cards.parabola.force(touching.after.depth, **given)
    assert abs(after) <= 1e-11 * touching.second.force_scale
    assert abs(lost.after.depth + d0) <= 1e-8 * d0


@pytest.mark.parametrize("kind", ["load_small", "load_opening", "load_pattern", "load_no_tension"])
def test_depth_paths_that_turn(kind):
    """What the readings are read off, against paths under imposed depth."""
    for seed in range(4):
        case = path_case(kind, seed)
        path = depth_path_of(case.scene, case.feature)
        depths = path.touch + case.scale * np.array([0.05, 0.6, 1.4, 0.3, -0.3, 0.2, 0.9, -0.6])
        history, place = load_path(case.scene, depths=depths), Place(path.touch)
        for i, depth in enumerate(depths.tolist()):
            place = path.moved(place, depth)
            state = path.totals(place)
            assert abs(history.force[i] - state.force) <= 1e-9 * (state.force_scale or 1)
            assert abs(history.energy[i] - state.energy) <= 1e-9 * (state.energy_scale or 1)


def test_two_tips_without_adhesion():
    """Closed form: two parabolas so far apart that they do not feel each other."""
    D, c = 30.0, 1 / 60
    profile = Profile(
        lambda x: np.minimum((x + D) ** 2 / 20, (x - D) ** 2 / 20 + 0.1),
        lambda x: np.where(np.asarray(x) < c, np.asarray(x) + D, np.asarray(x) - D) / 10,
        extent=(-60, 60),
        corners=(c,),
    )
    reading = reading_of(Hanging(Scene(LAYER, WORK(1.0, 0.0), profile), 1.0), Control(0.0), 1.0)
    right = [0, 0.1367, 0.2052, 0.2633, 0.3155, 0.3636, 0.4087, 0.4514, 0.4921]
    found = [reading.go(force).depth for force in np.linspace(0, 4, 9)]
    assert np.abs(np.array(found) - right).max() <= 5e-5


def test_what_a_stiff_machine_loses_is_what_imposed_depth_loses():
    x = np.linspace(-15, 15, 301)
    z = 0.05 * np.cos(2 * np.pi * x / 5 + 0.4) + 0.004 * x**2
    scene = Scene(LAYER, WORK(1.0, 0.02), Sampled(x, z, kind="smooth"))
    reading = reading_of(Adhering(scene, 1.0), Control(1e8), scene.critical_separation)
    for drive in (0.3, -0.5):
        reading.go(drive)
    assert abs(sum(jump.released for jump in reading.jumps) - 0.30069) <= 1e-5
    assert abs(reading.jumps[-1].before.depth + 0.24807) <= 1e-5


@pytest.mark.parametrize("seed", [4, 8])
def test_springs_jump_where_a_sum_over_many_of_them_does(seed):
    """Pulled by a machine over a flat slope and a contact that splits: C is steep there."""
    case = path_case("machine_no_tension", seed)
    scene, path = case.scene, depth_path_of(case.scene, case.feature)
    reading, let_go = reading_of(path, Control(case.stiffness), case.scale), path.held
    values = programme(case, reading)
    for value in values[: -STEPS[-1]]:
        reading.go(value)
    depths = np.linspace(reading.place.depth, path.touch - let_go, 20_001)
    x, step = np.linspace(*scene.indenter.extent, 100_001, retstep=True)
    f = np.sort(scene.indenter.height(x))
    held = np.searchsorted(f, np.minimum(depths + let_go, reading.place.level))
    force = scene.stiffness * step * (held * depths - np.append(0.0, np.cumsum(f))[held])
    C, before = depths + force / case.stiffness, len(reading.jumps)
    edges = depths[np.flatnonzero(np.diff(np.minimum.accumulate(C) < C, append=False))]
    wide = edges.reshape(-1, 2)[np.diff(edges)[::2] < -0.004 * case.scale]
    reading.go(values[-1])
    found = [(jump.before.depth, jump.after.depth) for jump in reading.jumps[before:]]
    found = [jump for jump in found if jump[0] - jump[1] > 0.004 * case.scale]
    assert len(wide) == len(found) and np.abs(wide - found).max() <= 1e-3 * case.scale


def test_a_line_that_creeps_is_refused_before_long():
    """Beside a corner, with two works of adhesion, where it comes free again and again."""
    case = path_case("machine_opening", 17)
    path = depth_path_of(case.scene, case.feature)
    reading = reading_of(path, Control(case.stiffness), case.scale)
    word, why = answer(case, programme(case, reading), None)[1:3]
    assert word == "right" or "do not come to rest" in why
