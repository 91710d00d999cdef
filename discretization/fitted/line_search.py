"""Where the two lines of a free surface come to rest at a fixed depth.

Lines q < p of a gap between two contacts, or one of them at infinity: a tail. Advancing (way 1)
they go to the first places where D >= d, receding (way -1) to the first where D <= d, D that of
../surfaces. In a gap each feels the other: they take turns, and close to their resting places both
are found at once by Newton's method, which is tried in every other sweep.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import TOLERANCE, NotCertifiedError
from discretization.fitted.rest_depths import TIE, RestDepths, displacement_scale
from discretization.fitted.tension import Pull, bounds, pull
from discretization.fitted.zeros import first_zero, gap_at_rest
from energy.arrays import Array

Pair = tuple[float, float]
MET = 1e-9  # of l: lines closer than that have met
PULLED = TOLERANCE / 4  # of a state's depths: a pull that opens no gap
_SHUT = 1 / 4  # of that: what still keeps a gap open
_SWEEPS = 1000  # over all lines; each is a contraction
_STILL = 4e-16  # of the positions: a line that moves less has come to rest
_ALONG = np.arange(1, 9) / 8  # of a way: where a line is asked whether it rests


@dataclass(frozen=True, eq=False)
class LineSearch:
    """Resting places of the lines of one free surface."""

    rests: RestDepths

    def closed(self, q: float, p: float, depth: float) -> bool:
        """Whether nothing holds a gap open: without adhesion, that the profile would pull there."""
        adheres = self.rests.scene.work_of_adhesion > 0
        return not (adheres or math.isinf(q - p) or self.pulls(q, p, depth))

    def pulls(self, one: float, other: float, depth: float) -> bool:
        """Whether the profile pulls between two positions, so that a gap there stays open.

        One closes at clearly less than opens one, or it would open and close for ever.
        """
        profile, least = self.rests.profile, _SHUT * self.least_pull(depth)
        own = profile.beyond(one, other)
        inner = (self._bounds[0, own.start : own.stop - 1] - depth) * np.diff(profile.x[own])
        torn = (inner > least * self.rests.length).any() or self.torn(one, other, depth).size
        return bool(torn or self.pull(one, other, depth).force > least)

    @functools.cached_property
    def _bounds(self) -> Array:
        """Of the pull at depth 0 between samples."""
        return bounds(self.rests.scene, self.rests.profile)

    def pull(self, one: float, other: float, depth: float) -> Pull:
        """The largest pull in contact between two positions, in either order."""
        own = self.rests.profile.beyond(one, other)
        if self._bounds[1, max(own.start - 1, 0) : own.stop].max(initial=-math.inf) < depth:
            return Pull()
        return pull(self.rests.scene, self.rests.profile, one, other, depth)

    def least_pull(self, depth: float) -> float:
        """The least pull at which a contact that does not adhere opens, over kl [length].

        Gaps close continuously with it, and D is known the less the narrower they are.
        """
        return PULLED * displacement_scale(self.rests.scene, depth, self.rests.size)

    def torn(self, one: float, other: float, depth: float, holds: Any = 0.0) -> Array:
        """The corners between two positions at which the slope falls by more than `holds` holds.

        Pressed by kg, a gap of width s opens at a fall of 2 g s/l²; none is shorter than MET.
        """
        profile, length = self.rests.profile, self.rests.length
        x, aside = profile.corners, 2 * MET * length
        if not x.size:
            return x
        g = np.maximum(depth - np.asarray(profile.indenter.height(x), float), 0.0)
        falls = profile.falls(self.rests.scene.slopes) - MET * g / length
        inside = (x > min(one, other) + aside) & (x < max(one, other) - aside)
        return np.asarray(x[inside & (falls > holds)])

    # both lines of a free surface: advancing (way 1) and receding (way -1)

    def advance(self, q: float, p: float, depth: float) -> Pair | None:
        """Both lines of a free surface advance; None: they meet, or that of a tail leaves."""
        everywhere = -math.inf, math.inf
        return None if self.closed(q, p, depth) else self._turns(q, p, everywhere, depth, 1)

    def recede(self, q: float, p: float, least: float, most: float, depth: float) -> Pair:
        """Both lines of a free surface recede, not beyond the other lines of their contacts.

        If nowhere, a line rests just beyond that.
        """
        return self._turns(q, p, (least, most), depth, -1)  # only lines that advance meet

    def _turns(self, q: float, p: float, limits: Pair, depth: float, way: int) -> Any:
        """Both lines move in turns until they rest; limits: of lines that recede."""
        least, most = limits
        for sweep in range(_SWEEPS):
            if way > 0 and p - q <= 2 * MET * self.rests.length:
                return None
            ends = q, p
            for exact in (True,) if math.isinf(q - p) or sweep % 2 else (False, True):
                a = self.line(1, q, least, p, depth, way, exact)
                b = None if a is None else self.line(-1, p, most, a, depth, way, exact)
                if a is None or b is None:
                    return None
                ends, lost = (a, b), a < least or b > most
                near = None if exact or lost else self._nearby((a, b), depth, way)
                if near is not None and near[0] >= least and near[1] <= most:
                    return near
            a, b = ends
            # where an equilibrium is about to disappear lines tremble for ever: more is rounding
            least_step = _STILL * (1 + sweep * sweep)
            still = abs(a - q) <= least_step * abs(q) and abs(b - p) <= least_step * abs(p)
            if still or math.isinf(a - b) or lost:
                return a, b
            step, (q, p) = (a - q, b - p), (a, b)
            further = self._further(q, p, step, depth, way)
            if further[0] >= least and further[1] <= most:
                q, p = further
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def line(
        self, side: int, x: float, limit: float, facing: float, depth: float, way: int, exact: bool
    ) -> float | None:
        """Where one line rests beside the other, at most at the edge of the body; None: nowhere."""
        if math.isinf(x) or (way < 0 and x == limit):
            return x
        end = facing if way > 0 else limit
        found = self._first_zero(side, x, end, facing, depth, way, exact)
        if found is not None or way < 0:
            return math.nextafter(limit, -side * math.inf) if found is None else found
        edge = float(self.rests.profile.x[-1 if side > 0 else 0])
        return edge if math.isinf(facing) and edge in self.rests.profile.indenter.walls else None

    def _first_zero(
        self, side: int, x: float, limit: float, facing: float, depth: float, way: int, exact: bool
    ) -> float | None:
        """The first place on this way at which a line rests; of one that recedes also the limit.

        Or if that need not be exact, one just before it.
        """
        beyond, w, indenter = self.rests.at(facing), self.rests.w(way), self.rests.profile.indenter

        def h(x: Any, f: Any = None, f1: Any = None) -> Any:
            f, f1 = (indenter.height(x), indenter.slope(x)) if f is None else (f, f1)
            return way * (self.rests.rest_depth(side, x, f, f1, beyond, w) - depth)

        closed, tie = way < 0 and math.isfinite(limit), TIE * self.rests.size * (way < 0)
        return first_zero(self.rests.profile, h, (x, limit), closed, exact, tie)

    def _nearby(self, start: Pair, depth: float, way: int) -> Pair | None:
        """Both lines of a gap in stable equilibrium beyond a start on this way, by Newton's method.

        None where a sample lies in between, they are not stable, or it fails.
        """
        found = gap_at_rest(self.rests, np.array(start), depth, way)
        if found is None:
            return None
        q, p = found.tolist()
        for place, moved in ((start[0], q), (start[1], p)):
            between = self.rests.profile.beyond(place, moved)
            if between.stop > between.start:
                return None
        return q, p

    def _further(self, q: float, p: float, step: Pair, depth: float, way: int) -> Pair:
        """The lines of a gap further on the same way, in growing steps of the one that moves most.

        Where an equilibrium has just disappeared they would pass its place by ever smaller ones.
        The other line is at rest meanwhile, and no step leaves the first beyond where it rests.
        """
        side = 1 if abs(step[0]) >= abs(step[1]) else -1
        (own, other), move = ((q, p), step[0]) if side > 0 else ((p, q), step[1])
        indenter = self.rests.profile.indenter
        while move:
            x, move = own + 4 * move, 4 * move
            passed = self.rests.profile.beyond(own, x)
            if passed.stop > passed.start or side * (other - x) <= 0:
                break
            limit = x if way > 0 else side * math.inf
            stop = self._first_zero(-side, other, limit, x, depth, way, exact=True)
            if stop is None:
                break
            z, facing = own + (x - own) * _ALONG, self.rests.at(other + (stop - other) * _ALONG)
            place = side, z, indenter.height(z), indenter.slope(z), facing, self.rests.w(way)
            if (way * (self.rests.rest_depth(*place) - depth) >= 0).any():
                break  # on its way, with the other line moving with it, the line is at rest
            own, other = x, stop
        return (own, other) if side > 0 else (other, own)
