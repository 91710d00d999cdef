"""Wall times, their spread, and the solve against which they are measured."""

import os
import statistics
import time
from collections.abc import Callable

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


def middle(values: ArrayLike) -> tuple[float, float]:
    """Median, and the interquartile range over it."""
    low, median, high = np.percentile(np.asarray(values, float), [25, 50, 75]).tolist()
    return median, (high - low) / median
