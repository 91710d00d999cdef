"""Load paths against the closed forms of jump-ins, pull-off and loop areas."""

import math

import numpy as np
import pytest
from scenes import adhesive

from discretization.loading import load_path
from energy import ElasticLayer, FlatPunch, Parabola, Scene, SurfaceEnergies, Wedge, cards
from studies.shared.random_cases import random_case

CONTROLS = ("depth", "force", "drive")
BARS = 1e-10


def parts(case):
    """Names of the shape's cards, its parameters and the scene's."""
    scene, body = case.scene, case.scene.indenter
    own = {"flat": "half_width", "wedge": "delta", "parabola": "R"}[case.shape]
    shape = {"a" if case.shape == "flat" else own: getattr(body, own)}
    material = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    return "flat_punch" if case.shape == "flat" else case.shape, shape | material


def programme(control, case, stiffness):
    """Touch, press in, retract until the contact is lost: two steps."""
    scene = case.scene
    d = 2 * scene.critical_separation
    size = scene.elastocapillary_length + case.half_width
    if control == "depth":
        return {"depths": [d, -d]}
    if control == "drive":
        return {"drives": [2 * d, -1e5 * d], "machine_stiffness": stiffness}
    force = scene.stiffness * d * size
    return {"forces": [force, -1e3 * force]}


@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("shape", ["flat", "wedge", "parabola"])
def test_events_and_loop_areas_are_those_of_the_cards(shape, control):
    rng = np.random.default_rng(len(shape) + 10 * len(control))
    for _ in range(6):
        case = random_case(rng, shape)
        scene, (name, given) = case.scene, parts(case)
        delta0, length = scene.critical_separation, scene.elastocapillary_length
        stiffness = scene.stiffness * length * 10 ** rng.uniform(-1, 1.5)
        path = load_path(scene, **programme(control, case, stiffness))
        module = {
            "depth": cards.displacement_control,
            "force": cards.load_control,
            "drive": cards.machine_control,
        }[control]
        of_machine = {"K": stiffness} if control == "drive" else {}
        depth_like = cards.displacement_control if shape == "flat" else module
        jump = getattr(depth_like, f"{name}_jump_in")(
            **given, **(of_machine if depth_like is module else {})
        )
        if control == "force":
            module = depth_like
        let_go = getattr(module, f"{name}_detachment")(**given, **of_machine)
        area = float(getattr(module, f"{name}_loop_area")(**given, **of_machine))
        first, last = path.events[0], path.events[-1]
        assert first.kind == "jump-in"
        assert last.kind == ("detachment" if control == "depth" else "pull-off")
        tension = scene.stiffness * delta0 * (length + jump.half_width)
        assert first.after.half_width == pytest.approx(jump.half_width, rel=BARS, abs=0)
        assert abs(first.after.force - jump.force) <= BARS * tension
        assert abs(first.energy_released - jump.energy_released) <= BARS * area
        assert last.force == pytest.approx(let_go.force, rel=BARS, abs=0)
        assert abs(last.depth - let_go.depth) <= BARS * delta0
        assert abs(last.before.half_width - let_go.half_width) <= BARS * jump.half_width
        assert last.energy_released == pytest.approx(let_go.energy_released, rel=BARS, abs=0)
        assert path.dissipated == pytest.approx(area, rel=BARS, abs=0)
        assert path.work() == pytest.approx(path.dissipated, rel=1e-11, abs=0)
        most = let_go if shape == "flat" else getattr(cards, name).pull_off(**given)
        assert path.pull_off.force == pytest.approx(most.force, rel=BARS, abs=0)
        assert abs(path.pull_off.depth - most.depth) <= BARS * delta0
        assert abs(path.pull_off.half_width - most.half_width) <= BARS * jump.half_width


def test_adhesion_hysteresis_pins_the_line_and_dissipates():
    k, gamma1, closing, opening, R = 130.0, 0.07, 0.001, 0.003, 0.02
    scene = adhesive(Parabola(R), w=closing, opening=opening)
    works = {"c": 1 / (2 * R), "n": 2.0, "k": k, "gamma1": gamma1, "w_closing": closing}
    top = 2 * scene.critical_separation
    down = cards.two_works.half_widths(0.0, **works, w=opening)
    path = load_path(scene, depths=[top, 0.0, top])
    up = cards.two_works.half_widths(top, **works, w=opening)
    assert path.half_width[0] == pytest.approx(up[0], rel=1e-13, abs=0)
    assert path.half_width[1] == pytest.approx(min(up[0], down[1]), rel=1e-13, abs=0)
    bottom = -0.96 * scene.opened.critical_separation
    cycles = load_path(scene, depths=[top, bottom, top, bottom, top])
    area = cards.two_works.cycle_area(**works, w=opening, d_min=bottom, d_max=top)
    once = load_path(scene, depths=[top, bottom, top])
    assert cycles.friction - once.friction == pytest.approx(float(area), rel=1e-13, abs=0)
    assert area > 0
    whole = load_path(scene, depths=[top, -4 * top])
    loop = cards.two_works.loop_area(**works, w=opening, d_max=top)
    assert whole.dissipated == pytest.approx(float(loop), rel=1e-13, abs=0)
    assert whole.work() == pytest.approx(whole.dissipated, rel=1e-11, abs=0)


