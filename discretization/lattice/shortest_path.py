"""Global minimum of the lattice energy over all contact sets: a shortest path over contact nodes.

    min U[u] s.t. u >= g, over all u and all contact sets (`NodalEnergy`); γ₁ > 0, w >= 0.

1. w = 0 is convex; its solution ū is that of obstacle.py. Every minimiser for w > 0 has u <= ū
   (maximum principle), so the contact nodes of ū are in contact in each of them.
2. In the drop v = ū - u, 0 <= v <= h = ū - g, the energy is U[ū] + Q(v) - wΔx·(contact links), Q
   the same springs and links. Let V_j be the least energy that ends in contact node j and a tail
   beyond it. A span of T links from contact node i replaces the tail at the cost of a square,

       V_j = min_i V_i + K_T (h_j - λᵀh_i)² - wΔx [T = 1],      K_T = t sinh μ/(1 - λ²ᵀ),

   or nothing precedes j: V = 0, T = ∞. The span is admissible iff it stays above g: its slope at i,
   p = K_T (h_j - λᵀh_i) exp(-μT), must not exceed the p of any node between.
3. Optimal spans never cross. So a start i that an older one beats at v = h_j is beaten for good,
   and of those left only a few need be compared for a node (starts.py).
4. Nodes that are certainly in contact, or never, are known beforehand (bounds.py); from here on ū
   is the surface held at the former, and the latter are left out: v < h there in every minimiser.

The recursion is exact but for rounding; a node takes a dozen looks at a start, however many left.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.certificate import Proof
from discretization.lattice import fronts, span
from discretization.lattice.bounds import certain, deepest_contact, may_pay
from discretization.lattice.nodal_energy import NodalEnergy
from discretization.lattice.nodes import Lattice
from discretization.lattice.recursion import Chain, Paths, shortest, without_adhesion
from discretization.lattice.starts import NOWHERE, Ends
from energy import Indenter

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]
_RIDGE = 1e-9  # of wΔx: what a node costs more than one it shields
_ENDLESS = 2.0**60  # links: the start "nothing precedes" is further than any node
MOST = 10**8  # nodes of a window on either side


@dataclass(frozen=True, eq=False)
class GlobalMinimum:
    """State of lowest energy: contacts (m, 2), first and last node of each; energy; its proof."""

    lattice: Lattice
    g: Array
    contacts: Nodes
    energy: float
    proof: Proof

    @property
    def in_contact(self) -> Mask:
        """(n,) whether a node is in contact."""
        return span.mask_of(self.g.size, self.contacts)

    def u(self) -> Array:
        """Displacements (n,): g in contact, free spans and tails elsewhere."""
        return span.displacement(self.lattice, self.g, self.in_contact)


def global_minimum(lattice: Lattice, g: ArrayLike) -> GlobalMinimum:
    """Lowest energy of all contact sets of n nodes in a row with g = d - f (n,).

    Beyond both ends are free tails; contact must be impossible there (see `window`). Of states
    whose energies agree within 1e-12 wΔx per contact the one with more contact. ValueError if
    γ₁ = 0 or g is empty or not finite.
    """
    if not lattice.gamma1:
        raise ValueError("gamma1 = 0.0 leaves the springs independent: use `fronts.held`")
    g = np.array(g, float)
    if g.ndim != 1 or not g.size or not np.isfinite(g).all():
        raise ValueError(f"g of shape {g.shape} must be one row of finite values: pass d - f")
    g.flags.writeable = False
    held, h = certain(lattice, g)
    chain = _chain(lattice, h)
    paths = shortest(lattice, chain)
    contacts = _contacts(chain, paths)
    mask = span.mask_of(g.size, contacts)
    terms = NodalEnergy(lattice, mask).terms(span.displacement(lattice, g, mask)).values()
    proof = Proof(
        bound=span.energy(lattice, g, held) + paths.least,
        attained=float(sum(terms)),
        scale=float(sum(abs(term) for term in terms)),
        find_margin=functools.partial(_margin, lattice, chain, contacts, paths),
    )
    return GlobalMinimum(lattice, g, contacts, proof.attained, proof)


def window(lattice: Lattice, indenter: Indenter, depth: float) -> tuple[int, Array]:
    """First node, and g = d - f from there on: outside these nodes no minimiser is in contact.

    The nodes with f <= d + D (bounds.py; h >= f - d), and all between; at least the lowest.
    ValueError if these are more than 1e8 on a side.
    """
    where = fronts.region(lattice, indenter, depth)
    limit = depth + deepest_contact(lattice)
    left, right = (_reaching(lattice, indenter, where, end, limit) for end in where[:2])
    return where.lowest - left.size + 1, depth - np.concatenate([left[:0:-1], right])


def _reaching(
    lattice: Lattice, indenter: Indenter, where: fronts.Region, end: int, limit: float
) -> Array:
    """Heights from the lowest node towards `end` up to the last one within the limit."""
    parts, count, size = [], 1, 1
    for start, f in fronts.blocks(lattice, indenter, where.lowest, end):
        parts.append(f if start == where.lowest else f[1:])
        size = abs(start - where.lowest) + f.size
        if size > MOST:
            raise ValueError(
                f"spacing = {lattice.spacing!r} puts more than {MOST} nodes where contact is to be "
                "looked for; give a larger spacing, or a profile of smaller extent"
            )
        inside = np.flatnonzero(f <= limit)
        if inside.size:
            count = size - f.size + int(inside[-1]) + 1
        if (indenter.apex is not None or indenter.convex) and f[-1] > limit:
            break
    return np.concatenate(parts)[:count]


def _chain(lattice: Lattice, h: Array) -> Chain:
    """Nodes where contact may pay; of a row of nodes with h = 0 only the first and the last."""
    zero = np.concatenate([[False], h == 0, [False]])
    inner = zero[:-2] & zero[1:-1] & zero[2:]
    node = np.flatnonzero(may_pay(lattice, h) & ~inner)
    links = np.diff(node, prepend=NOWHERE)
    lifted = np.diff(np.cumsum(h > 0)[node], prepend=-1) > 0
    links[(links > 1) & lifted] = 0
    return Chain(node, h[node], links.astype(float))


def _contacts(chain: Chain, paths: Paths) -> Nodes:
    """First and last node of each contact on the shortest path, (m, 2)."""
    path, j = [], paths.last
    while j >= 0:
        path.append(j)
        j = int(paths.before[j])
    at = np.array(path[::-1], np.int64)
    parted = (np.diff(at) > 1) | (chain.links[at[1:]] == 0)
    ends = np.concatenate([[True], parted, [True]])[: at.size + 1]
    return chain.node[np.stack([at[ends[:-1]], at[ends[1:]]], axis=1)]


def _margin(lattice: Lattice, chain: Chain, contacts: Nodes, paths: Paths) -> float:
    """Energy of the best state of another topology (`Proof`) above the minimum."""
    n, back, ends = chain.node.size, chain.reversed(), np.searchsorted(chain.node, contacts)
    loose = [pair for pair in ends.tolist() if chain.depth[pair[0] : pair[1] + 1].all()]
    mirrored = shortest(lattice, back, {n - 1 - last for _, last in loose})
    beyond = mirrored.value[::-1] - span.unit(lattice) * chain.depth**2
    others = [
        _elsewhere(lattice, chain, paths.value + beyond, ends),
        _merged(lattice, chain, paths.value, beyond, ends),
        _opened(lattice, chain, paths, mirrored, loose),
    ]
    return max(0.0, min(others) - paths.least)


def _elsewhere(lattice: Lattice, chain: Chain, touching: Array, ends: Nodes) -> float:
    """Least energy that touches a free node which is shielded on both sides."""
    at = np.flatnonzero(~span.mask_of(chain.node.size, ends))
    gap = np.searchsorted(ends[:, 0], at)
    energy, parted = touching[at], np.append(chain.links, 0) == 0
    left = span.running_max(np.where(parted[at], math.inf, energy), gap)
    right = np.where(parted[at + 1], math.inf, energy)[::-1]
    right = span.running_max(right, len(ends) - gap[::-1])[::-1]
    shielded = energy + _RIDGE * lattice.w * lattice.spacing < np.minimum(left, right)
    return float(energy[shielded].min(initial=math.inf))


def _merged(lattice: Lattice, chain: Chain, value: Array, beyond: Array, ends: Nodes) -> float:
    """Least energy that touches all nodes between two contacts."""
    if len(ends) < 2:
        return math.inf
    rise = np.diff(chain.depth) + lattice.loss * chain.depth[:-1]
    cost = span.stiffness(lattice, np.ones(1)) * rise**2 - lattice.w * lattice.spacing
    cost[chain.links[1:] == 0] = math.inf
    gaps = np.column_stack([ends[:-1, 1], ends[1:, 0]])
    closed = np.add.reduceat(np.append(cost, 0.0), gaps.ravel())[::2]
    return float((value[gaps[:, 0]] + closed + beyond[gaps[:, 1]]).min())


def _opened(
    lattice: Lattice, chain: Chain, paths: Paths, mirrored: Paths, loose: list[list[int]]
) -> float:
    """Least energy in which one of the loose contacts, first and last in the chain, is silent."""
    if not loose:
        return math.inf
    n, back, best = chain.node.size, chain.reversed(), math.inf
    near = _with_certain(chain, [first for first, _ in loose])
    part = Chain(chain.node[near], chain.depth[near], chain.links[near])
    there = np.searchsorted(near, [first for first, _ in loose]).tolist()
    again = shortest(lattice, part, set(there))
    for (first, last), start in zip(loose, there, strict=True):
        core = first + int(np.argmin(chain.depth[first : last + 1]))
        left = without_adhesion(lattice, part, again, start, start + core - first)
        right = without_adhesion(lattice, back, mirrored, n - 1 - last, n - 1 - core)
        parted = left[0] + right[0] - span.unit(lattice) * float(chain.depth[core]) ** 2
        over = _over(lattice, left[1], right[1], int(chain.node[core]))
        shift = float(paths.value[first] - again.value[start])
        best = min(best, min(parted, over) + shift)
    return best


def _with_certain(chain: Chain, places: list[int]) -> Nodes:
    """The nodes from the certain one before each of these places to the next certain one.

    No span passes a certain node, so that V follows from there but for a constant.
    """
    stretch = np.cumsum(chain.depth == 0)
    wanted = np.zeros(int(stretch[-1]) + 1, bool)
    wanted[stretch[places]] = True
    return np.flatnonzero(wanted[stretch])


def _over(lattice: Lattice, left: Ends, right: Ends, x: int) -> float:
    """Least energy with one span over node x, from a start on its left to one on its right."""
    mu, unit = lattice.log_decay, span.unit(lattice)
    p, q = (np.abs(float(x) - side * s.node) for side, s in ((1, left), (-1, right)))
    p, q = (np.where(links > _ENDLESS, math.inf, links) for links in (p, q))
    best = math.inf
    for T, value, depth, slope in zip(p, left.value, left.depth, left.slope, strict=True):
        drop = -span.excess(lattice, T, q, depth, np.zeros(q.size), right.depth)
        near = span.stiffness(lattice, T) * (drop - math.exp(-mu * T) * depth) <= slope
        far = span.stiffness(lattice, q) * (drop - np.exp(-mu * q) * right.depth) <= right.slope
        rise = right.depth - np.exp(-mu * (T + q)) * depth
        total = value + right.value - unit * right.depth**2
        total += span.stiffness(lattice, T + q) * rise**2
        best = min(best, float(total[near & far].min(initial=math.inf)))
    return best
