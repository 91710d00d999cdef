"""Where a profile without adhesion would pull, in closed form for a wave of f = A (1 - cos qx)."""

import math
from dataclasses import replace

import numpy as np
import pytest

from discretization import minimise
from discretization.fitted.tension import pull
from discretization.profile import resolve
from energy import ElasticLayer, FlatPunch, Profile, Scene, SurfaceEnergies

L, Q, DEPTH = 0.5, 2 * math.pi, 0.2
STEEP = 1 + (L * Q) ** 2  # the pull over k is A - d - A STEEP cos qx


def scene(A, slopes="small"):
    """A wave of this amplitude and length 1, over two periods."""
    profile = Profile(
        lambda x: A * (1 - np.cos(Q * np.asarray(x, float))),
        lambda x: A * Q * np.sin(Q * np.asarray(x, float)),
        extent=(-1.0, 1.0),
    )
    return Scene(ElasticLayer(1.0, 0.0, 1.0), SurfaceEnergies.from_work(L**2, 0.0), profile, slopes)


def pulled(A, left, right, slopes="small"):
    """The largest pull between two positions, and where the profile pulls."""
    problem = scene(A, slopes)
    return pull(problem, resolve(problem, DEPTH), left, right, DEPTH)


@pytest.mark.parametrize("excess", [1e-6, 1e-3, 0.1])
def test_a_pull_over_less_than_a_sample_is_seen(excess):
    A = (DEPTH + excess) / (1 + STEEP)  # at x = ±1/2 the pull is A (1 + STEEP) - d
    found = pulled(A, 0.9, 0.1)
    assert found.worst == pytest.approx(excess, rel=0.02, abs=1e-9)
    edge = math.acos((1 - DEPTH / A) / STEEP) / Q
    wide = 2 * (0.5 - edge)
    assert found.ends == pytest.approx((edge, 1 - edge), rel=0, abs=max(0.2 * wide, 1e-4))


def test_what_presses_does_not_pull():
    A = (DEPTH - 1e-9) / (1 + STEEP)
    for found in (pulled(A, -0.9, 0.9), pulled(0.1, -0.02, 0.02), pulled(0.1, 0.5, 0.5)):
        assert found.worst == 0
        assert np.isnan(found.ends).all()


def test_inclined_surfaces_bend_less():
    A, x, problem = 0.15, 0.3, scene(0.15, "finite")
    f, f1, f2 = A * (1 - math.cos(Q * x)), A * Q * math.sin(Q * x), A * Q**2 * math.cos(Q * x)
    exact = f - DEPTH - L**2 * f2 / (1 + f1 * f1) ** 1.5
    found = pull(problem, resolve(problem, DEPTH), x - 1e-5, x + 1e-5, DEPTH).worst
    assert found == pytest.approx(exact, rel=1e-3)
    assert found < 0.8 * pulled(A, x - 1e-5, x + 1e-5).worst


def test_around_an_axis_both_curvatures_count():
    A, r, problem = 0.1, 0.3, replace(scene(0.1), geometry="axisymmetric")
    mean = A * Q**2 * math.cos(Q * r) + A * Q * math.sin(Q * r) / r
    exact = A * (1 - math.cos(Q * r)) - DEPTH - L**2 * mean
    found = [pull(problem, resolve(problem, d), r - 1e-5, r + 1e-5, d).worst for d in (-1.0, -2.0)]
    assert found == pytest.approx([exact + DEPTH + 1, exact + DEPTH + 2], rel=1e-3)


@pytest.mark.parametrize("excess", [1e-5, 1e-3])
def test_a_gap_opens_however_narrow(excess):
    """Around what pulls, √3 times as wide, where the pull is a parabola."""
    A = (DEPTH + excess) / (1 + STEEP)
    problem = scene(A)
    state = minimise(replace(problem, indenter=problem.indenter + FlatPunch(0.9)), DEPTH)
    edge = math.acos((1 - DEPTH / A) / STEEP) / Q
    assert len(state.contacts) == 3
    gaps = state.contacts[1:, 0] - state.contacts[:-1, 1]
    assert gaps == pytest.approx(math.sqrt(3) * 2 * (0.5 - edge), rel=0.02)
