"""Fits that tell when the model does not fit, bounds, two works of adhesion, several contacts."""

import math
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from discretization import load_path
from energy import FlatPunch, Scene, SurfaceEnergies, Wedge
from studies import __main__ as command_line
from studies import fit_failures, fit_figure, fit_trials
from studies.command import Output
from studies.fit_estimate import fit
from studies.fit_model import DEFAULT, Model, parameters_of, scene_with
from studies.fit_quality import Quality, judged, runs
from studies.force_curve import Curve, contacts, in_contact, loading, marks, turning_points
from studies.scene_file import load

SCENE = fit_trials.SCENE
LIFT = SCENE.critical_separation


def measured(scene, turns, share=0.0, steps=40, seed=3):
    """A simulated curve through turning points in units of δ₀ of SCENE, with noise."""
    legs = [np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(turns)]
    depth = LIFT * np.concatenate([turns[:1], *legs])
    force = load_path(scene, depths=depth).force
    noise = np.random.default_rng(seed).standard_normal(depth.size)
    return Curve(depth, force + share * np.abs(force).max() * noise)


def with_opening(scene, times):
    w = times * scene.work_of_adhesion
    return replace(scene, opening=SurfaceEnergies.from_work(scene.gamma1, w))


def test_the_offset_of_the_depth_is_fitted_by_default():
    assert DEFAULT == ("w", "gamma1", "offset")
    curve = measured(SCENE, [-1.1, 1.1, -1.1], 0.005, seed=1)
    found = fit(SCENE, Curve(curve.depth + 0.5 * LIFT, curve.force), profiles=False)
    w, _, offset = found.estimates
    assert w.value == pytest.approx(SCENE.work_of_adhesion, rel=0.03)
    assert offset.interval[0] < 0.5 * LIFT < offset.interval[1]
    assert found.quality.fits and 0.6 < found.quality.times < 1.4


@pytest.mark.parametrize("kind", fit_failures.KINDS)
def test_failures_are_called_and_good_curves_are_not(kind):
    params = fit_failures.Parameters(SCENE, steps=(20, 30))
    for number in range(1, 9):
        outcome = fit_failures._outcome(params, (kind, number))
        assert outcome.called == (kind != "good"), outcome
        if kind != "good":
            assert re.search("times the noise.*: check .*zero", outcome.quality.told)


def test_each_kind_of_curve_has_what_its_name_says():
    params = fit_failures.Parameters(SCENE)
    good, sign, zero, loop, level = (
        fit_failures.case(params, kind, 1) for kind in fit_failures.KINDS
    )
    assert abs(level.curve.force[0]) > 0.05 * np.abs(level.curve.force).max()
    assert good.names == sign.names == loop.names == level.names == DEFAULT
    assert zero.names == ("w", "gamma1")
    deep = [case.curve.force[case.curve.depth.argmax()] for case in (good, sign)]
    assert deep[0] > 0 > deep[1]
    work = [np.trapezoid(c.curve.force, c.curve.depth) for c in (good, loop)]
    assert work[1] > 2 * work[0] > 0
    again = fit_failures.case(params, "good", 1)
    assert np.array_equal(again.curve.force, good.curve.force)
    wedge = replace(SCENE, indenter=Wedge(0.002))
    other = fit_failures.case(fit_failures.Parameters(wedge), "good", 1).start
    assert 0.5 <= other.indenter.delta / 0.002 <= 2 and other.indenter.delta != 0.002


def test_a_model_that_does_not_fit_has_no_intervals():
    curve = measured(SCENE, [-1.1, 1.1, -1.1], 0.01)
    found = fit(SCENE, Curve(curve.depth, -curve.force))
    assert not found.quality.fits
    assert all(e.interval is None and e.profile is None for e in found.estimates)
    said = str(found)
    assert re.search(r"WARNING: residual is \d+\.?\d* times the noise: check sign, zero", said)
    assert "withheld" in said and "nan" not in said
    good = fit(SCENE, curve, profiles=False)
    assert "WARNING" not in str(good) and "nan" not in str(good) and "not sought" in str(good)


