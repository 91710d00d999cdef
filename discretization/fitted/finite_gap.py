"""The free surface between two contacts with finite slopes, on a mesh anchored at both lines.

    F(u_a, u_b; L) = min over u, u(0) = u_a, u(L) = u_b, of ∫₀^L (k/2 u² + γ₁ (√(1+u'²) - 1)) dx

in units of l and γ₁: k = γ₁ = l = 1. F is convex in u, and its minimum solves (sin φ)' = u with
tan φ = u'. In p = 2 sin(φ/2) and dτ = cos(φ/2) ds, s the arc length, this is the linear problem of
small slopes, and only x is not: du/dτ = p and dp/dτ = u, so u is a sum of two exponentials, and

    dx/dτ = h(p) = (1 - p²/2)/√(1 - p²/4).

So a gap has one unknown, its range T of τ, for which x(T) = L. The elements are laid out in τ: that
grades them towards steep lines, and u and x are smooth functions of τ however steep the surface is.
The discrete energy is that of the nodal u at the nodes' fixed x, by the Gauss-Lobatto rule in τ,

    F = Σ_i w_i [h_i u_i²/2 + √(h_i² + (du/dτ)_i²) - h_i].

What searches for lines reads the exponentials (`rest_displacement`, `solved`), which minimise F to
rounding; the `relaxed` surface does minimise it and has its reactions S = ∂F/∂u. As ∂F/∂h_i of the
minimum is u²/2 + cos φ - 1, the same at every node, that is also ∂F/∂L.

Only one mean displacement has a given inclination φ < 0 outwards of a line, at a given rise
u_b - u_a: with it grows v = ∂u, (cos³φ v')' = v, v = 1 at both lines and 0 < v < 1 between
(maximum principle), so that v' < 0 outwards of a line, and S grows. Hence T is unique as well.
A surface that would turn over, p² > 2, is followed as if it were upright there: x does not grow.
Lines more than 40 l apart do not feel each other.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from discretization.fitted.free_surface import OVERHANG
from discretization.fitted.spectral import coefficients, rounded

Array = NDArray[np.float64]
DEGREE = 16  # of u and x in τ, which it resolves to rounding on elements of these ends:
_ENDS = np.array([0.0, 1.0, 2.5, 5.0, 9.0, 14.0, 21.0])  # from either line up to the middle
FAR = 40.0  # lines further apart are independent: exp(-FAR) is below rounding
UPRIGHT = 2e-8  # of the greatest p: so close to turning over no double resolves it
_STEEPEST = (OVERHANG * (1 - UPRIGHT)) ** 2
_MILD = 0.1  # of dx/dT: surfaces that are found without bounds
_CLOSE = 1e-16  # of T: a step cubed over the one before squared, which is about what is left
_INSIDE = 1e-8  # of an element: the same for a place in it
_STEPS = 80
_POLISH = 3  # steps of Newton's method from what minimises F to rounding already
_INVERSE = 8


class Mesh(NamedTuple):
    """A range of τ, mirror-symmetric: nodes and weights (nodes,), half the elements; over T."""

    nodes: Array
    weights: Array
    half: Array


def _mesh(T: float) -> Mesh:
    """The mesh of ranges up to T: one element, or several on either side of the middle."""
    return _meshes(int(np.searchsorted(_ENDS[:-1], T / 2)) if T > _ENDS[1] else 0)


@functools.lru_cache(maxsize=8)
def _meshes(count: int) -> Mesh:
    points, weights, _ = rounded(DEGREE)
    ends = _ENDS[: count + 1] / (2 * _ENDS[count] or 1.0)
    ends = np.concatenate([ends, 1 - ends[-2::-1]]) if count else np.array([0.0, 1.0])
    half = np.diff(ends) / 2
    nodes = ends[:-1, None] + half[:, None] * (points + 1)
    return Mesh(nodes.ravel(), (half[:, None] * weights).ravel(), half)


def _rate(p: Any) -> tuple[Any, Any]:
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


def _functions(T: Any) -> Any:
    """sinh and tanh of a number or an array."""
    return np if isinstance(T, np.ndarray) else math


def _crossed(T: Any, lines: Lines) -> tuple[Any, Any]:
    """x(T) and its derivative, for a number or an array (n, 1)."""
    many, whole = isinstance(T, np.ndarray), _functions(T).sinh(T)
    mesh = _mesh(float(T.max()) if many else T)
    weights = mesh.weights[:, None] if many else mesh.weights
    tau = T * mesh.nodes
    grown = np.sinh(tau) / whole
    h, h1 = _rate(lines.start * grown[..., ::-1] + lines.end * grown)
    if lines.b is None:
        change = lines.a * ((h1 * grown) @ weights)
    else:
        change = lines.b * ((h1 * np.cosh(tau)) @ weights) / whole
    return T * (h @ weights), (h[..., -1:] if many else h[-1]) + T * change


def _range(length: Any, ends: Ends) -> Any:
    """T with x(T) = L, by Newton's method from x ≈ T - 3/8 ∫p² dτ; numbers or arrays (n, 1)."""
    (start, end, *_), lib = ends(length), _functions(length)
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
        T, small = T - step, abs(step) ** 3 <= _CLOSE * T * before * before
        if small:
            return T
        before = abs(step)
    return float(_bracketed(np.array([[T]]), np.array([[length]]), ends)[0, 0])


