"""The certificate of the states of a path, many of them at once (conditions: ../certificate.py).

Without adhesion a contact may open inside: those states are judged one by one (fitted/contacts.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discretization.certificate import ROUNDING, Certificate
from discretization.fitted.contact_lines import ContactLines
from discretization.fitted.contacts import Contacts, certify
from discretization.fitted.rest_depths import displacement_scale
from discretization.refine.clearance import least_gaps
from discretization.refine.equations import Equations, free_surfaces
from energy.arrays import Array, Mask, Nodes

Lines = tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Judge:
    """What judges states with small slopes by the sizes of the whole path.

    Attributes
    ----------
    equations : Equations
    contact_lines : ContactLines
    """

    equations: Equations
    contact_lines: ContactLines

    def certificates(self, states: Sequence[tuple[Lines, float]]) -> list[Certificate]:
        """The certificates of states in contact.

        Parameters
        ----------
        states : sequence of (tuple of float, float)
            The 2m lines of each, from left to right, and its depth [length].

        Returns
        -------
        list of Certificate
        """
        if not states:
            return []
        if not self.contact_lines.scene.opened.work_of_adhesion:
            found = [Contacts(self.contact_lines, *state) for state in states]
            return [certify(contacts, contacts.totals()) for contacts in found]
        surfaces = [free_surfaces(lines) for lines, _ in states]
        counts = np.array([len(rows) for rows in surfaces])
        first = np.cumsum(counts) - counts
        depth = np.array([depth for _, depth in states])
        rows = np.concatenate(surfaces)
        return self._of_rows(rows, first, np.repeat(depth, counts), depth)

    def _of_rows(
        self, rows: Array, first: Nodes, depths: Array, of_state: Array
    ) -> list[Certificate]:
        """Of states whose surfaces stand next to each other in rows (n, 2), the first ones here.

        depths (n,); of_state: the same of each state.
        """
        scene = self.contact_lines.scene
        size = self.contact_lines.rests.size
        scale = np.array([displacement_scale(scene, depth, size) for depth in of_state.tolist()])
        points = self._points(rows, first)
        line_states = self.contact_lines.line_state_rows(rows, points)
        at = np.where(np.isfinite(rows), depths[:, None], -np.inf)

        def worst(values: Array) -> Array:
            """Of each state, of values (n, 2) of its lines."""
            return np.asarray(np.maximum.reduceat(values.max(axis=1), first))

        closing = worst(at - line_states.closing)
        bare = worst(at - line_states.bare)
        opening = worst(np.where(np.isfinite(rows), line_states.opening - depths[:, None], -np.inf))
        through = np.where(closing > ROUNDING * size, bare, closing)
        terms = scale + worst(self._steepness(rows))
        beyond = np.maximum.reduceat(-least_gaps(self.equations, rows, depths), first)
        # pinned by another work of adhesion than what moves them, or the energy is convex
        kept = scene.hysteretic or not scene.work_of_adhesion
        firm = np.logical_and.reduceat(line_states.stable | kept, first)
        neighbours = np.maximum(np.maximum(closing, opening) / terms, ~firm)
        columns = (
            np.maximum(through / terms, beyond / scale),
            np.zeros(of_state.size),  # free surfaces are solved in closed form
            self._tension(rows, first, depths, points) / scale,
            neighbours,
            self._off_force(rows, first, depths),
        )
        table = np.maximum(0.0, np.column_stack(columns))
        return [Certificate(*row) for row in table.tolist()]

    def _points(self, rows: Array, first: Nodes) -> Mask:
        """Which lines (n, 2) are those of contacts of one point."""
        found = np.zeros(rows.shape, bool)
        lone = rows[:-1, 1] == rows[1:, 0]
        found[:-1, 1] = lone
        found[1:, 0] = lone
        return found

    def _steepness(self, rows: Array) -> Array:
        """l |f'| at lines (n, 2), at corners the larger one."""
        line = np.isfinite(rows)
        at = np.where(line, rows, self.equations.profile.lowest)
        sides = (-1, 1) if len(self.contact_lines.scene.indenter.corners) else 0
        slopes = self.contact_lines.scene.indenter.slope_beside(at[..., None], sides)
        steep = np.abs(slopes).reshape(*rows.shape, -1).max(axis=2)
        return np.where(line, self.equations.length * steep, -np.inf)

    def _tension(self, rows: Array, first: Nodes, depths: Array, points: Mask) -> Array:
        """The largest force over kl that would open a contact of each state."""
        pulls = self.equations.pulls(rows, depths)
        lone = np.where(points[:-1, 1], -(pulls[:-1, 1] + pulls[1:, 0]), 0.0)
        found = np.maximum.reduceat(np.append(lone, 0.0), first)
        corners = self.equations.profile.corners
        over = self.contact_lines.forces_opening_corners(corners)
        unit = self.contact_lines.scene.stiffness * self.equations.length
        for corner, force in zip(corners[over > 0], over[over > 0], strict=True):
            inside = np.append(rows[:-1, 1], np.inf) < corner
            inside &= corner < np.append(rows[1:, 0], -np.inf)
            in_contact = np.logical_or.reduceat(inside, first)
            found = np.maximum(found, in_contact * force / unit)
        return np.asarray(found)

    def _off_force(self, rows: Array, first: Nodes, depths: Array) -> Array:
        """dU/dd against k∫u of each state, as γ₁ times the change of u' over its free surfaces.

        Both with the same integral over contacts, over the size of what they are summed from.
        """
        equations = self.equations
        pulls = equations.pulls(rows, depths)
        has_line = np.isfinite(rows)
        surface, _ = np.nonzero(has_line)
        slopes = np.zeros(rows.shape)
        _, slopes[has_line] = equations.surface(rows[has_line], surface, rows, depths)
        by_field = equations.length * (slopes * (-1.0, 1.0)).sum(axis=1)
        off = np.add.reduceat(pulls.sum(axis=1) - by_field, first)

        of_surfaces = np.abs(pulls).sum(axis=1)
        displaced = np.abs(equations.displaced(rows, depths)).max(axis=1)
        of_contacts = displaced * equations.length
        size = np.add.reduceat(of_surfaces + of_contacts, first)
        return np.abs(off) / np.where(size > 0, size, 1.0)
