"""Free surfaces between two lines with finite slopes, on a mesh anchored at the lines.

In units of l and γ₁ the surface between two lines L apart solves (sin φ)' = u with tan φ = u'. In
p = 2 sin(φ/2) and dτ = cos(φ/2) ds, s the arc length, this is the linear problem of small slopes:
du/dτ = p and dp/dτ = u, so that u is a sum of two exponentials, and only x is not,

    dx/dτ = h(p) = (1 - p²/2)/√(1 - p²/4).

So a gap has one unknown, its range T of τ, for which x(T) = L. The elements are laid out in τ. That
grades them towards steep lines, and u and x are smooth functions of τ however steep the surface is.
The discrete energy is that of the nodal u at fixed x, by the Gauss-Lobatto rule in τ, convex in u:

    F = Σ_i w_i [h_i u_i²/2 + √(h_i² + (du/dτ)_i²) - h_i].

The exponentials minimise F to rounding, which `residual` measures. As ∂F/∂h_i of the minimum is
u²/2 + cos φ - 1, the same at every node, that is also ∂F/∂L.

Only one mean displacement has a given inclination φ at a line, at a given rise u_b - u_a: with it
grows v = ∂u, (cos³φ v')' = v, v = 1 at both lines and 0 < v < 1 between (maximum principle), so
that v' < 0 outwards of a line, and its reaction grows. Hence T is unique as well. A surface that
would turn over, p² > 2, is followed as if it were upright there: at its line it is cut at p² = 2,
as its least energy among functions that may jump is. Lines over 40 l apart do not feel each other.
"""

import bisect
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.roots import crossings
from discretization.surfaces.network import on_elements, rounded
from energy.arrays import Array, Indices

DEGREE = 16  # of u and x in τ, which it resolves to rounding on elements of these ends:
_ENDS = (0.0, 0.4, 1.0, 2.5, 5.0, 9.0, 14.0, 21.0)  # from either line up to the middle
FAR = 40.0  # lines further apart are independent: exp(-FAR) is below rounding
_UPRIGHT = 2e-8  # of the greatest p: so close to turning over no double resolves it
_STEEPEST = math.sqrt(2) * (1 - _UPRIGHT)  # p, and the displacement of a tail, at most
_CLOSE = 8e-16  # of T: what x and L may differ by
_INSIDE = 1e-8  # of τ: a step to a place after which the error is rounding
_INVERSE = 8  # steps of Newton's method to it


class Mesh(NamedTuple):
    """Elements of a range of τ, mirror-symmetric: ends, nodes, weights; over T.

    own: numbers of the nodes of every element (elements, DEGREE + 1).
    """

    ends: Array
    nodes: Array
    weights: Array
    own: Indices


def mesh_of(T: Array) -> Mesh:
    """The mesh of ranges up to the longest: an element, or several on either side of the middle."""
    longest = float(T.max())
    return _meshes(bisect.bisect_left(_ENDS, longest / 2, hi=len(_ENDS) - 1) if longest > 1 else 0)


@functools.lru_cache(maxsize=8)
def _meshes(count: int) -> Mesh:
    points, _, _ = rounded(DEGREE)
    ends = np.array(_ENDS[: count + 1]) / (2 * _ENDS[count] or 1.0)
    ends = np.concatenate([ends, 1 - ends[-2::-1]]) if count else np.array([0.0, 1.0])
    half, first = np.diff(ends)[:, None] / 2, np.arange(ends.size - 1)[:, None] * DEGREE
    own = first + np.arange(DEGREE + 1)
    nodes, weights = np.zeros((2, own[-1, -1] + 1))
    nodes[own] = ends[:-1, None] + half * (points + 1)
    np.add.at(weights, own, half * rounded(DEGREE)[1])
    return Mesh(ends, nodes, weights, own)


def rate(p: Any) -> tuple[Any, Any]:
    """h(p) and h'(p)."""
    square = np.minimum(p * p, _STEEPEST**2)
    root = np.sqrt(1 - square / 4)
    return (1 - square / 2) / root, p * (square / 8 - 0.75) / (root * root * root)


# of gaps with these numbers (k,) and ranges T (k, 1): p at both lines, and ∂p/∂T there at a given τ
Ends = Callable[[Array, Indices], tuple[Array, Array, Any, Array]]


