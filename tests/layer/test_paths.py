"""Load paths of one contact of a layer: loops, hysteresis, what is held, and what they lose.

Under dead loads and machines, and continued from files: tests/paths/test_controls.py.
"""

import math

import numpy as np
import pytest
from support.bonded_layers import GEOMETRIES, FlatTo, scene_of

from discretization import NotCertifiedError, load_path, minimise
from discretization.paths.layer_branch import LayerBranch
from energy import FlatPunch, Parabola, Wedge


def loop(steps=200, deep=0.05, far=-0.25):
    """Depths in a layer of thickness 1: down to `deep` and out to `far`, where nothing touches."""
    approach = np.linspace(-0.02, deep, steps // 2)
    retraction = np.linspace(deep, far, steps // 2)
    return np.concatenate([approach, retraction])


def largest_energy(path):
    """The largest energy of a path and what its events release: what rounding is relative to."""
    released = sum(abs(event.energy_released) for event in path.events)
    return np.abs(path.energy).max() + released


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_wedge_all_but_flat_for_its_adhesion(geometry):
    """Its slope is a fifth of √(2w/γ₁) wherever a line may be."""
    critical_slope = math.sqrt(2 * 0.01 / 0.7)
    scene = scene_of(Wedge(math.atan(0.2 * critical_slope)), -0.5, geometry=geometry)
    branch = LayerBranch(scene, 1e-6)
    assert branch.first.lines[1] < 10.0
    assert max(octave for _, octave in branch.table.panels) <= 10
    path = load_path(scene, depths=[0.0, 0.05])
    state = minimise(scene, 0.05)
    assert path.half_width[-1] == pytest.approx(state.half_width, rel=1e-7)
    assert abs(path.force[-1] - state.force) <= 1e-7 * state.scales["force"]


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("nu", [0.2, 0.5])
def test_a_loop_loses_what_its_events_release(geometry, nu):
    scene = scene_of(Parabola(40.0), nu, geometry=geometry)
    path = load_path(scene, depths=loop(), rtol=1e-6)
    assert [event.kind for event in path.events] == ["jump-in", "detachment"]
    assert all(event.energy_released > 0 for event in path.events)
    assert abs(path.work() - path.dissipated) <= 1e-9 * largest_energy(path)
    assert path.pull_off.force <= path.force.min() < 0
    last = path.events[1].before
    for depth in (0.03, 0.0, 0.5 * last.depth):  # on the way out
        step = int(np.argmin(np.abs(path.depth[100:] - depth))) + 100
        depth = float(path.depth[step])
        if depth < last.depth:
            continue
        state = minimise(scene, depth, rtol=1e-5)
        assert path.half_width[step] == pytest.approx(state.half_width, rel=1e-5)
        assert abs(path.force[step] - state.force) <= 2e-6 * state.scales["force"]
        assert abs(path.energy[step] - state.energy) <= 2e-6 * state.scales["energy"]
    assert minimise(scene, last.depth * 0.99, rtol=1e-4).half_width > last.half_width
    assert not minimise(scene, last.depth * 1.001).contacts.size


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_two_works_of_adhesion_hold_the_line(geometry):
    scene = scene_of(Parabola(40.0), 0.45, w=0.005, opening=0.015, geometry=geometry)
    path = load_path(scene, depths=loop(60), rtol=1e-6)
    a = path.half_width
    top = 30
    held = a[top + 1 : top + 3]
    assert (np.abs(held - a[top]) <= 1e-12 * a[top]).all()
    assert a[-10] < a[top]
    assert (np.diff(path.force[top : top + 3]) < 0).all()
    assert path.friction > 0.1 * path.dissipated
    single = load_path(scene.opened, depths=loop(60), rtol=1e-6)
    assert path.events[-1].depth == pytest.approx(single.events[-1].depth, rel=1e-7)
    alike = np.abs(a - single.half_width) <= 1e-7 * single.half_width
    assert (alike & (a > 0))[top:].sum() > 3  # where the line opens


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("nu", [0.3, 0.5])
@pytest.mark.filterwarnings("ignore::discretization.AccuracyWarning")  # nearly any width rests
def test_a_punch_is_pulled_off_from_its_edge(geometry, nu):
    scene = scene_of(FlatPunch(1.5), nu, geometry=geometry)
    path = load_path(scene, depths=[0.0, 0.1, 0.0, -0.02, -1.0], rtol=1e-6)
    kinds = [event.kind for event in path.events]
    assert kinds[0] == "jump-in"
    assert "edge depinning" in kinds
    assert kinds[-1] == "detachment"
    assert (path.half_width[:4] == 1.5).all()
    assert math.isnan(path.contacts[-1, 0])
    pressed = path.force[1] / path.depth[1]
    pulled = path.force[3] / path.depth[3]
    assert pressed == pytest.approx(pulled, rel=1e-9)
    off = path.events[kinds.index("edge depinning")]
    assert minimise(scene, off.depth * 0.999, rtol=1e-4).half_width == 1.5
    assert minimise(scene, off.depth * 1.001, rtol=1e-4).half_width < 1.5
    assert abs(path.work() - path.dissipated) <= 1e-9 * largest_energy(path)


@pytest.mark.parametrize("w", [0.01, 0.0])
def test_a_steep_wedge_is_held_at_its_tip(w):
    scene = scene_of(Wedge(math.atan(0.3)), 0.45, w=w)
    path = load_path(scene, depths=[-0.1, 0.002, 0.2, 0.002, -0.1], rtol=1e-6)
    kinds = [event.kind for event in path.events]
    assert kinds[:3] == ["touch", "tip depinning", "tip pinning"]
    assert kinds[-1] == "detachment"
    at_the_tip, wide, again_at_the_tip = path.half_width[1:4]
    assert at_the_tip == again_at_the_tip == 0
    assert wide > 0
    assert path.force[1] == pytest.approx(path.force[3], rel=1e-12)
    assert path.events[-1].depth == 0
    assert abs(path.dissipated) <= 1e-9 * largest_energy(path)
    dead_load = load_path(scene, rtol=1e-6, forces=[0.0, 0.1, -1])
    assert dead_load.events[-1].kind == "pull-off"
    machine = load_path(scene, rtol=1e-6, drives=[0.0, 0.3, -1], machine_stiffness=1)
    assert machine.events[-1].kind == "pull-off"
    out = load_path(scene, depths=[-0.1, -0.05], rtol=1e-6)
    assert np.isnan(out.contacts).all()
    assert not out.events
    assert (out.force == 0).all()


@pytest.mark.parametrize("opening", [None, 0.015])
@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_a_line_that_does_not_rest_is_not_certified(geometry, opening):
    scene = scene_of(Parabola(40.0), 0.45, w=0.005, opening=opening, geometry=geometry)
    branch = LayerBranch(scene, 1e-6)
    first = branch.first  # where it touches
    pressed = branch.segment(first, first.depth + 0.02).end
    for point in (first, pressed):
        branch.certify(point)
        just = branch.point(point.depth, point.memory * (1 - 1e-9))
        branch.certify(just)
        with pytest.raises(NotCertifiedError, match="neighbours"):  # it would advance
            branch.certify(branch.point(point.depth, point.memory * (1 - 1e-4)))
    wide = branch.point(pressed.depth, pressed.memory * 1.02)
    if opening is None:
        with pytest.raises(NotCertifiedError, match="neighbours"):  # it would recede
            branch.certify(wide)
    else:
        branch.certify(wide)  # it is held
        with pytest.raises(NotCertifiedError, match="neighbours"):
            branch.certify(branch.point(pressed.depth, pressed.memory * 2))


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("body", [FlatPunch(1.0), FlatTo(1.0, 0.1)])
def test_flat_face_touches_and_parts_at_once(body, geometry):
    """Without adhesion a flat face touches and parts as a whole."""
    scene = scene_of(body, 0.3, w=0.0, geometry=geometry)
    path = load_path(scene, depths=[0.02, 0.05, -0.1], rtol=1e-6)
    for depth, a, force in zip(path.depth[:2], path.half_width, path.force, strict=False):
        state = minimise(scene, float(depth), rtol=1e-6)
        assert a == pytest.approx(state.half_width, rel=1e-6)
        assert force == pytest.approx(state.force, rel=1e-6)
    assert (path.events[0].kind, path.events[-1].kind) == ("touch", "detachment")
    assert abs(path.events[-1].depth) <= 1e-9
    assert path.dissipated <= 1e-9 * path.energy[1]
    pulled = load_path(scene, forces=[0.01, -0.01], rtol=1e-6)
    assert list(pulled.half_width) == [1.0, 0.0]


def pull_off(nu, gamma, w, R, deep):
    """The most tensile force under a sphere, over πwR.

    nu is Poisson's ratio, gamma the tension over the modulus and the thickness, w the work of
    adhesion over the same, R the radius over the thickness, deep the depth from which the sphere
    is pulled.
    """
    scene = scene_of(Parabola(R), nu, gamma, w, "axisymmetric")
    path = load_path(scene, depths=[deep, -30 * deep], rtol=1e-5)
    return -path.pull_off.force / (math.pi * w * R)


def half_space(a):
    """Contacts far smaller than the thickness, and far larger than what tension rules."""
    w = 8 * 2 / 0.7 * a**3 / (9 * math.pi)
    return pull_off(nu=0.3, gamma=1e-2 * a**2, w=w, R=1.0, deep=a * a)


def compressible(a):
    """Wide contacts of a layer that is compressed."""
    deep = a * a / 2e4 / 2
    return pull_off(nu=0.0, gamma=0.5, w=deep**2, R=1e4, deep=deep)


def incompressible(a):
    """Wide contacts of a layer that has to flow sideways."""
    w = 1.5 * (a**3 / 12e4) ** 2
    return pull_off(nu=0.5, gamma=0.1, w=w, R=1e4, deep=a * a / 2e4)


def tension(a):
    """Contacts so small that tension rules."""
    return pull_off(nu=0.3, gamma=1.0, w=a * a, R=1.0, deep=a * a)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("limit", "value", "widths", "bounds"),
    [
        (half_space, 1.5, (0.3, 0.03), (0.06, 0.006)),
        (compressible, 2.0, (30.0, 300.0), (0.06, 0.006)),
        (incompressible, 3.0, (20.0, 98.0, 459.0), (0.3, 0.06, 0.012)),
        (tension, 1.0, (1e-2, 1e-3, 1e-4), (5e-3, 6e-4, 7e-5)),
    ],
)
def test_how_hard_a_sphere_sticks_in_the_limits(limit, value, widths, bounds):
    off = np.array([abs(limit(a) - value) for a in widths])
    assert (off <= bounds).all()
    assert (np.diff(off) < 0).all()
