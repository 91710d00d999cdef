"""The layer by itself: its kernel, its poles, its effective length, and what is refused."""

import math
from dataclasses import replace
from decimal import Decimal, localcontext
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from support.bonded_layers import GEOMETRIES, layer, scene_of

from discretization import load_path, minimise
from discretization.layer.poles import poles
from energy import ElasticLayer, Parabola, Patches, Plane, Profile, Scene, SurfaceEnergies
from energy.validity import assumptions

RATIOS = (-0.9, -0.4, 0.0, 0.25, 0.3, 0.4, 0.45, 0.49, 0.4999, 0.5)
DIGITS = 120
HALVINGS = 12


def exponential(matrix):
    """By its series, of a small part, squared; of numbers with as many digits as wanted."""
    part = matrix / Decimal(2**HALVINGS)
    term = found = np.array([[Decimal(i == j) for j in range(4)] for i in range(4)])
    for n in range(1, 60):
        term = term.dot(part) / Decimal(n)
        found = found + term
    for _ in range(HALVINGS):
        found = found.dot(found)
    return found


def through_the_thickness(nu, q):
    """k h/G from displacements and stresses on their way up through the layer, at 120 digits.

    u = U sin qx, v = V cos qx and the stresses T sin qx, S cos qx on planes y = const obey four
    linear equations in y; at the base U = V = 0, on the surface T = 0.
    """
    with localcontext() as context:
        context.prec = DIGITS
        nu = Decimal(nu)
        q = Decimal(q)
        one = Decimal(1)
        tied = nu / (1 - nu)
        rates = [
            [0, q, one, 0],
            [-tied * q, 0, 0, (1 - 2 * nu) / (2 * (1 - nu))],
            [2 * q * q / (1 - nu), 0, 0, tied * q],
            [0, 0, -q, 0],
        ]
        m = exponential(np.array([[Decimal(x) for x in row] for row in rates]))
        shear = -m[2][3]
        normal = m[2][2]  # at the base, so that T = 0 on the surface
        v = m[1][2] * shear + m[1][3] * normal
        return float((m[3][2] * shear + m[3][3] * normal) / v)


@pytest.mark.parametrize("nu", RATIOS)
def test_kernel_against_elasticity_through_the_thickness(nu):
    """The kernel is that of linear elasticity through the thickness."""
    q = [1e-9, 1e-5, 1e-3, 0.03, 0.3, 0.79, 0.81, 1.0, 2.5, 7.0, 20.0, 45.0]
    expected = np.array([through_the_thickness(nu, x) for x in q])
    stress = 3.1e4
    unit = 2e-3
    found = layer(nu, stress=stress, unit=unit).stiffness_at(np.array(q) / unit) * unit / stress
    loss = 1e-13 if nu < 0.499 else 2e-12  # 1 - 2ν has lost digits that q = 0 depends on
    assert np.abs(found / expected - 1).max() <= (1e-13 if nu == 0.5 else loss)


@pytest.mark.parametrize("nu", RATIOS)
def test_the_kernel_at_both_ends(nu):
    body = layer(nu, stress=7e3, unit=0.3)
    q = np.array([1e3, 1e8, 1e60])
    assert np.allclose(body.stiffness_at(q), 7e3 * q / (1 - nu), rtol=1e-14, atol=0)
    if nu < 0.5:
        still = [body.stiffness_at(0.0), body.stiffness_at(1e-12)]
        assert np.allclose(still, body.stiffness, rtol=1e-13, atol=0)
    else:
        assert body.stiffness_at(0.0) == np.inf == body.stiffness
        small = np.array([1e-60, 1e-6, 1e-3]) / 0.3
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
    gamma = 10 ** rng.uniform(-4, 4)
    tolerance = 10 ** rng.uniform(-9, -2)
    found = poles(layer(nu), gamma, tolerance)
    q = 10 ** rng.uniform(-4, 9, 4000)
    exact = layer(nu).stiffness_at(q)
    s = q[:, None] ** 2
    k = found.still + found.flow / (s[:, 0] + found.first) + (s / (s + found.tau) @ found.c).real
    off = np.abs(k - exact) / (exact + gamma * q * q)
    assert off.max() <= tolerance
    mu = (found.decays**2)[:, None]
    flow = found.flow / (found.first - mu)
    parts = ((found.still + flow) / mu, -gamma, found.c / (mu - found.tau))
    rates = (
        (found.still + flow) / mu**2 - flow / (found.first - mu) / mu,
        found.c / (mu - found.tau) ** 2,
    )
    left = sum(np.sum(part + 0 * mu, axis=1) for part in parts)
    rate = sum(np.sum(part + 0 * mu, axis=1) for part in rates)
    assert (np.abs(left) <= 1e-9 * np.abs(rate * mu[:, 0])).all()  # a step of Newton's method
    assert (found.decays.real > 0).all()


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.45, 0.499])
@pytest.mark.parametrize("gamma", [1e-3, 0.5, 40.0])
def test_the_effective_length_is_its_integral(nu, gamma):
    body = layer(nu, unit=3e-5)
    unit = 3e-5
    k = layer(nu).stiffness

    def density(q):
        return math.log((float(layer(nu).stiffness_at(q)) + gamma * q * q) / k) / q**2

    ends = [1e-3, 0.1, 1.0, 10.0, 1e3, np.inf]
    parts = [quad(density, *pair, epsrel=1e-10, limit=200)[0] for pair in pairwise(ends)]
    c2 = nu * (4 * nu - 1) / (3 * (1 - nu) * (1 - 2 * nu))
    expected = (sum(parts) + 1e-3 * (gamma / k - c2)) / math.pi
    scene = Scene(body, SurfaceEnergies.from_work(gamma * unit, 0.0), Parabola(1.0))
    size = abs(expected) + math.sqrt(gamma / k)
    assert abs(scene.effective_length / unit - expected) <= 1e-5 * size


