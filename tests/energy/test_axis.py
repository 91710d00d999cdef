"""Rotational symmetry of a scene: which profiles and patterns it takes, and the true arc."""

import numpy as np
import pytest

from discretization import minimise
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
)
from energy.description import described, rebuilt

LAYER = ElasticLayer(2.5e3, 0.3, 5e-6)
SURFACES = SurfaceEnergies.from_work(0.07, 6e-3)
X = np.linspace(-3e-4, 3e-4, 41)
R = X[20:] - X[20]


def turned(indenter, **more):
    return Scene(LAYER, SURFACES, indenter, geometry="axisymmetric", **more)


SYMMETRIC = [
    FlatPunch(1e-4),
    Wedge(0.2),
    Parabola(0.02),
    PowerLaw(3.0, 1.5),
    Circle(0.02),
    Parabola(0.02) + Wedge(0.1),
    Parabola(0.02).shifted(0.0).tilted(0.0),
    Sampled(X, X**2),
    Sampled(X, 7e-3 + np.cos(2e4 * X) * 1e-7 + X**2, kind="smooth"),
    Profile(lambda x: 1e-4 * np.cosh(x / 1e-3), lambda x: 0.1 * np.sinh(x / 1e-3)),
    Profile(np.square, lambda x: 2 * x, extent=(-1e-3, 1e-3)),
]


@pytest.mark.parametrize("indenter", SYMMETRIC, ids=lambda i: type(i).__name__)
def test_a_symmetric_profile_is_turned_as_it_is(indenter):
    scene = turned(indenter)
    assert scene.axisymmetric
    assert scene.opened.axisymmetric
    assert scene.indenter is indenter
    assert not Scene(LAYER, SURFACES, indenter).axisymmetric


def test_smooth_samples_are_no_less_symmetric_for_their_height():
    x = np.linspace(-20, 20, 41)
    r = np.linspace(0, 20, 777)
    own = Sampled(x, x**2 / 2**40, kind="smooth")
    raised = Sampled(x, 1.0 + x**2 / 2**40, kind="smooth")  # the same digits
    assert np.abs(raised.slope(r) - own.slope(r)).max() <= 1e-14 * np.abs(own.slope(r)).max()
    assert np.abs(raised.height(r) - raised.height(-r)).max() <= 2 * np.finfo(float).eps


REFUSED = [
    (body, r"must be mirror-symmetric about 0 or begin there; rem")
    for body in (
        Parabola(0.02).tilted(1e-8),
        FlatPunch(1e-4).tilted(1e-3),
        Parabola(0.02).shifted(1e-13),
        Circle(0.02).shifted(1e-4),
        FlatPunch(1e-4).shifted(1e-6),
        Wedge(0.1) + Parabola(0.02).shifted(1e-5),
        Sampled(X, X**2 + 1e-9 * np.sin(1e4 * X)),
        Sampled(X[1:], X[1:] ** 2),
        Sampled(R + 1e-5, R**2),
        Profile(np.exp, np.exp),
        Profile(np.square, lambda x: 2 * x, extent=(-1e-3, np.inf)),
        # Nothing beyond a place on the right alone; and nothing beyond one on each side.
        Profile(lambda x: np.where(np.asarray(x) > 1e-3, np.inf, np.square(x)), lambda x: 2 * x),
        Profile(
            lambda x: np.where(np.abs(x) > 1e-3, np.inf, np.square(x) + x),
            lambda x: 2 * x + 1,
            extent=(-2e-3, 2e-3),
        ),
    )
]


@pytest.mark.parametrize(
    ("indenter", "told"), [*REFUSED, (Plane(), r"no radius .*; use FlatPunch\(half_width\)")]
)
def test_turned_profile_not_mirrored_or_endless_raises(indenter, told):
    """A profile that is not its mirror image or has no end is refused."""
    with pytest.raises(ValueError, match=told):
        turned(indenter)


@pytest.mark.parametrize("kind", ["linear", "smooth"])
def test_samples_from_the_axis_on_are_mirrored(kind):
    scene = turned(Sampled(R, 2e-9 + R**2 / 0.04, kind=kind))
    both = scene.indenter
    assert (both.x == -both.x[::-1]).all()
    assert both.kind == kind
    assert both.extent == (-R[-1], R[-1])
    assert np.allclose(both.height(R), both.height(-R), rtol=1e-15, atol=0)
    assert both.height(0.0) == 2e-9
    assert kind == "linear" or both.slope(0.0) == both.apex == 0
    again = rebuilt(described(scene))
    assert (again.indenter.z == both.z).all()
    assert again.axisymmetric


