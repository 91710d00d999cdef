"""Primal-dual active set (Hintermüller, Ito, Kunisch 2003) on one LAPACK tridiagonal solve.

Nodes with λ > 0 or u < g are held at g, the others are free with λ = 0; repeat until nothing
changes. From {g > 0} it peels one node per iteration; the contact of a grid half as fine is a start
from which a few suffice.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.linalg import lapack, solveh_banded

from studies.benchmarks.rivals.problem import Answer, Array, Grid

COARSEST = 65
Mask = np.ndarray


def plain(grid: Grid) -> Callable[[], Answer]:
    """From {g > 0}, with `solveh_banded`."""

    def banded(diagonal: Array, off: Array, right: Array) -> Array:
        band = np.zeros((2, diagonal.size))
        band[0], band[1, :-1] = diagonal, off
        return np.asarray(solveh_banded(band, right, lower=True, check_finite=False))

    return lambda: grid.read(*solved(grid, grid.g > 0, banded)[:2])


def nested(grid: Grid) -> Callable[[], Answer]:
    """From the contact on a grid half as fine, down from the coarsest; with `dptsv`."""

    def solve() -> Answer:
        sizes = [grid.nodes]
        while sizes[-1] > COARSEST:
            sizes.append((sizes[-1] + 1) // 2)
        held = np.empty(0, bool)
        for n in reversed(sizes):
            level = replace(grid, nodes=n) if n != grid.nodes else grid
            start = level.g > 0 if not held.size else np.repeat(held, 2)[:n]
            if start.size < n:
                start = np.append(start, np.zeros(n - start.size, bool))
            u, multipliers, held = solved(level, start, positive_definite)
        return grid.read(u, multipliers)

    return solve


def positive_definite(diagonal: Array, off: Array, right: Array) -> Array:
    """The tridiagonal system by LAPACK's dptsv, in place."""
    return np.asarray(lapack.dptsv(diagonal, off, right, 1, 1, 1)[2])


def held_at(
    grid: Grid, held: Mask, solver: Callable[[Array, Array, Array], Array] = positive_definite
) -> Array:
    """u (n,) with u = g on the held nodes, the others free."""
    diagonal, off = grid.bands()
    heights = np.where(held, grid.g, 0.0)
    right = heights.copy()
    right[1:] -= np.where(held[1:], 0.0, off * heights[:-1])
    right[:-1] -= np.where(held[:-1], 0.0, off * heights[1:])
    diagonal[held] = 1
    off[held[1:] | held[:-1]] = 0
    return solver(diagonal, off, right)


def solved(
    grid: Grid, held: Mask, solver: Callable[[Array, Array, Array], Array]
) -> tuple[Array, Array, Mask]:
    """Displacements, multipliers (zero where free) and contact."""
    for _ in range(2 * grid.nodes):
        u = held_at(grid, held, solver)
        multipliers = np.where(held, grid.pushed(u), 0.0)
        changed = np.where(held, multipliers > 0, u < grid.g)
        if np.array_equal(changed, held):
            return u, multipliers, held
        held = changed
    raise RuntimeError(f"no active set after {2 * grid.nodes} iterations")
