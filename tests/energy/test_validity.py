"""How far the assumptions of the model hold, and what the exact layer says of the springs."""

import itertools
import math

import numpy as np
import pytest
from scenes import DELTA0, L, adhesive, rough, two
from scipy.integrate import quad

from discretization import minimise
from energy import ElasticLayer, FlatPunch, Parabola, Plane, Sampled, Scene, SurfaceEnergies
from energy.layer import second_order
from energy.validity import compliance_error, springs_error
from studies.scenes import run
from studies.verify import scenes as checks


def stiffness(nu, q):
    """k(q)/k of a bonded layer of h = 1, which tests/layer holds against linear elasticity."""
    layer = ElasticLayer(1.0, nu, 1.0, response="layer")
    return float(layer.stiffness_at(q)) / layer.stiffness


def compliance(nu, ratio):
    """u(0)/F of the free surface under a line load over 1/(2kl), for ratio = l/h."""

    def density(q):
        return 1 / (stiffness(nu, q) + (q * ratio) ** 2)

    cuts = [0, 0.3 / ratio, 1, 3, 8.0, math.inf]
    parts = [quad(density, a, b, epsrel=1e-9)[0] for a, b in itertools.pairwise(cuts)]
    return 2 * ratio / math.pi * sum(parts)


def film(nu, ratio, gamma1=0.07, **options):
    """A scene with l/h = ratio."""
    unit, h = ElasticLayer(1.0, nu, 1.0).modulus, 5e-6
    layer = ElasticLayer(gamma1 / (ratio**2 * h * unit), nu, h)
    return Scene(layer, SurfaceEnergies.from_work(gamma1, 6e-5), Parabola(0.02), **options)


def measures(state):
    return {one.name: one for one in state.validity}


@pytest.mark.parametrize(
    ("nu", "ratio", "percent"),
    [
        *((0.45, r, p) for r, p in ((0.35, 25), (1, 15), (2, 7.8), (5, 2.3), (10, 0.8))),
        *((0.3, r, p) for r, p in ((0.35, -9), (1, -0.5), (2, 0.1))),
        *((0.49, r, p) for r, p in ((2, 30), (5, 11), (10, 4))),
    ],
)
def test_the_error_that_is_told_is_that_of_the_exact_layer(nu, ratio, percent):
    exact = 100 * (compliance(nu, ratio) - 1)
    assert exact == pytest.approx(percent, rel=0.05, abs=0.051)
    assert 100 * compliance_error(nu, 1 / ratio) == pytest.approx(exact, rel=0, abs=2e-3)
    for one in measures(minimise(film(nu, ratio), 0.0)).values():
        if one.name in ("h/l", "|c₂|(h/l)²"):
            assert f"is off by {abs(exact):.2g} %" in one.consequence


def test_springs_say_what_the_layer_would_change():
    """The entries of the table are held in the test of the study that computes them."""
    told = measures(minimise(film(0.45, 0.5), 0.0))["h/l"].consequence
    assert "force at pull-off by up to 6.9 %, its radius there by up to 11 %" in told
    assert told.endswith("; use response='layer'")
    between = [springs_error(0.465, ratio) for ratio in (0.5, 0.7, 1.0)]
    assert between[0] == pytest.approx((9.45, 15.5), rel=1e-9)
    assert between[0] > between[1] > between[2]
    for outside in (film(-0.2, 0.5), film(0.3, 0.2)):
        told = measures(minimise(outside, 0.0))["h/l"].consequence
        assert "pull-off" not in told and told.endswith("; use response='layer'")


@pytest.mark.parametrize("nu", [-0.5, 0.3, 0.45, 0.49])
def test_c2_is_the_second_order_of_the_exact_layer(nu):
    assert (1 - stiffness(nu, 1e-2)) / 1e-4 == pytest.approx(second_order(nu), rel=5e-3, abs=0)
    far = 100.0
    half = second_order(nu) / (2 * far**2)
    assert compliance(nu, far) - 1 == pytest.approx(half, rel=0.1, abs=0)


