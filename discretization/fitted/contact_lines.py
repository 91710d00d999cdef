"""States of the fitted mesh: contact lines that move downhill in energy as the depth changes.

A state is the tuple of its lines from left to right, (left, right, left, right, ...); () is
detached. In contact u = d - f is prescribed, so the free surfaces (two tails, and a gap between
neighbouring contacts) do not feel each other, and each is followed by itself. Pressed
(pressed_surface.py), lines advance to the first place where they rest, a contact begins where the
free surface touches the profile, and lines that meet close their gap. Retracted, lines recede to
the first place where they rest, and contacts whose lines meet are gone.

Conventions
-----------
The depth d of the indenter, the rest depth D(x), at which a line at x would be in equilibrium, and
the displacement u of the surface are positive down into the layer, heights f of the profile upwards
[length]. A line advances where D < d and recedes where D > d.

Lines stand in three layouts. `Lines`, the state, is flat: both ends of every contact, from left to
right. `free_surface_lines` turns it into pairs of the lines of every free surface, from left to
right: (-inf, left end of the first contact), (right end of the first, left end of the second), ...,
(right end of the last, inf). As an array (n, 2) these have the left lines of surfaces in column 0,
whose contact is on their left and whose `SIDES` is 1, and the right ones in column 1, with -1.

About an axis x is the radius; the left end of a contact around the axis is 0, which is no line.

`RestDepths.ahead(lines, direction)` is D just ahead of lines, with 1 outwards of the contact with
the adhesion of a contact that closes, with -1 inwards with that of one that opens;
`RestDepths.noise` is what D may be off by. `EquilibriumFinder.recede` moves both lines of a surface
to the first places where they rest at a depth; a line that rests nowhere before the other one of
its contact is then beyond that. `Pull` has the place and the force of where the profile would pull
at the surface in contact. `LineState` is the evidence of one line for the certificate.

Of the scene, l = √(γ₁/k) is `elastocapillary_length`, δ₀ = √(2w/k) `critical_separation`, and
`opened` the same scene with the work of adhesion of contacts that open. Of its indenter, `extent`
are the ends of the known profile and `walls` those of them at which the body itself ends. Of its
pattern, `factor(x)` is what w is multiplied by at x, `factors` are these from left to right, one
more than there are `edges`.

`PressedSurface.advance` takes the two lines of a surface from one depth to another and returns
those of all surfaces that it has become; its `least_clearance` is how far the surface stays above
the profile, negative inside it, with the place, and its `search` an `EquilibriumFinder`. Of that,
`pull(left, right, depth)` is the `Pull` between two places, with its force over kl, `least_pull`
the force over kl that opens a gap, and `opening_corners` are the corners between two places at
which a gap opens by itself. MET is half the width over l of a gap that has just opened, TIE what is
rounding of D over the size of depths, ULPS to how many roundings a line is found.

Of `RestDepths`, `one_sided(side, x, facing, aside, direction, adheres)` is D just outwards (aside
1) or inwards (-1) of lines; `with_rates` are D and its derivatives, (n, 2, 2), within the places
between which no corner is passed (`between_corners`); `condition` is how far lines move over what D
is off by, and whether they are stable.

A `Pair` is two places, (left, right). `surfaces_of` are the free surfaces of a scene, with small or
finite slopes; `Surfaces.shape(x, left, right, depth)` is u at x and its slope. Forces are given
over kl, with the stiffness k per area, where they are compared with depths. MOST_CHANGES limits how
often contacts open one after the other at one depth.
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
    """Evidence for the certificate, of the left and right lines (columns) of n free surfaces.

    The meaning is that of the attributes of `LineState`, which has one line.

    Attributes
    ----------
    free : ndarray of bool (n, 2)
        Whether a line is not pinned.
    closing : ndarray (n, 2)
        D just outside, of a contact that closes [length].
    bare : ndarray (n, 2)
        The same without adhesion.
    opening : ndarray (n, 2)
        D just inside, of a contact that opens; -inf for a contact of one point [length].
    moved : ndarray (n, 2)
        How far a line moves over what D of both lines is off by.
    stable : ndarray of bool (n,)
        Whether D grows outwards, of both lines together.
    """

    free: Mask
    closing: Array
    bare: Array
    opening: Array
    moved: Array
    stable: Mask


@dataclass(frozen=True, eq=False)
class ContactLines:
    """Moves the contact lines of a scene as the depth changes.

    Attributes
    ----------
    scene : Scene
    profile : Resolved
        Its profile, with the samples that resolve it.
    surfaces : Surfaces
        Its free surfaces, of which lines give energy, forces and shape.
    rests : RestDepths
        The depths at which lines rest.
    """

    scene: Scene
    profile: Resolved
    surfaces: Surfaces
    rests: RestDepths

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, depth: float) -> ContactLines:
        """The lines of a scene, for depths up to one.

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
        size = size or scene.layer.h  # without adhesion, at the depth 0 of first touch
        return cls(scene, profile, surfaces, RestDepths(scene, profile, surfaces, size))

    @property
    def gradual(self) -> bool:
        """Whether lines never jump: D grows outwards in a line contact of a convex profile."""
        scene = self.scene
        return scene.indenter.convex and not scene.axisymmetric and scene.pattern is None

    @functools.cached_property
    def pressed_surface(self) -> PressedSurface:
        """Moves the lines of one free surface as the indenter is pressed."""
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
        # Without adhesion nothing is pulled up to a profile above the surface.
        if depth < touch and not self.scene.opened.work_of_adhesion:
            return ()
        lines = self.first()
        return self.pressed(lines, touch, depth) if depth >= touch else self.relaxed(lines, depth)

    def settled(self, lines: Lines, depth: float) -> Lines:
        """Lines that are near a state at rest, moved to it: first they recede, then they advance.

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
            # From first touch on the flat surface is no state: it would be inside the profile.
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
        return [
            LineState(
                x=float(x[i, j]),
                free=bool(found.free[i, j]),
                closing=float(found.closing[i, j]),
                bare=float(found.bare[i, j]),
                opening=float(found.opening[i, j]),
                size=self.rests.size,
                moved=float(found.moved[i, j]),
                stable=bool(found.stable[i]),
            )
            for i, j in np.argwhere(np.isfinite(x)).tolist()
        ]

    def line_state_rows(self, x: Array, points: Mask, *, single: bool = False) -> LineStateRows:
        """Evidence of the lines of free surfaces.

        A free line is found to a few roundings of its place, and D of the lines of narrow gaps is
        off by `noise`; both are granted: D is read so far outside of the line and so far inside of
        it. Pinned are lines at corners, at edges of the body, and at or beside those of a pattern.

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
        LineStateRows
        """
        rests = self.rests
        free = self._free(x)
        with np.errstate(invalid="ignore"):
            rounding = np.where(free, ULPS * np.spacing(np.abs(x)), 0.0) * SIDES
        # Beyond the known profile nothing can be read; a line may rest within roundings of its end.
        known = self.scene.indenter.extent
        outside = np.where(free, np.clip(x + rounding, *known), x)
        inside = np.where(free, np.clip(x - rounding, *known), x)
        noise = rests.noise(x)[:, None]
        closing = rests.ahead(outside, 1) + noise
        bare = rests.one_sided(SIDES, outside, outside[:, ::-1], 1, 1, adheres=False) + noise
        opening = rests.ahead(inside, -1) - noise
        opening[points] = -math.inf  # a point cannot recede any further
        rates = rests.with_rates(x, rests.between_corners(x, 1), 1)[1]
        rates = np.where(np.isfinite(rates), rates, 0.0)
        moved, stable = rests.condition(rates, free, single=single)
        return LineStateRows(free, closing, bare, opening, moved, stable)

    def _free(self, x: Array) -> Mask:
        """Which lines (n, 2) exist and are not pinned."""
        edges = self.profile.edges
        beside_edges = np.nextafter(edges, -math.inf)
        walls = self.profile.indenter.walls
        pinning = [*self.profile.corners, *walls, *edges, *beside_edges]
        return np.isfinite(x) & ~np.isin(x, pinning)

    def forces_opening_corners(self, corners: Array) -> Array:
        """Forces that would open contacts at corners, beyond what adhesion holds there.

        A gap opens where the slope falls by more than the kinks of its two lines hold; γ₁ times a
        slope is a force per length.

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
        """Forces that would open contacts: where they do not adhere, and at corners inside them.

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        depth : float
            [length].

        Returns
        -------
        list of float
            [force/length]; 0 or negative where nothing opens.
        """
        scene = self.scene
        search = self.pressed_surface.search
        ends = np.array(lines)
        unit = scene.stiffness * scene.elastocapillary_length
        without_adhesion = self.bare(ends.reshape(-1, 2))
        forces = [unit * search.pull(*part, depth).force for part in without_adhesion]
        corners = self.profile.corners
        if corners.size and not scene.indenter.convex:
            # A corner is inside a contact, and not at its end, if the number of lines to its left
            # is odd, whether lines at the corner itself are counted or not.
            inside = np.searchsorted(ends, corners) & np.searchsorted(ends, corners, "right")
            forces += self.forces_opening_corners(corners)[inside % 2 == 1].tolist()
        return forces

    def first(self) -> Lines:
        """The state at first touch, where the first contact has spread from the lowest point."""
        touch = self.profile.touch
        lowest = self.profile.lowest
        return self.pressed((lowest, lowest), touch, touch)

    def pressed(self, lines: Lines, start: float, end: float) -> Lines:
        """Lines at rest at the depth `start`, taken to the depth `end` >= start.

        The depth at which a contact begins is known to a tolerance (pressed_surface.py). Lines that
        have advanced a little too far since it began too early recede in the end.

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        start, end : float
            [length].

        Returns
        -------
        tuple of float
            [length].
        """
        found: list[float] = []
        for pair in free_surface_lines(lines):
            found += self.pressed_surface.advance(*pair, start, end)
        of_contacts = found[1:-1]  # without the lines of the tails at infinity
        return self.relaxed(tuple(of_contacts), end)

    def relaxed(self, lines: Lines, depth: float) -> Lines:
        """Lines that recede as far as they must, and gaps that open.

        Gaps open inside contacts without a barrier: at a corner at which the slope falls by more
        than two lines hold, and without adhesion where the profile would pull at the surface. Each
        that opens may let others open; it ends where none does.

        Parameters
        ----------
        lines : tuple of float
            Both ends of every contact [length].
        depth : float
            d [length].

        Returns
        -------
        tuple of float
            [length].
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
        """The left and the right line of a gap that opens in a contact by itself; () if none does.

        The contact has its ends at `left` and `right`. Of several gaps it is one; the others follow
        when the parts of the contact are looked at again.
        """
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
        """By how much the slope may fall at a corner in contact before a gap opens there.

        Each of the two lines that would begin there holds a kink √(2w/γ₁) against opening, so it is
        2 √(2w/γ₁); with finite slopes an angle β with 2γ₁ sin²(β/2) = w, 2 · 2 arcsin √(w/2γ₁).

        Parameters
        ----------
        x : ndarray (n,)
            Positions [length].

        Returns
        -------
        ndarray (n,)
            Differences of slopes, or angles [rad].
        """
        w = self.scene.opened.work_of_adhesion
        pattern = self.scene.pattern
        least = np.ones_like(x)
        if pattern is not None:  # the gap opens to the side that adheres less
            on_left = pattern.factor(np.nextafter(x, -math.inf))
            on_right = pattern.factor(np.nextafter(x, math.inf))
            least = np.minimum(on_left, on_right)
        # √(2w/γ₁) = 2 sine, with the sine of β/2.
        sine = np.sqrt(w * least / (2 * self.scene.gamma1))
        return 4 * sine if self.scene.slopes == "small" else 4 * np.arcsin(sine)

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
        """Lines that have receded as far as they must at a depth, without the contacts lost.

        A contact that is lost changes the free surfaces beside it, so that others may have to
        recede further; it ends where none is lost any more.

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
        """Lines after those of each surface have receded as far as they must; same layout.

        Where no line of a surface has to recede both stay as they are, to the last bit. Lines of a
        contact that is lost have crossed: its left one is then greater than its right one.

        lines: both ends of every contact [length]; depth: d [length].
        """
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
        """Lines without contacts whose lines have crossed.

        Where one of these lines is at a corner or an edge of the body, a contact of that point is
        left, as D jumps there and may hold it; `unpulled` judges whether it does.
        """
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
        """Whether a contact of one point is pulled: the surface without it is clear there.

        Parameters
        ----------
        x : float
            Where it is [length].
        beside : tuple of float
            The lines of the surface without it: the next ones on its left and on its right,
            infinite where there is none [length].
        depth : float
            d [length].
        """
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
