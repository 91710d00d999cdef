"""Equilibria and load paths from Python: figures, data, one line each, and types."""

import doctest
import inspect
import math
import runpy
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.example_scenes import plain, rippled
from support.repository import ROOT

import discretization
import energy
from discretization import load_path, minimise, readings
from energy import ElasticLayer, FlatPunch, Parabola, Scene, SurfaceEnergies

SCENE = Scene(
    ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(0.07, 0.06e-3), Parabola(0.02)
)
LIFT = SCENE.critical_separation


@pytest.fixture(scope="module")
def state():
    return minimise(SCENE, 0.5 * LIFT)


@pytest.fixture(scope="module")
def path():
    return load_path(SCENE, depths=np.array([-0.5, 0.0, 1.0, 0.0, -1.2]) * LIFT)


def test_a_state_is_told_in_one_line_and_in_full(state):
    line = repr(state)
    assert "\n" not in line
    assert line.startswith("Equilibrium(depth=")
    assert len(line) < 200
    assert f"force={state.force:.6g}" in line
    assert f"label={state.label!r}" in line
    assert str(state).splitlines()[0].startswith("depth        d = ")
    assert (
        state._repr_html_() == f"<pre>{str(state).replace('<', '&lt;').replace('>', '&gt;')}</pre>"
    )


def test_numbers_have_units_and_digits():
    """As many digits as their errors allow."""
    nodes = {"method": "lattice", "spacing": SCENE.elastocapillary_length / 20}
    state = minimise(SCENE, LIFT, **nodes)
    shown = readings.rounded
    assert shown(0.01413690508, 3.8e-3) == "0.014"
    assert shown(-2.0, 30.0) == "-2"
    assert shown(1 / 3, 1e-18) == "0.3333333333"
    assert shown(1.25, math.inf) == "1.25"
    width = shown(state.half_width, state.uncertainty["half_width"])
    assert len(width.lstrip("0.")) < 8
    assert f"half-width   a = {width} m   (numerical" in str(state)
    for part in ("force        P = ", "energy       U = ", "angle        θ = "):
        (line,) = [line for line in str(state).splitlines() if line.startswith(part)]
        unit = {"f": " N/m", "e": " J/m", "a": " rad"}[part[0]]
        assert line.count(unit) == 2, line
    exact = minimise(SCENE, LIFT)
    assert str(exact).count("numerical error below rounding") == 4
    around = str(minimise(replace(SCENE, geometry="axisymmetric"), LIFT))
    assert " N   (" in around
    assert " J   (" in around
    assert "radius       a = " in around


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_the_error_of_the_angle_covers_what_it_is_off_by(slopes):
    """By Young's law, or its small-slope form, for lines anywhere between the nodes."""
    scene = replace(SCENE, slopes=slopes)
    surfaces = scene.surfaces
    law = surfaces.angle_deficit if slopes == "finite" else surfaces.small_slope_deficit
    for depth in np.linspace(-0.4, 1.4, 7) * LIFT:
        for per_length in (8, 31):
            spacing = scene.elastocapillary_length / per_length
            state = minimise(scene, depth, method="lattice", spacing=spacing)
            off = abs(state.angle_deficit - law)
            assert off < state.contact_angle_error < 20 * off + 1e-9
        exact = minimise(scene, depth)
        assert abs(exact.angle_deficit - law) < exact.contact_angle_error < 1e-10


def test_a_pinned_line_is_marked_and_no_line_has_no_angle():
    punch = Scene(SCENE.layer, SCENE.surfaces, FlatPunch(1e-4))
    assert "; pinned at a corner)" in str(minimise(punch, 0.0))
    apart = minimise(SCENE, -2 * LIFT)
    assert "angle        none, as there is no contact line" in str(apart)
    assert math.isnan(apart.contact_angle_error)


def test_a_state_is_a_row_of_plain_data(state):
    row = state.to_dict()
    for name in ("depth", "half_width", "force", "energy", "contact_angle"):
        assert row[name] == getattr(state, name)
        assert type(row[name]) is float
    assert row["error_force"] == state.uncertainty["force"]
    assert (row["label"], row["branch"], row["method"]) == (state.label, "adhered", state.method)
    assert row["contacts"] == 1
    assert minimise(SCENE, -2 * LIFT).to_dict()["contacts"] == 0


