"""Two Gauss rules at once, by fewer and by more points, on many panels."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PLAIN = 6  # up to so many points: an ungraded panel


@functools.lru_cache(maxsize=16)
def _rule(order: int) -> tuple[Array, Array]:
    """Gauss points and weights on [0, 1]; of many, half for each half, crowded at the ends by t⁴.

    A power law is not smooth where the panels end.
    """
    t, weights = np.polynomial.legendre.leggauss(order)
    t, weights = (t + 1) / 2, weights / 2
    if order <= PLAIN:
        return t, weights
    near, weights = t**4 / 2, 2 * weights * t**3
    return np.concatenate([near, 1 - near]), np.concatenate([weights, weights])


@functools.lru_cache(maxsize=16)
def pair(few: int, many: int) -> tuple[Array, Array]:
    """Both rules at once: all their points (p,), and their weights (2, p)."""
    (at, weights), (more, heavier) = _rule(few), _rule(many)
    both = np.zeros((2, at.size + more.size))
    both[0, : at.size], both[1, at.size :] = weights, heavier
    return np.concatenate([at, more]), both


def points(ends: Array, at: Array, weights: Array) -> tuple[Array, Array]:
    """Points (n, ·) and weights (2, n, ·) of both rules on the panels between ends (n, m + 1)."""
    start, stop = ends[:, :-1, None], ends[:, 1:, None]
    span = stop - start
    x = (start + span * at).reshape(len(ends), (ends.shape[1] - 1) * at.size)
    return x, (span * weights[:, None, None]).reshape(2, *x.shape)
