"""Contacts that stay after an event and are narrower than nodes see.

Where a contact is lost on nodes, a remnant may still rest. One line may recede beyond a fold to a
place close to the other one: a contact is looked for from a point at either line. And at a corner D
rises by a jump, which holds a contact of any width: its lines are looked for from widths of a
spacing of the nodes down to rounding. Receding lines come to rest in the widest contact first.

Conventions
-----------
Only where the depth falls: directions are -1. Lines of neighbouring free surfaces are rows from
left to right of their left and right line [length], -inf and inf where a tail has none; the contact
between two surfaces reaches from the right line of the left one to the left line of the right one.
A `Happening` is an event that ends surfaces `before` and begins those `after`, each a `Life`. On
nodes a surface is the pair of contact nodes at its ends, None where there is none. `Events.rest`
takes lines to rest by Newton's method; `Equations.pulls` are the forces of surfaces at their lines
over kl [length], positive where they push the contact up against the indenter. Of a `Happening`,
`at` is its depth on nodes, `depth` the refined one, `lines_before` and `lines_after` are the lines
(n, 2) there. Of a `Life`, `born` is the event at which it begins, `start` its depth and `first` its
lines there, nan where not known, and `trace` has depths on nodes, each with the `Pair` of contact
nodes from there on. `just_beyond` is a depth so little beyond an event that lines rest as at it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.refine.events import Events
from discretization.refine.lives import Happening, Life, Pair
from energy.arrays import Array, Mask

# Of the spacing of nodes: half-widths of contacts that are tried, from a link on either side down
# to 2e-12, where the width is the rounding of a position a few thousand spacings from 0.
_WIDTHS = 0.5 ** np.arange(40)


class RemnantRules(NamedTuple):
    """Which contacts are looked for; lengths are of the spacing of nodes.

    Halved or doubled (tolerances: a tenth or ten times), each leaves the random paths that read it
    as they are to 1e-9: 8 results for `closed`, 2 for the others, as few paths have a remnant
    (`python -m tests.sensitivity discretization.refine.remnants`).

    Attributes
    ----------
    widest : float
        Wider contacts are seen on the nodes.
    closed : float
        A contact that narrow just before it is lost leaves no remnant.
    pulled : float
        Of the size of depths: a contact of one point that is pulled no more than that stays.
    rounds : int
        Of Newton's method from a point at one of the lines: it converges quadratically, or there is
        nothing near.
    """

    widest: float = 4.0
    closed: float = 1e-6
    pulled: float = 1e-13
    rounds: int = 10


_RULES = RemnantRules()


@dataclass(frozen=True, eq=False)
class Remnants:
    """What looks for contacts that are left.

    Attributes
    ----------
    events : Events
        What takes lines to rest.
    """

    events: Events

    def found(self, happened: Sequence[Happening]) -> list[Happening]:
        """Find contacts that stay after events at which they seemed to be lost.

        Parameters
        ----------
        happened : sequence of Happening
            With the lines after them. Where there is a remnant, `after` and `lines_after` become
            the two surfaces on both sides of it and their lines.

        Returns
        -------
        list of Happening
            The events at which the remnants are lost, whose depths are not known yet.
        """
        lost = [event for event in happened if _loses_wide_contact(event)]
        for event in lost:
            # With two works of adhesion lines are bounded by where they stand.
            for life, row in zip(event.before, event.lines_before, strict=True):
                life.first = row if np.isnan(life.first).any() else life.first
        later = list[Happening]()
        for event, receded in zip(lost, self._receded(lost), strict=True):
            rows = self._at_corner(event) if receded is None else receded
            if rows is not None:
                left, right = _ends(event.lines_before)
                later.append(_interposed(event, rows, (left + right) / 2))
        return later

    def _receded(self, lost: Sequence[Happening]) -> list[Array | None]:
        """For each event the lines (2, 2) of a narrow contact to which the lines before it recede.

        None where there is none. One line recedes to near the other one, so that a contact is
        looked for from a point at either line; those of all events at once.
        """
        if not lost:
            return []
        starts = [self._points(event) for event in lost]
        count = starts[0].shape[1]
        lives = [life for event in lost for life in event.before]
        depths = np.repeat([event.depth for event in lost], 2)[:, None]
        found = self.events.rest(
            lives,
            np.concatenate(starts),
            np.repeat(depths, count, axis=1),
            rounds=_RULES.rounds,
        )
        lines = found.lines.reshape(len(lost), 2, count, 2)
        at_rest = np.asarray(found.at_rest.reshape(len(lost), 2, count).all(axis=1))
        return [self._widest(*each) for each in zip(lost, lines, at_rest, strict=True)]

    def _points(self, event: Happening) -> Array:
        """Lines (2, 2, 2) of the surfaces beside a contact of no width, at either line before."""
        places = np.array(_ends(event.lines_before))
        return _beside(event, places, places)

    def _at_corner(self, event: Happening) -> Array | None:
        """Lines (2, 2) of the surfaces on both sides of a contact that stays at a corner.

        None if none stays.
        """
        left, right = _ends(event.lines_before)
        spacing = event.before[0].nodes.spacing
        corners = self.events.equations.profile.corners
        near = corners[(corners >= left - spacing) & (corners <= right + spacing)]
        half = _WIDTHS * spacing
        for corner in near.tolist():
            starts = _beside(event, corner - half, corner + half)
            depths = np.full(starts.shape[:2], event.depth)
            found = self.events.rest(event.before, starts, depths)
            at_rest = np.asarray(found.at_rest.reshape(2, -1).all(axis=0))
            rows = self._widest(event, found.lines.reshape(starts.shape), at_rest)
            if rows is not None:
                return rows
        return None

    def _widest(self, event: Happening, lines: Array, at_rest: Mask) -> Array | None:
        """The lines (2, 2) beside the widest contact that stays; None if none does.

        lines (2, j, 2) are those of the surfaces on the left and on the right of j contacts;
        at_rest (j,) is whether both are at rest.
        """
        left, right = _ends(event.lines_before)
        spacing = event.before[0].nodes.spacing
        width = lines[1, :, 0] - lines[0, :, 1]
        good = at_rest & (width >= 0) & (width <= _RULES.widest * spacing)
        good &= (lines[0, :, 1] >= left - spacing) & (lines[1, :, 0] <= right + spacing)
        good &= (width > 0) | self._is_pressed(lines, event.depth)
        good &= width < (right - left) / 2  # not the contact before
        if not good.any():
            return None
        widest = int(np.argmax(np.where(good, width, -1.0)))
        return np.asarray(lines[:, widest])

    def _is_pressed(self, lines: Array, depth: float) -> Mask:
        """Whether contacts of one point are pressed, or not pulled but for rounding (j,).

        lines (2, j, 2) are those of the surfaces on both sides, the middle two at the point.
        """
        equations = self.events.equations
        flat = lines.reshape(-1, 2)
        pulls = equations.pulls(flat, np.full(len(flat), depth)).reshape(lines.shape)
        reaction = pulls[0, :, 1] + pulls[1, :, 0]
        return np.asarray(reaction >= -_RULES.pulled * equations.size)


def _loses_wide_contact(event: Happening) -> bool:
    """Whether receding lines lose a contact that is not closed just before, but for rounding."""
    if event.direction > 0 or len(event.before) != 2 or len(event.after) > 1:
        return False
    left, right = _ends(event.lines_before)
    return right - left > _RULES.closed * event.before[0].nodes.spacing


def _beside(event: Happening, first: Array, last: Array) -> Array:
    """Lines (2, j, 2) of the surfaces on both sides of contacts that reach from first to last (j,).

    The other line of each surface is that of the surface which is there after the event.
    """
    outer_left, outer_right = event.lines_after[0] if len(event.after) else (-np.inf, np.inf)
    on_the_left = np.column_stack([np.full(first.size, outer_left), first])
    on_the_right = np.column_stack([last, np.full(last.size, outer_right)])
    return np.array([on_the_left, on_the_right])


def _ends(rows: Array) -> tuple[float, float]:
    """The ends of the contact between two surfaces with these lines (2, 2)."""
    return float(rows[0, 1]), float(rows[1, 0])


def _interposed(event: Happening, rows: Array, place: float) -> Happening:
    """Put a remnant between an event and what comes after it; the event at which it is lost.

    rows (2, 2): the lines of the surfaces on both sides of it; place: where it is [length]. These
    two surfaces come after the event now, and end at the new one, which has what came after it.
    """
    nodes = event.before[0].nodes
    (node, _), *_ = nodes.contacts((place, place))
    # The outermost nodes, as the two surfaces have them after the event, or last had them.
    first = event.before[0].trace[-1][1][0]
    last = event.before[-1].trace[-1][1][1]
    if event.after:
        first, last = event.after[0].trace[0][1]
    both: list[Pair] = [(first, node), (node, last)]
    new = [Life(nodes, event.direction, [(event.at, pair)], born=event) for pair in both]
    later = Happening(event.at, new, event.after)
    for life in event.after:
        life.born = later
        life.start = math.nan
    event.after = new
    event.lines_after = rows
    return later
