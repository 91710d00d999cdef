"""Load paths on the lattice: the same events, an exact energy balance, no lattice hysteresis."""

from dataclasses import replace

import numpy as np
import pytest
from support.example_scenes import adhesive, plain
from truth.random_states import case_of

from discretization import History, NotCertifiedError, load_path, minimise
from discretization.paths.branch import Point
from discretization.paths.lattice_branch import LatticeBranch
from energy import Parabola, Patches, Profile, Sampled, SurfaceEnergies, cards

SPACING = 1e-5


def moved(branch, point, depth):
    """The point to which a branch of load paths comes at another depth."""
    while point.depth != depth and point.lines is not None:
        segment = branch.segment(point, depth)
        point = segment.after or segment.end
    return Point(depth, None) if point.lines is None else point


def programme(scene, top=3.0, bottom=-2.0):
    return np.r_[np.linspace(-1, top, 40), np.linspace(top, bottom, 60)] * scene.critical_separation


@pytest.mark.slow
def test_stripes_pin_the_line_and_release_it_by_avalanches():
    period = 0.004
    low = 0.25
    high = 1.0
    plain = adhesive(Parabola(0.05))
    scene = replace(plain, pattern=Patches.stripes(period, low, high, 0.1))
    depths = programme(scene, 3.0, -2.0)
    path = load_path(scene, depths=depths, method="lattice", spacing=SPACING)
    bare = load_path(plain, depths=depths, method="lattice", spacing=SPACING)
    jumps = [event for event in path.events if event.kind == "jump"]
    assert len(jumps) >= 4 and not [event for event in bare.events if event.kind == "jump"]
    assert min(event.energy_released for event in jumps) > 0
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)
    # a line rests at the border of a strong stripe, or between the lines of both works
    strong, weak = (
        load_path(
            replace(plain, surfaces=SurfaceEnergies.from_work(plain.gamma1, factor * 0.002)),
            depths=depths,
            method="lattice",
            spacing=SPACING,
        ).half_width
        for factor in (high, low)
    )
    rising = slice(int(np.argmax(path.half_width > 0)), 40)
    assert (path.half_width[rising] >= weak[rising] - 2 * SPACING).all()
    assert (path.half_width[rising] <= strong[rising] + 2 * SPACING).all()


def test_a_defect_holds_the_line_until_it_tears_off():
    """On retraction a strong patch holds the right line until it tears off the inner border."""
    plain = adhesive(Parabola(0.02))
    scene = replace(plain, pattern=Patches([0.006, 0.0066], [1.0, 4.0, 1.0]))
    f = 0.006**2 / 0.04
    slope = 0.006 / 0.02
    alpha = np.sqrt(2 * 4 * 0.002 / plain.gamma1)
    torn = f + plain.elastocapillary_length * (slope - alpha)  # Eq. (16) of the patch there
    there = np.linspace(-0.8, 2, 60) * scene.critical_separation
    path = load_path(scene, depths=[0.0, *there, *there[::-1]], method="lattice", spacing=SPACING)
    pulled = [e for e in path.events if e.kind == "jump" and e.after.right < e.before.right]
    assert len(pulled) == 1
    assert pulled[0].before.right == pytest.approx(0.006, abs=2 * SPACING)
    assert pulled[0].before.left == pulled[0].after.left  # the other side has no defect
    assert pulled[0].depth == pytest.approx(torn, abs=0.01 * abs(torn))
    again = load_path(plain, depths=[0.0, *there, *there[::-1]], method="lattice", spacing=SPACING)
    assert [e.kind for e in again.events] == ["jump-in"]


def test_a_uniform_pattern_is_no_pattern(tmp_path):
    plain = adhesive(Parabola(0.02), w=0.001)
    doubled = replace(plain, pattern=Patches([-0.003, 0.002], [2.0, 2.0, 2.0]))
    given = {"depths": programme(plain), "method": "lattice", "spacing": SPACING}
    path = load_path(doubled, **given)
    twice = load_path(adhesive(Parabola(0.02), w=0.002), **given)
    assert path.half_width == pytest.approx(twice.half_width, rel=1e-12, abs=1e-15)
    assert path.dissipated == pytest.approx(twice.dissipated, rel=1e-13, abs=0)
    path.to_csv(tmp_path / "path.csv")
    assert History.from_csv(tmp_path / "path.csv").scene.pattern == doubled.pattern


@pytest.mark.parametrize("pattern", [None, Patches([0.004], [1.0, 1.0])])
def test_a_path_does_not_continue_from_a_wrong_state(pattern):
    scene = replace(adhesive(Parabola(0.02)), pattern=pattern)
    branch = LatticeBranch.of(scene, SPACING, 1e-3)
    point = moved(branch, branch.first, 1e-3)
    branch.certify(point)
    ((first, last),) = point.memory
    for links in (-1, 1):
        with pytest.raises(NotCertifiedError, match="neighbours"):
            branch.certify(point._replace(memory=((first, last + links),)))


