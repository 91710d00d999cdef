"""Contacts found on nodes and refined: lines at rest, events, landings, states and paths."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from support.example_scenes import DELTA0, L, adhesive, plain
from truth.paths.random_paths import path_case

from discretization import AccuracyWarning, load_path
from discretization.fitted.contact_lines import ContactLines
from discretization.fitted.contacts import Contacts, certify
from discretization.paths.branch import Point
from discretization.paths.control import Control
from discretization.paths.history import History
from discretization.paths.load_path import LoadPath
from discretization.paths.refined_branch import RefinedBranch
from discretization.profile import resolve
from discretization.refine import roots
from discretization.refine.equations import Equations, free_surfaces, lines_of_surfaces
from discretization.refine.events import NotRefined
from discretization.refine.judged import Judge
from discretization.refine.landings import Landings
from discretization.refine.plan import Refinement
from discretization.refine.settle import settle
from discretization.refine.totals import Totals
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

R = 0.02
PARABOLA = adhesive(Parabola(R))


def equations_of(scene, depth):
    return Equations.of(scene, resolve(scene, depth), depth)


def ripples(height=0.6, wave=1.3, R=0.5):
    """A wide parabola with waves steeper than the contact angle."""
    rise = height * DELTA0
    q = 2 * math.pi / (wave * L)
    return adhesive(
        Profile(
            lambda x: np.asarray(x) ** 2 / (2 * R) + rise * (1 - np.cos(q * np.asarray(x))),
            lambda x: np.asarray(x) / R + rise * q * np.sin(q * np.asarray(x)),
            extent=(-8 * L, 8 * L),
        )
    )


def path_of(scene, values, given="depth", stiffness=None):
    """The history of the refined branch."""
    values = np.asarray(values, float)
    history = History(scene, given, stiffness, 1e-8, None)
    path = LoadPath(
        RefinedBranch.of(scene, values.max()), Control.of(given, stiffness), Point(-math.inf, None)
    )
    path.go(values)
    return history.extended(path, values)


def test_lines_of_a_parabola_rest_where_the_closed_form_has_them():
    """(a + l)² = l² + 2R(d + δ₀), from far away and at many depths at once."""
    depths = np.linspace(-0.5, 2, 7) * DELTA0
    a = np.sqrt(L**2 + 2 * R * (depths + DELTA0)) - L
    lines = np.column_stack([1.3 * a, np.full(7, math.inf)])
    found = settle(equations_of(PARABOLA, depths.max()), lines, depths, np.ones(7))
    assert found.at_rest.all() and not found.pinned.any() and not found.jumped.any()
    assert np.abs(found.lines[:, 0] - a).max() <= 1e-13 * L


@pytest.mark.parametrize(
    ("indenter", "start", "depth", "place"),
    [(FlatPunch(2 * L), 1.9 * L, 0.3 * DELTA0, 2 * L), (Wedge(0.5), 0.01 * L, 0.1 * L, 0.0)],
)
def test_lines_are_pinned_where_the_rest_depth_jumps(indenter, start, depth, place):
    lines = np.array([[start, math.inf], [-math.inf, -start]])
    found = settle(equations_of(adhesive(indenter), depth), lines, np.full(2, depth), np.ones(2))
    assert found.at_rest.all() and found.pinned[[0, 1], [0, 1]].all()
    assert found.lines[0, 0] == place and found.lines[1, 1] == -place


def test_no_line_rests_beyond_a_fold():
    """The rest depth D of a tail falls there, so that no equilibrium is stable."""
    scene = ripples()
    equations = equations_of(scene, DELTA0)
    indenter = scene.indenter

    def rise(x):
        step = 1e-5 * L
        kink = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
        rest = indenter.height(x + np.array([-step, step]))
        rest = rest + L * (indenter.slope(x + np.array([-step, step])) - kink)
        return float(np.diff(rest)[0])

    fold = brentq(rise, 0.1 * L, 0.8 * L, xtol=1e-14)
    kink = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
    depth = float(indenter.height(fold) + L * (indenter.slope(fold) - kink))
    near = np.array([[fold - 0.02 * L, math.inf]])
    found = roots.folds(equations, near, np.array([depth]), np.ones(1), np.array([[True, False]]))
    assert found.found[0] and abs(found.depths[0] - depth) <= 1e-12 * DELTA0
    for side, rests in ((-1, True), (1, False)):
        at = np.array([depth + side * 1e-4 * DELTA0])
        state = settle(equations, near, at, np.ones(1), reach=0.2 * L)
        assert state.at_rest[0] == rests


def test_force_is_the_derivative_of_the_energy():
    """P = dU/dd along lines at rest, by a central difference, for a tail and a gap."""
    scene = ripples(0.3)
    equations = equations_of(scene, 2 * DELTA0)
    totals = Totals.of(equations)
    lines = free_surfaces((-1.5 * L, -0.9 * L, 0.8 * L, 1.4 * L))
    step = 1e-4 * DELTA0
    energies = []
    for depth in (0.2 * DELTA0 - step, 0.2 * DELTA0 + step):
        energy, _ = totals.of_surfaces(lines, np.full(3, depth))
        energies.append(energy.sum())
    _, force = totals.of_surfaces(lines, np.full(3, 0.2 * DELTA0))
    assert (energies[1] - energies[0]) / (2 * step) == pytest.approx(force.sum(), rel=1e-9)


def test_a_loop_loses_what_its_events_release():
    """∮P dd by quadrature on the pieces of all surfaces against the drops of U at the events."""
    scene = ripples()
    path = path_of(scene, np.r_[np.linspace(-0.1, 2.5, 9), np.linspace(2.4, -2.5, 9)] * DELTA0)
    released = sum(event.energy_released for event in path.events)
    assert len(path.events) >= 6 and path.depth[-1] < -DELTA0 and math.isnan(path.contacts[-1, 0])
    assert path.dissipated == pytest.approx(released, rel=1e-9)


@pytest.mark.parametrize(
    ("kind", "seed"), [("load_small", 2), ("load_edges", 13), ("load_opening", 3)]
)
def test_paths_have_the_events_of_close_nodes(kind, seed):
    """And lose what is put in."""
    case = path_case(kind, seed)
    touch = resolve(case.scene, 0.0).touch
    top = touch + case.deep * case.scale
    depths = np.r_[np.linspace(touch, top, 5), np.linspace(top, touch - 4 * case.scale, 9)]
    path = load_path(case.scene, depths=depths)
    nodes = load_path(case.scene, depths=depths, method="lattice", spacing=case.length / 256)
    assert not path.on_nodes
    jumps, known = ([e for e in one.events if "inning" not in e.kind] for one in (path, nodes))
    assert [event.kind for event in jumps] == [event.kind for event in known]
    for one, other in zip(jumps, known, strict=True):
        assert abs(one.depth - other.depth) <= 5e-3 * case.scale
    assert path.work() == pytest.approx(path.dissipated, rel=1e-9, abs=0)


def test_a_dead_load_is_read_off_the_same_path():
    """Where P is the load, lines rest at a depth that was reached before."""
    scene = ripples()
    pressed = load_path(scene, depths=[0.0, 2 * DELTA0])
    loads = np.array([0.1, 0.5, 0.9, 0.4, 0.1]) * pressed.force[-1]
    path = load_path(scene, forces=loads)
    assert np.abs(path.force - loads).max() <= 1e-9 * loads.max()
    turn = float(path.depth.max())
    known = load_path(scene, depths=[0.0, *path.depth[:2], turn, *path.depth[3:]])
    assert known.force[[1, 2, 4, 5]] == pytest.approx(loads[[0, 1, 3, 4]], rel=1e-9, abs=0)


def test_a_gap_without_adhesion_closes_and_opens():
    """There kg + γ₁f'' = 0: f = x²/20 + 0.1 cos 2x at x = 0, l = 1/2, d = 0.1 + 0.3 l²."""
    body = Profile(
        lambda x: np.asarray(x) ** 2 / 20 + 0.1 * np.cos(2 * np.asarray(x)),
        lambda x: np.asarray(x) / 10 - 0.2 * np.sin(2 * np.asarray(x)),
        extent=(-15.0, 15.0),
    )
    scene = plain(body, w=0.0, gamma1=0.25)
    path = load_path(scene, depths=[-0.1, 0.4, 0.05, -0.1])
    closing, opening = (
        next(event for event in path.events if event.kind == kind)
        for kind in ("coalescence", "splitting")
    )
    exact = 0.1 + 0.3 * 0.25
    assert [closing.depth, opening.depth] == pytest.approx([exact, exact], rel=2e-8, abs=0)
    assert not path.on_nodes and abs(path.dissipated) <= 1e-11 * path.energy.max()


def test_what_is_never_confirmed_keeps_the_nodes(monkeypatch):
    """With a warning and the depths; beyond these it is refined again."""
    scene = ripples()
    depths = np.array([0.0, 1.0, 2.0, 0.5, -1.0]) * DELTA0
    exact = load_path(scene, depths=depths)
    assert len(exact.events) > 2
    agrees = Landings.agrees
    at = exact.events[1].depth

    def never_there(self, event, *known):
        return abs(event.depth - at) > 0.2 * DELTA0 and agrees(self, event, *known)

    monkeypatch.setattr(Landings, "agrees", never_there)
    with pytest.warns(AccuracyWarning, match="could not be refined"):
        path = load_path(scene, depths=depths)
    near = 0.05 * DELTA0
    assert any(min(part) <= at <= max(part) + near for part in path.on_nodes)
    assert "parts on nodes" in "".join(path.warnings) and not exact.on_nodes
    off = np.abs(path.force - exact.force)
    assert off.max() <= 1e-3 * np.abs(exact.force).max()


def test_many_states_are_judged_as_each_is_alone():
    case = path_case("load_small", 2)
    top = resolve(case.scene, 0.0).touch + case.deep * case.scale
    branch = RefinedBranch.of(case.scene, top)
    path = LoadPath(branch, Control(None), Point(-math.inf, None))
    path.go(np.linspace(branch.touch, top, 4))
    states = [(point.lines, point.depth) for point in path.points]
    moved = [(tuple(x + 1e-6 * case.length for x in lines), depth) for lines, depth in states]
    judge = Judge(branch.refinement(0).equations, branch.contact_lines)
    for (lines, depth), found in zip(
        states + moved, judge.certificates(states + moved), strict=True
    ):
        contacts = Contacts(branch.contact_lines, lines, depth)
        alone = certify(contacts, contacts.totals())
        assert np.allclose(found[:5], alone[:5], rtol=1e-6, atol=1e-13)
    assert all(one.ok for one in judge.certificates(states))
    assert not any(one.ok for one in judge.certificates(moved))


def test_a_wrong_force_is_as_wrong_in_any_unit_of_length(monkeypatch):
    """The violation of a force that is off by 1e-3 in the certificate of many states."""
    pulls = Equations.pulls
    monkeypatch.setattr(Equations, "pulls", lambda *given: 1.001 * pulls(*given))
    violations = []
    for length in (1.0, 1e-6):
        scene = plain(Parabola(2 * length), length=length)
        depth = 0.1 * length
        judge = Judge(
            equations_of(scene, depth), ContactLines.of(scene, resolve(scene, depth), depth)
        )
        (certificate,) = judge.certificates([((-0.5 * length, 0.5 * length), depth)])
        violations.append(certificate.force)
    assert violations[0] == pytest.approx(violations[1], rel=1e-6)
    assert 1e-4 < violations[0] < 1e-3


def test_a_remnant_at_a_tip_narrower_than_the_nodes_is_found():
    """After a jump of both lines of a rippled wedge a contact of 3e-4 l is left at its tip."""
    case = path_case("load_small", 11)
    length = case.length
    depths = np.r_[0.0, 0.4, np.linspace(0.3, -0.3, 8)] * case.scale
    events = path_of(case.scene, depths).events
    jump, lost = events[-2:]
    assert (jump.kind, lost.kind) == ("jump", "detachment")
    assert 1e-5 * length < jump.after.half_width < 1e-3 * length


def test_closer_nodes_have_the_last_word_on_landings():
    """On the usual nodes the first contact of these tips spreads over two resting places."""
    case = path_case("load_opening", 29)
    profile = resolve(case.scene, 0.0)
    with pytest.raises(NotRefined, match="closer nodes find other contacts at first touch"):
        Refinement.of(case.scene, profile, profile.touch).touched()
    _, _, lines = Refinement.of(case.scene, profile, profile.touch, closer=4).touched()
    spacing = case.length / 512
    known = load_path(case.scene, depths=[profile.touch], method="lattice", spacing=spacing)
    known = known.events[0].after.lines
    assert np.abs(np.subtract(lines_of_surfaces(lines), known)).max() <= 2 * spacing


def crests(count, seed):
    """Crests 2 l apart, of heights that vary, on a bowl: of about `count` contacts."""
    alpha = 0.2
    bowl = 2 * alpha / count**2
    phases = np.random.default_rng(seed).uniform(0, 2 * math.pi, 3)
    rates = math.pi * np.array([0.31, 0.17, 0.43])

    def height(x):
        x = np.asarray(x, float)
        waves = [1 + np.cos(rate * x + phase) for rate, phase in zip(rates, phases, strict=True)]
        return bowl * x**2 + 1.5 * alpha * (1 - np.cos(math.pi * x)) + 0.15 * alpha * sum(waves)

    def slope(x):
        x = np.asarray(x, float)
        waves = [rate * np.sin(rate * x + phase) for rate, phase in zip(rates, phases, strict=True)]
        rise = 1.5 * alpha * math.pi * np.sin(math.pi * x)
        return 2 * bowl * x + rise - 0.15 * alpha * sum(waves)

    return plain(Profile(height, slope, extent=(-count - 6, count + 6)), w=0.02)


def test_events_in_another_order_than_on_nodes():
    """Of two contacts that close one after the other nodes have the wrong one first.

    A path that ended between the two depths kept a contact whose lines had passed each other.
    """
    scene = crests(10, 1)
    lowest = float(scene.indenter.height(np.linspace(-10, 10, 9999)).min())
    through = load_path(scene, depths=[lowest, lowest + 0.5, -0.1125, -0.2])
    until = load_path(scene, depths=[lowest, lowest + 0.5, -0.1125])
    assert [event.kind for event in through.events[-2:]] == ["closing", "detachment"]
    assert until.events[-1].depth == pytest.approx(through.events[-2].depth, rel=1e-9, abs=0)
    size = np.abs(through.force).max()
    assert until.force[-1] == pytest.approx(through.force[2], rel=0, abs=1e-9 * size)
    assert not until.on_nodes and not through.on_nodes


@pytest.mark.parametrize("count", [3, 10])
def test_a_loop_over_crests_loses_what_it_does_on_nodes(count):
    """Within three error estimates of nodes, as in tests/paths/test_lattice_accuracy.py."""
    scene = crests(count, 1)
    lowest = float(scene.indenter.height(np.linspace(-count, count, 9999)).min())
    depths = np.r_[lowest, np.linspace(lowest + 0.5, lowest - 0.3, 40)]
    refined = load_path(scene, depths=depths)
    nodes = load_path(scene, depths=depths, method="lattice", spacing=0.01)
    assert [event.kind for event in refined.events] == [event.kind for event in nodes.events]
    estimate = nodes.error_estimate["dissipated"]
    assert estimate <= 5e-3
    assert abs(refined.dissipated / nodes.dissipated - 1) <= 3 * estimate
    assert refined.work() == pytest.approx(refined.dissipated, rel=1e-9, abs=0)


@pytest.mark.parametrize("tip", [-2.0123456, -2.017])
def test_contacts_that_touch_at_tips_stand_there(tip):
    """With two works of adhesion, and tips between nodes."""
    x = [-9.0, tip - 0.3, tip, tip + 0.4, -1.0, 0.1, 9.0]
    z = [4.0, 0.5, 0.25, 0.5, 0.3, 0.0, 4.0]
    opening = SurfaceEnergies.from_work(1.0, 0.08)
    closing = SurfaceEnergies.from_work(1.0, 0.02)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), closing, Sampled(x, z), opening=opening)
    path = load_path(scene, depths=[0.0, 0.4])
    first, second = path.events
    assert first.after.lines == (0.1, 0.1)
    assert second.kind == "nucleation"
    assert second.after.lines[:2] == (tip, tip)
    assert [event.energy_released for event in path.events] == pytest.approx([0, 0], abs=1e-12)


def test_all_flat_faces_that_are_lowest_touch_at_once():
    """Without adhesion each is in contact over its width."""
    x = [-30.0, 0.0, 0.6, 5.4, 6.0, 11.0, 11.3, 14.0, 14.3, 40.0]
    z = [32.0, 2.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 2.0, 32.0]
    layer = ElasticLayer(1.0, 0.0, 1.0)
    scene = Scene(layer, SurfaceEnergies.from_work(1.0, 0.0), Sampled(x, z))
    path = load_path(scene, depths=[0.0, 0.1, 0.0])
    assert path.at(1).lines == (0.6, 5.4, 11.3, 14.0)
    assert path.force[[0, 2]] == pytest.approx(0, abs=1e-12)


def test_a_gap_without_a_node_in_it_is_followed_on_closer_nodes():
    """The path went on from nodes that had closed the gap, and the contact was never lost."""
    scene = path_case("load_edges", 500018).scene
    path = load_path(scene, depths=[5.3e-7, 3.71e-6, 4.6e-7])
    kinds = [event.kind for event in path.events]
    assert kinds[-2:] == ["nucleation", "closing"]


def test_a_rest_between_a_jump_and_where_nodes_land_is_not_skipped():
    """A line stops next to a corner at depths so few that nodes pass them at once."""
    scene = path_case("load_edges", 500031).scene
    path = load_path(scene, depths=[1.9e-6, 2.9e-6, 3.2e-6])
    jumps = [event.depth for event in path.events if event.kind == "jump"]
    assert jumps == pytest.approx([2.88073387e-06, 2.92272050e-06], rel=1e-8, abs=0)
    right = np.array(path.at(1).lines)[-1]
    assert 0.00537 < right < 0.005377


def test_a_touch_of_lines_beyond_a_fold_is_none():
    """Nothing touched there, and the jump came too early."""
    scene = path_case("load_small", 600029).scene
    path = load_path(scene, depths=[0.0, 0.13])
    assert path.events[-1].depth == pytest.approx(0.12676783712, rel=1e-9, abs=0)


def test_a_line_stays_at_a_corner_until_it_is_pushed_off():
    """The slope next to the corner was that of the other side, by rounding."""
    scene = path_case("machine_small", 600015).scene
    path = load_path(scene, depths=[0.003, 0.04])
    assert path.events[-1].depth == pytest.approx(0.0381548966016, rel=1e-9, abs=0)


def test_contacts_without_adhesion_begin_as_points_that_are_refined():
    """Their two lines are known to the root of rounding, and overlapped."""
    scene = path_case("machine_no_adhesion", 500010).scene
    path = load_path(scene, depths=[0.0613, 0.36])
    assert [event.kind for event in path.events] == ["touch", "nucleation", "nucleation"]
    assert not path.on_nodes


def test_a_line_stands_at_an_edge_until_it_is_pushed():
    """With two works of adhesion a line at an edge of the body stays while it would only recede."""
    scene = path_case("load_edges", 97169).scene
    assert scene.hysteretic
    edge = float(scene.indenter.walls[1])
    equations = equations_of(scene, 2e-5)
    stands = free_surfaces((-edge, edge))[1:]
    pressed = np.ones(1)
    found = settle(equations, stands, np.array([-1.2e-5]), pressed, kept=stands)
    alone = settle(equations, stands, np.array([-1.2e-5]), pressed)
    assert found.at_rest.all() and found.lines[0, 0] == edge
    assert alone.lines[0, 0] < 0.9 * edge  # where it would recede to


def test_parts_are_not_halved_where_nothing_balances(monkeypatch):
    """Where a force is wrong no part balances, however short: halving all of them has an end."""
    of_surfaces = Totals.of_surfaces
    counts = []

    def wrong(self, lines, depths, direction=1):
        counts.append(len(lines))
        energy, force = of_surfaces(self, lines, depths, direction)
        return energy, 1.001 * force

    scene = adhesive(Parabola(R) + Sampled([-9 * L, 0, 9 * L], np.zeros(3), kind="smooth"))
    refinement = Refinement.of(scene, resolve(scene, DELTA0), DELTA0)
    contacts, on_nodes, lines = refinement.touched()
    monkeypatch.setattr(Totals, "of_surfaces", wrong)
    with pytest.raises(NotRefined, match="on energy and work differ"):
        refinement.follow(contacts, on_nodes, lines, 0.0, DELTA0)
    assert 256 < max(counts) < 50_000
