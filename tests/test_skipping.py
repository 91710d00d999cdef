"""What is not needed is not done: no digit changes, and the work saved is counted, not timed."""

import importlib
import inspect
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import lapack

import discretization
from discretization import minimise
from discretization.fitted import quadrature, several
from discretization.fitted.lines import Problem
from discretization.lattice import lowest
from discretization.surfaces import mesh, response
from discretization.surfaces.mesh import FreeSurface
from energy import Parabola
from studies.benchmarks import skipping
from studies.benchmarks.skipping_routes import ROUTES, declared, numbers, scene

README = Path(discretization.__file__).with_name("README.md")
WORK = {
    "shortfalls": (Problem, "shortfall"),
    "solves": (mesh, "_newton"),
    "factored": (mesh, "cho_factor"),
    "tridiagonal": (lapack, "dptsv"),
    "integrals": (quadrature, "inside"),
    "fields": (FreeSurface, "displacement"),
    "searches": (lowest, "_cheapest"),
    "resolved": (several, "resolve"),
    "heights": (Parabola, "height"),
}
SAVED = {  # what is counted, most with the skip, least by the general route
    "surface tension": ("factored", 0, 3),
    "adhesion": ("searches", 0, 1),
    "second side, fitted": ("shortfalls", 17, 27),
    "second side, lattice": ("heights", 101_000, 200_000),
    "line of a punch": ("shortfalls", 4, 50),
    "contact": ("tridiagonal", 0, 1),
    "far field": ("tridiagonal", 0, 1),
    "other contacts": ("resolved", 0, 1),
    "links in between": ("heights", 250, 90_000),
    "true lengths": ("solves", 0, 1),
    "known surfaces": ("solves", 1, 27),
    "energy": ("integrals", 0, 50),
    "fields": ("fields", 0, 2),
    "error estimate": ("heights", 11_000, 15_500),
    "search for the line": ("shortfalls", 320, 560),
}


@pytest.fixture
def counted(monkeypatch):
    counts = Counter()

    def counting(name, work):
        def counted_work(*args, **options):
            counts[name] += np.size(args[1]) if name == "heights" else 1
            return work(*args, **options)

        return counted_work

    for name, (owner, attribute) in WORK.items():
        monkeypatch.setattr(owner, attribute, counting(name, getattr(owner, attribute)))
    return counts


@pytest.mark.parametrize("name", ROUTES)
def test_a_skip_changes_no_digit_and_saves_work(name, counted):
    skips, general = ROUTES[name]()
    skips()
    counted.clear()
    found, cost = skips(), counted.copy()
    counted.clear()
    assert skipping.difference(found, general()) <= 1e-13
    kind, most, least = SAVED[name]
    assert cost[kind] <= most
    assert counted[kind] >= least


def test_every_row_stands_in_the_docstring_and_in_the_readme():
    said = re.findall(r"^\| (.+?) +\| .+? +\| ([\w.]+\.\w+) +\|$", discretization.__doc__, re.M)
    assert [name for name, _ in said] == [*ROUTES, skipping.IMPORTS]
    told = README.read_text("utf-8").split("## What a scene does not need")[1].split("\n## ")[0]
    factors = re.findall(r"\| ([\d.; ]+) \|$", told, re.M)
    assert sum(len(row.split(";")) for row in factors) == len(said)
    for _, place in said:
        module, *names = place.split(".")
        found = importlib.import_module(f"discretization.{module}")
        for name in names:
            found = getattr(found, name)
        assert inspect.unwrap(found).__doc__


def test_springs_alone_ask_for_no_surface(counted):
    for slopes in ("small", "finite"):
        for module in (mesh, response):
            for kept in vars(module).values():
                if hasattr(kept, "cache_clear"):
                    kept.cache_clear()
        minimise(scene(gamma1=0.0, w=0.0, slopes=slopes), 2e-6)
    assert counted["factored"] == counted["solves"] == 0


def test_what_says_less_of_itself_is_the_same_profile():
    x = np.linspace(-1, 1, 5)
    plain, less = Parabola(0.1), declared(Parabola(0.1), symmetric=False, apex=None)
    assert (plain.height(x) == less.height(x)).all()
    assert plain.symmetric and not less.symmetric and less.apex is None and less.convex


def test_modules_that_are_not_imported():
    """Beyond those of scipy.linalg, which in some versions imports scipy.sparse."""
    codes = ("import numpy, scipy.linalg", skipping.PLAIN)
    found = []
    for code in (*codes, f"{skipping.PLAIN}, cvxpy, matplotlib.figure"):
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
    monkeypatch.setattr(skipping, "QUICK", skipping.Parameters(2, 1, 0.0))
    monkeypatch.setattr(skipping, "interpreter_seconds", len)
    few = {name: ROUTES[name] for name in ("contact", "fields")}
    monkeypatch.setattr(skipping, "ROUTES", few)
    assert skipping.main(["--quick", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "3 things that may be left out" in said and "none changes a digit" in said
    assert (tmp_path / "skipping.png").stat().st_size > 10_000
    state = minimise(scene(), 2e-6)
    other = (state.half_width * (1 + 1e-11), *numbers(state)[1:])
    few["wrong"] = lambda: (lambda: numbers(state), lambda: other)
    assert skipping.main(["--quick", "--out", str(tmp_path)]) == 1
    assert "these change a digit: wrong." in capsys.readouterr().out
