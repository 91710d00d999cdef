"""Contacts on nodes pressed to one depth at once.

Pressed, contacts only grow, and whatever grows first makes the others grow no less
(nodes/thresholds.py). So the contacts at a depth do not depend on the order in which lines pass
links and nodes touch, nor on the depths at which they did: a line may pass all links up to the
first that holds it, found in an array, as long as the surface stays clear of the indenter.

Conventions
-----------
The depth grows as the indenter goes down. Nodes are counted from 0 on the left. A contact is the
pair of its first and last node. A free surface is the pair (left, right) of the contact nodes at
its two ends, which are its contact lines; None stands where there is no contact on that side.
`side` is 1 for a line with its free surface on the right, which advances towards higher node
numbers, and -1 for one with its free surface on the left.

`Walk` has the nodes (`row`), the thresholds for contacts that close (`closing`), and `rise`: the
first change of one free surface as the depth grows, with the depth at which it happens and the ends
of the free surfaces that are left of it. Of `Thresholds`, `advances` are the depths from which on a
line passes the link before it, `touches_next` the depths from which on the node beyond that link
would be in the indenter if the line stayed, and `clears` is whether no node of a free surface is in
the indenter. `f` are the heights of all nodes, positive upwards, and `row.lowest` that of the node
`row.touch`, which touches first.

An `End` is a contact node or None. `ends_of(contacts)` are the ends of all free surfaces from left
to right, two for each and None first and last; `paired` makes contacts of a row of nodes (first,
last, first, last, ...). `bare_contacts(lattice, g)` has the nodes in contact without adhesion, for
g = d - f, and `runs` the first and last nodes of those next to each other.
"""

from __future__ import annotations

import numpy as np

from discretization.lattice.lowest import runs
from discretization.lattice.walk import End, Walk, ends_of, paired
from discretization.nodes.obstacle import pressed as bare_contacts
from discretization.nodes.row import Contacts
from discretization.nodes.thresholds import Thresholds

# Links whose depths are found at once, twice as many each time; 16 or 64 changes no result
# (`python -m tests.sensitivity discretization.refine.pressed`).
_LOOKED = 32


def pressed(walk: Walk, depth: float) -> Contacts:
    """The contacts of the path from first touch to a depth.

    They contain those without adhesion, which are found at once (nodes/obstacle.py).

    Parameters
    ----------
    walk : Walk
    depth : float
        [length]; below first touch the contact of the lowest node is pressed to it.

    Returns
    -------
    Contacts
        First and last nodes, from left to right.
    """
    rules = walk.closing
    start: Contacts = ((walk.row.touch, walk.row.touch),)
    if depth >= walk.row.lowest:
        nodes, _ = bare_contacts(rules.lattice, depth - rules.f)
        mask = np.zeros(rules.f.size, bool)
        mask[nodes] = True
        start = tuple((first, last) for first, last in runs(mask).tolist())
    return _grown(walk, start, depth)


def _grown(walk: Walk, contacts: Contacts, depth: float) -> Contacts:
    """The contacts that others have become once nothing more happens to them at a depth.

    Free surfaces do not feel each other, so that one after the other is worked off, from left to
    right. First both of its lines pass all links that do not hold them; where both are held, the
    first change of any other kind happens, if that is due by the depth; else the surface stays.
    """
    ends = ends_of(contacts)
    surfaces = list(zip(ends[::2], ends[1::2], strict=True))
    waiting = surfaces[::-1]  # a stack: the leftmost surface is last
    lines = list[End]()  # ends of the surfaces that stay, from left to right
    while waiting:
        left, right = waiting.pop()
        if left is not None and right is not None and right - left <= 1:
            continue  # the gap is closed
        new_left = _advanced(walk.closing, left, 1, right, depth)
        new_right = _advanced(walk.closing, right, -1, new_left, depth)
        if (new_left, new_right) != (left, right):
            waiting.append((new_left, new_right))
            continue
        change = walk.rise(left, right)
        if change.depth > depth:
            lines += left, right
            continue
        parts = list(zip(change.ends[::2], change.ends[1::2], strict=True))
        waiting += parts[::-1]
    return paired([node for node in lines if node is not None])


def _advanced(rules: Thresholds, line: End, side: int, facing: End, depth: float) -> End:
    """The node to which a line advances over its free surface while the line that it faces stays.

    `facing` is the contact node at that other line, None of an outermost surface. The last two
    links before it, which lines pass together, are left. Returns None where there is no line.
    """
    if line is None:
        return None
    end_of_row = rules.f.size - 1 if side > 0 else 0
    furthest = end_of_row if facing is None else facing - 2 * side
    count = _passed(rules, line, side, side * (furthest - line), facing, depth)
    # Where the surface would be in the indenter a node further away touches first. Fewer links are
    # passed then: any number will do after which the surface is clear, since the line is moved
    # again, and `Walk.rise` has that node touch once no line moves.
    while count and not _clears(rules, line + side * count, side, facing, depth):
        count //= 2
    return line + side * count


def _clears(rules: Thresholds, line: int, side: int, facing: End, depth: float) -> bool:
    """Whether the free surface on a side of a line is clear of the indenter at a depth."""
    left, right = (line, facing) if side > 0 else (facing, line)
    return rules.clears(left, right, depth)


def _passed(rules: Thresholds, line: int, side: int, most: int, facing: End, depth: float) -> int:
    """How many links, at most so many, a line passes one after the other before one holds it.

    A link holds the line if the line does not advance over it by this depth. It also holds it if
    the node beyond is in the indenter while the line is still before the link: the surface is not
    clear then, and what comes into contact first may be another node. If no link was of that kind,
    every node that came into contact was drawn up to the indenter, and the rest of the surface with
    it; hence a surface that is clear in the end has been so all along.
    """
    passed = 0
    looked = _LOOKED
    while passed < most:
        count = min(looked, most - passed)
        nodes = line + side * (passed + np.arange(count))
        advance = rules.advances(nodes, side, facing)
        touch = rules.touches_next(nodes, side, facing)
        holds = (advance > depth) | (touch < depth)
        if holds.any():
            return passed + int(holds.argmax())
        passed += count
        looked *= 2
    return passed
