"""Load paths of one contact of a layer with its exact response.

The half-width a tells everything: D(a), where a line rests that advances or recedes, and at a depth
the force and the energy, which is a parabola of the depth at fixed a (../layer/table.py). So a line
advances to the first a at which D is the depth, or recedes to it; between D of closing and D of
opening it is held; and where D turns, it jumps to the next a with the same D.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import TOLERANCE
from discretization.layer.body import SPREADS, TIP, Body, Search
from discretization.layer.state import certify
from discretization.layer.table import Table
from discretization.layer.totals import Layer
from discretization.paths.branch import Branch, Leg, Pinned, Point
from discretization.roots import bracketed, crossings, least
from energy import Scene

Array = NDArray[np.float64]
_TIE = 1e-12  # of the depth and how far a line is lifted: depths that are the same
_NARROWEST = 1e-8  # of the half-width below which adhesion rules
_LEFT = 1 / 8  # of how far below touching a line about an axis rests at most
_STEPS = 12  # places in an octave at which it is looked whether D turns


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
    """One contact under a prescribed depth; what a point remembers is a, in units of h."""

    scene: Scene
    body: Body
    table: Table
    tolerance: float

    @classmethod
    def of(cls, scene: Scene, rtol: float) -> LayerBranch:
        """The poles, and what is computed at half-widths, are good to rtol."""
        body = Body(scene)
        return cls(scene, body, Table(body, rtol), rtol)

    @property
    def h(self) -> float:
        """Unit of lengths."""
        return self.body.h

    @property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return self.body.touch * self.h

    @functools.cached_property
    def holding_range(self) -> float:
        """Displacement at the line of a contact as it begins."""
        a = self.first.memory
        if not a:
            return 0.0
        return (
            self.h * self.body.excess(self.scene.opened) / float(self.table.at(np.array([a]))[0, 0])
        )

    @functools.cached_property
    def first(self) -> Point:
        """The contact at first touch."""
        search = Search(self.body, self.body.touch, self.body.excess(self.scene))
        a, pinned = search.looked_for(search.start(), 1)
        if math.isnan(a):
            return Point(self.touch, ())
        return self.point(self.touch, a if pinned else search.found(a, self.tolerance)[0])

    def point(self, depth: float, a: float) -> Point:
        """The contact of this half-width at a depth."""
        x = 0.0 if a <= TIP else a * self.h
        return Point(
            depth,
            ((0.0 if self.scene.axisymmetric else -x) + self.body.apex, x + self.body.apex),
            a,
        )

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with these lines; nan: detached."""
        if math.isnan(lines[0]):
            return Point(depth, None)
        return self.point(depth, max((lines[1] - self.body.apex) / self.h, TIP))

    def pinned(self, point: Point) -> Pinned:
        """What holds each line: "edge", "tip" or ""."""
        tips = point.memory == TIP and not self.scene.axisymmetric
        if tips and self.body.apex in self.scene.indenter.corners:
            return "tip", "tip"
        return super().pinned(point)

    def rest_depth(self, a: Array, way: int, within: float = math.nan) -> Array:
        """D [h] of lines that move this way (n,), beyond corners, but for the one at `within`."""
        sigma, rest = self.table.at(a)[:2]
        scene, profile = (self.scene if way > 0 else self.scene.opened), self.body.profile
        side = np.where(a == within, -way, way)
        slope = profile.slope(a, side)
        found = profile.height(a) + (slope - rest - self.body.excess(scene)) / sigma
        found = np.where((a <= TIP) & (side < 0), self.body.touch, found)
        return np.where((a >= self.body.edge) & (side > 0), math.inf, found)

    def rests(self, depths: Array, one: float, other: float) -> Array:
        """Where D is each of these depths between two half-widths, as it does not turn there."""
        way = 1 if other > one else -1
        lo, hi = np.full(depths.size, min(one, other)), np.full(depths.size, max(one, other))

        def off(a: Array, own: NDArray[np.int64]) -> Array:
            return self.rest_depth(a, way, other) - depths[own] / self.h

        span = self.rest_depth(np.array([one, other]), way, other)
        rise = np.full(depths.size, float(np.diff(span)[0]) / (other - one))
        share = np.clip((depths / self.h - span[0]) / (span[1] - span[0]), 0, 1)
        return crossings(off, lo, hi, one + share * (other - one), rise, 0.0)

    def _ahead(self, a: float, way: int) -> Iterator[tuple[Array, Array]]:
        """Places from a line on (n,), and D there on the side of the line, octave by octave.

        Up to the next corner, or so narrow that nothing is left.
        """
        ahead = [x for x in (*self.body.corners, self.body.edge) if way * (x - a) > 0]
        stop = min(ahead) if way > 0 else max([*ahead, min(self.narrowest, a)])
        while a != stop:
            x = a * 2.0 ** (way * np.arange(_STEPS + 1) / _STEPS)
            x = np.append(x[way * (stop - x) > 0], stop) if way * (stop - x[-1]) <= 0 else x
            yield x, self.rest_depth(x, way, stop)
            a = float(x[-1])

    @functools.cached_property
    def narrowest(self) -> float:
        """Half-width down to which a contact is followed.

        A line contact closes up. About an axis D returns to first touch as the radius vanishes, and
        in contacts so small that it has nearly done so no line rests.
        """
        search = Search(self.body, self.body.touch, self.body.excess(self.scene.opened))
        a = search.start()
        if not self.scene.axisymmetric:
            return max(_NARROWEST * a, TIP)
        least = here = search.off(a)
        while here < _LEFT * least:
            a /= 2
            here = search.off(a)
            least = min(least, here)
        return a

    def leg(self, point: Point, goal: float) -> Slide:
        """The way from a point towards another depth, up to where the line comes free or jumps."""
        a, here, to = point.memory, point.depth / self.h, goal / self.h
        way = 1 if goal >= point.depth else -1
        rest = float(self.rest_depth(np.array([a]), way)[0])
        if way * (rest - here) > self._tie(here):  # held so far
            held = goal if way * (to - rest) <= 0 else rest * self.h
            return Slide(self, point, self.point(held, a), None, False)
        far, depth, turns = self._slides(a, here, to, way)
        if turns:
            top, after = self.point(depth * self.h, far), self._landing(far, depth, way)
            return Slide(self, point, top, after, True)
        end = self.point(goal if depth == to else depth * self.h, far)
        lost = way < 0 and far <= self.narrowest
        lost = lost and self._one(far, way) >= depth - self._tie(depth)
        return Slide(self, point, end, Point(end.depth, None) if lost else None, False)

    def _tie(self, depth: float) -> float:
        return _TIE * (abs(depth) + self.holding_range / self.h)

    def _slides(self, a: float, here: float, to: float, way: int) -> tuple[float, float, bool]:
        """How far a line slides on the way to a depth, the depth there, and whether D turns."""
        before, last, far = a, here, a
        for x, rest in self._ahead(a, way):
            rest[0] = last
            for i in range(1, x.size):
                if way * (rest[i] - rest[i - 1]) < -self._tie(here):
                    top, value = least(
                        lambda y: -way * self._one(y, way), *sorted((before, float(x[i])))
                    )
                    found, top = way * -float(value), float(top)
                    if way * (found - to) < 0:
                        return top, found, True
                    return self._between(to, before, top, way), to, False
                if way * (rest[i] - to) >= 0:
                    return self._between(to, float(x[i - 1]), float(x[i]), way), to, False
                before = float(x[i - 1])
            last, far = float(rest[-1]), float(x[-1])
        if way > 0 and far not in self.body.corners:
            raise ValueError(SPREADS.format(depth=to * self.h, x=far * self.h + self.body.apex))
        return far, last, False

    def _one(self, a: float, way: int) -> float:
        return float(self.rest_depth(np.array([a]), way)[0])

    def _between(self, depth: float, one: float, other: float, way: int) -> float:
        """Where D is a depth."""
        return bracketed(lambda y: way * (self._one(y, way) - depth), one, other)

    def _landing(self, a: float, depth: float, way: int) -> Point:
        """Where a line that has come free at a depth rests next."""
        while True:
            for x, rest in self._ahead(a, way):
                off = way * (rest - depth)
                stays = (off[1:] >= 0) & (off[:-1] < 0)
                if stays.any():
                    i = int(np.argmax(stays))
                    found = self._between(depth, float(x[i]), float(x[i + 1]), way)
                    return self.point(depth * self.h, found)
                a = float(x[-1])
            if way < 0 and a not in self.body.corners:
                return Point(depth * self.h, None)
            if a not in self.body.corners:
                raise ValueError(
                    SPREADS.format(depth=depth * self.h, x=a * self.h + self.body.apex)
                )
            if way * (self._one(a, way) - depth) >= 0:
                return self.point(depth * self.h, a)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points in contact."""
        a = np.array([point.memory for point in points])
        u = np.array([point.depth for point in points]) / self.h - self.body.profile.height(a)
        _, _, stiffness, force, stored = self.table.at(a)
        bound = self.body.excess(self.scene) ** 2 * self.body.gamma / 2 * self._area(a)
        energy = stored + force * u + stiffness * u * u / 2 - bound
        return self.body.unit * np.array([energy * self.h, stiffness * u + force])

    def _area(self, a: Array) -> Array:
        """In contact [h, or h² about an axis]."""
        return math.pi * a * a if self.scene.axisymmetric else 2 * a

    def opened(self, before: Point, after: Point) -> float:
        """The length or area that opens between two points."""
        if not before.lines or not after.lines:
            return 0.0
        lost = self._area(np.array([before.memory])) - self._area(np.array([after.memory]))
        return max(0.0, float(lost[0])) * self.h ** (2 if self.scene.axisymmetric else 1)

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contact is in equilibrium, as far as the table is known."""
        if point.lines:
            a, depth = point.memory, point.depth / self.h
            state = Layer(self.body, self.body.condensed(a, self.tolerance), depth, self.tolerance)
            closing, opening = map(self.body.excess, (self.scene, self.scene.opened))
            found = certify(state, closing, opening)._replace(
                tolerance=max(TOLERANCE, self.tolerance)
            )
            found.demand(f"the state at depth = {point.depth!r}", "the path stops before it")