def test_the_noise_of_few_points_is_not_known():
    clean = measured(SCENE, [0.2, 1.1], steps=6)
    found = fit(SCENE, clean, ("w",), profiles=False)
    assert "the noise cannot be told from so few points" in found.warnings[0]
    assert "nan" not in str(found)


def test_an_estimate_on_a_bound_is_called_so():
    punch = Scene(SCENE.layer, SCENE.surfaces, FlatPunch(1e-4))
    curve = measured(punch, [0.2, 1.1, 0.2], 0.01)
    low = Curve(curve.depth, curve.force - 2 * punch.gamma1 * curve.depth[0] / 1e-5)
    found = fit(punch, low, ("gamma1",))
    (gamma1,) = found.estimates
    assert gamma1.bound and gamma1.interval is None and not gamma1.identifiable
    assert gamma1.value == pytest.approx(1e-4 * punch.gamma1, rel=1e-3)
    assert "gamma1 = 7e-06 J/m² is the bound of the search, no estimate" in str(found)
    assert "bound of the search J/m²" in str(found)


def test_a_loop_has_two_works_of_adhesion():
    names = ("w", "opening", "offset")
    true = with_opening(SCENE, 3.0)
    curve = measured(true, [-1.9, 1.1, -1.9], 0.01)
    wrong = fit(SCENE, curve, ("w", "offset"), profiles=False)
    assert not wrong.quality.fits
    for start in (SCENE, with_opening(SCENE, 1.8)):
        found = fit(start, curve, names, profiles=False)
        assert found.quality.fits, found
        for estimate, value in zip(found.estimates, (2e-6, 6e-6, 0.0), strict=True):
            assert abs(estimate.value - value) < np.ptp(estimate.interval)  # four deviations
        assert np.ptp(found.estimates[1].interval) < 0.3 * 6e-6
    none = fit(SCENE, measured(SCENE, [-1.1, 1.1, -1.1], 0.01), names, profiles=False)
    w, opening, _ = none.estimates
    if opening.bound:
        assert opening.interval is None
    else:
        assert opening.value < 1.05 * w.value


def test_the_opening_of_a_scene_is_kept_where_it_is_not_fitted():
    true = with_opening(SCENE, 3.0)
    curve = measured(true, [-1.9, 1.1, -1.9], 0.01)
    start = scene_with(true, parameters_of(true) | {"w": 1.4e-6})
    found = fit(start, curve, ("w", "offset"), profiles=False)
    assert found.quality.fits
    assert found.estimates[0].interval[0] < 2e-6 < found.estimates[0].interval[1]
    assert parameters_of(start)["opening"] == 6e-6 and parameters_of(SCENE)["opening"] == 0.0


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


def test_a_contact_that_is_lost_begins_anew():
    turns = [-0.3, 1.0, -1.2, 0.7, 0.2, 0.9, -1.2]
    curve = measured(SCENE, turns, 0.005, steps=30)
    first, second = contacts(curve)
    assert (first.start, first.stop, second.stop) == (0, 60, curve.depth.size)
    used = in_contact(curve)
    held = ~np.isnan(load_path(SCENE, depths=curve.depth).contacts[:, 0])
    assert np.count_nonzero(used != held) <= 2
    assert [mark.kind for mark in marks(curve)] == ["touch", "letting go"] * 2
    model = Model.of(SCENE, DEFAULT, curve)
    assert len(model.pieces) == 2
    assert model.pieces[1].stop == used.sum() == model.depths.size
    found = fit(SCENE, curve, profiles=False)
    assert found.quality.fits and not found.warnings
    top, _ = fit_figure.plot(found, "two contacts").axes
    names = [text.get_text() for text in top.get_legend().get_texts()]
    assert names == ["out of contact", "fit", "loading", "unloading"]


