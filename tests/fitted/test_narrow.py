"""Contacts far narrower than l: power laws that are all but wedges, needles about an axis."""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from support.comparison import check
from support.example_scenes import plain
from truth.meniscus import state as meniscus

from discretization import load_path, minimise
from energy import ElasticLayer, PowerLaw, Profile, Scene, SurfaceEnergies, Wedge, cards

EXPONENTS = (1.0001, 1.001, 1.01, 1.05, 1.1)
DELTA0 = 0.2  # √(2w/k) of `plain`
DEPTHS = (-0.199, -0.19, -0.1, -0.01, 0.0, 0.1, 0.3, 0.7)


def exact(c, n, d, w="0.02"):
    """ln a, P and U of k = γ₁ = l = 1, to 30 digits: c aⁿ⁻¹ (a + n) = d + δ₀."""
    with mpmath.workdps(40):
        c, n, d, w = (
            mpmath.mpf(repr(v)) if isinstance(v, float) else mpmath.mpf(v) for v in (c, n, d, w)
        )
        delta0 = mpmath.sqrt(2 * w)

        def off(t):
            a = mpmath.exp(t)
            return mpmath.log(c * (a + n)) + (n - 1) * t - mpmath.log(d + delta0)

        # off is convex and grows: Newton's steps from the right of the zero decrease to it
        t = mpmath.mpf(10)
        for _ in range(100):
            a = mpmath.exp(t)
            t -= off(t) / (a / (a + n) + n - 1)
        a = mpmath.exp(t)
        u_a = d - c * a**n
        force = 2 * (a + 1) * u_a + 2 * c * a ** (n + 1) * n / (n + 1)
        s = n * c * a ** (n - 1)
        springs = (
            d * d * a - 2 * c * d * a ** (n + 1) / (n + 1) + c * c * a ** (2 * n + 1) / (2 * n + 1)
        )
        energy = springs + s * s * a / (2 * n - 1) + u_a**2 - 2 * w * a
        return float(t), float(force), float(energy)


def in_units(length, stress, c, n, **options):
    """The same scene with other units, its lengths and stresses these times as large."""
    return plain(PowerLaw(c * length ** (1 - n), n), length=length, stress=stress, **options)


@pytest.mark.parametrize("n", EXPONENTS)
@pytest.mark.parametrize("c", [0.15, 0.5])
@pytest.mark.parametrize(("length", "stress"), [(1.0, 1.0), (3e-6, 2e4)])
def test_power_laws_all_but_wedges(c, n, length, stress):
    scene = in_units(length, stress, c, n)
    for d in DEPTHS:
        log_a, force, energy = exact(c, n, d)
        state = minimise(scene, d * length)
        assert state.contacts.size, d
        check(state.force / (stress * length), force, 1e-12, DELTA0)
        check(state.energy / (stress * length**2), energy, 1e-12, DELTA0**2)
        if log_a > -600:
            assert abs(math.log(state.half_width / length) - log_a) <= 1e-9
        else:
            assert state.half_width <= 1e-250 * length


@pytest.mark.parametrize(
    ("c", "n", "d", "force"),
    [
        (0.15, 1.01, -0.19, -0.38),
        (0.15, 1.0001, -0.1, -0.2),
        (0.5, 1.0001, 0.1, 0.2),
        (0.5, 1.001, -0.19, -0.38),
    ],
)
def test_point_contact_is_a_wedge_pinned_at_its_tip(c, n, d, force):
    """The contact of a point pulls like a wedge pinned at its tip."""
    state = minimise(plain(PowerLaw(c, n)), d)
    check(state.force, force, 1e-12)
    check(state.force, cards.power_law.force(d, c=c, n=n, k=1.0, gamma1=1.0, w=0.02), 1e-12)
    check(state.energy, d * d, 1e-12)


def test_beyond_the_critical_separation_a_point_lets_go():
    for n in EXPONENTS:
        assert not minimise(plain(PowerLaw(0.5, n)), -1.001 * DELTA0).contacts.size


def test_a_kink_that_nobody_named_is_no_point_that_adheres():
    kink = Profile(lambda x: 0.5 * np.abs(x), lambda x: 0.5 * np.sign(x), convex=True)
    assert not minimise(plain(kink), -0.1).contacts.size


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("n", [1.001, 1.05])
def test_finite_slopes_of_a_point(n, slopes):
    # nothing is steeper than the free surface: d = -2l sin(φ/2), P = -2γ₁ sin φ
    state = minimise(plain(PowerLaw(0.5, n), slopes=slopes), -0.19)
    phi = 2 * math.asin(0.19 / 2)
    check(state.force, -2 * math.sin(phi) if slopes == "finite" else -0.38, 1e-12)


SLOW = [pytest.param(n, marks=pytest.mark.slow) for n in (1.0001, 1.001)]


