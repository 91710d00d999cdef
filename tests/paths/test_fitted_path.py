"""Load paths of several contacts on the fitted mesh: against minimise, single contacts, forces."""

import math

import numpy as np
import pytest
from support.example_scenes import ALPHA, DELTA0, L, adhesive, plain, rippled, tips, wavy
from truth.paths.random_paths import envelope
from truth.random_states import case_of

from discretization import AccuracyWarning, load_path, minimise
from discretization.paths.single_line import SingleLine
from discretization.profile import resolve
from energy import ElasticLayer, Parabola, PowerLaw, Profile, Sampled, Scene, SurfaceEnergies


def test_without_adhesion_a_path_begins_with_less_than_rounding():
    """Where it is asked for first, the contact is only 5e-10 l wide."""
    case = case_of("no_adhesion", 1)
    touch = resolve(case.scene, case.depth).touch
    path = load_path(case.scene, depths=touch + case.scale * np.array([-0.1, 2e-9, 0.4, 0.8]))
    states = [minimise(case.scene, float(depth)) for depth in path.depth[2:]]
    assert path.force[2:] == pytest.approx([state.force for state in states], rel=1e-11, abs=0)
    assert len(states[-1].contacts) == 4


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize(
    "indenter", [Parabola(0.02), PowerLaw(0.3, 1.5), PowerLaw(2e5, 3), PowerLaw(4e9, 4)]
)
@pytest.mark.parametrize("w", [0.0, 6e-5])
def test_smooth_profile_is_followed_without_search(indenter, w, geometry, monkeypatch):
    """One contact of a smooth profile is followed without a search."""
    searches = []
    arc = SingleLine.arc
    monkeypatch.setattr(SingleLine, "arc", lambda *given: searches.append(1) or arc(*given))
    surfaces = SurfaceEnergies.from_work(0.07, w)
    scene = Scene(ElasticLayer(2.5e3, 0.3, 5e-6), surfaces, indenter, geometry=geometry)
    depths = np.r_[np.linspace(0.0, 4e-7, 40), np.linspace(4e-7, -8e-7, 80)]
    path = load_path(scene, depths=depths)
    assert path.events[-1].kind == "detachment"
    assert not searches
    for step in (1, 20, 60):
        force = minimise(scene, float(depths[step])).force
        assert path.force[step] == pytest.approx(force, rel=1e-10, abs=0)


@pytest.mark.parametrize("w", [0.0, 2e-3])
def test_lines_leave_polygon_corners_as_states_do(w):
    """With steps just beside the depths at which they come free, too."""
    x = np.array([-6.0, -3.0, -1.2, 0.1, 1.5, 2.9, 6.0])
    polygon = Sampled(x, 0.01 * x**2 + 0.003 * x, kind="linear")
    scene = plain(polygon, w=w)
    free = [event.depth for event in load_path(scene, depths=[0.0, 0.3]).events[1:]]
    near = (0.0, 1e-9, -1e-9) if w else (1e-4, -1e-4)  # a tip's first steps are hardly resolved
    up = np.sort([0.0, 0.02, 0.1, *(depth + off for depth in free for off in near), 0.3])
    path = load_path(scene, depths=np.r_[up, up[::-1]])
    states = {float(depth): minimise(scene, float(depth)) for depth in up[1:]}
    for step, depth in enumerate(path.depth[1:-1], 1):
        state = states[float(depth)]
        assert path.half_width[step] == pytest.approx(state.half_width, rel=1e-12)
        assert path.force[step] == pytest.approx(state.force, rel=1e-11)
    loads = np.linspace(0.0, path.force.max(), 12)
    for depth, load in zip(load_path(scene, forces=loads).depth[1:], loads[1:], strict=True):
        assert minimise(scene, float(depth)).force == pytest.approx(load, rel=1e-10)


def test_a_polygon_is_pulled_off_where_a_line_leaves_a_corner():
    x = np.sort(np.r_[np.random.default_rng(37).uniform(-6, 6, 10), -6.0, 6.0])
    scene = plain(Sampled(x, 0.01 * x**2 + 0.003 * x, kind="linear"), w=2e-3)
    pull = load_path(scene, forces=[0.02, 0.25, -1.0]).events[-1]  # the load falls from there on
    pulls = [minimise(scene, pull.depth + off).force for off in (-1e-4, 0.0, 1e-4)]
    assert pulls[1] == pytest.approx(pull.force, rel=1e-10) and pulls[1] == min(pulls)


