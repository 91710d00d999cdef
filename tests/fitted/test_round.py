"""Rotational symmetry on the fitted mesh, small slopes, against the closed forms."""

import mpmath
import numpy as np
import pytest
from round_cases import SHAPES, random_round_case
from scenes import check
from scipy.optimize import fsolve

from discretization import load_path, minimise
from discretization.equilibrium import QUANTITIES
from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Parabola,
    PowerLaw,
    Profile,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

axi = cards.axisymmetric
K, GAMMA1, W = 1.1e7, 0.031, 4.3e-3
LAYER = {"k": K, "gamma1": GAMMA1, "w": W}
ELL, DELTA0 = np.sqrt(GAMMA1 / K), np.sqrt(2 * W / K)


def turned(indenter, k=K, gamma1=GAMMA1, w=W, **more):
    layer, surfaces = ElasticLayer(k, 0.0, 1.0), SurfaceEnergies.from_work(gamma1, w)
    return Scene(layer, surfaces, indenter, geometry="axisymmetric", **more)


@pytest.mark.parametrize("shape", SHAPES)
def test_eleven_digits_over_eight_decades_and_an_honest_estimate(shape):
    rng, understated = np.random.default_rng(200 + SHAPES.index(shape)), 0
    for _ in range(63):
        case = random_round_case(rng, shape)
        state = minimise(case.scene, case.depth)
        scales = {"half_width": case.half_width, **state.scales}
        for name in QUANTITIES:
            error = abs(getattr(state, name) - getattr(case, name)) / scales[name]
            assert error <= 1e-11
            assert error <= 10 * state.error_estimate[name]
            understated += error > state.error_estimate[name]
        if shape != "flat":
            assert abs(state.angle_deficit - case.scene.surfaces.small_slope_deficit) <= 1e-10
    assert understated <= 3


CASES = {  # an indenter, its card and its parameters
    "sphere": (Parabola(0.013), axi.sphere, {"R": 0.013}),
    "cone": (Wedge(0.01), axi.cone, {"delta": 0.01}),
    "power": (PowerLaw(7e5, 3.0), axi.power_law, {"c": 7e5, "n": 3.0}),
}


@pytest.mark.parametrize("name", CASES)
def test_what_an_equilibrium_says_of_itself(name):
    indenter, card, own = CASES[name]
    args = {**own, **LAYER}
    for d in (-0.1 * DELTA0, 0.0, 3 * DELTA0):
        state, a = minimise(turned(indenter), d), float(card.radius(d, **args))
        check(state.radius, a, 1e-12)
        assert state.half_width == state.radius
        assert state.contacts.tolist() == [[0.0, state.radius]]
        check(state.contact_area, np.pi * a**2, 1e-12)
        r = np.array([-1.7, -0.5, 0.0, 0.9, 1.1, 3.0]) * a
        check(state.displacement(r), card.displacement(r, d=d, **args), 1e-10, DELTA0)
        assert (state.pressure(r)[[0, 4, 5]] == 0).all()
        check(state.pressure(r)[1:4], K * (d - indenter.height(r[1:4])), 1e-14)
        parts, energies = state.force_parts, state.energy_parts
        check(sum(parts.values()), state.force, 1e-12, abs(sum(map(abs, parts.values()))))
        check(sum(energies.values()), state.energy, 1e-12, sum(map(abs, energies.values())))
        check(energies["adhesion"], -W * np.pi * a**2, 1e-11)
        u_a = d - float(indenter.height(a))
        check(parts["lines"], axi.surface.force(u_a, a=a, k=K, gamma1=GAMMA1), 1e-9)
        check(state.force, card.force(d, **args), 1e-11, state.scales["force"])


OF_SPHERE = {  # Λ: F_A/(2πRw)
    0.1: 0.928964975514,
    0.3: 0.794985771137,
    1.0: 0.554575152060,
    3.0: 0.502146734323,
}


