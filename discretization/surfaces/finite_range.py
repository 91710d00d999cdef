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
_UPRIGHT = OVERHANG * (1 - UPRIGHT)
_STEEPEST = _UPRIGHT**2
_MILD = 0.1  # of dx/dT: surfaces that are found without bounds
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
    if top > _STEEPEST:
        square = np.minimum(square, _STEEPEST)
    root = np.sqrt(1 - square / 4)
    change = p * (square / 8 - 0.75) / (root * root * root)
    if top > _STEEPEST:
        change = np.where(square < _STEEPEST, change, 0.0)
    return (1 - square / 2) / root, change


class Lines(NamedTuple):
    """p at both lines of a range T, and A or B of ∂p/∂T = A sinh τ/sinh T or B cosh τ/sinh T."""

    start: Any
    end: Any
    a: Any
    b: Any = None


Ends = Callable[[Any], Lines]


def functions_of(T: Any) -> Any:
    """sinh and tanh of a number or an array."""
    return np if isinstance(T, np.ndarray) else math


def _crossed(T: Any, lines: Lines) -> tuple[Any, Any]:
    """x(T) and its derivative, for a number or an array (n, 1)."""
    many, whole = isinstance(T, np.ndarray), functions_of(T).sinh(T)
    mesh = mesh_of(float(T.max()) if many else T)
    weights = mesh.weights[:, None] if many else mesh.weights
    tau = T * mesh.nodes
    grown = np.sinh(tau) / whole
    h, h1 = rate(lines.start * grown[..., ::-1] + lines.end * grown)
    if lines.b is None:
        change = lines.a * ((h1 * grown) @ weights)
    else:
        change = lines.b * ((h1 * np.cosh(tau)) @ weights) / whole
    return T * (h @ weights), (h[..., -1:] if many else h[-1]) + T * change


def range_of(length: Any, ends: Ends) -> Any:
    """T with x(T) = L, by Newton's method from x ≈ T - 3/8 ∫p² dτ; numbers or arrays (n, 1)."""
    (start, end, *_), lib = ends(length), functions_of(length)
    whole, cosh = lib.sinh(length), lib.cosh(length)
    square = (start * start + end * end) * (cosh - length / whole) / whole / 2
    square = square + start * end * (length * cosh / whole - 1) / whole
    T = length + np.minimum(0.375 * square, length)
    if isinstance(length, np.ndarray):
        return _bracketed(T, length, ends)
    T, before = float(T), 0.0
    for _ in range(_STEPS):
        x, slope = _crossed(T, ends(T))
        step = float((x - length) / slope)
        if not (slope > _MILD and abs(step) < T / 2):
            break
        T, size = T - step, abs(step)
        if size**3 <= _CLOSE * T * before * before or size * slope <= 2 * _CLOSE * T:
            return T
        before = size
    return float(_bracketed(np.array([[T]]), np.array([[length]]), ends)[0, 0])


def _bracketed(T: Array, length: Array, ends: Ends) -> Array:
    """The same between bounds, L <= T."""
    T, low, high = np.maximum(T, length), length, np.full_like(length, math.inf)
    before = np.zeros_like(length)
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
    many = np.ndim(p) or np.ndim(rise) or np.ndim(length)
    if many:
        p, rise, length = (np.reshape(part, (-1, 1)) for part in (p, rise, length))
        length = np.minimum(length, FAR) + 0 * (p + rise)
    else:
        length = min(float(length), FAR)

    def ends(T: Any) -> Lines:
        lib, end = functions_of(T), _far_end(p, rise, T)
        half, mild = lib.sinh(T / 2), abs(end) < _UPRIGHT
        u = (end * lib.cosh(T) - p) / lib.sinh(T)
        return Lines(p, end, -u - mild * rise / (2 * half * half))

    T = range_of(length, ends)
    lib = functions_of(T)
    u = (_far_end(p, rise, T) - p * lib.cosh(T)) / lib.sinh(T)
    return u[:, 0] if many else float(u)


def _far_end(p: Any, rise: Any, T: Any) -> Any:
    """p at the other line, at most upright: a surface that would turn over falls short of it."""
    if isinstance(T, np.ndarray):
        return np.clip(rise / np.tanh(T / 2) - p, -_UPRIGHT, _UPRIGHT)
    return min(max(rise / math.tanh(T / 2) - p, -_UPRIGHT), _UPRIGHT)
