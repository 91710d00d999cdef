"""The life of every free surface on the nodes, from the event it is born at to that it ends at.

As the depth changes in one direction, the free surfaces between and next to contacts do not feel
each other.
Pressed, a surface is divided where contacts begin in it, its lines jump, or it closes; retracted,
lines jump, surfaces are joined where the contact between them is lost, and a surface is born where
a contact opens inside.

Conventions
-----------
A direction is 1 where the depth grows (the indenter is pressed) and -1 where it falls (it is
retracted); depths times the direction increase along a route, and so they are compared.

Contacts are ((first, last), ...), their first and last nodes from left to right, counted from 0 in
the row of nodes; () is detached. m contacts have m + 1 free surfaces: two tails and the gaps in
between. On nodes a free surface is a `Pair`: the contact node at its left and at its right end,
which are its two lines; None where a tail has none, so that (None, None) is the whole surface when
detached. Off the nodes a free surface is an array (2,) of its left and its right line [length],
-inf and inf where there is none.

A surface that no event ends or begins at is None there; a depth that is not known yet is nan, and
so are lines. Everything of a `Life` but its direction, nodes and trace is written later, by those
who refine it.

An `End` is a contact node or None. `Walk.tracks` leads from event to event: of each track, `at` is
the depth of the event at its end, None at the end of the route, `after` the contacts then, and
`trace` has the depths before it with the contacts from each on, as one row of nodes (first, last,
first, last, ...), which `paired` makes contacts again.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from discretization.lattice.walk import End, paired
from discretization.nodes.row import Contacts
from discretization.refine.nodes import FoundNodes
from energy.arrays import Array

Pair = tuple[End, End]
# Links that a line may pass at one depth and yet move smoothly off the nodes: a corner between two
# nodes may put the depths of neighbouring links into the wrong order. Where it does jump the energy
# is out of balance (`_creeps`). 1 or 4 changes none of 14 random states and paths (`python -m
# tests.sensitivity discretization.refine.lives`).
CREEPING = 2


class Piece(NamedTuple):
    """A smooth part of the life of a free surface.

    Attributes
    ----------
    depths : ndarray (j,)
        In the order of the route: the depths of Gauss-Lobatto points, as in balance.py [length].
    lines : ndarray (j, 2)
        Its left and its right line at these depths [length].
    """

    depths: Array
    lines: Array


@dataclass(eq=False)
class Life:
    """One free surface on its route in one direction.

    Attributes
    ----------
    nodes : FoundNodes
        The nodes that its trace is on.
    direction : {1, -1}
    trace : list of (float, (int or None, int or None))
        On nodes: depths, in the order of the route, with the surface's pair of contact nodes from
        there on [length]. The first depth is that at which it is born on the nodes.
    born : Happening or None
        The event at which it begins; None where the route begins with it.
    start, end : float
        Refined depths at which it begins and ends [length].
    first, last : ndarray (2,)
        Its refined lines there [length].
    pieces : list of Piece
        The refined motion in between, in the order of the route.
    passed : ndarray (p,)
        Depths of the ends of the p pieces times the direction, which increase [length].
    cuts : list of float
        Depths at which a line becomes pinned or free [length].
    """

    nodes: FoundNodes
    direction: int
    trace: list[tuple[float, Pair]]
    born: Happening | None = None
    start: float = math.nan
    end: float = math.nan
    first: Array = field(default_factory=lambda: np.full(2, math.nan))
    last: Array = field(default_factory=lambda: np.full(2, math.nan))
    pieces: list[Piece] = field(default_factory=list)
    passed: Array = field(default_factory=lambda: np.empty(0))
    cuts: list[float] = field(default_factory=list)

    def guess(self, depth: float) -> Array:
        """The positions (2,) of its nodes at a depth: about where its lines are [length].

        Before its birth on the nodes those at its birth, beyond its end the last ones.
        """
        return self.lines_at(self.pair(depth))

    def guesses(self, depths: Array) -> Array:
        """The same (n, 2) at depths (n,)."""
        passed = np.array([self.direction * depth for depth, _ in self.trace])
        last = np.searchsorted(passed, self.direction * depths, "right") - 1
        known, which = np.unique(np.maximum(last, 0), return_inverse=True)
        lines = np.array([self.lines_at(self.trace[i][1]) for i in known.tolist()])
        return lines[which]

    def pair(self, depth: float) -> Pair:
        """Its contact nodes at a depth, before its birth and beyond its end as in `guess`."""
        direction = self.direction
        last = bisect.bisect_right(
            self.trace, direction * depth, key=lambda passed: direction * passed[0]
        )
        return self.trace[max(last - 1, 0)][1]

    def lines_at(self, pair: Pair) -> Array:
        """The positions (2,) of a pair of nodes [length], -inf and inf where there is none."""
        left, right = pair
        where = self.nodes.positions
        one = -math.inf if left is None else where[left]
        other = math.inf if right is None else where[right]
        return np.array([one, other])


@dataclass(eq=False)
class Happening:
    """An event: free surfaces end and others begin.

    Attributes
    ----------
    at : float
        Its depth on the nodes [length].
    before, after : list of Life
        The surfaces that end and begin, from left to right: neighbours of each other. None ends at
        first touch and where a contact opens inside; none begins where a gap closes and at
        detachment.
    smooth : bool
        Whether no line jumps, as where a gap begins or ends with no width.
    depth : float
        Its refined depth [length]; nan until it is found.
    lines_before, lines_after : ndarray (n, 2)
        Refined lines of `before` and `after` at that depth, just before and after the event
        [length]; empty until they are found.
    """

    at: float
    before: list[Life]
    after: list[Life]
    smooth: bool = False
    depth: float = math.nan
    lines_before: Array = field(default_factory=lambda: np.empty((0, 2)))
    lines_after: Array = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def direction(self) -> int:
        """1 where the depth grows, -1 where it falls; there is a surface before or after."""
        return (self.before or self.after)[0].direction


class Walked(NamedTuple):
    """What happens to the free surfaces of a route on nodes.

    Attributes
    ----------
    first : list of Life
        The surfaces at the start, from left to right.
    events : list of Happening
        In the order of the route.
    """

    first: list[Life]
    events: list[Happening]


def walked(nodes: FoundNodes, contacts: Contacts, start: float, goal: float) -> Walked:
    """The lives of all free surfaces of contacts on nodes, on the route to a depth.

    Parameters
    ----------
    nodes : FoundNodes
    contacts : Contacts
        At rest on the nodes at the start.
    start, goal : float
        Depths [length].

    Returns
    -------
    Walked
    """
    direction = 1 if goal >= start else -1
    alive = [Life(nodes, direction, [(start, pair)]) for pair in pairs(contacts)]
    first = list(alive)
    events = list[Happening]()
    # Each track leads to the next event that the walk sees, and has the contacts after it.
    for track in nodes.walk.tracks(contacts, start, goal):
        before = paired(track.trace[-1][1])
        _write_traces(alive, track.trace)
        if track.at is None:
            break
        if _creeps(before, track.after):
            _write_traces(alive, [(track.at, tuple(itertools.chain(*track.after)))])
            continue
        found = _events_at(track.at, alive, pairs(before), pairs(track.after))
        events += found
        alive = _alive_after(found, alive)
    return Walked(first, events)


def _creeps(before: Contacts, after: Contacts) -> bool:
    """Whether contacts before and after an event differ by so few links that lines may not jump.

    Off the nodes they may then move smoothly. Where they do jump the energy of the surface does not
    balance, and closer nodes are needed.
    """
    if len(before) != len(after):
        return False
    return bool(np.abs(np.subtract(before, after)).max() <= CREEPING)


def pairs(contacts: Contacts) -> list[Pair]:
    """The pairs of contact nodes of all free surfaces of contacts, from left to right.

    One more than contacts; but [] where there is no contact.
    """
    if not contacts:
        return []
    ends: list[End] = [None]
    for contact in contacts:
        ends += contact
    ends.append(None)
    return list(zip(ends[::2], ends[1::2], strict=True))


def _write_traces(alive: list[Life], trace: Sequence[tuple[float, tuple[int, ...]]]) -> None:
    """Write the nodes at which lines are from depths on into the traces of their surfaces.

    alive: all surfaces from left to right; trace: depths in the order of the route, each with the
    first and last nodes of all contacts in one row: 2m nodes of always the same m contacts.
    """
    first_depth, first_nodes = trace[0]
    for surface, life in enumerate(alive):
        _write_pair(life, first_depth, _pair(first_nodes, surface))
    rows = np.array([nodes for _, nodes in trace])
    # Of a step only the surfaces are touched one of whose lines has moved. The first node of a
    # contact (even column) is the right end of a surface, the last one the left end of the next.
    for step, column in np.argwhere(np.diff(rows, axis=0)).tolist():
        depth, nodes = trace[step + 1]
        surface = (column + 1) // 2
        _write_pair(alive[surface], depth, _pair(nodes, surface))


def _write_pair(life: Life, depth: float, pair: Pair) -> None:
    """Add to the trace of a surface its contact nodes from a depth on, if they are others."""
    if life.trace[-1][1] != pair:
        life.trace.append((depth, pair))


def _pair(nodes: tuple[int, ...], surface: int) -> Pair:
    """The contact nodes of free surface number `surface` from the left.

    nodes: the first and last nodes of all contacts in one row.
    """
    left = nodes[2 * surface - 1] if surface > 0 else None
    right = nodes[2 * surface] if 2 * surface < len(nodes) else None
    return left, right


def _events_at(
    at: float, alive: list[Life], before: list[Pair], after: list[Pair]
) -> list[Happening]:
    """What happens at one depth of the nodes: an event for every part that does not feel others.

    before: the pairs of the surfaces alive; after: those of the surfaces that there are then.
    Pressed, a surface may only be divided, so that what becomes of it lies within it; retracted,
    surfaces may only be joined, so that those which become one lie within that.
    """
    nodes = alive[0].nodes
    direction = alive[0].direction
    found = list[Happening]()
    if direction > 0:
        unchanged = set(after)
        for life, pair in zip(alive, before, strict=True):
            if pair not in unchanged:
                inside = [new for new in after if _holds(pair, new)]
                found.append(_event_between([life], inside, at, nodes, direction))
        return found
    if not after:  # detached
        return [_event_between(list(alive), [], at, nodes, direction)]
    unchanged = set(before)
    for pair in after:
        if pair not in unchanged:
            joined = [life for life, old in zip(alive, before, strict=True) if _holds(pair, old)]
            found.append(_event_between(joined, [pair], at, nodes, direction))
    return found


def _event_between(
    before: list[Life], after: list[Pair], at: float, nodes: FoundNodes, direction: int
) -> Happening:
    """An event at which these surfaces end and new ones begin, between the given pairs of nodes.

    It is written into the new surfaces, too.
    """
    new = [Life(nodes, direction, [(at, pair)]) for pair in after]
    event = Happening(at, before, new)
    for life in new:
        life.born = event
    return event


def _holds(outer: Pair, inner: Pair) -> bool:
    """Whether one free surface covers all that another one would cover: no line of it is inside."""
    low, high = _bounds(outer)
    left, right = _bounds(inner)
    return low <= left and right <= high


def _bounds(pair: Pair) -> tuple[float, float]:
    """The nodes of a pair as numbers, -inf and inf where there is none."""
    left, right = pair
    return -math.inf if left is None else left, math.inf if right is None else right


def _alive_after(events: Sequence[Happening], alive: list[Life]) -> list[Life]:
    """The surfaces that there are after events, from left to right.

    alive: those before. What an event ends goes, what it begins comes, all others stay.
    """
    ended = {id(life) for event in events for life in event.before}
    kept = [life for life in alive if id(life) not in ended]
    kept += [life for event in events for life in event.after]
    return sorted(kept, key=lambda life: _bounds(life.trace[-1][1]))
