"""Fits of what instruments measure: cantilevers, any zero, tilted lines; other models; folders."""

import doctest
import inspect
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.measured_curves import START, sphere, written
from support.repository import ROOT
from support.scene_files import SPHERE

import studies
from discretization import load_path
from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Parabola,
    PowerLaw,
    Scene,
    SurfaceEnergies,
)
from studies import __main__ as command_line
from studies.scenes.curve_file import Reading, read_curve
from studies.scenes.file import load
from studies.scenes.fit import branches, many, plan, trials
from studies.scenes.fit import study as fit_study
from studies.scenes.fit.branches import leg_branches, touching
from studies.scenes.fit.estimate import fit
from studies.scenes.fit.force_curve import Curve, Data, baseline, free_parts
from studies.scenes.fit.trials import SCENE
from studies.shared.table import read

FAST = {"profiles": False, "alternatives": False}


@pytest.mark.parametrize(
    ("body", "gamma1", "opening", "right"),
    [
        (Parabola(5e-6), 0.03, None, 1e-5),
        (Circle(5e-6), 0.03, 3e-4, 1e-3),  # lines are held at first: a kink
        (PowerLaw(1e16, 3.0), 0.03, None, 1e-5),
        (FlatPunch(2e-6), 0.03, None, 1e-5),
        (Parabola(5e-6), 0.0, None, 1e-3),
    ],
)
@pytest.mark.parametrize("stiffness", [math.inf, 0.3, 0.03])
def test_forces_off_a_depth_path_under_a_machine(body, gamma1, opening, right, stiffness):
    """Forces read off a depth path are those under the machine."""
    opened = opening and SurfaceEnergies.from_work(gamma1, opening)
    surfaces = SurfaceEnergies.from_work(gamma1, 1e-4)
    scene = replace(SCENE, indenter=body, surfaces=surfaces, opening=opened)
    lift = 2.3e-8
    legs = np.linspace(0.1 * lift, 2 * lift, 15), np.linspace(2 * lift, -1.2 * lift, 25)[1:]
    touch = touching(scene)
    there, back = found = leg_branches(scene, touch, 6 * lift, (2 * lift,), stiffness)
    assert (there is back) == (gamma1 > 0 and opening is None)
    read_off = [way.read(leg, stiffness) for way, leg in zip(found, legs, strict=True)]
    force = np.concatenate([force for force, _ in read_off])
    drive = np.concatenate(legs)
    machine = {"machine_stiffness": stiffness}
    history = load_path(
        scene, **({"depths": drive} if math.isinf(stiffness) else {"drives": drive} | machine)
    )
    held = ~np.isnan(history.contacts[:, 0])
    size = np.abs(history.force).max()
    assert held.sum() > 20
    assert np.abs(force - history.force)[held].max() < right * size
    lost = [event for event in history.events if event.kind in ("detachment", "pull-off")]
    if lost:
        assert abs(lost[-1].control - read_off[1][1]) < 1e-4 * lift


def test_beyond_its_end_a_branch_goes_on_straight():
    (found,) = leg_branches(SCENE, 0.0, 1e-7, (), 0.3)
    _, end = found.read(np.array([0.0]), 0.3)
    force, _ = found.read(end + 1e-9 * np.array([-1.0, 0.0, 0.5, 1.0, 1.5]), 0.3, 1e-9)
    assert np.diff(force[:4], 2)[1] == pytest.approx(0, abs=1e-6 * np.ptp(force))
    assert (np.diff(force) < 0).all()  # past the most tensile state


def test_machine_too_soft_for_all_states_but_one():
    """A machine too soft for every state but one has its force."""
    (found,) = leg_branches(SCENE, 0.0, 2e-8, (), 0.3)
    part = slice(-found.depth.size // 3, None)  # along which the pull falls
    last = replace(found, depth=found.depth[part], force=found.force[part])
    force, _ = last.read(np.array([0.0, 1.0]), 1e-5)
    assert force == pytest.approx(np.full(2, last.force[0]), rel=1e-12, abs=0)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [math.inf, 0.03])
