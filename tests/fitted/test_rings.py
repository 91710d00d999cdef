"""Contacts about an axis that are rings, discs with rings, or the lowest of several discs.

The free surfaces are held against modified Bessel functions, energies against sums over them.
"""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import i0, i1, k0, k1

from discretization import load_path, minimise
from discretization.surfaces import surfaces_of
from discretization.surfaces.protocol import At
from energy import ElasticLayer, FlatPunch, Parabola, Profile, Scene, SurfaceEnergies

K, LENGTH = 3.0, 0.05
GAMMA1 = K * LENGTH**2


def scene(profile, alpha=0.1, **options):
    """A layer with l = LENGTH whose lines stop at the kink alpha."""
    surfaces = SurfaceEnergies.from_work(GAMMA1, alpha**2 * GAMMA1 / 2)
    return Scene(ElasticLayer(K, 0.0, 1.0), surfaces, profile, geometry="axisymmetric", **options)


def dimpled(height, radius):
    """A fourth-order profile with its lowest ring at a radius, and a height in the middle."""
    return Profile(
        lambda x: height * (np.asarray(x) ** 2 / radius**2 - 1) ** 2,
        lambda x: 4 * height * np.asarray(x) / radius**2 * (np.asarray(x) ** 2 / radius**2 - 1),
        extent=(-3 * radius, 3 * radius),
    )


def waved(height=0.01, wave=0.2, radius=1.0):
    """A paraboloid with rings of waves."""
    q = 2 * math.pi / wave
    return Profile(
        lambda x: np.asarray(x) ** 2 / (2 * radius) + height * (1 - np.cos(q * np.asarray(x))),
        lambda x: np.asarray(x) / radius + height * q * np.sin(q * np.asarray(x)),
        extent=(-2, 2),
    )


def crossed():
    """Waves of two lengths on a paraboloid: beside its ring a point touches, on the axis."""
    waves = ((0.0115930, 6.8916532), (-0.0619500, 5.7500399))

    def height(x):
        own = np.asarray(x) ** 2 / 145.238
        return own + sum(size * np.cos(q * np.asarray(x)) for size, q in waves)

    def slope(x):
        own = 2 * np.asarray(x) / 145.238
        return own - sum(size * q * np.sin(q * np.asarray(x)) for size, q in waves)

    least = height(1.1241150149)
    return Profile(lambda x: height(x) - least, slope, extent=(-10, 10))


def kinks(own, state):
    """f' + u' outwards at every line, of surfaces of Bessel functions between the lines."""
    found, lines = [], state.contacts.ravel()
    f, f1, d = own.indenter.height, own.indenter.slope, state.depth
    ends = [(None, lines[0]), *zip(lines[1:-1:2], lines[2:-1:2], strict=True), (lines[-1], None)]
    for q, p in ends:
        if p is not None and p == 0:
            continue
        known = [x for x in (q, p) if x is not None]
        shapes = [
            g for g, end in ((lambda r: i0(r / LENGTH), p), (lambda r: k0(r / LENGTH), q)) if end
        ]
        rates = [
            g for g, end in
            ((lambda r: i1(r / LENGTH) / LENGTH, p), (lambda r: -k1(r / LENGTH) / LENGTH, q)) if end
        ]  # fmt: skip
        parts = np.linalg.solve([[g(x) for g in shapes] for x in known], [d - f(x) for x in known])
        for x in known:
            side = 1 if x == q else -1
            slope = sum(part * g(x) for part, g in zip(parts, rates, strict=True))
            found.append(side * float(f1(x)) + side * float(slope))
    return np.array(found)