def test_the_effective_length_of_springs_and_beside_tension():
    for response in ("springs", "layer"):
        scene = scene_of(Parabola(1.0), 0.3, 1e9, response=response)
        assert scene.effective_length == pytest.approx(
            scene.elastocapillary_length, rel=1e-4, abs=0
        )
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
    "slopes": ({"slopes": "finite"}, r"slopes = 'finite'"),
    "tension": ({"surfaces": SurfaceEnergies.from_work(0.0, 0.1)}, r"gamma1 = 0"),
    "pattern": ({"pattern": Patches([1.0], [1.0, 2.0])}, r"pattern = Patches"),
    "bumps": ({"indenter": Profile(hills, lambda x: -0.1 * np.sin(x))}, r"Profile\(.*not convex"),
    "tilted": ({"indenter": Parabola(9.0).tilted(0.1)}, r"indenter = .*not mirror-symmetric"),
    "plane": ({"indenter": Plane()}, r"indenter = Plane\(\) has no lowest point"),
}
NODES = {"method": "lattice", "spacing": 0.1}
ASKED = {
    "state": lambda scene: minimise(scene, 0.1),
    "nodes": lambda scene: minimise(scene, 0.1, **NODES),
    "path": lambda scene: load_path(scene, depths=[0.0, 0.1]),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("asked", ASKED)
def test_scenes_that_only_springs_answer(name, asked):
    change, match = REFUSED[name]
    scene = replace(scene_of(Parabola(9.0)), **change)
    with pytest.raises(ValueError, match=f"{match}.*response = 'layer' supports.*'springs'"):
        ASKED[asked](scene)


def test_questions_that_only_springs_answer():
    scene = scene_of(Parabola(9.0))
    for given in ({}, NODES, NODES | {"method": "shortest_path"}):
        with pytest.raises(ValueError, match=r"branch = 'global'.*response='springs'"):
            minimise(scene, 0.1, branch="global", **given)
    with pytest.raises(ValueError, match=r"method = 'lattice'.*method='fitted'"):
        load_path(scene, depths=[0.0, 0.1], **NODES)
    hysteretic = scene_of(Parabola(9.0), opening=0.02)
    for given in ({}, NODES):
        with pytest.raises(ValueError, match=r"opening = .*load_path"):
            minimise(hysteretic, 0.1, **given)
    with pytest.raises(ValueError, match=r"spacing = 0\.1"):
        minimise(scene, 0.1, spacing=0.1)
    with pytest.raises(ValueError, match=r"spacing = None"):
        minimise(scene, 0.1, method="lattice")


def test_a_contact_beyond_the_known_profile():
    half = {"extent": (0, 1), "convex": True}
    body = Profile(lambda r: np.square(r) / 9, lambda r: 2 * np.asarray(r) / 9, **half)
    scene = scene_of(body, geometry="axisymmetric")
    for ask in (minimise, lambda scene, depth: load_path(scene, depths=[0.0, depth])):
        with pytest.raises(ValueError, match=r"depth = .* profile is not known.*smaller depth"):
            ask(scene, 3.0)
    with pytest.raises(ValueError, match=r"depth = .* whole known profile"):
        minimise(scene, 3.0, **NODES)
    with pytest.raises(ValueError, match=r"depth = "):
        minimise(scene_of(Parabola(1e25)), 3.0)


def test_a_contact_too_wide_for_nodes():
    body = Parabola(1e4)
    scene = scene_of(body, nu=0.5, gamma=0.05, w=1e-4, geometry="axisymmetric")
    with pytest.raises(ValueError, match=r"times as wide as .*use method='fitted'"):
        minimise(scene, 0.05, method="lattice", spacing=2.0)


def test_validity_of_the_layer_asks_how_far_a_line_lifts_it():
    for geometry in GEOMETRIES:
        state = minimise(scene_of(Parabola(40.0), 0.3, geometry=geometry), 0.03, rtol=1e-4)
        found = {item.name: item for item in state.validity}
        assert not {"h/a", "h/l", "|c₂|(h/l)²", "(h/a)²/(1-2ν)"} & set(found)
        assert {"d/h", "u/h", "δ₀/h", "slope", "2w/γ₁"} == set(found)
        scene = state.scene
        item = found["δ₀/h"]
        least = 0.005 * scene.gamma1 * (scene.layer.h / scene.elastocapillary_length) ** 2
        assert item.holds == (scene.work_of_adhesion <= least)
        assert item.value / item.limit == pytest.approx(
            math.sqrt(scene.work_of_adhesion / least), rel=1e-12
        )
        torn = replace(scene, opening=SurfaceEnergies.from_work(scene.gamma1, 0.04))
        (lifted,) = (a for a in assumptions(torn, state._deformation) if a.name == "δ₀/h")
        assert lifted.value == pytest.approx(2 * item.value, rel=1e-12)  # that of opening