def test_a_path_is_told_with_its_events(path):
    assert len(path) == path.depth.size == 5
    line = repr(path)
    assert "\n" not in line
    assert "5 steps of depth" in line
    assert "events" in line
    assert len(line) < 200
    told = str(path).splitlines()
    assert len(told) == 4 + len(path.events)
    for event, text in zip(path.events, told[2:], strict=False):
        assert text.startswith(event.kind)
        assert float(text.split()[-1]) == pytest.approx(event.energy_released, rel=1e-5, abs=1e-30)
    assert f"P = {path.pull_off.force:.6g}" in told[-2]
    assert "force/(N/m)" in told[1]
    assert path._repr_html_().startswith("<pre>load path: 5 steps")


def test_a_path_without_tension_or_steps_is_told_too():
    pressed = load_path(SCENE, depths=[-LIFT, -0.5 * LIFT])
    assert "most tensile" not in str(pressed)
    assert "0 events" in str(pressed)
    empty = discretization.History(SCENE, "depth", None, 1e-8, None)
    assert len(empty) == 0
    assert empty
    assert "0 steps" in repr(empty)


def test_a_path_is_columns_of_plain_data(path):
    columns = path.to_dict()
    assert {values.shape for values in columns.values()} == {(5,)}
    assert columns["force"] is path.force
    assert columns["control"] is path.values
    assert columns["contacts"].tolist() == [0, 1, 1, 1, 0]
    assert np.isnan(columns["left"]).tolist() == [True, False, False, False, True]
    assert columns["half_width"][2] == pytest.approx(columns["right"][2], rel=1e-12)


def test_contacts_are_counted_where_there_are_several():
    waves = rippled(20.0, math.pi / 2, 0.05)
    scene = plain(waves, w=1e-4, gamma1=0.05)
    several = load_path(scene, depths=[0.0, 0.1], method="lattice", spacing=0.01)
    counts = several.to_dict()["contacts"]
    assert counts[-1] == len(several.inner[-1]) // 2 + 1 >= 2


def test_a_state_is_drawn(state):
    figure = state.plot("a title")
    surface, line = figure.axes
    assert figure.get_suptitle() == "a title"
    assert surface.get_xlabel() == "position x in µm"
    assert "in nm" in surface.get_ylabel()
    (drawn,) = [one for one in surface.lines if one.get_label() == "surface u"]
    x, u = np.array(drawn.get_data()) * [[1e-6], [1e-9]]
    np.testing.assert_allclose(u, state.displacement(x), atol=1e-9 * LIFT)
    assert f"{math.degrees(state.angle_deficit):.3g}°" in line.get_title()


def test_a_detached_state_is_drawn_without_a_line():
    _, line = minimise(SCENE, -2 * LIFT).plot().axes
    assert not line.axison


def test_plain_numbers_are_drawn_without_units(state, path):
    for figure in (state.plot(si=False), path.plot(si=False)):
        for axes in figure.axes:
            for text in (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()):
                assert " in " not in text.replace("last in", "")
                assert "µ" not in text
    (drawn,) = [a for a in state.plot(si=False).axes[0].lines if a.get_label() == "surface u"]
    x, u = drawn.get_data()
    np.testing.assert_array_equal(u, state.displacement(x))


def test_a_path_is_drawn_with_its_events(path):
    figure = path.plot("loop")
    force, width = figure.axes
    assert force.get_ylabel().startswith("force P in ")
    assert width.get_xlabel().startswith("depth d")
    names = force.get_legend_handles_labels()[1]
    assert {event.kind for event in path.events} <= set(names)
    driven = load_path(SCENE, forces=[0.0, 0.01, -0.1])
    assert len(driven.plot().axes) == 3


