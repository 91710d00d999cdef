"""States of the fitted mesh: contact lines that move downhill in energy as the depth changes.

A state is the tuple of its lines from left to right, (left, right, left, right, ...); () is
detached. In contact u = d - f is prescribed, so the free surfaces (two tails, and a gap between
neighbouring contacts) do not feel each other, and each is followed by itself. Pressed
(pressed_surface.py), lines advance to the first place where they rest, a contact begins where the
free surface touches the profile, and lines that meet close their gap. Retracted, lines recede to
the first place where they rest, and contacts whose lines meet are gone.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from discretization.certificate import NotCertifiedError, worst
from discretization.fitted.line_search import MET, EquilibriumFinder, Pair
from discretization.fitted.pressed_surface import MOST_CHANGES, Lines, PressedSurface, pairs
from discretization.fitted.rest_depths import SIDES, TIE, ULPS, RestDepths, surfaces_of
from discretization.profile import Resolved
from discretization.surfaces.protocol import LineState, Surfaces
from energy import Scene
from energy.arrays import Array, Mask


class LineStateRows(NamedTuple):
    """Evidence for the certificate, of the lines of free surfaces, as of one line in `LineState`.

    Attributes
    ----------
    free : ndarray of bool (n, 2)
    closing, bare, opening, moved : ndarray (n, 2)
    stable : ndarray of bool (n,)
        Of both lines together.
    """

    free: Mask
    closing: Array
    bare: Array
    opening: Array
    moved: Array
    stable: Mask


@dataclass(frozen=True, eq=False)
class ContactLines:
    """What moves the contact lines of a scene.

    Attributes
    ----------
    scene : Scene
    profile : Resolved
        Its profile.
    surfaces : Surfaces
        Its free surfaces.
    rests : RestDepths
        Where lines rest.
    """

    scene: Scene
    profile: Resolved
    surfaces: Surfaces
    rests: RestDepths

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, depth: float) -> ContactLines:
        """What moves the lines of a scene, for depths up to one.

        Parameters
        ----------
        scene : Scene
        profile : Resolved
            Its profile.
        depth : float
            The largest depth [length].

        Returns
        -------
        ContactLines
        """
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
    def pressed_surface(self) -> PressedSurface:
        """What moves the lines of one free surface."""
        return PressedSurface(EquilibriumFinder(self.rests))

    def adhered(self, depth: float) -> Lines:
        """The state of the path that touches first and then moves to this depth.

        Parameters
        ----------
        depth : float
            [length].

        Returns
        -------
        tuple of float
            Both ends of every contact [length]; () without contact.

        Raises
        ------
        NotCertifiedError
            If the lines do not come to rest.
        ValueError
            If a line leaves the known profile.
        """
        touch = self.profile.touch
        if depth < touch and not self.scene.opened.work_of_adhesion:
            return ()
        lines = self.first()
        return self.pressed(lines, touch, depth) if depth >= touch else self.relaxed(lines, depth)

    def settled(self, lines: Lines, depth: float) -> Lines:
        """Lines that are near a state at rest, moved to it.

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        depth : float
            [length].

        Returns
        -------
        tuple of float
            [length]; () without contact.

        Raises
        ------
        NotCertifiedError, ValueError
            As `adhered`.
        """
        kept = self.retracted(lines, depth)
        if not kept:
            return () if depth < self.profile.touch else self.adhered(depth)
        return self.pressed(kept, depth, depth)

    def penetration(self, lines: Lines, depth: float) -> float:
        """How far the profile sticks through the free surfaces, at worst [length].

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        depth : float
            [length].

        Returns
        -------
        float
            [length], 0 if the surfaces are clear of it.
        """
        parts = free_surface_lines(lines)
        clearances = [
            self.pressed_surface.least_clearance(pair, depth, exact=True)[0] for pair in parts
        ]
        return worst(*(-clearance for clearance in clearances))

    def pointed(self, x: float) -> bool:
        """Whether a contact of the one point x stands for one too narrow for doubles: never here.

        Only a convex profile alone has such a contact (single_contact.py).
        """
        return False

    def line_states(self, lines: Lines, depth: float) -> list[LineState]:
        """Evidence for the certificate, of every line from left to right.

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        depth : float
            [length].

        Returns
        -------
        list of LineState
        """
        x = np.array(free_surface_lines(lines))
        if self.scene.axisymmetric and not lines[0]:
            x[0, 1] = math.inf  # a contact around the axis has no line there
        points = np.isin(x, [left for left, right in pairs(lines) if left == right])
        single = len(lines) == 2 and self.scene.indenter.convex
        found = self.line_state_rows(x, points, single=single)
        size = np.full_like(x, self.rests.size)
        stable = np.broadcast_to(found.stable[:, None], x.shape)
        columns = (
            x,
            found.free,
            found.closing,
            found.bare,
            found.opening,
            size,
            found.moved,
            stable,
        )
        rows = zip(*(column.ravel().tolist() for column in columns), strict=True)
        return [LineState(*row) for row in rows if math.isfinite(row[0])]

    def line_state_rows(self, x: Array, points: Mask, *, single: bool = False) -> LineStateRows:
        """Evidence of the lines of free surfaces.

        D of free lines is off by the rounding of their places, and by that of narrow gaps. Pinned
        are lines at corners, edges of the body, and beside those of a pattern.

        Parameters
        ----------
        x : ndarray (n, 2)
            Both lines of every surface [length], infinite where there is none.
        points : ndarray of bool (n, 2)
            Which of them are those of contacts of one point.
        single : bool
            Whether they are the lines of the only contact.

        Returns
        -------
        FeltRows
        """
        rests = self.rests
        free = self._free(x)
        with np.errstate(invalid="ignore"):
            rounding = np.where(free, ULPS * np.spacing(np.abs(x)), 0.0) * SIDES
        # A contact next to an end of the profile may be narrower than these roundings.
        known = self.scene.indenter.extent
        outside = np.where(free, np.clip(x + rounding, *known), x)
        inside = np.where(free, np.clip(x - rounding, *known), x)
        noise = rests.noise(x)[:, None]
        closing = rests.ahead(outside, 1) + noise
        bare = rests.one_sided(SIDES, outside, outside[:, ::-1], 1, 1, adheres=False) + noise
        opening = rests.ahead(inside, -1) - noise
        opening[points] = -math.inf
        rates = rests.with_rates(x, rests.between_corners(x, 1), 1)[1]
        rates = np.where(np.isfinite(rates), rates, 0.0)
        moved, stable = rests.condition(rates, free, single=single)
        return LineStateRows(free, closing, bare, opening, moved, stable)

    def _free(self, x: Array) -> Mask:
        """Which lines (n, 2) are not pinned."""
        edges = self.profile.edges
        beside_edges = np.nextafter(edges, -math.inf)
        walls = self.profile.indenter.walls
        pinning = [*self.profile.corners, *walls, *edges, *beside_edges]
        return np.isfinite(x) & ~np.isin(x, pinning)

    def forces_opening_corners(self, corners: Array) -> Array:
        """Forces that would open contacts at corners, beyond what lines hold there.

        Parameters
        ----------
        corners : ndarray (n,)
            All corners of the profile [length].

        Returns
        -------
        ndarray (n,)
            [force/length]; negative where the corner stays closed.
        """
        return self.scene.gamma1 * (self.profile.falls(self.scene.slopes) - self.holds(corners))

    def opening(self, lines: Lines, depth: float) -> list[float]:
        """Forces that would open contacts: where they do not adhere, and at corners.

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        depth : float
            [length].

        Returns
        -------
        list of float
            [force/length].
        """
        scene = self.scene
        search = self.pressed_surface.search
        ends = np.array(lines)
        unit = scene.stiffness * scene.elastocapillary_length
        without_adhesion = self.bare(ends.reshape(-1, 2))
        forces = [unit * search.pull(*part, depth).force for part in without_adhesion]
        corners = self.profile.corners
        if corners.size and not scene.indenter.convex:
            # Inside a contact, not at its end, is a corner with odd numbers of lines to its left,
            # lines at the corner itself counted or not.
            inside = np.searchsorted(ends, corners) & np.searchsorted(ends, corners, "right")
            forces += self.forces_opening_corners(corners)[inside % 2 == 1].tolist()
        return forces

    def first(self) -> Lines:
        """The state at first touch."""
        touch = self.profile.touch
        lowest = self.profile.lowest
        return self.pressed((lowest, lowest), touch, touch)

    def pressed(self, lines: Lines, start: float, end: float) -> Lines:
        """Lines at rest at the depth `start`, taken to the depth `end` >= start.

        Where a contact begins is known to a tolerance (pressed_surface.py): lines that went too far
        for it recede.
        """
        found: list[float] = []
        for pair in free_surface_lines(lines):
            found += self.pressed_surface.advance(*pair, start, end)
        return self.relaxed(tuple(found[1:-1]), end)

    def relaxed(self, lines: Lines, depth: float) -> Lines:
        """Lines that recede as far as they must, and gaps that open.

        Gaps open inside contacts without a barrier: at a corner at which the slope falls by more
        than two lines hold, and without adhesion where the profile would pull at the surface.
        """
        lines = self.retracted(lines, depth)
        for _ in range(MOST_CHANGES):
            gaps = {pair: self._opening_gap(*pair, depth) for pair in pairs(lines)}
            if not any(gaps.values()):
                return lines
            torn: list[float] = []
            for (left, right), gap in gaps.items():
                torn += left, *gap, right
            lines = self.retracted(tuple(torn), depth)
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def _opening_gap(self, left: float, right: float, depth: float) -> Lines:
        """The lines of a gap that opens in a contact by itself; () if nowhere."""
        search = self.pressed_surface.search
        torn = search.opening_corners(left, right, depth, self.holds(self.profile.corners))
        if torn.size:
            corner = float(torn[0])
            aside = MET * self.scene.elastocapillary_length
            return corner - aside, corner + aside
        for start, end in self.bare(np.array([[left, right]])):
            found = search.pull(start, end, depth)
            if found.force > search.least_pull(depth):
                return found.ends
        return ()

    def holds(self, x: Array) -> Array:
        """The kinks that both lines of a closed gap hold: 2 √(2w/γ₁), or as angles with finite
        slopes.

        Parameters
        ----------
        x : ndarray (n,)
            Positions [length].

        Returns
        -------
        ndarray (n,)
        """
        w = self.scene.opened.work_of_adhesion
        pattern = self.scene.pattern
        least = np.ones_like(x)
        if pattern is not None:  # the gap opens to the side that adheres less
            on_left = pattern.factor(np.nextafter(x, -math.inf))
            on_right = pattern.factor(np.nextafter(x, math.inf))
            least = np.minimum(on_left, on_right)
        half = np.sqrt(w * least / (2 * self.scene.gamma1))
        return 4 * half if self.scene.slopes == "small" else 4 * np.arcsin(half)

    def bare(self, contacts: Array) -> list[Pair]:
        """The parts of contacts that do not adhere: all where w = 0, or bare patches of a pattern.

        Parameters
        ----------
        contacts : ndarray (m, 2)
            Ends of the contacts [length].

        Returns
        -------
        list of pairs of float
            Their ends [length].
        """
        if not self.scene.opened.work_of_adhesion:
            return [(left, right) for left, right in contacts.tolist() if left < right]
        if self.scene.pattern is None:
            return []
        edges = [-math.inf, *self.scene.pattern.edges, math.inf]
        found = []
        for (start, end), factor in zip(pairwise(edges), self.scene.pattern.factors, strict=True):
            if factor:
                continue
            for left, right in contacts.tolist():
                first = max(start, left)
                last = min(end, right)
                if first < last:
                    found.append((first, last))
        return found

    def retracted(self, lines: Lines, depth: float) -> Lines:
        """Lines taken to a smaller depth, without the contacts that are lost.

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        depth : float
            [length].

        Returns
        -------
        tuple of float
            [length].
        """
        while lines:
            receded = self._receded(lines, depth)
            kept = self.unpulled(self._closed(receded), depth)
            if len(kept) == len(lines):
                return kept
            lines = kept
        return lines

    def _receded(self, lines: Lines, depth: float) -> Lines:
        """Lines after each has receded as far as it must; those of a contact may cross."""
        surfaces = np.array(free_surface_lines(lines))
        contacts = free_surface_lines((-math.inf, *lines, math.inf))
        behind = np.where(np.isfinite(surfaces), self.rests.ahead(surfaces, -1), -math.inf)
        recedes = (behind - depth > TIE * self.rests.size).any(axis=1)
        for i in np.flatnonzero(recedes).tolist():
            left_limit, left = contacts[i]  # the contact on the left of the surface
            right, right_limit = contacts[i + 1]
            search = self.pressed_surface.search
            surfaces[i] = search.recede(left, right, left_limit, right_limit, depth)
        return tuple(surfaces.ravel().tolist()[1:-1])

    def _closed(self, lines: Lines) -> Lines:
        """Lines of contacts that are left: those at a corner remain there where they cross."""
        sharp = [*self.profile.corners, *self.profile.indenter.walls]
        kept: list[float] = []
        for left, right in pairs(lines):
            corners = [x for x in (left, right) if x in sharp]
            if left <= right:
                kept += left, right
            elif corners:
                kept += corners[0], corners[0]
        return tuple(kept)

    def unpulled(self, lines: Lines, depth: float) -> Lines:
        """Lines without contacts of one point that are pulled: without them the surface is clear.

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        depth : float
            [length].

        Returns
        -------
        tuple of float
            [length].
        """
        kept: list[float] = []
        for (before, left), (right, beyond) in pairwise(free_surface_lines(lines)):
            if left < right or not self._pulled(left, (before, beyond), depth):
                kept += left, right
        return tuple(kept)

    def _pulled(self, x: float, beside: Pair, depth: float) -> bool:
        """Whether a contact of one point is pulled: the surface without it is clear there."""
        left, right = (self.rests.at(end) for end in beside)
        u, _ = self.rests.surfaces.shape(np.array(x), left, right, depth)
        f = float(self.profile.indenter.height(x))
        displacements = [abs(depth - line.f) for line in (left, right) if line]
        size = max(abs(depth), abs(f), *displacements)
        clearance = u - depth + f
        return bool(clearance > TIE * size)


def free_surface_lines(lines: Sequence[float]) -> list[Pair]:
    """The lines of every free surface from left to right, infinite where there is none.

    Parameters
    ----------
    lines : sequence of float
        Both ends of every contact [length].

    Returns
    -------
    list of pairs of float
        The left and the right line of each surface [length].
    """
    return pairs((-math.inf, *lines, math.inf))
