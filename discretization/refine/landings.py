"""Where surfaces come to rest after events, and whether closer nodes agree.

After an event the lines of the new surfaces rest near their nodes. A jump on nodes may have skipped
a rest that exists at few depths, or a contact that is narrower than the nodes see, and both the
balance of energy and the certificate of the state are blind to that. So lines are moved from where
they are before the event as their forces push them, and must not rest earlier; and every landing is
repeated on nodes CLOSER times as close.

Conventions
-----------
Depths grow as the indenter goes down. A direction is 1 where the depth grows and -1 where it falls;
"beyond" is further in this direction. A margin is by how much the depth of an event on nodes may be
off (`FoundNodes.margin`).

Lines of neighbouring free surfaces are arrays (n, 2), a row for each from left to right, with its
left and its right line [length], -inf and inf where a tail has none. The contact between rows i and
i + 1 reaches from [i, 1] to [i + 1, 0]; lines are in order if [i, 1] <= [i + 1, 0]. On nodes a free
surface is a pair of contact nodes, None where there is none. OUTWARDS = (1, -1) is where the left
and the right line of a surface go when their contacts grow.

A `Happening` is an event, with the surfaces that end at it, `before`, and those that begin, `after`
(each a `Life`), its depth on the nodes, `at`, and its refined depth, `depth`. `Events.rest` takes
lines of surfaces to rest by Newton's method; with `downhill` they go where their forces push them
where that leads to no stable rest. `Events.clearance` is the least minimum of the gap between a
surface and the indenter, negative where the surface would be in the indenter, and its place; below
-PENETRATION δ, δ the size of depths, it is.

Of a `Life`, `first` are its lines where they begin, nan where not known; with two works of adhesion
(`scene.hysteretic`) lines stand there until they move. `trace` has depths on nodes, each with the
`Pair` of contact nodes from there on, `guess(depth)` the positions of these. Of `FoundNodes`,
`row.lowest` is the height of the lowest node, `positions` are x of all nodes, and
`walk.track_part(pairs, start, end)` follows neighbouring surfaces up to the first event:
`at` is its depth, None if there is none, `after` the contacts then, and the last entry of `trace`
has those before it, which `paired` makes pairs (first node, last node). `pairs` are the pairs of
nodes of all surfaces of contacts, [] if detached. `settle` takes surfaces to rest by themselves,
each line no further than `reach`; FROM_NODES, of l, is how far lines may rest from their nodes.
`faces_at_touch` are the ends (m, 2) of what touches first, nan where they are not known exactly;
`lines_of_surfaces` the 2m lines of m contacts from their surfaces. CREEPING is how many links lines
may pass at one depth on nodes and yet move smoothly.
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
from energy.arrays import Array, Indices, Mask

# Times as close are the nodes on which landings are repeated: three halvings, so that what is an
# accident of the nodes is unlikely to be repeated. 4 or 16 changes none of 8 random paths
# (`python -m tests.sensitivity discretization.refine.landings CLOSER`).
CLOSER = 8


class LandingRules(NamedTuple):
    """How lines after events are found, and when closer nodes agree with them.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each but `neighbours` leaves 8
    random states and paths as they are to 1e-9: `python -m tests.sensitivity
    discretization.refine.landings`.

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
        contacts. Without them one of 8 random paths is left to the nodes on a part, and warns.
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
        What takes lines to rest, and finds how far surfaces are from the indenter.
    closer : FoundNodes
        Nodes CLOSER times as close, which must agree.
    """

    events: Events
    closer: FoundNodes

    def land(self, happened: Sequence[Happening]) -> None:
        """Find the lines after events of known depths.

        They are followed from their nodes a little beyond the event back to it, from ever further
        beyond: next to where they are born equilibria may be hard to find from the nodes. Where
        that fails lines move from their nodes as their forces push them.

        Parameters
        ----------
        happened : sequence of Happening
            Their `lines_after` are written, where these are not known yet.

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
        """Raise NotRefined if lines rest somewhere on their path to where they land.

        From where they are before the event they are moved as their forces push them. Energies are
        submodular in the contact, so that lines stop at the first rest on the path. Events whose
        lines do not jump, or begin at unknown places, are not looked at.
        """
        events = [event for event in happened if not event.smooth and event.after]
        starts = [(event, self._start(event)) for event in events]
        known = [(event, rows) for event, rows in starts if rows is not None]
        if not known:
            return
        # The surfaces of all these events in one array, those of an event next to each other.
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
        """A depth just beyond an event: at the event itself, a fold, no force pushes the lines."""
        margin = (event.before or event.after)[0].nodes.margin
        return event.depth + event.direction * _LANDING.beyond * margin

    def _start(self, event: Happening) -> Array | None:
        """Where the lines (n, 2) of the n surfaces after an event are before they move.

        Of one surface these are the outermost lines of those before it; a contact begins as a
        point, where the surface touches. None of more surfaces, or where that place is not known.
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
            # The gap on one side of the new contact has closed at once: the line that is left on
            # that side is the other end of the new contact.
            left, right = event.lines_after[0]
            if left >= place:
                outer[0, 0] = place
            if right <= place:
                outer[0, 1] = place
        return outer

    def _touched(self, event: Happening) -> float | None:
        """Where the one surface before an event touches the indenter [length]; None if nowhere.

        It does where the least minimum of its gap is 0 to rounding, PENETRATION δ.
        """
        clearance, place = self.events.clearance(event.lines_before[0], event.depth)
        touches = abs(clearance) <= PENETRATION * self.events.equations.size
        return place if touches else None

    def _stops_earlier(self, event: Happening, rows: Array) -> bool:
        """Whether lines (n, 2) are on the path to those after an event, and well before them.

        Well before is by l/100 or more. No line may be beyond by as much, and neighbours may not
        have met.
        """
        if (rows[:-1, 1] > rows[1:, 0]).any():
            return False
        finite = np.isfinite(rows)
        forwards = event.direction * OUTWARDS  # pressed, contacts grow from both lines of a surface
        with np.errstate(invalid="ignore"):  # inf - inf of tails
            remaining = np.where(finite, (event.lines_after - rows) * forwards, 0.0)
        near = _LANDING.elsewhere * self.events.equations.length
        return bool((remaining >= -near).all() and (remaining > near).any())

    def _landed(
        self, todo: Sequence[Happening], ahead: float, *, downhill: bool = False
    ) -> list[Happening]:
        """Write the lines after events into them; the events for which that fails.

        They fail if a surface does not come to rest, lines of neighbours overlap, or a surface is
        in the indenter. `ahead` is how many margins beyond the event the lines are followed from.
        """
        if self.events.equations.scene.hysteretic:
            for event in todo:
                self._stand(event)
        owner = np.repeat(np.arange(len(todo)), [len(event.after) for event in todo])
        lines, at_rest = self._rest_after(todo, owner, ahead, downhill=downhill)
        failed = list[Happening]()
        for i, event in enumerate(todo):
            own = owner == i
            rows = self._without_overlap(lines[own])
            in_order = bool((rows[:-1, 1] <= rows[1:, 0]).all())
            if at_rest[own].all() and in_order and self._clear(rows, event.depth):
                event.lines_after = rows
            else:
                failed.append(event)
        return failed

    def _rest_after(
        self, todo: Sequence[Happening], owner: Indices, ahead: float, *, downhill: bool
    ) -> tuple[Array, Mask]:
        """Lines (n, 2) of all surfaces after events, and whether they are at rest (n,).

        First they are taken to rest some margins beyond the event, from the nodes as far beyond
        their own event, then from there at the event. owner (n,): the number of each surface's
        event.
        """
        lives = [life for event in todo for life in event.after]
        directions = np.array([float(event.direction) for event in todo])[owner]
        margins = np.array([life.nodes.margin for life in lives])
        further = directions * ahead * margins
        at = np.array([event.depth for event in todo])[owner]
        on_nodes = np.array([event.at for event in todo])[owner]
        guess = np.array([life.guess(d) for life, d in zip(lives, on_nodes + further, strict=True)])
        reach = FROM_NODES * self.events.equations.length
        beyond = (at + further)[:, None]
        found = self.events.rest(lives, guess[:, None], beyond, reach=reach, downhill=downhill)
        at_rest = found.at_rest
        if ahead:
            found = self.events.rest(lives, found.lines[:, None], at[:, None], reach=reach)
            at_rest = at_rest & found.at_rest
        return found.lines, at_rest

    def merged(self, event: Happening, place: int) -> Array | None:
        """Lines of the surface that two neighbours become at an event, the other contacts staying.

        Parameters
        ----------
        event : Happening
            Several contacts are lost at it; the one between both surfaces is lost first.
        place : int
            Number of the left one of both surfaces in `before`.

        Returns
        -------
        ndarray (2,) or None
            [length]; None where it does not come to rest, or only where it would meet the line on
            the other side of a neighbouring contact.
        """
        rows = event.lines_before
        outer = np.array([rows[place, 0], rows[place + 1, 1]])
        merged = Life(event.before[place].nodes, event.direction, [], first=outer)
        depths = np.array([[event.depth]])
        found = self.events.rest([merged], outer[None, None], depths, downhill=True)
        (lines,) = found.lines
        left_stays = place == 0 or rows[place - 1, 1] < lines[0]
        right_stays = place + 2 == len(rows) or lines[1] < rows[place + 2, 0]
        if not (found.at_rest[0] and left_stays and right_stays):
            return None
        return np.asarray(lines)

    def _stand(self, event: Happening) -> None:
        """Write into surfaces after an event where their lines stand before they move (`first`).

        For two works of adhesion. The outermost lines are those of the surfaces before. A contact
        begins where the surface touches; where that is not known, in the middle of its nodes.
        """
        begins = self._begins(event)
        for i, (life, following) in enumerate(itertools.pairwise(event.after)):
            life.first = np.array([life.first[0], begins[i, 0]])
            following.first = np.array([begins[i, 1], following.first[1]])
        left = -math.inf
        right = math.inf
        if len(event.lines_before):
            left = float(event.lines_before[0, 0])
            right = float(event.lines_before[-1, 1])
        first = event.after[0]
        first.first = np.array([left, first.first[1]])
        last = event.after[-1]
        last.first = np.array([last.first[0], right])

    def _begins(self, event: Happening) -> Array:
        """Where the m contacts between the surfaces after an event begin: their ends (m, 2).

        The left and the right end are the same where a contact begins as a point.
        """
        nodes = event.after[0].nodes
        contacts = list[tuple[int, int]]()
        for life, following in itertools.pairwise(event.after):
            first = life.trace[0][1][1]  # the right node of the surface on the left
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
        """Lines (n, 2), those of a contact that overlap by rounding both put in their middle.

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
        """Whether no surface with lines (n, 2) is in the indenter, but for rounding."""
        least = -PENETRATION * self.events.equations.size
        return all(self.events.clearance(row, depth)[0] >= least for row in rows)

    def agrees_at_touch(self, after: Array) -> bool:
        """Whether closer nodes have the surfaces with these lines (n, 2) after first touch."""
        return self._near(pairs(self.closer.walk.touched(self.closer.row.lowest)), after)

    def agrees(self, event: Happening, before: Array, first: int) -> bool:
        """Whether closer nodes divide, or join, the surfaces of an event likewise.

        They are followed on closer nodes from a little before the event to a little beyond, ever
        further, until something happens to them. What they become then must be what is there after
        the event; if nothing happens, what they are at the last of these depths.

        Parameters
        ----------
        event : Happening
            Some surface ends at it.
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
        stop = first + len(event.before)
        left = on_nodes[first][0]  # the outermost nodes of the surfaces of the event
        right = on_nodes[stop - 1][1]
        neighbours = 0 if event.direction > 0 else _LANDING.neighbours
        start = on_nodes[max(first - neighbours, 0) : stop + neighbours]
        reached = list[Pair]()
        for passed in _LANDING.passed:
            reach = event.direction * passed * self.closer.margin
            followed = start
            depth: float | None = event.depth - reach
            while depth is not None:
                track = self.closer.walk.track_part(followed, depth, event.depth + reach)
                reached = _within(paired(track.trace[-1][1]), left, right)
                depth = track.at
                followed = _between(track.after, start)
                landed = _within(track.after, left, right)
                if depth is not None and not _alike(reached, landed):
                    return self._lands_at(landed, event)
        return self._lands_at(reached, event)

    def _lands_at(self, surfaces: list[Pair], event: Happening) -> bool:
        """Whether surfaces on closer nodes agree with those after an event.

        They do if they are as many, with lines nearby; or if they are not in equilibrium off the
        nodes at the depth of the event. Nodes come too late by their spacing, also where a landing
        is about to disappear, so that they may land there when off the nodes it is gone.
        """
        bounded = [pair for pair in surfaces if pair != (None, None)]
        if self._near(bounded, event.lines_after):
            return True
        return self._near(bounded, self._seen(event.lines_after)) or not self._rests(bounded, event)

    def _seen(self, lines: Array) -> Array:
        """The lines (n, 2) of surfaces without those of contacts narrower than a link.

        Closer nodes have lost such a contact, so that the surfaces on both sides of it are one.
        What is left of a surface without lines is no row.
        """
        flat = lines.ravel()
        contacts = flat[1:-1].reshape(-1, 2)
        wide = np.diff(contacts, axis=1)[:, 0] >= self.closer.spacing
        seen = np.concatenate([flat[:1], contacts[wide].ravel(), flat[-1:]]).reshape(-1, 2)
        return np.asarray(seen[np.isfinite(seen).any(axis=1)])

    def _rests(self, surfaces: list[Pair], event: Happening) -> bool:
        """Whether surfaces on closer nodes rest near these at the depth of an event.

        Where there is none, as when all is detached, nothing need rest.
        """
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
        in_order = bool((found.lines[:-1, 1] <= found.lines[1:, 0]).all())
        return bool(found.at_rest.all()) and in_order

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


def _between(contacts: Contacts, start: list[Pair]) -> list[Pair]:
    """What has become of some neighbouring surfaces, given the contacts between and beside them.

    start: these surfaces at first. Beside the outermost ones are contacts, beyond which surfaces
    are not followed, unless they are tails.
    """
    found = pairs(contacts) or [(None, None)]
    first = 0 if start[0][0] is None else 1
    stop = len(found) if start[-1][1] is None else -1
    return found[first:stop]


def _within(contacts: Contacts, left: End, right: End) -> list[Pair]:
    """The surfaces of contacts on nodes that lie between two nodes, at least in part.

    Of the surfaces of an event these are the outermost nodes before it: of a pressed surface lines
    only move inwards, of retracted ones only outwards, so that what lies there in part has come
    from these surfaces.
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
    """Whether surfaces before and after are as many, with lines at most CREEPING links apart."""
    if len(before) != len(after):
        return False
    for old, new in zip(before, after, strict=True):
        for one, other in zip(old, new, strict=True):
            if (one is None) != (other is None):
                return False
            if one is not None and other is not None and abs(one - other) > CREEPING:
                return False
    return True
