"""The free surface between two contacts with finite slopes, on a mesh anchored at both lines.

    F(u_a, u_b; L) = min over u, u(0) = u_a, u(L) = u_b, of ∫₀^L (k/2 u² + γ₁ (√(1+u'²) - 1)) dx

in units of l and γ₁: k = γ₁ = l = 1. The elements are laid out in the coordinate τ in which the
surface is a sum of two exponentials (finite_range.py). That grades them towards steep lines, and u
and x are smooth functions of τ however steep the surface is. The discrete energy is that of the
nodal u at the nodes' fixed x, by the Gauss-Lobatto rule in τ, convex in u:

    F = Σ_i w_i [h_i u_i²/2 + √(h_i² + (du/dτ)_i²) - h_i],    h = dx/dτ.

What searches for lines reads the exponentials, which minimise F to rounding; the `relaxed` surface
does minimise it, and has its reactions S = ∂F/∂u. As ∂F/∂h_i of the minimum is u²/2 + cos φ - 1,
the same at every node, that is also ∂F/∂L.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from discretization.surfaces.finite_range import (
    DEGREE,
    FAR,
    UPRIGHT,
    Lines,
    functions_of,
    mesh_of,
    range_of,
    rate,
)
from discretization.surfaces.spectral import band, coefficients, rounded

Array = NDArray[np.float64]
_INSIDE = 1e-8  # of an element: a step to a place in it after which the error is rounding
_POLISH = 3  # steps of Newton's method, with one Hessian, from what minimises F to rounding
_INVERSE = 8  # steps of Newton's method, from a place in the right element


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
        rises, hessian = self.rises.copy(), self._hessian[:, 1:-1]
        for _ in range(_POLISH):
            off = self._balance(rises)[1:-1]
            rises[1:-1] -= solveh_banded(hessian, off, lower=True, check_finite=False)
        gradient = self._balance(rises)
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
        own, h, weight = self._elements(self.rises)
        rise, own = self._inclined(own), self.left + own
        density = h * own * own / 2 + rise * rise / (np.sqrt(h * h + rise * rise) + h)
        return float(np.sum(weight * density))

    @property
    def area(self) -> float:
        """∫u dx."""
        own, h, weight = self._elements(self.rises)
        return float(np.sum(weight * h * (self.left + own)))

    @property
    def residual(self) -> float:
        """Largest imbalance of a free node, of the constancy of u²/2 + cos φ, over u and S."""
        gradient = self._balance(self.rises)
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

    @property
    def slope(self) -> float:
        """u' at the left line."""
        return self.slopes[0]

    def displacement(self, distance: Array) -> Array:
        """u at distances from the left line."""
        return self.at(distance, np.maximum(self.length - distance, 0.0))[0]

    @functools.cached_property
    def _series(self) -> Array:
        """Legendre coefficients (4, elements, degree + 1) of x, h, u - left and du/dτ."""
        places, rates, rises = (self._elements(of)[0] for of in (self.x, self.h, self.rises))
        steeps = self._inclined(rises)
        return coefficients(DEGREE, np.array([places, rates, rises, steeps]))

    def _elements(self, values: Array) -> tuple[Array, Array, Array]:
        """Nodal values, h and weights of every element (elements, nodes)."""
        index = np.arange(self.half.size)[:, None] * DEGREE + np.arange(DEGREE + 1)
        return values[index], self.h[index], self.half[:, None] * rounded(DEGREE)[1]

    def _inclined(self, own: Array) -> Array:
        """du/dτ at the nodes of every element."""
        return np.asarray(own @ rounded(DEGREE)[2].T / self.half[:, None])

    def _balance(self, rises: Array) -> Array:
        """The gradient of F by the nodal u = left + rises."""
        own, h, weight = self._elements(rises)
        rise, d = self._inclined(own), rounded(DEGREE)[2]
        pull = weight * rise / np.sqrt(h * h + rise * rise) / self.half[:, None]
        pull = weight * h * (self.left + own) + pull @ d
        gradient = np.zeros(rises.size)
        gradient[:-1] = pull[:, :-1].ravel()
        gradient[DEGREE::DEGREE] += pull[:, -1]
        return gradient

    @property
    def _hessian(self) -> Array:
        """That of F by the nodal u, lower banded."""
        own, h, weight = self._elements(self.rises)
        rise, d = self._inclined(own), rounded(DEGREE)[2]
        bend = weight * h * h / np.sqrt(h * h + rise * rise) ** 3 / self.half[:, None] ** 2
        blocks = (d.T * bend[:, None, :]) @ d
        blocks[:, np.arange(DEGREE + 1), np.arange(DEGREE + 1)] += weight * h
        return band(blocks)