def test_largest_pull_on_a_lone_node():
    """Which pull with √(2wγ₁) each: below -δ₀ such a contact has closed."""
    scene = adhesive(Parabola(0.02))
    branch = LatticeBranch.of(scene, SPACING, 1e-3)
    touch = branch.row.touch
    delta0 = scene.critical_separation
    alone = branch.first._replace(memory=((touch, touch),))
    branch.certify(alone._replace(depth=-(1 - 1e-6) * delta0))
    with pytest.raises(NotCertifiedError, match="opening"):
        branch.certify(alone._replace(depth=-1.01 * delta0))


@pytest.mark.parametrize("seed", [6004, 6006])
def test_narrow_contacts_are_held_beside_their_nodes(seed):
    """Lines of a contact narrower than a link meet where the profile is lower than at the node."""
    case = case_of("small", seed)
    depths = [case.above + share * case.scale for share in (-0.2, 1.5, -2.0)]
    spacing = case.scene.elastocapillary_length / 64
    path = load_path(case.scene, depths=depths, method="lattice", spacing=spacing)
    assert path.depth[-1] == depths[-1]
    assert any(event.kind == "closing" for event in path.events)  # a contact is lost


def one_sided(factors=(0.0, 1.0), edges=(0.05,)):
    """A parabola that adheres on one side only, with k = 1."""
    scene = plain(Parabola(1.0), w=0.00125, gamma1=0.01)
    return replace(scene, pattern=Patches(edges, factors))


@pytest.mark.slow
def test_a_line_crosses_the_apex_where_nothing_holds_it():
    """On the bare side d = f - l |f'|; from x = 0.05 on adhesion holds the line."""
    h = 1e-4
    depths = [0.02, -0.002, -0.01, -0.04]
    path = load_path(one_sided(), depths=depths, method="lattice", spacing=h)
    left = path.contacts[:, 0]
    right = path.contacts[:, 1]
    bare = 0.1 - np.sqrt(0.1**2 - 2 * 0.002)  # x²/2 - l x = d
    assert left[1] == pytest.approx(bare, abs=h / 10)
    assert left[2:] == pytest.approx([0.05, 0.05], abs=h)
    u = depths[3] - np.array([left[3], right[3]]) ** 2 / 2
    springs = depths[3] * (right[3] - left[3]) - (right[3] ** 3 - left[3] ** 3) / 6
    assert path.force[3] == pytest.approx(springs + 0.1 * u.sum(), rel=1e-3)
    assert path.force[3] == pytest.approx(-0.00937, abs=2e-5)
    whole = load_path(one_sided(), depths=[*depths, -0.2], method="lattice", spacing=h)
    assert whole.work() == pytest.approx(whole.dissipated, rel=1e-12, abs=0)
    tilted = replace(one_sided(), pattern=Patches([-0.05], [1.0, 0.0]))
    other = load_path(tilted, depths=depths, method="lattice", spacing=h)
    assert other.contacts[:, ::-1] == pytest.approx(-path.contacts, abs=1e-12)


def test_a_line_left_at_the_apex_does_not_pass():
    branch = LatticeBranch.of(one_sided(), 1e-4, 0.02)
    point = moved(branch, moved(branch, branch.first, 0.02), -0.04)
    ((first, last),) = point.memory
    assert first == branch.row.touch + 500
    branch.certify(point)
    with pytest.raises(NotCertifiedError, match="neighbours"):
        branch.certify(point._replace(memory=((branch.row.touch, last),)))


@pytest.mark.parametrize("opening", [None, 0.002])
def test_a_contact_opens_on_a_bare_patch(opening):
    """It is pulled there, with a contact on either side; on a weak patch it stays whole."""
    scene = one_sided((1.0, 0.0, 1.0), (0.05, 0.1))
    if opening:
        scene = replace(scene, opening=SurfaceEnergies.from_work(scene.gamma1, opening))
    depths = [0.02, -0.02, -0.01, -0.02, -0.3]
    path = load_path(scene, depths=depths, method="lattice", spacing=1e-3)
    assert [len(inner) // 2 for inner in path.inner[:2]] == [0, 1]
    lines = path.at(1).lines
    assert lines[1] == pytest.approx(0.05, abs=1e-3) and lines[2] == pytest.approx(0.1, abs=1e-3)
    assert "splitting" in [event.kind for event in path.events]
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)
    whole = replace(scene, pattern=Patches((0.05, 0.1), (1.0, 0.5, 1.0)))
    path = load_path(whole, depths=[0.02, -0.02], method="lattice", spacing=1e-3)
    assert path.inner[1] == ()


