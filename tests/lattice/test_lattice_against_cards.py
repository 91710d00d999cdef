"""The lattice minimiser against the closed forms: errors, orders, special cases."""

import math

import numpy as np
import pytest
from scenes import adhesive

from discretization import minimise
from discretization.lattice.state import on_lattice
from energy import FlatPunch, Parabola, Plane, PowerLaw, Sampled, Wedge, cards
from studies.shared.random_cases import SHAPES, random_case

K, GAMMA1, W = 130.0, 0.07, 0.002
M = {"k": K, "gamma1": GAMMA1, "w": W}
L, DELTA0 = math.sqrt(GAMMA1 / K), math.sqrt(2 * W / K)


@pytest.mark.parametrize("shape", SHAPES)
def test_random_scenes_over_eight_decades(shape):
    rng = np.random.default_rng(SHAPES.index(shape))
    for _ in range(60):
        case = random_case(rng, shape)
        dx = case.resolved / 200
        state = minimise(case.scene, case.depth, method="lattice", spacing=dx)
        raw = (state.nodes[0, 1] - state.nodes[0, 0]) / 2
        assert abs(raw - case.half_width) <= 0.6 * dx
        assert abs(state.half_width - case.half_width) <= 2 * dx**2 / case.resolved
        assert abs(state.force - case.force) <= 1e-4 * abs(case.force)
        assert abs(state.energy - case.energy) <= 1e-4 * state.scales["energy"]
        if shape != "flat":
            young = cards.contact_line.angle_deficit_small(
                case.scene.work_of_adhesion, case.scene.gamma1
            )
            assert abs(state.angle_deficit - young) <= 0.01 * young


@pytest.mark.parametrize("shape", ["wedge", "parabola", "power"])
def test_order_of_the_worst_error_over_grid_offsets(shape):
    case = random_case(np.random.default_rng(7), shape)
    spacings = case.resolved / np.array([12.5, 25, 50, 100, 200])
    worst = []
    for dx in spacings:
        errors = []
        for offset in (np.arange(16) + 0.37) / 16:
            state = on_lattice(case.scene, case.depth, dx, origin=offset * dx)
            raw = np.abs(state.nodes - case.half_width * np.array([[-1, 1]])).max()
            recovered = np.abs(state.contacts - case.half_width * np.array([[-1, 1]])).max()
            force = abs(state.force - case.force) / state.scales["force"]
            errors.append((raw, recovered, force))
        worst.append(np.max(errors, axis=0))
    raw, recovered, force = (
        np.polyfit(np.log(spacings), np.log(e), 1)[0] for e in np.transpose(worst)
    )
    assert raw == pytest.approx(1.0, abs=0.15)
    assert recovered == pytest.approx(2.0, abs=0.2)
    assert force == pytest.approx(2.0, abs=0.2)
    assert worst[-1][0] <= 0.6 * spacings[-1]
    assert worst[-1][1] <= 2 * spacings[-1] ** 2 / case.resolved
    assert worst[-1][2] <= 1e-4


def test_auto_meets_rtol_against_the_card_and_its_own_estimate():
    for R, d in ((0.011, 2e-3), (0.03, -4e-3)):
        scene = adhesive(Parabola(R))
        state = minimise(scene, d)
        a = cards.parabola.half_width(d, R=R, **M)
        error = abs(state.half_width / a - 1)
        assert error <= 1e-8
        assert error <= state.error_estimate["half_width"] <= 1e-8


def test_wedge_is_pinned_at_its_tip_and_leaves_it_when_pressed_harder():
    delta = math.atan(2.5 * DELTA0 / L)
    lo, hi = cards.wedge.tip_pinned_depths(delta=delta, **M)
    for d in np.linspace(lo, hi, 7)[1:-1]:
        state = minimise(adhesive(Wedge(delta)), d, method="lattice", spacing=L / 400)
        assert state.half_width == 0
        assert state.pinned.all()
        assert state.force == pytest.approx(2 * K * L * d, rel=1e-5, abs=0)
        assert state.angle_deficit > DELTA0 / L  # a pinned line's angle is not Young's
    beyond = minimise(adhesive(Wedge(delta)), 1.2 * hi, method="lattice", spacing=L / 400)
    assert not beyond.pinned.any()
    assert beyond.half_width == pytest.approx(
        cards.wedge.half_width(1.2 * hi, delta=delta, **M), rel=1e-4, abs=0
    )
    assert minimise(adhesive(Wedge(delta)), -0.01 * DELTA0).label == "detached"


def test_flat_punch_is_pinned_at_its_edges_wherever_they_fall_on_the_grid():
    a = 3.3 * L
    for offset in (0.0, 0.21, 0.5, 0.93):
        state = on_lattice(adhesive(FlatPunch(a)), -0.7 * DELTA0, L / 200, origin=offset * L / 200)
        assert state.pinned.all()
        assert np.abs(state.contacts - [[-a, a]]).max() <= 1e-13 * a
        card = cards.flat_punch.force(-0.7 * DELTA0, a=a, **M)
        assert state.force == pytest.approx(card, rel=1e-5, abs=0)


