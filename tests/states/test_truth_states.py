"""States against references of tests/truth: random ones, and what once was wrong and certified."""

import math
import os
import warnings

import numpy as np
import pytest
from scenes import DELTA0, L, plain, rippled, rough
from truth.compare import differences, penetration, reference, verdict
from truth.obstacle import obstacle
from truth.scenes import KINDS, case_of
from truth.sets import lowest
from truth.totals import adhered
from truth.walk import Walk

from discretization import AccuracyWarning, load_path, minimise
from energy import Profile

COSINES = rippled(math.inf, 0.4, 0.02, (-0.99, 0.99))
OFFSET = Profile(
    lambda x: np.asarray(x) ** 2 / 2 + 0.1 * np.asarray(x),
    lambda x: np.asarray(x) + 0.1,
    extent=(-50.0, 50.0),
)


def agrees(state, truth, scale=1e-9):
    """Contacts, force and energy of a state against the reference."""
    assert state.contacts.shape == truth.contacts.shape
    width = truth.half_width
    assert np.abs(state.contacts - truth.contacts).max(initial=0.0) <= scale * width
    assert abs(state.force - truth.force) <= scale * truth.force_scale
    assert abs(state.energy - truth.energy) <= scale * truth.energy_scale


def test_finite_slopes_stop_at_the_first_rest():
    scene = plain(rippled(1.0, 0.36, 0.06, (-3, 3)), w=0.0035 * 0.16, gamma1=0.16, slopes="finite")
    truth = adhered(Walk(scene, 0.36), 0.01)
    assert truth.force == pytest.approx(0.00787, abs=5e-6)
    agrees(minimise(scene, 0.01), truth)


def test_contacts_that_begin_on_the_way_stay():
    scene = plain(rippled(1.0, 0.2, 0.01, (-2, 2)), w=1.25e-5, gamma1=0.0025)
    truth = adhered(Walk(scene, 0.05), 0.03)
    assert len(truth.contacts) == 3
    agrees(minimise(scene, 0.03), truth)


def test_a_small_contact_without_adhesion():
    scene, above = plain(OFFSET, w=0.0, gamma1=4.0), 3e-6
    a = above / 2  # a²/2 + a l = d - min f, l = 2
    a -= a * a / (2 * (a + 2))
    force = 2 * (above * a - a**3 / 6) + 4 * (above - a * a / 2)  # 2k l = 4
    state = minimise(scene, -0.005 + above)
    assert state.force == pytest.approx(force, rel=1e-9)
    assert force == pytest.approx(1.2e-5, rel=1e-3)
    agrees(state, obstacle(scene, 2.0, -0.005 + above))


def test_small_contacts_that_are_pulled():
    scene = plain(COSINES, w=2e-6, gamma1=0.04)
    truth = adhered(Walk(scene, 0.2), -0.001)
    assert len(truth.contacts) == 5
    agrees(minimise(scene, -0.001), truth)


@pytest.mark.parametrize("seed", [10, 38, 41, 133, 242, 439, 1033, 2292])
def test_without_adhesion(seed):
    """Nothing penetrates (the first three); gaps narrower than two samples, and one that closes."""
    case = case_of("no_adhesion", seed)
    state = minimise(case.scene, case.depth)
    assert penetration(state, case.feature) <= 1e-9 * case.scale
    truth, why = reference(case)
    assert truth is not None, why
    assert not differences(case, state, truth)


def test_the_lowest_state_of_fine_ripples():
    scene = plain(rippled(1.0, 0.1, 0.005, (-2, 2)), w=0.02, gamma1=4.0)
    truth = lowest(scene, 0.1, 0.02)
    state = minimise(scene, 0.02, branch="global")
    assert state.energy <= truth.energy + 1e-9 * truth.energy_scale
    adhered_too = minimise(scene, 0.02).energy
    assert truth.energy <= adhered_too + 1e-9 * truth.energy_scale


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 11])
def test_lattice_paths_of_rough_profiles_come_to_rest(seed):
    """A closed loop on two lattices, the finer one against the walk there and back.

    Next to an event a lattice may be on its other side: at three of the 26 depths at most.
    """
    scene, times = rough(seed), (25, 100)
    levels = np.concatenate([np.linspace(-0.5, 3, 12), np.linspace(3, -1.5, 14)]) * DELTA0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        paths = [load_path(scene, depths=levels, method="lattice", spacing=L / n) for n in times]
    for path in paths:
        assert path.work() == pytest.approx(path.dissipated, rel=1e-8)
        assert path.force[-1] == 0
    walk, truth = Walk(scene, L / 5), []
    for depth in levels.tolist():
        before = not truth and depth < walk.touch
        truth += [] if before else [adhered(walk, depth).force]
    truth = [0.0] * (levels.size - len(truth)) + truth
    off = np.abs(paths[1].force - truth) / (scene.stiffness * DELTA0 * L / times[1])
    assert np.sum(off > 15) <= 3
    assert np.median(off) <= 1


def test_the_verdict_of_a_case_that_is_right():
    assert verdict("small", 0).word == "right"


FEW, MANY = 5, int(os.environ.get("ELASTOCAP_TRUTH", "0"))
# with finite slopes some cases take a hundred times as long as others: of seeds 5 to 44 quick ones
# of every shape that has one
QUICK = {"finite": (5, 6, 10, 11, 13, 15, 16, 19, 26, 27, 28, 29, 33, 41, 43)}
REFUSED, SKIPPED = 0.02, 0.05  # of all states, or one of a few
COMPARED = 0.8  # at least


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_few_states_are_right_or_refused(kind):
    assert_right_or_refused(kind, range(FEW))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_many_states_are_right_or_refused(kind):
    asked = range(FEW, MANY) if MANY else QUICK.get(kind, range(FEW, 20))
    assert_right_or_refused(kind, asked)


def assert_right_or_refused(kind, asked):
    """None of the states of these seeds is wrong, and few are refused or skipped."""
    words = ("wrong", "refused", "skipped", "right", "warned")
    seeds = {word: {} for word in words}
    for seed in asked:
        found = verdict(kind, seed)
        seeds.setdefault(found.word, {})[seed] = found.why
    assert not seeds["wrong"], f"{len(seeds['wrong'])} of {len(asked)}: {seeds['wrong']}"
    assert len(seeds["refused"]) <= max(1, REFUSED * len(asked)), seeds["refused"]
    assert len(seeds["skipped"]) <= max(1, SKIPPED * len(asked)), seeds["skipped"]
    assert len(seeds["right"]) >= COMPARED * len(asked)
