"""Where surfaces come to rest after events, and whether closer nodes agree.

After an event the lines of the new surfaces rest near their nodes. A jump on nodes may have skipped
a rest that exists at few depths, or a contact that is narrower than the nodes see, and both the
balance of energy and the certificate of the state are blind to that. So lines are moved from where
they are before the event as their forces push them, and must not rest earlier; and every landing is
repeated on nodes CLOSER times as close.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.lattice.walk import End, paired
from discretization.nodes.row import Contacts
from discretization.refine.equations import OUTWARDS, lines_of_surfaces
from discretization.refine.events import PENETRATION, Events, NotRefined
from discretization.refine.first_touch import faces_at_touch
from discretization.refine.lives import CREEPING, Happening, Life, Pair, pairs
from discretization.refine.nodes import FROM_NODES, FoundNodes
from discretization.refine.settle import settle
from energy.arrays import Array

CLOSER = 8


class LandingRules(NamedTuple):
    """How lines after events are found, and when closer nodes agree with them.

    Attributes
    ----------
    ahead : tuple of float
        Margins beyond an event, from where lines are followed back to it: one after the other,
        until they rest.
    beyond : float
        Margins: so little beyond a fold lines still rest where they would at the event.
    elsewhere : float
        Of l: lines that far from those after an event are others.
    met : float
        Of l: lines of a contact of no width may overlap by that much.
    landed : float
        Of l: how far lines on closer nodes may be from those after the event.
    neighbours : int
        Surfaces on each side of an event of receding lines that are followed with it, as they share
        contacts.
    passed : tuple of float
        Margins on both sides of an event, within which closer nodes have it.
    """

    ahead: tuple[float, ...] = (0.0, 0.02, 0.1, 0.3, 1.0)
    beyond: float = 1e-6
    elsewhere: float = 1e-2
    met: float = 1e-6
    landed: float = 0.2
    neighbours: int = 1
    passed: tuple[float, ...] = (0.1, 0.5)


_LANDING = LandingRules()


@dataclass(frozen=True, eq=False)
class Landings:
    """What finds where lines come to rest after events.

    Attributes
    ----------
    events : Events
        Takes lines to rest.
    closer : FoundNodes
        Nodes CLOSER times as close, which must agree.
    """

    events: Events
    closer: FoundNodes

    def land(self, happened: Sequence[Happening]) -> None:
        """Find the lines after events of known depths.

        They are followed from their nodes a little beyond the event back to it, from ever further
        beyond; where that fails they move as their forces push them.

        Parameters
        ----------
        happened : sequence of Happening
            Their `lines_after` are written.

        Raises
        ------
        NotRefined
            If no equilibrium is found, or lines rest earlier on their path.
        """
        todo = [event for event in happened if event.after and not len(event.lines_after)]
        for ahead in _LANDING.ahead:
            if todo:
                todo = self._landed(todo, ahead)
        if todo:
            todo = self._landed(todo, 0.0, downhill=True)
        if todo:
            raise NotRefined(
                f"no equilibrium is found after the event at depth = {todo[0].depth!r}",
                todo[0].depth,
            )
        self._demand_first(happened)

    def _demand_first(self, happened: Sequence[Happening]) -> None:
        """NotRefined if lines rest somewhere on their path to where they land.

        From where they are before the event they are moved as their forces push them. Energies are
        submodular in the contact, so that lines stop at the first rest on the path.
        """
        events = [event for event in happened if not event.smooth and event.after]
        starts = [(event, self._start(event)) for event in events]
        known = [(event, rows) for event, rows in starts if rows is not None]
        if not known:
            return
        lives = [life for event, _ in known for life in event.after]
        rows = np.concatenate([rows for _, rows in known])
        depths = np.concatenate(
            [np.full(len(rows), self._just_beyond(event)) for event, rows in known]
        )
        found = self.events.rest(lives, rows[:, None], depths[:, None], downhill=True)
        first = 0
        for event, _ in known:
            own = slice(first, first + len(event.after))
            first += len(event.after)
            if found.at_rest[own].all() and self._stops_earlier(event, found.lines[own]):
                raise NotRefined(
                    f"lines rest on the path from the event at depth = {event.depth!r}", event.depth
                )

    def _just_beyond(self, event: Happening) -> float:
        """A depth just beyond an event, where lines are still pushed in its direction."""
        margin = (event.before or event.after)[0].nodes.margin
        return event.depth + event.direction * _LANDING.beyond * margin

    def _start(self, event: Happening) -> Array | None:
        """Lines (n, 2) of the surfaces after an event before they move; None where not known.

        Those that were there before, or both sides of the place where a surface touches.
        """
        before = event.lines_before
        if len(before) == 0 or len(event.after) > 2:
            return None
        outer = np.array([[before[0, 0], before[-1, 1]]])
        if event.direction < 0:
            return outer if len(event.after) == 1 else None
        place = self._touched(event)
        if len(event.after) == 2:
            if place is None:
                return None
            return np.array([[before[0, 0], place], [place, before[0, 1]]])
        if place is not None:
            left, right = event.lines_after[0]
            if left >= place:
                outer[0, 0] = place
            if right <= place:
                outer[0, 1] = place
        return outer

    def _touched(self, event: Happening) -> float | None:
        """Where the one surface before an event touches the indenter; None if it does not."""
        clearance, place = self.events.clearance(event.lines_before[0], event.depth)
        touches = abs(clearance) <= PENETRATION * self.events.equations.size
        return place if touches else None

    def _stops_earlier(self, event: Happening, rows: Array) -> bool:
        """Whether lines (n, 2) are on the path to those after an event, and well before them."""
        if (rows[:-1, 1] > rows[1:, 0]).any():
            return False
        finite = np.isfinite(rows)
        forwards = event.direction * OUTWARDS  # pressed, contacts grow from both lines of a surface
        with np.errstate(invalid="ignore"):
            left = np.where(finite, (event.lines_after - rows) * forwards, 0.0)
        near = _LANDING.elsewhere * self.events.equations.length
        return bool((left >= -near).all() and (left > near).any())

    def _landed(
        self, todo: Sequence[Happening], ahead: float, *, downhill: bool = False
    ) -> list[Happening]:
        """Find lines after events, some margins beyond and back; those that fail."""
        lives = [life for event in todo for life in event.after]
        owner = np.repeat(np.arange(len(todo)), [len(event.after) for event in todo])
        depths = np.array([event.depth for event in todo])
        directions = np.array([float(event.direction) for event in todo])
        margins = np.array([life.nodes.margin for life in lives])
        length = self.events.equations.length
        at = depths[owner]
        beyond = at + directions[owner] * ahead * margins
        on_nodes = np.array([event.at for event in todo])[owner]
        read = on_nodes + directions[owner] * ahead * margins
        lines = np.array([life.guess(d) for life, d in zip(lives, read, strict=True)])
        if self.events.equations.scene.hysteretic:
            for event in todo:
                self._stand(event)
        reach = FROM_NODES * length
        found = self.events.rest(
            lives, lines[:, None], beyond[:, None], reach=reach, downhill=downhill
        )
        good = found.at_rest
        if ahead:
            found = self.events.rest(lives, found.lines[:, None], at[:, None], reach=reach)
            good = good & found.at_rest
        failed = list[Happening]()
        for i, event in enumerate(todo):
            own = np.flatnonzero(owner == i)
            rows = self._without_overlap(found.lines[own])
            apart = bool((rows[:-1, 1] <= rows[1:, 0]).all())
            if good[own].all() and apart and self._clear(rows, event.depth):
                event.lines_after = rows
            else:
                failed.append(event)
        return failed

    def merged(self, event: Happening, place: int) -> Array | None:
        """Lines of the surface that two neighbours become at an event, the other contacts staying.

        Parameters
        ----------
        event : Happening
        place : int
            Number of the left one of both surfaces.

        Returns
        -------
        ndarray (2,) or None
            [length]; None where it does not come to rest.
        """
        rows = event.lines_before
        outer = np.array([rows[place, 0], rows[place + 1, 1]])
        both = Life(event.before[place].nodes, event.direction, [], first=outer)
        depths = np.array([[event.depth]])
        found = self.events.rest([both], outer[None, None], depths, downhill=True)
        (lines,) = found.lines
        inside = place == 0 or rows[place - 1, 1] < lines[0]
        inside &= place + 2 == len(rows) or lines[1] < rows[place + 2, 0]
        if not (found.at_rest[0] and inside):
            return None
        return np.asarray(lines)

    def _stand(self, event: Happening) -> None:
        """Find where the lines after an event stand before they move, with two works of adhesion.

        Those that were there stay. A contact begins where the surface touches; where that is not
        known, in the middle of its nodes.
        """
        begins = self._begins(event)
        for i, (life, following) in enumerate(itertools.pairwise(event.after)):
            life.first = np.array([life.first[0], begins[i, 0]])
            following.first = np.array([begins[i, 1], following.first[1]])
        left, right = -math.inf, math.inf
        if len(event.lines_before):
            left = float(event.lines_before[0, 0])
            right = float(event.lines_before[-1, 1])
        first = event.after[0]
        first.first = np.array([left, first.first[1]])
        last = event.after[-1]
        last.first = np.array([last.first[0], right])

    def _begins(self, event: Happening) -> Array:
        """The left and the right end (m, 2) of the places at which contacts begin at an event."""
        nodes = event.after[0].nodes
        contacts = list[tuple[int, int]]()
        for life, following in itertools.pairwise(event.after):
            first = life.trace[0][1][1]
            last = following.trace[0][1][0]
            if first is not None and last is not None:
                contacts.append((first, last))
        middles = np.array([nodes.positions[list(each)].mean() for each in contacts])
        in_the_middle = np.column_stack([middles, middles])
        if not event.before:
            faces = faces_at_touch(self.events.equations, nodes, tuple(contacts))
            return np.where(np.isnan(faces), in_the_middle, faces)
        if len(event.before) == 1 and len(contacts) == 1:
            place = self._touched(event)
            if place is not None:
                return np.array([[place, place]])
        return in_the_middle

    def _without_overlap(self, rows: Array) -> Array:
        """Lines (n, 2) of surfaces with contacts of no width where lines overlap by rounding.

        Without adhesion a contact begins as a point, whose lines are known to about the root of
        rounding.
        """
        overlap = rows[:-1, 1] - rows[1:, 0]
        met = np.flatnonzero(
            (overlap > 0) & (overlap <= _LANDING.met * self.events.equations.length)
        )
        if not met.size:
            return rows
        found = rows.copy()
        places = (rows[met, 1] + rows[met + 1, 0]) / 2
        found[met, 1] = places
        found[met + 1, 0] = places
        return found

    def _clear(self, rows: Array, depth: float) -> bool:
        least = -PENETRATION * self.events.equations.size
        return all(self.events.clearance(row, depth)[0] >= least for row in rows)

    def agrees_at_touch(self, after: Array) -> bool:
        """Whether closer nodes find the same surfaces (n, 2) at first touch."""
        return self._near(pairs(self.closer.walk.touched(self.closer.row.lowest)), after)

    def agrees(self, event: Happening, before: Array, first: int) -> bool:
        """Whether closer nodes divide, or join, the surfaces of an event likewise.

        Parameters
        ----------
        event : Happening
        before : ndarray (n, 2)
            Lines of all free surfaces before it [length].
        first : int
            Number of the first surface of the event among these.

        Returns
        -------
        bool
        """
        contacts = self.closer.contacts(lines_of_surfaces(before))
        if any(start > end for start, end in contacts):
            return True  # a contact narrower than the closer nodes are apart is all but closed
        on_nodes = pairs(contacts)
        last = first + len(event.before)
        left = on_nodes[first][0]
        right = on_nodes[last - 1][1]
        neighbours = 0 if event.direction > 0 else _LANDING.neighbours
        own = on_nodes[max(first - neighbours, 0) : last + neighbours]
        known = list[Pair]()
        for passed in _LANDING.passed:
            reach = event.direction * passed * self.closer.margin
            now = own
            at: float | None = event.depth - reach
            while at is not None:
                track = self.closer.walk.track_part(now, at, event.depth + reach)
                known = _parts(paired(track.trace[-1][1]), left, right)
                at = track.at
                now = _between(track.after, own)
                landed = _parts(track.after, left, right)
                if at is not None and not _alike(known, landed):
                    return self._lands_at(landed, event)
        return self._lands_at(known, event)

    def _lands_at(self, surfaces: list[Pair], event: Happening) -> bool:
        """Whether surfaces on closer nodes are those after an event, with lines nearby.

        Or, if they are others, are not in equilibrium off the nodes at the depth of the event:
        nodes come too late by their spacing, also where a landing is about to disappear.
        """
        bounded = [pair for pair in surfaces if pair != (None, None)]
        return self._near(bounded, event.lines_after) or not self._rests(bounded, event)

    def _rests(self, surfaces: list[Pair], event: Happening) -> bool:
        """Whether surfaces on closer nodes rest nearby at the depth of an event."""
        if not surfaces:
            return True
        where = self.closer.positions
        lines = np.array(
            [
                [
                    -math.inf if left is None else where[left],
                    math.inf if right is None else where[right],
                ]
                for left, right in surfaces
            ]
        )
        count = len(lines)
        found = settle(
            self.events.equations,
            lines,
            np.full(count, event.depth),
            np.full(count, float(event.direction)),
            reach=_LANDING.landed * self.events.equations.length,
        )
        apart = bool((found.lines[:-1, 1] <= found.lines[1:, 0]).all())
        return bool(found.at_rest.all()) and apart

    def _near(self, surfaces: list[Pair], lines: Array) -> bool:
        """Whether surfaces on closer nodes are as many as these (n, 2), with lines nearby."""
        if len(surfaces) != len(lines):
            return False
        near = _LANDING.landed * self.events.equations.length
        for pair, row in zip(surfaces, lines, strict=True):
            for node, line in zip(pair, row.tolist(), strict=True):
                if (node is None) != math.isinf(line):
                    return False
                if node is not None and abs(float(self.closer.positions[node]) - line) > near:
                    return False
        return True


def _between(contacts: Contacts, surfaces: list[Pair]) -> list[Pair]:
    """The surfaces between the outermost lines of these, after what has happened to them."""
    found = pairs(contacts) or [(None, None)]
    start = 0 if surfaces[0][0] is None else 1
    end = len(found) if surfaces[-1][1] is None else -1
    return found[start:end]


def _parts(contacts: Contacts, left: End, right: End) -> list[Pair]:
    """The surfaces on nodes that share what is between two lines.

    Of a pressed surface lines only move inwards, of retracted ones only outwards.
    """
    low = -math.inf if left is None else left
    high = math.inf if right is None else right
    found = list[Pair]()
    for one, other in pairs(contacts) or [(None, None)]:
        start = -math.inf if one is None else one
        end = math.inf if other is None else other
        if end > low and start < high:
            found.append((one, other))
    return found


def _alike(before: list[Pair], after: list[Pair]) -> bool:
    """Whether surfaces on nodes are as many, with lines that have at most crept."""
    if len(before) != len(after):
        return False
    for old, new in zip(before, after, strict=True):
        for one, other in zip(old, new, strict=True):
            if (one is None) != (other is None):
                return False
            if one is not None and other is not None and abs(one - other) > CREEPING:
                return False
    return True
