"""Points of a sweep in batches for any executor, sized so that no worker idles.

Conventions:

- A `Clock` counts done points and tells the progress; `tick(n)` counts n more.
- `found_line` and `failed_line` are the lines of the file for a point.
"""

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from itertools import islice
from typing import Any, NamedTuple

from studies.scenes.sweep.store import failed_line, found_line
from studies.shared.batches import Clock

Point = tuple[int, Mapping[str, Any]]
Function = Callable[[Any], Mapping[str, Any]]
SECONDS = 0.25  # that a batch should take
AHEAD = 2  # batches per worker, one of them waiting


class Batch(NamedTuple):
    """Points that one process has done.

    Attributes
    ----------
    lines : list of str
        For the file.
    failed : int
        How many of them are failures.
    seconds : float
        What they took.
    """

    lines: list[str]
    failed: int
    seconds: float


class BatchClock(Clock):
    """Counts points, and says from what they cost how many of them make a batch."""

    cost = math.nan  # seconds per point, smoothed

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


def solve(function: Function, points: Sequence[Point]) -> Batch:
    """The lines of a batch; a failure becomes a line as well.

    A function may find several points together, by a method `many` that gives a result for each
    point, or None where the point is to be found by itself.
    """
    start = time.perf_counter()
    lines = []
    failed = 0
    together = getattr(function, "many", None)
    known = together([point for _, point in points]) if together else [None] * len(points)
    for (at, point), found in zip(points, known, strict=True):
        try:
            lines.append(found_line(at, function(point) if found is None else found))
        except Exception as error:
            lines.append(failed_line(at, error))
            failed += 1
    return Batch(lines, failed, time.perf_counter() - start)


def in_batches(
    function: Function,
    todo: Iterator[Point],
    pool: Executor | None,
    workers: int,
    clock: BatchClock,
) -> Iterator[list[str]]:
    """Lines of the points as they come, AHEAD batches per worker under way.

    Parameters
    ----------
    function : callable
        Of a point.
    todo : iterator of Point
    pool : Executor or None
        None: done here.
    workers : int
    clock : BatchClock

    Yields
    ------
    list of str
        Lines of a batch.
    """
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
    """A batch under way in the pool, or done here.

    Parameters
    ----------
    pool : Executor or None
        None: done here.
    function : callable
    points : list of Point

    Returns
    -------
    Future of a Batch
    """
    if pool is not None:
        return pool.submit(solve, function, points)
    future: Future[Batch] = Future()
    future.set_result(solve(function, points))
    return future
