"""The reference solutions of tests/truth, tested before they are used."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support import paths_without_adhesion
from support.example_scenes import adhesive, plain, rippled, steep

from energy import Parabola, Profile, Wedge, cards
from truth import sets
from truth.compare import penetration
from truth.ground import Ground
from truth.obstacle import obstacle, springs
from truth.random_states import case_of
from truth.surfaces import surface_of
from truth.totals import adhered, imbalance
from truth.walk import Walk

R = 0.02
BODY = Profile(Parabola(R).height, Parabola(R).slope, extent=(-0.2, 0.2))


@pytest.mark.parametrize("level", [-0.9999, -0.9, -0.3, 0.0, 1e-4, 0.5, 3.0])
def test_parabola_of_small_slopes(level):
    scene = adhesive(BODY)
    depth = level * scene.critical_separation
    given = {"R": R, **material(scene)}
    found = adhered(Walk(scene, 0.01), depth)
    a = cards.parabola.half_width(depth, **given)
    P, U = (getattr(cards.parabola, name)(depth, **given) for name in ("force", "energy"))
    near = R * scene.surfaces.angle_deficit if level < -0.99 else 0.0  # where a falls steeply
    assert np.abs(found.contacts - [-a, a]).max() <= 1e-12 * (a + near)
    assert abs(found.force - P) <= 1e-12 * found.force_scale
    assert abs(found.energy - U) <= 1e-12 * found.energy_scale
    assert not adhered(Walk(scene, 0.01), -1.0001 * scene.critical_separation).contacts.size


def material(scene):
    return {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}


@pytest.mark.parametrize("level", [-0.9, -0.3, 0.5, 2.0])
def test_parabola_of_finite_slopes(level):
    scene = steep(BODY)
    depth = level * scene.critical_separation
    k = scene.stiffness
    found = adhered(Walk(scene, 0.01), depth)
    a = found.half_width
    exact = cards.finite.depth(a * a / (2 * R), a / R, **material(scene))
    assert abs(exact - depth) <= 1e-12 * abs(depth)
    free = cards.finite.surface_force(depth - a * a / (2 * R), k=k, gamma1=scene.gamma1)
    P = 2 * k * (depth * a - a**3 / (6 * R)) + free
    assert abs(found.force - P) <= 1e-12 * found.force_scale


@pytest.mark.parametrize("level", [0.1, 0.4, 0.8])
def test_a_steep_wedge_is_pinned_at_its_tip(level):
    body = Wedge(math.atan(3.0 * adhesive(BODY).surfaces.small_slope_deficit))
    scene = adhesive(Profile(body.height, body.slope, (-0.1, 0.1), (0.0,)))
    depth = level * 2 * scene.critical_separation  # l tan δ - δ₀ = 2δ₀
    found = adhered(Walk(scene, 0.01), depth)
    assert found.contacts.tolist() == [[0.0, 0.0]]
    P = 2 * scene.stiffness * scene.elastocapillary_length * depth
    assert abs(found.force - P) <= 1e-13 * P


def test_gaps_of_finite_slopes_solve_their_equation():
    surface = surface_of(plain(BODY, w=0.01, slopes="finite"))
    for left, right, width in [(0.3, 0.35, 0.1), (0.8, -0.5, 1.0), (1.2, 1.1, 3.0), (-0.3, 0.2, 6)]:
        x = np.linspace(0, width, 401)
        tilt = surface.facing(left, right, width)
        solved = solve_ivp(
            lambda _, y: [math.tan(y[1]), y[0] / math.cos(y[1])],
            (0, width), [left, tilt], t_eval=x, rtol=1e-12, atol=1e-14,
        )  # fmt: skip
        u, angle = solved.y
        assert np.abs(surface.gap_shape(x, width, left, right) - u).max() <= 3e-9
        assert abs(surface.facing(right, left, width) + angle[-1]) <= 3e-9
        area = math.sin(angle[-1]) - math.sin(tilt)
        assert abs(surface.gap_area(left, right, width) - area) <= 3e-9
        fine = surface.gap_shape(np.array([width / 3, 2 * width / 3]), width, left, right)
        parts = [(left, fine[0]), (fine[0], fine[1]), (fine[1], right)]
        energy = sum(surface.gap_energy(float(a), float(b), width / 3) for a, b in parts)
        assert abs(surface.gap_energy(left, right, width) - energy) <= 1e-11 * energy


@pytest.mark.parametrize("depth", [1e-9, 1e-4, 1e-3])
def test_no_adhesion_parabola(depth):
    scene = adhesive(BODY, w=0.0)
    found = obstacle(scene, 0.01, depth)
    card = cards.nonadhesive
    given = {"R": R, "k": scene.stiffness, "gamma1": scene.gamma1}
    a = card.parabola_half_width(depth, **given)
    P = card.parabola_force(depth, **given)
    assert abs(found.half_width - a) <= 1e-11 * a
    assert abs(found.force - P) <= 1e-12 * P


def test_springs_of_a_parabola():
    scene = adhesive(BODY, gamma1=0.0)
    depth = 1e-3
    k = scene.stiffness
    w = scene.work_of_adhesion
    a = math.sqrt(2 * R * depth)
    found = springs(scene, 0.01, depth)
    assert abs(found.half_width - a) <= 1e-13 * a
    assert abs(found.force - 4 / 3 * k * depth * a) <= 1e-13 * found.force
    energy = 8 / 15 * k * depth**2 * a - 2 * w * a
    assert abs(found.energy - energy) <= 1e-13 * found.energy_scale


def test_no_adhesion_has_pressure_inside_and_clearance_outside():
    """Which is sufficient, as the problem is convex."""
    cases = [case_of("no_adhesion", seed) for seed in range(40)]
    several = [pressed(case.scene, case.feature, case.depth, case.scale) > 1 for case in cases]
    assert sum(several) >= 10


@pytest.mark.parametrize(
    ("kind", "seed"), [("polygon", s) for s in (104, 107, 115, 125, 131, 136)] + [("plateau", 15)]
)
def test_no_contact_is_lost_at_a_corner_next_to_a_node(kind, seed):
    scene, feature, low, depths = paths_without_adhesion.case(kind, seed)
    for depth in depths[depths > low + 0.01 * (depths.max() - low)].tolist():
        pressed(scene, feature, depth, depth - low)


def pressed(scene, feature, depth, scale):
    """How many contacts: clearance outside, pressure inside, lines that push or nothing."""
    ground = Ground(scene.indenter, feature)
    surface = surface_of(scene)
    contacts = obstacle(scene, feature, depth).contacts
    lines = contacts.ravel()
    assert not sets.dips(lines, depth, ground, surface, scene)
    assert (imbalance(lines, depth, ground, surface) >= -1e-9 * scale / surface.length).all()
    for left, right in contacts:
        x = np.linspace(left, right, 101)
        g = depth - scene.indenter.height(x)
        pull = np.diff(scene.indenter.slope(x)) * scene.gamma1  # of γ₁ f'' over each part
        push = scene.stiffness * (g[1:] + g[:-1]) / 2 * np.diff(x)
        assert (pull + push >= -1e-9 * scene.stiffness * scale * (right - left)).all()
    return len(contacts)


def test_penetration_is_found_between_samples():
    scene = adhesive(rippled(1.0, 0.05, 1e-3, (-0.5, 0.5)))

    def deep(depth, *contacts):
        held = np.array(contacts, float).reshape(-1, 2)
        flat = SimpleNamespace(scene=scene, depth=depth, contacts=held, displacement=np.zeros_like)
        return penetration(flat, 0.05)

    assert deep(-1e-5) == 0.0
    assert abs(deep(1e-7) - 1e-7) <= 1e-15
    beyond = (1e-4 - scene.indenter.height(np.linspace(0.01, 0.5, 200001))).max()
    assert abs(deep(1e-4, (-0.01, 0.01)) - max(0.0, beyond)) <= 1e-3 * max(0.0, beyond) + 1e-12
