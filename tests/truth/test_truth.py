"""The reference solutions of tests/truth, tested before they are used."""

import math

import numpy as np
import pytest
from scenes import adhesive, steep
from scipy.integrate import solve_ivp

from energy import ElasticLayer, Parabola, Profile, Scene, SurfaceEnergies, Wedge, cards
from truth import walk
from truth.compare import REFERENCE
from truth.ground import Outside
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


@pytest.mark.parametrize(
    ("gamma1", "w", "slopes", "profile", "depth", "force", "count"),
    [
        (0.16, 0.0035 * 0.16, "finite", ripples(0.06, 0.36, 3), 0.01, 0.00787, 1),
        (0.0025, 1.25e-5, "small", ripples(0.01, 0.2), 0.03, 0.0066820, 3),
    ],
)
def test_examples_known_from_elsewhere(gamma1, w, slopes, profile, depth, force, count):
    found = adhered(Walk(Scene(LAYER, WORK(gamma1, w), profile, slopes), 0.2), depth)
    assert len(found.contacts) == count
    assert abs(found.force - force) <= 6e-4 * force


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


def test_gaps_of_finite_slopes_become_those_of_small_ones():
    small = surface_of(Scene(LAYER, WORK(1.0, 1e-9), BODY))
    finite = surface_of(Scene(LAYER, WORK(1.0, 1e-9), BODY, "finite"))
    for width in (1e-3, 0.5, 5.0, 60.0):
        ends = (1e-6 * min(width, 1.0), 2e-6 * min(width, 1.0))
        one, other = (s.facing(*ends, width) for s in (small, finite))
        assert abs(one - other) <= 1e-9 * abs(one)
        one, other = (s.gap_energy(*ends, width) for s in (small, finite))
        assert abs(one - other) <= 1e-9 * one


SLOWLY = pytest.param("finite", marks=pytest.mark.slow)


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


def test_a_scene_and_its_mirror_image():
    for seed in (0, 5, 7, 13, 36):
        case = case_of("small", seed)
        body = case.scene.indenter
        lo, hi = body.extent
        mirrored = Profile(
            lambda x, body=body: body.height(-np.asarray(x)),
            lambda x, body=body: -body.slope(-np.asarray(x)),
            (-hi, -lo),
            [-c for c in body.corners][::-1],
        )
        other = Scene(case.scene.layer, case.scene.surfaces, mirrored)
        one, two = (adhered(Walk(s, case.feature), case.depth) for s in (case.scene, other))
        assert one.contacts.shape == two.contacts.shape
        assert np.abs(one.contacts + two.contacts[::-1, ::-1]).max(initial=0) <= 1e-9 * case.feature
        assert abs(one.force - two.force) <= 1e-11 * one.force_scale
