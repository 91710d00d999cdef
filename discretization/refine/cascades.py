"""Contacts that nodes lose together, and that are lost one after the other off the nodes.

On nodes a contact is lost a little late. A neighbour that would have been lost soon afterwards may
then be lost at the same depth. Off the nodes the first of them is the one whose lines have met. The
free surfaces on both sides of it become one; if that comes to rest, the others are lost later.

Conventions
-----------
Only where the depth falls: directions are -1. Lines of neighbouring free surfaces are arrays
(n, 2), a row for each from left to right, with its left and its right line [length]; the contact
between rows i and i + 1 reaches from [i, 1] to [i + 1, 0]. A `Happening` is an event that ends
surfaces `before` and begins those `after`, each a `Life`; `lines_before` and `lines_after` are
their lines just before and after it. `Landings.merged` are the lines of the surface that two
neighbours become when the contact between them is lost and the others stay, None where it does not
come to rest. Of a `Life`, `born` is the event at which it begins, `start` the refined depth of
that, nan where not known, and `trace` has depths on nodes, each with the contact nodes at both
ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discretization.refine.landings import Landings
from discretization.refine.lives import Happening, Life
from energy.arrays import Array

# Of l: lines of a contact that is lost are as near to each other. 1e-7 or 1e-5 changes nothing
# (`python -m tests.sensitivity discretization.refine.cascades`).
_MET = 1e-6


@dataclass(frozen=True, eq=False)
class Cascades:
    """What takes apart events at which several contacts are lost.

    Attributes
    ----------
    landings : Landings
        What finds where the surface rests that two neighbours become.
    """

    landings: Landings

    def found(self, happened: Sequence[Happening]) -> list[Happening]:
        """Divide events at which several contacts are lost into one after the other.

        Parameters
        ----------
        happened : sequence of Happening
            With the lines before them. Those that can be divided become the loss of their first
            contact alone.

        Returns
        -------
        list of Happening
            The events at which the other contacts are lost, whose depths are not known yet.
        """
        later = list[Happening]()
        for event in happened:
            if event.direction > 0 or len(event.before) < 3:
                continue
            place = self._first_lost(event)
            if place is None:
                continue
            merged = self.landings.merged(event, place)
            if merged is not None:
                later.append(_taken_apart(event, place, merged))
        return later

    def _first_lost(self, event: Happening) -> int | None:
        """The number of the surface on the left of the contact whose lines have met.

        None where no contact is closed just before the event: what is lost first is not known.
        """
        rows = event.lines_before
        widths = rows[1:, 0] - rows[:-1, 1]
        place = int(np.argmin(widths))
        closed = widths[place] <= _MET * self.landings.events.equations.length
        return place if closed else None


def _taken_apart(event: Happening, place: int, merged: Array) -> Happening:
    """Make an event the loss of one contact; returns the event at which the others are lost.

    place: the number of the surface on the left of that contact; merged: lines (2,) of the surface
    that is there afterwards. That surface and the others before the event are those before the new
    one, which has what came after the old event.
    """
    nodes = event.before[0].nodes
    left = event.before[place]
    right = event.before[place + 1]
    pair = (left.trace[-1][1][0], right.trace[-1][1][1])
    between = Life(nodes, event.direction, [(event.at, pair)], born=event)
    before = [*event.before[:place], between, *event.before[place + 2 :]]
    later = Happening(event.at, before, event.after)
    for life in event.after:
        life.born = later
        life.start = math.nan
    event.before = [left, right]
    event.lines_before = event.lines_before[place : place + 2]
    event.after = [between]
    event.lines_after = merged[None]
    return later
