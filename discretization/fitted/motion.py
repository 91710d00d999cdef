"""Contact lines of the fitted mesh that move downhill in energy as the depth changes.

A state is the tuple of its lines from left to right, (left, right, left, right, ...); () is
detached. In contact u = d - f is prescribed, so the free surfaces (two tails, and a gap between
neighbouring contacts) do not feel each other, and each is followed by itself.

Pressed, lines advance to the first place where they rest, a contact begins where the free surface
touches the profile, and lines that meet close their gap. The clearance v = u - g falls with the
depth and with every point that comes into contact, and where v >= 0 that moves other lines on,
never back. So a surface may be taken to a larger depth at once, in any order, if v >= 0 at the end
and nothing touched ahead of a line that has passed since: there a line without adhesion would rest,
D₀(z) <= d, before the line itself came by. Else the step is halved.

Retracted, v only grows: lines recede to the first place where they rest, and contacts whose lines
meet are gone.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.fitted.clearance import Clearance
from discretization.fitted.response import Response
from discretization.fitted.stops import Stop, first_stop
from discretization.fitted.surfaces import FiniteSurfaces, SmallSurfaces, Surfaces
from discretization.profile import Resolved
from energy import Scene

Array = NDArray[np.float64]
Lines = tuple[float, ...]
Pair = tuple[float, float]
_MET = 1e-9  # of l: lines closer than that have met
_SWEEPS = 1000
_STILL = 4e-16  # of the positions: a line that moves less has come to rest
_ROUNDED = 1e-12  # of the same: a step of Newton's method that may be rounding, if it shrinks no more
_NEWTON = 12
_DIFFERENCE = 1e-6  # of the room between two lines, for the change of D
_STEP = 1e-9  # of δ₀ and the depth: a step of the depth that is no longer halved
_TOUCHED = 1e-9  # of the same: the penetration at which a contact has begun
_TIE = 1e-13  # of the same: no penetration, but rounding
_HALVINGS = 40
_MOST = 100_000


class At(NamedTuple):
    """A contact line at x and the height of the profile there."""

    x: Any
    f: Any


@dataclass(frozen=True, eq=False)
class Motion:
    """What moves lines: a profile, its free surfaces, and where they touch; size: of depths."""

    scene: Scene
    profile: Resolved
    surfaces: Surfaces
    size: float

    @functools.cached_property
    def clearance(self) -> Clearance:
        """Where free surfaces come closest to the profile."""
        return Clearance(self.profile, self.surfaces)

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, response: Response, depth: float) -> Motion:
        """With the free surfaces of a response, for depths up to this one."""
        kind = SmallSurfaces if scene.slopes == "small" else FiniteSurfaces
        size = scene.critical_separation + max(abs(depth), abs(profile.touch))
        return cls(scene, profile, kind(scene, response), size)

    def adhered(self, depth: float) -> Lines:
        """The state of the path that touches first and then moves to this depth."""
        touch = self.profile.touch
        if depth < touch and not self.scene.work_of_adhesion:
            return ()
        lines = self.first()
        return self.pressed(lines, touch, depth) if depth >= touch else self.retracted(lines, depth)

    def settled(self, lines: Lines, depth: float) -> Lines:
        """Lines that are near a state at rest, moved to it."""
        return self.pressed(self.retracted(lines, depth), depth, depth)

    def penetration(self, lines: Lines, depth: float) -> float:
        """How far the profile sticks through the free surfaces, at worst [length]."""
        return max(0.0, *(-self._least(pair, depth)[0] for pair in free(lines)))

    def neutral(self, lines: Lines, depth: float) -> bool:
        """Whether a line at an edge of the body costs nothing to move inwards."""
        if not lines or not self.scene.work_of_adhesion:
            return False
        ends = ((side, x) for side, x in ((-1, lines[0]), (1, lines[-1])) if lines[0] < lines[-1])
        return any(
            abs(self._rest(side, x, *self.profile.at(x, -side), None) - depth) <= _TIE * self.size
            for side, x in ends
            if x in self.profile.indenter.walls
        )

    def continuous(self, here: Lines, there: Lines) -> bool:
        """Whether lines move from one state to another over places where they could rest alone.

        D changes one way only on the way of every line, whether its neighbour is where it was or
        where it is now.
        """
        before, after = free(here), free(there)
        return all(
            self._monotone(1, a[0], b[0], facing) and self._monotone(-1, a[1], b[1], other)
            for a, b in zip(before, after, strict=True)
            for facing, other in ((a[1], a[0]), (b[1], b[0]))
        )

    def _monotone(self, side: int, old: float, new: float, facing: float) -> bool:
        """Whether D grows outwards between two positions of a line."""
        own = self.profile.beyond(old, new)
        if math.isinf(old) or own.stop == own.start:
            return True
        z, f, f1 = (column[own][::side] for column in (self.profile.x, self.profile.f, self.profile.slope))
        if not math.isinf(facing) and side * (facing - z[-1]) <= 0:
            return False
        rest = self._rest(side, z, f, f1, self._at(facing))
        return bool((np.diff(rest) >= 0).all())

    def first(self) -> Lines:
        """The state at first touch."""
        touch, lowest = self.profile.touch, self.profile.lowest
        return self.pressed((lowest, lowest), touch, touch)

    def pressed(self, lines: Lines, start: float, end: float) -> Lines:
        """Lines at rest at the depth `start`, taken to the depth `end` >= start.

        Where a contact begins is known to _TOUCHED only: lines that went too far for it recede.
        """
        found: list[float] = []
        for left, right in free(lines):
            found += self._pressed(left, right, start, end)
        return self._opened(self.retracted(tuple(found[1:-1]), end), end)

    def _opened(self, lines: Lines, depth: float) -> Lines:
        """Lines with the gaps that open inside contacts without a barrier.

        At a corner at which the slope falls by more than two lines hold, and without adhesion where
        the profile would pull at the surface.
        """
        for _ in range(_MOST):
            torn = [self._torn(*pair, depth) for pair in pairs(lines)]
            if all(x is None for x in torn):
                return lines
            aside = _MET * self.scene.elastocapillary_length
            parts = [
                pair if x is None else (pair[0], x - aside, x + aside, pair[1])
                for pair, x in zip(pairs(lines), torn, strict=True)
            ]
            lines = self.retracted(tuple(x for part in parts for x in part), depth)
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def _torn(self, left: float, right: float, depth: float) -> float | None:
        """Where a contact opens by itself; None if nowhere."""
        profile, aside = self.profile, 2 * _MET * self.scene.elastocapillary_length
        inside = (profile.corners > left + aside) & (profile.corners < right - aside)
        torn = np.flatnonzero(inside & (profile.falls(self.scene.slopes) > self._held))
        if torn.size:
            return float(profile.corners[torn[0]])
        if self.scene.work_of_adhesion:
            return None
        pull, place = self.pulled(left, right, depth)
        return place if pull > _TIE * self.size and left + aside < place < right - aside else None

    @functools.cached_property
    def _held(self) -> float:
        """The kink that both lines of a closed gap hold together: 2 √(2w/γ₁), or as angles."""
        half = math.sqrt(self.scene.work_of_adhesion / (2 * self.scene.gamma1))
        return 4 * half if self.scene.slopes == "small" else 4 * math.asin(half)

    def retracted(self, lines: Lines, depth: float) -> Lines:
        """Lines taken to a smaller depth."""
        while lines:
            moved: list[float] = []
            inner = (-math.inf, *lines, math.inf)
            for i, (left, right) in enumerate(free(lines)):
                least = inner[2 * i - 1] if i else -math.inf
                most = inner[2 * i + 2] if 2 * i + 2 < len(inner) else math.inf
                moved += self.apart(left, right, least, most, depth)
            held = [x for pair in pairs(moved[1:-1]) if pair[0] <= pair[1] for x in pair]
            kept = self._unpulled(tuple(held), depth)
            if len(kept) == len(lines):
                return kept
            lines = kept
        return lines

    def _pressed(self, left: float, right: float, start: float, end: float) -> Lines:
        """The lines of a free surface with those of contacts that begin in it; () if it closes."""
        done: list[float] = []
        todo = [(left, right, start, end)]
        for _ in range(_MOST):
            if not todo:
                return tuple(done)
            q, p, low, high = todo.pop()
            moved = self._together(q, p, high)
            plain = moved is not None and not self._overtakes(q, p, moved, low, high)
            least, place = self._least(moved, high) if moved and plain else (-math.inf, math.nan)
            if moved and least >= -_TIE * self.size:
                done += moved
            elif moved and least >= -_TOUCHED * self.size:
                todo += [(place, moved[1], high, high), (moved[0], place, high, high)]
            elif high - low <= _STEP * self.size:
                parts = pairs(self._creeping(q, p, high))
                todo += [(*part, high, high) for part in reversed(parts)]
            else:
                middle = self._middle(q, p, low, high, least)
                first = self._pressed(q, p, low, middle)
                todo += [(*part, middle, high) for part in reversed(pairs(first))]
        raise NotCertifiedError(f"the contacts at depth = {end!r} do not come to rest")

    def _middle(self, q: float, p: float, low: float, high: float, least: float) -> float:
        """A depth between two, at which the surface just touches if the clearance is linear."""
        clear = max(self._least((q, p), low)[0], 0.0)
        if math.isinf(least) or math.isinf(clear):
            return (low + high) / 2
        share = (clear + _TOUCHED / 2 * self.size) / (clear - least)
        return low + (high - low) * min(max(share, 0.02), 0.98)

    def _least(self, lines: Pair, depth: float) -> tuple[float, float]:
        """The least clearance between two lines, and where."""
        return self.clearance.least(self._at(lines[0]), self._at(lines[1]), depth)

    def _at(self, x: float) -> At | None:
        if math.isinf(x):
            return None
        return At(x, float(self.profile.indenter.height(x)))

    # both lines of a free surface: advancing (way 1) and receding (way -1)

    def _together(self, q: float, p: float, depth: float) -> Pair | None:
        """Both lines of a free surface advance; None: they meet."""
        if math.isinf(q) and math.isinf(p):
            return q, p
        if math.isinf(q) or math.isinf(p):
            return self._outermost(q, p, depth)
        least = 2 * _MET * self.scene.elastocapillary_length
        for sweep in range(_SWEEPS):
            if p - q <= least:
                return None
            a = self._stop(1, q, p, self._at(p), depth, 1)
            b = a and self._stop(-1, p, a.before, self._at(a.before), depth, 1)
            if a is None or b is None:
                return None
            if a.root and b.root:
                near = self._nearby((a.guess, b.guess), (a.before, b.before), depth, 1)
                if near is not None:
                    return near
            ends = a.x, b.x
            if _still(ends[0], q, sweep) and _still(ends[1], p, sweep):
                return ends
            step, (q, p) = (ends[0] - q, ends[1] - p), ends
            q, p = self._further(q, p, step, depth, 1)
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def apart(self, q: float, p: float, least: float, most: float, depth: float) -> Pair:
        """Both lines of a free surface recede, not beyond the other lines of their contacts."""
        for sweep in range(_SWEEPS):
            facing = self._at(p)
            a = q if math.isinf(q) else self._lower(1, q, least, facing, depth)
            facing = self._at(a)
            b = p if math.isinf(p) else self._lower(-1, p, most, facing, depth)
            lost = a < least or b > most
            if lost or math.isinf(q) or math.isinf(p) or (
                _still(a, q, sweep) and _still(b, p, sweep)
            ):
                return a, b
            step, (q, p) = (a - q, b - p), (a, b)
            near = self._nearby((q, p), (q, p), depth, -1)
            if near is not None and near[0] >= least and near[1] <= most:
                return near
            further = self._further(q, p, step, depth, -1)
            if further[0] >= least and further[1] <= most:
                q, p = further
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def _lower(
        self, side: int, x: float, limit: float, facing: At | None, depth: float
    ) -> float:
        """Where a receding line rests; just beyond the other line of its contact if nowhere."""
        if x == limit or self._rest(side, x, *self.profile.at(x, -side), facing) - depth <= (
            _TIE * self.size
        ):
            return x
        stop = self._stop(side, x, limit, facing, depth, -1)
        return stop.x if stop is not None else math.nextafter(limit, -side * math.inf)

    def _outermost(self, q: float, p: float, depth: float) -> Pair:
        """A tail's line advances, at most to the edge of the body."""
        side, x = (1, q) if math.isinf(p) else (-1, p)
        stop = self._stop(side, x, side * math.inf, None, depth, 1)
        if stop is not None:
            at = stop.x
        else:
            at = float(self.profile.x[-1 if side > 0 else 0])
            if at not in self.profile.indenter.walls:
                raise ValueError(
                    f"depth = {depth!r} spreads the contact to x = {at!r}, where the profile is "
                    "not known any more; give a wider profile, a smaller depth, or add a FlatPunch "
                    "whose edge ends the indenter there"
                )
        return (at, p) if side > 0 else (q, at)

    def _stop(
        self, side: int, x: float, limit: float, facing: At | None, depth: float, way: int
    ) -> Stop | None:
        """The first place on this way at which a line rests."""

        def h(x: Any, f: Any, f1: Any) -> Any:
            return way * (self._rest(side, x, f, f1, facing) - depth)

        return first_stop(self.profile, h, x, limit)

    def _rest(self, side: int, x: Any, f: Any, f1: Any, facing: At | None) -> Any:
        return self.surfaces.rest_depth(side, x, f, f1, facing, self.scene.work_of_adhesion)

    def _nearby(self, guess: Pair, start: Pair, depth: float, way: int) -> Pair | None:
        """Both lines of a gap in stable equilibrium beyond a start on this way, by Newton's method.

        None where a sample lies in between, they are not stable, or it fails.
        """
        x, last = np.array(guess), math.inf
        size = abs(start[0]) + abs(start[1]) + self.scene.elastocapillary_length
        for _ in range(_NEWTON):
            value, rate = self._rates(*x.tolist())
            crossed = rate[0, 0] * rate[1, 1] - rate[0, 1] * rate[1, 0]
            if not (rate[0, 0] > 0 > rate[1, 1] and crossed < 0):
                return None
            residual = value - depth
            step = np.array(
                [
                    rate[1, 1] * residual[0] - rate[0, 1] * residual[1],
                    rate[0, 0] * residual[1] - rate[1, 0] * residual[0],
                ]
            )
            x = x - step / crossed
            now = float(np.abs(step / crossed).max())
            if not x[0] < x[1]:
                return None
            if now <= _STILL * size or last / 2 <= now <= _ROUNDED * size:
                break
            last = now
        else:
            return None
        if (way * (x - start) * (1, -1) < -_ROUNDED * size).any():
            return None
        for old, new in zip(start, x.tolist(), strict=True):
            between = self.profile.beyond(old, new)
            if between.stop > between.start:
                return None
        return float(x[0]), float(x[1])

    def _further(self, q: float, p: float, step: Pair, depth: float, way: int) -> Pair:
        """The lines of a gap further on the same way, in growing steps of the one that moves most.

        Where an equilibrium has just disappeared they would pass its place by ever smaller ones. The
        other line is at rest meanwhile, and no step is taken that leaves the first beyond its own.
        """
        side = 1 if abs(step[0]) >= abs(step[1]) else -1
        (own, other), move = ((q, p), step[0]) if side > 0 else ((p, q), step[1])
        while move:
            x, move = own + 2 * move, 2 * move
            passed = self.profile.beyond(own, x)
            if passed.stop > passed.start or side * (other - x) <= 0:
                break
            stop = self._stop(-side, other, x if way > 0 else -side * math.inf, self._at(x), depth, way)
            if stop is None:
                break
            values = self.rest_depths(*((x, stop.x) if side > 0 else (stop.x, x)))
            if way * (values[0 if side > 0 else 1] - depth) >= 0:
                break
            own, other = x, stop.x
        return (own, other) if side > 0 else (other, own)

    def rest_depths(self, q: float, p: float) -> Array:
        """D of both lines of a gap."""
        indenter = self.profile.indenter
        (f, f1), (g, g1) = ((float(indenter.height(x)), float(indenter.slope(x))) for x in (q, p))
        one, other = self._rest(1, q, f, f1, At(p, g)), self._rest(-1, p, g, g1, At(q, f))
        return np.array([one, other])

    def _rates(self, q: float, p: float) -> tuple[Array, Array]:
        """D of both lines of a gap, and its change (rows) with the lines (columns)."""
        indenter, h = self.profile.indenter, _DIFFERENCE * (p - q)
        x = np.array([q, q + h, q - h, q, q, p, p, p, p + h, p - h])
        f, f1 = np.asarray(indenter.height(x), float), np.asarray(indenter.slope(x), float)
        one = self._rest(1, x[:5], f[:5], f1[:5], At(x[5:], f[5:]))
        other = self._rest(-1, x[5:], f[5:], f1[5:], At(x[:5], f[:5]))
        both = np.array([one, other])
        return both[:, 0], (both[:, [1, 3]] - both[:, [2, 4]]) / (2 * h)

    # what must not be passed unseen

    def _overtakes(self, q: float, p: float, moved: Pair, low: float, high: float) -> bool:
        """Whether the surface may have touched ahead of a line that has passed there since."""
        return any(
            not math.isinf(x)
            and self._touched_ahead(side, x, new, self._at(old), self._at(facing), low, high)
            for side, x, new, old, facing in ((1, q, *moved[:1], p, moved[1]), (-1, p, moved[1], q, moved[0]))
        )

    def _touched_ahead(
        self, side: int, x: float, new: float, old: At | None, facing: At | None, low: float, high: float
    ) -> bool:
        """Whether D₀ <= d somewhere on the way of a line, before the line itself came by.

        old, facing: the other line before and afterwards; each is taken where it asks for more care.
        Without adhesion the state does not depend on the way: whether the profile pulls there at the
        end, which it must not.
        """
        own = self.profile.beyond(x, new)
        if own.stop == own.start:
            return False
        z, f, f1 = (column[own][::side] for column in (self.profile.x, self.profile.f, self.profile.slope))
        if not self.scene.work_of_adhesion:
            return self.pulled(x, new, high)[0] > _TIE * self.size
        rest, w = self.surfaces.rest_depth, self.scene.work_of_adhesion
        passed = np.maximum.accumulate(np.append(low, rest(side, z, f, f1, old, w)))[:-1]
        bare = rest(side, z, f, f1, facing, 0.0)
        return bool((bare <= np.minimum(passed, high) - _TIE * self.size).any())

    def pulled(self, one: float, other: float, depth: float) -> tuple[float, float]:
        """The largest pull on the profile in contact between two positions, and where.

        Over k: -g - l² f''.

        f'' is a difference of slopes (finite slopes: of their sines).
        """
        ends = sorted((one, other))
        own = self.profile.beyond(*ends)
        x = np.concatenate([ends[:1], self.profile.x[own], ends[1:]])
        f, f1 = (
            np.concatenate([[self.profile.at(ends[0], 1)[i]], column[own], [self.profile.at(ends[1], -1)[i]]])
            for i, column in enumerate((self.profile.f, self.profile.slope))
        )
        if self.scene.slopes == "finite":
            f1 = f1 / np.sqrt(1 + f1 * f1)
        width = np.diff(x)
        bend = np.diff(f1)[width > 0] / width[width > 0]
        g = depth - np.minimum(f[1:], f[:-1])[width > 0]
        pull = -g - self.scene.elastocapillary_length**2 * bend
        if not pull.size:
            return 0.0, math.nan
        i = int(np.argmax(pull))
        return max(float(pull[i]), 0.0), float((x[:-1] + x[1:])[width > 0][i] / 2)

    def _creeping(self, q: float, p: float, depth: float) -> Lines:
        """Both lines of a free surface advance from sample to sample, until it touches."""
        end = self._together(q, p, depth)
        goal = end or (p, q)
        while (q, p) != end:
            step = (self._next(q, goal[0], 1), self._next(p, goal[1], -1))
            if step[0] >= step[1] or step == (q, p):
                return () if end is None else end
            least, place = self._least(step, depth)
            if least < -_TIE * self.size:
                return q, place, place, p
            q, p = step
        return q, p

    def _next(self, x: float, goal: float, side: int) -> float:
        """The next sample on the way of a line, or its goal."""
        if math.isinf(x) or x == goal:
            return x
        own = self.profile.beyond(x, goal)
        if own.stop == own.start:
            return goal
        return float(self.profile.x[own.start if side > 0 else own.stop - 1])

    def _unpulled(self, lines: Lines, depth: float) -> Lines:
        """Without contacts of one point that are pulled: the surface would be clear without them."""
        kept: list[float] = []
        for i, (left, right) in enumerate(pairs(lines)):
            if left == right:
                beside = (self._at(x) for x in (-math.inf, *lines, math.inf)[2 * i :: 3][:2])
                u, _ = self.surfaces.shape(np.array(left), *beside, depth)
                if u - depth + float(self.profile.indenter.height(left)) > _TIE * self.size:
                    continue
            kept += [left, right]
        return tuple(kept) if len(kept) == len(lines) else self._unpulled(tuple(kept), depth)


def _still(new: float, old: float, sweep: int) -> bool:
    """Whether a line has not moved beyond rounding.

    Where an equilibrium is about to disappear within rounding, lines tremble more, for ever: the
    more sweeps have been made, the more counts as rounding.
    """
    return abs(new - old) <= _STILL * (1 + sweep * sweep) * abs(old)


def free(lines: Sequence[float]) -> list[Pair]:
    """Both lines of every free surface, infinite where there is none."""
    return pairs((-math.inf, *lines, math.inf))


def pairs(lines: Sequence[float]) -> list[Pair]:
    """Lines two by two."""
    return list(zip(lines[::2], lines[1::2], strict=True))
