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

from discretization.certificate import DECAYED
from energy.arrays import Array

Shape = tuple[Array, Array]  # u and u' of a surface at places (n,)


class LineMesh(NamedTuple):
    """Elements beside a line of a line contact; lengths in l.

    Attributes
    ----------
    longest : float
        Longest element, up to which the polynomials of `Line` have errors that are rounding; longer
        parts are several elements in a row.
    covered : float
        Distance from a line up to which there are elements; what is beyond is eliminated exactly.
    """

    longest: float = 0.5
    covered: float = 4.0


_MESH = LineMesh()


_MANY = 500  # places from which on a recurrence is faster than as many cosines
TABLES = Path(__file__).with_name("families.npz")  # written by tables.py
_WIDEST = 2.0**12  # l: up to these radii pieces of families are shipped; few contacts are wider


class Rule(NamedTuple):
    """Gauss-Lobatto points on [-1, 1], their weights, and the matrix of derivatives there."""

    points: Array
    weights: Array
    derivative: Array


@functools.lru_cache(maxsize=64)
def gauss_lobatto(degree: int) -> Rule:
    """The Gauss-Lobatto rule whose points are the nodes of polynomials of a degree.

    It is computed in the machine's widest floating-point type, as rounding of the points would be
    the largest error of an element.

    Parameters
    ----------
    degree : int

    Returns
    -------
    Rule
        Points and weights (degree + 1,), derivative (degree + 1, degree + 1).
    """
    legendre_polynomial = Legendre.basis(degree)
    slope = legendre_polynomial.deriv()
    curvature = legendre_polynomial.deriv(2)
    inner = np.sort(slope.roots().real).astype(np.longdouble)
    for _ in range(3):  # steps of Newton's method from zeros that are good to double precision
        inner -= slope(inner) / curvature(inner)
    points = np.concatenate([[-1], (inner - inner[::-1]) / 2, [1]])
    values = legendre.legval(points, legendre_polynomial.coef)
    weights = 2 / (degree * (degree + 1) * values**2)
    differences = points[:, None] - points[None, :] + np.eye(points.size)
    derivative = values[:, None] / values[None, :] / differences
    np.fill_diagonal(derivative, 0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return Rule(points.astype(float), weights.astype(float), derivative.astype(float))


@functools.lru_cache(maxsize=64)
def to_legendre(degree: int) -> Array:
    """The matrix that takes rows of values at the Gauss-Lobatto points to Legendre coefficients.

    Parameters
    ----------
    degree : int

    Returns
    -------
    ndarray (degree + 1, degree + 1)
    """
    points, weights, _ = gauss_lobatto(degree)
    basis = legendre.legvander(points, degree)
    return np.asarray(basis * weights[:, None] / (weights @ basis**2))


@functools.lru_cache(maxsize=64)
def _to_chebyshev(degree: int) -> Array:
    """The matrix from values at the Gauss-Lobatto points to Chebyshev coefficients."""
    return np.asarray(np.linalg.inv(chebyshev(gauss_lobatto(degree).points, degree + 1)))


def on_elements(ends: Array, u: Array, x: Array) -> Shape:
    """A function and its slope at places, from its nodal values on elements.

    Parameters
    ----------
    ends : ndarray (e + 1,)
        Ends of the elements, increasing.
    u : ndarray (e * degree + 1,)
        Nodal values; neighbouring elements share a node.
    x : ndarray (n,)
        Places.

    Returns
    -------
    values, slopes : ndarray (n,)
    """
    degree = (u.size - 1) // (ends.size - 1)
    element = np.searchsorted(ends[1:-1], x, side="right")
    nodes = element[:, None] * degree + np.arange(degree + 1)
    nodal = u[nodes]
    width = np.diff(ends)[element]
    place = 2 * (x - ends[element]) / width - 1  # from -1 to 1 on the element
    basis = chebyshev(place, degree + 1)
    shape_functions = basis @ _to_chebyshev(degree)
    values = (shape_functions * nodal).sum(axis=1)
    slopes = (shape_functions * (nodal @ gauss_lobatto(degree).derivative.T)).sum(axis=1)
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
    first = math.floor(math.log2(least) / octaves)
    stop = math.ceil(math.log2(_WIDEST) / octaves)
    return range(first, stop)


@functools.cache
def tables() -> dict[str, Array]:
    """The pieces of all families that are shipped: (pieces, points, values) by family and kind."""
    with np.load(TABLES) as file:
        return dict(file)


@dataclass(frozen=True, eq=False)
class Family:
    """Smooth functions of log s, of several kinds, read as polynomials on pieces of some octaves.

    Piece number n is the octaves that begin at s = 2^(n octaves). As the functions depend on
    nothing else, those pieces that most scenes need are read from a file (tables.py); others are
    solved for when first needed.

    Attributes
    ----------
    name : str
        That in the file.
    solve : callable
        solve(kind, s): values (n, values) of one kind at s (n,).
    values : int
        How many functions each kind has.
    points : int
        Chebyshev points of a piece.
    octaves : float
        Length of a piece in log₂ s.
    shipped : dict of range
        Numbers of the pieces in the file, by kind.
    """

    name: str
    solve: Callable[[int, Array], Array]
    values: int
    points: int
    octaves: float
    shipped: dict[int, range]

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
        """Values (values,) of one kind at one s."""
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
        kinds = np.broadcast_to(kinds, s.shape)
        found = np.empty((s.size, self.values))
        for kind, number in set(zip(kinds.tolist(), numbers.tolist(), strict=True)):
            own = (kinds == kind) & (numbers == number)
            found[own] = basis[own] @ self.piece(kind, number)
        return found


class Network(NamedTuple):
    """A surface between two lines as a network of two terminals.

    Attributes
    ----------
    left, right : float or ndarray
        σ: stiffness that grounds each line.
    tie : float or ndarray
        τ: stiffness between them.
    """

    left: Any
    tie: Any
    right: Any

    def energy(self, u: Any, v: Any, difference: Any) -> Any:
        """Energy E of a surface whose lines are displaced.

        Parameters
        ----------
        u, v : float or ndarray
            Displacements of the left and the right line [l].
        difference : float or ndarray
            u - v, which is given besides: of a short surface, subtraction would leave few digits.

        Returns
        -------
        float or ndarray
            [γ₁ l].
        """
        grounded = self.left * u * u + self.right * v * v
        return (grounded + self.tie * difference * difference) / 2

    def pulls(self, u: Any, v: Any, difference: Any) -> tuple[Any, Any]:
        """∂E/∂u and ∂E/∂v, the forces that displace the lines by u and v; as `energy`."""
        tied = self.tie * difference
        return self.left * u + tied, self.right * v - tied

    def then(self, other: Network) -> Network:
        """This network and another one on its right: the line between them is eliminated."""
        middle = self.right + other.left
        total = self.tie + other.tie + middle
        own_share = self.tie / total
        other_share = other.tie / total
        return Network(
            self.left + own_share * middle,
            other_share * self.tie,
            other.right + other_share * middle,
        )


Modes = list[list[float]]  # λ and the squared share of a load, of each mode


@functools.lru_cache(maxsize=16)
def modes(degree: int) -> tuple[Modes, Modes]:
    """Modes of the inner nodes of an element [-1, 1], K φ = λ M φ with φᵀ M φ = 1.

    λ and c² of the even ones, c = φᵀ M 1, and λ and b² of the odd ones, b = φᵀ M x.
    """
    points, weights, derivative = gauss_lobatto(degree)
    root_mass = np.sqrt(weights[1:-1])
    stiffness = ((derivative.T * weights) @ derivative)[1:-1, 1:-1]
    values, vectors = np.linalg.eigh(stiffness / np.outer(root_mass, root_mass))
    c = root_mass @ vectors[:, 0::2]  # even and odd modes take turns
    b = root_mass * points[1:-1] @ vectors[:, 1::2]
    even = np.array([values[0::2], c**2]).T
    odd = np.array([values[1::2], b**2]).T
    return even.tolist(), odd.tolist()


def _compliance(modes: Modes, square: Any) -> Any:
    """Σ share η²/(λ + η²) over the modes; square: η²."""
    total = 0.0
    for value, share in modes:
        total = total + share * (square / (value + square))
    return total


def piece(degree: int, length: Any) -> Network:
    """A part of a line contact's surface, condensed to its two ends.

    Parameters
    ----------
    degree : int
        Degree of the polynomials on its elements.
    length : float, complex or ndarray
        > 0 [l].

    Returns
    -------
    Network
    """
    longest = length.real.max() if isinstance(length, np.ndarray) else length.real
    doublings = max(0, math.ceil(math.log2(longest / _MESH.longest)))
    half = length / 2 ** (doublings + 1)  # η of one element
    square = half * half
    even, odd = modes(degree)
    ground = half * (1 - _compliance(even, square) / 2)
    ground_and_ties = 1 / half + half * (1 / 3 - _compliance(odd, square) / 2)
    found = Network(ground, (ground_and_ties - ground) / 2, ground)
    for _ in range(doublings):
        found = found.then(found)
    return found


_piece_of_length = functools.lru_cache(maxsize=256)(piece)  # gaps of one length come often


@functools.lru_cache(maxsize=16)
def semi_infinite_stiffness(degree: int) -> float:
    """Reaction of a tail over the displacement of its line.

    That is 1 but for the discretisation. The far field, which acts on the last node of the elements
    with its displacement, is eliminated exactly.
    """
    far_field = Network(1.0, 0.0, 0.0)
    return float(piece(degree, _MESH.covered).then(far_field).left)


class Line(NamedTuple):
    """The networks of a line contact, on elements of one degree."""

    degree: int

    def between(self, side: Any, s: Any, width: Any) -> Network:
        """The surface from one line to another.

        Parameters
        ----------
        side, s : int, float or ndarray
            Direction of the other line, and place of the first one; all are alike here.
        width : float, complex or ndarray
            Distance of the lines [l], maybe infinite.

        Returns
        -------
        Network
        """
        if isinstance(width, np.ndarray):
            half = piece(self.degree, np.minimum(width, DECAYED) / 2)
        elif width.real > DECAYED:
            stiffness = semi_infinite_stiffness(self.degree)
            return Network(stiffness, 0.0, stiffness)
        else:
            half = _piece_of_length(self.degree, width / 2)
        return half.then(half)

    def shape(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """u and u' at distances x from a line displaced by u towards another one, by u + rise.

        With exact decays, u cosh(x - L/2)/cosh(L/2) + rise sinh(x)/sinh(L), also for L = ∞.
        """
        near = np.exp(-x)
        far = np.exp(x - width)
        cosh = 1 + math.exp(-width)  # 2 exp(-L/2) cosh(L/2)
        sinh = -math.expm1(-2 * width)  # 2 exp(-L) sinh(L)
        ramp = far * -np.expm1(-2 * x) / sinh
        ramp_slope = far * (1 + near * near) / sinh
        values = u * (near + far) / cosh + rise * ramp
        slopes = u * (far - near) / cosh + rise * ramp_slope
        return values, slopes
