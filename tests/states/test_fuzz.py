"""Random scenes and programmes: a documented error, or a right answer."""

import math
from dataclasses import replace
from decimal import Decimal, localcontext

import numpy as np
from hypothesis import given, settings
from random_scenes import ASKED, answered, depth_of, dice, fuzz, scene_and_depth, sound

from discretization import load_path, minimise
from energy import Parabola, PowerLaw, SurfaceEnergies
from studies.benchmarks.stress import reference

CLOSE = 4e-15  # of letting go, in δ₀: rounding of the depth decides
MOST, MANY = 10**6, 2000  # nodes in contact, of one and of several: more only take longer


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


def affordable(dice, scene, depth, unit):
    """A spacing with which neither too few nor too many nodes are in contact; or None."""
    at_least = answered(lambda: minimise(scene, max(depth, 0.0), rtol=1e-2))
    if at_least is None or not 0 < at_least.half_width < math.inf:
        return None
    spacing = (scene.elastocapillary_length or unit) * dice.decade(-3, 1)
    spacing = max(spacing, at_least.half_width / (MOST if scene.indenter.convex else MANY))
    return spacing


@settings(fuzz, max_examples=ASKED or 100)
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


@settings(fuzz, max_examples=ASKED or 25)
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
