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
from discretization.fitted.spectral import polynomials, rounded

Array = NDArray[np.float64]
DEGREE = 16  # of u and x in τ, which it resolves to rounding on elements of these ends:
_ENDS = np.array([0.0, 1.0, 2.5, 5.0, 9.0, 14.0, 21.0])  # from either line up to the middle
FAR = 40.0  # lines further apart are independent: exp(-FAR) is below rounding
UPRIGHT = 2e-8  # of the greatest p: so close to turning over no double resolves it
_STEEPEST = (OVERHANG * (1 - UPRIGHT)) ** 2
_CLOSE = 1e-10  # of T: the step of Newton's method after which the error, its square, is rounding
_INSIDE = 1e-15  # of an element: the same for a place in it
_STEPS = 80
_POLISH = 3  # steps of Newton's method from what minimises F to rounding already
_INVERSE = 8


class Mesh(NamedTuple):
    """A range of τ, mirror-symmetric: nodes and weights (nodes,), half the elements; over T."""

    nodes: Array
    weights: Array
    half: Array


def _mesh(T: float) -> Mesh:
    """The mesh of ranges up to T."""
    return _meshes(min(int(np.searchsorted(_ENDS, T / 2)), _ENDS.size - 1))


@functools.lru_cache(maxsize=8)
def _meshes(count: int) -> Mesh:
    """So many elements on either side of the middle."""
    points, weights, _ = rounded(DEGREE)
    ends = _ENDS[: count + 1] / (2 * _ENDS[count])
    half = np.diff(ends)[:, None] / 2
    near, weight = (ends[:-1, None] + half * (points + 1)).ravel(), (half * weights).ravel()
    return Mesh(
        np.concatenate([near, 1 - near[::-1]]),
        np.concatenate([weight, weight[::-1]]),
        np.concatenate([half[:, 0], half[::-1, 0]]),
    )


def _rate(p: Any) -> tuple[Any, Any]:
    """h(p) and h'(p)."""
    square = np.minimum(p * p, _STEEPEST)
    root = np.sqrt(1 - square / 4)
    change = p * (square / 8 - 0.75) / root**3
    if square.max() == _STEEPEST:
        change = np.where(square < _STEEPEST, change, 0.0)
    return (1 - square / 2) / root, change


Ends = Callable[[Array], tuple[Array, Array, Array, Array]]


def _range(length: Array, rise: Array, ends: Ends) -> Array:
    """T with x(T) = L, by Newton's method between bounds.

    ends: p at both lines, and A, B of ∂p/∂T = A sinh τ/sinh T + B cosh τ/sinh T.
    """
    near = np.minimum(length, 1.0)
    chord = 2 * np.sin(np.arctan(np.minimum(np.abs(rise) / near, 3.0)) / 2)
    T = length + near * (1 / _rate(chord)[0] - 1)
    low, high = length, np.full_like(length, math.inf)
    for _ in range(_STEPS):
        mesh = _mesh(float(T.max()))
        tau, (start, end, a, b) = T[:, None] * mesh.nodes, ends(T)
        grown = np.sinh(tau) / np.sinh(T)[:, None]
        p = start[:, None] * grown[:, ::-1] + end[:, None] * grown
        h, h1 = _rate(p)
        change = a * ((h1 * grown) @ mesh.weights)
        if b.any():
            change = change + b * ((h1 * np.cosh(tau)) @ mesh.weights) / np.sinh(T)
        off, slope = T * (h @ mesh.weights) - length, h[:, -1] + T * change
        low, high = np.where(off < 0, T, low), np.where(off < 0, high, T)
        step = off / np.where(slope > 0, slope, 1e-300)
        new, still = T - step, np.abs(step) <= _CLOSE * slope * T
        halved = np.where(np.isinf(high), 2 * T, (low + high) / 2)
        T = np.where(still | ((new >= low) & (new <= high)), new, halved)
        if still.all():
            break
    return T


def rest_displacement(p: Any, rise: Any, length: Any) -> Any:
    """u at a line with this p outwards, where the other line is displaced by `rise` more.

    Numbers or arrays; length: of the gap.
    """
    apart = np.minimum(length, FAR) + 0 * rise
    own, rise, length = np.broadcast_arrays(*np.atleast_1d(p, rise, apart))

    def ends(T: Array) -> tuple[Array, Array, Array, Array]:
        coth, u = 1 / np.tanh(T / 2), _displaced(own, rise, T)
        change = -rise / (2 * np.sinh(T / 2) ** 2) - u - rise
        return own, rise * coth - own, change, np.zeros_like(T)

    u = _displaced(own, rise, _range(length, rise, ends))
    shape = np.broadcast_shapes(np.shape(p), np.shape(apart))
    return u.reshape(shape) if shape else float(u[0])


def _displaced(p: Array, rise: Array, T: Array) -> Array:
    """u at a line with this p."""
    return np.asarray((rise / np.sinh(T) - p) / np.tanh(T / 2))


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
        return bool((self.h <= 2 * UPRIGHT).any())

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
        places, rises, rates = (self._elements(of)[0] for of in (self.x, self.rises, self.h))
        e = np.clip(np.searchsorted(places[1:, 0], x, side="right"), 0, self.half.size - 1)
        half, nodes = self.half[e], places[e]
        start, width = nodes[:, 0], nodes[:, -1] - nodes[:, 0]
        t = np.clip(2 * (x - start) / width - 1, -1, 1)
        for _ in range(_INVERSE):
            step = (polynomials(DEGREE, t, nodes) - x) / (half * polynomials(DEGREE, t, rates[e]))
            t = np.clip(t - step, -1, 1)
            if (np.abs(step) <= _INSIDE).all():
                break
        u1 = rises[e] @ rounded(DEGREE)[2].T / half[:, None]
        slope = polynomials(DEGREE, t, u1) / polynomials(DEGREE, t, rates[e])
        return self.left + polynomials(DEGREE, t, rises[e]).reshape(shape), slope.reshape(shape)

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
    length, rises = min(length, FAR), np.array([rise])

    def ends(T: Array) -> tuple[Array, Array, Array, Array]:
        steep, tanh = rise / np.sinh(T), np.tanh(T / 2)
        start, end = steep - left * tanh, steep + (left + rise) * tanh
        return start, end, np.zeros_like(T), -end

    T = _range(np.array([length]), rises, ends)
    mesh, (start, end, *_), T = _mesh(float(T[0])), ends(T), T[0]
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
