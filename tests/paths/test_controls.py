"""A load or a machine is read off the depth path: jumps, their limits, and what was wrong once."""

import numpy as np
import pytest

from discretization import load_path
from discretization.following.smooth import Smooth
from energy import Circle, ElasticLayer, Parabola, Profile, Sampled, Scene, SurfaceEnergies

LAYER, SURFACES = ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work
NODES = {"method": "lattice", "spacing": 0.05}
METHODS = pytest.mark.parametrize("method", [{}, NODES], ids=["fitted", "lattice"])
ADHESIVE = SURFACES(1.0, 0.02)


def two_parabolas(w=0.0):
    """R = 10 at ±30, the right one higher by 0.1."""
    far, c = 30.0, 1 / 60
    body = Profile(
        height=lambda x: np.minimum((x + far) ** 2 / 20, (x - far) ** 2 / 20 + 0.1),
        slope=lambda x: np.where(x < c, x + far, x - far) / 10,
        extent=(-60, 60),
        corners=(c,),
    )
    return Scene(LAYER, SURFACES(1.0, w), body)


def wavy():
    x = np.linspace(-15, 15, 301)
    z = 0.05 * np.cos(2 * np.pi * x / 5 + 0.4) + 0.004 * x**2
    return Scene(LAYER, ADHESIVE, Sampled(x, z, kind="smooth"))


LOOP = np.r_[np.linspace(0, 0.3, 8), np.linspace(0.3, -0.5, 16)]


def pressed(depth):
    """Eq. (40) of parabolas of R = 10 that do not feel each other; k = l = 1."""
    above = [d for d in (depth, depth - 0.1) if d > 0]
    return sum(((20 * d + 1) ** 1.5 - 1) * 2 / 30 for d in above)


@METHODS
@pytest.mark.parametrize("stiffness", [None, 0.01, 1.0, 1e4])
def test_a_second_contact_carries_its_share(method, stiffness):
    loads = np.linspace(0, 4, 9)
    scene, more = two_parabolas(), {} if stiffness is None else {"machine_stiffness": stiffness}
    drives = np.linspace(0, 0.5 + (4 / stiffness if stiffness else 0), 9)
    programme = {"forces": loads} if stiffness is None else {"drives": drives}
    path = load_path(scene, **programme, **more, **method)
    exact = [pressed(depth) for depth in path.depth.tolist()]
    assert path.force == pytest.approx(exact, rel=0, abs=1e-3 if method else 1e-10)
    load = loads if stiffness is None else stiffness * (drives - path.depth)
    assert path.force == pytest.approx(load, rel=0, abs=1e-11 * max(1.0, (stiffness or 0) / 10))
    assert {event.kind for event in path.events} == {"touch", "nucleation"}
    if stiffness is None:
        known = [0, 0.1367, 0.2052, 0.2633, 0.3155, 0.3636, 0.4087, 0.4514, 0.4921]
        assert path.depth == pytest.approx(known, rel=0, abs=1.5e-4)


@METHODS
@pytest.mark.parametrize("scene", [wavy(), Scene(LAYER, ADHESIVE, Parabola(10.0))])
def test_a_stiff_machine_imposes_the_depth(scene, method):
    """P changes the drive by P/K, and what jumps with P by no more than that."""
    depths = load_path(scene, depths=LOOP, **method)
    for stiffness in (1e8, 1e11)[:: 1 if method else -2]:  # nodes are quick
        path = load_path(scene, drives=LOOP, machine_stiffness=stiffness, **method)
        near = 20 / stiffness + 1e-9
        assert len(path.events) == len(depths.events)
        for here, there in zip(path.events, depths.events, strict=True):
            assert abs(here.depth - there.depth) <= near
            assert abs(here.after.depth - there.after.depth) <= near
            assert abs(here.energy_released - there.energy_released) <= near
            assert here.kind == there.kind.replace("detachment", "pull-off")
        assert path.dissipated == pytest.approx(depths.dissipated, rel=0, abs=10 * near)
        assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)
        assert path.half_width == pytest.approx(depths.half_width, rel=0, abs=1e4 * near)


@METHODS
@pytest.mark.parametrize("scene", [wavy(), Scene(LAYER, ADHESIVE, Parabola(10.0))])
def test_a_soft_machine_is_a_dead_load(scene, method):
    """As long as there is contact: beyond, a dead load pulls the indenter away for ever."""
    loads = np.r_[np.linspace(0, 1.5, 7), np.linspace(1.5, -4, 23)]
    dead = load_path(scene, forces=loads, **method)
    for stiffness in (1e-9, 1e-11)[:: 1 if method else -2]:
        path = load_path(scene, drives=loads / stiffness, machine_stiffness=stiffness, **method)
        held = np.isfinite(dead.contacts[:, 0])
        assert (np.isfinite(path.contacts[:, 0]) == held).all()
        assert path.depth[held] == pytest.approx(dead.depth[held], rel=0, abs=1e-9)
        for here, there in zip(path.events, dead.events, strict=True):
            assert here.kind == there.kind
            assert abs(here.depth - there.depth) <= 1e-9
            if here.kind != "pull-off":
                assert abs(here.energy_released - there.energy_released) <= 1e-9


