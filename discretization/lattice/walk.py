"""Contacts on nodes followed as the depth changes: a walk from change to change.

Contacts are node intervals ((first, last), ...), and between and beside them lie free parts, each
given by the contact node on its left and on its right (None: none there). In contact the
displacement is prescribed, so that free parts do not feel each other: each has a next change of its
own, at a depth known in closed form (rules.py). With growing depth a line passes a link, two lines
that face each other do so at once, or a free node touches; with falling depth a line, or two, open
a link, a node inside a contact is torn open, or a lone node lets go. The earliest change on the way
happens. Changes that follow at no other depth belong to it: together they are an event, if they
release energy or leave another number of contacts. A line that moves link by link at depths of
their own releases nothing, so that a branch walked there and back has no loop area.
"""

from __future__ import annotations

import functools
import itertools
import math
from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import EPSILON
from discretization.lattice.line import offsets, offsets_of, outwards, positions
from discretization.nodes.row import Contacts, Row

Array = NDArray[np.float64]
Part = tuple[int | None, int | None]  # contact nodes on both sides of a free surface; None: none
Lines = tuple[float, ...]  # x of all lines
_ROUNDING = 16 * EPSILON  # of x: by less no line has moved
_LEAST = 1e-10  # of the adhesion of one link: rounding of U, relative to that


class Change(NamedTuple):
    """What happens first to a part or contact: those from `start` to `stop` become `parts`.

    start, stop: counted from the part, or from the part on the left of the contact.
    """

    depth: float
    start: int
    stop: int
    parts: tuple[Part, ...]


class Way(NamedTuple):
    """How contacts come to a depth, or to an event before it.

    trace: the depth at which contacts become others, and these, in the order of the way; first its
    start; at: the depth of the event, None if there is none; after: the contacts after it.
    """

    trace: list[tuple[float, Contacts]]
    at: float | None
    after: Contacts


def parts_of(nodes: Contacts) -> list[Part]:
    """All free parts from left to right."""
    ends = [None, *(node for pair in nodes for node in pair), None]
    return list(zip(ends[::2], ends[1::2], strict=True))


def contacts_of(parts: Sequence[Part]) -> Contacts:
    """The contacts between these free parts."""
    inner = [node for part in parts for node in part if node is not None]
    return tuple(zip(inner[::2], inner[1::2], strict=True))


