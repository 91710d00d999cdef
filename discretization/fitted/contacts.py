"""Any number of contacts on the fitted mesh: their lines, energy and force.

In contact u = d - f is prescribed, so the free surfaces are independent of each other: two tails,
each with one line (lines.py), and gaps, each with two (gap_lines.py).
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.gap_lines import gap_of
from discretization.fitted.lines import FittedLine, Problem
from discretization.fitted.motion import Lines, Motion
from discretization.fitted.quadrature import Interval, refined
from energy import Indenter

Array = NDArray[np.float64]


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
        problem, own = self.problem, gap_of(self.problem)
        sums, length = np.zeros((len(self.pairs), 2)), problem.scene.elastocapillary_length
        for column, (_, line) in enumerate(self.outer):
            u0 = problem.displaced(line.x) / length
            sums[-column, column] = problem.response.reaction(u0)
        for i, (q, p) in enumerate(self.gaps):
            sums[i, 1], sums[i + 1, 0] = own.reactions(q.x, p.x)
        return sums


def fitted_contacts(problem: Problem, motion: Motion, lines: Lines) -> FittedContacts:
    """The contacts of a state."""
    corners, walls = motion.profile.corners, problem.scene.indenter.walls
    held = [FittedLine(x, bool(np.any(corners == x)) or x in walls, False) for x in lines]
    return FittedContacts(problem, tuple(zip(held[::2], held[1::2], strict=True)))


def totals(contacts: FittedContacts, rtol: float) -> tuple[Interval, Interval]:
    """Energy and force by fewer and by more Gauss points, on panels halved until both agree."""
    scene, depth = contacts.problem.scene, contacts.problem.depth
    return refined(scene, depth, panels(scene.indenter, contacts.x), _surfaces(contacts), rtol)


def panels(indenter: Indenter, x: Array) -> Array:
    """Ends (n, 2) of the parts of contacts (m, 2) between corners, knots and the apex."""
    apex = () if indenter.apex is None else (indenter.apex,)
    cuts = np.unique(np.concatenate([indenter.corners, indenter.knots, apex]))
    parts = [
        np.concatenate([[left], cuts[(cuts > left) & (cuts < right)], [right]])
        for left, right in x.tolist()
    ]
    return np.concatenate([np.column_stack([part[:-1], part[1:]]) for part in parts])


def _surfaces(contacts: FittedContacts) -> tuple[float, float, float, float]:
    """Of all free surfaces: energy, reactions, areas (times k), and absolute reactions."""
    problem, scene = contacts.problem, contacts.problem.scene
    length, own, energy, area = scene.elastocapillary_length, gap_of(problem), 0.0, 0.0
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