def test_any_zero_a_tilted_line_and_a_soft_cantilever_are_fitted(stiffness):
    zero = 3.2e-6
    level = 0.3e-9
    slope = 3e-3
    curve = sphere(stiffness, zero=zero, level=level, slope=slope)
    found = fit(START, curve, **FAST)
    assert found.quality.fits, found
    for name, true in (("w", 1e-4), ("gamma1", 0.03), ("offset", zero), ("slope", slope)):
        assert abs(found[name].value - true) < np.ptp(found[name].interval), name
        assert np.ptp(found[name].interval) < {"offset": 3e-9}.get(name, 0.5 * true)
    if stiffness < math.inf:  # the noise is in the depth, too
        rigid = fit(START, curve._replace(machine_stiffness=math.inf), **FAST)
        assert rigid.quality.times > 1.3 * found.quality.times


def test_line_without_contact_is_found():
    """The line without contact is found and nothing else taken for it."""
    curve = sphere(level=0.3e-9, slope=3e-3)
    held = ~np.isnan(load_path(SCENE, depths=curve.depth).contacts[:, 0])
    free = free_parts(curve)
    assert not (free & held).any() and free.sum() > 0.7 * (~held).sum()
    assert baseline(curve, free).shape == (180, 3)
    first = slice(0, 90)
    assert baseline(Curve(curve.depth[first], curve.force[first]), free[first]).shape == (90, 2)
    pressed = curve.depth > 1e-9
    assert not free_parts(Curve(curve.depth[pressed], curve.force[pressed])).any()
    hertz = np.maximum(curve.depth, 0.0) ** 1.5
    assert not free_parts(Curve(curve.depth[pressed], hertz[pressed])).any()
    assert Data.of(curve).used.sum() == pytest.approx(held.sum(), abs=2)


def test_points_that_scatter_by_chance_are_still_on_a_line():
    steps = np.random.default_rng(5).standard_normal((60, 180))
    curve = sphere(noise=0.0)
    for step in steps:
        free = free_parts(curve._replace(force=curve.force + 20e-12 * step))
        assert free[0] and free[-1]


@pytest.mark.slow
@pytest.mark.parametrize("which", [("no tension", 26), ("half-space", 50), ("layer", 3)])
def test_what_is_no_sphere_on_springs_is_said(which):
    found = trials.outcome(trials.Parameters(), which)
    assert found.rightly and not found.silent, found


@pytest.mark.slow
def test_assumptions_are_told_at_their_worst_along_the_curve():
    found = fit(START, sphere(), **FAST)
    worst = {one.name: (one.value, depth) for one, depth in found.strained}
    assert worst["d/h"][0] == pytest.approx(0.2, rel=0.02)
    assert worst["d/h"][1] == pytest.approx(60e-9, rel=0.02) and worst["h/a"][1] < 0
    assert any("h/a = " in text and "worst at d = " in text for text in found.warnings)


def test_the_self_test_counts(tmp_path, capsys, monkeypatch):
    params = trials.Parameters(curves=2, kinds=("rigid", "sign"))
    good = trials.Outcome("rigid", 1, True, False, (True, True, True), 1.0)
    bad = trials.Outcome("sign", 1, True, False, (None, None, None), 9.0)
    record = trials.Record(params, (good, good, bad, bad))
    assert record.passed and math.isnan(record.shares("sign")[2])
    for one in (
        good._replace(rightly=False),
        good._replace(holds=(False, True, True)),
        good._replace(silent=True),
    ):
        assert not replace(record, outcomes=(one, one, bad, bad)).passed
    monkeypatch.setattr(trials, "run", lambda p, jobs: record)
    assert fit_study.main(["--self-test", "--out", str(tmp_path)]) == 0
    assert "wrong, no word" in capsys.readouterr().out
    assert "rigid,1,True,False,True,True" in (tmp_path / "fit_self_test.csv").read_text("utf-8")
    monkeypatch.undo()
    with pytest.raises(ValueError, match="trials = 0 must be at least 1"):
        fit_study.main(["--self-test", "--trials", "0", "--out", str(tmp_path)])


