"""The free surface outside a contact, on spectral elements anchored at the contact line.

    F(u₀) = min over u, u(0) = u₀, of ∫₀^∞ (k/2 u² + γ₁ ψ(u')) dx,
    ψ = u'²/2 (small slopes) or √(1+u'²) - 1 (finite slopes)

in the distance x from the line. Here in units of l and γ₁: k = γ₁ = l = 1. Gauss-Lobatto elements
cover the first lengths; beyond them the far field is eliminated exactly through its first integral
u²/2 = 1 - cos φ: it acts on its first node with the force sin φ = u √(1 - u²/4) (small slopes: u).
The mesh moves with the line: a shifted line meets the same discrete surface, and no error of the
mesh acts on it as a force. A surface that would turn over (|u₀| >= √2) has no solution.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre, legendre
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve, lapack

from energy import terms

Array = NDArray[np.float64]
DEGREE = {"small": 12, "finite": 16}
ELEMENTS = (0.5, 1.0, 1.5)
OVERHANG = math.sqrt(2)
_GRADING = 0.6  # first element over cos²φ: the surface is singular a little behind a steep line


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


@functools.lru_cache(maxsize=64)
def _rounded(degree: int) -> tuple[Array, Array]:
    _, weights, d = lobatto(degree)
    return weights.astype(float), d.astype(float)


@dataclass(frozen=True, eq=False)
class FreeSurface:
    """A solved free surface in units of l and γ₁.

    lengths (m,): the elements; u (m·degree+1,): nodal displacements, u[0] at the line;
    energy F; reaction dF/du₀; slope u'(0); area ∫u dx with the far field; residual: largest
    imbalance of a free node.
    """

    lengths: tuple[float, ...]
    u: Array
    energy: float
    reaction: float
    slope: float
    area: float
    residual: float
    slopes: str

    def scaled(self, factor: float) -> FreeSurface:
        """The small-slope surface with its line displaced `factor` times as far."""
        parts = (self.reaction, self.slope, self.area, self.residual)
        reaction, slope, area, residual = (factor * part for part in parts)
        energy = factor**2 * self.energy
        u = factor * self.u
        return FreeSurface(self.lengths, u, energy, reaction, slope, area, residual, self.slopes)

    def displacement(self, x: ArrayLike) -> Array:
        """u at distances x >= 0 from the line: the elements' polynomials, then the linear decay.

        (Of a finite-slope far field the decay is the first term; what is left out is of the third
        order in u, which is below 0.07 there.)
        """
        x, degree = np.asarray(x, float), DEGREE[self.slopes]
        result, lo = np.empty_like(x), 0.0
        for e, length in enumerate(self.lengths):
            inside = (x >= lo) & (x < lo + length)
            at = 2 * (x[inside] - lo) / length - 1
            result[inside] = _polynomial(degree, at, self.u[e * degree : (e + 1) * degree + 1])
            lo += length
        result[x >= lo] = self.u[-1] * np.exp(lo - x[x >= lo])
        return result


def _polynomial(degree: int, at: Array, values: Array) -> Array:
    """The polynomial with these values at the Gauss-Lobatto points, at other points."""
    points, weights, _ = (np.asarray(part, float) for part in lobatto(degree))
    basis = legendre.legvander(points, degree)
    norms = (weights[:, None] * basis**2).sum(axis=0)
    return np.asarray(legendre.legval(at, (basis * weights[:, None]).T @ values / norms))


def free_surface(u0: float, slopes: str = "small") -> FreeSurface:
    """The surface whose line is displaced by u0. ValueError if it would turn over."""
    if slopes == "small":
        return _unit().scaled(u0)
    return _steep(u0)


@functools.lru_cache(maxsize=1)
def _unit() -> FreeSurface:
    """The linear surface with u₀ = 1, solved once; every small-slope line scales it."""
    degree = DEGREE["small"]
    _, weights, d = lobatto(degree)
    n = degree * len(ELEMENTS) + 1
    hessian, mass = np.zeros((n, n), np.longdouble), np.zeros(n, np.longdouble)
    for e, length in enumerate(ELEMENTS):
        nodes = slice(e * degree, (e + 1) * degree + 1)
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
        lengths=ELEMENTS,
        u=u.astype(float),
        energy=float(u @ hessian @ u) / 2,
        reaction=float(hessian[0] @ u),
        slope=float(d[0] @ u[: degree + 1] * 2 / ELEMENTS[0]),
        area=float(mass @ u + u[-1]),
        residual=float(np.abs(hessian[1:] @ u).max()),
        slopes="small",
    )


def _graded(u0: float) -> tuple[float, ...]:
    """Elements that halve towards the line down to the scale of its steepness."""
    least = _GRADING * (1 - u0 * u0 / 2) ** 2
    first, *rest = ELEMENTS
    lengths: list[float] = []
    while first > 1.4 * least:
        first /= 2
        lengths.insert(0, first)
    return (first, *lengths, *rest)


@functools.lru_cache(maxsize=256)
def _steep(u0: float) -> FreeSurface:
    """Newton's method on the convex nodal energy of the true surface length."""
    if abs(u0) >= OVERHANG:
        raise ValueError(
            f"displacement {u0!r} l at the contact line exceeds √2 l: the surface would turn over "
            "(inclination beyond π/2) and is no graph u(x) any more; use a smaller |depth| or w"
        )
    lengths = _graded(u0)
    nodes = np.concatenate([[0.0], np.cumsum(lengths)])
    points = (lobatto(DEGREE["finite"])[0].astype(float) + 1) / 2
    x = np.concatenate([[0.0], (nodes[:-1, None] + np.outer(lengths, points[1:])).ravel()])
    steepness = 1 - u0 * u0 / 2
    if steepness < 0.3:  # start from a less steep surface, half as far from turning over
        milder = math.copysign(math.sqrt(2 * (1 - 1.6 * steepness)), u0)
        u = _steep(milder).displacement(x) * (u0 / milder)
    else:
        u = u0 * _unit().displacement(x)
    u[0] = u0
    u, (energy, gradient, _, area) = _newton(u, lengths)
    degree = DEGREE["finite"]
    slope = float(lobatto(degree)[2][0].astype(float) @ u[: degree + 1]) * 2 / lengths[0]
    residual = float(np.abs(gradient[1:]).max())
    return FreeSurface(lengths, u, energy, float(gradient[0]), slope, area, residual, "finite")


