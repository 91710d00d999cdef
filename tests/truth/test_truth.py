"""The reference solutions of tests/truth, tested before they are used."""

import math

import numpy as np
import pytest
import test_balance as no_adhesion_paths
from scenes import adhesive, steep
from scipy.integrate import solve_ivp

from energy import ElasticLayer, Parabola, Profile, Scene, SurfaceEnergies, Wedge, cards
from truth import sets, walk
from truth.compare import REFERENCE, penetration
from truth.ground import Ground, Outside
from truth.obstacle import obstacle, springs
from truth.scenes import KINDS, case_of
from truth.surfaces import surface_of
from truth.totals import adhered, imbalance
from truth.walk import Walk

LAYER, WORK = ElasticLayer(1, 0.0, 1.0), SurfaceEnergies.from_work
R, FAR = 0.02, 0.2
BODY = Profile(Parabola(R).height, Parabola(R).slope, extent=(-FAR, FAR))


def ripples(height, wave, reach=2.0):
    """A parabola of radius 1 with ripples."""
    q = 2 * np.pi / wave
    return Profile(
        lambda x: np.asarray(x) ** 2 / 2 + height * (1 - np.cos(q * np.asarray(x))),
        lambda x: np.asarray(x) + height * q * np.sin(q * np.asarray(x)),
        extent=(-reach, reach),
    )


def given(scene):
    return {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}


def states(kind, seeds):
    """Cases with their references, at their depth and two others close by."""
    for seed in seeds:
        case = case_of(kind, seed)
        away = 1e-4 * min(case.scale, abs(case.above))
        near = [case.depth + s * away for s in (-1, 0, 1)]
        try:
            yield case, near, REFERENCE[kind](case, near)
        except Outside:
            continue


@pytest.mark.parametrize("level", [-0.9, -0.3, 0.0, 1e-4, 0.5, 3.0])
def test_parabola_of_small_slopes(level):
    scene = adhesive(BODY)
    depth = level * scene.critical_separation
    found = adhered(Walk(scene, 0.01), depth)
    a = cards.parabola.half_width(depth, R=R, **given(scene))
    P, U = (f(depth, R=R, **given(scene)) for f in (cards.parabola.force, cards.parabola.energy))
    assert np.abs(found.contacts - [-a, a]).max() <= 1e-12 * a
    assert abs(found.force - P) <= 1e-12 * found.force_scale
    assert abs(found.energy - U) <= 1e-12 * found.energy_scale


@pytest.mark.parametrize("level", [-0.9, -0.3, 0.5, 2.0])
def test_parabola_of_finite_slopes(level):
    scene = steep(BODY)
    depth = level * scene.critical_separation
    found = adhered(Walk(scene, 0.01), depth)
    a = found.half_width
    same = {**given(scene)}
    assert abs(cards.finite.depth(a * a / (2 * R), a / R, **same) - depth) <= 1e-12 * abs(depth)
    u, k, gamma1 = depth - a * a / (2 * R), scene.stiffness, scene.gamma1
    P = 2 * k * (depth * a - a**3 / (6 * R)) + cards.finite.surface_force(u, k=k, gamma1=gamma1)
    assert abs(found.force - P) <= 1e-12 * found.force_scale


def test_a_contact_lets_go_where_the_closed_form_does():
    scene = adhesive(BODY)
    assert adhered(Walk(scene, 0.01), -0.9999 * scene.critical_separation).half_width > 0
    assert not adhered(Walk(scene, 0.01), -1.0001 * scene.critical_separation).contacts.size


@pytest.mark.parametrize("level", [0.1, 0.4, 0.8])
def test_a_steep_wedge_is_pinned_at_its_tip(level):
    steepness = 3.0
    scene = adhesive(Wedge(0.1))
    tan = steepness * scene.surfaces.small_slope_deficit
    body = Wedge(math.atan(tan))
    scene = adhesive(Profile(body.height, body.slope, (-0.1, 0.1), (0.0,)))
    top = scene.elastocapillary_length * tan - scene.critical_separation
    found = adhered(Walk(scene, 0.01), level * top)
    assert found.contacts.tolist() == [[0.0, 0.0]]
    P = 2 * scene.stiffness * scene.elastocapillary_length * level * top
    assert abs(found.force - P) <= 1e-13 * P


def test_gaps_of_finite_slopes_solve_their_equation():
    surface = surface_of(Scene(LAYER, WORK(1.0, 0.01), BODY, "finite"))
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


SLOWLY = pytest.param("finite", marks=pytest.mark.slow)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [SLOWLY if kind == "finite" else kind for kind in KINDS])
def test_force_is_the_derivative_of_the_energy(kind):
    """At three depths next to each other, between events."""
    compared = several = 0
    for case, near, found in states(kind, range(20)):
        if len({len(s.contacts) for s in found}) > 1 or not found[1].half_width:
            continue
        if abs(found[2].half_width - found[0].half_width) > 1e-2 * found[1].half_width:
            continue
        kept = case.scene.work_of_adhesion if kind == "no_tension" else 0.0  # lost on touching
        energy = [s.energy + 2 * kept * s.half_width for s in found]
        slope = (energy[2] - energy[0]) / (near[2] - near[0])
        lost = 1e-12 * found[1].energy_scale / (near[2] - near[0])
        curved = 1e-3 * abs(found[2].force - found[0].force)
        assert abs(slope - found[1].force) <= 1e-7 * found[1].force_scale + lost + curved
        compared += 1
        several += len(found[1].contacts) > 1
    assert compared >= 8
    assert several >= 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["small", SLOWLY])
