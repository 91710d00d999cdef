"""No adhesion: the surface pushed by an obstacle, for any profile with any number of contacts.

With w = 0 the lattice energy is convex and the contact set is a result, not a choice:

    min over u   Σ_i kΔx u_i²/2 + Σ_i t (u_{i+1} - u_i)²/2 + tails     s.t. u_i >= g_i,

t = γ₁/Δx. Its solution is the smallest majorant of g and 0 that is concave with respect to
{cosh, sinh}: a hull. Only its corners, the contact nodes, need to be found; between two of them, n
links apart, the free surface is eliminated exactly, and pulls at the one displaced by a with

    T_n (a - b) + S_n a,   T_n = t sinh μ / sinh μn,   S_n = t(1-λ) (1 - λ^(n-1)) / (1 + λⁿ)

(b: the other's displacement, μ = -ln λ, n = ∞ for a tail), a sum of positive stiffnesses: nothing
cancels however large l/Δx is.

Method. Whatever the surface over *some* of the nodes is, the surface over all of them lies above
it (M-matrix). So a node below the surface over others is free, for good: a removal is a proof.
1. The highest node of each block of 16, of 16², ..., forms a pyramid of coarser problems.
2. From its top: nodes below the surface of the level above are dropped, whole blocks of them by
   u_j >= λ^|i-j| u_i; of the rest those which pull (multiplier < 0) are removed until none does.
The last level holds the exact contact set: u >= g, multipliers >= 0, zero where the surface is
free (ties are decided by rounding). The cost is some passes over the nodes, whatever l/Δx.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.lattice import span
from discretization.lattice.nodes import Lattice

Array = NDArray[np.float64]
Nodes = NDArray[np.intp]
BLOCK = 16  # nodes of a block, blocks of a larger one
SLACK = 1 - 1e-12  # on bounds: rounding drops no node, the sign of its multiplier decides


@dataclass(frozen=True)
class ObstacleSolution:
    """The surface over an obstacle, per unit length of the line contact.

    u: displacements (n,). contact: (n,) bool, the nodes that hold the surface. multipliers: (n,)
    forces [force/length] of the indenter on the nodes, >= 0, zero where free. rounds: of removal.
    """

    u: Array
    contact: NDArray[np.bool_]
    multipliers: Array
    rounds: int

    @property
    def intervals(self) -> Nodes:
        """First and last node of each contact (m, 2)."""
        return span.runs(self.contact)

    @property
    def energy(self) -> float:
        """U = Σ p_i u_i / 2 [energy/length]: the work of the multipliers p."""
        return float(self.multipliers @ self.u) / 2

    @property
    def force(self) -> float:
        """P = Σ p_i [force/length]."""
        return float(self.multipliers.sum())


def obstacle(lattice: Lattice, g: ArrayLike) -> ObstacleSolution:
    """Global minimum of the lattice energy for w = 0 with u_i >= g_i.

    g: (n,) heights d - f(x_i) of the obstacle; -inf where there is none, as beyond both ends.
    ValueError if the lattice has adhesion or g is not such an array.
    """
    g = _checked(lattice, g)
    if not lattice.gamma1 or g.max() <= 0:
        u = np.maximum(g, 0.0)
        return ObstacleSolution(u, g > 0, lattice.spring * u, 0)
    held, pressing, rounds = _held(lattice, g)
    contact, multipliers = np.zeros(g.size, bool), np.zeros(g.size)
    contact[held], multipliers[held] = True, pressing
    return ObstacleSolution(_surface(lattice, g, held), contact, multipliers, rounds)


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


def pressing_nodes(lattice: Lattice, g: Array) -> Nodes:
    """Contact nodes for w = 0, whatever the lattice's w, of heights g (n,), some > 0."""
    return _held(lattice, g)[0]


def _held(lattice: Lattice, g: Array) -> tuple[Nodes, Array, int]:
    """Contact nodes, their multipliers, rounds of removal: down the pyramid."""
    pyramid = _pyramid(g)
    blocks = np.arange(pyramid[-1].size)
    held, rounds = np.empty(0, np.intp), 0
    for level in reversed(range(len(pyramid))):
        nodes = pyramid[level][blocks] if level else blocks
        heights = g[nodes]
        below = _lower_bound(lattice, g, held, nodes)
        keep = (heights > 0) & (heights >= below)
        held, pressing, more = _peel(lattice, nodes[keep], heights[keep])
        rounds += more
        if level:
            below *= math.exp(-lattice.log_decay * BLOCK**level)
            alive = blocks[(heights > 0) & (heights >= below)]
            blocks = np.arange(pyramid[level - 1].size)
            if alive.size < pyramid[level].size:
                inside = (alive[:, None] * BLOCK + np.arange(BLOCK)).ravel()
                blocks = inside[: np.searchsorted(inside, blocks.size)]
    return held, pressing, rounds


