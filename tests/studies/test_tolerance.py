"""The study `tolerance`, what makes it fail, and error estimates on nodes."""

import math
import os
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from scenes import DELTA0, ROOT, L, adhesive, rough, tips, two
from scipy.optimize import brentq

from discretization import minimise
from discretization.lattice.state import on_lattice
from energy import Parabola, Wedge
from studies.benchmarks import tolerance
from studies.scenes import run
from studies.shared import timing


def test_rtol_is_honoured_in_99_of_100_scenes_and_no_estimate_is_below_a_tenth_of_the_error():
    trials = tolerance.run(tolerance.Parameters(lattices=0))
    assert len(trials) == 500
    assert sum(trial.honoured for trial in trials) >= 495
    assert [trial for trial in trials if not trial.trusted] == []
    assert tolerance.passed(trials)
    first = trials[0]
    bold = first._replace(errors=(1e-8, 0.0, 0.0), estimates=(9e-10, 1.0, 1.0))
    assert not bold.trusted and not tolerance.passed([bold, *trials])
    wrong = first._replace(errors=(2 * first.rtol + 1e-11,) * 3, estimates=(1.0,) * 3)
    assert wrong.trusted and not wrong.honoured
    assert not tolerance.passed([*trials, *[wrong] * 7])


@pytest.mark.slow
def test_estimates_of_lattice_states_are_trusted_and_seldom_withheld(tmp_path, monkeypatch, capsys):
    """None is below a tenth of the error or far too large; one that is off fails the study."""
    given = tolerance.Parameters(scenes=0, lattices=100, seed=5)
    sparse = tolerance.run(given, lambda progress: None)
    assert len(sparse) == 100
    assert [state for state in sparse if not state.trusted] == []
    words = Counter(state.word for state in sparse)
    assert words["estimated"] >= 80 and words["withheld"] >= 3
    assert all(state.nodes < 50 for state in sparse if state.word == "refused")
    assert all(state.links < 8 for state in sparse if state.word == "withheld")
    ratios = [state.worst for state in sparse if state.word == "estimated"]
    assert 0.3 <= np.median(ratios) <= 1
    state = next(state for state in sparse if state.word == "estimated")
    bold = state._replace(errors=(1e-3, 0.0, 0.0), estimates=(9e-5, 1.0, 1.0))
    assert not bold.trusted and bold._replace(word="withheld").trusted
    few = tolerance.Parameters(scenes=8, lattices=8)
    monkeypatch.setattr(tolerance, "Parameters", lambda **_: few)
    command = ["--preset", "quick", "--jobs", "1", "--out", str(tmp_path)]
    assert tolerance.main(command) == 0
    assert "withheld" in capsys.readouterr().out
    found = tolerance.run(few)
    monkeypatch.setattr(tolerance, "run", lambda *_, **__: [*found, bold])
    assert tolerance.main(command) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "depth", "cells"),
    [
        (Parabola(0.02), -0.95, 4),  # narrower than a link
        (Parabola(0.02), -0.9, 12),  # a few links
        (Wedge(0.05).shifted(0.3 * L), -0.75, 3),
        (tips(3 * L), 1.0, 6.7),  # between nodes
        (two(3 * L), -0.3, 2.75),  # detached, where a finer lattice is not
        (rough(149).indenter, 1.2, 2.8),  # unresolved roughness inside the contact
        (rough(9).indenter, 1.2, 5),  # a contact that coarser lattices miss, too
    ],
)
def test_what_a_lattice_does_not_resolve_has_no_estimate(body, depth, cells):
    scene, spacing = adhesive(body), L / cells
    state = on_lattice(scene, depth * DELTA0, spacing)
    assert set(state.error_estimate.values()) == {math.inf}
    assert str(state).count("not resolved: use smaller spacing") == 3
    assert "not res." in run.row(state)
    fine = on_lattice(scene, depth * DELTA0, L / 400)
    assert max(fine.error_estimate.values()) < 0.1 or body.corners


def test_a_state_that_is_detached_on_any_lattice_has_no_error():
    for body in (Parabola(0.02), two(3 * L)):
        state = on_lattice(adhesive(body), -1.01 * DELTA0, L / 5)
        assert state.label == "detached"
        assert set(state.error_estimate.values()) == {0.0}


def test_errors_are_told_in_the_units_of_their_quantities():
    """The force passes through 0, and its error stays what it is."""
    scene = adhesive(Parabola(0.02))
    level = brentq(lambda d: minimise(scene, d).force, 0.01 * DELTA0, 2 * DELTA0, xtol=1e-16)
    state = on_lattice(scene, level, L / 40)
    limit = state.uncertainty["force"]
    assert abs(state.force) <= limit == state.error_estimate["force"] * state.scales["force"]
    assert f"force        P = {state.force:.10g}   (numerical error {limit:.1e})" in str(state)
    assert limit > 100 * abs(minimise(scene, level).force)


def test_the_verdict_says_with_how_many_threads_it_was_measured(monkeypatch):
    code = (
        "import studies.__main__, os; from studies.shared.timing import blas_threads;"
        "print(blas_threads(), os.environ['MKL_NUM_THREADS'])"
    )
    given = {**os.environ, "OPENBLAS_NUM_THREADS": "7", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=given, capture_output=True, text=True, check=True)
    assert done.stdout == "one thread 1\n"
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    assert timing.blas_threads() == "as many threads as it takes"
