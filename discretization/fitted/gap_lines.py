"""The two contact lines of a gap between two contacts on the fitted mesh.

With the reactions S_a, S_b of the free surface in the gap (gap.py), the energy of the lines q < p
is with small slopes

    U(q, p) = ∫^q [k/2 g² + γ₁/2 f'² - w] dx + F(g(q), g(p); p - q) + ∫_p [k/2 g² + γ₁/2 f'² - w] dx

changes outwards of either contact by dU/dq = γ₁/2 r² - w, r = f' - S_a/γ₁, as k g² - S_a²/γ₁ =
2 ∂F/∂L on the mesh to rounding, and likewise for p. So each line obeys the rule of a line that
faces no other contact, with another reaction, and its `drive` is √(γ₁/2) r - √w. The lines are
found together: q is the sign change of its drive with p always in its own equilibrium. With finite
slopes (finite_gap.py) the rule is likewise that of such a line, r = 2 sin((β - φ)/2), sin φ = S/γ₁.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted import finite_gap, gap
from discretization.fitted.lines import Problem

Array = NDArray[np.float64]


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
        kink = self._kink(side * float(scene.indenter.slope(x + side * aside)), pull)
        return math.sqrt(scene.gamma1 / 2) * kink - self.problem.held

    def _kink(self, f1: float, pull: float) -> float:
        """r at a line with the slope f' outwards."""
        return f1 - pull

    def refuse_overhang(self, q: float, p: float) -> None:
        """ValueError if the surface would turn over."""

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


class FiniteGap(Gap):
    """The same with finite slopes."""

    def reactions(self, q: float, p: float) -> tuple[float, float]:
        return self._solved(q, p).relaxed.reactions

    def energy(self, q: float, p: float) -> float:
        return self._solved(q, p).relaxed.energy

    def area(self, q: float, p: float) -> float:
        return self._solved(q, p).relaxed.area

    def imbalance(self, q: float, p: float) -> float:
        """Residual of the free nodes, and how far off the reactions are that lines are found by."""
        read = self._solved(q, p)
        return max(read.relaxed.residual, read.apart)

    def refuse_overhang(self, q: float, p: float) -> None:
        if self._solved(q, p).upright:
            raise ValueError(
                f"depth = {self.problem.depth!r}: between the contact lines x = {q!r} and {p!r} "
                "the surface would turn over (inclination beyond π/2) and is no graph u(x); use a "
                "smaller |depth|, a smaller w or a blunter indenter"
            )

    def _kink(self, f1: float, pull: float) -> float:
        phi = math.asin(min(max(pull, -1.0), 1.0))
        return 2 * math.sin((math.atan(f1) - phi) / 2)

    def _solved(self, q: float, p: float) -> finite_gap.FiniteGap:
        even, odd = self._halves(q, p)
        return finite_gap.solved(even + odd, -2 * odd, self._length(q, p))


def gap_of(problem: Problem) -> Gap:
    """The gaps of a problem."""
    return (Gap if problem.scene.slopes == "small" else FiniteGap)(problem)
