"""The certificate of the states of a path, many of them at once (conditions: ../certificate.py).

Without adhesion a contact may open inside: those states are judged one by one (fitted/contacts.py).

Conventions
-----------
Depths d grow as the indenter goes down. The free surfaces of s states stand next to each other in
rows, those of a state from left to right; a row is (left line, right line) [length], -inf and inf
where a tail has none. `first` (s,) are the numbers of the rows of the left tails, so that
`ufunc.reduceat(values, first)` is a value for each state; as a right tail has no right line and a
left tail no left one, what is formed of neighbouring rows of two states is never a contact.

D is the depth at which a line would rest (`ContactLines`): it advances where D < d, with the
adhesion of closing, and recedes where D > d, with that of opening. `Equations.pulls` are the forces
of surfaces at their lines over kl [length], positive where they press against the indenter.

`ContactLines.line_state_rows(rows, points)` has for every line D just outside it of a contact that
closes (`closing`), the same without adhesion (`bare`) and D just inside it of a contact that opens
(`opening`), and for every surface whether D grows outwards of both lines (`stable`);
`forces_opening_corners` for every corner the force that would open a contact there, 0 or less where
it stays closed [force/length]. `displacement_scale(scene, depth, size)` is the size of depths to
which violations are compared: the larger of |d| and δ₀, or more where the terms of D are so large,
`size`, that their rounding would count. ROUNDING, 16 roundings, is that of a sum of a dozen terms.
`least_gaps` are the least minima of the gaps of surfaces, negative where they are in the profile, 0
where there is none. `Contacts` and `certify` judge one state. `scene.hysteretic` is whether opening
takes another work of adhesion than closing, and `scene.opened` the scene with that of opening.
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
        The pulls and shapes of free surfaces.
    contact_lines : ContactLines
        The depths D at which lines would rest.
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
        depths = np.array([depth for _, depth in states])
        rows = np.concatenate(surfaces)
        return self._of_rows(rows, first, np.repeat(depths, counts), depths)

    def _of_rows(
        self, rows: Array, first: Nodes, depths: Array, depths_of_states: Array
    ) -> list[Certificate]:
        """The certificates of states with these rows (n, 2), their depths (n,), and depths (s,)."""
        scene = self.contact_lines.scene
        size = self.contact_lines.rests.size
        scale = np.array([displacement_scale(scene, d, size) for d in depths_of_states.tolist()])
        terms = scale + _worst(self._steepness(rows), first)  # of the terms that cancel in D
        points = self._points(rows)
        lines = self.contact_lines.line_state_rows(rows, points)

        # How much deeper than D of a line that closes the state is, and less deep than D of one
        # that opens. Without adhesion a line rests later, D₀ >= D.
        has_line = np.isfinite(rows)
        deep = np.where(has_line, depths[:, None], -np.inf)
        advances = _worst(deep - lines.closing, first)
        passes_through = _worst(deep - lines.bare, first)
        recedes = _worst(np.where(has_line, lines.opening - depths[:, None], -np.inf), first)
        # What is rounding where the line is judged with adhesion is rounding without it.
        through = np.where(advances > ROUNDING * size, passes_through, advances)
        beyond = np.maximum.reduceat(-least_gaps(self.equations, rows, depths), first)

        # Stable is any line that another work of adhesion holds than moves it, and any of a convex
        # energy.
        always_stable = scene.hysteretic or not scene.work_of_adhesion
        stable = np.logical_and.reduceat(lines.stable | always_stable, first)
        return _certificates(
            penetration=np.maximum(through / terms, beyond / scale),
            opening=self._tension(rows, first, depths, points) / scale,
            neighbours=np.maximum(np.maximum(advances, recedes) / terms, ~stable),
            force=self._off_force(rows, first, depths),
        )

    def _points(self, rows: Array) -> Mask:
        """Which lines (n, 2) are those of contacts of one point, where two neighbours meet.

        The right line of a surface and the left line of the next one are then at the same place.
        """
        found = np.zeros(rows.shape, bool)
        lone = rows[:-1, 1] == rows[1:, 0]
        found[:-1, 1] = lone
        found[1:, 0] = lone
        return found

    def _steepness(self, rows: Array) -> Array:
        """l |f'| at lines (n, 2) [length], at corners the larger one; -inf where is no line."""
        line = np.isfinite(rows)
        at = np.where(line, rows, self.equations.profile.lowest)
        sides = (-1, 1) if len(self.contact_lines.scene.indenter.corners) else 0
        slopes = self.contact_lines.scene.indenter.slope_beside(at[..., None], sides)
        steep = np.abs(slopes).reshape(*rows.shape, -1).max(axis=2)
        return np.where(line, self.equations.length * steep, -np.inf)

    def _tension(self, rows: Array, first: Nodes, depths: Array, points: Mask) -> Array:
        """The largest force over kl that would open a contact of each state (s,) [length].

        At contacts of one point, where the surfaces on both sides pull together, and at corners
        inside of contacts. At least 0.
        """
        pulls = self.equations.pulls(rows, depths)
        lone = np.where(points[:-1, 1], -(pulls[:-1, 1] + pulls[1:, 0]), 0.0)
        found = np.maximum.reduceat(np.append(lone, 0.0), first)
        corners = self.equations.profile.corners
        over = self.contact_lines.forces_opening_corners(corners)
        unit = self.contact_lines.scene.stiffness * self.equations.length
        for corner, force in zip(corners[over > 0], over[over > 0], strict=True):
            # The contact after each row, which is none after the last one of a state.
            inside = np.append(rows[:-1, 1], np.inf) < corner
            inside &= corner < np.append(rows[1:, 0], -np.inf)
            in_contact = np.logical_or.reduceat(inside, first)
            found = np.maximum(found, in_contact * force / unit)
        return np.asarray(found)

    def _off_force(self, rows: Array, first: Nodes, depths: Array) -> Array:
        """By how much dU/dd and k∫u of each state differ (s,), over the sizes of their terms.

        The contacts add the same to both. A free surface adds its pulls kl [σ u + τ (u - u_facing)]
        at both lines to dU/dd. To k∫u it adds γ₁ times the change of u' over it, as k u = γ₁ u''.
        All over kl [length].
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
        # Springs that are displaced as at the lines over a length l press with kl u.
        of_contacts = np.abs(equations.displaced(rows, depths)).max(axis=1)
        size = np.add.reduceat(of_surfaces + of_contacts, first)
        return np.abs(off) / np.where(size > 0, size, 1.0)


def _worst(values: Array, first: Nodes) -> Array:
    """The largest of values (n, 2) at the lines of each state (s,); -inf stands for no line."""
    return np.asarray(np.maximum.reduceat(values.max(axis=1), first))


def _certificates(
    penetration: Array, opening: Array, neighbours: Array, force: Array
) -> list[Certificate]:
    """The certificates of states, given how much each violates these conditions (s,).

    Less than 0 is no violation. Free surfaces are solved in closed form, so that no force is left
    on them: the violation of stationarity is 0.
    """
    none = np.zeros(penetration.size)
    violations = np.maximum(
        0.0, np.column_stack([penetration, none, opening, neighbours, force])
    ).tolist()
    return [
        Certificate(
            penetration=through,
            stationarity=left,
            opening=pulled,
            neighbours=moving,
            force=off,
        )
        for through, left, pulled, moving, off in violations
    ]
