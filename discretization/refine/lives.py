"""The life of every free surface on the nodes, from the event it is born at to that it ends at.

As the depth changes in one direction, the free surfaces between and next to contacts do not feel
each other.
Pressed, a surface is divided where contacts begin in it, its lines jump, or it closes; retracted,
lines jump, and surfaces are joined where the contact between them is lost.
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
CREEPING = 2  # links that lines pass at once and may not jump over


class Piece(NamedTuple):
    """A smooth part of the life of a free surface.

    Attributes
    ----------
    depths : ndarray (j,)
        Gauss-Lobatto points of it, as in balance.py [length].
    lines : ndarray (j, 2)
        Of the surface at these depths [length].
    """

    depths: Array
    lines: Array


@dataclass(eq=False)
class Life:
    """One free surface on its route in one direction, 1 or -1 of growing or falling depth.

    Attributes
    ----------
    nodes : FoundNodes
    direction : {1, -1}
    trace : list of (float, (int or None, int or None))
        Depths, in the order of the route, with the contact nodes on both sides from there on.
    born, dies : Happening or None
        The events at which it begins and ends.
    start, end : float
        Depths of these, once refined [length].
    first, last : ndarray (2,)
        Lines there [length].
    pieces : list of Piece
        The motion in between.
    passed : ndarray (p,)
        Depths of the ends of the pieces times the direction, which increase [length].
    cuts : list of float
        Depths at which a line becomes pinned or free [length].
    """

    nodes: FoundNodes
    direction: int
    trace: list[tuple[float, Pair]]
    born: Happening | None = None
    dies: Happening | None = None
    start: float = math.nan
    end: float = math.nan
    first: Array = field(default_factory=lambda: np.full(2, math.nan))
    last: Array = field(default_factory=lambda: np.full(2, math.nan))
    pieces: list[Piece] = field(default_factory=list)
    passed: Array = field(default_factory=lambda: np.empty(0))
    cuts: list[float] = field(default_factory=list)

    def guess(self, depth: float) -> Array:
        """Lines (2,) at its nodes at a depth, or at those nearest to it on the route."""
        return self.lines_at(self.pair(depth))

    def guesses(self, depths: Array) -> Array:
        """Lines (n, 2) at its nodes at depths (n,), or at those nearest to them on the route."""
        passed = np.array([self.direction * depth for depth, _ in self.trace])
        last = np.searchsorted(passed, self.direction * depths, "right") - 1
        known, which = np.unique(np.maximum(last, 0), return_inverse=True)
        lines = np.array([self.lines_at(self.trace[i][1]) for i in known.tolist()])
        return lines[which]

    def pair(self, depth: float) -> Pair:
        """Its contact nodes at a depth, or those nearest to it on the route."""
        direction = self.direction
        last = bisect.bisect_right(
            self.trace, direction * depth, key=lambda passed: direction * passed[0]
        )
        return self.trace[max(last - 1, 0)][1]

    def lines_at(self, pair: Pair) -> Array:
        """The positions of two nodes, infinite where there is none."""
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
        The surfaces that end and begin, from left to right.
    smooth : bool
        Whether no line jumps, as where a gap begins or ends with no width.
    depth : float
        Its refined depth [length]; nan until it is found.
    lines_before, lines_after : ndarray (n, 2)
        Refined lines of the surfaces just before and after it [length].
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
        """1 where the depth grows, -1 where it falls."""
        return (self.before or self.after)[0].direction


class Walked(NamedTuple):
    """What happens to the free surfaces of a route on nodes.

    Attributes
    ----------
    first : list of Life
        The surfaces at the start, from left to right.
    events : list of Happening
        In the order of the route.
    reached : float
        The depth at the end [length].
    """

    first: list[Life]
    events: list[Happening]
    reached: float


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
    for track in nodes.walk.tracks(contacts, start, goal):
        last = paired(track.trace[-1][1])
        _noted(alive, track.trace)
        if track.at is None:
            break
        if _creeps(last, track.after):
            _noted(alive, [(track.at, tuple(itertools.chain(*track.after)))])
            continue
        found = _divided(alive, pairs(last), pairs(track.after), track.at)
        events += found
        alive = _alive(alive, found)
    return Walked(first, events, goal)


def _creeps(before: Contacts, after: Contacts) -> bool:
    """Whether lines pass so few links at once that off the nodes they may move smoothly.

    Where they do jump the energy of the surface does not balance, and closer nodes are needed.
    """
    if len(before) != len(after):
        return False
    return bool(np.abs(np.subtract(before, after)).max() <= CREEPING)


def pairs(contacts: Contacts) -> list[Pair]:
    """The contact nodes on both sides of every free surface; [] where there is no contact."""
    if not contacts:
        return []
    ends: list[End] = [None]
    for contact in contacts:
        ends += contact
    ends.append(None)
    return list(zip(ends[::2], ends[1::2], strict=True))


def _noted(alive: list[Life], trace: Sequence[tuple[float, tuple[int, ...]]]) -> None:
    """Write the nodes at which lines are from depths on into the traces of their surfaces.

    trace: these depths, and the first and last nodes of all contacts in one row.
    """
    first, nodes = trace[0]
    for k, life in enumerate(alive):
        _passed(life, first, _pair(nodes, k))
    rows = np.array([nodes for _, nodes in trace])
    for step, column in np.argwhere(np.diff(rows, axis=0)).tolist():
        depth, nodes = trace[step + 1]
        surface = (column + 1) // 2
        _passed(alive[surface], depth, _pair(nodes, surface))


def _passed(life: Life, depth: float, pair: Pair) -> None:
    """Write into a surface between which nodes it is from a depth on."""
    if life.trace[-1][1] != pair:
        life.trace.append((depth, pair))


def _pair(nodes: tuple[int, ...], surface: int) -> Pair:
    """The contact nodes of a free surface, of the first and last nodes of all contacts."""
    left = nodes[2 * surface - 1] if surface > 0 else None
    right = nodes[2 * surface] if 2 * surface < len(nodes) else None
    return left, right


def _divided(
    alive: list[Life], before: list[Pair], after: list[Pair], at: float
) -> list[Happening]:
    """What happens to which surfaces at an event, those apart that do not feel each other."""
    direction = alive[0].direction
    found = list[Happening]()
    if direction > 0:
        unchanged = set(after)
        for life, pair in zip(alive, before, strict=True):
            if pair in unchanged:
                continue
            inside = [new for new in after if _holds(pair, new)]
            found.append(_happening(at, [life], inside, life.nodes, direction))
        return found
    if not after:
        return [_happening(at, list(alive), [], alive[0].nodes, direction)]
    unchanged = set(before)
    for pair in after:
        if pair in unchanged:
            continue
        joined = [life for life, old in zip(alive, before, strict=True) if _holds(pair, old)]
        found.append(_happening(at, joined, [pair], alive[0].nodes, direction))
    return found


def _happening(
    at: float, before: list[Life], after: list[Pair], nodes: FoundNodes, direction: int
) -> Happening:
    """An event, tied to the surfaces that end and begin at it."""
    new = [Life(nodes, direction, [(at, pair)]) for pair in after]
    event = Happening(at, before, new)
    for life in before:
        life.dies = event
    for life in new:
        life.born = event
    return event


def _holds(outer: Pair, inner: Pair) -> bool:
    """Whether one part of the row contains another."""
    low, high = _bounds(outer)
    left, right = _bounds(inner)
    return low <= left and right <= high


def _bounds(pair: Pair) -> tuple[float, float]:
    left, right = pair
    return -math.inf if left is None else left, math.inf if right is None else right


def _alive(alive: list[Life], events: Sequence[Happening]) -> list[Life]:
    """The surfaces after events, from left to right."""
    ended = {id(life) for event in events for life in event.before}
    kept = [life for life in alive if id(life) not in ended]
    kept += [life for event in events for life in event.after]
    return sorted(kept, key=lambda life: _bounds(life.trace[-1][1]))
