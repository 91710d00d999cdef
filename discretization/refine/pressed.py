"""Contacts on nodes pressed to one depth at once.

Pressed, contacts only grow, and whatever grows first makes the others grow no less
(nodes/thresholds.py). So the contacts at a depth do not depend on the order in which lines pass
links and nodes touch, nor on the depths at which they did: a line may pass all links up to the
first that holds it, found in an array, as long as the surface stays clear of the indenter.
"""

from __future__ import annotations

import numpy as np

from discretization.lattice.lowest import runs
from discretization.lattice.walk import End, Walk, ends_of, paired
from discretization.nodes.obstacle import pressed as bare_contacts
from discretization.nodes.row import Contacts
from discretization.nodes.thresholds import Thresholds

_LOOKED = 32  # links whose depths are found at once, twice as many each time


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
    """What becomes of contacts that are pressed to a depth."""
    ends = ends_of(contacts)
    waiting = list(zip(ends[::2], ends[1::2], strict=True))[::-1]
    lines = list[End]()
    while waiting:
        left, right = waiting.pop()
        if left is not None and right is not None and right - left <= 1:
            continue  # the gap is closed
        moved = _left_line(walk.closing, left, right, depth)
        other = _right_line(walk.closing, moved, right, depth)
        if (moved, other) != (left, right):
            waiting.append((moved, other))
            continue
        change = walk.rise(left, right)
        if change.depth > depth:
            lines += left, right
            continue
        parts = list(zip(change.ends[::2], change.ends[1::2], strict=True))
        waiting += parts[::-1]
    return paired([node for node in lines if node is not None])


def _left_line(rules: Thresholds, left: End, right: End, depth: float) -> End:
    """Where the left line of a free surface stops, with the other one where it is."""
    if left is None:
        return None
    last = rules.f.size - 1 if right is None else right - 2
    count = _passed(rules, left, 1, last - left, right, depth)
    while count and not rules.clears(left + count, right, depth):
        count //= 2
    return left + count


def _right_line(rules: Thresholds, left: End, right: End, depth: float) -> End:
    """Where the right line of a free surface stops, with the other one where it is."""
    if right is None:
        return None
    last = 0 if left is None else left + 2
    count = _passed(rules, right, -1, right - last, left, depth)
    while count and not rules.clears(left, right - count, depth):
        count //= 2
    return right - count


def _passed(rules: Thresholds, node: int, side: int, most: int, facing: End, depth: float) -> int:
    """How many links the line at a node passes before one holds it, up to the last but two."""
    passed = 0
    looked = _LOOKED
    while passed < most:
        count = min(looked, most - passed)
        nodes = node + side * (passed + np.arange(count))
        passes = rules.advances(nodes, side, facing)
        touches = rules.touches_next(nodes, side, facing)
        holds = (passes > depth) | (touches < depth)
        if holds.any():
            return passed + int(holds.argmax())
        passed += count
        looked *= 2
    return max(passed, 0)
