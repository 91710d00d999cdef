"""The metastable branch of several contacts of a line contact, found on nodes and refined.

A route in one direction is refined at once (../refine/plan.py); segments are the parts of it
between events and the depths at which a line becomes pinned or free. Where the route
cannot be refined from nodes of the usual distance, closer ones are tried. Where these fail as well,
the part of the route next to the failure keeps what nodes alone know (lattice_branch.py), and
`on_nodes` says at which depths.

Conventions
-----------
The depth d is positive down into the layer [length]; `direction` is 1 where it grows along a route
and -1 where it falls. P is positive where the indenter is pressed; P and the energy U count per
length of the contact.

Lines of a point are a flat tuple: both ends of every contact from left to right. Those of all free
surfaces are an array (m + 1, 2) for m contacts: row by row the left and the right line, at -inf and
inf for the two tails. `lines_of_surfaces` and `free_surfaces` turn one into the other.

Words of refine/: a `Route` is a part of a path in one direction, refined; it consists of stretches
of smooth motion (`Stretch`, numbered from 0), which end at events; its `lines` are those of all
surfaces (m + 1, k, 2) at k depths. `NotRefined` is raised where it cannot be refined, with the
depth of the failure. A `Refinement` belongs to nodes of one closeness, whose spacing is the usual
one divided by CLOSER[level]; its `nodes.margin` is how much depths of events on nodes may be off.
Contacts on nodes are pairs of first and last nodes (row.Contacts).

`Refinement.of` has, with its nodes, the `equations` of lines at rest and the `totals`, of which
`of_surfaces` are U and P that each free surface accounts for (2, n). Its `touched()` gives the
contacts at first touch, the depth at which they rest on nodes, and their lines; `follow(contacts,
on_nodes, lines, start, goal)` the stretches to a depth. `Route.next_cut` is the first depth ahead
at which a line becomes pinned or free, `work` is ∫P dd, and `lines_of_routes` are the lines on
parts of many routes at once. `settle` takes lines to rest from nearby, with `at_rest` for each
surface. `known_lines` are the lines of surfaces, ValueError if one has left the known profile. A
`Judge` certifies many states at once (`certificates`); `ok` is whether one passes, and `demand`
raises NotCertifiedError if not. Routes end ASIDE margins before a depth of failure.

`LatticeBranch.nearest` are numbers of the nodes nearest to lines, and `row.lattice.spacing` is
their distance. Of the indenter, `corners` and `knots` are where f' or a higher derivative jumps,
for measured profiles the samples; `noise_slope` is the rms slope of their noise, None without
samples. `hysteretic` scenes hold lines over a range of depths, by two works of adhesion; `opened`
is the scene with that of contacts that open.

A `FittedBranch` has the states at imposed depths: `segment(point, goal)` is the path from a `Point`
(depth, lines, None without contact, and its memory, here a `Place`) towards a depth, up to an
event. A `PathSegment` has its points `start` and `end`, the point `after` the event, None if there
is none, and whether lines jump there. A `Snapshot` is a point with its force and energy, put
together by `snapshot_of`. `Integrals.hidden` are places of features that samples of the profile
have missed, of which `warn_hidden` warns.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.contact_lines import ContactLines
from discretization.nodes import row
from discretization.paths.branch import PathSegment, Point, Snapshot, snapshot_of
from discretization.paths.fitted_branch import FittedBranch
from discretization.paths.lattice_branch import LatticeBranch, LatticeSegment
from discretization.profile import Resolved, resolve, warn_hidden
from discretization.quadrature import Integrals
from discretization.refine.equations import free_surfaces, lines_of_surfaces
from discretization.refine.events import NotRefined
from discretization.refine.judged import Judge
from discretization.refine.plan import ASIDE, Refinement
from discretization.refine.route import Route, lines_of_routes
from discretization.refine.settle import settle
from discretization.refine.states import CLOSER, known_lines
from energy import Scene
from energy.arrays import Array


class RefinementRules(NamedTuple):
    """When contacts on nodes are refined, and when they are left to the nodes.

    Halved or doubled, each leaves the 8 or more random states and paths that read it as they are to
    1e-9 (`beyond`, `noise` and `near_nodes` are not read there): `python -m tests.sensitivity
    discretization.paths.refined_branch`.

    Attributes
    ----------
    beyond : float
        Margins beyond a depth at which nodes fail, up to which the route is left to nodes.
    most_failures : int
        Of nodes of a closeness, after which closer ones are taken for all that is left; and
        segments on nodes alone, after which all is. Each costs a walk to the end of the route.
    noise : float
        Of √(2w/γ₁): with more noise of the slopes lines go from facet to facet by jumps.
    few_samples : int
        Of fewer samples all is refined in seconds even so. Of 1000 with noise of 0.3 hardly
        anything is, after 4 s.
    near_nodes : float
        Spacings: so near to those of nodes lines must rest to be refined again.
    """

    beyond: float = 1.0
    most_failures: int = 4
    noise: float = 0.25
    few_samples: int = 500
    near_nodes: float = 4.0


_RULES = RefinementRules()


class Place(NamedTuple):
    """What a point of this branch remembers: where it is on a route, or on nodes.

    With a route only `route` and `stretch` count. Without one, as at first touch and for a point
    that is given by its lines, a route begins from `contacts` on the nodes of `level`. With `nodal`
    the point is not refined.

    Attributes
    ----------
    route : Route or None
    stretch : int
        Number of the stretch of the route.
    level : int
        Index into CLOSER: how close the nodes are.
    contacts : Contacts
        First and last nodes of the contacts on these.
    on_nodes : float
        The depth at which these are at rest on nodes [length].
    nodal : Point or None
        The point of the branch on nodes alone, where it is not refined.
    """

    route: Route | None
    stretch: int = 0
    level: int = 0
    contacts: row.Contacts = ()
    on_nodes: float = 0.0
    nodal: Point | None = None


class Shortened(NamedTuple):
    """A route that ends at a depth before its goal, since it could not be refined any further.

    Attributes
    ----------
    direction : {1, -1}
        1 where the depth grows.
    depth : float
        Where it ends [length].
    goal : float
        Where it was to go [length].
    """

    direction: int
    depth: float
    goal: float


@dataclass(eq=False)
class RefinedSegment(PathSegment):
    """A segment of a load path that is a part of a stretch of a route.

    Attributes
    ----------
    route : Route
    index : int
        Number of the stretch.
    settled : dict of float: Point
        Points by depth that have been found together with those of other segments.
    """

    route: Route
    index: int
    settled: dict[float, Point] = field(default_factory=dict)

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the segment (n,)."""
        new = np.array([depth for depth in depths.tolist() if depth not in self.settled])
        _settle([(self, new)])
        return [self.settled[depth] for depth in depths.tolist()]

    def forces(self, depths: Array, *, roughly: bool = False) -> Array:
        """P (n,) at depths (n,) on the segment.

        roughly: with lines read off the polynomials of the route, in place of lines at rest.
        """
        if not roughly:
            return super().forces(depths)
        lines = self.route.lines(self.index, depths, roughly=True)
        totals = self.route.refinement.totals
        _, force = totals.of_surfaces(lines.reshape(-1, 2), np.tile(depths, len(lines)))
        return np.asarray(force.reshape(len(lines), -1).sum(axis=0))

    def external_work(self) -> float:
        """∫P dd from the start to the end."""
        return self.route.work(self.index, self.start.depth, self.end.depth)


