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


def advances(rules: Rules, nodes: Nodes) -> Iterator[Change]:
    """What can happen as the depth grows."""
    for i, side, other in lines(nodes):
        node = nodes[i][side > 0]
        if 0 <= node + side < rules.f.size:
            depth = rules.passes(node, side, other)
            closing = other is not None and abs(other - node) == 2
            yield Change(depth, i, i + 1, (_moved(nodes[i], side, 1),), closing)
    for i, (left, right) in enumerate(spans(nodes) if nodes else ()):
        depth, node = rules.touches(left, right)
        if node >= 0:
            yield Change(depth, i, i, ((node, node),), True)
    if not nodes:
        node = int(np.argmin(rules.f))
        yield Change(float(rules.f[node]), 0, 0, ((node, node),), True)


def recedes(rules: Rules, nodes: Nodes) -> Iterator[Change]:
    """What can happen as the depth falls."""
    for i, side, other in lines(nodes):
        first, last = nodes[i]
        if first < last:
            node = nodes[i][side > 0]
            depth = rules.passes(node - side, side, other)
            yield Change(depth, i, i + 1, (_moved(nodes[i], side, -1),), False)
        elif side > 0:
            left = nodes[i - 1][1] if i else None
            right = nodes[i + 1][0] if i + 1 < len(nodes) else None
            depth = rules.pulled(left, first, right)
            yield Change(depth, i, i + 1, (), True)
    for i, (first, last) in enumerate(nodes):
        if last - first >= 2:
            depth, node = rules.tears(first, last)
            parts = (first, node - 1), (node + 1, last)
            yield Change(depth, i, i + 1, parts, True)


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
