"""One contact on nodes by the simplest method there is: read this first.

The unknowns are the displacements u_i of the nodes, U is their `NodalEnergy`. While those of some
nodes are prescribed, u = g = d - f in contact, all others minimise a convex function: Newton's
method, each step of which is one tridiagonal solve. Descent in u alone can never move a contact
line, as lifting a contact node costs its adhesion at once, and a free node has to cross a finite
gap. So energies of neighbouring contact sets are compared, each with its surface relaxed: from the
node that touches first a line passes link after link while that lowers the energy, or while the
surface beyond would be in the indenter. In contact u is prescribed, so that neither line feels the
other one.

Small or finite slopes, with or without surface tension and adhesion, line contact or axis. States
with finite slopes, and those of independent springs (γ₁ = 0), come from here; for small slopes the
rest of the package knows free surfaces in closed form, is faster, and finds the same states.

Conventions
-----------
Depths and displacements are positive down into the layer, heights f upwards, g = d - f; a force is
dU/dd, positive if the indenter presses. Nodes are numbered from 0 in the row (`Row`), from left to
right. A line is at a contact node, with the free surface on its `side`: -1 the left line, 1 the
right one. It passes, or closes, the link to the node + side. About an axis there is no left line.
`NodalEnergy(lattice, contact, first, tails=...)` is the energy of nodes with contacts fixed,
`first` the lattice's number of the first of them; `relaxed` are the displacements of least energy
with those of contact nodes as given, and `balance` has terms of U and nodal forces at some
displacements.
`Advances` has what changes as lines pass links, with the links LINKS = -3 ... 2 outwards from a
line's node as its last axis.

Of a lattice, `cell` is the length or area of a link of weight 1, `weight(i)` that of node i or, at
i + ½, of link i: 1, or about an axis the radius over Δr; `stored(u)` the energy of the springs per
area with its first and second derivative by u, `value`, `first` and `second`; `log_decay` μ, by
which a linear tail decays per node; `overhang` ½ without tension, as a contact then reaches half a
spacing beyond its last node, else 0. `Row.refuse_unknown` raises a ValueError where a contact
reaches the end of the known profile. δ₀ = √(2w/k) is `Scene.critical_separation`.
"""

import bisect
import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import TOLERANCE
from discretization.lattice.certificate import State
from discretization.lattice.subgrid import LINKS, Advances
from discretization.nodes.lattice import Lattice, LatticeTail
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.row import Row
from energy import terms
from energy.arrays import Array

# Decay lengths, beyond which a free surface is linear: what finite slopes add is of the square of
# the slope, which is e⁻²⁴ = 4e-11 of that at the line there.
FAR = 12.0
# This and the next three halved or doubled (or a tenth and ten times of MOST and _TIE) change no
# result (`python -m tests.sensitivity discretization.lattice.plain`).
MOST = 400_000  # nodes of a free surface, so that a state takes seconds at most
# Displacement in l. At √2 a surface of finite slope turns over; the margin of 8 % is that of nodes,
# whose surfaces turn over a little earlier or later.
TURNING = 1.3
# Relative slack that keeps a line where both sides cost the same: some thousand roundings.
_TIE = 1e-12


def far(lattice: Lattice) -> int:
    """Nodes of a free surface up to where it is linear. ValueError if these are more than MOST."""
    count = math.ceil(FAR / lattice.log_decay) + 1
    if count > MOST:
        raise ValueError(
            f"spacing = {lattice.spacing!r} puts {count} nodes on a free surface, each an unknown "
            f"with slopes = {lattice.slopes!r}: use method='fitted', or a larger spacing"
        )
    return count


def turning(lattice: Lattice) -> float:
    """Displacement at which a surface of finite slope, resolved to a link, would all but turn.

    ∞ for small slopes, which never do.
    """
    length = math.sqrt(lattice.gamma1 / lattice.k)
    return TURNING * length + lattice.spacing if lattice.slopes == "finite" else math.inf


