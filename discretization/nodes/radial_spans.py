"""Free surfaces on nodes r_i = iΔr around the axis: outside and inside a contact, and rings.

In units of the stiffness 2πγ₁ link m, between nodes m and m + 1, has the stiffness m + 1/2 and
node i the spring κi, κ = kΔr²/γ₁, that on the axis κ/8: free nodes obey

    (i + ½) u_{i+1} + (i - ½) u_{i-1} = (2 + κ) i u_i.

A free surface that is held at node m pulls at it with σ_m u_m, the spring there not counted. Node
by node, with positive numbers only and an error that every step makes smaller,

    outside   σ_m = (m + ½) s/(m + ½ + s),   s = κ(m + 1) + σ_{m+1},
    inside    σ_m = (m - ½) s/(m - ½ + s),   s = κ(m - 1) + σ_{m-1},   from σ_0 = 0 on the axis.

Far out, σ is known without the nodes between: the outer surface is the Legendre function
Q_{m-½}(cosh μ), κ = 4 sinh²(μ/2), the inner one is P_{m-½} there, and with y = d ln u_m/dμ

    σ_m = ∓ y sinh μ - (m ± ½) κ/2.

y follows from √sinh μ u_m = √μ [K₀(mμ) A + K₁(mμ) B/m] (I₀, -I₁ inside; Olver, Asymptotics and
Special Functions, chapter 12), whose coefficients obey, ψ = (1/μ² - 1/sinh² μ)/4,

    2B' = A'' + A'/μ - ψA,    2m²A' = B'' - B'/μ + B/μ² - ψB:    A = 1, 8B = 1/μ - coth μ,

but for O(m⁻²). Of that A' = a/m² and the same of B are kept, a = 7μ/960 where mμ is not large; for
large mμ the latter does not matter.

Rings, the surfaces between two contact nodes, are known by tables over all nodes. P_m grows
outwards and is regular on the axis, Q_m decays; both only enter by their ratios,

    L_m = ln P_m/P_0,    M_m = ln Q_0/Q_m,    S = L + M,    D_m = κ_m + σ_m(in) + σ_m(out),

of which L and M are sums of -ln λ, facing the axis and outwards, and D is the stiffness of node m
with its spring κ_m. Of a surface held at nodes p < q, in units of 2πγ₁, every node between is
displaced by a u_p + b u_q, and the ends feel the stiffness E with the other end at rest, of which
the part C is tied to that end and the rest G to the ground:

    a = e^{M_p-M_m} (1 - e^{S_m-S_q})/(1 - e^{S_p-S_q}),   b = e^{L_m-L_q} (1 - e^{S_p-S_m})/(...),
    E_p = σ_p(out) + D_p/(e^{S_q-S_p} - 1),   E_q = σ_q(in) + D_q/(e^{S_q-S_p} - 1),
    C = D_p e^{L_p-L_q}/(1 - e^{S_p-S_q}),    G = E - C.

Nothing overflows. 1 - a - b and G are differences, by a part of l²/(links Δr)² smaller than their
terms: the tables have the digits of long double where there is one.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e, i1e, k0e, k1e

from discretization.nodes.lattice import Pair

Array = NDArray[Any]
_KNOWN = 1024  # from this node on the expansion is exact to rounding
_AXIS = 0.125  # weight of the node on the axis
_SERIES = 0.3  # of μ, below which its coefficients are taken from their series


@dataclass(frozen=True, eq=False)
class Rings:
    """κ, and σ of the first nodes, outside and inside."""

    kappa: float
    outside: Array
    inside: Array

    def pull(self, nodes: Any, side: int) -> Array:
        """σ of a surface outside (side 1) or inside (-1) of contact nodes."""
        nodes = np.asarray(nodes)
        table = self.outside if side > 0 else self.inside
        found = table.take(np.asarray(nodes, np.int64), mode="clip")
        far = nodes >= _KNOWN
        if far.any():
            found = np.where(far, _far(self.kappa, np.maximum(nodes, _KNOWN), side), found)
        return np.asarray(found)


@functools.lru_cache(maxsize=128)
def rings(kappa: float) -> Rings:
    """The surfaces around the axis on a lattice with this κ > 0."""
    return Rings(kappa, *near(kappa, _KNOWN + 1, float(_far(kappa, np.array(_KNOWN), 1))))


def near(kappa: Any, count: int, farthest: Any) -> tuple[Array, Array]:
    """σ (count,) of the first nodes, outside and inside, with the digits of κ.

    farthest: σ outside of the last of them.
    """
    outside, inside = np.zeros((2, count), np.result_type(kappa))
    outside[-1] = pull = farthest
    for m in range(count - 2, -1, -1):
        pull = _step(m + 0.5, kappa * (m + 1) + pull)
        outside[m] = pull
    pull = 0.0
    for m in range(1, count):
        pull = _step(m - 0.5, kappa * (m - 1 or _AXIS) + pull)
        inside[m] = pull
    return outside, inside


def _step(link: Any, beyond: Any) -> Any:
    """A link and what is beyond it, one after the other."""
    return link * beyond / (link + beyond)


def _far(kappa: float, nodes: Array, side: int) -> Array:
    """σ far out: the expansion one node further on, and a step from there.

    The step damps what the expansion loses to cancellation where l << Δr.
    """
    at = nodes + float(side)
    mu = 2 * math.asinh(math.sqrt(kappa) / 2)
    a, b, bend = _coefficients(mu)
    z = mu * at
    ratio = k1e(z) / k0e(z) if side > 0 else -i1e(z) / i0e(z)
    second = a / at**2
    above = -b - ratio * (at - (bend - b / mu) / at)
    rate = above / (1 + (b + second) * ratio / at) + 4 * b
    sinh = math.sqrt(kappa) * math.sqrt(1 + kappa / 4)
    pull = -side * sinh * rate - (at + side / 2) * kappa / 2
    link = at - side / 2
    return np.asarray(_step(link, kappa * at + np.clip(pull, 0.0, at + side / 2)))


def _coefficients(mu: float) -> tuple[float, float, float]:
    """a, B and B'."""
    if mu < _SERIES:
        square = mu * mu
        b = -mu / 24 * (1 - square / 15 + 2 * square**2 / 315)
        bend = -1 / 24 * (1 - square / 5 + 2 * square**2 / 63)
        return 7 / 960 * mu, b, bend
    sinh, coth = math.sinh(min(mu, 300.0)), 1 / math.tanh(mu)
    psi = (1 / mu**2 - 1 / sinh**2) / 4
    b, bend = (1 / mu - coth) / 8, -psi / 2
    bends = (2 / mu**3 - 2 * coth / sinh**2) / 8
    return (bends - bend / mu + b / mu**2 - psi * b) / 2, b, bend


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
