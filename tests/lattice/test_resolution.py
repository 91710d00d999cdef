"""Nodes that are too far apart for the surface or the contact say so, wherever they are asked."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scenes import plain

from discretization import AccuracyWarning, load_path, minimise
from energy import ElasticLayer, FlatPunch, Parabola, Plane, Profile, Scene, SurfaceEnergies

SCENE = Scene(ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(0.07, 6e-5), Parabola(0.02))
LENGTH = SCENE.elastocapillary_length
LATTICE = {"method": "lattice"}


def told(state):
    """The names of the violated assumptions on nodes."""
    return {one.name for one in state.resolution if not one.holds}


@pytest.mark.parametrize("branch", ["adhered", "global"])
@pytest.mark.parametrize("spacing", [1.01, 10, 1e3, 1e6])
def test_nodes_further_apart_than_the_decay_length_are_warned_of(spacing, branch):
    with pytest.warns(AccuracyWarning, match=r"too far apart: Δx/l = .*give a smaller spacing"):
        state = minimise(SCENE, 3e-7, **LATTICE, spacing=spacing * LENGTH, branch=branch)
    assert "Δx/l" in told(state) and any("Δx/l" in warning for warning in state.warnings)
    assert ("Δx/a" in told(state)) == (spacing >= 10)
    assert "Δx/l" in str(state) and minimise(SCENE, 3e-7).resolution == ()


def test_paths_warn_before_they_are_followed():
    with pytest.warns(AccuracyWarning, match="too far apart"):
        load_path(SCENE, depths=[0.0, 3e-7], **LATTICE, spacing=2 * LENGTH)


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_inside_the_limits_the_half_width_is_known_to_a_tenth(geometry):
    """Random parabolas, with tension against adhesion and curvature over decades."""
    rng, seen, sparse = np.random.default_rng(4), 0, 0
    for _ in range(40):
        w, R = 10 ** rng.uniform(-4, -1), 10 ** rng.uniform(0, 4)
        scene = replace(plain(Parabola(R), w=w), geometry=geometry)
        depth = scene.critical_separation * rng.uniform(-0.5, 3)
        true, spacing = minimise(scene, depth), scene.elastocapillary_length * rng.uniform(0.1, 1)
        state = minimise(scene, depth, **LATTICE, spacing=spacing)
        if state.contacts.size and not told(state):
            assert state.half_width == pytest.approx(true.half_width, rel=0.1)
            seen += 1
        sparse += "Δx/a" in told(state)
    assert seen > 20 and sparse > 3


def rippled(wave, steep, phase):
    """A parabola with waves of this length whose slope is this steep."""
    return Profile(
        lambda x: x**2 / 40 + steep * wave * np.cos(x / wave + phase),
        lambda x: x / 20 - steep * np.sin(x / wave + phase),
        (-3.0, 3.0),
    )


@pytest.mark.filterwarnings("always::discretization.AccuracyWarning")
def test_ripples_between_nodes_are_resolved_or_not_at_all():
    """Lines hold at ripples: what is told without a warning is no less than the error."""
    rng, told_of = np.random.default_rng(9), 0
    for _ in range(60):
        wave, steep = rng.uniform(0.5, 3) / 20, 0.02 * 10 ** rng.uniform(-1.5, 0.3)
        scene = plain(rippled(wave, steep, rng.uniform(0, 6)), w=2e-4)
        depth = scene.critical_separation * rng.uniform(-0.3, 2)
        with warnings.catch_warnings(record=True) as said:
            state = minimise(scene, depth, **LATTICE, spacing=1 / 20)
            known = state.error_estimate["half_width"]
        if state.contacts.size and not said and np.isfinite(known):
            true, told_of = minimise(scene, depth), told_of + 1
            assert len(true.contacts) == len(state.contacts), (wave, steep)
            assert abs(state.half_width / true.half_width - 1) <= known, (wave, steep)
    assert told_of > 20


def test_where_nodes_lose_nothing_nothing_is_said():
    assert minimise(plain(Plane()), 0.1, **LATTICE, spacing=50.0).resolution == ()
    punch = minimise(plain(FlatPunch(1.0)), 0.1, **LATTICE, spacing=0.7)  # held at both edges
    assert not told(punch)
    springs = minimise(plain(Parabola(10.0), gamma1=0.0), 0.1, **LATTICE, spacing=0.01)
    assert [one.name for one in springs.resolution] == ["Δx/a"] and not told(springs)
