"""Finite slopes on the lattice: errors, orders, agreement with the mesh."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive, steep

from discretization import load_path, minimise
from discretization.equilibrium import QUANTITIES
from discretization.lattice.state import on_lattice
from energy import (
    FlatPunch,
    Parabola,
    Patches,
    Plane,
    PowerLaw,
    Profile,
    Sampled,
    SurfaceEnergies,
    Wedge,
    cards,
)
from studies.shared.random_cases import random_steep_case, steep_totals

COSINES = Profile(
    lambda x: 2e-5 * np.cos(2000 * np.asarray(x)), lambda x: -0.04 * np.sin(2000 * np.asarray(x))
)


def carded(scene, a):
    """(depth, force, energy) at the half-width a by energy.cards.finite and quadrature."""
    m = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    f, slope = float(scene.indenter.height(a)), float(scene.indenter.slope(a))
    depth = float(cards.finite.depth(f, slope, **m))
    return depth, *steep_totals(scene, depth, a)


def built(shape, a, rise):
    """An indenter of the slope `rise` at a."""
    return {
        "wedge": lambda: Wedge(math.atan(rise)),
        "parabola": lambda: Parabola(a / rise),
        "power": lambda: PowerLaw(rise / (3 * a**2), 3.0),
    }[shape]()


def orders(spacings, errors):
    return [float(np.polyfit(np.log(spacings), np.log(column), 1)[0]) for column in errors.T]


@pytest.mark.parametrize(
    ("ratio", "rise", "width"), [(0.8, 0.3, 2.0), (0.1, 1.0, 5.0), (0.003, 0.5, 0.4)]
)
@pytest.mark.parametrize("shape", ["wedge", "parabola", "power"])
def test_worst_error_over_grid_offsets_against_the_cards(shape, ratio, rise, width):
    ell = steep(Parabola(1.0)).elastocapillary_length
    a = width * ell
    scene = steep(built(shape, a, rise), ratio)
    depth, force, energy = carded(scene, a)
    links = np.array([12, 24, 48, 96]) * math.ceil(max(1.0, width))
    worst = []
    for n in links:
        errors = []
        for offset in (np.arange(4) + 0.37) / 4:  # of the line between two nodes, tip on a node
            state = on_lattice(scene, depth, a / (n + offset))
            errors.append(
                (
                    np.abs(np.abs(state.nodes) - a).max() / state.spacing,
                    np.abs(np.abs(state.contacts) - a).max() / a,
                    abs(state.force - force) / state.scales["force"],
                    abs(state.energy - energy) / state.scales["energy"],
                    np.abs(state.contact_angles - scene.surfaces.contact_angle).max(),
                )
            )
        worst.append(np.max(errors, axis=0))
    worst = np.array(worst)
    assert worst[-2:, 0].max() <= 1.0  # raw lines within one link
    for order in orders(1 / links, worst[:, 1:]):
        assert order == pytest.approx(2.0, abs=0.25)
    assert worst[-1, 1:4].max() <= 3e-5
    assert worst[-1, 4] <= 3e-4


@pytest.mark.parametrize(("ratio", "share"), [(0.8, -0.97), (0.2, 1.5), (0.02, -0.5)])
def test_flat_punch_force_and_energy_converge_wherever_its_edges_fall(ratio, share):
    ell, a = steep(Parabola(1.0)).elastocapillary_length, 0.03
    scene = steep(FlatPunch(a), ratio)
    k, gamma1, w = scene.stiffness, scene.gamma1, scene.work_of_adhesion
    d, worst = min(share * scene.critical_separation, 1.2 * ell), []
    force = 2 * k * a * d + float(cards.finite.surface_force(d, k=k, gamma1=gamma1))
    energy = k * a * d**2 - 2 * w * a + 2 * float(cards.finite.tail_energy(d, k=k, gamma1=gamma1))
    spacings = ell / np.array([12.5, 25, 50, 100, 200])
    for dx in spacings:
        states = [on_lattice(scene, d, dx, origin=o * dx) for o in (0.0, 0.21, 0.5, 0.83)]
        for state in states:
            assert np.abs(np.abs(state.contacts) - a).max() <= 1e-13 * a
            assert state.pinned.all()
        worst.append(
            [
                max(abs(s.force - force) / s.scales["force"] for s in states),
                max(abs(s.energy - energy) / s.scales["energy"] for s in states),
            ]
        )
    for order in orders(spacings, np.array(worst)):
        assert order == pytest.approx(2.0, abs=0.25)
    assert np.max(worst[-1]) <= 3e-5


def test_lattice_and_fitted_agree_within_the_lattice_s_own_estimate():
    rng = np.random.default_rng(12)
    for kind in range(30):
        case = random_steep_case(rng, ("wedge", "parabola", "power")[kind % 3])
        fitted = minimise(case.scene, case.depth, method="fitted")
        dx = case.resolved / 60
        lattice = minimise(case.scene, case.depth, method="lattice", spacing=dx)
        assert lattice.label == fitted.label
        if lattice.label == "detached":
            continue
        scales = {"half_width": fitted.half_width, **fitted.scales}
        for name in QUANTITIES:
            error = abs(getattr(lattice, name) - getattr(fitted, name)) / scales[name]
            assert error <= lattice.error_estimate[name] <= 1e-3


@pytest.mark.parametrize("links", [0.3, 3.0, 1e2, 1e3])
def test_flat_faces_let_go_at_the_critical_separation_at_any_slope(links):
    for ratio in (1e-3, 0.3, 0.8):
        scene = steep(FlatPunch(0.03), ratio)
        dx = min(scene.elastocapillary_length / links, 0.004)
        d_c = -scene.critical_separation
        assert on_lattice(scene, d_c, dx).label == "neutral"
        assert on_lattice(scene, d_c * (1 + 1e-9), dx).label == "detached"
        assert on_lattice(scene, d_c * (1 - 1e-9), dx).label == "metastable"
        plane = replace(scene, indenter=Plane())
        assert minimise(plane, d_c).label == "neutral"
        assert minimise(plane, d_c * (1 + 1e-9)).label == "detached"
        assert minimise(plane, 0.9 * d_c).half_width == math.inf


@pytest.mark.slow
@pytest.mark.parametrize("decade", range(-2, 5))
def test_it_is_stable_for_any_ratio_of_length_to_spacing(decade):
    dx, k, rise = 0.013, 37.0, 0.4
    ell, a = 10.0**decade * dx, 150.3 * dx
    tension = {"gamma1": k * ell**2, "w": 0.3 * k * min(ell, a) ** 2}
    scene = adhesive(Parabola(a / rise), k=k, **tension, slopes="finite")
    state = minimise(scene, carded(scene, a)[0], method="lattice", spacing=dx)
    assert state.certificate.ok
    assert state.certificate.force <= 1e-13
    assert abs(state.half_width - a) <= dx * min(0.5, 0.3 * dx / min(ell, a) + 1e-4)
    if decade >= 0:
        assert abs(state.half_width / a - 1) <= state.error_estimate["half_width"]


def test_profiles_that_are_not_convex_work_while_the_contact_is_one_interval():
    indenter = Parabola(0.02) + COSINES
    x = np.linspace(-0.04, 0.04, 8001)
    sampled = Sampled(x, indenter.height(x), kind="smooth")
    for depth in (1e-3, -2e-3):
        found = []
        for f in (indenter, sampled):
            scene = steep(f)
            state = minimise(
                scene, depth, method="lattice", spacing=scene.elastocapillary_length / 100
            )
            assert not f.convex
            assert state.certificate.ok
            assert state.error_estimate["half_width"] <= 1e-3
            assert abs(state.contact_angle - scene.surfaces.contact_angle) <= 1e-3
            found.append(state.half_width)
        assert found[0] == pytest.approx(found[1], rel=1e-08, abs=0)


def test_the_field_carries_the_force_and_meets_the_lines():
    scene = steep(Parabola(0.02).tilted(0.1), 0.6)
    ell = scene.elastocapillary_length
    state = minimise(scene, 1e-3, method="lattice", spacing=ell / 400)
    left, right = state.contacts[0]
    nodes, weights = np.polynomial.legendre.leggauss(60)
    force = 0.0
    for lo, hi in ((left, right), (right, right + 40 * ell), (left - 40 * ell, left)):
        x = (lo + hi) / 2 + (hi - lo) / 2 * nodes
        force += scene.stiffness * (hi - lo) / 2 * float(weights @ state.displacement(x))
    assert abs(force - state.force) <= 1e-5 * state.scales["force"]
    u = 1e-3 - float(scene.indenter.height(right))
    heights = u * np.array([0.9, 0.5, 0.1])
    x = cards.finite.meniscus(heights, u_a=u, k=scene.stiffness, gamma1=scene.gamma1)
    assert np.abs(state.displacement(right + x) - heights).max() <= 1e-4 * abs(u)


def test_a_surface_about_to_turn_over_is_refused_with_the_way_out():
    scene = steep(FlatPunch(0.03), 1.5)
    ell, dx = scene.elastocapillary_length, scene.elastocapillary_length / 100
    assert on_lattice(scene, -1.3 * ell, dx).certificate.ok
    for indenter in (FlatPunch(0.03), Plane(), Wedge(0.03)):  # the last must not spread for ever
        with pytest.raises(ValueError, match=r"depth = .* turn over; use method='fitted'"):
            on_lattice(replace(scene, indenter=indenter), -1.35 * ell, dx)
    pressed = on_lattice(steep(Parabola(1.0)), 5 * ell, dx)  # deep inside, gentle at the lines
    assert pressed.certificate.ok


def test_what_plain_nodes_do_not_answer_is_refused_with_the_way_out():
    scene = steep(Parabola(0.02))
    ell, delta = scene.elastocapillary_length, scene.critical_separation
    given = {"method": "lattice", "spacing": ell / 50}
    with pytest.raises(ValueError, match=r"nodes on a free surface.* use method='fitted'"):
        minimise(scene, 1e-3, method="lattice", spacing=1e-6 * ell)
    more = SurfaceEnergies.from_work(scene.gamma1, 1.5 * scene.work_of_adhesion)
    pattern = Patches(np.array([-1.0, 1.5]) * ell, [1.0, 0.5, 0.8])
    for held in ({"opening": more}, {"pattern": pattern}):
        with pytest.raises(ValueError, match=r"nodes only answer states of one contact.*'fitted'"):
            minimise(replace(scene, **held), delta, **given)
    with pytest.raises(ValueError, match=r"no load paths.* use method='fitted'"):
        load_path(scene, depths=[0.0, delta], **given)
    two = Profile(
        lambda x: (np.abs(x) - 5 * ell) ** 2 / (6 * ell),
        lambda x: np.sign(x) * (np.abs(x) - 5 * ell) / (3 * ell),
        extent=(-20 * ell, 20 * ell),
    )
    with pytest.raises(ValueError, match="states of one contact only: use method='fitted'"):
        minimise(replace(scene, indenter=two), delta, **given)
    with pytest.raises(ValueError, match="slopes='small'"):
        minimise(replace(scene, indenter=two), delta, branch="global", **given)


def test_small_slopes_are_the_limit():
    errors = []
    for ratio in (0.08, 0.04, 0.02, 0.01):
        true = steep(Parabola(0.02), ratio=ratio)
        for share in (0.0, 0.5, -0.3):
            one, other = (
                on_lattice(scene, share * true.critical_separation, 1e-4).half_width
                for scene in (true, replace(true, slopes="small"))
            )
            errors.append(abs(one / other - 1))
    errors = np.max(np.reshape(errors, (4, 3)), axis=1)
    assert 0.8 <= np.polyfit(np.log([8, 4, 2, 1]), np.log(errors), 1)[0] <= 1.2
