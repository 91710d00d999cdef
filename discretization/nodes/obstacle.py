"""No adhesion: the surface pushed by an obstacle, for any profile with any number of contacts.

With w = 0 the lattice energy is convex and the contact set is a result, not a choice:

    min over u   Σ_i kΔx u_i²/2 + Σ_i t (u_{i+1} - u_i)²/2 + tails     s.t. u_i >= g_i,

t = γ₁/Δx. Its solution is the smallest majorant of g and 0 that is concave with respect to
{cosh, sinh}: a hull. Only its corners, the contact nodes, need to be found; the free surfaces
between and beside them are known in closed form (lattice.py). They pull at their ends with positive
stiffnesses, so that nothing cancels however large l/Δx is.

Method. Whatever the surface over *some* of the nodes is, the surface over all of them lies above
it (M-matrix). So a node below the surface over others is free, for good: a removal is a proof.
1. The highest node of each block of 16, of 16², ..., forms a pyramid of coarser problems.
2. From its top: nodes below the surface of the level above are dropped; of the rest those which
   pull (multiplier < 0) are removed until none does; all at once, since the removal of one only
   raises the surface, so that the others stay below what it is without them.
The last level holds the exact contact set: u >= g, multipliers >= 0, zero where the surface is
free (ties are decided by rounding). The cost is some passes over the nodes, whatever l/Δx.

Conventions
-----------
u and g = d - f are positive down into the layer; the highest node is the one with the largest g. A
multiplier is the force with which the indenter presses on a contact node, positive downwards. Nodes
are numbered from 0 in the row of g, from left to right; line contacts only. `Lattice.log_decay` is
μ, by which a free tail decays per link; `shares` are the parts of both ends in the displacement
between them, `Lattice.surface_stiffnesses` what a free surface does to its ends as springs: one
that ties them, and one from each of them to the ground; `Lattice.spring_stiffness` is kΔx.
"""

import math

import numpy as np

from discretization.nodes.lattice import Lattice, shares
from energy.arrays import Array, Nodes

# Neither a _BLOCK of 8 or 32 nor a slack of 5e-13 or 2e-12 changes a result (`python -m
# tests.sensitivity discretization.nodes.obstacle`).
_BLOCK = 16  # nodes of a block, blocks of a larger one
_SLACK = 1 - 1e-12  # on bounds: rounding drops no node, the sign of its multiplier decides


def pressed(lattice: Lattice, g: Array) -> tuple[Nodes, Array]:
    """Contact nodes of the surface without adhesion, whatever the lattice's w.

    Parameters
    ----------
    lattice : Lattice
    g : ndarray (n,)
        d - f at the nodes [length].

    Returns
    -------
    nodes : ndarray of int
        Those in contact; those with g = 0 if none is higher.
    forces : ndarray
        What holds them down, their multipliers, 0 or more [force/length].
    """
    if g.max() <= 0:
        touching = np.flatnonzero(g == 0)
        return touching, np.zeros(touching.size)
    contact = np.empty(0, np.int64)
    for nodes in reversed(_pyramid(g)):
        high = nodes[g[nodes] > 0]
        contact = high[g[high] >= _SLACK * surface(lattice, contact, g[contact], high)]
        forces = _multipliers(lattice, contact, g[contact])
        while forces.min() < 0:
            contact = contact[forces >= 0]
            forces = _multipliers(lattice, contact, g[contact])
    return contact, forces


def _pyramid(g: Array) -> list[Nodes]:
    """Nodes of each level, finest (all nodes) first: the highest of each block of the level before.

    The coarsest level has a block at most.
    """
    levels = [np.arange(g.size)]
    while levels[-1].size > _BLOCK:
        nodes = levels[-1]
        missing = -nodes.size % _BLOCK  # the last block is filled up with its last node
        blocks = np.append(nodes, np.full(missing, nodes[-1])).reshape(-1, _BLOCK)
        highest = g[blocks].argmax(axis=1)
        levels.append(blocks[np.arange(len(blocks)), highest])
    return levels


def surface(lattice: Lattice, contact: Nodes, g: Array, at: Nodes) -> Array:
    """The free surface that is fixed at some nodes; far out it is flat.

    Parameters
    ----------
    lattice : Lattice
    contact : ndarray of int (m,)
        Those nodes, increasing.
    g : ndarray (m,)
        Their displacements [length].
    at : ndarray of int (n,)
        Nodes at which it is read.

    Returns
    -------
    ndarray (n,)
        u [length].
    """
    # On both sides a node at infinity, where u is 0.
    nodes = np.pad(contact.astype(float), 1)
    nodes[0] = -math.inf
    nodes[-1] = math.inf
    u = np.pad(g, 1)
    after = np.searchsorted(contact, at) + 1  # in `nodes`: the next one at `at` or to its right
    before = after - 1
    distance_before = at - nodes[before]
    distance_after = nodes[after] - at
    before_share, after_share, _ = shares(lattice.log_decay, distance_before, distance_after)
    return before_share * u[before] + after_share * u[after]


def _multipliers(lattice: Lattice, nodes: Nodes, u: Array) -> Array:
    """Forces p_i (m,) that hold m nodes, in increasing order, at u [force/length].

    A free surface between two nodes acts as a spring that ties them and one between each of them
    and the ground; a tail beside the outermost ones only as the latter.
    """
    links = np.diff(
        nodes, prepend=-math.inf, append=math.inf
    )  # before the first ... after the last
    tie, ground = lattice.surface_stiffnesses(links)
    tension = tie[1:-1] * (u[:-1] - u[1:])  # of the surfaces between the nodes
    from_neighbours = np.diff(tension, prepend=0.0, append=0.0)
    to_ground = lattice.spring_stiffness + ground[:-1] + ground[1:]
    return np.asarray(to_ground * u + from_neighbours)
