"""States that were once wrong and certified, next to references that were found independently."""

import math

import numpy as np
import pytest
from truth.obstacle import obstacle
from truth.penetration import penetration
from truth.springs import springs
from truth.totals import adhered
from truth.walk import Walk

from discretization import minimise
from energy import ElasticLayer, Profile, Sampled, Scene, SurfaceEnergies

LAYER = ElasticLayer(1, 0.0, 1.0)
WORK = SurfaceEnergies.from_work


def ripples(height, wave, extent=2.0):
    k = 2 * np.pi / wave
    return Profile(
        lambda x: np.asarray(x) ** 2 / 2 + height * (1 - np.cos(k * np.asarray(x))),
        lambda x: np.asarray(x) + height * k * np.sin(k * np.asarray(x)),
        extent=(-extent, extent),
    )


TILTED = Profile(
    lambda x: np.asarray(x) ** 2 / 2 + 0.1 * np.asarray(x),
    lambda x: np.asarray(x) + 0.1,
    extent=(-50, 50),
)
WAVES = Profile(
    lambda x: 0.02 * (1 - np.cos(5 * np.pi * np.asarray(x))),
    lambda x: 0.1 * np.pi * np.sin(5 * np.pi * np.asarray(x)),
    extent=(-0.99, 0.99),
)
CASES = {
    "a line stops at its first resting place": (
        Scene(LAYER, WORK(0.16, 0.0035 * 0.16), ripples(0.06, 0.36, 3), slopes="finite"),
        0.01,
        0.36,
        (1, 0.00787),
    ),
    "contacts begin on the way": (
        Scene(LAYER, WORK(0.0025, 1.25e-5), ripples(0.01, 0.2)),
        0.03,
        0.2,
        (3, 0.0066820),
    ),
    "a contact smaller than any lattice": (
        Scene(LAYER, WORK(4.0, 0.0), TILTED),
        -0.005 + 3e-6,
        0.1,
        (1, 1.2e-5),
    ),
    "five contacts smaller than any lattice": (
        Scene(LAYER, WORK(0.04, 2e-6), WAVES),
        -0.001,
        0.4,
        (5, -0.00163),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_examples_are_those_of_the_reference(case):
    scene, depth, feature, (count, force) = CASES[case]
    found = minimise(scene, depth)
    walked = scene.work_of_adhesion > 0
    exact = adhered(Walk(scene, feature), depth) if walked else obstacle(scene, feature, depth)
    assert len(found.contacts) == count
    assert found.force == pytest.approx(force, rel=5e-3, abs=0)  # the digits it was reported with
    assert found.force == pytest.approx(exact.force, rel=0, abs=1e-10 * found.scales["force"])
    assert found.energy == pytest.approx(exact.energy, rel=0, abs=1e-10 * found.scales["energy"])
    assert found.contacts == pytest.approx(exact.contacts, rel=1e-7, abs=0)
    assert found.certificate.ok and max(found.error_estimate.values()) <= 1e-8


@pytest.mark.parametrize(("height", "wave", "depth"), [(0.01, 0.2, 0.03), (0.01, 0.02, 0.1)])
def test_without_adhesion_nothing_penetrates_between_samples(height, wave, depth):
    scene = Scene(LAYER, WORK(0.0025, 0.0), ripples(height, wave))
    found, exact = minimise(scene, depth), obstacle(scene, wave, depth)
    assert found.contacts == pytest.approx(exact.contacts, rel=0, abs=1e-9)
    assert penetration(found, wave) <= 1e-9 * depth


def test_springs_alone_see_small_features():
    scene = Scene(LAYER, WORK(0.0, 2e-4), ripples(0.005, 0.1))
    found, exact = minimise(scene, 0.02), springs(scene, 0.1, 0.02)
    assert found.contacts == pytest.approx(exact.contacts, rel=1e-12, abs=0)
    assert found.force == pytest.approx(exact.force, rel=1e-12, abs=0)


def test_the_lowest_state_is_not_above_the_adhered_one_on_ripples_much_finer_than_l():
    scene = Scene(LAYER, WORK(4.0, 0.02), ripples(0.005, 0.1))
    lowest, adhered_one = (minimise(scene, 0.02, branch=b) for b in ("global", "adhered"))
    fine = minimise(scene, 0.02, branch="global", method="lattice", spacing=1e-3)
    assert lowest.energy <= adhered_one.energy * (1 + 1e-12)
    assert lowest.energy == pytest.approx(fine.energy, rel=2e-3, abs=0)


def test_both_lines_of_a_lone_tip_have_the_same_angle_at_depth_zero():
    tip = Sampled([-1, 0, 1], [0.8, -0.2, 0.8])
    state = minimise(Scene(LAYER, WORK(1.0, 0.02), tip), 0.0)
    left, right = state.contact_angles[0].tolist()
    assert left == pytest.approx(right, rel=1e-12, abs=0) and right < math.pi
