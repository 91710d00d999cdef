"""w = 0: the obstacle problem against enumeration, high precision, and its own conditions."""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from lattices import lattice, lowest, obstacle, rough_heights
from scenes import adhesive

from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.radial import RadialLattice
from energy import Parabola, cards

SIZES = (3, 16, 17, 300, 16**3 + 1, 20_000)  # blocks of 16 nodes


def profiles(rng, n):
    """Heights of different character, each above the surface somewhere."""
    x = np.linspace(-1, 1, n)
    return {
        "parabola": 0.5 - x**2,
        "cusp": 0.3 - np.sqrt(np.abs(x)),
        "tilted": 0.2 + 0.4 * x,
        "steps": 0.1 * np.sign(np.sin(9 * x + 1)),
        "waves": 0.2 + np.cos(40 * x) - 2 * x**2,
        "white": rng.normal(size=n) + 2,
        "rough": rough_heights(rng, n) + 0.2,
    }


@pytest.mark.parametrize("n", [3, 6, 9])
def test_equals_the_best_of_all_contact_sets(n):
    rng = np.random.default_rng(n)
    for ell in (0.2, 1.7, 30.0):
        lat, g = lattice(ell), rng.normal(size=n)
        g[rng.integers(n)] = 1.1
        energy, contact, u = lowest(lat, g)
        found = obstacle(lat, g)
        assert found.energy == pytest.approx(energy, rel=1e-12, abs=0)
        assert np.array_equal(found.contact, contact)
        assert np.allclose(found.u, u, rtol=1e-11, atol=0)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("ell", [0.01, 3.0, 200.0, 4e4])
def test_no_penetration_no_tension_and_balance(n, ell):
    rng, lat = np.random.default_rng(n), lattice(ell)
    for name, g in profiles(rng, n).items():
        found = obstacle(lat, g)
        u, p = found.u, found.multipliers
        energy = NodalEnergy(lat, found.contact)
        noise = 1e-14 * (lat.spring + lat.link) * np.abs(g).max()
        assert (u >= g).all() and (p >= 0).all(), name
        assert (u[found.contact] == g[found.contact]).all() and found.contact.any(), name
        assert (p[~found.contact] == 0).all(), name
        assert np.abs(energy.gradient(u) - p).max() <= noise, name
        assert found.energy == pytest.approx(energy.value(u), rel=1e-12, abs=0), name
        force = lat.spring * u.sum() + lat.end_stiffness * (u[0] + u[-1])
        assert found.force == pytest.approx(force, rel=1e-12, abs=0), name


@pytest.mark.parametrize("n", [3, 17, 300, 5000])
@pytest.mark.parametrize("ell", [0.1, 3.0, 400.0])
def test_the_same_around_an_axis(n, ell):
    rng, flat = np.random.default_rng(n), lattice(ell)
    lat = RadialLattice(flat.spacing, 0.0, flat.k, flat.gamma1, 0.0)
    for name, g in profiles(rng, n).items():
        found = obstacle(lat, g)
        u, p, held = found.u, found.multipliers, found.contact
        energy = NodalEnergy(lat, held)
        noise = 1e-13 * n * (lat.spring + lat.link) * np.abs(g).max()
        assert (u >= g).all() and (p >= 0).all() and held.any(), name
        assert (u[held] == g[held]).all() and (p[~held] == 0).all(), name
        assert np.abs(energy.gradient(u) - p).max() <= noise, name
        assert found.energy == pytest.approx(energy.value(u), rel=1e-12, abs=0), name


def solve_exactly(lat, g, held):
    """u and nodal forces in 40 digits, held at g on some nodes: double sweep, exact ends."""
    mpmath.mp.dps = 40
    s, t = mpmath.mpf(lat.k) * lat.spacing, mpmath.mpf(lat.gamma1) / lat.spacing
    end = t * (1 - mpmath.exp(-2 * mpmath.asinh(mpmath.sqrt(s / t) / 2)))
    n, ratio, shift = g.size, [], []
    for i in range(n):
        if held[i]:
            ratio.append(mpmath.mpf(0))
            shift.append(mpmath.mpf(g[i]))
            continue
        diagonal = s + (t if i < n - 1 else end) + (t * (1 - ratio[-1]) if i else end)
        ratio.append(t / diagonal)
        shift.append(t * shift[-1] / diagonal if i else mpmath.mpf(0))
    u = [mpmath.mpf(0)] * (n + 1)
    for i in reversed(range(n)):
        u[i] = shift[i] + (ratio[i] * u[i + 1] if i < n - 1 else 0)
    u = u[:n]
    left = [end * u[0]] + [t * (u[i] - u[i - 1]) for i in range(1, n)]
    right = [t * (u[i] - u[i + 1]) for i in range(n - 1)] + [end * u[-1]]
    return u, [s * u[i] + left[i] + right[i] for i in range(n)]


