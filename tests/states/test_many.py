"""Many states at once: as one by one, in any unit, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.arrays_of_states import Case, differences
from support.comparison import check
from support.example_scenes import ALPHA, DELTA0, SCENE, L, adhesive, exact, rescaled, turned

from discretization import Equilibria, NotCertifiedError, minimise, minimise_many
from energy import (
    Circle,
    FlatPunch,
    Parabola,
    Patches,
    Plane,
    PowerLaw,
    Profile,
    Sampled,
    SurfaceEnergies,
    Wedge,
)

K = SCENE.stiffness
GAMMA1 = SCENE.gamma1
W = SCENE.work_of_adhesion
FIELDS = ("half_width", "force", "energy", "contact_angle", "in_contact", "stable", "residual")
DEPTHS = np.linspace(-0.9, 2.0, 7) * DELTA0


@pytest.mark.parametrize("seed", range(30))
def test_many_are_those_found_one_by_one(seed):
    worst, compared = differences(Case(seed))
    assert compared and (worst <= 1).all(), worst


@pytest.mark.slow
@pytest.mark.parametrize("hundred", range(3))
def test_three_thousand_are_those_found_one_by_one(hundred):
    found = [differences(Case(1000 + 105 * hundred + i)) for i in range(105)]
    assert sum(count for _, count in found) > 900
    for worst, _ in found:
        assert (worst <= 1).all(), worst


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_uncertainties_are_those_of_one_state(geometry):
    """But for bounds of sums whose terms change their sign, and roundings counted once more."""
    scene = replace(SCENE, geometry=geometry)
    many = minimise_many(scene, DEPTHS[2:])
    for i, depth in enumerate(DEPTHS[2:]):
        for name, size in minimise(scene, depth).uncertainty.items():
            assert 0.5 < many.uncertainty[name][i] / size < 10


def test_arguments_broadcast_and_so_do_the_results():
    works = np.array([0.5, 1.0, 2.0]) * W
    tensions = np.array([[1.0], [3.0]]) * GAMMA1
    found = minimise_many(SCENE, DELTA0, w=works, gamma1=tensions, stiffness=2 * K)
    assert {getattr(found, name).shape for name in FIELDS} == {(2, 3)}
    layer = replace(SCENE.layer, E=2 * SCENE.layer.E)
    surfaces = SurfaceEnergies.from_work(3 * GAMMA1, 2 * W)
    one = minimise(replace(SCENE, layer=layer, surfaces=surfaces), DELTA0)
    check(found.half_width[1, 2], one.half_width, 1e-13)
    check(found.force[1, 2], one.force, 1e-13, one.scales["force"])
    check(found.energy[1, 2], one.energy, 1e-13, one.scales["energy"])
    alone = minimise_many(SCENE, DELTA0)
    assert alone.force.shape == ()
    assert "in contact: 1" in repr(alone)
    assert minimise_many(SCENE, []).force.shape == (0,)
    assert isinstance(found, Equilibria)


def test_a_state_does_not_depend_on_the_others():
    """But for rounding: products of matrices add in another order."""
    wide = np.concatenate([DEPTHS, 1e6 * DEPTHS, 1e-6 * DEPTHS])
    body = Sampled(*(np.linspace(-40, 40, 81) * L, np.linspace(-40, 40, 81) ** 2 * L / 100))
    for scene in (SCENE, adhesive(body), turned(Parabola(0.02))):
        depths = DEPTHS if scene.indenter is body else wide
        many = minimise_many(scene, depths)
        for i in (0, 3, 6):
            one = minimise_many(scene, depths[i])
            for name in FIELDS[:3]:
                check(getattr(one, name), getattr(many, name)[i], 1e-13)


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_units_do_not_matter(slopes, geometry):
    scene = replace(SCENE, slopes=slopes, geometry=geometry)
    length = 1e3
    stress = 1e-6  # from m and Pa to mm and N/mm²
    other = rescaled(scene, length, stress)
    works = W * np.geomspace(0.1, 10, 7)
    one = minimise_many(scene, DEPTHS, w=works)
    scaled = minimise_many(other, length * DEPTHS, w=stress * length * works)
    power = 2 if geometry == "axisymmetric" else 1
    assert (one.in_contact == scaled.in_contact).all()
    assert one.in_contact.any()
    check(scaled.half_width / length, one.half_width, 1e-11)
    size = np.abs(one.force).max()
    check(scaled.force / (stress * length**power), one.force, 1e-11, size)
    size = np.abs(one.energy).max()
    check(scaled.energy / (stress * length ** (power + 1)), one.energy, 1e-11, size)
    check(scaled.contact_angle[one.in_contact], one.contact_angle[one.in_contact], 1e-11)


def test_limits():
    """Touching, a tip, an edge, no adhesion, no tension, deep, and just before it is lost."""
    touch = minimise_many(SCENE, 0.0, w=0.0)
    assert touch.in_contact
    assert touch.half_width == touch.force == touch.energy == 0
    assert minimise_many(SCENE, [-DELTA0 / 9], w=0.0).in_contact.tolist() == [False]

    blunt = adhesive(Wedge(math.atan(3 * ALPHA)))
    tip = minimise_many(blunt, 0.5 * DELTA0)
    assert tip.in_contact
    assert tip.half_width == 0
    assert tip.stable
    check(tip.force, 2 * K * L * 0.5 * DELTA0, 1e-12)

    punch = minimise_many(adhesive(FlatPunch(L)), np.array([-0.999, -1.001]) * DELTA0)
    assert punch.in_contact.tolist() == [True, False]
    assert punch.half_width[0] == L

    springs = minimise_many(SCENE, [-0.5 * DELTA0, DELTA0, -2 * DELTA0], gamma1=0.0)
    assert springs.in_contact.tolist() == [True, True, False]
    assert np.isnan(springs.contact_angle).all()
    check(springs.half_width[:2], np.sqrt(2 * 0.02 * np.array([0.0, DELTA0])), 1e-14)

    deep = minimise_many(SCENE, 1e9 * DELTA0)
    check(deep.half_width, math.sqrt(2 * 0.02 * 1e9 * DELTA0), 1e-3)
    assert deep.residual < 1e-14


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_a_fold_about_an_axis_is_where_one_state_has_it(slopes):
    scene = replace(turned(Parabola(0.02)), slopes=slopes)
    held = 0.0
    gone = -DELTA0
    for _ in range(60):
        middle = (held + gone) / 2
        held, gone = (middle, gone) if minimise_many(scene, middle).in_contact else (held, middle)
    margin = 1e-13 * DELTA0
    assert minimise(scene, held + margin).contacts.size
    assert not minimise(scene, gone - margin).contacts.size
    near = minimise_many(scene, [held + margin, held])
    one = minimise(scene, held + margin)
    check(near.half_width, np.full(2, one.half_width), 1e-5)
    assert near.stable.all()
    assert (near.residual < 1e-13).all()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"depths": [0.0, math.nan]}, r"depths\[1\] = nan is not finite"),
        ({"depths": "deep"}, "depths = 'deep' must be a sequence of real numbers"),
        ({"depths": None}, "depths = nan is not finite"),
        ({"depths": [1j]}, "depths = "),
        ({"depths": 1e300}, "depths = 1e\\+300 is too large"),
        ({"depths": math.inf}, "depths = inf is not finite"),
        ({"w": [[W, -W]]}, rf"w\[0, 1\] = -{W} must not be negative; give"),
        ({"w": True}, "w = True must be a sequence of real numbers"),
        ({"w": 1e-300}, "w = 1e-300 is too small"),
        ({"gamma1": -1.0}, r"gamma1 = -1.0 must not be negative"),
        ({"stiffness": [1.0, 0.0]}, r"stiffness\[1\] = 0.0 must be positive"),
        ({"stiffness": -1.0}, "stiffness = -1.0 must be positive"),
        ({"w": [W, W], "gamma1": [1.0, 1.0, 1.0]}, r"do not broadcast: .*w \(2,\), gamma1 \(3,\)"),
        ({"scene": "scene"}, "scene = 'scene' is not a Scene"),
    ],
)
def test_bad_input_is_named_with_a_remedy(given, words):
    with pytest.raises(ValueError, match=words):
        minimise_many(**{"scene": SCENE, "depths": 0.0, **given})


def test_no_youngs_angle_is_refused_by_its_place():
    with pytest.raises(ValueError, match=r"w = 0.21 exceeds 2 gamma1 = 0.14 at \[1\]"):
        minimise_many(replace(SCENE, slopes="finite"), 0.0, w=[0.01, 0.21])


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (exact(Parabola(0.02)), "layer.response = 'layer'"),
        (adhesive(Plane()), "has no lowest point"),
        (adhesive(Profile(lambda x: x**4 - x**2, lambda x: 4 * x**3 - 2 * x)), "is not convex"),
        (adhesive(Parabola(0.02), opening=2 * W), "opening = "),
        (replace(SCENE, pattern=Patches([0.0], [1.0, 0.5])), "pattern = "),
        (turned(Profile(np.square, lambda x: 2 * x, convex=True)), "about an axis"),
    ],
)
def test_scenes_that_do_not_vectorise_are_refused_with_a_remedy(scene, words):
    with pytest.raises(ValueError, match=rf"{words}.*use minimise in a loop, or load_path"):
        minimise_many(scene, 0.0)


def test_the_first_state_that_is_lost_is_named():
    x = np.linspace(-5, 5, 11) * L
    known = adhesive(Sampled(x, x**2 / 0.04, kind="smooth"))
    with pytest.raises(ValueError, match=r"^depths\[1, 2\] = .*profile is not known any more"):
        minimise_many(known, [[-DELTA0 / 2] * 3, [0.0, 0.0, 50 * L]])
    sharp = adhesive(Parabola(L / 2), w=0.139, slopes="finite")
    with pytest.raises(ValueError, match=r"^depths\[1\] = .*would turn over"):
        minimise_many(sharp, np.array([10.0, 3.0, 0.0]) * L)


def test_a_state_that_is_no_equilibrium_is_not_returned(monkeypatch):
    from discretization.fitted import many_lines

    monkeypatch.setattr(many_lines, "crossings", lambda off, lo, hi, guess, *_: (lo + hi) / 2)
    with pytest.raises(NotCertifiedError, match=r"depths\[0\] = .*residual"):
        minimise_many(SCENE, DEPTHS)


@pytest.mark.parametrize(
    "body", [Parabola(0.02), Wedge(ALPHA / 2), PowerLaw(40.0, 3), Circle(0.02), FlatPunch(L)]
)
@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_the_force_is_the_derivative_of_the_energy(body, geometry):
    scene = replace(adhesive(body), geometry=geometry)
    depth = np.linspace(0.1, 2, 5) * DELTA0
    step = 1e-4 * DELTA0
    energies = [minimise_many(scene, depth + i * step).energy for i in (-2, -1, 1, 2)]
    rate = (energies[0] - 8 * energies[1] + 8 * energies[2] - energies[3]) / (12 * step)
    force = minimise_many(scene, depth).force
    check(rate, force, 1e-8, np.abs(force).max())
