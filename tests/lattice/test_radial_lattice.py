"""Rotational symmetry on nodes: exact ends, the line's rule, and closed forms written here.

d = f(a) - (δ₀ - l f'(a)) q,  P = πk∫₀ᵃ r² f' dr - πk(a²q + 2al)(δ₀ - l f'(a)),
U = π∫₀ᵃ (k(d-f)² + γ₁f'²) r dr + πγ₁(s/q)(d-f(a))² - wπa²,  s = a/l,  q = K₀(s)/K₁(s).
"""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from lattices import over
from scenes import ALPHA, DELTA0, SCENE, L, adhesive, steep
from scipy.integrate import quad
from scipy.special import k0e, k1e

from discretization import minimise
from discretization.lattice.judge import judge, totals
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.radial_spans import rings
from energy import Circle, FlatPunch, Parabola, PowerLaw, Profile, Sampled, Wedge

K, GAMMA1, W = SCENE.stiffness, SCENE.gamma1, SCENE.work_of_adhesion
A = 1.7 * L
BODIES = {
    "parabola": Parabola(A / (0.9 * ALPHA)),
    "cone": Wedge(math.atan(0.6 * ALPHA)),
    "power": PowerLaw(0.3 * ALPHA / A**2, 3.0),
    "circle": Circle(A / (0.9 * ALPHA)),
}


def turned(body, **options):
    return replace(adhesive(body, **options), geometry="axisymmetric")


def expected(scene, a):
    """Depth, force and energy of a contact of radius a."""
    k, gamma1, w, ell = (
        scene.stiffness,
        scene.gamma1,
        scene.work_of_adhesion,
        scene.elastocapillary_length,
    )
    f, slope = scene.indenter.height, scene.indenter.slope
    q, pull = k0e(a / ell) / k1e(a / ell), scene.critical_separation - ell * float(slope(a))
    d = float(f(a)) - pull * q

    def integral(density):
        return quad(density, 0, a, epsabs=0, epsrel=1e-13)[0]

    force = math.pi * k * integral(lambda r: r * r * float(slope(r)))
    force -= math.pi * k * (a * a * q + 2 * a * ell) * pull
    inside = integral(lambda r: r * (k * (d - float(f(r))) ** 2 + gamma1 * float(slope(r)) ** 2))
    tail = gamma1 * a / (ell * q) * (d - float(f(a))) ** 2
    return d, force, math.pi * (inside + tail - w * a * a)


def on_nodes(scene, depth, spacing, **options):
    return minimise(scene, depth, method="lattice", spacing=spacing, **options)


@pytest.mark.parametrize("kappa", [1e-18, 1e-6, 3e-3, 0.4, 2.0, 1e3, 1e9])
@pytest.mark.parametrize("node", [0, 1, 7, 1023, 1024, 5000])
def test_the_outer_surface_is_a_legendre_function(kappa, node):
    with mpmath.workdps(40):
        nu, decay = mpmath.mpf(node) - 0.5, mpmath.exp(-4 * mpmath.asinh(mpmath.sqrt(kappa) / 2))
        ratio = (nu + 1) / (nu + 1.5) * mpmath.sqrt(decay)
        ratio *= mpmath.hyp2f1(0.5, nu + 2, nu + 2.5, decay) / mpmath.hyp2f1(
            0.5, nu + 1, nu + 1.5, decay
        )
        exact = float((node + 0.5) * (1 - ratio))
    assert float(rings(kappa).pull(node, 1)) == pytest.approx(exact, rel=2e-14, abs=0)


@pytest.mark.parametrize("kappa", [1e-12, 1e-6, 3e-3, 0.4, 1e3])
def test_the_inner_surface_is_that_of_all_nodes_to_the_axis(kappa):
    with mpmath.workdps(30):
        spring, pull, exact = mpmath.mpf(kappa) / 8, mpmath.mpf(0), []
        for node in range(1, 3001):
            link, beyond = node - mpmath.mpf(0.5), spring + pull
            pull, spring = link * beyond / (link + beyond), mpmath.mpf(kappa) * node
            exact.append(float(pull))
    found = rings(kappa).pull(np.arange(1, 3001), -1)
    assert found == pytest.approx(np.array(exact), rel=2e-14, abs=0)


def least_energy(scene, spacing, held, g, nodes):
    """The energy of nodes 0..held at g with as many free ones beyond, by elimination."""
    i = np.arange(nodes + 1.0)
    area = 2 * math.pi * spacing**2 * np.where(i > 0, i, 1 / 8)
    link = 2 * math.pi * scene.gamma1 * (i[:-1] + 0.5)
    u = g[: held + 1]
    value = scene.stiffness / 2 * (area[: held + 1] @ u**2) + link[:held] @ np.diff(u) ** 2 / 2
    end = 0.0
    for m in range(nodes - 1, held - 1, -1):
        beyond = scene.stiffness * area[m + 1] + end
        end = link[m] * beyond / (link[m] + beyond)
    return value + end / 2 * u[-1] ** 2 - scene.work_of_adhesion * math.pi * (held * spacing) ** 2


