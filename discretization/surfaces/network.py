"""Spectral elements, and linear free surfaces between two contact lines, condensed to the lines.

For small slopes, k = γ₁ = l = 1, the surface between lines displaced by u and v stores at least

    E = σ_left u²/2 + σ_right v²/2 + τ (u - v)²/2,

three numbers: what its ends are grounded by, and what ties them, a network of two terminals. Two of
them in a row are one, by sums of positive numbers only (`then`).

One element of a line contact, with Gauss-Lobatto points for its nodes, is condensed once and for
all lengths: with the modes of its inner nodes, K φ = λ M φ, of length 2η

    σ = η - η³/2 Σ c²/(λ+η²),    σ + 2τ = 1/η + η/3 - η³/2 Σ b²/(λ+η²),

c and b the modes' shares of 1 and x. About an axis see rings.py.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Legendre, legendre
from numpy.polynomial.chebyshev import chebpts1

from energy.arrays import Array

Shape = tuple[Array, Array]  # u and u' of a surface at places (n,)
FAR = 40.0  # l: the lines of a surface this wide do not feel each other, e^-40 = 4e-18
_LONGEST = 0.5  # l: of an element, which rounding then resolves
_MANY = 500  # places from which on a recurrence is faster than so many cosines
_COVERED = 4.0  # l: beside a line, by elements
TABLES = Path(__file__).with_name("families.npz")  # written by tables.py
_WIDEST = 2.0**12  # l: up to these radii pieces of families are shipped; few contacts are wider


@functools.lru_cache(maxsize=64)
def rounded(degree: int) -> tuple[Array, Array, Array]:
    """Gauss-Lobatto points on [-1, 1], their weights, and the matrix of derivatives there.

    In the machine's widest floating-point type, as their rounding would be the largest error.
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
    return x.astype(float), weights.astype(float), d.astype(float)


@functools.lru_cache(maxsize=64)
def to_legendre(degree: int) -> Array:
    """The matrix that takes rows of values at the Gauss-Lobatto points to Legendre coefficients."""
    points, weights, _ = rounded(degree)
    basis = legendre.legvander(points, degree)
    return np.asarray(basis * weights[:, None] / (weights @ basis**2))


@functools.lru_cache(maxsize=64)
def _interpolation(degree: int) -> Array:
    """Values at the Gauss-Lobatto points to coefficients of Chebyshev polynomials."""
    return np.asarray(np.linalg.inv(chebyshev(rounded(degree)[0], degree + 1)))


def on_elements(ends: Array, u: Array, x: Array) -> Shape:
    """A surface and its slope at x (n,), from its nodal values on elements between ends."""
    degree, e = (u.size - 1) // (ends.size - 1), np.searchsorted(ends[1:-1], x, side="right")
    own, width = u[e[:, None] * degree + np.arange(degree + 1)], np.diff(ends)[e]
    at = chebyshev(2 * (x - ends[e]) / width - 1, degree + 1) @ _interpolation(degree)
    values, slopes = ((at * part).sum(axis=1) for part in (own, own @ rounded(degree)[2].T))
    return np.asarray(values), np.asarray(slopes * 2 / width)


def band(blocks: Array) -> Array:
    """Element matrices (..., m, degree+1, degree+1) added up, lower banded (..., degree+1, n)."""
    *many, elements, size, _ = blocks.shape
    last = elements * (size - 1)
    result = np.zeros((*many, size, last + 1))
    for i in range(size):
        for j in range(i, size):
            result[..., j - i, i : i + last : size - 1] += blocks[..., j, i]
    return result


def chebyshev(t: Array, count: int) -> Array:
    """The first Chebyshev polynomials at t (n, count).

    T_k = cos(k acos t); at many places by T_{k+1} = 2t T_k - T_{k-1}, several times as fast, whose
    error grows with k as the coefficients of smooth functions fall.
    """
    if t.size >= _MANY:
        found = np.empty((count, t.size))
        found[0] = 1.0
        found[1:2] = t
        twice = 2 * t
        for k in range(2, count):
            np.multiply(twice, found[k - 1], out=found[k])
            found[k] -= found[k - 2]
        return found.T
    angle = np.arccos(np.minimum(np.maximum(t, -1.0), 1.0))
    return np.asarray(np.cos(angle[:, None] * np.arange(count)))


def shipped(least: float, octaves: float) -> range:
    """Numbers of the pieces of so many octaves that are shipped of a family, from a radius on."""
    first, last = math.log2(least) / octaves, math.log2(_WIDEST) / octaves
    return range(math.floor(first), math.ceil(last))


@functools.cache
def tables() -> dict[str, Array]:
    """The pieces of all families that are shipped: (pieces, points, values) by family and kind."""
    with np.load(TABLES) as file:
        return dict(file)


