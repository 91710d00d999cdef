"""Paths of any profile on the fitted mesh: every control, hysteresis, patterns, no adhesion."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import DELTA0, L, adhesive, rippled
from test_fitted_path import apart
from truth.scenes import case_of

from discretization import load_path, minimise
from discretization.profile import resolve
from energy import Parabola, Patches, Sampled, SurfaceEnergies

LOOP = np.r_[-0.1, np.linspace(0, 1.6, 5), np.linspace(1.3, -1.6, 12)] * DELTA0
PATCHES = Patches(np.array([-1.3, -0.45, 0.15, 0.8]) * L, (1.0, 0.5, 0.9, 0.4, 1.0))
STRONGER = SurfaceEnergies.from_work(0.07, 0.003)
CASES = {
    "opening": {"opening": STRONGER},
    "pattern": {"pattern": PATCHES},
    "both": {"opening": STRONGER, "pattern": PATCHES},
}


def crests(**more):
    """Contact begins at the middle crest, and twice beside it on the way."""
    return replace(adhesive(rippled(0.03, 0.6 * L, 0.17 * DELTA0, (-8 * L, 8 * L))), **more)


@pytest.fixture(scope="module")
def paths():
    return {name: load_path(crests(**more), depths=LOOP) for name, more in CASES.items()}


@pytest.mark.parametrize("name", CASES)
def test_what_holds_the_lines_loses_what_is_put_in(paths, name):
    path = paths[name]
    assert max(len(inner) for inner in path.inner) >= 2
    assert np.isnan(path.contacts[-1, 0])
    assert path.work() == pytest.approx(path.dissipated, rel=1e-10, abs=0)
    assert path.dissipated > sum(event.energy_released for event in path.events) * (1 - 1e-12)
    assert (path.friction > 0.02 * path.dissipated) == (name != "pattern")


@pytest.mark.parametrize("name", CASES)
def test_nodes_tend_to_it(paths, name):
    """With first order at least: with two works of adhesion a line that is held is at a node."""
    errors = []
    for links in (100, 800):
        nodes = load_path(crests(**CASES[name]), depths=LOOP, method="lattice", spacing=L / links)
        same = [len(a) == len(b) for a, b in zip(nodes.inner, paths[name].inner, strict=True)]
        assert np.mean(same) > 0.85
        errors.append(np.median(np.abs(nodes.force - paths[name].force)[same][1:]))
    assert errors[-1] < 1e-3 * np.abs(paths[name].force).max()
    assert errors[-1] < errors[0] / 4


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("level", [0.9, -0.5])
def test_one_state_is_the_end_of_its_path(name, level):
    scene = crests(**CASES[name])
    depths = [-0.1 * DELTA0, max(level, 0.0) * DELTA0, level * DELTA0]
    state, path = minimise(scene, depths[-1]), load_path(scene, depths=depths)
    assert state.certificate.ok and state.label == "adhered"
    assert state.contacts.ravel() == pytest.approx(path.at(-1).lines, rel=0, abs=1e-11 * L)
    assert state.force == pytest.approx(path.force[-1], rel=1e-10, abs=0)


def test_without_adhesion_the_path_has_the_states_of_minimise():
    scene = crests(surfaces=SurfaceEnergies.from_work(0.07, 0.0))
    path = load_path(scene, depths=LOOP)
    for depth, force in zip(LOOP[2:8], path.force[2:8], strict=True):
        assert force == pytest.approx(minimise(scene, depth).force, rel=1e-10, abs=0)
    size = path.energy.max()
    assert path.dissipated == pytest.approx(0.0, rel=0, abs=1e-11 * size)
    assert path.work() == pytest.approx(0.0, rel=0, abs=1e-11 * size)


@pytest.mark.slow
def test_many_corners_stop_lines_and_nothing_is_lost():
    x = np.linspace(-3, 3, 121) * L
    rng = np.random.default_rng(5)
    heights = x**2 / 0.06 + 0.02 * DELTA0 * np.cumsum(rng.normal(size=x.size))
    path = load_path(adhesive(Sampled(x, heights)), depths=LOOP + heights.min())
    assert len(path.events) > 2 and np.isnan(path.contacts[-1, 0])
    assert path.work() == pytest.approx(path.dissipated, rel=1e-10, abs=0)


def test_a_stiff_machine_imposes_the_depth_and_a_soft_one_the_force():
    scene, k, depths = crests(), crests().stiffness * L, np.array([-0.1, 0.7, 1.6]) * DELTA0
    imposed = load_path(scene, depths=depths)
    for more in (1e3, 1e5):
        path = load_path(scene, drives=depths, machine_stiffness=more * k)
        assert np.abs(path.force - imposed.force).max() < 10 / more * np.abs(imposed.force).max()
    forces = np.array([0.0, 0.5, 1.0]) * imposed.force.max()
    dead = load_path(scene, forces=forces)
    soft = 1e-4 * k
    machine = load_path(scene, drives=forces / soft, machine_stiffness=soft)
    assert machine.force[1:] == pytest.approx(dead.force[1:], rel=1e-3, abs=0)
    assert dead.force == pytest.approx(forces, rel=0, abs=1e-12 * forces[-1])


def test_two_contacts_far_apart_share_a_dead_load():
    """Of two equal parabolas each bears half, until they let go one after the other."""
    c = 60 * L
    both, one = adhesive(apart(c)), adhesive(Parabola(0.003))
    depths = np.array([-0.1, 0.4, 0.2]) * DELTA0
    single = (
        load_path(one, depths=depths),
        load_path(adhesive(Parabola(0.005)), depths=depths - 0.1 * DELTA0),
    )
    total = single[0].force[1:] + single[1].force[1:]
    path = load_path(both, forces=[0.0, *total])
    assert path.depth[1:] == pytest.approx(depths[1:], rel=0, abs=1e-10 * DELTA0)


def test_springs_lose_their_work_of_adhesion_wherever_they_have_been_touched():
    """γ₁ = 0: each attaches when touched and lets go at u = -δ₀, at a loss of w."""
    w, deep = 0.002, rippled(0.03, 0.6 * L, 0.6 * DELTA0, (-8 * L, 8 * L))
    scene = adhesive(deep, gamma1=0.0, w=w)
    path = load_path(scene, depths=LOOP)
    x = np.linspace(-8 * L, 8 * L, 4_000_001)
    touched = np.mean(scene.indenter.height(x) < LOOP.max()) * 16 * L
    assert max(len(inner) for inner in path.inner) >= 4
    assert path.work() == pytest.approx(w * touched, rel=1e-5, abs=0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-8, abs=0)
    for depth, force in zip(LOOP[2:6], path.force[2:6], strict=True):
        assert force == pytest.approx(minimise(scene, depth).force, rel=1e-12, abs=0)


def test_under_a_dead_load_contacts_begin_and_the_balance_closes():
    scene = crests()
    most = load_path(scene, depths=LOOP[:6]).force.max()
    path = load_path(scene, forces=np.r_[np.linspace(0, most, 4), np.linspace(most, -most, 6)])
    kinds = [event.kind for event in path.events]
    assert kinds[0] == "jump-in" and "nucleation" in kinds and kinds[-1] == "pull-off"
    assert path.work() == pytest.approx(path.dissipated, rel=1e-10, abs=0)
    assert min(event.energy_released for event in path.events) > 0


def test_without_adhesion_a_path_begins_with_less_than_rounding():
    """Where it is asked for first, the contact is only 5e-10 l wide."""
    case = case_of("no_adhesion", 1)
    touch = resolve(case.scene, case.depth).touch
    path = load_path(case.scene, depths=touch + case.scale * np.array([-0.1, 2e-9, 0.4, 0.8]))
    states = [minimise(case.scene, float(depth)) for depth in path.depth[2:]]
    assert path.force[2:] == pytest.approx([state.force for state in states], rel=1e-11, abs=0)
    assert len(states[-1].contacts) == 4
