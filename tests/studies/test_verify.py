"""The study `verify`: all equations, their bars and orders, what it writes, how it fails."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from discretization import Lattice
from energy import SurfaceEnergies, cards
from studies.shared.table import read
from studies.verify import convergence, mesh, observe
from studies.verify import study as verify
from studies.verify.checks import CHECKS, bonded
from studies.verify.checks import axisymmetric as around_axis
from studies.verify.convergence import EXACT, FIRST, SECOND, Comparison, check, refine

PRESET = replace(verify.QUICK, points=5)


LIMITS = (bonded.half_space, bonded.incompressible, bonded.springs, bonded.tension)
LAYER = (bonded.effective_length, bonded.angle, *LIMITS)


def checks_of(equation):
    return [item for item in CHECKS if equation in item.equations]


def test_every_check_passes_and_curves_lie_on_their_closed_forms():
    record = verify.run(PRESET)
    assert not [verify.line(result) for result in record.failed]
    assert len(record.results) == len(CHECKS)
    drawn = record.curves.meniscus
    assert np.max(np.abs(drawn.u - drawn.closed_form)) < 1e-5 * abs(drawn.depth)
    for one in record.curves.branches:
        for found, form in ((one.forces, one.force), (one.half_widths, one.half_width)):
            exact = np.asarray(form[0](one.depths))
            assert np.max(np.abs(found - exact)) < 1e-3 * np.max(np.abs(exact))


@pytest.mark.slow
def test_the_main_job_passes():
    """What the first command of the README runs, at all its levels and shifts of the nodes."""
    assert not [verify.line(result) for result in verify.run(verify.FULL, jobs=2).failed]


def test_every_equation_has_a_check():
    """Every equation of the paper has a check and the list is sorted."""
    numbers = [n for item in CHECKS for n in item.equations]
    assert set(numbers) == set(range(1, 41))
    assert numbers == sorted(numbers)


def test_the_bars_are_tight_and_the_bands_narrow():
    others = [item for item in CHECKS if item not in LAYER]
    most = {EXACT: 1e-7, SECOND: 5e-6, FIRST: 1e-2}
    assert all(item.bar <= most[item.order] for item in others)
    assert (SECOND, FIRST) == ((1.8, 2.2), (0.85, 1.15))
    assert {n for item in others if item.fitted_bar > 1e-8 for n in item.equations} == {8, 10}
    assert max(item.fitted_bar for item in others) <= 1e-7
    assert sum(item.fitted_bar > 1e-10 for item in others) <= 14
    assert [item.equations for item in CHECKS if item.lattice_only] == [(4,)]


def test_layer_approaches_its_limits():
    """Of a limit the error is how far away it still is, least on the fitted mesh."""
    for item in LAYER:
        assert item.bar <= 5e-2 and item.order[0] >= 0.5, item
        assert item.fitted_bar <= item.bar / 4, item
        assert (item.fitted_bar > 1e-10) == (item in LIMITS), item


ROUND = cards.axisymmetric


@pytest.mark.parametrize(
    ("card", "name", "check"),
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
        (ROUND.sphere, "displacement", around_axis.outside),
        (ROUND.cone, "radius", around_axis.place),
        (ROUND.power_law, "force", around_axis.force),
        (ROUND.sphere, "force", around_axis.whole_force),
        (ROUND.sphere, "energy", around_axis.energy),
        (ROUND.flat_punch, "force", around_axis.cylinder_force),
        (ROUND.flat_punch, "global_pull_off_depth", around_axis.cylinder_global_pull_off),
        (ROUND.sphere, "depth_without_adhesion", around_axis.sphere_without_adhesion),
        (cards.layer, "depth", bonded.effective_length),
    ],
)
def test_a_card_wrong_by_one_percent_fails_its_check(monkeypatch, card, name, check):
    right = getattr(card, name)
    monkeypatch.setattr(card, name, lambda *a, **k: 1.01 * right(*a, **k))
    for item in checks_of(check) if isinstance(check, int) else [check]:
        result = refine(item, (25, 50, 100, 200), (0.37,))
        assert not result.lattice_passed
        assert not result.fitted_passed
        assert min(result.error, result.fitted_error) > 2e-3


FAULTS = (
    lambda k, gamma1, w: (1.01 * k, gamma1, w),
    lambda k, gamma1, w: (k, 1.01 * gamma1, w),
    lambda k, gamma1, w: (k, gamma1, 1.01 * w + 1e-6 * gamma1),  # also where w = 0
)


def put_in(fault, monkeypatch):
    """What is solved has other parameters than it was given, on nodes and on the mesh."""

    def changed(scene):
        k, gamma1, w = fault(scene.stiffness, scene.gamma1, scene.work_of_adhesion)
        layer = replace(scene.layer, E=scene.layer.E * (k / scene.stiffness))
        return replace(scene, layer=layer, surfaces=SurfaceEnergies.from_work(gamma1, w))

    for name in ("minimise", "on_lattice"):
        solve = getattr(mesh, name)
        faulty = lambda s, *at, solve=solve, **o: replace(solve(changed(s), *at, **o), scene=s)  # noqa: E731
        monkeypatch.setattr(mesh, name, faulty)
    path = mesh.load_path

    def lattice(scene, *at):
        return Lattice.of(changed(scene), *at)

    monkeypatch.setattr(observe, "Lattice", SimpleNamespace(of=lattice))
    monkeypatch.setattr(mesh, "load_path", lambda scene, **o: path(changed(scene), **o))


@pytest.mark.slow
def test_fault_of_one_percent_in_the_energy_is_found():
    # what the indenter prescribes holds at any k, γ₁, w
    """A fault of one percent in the discrete energy is seen on both discretisations."""
    geometry = {"contact_field", "contact_field_by_programme", "continuity", "radius"}
    others = [item for item in CHECKS if item not in LIMITS]  # in these the fault is the limit's
    seen_on_lattice = set()
    seen_on_fitted = set()
    for fault in FAULTS:
        with pytest.MonkeyPatch.context() as patch:
            put_in(fault, patch)
            results = [r for item in others if not (r := refine(item, (100,), (0.37,))).note]
        seen_on_lattice |= {r.check for r in results if r.error > 1e-3}
        seen_on_fitted |= {r.check for r in results if r.fitted_error > 1e-3}
    for seen in (seen_on_lattice, seen_on_fitted):
        assert {item.measure.__name__ for item in others if item not in seen} == geometry


def test_the_command_writes_report_table_and_figures(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(verify, "CHECKS", tuple(checks_of(25) + checks_of(20)))
    monkeypatch.setattr(verify, "QUICK", PRESET)
    assert verify.main(["--quick", "--jobs", "1", "--out", str(tmp_path / "new")]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[-2].startswith("2 checks, 2 on both discretisations: 2 passed, 0 failed; ")
    assert out[-1] == "answer: Yes: all 2 checks pass, 2 of the paper's equations and 0 beyond."
    assert sum("ok" in printed for printed in out) == 2
    report = (tmp_path / "new" / "report.md").read_text("utf-8")
    links = re.findall(r"\]\((.*?)\)", report)
    assert links == ["fig2.png", "case_studies.png"]
    assert all((tmp_path / "new" / link).exists() for link in links)
    rows = read(tmp_path / "new" / "verify.csv")
    assert [row["equation"] for row in rows] == ["25", "20"]
    assert rows[0]["passed"] == "True"
    assert float(rows[0]["error"]) == float(rows[0]["error_400"])
    assert 1.8 < float(rows[0]["order"]) < 2.2
    assert rows[1]["order"] == "exact"
    for row in rows:
        assert 0 <= float(row["fitted_error"]) <= float(row["fitted_bar"]) == 1e-10
        assert row["lattice_only"] == ""


def test_the_command_fails_with_a_broken_card(monkeypatch, tmp_path, capsys):
    right = cards.wedge.half_width
    monkeypatch.setattr(cards.wedge, "half_width", lambda *a, **k: 1.01 * right(*a, **k))
    monkeypatch.setattr(verify, "CHECKS", tuple(checks_of(25)))
    monkeypatch.setattr(verify, "plot", lambda record: {})
    assert verify.main(["--quick", "--jobs", "1", "--out", str(tmp_path)]) == 1
    assert "1 on both discretisations: 0 passed, 1 failed" in capsys.readouterr().out
    assert " FAIL " in (tmp_path / "report.md").read_text("utf-8")


LEVELS = (50, 100, 200, 400)


def artificial(error, order=SECOND, shifts=(0.0,), **options):
    """A check on lattices whose simulated value is off by error(cells, offset)."""

    @check(what="artificial", order=order, lattice_only="artificial", **options)
    def measure(grid):
        return Comparison(2.5 * (1 + error(grid.cells, grid.offset)), 2.5)

    return refine(measure, LEVELS, shifts)


@pytest.mark.parametrize(
    ("error", "order", "options", "passes"),
    [
        (lambda n, _: n**-2.0, SECOND, {"bar": 1e-5}, True),
        (lambda n, _: n**-2.0, SECOND, {"bar": 1e-6}, False),
        (lambda n, _: 1e-3 / n, SECOND, {"bar": 1e-5}, False),
        (lambda n, _: 1e-3 / n, FIRST, {"bar": 1e-5}, True),
        (lambda n, _: 1e-7 + n**-2.0 / 1e3, SECOND, {"bar": 1e-5}, False),
        (lambda n, _: n**-3.0, SECOND, {"bar": 1e-5}, False),
        (lambda n, _: 1e-15, EXACT, {}, True),
        (lambda n, _: 1e-3 if n == LEVELS[0] else 0.0, EXACT, {}, False),
        (lambda n, _: math.nan, SECOND, {}, False),
        (lambda n, _: math.inf, SECOND, {}, False),
    ],
)
def test_the_engine_wants_the_order_as_well_as_the_error(error, order, options, passes):
    assert artificial(error, order, **options).passed == passes


def test_the_engine_takes_the_worst_shift_and_four_levels():
    result = artificial(lambda n, offset: 2.5 * (offset + 1) / n**2, shifts=(0.0, 0.5, 0.25))
    assert result.errors == pytest.approx([3.75 / n**2 for n in LEVELS], rel=1e-9, abs=0)
    assert result.observed_order == pytest.approx(2, abs=1e-9)
    turns = artificial(lambda n, offset: n + offset, EXACT, shifts=(0.0, 0.5))
    assert turns.errors == pytest.approx([50, 100.5, 200, 400.5])
    assert math.isnan(convergence.observed_order((50, 100, 200), (4e-6, 1e-6, 2.5e-7)))
    with pytest.raises(ValueError, match="bar="):
        check(what="x", order=FIRST)


def test_the_engine_wants_both_discretisations():
    """A check that is right on lattices and off by `error`, or refused, on the fitted mesh."""

    def on_fitted(error, **options):
        @check(what="breaks", order=EXACT, **options)
        def measure(where):
            fitted = isinstance(where, mesh.Fitted)
            if fitted and error is None:
                raise ValueError("no such depth")
            return Comparison(2.5 * (1 + error) if fitted else 2.5, 2.5)

        return refine(measure, LEVELS, (0.0, 0.5))

    assert on_fitted(1e-11).passed
    wrong = on_fitted(1e-9)
    assert wrong.lattice_passed
    assert not wrong.passed
    assert wrong.fitted_error == pytest.approx(1e-9, rel=1e-5, abs=0)
    assert on_fitted(1e-9, fitted_bar=2e-9).passed
    assert not on_fitted(math.nan).passed
    broken = on_fitted(None)
    assert broken.lattice_passed
    assert not broken.passed
    assert broken.fitted_error == math.inf
    assert "fitted: ValueError: no such depth" in verify.line(broken)
    alone = on_fitted(1.0, lattice_only="because")
    assert alone.passed
    assert math.isnan(alone.fitted_error)
    assert verify.fitted(alone) == "—"
    assert "because" in verify.report(verify.Record(verify.Parameters(), (alone,), None), "")
