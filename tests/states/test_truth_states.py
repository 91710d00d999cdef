"""States against references of tests/truth: random ones, and what once was wrong and certified."""

import math
import os
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scenes import (
    ALPHA,
    DELTA0,
    SCENE,
    L,
    adhesive,
    plain,
    rippled,
    rough,
    steep,
    turned,
    two,
    wavy,
)
from truth.compare import differences, penetration, reference, verdict
from truth.obstacle import obstacle
from truth.scenes import KINDS, case_of
from truth.sets import lowest
from truth.test_truth import LAYER, WORK, ripples
from truth.totals import adhered
from truth.walk import Walk

from discretization import AccuracyWarning, Lattice, load_path, minimise
from energy import (
    Circle,
    FlatPunch,
    Parabola,
    Patches,
    Plane,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

COSINES = Profile(
    lambda x: 0.02 * (1 - np.cos(5 * np.pi * np.asarray(x))),
    lambda x: 0.1 * np.pi * np.sin(5 * np.pi * np.asarray(x)),
    extent=(-0.99, 0.99),
)
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
    scene = Scene(LAYER, WORK(0.16, 0.0035 * 0.16), ripples(0.06, 0.36, 3), slopes="finite")
    truth = adhered(Walk(scene, 0.36), 0.01)
    assert truth.force == pytest.approx(0.00787, abs=5e-6)
    agrees(minimise(scene, 0.01), truth)


def test_contacts_that_begin_on_the_way_stay():
    scene = Scene(LAYER, WORK(0.0025, 1.25e-5), ripples(0.01, 0.2))
    truth = adhered(Walk(scene, 0.05), 0.03)
    assert len(truth.contacts) == 3
    agrees(minimise(scene, 0.03), truth)


def test_a_small_contact_without_adhesion():
    scene, above = Scene(LAYER, WORK(4.0, 0.0), OFFSET), 3e-6
    a = above / 2  # a²/2 + a l = d - min f, l = 2
    a -= a * a / (2 * (a + 2))
    force = 2 * (above * a - a**3 / 6) + 4 * (above - a * a / 2)  # 2k l = 4
    state = minimise(scene, -0.005 + above)
    assert state.force == pytest.approx(force, rel=1e-9)
    assert force == pytest.approx(1.2e-5, rel=1e-3)
    agrees(state, obstacle(scene, 2.0, -0.005 + above))


def test_small_contacts_that_are_pulled():
    scene = Scene(LAYER, WORK(0.04, 2e-6), COSINES)
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
    scene = Scene(LAYER, WORK(4.0, 0.02), ripples(0.005, 0.1))
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


FEW, MANY = 5, int(os.environ.get("ELASTOCAP_TRUTH", "20"))
REFUSED, SKIPPED = 0.02, 0.05  # of all states, or one of a few
COMPARED = 0.8  # at least


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_few_states_are_right_or_refused(kind):
    assert_right_or_refused(kind, range(FEW))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_many_states_are_right_or_refused(kind):
    assert_right_or_refused(kind, range(FEW, MANY))


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


FINITE = replace(SCENE, slopes="finite")
OPEN_ENDED = adhesive(Sampled(np.linspace(-L, L, 9), np.array([3, 1, 2, 0, 2, 0, 3, 1, 0]) * 1e-3))
OPENING = adhesive(Parabola(0.02), w=0.001, opening=0.003)
PATTERN = replace(SCENE, pattern=Patches([-L, 1.5 * L], [1.0, 0.5, 0.8]))
RAMP = adhesive(Profile(lambda x: 0.1 * x, lambda x: 0.1 + 0 * x))
HOLE = adhesive(Profile(lambda x: np.where(np.abs(x) < 0.003, x**2, np.nan), lambda x: 2 * x))
BUMPY = Profile(lambda x: 1e-5 * np.cos(900 * np.asarray(x)), lambda x: 0 * x, (-0.02, 0.02))
ROUND_WAVES = turned(rippled(0.9, 2 * L, 0.7 * DELTA0, (-12 * L, 12 * L)))
LIPS = steep(two(5 * L, 0.1 * L, 0.1 * L))
NODES = {"method": "lattice", "spacing": L / 50}
LOWEST = {"branch": "global"}
SEARCH = {"method": "shortest_path", "spacing": L / 20, **LOWEST}
ORACLE = {"method": "oracle", "spacing": L / 400, **LOWEST}
FITTED = ": nodes answer.* use method='fitted'"
STATES = [  # scene, depth, options, words
    (SCENE, math.nan, {}, "depth = nan"),
    (SCENE, "1 mm", {}, "depth = '1 mm'"),
    ("a scene", 1e-3, {}, "scene = 'a scene'"),
    (SCENE, 1e-3, {"method": "magic"}, "'auto', 'lattice'"),
    (SCENE, 1e-3, {"branch": "lucky"}, "'adhered', 'global'"),
    (SCENE, 1e-3, {"rtol": 0.0}, "rtol = 0.0"),
    (SCENE, 1e-3, {"rtol": 2.0}, "rtol = 2.0"),
    (SCENE, 1e-3, {"method": "lattice"}, "spacing = None"),
    (SCENE, 1e-3, {"method": "lattice", "spacing": 0.0}, "spacing = 0.0"),
    (SCENE, 1e-3, {"spacing": 1e-4}, "method='lattice'"),
    (SCENE, 0.0, {"method": "fitted", "spacing": L}, "has no spacing"),
    (SCENE, 0.0, {"method": "shortest_path", **LOWEST}, "spacing = None"),
    (SCENE, 0.0, {**SEARCH, "branch": "adhered"}, "branch = 'adhered'"),
    (SCENE, 0.0, {**ORACLE, "branch": "adhered"}, "branch = 'adhered'"),
    (SCENE, 0.0, ORACLE, "too many for integers"),
    (adhesive(Parabola(1.0), gamma1=0.0), 0.0, ORACLE, "gamma1 = 0"),
    (adhesive(BUMPY, gamma1=0.0), 0.0, NODES, "gamma1 = 0" + FITTED),
    (OPEN_ENDED, 0.0, LOWEST, "not known any more"),
    (OPEN_ENDED, 0.0, {**NODES, **LOWEST}, "not known any more"),
    (RAMP, 0.0, {"method": "lattice", "spacing": 0.1}, "no lowest point"),
    (HOLE, 1e-3, {"method": "lattice", "spacing": 1e-4}, "is not finite"),
    (plain(FlatPunch(1.0)), 0.1, {"method": "lattice", "spacing": 4.6}, "4.6 leaves one node"),
    (plain(Plane().tilted(0.1)), 0.1, {"method": "lattice", "spacing": 0.1}, "no lowest point"),
    (plain(Parabola(10.0)), 0.1, {"method": "lattice", "spacing": 1e-300}, "spacing"),
    (adhesive(Plane()), 0.0, SEARCH, "end to the plane"),
    # finite slopes
    (FINITE, 0.0, SEARCH, "slopes = 'finite'"),
    (replace(OPEN_ENDED, slopes="finite"), 0.0, LOWEST, "slopes='small'"),
    (replace(wavy(), slopes="finite"), 2.3 * DELTA0, LOWEST, "slopes = 'finite'.*slopes='small'"),
    (LIPS, DELTA0, {**NODES, **LOWEST}, "slopes='small'"),
    (LIPS, DELTA0, NODES, "states of one contact only: use method='fitted'"),
    (FINITE, 1e-3, {**NODES, "spacing": 1e-6 * L}, "nodes on a free surface.* use method='fitted'"),
    (replace(OPENING, slopes="finite"), 1e-3, NODES, "slopes = 'finite'" + FITTED),
    (replace(PATTERN, slopes="finite"), 1e-3, NODES, "slopes = 'finite'" + FITTED),
    (steep(FlatPunch(0.03), 1.5), -1.35 * L, NODES, "turn over; use method='fitted'"),
    (steep(Plane(), 1.5), -1.35 * L, NODES, "turn over; use method='fitted'"),
    (steep(Wedge(0.03), 1.5), -1.35 * L, NODES, "turn over; use method='fitted'"),
    (steep(FlatPunch(0.03), 1.4), -1.5 * L, {}, "depth = .* at the contact line x = .* turn over"),
    (plain(Wedge(0.1), w=1.3, slopes="finite"), 0.1, {}, "turn over and be no graph"),
    # rotational symmetry
    (turned(FINITE.indenter, slopes="finite"), 0.0, NODES, "geometry = 'axisymmetric'" + FITTED),
    (turned(BUMPY, gamma1=0.0), 0.0, NODES, "geometry = 'axisymmetric'" + FITTED),
    (turned(Parabola(0.02)), 0.0, ORACLE, "geometry = 'axisymmetric'" + FITTED),
    (replace(ROUND_WAVES, slopes="finite"), 0.5 * DELTA0, LOWEST, "only found for slopes='small'"),
    (replace(ROUND_WAVES, slopes="finite"), 0.5 * DELTA0, {}, "between two is not implemented"),
    # what depends on the way
    (OPENING, 1e-3, LOWEST, "opening = .* use branch='adhered'"),
    (OPENING, 1e-3, {**NODES, **LOWEST}, "opening = .* use branch='adhered'"),
    (PATTERN, 1e-3, LOWEST, "pattern = .* depends on the path; use branch='adhered'"),
    (PATTERN, 1e-3, {**NODES, **LOWEST}, "pattern = .* use branch='adhered'"),
    (replace(OPENING, indenter=Plane()), 1e-3, NODES, "opening = "),
]


@pytest.mark.parametrize(("scene", "depth", "options", "words"), STATES)
def test_a_state_that_is_not_answered_is_refused_in_words(scene, depth, options, words):
    with pytest.raises(ValueError, match=words):
        minimise(scene, depth, **options)


STEPS = {"depths": [1e-3]}
TAUGHT = adhesive(Sampled([-0.01, 0.0, 0.01], [0.0025, 0.0, 0.0025]))
PATHS = [  # scene, options, words
    (SCENE, {}, "exactly one of depths, forces, drives"),
    (SCENE, {"depths": [0.1], "forces": [1.0]}, "exactly one of"),
    (SCENE, {"depths": []}, "depths = .* at least one finite number"),
    (SCENE, {"depths": [0.1, math.nan]}, "at least one finite"),
    (SCENE, {"depths": 0.1}, "must be a list"),
    (SCENE, {"forces": "x"}, "forces = 'x'"),
    (SCENE, {"forces": [-1e9]}, r"forces\[0\] = -1000000000.0 is below the pull-off force"),
    (SCENE, {"depths": [0.1], "rtol": math.nan}, "rtol = nan"),
    (SCENE, {"depths": [0.1], "rtol": 2.0}, "rtol = 2.0 is outside"),
    (SCENE, {"depths": [0.1], "every": 0}, "every = 0 is no number of steps"),
    (SCENE, {"drives": [0.1]}, "machine_stiffness = None with drives"),
    (SCENE, {"drives": [0.1], "machine_stiffness": 0.0}, "machine_stiffness = 0.0 must be posit"),
    (SCENE, {"depths": [0.1], "machine_stiffness": 3.0}, "machine_stiffness = 3.0 with depths"),
    (Parabola(1.0), STEPS, "is not a Scene"),
    (adhesive(Plane()), STEPS, "a profile with a lowest point"),
    (SCENE, {**STEPS, "method": "lattice"}, "spacing = None with method = 'lattice'"),
    (SCENE, {**STEPS, "spacing": 1e-5}, "spacing = 1e-05 with method = 'fitted'"),
    (SCENE, {**STEPS, "method": "mesh"}, "method = 'mesh'"),
    (SCENE, {**STEPS, "method": "lattice", "spacing": -1.0}, "spacing = -1.0"),
    (adhesive(Parabola(0.02), gamma1=0.0), {**STEPS, **NODES}, "gamma1 = 0" + FITTED),
    (steep(FlatPunch(0.03)), {**STEPS, **NODES}, "slopes = 'finite'" + FITTED),
    (TAUGHT, {"depths": [0.1], **NODES}, "whole known profile"),
    (rough(1), {**STEPS, **NODES, "spacing": 1e-9 * L}, "puts .* nodes"),
]


@pytest.mark.parametrize(("scene", "options", "words"), PATHS)
def test_a_path_that_is_not_followed_is_refused_in_words(scene, options, words):
    with pytest.raises(ValueError, match=words):
        load_path(scene, **options)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Patches([1.0, 0.0], [1, 1, 1]), "sort them"),
        (lambda: Patches([0.0], [1.0]), "one more than"),
        (lambda: Patches([0.0], [1.0, -1.0]), "not negative"),
        (lambda: Patches([np.nan], [1.0, 1.0]), "finite numbers"),
        (lambda: replace(SCENE, pattern=3.0), "must be Patches"),
        (lambda: Lattice.of(turned(Parabola(0.02)), 0.1, 0.3), r"origin = 0\.3: with rotational"),
        *(
            (
                lambda s=s: replace(SCENE, opening=SurfaceEnergies.from_work(*s)),
                r"opening = .* must have the gamma1",
            )
            for s in ((0.07, 0.0009), (0.08, 0.003))
        ),
    ],
)
def test_patterns_works_and_nodes_are_checked(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_next_to_what_is_refused_there_is_an_answer():
    """At an angle of nearly 90°, deep inside the layer, and up to the end of a profile."""
    near = minimise(steep(FlatPunch(0.03), 1.4), -1.41 * L)
    assert near.certificate.ok
    assert near.angle_deficit == pytest.approx(2 * math.asin(1.41 / 2), rel=1e-10, abs=0)
    assert minimise(steep(FlatPunch(0.03), 1.5), -1.3 * L, **NODES).certificate.ok
    assert minimise(steep(Parabola(1.0)), 5 * L, **NODES).certificate.ok
    upright = minimise(plain(Wedge(0.1), w=1.0, slopes="finite"), 0.2 - math.sqrt(2))
    assert upright.contact_angle == pytest.approx(math.pi / 2, rel=1e-10, abs=0)
    x = np.linspace(-0.01, 0.01, 201)
    ended = adhesive(Sampled(x, x**2) + FlatPunch(0.009))
    assert minimise(ended, 0.01, method="lattice", spacing=1e-4).half_width == 0.009
    arc = Circle(2 * L / ALPHA)
    assert 0.999 < minimise(adhesive(arc), 400 * arc.R).half_width / arc.R < 1
