"""One free surface as the depth grows: its lines advance, contacts begin in it, or it closes.

The clearance v = u - g falls with the depth and with every point that comes into contact, and
where v >= 0 that moves other lines on, never back. So a surface may be taken to a larger depth at
once, in any order, if v >= 0 at the end and nothing touched ahead of a line that has passed since:
there a line without adhesion would rest, D₀(z) <= d, before the line itself came by. Else smaller
steps are tried, until the surface just touches, where a contact begins, or until lines jump at a
fixed depth: then they are followed from sample to sample.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.line_search import LineSearch, Pair
from discretization.fitted.rest_depths import TIE
from discretization.profile import unknown
from discretization.roots import crossings, minima

Lines = tuple[float, ...]
_STEP = 1e-9  # of δ₀ and the depth: a step of the depth that is no longer halved
_TOUCHED = 1e-9  # of the same: the penetration at which a contact has begun
_AGAIN = 2  # smaller steps passed, after which a longer one is tried again
_UNKNOWN = math.nan, math.nan  # the least clearance, and where, of a step that does not tell
_MOST = 100_000  # changes on one way, as in motion.py
_HIGHER = 1 / 16  # of δ₀
_TINY = 1e-300  # more than 0
_LEVEL = 1e-6  # of how v' varies around a minimum of v: v' there


@dataclass(frozen=True, eq=False)
class FreePart:
    """Free surfaces that are pressed."""

    search: LineSearch

    def advance(self, left: float, right: float, start: float, end: float) -> Lines:
        """The lines of a free surface with those of contacts that begin in it; () if it closes."""
        done, todo = list[float](), [(left, right, start)]
        for _ in range(_MOST):
            if not todo:
                return tuple(done)
            parts, depth, rest = self._parts(*todo.pop(), end)
            if rest:
                done += parts[0]
            else:
                todo += [(*part, depth) for part in reversed(parts)]
        raise NotCertifiedError(f"the contacts at depth = {end!r} do not come to rest")

    def _parts(self, q: float, p: float, low: float, end: float) -> tuple[list[Pair], float, bool]:
        """Where the lines of a surface are at the end, True; else what it falls into at what depth.

        At the depth `high` something has happened since `low`, or a step so long does not tell;
        first `low` itself is asked. run: how many steps in a row passed or, if negative, not; room,
        dip: clearances there, for the Illinois method (M. Dowell, P. Jarratt, BIT 11 (1971) 168).
        """
        size, depth, high, room, dip, run = self.search.rests.size, low, end, 0.0, math.nan, _AGAIN
        for _ in range(_MOST):
            moved = self.search.advance(q, p, depth)
            plain = moved is not None and not self.overtakes(q, p, moved, low, depth)
            clear, place = self.least(moved, depth) if moved and plain else _UNKNOWN
            if moved and clear >= -TIE * size:
                if depth == end:
                    return [moved], end, True
                room, dip = clear + _TOUCHED / 2 * size, dip / 2 if run > 0 else dip
                (q, p), low, run = moved, depth, max(run, 0) + 1
            elif moved and clear >= -_TOUCHED * size:
                return [(moved[0], place), (place, moved[1])], depth, False
            elif depth - low <= _STEP * size:
                if moved is None and math.isinf(q - p):
                    edge = float(self.search.rests.profile.x[0 if math.isinf(q) else -1])
                    raise unknown(depth, edge)
                return pairs(self._creeping(q, p, depth, moved)), depth, False
            else:
                room, dip = room / 2 if run < 0 else room, clear
                high, run = depth, min(run, 0) - 1
            if low == high:
                depth, high, dip, run = end, end, math.nan, _AGAIN
            elif (math.isnan(dip) and run >= _AGAIN) or high - low <= _STEP * size:
                depth = high  # from nearby a step may tell
            else:
                depth = low + (high - low) * float(np.nan_to_num(room / (room - dip), nan=0.5))
        raise NotCertifiedError(f"the contacts at depth = {end!r} do not come to rest")

    def overtakes(self, q: float, p: float, moved: Pair, low: float, high: float) -> bool:
        """Whether the surface may have touched ahead of a line that has passed there since.

        Whether D₀ <= d somewhere on its way, before the line itself came by; of where the other
        line was and is, that is taken which asks for more care. Without adhesion the state does not
        depend on the way: whether the profile pulls there at the end, which it must not.
        """
        profile, rests, (left, right) = self.search.rests.profile, self.search.rests, moved
        for side, x, new, old, facing in ((1, q, left, p, right), (-1, p, right, q, left)):
            own = profile.beyond(x, new)
            if own.stop == own.start:
                continue
            if not rests.scene.work_of_adhesion:
                if self.search.pulls(x, new, high):
                    return True
                continue
            z, f, f1 = (column[own][::side] for column in (profile.x, profile.f, profile.slope))
            found = rests.rest_depth(side, z, f, f1, rests.at(old), rests.w(1))
            passed = np.maximum.accumulate(np.append(low, found))[:-1]
            bare = rests.surfaces.rest_depth(side, z, f, f1, rests.at(facing), 0.0)
            if (bare <= np.minimum(passed, high) - TIE * rests.size).any():
                return True
        return False

    def _creeping(self, q: float, p: float, depth: float, end: Pair | None) -> Lines:
        """Both lines of a free surface advance to an end from sample to sample until it touches.

        First each as far as it goes beside the other; both at once where neither goes.
        """
        if end == (q, p):  # nothing moves: it has touched a little before
            place = self.least(end, depth)[1]
            return q, place, place, p
        (left, right), line, profile = end or (p, q), self.search.line, self.search.rests.profile
        while q < p and (q, p) != (left, right):
            lefts = [*profile.x[profile.beyond(q, left)].tolist(), left]
            rights = [*profile.x[profile.beyond(p, right)].tolist()[::-1], right]
            a = line(1, q, -math.inf, p, depth, 1, True)
            b = line(-1, p, math.inf, q, depth, 1, True)
            steps = [(x, p) for x in lefts if q < x and (a is None or x <= a)]
            steps = steps or [(q, x) for x in rights if x < p and (b is None or x >= b)]
            for step in steps or [(lefts[0], rights[0])]:
                if step[0] >= step[1]:
                    return end or ()
                clear, place = self.least(step, depth)
                if clear < -TIE * self.search.rests.size:
                    return q, place, place, p
                q, p = step
        return end or ()

    def least(self, lines: Pair, depth: float, *, exact: bool = False) -> tuple[float, float]:
        """The least of the minima of the clearance v = u - g between two lines, and where; or ∞.

        Those of the cubics through v and v' at samples, solved for where that may be the least and
        negative, unless its sign is certain and need not be exact. Towards a line v vanishes: that
        is no minimum. As the surface is nowhere lower than at both lines and far away, samples of
        the profile that are higher by a part of δ₀ do not count.
        """
        left, right = (self.search.rests.at(x) for x in lines)
        profile, shape = self.search.rests.profile, self.search.rests.surfaces.shape
        own, level = profile.beyond(*lines), max([depth, *(z.f for z in (left, right) if z)])
        low = profile.f[own] <= level + _HIGHER * self.search.rests.scene.opened.critical_separation
        if not low.any():
            return math.inf, math.nan
        low[1:] |= low[:-1]  # and the samples beside those
        low[:-1] |= low[1:]
        x, f, f1 = (column[own][low] for column in (profile.x, profile.f, profile.slope))
        ends = np.where(np.isfinite(lines), lines, x[[0, -1]])
        beside = np.array([ends, *profile.beside(ends, (1, -1))])
        x, f, f1 = np.concatenate([beside[:, :1], [x, f, f1], beside[:, 1:]], axis=1)
        u, u1 = shape(x, left, right, depth)
        v, v1 = u - depth + f, u1 + f1
        v1[0] = max(v1[0], _TINY) if left else -1.0  # an end without a line may be a minimum
        v1[-1] = min(v1[-1], -_TINY) if right else 1.0
        lo, hi, at, bend, clear, off = minima(x, v, v1)
        near = (clear - off <= min(0.0, (clear + off).min(initial=0.0))) & (lo < hi)
        near &= exact | (clear + off >= 0)
        if near.any():
            at[near] = crossings(
                lambda z, _: shape(z, left, right, depth)[1] + profile.indenter.slope(z),
                *(lo[near], hi[near], at[near], bend[near]),
                _LEVEL * float(((hi[near] - lo[near]) * bend[near]).min()),
            )
            clear[near] = shape(at[near], left, right, depth)[0] - depth
            clear[near] += profile.indenter.height(at[near])
        return min(zip(clear.tolist(), at.tolist(), strict=True), default=(math.inf, math.nan))


def pairs(lines: Sequence[float]) -> list[Pair]:
    """Lines two by two."""
    return list(zip(lines[::2], lines[1::2], strict=True))
