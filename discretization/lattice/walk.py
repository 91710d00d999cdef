"""Contacts on nodes followed as the depth changes: a walk from change to change.

In contact the displacement is prescribed, so that free surfaces do not feel each other: each has a
next change of its own, at a depth known in closed form (thresholds.py). With growing depth a line
passes a link, two lines that face each other do so at once, or a free node touches; with falling
depth a line, or two, open a link, a node inside a contact opens, or a lone node does: as soon as it
is pulled, or, where it stands for a contact narrower than a link, when that is lost (loss.py). The
earliest change happens: a heap has the next one of every part (`Front`), a free surface or a
contact. Changes that follow at no other depth belong to it: together they are an event, if they
release energy or leave another number of contacts.

Conventions
-----------
Depths d [length] are positive down into the layer, heights f of the nodes are positive upwards, and
u = d - f in contact. `direction` is +1 while the depth grows (the indenter is pressed) and -1 while
it falls (it is retracted). Nodes are numbered from 0 in the row, from left to right; link i is
between the nodes i and i + 1.

A contact is (first node, last node), a lone node (i, i). A free surface is given by the contact
nodes on its left and on its right, None where the row ends without one: the surface is then a tail.
Contacts come as `Contacts`, a tuple of pairs, or, where they are compared and stored often, as one
flat tuple (first, last, first, last, ...).

A contact line is named by its contact node and the `side` of its free surface: -1 for the left line
of a contact, +1 for the right one. Line "i, side" advances over the link to node i + side. The link
behind it opens at the depth at which a line at node i - side would advance over it: opening is
therefore computed as the advance of a line one node further inside.

`Thresholds` gives the depths of such changes for one work of adhesion; `row.thresholds` are two of
them, for contacts that close and for contacts that open. `advance(node, side, other)` is the depth
at which that line advances while its surface ends at contact node `other`; `advance_both` that of
both lines of a gap at once; `touches` that at which a free node of a surface touches, with the
node; `clears` whether a surface is nowhere in the indenter at a depth; `open` has the depths at
which nodes inside a contact open; `pulled` is the depth below which a lone node is pulled upwards.
A closing happens once d >= its depth, an opening once d < its depth. `row.clear` means that there
is one contact and that no surface outside of it can touch anything but its next node.

`advance_of_outermost(nodes, side)` is `advance` of outermost lines at many nodes. Of a row, `touch`
is the node that touches first and `lowest` its height, the depth at which it does; `works` are the
works of adhesion of closing and of opening, `bonds` lengths or areas of links times the factor of
the pattern, and `totals(nodes, depths)` has U (row 0) and P (row 1) of states. `lattice.axis` is 0
about an axis, else nan. `is_lost_smoothly(row)` is whether contacts adhere and have two free lines:
only then `ContactLoss` has the depths at which contacts narrower than a link are lost.
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
# Neither of the two halved or doubled (a tenth and ten times of _ROUNDING) changes a result
# (`python -m tests.sensitivity discretization.lattice.walk`).
_ROUNDING = 1e-10  # of the adhesion of one link: an event releases more, less is rounding of U
_LOOKED = 1 << 9  # links whose depths are found at once: by then arrays cost little per link
# Changes at one depth, after which a line is taken to jump and passes many links at once. Contacts
# after the jump are the same with any number: see `Walk._jumped`.
_JUMPING = 6


class Change(NamedTuple):
    """The next change of one part, a free surface or a contact.

    Attributes
    ----------
    depth : float
        At which it happens [length]; -∞ or ∞ if it never does.
    ends : tuple of (int or None)
        Nodes that take the place of the part's two ends, from left to right. Of a free surface:
        (left, right) with a line moved; () where it closes entirely; (left, i, j, right) where a
        contact (i, j) has begun in it. Of a contact: () where it is lost, (first, i, j, last) where
        a free surface has opened between its nodes i and j.
    """

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


def _free(*surfaces: tuple[End, End]) -> tuple[End, ...]:
    """The ends, in one row, of those of these surfaces that have a free node.

    Between neighbouring contact nodes there is none: the contacts there have merged.
    """
    return tuple(
        end
        for left, right in surfaces
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

    Attributes
    ----------
    closing, opening : Thresholds
        Of contacts that close and of contacts that open; the same object without hysteresis.
    loss : ContactLoss or None
        When contacts narrower than a link are lost; None if lone nodes let go when pulled.
    least_released : float
        Energy that an event releases at least [energy/length]; 0 without adhesion.
    weakest : dict
        By contact (first, last): the node inside it that opens first, as far as it was looked for.
    """

    def __init__(self, row: Row, *, narrow: bool = False) -> None:
        """A walk over a row of nodes, on which nothing has been looked for yet; see the class."""
        self.row = row
        self.closing, self.opening = row.thresholds
        self.loss = ContactLoss(row, self.opening) if narrow and is_lost_smoothly(row) else None
        self.least_released = _ROUNDING * float(self.opening.work.max(initial=0.0))
        self.weakest: dict[tuple[int, int], int] = {}

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
            At rest at the first depth; not empty.
        start, depth : float
            Depths from which and to which they come [length].

        Returns
        -------
        Contacts
            () if all contact has been lost.
        """
        direction = 1 if depth >= start else -1
        if not self.row.clear:
            tracks = list(self.tracks(nodes, start, depth))
            return tracks[-1].after
        # There is one contact, and its lines do not feel each other: each is moved alone.
        ((first, last),) = nodes
        ahead_left, ahead_right = self._ahead(nodes, direction)
        first -= direction * self._links(*ahead_left, direction, depth)
        last += direction * self._links(*ahead_right, direction, depth)
        if first < last:
            return ((first, last),)
        # No link is left. A lone node has no adhesion: it stays while it is pressed.
        touch = self.row.touch
        return ((touch, touch),) if depth >= self.row.lowest else ()

    def _ahead(self, nodes: Contacts, direction: int) -> Sequence[tuple[range, int]]:
        """The links that the left and the right line of one contact pass next, and their sides.

        Each link is given by the node on the contact's side of it, in the order in which the line
        passes them: outwards from the line if the depth grows, inwards to the other line if it
        falls. Line "node, side" is the one that advances over the link, or has opened it.
        """
        ((first, last),) = nodes
        if direction > 0:
            return (range(first, 0, -1), -1), (range(last, self.row.size - 1), 1)
        return (range(first + 1, last + 1), -1), (range(last - 1, first - 1, -1), 1)

    def _passed(self, ahead: range, side: int, direction: int) -> Array:
        """direction × the depths by which a line of one convex contact has passed these links.

        Never falling: a link is not passed before those in front of it.
        """
        nodes = np.arange(ahead.start, ahead.stop, ahead.step)
        thresholds = self.closing if direction > 0 else self.opening
        return np.maximum.accumulate(direction * thresholds.advance_of_outermost(nodes, side))

    def _links(self, ahead: range, side: int, direction: int, depth: float) -> int:
        """How many of these links the line passes until the depth is reached.

        When pressing, threshold depths increase outwards, so that sampling suffices: every
        stride-th link first, then those from the last sample passed to the next one.
        """
        stride = 1 if direction < 0 else 1 + len(ahead) // _LOOKED
        passed = self._passed(ahead[::stride], side, direction)
        # A link closes at its depth, and opens beyond it.
        count = int(passed.searchsorted(direction * depth, "right" if direction > 0 else "left"))
        if stride == 1:
            return count
        start = max(count - 1, 0) * stride
        return start + self._links(ahead[start : start + stride], side, direction, depth)

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
        """The tracks from event to event, until the last depth or the loss of all contact.

        Parameters
        ----------
        nodes : Contacts
            At rest at the start.
        start, end : float
            Depths [length].

        Yields
        ------
        Track
            The first from the start, every other one from the event that ends the one before it.
        """
        direction = 1 if end >= start else -1
        front = Front(self, nodes, direction)
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
        direction = 1 if end >= start else -1
        first, *inner, last = itertools.chain(*surfaces)
        nodes = paired([end for end in inner if end is not None])
        track, _ = self._tracked(Front(self, nodes, direction, (first, last)), start, end)
        return track

    def _tracked(self, front: "Front", start: float, end: float) -> tuple[Track, "Front"]:
        """The path of a front to another depth, up to the first event, and the front there.

        Change after change happens, the earliest first. Once the next one is at another depth, all
        that has happened at this one is judged together: it is an event, and the path ends, or the
        contacts are recorded and the path goes on. Where many changes have happened at one depth a
        line jumps: then it passes as many links at once as it will.
        """
        direction = front.direction
        trace = [(start, front.nodes)]
        depth = start
        changes = 0  # at this depth
        changes_at_jump = 0  # how many of these there were when a line last passed many links
        while True:
            change, place = front.first()
            is_beyond_end = change.depth > end if direction > 0 else change.depth <= end
            # A change that is due already, as others have made it so, happens at this depth, too.
            is_later = direction * (change.depth - depth) > 0
            if is_beyond_end or is_later:  # all at this depth has happened
                after = front.nodes
                if self._is_jump(trace[-1][1], after, changes, depth):
                    return Track(trace, depth, paired(after)), front
                if changes:
                    trace.append((depth, after))
                if is_beyond_end:
                    return Track(trace, None, paired(after)), front
                changes = 0
                changes_at_jump = 0
                smooth = self._smooth_steps(after, depth, end)
                if smooth:
                    trace += smooth
                    depth, after = smooth[-1]
                    front = Front(self, paired(after), direction)
                    continue
                depth = change.depth
            is_free_surface = place % 2 == 0
            if changes - changes_at_jump >= _JUMPING and is_free_surface:
                changes_at_jump = changes
                jumped = self._jumped(front, place, depth)
                change = change._replace(ends=jumped or change.ends)
            front.apply(change, place)
            changes += 1

    def _jumped(self, front: "Front", place: int, depth: float) -> tuple[End, ...]:
        """The ends of a free surface once its lines have passed all links they do at a depth.

        One line passes all that it does while the other one stays, as long as no node touches, then
        the other: what is in contact at the end does not depend on the order, as the energy is
        submodular (nodes/thresholds.py). The last links of a surface, or of a contact, are left to
        single changes, since more can happen there than that a line passes a link.

        Parameters
        ----------
        front : Front
        place : int
            Of the left end of the surface in `front.ends`.
        depth : float
            [length].

        Returns
        -------
        tuple of (int or None)
            Left and right end; () if no link is passed.
        """
        if self.row.clear or self.row.lattice.axis == 0:
            return ()
        left_start, right_start = front.ends[place : place + 2]
        links_on_left, links_on_right = front.links_beside(place)
        left = left_start
        right = right_start
        while True:
            before = (left, right)
            links_behind = links_on_left + (left - left_start)
            left += self._passed_at(left, right, 1, front.direction, depth, links_behind)
            links_behind = links_on_right + (right_start - right)
            right -= self._passed_at(right, left, -1, front.direction, depth, links_behind)
            if (left, right) == before:
                break
        if (left, right) == (left_start, right_start):
            return ()
        return _node(left, self.row.size), _node(right, self.row.size)

    def _passed_at(
        self, line: int, other: int, side: int, direction: int, depth: float, links_behind: int
    ) -> int:
        """How many links one line passes at a depth, towards its free surface.

        Parameters
        ----------
        line, other : int
            Contact nodes at this line and at the one that it faces; -1 or the number of nodes where
            there is none.
        side : {1, -1}
            On which the free surface of the line is.
        direction : {1, -1}
            Whether lines advance or recede.
        depth : float
            [length].
        links_behind : int
            Links of the contact behind the line.

        Returns
        -------
        int
            Less than 0 if the line recedes.
        """
        size = self.row.size
        if line in (-1, size):
            return 0
        thresholds = self.closing if direction > 0 else self.opening
        facing = _node(other, size)
        # `advances` is for surfaces of three links or more; the last link of a contact is left.
        links = abs(other - line) - 3 if direction > 0 else links_behind - 2
        links = min(links, _LOOKED)
        if links < 1:
            return 0
        if direction > 0:
            passed = thresholds.advances(line + side * np.arange(links), side, facing) <= depth
        else:
            passed = (
                thresholds.advances(line - side * np.arange(1, links + 1), side, facing) > depth
            )
        count = links if passed.all() else int(passed.argmin())  # up to the first that is not
        if direction < 0:
            return -count
        # If the surface is in the indenter after so many links, it is so after more of them, too.
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

        All at once in arrays, as the two lines of a convex contact do not feel each other.

        Parameters
        ----------
        nodes : tuple of int
            First and last nodes of all contacts at this depth.
        depth, end : float
            This depth, and the one to which the path goes [length].

        Returns
        -------
        list of (float, tuple of int)
            Depths, and the first and last node of the contact from there on: up to the first link
            that is passed together with the one before it (a line jumps), and as long as two links
            are left. Empty if there are several contacts, or the row is not `clear`.
        """
        if len(nodes) != 2 or not self.row.clear:
            return []
        first, last = nodes
        direction = 1 if end >= depth else -1
        both_ahead = self._ahead(((first, last),), direction)
        passed = [self._passed(*ahead, direction) for ahead in both_ahead]
        stop = min(direction * end, _first_jump(passed, direction * depth))
        depths = np.unique(np.concatenate(passed))
        depths = depths[depths < stop]
        left_links, right_links = (line.searchsorted(depths, "right") for line in passed)
        lefts = (first - direction * left_links).tolist()
        rights = (last + direction * right_links).tolist()
        steps = zip((direction * depths).tolist(), lefts, rights, strict=True)
        return [(at, (i, j)) for at, i, j in steps if direction > 0 or j - i > 1]

    # Kept are as many changes as surfaces can be met on long paths, some 30 MB at most: a path over
    # ripples meets some hundred, and asks two or three times for each.
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
        touch_depth, node = thresholds.touches(left, right)
        found = Change(touch_depth, _free((left, node), (node, right)))
        moves: list[tuple[float, tuple[End, End]]] = []  # depths, and the surface afterwards
        if left is not None:
            moves.append((thresholds.advance(left, 1, right), (left + 1, right)))
        if right is not None:
            moves.append((thresholds.advance(right, -1, left), (left, right - 1)))
        if left is not None and right is not None:
            moves.append((thresholds.advance_both(left, right), (left + 1, right - 1)))
        for depth, surface in moves:
            if depth >= found.depth:
                continue
            if thresholds.clears(*surface, depth):
                found = Change(depth, _free(surface))
            else:
                found = self._with_touch((left, right), surface, depth, found)
        return found

    def _with_touch(self, own: Any, moved: Any, depth: float, later: Change) -> Change:
        """A line passes a link as a node touches that would then be in the indenter, or `later`.

        That happens at the depth at which both together leave U as it is. With given contacts U is
        quadratic in d, so that the energy released is a parabola of the depth: it is read at three
        depths, at that of the link alone, at that of `later`, and half way, and its zero is found
        by the formula that subtracts nothing.

        Parameters
        ----------
        own : tuple of (int or None)
            Contact nodes at the left and the right end of the free surface.
        moved : tuple of (int or None)
            The same once the line has passed the link.
        depth : float
            The depth at which the line alone would pass the link [length].
        later : Change
            What happens otherwise, at a larger depth.

        Returns
        -------
        Change
        """
        _, node = self.closing.touches(*moved)
        ends = _free((moved[0], node), (node, moved[1]))
        # Both with the same outermost nodes, so that all beyond these cancels in the difference.
        before = contacts_of((own[0], *own, own[1]))
        after = contacts_of((own[0], *ends, own[1]))

        def released(d: float) -> float:
            """U before less U after at a depth d [energy/length]: what the change releases."""
            return self.energy(before, d) - self.energy(after, d)

        first = released(depth)
        middle = released((depth + later.depth) / 2)
        last = released(later.depth)
        if last <= 0:
            return later
        # first + linear s + bend s² = 0, with s from 0 at `depth` to 1 at that of `later`.
        linear = 4 * middle - 3 * first - last
        bend = 2 * (first + last - 2 * middle)
        denominator = linear + math.sqrt(max(linear**2 - 4 * bend * first, 0.0))
        s = -2 * first / denominator if first < 0 else 0.0
        return Change(depth + s * (later.depth - depth), ends)

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def fall(self, left: Any, right: Any, left_lone: bool, right_lone: bool) -> Change:
        """The first move of the lines of a free surface as the depth falls.

        Lines of lone nodes stay: these nodes open as a whole (`pulled`). No free node touches, as
        contacts only shrink.

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
            # Both open at once only where the wider surface would clear the indenter.
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
        depth = math.nan  # as `ContactLoss.depth` where that does not know it
        if self.loss is not None:
            depth = self.loss.depth(before, node, after)
        if math.isnan(depth):
            depth = self.opening.pulled(before, node, after)
        return Change(depth, ())

    def opened_inside(self, first: int, last: int) -> Change:
        """The opening of the weakest node inside a contact; in a convex one only lines recede.

        The weakest node is the one that opens at the largest depth. A contact that is one link
        shorter on a side than another has the same one, unless that is at its end: as lines recede,
        it need not be looked for anew.

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

        U counts contacts at the closing work of adhesion. What opens costs the opening one, so that
        the difference of the two is lost to hysteresis anyway and is not released by an event.

        Parameters
        ----------
        before, after : tuple of int
            First and last nodes of all contacts before and after these changes.
        changes : int
            How many they are. A single one happens where it leaves U as it is.
        depth : float
            [length].

        Returns
        -------
        bool
        """
        if len(before) != len(after):
            return True
        if changes < 2:
            return False
        if not self.least_released:  # without adhesion U is convex, and nothing jumps
            return False
        closing, opening = self.row.works
        released = self.energy(before, depth) - self.energy(after, depth)
        opened = self.opened(paired(before), paired(after)) if opening != closing else 0.0
        return released - opened * (opening - closing) > self.least_released

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


def _first_jump(passed: Sequence[Array], start: float) -> float:
    """The first place at which one of these lines passes a link together with the one before it.

    passed: of each line the places, never falling, at which it passes link after link; start: where
    all lines are before the first. ∞ if none does.
    """
    found = math.inf
    for line in passed:
        together = line <= np.append(start, line[:-1])
        found = min(found, float(line[together].min(initial=math.inf)))
    return found


class _Part(NamedTuple):
    """A free surface or a contact, with all nodes on which its next change depends.

    Attributes
    ----------
    free : bool
        Whether it is a free surface.
    left, right : int
        Its ends: contact nodes, of a surface -1 or the number of nodes where there is none.
    left_lone, right_lone : bool
        Of a surface as the depth falls, whether its lines stay: the contacts beside it are lone
        nodes, or not followed, or there are none. As the depth grows False.
    before, after : int or None
        Of a lone node as the depth falls, the far ends of the surfaces beside it, on which it
        depends when it is pulled; else None.
    """

    free: bool
    left: int
    right: int
    left_lone: bool = False
    right_lone: bool = False
    before: int | None = None
    after: int | None = None


class _Entry(NamedTuple):
    """The next change of a part on the heap, which sorts by the first of these that differs.

    Attributes
    ----------
    priority : float
        direction × its depth: the earliest change is the least.
    left : int
        The part's left end: of changes at one depth the leftmost is first.
    free : bool
        Whether the part is a free surface; a contact that begins at the same node is first.
    number : int
        How many entries were made before it, so that no two are alike.
    change : Change
    part : _Part
    """

    priority: float
    left: int
    free: bool
    number: int
    change: Change
    part: _Part


class Front:
    """The contacts of a walk that goes on, and the next change of every part of them.

    Contacts prescribe the displacement, so that parts do not feel each other: after a change only
    the parts that it has changed need a new next one. A heap has the earliest first; entries of
    parts that are no more stay in it until they come first.

    Parameters
    ----------
    walk : Walk
    nodes : Contacts
    direction : {1, -1}
        Whether the depth grows or falls.
    outermost : tuple of (int or None)
        Contact nodes at both ends of the row of surfaces that are followed, if these are not all.

    Attributes
    ----------
    ends : list of int
        Of all free surfaces, from left to right; -1 and the number of nodes: no contact there. Two
        of them from an even place on enclose a free surface, from an odd place on a contact.
    heap : list of _Entry
    known : dict
        By left end, and whether it is a free surface: the part whose next change was pushed last.
    pushed : int
        How many entries have been made.
    """

    def __init__(
        self, walk: Walk, nodes: Contacts, direction: int, outermost: tuple[End, End] = (None, None)
    ) -> None:
        """Ends of all free surfaces, and a heap of their next changes; see the class."""
        self.walk = walk
        self.direction = direction
        self.size = walk.row.size
        self.outermost = outermost
        first, last = outermost
        self.ends = [
            -1 if first is None else first,
            *itertools.chain(*nodes),
            self.size if last is None else last,
        ]
        self.heap: list[_Entry] = []
        self.known: dict[tuple[int, bool], _Part] = {}
        self.pushed = 0
        self._push(0, len(self.ends))

    @property
    def nodes(self) -> tuple[int, ...]:
        """The first and last nodes of all contacts as they are now, in one row.

        If only some neighbouring surfaces are followed, the contacts beside the outermost of these
        reach from where their lines were at the start to where they have come.
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
        """The earliest change, and the place in `ends` of the left end of the part it happens to.

        If nothing is going to happen, a change at an infinite depth.
        """
        while self.heap:
            _, left, free, _, change, part = self.heap[0]
            # A lone node stands twice in `ends`: at its left end a contact begins, at its right end
            # a free surface.
            place = bisect_right(self.ends, left) - 1 if free else bisect_left(self.ends, left)
            if self._part(place, free) == part:
                return change, place
            heapq.heappop(self.heap)  # the part is no more what it was
        return Change(self.direction * math.inf, ()), 0

    def links_beside(self, place: int) -> tuple[int, int]:
        """How many links the contacts on the left and the right of a free surface have.

        place: of the surface's left end in `ends`. 0 where there is no contact that is followed.
        """
        ends = self.ends
        on_left = ends[place] - ends[place - 1] if place > 0 else 0
        on_right = ends[place + 2] - ends[place + 1] if place + 2 < len(ends) else 0
        return on_left, on_right

    def apply(self, change: Change, place: int) -> None:
        """Let a change happen to the part whose left end is at this place of `ends`.

        Its two ends there become those of the change, None becoming -1 or the number of nodes; and
        the next changes of all parts that are new, or depend on it, are pushed.
        """
        no_contact = (-1, self.size)  # of left and of right ends
        new = [no_contact[i % 2] if end is None else end for i, end in enumerate(change.ends)]
        self.ends[place : place + 2] = new
        if self.direction > 0:
            self._push(place, place + len(new))
        else:  # the parts beside it depend on it, too: see `_Part`
            self._push(max(place - 2, 0), place + len(new) + 2)

    def _part(self, place: int, free: bool) -> _Part | None:
        """The part whose left end is at a place of `ends`; None if none of this kind is there."""
        ends = self.ends
        if place < 0 or (place % 2 == 0) != free or place + 1 >= len(ends):
            return None
        left, right = ends[place : place + 2]
        if self.direction > 0 or (not free and left < right):
            return _Part(free, left, right)
        before = ends[place - 1] if place > 0 else left
        after = ends[place + 2] if place + 2 < len(ends) else right
        if free:
            return _Part(free, left, right, before == left, after == right)
        return _Part(free, left, right, before=before, after=after)

    def _push(self, start: int, stop: int) -> None:
        """Push the next changes of the parts between two places of `ends`, if they are not known.

        As the depth grows nothing happens to contacts, and only free surfaces have one.
        """
        if self.ends == [-1, self.size]:  # detached
            return
        step = 2 if self.direction > 0 else 1
        for place in range(start, min(stop, len(self.ends) - 1), step):
            free = place % 2 == 0
            part = self._part(place, free)
            if part is None or self.known.get((part.left, free)) == part:
                continue
            self.known[part.left, free] = part
            change = self._change(part)
            self.pushed += 1
            priority = self.direction * change.depth
            heapq.heappush(self.heap, _Entry(priority, part.left, free, self.pushed, change, part))

    def _change(self, part: _Part) -> Change:
        """The next change of a part."""
        walk = self.walk
        left = _node(part.left, self.size)
        right = _node(part.right, self.size)
        if not part.free:
            if part.before is None or part.after is None:  # more than a lone node
                return walk.opened_inside(part.left, part.right)
            before = _node(part.before, self.size)
            return walk.pulled(before, part.left, _node(part.after, self.size))
        if self.direction > 0:
            return walk.rise(left, right)
        return walk.fall(left, right, part.left_lone, part.right_lone)


def _node(end: int, size: int) -> End:
    """The contact node at an end of a free surface as `Front` has it; None: there is none."""
    return None if end in (-1, size) else end