def test_every_line_rests_and_nothing_penetrates(kind):
    several = 0
    for seed in range(100, 120):
        case = case_of(kind, seed)
        one = Walk(case.scene, case.feature)
        found = adhered(one, case.depth)
        lines = found.contacts.ravel()
        several += lines.size > 2
        free = ~np.isin(lines, one.ground.corners)
        if lines.size:
            off = imbalance(lines, case.depth, one.ground, one.surface)[free]
            assert np.abs(off).max(initial=0.0) <= 1e-9 * one.surface.deficit
        one.lines = lines.tolist()
        assert min((v for i in range(lines.size // 2 + 1) for v, _ in one._dips(i)), default=0) >= (
            -10 * one.tie
        )
    assert several >= 2


@pytest.mark.parametrize("kind", ["small", SLOWLY])
def test_the_walk_does_not_depend_on_its_steps(kind, monkeypatch):
    seeds = [seed for seed in range(100, 140) if case_of(kind, seed).above > 0][:4]
    usual = [REFERENCE[kind](case, [case.depth])[0] for case in map(case_of, [kind] * 4, seeds)]
    monkeypatch.setattr(walk, "SINK", 1 / 13)
    monkeypatch.setattr(walk, "MOVE", 1 / 11)
    for seed, before in zip(seeds, usual, strict=True):
        case = case_of(kind, seed)
        (after,) = REFERENCE[kind](case, [case.depth])
        assert len(after.contacts) == len(before.contacts)
        assert abs(after.force - before.force) <= 1e-11 * before.force_scale


def test_no_adhesion_parabola():
    scene = adhesive(BODY, w=0.0)
    for depth in (1e-9, 1e-4, 1e-3):
        found = obstacle(scene, 0.01, depth)
        same = {"R": R, "k": scene.stiffness, "gamma1": scene.gamma1}
        a = cards.nonadhesive.parabola_half_width(depth, **same)
        assert abs(found.half_width - a) <= 1e-11 * a
        P = cards.nonadhesive.parabola_force(depth, **same)
        assert abs(found.force - P) <= 1e-12 * P


def test_springs_of_a_parabola():
    scene = adhesive(BODY, gamma1=0.0)
    depth, k, w = 1e-3, scene.stiffness, scene.work_of_adhesion
    a = math.sqrt(2 * R * depth)
    found = springs(scene, 0.01, depth)
    assert abs(found.half_width - a) <= 1e-13 * a
    assert abs(found.force - 4 / 3 * k * depth * a) <= 1e-13 * found.force
    energy = 8 / 15 * k * depth**2 * a - 2 * w * a
    assert abs(found.energy - energy) <= 1e-13 * found.energy_scale


def test_no_adhesion_has_pressure_inside_and_clearance_outside():
    """Which is sufficient, as the problem is convex."""
    several = 0
    for seed in range(40):
        case = case_of("no_adhesion", seed)
        found = obstacle(case.scene, case.feature, case.depth)
        several += len(found.contacts) > 1
        assert_pressed(case.scene, case.feature, case.depth, found, case.scale)
    assert several >= 10


@pytest.mark.parametrize(
    ("kind", "seed"), [("polygon", s) for s in (104, 107, 115, 125, 131, 136)] + [("plateau", 15)]
)
def test_no_contact_is_lost_at_a_corner_next_to_a_node(kind, seed):
    scene, feature, low, depths = no_adhesion_paths.case(kind, seed)
    for depth in depths[depths > low + 0.01 * (depths.max() - low)].tolist():
        found = obstacle(scene, feature, depth)
        assert_pressed(scene, feature, depth, found, depth - low)


def assert_pressed(scene, feature, depth, found, scale):
    """Clearance outside, pressure inside, and lines that push or nothing."""
    ground, surface = Ground(scene.indenter, feature), surface_of(scene)
    lines = found.contacts.ravel()
    assert not sets.dips(lines, depth, ground, surface, scene)
    assert (imbalance(lines, depth, ground, surface) >= -1e-9 * scale / surface.length).all()
    for left, right in found.contacts:
        x = np.linspace(left, right, 101)
        g = depth - scene.indenter.height(x)
        pull = np.diff(scene.indenter.slope(x)) * scene.gamma1  # of γ₁ f'' over each part
        push = scene.stiffness * (g[1:] + g[:-1]) / 2 * np.diff(x)
        assert (pull + push >= -1e-9 * scene.stiffness * scale * (right - left)).all()


@pytest.mark.slow
def test_the_lowest_state_is_not_above_the_adhered_one():
    below = 0
    for seed in range(8):
        case = case_of("global", seed)
        try:
            low = sets.lowest(case.scene, case.feature, case.depth)
            other = adhered(Walk(case.scene, case.feature), case.depth)
        except Outside:
            continue
        assert low.energy <= other.energy + 1e-10 * other.energy_scale
        below += low.energy < other.energy - 1e-6 * other.energy_scale
    assert below >= 1


class Stub:
    """What `penetration` reads of a state."""

    def __init__(self, scene, depth, contacts, displacement):
        self.scene, self.depth, self.displacement = scene, depth, displacement
        self.contacts = np.array(contacts, float).reshape(-1, 2)


def test_penetration_is_found_between_samples():
    scene = adhesive(ripples(1e-3, 0.05, 0.5))
    assert penetration(Stub(scene, -1e-5, [], np.zeros_like), 0.05) == 0.0
    deep = penetration(Stub(scene, 1e-7, [], np.zeros_like), 0.05)
    assert abs(deep - 1e-7) <= 1e-15
    flat = Stub(scene, 1e-4, [(-0.01, 0.01)], np.zeros_like)
    inside = np.linspace(0.01, 0.5, 200001)
    deep = max(0.0, float((1e-4 - scene.indenter.height(inside)).max()))
    assert abs(penetration(flat, 0.05) - deep) <= 1e-3 * deep + 1e-12
