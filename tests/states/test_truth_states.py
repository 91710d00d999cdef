"""States against references of tests/truth: random ones, and what once was wrong and certified."""

import math
import os
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scenes import DELTA0, L, rough
from truth.compare import differences, reference, verdict
from truth.obstacle import obstacle
from truth.penetration import penetration
from truth.scenes import KINDS, case_of
from truth.sets import lowest
from truth.test_truth import LAYER, WORK, ripples
from truth.totals import adhered
from truth.walk import Walk

from discretization import AccuracyWarning, load_path, minimise
from energy import Parabola, Patches, Profile, Sampled, Scene

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


def test_a_line_crosses_the_apex_to_the_edge_of_a_pattern():
    """Left of the edge at 0.05 nothing adheres; the contact is pulled up to that edge."""
    scene = Scene(LAYER, WORK(0.01, 0.00125), Parabola(1.0))
    patterned = replace(scene, pattern=Patches((0.05,), (0.0, 1.0)))
    spacing = 1e-4
    path = load_path(patterned, depths=[0.02, -0.01, -0.04], method="lattice", spacing=spacing)
    left, right = 0.05, _right_line(-0.04)
    force = _pulled_force(-0.04, left, right)
    last = path.at(-1)
    assert last.left == pytest.approx(left, abs=2 * spacing)
    assert last.right == pytest.approx(right, abs=2 * spacing)
    assert path.force[-1] == pytest.approx(force, abs=2 * spacing * 0.05)
    assert force == pytest.approx(-0.00937, abs=1e-5)


def _right_line(depth, l=0.1, alpha=0.5):  # noqa: E741
    """a²/2 + l a = d + α l of a parabola with R = 1, Eq. (33)."""
    return -l + math.sqrt(l * l + 2 * (depth + alpha * l))


def _pulled_force(depth, left, right, l=0.1):  # noqa: E741
    """∫(d - x²/2) dx over the contact, and l (d - x²/2) at both lines; k = 1."""
    inside = depth * (right - left) - (right**3 - left**3) / 6
    return inside + l * (2 * depth - (right**2 + left**2) / 2)


@pytest.mark.parametrize("seed", [3, 9, 11, 24, 30])
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


