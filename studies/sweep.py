"""What comes out of a scene, or any function, over a grid of its parameters?

A scene file in which a list or a range stands for a number (studies/scene_grid.py) is solved at
every point of the grid. Results are appended to SCENE_sweep.jsonl as they come: killed at any
moment, the same command goes on from there and loses at most the points in flight. A point that
fails is recorded with its message and does not stop the rest. At the end: SCENE_sweep.csv, in the
order of the grid, and SCENE_sweep.png. The numbers do not depend on where they were computed.

From Python, over any concurrent.futures executor, with any function of module level:

    from studies.sweep import sweep
    sweep(function, {"w": [1e-4, 2e-4], "h": [1e-5]}, "sweep.jsonl", jobs=2)

    from distributed import Client                     # pip install elastocap[sweep]
    with Client("scheduler:8786").get_executor() as executor:
        sweep(function, axes, "sweep.jsonl", executor=executor, jobs=64)

    from mpi4py.futures import MPIPoolExecutor         # mpiexec -n 65 python -m mpi4py.futures ...
    with MPIPoolExecutor() as executor:
        sweep(function, axes, "sweep.jsonl", executor=executor, jobs=64)

function gets one dict, {key: value}, and returns a dict of numbers and texts. Points are handed
over in batches of about a quarter of a second; the workers import `studies`, so it is installed
where they run. Exit status 1 if a point failed.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from studies import command, sweep_figure
from studies.batches import Clock, Function, Progress, in_batches, processes, tell
from studies.scene_file import built, read
from studies.scene_grid import Axis, SolvedScene, Value, axes, coarser, placed
from studies.sweep_store import Found, Store
from studies.table import versions


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some axes, numbered with the last axis fastest."""

    axes: tuple[Axis, ...]

    def __len__(self) -> int:
        return math.prod(len(axis.values) for axis in self.axes)

    def point(self, number: int) -> dict[str, Value]:
        """The values at a point, by key."""
        at: list[Value] = []
        for axis in reversed(self.axes):
            number, i = divmod(number, len(axis.values))
            at.append(axis.values[i])
        return dict(zip((axis.key for axis in self.axes), reversed(at), strict=True))


@dataclass(frozen=True)
class Record:
    """A finished sweep: its grid, and what was found or the error at each point."""

    grid: Grid
    results: tuple[Found, ...]

    @property
    def failed(self) -> int:
        """How many points failed."""
        return sum("error" in result for result in self.results)

    @property
    def detached(self) -> np.ndarray:
        """Whether the state at each point is detached (n,)."""
        labels = [result.get("found", {}).get("label") for result in self.results]
        return np.array([label == "detached" for label in labels])

    def column(self, name: str) -> np.ndarray:
        """A number at every point (n,); nan where the point failed or has none."""
        values = [result.get("found", {}).get(name) for result in self.results]
        return np.array([math.nan if value is None else value for value in values], float)


def sweep(
    function: Function,
    parameters: Mapping[str, Sequence[Value]],
    path: str | Path,
    *,
    executor: Executor | None = None,
    jobs: int | None = None,
    identity: Any = None,
    retry: bool = False,
    show: Callable[[Progress], object] = lambda progress: None,
) -> Record:
    """function({key: value}) at every point of the grid, kept in the file `path`.

    executor: any concurrent.futures.Executor with `jobs` workers; without one, `jobs` processes of
    this machine (default: one per core; 1: this process). identity: plain data that determine the
    numbers besides the grid (default: the function's name); a file of another sweep is refused.
    retry: try failed points again. show gets the progress about once a second.

    ValueError for an empty axis, jobs < 1 and a file of another sweep.
    """
    grid = Grid(tuple(Axis(key, tuple(values)) for key, values in parameters.items()))
    workers = (os.cpu_count() or 1) if jobs is None else jobs
    if workers < 1:
        raise ValueError(f"jobs = {jobs!r} must be at least 1: give the number of workers")
    for axis in grid.axes:
        if not axis.values:
            raise ValueError(f"{axis.key} = () has no values; give at least one")
    name = f"{function.__module__}.{function.__qualname__}" if identity is None else identity
    store = Store(Path(path), {"function": name, "axes": list(grid.axes), "made_with": versions()})
    known = store.results()
    done = {at for at, line in known.items() if not (retry and "error" in line)}
    failed = sum("error" in known[at] for at in done)
    clock = Clock(len(done), len(grid), failed, show)
    todo = ((at, grid.point(at)) for at in range(len(grid)) if at not in done)
    with store, nullcontext(executor) if executor else processes(workers) as pool:
        for lines in in_batches(function, todo, pool, workers, clock):
            store.add(lines)
    results = store.results()
    return Record(grid, tuple(results[at] for at in range(len(grid))))


def table(record: Record) -> tuple[list[str], list[list[object]]]:
    """Columns and a row for each point in the order of the grid; errors in the last column."""
    columns = list(dict.fromkeys(name for r in record.results for name in r.get("found", {})))
    keys, rows = [axis.key for axis in record.grid.axes], []
    for at, result in enumerate(record.results):
        found = result.get("found", {})
        row = [*record.grid.point(at).values(), *(found.get(name, "") for name in columns)]
        rows.append(["nan" if c is None else c for c in (*row, result.get("error", ""))])
    return [*keys, *columns, "error"], rows


def main(argv: Sequence[str] | None = None) -> int:
    """Sweep a scene file; 1 if a point failed."""
    parser = command.parser("sweep", __doc__, "at most 5 values of each key")
    parser.add_argument("scene", type=Path, help="scene file with a list or range for a number")
    parser.add_argument("--retry", action="store_true", help="try failed points again")
    options, out = command.parse(parser, argv)
    path, content, quick = options.scene, read(options.scene), options.preset == "quick"
    content = coarser(content) if quick else content
    found = axes(path, content)
    if not found:
        raise ValueError(f"{path} has no list or range for a number: use `python -m studies run`")
    grid = Grid(found)
    given = built(path, placed(content, grid.point(0)))  # refuses a wrong file before any work
    if given.programme is not None and "depth" in content:
        raise ValueError(f"{path}: depth stands beside [path] in a sweep: give one of the two")
    function = SolvedScene(path, content)
    print(f"{given.title}: {len(grid)} points, {' × '.join(axis.key for axis in found)}")
    name = f"{path.stem}_sweep" + ("_quick" if quick else "")
    record = sweep(
        function,
        {axis.key: axis.values for axis in found},
        out.folder / f"{name}.jsonl",
        jobs=options.jobs,
        identity=function.identity([axis.key for axis in found]),
        retry=options.retry,
        show=tell,
    )
    notes = [f"title: {given.title}", f"source: {given.source}", sweep_figure.CONVENTIONS]
    written = [out.table(f"{name}.csv", json.dumps(content), *table(record), notes=notes)]
    written += out.figure(name, sweep_figure.plot(record, given.title))
    failed = f"; {record.failed} failed" if record.failed else ""
    print(f"written: {', '.join(map(str, written))}{failed}")
    return 1 if record.failed else 0
