"""The study `run`: its table, what it says, its figures, and the shipped scenes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from project import ROOT
from scene_files import DEPTH, by_hand, refused, writer

from discretization import minimise
from energy import ElasticLayer, FlatPunch, Parabola, Plane, SurfaceEnergies, Wedge
from studies.scenes import run as study
from studies.scenes.file import load
from studies.shared.table import read

SHIPPED = sorted((ROOT / "studies" / "scenes").glob("*.toml"))


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path / "tiny.toml")


COLUMNS = ("depth", "half_width", "force", "energy", "contact_angle")


def test_a_run_writes_what_minimise_says(written, tmp_path, capsys):
    out, path = tmp_path / "new" / "folder", written()
    assert study.main([str(path), "--out", str(out)]) == 0
    text, rows = (out / "tiny.csv").read_text("utf-8"), read(out / "tiny.csv")
    header = [line[2:] for line in text.splitlines() if line.startswith("# ")]
    assert len(rows) == 3
    for row, depth in zip(rows, (2e-6, 0.0, -4e-5), strict=True):
        state = minimise(by_hand(Parabola(0.017)), depth, rtol=1e-6)
        assert row.pop("label") == state.label
        wanted = {name: getattr(state, name) for name in COLUMNS[:5]}
        wanted |= {f"error_{name}": state.uncertainty[name] for name in COLUMNS[1:4]}
        assert list(row) == list(wanted)
        for name, value in wanted.items():
            assert float(row[name]) == value or (math.isnan(value) and row[name] == "nan"), name
    assert [float(row["half_width"]) > 0 for row in rows] == [True, True, False]
    assert "title: A test" in header
    assert header[0] == f"command: python -m studies run {path} --out {out}"
    scene = ("ElasticLayer(E=2000.0, nu=0.31, h=6e-05)", "Parabola(R=0.017)", "'rtol': 1e-06")
    for part in (*scene, "nowhere", "force in N/m", "force > 0 compressive"):
        assert any(part in line for line in header), part
    assert (out / "tiny.png").stat().st_size > 10_000
    said = capsys.readouterr().out
    assert said.count("global, adhered branch") == 1 and said.count("  global") == 2
    assert "violated: h/a" in said
    assert "all assumptions hold in 0 of 2 states in contact" in said
    assert "validity     h/a" in said


def test_one_depth_is_told_in_full(written, tmp_path, capsys):
    path = written((DEPTH, "depth = 2e-6"))
    assert study.main([str(path), "--out", str(tmp_path)]) == 0
    assert str(minimise(by_hand(Parabola(0.017)), 2e-6, rtol=1e-6)) in capsys.readouterr().out


def test_options_reach_the_minimiser(written):
    options = 'method = "lattice"\nspacing = 3e-6\nbranch = "adhered"'
    record = study.run(load(written(("rtol = 1e-6", options))))
    assert {(state.method, state.spacing) for state in record.states} == {("lattice", 3e-6)}


def test_what_the_minimiser_refuses_names_file_and_depth(written):
    path = written(("rtol = 1e-6", 'method = "magic"'))
    with refused(path, "depth = 2e-06: method = 'magic'.*'lattice'"):
        study.run(load(path))


def test_the_worst_state_and_the_violations_are_those_in_contact(written):
    record = study.run(load(written()))
    assert [state.label == "detached" for state in record.states] == [False, False, True]
    assert record.worst is record.states[1]  # the narrower contact
    widest = {one.name: one.value for one in record.violated}
    assert widest["h/a"] == 60e-6 / record.states[1].half_width


@pytest.fixture(scope="module")
def drawn():
    """Axes of the figure of a scene at some depths."""

    def draw(indenter, depths):
        given = load(SHIPPED[0])
        film, surfaces = ElasticLayer(400.0, 0.31, 60e-6), SurfaceEnergies.from_work(0.05, 1e-4)
        scene = replace(by_hand(indenter), layer=film, surfaces=surfaces)
        given = replace(given, scene=scene, depths=np.array(depths), options={}, title="drawn")
        figure = study.plot(study.run(given))
        figure.draw_without_rendering()
        return figure

    return draw


def test_the_figure_of_several_depths(drawn):
    figure = drawn(Parabola(0.017), [2e-6, 0.0, -4e-5])
    force, width, whole, _ = figure.axes
    assert force.get_ylabel() == "force P in mN/m"
    assert width.get_ylabel() == "half-width a in µm"
    assert force.get_xlabel() == "depth d in µm"
    assert [text.get_text() for text in force.get_legend().get_texts()][-1] == "detached"
    assert whole.get_title().startswith("surface at d = 0 m, last in contact")
    assert "h/a up to" in figure.get_supxlabel()


@pytest.mark.parametrize(
    ("indenter", "depths"),
    [
        (Plane(), [1e-6]),
        (Plane(), [1e-6, -1e-6, -1e-3]),
        (Parabola(0.1), [-1e-3]),
        (Parabola(0.1), [-1e-3, -2e-3]),
        (FlatPunch(1e-3), [0.0]),
        (Wedge(0.01).shifted(2e-4), [1e-6]),
    ],
)
def test_contacts_without_lines_or_width_are_drawn(drawn, indenter, depths):
    figure = drawn(indenter, depths)
    surface = figure.axes[-2]
    bottom, top = surface.get_ylim()
    assert bottom > top
    lowest = surface.collections[1].get_paths()[0].vertices[:, 1].max()  # the indenter is in sight
    assert top < lowest < bottom


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_scenes_give_certified_states(path):
    given = load(path)
    assert given.source
    assert given.title != path.stem
    depths = given.depths[:: max(1, given.depths.size // 8)]
    record = study.run(replace(given, depths=depths))
    assert record.attached
    for state in record.states:
        assert state.certificate.ok
        assert max(state.error_estimate.values()) <= 1e-8
    honest = "VIOLATED" in path.read_text("utf-8")
    assert honest == bool(record.violated)


def test_there_are_scenes_of_four_kinds():
    shapes = {type(load(path).scene.indenter) for path in SHIPPED}
    assert len(SHIPPED) >= 4
    assert shapes >= {Parabola, Wedge, FlatPunch}
