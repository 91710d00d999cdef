"""Free spans between contact nodes in closed form, and the w = 0 surface built from them.

Between two contact nodes T links apart free nodes obey u_{i-1} - 2u_i + u_{i+1} = κ u_i: u is a sum
of sinh μ(i - left) and sinh μ(right - i), μ = -ln λ; beyond the outermost contact nodes T = ∞ and u
is a tail. Everything is scaled so that no sinh overflows and no difference cancels.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]


def excess(lattice: Lattice, p: Array, q: Array, left: Array, own: Array, right: Array) -> Array:
    """How far `own` lies above the span between its neighbours, p nodes left and q nodes right.

    (own - left) sinh μq/sinh μ(p+q) + (own - right) sinh μp/sinh μ(p+q)
    + own · 2 sinh(μp/2) sinh(μq/2)/cosh(μ(p+q)/2); p and q may be inf.
    """
    mu = lattice.log_decay
    ep, eq, both = np.exp(-mu * p), np.exp(-mu * q), np.expm1(-2 * mu * (p + q))
    result = ep * np.expm1(-2 * mu * q) / both * (own - left)
    result += eq * np.expm1(-2 * mu * p) / both * (own - right)
    return result + np.expm1(-mu * p) * np.expm1(-mu * q) / (1 + ep * eq) * own


def advance(lattice: Lattice, g: Array, links: Array, facing: float) -> tuple[Array, Array, Array]:
    """`Lattice.gap`, `advance_energy` and `advance_force` of a line that faces another one.

    g: (n+1,) at the line's successive nodes; links: (n,) from the first n of them to the facing
    line, where u = facing; they need not be whole. Advancing lifts the next node out of the span,

        ΔE = (K_1 + K_{T-1} - t sinh μ) gap² - wΔx,

    and the gap returned is scaled so that ΔE has the form of `Lattice.advance_cost`.
    """
    one, unit = np.ones_like(links), lattice.link * math.sinh(lattice.log_decay)
    half = lattice.link_over_decay / 2 + (stiffness(lattice, links - 1) - unit)
    gap = -excess(lattice, one, links - 1, g[:-1], g[1:], facing * one)
    energy = half * gap * gap - lattice.w * lattice.spacing
    force = -2 * half * gap * excess(lattice, one, links - 1, one, one, one)
    return gap * np.sqrt(2 * half / lattice.link_over_decay), energy, force


def above(lattice: Lattice, y: Array, held: Nodes, at: Nodes, own: Array) -> Array:
    """Excess of `own` at the nodes `at` over the spans through y at the held nodes."""
    k = np.searchsorted(held, at)
    x = np.concatenate([[-math.inf], held, [math.inf]])
    ends = np.concatenate([[0.0], y[held], [0.0]])
    return excess(lattice, at - x[k], x[k + 1] - at, ends[k], own, ends[k + 1])


def displacement(lattice: Lattice, g: Array, contact: NDArray[np.bool_]) -> Array:
    """u (n,): g on the contact nodes, spans between and tails beyond them."""
    u, free = np.where(contact, g, 0.0), np.flatnonzero(~contact)
    u[free] = -above(lattice, g, np.flatnonzero(contact), free, u[free])
    return u


def stiffness(lattice: Lattice, links: Array) -> Array:
    """K_T = t sinh μ/(1 - λ²ᵀ); a span to u' instead of a tail from u costs K_T (u' - λᵀu)²."""
    with np.errstate(divide="ignore"):  # T = 0
        both = np.divide(-1.0, np.expm1(-2 * lattice.log_decay * links))
    return lattice.link * math.sinh(lattice.log_decay) * both


def energy(lattice: Lattice, g: Array, held: Nodes) -> float:
    """Springs and surface of the state held at these nodes only, span by span; no adhesion."""
    links = np.diff(held, prepend=-math.inf)
    before = np.concatenate([[0.0], g[held]])[: held.size]
    rise = g[held] - before - np.expm1(-lattice.log_decay * links) * before
    return float(np.sum(stiffness(lattice, links) * rise**2))


def majorant(lattice: Lattice, g: Array) -> Nodes:
    """Contact nodes for w = 0: those with g >= 0 that no span between two others passes above.

    A node below any span can go at once. Spans over 1, 2, 4, ... neighbours take whole flanks away,
    until those between direct neighbours find nothing any more.
    """
    nodes = np.flatnonzero(g > 0 if g.max() > 0 else g == 0)
    stride, complete = 1, False
    while nodes.size and not complete:
        zero = np.zeros(stride)
        x = np.concatenate([zero - math.inf, nodes, zero + math.inf])
        y = np.concatenate([zero, g[nodes], zero])
        near, far = slice(None, -2 * stride), slice(2 * stride, None)
        own = y[stride:-stride]
        keep = excess(lattice, nodes - x[near], x[far] - nodes, y[near], own, y[far]) >= 0
        complete = stride == 1 and bool(keep.all())
        nodes = nodes[keep]
        stride = 2 * stride if 2 * stride <= nodes.size else 1
    return nodes
