"""One side of a contact on the lattice: at which depth its line passes each link.

    d_m = f_m + (f_{m+1} - f_m - G)/(1 - λ),      G: `Lattice.critical_gap`,

with the G of the work of adhesion that holds at the link, for closing and for opening it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.fronts import Region, blocks
from discretization.lattice.nodes import Lattice
from energy import Scene

Array = NDArray[np.float64]
_SPARE = 4
_BLOCK = 16


class Side(NamedTuple):
    """One side, outwards from the node that touches first (n nodes, n - 1 links).

    x, f of the nodes; the depths at which each link closes, inf beyond the last one (n,), and opens
    (n - 1,); running sums up to each node (n,) of f and f², node 0 left out, and over the links of
    (Δf)² and of the pattern's factor on w.
    """

    x: Array
    f: Array
    closes: Array
    opens: Array
    sum_f: Array
    sum_f2: Array
    sum_df2: Array
    bonds: Array

    def moved(self, links: int, depth: float) -> int:
        """Links in contact at this depth after there were `links`."""
        size = _BLOCK
        while self.closes[links] <= depth:
            resists = self.closes[links : links + size] > depth
            links += int(np.argmax(resists)) if resists.any() else resists.size
            size *= 2
        size = _BLOCK
        while links and self.opens[links - 1] > depth:
            holds = self.opens[max(links - size, 0) : links][::-1] <= depth
            links -= int(np.argmax(holds)) if holds.any() else holds.size
            size *= 2
        return links

    def crossed(self, links: int, depth: float) -> tuple[Array, Array]:
        """Depths at which the line crosses links on the way here, and whether by a jump."""
        there = self.moved(links, depth)
        if there >= links:
            own = self.closes[links:there]
            at = np.maximum.accumulate(own)
        else:
            own = self.opens[there:links][::-1]
            at = np.minimum.accumulate(own)
        return at, own != at


def build(scene: Scene, lattice: Lattice, where: Region, side: int, deepest: float) -> Side:
    """Nodes outwards to the first link that resists at the largest depth, and three links more."""
    limit = where.first if side < 0 else where.last
    strongest = max(scene.pattern.factors) if scene.pattern else 1.0
    reach = lattice.critical_gap * math.sqrt(strongest)
    parts: list[Array] = []
    for _, f in blocks(lattice, scene.indenter, where.lowest, limit):
        parts.append(f if not parts else f[1:])
        whole = np.concatenate(parts)
        closes = whole[:-1] + (np.diff(whole) - reach) / lattice.loss
        resists = np.flatnonzero(closes > deepest)
        if resists.size and resists[0] + _SPARE < closes.size:
            whole = whole[: resists[0] + 1 + _SPARE]
            break
    else:
        end = scene.indenter.extent[0 if side < 0 else 1]
        if end not in scene.indenter.walls:
            raise ValueError(
                f"depth = {deepest!r} spreads the contact over the whole known profile, to x = "
                f"{end!r}; give a wider profile or smaller depths"
            )
    f, steps = whole, np.diff(whole)
    x = lattice.x(where.lowest + side * np.arange(f.size))
    factor = _factors(scene, (x[1:] + x[:-1]) / 2)
    opened = Lattice.of(scene.opened, lattice.spacing, lattice.origin).critical_gap
    closes, opens = (
        f[:-1] + (steps - gap * np.sqrt(factor)) / lattice.loss
        for gap in (lattice.critical_gap, opened)
    )
    sums = (
        np.concatenate([[0.0], np.cumsum(part)]) for part in (f[1:], f[1:] ** 2, steps**2, factor)
    )
    beyond = np.append(closes, math.inf)
    return Side(np.clip(x, *scene.indenter.extent), f, beyond, opens, *sums)


def _factors(scene: Scene, x: Array) -> Array:
    return np.ones_like(x) if scene.pattern is None else scene.pattern.factor(x)