def test_cases_of_the_self_test_are_what_they_are_called():
    cases = {kind: trials.case(trials.Parameters(), kind, 1) for kind in trials.KINDS}
    for kind, stiffness in trials.SPRINGS.items():
        assert cases[kind].curve.machine_stiffness == stiffness
    assert cases["no tension"].truth["gamma1"] == 0 == cases["half-space"].truth["gamma1"]
    assert cases["half-space"].start.layer.h == trials.THICK
    assert cases["layer"].start.layer.nu == trials.NU and not cases["layer"].start.layer.exact
    assert abs(cases["offset"].truth["offset"]) > 1e-7
    pulled = cases["rigid"].curve, cases["sign"].curve
    assert [abs(c.force.min()) < c.force.max() for c in pulled] == [True, False]
    again = [trials.case(trials.Parameters(), "drift", 2).curve.force for _ in range(2)]
    assert np.array_equal(*again)


@pytest.mark.slow
def test_figures_and_exit_status(tmp_path, capsys):
    """A figure for each name and a status that says whether it fits."""
    scene = tmp_path / "sphere.toml"
    scene.write_text(SPHERE, "utf-8")
    for name, sign in (("kc0.08.csv", 1), ("kc0.3.csv", -1)):
        curve = sphere(0.08)
        data = written(tmp_path / name, curve._replace(force=sign * curve.force))
        given = ["fit", str(data), "--scene", str(scene), "--out", str(tmp_path), "--quick"]
        status = command_line.main([*given, "--spring-constant", "0.08"])
        assert status == (sign < 0), capsys.readouterr().out
        stem = name.removesuffix(".csv")
        assert (tmp_path / f"{stem}_fit.png").stat().st_size > 10_000
        rows = read(tmp_path / f"{stem}_fit.csv")
        assert list(rows[0]) == ["depth [m]", "force [N]", "fitted [N]", "residual [N]"]
        assert len(rows) == curve.force.size


@pytest.mark.slow
def test_a_folder_is_fitted_resumed_and_shares_a_parameter(tmp_path, capsys, monkeypatch):
    scene = tmp_path / "sphere.toml"
    folder = tmp_path / "curves"
    scene.write_text(SPHERE, "utf-8")
    folder.mkdir()
    for seed in range(1, 4):
        written(folder / f"{seed}.csv", sphere(seed=seed, n=50))
    given = [str(folder), "--scene", str(scene), "--out", str(tmp_path), "--quick", "--jobs", "1"]
    assert fit_study.main([*given, "--shared", "gamma1"]) == 0
    said = capsys.readouterr().out
    assert "3 of 3 curves are described by the model" in said and "w: median" in said
    assert "from 3 curves, χ² per curve" in said
    rows = read(tmp_path / "curves_fits_shared_gamma1.csv")
    assert [float(row["w"]) for row in rows] == pytest.approx([1e-4] * 3, rel=0.05)
    assert "gamma1" not in rows[0] and "gamma1_low" in read(tmp_path / "curves_fits.csv")[0]
    assert (tmp_path / "curves_fits_shared_gamma1.png").stat().st_size > 10_000
    monkeypatch.setattr(many, "fit", None)  # nothing is left to be fitted
    assert fit_study.main([*given, "--shared", "gamma1"]) == 0
    (folder / "1.csv").write_text((folder / "2.csv").read_text("utf-8"), "utf-8")
    with pytest.raises(ValueError, match="holds results of another command"):  # of another content
        fit_study.main(given)
    with pytest.raises(ValueError, match="shared = 'offset' must be one of what is fitted: w, ga"):
        fit_study.main([*given, "--shared", "offset"])
    (tmp_path / "none").mkdir()
    with pytest.raises(ValueError, match="holds no curves"):
        many.curves(tmp_path / "none", Reading())


def test_the_figure_of_a_folder_has_units():
    columns = {"fits": np.ones(4), "w": 1e-4 * np.arange(1.0, 5.0), "E": np.full(4, 3e4)}
    record = SimpleNamespace(column=columns.__getitem__)
    figure = many.plot(record, ["w", "E"], "four curves")
    assert [axes.get_xlabel() for axes in figure.axes] == ["w in µJ/m²", "E in kPa"]