def test_matplotlib_is_imported_when_something_is_drawn():
    code = """
import sys
from discretization import load_path, minimise, readings
from energy import ElasticLayer, FlatPunch, Parabola, Scene, SurfaceEnergies
scene = Scene(ElasticLayer(1, 0, 1), SurfaceEnergies.from_work(1, 0.1), Parabola(9))
state, path = minimise(scene, 0.1), load_path(scene, depths=[0, 0.1])
str(state), repr(path), state.to_dict(), path.to_dict()
assert "matplotlib" not in sys.modules
state.plot(), path.plot()
assert "matplotlib.figure" in sys.modules and "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True, cwd=ROOT)


def test_the_public_names_are_complete():
    for package in (energy, discretization):
        public = {
            name
            for name, value in vars(package).items()
            if getattr(value, "__module__", "").startswith(package.__name__)
            and not name.startswith("__")
        }
        assert public <= set(package.__all__)
        assert all(hasattr(package, name) for name in package.__all__)


def test_what_a_user_writes_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(Path(__file__).with_name("user_script.py")))
    width, error, kinds = capsys.readouterr().out.split(maxsplit=2)
    assert float(width) == pytest.approx(1.6e-4, rel=0.01)
    assert abs(float(error)) < 1e-12
    assert kinds == "['jump-in', 'detachment']\n"
    assert (tmp_path / "state.png").stat().st_size > 1e4 < (tmp_path / "path.png").stat().st_size


def test_types_are_known_to_those_who_import():
    build = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]["build"]
    wheel = build["targets"]["wheel"]  # all files of these folders but pictures
    assert wheel["packages"] == ["energy", "discretization", "studies"]
    assert wheel["exclude"] == ["studies/gallery"]
    assert all((ROOT / package / "py.typed").is_file() for package in wheel["packages"])


def test_modules_that_are_not_imported():
    """Beyond those of scipy.linalg, which in some versions imports scipy.sparse."""
    codes = ("numpy, scipy.linalg", "energy, discretization", "cvxpy, matplotlib.figure")
    code = "\n".join(f"import {names}, sys; print(*sys.modules)" for names in codes)
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    least, plain, everything = ({*line.split()} for line in loaded.stdout.splitlines())
    unwanted = {"cvxpy", "matplotlib", "scipy.sparse", "scipy.optimize"}
    assert not unwanted & (plain - least)
    assert len(plain) < len(everything) / 2


FUNCTIONS = (discretization.minimise, discretization.load_path, energy.read_profile)
MADE = (
    *(energy.ElasticLayer, energy.SurfaceEnergies, energy.Scene, energy.Patches, energy.Profile),
    *(energy.FlatPunch, energy.Wedge, energy.Parabola, energy.Circle, energy.PowerLaw),
    *(energy.Sampled, energy.SurfaceEnergies.from_work),
)
FOUND = (discretization.Equilibrium, discretization.History, discretization.Event)
FIRST = (*FUNCTIONS, *MADE, *FOUND, energy.Plane, energy.Assumption)


@pytest.mark.parametrize("thing", FIRST, ids=lambda thing: thing.__qualname__)
def test_help_has_numpydoc_sections_and_examples(thing):
    """Help answers in the sections of numpydoc and its examples run."""
    text = inspect.getdoc(thing)
    heads = {
        line
        for line, rule in zip(text.split("\n"), text.split("\n")[1:], strict=False)
        if rule == "-" * len(line) and line
    }
    assert "\n" not in text.split("\n\n")[0]
    assert "Examples" in heads
    assert thing not in (*FUNCTIONS, *MADE) or "Parameters" in heads
    assert thing not in FUNCTIONS or "Raises" in heads
    assert thing not in FOUND or "Attributes" in heads
    if "Parameters" in heads:
        section = text.split("Parameters\n----------\n")[1].split("\n\n")[0]
        told = {
            name.strip()
            for line in section.split("\n")
            if not line.startswith(" ")
            for name in line.split(" : ")[0].split(",")
        }
        assert set(inspect.signature(thing).parameters) <= told | {"given_by_work"}
    known = {}  # what is found goes on from what the functions find
    for one in (*FUNCTIONS[:2], thing) if thing in FOUND else (thing,):
        known |= run(one, known)


def run(thing, known):
    """What the examples of a docstring leave behind, which begin with what is known."""
    text = inspect.getdoc(thing)
    said = []
    test = doctest.DocTestParser().get_doctest(text, known, thing.__qualname__, None, None)
    assert test.examples
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(test, out=said.append, clear_globs=False)
    assert not said, "".join(said)
    return test.globs


def test_the_returned_things_are_named():
    for function in (discretization.minimise, discretization.load_path):
        returned = inspect.signature(function).return_annotation.__name__
        assert f"Returns\n-------\n{returned}\n" in inspect.getdoc(function)
    assert len(FIRST) == 20
