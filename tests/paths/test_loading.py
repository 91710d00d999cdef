"""Load paths: events, their energy balance, what is refused."""

import math

import numpy as np
import pytest
from scenes import adhesive

from discretization import NotCertifiedError, minimise
from discretization.following.events import Events
from discretization.loading import load_path
from energy import ElasticLayer, FlatPunch, Parabola, PowerLaw, Scene, SurfaceEnergies, Wedge, cards
from studies.shared.random_cases import random_case


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("body", [Parabola(0.02), Parabola(0.02).tilted(0.05), PowerLaw(40.0, 3.0)])
def test_a_path_is_made_of_the_equilibria_of_minimise(body, slopes):
    scene = adhesive(body, slopes=slopes)
    delta0 = scene.critical_separation
    depths = np.r_[np.linspace(-1, 2, 7), np.linspace(2, -1.99, 9)] * delta0
    path = load_path(scene, depths=depths)
    held = ~np.isnan(path.contacts[:, 0])
    assert held.sum() >= 8
    for depth, force, energy, ends in zip(
        depths[held], path.force[held], path.energy[held], path.contacts[held], strict=True
    ):
        state = minimise(scene, depth)
        width = state.half_width
        assert np.abs(ends - state.contacts[0]).max() <= 1e-11 * max(width, 1e-3 * abs(depth))
        assert abs(force - state.force) <= 1e-12 * state.scales["force"]
        assert abs(energy - state.energy) <= 1e-12 * state.scales["energy"]


def test_events_do_not_depend_on_the_steps():
    scene = adhesive(Parabola(0.02))
    delta0 = scene.critical_separation
    coarse = load_path(scene, depths=[3 * delta0, -2 * delta0])
    depths = np.r_[np.linspace(-delta0, 3 * delta0, 83), np.linspace(3 * delta0, -2 * delta0, 97)]
    fine = load_path(scene, depths=depths)
    assert [e.kind for e in fine.events] == [e.kind for e in coarse.events]
    for a, b in zip(fine.events, coarse.events, strict=True):
        assert a.depth == pytest.approx(b.depth, rel=1e-12, abs=1e-12 * delta0)
        assert a.energy_released == pytest.approx(b.energy_released, rel=1e-13, abs=0)
    assert fine.pull_off.force == pytest.approx(coarse.pull_off.force, rel=1e-13, abs=0)
    assert fine.work() == pytest.approx(coarse.work(), rel=1e-12, abs=0)


@pytest.mark.parametrize("body", [Parabola(0.02), Parabola(0.02).tilted(0.05), PowerLaw(40.0, 3.0)])
def test_a_second_retraction_counts_as_the_first_does(body):
    """The largest pull is between the steps of the last of three runs; the others lose nothing."""
    scene = adhesive(body)
    turns = np.array([3.0, -0.1, 2.0, -2.5]) * scene.critical_separation
    path, once = (load_path(scene, depths=depths) for depths in (turns, turns[[0, 3]]))
    for name in ("force", "depth"):
        most, known = (getattr(one.pull_off, name) for one in (path, once))
        assert most == pytest.approx(known, rel=1e-12, abs=0)
    assert path.pull_off.force < path.force.min()
    assert path.work() == pytest.approx(once.work(), rel=1e-11, abs=0)


def test_a_sharp_wedge_is_pinned_at_its_tip_and_loses_nothing():
    scene = adhesive(Wedge(0.4), w=0.001)
    slope, length, delta0 = math.tan(0.4), scene.elastocapillary_length, scene.critical_separation
    free = length * slope - delta0
    assert free > 0
    path = load_path(scene, depths=[2 * free, -delta0])
    kinds = [event.kind for event in path.events]
    assert kinds == ["touch", "tip depinning", "tip pinning", "tip depinning", "detachment"]
    assert path.events[1].depth == pytest.approx(free, rel=1e-12, abs=0)
    assert path.events[-1].depth == pytest.approx(0, abs=1e-13 * delta0)
    scale = scene.stiffness * delta0**2 * length
    assert abs(path.dissipated) <= 1e-12 * scale and abs(path.work()) <= 1e-12 * scale


def test_a_flat_punch_lets_go_of_its_edges_and_detaches_at_once():
    scene = adhesive(FlatPunch(0.03))
    path = load_path(scene, depths=[0.0, -2 * scene.critical_separation])
    assert [e.kind for e in path.events] == ["jump-in", "edge depinning", "detachment"]
    assert path.events[1].energy_released == 0
    assert path.events[2].depth == pytest.approx(-scene.critical_separation, rel=1e-12, abs=0)


def test_a_tilted_punch_leaves_one_edge_and_then_the_other():
    """One line passes from the upper edge to the lower one, x at d = f + l f' - δ₀.

    Under a load nothing holds it once it has left its edge.
    """
    scene = adhesive(FlatPunch(0.03).tilted(0.002))
    delta0, length = scene.critical_separation, scene.elastocapillary_length
    ends = [0.002 * (x + length) - delta0 for x in (0.03, -0.03)]
    path = load_path(scene, depths=[0.5 * delta0, -2 * delta0])
    left = [event.depth for event in path.events if event.kind == "edge depinning"]
    assert left == pytest.approx(ends, rel=0, abs=1e-12 * delta0)
    path = load_path(scene, forces=[path.force[0], 5 * path.pull_off.force])
    assert [event.kind for event in path.events] == ["jump-in", "edge depinning", "pull-off"]
    depths = [event.depth for event in path.events[1:]]
    assert depths == pytest.approx(2 * ends[:1], rel=0, abs=1e-12 * delta0)


def test_after_pull_off_the_indenter_can_touch_again():
    scene = adhesive(Parabola(0.02))
    force = scene.stiffness * scene.critical_separation * 0.1
    path = load_path(scene, forces=[force, -100 * force, 0.0, force])
    assert [e.kind for e in path.events] == ["jump-in", "pull-off", "jump-in"]
    assert [e.step for e in path.events] == [0, 1, 2]
    assert path.depth[1] == -math.inf
    assert path.force == pytest.approx([force, 0.0, 0.0, force], rel=1e-10, abs=1e-12 * force)
    machine = load_path(scene, drives=[0.01, -1.0, 0.01], machine_stiffness=scene.stiffness * 0.001)
    assert machine.depth[1] == -1.0 and machine.force[1] == 0.0
    found, before = machine.depth[2], machine.depth[0]  # roots found from different states
    assert found == pytest.approx(before, rel=1e-14, abs=0)


def test_a_path_does_not_continue_from_a_wrong_state(monkeypatch):
    """A line out of place is noticed, with one work of adhesion and with two."""
    plain = adhesive(Parabola(0.02), w=0.001)
    hysteretic = adhesive(Parabola(0.02), w=0.001, opening=0.003)
    part = Events.part
    for scene, factor in ((plain, 0.999), (plain, 1.001), (hysteretic, 0.999), (hysteretic, 3.0)):

        def wrong(self, lines, start, end, factor=factor):
            moved = part(self, lines, start, end)
            pieces = [piece._replace(lines=factor * piece.lines) for piece in moved.pieces]
            lines = tuple(factor * x for x in moved.lines)
            return moved._replace(lines=lines, pieces=tuple(pieces))

        touched = load_path(scene, depths=[0.001])
        monkeypatch.setattr(Events, "part", wrong)
        with pytest.raises(NotCertifiedError, match="neighbours"):
            load_path(scene, depths=[0.0012], after=touched)  # no event on the way
        monkeypatch.setattr(Events, "part", part)
        assert load_path(scene, depths=[0.001, -0.001]).half_width[1] > 0  # pinned if hysteretic


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
