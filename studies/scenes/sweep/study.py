"""What comes out of a scene, or any function, over a grid of its parameters?

A scene file in which a list or a range stands for a number (studies/scenes/grid.py) is solved at
every point of the grid. Results are appended to SCENE_sweep.jsonl as they come: killed at any
moment, the same command goes on from there and loses at most the points in flight. A point that
fails is recorded with its message and does not stop the rest. At the end: SCENE_sweep.csv, in the
order of the grid, and SCENE_sweep.png. The numbers do not depend on where they were computed, but
for rounding: states of one contact are found in batches, whose products add in another order.

From Python, over any concurrent.futures executor, with any function of module level:

    from studies.scenes.sweep.study import sweep
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

# Conventions:
# - `command.parser` has the options of all studies; `command.parse` gives them and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - A `Table` is the names of its columns, and its rows.
# - A `Grid` has all combinations of its axes; `built` makes a scene file of tables, `placed` those
#   of a point.
# - A `Store` appends results to a file, and a `Record` has all of them.
# - `in_batches` hands points to an executor; `BatchClock` says how many at a time.
# - An `Axis` is a key with its values; `axes` are those of a file, and `coarser` thins them.
# - A `SolvedScene` is the file as a function of a point: what its state or path has, by name.

import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from studies.scenes.file import built, read
from studies.scenes.grid import Axis, Grid, SolvedScene, Value, axes, coarser, placed
from studies.scenes.sweep import figure as sweep_figure
from studies.scenes.sweep.batches import BatchClock, Function, in_batches
from studies.scenes.sweep.store import Record, Store
from studies.shared import command
from studies.shared.batches import Progress, processes, tell
from studies.shared.table import Table, versions

GOLDEN = 0.6180339887498949  # multiples of the golden ratio modulo 1 fill (0, 1) evenly


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
    """The values of a function at every point of a grid, kept in a file.

    Parameters
    ----------
    function : callable
        Of module level; gets one dict {key: value} and returns a dict of numbers and texts.
    parameters : mapping
        The values of each key.
    path : str or Path
        The file.
    executor : concurrent.futures.Executor, optional
        With `jobs` workers; None: `jobs` processes of this machine.
    jobs : int, optional
        None: one for each core; 1: this process.
    identity : optional
        Plain data that determine the numbers besides the grid; None: the function's name. A file
        of another sweep is refused.
    retry : bool
        Whether failed points are tried again.
    show : callable
        Is called with the `Progress`, about once a second.

    Returns
    -------
    Record

    Raises
    ------
    ValueError
        For an empty axis, jobs < 1, a file of another sweep and one that another sweep is writing.
    KeyboardInterrupt
        On Ctrl-C, saying how many points are kept.
    """
    grid = Grid(tuple(Axis(key, tuple(values)) for key, values in parameters.items()))
    workers = (os.cpu_count() or 1) if jobs is None else jobs
    if workers < 1:
        raise ValueError(f"jobs = {jobs!r} must be at least 1: give the number of workers")
    name = f"{function.__module__}.{function.__qualname__}" if identity is None else identity
    store = Store(Path(path), {"function": name, "axes": list(grid.axes), "made_with": versions()})
    try:
        with store, nullcontext(executor) if executor else processes(workers) as pool:
            known = store.results()
            done = {at for at, line in known.items() if not (retry and "error" in line)}
            failed = sum("error" in known[at] for at in done)
            clock = BatchClock(len(done), len(grid), failed, show)
            todo = ((at, grid.point(at)) for at in scattered(len(grid)) if at not in done)
            for lines in in_batches(function, todo, pool, workers, clock):
                store.add(lines)
    except KeyboardInterrupt:
        kept = f"{len(store.results())} of {len(grid)} points are kept in {path}"
        raise KeyboardInterrupt(f"{kept}; the same command goes on from there") from None
    results = store.results()
    return Record(grid, tuple(results[at] for at in range(len(grid))))


def scattered(count: int) -> list[int]:
    """The numbers 0 to count - 1, any of which are like all: what they cost tells what is to go."""
    return sorted(range(count), key=lambda at: at * GOLDEN % 1)


def table(record: Record) -> Table:
    """Columns and a row for each point in the order of the grid; errors in the last column."""
    columns = _names(record)
    keys = [axis.key for axis in record.grid.axes]
    rows = []
    for at, result in enumerate(record.results):
        found = result.get("found", {})
        values = [found.get(name, "") for name in columns]
        row = [*record.grid.point(at).values(), *values, result.get("error", "")]
        rows.append(["nan" if cell is None else cell for cell in row])
    return [*keys, *columns, "error"], rows


def _names(record: Record) -> list[str]:
    """The names of what was found at any point, in the order in which they came."""
    names: dict[str, None] = {}
    for result in record.results:
        names.update(dict.fromkeys(result.get("found", {})))
    return list(names)


def ranges(record: Record) -> str:
    """The least and the largest of each number found, and where on the grid."""
    lines = []
    for name in _names(record):
        known: dict[int, float] = {}
        for at, result in enumerate(record.results):
            value = result.get("found", {}).get(name)
            if isinstance(value, int | float) and not math.isnan(value):
                known[at] = value
        if not known or name.startswith("error_"):
            continue
        least = min(known, key=known.__getitem__)
        most = max(known, key=known.__getitem__)
        ends = [f"{known[at]:.6g} at {_place(record, at)}" for at in (least, most)]
        lines.append(f"{name:14s} from {' to '.join(ends)}")
    return "\n".join(lines)


def _place(record: Record, at: int) -> str:
    """The values of the axes at a point, in words."""
    return ", ".join(f"{key} = {value}" for key, value in record.grid.point(at).items())


def main(argv: Sequence[str] | None = None) -> int:
    """Sweep a scene file; 1 if a point failed."""
    parser = command.parser("sweep", __doc__, "at most 5 values of each key")
    parser.add_argument("scene", type=Path, help="scene file with a list or range for a number")
    parser.add_argument("--retry", action="store_true", help="try failed points again")
    options, out = command.parse(parser, argv)
    path = options.scene
    content = read(options.scene)
    quick = options.preset == "quick"
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
    per_length = given.scene.per_length
    notes = [
        f"title: {given.title}",
        f"source: {given.source}",
        sweep_figure.conventions(per_length),
    ]
    written = [out.table(f"{name}.csv", json.dumps(content), *table(record), notes=notes)]
    written += out.figure(name, sweep_figure.plot(record, given.title, per_length))
    print(ranges(record))
    print(f"written: {', '.join(map(str, written))}")
    if record.failed:
        print(f"FAILED: {record.failed} of {len(grid)} points; the table has their messages")
    return 1 if record.failed else 0
