"""The nodes there are under an indenter, the one that touches first, and the heights there."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.nodes.lattice import Lattice
from energy import Indenter

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
MOST = 10**7  # nodes that are looked through, or kept
_ENDLESS = 1 << 31  # nodes, beyond which a convex profile is not looked for its lowest one
_AHEAD = np.unique(np.geomspace(1, _ENDLESS, 256).astype(np.int64)) - 1  # further and further apart
_AT_ONCE = 128  # links looked at


class Region(NamedTuple):
    """Nodes first..last in which contact is looked for, and the node that touches first."""

    first: int
    last: int
    lowest: int


def positions(lattice: Lattice, indenter: Indenter, nodes: Array | Nodes) -> Array:
    """x of the nodes; nodes on an end of the extent stay on it in spite of rounding."""
    x, (lo, hi) = lattice.x(nodes), indenter.extent
    return np.clip(x, lo, hi) if lo > -math.inf or hi < math.inf else x


def heights(lattice: Lattice, indenter: Indenter, nodes: Array | Nodes) -> Array:
    """f at the nodes."""
    x = positions(lattice, indenter, nodes)
    f = indenter.height(x)
    if not np.isfinite(f).all():
        raise ValueError(
            f"indenter.height({float(x[~np.isfinite(f)][0])!r}) is not finite; give a profile that "
            f"is finite inside its extent {indenter.extent}"
        )
    return f


def region(lattice: Lattice, indenter: Indenter, depth: float) -> Region:
    """Where contact is possible. ValueError if the profile has no lowest point to touch with."""
    (lo, hi), dx = indenter.extent, lattice.spacing
    first = math.ceil(max((lo - lattice.origin) / dx - 1e-9, -_ENDLESS))
    last = math.floor(min((hi - lattice.origin) / dx + 1e-9, _ENDLESS))
    if first > last:
        raise ValueError(f"spacing = {dx!r} leaves no node on the indenter; give a smaller one")
    if first == last and lattice.gamma1:
        raise ValueError(f"spacing = {dx!r} leaves one node on the indenter; give a smaller one")
    if not indenter.convex and last - first > MOST:
        if hi - lo < math.inf:
            raise ValueError(
                f"spacing = {dx!r} puts {last - first} nodes on the indenter: at most {MOST} are "
                "looked through; give it a smaller extent, or a larger spacing"
            )
        first, last = _searched(lattice, indenter, depth, first, last)
    if indenter.apex is not None:
        beside = min(max(math.floor((indenter.apex - lattice.origin) / dx + 1e-9), first), last)
        if lattice.x(beside) == indenter.apex:
            return Region(first, last, beside)
        pair = beside, min(beside + 1, last)
        return Region(first, last, pair[int(np.argmin(heights(lattice, indenter, np.array(pair))))])
    if indenter.convex:
        return Region(first, last, _bottom(lattice, indenter, first, last))
    f = heights(lattice, indenter, np.arange(first, last + 1.0))
    return Region(first, last, first + int(np.argmin(f)))


def first_failing(holds: Callable[[Nodes], NDArray[np.bool_]], most: int) -> int:
    """The first of links 0, 1, ..., most - 1 that does not hold, where all before do; most: none.

    Many are looked at at once: first links further and further apart, then those between.
    """
    low, high, links = 0, most, _AHEAD[most > _AHEAD]
    while low < high:
        held = holds(links)
        i = links.size if held.all() else int(held.argmin())
        low, high = int(links[i - 1]) + 1 if i else low, int(links[i]) if i < links.size else high
        links = np.arange(low, high, max(1, (high - low) // _AT_ONCE))
    return low


def _bottom(lattice: Lattice, indenter: Indenter, first: int, last: int) -> int:
    """The lowest node of a convex profile: downhill from the origin to the first link that rises.

    ValueError if it falls for ever.
    """
    start = min(max(0, first), last)
    for side, limit in ((1, last), (-1, first)):

        def falls(links: Nodes, side: int = side) -> NDArray[np.bool_]:
            ends = (positions(lattice, indenter, start + side * (links + j)) for j in (0, 1))
            with np.errstate(over="ignore", invalid="ignore"):  # far from where it is lowest
                near, far = map(indenter.height, ends)
            return np.asarray((far <= near) & np.isfinite(far))

        found = first_failing(falls, abs(limit - start))
        if found == _ENDLESS:
            raise ValueError(_bottomless(lattice, indenter, found))
        if found:
            return start + side * found
    return start


def _searched(
    lattice: Lattice, indenter: Indenter, depth: float, first: int, last: int
) -> tuple[int, int]:
    """Window about the origin, doubled until its ends stand clear of the surface."""
    half = 1 << 10
    while 2 * half <= MOST:
        lo, hi = max(first, -half), min(last, half)
        f = heights(lattice, indenter, np.arange(lo, hi + 1.0))
        clear = max(depth, float(f.min())) + lattice.deepest_contact
        if abs(lo + int(np.argmin(f))) <= half // 2 and min(f[0], f[-1]) > clear:
            return lo, hi
        half *= 2
    raise ValueError(_bottomless(lattice, indenter, half // 2))


def _bottomless(lattice: Lattice, indenter: Indenter, nodes: int) -> str:
    return (
        f"indenter = {indenter!r} has no lowest point within {nodes} nodes of x = "
        f"{lattice.origin!r}; give Profile(..., extent=(lo, hi)) or a larger spacing"
    )


def unknown(lattice: Lattice, depth: float, node: int) -> str:
    """What to say of a contact that reaches the last node of a profile that may go on."""
    return (
        f"depth = {depth!r} spreads the contact over the whole known profile, to x = "
        f"{lattice.x(node)!r}, beyond which it is not known any more; give a wider profile, a "
        "smaller depth, or add a FlatPunch whose edge ends the indenter there"
    )
