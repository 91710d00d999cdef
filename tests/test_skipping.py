"""What is not needed is not done: no digit changes, and evaluations that are saved are counted."""

import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import discretization
from discretization import minimise
from energy import Parabola
from studies.benchmarks import skipping
from studies.benchmarks.skipping import declared, scene

README = Path(discretization.__file__).with_name("README.md")
ROUTES = skipping.routes()
SAVED = {  # heights of the profile: most with the skip, least by the general route
    "other contacts": (1_000, 2_000),
    "error estimate": (13_000, 17_000),
}


@pytest.fixture
def heights(monkeypatch):
    counts, right = Counter(), Parabola.height

    def height(self, x):
        counts["heights"] += np.size(x)
        return right(self, x)

    monkeypatch.setattr(Parabola, "height", height)
    return counts


@pytest.mark.parametrize("name", ROUTES)
def test_a_skip_changes_no_digit_and_saves_work(name, heights):
    skips, general = skipping.routes()[name]
    skips()
    heights.clear()
    found = skips()
    cost = heights["heights"]
    heights.clear()
    assert skipping.difference(found, general()) <= 1e-13
    if name in SAVED:
        most, least = SAVED[name]
        assert cost <= most
        assert heights["heights"] >= least


def test_every_row_stands_in_the_docstring_and_in_the_readme():
    said = re.findall(r"^\| (.+?) +\| .+? +\| ([\w.]+\.\w+) +\|$", discretization.__doc__, re.M)
    names = [*ROUTES]
    assert [name for name, _ in said if name in names] == names
    told = README.read_text("utf-8").split("## What a scene does not need")[1].split("\n## ")[0]
    factors = re.findall(r"\| ([\d.; ]+) \|$", told, re.M)
    assert sum(len(row.split(";")) for row in factors) == len(names)


def test_what_says_less_of_itself_is_the_same_profile():
    x = np.linspace(-1, 1, 5)
    plain, less = Parabola(0.1), declared(Parabola(0.1), symmetric=False, apex=None)
    assert (plain.height(x) == less.height(x)).all()
    assert plain.symmetric and not less.symmetric and less.apex is None and less.convex


def test_modules_that_are_not_imported():
    """Beyond those of scipy.linalg, which in some versions imports scipy.sparse."""
    codes = ("import numpy, scipy.linalg", "import energy, discretization")
    found = []
    for code in (*codes, f"{codes[1]}, cvxpy, matplotlib.figure"):
        command = [sys.executable, "-c", f"{code}, sys; print(*sys.modules)"]
        loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
        found.append({*loaded})
    least, plain, everything = found
    unwanted = {"cvxpy", "matplotlib", "scipy.sparse", "scipy.optimize"}
    assert not unwanted & (plain - least)
    assert len(plain) < len(everything) / 2


def test_the_study_measures_every_row_and_fails_where_a_digit_changes(
    tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(skipping, "QUICK", skipping.Parameters(2, 0.0))
    few = {name: ROUTES[name] for name in ("far field", "fields")}
    monkeypatch.setattr(skipping, "routes", lambda: few)
    assert skipping.main(["--quick", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "2 things that may be left out" in said and "none changes a digit" in said
    assert (tmp_path / "skipping.png").stat().st_size > 10_000
    state = minimise(scene(), 2e-6)
    numbers = state.half_width, state.force, state.energy
    other = (state.half_width * (1 + 1e-11), *numbers[1:])
    few["wrong"] = lambda: numbers, lambda: other
    assert skipping.main(["--quick", "--out", str(tmp_path)]) == 1
    assert "these change a digit: wrong." in capsys.readouterr().out
