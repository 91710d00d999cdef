"""Contacts on nodes followed as the depth changes: a walk from change to change.

Contacts are node intervals ((first, last), ...), and between and beside them lie free surfaces,
each given by the contact node on its left and on its right (None: none there). In contact the
displacement is prescribed, so that free surfaces do not feel each other: each has a next change of
its own, at a depth known in closed form (thresholds.py). With growing depth a line passes a link,
two lines that face each other do so at once, or a free node touches; with falling depth a line, or
two, open a link, a node inside a contact opens, or a lone node does: as soon as it is pulled, or,
where it stands for a contact narrower than a link, when that is lost (loss.py). The earliest change
happens: a heap has the next one of every part (`Front`), a free surface or a contact. Changes that
follow at no other depth belong to it: together they are an event, if they release energy or leave
another number of contacts.
"""

import functools
import heapq
import itertools
import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from discretization.lattice.loss import ContactLoss, is_lost_smoothly
from discretization.nodes.row import Contacts, Row
from energy.arrays import Array

End = int | None  # the contact node on one side of a free surface; None: none there
Part = tuple[int, ...]  # the nodes on which a next change depends
_ROUNDING = 1e-10  # of the adhesion of one link: an event releases more, less is rounding of U
_LOOKED = 1 << 9  # links whose depths are found at once: by then arrays cost little per link
_JUMPING = 6  # changes at one depth, after which a line is taken to jump and passes many at once


class Change(NamedTuple):
    """What happens first to a free surface or a contact: its two ends become these."""

    depth: float
    ends: tuple[End, ...]


class Track(NamedTuple):
    """How contacts come to a depth, or to an event before it.

    Attributes
    ----------
    trace : list of (float, tuple of int)
        The depths at which contacts become others, and the first and last nodes of all of these in
        one row, in the order of the path; first its start.
    at : float or None
        The depth of the event, None if there is none [length].
    after : Contacts
        The contacts after it.
    """

    trace: list[tuple[float, tuple[int, ...]]]
    at: float | None
    after: Contacts


_NEVER = Change(-math.inf, ())


def paired(nodes: Sequence[int]) -> Contacts:
    """Contacts by their first and last nodes.

    Parameters
    ----------
    nodes : sequence of int
        These of all contacts in one row.

    Returns
    -------
    Contacts
    """
    return tuple(zip(nodes[::2], nodes[1::2], strict=True))


def ends_of(nodes: Contacts) -> list[End]:
    """The ends of all free surfaces, and in between of all contacts, from left to right.

    Parameters
    ----------
    nodes : Contacts
        First and last nodes of the contacts.

    Returns
    -------
    list of (int or None)
        None first and last.
    """
    return [None, *itertools.chain(*nodes), None]


def contacts_of(ends: Sequence[End]) -> Contacts:
    """The contacts between ends of free surfaces."""
    return paired([end for end in ends if end is not None])


def _free(*parts: tuple[End, End]) -> tuple[End, ...]:
    """The ends of those of these parts that have a free node."""
    return tuple(
        end
        for left, right in parts
        if left is None or right is None or right - left > 1
        for end in (left, right)
    )


