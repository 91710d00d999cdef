"""The studies of one question each: numbers, figures, files and answers."""

import itertools
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from energy import Parabola, Wedge
from energy.validity import springs_error
from studies import hysteresis, layer, levels, pull_off, rough, sphere
from studies.__main__ import main
from studies.contact_angle import study as contact_angle
from studies.contact_angle.study import measured
from studies.shared import loops
from studies.shared.loops import INDENTERS, LIFT, SIZE
from studies.shared.small_slopes import scene, simulated
from studies.shared.table import read

PRESET = contact_angle.Parameters(
    ratios=(0.01, 0.1, 0.5), widths=(0.3, 2.0), path=(0.1, 0.5), steps=4, nodes=(6, 12, 25, 50)
)


@pytest.fixture(scope="module")
def record():
    return contact_angle.run(PRESET)


def test_young_s_law_and_its_small_slope_form_emerge(record):
    """And the two laws differ as far as they should."""
    assert record.worst("finite") < 1e-9
    assert record.worst("small") < 1e-11
    finite = record.of("finite")
    small = record.of("small")
    shapes = {angle.shape for angle in finite}
    assert shapes == set(contact_angle.INDENTERS) | set(contact_angle.ROUND)
    assert {angle.shape for angle in small} == shapes | set(contact_angle.TILTED)
    for angle in finite:
        assert -math.cos(angle.deficit) == pytest.approx(angle.ratio - 1, rel=0, abs=1e-9)
    by_15 = {angle.ratio: angle.deficit for angle in small}
    by_8 = {angle.ratio: angle.deficit for angle in finite}
    for ratio, gap, rel in ((0.01, 0.001, 0.2), (0.1, 0.009, 0.1), (0.5, 0.045, 0.01)):
        assert 1 - by_15[ratio] / by_8[ratio] == pytest.approx(gap, rel=rel, abs=0)


def test_the_angle_stays_while_everything_else_moves(record):
    expected = set(itertools.product(("wedge", "parabola"), PRESET.path))
    assert {(one.shape, one.ratio) for one in record.loops} == expected
    for one in record.loops:
        assert np.ptp([angle.deficit for angle in one.angles]) < 1e-9
        depths = np.array([angle.depth for angle in one.angles])
        widths = np.array([angle.half_width for angle in one.angles])
        turn = int(np.argmax(depths))
        assert np.all(np.diff(depths[: turn + 1]) > 0)
        assert np.all(np.diff(depths[turn + 1 :]) < 0)
        assert depths[-1] < -0.3 * depths[turn]  # on the metastable branch
        assert widths.max() > 100 * widths.min()
        if one.shape == "parabola":
            assert np.ptp([angle.layer for angle in one.angles]) > 0.3


def test_the_angle_emerges_on_nodes_with_second_order(record):
    """θ = 120° of the true lengths, 180° - 1 rad of small slopes, from energies alone."""
    found = {(one.kind, one.shape) for one in record.nodes}
    assert found == set(itertools.product(("finite", "small"), contact_angle.ON_NODES))
    for one in record.nodes:
        assert 1.7 < one.order < 2.2
        assert one.errors[-1] < 0.01


def test_mirror_twins_count_once_and_pinned_lines_not_at_all(record):
    """A parabola that is tilted is one that is shifted, its own mirror image still."""
    tilted = Parabola(4.0).tilted(0.1)
    for body, lines in ((Parabola(4.0), 1), (tilted, 1), (Wedge(0.1).tilted(0.02), 2)):
        state = simulated(scene(body, 1.0, 0.1, "small"), 0.5)
        assert len(list(measured("small", "", state))) == lines
    assert min(record.edge) < -0.9  # any angle, with the depth
    assert max(record.edge) > 0.9


