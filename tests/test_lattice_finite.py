"""Finite slopes on the lattice: errors, orders, the eliminated tail, agreement with the mesh."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive
from scipy.integrate import quad

from discretization import Lattice, NodalEnergy, minimise, on_lattice
from discretization.certificate import certify, measured
from discretization.lattice import fronts
from discretization.lattice.tails import tail_response
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Plane,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

QUANTITIES = ("half_width", "force", "energy")
COSINES = Profile(
    lambda x: 2e-5 * np.cos(2000 * np.asarray(x)), lambda x: -0.04 * np.sin(2000 * np.asarray(x))
)


def steep(indenter, ratio=0.3, gamma1=0.07):
    return replace(adhesive(indenter, gamma1=gamma1, w=ratio * gamma1), slopes="finite")


def built(shape, a, rise):
    """An indenter of the slope `rise` at a."""
    return {
        "wedge": lambda: Wedge(math.atan(rise)),
        "parabola": lambda: Parabola(a / rise),
        "power": lambda: PowerLaw(rise / (3 * a**2), 3.0),
    }[shape]()


def carded(scene, a):
    """(depth, force, energy) at the half-width a by energy.cards.finite and quadrature."""
    k, gamma1, w, f = scene.stiffness, scene.gamma1, scene.work_of_adhesion, scene.indenter
    m = {"k": k, "gamma1": gamma1}
    depth = float(cards.finite.depth(float(f.height(a)), float(f.slope(a)), w=w, **m))
    u = depth - float(f.height(a))

    def density(x):
        g, arc = depth - float(f.height(x)), math.hypot(1, float(f.slope(x)))
        return k / 2 * g**2 + (gamma1 - w) * arc - gamma1

    springs = quad(lambda x: depth - float(f.height(x)), 0, a, epsrel=1e-12)[0]
    energy = quad(density, 0, a, epsrel=1e-12)[0]
    return (
        depth,
        2 * k * springs + float(cards.finite.surface_force(u, **m)),
        2 * energy + 2 * float(cards.finite.tail_energy(u, **m)),
    )


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
            assert np.abs(np.abs(state.contacts) - a).max() <= 1e-12 * a
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


def random_scene(rng, shape):
    length = 10.0 ** rng.uniform(-4, 4)
    k, gamma1 = 3.7 / length, 3.7 * length
    w = gamma1 * 10 ** rng.uniform(-3, -0.1)
    a = length * 10 ** rng.uniform(-1, 1)
    surfaces = SurfaceEnergies.from_work(gamma1, w)
    scene = Scene(
        ElasticLayer(k, 0.0, 1.0), surfaces, built(shape, a, rng.uniform(0.02, 1.0)), "finite"
    )
    return scene, a, carded(scene, a)[0]


def test_lattice_and_fitted_agree_within_the_lattice_s_own_estimate():
    rng = np.random.default_rng(12)
    for kind in range(30):
        scene, a, depth = random_scene(rng, ("wedge", "parabola", "power")[kind % 3])
        fitted = minimise(scene, depth, method="fitted")
        dx = min(a, scene.elastocapillary_length) / 60
        lattice = minimise(scene, depth, method="lattice", spacing=dx)
        assert lattice.label == fitted.label
        if lattice.label == "detached":
            continue
        scales = {"half_width": fitted.half_width, **fitted.scales}
        for name in QUANTITIES:
            error = abs(getattr(lattice, name) - getattr(fitted, name)) / scales[name]
            assert error <= lattice.error_estimate[name] <= 1e-3


def test_finite_slopes_tend_to_small_slopes_in_first_order_of_w():
    ratios, differences = np.array([1e-2, 1e-3, 1e-4, 1e-5]), []
    for ratio in ratios:
        scene = steep(Wedge(0.5 * math.sqrt(2 * ratio)), ratio)
        dx = scene.elastocapillary_length / 50
        one, other = (on_lattice(replace(scene, slopes=s), 0.0, dx) for s in ("small", "finite"))
        differences.append([abs(getattr(other, q) / getattr(one, q) - 1) for q in QUANTITIES])
    for order in orders(ratios, np.array(differences)):
        assert order == pytest.approx(1.0, abs=0.05)
    assert np.max(differences[-1]) <= ratios[-1]


@pytest.mark.parametrize("links", [0.3, 3.0, 1e2, 1e6])
def test_flat_faces_let_go_at_the_critical_separation_at_any_slope(links):
    for ratio in (1e-3, 0.3, 0.8):
        scene = steep(FlatPunch(0.03), ratio)
        dx = min(scene.elastocapillary_length / links, 0.004)
        if links > 1e3:
            scene = replace(scene, indenter=FlatPunch(200.3 * dx))
        d_c = -scene.critical_separation
        assert on_lattice(scene, d_c, dx).label == "neutral"
        assert on_lattice(scene, d_c * (1 + 1e-9), dx).label == "detached"
        assert on_lattice(scene, d_c * (1 - 1e-9), dx).label == "metastable"
        plane = replace(scene, indenter=Plane())
        assert minimise(plane, d_c).label == "neutral"
        assert minimise(plane, d_c * (1 + 1e-9)).label == "detached"
        assert minimise(plane, 0.9 * d_c).half_width == math.inf


@pytest.mark.parametrize("h", [0.02, 0.3, 4.0])
def test_the_collocated_tail_is_a_long_chain_of_nodes(h):
    """Reaction, energy and nodes against Newton's method on all of them."""
    scene = steep(Parabola(0.02))
    ell = scene.elastocapillary_length
    lattice = Lattice.of(scene, h * ell)
    held = np.zeros(int(40 / min(h, 1.0)) + 5, bool)
    held[0] = True
    chain, end = NodalEnergy(lattice, held), NodalEnergy(lattice, held[:1])
    for share in (1e-3, 0.4, -0.9, 1.3, -1.3):
        g = np.where(held, share * ell, 0.0)
        u = chain.relaxed(g)
        assert chain.value(u) == pytest.approx(end.value(g[:1]), rel=1e-12, abs=0)
        assert chain.gradient(u)[0] == pytest.approx(end.gradient(g[:1])[0], rel=1e-12, abs=0)
        decayed = lattice.tail.displacement(lattice.spacing * np.arange(held.size), g[0])
        assert np.abs(u - decayed).max() <= 1e-12 * abs(g[0])


