"""The metastable branch on the lattice: contact lines moved by comparing energies.

Descent in u alone cannot move a contact line: lifting a contact node costs its adhesion at once,
and a free node has to cross a finite gap. So neighbouring contact sets are compared, each with its
surface re-equilibrated. Between contact lines u = g, outside are exact tails, hence the energy is
a sum over links and moving one line by one link changes it by `Lattice.advance_cost` of one gap,

    gap_m = λ g_m - g_{m+1} = (f_{m+1} - f_m) + (1-λ)(f_m - d),    line advances iff ΔE(gap_m) <= 0

(small slopes; for finite ones `Lattice.gap` is scaled so that the same rule holds). Raising d
lowers every gap, and where the profile is convex the gap grows outwards. So the state of a convex
profile is found without stepping through the path: from the touching node outwards to the first
link that resists, which is bracketed with O(log n) heights. Around an axis that is so while the
contact is pressed (radial.py).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.nodes import Lattice
from energy import Indenter

Array = NDArray[np.float64]
BLOCK, FIRST_BLOCK = 1 << 14, 64  # nodes: a block stays in the cache, most scenes need the first
MAX_NODES = 1 << 31
_SEARCH_NODES = 1 << 24  # in which a profile is looked through for its lowest node
_BOTH: Array = np.array([[0.0], [1.0]])  # nodes of a link
_TIE = 1e-12  # relative slack that keeps a line where both sides cost the same


class Region(NamedTuple):
    """Nodes first..last in which contact is looked for, and the node that touches first."""

    first: int
    last: int
    lowest: int


def mirror_axis(lattice: Lattice, indenter: Indenter, first: int, last: int) -> float | None:
    """x of the node about which nodes first..last and a symmetric indenter are mirrored."""
    middle = (first + last) // 2
    symmetric = indenter.symmetric and first + last == 2 * middle
    return indenter.apex if symmetric and lattice.x(middle) == indenter.apex else None


def height(lattice: Lattice, indenter: Indenter, node: int) -> float:
    """f at one node."""
    return float(heights(lattice, indenter, np.array([node], float))[0])


def heights(lattice: Lattice, indenter: Indenter, nodes: Array) -> Array:
    """f at the nodes; nodes on an end of the extent stay on it in spite of rounding."""
    x = _positions(lattice, indenter, nodes)
    f = indenter.height(x)
    if not (math.isfinite(f.dot(f)) or np.isfinite(f).all()):  # squares are the fastest sum
        raise ValueError(
            f"indenter.height({float(x[~np.isfinite(f)][0])!r}) is not finite; give a profile that "
            f"is finite inside its extent {indenter.extent}"
        )
    return f


def _positions(lattice: Lattice, indenter: Indenter, nodes: Array) -> Array:
    x, (lo, hi) = lattice.x(nodes), indenter.extent
    return np.clip(x, lo, hi) if lo > -math.inf or hi < math.inf else x


def blocks(
    lattice: Lattice, indenter: Indenter, start: int, stop: int
) -> Iterator[tuple[int, Array]]:
    """Heights from node start to node stop in growing blocks that share one node."""
    for first, last in blocks_between(start, stop):
        way = 1 if stop >= start else -1
        yield first, heights(lattice, indenter, np.arange(first, last + way, way, dtype=float))


def blocks_between(start: int, stop: int) -> Iterator[tuple[int, int]]:
    """First and last nodes of these blocks."""
    side, size = (1 if stop >= start else -1), FIRST_BLOCK
    if abs(stop - start) >= MAX_NODES:
        stop = start + side * MAX_NODES
    while True:
        end = start + side * min(size, abs(stop - start))
        yield start, end
        if end == stop:
            return
        start, size = end, min(4 * size, BLOCK)


def region(lattice: Lattice, indenter: Indenter, depth: float) -> Region:
    """Where contact is possible. ValueError if the profile has no lowest point to touch with."""
    (lo, hi), dx = indenter.extent, lattice.spacing
    bound = float(MAX_NODES)
    first = math.ceil(max((lo - lattice.origin) / dx - 1e-9, -bound))
    last = math.floor(min((hi - lattice.origin) / dx + 1e-9, bound))
    if first > last:
        raise ValueError(f"spacing = {dx!r} leaves no node on the indenter; give a smaller one")
    if first == last and lattice.gamma1:
        raise ValueError(f"spacing = {dx!r} leaves one node on the indenter; give a smaller one")
    if indenter.apex is not None:
        beside = min(max(math.floor((indenter.apex - lattice.origin) / dx + 1e-9), first), last)
        if lattice.x(beside) == indenter.apex:
            return Region(first, last, beside)
        pair = beside, min(beside + 1, last)
        return Region(first, last, min(pair, key=lambda node: height(lattice, indenter, node)))
    if indenter.convex:
        return Region(first, last, _bottom(lattice, indenter, first, last))
    if last - first < _SEARCH_NODES:
        return Region(first, last, _lowest(lattice, indenter, first, last)[0])
    return _searched(lattice, indenter, depth, first, last)


def _bottom(lattice: Lattice, indenter: Indenter, first: int, last: int) -> int:
    """The lowest node of a convex profile: downhill from the origin to the first link that rises.

    ValueError if it falls for ever.
    """
    start = min(max(0, first), last)
    for side, limit in ((1, last), (-1, first)):
        rise = functools.partial(_rise, lattice, indenter, start, side)
        found = first_above(0.0, rise, abs(limit - start))
        if found == MAX_NODES:
            raise ValueError(_bottomless(lattice, indenter, found))
        if found:
            return start + side * found
    return start


def _lowest(lattice: Lattice, indenter: Indenter, first: int, last: int) -> tuple[int, float]:
    node, least = first, math.inf
    for start, f in blocks(lattice, indenter, first, last):
        i = int(np.argmin(f))
        if f[i] < least:
            node, least = start + i, float(f[i])
    return node, least


def _searched(lattice: Lattice, indenter: Indenter, depth: float, first: int, last: int) -> Region:
    """Window about the origin, doubled until its ends stand clear of the surface."""
    half = 1 << 10
    while half <= _SEARCH_NODES:
        lo, hi = max(first, -half), min(last, half)
        node, least = _lowest(lattice, indenter, lo, hi)
        ends = heights(lattice, indenter, np.array([lo, hi], float))
        clear = max(depth, least) + lattice.deepest_contact
        if abs(node) <= half // 2 and ends.min() > clear:
            return Region(lo, hi, node)
        half *= 2
    raise ValueError(_bottomless(lattice, indenter, half // 2))


def _bottomless(lattice: Lattice, indenter: Indenter, nodes: int) -> str:
    return (
        f"indenter = {indenter!r} has no lowest point within {nodes} nodes of x = "
        f"{lattice.origin!r}; give Profile(..., extent=(lo, hi)) or a larger spacing"
    )


def adhered(
    lattice: Lattice, indenter: Indenter, depth: float, where: Region
) -> tuple[int, int] | None:
    """First and last contact node of a convex profile on the path from first touch to `depth`.

    None: it has let go. γ₁ > 0.
    """
    first, last, lowest = where
    least = height(lattice, indenter, lowest)
    if lattice.axis == 0 and depth < least:
        right = _receded(lattice, indenter, depth, outermost(lattice, indenter, least, 0, last))
    else:
        right = outermost(lattice, indenter, depth, lowest, last)
    if mirror_axis(lattice, indenter, lowest, lowest) is not None:
        left = 2 * lowest - right
    else:
        left = outermost(lattice, indenter, depth, lowest, first)
    return None if left == right and depth < least else (left, right)


def _receded(lattice: Lattice, indenter: Indenter, depth: float, last: int) -> int:
    """The node a disc around the axis recedes to: of narrower ones the gap may be larger, too."""
    f = heights(lattice, indenter, np.arange(last + 1.0))
    holds = lattice.at(np.arange(last), 1).gap(f[:-1], f[1:], depth) <= _reach(lattice)
    return int(np.max(np.flatnonzero(holds) + 1, initial=0))


def _reach(lattice: Lattice) -> float:
    """The gap that adhesion pays for."""
    return lattice.critical_gap * (1 + _TIE)


def outermost(
    lattice: Lattice,
    indenter: Indenter,
    depth: float,
    start: int,
    limit: int,
    strongest: float = 1.0,
) -> int:
    """Outwards from a node to the first link whose adhesion does not pay for its gap.

    The profile is convex: the gap grows outwards. strongest: factor on the work of adhesion.
    """
    side = 1 if limit >= start else -1

    def gap(links: Array) -> Array:
        nodes, f, f_next = _linked(lattice, indenter, start, side, links)
        return np.asarray(lattice.at(nodes, side).gap(f, f_next, depth))

    reach = math.sqrt(strongest) * _reach(lattice)
    return start + side * first_above(reach, gap, abs(limit - start))


def _rise(lattice: Lattice, indenter: Indenter, start: int, side: int, links: Array) -> Array:
    """By how much f rises over links outwards from node start."""
    _, f, f_next = _linked(lattice, indenter, start, side, links)
    return f_next - f


def below(lattice: Lattice, indenter: Indenter, where: Region, level: float) -> tuple[int, int]:
    """First and last node of a convex profile with f <= level, at least that of the lowest one."""
    found = []
    for end in where[:2]:
        way = 1 if end > where.lowest else -1

        def f(links: Array, way: int = way) -> Array:
            nodes = where.lowest + way * (links + 1)
            return indenter.height(_positions(lattice, indenter, nodes))

        found.append(where.lowest + way * first_above(level, f, abs(end - where.lowest)))
    return found[0], found[1]


def _linked(
    lattice: Lattice, indenter: Indenter, start: int, side: int, links: Array
) -> tuple[Array, Array, Array]:
    """Inner nodes of links outwards from node start, and f, maybe not finite, at both ends."""
    outwards = (links + _BOTH).ravel()
    nodes = float(start) + outwards if side > 0 else float(start) - outwards
    f = indenter.height(_positions(lattice, indenter, nodes))
    return nodes[: links.size], f[: links.size], f[links.size :]


def unknown(lattice: Lattice, depth: float, node: int) -> str:
    """What to say of a contact that reaches the last node of a profile that may go on."""
    return (
        f"depth = {depth!r} spreads the contact over the whole known profile, to x = "
        f"{lattice.x(node)!r}, beyond which it is not known any more; give a wider profile, a "
        "smaller depth, or add a FlatPunch whose edge ends the indenter there"
    )


_FIRST: Array = np.exp2(np.arange(32.0)) - 1
_SHARES: Array = np.arange(16.0) / 16


def first_above(level: float, term: Callable[[Array], Array], count: int) -> int:
    """The first of 0, 1, ..., count - 1 with term > level, as for all after it; else count.

    term: of an array of these numbers; where it is not finite it counts as above. Powers of two
    are tried first, then numbers at equal distances between the last two of them.
    """
    low, high, tried = 0.0, float(count), _FIRST[: count.bit_length()]
    with np.errstate(over="ignore", invalid="ignore"):
        while low < high:
            first = int(term(tried).searchsorted(level, side="right"))  # nan: far beyond
            if first < tried.size:
                high = float(tried[first])
            if first:
                low = float(tried[first - 1]) + 1
            tried = np.floor(low + _SHARES * (high - low))
    return int(low)