def sine(p: Any) -> Any:
    """sin φ of p = 2 sin(φ/2)."""
    return p * np.sqrt(np.maximum(1 - p * p / 4, 0.0))


def _cos(s: float) -> float:
    """cos φ of sin φ."""
    return math.sqrt(max(1 - s * s, 0.0))


@functools.lru_cache(maxsize=1024)
def solved(left: float, rise: float, length: float) -> FiniteGap:
    """The surface displaced by `left` and `left + rise` at its lines, by its exponentials."""
    length = min(length, FAR)
    T = range_of(length, functools.partial(_ends, left, rise))
    return _laid(T, left, *_exponentials(left, rise, T, mesh_of(T).nodes), length)


@functools.lru_cache(maxsize=256)
def tail(u0: float) -> FiniteGap:
    """The surface beside a line displaced by u₀, as one to a line so far away that it is flat."""
    tau = FAR * mesh_of(FAR).nodes
    return _laid(FAR, u0, -u0 * np.exp(-tau), u0 * np.expm1(-tau))


def _laid(T: float, left: float, p: Array, rises: Array, length: float | None = None) -> FiniteGap:
    """The surface of a range T on its mesh; length: where it is known."""
    half, h = T * mesh_of(T).half, rate(p)[0]
    steps = half[:, None] * (h.reshape(half.size, -1) @ _integrals().T)
    before = np.concatenate([[0.0], np.cumsum(steps[:, -1])])[:-1]
    x = (before[:, None] + steps).ravel()
    kept = np.append(np.arange(1, p.size) % (DEGREE + 1) != 0, True)  # nodes of two elements once
    sines = sine(p[[0, -1]])
    reactions = -float(sines[0]), float(sines[1])
    length = float(x[-1]) if length is None else length
    return FiniteGap(length, half, x[kept], h[kept], left, rises[kept], reactions)


def tails(u0: Array) -> tuple[Array, Array]:
    """F and S of tails beside lines displaced by u₀ (n,): p = -u, and both decay with τ."""
    mesh = mesh_of(FAR)
    u = u0[:, None] * np.exp(-FAR * mesh.nodes)
    return FAR * (_density(u, u) @ mesh.weights), sine(u0)


def _density(u: Array, p: Array) -> Array:
    """dF/dτ."""
    h = rate(p)[0]
    return np.asarray(h * u * u / 2 + p * p / (np.sqrt(h * h + p * p) + h))


def stored(left: Array, rise: Array, length: Array) -> tuple[Array, Array]:
    """F and S of both lines together, of surfaces (n,), by their exponentials."""
    left, rise, length = (np.reshape(part, (-1, 1)) for part in (left, rise, length))
    T = range_of(np.minimum(length, FAR), functools.partial(_ends, left, rise))
    mesh = mesh_of(float(T.max()))
    p, rises = _exponentials(left, rise, T, mesh.nodes)
    sines = sine(p[:, [0, -1]])
    return T[:, 0] * (_density(left + rises, p) @ mesh.weights), sines[:, 1] - sines[:, 0]


def _ends(left: Any, rise: Any, T: Any) -> Lines:
    """p at both lines of surfaces displaced by `left` and `left + rise`, of a range T."""
    lib = functions_of(T)
    steep, tanh = rise / lib.sinh(T), lib.tanh(T / 2)
    start, end = steep - left * tanh, steep + (left + rise) * tanh
    return Lines(start, end, None, -end)


def _exponentials(left: Any, rise: Any, T: Any, nodes: Array) -> tuple[Array, Array]:
    """p and u - left at nodes along a range T; numbers or arrays (n, 1)."""
    tau, (start, end, *_) = T * nodes, _ends(left, rise, T)
    grown = np.sinh(tau) / np.sinh(T)
    back = np.sinh(tau / 2) * np.sinh(tau[..., ::-1] / 2) / np.cosh(T / 2)
    return start * grown[..., ::-1] + end * grown, rise * grown - 2 * left * back


@functools.lru_cache(maxsize=1)
def _integrals() -> Array:
    """Integrals from the first node to each, of the polynomial with given values at the nodes."""
    points = rounded(DEGREE)[0]
    values = legendre.legvander(points, DEGREE)
    integrals = legendre.legval(points, legendre.legint(np.eye(DEGREE + 1), lbnd=-1, axis=0)).T
    return np.asarray(integrals @ np.linalg.inv(values))
