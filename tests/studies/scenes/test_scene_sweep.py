"""Sweeps of scene files: axes, what `run` and `sweep` write, load paths."""

import importlib.util
import re

import numpy as np
import pytest
from scene_files import DEPTH, SURFACES, TEXT, refused, writer
from sweep_points import lines

from discretization import minimise
from studies.scenes import run as run_study
from studies.scenes.file import built, read
from studies.scenes.grid import SolvedScene, axes, placed
from studies.scenes.sweep import figure as sweep_figure
from studies.scenes.sweep import study
from studies.scenes.sweep.study import sweep
from studies.shared import table

WORKS = 'w = { from = 1e-4, to = 1e-2, steps = 3, spacing = "log" }'
SWEPT = TEXT.replace("E = 2e3", "E = [2e3, 4e3]").replace(SURFACES, WORKS)


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path / "tiny.toml", SWEPT)


@pytest.fixture
def scene(written):
    return written()


@pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None,
    reason="dask.distributed is not installed: pip install elastocap[sweep]",
)
@pytest.mark.filterwarnings("ignore")  # of dask's own imports and of its closing sockets
def test_a_dask_cluster_gives_the_same_numbers(scene, tmp_path):
    from distributed import Client, LocalCluster

    content = read(scene)
    grid = {axis.key: axis.values for axis in axes(scene, content)}
    function = SolvedScene(scene, content)
    here = sweep(function, grid, tmp_path / "here", jobs=1, identity="scene")
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None
        ) as c,
        Client(c) as client,
        client.get_executor() as executor,
    ):
        there = sweep(function, grid, tmp_path / "d", executor=executor, jobs=2, identity="scene")
    assert lines(tmp_path / "here") == lines(tmp_path / "d")
    assert here.failed == there.failed == 0


def test_lists_and_ranges_are_the_axes_of_a_scene(scene):
    found = axes(scene, read(scene))
    assert [axis.key for axis in found] == ["layer.E", "surfaces.w", "depth"]
    assert found[0].values == (2e3, 4e3)
    assert found[1].values == pytest.approx((1e-4, 1e-3, 1e-2), rel=1e-14, abs=0)
    assert found[2].values == (2e-6, 0.0, -4e-5)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"log"', '"square"', 'surfaces.w.spacing = \'square\' must be "linear" or "log"'),
        ("from = 1e-4", "from = 0", "surfaces.w.from = 0.0 to 0.01 crosses zero"),
        ("steps = 3", "steps = 1", "surfaces.w.steps = 1 must be a whole number of at least 2"),
        ("[2e3, 4e3]", "[]", "layer.E = [] must be a list of at least one number"),
        ("[2e3, 4e3]", '[2e3, "4e3"]', "layer.E[1] = '4e3' must be a number"),
        ("[2e3, 4e3]", "[2e3, 2e3]", "layer.E = [2000.0, 2000.0] has a value twice"),
        ("[layer]", "[lair]", "lair = "),
    ],
)
def test_an_unusable_axis_is_refused_by_file_and_key(written, tmp_path, old, new, told):
    scene = written((old, new))
    with refused(scene, re.escape(told)):
        study.main([str(scene), "--out", str(tmp_path / "out")])
    assert not (tmp_path / "out").exists()


def test_run_sweeps_a_scene_and_writes_what_minimise_says(scene, tmp_path, capsys):
    assert run_study.main([str(scene), "--out", str(tmp_path)]) == 0
    text, rows = (
        (tmp_path / "tiny_sweep.csv").read_text("utf-8"),
        table.read(tmp_path / "tiny_sweep.csv"),
    )
    assert len(rows) == 18
    content = read(scene)
    for row in rows:
        point = {key: float(row[key]) for key in ("layer.E", "surfaces.w", "depth")}
        given = built(scene, placed(content, point))
        state = minimise(given.scene, point["depth"], rtol=1e-6)
        assert float(row["force"]) == state.force
        assert float(row["half_width"]) == state.half_width
        assert (row["label"], row["error"]) == (state.label, "")
    assert "h/a" in rows[0]["violated"]
    assert "\n# versions: elastocap" in text
    assert (tmp_path / "tiny_sweep.png").stat().st_size > 10_000
    assert "18 of 18 points" in capsys.readouterr().err


