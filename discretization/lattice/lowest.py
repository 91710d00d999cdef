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

Conventions
-----------
u and g = d - f are displacements, positive down into the layer. v and h are *drops* of u below ū:
positive upwards, h the drop of a node in contact. V of a node is the least U of a state whose last
contact node it is, less U of ū without adhesion [energy/length], or about an axis just U [energy].
A height y is v/Q, in the diagram of z and y in which free surfaces are straight.

Nodes are numbered from 0 in the row, from left to right; *older* starts lie further to the left
than newer ones. Nodes that may end a free surface are the entries of `_Ends`, and numbers called
`which`, `start` or `first` and `stop` (exclusive) count these entries, not the nodes. Two entries
follow those of the m nodes: number m is the tail that follows the last contact, number m + 1, the
last one, is nothing that precedes the first contact.

`pressed(lattice, g)` has the contact nodes of ū and the forces, positive downwards, that hold them
there; `surface(lattice, nodes, g, at)` the displacements at some nodes of a free surface that is
held at others. Of a lattice, `spring_stiffness` is kΔx, `link_stiffness` t and `cell` the length or
area of a link, all for weight 1; `weight` that of nodes, or of links by their middles, i + ½;
`tail_stiffness(node, side)` what a tail beyond a node pulls with over u, and `deepest_contact` D,
the largest drop of a node in contact in any minimum. DECAYED is 40 decay lengths, after which a
tail is less than rounding. `NodalEnergy(lattice, contact).balance(u).terms` are the terms of U.
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

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 8 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.lattice.lowest`.

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
    # What is in contact, and the surface over all of it: a check by the energy of all nodes.
    u = np.where(contact, g, surface(lattice, np.flatnonzero(contact), g[contact], every))
    terms = np.array([*NodalEnergy(lattice, contact).balance(u).terms.values()])
    bound = float(force @ g[certain]) / 2 + least  # U of ū is half the work of its forces
    return runs(contact), Proof(bound, float(terms.sum()), float(abs(terms).sum()))


def lowest_rings(lattice: Lattice, g: Array) -> Mask:
    """The nodes in contact (n,) of lowest energy around an axis, of heights g = d - f (n,).

    All of them may be in contact: `deepest_contact` is a bound for line contacts only.
    """
    return _cheapest(lattice, -g, np.ones(g.size, bool))[1]


def _chain(lattice: Lattice, size: int) -> tuple[Any, Any, Array]:
    """ln P and -ln Q of all nodes (n,) in long double, both 0 at node 0, and c of them (n,).

    P and Q follow from the stiffness s of what is on one side of a node, its own spring included:
    over a link t to the next node a free surface grows by the factor 1 + s/t. P grows to the right
    as s of the left side has it, and 1/Q as s of the right side does. Of surfaces in series the
    stiffnesses add like those of springs: s of the next node is its spring and t s/(t + s).

    Long double, as differences of these logarithms are needed with all digits of double.
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

    growth_of_p = np.append(0.0, left_side[:last] / link)  # over the link before each node, less 1
    decay_of_q = np.append(0.0, right_side[1:] / link)
    log_p = _running_sum(np.log1p(growth_of_p))
    minus_log_q = _running_sum(np.log1p(decay_of_q))
    both_sides = left_side + right_side - spring  # the node's own spring once
    return log_p, minus_log_q, np.asarray(both_sides / 2)


def _running_sum(terms: Array) -> Any:
    """Running sum in long double."""
    return np.cumsum(terms, dtype=np.longdouble)


class _Ends:
    """Where free surfaces may end or begin: m nodes, from left to right, and two more places.

    These, with h = 0, are far beyond the nodes, where a tail that follows has decayed (entry m),
    and far before them, where nothing precedes (entry m + 1, or -1).

    Parameters
    ----------
    lattice : Lattice
    h : ndarray (n,)
        The largest drops of all nodes [length].
    node : ndarray of int (m,)
        Those that may be in contact; of a contact that is certain its two end nodes.

    Attributes
    ----------
    node : ndarray of int (m,)
        Numbers of the nodes.
    h : ndarray (m + 2,)
        Drops [length].
    log_y, log_z : ndarray (m + 2,)
        -ln Q and ln P/Q, in long double: y of a drop v is v exp(log_y), z is exp(log_z).
    stiffness : ndarray (m,)
        c, half the stiffness of the surface at the node.
    step : ndarray (m + 1,)
        What it costs to reach each node from the one before: that of the free surface between them,
        less the adhesion if they are neighbours or the ends of a certain contact; 0 of the tail.
    """

    def __init__(self, lattice: Lattice, h: Array, node: Nodes) -> None:
        """Logarithms at the nodes and, DECAYED lengths beyond them, at the tail; see the class."""
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
        """Energy of what is between each node and the one before (m,), as `step`.

        A contact is a free surface without free nodes, between neighbours, that adheres besides.
        """
        node = self.node
        last = np.append(node[:1], node[:-1])  # the node before; of the first itself
        none_between = np.diff(np.cumsum(h > 0)[node], prepend=-1) == 0  # with h > 0, j included
        linked = (node - last == 1) | none_between  # none: i and j end a certain contact
        links = node - last
        adhesion = lattice.w * lattice.cell * links * lattice.weight((node + last) / 2)
        decay = self._since_last(self.log_y)
        growth = self._since_last(self.log_z)
        rise = h[node] - h[last] - np.expm1(-decay) * h[last]
        with np.errstate(divide="ignore", invalid="ignore"):  # of the first nothing is before
            free = self.stiffness * rise**2 / -np.expm1(-growth)
        return np.asarray(free - np.where(linked, adhesion, 0.0))

    def _since_last(self, log: Any) -> Array:
        """By how much a logarithm has grown since the node before (m,); 0 of the first node."""
        of_nodes = log[:-2]
        before = np.append(log[:1], of_nodes[:-1])
        return np.asarray((of_nodes - before).astype(float))

    def logs(self, which: Nodes, origin: int) -> tuple[Array, Array]:
        """ln y/h and ln z of some entries, in units in which y = h and z = 1 at the entry `origin`.

        Both are negative to the left of it.
        """
        log_y = self.log_y[which] - self.log_y[origin]
        log_z = self.log_z[which] - self.log_z[origin]
        return log_y.astype(float), log_z.astype(float)


class _Start(NamedTuple):
    """A start relative to a block, in units in which y = h and z = 1 at the origin of the block.

    Attributes
    ----------
    which : int
        Its number in `_Ends`.
    value : float
        V [energy/length].
    h : float
        Its drop [length].
    more : float
        y - h, without the rounding of y.
    z : float
        z - 1, without the rounding of z: -1 of what is far to the left, 0 at the origin.
    y : float
        y.
    """

    which: int
    value: float
    h: float
    more: float
    z: float
    y: float


def _placed(ends: _Ends, which: Nodes, value: Array, origin: int) -> list[_Start]:
    """Starts `which`, of energies V, relative to the first entry of a block."""
    h = ends.h[which]
    log_y, log_z = ends.logs(which, origin)
    more = h * np.expm1(log_y)
    y = h * np.exp(log_y)
    columns = (which, value, h, more, np.expm1(log_z), y)
    return list(map(_Start, *(column.tolist() for column in columns)))


def _limits(ends: _Ends, starts: Nodes, value: Array, origin: int) -> tuple[Nodes, Array]:
    """The starts that are needed at the first entry of a block, and up to which height each is.

    The formula of 3. in the module's docstring, at z = 1, C = c of the origin. Differences of y and
    z are those of neighbours, so that no digits are lost.

    Parameters
    ----------
    ends : _Ends
    starts : ndarray of int (s,)
        Entries of `ends`, older ones first.
    value : ndarray (s,)
        V of them [energy/length].
    origin : int
        The entry of `ends` at which intervals are found.

    Returns
    -------
    kept : ndarray of int
        Numbers, among the starts, of those that have an interval.
    limit : ndarray
        Upper end of the interval of each of these, the lower end of the next one's; inf of the
        last.
    """
    h = ends.h[starts]
    log_y, log_z = ends.logs(starts, origin)
    near = np.exp(np.maximum(log_y, -_SEARCH.faint))
    z = np.exp(np.maximum(log_z, -2 * _SEARCH.faint))
    pairs = _Pairs(
        c=float(ends.stiffness[origin]),
        value=value,
        y=near * h,
        ahead=-np.expm1(log_z),
        dy=near[1:] * (np.diff(h) - np.expm1(log_y[:-1] - log_y[1:]) * h[:-1]),
        dz=z[1:] * -np.expm1(log_z[:-1] - log_z[1:]),
    )
    return _with_interval(pairs, np.append(pairs.limits(), math.inf))


class _Pairs(NamedTuple):
    """Starts i = 0 ... s - 1 at the origin of a block, and what lies between neighbours of them.

    Attributes
    ----------
    c : float
        c of the origin, C of the module.
    value, y, ahead : ndarray (s,)
        V_i, y_i, and z of the origin less z_i.
    dy, dz : ndarray (s - 1,)
        From each start to the next newer one that is left.
    """

    c: float
    value: Array
    y: Array
    ahead: Array
    dy: Array
    dz: Array

    def limits(self) -> Array:
        """Heights at the origin (s - 1,) above which the next newer start costs less."""
        slope = self.dy / self.dz
        excess = np.maximum(self.c * self.dy * slope - np.diff(self.value), 0.0)  # A
        below_line = np.sqrt(excess / self.c / self.dz * self.ahead[:-1] * self.ahead[1:])
        return np.asarray(self.y[1:] + slope * self.ahead[1:] - below_line)

    def limit(self, i: int, k: int) -> float:
        """Height at the origin above which start k costs less than i, with none left in between.

        dy and dz of i have to be those from i to k.
        """
        rise = float(self.dy[i])
        run = float(self.dz[i])
        excess = max(self.c * rise * (rise / run) - float(self.value[k] - self.value[i]), 0.0)
        below_line = math.sqrt(excess / self.c / run * float(self.ahead[i] * self.ahead[k]))
        return float(self.y[k]) + rise / run * float(self.ahead[k]) - below_line


def _with_interval(pairs: _Pairs, limit: Array) -> tuple[Nodes, Array]:
    """The starts that have an interval, and the upper end of it, as `_limits` returns them.

    Start k is dropped if its limit (s,) is less than that of the next older one, i, which then has
    the limit with the next newer one, j. `pairs` are changed.
    """
    older = np.arange(limit.size) - 1  # neighbours among those that are left
    newer = np.arange(limit.size) + 1
    left = np.full(limit.size, True)
    suspects = (np.flatnonzero(limit[:-1] > limit[1:]) + 1).tolist()
    while suspects:
        k = suspects.pop()
        i = int(older[k])
        j = int(newer[k])
        if not left[k] or i < 0 or j == limit.size or limit[i] <= limit[k]:
            continue
        left[k] = False
        newer[i] = j
        older[j] = i
        pairs.dy[i] += pairs.dy[k]
        pairs.dz[i] += pairs.dz[k]
        limit[i] = pairs.limit(i, j)
        suspects += [i, j]
    kept = np.flatnonzero(left)
    return kept, limit[kept]


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
        How many surfaces were compared: what the search costs.
    """
    if not may.any():  # then nothing is in contact without adhesion either, h = 0 nowhere
        return 0.0, h == 0, 0
    ends = _Ends(lattice, h, np.flatnonzero(may))
    certain = min(0.0, float(h.min()))  # the drop of certain contacts, the least that v can be
    tie = _SEARCH.tie * lattice.w * lattice.cell
    size = ends.node.size + 1  # with the tail that follows, and the number of what precedes
    before = np.full(size, size)  # of each entry the start of the best surface to it
    starts = np.array([size])
    value = np.zeros(1)
    log_z = ends.log_z[:size].astype(float)
    first = 0
    compared = 0
    while first < size:
        stop = _end_of_block(ends, log_z, first, starts.size)
        compared += starts.size
        block = _Block(ends, first, stop, certain, tie)
        starts, value = block.passed(starts, value)
        before[first:stop] = block.before
        compared += block.compared
        first = stop
    # Back from the tail, start by start, to what precedes all.
    contact = h == certain
    k = int(before[-1])
    while k < size:
        contact[ends.node[k]] = True
        k = int(before[k])
    return float(value[-1]), contact, compared


def _end_of_block(ends: _Ends, log_z: Array, first: int, starts: int) -> int:
    """The entry of `_Ends` after a block that begins with this one, followed with so many starts.

    A block has at least one entry; the tail is always in a block with what comes before it.
    """
    size = log_z.size
    most = _SEARCH.block + starts // _SEARCH.starts_per_node
    stop = min(first + most, int(log_z.searchsorted(log_z[first] + _SEARCH.span)), size - 1)
    if stop == size - 1:
        return size
    return min(stop, int(ends.node.searchsorted(ends.node[first] + 2 * most)))


class _Block:
    """Nodes that are passed one after the other, entries first to stop - 1 of `_Ends`.

    y and z are in units in which y = h and z = 1 at the first of them. A *sheared* height is a
    height less what a line through the block's first and last node has there: it is level at both.

    Parameters
    ----------
    ends : _Ends
    first, stop : int
        Entries of `ends`.
    certain : float
        Drop of nodes that are in contact for certain [length].
    tie : float
        By how much a surface from an older start has to cost less to be preferred [energy/length].

    Attributes
    ----------
    before : list of int
        Of each entry passed, the start of the best surface to it.
    compared : int
        How many surfaces were compared.
    nodes : list of _Start
        The entries; their `value` is that of `_Ends.step`, not V.
    end : float
        z of the last entry less z of the first.
    shear : float
        Slope of the line through both.
    """

    def __init__(self, ends: _Ends, first: int, stop: int, certain: float, tie: float) -> None:
        """The nodes of the block in its own units; see the class."""
        self.ends = ends
        self.first = first
        self.stop = stop
        self.certain = certain
        self.tie = tie
        self.before = list[int]()
        self.compared = 0
        which = np.arange(first, stop)
        self.nodes = _placed(ends, which, ends.step[first:stop], first)
        self.end = self.nodes[-1].z
        self.shear = (self.nodes[-1].y - self.nodes[0].y) / self.end if self.end else 0.0

    def passed(self, starts: Nodes, value: Array) -> tuple[Nodes, Array]:
        """Starts that may be needed beyond the block, older ones first, and their V.

        Parameters
        ----------
        starts : ndarray of int (s,)
            Entries of `_Ends` that may be needed at its first node.
        value : ndarray (s,)
            V of them [energy/length].

        Returns
        -------
        starts : ndarray of int
        value : ndarray
        """
        own, limit = _limits(self.ends, starts, value, self.first)
        lowest = int(limit.searchsorted(self.certain))  # intervals of others lie below all surfaces
        own = own[lowest:]
        limit = limit[lowest:]
        starts = starts[own]
        value = value[own]
        h = self.ends.h[starts]
        log_y, log_z = self.ends.logs(starts, self.first)
        steepest = (limit - h * np.exp(log_y)) / -np.expm1(log_z)
        # The highest sheared height, in the block, of the steepest line from each start or an older
        # one: straight, so at the first node or at the last. No node above it needs the start.
        at_end = limit[:-1] + (steepest[:-1] - self.shear) * self.end
        reach = np.append(np.maximum(limit[:-1], at_end), math.inf)
        reach = np.maximum.accumulate(reach)
        least = min(node.y - self.shear * node.z for node in self.nodes)
        deep = int(reach.searchsorted(least))  # so many starts reach no node of the block
        near = _placed(self.ends, starts[deep:], value[deep:], self.first)
        if self.follow(near, steepest[deep:].tolist(), reach[deep:].tolist()):
            deep = 0
        which, found, *_ = zip(*near, strict=True)
        return np.append(starts[:deep], which), np.append(value[:deep], found)

    def follow(self, near: list[_Start], steepest: list[float], reach: list[float]) -> bool:
        """Find V of the nodes of the block one after the other; each becomes a start.

        Parameters
        ----------
        near : list of _Start
            The starts, older ones first; changed to those that are needed beyond the block.
        steepest, reach : list of float
            Slope of a line from each, and sheared height, above which the start is not needed; the
            latter the largest of this and all older starts. Changed with the starts.

        Returns
        -------
        bool
            Whether a certain contact is among the nodes, so that no start before it is needed.
        """
        passed_certain = False
        for k, node in enumerate(self.nodes):
            if k and len(near) > 1:
                self._bound(near, steepest, reach, node.z)
            best, least = self._best_start(node, near, steepest, reach)
            self.before.append(near[best].which)
            if node.h <= self.certain:  # nothing passes a certain contact
                best = -1
                passed_certain = True
            del near[best + 1 :], steepest[best + 1 :], reach[best + 1 :]  # 1. of the module
            near.append(_Start(node.which, least, node.h, node.more, node.z, node.y))
            steepest.append(math.inf)
            reach.append(math.inf)
        return passed_certain

    def _best_start(
        self, node: _Start, near: list[_Start], steepest: list[float], reach: list[float]
    ) -> tuple[int, float]:
        """The number among the starts of the best one of a surface to this node, and V of it.

        Starts are compared from the newest on, until none may reach as high as the node.
        """
        which, step, h, more, z, y = node
        c = float(self.ends.stiffness[self.first])
        sheared_height = y - self.shear * z
        base = math.inf
        least = math.inf
        best = 0
        newest = len(near) - 1
        j = newest
        while j >= 0 and reach[j] >= sheared_height:
            _, value, own_h, own_more, own_z, own_y = near[j]
            rise = (h - own_h) + (more - own_more)
            slope = rise / (z - own_z)
            # A line that is higher at z = 0 than that of a newer start passes above that start.
            height = own_y - slope * (1 + own_z)
            if height <= base:
                base = height
                cost = value + (step if j == newest and which else c * rise * slope)
                if slope <= steepest[j] and cost < least - self.tie:
                    least = cost
                    best = j
            j -= 1
        self.compared += newest - j
        return best, least

    def _bound(
        self, near: list[_Start], steepest: list[float], reach: list[float], z: float
    ) -> None:
        """Up to where the start before the newest one is still needed, at the next node (z).

        By 3. of the module with i the one and k the newest; its entries of `steepest` and `reach`
        become those of its limit.
        """
        c = float(self.ends.stiffness[self.first])
        one = near[-2]
        newest = near[-1]
        rise = (newest.h - one.h) + (newest.more - one.more)
        run = newest.z - one.z
        excess = max(one.value + c * rise * (rise / run) - newest.value, 0.0)
        slope = rise / run - math.sqrt(excess / c / run * (z - newest.z) / (z - one.z))
        limit = one.y + slope * (z - one.z) - self.shear * z
        at_end = limit + (slope - self.shear) * (self.end - z)
        steepest[-2] = slope
        reach[-2] = max(limit, at_end, reach[-3] if len(reach) > 2 else -math.inf)


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
