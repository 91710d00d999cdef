"""The studies of load paths: loops and pull-off against the cards, their figures and files."""

import math
from dataclasses import replace

import numpy as np
import pytest

from discretization.plots import legs
from discretization.plots import plot_path as figure
from energy import Parabola, Wedge
from studies.hysteresis import study as hysteresis
from studies.pull_off import study as pull_off
from studies.shared import loops
from studies.shared.loops import INDENTERS, LAYER, LIFT, SIZE, WORK, Form
from studies.shared.table import read

LITTLE = hysteresis.QUICK
FEW = pull_off.Parameters(ratios=(0.1, 0.3, 0.8, 1.7, 4.0))


@pytest.fixture(scope="module")
def record():
    return hysteresis.run(LITTLE)


@pytest.fixture(scope="module")
def pulls():
    return pull_off.run(FEW)


@pytest.fixture(scope="module")
def parabola(record):
    return hysteresis.featured(record)


def test_every_loop_agrees_with_the_cards_and_its_energy_balances(record):
    assert len(record.loops) == len(INDENTERS) * 2 * 3
    assert {loop.history.control for loop in record.loops} == {"depth", "force", "drive"}
    for loop in record.loops:
        assert loop.error <= 1e-8, (hysteresis.line(loop), loop.forms)
        assert loop.imbalance <= 1e-9, hysteresis.line(loop)
    assert record.passed
    assert (hysteresis.BAR, hysteresis.LEDGER) == (1e-8, 1e-9)


def test_the_loops_are_those_of_the_formulas(record):
    areas = {
        (loop.shape, loop.control, loop.history.scene.gamma1): loop.history.dissipated
        for loop in record.loops
    }
    for gamma1 in LITTLE.tensions:
        length = math.sqrt(gamma1 / LAYER.stiffness)
        for control in ("depth", "force"):
            found = areas["flat punch", control, gamma1]
            assert found == pytest.approx(2 * WORK * (SIZE + length), rel=1e-9, abs=0)
    sharp = areas["wedge", "depth", 0.4]
    assert abs(sharp) < 1e-12 * WORK * SIZE
    for shape in ("wedge", "parabola"):
        assert areas[shape, "force", 0.02] > 1.05 * areas[shape, "depth", 0.02]


def test_a_wrong_number_or_imbalance_fails(record):
    loop = record.loops[0]
    off = loop.forms[0]._replace(simulated=loop.forms[0].closed_form + 2e-8 * loop.forms[0].scale)
    wrong = replace(loop, forms=(off, *loop.forms[1:]))
    lost = replace(loop, work=loop.work * (1 + 2e-9))
    missing = replace(loop, forms=(off._replace(simulated=math.nan), *loop.forms[1:]))
    for one in (wrong, lost, missing):
        assert not one.passed
        assert hysteresis.line(one).endswith("FAIL")
        assert not replace(record, loops=(one,)).passed


def test_errors_are_relative_to_the_closed_form_unless_it_is_zero():
    assert Form("", 2.02, 2.0, 1e3).error == pytest.approx(0.01, rel=1e-12, abs=0)
    assert Form("", 0.02, 0.0, 4.0).error == pytest.approx(0.005, rel=1e-12, abs=0)


def test_all_indenters_have_the_size_they_are_compared_at():
    for shape in INDENTERS:
        assert loops.size(loops.scene_of(shape, 0.1)) == pytest.approx(SIZE, rel=1e-12, abs=0)
    assert pytest.approx(math.sqrt(2 * WORK / LAYER.stiffness), rel=1e-12, abs=0) == LIFT


def test_legs_go_one_way_and_jumps_lie_on_the_line_of_the_control(record):
    for loop in record.loops:
        history = loop.history
        K = history.machine_stiffness
        for leg in legs(history):
            steps = np.diff(leg.depth)
            assert np.all(np.isfinite(leg.depth))
            if leg.kind in ("loading", "unloading"):
                assert np.all(steps > 0 if leg.kind == "loading" else steps < 0)
            elif leg.kind == "jump":
                held = leg.force[:2] + (K or 0.0) * leg.depth[:2]
                slip = abs(held[1] - held[0])
                assert history.control == "depth" or slip <= 1e-9 * loops.force_scale(history.scene)
        jumps = [leg for leg in legs(history) if leg.kind == "jump"]
        sharp = loop.shape == "wedge" and history.scene.gamma1 == 0.4
        assert len(jumps) == 2
        assert (abs(jumps[0].half_width[-1]) < 1e-9 * SIZE) == sharp


def test_the_area_between_the_drawn_jumps_is_the_loop(record):
    """∮P dd of the polygon that is drawn, by trapezoids: coarse, but a wrong jump shows."""
    for loop in record.loops:
        drawn = sum(
            float(np.sum((leg.force[1:] + leg.force[:-1]) / 2 * np.diff(leg.depth)))
            for leg in legs(loop.history)
        )
        size = 2 * WORK * SIZE
        assert drawn == pytest.approx(loop.history.dissipated, rel=0.02, abs=0.02 * size)


