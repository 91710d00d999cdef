"""The metastable branch on the lattice, with any number of contacts, from change to change.

A state is a list of contacts, node intervals first..last, which walk.py takes from depth to depth.
What is reported for a step, lines, force and energy, is interpolated between nodes (subgrid.py);
states, events and the energy balance are those of the contact sets, but for the depths of first
touch, by the parabola through three nodes, and at which contacts are lost (lattice/loss.py).

Conventions
-----------
The depth d is positive down into the layer, heights f of the profile upwards [length]; `direction`
is 1 where the depth grows. P is positive where pressed, U is 0 without contact; for a line contact
both count per length of it.

Contacts are pairs (first, last) of node numbers from left to right, counted from the first node of
the row of nodes under the profile (`Row`); x = origin + (row.first + number) · spacing, but for the
edges of the body, where lines stand at the edge itself. A link is what lies between neighbouring
nodes. `paired` makes such pairs of a flat tuple of node numbers. Lines of a point are x of both
ends of all contacts, a flat tuple.

`Walk.track(contacts, depth, goal)` takes contacts from a depth towards another: it gives the depths
at which they change with the flat node numbers from there on, the depth of the first event, or
None, and the contacts beyond that. `subgrid` finds lines between nodes, and what U and P are more
with lines there than with lines on nodes.

Of the nodes, `Lattice` has the spacing, `scene_on_nodes` is the scene that they see (about an axis
r >= 0 alone), `tail` stands for a free surface where one is needed, and `axis` is the number of the
node on the axis, nan if there is none. `Row.refuse_unknown` raises ValueError for contacts that
reach an end of the known profile. `ContactLoss.smooth` is whether neither profile nor pattern has a
corner beside a node. `subgrid.of_states` are the lines of states with what U and P are more by them
(2, n), `subgrid.moved` the lines that two works of adhesion hold where they have last moved, and
`subgrid.advances` the changes as lines pass their next links. `on_row` is the state on nodes with
its `certificate`, whose `demand` raises NotCertifiedError if it fails.

`hysteretic` scenes hold lines over a range of depths, by two works of adhesion. Of the indenter,
`extent` are the ends of the known profile, `walls` those at which the body itself ends, `corners`
where its slope jumps, and `convex` profiles have a single contact. What nodes do not see of the
profile is `unseen` of it; there are warnings for lines that the profile does not let rest
(`warn_lines`), for contacts that nodes lose though the profile holds them (`warn_losses`), for
contacts too narrow for nodes (`warn_narrow`, at the lowest point that `lowest_within` finds), and
for surfaces that miss the profile between nodes (`warn_unresolved`). `route` raises ValueError for
scenes that nodes cannot follow. `alike` gives numbers of the points with the same number of lines.

A `Branch` (branch.py) has the states at imposed depths: `segment(point, goal)` is the path from a
`Point` (depth, lines, None without contact, and its memory, here the contacts) towards a depth, up
to an event. A `PathSegment` has its points `start` and `end`, the point `after` the event, None if
there is none, and whether lines jump there. `Pinned` are two words, where the left and the right
outermost line is pinned, "" if free. A `Snapshot` is a point with its force and energy, put
together by `snapshot_of`. `Certificate.undeformed` is that of a surface without contact; δ₀ =
√(2w/k) is `critical_separation`.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import detached
from discretization.lattice import subgrid
from discretization.lattice.certificate import on_row
from discretization.lattice.unresolved import (
    Unseen,
    lowest_within,
    unseen,
    warn_lines,
    warn_losses,
    warn_narrow,
    warn_unresolved,
)
from discretization.lattice.walk import Walk, paired
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Contacts, Row, positions
from discretization.paths.branch import (
    Branch,
    PathSegment,
    Pinned,
    Point,
    Snapshot,
    alike,
    snapshot_of,
)
from discretization.routes import route
from energy import Scene
from energy.arrays import Array, Nodes

# Of the depth and δ₀: depths of one closing, some thousand roundings. 1e-13 or 1e-11 changes no
# result (`python -m tests.sensitivity discretization.paths.lattice_branch`).
_SAME = 1e-12


@dataclass(eq=False)
class LatticeSegment(PathSegment):
    """A segment on which lines pass links, each at a depth of its own.

    Attributes
    ----------
    trace : sequence of (float, tuple of int)
        Depths, in the order of the path, with the first and last nodes of all contacts from there
        on, as in the `Track` of the walk. The first depth is that of the start.
    """

    trace: Sequence[tuple[float, tuple[int, ...]]]

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths (n,) on the segment: those since the last change before each."""
        direction = 1 if self.end.depth >= self.start.depth else -1
        changed = direction * np.array([depth for depth, _ in self.trace])
        last = np.searchsorted(changed, direction * depths, side="right") - 1
        contacts = [paired(self.trace[i][1]) for i in last.tolist()]
        return list(self.branch.points(contacts, depths, self.start))

    def external_work(self) -> float:
        """∫P dd of the contact sets from the start to the end.

        P is linear in d between changes, so that it is that at the middle of each part.
        """
        depths = np.array([depth for depth, _ in self.trace] + [self.end.depth])
        nodes = np.array([nodes for _, nodes in self.trace]).reshape(len(self.trace), -1)
        spans = np.diff(depths)
        _, force = self.branch.row.totals(nodes, depths[:-1] + spans / 2)
        return float(spans @ force)


