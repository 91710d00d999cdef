"""The studies of run time against error and of stability under stress, errors and estimates."""

import functools
import math
import os
import re
import subprocess
import sys
import time
from collections import Counter
from dataclasses import replace
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest
from support.example_scenes import plain
from support.repository import ROOT

import discretization
from discretization import minimise
from energy import Parabola
from studies.benchmarks import runtime_report, skipping
from studies.benchmarks import runtime_vs_error as study
from studies.benchmarks.rivals import problem, solvers
from studies.benchmarks.rivals.problem import Method
from studies.benchmarks.rivals.tasks import TASKS
from studies.benchmarks.stress import reference as stress_reference
from studies.benchmarks.stress import study as stress
from studies.benchmarks.stress.verdicts import estimated
from studies.shared import timing
from studies.shared.random_cases import random_case, random_steep_case

TINY = study.Parameters(sizes=(400,), patience=0.02, repeats=2, steps=12)
WIDTH = {  # relative error of a that each rival must reach with 400 nodes
    "ours": 1e-4,
    "active set": 1e-3,
    "cvxpy": 5e-3,
    "scipy L-BFGS-B": 1e-3,
    "one line by hand": 3e-3,
    "scipy solve_bvp": 1e-3,
}


SHORT = [name for name in TASKS if name != "rough loop"]
points = functools.cache(lambda *tasks: study.run(TINY, tasks))


@pytest.mark.parametrize("tasks", [SHORT, pytest.param(["rough loop"], marks=pytest.mark.slow)])
def test_every_method_of_every_task_was_measured_or_says_why_not(tasks):
    for name in tasks:
        methods = {p.method for p in points(*tasks) if p.task == name}
        assert methods == {m.name for m in TASKS[name](10).methods}
    for p in points(*tasks):
        assert p.note or (p.seconds > 0 and p.ratio > 0 and p.unknowns > 0 and p.spread >= 0)
        assert "not installed" in p.note or not p.note


def test_rivals_solve_the_same_problem():
    checked = 0
    for p in points(*SHORT):
        for start, bar in WIDTH.items():
            if p.method.startswith(start) and not p.note and "rough" not in p.task:
                rtol = p.size if p.size < 1 else 0.0
                # contacts of less than a link, and around an axis those about to detach
                lone = 3e-3 if p.task.endswith("loop") else 0.0
                assert p.errors[0] <= max(bar, rtol, lone), p
                checked += 1
    assert checked > 12


@pytest.mark.parametrize("name", ["nonadhesive", "adhesive", "finite"])
def test_the_default_method_reaches_its_digits(name):
    """However long it takes: `points` leave out what is slow."""
    task = TASKS[name](TINY.steps)
    (method,) = (method for method in task.methods if method.name == "ours, default")
    for rtol in (1e-10, 1e-12):
        assert max(task.errors(method.make(task, rtol)[0]())) <= 1e-10


def test_absent_packages_are_skipped_with_a_word(monkeypatch):
    monkeypatch.setattr(study, "installed", lambda name: name != "pyscipopt")
    found = study.run(TINY, ["rough"])
    (absent,) = (p for p in found if p.note)
    assert absent.note == "pyscipopt not installed"
    assert not absent.success
    assert math.isnan(absent.seconds)
    assert not problem.installed("a_package_nobody_has")


def test_a_size_that_would_take_for_ever_is_left_out():
    blank = study.Point.failed("t", "m", 0, "")
    slow = ((10**3, 0.01), (10**4, 10.0))
    made = [blank._replace(size=n, seconds=t) for n, t in slow]
    assert study.expected(made[:1], 10**4) == pytest.approx(1.0, rel=1e-13, abs=0)
    assert study.expected(made, 10**5) == pytest.approx(1e4, rel=1e-12, abs=0)
    assert study.expected(made, 1e-8) == 10.0  # a tolerance
    sizes = []

    def prepare(task, size):
        sizes.append(size)
        return (lambda: time.sleep(0.003) or problem.Answer(1.0, 1.0, 1.0, 1.0)), 100

    task = TASKS["adhesive"](1)
    method = Method("slow", prepare)
    study._grown(study.Parameters((10, 100, 1000), patience=0.05, repeats=1), len, (task, method))
    assert sizes == [10]


def test_a_task_with_one_point_a_method_is_not_drawn():
    blank = study.Point.failed("loop", "ours, default", 0, "")
    pair = [blank._replace(size=n, seconds=1e-3 * n, errors=(1e-8,) * 4) for n in (1, 2)]
    lone = [blank._replace(task="many", method=m, seconds=1.0) for m in ("ours, default", "b")]
    absent = blank._replace(task="many", method="b", note="not installed")
    assert runtime_report.curves([*pair, *lone, absent]) == pair
    figure = runtime_report.plot([*pair, *lone], {1000: 1e-4})
    assert len(figure.axes) == 1
    box = figure.get_tightbbox()  # the title is wider than one panel
    assert box.x0 >= 0
    assert box.x1 <= figure.get_size_inches()[0]


