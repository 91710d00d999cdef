"""Load paths: events, their energy balance, what is refused."""

import math

import numpy as np
import pytest
from support.example_scenes import DELTA0, L, adhesive, rescaled, rippled, wavy
from support.scene_kinds import ON_NODES, PATTERNED, SCENES

from discretization import NotCertifiedError, minimise
from discretization.loading import load_path
from discretization.paths.one_contact import OneContactBranch
from discretization.profile import resolve
from energy import ElasticLayer, FlatPunch, Parabola, PowerLaw, Scene, SurfaceEnergies, Wedge, cards
from studies.shared.random_cases import random_case

CUBIC = PowerLaw(40.0, 3.0)
TILTED = Parabola(0.02).tilted(0.05)
SINGLE = {"parabola": SCENES["parabola"], "steep parabola": SCENES["steep parabola"]} | {
    f"{slopes} {type(body).__name__}": adhesive(body, slopes=slopes)
    for slopes in ("small", "finite")
    for body in (CUBIC, TILTED)
}
OTHERS = {name: scene for name, scene in SCENES.items() if name not in SINGLE}
OTHERS = {name: s for name, s in OTHERS.items() if name != "springs, opening" and not s.layer.exact}
DRY = {"no adhesion": adhesive(SCENES["ripples"].indenter, w=0.0)}
STEPS = [(name, [*np.linspace(-1, 2, 7), *np.linspace(2, -1.99, 9)]) for name in SINGLE]
STEPS += [
    (name, [-0.1, *way])
    for name in OTHERS
    if name not in PATTERNED
    for way in ([0.9, 1.4], [0.0, -0.5])
]
STEPS += [(name, [-0.1, 0.4, 0.9, 1.6, 1.3, -0.1]) for name in DRY]
STEPS = [(*step, {}) for step in STEPS]
STEPS += [  # on nodes, where lines are held
    (name, levels, ON_NODES[name])
    for name in ("opening", "ripples, pattern", "ripples, both")
    for levels in ([-0.1, 0.3, 1.7, 4.0], [0.0, -0.6, -4.0])
]
RING = pytest.param("dimple", marks=pytest.mark.slow)


@pytest.mark.filterwarnings("ignore:the pull-off force")  # of few links, for some of them
@pytest.mark.parametrize(("name", "levels", "nodes"), STEPS)
def test_a_path_is_made_of_the_states_of_minimise(name, levels, nodes):
    """Several contacts only grow or only shrink since they touched first."""
    scene = (SINGLE | OTHERS | DRY)[name]
    depths = resolve(scene, 0.0).touch + np.array(levels) * DELTA0
    path = load_path(scene, depths=depths, **nodes)
    held = 0
    for i, depth in enumerate(path.depth.tolist()):
        if math.isnan(path.contacts[i, 0]):  # before it touches, or lost
            assert not held or minimise(scene, depth, **nodes).label == "detached"
            continue
        state = minimise(scene, depth, **nodes)
        held = held + 1
        lines = state.contacts.ravel()
        width = max(state.half_width, 1e-3 * abs(state.depth))
        inner = nodes["spacing"] / 2 if nodes else 1e-11 * width  # on nodes told by their links
        assert path.contacts[i] == pytest.approx(lines[[0, -1]], rel=0, abs=1e-11 * width)
        assert path.at(i).lines == pytest.approx(lines, rel=0, abs=inner)
        assert abs(path.force[i] - state.force) <= 1e-12 * state.scales["force"]
        assert abs(path.energy[i] - state.energy) <= 1e-12 * state.scales["energy"]
    assert held >= len(levels) // 2
    if name in DRY:
        assert max(abs(path.dissipated), abs(path.work())) <= 1e-11 * path.energy.max()


