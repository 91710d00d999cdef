"""Sweeps: the same numbers wherever they are computed, nothing lost when killed, failures kept."""

import importlib.util
import json
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from support.repository import MODULE_PATH
from support.scene_files import DEPTH, SURFACES, TEXT, refused, writer
from support.sweep_points import cheap, gone, lines, slow

from discretization import minimise
from studies.scenes import run as run_study
from studies.scenes.file import built, read
from studies.scenes.grid import Axis, Grid, SolvedScene, axes, placed
from studies.scenes.sweep import figure as sweep_figure
from studies.scenes.sweep import study
from studies.scenes.sweep.store import Record
from studies.scenes.sweep.study import sweep
from studies.shared import table

AXES = {"x": [1.0, 2.0, 0.1], "y": [3.0, 1e-17, 7.0, -2.0]}


def test_a_sweep_finds_each_point_and_keeps_its_failure(tmp_path):
    """The last axis is the fastest."""
    seen = []
    record = sweep(cheap, AXES, tmp_path / "a.jsonl", jobs=1, show=seen.append)
    assert [result["at"] for result in record.results] == list(range(12))
    assert record.failed == 1 and record.results[4]["error"] == "ValueError: no state here"
    points = [{"x": x, "y": y} for x in AXES["x"] for y in AXES["y"]]
    assert [record.grid.point(i) for i in range(12)] == points
    wanted = [cheap(point)["sum"] for point in points if point != points[4]]
    assert np.delete(record.column("sum"), 4).tolist() == wanted  # to the last bit
    assert np.isnan(record.column("none")).all() and np.isnan(record.column("sum")[4])
    assert (seen[-1].done, seen[-1].total, seen[-1].failed) == (12, 12, 1)


@pytest.mark.slow
def test_processes_and_threads_give_the_same_file(tmp_path):
    here, there, threads = (tmp_path / name for name in ("1", "2", "3"))
    sweep(cheap, AXES, here, jobs=1)
    sweep(cheap, AXES, there, jobs=2)
    with ThreadPoolExecutor(3) as executor:
        sweep(cheap, AXES, threads, executor=executor, jobs=3)
    assert lines(here) == lines(there) == lines(threads)


def test_a_sweep_goes_on_where_it_was_and_computes_nothing_twice(tmp_path):
    path = tmp_path / "a.jsonl"
    whole = sweep(cheap, AXES, path, jobs=1)
    text = path.read_text("utf-8").splitlines()
    cut = "\n".join([*text[:6], text[6][:-7]])  # killed within a line
    path.write_text(cut, "utf-8")
    again = sweep(cheap, AXES, path, jobs=1)
    assert again.results == whole.results
    after = path.read_text("utf-8")
    assert after.startswith(cut + "\n")
    assert len(after.splitlines()) == len(text) + 1  # the half line, and the point it was for
    sweep(cheap, AXES, path, jobs=1)
    assert path.read_text("utf-8") == after


def test_failed_points_are_tried_again_on_demand(tmp_path):
    path = tmp_path / "a.jsonl"
    sweep(cheap, AXES, path, jobs=1)
    text = path.read_text("utf-8").replace('{"at": 0, "found"', '{"at": 0, "error": "x", "was"')
    path.write_text(text, "utf-8")
    assert sweep(cheap, AXES, path, jobs=1).failed == 2
    assert sweep(cheap, AXES, path, jobs=1, retry=True).failed == 1


def test_another_sweep_and_unusable_arguments_are_refused(tmp_path):
    path = tmp_path / "a.jsonl"
    sweep(cheap, AXES, path, jobs=1)
    with pytest.raises(ValueError, match=r"another command \(it differs in axes\): give another"):
        sweep(cheap, AXES | {"y": [3.0]}, path, jobs=1)
    with pytest.raises(ValueError, match="differs in function"):
        sweep(slow, AXES, path, jobs=1)
    path.write_text("x,y\n1,2\n")
    with pytest.raises(ValueError, match="another command"):
        sweep(cheap, AXES, path, jobs=1)
    with pytest.raises(ValueError, match="jobs = 0 must be at least 1"):
        sweep(cheap, AXES, tmp_path / "b", jobs=0)
    with pytest.raises(ValueError, match=r"y = .* has no values"):
        sweep(cheap, AXES | {"y": []}, tmp_path / "b", jobs=1)
    assert not (tmp_path / "b").exists()


