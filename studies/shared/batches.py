"""Cases computed in several processes, and the progress of long work shown on the screen.

Work that is done in other processes is a function of module level, which they can import, and its
cases are what can be pickled. Processes are forked while this one has a single thread, else they
start afresh and import what they need.
"""

import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

Show = Callable[[str], object]  # called with each line of text
Case = TypeVar("Case")
Result = TypeVar("Result")
PAUSE = 1.0  # s between two lines of progress
# The time to go is told from this share of the work on, ...
_KNOWN_FROM = 0.05
# ... and measured from this one on: before, processes start and modules are imported.
_MEASURED_FROM = 0.025
_THREAD_ENDS = 0.1  # s that a thread which has just ended may take to go
_LOOK_AGAIN = 0.005  # s until it is looked for once more, a twentieth of that
_WATCH = 1.0  # s between two looks at whether the parent lives: a worker outlives it by no more
_WIDTH = 50  # characters of a line of progress, to cover the longer one before


class Progress(NamedTuple):
    """How far long work has come.

    Attributes
    ----------
    done, total, failed : int
        Points.
    remaining : float
        Seconds to go; NaN while that is not known.
    """

    done: int
    total: int
    failed: int
    remaining: float

    def __str__(self) -> str:
        """Such as 3 of 10 points, 1 failed, 20 s to go."""
        said = [f"{self.done} of {self.total} points"]
        if self.failed:
            said.append(f"{self.failed} failed")
        if self.done < self.total and not math.isnan(self.remaining):
            said.append(f"{self.remaining:.0f} s to go")
        return ", ".join(said)


class Clock:
    """Counts points and tells the progress about once a second.

    The time to go is known after a twentieth of the work, from what was done in its second half: in
    the first, processes start and modules are imported.

    Parameters
    ----------
    done, total, failed : int
        Points at the beginning.
    show : callable
        Is called with a `Progress`.

    Attributes
    ----------
    begun : int
        Points that were done at the beginning, by an earlier run.
    told : float
        When the progress was last shown, on the clock of time.monotonic [s].
    since : tuple of int and float, or None
        How many points were done, and when, as the rate began to be measured.
    """

    def __init__(
        self, done: int, total: int, failed: int, show: Callable[[Progress], object]
    ) -> None:
        """Nothing is shown before the first tick."""
        self.done = done
        self.total = total
        self.failed = failed
        self.show = show
        self.begun = done
        self.told = -math.inf
        self.since: tuple[int, float] | None = None

    def tick(self, points: int = 1) -> None:
        """So many points more are done."""
        self.done += points
        now = time.monotonic()
        part = (self.done - self.begun) / (self.total - self.begun)
        if self.since is None or part <= _MEASURED_FROM:
            self.since = (self.done, now)
        if now - self.told < PAUSE and self.done < self.total:
            return
        done, start = self.since
        remaining = math.nan
        if part >= _KNOWN_FROM and self.done > done:
            seconds_a_point = (now - start) / (self.done - done)
            remaining = seconds_a_point * (self.total - self.done)
        self.show(Progress(self.done, self.total, self.failed, remaining))
        self.told = now


@contextmanager
def processes(jobs: int) -> Iterator[ProcessPoolExecutor | None]:
    """Processes of this machine that end with this one.

    A process with a single thread can be forked, which takes no time; another starts them afresh.
    On Ctrl-C they are ended in the midst of their work.

    Parameters
    ----------
    jobs : int

    Yields
    ------
    ProcessPoolExecutor or None
        None for one job, which is this process.
    """
    if jobs == 1:
        yield None
        return
    context: Any = get_context("fork" if alone() else "spawn")
    others = set(active_children())
    pool = ProcessPoolExecutor(jobs, context, initializer=end_with, initargs=(os.getpid(),))
    try:
        yield pool
    except KeyboardInterrupt:
        for worker in set(active_children()) - others:
            worker.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def in_own_process(function: Callable[[Case], Result], case: Case) -> Result:
    """The value of a function in a process of its own: nothing it opens stays open in this one.

    Parameters
    ----------
    function : callable
        Of module level.
    case : object
        Its argument.

    Returns
    -------
    object
    """
    context: Any = get_context("fork" if alone() else "spawn")
    with ProcessPoolExecutor(1, context) as pool:
        return pool.submit(function, case).result()


def alone() -> bool:
    """Whether this process has a single thread; one that has just ended may take a moment to go."""
    tasks = Path("/proc/self/task")
    until = time.monotonic() + _THREAD_ENDS
    while tasks.is_dir():
        if len(list(tasks.iterdir())) == 1:
            return True
        if time.monotonic() > until:
            return False
        time.sleep(_LOOK_AGAIN)
    return False


def silent(line: object) -> None:
    """Drop a line: the `Show` of who wants none."""


def tell(progress: Progress) -> None:
    """The progress on the screen, beside what is kept of it: on stderr, one line on a terminal."""
    on_terminal = sys.stderr.isatty()
    again = on_terminal and progress.done < progress.total
    width = _WIDTH if on_terminal else 0
    end = "\r" if again else "\n"
    print(f"{progress!s:{width}s}", end=end, file=sys.stderr, flush=True)


def each(
    function: Callable[[Case], Result],
    cases: Sequence[Case],
    jobs: int,
    show: Callable[[Progress], object] = tell,
    say: Callable[[Result], object] = lambda result: None,
    together: int = 1,
) -> Iterator[Result]:
    """The values of a function for many cases, in their order, from several processes.

    Parameters
    ----------
    function : callable
        Of module level, or a functools.partial of such a function.
    cases : sequence
        Its arguments.
    jobs : int
        Number of processes; 1: this one.
    show : callable, optional
        Is called with the `Progress`, about once a second.
    say : callable, optional
        Is called with each result.
    together : int
        How many neighbours one process takes at once, as they share what it keeps.

    Yields
    ------
    object
    """
    clock = Clock(0, len(cases), 0, show)
    with processes(min(jobs, max(1, len(cases)))) as pool:
        found = pool.map(function, cases, chunksize=together) if pool else map(function, cases)
        for result in found:
            clock.tick()
            say(result)
            yield result


def end_with(parent: int) -> None:
    """A worker whose parent was killed would wait for work for ever: it looks every second.

    Ctrl-C, which reaches all processes of a terminal, is the parent's to answer.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        """End this process once it has another parent."""
        while os.getppid() == parent:
            time.sleep(_WATCH)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
