"""The layer by itself: its kernel, its poles, its effective length, and what is refused."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from layers import GEOMETRIES, layer, scene_of
from scipy.integrate import quad

from discretization import load_path, minimise
from discretization.layer.poles import poles, stiffness
from energy import (
    ElasticLayer,
    Parabola,
    Patches,
    Plane,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
)

RATIOS = (-0.9, -0.4, 0.0, 0.25, 0.3, 0.4, 0.45, 0.49, 0.4999, 0.5)
DIGITS = 120


def product(one, other):
    return [[sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*other, strict=True)] for row in one]


def exponential(matrix):
    """By its series, of a small part, squared."""
    halvings, size = 12, len(matrix)
    part = [[x / 2**halvings for x in row] for row in matrix]
    found = [[Decimal(i == j) for j in range(size)] for i in range(size)]
    term = found
    for n in range(1, 60):
        term = [[x / n for x in row] for row in product(term, part)]
        found = [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(found, term, strict=True)]
    for _ in range(halvings):
        found = product(found, found)
    return found


def through_the_thickness(nu, q):
    """k h/G from displacements and stresses on their way up through the layer, at 120 digits.

    u = U sin qx, v = V cos qx and the stresses T sin qx, S cos qx on planes y = const obey four
    linear equations in y; at the base U = V = 0, on the surface T = 0.
    """
    with localcontext() as context:
        context.prec = DIGITS
        nu, q, one = Decimal(nu), Decimal(q), Decimal(1)
        tied = nu / (1 - nu)
        rates = [
            [0, q, one, 0],
            [-tied * q, 0, 0, (1 - 2 * nu) / (2 * (1 - nu))],
            [2 * q * q / (1 - nu), 0, 0, tied * q],
            [0, 0, -q, 0],
        ]
        m = exponential([[Decimal(x) for x in row] for row in rates])
        shear, normal = -m[2][3], m[2][2]  # at the base, so that T = 0 on the surface
        v = m[1][2] * shear + m[1][3] * normal
        return float((m[3][2] * shear + m[3][3] * normal) / v)


@pytest.mark.parametrize("nu", RATIOS)
def test_the_kernel_is_that_of_linear_elasticity_through_the_thickness(nu):
    q = [1e-9, 1e-5, 1e-3, 0.03, 0.3, 0.79, 0.81, 1.0, 2.5, 7.0, 20.0, 45.0]
    expected = np.array([through_the_thickness(nu, x) for x in q])
    stress, unit = 3.1e4, 2e-3
    found = layer(nu, stress=stress, unit=unit).stiffness_at(np.array(q) / unit) * unit / stress
    loss = 1e-13 if nu < 0.499 else 2e-12  # 1 - 2ν has lost digits that q = 0 depends on
    assert np.abs(found / expected - 1).max() <= (1e-13 if nu == 0.5 else loss)


@pytest.mark.parametrize("nu", RATIOS)
def test_the_kernel_at_both_ends(nu):
    body = layer(nu, stress=7e3, unit=0.3)
    q = np.array([1e3, 1e8, 1e300])
    assert np.allclose(body.stiffness_at(q), 7e3 * q / (1 - nu), rtol=1e-14, atol=0)
    if nu < 0.5:
        still = [body.stiffness_at(0.0), body.stiffness_at(1e-12)]
        assert np.allclose(still, body.stiffness, rtol=1e-13, atol=0)
    else:
        assert body.stiffness_at(0.0) == np.inf == body.stiffness
        small = np.array([1e-150, 1e-6, 1e-3]) / 0.3
        flow = 7e3 / 0.3 * (3 / (small * 0.3) ** 2 + 27 / 5)
        assert np.allclose(body.stiffness_at(small), flow, rtol=1e-12, atol=0)
    assert body.stiffness_at(np.ones((2, 3))).shape == (2, 3)


def test_springs_have_one_stiffness():
    springs = layer(0.3, response="springs")
    assert (springs.stiffness_at(np.array([0.0, 1.0, 1e9])) == springs.stiffness).all()


@pytest.mark.parametrize("seed", range(12))
def test_poles_are_good_to_their_tolerance(seed):
    rng = np.random.default_rng(seed)
    nu = float(rng.choice([0.5, rng.uniform(-0.9, 0.5), 0.5 - 10 ** rng.uniform(-4, -1)]))
    gamma, tolerance = 10 ** rng.uniform(-4, 4), 10 ** rng.uniform(-9, -2)
    found = poles(nu, gamma, tolerance)
    q = 10 ** rng.uniform(-4, 9, 4000)
    exact = layer(nu).stiffness_at(q)
    off = np.abs(stiffness(found, q * q) - exact) / (exact + gamma * q * q)
    assert off.max() <= tolerance
    s = -(found.decays**2)[:, None]
    parts = np.concatenate([found.c * s / (s + found.tau), found.flow / s, 0 * s + found.still], 1)
    left = parts.sum(axis=1) + gamma * s[:, 0]
    size = np.abs(parts).sum(axis=1) + np.abs(gamma * s[:, 0])
    assert (np.abs(left) <= 1e-8 * size).all() and (found.decays.real > 0).all()


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.45, 0.499])
@pytest.mark.parametrize("gamma", [1e-3, 0.5, 40.0])
def test_the_effective_length_is_its_integral(nu, gamma):
    body, unit = layer(nu, unit=3e-5), 3e-5
    k = layer(nu).stiffness

    def density(q):
        return math.log((float(layer(nu).stiffness_at(q)) + gamma * q * q) / k) / q**2

    ends = [1e-3, 0.1, 1.0, 10.0, 1e3, np.inf]
    parts = [quad(density, *pair, epsrel=1e-10, limit=200)[0] for pair in zip(ends, ends[1:], strict=False)]
    c2 = nu * (4 * nu - 1) / (3 * (1 - nu) * (1 - 2 * nu))
    expected = (sum(parts) + 1e-3 * (gamma / k - c2)) / math.pi
    scene = Scene(body, SurfaceEnergies.from_work(gamma * unit, 0.0), Parabola(1.0))
    size = abs(expected) + math.sqrt(gamma / k)
    assert abs(scene.effective_length / unit - expected) <= 1e-5 * size


def test_the_effective_length_of_springs_and_beside_tension():
    for response in ("springs", "layer"):
        scene = scene_of(Parabola(1.0), 0.3, 1e9, response=response)
        assert scene.effective_length == pytest.approx(scene.elastocapillary_length, rel=1e-4, abs=0)
    lengths = {0.0: 0.18, 0.3: 0.12, 0.4: -0.11, 0.45: -0.55}
    for nu, expected in lengths.items():
        assert abs(scene_of(Parabola(1.0), nu, 1e-12).effective_length - expected) <= 0.006
    with pytest.raises(ValueError, match=r"nu = 0\.5.*smaller Poisson"):
        _ = scene_of(Parabola(1.0), 0.5).effective_length


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"nu": 0.51}, r"nu = 0\.51 is outside \(-1, 0\.5\]; give"),
        ({"nu": -1.0}, r"nu = -1\.0 is outside"),
        ({"nu": 0.5, "response": "springs"}, r"nu = 0\.5 .*response='layer'"),
        ({"nu": math.nan}, "nu = nan"),
        ({"response": "Layer"}, r"response = 'Layer'.*'springs'.*'layer'"),
        ({"response": None}, r"response = None"),
        ({"h": math.inf}, r"h = inf.*half-space.*much larger than the contact"),
        ({"h": 0.0}, r"h = 0\.0"),
        ({"E": -1.0}, r"E = -1\.0"),
    ],
)
def test_layers_that_are_none(given, match):
    with pytest.raises(ValueError, match=match):
        ElasticLayer(**({"E": 1.0, "nu": 0.3, "h": 1.0, "response": "layer"} | given))


def hills(x):
    return 0.1 * np.cos(np.asarray(x))


REFUSED = {
    "slopes": (scene_of(Parabola(9.0)), {"slopes": "finite"}, r"slopes = 'finite'"),
    "tension": (scene_of(Parabola(9.0), gamma=0.0), {}, r"gamma1 = 0"),
    "pattern": (scene_of(Parabola(9.0)), {"pattern": Patches([1.0], [1.0, 2.0])}, r"pattern = Patches"),
    "bumps": (scene_of(Profile(hills, lambda x: -0.1 * np.sin(x))), {}, r"indenter = Profile"),
    "tilted": (scene_of(Parabola(9.0).tilted(0.1)), {}, r"indenter = .*mirror"),
    "plane": (scene_of(Plane()), {}, r"indenter = Plane"),
}