@pytest.mark.parametrize("name", ["parabola", "tilted", "small PowerLaw", "crests", RING])
def test_events_work_and_largest_pull_do_not_depend_on_the_steps(name):
    """The pull is that of the last of several retractions, between two steps."""
    scene = (SINGLE | SCENES)[name]
    turns = resolve(scene, 0.0).touch + np.array([-0.1, 3.0, -0.1, 2.0, -3.5]) * DELTA0
    fine = load_path(scene, depths=np.interp(np.linspace(0, 4, 41), range(5), turns))
    coarse = load_path(scene, depths=turns)
    several = name in ("crests", "dimple")
    once = [] if several else [load_path(scene, depths=turns[[0, 1, 4]])]
    work = coarse.work()
    assert [e.kind for e in fine.events] == [e.kind for e in coarse.events]
    for a, b in zip(fine.events, coarse.events, strict=True):
        assert a.depth == pytest.approx(b.depth, rel=1e-12, abs=1e-12 * DELTA0)
        assert a.energy_released == pytest.approx(b.energy_released, rel=1e-13, abs=0)
    for other in (fine, *once):
        assert other.pull_off.force == pytest.approx(coarse.pull_off.force, rel=1e-13, abs=0)
        assert other.pull_off.depth == pytest.approx(coarse.pull_off.depth, rel=1e-12, abs=0)
        assert other.work() == pytest.approx(work, rel=1e-12, abs=0)
    assert coarse.pull_off.force < coarse.force.min()


@pytest.mark.parametrize("nodes", [{}, {"method": "lattice", "spacing": L / 60}])
def test_no_unit_enters(nodes):
    unit = 1e-6
    stress = 3e4
    depths = np.r_[-0.1, 0.6, 1.485, 1.8, np.linspace(1.2, -0.9, 6)] * DELTA0
    scene = wavy(crests=3)
    path = load_path(scene, depths=depths, **nodes)
    nodes = nodes and nodes | {"spacing": unit * L / 60}
    there = load_path(rescaled(scene, unit, stress), depths=depths * unit, **nodes)
    assert [e.kind for e in there.events] == [e.kind for e in path.events]
    size = 1e-10 * np.abs(path.force).max()
    assert np.allclose(there.force / (stress * unit), path.force, rtol=0, atol=size)
    at = [[e.depth / scale for e in p.events] for p, scale in ((there, unit), (path, 1.0))]
    assert np.allclose(*at, rtol=0, atol=1e-11 * DELTA0)
    assert there.dissipated / (stress * unit**2) == pytest.approx(path.dissipated, rel=1e-13, abs=0)


def test_a_sharp_wedge_is_pinned_at_its_tip_and_loses_nothing():
    scene = adhesive(Wedge(0.4), w=0.001)
    slope = math.tan(0.4)
    length = scene.elastocapillary_length
    delta0 = scene.critical_separation
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
    delta0 = scene.critical_separation
    length = scene.elastocapillary_length
    ends = [0.002 * (x + length) - delta0 for x in (0.03, -0.03)]
    path = load_path(scene, depths=[0.5 * delta0, -2 * delta0])
    left = [event.depth for event in path.events if event.kind == "edge depinning"]
    assert left == pytest.approx(ends, rel=0, abs=1e-12 * delta0)
    path = load_path(scene, forces=[path.force[0], 5 * path.pull_off.force])
    assert [event.kind for event in path.events] == ["jump-in", "edge depinning", "pull-off"]
    depths = [event.depth for event in path.events[1:]]
    assert depths == pytest.approx(2 * ends[:1], rel=0, abs=1e-12 * delta0)


def test_a_contact_is_lost_within_rounding_of_its_last_depth():
    scene = adhesive(Parabola(0.02))
    last = load_path(scene, depths=[0.0, -2 * DELTA0]).events[-1].before
    assert last.depth == pytest.approx(-DELTA0, rel=2e-14, abs=0) and last.right > 0
    assert load_path(scene, depths=[0.0, -(1 - 3e-14) * DELTA0]).half_width[-1] > 0
    assert load_path(scene, depths=[0.0, -(1 + 3e-14) * DELTA0]).half_width[-1] == 0


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
    found = machine.depth[2]
    before = machine.depth[0]  # roots found from different states
    assert found == pytest.approx(before, rel=1e-14, abs=0)


