"""One contact on nodes in the simplest way there is: read this first.

The unknowns are the displacements u_i of the nodes, U is their `NodalEnergy`. While some nodes are
held in contact, u = g = d - f there, all others minimise a convex function: Newton's method, each
step of which is one tridiagonal solve. Descent in u alone can never move a contact line, as lifting
a contact node costs its adhesion at once, and a free node has to cross a finite gap. So energies of
neighbouring contact sets are compared, each with its surface relaxed: from the node that touches
first a line passes link after link while that lowers the energy, or while the surface beyond would
be in the indenter. In contact u is prescribed, so that neither line feels the other one.

Small or finite slopes, with or without surface tension and adhesion, line contact or axis. States
with finite slopes, and those of independent springs (γ₁ = 0), come from here; for small slopes the
rest of the package knows free surfaces in closed form, is faster, and has the same answer.
"""

import bisect
import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import TOLERANCE
from discretization.lattice.judge import State
from discretization.lattice.line import LINKS, Advances
from discretization.nodes.lattice import Lattice, LatticeTail
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.row import Row
from energy import terms
from energy.arrays import Array

FAR = 12.0  # decay lengths, beyond which a free surface is linear and known
MOST = 400_000  # nodes of a free surface
TURNING = 1.3  # displacement in l; at √2 a surface of finite slope turns over
_TIE = 1e-12  # relative slack that keeps a line where both sides cost the same


def far(lattice: Lattice) -> int:
    """Nodes of a free surface up to where it is linear. ValueError if these are too many."""
    count = math.ceil(FAR / lattice.log_decay) + 1
    if count > MOST:
        raise ValueError(
            f"spacing = {lattice.spacing!r} puts {count} nodes on a free surface, each an unknown "
            f"with slopes = {lattice.slopes!r}: use method='fitted', or a larger spacing"
        )
    return count


def turning(lattice: Lattice) -> float:
    """Displacement at which a surface of finite slope, resolved to a link, would all but turn."""
    length = math.sqrt(lattice.gamma1 / lattice.k)
    return TURNING * length + lattice.spacing if lattice.slopes == "finite" else math.inf


@dataclass(frozen=True, eq=False)
class Plain:
    """Contact over a row of nodes at a depth; work: of adhesion, for which a line passes a link."""

    row: Row
    depth: float
    work: float

    def g(self, node: int) -> float:
        """d - f at a node."""
        return self.depth - float(self.row.f[node])

    def outside(self, node: int, side: int) -> tuple[float, float, float]:
        """A surface held at this node and free beyond: its energy, the force there, the next u."""
        anywhere = self.row.lattice.axis != 0  # or wherever the line is
        at = (-self.row.first, 1) if anywhere else (node, side)
        return self._outside(*at, self.g(node))

    @functools.lru_cache(maxsize=1 << 12)  # noqa: B019
    def _outside(self, node: int, side: int, u_line: float) -> tuple[float, float, float]:
        """The same, displaced by so much there."""
        lattice, at = self.row.lattice, self.row.first + node
        if not lattice.gamma1:  # a spring alone
            held, size = lattice.stored(u_line), lattice.cell * lattice.weight(at)
            return size * float(held.value), size * float(held.first), 0.0
        count = far(lattice) + 2
        first, held = min(node, node + side * (count - 1)), np.arange(count)[::side] == 0
        model = NodalEnergy(lattice, held, self.row.first + first, tails=(side < 0, side > 0))
        found = model.balance(u := model.relaxed(np.full(count, u_line)))
        energy = found.energy - found.terms["adhesion"]
        return energy, float(found.forces[::side][0]), float(u[::side][1])

    def link(self, node: int, side: int) -> tuple[float, ...]:
        """What the link outwards from a line at this node takes: one of each of `Advances`.

        What is stored is the difference of energies; without adhesion half the force times the way.
        """
        lattice, after = self.row.lattice, node + side
        (energy, force, u), (other, pressed, _) = (self.outside(at, side) for at in (node, after))
        own, slope = self.g(node), (self.g(after) - self.g(node)) / lattice.spacing
        at = self.row.first + node
        held, cell = lattice.stored(own), lattice.cell * lattice.weight(at)
        size = lattice.cell * lattice.weight(at + side * (0.5 + lattice.edge))
        stretch = terms.surface(slope, gamma1=lattice.gamma1 * size, slopes=lattice.slopes)
        gap = u - self.g(after)
        stored = max(other + cell * float(held.value) + float(stretch.value) - energy, 0.0)
        if not lattice.w:
            stored = abs(gap * (pressed + float(stretch.first) / lattice.spacing)) / 2
        elif lattice.slopes == "finite":
            size *= math.hypot(1.0, slope)
        return gap, stored, pressed + cell * float(held.first) - force, size

    def resists(self, node: int, side: int) -> bool:
        """Whether a line at this node does not pass the next link outwards."""
        lattice, scene, u = self.row.lattice, self.row.scene, self.g(node)
        if u > turning(lattice):
            return False  # it would turn over, into the indenter
        if scene.indenter.convex and -u > (1 + _TIE) * scene.critical_separation:
            return True  # no flat face would hold, and no link beyond this one
        gap, stored, _, bonds = self.link(node, side)
        return gap > 0 and stored > self.work * bonds * (1 + _TIE)

    def outermost(self, side: int) -> int:
        """The node at which a line comes to rest that starts at the node that touches first.

        Where the profile is convex the gap grows outwards, so that many links are passed at once.
        Else the line is pressed first, and comes back as the indenter is withdrawn.
        """
        row, start, end = self.row, self.row.touch, self.row.size - 1 if side > 0 else 0
        ahead, resists = range(start, end, side), functools.partial(self.resists, side=side)
        if row.scene.indenter.convex:
            return start + side * bisect.bisect_left(ahead, True, key=resists)
        if self.depth >= row.lowest:
            return next(filter(resists, ahead), end)
        back = range(Plain(row, row.lowest, self.work).outermost(side), start, -side)
        return next((node for node in back if not resists(node - side)), start)

    def contact(self) -> tuple[int, int] | None:
        """First and last node in contact on the path from first touch on; None: detached."""
        row, pulled = self.row, self.row.lowest - self.depth
        if pulled > (1 + _TIE) * row.scene.critical_separation:
            return None
        left, right = self.outermost(-1), self.outermost(1)
        return None if left == right and pulled > 0 and row.lattice.gamma1 else (left, right)

    def advances(self, nodes: tuple[int, int]) -> Advances:
        """What passing the links beside both lines changes, by which they are between nodes."""
        found, row = np.full((4, 1, 2, LINKS.size), math.nan), self.row
        on_axis = row.first + nodes[0] == row.lattice.axis
        for i, j in np.ndindex(2, LINKS.size):
            side, link = 2 * i - 1, int(LINKS[j])
            start = nodes[i] + side * link
            inside = min(start, start + side) >= 0 and max(start, start + side) < row.size
            if inside and link >= nodes[0] - nodes[1] and not (on_axis and side < 0):
                found[:, 0, i, j] = self.link(start, side)
        return Advances(*found)

    def relaxed(self, nodes: tuple[int, int]) -> State:
        """The relaxed surface of one contact between these nodes.

        The nodes looked at are those of the row, and those up to where free surfaces are linear.
        """
        (first, last), row, lattice = nodes, self.row, self.row.lattice
        start, stop = min(0, first - far(lattice)), max(row.size - 1, last + far(lattice))
        start = max(start, -row.first) if lattice.axis == 0 else start
        every, passed = np.arange(start, stop + 1), self.advances(nodes)
        g = np.full(every.size, -math.inf)
        g[-start : row.size - start] = self.depth - row.f
        model = NodalEnergy(lattice, (every >= first) & (every <= last), row.first + start)
        closes = np.full(2, self.work == lattice.w)  # else springs attach where they touch
        u = model.relaxed(g)
        return State(row, (nodes,), self.depth, self.work, model, u, g, passed, closes)


