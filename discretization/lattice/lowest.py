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

from discretization.certificate import DECAYED, Proof
from discretization.lattice.oracle import oracle
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.obstacle import pressed, surface
from discretization.nodes.row import Contacts, Row
from energy import Scene
from energy.arrays import Array, Mask, Nodes


class Search(NamedTuple):
    """How the search over contact sets is divided; no result depends on it but by ties.

    Attributes
    ----------
    tie : float
        Of wΔx: what a state with more contact may cost more.
    block : int
        Nodes of a block at least,
    starts_per_node : int
        and one more for so many starts: finding the intervals of all starts costs about as much as
        following them over the block.
    faint : float
        Decay lengths after which starts are distinguished by energy alone, not by how far they are.
    span : float
        Of ln z over a block: y² and z of its nodes, at most e⁶⁰⁰, do not overflow.
    """

    tie: float = 1e-12
    block: int = 64
    starts_per_node: int = 32
    faint: float = 100.0
    span: float = 300.0


_SEARCH = Search()


def global_minimum(lattice: Lattice, g: ArrayLike) -> tuple[Nodes, Proof]:
    """The contacts of lowest energy of all contact sets, and the proof.

    Of states whose energies agree within 1e-12 wΔx per contact that with more.

    Parameters
    ----------
    lattice : Lattice
    g : array_like (n,)
        d - f of nodes in a row; in the free tails beyond contact must be impossible [length].

    Returns
    -------
    contacts : ndarray of int (m, 2)
        First and last node of each contact.
    proof : Proof

    Raises
    ------
    ValueError
        If g is not finite.
    """
    g = np.asarray(g, float)
    if g.ndim != 1 or not g.size or not np.isfinite(g).all():
        raise ValueError(f"g of shape {g.shape} must be one row of finite values: pass d - f")
    every = np.arange(g.size)
    certain, force = pressed(lattice, g)  # contact without adhesion
    h = np.maximum(surface(lattice, certain, g[certain], every) - g, 0.0)
    h[certain] = 0.0
    zero = np.pad(h == 0, 1)
    inside_certain = zero[:-2] & zero[1:-1] & zero[2:]
    may = (h <= lattice.deepest_contact) & ~inside_certain
    least, contact, _ = _cheapest(lattice, h, may)
    u = np.where(contact, g, surface(lattice, np.flatnonzero(contact), g[contact], every))
    terms = np.array([*NodalEnergy(lattice, contact).balance(u).terms.values()])
    bound = float(force @ g[certain]) / 2 + least
    return runs(contact), Proof(bound, float(terms.sum()), float(abs(terms).sum()))


def lowest_rings(lattice: Lattice, g: Array) -> Mask:
    """The nodes in contact (n,) of lowest energy around an axis, of heights g = d - f."""
    return _cheapest(lattice, -g, np.ones(g.size, bool))[1]


def _chain(lattice: Lattice, size: int) -> tuple[Any, Any, Array]:
    """ln P and -ln Q of all nodes in long double, and c of them.

    P and Q follow from the stiffness s of what is on one side of a node, its own spring included:
    over a link t to the next node a free surface grows by the factor 1 + s/t.
    """
    every = np.arange(size)
    last = size - 1
    spring = lattice.spring_stiffness * lattice.weight(every) * np.ones(size)
    link = lattice.link_stiffness * lattice.weight(every[:last] + 0.5) * np.ones(last)
    right_side = spring + lattice.tail_stiffness(every, 1)
    stiffnesses = [float(spring[0] + lattice.tail_stiffness(0, -1))]
    for own, tie in zip(spring[1:].tolist(), link.tolist(), strict=True):
        in_series = tie * stiffnesses[-1] / (tie + stiffnesses[-1])
        stiffnesses.append(own + in_series)
    left_side = np.array(stiffnesses)

    growth = np.append(0.0, left_side[:last] / link)
    decay = np.append(0.0, right_side[1:] / link)
    log_p = _running_sum(np.log1p(growth))
    minus_log_q = _running_sum(np.log1p(decay))
    return log_p, minus_log_q, np.asarray((left_side + right_side - spring) / 2)


def _running_sum(terms: Array) -> Any:
    """Running sum in long double."""
    return np.cumsum(terms, dtype=np.longdouble)


