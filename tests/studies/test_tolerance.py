"""Whether rtol and error estimates can be trusted: the random scenes of `stress`, and nodes."""

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
from studies.benchmarks.stress import study as stress
from studies.benchmarks.stress.verdicts import estimated
from studies.scenes import run
from studies.shared import timing


def test_rtol_is_honoured_and_no_estimate_is_below_a_tenth_of_the_error():
    trials = stress.run(stress.Parameters(scenes=500), ["random"])
    assert [t.verdict for t in trials] == ["ok"] * 500


@pytest.mark.parametrize(
    ("errors", "estimates", "where", "rtol", "word"),
    [
        ((1e-8, 0.0, 0.0), (9e-10, 1.0, 1.0), "mesh", 1e-6, "wrong"),
        ((1e-8, 0.0, 0.0), (1.1e-9, 1.0, 1.0), "mesh", 1e-6, "ok"),
        ((9e-16, 0.0, 0.0), (0.0, 0.0, 0.0), "mesh", 1e-6, "ok"),
        ((1.1e-15, 0.0, 0.0), (0.0, 0.0, 0.0), "mesh", 1e-6, "wrong"),
        ((9e-14, 0.0, 0.0), (0.0, 0.0, 0.0), "nodes", math.inf, "ok"),
        ((1.1e-13, 0.0, 0.0), (0.0, 0.0, 0.0), "nodes", math.inf, "wrong"),
        ((0.0, 0.0, 1.1e-6), (1.0, 1.0, 1.0), "mesh", 1e-6, "lost"),
        ((0.0, 0.0, 0.9e-12), (1.0, 1.0, 1.0), "mesh", 1e-13, "ok"),
        ((0.0, 0.0, 1.1e-12), (1.0, 1.0, 1.0), "mesh", 1e-13, "lost"),
    ],
)
def test_errors_beyond_rtol_and_estimates_below_a_tenth_are_bad(
    errors, estimates, where, rtol, word
):
    assert estimated(errors, estimates, where, rtol)[2] == word
    assert (word in stress.BAD) == (word != "ok")


@pytest.mark.slow
def test_estimates_of_lattice_states_are_trusted_and_seldom_withheld(tmp_path, monkeypatch, capsys):
    """None is below a tenth of the error or far too large; one that is off fails the study."""
    sparse = stress.run(stress.Parameters(lattices=100, seed=5), ["nodes"])
    words = Counter(t.verdict for t in sparse)
    assert set(words) <= {"ok", "withheld", "refused"} and sum(words.values()) == 100
    assert words["ok"] >= 80 and words["withheld"] >= 3
    assert all(10**t.x < 50 for t in sparse if t.verdict == "refused")
    links = [float(t.note.split()[0]) for t in sparse if t.verdict == "withheld"]
    assert max(links) < 8
    assert 0.3 <= np.median([t.excess for t in sparse if t.verdict == "ok"]) <= 1
    wrong = sparse[0]._replace(verdict="wrong")
    for found, status in ((sparse, 0), ([*sparse, wrong], 1)):
        monkeypatch.setattr(stress, "run", lambda *_, found=found: found)
        assert stress.main(["--quick", "--grids", "nodes", "--out", str(tmp_path)]) == status
    assert "trusted in 100 of 101 random scenes" in capsys.readouterr().out


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
