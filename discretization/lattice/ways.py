"""How a free part of the surface changes with the depth, on the lattice.

Free parts lie between and beside contacts. Each is given by the contact node on its left and on its
right (None: none there). In contact the displacement is prescribed, so that free parts do not feel
each other: each is followed by itself, until it is split by a node that touches, or closes (with
growing depth), or a contact beside it ends (with falling depth).
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.rules import TIE, Nodes, Rules
from discretization.lattice.waiting import advances

Array = NDArray[np.float64]
Part = tuple[int | None, int | None]
_BLOCK = 256  # links looked at at once, at first


class Way(NamedTuple):
    """How a free part changes on the way to a depth, one link at a time.

    depths (k,): where, in their order; left, right (k + 1,): its contact nodes before and after
    each (None: none there); stop: the depth of a change that may be more than one link, with which
    the way ends.
    """

    depths: Array
    left: Sequence[int] | None
    right: Sequence[int] | None
    stop: float | None = None

    def at(self, count: int) -> Part:
        """The part after so many changes."""
        _, left, right, _ = self
        return None if left is None else left[count], None if right is None else right[count]

    def before(self, depth: float, rising: bool) -> Part:
        """The part just before a depth is reached."""
        way = 1 if rising else -1
        return self.at(int(np.searchsorted(way * self.depths, way * depth)))

    def moves(self, line: int) -> Array:
        """Depths at which the right (1) or left (-1) contact node changes."""
        nodes, other = (self.right, self.left)[::line]
        if nodes is None or other is None:
            return self.depths if other is None else np.empty(0)
        return self.depths[np.diff(nodes) != 0]

    @property
    def end(self) -> Part:
        """The part at the end."""
        return self.at(-1)


class Rise(NamedTuple):
    """What happens first to a free part as the depth changes, and at which depth.

    left, right: its contact nodes then (None: none there); node: the one that touches, or -1.
    """

    depth: float
    left: int | None
    right: int | None
    node: int = -1


@functools.lru_cache(maxsize=1 << 16)
def rise(rules: Rules, left: int | None, right: int | None) -> Rise:
    """The first change of a free part as the depth grows."""
    touch, node = rules.touches(left, right)
    found = []
    if left is not None and left + 1 < rules.f.size:
        found.append(Rise(advances(rules, left, 1, right), left + 1, right))
    if right is not None and right > 0:
        found.append(Rise(advances(rules, right, -1, left), left, right - 1))
    if left is not None and right is not None:
        found.append(Rise(rules.advance_both(left, right), left + 1, right - 1))
    found.append(Rise(touch, left, right, node))
    return min(found, key=lambda change: change.depth)


@functools.lru_cache(maxsize=1 << 16)
def fall(
    rules: Rules, left: int | None, right: int | None, lone_left: bool, lone_right: bool
) -> Rise | None:
    """The first change of a free part as the depth falls; None if no line can recede.

    lone_left, lone_right: whether the contact on its left or right is a lone node.
    """
    found = []
    if left is not None and not lone_left:
        found.append(Rise(rules.passes(left - 1, 1, right), left - 1, right))
    if right is not None and not lone_right:
        found.append(Rise(rules.passes(right + 1, -1, left), left, right + 1))
    if len(found) == 2 and left is not None and right is not None:
        found.append(Rise(rules.recede_both(left, right), left - 1, right + 1))
    return max(found, key=lambda change: change.depth, default=None)


def risen(rules: Rules, left: int | None, right: int | None, depth: float) -> Way:
    """The way of a free part to a larger depth, up to what may be more than one link at a time."""
    if left is None or right is None:
        return outer_way(rules, left, right, depth)
    depths: list[float] = []
    ends, stop = [(left, right)], None
    while right - left > 1:
        change = rise(rules, left, right)
        if change.depth > depth:
            break
        assert change.left is not None and change.right is not None
        closed = change.right - change.left < 2
        if change.node >= 0 or closed or (depths and change.depth <= depths[-1]):
            stop = max([change.depth, *depths[-1:]])
            break
        left, right = change.left, change.right
        depths.append(change.depth)
        ends.append((left, right))
    return _way(depths, ends, stop)


def fallen(
    rules: Rules,
    left: int | None,
    right: int | None,
    first: int | None,
    last: int | None,
    depth: float,
) -> Way:
    """The way of a free part to a smaller depth, up to what may be more than one link at a time.

    first, last: the other ends of the contacts on its left and right, which it does not pass.
    """
    if left is None or right is None:
        return outer_way(rules, left, right, depth, end=first if right is None else last)
    depths: list[float] = []
    ends, stop = [(left, right)], None
    while change := fall(rules, left, right, left == first, right == last):
        if change.depth <= depth:
            break
        if depths and change.depth >= depths[-1]:
            stop = depths[-1]
            break
        assert change.left is not None and change.right is not None
        left, right = change.left, change.right
        depths.append(change.depth)
        ends.append((left, right))
    return _way(depths, ends, stop)


def _way(depths: list[float], ends: list[tuple[int, int]], stop: float | None) -> Way:
    left, right = zip(*ends, strict=True)
    return Way(np.array(depths), left, right, stop)


def outer_way(
    rules: Rules,
    left: int | None,
    right: int | None,
    depth: float,
    *,
    end: int | None = None,
    through: bool = False,
) -> Way:
    """The way beyond an outermost line; also through jumps of that line if asked for.

    end: the other end of the contact, which the line does not pass as the depth falls; None: the
    depth grows.
    """
    side, rising = (1 if right is None else -1), end is None
    node = left if right is None else right
    assert node is not None
    moves = side if rising else -side
    own, links = _passed(rules, side, node, end, depth)
    when = (np.maximum if rising else np.minimum).accumulate(own)
    free, stop = own.size, None
    if rising and not rules.clear:
        free, stop = _clear(rules, side, node, when, depth)
    lags = None if through else _lag(rules, side, links[:free], own[:free], when[:free])
    if lags is not None:
        way = side * moves
        free, stop = int(np.searchsorted(way * when, way * lags)), lags
    line = range(node, node + moves * (free + 1), moves)
    if side > 0:
        return Way(when[:free], line, None, stop)
    return Way(when[:free], None, line, stop)


def _passed(
    rules: Rules, side: int, node: int, end: int | None, depth: float
) -> tuple[Array, range]:
    """Depths at which an outermost line passes links on the way to one, as `Rules.outwards`.

    Also where they are there.
    """
    passes = rules.outwards[side]
    start, last = node, end
    if side < 0:
        start, last = passes.size - 1 - node, None if end is None else passes.size - 1 - end
    ahead = passes[start:] if last is None else passes[last:start][::-1]
    count, size = 0, _BLOCK
    while count < ahead.size:
        stops = (ahead[count : count + size] > depth) == (last is None)
        first = int(stops.argmax())
        if stops[first]:
            count += first
            break
        count, size = count + stops.size, 2 * size
    links = range(start, start + count) if last is None else range(start - 1, start - 1 - count, -1)
    return ahead[:count], links


def _lag(rules: Rules, side: int, links: range, own: Array, when: Array) -> float | None:
    """The first depth at which a line passes links late, at a gain, behind the one before."""
    if not (own != when).any():
        return None
    gained = np.cumsum(_gains(rules, side, np.array(links), own, when))
    behind = np.flatnonzero(gained > rules.least)
    return float(when[behind[0]]) if behind.size else None


def _gains(rules: Rules, side: int, at: Nodes, own: Array, when: Array) -> Array:
    """Energy gained by an outermost line that passes links at other depths than its own.

    at: links as they are counted in `Rules.outwards`, with their own depths there.
    """
    lat, f = rules.lattice, rules.f[::side]
    work, near, far = rules.work[::side][at], f[at], f[at + 1]
    place = lat.at(rules.nodes[::side].start + side * at, side)
    gap = place.gap(near, far, when)
    gain = np.abs(place.stored(gap) - work)
    rounding = TIE * (np.abs(rules.f).max() + np.abs(own) + np.abs(when))
    return np.where(np.abs(place.loss * (own - when)) > rounding, gain, 0.0)


def _clear(
    rules: Rules, side: int, node: int, when: Array, depth: float
) -> tuple[int, float | None]:
    """How many links an outermost line passes at these depths before its surface touches a node.

    Also the depth of what happens then, None where nothing does up to `depth`. The clearance of
    every node falls as the line advances: had another one touched before, it would be in the
    indenter now, or when the line came to the node before it.
    """
    start = node if side > 0 else rules.f.size - 1 - node
    met = rules.meets[side][start : start + when.size] <= when
    most = int(np.argmax(met)) if met.any() else when.size

    def clear(count: int) -> bool:
        until = depth if count == when.size else float(when[count - 1])
        return count == 0 or rules.first_touch(node + side * count, side) > until

    if most == when.size and rules.first_touch(node + side * most, side) > depth:
        return most, None
    low, high = 0, most + 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if clear(middle) else (low, middle)
    at = node + side * low
    after = rise(rules, *((at, None) if side > 0 else (None, at))).depth
    after = max([after, *when[:low][-1:].tolist()])
    return low, after if after <= depth else None


def part_pressed(rules: Rules, left: int | None, right: int | None, depth: float) -> Iterator[Part]:
    """The free parts that are left of one, from left to right; none where it closes."""
    todo: list[Part] = [(left, right)]
    while todo:
        left, right = todo.pop()
        while left is None or right is None or right - left > 1:
            if left is None or right is None:
                left, right = outer_way(rules, left, right, depth, through=True).end
            else:
                left, right = risen(rules, left, right, depth).end
            first = rise(rules, left, right)
            if first.depth > depth:
                yield left, right
                break
            left, right = first.left, first.right
            if first.node >= 0:
                todo.append((first.node, right))
                right = first.node
