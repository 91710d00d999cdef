"""Finite-element packages on the w = 0 problem."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from studies.benchmarks.rivals.problem import Answer, Array, Grid, package


def scikit_fem(grid: Grid) -> Callable[[], Answer]:
    """scikit-fem, linear elements, nested primal-dual active set on its condensed systems."""
    fem = package("skfem")
    forms = package("skfem.models.poisson")
    scene = grid.scene

    def level(n: int) -> tuple[Any, Array]:
        mesh = fem.MeshLine(np.linspace(-grid.reach, grid.reach, n))
        basis = fem.Basis(mesh, fem.ElementLineP1())
        matrix = scene.gamma1 * forms.laplace.assemble(basis)
        matrix = (matrix + scene.stiffness * forms.mass.assemble(basis)).tolil()
        for end in (0, n - 1):
            matrix[end, end] += scene.gamma1 / scene.elastocapillary_length
        return matrix.tocsr(), grid.depth - scene.indenter.height(mesh.p[0])

    def solve() -> Answer:
        sizes = [grid.nodes]
        while sizes[-1] > 65:
            sizes.append((sizes[-1] + 1) // 2)
        held = np.empty(0, bool)
        for n in reversed(sizes):
            matrix, g = level(n)
            held = g > 0 if not held.size else np.resize(np.repeat(held, 2), n)
            for _ in range(2 * n):
                where = np.flatnonzero(held)
                u = fem.solve(*fem.condense(matrix, np.zeros(n), x=np.where(held, g, 0.0), D=where))
                push = matrix @ u
                changed = np.where(held, push > 0, u < g)
                if np.array_equal(changed, held):
                    break
                held = changed
        return grid.read(u, np.where(held, push, 0.0))

    return solve