def programmes(scene, top, **options):
    """A dead load and a soft machine, in to about this depth and out until contact is lost."""
    delta0 = scene.critical_separation
    force = load_path(scene, depths=[top], **options).force[0]
    stiffness = 0.3 * scene.stiffness * scene.elastocapillary_length
    far = top + force / stiffness
    return (
        {"forces": np.r_[np.linspace(0, force, 9), np.linspace(force, -4 * force, 25)]},
        {
            "drives": np.r_[np.linspace(-delta0, far, 9), np.linspace(far, -40 * delta0, 25)],
            "machine_stiffness": stiffness,
        },
    )


def assert_balanced(path):
    held = ~np.isnan(path.contacts[:, 0])
    load = path.values if path.control == "force" else path.values - path.depth
    load = load * (path.machine_stiffness or 1.0)
    assert held.sum() > 5
    assert np.abs(path.force - load)[held].max() <= 1e-11 * np.abs(load[held]).max()
    assert np.isnan(path.contacts[-1]).all()
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


WELL = plain(
    Profile(
        lambda x: 0.3 * (np.asarray(x, float) ** 2 - 1) ** 2 + 0.1 * np.asarray(x, float) ** 2,
        lambda x: 1.2 * x * (np.asarray(x, float) ** 2 - 1) + 0.2 * np.asarray(x, float),
        extent=(-2.5, 2.5),
    ),
    w=0.02,
)


@pytest.mark.parametrize("control", [0, 1])
def test_two_contacts_under_a_load(control):
    """Second order in the spacing, and the energy balance closes with both contacts."""
    touch = 0.1 - 0.1**2 / 1.2
    given = programmes(WELL, touch + 0.1)[control]
    fine = load_path(WELL, **given)
    errors = []
    for spacing in (0.08, 0.04, 0.02, 0.01):
        path = load_path(WELL, **given, method="lattice", spacing=spacing)
        assert max(map(len, path.inner)) == 2
        assert_balanced(path)
        steps = slice(2, 15)
        assert [len(i) for i in path.inner[steps]] == [len(i) for i in fine.inner[steps]]
        errors.append(np.abs(path.depth[steps] - fine.depth[steps]).max())
    slope = np.polyfit(np.log([8, 4, 2, 1]), np.log(errors), 1)[0]
    assert 1.6 <= slope <= 2.4
    assert errors[-1] <= 1e-3 * WELL.critical_separation


@pytest.mark.parametrize("seed", [1, 2, 5, 8, 12, 14, 16, 20, 23])
def test_path_without_adhesion_is_an_obstacle_problem(seed):
    """Whatever the profile: the same contacts, nothing lost, and no line jumps."""
    case = case_of("no_adhesion", seed)
    scene = case.scene
    spacing = case.feature / 9
    depths = case.above + case.scale * np.r_[np.linspace(-0.2, 2, 10), np.linspace(1.9, -0.2, 8)]
    path = load_path(scene, depths=depths, method="lattice", spacing=spacing)
    for step, depth in enumerate(depths.tolist()):
        state = minimise(scene, depth, method="lattice", spacing=spacing)
        if not state.contacts.size:
            assert np.isnan(path.contacts[step, 0])
            continue
        lines = np.array(path.at(step).lines)
        assert lines.shape == state.nodes.ravel().shape
        assert np.abs(lines - state.nodes.ravel()).max() <= 0.51 * spacing
    assert abs(path.dissipated) <= 1e-12 * np.abs(path.energy).max()
    kinds = {event.kind for event in path.events}
    assert kinds <= {"touch", "nucleation", "splitting", "closing", "coalescence", "detachment"}
    assert max(map(len, path.inner)) > 0


def dead_load_of(seed, nodes):
    """A random profile, so many nodes on its shortest length, pressed and pulled by dead loads."""
    case = case_of("small", seed)
    scene = case.scene
    rng = np.random.default_rng(seed)
    options = {"method": "lattice", "spacing": case.feature / rng.uniform(*nodes)}
    depths = np.linspace(-0.1, rng.uniform(0.3, 3), 30) * case.scale + case.above
    deepest = load_path(scene, depths=depths, **options).force.max()
    least = scene.stiffness * case.scale * scene.elastocapillary_length
    force = max(deepest, least)
    forces = np.r_[np.linspace(0, force, 12), np.linspace(force, -3 * force, 20)]
    return load_path(scene, forces=forces, **options)


