"""The two contact lines of a gap between two contacts on the fitted mesh (small slopes).

With the reactions S_a, S_b of the free surface in the gap (gap.py), the energy of the lines q < p

    U(q, p) = ∫^q [k/2 g² + γ₁/2 f'² - w] dx + F(g(q), g(p); p - q) + ∫_p [k/2 g² + γ₁/2 f'² - w] dx

changes outwards of either contact by dU/dq = γ₁/2 r² - w, r = f' - S_a/γ₁, as k g² - S_a²/γ₁ =
2 ∂F/∂L on the mesh to rounding, and likewise for p. So each line obeys the rule of a line that
faces no other contact, with another reaction, and its `drive` is √(γ₁/2) r - √w. The lines are
found together: q is the sign change of its drive with p always in its own equilibrium.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted import gap
from discretization.fitted.lines import FittedLine, Problem
from discretization.fitted.roots import bracketed

Array = NDArray[np.float64]
Drive = Callable[[float, float], float]
_TIE = 1e-12
_ASIDE = 1e-9
_STEPS = 10**5


class LostLineError(RuntimeError):
    """A line that was looked for is not near: its contact has let go or met the next one."""


@dataclass(frozen=True, eq=False)
class Gap:
    """The free surface between two lines of a problem."""

    problem: Problem

    def reactions(self, q: float, p: float) -> tuple[float, float]:
        """S_a, S_b [γ₁] = ∂F/∂g at the lines q < p."""
        even, odd = self._halves(q, p)
        found = gap.half(self.problem.response.degree, self._length(q, p))
        return even * found.even + odd * found.odd, even * found.even - odd * found.odd

    def energy(self, q: float, p: float) -> float:
        """F [γ₁ l]."""
        even, odd = self._halves(q, p)
        found = gap.half(self.problem.response.degree, self._length(q, p))
        return even * even * found.even + odd * odd * found.odd

    def area(self, q: float, p: float) -> float:
        """∫u dx [l²] over the nodes."""
        degree, length = self.problem.response.degree, self._length(q, p)
        even = self._halves(q, p)[0]
        if length > 2 * gap.FAR:
            return 2 * even * self.problem.response.area(1.0)
        return 2 * even * float(gap.shapes(degree, length).areas[0])

    def imbalance(self, q: float, p: float) -> float:
        """Residual of the free nodes, and of 2 ∂F/∂L = u_a² - S_a², over the displacement there."""
        degree, length = self.problem.response.degree, self._length(q, p)
        if length > 2 * gap.FAR:
            return abs(self.problem.response.reaction(1.0) - 1)
        (even, odd), found = self._halves(q, p), gap.half(degree, length)
        even_rate, odd_rate = gap.rates(degree, length)
        rate = even * even * even_rate + odd * odd * odd_rate
        own, reaction = even + odd, even * found.even + odd * found.odd
        size = own * own + reaction * reaction
        apart = abs(2 * rate - own * own + reaction * reaction) / (size or 1.0)
        return max(apart, gap.shapes(degree, length).residual / (1 + found.odd))

    def drive(self, side: int, q: float, p: float, aside: float) -> float:
        """√(γ₁/2) r - √w of the line q (side 1) or p (side -1); negative: it advances."""
        scene = self.problem.scene
        x = q if side > 0 else p
        pull = self.reactions(q, p)[0 if side > 0 else 1]
        jump = side * float(scene.indenter.slope(x + side * aside)) - pull
        return math.sqrt(scene.gamma1 / 2) * jump - self.problem.held

    def stiffness(self, q: float, p: float, step: float) -> Array:
        """Change of both drives (rows) as the lines (columns) move outwards, by differences."""
        result = np.empty((2, 2))
        for column, side in enumerate((1, -1)):
            moved = [(q + h, p) if side > 0 else (q, p - h) for h in (-step, step)]
            for row, own in enumerate((1, -1)):
                low, high = (self.drive(own, *lines, 0.0) for lines in moved)
                result[row, column] = (high - low) / (2 * step)
        return result

    def _length(self, q: float, p: float) -> float:
        if p <= q:
            raise LostLineError(f"the contacts beside x = {q!r} have met")
        return (p - q) / self.problem.scene.elastocapillary_length

    def _halves(self, q: float, p: float) -> tuple[float, float]:
        """s and t; t from the heights, as g(q) - g(p) may cancel."""
        height, length = (
            self.problem.scene.indenter.height,
            self.problem.scene.elastocapillary_length,
        )
        left, right = float(height(q)), float(height(p))
        even = self.problem.depth - left / 2 - right / 2
        return even / length, (right - left) / (2 * length)


@dataclass(frozen=True)
class Search:
    """Where a line is looked for: from `start` in growing steps, between two limits.

    side: outwards of its contact; corners: increasing; walls: where the body ends.
    """

    side: int
    start: float
    step: float
    inner: float
    outer: float
    corners: Array
    walls: tuple[float, ...]

    def corner(self, x: float, way: int) -> float:
        """The next corner from x on this way."""
        if way > 0:
            i = int(np.searchsorted(self.corners, x, side="right"))
            return float(self.corners[i]) if i < self.corners.size else math.inf
        i = int(np.searchsorted(self.corners, x, side="left")) - 1
        return float(self.corners[i]) if i >= 0 else -math.inf

    def at_corner(self, x: float) -> bool:
        """Whether x is a corner."""
        i = int(np.searchsorted(self.corners, x))
        return i < self.corners.size and bool(self.corners[i] == x)


def settled(h: Drive, held: float, search: Search) -> FittedLine:
    """The line nearest downhill: outwards while its drive h is negative, inwards while positive.

    h(x, aside): drive of a line at x, the slope read `aside` of x outwards. LostLineError where
    there is none between the limits.
    """
    side, x, step, aside = search.side, search.start, search.step, _ASIDE * search.step
    outwards = h(x, aside if search.at_corner(x) else 0.0) < 0
    if search.at_corner(x):
        pinned = _pinned(h, held, search, x, aside)
        if pinned is not None:
            return pinned
        outwards = h(x, -aside) <= 0
    way, limit = (side, search.outer) if outwards else (-side, search.inner)
    for _ in range(_STEPS):
        y = way * min(way * (x + way * step), way * search.corner(x, way), way * limit)
        kink = search.at_corner(y)
        value = h(y, (-aside if outwards else aside) if kink else 0.0)
        if (value > 0) if outwards else (value <= 0):
            inside, outside = (x, y) if outwards else (y, x)
            return FittedLine(_between(h, aside, search, inside, outside), False, False)
        if kink:
            pinned = _pinned(h, held, search, y, aside)
            if pinned is not None:
                return pinned
        if y == limit:
            break
        x, step = y, step if kink else 2 * step
    raise LostLineError(
        f"no contact line between x = {search.inner!r} and {search.outer!r}: the contact there has "
        "let go or met the next one"
    )


def _between(h: Drive, aside: float, search: Search, inside: float, outside: float) -> float:
    """Sign change of h between two positions, slopes at corners read from in between."""
    ends = {inside: aside, outside: -aside}

    def read(x: float) -> float:
        return h(x, ends[x] if x in ends and search.at_corner(x) else 0.0)

    return bracketed(read, inside, outside)


def _pinned(h: Drive, held: float, search: Search, x: float, aside: float) -> FittedLine | None:
    """The line at this corner, if it holds it."""
    near = h(x, -aside)
    tie = _TIE * (abs(near) + held)
    if near > tie:
        return None
    if x in search.walls:
        return FittedLine(x, True, held > 0 and abs(near) <= tie)
    return FittedLine(x, True, False) if h(x, aside) >= -tie else None


def lines_of_gap(own: Gap, left: Search, right: Search) -> tuple[FittedLine, FittedLine]:
    """Both lines of a gap, each in its equilibrium with the other."""
    held = own.problem.held
    last = [right.start]

    def facing(q: float) -> FittedLine:
        at = Search(-1, last[0], right.step, right.inner, q, right.corners, right.walls)
        line = settled(lambda x, aside: own.drive(-1, q, x, aside), held, at)
        last[0] = line.x
        return line

    q = settled(lambda x, aside: own.drive(1, x, facing(x).x, aside), held, left)
    return q, facing(q.x)
