"""Where the line of a contact of a layer rests, and how far it moves.

A convex profile that is mirrored about its lowest point, or turned about an axis, has one contact
with one line, at the half-width or radius a. From first touch the line advances while D(a) < d;
withdrawn it recedes while D(a) > d, D as in contact.py. At a corner, and at the edge of the body,
D jumps, and the line may be pinned. Lengths are in units of h.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import TIP
from discretization.layer.table import Table
from discretization.roots import bracketed, least

Array = NDArray[np.float64]
_AT_ONCE = 6  # of these
_PLACES = 2.0 ** np.arange(-30, 31)  # half-widths at which a line is looked for first
_SMALL = 1 / 8  # of √(2w/γ₁), and of the depth: slopes and heights where adhesion rules
_CLOSED = 1e-8  # of the half-width below which adhesion rules
_LEFT = 1 / 8  # of how far below touching a line about an axis rests at most


class Found(NamedTuple):
    """How far a line has come, and the depth there.

    how: it "rests" there, is at a "corner", where D "turns", or is "lost".
    """

    a: float
    depth: float
    how: str


class Lines:
    """The line of a body against a work of adhesion, with D from a table.

    ratio: of half-widths at which it is looked for; D may turn once between.
    """

    def __init__(self, table: Table, excess: float, ratio: float = 2.0) -> None:
        self.table, self.body, self.excess, self.ratio = table, table.body, excess, ratio

    def rest_depth(self, a: float, side: int) -> float:
        """D, at a corner on that side of it."""
        return self._rest_depths(np.array([a]), side)[0]

    def walk(
        self, start: float, depth: float, to: float, way: int, *, past: bool, tie: float = 0.0
    ) -> Found:
        """Where a line comes to from here, at a depth, on the way to another, out (1) or in (-1).

        past: on over places where D turns, and corners that do not hold it; tie: by which D turns
        at least. ValueError where the profile is not known any further.
        """
        before, a, last, rising = start, start, depth, not past
        for x, side, value in self._ahead(start, way):

            def short(y: float, end: float = x, side: int = side) -> float:
                return way * (self.rest_depth(y, side if y == end else way) - to)

            if rising and way * (value - last) < -tie:  # there is a top between
                top, best = self._top(before, x, way)
                if way * (best - to) >= 0:
                    return Found(bracketed(short, before, top), to, "rests")
                if not past:
                    return Found(top, best, "turns")
            elif way * (value - to) >= 0:
                return Found(bracketed(short, a, x), to, "rests")
            before, a, last, rising = a, x, value, way * (value - last) > 0
            if side != way and x in self.body.corners:
                last = self.rest_depth(x, way)
                if not past or way * (last - to) >= 0:
                    return Found(x, value, "corner")
        if way > 0:
            x = a * self.body.h + self.body.apex
            raise ValueError(
                f"depth = {to * self.body.h!r} spreads the contact over the whole known profile, "
                f"to {x!r}; give a wider profile, or a smaller depth"
            )
        touch = self.body.touch  # at which the lowest point alone lets go
        held = a <= TIP and touch < last - tie and (not past or touch <= to)
        return Found(a, last, "corner" if held else "lost")

    def _ahead(self, a: float, way: int) -> Iterator[tuple[float, int, float]]:
        """Places from a line on, the side of corners on which they are reached, and D there."""
        stops = [*self.body.corners, min(self.body.edge, float(_PLACES[-1]))]
        stops += [min(self.narrowest, a)] if way < 0 else []
        for stop in sorted((x for x in set(stops) if way * (x - a) > 0), key=lambda x: way * x):
            while a != stop:
                x: Any = a * self.ratio ** (way * np.arange(1, _AT_ONCE + 1))
                beyond = way * (x - stop) >= 0
                x = np.append(x[~beyond], stop) if beyond.any() else x
                side = np.where(x == stop, -way, way)
                yield from zip(x.tolist(), side.tolist(), self._rest_depths(x, side), strict=True)
                a = float(x[-1])

    def _rest_depths(self, a: Array, side: Any) -> list[float]:
        return list(self.table.rest_depth(a, self.excess, side).tolist())

    def _top(self, before: float, beyond: float, way: int) -> tuple[float, float]:
        a, value = least(lambda y: -way * self.rest_depth(y, way), *sorted((before, beyond)))
        return float(a), -way * float(value)

    def settled(self, depth: float) -> Found:
        """Where it rests at a depth on the way from first touch; "lost": the contact is."""
        pressed = max(depth, self.body.touch)
        a = self.start(pressed)
        found = Found(a, pressed, "corner" if a == TIP or a in self.body.corners else "rests")
        here = self.rest_depth(a, 1)
        if here < pressed:
            found = self.walk(a, here, pressed, 1, past=True)
        if depth < self.body.touch:
            here = self.rest_depth(found.a, -1)
            if here > depth:
                return self.walk(found.a, here, depth, -1, past=True)
        return found

    def start(self, depth: float) -> float:
        """A half-width so small that a line there advances, if there is any."""
        body, places = self.body, np.minimum(_PLACES, self.body.edge / 2)
        deep, rise = depth - self.body.touch, body.height(places) - self.body.touch
        limits = ((self.excess, body.slope(places)), (deep, rise))
        flat = [values < _SMALL * limit for limit, values in limits if limit > 0]
        a = float(places[np.all(flat, axis=0)].max(initial=places[0])) if flat else 1.0
        while a > TIP and self.rest_depth(a, 1) >= depth:
            a = max(a / 8, TIP)
        return a

    @functools.cached_property
    def narrowest(self) -> float:
        """Half-width down to which a contact is followed.

        A line contact closes up. About an axis D returns to first touch as the radius vanishes, and
        in contacts so small that it has nearly done so no line rests.
        """
        a = self.start(self.body.touch)
        if not self.body.scene.axisymmetric:
            return max(_CLOSED * a, TIP)
        least = here = self.rest_depth(a, 1) - self.body.touch
        while here < _LEFT * least:
            a /= 2
            here = self.rest_depth(a, 1) - self.body.touch
            least = min(least, here)
        return a