def _newton(
    u: Array, lengths: tuple[float, ...]
) -> tuple[Array, tuple[float, Array, Array, float]]:
    """Minimise the convex nodal energy with u[0] held: Newton steps, halved while too long."""
    state, decrease = _nodal(u, lengths), math.inf
    while decrease > 1e-16 * state[0]:  # the step it is computed for leaves its square
        _, solution, singular = lapack.dposv(state[2][1:, 1:], state[1][1:])
        if singular:
            raise RuntimeError(f"free surface with u0 = {u[0]!r}: Hessian not positive definite")
        step = np.concatenate([[0.0], -solution])
        decrease = -float(state[1] @ step)
        factor, trial = 1.0, _nodal(u + step, lengths)
        while decrease > 1e-10 * state[0] and trial[0] > state[0] - 1e-3 * factor * decrease:
            factor /= 2
            trial = _nodal(u + factor * step, lengths)
        u, state = u + factor * step, trial
    return u, state


def _nodal(u: Array, lengths: tuple[float, ...]) -> tuple[float, Array, Array, float]:
    """Nodal energy, gradient, Hessian and ∫u dx of a finite-slope surface."""
    degree = DEGREE["finite"]
    weights, d = _rounded(degree)
    index = np.arange(len(lengths))[:, None] * degree + np.arange(degree + 1)
    half = np.array(lengths)[:, None] / 2
    own, weight = u[index], half * weights
    stretch = terms.surface(own @ d.T / half, gamma1=1.0, slopes="finite")
    energy = float(np.sum(weight * (own * own / 2 + stretch.value)))
    area = float(np.sum(weight * own))
    pull = weight * own + (weight * stretch.first / half) @ d
    blocks = d.T @ ((weight * stretch.second / half**2)[:, :, None] * d)
    gradient, hessian = np.zeros_like(u), np.zeros((u.size, u.size))
    for e, block in enumerate(blocks):
        nodes = slice(e * degree, (e + 1) * degree + 1)
        gradient[nodes] += pull[e]
        hessian[nodes, nodes] += block
        hessian.flat[nodes.start * (u.size + 1) : nodes.stop * (u.size + 1) : u.size + 1] += weight[
            e
        ]
    end, root = float(u[-1]), math.sqrt(max(1 - float(u[-1]) ** 2 / 4, 1e-300))
    energy += end * end / 3 * (1 + root + root * root) / (1 + root)  # 4/3 (1 - root³)
    gradient[-1] += end * root
    hessian[-1, -1] += root - end * end / (4 * root)
    return energy, gradient, hessian, area + end * root