def test_the_tail_keeps_its_digits_for_any_ratio_of_length_to_spacing():
    """Its own balance, and the first integral 1 - cos φ = u²/2 as the spacing vanishes."""
    for h in 10.0 ** np.arange(-9, 4):
        tail = tail_response(h)
        u = np.linspace(-1.3, 1.3, 53)
        after, pull = tail.after(u), tail.reaction(u)
        balance = h * after + tail.reaction(after) - pull
        assert np.abs(balance).max() <= 1e-14 * np.max(np.abs(pull) + h * np.abs(u))
        level = tail.parting(u, 0 * u)  # a node as high as the last: only its spring counts
        assert np.abs(level + u).max() <= 1e-13
        if h <= 1e-3:
            phi = 2 * np.arcsin(u / 2)
            assert np.abs(pull + h * u / 2 - np.sin(phi)).max() <= 50 * h**2 + 1e-14
            slope = math.log1p(-h * tail.fall(np.array(1e-9)) / 1e-9) / h * tail.steepness(u)
            assert np.abs(np.arctan(slope) + phi).max() <= 50 * h**2 + 2e-7


def test_an_advance_changes_energy_and_force_as_two_relaxed_chains_say():
    scene = steep(Parabola(0.02), 0.5)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 8)
    nodes = np.arange(-40, 41)
    f = scene.indenter.height(lattice.x(nodes))
    for last, depth in itertools.product((3, 9), (1e-3, -5e-3)):
        i = last + 40
        values, forces = [], []
        for end in (last, last + 1):
            energy = NodalEnergy(lattice, (nodes >= -2) & (nodes <= end))
            u = energy.relaxed(depth - f)
            values.append(energy.value(u))
            forces.append(energy.gradient(u)[energy.contact].sum())
        move = f[i], f[i + 1], depth
        change, size = values[1] - values[0], scene.gamma1 * lattice.spacing
        _, energy, force = lattice.advance(*move)
        assert energy == pytest.approx(change, rel=0, abs=1e-11 * size)
        expected = forces[1] - forces[0]
        assert force == pytest.approx(expected, rel=0, abs=1e-11 * scene.gamma1)


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_nodal_energy_derivatives(slopes):
    scene = replace(steep(Parabola(0.02)), slopes=slopes)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 5)
    rng, size = np.random.default_rng(3), 12
    u = rng.uniform(-0.5, 0.5, size) * scene.elastocapillary_length
    energy, step = NodalEnergy(lattice, np.arange(size) % 5 > 1), 1e-5 * np.abs(u).max()
    band = energy.hessian(u)
    hessian = np.diag(band[0]) + np.diag(band[1, :-1], -1) + np.diag(band[1, :-1], 1)
    for i, unit in enumerate(step * np.eye(size)):
        slope = (energy.value(u + unit) - energy.value(u - unit)) / (2 * step)
        assert slope == pytest.approx(energy.gradient(u)[i], rel=1e-6, abs=1e-8 * scene.gamma1)
        change = (energy.gradient(u + unit) - energy.gradient(u - unit)) / (2 * step)
        assert np.abs(change - hessian[i]).max() <= 1e-7 * hessian[i, i]