def _bracketed(T: Array, length: Array, ends: Ends) -> Array:
    """The same between bounds, L <= T."""
    T, low, high = np.maximum(T, length), length, np.full_like(length, math.inf)
    before = np.zeros_like(length)
    for _ in range(_STEPS):
        x, slope = _crossed(T, ends(T))
        low, high = np.where(x < length, T, low), np.where(x < length, high, T)
        step = (x - length) / np.where(slope > 0, slope, 1e-300)
        new, still = T - step, np.abs(step) ** 3 <= _CLOSE * slope * T * before * before
        halved = np.where(np.isinf(high), 2 * T, (low + high) / 2)
        T = np.where(still | ((new >= low) & (new <= high)), new, halved)
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
        lib = _functions(T)
        coth, half = 1 / lib.tanh(T / 2), lib.sinh(T / 2)
        change = -rise / (2 * half * half) - _displaced(p, rise, T) - rise
        return Lines(p, rise * coth - p, change)

    u = _displaced(p, rise, _range(length, ends))
    return u[:, 0] if many else float(u)


def _displaced(p: Any, rise: Any, T: Any) -> Any:
    """u at a line with this p."""
    lib = _functions(T)
    return (rise / lib.sinh(T) - p) / lib.tanh(T / 2)


@dataclass(frozen=True, eq=False)
class FiniteGap:
    """A free surface: its line displacements are u[0] and u[-1].

    length: of the gap, at most FAR; half (elements,): half the elements in τ; x, h (nodes,): places
    of the nodes and dx/dτ there; left: u at the left line; rises (nodes,): u - left, which a short
    gap would not leave digits of; reactions: S = ∂F/∂u at both lines, as read from the exponentials
    or, once relaxed, of the nodal energy.
    """

    length: float
    half: Array
    x: Array
    h: Array
    left: float
    rises: Array
    reactions: tuple[float, float]

    @property
    def upright(self) -> bool:
        """Whether the surface turns over."""
        return bool((self.h <= 3 * UPRIGHT).any())

    @functools.cached_property
    def relaxed(self) -> FiniteGap:
        """The surface whose nodal energy is least, by Newton's method."""
        rises = self.rises.copy()
        for _ in range(_POLISH):
            _, gradient, hessian = self._nodal(rises)
            rises[1:-1] -= np.linalg.solve(hessian[1:-1, 1:-1], gradient[1:-1])
        gradient = self._nodal(rises)[1]
        return replace(self, rises=rises, reactions=(float(gradient[0]), float(gradient[-1])))

    @property
    def apart(self) -> float:
        """How far the relaxed reactions are from those of this surface, over their size and u."""
        size = abs(self.left) + abs(self.left + float(self.rises[-1]))
        size += sum(abs(each) for each in self.reactions)
        off = zip(self.reactions, self.relaxed.reactions, strict=True)
        return max(abs(own - other) for own, other in off) / (size or 1.0)

    @property
    def energy(self) -> float:
        """F."""
        return self._nodal(self.rises)[0]

    @property
    def area(self) -> float:
        """∫u dx."""
        own, h, weight = self._elements(self.rises)
        return float(np.sum(weight * h * (self.left + own)))

    @property
    def residual(self) -> float:
        """Largest imbalance of a free node, of the constancy of u²/2 + cos φ, over u and S."""
        gradient = self._nodal(self.rises)[1]
        rise, (s, t) = float(self.rises[-1]), self.reactions
        u, v = self.left, self.left + rise
        size = abs(u) + abs(v) + abs(s) + abs(t)
        apart = -rise * (u + v) / 2 + (t - s) * (t + s) / (_cos(s) + _cos(t))
        worst = max(float(np.abs(gradient[1:-1]).max()), abs(apart) / (size or 1.0))
        return worst / (size or 1.0)

    @property
    def slopes(self) -> tuple[float, float]:
        """u' at both lines, to the right."""
        d = rounded(DEGREE)[2]
        first = float(d[0] @ self.rises[: DEGREE + 1]) / (self.half[0] * self.h[0])
        return first, float(d[-1] @ self.rises[-DEGREE - 1 :]) / (self.half[-1] * self.h[-1])

    def at(self, p: Array, q: Array) -> tuple[Array, Array]:
        """u and u' at distances p from the left and q from the right line."""
        x = np.where(
            p <= q, np.minimum(p, self.length / 2), self.length - np.minimum(q, self.length / 2)
        )
        shape, x = x.shape, x.ravel()
        starts = self.x[:-1:DEGREE]
        e = np.searchsorted(starts[1:], x, side="right")
        places, rates, rises, steeps = self._series[:, e]
        t = np.clip(2 * (x - starts[e]) / (self.x[DEGREE * (e + 1)] - starts[e]) - 1, -1, 1)
        for _ in range(_INVERSE):
            basis = legendre.legvander(t, DEGREE)
            off, h = (places * basis).sum(axis=1) - x, (rates * basis).sum(axis=1)
            step = off / (self.half[e] * h)
            t = np.clip(t - step, -1, 1)
            if (np.abs(step) <= _INSIDE).all():
                break
        h, u, u1 = (np.array([rates, rises, steeps]) * legendre.legvander(t, DEGREE)).sum(axis=2)
        return (self.left + u).reshape(shape), (u1 / h).reshape(shape)

    @functools.cached_property
    def _series(self) -> Array:
        """Legendre coefficients (4, elements, degree + 1) of x, h, u - left and du/dτ."""
        places, rates, rises = (self._elements(of)[0] for of in (self.x, self.h, self.rises))
        steeps = rises @ rounded(DEGREE)[2].T / self.half[:, None]
        return coefficients(DEGREE, np.array([places, rates, rises, steeps]))

    def _elements(self, values: Array) -> tuple[Array, Array, Array]:
        """Nodal values, h and weights of every element (elements, nodes)."""
        index = np.arange(self.half.size)[:, None] * DEGREE + np.arange(DEGREE + 1)
        return values[index], self.h[index], self.half[:, None] * rounded(DEGREE)[1]

    def _nodal(self, rises: Array) -> tuple[float, Array, Array]:
        """F, its gradient and its second derivatives by the nodal u = left + rises."""
        d = rounded(DEGREE)[2] / self.half[:, None, None]
        own, h, weight = self._elements(rises)
        rise, own = np.einsum("eij,ej->ei", d, own), self.left + own
        root = np.sqrt(h * h + rise * rise)
        energy = float(np.sum(weight * (h * own * own / 2 + rise * rise / (root + h))))
        pull = weight * h * own + np.einsum("ei,eij->ej", weight * rise / root, d)
        blocks = np.einsum("eij,ei,eik->ejk", d, weight * h * h / root**3, d)
        blocks += (weight * h)[:, :, None] * np.eye(DEGREE + 1)
        gradient, hessian = np.zeros(rises.size), np.zeros((rises.size, rises.size))
        for e in range(self.half.size):
            own_nodes = slice(e * DEGREE, (e + 1) * DEGREE + 1)
            gradient[own_nodes] += pull[e]
            hessian[own_nodes, own_nodes] += blocks[e]
        return energy, gradient, hessian


