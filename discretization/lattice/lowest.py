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

Few starts need be asked. T_i(y) is the least cost of a surface from start i to the height y at some
z, as taut as the nodes between allow. Two of these do not cross, so that from the older start comes
more steeply: T_i - T_k grows with y if i is older than k. A start beaten by an older one is beaten
by it at all lower y, by a newer one at all higher y. As surfaces pass node j at 0 <= y <= y_j,

1. starts newer than the best one of node j are not needed beyond it. (Nor do they block any: a line
   from an older start that is above one of them, but not above the best one, is above node j.)
2. starts older than the best one at y = 0 are not needed beyond it, nor those blocked there, which
   a newer one beats. (Nor do these block any: lines above such a one fall below y = 0.)

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
_FEW = 32  # nodes after which it is looked again which starts are needed
_FAR = 600.0  # decay lengths


def global_minimum(lattice: Lattice, g: ArrayLike) -> tuple[Nodes, Proof]:
    """First and last node of each contact (m, 2) of lowest energy of all sets, and its proof.

    g (n,): d - f of nodes in a row; in the free tails beyond contact must be impossible. Of states
    whose energies agree within 1e-12 wΔx per contact that with more. ValueError if g is not finite.
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
    terms = np.array([*NodalEnergy(lattice, contact).balance(u).terms.values()])
    proof = Proof(float(force @ g[held]) / 2 + least, float(terms.sum()), float(abs(terms).sum()))
    return runs(contact), proof


def lowest_rings(lattice: Lattice, g: Array) -> Mask:
    """The nodes in contact (n,) of lowest energy around an axis, of heights g = d - f."""
    return _cheapest(lattice, -g, np.ones(g.size, bool))[1]


def _chain(lattice: Lattice, h: Array) -> tuple[Array, ...]:
    """ln P, -ln Q, c and h of all nodes, then of a place far beyond them, and one far before them.

    P and Q follow from what the free surface on each side of a node pulls with.
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
    grown, decayed = (np.append(place, (place[-1] + _FAR, -math.inf)) for place in places)
    return grown, decayed, *np.pad([(within + outside - spring) / 2, h], ((0, 0), (0, 2)))


def _costs(chain: tuple[Array, ...], value: Array, starts: Nodes, k: int, height: float) -> Array:
    """V of a surface at this height at node k from each of the starts, inf if one blocks another.

    Slopes are compared less that of a line from z = 0, so that nothing is lost in rounding.
    """
    own = chain[3][starts]
    grown, decayed = ((place[starts] - place[k]).astype(float) for place in chain[:2])
    whole = -np.expm1(grown + decayed)
    rise = height - own - np.expm1(decayed) * own
    cost = value[starts] + chain[2][k] * rise**2 / whole
    if starts.size > 1:
        slope = np.exp(decayed - decayed[-1]) * (height - own + np.expm1(grown) * height) / whole
        cost[slope < np.maximum.accumulate(slope[::-1])[::-1]] = math.inf
    return cost


def _cheapest(lattice: Lattice, h: Array, may: Mask) -> tuple[float, Mask]:
    """V of the tail that follows, and the nodes in contact, of drops of at most h.

    may: nodes that may be in contact; of a contact that is certain, h = 0, its ends are enough.
    """
    n, nodes, chain = h.size, np.flatnonzero(may), _chain(lattice, h)
    floor = min(0.0, float(h.min()))
    last = np.append(nodes[:1], nodes[:-1])
    linked = (nodes - last == 1) | (np.diff(np.cumsum(h > 0)[nodes], prepend=-1) == 0)
    bond = lattice.w * lattice.cell
    bonds = np.where(linked, bond * (nodes - last) * lattice.weight((nodes + last) / 2), 0.0)
    value, before, starts = np.full(n + 2, math.inf), np.full(n + 1, n), np.array([n + 1])
    value[n + 1] = 0.0
    for i, (k, gained) in enumerate([*zip(nodes.tolist(), bonds.tolist(), strict=True), (n, 0.0)]):
        if i % _FEW == 0:
            cost = _costs(chain, value, starts, k, floor)
            needed = np.isfinite(cost)
            needed[: cost.argmin()] = False  # statement 2
            starts = starts[needed]
        height = float(chain[3][k])
        cost = _costs(chain, value, starts, k, height)
        cost[-1] -= gained
        best = int(np.flatnonzero(cost <= cost.min() + _TIE * bond)[-1])
        value[k], before[k] = cost[best], starts[best]
        kept = best + 1 if height > floor else 0  # statement 1; none passes a certain contact
        starts = np.append(starts[:kept], k)
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
