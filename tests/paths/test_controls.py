"""A load or a machine is read off the depth path; loops of every kind, on nodes and the mesh."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.example_scenes import (
    DELTA0,
    L,
    plain,
    rippled,
    turned,
)
from support.scene_kinds import ON_NODES, PATTERNED, RIPPLED_SPHERE, SCENES, STEEP_CRESTS
from truth.paths.random_paths import envelope

from discretization import History, NotCertifiedError, load_path
from discretization.fitted.contact_lines import ContactLines
from discretization.paths.control import Control
from energy import Circle, FlatPunch, Parabola, Profile, Sampled

pytestmark = pytest.mark.filterwarnings("ignore:the pull-off force")  # of few links, for some
NODES = {"method": "lattice", "spacing": 0.05}
METHODS = pytest.mark.parametrize("method", [{}, NODES], ids=["fitted", "lattice"])


def waves(reach=15):
    x = np.linspace(-reach, reach, 20 * reach + 1)
    z = 0.05 * np.cos(2 * np.pi * x / 5 + 0.4) + 0.004 * x**2
    return plain(Sampled(x, z, kind="smooth"))


IN_AND_OUT = np.r_[np.linspace(0, 0.3, 8), np.linspace(0.3, -0.5, 16)]


@METHODS
@pytest.mark.parametrize("stiffness", [None, 0.01, 1e4])
def test_a_second_contact_carries_its_share(method, stiffness):
    """Eq. (40) of parabolas of R = 10 that do not feel each other, one higher by 0.1; k = l = 1."""
    height, slope, corners = envelope(10.0, [-30.0, 30.0], [0.0, 0.1])
    scene = plain(Profile(height, slope, (-60, 60), corners), w=0.0)
    if stiffness:
        drives = np.linspace(0, 0.5 + 4 / stiffness, 9)
        path = load_path(scene, drives=drives, machine_stiffness=stiffness, **method)
        load = stiffness * (drives - path.depth)
    else:
        load = np.linspace(0, 4, 9)
        path = load_path(scene, forces=load, **method)
        known = [0, 0.1367, 0.2052, 0.2633, 0.3155, 0.3636, 0.4087, 0.4514, 0.4921]
        assert path.depth == pytest.approx(known, rel=0, abs=1.5e-4)
    deep = np.maximum([path.depth, path.depth - 0.1], 0)
    exact = (((20 * deep + 1) ** 1.5 - 1) * 2 / 30).sum(axis=0)
    assert path.force == pytest.approx(exact, rel=0, abs=1e-3 if method else 1e-10)
    assert path.force == pytest.approx(load, rel=0, abs=1e-11 * max(1.0, (stiffness or 0) / 10))
    assert {event.kind for event in path.events} == {"touch", "nucleation"}


MACHINES = [(waves(), NODES), (plain(Parabola(10.0)), {}), (plain(Parabola(10.0)), NODES)]
MACHINES += [pytest.param(waves(12), {}, marks=pytest.mark.slow)]
MACHINES = pytest.mark.parametrize(("scene", "method"), MACHINES)


@MACHINES
def test_a_stiff_machine_imposes_the_depth(scene, method):
    """P changes the drive by P/K, and what jumps with P by no more than that."""
    depths = load_path(scene, depths=IN_AND_OUT, **method)
    for stiffness in (1e8, 1e11)[:: 1 if method else -2]:  # nodes are quick
        path = load_path(scene, drives=IN_AND_OUT, machine_stiffness=stiffness, **method)
        near = 20 / stiffness + 1e-9
        for here, there in zip(path.events, depths.events, strict=True):
            assert abs(here.depth - there.depth) <= near
            assert abs(here.after.depth - there.after.depth) <= near
            assert abs(here.energy_released - there.energy_released) <= near
            assert here.kind == there.kind.replace("detachment", "pull-off")
        assert path.dissipated == pytest.approx(depths.dissipated, rel=0, abs=10 * near)
        assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)
        assert path.half_width == pytest.approx(depths.half_width, rel=0, abs=1e4 * near)
    assert load_path(plain(FlatPunch(1), w=0), drives=[1, -1], machine_stiffness=50).events[1].step


@MACHINES
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


def test_a_control_with_a_constant_leads_to_the_same_states(monkeypatch):
    """Drives that are measured from another place: the constant is no rounding of C."""
    scene = plain(Parabola(2.0))
    drives = np.array([0.0, 0.5, 1.0, 0.5, -0.5, -1.0]) * scene.critical_separation
    machine = {"machine_stiffness": scene.stiffness * scene.elastocapillary_length}
    expected = load_path(scene, drives=drives, **machine)
    constant = 5 * scene.critical_separation
    value = Control.value
    monkeypatch.setattr(
        Control, "value", lambda control, d, force: value(control, d, force) + constant
    )
    path = load_path(scene, drives=drives + constant, **machine)
    near = 1e-11 * scene.critical_separation
    assert path.depth == pytest.approx(expected.depth, rel=0, abs=near)
    assert [event.kind for event in path.events] == [event.kind for event in expected.events]


@pytest.mark.slow
def test_sphere_wetted_almost_to_its_equator():
    """It is pressed by nothing, and pulled in to a/R = 0.9946; no depth beyond is asked for."""
    scene = replace(plain(Circle(0.05), w=0.9, slopes="finite"), geometry="axisymmetric")
    path = load_path(scene, forces=np.linspace(0, -0.4, 41))
    assert [event.kind for event in path.events] == ["jump-in", "pull-off"]
    depths = load_path(scene, depths=[0.0, path.depth[1]])
    assert depths.force[1] == pytest.approx(-0.01, rel=1e-12, abs=0)
    assert path.half_width[0] / 0.05 > 0.99
    assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)


@pytest.mark.slow
def test_wavy_turned_profile_without_adhesion():
    """C next to touching is all rounding: drawn from lines that are solved for, it has peaks."""
    bumps = rippled(10.0, 2 * math.pi / 3, 0.05)
    scene = turned(bumps, k=1.3, gamma1=1.1, w=0.0)
    path = load_path(scene, drives=[0.0, 0.01, -0.005], machine_stiffness=2.0)
    assert [event.kind for event in path.events] == ["touch", "pull-off"]
    assert path.force[1] == pytest.approx(2.0 * (0.01 - path.depth[1]), rel=1e-12, abs=0)


LOOP = np.r_[np.linspace(-0.1, 1.8, 8), np.linspace(1.5, -3.5, 18)] * DELTA0
MORE = {  # lines after an event less those before it; a jump keeps them or joins contacts
    "touch": (2,),
    "jump-in": (2,),
    "nucleation": (2, 4),  # on both sides at once
    "splitting": (2, 4),
    "jump": (0, -2, -4),
    **dict.fromkeys(("closing", "coalescence"), (-2, -4)),
    **dict.fromkeys(("edge depinning", "edge pinning"), (0,)),
}
LOADED = ("parabola", "opening", "crests", "sphere", "dimple", "layer")
LOADED = [(name, control) for name in LOADED for control in ("load", "machine")]
LOADED += [(name, "depth") for name in SCENES if name not in PATTERNED]
LONG = {("rings of a pattern", "depth")}
LONG |= {("crests", "machine"), ("layer", "load"), ("layer", "machine")}
LOADED = [pytest.param(*one, marks=[pytest.mark.slow] * (one in LONG)) for one in LOADED]
BOTH = [*((name, {}) for name in SCENES if name not in PATTERNED), *ON_NODES.items()]


def programme(scene, control):
    """In and out until contact is lost, under each control."""
    if control == "depth":
        return {"depths": LOOP}
    K = 0.5 * scene.stiffness * L * (math.pi * L if scene.axisymmetric else 1.0)
    if control == "machine":
        return {"drives": np.r_[3 * LOOP, -60 * DELTA0], "machine_stiffness": K}
    return {"forces": K * DELTA0 * np.r_[np.linspace(0, 3, 7), np.linspace(3, -60, 15)]}


@pytest.mark.parametrize("scene", [RIPPLED_SPHERE, STEEP_CRESTS], ids=["rings", "steep"])
def test_a_second_contact_is_refused(scene):
    """About an axis and with finite slopes a path has one contact."""
    with pytest.raises(NotCertifiedError, match="another contact begins"):
        load_path(scene, depths=LOOP)


def test_a_penetration_that_is_not_a_number_is_refused(monkeypatch):
    monkeypatch.setattr(ContactLines, "penetration", lambda *_: math.nan)
    with pytest.raises(NotCertifiedError, match="another contact begins"):
        load_path(RIPPLED_SPHERE, depths=LOOP[:2])


def test_a_force_inside_that_is_not_a_number_is_refused(monkeypatch):
    monkeypatch.setattr(ContactLines, "opening", lambda *_: [math.nan])
    with pytest.raises(NotCertifiedError, match="a gap opens inside"):
        load_path(RIPPLED_SPHERE, depths=LOOP[:2])


@pytest.mark.parametrize("name", PATTERNED)
def test_several_contacts_over_a_pattern_are_followed_on_nodes(name):
    with pytest.raises(ValueError, match="use method='lattice'"):
        load_path(SCENES[name], depths=LOOP, method="fitted")
    assert load_path(SCENES[name], depths=LOOP[:2]).spacing is not None


def lines(state):
    """How many contact lines a state has."""
    return sum(map(np.isfinite, state.lines))


@pytest.mark.parametrize(("name", "control"), LOADED)
def test_a_loop_loses_what_is_put_in_and_is_the_same_on_nodes(name, control):
    """Next to an event either may be on its other side; lines of nodes are told by their links."""
    scene = SCENES[name]
    given = programme(SCENES[name], control)
    mesh = load_path(scene, **given)
    assert_balanced(mesh, name, control)
    if name not in ON_NODES:
        return
    nodes = load_path(scene, **given, **ON_NODES[name])
    assert_balanced(nodes, name, control)
    both = ~np.isnan(nodes.contacts[:, 0]) & ~np.isnan(mesh.contacts[:, 0])
    assert both.sum() >= 8
    for one, bound in (("force", 1e-3), ("depth", 1e-3), ("energy", 2e-3), ("half_width", 1e-2)):
        own = getattr(nodes, one)[both]
        exact = getattr(mesh, one)[both]
        assert np.quantile(np.abs(own - exact), 0.75) <= bound * np.abs(exact).max(), one
    if name in ("parabola", "tilted", "wedge", "sphere", "cone", "arc"):  # lines between nodes
        off = np.abs(nodes.half_width - mesh.half_width)[both]
        assert np.quantile(off, 0.75) <= 0.02 * nodes.spacing
    kept = ("touch", "jump-in", "nucleation", "detachment", "pull-off")
    ours, theirs = ([e for e in path.events if e.kind in kept] for path in (nodes, mesh))
    assert [event.kind for event in ours] == [event.kind for event in theirs]
    for here, there in zip(ours, theirs, strict=True):
        assert here.before.depth == pytest.approx(there.before.depth, rel=0, abs=0.1 * DELTA0)
    size = 1e-11 * np.abs(mesh.energy).max()
    assert nodes.dissipated == pytest.approx(mesh.dissipated, rel=0.1, abs=size)


def assert_balanced(path, name, control):
    """A loop loses what is put in, and no contact between events."""
    assert np.isnan(path.contacts[-1, 0]) and path.force[-1] == 0
    size = np.abs(path.energy).max()
    number = 0
    assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=1e-11 * size)
    assert min(event.energy_released for event in path.events) >= -1e-11 * size
    held = "opening" in name or "both" in name or not path.scene.gamma1
    assert (path.friction > 0) == held
    if control != "depth":
        held = ~np.isnan(path.contacts[:, 0])
        load = path.values
        if control == "machine":
            load = path.machine_stiffness * (path.values - path.depth)
        assert np.abs(path.force - load)[held].max() <= 1e-9 * np.abs(load[held]).max()
    for step in range(len(path)):
        for event in (event for event in path.events if event.step == step):
            before = lines(event.before)
            after = lines(event.after)
            assert before == number, event.kind
            gone = event.kind in ("detachment", "pull-off")
            assert after == 0 if gone else not after or after - before in MORE[event.kind]
            number = after
        assert lines(path.at(step)) == number, step


ONE_OF_A_KIND = ("parabola", "punch", "ripples, both", "sphere, opening", "cylinder")
ONE_OF_A_KIND += ("rings of a pattern", "dimple", "layer, sphere")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "nodes"), [both for both in BOTH if both[0] in ONE_OF_A_KIND])
def test_a_loop_continues_from_its_file_as_if_it_had_not_stopped(name, nodes, tmp_path):
    depths = LOOP[1::2]
    cut = 5
    whole = load_path(SCENES[name], depths=depths, **nodes)
    load_path(SCENES[name], depths=depths[:cut], **nodes).to_csv(tmp_path / "path.csv")
    first = History.from_csv(tmp_path / "path.csv", SCENES[name])
    again = load_path(SCENES[name], depths=depths[cut:], after=first, **nodes)
    for one in ("force", "energy", "contacts"):
        ours = getattr(again, one)
        theirs = getattr(whole, one)
        size = (1e-14 if nodes else 1e-12) * np.nanmax(np.abs(theirs))
        assert ours == pytest.approx(theirs, abs=size, rel=0, nan_ok=True), one
    assert [e.kind for e in again.events] == [e.kind for e in whole.events]
    assert list(map(len, again.inner)) == list(map(len, whole.inner))


@pytest.mark.parametrize(("name", "nodes"), BOTH)
def test_there_and_back_without_an_event_costs_nothing(name, nodes):
    """On a smooth branch, or with all lines held."""
    scene = SCENES[name]
    there = np.linspace(0.3, 0.33, 4) * DELTA0
    once = load_path(scene, depths=[there[-1], there[0]], **nodes)
    twice = load_path(scene, depths=[*there, *there[::-1]], after=once, **nodes)
    assert twice.events == once.events
    size = scene.stiffness * DELTA0**2 * L * (L if scene.axisymmetric else 1.0)
    assert twice.work() == pytest.approx(once.work(), rel=0, abs=1e-9 * size)
    assert twice.force[-1] == pytest.approx(once.force[-1], rel=1e-9, abs=1e-12 * size / DELTA0)