def test_a_function_from_the_axis_on_is_mirrored():
    def height(x):
        assert (np.asarray(x) >= 0).all(), "outside the extent"
        return 0.1 * x + x**3

    knots = (2e-4,)
    corners = (1e-4, 3e-4)
    half = Profile(height, lambda x: 0.1 + 3 * x**2, (0.0, 1e-3), corners, True, knots)
    both = turned(half).indenter
    assert both.height(-2e-4) == both.height(2e-4) == height(2e-4)
    assert both.slope(-2e-4) == -both.slope(2e-4) == -0.1 - 3 * 2e-4**2
    assert list(both.corners) == [-3e-4, -1e-4, 0.0, 1e-4, 3e-4]
    assert list(both.knots) == [-2e-4, 0.0, 2e-4]
    assert both.extent == (-1e-3, 1e-3)
    assert both.walls == ()
    assert both.convex
    assert both.symmetric
    assert both.apex == 0
    dimple = turned(Profile(lambda x: x * x - 1e-4 * x, lambda x: 2 * x - 1e-4, (0.0, 1.0)))
    assert not dimple.indenter.convex
    assert dimple.indenter.apex is None
    assert turned(half + FlatPunch(2e-4)).indenter.walls == (-2e-4, 2e-4)


def test_a_pattern_is_one_of_rings():
    over_r = Patches([1e-4, 2e-4], [1, 0.5, 1])
    both = Patches([-1e-4, 1e-4], [0.5, 1, 0.5])
    for pattern in (over_r, both, Patches.stripes(1e-4, 0, 1, 4e-4), Patches([], [0.5])):
        assert turned(Parabola(0.02), pattern=pattern).pattern is pattern
    for pattern in (Patches([-1e-4, 2e-4], [1, 0, 1]), Patches([-1e-4, 1e-4], [1, 0, 0.5])):
        with pytest.raises(ValueError, match=r"not mirror-symmetric about 0; .* r >= 0 only"):
            turned(Parabola(0.02), pattern=pattern)


def test_the_circle_is_an_arc():
    circle = Circle(0.02)
    x = np.array([-0.02, -0.0199, -3e-3, 0.0, 1e-9, 0.01, 0.02])
    f = circle.height(x)
    assert np.allclose(x**2 + (0.02 - f) ** 2, 0.02**2, rtol=1e-14, atol=0)
    assert f[4] == pytest.approx(1e-18 / 0.04, rel=1e-14, abs=0)
    inner = x[1:-1]
    assert np.allclose(circle.slope(inner) * (0.02 - f[1:-1]), inner, rtol=1e-13, atol=0)
    assert circle.slope(0.02) == -circle.slope(-0.02) == np.inf
    assert np.isinf(circle.height(0.021))
    assert np.isnan(circle.slope(0.021))
    assert circle.height(0.01) == f[5]
    assert circle.shifted(0.3).apex == 0.3


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("radius", [3e-6, 2e-5, 2e-2])
def test_the_line_on_an_arc_is_where_theory_puts_it(slopes, radius):
    circle = Circle(radius)
    scene = Scene(LAYER, SURFACES, circle, slopes=slopes)
    card = cards.finite.depth if slopes == "finite" else cards.contact_line.depth
    args = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    for d in (-1e-7, 2e-6):
        a = minimise(scene, d).half_width
        depth = card(float(circle.height(a)), float(circle.slope(a)), **args)
        assert depth == pytest.approx(d, rel=0, abs=1e-12 * radius)


def test_a_contact_that_would_climb_above_the_equator_is_refused():
    circle = Circle(3e-6)
    for method in ({}, {"method": "lattice", "spacing": 1e-7}):
        with pytest.raises(ValueError, match="depth = 4e-05"):
            minimise(Scene(LAYER, SURFACES, circle, slopes="finite"), 4e-5, **method)
    state = minimise(Scene(LAYER, SURFACES, circle), 4e-4)  # small slopes never get there
    assert 0.999 < state.half_width / circle.R < 1


@pytest.mark.parametrize("tension", [1e-40, 1e-28, 1e-20])
def test_a_tension_that_does_nothing_leaves_independent_springs(tension):
    """Its l is 1e-20 of the contact's radius, beside which the elements of a tail vanish."""
    surfaces = SurfaceEnergies.from_work(tension, 0.0)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, Parabola(10.0), geometry="axisymmetric")
    state = minimise(scene, 0.1)
    assert state.radius == pytest.approx(np.sqrt(2.0), rel=1e-9)
    assert state.force == pytest.approx(0.1 * np.pi, rel=1e-9)
