"""Dead load and machine on the lattice: the loads are balanced, and so is the energy, exactly."""

import numpy as np
import pytest
from scenes import adhesive, plain
from test_many_contacts import bumps
from truth.scenes import case_of

from discretization import load_path, minimise
from energy import FlatPunch, Parabola, Profile, Wedge

BODIES = {
    "parabola": Parabola(0.02),
    "tilted": Parabola(0.02).tilted(0.05),
    "wedge": Wedge(0.05),
    "punch": FlatPunch(0.03),
}
SPACING = 1e-4


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


def load_of(path):
    """The load on the indenter at every step."""
    return (
        path.values
        if path.control == "force"
        else path.machine_stiffness * (path.values - path.depth)
    )


def assert_balanced(path):
    held = ~np.isnan(path.contacts[:, 0])
    load = load_of(path)
    assert held.sum() > 5
    assert np.abs(path.force - load)[held].max() <= 1e-11 * np.abs(load[held]).max()
    assert np.isnan(path.contacts[-1]).all()
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


@pytest.mark.parametrize("control", [0, 1])
@pytest.mark.parametrize("body", BODIES)
def test_a_load_on_the_lattice_is_that_on_the_fitted_mesh(body, control):
    scene = adhesive(BODIES[body])
    given = programmes(scene, 2 * scene.critical_separation)[control]
    path = load_path(scene, **given, method="lattice", spacing=SPACING)
    fine = load_path(scene, **given)
    assert_balanced(path)
    assert [event.kind for event in path.events] == [event.kind for event in fine.events]
    both = ~np.isnan(path.contacts[:, 0]) & ~np.isnan(fine.contacts[:, 0])
    off = np.abs(path.depth[both] - fine.depth[both]).max()
    assert off <= 5e-5 * scene.critical_separation
    assert path.pull_off.force == pytest.approx(fine.pull_off.force, rel=0.01, abs=0)


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


def test_contacts_begin_and_end_under_a_load():
    scene = adhesive(bumps([0.0, 3e-4, 1e-4]), w=2e-4)
    options = {"method": "lattice", "spacing": 4e-5}
    for given in programmes(scene, 6 * scene.critical_separation, **options):
        path = load_path(scene, **given, **options)
        assert_balanced(path)
        assert "nucleation" in [event.kind for event in path.events]
        assert min(event.energy_released for event in path.events) >= 0


def test_a_stiff_machine_imposes_the_depth_and_a_soft_one_the_force():
    touch, delta0 = 0.1 - 0.1**2 / 1.2, WELL.critical_separation
    options = {"method": "lattice", "spacing": 0.02}
    depths = touch + np.linspace(0.02, 0.5, 7) * delta0
    exact = load_path(WELL, depths=depths, **options)
    scale = WELL.stiffness * WELL.elastocapillary_length
    for stiffness in (1e6 * scale, 1e8 * scale):
        path = load_path(WELL, drives=depths, machine_stiffness=stiffness, **options)
        assert np.abs(path.force - exact.force).max() <= 20 * scale / stiffness * scale * delta0
    dead = load_path(WELL, forces=exact.force[3:], **options)
    for stiffness in (1e-6 * scale, 1e-8 * scale):
        drives = exact.force[3:] / stiffness
        soft = load_path(WELL, drives=drives, machine_stiffness=stiffness, **options)
        assert np.abs(soft.depth - dead.depth).max() <= 20 * stiffness / scale * delta0


@pytest.mark.parametrize("seed", [1, 2, 5, 8, 12, 14, 16, 20, 23])
def test_without_adhesion_a_path_passes_the_states_of_an_obstacle(seed):
    """Whatever the profile: the same contacts, nothing lost, and no line jumps."""
    case = case_of("no_adhesion", seed)
    scene, spacing = case.scene, case.feature / 9
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
    scene, rng = case.scene, np.random.default_rng(seed)
    options = {"method": "lattice", "spacing": case.feature / rng.uniform(*nodes)}
    depths = np.linspace(-0.1, rng.uniform(0.3, 3), 30) * case.scale + case.above
    deepest = load_path(scene, depths=depths, **options).force.max()
    least = scene.stiffness * case.scale * scene.elastocapillary_length
    force = max(deepest, least)
    forces = np.r_[np.linspace(0, force, 12), np.linspace(force, -3 * force, 20)]
    return load_path(scene, forces=forces, **options)


def test_a_pull_off_releases_energy_down_to_where_the_contact_closes():
    """Its lines jump as it begins: what the load does until they are gone counts."""
    path = dead_load_of(29, (8, 16))
    assert path.events[-1].kind == "pull-off"
    assert path.events[-1].after.depth < path.events[-1].before.depth
    assert min(event.energy_released for event in path.events) > 0
    assert_balanced(path)


@pytest.mark.parametrize("seed", [24, 62, 71, 81, 88])
def test_nothing_is_pulled_off_by_a_growing_load(seed):
    """P between the nodes may fall and rise again by what a link changes, or rise by a jump."""
    path = dead_load_of(seed, (8, 16))
    pulled = [event.step for event in path.events if event.kind == "pull-off"]
    assert len(pulled) == 1 and pulled[0] >= 12
    assert path.work() == pytest.approx(path.dissipated, rel=1e-12, abs=0)


def test_a_state_that_is_left_before_an_event_does_not_wait_for_that_event():
    """Where P between the nodes falls by what a link changes; the next contact begins far below."""
    case = case_of("small", 62)
    scene, rng = case.scene, np.random.default_rng(62)
    spacing, delta0 = case.feature / rng.uniform(8, 16), case.scale
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