class _Ends:
    """Where free surfaces may end or begin: m nodes, from left to right, and two more places.

    These, with h = 0, are far beyond the nodes, where a tail that follows has decayed, and far
    before them, where nothing precedes.

    Attributes
    ----------
    node : ndarray of int (m,)
        Numbers of the nodes.
    h : ndarray (m + 2,)
        Drops [length].
    log_y, log_z : ndarray (m + 2,)
        -ln Q and ln P/Q, in long double.
    stiffness : ndarray (m,)
        c.
    step : ndarray (m + 1,)
        Energy of the contact, or of a free surface, from the node before to this one, then 0.
    """

    def __init__(self, lattice: Lattice, h: Array, node: Nodes) -> None:
        log_p, minus_log_q, stiffness = _chain(lattice, h.size)
        log_y = minus_log_q[node]
        log_z = (log_p + minus_log_q)[node]
        self.node = node
        self.h = np.append(h[node], (0.0, 0.0))
        self.log_y = np.append(log_y, (log_y[-1] + DECAYED, -math.inf))
        self.log_z = np.append(log_z, (log_z[-1] + 2 * DECAYED, -math.inf))
        self.stiffness = stiffness[node]
        self.step = np.append(self._steps(lattice, h), 0.0)

    def _steps(self, lattice: Lattice, h: Array) -> Array:
        """Energy of what is between each node and the one before (m,)."""
        node = self.node
        last = np.append(node[:1], node[:-1])
        certain = np.diff(np.cumsum(h > 0)[node], prepend=-1) == 0  # ends of a certain contact
        linked = (node - last == 1) | certain
        bonds = lattice.w * lattice.cell * (node - last) * lattice.weight((node + last) / 2)
        decay = self._since_last(self.log_y)
        growth = self._since_last(self.log_z)
        rise = h[node] - h[last] - np.expm1(-decay) * h[last]
        with np.errstate(divide="ignore", invalid="ignore"):  # of the first nothing is before
            free = self.stiffness * rise**2 / -np.expm1(-growth)
        return np.asarray(free - np.where(linked, bonds, 0.0))

    def _since_last(self, log: Any) -> Array:
        """By how much a logarithm has grown since the node before (m,)."""
        before = np.append(log[:1], log[:-3])
        return np.asarray((log[:-2] - before).astype(float))

    def logs(self, which: Nodes, origin: int) -> tuple[Array, Array]:
        """ln y/h and ln z of some of them, in units in which y = h and z = 1 at the origin."""
        log_y = self.log_y[which] - self.log_y[origin]
        log_z = self.log_z[which] - self.log_z[origin]
        return log_y.astype(float), log_z.astype(float)


class _Start(NamedTuple):
    """A start relative to a block, in units in which y = h and z = 1 at the origin of the block.

    Attributes
    ----------
    which : int
        Its place in `_Ends`.
    value : float
        V [energy/length].
    h : float
        Its drop [length].
    more, z, y : float
        y - h, z - 1 and y.
    """

    which: int
    value: float
    h: float
    more: float
    z: float
    y: float


def _placed(ends: _Ends, which: Nodes, value: Array, origin: int) -> list[_Start]:
    """Starts relative to an origin."""
    h = ends.h[which]
    log_y, log_z = ends.logs(which, origin)
    more = h * np.expm1(log_y)
    y = h * np.exp(log_y)
    columns = (which, value, h, more, np.expm1(log_z), y)
    return list(map(_Start, *(column.tolist() for column in columns)))


