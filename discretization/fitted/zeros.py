"""Where lines come to rest, zeros of D - d: the first one along a profile, or both of a gap.

The first place along the profile where a function is no longer negative: it is read at the
samples of the resolved profile, at corners on either side, until it is. Between samples a maximum
is looked for wherever one could reach 0, so that a stop is not missed next to where it disappears.

The lines of a gap, each of which feels the other one, are found by Newton's method.
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

Function = Callable[..., Any]  # of x, numbers or arrays, and f(x) and f'(x) if they are known


class SearchRules(NamedTuple):
    """How the first zero along a profile is searched.

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
# without bounds towards a line that is met.
_TOWARDS = 1 - 0.25 ** np.arange(1, 6)


class NewtonRules(NamedTuple):
    """Newton's method for both lines of a gap; sizes are those of positions: the positions and l.

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
    even: float = 4e-15
    back: float = 1e-7


_NEWTON = NewtonRules()


class Samples(NamedTuple):
    """Places (n,) in the order in which they are passed, corners twice, and the function there.

    Attributes
    ----------
    x, values : ndarray (n,)
        Positions [length], and the function there.
    """

    x: Array
    values: Array

    def followed_by(self, x: Any, values: Any) -> Samples:
        """These and further ones."""
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
        Start and limit of the search, in this order [length].
    closed : bool
        Whether the limit itself is searched, too; it is not where another line is.
    exact : bool
        Whether the zero itself is needed; otherwise it is a place just before it.
    tie : float
        What h may be less than 0 by at the start.

    Returns
    -------
    float or None
        [length], None if there is none.
    """
    start, limit = ends
    side = 1 if limit > start else -1
    value = float(h(profile.past(start, side), *profile.one_sided(np.array(start), side)))
    if value >= -tie:
        return start
    samples = _samples(profile, start, limit, side)
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
    """x, f and f' (3, n) of the samples strictly between, in the order in which they are passed.

    There are some more where these are few, and next to the limit.
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
    """The stop among samples, the first of which is negative, or a place before it."""
    x, values = samples
    stops = np.flatnonzero(values >= 0)
    end = int(stops[0]) if stops.size else values.size
    for i in _peaks(x[: end + 1], values[: end + 1]):
        found = _beside_peak(h, x[i - 1 : i + 2].tolist(), exact)
        if found is not None:
            return found
    if not stops.size:
        return None
    inside, outside = x[end - 1 : end + 1].tolist()
    if inside == outside or not exact:
        return inside
    # at a corner h is known on the side that belongs to this interval
    known = {inside: float(values[end - 1]), outside: float(values[end])}
    return bracketed(lambda z: known[z] if z in known else float(h(z)), inside, outside)


def _beside_peak(h: Function, places: list[float], exact: bool) -> float | None:
    """The stop around a sample that is higher than both others, if h reaches 0 there."""
    before, middle, beyond = places
    # Between samples on both sides of an edge of a pattern lies no maximum.
    if abs(beyond - before) <= ULPS * math.ulp(before):
        return None
    top, lowest = bracketed_minimum(lambda z: -h(z), before, beyond, 0.0, reach=_SEARCH.may_rise)
    if lowest > 0:
        return None
    inside = middle if abs(top - before) > abs(middle - before) else before
    return bracketed(h, inside, top) if exact else inside


def _peaks(x: Array, values: Array) -> list[int]:
    """Numbers of samples not less than their neighbours, beside which a maximum could reach 0.

    It could where the value at the sample, raised by `may_rise` times the change to the next ones,
    is not negative. The first sample is a start, before which the value is -∞; it may be as high as
    the second one, so that the change after that counts, too.
    """
    steps = np.abs(np.diff(values))
    steps[~np.isfinite(steps)] = 0.0
    change = np.maximum(steps[:-1], steps[1:])
    change[:-1] = np.maximum(change[:-1], steps[2:])
    before = values[:-2]
    middle = values[1:-1]
    after = values[2:]
    reaches_zero = (middle < 0) & (middle + _SEARCH.may_rise * change >= 0)
    top = (middle >= before) & (middle >= after) & reaches_zero
    is_start = np.isinf(before)
    corner = np.diff(x) == 0  # nothing lies between its two sides
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
        [length].
    direction : {1, -1}
        1 where lines advance, -1 where they recede.

    Returns
    -------
    ndarray (2,) or None
        [length]. None if the method fails, the lines are not stable, one of them moves back by more
        than rounding, or one that has stayed would have to move in the end.
    """
    free = direction * (rests.ahead(lines[None], direction)[0] - depth) < 0
    if not free.any():
        return lines
    newton = _GapNewton.of(rests, lines, depth, direction, free)
    outcome = Step.MOVES
    for _ in range(_NEWTON.most_steps):
        outcome = newton.step()
        if outcome is not Step.MOVES:
            break
    if outcome is not Step.RESTS:
        return None
    x = newton.x
    noise = float(rests.noise(x[None])[0])

    with np.errstate(divide="ignore", invalid="ignore"):
        uncertain = noise / np.abs(np.diagonal(newton.rates)).min()
    back = direction * (lines - x) * SIDES
    if (back > _NEWTON.back * newton.size + np.nan_to_num(uncertain, posinf=0.0)).any():
        return None
    missing = direction * (depth - rests.ahead(x[None], direction)[0])
    if (~free & (missing > _NEWTON.even * rests.size + noise)).any():
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
        What knows D.
    depth : float
        The depth at which they are to rest [length].
    direction : {1, -1}
        1 where lines advance, -1 where they recede.
    free : ndarray of bool (2,)
        Which lines move.
    room : ndarray (2, 2)
        Between which places the lines move: the least ones, and the largest ones.
    size : float
        Of positions [length].
    x : ndarray (2,)
        Where the lines are.
    rates : ndarray (2, 2)
        Changes of D of both lines with both.
    last : float
        The last step.
    slow : int
        How many steps have shrunk too little.
    near : bool
        Whether D changes with the lines as it did at the step before.
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
        """From these lines on."""
        room = rests.between_corners(lines[None], direction)[:, 0]
        x = np.where(free, np.clip(lines, *room), lines)
        size = float(np.abs(lines).sum() + rests.length)
        return cls(rests, depth, direction, free, room, size, x, np.zeros((2, 2)))

    def step(self) -> Step:
        """One step of both lines.

        It fails if the lines meet, are not stable, want to pass a corner at which they already
        are, or if too many steps have shrunk too little.
        """
        excess = np.where(self.free, self._read() - self.depth, 0.0)
        target = self.x - solved(self.rates[None], excess[None], self.free[None])[0]
        new = np.where(self.free, np.clip(target, *self.room), self.x)
        with np.errstate(invalid="ignore"):
            step = float(np.where(self.free, np.abs(new - self.x), 0.0).max())

        # A line that would pass a corner does not rest there, unless its D is off by rounding.
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
        if not fails:  # only where lines are stable at every step do they lead to this equilibrium
            fails = not stable(self.rates[None], self.free[None])[0]

        width = float(new[1] - new[0])
        self.near = step <= min(_NEWTON.local * min(self.size, width), self.last / 8)
        self.last = step
        self.x = new
        if fails:
            return Step.FAILS
        return Step.RESTS if rests else Step.MOVES

    def _read(self) -> Array:
        """D of both lines; its changes are read, too, where they may have changed."""
        lines = self.x[None]
        if self.near:
            return self.rests.depths(lines, self.direction)[0]
        depths, rates = self.rests.with_rates(lines, self.room[:, None], self.direction)
        self.rates = rates[0]
        return depths[0]

    def _converged(self, step: float, *, is_rounding: bool) -> bool:
        """Whether this step, after others, is rounding, or the next one will be.

        That is so if the step is at most `still`; if it may be rounding, and is more than half of
        the last one, so that steps shrink no more; or if step²/(last step), which is the next step
        of a method that converges quadratically, is at most `still`.

        Parameters
        ----------
        step : float
            [length].
        is_rounding : bool
            Whether D - d of both lines is, and the step not wider than the gap.

        Returns
        -------
        bool
        """
        if step <= _NEWTON.still * self.size:
            return True
        small = is_rounding or step <= _NEWTON.rounded * self.size * 4.0**self.slow
        if small and self.last / 2 <= step:
            return True
        return math.isfinite(self.last) and step * step <= _NEWTON.still * self.size * self.last