@pytest.mark.parametrize("per_length", [0.7, 5.0, 40.0])
def test_the_advance_of_a_link_is_a_perfect_square(per_length):
    scene, spacing = turned(BODIES["cone"]), L / per_length
    lattice, depth = Lattice.of(scene, spacing), 0.3 * DELTA0
    g = depth - scene.indenter.height(spacing * np.arange(60.0))
    beyond = 60 + math.ceil(25 * per_length)
    for m in (0, 1, 5, 40):
        energies = [least_energy(scene, spacing, held, g, beyond) for held in (m, m + 1)]
        _, rest, stiffness = lattice.beside(m, 1)
        gap = g[m] - g[m + 1] - rest * g[m]
        adhesion = W * math.pi * (2 * m + 1) * spacing**2
        change = stiffness / 2 * gap**2 - adhesion
        size = max(map(abs, energies)) + W * math.pi * ((m + 1) * spacing) ** 2
        assert energies[1] - energies[0] == pytest.approx(change, rel=0, abs=2e-14 * size)


def test_energy_and_force_of_a_contact_set_are_sums_over_all_nodes():
    scene, spacing, depth = turned(BODIES["parabola"]), L / 6, 0.3 * DELTA0
    lattice = Lattice.of(scene, spacing)
    for last in (1, 2, 9, 30):
        f = scene.indenter.height(spacing * np.arange(last + 1.0))
        sums = totals(over(lattice, lattice.seen(scene).indenter, depth, (0, last)))
        low, own, high = (
            least_energy(scene, spacing, last, depth + step - f, last + 300)
            for step in (-0.1 * DELTA0, 0.0, 0.1 * DELTA0)
        )
        assert sums.energy == pytest.approx(own, rel=0, abs=1e-13 * sums.energy_scale)
        for force in (sums.force, sums.force_by_reactions):
            rate = (high - low) / (0.2 * DELTA0)
            assert force == pytest.approx(rate, rel=0, abs=1e-11 * sums.force_scale)


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_second_order_at_the_worst_of_16_offsets(name):
    scene = turned(BODIES[name])
    d, force, energy = expected(scene, A)
    links, worst = np.array([25, 50, 100, 200]), []
    for n in links:
        errors = []
        for offset in np.arange(16) / 16 + 0.02:
            state = on_nodes(scene, d, A / (n + offset))
            assert state.contacts[0, 0] == 0
            assert state.contacts[0, 1] == state.radius
            found = (state.radius / A - 1, state.contact_angle - math.pi + ALPHA)
            errors.append((*found, state.force / force - 1, state.energy / energy - 1))
        worst.append(np.abs(errors).max(axis=0))
    orders = -np.polyfit(np.log(links), np.log(worst), 1)[0]
    assert orders == pytest.approx(np.full(4, 2.0), rel=0, abs=0.2)
    assert (worst[-1] <= 6 / links[-1] ** 2).all()


def test_random_scenes_stay_within_their_own_estimate():
    rng, missed = np.random.default_rng(18), []
    for _ in range(120):
        rise, a = ALPHA * 10 ** rng.uniform(-1, 0.3), L * 10 ** rng.uniform(-1.5, 1.5)
        body = (
            Parabola(a / rise),
            Circle(max(a / rise, 1.5 * a)),
            Wedge(math.atan(rise)),
            PowerLaw(rise / (3 * a * a), 3.0),
        )[rng.integers(4)]
        scene = turned(body, w=W if rng.random() < 0.8 else 0.0)
        d, force, energy = expected(scene, a)
        state = on_nodes(scene, d, a / 10 ** rng.uniform(1.5, 2.5))
        if not state.contacts.size:
            continue  # another, narrower state of this depth, or none
        off = dict(half_width=state.radius - a, force=state.force - force)
        off["energy"] = state.energy - energy
        if abs(off["half_width"]) < 0.1 * a:
            missed.append(max(abs(off[name]) / state.uncertainty[name] for name in off))
    assert len(missed) > 60
    assert np.mean(np.array(missed) <= 1) > 0.95
    assert max(missed) < 3


@pytest.mark.parametrize("depth", [-0.6, 0.0, 1.5])
def test_a_cylinder_holds_the_line_at_its_edge_between_nodes(depth):
    scene, d = turned(FlatPunch(A)), depth * DELTA0
    q = k0e(A / L) / k1e(A / L)
    force = math.pi * K * (A * A + 2 * A * L / q) * d
    errors = []
    for n in (40.3, 80.8, 160.5, 320.7):
        state = on_nodes(scene, d, A / n)
        assert state.contacts.tolist() == [[0.0, A]]
        assert state.pinned.tolist() == [[False, True]]
        errors.append(abs(state.force - force) / (state.scales["force"] or 1))
        assert errors[-1] <= state.error_estimate["force"]
    assert errors[-1] <= 2e-5
    if depth:
        assert np.polyfit(np.log([40.3, 80.8, 160.5, 320.7]), np.log(errors), 1)[0] < -1.7
    critical = -DELTA0 * q
    assert on_nodes(scene, 0.98 * critical, A / 300).contacts.size
    assert not on_nodes(scene, 1.02 * critical, A / 300).contacts.size


