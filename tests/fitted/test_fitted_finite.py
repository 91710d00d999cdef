"""Finite slopes on the fitted mesh: Young's law (8), and where there is no surface."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import L, adhesive, plain, rippled, steep

from discretization import minimise
from discretization.equilibrium import QUANTITIES
from energy import FlatPunch, Parabola, Wedge, cards
from studies.shared.random_cases import random_steep_case


def test_flat_punch_lets_go_at_the_critical_separation_at_any_slope():
    for ratio in (1e-3, 0.3, 0.9, 0.99):
        scene, a = steep(FlatPunch(0.03), ratio), 0.03
        gamma1, d_c = scene.gamma1, -scene.critical_separation
        state = minimise(scene, d_c)
        assert state.label == "neutral"
        surface = state.force - 2 * scene.stiffness * a * d_c
        card = cards.finite.punch_surface_force_at_detachment(gamma1=gamma1, w=ratio * gamma1)
        assert surface == pytest.approx(-card, rel=1e-12, abs=0)
        assert minimise(scene, d_c * (1 + 1e-9)).label == "detached"
        assert minimise(scene, d_c * (1 - 1e-9)).label == "metastable"


@pytest.mark.parametrize("options", [{}, {"method": "lattice", "spacing": L / 50}])
def test_finite_slopes_tend_to_small_slopes_in_first_order_of_w(options):
    ratios, differences = np.array([1e-2, 1e-3, 1e-4, 1e-5]), []
    for ratio in ratios:
        scene = steep(Wedge(0.5 * math.sqrt(2 * ratio)), ratio)
        small, finite = (
            minimise(replace(scene, slopes=s), 0.0, **options) for s in ("small", "finite")
        )
        differences.append([abs(getattr(finite, q) / getattr(small, q) - 1) for q in QUANTITIES])
    for column in np.transpose(differences):
        order = np.polyfit(np.log(ratios), np.log(column), 1)[0]
        assert order == pytest.approx(1.0, abs=0.05)
    assert np.max(differences[-1]) <= ratios[-1]


def test_an_overhanging_surface_is_refused_with_an_explanation():
    scene = steep(FlatPunch(0.03), 0.1 / 0.07)
    with pytest.raises(ValueError, match=r"depth = .* at the contact line x = .* turn over"):
        minimise(scene, -1.5 * scene.elastocapillary_length)
    near = minimise(scene, -1.41 * scene.elastocapillary_length)
    assert near.certificate.ok
    assert near.angle_deficit == pytest.approx(2 * math.asin(1.41 / 2), rel=1e-10, abs=0)


@pytest.mark.slow
def test_finite_slopes_of_profiles_that_are_not_convex():
    for w, depth in ((0.002, 0.0), (0.02, 5e-3)):
        scene = adhesive(rippled(0.02, 0.004, 2e-5), w=w, slopes="finite")
        state = minimise(scene, depth)
        coarse = minimise(scene, depth, method="lattice", spacing=4e-5)
        assert abs(state.contact_angle - scene.surfaces.contact_angle) <= 1e-9
        for name in QUANTITIES:
            change = abs(getattr(state, name) - getattr(coarse, name))
            scale = coarse.scales.get(name, coarse.half_width)
            assert change <= coarse.error_estimate[name] * scale


def test_without_tension_there_is_nothing_to_incline():
    scene = adhesive(Parabola(0.02), gamma1=0.0, w=0.0)
    for method in ({}, {"method": "lattice", "spacing": 1e-6}):
        small = minimise(scene, 1e-3, **method)
        finite = minimise(replace(scene, slopes="finite"), 1e-3, **method)
        assert finite.force == small.force and finite.half_width == small.half_width


@pytest.mark.parametrize("shape", ["wedge", "parabola", "power"])
def test_young_s_law_emerges_at_finite_slopes(shape):
    rng, held = np.random.default_rng(len(shape)), 0
    for _ in range(40):
        case = random_steep_case(rng, shape)
        state = minimise(case.scene, case.depth)
        if case.depth < 0 and state.label == "detached":
            continue  # a wedge lets go before its line reaches such a width
        held += 1
        scales = {"half_width": case.half_width, **state.scales}
        for name in QUANTITIES:
            assert abs(getattr(state, name) - getattr(case, name)) <= 1e-11 * scales[name]
        assert abs(state.contact_angle - case.scene.surfaces.contact_angle) <= 1e-9
    assert held >= 20


def test_near_turning_over_a_state_is_found_or_refused_in_plain_words():
    # the line's search meets a surface that stands upright to rounding
    upright = minimise(plain(Wedge(0.1), w=1.0, slopes="finite"), 0.2 - math.sqrt(2))
    assert upright.contact_angle == pytest.approx(math.pi / 2, rel=1e-10, abs=0)
    with pytest.raises(ValueError, match="turn over and be no graph"):
        minimise(plain(Wedge(0.1), w=1.3, slopes="finite"), 0.1)
