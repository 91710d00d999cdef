"""Hostile arguments are refused in words or harmless; and what once failed in a random test."""

import math
from dataclasses import replace
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given, settings
from support.example_scenes import plain
from support.hostile_scenes import ASKED, answered, depth_of, dice, fuzz, scene_and_depth, sound

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
from studies.benchmarks.stress import reference

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


def test_what_once_failed_is_answered():
    """Each without a warning: those are errors here."""
    blunt = plain(PowerLaw(1.0, 12), w=0.0)
    punch = plain(FlatPunch(1.0).tilted(-1.29), w=1.9)
    found = load_path(blunt, depths=[0.0018386, 71.8]).half_width[-1]
    assert found == pytest.approx(minimise(blunt, 71.8).half_width, rel=1e-13, abs=0)
    assert np.isfinite(load_path(punch, forces=[5.0, -0.1, 1.0]).half_width).all()
    assert minimise(plain(Parabola(10.0) + FlatPunch(1.0), gamma1=0.0), 0.0).half_width == 0
    springs = plain(Parabola(8.0), gamma1=0.0, w=0.0)
    assert str(minimise(springs, 0.0625, method="lattice", spacing=0.125))
    assert minimise(plain(Plane().shifted(1.0)), 0.1).contacts.tolist() == [[-math.inf, math.inf]]
    fine = plain(Parabola(3e-3 / math.sqrt(0.02)), w=0.01)
    m = {"R": fine.indenter.R, "k": 1.0, "gamma1": 1.0, "w": 0.01}
    depth = float(cards.parabola.depth(3e-3, **m))
    assert minimise(fine, depth, method="lattice", spacing=1e-7).certificate.ok


def test_contact_and_estimate_next_to_letting_go():
    """Next to letting go contact is held and the estimate honest."""
    with pytest.warns(AccuracyWarning, match="rtol = 1e-08 not reached"):  # of a, not of P
        state = minimise(plain(Parabola(10.0)), -0.2 * (1 - 1e-11))
    assert state.label != "detached"
    assert state.force == pytest.approx(-0.4, rel=1e-10, abs=0)  # 2klδ₀
    with pytest.warns(AccuracyWarning, match="not reached"):
        state = minimise(plain(PowerLaw(0.1, 3)), -0.2 * (1 - 1e-12), rtol=1e-3)
    true = cards.power_law.half_width(-0.2 * (1 - 1e-12), c=0.1, n=3, k=1.0, gamma1=1.0, w=0.02)
    assert abs(state.half_width / true - 1) <= 10 * state.error_estimate["half_width"]


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


CLOSE = 4e-15  # of letting go, in δ₀: rounding of the depth decides
MOST = 10**6
MANY = 2000  # nodes in contact, of one and of several: more only take longer


def exact_at(scene, depth):
    """The closed form in 60 digits, and the problem's condition; None where there is none."""
    if not scene.gamma1 or (scene.slopes == "finite" and not isinstance(scene.indenter, Parabola)):
        return None
    with localcontext(prec=reference.DIGITS):
        try:
            given_ = reference.inputs(scene, depth)
        except ValueError:
            return None
        return given_, reference.answer(given_, scene.slopes)


def agree(scene, depth, numbers, scales, estimates):
    """Half-width, force and energy against the closed form, as far as the estimates promise."""
    found = exact_at(scene, depth)
    delta0 = scene.critical_separation
    lip = 0.0
    if isinstance(scene.indenter, PowerLaw) and scene.indenter.n == 1:
        lip = scene.elastocapillary_length * scene.indenter.c
    if found is None or abs(depth + delta0 - lip) <= CLOSE * (delta0 + lip + abs(depth)):
        return  # about to let go
    given_, exact = found
    if exact is None or not numbers[0]:
        bare = exact is None or not float(exact.half_width)
        assert bare == (not numbers[0]), (exact, numbers)
        return
    with localcontext(prec=reference.DIGITS):
        sizes = [Decimal(float(s)) for s in (exact.half_width, *scales)]
        condition = reference.conditions(given_, scene.slopes, reference.Exact(*sizes))
        for name, value, true, size, c, estimate in zip(
            "aPU", numbers, exact, sizes, condition, estimates, strict=True
        ):
            error = float(abs(Decimal(float(value)) - true) / (size or 1))
            assert error <= 20 * estimate + 1e-13 * (1 + c), (name, error, estimate, c)


