"""Load paths of one contact of a layer with its exact response.

The half-width a tells everything: D(a), where a line rests that advances or recedes, and at a depth
the force and the energy, which is a parabola of the depth at fixed a (../layer/lines.py). So a line
advances to the first a at which D is the depth, or recedes to it; between D of closing and D of
opening it is pinned; and where D turns, it jumps to the next a with the same D.
"""

import functools
from collections.abc import Sequence

import numpy as np

from discretization.certificate import TOLERANCE
from discretization.layer.body import Body
from discretization.layer.contact import Contact, at_depth
from discretization.layer.lines import Lines, Table
from discretization.layer.state import Layer
from discretization.paths.branch import Branch, PathSegment, Pinned, Point
from discretization.roots import crossings
from energy import Scene
from energy.arrays import Array, Indices

_TIE = 1e-12  # of the depth and how far a line is lifted: depths that are the same
_STEP = 1 / 12  # of log₂ a


class LayerSegment(PathSegment):
    """A segment on which the line is pinned, or slides along D = d, which does not turn."""

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the segment (n,)."""
        branch, ((d, _, one), (e, _, other)) = self.branch, (self.start, self.end)
        a = np.full(depths.size, one)
        if one != other:
            direction, rise = 1 if other > one else -1, (e - d) / (other - one)

            def short(x: Array, own: Indices) -> Array:
                inwards = x == other  # of a corner at which the line ends
                side = np.where(inwards, -direction, direction)
                return np.asarray(branch.lines[direction].rest_depth(x, side) - depths[own])

            lo, hi = (np.full(depths.size, x) for x in sorted((one, other)))
            a = crossings(short, lo, hi, one + (depths - d) / rise, np.full(depths.size, rise), 0.0)
        return [branch.point(d, x) for d, x in zip(depths.tolist(), a.tolist(), strict=True)]

    @property
    def rounding(self) -> float:
        """Of P."""
        return 1e-14 * max(abs(self.branch.total(p)[1]) for p in (self.start, self.end) if p.lines)


class LayerBranch(Branch):
    """One contact under a prescribed depth; what a point remembers is a.

    The poles, and what is computed at half-widths, are good to rtol. lines: out (1), in (-1).
    """

    def __init__(self, scene: Scene, rtol: float) -> None:
        self.scene, self.body = scene, Body(scene)
        self.table = Table(self.body, rtol)
        works = {1: scene.surfaces, -1: scene.opened.surfaces}
        given = self.body, self.table.at
        self.lines = {i: Lines(*given, w.small_slope_deficit, _STEP) for i, w in works.items()}

    @property
    def resolution(self) -> float:
        """The length by which lines may be off."""
        return self.table.tolerance * self.first.memory

    touch = property(lambda self: self.body.touch)

    @functools.cached_property
    def holding_range(self) -> float:
        """Displacement at the line of a contact as it begins."""
        a = self.first.memory
        return self.lines[-1].excess / float(self.table.at(a)[0, 0]) if a else 0.0

    @functools.cached_property
    def first(self) -> Point:
        """The contact at first touch."""
        return self.point(self.touch, self.lines[1].settled(self.touch)[0])

    def point(self, depth: float, a: float) -> Point:
        """The contact of this half-width at a depth."""
        return Point(depth, self.body.ends(a), a)

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with these lines."""
        return self.point(depth, max(lines[1] - self.body.apex, self.body.tip))

    def pinned(self, point: Point) -> Pinned:
        """Where each line is pinned: "edge", "tip" or "" where it is free."""
        tips = point.memory == self.body.tip and not self.scene.axisymmetric
        if tips and self.body.apex in self.scene.indenter.corners:
            return "tip", "tip"
        return super().pinned(point)

    def segment(self, point: Point, goal: float) -> LayerSegment:
        """The path from a point towards another depth, up to where the line comes free or jumps."""
        a, here, direction = point.memory, point.depth, 1 if goal >= point.depth else -1
        lines, tie = self.lines[direction], _TIE * (abs(here) + self.holding_range)
        rest = lines.rest_depth(a, direction)
        if direction * (rest - here) > tie:  # pinned so far
            pinned_to = goal if direction * (goal - rest) <= 0 else rest
            return LayerSegment(self, point, self.point(pinned_to, a), None, False)
        a, depth, how = lines.walk(a, here, goal, direction, past=False)
        end, after, jumps = self.point(depth, a), None, how == "turns"
        if jumps:
            a, _, how = lines.walk(a, depth, depth, direction)
        if jumps or how == "lost":
            after = Point(depth, None) if how == "lost" else self.point(depth, a)
        return LayerSegment(self, point, end, after, jumps)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points in contact."""
        a, depth = np.array([(point.memory, point.depth) for point in points]).T
        force, stored = at_depth(self.table.at(a), depth - self.body.height(a))
        return np.array([stored - self.body.bound(a), force])

    def opened(self, before: Point, after: Point) -> float:
        """The length or area that opens between two points."""
        if not before.lines or not after.lines:
            return 0.0
        return max(0.0, float(self.body.area(before.memory) - self.body.area(after.memory)))

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contact is in equilibrium, as far as the table is known."""
        if point.lines:
            tolerance = self.table.tolerance
            found = Layer(point.depth, Contact(self.body, point.memory, tolerance)).certificate
            found = found._replace(tolerance=max(TOLERANCE, tolerance))
            found.demand(f"the state at depth = {point.depth!r}", "the path stops before it")
