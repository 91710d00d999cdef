"""What one answer costs in counts, and that what is not needed is not done."""

import re
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scenes import plain, roughness

import discretization
from discretization import Lattice, load_path, minimise
from discretization.fitted.single_lines import Single
from discretization.lattice import lowest
from discretization.surfaces import finite_gap, menisci
from energy import ElasticLayer, FlatPunch, Parabola, Scene, SurfaceEnergies
from studies.benchmarks import skipping
from studies.benchmarks.skipping import declared, scene

counted = Counter()


@dataclass(frozen=True)
class Counted(Parabola):
    """A parabola that counts the points it is asked for."""

    def height(self, x):
        counted["heights"] += np.size(x)
        counted["calls"] += 1
        counted["longest"] = max(counted["longest"], np.size(x))
        return super().height(x)

    def slope(self, x):
        counted["slopes"] += np.size(x)
        return super().slope(x)


@pytest.fixture(autouse=True)
def _counting(monkeypatch):
    counted.clear()

    def counting(name, work):
        def counted_work(*args, **given):
            counted[name] += 1
            return work(*args, **given)

        return counted_work

    monkeypatch.setattr(Single, "shortfall", counting("shortfalls", Single.shortfall))
    monkeypatch.setattr(finite_gap, "_laid", counting("solves", finite_gap._laid))


@pytest.mark.parametrize(
    ("slopes", "w", "solves"), [("small", 0.02, 0), ("small", 0.0, 0), ("finite", 0.3, 1)]
)
def test_one_equilibrium(slopes, w, solves):
    question = plain(Counted(10.0), w=w, slopes=slopes)
    minimise(question, 1.0)  # tables that are kept
    counted.clear()
    minimise(question, 1.5)
    assert counted["shortfalls"] <= 16
    assert counted["heights"] <= 375
    assert counted["slopes"] <= 360
    assert counted["solves"] == solves


def test_a_flat_punch_looks_for_no_line():
    minimise(plain(FlatPunch(1.0)), 0.1)
    assert counted["shortfalls"] <= 3


def test_a_step_of_a_load_path():
    question = plain(Counted(10.0))
    load_path(question, depths=[1.0])
    counted.clear()
    load_path(question, depths=np.linspace(0, 3, 100))
    assert counted["shortfalls"] <= 100 * 8
    assert counted["heights"] <= 100 * 365
    assert counted["solves"] == 0


@pytest.mark.parametrize(("w", "depth"), [(0.02, 1.5), (0.02, -0.02), (0.0, 1.5)])
@pytest.mark.parametrize("nodes", [1000, 200_000])
def test_the_lattice_visits_each_node_once(nodes, w, depth):
    """Symmetric: half of the contact. Lines are found with few nodes; arrays stay in the cache."""
    question = plain(Counted(10.0), w=w)
    a = minimise(question, depth).half_width
    counted.clear()
    state = minimise(question, depth, method="lattice", spacing=2 * a / nodes)
    assert state.certificate.ok
    assert counted["heights"] <= nodes / 2 + 5000
    assert counted["longest"] <= 20_000


def test_a_path_on_the_lattice_reads_the_profile_once():
    question, depths = plain(Counted(10.0)), np.linspace(1.0, 1.1, 101)
    load_path(question, depths=depths[-1:], method="lattice", spacing=1e-3)
    one_step = counted["heights"]
    counted.clear()
    load_path(question, depths=depths, method="lattice", spacing=1e-3)
    assert 0 < counted["heights"] <= 1.25 * one_step


def waves(n):
    """Several contacts; some hundred and a thousand starts could be the best."""
    x = np.linspace(-1, 1, n)
    g = 0.3 - 0.5 * x * x - 1.5 * (1 - np.cos(13 * np.pi * x))
    return Lattice(1.0, 0.0, 1.0, (n / 70) ** 2, 0.5), g


def pulled(n):
    """Nothing is in contact for certain, and many spans could still be the best."""
    g = -0.3 - 0.3 * roughness(n, 3 * n // 20, 6)
    return Lattice(1.0, 0.0, 1.0, n / 5.0, 1.5), g


def flat(n):
    """A punch that is pulled: every node could be the start of a span to every other one."""
    return Lattice(1.0, 0.0, 1.0, (n / 3.0) ** 2, 0.5), np.full(n, -0.7)


@pytest.mark.parametrize("n", [2000, 16_000])
@pytest.mark.parametrize(("row", "most"), [(waves, 60), (pulled, 45), (flat, 220)])
def test_starts_compared_by_the_shortest_path(row, most, n, monkeypatch):
    """Per node; of a punch their number grows with the root of the number of nodes."""
    asked, costs = Counter(), lowest._costs

    def watched(chain, value, starts, k, height):
        asked["starts"] += starts.size
        return costs(chain, value, starts, k, height)

    monkeypatch.setattr(lowest, "_costs", watched)
    lowest.global_minimum(*row(n))
    assert n < asked["starts"] <= most * n


def test_the_first_state_with_finite_slopes_about_an_axis_solves_what_it_asks_for():
    """Two pieces of the family of menisci hold the line and the place beyond it."""
    menisci._piece.cache_clear()
    surfaces = SurfaceEnergies.from_work(0.07, 6e-5)
    given = {"slopes": "finite", "geometry": "axisymmetric"}
    minimise(Scene(ElasticLayer(2.5e3, 0.3, 5e-6), surfaces, Parabola(0.02), **given), 1e-7)
    assert menisci._piece.cache_info().misses <= 2


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
