"""Where the two lines of a free surface come to rest at a fixed depth.

The lines q < p are those of a gap between two contacts, or one of them is at infinity: a tail.
Advancing (direction 1) they go to the first places where D >= d, receding (direction -1) to the
first where D <= d, D that of ../surfaces. In a gap each feels the other: they move one after the
other, and close to where they rest both are found at once by Newton's method, which is tried in
every other sweep.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import TOLERANCE, NotCertifiedError
from discretization.fitted.rest_depths import TIE, RestDepths, displacement_scale
from discretization.fitted.tension import Pull, bounds, pull
from discretization.fitted.zeros import first_zero, gap_at_rest
from energy.arrays import Array

Pair = tuple[float, float]
MET = 1e-9  # of l: lines closer than that have met
PULLED = TOLERANCE / 4  # of a state's depths: a pull that opens no gap, and passes the certificate


class TurnRules(NamedTuple):
    """When the two lines of a gap, which move one after the other, have come to rest.

    Attributes
    ----------
    most_sweeps : int
        Sweeps over both lines at most; each is a contraction.
    still : float
        Of the positions, two roundings: a line that moves less has come to rest.
    further : int
        The next step of lines that move on alike, over the last one.
    still_open : float
        Of PULLED: a pull that keeps a gap open.
    """

    most_sweeps: int = 1000
    still: float = 4e-16
    further: int = 4
    still_open: float = 1 / 4


_RULES = TurnRules()


_ALONG = np.arange(1, 9) / 8  # parts of a step where it is read whether a line rests


@dataclass(frozen=True, eq=False)
class EquilibriumFinder:
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
        profile = self.rests.profile
        least = _RULES.still_open * self.least_pull(depth)
        own = profile.beyond(one, other)
        least_pulls = self._bounds[0, own.start : own.stop - 1] - depth
        between_samples = least_pulls * np.diff(profile.x[own])
        if (between_samples > least * self.rests.length).any():
            return True
        if self.opening_corners(one, other, depth).size:
            return True
        return self.pull(one, other, depth).force > least

    @functools.cached_property
    def _bounds(self) -> Array:
        """Safe bounds, lower and upper (2, n), of the pull at depth 0 between samples."""
        return bounds(self.rests.scene, self.rests.profile)

    def pull(self, one: float, other: float, depth: float) -> Pull:
        """The largest pull in contact between two positions, in either order."""
        own = self.rests.profile.beyond(one, other)
        most = self._bounds[1, max(own.start - 1, 0) : own.stop].max(initial=-math.inf)
        if most < depth:
            return Pull()
        return pull(self.rests.scene, self.rests.profile, one, other, depth)

    def least_pull(self, depth: float) -> float:
        """The least pull at which a contact that does not adhere opens, over kl [length].

        Gaps close continuously with it, and D is known the less the narrower they are.
        """
        return PULLED * displacement_scale(self.rests.scene, depth, self.rests.size)

    def opening_corners(self, one: float, other: float, depth: float, holds: Any = 0.0) -> Array:
        """The corners between two positions at which the slope falls by more than `holds` holds.

        Pressed by kg, a gap of width s opens at a fall of 2 g s/l²; none is shorter than MET.
        """
        profile = self.rests.profile
        length = self.rests.length
        aside = 2 * MET * length
        x = profile.corners
        if not x.size:
            return x
        g = np.maximum(depth - np.asarray(profile.indenter.height(x), float), 0.0)
        falls = profile.falls(self.rests.scene.slopes) - MET * g / length
        inside = (x > min(one, other) + aside) & (x < max(one, other) - aside)
        return np.asarray(x[inside & (falls > holds)])

    def advance(self, q: float, p: float, depth: float) -> Pair | None:
        """Both lines of a free surface advance to the first places where they rest.

        Parameters
        ----------
        q, p : float
            The left and the right line [length], infinite where there is none.
        depth : float
            [length].

        Returns
        -------
        tuple of float or None
            [length]. None if they meet, or the line of a tail leaves the known profile.

        Raises
        ------
        NotCertifiedError
            If they do not come to rest.
        """
        if self.closed(q, p, depth):
            return None
        everywhere = (-math.inf, math.inf)
        return self._alternated(q, p, everywhere, depth, 1)

    def recede(self, q: float, p: float, least: float, most: float, depth: float) -> Pair:
        """Both lines of a free surface recede to the first places where they rest.

        Parameters
        ----------
        q, p, depth
            As of `advance`.
        least, most : float
            The other lines of their contacts [length].

        Returns
        -------
        tuple of float
            [length]. A line that rests nowhere before the other one of its contact is just beyond.

        Raises
        ------
        NotCertifiedError
            If they do not come to rest.
        """
        found = self._alternated(q, p, (least, most), depth, -1)
        assert found is not None, "only lines that advance meet"
        return found

    def _alternated(
        self, q: float, p: float, limits: Pair, depth: float, direction: int
    ) -> Pair | None:
        """Both lines move in turns until they rest; limits: of lines that recede."""
        least, most = limits
        for sweep in range(_RULES.most_sweeps):
            if direction > 0 and p - q <= 2 * MET * self.rests.length:
                return None
            try_newton = not (math.isinf(q - p) or sweep % 2)
            if try_newton:
                ends = self._one_after_the_other(q, p, limits, depth, direction, exact=False)
                if ends is None:
                    return None
                lost = ends[0] < least or ends[1] > most
                near = None if lost else self._nearby(ends, depth, direction)
                if near is not None and near[0] >= least and near[1] <= most:
                    return near
            ends = self._one_after_the_other(q, p, limits, depth, direction, exact=True)
            if ends is None:
                return None
            a, b = ends
            lost = a < least or b > most
            # where an equilibrium is about to disappear lines tremble for ever: more is rounding
            least_step = _RULES.still * (1 + sweep * sweep)
            rests = abs(a - q) <= least_step * abs(q) and abs(b - p) <= least_step * abs(p)
            if rests or math.isinf(a - b) or lost:
                return ends
            further = self._further(a, b, (a - q, b - p), depth, direction)
            within = further[0] >= least and further[1] <= most
            q, p = further if within else ends
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def _one_after_the_other(
        self, q: float, p: float, limits: Pair, depth: float, direction: int, *, exact: bool
    ) -> Pair | None:
        """The left line moves until it rests, then the right one; None if one rests nowhere."""
        a = self.line(1, q, limits[0], p, depth, direction, exact)
        if a is None:
            return None
        b = self.line(-1, p, limits[1], a, depth, direction, exact)
        return None if b is None else (a, b)

    def line(
        self,
        side: int,
        x: float,
        limit: float,
        facing: float,
        depth: float,
        direction: int,
        exact: bool,
    ) -> float | None:
        """Where one line rests beside the other.

        Parameters
        ----------
        side : {1, -1}
            1 for a line whose contact is on its left.
        x : float
            Where it is [length].
        limit : float
            The other line of its contact, as far as which it may recede [length].
        facing : float
            The line beyond its free surface, infinite if there is none [length].
        depth : float
            [length].
        direction : {1, -1}
            1 where it advances, -1 where it recedes.
        exact : bool
            Whether the place itself is needed; otherwise it may be one just before it.

        Returns
        -------
        float or None
            [length]; at most the edge of the body. None if an advancing line rests nowhere; one
            that recedes is then just beyond the limit.
        """
        if math.isinf(x) or (direction < 0 and x == limit):
            return x
        end = facing if direction > 0 else limit
        found = self._first_zero(side, x, end, facing, depth, direction, exact)
        if found is not None:
            return found
        if direction < 0:
            return math.nextafter(limit, -side * math.inf)
        edge = float(self.rests.profile.x[-1 if side > 0 else 0])
        ends_there = math.isinf(facing) and edge in self.rests.profile.indenter.walls
        return edge if ends_there else None

    def _first_zero(
        self,
        side: int,
        x: float,
        limit: float,
        facing: float,
        depth: float,
        direction: int,
        exact: bool,
    ) -> float | None:
        """The first place in this direction at which a line rests; if it recedes also the limit.

        Or if that need not be exact, one just before it.
        """
        beyond = self.rests.at(facing)
        w = self.rests.w(direction)
        indenter = self.rests.profile.indenter

        def h(x: Any, f: Any = None, f1: Any = None) -> Any:
            if f is None:
                f = indenter.height(x)
                f1 = indenter.slope(x)
            return direction * (self.rests.rest_depth(side, x, f, f1, beyond, w) - depth)

        recedes = direction < 0
        closed = recedes and math.isfinite(limit)
        tie = TIE * self.rests.size if recedes else 0.0
        return first_zero(self.rests.profile, h, (x, limit), closed, exact, tie)

    def _nearby(self, start: Pair, depth: float, direction: int) -> Pair | None:
        """Both lines of a gap in stable equilibrium beyond a start, by Newton's method.

        None where a sample lies in between, they are not stable, or it fails.
        """
        found = gap_at_rest(self.rests, np.array(start), depth, direction)
        if found is None:
            return None
        q, p = found.tolist()
        for place, moved in ((start[0], q), (start[1], p)):
            between = self.rests.profile.beyond(place, moved)
            if between.stop > between.start:
                return None
        return q, p

    def _further(self, q: float, p: float, step: Pair, depth: float, direction: int) -> Pair:
        """The lines of a gap further on in the same direction, in growing steps of the faster one.

        Where an equilibrium has just disappeared they would pass its place by ever smaller ones.
        The other line is at rest meanwhile, and no step leaves the first beyond where it rests.
        """
        side = 1 if abs(step[0]) >= abs(step[1]) else -1
        own, other = (q, p) if side > 0 else (p, q)
        move = step[0] if side > 0 else step[1]
        while move:
            move = _RULES.further * move
            x = own + move
            passed = self.rests.profile.beyond(own, x)
            if passed.stop > passed.start or side * (other - x) <= 0:
                break
            limit = x if direction > 0 else side * math.inf
            stop = self._first_zero(-side, other, limit, x, depth, direction, exact=True)
            if stop is None or self._rests_on_step(side, (own, x), (other, stop), depth, direction):
                break
            own = x
            other = stop
        return (own, other) if side > 0 else (other, own)

    def _rests_on_step(
        self, side: int, line: Pair, other: Pair, depth: float, direction: int
    ) -> bool:
        """Whether a line rests on a step, with the other line moving with it; both from and to."""
        x = line[0] + (line[1] - line[0]) * _ALONG
        facing = self.rests.at(other[0] + (other[1] - other[0]) * _ALONG)
        f = self.rests.profile.indenter.height(x)
        f1 = self.rests.profile.indenter.slope(x)
        rest = self.rests.rest_depth(side, x, f, f1, facing, self.rests.w(direction))
        return bool((direction * (rest - depth) >= 0).any())
