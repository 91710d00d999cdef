"""A path under a load or a machine is the path at imposed depths: same depths, same states."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive

from discretization import load_path
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

BODIES = {
    "parabola": Parabola(9.0),
    "punch": FlatPunch(0.7),
    "wedge": Wedge(0.12),
    "power": PowerLaw(0.1, 20) + FlatPunch(1.0),
    "tilted": Parabola(3.0).tilted(0.1),
}
SURFACES = {  # γ₁, w, w of opening
    "tension": (1.3, 0.0, None),
    "springs": (0.0, 0.0, None),
    "adhesion": (1.3, 0.02, None),
    "adhesive springs": (0.0, 0.02, None),
    "two works": (1.3, 0.02, 0.1),
}


def scene_of(body, surfaces):
    gamma1, w, opening = SURFACES[surfaces]
    return adhesive(BODIES[body], k=1.9, gamma1=gamma1, w=w, opening=opening)


@pytest.mark.parametrize("surfaces", SURFACES)
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("stiffness", [0.0, 0.6])
def test_every_step_balances_its_load_and_is_a_state_of_the_depth_path(body, surfaces, stiffness):
    scene, values = scene_of(body, surfaces), np.array([0.05, 0.1, 0.2, 0.07, 0.3, 0.01])
    if stiffness:
        path = load_path(scene, drives=values, machine_stiffness=stiffness)
        load = stiffness * (values - path.depth)
    else:
        path, load = load_path(scene, forces=values), values
    assert path.force == pytest.approx(load, rel=0, abs=1e-11 * np.abs(load).max())
    again = load_path(scene, depths=path.depth)
    assert again.half_width == pytest.approx(path.half_width, rel=1e-13, abs=0)
    assert again.force == pytest.approx(path.force, rel=0, abs=1e-12 * np.abs(load).max())


@pytest.mark.parametrize("body", BODIES)
def test_nothing_holds_a_contact_without_adhesion(body):
    path = load_path(scene_of(body, "tension"), forces=[0.1, -1e-6])
    assert [event.kind for event in path.events] == ["touch", "pull-off"]
    assert path.half_width[-1] == path.force[-1] == 0.0
    assert path.events[-1].force == pytest.approx(0.0, abs=1e-13)


def test_a_profile_whose_knots_nobody_told_is_loaded_as_exactly():
    x = np.array([-24.0, -22.0, -15.0, -14.0, -7.0, 2.0, 6.0, 16.0])
    spline = Sampled(x, np.abs(x) ** 2.3 / 6, kind="smooth")
    told = Profile(spline.height, spline.slope, extent=spline.extent, convex=True)
    scene = scene_of("parabola", "adhesion")
    force = load_path(replace(scene, indenter=told), forces=[40.0]).force[0]
    assert force == pytest.approx(40.0, rel=1e-13, abs=0)


def test_a_change_of_the_load_below_rounding_is_no_instability():
    layer = ElasticLayer(8.827400528964317e-09, 0.0, 5.446432590758204)
    surfaces = SurfaceEnergies.from_work(2.5088464360903674e-07, 2.5088464360903673e-19)
    scene = Scene(layer, surfaces, Wedge(1.6383029836310005e-07), slopes="finite")
    drives = np.array([5.582945e-06, -1.7595097904911395e-05, -1.759509790492899e-05])
    path = load_path(scene, drives=drives, machine_stiffness=5.6e-10)
    assert [event.kind for event in path.events] == ["jump-in"]
    assert path.half_width[2] == pytest.approx(path.half_width[1], rel=1e-13, abs=0)


def test_a_force_that_bends_upwards_with_depth_is_followed_up_again():
    """Finite slopes: P' falls on the way, so that a secant points to where there is no contact."""
    surfaces = SurfaceEnergies.from_work(1.0, 0.3)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, PowerLaw(3e4, 4), slopes="finite")
    loads = np.array([11.5, -0.545, 0.88, -0.7])
    path = load_path(scene, forces=loads)
    assert [event.kind for event in path.events] == ["jump-in"]
    assert np.allclose(path.force, loads, rtol=5e-14, atol=0)


def test_a_trial_line_far_from_its_contact_overflows_no_height():
    layer = ElasticLayer(15176.15686299098, 0.0, 299295963.32060844)
    surfaces = SurfaceEnergies.from_work(5161235914605.363, 5161235.914605363)
    body = PowerLaw(3.0625326182347254e-204, 20).shifted(-60182743520.28064)
    depths = [236142.71773194047, -451191.5371889529, 1218124.8445969347]
    path = load_path(Scene(layer, surfaces, body), depths=depths)
    centred = load_path(Scene(layer, surfaces, body.base), depths=depths)
    known = np.spacing(np.abs(depths).max()) / 6e-10  # of a line, as D grows by 6e-10 of its way
    assert np.allclose(path.half_width, centred.half_width, rtol=1e-14, atol=known)