def test_a_wrong_angle_fails_the_study(record):
    assert record.passed
    right = record.states[0]
    spoilt = right._replace(deficit=right.deficit * (1 + 1e-6))
    wrong = replace(record, states=(*record.states, spoilt))
    assert not wrong.passed
    assert "by up to 1e-06 of itself" in contact_angle.answer(wrong)
    assert "NOT the constant" in contact_angle.plot(wrong).get_suptitle()
    path = record.loops[0]
    right = path.retract[-1]
    spoilt = right._replace(deficit=right.deficit * (1 + 1e-6))
    path = path._replace(retract=(*path.retract[:-1], spoilt))
    assert not replace(record, loops=(*record.loops[1:], path)).passed
    coarse = record.nodes[0]._replace(errors=(0.1,) * 4)  # does not converge
    assert not replace(record, nodes=(*record.nodes[1:], coarse)).passed
    said = contact_angle.summary(record)
    assert f"(8), relative error at most {record.worst('finite'):.0e}" in said
    columns, rows = contact_angle.table(record)
    on_paths = sum(len(one.angles) for one in record.loops)
    assert len(rows) == len(record.states) + on_paths
    assert rows[0][columns.index("deficit")] == record.states[0].deficit
    sharp = simulated(scene(Wedge(0.5), 1.0, 0.01), 0.1)
    assert sharp.pinned.all()
    assert not list(measured("finite", "wedge", sharp))  # it has no say


