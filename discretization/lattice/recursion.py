"""The shortest path over contact nodes, one node after the other.

With the quantities of shortest_path.py: V_j = min_i V_i + K_T (h_j - λᵀh_i)² - wΔx·links over the
starts i of admissible spans (starts.py).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.nodes import Lattice
from discretization.lattice.starts import Ends, Starts

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_TIE = 1e-12  # of wΔx: what more contact may cost


class Chain(NamedTuple):
    """Nodes where contact may pay, their depth h, links of certain contact to the one before."""

    node: Nodes
    depth: Array
    links: Array

    def reversed(self) -> Chain:
        links = np.concatenate([self.links[:1], self.links[:0:-1]])
        return Chain(-self.node[::-1], self.depth[::-1], links)


class Paths(NamedTuple):
    """V_j and predecessor (-1: none) of each node of the chain, the last contact and its V.

    reached: the stack at each of the stops, just after landing there.
    """

    value: Array
    before: Nodes
    last: int
    least: float
    reached: dict[int, Starts]


def shortest(lattice: Lattice, chain: Chain, stops: Collection[int] = ()) -> Paths:
    """The recursion of statement 2, node by node. stops: where the stack is kept."""
    n, tie = chain.node.size, _TIE * lattice.w * lattice.spacing
    starts, reached = Starts(lattice), {}
    value, before = np.empty(n), np.empty(n, np.int64)
    for j, (x, h, links) in enumerate(_steps(chain)):
        adhesion = lattice.w * lattice.spacing * links
        value[j], before[j] = starts.land(x, h, adhesion, tie)
        if j in stops:
            reached[j] = starts.fork()
        starts.push(j, x, h, float(value[j]))
    return Paths(value, before, *starts.last(tie), reached)


def _steps(chain: Chain) -> Iterator[tuple[int, float, float]]:
    """Node, depth and links to the node before, for each node of the chain."""
    return zip(*(column.tolist() for column in chain), strict=True)


def without_adhesion(
    lattice: Lattice, chain: Chain, paths: Paths, first: int, core: int
) -> tuple[float, Ends]:
    """V of the core and the starts of spans over it if the links first..core do not adhere."""
    starts, value = paths.reached[first], float(paths.value[first])
    part = slice(first, core + 1)
    steps = _steps(Chain(chain.node[part], chain.depth[part], chain.links[part]))
    x, h, _ = next(steps)
    for beyond, depth, _ in steps:
        starts.push(first, x, h, value)
        value, _ = starts.land(beyond, depth, 0.0, 0.0)
        x, h = beyond, depth
    return value, starts.ends(x, h)
