"""Free surfaces between two contact nodes with finite slopes, by Newton's method on their nodes.

In units k = γ₁ = l = 1 with spacing h = Δx/l, T links apart, the ends displaced by u_0 and u_T,

    min E = Σ_{0<i<T} h u_i²/2 + Σ_{i<T} h (√(1 + s_i²) - 1),    s_i = (u_{i+1} - u_i)/h,

over the nodes between. E is strictly convex. The springs under the end nodes are not counted, as of
a tail.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dptsv

from discretization.lattice.shares import shares

Array = NDArray[np.float64]
ENDLESS = 40.0  # decay lengths, beyond which the ends are independent to rounding
_NEWTON = 60  # steps of Newton's method; four or five do
_SETTLED = 1e-9  # of u: the step after which the next would be below rounding
_ROUNDING = 1e-15  # of E


class FiniteSpan(NamedTuple):
    """A relaxed surface: u (T + 1,), E, and dE/du_0 and dE/du_T."""

    u: Array
    energy: float
    pulls: tuple[float, float]


@functools.lru_cache(maxsize=1 << 12)
def finite_span(h: float, left: float, right: float, links: int) -> FiniteSpan:
    """The surface between ends displaced by `left` and `right`, in the units of the module."""
    near, far, _ = shares(2 * math.asinh(h / 2), np.arange(links + 1.0), np.arange(links, -1.0, -1))
    u = near * left + far * right
    for _ in range(_NEWTON):
        slopes = np.diff(u) / h
        root = np.sqrt(1 + slopes * slopes)
        force = h * u[1:-1] - np.diff(slopes / root)
        step = _step(h, 1 / root**3, force)
        if _energy(h, u + step) > (1 + _ROUNDING) * _energy(h, u):
            step = _step(h, np.ones_like(root), force)  # a stiffness that is never too small
        u = u + step
        if np.abs(step).max() <= _SETTLED * np.abs(u).max():
            break
    slopes = np.diff(u) / h
    tension = slopes / np.sqrt(1 + slopes * slopes)
    return FiniteSpan(u, _energy(h, u), (-float(tension[0]), float(tension[-1])))


def _step(h: float, stiffness: Array, force: Array) -> Array:
    """Newton's step (T + 1,) with these stiffnesses of the links, over h."""
    if not force.size:
        return np.zeros(2)
    diagonal, beside = h + (stiffness[1:] + stiffness[:-1]) / h, -stiffness[1:] / h
    return np.pad(dptsv(diagonal, beside[: max(1, force.size - 1)], -force)[2], 1)


def _energy(h: float, u: Array) -> float:
    squares, inner = (np.diff(u) / h) ** 2, u[1:-1]
    return h * (float(inner @ inner) / 2 + float((squares / (1 + np.sqrt(1 + squares))).sum()))
