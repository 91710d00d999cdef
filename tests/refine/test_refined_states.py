"""States of several contacts: contacts on nodes near no event, and their lines at rest."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.example_scenes import DELTA0, L, adhesive, rough, wavy
from truth.random_states import case_of

from discretization import load_path, minimise
from discretization.fitted.states import on_several
from discretization.profile import resolve
from discretization.refine.nodes import FoundNodes, slope_turns
from discretization.refine.pressed import pressed
from discretization.refine.steady import steady_contacts
from energy import Profile, Sampled, SurfaceEnergies


def nodes_of(scene, depth, closer=1):
    """Nodes for depths up to this one."""
    return FoundNodes.of(scene, resolve(scene, depth), depth, closer)


def agree(state, known):
    """Whether two states have the same contacts, force and energy."""
    assert state.certificate.ok and state.contacts.shape == known.contacts.shape
    assert np.abs(state.contacts - known.contacts).max(initial=0.0) <= 1e-9 * L
    assert abs(state.force - known.force) <= 1e-9 * known.scales["force"]
    assert abs(state.energy - known.energy) <= 1e-9 * known.scales["energy"]


@pytest.mark.parametrize("seed", range(8))
def test_states_are_those_of_lines_that_move_one_by_one(seed):
    scene = rough(seed)
    depth = float(np.random.default_rng(seed).uniform(-0.6, 1.5)) * DELTA0
    agree(minimise(scene, depth), on_several(scene, depth, branch="adhered"))


@pytest.mark.parametrize("seed", range(4))
def test_states_without_adhesion_are_found_at_once(seed):
    scene = rough(seed)
    scene = replace(scene, surfaces=SurfaceEnergies.from_work(scene.gamma1, 0.0))
    depth = resolve(scene, 0.0).touch + 1.5 * DELTA0
    agree(minimise(scene, depth), on_several(scene, depth, branch="adhered"))


@pytest.mark.parametrize("factor", [1.5, 4.0])
def test_states_with_two_works_of_adhesion(factor):
    """They stand where they are pinned."""
    scene = rough(2)
    opening = SurfaceEnergies.from_work(scene.gamma1, factor * scene.work_of_adhesion)
    scene = replace(scene, opening=opening)
    for depth in (-0.5 * DELTA0, 0.8 * DELTA0):
        agree(minimise(scene, depth), on_several(scene, depth, branch="adhered"))


@pytest.mark.parametrize("kind", ["small", "edges"])
@pytest.mark.parametrize("seed", [6000, 6004, 6010])
def test_contacts_pressed_at_once_are_those_of_the_walk(kind, seed):
    case = case_of(kind, seed)
    nodes = nodes_of(case.scene, case.depth)
    depth = max(case.depth, nodes.row.lowest)
    assert pressed(nodes.walk, depth) == nodes.walk.touched(depth)


def test_contacts_next_to_an_event_are_not_believed():
    """On either side of a jump on the nodes, and where the contact is lost."""
    scene = wavy(0.002, crests=4)
    nodes = nodes_of(scene, 3 * DELTA0)
    walk = nodes.walk
    lowest = nodes.row.lowest
    event = walk.track(walk.touched(lowest), lowest, 3 * DELTA0)
    assert event.at is not None and len(event.after) > len(event.trace[-1][1]) // 2
    margin = 0.01 * DELTA0
    for beside in (-0.9, 0.9):
        assert steady_contacts(nodes, event.at + beside * margin, margin) is None
    before = steady_contacts(nodes, event.at - 1.1 * margin, margin)
    assert before is not None and len(before) == len(event.trace[-1][1]) // 2
    lost = walk.track(walk.touched(lowest), lowest, -3 * DELTA0)
    while lost.after:
        lost = walk.track(lost.after, lost.at, -3 * DELTA0)
    assert steady_contacts(nodes, lost.at + 0.5 * margin, margin) is None
    assert steady_contacts(nodes, lost.at - 2 * margin, margin) == ()


def test_states_right_beside_an_event():
    """Nodes are no guide there, as they have the event at another depth."""
    scene = rough(3)
    touch = resolve(scene, 0.0).touch
    path = load_path(scene, depths=touch + np.linspace(0, 3, 9) * DELTA0)
    event = next(event for event in path.events if event.kind == "nucleation")
    for side, known, contacts in ((-1, event.before, 1), (1, event.after, 2)):
        state = minimise(scene, event.depth + side * 1e-6 * DELTA0)
        assert state.certificate.ok and len(state.contacts) == contacts
        assert abs(state.force - known.force) <= 1e-4 * state.scales["force"]
        assert abs(state.energy - known.energy) <= 1e-4 * state.scales["energy"]


def rippled(kind, samples):
    """A wide parabola with ripples, measured at many places."""
    x = np.linspace(-8 * L, 8 * L, samples)
    ripples = 0.3 * DELTA0 * (1 - np.cos(2 * math.pi * x / (1.3 * L)))
    return adhesive(Sampled(x, x**2 + ripples, kind=kind))


def test_lines_pass_many_facets_of_a_measured_profile():
    straight, smooth = (
        minimise(rippled(kind, 100_001), 0.75 * DELTA0) for kind in ("linear", "smooth")
    )
    assert len(straight.contacts) == len(smooth.contacts) == 3
    assert straight.force == pytest.approx(smooth.force, rel=1e-4)
    assert np.abs(straight.contacts - smooth.contacts).max() <= 2 * 16 * L / 100_000


def test_profiles_of_narrow_features_do_not_need_as_many_nodes():
    """A spike of 1e-3 l on 18 l is found without as many nodes as there are such widths."""
    width = 1e-3 * L
    places_read = []

    def spike(x):
        return 0.2 * DELTA0 * np.exp(-(((x - L) / width) ** 2))

    def height(x):
        x = np.asarray(x)
        places_read.append(x.size)
        return x**2 - spike(x)

    def slope(x):
        x = np.asarray(x)
        return 2 * x + 2 * (x - L) / width**2 * spike(x)

    scene = adhesive(Profile(height, slope, extent=(-9 * L, 9 * L), knots=(L,)))
    state = minimise(scene, 0.5 * DELTA0)
    assert state.certificate.ok and len(state.contacts) == 2
    assert sum(places_read) < 18 * L / width / 2


def test_slopes_turn_where_they_have_changed_and_change_back():
    x = np.linspace(0.0, 4 * math.pi, 2001)
    noise = 1e-3 * np.random.default_rng(0).uniform(-1, 1, x.size)
    turns = slope_turns(x, np.sin(x) + noise, 0.1)
    assert np.abs(turns - math.pi * (0.5 + np.arange(4))).max() <= 0.1


def test_lowest_contacts_of_a_link_are_sought_on_closer_nodes():
    """Two rows of nodes agreed on 9 contacts, as the adhered state had 9, too."""
    case = case_of("global", 91003)
    state = minimise(case.scene, case.depth, branch="global")
    assert len(state.contacts) == 10
    assert state.energy == pytest.approx(0.10648696804, rel=1e-9)  # of tests/truth, 9: 0.10663
