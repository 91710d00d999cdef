"""Contacts about an axis that are rings, discs with rings, or the lowest of several discs.

The free surfaces are held against modified Bessel functions, energies against sums over them.
"""

import itertools
import math

import numpy as np
import pytest
from scipy.special import i0, i1, k0, k1
from support.example_scenes import dimple
from truth import meniscus

from discretization import load_path, minimise
from discretization.equilibrium import QUANTITIES
from discretization.fitted.rest_depths import surfaces_of
from discretization.surfaces.protocol import LinePosition
from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Indenter,
    Parabola,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

K = 3.0
LENGTH = 0.05
GAMMA1 = K * LENGTH**2


def scene(profile, alpha=0.1, **options):
    """A layer with l = LENGTH whose lines stop at the kink alpha."""
    surfaces = SurfaceEnergies.from_work(GAMMA1, alpha**2 * GAMMA1 / 2)
    return Scene(ElasticLayer(K, 0.0, 1.0), surfaces, profile, geometry="axisymmetric", **options)


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
    found = []
    lines = state.contacts.ravel()
    f = own.indenter.height
    f1 = own.indenter.slope
    d = state.depth
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
    own = scene(dimple(radius, 0.2))
    state = minimise(own, depth)
    assert len(state.contacts) == 1 and state.contacts[0, 0] > 0
    assert np.abs(kinks(own, state) - 0.1).max() <= 1e-9
    assert np.abs(math.pi - state.contact_angles - 0.1).max() <= 1e-10
    assert state.contact_area == pytest.approx(
        math.pi * (state.contacts[0, 1] ** 2 - state.contacts[0, 0] ** 2), rel=1e-14
    )


def test_a_disc_closes_when_it_is_pressed():
    own = scene(dimple(2.0, 0.2))
    assert minimise(own, 0.1).contacts[0, 0] > 1
    assert minimise(own, 0.2).contacts[0, 0] == 0


def least_energy(own, depth, most, cells=4000, every=20):
    """Of no contact and of all discs and rings up to a radius, each a sum of closed forms."""
    (points, weights), ends = np.polynomial.legendre.leggauss(3), np.linspace(0, most, cells + 1)
    r = ends[:-1, None] + (points + 1) * most / cells / 2
    density = (
        K / 2 * (depth - own.indenter.height(r)) ** 2 + GAMMA1 / 2 * own.indenter.slope(r) ** 2
    )
    whole = 2 * math.pi * r * (density - own.work_of_adhesion) @ weights * most / cells / 2
    up_to = np.append(0.0, np.cumsum(whole))[::every]
    a = ends[::every]
    tail = math.pi * GAMMA1 * (depth - own.indenter.height(a)) ** 2
    s = a[1:] / LENGTH
    within = np.append(0.0, s * i1(s) / i0(s)) * tail
    beyond = s * k1(s) / k0(s) * tail[1:]
    energy = (within - up_to)[:, None] + beyond + up_to[1:]
    g = depth - own.indenter.height(ends)
    x = ends / LENGTH  # no surface is in the indenter
    for i in range(1, a.size):
        n = every * i
        if (g[:n] > g[n] * i0(x[:n]) / i0(x[n]) + 1e-9 * LENGTH).any():
            energy[i] = math.inf
        if (g[n:] > g[n] * k0(x[n:]) / k0(x[n]) + 1e-9 * LENGTH).any():
            energy[:, i - 1] = math.inf
    least = float(energy[np.subtract.outer(a, a[1:]) < 0].min())
    return least if g.max() > 0 else min(0.0, least)


KINKED = np.array([0.0, 1.0, 1.2, 2.5, 6.0]) * LENGTH  # around an axis more than one disc may rest
BOWL = Sampled(KINKED, 0.1 * LENGTH * np.array([0.0, 0.1, 0.4, 3.4, 16.0]))


@pytest.mark.parametrize(
    ("body", "depth", "contacts"),
    [
        *((dimple(1.2 * LENGTH, 0.1 * LENGTH), d, m) for d, m in ((-0.3, 0), (0.0, 1), (1.0, 1))),
        *((BOWL, d, m) for d, m in ((-0.5, 0), (-0.4, 1), (0.4, 1))),
    ],
)
def test_no_disc_or_ring_has_less_energy_than_the_lowest_state(body, depth, contacts):
    own = scene(body)
    depth *= own.critical_separation
    lowest = minimise(own, depth, branch="global")
    off = lowest.energy - least_energy(own, depth, 4 * LENGTH)
    size = max(lowest.scales["energy"], own.work_of_adhesion * LENGTH**2)
    assert len(lowest.contacts) == contacts
    assert -1e-3 * size <= off <= 1e-9 * size