@pytest.mark.parametrize("ratio", OF_SPHERE)
def test_a_sphere_is_pulled_off_where_theory_says(ratio):
    R, gamma1 = 0.013, K * ratio**2 * 0.013 * DELTA0
    args = {"R": R, "k": K, "gamma1": gamma1, "w": W}
    scene, there = turned(Parabola(R), gamma1=gamma1), DELTA0 * np.linspace(-1.1, 1.0, 12)
    first, last = axi.sphere.jump_in(**args), axi.sphere.detachment(**args)
    loop = load_path(scene, depths=[*there, *there[::-1]])
    assert [event.kind for event in loop.events] == ["jump-in", "detachment"]
    for event, jump in zip(loop.events, (first, last), strict=True):
        check(event.depth, jump.depth, 1e-11)
        check(event.energy_released, jump.energy_released, 1e-11)
    check(loop.dissipated, first.energy_released + last.energy_released, 1e-11)
    pull = axi.sphere.pull_off(**args)
    pulled = load_path(scene, forces=pull.force * np.array([0.0, 0.5, 0.9, 1.1])).pull_off
    check(pulled.force / (-2 * np.pi * R * W), OF_SPHERE[ratio], 2e-12)
    check(pulled.force, pull.force, 1e-11)
    check(pulled.depth, pull.depth, 1e-9, DELTA0)


def test_a_cylinder_detaches_alike_under_depth_and_load():
    a, depths = 0.7 * ELL, DELTA0 * np.array([-1.0, 0.2, -1.1])
    args = {"a": a, **LAYER}
    gone = axi.flat_punch.detachment(**args)
    loop = load_path(turned(FlatPunch(a)), depths=depths)
    check(loop.events[-1].depth, gone.depth, 1e-12)
    check(loop.events[-1].energy_released, gone.energy_released, 1e-11)
    load = load_path(turned(FlatPunch(a)), forces=gone.force * np.array([0.0, 0.99, 1.01]))
    check(load.pull_off.force, gone.force, 1e-12)
    check(load.pull_off.depth, gone.depth, 1e-12)


@pytest.mark.parametrize("a", [0.3 * ELL, 20 * ELL])
def test_the_lowest_state_leaves_a_cylinder_earlier(a):
    even = float(axi.flat_punch.global_pull_off_depth(a=a, **LAYER))
    for depth, contacts in ((even * (1 - 1e-9), 1), (even * (1 + 1e-9), 0)):
        assert len(minimise(turned(FlatPunch(a)), depth, branch="global").contacts) == contacts
    assert len(minimise(turned(FlatPunch(a)), even * (1 + 1e-9)).contacts) == 1


def test_the_lowest_state_of_a_sphere_is_the_one_of_negative_energy():
    args = {"R": 0.013, **LAYER}
    least = float(axi.sphere.detachment(**args).depth)
    for d in np.linspace(0.999 * least, 0.3 * DELTA0, 12):
        state = minimise(turned(Parabola(0.013)), float(d), branch="global")
        assert bool(state.contacts.size) == (axi.sphere.energy(d, **args) < 0)


@pytest.mark.parametrize("indenter", [Parabola(0.013), PowerLaw(7e5, 3.0), Circle(1e-3)], ids=repr)
def test_without_adhesion_and_without_tension(indenter):
    for share in (1e-3, 0.1, 1.0, 30.0):
        a = min(share * ELL, 9e-4)
        f, slope = float(indenter.height(a)), float(indenter.slope(a))
        bare = axi.contact_line.depth(f, slope, a, k=K, gamma1=GAMMA1, w=0.0)
        check(minimise(turned(indenter, w=0.0), float(bare)).radius, a, 1e-11)
        if f < 1e-4 * DELTA0:  # ill-conditioned without tension
            continue
        alone = minimise(turned(indenter, gamma1=0.0), f - DELTA0, branch="global")
        check(alone.radius, a, 1e-11 * max(1.0, DELTA0 / f))
        force = axi.force.elastic(f - DELTA0, a, f=indenter.height, k=K)
        check(alone.force, force, 1e-11 * max(1.0, DELTA0 / f))


def test_wide_contacts_become_the_line_contact_per_length():
    errors = []
    for ratio in (1e2, 1e3, 1e4):
        flat, c = {"gamma1": K * 1e-6, "w": W}, 1e-3 * ratio
        around = turned(FlatPunch(c), **flat)
        line = Scene(around.layer, around.surfaces, FlatPunch(c))
        pair = minimise(around, -DELTA0 / 2), minimise(line, -DELTA0 / 2)
        per_length = [state.force_parts["lines"] for state in pair]
        errors.append(per_length[0] / (np.pi * c) / per_length[1] - 1)
    check(np.array(errors) * [1e2, 1e3, 1e4], np.full(3, 0.5), 1e-2)  # 1/q = 1 + l/(2a)