@pytest.mark.parametrize("n", [*SLOW, 1.01, 1.05, 1.1])
def test_loads_on_power_laws_all_but_wedges(n):
    forces = [0.0, 0.3, 0.6, 0.0, -0.1, -0.3, -0.39, -0.41]
    path = load_path(plain(PowerLaw(0.5, n)), forces=forces)
    for d, P, given in zip(path.depth[:-1], path.force, forces, strict=False):
        check(P, given, 1e-11, DELTA0)
        check(exact(0.5, n, float(d))[1], given, 1e-11, DELTA0)
    assert [event.kind for event in path.events][1:] == ["pull-off"]
    check(path.events[-1].force, -2 * DELTA0, 1e-9)
    check(path.events[-1].depth, -DELTA0, 1e-9)
    check(path.work(), path.dissipated, 1e-9, DELTA0**2)


@pytest.mark.parametrize("n", [*SLOW, 1.01, 1.05, 1.1])
@pytest.mark.parametrize("c", [0.15])
def test_machines_and_depths_on_power_laws_all_but_wedges(c, n):
    scene = plain(PowerLaw(c, n))
    K = 2.0
    path = load_path(scene, drives=[0.0, 0.3, 0.1, -0.1, -0.7], machine_stiffness=K)
    for d, P, drive, a in zip(path.depth, path.force, path.values, path.half_width, strict=True):
        check(P, K * (drive - d), 1e-11, DELTA0)
        if a or drive > -0.7:
            check(P, exact(c, n, float(d))[1], 1e-11, DELTA0)
    assert path.force[-1] == 0
    path = load_path(scene, depths=[0.0, 0.4, 0.1, -0.1, -0.19, -0.25])
    expected = [exact(c, n, float(d))[1] for d in path.depth[:-1]]
    check(path.force[:-1], expected, 1e-11, DELTA0)
    check(path.events[-1].depth, -DELTA0, 1e-9)
    check(path.work(), path.dissipated, 1e-9, DELTA0**2)


@pytest.mark.parametrize("n", EXPONENTS)
@pytest.mark.parametrize("c", [0.15, 0.5])
def test_power_laws_all_but_cones(c, n):
    given = {"c": c, "n": n, "k": 1.0, "gamma1": 1.0, "w": 0.02}
    card = cards.axisymmetric.power_law
    scene = replace(plain(PowerLaw(c, n)), geometry="axisymmetric")
    path = load_path(scene, depths=[0.1, 0.4, 0.1])
    for d, P, a in zip(path.depth.tolist(), path.force, path.half_width, strict=True):
        check(d, card.depth(a, **given), 1e-12, DELTA0)
        check(P, card.force(d, **given), 1e-11, DELTA0)
    touching = minimise(scene, 0.0)
    if c == 0.5:  # the line is next to the axis, where slope and adhesion all but balance
        assert touching.half_width <= 1e-4
        assert abs(touching.force) <= 1e-3 * DELTA0
    else:
        check(touching.force, card.force(0.0, **given), 1e-11, DELTA0)


def needle(delta, ratio):
    layer = ElasticLayer(1.0, 0.0, 1.0)
    surfaces = SurfaceEnergies.from_work(1.0, ratio)
    return Scene(layer, surfaces, Wedge(delta), slopes="finite", geometry="axisymmetric")


@pytest.mark.parametrize(
    ("delta", "ratio"), [(1.5, 0.5), (1.5, 1.99), (1.56, 1.5), (1.57, 0.5), (1.5707, 1.99)]
)
def test_needles_against_the_equation_of_young_and_laplace(delta, ratio):
    scene = needle(delta, ratio)
    for d in (0.1, 2.0):
        state = minimise(scene, d)
        truth = meniscus(scene, state.radius)
        check(d, truth.depth, 1e-9)
        check(state.force, truth.force, 1e-8, 2 * math.pi * state.radius)
        check(state.energy, truth.energy, 1e-8, 2 * math.pi * state.radius * d)
        check(state.contact_angle, scene.surfaces.contact_angle, 1e-8)


def test_a_needle_that_has_only_just_touched():
    # a ≪ l: |u_a| = a sin φ (ln(4l/(a(1 + cos φ))) - γ_E) = a tan δ
    delta = 1.5
    phi = math.pi / 2 - delta
    state = minimise(needle(delta, 1.0), 0.0)
    expected = math.log(4 / (1 + math.cos(phi))) - np.euler_gamma - math.tan(delta) / math.sin(phi)
    assert abs(math.log(state.radius) - expected) <= 1e-7
    state = minimise(needle(1.57, 1.99), 0.0)  # narrower than doubles
    assert state.radius == state.force == state.energy == 0


@pytest.mark.parametrize(("delta", "ratio"), [(1.5, 1.999), (1.57, 1.999), (1.2, 1.99)])
def test_needles_whose_surface_would_stand_upright(delta, ratio):
    with pytest.raises(ValueError, match="more than 86°"):
        minimise(needle(delta, ratio), 0.1)
