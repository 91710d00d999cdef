"""What nodes do not resolve of a profile is noticed, on states and on paths."""

import math
import re
import warnings

import numpy as np
import pytest
from support.example_scenes import adhesive, plain, turned
from support.narrow_features import case_of, outcome, path_outcome

from discretization import AccuracyWarning, load_path, minimise
from discretization.lattice.unresolved import astray, lost_too_early
from discretization.nodes.lattice import Lattice
from energy import FlatPunch, Parabola, PowerLaw, Sampled, Wedge

LATTICE = {"method": "lattice"}
NAMED = re.compile(r"give a spacing of ([-0-9.e]+),")


def told(question):
    """The answer, and the spacings that are named in its warnings."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always", AccuracyWarning)
        answer = question()
    said = " ".join(str(one.message) for one in found)
    return answer, [float(one) for one in NAMED.findall(said)]


def trapezoid(width, high=2.0, half=1.0):
    """A flat face between two flanks of this width."""
    x = [-9, -half - width, -half, half, half + width, 9]
    return Sampled(x, [high + 1, high, 0, 0, high, high + 1])


FLANKS = [
    (trapezoid(0.01), 0.025),
    (trapezoid(0.01), 0.0125),
    (trapezoid(0.004, high=0.5), 0.02),
    (trapezoid(0.03, half=1.31), 0.05),
]


@pytest.mark.parametrize(("body", "spacing"), FLANKS)
def test_a_flank_narrower_than_the_spacing(body, spacing):
    """The line stays at the edge of the face: P = 2kd(a + l) for -δ₀ < d <= 0."""
    scene = plain(body)
    depths = np.linspace(0, -0.15, 16)
    _, closer = told(lambda: load_path(scene, depths=depths, **LATTICE, spacing=spacing))
    assert closer
    _, own = told(lambda: minimise(scene, -0.11, **LATTICE, spacing=spacing))
    assert own
    closer = min(closer + own)
    half = float(body.x[3])
    path = load_path(scene, depths=depths, **LATTICE, spacing=closer)  # without a warning
    force = 2 * depths * (half + 1)
    assert np.abs(path.force - force).max() <= 1e-3 * np.abs(force).max()
    state = minimise(scene, -0.11, **LATTICE, spacing=closer)
    assert state.half_width == pytest.approx(half, rel=1e-3, abs=0)


NEEDLES = [(1.56, 1.0, 0.25), (1.54, 0.9, 0.25), (1.55, 1.0, 0.4), (1.565, 1.3, 0.1)]


@pytest.mark.parametrize(("delta", "w", "depth"), NEEDLES)
def test_a_needle_with_finite_slopes(delta, w, depth):
    scene = plain(Wedge(delta), w=w, slopes="finite")
    true = minimise(scene, depth)
    _, closer = told(lambda: minimise(scene, depth, **LATTICE, spacing=0.02))
    assert closer
    state = minimise(scene, depth, **LATTICE, spacing=min(closer))
    for name, size in state.uncertainty.items():
        assert abs(getattr(state, name) - getattr(true, name)) <= 3 * size


def test_a_needle_held_at_its_tip_is_resolved_by_any_nodes():
    scene = plain(Wedge(1.5), w=0.1, slopes="finite")
    true = minimise(scene, 0.1)
    state = minimise(scene, 0.1, **LATTICE, spacing=0.02)
    assert true.half_width == 0
    assert state.force == pytest.approx(true.force, rel=1e-3, abs=0)


TIPS = [(0.15, 1.2, -0.18), (0.1, 1.2, -0.19), (0.2, 1.1, -0.15), (0.3, 1.3, -0.18)]


@pytest.mark.parametrize(("c", "n", "depth"), TIPS)
def test_a_contact_narrower_than_a_link(c, n, depth):
    scene = plain(PowerLaw(c, n))
    true = minimise(scene, depth)
    state, closer = told(lambda: minimise(scene, depth, **LATTICE, spacing=0.01))
    assert not state.contacts.size and min(state.error_estimate.values()) == math.inf
    lattice = Lattice.of(scene, 0.01)
    assert 0.5 <= lost_too_early(scene, lattice, depth) / true.half_width <= 1
    path, _ = told(
        lambda: load_path(scene, depths=np.linspace(0, depth, 10), **LATTICE, spacing=0.01)
    )
    assert path.force[-1] == pytest.approx(true.force, rel=1e-3)  # a lone node holds on a path
    if true.half_width > 1e-6:
        near = minimise(scene, depth, **LATTICE, spacing=min(closer))
        assert near.force == pytest.approx(true.force, rel=1e-4, abs=0)


def test_nothing_narrow_is_left_where_the_indenter_has_let_go():
    scene = plain(PowerLaw(0.15, 1.2))
    lattice = Lattice.of(plain(PowerLaw(0.15, 1.2)), 0.01)
    lost = scene.critical_separation
    assert lost_too_early(scene, lattice, -lost * (1 + 1e-6)) == 0
    assert lost_too_early(scene, lattice, 0.01) == 0
    wedge = plain(Wedge(math.atan(0.3)))  # steeper than √(2w/γ₁): nothing is held above touching
    assert lost_too_early(wedge, Lattice.of(wedge, 0.01), -1e-3) == 0
    blunt = plain(Wedge(math.atan(0.1)))
    assert lost_too_early(blunt, Lattice.of(blunt, 0.01), -0.09) > 0
    assert lost_too_early(blunt, Lattice.of(blunt, 0.01), -0.11) == 0
    assert lost_too_early(blunt, Lattice.of(blunt, 0.01), -0.09, "global") == 0


@pytest.mark.parametrize("geometry", ["line", "axis"])
def test_lines_of_the_closed_form_rest_on_nodes(geometry):
    """Lines of the closed form rest and lines half a link aside do not."""
    make = adhesive if geometry == "line" else turned
    scene = make(Parabola(0.02))
    state = minimise(scene, 0.3 * scene.critical_separation)
    length = scene.elastocapillary_length
    lattice = Lattice.of(scene, length / 4)
    depth = np.array([state.depth])
    lines = state.contacts.reshape(1, -1)
    assert not astray(scene, lattice, depth, lines).any()
    for share in (-0.5, 0.5):
        aside = lines + share * lattice.spacing * np.array([-1.0, 1.0])
        assert astray(scene, lattice, depth, aside)[0, -1]


def test_the_edges_of_a_punch_hold_lines_on_any_nodes():
    scene = plain(FlatPunch(0.3) + Parabola(20.0))
    for depth in (0.5, 0.0, -0.1):
        for spacing in (0.3, 0.1, 0.013):
            state = minimise(scene, depth, **LATTICE, spacing=spacing)
            assert state.half_width == pytest.approx(0.3, rel=1e-9, abs=0)


@pytest.mark.parametrize("seed", range(20))
def test_random_states_are_right_or_warned_of(seed):
    assert outcome(case_of(seed)).word != "wrong"


@pytest.mark.parametrize("seed", range(1, 5))
def test_random_paths_are_right_or_warned_of(seed):
    assert path_outcome(case_of(seed, paths=True)).word != "wrong"
