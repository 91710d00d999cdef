"""The study `verify`: all equations, their bars and orders, what it writes, how it fails."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from discretization import Lattice
from energy import cards
from studies import verify
from studies.checks import CHECKS, convergence, curves, scenes
from studies.checks.convergence import EXACT, FIRST, SECOND, Comparison, check, refine

CELLS = (50, 100, 200, 400)
PRESET = verify.Parameters(cells=CELLS, offsets=(0.37,), points=5)


def checks_of(equation):
    return [item for item in CHECKS if equation in item.equations]


@pytest.fixture(scope="module")
def record():
    return verify.run(PRESET, jobs=2)


def artificial(error, order=SECOND, **options):
    """A check whose simulated value is off by error(cells)."""

    @check(what="artificial", order=order, **options)
    def measure(grid):
        return Comparison(2.5 * (1 + error(grid.cells)), 2.5)

    return refine(measure, CELLS, (0.0,))


def test_every_check_passes(record):
    assert not [verify.line(result) for result in record.failed]
    assert len(record.results) == len(CHECKS)


def test_every_equation_of_the_paper_has_a_check_and_the_list_is_sorted():
    numbers = [n for item in CHECKS for n in item.equations]
    assert set(numbers) == set(range(1, 41))
    assert numbers == sorted(numbers)


def test_no_two_checks_say_the_same():
    names = [(item.equations, item.what) for item in CHECKS]
    assert len(set(names)) == len(names)


def test_the_bars_are_tight_and_the_bands_narrow():
    for item in CHECKS:
        if item.order is EXACT:
            assert item.bar <= 1e-7, item
        elif item.order == SECOND:
            assert item.bar <= 5e-6, item
        else:
            assert item.order == FIRST, item
            assert item.bar <= 1e-2, item
    assert SECOND == (1.8, 2.2)
    assert FIRST == (0.85, 1.15)


def test_the_shared_scenes_obey_the_assumptions_of_the_model():
    for indenter in (scenes.PUNCH, scenes.WEDGE, scenes.PARABOLA):
        state = convergence.Grid(50).solve(scenes.gel(indenter), 0.0)
        assert state.warnings == ()


@pytest.mark.parametrize(
    ("card", "name", "equation"),
    [
        (cards.contact_line, "work_of_adhesion", 1),
        (cards.foundation, "stiffness", 3),
        (cards.tail, "elastocapillary_length", 7),
        (cards.contact_line, "angle_deficit_small", 15),
        (cards.plane, "critical_separation", 20),
        (cards.flat_punch, "adhesion_force", 23),
        (cards.wedge, "half_width", 25),
        (cards.wedge, "adhesion_force", 30),
        (cards.parabola, "half_width", 33),
        (cards.nonadhesive, "parabola_force", 40),
    ],
)
def test_a_card_wrong_by_one_percent_fails_its_check(monkeypatch, card, name, equation):
    right = getattr(card, name)
    monkeypatch.setattr(card, name, lambda *a, **k: 1.01 * right(*a, **k))
    results = [refine(item, (25, 50, 100, 200), (0.37,)) for item in checks_of(equation)]
    assert not any(result.passed for result in results)
    assert min(result.error for result in results) > 5e-3


@pytest.mark.parametrize(
    ("name", "equation"), [("force", 11), ("force", 40), ("half_width", 39), ("contacts", 16)]
)
def test_a_simulated_value_wrong_by_one_percent_fails_its_check(monkeypatch, name, equation):
    class Wrong:
        def __init__(self, state):
            self.state = state

        def __getattr__(self, asked):
            value = getattr(self.state, asked)
            return 1.01 * value if asked == name else value

    right = convergence.on_lattice
    monkeypatch.setattr(convergence, "on_lattice", lambda *a, **k: Wrong(right(*a, **k)))
    results = [refine(item, (25, 50, 100, 200), (0.37,)) for item in checks_of(equation)]
    assert not results[0].passed


def test_a_fault_of_one_percent_in_the_discrete_energy_is_seen(monkeypatch):
    geometry = {4, 31}  # what the indenter prescribes holds at any k, γ₁, w
    right, seen = Lattice.of, set()
    faults = (
        lambda true: {"k": 1.01 * true.k},
        lambda true: {"gamma1": 1.01 * true.gamma1},
        lambda true: {"w": 1.01 * true.w + 1e-6 * true.gamma1},  # also where w = 0
    )
    for fault in faults:

        def of(scene, spacing, origin=None, fault=fault):
            lattice = right(scene, spacing, origin)
            return replace(lattice, **fault(lattice))

        monkeypatch.setattr(Lattice, "of", of)
        results = [refine(item, (100,), (0.37,)) for item in CHECKS]
        seen |= {r.check.equations for r in results if r.error > 1e-3 and not r.note}
    blind = {n for item in CHECKS for n in item.equations if item.equations not in seen}
    assert blind == geometry


def test_the_engine_wants_the_order_as_well_as_the_error():
    assert artificial(lambda n: n**-2.0, bar=1e-5).passed
    assert not artificial(lambda n: n**-2.0, bar=1e-6).passed
    first = artificial(lambda n: 1e-3 / n, bar=1e-5)
    assert first.error < 1e-5
    assert first.observed_order == pytest.approx(1, abs=1e-9)
    assert not first.passed
    assert artificial(lambda n: 1e-3 / n, order=FIRST, bar=1e-5).passed
    assert not artificial(lambda n: 1e-7 + n**-2.0 / 1e3, bar=1e-5).passed
    assert not artificial(lambda n: n**-3.0, bar=1e-5).passed


def test_the_engine_judges_an_exact_quantity_on_every_grid():
    assert artificial(lambda n: 1e-15, order=EXACT).passed
    assert not artificial(lambda n: 1e-3 if n == CELLS[0] else 0.0, order=EXACT).passed


def test_the_engine_takes_the_worst_shift():
    @check(what="sawtooth")
    def measure(grid):
        return Comparison(1 + (grid.offset + 1) / grid.cells**2, 1.0)

    result = refine(measure, CELLS, (0.0, 0.5, 0.25))
    assert result.errors == pytest.approx([1.5 / n**2 for n in CELLS])


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_value_that_is_no_number_fails(value):
    result = artificial(lambda n: value)
    assert result.error == math.inf
    assert not result.passed


def test_fewer_than_four_levels_have_no_order():
    assert math.isnan(convergence.observed_order((50, 100, 200), (4e-6, 1e-6, 2.5e-7)))


def test_an_error_of_the_simulator_fails_the_check_and_is_reported():
    @check(what="breaks")
    def measure(grid):
        raise ValueError("no such depth")

    result = refine(measure, CELLS, (0.0,))
    assert not result.passed
    assert "ValueError: no such depth" in verify.line(result)


def test_a_first_order_check_has_to_name_its_bar():
    with pytest.raises(ValueError, match="bar="):
        check(what="x", order=FIRST)


def test_the_command_writes_report_table_and_figures(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(verify, "CHECKS", tuple(checks_of(25) + checks_of(20)))
    assert verify.main(["--quick", "--jobs", "1", "--out", str(tmp_path / "new")]) == 0
    out = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"2 checks: 2 passed, 0 failed; \d+\.\d s", out[-1])
    assert sum("ok" in printed for printed in out) == 2
    report = (tmp_path / "new" / "report.md").read_text("utf-8")
    links = re.findall(r"\]\((.*?)\)", report)
    assert len(links) == 4
    for link in links:
        assert (tmp_path / "new" / link).read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "new" / "verify.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["equation"] for row in rows] == ["25", "20"]
    assert rows[0]["passed"] == "True"
    assert float(rows[0]["error"]) == pytest.approx(float(rows[0]["error_400"]))
    assert 1.8 < float(rows[0]["order"]) < 2.2
    assert rows[1]["order"] == "exact"


def test_the_command_fails_with_a_broken_card(monkeypatch, tmp_path, capsys):
    right = cards.wedge.half_width
    monkeypatch.setattr(cards.wedge, "half_width", lambda *a, **k: 1.01 * right(*a, **k))
    monkeypatch.setattr(verify, "CHECKS", tuple(checks_of(25)))
    monkeypatch.setattr(verify, "plot", lambda record: {})
    assert verify.main(["--quick", "--jobs", "1", "--out", str(tmp_path)]) == 1
    assert "1 checks: 0 passed, 1 failed" in capsys.readouterr().out
    assert "**FAIL**" in (tmp_path / "report.md").read_text("utf-8")


def test_the_table_survives_bars_in_the_text(record):
    table = [row for row in verify.report(record, "").splitlines() if row.startswith("| ")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in table} == {12}
    assert len(table) == len(CHECKS) + 2


def test_the_curves_lie_on_their_closed_forms(record):
    data = record.curves
    drawn = data.meniscus
    assert np.max(np.abs(drawn.u - drawn.closed_form)) < 1e-5 * abs(drawn.depth)
    for shape in data.outside:
        assert np.max(np.abs(shape.u - shape.closed_form)) < 1e-4 * abs(shape.at_line)
    for angle in data.angles:
        order = convergence.observed_order(tuple(angle.cells), tuple(angle.errors))
        assert order == pytest.approx(2, abs=0.1)
    for case, study in zip(data.branches, curves.studies(), strict=True):
        force = np.asarray(study.force(case.depths))
        assert np.max(np.abs(case.forces - force)) < 1e-3 * np.max(np.abs(force))
        expected = np.asarray(study.half_width(case.depths))
        assert np.max(np.abs(case.half_widths - expected)) < 1e-3 * np.max(expected)