def _pyramid(g: Array) -> list[Nodes]:
    """Levels of the highest node of each block, finest (all nodes) first."""
    levels = [np.arange(g.size)]
    while levels[-1].size > BLOCK:
        nodes = levels[-1]
        heights = g[nodes] if len(levels) > 1 else g
        whole = nodes.size // BLOCK
        best = heights[: whole * BLOCK].reshape(whole, BLOCK).argmax(1)
        best += np.arange(0, whole * BLOCK, BLOCK)
        if whole * BLOCK < nodes.size:
            best = np.append(best, whole * BLOCK + heights[whole * BLOCK :].argmax())
        levels.append(nodes[best])
    return levels


def _lower_bound(lattice: Lattice, g: Array, held: Nodes, nodes: Nodes) -> Array:
    """At increasing nodes, the surface held at g on some nodes; 0 in gaps with few nodes."""
    below = np.zeros(nodes.size)
    if not held.size:
        return below
    ends = np.searchsorted(nodes, held)
    wide = np.flatnonzero(np.diff(ends) > 2 * BLOCK)
    at = _ranges(ends[wide], ends[wide + 1])
    below[at] = _between(lattice, g, held, wide, nodes[at], np.diff(ends)[wide])
    for end, part in ((held[0], slice(ends[0])), (held[-1], slice(ends[-1], None))):
        below[part] = g[end] * np.exp(-lattice.log_decay * np.abs(nodes[part] - end))
    below *= SLACK
    return below


def _surface(lattice: Lattice, g: Array, held: Nodes) -> Array:
    """u at all nodes, held at g on some."""
    u = g.copy()
    wide = np.flatnonzero(np.diff(held) > 1)
    at = _ranges(held[wide] + 1, held[wide + 1])
    u[at] = _between(lattice, g, held, wide, at, np.diff(held)[wide] - 1)
    first, last = held[0], held[-1]
    u[:first] = g[first] * np.exp(-lattice.log_decay * np.arange(first, 0, -1))
    u[last + 1 :] = g[last] * np.exp(-lattice.log_decay * np.arange(1, g.size - last))
    return np.maximum(u, g, out=u)


def _ranges(starts: Nodes, stops: Nodes) -> Nodes:
    """All integers in the half-open ranges, concatenated."""
    counts = stops - starts
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if ends.size else 0) + np.repeat(starts - ends + counts, counts)


def _between(
    lattice: Lattice, g: Array, held: Nodes, gaps: Nodes, nodes: Nodes, counts: Nodes
) -> Array:
    """u at nodes, `counts` of them in each of the gaps."""
    left, right = (np.repeat(ends[gaps], counts) for ends in (held[:-1], held[1:]))
    return lattice.free(left, right, g[left], g[right], nodes)


def _peel(lattice: Lattice, nodes: Nodes, heights: Array) -> tuple[Nodes, Array, int]:
    """Remove nodes that pull, until those left press: these, their multipliers, and rounds."""
    place = np.concatenate(([-math.inf], nodes, [math.inf]))
    u, rounds = np.concatenate(([0.0], heights, [0.0])), 0
    while True:
        force = _multipliers(lattice, place, u)
        keep = np.flatnonzero(force >= 0)  # with the places at infinity
        if keep.size == u.size:
            return place[1:-1].astype(np.intp), force[1:-1], rounds
        place, u, rounds = place[keep], u[keep], rounds + 1


def _multipliers(lattice: Lattice, place: Array, u: Array) -> Array:
    """Forces p_i that hold the nodes at these places at u; most are neighbours."""
    flow = u[:-1] - u[1:]
    flow *= lattice.link
    force = lattice.spring * u
    wide = np.flatnonzero(np.diff(place) > 1)
    a, b = u[wide], u[wide + 1]
    tie, ground, _ = lattice.pair(0, place[wide + 1] - place[wide])
    flow[wide] = tie * (a - b)
    force[:-1] += flow
    force[1:] -= flow
    force[wide] += ground * a
    force[wide + 1] += ground * b
    force[[0, -1]] = 0  # the places at infinity
    return force
