"""The work-precision study: its rivals solve the problem, its guard notices a loss."""

import math
import time

import numpy as np
import pytest

from studies.benchmarks import runtime_report as report
from studies.benchmarks import runtime_vs_error as study
from studies.benchmarks.rivals import problem
from studies.benchmarks.rivals.problem import Method
from studies.benchmarks.rivals.tasks import TASKS

SLOW = ((10**3, 0.01), (10**4, 10.0))
TINY = study.Parameters(sizes=(400,), patience=0.02, repeats=2, steps=20)
WIDTH = {  # relative error of a that each rival must reach with 400 nodes
    "ours": 1e-4,
    "active set": 1e-3,
    "PIQP": 1e-3,
    "cvxpy": 5e-3,
    "scipy L-BFGS-B": 1e-3,
    "one line by hand": 3e-3,
    "scipy solve_bvp": 1e-3,
}


@pytest.fixture(scope="module")
def points():
    return study.run(TINY)


def test_every_method_of_every_task_was_measured_or_says_why_not(points):
    for name in TASKS:
        methods = {p.method for p in points if p.task == name}
        assert methods == {m.name for m in TASKS[name](10).methods}
    for p in points:
        assert p.note or (p.seconds > 0 and p.ratio > 0 and p.unknowns > 0 and p.spread >= 0)
        assert "not installed" in p.note or not p.note


def test_rivals_solve_the_same_problem(points):
    checked = 0
    for p in points:
        for start, bar in WIDTH.items():
            if p.method.startswith(start) and not p.note and p.task != "rough":
                rtol = p.size if p.size < 1 else 0.0
                # contacts of less than a link, and around an axis those about to detach
                lone = 3e-3 if p.task.endswith("loop") else 0.0
                assert p.errors[0] <= max(bar, rtol, lone), p
                checked += 1
    assert checked > 20


@pytest.mark.parametrize("name", ["nonadhesive", "adhesive", "finite"])
def test_the_default_method_reaches_its_digits(name):
    """However long it takes: `points` leave out what is slow."""
    task = TASKS[name](TINY.steps)
    (method,) = (method for method in task.methods if method.name == "ours, default")
    for rtol in (1e-10, 1e-12):
        assert max(task.errors(method.make(task, rtol)[0]())) <= 1e-10


def test_a_nested_active_set_is_of_second_order():
    task = TASKS["nonadhesive"](1)
    (method,) = (m for m in task.methods if m.name == "active set, nested grids")
    errors = [task.errors(method.make(task, n)[0]())[0] for n in (500, 1000, 2000, 4000, 8000)]
    slope = np.polyfit(np.log([500, 1000, 2000, 4000, 8000]), np.log(errors), 1)[0]
    assert -2.6 < slope < -1.4
    assert errors[-1] < 2e-6


def test_absent_packages_are_skipped_with_a_word(monkeypatch):
    monkeypatch.setattr(study, "installed", lambda name: name != "pyscipopt")
    found = study.run(TINY, ["rough"])
    (absent,) = (p for p in found if p.note)
    assert absent.note == "pyscipopt not installed"
    assert not absent.success and math.isnan(absent.seconds)
    assert not problem.installed("a_package_nobody_has")


def test_a_size_that_would_take_for_ever_is_left_out():
    made = [study.Point.failed("t", "m", 0, "")._replace(size=n, seconds=t) for n, t in SLOW]
    assert study.expected(made[:1], 10**4) == pytest.approx(100 * SLOW[0][1], rel=1e-13, abs=0)
    assert study.expected(made, 10**5) == pytest.approx(1e3 * SLOW[1][1], rel=1e-12, abs=0)
    assert study.expected(made, 1e-8) == SLOW[1][1]  # a tolerance
    sizes = []

    def prepare(task, size):
        sizes.append(size)
        return (lambda: time.sleep(0.003) or problem.Answer(1.0, 1.0, 1.0, 1.0)), 100

    task = TASKS["adhesive"](1)
    method = Method("slow", prepare)
    study._grown(study.Parameters((10, 100, 1000), patience=0.05, repeats=1), len, (task, method))
    assert sizes == [10]


def test_time_to_an_error_counts_only_success_and_only_what_reached_it():
    blank = study.Point.failed("t", "ours, lattice", 0, "")._replace(note="")

    def point(method, seconds, error, success=True):
        errors = (error, 0.0, 0.0, 0.0)
        return blank._replace(method=method, seconds=seconds, errors=errors, success=success)

    points = [point("ours, lattice", 1e-3, 1e-5), point("ours, lattice", 4e-3, 1e-11)]
    points += [point("slow", 2e-2, 1e-5), point("slow", 1e-3, 1e-9, success=False)]
    assert set(report.reached(points, 1e-4)) == {"ours, lattice", "slow"}
    assert set(report.reached(points, 1e-8)) == {"ours, lattice"}
    *_, ours, slow = report.levels(points).splitlines()
    assert ours == "| ours, lattice | 1 ms | 4 ms | 4 ms | 4 ms |"
    assert slow == "| slow | 20 ms, × 20 | never | never | never |"


def test_the_command_writes_table_csv_and_figures(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(study, "QUICK", TINY)
    assert study.main(["--quick", "--tasks", "finite", "rough", "--out", str(tmp_path)]) == 0
    text = (tmp_path / "runtime_vs_error.md").read_text("utf-8")
    assert text in capsys.readouterr().out
    assert "cores" in text and "### floors" in text
    rows = (tmp_path / "runtime_vs_error.csv").read_text("utf-8").splitlines()
    assert len({row.count(",") for row in rows if row[0] != "#" and '"' not in row}) == 1
    assert (tmp_path / "runtime_vs_error.png").stat().st_size > 20_000