def range_of(length: Array, ends: Ends, steepest: Any) -> Array:
    """T with x(T) = L (n, 1), from T = L on.

    steepest: |p| at both lines is no more from T = 1 on. As 1 - h <= p²/2 and |p| decays by e^-τ
    from either line, L <= T <= L + 1 + 2 ln(steepest).
    """

    def off(T: Array, own: Indices) -> tuple[Array, Array]:
        """(x - L)/T, and dx/dT = h(p_end) + ∫h'(p) ∂p/∂T dτ over T."""
        mesh, (start, end, one, other) = mesh_of(T), ends(T[:, None], own)
        grown = np.sinh(T[:, None] * mesh.nodes) / np.sinh(T[:, None])
        back = grown[:, ::-1]
        h, bend = rate(start * back + end * grown)
        moved = (bend * (one * back + other * grown)) @ mesh.weights
        return h @ mesh.weights - low[own] / T, h[:, -1] / T + moved

    low = length[:, 0]
    return crossings(off, low, low + 1 + 2 * np.log(steepest), low, 1 / low, _CLOSE)[:, None]


def rest_displacement(p: Any, rise: Any, length: Any) -> Any:
    """u at a line with this p outwards, where the other line is displaced by `rise` more.

    Numbers or arrays (n,); length: of the gap.
    """
    one = not (np.ndim(p) or np.ndim(rise) or np.ndim(length))
    p, rise, length = (np.reshape(part, (-1, 1)) for part in (p, rise, length))
    p, rise, length = np.broadcast_arrays(p, rise, np.minimum(length, FAR))

    def ends(T: Array, own: Indices) -> tuple[Array, Array, Any, Array]:
        """At the other line at most upright: what would turn over falls short of it."""
        start, half = p[own], np.tanh(T / 2)
        end = rise[own] / half - start
        free = np.abs(end) < _STEEPEST
        end = np.minimum(np.maximum(end, -_STEEPEST), _STEEPEST)
        u = (end * np.cosh(T) - start) / np.sinh(T)
        return start, end, 0.0, free * rise[own] * (1 - half**-2) / 2 - u

    T = range_of(length, ends, 2.0)
    u = (ends(T, np.arange(len(T)))[1] - p * np.cosh(T)) / np.sinh(T)
    return float(u[0, 0]) if one else u[:, 0]


def sine(p: Any) -> Any:
    """sin φ of p = 2 sin(φ/2)."""
    return p * np.sqrt(np.maximum(1 - p * p / 4, 0.0))


def _ends(left: Array, rise: Array, T: Array) -> tuple[Array, Array, Any, Array]:
    """Of surfaces displaced by `left` and `left + rise` at both lines, as above."""
    sinh, tanh = np.sinh(T), np.tanh(T / 2)
    start, end = rise / sinh - left * tanh, rise / sinh + (left + rise) * tanh
    return start, end, -end / sinh, -end / np.tanh(T)


def _exponentials(left: Array, rise: Array, T: Array, tau: Array) -> tuple[Array, Array]:
    """p and u - left of such surfaces at τ."""
    start, end, *_ = _ends(left, rise, T)
    grown, shrunk = np.sinh(tau) / np.sinh(T), np.sinh(T - tau) / np.sinh(T)
    back = np.sinh(tau / 2) * np.sinh((T - tau) / 2) / np.cosh(T / 2)
    return start * shrunk + end * grown, rise * grown - 2 * left * back


