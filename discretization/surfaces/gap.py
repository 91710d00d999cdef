"""The free surface between two contacts, on spectral elements anchored at both lines.

    F(u_a, u_b; L) = min over u, u(0) = u_a, u(L) = u_b, of ∫₀^L (k/2 u² + γ₁/2 u'²) dx

Small slopes, in units of l and γ₁: k = γ₁ = l = 1. In the halves s = (u_a + u_b)/2 and
t = (u_a - u_b)/2 it falls into two problems on half the gap, both with u = 1 at the line,

    F = s² B + t² A,    reactions S_a = s B + t A,  S_b = s B - t A,

B with a free end in the middle (even), A with u = 0 there (odd). The half is covered by equal
elements of a length of at most 1/2. One element is condensed to its ends once and for all lengths:
with the modes of its inner nodes, K φ = λ M φ, of length 2η its even and odd energies are

    σ = η - η³/2 Σ c²/(λ+η²),    σ + 2τ = 1/η + η/3 - η³/2 Σ b²/(λ+η²),

c and b the modes' shares of 1 and x; two equal parts in a row are one of twice the length, which
adds positive numbers only (`Piece.doubled`). Lines more than 40 l apart do not feel each other.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.mesh import linear
from discretization.surfaces.spectral import lobatto, polynomials, rounded

Array = NDArray[np.float64]
_LONGEST = 0.5  # l: of an element, which rounding then resolves
_STEP = 1e-30  # of the length, along the imaginary axis
FAR = 20.0  # half a gap whose lines are independent: exp(-2 FAR) is below rounding


class Modes(NamedTuple):
    """Modes of the inner nodes of an element [-1, 1]: λ and c² if even, λ and b² if odd."""

    even: tuple[Array, Array]
    odd: tuple[Array, Array]


@functools.lru_cache(maxsize=16)
def modes(degree: int) -> Modes:
    """Solved once for each degree."""
    points, weights, d = (np.asarray(part, float) for part in lobatto(degree))
    root = np.sqrt(weights[1:-1])
    stiffness = ((d.T * weights) @ d)[1:-1, 1:-1]
    values, vectors = np.linalg.eigh(stiffness / np.outer(root, root))
    c, b = (root * points[1:-1] ** power @ vectors for power in (0, 1))
    even = np.abs(c) > np.abs(b)
    return Modes((values[even], c[even] ** 2), (values[~even], b[~even] ** 2))


class Piece(NamedTuple):
    """A part of a surface condensed to its two ends, each with the stiffness σ, tied by τ.

    Numbers or arrays.
    """

    ground: Any
    tie: Any

    @property
    def doubled(self) -> Piece:
        """Two such parts in a row: σ + τσ/(σ+τ) and τ²/(2(σ+τ)), sums of positive numbers."""
        share = self.tie / (self.ground + self.tie)
        return Piece(self.ground + share * self.ground, share * self.tie / 2)


def element(degree: int, eta: Any) -> Piece:
    """One element of length 2η (a number or an array)."""
    square = eta * eta
    even, odd = (_share(value, part, square) for value, part in modes(degree))
    ground, both = eta * (1 - even / 2), 1 / eta + eta * (1 / 3 - odd / 2)
    return Piece(ground, (both - ground) / 2)


def _share(values: Array, parts: Array, square: Any) -> Any:
    """Σ c² η²/(λ + η²)."""
    if isinstance(square, np.ndarray) and square.ndim:
        return parts @ (square / (values[:, None] + square))
    return sum(
        part * (square / (value + square))
        for value, part in zip(values.tolist(), parts.tolist(), strict=True)
    )


def piece(degree: int, length: Any) -> Piece:
    """A part of this length > 0 (a number or an array), on equal elements."""
    longest = length.max() if isinstance(length, np.ndarray) else length
    times = _doublings(longest)
    found = element(degree, length / 2 ** (times + 1))
    for _ in range(times):
        found = found.doubled
    return found


def _doublings(length: float) -> int:
    """How often an element is doubled, so that it is at most _LONGEST long."""
    return max(0, math.ceil(math.log2(length / _LONGEST)))


class Half(NamedTuple):
    """B and A of a gap; numbers or arrays."""

    even: Any
    odd: Any


def half(degree: int, length: Any) -> Half:
    """B and A of a gap of this length > 0 (a number or an array)."""
    if not isinstance(length, np.ndarray):
        if length > 2 * FAR:
            return Half(linear(degree).reaction, linear(degree).reaction)
        ground, tie = piece(degree, length / 2)
    else:
        ground, tie = piece(degree, np.minimum(length, 2 * FAR) / 2)
    return Half(ground + tie * ground / (ground + tie), ground + tie)


def rates(degree: int, length: float) -> Half:
    """Derivatives of B and A of a gap by its length, from a step along the imaginary axis.

    B and A are rational functions of the length, so that Im B(L + ih)/h has no difference to lose
    digits in. W. Squire, G. Trapp, SIAM Review 40 (1998) 110.
    """
    if length > 2 * FAR:
        return Half(0.0, 0.0)
    times = _doublings(length / 2)
    found = element(degree, complex(length, _STEP * length) / 2 ** (times + 2))
    for _ in range(times):
        found = found.doubled
    even = found.ground + found.tie * found.ground / (found.ground + found.tie)
    odd = found.ground + found.tie
    return Half(even.imag / (_STEP * length), odd.imag / (_STEP * length))


def count(length: float) -> int:
    """Elements on half of a gap."""
    return int(2 ** _doublings(length / 2))


@dataclass(frozen=True, eq=False)
class Shapes:
    """The even and the odd surface of a gap: nodal values on the half next to the line."""

    degree: int
    length: float
    u: Array

    @property
    def lengths(self) -> tuple[float, ...]:
        """The elements."""
        n = count(self.length)
        return (self.length / (2 * n),) * n

    def at(self, distance: Array, which: int) -> Array:
        """The even (0) or odd (1) surface at distances up to the middle."""
        size = self.lengths[0]
        e = np.clip((distance / size).astype(int), 0, len(self.lengths) - 1)
        values = self.u[which][e[:, None] * self.degree + np.arange(self.degree + 1)]
        at = 2 * (distance / size - e) - 1
        return polynomials(self.degree, at, values)

    @property
    def slopes(self) -> Array:
        """Slopes at the line, of even and odd."""
        d = rounded(self.degree)[2][0]
        return np.asarray(self.u[:, : self.degree + 1] @ d * 2 / self.lengths[0])

    @property
    def areas(self) -> Array:
        """∫u dx over the half, of even and odd."""
        weights, n = rounded(self.degree)[1] * self.lengths[0] / 2, len(self.lengths)
        mass = np.zeros(n * self.degree + 1)
        for e in range(n):
            mass[e * self.degree : (e + 1) * self.degree + 1] += weights
        return np.asarray(self.u @ mass)

    @property
    def residual(self) -> float:
        """Largest imbalance of a free node of the discrete equations on the half."""
        _, weights, d = rounded(self.degree)
        n, eta, found = len(self.lengths), self.lengths[0] / 2, np.zeros_like(self.u)
        hessian = (d.T * weights) @ d / eta + np.diag(weights) * eta
        for e in range(n):
            own = slice(e * self.degree, (e + 1) * self.degree + 1)
            found[:, own] += self.u[:, own] @ hessian
        return float(max(np.abs(found[0, 1:]).max(), np.abs(found[1, 1:-1]).max(initial=0.0)))


@functools.lru_cache(maxsize=256)
def shapes(degree: int, length: float) -> Shapes:
    """The nodal values of a gap that is not `FAR`."""
    n = count(length)
    part = element(degree, length / (4 * n))
    ends = np.zeros((2, n + 1))
    ends[:, 0] = 1
    for which, s in enumerate((0.0, math.inf)):
        stiff = [s]
        for _ in range(n - 1):
            s = _beyond(part, s)
            stiff.insert(0, s)
        for e, beyond in enumerate(stiff):
            passed = 0.0 if math.isinf(beyond) else part.tie / (part.tie + part.ground + beyond)
            ends[which, e + 1] = ends[which, e] * passed
    even, odd = _inner(degree, length / (4 * n))
    mean, half_rise = (ends[:, :-1] + ends[:, 1:]) / 2, np.diff(ends, axis=1) / 2
    inside = mean[..., None] * even + half_rise[..., None] * odd
    u = np.concatenate([ends[:, :1], inside[..., 1:].reshape(2, -1)], axis=1)
    return Shapes(degree, length, u)


def _beyond(part: Piece, s: float) -> float:
    """Stiffness at the outer end of an element that has the stiffness s at its inner end."""
    y = part.ground + s
    return float(part.ground + (part.tie if math.isinf(s) else part.tie * y / (part.tie + y)))


def _inner(degree: int, eta: float) -> tuple[Array, Array]:
    """Nodal values of an element of length 2η whose ends are displaced by 1, 1 and by -1, 1."""
    points, weights, d = rounded(degree)
    stiffness, mass = (d.T * weights) @ d, np.diag(weights) * eta**2
    found = []
    for outer in (np.ones_like(points), points.copy()):
        load = (mass @ outer)[1:-1]
        outer[1:-1] -= np.linalg.solve((stiffness + mass)[1:-1, 1:-1], load)
        found.append(outer)
    return found[0], found[1]


def displacement(
    degree: int, p: Array, q: Array, length: float, left: float, right: float
) -> Array:
    """u at distances p from the left line and q from the right one (n,)."""
    if length > 2 * FAR:
        tail = linear(degree)
        return left * tail.displacement(p) + right * tail.displacement(q)
    solved, near = shapes(degree, length), np.minimum(p, q)
    sides = np.where(p <= q, 1.0, -1.0)
    even, odd = (solved.at(near, which) for which in (0, 1))
    return (left + right) / 2 * even + sides * (left - right) / 2 * odd


def slope(degree: int, length: float, own: float, other: float) -> float:
    """u' at a line with u = own, towards the other one."""
    if length > 2 * FAR:
        return own * linear(degree).slope
    even, odd = shapes(degree, length).slopes.tolist()
    return (own + other) / 2 * even + (own - other) / 2 * odd