def _cos(s: float) -> float:
    """cos φ of sin φ."""
    return math.sqrt(max(1 - s * s, 0.0))


@functools.lru_cache(maxsize=1024)
def solved(left: float, rise: float, length: float) -> FiniteGap:
    """The surface displaced by `left` and `left + rise` at its lines, by its exponentials."""
    length = min(length, FAR)

    def ends(T: Any) -> Lines:
        steep, tanh = rise / _functions(T).sinh(T), _functions(T).tanh(T / 2)
        start, end = steep - left * tanh, steep + (left + rise) * tanh
        return Lines(start, end, None, -end)

    T = _range(length, ends)
    mesh, (start, end, *_) = _mesh(T), ends(T)
    tau, half = T * mesh.nodes, T * mesh.half
    grown = np.sinh(tau) / np.sinh(T)
    p = start * grown[::-1] + end * grown
    rises = rise * grown - 2 * left * np.sinh(tau / 2) * np.sinh(tau[::-1] / 2) / np.cosh(T / 2)
    h = _rate(p)[0]
    steps = half[:, None] * (h.reshape(half.size, -1) @ _integrals().T)
    before = np.concatenate([[0.0], np.cumsum(steps[:, -1])])[:-1]
    x = (before[:, None] + steps).ravel()
    kept = np.append(np.arange(1, p.size) % (DEGREE + 1) != 0, True)  # nodes of two elements once
    sines = p[[0, -1]] * np.sqrt(np.maximum(1 - p[[0, -1]] ** 2 / 4, 0.0))
    reactions = -float(sines[0]), float(sines[1])
    return FiniteGap(length, half, x[kept], h[kept], left, rises[kept], reactions)


@functools.lru_cache(maxsize=1)
def _integrals() -> Array:
    """Integrals from the first node to each, of the polynomial with given values at the nodes."""
    points = rounded(DEGREE)[0]
    values = legendre.legvander(points, DEGREE)
    integrals = legendre.legval(points, legendre.legint(np.eye(DEGREE + 1), lbnd=-1, axis=0)).T
    return np.asarray(integrals @ np.linalg.inv(values))
