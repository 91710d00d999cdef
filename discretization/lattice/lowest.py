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

Few starts need be compared. T_i(y) is the least cost of a surface from start i to the height y at
some z, as taut as the nodes between allow. Two of these do not cross, so that from the older start
comes more steeply: T_i - T_k grows with y if i is older than k. A start beaten by an older one is
beaten by it at all lower y, by a newer one at all higher y. So at each z every start that is still
needed has an interval of heights y of its own, higher ones for newer starts. As surfaces pass node
j at 0 <= y <= y_j,

1. starts newer than the best one of node j are not needed beyond it. (Nor do they block any: a line
   from an older start that is above one of them, but not above the best one, is above node j.)
2. starts whose interval lies below y = 0 are not needed.
3. Where nodes between do not count, starts i and k, the next newer one, cost the same at

       y = y_k + p (z - z_k) - √(A (z - z_i)(z - z_k)/(C (z_k - z_i))),
       p = (y_k - y_i)/(z_k - z_i),    A = V_i + C p² (z_k - z_i) - V_k >= 0,

   with C = c_j P_j Q_j, the same for all j. Above, k costs less, until line i-k, above which k
   blocks i. If these limits grow from each start to the next newer one they are the ends of the
   intervals: a surface from k below its limit passes below all newer nodes. If the limit of k is
   less than that of i, k has no interval and is dropped.
4. Slopes of lines from i that reach its interval only get less as z grows. So i is not needed above
   a line of the steepest slope that reached it before; nor does what is dropped block what is left.

Nodes are taken in blocks. At the first node of a block intervals are found for all starts; within
it a node is only compared with starts whose lines may reach it, from the newest on. The highest of
all older lines is known for each start, relative to a line through the block's first and last node.

So nothing is left out: V is the minimum but for rounding, and proves the state that attains it.