def test_a_common_parameter_is_weighted_and_says_when_it_is_none():
    values = np.array([0.03, 0.031, 0.029, math.nan])
    reach = math.exp(1.96 * 0.03)
    same = many.common("gamma1", values / reach, values * reach)
    assert same.value == pytest.approx(
        0.03, rel=0.01
    ) and "consistent with one value for all" in str(same)
    low, high = same.interval
    assert same.curves == 3
    assert math.log(high / low) == pytest.approx(2 * 1.96 * 0.03 / math.sqrt(3))
    apart = many.common("gamma1", np.array([0.03, 0.06]) / reach, np.array([0.03, 0.06]) * reach)
    assert "WARNING: not consistent with one value" in str(apart)
    sure = many.common("w", np.array([1.0, 1.9]), np.array([1.0001, 2.1]))
    assert sure.value == pytest.approx(1.0, rel=1e-3)  # told by the one that knows
    with pytest.raises(ValueError, match="no curve has an interval of it"):
        many.common("w", values * math.nan, values)


@pytest.mark.slow
def test_plan_predicts_the_scatter_of_fits(tmp_path, capsys):
    """A plan shows what noise does, and fits scatter as predicted."""
    scene = tmp_path / "sphere.toml"
    scene.write_text(SPHERE.replace("0.045", "0.03").replace("0.7e-4", "1e-4"), "utf-8")
    one = plan.Experiment(load(scene).scene, 10e-12, math.inf, 60, 50e-9)
    w, gamma1, _ = one.predicted()
    half = replace(one, noise=5e-12).predicted()
    assert half[:2] == pytest.approx((w / 2, gamma1 / 2), rel=0.1)
    found = fit(one.scene, one.curve(3), **FAST)
    spans = [np.diff(np.log(found[name].interval))[0] / 2 for name in ("w", "gamma1")]
    assert (w, gamma1) == pytest.approx(spans, rel=0.4)
    given = ["plan", "--scene", str(scene), "--noise", "20e-12", "--points", "40"]
    assert command_line.main([*given, "--checks", "2", "--jobs", "1", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "as planned" in said and "determines w and gamma1" in said and "3 R" in said
    assert len(read(tmp_path / "sphere_plan.csv")) == 7
    with pytest.raises(ValueError, match=r"noise = .* must be positive"):
        plan.main(["--scene", str(scene), "--noise", "0"])


@pytest.mark.parametrize("name", ["fit", "read_curve", "Curve", "Reading"])
def test_help_of_public_names_has_examples_that_run(name):
    public = getattr(studies, name)
    text = inspect.getdoc(public)
    heads = ["Parameters", "Examples"] + ["Returns", "Raises"] * (public in (fit, read_curve))
    assert all(f"\n{head}\n{'-' * len(head)}\n" in text for head in heads)
    given = set(inspect.signature(public).parameters)
    assert all(f"\n{one} : " in text for one in given)
    said = []
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    assert test.examples
    doctest.DocTestRunner().run(test, out=said.append)
    assert not said, "".join(said)


def test_the_public_functions_are_the_ones_of_the_command():
    assert studies.fit is fit and studies.Curve is Curve
    assert studies.read_curve is read_curve and studies.Reading is Reading
    with pytest.raises(AttributeError, match="no attribute 'fits'"):
        _ = studies.fits


def alike(shown, told):
    """Whether a line begins with what is shown, but for the third digits of its numbers."""
    pairs = zip(re.split(r"[\s\[\],;]+", shown), re.split(r"[\s\[\],;]+", told), strict=False)
    for one, other in pairs:
        try:
            if float(one) != pytest.approx(float(other), rel=0.02):
                return False
        except ValueError:
            if one != other:
                return False
    return True


@pytest.mark.slow
def test_the_tutorial_shows_what_is_so(tmp_path, capsys, monkeypatch):
    text = (ROOT / "studies" / "README.md").read_text("utf-8")
    shown = text.partition("## From a measured curve")[2].partition("\n## ")[0]
    (command,) = (line.split()[3:] for line in shown.splitlines() if "-m studies fit stud" in line)
    monkeypatch.chdir(ROOT)
    assert command_line.main([*command, "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    lines = [line[4:].removesuffix("...").rstrip("; ") for line in shown.splitlines()]
    beginnings = ("w ", "gamma1 ", "offset ", "WARNING", "70", "springs fit", "answer: ")
    told = [line for line in lines if line.startswith(beginnings)]
    assert len(told) == 8
    for line in told:
        assert any(alike(line, row) for row in said.splitlines()), line
    data = (ROOT / "studies" / "scenes" / "sphere_curve.csv").read_text("utf-8").splitlines()
    assert all(f"    {line}\n" in shown for line in data[:3])
    assert (tmp_path / "sphere_curve_fit.png").stat().st_size > 10_000


def test_start_of_weakly_determined_parameters():
    """They lead γ₁ of this curve to 1e-4 of where it begins, for a gain of next to nothing."""
    layer = ElasticLayer(2.5e3, 0.3, 5e-6)
    surfaces = SurfaceEnergies.from_work(0.07, 6e-5)
    scene = Scene(layer, surfaces, Parabola(0.02))
    depth = np.r_[np.linspace(0, 4e-7, 100), np.linspace(4e-7, -6e-7, 200)]
    force = load_path(scene, depths=depth).force
    noise = np.random.default_rng(5).standard_normal(force.size)
    curve = Curve(depth, force + 0.005 * np.abs(force).max() * noise, math.inf)
    start = replace(scene, surfaces=SurfaceEnergies.from_work(0.05, 4e-5))
    found = fit(start, curve, **FAST)
    low, high = found["gamma1"].interval
    assert 0.02 < low < 0.07 < high < 0.3


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("opening", [None, 3e-4])
def test_legs_of_springs_without_tension_are_those_of_a_path(geometry, opening):
    opened = opening and SurfaceEnergies.from_work(0.0, opening)
    surfaces = SurfaceEnergies.from_work(0.0, 1e-4)
    scene = replace(SCENE, surfaces=surfaces, opening=opened, geometry=geometry)
    unit = scene.opened.critical_separation
    turns = [0.0, 2 * unit, 0.3 * unit, 1.5 * unit]
    for count in range(1, 5):
        leg = branches._slack_leg(scene, turns[:count], 3 * unit)
        path = load_path(scene, depths=[*turns[:count], *leg.depth[:-1:10].tolist()], rtol=1e-6)
        force = path.force[count:]
        assert np.abs(force - leg.force[:-1:10]).max() <= 1e-12 * np.abs(leg.force).max()
        if count % 2 == 0:
            assert abs(leg.depth[-1] + unit) <= 1e-12 * unit


def test_legs_of_springs_below_a_corner_are_followed():
    scene = replace(SCENE, surfaces=SurfaceEnergies.from_work(0.0, 1e-4), indenter=FlatPunch(1e-6))
    assert branches._slack_leg(scene, [0.0], 1e-7) is None


def test_a_result_in_a_sentence():
    """Values with units and half their intervals; none where the model does not fit."""
    curve = sphere(0.08)
    number = r"\d+\.\d+ ± \d+\.\d+"
    fits = rf"the model fits with w = {number} µJ/m², γ₁ = {number} mJ/m², D₀ = \S+ ± \S+ [np]m "
    assert re.fullmatch(fits + r"\(95 %\)", fit_study.result(fit(START, curve, **FAST)))
    reversed_force = curve._replace(force=-curve.force)
    said = fit_study.result(fit(START, reversed_force, **FAST))
    assert said.startswith("the model does not fit; nearest are w = ") and "±" not in said


@pytest.mark.parametrize(
    ("share", "shown"),
    [(1e-5, "0.0010 %"), (0.0182, "   1.8 %"), (0.02, "   2.0 %"), (3.456, "   346 %")],
)
def test_half_widths_are_shown_with_two_digits(share, shown):
    assert plan._percent(share) == shown
