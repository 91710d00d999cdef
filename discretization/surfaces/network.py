"""Spectral elements, and linear free surfaces between two contact lines, condensed to the lines.

For small slopes, k = γ₁ = l = 1, the surface between lines displaced by u and v stores at least

    E = σ_left u²/2 + σ_right v²/2 + τ (u - v)²/2.

These three numbers are a network of two terminals: σ is a spring from a line to the undisturbed
surface, its ground, and τ one between both lines. Two networks in a row are one, by sums of
positive numbers only (`Network.then`).

One element of a line contact, with Gauss-Lobatto points for its nodes, is condensed once and for
all lengths. Let M and K be the matrices of ∫u² and ∫u'² on [-1, 1], and φ the modes of its inner
nodes, K φ = λ M φ. An element of length 2η has the energy (η uᵀMu + uᵀKu/η)/2. Least over the
modes, it is σ where both ends are displaced by 1, and σ + 2τ where they are by -1 and 1:

    σ = η - η³/2 Σ c²/(λ+η²),    σ + 2τ = 1/η + η/3 - η³/2 Σ b²/(λ+η²),

with c = φᵀM 1 and b = φᵀM x. About an axis see rings.py.

Conventions
-----------
Lengths are in l, stiffnesses in γ₁/l, energies in γ₁l; of line contacts all are per length.
Displacements u are positive downwards, into the layer. A surface is described from its first line
on: `side` is 1 if it extends to the right of that, towards +x or larger radii, and -1 if to the
left. `left` of a network is the first line, whatever the side, and `right` the other one.
`DECAYED` = 40 is the distance in l at which exp(-x) is less than rounding: lines further apart do
not feel each other.
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

Shape = tuple[Array, Array]  # u and u' = du/dx of a surface at the same places, (n,) each


class LineMesh(NamedTuple):
    """Elements beside a line of a line contact; lengths in l.

    Half or twice of each changes the stiffness of a tail by 2e-16, its rounding.

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


# Places from which on the recurrence is used: with 24 polynomials it is four times as fast there.
# For fewer places both take 0.1 ms or less, and cosines round less.
_MANY = 500
TABLES = Path(__file__).with_name("families.npz")  # written by tables.py
# l: up to these radii pieces of families are shipped. Wider contacts cost 0.1 s for each piece that
# is solved for, and their numbers are the same.
_WIDEST = 2.0**12


class Rule(NamedTuple):
    """The Gauss-Lobatto rule of n points, which include both ends.

    Attributes
    ----------
    points : ndarray (n,)
        On [-1, 1], increasing.
    weights : ndarray (n,)
        Their weights in integrals over [-1, 1].
    derivative : ndarray (n, n)
        derivative @ v are the derivatives, at the points, of the polynomial with the values v.
    """

    points: Array
    weights: Array
    derivative: Array


