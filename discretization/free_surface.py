"""The free surface outside a contact, on spectral elements anchored at the contact line.

    F(u₀) = min over u, u(0) = u₀, of ∫₀^∞ (k/2 u² + γ₁/2 u'²) dx

in the distance x from the line. Gauss-Lobatto elements cover the first elastocapillary lengths;
beyond them the far field decays and is eliminated exactly: it adds √(kγ₁)/2 u² at its first node,
so the mesh ends where the elements do. The mesh moves with the line: a shifted line meets the same
discrete surface, and no error of the mesh acts on it as a force.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre, legendre
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve

Array = NDArray[np.float64]
DEGREE = 12
ELEMENTS = (0.5, 1.0, 1.5)  # lengths over l


@functools.lru_cache(maxsize=64)
def lobatto(degree: int) -> tuple[Array, Array, Array]:
    """Gauss-Lobatto points on [-1, 1], their weights, and the matrix of derivatives there.

    In the widest floating-point type of the machine: the rounding of these entries would be the
    largest error of a smooth solution.
    """
    p = Legendre.basis(degree)
    slope, curvature = p.deriv(), p.deriv(2)
    inner = np.sort(slope.roots().real).astype(np.longdouble)
    for _ in range(3):
        inner -= slope(inner) / curvature(inner)
    x = np.concatenate([[-1], (inner - inner[::-1]) / 2, [1]])
    values = legendre.legval(x, p.coef)
    weights = 2 / (degree * (degree + 1) * values**2)
    d = values[:, None] / values[None, :] / (x[:, None] - x[None, :] + np.eye(x.size))
    np.fill_diagonal(d, 0)
    np.fill_diagonal(d, -d.sum(axis=1))
    return x, weights, d


@dataclass(frozen=True, eq=False)
class FreeSurface:
    """The response to u₀ = 1 in units of l: positions and displacements of the nodes, stiffness.

    stiffness s: F = s √(kγ₁) u₀²/2; slope: -u'(0) l/u₀; area: ∫u dx/(u₀ l), far field included;
    residual: largest imbalance of a free node.
    """

    x: Array
    u: Array
    stiffness: float
    slope: float
    area: float
    residual: float
    degree: int

    def displacement(self, x: ArrayLike) -> Array:
        """u/u₀ at distances x/l >= 0 from the line: the elements' polynomials, then the decay."""
        x = np.asarray(x, float)
        result = self.u[-1] * np.exp(self.x[-1] - np.maximum(x, self.x[-1]))
        for e in range(len(ELEMENTS)):
            nodes = slice(e * self.degree, (e + 1) * self.degree + 1)
            lo, hi = self.x[nodes][[0, -1]]
            inside = (x >= lo) & (x < hi)
            result[inside] = _interpolated(
                self.degree, 2 * (x[inside] - lo) / (hi - lo) - 1, self.u[nodes]
            )
        return result


def _interpolated(degree: int, at: Array, values: Array) -> Array:
    points, weights, _ = (np.asarray(part, float) for part in lobatto(degree))
    basis = legendre.legvander(points, degree)
    norms = (weights[:, None] * basis**2).sum(axis=0)
    return np.asarray(legendre.legval(at, (basis * weights[:, None]).T @ values / norms))


@functools.lru_cache(maxsize=64)
def free_surface(degree: int = DEGREE) -> FreeSurface:
    """Solve the linear free surface once; every line of every small-slope scene scales it."""
    points, weights, d = lobatto(degree)
    n = degree * len(ELEMENTS) + 1
    hessian, x, mass = (np.zeros(shape, np.longdouble) for shape in ((n, n), n, n))
    for e, length in enumerate(ELEMENTS):
        nodes = slice(e * degree, (e + 1) * degree + 1)
        x[nodes] = sum(ELEMENTS[:e]) + length * (points + 1) / 2
        mass[nodes] += length / 2 * weights
        hessian[nodes, nodes] += 2 / length * (d.T * weights) @ d
    hessian += np.diag(mass)
    hessian[-1, -1] += 1  # the far field
    u = np.zeros(n, np.longdouble)
    u[0] = 1
    factor = cho_factor(hessian[1:, 1:].astype(float))
    for _ in range(4):  # the solve is repeated on its residual until that is rounding
        u[1:] -= cho_solve(factor, (hessian[1:] @ u).astype(float))
    return FreeSurface(
        x=x.astype(float),
        u=u.astype(float),
        stiffness=float(hessian[0] @ u),
        slope=float(-(d[0] @ u[: degree + 1]) * 2 / ELEMENTS[0]),
        area=float(mass @ u + u[-1]),
        residual=float(np.abs(hessian[1:] @ u).max()),
        degree=degree,
    )