def _honest(body, depth, a, force, energy):
    """Errors of at most ten times the estimate; γ₁ = 0.04, w = 1e-4, k = 1."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        state = minimise(Scene(LAYER, WORK(GAMMA1, W), body), depth, rtol=1e-2)
    exact = {
        "half_width": (a, a),
        "force": (force, state.scales["force"]),
        "energy": (energy, state.scales["energy"]),
    }
    for name, (true, scale) in exact.items():
        error = abs(getattr(state, name) - true) / scale
        assert error <= max(10 * state.error_estimate[name], 1e-13), name


GAMMA1, W, LENGTH, LIFT = 0.04, 1e-4, 0.2, math.sqrt(2e-4)


@pytest.mark.parametrize(
    ("b", "R", "x0", "depth", "convex"),
    [
        (0.6414096140177508, 0.8959713938549697, 0.0007353958401157962, 0.08419670732411977, False),
        (0.2619152116773472, 2.9680255273384377, -0.04086255060046016, 0.06566342479970307, True),
        (0.337, 1.0, 0.0, 0.01, False),
    ],
)
def test_estimates_see_the_curvature_of_a_rounded_punch(b, R, x0, depth, convex):
    """f = 0 for |x - x0| <= b and a parabola beyond, without declaring where."""

    def beyond(x):
        return np.maximum(np.abs(np.asarray(x) - x0) - b, 0.0)

    body = Profile(
        lambda x: beyond(x) ** 2 / (2 * R),
        lambda x: np.sign(np.asarray(x) - x0) * beyond(x) / R,
        extent=(-3.0, 3.0),
        convex=convex,
    )
    s = -LENGTH + math.sqrt(LENGTH**2 + 2 * R * (depth + LIFT))
    a, g = b + s, depth - s * s / (2 * R)
    force = 2 * (depth * a - s**3 / (6 * R)) + 2 * LENGTH * g
    spring = depth**2 * a - depth * s**3 / (3 * R) + s**5 / (20 * R * R)
    energy = spring + GAMMA1 * s**3 / (3 * R * R) - 2 * W * a + GAMMA1 / LENGTH * g * g
    _honest(body, depth, a, force, energy)


@pytest.mark.parametrize(
    ("x1", "R", "depth"),
    [
        (0.18890547943997332, 4.792511014726725, 0.02417433382456626),
        (0.07582015430863390, 1.9292863187355258, 0.0061299377820738556),
    ],
)
def test_estimates_see_the_curvature_of_a_rounded_cone(x1, R, depth):
    """A parabola for |x| <= x1 and its tangents beyond, without declaring where."""
    tan, rim = x1 / R, x1 * x1 / (2 * R)

    def height(x):
        t = np.abs(np.asarray(x))
        return np.where(t < x1, t * t / (2 * R), rim + tan * (t - x1))

    body = Profile(height, lambda x: np.clip(np.asarray(x), -x1, x1) / R, extent=(-3.0, 3.0))
    top = depth + LIFT - LENGTH * tan
    a, g = x1 + (top - rim) / tan, depth - top
    under = x1**3 / (6 * R) + rim * (a - x1) + tan * (a - x1) ** 2 / 2
    force = 2 * (depth * a - under) + 2 * LENGTH * g
    inner = depth**2 * x1 - depth * x1**3 / (3 * R) + x1**5 / (20 * R * R)
    spring = inner + ((depth - rim) ** 3 - g**3) / (3 * tan)
    bent = x1**3 / (3 * R * R) + tan**2 * (a - x1)
    energy = spring + GAMMA1 * bent - 2 * W * a + GAMMA1 / LENGTH * g * g
    _honest(body, depth, a, force, energy)


def test_estimates_see_a_kink_that_was_not_declared():
    """A wedge without its corner: P and U from Eqs. (25), (27)."""
    tan, x0, depth = 0.123, 0.0137, 0.05
    body = Profile(
        lambda x: tan * np.abs(np.asarray(x) - x0),
        lambda x: tan * np.sign(np.asarray(x) - x0),
        extent=(-3.0, 3.0),
    )
    a = (depth + LIFT) / tan - LENGTH
    g = depth - a * tan
    force = 2 * (a * depth - a * a * tan / 2) + 2 * LENGTH * g
    spring = (depth**3 - g**3) / (3 * tan)
    energy = spring + a * GAMMA1 * tan**2 - 2 * W * a + GAMMA1 / LENGTH * g * g
    _honest(body, depth, a, force, energy)


def test_estimates_count_the_rounding_of_the_profile():
    """cosh x - 1 has lost its digits where x is small; 2 sinh²(x/2) has not."""
    surfaces, depth = WORK(1e-6, 1e-18), 1e-11
    rounded, sound = (
        Profile(height, np.sinh, extent=(-0.1, 0.1), convex=True)
        for height in (lambda x: np.cosh(x) - 1, lambda x: 2 * np.sinh(np.asarray(x) / 2) ** 2)
    )
    truth = adhered(Walk(Scene(LAYER, surfaces, sound), 1e-3), depth)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        state = minimise(Scene(LAYER, surfaces, rounded), depth, rtol=0.5)
    off = abs(state.half_width - truth.half_width) / truth.half_width
    assert off <= 10 * state.error_estimate["half_width"]
    off = abs(state.force - truth.force) / truth.force_scale
    assert off <= 10 * state.error_estimate["force"]


def test_the_angle_at_a_lone_tip_is_the_same_on_both_sides():
    """f' + u' = 1 - 0.2 on either side at every depth near 0."""
    scene = Scene(LAYER, WORK(1.0, 0.02), Sampled([-1.0, 0.0, 1.0], [0.8, -0.2, 0.8]))
    for depth in (0.0, 1e-9, -1e-9):
        angles = minimise(scene, depth).contact_angles
        assert np.abs(angles - (math.pi - 0.8)).max() <= 1e-8


def test_the_verdict_of_a_case_that_is_right():
    assert verdict("small", 0).word == "right"


FEW, MANY = 5, int(os.environ.get("ELASTOCAP_TRUTH", "20"))
REFUSED, SKIPPED = 0.02, 0.05  # of all states, or one of a few
COMPARED = 0.8  # at least


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