def test_pull_off_of_an_almost_flat_body():
    """The known profile ends 10²³ times as high as any state is deep."""
    surfaces = SurfaceEnergies.from_work(12276.2, 122762.3)
    scene = Scene(ElasticLayer(356.3, -0.9, 0.1108), surfaces, PowerLaw(1.3376e37, 20))
    (jump, pull) = load_path(scene, forces=[0.0, -1e6]).events
    assert jump.energy_released > 0 < pull.energy_released
    pulls = [minimise(scene, pull.depth + off).force for off in (-1e-4, 0.0, 1e-4)]
    assert pulls[1] == pytest.approx(pull.force, rel=1e-10) and pulls[1] == min(pulls)


def test_first_and_second_contact_begin():
    """Each is there from the depth of its event on."""
    scene = wavy(crests=3)
    up = np.array([-0.1, 0.6, 1.485]) * DELTA0
    path = load_path(scene, depths=up)
    x = np.linspace(*scene.indenter.extent, 100_001)
    near = x[np.argmin(scene.indenter.height(x))] + np.linspace(-1e-3, 1e-3, 100_001) * L
    lowest = scene.indenter.height(near).min()
    assert path.events[0].depth == pytest.approx(lowest, rel=0, abs=1e-12 * DELTA0)
    event = next(event for event in path.events if event.kind == "nucleation")
    for off, number in ((-1e-9, 0), (1e-9, 1)):
        begun = load_path(scene, depths=[*up[:2], event.depth + off * DELTA0])
        assert len(begun.inner[-1]) == len(event.before.inner) + 2 * number


def test_springs_pull_hardest_where_a_gap_opens_between_readings():
    """γ₁ = 0 and a stiff machine: at a crest of the profile, in a jump that hardly moves it."""
    body = rippled(0.03, 0.6 * L, 0.6 * DELTA0, (-8 * L, 8 * L))
    x = np.linspace(-8, 8, 1_000_001) * L
    scene = adhesive(body, gamma1=0.0)
    f = body.height(x)
    drives = np.array([1.6, -1.0, -1.6]) * DELTA0
    stiff = 1e5 * scene.stiffness * L
    path = load_path(scene, drives=drives, machine_stiffness=stiff)
    crests = f[1:-1][(f[1:-1] > f[:-2]) & (f[1:-1] > f[2:]) & (f[1:-1] < drives[0])]
    pulled = [scene.stiffness * (z - DELTA0 - f[f <= z]).sum() * (x[1] - x[0]) for z in crests]
    least = min(pulled), crests[np.argmin(pulled)] - DELTA0
    assert path.pull_off[:2] == pytest.approx(least, rel=1e-5, abs=0)
    assert [event.kind for event in path.events] == ["touch", "jump", "jump", "pull-off"]


def test_contacts_many_decay_lengths_apart_are_single_ones():
    off = 0.1 * DELTA0
    depths = np.r_[-0.1, 0.4, -0.5, -1.1] * DELTA0
    height, slope, corners = envelope([0.005, 0.003], np.array([-60, 60]) * L, [off, 0.0])
    body = Profile(height, slope, (-120 * L, 120 * L), corners)
    both = load_path(adhesive(body), depths=depths)
    one = load_path(adhesive(Parabola(0.005)), depths=depths - off)
    other = load_path(adhesive(Parabola(0.003)), depths=depths)
    assert both.force == pytest.approx(one.force + other.force, rel=1e-10, abs=1e-13)
    single = [(e.depth + off, e.energy_released) for e in one.events]
    single += [(e.depth, e.energy_released) for e in other.events]
    found = sorted((e.depth, e.energy_released) for e in both.events)
    assert np.allclose(found, sorted(single), rtol=1e-10, atol=1e-12 * DELTA0)


