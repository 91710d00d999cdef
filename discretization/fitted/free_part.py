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
from discretization.fitted.rest_depths import TIE, RestDepths
from discretization.roots import bracketed
from discretization.surfaces.protocol import At
from energy.arrays import Array, Indices

Lines = tuple[float, ...]
_STEP = 1e-9  # of δ₀ and the depth: a step of the depth that is no longer halved
_TOUCHED = 1e-9  # of the same: the penetration at which a contact has begun
_AGAIN = 2  # smaller steps passed, after which a longer one is tried again
_UNKNOWN = -math.inf, math.nan  # the least clearance, and where, of a step that does not tell
_MOST = 100_000  # changes on one way, as in motion.py
_UNSURE = 1 / 16  # of the width of an interval and of how v' varies in it
_HIGHER = 1 / 16  # of δ₀


@dataclass(frozen=True, eq=False)
class FreePart:
    """Free surfaces that are pressed."""

    search: LineSearch

    @property
    def rests(self) -> RestDepths:
        """Where lines rest."""
        return self.search.rests

    def advance(self, left: float, right: float, start: float, end: float) -> Lines:
        """The lines of a free surface with those of contacts that begin in it; () if it closes."""
        done: list[float] = []
        todo = [(left, right, start)]
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

        At the depth `high` something has happened since `low`, or a step that long does not tell;
        first nothing is known, and `low` itself is asked. passes: how many steps in a row have
        succeeded since one did not tell.
        """
        size, depth, high, passes = self.rests.size, low, end, _AGAIN
        for _ in range(_MOST):
            moved = self.search.advance(q, p, depth)
            plain = moved is not None and not self.overtakes(q, p, moved, low, depth)
            least, place = self.least(moved, depth) if moved and plain else _UNKNOWN
            if moved and least >= -TIE * size:
                if depth == end:
                    return [moved], end, True
                (q, p), low, passes = moved, depth, passes + 1
            elif moved and least >= -_TOUCHED * size:
                return [(moved[0], place), (place, moved[1])], depth, False
            elif depth - low <= _STEP * size:
                if moved is None and math.isinf(q - p):
                    raise ValueError(_beyond(depth, p if math.isinf(q) else q))
                return pairs(self._creeping(q, p, depth)), depth, False
            else:
                high, passes = depth, -_MOST if plain else 0
            if low == high:
                depth, high, passes = end, end, _AGAIN
            else:  # from nearby a step may tell
                near = passes >= _AGAIN or high - low <= _STEP * size
                depth = high if near else (low + high) / 2
        raise NotCertifiedError(f"the contacts at depth = {end!r} do not come to rest")

    def overtakes(self, q: float, p: float, moved: Pair, low: float, high: float) -> bool:
        """Whether the surface may have touched ahead of a line that has passed there since.

        Whether D₀ <= d somewhere on its way, before the line itself came by; of where the other
        line was and is, that is taken which asks for more care. Without adhesion the state does not
        depend on the way: whether the profile pulls there at the end, which it must not.
        """
        profile, rests = self.rests.profile, self.rests
        for side, x, new, old, facing in (
            (1, q, moved[0], p, moved[1]),
            (-1, p, moved[1], q, moved[0]),
        ):
            own = profile.beyond(x, new)
            if own.stop == own.start:
                continue
            if not rests.scene.work_of_adhesion:
                if self.search.pulls(x, new, high):
                    return True
                continue
            z, f, f1 = (column[own][::side] for column in (profile.x, profile.f, profile.slope))
            found = rests.rest_depth(side, z, f, f1, rests.at(old), 1)
            passed = np.maximum.accumulate(np.append(low, found))[:-1]
            bare = rests.surfaces.rest_depth(side, z, f, f1, rests.at(facing), 0.0)
            if (bare <= np.minimum(passed, high) - TIE * rests.size).any():
                return True
        return False

    def _creeping(self, q: float, p: float, depth: float) -> Lines:
        """Both lines of a free surface advance from sample to sample, until it touches."""
        end = self.search.advance(q, p, depth)
        if end == (q, p):  # nothing moves: it has touched a little before
            place = self.least(end, depth)[1]
            return q, place, place, p
        goal = end or (p, q)
        while (q, p) != end:
            step = (self._next(q, goal[0], 1), self._next(p, goal[1], -1))
            if step[0] >= step[1] or step == (q, p):
                return () if end is None else end
            least, place = self.least(step, depth)
            if least < -TIE * self.rests.size:
                return q, place, place, p
            q, p = step
        return q, p

    def _next(self, x: float, goal: float, side: int) -> float:
        """The next sample on the way of a line, or its goal."""
        if math.isinf(x) or x == goal:
            return x
        own = self.rests.profile.beyond(x, goal)
        if own.stop == own.start:
            return goal
        return float(self.rests.profile.x[own.start if side > 0 else own.stop - 1])

    def least(self, lines: Pair, depth: float) -> tuple[float, float]:
        """The least clearance v = u - g between two lines, and where.

        Read where it is negative at samples; between two of them, where v' changes sign, at the
        minimum of the cubic through v and v'. The least of all these is solved for, unless its sign
        is certain. Towards a line v vanishes: that is no minimum, ∞.
        """
        left, right = (self.rests.at(x) for x in lines)
        highest = max([depth, *(line.f for line in (left, right) if line is not None)])
        z, f, slope = self._near(lines, highest)
        if not z.size:
            return math.inf, math.nan
        u, u1 = self.rests.surfaces.shape(z, left, right, depth)
        v, v1 = u - depth + f, u1 + slope
        i = int(np.argmin(v))
        best, place = (float(v[i]), float(z[i])) if v[i] < 0 else (math.inf, math.nan)
        dips = np.flatnonzero((v1[:-1] < 0) & (v1[1:] > 0))
        if dips.size:
            low, unsure = _dips(z, v, v1, dips)
            j = int(np.argmin(low))
            if low[j] < best:
                i = int(dips[j])
                if abs(low[j]) <= unsure[j]:
                    return self._bottom(left, right, depth, *z[i : i + 2].tolist())
                return float(low[j]), float(z[i] + v1[i] / (v1[i] - v1[i + 1]) * (z[i + 1] - z[i]))
        return best, place

    def _near(self, lines: Pair, highest: float) -> Array:
        """x, f and f' of the samples between two lines that are low: v >= f - max(d, f_line).

        And of those a little higher, so that the least v changes with the depth without a jump.
        """
        profile, own = self.rests.profile, self.rests.profile.beyond(*lines)
        f = profile.f[own]
        low = f <= highest + _HIGHER * self.rests.scene.opened.critical_separation
        kept = low.copy()
        kept[1:] |= low[:-1]
        kept[:-1] |= low[1:]
        return np.array([profile.x[own][kept], f[kept], profile.slope[own][kept]])

    def _bottom(
        self, left: At | None, right: At | None, depth: float, start: float, end: float
    ) -> tuple[float, float]:
        """The minimum between two samples, as v and its place."""
        indenter, shape = self.rests.profile.indenter, self.rests.surfaces.shape

        def inclined(z: float) -> float:
            return float(shape(np.array(z), left, right, depth)[1] + indenter.slope(z))

        place = bracketed(inclined, start, end)
        u = float(shape(np.array(place), left, right, depth)[0])
        return u - depth + float(indenter.height(place)), place


def _beyond(depth: float, x: float) -> str:
    return (
        f"depth = {depth!r} spreads the contact from x = {x!r} to where the profile is not known "
        "any more; give a wider profile, a smaller depth, or add a FlatPunch whose edge ends the "
        "indenter there"
    )


def pairs(lines: Sequence[float]) -> list[Pair]:
    """Lines two by two."""
    return list(zip(lines[::2], lines[1::2], strict=True))


def _dips(z: Array, v: Array, v1: Array, at: Indices) -> tuple[Array, Array]:
    """The least v of the cubics between samples `at` and the next, and how far it may be off."""
    width, fall, rise = z[at + 1] - z[at], -v1[at], v1[at + 1]
    t = fall / (fall + rise)
    t2, t3 = t * t, t * t * t
    low = v[at] * (2 * t3 - 3 * t2 + 1) + v[at + 1] * (3 * t2 - 2 * t3)
    low += width * (rise * (t3 - t2) - fall * (t3 - 2 * t2 + t))
    return low, _UNSURE * width * (fall + rise)
