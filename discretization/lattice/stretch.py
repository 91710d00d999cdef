"""The way of contacts at rest to another depth, up to what may be a jump, and the work on it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.changes import Contacts, contacts_of, parts, retracted
from discretization.lattice.row import Row
from discretization.lattice.rules import Rules
from discretization.lattice.ways import Part, Way, fallen, part_pressed, risen

Array = NDArray[np.float64]


class Stretch(NamedTuple):
    """The way from contacts at rest to a depth, or to what may be a jump before it.

    ways: of the free parts; at: the depth of the possible jump, None if there is none; before,
    after: the contacts just before and after it, or at the end.
    """

    ways: list[Way]
    rising: bool
    at: float | None
    before: Contacts
    after: Contacts


def stretch(closing: Rules, opening: Rules, nodes: Contacts, depth: float) -> Stretch:
    """The way of contacts at rest to a depth, up to what may be a jump."""
    ways = [risen(closing, *part, depth) for part in parts(nodes)]
    if any(way.depths.size or way.stop is not None for way in ways):
        at = min((way.stop for way in ways if way.stop is not None), default=None)
        before = _between(ways, at, rising=True)
        after = before if at is None else _pressed(closing, ways, at)
        return Stretch(ways, True, at, before, after)
    ends = [None, *(node for pair in nodes for node in reversed(pair)), None]
    ways = [
        fallen(opening, *part, ends[2 * i], ends[2 * i + 1], depth)
        for i, part in enumerate(parts(nodes))
    ]
    at = max(_openings(opening, nodes, ways, depth), default=None)
    before = _between(ways, at, rising=False)
    after = before
    if at is not None:
        after = retracted(opening, before, math.nextafter(at, -math.inf))
    return Stretch(ways, False, at, before, after)


def _pressed(closing: Rules, ways: list[Way], at: float) -> Contacts:
    """The contacts after what happens at this depth, which is where some ways stop."""
    ends: list[Part] = []
    for way in ways:
        part = way.before(at, rising=True)
        stops = way.stop is not None and way.stop <= at
        own = way.before(math.nextafter(at, math.inf), rising=True)
        ends += part_pressed(closing, *part, at) if stops else [own]
    return contacts_of(ends)


def _openings(opening: Rules, nodes: Contacts, ways: list[Way], depth: float) -> Iterator[float]:
    """Depths at which something else than one link may open on these ways."""
    yield from (way.stop for way in ways if way.stop is not None)
    for (first, last), left, right in zip(nodes, ways, ways[1:], strict=False):
        links = last - first
        if left.depths.size + right.depths.size >= links > 0:
            opened = np.sort(np.concatenate([left.moves(1), right.moves(-1)]))[::-1]
            yield from opened[links - 1 : links].tolist()
        if not links:
            yield from _let_go(opening, first, left, right, depth)
        if links > 1 and opening.most_torn > depth:
            yield from _torn(opening, first, last, left, right, depth)


def _let_go(opening: Rules, node: int, left: Way, right: Way, depth: float) -> Iterator[float]:
    """The depth at which a lone node lets go between two free parts that change there."""
    changes = np.sort(np.concatenate([left.moves(-1), right.moves(1)]))[::-1]
    ends = [math.inf, *changes.tolist(), depth]
    for upper, lower in itertools.pairwise(ends):
        around = left.before(lower, rising=False)[0], right.before(lower, rising=False)[1]
        at = min(upper, opening.pulled(around[0], node, around[1]))
        if at > lower:
            yield at
            return


def _torn(
    opening: Rules, first: int, last: int, left: Way, right: Way, depth: float
) -> Iterator[float]:
    """The first depth at which a node is torn open that neither line has passed before."""
    torn = opening.torn[first + 1 : last]
    for i in np.argsort(-torn, kind="stable").tolist():
        at, node = float(torn[i]), first + 1 + i
        if at <= depth:
            return
        inside = left.before(at, rising=False)[1], right.before(at, rising=False)[0]
        if (inside[0] or 0) < node < (inside[1] or 0):
            yield at
            return


def _between(ways: list[Way], depth: float | None, *, rising: bool) -> Contacts:
    """The contacts between these free parts just before a depth, or at their ends."""
    ends: list[Part] = [way.end if depth is None else way.before(depth, rising) for way in ways]
    return contacts_of(ends)


def work_of(row: Row, ways: list[Way], start: float, end: float) -> float:
    """∫P dd on the ways of all free parts, each of which adds to P with its lines."""
    sign, done = (1 if end >= start else -1), 0.0
    gaps: tuple[list[float], list[float], list[int], list[int]] = ([], [], [], [])
    for way in ways:
        count = int(np.searchsorted(sign * way.depths, sign * end))
        cuts = [start, *way.depths[:count].tolist(), end]
        if way.left is None or way.right is None:
            done += _outer_work(row, way, np.array(cuts))
            continue
        gaps[0].extend(cuts[:-1])
        gaps[1].extend(cuts[1:])
        gaps[2].extend(way.left[: count + 1])
        gaps[3].extend(way.right[: count + 1])
    low, high, left, right = map(np.array, gaps)
    if not low.size:
        return done
    return done + _over(low, high, lambda depth: row.gap_force(left, right, depth))


def _over(low: Array, high: Array, force: Callable[[Array], Array]) -> float:
    """Σ ∫ force dd from each of these depths to the other."""
    return float((high - low) @ force((low + high) / 2))  # linear in between


def _outer_work(row: Row, way: Way, cuts: Array) -> float:
    """The part of an outermost line, which passes a link at each of the inner cuts."""
    line, side = (way.left, 1) if way.left is not None else (way.right, -1)
    assert isinstance(line, range)
    nodes = line.start + line.step * np.arange(cuts.size - 1)
    return _over(cuts[:-1], cuts[1:], lambda depth: row.tail_force(nodes, side, depth))
