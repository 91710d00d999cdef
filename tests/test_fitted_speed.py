"""The study `fitted_speed`: what it measures, what makes it fail, what it writes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from discretization import minimise
from energy import Plane
from studies.benchmarks import fitted_speed
from studies.benchmarks.fitted_speed import FINITE, SMALL, Parameters
from studies.shared.random_cases import SHAPES, random_case, random_steep_case
from studies.shared.table import read

PRESET = Parameters(small=4, finite=2, unknowns=1000)
LITTLE = ["--scenes", "1", "--steep", "1"]


@pytest.fixture(scope="module")
def rows():
    return fitted_speed.run(PRESET)


@pytest.fixture
def one_indenter(monkeypatch):
    makers = {"small": {"parabola": SMALL["parabola"]}, "finite": {"wedge": FINITE["wedge"]}}
    monkeypatch.setattr(fitted_speed, "MAKERS", makers)


def spoilt(monkeypatch, **changes):
    """minimise with these factors on its results."""

    def wrong(scene, depth):
        state = minimise(scene, depth)
        return replace(state, **{n: getattr(state, n) * v for n, v in changes.items()})

    monkeypatch.setattr(fitted_speed, "minimise", wrong)


def test_every_indenter_is_within_the_bars_of_error(rows):
    assert [(row.slopes, row.shape) for row in rows] == [
        *(("small", shape) for shape in SMALL),
        *(("finite", shape) for shape in FINITE),
    ]
    for row in rows:
        assert row.accurate, fitted_speed.line(row)
        assert len(row.trials) == (PRESET.small if row.slopes == "small" else PRESET.finite)
        pinned = row.shape in ("plane", "flat punch")
        assert math.isnan(row.worst[3]) == pinned
    assert fitted_speed.BARS == {"small": (1.0, 1e-10, 1e-9), "finite": (10.0, 1e-9, 1e-9)}


def test_the_scenes_differ_and_their_scales_span_decades(rows):
    lengths = [t.case.scene.elastocapillary_length for row in rows for t in row.trials]
    assert len(set(lengths)) == len(lengths)
    assert max(lengths) > 1e6 * min(lengths)


def test_times_are_ratios_to_the_tridiagonal_solves_between_them(rows):
    row = rows[1]
    trials = tuple(
        trial._replace(seconds=seconds, floor=floor)
        for trial, seconds, floor in zip(row.trials, (1, 2, 3, 30), (4, 2, 2, 1), strict=True)
    )
    row = replace(row, trials=trials)
    assert row.ratio(50) == 1.25
    assert row.ratio(100) == 15
    assert not row.fast
    quick = tuple(trial._replace(seconds=1.9) for trial in trials)
    assert replace(row, trials=quick).fast


@pytest.mark.parametrize("name", ["contacts", "force", "energy"])
def test_an_error_of_1e_8_misses_the_bar(monkeypatch, name):
    rng = np.random.default_rng(2)
    spoilt(monkeypatch, **{name: 1 + 1e-8})
    for make in (SMALL["parabola"], FINITE["parabola"]):
        case = make(rng)
        trial = fitted_speed.measure(case, 100)
        row = fitted_speed.Row(case.scene.slopes, "parabola", (trial,))
        assert not row.accurate
        assert 1e-9 < max(trial.errors[:3]) < 1.1e-8


def test_each_error_alone_misses_the_bar(rows):
    for row in (rows[3], rows[-1]):
        for i, bar in enumerate([*[row.bar.error] * 3, row.bar.angle]):
            errors = tuple(1.1 * bar * (i == j) for j in range(4))
            worse = (row.trials[0]._replace(errors=errors), *row.trials[1:])
            assert not replace(row, trials=worse).accurate


def test_a_contact_that_is_not_found_is_an_error_of_all_and_a_refusal_is_infinite(monkeypatch):
    case = SMALL["parabola"](np.random.default_rng(3))
    lost = fitted_speed.minimise(case.scene, -10 * case.scene.critical_separation)
    monkeypatch.setattr(fitted_speed, "minimise", lambda scene, depth: lost)
    assert fitted_speed.measure(case, 100).errors == (1.0, 1.0, 1.0, math.inf)

    def refuse(scene, depth):
        raise ValueError("too deep")

    monkeypatch.setattr(fitted_speed, "minimise", refuse)
    trial = fitted_speed.measure(case, 100)
    assert trial.errors == (math.inf,) * 4
    assert "1 not solved, first: ValueError: too deep" in fitted_speed.line(
        fitted_speed.Row("small", "parabola", (trial,))
    )


@pytest.mark.usefixtures("one_indenter")
def test_a_missed_bar_of_time_decides_only_when_asked(monkeypatch, tmp_path, capsys):
    little = [*LITTLE, "--out", str(tmp_path)]
    monkeypatch.setattr(fitted_speed, "tridiagonal_seconds", lambda n, repeats: 1e-9)
    assert fitted_speed.main(little) == 0
    assert fitted_speed.main([*little, "--strict"]) == 1
    told = "missed: 2 of 2 kinds of scenes take longer than their limit\n"
    assert capsys.readouterr().out.count(told) == 2
    monkeypatch.setattr(fitted_speed, "tridiagonal_seconds", lambda n, repeats: 1e9)
    assert fitted_speed.main([*little, "--strict"]) == 0


@pytest.mark.usefixtures("one_indenter")
def test_a_missed_bar_of_error_fails_the_command_and_the_table_shows_it(
    monkeypatch, tmp_path, capsys
):
    spoilt(monkeypatch, force=1 + 1e-6)
    assert fitted_speed.main([*LITTLE, "--out", str(tmp_path)]) == 1
    assert capsys.readouterr().out.count("FAIL") == 2
    table = read(tmp_path / "fitted_speed.csv")
    assert [(row["slopes"], row["indenter"]) for row in table] == [
        ("small", "parabola"),
        ("finite", "wedge"),
    ]
    for row in table:
        assert 1e-7 < float(row["error_force"]) < 1.1e-6
        assert float(row["error_energy"]) < 1e-10
        assert float(row["seconds"]) > 0 < float(row["dptsv_seconds"])


def test_a_sample_of_none_is_refused(capsys):
    with pytest.raises(SystemExit):
        fitted_speed.main(["--steep", "0"])
    assert "--steep 0 is no sample" in capsys.readouterr().err


def test_the_plane_holds_down_to_the_critical_separation():
    rng = np.random.default_rng(4)
    held = set()
    for _ in range(20):
        case = fitted_speed.plane_case(rng)
        assert isinstance(case.scene.indenter, Plane)
        above = case.depth >= -case.scene.critical_separation
        assert case.half_width == (math.inf if above else 0)
        held.add(above)
    assert held == {True, False}


@pytest.mark.parametrize("shape", SHAPES)
def test_random_cases_obey_the_ranges_they_state(shape):
    rng = np.random.default_rng(5)
    for _ in range(50):
        for case, lo, hi in (
            (random_case(rng, shape), 10**-1.5, 10**1.5),
            (random_steep_case(rng, shape), 0.1, 10),
        ):
            ell = case.scene.elastocapillary_length
            assert lo * (1 - 1e-9) <= case.half_width / ell <= hi * (1 + 1e-9)
            assert ell * (1 + 1e-9) >= 1e-4 and ell <= 1e4 * (1 + 1e-9)
        ratio = case.scene.work_of_adhesion / case.scene.gamma1
        assert 1e-3 * (1 - 1e-9) <= ratio <= 0.8 * (1 + 1e-9)
        if shape != "flat":
            slope = float(case.scene.indenter.slope(case.half_width))
            assert 0.02 * (1 - 1e-9) <= slope <= 1 + 1e-9