def test_a_jump_that_keeps_the_number_of_contacts_loses_what_it_does():
    path = load_path(wavy(), drives=LOOP, machine_stiffness=1e8)
    assert path.dissipated == pytest.approx(0.300688, rel=0, abs=1e-6)
    assert max(event.energy_released for event in path.events) <= 0.125


@pytest.mark.parametrize("spacing", np.linspace(0.03, 0.06, 13))
@pytest.mark.parametrize("dead", [False, True])
def test_nodes_with_two_works_balance_their_load(spacing, dead):
    scene = Scene(LAYER, ADHESIVE, Parabola(10.0), opening=SURFACES(1.0, 0.03))
    values = np.r_[np.linspace(0, 0.6, 13), np.linspace(0.6, -2.0 if dead else -9.0, 14)]
    given = {"forces": values} if dead else {"drives": values, "machine_stiffness": 0.3}
    path = load_path(scene, **given, method="lattice", spacing=spacing)
    held = np.isfinite(path.contacts[:, 0])
    load = values if dead else 0.3 * (values - path.depth)
    assert path.force[held] == pytest.approx(load[held], rel=0, abs=1e-12)
    assert [event.kind for event in path.events] == ["jump-in", "pull-off"]
    assert min(event.energy_released for event in path.events) > 0
    fine = load_path(scene, **given)
    both = held & np.isfinite(fine.contacts[:, 0])
    assert both.sum() > 13
    assert path.depth[both] == pytest.approx(fine.depth[both], rel=0, abs=2e-3)


@pytest.mark.parametrize("spacing", [0.05, 0.041, 0.025])
def test_nodes_under_a_stiff_machine_are_pulled_off_where_the_mesh_is(spacing):
    path = load_path(wavy(), drives=LOOP, machine_stiffness=1e8, method="lattice", spacing=spacing)
    assert path.events[-1].kind == "pull-off"
    assert path.events[-1].control == pytest.approx(-0.248074, rel=0, abs=2e-5)


def test_steps_between_two_events_are_read_off_one_way(monkeypatch):
    """Ten times as many steps: no more ways are followed."""
    over, ways = Smooth.over, []

    def counted(self, *arguments):
        ways[-1] += 1
        return over(self, *arguments)

    monkeypatch.setattr(Smooth, "over", counted)
    for n in (40, 400):
        ways.append(0)
        drives = np.r_[np.linspace(-0.05, 0.1, n), np.linspace(0.1, 0.0, n)]
        path = load_path(wavy(), drives=drives, machine_stiffness=5.0)
        assert len(path) == 2 * n
    assert ways[1] <= 1.2 * ways[0]


@pytest.mark.slow
def test_a_sphere_that_is_wetted_almost_to_its_equator_is_pulled_off():
    """It is pressed by nothing, and pulled in to a/R = 0.9946; no depth beyond is asked for."""
    scene = Scene(LAYER, SURFACES(1.0, 0.9), Circle(0.05), "finite", geometry="axisymmetric")
    path = load_path(scene, forces=np.linspace(0, -0.4, 41))
    assert [event.kind for event in path.events] == ["jump-in", "pull-off"]
    depths = load_path(scene, depths=[0.0, path.depth[1]])
    assert depths.force[1] == pytest.approx(-0.01, rel=1e-12, abs=0)
    assert path.half_width[0] / 0.05 > 0.99
    assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)


def test_a_wavy_profile_without_adhesion_turned_about_an_axis_is_pressed_from_touching():
    """C next to touching is all rounding: drawn from lines that are solved for, it has peaks."""
    layer, surfaces = ElasticLayer(1.3, 0.0, 1.0), SurfaceEnergies.from_work(1.1, 0.0)
    wavy = Profile(
        lambda x: 0.05 * x * x + 0.05 * (1 - np.cos(3 * x)),
        lambda x: 0.1 * x + 0.15 * np.sin(3 * x),
    )
    scene = Scene(layer, surfaces, wavy, geometry="axisymmetric")
    path = load_path(scene, drives=[0.0, 0.01, -0.005], machine_stiffness=2.0)
    assert [event.kind for event in path.events] == ["touch", "pull-off"]
    assert path.force[1] == pytest.approx(2.0 * (0.01 - path.depth[1]), rel=1e-12, abs=0)
