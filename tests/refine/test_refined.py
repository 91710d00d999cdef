"""Contacts found on nodes and refined: lines at rest, events, landings, states and paths."""

import math

import numpy as np
import pytest
from scenes import DELTA0, L, adhesive
from scipy.optimize import brentq

from discretization import load_path
from discretization.paths.branch import Point
from discretization.paths.control import Control
from discretization.paths.history import History
from discretization.paths.load_path import LoadPath
from discretization.paths.refined_branch import RefinedBranch
from discretization.profile import resolve
from discretization.refine import roots
from discretization.refine.equations import Equations, contact_lines, free_surfaces
from discretization.refine.events import NotRefined
from discretization.refine.plan import Refinement
from discretization.refine.settle import settle
from discretization.refine.totals import Totals
from energy import FlatPunch, Parabola, Profile, Wedge
from tests.truth.paths.path_scenes import path_case

R = 0.02
PARABOLA = adhesive(Parabola(R))


def equations_of(scene, depth):
    return Equations.of(scene, resolve(scene, depth), depth)


def ripples(height=0.6, wave=1.3, R=0.5):
    """A wide parabola with waves steeper than the contact angle."""
    rise, q = height * DELTA0, 2 * math.pi / (wave * L)
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
def test_paths_are_those_of_lines_followed_from_event_to_event(kind, seed):
    case = path_case(kind, seed)
    touch = resolve(case.scene, 0.0).touch
    top = touch + case.deep * case.scale
    depths = np.r_[np.linspace(touch, top, 5), np.linspace(top, touch - 4 * case.scale, 9)]
    path, known = path_of(case.scene, depths), load_path(case.scene, depths=depths)
    assert [event.kind for event in path.events] == [event.kind for event in known.events]
    for one, other in zip(path.events, known.events, strict=True):
        assert abs(one.depth - other.depth) <= 1e-9 * case.scale
    assert np.abs(path.force - known.force).max() <= 1e-9 * np.abs(known.force).max()


def test_a_dead_load_is_read_off_the_same_path():
    scene = ripples()
    top = float(path_of(scene, [0.0, 2 * DELTA0]).force[-1])
    loads = np.array([0.1, 0.5, 0.9, 0.4, 0.1]) * top
    branch = RefinedBranch.of(scene, 4 * DELTA0)
    history = History(scene, "force", None, 1e-8, None)
    path = LoadPath(branch, history.hold, Point(-math.inf, None))
    path.go(loads)
    known = load_path(scene, forces=loads)
    assert np.abs(history.extended(path, loads).depth - known.depth).max() <= 1e-9 * DELTA0


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
    known = load_path(case.scene, depths=[profile.touch]).events[0].after
    assert np.abs(np.subtract(contact_lines(lines), known.lines)).max() <= 1e-9 * case.length
