"""Where the line of a contact of a layer rests, how far it moves, and what the contact takes.

A convex profile, mirrored about its lowest point or turned about an axis, has one contact with one
line, at the half-width or radius a. From first touch the line advances while D(a) < d; withdrawn it
recedes while D(a) > d, D as in contact.py. At corners and edges D jumps and may pin it.

What a contact takes is the same at any depth: a state looks at a few a, a path reads a table.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legval

from discretization.layer.body import Body
from discretization.layer.contact import Contact
from discretization.profile import unknown
from discretization.roots import bracketed, least
from discretization.surfaces.network import rounded, to_legendre
from energy.arrays import Array

_PLACES = 2.0 ** np.arange(-30, 31)  # of h: half-widths that are tried first, and the largest
_SMALL = 1 / 4  # of √(2w/γ₁), and of the depth: slopes and heights where adhesion rules
_TINY, _CLOSED = 1 / 64, 1e-8  # of the half-width below which adhesion rules: far below; closed up
_SPARSE = 6.0  # of log₂ a: half-widths that are looked at where they are far below
_ROUNDS = 10  # of the search for where D turns: D is known twice as well as the place
_TIE = 1e-12  # of depths and heights: depths that are the same
_CLOSE = 3e-7  # of the half-width: D is straight over that to rounding
_DEGREE = 10
_NARROW = 2.0**-9  # of log₂ a: a panel that is halved no more
_KNOWN = 0.1  # of the tolerance: last coefficients of a panel

Found = tuple[float, float, str]  # of `Lines.walk`


@dataclass(frozen=True, eq=False)
class Lines:
    """The line of a body against a work of adhesion, excess: √(2w/γ₁).

    reaction: σ, s₀, and maybe more, of half-widths; step: of log₂ a, in which D turns once at most.
    """

    body: Body
    reaction: Callable[[Any], Array]
    excess: float
    step: float

    def rest_depth(self, a: Any, side: Any) -> Any:
        """D, at a corner on that side of it; a number or an array."""
        found = self.body.rest_depth(a, self.reaction(a), self.excess, side)
        return found if np.ndim(a) else found.item()

    def walk(self, start: float, here: float, to: float, way: int, *, past: bool = True) -> Found:
        """How far a line comes, out (1) or in (-1), from where it rests at a depth to another.

        And the depth there, and how: it "rests", is at a "corner", where D "turns", or "lost".
        past: on over such turns, and corners that do not hold. ValueError beyond a known profile.
        """
        before, a, last, rising = start, start, here, not past
        size = abs(here - to) + abs(self.body.height(start) - self.body.touch)

        def short(y: float) -> float:
            return float(way * (self.rest_depth(y, -way if y == end else way) - to))

        for x, value in self._ahead(start, way):
            if x == a and (not past or way * (value - to) >= 0):
                return x, last, "corner"
            end, high, turned = x, value, rising and way * (value - last) < -_TIE * size
            if turned:
                lo, hi = sorted((before, x))
                fall = np.vectorize(lambda y: -way * self.rest_depth(y, way))
                turn = least(fall, lo, hi, -way * to, _ROUNDS)
                end, high, a = turn[0], -way * turn[1], before
            if way * (high - to) >= 0:
                first = max(0.1, min(0.9, (to - last) / ((high - last) or 1.0)))
                return bracketed(short, a, end, _CLOSE, first), to, "rests"
            if turned and not past:
                return end, high, "turns"
            before, a, last, rising = a, x, value, way * (value - last) > 0
        if way > 0:
            raise unknown(to, a + self.body.apex)
        return a, last, "lost"

    def _ahead(self, a: float, way: int) -> Iterator[tuple[float, float]]:
        """Places from a line on, and D there, at corners that may hold it before and beyond them.

        A lowest point alone lets go at first touch, where it is held till then. A line contact
        closes up; about an axis D returns to first touch as the radius vanishes. Far below all
        lengths, and where adhesion begins to rule, D turns once at most.
        """
        body, scene, least = self.body, self.body.scene, self.least
        small, last = self._small(body.touch), min(body.edge, float(_PLACES[-1]) * scene.layer.h)
        end = last if way > 0 else min(a, max(_CLOSED * small, least))
        length = max(small, min(scene.layer.h, scene.gamma1 / scene.layer.shear_modulus))
        middle = sorted((a, _TINY * length, end))[1]
        corners = {x for x in {*body.corners, least} if way * a < way * x <= way * end}
        steps = zip(itertools.pairwise((a, middle, end)), (self.step, _SPARSE)[::-way], strict=True)
        parts = [x * 2.0 ** (way * np.arange(h, way * math.log2(y / x), h)) for (x, y), h in steps]
        places = {*np.concatenate(parts).tolist(), middle, end, *corners}
        for x in sorted(places - {a}, reverse=way < 0):
            before = self.rest_depth(x, -way if x == end or x in corners else way)
            yield x, before
            if x in corners and way * (beyond := self.rest_depth(x, way)) > way * before:
                yield x, beyond

    def settled(self, depth: float) -> Found:
        """Where it rests at a depth on the way from first touch; "lost": the contact is."""
        pressed = max(depth, self.body.touch)
        a, here = 8 * self._small(pressed), math.inf
        while a > self.least and here >= pressed:
            a = max(a / 8, self.least)
            here = self.rest_depth(a, 1)
        found = self.walk(a, here, pressed, 1) if here < pressed else (a, pressed, "corner")
        if depth < self.body.touch and (here := self.rest_depth(found[0], -1)) > depth:
            return self.walk(found[0], here, depth, -1)
        return found

    def _small(self, depth: float) -> float:
        """A half-width so small, by slope and height, that a line there advances, if any does."""
        body, length = self.body, self.body.scene.layer.h
        places = np.minimum(_PLACES * length, body.edge / 2)
        lifted = self.excess * max(length, body.scene.elastocapillary_length)
        flat = body.height(places) - body.touch < _SMALL * (depth - body.touch + lifted)
        if self.excess:
            flat &= body.slope(places) < _SMALL * self.excess
        return max(float(places[flat].max(initial=0.0)), self.least)

    @functools.cached_property
    def least(self) -> float:
        """That of the lowest point, or of a flat face, which without adhesion parts as a whole."""
        level = [x for x in self.body.corners if self.body.height(x) == self.body.touch]
        return self.body.tip if self.excess else max(level, default=self.body.tip)


class Table:
    """σ, s₀, dP/du, and P₀ and U₀ at u(a) = 0, without adhesion, as polynomials in log₂ a.

    Octaves, or what breaks leave of them, are made when asked for, and halved until polynomials
    tell. panels: Legendre coefficients (5, 11) of what is taken between two log₂ a, and if enough.
    """

    def __init__(self, body: Body, tolerance: float) -> None:
        self.body, self.tolerance = body, tolerance
        self.breaks = [math.log2(x) for x in (*body.breaks, body.edge)]
        self.panels: dict[tuple[float, float], tuple[Array, bool]] = {}

    def at(self, a: Any) -> Array:
        """These five (5, n) of half-widths (n,), or one."""
        t = np.log2(np.atleast_1d(a))
        return self._read(t, float(np.ceil(t.min())) - 1, float(np.ceil(t.max())))

    def _read(self, t: Array, lo: float, hi: float) -> Array:
        """At log₂ a from a panel, or from its parts."""
        inner = [x for x in self.breaks if lo < x < hi]
        if hi - lo > 1:
            inner = [(lo + hi) // 2]
        if not inner:
            self.panels[lo, hi] = self.panels.get((lo, hi)) or self._made(lo, hi)
            series, known = self.panels[lo, hi]
            if known or hi - lo < _NARROW:
                return np.asarray(legval((2 * t - lo - hi) / (hi - lo), series.T))
        middle, found = min(inner, default=(lo + hi) / 2), np.empty((5, t.size))
        for own, one, other in ((t <= middle, lo, middle), (t > middle, middle, hi)):
            if own.any():
                found[:, own] = self._read(t[own], one, other)
        return found

    def _made(self, lo: float, hi: float) -> tuple[Array, bool]:
        a = np.minimum(np.exp2((lo + hi + (hi - lo) * rounded(_DEGREE)[0]) / 2), self.body.edge)
        values = np.array([Contact(self.body, x, self.tolerance).taken for x in a.tolist()])
        series = values.T @ to_legendre(_DEGREE)
        tail = np.abs(series[:, -2:]).max(axis=1)
        excess = self.body.scene.opened.surfaces.small_slope_deficit
        steep = abs(float(self.body.slope(2.0**hi, -1))) + excess
        low, rest, rate = values[:, 0].min(), np.abs(values[:, 1]).max() + steep, values[:, 2].max()
        lift = rest / low  # by which u(a) may change
        size = np.array([low, rest, rate, rate * lift, rate * lift**2])
        return series, bool((tail <= _KNOWN * self.tolerance * size).all())
