"""Random scenes and arguments, hostile ones included: a documented error, or a right answer.

A few hundred examples here; ELASTOCAP_FUZZ=20000 asks for as many, at random. What once
failed stands at the end.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import signal
import warnings
from dataclasses import replace
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from discretization import AccuracyWarning, NotCertifiedError, load_path, minimise
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
from studies import stress_reference as reference

ASKED = int(os.environ.get("ELASTOCAP_FUZZ", "0"))
fuzz = settings(
    deadline=None,
    derandomize=not ASKED,
    max_examples=ASKED or 250,
    database=None,
    suppress_health_check=list(HealthCheck),
)
SECONDS = 60  # more is taken for a hang
HOUSE_STYLE = re.compile(r" = |\] |has the attributes|exactly one of|have shapes")
HOSTILE = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1e-300, 1e300, "1", None, True, [1.0], 1j)
NUMBERS = HOSTILE
CLOSE = 4e-15  # of letting go, in δ₀: rounding of the depth decides
MOST, MANY = 10**6, 2000  # nodes in contact, of one and of several: more only take longer


@contextlib.contextmanager
def within(seconds):
    """TimeoutError if the block takes longer."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def late(*_):
        raise TimeoutError(f"not done after {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def answered(question):
    """Its answer; None for a documented refusal. Anything else is raised."""
    with within(SECONDS), warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", AccuracyWarning)
        try:
            return question()
        except (NotCertifiedError, ValueError) as problem:
            message = str(problem)
    assert HOUSE_STYLE.search(message), message
    return None


class Dice:
    """Random choices from one seed."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)

    def between(self, low, high):
        return float(self.rng.uniform(low, high))

    def decade(self, low, high):
        return 10 ** self.between(low, high)

    def one_of(self, *values):
        return values[self.rng.integers(len(values))]

    def chance(self, probability):
        return bool(self.rng.random() < probability)


dice = st.integers(0, 2**62).map(Dice)


def body(dice, ell, rise):
    """An indenter with a slope of the size of `rise` at a distance of some l."""
    a, n = ell * dice.decade(-2, 2), dice.one_of(1, 2, 3, 4, 2.5, 20)
    made = dice.one_of(
        lambda: Plane(),
        lambda: FlatPunch(a),
        lambda: Wedge(math.atan(rise)),
        lambda: Parabola(a / rise),
        lambda: PowerLaw(rise / n * a ** (1 - n), n),
        lambda: PowerLaw(rise / n * a ** (1 - n), n),
        lambda: rough(dice, a, rise),
    )()
    changes = (
        lambda: made.shifted(dice.between(-3, 3) * a),
        lambda: made.tilted(dice.between(-0.5, 0.5) * rise),
        lambda: made + FlatPunch(2 * a),
        lambda: made + Parabola(a / rise),
        lambda: Profile(made.height, made.slope, made.extent, made.corners, made.convex),
    )
    return dice.one_of(*changes)() if dice.chance(0.3) else made


def rough(dice, a, rise):
    """Measured profiles: noise, plateaus, jumps, kinks."""
    n = int(dice.rng.integers(3, 40))
    x = a * (np.sort(dice.rng.uniform(-4, 4, n)) if dice.chance(0.5) else np.linspace(-4, 4, n))
    z = rise / (2 * a) * x * x
    z = z + dice.one_of(0.0, 1e-6, 0.1) * rise * a * dice.rng.normal(size=n)
    if dice.chance(0.3):
        z = np.maximum(z, 0.1 * rise * a)
    if dice.chance(0.3):
        z = z + rise * a * (x > a)
    return Sampled(x, z, kind=dice.one_of("linear", "smooth"))


def scene_and_depth(dice):
    """A scene over many decades, and a displacement of its to measure depths by."""
    ell, stress = dice.decade(-9, 9), dice.decade(-9, 9)
    layer = ElasticLayer(stress, dice.one_of(0.0, 0.3, 0.4999, -0.9), ell * dice.decade(-1, 1))
    gamma1 = layer.stiffness * ell**2
    work = dice.one_of(0.0, 1e-12, 1e-6, 1e-2, 0.3, 1.0, 1.9, 10.0)
    slopes = dice.one_of("small", "small", "finite")
    surfaces = SurfaceEnergies.from_work(0.0 if dice.chance(0.1) else gamma1, work * gamma1)
    rise = math.sqrt(work) * dice.decade(-1, 1) or dice.decade(-4, 0)
    indenter = body(dice, ell, rise)
    scene = answered(lambda: Scene(layer, surfaces, indenter, slopes=slopes))
    return scene, max(scene.critical_separation, rise * ell) if scene else 0.0


def depth_of(dice, scene, unit):
    """Any depth, or one near letting go."""
    if dice.chance(0.7):
        return unit * dice.between(-2, 2) * dice.one_of(1, 10)
    near = dice.one_of(-1.0, -1 + 1e-12, -1 - 1e-12, -1 + 1e-6, 0.0, 1e-12, -1e-12)
    return near * scene.critical_separation


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


def _unsure(scene, depth):
    """Whether the contact is about to let go."""
    delta0, lip = scene.critical_separation, 0.0
    if isinstance(scene.indenter, PowerLaw) and scene.indenter.n == 1:
        lip = scene.elastocapillary_length * scene.indenter.c
    return abs(depth + delta0 - lip) <= CLOSE * (delta0 + lip + abs(depth))


def agree(scene, depth, numbers, scales, estimates):
    """Half-width, force and energy against the closed form, as far as the estimates promise."""
    found = exact_at(scene, depth)
    if found is None:
        return
    given_, exact = found
    if exact is None or not numbers[0]:
        bare = exact is None or not float(exact.half_width)
        assert bare == (not numbers[0]) or _unsure(scene, depth), (exact, numbers)
        return
    if _unsure(scene, depth):
        return
    with localcontext(prec=reference.DIGITS):
        sizes = [Decimal(float(s)) for s in (exact.half_width, *scales)]
        condition = reference.conditions(given_, scene.slopes, reference.Exact(*sizes))
        for name, value, true, size, c, estimate in zip(
            "aPU", numbers, exact, sizes, condition, estimates, strict=True
        ):
            error = float(abs(Decimal(float(value)) - true) / (size or 1))
            assert error <= 20 * estimate + 1e-13 * (1 + c), (name, error, estimate, c)


def sound(state):
    """No NaN, certified, consistent."""
    assert state.certificate.ok
    numbers = (state.half_width, state.force, state.energy)
    assert not any(map(math.isnan, (*numbers, *state.error_estimate.values())))
    assert (state.contacts[:, 0] <= state.contacts[:, 1]).all()
    if math.isfinite(state.half_width):
        assert all(map(math.isfinite, numbers))
        reach = max(state.half_width, state.scene.elastocapillary_length)
        x = np.concatenate([state.contacts.ravel(), np.linspace(-5, 5, 11) * reach])
        assert np.isfinite(state.displacement(x)).all()
        assert np.isfinite(state.pressure(x)).all()
    assert str(state)


def affordable(dice, scene, depth, unit):
    """A spacing with which neither too few nor too many nodes are in contact; or None."""
    at_least = answered(lambda: minimise(scene, max(depth, 0.0), rtol=1e-2))
    if at_least is None or not 0 < at_least.half_width < math.inf:
        return None
    spacing = (scene.elastocapillary_length or unit) * dice.decade(-3, 1)
    spacing = max(spacing, at_least.half_width / (MOST if scene.indenter.convex else MANY))
    return spacing


@fuzz
@given(dice)
def test_minimise_answers_rightly_or_refuses(dice):
    scene, unit = scene_and_depth(dice)
    if scene is None:
        return
    depth, options = depth_of(dice, scene, unit), {"rtol": dice.one_of(1e-2, 1e-8, 1e-12)}
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


@settings(fuzz, max_examples=ASKED or 120)
@given(dice)
def test_load_path_answers_rightly_or_refuses(dice):
    scene, unit = scene_and_depth(dice)
    if scene is None:
        return
    programme = [depth_of(dice, scene, unit) for _ in range(dice.rng.integers(1, 7))]
    name, options = dice.one_of("depths", "depths", "forces", "drives"), {}
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
    """Where the path ends in contact, `minimise` finds the same state at that depth."""
    last = path.at(-1)
    state = answered(lambda: minimise(scene, last.depth))
    if state is None or not state.contacts.size:
        return
    estimate = 20 * state.error_estimate["half_width"] + 1e-9
    for name, bar in (("half_width", estimate), ("force", 1e-8), ("energy", 1e-8)):
        size = state.scales.get(name, state.half_width)
        passed = np.abs(getattr(path, name)).max()  # rounding of where it comes from
        found = abs(getattr(state, name) - getattr(last, name))
        assert found <= bar * size + 1e-12 * passed, name


def plain(indenter):
    surfaces = SurfaceEnergies.from_work(1.0, 0.02)
    return Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, indenter)


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
        return dice.one_of(*NUMBERS) if dice.chance(0.2) else usual

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


PROGRAMMES = ({}, {"depths": []}, {"depths": [math.nan]}, {"depths": 1.0})


@pytest.mark.parametrize("programme", PROGRAMMES, ids=repr)
def test_hostile_programmes_are_refused(programme):
    assert answered(lambda: load_path(plain(Parabola(10.0)), **programme)) is None


def steps(indenter, *, w=0.02, gamma1=1.0, **programme):
    """Half-widths of a load path; with the time it may take."""
    surfaces = SurfaceEnergies.from_work(gamma1, w)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, indenter)
    with within(2), warnings.catch_warnings():
        warnings.simplefilter("error")
        return load_path(scene, **programme).half_width


def test_a_load_path_follows_a_blunt_profile():
    scene = replace(plain(PowerLaw(1.0, 12)), surfaces=SurfaceEnergies.from_work(1.0, 0.0))
    found = load_path(scene, depths=[0.0018386, 71.8]).half_width[-1]
    assert found == pytest.approx(minimise(scene, 71.8).half_width, rel=1e-9, abs=0)


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
        state = minimise(scene, -0.2 * (1 - 1e-12), rtol=1e-2)
    true = cards.power_law.half_width(-0.2 * (1 - 1e-12), c=0.1, n=3, k=1.0, gamma1=1.0, w=0.02)
    assert abs(state.half_width / true - 1) <= 10 * state.error_estimate["half_width"]


def test_springs_without_tension_touch_at_depth_zero():
    surfaces = SurfaceEnergies.from_work(0.0, 0.02)
    body = Parabola(10.0) + FlatPunch(1.0)
    assert minimise(Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, body), 0.0).half_width == 0


def test_springs_without_tension_on_a_lattice_print_without_warning():
    surfaces = SurfaceEnergies.from_work(0.0, 0.0)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, Parabola(8.0))
    state = minimise(scene, 0.0625, method="lattice", spacing=0.125)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert str(state)


def test_a_lattice_too_coarse_for_the_body_is_refused():
    question = minimise, (plain(FlatPunch(1.0)), 0.1), {"method": "lattice", "spacing": 4.6}
    assert answered(lambda: question[0](*question[1], **question[2])) is None


def test_a_lattice_of_too_many_nodes_is_refused():
    for indenter, spacing in ((Plane().tilted(0.1), 0.1), (Parabola(10.0), 1e-300)):
        with within(1), pytest.raises(ValueError, match=r"spacing|no lowest point"):
            minimise(plain(indenter), 0.1, method="lattice", spacing=spacing)


def test_a_plane_is_the_same_everywhere():
    assert minimise(plain(Plane().shifted(1.0)), 0.1).contacts.tolist() == [[-math.inf, math.inf]]


def test_a_fine_lattice_is_certified():
    a = 3e-3
    scene = replace(plain(Parabola(a / math.sqrt(0.02))), surfaces=SurfaceEnergies(1.0, 0.01, 1.0))
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
