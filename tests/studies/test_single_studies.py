"""The studies `contact_angle`, `sphere` and `rough`: numbers, figures, files and answers."""

import math
from dataclasses import replace

import numpy as np
import pytest

from energy import Wedge
from studies import __main__ as studies
from studies import rough, sphere
from studies.__main__ import main
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


SMALL = sphere.Parameters((0.03, 1.0, 4.0), (1.0,), (0.1,))


@pytest.fixture(scope="module")
def spheres():
    return sphere.run(SMALL)


@pytest.mark.slow
def test_small_slopes_are_the_closed_forms_and_finite_ones_are_near(spheres):
    assert [s.slopes for s in spheres] == ["small"] * 3 + ["finite"]
    assert max(s.error for s in spheres[:3]) <= 1e-11
    assert 1e-4 < spheres[3].error < 1e-2
    forces = [s.load.force for s in spheres[:3]]
    assert forces[0] > 0.97 and 0.5 < forces[2] < 0.501
    for s in spheres:
        assert s.depth.depth < s.load.depth and s.depth.radius < s.load.radius
        assert 0 < s.depth.force < s.load.force


def test_the_expansions_and_the_line_contact_drawn_are_those_of_the_cards(spheres):
    drawn = sphere.plot(spheres)
    left, right = drawn.axes
    lines = {line.get_label(): line for line in left.lines}
    _, line_contact = lines["line contact, over its springs'"].get_data()
    ratios = lines["closed form"].get_xdata()
    given = {"R": 1e-3, "k": 1e8, "w": 1e-3}
    lift = (2 * given["w"] / given["k"]) ** 0.5
    tension = given["k"] * ratios**2 * given["R"] * lift
    pull = sphere.cards.parabola.adhesion_force(gamma1=tension, **given)
    bare = sphere.cards.parabola.adhesion_force(gamma1=0.0, **given)
    assert np.allclose(line_contact, pull / bare, rtol=1e-12, atol=0)
    depth = sphere.cards.parabola.pull_off(gamma1=tension, **given).depth / lift
    pulled = next(line for line in right.lines if line.get_label() == "line contact: dead load")
    assert np.allclose(pulled.get_ydata(), depth, rtol=1e-12, atol=0)
    stiff = lines["expansions, Λ → 0 and Λ → ∞"]
    assert abs(stiff.get_ydata()[0] - sphere.closed_forms(ratios[0])[0].force) < 3e-5


def test_what_is_written_and_said(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sphere, "QUICK", sphere.Parameters((0.1, 1.0), (1.0,), (0.1,)))
    assert main(["sphere", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"sphere.csv", "sphere.png"}
    said = capsys.readouterr().out
    assert "answer: Both: F_A/2πRw falls from 1 to ½" in said
    assert "0.929 at Λ = 0.1, 0.5546 at Λ = 1" in said
    monkeypatch.setattr(sphere, "LARGEST", 1e-30)
    assert main(["sphere", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 1


@pytest.fixture(scope="module")
def loops():
    return rough.run(rough.Parameters(nodes=1001, steps=15, compared=3))


def test_tension_breaks_the_contact_up_into_spots(loops):
    assert [loop.tension for loop in loops] == [0.25, 1.0, 4.0]
    spots = [int(loop.contacts.max()) for loop in loops]
    assert spots[0] < spots[-1] and spots[-1] >= 8
    deepest = [loop.fraction[14] for loop in loops]
    assert deepest[0] == pytest.approx(1.0, abs=1e-13) and deepest[-1] < 0.6


def test_energies_balance_and_contacts_are_lost(loops):
    for loop in loops:
        assert loop.path.work() == pytest.approx(loop.path.dissipated, rel=1e-11, abs=0)
        assert np.isnan(loop.path.contacts[-1]).all()


def test_no_metastable_state_lies_below_the_global_one(loops):
    assert all(rough.lowest_is_lowest(loop) for loop in loops)
    below = [s.energy < loop.path.energy[i] for loop in loops for i, s in loop.lowest.items()]
    assert any(below)


def test_weak_adhesion_comes_to_rest():
    """Lone nodes that have just touched do not let go again by rounding."""
    params = rough.Parameters(w=2e-7, compared=0, tensions=(4.0,))
    (loop,) = rough.run(params)
    assert loop.contacts.max() >= 10
    assert loop.path.work() == pytest.approx(loop.path.dissipated, rel=1e-11, abs=0)
