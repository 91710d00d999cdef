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

# Of the depth and how far a line is lifted: depths that are the same, some thousand roundings.
_TIE = 1e-12
_ROUNDING = 1e-14  # of P: some roundings of the sum over poles
# Of log₂ a, 6 % of a: distance of places between which D turns once at most. Half or twice as much
# changes no result (`python -m tests.sensitivity discretization.paths.layer_branch _STEP`).
_STEP = 1 / 12


class LayerSegment(PathSegment):
    """A segment on which the line is pinned, or slides along D = d, which does not turn."""

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the segment (n,)."""
        branch = self.branch
        half_widths = self._half_widths(depths)
        return [
            branch.point(depth, a)
            for depth, a in zip(depths.tolist(), half_widths.tolist(), strict=True)
        ]

    def _half_widths(self, depths: Array) -> Array:
        """Half-widths a (n,) at depths on the segment, D(a) = d [length]."""
        first = self.start.memory
        last = self.end.memory
        if first == last:
            return np.full(depths.size, first)
        direction = 1 if last > first else -1
        line = self.branch.lines[direction]
        slope = (self.end.depth - self.start.depth) / (last - first)

        def off(a: Array, own: Indices) -> Array:
            """D(a) - d."""
            ends_at_corner = a == last  # D there is that on the inner side of the corner
            side = np.where(ends_at_corner, -direction, direction)
            return np.asarray(line.rest_depth(a, side) - depths[own])

        lowest = np.full(depths.size, min(first, last))
        highest = np.full(depths.size, max(first, last))
        guess = first + (depths - self.start.depth) / slope
        slopes = np.full(depths.size, slope)
        return crossings(off, lowest, highest, guess, slopes, 0.0)

    @property
    def rounding(self) -> float:
        """Of P."""
        ends = [point for point in (self.start, self.end) if point.lines]
        forces = [abs(self.branch.total(point)[1]) for point in ends]
        return _ROUNDING * max(forces)


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
