"""Segments of a curve: holds, constant depths out of contact, chosen points."""

import math

import numpy as np
import pytest

from studies.scenes.fit import trials
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import (
    Curve,
    Data,
    chosen_points,
    free_parts,
    holds,
    in_motion,
)
from studies.scenes.fit.trials import SCENE

FAST = {"profiles": False, "alternatives": False}
NOISE = 2e-11  # N
TRUTH = {"w": 1e-4, "gamma1": 0.03}


def noisy(depth, seed=1):
    """A curve of SCENE with noise in the force."""
    force = trials.simulated(SCENE, depth, math.inf)
    return Curve(depth, force + NOISE * np.random.default_rng(seed).standard_normal(depth.size))


def held(points=80, relaxation=0.2):
    """A loop that is held at its deepest point, where the force relaxes."""
    way = np.linspace(-60e-9, 60e-9, 150)
    curve = noisy(np.concatenate([way, np.full(points, way[-1]), way[::-1]]))
    force = curve.force.copy()
    force[150 : 150 + points] *= 1 - relaxation * (1 - np.exp(-np.arange(points) / 20))
    return curve._replace(force=force)


def assert_found(found):
    assert found.quality.fits, found
    for name, true in TRUTH.items():
        low, high = found[name].interval
        assert low - (high - low) / 2 < true < high + (high - low) / 2, name


def test_a_hold_is_named_and_left_out():
    curve = held()
    moving, (hold,) = in_motion(curve)
    assert hold.points == 82 and moving.depth.size == curve.depth.size - 82
    found = fit(SCENE, curve, **FAST)
    assert_found(found)
    assert "left out: a hold of 82 points at d = 6e-08 m" in str(found)


@pytest.mark.parametrize("noise", [0.0, 0.2e-9])
def test_a_loop_without_a_hold_has_none(noise):
    way = np.linspace(-60e-9, 60e-9, 400)
    depth = np.concatenate([way, way[::-1]])
    depth = depth + noise * np.random.default_rng(2).standard_normal(depth.size)
    assert holds(Curve(depth, np.zeros(depth.size))) == ()


def test_a_depth_that_is_constant_out_of_contact():
    """An instrument that measures the depth from first touch on: a level, and no slope."""
    depth = np.concatenate([np.zeros(200), np.linspace(0, 60e-9, 200)])
    curve = noisy(depth)
    force = curve.force.copy()
    force[:200] = NOISE * np.random.default_rng(3).standard_normal(200)
    curve = curve._replace(force=force)
    assert Data.of(curve).columns.shape == (400, 1)
    found = fit(SCENE, curve, **FAST)
    assert_found(found)
    assert [one.name for one in found.estimates] == ["w", "gamma1", "offset", "level"]


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_level_at_constant_depth_is_free_in_any_units(unit):
    """The level is a force: the depths in contact say nothing about whether it is flat."""
    force = np.concatenate([np.zeros(200), np.linspace(-0.3, 1.0, 200)]) + 10.0
    force = force + 1e-3 * np.random.default_rng(4).standard_normal(400)
    depth = np.concatenate([np.zeros(200), np.linspace(0, unit, 200)])
    assert 170 <= free_parts(Curve(depth, force)).sum() <= 200


def test_depths_are_chosen_and_left_out():
    """A part of the curve that is spoilt is left out in both ways."""
    way = np.linspace(-60e-9, 60e-9, 150)
    curve = noisy(np.concatenate([way, way[::-1]]))
    spoilt = curve.depth > 40e-9
    curve = curve._replace(force=curve.force + 2e-9 * spoilt)
    assert not fit(SCENE, curve, **FAST).quality.fits
    for chosen in ({"depth_range": (-1e-7, 40e-9)}, {"exclude": [(40e-9, 1e-7)]}):
        found = fit(SCENE, curve, **FAST, **chosen)
        assert_found(found)
        assert f"left out: {spoilt.sum()} points outside of the chosen depths" in str(found)


@pytest.mark.parametrize(
    ("depth_range", "exclude", "message"),
    [
        ((1.0, 0.0), (), "range = .* must be two increasing depths in m"),
        (None, [(0.0, 0.0)], "exclude = .* must be two increasing depths in m"),
        ((2.0, 3.0), (), "leave no point; the depths of the curve are 0.0 to 1.0 m"),
        (None, [(-1.0, 2.0)], "leave no point"),
    ],
)
def test_depths_that_choose_nothing_are_refused(depth_range, exclude, message):
    with pytest.raises(ValueError, match=message):
        chosen_points(np.linspace(0, 1, 5), depth_range, exclude)


DEPTH = np.linspace(-60e-9, 60e-9, 40)
NAN = np.full(40, np.nan)


@pytest.mark.parametrize(
    ("curve", "message"),
    [
        (
            Curve(DEPTH, NAN),
            r"40 of 40 points are not finite \(the first is point 1, depth = -6e-08",
        ),
        (Curve(np.where(DEPTH > 5e-8, np.nan, DEPTH), DEPTH), "4 of 40 points are not finite"),
        (Curve(0 * DEPTH, DEPTH), "the depth is the same at all 40 points"),
        (Curve(DEPTH, 0 * DEPTH + 1.0), "the force is the same at all 40 points"),
        (Curve(DEPTH[:0], DEPTH[:0]), "the depth is the same at all 0 points"),
        (Curve(DEPTH[:2], DEPTH[:2]), "2 points .* are too few for 3 parameters"),
        (Curve(DEPTH[:9], DEPTH), r"shapes \(9,\) and \(40,\)"),
        (Curve(DEPTH, DEPTH, 0.0), "machine_stiffness = 0.0 must be positive"),
    ],
)
def test_what_is_no_curve_is_refused_in_a_sentence(curve, message, capfd):
    with pytest.raises(ValueError, match=f"^curve: .*{message}"):
        fit(SCENE, curve, **FAST)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("part", [slice(0, 90), slice(90, 180)])
def test_one_branch_alone_is_fitted(part):
    """Loading or unloading; the numbers may stand in lists."""
    way = np.linspace(-100e-9, 60e-9, 90)
    curve = noisy(np.concatenate([way, way[::-1]]))
    half = Curve(curve.depth[part].tolist(), curve.force[part].tolist())
    assert_found(fit(SCENE, half, **FAST))
