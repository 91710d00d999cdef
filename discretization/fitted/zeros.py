"""Where lines come to rest, zeros of D - d: the first one along a profile, or both of a gap.

The first place along the profile where a function is no longer negative: it is read at the
samples of the resolved profile, at corners on either side, until it is. Between samples a maximum
is looked for wherever one could reach 0, so that a zero is not missed next to where it disappears.

The lines of a gap, each of which feels the other one, are found by Newton's method.

Conventions
-----------
D is the depth at which a contact line would be in equilibrium, d the depth of the indenter, both
positive down into the layer [length]. A line advances, outwards of its contact and into the free
surface, where D < d, and recedes where D > d. `direction` is 1 where lines advance, -1 where they
recede; so `direction · (D - d)` is negative while a line moves, and not negative where it stops.

Here `side` is the sense of the search along x: 1 towards larger x, -1 towards smaller x. The lines
of a gap are an array (2,): the left line, whose contact is on its left and which advances towards
+x, and the right one, which advances towards -x; `SIDES` is (1, -1), their directions of advance.

`Resolved` is the profile with samples between which nothing is missed; a corner stands twice among
them, first with the slope on its left. Its `one_sided(x, side)` gives height and slope, at a corner
those on the right (1) or on the left (-1); `past(x, side)` moves a place at the edge of a pattern
of adhesion by one rounding to that side. `RestDepths` gives D of lines, `ahead` just ahead of them
in the direction in which they move; `noise` is what D may be off by; `size` is that of depths.

`Resolved.beyond(a, b)` is the slice of the samples strictly between two places.
`RestDepths.with_rates` are D of the lines and its derivatives, `between_corners` the places between
which lines pass no corner, and `solved` the step that makes D - d vanish, by the matrix of these
derivatives. `bracketed` is the zero between two places at which a function differs in sign;
`bracketed_minimum` is where a function is least between two places, and its value. ULPS is to how
many roundings of its position a line is found.

A `Step` of Newton's method says whether lines still move (MOVES), rest (RESTS), or the method fails
(FAILS); then lines move one after the other (line_search.py).
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.fitted.rest_depths import SIDES, ULPS, RestDepths, solved, stable
from discretization.profile import Resolved
from discretization.roots import bracketed, bracketed_minimum
from energy.arrays import Array, Mask

# h(x, f, f1) or h(x): values at places x, numbers or arrays; with the height f and the slope f1 of
# the profile there where they are known, as at a corner; otherwise h reads them itself.
Function = Callable[..., Any]


class SearchRules(NamedTuple):
    """How the first zero along a profile is searched.

    Halved or doubled, each leaves the 10 or more random states and paths that read it as they are
    to 1e-9: `python -m tests.sensitivity discretization.fitted.zeros`.

    Attributes
    ----------
    block : int
        Samples read at once, four times as many each time.
    least_samples : int
        Samples at least up to another line, however near it is.
    may_rise : float
        Times what a value differs from the next samples, that a maximum may rise above it: twice
        what a parabola through three samples rises.
    """

    block: int = 32
    least_samples: int = 8
    may_rise: float = 2.0


_SEARCH = SearchRules()


# Samples between the last one of the profile and that line, as parts of what is left: D grows
# without bounds towards a line that is met. Each part is a quarter of the last: half or twice as
# large ones change no result (`python -m tests.sensitivity discretization.fitted.zeros _TOWARDS`).
_TOWARDS = 1 - 0.25 ** np.arange(1, 6)


class NewtonRules(NamedTuple):
    """Newton's method for both lines of a gap; sizes are those of positions: the positions and l.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 5 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.fitted.zeros`.

    Attributes
    ----------
    most_steps : int
        Steps at most: where an equilibrium disappears they only halve.
    shrinks : float
        Of the last step: one that is longer shrinks too little. Newton's steps shrink by more next
        to a zero, and halve next to a double one.
    patience : int
        Steps that shrink too little before the method fails. Then lines move one after the other
        instead: no result depends on it.
    still : float
        Of the size, five roundings: a step that is rounding.
    rounded : float
        Of the size: a step that may be rounding, if steps shrink no more.
    local : float
        Of the size, and of the gap: after such a step the rates of D are kept, as they have
        changed by about as small a part, by which the next, smaller step is off.
    kept : float
        Of the last step: after one that is no longer the rates are kept, so that the method still
        converges as fast.
    lenient : float
        Of `rounded`: by so many times more counts for each step that has shrunk too little.
    even : float
        Of the size of depths, 18 roundings: D - d that is rounding, where a step need not be.
    back : float
        Of the size: how far lines may move back by rounding, above √ε = 1.5e-8, which is what
        rounding leaves of a place where D is least.
    """

    most_steps: int = 48
    shrinks: float = 0.7
    patience: int = 2
    still: float = 1e-15
    rounded: float = 1e-12
    local: float = 1e-5
    kept: float = 1 / 8
    lenient: float = 4.0
    even: float = 4e-15
    back: float = 1e-7


_NEWTON = NewtonRules()


class Samples(NamedTuple):
    """Places in the order in which the search passes them, corners twice, and the function there.

    Attributes
    ----------
    x, values : ndarray (n,)
        Positions [length], and the function there.
    """

    x: Array
    values: Array

    def followed_by(self, x: Any, values: Any) -> Samples:
        """These samples and the ones that are passed after them."""
        return Samples(np.append(self.x, x), np.append(self.values, values))


def first_zero(
    profile: Resolved, h: Function, ends: tuple[float, float], closed: bool, exact: bool, tie: float
) -> float | None:
    """The first place along a profile at which a function is not negative.

    Parameters
    ----------
    profile : Resolved
    h : callable
        h(x, f, f1): its values at places with these heights and slopes of the profile, which h(x)
        reads itself.
    ends : tuple of float
        Start and limit of the search, in this order, which gives its sense [length]. The start is
        finite; the limit may be infinite.
    closed : bool
        Whether the limit itself is searched, too; it is not where another line is.
    exact : bool
        Whether the zero itself is needed; otherwise it is a place just before it.
    tie : float
        What h may be less than 0 by at the start, where it counts as 0 all the same.

    Returns
    -------
    float or None
        [length], None if there is none.
    """
    start, limit = ends
    side = 1 if limit > start else -1
    # The start is read on the side that is searched, the limit on the side it is reached from.
    value = float(h(profile.past(start, side), *profile.one_sided(np.array(start), side)))
    if value >= -tie:
        return start
    samples = _samples(profile, start, limit, side)
    # The first entry is no sample: it says that the start is one, see `_peaks`.
    last_read = Samples(np.array([start, start]), np.array([-math.inf, value]))
    first = 0
    size = _SEARCH.block
    while first < samples.shape[1]:
        x, f, f1 = samples[:, first : first + size]
        block = last_read.followed_by(x, h(x, f, f1))
        found = _among(h, block, exact)
        if found is not None:
            return found
        last_read = Samples(block.x[-2:], block.values[-2:])
        first += size
        size *= 4
    if not closed:
        return None
    value = float(h(profile.past(limit, -side), *profile.one_sided(np.array(limit), -side)))
    return _among(h, last_read.followed_by(limit, value), exact)


def _samples(profile: Resolved, start: float, limit: float, side: int) -> Array:
    """x, f and f' (3, n) of places strictly between, in the order in which they are passed.

    They are the samples of the profile. Where the limit is finite, another line may be there,
    beside which D varies more than the profile does: there are further places between the last
    sample and the limit, ever closer to it, and evenly spaced ones where the samples are few.

    Parameters
    ----------
    profile : Resolved
    start, limit : float
        Ends of the search [length].
    side : {1, -1}
        1 where it goes towards larger x.
    """
    own = profile.beyond(start, limit)
    found = np.array([profile.x[own], profile.f[own], profile.slope[own]])[:, ::side]
    if not math.isfinite(limit):
        return found
    last = float(found[0, -1]) if found.size else start
    x = last + (limit - last) * _TOWARDS
    if found.shape[1] < _SEARCH.least_samples:
        evenly = (
            start + (limit - start) * np.arange(1, _SEARCH.least_samples) / _SEARCH.least_samples
        )
        x = np.concatenate([evenly, x])
    x = x[(x != limit) & (x != last) & ~np.isin(x, found[0])]
    more = np.array([x, profile.indenter.height(x), profile.indenter.slope(x)])
    found = np.hstack([found, more])
    return found[:, np.argsort(side * found[0], kind="stable")]


def _among(h: Function, samples: Samples, exact: bool) -> float | None:
    """The first zero among samples, or a place just before it; None if h does not reach 0.

    h is negative at the first sample. It reaches 0 between two samples of different signs, or
    before them next to a sample that is higher than its neighbours.
    """
    x, values = samples
    not_negative = np.flatnonzero(values >= 0)
    end = int(not_negative[0]) if not_negative.size else values.size
    for i in _peaks(x[: end + 1], values[: end + 1]):
        found = _beside_peak(h, x[i - 1 : i + 2].tolist(), exact)
        if found is not None:
            return found
    if not not_negative.size:
        return None
    inside, outside = x[end - 1 : end + 1].tolist()
    if inside == outside or not exact:  # between both sides of a corner lies no other place
        return inside
    # At a corner the samples have h on the side of this interval, which h(x) may not have.
    known = {inside: float(values[end - 1]), outside: float(values[end])}
    return bracketed(lambda z: known[z] if z in known else float(h(z)), inside, outside)


def _beside_peak(h: Function, places: list[float], exact: bool) -> float | None:
    """The zero around a sample at which h is higher than beside it; None if h stays negative.

    `places` are three neighbouring samples in the order in which they are passed, the highest of
    them the middle one. Its zero is the one before the maximum, at which the search comes by first.
    """
    before, middle, beyond = places
    # Between samples on both sides of an edge of a pattern lies no maximum.
    if abs(beyond - before) <= ULPS * math.ulp(before):
        return None
    top, lowest = bracketed_minimum(lambda z: -h(z), before, beyond, 0.0, reach=_SEARCH.may_rise)
    if lowest > 0:
        return None
    # h is negative at all three places, so that the zero lies between the last of them before the
    # top and the top.
    inside = middle if abs(top - before) > abs(middle - before) else before
    return bracketed(h, inside, top) if exact else inside


def _peaks(x: Array, values: Array) -> list[int]:
    """Numbers of samples not less than their neighbours, beside which a maximum could reach 0.

    It could where the value at the sample, raised by `may_rise` times the change to the next ones,
    is not negative. Before the start of the search the value is -∞. The start may be as high as the
    sample after it, with the maximum between them; so the change after that one counts, too.

    Parameters
    ----------
    x, values : ndarray (n,)
        Places in the order in which they are passed, and values there.

    Returns
    -------
    list of int
        Between 1 and n - 2: a sample with both neighbours.
    """
    steps = np.abs(np.diff(values))
    steps[~np.isfinite(steps)] = 0.0
    # The largest change of the two intervals at each inner sample, and of the one after these.
    change = np.maximum(steps[:-1], steps[1:])
    change[:-1] = np.maximum(change[:-1], steps[2:])
    before = values[:-2]
    middle = values[1:-1]
    after = values[2:]
    reaches_zero = (middle < 0) & (middle + _SEARCH.may_rise * change >= 0)
    top = (middle >= before) & (middle >= after) & reaches_zero
    # Of the two samples at a corner neither is a top: nothing lies between them, and towards the
    # other interval h continues from a value of its own.
    is_start = np.isinf(before)
    corner = np.diff(x) == 0
    top &= (is_start | ~corner[:-1]) & ~corner[1:]
    return (np.flatnonzero(top) + 1).tolist()


def gap_at_rest(rests: RestDepths, lines: Array, depth: float, direction: int) -> Array | None:
    """Both lines of a gap in stable equilibrium, by Newton's method from where they are.

    Lines that need not move stay, and those that move do not pass a corner.

    Parameters
    ----------
    rests : RestDepths
    lines : ndarray (2,)
        Where the left and the right line are [length].
    depth : float
        d, at which they are to rest [length].
    direction : {1, -1}
        1 where lines advance, -1 where they recede.

    Returns
    -------
    ndarray (2,) or None
        [length]. None if the method fails, the lines are not stable, one of them moves back by more
        than rounding, or one that has stayed would have to move in the end.
    """
    moves = direction * (rests.ahead(lines[None], direction)[0] - depth) < 0
    if not moves.any():
        return lines
    newton = _GapNewton.of(rests, lines, depth, direction, moves)
    outcome = Step.MOVES
    for _ in range(_NEWTON.most_steps):
        outcome = newton.step()
        if outcome is not Step.MOVES:
            break
    if outcome is not Step.RESTS:
        return None
    x = newton.x
    noise = float(rests.noise(x[None])[0])

    # How far a line may move since D is off by `noise`; one at which D is flat says nothing.
    with np.errstate(divide="ignore", invalid="ignore"):
        off_by_noise = noise / np.abs(np.diagonal(newton.rates)).min()
    back = direction * (lines - x) * SIDES  # how far each has moved against the direction
    if (back > _NEWTON.back * newton.size + np.nan_to_num(off_by_noise, posinf=0.0)).any():
        return None
    # A line that has stayed rests beside the other one's new place only if D >= d there, too (or
    # D <= d where lines recede).
    missing = direction * (depth - rests.ahead(x[None], direction)[0])
    if (~moves & (missing > _NEWTON.even * rests.size + noise)).any():
        return None
    return x


class Step(enum.Enum):
    """What a step of Newton's method has led to."""

    MOVES = "the lines still move"
    RESTS = "they rest: the step is rounding, or the next one will be"
    FAILS = "they meet, are stopped by a corner, are not stable, or steps do not shrink"


