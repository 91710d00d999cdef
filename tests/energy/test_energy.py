"""Layer, surfaces, indenters, scene: formulas, composition, refusals."""

import dataclasses
import math

import numpy as np
import pytest
from support.example_scenes import adhesive

from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Parabola,
    Patches,
    Plane,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
    terms,
)
from energy.validity import Deformation, assumptions

LAYER = ElasticLayer(4.2e3, 0.41, 3e-4)
SURFACES = SurfaceEnergies(0.04, 0.03, 0.065)


def test_layer_and_surface_formulas():
    E = 4.2e3
    nu = 0.41
    h = 3e-4
    lame = E * nu / ((1 + nu) * (1 - 2 * nu))
    shear = E / (2 * (1 + nu))
    assert LAYER.modulus == pytest.approx(lame + 2 * shear, rel=1e-14, abs=0)
    assert LAYER.stiffness == pytest.approx((lame + 2 * shear) / h, rel=1e-14, abs=0)
    w = SURFACES.work_of_adhesion
    assert w == pytest.approx(0.005, rel=1e-12, abs=0)
    assert abs(0.065 + 0.04 * math.cos(SURFACES.contact_angle) - 0.03) <= 1e-16  # Eq. (8)
    assert SURFACES.small_slope_deficit == pytest.approx(math.sqrt(2 * w / 0.04), rel=1e-14, abs=0)
    scene = Scene(LAYER, SURFACES, Parabola(0.01))
    given = {"rel": 1e-14, "abs": 0}
    length = cards.tail.elastocapillary_length(LAYER.stiffness, 0.04)
    assert scene.elastocapillary_length == pytest.approx(length, **given)
    delta0 = cards.plane.critical_separation(LAYER.stiffness, w)
    assert scene.critical_separation == pytest.approx(delta0, **given)
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.slopes = "finite"


def test_contact_angle_without_and_with_little_adhesion():
    """No adhesion means a smooth surface and little keeps its digits."""
    s = SurfaceEnergies(0.07, 0.03, 0.1)  # Eq. (34), a sum that vanishes to rounding only
    assert (s.work_of_adhesion, s.contact_angle) == (0, math.pi)
    assert SurfaceEnergies.from_work(0.07, 1e-30).work_of_adhesion == 1e-30
    s = SurfaceEnergies.from_work(0.3, 3e-19)
    assert s.angle_deficit == pytest.approx(math.sqrt(2e-18), rel=1e-13, abs=0)
    assert SurfaceEnergies.from_work(0.3, 0.6).contact_angle == pytest.approx(0, abs=1e-7)


SHAPES = [
    Plane(),
    FlatPunch(0.7),
    Wedge(0.2),
    Parabola(3.0),
    Circle(1.3),
    PowerLaw(0.4, 2.6),
    Sampled(np.linspace(-1, 1, 41), np.cos(3 * np.linspace(-1, 1, 41))),
    Sampled(np.linspace(-1, 1, 41), np.cos(3 * np.linspace(-1, 1, 41)), kind="smooth"),
    Profile(lambda x: np.cosh(x), lambda x: np.sinh(x)),
    Parabola(3.0).shifted(0.31).tilted(-0.2) + Wedge(0.1).shifted(-0.2),
]


@pytest.mark.parametrize("indenter", SHAPES, ids=lambda i: type(i).__name__)
def test_slope_is_the_derivative_of_height(indenter):
    x = np.array([-0.537, -0.213, 0.117, 0.389, 0.633])
    step = 1e-5
    difference = (indenter.height(x + step) - indenter.height(x - step)) / (2 * step)
    assert np.allclose(indenter.slope(x), difference, rtol=0, atol=1e-8)


@pytest.mark.parametrize("indenter", SHAPES, ids=lambda i: type(i).__name__)
def test_height_and_slope_are_those_of_each_alone(indenter):
    """Bit for bit, of arrays and of single places, also where there is no profile."""
    for x in (np.linspace(-1.4, 1.2, 27).reshape(9, 3), 0.3, -5.0):
        height, slope = indenter.height_and_slope(x)
        assert np.array_equal(height, indenter.height(x), equal_nan=True)
        assert np.array_equal(slope, indenter.slope(x), equal_nan=True)
        assert np.shape(height) == np.shape(slope) == np.shape(x)


def test_smooth_samples_converge_to_the_function():
    counts = (41, 81, 161, 321)
    at = np.linspace(-1, 2, 5001)
    errors = []
    for n in counts:
        x = np.linspace(-1, 2, n)
        s = Sampled(x, np.sin(3 * x), kind="smooth")
        errors.append(np.abs(s.height(at) - np.sin(3 * at)).max())
        assert np.array_equal(s.height(x[1:-1]), s.z[1:-1])
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] <= -3.8
    assert errors[-1] <= 1e-7


