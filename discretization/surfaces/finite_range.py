"""The range of the coordinate τ in which gaps with finite slopes are linear, and its mesh.

In units of l and γ₁ the surface between two lines L apart solves (sin φ)' = u with tan φ = u'. In
p = 2 sin(φ/2) and dτ = cos(φ/2) ds, s the arc length, this is the linear problem of small slopes:
du/dτ = p and dp/dτ = u, so that u is a sum of two exponentials, and only x is not,

    dx/dτ = h(p) = (1 - p²/2)/√(1 - p²/4).

So a gap has one unknown, its range T of τ, for which x(T) = L.

Only one mean displacement has a given inclination φ at a line, at a given rise u_b - u_a: with it
grows v = ∂u, (cos³φ v')' = v, v = 1 at both lines and 0 < v < 1 between (maximum principle), so
that v' < 0 outwards of a line, and its reaction grows. Hence T is unique as well. A surface that
would turn over, p² > 2, is followed as if it were upright there: at its line it is cut at p² = 2,
as its least energy among functions that may jump is. Lines more than 40 l apart do not feel each
other.
"""

import bisect
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from discretization.roots import crossings
from discretization.surfaces.network import rounded
from energy.arrays import Array, Indices

DEGREE = 16  # of u and x in τ, which it resolves to rounding on elements of these ends:
_ENDS = (0.0, 0.4, 1.0, 2.5, 5.0, 9.0, 14.0, 21.0)  # from either line up to the middle
FAR = 40.0  # lines further apart are independent: exp(-FAR) is below rounding
OVERHANG = math.sqrt(2)  # l: displacement at which a tail is upright
UPRIGHT = 2e-8  # of the greatest p: so close to turning over no double resolves it
STEEPEST = OVERHANG * (1 - UPRIGHT)  # p, and the displacement of a tail, at most
_CLOSE = 8e-16  # of T: what x and L may differ by


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


def rate(p: Any) -> Any:
    """h(p)."""
    square = np.minimum(p * p, STEEPEST**2)
    return (1 - square / 2) / np.sqrt(1 - square / 4)


# p at both lines of gaps with these numbers (k,) and ranges T (k, 1)
Ends = Callable[[Array, Indices], tuple[Array, Array]]


def range_of(length: Array, ends: Ends, steepest: Any) -> Array:
    """T with x(T) = L (n, 1), from T = L on.

    steepest: |p| at both lines is no more from T = 1 on. As 1 - h <= p²/2 and |p| decays by e^-τ
    from either line, L <= T <= L + 1 + 2 ln(steepest).
    """

    def off(T: Array, own: Indices) -> Array:
        """(x - L)/T."""
        mesh, (start, end) = mesh_of(T), ends(T[:, None], own)
        grown = np.sinh(T[:, None] * mesh.nodes) / np.sinh(T[:, None])
        return np.asarray(rate(start * grown[:, ::-1] + end * grown) @ mesh.weights - low[own] / T)

    low = length[:, 0]
    high = low + 1 + 2 * np.log(steepest)
    return crossings(off, low, high, low, 1 / low, _CLOSE)[:, None]


def rest_displacement(p: Any, rise: Any, length: Any) -> Any:
    """u at a line with this p outwards, where the other line is displaced by `rise` more.

    Numbers or arrays (n,); length: of the gap.
    """
    one = not (np.ndim(p) or np.ndim(rise) or np.ndim(length))
    p, rise, length = (np.reshape(part, (-1, 1)) for part in (p, rise, length))
    p, rise, length = np.broadcast_arrays(p, rise, np.minimum(length, FAR))

    def ends(T: Array, own: Indices) -> tuple[Array, Array]:
        """At the other line at most upright: what would turn over falls short of it."""
        return p[own], np.clip(rise[own] / np.tanh(T / 2) - p[own], -STEEPEST, STEEPEST)

    T = range_of(length, ends, 2.0)
    u = (ends(T, np.arange(len(T)))[1] - p * np.cosh(T)) / np.sinh(T)
    return float(u[0, 0]) if one else u[:, 0]