@dataclass(frozen=True, eq=False)
class LatticeBranch(Branch):
    """Any number of contacts on fixed nodes under a prescribed depth.

    The memory of a point are its contacts as pairs of nodes. Its lines are at these nodes. Only
    where the works of adhesion of closing and opening differ they stand between nodes, where they
    have last moved.

    Attributes
    ----------
    scene : Scene
        As given; that of `row` has the profile that the nodes see.
    row : Row
        The nodes, with the profile on them.
    walk : Walk
        Takes contacts on them from depth to depth.
    hidden : Unseen
        Where the nodes do not see the profile.
    """

    scene: Scene
    row: Row
    walk: Walk
    hidden: Unseen
    smooth = False

    @classmethod
    def of(cls, scene: Scene, spacing: float, deepest: float) -> LatticeBranch:
        """The branch of a scene.

        Parameters
        ----------
        scene : Scene
        spacing : float
            Of the nodes [length].
        deepest : float
            The largest depth of the programme, for which there have to be nodes [length].

        Returns
        -------
        LatticeBranch

        Raises
        ------
        ValueError
            For springs without tension.
        """
        route(scene, "path", nodes=True)
        lattice = Lattice.of(scene, spacing)
        seen = lattice.scene_on_nodes(scene)
        row = Row.of(seen, lattice, deepest)
        return cls(scene, row, Walk(row, narrow=True), unseen(seen, deepest, lattice))

    @property
    def touch(self) -> float:
        """Depth at which contact begins [length]."""
        return self._touching[0]

    @functools.cached_property
    def _touching(self) -> tuple[float, Contacts]:
        """Depth at which contact begins, and the contacts there.

        The depth is the height at which the parabola through the lowest node and both beside it is
        lowest. It is that of the lowest node itself where this is at a corner, and where the
        contact would not spread at the depth of the parabola.
        """
        row = self.row
        node = self.row.touch  # number of the lowest node
        lowest = self.row.lowest  # and its height
        own = ((node, node),)
        if self.walk.loss is not None and self.walk.loss.smooth(node):
            before, here, after = row.f[node - 1 : node + 2].tolist()
            bend = before - 2 * here + after
            if before != after and bend > 0:
                depth = here - (after - before) ** 2 / (8 * bend)
                spread = self.walk.moved(own, depth, depth)
                if spread and spread[0][0] < spread[0][1]:
                    return depth, spread
        return lowest, self.walk.moved(own, lowest, lowest)

    @property
    def resolution(self) -> float:
        """The length by which lines may be off: a link, by which they jump, and half of one."""
        return 1.5 * self.row.lattice.spacing

    def point(self, nodes: Contacts, depth: float, before: Point) -> Point:
        """The point with these contacts at a depth, on the path from a point `before`.

        Without contacts it is detached. ValueError for contacts that reach an end of the known
        profile.
        """
        return self.points([nodes], np.array([depth]), before)[0] if nodes else Point(depth, None)

    def points(self, nodes: list[Contacts], depths: Array, before: Point) -> list[Point]:
        """Points with these contacts at depths (n,), all with as many contacts, not detached.

        nodes: pairs of first and last nodes of the contacts of each; before: the point of the path
        that comes before them, from which lines that resist have moved on. ValueError for contacts
        that reach an end of the known profile.
        """
        for each, depth in zip(nodes, depths.tolist(), strict=True):
            self.row.refuse_unknown(depth, each)
        if self.scene.hysteretic:
            lines = subgrid.moved(self.row, nodes, depths, before.memory, before.lines or ())
        else:
            at = self.row.first + np.array(nodes).reshape(len(nodes), -1)
            x = positions(self.row.lattice, self.row.scene.indenter, at)
            lines = [tuple(own) for own in x.tolist()]
        return list(map(Point, depths.tolist(), lines, nodes))

    def _on_nodes(self, nodes: Contacts) -> tuple[float, ...]:
        """Positions of both ends of all contacts, at their nodes [length]."""
        at = self.row.first + np.ravel(nodes)
        return tuple(positions(self.row.lattice, self.row.scene.indenter, at).tolist())

    @property
    def first(self) -> Point:
        """The contacts at first touch."""
        depth, nodes = self._touching
        return self.point(nodes, depth, Point(depth, (), ()))

    def contact(self, depth: float, *lines: float) -> Point:
        """The point whose lines are less than half a link from these positions.

        A line at an edge belongs to the last node.
        """
        nodes = contacts_at(self.nearest(np.array(lines)))
        return Point(depth, lines if self.scene.hysteretic else self._on_nodes(nodes), nodes)

    def nearest(self, lines: Array) -> Nodes:
        """Numbers of the nodes nearest to lines; at an edge beyond the last node that one."""
        lattice = self.row.lattice
        at = np.rint((lines - lattice.origin) / lattice.spacing).astype(int) - self.row.first
        return np.minimum(at, self.row.size - 1)

    def segment(self, point: Point, goal: float) -> LatticeSegment:
        """The path from a point towards another depth, up to the first event.

        Or to where an outermost line becomes pinned or free.
        """
        trace, event_depth, beyond = self.walk.track(point.memory, point.depth, goal)
        stop = goal if event_depth is None else event_depth
        pinned = [self.pinned_at(nodes[0], nodes[-1]) for _, nodes in trace]
        for i in range(1, len(trace)):
            depth = trace[i][0]
            if pinned[i] != pinned[i - 1] and depth not in (point.depth, stop):
                here, there = (
                    self.point(paired(nodes), depth, point) for _, nodes in trace[i - 1 : i + 1]
                )
                return LatticeSegment(self, point, here, there, False, trace[:i])
        low, high = sorted((point.depth, goal))
        last = paired(trace[-1][1])
        end = self.point(last, min(max(stop, low), high), point)  # outside only by rounding
        after = None if event_depth is None else self.point(beyond, end.depth, end)
        # The loss of the last contact is no jump of a line; every other event is.
        lost = after is not None and after.lines is None and len(last) == 1
        return LatticeSegment(self, point, end, after, after is not None and not lost, trace)

    @functools.cached_property
    def _pinning(self) -> tuple[dict[int, str], dict[int, str]]:
        """Where a left line is pinned, and where a right one: "edge" or "tip" by node number."""
        body = self.row.scene.indenter
        lowest_node = self.row.touch
        lowest, _ = self._on_nodes(((lowest_node, lowest_node),))
        first, last = body.extent
        left = dict[int, str]()
        right = dict[int, str]()
        if body.convex and lowest in body.corners:
            kind = "edge" if lowest in self.scene.indenter.walls else "tip"
            left[lowest_node] = kind
            right[lowest_node] = kind
        if first in body.walls:
            left[0] = "edge"
        if last in body.walls:
            right[self.row.size - 1] = "edge"
        if first == self.row.lattice.axis:  # a disc has no left line
            left = {}
        return left, right

    def pinned_at(self, first: int, last: int) -> Pinned:
        """Where the outermost lines are pinned if these are the first and last nodes of all."""
        left, right = self._pinning
        return left.get(first, ""), right.get(last, "")

    def pinned(self, point: Point) -> Pinned:
        """Where each of the outermost lines is pinned: "edge", "tip" or "" where it is free."""
        if point.lines is None:
            return "", ""
        return self.pinned_at(point.memory[0][0], point.memory[-1][1])

    def totals(self, points: Sequence[Point]) -> Array:
        """U and P (2, n), interpolated between the nodes: those of a contact set jump at links."""
        return self._interpolated(points)[:2]

    def _interpolated(self, points: Sequence[Point], *, looked: bool = False) -> Array:
        """U, P and both outermost lines between the nodes, of points in contact.

        Parameters
        ----------
        points : sequence of Point
            n of them.
        looked : bool
            Whether to warn of lines where the profile between nodes does not let them rest.

        Returns
        -------
        ndarray (4, n)
            In its rows U, P, and x of the first and of the last line.
        """
        row = self.row
        found = np.empty((4, len(points)))
        all_depths = np.array([point.depth for point in points])
        # Lines of each point, and by what U and P (2, n) are more than those of the contact sets.
        # With hysteresis lines stand where they have last moved, which the points know.
        of_points: list[Array] = []
        if not self.scene.hysteretic:
            of_points, more = subgrid.of_states(row, [p.memory for p in points], all_depths)
        for own in alike(points):
            nodes = np.array([points[i].memory for i in own]).reshape(len(own), -1)
            depths = all_depths[own]
            found[:2, own] = row.totals(nodes, depths)
            if self.scene.hysteretic:
                known = np.array([points[i].lines for i in own])
                passed = subgrid.advances(row, nodes, depths)
                lines, by_line = subgrid.between(row, nodes, depths, passed, known)
                added = by_line.sum(axis=-1)
            else:
                lines = np.array([of_points[i] for i in own])
                added = more[:, own]
            found[:2, own] += added
            found[2:, own] = lines[:, 0], lines[:, -1]
            if looked:
                warn_lines(self.scene, row.lattice, depths, lines, stacklevel=6)
        return found

    def snapshots(self, points: Sequence[Point]) -> list[Snapshot]:
        """Points just before or after events: U of the contact sets, and P between the nodes."""
        in_contact = [point for point in points if point.lines is not None]
        forces = iter(self.totals(in_contact)[1].tolist() if in_contact else [])
        found = []
        for point in points:
            energy = 0.0
            force = 0.0
            if point.lines is not None:
                energy = self.walk.energy(point.memory, point.depth)
                force = next(forces)
            found.append(snapshot_of(point, energy, force, self.scene.axisymmetric))
        return found

    def total(self, point: Point) -> Array:
        """U of the contact set, and P between the nodes (2,); 0 when detached."""
        energy = 0.0 if point.lines is None else self.walk.energy(point.memory, point.depth)
        return np.array([energy, super().total(point)[1]])

    def opened(self, before: Point, after: Point) -> float:
        """The length of the links that open between two points, weighted with the pattern's factor.

        0 where links close.
        """
        return self.walk.opened(before.memory or (), after.memory or ())

    def recorded(self, points: Sequence[Point]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,), interpolated between the nodes.

        AccuracyWarning where the surfaces miss what the nodes do not see.
        """
        lattice = self.row.lattice
        # States without more than depth and contacts, which the warning reads.
        flat = Certificate.undeformed()
        without_contact = detached(self.scene, 0.0, "adhered", lattice.tail, flat)
        states = (
            replace(
                without_contact, depth=point.depth, contacts=np.array(point.lines).reshape(-1, 2)
            )
            for point in points
        )
        warn_unresolved(states, self.hidden, lattice, stacklevel=4)
        for one, other in itertools.pairwise(points if self.scene.work_of_adhesion else ()):
            before = one.lines or ()
            after = other.lines or ()
            if len(after) < len(before) and other.depth < one.depth:
                warn_losses(self.scene, lattice, other.depth, before, after, stacklevel=4)
        energy, force, *lines = self._interpolated(points, looked=True)
        return np.array(lines).T, force, energy

    def closes_at(self, state: Snapshot) -> bool:
        """Whether the last contact, of a node or a link, is lost at the depth where its lines meet.

        That depth is that of the links they would pass (lattice/loss.py); a contact that lets go
        from more nodes, or at another depth, is lost too early.
        """
        contacts = self.contact(state.depth, *state.lines).memory
        first, last = contacts[0]
        if len(contacts) > 1 or last - first > 1 or self.walk.loss is None:
            return False
        depth = self.walk.loss.depth(None, first, None)
        size = abs(depth) + self.scene.opened.critical_separation
        return abs(depth - state.depth) <= _SAME * size

    def released(self, depth: float, left: float, right: float) -> None:
        """AccuracyWarning if at this depth a contact is narrower than the nodes can hold."""
        scene = self.scene
        lattice = self.row.lattice
        lowest = None
        if not scene.indenter.convex:
            lowest = lowest_within(scene, lattice, left, right)
        warn_narrow(scene, lattice, depth, "adhered", lowest, stacklevel=5)

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contacts are in equilibrium on the nodes.

        Then nothing would still happen at this depth, and nothing should have happened before.
        """
        depth, lines, nodes = point
        if lines is not None:
            certificate = on_row(self.row, nodes, depth, narrow=True).certificate
            certificate.demand(f"the state at depth = {depth!r}", "the path stops before it")


def contacts_at(nodes: Nodes) -> Contacts:
    """The contacts with these first and last nodes, a flat array (2m,), as pairs."""
    ends = nodes.tolist()
    return tuple(zip(ends[::2], ends[1::2], strict=True))
