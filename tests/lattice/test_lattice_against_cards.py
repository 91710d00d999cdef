"""The lattice minimiser against the closed forms: errors, orders, special cases."""

import contextlib
import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive, plain, rippled, steep
from truth.compare import reference
from truth.scenes import case_of

from discretization import AccuracyWarning, load_path, minimise
from discretization.lattice.accuracy import Unseen, looked_at, unseen
from discretization.lattice.state import on_lattice
from discretization.nodes.lattice import Lattice
from energy import FlatPunch, Parabola, Plane, Profile, Wedge, cards
from studies.shared.random_cases import SHAPES, random_case

K, GAMMA1, W = 130.0, 0.07, 0.002
M = {"k": K, "gamma1": GAMMA1, "w": W}
L, DELTA0 = math.sqrt(GAMMA1 / K), math.sqrt(2 * W / K)


@pytest.mark.parametrize("shape", SHAPES)
def test_random_scenes_over_eight_decades(shape):
    rng = np.random.default_rng(SHAPES.index(shape))
    for _ in range(60):
        case = random_case(rng, shape)
        dx = case.resolved / 200
        state = minimise(case.scene, case.depth, method="lattice", spacing=dx)
        raw = (state.nodes[0, 1] - state.nodes[0, 0]) / 2
        assert abs(raw - case.half_width) <= 0.6 * dx
        assert abs(state.half_width - case.half_width) <= 2 * dx**2 / case.resolved
        assert abs(state.force - case.force) <= 1e-4 * abs(case.force)
        assert abs(state.energy - case.energy) <= 1e-4 * state.scales["energy"]
        if shape != "flat":
            young = cards.contact_line.angle_deficit_small(
                case.scene.work_of_adhesion, case.scene.gamma1
            )
            assert abs(state.angle_deficit - young) <= 0.01 * young


def test_wedge_is_pinned_at_its_tip_and_leaves_it_when_pressed_harder():
    delta = math.atan(2.5 * DELTA0 / L)
    lo, hi = cards.wedge.tip_pinned_depths(delta=delta, **M)
    for d in np.linspace(lo, hi, 7)[1:-1]:
        state = minimise(adhesive(Wedge(delta)), d, method="lattice", spacing=L / 400)
        assert state.half_width == 0
        assert state.pinned.all()
        assert state.force == pytest.approx(2 * K * L * d, rel=1e-5, abs=0)
        assert state.angle_deficit > DELTA0 / L  # a pinned line's angle is not Young's
    beyond = minimise(adhesive(Wedge(delta)), 1.2 * hi, method="lattice", spacing=L / 400)
    assert not beyond.pinned.any()
    assert beyond.half_width == pytest.approx(
        cards.wedge.half_width(1.2 * hi, delta=delta, **M), rel=1e-4, abs=0
    )
    assert minimise(adhesive(Wedge(delta)), -0.01 * DELTA0).label == "detached"


def test_a_wedge_contact_smaller_than_the_spacing_is_found_beyond_its_tip():
    delta = math.atan(2.5 * DELTA0 / L)
    dx = L / 300
    for a in (0.2 * dx, 0.4 * dx, 0.7 * dx):
        d = cards.wedge.depth(a, delta=delta, **M)
        state = minimise(adhesive(Wedge(delta)), d, method="lattice", spacing=dx)
        assert not state.pinned.any()
        assert abs(state.half_width - a) <= 2 * dx**2 / L


SLOWLY = [pytest.param(links, marks=pytest.mark.slow) for links in (1e2, 1e3)]


@pytest.mark.parametrize("links", [0.3, 3.0, *SLOWLY])
def test_flat_faces_let_go_at_the_critical_separation_at_any_slope(links):
    for ratio in (1e-3, 0.3, 0.8):
        scene = steep(FlatPunch(0.03), ratio)
        dx = min(scene.elastocapillary_length / links, 0.004)
        d_c = -scene.critical_separation
        assert on_lattice(scene, d_c, dx).label == "neutral"
        assert on_lattice(scene, d_c * (1 + 1e-9), dx).label == "detached"
        assert on_lattice(scene, d_c * (1 - 1e-9), dx).label == "metastable"
        plane = replace(scene, indenter=Plane())
        assert minimise(plane, d_c).label == "neutral"
        assert minimise(plane, d_c * (1 + 1e-9)).label == "detached"
        assert minimise(plane, 0.9 * d_c).half_width == math.inf


RIPPLED = rippled(1.0, 0.2, 0.01, (-2, 2))


def spacing_of(case):
    length = case.scene.elastocapillary_length or case.feature
    return min(length / 12, case.feature / 8)


def on_nodes(case, spacing):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # the coarser levels
        return minimise(case.scene, case.depth, method="lattice", spacing=spacing)


def resolved(case, half_width):
    """Whether the case is not too long for a test, and its contacts not too small for its nodes."""
    lo, hi = case.scene.indenter.extent
    return (hi - lo) / spacing_of(case) < 2e4 and half_width > spacing_of(case)


