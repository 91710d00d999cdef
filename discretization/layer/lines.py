"""Where the line of a contact of a layer rests, how far it moves, and what the contact takes.

A convex profile that is mirrored about its lowest point, or turned about an axis, has one contact
with one line, at the half-width or radius a. From first touch the line advances while D(a) < d;
withdrawn it recedes while D(a) > d, D as in contact.py. At a corner, and at the edge of the body,
D jumps, and the line may be pinned.

What a contact takes does not depend on the depth. A state looks at a few half-widths, a path reads
it off a table over all of them.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import Body
from discretization.layer.contact import Contacts, contacts
from discretization.roots import bracketed, least
from discretization.surfaces.network import coefficients, polynomial, rounded

Array = NDArray[np.float64]
_PLACES = 2.0 ** np.arange(-30, 31)  # of h: half-widths at which a line is looked for first
_SMALL = 1 / 4  # of √(2w/γ₁), and of the depth: slopes and heights where adhesion rules
_CLOSED = 1e-8  # of the half-width below which adhesion rules
_LEFT = 1 / 8  # of how far below touching a line about an axis rests at most
_SECTIONS = 27  # golden ones, of where D turns: D is known twice as well
_TIE = 1e-12  # of the depth and how far a line is lifted: depths that are the same
_DEGREE = 10
_HALVINGS = 10
_KNOWN = 0.1  # of the tolerance: last coefficients of a panel


class Single:
    """What single contacts of a body take.

    step: of log₂ a, at which a line is looked for; D may turn once between.
    """

    step = 1.0

    def __init__(self, body: Body, tolerance: float) -> None:
        self.body, self.tolerance = body, tolerance
        self.known: dict[float, Contacts] = {}

    def contact(self, a: float) -> Contacts:
        """The contact of a half-width, found once."""
        if a not in self.known:
            self.known[a] = contacts(self.body, np.array([a]), self.tolerance)
        return self.known[a]

    def reaction(self, a: Array) -> Array:
        """σ and s₀ (2, n) of half-widths (n,)."""
        return np.array([self.contact(x).reaction[0] for x in a.tolist()]).T


class Panel(NamedTuple):
    """Between two half-widths: their logarithms, and what is taken at Lobatto points (11, 5)."""

    lo: float
    hi: float
    values: Array


class Table:
    """What contacts of a body take, as polynomials in log₂ a.

    Octaves, made where they are asked for, are halved until the polynomials tell it.
    """

    step = 1 / 12

    def __init__(self, body: Body, tolerance: float) -> None:
        self.body, self.tolerance = body, tolerance
        self.breaks = np.log2([*body.breaks, body.edge])
        self.panels: dict[tuple[float, float], list[Panel]] = {}

    def reaction(self, a: Array) -> Array:
        """σ and s₀ (2, n) of half-widths (n,)."""
        return self.at(a)[:2]

    def taken(self, a: Array, depth: Array) -> tuple[Array, Array]:
        """P, and U without adhesion, of half-widths at depths (n,)."""
        u, (_, _, rate, force, stored) = depth - self.body.height(a), self.at(a)
        return rate * u + force, stored + force * u + rate * u * u / 2

    def at(self, a: Array) -> Array:
        """σ, s₀, dP/du, P₀ and U₀ at u(a) = 0 (5, n) at half-widths (n,)."""
        t, found = np.log2(a), np.empty((5, a.size))
        octaves = np.arange(np.floor(t.min()), np.floor(t.max()) + 2)
        inner = (self.breaks > octaves[0]) & (self.breaks < octaves[-1])
        cuts = np.union1d(octaves, self.breaks[inner])
        part = np.maximum(np.searchsorted(cuts, t), 1)
        for i in np.unique(part).tolist():
            key = float(cuts[i - 1]), float(cuts[i])
            self.panels[key] = self.panels.get(key) or self._made(*key, _HALVINGS)
            for lo, hi, values in self.panels[key]:
                own = (t >= lo) & (t <= hi)
                found[:, own] = polynomial(_DEGREE, (2 * t[own] - lo - hi) / (hi - lo), values)
        return found

    def _made(self, lo: float, hi: float, left: int) -> list[Panel]:
        t = (lo + hi) / 2 + (hi - lo) / 2 * rounded(_DEGREE)[0]
        a = np.minimum(np.exp2(t), self.body.edge)
        alike = not any(0 < x < a.max() for x in self.body.breaks)  # else each has its own elements
        groups = [a] if alike else np.split(a, a.size)
        values = np.concatenate([_five(contacts(self.body, x, self.tolerance)) for x in groups])
        tail = np.abs(coefficients(_DEGREE, values.T)[:, -2:]).max(axis=1)
        slope = abs(float(self.body.slope(2.0**hi, -1)))
        excess = self.body.scene.opened.surfaces.small_slope_deficit
        rest, rate = np.abs(values[:, 1]).max() + slope + excess, values[:, 2].max()
        lift = rest / values[:, 0].min()  # by which u(a) may change
        size = np.array([values[:, 0].min(), rest, rate, rate * lift, rate * lift**2])
        if left and (tail > _KNOWN * self.tolerance * size).any():
            middle = (lo + hi) / 2
            return self._made(lo, middle, left - 1) + self._made(middle, hi, left - 1)
        return [Panel(lo, hi, values)]


def _five(own: Contacts) -> Array:
    stored = own.form[:, 1, 1] / 2 + own.stretched
    return np.column_stack([own.reaction, own.form[:, :, 0], stored])


class Found(NamedTuple):
    """How far a line has come, and the depth there.

    how: it "rests" there, is at a "corner", where D "turns", or is "lost".
    """

    a: float
    depth: float
    how: str


class Lines:
    """The line of a body against a work of adhesion, excess: √(2w/γ₁)."""

    def __init__(self, taken: Single | Table, excess: float) -> None:
        self.taken, self.body, self.excess = taken, taken.body, excess

    def rest_depth(self, a: Any, side: Any) -> Any:
        """D, at a corner on that side of it; a number or an array."""
        at = np.atleast_1d(a)
        found = self.body.rest_depth(at, self.taken.reaction(at), self.excess, side)
        return found if np.ndim(a) else float(found[0])

    def walk(
        self, start: float, depth: float, to: float, way: int, *, past: bool, tie: float = 0.0
    ) -> Found:
        """Where a line comes to from here, at a depth, on the way to another, out (1) or in (-1).

        past: on over places where D turns, and corners that do not hold it; tie: by which D turns
        at least. ValueError where the profile is not known any further.
        """

        def rests(inside: float, outside: float) -> Found:
            def short(y: float) -> float:
                off = way * (self.rest_depth(y, -way if y == outside else way) - to)
                return 0.0 if abs(off) <= tie else float(off)

            return Found(bracketed(short, inside, outside), to, "rests")

        before, a, last, rising = start, start, depth, not past
        for x, value in self._ahead(start, way):
            if x == a:  # a corner
                if not past or way * (value - to) >= 0:
                    return Found(x, last, "corner")
            elif rising and way * (value - last) < -tie:  # there is a top between
                top, best = self._top(before, x, to, way)
                if way * (best - to) >= 0:
                    return rests(before, top)
                if not past:
                    return Found(top, best, "turns")
            elif way * (value - to) >= 0:
                return rests(a, x)
            before, a, last, rising = a, x, value, way * (value - last) > 0
        if way > 0:
            raise ValueError(
                f"depth = {to!r} spreads the contact over the whole known profile, to "
                f"{a + self.body.apex!r}; give a wider profile, or a smaller depth"
            )
        return Found(a, last, "lost")

    def _ahead(self, a: float, way: int) -> Iterator[tuple[float, float]]:
        """Places from a line on, and D there, at corners on the way to and from them.

        A lowest point alone lets go at first touch, where it is held till then.
        """
        ends = [min(self.body.edge, float(_PLACES[-1]) * self.body.scene.layer.h)]
        ends += [min(self.narrowest, a)] if way < 0 else []
        stops = {x for x in [*self.body.corners, *ends] if way * (x - a) > 0}
        for stop in sorted(stops, key=lambda x: way * x):
            while a != stop:
                steps = self.taken.step * np.arange(1, round(1 / self.taken.step) + 1)
                x: Any = a * 2.0 ** (way * steps)
                x = np.append(x[way * (stop - x) > 0], stop)[: steps.size]
                value = self.rest_depth(x, np.where(x == stop, -way, way))
                yield from zip(x.tolist(), value.tolist(), strict=True)
                a = float(x[-1])
            beyond = self.rest_depth(stop, way)
            if stop in self.body.corners or (stop <= self.body.tip and beyond < value[-1]):
                yield stop, beyond

    def _top(self, before: float, beyond: float, to: float, way: int) -> tuple[float, float]:
        def low(y: float) -> float:
            return float(-way * self.rest_depth(y, way))

        lo, hi = sorted((before, beyond))
        a, value = least(low, lo, hi, -way * to, _SECTIONS)
        return float(a), -way * float(value)

    def settled(self, depth: float) -> Found:
        """Where it rests at a depth on the way from first touch; "lost": the contact is."""
        pressed = max(depth, self.body.touch)
        a, here = self.start(pressed)
        found = Found(a, pressed, "corner" if a in (self.body.tip, *self.body.corners) else "rests")
        if here < pressed:
            found = self.walk(a, here, pressed, 1, past=True, tie=_TIE * (pressed - here))
        if depth < self.body.touch:
            here = self.rest_depth(found.a, -1)
            if here > depth:
                return self.walk(found.a, here, depth, -1, past=True, tie=_TIE * (here - depth))
        return found

    def start(self, depth: float) -> tuple[float, float]:
        """A half-width so small that a line there advances, if there is any, and D there."""
        body, tip = self.body, self.body.tip
        if self.flat:
            return self.flat, self.rest_depth(self.flat, 1)
        places = np.minimum(_PLACES * body.scene.layer.h, body.edge / 2)
        deep, rise = depth - body.touch, body.height(places) - body.touch
        limits = ((self.excess, body.slope(places)), (deep, rise))
        flat = [values < _SMALL * limit for limit, values in limits if limit > 0]
        a = places[np.all(flat, axis=0)].max(initial=places[0]) if flat else body.scene.layer.h
        a, here = float(a), self.rest_depth(float(a), 1)
        while a > tip and here >= depth:
            a = max(a / 8, tip)
            here = self.rest_depth(a, 1)
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
        lowest = here
        while here - touch < _LEFT * (lowest - touch):
            a /= 2
            here = self.rest_depth(a, 1)
            lowest = min(lowest, here)
        return a
