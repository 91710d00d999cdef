"""The study of loop times: accurate loops, and few states per step."""

import numpy as np
import pytest

from discretization import load_path
from discretization.paths.fitted_branch import FittedBranch
from studies.benchmarks import path_speed
from studies.shared import timing


def test_the_middle_of_times():
    assert timing.middle([1.0, 2.0, 3.0, 4.0, 100.0]) == (3.0, 2 / 3)


def test_a_wrong_loop_fails():
    row = path_speed.Row("x", 1.0, 0.0, 2e-8, 0.0, 1e-8)
    assert not row.accurate
    assert not row._replace(error=0.0, ledger=1e-8).accurate
    assert row._replace(error=0.0).accurate


@pytest.mark.parametrize(("name", "states"), [("imposed depth", 1.0), ("dead load", 3.2)])
def test_states_per_step(name, states, monkeypatch):
    """Counts, not seconds: a smooth step looks for one state, under a load for three."""
    params = path_speed.Parameters(steps=1000, nodes=100)
    arguments, _, _ = path_speed.loops(params)[name]
    (key, values), *_ = arguments.items()
    start, more = values[250:251], values[250:500]
    path = load_path(params.scene, **{key: start})
    count = 0
    follow = FittedBranch.follow

    def counted(self, before, depth):
        nonlocal count
        count += 1
        return follow(self, before, depth)

    monkeypatch.setattr(FittedBranch, "follow", counted)
    load_path(params.scene, **{key: more}, after=path)
    assert count <= states * np.size(more)
