"""Fits of measured curves: synthetic data, intervals, what is not identifiable, files."""

import math
from dataclasses import replace

import numpy as np
import pytest
from support.example_scenes import rescaled
from support.measured_curves import SCENE, measured

from discretization import load_path
from energy import ElasticLayer, FlatPunch, Scene, SurfaceEnergies
from studies.scenes.fit import study
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve, Data, noise
from studies.scenes.fit.model import Model, astray, parameters_of
from studies.scenes.fit.search import conditioning, spreads

ENERGIES = ("w", "gamma1")
FAST = {"profiles": False, "alternatives": False}
WRONG = astray(SCENE, ENERGIES, 1.5)


def curve_of(scene, steps=12, share=0.0, seed=5):
    """A synthetic curve with noise of a share of its largest force."""
    return measured(scene, [-1.1, 1.1, -1.1], share, steps, seed)


@pytest.mark.slow
def test_an_incompressible_layer_has_no_stiffness_to_fit():
    layer = ElasticLayer(1.0, 0.5, 1.0, response="layer")
    with pytest.raises(ValueError, match=r"nu = 0\.5: .* Poisson's ratio, such as 0\.49"):
        parameters_of(replace(SCENE, layer=layer))


@pytest.mark.slow
def test_the_intervals_hold_the_truth():
    found = [fit(WRONG, curve_of(SCENE, 14, 0.01, seed), ENERGIES, **FAST) for seed in range(5)]
    for i, name in enumerate(ENERGIES):
        true = parameters_of(SCENE)[name]
        values = np.array([one[name].value for one in found])
        assert sum(one[name].interval[0] < true < one[name].interval[1] for one in found) >= 4
        assert sum(one.inside_profile(i, true) for one in found) >= 4
        spread = values.std(ddof=1) / true
        assert abs(values.mean() / true - 1) < 3 * spread / math.sqrt(len(values))
        assert 0 < spread < {"w": 0.01, "gamma1": 0.05}[name]
        widths = [np.ptp(one[name].interval) / true for one in found]
        assert 1.5 < np.mean(widths) / spread < 10  # 2 · 2.03 in the mean of many


@pytest.mark.slow
def test_profile_and_linearised_interval_agree():
    """The profile agrees with the linearised interval where the model is nearly linear."""
    found = fit(SCENE, curve_of(SCENE, share=0.005), ENERGIES, alternatives=False)
    for i, estimate in enumerate(found.estimates):
        assert estimate.identifiable
        width = np.ptp(estimate.interval)
        assert estimate.profile == pytest.approx(estimate.interval, abs=0.05 * width)
        inside, outside = (estimate.value + share * width for share in (0.4, 0.6))
        assert found.inside_profile(i, inside) and not found.inside_profile(i, outside)
    assert all("VIOLATED" in text for text in found.warnings)  # of a small contact
    assert "touch, detachment used" in str(found)


@pytest.mark.slow
def test_the_fit_does_not_depend_on_units():
    depth, force, *_ = curve_of(SCENE, share=0.01)
    here = fit(WRONG, Curve(depth, force), **FAST)
    # lengths and P per length 2¹⁰ times as large: by a power of two, which rounds nothing
    there = fit(rescaled(WRONG, 1024.0, 1.0), Curve(1024.0 * depth, 1024.0 * force), **FAST)
    for a, b in zip(here.estimates, there.estimates, strict=True):
        assert b.value == pytest.approx(1024.0 * a.value, rel=1e-6, abs=0)


PUNCH = Scene(
    ElasticLayer(50.0, 0.45, 5e-6), SurfaceEnergies.from_work(0.07, 2e-6), FlatPunch(1e-4)
)


@pytest.mark.slow
def test_a_pinned_line_does_not_feel_w_without_the_letting_go():
    depth, force, *_ = curve_of(PUNCH, share=0.005)
    pressed = depth > -0.5 * PUNCH.critical_separation  # cut before the letting go
    found = fit(PUNCH, Curve(depth[pressed], force[pressed]), ENERGIES, alternatives=False)
    w, gamma1 = found.estimates
    assert (w.identifiable, w.interval) == (False, (0.0, math.inf))
    assert gamma1.identifiable
    assert math.isinf(found.condition)
    assert "w is not identifiable" in found.warnings[0]
    constrained = "w is poorly constrained by this curve (condition number "
    assert found.warnings[1].startswith(constrained)
    assert str(found).count("WARNING") == len(found.warnings)


