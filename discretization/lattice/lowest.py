"""States of lowest energy on the lattice, with any number of contacts (small slopes, γ₁ > 0).

    min U[u] s.t. u >= g, over all u and all contact sets (`NodalEnergy`).

Certain contact. Without adhesion the minimum is the surface ū of obstacle.py. Any minimiser has
u <= ū: else min(u, ū) had less energy and no less contact, as the energy is submodular. So nodes in
contact in ū are in contact, and it is searched for the drop v = ū - u, 0 <= v <= h = ū - g.

The recursion. Along free nodes P_m = λ⁻ᵐ grows and Q_m = λᵐ decays. With z = P/Q and y = v/Q a free
surface between two contact nodes is a straight line below the nodes between, and costs

    C (y_j - y_i)²/(z_j - z_i) = c_j (h_j - h_i Q_j/Q_i)²/(1 - z_i/z_j).

A surface begins at z = y = 0 ("nothing precedes") and ends far out at v = 0 ("a tail follows"). The
least energy V_j that ends in contact node j is the least of V_i and that cost over all starts i,
less the adhesion of the links between if i and j are neighbours.

Few starts need be asked. Let T_i(y) be the least cost of a surface from start i to the height y at
some z, as taut as the nodes between allow. Two of these do not cross, so the one from the older
start arrives more steeply: T_i - T_k grows with y if i is older than k. A start beaten by an older
one is beaten by it at all lower y, and by a newer one at all higher y. As surfaces pass node j at
0 <= y <= y_j,

1. starts newer than the best one of node j are not needed beyond it. (Nor do they block any: a line
   from an older start that is above one of them, but not above the best one, is above node j.)
2. starts older than the best one at y = 0 are not needed beyond it, nor those blocked there, which
   a newer one beats. (Nor do these block any: lines above such a one fall below y = 0.)

So nothing is left out: V is the minimum but for rounding, and proves the state that attains it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.certificate import Proof
from discretization.equilibrium import Equilibrium
from discretization.lattice.assembly import Question, of_contacts
from discretization.lattice.oracle import Oracle
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.obstacle import pressed, surface
from discretization.nodes.row import Row
from energy import Scene

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_TIE = 1e-12  # of wΔx: what more contact may cost
_FEW = 32  # nodes after which it is looked again which starts are needed
_TINY = 1e-300  # what a node far away pulls with: only the sign of a slope is left
_FAR = 300.0  # decay lengths: exp(-2·300) is a number


def global_minimum(lattice: Lattice, g: ArrayLike) -> tuple[Nodes, Proof]:
    """First and last node of each contact (m, 2) of lowest energy of all sets, and its proof.

    g: (n,) heights d - f of nodes in a row. Beyond both ends are free tails; contact must be
    impossible there (see `window`). Of states whose energies agree within 1e-12 wΔx per contact the
    one with more contact. ValueError if g is empty or not finite.
    """
    g = np.asarray(g, float)
    if g.ndim != 1 or not g.size or not np.isfinite(g).all():
        raise ValueError(f"g of shape {g.shape} must be one row of finite values: pass d - f")
    every, (held, force) = np.arange(g.size), pressed(lattice, g)
    h = np.maximum(surface(lattice, held, g[held], every) - g, 0.0)
    h[held] = 0.0
    chain = _chain(lattice, h)
    least, before = _cheapest(chain, _TIE * lattice.w * lattice.cell)
    contact = h == 0
    contact[chain.node[_path(before)]] = True
    u = np.where(contact, g, surface(lattice, np.flatnonzero(contact), g[contact], every))
    terms = np.array([*NodalEnergy(lattice, contact).terms(u).values()])
    proof = Proof(float(force @ g[held]) / 2 + least, float(terms.sum()), float(abs(terms).sum()))
    return runs(contact), proof


class Chain(NamedTuple):
    """The nodes where contact may pay, then one far beyond all, and one far before them.

    place: in decay lengths; stiffness: c; height: h; bonds: what adheres in a contact from the
    node before to this one, 0 if there is something else between.
    """

    node: Nodes
    place: Array
    stiffness: float
    height: Array
    bonds: Array


def _chain(lattice: Lattice, h: Array) -> Chain:
    """Of a row of nodes with h = 0 only the first and the last."""
    zero = np.concatenate([[False], h == 0, [False]])
    inner = zero[:-2] & zero[1:-1] & zero[2:]
    node = np.flatnonzero((h <= lattice.deepest_contact) & ~inner)
    before = np.append(node[:1], node[:-1])
    linked = (node - before == 1) | (np.diff(np.cumsum(h > 0)[node], prepend=-1) == 0)
    bonds = np.where(linked, lattice.w * lattice.cell * (node - before), 0.0)
    place = np.append(lattice.log_decay * node, (0.0, -math.inf))
    place[-2] = place.max() + 2 * _FAR
    stiffness = lattice.spring / 2 + lattice.end_stiffness
    return Chain(
        node, place, stiffness, *(np.append(part, (0.0, 0.0)) for part in (h[node], bonds))
    )


def _costs(chain: Chain, value: Array, starts: Nodes, k: int, height: float) -> Array:
    """V of a surface at this height at node k from each of the starts, inf if one blocks another.

    Slopes are compared less that of a line from z = 0, so that nothing is lost in rounding.
    """
    own, reach = chain.height[starts], chain.place[starts] - chain.place[k]
    falls = np.expm1(reach)
    whole = -falls * (2 + falls)
    cost = value[starts] + chain.stiffness * (height - own - falls * own) ** 2 / whole
    if starts.size > 1:
        slope = np.exp(reach - reach[-1]) * (height - own + falls * height) / whole
        cost[slope < np.maximum.accumulate(slope[::-1])[::-1]] = math.inf
    return cost


def _cheapest(chain: Chain, tie: float) -> tuple[float, Nodes]:
    """V of the tail that follows, and from where each node is reached (-1: nothing precedes)."""
    n, starts = chain.node.size, np.array([-1])
    value, before = np.full(n + 2, math.inf), np.empty(n + 1, np.int64)
    value[-1] = 0.0
    for k in range(n + 1):
        if k % _FEW == 0:
            starts = _needed(chain, value, starts, k)
        height = float(chain.height[k])
        cost = _costs(chain, value, starts, k, height)
        cost[-1] -= chain.bonds[k]
        best = _newest(cost, tie)
        value[k], before[k] = cost[best], starts[best]
        kept = best + 1 if height else 0  # no span passes a node certainly in contact
        starts = np.append(starts[:kept], k)
    return float(value[n]), before


def _newest(cost: Array, tie: float) -> int:
    """Place of the least cost; the last, that of most contact, if it costs no more but a tie."""
    last = cost.size - 1
    best = last - int(cost[::-1].argmin())
    return last if cost[last] <= cost[best] + tie else best


def _needed(chain: Chain, value: Array, starts: Nodes, k: int) -> Nodes:
    """Those that may be best at node k or beyond (statement 2)."""
    cost = _costs(chain, value, starts, k, 0.0)
    best = _newest(cost, 0.0)
    return starts[best:][np.isfinite(cost[best:])]


def _path(before: Nodes) -> list[int]:
    """Nodes of the chain from the last contact back to the first."""
    path, k = [], int(before[-1])
    while k >= 0:
        path.append(k)
        k = int(before[k])
    return path


def runs(contact: NDArray[np.bool_]) -> Nodes:
    """First and last node of each contact (m, 2), of a mask of all nodes."""
    edges = np.diff(contact.astype(np.int8), prepend=0, append=0)
    return np.column_stack((np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1))


def window(row: Row, depth: float) -> tuple[int, Array]:
    """First node, and g = d - f from there on: outside these nodes no minimiser is in contact.

    The nodes with f <= d + D (`Lattice.deepest_contact`; h >= f - d), and all between; at least the
    lowest.
    """
    near = np.append(np.flatnonzero(row.f <= depth + row.lattice.deepest_contact), row.touch)
    start, stop = int(near.min()), int(near.max()) + 1
    return start, depth - row.f[start:stop]


def on_lowest(asked: Question, row: Row) -> Equilibrium:
    """Certified state of lowest energy of all contact sets on these nodes, with its proof.

    Method "shortest_path", "oracle", which needs cvxpy and has no proof, or "lattice": without
    adhesion obstacle.py, else as "shortest_path". ValueError for what the method cannot express,
    and a contact that reaches the end of the known profile.
    """
    nodes, proof = _lowest(row, asked.depth, asked.method)
    state = of_contacts(asked, row, tuple((first, last) for first, last in nodes.tolist()))
    return replace(state, proof=proof, method="shortest_path" if proof else asked.method)


def lowest_contacts(scene: Scene, depth: float, lattice: Lattice) -> Nodes:
    """First and last nodes (m, 2) of the contacts of lowest energy; of rings around an axis, too.

    scene: as far as it has nodes (`Lattice.seen`). ValueError as `on_lowest`.
    """
    row = Row.of(scene, lattice, depth)
    if lattice.axis == 0:
        return runs(lowest_rings(lattice, depth - row.f))
    return _lowest(row, depth, "lattice")[0] + row.first


def _lowest(row: Row, depth: float, method: str) -> tuple[Nodes, Proof | None]:
    """First and last nodes of the row, and the proof if there is one."""
    lattice, (start, g) = row.lattice, window(row, depth)
    if method == "oracle":
        g = np.append(g, -math.inf)  # it needs two nodes
        return runs(Oracle(lattice, g.size).solve(g).contact) + start, None
    if method == "lattice" and not lattice.w:
        contact = np.zeros(g.size, bool)
        contact[pressed(lattice, g)[0]] = True
        return runs(contact) + start, None
    contacts, proof = global_minimum(lattice, g)
    return contacts + start, proof


def lowest_rings(lattice: Lattice, g: Array) -> NDArray[np.bool_]:
    """The nodes in contact (n,) of lowest energy around an axis, of heights g = d - f.

    Let T_j be the least energy of a surface whose outermost contact node is j, with the free
    surface outside. From a contact node i to the next one, j, the surface that is held at i and
    free outside is lifted by g_j - τ_ij g_i there, τ_ij what is left of u_i at j, which costs a
    square:

        T_j = min over i of  T_i + (E_ij + κ_j + σ_j)/2 (g_j - τ_ij g_i)² - adhesion, if i = j - 1,

    κ_j + σ_j the stiffness of the spring at j and of the surface outside, E_ij that of the surface
    between with node i at rest. No node between is penetrated if g_m - τ_im g_i, times what a
    displacement of m pulls with at i, is nowhere larger before j: surfaces that leave i are ordered
    by their slopes. Where nothing is in contact before j, E is that of the disc inside, and
    u_i = 0. All of these follow node by node, for all i at once: n² numbers for n nodes.
    """
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
