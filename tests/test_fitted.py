"""The fitted mesh: rounding-level agreement with the closed forms, small and finite slopes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import SHAPES, adhesive, random_case
from scipy.integrate import quad

from discretization import minimise
from discretization.fitted.free_surface import linear
from discretization.fitted.lines import FittedLine, Problem, find_line
from discretization.fitted.quadrature import totals
from discretization.fitted.response import DEGREES, chosen, response
from discretization.fitted.state import certify_lines
from energy import (
    FlatPunch,
    Parabola,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)
from energy.layer import ElasticLayer

QUANTITIES = ("half_width", "force", "energy")


@pytest.mark.parametrize("shape", SHAPES)
def test_ten_digits_over_eight_decades_and_an_honest_estimate(shape):
    rng = np.random.default_rng(100 + SHAPES.index(shape))
    understated = 0
    for _ in range(150):
        case = random_case(rng, shape)
        state = minimise(case.scene, case.depth)
        scales = {"half_width": case.half_width, **state.scales}
        for name in QUANTITIES:
            error = abs(getattr(state, name) - getattr(case, name)) / scales[name]
            assert error <= 1e-10
            assert state.error_estimate[name] >= error / 10
            understated += error > state.error_estimate[name]
        if shape != "flat":
            young = case.scene.surfaces.small_slope_deficit
            assert abs(state.angle_deficit - young) <= 1e-9 * max(young, 1e-3)
    assert understated <= 5


@pytest.mark.parametrize("shape", SHAPES)
def test_lattice_and_fitted_agree_within_the_lattice_error(shape):
    rng = np.random.default_rng(200 + SHAPES.index(shape))
    for _ in range(30):
        case = random_case(rng, shape)
        dx = case.resolved / 100
        fitted = minimise(case.scene, case.depth, method="fitted")
        lattice = minimise(case.scene, case.depth, method="lattice", spacing=dx)
        assert abs(fitted.half_width - lattice.half_width) <= 2 * dx**2 / case.resolved
        assert abs(fitted.force - lattice.force) <= 4e-4 * fitted.scales["force"]
        assert fitted.label == lattice.label


def composed_scene(rng, kind):
    """A convex profile as it is, tilted, or with a shifted parabola on it; with or without w."""
    length, k = 10 ** rng.uniform(-3, 3, 2)
    alpha = 10 ** rng.uniform(-2, 0)
    w = k * (alpha * length) ** 2 / 2 * (rng.random() > 0.2)
    indenter = (
        Parabola(length * 10 ** rng.uniform(0, 2)),
        Wedge(math.atan(alpha * rng.uniform(0.1, 3))),
        FlatPunch(length * 10 ** rng.uniform(-0.5, 1)),
        PowerLaw(alpha * length**-2 * rng.uniform(0.1, 3), 3.0),
    )[kind % 4]
    if kind % 3 == 1:
        indenter = indenter.tilted(rng.uniform(-0.08, 0.08) * alpha)
    if kind % 3 == 2:
        hill = Parabola(length * 20).shifted(rng.uniform(-1, 1) * length)
        indenter = (indenter + hill).shifted(length * 0.3)
    surfaces = SurfaceEnergies.from_work(k * length**2, w)
    return Scene(ElasticLayer(k, 0.0, 1.0), surfaces, indenter), alpha * length * rng.uniform(
        -1.05, 3
    )


def test_composed_profiles_agree_on_both_discretisations():
    rng = np.random.default_rng(4)
    for kind in range(120):
        scene, depth = composed_scene(rng, kind)
        dx = scene.elastocapillary_length / 200
        fitted = minimise(scene, depth, method="fitted")
        lattice = minimise(scene, depth, method="lattice", spacing=dx)
        assert fitted.label == lattice.label
        assert max(fitted.error_estimate.values()) <= 1e-8
        if fitted.contacts.size:
            assert np.abs(fitted.contacts - lattice.contacts).max() <= 0.05 * dx
            assert abs(fitted.force - lattice.force) <= 1e-3 * lattice.scales["force"]


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("change", [1e-5, -1e-5])
def test_the_certificate_rejects_a_line_out_of_place(slopes, change):
    scene = replace(adhesive(Parabola(0.02)), slopes=slopes)
    problem = Problem.of(scene, 1e-3, 0.0, "adhered", chosen(scene.slopes, 1e-8))
    a = find_line(problem, 1, 0.0).x * (1 + change)
    ends = FittedLine(-a, False, False), FittedLine(a, False, False)
    judged = certify_lines(problem, ends, totals(scene, problem.response, 1e-3, -a, a, 1e-8)[1])
    assert judged.failures == ("neighbours",)
    smooth = replace(scene, surfaces=SurfaceEnergies.from_work(scene.gamma1, 0.0))
    problem = Problem.of(smooth, 1e-3, 0.0, "adhered", problem.response)
    a = find_line(problem, 1, 0.0).x * (1 - 1e-5)
    ends = FittedLine(-a, False, False), FittedLine(a, False, False)
    assert (
        "penetration"
        in certify_lines(
            problem, ends, totals(smooth, problem.response, 1e-3, -a, a, 1e-8)[1]
        ).failures
    )


def test_violations_do_not_depend_on_the_unit_of_stress():
    judged = []
    for unit in (1.0, 1e-6, 1e9):
        scene = adhesive(Parabola(0.02), k=130.0 * unit, gamma1=0.07 * unit, w=0.0)
        problem = Problem.of(scene, 1e-3, 0.0, "adhered", chosen(scene.slopes, 1e-8))
        a = find_line(problem, 1, 0.0).x
        near, far = (FittedLine(-a * c, False, False) for c in (0.999, 10.0))
        ends = near, FittedLine(0.999 * a, False, False)
        judged.append(
            certify_lines(
                problem, ends, totals(scene, problem.response, 1e-3, near.x, ends[1].x, 1e-8)[1]
            )
        )
        ends = far, FittedLine(10 * a, False, False)
        judged.append(
            certify_lines(
                problem, ends, totals(scene, problem.response, 1e-3, far.x, ends[1].x, 1e-8)[1]
            )
        )
    for small, wide in zip(judged[2::2], judged[3::2], strict=True):
        assert small.penetration == pytest.approx(judged[0].penetration, rel=1e-9, abs=0)
        assert wide.opening == pytest.approx(judged[1].opening, rel=1e-9, abs=0)
    assert judged[0].penetration > 1e-5
    assert judged[1].opening > 1e-3


def test_springs_without_tension_attach_on_touching_and_let_go_at_the_critical_separation():
    R, d = 0.02, 1.5e-3
    scene = adhesive(Parabola(R), gamma1=0.0)
    k, delta0 = scene.stiffness, scene.critical_separation
    touched = minimise(scene, d)
    assert touched.half_width == pytest.approx(math.sqrt(2 * R * d), rel=1e-13, abs=0)
    assert touched.force == pytest.approx(4 / 3 * k * touched.half_width * d, rel=1e-13, abs=0)
    lowest = minimise(scene, d, branch="global")
    level = cards.contact_line.cut_level(d, k=k, w=scene.work_of_adhesion)
    assert lowest.half_width == pytest.approx(math.sqrt(2 * R * level), rel=1e-13, abs=0)
    punch = adhesive(FlatPunch(0.013), gamma1=0.0)
    assert minimise(punch, -0.999 * delta0).half_width == 0.013
    assert minimise(punch, -1.001 * delta0).label == "detached"


def test_asymmetric_and_rough_profiles_take_their_topology_from_the_lattice():
    scene = adhesive(Parabola(0.02).tilted(0.013))
    shift = 0.013 * 0.02  # x²/2R + sx is the parabola moved by -sR and lowered by s²R/2
    state = minimise(scene, 1e-3)
    plain = minimise(adhesive(Parabola(0.02)), 1e-3 + 0.013**2 * 0.02 / 2)
    assert np.allclose(state.contacts + shift, plain.contacts, rtol=1e-11, atol=0)
    assert state.force == pytest.approx(plain.force, rel=1e-11, abs=0)
    assert state.certificate.ok


def test_samples_of_a_parabola_give_the_parabola():
    """A cubic spline through them is the parabola; quadrature has to stop at its knots."""
    x = np.sort(np.random.default_rng(5).uniform(-0.02, 0.02, 301))
    smooth = minimise(adhesive(Sampled(x, x**2 / 0.04, kind="smooth").shifted(0.002)), 1e-3)
    plain = minimise(adhesive(Parabola(0.02)), 1e-3)
    for name in QUANTITIES:
        assert getattr(smooth, name) == pytest.approx(getattr(plain, name), rel=1e-10, abs=0)


def test_a_profile_with_jumps_of_curvature_is_integrated_to_rounding():
    x = np.linspace(-0.02, 0.02, 41)
    z = np.where(x < 0, x**2 / 0.04, x**2 / 0.02)
    state = minimise(adhesive(Sampled(x, z, kind="smooth").tilted(0.003).shifted(0.001)), 1e-3)
    assert max(state.error_estimate.values()) <= 1e-11
    linear = minimise(adhesive(Sampled(x, z)), 1e-3)
    assert max(linear.error_estimate.values()) <= 1e-11


def test_the_linear_free_surface_converges_spectrally():
    found = [response("small", degree) for degree in DEGREES["small"]]
    errors = [abs(linear(degree).reaction - 1) for degree in (2, 4, 6)]
    assert errors[0] <= 1e-3
    assert errors[1] <= 1e-3 * errors[0]
    assert errors[2] <= 1e-4 * errors[1]
    best = found[-1].surface(1.0)
    assert abs(best.reaction - 1) <= 1e-14
    assert abs(best.slope + 1) <= 1e-13
    assert abs(best.area - 1) <= 1e-14


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_a_response_knows_how_wrong_it_is(slopes):
    for degree in DEGREES[slopes]:
        found = response(slopes, degree)
        for u in (-1.29, -0.4, 1e-4, 0.7, 1.2):
            pull = u * math.sqrt(1 - u * u / 4) if slopes == "finite" else u
            phi = 2 * math.asin(u / 2) if slopes == "finite" else u
            slope = found.surface(u).slope
            read = math.atan(slope) if slopes == "finite" else slope
            assert abs(found.reaction(u) / pull - 1) <= found.error + 2e-12
            assert abs(found.area(u) / pull - 1) <= found.error + 1e-14
            assert abs(read + phi) <= 3 * found.mismatch + 1e-12


def test_the_tolerance_chooses_the_degree():
    for slopes in ("small", "finite"):
        degrees = [chosen(slopes, 10.0**-n).degree for n in range(1, 14)]
        assert degrees == sorted(degrees)
        assert degrees[0] == DEGREES[slopes][0] < degrees[-1]
        assert chosen(slopes, 1e-8).mismatch <= 1e-9


def test_the_steep_free_surface_obeys_its_own_first_integral():
    found = chosen("finite", 1e-8)
    for u in (-1.3, -0.4, 1e-4, 0.7, 1.2, 1.41):
        surface = found.surface(u)
        phi = 2 * math.asin(u / 2)
        assert abs(surface.reaction - math.sin(phi)) <= 1e-12 * abs(u)
        assert abs(surface.reaction - found.reaction(u)) <= 1e-12 * abs(u)
        assert abs(math.atan(surface.slope) + phi) <= 1e-9
        energy = cards.finite.tail_energy(u, k=1.0, gamma1=1.0)
        assert surface.energy == pytest.approx(energy, rel=1e-9, abs=0)
        assert found.energy(u) == pytest.approx(energy, rel=1e-9, abs=0)
        heights = abs(u) * np.array([0.9, 0.6, 0.3])
        x = cards.finite.meniscus(heights, u_a=abs(u), k=1.0, gamma1=1.0)
        assert np.abs(np.abs(surface.displacement(x)) - heights).max() <= 1e-8


def steep_scene(rng, shape):
    """Finite slopes: w/γ₁ up to 0.8, tan f' up to 1, depth from the card at a random width."""
    length = 10.0 ** rng.uniform(-4, 4)
    k, gamma1 = 3.7 / length, 3.7 * length
    w = gamma1 * 10 ** rng.uniform(-3, -0.1)
    a = length * 10 ** rng.uniform(-1, 1)
    rise = rng.uniform(0.02, 1.0)
    indenter = {
        "wedge": lambda: Wedge(math.atan(rise)),
        "parabola": lambda: Parabola(a / rise),
        "power": lambda: PowerLaw(rise / (3 * a**2), 3.0),
    }[shape]()
    scene = Scene(
        ElasticLayer(k, 0.0, 1.0), SurfaceEnergies.from_work(gamma1, w), indenter, "finite"
    )
    f, f1 = float(indenter.height(a)), float(indenter.slope(a))
    return scene, a, float(cards.finite.depth(f, f1, k=k, gamma1=gamma1, w=w))


