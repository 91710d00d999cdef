"""Primal-dual active set (Hintermüller, Ito, Kunisch 2003), by hand and on scikit-fem's systems.

Nodes with λ > 0 or u < g are held at g, the others are free with λ = 0; repeat until nothing
changes. From {g > 0} it peels one node per iteration; the contact of a grid half as fine is a start
from which a few suffice.
"""

import importlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import lapack

from studies.benchmarks.rivals.problem import Answer, Array, Grid

COARSEST = 65
Mask = np.ndarray
Solved = Callable[[Mask], tuple[Array, Array]]  # contact -> displacements, forces on the nodes


def nested(grid: Grid) -> Callable[[], Answer]:
    """On one LAPACK tridiagonal solve, `dptsv`."""

    def level(n: int) -> tuple[Array, Solved]:
        own = replace(grid, nodes=n) if n != grid.nodes else grid
        return own.g, lambda held: held_at(own, held)

    return lambda: _refined(grid, level)


def scikit_fem(grid: Grid) -> Callable[[], Answer]:
    """With linear elements of scikit-fem, on its condensed systems."""
    fem: Any = importlib.import_module("skfem")
    forms: Any = importlib.import_module("skfem.models.poisson")
    scene = grid.scene

    def level(n: int) -> tuple[Array, Solved]:
        mesh = fem.MeshLine(np.linspace(-grid.reach, grid.reach, n))
        basis = fem.Basis(mesh, fem.ElementLineP1())
        matrix = scene.gamma1 * forms.laplace.assemble(basis)
        matrix = (matrix + scene.stiffness * forms.mass.assemble(basis)).tolil()
        for end in (0, n - 1):
            matrix[end, end] += scene.gamma1 / scene.elastocapillary_length
        matrix, g = matrix.tocsr(), grid.depth - scene.indenter.height(mesh.p[0])

        def condensed(held: Mask) -> tuple[Array, Array]:
            known = {"x": np.where(held, g, 0.0), "D": np.flatnonzero(held)}
            u = fem.solve(*fem.condense(matrix, np.zeros(n), **known))
            return u, matrix @ u

        return g, condensed

    return lambda: _refined(grid, level)


def _refined(grid: Grid, level: Callable[[int], tuple[Array, Solved]]) -> Answer:
    """From the contact on a grid half as fine, down from the coarsest."""
    sizes = [grid.nodes]
    while sizes[-1] > COARSEST:
        sizes.append((sizes[-1] + 1) // 2)
    held = np.empty(0, bool)
    for n in reversed(sizes):
        g, solve = level(n)
        start = np.repeat(held, 2)[:n] if held.size else g > 0
        u, multipliers, held = solved(g, start, solve)
    return grid.read(u, multipliers)


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


def solved(g: Array, held: Mask, solve: Solved) -> tuple[Array, Array, Mask]:
    """Displacements, multipliers (zero where free) and contact, from a first guess of it."""
    for _ in range(2 * g.size):
        u, force = solve(held)
        multipliers = np.where(held, force, 0.0)
        changed = np.where(held, multipliers > 0, u < g)
        if np.array_equal(changed, held):
            return u, multipliers, held
        held = changed
    raise RuntimeError(f"no active set after {2 * g.size} iterations")
