"""Lowest energy of all contact sets around the axis: a shortest path over contact nodes.

With u = g = d - f on the contact nodes and exact surfaces between and beside them the energy is a
sum over nodes, contact links and free surfaces (radial_spans.py), so that with V_j the least energy
that ends in contact node j, in units of 2πγ₁, and V_j + σ_j(out) g_j²/2 with the surface outside,

    V_j = κ_j g_j²/2 + min( σ_j(in) g_j²/2,  min_i V_i + cost(i, j) ),
    cost(i, j) = (C (g_i - g_j)² + G_i g_i² + G_j g_j²)/2, less the link's adhesion if j = i + 1.

A surface is admissible if it stays above the indenter. Surfaces that begin at node i are ordered by
their slope there, and do not cross: so that to j clears all nodes between if C g_j - E_i g_i, which
grows with its slope, is no smaller for j than for any of them. A disc inside clears them if g_j is
no smaller than any g_m P_j/P_m, the outer surface if g_i is no smaller than any g_m Q_i/Q_m.

The recursion leaves out nothing and takes O(n²) steps of n nodes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.radial_spans import RingSpans, ring_spans
from discretization.lattice.row import Row

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
MOST = 6000  # nodes, for which it takes about ten seconds


def lowest_rings(row: Row, depth: float) -> tuple[Nodes, float]:
    """First and last nodes (m, 2) of the contacts of lowest energy among all sets, and its energy.

    ValueError for more than MOST nodes.
    """
    n, link = row.f.size, row.lattice.link
    if n > MOST:
        raise ValueError(
            f"spacing = {row.lattice.spacing!r} puts {n} nodes where contact is to be looked for; "
            f"branch = 'global' with rotational symmetry takes at most {MOST}: give a larger one"
        )
    spans, g = ring_spans(row.lattice.spring / link, n), depth - row.f
    own = spans.spring.astype(float) * g * g / 2
    inside, outside = (part.astype(float) * g * g / 2 for part in (spans.inside, spans.outside))
    value = own + np.where(g >= _before(g, spans.rise), inside, math.inf)
    came, works = np.full(n, -1), row.works[0] * row.bonds / link
    for i in range(n - 1):
        cost = own[i + 1 :] + value[i] + _costs(spans, g, i, float(works[i]))
        better = cost < value[i + 1 :]
        value[i + 1 :][better] = cost[better]
        came[i + 1 :][better] = i
    beyond = _before(g[::-1], spans.fall[-1] - spans.fall[::-1])[::-1]
    total = value + np.where(g >= beyond, outside, math.inf)
    last = int(np.argmin(total))
    if (g <= 0).all() and not total[last] < 0:
        return np.empty((0, 2), np.int64), 0.0
    return _contacts(came, last), link * float(total[last])


def _before(g: Array, growth: Array) -> Array:
    """Largest g_m exp(growth_j - growth_m) over the nodes m before each node j (n,); -inf: none."""
    factors = np.exp(np.diff(growth).astype(float))
    found = np.full(g.size, -math.inf)
    for j, factor in enumerate(factors.tolist(), start=1):
        found[j] = max(found[j - 1], g[j - 1]) * factor
    return found


def _costs(spans: RingSpans, g: Array, i: int, work: float) -> Array:
    """cost(i, j) of all nodes j beyond i; inf where the surface would not clear the indenter."""
    there = np.arange(i + 1, g.size)
    tie, left, right = spans.pair(i, there)
    pull = tie * (g[there] - g[i]) - left * g[i]
    steepest = np.maximum.accumulate(np.concatenate([[-math.inf], pull[:-1]]))
    cost = (tie * (g[there] - g[i]) ** 2 + left * g[i] ** 2 + right * g[there] ** 2) / 2
    cost[0] -= work
    return np.where(pull >= steepest, cost, math.inf)


def _contacts(came: Nodes, last: int) -> Nodes:
    """First and last node of each contact on the path that ends here."""
    path = [last]
    while came[path[-1]] >= 0:
        path.append(int(came[path[-1]]))
    held = np.array(path[::-1], np.int64)
    parted = np.flatnonzero(np.diff(held) > 1)
    first, final = np.append(0, parted + 1), np.append(parted, held.size - 1)
    return np.column_stack([held[first], held[final]])
