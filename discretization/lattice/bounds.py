"""What is decided before the search: nodes certainly in contact, and nodes where it never pays.

Certain. The energy is submodular in u: with adhesion on more links a minimiser only comes down. So
the contact nodes for w = 0 are certain; and if a contact line at a certain node gains energy by
advancing over one link, all other nodes free, the next node is certain too. With the next certain
node T links ahead of the line, and `gap` between free surface and node, the advance costs

    ΔE = (K_1 + K_{T-1} - t sinh μ) gap² - wΔx          (`Lattice.advance_cost` for T = ∞).

Never. Let ū be the surface held at the certain nodes, h = ū - g, v = ū - u. Replace v by the free
span between v_{j-r} and v_{j+r} where that is lower. This loses at most the L links about j on
which contact may pay, and gains at least t sinh μ coth μr (v_j - s)², s = (v_{j-r} + v_{j+r})/(2
cosh μr). So contact at j never pays if this exceeds wΔxL with v_j = h_j and bounds of v in s. For
the deepest contact v <= h_j and L <= 2r: it is not below D = about 1.9 δ₀; hence v <= min(h, D).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.lattice import span
from discretization.lattice.nodes import Lattice
from discretization.lattice.obstacle import pressing_nodes

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
_SLACK = 1e-9  # of wΔx: what a step must gain
_PROGRESS = 0.9  # repeat while a tenth of the nodes drop out


def certain(lattice: Lattice, g: Array) -> tuple[Nodes, Array]:
    """Certain contact nodes, and h (n,): height above g of the surface held at just these nodes."""
    held, before = _convex(lattice, g), -1
    while held.size > before:
        h = _heights(lattice, g, held)
        if (h < 0).any():  # two lines came down upon a node between them
            h = _heights(lattice, g, _supporting(lattice, g, held, h))
        h = np.maximum(h, 0.0)
        held = np.flatnonzero(h == 0)
        before = held.size
        if lattice.w:
            held = _grown(lattice, h, held)
    return held, h


def _convex(lattice: Lattice, g: Array) -> Nodes:
    """Contact nodes for w = 0."""
    return pressing_nodes(lattice, g) if g.max() > 0 else np.flatnonzero(g == 0)


def _grown(lattice: Lattice, h: Array, held: Nodes) -> Nodes:
    """The held nodes, and those their contact lines reach downhill."""
    last, mask = h.size - 1, np.zeros(h.size, bool)
    for nodes in (held, _reached(lattice, h, held)):
        mask[nodes] = True
    mask[last - _reached(lattice, h[::-1], last - held[::-1])] = True
    return np.flatnonzero(mask)


def _reached(lattice: Lattice, h: Array, held: Nodes) -> Nodes:
    """Nodes that the right lines of the held nodes gain by reaching.

    Each must be on the way to the next certain node, `far` links ahead: no span from there to the
    line's node may be blocked by a node between.
    """
    mu = lattice.log_decay
    count = np.diff(held, append=h.size) - 1
    far: Array = 1.0 + count
    if far.size:
        far[-1] += span.FAR / mu
    starting = np.flatnonzero(count)
    starting = starting[_gain(lattice, h, held[starting] + 1, far[starting] - 1) > 0]
    count = count[starting]
    line = np.repeat(np.arange(count.size), count)
    nth = np.arange(line.size) - np.repeat(np.cumsum(count) - count, count)
    node, links = held[starting][line] + nth + 1, far[starting][line] - nth - 1
    steepness = np.log(h[node]) - mu * links - np.log(-np.expm1(-2 * mu * links))
    ahead = -span.running_max(-steepness[::-1], count.size - 1 - line[::-1])[::-1]
    stops = (_gain(lattice, h, node, links) <= 0) | (steepness > ahead)
    before = np.cumsum(stops) - stops
    first = np.cumsum(count) - count
    return node[~stops & (before == before[first][line])]


def _gain(lattice: Lattice, h: Array, node: Nodes, links: Array) -> Array:
    """Energy gained by a line that advances to these nodes, `links` from the next certain node."""
    gap = span.excess(lattice, np.ones(1), links, h[node - 1], h[node], np.zeros(1))
    stiffness = lattice.link_over_decay / 2 + span.stiffness(lattice, links) - span.unit(lattice)
    return (1 - _SLACK) * lattice.w * lattice.spacing - stiffness * gap * gap


def _heights(lattice: Lattice, g: Array, held: Nodes) -> Array:
    h, free = np.zeros(g.size), np.ones(g.size, bool)
    free[held] = False
    at = np.flatnonzero(free)
    h[at] = -span.above(lattice, g, held, at, g[at])
    return h


def _supporting(lattice: Lattice, g: Array, held: Nodes, h: Array) -> Nodes:
    """The held nodes, and those of the nodes with h < 0 that then hold the surface."""
    nodes, keep, certain = np.flatnonzero(h <= 0), np.zeros(1, bool), np.zeros(h.size, bool)
    certain[held] = True
    while not keep.all():
        x = np.concatenate([[-math.inf], nodes, [math.inf]])
        y = np.concatenate([[0.0], g[nodes], [0.0]])
        above = span.excess(lattice, nodes - x[:-2], x[2:] - nodes, y[:-2], y[1:-1], y[2:])
        keep = (above >= 0) | certain[nodes]
        nodes = nodes[keep]
    return nodes


def deepest_contact(lattice: Lattice) -> float:
    """D [length]: contact deeper below ū never pays; at nearly the best r. γ₁ = 0: δ₀."""
    if not lattice.gamma1:
        return lattice.critical_gap
    mu, wdx = lattice.log_decay, lattice.w * lattice.cell
    r = max(1, round(2.4 / mu))
    rise = 1 - 1 / math.cosh(min(mu * r, span.FAR))
    return math.sqrt(2 * r * wdx * math.tanh(mu * r) / (span.unit(lattice))) / rise


def may_pay(lattice: Lattice, h: Array) -> NDArray[np.bool_]:
    """(n,) False where contact never pays: r = 1, 2, 4, ... up to six decay lengths, repeatedly."""
    mu, deepest = lattice.log_decay, deepest_contact(lattice)
    pays, before = h <= deepest, h.size + 1
    v, i = np.minimum(h, deepest), np.arange(h.size)
    while np.count_nonzero(pays) < _PROGRESS * before:
        before, r = int(np.count_nonzero(pays)), 1
        while r == 1 or (mu * r < 6 and r < h.size):
            ends = np.concatenate([np.full(r, deepest), v, np.full(r, deepest)])
            rise = h - (ends[: -2 * r] + ends[2 * r :]) / (2 * math.cosh(min(mu * r, span.FAR)))
            links = np.concatenate([[0], np.cumsum(pays[1:] & pays[:-1])])
            lost = links[np.minimum(i + r, h.size - 1)] - links[np.maximum(i - r, 0)]
            stiffness = span.unit(lattice) / math.tanh(mu * r)
            gain = stiffness * np.maximum(rise, 0.0) ** 2
            pays &= (gain <= (1 + _SLACK) * lattice.w * lattice.spacing * lost) | (h == 0)
            r *= 2
    return pays
