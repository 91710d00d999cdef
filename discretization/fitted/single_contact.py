"""The lines of a contact where there can be no other.

A line advances where the depth D at which it would be at rest (../surfaces) is less than the depth
d, and recedes where it is greater. Of a convex indenter D grows outwards of a line contact, so that
there is one place where it rests; at a corner D may jump past d and hold the line. About an axis D
falls from the depth of touching to its least value and grows from there on, for the shapes of
routes.UNIMODAL: where the depth is less than that of touching, the line rests in the growing part.
There D = f + l f' q - δ₀ q with q = 1/S, S(s) the stiffness beside a radius of s = a/l, and

    dD/ds = (q' / l) {[l f' + l² f'' q]/q' + l f' - δ₀}    (f', f'' by x),

in which f', f'' q and 1/q' grow with s, so that the brace changes sign once.

Beside an apex that is all but a tip, f = c |x|ⁿ with n next to 1, a line may rest 10⁻¹⁰⁰ l from it.
There it is looked for in log |x|. Nearer than doubles resolve D jumps past d at the apex itself:
the contact is that one point, P = 2kl (d - f), and holds like a wider one as long as D there, where
f' = 0, is less than d.

Conventions
-----------
The depth d, the rest depth D and the displacement u of the surface are positive down into the
layer, heights f of the profile upwards [length]; P is the force per length of a line contact, or
the force about an axis, positive where the indenter is pressed. l is the elastocapillary length,
δ₀ = √(2w/k) the critical separation.

`side` is 1 for the right line of the contact, whose contact is on its left, and -1 for the left
one; outwards is the direction `side` along x. About an axis x is the radius, and the right line is
the only one. `beside` says where the slope at x is read: 1 just outwards of the contact, -1 just
inwards, 0 or None at x itself. `Surfaces.rest_depth` is D of lines with given heights and slopes;
`past_wall` is whether lines are at the edge of the body, so that there is nothing `beside` them.

Of the scene, `opened` is the same with the work of adhesion of contacts that open. Of the indenter,
`extent` are the ends of the known profile, `walls` those of them at which the body itself ends,
`symmetric` is whether it is its mirror image about the apex, and `slope_beside(x, side)` is f' just
on the right (1) or left (-1) of x. `Surfaces.solve` is a free surface (`Free`: energy, area, and
the pulls at its lines) beside a `LinePosition`, x with the height f; it raises ValueError where
that would turn over. `bracketed` is the zero between two places at which a function differs in
sign; `bracketed_minimum` where a function with one minimum is least, and its value. FLAT is what is
rounding of dD/dx, of the size of depths over the length in which D varies; ROUNDING is 16 times
2⁻⁵², and ULPS to how many roundings a line is found. `unknown(depth, x)` is the error of a line
that reaches the end x of the known profile.

l = √(γ₁/k) is `Scene.elastocapillary_length`, δ₀ its `critical_separation`, and `surfaces_of` are
its free surfaces. A `Pair` is two places. Steps of differences are at least
`DIFFERENCES.least_ulps` roundings of a position.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import ROUNDING
from discretization.fitted.line_search import Pair
from discretization.fitted.rest_depths import DIFFERENCES, FLAT, ULPS, surfaces_of
from discretization.profile import past_wall, unknown
from discretization.roots import bracketed, bracketed_minimum
from discretization.surfaces.protocol import Free, LinePosition, LineState, Surfaces
from energy import Indenter, Scene
from energy.arrays import Array


class ApexRules(NamedTuple):
    """Lines so near to an apex that their distance from it is found by its logarithm.

    At a tenth or ten times its value each leaves the 4 or more random states and paths that read it
    as they are to 1e-9 (`touching` is not read there): `python -m tests.sensitivity
    discretization.fitted.single_contact`.

    Attributes
    ----------
    tip : float
        Least distance of a line from an apex at x = 0, in any unit of length: products of smaller
        numbers are subnormal and lose digits.
    flatter : float
        Of the slope beside the apex. It is read at the nearest place and half of the orders of
        magnitude further out: if it is less at the first by no more than this part, it does not
        fall towards 0, and the apex is a kink that nobody declared.
    rests : float
        Of the size of depths: where |D - d| is at most this, a line that was looked for by its
        distance has been found. It is above what rounding leaves in a root finder.
    narrow : float
        Of l: the width of a contact, about an axis its radius, up to which the step of a difference
        may reach beyond the apex.
    touching : float
        Of `DIFFERENCES.least_radius`: at smaller radii D is the depth of touching to rounding of
        the size of depths, whether a line rests there or not, so that |D - d| proves nothing.
    """

    tip: float = 2.0**-1000
    flatter: float = 1e-6
    rests: float = 1e-11
    narrow: float = 8 * DIFFERENCES.step
    touching: float = 2.0**-100


_APEX = ApexRules()


class LowestPoint(NamedTuple):
    """Where the lowest point of a profile is looked for.

    Attributes
    ----------
    within : float
        Of a length of the scene: a lowest point further away is where the slope of a profile that
        falls for ever has become too small for doubles.
    at_corner : float
        Of the same: a corner so near to where the slope changes its sign is the lowest point
        itself. That place is found to 4e-16 of its position: so it is up to a thousand lengths
        from x = 0.
    """

    within: float = 1e30
    at_corner: float = 1e-12


_LOWEST = LowestPoint()


# Powers of e inwards of a radius in which the least D about an axis is looked for: down to 1e-13.
# 15 or 60 changes none of 20 random states and paths (`python -m tests.sensitivity
# discretization.fitted.single_contact DEEPEST_POWER`).
DEEPEST_POWER = 30.0
# Of the size of depths: so close to the depth at which a contact is lost the surface beside it may
# turn over at once, and a state without contact is not known to exist. 1e-8 or 1e-6 changes none of
# 6 random states and paths (`python -m tests.sensitivity discretization.fitted.single_contact
# UNDECIDED`).
UNDECIDED = 1e-7

Excess = Callable[[float], float]  # D - d of a line at a position: positive where it would recede


@dataclass(frozen=True, eq=False)
class SingleContact:
    """Finds the lines of the one contact of a scene.

    Attributes
    ----------
    scene : Scene
    surfaces : Surfaces
        Its free surfaces.
    apex : float
        Where the profile is lowest and the contact begins [length].
    touch : float
        The height of the profile there: the depth at which it begins [length].
    """

    scene: Scene
    surfaces: Surfaces
    apex: float
    touch: float

    # Lines are found by f and f' themselves; others, such as `Contacts`, read samples where there
    # are any.
    profile = None

    @classmethod
    def of(cls, scene: Scene) -> SingleContact:
        """The one contact of a scene whose indenter is convex.

        Raises
        ------
        ValueError
            If the profile has no lowest point.
        """
        apex = scene.indenter.apex
        if apex is None:
            apex = lowest_point(scene.indenter, scene.elastocapillary_length)
        return cls(scene, surfaces_of(scene), apex, float(scene.indenter.height(apex)))

    @property
    def sides(self) -> tuple[int, ...]:
        """-1 for the left line and 1 for the right one; about an axis only the right one."""
        return (1,) if self.scene.axisymmetric else (-1, 1)

    def size(self, *depths: float) -> float:
        """A displacement to measure others by: the largest |depth| of these, plus δ₀ [length]."""
        return max(map(abs, depths)) + self.scene.critical_separation

    def rest_depth(self, side: Any, x: Any, beside: Any = None, work: Any = None) -> Any:
        """Depth D at which lines would rest.

        Parameters
        ----------
        side : {1, -1}, or ndarray
            1 for a line whose contact is on its left.
        x : float or ndarray
            Positions of the lines [length].
        beside : {1, -1, 0}, or ndarray, optional
            Whether D is read just outwards (1) or inwards (-1) of x, which differ at corners, or
            with the slope at x itself (0, and by default). Beyond an edge of the body D is
            infinite.
        work : float or ndarray, optional
            Work of adhesion [energy/area], if not that of a contact that closes.

        Returns
        -------
        float or ndarray
            [length].
        """
        scene = self.scene
        indenter = scene.indenter
        height = indenter.height(x)
        slope = indenter.slope(x) if beside is None else indenter.slope_beside(x, side * beside)
        w = scene.work_of_adhesion if work is None else work
        found = self.surfaces.rest_depth(side, x, height, slope, None, w)
        if beside is None or not indenter.walls:
            return found
        return np.where(past_wall(indenter, x, side, beside), np.copysign(math.inf, beside), found)

    def solve(self, side: int, x: float, depth: float) -> Free:
        """The tail of the free surface beyond the line on this side, at x [length].

        Raises
        ------
        ValueError
            If it would turn over.
        """
        line = LinePosition(x, float(self.scene.indenter.height(x)))
        left = line if side > 0 else None
        right = line if side < 0 else None
        return self.surfaces.solve(left, right, depth)

    def lines(self, depth: float) -> tuple[float, ...]:
        """Both ends of the contact at a depth [length].

        The left one is 0 about an axis. () where there is no contact: where no line rests, and
        where lines meet below the depth of touching, unless that point stands for a contact too
        narrow for doubles.
        """
        indenter = self.scene.indenter
        right = self.find(1, depth)
        if self.scene.axisymmetric:
            left = 0.0
        elif indenter.symmetric and not self.apex:
            left = -right
        else:
            left = self.find(-1, depth)
        if left == right and depth < self.touch:
            touches = self.pointed(left) and float(self.rest_depth(1, left)) < depth
        else:
            touches = left <= right  # False for nan, where no line rests
        return (left, right) if touches else ()

    def pointed(self, x: float) -> bool:
        """Whether a contact of the one point x stands for one too narrow for doubles.

        Parameters
        ----------
        x : float
            Position of a contact of one point [length].

        Returns
        -------
        bool
        """
        return x == self.apex and self.tip > 0

    @functools.cached_property
    def tip(self) -> float:
        """Least distance of a line from the apex that is distinct from 0 [length].

        It is 0 where lines get to the apex itself: at a corner, at an end of the profile, at an
        axis, and where the slope does not fall towards 0 beside the apex, as at a kink that nobody
        declared. The slope is compared at the least distance and half of the orders of magnitude
        further out, up to the radius nearer than which D is looked for by logarithms.
        """
        scene = self.scene
        indenter = scene.indenter
        apex = self.apex
        if scene.axisymmetric or apex in indenter.corners or apex in indenter.extent:
            return 0.0
        least = max(_APEX.tip, ULPS * math.ulp(apex)) if apex else _APEX.tip
        middle = max(
            least, math.sqrt(least * DIFFERENCES.least_radius * scene.elastocapillary_length)
        )
        sides = np.array(self.sides)
        near = sides * indenter.slope(apex + sides * least)
        far = sides * indenter.slope(apex + sides * middle)
        falls_to_zero = (near < (1 - _APEX.flatter) * far).all()
        return least if falls_to_zero else 0.0

    def line_states(self, lines: Sequence[float], depth: float) -> list[LineState]:
        """Evidence for the certificate, of both lines or of the one about an axis.

        Parameters
        ----------
        lines : sequence of float
            Both ends of the contact [length], 0 at an axis.
        depth : float
            [length].

        Returns
        -------
        list of LineState
            Pinned are lines at corners, and at the axis.
        """
        start, end = lines
        of_sides = lines[-len(self.sides) :]  # about an axis only the right one
        return [
            self._line_state(side, x, end - start, depth)
            for side, x in zip(self.sides, of_sides, strict=True)
        ]

    def _line_state(self, side: int, x: float, width: float, depth: float) -> LineState:
        """Evidence of one line at x, on this side of a contact of this width [length].

        It consists of the depths D at which the line would advance and recede, the size of the
        terms they consist of, and of dD/dx outwards: whether and how firmly it rests.
        """
        scene = self.scene
        point_contact = width == 0
        at_corner = x in scene.indenter.corners or (x == 0 and scene.axisymmetric)
        unresolved = point_contact and self.pointed(x)
        pinned = at_corner or unresolved

        # Where D is read: a few roundings outside and inside of a free line; at a corner exactly
        # there; beside a point that stands for a contact, where lines are just distinct from it.
        rounding = 0.0 if pinned else side * ULPS * math.ulp(x)
        outside = self._within(x + (side * self.tip if unresolved else rounding))
        inside = self._within(x - rounding)
        low, high = self._difference(x, width)
        w = scene.work_of_adhesion
        readings = [  # of D: where, on which side of that, and with which work of adhesion
            (outside, 1, w),
            (outside, 1, 0.0),
            (inside, -1, scene.opened.work_of_adhesion),
            (x, 0, w),
            (x, 0, 0.0),
            (high, 0, w),
            (low, 0, w),
        ]
        places, beside, works = map(np.array, zip(*readings, strict=True))
        found = self.rest_depth(side, places, beside, works)
        closing, without_adhesion, opening, resting, resting_bare, at_high, at_low = found.tolist()
        if point_contact:
            opening = -math.inf  # a point cannot open further

        # The terms that cancel in D - d are d, f, and what slope and adhesion add to D.
        height = float(scene.indenter.height(x))
        size = abs(depth) + abs(height) + abs(resting_bare - height) + abs(resting_bare - resting)

        rate = side * (at_high - at_low) / (high - low) if high > low else 0.0  # outwards
        stable = pinned or rate + FLAT * size / self._span(x) > 0
        sensitivity = 1 / abs(rate) if rate else math.inf
        return LineState(
            x=x,
            free=not pinned,
            closing=closing,
            bare=without_adhesion,
            opening=opening,
            size=size,
            moved=sensitivity,
            stable=stable,
        )

    def _difference(self, x: float, width: float) -> Pair:
        """Places on the left and on the right of a line at x, for dD/dx by a difference of D there.

        They are a step away, but at most half of the distance to a corner, and in a narrow contact
        to the apex. So neither is crossed. `width` is that of the contact [length].
        """
        corners = self.scene.indenter.corners
        step = max(DIFFERENCES.step * self._span(x), DIFFERENCES.least_ulps * math.ulp(x))
        if width <= _APEX.narrow * self.scene.elastocapillary_length and x != self.apex:
            step = min(step, abs(x - self.apex) / 2)
        corner_before = max((corner for corner in corners if corner < x), default=-math.inf)
        corner_after = min((corner for corner in corners if corner > x), default=math.inf)
        half_way_before = (x + corner_before) / 2
        half_way_after = (x + corner_after) / 2
        low = self._within(max(x - step, half_way_before))
        high = self._within(min(x + step, half_way_after))
        return low, high

    def _span(self, x: float) -> float:
        """The length over which D of a line at x varies: l, or about an axis its radius if less."""
        length = self.scene.elastocapillary_length
        return (
            min(max(x, DIFFERENCES.least_radius * length), length)
            if self.scene.axisymmetric
            else length
        )

    def _within(self, x: float) -> float:
        """The position x, or the end of the known profile that it is beyond."""
        start, end = self.scene.indenter.extent
        return min(max(x, start), end)

    def opening(self, lines: tuple[float, ...], depth: float) -> list[float]:
        """Forces that would open a contact without adhesion, -klg at each end, with g = d - f.

        Inside, the indenter presses where kg + γ₁f'' >= 0. As f'' >= 0, that holds where g >= 0,
        and g is least at an end. Tractions are multiplied by l, as in the certificate.

        Parameters
        ----------
        lines : tuple of float
            Both ends of the contact [length].
        depth : float
            [length].

        Returns
        -------
        list of float
            At the left and at the right end, negative where it is pressed [force/length]; [] where
            the contact adheres.
        """
        scene = self.scene
        if scene.opened.work_of_adhesion:
            return []
        f = np.asarray(scene.indenter.height(np.array(lines)), float)
        unit = scene.stiffness * scene.elastocapillary_length
        return (unit * (f - depth)).tolist()

    def penetration(self, lines: tuple[float, ...], depth: float) -> float:
        """How far the profile sticks through the surface at most.

        It does not beside a contact: the slope u' + f' of the clearance, outwards, is positive at
        the line and grows. Without contact the surface is flat, u = 0.

        Parameters
        ----------
        lines : tuple of float
            Both ends of the contact [length]; () without one.
        depth : float
            [length].

        Returns
        -------
        float
            [length]; 0 if it does not.
        """
        return 0.0 if lines else max(0.0, depth - self.touch)

    @functools.cached_property
    def lowest(self) -> tuple[float, float]:
        """The innermost place where a line may rest, and D there: at that depth contact is lost.

        In a line contact it is the apex. About an axis it is the radius of the least D, looked for
        in log r between the line at the depth of touching and the axis: D(r) falls from the depth
        of touching at r = 0 and passes it again, growing, at the line at that depth. Where this is
        at r = 0, D nowhere falls below it.

        Returns
        -------
        place, depth : float
            [length].
        """
        if not self.scene.axisymmetric:
            ahead = self.rest_depth(np.array(self.sides), self.apex, 1)
            return self.apex, min(self.touch, *ahead.tolist())
        outer = self.find(1, self.touch)
        if not outer:
            return 0.0, self.touch

        def inwards(powers: Array) -> Array:
            """D at the radii e⁻ᵗ of the outer one, for powers t (n,)."""
            return np.asarray(self.rest_depth(1, outer * np.exp(-powers)))

        depth_at_outer = float(self.rest_depth(1, outer, -1))
        power, least_depth = bracketed_minimum(inwards, 0.0, DEEPEST_POWER, enough=-math.inf)
        inner = outer * math.exp(-power)
        places = (inner, least_depth), (outer, depth_at_outer), (0.0, self.touch)
        return min(places, key=lambda place: place[1])

    def find(self, side: int, depth: float) -> float:
        """Where the line on one side rests.

        D grows outwards of the innermost place. So a line rests at the first corner just outwards
        of which D exceeds the depth, or, if D reaches the depth before that corner, where it does.
        If D exceeds the depth just outwards of the innermost place already, it rests there.

        Parameters
        ----------
        side : {1, -1}
            1 for the right line.
        depth : float
            [length].

        Returns
        -------
        float
            Position [length]; nan about an axis where it rests nowhere.

        Raises
        ------
        ValueError
            If the line leaves the known profile, or the surface beside it would turn over.
        """
        start = self.apex
        if self.scene.axisymmetric and depth < self.touch:
            start, least_depth = self.lowest
            if least_depth > depth:
                return math.nan

        @functools.cache
        def excess(x: float, beside: int | None = None) -> float:
            """D - d at x; of a corner just outwards (beside 1) or inwards (-1) of it."""
            return float(self.rest_depth(side, x, beside)) - depth

        places, depths_outwards = self._outer_corners(side, start)
        ahead = depths_outwards - depth
        tie = ROUNDING * self.size(depth, self.touch)
        holds = ahead > tie
        if holds.any():
            first = int(np.argmax(holds))
            x = float(places[first])
            inside = float(places[max(first - 1, 0)])  # where D does not exceed the depth yet
            rests_before = first > 0 and excess(x, -1) > tie
            return bracketed(excess, inside, x) if rests_before else x
        last = float(places[-1])
        if ahead[-1] >= 0:
            return last
        return self._beyond_corners(excess, side, last, depth)

    @functools.lru_cache(maxsize=4)  # noqa: B019 two sides, from the apex or the innermost place
    def _outer_corners(self, side: int, start: float) -> tuple[Array, Array]:
        """A place and the corners outwards of it (n,), and D just outwards of each of these.

        D does not depend on the depth: a path over a polygon of thousands of corners reads it once.

        side: 1 for the right line; start: the apex, or the innermost place of a line about an axis
        [length].
        """
        corners = np.asarray(self.scene.indenter.corners, float)
        outer = corners[side * corners > side * start]
        places = np.append(start, outer[::side])
        if not outer.size:
            return places, np.atleast_1d(self.rest_depth(side, start, 1))
        return places, np.asarray(self.rest_depth(side, places, 1))

    def _beyond_corners(self, excess: Excess, side: int, last: float, depth: float) -> float:
        """A line that rests beyond the last corner, or beyond the apex if there is none.

        Next to the apex the root finder may stop before D is d. Then the line is looked for again,
        by the logarithm of its distance from the apex.

        Parameters
        ----------
        excess : callable
            D - d of this line at a position.
        side : {1, -1}
            1 for the right line.
        last : float
            The last corner, or the innermost place, where D <= d just outwards [length].
        depth : float
            d [length].
        """
        found = bracketed(excess, *self._around(excess, side, last, depth))
        near = DIFFERENCES.least_radius * self.scene.elastocapillary_length
        if last != self.apex or abs(found - last) > near:
            return found
        rests = abs(excess(found)) <= _APEX.rests * self.size(depth, self.touch)
        if rests and not (self.scene.axisymmetric and found < _APEX.touching * near):
            return found
        return self._beside_apex(excess, side, found)

    def _beside_apex(self, excess: Excess, side: int, found: float) -> float:
        """A line so near to the apex that its distance is found by its logarithm.

        It is the apex if D is not less than the depth at the least distance already. It is `found`,
        the position that a search by the distance itself has given, if lines may get to the apex,
        so that there is no least distance.

        excess, side: as of `_beyond_corners`.
        """
        apex = self.apex
        tip = _APEX.tip if self.scene.axisymmetric else self.tip
        if not tip:
            return found
        if excess(apex + side * tip) >= 0:
            return apex

        def excess_by_logarithm(t: float) -> float:
            """D - d at the distance eᵗ from the apex [length]."""
            return excess(apex + side * math.exp(t))

        nearest = math.log(tip)
        furthest = math.log(DIFFERENCES.least_radius * self.scene.elastocapillary_length)
        return apex + side * math.exp(bracketed(excess_by_logarithm, nearest, furthest))

    def _around(self, excess: Excess, side: int, start: float, depth: float) -> Pair:
        """Places on both sides of a line: D <= d at the inner one, D > d at the outer one.

        They are found by going outwards from `start` by l, 4 l, 16 l, ...

        Raises
        ------
        ValueError
            If the known profile ends before the line, or the surface would turn over beside a place
            that the line would pass.
        """
        scene = self.scene
        limit = scene.indenter.extent[0 if side < 0 else 1]
        x = start
        for inside, x in _further(start, side * scene.elastocapillary_length, limit):
            if excess(x) > 0:
                return inside, x
            # The surface is pulled up by f - d, which grows outwards, and turns over at some value
            # of it; from there on D has no meaning.
            pulled_up = depth < scene.indenter.height(x)
            if scene.slopes == "finite" and pulled_up:
                self.solve(side, x, depth)  # for its error alone
        raise unknown(depth, x)


def _further(start: float, step: float, limit: float) -> Iterator[Pair]:
    """Intervals (inner end, outer end) that follow each other from a place on, up to a limit.

    Their outer ends are `step`, whose sign is the direction, 4, 16, ... times it from the place: a
    million steps away is reached in ten.
    """
    side = math.copysign(1.0, step)
    x = start
    while x != limit and math.isfinite(step):
        inside = x
        x = side * min(side * (start + step), side * limit)
        yield inside, x
        step *= 4


def lowest_point(indenter: Indenter, size: float) -> float:
    """Where a convex profile is lowest: where its slope changes sign, or its extent ends.

    Parameters
    ----------
    indenter : Indenter
    size : float
        A length of the scene, the first distance in which it is looked for.

    Returns
    -------
    float
        [length].

    Raises
    ------
    ValueError
        If the profile falls for ever.
    """
    start = min(max(0.0, indenter.extent[0]), indenter.extent[1])
    side = 1 if indenter.slope(start) < 0 else -1
    limit = indenter.extent[0 if side < 0 else 1]

    def rise(z: float) -> float:
        """The slope in the direction of the search, downhill from the start: negative there."""
        return side * float(indenter.slope(z))

    x = start
    if rise(start):
        x = next((x for _, x in _further(start, side * size, limit) if rise(x) >= 0), limit)
    if not math.isfinite(x) or abs(x - start) > _LOWEST.within * size:
        raise ValueError(f"indenter = {indenter!r} has no lowest point; give it a finite extent")
    if rise(x) > 0 and x != start:
        x = bracketed(rise, start, x)
    corners = np.asarray(indenter.corners, float)
    near = corners[np.abs(corners - x) <= _LOWEST.at_corner * size].tolist()
    # The first of equal heights counts, so a corner goes before a place found beside it.
    return min([*near, x], key=lambda z: float(indenter.height(z)))