class Walk:
    """The walks over one row of nodes; next changes of free surfaces are remembered.

    Parameters
    ----------
    row : Row
    narrow : bool
        Whether lone nodes stand for contacts narrower than a link, up to where these are lost; else
        they let go as soon as they are pulled.
    """

    def __init__(self, row: Row, *, narrow: bool = False) -> None:
        self.row = row
        self.closing, self.opening = row.thresholds
        self.lines = ContactLoss(row, self.opening) if narrow and is_lost_smoothly(row) else None
        self.weakest: dict[tuple[int, int], int] = {}  # of contacts: the node that opens first

    def touched(self, depth: float) -> Contacts:
        """The contacts at a depth to which the indenter has been pressed from first touch on.

        Parameters
        ----------
        depth : float
            [length].

        Returns
        -------
        Contacts
            () before first touch.
        """
        touch = self.row.touch
        lowest = self.row.lowest
        if lowest > depth:
            return ()
        return self.moved(((touch, touch),), lowest, depth)

    def moved(self, nodes: Contacts, start: float, depth: float) -> Contacts:
        """What contacts at rest have become once they have come from one depth to another.

        Parameters
        ----------
        nodes : Contacts
        start, depth : float
            [length].

        Returns
        -------
        Contacts
        """
        sign = 1 if depth >= start else -1
        if not self.row.clear:
            tracks = list(self.tracks(nodes, start, depth))
            return tracks[-1].after
        ((first, last),) = nodes
        ahead_left, ahead_right = self._ahead(nodes, sign)
        first -= sign * self._links(*ahead_left, sign, depth)
        last += sign * self._links(*ahead_right, sign, depth)
        if first < last:
            return ((first, last),)
        touch = self.row.touch
        return ((touch, touch),) if depth >= self.row.lowest else ()

    def _ahead(self, nodes: Contacts, sign: int) -> Sequence[tuple[range, int]]:
        """For each line of one contact the nodes before the links it passes next, and its side."""
        ((first, last),) = nodes
        if sign > 0:
            return (range(first, 0, -1), -1), (range(last, self.row.size - 1), 1)
        return (range(first + 1, last + 1), -1), (range(last - 1, first - 1, -1), 1)

    def _passed(self, ahead: range, side: int, sign: int) -> Array:
        """± the depths at which a line of one convex contact has passed these links."""
        nodes = np.arange(ahead.start, ahead.stop, ahead.step)
        thresholds = self.closing if sign > 0 else self.opening
        return np.maximum.accumulate(sign * thresholds.advance_of_outermost(nodes, side))

    def _links(self, ahead: range, side: int, sign: int, depth: float) -> int:
        """How many of these links the line passes until the depth is reached.

        When pressing, threshold depths increase outwards, so that sampling suffices.
        """
        stride = 1 if sign < 0 else 1 + len(ahead) // _LOOKED
        passed = self._passed(ahead[::stride], side, sign)
        count = int(passed.searchsorted(sign * depth, "right" if sign > 0 else "left"))
        if stride == 1:
            return count
        start = max(count - 1, 0) * stride
        return start + self._links(ahead[start : start + stride], side, sign, depth)

    def track(self, nodes: Contacts, start: float, end: float) -> Track:
        """The path from one depth to another, up to the first event.

        Parameters
        ----------
        nodes : Contacts
            At rest at the start.
        start, end : float
            Depths [length].

        Returns
        -------
        Track
        """
        return next(self.tracks(nodes, start, end))

    def tracks(self, nodes: Contacts, start: float, end: float) -> Iterator[Track]:
        """The same from event to event, until the last depth or the loss of all contact."""
        sign = 1 if end >= start else -1
        front = Front(self, nodes, sign)
        depth = start
        while True:
            track, front = self._tracked(front, depth, end)
            yield track
            if track.at is None or not track.after:
                return
            depth = track.at

    def track_part(self, surfaces: Sequence[tuple[End, End]], start: float, end: float) -> Track:
        """The path of neighbouring free surfaces alone, as far as they do not feel others.

        Parameters
        ----------
        surfaces : sequence of pairs of int or None
            The contact nodes at both ends of each; None: there is none.
        start, end : float
            Depths [length].

        Returns
        -------
        Track
            Contacts next to the surfaces reach as far as their lines have come. Receding outermost
            lines stay.
        """
        sign = 1 if end >= start else -1
        first, *inner, last = itertools.chain(*surfaces)
        nodes = paired([end for end in inner if end is not None])
        track, _ = self._tracked(Front(self, nodes, sign, (first, last)), start, end)
        return track

    def _tracked(self, front: "Front", start: float, end: float) -> tuple[Track, "Front"]:
        """The path of a front to another depth, up to the first event, and the front there.

        Change after change happens, the earliest first. Once the next one is at another depth, all
        that has happened at this one is judged together: it is an event, and the path ends, or the
        contacts are recorded and the path goes on. Where many changes have happened at one depth a
        line jumps: then it passes as many links at once as it will.
        """
        sign = front.sign
        trace = [(start, front.nodes)]
        depth = start
        changes = 0  # at this depth
        changes_at_jump = 0  # how many of these there were when a line last passed many links
        while True:
            change, place = front.first()
            last = change.depth > end if sign > 0 else change.depth <= end
            if last or sign * (change.depth - depth) > 0:  # all at this depth has happened
                after = front.nodes
                if self._is_jump(trace[-1][1], after, changes, depth):
                    return Track(trace, depth, paired(after)), front
                if changes:
                    trace.append((depth, after))
                if last:
                    return Track(trace, None, paired(after)), front
                changes = 0
                changes_at_jump = 0
                smooth = self._smooth_steps(after, depth, end)
                if smooth:
                    trace += smooth
                    depth, after = smooth[-1]
                    front = Front(self, paired(after), sign)
                    continue
                depth = change.depth
            if changes - changes_at_jump >= _JUMPING and place % 2 == 0:
                changes_at_jump = changes
                jumped = self._jumped(front, place, depth)
                change = change._replace(ends=jumped or change.ends)
            front.apply(change, place)
            changes += 1

    def _jumped(self, front: "Front", place: int, depth: float) -> tuple[End, ...]:
        """The ends of a free surface once its lines have passed all links they do at a depth.

        One line passes all that it does while the other one stays, as long as no node touches, then
        the other: what is in contact at the end does not depend on the order, as the energy is
        submodular (nodes/thresholds.py). The last links of a surface, or of a contact, are left;
        () if no link is passed.
        """
        if self.row.clear or self.row.lattice.axis == 0:
            return ()
        left_start, right_start = front.ends[place : place + 2]
        left_room, right_room = front.rooms(place)
        left = left_start
        right = right_start
        while True:
            before = (left, right)
            room = left_room - (left_start - left)
            left += self._passed_at(left, right, 1, front.sign, depth, room)
            room = right_room - (right - right_start)
            right -= self._passed_at(right, left, -1, front.sign, depth, room)
            if (left, right) == before:
                break
        if (left, right) == (left_start, right_start):
            return ()
        return _node(left, self.row.size), _node(right, self.row.size)

    def _passed_at(
        self, line: int, other: int, side: int, sign: int, depth: float, room: int
    ) -> int:
        """How many links one line passes in a direction at a depth; less than 0 if it recedes.

        side: where the free surface is; room: links of the contact behind the line.
        """
        size = self.row.size
        if line in (-1, size):
            return 0
        thresholds = self.closing if sign > 0 else self.opening
        facing = _node(other, size)
        links = abs(other - line) - 3 if sign > 0 else room - 2
        links = min(links, _LOOKED)
        if links < 1:
            return 0
        if sign > 0:
            passed = thresholds.advances(line + side * np.arange(links), side, facing) <= depth
        else:
            passed = (
                thresholds.advances(line - side * np.arange(1, links + 1), side, facing) > depth
            )
        count = links if passed.all() else int(passed.argmin())
        if sign < 0:
            return -count
        return bisect_left(
            range(1, count + 1),
            True,
            key=lambda moved: not self._clear_beyond(line + side * moved, side, facing, depth),
        )

    def _clear_beyond(self, line: int, side: int, facing: End, depth: float) -> bool:
        """Whether the surface on a side of a line clears the indenter."""
        left, right = (line, facing) if side > 0 else (facing, line)
        return self.closing.clears(left, right, depth)

    def _smooth_steps(
        self, nodes: tuple[int, ...], depth: float, end: float
    ) -> list[tuple[float, tuple[int, ...]]]:
        """The links that the lines of one convex contact pass towards a depth, each at its own.

        Depths with the nodes of the contact, up to the first link that is passed at no depth of its
        own, and not the last two links of a contact. None of contacts that are not convex.
        """
        if len(nodes) != 2 or not self.row.clear:
            return []
        first, last = nodes
        sign = 1 if end >= depth else -1
        passed = [self._passed(*ahead, sign) for ahead in self._ahead(((first, last),), sign)]
        stop = sign * end
        for line in passed:
            together = line <= np.append(sign * depth, line[:-1])
            stop = min(stop, float(line[together].min(initial=math.inf)))
        depths = np.unique(np.concatenate(passed))
        depths = depths[depths < stop]
        left_links, right_links = (line.searchsorted(depths, "right") for line in passed)
        lefts = (first - sign * left_links).tolist()
        rights = (last + sign * right_links).tolist()
        steps = zip((sign * depths).tolist(), lefts, rights, strict=True)
        return [(at, (i, j)) for at, i, j in steps if sign > 0 or j - i > 1]

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def rise(self, left: Any, right: Any) -> Change:
        """The first change of a free surface as the depth grows.

        Parameters
        ----------
        left, right : int or None
            Contact nodes at its ends; None: there is none.

        Returns
        -------
        Change
        """
        thresholds = self.closing
        touching, node = thresholds.touches(left, right)
        found = Change(touching, _free((left, node), (node, right)))
        moves = []
        if left is not None:
            moves.append((thresholds.advance(left, 1, right), (left + 1, right)))
        if right is not None:
            moves.append((thresholds.advance(right, -1, left), (left, right - 1)))
        if left is not None and right is not None:
            moves.append((thresholds.advance_both(left, right), (left + 1, right - 1)))
        for depth, part in moves:
            if depth >= found.depth:
                continue
            if thresholds.clears(*part, depth):
                found = Change(depth, _free(part))
            else:
                found = self._with_touch((left, right), part, depth, found)
        return found

    def _with_touch(self, own: Any, part: Any, depth: float, later: Change) -> Change:
        """A line passes a link as a node touches that would then be in the indenter, or `later`.

        That happens at the depth at which both together leave U as it is. The energy that they
        release is a parabola of the depth: it is read at three depths between that of the link
        alone and that of `later`, and its zero found by the formula that subtracts nothing.

        Parameters
        ----------
        own : tuple of (int or None)
            Contact nodes at the ends of the free surface.
        part : tuple of (int or None)
            The same once the line has passed the link.
        depth : float
            The depth at which the line alone would pass the link [length].
        later : Change
            What happens otherwise, at a larger depth.

        Returns
        -------
        Change
        """
        _, node = self.closing.touches(*part)
        ends = _free((part[0], node), (node, part[1]))
        before = contacts_of((own[0], *own, own[1]))
        after = contacts_of((own[0], *ends, own[1]))

        def released(d: float) -> float:
            """U before less U after."""
            return self.energy(before, d) - self.energy(after, d)

        first = released(depth)
        middle = released((depth + later.depth) / 2)
        last = released(later.depth)
        if last <= 0:
            return later
        linear = 4 * middle - 3 * first - last
        bend = 2 * (first + last - 2 * middle)
        root = linear + math.sqrt(max(linear**2 - 4 * bend * first, 0.0))
        share = -2 * first / root if first < 0 else 0.0
        return Change(depth + share * (later.depth - depth), ends)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def fall(self, left: Any, right: Any, left_lone: bool, right_lone: bool) -> Change:
        """The first move of the lines of a free surface as the depth falls; those of lone nodes
        stay.

        Parameters
        ----------
        left, right : int or None
            Contact nodes at its ends; None: there is none.
        left_lone, right_lone : bool
            Whether the contact on that side is a lone node.

        Returns
        -------
        Change
        """
        thresholds = self.opening
        found = [_NEVER]
        if not left_lone:
            found.append(Change(thresholds.advance(left - 1, 1, right), (left - 1, right)))
        if not right_lone:
            found.append(Change(thresholds.advance(right + 1, -1, left), (left, right + 1)))
        if not left_lone and not right_lone:
            both = left - 1, right + 1
            depth = min(thresholds.advance_both(*both), thresholds.touches(*both)[0])
            found.append(Change(depth, both))
        return max(found, key=lambda change: change.depth)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def pulled(self, before: End, node: Any, after: End) -> Change:
        """The depth at which a lone node between two free surfaces lets go.

        Parameters
        ----------
        before, after : int or None
            Contact nodes beyond these surfaces; None: there is none.
        node : int
            The lone node.

        Returns
        -------
        Change
        """
        depth = math.nan
        if self.lines is not None:
            depth = self.lines.depth(before, node, after)
        if math.isnan(depth):
            depth = self.opening.pulled(before, node, after)
        return Change(depth, ())

    def opened_inside(self, first: int, last: int) -> Change:
        """Where the first node inside a contact opens; never in a convex one, whose lines recede.

        A contact that is one link shorter on a side than another has the same weakest node, unless
        that was at its end.

        Parameters
        ----------
        first, last : int
            First and last node of the contact.

        Returns
        -------
        Change
        """
        if last - first < 2 or self.opening.clear:
            return _NEVER
        wider = [(first, last), (first - 1, last), (first, last + 1), (first - 1, last + 1)]
        node = next((self.weakest[contact] for contact in wider if contact in self.weakest), -1)
        depths = self.opening.open
        if not first < node < last:
            node = first + 1 + int(depths[first + 1 : last].argmax())
        self.weakest[first, last] = node
        return Change(float(depths[node]), (first, node - 1, node + 1, last))

    def _is_jump(
        self, before: tuple[int, ...], after: tuple[int, ...], changes: int, depth: float
    ) -> bool:
        """Whether changes at one depth are an event: they release energy, or contacts differ.

        What is not lost to adhesion hysteresis anyway; without adhesion, where U is convex, none.
        """
        if len(before) != len(after):
            return True
        if changes < 2:
            return False
        least = _ROUNDING * float(self.opening.work.max(initial=0.0))
        if not least:
            return False
        closing, opening = self.row.works
        released = self.energy(before, depth) - self.energy(after, depth)
        opened = self.opened(paired(before), paired(after)) if opening != closing else 0.0
        return released - opened * (opening - closing) > least

    def energy(self, nodes: Contacts | tuple[int, ...], depth: float) -> float:
        """Energy U of contacts at a depth.

        Parameters
        ----------
        nodes : Contacts, or tuple of int
            First and last nodes of the contacts.
        depth : float
            [length].

        Returns
        -------
        float
            [energy/length].
        """
        return float(self.row.totals(np.reshape(nodes, (1, -1)), np.array([depth]))[0, 0])

    def opened(self, before: Contacts, after: Contacts) -> float:
        """The length or area that opens, weighted with the pattern's factor.

        Parameters
        ----------
        before, after : Contacts
            The contacts before and after a change.

        Returns
        -------
        float
            [length or area].
        """
        bonds = self.row.bonds
        bonded_before = sum(bonds[i:j].sum() for i, j in before)
        bonded_after = sum(bonds[i:j].sum() for i, j in after)
        return max(0.0, float(bonded_before - bonded_after))


