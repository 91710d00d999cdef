"""Contacts that stay at a corner and are narrower than nodes see.

Where a contact is lost on nodes, a remnant may still rest at a tip: at a corner D rises by a
jump, which holds a contact of any width. Its lines are looked for from widths of a spacing of the
nodes down to rounding; receding lines come to rest in the widest contact first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.refine.events import Events
from discretization.refine.lives import Happening, Life, Pair
from energy.arrays import Array

# Of the spacing of nodes: half widths of contacts that are tried, down to 2e-12, where the width is
# the rounding of a position a few thousand spacings from 0.
_WIDTHS = 0.5 ** np.arange(40)


class RemnantRules(NamedTuple):
    """Which contacts at corners are looked for; lengths are of the spacing of nodes.

    `closed` times 0 or 1000 leaves 6 random paths as they are to 1e-9 (`python -m tests.sensitivity
    discretization.refine.remnants RemnantRules.closed 0 1000`). The other two are read where a
    remnant is tried, which happened in none of 24 random paths.

    Attributes
    ----------
    widest : float
        Wider contacts are seen on the nodes.
    closed : float
        A contact that narrow just before it is lost leaves no remnant.
    pulled : float
        Of the size of depths: a contact of one point that is pulled no more than that stays.
    """

    widest: float = 4.0
    closed: float = 1e-6
    pulled: float = 1e-13


_RULES = RemnantRules()


@dataclass(frozen=True, eq=False)
class Remnants:
    """What looks for contacts that are left at corners.

    Attributes
    ----------
    events : Events
        Takes lines to rest.
    """

    events: Events

    def found(self, happened: Sequence[Happening]) -> list[Happening]:
        """Find contacts that stay at corners after events at which they seemed to be lost.

        Parameters
        ----------
        happened : sequence of Happening
            Surfaces and lines after those with a remnant become the ones on both sides of it.

        Returns
        -------
        list of Happening
            The events at which the remnants are lost, whose depths are not known yet.
        """
        if not self.events.equations.profile.corners.size:
            return []
        later = list[Happening]()
        for event in happened:
            if event.direction < 0 and len(event.before) == 2 and len(event.after) <= 1:
                left = event.lines_before[0, 1]
                right = event.lines_before[1, 0]
                if right - left <= _RULES.closed * event.before[0].nodes.spacing:
                    continue
                rows = self._remnant(event, float(left), float(right))
                if rows is not None:
                    later.append(_interposed(event, rows, float((left + right) / 2)))
        return later

    def _remnant(self, event: Happening, left: float, right: float) -> Array | None:
        """Lines (2, 2) of the surfaces on both sides of a contact that stays between two lines."""
        equations = self.events.equations
        spacing = event.before[0].nodes.spacing
        corners = equations.profile.corners
        near = corners[(corners >= left - spacing) & (corners <= right + spacing)]
        outer = event.lines_after[0] if len(event.after) else (-np.inf, np.inf)
        for corner in near.tolist():
            half = spacing * _WIDTHS
            rows = np.empty((half.size, 2, 2))
            rows[:, 0] = np.column_stack([np.full(half.size, outer[0]), corner - half])
            rows[:, 1] = np.column_stack([corner + half, np.full(half.size, outer[1])])
            flat = rows.transpose(1, 0, 2)
            depths = np.full(flat.shape[:2], event.depth)
            for life, row in zip(event.before, event.lines_before, strict=True):
                life.first = row if np.isnan(life.first).any() else life.first
            found = self.events.rest(event.before, flat, depths)
            lines = found.lines.reshape(flat.shape)
            width = lines[1, :, 0] - lines[0, :, 1]
            good = found.at_rest.reshape(2, -1).all(axis=0)
            good &= (width >= 0) & (width <= _RULES.widest * spacing)
            good &= (lines[0, :, 1] >= left - spacing) & (lines[1, :, 0] <= right + spacing)
            pulls = equations.pulls(lines.reshape(-1, 2), depths.ravel()).reshape(flat.shape)
            reaction = pulls[0, :, 1] + pulls[1, :, 0]
            good &= (width > 0) | (reaction >= -_RULES.pulled * equations.size)
            good &= width < (right - left) / 2  # not the contact before
            if good.any():
                widest = int(np.argmax(np.where(good, width, -1.0)))
                return lines[:, widest]
        return None


def _interposed(event: Happening, rows: Array, place: float) -> Happening:
    """Put a remnant between an event and what comes after it; the event at which it is lost."""
    nodes = event.before[0].nodes
    (node, _), *_ = nodes.contacts((place, place))
    first = event.before[0].trace[-1][1][0]
    last = event.before[-1].trace[-1][1][1]
    if event.after:
        first, last = event.after[0].trace[0][1]
    both: list[Pair] = [(first, node), (node, last)]
    new = [Life(nodes, event.direction, [(event.at, pair)], born=event) for pair in both]
    later = Happening(event.at, new, event.after)
    for life in event.after:
        life.born = later
        life.start = float("nan")
    event.after = new
    event.lines_after = rows
    return later
