"""Energy and force in parts: against closed forms, and their sums against the whole."""

import math

import numpy as np
import pytest
from scenes import DELTA0, L, adhesive, rough, tips, two, wavy

from discretization import load_path, minimise
from energy import FlatPunch, Parabola, Plane, Wedge
from studies.shared.random_cases import SHAPES, random_case, random_steep_case

STORED = ("springs", "surface", "adhesion")
ACTING = ("pressure", "lines")


def sums(state):
    """Parts less the whole, over the scales of energy and force."""
    energy = sum(state.energy_parts.values()) - state.energy
    force = sum(state.force_parts.values()) - state.force
    return abs(energy) / state.scales["energy"], abs(force) / state.scales["force"]


@pytest.mark.parametrize(("method", "error"), [({}, 1e-13), ({"spacing": L / 400}, 1e-5)])
def test_the_parts_of_a_flat_punch_are_those_of_the_closed_forms(method, error):
    scene, a, d = adhesive(FlatPunch(2 * L)), 2 * L, 0.7 * DELTA0
    state = minimise(scene, d, method="lattice" if method else "auto", **method)
    k, w = scene.stiffness, scene.work_of_adhesion
    tail = k * L * d * d / 2  # of both tails, half of it in springs
    stored = (k * d * d * a + tail, tail, -2 * a * w)
    for name, value in zip(STORED, stored, strict=True):
        assert state.energy_parts[name] == pytest.approx(value, rel=error, abs=0)
    acting = (2 * a * k * d, 2 * k * L * d)  # (9), (10)
    for name, value in zip(ACTING, acting, strict=True):
        assert state.force_parts[name] == pytest.approx(value, rel=error, abs=0)


def test_the_parts_of_a_parabola_are_those_of_the_closed_forms():
    scene, d, R = adhesive(Parabola(0.02)), 0.4 * DELTA0, 0.02
    state = minimise(scene, d)
    k, gamma1, w, a = scene.stiffness, scene.gamma1, scene.work_of_adhesion, state.half_width
    u = d - a * a / (2 * R)
    within = k * (d * d * a - d * a**3 / (3 * R) + a**5 / (20 * R * R))
    parts = {
        "springs": within + k * L * u * u / 2,
        "surface": gamma1 * a**3 / (3 * R * R) + k * L * u * u / 2,
        "adhesion": -2 * a * w,
    }
    for name, value in parts.items():
        assert state.energy_parts[name] == pytest.approx(value, rel=1e-12, abs=0)
    pressure = 2 * k * (d * a - a**3 / (6 * R))
    assert state.force_parts["pressure"] == pytest.approx(pressure, rel=1e-12, abs=0)
    assert state.force_parts["lines"] == pytest.approx(2 * gamma1 * u / L, rel=1e-12, abs=0)


def test_the_parts_of_finite_slopes_are_those_of_the_first_integral():
    """k u²/2 = γ₁(1 - cos φ): a tail stores 2γ₁l(1 - cos φ/2) in its surface; sin φ acts."""
    scene = adhesive(FlatPunch(2 * L), w=0.05, slopes="finite")
    state = minimise(scene, 0.9 * L)
    gamma1, phi = scene.gamma1, 2 * math.asin(0.45)
    surface = 4 * gamma1 * L * (1 - math.cos(phi / 2))
    assert state.energy_parts["surface"] == pytest.approx(surface, rel=1e-10, abs=0)
    assert state.energy_parts["adhesion"] == pytest.approx(-4 * L * 0.05, rel=1e-13, abs=0)
    assert state.force_parts["lines"] == pytest.approx(2 * gamma1 * math.sin(phi), rel=1e-10, abs=0)


@pytest.mark.parametrize(("draw", "error"), [(random_case, 1e-12), (random_steep_case, 1e-10)])
def test_the_parts_sum_to_the_whole_on_the_fitted_mesh(draw, error):
    rng = np.random.default_rng(11)
    for i in range(40):
        case = draw(rng, SHAPES[i % len(SHAPES)])
        state = minimise(case.scene, case.depth)
        assert max(sums(state)) <= error + max(state.error_estimate.values())


@pytest.mark.parametrize(
    ("scene", "depth"),
    [
        (adhesive(two(6 * L)), 0.3 * DELTA0),
        (adhesive(two(1.2 * L)), 0.3 * DELTA0),
        (adhesive(tips(3 * L)), 2 * DELTA0),
        (wavy(), 0.8 * DELTA0),
        (rough(1), 0.0),
        (rough(3, w=0.0), 0.5 * DELTA0),
    ],
)
def test_the_parts_of_any_number_of_contacts_sum_to_the_whole(scene, depth):
    state = minimise(scene, depth)
    assert max(sums(state)) <= 1e-12
    coarse, fine = (
        minimise(scene, depth, method="lattice", spacing=L / cells) for cells in (50, 200)
    )
    for one, other in zip(sums(coarse), sums(fine), strict=True):
        assert other <= max(one / 4, 1e-6)
    for name in STORED:
        size = state.scales["energy"]
        assert abs(fine.energy_parts[name] - state.energy_parts[name]) <= 0.02 * size


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("body", [Parabola(0.02), Wedge(0.05), FlatPunch(2 * L)])
def test_the_parts_of_a_lattice_state_converge_to_the_whole(body, slopes):
    cells, found = np.array([25, 50, 100, 200]), []
    for each in cells:
        offsets = [
            minimise(
                adhesive(body.shifted(part * L / each), slopes=slopes),
                0.6 * DELTA0,
                method="lattice",
                spacing=L / each,
            )
            for part in (0.0, 0.3, 0.8)
        ]
        found.append(np.max([sums(state) for state in offsets], axis=0))
    orders = -np.polyfit(np.log(cells), np.log(found), 1)[0]
    assert (orders >= 1.8).all() and (orders <= 2.2).all()
    assert np.max(found[-1]) <= 1e-4


def test_the_parts_without_tension_without_contact_and_without_end():
    springs = minimise(adhesive(Parabola(0.02), gamma1=0.0), DELTA0)
    assert springs.energy_parts["surface"] == springs.force_parts["lines"] == 0
    assert max(sums(springs)) <= 1e-14
    apart = minimise(adhesive(Parabola(0.02)), -2 * DELTA0)
    assert apart.energy_parts == dict.fromkeys(STORED, 0.0)
    assert apart.force_parts == dict.fromkeys(ACTING, 0.0)
    endless = minimise(adhesive(Plane()), -0.5 * DELTA0)
    assert endless.energy_parts == {"springs": math.inf, "surface": 0.0, "adhesion": -math.inf}
    assert endless.force_parts == {"pressure": -math.inf, "lines": 0.0}


def test_a_contact_of_a_point_is_carried_by_its_lines():
    pinned = minimise(adhesive(Wedge(0.5)), 0.5 * L * math.tan(0.5))
    assert pinned.half_width == 0
    assert pinned.force_parts["pressure"] == 0
    assert pinned.force_parts["lines"] == pytest.approx(pinned.force, rel=1e-12, abs=0)
    assert pinned.energy_parts["adhesion"] == 0


def test_the_parts_agree_with_the_forces_of_a_path():
    scene = adhesive(Parabola(0.02))
    path = load_path(scene, depths=np.linspace(0, DELTA0, 4))
    state = minimise(scene, DELTA0)
    assert sum(state.force_parts.values()) == pytest.approx(path.force[-1], rel=1e-10, abs=0)