class Walk:
    """The walks over one row of nodes; what has been asked of a free part is remembered."""

    def __init__(self, row: Row) -> None:
        self.row = row
        self.closing, self.opening = row.rules

    def touched(self, depth: float) -> Contacts:
        """The contacts at a depth to which the indenter has been pressed from first touch on."""
        touch = self.row.touch
        return () if self.row.lowest > depth else self.moved(((touch, touch),), depth)

    def moved(self, nodes: Contacts, depth: float) -> Contacts:
        """Contacts at rest, once they have come to this depth, whatever happens on the way."""
        if self.row.clear:
            return self._alone(nodes, depth)
        rises = self.first(parts_of(nodes), 1)[0].depth <= depth
        way = self.way(nodes, -math.inf if rises else math.inf, depth)
        while way.at is not None:
            way = self.way(way.after, way.at, depth)
        return way.after

    def _alone(self, nodes: Contacts, depth: float) -> Contacts:
        """The same of one convex contact: lines advance to the first link that resists.

        Or they come back to the last one that still holds.
        """
        ends, touch, most = [], self.row.touch, self.row.size - 1
        for side, node in zip((-1, 1), nodes[0], strict=True):
            first, at = (touch, node) if side > 0 else (most - touch, most - node)
            at += int((self.closing.outwards[side][at:] > depth).argmax())
            holding = np.flatnonzero(self.opening.outwards[side][first:at] <= depth)
            ends.append(touch + side * int(np.max(holding + 1, initial=0)))
        left, right = ends
        return ((left, right),) if left < right or depth >= self.row.lowest else ()

    def way(self, nodes: Contacts, start: float, end: float) -> Way:
        """The way to another depth, up to the first event."""
        parts, trace, sign = parts_of(nodes), [(start, nodes)], 1 if end >= start else -1
        depth, changes = start, 0
        while True:
            change, i = self.first(parts, sign)
            last = sign * (change.depth - end) >= 0 and (sign < 0 or change.depth > end)
            if last or sign * (change.depth - depth) > 0:  # all at a depth has happened
                after = contacts_of(parts)
                if self._happens(trace[-1][1], after, changes, depth):
                    return Way(trace, depth, after)
                trace += [(depth, after)] if changes else []
                if last:
                    return Way(trace, None, after)
                changes = 0
                if slid := self._slid(parts, depth, end):
                    trace += slid
                    depth, after = slid[-1]
                    parts = parts_of(after)
                    continue
                depth = sign * max(sign * depth, sign * change.depth)
            parts[i + change.start : i + change.stop] = change.parts
            changes += 1

    def _slid(self, parts: list[Part], depth: float, end: float) -> list[tuple[float, Contacts]]:
        """The links that the lines of one convex contact pass one by one on the way.

        Up to the first of both lines that is passed at no depth of its own; the last two links of a
        contact are left to the other rules.
        """
        if len(parts) != 2 or not self.row.clear:
            return []
        ((first, last),), sign = contacts_of(parts), 1 if end >= depth else -1
        rules, stop, found = self.closing if sign > 0 else self.opening, end, []
        for side, at in ((-1, self.row.size - 1 - first), (1, last)):
            ahead = rules.outwards[side][at:]
            if sign < 0:
                ahead = rules.outwards[side][at - (last - first) : at][::-1]
            late = sign * ahead <= sign * np.append(depth, ahead[:-1])
            count = int(late.argmax()) if late.any() else ahead.size
            if late.any():
                stop = sign * min(sign * stop, sign * float(ahead[count - 1] if count else depth))
            found.append(ahead[:count])
        found = [when[sign * when < sign * stop] for when in found]
        when = np.concatenate(found)
        order = np.argsort(sign * when, kind="stable")
        order = order if sign > 0 else order[: max(last - first - 2, 0)]
        left = order < found[0].size
        lefts = (first - sign * np.cumsum(left)).tolist()
        rights = (last + sign * np.cumsum(~left)).tolist()
        nodes = ((pair,) for pair in zip(lefts, rights, strict=True))
        return list(zip(when[order].tolist(), nodes, strict=True))

    def first(self, parts: Sequence[Part], sign: int) -> tuple[Change, int]:
        """What happens first as the depth changes this way, and to which part or contact."""
        if len(parts) < 2:
            return Change(sign * math.inf, 0, 0, ()), 0
        found = self.changes(parts, sign)
        depths = [sign * change.depth for change in found]
        i = depths.index(min(depths))
        return found[i], i if i < len(parts) else i - len(parts)

    def changes(self, parts: Sequence[Part], sign: int) -> list[Change]:
        """The first change of each part, and, as the depth falls, of each contact."""
        if sign > 0:
            return [self.rise(part) for part in parts]
        pairs = list(itertools.pairwise(parts))
        lone = [one[1] == other[0] for one, other in pairs]
        keys = zip(parts, [True, *lone], [*lone, True], strict=True)
        return [*itertools.starmap(self._fall, keys), *itertools.starmap(self._split, pairs)]

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def rise(self, part: Part) -> Change:
        """The first change of a free part as the depth grows."""
        rules, (left, right) = self.closing, part
        depth, node = rules.touches(left, right)
        parts: list[Part] = [(left, node), (node, right)]
        for side, line, other in ((1, left, right), (-1, right, left)):
            if line is not None and 0 <= line + side < rules.f.size:
                new = (line + side, other)[::side]
                at = rules.passes(line, side, other)
                if at < depth and rules.clears(new[0], new[1], at):
                    depth, parts = at, [(new[0], new[1])]
        if left is not None and right is not None and right - left > 2:
            at = rules.passes_both(left, right)
            if at < depth and rules.clears(left + 1, right - 1, at):
                depth, parts = at, [(left + 1, right - 1)]
        return Change(depth, 0, 1, tuple(filter(_is_free, parts)))

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def _fall(self, part: Part, left_fixed: bool, right_fixed: bool) -> Change:
        """The first move of the lines of a free part as the depth falls; fixed: of a lone node."""
        rules, (left, right), found = self.opening, part, [_NEVER]
        if left is not None and not left_fixed:
            depth = rules.passes(left - 1, 1, right)
            found.append(Change(depth, 0, 1, ((left - 1, right),)))
        if right is not None and not right_fixed:
            depth = rules.passes(right + 1, -1, left)
            found.append(Change(depth, 0, 1, ((left, right + 1),)))
        if left is not None and right is not None and len(found) == 3:
            ends = left - 1, right + 1
            depth = min(rules.passes_both(*ends), rules.touches(*ends)[0])
            found.append(Change(depth, 0, 1, ((left - 1, right + 1),)))
        return max(found, key=lambda change: change.depth)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def _split(self, one: Part, other: Part) -> Change:
        """Where the contact between two parts lets go, or is torn open inside."""
        rules, ((before, first), (last, after)) = self.opening, (one, other)
        assert first is not None and last is not None
        if first == last:
            return Change(rules.pulled(before, first, after), 0, 2, ((before, after),))
        if last - first > 1 and not rules.clear:  # lines of a convex contact recede
            depth, node = rules.tears(first, last)
            return Change(depth, 1, 1, ((node - 1, node + 1),))
        return _NEVER

    def _happens(self, before: Contacts, after: Contacts, changes: int, depth: float) -> bool:
        """Whether changes at one depth are an event: they release energy, or contacts differ.

        Energy that is not lost to adhesion hysteresis anyway. Without adhesion the energy is
        convex, and nothing is ever released.
        """
        least = _LEAST * float(self.opening.work.max(initial=0.0))
        if len(before) != len(after) or changes < 2 or not least:
            return len(before) != len(after)
        here, (closing, opening) = np.array([depth]), self.row.works
        one, other = (
            self.row.totals(np.reshape(nodes, (1, -1)), here)[0, 0] for nodes in (before, after)
        )
        opened = max(0.0, self.row.bonded(before) - self.row.bonded(after))
        return float(one - other) - opened * (opening - closing) > least