def test_runs_of_known_signs():
    assert runs(np.array([1.0, -1.0] * 8)) == pytest.approx((16 - 9) / math.sqrt(8 * 7 / 15))
    assert runs(np.repeat([1.0, -1.0], 8)) == pytest.approx((2 - 9) / math.sqrt(8 * 7 / 15))
    assert runs(np.ones(9)) == -3.0
    rng = np.random.default_rng(2)
    many = np.array([runs(rng.standard_normal(60)) for _ in range(400)])
    assert abs(many.mean()) < 0.2 and many.std() == pytest.approx(1, abs=0.1)


def test_quality_of_known_residuals():
    flat, none = np.array([1.0, -1.0] * 8), np.empty(0)
    assert judged(flat, none, none, 16, 0.5).times == 2.0
    assert judged(flat, np.array([4.0, 4.0]), none, 12, 1.0).times == 2.0
    assert judged(flat, none, np.full(25, 0.5), 16, 1.0).zero == 2.5
    assert math.isnan(judged(flat, none, none, 16, 0.0).times)
    assert not Quality(1.0, -4.0).fits and Quality(1.0, -3.0, 4.0).fits
    assert Quality(0.1, -9.0).fits and not Quality(2.1, 0.0).fits
    assert not Quality(1.0, 0.0, -5.0).fits
    assert "keeps its sign over many points" in Quality(1.2, -5.0).told
    assert "the force out of contact is -5 standard errors off" in Quality(1.0, 0.0, -5.0).told


def test_a_small_force_out_of_contact_is_called():
    curve = measured(SCENE, [-1.1, 1.1, -1.1], 0.02)
    level = 0.05 * np.abs(curve.force).max()  # too small to be taken for contact
    found = fit(SCENE, Curve(curve.depth, curve.force + level), profiles=False)
    assert found.quality.times < 1 < 5 < found.quality.zero
    assert "check zero: the force out of contact" in found.warnings[0]
    assert found.estimates[0].interval is None


def test_residuals_below_what_the_simulation_tells_are_no_misfit():
    curve = measured(SCENE, [0.01, 1.1], steps=400)
    found = fit(SCENE, curve, ("w",), profiles=False)
    assert found.quality.fits and not found.warnings
    wrong = Curve(curve.depth, curve.force * (1 + 1e-8 * np.sin(8e6 * curve.depth)))
    assert fit(SCENE, wrong, ("w",), profiles=False).quality.fits


def test_the_self_test_fails_where_a_failure_is_not_called(tmp_path, capsys, monkeypatch):
    params = fit_trials.Parameters(SCENE, ("w", "gamma1"), 1, steps=14, profile=False)
    few = fit_failures.Parameters(SCENE, 1, steps=(20, 21))
    with pytest.raises(ValueError, match="trials = 0 must be at least 1"):
        fit_failures.run(replace(few, curves=0))
    record = fit_failures.run(few)
    assert record.passed and record.called("sign") == 1
    missed = [one._replace(called=one.kind == "sign") for one in record.outcomes]
    missed = replace(record, outcomes=tuple(missed))
    mistaken = [one._replace(called=True) for one in record.outcomes]
    assert not missed.passed and not replace(record, outcomes=tuple(mistaken)).passed
    for given, status in ((record, 0), (missed, 1)):
        monkeypatch.setattr(fit_failures, "run", lambda p, jobs, given=given: given)
        assert fit_trials.report(params, Output(tmp_path, "a command")) == status
    assert "hysteresis       0   needed: all" in capsys.readouterr().out
    rows = (tmp_path / "fit_self_test_failures.csv").read_text("utf-8").splitlines()
    assert "kind,curve,residual_over_noise,runs,zero,called" in rows


SCENE_FILE = """
depth = 0
[layer]
E = 50.0
nu = 0.45
h = 5e-6
[surfaces]
gamma1 = 0.1
w = 1.5e-6
[indenter]
shape = "parabola"
R = 0.05
[measured]
columns = ["Weg [µm]", "2 [mN]"]
width = 0.01
skip = 1
"""


