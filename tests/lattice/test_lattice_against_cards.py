"""The lattice minimiser against the closed forms; nodes that are too far apart say so."""

import contextlib
import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from support.example_scenes import (
    ALPHA,
    DELTA0,
    L,
    adhesive,
    plain,
    rippled,
    rough,
    steep,
    tips,
    two,
)

from discretization import AccuracyWarning, load_path, minimise, readings
from discretization.lattice.state import on_lattice
from discretization.lattice.unresolved import Unseen, unseen, warn_unresolved
from discretization.nodes.lattice import Lattice
from energy import FlatPunch, Parabola, Plane, Profile, Wedge, cards
from studies.scenes import run
from studies.shared.random_cases import SHAPES, random_case

M = {"k": 130.0, "gamma1": 0.07, "w": 0.002}


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


def test_wedge_pinned_at_its_tip_then_free():
    """Wedge is pinned at its tip and leaves it when pressed harder."""
    delta = math.atan(2.5 * ALPHA)
    lo, hi = cards.wedge.tip_pinned_depths(delta=delta, **M)
    for d in np.linspace(lo, hi, 7)[1:-1]:
        state = minimise(adhesive(Wedge(delta)), d, method="lattice", spacing=L / 400)
        assert state.half_width == 0
        assert state.pinned.all()
        assert state.force == pytest.approx(2 * 130.0 * L * d, rel=1e-5, abs=0)
        assert state.angle_deficit > ALPHA  # a pinned line's angle is not Young's
    beyond = minimise(adhesive(Wedge(delta)), 1.2 * hi, method="lattice", spacing=L / 400)
    assert not beyond.pinned.any()
    assert beyond.half_width == pytest.approx(
        cards.wedge.half_width(1.2 * hi, delta=delta, **M), rel=1e-4, abs=0
    )
    assert minimise(adhesive(Wedge(delta)), -0.01 * DELTA0).label == "detached"


def test_wedge_contact_smaller_than_the_spacing():
    """A wedge contact smaller than the spacing is found beyond its tip."""
    delta = math.atan(2.5 * ALPHA)
    dx = L / 300
    for a in (0.2 * dx, 0.4 * dx, 0.7 * dx):
        d = cards.wedge.depth(a, delta=delta, **M)
        state = minimise(adhesive(Wedge(delta)), d, method="lattice", spacing=dx)
        assert not state.pinned.any()
        assert abs(state.half_width - a) <= 2 * dx**2 / L


SLOWLY = [pytest.param(links, marks=pytest.mark.slow) for links in (1e2, 1e3)]


@pytest.mark.parametrize("links", [0.3, 3.0, *SLOWLY])
def test_flat_faces_let_go_at_any_slope(links):
    """Flat faces let go at the critical separation at any slope."""
    for ratio in (1e-3, 0.3, 0.8):
        scene = steep(FlatPunch(0.03), ratio)
        dx = min(scene.elastocapillary_length / links, 0.004)
        d_c = -scene.critical_separation
        assert on_lattice(scene, d_c, dx).label == "neutral"
        assert on_lattice(scene, d_c * (1 + 1e-9), dx).label == "detached"
        assert on_lattice(scene, d_c * (1 - 1e-9), dx).label == "metastable"
        plane = replace(scene, indenter=Plane())
        for off, neutral in ((-6e-11, False), (-4e-11, True), (9e-13, True), (1.1e-12, False)):
            assert (minimise(plane, d_c * (1 + off)).label == "neutral") == neutral
        assert minimise(plane, d_c * (1 + 1.1e-12)).label == "detached"
        assert minimise(plane, 0.9 * d_c).half_width == math.inf


WIDE = (0.2, 0.01)
FAINT = (0.02, 1e-4)  # faint: less steep than the profile is over a link


@pytest.mark.parametrize(("spacing", "wave"), [(0.2, WIDE), (0.15, WIDE), (0.2, FAINT)])
def test_ripples_narrower_than_the_spacing_give_a_warning(spacing, wave):
    scene = plain(rippled(1.0, *wave, (-2, 2)).shifted(0.03), gamma1=0.0025, w=1.25e-5)
    ripple = "narrower than the spacing"
    sparse = "nodes are too far apart"
    with pytest.warns(AccuracyWarning, match=ripple), pytest.warns(AccuracyWarning, match=sparse):
        minimise(scene, 0.03, method="lattice", spacing=spacing)
    with pytest.warns(AccuracyWarning, match=ripple), pytest.warns(AccuracyWarning, match=sparse):
        load_path(scene, depths=[0.0, 0.03], method="lattice", spacing=spacing)
    minimise(scene, 0.03, method="lattice", spacing=wave[0] / 20)  # none where they are resolved