def test_springs_without_tension_lose_what_they_gained_by_closing():
    scene = adhesive(Parabola(0.02), gamma1=0.0)
    top = 3 * scene.critical_separation
    path = load_path(scene, depths=[top, -2 * top])
    assert path.half_width[0] == pytest.approx(math.sqrt(2 * 0.02 * top), rel=1e-13, abs=0)
    lost = scene.work_of_adhesion * 2 * math.sqrt(2 * 0.02 * top)
    assert path.dissipated == pytest.approx(lost, rel=1e-13, abs=0)
    assert path.work() == pytest.approx(lost, rel=1e-9, abs=0)


def test_a_stiff_machine_imposes_the_depth_and_a_soft_one_the_force():
    scene = adhesive(Parabola(0.5))
    given = {"R": 0.5, "k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    delta0 = scene.critical_separation
    reference = scene.stiffness * scene.elastocapillary_length
    stiff = load_path(scene, drives=[delta0, -3 * delta0], machine_stiffness=1e9 * reference)
    assert stiff.depth[0] == pytest.approx(delta0, rel=1e-8, abs=0)
    end = cards.displacement_control.parabola_detachment(**given)
    assert stiff.events[-1].depth == pytest.approx(end.depth, rel=1e-13, abs=0)
    soft = load_path(
        scene, drives=[1e5 * delta0, -1e6 * delta0], machine_stiffness=1e-4 * reference
    )
    end = cards.load_control.parabola_detachment(**given)
    assert soft.events[-1].force == pytest.approx(end.force, rel=1e-6, abs=0)
    for step in range(2):
        held = 1e9 * reference * (stiff.values[step] - stiff.depth[step])
        if stiff.half_width[step]:
            assert held == pytest.approx(stiff.force[step], rel=1e-5, abs=0)


def test_a_contact_of_nanometres_still_holds():
    """Letting go does not come early where the last contact is far narrower than l."""
    k, w, b = ElasticLayer(300.0, 0.4, 1e-5).stiffness, 1e-4, 5e-5
    delta0 = math.sqrt(2 * w / k)
    for tension, steps in ((3, 20), (30, 60)):
        scene = Scene(
            ElasticLayer(300.0, 0.4, 1e-5),
            SurfaceEnergies.from_work(k * (tension * b) ** 2, w),
            Parabola(b * b / delta0),
        )
        depths = -delta0 + 3 * delta0 * np.linspace(1, 0, steps) ** 2
        path = load_path(scene, depths=[*depths, -1.4 * delta0])
        expected = 2 * w * scene.elastocapillary_length
        assert path.events[-1].energy_released == pytest.approx(expected, rel=1e-11, abs=0)


def test_springs_without_tension_under_a_flat_punch_let_go_at_the_critical_separation():
    scene = adhesive(FlatPunch(0.03), gamma1=0.0)
    delta0 = scene.critical_separation
    full = 2 * scene.stiffness * 0.03 * delta0
    for given in ({"depths": [0.01 * delta0, -2 * delta0]}, {"forces": [full, -10 * full]}):
        path = load_path(scene, **given)
        assert path.events[-1].depth == pytest.approx(-delta0, rel=1e-11, abs=0)
        assert path.pull_off.force == pytest.approx(-full, rel=1e-11, abs=0)


def test_a_line_that_comes_free_can_be_the_pull_off():
    """Under a dead load, springs without tension: pinned up to d = 0, unstable from there on."""
    scene = adhesive(Wedge(0.05), gamma1=0.0)
    delta0, slope, k = scene.critical_separation, math.tan(0.05), scene.stiffness
    deepest = delta0
    force = k * deepest**2 / slope
    path = load_path(scene, forces=[force, -3 * force])
    assert path.pull_off.depth == pytest.approx(0.0, abs=1e-7 * delta0)
    assert path.pull_off.force == pytest.approx(-k * delta0**2 / slope, rel=1e-12, abs=0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)