Rings around an axis. There ū is not known: v = -u is the drop below the flat surface and h = -g, so
that v is at least -max(g, 0) instead of 0. Nodes of that height are certain.
"""

import math
from typing import Any, NamedTuple

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
_FEW = 64  # nodes of a block, at least,
_SHARE = 32  # and one more for each so many starts: finding their intervals costs as much
_FAR = 40.0  # decay lengths, by which a tail has decayed to less than rounding
_FAINT = 100.0  # the same in which starts are not told apart by how far they are, but by energy
_SPAN = 300.0  # of ln z over a block: y² and z of its nodes do not overflow


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
    least, contact, _ = _cheapest(lattice, h, (h <= lattice.deepest_contact) & ~within)
    u = np.where(contact, g, surface(lattice, np.flatnonzero(contact), g[contact], every))
    terms = np.array([*NodalEnergy(lattice, contact).balance(u).terms.values()])
    proof = Proof(float(force @ g[held]) / 2 + least, float(terms.sum()), float(abs(terms).sum()))
    return runs(contact), proof


def lowest_rings(lattice: Lattice, g: Array) -> Mask:
    """The nodes in contact (n,) of lowest energy around an axis, of heights g = d - f."""
    return _cheapest(lattice, -g, np.ones(g.size, bool))[1]


def _chain(lattice: Lattice, size: int) -> tuple[Any, Any, Array]:
    """ln P and -ln Q of all nodes in long double, and c of them.

    P and Q follow from what the free surface on each side of a node pulls with.
    """
    every, last = np.arange(size), size - 1
    spring = lattice.spring * lattice.weight(every) * np.ones(size)
    link = lattice.link * lattice.weight(every[:last] + 0.5) * np.ones(last)
    outside, inside = spring + lattice.pull(every, 1), [float(spring[0] + lattice.pull(0, -1))]
    for own, one in zip(spring[1:].tolist(), link.tolist(), strict=True):
        inside.append(own + one * inside[-1] / (one + inside[-1]))
    within = np.array(inside)
    grown, decayed = (
        np.cumsum(np.log1p(np.append(0.0, each / link)), dtype=np.longdouble)
        for each in (within[:last], outside[1:])
    )
    return grown, decayed, np.asarray((within + outside - spring) / 2)


class _Ends:
    """Where free surfaces may end or begin: m nodes, from left to right, and two more places.

    These, with h = 0, are far beyond the nodes, where a tail that follows has decayed, and far
    before them, where nothing precedes.

    node: numbers (m,); h, log_y, log_z: drops, -ln Q and ln P/Q (m + 2,); stiffness: c (m,); step:
    energy of the contact, or of a free surface, from the node before to this one, then 0 (m + 1,).
    """

    def __init__(self, lattice: Lattice, h: Array, node: Nodes) -> None:
        grown, decayed, stiffness = _chain(lattice, h.size)
        log_y, log_z = decayed[node], (grown + decayed)[node]
        self.node, self.h = node, np.append(h[node], (0.0, 0.0))
        self.log_y = np.append(log_y, (log_y[-1] + _FAR, -math.inf))
        self.log_z = np.append(log_z, (log_z[-1] + 2 * _FAR, -math.inf))
        self.stiffness = stiffness[node]
        last = np.append(node[:1], node[:-1])
        certain = np.diff(np.cumsum(h > 0)[node], prepend=-1) == 0  # ends of a certain contact
        linked = (node - last == 1) | certain
        bonds = lattice.w * lattice.cell * (node - last) * lattice.weight((node + last) / 2)
        log_q, log_pq = (
            (each[:-2] - np.append(each[:1], each[:-3])).astype(float)
            for each in (self.log_y, self.log_z)
        )
        rise = h[node] - h[last] - np.expm1(-log_q) * h[last]
        with np.errstate(divide="ignore", invalid="ignore"):  # of the first nothing is before
            free = self.stiffness * rise**2 / -np.expm1(-log_pq)
        self.step = np.append(free - np.where(linked, bonds, 0.0), 0.0)

    def logs(self, which: Nodes, origin: int) -> tuple[Array, Array]:
        """ln y/h and ln z of some of them, in units in which y = h and z = 1 at the origin."""
        log_y = self.log_y[which] - self.log_y[origin]
        log_z = self.log_z[which] - self.log_z[origin]
        return log_y.astype(float), log_z.astype(float)


class _Start(NamedTuple):
    """A start seen from a block: place in `_Ends`, V, h, then y - h, z - 1, y as `_Ends.logs`."""

    which: int
    value: float
    h: float
    more: float
    z: float
    y: float


def _placed(ends: _Ends, which: Nodes, value: Array, origin: int) -> list[_Start]:
    """Starts as seen from an origin."""
    h, (log_y, log_z) = ends.h[which], ends.logs(which, origin)
    more, y = h * np.expm1(log_y), h * np.exp(log_y)
    columns = which, value, h, more, np.expm1(log_z), y
    return list(map(_Start, *(column.tolist() for column in columns)))


def _limits(ends: _Ends, starts: Nodes, value: Array, origin: int) -> tuple[Nodes, Array]:
    """Which of the starts are not dropped, and up to which height they are needed at the origin.

    Of the newest that is inf. Differences are those of neighbours, so that no digits are lost.
    """
    c, h = float(ends.stiffness[origin]), ends.h[starts]
    log_y, log_z = ends.logs(starts, origin)
    ahead = -np.expm1(log_z)
    near, z = np.exp(np.maximum(log_y, -_FAINT)), np.exp(np.maximum(log_z, -2 * _FAINT))
    y, dz = near * h, z[1:] * -np.expm1(log_z[:-1] - log_z[1:])
    dy = near[1:] * (np.diff(h) - np.expm1(log_y[:-1] - log_y[1:]) * h[:-1])
    lost = np.maximum(c * dy * (dy / dz) - np.diff(value), 0.0)
    cut = np.sqrt(lost / c / dz * ahead[:-1] * ahead[1:])
    limit = np.append(y[1:] + dy / dz * ahead[1:] - cut, math.inf)
    older, newer = np.arange(starts.size) - 1, np.arange(starts.size) + 1
    left = np.full(starts.size, True)
    todo = (np.flatnonzero(limit[:-1] > limit[1:]) + 1).tolist()
    while todo:
        k = todo.pop()
        i, j = int(older[k]), int(newer[k])
        if not left[k] or i < 0 or j == starts.size or limit[i] <= limit[k]:
            continue
        left[k], newer[i], older[j] = False, j, i
        dy[i], dz[i] = rise, run = float(dy[i] + dy[k]), float(dz[i] + dz[k])
        more = max(c * rise * (rise / run) - float(value[j] - value[i]), 0.0)
        off = math.sqrt(more / c / run * float(ahead[i] * ahead[j]))
        limit[i] = float(y[j]) + rise / run * float(ahead[j]) - off
        todo += [i, j]
    found = np.flatnonzero(left)
    return found, limit[found]


def _cheapest(lattice: Lattice, h: Array, may: Mask) -> tuple[float, Mask, int]:
    """V of the tail that follows, and the nodes in contact, of drops of at most h.

    may: nodes that may be in contact; of a contact that is certain, h = 0, its ends are enough.
    Also how many surfaces were compared.
    """
    if not may.any():
        return 0.0, h == 0, 0
    ends, floor = _Ends(lattice, h, np.flatnonzero(may)), min(0.0, float(h.min()))
    size, tie = ends.node.size + 1, _TIE * lattice.w * lattice.cell
    before, starts, value = np.full(size, size), np.array([size]), np.zeros(1)
    place, first, compared = ends.log_z[:size].astype(float), 0, 0
    while first < size:
        most = _FEW + starts.size // _SHARE
        stop = min(first + most, int(place.searchsorted(place[first] + _SPAN)), size - 1)
        if stop < size - 1:
            stop = min(stop, int(ends.node.searchsorted(ends.node[first] + 2 * most)))
        else:
            stop = size
        compared += starts.size
        block = _Block(ends, first, stop, floor, tie)
        starts, value = block.passed(starts, value)
        before[first:stop], first = block.before, stop
        compared += block.compared
    contact, k = h == floor, int(before[-1])
    while k < size:
        contact[ends.node[k]] = True
        k = int(before[k])
    return float(value[-1]), contact, compared


class _Block:
    """Nodes that are passed one after the other, from first to stop - 1 of `_Ends`.

    before: the start of the best surface to each; compared: how many surfaces were compared.
    """

    def __init__(self, ends: _Ends, first: int, stop: int, floor: float, tie: float) -> None:
        self.ends, self.first, self.stop, self.floor, self.tie = ends, first, stop, floor, tie
        self.before, self.compared = list[int](), 0
        which = np.arange(first, stop)
        self.nodes = _placed(ends, which, ends.step[first:stop], first)
        self.end = self.nodes[-1].z
        self.shear = (self.nodes[-1].y - self.nodes[0].y) / self.end if self.end else 0.0

    def passed(self, starts: Nodes, value: Array) -> tuple[Nodes, Array]:
        """Starts that may be needed beyond the block, and their V, of those before it."""
        own, limit = _limits(self.ends, starts, value, self.first)
        lowest = int(limit.searchsorted(self.floor))
        own, limit = own[lowest:], limit[lowest:]
        starts, value = starts[own], value[own]
        h, (log_y, log_z) = self.ends.h[starts], self.ends.logs(starts, self.first)
        slope = (limit - h * np.exp(log_y)) / -np.expm1(log_z)
        further = limit[:-1] + (slope[:-1] - self.shear) * self.end
        reach = np.append(np.maximum(limit[:-1], further), math.inf)
        reach = np.maximum.accumulate(reach)
        least = min(y - self.shear * z for _, _, _, _, z, y in self.nodes)
        deep = int(reach.searchsorted(least))
        near = _placed(self.ends, starts[deep:], value[deep:], self.first)
        if self.follow(near, slope[deep:].tolist(), reach[deep:].tolist()):
            deep = 0
        which, found, *_ = zip(*near, strict=True)
        return np.append(starts[:deep], which), np.append(value[:deep], found)

    def follow(self, near: list[_Start], steepest: list[float], reach: list[float]) -> bool:
        """Pass the nodes with these starts, which change. Returns whether none passes one of them.

        steepest, reach: slopes and sheared heights above which a start is not needed; the latter
        the largest of all older starts.
        """
        c, shear, tie, none = float(self.ends.stiffness[self.first]), self.shear, self.tie, False
        for k, (node, step, h, more, z, y) in enumerate(self.nodes):
            if k and len(near) > 1:
                self._bound(near, steepest, reach, z)
            at, base, least, best = y - shear * z, math.inf, math.inf, 0
            newest = j = len(near) - 1
            while j >= 0 and reach[j] >= at:
                _, value, own_h, own_more, own_z, own_y = near[j]
                rise = (h - own_h) + (more - own_more)
                slope = rise / (z - own_z)
                height = own_y - slope * (1 + own_z)  # of the line at z = 0
                if height <= base:  # no newer one is above it
                    base = height
                    cost = value + (step if j == newest and node else c * rise * slope)
                    if slope <= steepest[j] and cost < least - tie:
                        least, best = cost, j
                j -= 1
            self.compared += newest - j
            self.before.append(near[best].which)
            if h <= self.floor:  # nothing passes a certain contact
                best, none = -1, True
            del near[best + 1 :], steepest[best + 1 :], reach[best + 1 :]
            near.append(_Start(node, least, h, more, z, y))
            steepest.append(math.inf)
            reach.append(math.inf)
        return none

    def _bound(
        self, near: list[_Start], steepest: list[float], reach: list[float], z: float
    ) -> None:
        """What the newest start leaves of the one before it, at the next node."""
        c, one, other = float(self.ends.stiffness[self.first]), near[-2], near[-1]
        rise, run = (other.h - one.h) + (other.more - one.more), other.z - one.z
        lost = max(one.value + c * rise * (rise / run) - other.value, 0.0)
        slope = rise / run - math.sqrt(lost / c / run * (z - other.z) / (z - one.z))
        limit = one.y + slope * (z - one.z) - self.shear * z
        further = limit + (slope - self.shear) * (self.end - z)
        steepest[-2] = slope
        reach[-2] = max(limit, further, reach[-3] if len(reach) > 2 else -math.inf)


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
