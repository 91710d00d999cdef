"""Contacts of lowest energy around an axis on nodes: which rings the fitted mesh begins with.

    min U[u] s.t. u >= g, over all u and all contact sets (small slopes, γ₁ > 0).

Let T_j be the least energy of a surface whose outermost contact node is j, with the free surface
outside. From a contact node i to the next one, j, the surface that is held at i and free outside
is lifted by g_j - τ_ij g_i there, τ_ij what is left of u_i at j, which costs a square:

    T_j = min over i of  T_i + (E_ij + κ_j + σ_j)/2 (g_j - τ_ij g_i)² - adhesion, if i = j - 1,

κ_j + σ_j the stiffness of the spring at j and of the surface outside, E_ij that of the surface
between with node i at rest. No node between is penetrated if g_m - τ_im g_i, times what a
displacement of m pulls with at i, is nowhere larger before j: surfaces that leave i are ordered by
their slopes. Where nothing is in contact before j, E is that of the disc inside, and u_i = 0. All
of these follow node by node, for all i at once: n² numbers for n nodes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.nodes.lattice import Lattice

Array = NDArray[np.float64]
_TINY = 1e-300  # what a node far away pulls with: only the sign of a slope is left


def lowest_rings(lattice: Lattice, g: Array) -> NDArray[np.bool_]:
    """The nodes in contact (n,) of lowest energy, of heights g = d - f on all nodes."""
    n = g.size
    links = np.arange(n - 1) + 0.5
    spring, link = lattice.spring * lattice.weight(np.arange(n)), lattice.link * links
    outside = spring + lattice.pull(np.arange(n), 1)
    decay, bonds = link / (link + outside[1:]), lattice.w * lattice.cell * links
    least, before = np.zeros(n + 1), np.zeros(n + 1, np.int64)  # 0: nothing; i + 1: node i
    felt, reaching, free = np.zeros(n + 1), np.ones(n + 1), np.zeros(n + 1)
    steepest = np.full(n + 1, -math.inf)
    for j in range(n):
        starts = slice(0, j + 1)
        lift = g[j] - free[starts]
        slope = reaching[starts] * lift
        cost = least[starts] + (felt[starts] + outside[j]) / 2 * lift**2
        cost[slope < steepest[starts]] = math.inf
        cost[j] -= bonds[j - 1] if j else 0.0
        before[j + 1] = best = j - int(cost[::-1].argmin())
        least[j + 1] = cost[best]
        steepest[starts] = np.maximum(steepest[starts], slope)
        if j < n - 1:
            share = link[j] / (link[j] + spring[j] + felt[starts])
            felt[starts] = share * (spring[j] + felt[starts])
            reaching[starts] = np.maximum(share * reaching[starts], _TINY)
            felt[j + 1] = reaching[j + 1] = link[j]
            free[: j + 2] = decay[j] * np.append(free[starts], g[j])
    contact, k = np.zeros(n, bool), int(np.where(steepest <= 0, least, math.inf).argmin())
    while k:
        contact[k - 1], k = True, int(before[k])
    return contact