def _settle(parts: Sequence[tuple[RefinedSegment, Array]]) -> None:
    """Find the points at depths (n,) on segments, for all of them at once.

    NotCertifiedError where lines do not come to rest.
    """
    parts = [(segment, depths) for segment, depths in parts if depths.size]
    if not parts:
        return
    try:
        lines_of_parts = lines_of_routes(
            [(segment.route, segment.index, depths) for segment, depths in parts]
        )
    except NotRefined as reason:
        raise NotCertifiedError(f"{reason}; try other depths, or method='lattice'") from reason
    for (segment, depths), lines_of_surfaces_at_depths in zip(parts, lines_of_parts, strict=True):
        place = Place(segment.route, segment.index)
        at_depths = lines_of_surfaces_at_depths.transpose(1, 0, 2)
        for depth, lines in zip(depths.tolist(), at_depths, strict=True):
            segment.settled[depth] = Point(depth, lines_of_surfaces(lines), place)


@dataclass(eq=False)
class NodalSegment(PathSegment):
    """A segment that is not refined.

    Attributes
    ----------
    lattice_segment : LatticeSegment
        The same segment on nodes alone.
    """

    lattice_segment: LatticeSegment
    smooth = False

    @property
    def trace(self) -> Any:
        """Depths at which lines pass links, with the nodes from there on, as of LatticeSegment."""
        return self.lattice_segment.trace

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the segment (n,)."""
        return [_kept(point) for point in self.lattice_segment.between(depths)]

    def external_work(self) -> float:
        """∫P dd from the start to the end."""
        return self.lattice_segment.external_work()


def _is_noisy(scene: Scene) -> bool:
    """Whether a profile of many samples is so noisy that lines go from facet to facet by jumps.

    Then there are too many events to refine. The noise is that of slopes, next to the kink
    √(2w/γ₁) at a contact line.
    """
    samples = len(scene.indenter.corners) + len(scene.indenter.knots)
    if samples <= _RULES.few_samples:
        return False
    noise = scene.indenter.noise_slope
    kink = math.sqrt(2 * scene.opened.work_of_adhesion / scene.gamma1)
    return noise is not None and kink > 0 and noise > _RULES.noise * kink


def _kept(point: Point) -> Point:
    """A point of the branch on nodes alone, as a point of the refined branch."""
    return Point(point.depth, point.lines, Place(None, nodal=point))


def _is_nodal(point: Point) -> bool:
    """Whether a point is not refined."""
    return point.memory is not None and point.memory.nodal is not None


@dataclass(eq=False)
class RefinedBranch(FittedBranch):
    """Any number of contacts of a line contact with small slopes under a prescribed depth.

    Attributes
    ----------
    scene : Scene
    profile : Resolved
        The profile with the samples that resolve it.
    contact_lines : ContactLines
        The lines and rest depths of the scene, for the certificate.
    deepest : float
        The largest depth of the programme [length].
    refinements : dict
        The refinement on nodes of each closeness (index into CLOSER), as far as needed so far.
    known : dict
        Points of the path by depth and lines, so that a point that is given by these again, as when
        a recorded path is followed once more, has its place on the route.
    on_nodes : list of (float, float)
        First and last depths of what is not refined [length].
    failures : list of int
        How often nodes of each closeness have failed, by the index into CLOSER.
    shortened : Shortened or None
        The last route that ended before its goal.
    noisy : bool
        Whether the noise of the samples decides where lines rest, so that nothing is refined.
    certified : set
        Lines and depths of states that are known to be in equilibrium.
    """

    scene: Scene
    profile: Resolved
    contact_lines: ContactLines
    deepest: float
    refinements: dict[int, Refinement] = field(default_factory=dict)
    known: dict[tuple[float, tuple[float, ...]], Point] = field(default_factory=dict)
    on_nodes: list[tuple[float, float]] = field(default_factory=list)
    failures: list[int] = field(default_factory=lambda: [0] * len(CLOSER))
    shortened: Shortened | None = None
    noisy: bool = False
    certified: set[tuple[tuple[float, ...], float]] = field(default_factory=set)

    @classmethod
    def of(cls, scene: Scene, deepest: float) -> RefinedBranch:
        """The branch of a scene, for depths up to the largest one of the programme, `deepest`.

        Warns
        -----
        AccuracyWarning
            Where the profile has features that its samples have missed.
        """
        profile = resolve(scene, deepest)
        branch = cls(
            scene,
            profile,
            ContactLines.of(scene, profile, deepest),
            deepest,
            noisy=_is_noisy(scene),
        )
        hidden = branch.refinement(0).totals.integrals.hidden
        if hidden.size:
            warn_hidden(hidden, stacklevel=4)
        return branch

    touch = property(lambda self: self.profile.touch)

    @property
    def integrals(self) -> Integrals:
        """Integrals over the profile, by which U and P of contacts are differences."""
        return self.refinement(0).totals.integrals

    @property
    def resolution(self) -> float:
        """The length by which lines may be off: by rounding, or more than a link of nodes."""
        if self.on_nodes:
            return self.nodal.resolution
        return super().resolution

    @functools.cached_property
    def nodal(self) -> LatticeBranch:
        """The branch on nodes alone, of the usual closeness."""
        return LatticeBranch.of(self.scene, self.refinement(0).nodes.spacing, self.deepest)

    def refinement(self, level: int) -> Refinement:
        """The refinement on nodes of this closeness (index into CLOSER)."""
        if level not in self.refinements:
            found = Refinement.of(
                self.scene, self.profile, self.deepest, CLOSER[level], self.refinements.get(0)
            )
            self.refinements[level] = found
        return self.refinements[level]

    @functools.cached_property
    def first(self) -> Point:
        """The contacts at first touch, on the widest nodes with which these are refined.

        Where none refine them, they are those of nodes alone.
        """
        for level in range(len(CLOSER) if not self.noisy else 0):
            try:
                contacts, on_nodes, lines = self.refinement(level).touched()
            except NotRefined:
                continue
            equations = self.refinement(level).equations
            known = known_lines(equations, lines, self.touch)
            return Point(self.touch, known, Place(None, 0, level, contacts, on_nodes))
        nodal = self.nodal.point(self.nodal.first.memory, self.touch, self.nodal.first)
        self.on_nodes.append((self.touch, self.touch))
        return _kept(nodal)

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with these lines, with its place on a route if the path has been here."""
        if (depth, lines) in self.known:
            return self.known[depth, lines]
        contacts = self.refinement(0).nodes.contacts(lines)
        return Point(depth, lines, Place(None, 0, 0, contacts, depth))

    def segment(self, point: Point, goal: float) -> PathSegment:
        """The route from a point towards another depth, up to the first event or cut."""
        if goal > point.depth >= self.deepest:
            raise ValueError(f"depth = {goal!r} is deeper than the programme, {self.deepest!r}")
        goal = min(goal, self.deepest)  # the profile is known so far
        direction = 1 if goal >= point.depth else -1
        route = point.memory.route
        index = point.memory.stretch
        leads_on = route is not None and route.direction == direction
        if leads_on and index + 1 == len(route.stretches) and route.goal == point.depth:
            leads_on = False  # the point is at the end of its route
        if not leads_on:
            aim = self._aim(point, goal, direction)
            found = self._followed(point, aim)
            if not isinstance(found, Route):
                nodal = self._nodal_segment(point, found)
                self.shortened = Shortened(direction, nodal.end.depth, aim)
                return self._remembered(nodal)
            route = found
            index = 0
            if route.goal != aim:
                self.shortened = Shortened(direction, route.goal, aim)
        return self._remembered(self._stretch(point, goal, route, index))

    def points_of(self, parts: Sequence[tuple[PathSegment, Array]]) -> list[list[Point]]:
        """Points on segments; the lines of all refined ones come to rest together."""
        inside = list[tuple[RefinedSegment, Array]]()
        for segment, depths in parts:
            if isinstance(segment, RefinedSegment):
                ends = [segment.start.depth, segment.end.depth]
                inside.append((segment, depths[~np.isin(depths, ends)]))
        _settle(inside)
        return super().points_of(parts)

    def _aim(self, point: Point, goal: float, direction: int) -> float:
        """How far a new route from a point is to go [length].

        That is to the goal. If the point is where the last route was cut short, and its own goal
        is further, it is that one, as it would have been without the cut.
        """
        cut = self.shortened
        if cut is None or cut.direction != direction or cut.depth != point.depth:
            return goal
        return direction * max(direction * goal, direction * cut.goal)

    def _stretch(self, point: Point, goal: float, route: Route, index: int) -> RefinedSegment:
        """The segment from a point on the stretch with this number.

        It ends at the goal, where a line becomes pinned or free, or where the stretch does, with
        the contacts beyond the event there.

        route, index: the route on which the point is, and the number of its stretch there. goal:
        the depth that is not passed [length].
        """
        stretch = route.stretches[index]
        end = route.next_cut(index, point.depth)
        if route.direction * (end - goal) > 0:
            end = goal
        if end != stretch.end:
            return RefinedSegment(
                self, point, self._at(route, index, end), None, False, route, index
            )
        before = lines_of_surfaces(stretch.before)
        last = Point(end, self._known(route, before, end), Place(route, index))
        if stretch.after is None:
            return RefinedSegment(self, point, last, None, False, route, index)
        after = Point(end, None)
        if len(stretch.after):
            lines = self._known(route, lines_of_surfaces(stretch.after), end)
            after = Point(end, lines, Place(route, index + 1))
        return RefinedSegment(self, point, last, after, self.jumps(last, after), route, index)

    def _remembered(self, segment: PathSegment) -> PathSegment:
        """The segment, whose points at the end are put among the known ones."""
        for point in (segment.end, segment.after):
            if point is not None and point.lines:
                self.known[point.depth, point.lines] = point
        return segment

    def _at(self, route: Route, index: int, depth: float) -> Point:
        """The point at a depth inside the stretch of a route with this number."""
        try:
            lines = route.lines(index, np.array([depth]))[:, 0]
        except NotRefined as reason:
            raise NotCertifiedError(f"{reason}; try other depths, or method='lattice'") from reason
        return Point(
            depth, self._known(route, lines_of_surfaces(lines), depth), Place(route, index)
        )

    def _known(self, route: Route, lines: tuple[float, ...], depth: float) -> tuple[float, ...]:
        """These lines; ValueError if one has left the known profile."""
        return known_lines(route.refinement.equations, free_surfaces(lines), depth)

    def _followed(self, point: Point, goal: float) -> Route | float:
        """The route from a point to a depth, or as far as it can be refined.

        Where nodes fail at a depth, the route ends before it. If the point is next to that depth
        already, closer nodes are tried, which have to get past it only.

        Returns
        -------
        Route or float
            A depth where not even the closest nodes refine a route from the point: up to it the
            path is left to nodes alone [length].
        """
        direction = 1 if goal >= point.depth else -1
        start = None
        if len(self.on_nodes) < _RULES.most_failures and not self.noisy:
            start = self._start(point, direction)
        if start is None:
            return goal
        target = goal
        for level in range(self._usual_level, len(CLOSER)):
            try:
                return self._route(start, target, level)
            except NotRefined as reason:
                failed = reason.depth
            self.failures[level] += 1
            route = self._route_before(start, failed, direction, level)
            if route is not None:
                return route
            target = self._passed(point, goal, failed)
        return target

    @property
    def _usual_level(self) -> int:
        """Index into CLOSER of the widest nodes that have not failed often, or of the closest."""
        usable = [
            level for level, count in enumerate(self.failures) if count < _RULES.most_failures
        ]
        return min(usable, default=len(CLOSER) - 1)

    def _route_before(
        self, start: Point, failed: float, direction: int, level: int
    ) -> Route | None:
        """The route that ends a little before a depth at which nodes fail.

        Nodes may fail again, at a depth before that; then it ends before that one, and so on. None
        if that is next to the start.

        Parameters
        ----------
        start : Point
        failed : float
            The depth at which nodes fail [length].
        direction : {1, -1}
            1 where the depth grows.
        level : int
            Index into CLOSER.
        """
        least = ASIDE * self.refinement(0).nodes.margin
        aside = direction * least
        goal = failed - aside
        while direction * (goal - start.depth) > least:
            try:
                return self._route(start, goal, level)
            except NotRefined as reason:
                if not direction * (goal - reason.depth) > 0:
                    return None
                goal = reason.depth - aside
        return None

    def _route(self, start: Point, goal: float, level: int) -> Route:
        """The route from a point to a depth, on nodes of this closeness.

        NotRefined if it cannot be refined, or a state beyond one of its events is no equilibrium.

        start: a point with its place on nodes; goal: the depth [length]; level: index into CLOSER.
        """
        refinement = self.refinement(level)
        contacts, on_nodes = self._on_nodes(start, level)
        lines = free_surfaces(start.lines or ())
        route = Route(refinement, refinement.follow(contacts, on_nodes, lines, start.depth, goal))
        self._demand_equilibria(route)
        return route

    def _demand_equilibria(self, route: Route) -> None:
        """NotRefined unless the states beyond all events are in equilibrium."""
        states = list[tuple[tuple[float, ...], float]]()
        for stretch in route.stretches:
            if stretch.after is not None and len(stretch.after):
                lines = self._known(route, lines_of_surfaces(stretch.after), stretch.end)
                states.append((lines, stretch.end))
        for state, certificate in zip(states, self._judge.certificates(states), strict=True):
            if not certificate.ok:
                raise NotRefined(f"no equilibrium beyond depth = {state[1]!r}", state[1])
        self.certified.update(states)

    def _passed(self, point: Point, goal: float, failed: float) -> float:
        """A depth a little beyond the one at which nodes `failed`, or the goal if that is nearer.

        The goal also if that depth lies behind the point.
        """
        direction = 1 if goal >= point.depth else -1
        beyond = failed + direction * _RULES.beyond * self.refinement(0).nodes.margin
        ahead = direction * (beyond - point.depth) > 0 and direction * (goal - beyond) > 0
        return beyond if ahead else goal

    def _start(self, point: Point, direction: int) -> Point | None:
        """The point as one from which a route can be refined, or None.

        A point on nodes alone is brought to rest on the mesh: its lines must rest near those on
        nodes, in order, and pass the certificate. With separate works of adhesion a line may rest
        anywhere in a range, and without adhesion a gap has no lines of its own: these stay on
        nodes.
        """
        place = point.memory
        if place.nodal is None:
            return point._replace(memory=place._replace(level=self._level(point)))
        if not self.scene.opened.work_of_adhesion or self.scene.hysteretic:
            return None
        equations = self.refinement(0).equations
        rows = free_surfaces(point.lines or ())
        count = len(rows)
        reach = _RULES.near_nodes * self.nodal.row.lattice.spacing
        directions = np.full(count, float(direction))
        found = settle(equations, rows, np.full(count, point.depth), directions, reach=reach)
        if not found.at_rest.all() or (found.lines[:-1, 1] >= found.lines[1:, 0]).any():
            return None
        lines = lines_of_surfaces(found.lines)
        (certificate,) = self._judge.certificates([(lines, point.depth)])
        if not certificate.ok:
            return None
        contacts = self.refinement(0).nodes.contacts(lines)
        return Point(point.depth, lines, Place(None, 0, 0, contacts, point.depth))

    def _nodal_segment(self, point: Point, goal: float) -> NodalSegment:
        """The segment from a point towards a depth, on nodes alone; its depths join `on_nodes`."""
        start = point.memory.nodal
        if start is None:
            start = self.nodal.contact(point.depth, *self._seen_by_nodes(point.lines or ()))
        found = self.nodal.segment(start, goal)
        self.on_nodes.append((point.depth, found.end.depth))
        after = None if found.after is None else _kept(found.after)
        return NodalSegment(self, point, _kept(found.end), after, found.jumps, found)

    def _seen_by_nodes(self, lines: tuple[float, ...]) -> tuple[float, ...]:
        """The lines without those of gaps in which there is no node, which nodes do not see."""
        nodes = self.nodal.nearest(np.array(lines))
        free_nodes = nodes[2::2] - nodes[1:-1:2] - 1
        kept = np.ones(len(lines), bool)
        kept[1:-1] = np.repeat(free_nodes > 0, 2)
        return tuple(np.array(lines)[kept].tolist())

    def _level(self, point: Point) -> int:
        """Index into CLOSER of the nodes on which a point has been found."""
        route = point.memory.route
        if route is None:
            return int(point.memory.level)
        return next(k for k, each in self.refinements.items() if each is route.refinement)

    def _on_nodes(self, point: Point, level: int) -> tuple[row.Contacts, float]:
        """Contacts on nodes of a closeness, and the depth at which these are at rest.

        NotRefined where there is no node in a gap between them.

        level: index into CLOSER. If the point was found on these nodes they are known; else they
        are those nearest to its lines, at rest at its own depth.
        """
        place = point.memory
        if level == self._level(point) and place.route is not None:
            found: tuple[row.Contacts, float] = place.route.contacts(place.stretch, point.depth)
            return found
        if level == self._level(point):
            contacts = place.contacts
            on_nodes = place.on_nodes
        else:
            contacts = self.refinement(level).nodes.contacts(point.lines or ())
            on_nodes = point.depth
        gaps = [right[0] - left[1] for left, right in itertools.pairwise(contacts)]
        if any(gap < 2 for gap in gaps):
            raise NotRefined(f"nodes at depth = {point.depth!r} see no gap", point.depth)
        return contacts, on_nodes

    def totals(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points in contact: refined, or as of nodes where they are not."""
        found = np.empty((2, len(points)))
        nodal, refined = self._parted(points)
        if nodal:
            found[:, nodal] = self.nodal.totals([points[i].memory.nodal for i in nodal])
        if refined:
            found[:, refined] = self._refined_totals([points[i] for i in refined])
        return found

    def _refined_totals(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of refined points: sums over their free surfaces, found all at once."""
        surfaces = [free_surfaces(point.lines or ()) for point in points]
        counts = [len(lines) for lines in surfaces]
        depths = np.repeat([point.depth for point in points], counts)
        totals = self.refinement(0).totals.of_surfaces(np.concatenate(surfaces), depths)
        first_surfaces = np.cumsum([0, *counts[:-1]])
        return np.asarray(np.add.reduceat(totals, first_surfaces, axis=1))

    def _parted(self, points: Sequence[Point]) -> tuple[list[int], list[int]]:
        """Numbers of the points that are those of nodes alone, and of those that are refined."""
        nodal = [i for i, point in enumerate(points) if _is_nodal(point)]
        return nodal, [i for i, point in enumerate(points) if not _is_nodal(point)]

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contacts of a point are in equilibrium."""
        self.certify_all([point])

    def certify_all(self, points: Sequence[Point]) -> None:
        """NotCertifiedError unless all points are in equilibrium; on nodes alone as nodes are.

        Those beyond the events of a route have been certified when it was made.
        """
        judged = [point for point in points if point.lines and not _is_nodal(point)]
        judged = [p for p in judged if (p.lines, p.depth) not in self.certified]
        states = [(point.lines or (), point.depth) for point in judged]
        for point, certificate in zip(judged, self._judge.certificates(states), strict=True):
            certificate.demand(
                f"the state at depth = {point.depth!r}",
                "the path stops before it; try other depths, or method='lattice'",
            )
        for point in points:
            if _is_nodal(point):
                self.nodal.certify(point.memory.nodal)

    @functools.cached_property
    def _judge(self) -> Judge:
        """What certifies many states at once."""
        return Judge(self.refinement(0).equations, self.contact_lines)

    def snapshots(self, points: Sequence[Point]) -> list[Snapshot]:
        """Points just before or after events."""
        energy, force = np.zeros((2, len(points)))
        known = [i for i, point in enumerate(points) if point.lines is not None]
        if known:
            energy[known], force[known] = self.totals([points[i] for i in known])
        nodal, _ = self._parted(points)
        found = [
            snapshot_of(point, stored, pushed, self.scene.axisymmetric)
            for point, stored, pushed in zip(points, energy.tolist(), force.tolist(), strict=True)
        ]
        of_nodes = self.nodal.snapshots([points[i].memory.nodal for i in nodal]) if nodal else []
        for i, state in zip(nodal, of_nodes, strict=True):
            found[i] = state
        return found

    def recorded(self, points: Sequence[Point]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,) to report of points in contact."""
        nodal, _ = self._parted(points)
        lines, force, energy = super().recorded(points)
        if nodal:
            known = self.nodal.recorded([points[i].memory.nodal for i in nodal])
            lines[nodal], force[nodal], energy[nodal] = known
        return lines, force, energy
