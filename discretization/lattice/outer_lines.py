"""Outermost lines pass many links at once, before anything else happens to the contacts.

Each link has a depth of its own (`Rules.outwards`), where there is nothing but a tail beyond.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.row import Part
from discretization.lattice.rules import Rules, ordered

Array = NDArray[np.float64]
_BLOCK = 256  # links looked at at once, at first


class Change(NamedTuple):
    """What happens first to a part or contact: those from `start` to `stop` become `parts`.

    start, stop: counted from the part, or from the part on the left of the contact.
    """

    depth: float
    start: int
    stop: int
    parts: tuple[Part, ...]


class Walked(Protocol):
    """What is asked of walk.py."""

    closing: Rules
    opening: Rules

    def rise(self, part: Part) -> Change:
        """The first change of a free part as the depth grows."""

    def changes(self, parts: Sequence[Part], sign: int) -> list[Change]:
        """The first change of each part, and of each contact, as the depth changes this way."""


def run(
    walk: Walked, parts: Sequence[Part], depth: float, end: float, through: bool
) -> list[Array]:
    """Depths at which the left and the right line pass links, each after the other; or empty.

    through: also links that are passed late, with one before.
    """
    sign = 1 if end >= depth else -1
    others = walk.changes(parts, sign)
    del others[0], others[len(parts) - 2]
    limit = sign * min([sign * end, *(sign * change.depth for change in others)])
    pairs = (-1, parts[0], parts[1]), (1, parts[-2], parts[-1])
    runs = [_run(walk, *pair, depth, limit, through) for pair in pairs]
    stop = sign * min(sign * until for _, until in runs)
    found = [own for own, _ in runs]
    if stop != end:
        found = [
            own[sign * own <= sign * stop if through else sign * own < sign * stop] for own in found
        ]
    if sign < 0 and len(parts) == 2:  # a contact of two links is left
        order = np.argsort(-np.concatenate(found), kind="stable")
        order = order[: max(_contact(*parts)[1] - _contact(*parts)[0] - 2, 0)]
        left = int((order < found[0].size).sum())
        found = [found[0][:left], found[1][: order.size - left]]
    return found if any(when.size for when in found) else []


def _run(
    walk: Walked, side: int, one: Part, other: Part, depth: float, limit: float, through: bool
) -> tuple[Array, float]:
    """Depths at which a line passes links in their order, and where that stops.

    one, other: the parts beside its contact. It stops where a link is passed late, with one before,
    or the surface beyond meets another node.
    """
    (first, last), sign = _contact(one, other), 1 if limit >= depth else -1
    rules, node, links = walk.closing if sign > 0 else walk.opening, first, last - first
    at = rules.f.size - 1 - first
    if side > 0:
        node = at = last
    ahead = rules.outwards[side][at:] if sign > 0 else rules.outwards[side][at - links : at]
    own, stop = _up_to(ahead[::sign], limit, sign), limit
    if sign < 0 and own.size == links > 0:  # with its last link the contact would be a lone node
        own, stop = own[:-1], float(own[-1])
    late = sign * np.diff(own, prepend=depth) <= 0
    if through:
        own = (np.maximum if sign > 0 else np.minimum).accumulate(np.append(depth, own))[1:]
    elif late.any():
        own = own[: int(late.argmax())]
        stop = sign * min(sign * stop, sign * float(own[-1] if own.size else depth))
    if sign > 0 and not rules.clear:
        met = rules.meets[side][at : at + own.size] <= own  # where it is late
        own = own[: int(met.argmax())] if met.any() else own
        own = own[: _clear(rules, side, node, own, stop)]
        stop = min(stop, walk.rise(ordered(side, node + side * own.size, None)).depth)
    return own, stop


def _contact(one: Part, other: Part) -> tuple[int, int]:
    """First and last node of the contact between two parts."""
    first, last = one[1], other[0]
    assert first is not None and last is not None
    return first, last


def _clear(rules: Rules, side: int, node: int, when: Array, depth: float) -> int:
    """How many links an outermost line passes before its surface touches a node further out.

    The clearance of every node falls as the line advances: had another one touched before, it
    would be in the indenter now, or when the line came to the node before it.
    """
    low, high = 0, when.size + 1
    while high - low > 1:
        middle = (low + high) // 2
        until = depth if middle == when.size else float(when[middle - 1])
        clear = rules.first_touch(node + side * middle, side) > until
        low, high = (middle, high) if clear else (low, middle)
    return low


def _up_to(depths: Array, end: float, sign: int) -> Array:
    """The first of these depths, all that are reached on the way to the end."""
    count, size = 0, _BLOCK
    while count < depths.size:
        block = depths[count : count + size]
        beyond = block > end if sign > 0 else block <= end
        if beyond.any():
            return depths[: count + int(beyond.argmax())]
        count, size = count + block.size, 2 * size
    return depths