def test_lowest_state_of_a_profile_without_an_end():
    """A wavy paraboloid has the lowest state of one that ends beyond its contact."""
    size = 0.002 * LENGTH
    waves = 1 / (0.4 * LENGTH)

    def height(x):
        return x * x / (8 * LENGTH) + size * (1 - np.cos(waves * x))

    def slope(x):
        return x / (4 * LENGTH) + size * waves * np.sin(waves * x)

    endless, ending = (
        minimise(scene(Profile(height, slope, **end)), 0.0, branch="global")
        for end in ({}, {"extent": (0.0, 20 * LENGTH)})
    )
    np.testing.assert_allclose(endless.contacts, ending.contacts, rtol=1e-9)
    assert endless.radius > 0


@pytest.mark.slow
@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_a_cylinder_is_held_up_to_a_rounding_of_where_it_lets_go(slopes):
    own = scene(FlatPunch(0.06), slopes=slopes)
    last = load_path(own, depths=[0.0, -2 * own.critical_separation]).events[-1].depth
    for part in (1e-6, 1e-9, 1e-12):
        assert minimise(own, last * (1 - part)).radius == 0.06
        assert minimise(own, last * (1 + part)).label == "detached"


def test_certificate_of_a_ring_around_a_small_contact():
    """What the ring stores at its outer line would round by more than the inner one feels."""
    surfaces = SurfaceEnergies.from_work(1.0, 1.1605e-5)
    own = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, crossed(), geometry="axisymmetric")
    state = minimise(own, 0.003)
    assert state.certificate.stationarity <= 1e-10 and len(state.contacts) == 2
    assert 0 < state.contacts[0, 1] < 0.006


@pytest.mark.parametrize("ends", [(0.005, 1.1), (0.9, 1.1), (1.0, 1.0 + 1e-7), (0.3, 6.0)])
def test_the_certificate_of_a_ring_notices_a_wrong_pull(ends):
    surfaces = surfaces_of(scene(Parabola(1.0)))
    q = ends[0]
    width = ends[1] - ends[0]
    left, right = (LinePosition(LENGTH * r, 0.01 * LENGTH * (r + i)) for i, r in enumerate(ends))
    assert surfaces.solve(left, right, 0.02 * LENGTH).residual <= 1e-10
    for one, other in ((0.01, 0.02), (-0.01, -0.0099999)):
        pull = surfaces.net.between(1, q, width).pulls(one, other, one - other)[0]
        assert surfaces._imbalance(1, q, width, one, one - other, pull) <= 1e-10
        assert surfaces._imbalance(1, q, width, one, one - other, 1.0001 * pull) >= 1e-6


axi = cards.axisymmetric
MOST = math.radians(80)


def turned(indenter: Indenter, ell, stress, deficit) -> Scene:
    """Surfaces with this π - θ, in units of `ell` and `stress`."""
    surfaces = SurfaceEnergies.from_work(stress * ell, stress * ell * (1 - math.cos(deficit)))
    layer = ElasticLayer(stress / ell, 0.0, 1.0)
    return Scene(layer, surfaces, indenter, slopes="finite", geometry="axisymmetric")


SHAPES = {  # with the angle β of inclination at the radius a
    "cone": lambda a, beta: Wedge(beta),
    "parabola": lambda a, beta: Parabola(a / math.tan(beta)),
    "sphere": lambda a, beta: Circle(a / math.sin(beta)),
    "power": lambda a, beta: PowerLaw(math.tan(beta) / (3 * a**2), 3.0),
    "sum": lambda a, beta: Parabola(2 * a / math.tan(beta)) + Wedge(math.atan(math.tan(beta) / 2)),
}


def drawn(rng, shape):
    """A stable state: the scene, the radius of its line and what is known of it."""
    while True:
        ell, stress = 10 ** rng.uniform(-4, 4, 2)
        a = ell * 10 ** rng.uniform(-2.5, 1.5)
        deficit = math.radians(rng.uniform(3, 110))
        beta = deficit * rng.uniform(0.05, 1.4)
        if max(beta, abs(deficit - beta)) > MOST:
            continue
        scene = turned(SHAPES[shape](a, beta), ell, stress, deficit)
        try:
            depths = [meniscus.state(scene, a * part, 1e-8).depth for part in (0.9, 0.95, 1.0)]
        except ValueError:
            continue
        if depths[0] < depths[1] < depths[2]:
            return scene, a, meniscus.state(scene, a)