@pytest.mark.parametrize("shape", ["wedge", "parabola", "power"])
def test_young_s_law_emerges_at_finite_slopes(shape):
    rng = np.random.default_rng(len(shape))
    for _ in range(40):
        scene, a, depth = steep_scene(rng, shape)
        k, gamma1, w, f = scene.stiffness, scene.gamma1, scene.work_of_adhesion, scene.indenter
        if depth < 0 and minimise(scene, depth).label == "detached":
            continue  # a wedge lets go before its line reaches such a width
        state = minimise(scene, depth)
        assert state.half_width == pytest.approx(a, rel=1e-9, abs=0)
        assert abs(state.contact_angle - scene.surfaces.contact_angle) <= 1e-9
        u = depth - float(f.height(a))
        force = 2 * k * quad(lambda x: depth - float(f.height(x)), 0, a, epsrel=1e-12)[0]  # noqa: B023
        force += cards.finite.surface_force(u, k=k, gamma1=gamma1)
        assert abs(state.force - force) <= 1e-9 * state.scales["force"]

        def density(x):
            g, arc = depth - float(f.height(x)), math.hypot(1, float(f.slope(x)))  # noqa: B023
            return k / 2 * g**2 + (gamma1 - w) * arc - gamma1  # noqa: B023

        energy = 2 * quad(density, 0, a, epsrel=1e-12)[0]
        energy += 2 * cards.finite.tail_energy(u, k=k, gamma1=gamma1)
        assert abs(state.energy - energy) <= 1e-9 * state.scales["energy"]


