"""Errors that nodes estimate of rough states, against nodes much closer and the mesh."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from support.example_scenes import DELTA0, L, adhesive, plain, rough

from discretization import load_path, minimise
from discretization.equilibrium import QUANTITIES
from discretization.lattice.state import on_lattice
from energy import Parabola, Profile

CLOSER = 9.3  # how much closer nodes are whose error, 1/86, is next to nothing
TIMES = 3.0  # of its estimate that an error may be


def rough_state(seed):
    """A self-affine profile on a parabola, and a depth at which it has several contacts or one.

    k = γ₁ = l = 1; and its shortest wave.
    """
    rng = np.random.default_rng([5454, seed])
    w = 0.02 * 10 ** rng.uniform(-0.7, 0.7)
    scale = math.sqrt(2 * w)
    shortest = 10 ** rng.uniform(-0.7, 0.3)
    length = shortest * rng.uniform(8, 24)
    q = 2 * math.pi / length * np.arange(2, int(length / shortest) + 1)
    height = q**-1.3 * rng.uniform(0.5, 1.0, q.size)
    phase = rng.uniform(0, 2 * math.pi, q.size)
    rms = scale * 10 ** rng.uniform(-0.3, 0.7)
    height *= rms / math.sqrt(np.sum(height**2) / 2)
    bowl = (scale * rng.uniform(0.2, 1) + 1.5 * rms) / (length / 2) ** 2
    x = np.linspace(-length, length, int(48 * length / shortest) | 1)
    waves = height[:, None] * np.cos(q[:, None] * x + phase[:, None])
    f = CubicSpline(x, bowl * x**2 + waves.sum(axis=0))
    slope = f.derivative()
    body = Profile(
        lambda t: f(np.asarray(t, float)), lambda t: slope(np.asarray(t, float)), (-length, length)
    )
    depth = float(f(x).min()) + max(scale, rms) * rng.uniform(-0.1, 3)
    return plain(body, w=w), depth, shortest


def errors_over_estimates(state, true):
    """Largest error of a, P and U of a state over its estimate."""
    scales = {"half_width": state.half_width or state.spacing, **state.scales}
    return max(
        abs(getattr(state, name) - getattr(true, name)) / scales[name] / state.error_estimate[name]
        for name in QUANTITIES
    )


def told(seeds, factor, truth):
    """How many rough states with several contacts there are, and how many have a number.

    factor: of nodes l/20 and 1/40 of the shortest wave apart. No error is beyond TIMES its number.
    """
    several = known = 0
    for seed in seeds:
        scene, depth, shortest = rough_state(seed)
        spacing = factor * min(1 / 20, shortest / 40)
        state = on_lattice(scene, depth, spacing)
        if len(state.contacts) < 2:
            continue
        several += 1
        if math.isfinite(state.error_estimate["energy"]):
            known += 1
            assert errors_over_estimates(state, truth(scene, depth, spacing)) <= TIMES, seed
    return several, known


def on_closer_nodes(scene, depth, spacing):
    return on_lattice(scene, depth, spacing / CLOSER)


def on_the_mesh(scene, depth, spacing):
    return minimise(scene, depth)


@pytest.mark.parametrize(
    ("factor", "truth", "seeds"),
    [
        (1.0, on_closer_nodes, range(10)),
        (3.0, on_closer_nodes, range(2000, 2012)),
        (4.0, on_closer_nodes, range(3000, 3012)),
        (2.0, on_the_mesh, range(4000, 4004)),
    ],
)
def test_most_rough_states_know_their_errors(factor, truth, seeds):
    several, known = told(seeds, factor, truth)
    assert several >= 2
    assert known >= 0.75 * several


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "first"), [(1.0, 0), (3.0, 2000)])
def test_of_many_rough_states_none_is_worse_than_it_says(factor, first):
    several, known = told(range(first, first + 120), factor, on_closer_nodes)
    assert several >= 40
    assert known >= 0.75 * several


@pytest.mark.parametrize("seed", [2048, 3028, 3047, 3050])
def test_a_contact_that_one_lattice_has_alone_is_in_the_estimate(seed):
    """Nodes four times closer have a contact more, or less: a number, not below what it adds."""
    scene, depth, shortest = rough_state(seed)
    spacing = (3.0 if seed < 3000 else 4.0) * min(1 / 20, shortest / 40)
    state = on_lattice(scene, depth, spacing)
    closer = on_lattice(scene, depth, spacing / 4)
    assert len(closer.contacts) != len(state.contacts)
    known = state.uncertainty
    for name in QUANTITIES:
        assert abs(getattr(closer, name) - getattr(state, name)) <= known[name] < math.inf
    assert errors_over_estimates(state, on_closer_nodes(scene, depth, spacing)) <= TIMES


def test_estimate_with_a_contact_coarse_nodes_miss():
    """A contact that coarser lattices miss too is in the estimate."""
    scene = adhesive(rough(9).indenter)
    state, true = (on_lattice(scene, 1.2 * DELTA0, L / nodes) for nodes in (5, 200))
    assert len(state.contacts) < len(true.contacts)
    assert max(state.error_estimate.values()) > 0.5
    assert errors_over_estimates(state, true) <= TIMES


def test_print_says_what_errors_are_relative_to():
    scene = adhesive(Parabola(0.02))
    nodes = {"method": "lattice", "spacing": L / 40}
    state = minimise(scene, 0.3 * DELTA0, **nodes)
    error = state.error_estimate
    scales = state.scales
    said = " ".join(str(state).split())
    assert f"relative errors are {error['half_width']:.1e} of a" in said
    for name in ("force", "energy"):
        assert f"{error[name]:.1e} of {scales[name]:.4g}" in said
    assert "the sums of the absolute values of the terms of P and of U" in said
    assert "relative" not in str(minimise(scene, 0.3 * DELTA0))
    path = load_path(scene, depths=[0.0, 1e-3], **nodes)
    assert "relative to the sums of the absolute terms of P and of U" in str(path)
    assert "relative" not in str(load_path(scene, depths=[0.0, 1e-3]))
