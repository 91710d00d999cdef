"""The study of the layer: what it measures, and what its table says to those who take springs."""

import numpy as np
import pytest

from energy.validity import springs_error
from studies.__main__ import main
from studies.layer import cases, study
from studies.shared.table import read

FEW = study.Parameters(
    angle_nus=(0.3,),
    thicknesses=(0.3,),
    nodes=16,
    length_nus=(0.45,),
    lengths=(0.3,),
    pull_nus=(0.5,),
    radii=(0.03, 30.0),
    strong=(0.1,),
    springs_nus=(0.3, 0.45),
    ratios=(2.0,),
    Lambdas=(0.4, 0.6),
    rtols=(1e-4, 1e-7),
)


@pytest.fixture(scope="module")
def record():
    return study.run(FEW)


def test_each_question_has_its_answer(record):
    assert record.errors < (5e-3, 1e-5) and record.errors[1] < 1e-5
    assert record.length[0].effective < 0
    half_space, thin, strong = record.pull
    assert half_space.force == pytest.approx(1.5, rel=0.01, abs=0)
    assert 2.8 < thin.force < 3 and 25 < thin.radius < 35
    assert strong.force == pytest.approx(1.0, rel=0.01, abs=0)
    assert study.serve(record) == "2 (ν = 0.3), 2 (ν = 0.45)"
    assert "up to 2.85 at ν = 0.5, a = 28 h, and 1 where tension rules" in study.answer(record)


def test_states_are_as_accurate_as_asked(record):
    assert {one.geometry for one in record.accuracy} == {"line", "axisymmetric"}
    for one in record.accuracy:
        assert 0 < max(one.half_width, one.force) <= one.rtol
    coarse, fine = record.accuracy[:2]
    assert fine.rtol < coarse.rtol and fine.half_width < coarse.half_width / 10


def test_the_worst_is_over_all_tensions_and_has_no_sign(record):
    for one in record.worst():
        own = [s for s in record.springs if s.nu == one.nu]
        assert one.force == max(abs(s.force) for s in own)
        assert one.radius == max(abs(s.radius) for s in own)


@pytest.mark.parametrize(
    ("case", "at_worst"),
    [((0.45, 0.5, 0.25), 1), ((0.45, 0.5, 0.6), 0), ((0.3, 1.0, 1.0), 1), ((0.48, 4.0, 1.0), 0)],
)
def test_the_table_of_validity_is_what_the_study_finds(case, at_worst):
    """At the Λ that is the worst for the force, or for the radius."""
    found = [100 * abs(off) for off in cases.springs(case)[3:]]
    told = springs_error(*case[:2])
    assert found[at_worst] == pytest.approx(told[at_worst], rel=0.02, abs=0)
    assert found[1 - at_worst] <= 1.02 * told[1 - at_worst]


@pytest.mark.slow
def test_the_command_writes_tables_and_figures(record, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(study, "run", lambda preset, show, jobs: record)
    assert main(["layer", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert "answer: The angle stays √(2w/γ₁) whatever ν and h" in capsys.readouterr().out
    drawn = {"layer_angle", "layer_length", "layer_pull", "layer_springs"}
    assert {path.stem for path in tmp_path.glob("*.png")} == drawn
    rows = read(tmp_path / "layer_springs_worst.csv")
    assert np.array([float(row["radius"]) for row in rows]) == pytest.approx(
        [one.radius for one in record.worst()]
    )
    spoilt = record._replace(angle=(record.angle[0]._replace(measured=1.02),))
    monkeypatch.setattr(study, "run", lambda preset, show, jobs: spoilt)
    assert main(["layer", "--quick", "--jobs", "1", "--out", str(tmp_path)]) == 1