def test_flat_punch_lets_go_at_the_critical_separation_at_any_slope():
    for ratio in (1e-3, 0.3, 0.9, 0.99):
        gamma1, a = 0.07, 0.03
        scene = replace(adhesive(FlatPunch(a), gamma1=gamma1, w=ratio * gamma1), slopes="finite")
        d_c = -scene.critical_separation
        state = minimise(scene, d_c)
        assert state.label == "neutral"
        surface = state.force - 2 * scene.stiffness * a * d_c
        card = cards.finite.punch_surface_force_at_detachment(gamma1=gamma1, w=ratio * gamma1)
        assert surface == pytest.approx(-card, rel=1e-9, abs=0)
        assert minimise(scene, d_c * (1 + 1e-9)).label == "detached"
        assert minimise(scene, d_c * (1 - 1e-9)).label == "metastable"


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-8, 1e-12])
def test_a_flat_punch_is_neutral_in_any_units_and_nowhere_beside(slopes, rtol):
    """The critical depth from two formulas that round differently; 10⁻¹³ of it is decided."""
    rng = np.random.default_rng(11)
    labels, beside = [], []
    for _ in range(60):
        unit, k, ratio = 10 ** rng.uniform([-9, -6, -6], [9, 6, -0.05])
        gamma1 = k * unit**2 * 10 ** rng.uniform(-3, 3)
        surfaces = SurfaceEnergies.from_work(gamma1, ratio * gamma1)
        layer = ElasticLayer(k * unit, rng.uniform(0, 0.4), unit)
        scene = Scene(layer, surfaces, FlatPunch(unit * rng.uniform(0.1, 9)), slopes=slopes)
        w = scene.work_of_adhesion
        for d in (scene.critical_separation, math.sqrt(2 * w * layer.h / layer.modulus)):
            labels.append(minimise(scene, -d, rtol=rtol).label)
        if rtol <= 1e-8:
            beside += [minimise(scene, -d * (1 + s * 1e-13), rtol=rtol).label for s in (1, -1)]
    assert set(labels) == {"neutral"}
    assert set(beside[::2]) <= {"detached"} and set(beside[1::2]) <= {"metastable"}


