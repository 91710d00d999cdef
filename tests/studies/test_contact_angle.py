"""The study `contact_angle`: both laws measured, constant along a loading path, its files."""

import math
from dataclasses import replace

import numpy as np
import pytest

from energy import Wedge
from studies import __main__ as studies
from studies.contact_angle import study as contact_angle
from studies.contact_angle.record import Loop
from studies.contact_angle.study import measured
from studies.shared.small_slopes import scene, simulated

PRESET = contact_angle.Parameters(
    ratios=(0.01, 0.1, 0.5),
    widths=(0.3, 2.0),
    path=(0.1, 0.5),
    steps=4,
)


@pytest.fixture(scope="module")
def record():
    return contact_angle.run(PRESET)


def test_young_s_law_and_its_small_slope_form_emerge(record):
    assert record.worst("finite") < 1e-9
    assert record.worst("small") < 1e-11
    shapes = {angle.shape for angle in record.of("finite")}
    assert shapes == set(contact_angle.INDENTERS) | set(contact_angle.ROUND)
    assert {angle.shape for angle in record.of("small")} == shapes | set(contact_angle.TILTED)
    for angle in record.of("finite"):
        cosine = -math.cos(angle.deficit)
        assert cosine == pytest.approx(angle.ratio - 1, rel=0, abs=1e-9)


def test_the_two_laws_differ_as_far_as_they_should(record):
    small, finite = ({x.ratio: x.deficit for x in record.of(kind)} for kind in ("small", "finite"))
    gap = {ratio: 1 - small[ratio] / finite[ratio] for ratio in finite}
    assert gap[0.01] == pytest.approx(0.001, rel=0.2, abs=0)
    assert gap[0.1] == pytest.approx(0.009, rel=0.1, abs=0)
    assert gap[0.5] == pytest.approx(0.045, rel=0.01, abs=0)


def test_the_angle_stays_while_everything_else_moves(record):
    assert {(one.shape, one.ratio) for one in record.loops} == {
        (shape, ratio) for shape in ("wedge", "parabola") for ratio in PRESET.path
    }
    for one in record.loops:
        assert one.spread < 1e-9
        depths = [angle.depth for angle in one.angles]
        turn = int(np.argmax(depths))
        assert np.all(np.diff(depths[: turn + 1]) > 0)
        assert np.all(np.diff(depths[turn + 1 :]) < 0)
        assert depths[-1] < -0.3 * depths[turn]  # on the metastable branch
        widths = [angle.half_width for angle in one.angles]
        assert max(widths) > 100 * min(widths)
        if one.shape == "parabola":
            assert np.ptp([angle.layer for angle in one.angles]) > 0.3


def test_both_inclinations_add_up_to_the_deficit(record):
    for one in record.loops:
        for angle in one.angles:
            assert angle.indenter + angle.layer == pytest.approx(angle.deficit, rel=1e-13, abs=0)


def test_a_line_that_a_corner_pins_has_no_say():
    sharp = simulated(scene(Wedge(0.5), 1.0, 0.01), 0.1)
    assert sharp is not None and sharp.pinned.all()
    assert list(measured("finite", "wedge", sharp)) == []


def test_a_wrong_angle_fails_the_study(record):
    assert record.passed
    spoilt = record.states[0]._replace(deficit=record.states[0].deficit * (1 + 1e-6))
    assert not replace(record, states=(spoilt, *record.states)).passed


def test_summary_csv_and_figure(record, tmp_path):
    text = contact_angle.summary(record)
    assert f"(8) within {record.worst('finite'):.0e}" in text
    columns, rows = contact_angle.table(record)
    on_loops = sum(len(one.angles) for one in record.loops)
    assert len(rows) == len(record.states) + on_loops
    assert rows[0][columns.index("deficit")] == record.states[0].deficit
    figure = contact_angle.plot(record)
    figure.savefig(tmp_path / "angles.png", dpi=40)
    assert len(figure.axes) == 4


def test_both_studies_run_from_the_command_line(tmp_path, monkeypatch, capsys):
    small = replace(PRESET, ratios=(0.1,), widths=(2.0,), path=(0.1,), steps=2)
    monkeypatch.setattr(contact_angle, "QUICK", small)
    assert studies.main(["contact_angle", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert "\nanswer: Yes: at 42 contact lines π - θ is" in capsys.readouterr().out
    written = {path.suffix for path in tmp_path.glob("contact_angle.*")}
    assert written == {".png", ".csv"}
    assert {"applicability", "contact_angle"} <= set(studies.STUDIES)


def test_the_spread_of_a_path_is_from_its_least_to_its_largest_angle(record):
    one = record.states[0]
    loading, pulling = (
        [one._replace(deficit=value) for value in part] for part in ((2, 5), (1, 3))
    )
    assert Loop("wedge", 0.1, tuple(loading), tuple(pulling)).spread == 4
    assert Loop("wedge", 0.1, tuple(pulling), tuple(loading)).spread == 4
