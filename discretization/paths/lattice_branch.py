"""The metastable branch on the lattice, with any number of contacts, from change to change.

A state is a list of contacts, node intervals first..last. As the depth changes, a line passes the
next link, two lines meet, a free node touches, a node inside a contact is torn open, a lone node
lets go, each at a depth of its own (../nodes/rules.py). So heights are turned to depths, and
afterwards a line moves by comparing numbers, without a solve. Every change lowers the
re-equilibrated energy or leaves it equal; where one calls for others at the same depth, the state
jumps. A line that moves smoothly releases nothing at any link, hence a branch walked there and back
has no loop area.

Between the nodes the outermost lines are where the depth at which a link is passed, taken at the
middles of the links, equals d; force and energy reported for a step are interpolated there. Where
closing and opening differ a line stays where it last moved. States, events and the energy balance
are those of the contact sets.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate, NotCertifiedError
from discretization.equilibrium import detached
from discretization.lattice.accuracy import Unseen, looked_at, unseen
from discretization.lattice.assembly import refuse_unknown
from discretization.lattice.between import at_offsets, interpolated, moved_lines
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.judge import judge, totals
from discretization.lattice.walk import Walk, Way, parts_of
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Contacts, Parts, Row
from discretization.paths.branch import FollowerBase, Point
from discretization.routes import route
from energy import Scene

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]


class Held(NamedTuple):
    """Contacts as node intervals from left to right, and the positions of all their lines.

    Where closing and opening differ in their work of adhesion lines are where they have last moved,
    between nodes; else, as the depth alone says where they are, on their nodes.
    """

    nodes: Contacts
    lines: tuple[float, ...]

    @property
    def ends(self) -> tuple[float, float]:
        """x of the outermost lines."""
        return self.lines[0], self.lines[-1]


State = Held | None


@dataclass(frozen=True, eq=False)
class LatticeBranch(FollowerBase):
    """States of any number of contacts on fixed nodes under a prescribed depth; None: detached.

    seen: the scene as far as it has nodes.
    """

    scene: Scene
    seen: Scene
    row: Row
    walk: Walk
    deepest: float

    @classmethod
    def of(cls, scene: Scene, spacing: float, deepest: float) -> LatticeBranch:
        """deepest: the largest depth of the programme, which says how many nodes are needed.

        ValueError for springs without tension.
        """
        route(scene, "path", nodes=True)
        lattice = Lattice.of(scene, spacing)
        seen = lattice.seen(scene)
        row = Row.of(seen, lattice, deepest)
        return cls(scene, seen, row, Walk(row), deepest)

    @functools.cached_property
    def hidden(self) -> Unseen:
        """What the nodes do not see of the profile."""
        return unseen(self.seen, self.deepest, self.row.lattice)

    @functools.cached_property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return self.row.lowest

    @property
    def smooth(self) -> bool:
        """Whether P is a smooth function of d between events."""
        return False

    @property
    def resolution(self) -> float:
        """The length by which lines may be off: more than a link, and they jump."""
        return 1.5 * self.row.lattice.spacing

    def _state(self, nodes: Contacts, depth: float, before: State) -> State:
        """The state with these contacts at a depth, when it was `before` on the way here."""
        if not nodes:
            return None
        if not self.scene.hysteretic:
            return Held(nodes, self._on_nodes(nodes))
        return Held(nodes, moved_lines(self.row, nodes, depth, before))

    def _on_nodes(self, nodes: Contacts) -> tuple[float, ...]:
        (lo, hi), lattice, first = self.seen.indenter.extent, self.row.lattice, self.row.first
        x = (lattice.x(first + node) for pair in nodes for node in pair)
        return tuple(min(max(at, lo), hi) for at in x)

    def contact(self, depth: float, *lines: float) -> State:
        """The state whose lines are less than half a link from these positions; nan: detached.

        A line at an edge belongs to the last node.
        """
        if math.isnan(lines[0]):
            return None
        lattice, first = self.row.lattice, self.row.first
        last = self.row.size - 1  # a line at an edge may be up to a link beyond
        at = [min(round((x - lattice.origin) / lattice.spacing) - first, last) for x in lines]
        nodes = tuple(zip(at[::2], at[1::2], strict=True))
        return Held(nodes, lines if self.scene.hysteretic else self._on_nodes(nodes))

    @functools.lru_cache(maxsize=4)  # noqa: B019
    def _way(self, nodes: Contacts, start: float, end: float) -> Way:
        return self.walk.way(nodes, start, end)

    def jump(self, state: State, start: float, end: float) -> tuple[float, State, State] | None:
        """First depth on the way at which more than one link changes, and the states beside it.

        Not where the only contact is lost: `follow` finds that.
        """
        if state is None:
            return None
        way = self._way(state.nodes, start, end)
        if way.at is None:
            return None
        self._inside(way.after, way.at)
        lost = not way.after and len(way.nodes) == 1
        inside = self._state(way.nodes, way.at, state)
        return None if lost else (way.at, inside, self._state(way.after, way.at, inside))

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        walk = self.walk
        nodes = walk.touched(depth) if before is None else walk.moved(before.nodes, depth)
        self._inside(nodes, depth)
        return self._state(nodes, depth, before)

    def _inside(self, nodes: Contacts, depth: float) -> None:
        """ValueError for contacts that reach an end of the known profile."""
        if nodes:
            refuse_unknown(self.row, depth, nodes)

    def pinned(self, state: State) -> tuple[str, str]:
        """What holds the outermost lines: "edge", "tip" or "" where they are free."""
        if state is None:
            return ("", "")
        body, row, held = self.seen.indenter, self.row, []
        ends = (state.nodes[0][0], 0, body.extent[0]), (state.nodes[-1][1], -1, body.extent[1])
        for (node, last, end), x in zip(ends, state.ends, strict=True):
            if end == row.lattice.axis and node == 0:
                held.append("")
                continue
            edge = node == last % row.size and end in body.walls
            tip = body.convex and node == row.touch and x in body.corners
            held.append("edge" if edge else "tip" if tip else "")
        return held[0], held[1]

    def force(self, state: State, depth: float) -> float:
        """P, interpolated between the nodes: that of a contact set jumps at every link."""
        if state is None:
            return 0.0
        return float(self._interpolated([state], np.array([depth]))[1][0])

    def forces(self, points: Sequence[Point]) -> Array:
        """P at points, of those with as many contacts at once."""
        found = np.zeros(len(points))
        counts = np.array([len(p.state.nodes) if p.state is not None else 0 for p in points])
        for count in np.unique(counts[counts > 0]).tolist():
            own = np.flatnonzero(counts == count)
            alike = [points[i] for i in own.tolist()]
            depths = np.array([point.depth for point in alike])
            found[own] = self._interpolated([point.state for point in alike], depths)[1]
        return found

    def _interpolated(self, states: Sequence[Held], depths: Array) -> tuple[Array, Array, Array]:
        """Lines, P and U of states with as many contacts each."""
        nodes = np.array([state.nodes for state in states]).reshape(len(states), -1)
        lines = np.array([state.lines for state in states]) if self.scene.hysteretic else None
        return interpolated(self.row, nodes, depths, lines)

    def energy(self, state: State, depth: float) -> float:
        """U of the contact set."""
        if state is None:
            return 0.0
        return self.total(self.row.energies, state, depth)

    def total(self, parts: Parts, state: Held, depth: float) -> float:
        """P or U of a contact set; parts: `forces` or `energies` of the row."""
        nodes = np.array(state.nodes).reshape(1, -1)
        return float(at_offsets(self.row, nodes, 0.0 * nodes, np.array([depth]), parts)[0])

    def friction(self, before: State, after: State) -> float:
        """(w_opening - w) for every link that opened without a jump."""
        if before is None or after is None:
            return 0.0
        more = self.scene.opened.work_of_adhesion - self.scene.work_of_adhesion
        return max(0.0, self._bonds(before) - self._bonds(after)) * more

    def _bonds(self, state: Held) -> float:
        """Length in contact, weighted with the pattern's factor."""
        bonds = self.row.sums.bonds
        return float(sum(bonds[last] - bonds[first] for first, last in state.nodes))

    def work(self, point: Point, depth: float) -> float:
        """∫P dd from one depth to another without a jump: P is linear between changes."""
        if point.state is None:
            return 0.0
        return self.walk.work(self._way(point.state.nodes, point.depth, depth).lives)

    def observed(self, depths: Array, states: Sequence[Held]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,), interpolated between the nodes.

        AccuracyWarning where the surfaces miss what the nodes do not see.
        """
        if self.hidden.x.size:
            lattice, flat = self.row.lattice, Certificate.undeformed()
            apart = detached(self.scene, 0.0, "adhered", lattice.tail, flat)
            whole = [
                replace(apart, depth=depth, contacts=np.reshape(state.lines, (-1, 2)))
                for depth, state in zip(depths.tolist(), states, strict=True)
            ]
            looked_at(whole, self.hidden, lattice, stacklevel=4)
        x, force, energy = np.empty((depths.size, 2)), np.empty(depths.size), np.empty(depths.size)
        counts = np.array([len(state.nodes) for state in states])
        for count in np.unique(counts).tolist():
            own = np.flatnonzero(counts == count)
            alike = [states[i] for i in own.tolist()]
            lines, force[own], energy[own] = self._interpolated(alike, depths[own])
            x[own] = lines[:, [0, -1]]
        return x, force, energy

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError if something would still happen at this depth, or has not before."""
        if state is None:
            return
        tie, parts = self.walk.closing.tie, parts_of(state.nodes)
        rising, falling = (self.walk.first(parts, sign)[0].depth for sign in (1, -1))
        if rising < depth - tie(depth, rising) or falling > depth + tie(depth, falling):
            raise NotCertifiedError(
                f"the contacts at depth = {depth!r} violate neighbours: a line has not come to "
                "rest; the path stops before them"
            )
        contacts = ContactSet(self.row, state.nodes, depth)
        certificate = judge(contacts, totals(contacts))
        certificate.demand(f"the state at depth = {depth!r}", "the path stops before it")
