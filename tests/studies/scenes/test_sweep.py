"""Sweeps: the same numbers wherever they are computed, nothing lost when killed, failures kept."""

import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from project import PLACES
from sweep_points import cheap, gone, lines, slow

from studies.scenes.grid import Axis
from studies.scenes.sweep.batches import SECONDS, Batch, BatchClock
from studies.scenes.sweep.store import Store
from studies.scenes.sweep.study import Grid, sweep

AXES = {"x": [1.0, 2.0, 0.1], "y": [3.0, 1e-17, 7.0, -2.0]}


def test_points_are_numbered_with_the_last_axis_fastest():
    grid = Grid((Axis("a", (1.0, 2.0)), Axis("b", (5.0, 6.0, 7.0))))
    pairs = [tuple(grid.point(i).values()) for i in range(len(grid))]
    assert pairs == [(1.0, 5.0), (1.0, 6.0), (1.0, 7.0), (2.0, 5.0), (2.0, 6.0), (2.0, 7.0)]


def test_a_sweep_finds_each_point_and_keeps_its_failure(tmp_path):
    seen = []
    record = sweep(cheap, AXES, tmp_path / "a.jsonl", jobs=1, show=seen.append)
    assert [result["at"] for result in record.results] == list(range(12))
    assert record.failed == 1
    assert record.results[4]["error"] == "ValueError: no state here"
    wanted = [cheap(record.grid.point(i))["sum"] for i in range(12) if i != 4]
    assert np.delete(record.column("sum"), 4).tolist() == wanted  # to the last bit
    assert np.isnan(record.column("none")).all() and np.isnan(record.column("sum")[4])
    assert (seen[-1].done, seen[-1].total, seen[-1].failed) == (12, 12, 1)
    assert str(seen[-1]) == "12 of 12 points, 1 failed"


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
    with pytest.raises(ValueError, match=r"another sweep \(it differs in axes\): give another"):
        sweep(cheap, AXES | {"y": [3.0]}, path, jobs=1)
    with pytest.raises(ValueError, match="differs in function"):
        sweep(slow, AXES, path, jobs=1)
    path.write_text("x,y\n1,2\n")
    with pytest.raises(ValueError, match="another sweep"):
        sweep(cheap, AXES, path, jobs=1)
    with pytest.raises(ValueError, match="jobs = 0 must be at least 1"):
        sweep(cheap, AXES, tmp_path / "b", jobs=0)
    with pytest.raises(ValueError, match=r"y = .* has no values"):
        sweep(cheap, AXES | {"y": []}, tmp_path / "b", jobs=1)
    assert not (tmp_path / "b").exists()


KILLED = """
if __name__ == "__main__":
    import sys
    from studies.scenes.sweep.study import sweep
    from sweep_points import held
    sweep(held, {"x": [1.0, 2.0, *range(5, 11)], "y": [3.0, *range(10, 19)]}, sys.argv[1], jobs=2)
"""


def test_a_sweep_killed_several_times_loses_nothing_and_leaves_no_process(tmp_path):
    """Each time it stops after 26 lines more, in the midst of its points, until it is killed."""
    script, path, seen = tmp_path / "killed.py", tmp_path / "a.jsonl", [0]
    script.write_text(KILLED)
    while True:
        count = seen[-1] + 26
        given = {"HELD_BY": str(path), "HELD_FROM": str(count)}
        given["PYTHONPATH"] = PLACES
        child = subprocess.Popen(
            [sys.executable, script, path], start_new_session=True, env=os.environ | given
        )
        while child.poll() is None:
            if path.exists() and path.read_text("utf-8").count("\n") >= count:
                child.send_signal(signal.SIGKILL)
            time.sleep(0.01)
        assert child.wait() in (0, -signal.SIGKILL)
        assert gone(child.pid)
        assert len(path.read_text("utf-8").splitlines()) > seen[-1]
        seen.append(len(path.read_text("utf-8").splitlines()))
        if child.returncode == 0:
            break
    assert len(seen) >= 4  # it was killed at least twice
    record = sweep(
        cheap,
        {"x": [1.0, 2.0, *range(5, 11)], "y": [3.0, *range(10, 19)]},
        path,
        jobs=1,
        identity="sweep_points.held",
    )
    written = [line["at"] for line in map(json.loads, filter(None, lines_of(path)))]
    assert sorted(written) == list(range(80))  # each point once: nothing lost, none twice
    assert record.failed == 1
    for i in range(80):
        if i != 10:
            assert record.results[i]["found"]["sum"] == cheap(record.grid.point(i))["sum"]


def lines_of(path):
    """Whole lines after the first; a line cut by a kill is left out."""
    return [line for line in path.read_text("utf-8").splitlines()[1:] if line.endswith("}")]


def test_a_batch_takes_about_its_time_and_the_last_ones_are_small():
    clock = BatchClock(0, 10**6, 0, lambda progress: None)
    assert clock.size(10**6, 2) == 1  # nothing is known yet
    clock.count(Batch(["{}"], 0, 1e-3))
    assert clock.size(10**6, 2) == int(SECONDS / 1e-3)
    assert clock.size(80, 2) == 10
    assert clock.size(3, 2) == 1
    for _ in range(20):
        clock.count(Batch(["{}"] * 10, 0, 10 * 1.0))
    assert clock.size(10**6, 2) == 1


def test_results_are_flushed_as_they_come(tmp_path):
    store = Store(tmp_path / "a.jsonl", {})
    with store:
        store.add(['{"at": 3, "found": {}}'])
        assert store.results() == {3: {"at": 3, "found": {}}}