def _limits(ends: _Ends, starts: Nodes, value: Array, origin: int) -> tuple[Nodes, Array]:
    """Which of the starts are not dropped, and up to which height they are needed at the origin.

    Of the newest that is inf. Differences are those of neighbours, so that no digits are lost.
    """
    c = float(ends.stiffness[origin])
    h = ends.h[starts]
    log_y, log_z = ends.logs(starts, origin)
    ahead = -np.expm1(log_z)
    near = np.exp(np.maximum(log_y, -_SEARCH.faint))
    z = np.exp(np.maximum(log_z, -2 * _SEARCH.faint))
    y = near * h
    dz = z[1:] * -np.expm1(log_z[:-1] - log_z[1:])
    dy = near[1:] * (np.diff(h) - np.expm1(log_y[:-1] - log_y[1:]) * h[:-1])
    lost = np.maximum(c * dy * (dy / dz) - np.diff(value), 0.0)
    cut = np.sqrt(lost / c / dz * ahead[:-1] * ahead[1:])
    limit = np.append(y[1:] + dy / dz * ahead[1:] - cut, math.inf)
    older = np.arange(starts.size) - 1  # neighbours among those that are left
    newer = np.arange(starts.size) + 1
    left = np.full(starts.size, True)
    todo = (np.flatnonzero(limit[:-1] > limit[1:]) + 1).tolist()
    while todo:
        k = todo.pop()
        i = int(older[k])
        j = int(newer[k])
        if not left[k] or i < 0 or j == starts.size or limit[i] <= limit[k]:
            continue
        left[k] = False
        newer[i] = j
        older[j] = i
        rise = float(dy[i] + dy[k])
        run = float(dz[i] + dz[k])
        dy[i] = rise
        dz[i] = run
        more = max(c * rise * (rise / run) - float(value[j] - value[i]), 0.0)
        off = math.sqrt(more / c / run * float(ahead[i] * ahead[j]))
        limit[i] = float(y[j]) + rise / run * float(ahead[j]) - off
        todo += [i, j]
    found = np.flatnonzero(left)
    return found, limit[found]


def _cheapest(lattice: Lattice, h: Array, may: Mask) -> tuple[float, Mask, int]:
    """The set of contact nodes of least energy.

    Parameters
    ----------
    lattice : Lattice
    h : ndarray (n,)
        The largest drops [length].
    may : ndarray of bool (n,)
        Nodes that may be in contact; of a contact that is certain, h = 0, its ends are enough.

    Returns
    -------
    least : float
        V of the tail that follows.
    contact : ndarray of bool (n,)
    compared : int
        How many surfaces were compared.
    """
    if not may.any():
        return 0.0, h == 0, 0
    ends = _Ends(lattice, h, np.flatnonzero(may))
    floor = min(0.0, float(h.min()))
    tie = _SEARCH.tie * lattice.w * lattice.cell
    size = ends.node.size + 1  # with the tail that follows, and the number of what precedes
    before = np.full(size, size)
    starts = np.array([size])
    value = np.zeros(1)
    log_z = ends.log_z[:size].astype(float)
    first = 0
    compared = 0
    while first < size:
        stop = _end_of_block(ends, log_z, first, starts.size)
        compared += starts.size
        block = _Block(ends, first, stop, floor, tie)
        starts, value = block.passed(starts, value)
        before[first:stop] = block.before
        compared += block.compared
        first = stop
    contact = h == floor
    k = int(before[-1])
    while k < size:
        contact[ends.node[k]] = True
        k = int(before[k])
    return float(value[-1]), contact, compared


def _end_of_block(ends: _Ends, log_z: Array, first: int, starts: int) -> int:
    """The place after a block of nodes that begins here, followed with so many starts."""
    size = log_z.size
    most = _SEARCH.block + starts // _SEARCH.starts_per_node
    stop = min(first + most, int(log_z.searchsorted(log_z[first] + _SEARCH.span)), size - 1)
    if stop == size - 1:
        return size
    return min(stop, int(ends.node.searchsorted(ends.node[first] + 2 * most)))