def test_composition_keeps_track_of_apex_corners_and_walls():
    punch = FlatPunch(2.0).shifted(0.5)
    both = Wedge(0.1) + Parabola(2.0)
    assert punch.extent == punch.walls == (-1.5, 2.5)
    assert punch.tilted(0.1).apex is None
    assert punch.height(2.5) == 0
    assert np.isinf(punch.height(2.6))
    assert np.isnan(punch.slope(2.6))
    assert both.apex == 0
    assert both.symmetric
    assert list(both.corners) == [0.0]
    rough = Sampled([-3.0, 0.0, 3.0], [0.1, 0.0, 0.1]) + FlatPunch(2.0)
    assert rough.extent == rough.walls == (-2.0, 2.0)
    assert Wedge(0.1).shifted(0.4).apex == 0.4
    assert (FlatPunch(2.0) + FlatPunch(1.0)).walls == (-1.0, 1.0)
    lopsided = Sampled([-1.0, 0.0, 2.0], [1.0, 0.0, 1.0])
    assert (lopsided + Parabola(1.0)).apex == 0
    assert not (lopsided + Parabola(1.0)).symmetric
    assert not lopsided.shifted(1.0).symmetric


def test_densities_and_their_derivatives():
    s = np.array([-2.0, -0.3, 0.0, 0.05, 1.7])
    step = 1e-5
    for slopes in terms.SLOPES:
        below = terms.surface(s - step, gamma1=0.3, slopes=slopes)
        here = terms.surface(s, gamma1=0.3, slopes=slopes)
        above = terms.surface(s + step, gamma1=0.3, slopes=slopes)
        first = (above.value - below.value) / (2 * step)
        assert np.allclose(first, here.first, rtol=0, atol=1e-9)
        second = (above.first - below.first) / (2 * step)
        assert np.allclose(second, here.second, rtol=0, atol=1e-9)
    tiny = np.array([1e-9])
    small = terms.surface(tiny, gamma1=0.3, slopes="small").value
    finite = terms.surface(tiny, gamma1=0.3, slopes="finite").value
    assert finite == pytest.approx(small, rel=1e-15, abs=0)
    flat = terms.contact(0.0, gamma1=0.3, w=0.1)
    assert flat == terms.contact(0.0, gamma1=0.3, w=0.1, slopes="finite") == -0.1


def test_the_assumptions_that_a_state_makes():
    def report(*deformed, surfaces=SURFACES):
        scene = Scene(LAYER, surfaces, Parabola(0.01))
        found = assumptions(scene, Deformation(*deformed))
        return {one.name: one for one in found}

    found = report(1e-6, 1e-6, 1e-2, 0.05)
    assert found["d/h"].holds
    assert found["h/a"].holds
    assert found["h/a"].value == pytest.approx(0.03, rel=1e-14, abs=0)
    assert not found["2w/γ₁"].holds
    assert "VIOLATED" in str(found["2w/γ₁"])
    assert not report(1e-6, 1e-6, 1e-4, 0.5)["slope"].holds
    assert report(0.0, 0.0, 0.0, 0.0)["h/a"].value == math.inf
    assert found["(h/a)²/(1-2ν)"].value == pytest.approx(0.03**2 / 0.18, rel=1e-12, abs=0)
    dry = SurfaceEnergies.from_work(0.0, 0.0)
    assert report(1e-6, 1e-6, 1e-2, 0.05, surfaces=dry)["2w/γ₁"].value == 0


