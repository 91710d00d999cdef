"""Where lines come to rest, zeros of D - d: the first on a way, or those of many depths at once.

The first place on a way along the profile where a function is no longer negative: it is read at the
samples of the resolved profile, at corners on either side, until it is. Between samples a maximum
is looked for wherever one could reach 0, so that a stop is not missed next to where it disappears.

Lines of many free surfaces, each feeling the other one of its surface, by Newton's method.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from discretization.fitted.rest_depths import RestDepths, solved, stable
from discretization.profile import Resolved
from discretization.roots import bracketed, least
from energy.arrays import Array, Mask

Function = Callable[..., Any]  # of x, numbers or arrays, and f(x) and f'(x) if they are known
_BLOCK = 32  # samples read at once, four times as many each time
_LEAST = 8  # samples on a way that ends at another line, however short it is
_TOWARDS = 1 - 0.25 ** np.arange(1, 6)  # samples between the last one and that line
_ULPS = 4.0  # roundings of x: no maximum lies in between
_NEAR = 2.0  # times its distance from the next samples, that a maximum may rise above them
_MOST = 48  # steps: where an equilibrium disappears they only halve
_SHRINKS, _PATIENCE = 0.7, 2  # steps that shrink less, and how many of them are too many
_STILL = 1e-15  # of the position and l: a step that is rounding
_GUESSED = 1e-4  # of the same: so far polynomials through neighbouring lines may be off
_ROUNDED = 1e-12  # of the same: it may be, if it shrinks no more; a longer one if it has not before
_LOCAL = 1e-5  # of the same, and of the least gap: the changes of D are those of the step before
EVEN = 4e-15  # of the size of depths: D - d that is rounding, where a step need not be
_HELD = 1e-11  # of the size of depths: lines so far from rest are held until they come free
_BACK = 1e-7  # of the position and l, as little as lines may move back by rounding there


def first_zero(
    profile: Resolved, h: Function, ends: tuple[float, float], closed: bool, exact: bool, tie: float
) -> float | None:
    """First x from a start to a limit with h >= 0, or a place just before; None if there is none.

    closed: the limit is asked as well, where no other line is. tie: h may begin less by this.
    """
    (start, limit), side = ends, 1 if ends[1] > ends[0] else -1
    value = float(h(profile.past(start, side), *profile.beside(np.array(start), side)))
    if value >= -tie:
        return start
    samples, first, size = _samples(profile, start, limit, side), 0, _BLOCK
    last = np.array([start, start]), np.array([-math.inf, value])
    while first < samples.shape[1]:
        x, f, f1 = samples[:, first : first + size]
        seen = np.concatenate([last[0], x]), np.concatenate([last[1], h(x, f, f1)])
        found = _among(h, *seen, exact)
        if found is not None:
            return found
        last = seen[0][-2:], seen[1][-2:]
        first, size = first + size, 4 * size
    if not closed:
        return None
    value = float(h(profile.past(limit, -side), *profile.beside(np.array(limit), -side)))
    return _among(h, np.append(last[0], limit), np.append(last[1], value), exact)


def _samples(profile: Resolved, start: float, limit: float, side: int) -> Array:
    """x, f and f' (3, n) of the samples strictly between, in the order of the way.

    With some more where the way is short, and next to its end.
    """
    own = profile.beyond(start, limit)
    found = np.array([profile.x[own], profile.f[own], profile.slope[own]])[:, ::side]
    if not math.isfinite(limit):
        return found
    last = float(found[0, -1]) if found.size else start
    x = last + (limit - last) * _TOWARDS
    if found.shape[1] < _LEAST:
        x = np.concatenate([start + (limit - start) * np.arange(1, _LEAST) / _LEAST, x])
    x = x[(x != limit) & (x != last) & ~np.isin(x, found[0])]
    found = np.hstack([found, [x, profile.indenter.height(x), profile.indenter.slope(x)]])
    return found[:, np.argsort(side * found[0], kind="stable")]


def _among(h: Function, x: Array, values: Array, exact: bool) -> float | None:
    """The stop among samples, the first of which is negative, or a place before it."""
    stops = np.flatnonzero(values >= 0)
    end = int(stops[0]) if stops.size else values.size
    for i in _peaks(x[: end + 1], values[: end + 1]):
        before, beyond = float(x[i - 1]), float(x[i + 1])
        if abs(beyond - before) <= _ULPS * math.ulp(before):
            continue  # both sides of an edge
        top, low = least(lambda z: -h(z), before, beyond, 0.0, reach=_NEAR)
        if low <= 0:
            inside = float(x[i]) if abs(top - before) > abs(x[i] - before) else before
            return bracketed(h, inside, top) if exact else inside
    if not stops.size:
        return None
    inside, outside = float(x[end - 1]), float(x[end])
    known = {inside: float(values[end - 1]), outside: float(values[end])}  # on one side of a corner
    if inside == outside or not exact:
        return inside
    return bracketed(lambda x: known[x] if x in known else float(h(x)), inside, outside)


def _peaks(x: Array, values: Array) -> list[int]:
    """Samples not less than their neighbours, beside which a maximum could reach 0."""
    steps = np.abs(np.diff(values))
    steps[~np.isfinite(steps)] = 0.0
    middle, apart = values[1:-1], np.maximum(steps[:-1], steps[1:])
    apart[:-1] = np.maximum(apart[:-1], steps[2:])  # a start may be as high as what follows
    top = (middle >= values[:-2]) & (middle >= values[2:]) & (middle < 0)
    top &= middle + _NEAR * apart >= 0
    start, corner = np.isinf(values[:-2]), np.diff(x) == 0  # nothing lies between the sides of one
    top &= (start | ~corner[:-1]) & ~corner[1:]
    return (np.flatnonzero(top) + 1).tolist()


class Way(NamedTuple):
    """Depths (j,) on a way, and of lines (n, 2) on it which are free, between which places.

    size (n,): of positions.
    """

    depths: Array
    way: int
    free: Mask
    room: Array
    size: Array


def followed(
    rests: RestDepths, lines: Array, depths: Array, way: int, guess: Array, off: float = _GUESSED
) -> tuple[Array, Mask]:
    """Lines (n, j, 2) at depths (j,) on a way that begins at lines (n, 2), or at a single depth.

    And which surfaces (n,) are in stable equilibrium, each line at rest or held all the way, and
    move one way. guess: of the lines, even beyond a corner; off: how wrong it may be, over size.
    """
    inner, ahead = np.isfinite(lines), rests.ahead(lines, way)
    free = inner & (way * (ahead - depths[-1]) < 0)
    early = _HELD * rests.size + rests.noise(lines)[:, None]
    good = ~(free & (way * (ahead - depths[0]) > early)).any(axis=1)
    size = np.abs(np.where(inner, lines, 0.0)).sum(axis=1) + rests.length
    room = rests.between_corners(lines, way)
    x = np.where(free[:, None], np.clip(guess, *room[:, :, None]), lines[:, None])
    last, moves = off * size, free.any(axis=1)
    on = Way(depths, way, free, room, size)
    rates, found = _newton(rests, x, on, last, moves & good)
    good &= stable(rates, free) & (found | ~moves)
    with np.errstate(divide="ignore", invalid="ignore"):
        loose = rests.noise(x) / np.abs(np.diagonal(rates, axis1=2, axis2=3)).min(axis=2)
        moved = way * np.diff(np.concatenate([lines[:, None], x], axis=1), axis=1) * (1.0, -1.0)
    slack = (_BACK * size + np.nan_to_num(loose.max(axis=1), posinf=0.0))[:, None]
    good &= ~(moved < -slack[..., None]).any(axis=(1, 2))
    good &= (depths.size == 1) | ~(moved[:, 0] > slack).any(axis=1)  # the first is the start's
    held = inner & ~free
    if held.any():  # they must be so at the end, too
        left = way * (rests.ahead(x[:, -1], way) - depths[-1])
        even = EVEN * rests.size + rests.noise(x[:, -1])
        good &= ~(held & (left < -even[:, None])).any(axis=1)
    return x, good


def _newton(rests: RestDepths, x: Array, on: Way, last: Array, active: Mask) -> tuple[Array, Mask]:
    """Move the free lines of active surfaces to rest within their rooms, x (n, j, 2) in place.

    The changes of D (n, j, 2, 2), and which surfaces rest. last: the last step, or a guess's error.
    """
    rates, still, worse = np.zeros((*x.shape, 2)), np.zeros(len(x), bool), np.zeros(len(x), int)
    near = False
    for _ in range(_MOST):
        own = np.flatnonzero(active)
        if not own.size:
            break
        rates_there = rates[own] if near else None
        value, rates[own] = rests.with_rates(x[own], on.room[:, own], on.way, rates_there)
        moves, (lo, hi), size = on.free[own, None], on.room[:, own, None], on.size[own]
        off = np.where(moves, value - on.depths[:, None], 0.0)
        aim = x[own] - solved(rates[own], off, on.free[own])
        new = np.where(moves, np.clip(aim, lo, hi), x[own])
        with np.errstate(invalid="ignore"):
            now = np.where(moves, np.abs(new - x[own]), 0.0).max(axis=(1, 2))
        exact = np.abs(off) <= (EVEN * rests.size + rests.noise(x[own]))[..., None]
        past = moves & ((aim < lo) | (aim > hi)) & ~exact  # that a corner leaves no room is no rest
        stuck = (past & (new == x[own])).any(axis=(1, 2))
        wide = (x[own, :, 1] - x[own, :, 0]).min(axis=1)
        even = exact.all(axis=(1, 2)) & (now <= wide)  # a step wider than its gap is no rounding
        x[own] = new
        before = last[own]  # this step, after others, is rounding, or the next one will be
        done = even | (now <= _ROUNDED * size * 4.0 ** worse[own])
        done = (now <= _STILL * size) | ((before / 2 <= now) & done)
        done |= (now * now <= _STILL * size * before) & np.isfinite(before)
        done &= ~past.any(axis=(1, 2))
        worse[own] += now > _SHRINKS * last[own]
        lost = stuck | (~done & (worse[own] > _PATIENCE)) | ~np.isfinite(now)
        lost |= ~(new[..., 0] < new[..., 1]).all(axis=1)
        if on.depths.size == 1:  # from afar only where it is stable all the way
            lost |= ~stable(rates[own], on.free[own])
        least = np.minimum(size, (new[..., 1] - new[..., 0]).min(axis=1))
        near = bool((now <= np.minimum(_LOCAL * least, last[own] / 8)).all())
        still[own], last[own], active[own] = done & ~lost, now, ~done & ~lost
    return rates, still