class Front:
    """The contacts of a walk that goes on, and the next change of every part of them.

    Contacts prescribe the displacement, so that parts do not feel each other: after a change only
    the parts that it has changed need a new next one. A heap has the earliest first; entries of
    parts that are no more stay in it until they come first.

    Parameters
    ----------
    walk : Walk
    nodes : Contacts
    sign : {1, -1}
        Whether the depth grows or falls.
    outermost : tuple of int or None
        Lines at both ends, where only the surfaces between these are followed.

    Attributes
    ----------
    ends : list of int
        Of all free surfaces, from left to right; -1 and the number of nodes: no contact there. Two
        of them from an even place on enclose a free surface, from an odd place on a contact.
    """

    def __init__(
        self, walk: Walk, nodes: Contacts, sign: int, outermost: tuple[End, End] = (None, None)
    ) -> None:
        self.walk = walk
        self.sign = sign
        self.size = walk.row.size
        self.outermost = outermost
        first, last = outermost
        self.ends = [
            -1 if first is None else first,
            *itertools.chain(*nodes),
            self.size if last is None else last,
        ]
        self.heap: list[tuple[float, int, bool, int, Change, Part]] = []
        self.known: dict[tuple[int, bool], Part] = {}
        self.pushed = 0
        self._push(0, len(self.ends))

    @property
    def nodes(self) -> tuple[int, ...]:
        """The first and last nodes of all contacts as they are now.

        Of some neighbouring surfaces from where their outermost lines have been.
        """
        first, last = self.outermost
        before = [] if first is None else [first]
        after = [] if last is None else [last]
        start = 1 if first is None else 0
        stop = len(self.ends) - (1 if last is None else 0)
        return (*before, *self.ends[start:stop], *after)

    @property
    def contacts(self) -> Contacts:
        """The contacts as they are now."""
        return paired(self.nodes)

    def first(self) -> tuple[Change, int]:
        """What happens first, and the place of the part it happens to."""
        while self.heap:
            _, node, free, _, change, part = self.heap[0]
            place = bisect_right(self.ends, node) - 1 if free else bisect_left(self.ends, node)
            if self._part(place, free) == part:
                return change, place
            heapq.heappop(self.heap)
        return Change(self.sign * math.inf, ()), 0

    def rooms(self, place: int) -> tuple[int, int]:
        """Links of the contacts on both sides of the free surface at a place; 0 if not followed."""
        ends = self.ends
        left = ends[place] - ends[place - 1] if place > 0 else 0
        right = ends[place + 2] - ends[place + 1] if place + 2 < len(ends) else 0
        return left, right

    def apply(self, change: Change, place: int) -> None:
        """The change happens to the part at a place."""
        no_contact = (-1, self.size)
        new = [no_contact[i % 2] if end is None else end for i, end in enumerate(change.ends)]
        self.ends[place : place + 2] = new
        if self.sign > 0:
            self._push(place, place + len(new))
        else:
            self._push(max(place - 2, 0), place + len(new) + 2)

    def _part(self, place: int, free: bool) -> Part:
        """The nodes on which the next change of the part at a place depends: () if there is none.

        Those of both its ends. As the depth falls no line of a lone node recedes, and whether such
        a node is pulled depends on the contacts next to it.
        """
        ends = self.ends
        if place < 0 or (place % 2 == 0) != free or place + 1 >= len(ends):
            return ()
        left, right = ends[place : place + 2]
        if self.sign > 0 or (not free and left < right):
            return left, right
        before = ends[place - 1] if place > 0 else left
        after = ends[place + 2] if place + 2 < len(ends) else right
        if free:
            return left, right, before == left, after == right
        return before, left, right, after

    def _push(self, start: int, stop: int) -> None:
        """Find the next change of the parts between two places, where it is not known."""
        if self.ends == [-1, self.size]:  # detached
            return
        step = 2 if self.sign > 0 else 1
        for place in range(start, min(stop, len(self.ends) - 1), step):
            node = self.ends[place]
            free = place % 2 == 0
            part = self._part(place, free)
            if self.known.get((node, free)) == part:
                continue
            self.known[node, free] = part
            change = self._change(part, free)
            self.pushed += 1
            entry = self.sign * change.depth, node, free, self.pushed, change, part
            heapq.heappush(self.heap, entry)

    def _change(self, part: Part, free: bool) -> Change:
        """The next change of a part."""
        walk = self.walk
        if not free:
            if len(part) == 2:
                return walk.opened_inside(*part)
            before, node, _, after = part
            return walk.pulled(_node(before, self.size), node, _node(after, self.size))
        left = _node(part[0], self.size)
        right = _node(part[1], self.size)
        if self.sign > 0:
            return walk.rise(left, right)
        return walk.fall(left, right, bool(part[2]), bool(part[3]))


def _node(end: int, size: int) -> End:
    """The contact node at an end of a free surface, None if there is none."""
    return None if end in (-1, size) else end
