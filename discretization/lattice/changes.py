"""Contacts on the lattice and how they change with the depth.

Contacts are node intervals ((first, last), ...) from left to right; the free parts between and
beside them are those of ways.py.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from discretization.lattice.rules import Rules
from discretization.lattice.ways import Part, fall, outer_way, part_pressed

Contacts = tuple[tuple[int, int], ...]


class Change(NamedTuple):
    """What happens at a depth to a contact: so many from it on become `instead`."""

    depth: float
    replaced: int
    instead: Contacts

    def applied(self, nodes: Contacts, i: int) -> Contacts:
        """The contacts after this has happened to the i-th."""
        return (*nodes[:i], *self.instead, *nodes[i + self.replaced :])


def parts(nodes: Contacts) -> Iterator[Part]:
    """All free parts from left to right."""
    ends = [None, *(node for pair in nodes for node in pair), None]
    yield from zip(ends[::2], ends[1::2], strict=True)


def contacts_of(ends: list[Part]) -> Contacts:
    """The contacts between these free parts."""
    inner = [node for part in ends for node in part if node is not None]
    return tuple(zip(inner[::2], inner[1::2], strict=True))


def pressed(rules: Rules, nodes: Contacts, depth: float, touch: int = 0) -> Contacts:
    """Contacts at rest at a smaller depth, once they are pressed to this one.

    touch: the node that touches first, where there is no contact yet.
    """
    if not nodes:
        if rules.f[touch] > depth:
            return nodes
        nodes = ((touch, touch),)
    return contacts_of([end for part in parts(nodes) for end in part_pressed(rules, *part, depth)])


def falls(rules: Rules, nodes: Contacts) -> list[Change]:
    """What happens first to each contact as the depth falls, the contacts counted from it.

    Also to the free part on its right, and to the one on the left of the first contact.
    """
    before, after = (None, *(last for _, last in nodes)), (*nodes[1:], (None, None))
    beside = zip(before, nodes, after, strict=False)
    return [_first_fall(rules, left, *pair, *beyond) for left, pair, beyond in beside]


@functools.lru_cache(maxsize=1 << 14)
def _first_fall(
    rules: Rules, left: int | None, first: int, last: int, right: int | None, beyond: int | None
) -> Change:
    """Of a contact, with the ends of those beside it."""
    found = []
    if left is None and (change := fall(rules, None, first, False, first == last)):
        found.append(Change(change.depth, 1, ((_node(change.right), last),)))
    if change := fall(rules, last, right, first == last, right == beyond):
        ends: Contacts = ((first, _node(change.left)),)
        if right is not None:
            ends = (*ends, (_node(change.right), _node(beyond)))
        found.append(Change(change.depth, len(ends), ends))
    if first == last:
        found.append(Change(rules.pulled(left, first, right), 1, ()))
    if last - first >= 2 and rules.most_torn > -np.inf:
        depth, node = rules.tears(first, last)
        found.append(Change(depth, 1, ((first, node - 1), (node + 1, last))))
    return max(found, key=lambda change: change.depth)


def _node(end: int | None) -> int:
    assert end is not None
    return end


def retracted(rules: Rules, nodes: Contacts, depth: float) -> Contacts:
    """Contacts at rest at a larger depth, once they are retracted to this one.

    What happens at the largest depth comes first.
    """
    nodes = _outer_receded(rules, nodes, depth)
    while nodes:
        found = falls(rules, nodes)
        depths = [change.depth for change in found]
        i = depths.index(max(depths))
        if depths[i] <= depth:
            break
        nodes = found[i].applied(nodes, i)
    return nodes


def _outer_receded(rules: Rules, nodes: Contacts, depth: float) -> Contacts:
    """Contacts whose outermost lines have receded by themselves, many links at once."""
    while nodes:
        (first, end), (start, last) = nodes[0], nodes[-1]
        left = outer_way(rules, None, first, depth, end=end, through=True).end[1]
        nodes = ((_node(left), end), *nodes[1:])
        start = nodes[-1][0]
        right = outer_way(rules, last, None, depth, end=start, through=True).end[0]
        if (first, last) == (left, right):
            break
        nodes = (*nodes[:-1], (start, _node(right)))
    return nodes
