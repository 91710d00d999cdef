"""Linear free surfaces between two contact lines, condensed to them: networks of two terminals.

With small slopes, in units of l and γ₁ (k = γ₁ = l = 1), the surface between lines displaced by u
and v stores at least

    E = σ_left u²/2 + σ_right v²/2 + τ (u - v)²/2,

three numbers: what its ends are grounded by, and what ties them. Two networks in a row are one, by
sums of positive numbers only (`then`).

One spectral element of a line contact is condensed once and for all lengths: with the modes of its
inner nodes, K φ = λ M φ, of length 2η

    σ = η - η³/2 Σ c²/(λ+η²),    σ + 2τ = 1/η + η/3 - η³/2 Σ b²/(λ+η²),

c and b the modes' shares of 1 and x. About an axis see rings.py.
"""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.spectral import lobatto

Array = NDArray[np.float64]
FAR = 40.0  # l: the lines of a surface this wide do not feel each other, e^-40 = 4e-18
_LONGEST = 0.5  # l: of an element, which rounding then resolves
_COVERED = 4.0  # l: beside a line, by elements


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

    def seen_from(self, side: int) -> Network:
        """With the right end first if the free surface is on the left side of a line."""
        return self if side > 0 else Network(*self[::-1])

    def then(self, other: Network) -> Network:
        """With another one in a row: the line between them is eliminated."""
        middle = self.right + other.left
        whole = self.tie + other.tie + middle
        share, rest = self.tie / whole, other.tie / whole
        return Network(self.left + share * middle, rest * self.tie, other.right + rest * middle)


@functools.lru_cache(maxsize=16)
def modes(degree: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Of the inner nodes of an element [-1, 1]: λ and c² of even ones, λ and b² of odd ones."""
    points, weights, d = (np.asarray(part, float) for part in lobatto(degree))
    root = np.sqrt(weights[1:-1])
    stiffness = ((d.T * weights) @ d)[1:-1, 1:-1]
    values, vectors = np.linalg.eigh(stiffness / np.outer(root, root))
    c, b = (root * points[1:-1] ** power @ vectors for power in (0, 1))
    even = np.abs(c) > np.abs(b)
    return (values[even], c[even] ** 2), (values[~even], b[~even] ** 2)


def _share(values: Array, parts: Array, square: Any) -> Any:
    """Σ c² η²/(λ + η²)."""
    if isinstance(square, np.ndarray) and square.ndim:
        return parts @ (square / (values[:, None] + square))
    return sum(
        part * (square / (value + square))
        for value, part in zip(values.tolist(), parts.tolist(), strict=True)
    )


def piece(degree: int, length: Any) -> Network:
    """A part of a line contact's surface, of this length > 0 (a number or an array)."""
    longest = length.max() if isinstance(length, np.ndarray) else length.real
    times = max(0, math.ceil(math.log2(longest / _LONGEST)))  # doubled, to be at most that long
    eta = length / 2 ** (times + 1)
    square = eta * eta
    even, odd = (_share(value, part, square) for value, part in modes(degree))
    ground, both = eta * (1 - even / 2), 1 / eta + eta * (1 / 3 - odd / 2)
    found = Network(ground, (both - ground) / 2, ground)
    for _ in range(times):
        found = found.then(found)
    return found


@functools.lru_cache(maxsize=16)
def endless(degree: int) -> float:
    """What the endless surface beside a line pulls, over its displacement.

    Far from the line it is eliminated exactly: it acts on the elements' last node with the force u.
    """
    return float(piece(degree, _COVERED).then(Network(1.0, 0.0, 0.0)).left)


class Line:
    """The networks of a line contact, on elements of one degree."""

    def __init__(self, degree: int) -> None:
        self.degree = degree

    def measure(self, s: Any) -> Any:
        """Length of a contact line at s."""
        return 1.0

    def alone(self, side: int, s: Any) -> Any:
        """What an endless surface beyond a line pulls, over its displacement."""
        return endless(self.degree)

    def between(self, side: Any, s: Any, width: Any) -> Network:
        """From a line at s to another one, this much further to a side; the left end first."""
        apart = Network(endless(self.degree), 0.0, endless(self.degree))
        if not isinstance(width, np.ndarray):
            return apart if width.real > FAR else self._gap(width)
        near = self._gap(np.minimum(width, FAR))
        return Network(*(np.where(width > FAR, *both) for both in zip(apart, near, strict=True)))

    def _gap(self, width: Any) -> Network:
        """Of lines that feel each other."""
        half = piece(self.degree, width / 2)
        return half.then(half)

    def beyond(self, side: int, s: float, distance: Array) -> tuple[Array, Array]:
        """u and u' outwards of an endless surface, displaced by 1 there: its exact decay."""
        left = np.exp(-distance)
        return left, -left

    def shape(self, q: float, width: float, x: Array, u: float, rise: float) -> tuple[Array, Array]:
        """u and u' between lines displaced by u and u + rise: their exact decays,

        u cosh(x - L/2)/cosh(L/2) + rise sinh(x)/sinh(L) at distances x from the left line.
        """
        one, other = np.exp(-x), np.exp(x - width)
        both, odd = 1 + math.exp(-width), -math.expm1(-2 * width)
        grown, steep = other * -np.expm1(-2 * x) / odd, other * (1 + one * one) / odd
        return u * (one + other) / both + rise * grown, u * (other - one) / both + rise * steep