MANY = {"x": [1.0, 2.0, *range(5, 11)], "y": [3.0, *range(10, 19)]}
KILLED = f"""
if __name__ == "__main__":
    import sys
    from studies.scenes.sweep.study import sweep
    from support.sweep_points import held
    sweep(held, {MANY}, sys.argv[1], jobs=2)
"""


@pytest.mark.slow
def test_sweep_killed_several_times(tmp_path):
    """Each time it stops after 26 lines more, in the midst of its points, until it is killed."""
    script = tmp_path / "killed.py"
    path = tmp_path / "a.jsonl"
    seen = [0]
    script.write_text(KILLED)

    def kept():
        return path.read_text("utf-8").splitlines() if path.exists() else []

    ended = False
    while not ended:
        count = seen[-1] + 26
        given = {"HELD_BY": str(path), "HELD_FROM": str(count), "PYTHONPATH": MODULE_PATH}
        child = subprocess.Popen(
            [sys.executable, script, path], start_new_session=True, env=os.environ | given
        )
        while child.poll() is None:
            if len(kept()) >= count:
                child.send_signal(signal.SIGKILL)
            time.sleep(0.01)
        assert child.wait() in (0, -signal.SIGKILL)
        assert gone(child.pid)
        assert len(kept()) > seen[-1]
        seen.append(len(kept()))
        ended = child.returncode == 0
    assert len(seen) >= 4  # it was killed at least twice
    record = sweep(cheap, MANY, path, jobs=1, identity="support.sweep_points.held")
    whole = [json.loads(line)["at"] for line in kept()[1:] if line.endswith("}")]
    assert sorted(whole) == list(range(80))  # each point once: nothing lost, none twice
    assert record.failed == 1
    found = [result["found"]["sum"] for result in record.results if "found" in result]
    assert found == [cheap(record.grid.point(i))["sum"] for i in range(80) if i != 10]


WORKS = 'w = { from = 1e-4, to = 1e-2, steps = 3, spacing = "log" }'
SWEPT = TEXT.replace("E = 2e3", "E = [2e3, 4e3]").replace(SURFACES, WORKS)


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path / "tiny.toml", SWEPT)


@pytest.fixture
def scene(written):
    return written()


def solved(scene):
    """What a sweep of this scene file calls, and the axes of its grid."""
    content = read(scene)
    return SolvedScene(scene, content), {axis.key: axis.values for axis in axes(scene, content)}


@pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None,
    reason="dask.distributed is not installed: pip install elastocap[sweep]",
)
@pytest.mark.filterwarnings("ignore")  # of dask's own imports and of its closing sockets
def test_a_dask_cluster_gives_the_same_numbers(scene, tmp_path):
    from distributed import Client, LocalCluster

    function, grid = solved(scene)
    here = sweep(function, grid, tmp_path / "here", jobs=1, identity="scene")
    local = {"n_workers": 2, "threads_per_worker": 1, "processes": False}
    with (
        LocalCluster(**local, dashboard_address=None) as cluster,
        Client(cluster) as client,
        client.get_executor() as executor,
    ):
        there = sweep(function, grid, tmp_path / "d", executor=executor, jobs=2, identity="scene")
    for one, other in zip(here.results, there.results, strict=True):
        assert same(one["found"], other["found"])
    assert here.failed == there.failed == 0


@pytest.mark.parametrize("shape", ['"parabola"\nR = 0.02', '"flat_punch"\nhalf_width = 3e-5'])
@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_points_found_together_are_those_found_alone(shape, geometry, tmp_path):
    """Observables, labels and violated assumptions; a point that is refused says so itself."""
    path = tmp_path / "scene.toml"
    path.write_text(
        "depth = 0.0\n[layer]\nE = 2.5e3\nnu = 0.3\nh = 5e-6\n[surfaces]\ngamma1 = 0.07\n"
        f'w = 6e-5\n[indenter]\nshape = {shape}\n[options]\ngeometry = "{geometry}"\n'
    )
    function = SolvedScene(path, read(path))
    works = (-1.0, 0.0, 3e-5, 9e-5)
    depths = (-5e-7, -2e-7, 0.0, 6e-7)
    points = [{"surfaces.w": w, "depth": d} for w in works for d in depths]
    assert function.many(points) == [None] * 16  # -1.0 is no work of adhesion
    found = function.many(points[4:])
    assert sum(one is None for one in found) <= 4
    for point, one in zip(points[4:], found, strict=True):
        other = function(point)
        if one is not None:
            errors = [name for name in other if name.startswith("error")]
            for name in errors:
                assert 0 <= one.pop(name) <= 10 * other.pop(name)
            assert repr(one.pop("contact_angle"))[:12] == repr(other.pop("contact_angle"))[:12]
            assert same(one, other)


