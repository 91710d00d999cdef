"""Load paths of one contact of a layer with its exact response.

The half-width a tells everything: D(a), where a line rests that advances or recedes, and at a depth
the force and the energy, which is a parabola of the depth at fixed a (../layer/lines.py). So a line
advances to the first a at which D is the depth, or recedes to it; between D of closing and D of
opening it is held; and where D turns, it jumps to the next a with the same D.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import TOLERANCE
from discretization.layer.body import Body
from discretization.layer.contact import contacts
from discretization.layer.lines import Lines, Table
from discretization.layer.state import Layer
from discretization.paths.branch import Branch, Leg, Pinned, Point
from discretization.roots import crossings
from energy import Scene

Array = NDArray[np.float64]
_TIE = 1e-12  # of the depth and how far a line is lifted: depths that are the same


@dataclass(eq=False)
class Slide(Leg):
    """A leg on which the line is held, or slides where D is the depth."""

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths on the way (n,)."""
        branch, one, other = self.branch, self.start.memory, self.end.memory
        a = np.full(depths.size, one)
        if one != other:
            a = branch.rests(depths, one, other)
        return [branch.point(d, x) for d, x in zip(depths.tolist(), a.tolist(), strict=True)]

    @property
    def rounding(self) -> float:
        """Of P."""
        return 1e-14 * max(abs(self.branch.force(p)) for p in (self.start, self.end) if p.lines)


@dataclass(frozen=True, eq=False)
class LayerBranch(Branch):
    """One contact under a prescribed depth; what a point remembers is a."""

    scene: Scene
    body: Body
    table: Table

    @classmethod
    def of(cls, scene: Scene, rtol: float) -> LayerBranch:
        """The poles, and what is computed at half-widths, are good to rtol."""
        body = Body(scene)
        return cls(scene, body, Table(body, rtol))

    @property
    def resolution(self) -> float:
        """The length by which lines may be off."""
        return self.table.tolerance * self.first.memory

    @property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return self.body.touch

    @functools.cached_property
    def holding_range(self) -> float:
        """Displacement at the line of a contact as it begins."""
        a = self.first.memory
        return self.lines[-1].excess / float(self.table.at(np.array([a]))[0, 0]) if a else 0.0

    @functools.cached_property
    def lines(self) -> dict[int, Lines]:
        """The line on its way out (1) and in (-1)."""
        works = {1: self.scene.surfaces, -1: self.scene.opened.surfaces}
        return {way: Lines(self.table, of.small_slope_deficit) for way, of in works.items()}

    @functools.cached_property
    def first(self) -> Point:
        """The contact at first touch."""
        return self.point(self.touch, self.lines[1].settled(self.touch).a)

    def point(self, depth: float, a: float) -> Point:
        """The contact of this half-width at a depth."""
        return Point(depth, self.body.ends(a), a)

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with these lines; nan: detached."""
        if math.isnan(lines[0]):
            return Point(depth, None)
        return self.point(depth, max(lines[1] - self.body.apex, self.body.tip))

    def pinned(self, point: Point) -> Pinned:
        """What holds each line: "edge", "tip" or ""."""
        tips = point.memory == self.body.tip and not self.scene.axisymmetric
        if tips and self.body.apex in self.scene.indenter.corners:
            return "tip", "tip"
        return super().pinned(point)

    def rests(self, depths: Array, one: float, other: float) -> Array:
        """Where D is each of these depths between two half-widths, as it does not turn there."""
        way = 1 if other > one else -1
        lo, hi = np.full(depths.size, min(one, other)), np.full(depths.size, max(one, other))

        def rest_depth(a: Array) -> Array:
            side = np.where(a == other, -way, way)  # of a corner at which the line ends
            return np.asarray(self.lines[way].rest_depth(a, side))

        span = rest_depth(np.array([one, other]))
        rise = np.full(depths.size, float(np.diff(span)[0]) / (other - one))
        share = np.clip((depths - span[0]) / (span[1] - span[0]), 0, 1)
        guess = one + share * (other - one)
        return crossings(lambda a, own: rest_depth(a) - depths[own], lo, hi, guess, rise, 0.0)

    def leg(self, point: Point, goal: float) -> Slide:
        """The way from a point towards another depth, up to where the line comes free or jumps."""
        a, here, way = point.memory, point.depth, 1 if goal >= point.depth else -1
        lines, tie = self.lines[way], _TIE * (abs(here) + self.holding_range)
        rest = lines.rest_depth(a, way)
        if way * (rest - here) > tie:  # held so far
            held = goal if way * (goal - rest) <= 0 else rest
            return Slide(self, point, self.point(held, a), None, False)
        far, depth, how = lines.walk(a, here, goal, way, past=False, tie=tie)
        end = self.point(depth, far)
        after, jumps = None, how == "turns"
        if jumps:
            landed = lines.walk(far, depth, depth, way, past=True)
            after = Point(depth, None) if landed.how == "lost" else self.point(depth, landed.a)
        elif how == "lost":
            after = Point(depth, None)
        return Slide(self, point, end, after, jumps)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points in contact."""
        a = np.array([point.memory for point in points])
        force, stored = self.table.taken(a, np.array([point.depth for point in points]))
        return np.array([stored - self.scene.work_of_adhesion * self.body.area(a), force])

    def opened(self, before: Point, after: Point) -> float:
        """The length or area that opens between two points."""
        if not before.lines or not after.lines:
            return 0.0
        return max(0.0, float(self.body.area(before.memory) - self.body.area(after.memory)))

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contact is in equilibrium, as far as the table is known."""
        if point.lines:
            tolerance = self.table.tolerance
            contact = contacts(self.body, np.array([point.memory]), tolerance)
            found = Layer(contact, point.depth, tolerance).certificate()
            found = found._replace(tolerance=max(TOLERANCE, tolerance))
            found.demand(f"the state at depth = {point.depth!r}", "the path stops before it")
