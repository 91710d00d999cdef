"""Fits of measured curves: synthetic data, intervals, what is not identifiable, files."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scene_files import FIT_SCENE
from scenes import rescaled

from discretization import load_path
from energy import ElasticLayer, FlatPunch, Scene, SurfaceEnergies
from studies import __main__ as command_line
from studies.scenes.file import load
from studies.scenes.fit import failures as fit_failures
from studies.scenes.fit import study
from studies.scenes.fit import trials as fit_trials
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve, in_contact, marks, noise
from studies.scenes.fit.model import Model, conditioning, parameters_of
from studies.scenes.fit.trials import SCENE
from studies.shared.command import Output
from studies.shared.table import read

ENERGIES = ("w", "gamma1")
FEW = fit_trials.Parameters(names=ENERGIES, trials=5, steps=14, noise=0.01)


def curve_of(scene, steps=12, share=0.0, seed=5):
    """A synthetic curve with noise of a share of its largest force."""
    params = fit_trials.Parameters(scene, ENERGIES, steps=steps)
    depth, force = fit_trials.clean_curve(params)
    sigma = share * np.abs(force).max()
    return Curve(depth, force + sigma * np.random.default_rng(seed).standard_normal(force.size))


@pytest.mark.slow
def test_an_incompressible_layer_has_no_stiffness_to_fit():
    layer = ElasticLayer(1.0, 0.5, 1.0, response="layer")
    with pytest.raises(ValueError, match=r"nu = 0\.5: .* Poisson's ratio, such as 0\.49"):
        parameters_of(replace(SCENE, layer=layer))


def test_the_intervals_hold_the_truth():
    record = fit_trials.run(FEW)
    for i, name in enumerate(FEW.names):
        values = np.array([trial[i].value for trial in record.trials])
        assert record.share(i) >= (4 / 5, 4 / 5)
        error = abs(values.mean() / record.truth[name] - 1)
        spread = values.std(ddof=1) / record.truth[name]
        assert error < 3 * spread / math.sqrt(len(values))
        assert 0 < spread < {"w": 0.01, "gamma1": 0.05}[name]
        widths = [np.ptp(trial[i].interval) / record.truth[name] for trial in record.trials]
        assert 1.5 < np.mean(widths) / spread < 10  # 2 · 2.03 in the mean of many
    assert "100%" in fit_trials.told(record)


@pytest.mark.slow
def test_the_profile_agrees_with_the_linearised_interval_where_the_model_is_nearly_linear():
    found = fit(SCENE, curve_of(SCENE, share=0.005), ENERGIES)
    for i, estimate in enumerate(found.estimates):
        assert estimate.identifiable
        width = np.ptp(estimate.interval)
        assert estimate.profile == pytest.approx(estimate.interval, abs=0.05 * width)
        inside, outside = (estimate.value + share * width for share in (0.4, 0.6))
        assert found.inside_profile(i, inside) and not found.inside_profile(i, outside)
    assert found.warnings == ()
    assert "touch, detachment used" in str(found)


@pytest.mark.slow
def test_the_fit_does_not_depend_on_units():
    wrong, (depth, force) = fit_trials.wrong_start(FEW), curve_of(SCENE, share=0.01)
    here = fit(wrong, Curve(depth, force), profiles=False)
    # 1 Pa = 1 µN/mm², and P per length: 1 N/m = 1e3 µN/mm
    there = fit(rescaled(wrong, 1e3, 1.0), Curve(1e3 * depth, 1e3 * force), profiles=False)
    for a, b in zip(here.estimates, there.estimates, strict=True):
        assert b.value == pytest.approx(1e3 * a.value, rel=1e-6, abs=0)


PUNCH = Scene(
    ElasticLayer(50.0, 0.45, 5e-6), SurfaceEnergies.from_work(0.07, 2e-6), FlatPunch(1e-4)
)


@pytest.mark.slow
def test_a_pinned_line_does_not_feel_w_without_the_letting_go():
    depth, force = curve_of(PUNCH, share=0.005)
    pressed = depth > -0.5 * PUNCH.critical_separation  # cut before the letting go
    found = fit(PUNCH, Curve(depth[pressed], force[pressed]), ENERGIES)
    w, gamma1 = found.estimates
    assert (w.identifiable, w.interval) == (False, (0.0, math.inf))
    assert gamma1.identifiable
    assert math.isinf(found.condition)
    assert "w is not identifiable" in found.warnings[0]
    assert "hardly fixes +1.00 log w" in found.warnings[1]
    assert str(found).count("WARNING") == 2


def test_conditioning_of_known_matrices():
    angle = 0.01
    columns = np.array([[1.0, math.cos(angle)], [0.0, math.sin(angle)]]) * [2.0, 5.0]
    condition, weakest, spread = conditioning(columns)
    assert condition == pytest.approx(1 / math.tan(angle / 2), rel=1e-9, abs=0)
    assert weakest[0] * weakest[1] < 0
    assert np.abs(weakest) == pytest.approx(np.array([5, 2]) / math.sqrt(29), rel=1e-9, abs=0)
    assert spread == pytest.approx(np.sqrt(np.diag(np.linalg.inv(columns.T @ columns))), abs=1e-9)


def test_the_model_follows_the_load_path_and_goes_on_smoothly():
    delta = SCENE.critical_separation
    depth = np.concatenate([np.linspace(0, delta, 8), np.linspace(delta, -0.99 * delta, 30)])
    force = load_path(SCENE, depths=depth).force
    model = Model.of(SCENE, ("w", "gamma1"), Curve(depth, force))
    assert np.abs(model.residuals(np.zeros(2))).max() < 1e-12 * np.abs(force).max()
    x, first = np.array([math.log(0.9), 0.0]), np.array([1.0, 0.0])
    # lets go at -0.949 δ₀, before the last points
    below = np.array([model.residuals(x + t * first)[-1] for t in np.linspace(0, 0.12, 41)])
    bends = np.abs(np.diff(below, 2)).max() / np.abs(np.diff(below)).max()
    assert bends < 0.1  # no jump where the model lets go of the last point


def test_noise_contact_and_marks_are_read_from_the_curve():
    clean, noisy = curve_of(SCENE, steps=60), curve_of(SCENE, steps=60, share=0.01)
    sigma = 0.01 * np.abs(clean.force).max()
    assert noise(noisy.force) == pytest.approx(sigma, rel=0.35, abs=0)
    held = ~np.isnan(load_path(SCENE, depths=clean.depth).contacts[:, 0])
    assert np.array_equal(in_contact(noisy), held)
    touch, detachment = marks(noisy)
    step = noisy.depth[1] - noisy.depth[0]
    assert (touch.kind, detachment.kind) == ("touch", "detachment")
    assert abs(touch.depth) <= step / 2
    assert abs(detachment.depth + SCENE.critical_separation) <= step / 2
    assert touch.error == pytest.approx(step / math.sqrt(12), rel=1e-9, abs=0)
    assert marks(Curve(noisy.depth[held], noisy.force[held])) == ()


def test_unusable_parameters_scenes_and_curves_are_refused():
    curve = curve_of(SCENE)
    few = Curve(curve.depth[[11, 12]], curve.force[[11, 12]])
    dry = replace(SCENE, surfaces=SurfaceEnergies.from_work(0.07, 0.0))
    for given, told in (
        ((SCENE, curve, ("w", "nu")), "must be among w, gamma1, stiffness, offset"),
        ((SCENE, curve, ("w", "w")), "each once"),
        ((dry, curve), r"w = 0\.0 in the scene: start from a value > 0"),
        ((SCENE, few), "2 points with a force above the noise are too few"),
    ):
        with pytest.raises(ValueError, match=told):
            fit(*given)


@pytest.mark.slow
def test_a_file_is_fitted_from_the_command_line(tmp_path, capsys):
    scene, data = tmp_path / "scene.toml", tmp_path / "curve.csv"
    scene.write_text(FIT_SCENE)
    curve = curve_of(SCENE, steps=24, share=0.01)
    rows = [f"{1e6 * d:.9g}, {1e3 * p:.9g}" for d, p in zip(*curve, strict=True)]
    data.write_text("\n".join(["depth [µm], force [mN/m]", *rows]), "utf-8")
    arguments = ["fit", str(data), "--scene", str(scene), "--out", str(tmp_path)]
    assert command_line.main(arguments) == 0
    said, progress = capsys.readouterr()
    assert "1 of 3 points" in progress
    assert "95 % profile" in said and "WARNING" not in said
    again, rows = fit(load(scene).scene, curve, profiles=False), read(tmp_path / "curve_fit.csv")
    assert list(rows[0]) == ["depth [m]", "force [N/m]", "fitted [N/m]", "residual [N/m]"]
    fitted = np.array([float(row["fitted [N/m]"]) for row in rows])
    assert fitted[in_contact(curve)] == pytest.approx(again.fitted, rel=1e-5, abs=0)
    assert (tmp_path / "curve_fit.png").stat().st_size > 10_000
    with pytest.raises(SystemExit):
        study.main([str(data)])
    assert "--scene are needed" in capsys.readouterr().err


def test_the_self_test_reports_and_fails_where_intervals_miss(tmp_path, capsys, monkeypatch):
    params, out = replace(FEW, names=("w",), trials=2, profile=False), Output(tmp_path, "a command")
    quality = fit_failures.Quality(1.0, 0.0)
    kinds = [fit_failures.Outcome(kind, 1, quality, kind != "good") for kind in fit_failures.KINDS]
    curves = fit_failures.Record(fit_failures.Parameters(SCENE, curves=1), tuple(kinds))
    monkeypatch.setattr(fit_failures, "run", lambda p, jobs: curves)
    assert fit_trials.report(params, out) == 0
    assert "2 of 2 points" in capsys.readouterr().err
    assert (tmp_path / "fit_self_test.csv").exists()
    with pytest.raises(ValueError, match="trials = 0 must be at least 1"):
        study.main(["--self-test", "--trials", "0", "--out", str(tmp_path)])
    record = fit_trials.run(params)
    missed = tuple(tuple(t._replace(holds=False) for t in trial) for trial in record.trials)
    missed = replace(record, trials=missed)
    assert record.passed and not missed.passed
    assert curves.passed and curves.called("sign") == 1
    missing, mistaken = (
        replace(curves, outcomes=tuple(one._replace(called=called(one)) for one in kinds))
        for called in (lambda one: one.kind == "sign", lambda one: True)
    )
    assert not missing.passed and not mistaken.passed
    for trials, failures in ((missed, curves), (record, missing)):
        monkeypatch.setattr(fit_trials, "run", lambda p, jobs, given=trials: given)
        monkeypatch.setattr(fit_failures, "run", lambda p, jobs, given=failures: given)
        assert fit_trials.report(params, out) == 1
    assert "hysteresis       0   needed: all" in capsys.readouterr().out
    assert "kind,curve,residual" in (tmp_path / "fit_self_test_failures.csv").read_text("utf-8")


def test_clean_data_in_contact_give_the_parameters_back():
    names = ("w", "gamma1", "stiffness")
    params = fit_trials.Parameters(names=names, steps=12)
    clean = fit_trials.clean_curve(params)
    held = np.abs(clean.force) > 0
    curve = Curve(clean.depth[held], clean.force[held])
    found = fit(fit_trials.wrong_start(params), curve, names, profiles=False)
    for estimate in found.estimates:
        true = parameters_of(params.scene)[estimate.name]
        assert estimate.value == pytest.approx(true, rel=1e-5, abs=0)
    assert fit_trials.wrong_start(params).gamma1 == 1.5 * params.scene.gamma1