def test_energy_released_by_a_pull_off():
    """Its lines jump as it begins: what the load does until they are gone counts."""
    path = dead_load_of(29, (8, 16))
    assert path.events[-1].kind == "pull-off"
    assert path.events[-1].after.depth < path.events[-1].before.depth
    assert min(event.energy_released for event in path.events) > 0
    assert_balanced(path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [24, 62, 81])
def test_nothing_is_pulled_off_by_a_growing_load(seed):
    """P between the nodes may fall and rise again by what a link changes, or rise by a jump."""
    path = dead_load_of(seed, (8, 16))
    pulled = [event.step for event in path.events if event.kind == "pull-off"]
    assert len(pulled) == 1 and pulled[0] >= 12
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


def test_state_left_before_an_event():
    """Where P between the nodes falls by what a link changes; the next contact begins far below."""
    case = case_of("small", 62)
    scene = case.scene
    rng = np.random.default_rng(62)
    spacing = case.feature / rng.uniform(8, 16)
    delta0 = case.scale
    top = case.above + delta0 * rng.uniform(0.3, 3)
    drives = np.r_[
        np.linspace(case.above - delta0, top, 12), np.linspace(top, case.above - 20 * delta0, 40)
    ]
    K = 0.3 * scene.stiffness * scene.elastocapillary_length
    path = load_path(scene, drives=drives, machine_stiffness=K, method="lattice", spacing=spacing)
    held = ~np.isnan(path.contacts[:, 0])
    assert held.sum() > 5
    load = K * (drives - path.depth)
    assert np.abs(path.force - load)[held].max() <= 1e-10 * np.abs(load[held]).max()
    assert min(event.energy_released for event in path.events) >= 0


def test_jumps_under_a_load_pass_any_number_of_links():
    """One jump is a hundredth of the way up: P has to be looked at wherever a link is passed."""
    rng = np.random.default_rng(3)
    x = np.linspace(-30, 30, 1201)
    waves = (np.cos(2 * np.pi * n * x / 20 + rng.uniform(0, 6.3)) * 0.02 / n for n in range(1, 9))
    z = sum(waves) + 0.002 * x**2
    scene = plain(Sampled(x, z - z.min(), kind="smooth"), w=0.01)
    nodes = {"method": "lattice", "spacing": 0.05}
    down = np.linspace(0.0, 0.25, 2001)
    up = np.linspace(0.25, -0.085, 4001)
    imposed = load_path(scene, depths=np.concatenate([down, up]), **nodes)
    force = imposed.force[2000:]
    held = load_path(scene, forces=[0.0, *np.linspace(force[0], 1.3 * force.min(), 300)], **nodes)
    lower = force <= np.minimum.accumulate(force)  # than ever before: at rest under some load
    last = np.flatnonzero(lower[:-1] & ~lower[1:])
    first = last + 1 + np.array([np.argmax(lower[i + 1 :]) for i in last])
    jumps = [(event.before.depth, event.after.depth) for event in held.events[2:-1]]
    assert len(jumps) == 2
    assert np.abs(up[[*zip(last, first, strict=True)]] - jumps).max() <= 2.5e-4


@pytest.mark.parametrize("spacing", [2e-3, 1e-3, 5e-4, 2.5e-4])
def test_the_pull_off_between_steps_is_found_on_nodes_as_well(spacing):
    scene = adhesive(Parabola(1.0))
    nodes = {"method": "lattice", "spacing": spacing}
    given = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    known = cards.parabola.pull_off(R=1.0, **given)
    delta0 = scene.critical_separation
    found = load_path(scene, depths=[0.0, delta0, -2 * delta0], **nodes).pull_off
    coarse = (spacing / scene.elastocapillary_length) ** 2
    assert found.force == pytest.approx(known.force, rel=0.03 * coarse, abs=0)
    assert abs(found.half_width - known.half_width) <= spacing


@pytest.mark.parametrize("off", [0.1, 0.3, 0.5])
def test_first_touch_by_the_parabola_of_nodes(off):
    """Not where the lowest node touches: the profile has its lowest point between nodes."""
    spacing = 0.05
    body = Profile(
        lambda x: (np.asarray(x, float) - off * spacing) ** 2 / 2,
        lambda x: np.asarray(x, float) - off * spacing,
        extent=(-4.0, 4.0),
    )
    scene = plain(body, w=0.02)
    nodes = {"method": "lattice", "spacing": spacing}
    path = load_path(scene, depths=[-1e-3, 1e-12, 0.1, -0.5], **nodes)
    assert path.events[0].kind == "jump-in"
    assert abs(path.events[0].depth) <= 1e-15
    exact = load_path(scene, depths=[-1e-3, 1e-12, 0.1, -0.5])
    assert path.force[:3] == pytest.approx(exact.force[:3], rel=2e-3)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)
