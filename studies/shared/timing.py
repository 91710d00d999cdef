"""Wall times, their spread, and the solve against which they are measured."""

import os
import statistics
import time
from collections.abc import Callable
from functools import partial

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
    """Median wall time of one LAPACK dptsv in place, without making its inputs.

    The matrix has 2.1 on its diagonal and -1 beside it, which is that of springs and tension, well
    conditioned; the time does not depend on the numbers.

    Parameters
    ----------
    n : int
        Number of unknowns.
    repeats : int
        Odd, so that the median is one of the times; with 7, three of them may be disturbed.

    Returns
    -------
    float
        [s]
    """
    times = []
    for _ in range(repeats):
        diagonal = np.full(n, 2.1)
        off_diagonal = np.full(n - 1, -1.0)
        right_hand_side = np.ones(n)
        solve = partial(lapack.dptsv, diagonal, off_diagonal, right_hand_side, 1, 1, 1)
        times.append(seconds(solve))
    return statistics.median(times)


def middle(values: ArrayLike) -> tuple[float, float]:
    """Median of some values, and their interquartile range over it.

    Parameters
    ----------
    values : array_like

    Returns
    -------
    median, spread : float
    """
    low, median, high = np.percentile(np.asarray(values, float), [25, 50, 75]).tolist()
    return median, (high - low) / median
