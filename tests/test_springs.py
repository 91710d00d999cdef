"""γ₁ = 0 with several contacts: every spring by itself, by brute force."""

import math
from dataclasses import replace

import numpy as np
import pytest
from lattices import of_heights
from scenes import adhesive

from discretization import Lattice, minimise
from discretization.lattice import lowest
from discretization.lattice.judge import judge
from discretization.lattice.totals import totals
from energy import Parabola, Profile, Sampled


def rough_scene(seed, *, w=0.002, n=201):
    """A random profile on nodes 1 apart that ends high, and its heights."""
    rng = np.random.default_rng(seed)
    x = np.arange(n) - n // 2 + 0.0
    f = np.convolve(rng.normal(size=n + 6), np.ones(7) / 7, "valid") + (x / (n / 3)) ** 4
    f = np.round(f - f.min(), 3) * 0.02
    return adhesive(Sampled(x, f), gamma1=0.0, w=w, k=130.0), f


def attached(scene, f, depth, branch):
    """The definition, node by node: the path is walked depth by depth."""
    lift = scene.critical_separation
    if branch == "global":
        return depth - f >= -lift
    on = np.zeros(f.size, bool)
    for d in [f.min(), depth]:  # touch, then move monotonically
        on = (on & (d - f >= -lift)) | (d - f >= 0)
    return on


@pytest.mark.parametrize("branch", ["adhered", "global"])
def test_every_spring_alone(branch):
    several = apart = 0
    for seed in range(12):
        scene, f = rough_scene(seed, w=[0.002, 1e-5, 0.0][seed % 3])
        lift = scene.critical_separation
        for depth in (-1.2 * lift - 1e-9, -0.7 * lift, 0.0, 0.003, 0.009):
            state = minimise(scene, depth, method="lattice", spacing=1.0, branch=branch)
            on = attached(scene, f, depth, branch)
            x = np.arange(f.size) - f.size // 2
            inside = np.zeros(f.size, bool)
            for left, right in state.nodes:
                inside |= (x >= left) & (x <= right)
            assert np.array_equal(inside, on), (seed, depth)
            g, k = depth - f[on], scene.stiffness
            assert state.certificate.ok
            several += len(state.contacts) > 2
            apart += not on.any()
            assert (state.label == "detached") == (not on.any())
            if on.any():
                half = np.sum(k * g**2 / 2 - scene.work_of_adhesion)
                edges = len(state.nodes) * (k * (lift + abs(depth)) ** 2 + scene.work_of_adhesion)
                assert abs(state.energy - half) <= edges
                assert abs(state.force - k * g.sum()) <= len(state.nodes) * k * (
                    lift + abs(depth) + 1e-3
                )
                # contacts reach half a node beyond their last one, and never meet
                assert (state.contacts[1:, 0] >= state.contacts[:-1, 1]).all()
    assert several >= 12
    assert apart >= 4


def test_lines_of_a_smooth_profile_are_found_between_the_nodes():
    def height(x):
        return 0.01 * (1 - np.cos(x)) + 1e-4 * x * x

    profile = Profile(height, lambda x: 0.01 * np.sin(x) + 2e-4 * x, extent=(-20.0, 20.0))
    scene = adhesive(profile, gamma1=0.0)
    lift = scene.critical_separation
    depth = 0.008
    x = np.linspace(-20, 20, 4_000_001)
    inside = height(x) <= depth + lift
    edges = np.flatnonzero(np.diff(inside.astype(int)))
    exact = (x[edges] + x[edges + 1]).reshape(-1, 2) / 2
    state = minimise(scene, depth, method="lattice", spacing=0.01, branch="global")
    assert state.contacts.shape == exact.shape == (3, 2)
    assert np.abs(state.contacts - exact).max() <= 2e-5
    u = depth - height(x[inside])
    energy = np.sum(scene.stiffness * u**2 / 2 - scene.work_of_adhesion) * 1e-5
    assert abs(state.energy - energy) <= 1e-4 * abs(energy)
    assert abs(state.force - scene.stiffness * u.sum() * 1e-5) <= 1e-4 * scene.stiffness * (
        np.abs(u).sum() * 1e-5
    )
    assert np.isfinite(state.displacement(x[::1000])).all()
    assert str(state)


def test_the_window_is_limited(monkeypatch):
    monkeypatch.setattr(lowest, "MOST", 1000)
    scene, _ = rough_scene(1, n=5001)
    with pytest.raises(ValueError, match=r"spacing = 1\.0 puts more than 1000 nodes"):
        minimise(scene, 0.005, method="lattice", spacing=1.0, branch="global")


def test_a_convex_indenter_agrees_with_one_that_does_not_promise_it():
    convex = adhesive(Parabola(0.4), gamma1=0.0)
    R = 0.4
    same = replace(
        convex, indenter=Profile(lambda x: x * x / (2 * R), lambda x: x / R, extent=(-0.2, 0.2))
    )
    lift = convex.critical_separation
    for depth, branch in ((3e-3, "adhered"), (3e-3, "global"), (-0.5 * lift, "global")):
        one, two = (
            minimise(s, depth, method="lattice", spacing=1e-4, branch=branch)
            for s in (convex, same)
        )
        assert math.isclose(one.half_width, two.half_width, rel_tol=1e-13)
        assert math.isclose(one.force, two.force, rel_tol=1e-13)
        assert math.isclose(one.energy, two.energy, rel_tol=1e-13)


@pytest.mark.parametrize(("share", "free"), [(0.9, {"neighbours"}), (1.1, set())])
def test_a_spring_left_alone_must_not_gain_by_attaching(share, free):
    """Nor one left attached by letting go, nor be pulled by more than it holds."""
    lattice = Lattice(1.0, 0.0, 130.0, 0.0, 0.002)
    g = np.array([0.01, -share * lattice.critical_gap])
    for ends, failures in (
        ([[0, 0]], free),
        ([[0, 1]], {"opening", "neighbours"} if share > 1 else set()),
    ):
        contacts = of_heights(lattice, g, ends)
        assert set(judge(contacts, totals(contacts), lowest=True).failures) == failures