@dataclass(frozen=True, eq=False)
class Family:
    """Smooth functions of log s, of several kinds, read as polynomials on pieces of some octaves.

    solve(kind, s): their values (n, values) at s (n,). Piece number n is the octaves that begin at
    s = 2^(n octaves). As the functions depend on nothing else, those pieces that most scenes need
    are read from a file (tables.py); others are solved for when first needed.
    """

    name: str  # in the file
    solve: Callable[[int, Array], Array]
    values: int
    points: int
    octaves: float
    shipped: dict[int, range]  # numbers of the pieces in the file, by kind

    @functools.cache  # noqa: B019
    def piece(self, kind: int, number: float) -> Array:
        """Chebyshev coefficients (points, values)."""
        numbers = self.shipped[kind]
        if number in numbers:
            return tables()[self.key(kind)][numbers.index(int(number))]
        return self.fitted(kind, number)

    def fitted(self, kind: int, number: float) -> Array:
        """Chebyshev coefficients (points, values) of the polynomials through values solved for."""
        t = chebpts1(self.points)
        found = self.solve(kind, 2.0 ** (self.octaves * (number + (t + 1) / 2)))
        return np.asarray(np.linalg.solve(chebyshev(t, self.points), found))

    def key(self, kind: int) -> str:
        """The name of one kind's pieces in the file."""
        return f"{self.name} {int(kind):+d}"

    def one(self, kind: int, s: float) -> Array:
        """Values of one kind at one s."""
        place = math.log2(s) / self.octaves
        number = math.floor(place)
        angle = math.acos(min(max(2 * (place - number) - 1, -1.0), 1.0))
        return np.asarray(np.cos(angle * np.arange(self.points)) @ self.piece(kind, number))

    def at(self, kinds: Any, s: Array) -> Array:
        """Values (n, values) of these kinds, a number or (n,), at s (n,)."""
        if s.size == 1:
            return self.one(np.asarray(kinds).item(), s.item())[None]
        place = np.log2(s) / self.octaves
        numbers = np.floor(place)
        basis = chebyshev(2 * (place - numbers) - 1, self.points)
        found, kinds = np.empty((s.size, self.values)), np.broadcast_to(kinds, s.shape)
        for kind, number in set(zip(kinds.tolist(), numbers.tolist(), strict=True)):
            own = (kinds == kind) & (numbers == number)
            found[own] = basis[own] @ self.piece(kind, number)
        return found


class Network(NamedTuple):
    """σ_left, τ and σ_right; numbers or arrays."""

    left: Any
    tie: Any
    right: Any

    def energy(self, u: Any, v: Any, apart: Any) -> Any:
        """E of ends displaced by u and v; apart: u - v, of which a short one would leave little."""
        return (self.left * u * u + self.right * v * v + self.tie * apart * apart) / 2

    def pulls(self, u: Any, v: Any, apart: Any) -> tuple[Any, Any]:
        """∂E/∂u and ∂E/∂v."""
        return self.left * u + self.tie * apart, self.right * v - self.tie * apart

    def then(self, other: Network) -> Network:
        """With another one in a row: the line between them is eliminated."""
        middle = self.right + other.left
        whole = self.tie + other.tie + middle
        share, rest = self.tie / whole, other.tie / whole
        return Network(self.left + share * middle, rest * self.tie, other.right + rest * middle)


@functools.lru_cache(maxsize=16)
def modes(degree: int) -> tuple[list[list[float]], list[list[float]]]:
    """Of the inner nodes of an element [-1, 1]: λ and c² of even ones, λ and b² of odd ones."""
    points, weights, d = rounded(degree)
    root = np.sqrt(weights[1:-1])
    stiffness = ((d.T * weights) @ d)[1:-1, 1:-1]
    values, vectors = np.linalg.eigh(stiffness / np.outer(root, root))
    c, b = ((root * points[1:-1] ** i @ vectors[:, i::2]) ** 2 for i in (0, 1))  # in turn
    even, odd = (np.array([values[i::2], part]).T.tolist() for i, part in enumerate((c, b)))
    return even, odd


def piece(degree: int, length: Any) -> Network:
    """A part of a line contact's surface, of this length > 0 (a number or an array)."""
    longest = length.real.max() if isinstance(length, np.ndarray) else length.real
    times = max(0, math.ceil(math.log2(longest / _LONGEST)))
    eta = length / 2 ** (times + 1)  # doubled so often, elements are not too long
    square = eta * eta
    even, odd = (
        sum(part * (square / (value + square)) for value, part in each) for each in modes(degree)
    )
    ground, both = eta * (1 - even / 2), 1 / eta + eta * (1 / 3 - odd / 2)
    found = Network(ground, (both - ground) / 2, ground)
    for _ in range(times):
        found = found.then(found)
    return found


_remembered = functools.lru_cache(maxsize=256)(piece)  # of one length, often asked for again


@functools.lru_cache(maxsize=16)
def endless(degree: int) -> float:
    """What the endless surface beside a line pulls, over its displacement.

    Far from the line it is eliminated exactly: it acts on the elements' last node with the force u.
    """
    return float(piece(degree, _COVERED).then(Network(1.0, 0.0, 0.0)).left)


class Line(NamedTuple):
    """The networks of a line contact, on elements of one degree."""

    degree: int

    def between(self, side: Any, s: Any, width: Any) -> Network:
        """From a line at s to another one, this much further to a side, maybe infinitely far."""
        one = not isinstance(width, np.ndarray)
        if one and width.real > FAR:
            return Network(endless(self.degree), 0.0, endless(self.degree))
        find, width = (_remembered, width) if one else (piece, np.minimum(width, FAR))
        half = find(self.degree, width / 2)
        return half.then(half)

    def shape(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """u and u' at distances x from a line displaced by u towards another one, by u + rise.

        With exact decays, u cosh(x - L/2)/cosh(L/2) + rise sinh(x)/sinh(L), also for L = ∞.
        """
        one, other = np.exp(-x), np.exp(x - width)
        both, odd = 1 + math.exp(-width), -math.expm1(-2 * width)
        grown, steep = other * -np.expm1(-2 * x) / odd, other * (1 + one * one) / odd
        return u * (one + other) / both + rise * grown, u * (other - one) / both + rise * steep