class _Block:
    """Nodes that are passed one after the other, from first to stop - 1 of `_Ends`.

    before: the start of the best surface to each; compared: how many surfaces were compared.
    """

    def __init__(self, ends: _Ends, first: int, stop: int, floor: float, tie: float) -> None:
        self.ends = ends
        self.first = first
        self.stop = stop
        self.floor = floor
        self.tie = tie
        self.before = list[int]()
        self.compared = 0
        which = np.arange(first, stop)
        self.nodes = _placed(ends, which, ends.step[first:stop], first)
        self.end = self.nodes[-1].z
        self.shear = (self.nodes[-1].y - self.nodes[0].y) / self.end if self.end else 0.0

    def passed(self, starts: Nodes, value: Array) -> tuple[Nodes, Array]:
        """Starts that may be needed beyond the block, and their V, of those before it."""
        own, limit = _limits(self.ends, starts, value, self.first)
        lowest = int(limit.searchsorted(self.floor))
        own = own[lowest:]
        limit = limit[lowest:]
        starts = starts[own]
        value = value[own]
        h = self.ends.h[starts]
        log_y, log_z = self.ends.logs(starts, self.first)
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
        c = float(self.ends.stiffness[self.first])
        tie = self.tie
        none = False
        for k, (node, step, h, more, z, y) in enumerate(self.nodes):
            if k and len(near) > 1:
                self._bound(near, steepest, reach, z)
            height_here = y - self.shear * z
            base = math.inf
            least = math.inf
            best = 0
            newest = len(near) - 1
            j = newest
            while j >= 0 and reach[j] >= height_here:
                _, value, own_h, own_more, own_z, own_y = near[j]
                rise = (h - own_h) + (more - own_more)
                slope = rise / (z - own_z)
                height = own_y - slope * (1 + own_z)  # of the line at z = 0
                if height <= base:  # no newer one is above it
                    base = height
                    cost = value + (step if j == newest and node else c * rise * slope)
                    if slope <= steepest[j] and cost < least - tie:
                        least = cost
                        best = j
                j -= 1
            self.compared += newest - j
            self.before.append(near[best].which)
            if h <= self.floor:  # nothing passes a certain contact
                best = -1
                none = True
            del near[best + 1 :], steepest[best + 1 :], reach[best + 1 :]
            near.append(_Start(node, least, h, more, z, y))
            steepest.append(math.inf)
            reach.append(math.inf)
        return none

    def _bound(
        self, near: list[_Start], steepest: list[float], reach: list[float], z: float
    ) -> None:
        """What the newest start leaves of the one before it, at the next node."""
        c = float(self.ends.stiffness[self.first])
        one = near[-2]
        other = near[-1]
        rise = (other.h - one.h) + (other.more - one.more)
        run = other.z - one.z
        lost = max(one.value + c * rise * (rise / run) - other.value, 0.0)
        slope = rise / run - math.sqrt(lost / c / run * (z - other.z) / (z - one.z))
        limit = one.y + slope * (z - one.z) - self.shear * z
        further = limit + (slope - self.shear) * (self.end - z)
        steepest[-2] = slope
        reach[-2] = max(limit, further, reach[-3] if len(reach) > 2 else -math.inf)


def runs(contact: Mask) -> Nodes:
    """First and last node of each contact.

    Parameters
    ----------
    contact : ndarray of bool (n,)
        Which nodes are in contact.

    Returns
    -------
    ndarray of int (m, 2)
    """
    return np.flatnonzero(np.diff(np.pad(contact, 1))).reshape(-1, 2) - (0, 1)


def on_lowest(row: Row, depth: float, method: str) -> tuple[Contacts, Proof | None]:
    """The contacts of lowest energy of all contact sets on these nodes, and the proof.

    Parameters
    ----------
    row : Row
    depth : float
        [length].
    method : {"shortest_path", "lattice", "oracle"}
        The first two are the same; the last needs cvxpy and has no proof.

    Returns
    -------
    contacts : Contacts
    proof : Proof or None

    Raises
    ------
    ValueError
        For what the method cannot express.
    """
    lattice = row.lattice
    g = depth - row.f
    proof = None
    if method == "oracle":
        near = np.append(np.flatnonzero(g >= -lattice.deepest_contact), row.touch)
        start = int(near.min())
        g = np.append(g[start : near.max() + 1], -math.inf)  # it needs two nodes
        contacts = runs(oracle(lattice, g).contact) + start
    else:
        contacts, proof = global_minimum(lattice, g)
    return tuple((first, last) for first, last in contacts.tolist()), proof


def lowest_contacts(scene: Scene, depth: float, lattice: Lattice) -> Nodes:
    """First and last nodes of the contacts of lowest energy; of rings around an axis, too.

    Parameters
    ----------
    scene : Scene
        As far as it has nodes (`Lattice.scene_on_nodes`).
    depth : float
        [length].
    lattice : Lattice

    Returns
    -------
    ndarray of int (m, 2)

    Raises
    ------
    ValueError
        As `on_lowest`.
    """
    row = Row.of(scene, lattice, depth)
    g = depth - row.f
    if lattice.axis == 0:
        contacts = runs(lowest_rings(lattice, g))
    else:
        contacts, _ = global_minimum(lattice, g)
    return contacts + row.first