@pytest.mark.parametrize("ell", [2.0, 1e3, 1e6, 1e8])
def test_keeps_its_digits_as_l_over_spacing_grows(ell):
    lat = lattice(ell)
    two = np.full(400, -math.inf)
    two[50], two[350] = 0.3, 0.3 * (1 - 100 / ell)
    parabola = 0.3 - np.linspace(-1, 0.8, 400) ** 2
    for g in (two, parabola, rough_heights(np.random.default_rng(8), 400)):
        found = obstacle(lat, g)
        u, p = solve_exactly(lat, g, found.contact)
        scale = max(p)
        # the exact surface of that contact set penetrates and pulls nowhere: it is the minimum
        assert min(a - b for a, b in zip(u, g, strict=True)) >= 0
        assert min(p) >= -1e-30 * scale
        assert max(abs(a / b - 1) for a, b in zip(found.u, u, strict=True)) <= 2e-13
        wrong = max(abs(a - b) for a, b in zip(found.multipliers, p, strict=True))
        assert wrong <= 1e-13 * scale
        assert abs(found.force / sum(p) - 1) <= 1e-12


def test_does_not_depend_on_units():
    g = rough_heights(np.random.default_rng(2), 5000)
    here = obstacle(lattice(40.0), g)
    for length, stress in ((1e3, 1e-6), (7e-7, 3e5)):
        lat = lattice(40.0, k=37.0 * stress / length, spacing=0.03 * length)
        there = obstacle(lat, g * length)
        assert np.array_equal(there.contact, here.contact)
        assert np.allclose(there.u / length, here.u, rtol=1e-12, atol=0)
        assert there.energy == pytest.approx(here.energy * stress * length**2, rel=1e-12, abs=0)


def test_mirror_image():
    g = rough_heights(np.random.default_rng(4), 7013)
    one, other = obstacle(lattice(25.0), g), obstacle(lattice(25.0), g[::-1])
    assert np.array_equal(one.contact, other.contact[::-1])
    assert np.array_equal(one.intervals, 7012 - other.intervals[::-1, ::-1])
    assert np.allclose(one.u, other.u[::-1], rtol=1e-13, atol=0)


def test_two_contacts_far_apart_are_two_single_ones():
    lat, n = lattice(20.0), 4000
    i = np.arange(n)
    left, right = 0.3 - 1e-4 * (i - 900) ** 2, 0.2 - 3e-5 * (i - 3000) ** 2
    both = obstacle(lat, np.maximum(left, right))
    one, other = obstacle(lat, left), obstacle(lat, right)
    assert len(both.intervals) == 2
    assert np.array_equal(both.contact, one.contact | other.contact)
    assert both.energy == pytest.approx(one.energy + other.energy, rel=1e-13, abs=0)
    assert both.force == pytest.approx(one.force + other.force, rel=1e-13, abs=0)
    near = obstacle(lat, np.maximum(left, np.roll(right, -1990)))
    assert near.energy < 0.97 * (one.energy + other.energy)


def test_a_lone_node_carries_two_tails():
    lat, g = lattice(6.0), np.full(301, -math.inf)
    g[100] = 0.02
    found = obstacle(lat, g)
    assert found.intervals.tolist() == [[100, 100]]
    expected = 0.02 * np.exp(-lat.log_decay * np.abs(np.arange(301) - 100))
    assert np.allclose(found.u, expected, rtol=1e-13, atol=0)
    force = 0.02 * (lat.spring + 2 * lat.end_stiffness)
    assert found.force == pytest.approx(force, rel=1e-14, abs=0)


def test_parabola_equals_the_closed_form():
    scene, depth = adhesive(Parabola(0.3), w=0.0), 0.02
    material = {"k": scene.stiffness, "gamma1": scene.gamma1, "R": 0.3}
    a = float(cards.nonadhesive.parabola_half_width(depth, **material))
    force = float(cards.nonadhesive.parabola_force(depth, **material))
    errors = []
    for links in (250, 1000, 4000):
        lat = Lattice.of(scene, a / links)
        x = lat.x(np.arange(-2 * links, 2 * links + 1))
        found = obstacle(lat, depth - x**2 / 0.6)
        ((first, last),) = found.intervals
        assert abs((last - first) / 2 - links) <= 1
        errors.append(abs(found.force / force - 1))
    assert errors[-1] < 1e-6 and errors[-1] < errors[0] / 100


def test_without_tension_or_contact():
    g = np.array([-1.0, 0.5, 0.0, 0.25])
    found = obstacle(replace(lattice(3.0), gamma1=0.0), g)
    assert found.u.tolist() == [0, 0.5, 0, 0.25]
    assert found.contact.tolist() == [False, True, False, True]
    assert found.multipliers[1] == pytest.approx(37.0 * 0.03 * 0.5, rel=1e-14, abs=0)
    detached = obstacle(lattice(3.0), g - 0.5)
    assert not detached.u.any() and not detached.contact.any() and detached.force == 0
    assert detached.intervals.shape == (0, 2)
