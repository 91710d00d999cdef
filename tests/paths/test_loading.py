"""Load paths: events, their energy balance, what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive, rescaled

from discretization import NotCertifiedError, minimise
from discretization.following.events import Events
from discretization.loading import load_path
from energy import FlatPunch, Parabola, Plane, PowerLaw, SurfaceEnergies, Wedge


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


def test_a_branch_walked_there_and_back_costs_nothing():
    for body in (Parabola(0.02), Wedge(0.05), Parabola(0.02).tilted(0.03)):
        scene = adhesive(body)
        delta0 = scene.critical_separation
        there = np.linspace(-0.5 * delta0, 3 * delta0, 40)
        path = load_path(scene, depths=np.r_[0.0, there, there[::-1]])
        assert [event.kind for event in path.events] == ["jump-in"]
        walked = load_path(scene, depths=np.r_[there, there[::-1]], after=path)
        assert walked.events == path.events
        scale = scene.stiffness * delta0**2 * scene.elastocapillary_length
        assert abs(walked.work() - path.work()) <= 1e-13 * scale
        assert np.abs(walked.energy[-1] - path.energy[-1]) <= 1e-13 * scale


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


def test_a_path_does_not_know_the_units():
    scene = adhesive(Parabola(0.02))
    delta0 = scene.critical_separation
    path = load_path(scene, depths=[delta0, -2 * delta0])
    for length, stress in ((1e3, 1e-6), (1e-9, 1e9)):
        depths = np.array([delta0, -2 * delta0]) * length
        again = load_path(rescaled(scene, length, stress), depths=depths)
        energy, force = path.dissipated * stress * length**2, path.pull_off.force * stress * length
        assert again.dissipated == pytest.approx(energy, rel=1e-13, abs=0)
        assert again.pull_off.force == pytest.approx(force, rel=1e-13, abs=0)


@pytest.mark.parametrize(
    ("programme", "message"),
    [
        ({}, "exactly one of depths, forces, drives"),
        ({"depths": [0.1], "forces": [1.0]}, "exactly one of"),
        ({"depths": []}, "depths = .* at least one finite number"),
        ({"depths": [0.1, math.nan]}, "at least one finite"),
        ({"depths": 0.1}, "must be a list"),
        ({"forces": [-1e9]}, r"forces\[0\] = -1000000000.0 is below the pull-off force"),
        ({"depths": [0.1], "rtol": math.nan}, "rtol = nan"),
        ({"depths": [0.1], "rtol": 2.0}, "rtol = 2.0 is outside"),
        ({"depths": [0.1], "every": 0}, "every = 0 is no number of steps"),
        ({"drives": [0.1]}, "machine_stiffness = None with drives"),
        ({"drives": [0.1], "machine_stiffness": 0.0}, "machine_stiffness = 0.0 must be positive"),
        ({"depths": [0.1], "machine_stiffness": 3.0}, "machine_stiffness = 3.0 with depths"),
    ],
)
def test_bad_programmes_are_refused(programme, message):
    with pytest.raises(ValueError, match=message):
        load_path(adhesive(Parabola(0.02)), **programme)


def test_indenters_a_path_cannot_follow_are_refused():
    with pytest.raises(ValueError, match="a profile with a lowest point"):
        load_path(adhesive(Plane()), depths=[0.001])
    with pytest.raises(ValueError, match="is not a Scene"):
        load_path(Parabola(1.0), depths=[0.001])


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


def test_an_opening_that_does_not_fit_is_refused():
    scene = adhesive(Parabola(0.02), w=0.001)
    for gamma1, w in ((0.07, 0.0009), (0.08, 0.002)):
        with pytest.raises(ValueError, match=r"opening = .* must have the gamma1"):
            replace(scene, opening=SurfaceEnergies.from_work(gamma1, w))