@pytest.mark.parametrize(
    ("opening", "factor"), [(None, 0.999), (None, 1.001), (0.003, 0.999), (0.003, 3.0)]
)
def test_a_path_does_not_continue_from_a_wrong_state(monkeypatch, opening, factor):
    """A line out of place is noticed, with one work of adhesion and with two."""
    scene = adhesive(Parabola(0.02), w=0.001, opening=opening)
    segment = OneContactBranch.segment

    def wrong(self, point, goal):
        found = segment(self, point, goal)
        found.end = found.end._replace(lines=tuple(factor * x for x in found.end.lines))
        return found

    touched = load_path(scene, depths=[0.001])
    with monkeypatch.context() as patch:
        patch.setattr(OneContactBranch, "segment", wrong)
        with pytest.raises(NotCertifiedError, match="neighbours"):
            load_path(scene, depths=[0.0012], after=touched)  # no event on the way
    assert load_path(scene, depths=[0.001, -0.001]).half_width[1] > 0  # pinned if hysteretic


BARS = 1e-10
OF_SHAPE = {  # names of the cards, and of the size in cards and in indenters
    "flat": ("flat_punch", "a", "half_width"),
    "wedge": ("wedge", "delta", "delta"),
    "parabola": ("parabola", "R", "R"),
}


@pytest.mark.parametrize("control", ["depth", "force", "drive"])
@pytest.mark.parametrize("shape", OF_SHAPE)
def test_events_and_loop_areas_are_those_of_the_cards(shape, control):
    """Touch, press in, retract until the contact is lost: two steps."""
    rng = np.random.default_rng(len(shape) + 10 * len(control))
    flat = shape == "flat"
    name, symbol, size = OF_SHAPE[shape]
    module = {"depth": cards.displacement_control, "force": cards.load_control}.get(control)
    module = module or cards.machine_control
    for _ in range(3):
        case = random_case(rng, shape)
        scene = case.scene
        delta0 = case.scene.critical_separation
        k = scene.stiffness
        length = scene.elastocapillary_length
        given = {symbol: getattr(scene.indenter, size), "k": k, "gamma1": scene.gamma1}
        given["w"] = scene.work_of_adhesion
        stiffness = k * length * 10 ** rng.uniform(-1, 1.5)
        d = 2 * delta0
        load = 2 * k * delta0 * (length + case.half_width)
        programme = {
            "depth": {"depths": [d, -d]},
            "force": {"forces": [load, -1e3 * load]},
            "drive": {"drives": [2 * d, -1e5 * d], "machine_stiffness": stiffness},
        }[control]
        path = load_path(scene, **programme)
        own = {"K": stiffness} if control == "drive" else {}
        begins = cards.displacement_control if flat else module
        jump = getattr(begins, f"{name}_jump_in")(**given, **({} if flat else own))
        ends = cards.displacement_control if flat and control == "force" else module
        let_go = getattr(ends, f"{name}_detachment")(**given, **own)
        area = float(getattr(ends, f"{name}_loop_area")(**given, **own))
        first = path.events[0]
        last = path.events[-1]
        assert first.kind == "jump-in"
        assert last.kind == ("detachment" if control == "depth" else "pull-off")
        tension = k * delta0 * (length + jump.half_width)
        assert first.after.half_width == pytest.approx(jump.half_width, rel=BARS, abs=0)
        assert abs(first.after.force - jump.force) <= BARS * tension
        assert abs(first.energy_released - jump.energy_released) <= BARS * area
        assert last.energy_released == pytest.approx(let_go.energy_released, rel=BARS, abs=0)
        assert path.dissipated == pytest.approx(area, rel=BARS, abs=0)
        assert path.work() == pytest.approx(path.dissipated, rel=1e-11, abs=0)
        most = let_go if flat else getattr(cards, name).pull_off(**given)
        for found, known in ((last.before, let_go), (path.pull_off, most)):
            assert found.force == pytest.approx(known.force, rel=BARS, abs=0)
            assert abs(found.depth - known.depth) <= BARS * delta0
            assert abs(found.half_width - known.half_width) <= BARS * jump.half_width