def same(one, other):
    """Whether two points differ by rounding at most: states are found in batches."""
    assert list(one) == list(other)
    sizes = {name: abs(value) for name, value in one.items() if isinstance(value, float)}
    texts = [(one[name], other[name]) for name in one if name not in sizes]
    off = [abs(one[name] - other[name]) <= 1e-12 * size for name, size in sizes.items()]
    return all(a == b for a, b in texts) and all(off)


def test_lists_and_ranges_are_the_axes_of_a_scene(scene):
    _, found = solved(scene)
    assert list(found) == ["layer.E", "surfaces.w", "depth"]
    assert found["layer.E"] == (2e3, 4e3) and found["depth"] == (2e-6, 0.0, -4e-5)
    assert found["surfaces.w"] == pytest.approx((1e-4, 1e-3, 1e-2), rel=1e-14, abs=0)


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


@pytest.mark.slow
def test_run_sweeps_a_scene_and_writes_what_minimise_says(scene, tmp_path, capsys):
    assert run_study.main([str(scene), "--out", str(tmp_path)]) == 0
    rows = table.read(tmp_path / "tiny_sweep.csv")
    content = read(scene)
    assert len(rows) == 18
    for row in rows:
        point = {key: float(row[key]) for key in ("layer.E", "surfaces.w", "depth")}
        state = minimise(built(scene, placed(content, point)).scene, point["depth"], rtol=1e-6)
        found = [float(row["force"]), float(row["half_width"])]
        assert found == pytest.approx([state.force, state.half_width], rel=1e-12, abs=0)
        assert (row["label"], row["error"]) == (state.label, "")
    assert "h/a" in rows[0]["violated"]
    assert "\n# versions: elastocap" in (tmp_path / "tiny_sweep.csv").read_text("utf-8")
    assert (tmp_path / "tiny_sweep.png").stat().st_size > 10_000
    assert "18 of 18 points" in capsys.readouterr().err


def test_points_of_a_scene_that_fail_are_told(written, tmp_path, capsys):
    scene = written(("nu = 0.31", "nu = [0.31, 0.5]"))
    assert study.main([str(scene), "--out", str(tmp_path), "--jobs", "1"]) == 1
    assert "FAILED: 18 of 36 points" in capsys.readouterr().out
    text = (tmp_path / "tiny_sweep.csv").read_text("utf-8")
    assert text.count("nu = 0.5 is outside (-1, 0.5)") == 18


def test_load_paths_are_swept(written, tmp_path):
    steps = "[path]\ndepths = [0, 1e-6, -4e-5]\nsteps = 3\n[options]"
    scene = written((DEPTH, ""), ("[2e3, 4e3]", "2e3"), ("[options]", steps))
    assert study.main([str(scene), "--out", str(tmp_path), "--jobs", "1"]) == 0
    rows = table.read(tmp_path / "tiny_sweep.csv")
    assert [row["events"] for row in rows] == ["jump-in; detachment"] * 3
    pulls = [float(row["pull_off_force"]) for row in rows]
    assert pulls[0] > pulls[1] > pulls[2]


def test_a_scene_without_a_sweep_is_refused(written, tmp_path):
    scene = written(("[2e3, 4e3]", "2e3"), (DEPTH, "depth = 0"), (WORKS, "w = 1e-4"))
    with pytest.raises(ValueError, match="no list or range for a number: use"):
        study.main([str(scene), "--out", str(tmp_path)])


def test_a_map_of_a_sweep_leaves_detached_states_out(written, tmp_path):
    many = 'w = { from = 1e-4, to = 1e-2, steps = 7, spacing = "log" }'
    deep = "depth = { from = -4e-5, to = 2e-6, steps = 7 }"
    path = written(("[2e3, 4e3]", "2e3"), (DEPTH, deep), (WORKS, many))
    function, grid = solved(path)
    record = sweep(function, grid, tmp_path / "a.jsonl", jobs=1, identity="s")
    columns, rows = study.table(record)
    apart = sum(row[columns.index("label")] == "detached" for row in rows)
    force = sweep_figure.plot(record, "drawn").axes[0]
    (colours,) = force.collections
    assert np.ma.getmaskarray(colours.get_array()).sum() == apart > 0
    assert force.lines[-1].get_xdata().size == apart


