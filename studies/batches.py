"""Points computed in batches by a concurrent.futures executor, sized so that no worker idles."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import nullcontext
from itertools import islice
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from studies.sweep_store import failed_line, found_line

Case = TypeVar("Case")
Result = TypeVar("Result")
Point = tuple[int, Mapping[str, Any]]
Function = Callable[[Any], Mapping[str, Any]]
SECONDS = 0.25  # that a batch should take
AHEAD = 2  # batches per worker, one of them waiting


class Batch(NamedTuple):
    """Lines for the file, how many of them are failures, and the seconds they took."""

    lines: list[str]
    failed: int
    seconds: float


class Progress(NamedTuple):
    """Points done of all, failed ones, and seconds to go."""

    done: int
    total: int
    failed: int
    remaining: float

    def __str__(self) -> str:
        failed = f"{self.failed} failed" if self.failed else ""
        left = f"{self.remaining:.0f} s to go" if self.done < self.total else ""
        return ", ".join(filter(None, (f"{self.done} of {self.total} points", failed, left)))


class Clock:
    """Counts points, tells the progress about once a second, and says how long a batch may be."""

    def __init__(
        self, done: int, total: int, failed: int, show: Callable[[Progress], object]
    ) -> None:
        self.done, self.total, self.failed, self.show = done, total, failed, show
        self.begun, self.start = done, time.monotonic()
        self.told = -math.inf
        self.cost = math.nan

    def size(self, waiting: int, workers: int) -> int:
        """Points of the next batch: SECONDS, and less towards the end so that none idles."""
        if math.isnan(self.cost):
            return 1
        share = math.ceil(waiting / (2 * AHEAD * workers))
        return min(share, max(1, int(SECONDS / max(self.cost, 1e-9))))

    def count(self, batch: Batch) -> None:
        """What a batch says of the cost of a point, smoothed, and of the progress."""
        cost = batch.seconds / len(batch.lines)
        self.cost = cost if math.isnan(self.cost) else (self.cost + cost) / 2
        self.failed += batch.failed
        self.tick(len(batch.lines))

    def tick(self, points: int = 1) -> None:
        """So many points more are done."""
        self.done += points
        now = time.monotonic()
        if now - self.told >= 1 or self.done == self.total:
            per_point = (now - self.start) / (self.done - self.begun)
            remaining = per_point * (self.total - self.done)
            self.show(Progress(self.done, self.total, self.failed, remaining))
            self.told = now


def processes(jobs: int) -> Any:
    """Processes of this machine that end with it; for one job None, which is this process.

    A process with a single thread can be forked, which takes no time; another starts them afresh.
    """
    if jobs == 1:
        return nullcontext()
    tasks = Path("/proc/self/task")
    alone = tasks.is_dir() and len(list(tasks.iterdir())) == 1
    context: Any = get_context("fork" if alone else "spawn")
    return ProcessPoolExecutor(jobs, context, initializer=end_with, initargs=(os.getpid(),))


def tell(progress: Progress) -> None:
    """The progress on the screen, beside what is kept of it: on stderr, one line on a terminal."""
    alone = sys.stderr.isatty()
    end = "\r" if alone and progress.done < progress.total else "\n"
    print(f"{progress!s:{50 if alone else 0}s}", end=end, file=sys.stderr, flush=True)


def each(
    function: Callable[[Case], Result],
    cases: Sequence[Case],
    jobs: int,
    show: Callable[[Progress], object] = tell,
) -> Iterator[Result]:
    """function(case) of every case, in their order, from `jobs` processes (1: this one).

    The function is of module level, or a functools.partial of one.
    """
    clock = Clock(0, len(cases), 0, show)
    with processes(min(jobs, max(1, len(cases)))) as pool:
        for result in map(function, cases) if pool is None else pool.map(function, cases):
            clock.tick()
            yield result


def end_with(parent: int) -> None:
    """A worker whose parent was killed would wait for work for ever: it looks every second."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def solve(function: Function, points: Sequence[Point]) -> Batch:
    """The lines of a batch; a failure becomes a line as well."""
    start, lines, failed = time.perf_counter(), [], 0
    for at, point in points:
        try:
            lines.append(found_line(at, function(point)))
        except Exception as error:
            lines.append(failed_line(at, error))
            failed += 1
    return Batch(lines, failed, time.perf_counter() - start)


def in_batches(
    function: Function, todo: Iterator[Point], pool: Executor | None, workers: int, clock: Clock
) -> Iterator[list[str]]:
    """Lines of the points as they come, AHEAD batches per worker under way; no pool: done here."""
    waiting = clock.total - clock.done
    most = AHEAD * workers if pool else 1
    pending: set[Future[Batch]] = set()
    while waiting or pending:
        while waiting and len(pending) < most:
            points = list(islice(todo, clock.size(waiting, workers)))
            waiting -= len(points)
            pending.add(submitted(pool, function, points))
        finished, pending = wait(pending, return_when=FIRST_COMPLETED)
        for future in finished:
            batch = future.result()
            yield batch.lines
            clock.count(batch)


def submitted(pool: Executor | None, function: Function, points: list[Point]) -> Future[Batch]:
    """A batch under way in the pool, or done here."""
    if pool is not None:
        return pool.submit(solve, function, points)
    future: Future[Batch] = Future()
    future.set_result(solve(function, points))
    return future
