"""One side of a contact on the lattice: at which depth its line passes each link.

    d_m = f_m + (f_{m+1} - f_m - G)/(1 - λ),      G: `Lattice.critical_gap`,

with the G of the work of adhesion that holds at the link, for closing and for opening it.

Where adhesion is stronger on one side than on the other, or the profile falls again, the line of
one side may recede beyond the node that touches first, while the other line still holds.
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
    """One side, outwards (n nodes, n - 1 links); node `start` is the one that touches first.

    Links are counted from there, negative ones lie on the other side of it. way: -1 left, +1 right.
    x, f of the nodes; the depths at which each link closes, inf beyond the last one (n,), and opens
    (n - 1,); running sums from node `start` up to each node (n,) of f and f², that node left out,
    and over the links of (Δf)² and of the pattern's factor on w.
    """

    way: int
    start: int
    x: Array
    f: Array
    closes: Array
    opens: Array
    sum_f: Array
    sum_f2: Array
    sum_df2: Array
    bonds: Array

    def links(self, x: float, spacing: float) -> int:
        """Links between node `start` and a line at the node at x."""
        return round(self.way * (x - float(self.x[self.start])) / spacing)

    def moved(self, links: int, depth: float) -> int:
        """Links in contact at this depth after there were `links`."""
        at, size = links + self.start, _BLOCK
        while self.closes[at] <= depth:
            resists = self.closes[at : at + size] > depth
            at += int(np.argmax(resists)) if resists.any() else resists.size
            size *= 2
        size = _BLOCK
        while at and self.opens[at - 1] > depth:
            holds = self.opens[max(at - size, 0) : at][::-1] <= depth
            at -= int(np.argmax(holds)) if holds.any() else holds.size
            size *= 2
        return at - self.start

    def crossed(self, links: int, depth: float) -> tuple[Array, Array]:
        """Depths at which the line crosses links on the way here, and whether by a jump."""
        here, there = links + self.start, self.moved(links, depth) + self.start
        if there >= here:
            own = self.closes[here:there]
            at = np.maximum.accumulate(own)
        else:
            own = self.opens[there:here][::-1]
            at = np.minimum.accumulate(own)
        return at, own != at


def build(scene: Scene, lattice: Lattice, where: Region, deepest: float) -> tuple[Side, Side]:
    """Left and right side, each up to the first link that resists at the largest depth.

    They reach to the other side, too, where a line may recede beyond the node that touches first:
    with a pattern, or a profile that is not convex.
    """
    left, right = (_outwards(scene, lattice, where, way, deepest) for way in (-1, 1))
    crosses = scene.pattern is not None or not scene.indenter.convex
    most = None if crosses else 1
    return (
        _side(scene, lattice, where.lowest, -1, right[1:most][::-1], left),
        _side(scene, lattice, where.lowest, 1, left[1:most][::-1], right),
    )


def _outwards(scene: Scene, lattice: Lattice, where: Region, way: int, deepest: float) -> Array:
    """Heights from the node that touches first to the link that resists, and three links more."""
    limit = where.first if way < 0 else where.last
    strongest = max(scene.pattern.factors) if scene.pattern else 1.0
    reach = lattice.critical_gap * math.sqrt(strongest)
    parts: list[Array] = []
    for _, f in blocks(lattice, scene.indenter, where.lowest, limit):
        parts.append(f if not parts else f[1:])
        whole = np.concatenate(parts)
        closes = whole[:-1] + (np.diff(whole) - reach) / lattice.loss
        resists = np.flatnonzero(closes > deepest)
        if resists.size and resists[0] + _SPARE < closes.size:
            return np.asarray(whole[: resists[0] + 1 + _SPARE])
    end = scene.indenter.extent[0 if way < 0 else 1]
    if end not in scene.indenter.walls:
        raise ValueError(
            f"depth = {deepest!r} spreads the contact over the whole known profile, to x = "
            f"{end!r}; give a wider profile or smaller depths"
        )
    return whole


def _side(
    scene: Scene, lattice: Lattice, lowest: int, way: int, inner: Array, outer: Array
) -> Side:
    """The side with these heights, outwards, before the node that touches first and from it on."""
    f, start = np.concatenate([inner, outer]), inner.size
    x, steps = lattice.x(lowest + way * np.arange(-start, outer.size)), np.diff(f)
    factor = factors(scene, (x[1:] + x[:-1]) / 2)
    opened = Lattice.of(scene.opened, lattice.spacing, lattice.origin).critical_gap
    closes, opens = (
        f[:-1] + (steps - gap * np.sqrt(factor)) / lattice.loss
        for gap in (lattice.critical_gap, opened)
    )
    sums = (_running(part, start) for part in (f[1:], f[1:] ** 2, steps**2, factor))
    beyond, x = np.append(closes, math.inf), np.clip(x, *scene.indenter.extent)
    return Side(way, start, x, f, beyond, opens, *sums)


def _running(parts: Array, start: int) -> Array:
    """Sums (n + 1,) of the n parts from `start` on, those before it counted negative."""
    before, after = np.cumsum(parts[:start][::-1])[::-1], np.cumsum(parts[start:])
    return np.concatenate([-before, [0.0], after])


def factors(scene: Scene, x: Array) -> Array:
    """The pattern's factor on w at x."""
    return np.ones_like(x) if scene.pattern is None else scene.pattern.factor(x)
