"""Where the two lines of a free surface come to rest at a fixed depth.

The lines q < p are those of a gap between two contacts, or one of them is at infinity: a tail.
Advancing (direction 1) they go to the first places where D >= d, receding (direction -1) to the
first where D <= d. In a gap each feels the other: they move one after the other, and close to where
they rest both are found at once by Newton's method, which is tried in every other sweep.

Conventions
-----------
The depth d of the indenter and the rest depth D(x), at which a line at x would be in equilibrium,
are positive down into the layer, heights f of the profile up, so that the displacement of a surface
in contact is d - f. All are lengths; l is the elastocapillary length.

`side` is 1 for a line whose contact is on its left, the left line q of a surface, and -1 for the
right line p. Outwards, into the free surface, is the direction `side` along x. `direction` is 1
where lines advance outwards (contacts close), -1 where they recede inwards (contacts open).

The line that is `facing` another one is at the other end of the free surface. Where lines recede,
the `limit` of one is the other line of its own contact, beyond which the contact is lost.

`Resolved.beyond(a, b)` is the slice of the samples of the profile strictly between two places.

`RestDepths` gives D: `rest_depth(side, x, f, f1, facing, w)` that of lines at x with height f and
slope f1 of the profile there, `at(x)` a place with its height, which is what `facing` is, None for
no line, and `w(direction)` the work of adhesion of contacts that close (1) or open (-1). Its `size`
is the largest of the depths that occur. `first_zero` is the first place along the profile where a
function is not negative, None if there is none; `gap_at_rest` are both lines of a gap by Newton's
method, None if that fails. TIE is what is rounding of D over `size`; `displacement_scale` is the
size of depths to which the certificate compares, and TOLERANCE what it tolerates. `walls` are the
ends of the profile at which the body itself ends.
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
# Of l: half the width of the narrowest gap. A gap opens at a corner with its lines so far on both
# sides of it, and lines of a gap closer than twice that have met. 1e-10 or 1e-8 changes none of 15
# random states (`python -m tests.sensitivity discretization.fitted.line_search MET`).
MET = 1e-9
# Of a state's depths: a pull that opens no gap. It passes the certificate, whose tolerance of the
# condition "opening" is four times as large.
PULLED = TOLERANCE / 4


class TurnRules(NamedTuple):
    """When the two lines of a gap, which move one after the other, have come to rest.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 2 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.fitted.line_search`.

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


# Parts of a step where it is read whether a line rests; half or twice as far apart they lead to the
# same states (`python -m tests.sensitivity discretization.fitted.line_search _ALONG`).
_ALONG = np.arange(1, 9) / 8


@dataclass(frozen=True, eq=False)
class EquilibriumFinder:
    """Finds where the lines of one free surface rest.

    Attributes
    ----------
    rests : RestDepths
        The rest depths D of the lines of the scene.
    """

    rests: RestDepths

    def closed(self, q: float, p: float, depth: float) -> bool:
        """Whether nothing holds open the gap between lines q and p, which then closes as a whole.

        Without adhesion a gap is only where the profile would pull at the surface in contact. With
        adhesion its lines decide, and a tail is never closed.
        """
        adheres = self.rests.scene.work_of_adhesion > 0
        return not (adheres or math.isinf(q - p) or self.pulls(q, p, depth))

    def pulls(self, one: float, other: float, depth: float) -> bool:
        """Whether the profile pulls between two positions, so that a gap there stays open.

        A gap closes at a pull clearly less than the one that opens it; with a single limit it could
        open and close for ever by rounding. The cheapest evidence comes first: bounds of the pull
        between samples, then corners, then the pull itself.

        Parameters
        ----------
        one, other : float
            Positions in either order [length].
        depth : float
            d [length].
        """
        profile = self.rests.profile
        least = _RULES.still_open * self.least_pull(depth)
        own = profile.beyond(one, other)
        least_pulls = self._bounds[0, own.start : own.stop - 1] - depth
        least_forces = least_pulls * np.diff(profile.x[own])  # of each interval, over k
        if (least_forces > least * self.rests.length).any():
            return True
        if self.opening_corners(one, other, depth).size:
            return True
        return self.pull(one, other, depth).force > least

    @functools.cached_property
    def _bounds(self) -> Array:
        """Safe bounds of the pull at depth 0 between neighbouring samples, over k [length].

        In the first row lower, in the second upper ones; column i is between the samples i and
        i + 1. At a depth d the pull is less by d.
        """
        return bounds(self.rests.scene, self.rests.profile)

    def pull(self, one: float, other: float, depth: float) -> Pull:
        """The largest pull in contact between two positions, in either order.

        Where the upper bounds of the pull stay below 0 it is not looked for: `Pull()` is none.
        """
        own = self.rests.profile.beyond(one, other)
        most = self._bounds[1, max(own.start - 1, 0) : own.stop].max(initial=-math.inf)
        if most < depth:
            return Pull()
        return pull(self.rests.scene, self.rests.profile, one, other, depth)

    def least_pull(self, depth: float) -> float:
        """The least force at which a contact that does not adhere opens, over kl [length].

        It is not 0: as the pull vanishes so does the width of the gap, and D of the lines of a
        narrow gap is the less known the narrower it is.
        """
        return PULLED * displacement_scale(self.rests.scene, depth, self.rests.size)

    def opening_corners(self, one: float, other: float, depth: float, holds: Any = 0.0) -> Array:
        """The corners between two positions at which a contact opens by itself.

        The slope falls there by more than the adhesion holds, and than the pressure does: pressed
        by kg, a gap of half-width s is kept open by a fall of 2 g s/l². No s is as small as MET/2
        of l, for which that is MET g/l. Corners within 2 MET of the ends do not count, as a gap at
        one would come next to these.

        Parameters
        ----------
        one, other : float
            Positions in either order [length].
        depth : float
            d [length].
        holds : float or ndarray (n,)
            The falls of the slope that adhesion holds, of all corners of the profile; angles with
            finite slopes.

        Returns
        -------
        ndarray (m,)
            Positions of the corners, increasing [length].
        """
        profile = self.rests.profile
        length = self.rests.length
        least_distance = 2 * MET * length
        x = profile.corners
        if not x.size:
            return x
        g = np.maximum(depth - np.asarray(profile.indenter.height(x), float), 0.0)
        falls = profile.falls(self.rests.scene.slopes) - MET * g / length
        after_first = x > min(one, other) + least_distance
        before_last = x < max(one, other) - least_distance
        return np.asarray(x[after_first & before_last & (falls > holds)])

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
            [length]. A line that rests nowhere before the other one of its contact is one rounding
            beyond that: the contact is lost.

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
        """Both lines move in turns until they rest.

        Parameters
        ----------
        q, p : float
            The left and the right line [length], infinite where there is none.
        limits : tuple of float
            How far the left and the right line may recede: the other lines of their contacts,
            (-inf, inf) where lines advance [length].
        depth : float
            d [length].
        direction : {1, -1}
            1 where they advance, -1 where they recede.

        Returns
        -------
        tuple of float or None
            [length]. None if lines that advance meet or one of them rests nowhere; a line that
            recedes and rests nowhere is beyond its limit.
        """
        least, most = limits
        for sweep in range(_RULES.most_sweeps):
            if direction > 0 and p - q <= 2 * MET * self.rests.length:
                return None
            is_gap = math.isfinite(q - p)
            if is_gap and sweep % 2 == 0:
                # Newton's method starts from the samples just before the places where both rest.
                before = self._one_after_the_other(q, p, limits, depth, direction, exact=False)
                if before is None:
                    return None
                lost = before[0] < least or before[1] > most
                at_rest = None if lost else self._nearby(before, depth, direction)
                if at_rest is not None and at_rest[0] >= least and at_rest[1] <= most:
                    return at_rest
            moved = self._one_after_the_other(q, p, limits, depth, direction, exact=True)
            if moved is None:
                return None
            new_q, new_p = moved
            lost = new_q < least or new_p > most
            # Where an equilibrium is about to disappear lines move on by roundings for ever; so
            # what counts as rounding grows with the sweeps.
            still = _RULES.still * (1 + sweep * sweep)
            rests = abs(new_q - q) <= still * abs(q) and abs(new_p - p) <= still * abs(p)
            # The line of a tail has no other one that could move it again.
            if rests or not is_gap or lost:
                return moved
            further = self._further(new_q, new_p, (new_q - q, new_p - p), depth, direction)
            within = further[0] >= least and further[1] <= most
            q, p = further if within else moved
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def _one_after_the_other(
        self, q: float, p: float, limits: Pair, depth: float, direction: int, *, exact: bool
    ) -> Pair | None:
        """The left line q moves until it rests, then the right one p beside it.

        Parameters as of `_alternated`, `exact` and what is returned as of `line`; None if one line
        rests nowhere.
        """
        new_q = self.line(1, q, limits[0], p, depth, direction, exact)
        if new_q is None:
            return None
        new_p = self.line(-1, p, limits[1], new_q, depth, direction, exact)
        return None if new_p is None else (new_q, new_p)

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
        """Where one line of a free surface comes to rest while the other one stays.

        Parameters
        ----------
        side : {1, -1}
            1 for a line whose contact is on its left.
        x : float
            Where it is [length].
        limit : float
            The other line of its contact, as far as which it may recede; not used where it advances
            [length].
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
        # An advancing line of a tail stops at the edge of the body, if the profile ends with one.
        last_sample = float(self.rests.profile.x[-1 if side > 0 else 0])
        ends_there = math.isinf(facing) and last_sample in self.rests.profile.indenter.walls
        return last_sample if ends_there else None

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
        """The first place between x and a limit at which a line rests, None if there is none.

        Parameters as of `line`, but that `limit` is where the search ends in either direction. It
        counts as a place where the line may rest only if it recedes: there an advancing line would
        meet the other one. If the place need not be exact, it is one just before it.
        """
        other = self.rests.at(facing)
        w = self.rests.w(direction)
        indenter = self.rests.profile.indenter

        def h(x: Any, f: Any = None, f1: Any = None) -> Any:
            """direction (D - d): negative where the line moves on."""
            if f is None:
                f = indenter.height(x)
                f1 = indenter.slope(x)
            return direction * (self.rests.rest_depth(side, x, f, f1, other, w) - depth)

        recedes = direction < 0
        closed = recedes and math.isfinite(limit)
        # A line that rests up to rounding of D does not recede from where it has advanced to.
        tie = TIE * self.rests.size if recedes else 0.0
        return first_zero(self.rests.profile, h, (x, limit), closed, exact, tie)

    def _nearby(self, start: Pair, depth: float, direction: int) -> Pair | None:
        """Both lines of a gap in stable equilibrium, found by Newton's method from a start.

        None if the method fails, or if a sample of the profile lies between the start and where
        they rest: lines are to stop at the first equilibrium, and there may be one before it.

        start: the left and the right line [length]; depth, direction: as of `_alternated`.
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

        Where an equilibrium has just disappeared, lines that move in turns would pass its place by
        very many small steps. Here the faster line steps on, each time `further` times as far, and
        the other line comes to rest beside it. It ends before a step that would pass a sample or
        the other line, on which the faster line would rest, or beside which the other one rests
        nowhere.

        Parameters
        ----------
        q, p : float
            The left and the right line [length].
        step : tuple of float
            How far each has just moved towards +x [length].
        depth, direction
            As of `_alternated`.

        Returns
        -------
        tuple of float
            The left and the right line [length]; q and p themselves if no step was possible.
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
            # As far as which the other line may move: to the first one, or away from it.
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
        """Whether the line on this side would rest somewhere on a step of both lines.

        `line` and `other` are where it and the facing line step from and to; both are read at the
        same parts of their steps.

        side: 1 for the left line of the surface; depth, direction: as of `_alternated`.
        """
        x = line[0] + (line[1] - line[0]) * _ALONG
        facing = self.rests.at(other[0] + (other[1] - other[0]) * _ALONG)
        f = self.rests.profile.indenter.height(x)
        f1 = self.rests.profile.indenter.slope(x)
        rest = self.rests.rest_depth(side, x, f, f1, facing, self.rests.w(direction))
        return bool((direction * (rest - depth) >= 0).any())
