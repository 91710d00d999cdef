"""The range of the arc-like coordinate τ in which gaps with finite slopes are linear.

In units of l and γ₁ the surface between two lines L apart solves (sin φ)' = u with tan φ = u'. In
p = 2 sin(φ/2) and dτ = cos(φ/2) ds, s the arc length, this is the linear problem of small slopes,
and only x is not: du/dτ = p and dp/dτ = u, so u is a sum of two exponentials, and

    dx/dτ = h(p) = (1 - p²/2)/√(1 - p²/4).

So a gap has one unknown, its range T of τ, for which x(T) = L.

Only one mean displacement has a given inclination φ at a line, at a given rise u_b - u_a: with it
grows v = ∂u, (cos³φ v')' = v, v = 1 at both lines and 0 < v < 1 between (maximum principle), so
that v' < 0 outwards of a line, and its reaction grows. Hence T is unique as well. A surface that
would turn over, p² > 2, is followed as if it were upright there: at its line it is cut at p² = 2,
as its least energy among functions that may jump is. Lines more than 40 l apart do not feel each
other.
"""

from __future__ import annotations

import bisect
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.spectral import rounded

Array = NDArray[np.float64]
DEGREE = 16  # of u and x in τ, which it resolves to rounding on elements of these ends:
_ENDS = (0.0, 0.4, 1.0, 2.5, 5.0, 9.0, 14.0, 21.0)  # from either line up to the middle
FAR = 40.0  # lines further apart are independent: exp(-FAR) is below rounding
OVERHANG = math.sqrt(2)  # l: displacement at which a tail is upright
UPRIGHT = 2e-8  # of the greatest p: so close to turning over no double resolves it
STEEPEST = OVERHANG * (1 - UPRIGHT)  # p, and the displacement of a tail, at most
_MOST = STEEPEST**2
_LEAST = 1e-8  # of dx/dT: what keeps Newton's method going where x does not grow
_CLOSE = 2e-16  # of T: a step cubed over the one before squared, which is about what is left
_STEPS = 80  # of halving, to the spacing of floating-point numbers


class Mesh(NamedTuple):
    """A range of τ, mirror-symmetric: nodes and weights (nodes,), half the elements; over T."""

    nodes: Array
    weights: Array
    half: Array


def mesh_of(T: float) -> Mesh:
    """The mesh of ranges up to T: one element, or several on either side of the middle."""
    return _meshes(bisect.bisect_left(_ENDS, T / 2, hi=len(_ENDS) - 1) if T > 1 else 0)


@functools.lru_cache(maxsize=8)
def _meshes(count: int) -> Mesh:
    points, weights, _ = rounded(DEGREE)
    ends = np.array(_ENDS[: count + 1]) / (2 * _ENDS[count] or 1.0)
    ends = np.concatenate([ends, 1 - ends[-2::-1]]) if count else np.array([0.0, 1.0])
    half = np.diff(ends) / 2
    nodes = ends[:-1, None] + half[:, None] * (points + 1)
    return Mesh(nodes.ravel(), (half[:, None] * weights).ravel(), half)


def rate(p: Any) -> tuple[Any, Any]:
    """h(p) and h'(p)."""
    square = p * p
    top = square.max()
    if top > _MOST:
        square = np.minimum(square, _MOST)
    root = np.sqrt(1 - square / 4)
    change = p * (square / 8 - 0.75) / (root * root * root)
    if top > _MOST:
        change = np.where(square < _MOST, change, 0.0)
    return (1 - square / 2) / root, change


class Lines(NamedTuple):
    """p at both lines of ranges T, and A or B of ∂p/∂T = A sinh τ/sinh T or B cosh τ/sinh T."""

    start: Array
    end: Array
    a: Array
    b: Array | None = None


Ends = Callable[[Array], Lines]


def _crossed(T: Array, lines: Lines) -> tuple[Array, Array]:
    """x(T) and its derivative."""
    mesh, whole = mesh_of(float(T.max())), np.sinh(T)
    weights, tau = mesh.weights[:, None], T * mesh.nodes
    grown = np.sinh(tau) / whole
    h, h1 = rate(lines.start * grown[:, ::-1] + lines.end * grown)
    if lines.b is None:
        change = lines.a * ((h1 * grown) @ weights)
    else:
        change = lines.b * ((h1 * np.cosh(tau)) @ weights) / whole
    return T * (h @ weights), h[:, -1:] + T * change


def range_of(length: Array, ends: Ends) -> Array:
    """T with x(T) = L (n, 1), by Newton's method between bounds from x ≈ T - 3/8 ∫p² dτ, L <= T."""
    (start, end, *_), whole, cosh = ends(length), np.sinh(length), np.cosh(length)
    square = (start * start + end * end) * (cosh - length / whole) / whole / 2
    square = square + start * end * (length * cosh / whole - 1) / whole
    T = length + np.clip(0.375 * square, 0.0, length)
    low, high, before = length, np.full_like(length, math.inf), np.zeros_like(length)
    for _ in range(_STEPS):
        x, slope = _crossed(T, ends(T))
        low, high = np.where(x < length, T, low), np.where(x < length, high, T)
        step = (x - length) / np.maximum(slope, _LEAST)
        new, still = T - step, np.abs(step) ** 3 <= _CLOSE * slope * T * before * before
        still |= (np.abs(step) * slope <= 2 * _CLOSE * T) | (high - low <= _CLOSE * T)
        most = np.minimum(high, 2 * T + 1)
        halved = np.where(most < high, most, (low + high) / 2)
        T = np.where(still | ((new > low) & (new < most)), new, halved)
        if still.all():
            break
        before = np.abs(step)
    return T


def rest_displacement(p: Any, rise: Any, length: Any) -> Any:
    """u at a line with this p outwards, where the other line is displaced by `rise` more.

    Numbers or arrays (n,); length: of the gap.
    """
    one = not (np.ndim(p) or np.ndim(rise) or np.ndim(length))
    p, rise, length = (np.reshape(part, (-1, 1)) for part in (p, rise, length))
    length = np.minimum(length, FAR) + 0 * (p + rise)

    def far_end(T: Array) -> Array:
        """p there, at most upright: a surface that would turn over falls short of the line."""
        return np.clip(rise / np.tanh(T / 2) - p, -STEEPEST, STEEPEST)

    def ends(T: Array) -> Lines:
        end, half = far_end(T), np.sinh(T / 2)
        u = (end * np.cosh(T) - p) / np.sinh(T)
        return Lines(p, end, -u - (np.abs(end) < STEEPEST) * rise / (2 * half * half))

    T = range_of(length, ends)
    u = (far_end(T) - p * np.cosh(T)) / np.sinh(T)
    return float(u[0, 0]) if one else u[:, 0]