def test_no_two_methods_of_others_are_drawn_alike():
    methods = {m.name for name in TASKS for m in TASKS[name](TINY.steps).methods}
    kinds = list(dict.fromkeys(runtime_report.family(m) for m in sorted(methods)))
    others = [kind for kind in kinds if not kind.startswith("ours")]
    drawn = [runtime_report._style(kind, kinds.index(kind)) for kind in others]
    assert len({(style["marker"], style["color"]) for style in drawn}) == len(others) > 6


def test_banners_of_solvers_are_dropped(capfd):
    with solvers.without_banner():
        os.write(1, b"a banner")
    os.write(1, b"shown")
    assert capfd.readouterr().out == "shown"


@pytest.mark.slow
def test_the_command_writes_table_csv_and_figures(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(study, "QUICK", TINY)
    assert study.main(["--quick", "--tasks", "finite", "rough", "--out", str(tmp_path)]) == 0
    text = (tmp_path / "runtime_vs_error.md").read_text("utf-8")
    assert text in capsys.readouterr().out
    assert "cores" in text
    assert "### a state with steep surfaces" in text
    assert "| a to 1e-06 |" in text
    assert "by ours, shortest path (lattice)" in text
    rows = (tmp_path / "runtime_vs_error.csv").read_text("utf-8").splitlines()
    assert len({row.count(",") for row in rows if row[0] != "#" and '"' not in row}) == 1
    assert (tmp_path / "runtime_vs_error.png").stat().st_size > 20_000


TINY_STRESS = stress.Parameters(stride=3, nodes=2000, scenes=20, lattices=8)


@pytest.fixture(scope="module")
def trials():
    return stress.run(TINY_STRESS)


@pytest.mark.parametrize("draw", [random_case, random_steep_case])
@pytest.mark.parametrize("shape", ["parabola", "flat"])
def test_the_reference_agrees_with_the_cards(draw, shape):
    rng = np.random.default_rng(4)
    for _ in range(20):
        case = draw(rng, shape)
        with localcontext(prec=stress_reference.DIGITS):
            given = stress_reference.inputs(case.scene, case.depth)
            exact = stress_reference.answer(given, case.scene.slopes)
        assert float(exact.half_width) == pytest.approx(case.half_width, rel=1e-10, abs=0)
        size = abs(case.force) + case.scene.stiffness * abs(case.depth) * case.half_width
        assert float(exact.force) == pytest.approx(case.force, rel=0, abs=1e-10 * size)
        size = case.scene.work_of_adhesion * case.half_width + abs(case.energy)
        assert float(exact.energy) == pytest.approx(case.energy, rel=0, abs=1e-10 * size)


def test_the_reference_refuses_what_it_has_no_closed_form_for():
    given = {name: Decimal(1) for name in ("k", "gamma1", "w")}
    with pytest.raises(ValueError, match="2l"):
        stress_reference.answer(given | {"d": Decimal(3), "a": Decimal(1)}, "finite")
    with pytest.raises(ValueError, match="parabola"):
        stress_reference.answer(
            given | {"d": Decimal(0), "c": Decimal(1), "n": Decimal(3)}, "finite"
        )


def test_nothing_is_lost_and_what_is_not_kept_has_its_reason(trials):
    """Both verdicts pass only within rounding of letting go; few states are refused."""
    assert not [t for t in trials if t.verdict in stress.BAD]
    assert {t.grid for t in trials} == set(stress.GRIDS)
    words = ("detachment", "contact or not")
    tied = [t for t in trials if t.verdict == "ok" and any(word in t.note for word in words)]
    assert {(t.grid, t.shape) for t in tied} == {("edge", "flat")}
    assert all(t.x >= 15 for t in tied)  # 4.5 ε; 450 ε must be decided
    few = [t for t in stress.exact(trials) if min(t.digits) < stress.KEPT]
    assert few
    assert all("condition" in t.note for t in few)
    told = stress.summary("edge", [t for t in trials if t.grid == "edge"])
    assert "keep 12" in told
    assert "ε (1 + condition)" in told
    for t in trials:
        if t.grid in ("fitted", "finite", "lattice") and not math.isnan(t.digits[0]):
            assert min(t.digits) >= 11.9 or t.excess <= 1, t
        if t.verdict == "refused":
            fine = t.grid == "lattice" and t.x >= 5 and "violates force" in t.note
            coarse = t.grid == "nodes" and t.x < math.log10(50)
            assert fine or coarse or (t.grid == "finite" and "turn over" in t.note), t


def test_too_small_estimate_of_a_lattice_state_fails():
    """An estimate of a lattice state that is too small is wrong."""
    scene = plain(Parabola(10.0))
    state = minimise(scene, 0.3, method="lattice", spacing=0.05)
    assert stress.untrusted(scene, 0.3, state) == ""
    bold = replace(state, errors={**state.error_estimate, "energy": 1e-7})
    assert stress.untrusted(scene, 0.3, bold).startswith("U is off by ")
    withheld = replace(state, errors=dict.fromkeys(state.error_estimate, math.inf))
    assert stress.untrusted(scene, 0.3, withheld) == ""


def test_verdicts():
    for digits, conditions, same, word in (
        ((1e-15, 0, 0), (1, 1, 1), True, "ok"),
        ((1e-11, 0, 0), (1, 1, 1), True, "lost"),
        ((1e-11, 0, 0), (1e5, 1, 1), True, "ok"),
        ((1e-15, 0, 0), (1, 1, 1), False, "wrong"),
    ):
        assert stress.verdict(digits, conditions, same)[2] == word

    def overflow():
        np.float64(1e300) * np.float64(1e300)
        raise AssertionError

    def underflow():
        np.exp(np.float64(-800.0))
        return (16.0,) * 3, 0.0, "ok", ""

    assert stress.judged("edge", "x", 0, 0, overflow).verdict == "floating point"
    assert stress.judged("edge", "x", 0, 0, lambda: int(None)).verdict == "crash"
    harmless = stress.judged("edge", "x", 0, 0, underflow)
    assert harmless.verdict == "ok"
    assert "underflow" in harmless.note


def test_rtol_and_estimates_against_errors():
    """Rtol is honoured and no estimate is below a tenth of the error."""
    trials = stress.run(stress.Parameters(scenes=125), ["random"])
    assert [t.verdict for t in trials] == ["ok"] * 125


def test_digits_are_drawn_against_those_expected():
    """The limit is 12 digits, 1000 ε (1 + c) where that is more, and 9 digits in other units."""
    blank = stress.Trial("fitted", "x1", 0, 0, (13.0, 14.0, 15.0), 4e3, "ok", "")
    assert blank.margin == pytest.approx(1.0, rel=1e-12)
    badly_posed = blank._replace(digits=(3.0, 14.0, 15.0), excess=10.0)
    assert badly_posed.margin == pytest.approx(2.0, rel=1e-12)
    lost = blank._replace(digits=(3.0, 14.0, 15.0), excess=1e5)
    assert lost.margin == pytest.approx(-2.0, rel=1e-12)
    other_units = blank._replace(grid="profiles", digits=(8.0, 14.0, 15.0), excess=1e-8)
    assert other_units.margin == pytest.approx(-1.0, rel=1e-12)
    assert math.isnan(blank._replace(digits=(math.nan,) * 3).margin)


def test_no_point_that_passes_lies_below_the_limit(trials):
    judged = [t for t in trials if t.grid not in stress.SCATTERED and not math.isnan(t.margin)]
    assert len(judged) > 50
    assert min(t.margin for t in judged if t.verdict == "ok") >= 0


@pytest.mark.parametrize(
    ("errors", "estimates", "where", "rtol", "word"),
    [
        ((1e-8, 0.0, 0.0), (9e-10, 1.0, 1.0), "mesh", 1e-6, "wrong"),
        ((1e-8, 0.0, 0.0), (1.1e-9, 1.0, 1.0), "mesh", 1e-6, "ok"),
        ((9e-16, 0.0, 0.0), (0.0, 0.0, 0.0), "mesh", 1e-6, "ok"),
        ((1.1e-15, 0.0, 0.0), (0.0, 0.0, 0.0), "mesh", 1e-6, "wrong"),
        ((9e-14, 0.0, 0.0), (0.0, 0.0, 0.0), "nodes", math.inf, "ok"),
        ((1.1e-13, 0.0, 0.0), (0.0, 0.0, 0.0), "nodes", math.inf, "wrong"),
        ((0.0, 0.0, 1.1e-6), (1.0, 1.0, 1.0), "mesh", 1e-6, "lost"),
        ((0.0, 0.0, 0.9e-12), (1.0, 1.0, 1.0), "mesh", 1e-13, "ok"),
        ((0.0, 0.0, 1.1e-12), (1.0, 1.0, 1.0), "mesh", 1e-13, "lost"),
    ],
)
def test_errors_beyond_rtol_and_estimates_below_a_tenth_are_bad(
    errors, estimates, where, rtol, word
):
    assert estimated(errors, estimates, where, rtol)[2] == word
    assert (word in stress.BAD) == (word != "ok")


@pytest.mark.slow
def test_estimates_of_lattice_states(tmp_path, monkeypatch, capsys):
    """None is below a tenth of the error or far too large; one that is off fails the study."""
    sparse = stress.run(stress.Parameters(lattices=30, seed=5), ["nodes"])
    words = Counter(t.verdict for t in sparse)
    assert set(words) <= {"ok", "withheld", "refused"}
    assert sum(words.values()) == 30
    assert words["ok"] >= 24
    assert words["withheld"] >= 1
    assert all(10**t.x < 50 for t in sparse if t.verdict == "refused")
    links = [float(t.note.split()[0]) for t in sparse if t.verdict == "withheld"]
    assert max(links) < 8
    assert 0.3 <= np.median([t.excess for t in sparse if t.verdict == "ok"]) <= 1
    wrong = sparse[0]._replace(verdict="wrong")
    for found, status in ((sparse, 0), ([*sparse, wrong], 1)):
        monkeypatch.setattr(stress, "run", lambda *_, found=found: found)
        assert stress.main(["--quick", "--grids", "nodes", "--out", str(tmp_path)]) == status
    assert "trusted in 30 of 31 random scenes" in capsys.readouterr().out


def test_the_verdict_says_with_how_many_threads_it_was_measured(monkeypatch):
    code = (
        "import studies.__main__, os; from studies.shared.timing import blas_threads;"
        "print(blas_threads(), os.environ['MKL_NUM_THREADS'])"
    )
    given = {**os.environ, "OPENBLAS_NUM_THREADS": "7", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=given, capture_output=True, text=True, check=True)
    assert done.stdout == "one thread 1\n"
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    assert timing.blas_threads() == "as many threads as it takes"


ROUTES = skipping.routes()
# heights of the profile: most with the skip, least by the general route
SAVED = {"other contacts": (1_000, 2_000), "error estimate": (22_000, 50_000)}


@pytest.mark.parametrize("name", ROUTES)
def test_a_skip_changes_no_digit_and_saves_work(name, monkeypatch):
    counted = [0]
    right = Parabola.height

    def height(self, x):
        counted[0] += np.size(x)
        return right(self, x)

    monkeypatch.setattr(Parabola, "height", height)
    skips, general = skipping.routes()[name]
    skips()
    counted[0] = 0
    found = skips()
    cost = counted[0]
    counted[0] = 0
    assert skipping.difference(found, general()) <= 1e-13
    if name in SAVED:
        assert cost <= SAVED[name][0]
        assert counted[0] >= SAVED[name][1]


def test_every_row_stands_in_the_readme():
    readme = Path(discretization.__file__).with_name("README.md").read_text("utf-8")
    told = readme.split("## Work that is skipped automatically")[1].split("\n## ")[0]
    factors = re.findall(r"\| ([\d.; ]+) \|$", told, re.M)
    assert sum(len(row.split(";")) for row in factors) == len(ROUTES)


def test_benchmark_rows_and_changed_digits(tmp_path, capsys, monkeypatch):
    """The study measures every row and fails where a digit changes."""
    monkeypatch.setattr(skipping, "QUICK", skipping.Parameters(2, 0.0))
    few = {name: ROUTES[name] for name in ("far field", "fields")}
    command = ["--quick", "--out"]
    monkeypatch.setattr(skipping, "routes", lambda: few)
    assert skipping.main([*command, str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "leaving out 2 things" in said
    assert "none changes a digit" in said
    assert (tmp_path / "skipping.png").stat().st_size > 10_000
    numbers = np.array([1.3e-4, 2.1, -3e-5])
    few["wrong"] = lambda: numbers, lambda: numbers * [1 + 1e-11, 1, 1]
    assert skipping.main([*command, str(tmp_path)]) == 1
    assert "these change a digit: wrong." in capsys.readouterr().out


def test_each_shape_is_tried_in_all_units_and_at_all_ratios_of_poisson():
    tried = [(shape, work.args[0].layer) for shape, _, _, work in stress.fitted(stress.QUICK)]
    scales = {round(math.log10(layer.h)) for _, layer in tried}
    for shape in stress.SHAPES:
        own = [layer for name, layer in tried if name == shape]
        assert {round(math.log10(layer.h)) for layer in own} == scales
        assert {layer.nu for layer in own} == set(stress.POISSON)
    assert len(scales) == len(stress.UNITS)


def test_detachment_is_approached_from_both_sides_of_the_same_depth():
    points = list(stress.edge(stress.QUICK))
    for (shape, j, side, before), (_, _, _, beyond) in zip(points[::2], points[1::2], strict=True):
        scene, depth = before.args
        assert side == 1
        apart = (depth - beyond.args[1]) / scene.critical_separation
        assert apart == pytest.approx(2 * 10.0**-j, rel=1e-12, abs=4e-16), shape