@dataclass(frozen=True, eq=False)
class Gaps:
    """Free surfaces between two lines each.

    T (n, 1): the range of τ; p, u, rises (n, nodes): p = du/dτ, u, and how much more that is
    than at the left line, of which a short gap would not leave digits.
    """

    T: Array
    p: Array
    u: Array
    rises: Array

    @functools.cached_property
    def h(self) -> Array:
        """dx/dτ at the nodes."""
        return np.asarray(rate(self.p)[0])

    @functools.cached_property
    def upright(self) -> bool:
        """Whether a surface turns over."""
        return bool((np.abs(self.p[:, [0, -1]]) >= _STEEPEST * (1 - _UPRIGHT / 16)).any())

    @functools.cached_property
    def pulls(self) -> Array:
        """S = ∂F/∂u at both lines (2, n)."""
        return np.array([-sine(self.p[:, 0]), sine(self.p[:, -1])])

    @functools.cached_property
    def energy(self) -> Array:
        """F (n,)."""
        h, square = self.h, self.p * self.p
        density = h * (self.u * self.u / 2) + square / (np.sqrt(h * h + square) + h)
        return np.asarray(self.T[:, 0] * (density @ mesh_of(self.T).weights))

    @functools.cached_property
    def area(self) -> Array:
        """∫u dx (n,)."""
        return np.asarray(self.T[:, 0] * ((self.h * self.u) @ mesh_of(self.T).weights))

    @functools.cached_property
    def residual(self) -> float:
        """How far the nodal energy of the first surface is from its least, over u and S.

        The imbalance of a node, of a reaction, of the constancy of u²/2 + cos φ.
        """
        (_, weights, d), mesh = rounded(DEGREE), mesh_of(self.T)
        half = self.T[0, 0] * np.diff(mesh.ends)[:, None] / 2
        h, u, rises = self.h[0][mesh.own], self.u[0], self.rises[0]
        inclined = rises[mesh.own] @ d.T
        steep = inclined / np.sqrt(half * half * h * h + inclined * inclined)
        pull = half * weights * h * u[mesh.own] + (weights * steep) @ d
        s, t = self.pulls[:, 0].tolist()
        off = np.append(pull[:, :-1].ravel(), pull[-1, -1] - t)
        off[::DEGREE][:-1] += np.append(-s, pull[:-1, -1])
        cosines = math.sqrt(max(1 - s * s, 0.0)) + math.sqrt(max(1 - t * t, 0.0))
        uneven = -rises[-1] * (u[0] + u[-1]) / 2 + (t - s) * (t + s) / cosines
        size = float(abs(u[0]) + abs(u[-1])) + abs(s) + abs(t) or 1.0
        return max(float(np.abs(off).max()), abs(float(uneven)) / size) / size

    @functools.cached_property
    def places(self) -> Array:
        """x of the nodes of the first one: on an element d x = h."""
        d, mesh = rounded(DEGREE)[2], mesh_of(self.T)
        h = self.T[0, 0] * np.diff(mesh.ends)[:, None] / 2 * self.h[0][mesh.own]
        parts = np.linalg.solve(d[1:, 1:], h[:, 1:].T).T
        starts = np.append(0.0, np.cumsum(parts[:-1, -1]))
        return np.append(0.0, parts + starts[:, None])

    def at(self, p: Array, q: Array) -> tuple[Array, Array]:
        """u and u' of the first one at distances p from the left and q from the right line (n,).

        Where they are further apart than here, the nearer one counts.
        """
        (T,), left, mesh, places = self.T, self.u[0, :1], mesh_of(self.T), self.places
        shape, half = (left, self.rises[0, -1:], T), places[-1] / 2
        x = np.where(p <= q, np.minimum(p, half), 2 * half - np.minimum(q, half))
        tau = np.interp(x, places, T * mesh.nodes)
        for _ in range(_INVERSE):
            off = on_elements(T * mesh.ends, places, tau)[0] - x
            step = off / rate(_exponentials(*shape, tau)[0])[0]
            tau = np.clip(tau - step, 0.0, T)
            if (np.abs(step) <= _INSIDE).all():
                break
        steep, rises = _exponentials(*shape, tau)
        return left + rises, steep / rate(steep)[0]


def surfaces(u: Array, rise: Array, width: Array) -> Gaps:
    """The surfaces displaced by u and u + rise at lines these distances apart, (n, 1).

    One to no other line is one to a line where it is flat, and at most upright.
    """
    if np.isinf(width).all():
        T, u = np.full_like(u, FAR), np.clip(u, -_STEEPEST, _STEEPEST)
        left = u * np.exp(-FAR * mesh_of(T).nodes)
        return Gaps(T, -left, left, left - u)
    u, rise, width = np.broadcast_arrays(u, rise, np.minimum(width, FAR))
    steepest = 1 + np.abs(u[:, 0]) + 2 * np.abs(rise[:, 0])
    T = range_of(width, lambda T, own: _ends(u[own], rise[own], T), steepest)
    p, rises = _exponentials(u, rise, T, T * mesh_of(T).nodes)
    return Gaps(T, p, u + rises, rises)


@functools.lru_cache(maxsize=1024)
def single(u: float, rise: float, width: float) -> Gaps:
    """A single surface."""
    return surfaces(*(np.full((1, 1), part) for part in (u, rise, width)))
