"""Any number of contacts on the fitted mesh (small slopes): their lines, energy and force.

In contact u = d - f is prescribed, so the free surfaces are independent of each other: two tails,
each with one line (lines.py), and gaps, each with two (gap_lines.py).
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.gap_lines import Gap, LostLineError, Search, lines_of_gap, settled
from discretization.fitted.lines import FittedLine, Problem
from discretization.fitted.quadrature import Interval, refined

Array = NDArray[np.float64]
_STEP = 0.25  # of the lattice's spacing, for the first step of a search
_SLACK = 2.0
_TIE = 1e-12


@dataclass(frozen=True, eq=False)
class FittedContacts:
    """Contacts of a problem from left to right: the left and the right line of each."""

    problem: Problem
    pairs: tuple[tuple[FittedLine, FittedLine], ...]

    @property
    def x(self) -> Array:
        """Ends of each contact (m, 2)."""
        return np.array([[left.x, right.x] for left, right in self.pairs])

    @property
    def gaps(self) -> list[tuple[FittedLine, FittedLine]]:
        """Both lines of each gap."""
        return [(a[1], b[0]) for a, b in itertools.pairwise(self.pairs)]

    @property
    def outer(self) -> tuple[tuple[int, FittedLine], tuple[int, FittedLine]]:
        """(side, line) of the outermost lines."""
        return (-1, self.pairs[0][0]), (1, self.pairs[-1][1])

    @functools.cached_property
    def reactions(self) -> Array:
        """What the free surfaces pull at both lines of each contact, S [γ₁] (m, 2)."""
        problem, own = self.problem, Gap(self.problem)
        sums, length = np.zeros((len(self.pairs), 2)), problem.scene.elastocapillary_length
        for column, (_, line) in enumerate(self.outer):
            u0 = problem.displaced(line.x) / length
            sums[-column, column] = problem.response.reaction(u0)
        for i, (q, p) in enumerate(self.gaps):
            sums[i, 1], sums[i + 1, 0] = own.reactions(q.x, p.x)
        return sums

    @property
    def pulled(self) -> NDArray[np.bool_]:
        """Which contacts are a point, which does not adhere, and are pulled (m,)."""
        lone, pull = self.x[:, 0] == self.x[:, 1], self.reactions.sum(axis=1)
        size = (
            np.abs(self.reactions).sum(axis=1)
            + self.problem.lift / self.problem.scene.elastocapillary_length
        )
        return lone & (pull < -_TIE * size)


def fitted_contacts(problem: Problem, near: Array, spacing: float) -> FittedContacts:
    """The lines in equilibrium near those of a lattice (m, 2).

    LostLineError where a contact of the lattice is none, or two of them are one.
    """
    indenter = problem.scene.indenter
    corners, (lo, hi) = np.asarray(indenter.corners, float), indenter.extent
    slack = _SLACK * spacing

    def search(side: int, contact: Array, outer: float, room: float = math.inf) -> Search:
        left, right = contact.tolist()
        start, inner = (
            (right, max(left - slack, lo)) if side > 0 else (left, min(right + slack, hi))
        )
        step = _STEP * min(spacing, room)
        return Search(side, start, step, inner, outer, corners, indenter.walls)

    def outermost(side: int, contact: Array, end: float) -> FittedLine:
        return settled(
            lambda x, aside: problem.drive(side, x, aside), problem.held, search(side, contact, end)
        )

    lines = [outermost(-1, near[0], lo)]
    for one, other in itertools.pairwise(near):
        room = float(other[0] - one[1])
        left = search(1, one, float(other[1]), room)
        right = search(-1, other, float(one[0]), room)
        lines += lines_of_gap(Gap(problem), left, right)
    lines.append(outermost(1, near[-1], hi))
    pairs = tuple(zip(lines[::2], lines[1::2], strict=True))
    for first, last in pairs:
        if first.x > last.x:
            raise LostLineError(f"the contact at x = {first.x!r} has let go")
    return FittedContacts(problem, pairs)


def totals(contacts: FittedContacts, rtol: float) -> tuple[Interval, Interval]:
    """Energy and force by fewer and by more Gauss points, on panels halved until both agree."""
    scene, depth = contacts.problem.scene, contacts.problem.depth
    indenter = scene.indenter
    apex = () if indenter.apex is None else (indenter.apex,)
    cuts = np.unique(np.concatenate([indenter.corners, indenter.knots, apex]))
    parts = [
        np.concatenate([[left], cuts[(cuts > left) & (cuts < right)], [right]])
        for left, right in contacts.x.tolist()
    ]
    panels = np.concatenate([np.column_stack([part[:-1], part[1:]]) for part in parts])
    return refined(scene, depth, panels, _surfaces(contacts), rtol)


def _surfaces(contacts: FittedContacts) -> tuple[float, float, float, float]:
    """Of all free surfaces: energy, reactions, areas (times k), and absolute reactions."""
    problem, scene = contacts.problem, contacts.problem.scene
    length, own, energy, area = scene.elastocapillary_length, Gap(problem), 0.0, 0.0
    for _, line in contacts.outer:
        u0 = problem.displaced(line.x) / length
        energy += problem.response.energy(u0)
        area += problem.response.area(u0)
    for q, p in contacts.gaps:
        energy += own.energy(q.x, p.x)
        area += own.area(q.x, p.x)
    pull = contacts.reactions
    pulls = float(np.abs(pull).sum())
    gamma1 = scene.gamma1
    return gamma1 * length * energy, gamma1 * float(pull.sum()), gamma1 * area, gamma1 * pulls