@pytest.mark.slow
@pytest.mark.parametrize("shape", SHAPES)
def test_every_state_is_that_of_the_young_laplace_equation(shape):
    rng = np.random.default_rng(300 + list(SHAPES).index(shape))
    scene, a, exact = drawn(rng, shape)
    state = minimise(scene, exact.depth)
    scales = {"half_width": a, **state.scales}
    known = {"half_width": a, "force": exact.force, "energy": exact.energy}
    for name in QUANTITIES:
        error = abs(getattr(state, name) - known[name]) / scales[name]
        assert error <= 1e-9
        assert error <= 10 * state.error_estimate[name]
    assert abs(state.angle_deficit - scene.surfaces.angle_deficit) <= 1e-9


PINNED = [*itertools.product((7.0, 300.0), (5.0, 80.0)), (3e-3, 40.0), (0.2, 80.0)]
PINNED += [pytest.param(3e-3, 80.0, marks=pytest.mark.slow)]


@pytest.mark.parametrize(("ratio", "degrees"), PINNED)
def test_a_pinned_line_of_a_punch(ratio, degrees):
    phi = math.radians(degrees)
    a = ratio * 3e-5
    scene = turned(FlatPunch(a), 3e-5, 2e3, min(phi * 1.1, 1.5))
    free = meniscus.outside(ratio, phi)
    k = scene.stiffness
    length = 3e-5
    d = -free.height * length
    state = minimise(scene, d)
    force = math.pi * k * a**2 * d - 2 * math.pi * a * scene.gamma1 * math.sin(phi)
    energy = math.pi * a**2 * (k * d**2 / 2 - scene.work_of_adhesion)
    energy += 2 * math.pi * scene.gamma1 * length**2 * free.energy
    assert abs(state.force / force - 1) <= 1e-9
    assert abs(state.energy - energy) <= 1e-9 * state.scales["energy"]
    assert abs(state.angle_deficit - phi) <= 1e-8


def test_surfaces_up_to_86_degrees():
    """A surface is followed until it is inclined by 86 degrees."""
    own = turned(FlatPunch(3.0), 1.0, 1.0, 2.69)
    assert 84 < math.degrees(minimise(own, -1.18).angle_deficit) < 86
    with pytest.raises(ValueError, match="inclined by more than 86°"):
        minimise(own, -1.2)


@pytest.mark.slow
def test_a_sphere_is_wetted_up_to_its_equator():
    """Where Young's angle meets a flat surface, d = R (1 - cos δ), the force is that of springs."""
    R = 0.05
    w = 0.9
    scene = turned(Circle(R), 1.0, 1.0, math.acos(1 - w))
    flat = minimise(scene, R * w)
    assert flat.radius == pytest.approx(R * math.sqrt(1 - (1 - w) ** 2), rel=1e-13, abs=0)
    cap = math.pi * (R * w) ** 2 * (R - R * w / 3)  # ∫ (d - f) dA
    size = scene.stiffness * R**2 * flat.radius
    assert flat.force == pytest.approx(scene.stiffness * cap, rel=0, abs=1e-12 * size)
    depths = [0.0, R * w, 0.06, 0.065]
    for depth, off in zip(depths, (0.1, 6e-3, 4e-4, 6e-6), strict=True):
        state = minimise(scene, depth)
        assert 0 < 1 - state.radius / R < off
        assert max(state.error_estimate.values()) <= 1e-9
    path = load_path(scene, depths=[*depths, *depths[::-1], -0.1])
    assert [event.kind for event in path.events] == ["jump-in", "detachment"]
    assert path.half_width[1] == pytest.approx(flat.radius, rel=1e-13, abs=0)
    assert path.dissipated == pytest.approx(path.work(), rel=1e-9, abs=0)
    with pytest.raises(ValueError, match=r"spreads the contact to x = 0\.05, where the profile"):
        minimise(scene, 0.07)


def test_ring_begins_between_equal_samples():
    """The surface dips into the profile between two samples, of both of which it is clear."""
    layer = ElasticLayer(43.16573, 0.3, 14.25646)
    surfaces = SurfaceEnergies.from_work(20.79, 2.025)
    A = 0.4682390
    q = 2.311797
    R = 5.313663
    body = Profile(
        lambda r: r**2 / (2 * R) + A * (1 - np.cos(q * r)),
        lambda r: r / R + A * q * np.sin(q * r),
        extent=(-24.378, 24.378),
    )
    scene = Scene(layer, surfaces, body, geometry="axisymmetric")
    r = np.linspace(0.0, 4.0, 40001)
    for depth in np.linspace(0.7449, 0.7452, 13):
        state = minimise(scene, depth)
        clear = state.displacement(r) - (depth - body.height(r))
        assert clear.min() > -1e-9 * scene.critical_separation