def test_figures_tell_loading_from_unloading_and_mark_the_events(parabola):
    axes = figure(parabola, "a parabola", ([0, 1e-6], [0, 1e-3], [0, 1e-5])).axes
    labels = [text.get_text() for text in axes[0].get_legend().get_texts()]
    assert {"closed form", "loading", "unloading", "jump-in", "detachment"} <= set(labels)
    assert axes[0].get_xlabel() == "depth d in µm"
    assert axes[0].get_ylabel() == "force P in mN/m"
    assert axes[1].get_ylabel() == "half-width a in µm"
    dashed = [line for line in axes[0].lines if line.get_linestyle() == "--"]
    drawn = [line.get_xydata() for line in dashed if len(line.get_xdata())]
    assert [data[0, 0] for data in drawn] == pytest.approx([0, -1e6 * LIFT], rel=1e-9, abs=1e-9)


def test_the_command_writes_everything(record, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(hysteresis, "run", lambda preset, show, jobs: record)
    assert hysteresis.main(["--quick", "--out", str(tmp_path)]) == 0
    assert "0 failed" in capsys.readouterr().out
    for name in ("control", "loop"):
        assert (tmp_path / f"hysteresis_{name}.png").stat().st_size > 2e4
    rows = read(tmp_path / "hysteresis.csv")
    assert len(rows) == len(record.loops)
    for row, loop in zip(rows, record.loops, strict=True):
        assert float(row["dissipated"]) == loop.history.dissipated
        assert float(row["work"]) == loop.work
        assert float(row["pull-off_force"]) <= 0


def test_pull_off_agrees_with_the_paper_and_the_parabola_law(pulls):
    for curve in pulls:
        assert curve.ratios.tolist() == [0.0, *FEW.ratios]
        assert curve.error <= 1e-8, curve.shape
    flat, wedge, parabola = (curve.forces for curve in pulls)
    ratios = np.array([0.0, *FEW.ratios])
    unit = 2 * WORK * SIZE / LIFT  # k δ₀ b
    assert flat == pytest.approx(2 * unit * (1 + ratios), rel=1e-8, abs=0)
    expected = unit * np.maximum(1 - ratios**2, 0)
    assert np.max(np.abs(wedge - expected)) < 1e-8 * unit
    law = np.where(ratios <= 1, 4 / 3 + 2 / 3 * ratios**3, 2 * ratios)
    assert parabola == pytest.approx(unit * law, rel=1e-8, abs=0)


def test_tension_helps_the_punch_and_the_parabola_and_weakens_the_wedge(pulls):
    flat, wedge, parabola = pulls
    assert pull_off.trend(flat.forces) == pull_off.trend(parabola.forces) == 1
    assert pull_off.trend(wedge.forces[wedge.ratios < 1]) == -1
    text = "\n".join(pull_off.conclusions(pulls))
    assert "flat punch (paper: tension helps): tension helps at every step: confirmed" in text
    assert "tan δ < α: tension weakens at every step: confirmed" in text
    assert "parabola (paper: open): tension helps at every step" in text
    assert "F_A ~ γ₁^0.500" in text


def test_the_conclusions_follow_the_numbers(pulls):
    flat, wedge, _ = pulls
    swapped = "\n".join(pull_off.conclusions((flat, replace(flat, shape="wedge"), wedge)))
    assert "tension helps at every step: NOT confirmed" in swapped
    assert "parabola (paper: open): tension has no one sign" in swapped
    assert pull_off.trend(np.array([1.0, 2.0, 1.5])) == 0
    assert pull_off.trend(np.array([1.0, 2.0, 2.0])) == 0


def test_the_global_pull_of_the_punch_is_the_maxwell_point(pulls):
    for pull in pulls[0].pulls:
        part = math.sqrt(1 / (1 + pull.ratio))
        assert pull.balanced.depth == pytest.approx(-LIFT * part, rel=1e-8, abs=0)
        assert pull.balanced.force == pytest.approx(part * pull.simulated.force, rel=1e-8, abs=0)
    assert all(pull.balanced is None for curve in pulls[1:] for pull in curve.pulls)


def test_pull_off_writes_its_table_and_figures_and_fails_on_an_error(
    pulls, monkeypatch, tmp_path, capsys
):
    monkeypatch.setattr(pull_off, "run", lambda preset, show, jobs: pulls)
    assert pull_off.main(["--quick", "--out", str(tmp_path)]) == 0
    assert "worst relative error" in capsys.readouterr().out
    assert (tmp_path / "pull_off_gain.png").stat().st_size > 2e4
    rows = read(tmp_path / "pull_off.csv")
    assert [float(row["force"]) for row in rows] == [*np.concatenate([c.forces for c in pulls])]
    first = pulls[0].pulls[0]
    wrong = first._replace(simulated=first.simulated._replace(depth=-LIFT * (1 + 2e-8)))
    spoilt = (replace(pulls[0], pulls=(wrong, *pulls[0].pulls[1:])), *pulls[1:])
    monkeypatch.setattr(pull_off, "run", lambda preset, show, jobs: spoilt)
    assert pull_off.main(["--quick", "--out", str(tmp_path)]) == 1


def test_pull_off_knows_the_indenters_it_compares():
    scene = replace(loops.scene_of("parabola", 0.1), indenter=Parabola(1.0) + Wedge(0.1))
    with pytest.raises(ValueError, match="must be a FlatPunch, Wedge or Parabola"):
        loops.size(scene)