@dataclass(eq=False)
class _GapNewton:
    """Newton's method for the free lines of a gap.

    Attributes
    ----------
    rests : RestDepths
        Gives D of both lines and its derivatives.
    depth : float
        d, the depth at which they are to rest [length].
    direction : {1, -1}
        1 where lines advance, -1 where they recede.
    free : ndarray of bool (2,)
        Which lines move.
    room : ndarray (2, 2)
        Between which places the lines move without passing a corner: in the first row the least
        places of both, in the second one the largest [length].
    size : float
        Of positions, of which their rounding is a part: both distances from 0, and l [length].
    x : ndarray (2,)
        Where the lines are [length].
    rates : ndarray (2, 2)
        Derivatives of D of the left and the right line (rows) by both positions (columns).
    last : float
        The last step, the larger one of both lines; inf before the first [length].
    slow : int
        How many steps have shrunk too little.
    near : bool
        Whether the rates may be kept for the next step, since the lines hardly moved.
    """

    rests: RestDepths
    depth: float
    direction: int
    free: Mask
    room: Array
    size: float
    x: Array
    rates: Array
    last: float = math.inf
    slow: int = 0
    near: bool = False

    @classmethod
    def of(
        cls, rests: RestDepths, lines: Array, depth: float, direction: int, free: Mask
    ) -> _GapNewton:
        """The method before its first step from these lines, each moved into its room."""
        room = rests.between_corners(lines[None], direction)[:, 0]
        x = np.where(free, np.clip(lines, *room), lines)
        size = float(np.abs(lines).sum() + rests.length)
        return cls(rests, depth, direction, free, room, size, x, np.zeros((2, 2)))

    def step(self) -> Step:
        """One step of both lines, at most to the ends of their room.

        It fails if the lines meet, are not stable, would pass a corner at which they already are,
        or if too many steps have shrunk too little.
        """
        excess = np.where(self.free, self._read() - self.depth, 0.0)  # D - d
        target = self.x - solved(self.rates[None], excess[None], self.free[None])[0]
        new = np.where(self.free, np.clip(target, *self.room), self.x)
        with np.errstate(invalid="ignore"):
            step = float(np.where(self.free, np.abs(new - self.x), 0.0).max())

        # A line that would pass a corner does not rest there, unless D - d is rounding.
        noise = self.rests.noise(self.x[None])[0]
        is_exact = np.abs(excess) <= _NEWTON.even * self.rests.size + noise
        beyond_room = (target < self.room[0]) | (target > self.room[1])
        passes_corner = self.free & beyond_room & ~is_exact
        is_stuck = (passes_corner & (new == self.x)).any()

        is_rounding = bool(is_exact.all()) and step <= self.x[1] - self.x[0]
        rests = self._converged(step, is_rounding=is_rounding) and not passes_corner.any()
        self.slow += step > _NEWTON.shrinks * self.last
        is_too_slow = not rests and self.slow > _NEWTON.patience
        fails = is_stuck or is_too_slow or not math.isfinite(step) or not new[0] < new[1]
        if not fails:
            # Lines that pass places where they are not stable have passed another equilibrium.
            fails = not stable(self.rates[None], self.free[None])[0]

        width = float(new[1] - new[0])
        # Rates are kept after a step that is small, and so much less than the one before that the
        # method converges without new ones.
        self.near = step <= min(_NEWTON.local * min(self.size, width), _NEWTON.kept * self.last)
        self.last = step
        self.x = new
        if fails:
            return Step.FAILS
        return Step.RESTS if rests else Step.MOVES

    def _read(self) -> Array:
        """D of both lines (2,) [length]; sets `rates` as well, unless the last ones are kept."""
        lines = self.x[None]
        if self.near:
            return self.rests.depths(lines, self.direction)[0]
        depths, rates = self.rests.with_rates(lines, self.room[:, None], self.direction)
        self.rates = rates[0]
        return depths[0]

    def _converged(self, step: float, *, is_rounding: bool) -> bool:
        """Whether this step, after others, is rounding, or the next one will be.

        That is so if the step is at most `still`; if it may be rounding, and is at least half of
        the last one, so that steps shrink no more; or if step²/(last step), which is above the next
        step of a method that converges quadratically, is at most `still`. Every step that has
        shrunk too little makes four times as much count as what may be rounding.

        Parameters
        ----------
        step : float
            The larger one of both lines [length].
        is_rounding : bool
            Whether D - d of both lines is rounding, and the step not wider than the gap.

        Returns
        -------
        bool
        """
        if step <= _NEWTON.still * self.size:
            return True
        rounded = _NEWTON.rounded * self.size * _NEWTON.lenient**self.slow
        small = is_rounding or step <= rounded
        if small and self.last / 2 <= step:
            return True
        return math.isfinite(self.last) and step * step <= _NEWTON.still * self.size * self.last
