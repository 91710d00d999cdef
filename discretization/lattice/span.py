"""Free spans between contact nodes in closed form, and the surface built from them.

A contact set is the first and last node of each contact, (m, 2), or a mask of all nodes, (n,).

Between two contact nodes T links apart free nodes obey u_{i-1} - 2u_i + u_{i+1} = κ u_i: u is a sum
of sinh μ(i - left) and sinh μ(right - i), μ = -ln λ; beyond the outermost contact nodes T = ∞ and u
is a tail. Everything is scaled so that no sinh overflows and no difference cancels.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.nodes import Lattice
from discretization.lattice.shares import shares

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]
FAR = 60.0  # decay lengths after which the ends of a span are independent


def runs(contact: Mask) -> Nodes:
    """First and last node of each contact (m, 2)."""
    edges = np.diff(contact.astype(np.int8), prepend=0, append=0)
    return np.column_stack((np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1))


def mask_of(n: int, contacts: Nodes) -> Mask:
    """(n,) whether a node is in one of the contacts."""
    step = np.zeros(n + 1, np.int64)
    step[contacts[:, 0]] += 1
    step[contacts[:, 1] + 1] -= 1
    return np.cumsum(step[:-1]) > 0


def excess(lattice: Lattice, p: Array, q: Array, left: Array, own: Array, right: Array) -> Array:
    """How far `own` lies above the span between its neighbours, p nodes left and q nodes right."""
    near, far, rest = shares(lattice.log_decay, p, q)
    result = near * (own - left)
    result += far * (own - right)
    return result + rest * own


def above(lattice: Lattice, y: Array, held: Nodes, at: Nodes, own: Array) -> Array:
    """Excess of `own` at the nodes `at` over the spans through y at the held nodes."""
    k = np.searchsorted(held, at)
    x = np.concatenate([[-math.inf], held, [math.inf]])
    ends = np.concatenate([[0.0], y[held], [0.0]])
    return excess(lattice, at - x[k], x[k + 1] - at, ends[k], own, ends[k + 1])


def displacement(lattice: Lattice, g: Array, contact: Mask) -> Array:
    """u (n,): g on the contact nodes, spans between and tails beyond them."""
    u, free = np.where(contact, g, 0.0), np.flatnonzero(~contact)
    u[free] = -above(lattice, g, np.flatnonzero(contact), free, u[free])
    return u


def unit(lattice: Lattice) -> float:
    """t sinh μ: what a half-infinite tail and half of the spring below do to a node."""
    return lattice.link * math.sinh(lattice.log_decay)


def stiffness(lattice: Lattice, links: Array) -> Array:
    """K_T = t sinh μ/(1 - λ²ᵀ); a span to u' instead of a tail from u costs K_T (u' - λᵀu)²."""
    with np.errstate(divide="ignore"):  # T = 0
        both = np.divide(-1.0, np.expm1(-2 * lattice.log_decay * links))
    return unit(lattice) * both


def energy(lattice: Lattice, g: Array, held: Nodes) -> float:
    """Springs and surface of the state held at these nodes only, span by span; no adhesion."""
    links = np.diff(held, prepend=-math.inf)
    before = np.concatenate([[0.0], g[held]])[: held.size]
    rise = g[held] - before - np.expm1(-lattice.log_decay * links) * before
    return float(np.sum(stiffness(lattice, links) * rise**2))


def running_max(values: Array, group: Nodes) -> Array:
    """Largest value so far within each group; group (n,): 0, ..., 0, 1, ..., 1, 2, ..."""
    order = np.argsort(values, kind="stable")
    rank = np.empty(values.size, np.int64)
    rank[order] = np.arange(values.size)
    rank += group * values.size
    rank = np.maximum.accumulate(rank)
    rank -= group * values.size
    return values[order[rank]]