def on_plain(row: Row, depth: float, branch: str) -> State | None:
    """The contact on the path; without tension, where springs attach as they touch or, for the
    lowest energy, where that pays. ValueError for one that reaches the end of the known profile."""
    lattice, work = row.lattice, row.lattice.w
    if not lattice.gamma1 and branch == "adhered":
        work = min(work, float(lattice.stored(max(0.0, row.lowest - depth)).value) * (1 + _TIE))
    plain = Plain(row, depth, work)
    if (found := plain.contact()) is None:
        return None
    row.refuse_unknown(depth, (found,))
    return plain.relaxed(found)


def refuse_turning(state: State, lines: Array) -> None:
    """ValueError for a surface that all but turns over, or is in the indenter beyond the contact.

    lines: where they are between the nodes (2,).
    """
    row, depth, limit = state.row, state.depth, turning(state.row.lattice)
    off = depth - row.scene.indenter.height(lines)
    own = np.abs(depth - row.f[list(state.nodes[0])]) - row.lattice.spacing
    for x, u, most in zip(lines.tolist(), off.tolist(), own.tolist(), strict=True):
        if max(abs(u), most) > limit:
            raise ValueError(overhang(depth, f" x = {x!r}", u, limit))
    if (state.g - state.u)[~state.model.contact].max(initial=0.0) > TOLERANCE * state.size:
        raise ValueError(
            f"depth = {depth!r}: beyond the contact the surface is in the indenter; with slopes = "
            f"{row.lattice.slopes!r} nodes answer states of one contact only: use method='fitted'"
        )


def overhang(depth: float, where: str, u: float, limit: float) -> str:
    """What to say of a surface that would all but turn over."""
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
        """u and u' outwards."""
        lat = self.lattice
        model = NodalEnergy(lat, np.arange(far(lat) + 1) == 0)
        u = model.relaxed(np.full(model.contact.size, u_line))
        u = np.append(u, math.exp(-lat.log_decay) * u[-1])
        steep = np.gradient(u, lat.spacing, edge_order=2) * (lat.slopes == "finite")
        bend = lat.stored(u).first / lat.gamma1 * (1 + steep**2) ** 1.5
        chord = np.diff(u) / lat.spacing
        return u[:-1], chord - lat.spacing / 6 * (2 * bend[:-1] + bend[1:])

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """u and u' beside one contact line."""
        line, side = (left, 1) if right is None else (right, -1)
        nodes, distance = self._nodes(float(depth - line.f)), side * (z - line.x)
        x = self.lattice.spacing * np.arange(nodes[0].size)
        decay = np.exp(-self.rate * np.maximum(distance - x[-1], 0.0))
        u, slope = (np.interp(distance, x, part) * decay for part in nodes)
        return u, side * slope
