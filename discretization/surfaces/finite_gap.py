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

Only one mean displacement has a given inclination φ at a line, at a given rise u_b - u_a: as both
lines are displaced further by the same, u changes by v with (cos³φ v')' = v, v = 1 at both lines
and 0 < v < 1 between (maximum principle), so that v' < 0 outwards of a line, and its reaction
grows. Hence T is unique as well. A surface that would turn over, p² > 2, is followed as if it were
upright there: at its line it is cut at p² = 2, as its least energy among functions that may jump
is.

Conventions
-----------
u is positive downwards. A gap extends from its left line, displaced by u, at x = τ = 0, to its
right line, displaced by u + rise, at x = L, τ = T. φ and p are positive where u grows towards the
right, at either line. The reaction at a line, ∂F/∂u, the force downwards that holds it, is -sin φ
at the left line and sin φ at the right one. n gaps are rows: parameters of each are columns (n, 1),
nodal values (n, nodes) from the left line to the right one. All gaps of one call share one mesh in
τ/T, that of the longest (`mesh_of`). Callers name the lines first and other instead of left and
right, as a surface and its mirror image are alike. `DECAYED` = 40: e^-40 is less than rounding, so
that lines over 40 l apart do not feel each other, and a tail is a surface of this range.

`gauss_lobatto(degree)` has degree + 1 points on [-1, 1], their weights, and the matrix that
differentiates values there; `on_elements(ends, values, x)` are a function and its slope at x from
nodal values. `newton_crossings(f, low, high, guess, slope, enough)` are zeros of many functions at
once, f(x, numbers) their values and slopes, one zero in each interval, up to |f| = enough.
"""

import bisect
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import DECAYED
from discretization.roots import newton_crossings
from discretization.surfaces.network import gauss_lobatto, on_elements
from energy.arrays import Array, Indices

# Degree of u and x on an element in τ, and the ends of elements from either line up to the middle:
# with these the error is rounding (tests/surfaces/test_free_surface.py). With degree 8 states are
# not certified; 32, and elements half or twice as long, change none of 38 random states (`python -m
# tests.sensitivity discretization.surfaces.finite_gap`).
DEGREE = 16
_ENDS = (0.0, 0.4, 1.0, 2.5, 5.0, 9.0, 14.0, 21.0)


class RangeRules(NamedTuple):
    """How the range T of a gap is divided and found.

    Halved or doubled (`close` and `inside` a tenth or ten times), each leaves the 7 or more random
    states that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.surfaces.finite_gap`.

    Attributes
    ----------
    one_element : float
        Range of τ up to which one element is enough: its errors are rounding
        (tests/surfaces/test_free_surface.py).
    close : float
        Of T: what x(T) and L may differ by, some roundings.
    inside : float
        Of τ: after a step of Newton's method for τ(x) that is this small the error, its square, is
        rounding.
    inverse_steps : int
        Such steps at most; the start, by straight lines between nodes, is close.
    """

    one_element: float = 1.0
    close: float = 8e-16
    inside: float = 1e-8
    inverse_steps: int = 8


_RANGE = RangeRules()


# How close to the greatest p, √2, a surface may come. As h = 0 there, x changes by the square of
# √2 - p, so that its rounding, 2e-16, is 1.5e-8 of p.
_UPRIGHT = 2e-8
_STEEPEST = math.sqrt(2) * (1 - _UPRIGHT)  # p, and the displacement of a tail, at most


class Mesh(NamedTuple):
    """Elements of a range of τ, mirror-symmetric about its middle, in τ/T.

    Attributes
    ----------
    ends : ndarray (e + 1,)
        Ends of the elements, from 0 to 1.
    nodes, weights : ndarray (n,)
        Nodes, increasing from 0 to 1, and their weights in integrals over τ/T.
    own : ndarray of int (e, DEGREE + 1)
        Numbers of the nodes of every element; neighbours share one.
    """

    ends: Array
    nodes: Array
    weights: Array
    own: Indices


def mesh_of(T: Array) -> Mesh:
    """The mesh that serves all ranges T, an array: an element, or several on both sides.

    The longest range decides: its half has as many elements as reach it, and their ends are in the
    ratios of `_ENDS`.
    """
    longest = float(T.max())
    if longest <= _RANGE.one_element:
        return _mesh(0)
    return _mesh(bisect.bisect_left(_ENDS, longest / 2, hi=len(_ENDS) - 1))


# There are no more than 8: one element, or 1 to 7 on either side.
@functools.lru_cache(maxsize=8)
def _mesh(count: int) -> Mesh:
    """The mesh with so many elements on either side of the middle; 0 for one element in all."""
    points, weights_of_rule, _ = gauss_lobatto(DEGREE)
    ends = np.array([0.0, 1.0])
    if count:
        left_half = np.array(_ENDS[: count + 1]) / (2 * _ENDS[count])
        ends = np.concatenate([left_half, 1 - left_half[-2::-1]])
    half = np.diff(ends)[:, None] / 2
    first_nodes = np.arange(ends.size - 1)[:, None] * DEGREE
    own = first_nodes + np.arange(DEGREE + 1)
    nodes = np.zeros(own[-1, -1] + 1)
    weights = np.zeros(own[-1, -1] + 1)
    nodes[own] = ends[:-1, None] + half * (points + 1)
    np.add.at(weights, own, half * weights_of_rule)
    return Mesh(ends, nodes, weights, own)


def rate(p: Any) -> tuple[Any, Any]:
    """dx/dτ = h(p), and h'(p), for any array of p = 2 sin(φ/2); |p| is cut at the steepest.

    h' = p (p²/8 - 3/4)/(1 - p²/4)^(3/2).
    """
    square = np.minimum(p * p, _STEEPEST**2)
    root = np.sqrt(1 - square / 4)
    return (1 - square / 2) / root, p * (square / 8 - 0.75) / (root * root * root)


class PAtLines(NamedTuple):
    """p at both lines of gaps with given ranges T (k, 1), and how p changes with T.

    In between both p(τ; T) and ∂p/∂T at a fixed τ, as solutions of p'' = p, follow from their
    values at τ = 0 and τ = T.

    Attributes
    ----------
    left, right : ndarray (k, 1)
        p at the left and at the right line.
    left_rate, right_rate : float or ndarray (k, 1)
        ∂p/∂T at the fixed places τ = 0 and τ = T. That is the derivative of `left`, but of `right`
        less dp/dτ = u there, by which p at the right line changes as this moves with T.
    """

    left: Array
    right: Array
    left_rate: Any
    right_rate: Array


def range_of(length: Array, ends: Callable[[Array, Indices], PAtLines], steepest: Any) -> Array:
    """The ranges T of τ for which x(T) = L, by Newton's method from T = L on.

    As 1 - h <= p²/2 and |p| decays by e^-τ from either line, L <= T <= L + 1 + 2 ln(steepest).

    Parameters
    ----------
    length : ndarray (n, 1)
        L.
    ends : callable
        ends(T, numbers): p at the lines of the gaps with these numbers (k,), if their ranges are
        T (k, 1).
    steepest : float or ndarray (n,)
        |p| at both lines is at most this from T = 1 on.

    Returns
    -------
    ndarray (n, 1)
    """

    def excess(T: Array, own: Indices) -> tuple[Array, Array]:
        """(x - L)/T of some gaps (k,), and dx/dT = h(p_right) + ∫h'(p) ∂p/∂T dτ, over T.

        Over T, as the tolerance is a part of it. That T divides x, too, does not count in the
        slope: it would add -(x - L)/T², which vanishes at the zero.
        """
        mesh = mesh_of(T)
        p_at = ends(T[:, None], own)
        # Solutions of p'' = p that are 1 at one line and 0 at the other, at the nodes.
        one_at_right = np.sinh(T[:, None] * mesh.nodes) / np.sinh(T[:, None])
        one_at_left = one_at_right[:, ::-1]
        h, h_slope = rate(p_at.left * one_at_left + p_at.right * one_at_right)
        p_rate = p_at.left_rate * one_at_left + p_at.right_rate * one_at_right
        x_over_T = h @ mesh.weights
        return x_over_T - low[own] / T, h[:, -1] / T + (h_slope * p_rate) @ mesh.weights

    low = length[:, 0]
    high = low + 1 + 2 * np.log(steepest)
    return newton_crossings(excess, low, high, low, 1 / low, _RANGE.close)[:, None]


def rest_displacement(p: Any, rise: Any, length: Any) -> Any:
    """Displacement at which a line with a given inclination rests beside a gap.

    The range T fixes p at the other line, by p(0) and the rise: with u = dp/dτ, the rise is
    tanh(T/2) (p(0) + p(T)). T follows from the length of the gap.

    Parameters
    ----------
    p : float or ndarray (n,)
        2 sin(φ/2) at the line, tan φ = du/dx with x from the line into the gap: negative where the
        surface rises away from the line.
    rise : float or ndarray (n,)
        How much more the other line is displaced [l].
    length : float or ndarray (n,)
        Of the gap [l]; infinite for a tail.

    Returns
    -------
    float or ndarray (n,)
        u [l].
    """
    one = not (np.ndim(p) or np.ndim(rise) or np.ndim(length))
    columns = (np.reshape(part, (-1, 1)) for part in (p, rise, length))
    p, rise, length = columns
    p, rise, length = np.broadcast_arrays(p, rise, np.minimum(length, DECAYED))

    def ends(T: Array, own: Indices) -> PAtLines:
        """p at both lines of some gaps; where one would turn over at its other line, it is cut.

        There u = dp/dτ = (p(T) cosh T - p(0))/sinh T, as p'' = p.
        """
        start = p[own]
        tanh = np.tanh(T / 2)
        end = rise[own] / tanh - start
        is_graph = np.abs(end) < _STEEPEST
        end = np.minimum(np.maximum(end, -_STEEPEST), _STEEPEST)
        u_at_end = (end * np.cosh(T) - start) / np.sinh(T)
        end_slope = is_graph * rise[own] * (1 - tanh**-2) / 2  # by T; 0 where it is cut
        return PAtLines(start, end, 0.0, end_slope - u_at_end)

    T = range_of(length, ends, 2.0)  # |p| = 2 |sin(φ/2)| is at most 2 at any inclination
    end = ends(T, np.arange(len(T))).right
    # u = dp/dτ at τ = 0, of p = [p(0) sinh(T - τ) + p(T) sinh τ]/sinh T
    u = (end - p * np.cosh(T)) / np.sinh(T)
    return float(u[0, 0]) if one else u[:, 0]


def sine(p: Any) -> Any:
    """sin φ of p = 2 sin(φ/2)."""
    return p * np.sqrt(np.maximum(1 - p * p / 4, 0.0))


def _ends_of_displaced(u_left: Array, rise: Array, T: Array) -> PAtLines:
    """p at the lines of gaps of which both lines have a given displacement.

    Parameters
    ----------
    u_left, rise : ndarray (k, 1)
        u at the left line, and how much more it is at the right one [l].
    T : ndarray (k, 1)
        Range of τ.
    """
    sinh = np.sinh(T)
    tanh = np.tanh(T / 2)
    start = rise / sinh - u_left * tanh
    end = rise / sinh + (u_left + rise) * tanh
    return PAtLines(start, end, -end / sinh, -end / np.tanh(T))


def _exponentials(u_left: Array, rise: Array, T: Array, tau: Array) -> tuple[Array, Array]:
    """p and u - u_left at τ, of gaps as in `_ends_of_displaced`.

    u = [u_left sinh(T-τ) + (u_left + rise) sinh τ]/sinh T. In a short gap u is nearly u_left: the
    difference is formed without subtracting them, by

        sinh(T-τ) + sinh τ - sinh T = -4 sinh(τ/2) sinh((T-τ)/2) sinh(T/2).

    tau: (k, nodes), or any places of a single gap.
    """
    ends = _ends_of_displaced(u_left, rise, T)
    one_at_right = np.sinh(tau) / np.sinh(T)
    one_at_left = np.sinh(T - tau) / np.sinh(T)
    sag = np.sinh(tau / 2) * np.sinh((T - tau) / 2) / np.cosh(T / 2)
    p = ends.left * one_at_left + ends.right * one_at_right
    return p, rise * one_at_right - 2 * u_left * sag


@dataclass(frozen=True, eq=False)
class Gaps:
    """n free surfaces between two lines each, at the nodes of the mesh of all.

    Nothing but T is unknown of a surface; the rest is evaluated when it is needed. Members that
    say "first" are those of the first surface alone, for objects that hold one.

    Attributes
    ----------
    T : ndarray (n, 1)
        Range of τ.
    p, u : ndarray (n, nodes)
        p = du/dτ and u, from the left line to the right one.
    rises : ndarray (n, nodes)
        u less u at the left line. In a short gap the difference of both would have few digits.
    """

    T: Array
    p: Array
    u: Array
    rises: Array

    @functools.cached_property
    def h(self) -> Array:
        """dx/dτ at the nodes (n, nodes)."""
        return np.asarray(rate(self.p)[0])

    @functools.cached_property
    def upright(self) -> bool:
        """Whether any of the surfaces would turn over: its |p| at a line is the steepest.

        That is compared but for a sixteenth of what the steepest is less than √2, 2e-9: more than
        the rounding of p, and less than what the rounding of x is worth there, 1.5e-8 of p.
        """
        return bool((np.abs(self.p[:, [0, -1]]) >= _STEEPEST * (1 - _UPRIGHT / 16)).any())

    @functools.cached_property
    def pulls(self) -> Array:
        """S = ∂F/∂u at the left and the right lines (2, n) [γ₁]."""
        return np.array([-sine(self.p[:, 0]), sine(self.p[:, -1])])

    @functools.cached_property
    def energy(self) -> Array:
        """F (n,) [γ₁ l]."""
        h = self.h
        square = self.p * self.p
        # √(h² + p²) - h without cancellation.
        density = h * (self.u * self.u / 2) + square / (np.sqrt(h * h + square) + h)
        return np.asarray(self.T[:, 0] * (density @ mesh_of(self.T).weights))

    @functools.cached_property
    def area(self) -> Array:
        """∫u dx (n,) [l²]."""
        return np.asarray(self.T[:, 0] * ((self.h * self.u) @ mesh_of(self.T).weights))

    @functools.cached_property
    def residual(self) -> float:
        """How far the nodal energy of the first surface is from its least, over u and S.

        The largest of the forces that are left at a node, at a line where its reaction is
        subtracted, and of how far u²/2 + cos φ is from being constant.
        """
        left_pull, right_pull = self.pulls[:, 0].tolist()
        u_left = float(self.u[0, 0])
        u_right = float(self.u[0, -1])
        size = abs(u_left) + abs(u_right) + abs(left_pull) + abs(right_pull) or 1.0
        imbalance = float(np.abs(self._nodal_imbalance(left_pull, right_pull)).max())

        # What cos φ falls by and u²/2 grows by from the left to the right line, which should be
        # the same, as products that lose no digits: cos² φ falls by the growth of sin² φ.
        cosines = math.sqrt(max(1 - left_pull * left_pull, 0.0))
        cosines += math.sqrt(max(1 - right_pull * right_pull, 0.0))
        cosine_falls = (right_pull - left_pull) * (right_pull + left_pull) / cosines
        half_square_rises = float(self.rises[0, -1]) * (u_left + u_right) / 2
        change = cosine_falls - half_square_rises
        return max(imbalance, abs(change) / size) / size

    def _nodal_imbalance(self, left_pull: float, right_pull: float) -> Array:
        """∂F/∂u of all nodes of the first surface (nodes,), less what pulls at both lines.

        left_pull, right_pull: the reactions at its lines.
        """
        _, weights, derivative = gauss_lobatto(DEGREE)
        mesh = mesh_of(self.T)
        half = self.T[0, 0] * np.diff(mesh.ends)[:, None] / 2  # dτ over that on [-1, 1]
        h = self.h[0][mesh.own]
        u = self.u[0][mesh.own]
        u_slope = self.rises[0][mesh.own] @ derivative.T  # du/dτ times `half`
        sine_phi = u_slope / np.sqrt(half * half * h * h + u_slope * u_slope)
        forces = half * weights * h * u + (weights * sine_phi) @ derivative  # (e, DEGREE + 1)
        # The last node of an element is the first of the next one.
        off = np.append(forces[:, :-1].ravel(), forces[-1, -1] - right_pull)
        off[::DEGREE][:-1] += np.append(-left_pull, forces[:-1, -1])
        return off

    @functools.cached_property
    def places(self) -> Array:
        """x of the nodes of the first surface (nodes,), from its left line on.

        On every element x is the polynomial that is 0 at its start and has dx/dτ = h at all other
        nodes; that it has so at the start, too, is not demanded.
        """
        derivative = gauss_lobatto(DEGREE).derivative
        mesh = mesh_of(self.T)
        h = self.T[0, 0] * np.diff(mesh.ends)[:, None] / 2 * self.h[0][mesh.own]
        from_starts = np.linalg.solve(derivative[1:, 1:], h[:, 1:].T).T
        starts = np.append(0.0, np.cumsum(from_starts[:-1, -1]))
        return np.append(0.0, from_starts + starts[:, None])

    def at(self, from_left: Array, from_right: Array) -> tuple[Array, Array]:
        """Displacement and slope of the first surface at places.

        τ of a place is found by Newton's method for x(τ), whose derivative is h.

        Parameters
        ----------
        from_left, from_right : ndarray (n,)
            Distances of the places from the left and the right line [l]. Lines may be further apart
            than `places` reach, as those over 40 l apart are: the smaller distance counts, and at
            most half of that reach.

        Returns
        -------
        u, slope : ndarray (n,)
            [l], and du/dx towards the right line.
        """
        (T,) = self.T
        u_left = self.u[0, :1]
        rise = self.rises[0, -1:]
        mesh = mesh_of(self.T)
        half = self.places[-1] / 2
        x_on_left = np.minimum(from_left, half)
        x_on_right = 2 * half - np.minimum(from_right, half)
        x = np.where(from_left <= from_right, x_on_left, x_on_right)
        tau = np.interp(x, self.places, T * mesh.nodes)
        for _ in range(_RANGE.inverse_steps):
            off = on_elements(T * mesh.ends, self.places, tau)[0] - x
            p, _ = _exponentials(u_left, rise, T, tau)
            step = off / rate(p)[0]
            tau = np.clip(tau - step, 0.0, T)
            if (np.abs(step) <= _RANGE.inside).all():
                break
        p, rises = _exponentials(u_left, rise, T, tau)
        return u_left + rises, p / rate(p)[0]


def surfaces(u: Array, rise: Array, width: Array) -> Gaps:
    """Free surfaces between lines, or beside single ones.

    Without another line u = u(0) e^-τ, and p = -u: a range of 40 leaves nothing of it. Where such a
    surface would turn over, |u(0)| > √2, it is that with the steepest u(0).

    Parameters
    ----------
    u, rise : ndarray (n, 1)
        Displacement of the first line, and how much more the other one is displaced [l].
    width : ndarray (n, 1)
        Distance of the lines [l]; infinity for all, if none has another line.

    Returns
    -------
    Gaps
    """
    if np.isinf(width).all():
        T = np.full_like(u, DECAYED)
        u = np.clip(u, -_STEEPEST, _STEEPEST)
        decaying = u * np.exp(-DECAYED * mesh_of(T).nodes)
        return Gaps(T, p=-decaying, u=decaying, rises=decaying - u)
    u, rise, width = np.broadcast_arrays(u, rise, np.minimum(width, DECAYED))

    def ends(T: Array, own: Indices) -> PAtLines:
        """p at both lines of the gaps with these numbers, if they have these ranges."""
        return _ends_of_displaced(u[own], rise[own], T)

    # |p| <= |rise|/sinh T + |u| + |rise| at both lines, and sinh T > 1 from T = 1 on.
    steepest = 1 + np.abs(u[:, 0]) + 2 * np.abs(rise[:, 0])
    T = range_of(width, ends, steepest)
    tau = T * mesh_of(T).nodes
    p, rises = _exponentials(u, rise, T, tau)
    return Gaps(T, p, u + rises, rises)


# A state reads each of its surfaces for energy, force, certificate and shape. One holds 10 kB at
# most, with 225 nodes, and all 10 MB.
@functools.lru_cache(maxsize=1024)
def single(u: float, rise: float, width: float) -> Gaps:
    """A single surface, kept as it is asked for often; parameters as of `surfaces`, numbers."""
    columns = (np.full((1, 1), part) for part in (u, rise, width))
    return surfaces(*columns)
