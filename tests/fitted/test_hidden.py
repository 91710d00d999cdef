"""Features of a profile that are narrower than its samples: never two answers without a word."""

import warnings

import numpy as np
import pytest
from support.comparison import check
from support.example_scenes import plain

from discretization import load_path, minimise
from discretization.certificate import AccuracyWarning, NotCertifiedError
from energy import Profile

PASSED = 1e-7  # of the scales: what slopes that no sample resolves, √(2w/γ₁)/64, may store


def spiked(spikes, R=20.0, knots=(), extent=(-9.0, 9.0)):
    """x²/(2R) with Gaussian spikes (height, width, place)."""

    def height(x):
        z = np.asarray(x, float)
        return z**2 / (2 * R) + sum(a * np.exp(-(((z - c) / b) ** 2)) for a, b, c in spikes)

    def slope(x):
        z = np.asarray(x, float)
        return z / R - sum(
            2 * a * (z - c) / b**2 * np.exp(-(((z - c) / b) ** 2)) for a, b, c in spikes
        )

    return Profile(height, slope, extent=extent, knots=knots)


def heard(solve):
    """What it answers, and whether it spoke of a narrow feature."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = solve()
    return found, any("narrower than its samples" in str(each.message) for each in said)


@pytest.mark.parametrize(
    "spikes",
    [
        [(-0.25, 1e-3, 1.234)],
        pytest.param([(-0.25, 1e-2, 1.234)], marks=pytest.mark.slow),  # that samples resolve
        [(-1e-3, 1e-2, 1.234)],  # gentle: the contact stays closed over it
        [(-1e-5, 1e-3, 1.234)],
    ],
)
def test_path_and_state_of_a_spike_agree_or_warn(spikes):
    """A path and a state of a spiked profile agree or one warns."""
    scene = plain(spiked(spikes))
    d = 0.1
    state, said = heard(lambda: minimise(scene, d))
    path, told = heard(lambda: load_path(scene, depths=[0.0, d]))
    if not (said or told):
        check(path.force[-1], state.force, PASSED, state.scales["force"])
        check(path.energy[-1], state.energy, PASSED, state.scales["energy"])


def test_the_spike_that_only_a_path_has_met_is_named():
    scene = plain(spiked([(-0.25, 1e-3, 1.234)]))
    with pytest.warns(AccuracyWarning, match=r"near x = 1\.23.*knots=\(x, "):
        load_path(scene, depths=[0.0, 0.1])


@pytest.mark.parametrize("place", [1.234, -2.0711, 0.31])
def test_a_spike_whose_place_is_given_is_resolved_without_a_word(place):
    # a spike so narrow is a line that carries 2kl u: its tip alone touches
    height = -0.25
    d = 0.1
    scene = plain(spiked([(height, 1e-3, place)], knots=(place,)))
    state = minimise(scene, d)
    lines = state.contacts[np.abs(state.contacts - place).max(axis=1) < 1e-2]
    assert lines.shape == (1, 2)
    tip = d - float(scene.indenter.height(np.array(place)))
    check(state.displacement(np.array([place]))[0], tip, 1e-9)


def test_the_spike_of_a_given_place():
    state = minimise(plain(spiked([(-0.25, 1e-3, 1.234)], knots=(1.234,))), 0.1)
    check(state.force, 0.5581827758, 1e-9)
    check(state.energy, 0.0520297131, 1e-8)


def test_energy_of_a_gentle_resolved_spike():
    # ∫γ₁f'²/2 of the spike alone is a²√(π/2)/(2b); the rest of U hardly notices it
    """A state integrates over a gentle spike that its samples resolve."""
    a = -1e-3
    b = 1e-2
    scenes = (plain(spiked(spikes)) for spikes in ([(a, b, 1.234)], []))
    with_spike, without = (minimise(scene, 0.1).energy for scene in scenes)
    stored = a * a * np.sqrt(np.pi / 2) / (2 * b)
    mixed = 1 / 20 * a * b * np.sqrt(np.pi)  # -∫ f'' of the parabola times the spike, and k g
    pressed = -(0.1 - 1.234**2 / 40) * a * b * np.sqrt(np.pi)
    check(with_spike - without, stored - mixed + pressed, 1e-2)


def random_spikes(seed):
    """One or two spikes up and down, over which a contact stays closed, and a depth."""
    rng = np.random.default_rng([54, seed])
    count = int(rng.integers(1, 3))
    widths = 10 ** rng.uniform(-4, -1, count)
    places = rng.uniform(-3, 3, count)
    heights = widths * 10 ** rng.uniform(-3, -1.2, count) * rng.choice([-1, 1], count)
    slopes = "finite" if rng.random() < 0.2 else "small"
    spikes = list(zip(heights, widths, places, strict=True))
    scene = plain(
        spiked(spikes, 10 ** rng.uniform(0.3, 1.5)), w=10 ** rng.uniform(-2.5, -1), slopes=slopes
    )
    return scene, float(rng.uniform(0.02, 0.5))


def agree(seed):
    """Whether state and path agree, or one of them said why not."""
    scene, d = random_spikes(seed)
    try:
        state, said = heard(lambda: minimise(scene, d))
        if said:
            return True
        path, said = heard(lambda: load_path(scene, depths=[0.0, d]))
    except NotCertifiedError:
        return True  # not in silence
    off = abs(path.force[-1] - state.force) / state.scales["force"]
    more = abs(path.energy[-1] - state.energy) / state.scales["energy"]
    return said or max(off, more) <= PASSED


@pytest.mark.parametrize("first", [0, pytest.param(10, marks=pytest.mark.slow)])
def test_random_spiked_profiles_agree_or_warn(first):
    assert [seed for seed in range(first, first + 5) if not agree(seed)] == []