def test_springs_alone_let_go_at_the_critical_separation():
    R, d = 0.02, 0.4 * DELTA0
    scene = turned(Parabola(R), gamma1=0.0)
    for branch, level in (("adhered", d), ("global", d + DELTA0)):
        state = on_nodes(scene, d, math.sqrt(2 * R * level) / 150.3, branch=branch)
        a = math.sqrt(2 * R * level)
        assert state.radius == pytest.approx(a, rel=1e-4, abs=0)
        force = math.pi * K * (a * a * d - a**4 / (4 * R))
        assert state.force == pytest.approx(force, rel=1e-4, abs=0)
        energy = math.pi * K * R * (d**3 + (level - d) ** 3) / 3 - math.pi * W * a * a
        assert state.energy == pytest.approx(energy, rel=1e-4, abs=0)


def test_springs_adhere_over_the_area_of_their_nodes():
    lattice = Lattice.of(turned(Parabola(0.02), gamma1=0.0), 0.1)
    for first, last, area in ((0, 0, 0.05**2), (0, 3, 0.35**2), (2, 3, 0.35**2 - 0.15**2)):
        held = np.ones(last - first + 1, bool)
        adhesive = NodalEnergy(lattice, held, first).terms(np.zeros(held.size))["adhesion"]
        assert adhesive == pytest.approx(-W * math.pi * area, rel=1e-14, abs=0)


def test_lengths_and_stresses_have_no_unit():
    unit, stress = 2.0**-21, 2.0**7
    states = []
    for u, s in ((1.0, 1.0), (unit, stress)):
        layer = replace(SCENE.layer, E=SCENE.layer.E * s, h=SCENE.layer.h * u)
        surfaces = type(SCENE.surfaces).from_work(GAMMA1 * s * u, W * s * u)
        scene = replace(turned(Parabola(0.02 * u)), layer=layer, surfaces=surfaces)
        states.append(on_nodes(scene, 0.3 * DELTA0 * u, L / 50 * u))
    one, other = states
    assert other.radius == one.radius * unit
    assert other.force == pytest.approx(one.force * stress * unit**2, rel=1e-14, abs=0)
    assert other.energy == pytest.approx(one.energy * stress * unit**3, rel=1e-14, abs=0)
    assert other.error_estimate == pytest.approx(one.error_estimate, rel=1e-6, abs=0)


@pytest.mark.parametrize("moved", [-1, 1])
def test_a_line_on_another_node_is_not_certified(moved):
    scene, spacing, depth = turned(BODIES["parabola"]), L / 40, 0.2 * DELTA0
    lattice = Lattice.of(scene, spacing)
    body, last = (
        lattice.seen(scene).indenter,
        round(on_nodes(scene, depth, spacing).nodes[0, 1] / spacing),
    )
    for node, fine in ((last, True), (last + moved, False)):
        contacts = over(lattice, body, depth, (0, node))
        assert judge(contacts, totals(contacts)).ok == fine


@pytest.mark.parametrize("name", ["parabola", "cone", "power", "circle", "profile", "samples"])
def test_nodes_and_the_fitted_mesh_agree_within_the_estimates(name):
    r = np.linspace(0, 6 * A, 400)
    bodies = BODIES | {
        "profile": Profile(lambda x: 40 * np.square(x), lambda x: 80 * np.asarray(x), convex=True),
        "samples": Sampled(r, 0.3 * r * r / A, kind="smooth"),
    }
    scene = turned(bodies[name])
    if not scene.indenter.convex:
        pytest.skip("samples of a smooth curve make no promise to be convex")
    for depth in (0.0, 0.5):
        fitted = minimise(scene, depth * DELTA0)
        state = on_nodes(scene, depth * DELTA0, fitted.radius / 130.6)
        assert state.label == fitted.label
        for key, error in state.uncertainty.items():
            assert abs(getattr(state, key) - getattr(fitted, key)) <= error
        x = fitted.radius * np.array([0.0, 0.4, 1.3, 4.0])
        apart = np.abs(state.displacement(x) - fitted.displacement(x))
        assert (apart <= 1e-4 * np.abs(fitted.displacement(x)).max()).all()


def test_what_nodes_around_an_axis_cannot_do_is_refused():
    with pytest.raises(ValueError, match="nodes do not know slopes = 'finite'"):
        on_nodes(replace(steep(Parabola(0.02)), geometry="axisymmetric"), 0.0, 1e-3)
    bumpy = Profile(lambda x: 1e-5 * np.cos(900 * np.asarray(x)), lambda x: 0 * x, extent=(0, 0.02))
    with pytest.raises(ValueError, match=r"nodes do not know .* gamma1 = 0 with a profile that is"):
        on_nodes(turned(bumpy, gamma1=0.0), 0.0, 1e-3)
    with pytest.raises(ValueError, match="or method = 'oracle'; use method='fitted'"):
        minimise(turned(Parabola(0.02)), 0.0, method="oracle", branch="global", spacing=1e-3)
    with pytest.raises(ValueError, match=r"origin = 0\.3: with rotational symmetry"):
        Lattice.of(turned(Parabola(0.02)), 0.1, 0.3)
