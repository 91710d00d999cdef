"""Load paths of one contact of a layer with its exact response.

The half-width a tells everything: D(a), where a line rests that advances or recedes, and at a depth
the force and the energy, which is a parabola of the depth at fixed a (../layer/lines.py). So a line
advances to the first a at which D is the depth, or recedes to it; between D of closing and D of
opening it is pinned; and where D turns, it jumps to the next a with the same D.

Conventions
-----------
The depth d, the rest depth D and the displacement u = d - f at the line are positive down into the
layer [length], P is positive where pressed, U is 0 without contact. a is the half-width of the
contact about the lowest point, or its radius; it is the memory of a `Point`. `direction` is 1 where
the depth grows and the line advances outwards, -1 where it falls and the line recedes inwards; the
same numbers say on which side of a corner D is read, 1 outwards, -1 inwards.

`Body` is the profile by the distance from its lowest point. `Table.at(a)` are the coefficients of
P and U at half-widths, to its tolerance, of which the first one, σ [1/length], is the slope of the
free surface at the line per unit of u. `Lines` are the line under one work of adhesion:
`rest_depth(a, side)` is D, `walk` how far the line comes that moves in one direction, and `settled`
where it comes to rest.

`Body.ends(a)` are both lines of the contact of half-width a, about an axis 0 and a (`Body.apex` is
x of the lowest point), `tip` is the half-width up to which it counts as a contact of one point,
`height(a)` is f there, `area(a)` is 2a or πa², and `bound(a)` w times that. `at_depth(coefficients,
u)` are P and U + w·area of contacts whose lines are displaced by u. `small_slope_deficit` of
surface energies is the kink √(2w/γ₁) at a line that rests, and `Lines.excess` is this kink for its
work of adhesion. A `Layer` is the state of a `Contact` of fixed half-width at a depth, with its
certificate, whose `demand` raises NotCertifiedError if it fails; TOLERANCE is what certificates
tolerate elsewhere. `crossings` finds zeros of many functions between brackets. `Scene.opened` is
the scene with the work of adhesion of contacts that open.

A `Branch` (branch.py) has the states at imposed depths: `segment(point, goal)` is the path from a
`Point` towards a depth, up to an event. A `PathSegment` has its points `start` and `end`, the point
`after` the event, None if there is none, and whether the line jumps there. `Pinned` are two words,
where the left and the right line is pinned, "" if free. `Branch.total` is U and P of a point.
`corners` of the indenter are where its slope jumps or the body ends.
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
# 1e-13 or 1e-11 changes no result (`python -m tests.sensitivity
# discretization.paths.layer_branch _TIE`).
_TIE = 1e-12
_ROUNDING = 1e-14  # of P: some roundings of the sum over poles
# Of log₂ a, 6 % of a: distance of places between which D turns once at most. Half or twice as much
# changes no result (`python -m tests.sensitivity discretization.paths.layer_branch _STEP`).
_STEP = 1 / 12


class LayerSegment(PathSegment):
    """A segment on which the line is pinned, or slides along D = d, which does not turn."""

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths (n,) on the segment."""
        branch = self.branch
        half_widths = self._half_widths(depths)
        return [
            branch.point(depth, a)
            for depth, a in zip(depths.tolist(), half_widths.tolist(), strict=True)
        ]

    def _half_widths(self, depths: Array) -> Array:
        """Half-widths a (n,) at depths (n,) on the segment: roots of D(a) = d, or one that stays.

        They lie between those at the ends of the segment [length].
        """
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
        """What rounding leaves of P on the segment, a part of the larger force at its ends."""
        ends = [point for point in (self.start, self.end) if point.lines]
        forces = [abs(self.branch.total(point)[1]) for point in ends]
        return _ROUNDING * max(forces)


