"""Contacts on the lattice and what can happen to them as the depth changes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from discretization.lattice.rules import Rules

Nodes = tuple[tuple[int, int], ...]


class Contacts(NamedTuple):
    """Node intervals ((first, last), ...) from left to right, and the positions of all lines."""

    nodes: Nodes
    lines: tuple[float, ...]

    @property
    def ends(self) -> tuple[float, float]:
        """x of the outermost lines."""
        return self.lines[0], self.lines[-1]


State = Contacts | None


class Change(NamedTuple):
    """What can happen at a depth: contacts start..stop-1 become `instead`.

    abrupt: whether it is more than one link.
    """

    depth: float
    start: int
    stop: int
    instead: Nodes
    abrupt: bool

    def applied(self, nodes: Nodes) -> Nodes:
        """The contacts afterwards, neighbouring ones as one."""
        return _joined((*nodes[: self.start], *self.instead, *nodes[self.stop :]))


def spans(nodes: Nodes) -> Iterator[tuple[int | None, int | None]]:
    """Last and first contact node on the left and on the right of every free part."""
    ends = [None, *(node for pair in nodes for node in pair), None]
    yield from zip(ends[::2], ends[1::2], strict=True)


def lines(nodes: Nodes) -> Iterator[tuple[int, int, int | None]]:
    """(contact, side, contact node beyond the free part) of every line."""
    for i, _ in enumerate(nodes):
        yield i, -1, nodes[i - 1][1] if i else None
        yield i, 1, nodes[i + 1][0] if i + 1 < len(nodes) else None


class Rise(NamedTuple):
    """What happens first to a free part as the depth grows, and at which depth.

    left, right: its contact nodes then (None: none there); node: the one that touches, or -1.
    """

    depth: float
    left: int | None
    right: int | None
    node: int = -1


def rise(rules: Rules, left: int | None, right: int | None) -> Rise:
    """The first change of the free part between two contact nodes as the depth grows."""
    touch, node = rules.touches(left, right)
    found = []
    if left is not None and left + 1 < rules.f.size:
        found.append(Rise(rules.advances(left, 1, right), left + 1, right))
    if right is not None and right > 0:
        found.append(Rise(rules.advances(right, -1, left), left, right - 1))
    if left is not None and right is not None:
        found.append(Rise(rules.advance_both(left, right), left + 1, right - 1))
    found.append(Rise(touch, left, right, node))
    return min(found, key=lambda change: change.depth)


def rises(rules: Rules, nodes: Nodes) -> Iterator[Change]:
    """What happens first to each free part as the depth grows."""
    if not nodes:
        node = int(np.argmin(rules.f))
        yield Change(float(rules.f[node]), 0, 0, ((node, node),), True)
        return
    for i, (left, right) in enumerate(spans(nodes)):
        depth, *ends, node = rise(rules, left, right)
        touched = ((node, node),) if node >= 0 else ()
        start, stop = max(i - 1, 0), min(i + 1, len(nodes))
        before = ((nodes[i - 1][0], ends[0]),) if ends[0] is not None else ()
        after = ((ends[1], nodes[i][1]),) if ends[1] is not None else ()
        closed = ends[0] is not None and ends[1] is not None and ends[1] - ends[0] < 2
        yield Change(depth, start, stop, (*before, *touched, *after), node >= 0 or closed)


def pressed(rules: Rules, nodes: Nodes, depth: float) -> Nodes:
    """Contacts at rest at a smaller depth, once they are pressed to this one.

    In contact the displacement is prescribed, so that the free parts do not feel each other: each
    is followed by itself, change by change in the order of their depths.
    """
    if not nodes:
        node = int(np.argmin(rules.f))
        if rules.f[node] > depth:
            return nodes
        nodes = ((node, node),)
    ends = [end for part in spans(nodes) for end in _pressed(rules, *part, depth)]
    inner = [node for node in ends if node is not None]
    return tuple(zip(inner[::2], inner[1::2], strict=True))


def _pressed(
    rules: Rules, left: int | None, right: int | None, depth: float
) -> Iterator[int | None]:
    """The ends of the free parts that are left of one; none where it closes."""
    todo = [(left, right)]
    while todo:
        left, right = todo.pop()
        while left is None or right is None or right - left > 1:
            first = rise(rules, left, right)
            if first.depth > depth:
                yield from (left, right)
                break
            left, right = first.left, first.right
            if first.node >= 0:
                todo.append((first.node, right))
                right = first.node


def recedes(rules: Rules, nodes: Nodes, i: int) -> Iterator[Change]:
    """What can happen to the i-th contact as the depth falls, and to the next one with it."""
    first, last = nodes[i]
    left = nodes[i - 1][1] if i else None
    right = nodes[i + 1][0] if i + 1 < len(nodes) else None
    if first == last:
        yield Change(rules.pulled(left, first, right), i, i + 1, (), True)
        return
    for side, node, other in ((-1, first, left), (1, last, right)):
        depth = rules.passes(node - side, side, other)
        yield Change(depth, i, i + 1, (_moved(nodes[i], side, -1),), False)
    if right is not None and last > first and nodes[i + 1][1] > right:
        both = _moved(nodes[i], 1, -1), _moved(nodes[i + 1], -1, -1)
        depth = rules.recede_both(last, right)
        yield Change(depth, i, i + 2, both, False)
    if last - first >= 2:
        depth, node = rules.tears(first, last)
        yield Change(depth, i, i + 1, ((first, node - 1), (node + 1, last)), True)


def retracted(rules: Rules, nodes: Nodes, depth: float) -> Nodes:
    """Contacts at rest at a larger depth, once they are retracted to this one.

    What happens at the largest depth comes first. A change concerns its contact and the contacts
    beside it; only those are looked at again.
    """
    best = [_falls(rules, nodes, i) for i, _ in enumerate(nodes)]
    while nodes:
        change = max(best, key=lambda change: change.depth)
        if change.depth <= depth:
            break
        nodes = change.applied(nodes)
        start, stop = max(change.start - 1, 0), change.start + len(change.instead) + 1
        near = range(start, min(stop, len(nodes)))
        kept = [
            c._replace(start=i, stop=i + c.stop - c.start)
            for i, c in enumerate(best[change.stop + 1 :], near.stop)
        ]
        best = [*best[:start], *(_falls(rules, nodes, i) for i in near), *kept]
    return nodes


def _falls(rules: Rules, nodes: Nodes, i: int) -> Change:
    return max(recedes(rules, nodes, i), key=lambda change: change.depth)


def _moved(pair: tuple[int, int], side: int, links: int) -> tuple[int, int]:
    """A contact with its line on one side moved outwards by some links."""
    first, last = pair
    return (first - links, last) if side < 0 else (first, last + links)


def _joined(nodes: Nodes) -> Nodes:
    """Contacts in order, neighbouring ones as one."""
    whole: list[tuple[int, int]] = []
    for first, last in sorted(nodes):
        if whole and first <= whole[-1][1] + 1:
            whole[-1] = (whole[-1][0], max(last, whole[-1][1]))
        else:
            whole.append((first, last))
    return tuple(whole)