class Outside(NamedTuple):
    """The free surface outwards of a contact line, which is on a node, and the spring there.

    Attributes
    ----------
    energy : float
        Of both [energy/length].
    force : float
        Derivative of that energy by the displacement of the node [force/length].
    u_next : float
        Displacement of the next node outwards [length].
    """

    energy: float
    force: float
    u_next: float


class LinkPassed(NamedTuple):
    """Changes as a line passes one link; the same, in the same order, as arrays in `Advances`.

    Attributes
    ----------
    gap : float
        Between surface and indenter at the node beyond the link, before; < 0: in the indenter
        [length].
    stored : float
        What the energy grows by without adhesion [energy/length].
    force : float
        What the force dU/dd grows by [force/length].
    bonds : float
        Length or area of the link, or without tension of the node, along the profile.
    """

    gap: float
    stored: float
    force: float
    bonds: float


@dataclass(frozen=True, eq=False)
class Plain:
    """One contact over a row of nodes at a depth.

    Attributes
    ----------
    row : Row
    depth : float
        [length].
    work : float
        Work of adhesion for which a line passes a link [energy/area]: w, or less where springs
        without tension attach only as they touch.
    """

    row: Row
    depth: float
    work: float

    def g(self, node: int) -> float:
        """d - f at a node [length]."""
        return self.depth - float(self.row.f[node])

    def outside(self, node: int, side: int) -> Outside:
        """The free surface on a side of a line at this node, relaxed, with the spring of the node.

        In a line contact it depends on u at the line alone: it is found as one on the right of a
        place that is the same for all, so that what is kept serves every node.
        """
        if self.row.lattice.axis == 0:
            return self._outside(node, side, self.g(node))
        anywhere = -self.row.first  # it is the same at all nodes
        return self._outside(anywhere, 1, self.g(node))

    @functools.lru_cache(maxsize=1 << 12)  # noqa: B019
    def _outside(self, node: int, side: int, u_line: float) -> Outside:
        """The free surface on a side of a node that is displaced by u_line, relaxed.

        Of as many nodes as it takes to be linear, with an exact tail beyond them.
        """
        lattice = self.row.lattice
        if not lattice.gamma1:  # a spring alone
            spring = lattice.stored(u_line)
            cell = lattice.cell * lattice.weight(self.row.first + node)
            return Outside(cell * float(spring.value), cell * float(spring.first), 0.0)
        count = far(lattice) + 2
        first = min(node, node + side * (count - 1))  # on the left the line is at the last node
        at_line = np.arange(count)[::side] == 0
        model = NodalEnergy(lattice, at_line, self.row.first + first, tails=(side < 0, side > 0))
        u = model.relaxed(np.full(count, u_line))
        balance = model.balance(u)
        energy = balance.energy - balance.terms["adhesion"]
        return Outside(energy, float(balance.forces[::side][0]), float(u[::side][1]))

    def link(self, node: int, side: int) -> LinkPassed:
        """Changes as a line at this node passes the next link.

        Before, the surface `here` begins at the node; after it, `beyond` begins at the next node,
        and the spring of this node and the link between both are in contact.

        What is stored is the difference of energies. Without adhesion a line rests where nothing is
        stored, and that difference would be rounding: there it is half the work of the force over
        the gap, as of a quadratic energy.
        """
        lattice = self.row.lattice
        after = node + side
        here = self.outside(node, side)
        beyond = self.outside(after, side)
        g = self.g(node)
        g_after = self.g(after)
        slope = (g_after - g) / lattice.spacing
        at = self.row.first + node
        spring = lattice.stored(g)
        cell = lattice.cell * lattice.weight(at)
        bonds = lattice.cell * lattice.weight(at + side * (0.5 + lattice.overhang))
        tension = terms.surface(slope, gamma1=lattice.gamma1 * bonds, slopes=lattice.slopes)
        gap = here.u_next - g_after
        change = beyond.energy + cell * float(spring.value) + float(tension.value) - here.energy
        stored = max(change, 0.0)
        if not lattice.w:
            stored = abs(gap * (beyond.force + float(tension.first) / lattice.spacing)) / 2
        elif lattice.slopes == "finite":
            bonds *= math.hypot(1.0, slope)
        force = beyond.force + cell * float(spring.first) - here.force
        return LinkPassed(gap, stored, force, bonds)

    def resists(self, node: int, side: int) -> bool:
        """Whether a line at this node does not pass the next link outwards.

        It passes where the surface would be in the indenter, or turn over, and where the energy
        stored is no more than the adhesion of the link; a tie counts as passed.
        """
        scene = self.row.scene
        u = self.g(node)  # in contact
        if u > turning(self.row.lattice):
            return False  # it would turn over, into the indenter
        if scene.indenter.convex and -u > (1 + _TIE) * scene.critical_separation:
            return True  # no flat face would hold, and no link beyond this one
        passed = self.link(node, side)
        return passed.gap > 0 and passed.stored > self.work * passed.bonds * (1 + _TIE)

    def outermost(self, side: int) -> int:
        """The node at which a line comes to rest that starts at the node that touches first.

        Where the profile is convex the gap grows outwards, so that many links are passed at once.
        Else the line is pressed first, and comes back as the indenter is withdrawn.
        """
        row = self.row
        start = row.touch
        end = row.size - 1 if side > 0 else 0
        ahead = range(start, end, side)
        resists = functools.partial(self.resists, side=side)
        if row.scene.indenter.convex:
            return start + side * bisect.bisect_left(ahead, True, key=resists)
        if self.depth >= row.lowest:
            return next(filter(resists, ahead), end)
        pressed = Plain(row, row.lowest, self.work)  # at first touch
        back = range(pressed.outermost(side), start, -side)
        # The last link of the contact stays closed if a line behind it would pass it.
        return next((node for node in back if not resists(node - side)), start)

    def contact(self) -> tuple[int, int] | None:
        """First and last node in contact on the path from first touch on; None: detached.

        A lone node with tension has no link, so that nothing holds it once it is pulled.
        """
        row = self.row
        pulled = row.lowest - self.depth
        if pulled > (1 + _TIE) * row.scene.critical_separation:
            return None
        left = self.outermost(-1)
        right = self.outermost(1)
        if left == right and pulled > 0 and row.lattice.gamma1:
            return None
        return left, right

    def advances(self, nodes: tuple[int, int]) -> Advances:
        """Changes as both lines pass the links beside them: arrays (1, 2, 6) of one state.

        nan where there is no link: outside of the row, inside of the other line, at an axis.
        """
        row = self.row
        found = np.full((4, 1, 2, LINKS.size), math.nan)  # rows: the fields of `Advances`
        on_axis = row.first + nodes[0] == row.lattice.axis
        inside_contact = nodes[0] - nodes[1]
        for line, side in enumerate((-1, 1)):
            if on_axis and side < 0:
                continue
            for place, link in enumerate(LINKS.tolist()):
                start = nodes[line] + side * link
                exists = min(start, start + side) >= 0 and max(start, start + side) < row.size
                if exists and link >= inside_contact:
                    found[:, 0, line, place] = self.link(start, side)
        return Advances(*found)

    def relaxed(self, nodes: tuple[int, int]) -> State:
        """The relaxed surface of one contact between these nodes.

        The nodes looked at are those of the row, and those up to where free surfaces are linear.
        """
        first, last = nodes
        row = self.row
        lattice = row.lattice
        start = min(0, first - far(lattice))
        stop = max(row.size - 1, last + far(lattice))
        if lattice.axis == 0:
            start = max(start, -row.first)
        every = np.arange(start, stop + 1)
        passed = self.advances(nodes)
        g = np.full(every.size, -math.inf)
        g[-start : row.size - start] = self.depth - row.f
        model = NodalEnergy(lattice, (every >= first) & (every <= last), row.first + start)
        closes = np.full(2, self.work == lattice.w)  # else springs attach where they touch
        u = model.relaxed(g)
        return State(row, (nodes,), self.depth, self.work, model, u, g, passed, closes)


