"""The metastable branch of several contacts of a line contact, found on nodes and refined.

A way in one direction is refined as a whole (../refine/plan.py); legs are the parts of it between
events and the depths at which a line becomes pinned or free. Ways that nodes of the usual distance
do not lead along are followed on closer ones.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.motion import Motion
from discretization.fitted.rest_depths import TIE
from discretization.nodes import row
from discretization.paths.branch import Branch, Leg, Pinned, Point, Snapshot, snapshot_of
from discretization.profile import Resolved, resolve
from discretization.refine.equations import contact_lines, free_surfaces
from discretization.refine.events import NotRefined
from discretization.refine.judged import Judge
from discretization.refine.plan import Refinement
from discretization.refine.states import CLOSER, known_lines
from discretization.refine.way import Way
from energy import Scene
from energy.arrays import Array

_SHORT = 1e-6  # of l: where an equilibrium disappears within rounding a line is that far from it
_FELT = 1e-9  # of l: lines that jump less far do so by rounding


class Place(NamedTuple):
    """Where a point is: on a stretch of a way.

    Or, before there is one, on nodes of this closeness: its contacts there and the depth at which
    these are at rest.
    """

    way: Way | None
    stretch: int = 0
    level: int = 0
    contacts: row.Contacts = ()
    on_nodes: float = 0.0


@dataclass(eq=False)
class RefinedLeg(Leg):
    """A part of a stretch of a way."""

    way: Way
    index: int

    def lines(self, depths: Array, *, roughly: bool = False) -> Array:
        """Lines (n, k, 2) of all free surfaces at depths (k,) on the leg."""
        try:
            return self.way.lines(self.index, depths, roughly=roughly)
        except NotRefined as reason:
            raise NotCertifiedError(f"{reason}; try other depths, or method='lattice'") from reason

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the leg (n,)."""
        lines = self.lines(depths).transpose(1, 0, 2)
        place = Place(self.way, self.index)
        return [
            Point(depth, contact_lines(each), place)
            for depth, each in zip(depths.tolist(), lines, strict=True)
        ]

    def forces(self, depths: Array, *, roughly: bool = False) -> Array:
        """P at depths on the leg (n,); roughly: from the polynomials of the lines."""
        if not roughly:
            return super().forces(depths)
        lines = self.lines(depths, roughly=True)
        totals = self.way.refinement.totals
        _, force = totals.of_surfaces(lines.reshape(-1, 2), np.tile(depths, len(lines)))
        return np.asarray(force.reshape(len(lines), -1).sum(axis=0))

    def external_work(self) -> float:
        """∫P dd from the start to the end."""
        return self.way.work(self.index, self.start.depth, self.end.depth)