@pytest.mark.parametrize("indenter", [Parabola(0.02), Parabola(0.02).tilted(0.1)])
def test_blocked_sums_are_the_nodal_energy(indenter):
    scene = steep(indenter)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 100, origin=0.0)
    u = 2e-3 - indenter.height(lattice.x(np.arange(-90, 71.0)))
    sums = measured(lattice, indenter, 2e-3, fronts.Contact(-90, 70, 0.0))
    energy = NodalEnergy(lattice, np.ones(u.size, bool))
    for name, value in energy.terms(u).items():
        assert getattr(sums, name) == pytest.approx(value, rel=1e-12, abs=0)
    force = energy.gradient(u).sum()
    assert sums.force_by_reactions == pytest.approx(force, rel=1e-10, abs=0)
    assert sums.force == pytest.approx(force, rel=1e-10, abs=0)
    steepest = np.abs(np.diff(u)).max() / lattice.spacing
    assert sums.stiffness == pytest.approx(lattice.link / (1 + steepest**2) ** 1.5, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "condition"), [((0, 1), "neighbours"), ((-1, 0), "neighbours"), ((40, -40), "pen")]
)
def test_the_certificate_rejects_a_line_out_of_place(change, condition):
    scene = steep(Parabola(0.02), 0.4 if condition == "neighbours" else 0.0)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 100)
    where = fronts.region(lattice, scene.indenter, 2e-3)
    first, last, reach = fronts.adhered(lattice, scene.indenter, 2e-3, where)
    for shift, fails in (((0, 0), False), (change, True)):
        moved = fronts.Contact(first + shift[0], last + shift[1], reach)
        sums = measured(lattice, scene.indenter, 2e-3, moved)
        certificate = certify(lattice, scene.indenter, 2e-3, where, moved, sums)
        assert any(name.startswith(condition) for name in certificate.failures) == fails
        assert certificate.stationarity == 0


def test_no_result_depends_on_the_units():
    rng = np.random.default_rng(8)
    for kind, (length, stress) in enumerate([(1e3, 1e-6), (1e-6, 1e9), (25.4, 0.145)] * 3):
        scene, a, depth = random_scene(rng, ("wedge", "parabola", "power")[kind % 3])
        if kind % 3 == 2:
            indenter = PowerLaw(scene.indenter.c / length**2, 3.0)
        else:
            indenter = scene.indenter if kind % 3 == 0 else Parabola(scene.indenter.R * length)
        layer, s = scene.layer, scene.surfaces
        other = Scene(
            ElasticLayer(layer.E * stress, layer.nu, layer.h * length),
            SurfaceEnergies.from_work(
                s.gamma1 * stress * length, s.work_of_adhesion * stress * length
            ),
            indenter,
            "finite",
        )
        dx, depth = min(a, scene.elastocapillary_length) / 50, max(depth, 0.0)
        one = on_lattice(scene, depth, dx)
        moved = on_lattice(other, depth * length, dx * length)
        force = stress * length
        assert moved.half_width == pytest.approx(one.half_width * length, rel=1e-9, abs=0)
        scale = force * one.scales["force"]
        assert moved.force == pytest.approx(one.force * force, rel=0, abs=1e-9 * scale)
        scale = force * length * one.scales["energy"]
        assert moved.energy == pytest.approx(one.energy * force * length, rel=0, abs=1e-9 * scale)
        assert moved.contact_angle == pytest.approx(one.contact_angle, rel=0, abs=1e-9)
        assert moved.label == one.label


@pytest.mark.parametrize("decade", range(-2, 9))
def test_it_is_stable_for_any_ratio_of_length_to_spacing(decade):
    dx, k, rise = 0.013, 37.0, 0.4
    ell, a = 10.0**decade * dx, 150.3 * dx
    surfaces = SurfaceEnergies.from_work(k * ell**2, 0.3 * k * min(ell, a) ** 2)
    scene = Scene(ElasticLayer(k, 0.0, 1.0), surfaces, Parabola(a / rise), "finite")
    state = minimise(scene, carded(scene, a)[0], method="lattice", spacing=dx)
    assert state.certificate.ok
    assert state.certificate.force <= 1e-13
    assert abs(state.half_width - a) <= dx * min(0.5, 0.3 * dx / min(ell, a) + 1e-4)
    if 0 <= decade <= 6:  # beyond, rounding is the larger part
        assert abs(state.half_width / a - 1) <= state.error_estimate["half_width"]


def test_profiles_that_are_not_convex_work_while_the_contact_is_one_interval():
    indenter = Parabola(0.02) + COSINES
    x = np.linspace(-0.04, 0.04, 8001)
    sampled = Sampled(x, indenter.height(x), kind="smooth")
    for depth in (3e-3, 1e-3, -2e-3):
        found = []
        for f in (indenter, sampled):
            scene = steep(f)
            state = minimise(
                scene, depth, method="lattice", spacing=scene.elastocapillary_length / 300
            )
            assert not f.convex
            assert state.certificate.ok
            assert state.error_estimate["half_width"] <= 1e-3
            assert abs(state.contact_angle - scene.surfaces.contact_angle) <= 1e-3
            found.append(state.half_width)
        assert found[0] == pytest.approx(found[1], rel=1e-5, abs=0)


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


def test_without_tension_and_adhesion_finite_slopes_change_nothing():
    scene = adhesive(Parabola(0.02), gamma1=0.0, w=0.0)
    one, other = (
        minimise(replace(scene, slopes=s), 1e-3, method="lattice", spacing=1e-5)
        for s in ("small", "finite")
    )
    assert one.half_width == other.half_width
    assert one.energy == other.energy
