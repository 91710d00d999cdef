"""The metastable branch of several contacts on the lattice, from change to change.

A state is a list of contacts, node intervals first..last. As the depth changes, a line passes the
next link or closes the last two (coalescence), a free node touches, a node inside a contact is torn
open, a lone node lets go, each at a depth of its own (`Rules`). Every change lowers the
re-equilibrated energy or leaves it equal; where one calls for others at the same depth, the state
jumps. Forces and energies are those of the contact sets, without interpolation between the nodes.
Facing lines of neighbouring contacts feel each other: they move in avalanches of one link each,
which release O(Δx²).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.lattice.changes import (
    Change,
    Contacts,
    Nodes,
    State,
    lines,
    pressed,
    recedes,
    retracted,
    rises,
)
from discretization.lattice.contact_set import ContactSet, judged, totals
from discretization.lattice.fronts import heights, region
from discretization.lattice.nodes import Lattice
from discretization.lattice.rules import Rules
from discretization.lattice.unseen import Unseen, looked_between, unseen
from energy import Scene

Array = NDArray[np.float64]
_BESIDE = 16  # nodes beside the window, for the certificate
_MANY = 10**6


@dataclass(frozen=True, eq=False)
class ManyContacts:
    """States of any number of contacts on fixed nodes under a prescribed depth; None: detached.

    f (n,): heights of the nodes of the window, which starts with node `first` of the lattice;
    deepest: the largest depth.
    """

    scene: Scene
    lattice: Lattice
    first: int
    f: Array
    rules: Rules
    deepest: float

    @functools.cached_property
    def hidden(self) -> Unseen:
        """What the nodes do not see of the profile."""
        return unseen(self.scene, self.deepest, self.lattice)

    @classmethod
    def of(
        cls, scene: Scene, spacing: float, deepest: float, origin: float | None = None
    ) -> ManyContacts:
        """deepest: the largest depth of the programme. ValueError for what cannot be followed."""
        lattice = Lattice.of(scene, spacing, origin)
        for name, given in (("opening", scene.opening), ("pattern", scene.pattern)):
            if given is not None:
                raise ValueError(f"{name} = {given!r} with several contacts: leave it out")
        if scene.slopes != "small" or not scene.gamma1:
            raise ValueError(
                f"slopes = {scene.slopes!r} with gamma1 = {scene.gamma1!r}: a load path on the "
                "lattice needs slopes='small' and gamma1 > 0"
            )
        if not scene.work_of_adhesion:
            raise ValueError(
                "w = 0 with an indenter that may have several contacts: the state does not depend "
                "on the path; use minimise at every depth"
            )
        where = region(lattice, scene.indenter, deepest)
        if where.last - where.first > _MANY:
            raise ValueError(
                f"spacing = {spacing!r} puts {where.last - where.first} nodes on the indenter; "
                "give it a finite extent, or a larger spacing"
            )
        f = heights(lattice, scene.indenter, np.arange(where.first, where.last + 1, dtype=float))
        return cls(scene, lattice, where.first, f, Rules(lattice, f), deepest)

    @property
    def smooth(self) -> bool:
        """Whether P is a smooth function of d between events."""
        return False

    @property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return float(self.f.min())

    @property
    def lift(self) -> float:
        """How far below touching a contact can be held."""
        return self.scene.critical_separation

    def _state(self, nodes: Nodes) -> State:
        if not nodes:
            return None
        x = (self.lattice.x(self.first + node) for pair in nodes for node in pair)
        return Contacts(nodes, tuple(map(float, x)))

    def contact(self, depth: float, *lines: float) -> State:
        """The state with lines here; nan: detached."""
        if math.isnan(lines[0]):
            return None
        lat = self.lattice
        at = [round((x - lat.origin) / lat.spacing) - self.first for x in lines]
        return self._state(tuple(zip(at[::2], at[1::2], strict=True)))

    def _rising(self, nodes: Nodes) -> Change:
        """The first change as the depth grows."""
        return min(rises(self.rules, nodes), key=lambda change: change.depth)

    def _falling(self, nodes: Nodes) -> Change | None:
        """The first change as the depth falls; None: there is no contact."""
        found = (change for i, _ in enumerate(nodes) for change in recedes(self.rules, nodes, i))
        return max(found, key=lambda change: change.depth, default=None)

    def _walk(
        self, nodes: Nodes, start: float, end: float
    ) -> Iterator[tuple[float, Nodes, Nodes, bool]]:
        """Changes on the way from one depth to another: where, contacts before and after, jump."""
        pressing = end >= start
        while True:
            change = self._rising(nodes) if pressing else self._falling(nodes)
            if change is None or (change.depth > end if pressing else change.depth <= end):
                return
            moved = change.applied(nodes)
            if pressing:
                after = pressed(self.rules, moved, change.depth)
            else:
                after = retracted(self.rules, moved, math.nextafter(change.depth, -math.inf))
            abrupt = change.abrupt or len(after) != len(nodes)
            if not abrupt and after != moved:
                abrupt = self._released(nodes, after, change.depth) > self._least
            yield change.depth, nodes, after, abrupt
            nodes = after

    @property
    def _least(self) -> float:
        """Energy below which a change is no jump: rounding."""
        return 1e-9 * self.lattice.w * self.lattice.spacing

    def _released(self, before: Nodes, after: Nodes, depth: float) -> float:
        energies = (self.energy(Contacts(nodes, ()), depth) for nodes in (before, after))
        return next(energies) - next(energies) if after else math.inf

    def jump(self, state: State, start: float, end: float) -> tuple[float, State, State] | None:
        """First depth on the way at which more than one link changes, and the states beside it."""
        if state is None:
            return None
        for depth, before, after, abrupt in self._walk(state.nodes, start, end):
            if abrupt:
                self._inside(after, depth)
                return depth, self._state(before), self._state(after)
        return None

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        if before is None and depth < self.touch:
            return None
        nodes = pressed(self.rules, () if before is None else before.nodes, depth)
        if before is not None and nodes == before.nodes:
            nodes = retracted(self.rules, nodes, depth)
        self._inside(nodes, depth)
        return self._state(nodes)

    def reached(self, depth: float) -> NDArray[np.int64]:
        """First and last nodes (m, 2), in the lattice's numbers, of the contacts at a depth.

        On the path that touches first and then moves there. Its next change is the one of the least
        depth; to take that one, again and again, until the depth is reached, is the path.
        """
        deepest = max(depth, self.touch)
        nodes = pressed(self.rules, (), deepest)
        self._inside(nodes, deepest)
        if depth < deepest:
            nodes = retracted(self.rules, nodes, depth)
        return np.array(nodes, np.int64).reshape(-1, 2) + self.first

    def _inside(self, nodes: Nodes, depth: float) -> None:
        lo, hi = self.scene.indenter.extent
        for node, end in ((nodes[0][0], lo), (nodes[-1][1], hi)) if nodes else ():
            if node in (0, self.f.size - 1) and end not in self.scene.indenter.walls:
                raise ValueError(
                    f"depth = {depth!r} spreads the contact over the whole known profile; give a "
                    "wider profile or smaller depths"
                )

    def pinned(self, state: State) -> tuple[str, str]:
        """What holds the outermost lines: "edge" or "" where they are free."""
        if state is None:
            return ("", "")
        walls = self.scene.indenter.walls
        ends = zip(state.ends, self.scene.indenter.extent, strict=True)
        near = self.lattice.spacing
        held = ["edge" if end in walls and abs(x - end) < near else "" for x, end in ends]
        return held[0], held[1]

    def _reactions(self, nodes: Nodes, depth: float) -> Iterator[tuple[float, float]]:
        """(g, pull of the free part) of every line."""
        for i, side, other in lines(nodes):
            node = nodes[i][side > 0]
            yield depth - float(self.f[node]), self.rules.pull(node, other, depth)

    def force(self, state: State, depth: float) -> float:
        """P = kΔx Σ g over the contact nodes + the pulls of the free parts."""
        if state is None:
            return 0.0
        total = sum(pull for _, pull in self._reactions(state.nodes, depth))
        for first, last in state.nodes:
            total += self.lattice.spring * float(np.sum(depth - self.f[first : last + 1]))
        return total

    def energy(self, state: State, depth: float) -> float:
        """U of the contact set."""
        if state is None:
            return 0.0
        lat = self.lattice
        total = sum(g * pull / 2 for g, pull in self._reactions(state.nodes, depth))
        for first, last in state.nodes:
            f = self.f[first : last + 1]
            g, steps = depth - f, np.diff(f)
            total += (lat.spring * float(g @ g) + lat.link * float(steps @ steps)) / 2
            total -= lat.w * lat.spacing * (last - first)
        return total

    def friction(self, before: State, after: State) -> float:
        """None: there is one work of adhesion."""
        return 0.0

    def work(self, before: State, start: float, end: float) -> float:
        """∫P dd from one depth to another without a jump: P is linear between changes."""
        if before is None or start == end:
            return 0.0
        done, here, nodes = 0.0, start, before.nodes
        for depth, _, after, _ in self._walk(before.nodes, start, end):
            middle = (here + depth) / 2
            done += (depth - here) * self.force(Contacts(nodes, ()), middle)
            here, nodes = depth, after
        return done + (end - here) * self.force(Contacts(nodes, ()), (here + end) / 2)

    def observed(self, depths: Array, states: Sequence[Contacts]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,) of the contact sets.

        AccuracyWarning where their surfaces miss what the nodes do not see.
        """
        pairs = list(zip(depths.tolist(), states, strict=True))
        lines = [state.lines for state in states]
        looked_between(self.scene, self.lattice, self.hidden, depths, lines, stacklevel=4)
        force = np.array([self.force(state, depth) for depth, state in pairs])
        energy = np.array([self.energy(state, depth) for depth, state in pairs])
        return np.array([state.ends for state in states]), force, energy

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError if something would still happen at this depth, or has not before."""
        if state is None:
            return
        rising, falling = self._rising(state.nodes), self._falling(state.nodes)
        tie = self.rules.tie
        moves = rising.depth < depth - tie(depth, rising.depth)
        if falling is not None:
            moves |= falling.depth > depth + tie(depth, falling.depth)
        if moves:
            raise NotCertifiedError(
                f"the contacts at depth = {depth!r} are not at rest; the path stops before them"
            )
        self._judge(state.nodes, depth)

    def _judge(self, nodes: Nodes, depth: float) -> None:
        """NotCertifiedError unless the surface over these contacts passes its certificate."""
        none = np.full(_BESIDE, -math.inf)
        g = np.concatenate([none, depth - self.f, none])
        contacts = ContactSet(self.lattice, g, np.array(nodes) + _BESIDE, depth)
        certificate = judged(contacts, totals(contacts))
        if not certificate.ok:
            raise NotCertifiedError(
                f"the contacts at depth = {depth!r} violate {', '.join(certificate.failures)} "
                f"({certificate}); the path stops before them"
            )
