"""Load paths without surface tension, γ₁ = 0, of any profile: independent springs.

Each spring attaches when it is touched and lets go at u = -δ₀, so that the contact is what lies
below a level of the profile. Pressed, the level is the depth where that is higher; retracted, it is
d + δ₀ where that is lower. Nothing jumps: what attaches loses its work of adhesion, as it had to be
touched, and no energy is released at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.contacts import panels
from discretization.fitted.quadrature import Interval, arc_length, refined
from discretization.fitted.springs import at_level, below
from discretization.paths.balance import integral
from discretization.paths.branch import FollowerBase, at_edges
from discretization.profile import Resolved, resolve
from energy import Scene

Array = NDArray[np.float64]
_WORK = 1e-10  # of the integral of the force, which has a kink where contacts begin or end


class Level(NamedTuple):
    """What lies below a level is in contact: its lines from left to right."""

    level: float
    lines: tuple[float, ...]

    @property
    def ends(self) -> tuple[float, float]:
        """x of the outermost lines."""
        return self.lines[0], self.lines[-1]


State = Level | None


@dataclass(frozen=True, eq=False)
class SpringsBranch(FollowerBase):
    """States of independent springs under a prescribed depth; None: detached."""

    scene: Scene
    profile: Resolved
    rtol: float

    @classmethod
    def of(cls, scene: Scene, rtol: float, deepest: float) -> SpringsBranch:
        """deepest: the largest depth of the programme. ValueError for a pattern."""
        if scene.pattern is not None:
            raise ValueError(
                f"pattern = {scene.pattern!r} with gamma1 = 0: springs that let go at different "
                "heights are not followed; give gamma1 > 0, or leave the pattern out"
            )
        return cls(scene, resolve(scene, deepest), rtol)

    @property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return self.profile.touch

    def _at(self, level: float) -> State:
        if level < self.touch:
            return None
        return Level(level, tuple(below(self.profile, level).ravel().tolist()))

    def contact(self, depth: float, *lines: float) -> State:
        """The state with lines here; nan: detached."""
        if math.isnan(lines[0]):
            return None
        return Level(float(np.max(self.profile.indenter.height(np.array(lines)))), lines)

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        if before is None and depth < self.touch:
            return None
        level = self.touch if before is None else before.level
        return self._at(min(max(level, depth), depth + self.lift))

    def jump(self, state: State, start: float, end: float) -> None:
        """Springs do not jump."""

    def pinned(self, state: State) -> tuple[str, str]:
        """What holds the outermost lines: "edge" or "" where they are free."""
        return at_edges(self.scene, state)

    def _totals(self, state: Level, depth: float) -> Interval:
        x = np.array(state.lines).reshape(-1, 2)
        return refined(self.scene, depth, panels(self.scene.indenter, x), (0.0,) * 4, 1e-14)[1]

    def force(self, state: State, depth: float) -> float:
        """P."""
        return 0.0 if state is None else self._totals(state, depth).force

    def energy(self, state: State, depth: float) -> float:
        """U."""
        return 0.0 if state is None else self._totals(state, depth).energy

    def friction(self, before: State, after: State) -> float:
        """w of what closes, which had to be touched, and w_opening - w of what opens."""
        if before is None or after is None:
            return 0.0
        grown = self._length(after) - self._length(before)
        w, opening = self.scene.work_of_adhesion, self.scene.opened.work_of_adhesion
        return w * grown if grown > 0 else (w - opening) * grown

    def _length(self, state: Level) -> float:
        pairs = zip(state.lines[::2], state.lines[1::2], strict=True)
        return sum(arc_length(self.scene, left, right) for left, right in pairs)

    def work(self, before: State, start: float, end: float) -> float:
        """∫P dd from one depth to another, by adaptive Lobatto rules."""
        if before is None:
            return 0.0
        return integral(
            lambda depth: self.force(self.follow(before, depth), depth), start, end, _WORK
        )

    def observed(self, depths: Array, states: Sequence[Level]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,)."""
        found = [self._totals(s, d) for d, s in zip(depths.tolist(), states, strict=True)]
        force, energy = np.array([(one.force, one.energy) for one in found]).T
        return np.array([state.ends for state in states]), force, energy

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError unless the springs are in equilibrium."""
        if state is not None:
            at_level(self.scene, self.profile, depth, state.level, branch="adhered", rtol=self.rtol)