def test_a_vanishing_tension_leaves_springs():
    indenter, depth, errors = Parabola(0.013), 0.4 * DELTA0, []
    springs = minimise(turned(indenter, gamma1=0.0), depth, branch="global")
    for ratio in (1e-2, 1e-3, 1e-4):
        state = minimise(turned(indenter, gamma1=K * (ratio * springs.radius) ** 2), depth)
        errors.append(abs(state.radius / springs.radius - 1))
    assert 0.9 < np.log10(errors[0] / errors[2]) / 2 < 1.1
    assert errors[2] < 3e-4


@pytest.mark.parametrize("centre", [0.5, 2.0, 10.0])
def test_a_ring_rests_between_a_free_disc_and_the_surface_outside(centre):
    """A lip f = c (r - r₀)²: two radii and a depth, from both line conditions."""
    r0 = centre * ELL
    c = DELTA0 / (0.3 * r0) ** 2
    lip = Profile(
        lambda x: c * (np.asarray(x) - r0) ** 2,
        lambda x: 2 * c * (np.asarray(x) - r0),
        (0.0, r0 + 20 * ELL),
    )

    def height(r):
        return c * (np.asarray(r) - r0) ** 2

    def defects(radii, d):
        b, a = radii * ELL
        outer = axi.contact_line.depth(height(a), 2 * c * (a - r0), a, **LAYER)
        return [float(outer - d) / DELTA0, float(inner(b) - d) / DELTA0]

    def inner(b):
        return axi.contact_line.inner_depth(height(b), 2 * c * (b - r0), b, **LAYER)

    d = 0.1 * DELTA0
    state = minimise(turned(lip), d)
    (b, a), *more = (state.contacts / ELL).tolist()
    assert not more and 0 < b < centre < a
    exact = fsolve(lambda x: defects(x, d), [b, a], xtol=1e-14)
    assert np.abs(defects(exact, d)).max() < 1e-12
    check(np.array([b, a]), exact, 1e-10)
    free = {"k": K, "gamma1": GAMMA1}
    b, a = exact * ELL
    force = axi.force.elastic(d, a, f=height, k=K) - axi.force.elastic(d, b, f=height, k=K)
    force += axi.surface.force(d - height(a), a=a, **free)
    force += axi.surface.disc_force(d - height(b), b=b, **free)
    check(state.force, force, 1e-10, state.scales["force"])
    check(state.contact_area, np.pi * (a**2 - b**2), 1e-10)
    check(
        state.displacement(b / 2),
        axi.surface.disc_displacement(b / 2, b=b, u_b=d - height(b), **free),
        1e-10,
    )
    assert np.abs(state.angle_deficits - DELTA0 / ELL).max() < 1e-9


@pytest.mark.parametrize("R", [1e-4, 1e-2, 1.0])
def test_the_estimate_is_about_what_rounding_does_also_beside_small_spheres(R):
    """The terms of D that cancel are small there; close to the least D it grows slowly."""
    mpmath.mp.dps = 40
    scene, R, delta0 = turned(Circle(R), 1.0, 1.0, 0.3), mpmath.mpf(R), mpmath.sqrt(0.6)

    def terms(a):
        f, f1 = R - mpmath.sqrt(R * R - a * a), a / mpmath.sqrt(R * R - a * a)
        q = mpmath.besselk(0, a) / mpmath.besselk(1, a)
        return f, f1 * q, -delta0 * q

    def rest(a):
        return sum(terms(a))

    falling = {"solver": "bisect", "verify": False, "maxsteps": 100}
    end = mpmath.findroot(lambda a: mpmath.diff(rest, a), (R * 1e-3, R * 0.9999), **falling)
    least = rest(end)
    for part in (0.5, 1e-3, 1e-6, 1e-9):
        depth = float(least + abs(least) * part)
        state = minimise(scene, depth)
        start = mpmath.asin(state.radius / R)
        a = R * mpmath.sin(mpmath.findroot(lambda t, d=depth: rest(R * mpmath.sin(t)) - d, start))
        felt = mpmath.fsum(map(abs, (depth, *terms(a)))) / mpmath.diff(rest, a) / a
        error, estimate = abs(state.radius / a - 1), state.error_estimate["half_width"]
        assert error <= estimate <= 20 * np.finfo(float).eps * (felt + 1)
