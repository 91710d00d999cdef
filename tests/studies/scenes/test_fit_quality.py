"""Fits that tell when the model does not fit, bounds, two works of adhesion, several contacts."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.measured_curves import LIFT, SCENE, measured

from discretization import minimise
from energy import FlatPunch, Scene, SurfaceEnergies
from studies.scenes.fit import estimate as fit_estimate
from studies.scenes.fit import search, trials
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve, Data, loading, turning_points
from studies.scenes.fit.model import DEFAULT, Model
from studies.scenes.fit.search import HOPELESS, profiled
from studies.scenes.fit.verdict import (
    STRONG,
    ZERO,
    Alternative,
    Quality,
    quality_of,
    runs,
    unsuited,
)

FAST = {"profiles": False, "alternatives": False}


@pytest.mark.slow
def test_the_offset_of_the_depth_is_fitted_by_default():
    assert DEFAULT == ("w", "gamma1", "offset")
    curve = measured(SCENE, [-1.13, 1.1, -1.13], 0.005, seed=1)  # touches between two points
    found = fit(SCENE, Curve(curve.depth + 0.5 * LIFT, curve.force), **FAST)
    w = found["w"]
    offset = found["offset"]
    assert w.value == pytest.approx(SCENE.work_of_adhesion, rel=0.03)
    assert offset.interval[0] < 0.5 * LIFT < offset.interval[1]
    assert found.quality.fits and 0.6 < found.quality.times < 1.4


@pytest.mark.slow
def test_a_model_that_does_not_fit_has_no_intervals():
    curve = measured(SCENE, [-1.1, 1.1, -1.1], 0.01)
    found = fit(SCENE, Curve(curve.depth, -curve.force), alternatives=False)
    assert not found.quality.fits
    assert all(e.interval is None and e.profile is None for e in found.estimates)
    said = str(found)
    assert re.search(r"WARNING: residual is \d+\.?\d* times the noise: check sign, zero", said)
    assert "withheld" in said and "nan" not in said
    good = fit(SCENE, curve, **FAST)
    assert "nan" not in str(good) and "not computed" in str(good)
    assert all("VIOLATED" in text for text in good.warnings)


def test_the_noise_of_few_points_is_not_known():
    clean = measured(SCENE, [0.2, 1.1], steps=6)
    found = fit(SCENE, clean, ("w",), **FAST)
    assert "the noise cannot be estimated from so few points" in found.warnings[0]
    assert "nan" not in str(found)


@pytest.mark.slow
def test_an_estimate_on_a_bound_is_called_so():
    punch = Scene(SCENE.layer, SCENE.surfaces, FlatPunch(1e-4))
    curve = measured(punch, [0.2, 1.1, 0.2], 0.01)
    low = Curve(curve.depth, curve.force - 2 * punch.gamma1 * curve.depth[0] / 1e-5)
    found = fit(punch, low, ("gamma1",), **FAST)
    (gamma1,) = found.estimates
    assert gamma1.bound and gamma1.interval is None and not gamma1.identifiable
    assert gamma1.value == pytest.approx(1e-4 * punch.gamma1, rel=1e-3)
    assert "gamma1 = 7e-06 J/m² is the bound of the search, no estimate" in str(found)
    assert "bound of the search J/m²" in str(found)


@pytest.mark.slow
def test_a_loop_has_two_works_of_adhesion():
    names = ("w", "opening", "offset")
    w = SCENE.work_of_adhesion
    true, start = (
        replace(SCENE, opening=SurfaceEnergies.from_work(SCENE.gamma1, times * w))
        for times in (3.0, 1.8)
    )
    curve = measured(true, [-1.9, 1.1, -1.9], 0.01)
    assert not fit(SCENE, curve, ("w", "offset"), **FAST).quality.fits
    found = fit(start, curve, names, **FAST)
    assert found.quality.fits, found
    for estimate, value in zip(found.estimates, (2e-6, 6e-6, 0.0), strict=False):
        assert abs(estimate.value - value) < np.ptp(estimate.interval)  # four deviations
    assert np.ptp(found.estimates[1].interval) < 0.3 * 6e-6
    none = fit(SCENE, measured(SCENE, [-1.1, 1.1, -1.1], 0.01), names, **FAST)
    closing, opening, *_ = none.estimates
    assert opening.interval is None if opening.bound else opening.value < 1.05 * closing.value


def test_turning_points_are_found_through_noise():
    way = np.concatenate(
        [np.linspace(0, 2, 21), np.linspace(2, -1, 31)[1:], np.linspace(-1, 3, 10)[1:]]
    )
    assert turning_points(way) == (20, 50)
    assert turning_points(1e-9 * way) == (20, 50)
    assert turning_points(way[:20]) == () and turning_points(np.ones(4)) == ()
    noisy = np.concatenate([np.linspace(0, 1, 400), np.linspace(1, 0, 400)])
    noisy += 0.004 * np.random.default_rng(0).standard_normal(800)  # more than a step
    (turn,) = turning_points(noisy)
    assert abs(turn - 400) < 15
    assert loading(way).tolist() == [True] * 21 + [False] * 30 + [True] * 9


def test_runs_of_known_signs():
    assert runs(np.array([1.0, -1.0] * 8)) == pytest.approx((16 - 9) / math.sqrt(8 * 7 / 15))
    assert runs(np.repeat([1.0, -1.0], 8)) == pytest.approx((2 - 9) / math.sqrt(8 * 7 / 15))
    assert runs(np.ones(9)) == -3.0
    rng = np.random.default_rng(2)
    many = np.array([runs(rng.standard_normal(60)) for _ in range(400)])
    assert abs(many.mean()) < 0.2 and many.std() == pytest.approx(1, abs=0.1)


def test_quality_of_known_residuals():
    flat = np.array([1.0, -1.0] * 8)
    none = np.empty(0)
    assert quality_of(flat, none, none, 16, 0.5).times == 2.0
    assert quality_of(flat, np.array([4.0, 4.0]), none, 12, 1.0).times == 2.0
    assert quality_of(flat, none, np.full(25, 0.5), 16, 1.0).zero == 2.5
    assert math.isnan(quality_of(flat, none, none, 16, 0.0).times)
    assert not Quality(1.0, -4.0).fits and Quality(1.0, -3.0, 4.0).fits
    assert Quality(0.1, -9.0).fits and not Quality(2.1, 0.0).fits
    assert not Quality(1.0, 0.0, -5.0).fits
    assert "keeps its sign over many points" in Quality(1.2, -5.0).message
    assert "the force out of contact is -5 standard errors off" in Quality(1.0, 0.0, -5.0).message


@pytest.mark.slow
def test_a_small_force_out_of_contact_is_fitted_or_called():
    short, long = (measured(SCENE, [-far, 1.1, -far], 0.02) for far in (1.1, 2.5))
    level = 0.05 * np.abs(short.force).max()  # too small to be taken for contact
    kept = short.depth > -0.3 * LIFT  # too few free points for a line of their own
    kept[short.force.size // 2 :] = True
    found = fit(SCENE, Curve(short.depth[kept], short.force[kept] + level), **FAST)
    assert found.model.names == DEFAULT
    assert found.quality.times < 2 and found.quality.zero > ZERO
    assert "check zero: the force out of contact" in found.warnings[0]
    assert found.estimates[0].interval is None
    found = fit(SCENE, Curve(long.depth, long.force + level), **FAST)
    low, high = found["level"].interval
    assert found.quality.fits and low < level < high and 5 * level > high - low
    assert found["w"].value == pytest.approx(2e-6, rel=0.1)


def test_the_way_out_alone_is_a_contact():
    curve = measured(SCENE, [1.1, -1.1])
    data = Data.of(curve)
    (contact,) = data.contacts
    assert [leg.points.size for leg in contact.legs] == [0, data.used.sum()]
    assert contact.legs[1].turn == curve.depth[0] and data.used.sum() > 30
    off = Model.of(SCENE, ("w",), data).residuals(np.zeros(1))
    assert np.abs(off[: data.used.sum()]).max() < 1e-6 * np.abs(curve.force).max()


@pytest.mark.parametrize(("times", "near"), [(0.9, False), (1.1, True)])
def test_minimum_beside_the_start(times, near, monkeypatch):
    """The minimum beside the start is taken only if the other is hopeless."""
    model = Model.of(SCENE, ("w",), Data.of(measured(SCENE, [-1.1, 1.1, -1.1], 0.01)))
    noise = len(model.data.lines) * model.data.sigma**2

    def followed(model, start, ftol):  # the lower minimum is beside the start
        lead = model.blunt > straight or start.any()
        squares = noise * ((times * HOPELESS) ** 2 if lead else 0.01)
        return SimpleNamespace(x=start + 0.1, squares=squares)

    straight = model.blunt
    monkeypatch.setattr(search, "followed", followed)
    assert (search.sought(model).squares < noise) == near


def test_every_contact_starts_from_a_touch():
    curve = measured(SCENE, [-0.3, 1.0, -1.2, 0.7, -1.2])
    shift = 80
    forces = []  # where it is farthest out
    second = Curve(curve.depth[shift:], curve.force[shift:])
    both, alone = (Model.of(SCENE, ("w", "offset"), Data.of(c)) for c in (curve, second))
    assert (len(both.data.contacts), len(alone.data.contacts)) == (2, 1)
    for model in (both, alone):  # lets go too early, touches too late
        at = [model.coordinate("w", 0.8 * 2e-6), model.coordinate("offset", 0.1 * LIFT)]
        force, _ = replace(model, blunt=0.0).forces(np.array(at))
        forces.append(force[(model is both and shift) or 0 :])
    assert np.abs(forces[0] - forces[1]).max() < 1e-5 * np.abs(forces[0]).max()
    assert np.abs(forces[0]).max() > 0


@pytest.mark.parametrize(
    ("name", "reach", "profile", "bound", "identifiable"),
    [
        ("w", 0.9, 0.9, False, True),
        ("w", 1.1, 0.9, False, False),  # wider than a factor e
        ("w", 0.9, 1.1, False, False),
        ("w", 0.9, math.inf, False, False),
        ("w", math.inf, 0.9, False, False),
        ("w", 0.9, 0.9, True, False),
        ("offset", 1.1, 1.1, False, True),  # an offset may have any size
        ("offset", 1.1, math.inf, False, False),
        ("offset", math.inf, 1.1, False, False),
        ("offset", 1.1, 1.1, True, False),
    ],
)
def test_identifiable_parameters(name, reach, profile, bound, identifiable, monkeypatch):
    """A parameter is identifiable with both intervals short and no bound."""
    end = lambda model, best, i, reach: math.copysign(profile, reach)  # noqa: E731
    monkeypatch.setattr(fit_estimate, "_profile_end", end)
    model = SimpleNamespace(  # as much of a model and of its minimum as an estimate looks at
        names=(name,),
        x=np.zeros(1),
        value=lambda name, coordinate: math.exp(coordinate),
        on_bound=lambda x, i: bound,
    )
    found = fit_estimate._estimate(model, model, 0, reach, True, True)
    assert found.identifiable == identifiable


def test_springs_thicker_than_every_contact_are_doubted():
    def said(h, depths=(0.0, 20e-9, 60e-9), **given):
        layer = replace(trials.SCENE.layer, h=h, **given)
        scene = replace(trials.SCENE, layer=layer)
        return unsuited([minimise(scene, depth) for depth in depths])

    assert said(trials.SCENE.layer.h) == said(20e-6, response="layer") == unsuited([]) == ""
    assert "along the whole curve, and springs need h much less than a" in said(20e-6)
    assert said(1e-6) == "" != said(1e-6, (0.0,))  # where the contact is narrow


@pytest.mark.parametrize(
    ("kind", "number"),
    [("drift", 158), pytest.param("drift", 49, marks=pytest.mark.slow), ("rigid", 1)],
)
def test_a_zero_of_the_depth_that_moves_is_called_and_no_other(kind, number):
    """By less than two nanometres, which w and γ₁ would make up for; nothing where it rests."""
    curve, start, _ = trials.case(trials.Parameters(), kind, number)
    found = fit(start, curve, profiles=False, alternatives=False)
    moves = kind == "drift"
    assert found.quality.fits and ("the zero of the depth" in found.unsuited) == moves
    assert not moves or 1e-9 < float(found.unsuited.split(" by ")[1].split()[0]) < 2e-9


def test_a_comparison_says_what_it_means():
    needless = Alternative("gamma1", 3.0, {"w": 1e-4}, {"w": 0.0})
    assert needless.preferred and needless.doubtful
    said = "gamma1 is not needed: without surface tension the fit is at least as good (ΔBIC = -3)"
    assert said in needless.message
    needed = replace(needless, better=-20.0)
    assert not needed.doubtful
    assert "gamma1 is needed: " in needed.message
    better = Alternative("layer", 2 * STRONG, {"w": 2e-4}, {"w": -0.5})
    assert better.doubtful
    said = "the layer's own response fits better (ΔBIC = -12), with w = 0.0002; this fit differs"
    assert said in better.message
    alike = replace(better, better=0.0)
    assert alike.doubtful and not alike.preferred
    assert "do not decide between them" in alike.message
    assert not replace(alike, off={"w": 0.01}).doubtful
    worse = replace(better, better=-2 * STRONG)
    assert not worse.doubtful
    said = "springs fit at least as well as the layer's own response (ΔBIC = 12)"
    assert said in worse.message


@pytest.mark.slow
def test_a_profile_is_the_minimum_of_the_others():
    """Where γ₁ is hardly known, steps with the Jacobian of the fit lead far away."""
    curve, start, truth = trials.case(trials.Parameters(), "hold", 47)
    found = fit(start, curve, profiles=False, alternatives=False)
    at = np.array([found.model.coordinate(name, value) for name, value in truth.items()])
    residuals = found.model.residuals(at)
    most = float(residuals @ residuals) / found.best.squares
    for i, coordinate in enumerate(at.tolist()):
        assert profiled(found.model, found.best, i, coordinate) <= most * (1 + 1e-3)
