"""The study `speed`: what it measures, what makes it fail; the random scenes that studies share."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from discretization import minimise
from studies.benchmarks import speed
from studies.shared import timing
from studies.shared.random_cases import SHAPES, random_case, random_steep_case
from studies.shared.table import read

TINY = speed.Parameters(1, (10**4,), 40, 400, (("lattice", 10),), 1, 1)


@pytest.fixture(scope="module")
def rows():
    return speed.run(TINY)


@pytest.fixture
def few(monkeypatch, rows):
    """The command with these rows, whatever they took."""
    found = [row._replace(ratio=0.5 * row.limit) for row in rows]
    monkeypatch.setattr(speed, "run", lambda p, show: found)
    return found


def test_every_answer_is_within_its_limit_of_error(rows):
    assert [row.name for row in rows] == [
        *("state, small slopes", "state, finite slopes", "nodes, 1e+04"),
        *("loop, depth", "loop, dead load", "loop, machine", "loop, nodes"),
        *("rough, 10 contacts, lattice", "import"),
    ]
    # 400 nodes leave the last link earlier than the 10⁵ for which the limit is
    assert [speed.line(row) for row in rows if not row.accurate and row.name != "loop, nodes"] == []
    assert all(row.seconds > 0 and row.ratio > 0 for row in rows)
    assert speed.STATE == {"small": (1.0, 1e-10), "finite": (10.0, 1e-9)}


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("name", ["contacts", "force", "energy"])
def test_an_error_of_1e_8_misses_the_limit(monkeypatch, slopes, name):
    def wrong(scene, depth):
        state = minimise(scene, depth)
        return replace(state, **{name: getattr(state, name) * (1 + 1e-8)})

    monkeypatch.setattr(speed, "minimise", wrong)
    row = speed.states(slopes, TINY)
    assert not row.accurate
    assert 1e-9 < row.error < (1e-5 if name == "contacts" else 1.1e-8)  # with it θ is off, too


def test_a_contact_that_is_not_found_and_a_refusal_are_infinite_errors(monkeypatch):
    case = random_case(np.random.default_rng(3), "parabola")
    lost = minimise(case.scene, -10 * case.scene.critical_separation)
    monkeypatch.setattr(speed, "minimise", lambda scene, depth: lost)
    assert speed.solved(case)[1] == math.inf

    def refuse(scene, depth):
        raise ValueError("too deep")

    monkeypatch.setattr(speed, "minimise", refuse)
    assert speed.solved(case) == (math.inf, math.inf)


def test_a_wrong_area_and_a_wrong_balance_miss_the_limit(monkeypatch):
    right = speed.load_path

    class Off:
        def __init__(self, path, area=1.0, balance=1.0):
            self.dissipated, self.held = path.dissipated * area, path
            self.factor = area * balance

        def work(self):
            return self.held.work() * self.factor

    for fault in ({"area": 1 + 3e-8}, {"balance": 1 + 3e-9}):
        wrong = lambda *a, fault=fault, **k: Off(right(*a, **k), **fault)  # noqa: E731
        monkeypatch.setattr(speed, "load_path", wrong)
        assert not speed.loop("loop, depth", TINY).accurate


def test_times_are_ratios_to_what_is_measured_beside_them(monkeypatch):
    assert timing.middle([1.0, 2.0, 3.0, 4.0, 100.0]) == (3.0, 2 / 3)
    took = iter([1.0, 4.0, 9.0])
    monkeypatch.setattr(speed, "seconds", lambda work: next(took))
    assert speed.paired(len, partial(float, "2"), 3) == (4.0, 2.0, 1.0)


@pytest.mark.usefixtures("few")
def test_a_missed_limit_of_time_decides_only_when_asked(few, tmp_path, capsys):
    given = ["--quick", "--out", str(tmp_path)]
    few[6] = few[6]._replace(error=0.0)
    assert speed.main([*given, "--strict"]) == 0
    few[0] = few[0]._replace(ratio=1.1)
    assert speed.main(given) == 0
    assert speed.main([*given, "--strict"]) == 1
    told = "missed: longer than its limit: state, small slopes\n"
    assert capsys.readouterr().out.count(told) == 2
    assert len(read(tmp_path / "speed.csv")) == 9
    few[0] = few[0]._replace(error=1e-9)
    assert speed.main(given) == 1
    assert "FAIL" in speed.line(few[0])


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