X = [0.0, 1.0, 2.0, 3.0]
OTHER = SurfaceEnergies.from_work(0.05, 0.01)
REFUSED = [
    (lambda: ElasticLayer(-1.0, 0.3, 1.0), "E = -1.0"),
    (lambda: ElasticLayer(math.nan, 0.3, 1.0), "E = nan"),
    (lambda: ElasticLayer(1.0, 0.5, 1.0), "nu = 0.5"),
    (lambda: ElasticLayer(1.0, -1.0, 1.0), "nu = -1.0"),
    (lambda: ElasticLayer(1.0, 0.3, 0.0), "h = 0.0"),
    (lambda: ElasticLayer("1 kPa", 0.3, 1.0), "E = '1 kPa'"),
    (lambda: ElasticLayer("1000", 0.3, 1.0), "E = '1000'"),
    (lambda: SurfaceEnergies(-0.1, 0.1, 0.0), "gamma1 = -0.1"),
    (lambda: SurfaceEnergies(0.1, 0.1, 0.3), "gamma12 = 0.3"),
    (lambda: SurfaceEnergies.from_work(0.1, -0.2), "w = -0.2"),
    (lambda: SurfaceEnergies.from_work(0.1, 0.3).contact_angle, "w = 0.3"),
    (lambda: SurfaceEnergies.from_work(0.0, 0.3).small_slope_deficit, "gamma1 = 0"),
    (lambda: FlatPunch(0.0), "half_width = 0.0"),
    (lambda: Wedge(0.0), "delta = 0.0"),
    (lambda: Wedge(math.pi / 2), "delta"),
    (lambda: Parabola(math.inf), "R = inf"),
    (lambda: PowerLaw(1.0, 0.5), "n = 0.5"),
    (lambda: PowerLaw(-1.0, 2.0), "c = -1.0"),
    (lambda: Sampled(X[::-1], X), "sort the samples"),
    (lambda: Sampled(X, [0.0, 1.0, math.nan, 2.0]), "z[2] = nan"),
    (lambda: Sampled(X, X[:-1]), "shapes"),
    (lambda: Sampled(X[:2], X[:2], kind="smooth"), "at least 3"),
    (lambda: Sampled(X, X, kind="wavy"), "'linear', 'smooth'"),
    (lambda: Profile(1.0, np.sin), "height = 1.0"),
    (lambda: Profile(np.cos, np.sin, extent=(1, -1)), "extent"),
    (lambda: Profile(np.cos, np.sin, corners=(1.0, 0.0)), "corners"),
    (lambda: Profile(np.cos, np.sin, knots=(1.0, 0.0)), "knots = (1.0, 0.0)"),
    (lambda: Profile(np.cos, np.sin, knots=((0.0, 1.0),)), "knots"),
    (lambda: Profile(np.cos, np.sin, knots=(0.0, math.nan)), "knots"),
    (lambda: Parabola(1.0).shifted(math.nan), "x0 = nan"),
    (lambda: FlatPunch(1.0) + FlatPunch(1.0).shifted(3.0), "no common points"),
    (lambda: Scene(LAYER, SURFACES, "sphere"), "indenter = 'sphere'"),
    (lambda: Scene(SURFACES, LAYER, Plane()), "layer"),
    (lambda: Scene(LAYER, SURFACES, Plane(), slopes="large"), "'small', 'finite'"),
    (lambda: Scene(LAYER, SURFACES, Plane(), geometry="round"), "'round' is unknown; choose one"),
    (lambda: Patches([1.0, 0.0], [1, 1, 1]), "sort them"),
    (lambda: Patches([0.0], [1.0]), "one more than"),
    (lambda: Patches([0.0], [1.0, -1.0]), "not negative"),
    (lambda: Patches([math.nan], [1.0, 1.0]), "finite numbers"),
    (lambda: Scene(LAYER, SURFACES, Plane(), pattern=3.0), "must be Patches"),
    (lambda: adhesive(Plane(), w=0.002, opening=0.001), "must have the gamma1"),
    (lambda: Scene(LAYER, SURFACES, Plane(), opening=OTHER), "must have the gamma1"),
    (lambda: adhesive(Plane(), gamma1=1.0, w=2.1, slopes="finite"), "exceeds 2 gamma1"),
    (lambda: adhesive(Plane(), gamma1=1.0, opening=2.1, slopes="finite"), "w = 2.1 exceeds 2 gam"),
]


@pytest.mark.parametrize(("build", "says"), REFUSED, ids=[says for _, says in REFUSED])
def test_bad_input_is_refused_with_name_value_and_remedy(build, says):
    with pytest.raises(ValueError) as error:  # noqa: PT011 (the message is what is tested)
        build()
    assert says in str(error.value)
    assert len(str(error.value)) > len(says) + 15


EPSILON = float(np.finfo(float).eps)


def turned(off=0.0, height=np.square, end=1.0, pattern=None):
    """A scene about an axis, with a profile that is mirrored but for `off`.

    Its height is height(x) from -1 to 1 and constant from there to `end`, and `off` is added
    where x > 1/2.
    """

    def f(x):
        return height(np.minimum(x, 1.0)) + off * (x > 0.5)

    body = Profile(f, lambda x: 2 * x, (-1.0, end))
    return Scene(LAYER, SURFACES, body, pattern=pattern, geometry="axisymmetric")


# What is made, of a number that is just accepted, or of one that just is not, and what is said.
LIMITS = [
    (lambda n: SurfaceEnergies(1.0, 1.0, 2 * (1 + n * EPSILON)), 4, 5, "exceeds gamma1"),
    (lambda large: ElasticLayer(large, 0.3, 1.0), 0.9e60, 1.1e60, "too large"),
    (lambda small: ElasticLayer(1.0, 0.3, small), 1.1e-60, 0.9e-60, "too small"),
    (lambda off: turned(off), 0.9e-12, 1.1e-12, "differ"),
    (lambda n: turned(n * EPSILON, np.ones_like), 8, 9, "differ"),
    (lambda off: turned(end=1 + off), 1.9e-12, 2.1e-12, "extent"),
    (lambda off: turned(pattern=Patches([-1.0, 1 + off], [1, 0, 1])), 0.9e-12, 1.1e-12, "mirror"),
]


