"""Where the line of a contact of a layer rests, and how far it moves.

A convex profile that is mirrored about its lowest point, or turned about an axis, has one contact
with one line, at the half-width or radius a. From first touch the line advances while D(a) < d;
withdrawn it recedes while D(a) > d, D as in contact.py. At a corner, and at the edge of the body,
D jumps, and the line may be pinned.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.table import Table
from discretization.roots import bracketed, least

Array = NDArray[np.float64]
_AT_ONCE = 6  # of these
_PLACES = 2.0 ** np.arange(-30, 31)  # of h: half-widths at which a line is looked for first
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
    """The line of a body against a work of adhesion, excess: √(2w/γ₁).

    ratio: of half-widths at which it is looked for; D may turn once between.
    """

    def __init__(self, table: Table, excess: float, ratio: float = 2.0) -> None:
        self.table, self.body, self.excess, self.ratio = table, table.body, excess, ratio

    def rest_depth(self, a: Any, side: Any) -> Any:
        """D by the table, at a corner on that side of it; a number or an array."""
        at = np.atleast_1d(a)
        found = self.body.rest_depth(at, self.table.at(at)[:2], self.excess, side)
        return found if np.ndim(a) else float(found[0])

    def exactly(self, a: float, side: int) -> float:
        """The same not by the table."""
        at = np.array([a])
        return float(self.body.rest_depth(at, self.table.reaction(at), self.excess, side)[0])

    def walk(
        self, start: float, depth: float, to: float, way: int, *, past: bool, tie: float = 0.0
    ) -> Found:
        """Where a line comes to from here, at a depth, on the way to another, out (1) or in (-1).

        past: on over places where D turns, and corners that do not hold it; tie: by which D turns
        at least. ValueError where the profile is not known any further.
        """
        before, a, last, rising, known = start, start, depth, not past, {start: depth}

        def short(y: float) -> float:
            return way * ((known[y] if y in known else self.rest_depth(y, way)) - to)

        for x, value, beyond in self._ahead(start, way):
            known[x] = value
            if rising and way * (value - last) < -tie:  # there is a top between
                top, best = self._top(before, x, way)
                if way * (best - to) >= 0:
                    known[top] = best
                    return Found(bracketed(short, before, top), to, "rests")
                if not past:
                    return Found(top, best, "turns")
            elif way * (value - to) >= 0:
                return Found(bracketed(short, a, x), to, "rests")
            held = beyond != value and (not past or way * (beyond - to) >= 0)
            before, a, last, rising = a, x, beyond, way * (value - last) > 0
            known[x] = beyond
            if held:
                return Found(x, value, "corner")
        if way > 0:
            x = a + self.body.apex
            raise ValueError(
                f"depth = {to!r} spreads the contact over the whole known profile, to {x!r}; give "
                "a wider profile, or a smaller depth"
            )
        touch = self.body.touch  # at which the lowest point alone lets go
        held = a <= self.body.tip and touch < last - tie and (not past or touch <= to)
        return Found(a, last, "corner" if held else "lost")

    def _ahead(self, a: float, way: int) -> Iterator[tuple[float, float, float]]:
        """Places from a line on, and D there, at corners on the way to and from them."""
        furthest = float(_PLACES[-1]) * self.body.scene.layer.h
        stops = [*self.body.corners, min(self.body.edge, furthest)]
        stops += [min(self.narrowest, a)] if way < 0 else []
        for stop in sorted((x for x in set(stops) if way * (x - a) > 0), key=lambda x: way * x):
            while a != stop:
                x: Any = a * self.ratio ** (way * np.arange(1, _AT_ONCE + 1))
                x = np.append(x[way * (stop - x) > 0], stop)[:_AT_ONCE]
                known = x, self.table.reaction(x), self.excess
                value = self.body.rest_depth(*known, np.where(x == stop, -way, way))
                beyond = self.body.rest_depth(*known, way)
                corner = np.isin(x, self.body.corners)
                rows = np.array([x, value, np.where(corner, beyond, value)])
                yield from map(tuple, rows.T.tolist())
                a = float(x[-1])

    def _top(self, before: float, beyond: float, way: int) -> tuple[float, float]:
        a, value = least(lambda y: -way * self.rest_depth(y, way), *sorted((before, beyond)))
        return float(a), -way * float(value)

    def settled(self, depth: float) -> Found:
        """Where it rests at a depth on the way from first touch; "lost": the contact is."""
        pressed = max(depth, self.body.touch)
        a, here = self.start(pressed)
        found = Found(a, pressed, "corner" if a in (self.body.tip, *self.body.corners) else "rests")
        if here < pressed:
            found = self.walk(a, here, pressed, 1, past=True)
        if depth < self.body.touch:
            here = self.exactly(found.a, -1)
            if here > depth:
                return self.walk(found.a, here, depth, -1, past=True)
        return found

    def start(self, depth: float) -> tuple[float, float]:
        """A half-width so small that a line there advances, if there is any, and D there."""
        body, tip = self.body, self.body.tip
        if self.flat:
            return self.flat, self.exactly(self.flat, 1)
        places = np.minimum(_PLACES * body.scene.layer.h, body.edge / 2)
        deep, rise = depth - body.touch, body.height(places) - body.touch
        limits = ((self.excess, body.slope(places)), (deep, rise))
        flat = [values < _SMALL * limit for limit, values in limits if limit > 0]
        a = places[np.all(flat, axis=0)].max(initial=places[0]) if flat else body.scene.layer.h
        a, here = float(a), self.exactly(float(a), 1)
        while a > tip and here >= depth:
            a = max(a / 8, tip)
            here = self.exactly(a, 1)
        return a, here

    @functools.cached_property
    def flat(self) -> float:
        """Half-width of a flat face, which without adhesion touches and parts as a whole; or 0."""
        level = [x for x in self.body.corners if self.body.height(x) == self.body.touch]
        return 0.0 if self.excess else max(level, default=0.0)

    @functools.cached_property
    def narrowest(self) -> float:
        """Half-width down to which a contact is followed.

        A line contact closes up. About an axis D returns to first touch as the radius vanishes, and
        in contacts so small that it has nearly done so no line rests.
        """
        touch = self.body.touch
        a, here = self.start(touch)
        if self.flat or not self.body.power:
            return self.flat or max(_CLOSED * a, self.body.tip)
        least = here
        while here - touch < _LEFT * (least - touch):
            a /= 2
            here = self.exactly(a, 1)
            least = min(least, here)
        return a
