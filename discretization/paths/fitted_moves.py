"""Contact lines on the fitted mesh that move downhill at a fixed depth, with those they call for.

As the indenter is pressed, lines advance to the first place where they rest, contacts whose lines
meet become one, and where the free surface touches the profile there is a new contact. Each of
these only helps the others on, as the gap v = u - g falls with every point that comes into contact;
so the order does not matter. As it is retracted, lines recede and contacts close, likewise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from discretization.fitted import gap
from discretization.fitted.roots import bracketed
from discretization.paths.clearance import Clearance
from discretization.paths.gap_moves import GapMoves, lower
from discretization.paths.line_levels import Levels
from discretization.paths.stops import Ground, first_stop

Lines = tuple[float, ...]
Pair = tuple[float, float]
_MOST = 10_000
_PULLED = 1e-12


@dataclass(frozen=True, eq=False)
class Moves:
    """Lines (left, right, left, ...) from left to right under a depth.

    ends: of the profile.
    """

    levels: Levels
    ground: Ground
    gaps: GapMoves
    clearance: Clearance
    ends: tuple[float, float]

    def relaxed(self, lines: Lines, depth: float, tie: float, exact: bool) -> Lines:
        """The lines at rest; () where there is no contact.

        tie: how far the profile may be from the free surface to count as touching it. Not exact:
        lines may go too far before the surface touches, which is only seen.
        """
        return self._retracted(self._pressed(lines, depth, tie, exact), depth)

    def _pressed(self, lines: Lines, depth: float, tie: float, exact: bool) -> Lines:
        for _ in range(_MOST):
            surfaces: list[float] = []
            for left, right in _free(lines):
                surfaces += self._pressed_surface(left, right, depth, tie, exact)
            before, lines = lines, tuple(surfaces[1:-1])
            if len(lines) == len(before):
                return lines
        raise RuntimeError(f"the contacts at depth = {depth!r} do not come to rest")

    def _pressed_surface(
        self, left: float, right: float, depth: float, tie: float, exact: bool
    ) -> Lines:
        """The lines of a free surface at rest, or when it touches, with the points where it does.

        () where the lines meet.
        """
        moved = self._advanced(left, right, depth)
        if moved is None:
            return ()
        touching = self.clearance.touching(*moved, depth, tie)
        if not touching:
            return moved
        if not exact or moved == (left, right):
            return moved[0], *(x for x in touching for _ in range(2)), moved[1]

        old = left, right

        def at(t: float) -> Pair:
            q, p = (x if x == y else x + t * (y - x) for x, y in zip(old, moved, strict=True))
            return q, p

        def clear(t: float) -> float:
            return tie - min(
                (v for _, v in self.clearance.minima(*at(t), depth, math.inf)), default=math.inf
            )

        t = 0.0 if clear(0.0) >= 0 else bracketed(clear, 0.0, 1.0)
        q, p = at(t)
        touching = self.clearance.touching(q, p, depth, tie) or touching[:1]
        return q, *(x for x in touching for _ in range(2)), p

    def _retracted(self, lines: Lines, depth: float) -> Lines:
        while lines:
            moved = self._receded(lines, depth)
            held = [pair for pair in _pairs(moved) if pair[0] <= pair[1]]
            left = tuple(x for pair in held for x in pair)
            left = self._unpulled(left, depth)
            if len(left) == len(lines):
                return left
            # the others recede from where they were: what they have lost may not be theirs
            lines = left
        return lines

    def _advanced(self, left: float, right: float, depth: float) -> Pair | None:
        """Both lines of a free surface at their next rest outwards; None: they meet."""
        if math.isfinite(left) and math.isfinite(right):
            return self.gaps.towards(left, right, depth)
        if math.isfinite(left):
            left = self._outermost(1, left, self.ends[1], depth)
        if math.isfinite(right):
            right = self._outermost(-1, right, self.ends[0], depth)
        return left, right

    def _outermost(self, side: int, x: float, end: float, depth: float) -> float:
        """An outermost line that advances."""
        level = self.levels.tail
        found = first_stop(lambda y, aside: level(side, y, aside) - depth, x, end, self.ground)
        if found is None and end not in self.levels.scene.indenter.walls:
            raise ValueError(
                f"depth = {depth!r} spreads the contact over the whole known profile; give a wider "
                "profile or smaller depths"
            )
        return end if found is None else found

    def _receded(self, lines: Lines, depth: float) -> Lines:
        """Every line at its next rest inwards, as far as the other line of its contact was."""
        tail = self.levels.tail
        first = lower(lambda y, a: depth - tail(-1, y, a), lines[0], lines[1], self.ground)
        last = lower(lambda y, a: depth - tail(1, y, a), lines[-1], lines[-2], self.ground)
        found = [first]
        for i in range(1, len(lines) - 1, 2):
            found += self.gaps.apart(lines[i], lines[i + 1], lines[i - 1], lines[i + 2], depth)
        return (*found, last)

    def _unpulled(self, lines: Lines, depth: float) -> Lines:
        """Without contacts of one point, which do not adhere, that are pulled."""
        kept: list[float] = []
        for i, (left, right) in enumerate(_pairs(lines)):
            if left < right or self._pull(lines, 2 * i, depth) >= 0:
                kept += [left, right]
        return tuple(kept) if len(kept) == len(lines) else self._unpulled(tuple(kept), depth)

    def _pull(self, lines: Lines, i: int, depth: float) -> float:
        """Force on a contact of one point, over γ₁, plus what rounding may make of 0."""
        scene, response = self.levels.scene, self.levels.response
        length, total, size = scene.elastocapillary_length, 0.0, self.levels.kink
        own = float(scene.indenter.height(lines[i]))
        for other in (lines[i - 1] if i else None, lines[i + 2] if i + 2 < len(lines) else None):
            if other is None:
                part = (depth - own) / length * response.reaction(1.0)
            else:
                far = float(scene.indenter.height(other))
                found = gap.half(response.degree, abs(other - lines[i]) / length)
                part = (depth - (own + far) / 2) / length * found.even
                part += (far - own) / (2 * length) * found.odd
            total += part
            size += abs(part)
        return total + _PULLED * size


def _free(lines: Lines) -> list[tuple[float, float]]:
    """Both lines of every free surface, infinite where there is none."""
    return _pairs((-math.inf, *lines, math.inf))


def _pairs(lines: Lines) -> list[tuple[float, float]]:
    return list(zip(lines[::2], lines[1::2], strict=True))