def test_scene_files_and_options_say_how_a_curve_is_read(tmp_path, capsys):
    scene, data = tmp_path / "scene.toml", tmp_path / "kurve.csv"
    scene.write_text(SCENE_FILE, "utf-8")
    curve = measured(SCENE, [-1.1, 1.1, -1.1], 0.01)
    rows = [f"{1e6 * d:.9f};{1e3 * 0.01 * p:.9f}" for d, p in zip(*curve, strict=True)]
    data.write_text("1;2\nWeg;Kraft\n" + "\n".join(rows).replace(".", ","), "utf-8")
    arguments = ["fit", str(data), "--scene", str(scene), "--out", str(tmp_path), "--quick"]
    assert command_line.main(arguments) == 0
    assert "not sought" in capsys.readouterr().out
    lines = (tmp_path / "kurve_fit.csv").read_text("utf-8").splitlines()
    table = np.array([row.split(",") for row in lines if not row.startswith(("#", "d"))], float)
    assert table[:, 0] == pytest.approx(curve.depth, abs=1e-15)
    assert table[:, 1] == pytest.approx(curve.force, abs=1e-10)
    for given, told in (
        (["--columns", "Zug [m]", "2 [mN]"], "no column 'Zug'"),
        (["--width", "-1"], "width = -1.0 must be positive"),
        (["--skip", "400"], "no line has two numbers"),
        (["--decimal", "."], "line 2: 1 cell|no line has two numbers|must be a finite number"),
        (["--encoding", "utf-16"], "is no text in utf-16|no line has two numbers"),
        (["--delimiter", "tab"], "no line has two numbers"),
        (["--curve", "2"], "curve = 2: text has one"),
    ):
        assert command_line.main([*arguments, *given]) == 2
        assert re.search(told, capsys.readouterr().err), given


def test_wrong_tables_of_measured_data_are_refused(tmp_path):
    path = tmp_path / "scene.toml"
    for old, new, told in (
        ("skip = 1", "skip = -1", "measured.skip = -1 must be a whole number"),
        ("skip = 1", 'decimal = "x"', "measured.decimal = 'x' is unknown"),
        ("width = 0.01", "width = 0", "measured.width = 0.0 must be positive"),
        ('"2 [mN]"', "", "measured.columns = .* must be a list of two"),
        ("skip = 1", "lines = 1", "measured.lines = 1 is unknown"),
    ):
        path.write_text(SCENE_FILE.replace(old, new), "utf-8")
        with pytest.raises(ValueError, match=f"{re.escape(str(path))}: {told}"):
            load(path)


def test_a_scene_file_takes_a_profile_from_a_file(tmp_path):
    path, body = tmp_path / "scene.toml", 'shape = "sampled"\nfile = "scan.csv"\nkind = "smooth"'
    x = np.linspace(-1, 1, 9)
    rows = "\n".join(f"{a:.4f};{500 * a * a:.4f}" for a in x).replace(".", ",")
    (tmp_path / "scan.csv").write_text(f"Profil\nlateral;up\n{rows}\n", "utf-8")
    text = SCENE_FILE[: SCENE_FILE.index("[measured]")]
    old = 'shape = "parabola"\nR = 0.05'
    path.write_text(text.replace(old, f'{body}\ncolumns = ["lateral [mm]", "2 [nm]"]'), "utf-8")
    indenter = load(path).scene.indenter
    assert indenter.kind == "smooth"
    assert indenter.x == pytest.approx(1e-3 * x, abs=1e-18)
    assert indenter.z == pytest.approx(500e-9 * x**2, abs=1e-20)
    for extra, told in (
        ("x = [1.0]", r"indenter.x = \[1.0\] stands beside file"),
        ("skip = 40", "indenter.*no line has two numbers"),
        ('columns = "x"', "indenter.columns = 'x' must be a list of two"),
    ):
        path.write_text(text.replace(old, f"{body}\n{extra}"), "utf-8")
        with pytest.raises(ValueError, match=told):
            load(path)
    path.write_text(text.replace(old, 'shape = "sampled"\nunit = 1e-3\nx = [0]\nz = [0]'), "utf-8")
    with pytest.raises(ValueError, match=r"indenter\.unit = 0\.001 needs file"):
        load(path)
