"""One free surface as the depth grows: its lines advance, contacts begin in it, or it closes.

The clearance v = u - g falls with the depth and with every point that comes into contact, and
where v >= 0 that moves other lines on, never back. So a surface may be taken to a larger depth at
once, in any order, if v >= 0 at the end and nothing touched ahead of a line that has passed since:
there a line without adhesion would rest, D₀(z) <= d, before the line itself came by. Else smaller
steps are tried, until the surface just touches, where a contact begins, or until lines jump at a
fixed depth: then they are followed from sample to sample.

Conventions
-----------
The depth d of the indenter, the rest depth D(x), at which a line at x would be in equilibrium, and
the displacement u of the surface are positive down into the layer; heights f of the profile count
upwards. The profile stands at g = d - f, and in contact u = g. The clearance v = u - g is negative
where the profile has penetrated the surface. All are lengths; δ₀ = √(2w/k) is
`Scene.critical_separation`.

A free surface is given by its left and right line (q, p), with -inf and inf where it has none. The
result of pressing is a flat tuple (left, right, left, right, ...) of the lines of all surfaces that
are left, in the order of x. `side` is 1 for the left line, which advances towards +x, and -1 for
the right one, which advances towards -x. Only direction 1, advancing, occurs here.

`EquilibriumFinder.advance` moves both lines to the first places where they rest at a depth, None if
they meet; its `line` moves one of them. `RestDepths.rest_depth` is D; `RestDepths.at` is a line
with the height of the profile there, None at infinity; `Resolved.beyond(a, b)` is the slice of the
samples of the profile strictly between two places.

`RestDepths.w(1)` is the work of adhesion of contacts that close, and `Scene.opened` the scene with
that of contacts that open. `Resolved.one_sided(x, side)` gives height and slope of the profile at
x, at corners on its right (1) or left (-1). TIE is what is rounding of a depth over
`RestDepths.size`. `minima` of a function given by values and slopes at samples have the places `lo`
and `hi` around each, its own place by cubics, the second derivative, the value there, and what that
may be off by. `crossings(h, lo, hi, guess, rise, enough)` finds zeros of many functions between
brackets, to |h| <= `enough`. `unknown(depth, x)` is the error of a line that reaches the end x of
the known profile.

A `Pair` is two places, (left, right).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.line_search import EquilibriumFinder, Pair
from discretization.fitted.rest_depths import TIE
from discretization.profile import unknown
from discretization.roots import crossings, minima
from discretization.surfaces.protocol import LinePosition
from energy.arrays import Array

Lines = tuple[float, ...]


class PressRules(NamedTuple):
    """When a surface that is pressed has touched, and how steps of the depth are chosen.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 7 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.fitted.pressed_surface`.

    Attributes
    ----------
    least_step : float
        Of the size of depths: a step of the depth that is no longer halved.
    touched : float
        Of the same: the penetration at which a contact has begun.
    try_again : int
        Smaller steps passed, after which a longer one is tried again.
    higher : float
        Of δ₀: samples that are higher than the lines by more do not touch the surface.
    level : float
        Of how v' varies around a minimum of v: what v' may be at the place that is found. v is off
        by the square, 1e-12 of how it varies.
    tiny : float
        A slope of which only the sign counts; it is no subnormal number.
    """

    least_step: float = 1e-9
    touched: float = 1e-9
    try_again: int = 2
    higher: float = 1 / 16
    level: float = 1e-6
    tiny: float = 1e-300


_RULES = PressRules()


# Changes of contacts at a depth at most: a profile has at most 200 000 samples, few of them tips.
MOST_CHANGES = 100_000


class Advance(NamedTuple):
    """What has become of a free surface that was pressed, up to the first event.

    Attributes
    ----------
    parts : list of pairs of float
        The left and the right line of each surface that it has become, from left to right [length]:
        one if nothing has happened, two where a contact has begun, none if it has closed.
    depth : float
        The depth that was reached [length].
    rests : bool
        Whether that is the depth to which it was to be pressed.
    """

    parts: list[Pair]
    depth: float
    rests: bool


@dataclass
class _Steps:
    """Which depth is tried next between one that was reached and one that was not.

    The clearance is followed to where it is -`touched`/2 of the size of depths, in the middle of
    the range in which a contact begins. As far as it is known at both depths, the next one is the
    zero of the straight line through both, with the Illinois rule: a value that stays is halved
    when its end stays for a second time (M. Dowell, P. Jarratt, BIT 11 (1971) 168). Else the
    interval is halved. After `try_again` steps in a row that passed, the larger depth itself is
    tried again, unless something is known to happen before it.

    Attributes
    ----------
    size, end : float
        Size of depths, and the depth that is to be reached [length].
    low, high : float
        The depth that was reached and the one that was not [length]: between them something
        happens, or a step so long is not conclusive.
    room, dip : float
        The clearances at `low`, where it is positive, and at `high`, where it is negative or nan
        where it is not known [length]; that of `low` counts from the one at which a contact begins.
        Halved by the Illinois rule.
    run : int
        How many steps in a row have passed or, if negative, have not.
    """

    size: float
    end: float
    low: float
    high: float
    room: float = 0.0
    dip: float = math.nan
    run: int = _RULES.try_again

    def passed(self, depth: float, clearance: float) -> None:
        """Record that nothing has happened up to this depth, where the clearance is this.

        It is then the lower end of the interval. Where the higher end stays for a second time, its
        value is halved.
        """
        self.room = clearance + _RULES.touched / 2 * self.size
        if self.run > 0:
            self.dip /= 2
        self.low = depth
        self.run = max(self.run, 0) + 1

    def failed(self, depth: float, clearance: float) -> None:
        """Record that something has happened before this depth, or may have.

        It is then the higher end of the interval; the clearance is nan where the lines do not say.
        Where the lower end stays for a second time, its value is halved.
        """
        if self.run < 0:
            self.room /= 2
        self.dip = clearance
        self.high = depth
        self.run = min(self.run, 0) - 1

    def following(self) -> float:
        """The depth to try next."""
        if self.low == self.high:  # the higher end has been reached: go for the whole rest
            self.high = self.end
            self.dip = math.nan
            self.run = _RULES.try_again
            return self.end
        try_again = math.isnan(self.dip) and self.run >= _RULES.try_again
        if try_again or self.high - self.low <= _RULES.least_step * self.size:
            return self.high  # a step from so near may be conclusive
        # The zero of the straight line, the middle where a clearance is not known.
        part = float(np.nan_to_num(self.room / (self.room - self.dip), nan=0.5))
        return self.low + (self.high - self.low) * part


@dataclass(frozen=True, eq=False)
class PressedSurface:
    """Moves the lines of one free surface as the indenter is pressed.

    Attributes
    ----------
    search : EquilibriumFinder
        Finds where its lines come to rest at a depth.
    """

    search: EquilibriumFinder

    def advance(self, left: float, right: float, start: float, end: float) -> Lines:
        """The lines of a free surface with those of contacts that begin in it; () if it closes.

        Parameters
        ----------
        left, right : float
            Its lines [length], infinite where there is none.
        start, end : float
            The depths at which they rest, and to which it is pressed [length].

        Returns
        -------
        tuple of float
            Two for each surface that is left, (left, right, left, right, ...) [length].

        Raises
        ------
        NotCertifiedError
            If its lines do not come to rest.
        ValueError
            If a line leaves the known profile.
        """
        # Surfaces are worked off from left to right, as the last one of `todo` comes next.
        done: list[float] = []
        todo = [(left, right, start)]
        for _ in range(MOST_CHANGES):
            if not todo:
                return tuple(done)
            found = self._pressed(*todo.pop(), end)
            if found.rests:
                done += found.parts[0]
            else:
                todo += [(*part, found.depth) for part in reversed(found.parts)]
        raise NotCertifiedError(f"the contacts at depth = {end!r} do not come to rest")

    def _pressed(self, q: float, p: float, start: float, end: float) -> Advance:
        """Take one surface to the depth `end`, or to where something happens before.

        It has passed a depth if its lines have come to rest there, nothing was overtaken, and it
        clears the indenter. It has touched where the penetration is at most `touched` of the size
        of depths. Once steps are as short as `least_step`, lines jump or meet at that depth.

        Parameters
        ----------
        q, p : float
            The left and the right line, at rest at the depth `start` [length].
        start, end : float
            Depths [length].

        Raises
        ------
        UnknownProfile, a ValueError
            If the line of a tail leaves the known profile.
        """
        size = self.search.rests.size
        steps = _Steps(size, end, low=start, high=end)
        depth = start
        for _ in range(MOST_CHANGES):
            moved = self.search.advance(q, p, depth)
            clearance = math.nan  # where lines meet, or may have come too late for a touch
            place = math.nan
            if moved and not self.overtakes(q, p, moved, steps.low, depth):
                clearance, place = self.least_clearance(moved, depth)
            if moved and clearance >= -TIE * size:
                if depth == end:
                    return Advance([moved], end, rests=True)
                steps.passed(depth, clearance)
                q, p = moved
            elif moved and clearance >= -_RULES.touched * size:
                touched = [(moved[0], place), (place, moved[1])]
                return Advance(touched, depth, rests=False)
            elif depth - steps.low <= _RULES.least_step * size:
                if moved is None and math.isinf(q - p):  # a tail whose line rests nowhere
                    edge = float(self.search.rests.profile.x[0 if math.isinf(q) else -1])
                    raise unknown(depth, edge)
                return Advance(pairs(self._creeping(q, p, depth, moved)), depth, rests=False)
            else:
                steps.failed(depth, clearance)
            depth = steps.following()
        raise NotCertifiedError(f"the contacts at depth = {end!r} do not come to rest")

    def overtakes(self, q: float, p: float, moved: Pair, low: float, high: float) -> bool:
        """Whether the surface may have touched the indenter ahead of a line that has passed since.

        It has touched at z before the line came by if D₀(z), the rest depth without adhesion, is
        not more than the depth at which the line passed z. Of the other line's places, before and
        now, the one is taken with which this is the more likely: contact lowers the depths at which
        others begin, so D of the line is greater beside the old place, and D₀ less beside the new
        one. Without adhesion the state does not depend on the path: then the criterion is whether
        the profile pulls there at the end.

        Parameters
        ----------
        q, p : float
            The lines before [length].
        moved : tuple of float
            The lines now [length].
        low, high : float
            Depths between which they have moved [length].

        Returns
        -------
        bool
        """
        left, right = moved
        return self._passes_touch(1, (q, left), (p, right), low, high) or self._passes_touch(
            -1, (p, right), (q, left), low, high
        )

    def _passes_touch(self, side: int, line: Pair, other: Pair, low: float, high: float) -> bool:
        """`overtakes` for the line on this side.

        `line` and `other` are where it and the other line of the surface move from and to.

        low, high: depths between which they have moved [length].
        """
        rests = self.search.rests
        profile = rests.profile
        own = profile.beyond(*line)
        if own.stop == own.start:
            return False
        if not rests.scene.work_of_adhesion:
            return self.search.pulls(*line, high)
        x = profile.x[own][::side]
        f = profile.f[own][::side]
        f1 = profile.slope[own][::side]
        before, now = other
        resting = rests.rest_depth(side, x, f, f1, rests.at(before), rests.w(1))
        # A line comes by a sample once it has passed all before it: at the largest of their D, and
        # no earlier than the depth from which it moves.
        comes_by = np.maximum.accumulate(np.append(low, resting))[:-1]
        touches_at = rests.surfaces.rest_depth(side, x, f, f1, rests.at(now), 0.0)  # D₀
        return bool((touches_at <= np.minimum(comes_by, high) - TIE * rests.size).any())

    def _creeping(self, q: float, p: float, depth: float, end: Pair | None) -> Lines:
        """The lines of a surface after a jump at a depth: they advance until the surface touches.

        Lines stand on samples in turn, so that a touch in between is not missed.

        Parameters
        ----------
        q, p : float
            The lines before the jump [length].
        depth : float
            d [length].
        end : tuple of float or None
            Where they rest after it if the surface does not touch, None if they meet.

        Returns
        -------
        tuple of float
            Lines of the surfaces that are left [length]: four if it has touched, with both new ones
            at the place where it has; two if not; () if it has closed.
        """
        if end == (q, p):  # nothing moves: the surface has touched a little before this depth
            place = self.least_clearance(end, depth)[1]
            return q, place, place, p
        goal = end or (p, q)
        while q < p and (q, p) != goal:
            for step in self._next_places(q, p, goal, depth):
                if step[0] >= step[1]:
                    return end or ()
                clearance, place = self.least_clearance(step, depth)
                if clearance < -TIE * self.search.rests.size:
                    return q, place, place, p
                q, p = step
        return end or ()

    def _next_places(self, q: float, p: float, goal: Pair, depth: float) -> list[Pair]:
        """Where both lines stand next, one after the other, as they jump to a goal.

        The left line moves from sample to sample as far as it does while the right one stays. If it
        does not reach its next sample, the right line does likewise; and if neither does, both go
        to their next samples, which they can only pass together.

        Parameters
        ----------
        q, p : float
            The left and the right line [length].
        goal : tuple of float
            Where both end, or (p, q) where they meet [length].
        depth : float
            d [length].

        Returns
        -------
        list of pairs of float
            Left and right lines, at least one pair [length].
        """
        profile = self.search.rests.profile
        lefts = profile.x[profile.beyond(q, goal[0])].tolist()
        lefts.append(goal[0])
        rights = profile.x[profile.beyond(p, goal[1])].tolist()[::-1]
        rights.append(goal[1])
        # An advancing line has no limit but the facing one; None: it rests nowhere before that.
        left_stop = self.search.line(1, q, -math.inf, p, depth, 1, True)
        furthest = math.inf if left_stop is None else left_stop
        steps = [(x, p) for x in lefts if q < x <= furthest]
        if steps:
            return steps
        right_stop = self.search.line(-1, p, math.inf, q, depth, 1, True)
        furthest = -math.inf if right_stop is None else right_stop
        steps = [(q, x) for x in rights if furthest <= x < p]
        return steps or [(lefts[0], rights[0])]

    def least_clearance(
        self, lines: Pair, depth: float, *, exact: bool = False
    ) -> tuple[float, float]:
        """The least of the minima of the clearance v = u - g between two lines, and where.

        The minima are those of the cubics through v and v' at samples. One that may be the least
        and negative is solved for, unless only its sign is needed and that is certain. Towards a
        line v vanishes: that is no minimum. As the surface is nowhere lower than at both lines and
        far away, samples of the profile that are higher by a part of δ₀ do not count.

        Parameters
        ----------
        lines : tuple of float
            The left and the right line, infinite where there is none [length].
        depth : float
            [length].
        exact : bool
            Whether the value itself is needed; otherwise its sign, and its place where negative.

        Returns
        -------
        clearance, place : float
            v [length], negative where the profile penetrates the surface, and x [length]; inf and
            nan if there is no minimum.
        """
        rests = self.search.rests
        height = rests.profile.indenter.height
        slope = rests.profile.indenter.slope
        left = rests.at(lines[0])
        right = rests.at(lines[1])
        samples = self._samples_near(lines, left, right, depth)
        if samples is None:
            return math.inf, math.nan
        x, f, f1 = samples

        def surface(z: Array) -> tuple[Array, Array]:
            """u and u' at places."""
            return rests.surfaces.shape(z, left, right, depth)

        u, u1 = surface(x)
        v = u - depth + f
        v1 = u1 + f1
        # Only the signs of v' at both ends matter, for whether they are minima: at a line v grows
        # from 0, which is none; an end without a line, the outermost sample, may be one.
        v1[0] = max(v1[0], _RULES.tiny) if left else -1.0
        v1[-1] = min(v1[-1], -_RULES.tiny) if right else 1.0
        lo, hi, at, bend, clearance, off = minima(x, v, v1)
        may_be_least = clearance - off <= min(0.0, (clearance + off).min(initial=0.0))
        # Solved for is what is no corner (lo < hi), and of a sign that is not certain.
        unsolved = may_be_least & (lo < hi) & (exact | (clearance + off >= 0))
        if unsolved.any():
            level = _RULES.level * float(((hi[unsolved] - lo[unsolved]) * bend[unsolved]).min())
            at[unsolved] = crossings(
                lambda z, _: surface(z)[1] + slope(z),
                lo[unsolved],
                hi[unsolved],
                at[unsolved],
                bend[unsolved],
                level,
            )
            clearance[unsolved] = surface(at[unsolved])[0] - depth
            clearance[unsolved] += height(at[unsolved])
        found = zip(clearance.tolist(), at.tolist(), strict=True)
        return min(found, default=(math.inf, math.nan))

    def _samples_near(
        self, lines: Pair, left: LinePosition | None, right: LinePosition | None, depth: float
    ) -> Array | None:
        """Samples that the surface may touch, with those beside them, and both ends.

        Parameters
        ----------
        lines : tuple of float
            The left and the right line, infinite where there is none [length].
        left, right : LinePosition or None
            The same with the heights of the profile there.
        depth : float
            d [length].

        Returns
        -------
        ndarray (3, n) or None
            x, f and f' from left to right. The first and the last column are the lines, with f' on
            the side of the surface; without a line the outermost sample a second time. None if no
            sample is low enough.
        """
        rests = self.search.rests
        profile = rests.profile
        own = profile.beyond(*lines)
        level = max([depth, *(line.f for line in (left, right) if line)])
        low = profile.f[own] <= level + _RULES.higher * rests.scene.opened.critical_separation
        if not low.any():
            return None
        low[1:] |= low[:-1]  # and the samples beside those, as the surface may touch in between
        low[:-1] |= low[1:]
        inner = np.array([profile.x[own][low], profile.f[own][low], profile.slope[own][low]])
        ends = np.where(np.isfinite(lines), lines, inner[0, [0, -1]])
        outer = np.array([ends, *profile.one_sided(ends, (1, -1))])
        return np.concatenate([outer[:, :1], inner, outer[:, 1:]], axis=1)


def pairs(lines: Sequence[float]) -> list[Pair]:
    """Lines in a row as pairs: of a surface or of a contact, as the first one is."""
    return list(zip(lines[::2], lines[1::2], strict=True))