def test_the_contact_angle_runs_from_the_command_line(tmp_path, monkeypatch, capsys):
    few = {"ratios": (0.1,), "widths": (2.0,), "path": (0.1,), "steps": 2}
    monkeypatch.setattr(contact_angle, "QUICK", replace(PRESET, **few))
    assert main(["contact_angle", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert " distinct free lines agree" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {
        "contact_angle.png",
        "contact_angle.csv",
        "angle_on_nodes.png",
        "angle_on_nodes.csv",
        "loading_path.png",
    }


@pytest.fixture(scope="module")
def spheres():
    return sphere.run(sphere.Parameters((0.03, 1.0, 4.0), (1.0,), (0.1,)))


@pytest.mark.slow
def test_small_and_finite_slopes_against_closed_forms(spheres):
    """Small slopes are the closed forms and finite ones are near."""
    assert [s.slopes for s in spheres] == ["small"] * 3 + ["finite"]
    assert max(s.error for s in spheres[:3]) <= 1e-11
    assert 1e-4 < spheres[3].error < 1e-2
    on_springs, _, on_a_liquid = (s.load.force for s in spheres[:3])
    assert on_springs > 0.97
    assert 0.5 < on_a_liquid < 0.501
    for s in spheres:
        assert s.depth.depth < s.load.depth
        assert s.depth.radius < s.load.radius
        assert 0 < s.depth.force < s.load.force


@pytest.mark.slow
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
def rough_loops():
    return rough.run(rough.Parameters(nodes=1001, steps=15, compared=1, tensions=(0.25, 4.0)))


def test_rough_contact_spots_and_energy_balance(rough_loops):
    """With weak adhesion, too: nodes that have just touched do not let go again by rounding."""
    first, last = rough_loops
    assert first.contacts.max() < last.contacts.max()
    assert last.contacts.max() >= 8
    assert first.fraction[14] == pytest.approx(1.0, abs=1e-13)  # at the deepest
    assert last.fraction[14] < 0.6
    (weak,) = rough.run(rough.Parameters(nodes=1001, w=2e-7, compared=0, tensions=(4.0,)))
    assert weak.contacts.max() >= 10
    for loop in (*rough_loops, weak):
        assert loop.path.work() == pytest.approx(loop.path.dissipated, rel=1e-11, abs=0)
        assert np.isnan(loop.path.contacts[-1]).all()


FEW = pull_off.Parameters(ratios=(0.1, 0.3, 0.8, 1.7, 4.0))


@pytest.fixture(scope="module")
def looped():
    return hysteresis.run(hysteresis.QUICK)


@pytest.fixture(scope="module")
def pulls():
    return pull_off.run(FEW)


def test_loops_agree_with_cards_and_balance(looped):
    """Every loop agrees with the cards and its energy balances."""
    assert len(looped) == len(INDENTERS) * 2 * 3
    assert {loop.history.control for loop in looped} == {"depth", "force", "drive"}
    for loop in looped:
        assert loop.error <= 1e-8, (hysteresis.line(loop), loop.forms)
        assert loop.imbalance <= 1e-9, hysteresis.line(loop)
        assert loop.passed


def test_hysteresis_files_and_failures(looped, monkeypatch, tmp_path, capsys):
    """Hysteresis writes everything and a wrong number or imbalance fails."""
    monkeypatch.setattr(hysteresis, "run", lambda preset, show, jobs: looped)
    assert hysteresis.main(["--quick", "--out", str(tmp_path)]) == 0
    assert "0 failed" in capsys.readouterr().out
    for name in ("control", "loop"):
        assert (tmp_path / f"hysteresis_{name}.png").stat().st_size > 2e4
    for row, loop in zip(read(tmp_path / "hysteresis.csv"), looped, strict=True):
        assert float(row["dissipated"]) == loop.history.dissipated
        assert float(row["work"]) == loop.work
        assert float(row["pull-off_force"]) <= 0
    loop = looped[0]
    form, *others = loop.forms
    off = form._replace(simulated=form.closed_form + 2e-8 * form.scale)
    missing = form._replace(simulated=math.nan)
    for change in (
        {"forms": (off, *others)},
        {"forms": (missing, *others)},
        {"work": loop.work * (1 + 2e-9)},
    ):
        one = replace(loop, **change)
        assert not one.passed
        assert hysteresis.line(one).endswith("FAIL")
    monkeypatch.setattr(hysteresis, "run", lambda preset, show, jobs: (one, *looped[1:]))
    monkeypatch.setattr(hysteresis, "plot", lambda record: {})
    assert hysteresis.main(["--quick", "--out", str(tmp_path)]) == 1


def test_all_indenters_have_the_size_they_are_compared_at():
    for shape in INDENTERS:
        assert loops.size(loops.scene_of(shape, 0.1)) == pytest.approx(SIZE, rel=1e-12, abs=0)
    other = replace(loops.scene_of("parabola", 0.1), indenter=Parabola(1.0) + Wedge(0.1))
    with pytest.raises(ValueError, match="must be a FlatPunch, Wedge or Parabola"):
        loops.size(other)


def test_pull_off_agrees_with_the_closed_forms(pulls):
    for curve in pulls:
        assert curve.ratios.tolist() == [0.0, *FEW.ratios]
        assert curve.error <= 1e-8, curve.shape


def test_tension_and_adhesion_force_of_shapes(pulls):
    """Tension helps the punch and the parabola and weakens the wedge."""
    flat, wedge, parabola = pulls
    assert pull_off.trend(flat.forces) == pull_off.trend(parabola.forces) == 1
    balanced = np.array([pull.balanced.force for pull in flat.pulls])
    assert pull_off.trend(balanced) == 1
    assert np.all(np.diff(balanced / flat.forces) < 0)
    assert pull_off.trend(wedge.forces[wedge.ratios < 1]) == -1
    told = "\n".join(pull_off.conclusions(pulls))
    assert told.count("at every step") == 3
    assert "F_A ~ γ₁^0.500" in told


def test_the_global_pull_of_the_punch_is_the_maxwell_point(pulls):
    for pull in pulls[0].pulls:
        part = math.sqrt(1 / (1 + pull.ratio))
        assert pull.balanced.depth == pytest.approx(-LIFT * part, rel=1e-8, abs=0)
        assert pull.balanced.force == pytest.approx(part * pull.simulated.force, rel=1e-8, abs=0)
    assert all(pull.balanced is None for curve in pulls[1:] for pull in curve.pulls)


def test_pull_off_files_and_failures(pulls, monkeypatch, tmp_path, capsys):
    """Pull off writes its table and figures and fails on an error."""
    monkeypatch.setattr(pull_off, "run", lambda preset, show, jobs: pulls)
    assert pull_off.main(["--quick", "--out", str(tmp_path)]) == 0
    assert "worst relative error" in capsys.readouterr().out
    assert (tmp_path / "pull_off_gain.png").stat().st_size > 2e4
    written = [float(row["force"]) for row in read(tmp_path / "pull_off.csv")]
    assert written == np.concatenate([curve.forces for curve in pulls]).tolist()
    flat, *others = pulls
    first, *further = flat.pulls
    state = first.simulated._replace(depth=-LIFT * (1 + 2e-8))
    wrong = first._replace(simulated=state)
    spoilt = (replace(flat, pulls=(wrong, *further)), *others)
    monkeypatch.setattr(pull_off, "run", lambda preset, show, jobs: spoilt)
    assert pull_off.main(["--quick", "--out", str(tmp_path)]) == 1


LAYERS = {
    "angle": ((0.3,), (0.3,), (16,)),
    "length": ((0.45,), (0.3,)),
    "weak": ((0.5,), (0.03, 30.0), ("weak",)),
    "strong": ((0.3,), (0.1,), ("strong",)),
    "springs": ((0.3, 0.45), (2.0,), (0.4, 0.6)),
    "accuracy": (("line", "axisymmetric"), (1e-4, 1e-7)),
}


@pytest.fixture(scope="module")
def layered():
    return layer.run(LAYERS)


def test_each_question_has_its_answer(layered):
    angle, length = layer.errors(layered)
    assert angle < 5e-3
    assert length < 1e-5
    assert layered["angle"][0].error < 1e-2
    assert layered["length"][0].effective < 0
    half_space, thin, strong = layered["weak"] + layered["strong"]
    assert half_space.force == pytest.approx(1.5, rel=0.01, abs=0)
    assert 2.8 < thin.force < 3
    assert 25 < thin.radius < 35
    assert strong.force == pytest.approx(1.0, rel=0.01, abs=0)
    said = layer.answers(layered)
    assert "2.85 at ν = 0.5, a = 28 h, 1 where tension dominates" in said["pull"]
    assert "within 5 % from l/h = 2 (ν = 0.3), 2 (ν = 0.45) on" in said["springs"]


def test_states_are_as_accurate_as_asked(layered):
    assert {one.geometry for one in layered["accuracy"]} == {"line", "axisymmetric"}
    for one in layered["accuracy"]:
        assert 0 < max(one.half_width, one.force) <= one.rtol
        assert one.over_springs > 1
    coarse, fine = layered["accuracy"][:2]
    assert fine.rtol < coarse.rtol
    assert fine.half_width < coarse.half_width / 10
    for one in layered["springs_worst"]:  # over all tensions, without a sign
        own = [s for s in layered["springs"] if s.nu == one.nu]
        assert one.force == max(abs(s.force) for s in own)
        assert one.radius == max(abs(s.radius) for s in own)


def test_times_are_measured_in_one_process(monkeypatch):
    """Whatever number of them is asked for: others on the same cores lengthen what is timed."""
    asked = {}

    def ask(measure, cases, jobs, say):
        asked[measure] = jobs
        return []

    monkeypatch.setattr(layer, "each", ask)
    layer.run(LAYERS, jobs=4)
    assert asked.pop(layer.accuracy) == 1
    assert set(asked.values()) == {4}


@pytest.mark.parametrize(
    ("case", "at_worst"),
    [((0.45, 0.5, 0.25), 1), ((0.45, 0.5, 0.6), 0), ((0.3, 1.0, 1.0), 1), ((0.48, 4.0, 1.0), 0)],
)
def test_the_table_of_validity_is_what_the_study_finds(case, at_worst):
    """At the Λ that is the worst for the force, or for the radius."""
    found = [100 * abs(off) for off in layer.springs(case)[3:]]
    told = springs_error(*case[:2])
    assert found[at_worst] == pytest.approx(told[at_worst], rel=0.02, abs=0)
    assert found[1 - at_worst] <= 1.02 * told[1 - at_worst]


def test_the_study_of_layers_writes_tables_and_figures(layered, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(layer, "run", lambda preset, show, jobs: layered)
    assert main(["layer", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert "answer: The angle stays √(2w/γ₁) whatever ν and h" in capsys.readouterr().out
    drawn = {"layer_angle", "layer_length", "layer_pull", "layer_springs"}
    assert {path.stem for path in tmp_path.glob("*.png")} == drawn
    written = [float(row["radius"]) for row in read(tmp_path / "layer_springs_worst.csv")]
    assert written == pytest.approx([one.radius for one in layered["springs_worst"]])
    spoilt = {**layered, "angle": [layered["angle"][0]._replace(measured=1.02)]}
    monkeypatch.setattr(layer, "run", lambda preset, show, jobs: spoilt)
    assert main(["layer", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 1


@pytest.fixture(scope="module")
def shared_work():
    return levels.run(replace(levels.QUICK, steps=12))


def test_paths_of_the_levels_pass_between_processes(shared_work):
    for path in (shared_work.refined, shared_work.on_nodes[6]):
        copy = pickle.loads(pickle.dumps(path))
        assert np.array_equal(copy.table, path.table, equal_nan=True)


def test_nodes_find_what_the_mesh_refines(shared_work):
    """Lines to half a link; events and energies with second order, on four numbers of nodes."""
    assert shared_work.passed
    assert shared_work.balance < 1e-12
    assert len(shared_work.refined.events) == 15
    found = shared_work.errors
    counts = [one.nodes for one in found]
    for name, order, finest in (("line", 1, 0.011), ("depth", 2, 5e-5), ("energy", 2, 4e-6)):
        values = [getattr(one, name) for one in found]
        slope = -np.polyfit(np.log(counts), np.log(values), 1)[0]
        assert slope == pytest.approx(order, abs=0.35) and values[-1] < finest, name
    assert all(one.line < 0.55 / one.nodes for one in found)


def test_an_event_is_enclosed(shared_work):
    """The gap narrows like a square root towards the fold at which it is lost."""
    refined = shared_work.enlarged[0]
    held = refined.depth < refined.event
    assert np.all(refined.width[held] > 0)
    assert np.all(refined.width[~held] == 0)
    left = refined.event - refined.depth[held]
    near = left < 0.01 * shared_work.refined.scene.critical_separation
    power = np.polyfit(np.sqrt(left[near]), refined.width[held][near], 1)
    line = np.polyval(power, np.sqrt(left[near]))
    assert power[0] > 0
    assert np.abs(line / refined.width[held][near] - 1).max() < 2e-3
    off = [abs(shared_work.enlarged[n].event - refined.event) for n in levels.QUICK.nodes]
    assert off == sorted(off, reverse=True)
    assert off[-1] < off[0] / 20


def test_levels_fail_where_nodes_find_other_events(shared_work, tmp_path, monkeypatch, capsys):
    assert "in the same order" in levels.answer(shared_work)
    fewer = {n: replace(p, events=p.events[:-1]) for n, p in shared_work.on_nodes.items()}
    wrong = replace(shared_work, on_nodes=fewer)
    assert wrong.balance < levels.BALANCE
    assert not wrong.passed
    assert math.isnan(wrong.errors[0].line)
    lost = replace(shared_work.refined, events=shared_work.refined.events[:-1])
    assert replace(shared_work, refined=lost).balance > levels.BALANCE
    partly = replace(shared_work.refined, on_nodes=((0.0, 1e-7),))
    assert not replace(shared_work, refined=partly).passed
    monkeypatch.setattr(levels, "run", lambda *_: shared_work)
    assert levels.main(["--quick", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "levels.png").stat().st_size > 20_000
    assert len(read(tmp_path / "levels.csv")) == 4
    monkeypatch.setattr(levels, "run", lambda *_: wrong)
    monkeypatch.setattr(levels, "plot", lambda record: shared_work.refined.plot("a path"))
    assert levels.main(["--quick", "--out", str(tmp_path)]) == 1
    assert "They do not agree" in capsys.readouterr().out