class LayerBranch(Branch):
    """One contact under a prescribed depth; what a point remembers is its half-width a.

    Parameters
    ----------
    scene : Scene
    rtol : float
        How good the poles are, and what is computed at half-widths, relative to their sizes.

    Attributes
    ----------
    body : Body
        The profile by the distance from its lowest point.
    table : Table
        Coefficients of P and U at half-widths.
    lines : dict of Lines
        By direction: the line that advances (1), with the adhesion of closing, and the one that
        recedes (-1), with that of opening.
    """

    def __init__(self, scene: Scene, rtol: float) -> None:
        """The branch of a scene, with half-widths tabulated as they are needed."""
        self.scene = scene
        self.body = Body(scene)
        self.table = Table(self.body, rtol)
        surfaces = {1: scene.surfaces, -1: scene.opened.surfaces}
        self.lines = {
            direction: Lines(self.body, self.table.at, energies.small_slope_deficit, _STEP)
            for direction, energies in surfaces.items()
        }

    @property
    def resolution(self) -> float:
        """The length by which lines may be off [length]."""
        return self.table.tolerance * self.first.memory

    touch = property(lambda self: self.body.touch)

    @functools.cached_property
    def holding_range(self) -> float:
        """How far the line of a contact that begins can be lifted [length].

        That is the displacement at which the slope of the surface there is the kink √(2w/γ₁) of
        opening; 0 of a contact of one point.
        """
        a = self.first.memory
        return self.lines[-1].excess / float(self.table.at(a)[0, 0]) if a else 0.0

    @functools.cached_property
    def first(self) -> Point:
        """The contact at first touch, spread to where its line rests."""
        return self.point(self.touch, self.lines[1].settled(self.touch)[0])

    def point(self, depth: float, a: float) -> Point:
        """The contact of half-width a at a depth [length]."""
        return Point(depth, self.body.ends(a), a)

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with these lines: a is the distance of the right one from the lowest point."""
        return self.point(depth, max(lines[1] - self.body.apex, self.body.tip))

    def pinned(self, point: Point) -> Pinned:
        """Where each line is pinned: "edge", "tip" or "" where it is free."""
        tips = point.memory == self.body.tip and not self.scene.axisymmetric
        if tips and self.body.apex in self.scene.indenter.corners:
            return "tip", "tip"
        return super().pinned(point)

    def segment(self, point: Point, goal: float) -> LayerSegment:
        """The path from a point towards another depth, up to the first change.

        That is where the line comes free, is pinned at a corner, jumps as D turns, or is lost.
        """
        a = point.memory
        here = point.depth
        direction = 1 if goal >= here else -1
        lines = self.lines[direction]
        rest = lines.rest_depth(a, direction)
        tie = _TIE * (abs(here) + self.holding_range)
        if direction * (rest - here) > tie:  # D ahead is beyond the depth: the line is pinned
            pinned_to = goal if direction * (goal - rest) <= 0 else rest
            return LayerSegment(self, point, self.point(pinned_to, a), None, False)
        moved = lines.walk(a, here, goal, direction, past=False)
        end = self.point(moved.depth, moved.a)
        if moved.how == "lost":
            return LayerSegment(self, point, end, Point(moved.depth, None), False)
        if moved.how != "turns":
            return LayerSegment(self, point, end, None, False)
        landed = lines.walk(moved.a, moved.depth, moved.depth, direction)  # at the same depth
        after = Point(moved.depth, None)
        if landed.how != "lost":
            after = self.point(moved.depth, landed.a)
        return LayerSegment(self, point, end, after, True)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points in contact."""
        # `bound` is the work of adhesion of closing over the contact.
        a, depth = np.array([(point.memory, point.depth) for point in points]).T
        force, stored = at_depth(self.table.at(a), depth - self.body.height(a))
        return np.array([stored - self.body.bound(a), force])

    def opened(self, before: Point, after: Point) -> float:
        """The length or area that opens between two points, 0 where it closes."""
        if not before.lines or not after.lines:
            return 0.0
        return max(0.0, float(self.body.area(before.memory) - self.body.area(after.memory)))

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contact is in equilibrium, to the tolerance of the table."""
        if point.lines:
            tolerance = self.table.tolerance
            found = Layer(point.depth, Contact(self.body, point.memory, tolerance)).certificate
            found = found._replace(tolerance=max(TOLERANCE, tolerance))
            found.demand(f"the state at depth = {point.depth!r}", "the path stops before it")