def test_flat_punch_and_plane_are_neutral_at_the_critical_separation():
    punch = adhesive(FlatPunch(2 * L))
    assert minimise(punch, -DELTA0, method="lattice", spacing=L / 50).label == "neutral"
    assert (
        minimise(punch, -DELTA0 * (1 - 1e-9), method="lattice", spacing=L / 50).label
        == "metastable"
    )
    assert (
        minimise(punch, -DELTA0 * (1 + 1e-9), method="lattice", spacing=L / 50).label == "detached"
    )
    assert minimise(punch, DELTA0, method="lattice", spacing=L / 50).label == "global"
    plane = adhesive(Plane())
    assert minimise(plane, -DELTA0).label == "neutral"
    assert minimise(plane, -DELTA0 * (1 + 1e-9)).label == "detached"
    spread = minimise(plane, -0.5 * DELTA0)
    assert spread.half_width == math.inf
    assert spread.force == -math.inf


def test_no_tension_means_independent_springs():
    R, d = 0.02, 1.5e-3
    scene = adhesive(Parabola(R), gamma1=0.0)
    dx = 1e-5
    touched = minimise(scene, d, method="lattice", spacing=dx)  # attach on touching
    a = math.sqrt(2 * R * d)
    assert touched.half_width == pytest.approx(a, abs=dx**2 / a)
    assert touched.force == pytest.approx(4 / 3 * K * a * d, rel=1e-5, abs=0)
    lowest = minimise(scene, d, method="lattice", spacing=dx, branch="global")  # Eq. (18)
    a = math.sqrt(2 * R * cards.contact_line.cut_level(d, k=K, w=W))
    assert lowest.half_width == pytest.approx(a, abs=dx**2 / a)
    punch = adhesive(FlatPunch(0.013), gamma1=0.0)
    kept = minimise(punch, -0.999 * DELTA0, method="lattice", spacing=dx)
    assert kept.force == pytest.approx(-2 * K * 0.013 * 0.999 * DELTA0, rel=1e-13, abs=0)
    assert minimise(punch, -1.001 * DELTA0, method="lattice", spacing=dx).label == "detached"


def test_no_adhesion_is_convex_and_has_a_smooth_surface():
    R, d = 0.02, 1.5e-3
    scene = adhesive(Parabola(R), w=0.0)
    a = cards.nonadhesive.parabola_half_width(d, R=R, k=K, gamma1=GAMMA1)
    state = minimise(scene, d, method="lattice", spacing=min(a, L) / 200)
    force = cards.nonadhesive.parabola_force(d, R=R, k=K, gamma1=GAMMA1)
    assert state.half_width == pytest.approx(a, rel=1e-5, abs=0)
    assert state.force == pytest.approx(force, rel=1e-5, abs=0)
    assert abs(state.angle_deficit) <= 1e-5 * a / R
    assert state.label == "global"
    assert minimise(scene, -1e-9).label == "detached"


@pytest.mark.parametrize("slope", [0.0, 0.003])
def test_line_condition_at_both_ends_of_an_asymmetric_smooth_profile(slope):
    x = np.linspace(-0.05, 0.06, 4001)
    indenter = (
        Sampled(x, 40 * np.abs(x) ** 3 + 0.5 * x**2, kind="smooth").tilted(slope).shifted(1e-3)
    )
    state = minimise(adhesive(indenter), 1e-3, method="lattice", spacing=L / 400)
    for side, end in zip((-1, 1), state.contacts[0], strict=True):
        residual = cards.contact_line.line_residual(
            1e-3, indenter.height(end), side * indenter.slope(end), **M
        )
        assert abs(residual) <= 1e-4 * DELTA0


def test_a_blunt_power_law_recovers_the_flat_punch():
    a, d = 3 * L, -0.5 * DELTA0
    blunt = minimise(
        adhesive(PowerLaw(a**-200.0 * 0.01, 200.0)), d, method="lattice", spacing=L / 200
    )
    assert blunt.half_width == pytest.approx(a, rel=0.05, abs=0)


def test_a_flat_punch_is_neutral_at_its_critical_separation_in_any_units():
    rng = np.random.default_rng(11)
    for _ in range(100):
        scene = random_case(rng, "flat").scene
        dx = min(scene.elastocapillary_length, scene.indenter.half_width) / 10
        assert (
            minimise(scene, -scene.critical_separation, method="lattice", spacing=dx).label
            == "neutral"
        )


def test_a_wedge_contact_smaller_than_the_spacing_is_found_beyond_its_tip():
    delta = math.atan(2.5 * DELTA0 / L)
    dx = L / 300
    for a in (0.2 * dx, 0.4 * dx, 0.7 * dx):
        d = cards.wedge.depth(a, delta=delta, **M)
        state = minimise(adhesive(Wedge(delta)), d, method="lattice", spacing=dx)
        assert not state.pinned.any()
        assert abs(state.half_width - a) <= 2 * dx**2 / L