def test_tip_between_nodes_warns():
    """A tip of width 0.02 at x = 0.55, one deep enough and one that is not."""

    def body(deep):
        tip = lambda x: deep * np.exp(-(((np.asarray(x) - 0.55) / 0.01) ** 2))  # noqa: E731
        rise = lambda x: 2e4 * (np.asarray(x) - 0.55) * tip(x)  # noqa: E731
        return Parabola(1.0) + Profile(lambda x: -tip(x), rise, extent=(-2, 2))

    with pytest.warns(AccuracyWarning, match=r"at x = 0\.5[45]"):
        minimise(plain(body(0.3), gamma1=0.01, w=1e-4), 0.01, method="lattice", spacing=0.1)
    quiet = plain(body(0.13), gamma1=0.01, w=1e-4)
    assert unseen(quiet, 0.01, Lattice.of(quiet, 0.1)).x.size
    minimise(quiet, 0.01, method="lattice", spacing=0.1)


def test_a_contact_between_two_nodes_gives_a_warning():
    tip = Profile(np.square, lambda x: 2 * np.asarray(x), (-1, 1))
    body = tip.shifted(0.05) + tip.shifted(0.05)
    with pytest.warns(AccuracyWarning, match="narrower than the spacing"):
        state = minimise(plain(body, gamma1=0.01, w=0.0), 1e-3, method="lattice", spacing=0.1)
    assert not state.contacts.size


def test_contacts_narrower_than_two_links():
    """Contacts narrower than two links are known to their own size."""
    body = Profile(lambda x: 20 * np.square(x), lambda x: 40 * np.asarray(x), extent=(-1, 1))
    state = minimise(plain(body, gamma1=0.04, w=1e-4), 1e-3, method="lattice", spacing=0.05)
    assert min(state.error_estimate.values()) >= 1 and np.diff(state.nodes).max() <= 0.05
    fine = minimise(plain(body, gamma1=0.04, w=1e-4), 1e-3, method="lattice", spacing=5e-4)
    assert max(fine.error_estimate.values()) <= 0.1
    with pytest.warns(AccuracyWarning, match="the nodes have no contact"):
        sharp = minimise(plain(Parabola(1e-5), gamma1=0.04), -1e-3, method="lattice", spacing=0.05)
    assert not sharp.contacts.size and sharp.error_estimate["half_width"] == math.inf


@pytest.mark.parametrize(("share", "warned"), [(0.9, False), (1.1, True)])
def test_penetration_beyond_1e_9_warns(share, warned):
    """A penetration by more than 1e-9 of the depths is warned of."""
    scene = plain(Parabola(1.0), gamma1=1.0, w=0.02)
    state = minimise(scene, -1.5 * scene.critical_separation)
    height = state.depth * (1 + share * 1e-9)  # of a tip that no node sees
    hidden = Unseen(np.zeros(1), np.array([height]), np.ones(1), np.array([False]))
    with pytest.warns(AccuracyWarning) if warned else contextlib.nullcontext():
        warn_unresolved([state], hidden, Lattice.of(scene, 0.1), 1)


SOFT = adhesive(Parabola(0.02), k=6.73e8, gamma1=0.07, w=6e-5)
LENGTH = SOFT.elastocapillary_length
LATTICE = {"method": "lattice"}


def told(state):
    """The names of the violated assumptions on nodes."""
    return {one.name for one in state.resolution if not one.holds}


@pytest.mark.parametrize("branch", ["adhered", "global"])
@pytest.mark.parametrize("spacing", [1.01, 10, 1e3, 1e6])
def test_nodes_further_apart_than_the_decay_length_are_warned_of(spacing, branch):
    with pytest.warns(AccuracyWarning, match=r"too far apart: Δx/l = .*give a smaller spacing"):
        state = minimise(SOFT, 3e-7, **LATTICE, spacing=spacing * LENGTH, branch=branch)
    assert "Δx/l" in told(state) and any("Δx/l" in warning for warning in state.warnings)
    assert ("Δx/a" in told(state)) == (spacing >= 10)
    assert "Δx/l" in str(state) and minimise(SOFT, 3e-7).resolution == ()


def test_paths_warn_before_they_are_followed():
    with pytest.warns(AccuracyWarning, match="too far apart"):
        load_path(SOFT, depths=[0.0, 3e-7], **LATTICE, spacing=2 * LENGTH)


@pytest.mark.parametrize("half", [0.7, 1.37, 2.11])
def test_an_arch_stands_on_its_edges_wherever_the_nodes_would_be(half):
    """Two contacts of no width, P = 2γ₁u(1 + tanh(a/l))/l with u at them, in second order."""
    end = half * L
    u = 0.3 * DELTA0
    arch = Profile(lambda x: -25 * np.square(x), lambda x: -50 * np.asarray(x), (-1, 1))
    scene = adhesive(arch + FlatPunch(end), w=0.0)
    depth = u - 25 * end**2
    force = 2 * scene.surfaces.gamma1 * u / L * (1 + math.tanh(half))
    for nodes in (10, 20, 37.3, 40):
        given = {**LATTICE, "spacing": L / nodes}
        for found in (minimise(scene, depth, **given), load_path(scene, depths=[depth], **given)):
            assert np.ravel(found.force)[-1] == pytest.approx(force, rel=0.2 / nodes**2, abs=0)


def test_the_edges_and_a_tip_in_the_middle_are_nodes():
    for body in (Wedge(0.1) + FlatPunch(0.01), FlatPunch(0.01)):
        x = Lattice.of(adhesive(body), 0.003).x(np.arange(9.0))
        assert np.allclose(x[[0, 4, 8]], [-0.01, 0.0, 0.01], rtol=0, atol=1e-15)


