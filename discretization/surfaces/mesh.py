"""The free surface outside a contact, on spectral elements anchored at the contact line.

    F(u₀) = min over u, u(0) = u₀, of ∫₀^∞ (k/2 u² + γ₁/2 u'²) dx

in the distance x from the line. Here in units of l and γ₁: k = γ₁ = l = 1. Gauss-Lobatto elements
cover the first lengths; beyond them the far field is eliminated exactly: it acts on its first node
with the force u. The mesh moves with the line: a shifted line meets the same discrete surface, and
no error of the mesh acts on it as a force.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import i0e, i1e, k0e, k1e

from discretization.surfaces.spectral import lobatto, nodes, polynomial, rounded

Array = NDArray[np.float64]
ELEMENTS = (0.5, 1.0, 1.5)  # l: lengths of the elements beside a line; then a tail
_WIDER = 1.5  # each element next to the axis than the one before
_INNER = 4.0  # l: free discs of a radius up to that are covered to the axis,
_INSIDE = (0.125, 0.25, 0.625)  # by these parts of it


@dataclass(frozen=True, eq=False)
class FreeSurface:
    """A solved free surface in units of l and γ₁.

    lengths (m,): the elements; u (m·degree+1,): nodal displacements, u[0] at the line;
    energy F; reaction S = dF/du₀; slope u'(0); area ∫u dx with the far field; residual: largest
    imbalance of a free node; radius of the line as in `linear`, and F, S and the area then are
    those per length of the line.
    """

    lengths: tuple[float, ...]
    u: Array
    energy: float
    reaction: float
    slope: float
    area: float
    residual: float
    radius: float = math.inf

    @property
    def degree(self) -> int:
        """Polynomial degree of the elements."""
        return (self.u.size - 1) // len(self.lengths)

    def scaled(self, factor: float) -> FreeSurface:
        """The small-slope surface with its line displaced `factor` times as far."""
        parts = (self.reaction, self.slope, self.area, self.residual)
        reaction, slope, area, residual = (factor * part for part in parts)
        energy = factor**2 * self.energy
        u, radius = factor * self.u, self.radius
        return FreeSurface(self.lengths, u, energy, reaction, slope, area, residual, radius)

    def displacement(self, x: ArrayLike) -> Array:
        """u at distances x >= 0 from the line: the elements' polynomials, then the far field."""
        x, degree = np.asarray(x, float), self.degree
        result, lo = np.empty_like(x), 0.0
        for e, length in enumerate(self.lengths):
            inside = (x >= lo) & (x < lo + length)
            at = 2 * (x[inside] - lo) / length - 1
            result[inside] = polynomial(degree, at, self.u[e * degree : (e + 1) * degree + 1])
            lo += length
        far = x >= lo
        result[far] = self.u[-1] * decayed(self.radius, lo, x[far])
        return result

    def slopes_at(self, x: ArrayLike) -> Array:
        """u' at distances x >= 0 from the line, likewise."""
        x, degree = np.asarray(x, float), self.degree
        result, lo = np.empty_like(x), 0.0
        d = rounded(degree)[2]
        for e, length in enumerate(self.lengths):
            inside = (x >= lo) & (x < lo + length)
            own, at = self.u[e * degree : (e + 1) * degree + 1], 2 * (x[inside] - lo) / length - 1
            result[inside] = polynomial(degree, at, d @ own) * 2 / length
            lo += length
        far = x >= lo
        step = 1e-6 * (1 + x[far])
        result[far] = (self.displacement(x[far] + step) - self.displacement(x[far])) / step
        return result


def elements(radius: float) -> tuple[float, ...]:
    """Lengths of the elements beside a line of this radius, which vary less towards the axis."""
    if radius >= 1 or -radius > _INNER:
        return ELEMENTS
    if radius < 0:
        return tuple(-radius * part for part in _INSIDE)
    count = math.ceil(math.log((radius + sum(ELEMENTS)) / radius, _WIDER))
    return tuple(radius * _WIDER**i * (_WIDER - 1) for i in range(count))


def far_stiffness(radius: float, distance: float) -> float:
    """The far field's exact reaction beyond that distance from a line, per length of the line."""
    if math.isinf(radius):
        return 1.0
    r = abs(radius + distance)
    if radius > 0:
        return (1 + distance / radius) * float(k1e(r) / k0e(r))
    return (1 + distance / radius) * float(i1e(r) / i0e(r)) if -radius > _INNER else 0.0


def decayed(radius: float, start: float, x: Array) -> Array:
    """How much of the displacement at a distance from a line is left at greater ones."""
    if math.isinf(radius):
        return np.exp(start - x)
    bessel = k0e if radius > 0 else i0e
    return np.asarray(bessel(np.abs(radius + x)) / bessel(abs(radius + start)) * np.exp(start - x))


@functools.lru_cache(maxsize=256)
def linear(degree: int, radius: float = math.inf) -> FreeSurface:
    """The small-slope surface with u₀ = 1, solved once; every small-slope line scales it.

    radius: with rotational symmetry that of the line, so that ∫ … (1 + x/radius) dx is minimised at
    distances x from it; negative for a disc of free surface around the axis.
    """
    _, weights, d = lobatto(degree)
    lengths = elements(radius)
    n = degree * len(lengths) + 1
    hessian, mass = np.zeros((n, n), np.longdouble), np.zeros(n, np.longdouble)
    measure = 1 + nodes(lengths, degree) / radius
    for e, length in enumerate(lengths):
        own = slice(e * degree, (e + 1) * degree + 1)
        mass[own] += length / 2 * weights * measure[own]
        hessian[own, own] += 2 / length * (d.T * (weights * measure[own])) @ d
    hessian += np.diag(mass)
    end = far_stiffness(radius, sum(lengths))
    hessian[-1, -1] += end
    u = np.zeros(n, np.longdouble)
    u[0] = 1
    factor = cho_factor(hessian[1:, 1:].astype(float))
    for _ in range(4):  # the solve is repeated on its residual until that is rounding
        u[1:] -= cho_solve(factor, (hessian[1:] @ u).astype(float))
    area = float(mass @ u + end * u[-1])
    straight = math.isinf(radius)  # else the sum of all balances, whose terms are positive
    return FreeSurface(
        lengths=lengths,
        u=u.astype(float),
        energy=float(u @ hessian @ u) / 2 if straight else area / 2,
        reaction=float(hessian[0] @ u) if straight else area,
        slope=float(d[0] @ u[: degree + 1] * 2 / lengths[0]),
        area=area,
        residual=float(np.abs(hessian[1:] @ u).max()),
        radius=radius,
    )