def test_a_logarithmic_range_has_a_logarithmic_axis():
    """And negative depths have a minus."""
    works = tuple(np.geomspace(1e-5, 7e-5, 5).tolist())
    grid = Grid((Axis("surfaces.w", works), Axis("depth", (-1e-6, 0.0, 1e-6))))
    found = [{"force": at, "half_width": 1e-6, "label": "global"} for at in range(15)]
    record = Record(grid, tuple({"at": i, "found": f} for i, f in enumerate(found)))
    figure = sweep_figure.plot(record, "A title")
    assert figure.axes[0].get_xscale() == "log"
    (legend,) = figure.legends
    assert "depth d = −1 µm" in [text.get_text() for text in legend.get_texts()]
    for values, log in (((1, 2, 3, 4), 0), ((1, 2, 4, 8), 1), ((1, 9), 0), ((0, 1, 10), 0)):
        assert sweep_figure._by_ratios(np.array(values, float)) == bool(log), values


@pytest.mark.parametrize("unknown", ["force", "half_width"])
@pytest.mark.parametrize("lines", [1, 2, 7])
def test_unresolved_states_of_a_sweep_are_marked(lines, unknown):
    """An error that is not known is no error bar of length 0."""
    depths = tuple(float(n) for n in range(1, 10))
    axes = (Axis("depth", depths), Axis("surfaces.gamma1", tuple(0.01 * n for n in range(lines))))
    grid = Grid(axes[: 1 if lines == 1 else 2])
    common = {"half_width": 1.0, "error_half_width": 0.1, "error_force": 0.1, "label": "global"}
    found = [{**common, "force": 1.0 + at} for at in range(len(grid))]
    found[3][f"error_{unknown}"] = None
    results = tuple({"at": at, "found": one} for at, one in enumerate(found))
    figure = sweep_figure.plot(Record(grid, results), "A title")
    marked, other = figure.axes[:2] if unknown == "force" else figure.axes[1::-1]
    (circles,) = [line for line in marked.lines if line.get_markerfacecolor() == "white"]
    assert circles.get_xdata().tolist() == [grid.point(3)["depth"]]
    assert not any(line.get_markerfacecolor() == "white" for line in other.lines)
    (legend,) = figure.legends
    assert sweep_figure.UNRESOLVED["label"] in [text.get_text() for text in legend.get_texts()]
    bars = [bar for part in marked.containers for bar in part.lines[2][0].get_segments()]
    drawn = len(grid) - 1 if lines <= sweep_figure.LINES else 0  # a map has none
    assert sum(bar.size > 0 for bar in bars) == drawn


@pytest.mark.parametrize(("depths", "lines"), [((1.0, 2.0, 3.0), 2), (tuple(range(9)), 7)])
def test_figure_of_a_sweep_axes_and_omissions(depths, lines):
    """Three axes: the longest along x, the second as lines or a map, of the third one value."""
    tensions = tuple(0.01 * n for n in range(1, lines + 1))
    axes = Axis("depth", depths), Axis("surfaces.gamma1", tensions), Axis("layer.h", (1e-6,) * 2)
    count = len(Grid(axes))
    labels = ["detached" if at == 0 else "global" for at in range(count)]
    found = [{"force": at, "half_width": 1e-6, "label": label} for at, label in enumerate(labels)]
    record = Record(Grid(axes), tuple({"at": i, "found": f} for i, f in enumerate(found)))
    figure = sweep_figure.plot(record, "A title")
    first = figure.axes[0]
    assert first.get_xlabel() == "depth d in m"
    assert "thickness h = 1 µm, one of 2; the others are in the table" in figure.get_suptitle()
    (legend,) = figure.legends
    told = [text.get_text() for text in legend.get_texts()]
    assert "detached" in told and first.get_legend() is None  # beside the data
    if lines > sweep_figure.LINES:
        assert first.get_ylabel() == "surface tension γ₁ in mJ/m²"
    else:
        assert "surface tension γ₁ = 10 mJ/m²" in told
