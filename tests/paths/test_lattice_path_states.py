"""`minimise` where the state depends on the path: adhesion hysteresis and patterns, on nodes."""

import math
from dataclasses import replace

import pytest
from scenes import adhesive
from test_many_contacts import bumps
from truth.scenes import case_of

from discretization import load_path, minimise
from energy import Parabola, Patches, Plane, SurfaceEnergies

SPACING = 1e-4
HYSTERETIC = adhesive(Parabola(0.02), w=0.001, opening=0.003)
STRIPED = replace(adhesive(Parabola(0.05)), pattern=Patches.stripes(0.004, 0.25, 1.0, 0.1))
BOTH = replace(
    adhesive(bumps([0.0, 3e-4, 1e-4]), w=2e-4, opening=4e-4),
    pattern=Patches.stripes(0.003, 0.5, 1.0, 0.1),
)
SCENES = {"opening": HYSTERETIC, "pattern": STRIPED, "both": BOTH}


@pytest.mark.parametrize("depth", [-2.5, -0.6, 0.3, 1.7, 4.0])
@pytest.mark.parametrize("name", SCENES)
def test_the_state_is_the_end_of_its_path(name, depth):
    scene = SCENES[name]
    depth = depth * scene.critical_separation
    spacing = SPACING if name != "both" else 4e-5
    state = minimise(scene, depth, method="lattice", spacing=spacing)
    path = load_path(scene, depths=[max(depth, 0.0), depth], method="lattice", spacing=spacing)
    assert len(state.contacts) == (len(path.inner[-1]) // 2 + 1 if state.contacts.size else 0)
    assert state.force == pytest.approx(path.force[-1], rel=1e-12, abs=0)
    assert state.energy == pytest.approx(path.energy[-1], rel=1e-12, abs=0)
    if not state.contacts.size:
        assert math.isnan(path.contacts[-1, 0]) and state.label == "detached"
        return
    assert state.certificate.ok and state.label == "adhered"
    assert state.contacts[0, 0] == path.contacts[-1, 0]
    assert state.contacts[-1, 1] == path.contacts[-1, 1]
    assert state.error_estimate["force"] > 0


@pytest.mark.parametrize("depth", [-1.5, -0.7, 0.4, 2.0])
def test_hysteresis_on_nodes_tends_to_that_on_the_fitted_mesh(depth):
    depth *= HYSTERETIC.critical_separation
    exact = load_path(HYSTERETIC, depths=[0.0, depth])
    errors = []
    for spacing in (4e-4, 2e-4, 1e-4, 5e-5):
        states = [
            minimise(HYSTERETIC, depth, method="lattice", spacing=spacing * stretch)
            for stretch in (0.9, 1.0, 1.13)
        ]
        scale = states[0].scales["energy"]
        errors.append(max(abs(state.energy - exact.energy[-1]) for state in states) / scale)
    assert errors[-1] <= 0.3 * errors[0]
    assert errors[-1] <= 0.01  # a line that is held keeps the node on which it came to rest


@pytest.mark.parametrize("name", SCENES)
def test_the_parts_of_the_energy_know_the_pattern(name):
    scene = SCENES[name]
    spacing = 2e-5
    state = minimise(scene, 1.5 * scene.critical_separation, method="lattice", spacing=spacing)
    total, scale = sum(state.energy_parts.values()), state.scales["energy"]
    assert total == pytest.approx(state.energy, rel=0, abs=2e-3 * scale)
    assert sum(state.force_parts.values()) == pytest.approx(
        state.force, rel=0, abs=2e-3 * state.scales["force"]
    )


def test_a_pattern_of_one_factor_is_another_work_of_adhesion():
    for seed in range(6):
        case = case_of("small", seed)
        plain, w = case.scene, case.scene.work_of_adhesion
        doubled = SurfaceEnergies.from_work(plain.gamma1, 2 * w)
        patched = replace(plain, pattern=Patches([0.0], [2.0, 2.0]))
        given = {"method": "lattice", "spacing": case.feature / 20}
        ours = minimise(patched, case.depth, **given)
        theirs = minimise(replace(plain, surfaces=doubled), case.depth, **given)
        assert ours.nodes == pytest.approx(theirs.nodes, rel=1e-12, abs=0)
        scale = theirs.scales["energy"] or 1.0
        assert ours.energy == pytest.approx(theirs.energy, rel=0, abs=0.02 * scale)


@pytest.mark.parametrize(
    "given",
    [{"branch": "global"}, {"method": "lattice", "spacing": 1e-4, "branch": "global"}],
    ids=str,
)
@pytest.mark.parametrize("name", ["opening", "pattern"])
def test_without_a_path_the_state_is_not_known(name, given):
    with pytest.raises(ValueError, match=rf"{name} = .* use branch='adhered'"):
        minimise(SCENES[name], 1e-3, **given)


def test_no_path_is_followed_for_a_plane():
    given = {"method": "lattice", "spacing": 1e-4}
    with pytest.raises(ValueError, match="opening = "):
        minimise(replace(HYSTERETIC, indenter=Plane()), 1e-3, **given)
    path = load_path(HYSTERETIC, depths=[0.0, 1e-3], **given)
    assert minimise(HYSTERETIC, 1e-3, **given).force == pytest.approx(path.force[-1], rel=1e-12)
