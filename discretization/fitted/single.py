"""States of one contact where there can be no other: totals, certificate, error estimate."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import ROUNDING, Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.alone import Alone
from discretization.fitted.contacts import equilibrium, estimated, push, totals
from discretization.quadrature import Interval
from discretization.surfaces.protocol import Free
from energy import Scene

Array = NDArray[np.float64]
_UNDECIDED = 1e-7  # letting go and turning over at once
_POSITION = ROUNDING / 4  # of |x|, to which a line is found
# steps over the width of a contact, and the least rise of D - d over its rounding
_STEPS = *((10.0**n, 10) for n in range(-8, -3)), (0.5, 4)


def on_one_contact(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """Certified equilibrium with its contact lines as unknowns, and its error estimate.

    branch "global" of a convex indenter: this state or, before it touches, the detached one,
    whichever has less energy. There is no other: the force on each line grows outwards.
    """
    alone = Alone.of(scene)
    lines, size = alone.lines(depth), alone.size(depth) or 1.0
    if lines:
        state = Single(alone, depth, tuple(lines)).state(branch)
        if branch != "global" or state.energy <= 0 or depth > alone.touch:
            return state
    elif abs(float(alone.rest(1, alone.apex)) - depth) <= _UNDECIDED * size:
        alone.free(1, alone.apex, depth)
    pressed = max(0.0, depth - alone.touch) / size
    return detached(scene, depth, branch, alone.surfaces, Certificate.undeformed(pressed))


@dataclass(frozen=True, eq=False)
class Single:
    """The contact at a depth; x: of its lines on either side, about an axis of the only one."""

    alone: Alone
    depth: float
    x: tuple[float, ...]

    @property
    def lines(self) -> list[tuple[int, float]]:
        """Side and place of every line."""
        return list(zip(self.alone.sides, self.x, strict=True))

    @functools.cached_property
    def free(self) -> list[Free]:
        """The free surfaces beyond the lines. ValueError where one would turn over."""
        return [self.alone.free(side, x, self.depth) for side, x in self.lines]

    @property
    def ends(self) -> Array:
        """Both ends of the contact (1, 2)."""
        return np.array([[0.0, *self.x][-2:]])

    def shortfall(self, side: int, x: Any, beside: int = 0, adhesive: bool = True) -> float:
        """D - d of a line at x; where it is negative it advances."""
        return float(self.alone.rest(side, x, beside, adhesive=adhesive)) - self.depth

    def state(self, branch: str) -> Equilibrium:
        """The certified state."""
        scene, depth = self.alone.scene, self.depth
        found = self.totals()
        certificate = self.certify(found)
        certificate.demand(
            f"the state at depth = {depth!r}", "try method='lattice' with a small spacing"
        )
        return equilibrium(
            self.ends,
            found,
            scene=scene,
            depth=depth,
            pinned=np.array([[True, *map(self._pinned, self.x)][-2:]]),
            certificate=certificate,
            surfaces=self.alone.surfaces,
            errors=self.errors(found),
            branch=branch,
            neutral=any(self._neutral(*line) for line in self.lines),
        )

    def _pinned(self, x: float) -> bool:
        """Whether a line is held by a corner."""
        indenter = self.alone.scene.indenter
        return x in indenter.corners or x in indenter.walls

    def _neutral(self, side: int, x: float) -> bool:
        """Whether a line at an edge of the body costs nothing to move inwards."""
        if x not in self.alone.scene.indenter.walls or not self.alone.scene.work_of_adhesion:
            return False
        return abs(self.shortfall(side, x, -1)) <= 2 * ROUNDING * self.alone.size(self.depth)

    def totals(self) -> Interval:
        """Energy and force."""
        return totals(self.alone.scene, self.depth, self.ends, self.free)

    def certify(self, found: Interval) -> Certificate:
        """The same conditions as of several contacts (contacts.py), next to the lines."""
        scene, penetration, neighbours = self.alone.scene, 0.0, 0.0
        lift = self.alone.size(self.depth) or 1.0
        size = lift + max(self._terms(side, x) for side, x in self.lines)
        width, highest = float(np.ptp(self.ends)), float(np.max(scene.indenter.height(self.ends)))
        step = 1e-7 * max(width, 1e-3 * scene.elastocapillary_length)
        for side, x in self.lines:
            if width:  # D may fall towards an edge
                at = (x, -1) if self._pinned(x) else (x - side * step, 0)
                neighbours = max(neighbours, self.shortfall(side, *at) / size)
            if x not in scene.indenter.walls:  # beyond an edge nothing can be penetrated
                beyond = x + side * step
                neighbours = max(neighbours, -self.shortfall(side, beyond) / size)
                bare = self.shortfall(side, beyond, adhesive=False)
                penetration = max(penetration, -bare / size)
        force = abs(found.force - found.force_by_field) / (found.force_scale or 1.0)
        pulled = 0.0 if scene.work_of_adhesion else max(0.0, highest - self.depth)
        stationarity = max(each.residual for each in self.free)
        return Certificate(penetration, stationarity, pulled / lift, neighbours, force)

    def _terms(self, side: int, x: float) -> float:
        """g and l |f'|, or l |sin β|: terms that cancel in D - d, but for δ₀ and d."""
        scene = self.alone.scene
        slope = abs(float(scene.indenter.slope_beside(x, -side)))
        if scene.slopes == "finite":
            slope /= math.hypot(1.0, slope)
        g = abs(self.depth - float(scene.indenter.height(x)))
        return g + scene.elastocapillary_length * slope

    def _sum(self, side: int, x: float) -> float:
        """Sum of the terms that cancel in D - d: d, f, and what f' and w add to D."""
        scene, rest = self.alone.scene, self.alone.surfaces.rest_depth
        sloped = rest(side, x, 0.0, float(scene.indenter.slope(x)), None, 0.0)
        lifted = rest(side, x, 0.0, 0.0, None, scene.work_of_adhesion)
        parts = self.depth, scene.indenter.height(x), sloped, lifted
        return sum(abs(float(part)) for part in parts)

    def errors(self, found: Interval) -> dict[str, float]:
        """Errors of surface and rounding times the condition of the line, and of the quadrature."""
        width, move, more = float(np.ptp(self.ends)), 0.0, 0.0
        for side, x in self.lines:
            if self._pinned(x) or not width:
                continue
            lost = ROUNDING * self._sum(side, x) + found.rounding
            moved = lost * self._yield(side, x, width, lost) + _POSITION * abs(x)
            move += moved
            more += moved * float(push(self.alone.scene, self.depth, np.array(x)))
        return estimated(found, width, move, more)

    def _yield(self, side: int, x: float, width: float, lost: float) -> float:
        """How far a line moves per change of its D - d, by the shortest step rounding leaves.

        Beside the least depth of a contact D grows outwards only from close by.
        """
        for part, clear in _STEPS:
            rise = -self.shortfall(side, x - side * part * width)
            if rise > clear * lost:
                return part * width / rise
        return width / lost