@pytest.mark.parametrize("radius", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("depth", [-0.0005, 0.0, 0.01, 0.1])
def test_both_lines_of_a_ring_stop_at_the_kink(radius, depth):
    own = scene(dimpled(0.2, radius))
    state = minimise(own, depth)
    assert len(state.contacts) == 1 and state.contacts[0, 0] > 0
    assert np.abs(kinks(own, state) - 0.1).max() <= 1e-9
    assert np.abs(math.pi - state.contact_angles - 0.1).max() <= 1e-10
    assert state.contact_area == pytest.approx(
        math.pi * (state.contacts[0, 1] ** 2 - state.contacts[0, 0] ** 2), rel=1e-14
    )


def test_a_disc_closes_when_it_is_pressed():
    own = scene(dimpled(0.2, 2.0))
    assert minimise(own, 0.1).contacts[0, 0] > 1
    assert minimise(own, 0.2).contacts[0, 0] == 0


@pytest.mark.parametrize("alpha", [0.1, 0.0])
def test_lines_of_a_disc_and_a_ring_stop_at_the_kink(alpha):
    own = scene(waved(), alpha)
    state = minimise(own, 0.03)
    assert len(state.contacts) == 2 and state.contacts[0, 0] == 0
    assert np.abs(kinks(own, state) - alpha).max() <= 1e-9
    step = 1e-6
    rise = minimise(own, 0.03 + step).energy - minimise(own, 0.03 - step).energy
    assert rise / (2 * step) == pytest.approx(state.force, rel=1e-8)
    for parts, whole in ((state.force_parts, state.force), (state.energy_parts, state.energy)):
        size = sum(map(abs, parts.values()))
        assert abs(sum(parts.values()) - whole) <= 1e-10 * size


@pytest.mark.parametrize("seed", range(3))
def test_loops_of_rings_balance(seed):
    rng = np.random.default_rng(seed)
    profile = waved(10 ** rng.uniform(-2.5, -1.8), rng.uniform(0.15, 0.3))
    own = scene(profile, rng.uniform(0.05, 0.15))
    depths = np.concatenate([np.linspace(-0.01, 0.06, 40), np.linspace(0.06, -0.06, 60)])
    path = load_path(own, depths=depths)
    assert path.force[-1] == 0 and len(path.events) >= 2
    assert abs(path.work() - path.dissipated) <= 1e-11 * np.abs(path.energy).max()


def energy(own, depth, a):
    """U of a disc of radius a, by integrals over the profile and Bessel functions."""
    f, f1, w = own.indenter.height, own.indenter.slope, own.work_of_adhesion

    def density(r):
        return (K / 2 * (depth - f(r)) ** 2 + GAMMA1 / 2 * f1(r) ** 2 - w) * 2 * math.pi * r

    s = a / LENGTH
    free = math.pi * GAMMA1 * s * k1(s) / k0(s) * (depth - float(f(a))) ** 2
    return quad(density, 0, a, epsabs=1e-15, limit=200)[0] + free


def clear(own, depth, a):
    """Whether the free surface beside a disc of radius a does not start through the indenter."""
    s, u = a / LENGTH, depth - float(own.indenter.height(a))
    return float(own.indenter.slope(a)) >= u * k1(s) / k0(s) / LENGTH


@pytest.mark.parametrize("depth", [0.01, 0.0, -0.001, -0.002, -0.004])
@pytest.mark.parametrize(
    "profile",
    [
        Parabola(1.0),
        Parabola(0.3) + FlatPunch(0.1),
        Profile(lambda x: np.cosh(x) - 1, np.sinh, convex=True),
    ],
)
def test_the_lowest_state_of_a_convex_profile_is_no_higher_than_any_disc(profile, depth):
    own = scene(profile)
    state = minimise(own, depth, branch="global")
    edge = min(0.4, own.indenter.extent[1])
    radii = [a for a in np.linspace(1e-4, edge, 400) if clear(own, depth, a)]
    discs = [energy(own, depth, a) for a in radii]
    lowest = min([*discs, *([0.0] if depth <= 0 else [])])
    assert state.energy <= lowest + 1e-12 * state.scales["energy"]
    assert state.energy >= lowest - 1e-3 * abs(lowest) - 1e-12


def test_of_other_profiles_the_lowest_state_is_found_with_small_slopes():
    lowest, adhered = (minimise(scene(waved()), 0.03, branch=way) for way in ("global", "adhered"))
    assert lowest.energy <= adhered.energy + 1e-12 * adhered.scales["energy"]
    assert lowest.label in ("global", "detached")
    with pytest.raises(ValueError, match=r"branch = 'global' .* only found for slopes='small'"):
        minimise(scene(waved(), slopes="finite"), 0.03, branch="global")


def test_rings_between_contacts_with_finite_slopes_are_refused_in_words():
    with pytest.raises(ValueError, match="ring of free surface between two is not implemented"):
        minimise(scene(waved(), slopes="finite"), 0.02)


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_a_cylinder_is_held_up_to_a_rounding_of_where_it_lets_go(slopes):
    own = scene(FlatPunch(0.06), slopes=slopes)
    last = load_path(own, depths=[0.0, -2 * own.critical_separation]).events[-1].depth
    for part in (1e-6, 1e-9, 1e-12):
        assert minimise(own, last * (1 - part)).radius == 0.06
        assert minimise(own, last * (1 + part)).label == "detached"


def test_a_ring_around_a_small_contact_is_certified_by_what_is_beside_it():
    """What the ring stores at its outer line would round by more than the inner one feels."""
    surfaces = SurfaceEnergies.from_work(1.0, 1.1605e-5)
    own = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, crossed(), geometry="axisymmetric")
    state = minimise(own, 0.003)
    assert state.certificate.stationarity <= 1e-10 and len(state.contacts) == 2
    assert 0 < state.contacts[0, 1] < 0.006
    errors = []
    for spacing in (4e-4, 2e-4, 1e-4):
        nodes = minimise(own, 0.003, method="lattice", spacing=spacing)
        errors.append(np.abs(nodes.contacts - state.contacts).max())
        assert nodes.force == pytest.approx(state.force, rel=1e-2 * spacing / 1e-4)
    assert errors[-1] <= 2e-5


@pytest.mark.parametrize("ends", [(0.005, 1.1), (0.9, 1.1), (1.0, 1.0 + 1e-7), (0.3, 6.0)])
def test_the_certificate_of_a_ring_notices_a_wrong_pull(ends):
    surfaces = surfaces_of(scene(Parabola(1.0)))
    q, width = ends[0], ends[1] - ends[0]
    left, right = (At(LENGTH * r, 0.01 * LENGTH * (r + i)) for i, r in enumerate(ends))
    assert surfaces.free(left, right, 0.02 * LENGTH).residual <= 1e-10
    for one, other in ((0.01, 0.02), (-0.01, -0.0099999)):
        pull = surfaces.net.between(1, q, width).pulls(one, other, one - other)[0]
        assert surfaces._off(1, q, width, one, one - other, pull) <= 1e-10
        assert surfaces._off(1, q, width, one, one - other, 1.0001 * pull) >= 1e-6