def on_plain(row: Row, depth: float, branch: str) -> State | None:
    """The state of one contact on the path from first touch, None if it is detached.

    Without tension springs attach as they touch, or for the lowest energy where that pays.

    Parameters
    ----------
    row : Row
    depth : float
        [length].
    branch : {"adhered", "global"}

    Returns
    -------
    State or None

    Raises
    ------
    ValueError
        If the contact reaches the end of the known profile.
    """
    lattice = row.lattice
    work = lattice.w
    if not lattice.gamma1 and branch == "adhered":
        lifted = max(0.0, row.lowest - depth)
        work = min(work, float(lattice.stored(lifted).value) * (1 + _TIE))
    plain = Plain(row, depth, work)
    found = plain.contact()
    if found is None:
        return None
    row.refuse_unknown(depth, (found,))
    return plain.relaxed(found)


def refuse_turning(state: State, lines: Array) -> None:
    """ValueError for a surface that all but turns over, or is in the indenter beyond the contact.

    lines: where they are between the nodes (2,).
    """
    row = state.row
    depth = state.depth
    limit = turning(row.lattice)
    u_lines = depth - row.scene.indenter.height(lines)
    u_nodes = np.abs(depth - row.f[list(state.nodes[0])]) - row.lattice.spacing
    for x, u, u_node in zip(lines.tolist(), u_lines.tolist(), u_nodes.tolist(), strict=True):
        if max(abs(u), u_node) > limit:
            raise ValueError(overhang(depth, f" x = {x!r}", u, limit))
    penetration = (state.g - state.u)[~state.model.contact].max(initial=0.0)
    if penetration > TOLERANCE * state.size:
        raise ValueError(
            f"depth = {depth!r}: beyond the contact the surface is in the indenter; with slopes = "
            f"{row.lattice.slopes!r} nodes support states of one contact only: use method='fitted'"
        )