def test_adhesion_hysteresis_pins_the_line_and_dissipates():
    scene = adhesive(Parabola(0.02), w=0.001, opening=0.003)
    given = {"c": 25.0, "n": 2.0, "k": scene.stiffness, "gamma1": scene.gamma1}
    given |= {"w_closing": 0.001, "w": 0.003}
    top = 2 * scene.critical_separation
    bottom = -0.96 * scene.opened.critical_separation
    up, down = (cards.two_works.half_widths(d, **given) for d in (top, 0.0))
    path = load_path(scene, depths=[top, 0.0, top])
    assert path.half_width[0] == pytest.approx(up[0], rel=1e-13, abs=0)
    assert path.half_width[1] == pytest.approx(min(up[0], down[1]), rel=1e-13, abs=0)
    once, twice = (load_path(scene, depths=[top, *[bottom, top] * n]) for n in (1, 2))
    area = float(cards.two_works.cycle_area(**given, d_min=bottom, d_max=top))
    assert twice.friction - once.friction == pytest.approx(area, rel=1e-13, abs=0)
    assert area > 0
    whole = load_path(scene, depths=[top, -4 * top])
    loop = cards.two_works.loop_area(**given, d_max=top)
    assert whole.dissipated == pytest.approx(float(loop), rel=1e-13, abs=0)
    assert whole.work() == pytest.approx(whole.dissipated, rel=1e-11, abs=0)


DEEP = rippled(0.03, 0.6 * L, 0.6 * DELTA0, (-8 * L, 8 * L))
DEPTHS = np.r_[-0.1, np.linspace(0, 1.6, 5), np.linspace(1.3, -1.6, 12)] * DELTA0


@pytest.mark.parametrize(
    ("body", "touched"),
    [(DEEP, None), (Parabola(0.02), 2 * math.sqrt(0.064 * DELTA0)), (FlatPunch(0.03), 0.06)],
)
def test_springs_lose_work_of_adhesion_where_touched(body, touched):
    """γ₁ = 0: each attaches when touched and lets go at u = -δ₀, at a loss of w."""
    scene = adhesive(body, gamma1=0.0)
    x = np.linspace(-8 * L, 8 * L, 1_000_001)
    path = load_path(scene, depths=DEPTHS)
    assert (max(len(inner) for inner in path.inner) >= 4) == (touched is None)
    sure = bool(touched)
    touched = touched or np.mean(body.height(x) < DEPTHS.max()) * 16 * L
    assert path.work() == pytest.approx(0.002 * touched, rel=1e-9 if sure else 1e-5, abs=0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-8, abs=0)
    for depth, force in zip(DEPTHS[2:6], path.force[2:6], strict=True):
        assert force == pytest.approx(minimise(scene, depth).force, rel=1e-12, abs=0)
    if isinstance(body, FlatPunch):
        full = 2 * scene.stiffness * 0.03 * DELTA0
        for one in (path, load_path(scene, forces=[full, -10 * full])):
            assert one.events[-1].depth == pytest.approx(-DELTA0, rel=1e-11, abs=0)
            assert one.pull_off.force == pytest.approx(-full, rel=1e-11, abs=0)


@pytest.mark.parametrize(("tension", "steps"), [(3, 20), (30, 60)])
def test_a_contact_of_nanometres_still_holds(tension, steps):
    """Letting go does not come early where the last contact is far narrower than l."""
    layer = ElasticLayer(300.0, 0.4, 1e-5)
    w = 1e-4
    b = 5e-5
    delta0 = math.sqrt(2 * w / layer.stiffness)
    surfaces = SurfaceEnergies.from_work(layer.stiffness * (tension * b) ** 2, w)
    scene = Scene(layer, surfaces, Parabola(b * b / delta0))
    depths = -delta0 + 3 * delta0 * np.linspace(1, 0, steps) ** 2
    path = load_path(scene, depths=[*depths, -1.4 * delta0])
    expected = 2 * w * scene.elastocapillary_length
    assert path.events[-1].energy_released == pytest.approx(expected, rel=1e-11, abs=0)


def test_a_line_that_comes_free_can_be_the_pull_off():
    """Under a dead load, springs without tension: pinned up to d = 0, unstable from there on."""
    scene = adhesive(Wedge(0.05), gamma1=0.0)
    slope = math.tan(0.05)
    delta0 = scene.critical_separation
    force = scene.stiffness * delta0**2 / slope
    path = load_path(scene, forces=[force, -3 * force])
    assert path.pull_off.depth == pytest.approx(0.0, abs=1e-7 * delta0)
    assert path.pull_off.force == pytest.approx(-force, rel=1e-12, abs=0)
    assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)
