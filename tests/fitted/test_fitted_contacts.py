"""Several contacts on the fitted mesh: against themselves, the lattice, single contacts, energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from support.example_scenes import ALPHA, DELTA0, L, adhesive, rough, steep, two, wavy

from discretization import load_path, minimise
from discretization.equilibrium import QUANTITIES
from discretization.roots import minima
from discretization.surfaces import small
from discretization.surfaces.network import Line
from energy import Parabola, Sampled, Wedge


def linear(seed, w):
    """A rough body with a corner at every second sample of the smooth one."""
    scene = rough(seed, w=w)
    body = scene.indenter.first
    return replace(scene, indenter=Sampled(body.x[::2], body.z[::2]) + scene.indenter.second)


DEPTH = 2.3 * DELTA0
CASES = [(0.0, "adhered"), (0.002, "global")]


def errors(state, exact):
    """In the lines over l, in a, P and U over their scales."""
    return {
        "lines": np.abs(state.contacts - exact.contacts).max() / L,
        "half_width": abs(state.half_width / exact.half_width - 1),
        "force": abs(state.force - exact.force) / exact.scales["force"],
        "energy": abs(state.energy - exact.energy) / exact.scales["energy"],
    }


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_many_contacts_are_those_of_a_higher_degree(case, monkeypatch):
    state = minimise(wavy(case[0], crests=10), DEPTH, branch=case[1])
    assert len(state.contacts) >= 7 and state.method == "fitted"
    assert state.certificate.ok and max(state.error_estimate.values()) <= 1e-8
    monkeypatch.setitem(small._NETS, "line", Line(16))
    exact = minimise(state.scene, state.depth, branch=case[1])
    for name, error in errors(state, exact).items():
        assert error <= 1e-13
        if name in state.error_estimate:
            assert error <= state.error_estimate[name]
    free = state.angle_deficits[~state.pinned]
    alpha = ALPHA if case[0] else 0.0
    assert np.abs(free - alpha).max() <= 1e-11 * ALPHA


FAR = {"fitted": {"branch": "global"}, "finite slopes": {"branch": "adhered"}}
FAR["nodes"] = {"branch": "global", "method": "lattice", "spacing": L / 200}


@pytest.mark.parametrize("w", [0.0, 0.002])
@pytest.mark.parametrize("how", FAR)
def test_contacts_many_decay_lengths_apart_are_single_ones(w, how):
    c = 60 * L
    depth = 0.4 * DELTA0
    slopes = "finite" if how == "finite slopes" else "small"
    both, one, other = (
        minimise(adhesive(body, w=w, slopes=slopes), d, **FAR[how])
        for body, d in (
            (two(c, lift=0.1 * DELTA0), depth),
            (Parabola(0.005).shifted(-c), depth - 0.1 * DELTA0),
            (Parabola(0.003).shifted(c), depth),
        )
    )
    assert np.allclose(both.contacts, [*one.contacts, *other.contacts], rtol=0, atol=1e-10 * L)
    assert both.force == pytest.approx(one.force + other.force, rel=1e-10, abs=0)
    assert both.energy == pytest.approx(one.energy + other.energy, rel=1e-10, abs=0)
    assert np.allclose(
        both.contact_angles, [*one.contact_angles, *other.contact_angles], rtol=1e-10, atol=0
    )
    x = np.linspace(-3 * L, 3 * L, 50)
    assert np.allclose(both.displacement(c + x), other.displacement(c + x), rtol=1e-9, atol=0)
    assert np.allclose(both.pressure(x - c), one.pressure(x - c), rtol=1e-9, atol=0)


@pytest.mark.parametrize(("seed", "depth"), [(29, -0.1), (142, -0.3)])
def test_a_retraction_keeps_what_the_first_touch_has_brought(seed, depth):
    """At first touch the contact spreads, the surface rises and touches a second crest."""
    scene = rough(seed)
    nodes = {"method": "lattice", "spacing": L / 100}
    path = load_path(scene, depths=np.array([0.001, depth]) * DELTA0, **nodes)
    coarse = minimise(scene, depth * DELTA0, **nodes)
    off = np.array(path.at(-1).lines) - coarse.nodes.ravel()
    assert np.abs(off).max() < coarse.spacing / 2  # each line beside its node
    state = minimise(scene, depth * DELTA0)
    assert len(coarse.contacts) == len(state.contacts) == 2
    assert errors(coarse, state)["lines"] <= 1e-3


@pytest.mark.parametrize("seed", [34, 71])
def test_a_lattice_too_coarse_for_the_path_is_not_believed(seed):
    scene = rough(seed)
    depth = np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
    state = minimise(scene, depth)
    fine = minimise(scene, depth, method="lattice", spacing=L / 400)
    assert errors(fine, state)["lines"] <= 1e-4


@pytest.mark.parametrize(("seed", "w"), [(5, 0.002), (16, 0.0)])
def test_corners_hold_lines(seed, w):
    scene = linear(seed, w)
    depth = np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
    state = minimise(scene, depth, branch="global")
    assert state.pinned.any() and len(state.contacts) >= (1 if w else 4)
    corners = np.asarray(scene.indenter.corners)
    assert np.isin(state.contacts[state.pinned], corners).all()
    free = state.angle_deficits[~state.pinned]
    assert np.abs(free - (ALPHA if w else 0.0)).max(initial=0.0) <= 1e-9 * ALPHA
    coarse = minimise(scene, depth, branch="global", method="lattice", spacing=L / 80)
    assert abs(coarse.energy - state.energy) <= 2e-3 * state.scales["energy"]


@pytest.mark.parametrize("options", [{}, {"method": "lattice", "spacing": L / 50}])
def test_finite_slopes_tend_to_small_slopes_in_first_order_of_w(options):
    ratios = np.array([1e-2, 1e-3, 1e-4, 1e-5])
    differences = []
    for ratio in ratios:
        scene = steep(Wedge(0.5 * math.sqrt(2 * ratio)), ratio)
        small, finite = (
            minimise(replace(scene, slopes=s), 0.0, **options) for s in ("small", "finite")
        )
        differences.append([abs(getattr(finite, q) / getattr(small, q) - 1) for q in QUANTITIES])
    for column in np.transpose(differences):
        order = np.polyfit(np.log(ratios), np.log(column), 1)[0]
        assert order == pytest.approx(1.0, abs=0.05)
    assert np.max(differences[-1]) <= ratios[-1]


def test_without_tension_there_is_nothing_to_incline():
    scene = adhesive(Parabola(0.02), gamma1=0.0, w=0.0)
    for method in ({}, {"method": "lattice", "spacing": 1e-6}):
        small = minimise(scene, 1e-3, **method)
        finite = minimise(replace(scene, slopes="finite"), 1e-3, **method)
        assert finite.force == small.force and finite.half_width == small.half_width


def test_a_dip_between_two_samples_of_a_measured_profile_is_seen():
    """A spline through more of its own points is the same profile; its dips lie between samples."""
    rng = np.random.default_rng(7)
    x = np.linspace(-2 * L, 2 * L, 601)
    heights = x**2 / (0.6 * L / ALPHA) + rng.normal(0, ALPHA * (x[1] - x[0]), x.size)
    body = Sampled(x, heights, kind="smooth")
    finer = np.linspace(-2 * L, 2 * L, 2401)
    turns = [np.count_nonzero(np.diff(np.sign(body.slope(at)))) for at in (x, finer)]
    assert turns[0] < turns[1]
    same = Sampled(finer, body.height(finer), kind="smooth")
    one, other = (minimise(adhesive(each), 0.2 * DELTA0) for each in (body, same))
    assert np.abs(one.contacts - other.contacts).max() <= 1e-9 * L
    dense = np.linspace(-2 * L, 2 * L, 200_001)
    clear = one.displacement(dense) - (one.depth - body.height(dense))
    assert clear.min() >= -1e-9 * DELTA0


def test_minima_of_cubics_between_rising_ends():
    """All minima of cubics are found also between places at which both rise."""
    rng = np.random.default_rng(3)
    between = 0
    for _ in range(200):
        x = np.cumsum(rng.uniform(0.1, 1.0, 12))
        v, v1 = rng.normal(size=(2, x.size))
        curve = CubicHermiteSpline(x, v, v1)
        turns = curve.derivative().roots(extrapolate=False)
        turns = turns[curve(turns, 2) > 0]
        lo, hi, place, bend, value, _ = minima(x, v, v1)
        order = np.argsort(place)
        assert np.allclose(place[order], turns, rtol=0, atol=1e-9)
        assert np.allclose(value, curve(place), rtol=0, atol=1e-12)
        assert ((lo <= place) & (place <= hi) & (bend > 0)).all()
        i = np.searchsorted(x, turns)
        between += np.count_nonzero(v1[i - 1] * v1[i] > 0)
    assert between > 100
