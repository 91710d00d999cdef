"""A line that waits: once it has passed the next link, another node would be penetrated.

That node is held, too, and the line passes at a larger depth: where the surface above the indenter
has the same energy before and after. As the energies compared are then no squares of one gap, that
depth is found by halving.
"""

from __future__ import annotations

import functools
import itertools
import math

from discretization.nodes.rules import Rules, ordered


@functools.lru_cache(maxsize=1 << 16)
def advances(rules: Rules, node: int, side: int, other: int | None) -> float:
    """Depth at which a line passes the next link, with the nodes it would put into the indenter.

    inf: another node touches before.
    """
    alone, after = rules.passes(node, side, other), node + side
    if other is not None and abs(other - after) < 2:
        return alone
    if rules.clears(*ordered(side, after, other), alone):
        return alone
    return _waiting_depth(rules, node, side, other, alone)


def _waiting_depth(rules: Rules, node: int, side: int, other: int | None, alone: float) -> float:
    """Depth at which a line passes the next link, above that at which it would alone.

    inf: another node touches before.
    """
    low, high = alone, rules.touches(*ordered(side, node, other))[0]
    if _cost(rules, node, side, other, high) > 0:
        return math.inf
    while high - low > rules.tie(low, high):
        middle = (low + high) / 2
        if _cost(rules, node, side, other, middle) > 0:
            low = middle
        else:
            high = middle
    return high


def _cost(rules: Rules, node: int, side: int, other: int | None, depth: float) -> float:
    """Energy by which passing the next link changes that of the surface above the indenter.

    Of adhesion it gains that link's alone: not what the nodes held may adhere by.
    """
    after = node + side
    new = sorted([after, *held_nodes(rules, *ordered(side, after, other), depth)])
    left, right = ordered(side, node, other)
    squeezed = sum(rules.stiffness[0][i] / 2 * (depth - rules.f[i]) ** 2 for i in new)
    surfaces = sum(_stored(rules, *part, depth) for part in itertools.pairwise([left, *new, right]))
    stored = squeezed + surfaces - _stored(rules, left, right, depth)
    return float(stored) - rules.adhesion(node, after)


def _stored(rules: Rules, left: int | None, right: int | None, depth: float) -> float:
    """Energy of the surface between two contact nodes (None: none there), free or one link."""
    lattice, f, first = rules.lattice, rules.f, rules.first
    if left is not None and right is not None:
        energy = lattice.gap_energy(first + left, first + right, f[left], f[right], depth)
        return float(energy)
    ends = [(end, side) for end, side in ((left, 1), (right, -1)) if end is not None]
    return sum(float(lattice.pull(first + i, way)) / 2 * (depth - f[i]) ** 2 for i, way in ends)


def held_nodes(rules: Rules, left: int | None, right: int | None, depth: float) -> list[int]:
    """The nodes that keep the surface between two contact nodes above the indenter.

    The first one to touch is among them, as they only become more with the depth.
    """
    touch, node = rules.touches(left, right)
    if touch >= depth:
        return []
    return [*held_nodes(rules, left, node, depth), node, *held_nodes(rules, node, right, depth)]