def affordable(dice, scene, depth, unit):
    """A spacing with which neither too few nor too many nodes are in contact; or None."""
    at_least = answered(lambda: minimise(scene, max(depth, 0.0), rtol=1e-2))
    if at_least is None or not 0 < at_least.half_width < math.inf:
        return None
    spacing = (scene.elastocapillary_length or unit) * dice.decade(-3, 1)
    return max(spacing, at_least.half_width / (MOST if scene.indenter.convex else MANY))


@settings(fuzz, max_examples=ASKED or 100)
@given(dice)
def test_minimise_answers_rightly_or_refuses(dice):
    scene, unit = scene_and_depth(dice)
    if scene is None:
        return
    depth = depth_of(dice, scene, unit)
    options = {"rtol": dice.one_of(1e-2, 1e-8, 1e-12)}
    if dice.chance(0.25) and (spacing := affordable(dice, scene, depth, unit)):
        options |= {"method": "lattice", "spacing": spacing}
    if dice.chance(0.2):
        options["branch"] = "global"
    state = answered(lambda: minimise(scene, depth, **options))
    if state is None:
        return
    sound(state)
    if "branch" not in options and state.method == "fitted":
        numbers = (state.half_width, state.force, state.energy)
        scales = [state.scales[name] for name in ("force", "energy")]
        agree(scene, depth, numbers, scales, state.error_estimate.values())


@settings(fuzz, max_examples=ASKED or 25)
@given(dice)
def test_load_path_answers_rightly_or_refuses(dice):
    scene, unit = scene_and_depth(dice)
    if scene is None:
        return
    programme = [depth_of(dice, scene, unit) for _ in range(dice.rng.integers(1, 7))]
    name = dice.one_of("depths", "depths", "forces", "drives")
    options = {}
    stiffness = scene.stiffness * (scene.elastocapillary_length or unit)
    if name == "forces":
        programme = [stiffness * value for value in programme]
    if name == "drives":
        options["machine_stiffness"] = stiffness * dice.decade(-2, 2)
    if dice.chance(0.2):
        w = scene.work_of_adhesion * dice.decade(0, 1)
        opening = SurfaceEnergies.from_work(scene.gamma1, w)
        scene = answered(lambda: replace(scene, opening=opening)) or scene
    path = answered(lambda: load_path(scene, **{name: programme}, **options))
    if path is None:
        return
    if name != "depths":
        balanced(path, np.array(programme), options, stiffness * unit)
    assert np.isfinite([path.force, path.energy, path.half_width]).all()
    assert not np.isnan(path.depth).any()
    assert (path.half_width >= 0).all()
    released = [event.energy_released for event in path.events]
    least = 1e-6 * stiffness * unit**2
    size = max(np.abs(path.energy).max(), sum(map(abs, released)), least)
    assert min(released, default=0.0) >= -1e-9 * size
    last = path.at(-1)
    if not math.isnan(last.left) and math.isfinite(last.depth) and not scene.hysteretic:
        same_as_minimised(scene, path)


def balanced(path, programme, options, size):
    """Where there is a contact, the force is the load."""
    held = np.isfinite(path.depth) & ((path.half_width > 0) | (path.force != 0))
    load = programme
    if options:
        load = options["machine_stiffness"] * (programme - np.where(held, path.depth, 0.0))
    assert np.abs(path.force - load)[held].max(initial=0.0) <= 1e-8 * max(np.abs(load).max(), size)


def same_as_minimised(scene, path):
    """Where the path ends in contact, `minimise` finds the same state at that depth.

    A profile that is not convex may keep what it has met further down.
    """
    last = path.at(-1)
    if not scene.indenter.convex and last.depth < path.depth.max():
        return
    state = answered(lambda: minimise(scene, last.depth))
    if state is None or not state.contacts.size:
        return
    estimate = 20 * state.error_estimate["half_width"] + 1e-9
    for name, bar in (("half_width", estimate), ("force", 1e-8), ("energy", 1e-8)):
        size = state.scales.get(name, state.half_width)
        passed = np.abs(getattr(path, name)).max()  # rounding of where it comes from
        found = abs(getattr(state, name) - getattr(last, name))
        assert found <= bar * size + 1e-12 * passed, name
