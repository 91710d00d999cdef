"""States of the fitted mesh: contact lines that move downhill in energy as the depth changes.

A state is the tuple of its lines from left to right, (left, right, left, right, ...); () is
detached. In contact u = d - f is prescribed, so the free surfaces (two tails, and a gap between
neighbouring contacts) do not feel each other, and each is followed by itself. Pressed
(free_part.py), lines advance to the first place where they rest, a contact begins where the free
surface touches the profile, and lines that meet close their gap. Retracted, lines recede to the
first place where they rest, and contacts whose lines meet are gone.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.free_part import FreePart, Lines, pairs
from discretization.fitted.line_search import MET, LineSearch, Pair
from discretization.fitted.rest_depths import SIDES, TIE, ULPS, RestDepths, surfaces_of
from discretization.profile import Resolved
from discretization.surfaces.protocol import Felt, Surfaces
from energy import Scene
from energy.arrays import Array, Mask

_MOST = 100_000  # changes on one way: a profile of a million corners has fewer


class FeltRows(NamedTuple):
    """What judges the lines (n, 2) of free surfaces, as in `Felt`; stable (n,)."""

    free: Mask
    closing: Array
    bare: Array
    opening: Array
    moved: Array
    stable: Mask


@dataclass(frozen=True, eq=False)
class Motion:
    """What moves the lines of a scene."""

    scene: Scene
    profile: Resolved
    surfaces: Surfaces
    rests: RestDepths

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, depth: float) -> Motion:
        """For depths up to this one."""
        surfaces = surfaces_of(scene)
        size = scene.opened.critical_separation + max(abs(depth), abs(profile.touch))
        size = size or scene.layer.h  # of no adhesion at touching itself
        return cls(scene, profile, surfaces, RestDepths(scene, profile, surfaces, size))

    @property
    def gradual(self) -> bool:
        """Whether lines never jump: D grows outwards in a line contact of a convex profile."""
        scene = self.scene
        return scene.indenter.convex and not scene.axisymmetric and scene.pattern is None

    @functools.cached_property
    def free_part(self) -> FreePart:
        """What moves the lines of one free surface."""
        return FreePart(LineSearch(self.rests))

    def adhered(self, depth: float) -> Lines:
        """The state of the path that touches first and then moves to this depth."""
        touch = self.profile.touch
        if depth < touch and not self.scene.opened.work_of_adhesion:
            return ()
        lines = self.first()
        return self.pressed(lines, touch, depth) if depth >= touch else self.relaxed(lines, depth)

    def settled(self, lines: Lines, depth: float) -> Lines:
        """Lines that are near a state at rest, moved to it."""
        kept = self.retracted(lines, depth)
        if not kept:
            return () if depth < self.profile.touch else self.adhered(depth)
        return self.pressed(kept, depth, depth)

    def penetration(self, lines: Lines, depth: float) -> float:
        """How far the profile sticks through the free surfaces, at worst [length]."""
        least = (self.free_part.least(pair, depth, exact=True)[0] for pair in free_parts(lines))
        return max(0.0, -min(least))

    def pointed(self, x: float) -> bool:
        """Whether a contact of the one point x stands for one too narrow for doubles: never here.

        Only a convex profile alone has such a contact (alone.py).
        """
        return False

    def felt(self, lines: Lines, depth: float) -> list[Felt]:
        """What judges the lines of every free surface."""
        x = np.array(free_parts(lines))
        if self.scene.axisymmetric and not lines[0]:
            x[0, 1] = math.inf  # a contact around the axis has no line there
        points = np.isin(x, [left for left, right in pairs(lines) if left == right])
        lone = len(lines) == 2 and self.scene.indenter.convex
        found = self.felt_by(x, points, lone=lone)
        columns = np.broadcast_arrays(
            x, found.free, found.closing, found.bare, found.opening, self.rests.size, found.moved,
            found.stable[:, None],
        )  # fmt: skip
        rows = np.stack(columns, axis=-1).reshape(-1, len(columns)).tolist()
        return [Felt(*row) for row in rows if math.isfinite(row[0])]

    def felt_by(self, x: Array, points: Mask, *, lone: bool = False) -> FeltRows:
        """The same of the lines of free surfaces (n, 2), those of contacts of one point marked.

        D of free lines is off by the rounding of their places, and by that of narrow gaps. Held are
        those at corners, edges of the body, and beside those of a pattern. lone: the only contact.
        """
        rests, edges = self.rests, self.profile.edges
        held = [*self.profile.corners, *self.profile.indenter.walls, *edges]
        loose = np.isfinite(x) & ~np.isin(x, [*held, *np.nextafter(edges, -math.inf)])
        with np.errstate(invalid="ignore"):
            off = np.where(loose, ULPS * np.spacing(np.abs(x)), 0.0) * SIDES
        noise, out = rests.noise(x)[:, None], x + off
        closing, behind = rests.ahead(out, 1) + noise, rests.ahead(x - off, -1) - noise
        bare = rests.beside(SIDES, out, out[:, ::-1], 1, 1, adheres=False) + noise
        behind[points] = -math.inf
        rates = rests.with_rates(x, rests.between_corners(x, 1), 1)[1]
        rates = np.where(np.isfinite(rates), rates, 0.0)
        moved, firm = rests.condition(rates, loose, lone=lone)
        return FeltRows(loose, closing, bare, behind, moved, firm)

    def torn(self, corners: Array) -> Array:
        """Forces that would open contacts at corners, beyond what lines hold there."""
        return self.scene.gamma1 * (self.profile.falls(self.scene.slopes) - self.holds(corners))

    def opening(self, lines: Lines, depth: float) -> list[float]:
        """Forces that would open contacts: where they do not adhere, and at corners."""
        scene, x, ends = self.scene, self.profile.corners, np.array(lines)
        unit, bare = scene.stiffness * scene.elastocapillary_length, self.bare(ends.reshape(-1, 2))
        forces = [unit * self.free_part.search.pull(*part, depth).force for part in bare]
        if x.size and not scene.indenter.convex:
            inside = np.searchsorted(ends, x) & np.searchsorted(ends, x, "right")
            forces += self.torn(x)[inside % 2 == 1].tolist()
        return forces

    def first(self) -> Lines:
        """The state at first touch."""
        touch, lowest = self.profile.touch, self.profile.lowest
        return self.pressed((lowest, lowest), touch, touch)

    def pressed(self, lines: Lines, start: float, end: float) -> Lines:
        """Lines at rest at the depth `start`, taken to the depth `end` >= start.

        Where a contact begins is known to _TOUCHED only: lines that went too far for it recede.
        """
        found: list[float] = []
        for pair in free_parts(lines):
            found += self.free_part.advance(*pair, start, end)
        return self.relaxed(tuple(found[1:-1]), end)

    def relaxed(self, lines: Lines, depth: float) -> Lines:
        """Lines that recede as far as they must, and gaps that open.

        Gaps open inside contacts without a barrier: at a corner at which the slope falls by more
        than two lines hold, and without adhesion where the profile would pull at the surface.
        """
        lines = self.retracted(lines, depth)
        for _ in range(_MOST):
            gaps = {pair: self._torn(*pair, depth) for pair in pairs(lines)}
            if not any(gaps.values()):
                return lines
            parts = [(left, *gap, right) for (left, right), gap in gaps.items()]
            lines = self.retracted(tuple(x for part in parts for x in part), depth)
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def _torn(self, left: float, right: float, depth: float) -> Lines:
        """The lines of a gap that opens in a contact by itself; () if nowhere."""
        torn = self.free_part.search.torn(left, right, depth, self.holds(self.profile.corners))
        if torn.size:
            aside = MET * self.scene.elastocapillary_length
            return float(torn[0]) - aside, float(torn[0]) + aside
        for start, end in self.bare(np.array([[left, right]])):
            found = self.free_part.search.pull(start, end, depth)
            if found.force > self.free_part.search.least_pull(depth):
                return found.ends
        return ()

    def holds(self, x: Array) -> Array:
        """The kink that both lines of a closed gap hold together: 2 √(2w/γ₁), or as angles."""
        w, pattern = self.scene.opened.work_of_adhesion, self.scene.pattern
        least = np.ones_like(x)
        if pattern is not None:  # the gap opens to the side that adheres less
            beside = (pattern.factor(np.nextafter(x, end)) for end in (-math.inf, math.inf))
            least = np.minimum(*beside)
        half = np.sqrt(w * least / (2 * self.scene.gamma1))
        return 4 * half if self.scene.slopes == "small" else 4 * np.arcsin(half)

    def bare(self, contacts: Array) -> list[Pair]:
        """The parts of contacts (m, 2) that do not adhere: all where w = 0, or bare patches."""
        if not self.scene.opened.work_of_adhesion:
            return [(left, right) for left, right in contacts.tolist() if left < right]
        if self.scene.pattern is None:
            return []
        edges = [-math.inf, *self.scene.pattern.edges, math.inf]
        found = []
        for (start, end), factor in zip(pairwise(edges), self.scene.pattern.factors, strict=True):
            for left, right in contacts.tolist() if not factor else ():
                if max(start, left) < min(end, right):
                    found.append((max(start, left), min(end, right)))
        return found

    def retracted(self, lines: Lines, depth: float) -> Lines:
        """Lines taken to a smaller depth."""
        while lines:
            surfaces, ends = np.array(free_parts(lines)), free_parts((-math.inf, *lines, math.inf))
            behind = np.where(np.isfinite(surfaces), self.rests.ahead(surfaces, -1), -math.inf)
            loose = (behind - depth > TIE * self.rests.size).any(axis=1)
            for i in np.flatnonzero(loose).tolist():
                (least, q), (p, most) = ends[i : i + 2]
                surfaces[i] = self.free_part.search.recede(q, p, least, most, depth)
            held: list[float] = []
            for left, right in pairs(surfaces.ravel().tolist()[1:-1]):
                sharp = *self.profile.corners, *self.profile.indenter.walls
                corners = [x for x in (left, right) if x in sharp]
                held += (left, right) if left <= right else 2 * corners[:1]  # narrowed to a corner
            kept = self.unpulled(tuple(held), depth)
            if len(kept) == len(lines):
                return kept
            lines = kept
        return lines

    def unpulled(self, lines: Lines, depth: float) -> Lines:
        """Without contacts of one point that are pulled: the surface is clear without them."""
        kept: list[float] = []
        for (before, left), (right, beyond) in pairwise(free_parts(lines)):
            if left < right or not self._pulled(left, (before, beyond), depth):
                kept += left, right
        return tuple(kept)

    def _pulled(self, x: float, beside: Pair, depth: float) -> bool:
        """Whether a contact of one point is pulled: the surface without it is clear there."""
        left, right = (self.rests.at(end) for end in beside)
        u, _ = self.rests.surfaces.shape(np.array(x), left, right, depth)
        f = float(self.profile.indenter.height(x))
        size = max(abs(depth), abs(f), *(abs(depth - line.f) for line in (left, right) if line))
        return bool(u - depth + f > TIE * size)


def free_parts(lines: Sequence[float]) -> list[Pair]:
    """Both lines of every free surface, infinite where there is none."""
    return pairs((-math.inf, *lines, math.inf))