@pytest.mark.filterwarnings("ignore::discretization.AccuracyWarning")  # outside the limits
@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_inside_the_limits_the_half_width_is_known_to_a_tenth(geometry):
    """Random parabolas, with tension against adhesion and curvature over decades."""
    rng = np.random.default_rng(4)
    seen = 0
    sparse = 0
    for _ in range(40):
        w = 10 ** rng.uniform(-4, -1)
        R = 10 ** rng.uniform(0, 4)
        scene = replace(plain(Parabola(R), w=w), geometry=geometry)
        depth = scene.critical_separation * rng.uniform(-0.5, 3)
        true = minimise(scene, depth)
        spacing = scene.elastocapillary_length * rng.uniform(0.1, 1)
        state = minimise(scene, depth, **LATTICE, spacing=spacing)
        if state.contacts.size and not told(state):
            assert state.half_width == pytest.approx(true.half_width, rel=0.1)
            seen += 1
        sparse += "Δx/a" in told(state)
    assert seen > 20 and sparse > 3


@pytest.mark.filterwarnings("always::discretization.AccuracyWarning")
def test_ripples_between_nodes_are_resolved_or_not_at_all():
    """Lines hold at ripples: what is told without a warning is no less than the error."""
    rng = np.random.default_rng(9)
    told_of = 0
    for _ in range(40):
        wave = rng.uniform(0.5, 3) / 20
        steep = 0.02 * 10 ** rng.uniform(-1.5, 0.3)
        waves = rippled(math.inf, 2 * math.pi * wave, steep * wave, (-3.0, 3.0))
        scene = plain(Parabola(20.0) + waves.shifted(rng.uniform(0, 6) * wave), w=2e-4)
        depth = scene.critical_separation * rng.uniform(-0.3, 2)
        with warnings.catch_warnings(record=True) as said:
            state = minimise(scene, depth, **LATTICE, spacing=1 / 20)
            known = state.error_estimate["half_width"]
        if state.contacts.size and not said and np.isfinite(known):
            true = minimise(scene, depth)
            told_of = told_of + 1
            assert len(true.contacts) == len(state.contacts), (wave, steep)
            assert abs(state.half_width / true.half_width - 1) <= known, (wave, steep)
    assert told_of > 13


def test_where_nodes_lose_nothing_nothing_is_said():
    assert minimise(plain(Plane()), 0.1, **LATTICE, spacing=50.0).resolution == ()
    punch = minimise(plain(FlatPunch(1.0)), 0.1, **LATTICE, spacing=0.4)  # held at both edges
    off = abs(punch.energy + 0.02) / punch.scales["energy"]
    assert not told(punch) and off < punch.error_estimate["energy"] < 2 * off
    springs = minimise(plain(Parabola(10.0), gamma1=0.0), 0.1, **LATTICE, spacing=0.01)
    assert [one.name for one in springs.resolution] == ["Δx/a"] and not told(springs)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "depth", "cells"),
    [
        (Parabola(0.02), -0.95, 4),  # narrower than a link
        (Parabola(0.02), -0.9, 12),  # a few links
        (Wedge(0.05).shifted(0.3 * L), -0.75, 3),
        (tips(3 * L), 1.0, 6.7),  # between nodes
        (two(3 * L), -0.3, 2.75),  # detached, where a finer lattice is not
        (rough(149).indenter, 1.2, 2.8),  # unresolved roughness inside the contact
    ],
)
def test_what_a_lattice_does_not_resolve_has_no_estimate(body, depth, cells):
    scene = adhesive(body)
    spacing = L / cells
    state = on_lattice(scene, depth * DELTA0, spacing)
    assert set(state.error_estimate.values()) == {math.inf}
    shown = 4 if state.contacts.size else 3  # where there is a line, its angle, too
    assert str(state).count("not resolved: use smaller spacing") == shown
    assert "not res." in run.row(state)
    fine = on_lattice(scene, depth * DELTA0, L / 200)
    assert max(fine.error_estimate.values()) < 0.1 or body.corners


def test_a_state_that_is_detached_on_any_lattice_has_no_error():
    for body in (Parabola(0.02), two(3 * L)):
        state = on_lattice(adhesive(body), -1.01 * DELTA0, L / 5)
        assert state.label == "detached"
        assert set(state.error_estimate.values()) == {0.0}


def test_errors_are_told_in_the_units_of_their_quantities():
    """The force passes through 0, and its error stays what it is."""
    scene = adhesive(Parabola(0.02))
    level = brentq(lambda d: minimise(scene, d).force, 0.01 * DELTA0, 2 * DELTA0, xtol=1e-16)
    state = on_lattice(scene, level, L / 40)
    limit = state.uncertainty["force"]
    assert abs(state.force) <= limit == state.error_estimate["force"] * state.scales["force"]
    shown = readings.rounded(state.force, limit)
    assert f"force        P = {shown} N/m   (numerical error {limit:.1g} N/m)" in str(state)
    assert limit > 100 * abs(minimise(scene, level).force)
