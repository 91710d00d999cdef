"""The shortest path over contact nodes, one node after the other.

With the quantities of shortest_path.py: V_j = min_i V_i + K_T (h_j - λᵀh_i)² - wΔx·links over the
starts i of admissible spans that are still alive (starts.py).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.nodes import Lattice
from discretization.lattice.span import FAR
from discretization.lattice.starts import Few, Many, Starts

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_TIE = 1e-12  # of wΔx: what more contact may cost
_PRUNE = 8  # steps between two removals of starts that lost at v = 0


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
    reached: dict[int, Few | Many]


def shortest(lattice: Lattice, chain: Chain, stops: Collection[int] = ()) -> Paths:
    """The recursion of statement 2, node by node. stops: where the stack is kept."""
    n, tie = chain.node.size, _TIE * lattice.w * lattice.spacing
    stack: Few | Many = Few(lattice, int(np.ptp(chain.node)) + 1 if n else 1)
    reached = {}
    value, before = np.empty(n), np.empty(n, np.int64)
    for j, (x, h, links, growth) in enumerate(_steps(lattice, chain)):
        adhesion = lattice.w * lattice.spacing * links
        value[j], before[j] = stack.land(x, h, adhesion, growth, tie)
        if j in stops:
            reached[j] = stack.fork()
        if j % _PRUNE == 0:
            stack.prune(x)
        stack.push(j, x, h, value[j])
        stack = stack.fitting()
    last, least = _detached(stack.starts, tie)
    return Paths(value, before, last, least, reached)


def _detached(starts: Starts, tie: float) -> tuple[int, float]:
    """The last contact, with an admissible tail beyond it, and its V."""
    total = np.where(starts.slope >= 0, starts.value, math.inf)
    best = int((total <= total.min() + tie).nonzero()[0][-1])
    return int(starts.place[best]), float(total[best])


def _steps(lattice: Lattice, chain: Chain) -> Iterator[tuple[int, float, float, float]]:
    """Node, depth, links to the node before and exp(μT) to it, for each node of the chain."""
    growth = np.minimum(lattice.log_decay * np.diff(chain.node, prepend=chain.node[:1]), FAR)
    columns = (chain.node, chain.depth, chain.links, np.exp(growth))
    return zip(*(column.tolist() for column in columns), strict=True)


def without_adhesion(
    lattice: Lattice, chain: Chain, paths: Paths, first: int, core: int
) -> tuple[float, Starts]:
    """V of the core and the starts alive there if the links first..core do not adhere."""
    stack, value = paths.reached[first], float(paths.value[first])
    part = slice(first, core + 1)
    steps = list(_steps(lattice, Chain(chain.node[part], chain.depth[part], chain.links[part])))
    for j, ((x0, h0, _, _), (x, h, _, growth)) in enumerate(itertools.pairwise(steps)):
        if j % _PRUNE == 0:
            stack.prune(x0)
        stack.push(first, x0, h0, value)
        stack = stack.fitting()
        value, _ = stack.land(x, h, 0.0, growth, 0.0)
    return value, stack.starts