def test_lines_jump_where_equation_16_has_extrema():
    """Without another contact a line at x rests at d = f + l (f' - √(2w/γ₁)), Eq. (16)."""
    scene = adhesive(rippled(0.015, 0.4 * L, 0.04 * DELTA0, (-8 * L, 8 * L)))
    path = load_path(scene, depths=np.r_[-0.1, 1.2, -3.0] * DELTA0)
    x = np.linspace(0, 6 * L, 600001)
    d = scene.indenter.height(x) + L * scene.indenter.slope(x) - DELTA0
    for step, side in ((1, 1), (2, -1)):
        extrema = d[1:-1][(side * d[1:-1] > side * d[:-2]) & (side * d[1:-1] > side * d[2:])]
        jumps = [e for e in path.events if e.kind == "jump" and e.step == step]
        assert jumps
        for event in jumps:
            assert np.abs(extrema - event.depth).min() <= 1e-9 * DELTA0
            assert event.energy_released > 0
    first = float(np.interp(path.at(1).lines[1], x, d))
    assert first == pytest.approx(1.2 * DELTA0, rel=1e-7, abs=0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)


def test_a_line_jumps_over_a_corner_at_which_the_slope_falls():
    """Eq. (16) with f' on either side: by J l apart in depth."""
    at = 0.8 * L
    fall = 0.3 * ALPHA
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


def test_tips_are_points_of_contact_until_they_are_pulled():
    """P = 2kld per tip while it holds the lines, for 0 < d < l tan δ - δ₀; nothing is released."""
    c = 60 * L
    scene = adhesive(tips(c))
    d = np.r_[0.5, 1.0, 0.3] * DELTA0
    path = load_path(scene, depths=[-DELTA0, *d, -0.1 * DELTA0])
    assert path.force[1:4] == pytest.approx(4 * scene.stiffness * L * d, rel=1e-10, abs=0)
    assert path.at(2).lines == (-c, -c, c, c)
    assert math.isnan(path.contacts[-1, 0])
    size = scene.stiffness * L * DELTA0**2
    assert path.dissipated == pytest.approx(0.0, rel=0, abs=1e-12 * size)
    assert path.work() == pytest.approx(0.0, rel=0, abs=1e-12 * size)
    assert {round(event.depth / DELTA0, 9) for event in path.events} == {0.0}


def test_a_profile_too_rough_to_see_every_event_is_warned_of():
    def roughened(k):
        """Smooth where contact is, ripples of wavenumber k beyond."""
        beyond = lambda x: np.maximum(np.abs(x) - 2, 0)  # noqa: E731
        body = Profile(
            lambda x: x * x / 20 + 1e-2 * np.sin(k * beyond(x)) / k,
            lambda x: x / 10 + 1e-2 * np.sign(x) * (np.abs(x) > 2) * np.cos(k * beyond(x)),
            (-3.0, 3.0),
            (-2.0, 2.0),
        )
        return plain(body, w=1e-3)

    load_path(roughened(30.0), depths=[-1e-3, 1e-3])
    with pytest.warns(AccuracyWarning, match="contacts may be missed"):
        load_path(roughened(1e6), depths=[-1e-3, 1e-3])


def test_pressed_tip_stays_in_contact():
    """One side of it is too steep for any line, the other up to a corner."""
    x = np.array([-4.0, -0.02, 0.0, 4.0]) * L
    slopes = np.array([-1.2, -2.0, 4.0]) * ALPHA
    body = Sampled(x, np.r_[0.0, np.cumsum(slopes * np.diff(x))] - (slopes * np.diff(x))[:2].sum())
    path = load_path(adhesive(body), depths=np.r_[-0.1, 1.5, 0.1, -0.2] * DELTA0)
    assert [event.kind for event in path.events] == ["touch", "jump", "jump", "detachment"]
    *_, pulled, last = path.events
    assert pulled.after.lines == last.before.lines == (0.0, 0.0)
    assert pulled.depth > 0.1 * DELTA0
    assert abs(last.depth) <= 1e-12 * DELTA0


def test_lines_of_a_tiny_contact_stay():
    """Its lines move by less than 1e-7 l in a step; held, they must not be taken for moving."""
    R = 1e-6 * L
    tiny = Profile(lambda x: x * x / (2 * R), lambda x: x / R, (-L, L))
    scene = adhesive(tiny, opening=0.004)
    depths = np.r_[np.linspace(-0.1, 0.5, 9), np.linspace(0.5, -3, 9)] * DELTA0
    path = load_path(scene, depths=depths)
    assert path.friction > 0
    assert abs(path.work() / path.dissipated - 1) <= 1e-12