def test_finite_slopes_tend_to_small_slopes_in_first_order_of_w():
    ratios, differences = np.array([1e-2, 1e-3, 1e-4, 1e-5]), []
    for ratio in ratios:
        small = adhesive(Wedge(0.5 * math.sqrt(2 * ratio)), w=ratio * 0.07)
        states = [minimise(replace(small, slopes=s), 0.0) for s in ("small", "finite")]
        differences.append(abs(states[1].half_width / states[0].half_width - 1))
    order = np.polyfit(np.log(ratios), np.log(differences), 1)[0]
    assert order == pytest.approx(1.0, abs=0.05)
    assert differences[-1] <= ratios[-1]


def test_an_overhanging_surface_is_refused_with_an_explanation():
    scene = replace(adhesive(FlatPunch(0.03), gamma1=0.07, w=0.1), slopes="finite")
    with pytest.raises(ValueError, match=r"depth = .* at the contact line x = .* turn over"):
        minimise(scene, -1.5 * scene.elastocapillary_length)
    near = minimise(scene, -1.41 * scene.elastocapillary_length)
    assert near.certificate.ok
    assert near.angle_deficit == pytest.approx(2 * math.asin(1.41 / 2), rel=1e-8, abs=0)


def test_finite_slopes_of_profiles_that_are_not_convex():
    ripple, q = 2e-5, 2 * math.pi / 0.004
    body = Profile(
        lambda x: x**2 / 0.04 + ripple * (1 - np.cos(q * x)),
        lambda x: x / 0.02 + ripple * q * np.sin(q * x),
    )
    for w in (0.002, 0.02):
        scene = replace(adhesive(body, w=w), slopes="finite")
        for depth in (0.0, 5e-3):
            state = minimise(scene, depth)
            coarse = minimise(scene, depth, method="lattice", spacing=1e-5)
            assert abs(state.contact_angle - scene.surfaces.contact_angle) <= 1e-9
            for name in ("half_width", "force", "energy"):
                change = abs(getattr(state, name) - getattr(coarse, name))
                scale = coarse.scales.get(name, coarse.half_width)
                assert change <= coarse.error_estimate[name] * scale


def test_without_tension_there_is_nothing_to_incline():
    scene = adhesive(Parabola(0.02), gamma1=0.0, w=0.0)
    for method in ({}, {"method": "lattice", "spacing": 1e-6}):
        small = minimise(scene, 1e-3, **method)
        finite = minimise(replace(scene, slopes="finite"), 1e-3, **method)
        assert finite.force == small.force and finite.half_width == small.half_width


def test_near_turning_over_a_state_is_found_or_refused_in_plain_words():
    def scene(w):
        return Scene(
            ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work(1.0, w), Wedge(0.1), "finite"
        )

    # the line's search meets a surface that stands upright to rounding
    upright = minimise(scene(1.0), 0.2 - math.sqrt(2))
    assert upright.contact_angle == pytest.approx(math.pi / 2, rel=1e-7, abs=0)
    with pytest.raises(ValueError, match="turn over and is no graph"):
        minimise(scene(1.3), 0.1)
