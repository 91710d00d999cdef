"""The studies of load paths: loops and pull-off against the cards, their figures and files."""

import math
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from discretization import load_path
from discretization.plots import legs
from discretization.plots import plot_path as figure
from energy import Parabola, Wedge, cards
from studies.hysteresis import study as hysteresis
from studies.hysteresis.animation import animate, frames, surface
from studies.hysteresis.figures import curves, landscape
from studies.pull_off import study as pull_off
from studies.pull_off.conclusions import trend
from studies.shared import loops
from studies.shared.loops import INDENTERS, LAYER, LIFT, SIZE, WORK, Form
from studies.shared.table import read

LITTLE = hysteresis.Parameters(
    tensions=(0.02, 0.4), works=(WORK,), machines=(0.3,), steps=36, across=(0.1,), up=(1.0, 3.0)
)
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
    for found in record.maps:
        assert found.error.max() <= 1e-8
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


def test_a_landscape_has_its_minimum_at_the_state_of_the_path(parabola):
    held = [i for i in range(parabola.depth.size) if parabola.half_width[i] > 0.05 * SIZE]
    for curve in curves(parabola, held[::8]):
        a, U = curve.half_width, np.where(curve.through, np.inf, curve.energy)
        assert curve.state[1] <= U.min() + 1e-12 * abs(U.min())
        assert abs(a[U.argmin()] - curve.state[0]) <= a[1] - a[0]
    assert landscape(parabola, held[:2]).axes[0].get_xlabel() == "half-width a in µm"


def test_a_landscape_shows_where_a_narrower_contact_would_pass_through():
    scene = loops.scene_of("parabola", 0.02)
    path = load_path(scene, depths=[LIFT])
    (curve,) = curves(path, [0])
    material = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": 0.0}
    edge = float(cards.parabola.half_width(LIFT, R=scene.indenter.R, **material))
    assert np.array_equal(curve.through, curve.half_width < edge)


def test_landscapes_refuse_what_they_cannot_draw():
    scene = loops.scene_of("wedge", 0.02)
    path = load_path(scene, depths=[-LIFT, LIFT])
    with pytest.raises(ValueError, match="must contain one with a contact"):
        landscape(path, [0])
    tilted = replace(scene, indenter=Wedge(0.05).tilted(0.01))
    with pytest.raises(ValueError, match="must be symmetric"):
        landscape(load_path(tilted, depths=[LIFT]), [0])


def test_the_animated_surface_is_that_of_the_cards(parabola):
    scene, R = parabola.scene, parabola.scene.indenter.R
    material = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    x = np.linspace(-4 * SIZE, 4 * SIZE, 101)
    step = int(np.argmin(parabola.force))
    u, body = surface(parabola, parabola.at(step), x)
    card = cards.parabola.displacement(x, d=float(parabola.depth[step]), R=R, **material)
    assert np.max(np.abs(u - card)) < 1e-9 * LIFT
    assert np.min(u - body) > -1e-12 * LIFT
    assert not np.any(surface(parabola, parabola.at(0), x)[0])


def test_the_animation_has_frames_of_every_part_and_stays_small(parabola, tmp_path):
    path = loops.depth_loop(parabola.scene, 100)
    shown = frames(path, 50)
    assert {"jump-in", "detachment"} <= {frame.caption.split(":")[0] for frame in shown}
    depths = [frame.state.depth for frame in shown]
    assert max(depths) == pytest.approx(2 * LIFT, rel=1e-12, abs=0)
    count = animate(path, tmp_path / "loop.gif", 50)
    assert 40 <= count <= 80
    with Image.open(tmp_path / "loop.gif") as gif:
        assert gif.n_frames > 30
        first = np.asarray(gif.convert("RGB"), int)
        gif.seek(gif.n_frames // 2)
        assert np.abs(first - np.asarray(gif.convert("RGB"), int)).max() > 100
    assert (tmp_path / "loop.gif").stat().st_size < 2e6


def test_animations_refuse_what_they_cannot_show(parabola, tmp_path):
    with pytest.raises(ValueError, match="must be at least 2"):
        frames(parabola, 1)
    apart = load_path(parabola.scene, depths=[-LIFT, -2 * LIFT])
    with pytest.raises(ValueError, match="has no contact"):
        animate(apart, tmp_path / "none.gif")


def test_the_command_writes_everything(record, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(hysteresis, "run", lambda preset, show, jobs: record)
    monkeypatch.setattr(hysteresis, "animate", lambda history, path, count: 0)
    assert hysteresis.main(["--quick", "--out", str(tmp_path)]) == 0
    assert "0 failed" in capsys.readouterr().out
    for name in ("tension", "control", "map", "loop", "landscape"):
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
    assert trend(flat.forces) == trend(parabola.forces) == 1
    assert trend(wedge.forces[wedge.ratios < 1]) == -1
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
    assert trend(np.array([1.0, 2.0, 1.5])) == 0
    assert trend(np.array([1.0, 2.0, 2.0])) == 0


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
    for name in ("", "_gain", "_maxwell"):
        assert (tmp_path / f"pull_off{name}.png").stat().st_size > 2e4
    rows = read(tmp_path / "pull_off.csv")
    assert [float(row["force"]) for row in rows] == [*np.concatenate([c.forces for c in pulls])]
    first = pulls[0].pulls[0]
    wrong = first._replace(simulated=first.simulated._replace(depth=-LIFT * (1 + 2e-8)))
    spoilt = (replace(pulls[0], pulls=(wrong, *pulls[0].pulls[1:])), *pulls[1:])
    monkeypatch.setattr(pull_off, "run", lambda preset, show, jobs: spoilt)
    monkeypatch.setattr(pull_off, "plot", lambda curves: {})
    assert pull_off.main(["--quick", "--out", str(tmp_path)]) == 1


def test_pull_off_knows_the_indenters_it_compares():
    scene = replace(loops.scene_of("parabola", 0.1), indenter=Parabola(1.0) + Wedge(0.1))
    with pytest.raises(ValueError, match="must be a FlatPunch, Wedge or Parabola"):
        loops.size(scene)