@dataclass(frozen=True, eq=False)
class RefinedBranch(Branch):
    """Any number of contacts of a line contact with small slopes under a prescribed depth.

    refinements: on nodes of each closeness, as far as they have been needed.
    """

    scene: Scene
    profile: Resolved
    motion: Motion
    deepest: float
    refinements: dict[int, Refinement] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: Scene, deepest: float) -> RefinedBranch:
        """deepest: the largest depth of the programme."""
        profile = resolve(scene, deepest)
        return cls(scene, profile, Motion.of(scene, profile, deepest), deepest)

    touch = property(lambda self: self.profile.touch)

    @property
    def resolution(self) -> float:
        """The length by which lines may be off, by rounding."""
        return _FELT * self.scene.elastocapillary_length

    def refinement(self, level: int) -> Refinement:
        """On nodes of this closeness."""
        if level not in self.refinements:
            found = Refinement.of(self.scene, self.profile, self.deepest, CLOSER[level])
            self.refinements[level] = found
        return self.refinements[level]

    @functools.cached_property
    def first(self) -> Point:
        """The contacts at first touch."""
        reasons = list[str]()
        for level in range(len(CLOSER)):
            try:
                contacts, on_nodes, lines = self.refinement(level).touched()
            except NotRefined as reason:
                reasons.append(str(reason))
                continue
            equations = self.refinement(level).equations
            known = known_lines(equations, lines, self.touch)
            return Point(self.touch, known, Place(None, 0, level, contacts, on_nodes))
        raise NotCertifiedError(
            f"the contacts at first touch, depth = {self.touch!r}, are not found: {reasons[-1]}; "
            "try method='lattice'"
        )

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with these lines."""
        contacts = self.refinement(0).nodes.contacts(lines)
        return Point(depth, lines, Place(None, 0, 0, contacts, depth))

    def leg(self, point: Point, goal: float) -> RefinedLeg:
        """The way from a point towards another depth, up to the first event or cut."""
        direction = 1 if goal >= point.depth else -1
        way, index = point.memory.way, point.memory.stretch
        ahead = way is not None and way.direction == direction
        if ahead and index + 1 == len(way.stretches) and way.goal == point.depth:
            ahead = False
        if not ahead:
            way, index = self._followed(point, goal), 0
        stretch = way.stretches[index]
        end = way.next_cut(index, point.depth)
        if direction * (end - goal) > 0:
            end = goal
        if end != stretch.end:
            return RefinedLeg(self, point, self._at(way, index, end), None, False, way, index)
        before = contact_lines(stretch.before)
        last = Point(end, self._known(way, before, end), Place(way, index))
        if stretch.after is None:
            return RefinedLeg(self, point, last, None, False, way, index)
        after = Point(end, None)
        if len(stretch.after):
            lines = self._known(way, contact_lines(stretch.after), end)
            after = Point(end, lines, Place(way, index + 1))
        return RefinedLeg(self, point, last, after, self._jumps(last, after), way, index)

    def _at(self, way: Way, index: int, depth: float) -> Point:
        """The point at a depth inside a stretch."""
        try:
            lines = way.lines(index, np.array([depth]))[:, 0]
        except NotRefined as reason:
            raise NotCertifiedError(f"{reason}; try other depths, or method='lattice'") from reason
        return Point(depth, self._known(way, contact_lines(lines), depth), Place(way, index))

    def _known(self, way: Way, lines: tuple[float, ...], depth: float) -> tuple[float, ...]:
        return known_lines(way.refinement.equations, free_surfaces(lines), depth)

    def _followed(self, point: Point, goal: float) -> Way:
        """The way from a point to a depth, on nodes as close as needed."""
        reasons = list[str]()
        lines = free_surfaces(point.lines or ())
        for level in range(self._level(point), len(CLOSER)):
            refinement = self.refinement(level)
            try:
                contacts, on_nodes = self._on_nodes(point, level)
                stretches = refinement.follow(contacts, on_nodes, lines, point.depth, goal)
                return Way(refinement, stretches)
            except NotRefined as reason:
                reasons.append(str(reason))
        raise NotCertifiedError(
            f"the contacts between depth = {point.depth!r} and {goal!r} are not followed on nodes "
            f"at most {CLOSER[-1]} times closer than usual: {reasons[-1]}; try other depths, or "
            "method='lattice'"
        )

    def _level(self, point: Point) -> int:
        """How close the nodes are on which a point has been found."""
        way = point.memory.way
        if way is None:
            return int(point.memory.level)
        return next(k for k, each in self.refinements.items() if each is way.refinement)

    def _on_nodes(self, point: Point, level: int) -> tuple[row.Contacts, float]:
        """Contacts on nodes of a closeness, and the depth at which these are at rest."""
        place = point.memory
        if level == self._level(point):
            if place.way is None:
                return place.contacts, place.on_nodes
            found: tuple[row.Contacts, float] = place.way.contacts(place.stretch, point.depth)
            return found
        return self.refinement(level).nodes.contacts(point.lines or ()), point.depth

    def pinned(self, point: Point) -> Pinned:
        """What holds each of the outermost lines: "edge", "tip" of a convex profile, or ""."""
        tip, held = self.profile.lowest, super().pinned(point)
        if not self.motion.gradual or tip not in self.scene.indenter.corners:
            return held
        first, last = (edge or "tip" * (x == tip) for edge, x in zip(held, point.ends, strict=True))
        return first, last

    def _jumps(self, before: Point, after: Point) -> bool:
        """Whether lines jump; not by what the energy changes within the rounding of a depth."""
        if not after.lines or not before.lines:
            return not self.motion.gradual
        if len(before.lines) != len(after.lines):
            return True
        apart = np.abs(np.subtract(before.lines, after.lines)).max()
        energy, force = self.totals([before, after])
        noise = TIE * self.motion.rests.size * float(np.abs(force).sum())
        far = apart > _SHORT * self.scene.elastocapillary_length
        return bool(far and energy[0] - energy[1] > noise)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points with as many lines as each other."""
        lines = np.array([free_surfaces(point.lines or ()) for point in points])
        depths = np.repeat([point.depth for point in points], lines.shape[1])
        totals = self.refinement(0).totals
        energy, force = totals.of_surfaces(lines.reshape(-1, 2), depths)
        parts = np.array([energy, force]).reshape(2, len(points), -1)
        return np.asarray(parts.sum(axis=2))

    def opened(self, before: Point, after: Point) -> float:
        """The length that opens between two points."""
        if not before.lines or not after.lines:
            return 0.0
        integrals = self.refinement(0).totals.integrals
        bound = [integrals.at(np.array(point.lines))[4] for point in (before, after)]
        return float(np.maximum((bound[0] - bound[1]).reshape(-1, 2) * (-1, 1), 0.0).sum())

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contacts are in equilibrium."""
        self.certify_all([point])

    def certify_all(self, points: Sequence[Point]) -> None:
        """The same of many points."""
        judge = Judge(self.refinement(0).equations, self.motion)
        judged = [point for point in points if point.lines]
        states = [(point.lines or (), point.depth) for point in judged]
        for point, certificate in zip(judged, judge.certificates(states), strict=True):
            certificate.demand(
                f"the state at depth = {point.depth!r}",
                "the path stops before it; try other depths, or method='lattice'",
            )

    def snapshots(self, points: Sequence[Point]) -> list[Snapshot]:
        """Points beside events."""
        energy, force = np.zeros((2, len(points)))
        known = [i for i, point in enumerate(points) if point.lines is not None]
        if known:
            energy[known], force[known] = self.totals([points[i] for i in known])
        turned = self.scene.axisymmetric
        return [snapshot_of(*row, turned) for row in zip(points, energy.tolist(), force.tolist(), strict=True)]
