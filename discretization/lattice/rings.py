"""Free surfaces on nodes r_i = iΔr around the axis: what they pull at their contact node.

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
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e, i1e, k0e, k1e

Array = NDArray[np.float64]
_KNOWN = 1024  # from this node on the expansion is exact to rounding
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
        pull = _step(m - 0.5, kappa * (m - 1 or 0.125) + pull)
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