def test_points_of_a_scene_that_fail_are_told(written, tmp_path, capsys):
    scene = written(("nu = 0.31", "nu = [0.31, 0.5]"))
    assert study.main([str(scene), "--out", str(tmp_path), "--jobs", "1"]) == 1
    assert "; 18 failed" in capsys.readouterr().out
    text = (tmp_path / "tiny_sweep.csv").read_text("utf-8")
    assert text.count("nu = 0.5 is outside (-1, 0.5)") == 18


def test_load_paths_are_swept(written, tmp_path):
    steps = "[path]\ndepths = [0, 1e-6, -4e-5]\nsteps = 3\n[options]"
    scene = written((DEPTH, ""), ("[2e3, 4e3]", "2e3"), ("[options]", steps))
    content = read(scene)
    (axis,) = axes(scene, content)
    assert axis.key == "surfaces.w"
    found = [SolvedScene(scene, content)({"surfaces.w": w}) for w in axis.values]
    assert [row["events"] for row in found] == ["jump-in; detachment"] * 3
    pulls = [row["pull_off_force"] for row in found]
    assert pulls[0] > pulls[1] > pulls[2]
    assert study.main([str(scene), "--out", str(tmp_path), "--jobs", "1"]) == 0


def test_a_scene_without_a_sweep_is_refused(written, tmp_path):
    scene = written(("[2e3, 4e3]", "2e3"), (DEPTH, "depth = 0"), (WORKS, "w = 1e-4"))
    with pytest.raises(ValueError, match="no list or range for a number: use"):
        study.main([str(scene), "--out", str(tmp_path)])


def drawn(written, tmp_path, *changes):
    """Force and half-width of a sweep in which some states are detached, and its rows."""
    scene = written(("[2e3, 4e3]", "2e3"), *changes)
    content = read(scene)
    grid = {axis.key: axis.values for axis in axes(scene, content)}
    record = sweep(SolvedScene(scene, content), grid, tmp_path / "a.jsonl", jobs=1, identity="s")
    figure = sweep_figure.plot(record, "drawn")
    columns, rows = study.table(record)
    return figure.axes, [dict(zip(columns, row, strict=True)) for row in rows]


def joined(axes):
    """Numbers of points of each unbroken stretch of the solid lines, and of crosses."""
    stretches, crosses = [], 0
    for line in axes.lines:
        known = np.isfinite(line.get_ydata())
        if line.get_marker() == "x":
            crosses += known.sum()
        elif line.get_marker() == "o":
            ends = np.flatnonzero(~known)
            stretches += [part.size for part in np.split(known, ends) if part.any()]
    return stretches, crosses


DEPTHS = "depth = [-4e-5, -3e-5, -1e-6, 0.0, 2e-6]"


@pytest.mark.parametrize("work", ["w = 1e-4", "w = [1e-4, 1e-3]"])
def test_lines_of_a_sweep_end_where_the_contact_ends(written, tmp_path, work):
    (force, width), rows = drawn(written, tmp_path, (DEPTH, DEPTHS), (WORKS, work))
    apart = sum(row["label"] == "detached" for row in rows)
    assert 2 <= apart < len(rows)
    for panel in (force, width):
        lines, crosses = joined(panel)
        assert crosses == apart
        assert max(lines) <= 4  # with the gap that ends a stretch
        for line in panel.lines:
            if line.get_marker() == "o":
                assert not (np.nan_to_num(line.get_ydata(), nan=1.0) == 0).any()
        assert "detached" in [text.get_text() for text in panel.get_legend().get_texts()]
    for row in rows:
        assert (row["label"] == "detached") == (row["half_width"] == 0)


def test_a_map_of_a_sweep_leaves_detached_states_out(written, tmp_path):
    many = 'w = { from = 1e-4, to = 1e-2, steps = 7, spacing = "log" }'
    deep = "depth = { from = -4e-5, to = 2e-6, steps = 7 }"
    (force, *_), rows = drawn(written, tmp_path, (DEPTH, deep), (WORKS, many))
    apart = sum(row["label"] == "detached" for row in rows)
    (colours,) = force.collections
    assert np.ma.getmaskarray(colours.get_array()).sum() == apart > 0
    assert force.lines[-1].get_xdata().size == apart