def test_contacts_that_began_on_the_way_stay():
    """A single contact is in equilibrium here, too, but the path has three."""
    scene = plain(RIPPLED, gamma1=0.0025, w=1.25e-5)
    state = minimise(scene, 0.03, method="lattice", spacing=1e-3)
    assert len(state.contacts) == 3
    assert state.force == pytest.approx(0.0066820, abs=5e-8)
    path = load_path(scene, depths=[0.0, 0.01, 0.03], method="lattice", spacing=1e-3)
    assert path.force[-1] == pytest.approx(state.force, rel=5e-3)
    assert len(path.inner[-1]) == 4


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 60, 20)[:2])
def test_adhered_states_are_those_of_the_walk(first):
    seen = 0
    for seed in range(first, first + 10):
        case = case_of("small", seed)
        truth, _ = reference(case)
        if truth is None or not resolved(case, truth.half_width):
            continue
        state = on_nodes(case, spacing_of(case) / 8)
        assert len(state.contacts) == len(truth.contacts), seed
        assert abs(state.force - truth.force) <= 2e-3 * truth.force_scale, seed
        seen += 1
    assert seen >= 3


@pytest.mark.parametrize("spacing", [0.2, 0.15])
def test_ripples_narrower_than_the_spacing_give_a_warning(spacing):
    scene = plain(RIPPLED.shifted(0.03), gamma1=0.0025, w=1.25e-5)
    ripple, sparse = "narrower than the spacing", "nodes are too far apart"
    with pytest.warns(AccuracyWarning, match=ripple), pytest.warns(AccuracyWarning, match=sparse):
        minimise(scene, 0.03, method="lattice", spacing=spacing)
    with pytest.warns(AccuracyWarning, match=ripple), pytest.warns(AccuracyWarning, match=sparse):
        load_path(scene, depths=[0.0, 0.03], method="lattice", spacing=spacing)
    minimise(scene, 0.03, method="lattice", spacing=0.01)  # and none where they are resolved


def test_a_tip_between_the_nodes_gives_a_warning_where_the_surface_is_above_it():
    """A tip of width 0.02 at x = 0.55, one deep enough and one that is not."""

    def body(deep):
        return Profile(
            lambda x: np.square(x) / 2 - deep * np.exp(-(((np.asarray(x) - 0.55) / 0.01) ** 2)),
            lambda x: (
                np.asarray(x)
                + 2e4 * deep * (np.asarray(x) - 0.55) * np.exp(-(((x - 0.55) / 0.01) ** 2))
            ),
            extent=(-2, 2),
        )

    with pytest.warns(AccuracyWarning, match=r"at x = 0\.5[45]"):
        minimise(plain(body(0.3), gamma1=0.01, w=1e-4), 0.01, method="lattice", spacing=0.1)
    quiet = plain(body(0.13), gamma1=0.01, w=1e-4)
    assert unseen(quiet, 0.01, Lattice.of(quiet, 0.1)).x.size
    minimise(quiet, 0.01, method="lattice", spacing=0.1)


def test_a_contact_between_two_nodes_gives_a_warning():
    body = Profile(
        lambda x: 2 * (np.asarray(x) - 0.05) ** 2, lambda x: 4 * (np.asarray(x) - 0.05), (-2, 2)
    )
    with pytest.warns(AccuracyWarning, match="narrower than the spacing"):
        state = minimise(plain(body, gamma1=0.01, w=0.0), 1e-3, method="lattice", spacing=0.1)
    assert not state.contacts.size


def test_contacts_narrower_than_two_links_are_known_to_their_own_size():
    body = Profile(lambda x: 20 * np.square(x), lambda x: 40 * np.asarray(x), extent=(-1, 1))
    state = minimise(plain(body, gamma1=0.04, w=1e-4), 1e-3, method="lattice", spacing=0.05)
    assert state.contacts.size and np.diff(state.nodes).max() <= 0.05
    assert min(state.error_estimate.values()) >= 1
    fine = minimise(plain(body, gamma1=0.04, w=1e-4), 1e-3, method="lattice", spacing=5e-4)
    assert max(fine.error_estimate.values()) <= 0.1


@pytest.mark.parametrize(("share", "warned"), [(0.9, False), (1.1, True)])
def test_a_penetration_by_more_than_1e_9_of_the_depths_is_warned_of(share, warned):
    scene = plain(Parabola(1.0), gamma1=1.0, w=0.02)
    state = minimise(scene, -1.5 * scene.critical_separation)
    height = state.depth * (1 + share * 1e-9)  # of a tip that no node sees
    hidden = Unseen(np.zeros(1), np.array([height]), np.ones(1))
    with pytest.warns(AccuracyWarning) if warned else contextlib.nullcontext():
        looked_at([state], hidden, Lattice.of(scene, 0.1), 1)
