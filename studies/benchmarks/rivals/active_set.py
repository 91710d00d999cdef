"""Primal-dual active set (Hintermüller, Ito, Kunisch 2003), written by hand.

Nodes with λ > 0 or u < g are held at g, the others are free with λ = 0; repeat until nothing
changes. From {g > 0} it peels one node per iteration; the contact of a grid half as fine is a start
from which a few suffice.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import lapack

from studies.benchmarks.rivals.problem import Answer, Array, Grid, Solve

COARSEST = 65
Mask = np.ndarray


def nested(grid: Grid) -> Solve:
    """From the contact on a grid half as fine, down from the coarsest; by LAPACK's `dptsv`."""
    sizes = [grid.nodes]
    while sizes[-1] > COARSEST:
        sizes.append((sizes[-1] + 1) // 2)

    def solve() -> Answer:
        held = np.empty(0, bool)
        for n in reversed(sizes):
            own = replace(grid, nodes=n)
            start = np.repeat(held, 2)[:n] if held.size else own.g > 0
            u, multipliers, held = solved(own, start)
        return grid.read(u, multipliers)

    return solve


def held_at(grid: Grid, held: Mask) -> tuple[Array, Array]:
    """u (n,) with u = g on the held nodes, the others free; and the forces on the nodes."""
    diagonal, off = grid.bands()
    heights = np.where(held, grid.g, 0.0)
    right = heights.copy()
    right[1:] -= np.where(held[1:], 0.0, off * heights[:-1])
    right[:-1] -= np.where(held[:-1], 0.0, off * heights[1:])
    diagonal[held] = 1
    off[held[1:] | held[:-1]] = 0
    u = np.asarray(lapack.dptsv(diagonal, off, right, 1, 1, 1)[2])
    return u, grid.pushed(u)


def solved(grid: Grid, held: Mask) -> tuple[Array, Array, Mask]:
    """Displacements, multipliers (zero where free) and contact, from a first guess of it."""
    for _ in range(2 * grid.nodes):
        u, force = held_at(grid, held)
        multipliers = np.where(held, force, 0.0)
        changed = np.where(held, multipliers > 0, u < grid.g)
        if np.array_equal(changed, held):
            return u, multipliers, held
        held = changed
    raise RuntimeError(f"no active set after {2 * grid.nodes} iterations")