@pytest.mark.parametrize(("make", "inside", "outside", "says"), LIMITS)
def test_tolerances_inside_and_outside(make, inside, outside, says):
    """Just inside a tolerance is accepted and just outside refused."""
    assert make(inside)
    with pytest.raises(ValueError, match=says):
        make(outside)


@pytest.mark.parametrize(("share", "convex"), [(0.9, True), (1.1, False)])
def test_samples_are_convex_to_1e_12_of_their_steepest_slope(share, convex):
    slopes = np.array([-1.0, 0.0, -share * 1e-12, 1.0])
    heights = np.append(0.0, slopes.cumsum())
    assert Sampled(np.arange(5.0), heights).convex == convex


@pytest.mark.parametrize(("depth", "holds"), [(0.0999, True), (0.1001, False)])
def test_much_less_is_a_tenth(depth, holds):
    scene = Scene(ElasticLayer(1.0, 0.3, 1.0), SURFACES, Parabola(1.0))
    found = assumptions(scene, Deformation(depth, depth, 1.0, 0.0))
    assert {one.name: one.holds for one in found}["d/h"] == holds


def sampled(kind):
    """Thirty random heights at random positions."""
    rng = np.random.default_rng(5)
    return Sampled(np.sort(rng.uniform(-1, 1, 30)), rng.normal(size=30), kind)


@pytest.mark.parametrize(
    "body", [sampled("linear"), sampled("smooth"), *SHAPES], ids=lambda i: type(i).__name__
)
def test_one_position_is_the_same_as_many(body):
    ends = [x for x in body.extent if math.isfinite(x)]
    anywhere = np.random.default_rng(6).uniform(-1.2, 1.2, 200)
    positions = np.concatenate([ends, body.corners, anywhere])
    for function in (body.height, body.slope):
        many = function(positions)
        single = np.array([function(position) for position in positions.tolist()])
        inside = np.isfinite(many)
        assert np.array_equal(inside, np.isfinite(single))
        largest = np.abs(many[inside]).max()
        assert np.abs(many[inside] - single[inside]).max() <= 1e-13 * largest


def test_sampled_profile_convexity_and_lowest_point():
    """A sampled profile knows whether it is convex and where it is lowest."""
    x = np.linspace(-1, 1.5, 41)
    for kind in ("linear", "smooth"):
        parabola = Sampled(x, (x - 0.23) ** 2, kind)
        assert parabola.convex
        assert parabola.apex == pytest.approx(0.23, abs=1e-12 if kind == "smooth" else 0.04)
        bump = Sampled(x, (x - 0.23) ** 2 + 0.05 * np.cos(9 * x), kind)
        assert not bump.convex
        assert bump.apex is None
    few = np.linspace(-1, 1.5, 12)
    assert Sampled(few, few**2 + 0.3 * few**3, "smooth").apex == pytest.approx(0, abs=1e-13)
    bent = np.linspace(-1, 0.01, 11)  # -x³ is not convex beyond 0, in the last interval
    assert not Sampled(bent, -(bent**3), "smooth").convex
    falling = Sampled(x, -x, "smooth")
    assert falling.convex
    assert falling.apex == 1.5


def test_stripes_widths_and_strong_middle():
    """Stripes are as wide as they say with the strong one in the middle."""
    stripes = Patches.stripes(2.0, 0.3, 0.9, 7.0)
    weak = [-1.4, -0.6, 0.6, 1.4]
    assert (stripes.factor(weak) == 0.3).all()
    strong = [-0.4, 0.0, 0.4, 1.6]
    assert (stripes.factor(strong) == 0.9).all()
    assert max(np.abs(stripes.edges)) >= 5.5


@pytest.mark.parametrize("side", [-1, 1])
def test_slopes_beside_a_corner_are_those_of_its_sides(side):
    t = math.tan(0.3)
    bent = Sampled([-2.0, -0.5, 1.0, 3.0], [1.0, 0.0, 0.5, 3.0])
    known = {
        Wedge(0.3): (0.0, side * t),
        Wedge(0.3).shifted(1e6): (1e6, side * t),
        Wedge(0.3).shifted(-1e-6).tilted(0.1): (-1e-6, side * t + 0.1),
        Wedge(0.3) + Parabola(2.0).shifted(3.0): (0.0, side * t - 1.5),
        FlatPunch(2.0): (2.0, 0.0),
        bent.shifted(0.1): (1.1, 1 / 3 if side < 0 else 1.25),
    }
    for body, (x, slope) in known.items():
        own = -1 if isinstance(body, FlatPunch) else side
        assert float(body.slope_beside(x, own)) == pytest.approx(slope, rel=1e-12, abs=1e-12)
        assert body.slope_beside(np.array([x, x]), np.array([own, own])).shape == (2,)
