"""Free surfaces between two contact nodes around the axis: rings, by tables over all nodes.

P_m grows outwards and is regular on the axis, Q_m decays; both only enter by their ratios,

    L_m = ln P_m/P_0,    M_m = ln Q_0/Q_m,    S = L + M,    D_m = κ_m + σ_m(in) + σ_m(out),

of which L and M are sums of -ln λ, facing the axis and outwards, and D is the stiffness of node m
with its spring κ_m (rings.py). Of a surface held at nodes p < q, in units of 2πγ₁, every node
between is displaced by a u_p + b u_q, and the ends feel the stiffness E with the other end at rest,
of which the part C is tied to that end and the rest G to the ground:

    a = e^{M_p-M_m} (1 - e^{S_m-S_q})/(1 - e^{S_p-S_q}),   b = e^{L_m-L_q} (1 - e^{S_p-S_m})/(...),
    E_p = σ_p(out) + D_p/(e^{S_q-S_p} - 1),   E_q = σ_q(in) + D_q/(e^{S_q-S_p} - 1),
    C = D_p e^{L_p-L_q}/(1 - e^{S_p-S_q}),    G = E - C.

Nothing overflows. 1 - a - b and G are differences, by a part of l²/(links Δr)² smaller than their
terms: the tables have the digits of long double where there is one.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.rings import near, rings
from discretization.lattice.shares import Pair

Array = NDArray[Any]
_AXIS = 0.125  # weight of the node on the axis


@dataclass(frozen=True, eq=False)
class RingSpans:
    """Tables over nodes 0, 1, ..., n - 1: κ_m, σ outside and inside, L, M."""

    spring: Array
    outside: Array
    inside: Array
    rise: Array
    fall: Array

    @functools.cached_property
    def _both(self) -> Array:
        """S."""
        return np.asarray(self.rise + self.fall)

    @functools.cached_property
    def _whole(self) -> Array:
        """D."""
        return np.asarray(self.spring + self.outside + self.inside)

    def pair(self, left: Any, right: Any) -> Pair:
        """C and G of surfaces between two nodes each, of numbers or arrays."""
        apart = self._both[right] - self._both[left]
        with np.errstate(over="ignore"):
            far, scale = 1 / np.expm1(apart), -1 / np.expm1(-apart)
        tie = self._whole[left] * np.exp(self.rise[left] - self.rise[right]) * scale
        one = self.outside[left] + self._whole[left] * far - tie
        other = self.inside[right] + self._whole[right] * far - tie
        return Pair(*(np.asarray(part, float) for part in (tie, one, other)))

    def shape(
        self, left: int | None, right: int | None, at: Array | slice
    ) -> tuple[Array, Array, Array]:
        """a, b and 1 - a - b at nodes between two ends; None: the axis, or nothing further out."""
        if left is None and right is None:
            lost = -np.ones_like(self.fall[at])
            return _doubles(lost + 1, lost + 1, -lost)
        if right is None:
            lost = np.expm1(self.fall[left] - self.fall[at])
            return _doubles(lost + 1, 0 * lost, -lost)
        if left is None:
            lost = np.expm1(self.rise[at] - self.rise[right])
            return _doubles(0 * lost, lost + 1, -lost)
        s, whole = self._both, -np.expm1(self._both[left] - self._both[right])
        a = -np.exp(self.fall[left] - self.fall[at]) * np.expm1(s[at] - s[right]) / whole
        b = -np.exp(self.rise[at] - self.rise[right]) * np.expm1(s[left] - s[at]) / whole
        return _doubles(a, b, 1 - a - b)


def _doubles(*parts: Array) -> tuple[Array, Array, Array]:
    a, b, rest = (np.asarray(part, float) for part in parts)
    return a, b, rest


@functools.lru_cache(maxsize=8)
def ring_spans(kappa: float, count: int) -> RingSpans:
    """The tables of so many nodes on a lattice with this κ."""
    nodes, exact = np.arange(count), np.longdouble(kappa)
    outside, inside = near(exact, count, float(rings(kappa).pull(count - 1, 1)))
    spring, links = np.where(nodes > 0, nodes, _AXIS) * exact, nodes[:-1] + np.longdouble(0.5)
    fall, rise = np.zeros((2, count), np.longdouble)
    fall[1:] = np.cumsum(np.log1p((spring[1:] + outside[1:]) / links))
    rise[1:] = np.cumsum(np.log1p((spring[:-1] + inside[:-1]) / links))
    return RingSpans(spring, outside, inside, rise, fall)
