"""Load paths of several contacts on the fitted mesh: against minimise, single contacts, forces."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import ALPHA, DELTA0, L, adhesive, rippled, tips, wavy
from scipy.optimize import brentq, minimize_scalar
from truth.scenes import case_of

from discretization import AccuracyWarning, load_path, minimise
from discretization.following import vanishing
from discretization.paths.fitted_many import FittedMany
from discretization.profile import resolve
from energy import ElasticLayer, Parabola, Patches, Profile, Sampled, Scene, SurfaceEnergies
from studies.benchmarks.speed import rough_scene

RIPPLED_LOOP = np.r_[-0.1, np.linspace(0, 1.6, 5), np.linspace(1.3, -1.6, 12)] * DELTA0
PATCHES = Patches(np.array([-1.3, -0.45, 0.15, 0.8]) * L, (1.0, 0.5, 0.9, 0.4, 1.0))
STRONGER = SurfaceEnergies.from_work(0.07, 0.003)
CASES = {
    "opening": {"opening": STRONGER},
    "pattern": {"pattern": PATCHES},
    "both": {"opening": STRONGER, "pattern": PATCHES},
}


def ripples(**more):
    """Contact begins at the middle crest, and twice beside it on the way."""
    return replace(adhesive(rippled(0.03, 0.6 * L, 0.17 * DELTA0, (-8 * L, 8 * L))), **more)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("level", [0.9, -0.5])
def test_one_state_is_the_end_of_its_path(name, level):
    scene = ripples(**CASES[name])
    depths = [-0.1 * DELTA0, max(level, 0.0) * DELTA0, level * DELTA0]
    state, path = minimise(scene, depths[-1]), load_path(scene, depths=depths)
    assert state.certificate.ok and state.label == "adhered"
    assert state.contacts.ravel() == pytest.approx(path.at(-1).lines, rel=0, abs=1e-11 * L)
    assert state.force == pytest.approx(path.force[-1], rel=1e-10, abs=0)


def test_without_adhesion_the_path_has_the_states_of_minimise():
    scene = ripples(surfaces=SurfaceEnergies.from_work(0.07, 0.0))
    path = load_path(scene, depths=RIPPLED_LOOP)
    for depth, force in zip(RIPPLED_LOOP[2:8], path.force[2:8], strict=True):
        assert force == pytest.approx(minimise(scene, depth).force, rel=1e-10, abs=0)
    size = path.energy.max()
    assert path.dissipated == pytest.approx(0.0, rel=0, abs=1e-11 * size)
    assert path.work() == pytest.approx(0.0, rel=0, abs=1e-11 * size)


def test_springs_lose_their_work_of_adhesion_wherever_they_have_been_touched():
    """γ₁ = 0: each attaches when touched and lets go at u = -δ₀, at a loss of w."""
    w, deep = 0.002, rippled(0.03, 0.6 * L, 0.6 * DELTA0, (-8 * L, 8 * L))
    scene = adhesive(deep, gamma1=0.0, w=w)
    path = load_path(scene, depths=RIPPLED_LOOP)
    x = np.linspace(-8 * L, 8 * L, 4_000_001)
    touched = np.mean(scene.indenter.height(x) < RIPPLED_LOOP.max()) * 16 * L
    assert max(len(inner) for inner in path.inner) >= 4
    assert path.work() == pytest.approx(w * touched, rel=1e-5, abs=0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-8, abs=0)
    for depth, force in zip(RIPPLED_LOOP[2:6], path.force[2:6], strict=True):
        assert force == pytest.approx(minimise(scene, depth).force, rel=1e-12, abs=0)


def test_without_adhesion_a_path_begins_with_less_than_rounding():
    """Where it is asked for first, the contact is only 5e-10 l wide."""
    case = case_of("no_adhesion", 1)
    touch = resolve(case.scene, case.depth).touch
    path = load_path(case.scene, depths=touch + case.scale * np.array([-0.1, 2e-9, 0.4, 0.8]))
    states = [minimise(case.scene, float(depth)) for depth in path.depth[2:]]
    assert path.force[2:] == pytest.approx([state.force for state in states], rel=1e-11, abs=0)
    assert len(states[-1].contacts) == 4


UP = np.r_[-0.1, 0.6, 1.485, 1.8] * DELTA0
LOOP = np.r_[UP, np.linspace(1.2, -0.9, 6) * DELTA0]


def crests(unit=1.0, stress=1.0, mirror=False):
    """Three unequal crests 2 l apart, in a bowl."""
    return wavy(crests=3, unit=unit, stress=stress, mirror=mirror)


@pytest.fixture(scope="module")
def path():
    return load_path(crests(), depths=LOOP)


def test_before_a_contact_begins_the_free_surface_is_clear_and_then_it_touches(path):
    """The contact is there from the depth of its event on."""
    event = next(event for event in path.events if event.kind == "nucleation")
    near = DELTA0 * 1e-9
    for depth, number in ((event.depth - near, 0), (event.depth + near, 1)):
        begun = load_path(path.scene, depths=[*UP[:2], depth])
        assert len(begun.inner[-1]) == len(event.before.inner) + 2 * number


def test_where_an_equilibrium_disappears_is_solved_for(path):
    """Of the outermost line: where its D is greatest."""
    rests = FittedMany.of(path.scene, 2 * DELTA0).motion.rests
    x = np.linspace(-8, 8, 2001) * L
    D = rests.ahead(np.column_stack([x, np.full_like(x, math.inf)]), 1)[:, 0]
    tops = np.flatnonzero((D[1:-1] > D[:-2]) & (D[1:-1] > D[2:])) + 1
    assert tops.size
    for i in tops.tolist():
        found = minimize_scalar(
            lambda q: -float(rests.ahead(np.array([[q, math.inf]]), 1)[0, 0]),
            bracket=x[i - 1 : i + 2].tolist(),
            tol=1e-9,
        )
        fold = vanishing.fold(rests, np.array([x[i - 10], math.inf]), 1)
        assert fold == pytest.approx(-found.fun, rel=0, abs=1e-14 * DELTA0)


@pytest.mark.slow
def test_jumps_are_where_halving_encloses_them(monkeypatch):
    """A gap between contacts on a rough profile: its lines leave at once, pressed and retracted."""
    scene, depths = rough_scene(4), np.r_[-0.1, 1.87, 2.0, 1.9, 0.5]
    solved = [event for event in load_path(scene, depths=depths).events if event.kind == "jump"]
    monkeypatch.setattr(vanishing, "fold", lambda *_: math.nan)
    halved = [event for event in load_path(scene, depths=depths).events if event.kind == "jump"]
    assert len(solved) == len(halved) >= 2
    for one, other in zip(solved, halved, strict=True):
        assert one.depth == pytest.approx(other.depth, rel=0, abs=1e-12)


def test_no_unit_enters(path):
    unit, stress = 1e-6, 3e4
    there = load_path(crests(unit, stress), depths=LOOP * unit)
    assert [e.kind for e in there.events] == [e.kind for e in path.events]
    size = 1e-10 * np.abs(path.force).max()
    assert np.allclose(there.force / (stress * unit), path.force, rtol=0, atol=size)
    depths = [[e.depth / scale for e in p.events] for p, scale in ((there, unit), (path, 1.0))]
    assert np.allclose(*depths, rtol=0, atol=1e-11 * DELTA0)
    assert there.dissipated / (stress * unit**2) == pytest.approx(path.dissipated, rel=1e-13, abs=0)


def apart(c):
    """Two parabolas at -c and c, the second one lower, that meet in a corner at the middle."""
    sizes, lift = (0.01, 0.006), 0.1 * DELTA0
    one, other = (lambda x, s=s, z=z: (x + s) ** 2 / z for s, z in zip((c, -c), sizes, strict=True))
    a, b = 1 / sizes[1] - 1 / sizes[0], -2 * c * (1 / sizes[1] + 1 / sizes[0])
    meet = 2 * (a * c * c - lift) / (-b + math.sqrt(b * b - 4 * a * (a * c * c - lift)))

    def height(x):
        x = np.asarray(x, float)
        return np.where(x < meet, one(x) + lift, other(x))

    def slope(x):
        x = np.asarray(x, float)
        return np.where(x < meet, 2 * (x + c) / sizes[0], 2 * (x - c) / sizes[1])

    return Profile(height, slope, (-2 * c, 2 * c), (meet,))


def test_contacts_many_decay_lengths_apart_are_single_ones():
    c, depths = 60 * L, np.r_[-0.1, 0.4, -0.5, -1.1] * DELTA0
    both = load_path(adhesive(apart(c)), depths=depths)
    one = load_path(adhesive(Parabola(0.005)), depths=depths - 0.1 * DELTA0)
    other = load_path(adhesive(Parabola(0.003)), depths=depths)
    assert both.force == pytest.approx(one.force + other.force, rel=1e-10, abs=1e-13)
    single = sorted(
        [(e.depth + 0.1 * DELTA0, e.energy_released) for e in one.events]
        + [(e.depth, e.energy_released) for e in other.events]
    )
    found = sorted((e.depth, e.energy_released) for e in both.events)
    assert np.allclose(found, single, rtol=1e-10, atol=1e-12 * DELTA0)


def test_lines_jump_where_equation_16_has_extrema():
    """Without another contact a line at x rests at d = f + l (f' - √(2w/γ₁)), Eq. (16)."""
    scene = adhesive(rippled(0.015, 0.4 * L, 0.04 * DELTA0, (-8 * L, 8 * L)))
    path = load_path(scene, depths=np.r_[-0.1, 1.2, -3.0] * DELTA0)
    x = np.linspace(0, 6 * L, 600001)
    d = scene.indenter.height(x) + L * scene.indenter.slope(x) - DELTA0
    jumps = [event for event in path.events if event.kind == "jump"]
    up, down = ([e for e in jumps if e.step == step] for step in (1, 2))
    assert len(up) >= 1 and len(down) >= 1
    for events, side in ((up, 1), (down, -1)):
        extrema = d[1:-1][(side * d[1:-1] > side * d[:-2]) & (side * d[1:-1] > side * d[2:])]
        for event in events:
            assert np.abs(extrema - event.depth).min() <= 1e-9 * DELTA0
            assert event.energy_released > 0
    first = float(np.interp(path.at(1).lines[1], x, d))
    assert first == pytest.approx(1.2 * DELTA0, rel=1e-7, abs=0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)


def test_a_line_jumps_over_a_corner_at_which_the_slope_falls():
    """Eq. (16) with f' on either side: by J l apart in depth."""
    at, fall = 0.8 * L, 0.3 * ALPHA
    body = Profile(
        lambda x: np.square(x) / 0.03 - fall * np.maximum(np.abs(x) - at, 0),
        lambda x: np.asarray(x) / 0.015 - fall * np.sign(x) * (np.abs(x) > at),
        (-8 * L, 8 * L),
        (-at, at),
    )
    path = load_path(adhesive(body), depths=np.r_[-0.1, 8.0, 4.0] * DELTA0)
    up, down = (event for event in path.events if event.kind == "jump")
    assert up.depth == pytest.approx(at**2 / 0.03 + L * at / 0.015 - DELTA0, rel=1e-13, abs=0)
    assert down.depth == pytest.approx(up.depth - 0.3 * DELTA0, rel=1e-12, abs=0)


def test_contact_begins_at_the_lowest_point_between_the_samples():
    scene, path = crests(), load_path(crests(), depths=[UP[1]])
    x = np.linspace(*scene.indenter.extent, 100_001)
    near = x[np.argmin(scene.indenter.height(x))] + np.linspace(-1e-3, 1e-3, 100_001) * L
    lowest = scene.indenter.height(near).min()
    assert path.events[0].depth == pytest.approx(lowest, rel=0, abs=1e-12 * DELTA0)


def test_tips_are_points_of_contact_until_they_are_pulled():
    """P = 2kld per tip while it holds the lines, for 0 < d < l tan δ - δ₀; nothing is released."""
    c = 60 * L
    scene, d = adhesive(tips(c)), np.r_[0.5, 1.0, 0.3] * DELTA0
    path = load_path(scene, depths=[-DELTA0, *d, -0.1 * DELTA0])
    assert path.force[1:4] == pytest.approx(4 * scene.stiffness * L * d, rel=1e-10, abs=0)
    assert path.at(2).lines == (-c, -c, c, c)
    assert math.isnan(path.contacts[-1, 0])
    size = scene.stiffness * L * DELTA0**2
    assert path.dissipated == pytest.approx(0.0, rel=0, abs=1e-12 * size)
    assert path.work() == pytest.approx(0.0, rel=0, abs=1e-12 * size)
    assert {round(event.depth / DELTA0, 9) for event in path.events} == {0.0}


def test_a_profile_too_rough_to_see_every_event_is_warned_of():
    def rippled(k):
        """Smooth where contact is, ripples of wavenumber k beyond."""
        return Profile(
            height=lambda x: x * x / 20 + 1e-2 * (np.abs(x) > 2) * np.sin(k * (np.abs(x) - 2)) / k,
            slope=lambda x: (
                x / 10 + 1e-2 * np.sign(x) * (np.abs(x) > 2) * np.cos(k * (np.abs(x) - 2))
            ),
            extent=(-3.0, 3.0),
            corners=(-2.0, 2.0),
        )

    surfaces = SurfaceEnergies.from_work(1.0, 1e-3)
    layer = ElasticLayer(1.0, 0.0, 1.0)
    load_path(Scene(layer, surfaces, rippled(30.0)), depths=[-1e-3, 1e-3])
    with pytest.warns(AccuracyWarning, match="contacts may be missed"):
        load_path(Scene(layer, surfaces, rippled(1e6)), depths=[-1e-3, 1e-3])


def test_a_line_that_a_corner_would_stop_is_not_at_rest_beside_it():
    """Left line of a narrow contact at a tip, 1e-7 δ₀ above the depth that would hold it."""
    x = np.array([-9.0, -4.0, 4.0, 6.0, 8.0, 14.0]) * L
    scene = adhesive(Sampled(x, np.array([9.0, 0.0, 0.0, 3.0, 2.7, 12.0]) * DELTA0), w=1e-8)
    motion, tip, p = FittedMany.of(scene, 5 * DELTA0).motion, 8 * L, (8 - 1e-8) * L

    def rest_depths(q):
        lines, rests = np.array([[[q, p]]]), motion.rests
        return rests.rest_depths(lines, rests.rooms(lines[0], 1), 1, False)[0][0, 0]

    def above(q):
        own, facing = rest_depths(q)
        return facing - own - 1e-7 * DELTA0

    q = brentq(above, 4.4 * L, 5.4 * L)
    assert motion.resting.apart(q, p, -4 * L, tip, rest_depths(q)[0])[1] > tip


def test_a_tip_that_is_pressed_in_stays_in_contact_where_a_line_jumps_to_it():
    """One side of it is too steep for any line, the other up to a corner."""
    x, slopes = np.array([-4.0, -0.02, 0.0, 4.0]) * L, np.array([-1.2, -2.0, 4.0]) * ALPHA
    body = Sampled(x, np.r_[0.0, np.cumsum(slopes * np.diff(x))] - (slopes * np.diff(x))[:2].sum())
    path = load_path(adhesive(body), depths=np.r_[-0.1, 1.5, 0.1, -0.2] * DELTA0)
    assert [event.kind for event in path.events] == ["touch", "jump", "jump", "detachment"]
    *_, pulled, last = path.events
    assert pulled.after.lines == last.before.lines == (0.0, 0.0)
    assert pulled.depth > 0.1 * DELTA0
    assert abs(last.depth) <= 1e-12 * DELTA0


def test_lines_of_a_tiny_contact_stay_until_they_are_pulled_enough():
    """Its lines move by less than 1e-7 l in a step; held, they must not be taken for moving."""
    R = 1e-6 * L
    tiny = Profile(lambda x: x * x / (2 * R), lambda x: x / R, (-L, L))
    scene = adhesive(tiny, opening=0.004)
    depths = np.r_[np.linspace(-0.1, 0.5, 9), np.linspace(0.5, -3, 9)] * DELTA0
    path = load_path(scene, depths=depths)
    assert path.friction > 0
    assert abs(path.work() / path.dissipated - 1) <= 1e-12
