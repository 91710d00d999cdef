"""No adhesion: the surface pushed by an obstacle, for any profile with any number of contacts.

With w = 0 the lattice energy is convex and the contact set is a result, not a choice:

    min over u   Σ_i kΔx u_i²/2 + Σ_i t (u_{i+1} - u_i)²/2 + tails     s.t. u_i >= g_i,

t = γ₁/Δx. Its solution is the smallest majorant of g and 0 that is concave with respect to
{cosh, sinh}: a hull. Only its corners, the contact nodes, need to be found; the free surfaces
between and beside them are known in closed form, on a line (lattice.py) and around an axis
(radial_spans.py). They pull at their ends with positive stiffnesses, so that nothing cancels
however large l/Δx is.

Method. Whatever the surface over *some* of the nodes is, the surface over all of them lies above
it (M-matrix). So a node below the surface over others is free, for good: a removal is a proof.
1. The highest node of each block of 16, of 16², ..., forms a pyramid of coarser problems.
2. From its top: nodes below the surface of the level above are dropped; of the rest those which
   pull (multiplier < 0) are removed until none does.
The last level holds the exact contact set: u >= g, multipliers >= 0, zero where the surface is
free (ties are decided by rounding). The cost is some passes over the nodes, whatever l/Δx.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.nodes.lattice import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_BLOCK = 16  # nodes of a block, blocks of a larger one
_SLACK = 1 - 1e-12  # on bounds: rounding drops no node, the sign of its multiplier decides


@dataclass(frozen=True)
class ObstacleSolution:
    """The surface over an obstacle, per unit length of the line contact.

    u: displacements (n,). contact: (n,) bool, the nodes that hold the surface. multipliers: (n,)
    forces [force/length] of the indenter on the nodes, >= 0, zero where free.
    """

    u: Array
    contact: NDArray[np.bool_]
    multipliers: Array

    @property
    def intervals(self) -> Nodes:
        """First and last node of each contact (m, 2)."""
        return runs(self.contact)

    @property
    def energy(self) -> float:
        """U = Σ p_i u_i / 2 [energy/length]: the work of the multipliers p."""
        return float(self.multipliers @ self.u) / 2

    @property
    def force(self) -> float:
        """P = Σ p_i [force/length]."""
        return float(self.multipliers.sum())


def runs(contact: NDArray[np.bool_]) -> Nodes:
    """First and last node of each contact (m, 2), of a mask of all nodes."""
    edges = np.diff(contact.astype(np.int8), prepend=0, append=0)
    return np.column_stack((np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1))


def obstacle(lattice: Lattice, g: ArrayLike) -> ObstacleSolution:
    """Global minimum of the lattice energy for w = 0 with u_i >= g_i.

    g: (n,) heights d - f(x_i) of the obstacle; -inf where there is none, as beyond both ends. Of
    nodes around an axis the first one is on it. ValueError if the lattice has adhesion or g is not
    such an array.
    """
    g = _checked(lattice, g)
    nodes, u = np.arange(g.size), np.maximum(g, 0.0)
    if not lattice.gamma1 or g.max() <= 0:
        return ObstacleSolution(u, g > 0, lattice.on_nodes(lattice.spring * u, nodes))
    held, force = pressed(lattice, g)
    contact, multipliers = np.zeros(g.size, bool), np.zeros(g.size)
    contact[held], multipliers[held] = True, force
    free = np.flatnonzero(~contact)
    u[free] = np.maximum(surface(lattice, held, g[held], free), g[free])
    return ObstacleSolution(u, contact, multipliers)


def _checked(lattice: Lattice, g: ArrayLike) -> Array:
    g = np.asarray(g, float)
    if lattice.slopes != "small":
        raise ValueError(f"slopes = {lattice.slopes!r} is no obstacle problem: use slopes='small'")
    if lattice.w:
        raise ValueError(f"w = {lattice.w!r} must be 0 for an obstacle: use minimise")
    if g.ndim != 1 or not g.size:
        raise ValueError(f"g has shape {g.shape}, must be (n,): give one height per node")
    if not g.max() < math.inf:
        raise ValueError("g = nan or inf is no height: give finite numbers, -inf for no obstacle")
    return g


def pressed(lattice: Lattice, g: Array) -> tuple[Nodes, Array]:
    """Contact nodes for w = 0, whatever the lattice's w, of heights g (n,), and their multipliers.

    Those with g = 0 if none is higher.
    """
    if g.max() <= 0:
        touching = np.flatnonzero(g == 0)
        return touching, np.zeros(touching.size)
    held = np.empty(0, np.int64)
    for nodes in reversed(_pyramid(g)):
        above = nodes[g[nodes] > 0]
        held = above[g[above] >= _SLACK * surface(lattice, held, g[held], above)]
        while (force := _multipliers(lattice, held, g[held])).min() < 0:
            held = held[force >= 0]
    return held, force


def _pyramid(g: Array) -> list[Nodes]:
    """Levels of the highest node of each block, finest (all nodes) first."""
    levels = [np.arange(g.size)]
    while levels[-1].size > _BLOCK:
        nodes = levels[-1]
        blocks = np.append(nodes, np.full(-nodes.size % _BLOCK, nodes[-1])).reshape(-1, _BLOCK)
        levels.append(blocks[np.arange(len(blocks)), g[blocks].argmax(axis=1)])
    return levels


def surface(lattice: Lattice, held: Nodes, g: Array, at: Nodes) -> Array:
    """Displacements at some nodes, increasing, of the surface held at g on others, or at 0."""
    u = np.zeros(at.size)
    if not held.size:
        return u
    ends = np.searchsorted(at, held)
    gap, between = np.repeat(np.arange(held.size - 1), np.diff(ends)), slice(ends[0], ends[-1])
    near, far, _ = lattice.shape(held[gap], held[gap + 1], at[between])
    u[between] = near * g[gap] + far * g[gap + 1]
    if ends[0]:
        inwards, first = slice(ends[0] - 1, None, -1), held[0]
        u[inwards] = lattice.beyond(first, -1, first - at[inwards], g[0])
    if ends[-1] < at.size:
        outwards, last = slice(ends[-1], None), held[-1]
        u[outwards] = lattice.beyond(last, 1, at[outwards] - last, g[-1])
    return u


def _multipliers(lattice: Lattice, nodes: Nodes, u: Array) -> Array:
    """Forces p_i that hold these nodes at u; most are neighbours."""
    flow = lattice.on_links(lattice.link * (u[:-1] - u[1:]), nodes)
    force = np.array(lattice.on_nodes(lattice.spring * u, nodes))
    wide = np.flatnonzero(np.diff(nodes) > 1)
    a, b = u[wide], u[wide + 1]
    tie, one, other = lattice.pair(nodes[wide], nodes[wide + 1])
    flow[wide] = tie * (a - b)
    force[:-1] += flow
    force[1:] -= flow
    force[wide] += one * a
    force[wide + 1] += other * b
    force[0] += lattice.pull(nodes[0], -1) * u[0]
    force[-1] += lattice.pull(nodes[-1], 1) * u[-1]
    return force