def test_conditioning_of_known_matrices():
    angle = 0.01
    columns = np.array([[1.0, math.cos(angle)], [0.0, math.sin(angle)]]) * [2.0, 5.0]
    condition, weakest = conditioning(columns, 2)
    spread = spreads(columns, 2)
    assert condition == pytest.approx(1 / math.tan(angle / 2), rel=1e-9, abs=0)
    assert weakest[0] * weakest[1] < 0
    assert np.abs(weakest) == pytest.approx(np.array([5, 2]) / math.sqrt(29), rel=1e-9, abs=0)
    assert spread == pytest.approx(np.sqrt(np.diag(np.linalg.inv(columns.T @ columns))), abs=1e-9)


def test_the_model_follows_the_load_path_and_goes_on_smoothly():
    delta = SCENE.critical_separation
    depth = np.concatenate([np.linspace(0, delta, 8), np.linspace(delta, -0.99 * delta, 30)])
    force = load_path(SCENE, depths=depth).force
    model = Model.of(SCENE, ("w", "gamma1"), Data.of(Curve(depth, force)))
    assert np.abs(model.residuals(np.zeros(2))).max() < 1e-6 * np.abs(force).max()
    x = np.array([math.log(0.9), 0.0])
    first = np.array([1.0, 0.0])
    # lets go at -0.949 δ₀, before the last points
    below = np.array([model.residuals(x + t * first)[-1] for t in np.linspace(0, 0.12, 41)])
    bends = np.abs(np.diff(below, 2)).max() / np.abs(np.diff(below)).max()
    assert bends < 0.3  # no jump where the model lets go of the last point


def test_noise_contact_and_marks_are_read_from_the_curve():
    clean = curve_of(SCENE, steps=60)
    noisy = curve_of(SCENE, steps=60, share=0.01)
    sigma = 0.01 * np.abs(clean.force).max()
    assert noise(noisy.force) == pytest.approx(sigma, rel=0.35, abs=0)
    held = ~np.isnan(load_path(SCENE, depths=clean.depth).contacts[:, 0])
    data = Data.of(noisy)
    assert np.array_equal(data.used, held)
    touch, detachment = data.ends
    step = noisy.depth[1] - noisy.depth[0]
    assert (touch.kind, detachment.kind) == ("touch", "detachment")
    within = 0.5 * step * (1 + 1e-9)
    assert abs(touch.depth) <= within
    assert abs(detachment.depth + SCENE.critical_separation) <= within
    assert touch.error == pytest.approx(step / math.sqrt(12), rel=1e-9, abs=0)
    assert Data.of(Curve(noisy.depth[held], noisy.force[held])).ends == ()


def test_unusable_parameters_scenes_and_curves_are_refused(capsys):
    curve = curve_of(SCENE)
    few = Curve(curve.depth[[11, 12]], curve.force[[11, 12]])
    dry = replace(SCENE, surfaces=SurfaceEnergies.from_work(0.07, 0.0))
    for given, told in (
        ((SCENE, curve, ("w", "nu")), "must be among w, gamma1, stiffness, E, offset"),
        ((SCENE, curve, ("w", "w")), "each once"),
        ((dry, curve), r"w = 0\.0 in the scene: start from a value > 0"),
        ((SCENE, few), "2 points with a force above the noise are too few"),
    ):
        with pytest.raises(ValueError, match=told):
            fit(*given)
    with pytest.raises(SystemExit):
        study.main(["curve.csv"])
    assert "--scene are needed" in capsys.readouterr().err


def test_clean_data_in_contact_give_the_parameters_back():
    names = ("w", "gamma1", "stiffness")
    clean = curve_of(SCENE, steps=6)
    held = np.abs(clean.force) > 0
    curve = Curve(clean.depth[held], clean.force[held])
    found = fit(astray(SCENE, names, 1.5), curve, names, **FAST)
    for estimate in found.estimates:
        true = parameters_of(SCENE)[estimate.name]
        assert estimate.value == pytest.approx(true, rel=1e-5, abs=0)
    assert WRONG.gamma1 == 1.5 * SCENE.gamma1