def test_without_tension_no_free_surface_is_judged():
    names = set(measures(minimise(adhesive(Parabola(0.02), gamma1=0.0), DELTA0)))
    assert "u/h" in names
    assert not names & {"h/l", "|c₂|(h/l)²"}


def test_a_detached_layer_is_not_strained_but_its_free_surface_is_judged():
    thick = film(0.45, 0.35)
    state = minimise(thick, -1.0)
    assert state.label == "detached"
    assert set(measures(state)) == {"2w/γ₁", "h/l", "|c₂|(h/l)²"}
    assert [text.split(" = ")[0] for text in state.warnings] == ["|c₂|(h/l)²", "h/l"]
    assert "VIOLATED" in run.summary(run.Record(None, (minimise(thick, 0.0),)))
    assert "violated: |c₂|(h/l)², h/l" in run.row(state)


@pytest.mark.parametrize("lift", [0.01, -0.03])
def test_depth_is_measured_from_first_touch(lift):
    x = np.linspace(-8 * L, 8 * L, 401)
    for d in (0.5 * DELTA0, -0.1 * DELTA0):
        body = Sampled(x, x**2 / 0.04 + lift, kind="smooth")
        found = measures(minimise(adhesive(body), d + lift))
        assert found["d/h"].value == pytest.approx(abs(d) / 0.03, rel=1e-9, abs=0)
    tilted = adhesive(Parabola(0.02).tilted(0.3))
    bottom = -(0.3**2) * 0.02 / 2
    found = measures(minimise(tilted, bottom + DELTA0))
    assert found["d/h"].value == pytest.approx(DELTA0 / 0.03, rel=1e-3, abs=0)


def test_thickness_is_measured_against_the_narrowest_contact():
    state = minimise(adhesive(two(6 * L)), 0.3 * DELTA0)
    widths = np.diff(state.contacts)[:, 0]
    assert len(widths) == 2 and widths[0] > 1.1 * widths[1]
    assert measures(state)["h/a"].value == pytest.approx(0.06 / widths[1], rel=1e-12, abs=0)
    layers = measures(minimise(rough(3), 0.5 * DELTA0))
    assert layers["h/a"].value > 0.03 / (10 * L)


def dent(half_width, height, punch):
    """A flat punch with a dent of this half-width and height in its middle."""
    x = np.linspace(-punch, punch, 801)
    z = np.where(np.abs(x) < half_width, height / 2 * (1 + np.cos(np.pi * x / half_width)), 0.0)
    return adhesive(Sampled(x, z, kind="smooth") + FlatPunch(punch))


def test_displacement_and_slopes_are_the_largest_anywhere():
    pressed = minimise(adhesive(Parabola(0.02)), 3 * DELTA0)
    assert measures(pressed)["u/h"].value == pytest.approx(3 * DELTA0 / 0.03, rel=1e-12, abs=0)
    inside, beside = 0.15 * DELTA0 * np.pi / (2 * L), 5 * DELTA0 / L
    for wide, depth, name, value, rel in (
        (4 * L, -0.1 * DELTA0, "u/h", 0.4 * DELTA0 / 0.03, 1e-4),
        (2 * L, 5 * DELTA0, "slope", beside, 1e-6),
        (2 * L, 0.0, "slope", inside, 1e-3),
    ):
        state = minimise(dent(wide, 0.3 * DELTA0, 5 * L), depth)
        assert len(state.contacts) == 1
        assert measures(state)[name].value == pytest.approx(value, rel=rel, abs=0)


def test_an_endless_contact_is_judged():
    flat = measures(minimise(adhesive(Plane()), 0.5 * DELTA0))
    assert flat["u/h"].value == flat["d/h"].value == pytest.approx(0.5 * DELTA0 / 0.03)
    assert flat["h/a"].value == 0


def test_the_scenes_of_checks_are_inside_the_model():
    for scene in (checks.gel(checks.PARABOLA), checks.gel(checks.WEDGE)):
        assert minimise(scene, 0.0).warnings == ()
