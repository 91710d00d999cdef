"""States of lowest energy on the lattice, with any number of contacts (small slopes, γ₁ > 0).

    min U[u] s.t. u >= g, over all u and all contact sets (`NodalEnergy`).

Certain contact. Without adhesion the minimum is the surface ū of obstacle.py. Any minimiser has
u <= ū: else min(u, ū) had less energy and no less contact, as the energy is submodular. So nodes in
contact in ū are in contact, and it is searched for the drop v = ū - u, 0 <= v <= h = ū - g.

The recursion. Along free nodes P grows and Q decays; λ⁻ᵐ and λᵐ for a line contact. With z = P/Q
and y = v/Q a free surface between two contact nodes is a straight line below the nodes between. To
reach contact node j from node i costs, more than the free surface beyond node i does,

    c_j (h_j - h_i Q_j/Q_i)²/(1 - z_i/z_j),     2 c_j the stiffness of the surface at node j.

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
3. starts older than the best one of node e are not needed by nodes j before e: its surface to e
   passes node j at y <= y_j, and an older one that is better there were better at e, too.

So nothing is left out: V is the minimum but for rounding, and proves the state that attains it.

Rings around an axis. There ū is not known: v = -u is the drop below the flat surface and h = -g, so
that v is at least -max(g, 0) instead of 0. Nodes of that height are certain.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from discretization.certificate import Proof
from discretization.lattice.oracle import oracle
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.obstacle import pressed, surface
from discretization.nodes.row import Contacts, Row
from energy import Scene
from energy.arrays import Array, Mask, Nodes

_TIE = 1e-12  # of wΔx: what more contact may cost
_FEW = 32  # nodes that are asked for at once
_FAR = 600.0  # decay lengths


def global_minimum(lattice: Lattice, g: ArrayLike) -> tuple[Nodes, Proof]:
    """First and last node of each contact (m, 2) of lowest energy of all sets, and its proof.

    g: (n,) heights d - f of nodes in a row. Beyond both ends are free tails, where contact must be
    impossible. Of states whose energies agree within 1e-12 wΔx per contact the one with more
    contact. ValueError if g is empty or not finite.
    """
    g = np.asarray(g, float)
    if g.ndim != 1 or not g.size or not np.isfinite(g).all():
        raise ValueError(f"g of shape {g.shape} must be one row of finite values: pass d - f")
    every, (held, force) = np.arange(g.size), pressed(lattice, g)
    h = np.maximum(surface(lattice, held, g[held], every) - g, 0.0)
    h[held] = 0.0
    zero = np.pad(h == 0, 1)
    within = zero[:-2] & zero[1:-1] & zero[2:]  # contacts that are certain
    least, contact = _cheapest(lattice, h, (h <= lattice.deepest_contact) & ~within)
    u = np.where(contact, g, surface(lattice, np.flatnonzero(contact), g[contact], every))
    terms = np.array([*NodalEnergy(lattice, contact).terms(u).values()])
    proof = Proof(float(force @ g[held]) / 2 + least, float(terms.sum()), float(abs(terms).sum()))
    return runs(contact), proof


def lowest_rings(lattice: Lattice, g: Array) -> Mask:
    """The nodes in contact (n,) of lowest energy around an axis, of heights g = d - f."""
    return _cheapest(lattice, -g, np.ones(g.size, bool))[1]


def _chain(lattice: Lattice, h: Array) -> tuple[Array, ...]:
    """ln P, -ln Q, c and h of all nodes, then of a place far beyond them, and one far before them.

    P and Q follow from what the free surface on each side of a node pulls with; of the logarithms
    what rounding takes from them, too.
    """
    every, last = np.arange(h.size), h.size - 1
    spring = lattice.spring * lattice.weight(every) * np.ones(h.size)
    link = lattice.link * lattice.weight(every[:last] + 0.5) * np.ones(last)
    outside, inside = spring + lattice.pull(every, 1), [float(spring[0] + lattice.pull(0, -1))]
    for own, one in zip(spring[1:].tolist(), link.tolist(), strict=True):
        inside.append(own + one * inside[-1] / (one + inside[-1]))
    within = np.array(inside)
    places = (
        np.cumsum(np.log1p(np.append(0.0, each / link)), dtype=np.longdouble)
        for each in (within[:last], outside[1:])
    )
    ends = (np.append(place, (place[-1] + _FAR, -_FAR)) for place in places)
    grown, decayed = (np.array([place, place - place.astype(float)], float) for place in ends)
    return grown, decayed, *np.pad([(within + outside - spring) / 2, h], ((0, 0), (0, 2)))


def _costs(chain: tuple[Array, ...], starts: Nodes, nodes: Nodes, height: Array) -> Array:
    """What surfaces at heights at nodes (t,) cost more than V of each of the starts (t, s).

    It is inf for what does not start before the node, or if another start blocks it. Slopes are
    compared less that of a line from z = 0, so that nothing is lost in rounding.
    """
    own, height = chain[3][starts], height[:, None]
    apart = (place[:, None, starts] - place[:, nodes, None] for place in chain[:2])
    grown, decayed = (place + rounding for place, rounding in apart)
    before = grown < 0
    grown[~before] = decayed[~before] = -math.inf
    less, lost, above = np.expm1(grown), np.expm1(decayed), height - own
    whole = -(less + lost + less * lost)
    nearest = np.maximum(decayed.max(axis=1, keepdims=True), -_FAR)
    slope = np.exp(decayed - nearest) * (above + less * height) / whole
    slope[~before] = -math.inf
    blocked = slope < np.maximum.accumulate(slope[:, ::-1], axis=1)[:, ::-1]
    cost = chain[2][nodes, None] * (above - lost * own) ** 2 / whole
    cost[blocked | ~before] = math.inf
    return np.asarray(cost)


def _cheapest(lattice: Lattice, h: Array, may: Mask) -> tuple[float, Mask]:
    """V of the tail that follows, and the nodes in contact, of drops of at most h.

    may: nodes that may be in contact; of a contact that is certain, h = 0, its ends are enough.
    """
    n, nodes, chain = h.size, np.flatnonzero(may), _chain(lattice, h)
    floor, bond = min(0.0, float(h.min())), lattice.w * lattice.cell
    last = np.append(nodes[:1], nodes[:-1])
    linked = (nodes - last == 1) | (np.diff(np.cumsum(h > 0)[nodes], prepend=-1) == 0)
    gained = np.where(linked, bond * (nodes - last) * lattice.weight((nodes + last) / 2), 0.0)
    value, before, starts = np.full(n + 2, math.inf), np.full(n + 1, n), np.array([n + 1])
    value[n + 1], nodes, gained = 0.0, np.append(nodes, n), np.append(gained, 0.0)
    for first in range(0, nodes.size, _FEW):
        own = nodes[first : first + _FEW]
        height, ends = chain[3][own], np.array([floor, chain[3][own[-1]]])
        costs = _costs(chain, np.append(starts, own), own[[0, -1]], ends)
        low, high = value[starts] + costs[:, : starts.size]
        needed = np.isfinite(low)
        needed[: low.argmin()] = False  # statement 2
        asked = needed & (np.arange(starts.size) >= high.argmin())  # statement 3
        around = np.append(starts[asked], own)
        known, costs = value[around], _costs(chain, around, own, height)
        for i, k in enumerate(own.tolist()):
            at = around.size - own.size + i
            cost = known + costs[i]
            cost[at - 1] -= gained[first + i]
            best = int(np.flatnonzero(cost <= cost.min() + _TIE * bond)[-1])
            value[k] = known[at] = cost[best]
            before[k] = around[best]
            known[best + 1 if height[i] > floor else 0 : at] = math.inf  # statement 1
        kept = starts[needed & ~asked] if height.min() > floor else starts[:0]
        starts = np.append(kept, around[np.isfinite(known)])
    contact, k = h == floor, int(before[n])
    while k < n:
        contact[k] = True
        k = int(before[k])
    return float(value[n]), contact


def runs(contact: Mask) -> Nodes:
    """First and last node of each contact (m, 2), of a mask of all nodes."""
    return np.flatnonzero(np.diff(np.pad(contact, 1))).reshape(-1, 2) - (0, 1)


def on_lowest(row: Row, depth: float, method: str) -> tuple[Contacts, Proof | None]:
    """Contacts of lowest energy of all contact sets on these nodes, and its proof.

    Method "shortest_path", "oracle", which needs cvxpy and has no proof, or "lattice", which is as
    "shortest_path". ValueError for what the method cannot express.
    """
    lattice, g, proof = row.lattice, depth - row.f, None
    if method == "oracle":
        near = np.append(np.flatnonzero(g >= -lattice.deepest_contact), row.touch)
        start = int(near.min())
        g = np.append(g[start : near.max() + 1], -math.inf)  # it needs two nodes
        contacts = runs(oracle(lattice, g).contact) + start
    else:
        contacts, proof = global_minimum(lattice, g)
    return tuple((first, last) for first, last in contacts.tolist()), proof


def lowest_contacts(scene: Scene, depth: float, lattice: Lattice) -> Nodes:
    """First and last nodes (m, 2) of the contacts of lowest energy; of rings around an axis, too.

    scene: as far as it has nodes (`Lattice.seen`). ValueError as `on_lowest`.
    """
    row = Row.of(scene, lattice, depth)
    g, turned = depth - row.f, lattice.axis == 0
    found = runs(lowest_rings(lattice, g)) if turned else global_minimum(lattice, g)[0]
    return found + row.first