def _is_free(part: Part) -> bool:
    """Whether there is a free node between these contact nodes."""
    left, right = part
    return left is None or right is None or right - left > 1


_NEVER = Change(-math.inf, 0, 0, ())


def moved_lines(
    row: Row, nodes: NDArray[np.int64], depth: Array, before: tuple[Contacts, Lines] | None
) -> list[Lines]:
    """Where lines of contacts (s, 2m) are at depths (s,) that came from these; None: from none.

    A line that is still at its node comes from where it was, to the last bit if it has not moved;
    others come from the side on which their contacts were.
    """
    contacts, lines = ((), ()) if before is None else before
    was = np.array(contacts, int).reshape(1, -1)
    facing = list(zip(outwards(was.size).tolist(), was[0].tolist(), strict=True))
    known = dict(zip(facing, lines, strict=True))
    there = dict(zip(facing, offsets_of(row, was, np.array(lines))[0].tolist(), strict=True))
    sides = outwards(nodes.shape[1]).tolist()
    asked = [list(zip(sides, each, strict=True)) for each in nodes.tolist()]
    came = [
        [there.get(key, 1.0 if _in_contact(contacts, key[1]) else -1.0) for key in keys]
        for keys in asked
    ]
    found = positions(row, nodes, offsets(row, nodes, depth, np.array(came)))
    near = _ROUNDING * float(np.abs(found).max())
    return [
        tuple(
            known[key] if abs(known.get(key, math.inf) - x) <= near else x
            for key, x in zip(keys, each, strict=True)
        )
        for keys, each in zip(asked, found.tolist(), strict=True)
    ]


def _in_contact(nodes: Contacts, node: int) -> bool:
    i = bisect_right(nodes, (node, node)) - 1
    beside = nodes[max(i, 0) : i + 2]
    return any(first <= node <= last for first, last in beside)
