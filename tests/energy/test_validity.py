"""How far the assumptions of the model hold, and what the exact layer says of the springs."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from support.example_scenes import DELTA0, L, adhesive, plain, rough, roughness, turned, two

from discretization import load_path, minimise
from energy import ElasticLayer, FlatPunch, Parabola, Plane, Sampled, Scene, SurfaceEnergies
from energy.layer import second_order
from energy.validity import assumptions, compliance_error, springs_error
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
    unit = ElasticLayer(1.0, nu, 1.0).modulus
    h = 5e-6
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
        assert "pull-off" not in told
        assert told.endswith("; use response='layer'")


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


def test_validity_of_a_detached_layer():
    """A detached layer is not strained but its free surface is judged."""
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
    assert len(widths) == 2
    assert widths[0] > 1.1 * widths[1]
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
    inside = 0.15 * DELTA0 * np.pi / (2 * L)
    beside = 5 * DELTA0 / L
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


NOISY = "noise slope/√(2w/γ₁)"


def waved(pieces, noise=0.0, *, wave=2 * math.pi / 3, height=0.03, R=15.0, seed=0, kind="linear"):
    """x²/(2R) and waves on (-9, 9), measured with white noise of this rms."""
    x = np.linspace(-9, 9, pieces + 1)
    z = x**2 / (2 * R) + height * np.cos(2 * math.pi * x / wave)
    return Sampled(x, z + noise * np.random.default_rng(seed).normal(size=x.size), kind=kind)


def noise_of(scene):
    """What is said of its samples, whatever the state."""
    (found,) = [one for one in assumptions(scene, None) if one.name == NOISY]
    return found


@pytest.mark.parametrize("kind", ["linear", "smooth"])
@pytest.mark.parametrize(
    ("pieces", "noise", "given"),
    [
        (400, 1e-3, {}),
        (1000, 1e-3, {}),
        (4000, 3e-4, {}),
        (250, 1.5e-3, {"height": 0.0}),
        (700, 6e-4, {"height": 0.01, "wave": 0.7}),
        (2500, 5e-4, {"R": 2.0, "height": 0.2, "wave": 3.0}),
    ],
)
def test_noise_that_holds_lines_is_measured_and_warned_of(pieces, noise, given, kind):
    """Its rms slope √2 σ/Δx over √(2w/γ₁) = 0.2, as well as a quartile of a few hundred tells."""
    for seed in range(3):
        found = noise_of(plain(waved(pieces, noise, seed=seed, kind=kind, **given)))
        share = math.sqrt(2) * noise / (18 / pieces) / 0.2
        assert found.value == pytest.approx(share, rel=1 / 3, abs=0)
        assert not found.holds
        assert "the samples' noise decides where lines rest: filter the profile" in str(found)


def test_states_and_paths_say_that_noise_decides():
    noisy = plain(waved(400, 1e-3))
    smooth = plain(waved(400))
    nodes = {"method": "lattice", "spacing": 0.045}
    for scene, wrong in ((noisy, True), (smooth, False)):
        path = load_path(scene, depths=[0.0, 0.05], **nodes)
        state = minimise(scene, 0.05, **nodes)
        for shown in (path, state):
            assert NOISY in {one.name for one in shown.validity}
            assert any(NOISY in warning for warning in shown.warnings) == wrong
            assert ("filter the profile" in str(shown)) == wrong
        note = path.plot(si=False).get_supxlabel()
        assert (NOISY in note) == wrong


@pytest.mark.parametrize("wrap", [
    lambda body: body.shifted(0.31),
    lambda body: body.tilted(0.02),
    lambda body: (body + FlatPunch(8.0)).shifted(0.1),
    lambda body: Parabola(20.0) + body.tilted(0.01),
])  # fmt: skip
def test_noise_is_known_of_what_is_made_of_samples(wrap):
    body = waved(400, 1e-3)
    own = noise_of(plain(body))
    made = noise_of(plain(wrap(body)))
    assert made.value == pytest.approx(own.value, rel=1e-9, abs=0)
    both = noise_of(plain(body + waved(400, 1e-3, seed=5)))
    assert both.value > 1.2 * own.value
    assert NOISY not in measures(minimise(plain(Parabola(15.0)), 0.1))


@pytest.mark.parametrize("kind", ["linear", "smooth"])
@pytest.mark.parametrize(("length", "stress"), [(1.0, 1.0), (1e-9, 1e6), (1e5, 1e-3)])
def test_noise_about_an_axis_and_in_any_units(kind, length, stress):
    r = np.linspace(0, 9, 301)
    for noise, wrong in ((1e-3, True), (0.0, False)):
        z = r**2 / 30 + noise * np.random.default_rng(2).normal(size=r.size)
        scene = plain(Sampled(length * r, length * z, kind=kind), length=length, stress=stress)
        found = noise_of(replace(scene, geometry="axisymmetric"))
        unit = noise_of(plain(Sampled(r, z, kind=kind)))
        assert found.holds != wrong
        if wrong:
            assert found.value == pytest.approx(unit.value, rel=0.3, abs=0)  # of both halves


X = np.linspace(-9.0, 9.0, 721)
STEP = X[1] - X[0]
TEETH = 2.0 * STEP * np.abs((X / STEP) % 12 - 6) / 6
PILLARS = np.repeat(np.random.default_rng(3).uniform(1, 2, 361), 2)[:721]
RESOLVED = {
    "parabola": X**2 / 30,
    "sharp parabola": 5 * X**2,
    "eight samples a wave": X**2 / 30
    + 0.3 / (2 * math.pi / (8 * STEP)) * np.cos(2 * math.pi * X / (8 * STEP) + 0.4),
    "rough": X**2 / 30 + 0.1 * roughness(721, 300, 8, seed=4),
    "wedge": np.abs(X),
    "facets": np.maximum.reduce([s * X - s**2 * 7 for s in np.linspace(-1, 1, 15)]),
    "teeth": X**2 / 30 + TEETH,
    "corners of teeth alone": STEP * (np.arange(721) % 2) + X**2 / 30,
    "pillars": np.where(np.arange(721) % 4 < 2, 3.0, 3.0 - PILLARS * STEP),
    "level": np.zeros(721),
}


@pytest.mark.parametrize("kind", ["linear", "smooth"])
@pytest.mark.parametrize("name", RESOLVED)
def test_noise_of_resolved_profiles_is_not_reported(name, kind):
    """Profiles that their samples resolve are not called noisy."""
    for w in (0.02, 2e-3):
        assert noise_of(plain(Sampled(X, RESOLVED[name], kind=kind), w=w)).holds
    uneven = X + 0.3 * STEP * np.sin(1.7 * np.arange(721))
    curve = Sampled(uneven, uneven**2 / 30 + 0.05 * np.cos(uneven), kind)
    assert noise_of(plain(curve)).holds


def test_a_few_corners_are_a_body_whatever_their_heights():
    rng = np.random.default_rng(7)
    for n in (5, 12, 39):
        x = np.sort(rng.uniform(-5, 5, n))
        body = Sampled(x, x**2 / 10 + rng.uniform(0, 0.5, n))
        assert noise_of(plain(body)).value == 0
    assert noise_of(turned(Sampled([0.0, 0.01, 0.02], [0.0, 0.001, 0.004]))).value == 0


def test_noise_of_a_part_of_the_samples_is_found():
    """Outer parts of two thirds are filled in with straight lines."""
    x = np.linspace(-9, 9, 3001)
    noise = 1e-3 * np.random.default_rng(0).normal(size=x.size)
    body = Sampled(x, np.where(np.abs(x) < 3, x**2 / 30 + noise, np.abs(x) - 2.7))
    assert not noise_of(plain(body)).holds


def test_without_an_angle_no_noise_is_judged():
    body = waved(400, 1e-3)
    for scene in (plain(body, w=0.0), plain(body, gamma1=0.0)):
        assert NOISY not in {one.name for one in assumptions(scene, None)}
    opened = replace(plain(body, w=0.0), opening=SurfaceEnergies.from_work(1.0, 0.02))
    assert noise_of(opened).value == noise_of(plain(body)).value
