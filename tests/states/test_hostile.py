"""Hostile arguments are refused in words or harmless; and what once failed in a random test."""

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from random_scenes import answered, dice, fuzz, sound, within
from scenes import plain

from discretization import AccuracyWarning, load_path, minimise
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Plane,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

HOSTILE = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1e-300, 1e300, "1", None, True, [1.0], 1j)


@pytest.mark.parametrize("on_lattice", [False, True])
@pytest.mark.parametrize("value", HOSTILE, ids=repr)
@pytest.mark.parametrize("name", ["depth", "rtol", "spacing", "method", "branch"])
def test_hostile_arguments_of_minimise_are_refused_or_harmless(name, value, on_lattice):
    options = {"depth": 0.1, "rtol": 1e-8}
    if on_lattice:
        options |= {"method": "lattice", "spacing": 0.05}
    options[name] = value
    state = answered(lambda: minimise(plain(Parabola(10.0)), **options))
    if state is not None:
        sound(state)


@fuzz
@given(dice)
def test_hostile_parts_of_a_scene_are_refused_or_harmless(dice):
    def some(usual):
        return dice.one_of(*HOSTILE) if dice.chance(0.2) else usual

    def question():
        layer = ElasticLayer(some(1.0), some(0.3), some(1.0))
        surfaces = SurfaceEnergies(some(1.0), some(0.02), some(1.0))
        indenter = dice.one_of(
            lambda: Parabola(some(10.0)),
            lambda: Wedge(some(0.1)),
            lambda: FlatPunch(some(1.0)),
            lambda: PowerLaw(some(0.1), some(3.0)),
            lambda: Sampled([-1.0, some(0.0), 1.0], [some(1.0), 0.0, 1.0]),
            lambda: Profile(some(np.abs), np.sign, extent=(some(-1.0), 1.0)),
        )()
        return minimise(Scene(layer, surfaces, indenter, slopes=some("small")), 0.1)

    state = answered(question)
    if state is not None:
        sound(state)


def steps(indenter, *, w=0.02, gamma1=1.0, **programme):
    """Half-widths of a load path; with the time it may take."""
    scene = plain(indenter, w=w, gamma1=gamma1)
    with within(2), warnings.catch_warnings():
        warnings.simplefilter("error")
        return load_path(scene, **programme).half_width


def test_a_load_path_follows_a_blunt_profile():
    scene = plain(PowerLaw(1.0, 12), w=0.0)
    found = load_path(scene, depths=[0.0018386, 71.8]).half_width[-1]
    assert found == pytest.approx(minimise(scene, 71.8).half_width, rel=1e-13, abs=0)


def test_a_path_without_adhesion_ends_below_touching():
    assert steps(Parabola(10.0), w=0.0, depths=[0.0, -1.0])[-1] == 0


def test_a_path_under_force_without_tension_ends():
    body = PowerLaw(0.1, 20) + FlatPunch(1.0)
    assert steps(body, gamma1=0.0, forces=[0.1, -0.1])[-1] > 0
    with pytest.raises(ValueError, match="below the pull-off force"):
        steps(body, gamma1=0.0, forces=[-0.1])


def test_a_tilted_punch_under_force_raises_no_warning():
    assert np.isfinite(steps(FlatPunch(1.0).tilted(-1.29), w=1.9, forces=[5.0, -0.1, 1.0])).all()


def test_a_tiny_contact_is_held():
    scene = plain(Parabola(10.0))
    delta0 = scene.critical_separation
    with pytest.warns(AccuracyWarning, match="rtol = 1e-08 not reached"):  # of a, not of P
        state = minimise(scene, -delta0 * (1 - 1e-11))
    assert state.label != "detached"
    pull = 2 * scene.stiffness * scene.elastocapillary_length * delta0
    assert state.force == pytest.approx(-pull, rel=1e-10, abs=0)


def test_the_estimate_is_honest_close_to_letting_go():
    scene = plain(PowerLaw(0.1, 3))
    with pytest.warns(AccuracyWarning, match="not reached"):
        state = minimise(scene, -0.2 * (1 - 1e-12), rtol=5e-3)
    true = cards.power_law.half_width(-0.2 * (1 - 1e-12), c=0.1, n=3, k=1.0, gamma1=1.0, w=0.02)
    assert abs(state.half_width / true - 1) <= 10 * state.error_estimate["half_width"]


def test_springs_without_tension_touch_at_depth_zero():
    body = Parabola(10.0) + FlatPunch(1.0)
    assert minimise(plain(body, gamma1=0.0), 0.0).half_width == 0


def test_springs_without_tension_on_a_lattice_print_without_warning():
    scene = plain(Parabola(8.0), gamma1=0.0, w=0.0)
    state = minimise(scene, 0.0625, method="lattice", spacing=0.125)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert str(state)


def test_a_lattice_too_coarse_for_the_body_is_refused():
    with pytest.raises(ValueError, match=r"spacing = 4\.6 leaves one node"):
        minimise(plain(FlatPunch(1.0)), 0.1, method="lattice", spacing=4.6)


def test_a_lattice_of_too_many_nodes_is_refused():
    for indenter, spacing in ((Plane().tilted(0.1), 0.1), (Parabola(10.0), 1e-300)):
        with within(1), pytest.raises(ValueError, match=r"spacing|no lowest point"):
            minimise(plain(indenter), 0.1, method="lattice", spacing=spacing)


def test_a_plane_is_the_same_everywhere():
    assert minimise(plain(Plane().shifted(1.0)), 0.1).contacts.tolist() == [[-math.inf, math.inf]]


def test_a_fine_lattice_is_certified():
    a = 3e-3
    scene = plain(Parabola(a / math.sqrt(0.02)), w=0.01)
    m = {"R": scene.indenter.R, "k": 1.0, "gamma1": 1.0, "w": 0.01}
    depth = float(cards.parabola.depth(a, **m))
    assert minimise(scene, depth, method="lattice", spacing=1e-7).certificate.ok


@pytest.mark.parametrize(
    "question",
    [
        lambda: Sampled([-1.0, 1j, 1.0], [1.0, 0.0, 1.0]),
        lambda: Profile(np.abs, np.sign, extent=([1.0], 1.0)),
        lambda: minimise(plain(PowerLaw(0.1, 1e300)), 0.1),
        lambda: minimise(plain(Parabola(10.0)), 1e300),
        lambda: load_path(plain(Parabola(10.0)), forces="x"),
    ],
)
def test_impossible_numbers_are_refused_in_words(question):
    assert answered(question) is None
