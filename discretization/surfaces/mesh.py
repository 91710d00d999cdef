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
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve, lapack
from scipy.special import i0e, i1e, k0e, k1e

from discretization.surfaces.spectral import band, lobatto, nodes, polynomial, rounded
from energy import terms

Array = NDArray[np.float64]
ELEMENTS = (0.5, 1.0, 1.5)  # l: lengths of the elements beside a line; then a tail
OVERHANG = math.sqrt(2)
_SHARPER = 4.0  # while a step lowers U by less than a quarter of the last: no rounding yet
_ROUNDS = 6  # of a fixed point that gains two digits in each
_WIDER = 1.5  # each element next to the axis than the one before
_INNER = 4.0  # l: free discs of a radius up to that are covered to the axis,
_INSIDE = (0.125, 0.25, 0.625)  # by these parts of it
_GRADING = 0.6  # first element over cos²φ: the surface is singular a little behind a steep line


@dataclass(frozen=True, eq=False)
class FreeSurface:
    """A solved free surface in units of l and γ₁.

    lengths (m,): the elements; u (m·degree+1,): nodal displacements, u[0] at the line;
    energy F; reaction S = dF/du₀; slope u'(0); area ∫u dx with the far field; residual: largest
    imbalance of a free node; slopes: of the far field; radius of the line as in `linear`, and F, S
    and the area then are those per length of the line.
    """

    lengths: tuple[float, ...]
    u: Array
    energy: float
    reaction: float
    slope: float
    area: float
    residual: float
    slopes: str = "small"
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
        return FreeSurface(
            self.lengths, u, energy, reaction, slope, area, residual, self.slopes, radius
        )

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
        if self.slopes == "finite" and math.isinf(self.radius):
            result[far] = _bent(result[far], float(self.u[-1]))
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


def _bent(decayed: Array, u0: float) -> Array:
    """u of a finite-slope far field from u0 < 0.1 on, where e^-x u0 is `decayed`.

    The first integral u²/2 = 1 - cos φ with u' = -tan φ gives, at c = √(1 - u²/4),
    u = e^-x u0 (1 + c)/(1 + c0) e^(2 c0 - 2 c); its right side hardly depends on u.
    """
    u, c0 = decayed, math.sqrt(1 - u0 * u0 / 4)
    for _ in range(_ROUNDS):
        c = np.sqrt(1 - u * u / 4)
        u = decayed * (1 + c) / (1 + c0) * np.exp(2 * (c0 - c))
    return u


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


def graded(u0: float) -> tuple[float, ...]:
    """Elements that halve towards the line down to the scale of its steepness."""
    least = _GRADING * (1 - u0 * u0 / 2) ** 2
    first, *rest = ELEMENTS
    lengths: list[float] = []
    while first > 1.4 * least:
        first /= 2
        lengths.insert(0, first)
    return (first, *lengths, *rest)


@functools.lru_cache(maxsize=256)
def steep(u0: float, degree: int) -> FreeSurface:
    """The finite-slope surface on a mesh of its own; solved from a less steep one if it must."""
    if abs(u0) >= OVERHANG:
        raise ValueError(
            f"displacement = {u0!r} l at a contact line exceeds √2 l: the surface would turn over "
            "(inclination beyond π/2) and is no graph u(x) any more; use a smaller |depth| or w"
        )
    lengths = graded(u0)
    x, steepness = nodes(lengths, degree), 1 - u0 * u0 / 2
    if steepness < 0.3:
        milder = math.copysign(math.sqrt(2 * (1 - 1.6 * steepness)), u0)
        u = steep(milder, degree).displacement(x) * (u0 / milder)
    else:
        u = u0 * linear(degree).displacement(x)
    u[0] = u0
    return relaxed(u, lengths)


def relaxed(u: Array, lengths: tuple[float, ...]) -> FreeSurface:
    """The finite-slope surface with the line at u[0], by Newton's method from u."""
    return _surface(lengths, *_newton(u, lengths))


@dataclass(frozen=True, eq=False)
class _Nodal:
    """Nodal energy at some u, with gradient (n,), Hessian in lower banded form, and ∫u dx."""

    energy: float
    gradient: Array
    hessian: Array
    area: float


def _surface(lengths: tuple[float, ...], u: Array, nodal: _Nodal) -> FreeSurface:
    """With the reaction dF/du₀ as the sum of all nodes' balances, which leaves ∫u dx.

    That of the first node alone is the same to `residual`, but full of rounding.
    """
    degree = (u.size - 1) // len(lengths)
    slope = float(rounded(degree)[2][0] @ u[: degree + 1]) * 2 / lengths[0]
    first = abs(float(nodal.gradient[0]) - nodal.area)
    residual = float(np.abs(nodal.gradient[1:]).max(initial=first))
    return FreeSurface(lengths, u, nodal.energy, nodal.area, slope, nodal.area, residual, "finite")


def _newton(u: Array, lengths: tuple[float, ...]) -> tuple[Array, _Nodal]:
    """Minimise the convex nodal energy with u[0] held: Newton steps, halved while too long.

    Until the decrease of the energy is rounding and no longer falls: a slope is less accurate.
    """
    state, last, decrease = _nodal(u, lengths), math.inf, math.inf
    while decrease > 1e-16 * state.energy or _SHARPER * decrease < last:
        last = decrease
        _, solution, singular = lapack.dpbsv(state.hessian[:, 1:], state.gradient[1:], lower=1)
        if singular and last <= 1e-16 * state.energy:
            break
        if singular:
            raise RuntimeError(f"free surface with u0 = {u[0]!r}: Hessian not positive definite")
        step = np.concatenate([[0.0], -solution])
        decrease = -float(state.gradient @ step)
        factor, trial = 1.0, _nodal(u + step, lengths)
        while (
            decrease > 1e-10 * state.energy
            and trial.energy > state.energy - 1e-3 * factor * decrease
        ):
            factor /= 2
            trial = _nodal(u + factor * step, lengths)
        u, state = u + factor * step, trial
    return u, state


def _nodal(u: Array, lengths: tuple[float, ...]) -> _Nodal:
    degree = (u.size - 1) // len(lengths)
    _, weights, d = rounded(degree)
    index = np.arange(len(lengths))[:, None] * degree + np.arange(degree + 1)
    half = np.array(lengths)[:, None] / 2
    own, weight = u[index], half * weights
    stretch = terms.surface(own @ d.T / half, gamma1=1.0, slopes="finite")
    energy = float(np.sum(weight * (own * own / 2 + stretch.value)))
    area = float(np.sum(weight * own))
    pull = weight * own + (weight * stretch.first / half) @ d
    blocks = d.T @ ((weight * stretch.second / half**2)[:, :, None] * d)
    blocks[:, np.arange(degree + 1), np.arange(degree + 1)] += weight
    gradient, hessian = np.zeros_like(u), band(blocks)
    gradient[:-1] = pull[:, :-1].ravel()
    gradient[degree::degree] += pull[:, -1]
    end, root = float(u[-1]), math.sqrt(max(1 - float(u[-1]) ** 2 / 4, 1e-300))
    energy += end * end / 3 * (1 + root + root * root) / (1 + root)  # 4/3 (1 - root³)
    gradient[-1] += end * root
    hessian[0, -1] += root - end * end / (4 * root)
    return _Nodal(energy, gradient, hessian, area + end * root)
