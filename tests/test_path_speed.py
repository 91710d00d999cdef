"""The study of loop times: accurate loops, and few states per step."""

import pytest

from discretization import load_path
from discretization.paths.fitted_many import FittedMany
from studies.benchmarks import path_speed
from studies.shared import timing


def test_the_middle_of_times():
    assert timing.middle([1.0, 2.0, 3.0, 4.0, 100.0]) == (3.0, 2 / 3)


def test_a_wrong_loop_fails():
    row = path_speed.Row("x", 1.0, 0.0, 2e-8, 0.0, 1e-8)
    assert not row.accurate
    assert not row._replace(error=0.0, ledger=1e-8).accurate
    assert row._replace(error=0.0).accurate


@pytest.mark.parametrize(("name", "most"), [("imposed depth", 1), ("dead load", 6)])
def test_legs_of_a_smooth_part(name, most, monkeypatch):
    """Counts, not seconds: the steps of a smooth part are read off a few legs."""
    params = path_speed.Parameters(steps=1000, nodes=100)
    arguments, _, _ = path_speed.loops(params)[name]
    (key, values), *_ = arguments.items()
    start, more = values[250:251], values[250:500]
    path = load_path(params.scene, **{key: start})
    count = 0
    leg = FittedMany.leg

    def counted(self, point, goal):
        nonlocal count
        count += 1
        return leg(self, point, goal)

    monkeypatch.setattr(FittedMany, "leg", counted)
    load_path(params.scene, **{key: more}, after=path)
    assert 0 < count <= most