@functools.lru_cache(maxsize=64)
def gauss_lobatto(degree: int) -> Rule:
    """The Gauss-Lobatto rule with degree + 1 points, the nodes of polynomials of this degree.

    With P the Legendre polynomial of the degree, the inner points are the zeros of P', and

        weights 2/(degree (degree + 1) P(x_i)²),    derivative P(x_i)/(P(x_j) (x_i - x_j)), i != j

    (C. Canuto, M. Y. Hussaini, A. Quarteroni, T. A. Zang, Spectral Methods, 2006, section 2.3).
    The diagonal is what the derivative of a constant being 0 leaves. All is computed in the
    machine's widest floating-point type, as rounding of the points would be the largest error of an
    element.

    Parameters
    ----------
    degree : int
        > 0.

    Returns
    -------
    Rule
        In double precision.
    """
    legendre_polynomial = Legendre.basis(degree)
    slope = legendre_polynomial.deriv()
    curvature = legendre_polynomial.deriv(2)
    inner = np.sort(slope.roots().real).astype(np.longdouble)
    for _ in range(3):  # steps of Newton's method from zeros that are good to double precision
        inner -= slope(inner) / curvature(inner)
    points = np.concatenate([[-1], (inner - inner[::-1]) / 2, [1]])  # symmetric to the last bit
    values = legendre.legval(points, legendre_polynomial.coef)
    weights = 2 / (degree * (degree + 1) * values**2)
    differences = points[:, None] - points[None, :] + np.eye(points.size)  # 1 for the diagonal
    derivative = values[:, None] / values[None, :] / differences
    np.fill_diagonal(derivative, 0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return Rule(points.astype(float), weights.astype(float), derivative.astype(float))


@functools.lru_cache(maxsize=64)
def to_legendre(degree: int) -> Array:
    """The matrix from values at the Gauss-Lobatto points to Legendre coefficients.

    Parameters
    ----------
    degree : int

    Returns
    -------
    ndarray (degree + 1, degree + 1)
        Rows of values times this matrix are rows of coefficients, of increasing degree.
    """
    points, weights, _ = gauss_lobatto(degree)
    basis = legendre.legvander(points, degree)
    # Under the rule Legendre polynomials are orthogonal, with these sums for their squares.
    squares = weights @ basis**2
    return np.asarray(basis * weights[:, None] / squares)


@functools.lru_cache(maxsize=64)
def _to_chebyshev(degree: int) -> Array:
    """The matrix from columns of values at the Gauss-Lobatto points to Chebyshev coefficients."""
    return np.asarray(np.linalg.inv(chebyshev(gauss_lobatto(degree).points, degree + 1)))


def on_elements(ends: Array, u: Array, x: Array) -> Shape:
    """A function and its slope at places, from its nodal values on elements.

    Parameters
    ----------
    ends : ndarray (e + 1,)
        Ends of the elements, increasing.
    u : ndarray (e * degree + 1,)
        Nodal values at the Gauss-Lobatto points of the elements, from the first element on;
        neighbouring elements share a node.
    x : ndarray (n,)
        Places between the first end and the last one; a place where two elements meet belongs to
        the later one.

    Returns
    -------
    values, slopes : ndarray (n,)
        The function, and its derivative by x.
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
    """The matrix of elements in a row, each of which shares its last node with the next one.

    Parameters
    ----------
    blocks : ndarray (..., m, degree + 1, degree + 1)
        Symmetric matrices of m elements, of one mesh or several.

    Returns
    -------
    ndarray (..., degree + 1, m * degree + 1)
        Their sum in the lower banded form of LAPACK: row i holds the i-th diagonal below the main
        one, row 0 the main one.
    """
    *many, elements, size, _ = blocks.shape
    degree = size - 1
    last_node = elements * degree
    result = np.zeros((*many, size, last_node + 1))
    for column in range(size):
        columns = slice(column, column + last_node, degree)  # that node of all elements
        for row in range(column, size):
            result[..., row - column, columns] += blocks[..., row, column]
    return result


def chebyshev(t: Array, count: int) -> Array:
    """The first Chebyshev polynomials, T₀ to T_{count-1}, at places.

    T_k = cos(k acos t); at many places by T_{k+1} = 2t T_k - T_{k-1}, several times as fast. Its
    error grows with k, which the coefficients of smooth functions make up for as they fall.

    Parameters
    ----------
    t : ndarray (n,)
        From -1 to 1, but for rounding.
    count : int

    Returns
    -------
    ndarray (n, count)
        T_k(t) in column k.
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
    """Numbers of the pieces of a family that are shipped: they cover radii up to `_WIDEST`.

    Parameters
    ----------
    least : float
        The smallest radius that they cover [l].
    octaves : float
        Length of a piece in log₂ s; see `Family`.

    Returns
    -------
    range
    """
    first = math.floor(math.log2(least) / octaves)
    stop = math.ceil(math.log2(_WIDEST) / octaves)
    return range(first, stop)


@functools.cache
def tables() -> dict[str, Array]:
    """The pieces of all families that are shipped.

    Returns
    -------
    dict of ndarray (pieces, points, values)
        Chebyshev coefficients under the names of `Family.key`; the pieces in the order of their
        numbers (`Family.shipped`), the coefficients as of `Family.piece`.
    """
    with np.load(TABLES) as file:
        return dict(file)


@dataclass(frozen=True, eq=False)
class Family:
    """Smooth functions of log s, of several kinds, read as polynomials on pieces of some octaves.

    Here s is the radius of a contact line [l], and a kind says on which side of the line the
    surface is, 1 outside and -1 inside (twice that for steep lines, in menisci.py). Piece number n
    is the range of s from 2^(n octaves) to 2^((n + 1) octaves). As the functions depend on nothing
    else, those pieces that most scenes need are read from a file (tables.py); others are solved for
    when first needed.

    Attributes
    ----------
    name : str
        That in the file.
    solve : callable
        solve(kind, s): values (n, values) of one kind at s (n,), exact to rounding.
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
        """Chebyshev coefficients (points, values) of a piece, of increasing degree down a column.

        The polynomials are those in t = 2 (log₂(s)/octaves - number) - 1, from -1 to 1.
        """
        numbers = self.shipped[kind]
        if number in numbers:
            return tables()[self.key(kind)][numbers.index(int(number))]
        return self.fitted(kind, number)

    def fitted(self, kind: int, number: float) -> Array:
        """The coefficients of `piece`, of the polynomials through values that are solved for."""
        t = chebpts1(self.points)
        found = self.solve(kind, 2.0 ** (self.octaves * (number + (t + 1) / 2)))
        return np.asarray(np.linalg.solve(chebyshev(t, self.points), found))

    def key(self, kind: int) -> str:
        """The name of one kind's pieces in the file."""
        return f"{self.name} {int(kind):+d}"

    def one(self, kind: int, s: float) -> Array:
        """Values (values,) of one kind at one s > 0."""
        place = math.log2(s) / self.octaves
        number = math.floor(place)
        t = 2 * (place - number) - 1
        angle = math.acos(min(max(t, -1.0), 1.0))
        return np.asarray(np.cos(angle * np.arange(self.points)) @ self.piece(kind, number))

    def at(self, kinds: Any, s: Array) -> Array:
        """Values (n, values) of these kinds, a number or (n,), at s (n,), each > 0."""
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
    """A surface between two lines as a network of two terminals; see the head of this module.

    Attributes
    ----------
    left, right : float, complex or ndarray
        σ: stiffness between the first, or the other, line and the undisturbed surface [γ₁/l].
    tie : float, complex or ndarray
        τ: stiffness between both lines [γ₁/l]; 0 if they do not feel each other, or if there is no
        other line.
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
        """∂E/∂u and ∂E/∂v [γ₁], the forces downwards that displace the lines by u and v.

        The parameters are those of `energy`.
        """
        tied = self.tie * difference
        return self.left * u + tied, self.right * v - tied

    def then(self, other: Network) -> Network:
        """This network and another one on its right, as one.

        The point where they meet is free of forces: its displacement is the mean of 0 and those of
        both lines, weighted by `middle`, which grounds it, and both ties. A tie thus acts in series
        with the others: `own_share` of `middle` grounds this line, and so on.
        """
        middle = self.right + other.left
        total = self.tie + other.tie + middle
        own_share = self.tie / total
        other_share = other.tie / total
        return Network(
            self.left + own_share * middle,
            other_share * self.tie,
            other.right + other_share * middle,
        )


class Mode(NamedTuple):
    """A mode φ of the inner nodes of an element [-1, 1], K φ = λ M φ with φᵀ M φ = 1.

    Attributes
    ----------
    value : float
        λ.
    share : float
        (φᵀ M e)², the squared share of the mode in e: 1 for even modes, and x for odd ones.
    """

    value: float
    share: float


@functools.lru_cache(maxsize=16)
def modes(degree: int) -> tuple[list[Mode], list[Mode]]:
    """The even and the odd modes of the inner nodes of an element of a degree.

    Springs load even modes alone if both ends are displaced by 1, and odd ones alone if they are by
    -1 and 1; the tension then loads none, as φ is 0 at the ends.
    """
    points, weights, derivative = gauss_lobatto(degree)
    root_mass = np.sqrt(weights[1:-1])
    stiffness = ((derivative.T * weights) @ derivative)[1:-1, 1:-1]
    values, vectors = np.linalg.eigh(stiffness / np.outer(root_mass, root_mass))
    c = root_mass @ vectors[:, 0::2]  # even and odd modes take turns
    b = root_mass * points[1:-1] @ vectors[:, 1::2]
    even = list(map(Mode, values[0::2].tolist(), (c**2).tolist()))
    odd = list(map(Mode, values[1::2].tolist(), (b**2).tolist()))
    return even, odd


def _relief(modes: list[Mode], square: Any) -> Any:
    """Σ share η²/(λ + η²) over the modes, with square = η², η half the length of an element.

    It is 2/η times what the energy falls by as the inner nodes move from where 1, or x, has them.
    """
    total = 0.0
    for value, share in modes:
        total = total + share * (square / (value + square))
    return total


def piece(degree: int, length: Any) -> Network:
    """A part of a line contact's surface, condensed to its two ends.

    It is divided into 1, 2, 4, … equal elements, until none is longer than `LineMesh.longest`.

    Parameters
    ----------
    degree : int
        Degree of the polynomials on its elements.
    length : float, complex or ndarray
        > 0 [l]; complex for derivatives by the length (small.py).

    Returns
    -------
    Network
    """
    longest = length.real.max() if isinstance(length, np.ndarray) else length.real
    doublings = max(0, math.ceil(math.log2(longest / _MESH.longest)))
    half = length / 2 ** (doublings + 1)  # η of one element
    square = half * half
    even, odd = modes(degree)
    ground = half * (1 - _relief(even, square) / 2)  # σ
    ground_and_ties = 1 / half + half * (1 / 3 - _relief(odd, square) / 2)  # σ + 2τ
    found = Network(ground, (ground_and_ties - ground) / 2, ground)
    for _ in range(doublings):  # two equal parts in a row are one of twice the length
        found = found.then(found)
    return found


_piece_of_length = functools.lru_cache(maxsize=256)(piece)  # gaps of one length come often


@functools.lru_cache(maxsize=16)
def semi_infinite_stiffness(degree: int) -> float:
    """Reaction of a tail over the displacement of its line [γ₁/l], 1 but for the discretisation.

    A tail is the surface beside a line that no other line faces. Beyond its elements it decays like
    exp(-x), so that at their last node the far field is a spring of stiffness 1.
    """
    far_field = Network(1.0, 0.0, 0.0)
    return float(piece(degree, _MESH.covered).then(far_field).left)


class Line(NamedTuple):
    """The networks of a line contact, on elements of one degree.

    Attributes
    ----------
    degree : int
        Degree of the polynomials on an element.
    """

    degree: int

    def between(self, side: Any, s: Any, width: Any) -> Network:
        """The surface from one line to another.

        Parameters
        ----------
        side, s : int, float or ndarray
            Direction of the other line, and place of the first one. Nothing depends on them: they
            are there because `rings.Axis`, which has the same methods, needs them.
        width : float, complex or ndarray
            Distance of the lines [l]; infinite if there is no other line, whose terminal then is
            one of another tail, not tied to the first.

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
        """Displacement and slope of a surface between two lines, or beside one.

        The exact solution of u'' = u, u cosh(x - L/2)/cosh(L/2) + rise sinh(x)/sinh(L). It is
        evaluated with decaying exponentials alone, so that L = ∞ is no special case.

        Parameters
        ----------
        x : ndarray (n,)
            Distances from the first line, towards the other one [l].
        side, s : int, float
            Nothing depends on them; see `between`.
        width : float
            Distance L of the lines [l], infinite if there is one alone.
        u, rise : float
            Displacement of the first line, and how much more the other one is displaced [l].

        Returns
        -------
        u, slope : ndarray (n,)
            [l], and du/dx.
        """
        near = np.exp(-x)
        far = np.exp(x - width)
        scaled_cosh = 1 + math.exp(-width)  # 2 exp(-L/2) cosh(L/2)
        scaled_sinh = -math.expm1(-2 * width)  # 2 exp(-L) sinh(L)
        ramp = far * -np.expm1(-2 * x) / scaled_sinh  # sinh(x)/sinh(L)
        ramp_slope = far * (1 + near * near) / scaled_sinh
        values = u * (near + far) / scaled_cosh + rise * ramp
        slopes = u * (far - near) / scaled_cosh + rise * ramp_slope
        return values, slopes