def overhang(depth: float, where: str, u: float, limit: float) -> str:
    """The message of the error for a surface that would all but turn over.

    Parameters
    ----------
    depth : float
        [length].
    where : str
        " x = ..." of the line, or nothing.
    u, limit : float
        Displacement there, and the largest one that is supported [length].

    Returns
    -------
    str
    """
    return (
        f"depth = {depth!r}: at the contact line{where} the surface is displaced by {u!r}, more "
        f"than 1.3 l + Δx = {limit!r}, where it would all but turn over; use method='fitted', a "
        "smaller |depth|, a smaller w or a blunter indenter"
    )


@dataclass(frozen=True)
class SteepTail(LatticeTail):
    """Free surfaces of a lattice that is not linear, from nodes that begin at the contact line.

    u' at nodes follows from u'' = k u (1 + u'²)^{3/2}/γ₁, k u the springs' pressure, the bracket
    for finite slopes, linear between them, as are u and u'.
    """

    lattice: Lattice

    @functools.lru_cache(maxsize=64)  # noqa: B019
    def _nodes(self, u_line: float) -> tuple[Array, Array]:
        """u and u' outwards at nodes that begin at a line displaced by u_line.

        u' by the chord to the next node and the cubic of which u'' is linear over the link: at its
        beginning it is less than the chord's by Δx/6 (2 u''₀ + u''₁).
        """
        lattice = self.lattice
        spacing = lattice.spacing
        model = NodalEnergy(lattice, np.arange(far(lattice) + 1) == 0)
        u = model.relaxed(np.full(model.contact.size, u_line))
        u = np.append(u, math.exp(-lattice.log_decay) * u[-1])
        slope = np.gradient(u, spacing, edge_order=2) * (lattice.slopes == "finite")
        bend = lattice.stored(u).first / lattice.gamma1 * (1 + slope**2) ** 1.5
        chord = np.diff(u) / spacing
        return u[:-1], chord - spacing / 6 * (2 * bend[:-1] + bend[1:])

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """u and du/dx beside one contact line, the other one None; see `LatticeTail.shape`."""
        line, side = (left, 1) if right is None else (right, -1)  # the surface is on this side
        u_nodes, slope_nodes = self._nodes(float(depth - line.f))
        distance = side * (z - line.x)
        x = self.lattice.spacing * np.arange(u_nodes.size)
        decay = np.exp(-self.rate * np.maximum(distance - x[-1], 0.0))
        u = np.interp(distance, x, u_nodes) * decay
        slope = np.interp(distance, x, slope_nodes) * decay
        return u, side * slope
