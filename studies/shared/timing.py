"""Wall times, their spread, and the solve against which they are measured."""

import functools
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lapack


def seconds(work: Callable[[], object]) -> float:
    """Wall time of one call."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def blas_threads() -> str:
    """With what times are taken; `python -m studies` sets one thread."""
    alone = os.environ.get("OPENBLAS_NUM_THREADS") == "1"
    return "one thread" if alone else "as many threads as it takes"


def tridiagonal_seconds(n: int, repeats: int = 7) -> float:
    """Median wall time of one LAPACK dptsv with n unknowns in place, without making its inputs."""
    times = []
    for _ in range(repeats):
        system = np.full(n, 2.1), np.full(n - 1, -1.0), np.ones(n)
        times.append(seconds(lambda a=system: lapack.dptsv(*a, 1, 1, 1)))  # type: ignore[misc]
    return statistics.median(times)


def interpreter_seconds(code: str) -> float:
    """Wall time of a Python that does nothing else, modules compiled as those installed are."""
    command, environment = [sys.executable, "-c", code], _compiled(code)
    given: dict[str, Any] = {"check": True, "env": environment, "cwd": _ROOT}
    return seconds(lambda: subprocess.run(command, **given))


_ROOT = Path(__file__).parents[2]  # from where these packages are found, installed or not
_BYTECODE = functools.cache(tempfile.TemporaryDirectory)  # one, made when it is needed


@functools.cache
def _compiled(code: str) -> dict[str, str]:
    """An environment in which what the code imports is compiled: it has run once."""
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": _BYTECODE().name}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    subprocess.run([sys.executable, "-c", code], check=True, env=environment, cwd=_ROOT)
    return environment


def middle(values: ArrayLike) -> tuple[float, float]:
    """Median, and the interquartile range over it."""
    low, median, high = np.percentile(np.asarray(values, float), [25, 50, 75]).tolist()
    return median, (high - low) / median
