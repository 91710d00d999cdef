"""Free surfaces of line contacts with finite slopes, on a mesh anchored at their lines.

D = f + u of the tail or of the gap that is inclined by φ = β - 2 asin √(w/(2γ₁)) at its line,
tan β = f'. Of a tail p = 2 sin(φ/2) is its displacement. A gap stores

    F(u_a, u_b; L) = min over u, u(0) = u_a, u(L) = u_b, of ∫₀^L (k/2 u² + γ₁ (√(1+u'²) - 1)) dx.

In units of l and γ₁, k = γ₁ = l = 1, the elements are laid out in the coordinate τ in which the
surface is a sum of two exponentials (finite_range.py). That grades them towards steep lines, and u
and x are smooth functions of τ however steep the surface is. The discrete energy is that of the
nodal u at the nodes' fixed x, by the Gauss-Lobatto rule in τ, convex in u:

    F = Σ_i w_i [h_i u_i²/2 + √(h_i² + (du/dτ)_i²) - h_i],    h = dx/dτ.

The exponentials minimise F to rounding, which `residual` measures. As ∂F/∂h_i of the minimum is
u²/2 + cos φ - 1, the same at every node, that is also ∂F/∂L.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from discretization.surfaces.finite_range import (
    DEGREE,
    FAR,
    OVERHANG,
    STEEPEST,
    UPRIGHT,
    Lines,
    Mesh,
    mesh_of,
    range_of,
    rate,
    rest_displacement,
)
from discretization.surfaces.protocol import MET, At, Free, alone
from discretization.surfaces.spectral import coefficients, rounded
from energy import Scene

Array = NDArray[np.float64]
_INSIDE = 1e-8  # of an element: a step to a place in it after which the error is rounding
_INVERSE = 8  # steps of Newton's method, from a place in the right element


@dataclass(frozen=True, eq=False)
class FiniteGap:
    """A free surface between two lines.

    half (elements, 1): half the elements in τ; x, p, rises (elements, nodes): places of the nodes,
    p = 2 sin(φ/2) = du/dτ there, and u - left, which a short gap would not leave digits of; left: u
    at the left line.
    """

    half: Array
    x: Array
    p: Array
    left: float
    rises: Array

    @property
    def upright(self) -> bool:
        """Whether the surface turns over."""
        return bool((rate(self.p)[0] <= 3 * UPRIGHT).any())

    @property
    def reactions(self) -> tuple[float, float]:
        """S = ∂F/∂u at both lines."""
        return -float(sine(self.p[0, 0])), float(sine(self.p[-1, -1]))

    @property
    def energy(self) -> float:
        """F."""
        return float(np.sum(self._weights * _density(self.left + self.rises, self.p)))

    @property
    def area(self) -> float:
        """∫u dx."""
        return float(np.sum(self._weights * rate(self.p)[0] * (self.left + self.rises)))

    @property
    def _weights(self) -> Array:
        """Of the nodes of every element (elements, nodes)."""
        return np.asarray(self.half * rounded(DEGREE)[1])

    @property
    def residual(self) -> float:
        """How far the nodal energy is from its least, over u and S.

        The imbalance of a free node, of a reaction, of the constancy of u²/2 + cos φ.
        """
        d, h, u = rounded(DEGREE)[2], rate(self.p)[0], self.left + self.rises
        inclined = self.rises @ d.T / self.half
        pull = self._weights * inclined / np.sqrt(h * h + inclined * inclined) / self.half
        pull = self._weights * h * u + pull @ d
        (s, t), v, rise = self.reactions, float(u[-1, -1]), float(self.rises[-1, -1])
        size = abs(self.left) + abs(v) + abs(s) + abs(t) or 1.0
        apart = -rise * (self.left + v) / 2 + (t - s) * (t + s) / (_cos(s) + _cos(t))
        ends = np.array([pull[0, 0] - s, pull[-1, -1] - t, apart / size])
        off = np.concatenate([pull[:, 1:-1].ravel(), pull[:-1, -1] + pull[1:, 0], ends])
        return float(np.abs(off).max()) / size

    def at(self, p: Array, q: Array) -> tuple[Array, Array]:
        """u and u' at distances p from the left and q from the right line (n,), apart or further.

        Where they are further apart than here, the nearer one counts.
        """
        starts, ends, half = self.x[:, 0], self.x[:, -1], self.x[-1, -1] / 2
        x = np.where(p <= q, np.minimum(p, half), 2 * half - np.minimum(q, half))
        e = np.searchsorted(starts[1:], x, side="right")
        places, rates, rises, steeps = self._series[:, e]
        t = np.clip(2 * (x - starts[e]) / (ends[e] - starts[e]) - 1, -1, 1)
        for _ in range(_INVERSE):
            basis = legendre.legvander(t, DEGREE)
            off, h = (places * basis).sum(axis=1) - x, (rates * basis).sum(axis=1)
            step = off / (self.half[e, 0] * h)
            t = np.clip(t - step, -1, 1)
            if (np.abs(step) <= _INSIDE).all():
                break
        h, u, u1 = (np.array([rates, rises, steeps]) * legendre.legvander(t, DEGREE)).sum(axis=2)
        return self.left + u, u1 / h

    @functools.cached_property
    def _series(self) -> Array:
        """Legendre coefficients (4, elements, degree + 1) of x, h, u - left and du/dτ."""
        return coefficients(DEGREE, np.array([self.x, rate(self.p)[0], self.rises, self.p]))


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
    T, _, p, rises = _exponentials(*(np.full((1, 1), part) for part in (left, rise, length)))
    return _laid(float(T[0, 0]), left, p[0], rises[0])


@functools.lru_cache(maxsize=256)
def tail(u0: float) -> FiniteGap:
    """The surface beside a line displaced by u₀, as one to a line so far away that it is flat."""
    tau = FAR * mesh_of(FAR).nodes
    return _laid(FAR, u0, -u0 * np.exp(-tau), u0 * np.expm1(-tau))


def _laid(T: float, left: float, p: Array, rises: Array) -> FiniteGap:
    """The surface of a range T on its mesh."""
    half = T * mesh_of(T).half[:, None]
    p, rises = (part.reshape(half.size, -1) for part in (p, rises))
    x = half * (rate(p)[0] @ _integrals().T)
    x[1:] += np.cumsum(x[:-1, -1:], axis=0)
    return FiniteGap(half, x, p, left, rises)


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
    T, mesh, p, rises = _exponentials(left, rise, np.minimum(length, FAR))
    sines = sine(p[:, [0, -1]])
    return T[:, 0] * (_density(left + rises, p) @ mesh.weights), sines[:, 1] - sines[:, 0]


def _exponentials(left: Array, rise: Array, length: Array) -> tuple[Array, Mesh, Array, Array]:
    """The ranges T of surfaces displaced by `left` and `left + rise` (n, 1), and their mesh.

    And p and u - left at its nodes.
    """

    def ends(T: Array) -> Lines:
        steep, tanh = rise / np.sinh(T), np.tanh(T / 2)
        end = steep + (left + rise) * tanh
        return Lines(steep - left * tanh, end, left, -end)

    T = range_of(length, ends)
    mesh, (start, end, *_) = mesh_of(float(T.max())), ends(T)
    tau = T * mesh.nodes
    grown = np.sinh(tau) / np.sinh(T)
    back = np.sinh(tau / 2) * np.sinh(tau[:, ::-1] / 2) / np.cosh(T / 2)
    return T, mesh, start * grown[:, ::-1] + end * grown, rise * grown - 2 * left * back


@functools.lru_cache(maxsize=1)
def _integrals() -> Array:
    """Integrals from the first node to each, of the polynomial with given values at the nodes."""
    points = rounded(DEGREE)[0]
    values = legendre.legvander(points, DEGREE)
    integrals = legendre.legval(points, legendre.legint(np.eye(DEGREE + 1), lbnd=-1, axis=0)).T
    return np.asarray(integrals @ np.linalg.inv(values))


@dataclass(frozen=True, eq=False)
class FiniteSurfaces:
    """Free surfaces of a scene."""

    scene: Scene

    def rest_depth(self, side: Any, x: Any, f: Any, f1: Any, facing: At | None, w: Any) -> Any:
        """D: the inclination at rest is known, and the displacement that has it is solved for.

        Where a gap would turn over its inclination is cut at ±π/2; a tail is refused if its line is
        at rest there.
        """
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        phi = np.arctan(side * f1) - 2 * np.arcsin(np.sqrt(w / (2 * gamma1)))
        if facing is None:
            return f + 2 * length * np.sin(phi / 2)
        phi = np.maximum(phi, -math.pi / 2)
        apart, rise = np.maximum(side * (facing.x - x) / length, MET), (f - facing.f) / length
        return f + length * rest_displacement(-2 * np.sin(phi / 2), rise, apart)

    def _found(self, left: At | None, right: At | None, depth: float) -> FiniteGap:
        """The surface beyond or between lines, at most upright; of a tail from its line on."""
        length = self.scene.elastocapillary_length
        u = (depth - alone(left, right).f) / length
        if left is None or right is None:
            return tail(min(max(u, -STEEPEST), STEEPEST))
        return solved(u, (left.f - right.f) / length, (right.x - left.x) / length)

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """As the exponentials have it."""
        if left is None and right is None:
            return np.zeros_like(z), np.zeros_like(z)
        length, side = self.scene.elastocapillary_length, -1 if left is None else 1
        p = side * (np.ravel(z) - alone(left, right).x) / length
        q = np.maximum(FAR - p, 0.0)
        if left is not None and right is not None:
            q = (right.x - np.ravel(z)) / length
        u, slope = self._found(left, right, depth).at(p, q)
        return length * u.reshape(np.shape(z)), side * slope.reshape(np.shape(z))

    def stored(self, left: At | None, right: At | None, depth: Array) -> tuple[Array, Array]:
        """F and S of tails and of gaps. ValueError if a tail would turn over."""
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        u = (depth - alone(left, right).f) / length
        if left is not None and right is not None:
            energy, pull = stored(u, (left.f - right.f) / length, (right.x - left.x) / length)
        elif np.max(np.abs(u), initial=0.0) < OVERHANG:
            energy, pull = tails(u)
        else:
            raise ValueError(self._overhang(depth, left, right))
        return gamma1 * length * energy, gamma1 * pull

    def free(self, left: At | None, right: At | None, depth: float) -> Free:
        """One free surface."""
        length, gamma1 = self.scene.elastocapillary_length, self.scene.gamma1
        found = self._found(left, right, depth)
        if found.upright:
            raise ValueError(self._overhang(depth, left, right))
        one, other = (gamma1 * pull for pull in found.reactions)
        if left is None or right is None:
            one, other = (one, 0.0) if right is None else (0.0, one)
        return Free(
            gamma1 * length * found.energy, (one, other), gamma1 * found.area, found.residual
        )

    def _overhang(self, depth: Any, left: At | None, right: At | None) -> str:
        line, limit = alone(left, right), OVERHANG * self.scene.elastocapillary_length
        place = f"at the contact line x = {line.x!r}"
        if left is not None and right is not None:
            place = f"between the contact lines x = {left.x!r} and {right.x!r}"
        return (
            f"depth = {depth!r}: {place} the surface, displaced by {depth - line.f!r}, would turn "
            f"over and be no graph u(x), as it does at √2 l = {limit!r} beside a single contact; "
            "use a smaller |depth|, a smaller w or a blunter indenter"
        )
