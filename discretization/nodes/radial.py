"""Rotational symmetry on nodes r_i = iΔr: node areas, link weights, and the surface outside.

    U[u] = Σ_i kA_i u_i²/2 + Σ_m t_m (u_{m+1} - u_m)²/2 - w Σ_{m in C} 2πr_{m+½}Δr,   u_i >= g_i,

A_0 = π(Δr/2)², A_i = 2πr_iΔr, t_m = 2πγ₁r_{m+½}/Δr. Nodes and links are those of a line contact
times a weight, i of node i (1/8 on the axis) and m + ½ of link m. Known is one contact around the
axis, with the free surface outside. From end node m to m + 1, with the outer surface
re-equilibrated before and after,

    ΔE = t_m/(2λ_m) (λ_m g_m - g_{m+1})² - w 2πr_{m+½}Δr,

a square again, so that the line stops at λ_m g_m - g_{m+1} = Δr√(2wλ_m/γ₁): the rule of the line
contact with the decay λ_m of the place for λ.

Of a convex profile pressed by d >= f(0) the gap grows outwards as in a line contact: for l << Δr it
is that of f alone, and for Δr << l the line rests where l f' + (f - d)/q = δ₀, q = K₀/K₁ at
s = a/l, whose left side grows by l f'' + f'/q - (f - d) q'/q² >= f' (1 - s q'/q)/q >= 0 over s, in
units of l, as f - d <= a f' and s q'/q = 1 - s (1/q - q).

The outer surface, in units of 2πγ₁ and with κ = kΔr²/γ₁, pulls at node m with σ_m u_m, the spring
there not counted. Node by node, with positive numbers only and an error that every step makes
smaller,

    σ_m = (m + ½) s/(m + ½ + s),   s = κ(m + 1) + σ_{m+1}.

Far out, σ is known without the nodes between: u_m is the Legendre function Q_{m-½}(cosh μ),
κ = 4 sinh²(μ/2), and with y = d ln u_m/dμ

    σ_m = -y sinh μ - (m + ½) κ/2.

y follows from √sinh μ u_m = √μ [K₀(mμ) A + K₁(mμ) B/m] (Olver, Asymptotics and Special Functions,
chapter 12), whose coefficients obey, ψ = (1/μ² - 1/sinh² μ)/4,

    2B' = A'' + A'/μ - ψA,    2m²A' = B'' - B'/μ + B/μ² - ψB:    A = 1, 8B = 1/μ - coth μ,

but for O(m⁻²). Of that A' = a/m² and the same of B are kept, a = 7μ/960 where mμ is not large; for
large mμ the latter does not matter.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import k0e, k1e

from discretization.nodes.lattice import Lattice, LatticeTail
from energy import Scene
from energy.axis import Radial

Array = NDArray[Any]
_AXIS = 1 / 8  # weight of the node on the axis
_KNOWN = 1024  # from this node on the expansion is exact to rounding
_SERIES = 0.3  # of μ, below which its coefficients are taken from their series


@dataclass(frozen=True)
class RadialLattice(Lattice):
    """The constants of `Lattice` for weight 1: spring 2πkΔr², link 2πγ₁, cell 2πΔr²."""

    axis: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.origin:
            raise ValueError(f"origin = {self.origin!r}: with rotational symmetry it is the axis")
        cell, link = 2 * math.pi * self.spacing**2, 2 * math.pi * self.gamma1
        vars(self).update(cell=cell, spring=self.k * cell, link=link)
        vars(self).update(link_over_decay=link or self.spring)

    @property
    def tail(self) -> LatticeTail:
        return RadialTail(self.log_decay / self.spacing)

    def seen(self, scene: Scene) -> Scene:
        """The scene with r >= 0 only, as if it were a line contact that ends at the axis."""
        return replace(scene, indenter=Radial(scene.indenter), geometry="line")

    def weight(self, at: Any) -> Any:
        return np.where(np.asarray(at) > 0, at, _AXIS)

    def pull(self, nodes: Any, side: int) -> Any:
        """Of the surface outside; there is none on the side of the axis."""
        if side < 0 or not self.gamma1:
            return np.zeros(np.shape(nodes))
        return self.link * outer_pull(self.spring / self.link, nodes)


@dataclass(frozen=True)
class RadialTail(LatticeTail):
    """The free surface outside a contact as a function of r, in between the nodes, too."""

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """u_a K₀(r/l)/K₀(a/l) and its slope outside a line; nothing inside, on the axis."""
        if left is None:
            return np.zeros_like(z), np.zeros_like(z)
        r, a = self.rate * z, self.rate * left.x
        u = (depth - left.f) * np.exp(a - r) / k0e(a)
        return u * k0e(r), -self.rate * u * k1e(r)


def outer_pull(kappa: float, nodes: Any) -> Array:
    """σ of the surface outside of contact nodes, κ > 0."""
    nodes = np.asarray(nodes)
    found = _near(kappa).take(np.asarray(nodes, np.int64), mode="clip")
    far = nodes >= _KNOWN
    if far.any():
        found = np.where(far, _far(kappa, np.maximum(nodes, _KNOWN)), found)
    return np.asarray(found)


@functools.lru_cache(maxsize=128)
def _near(kappa: float) -> Array:
    """σ of the first nodes."""
    found = np.empty(_KNOWN + 1)
    found[-1] = pull = float(_far(kappa, np.array(_KNOWN)))
    for m in range(_KNOWN - 1, -1, -1):
        found[m] = pull = _step(m + 0.5, kappa * (m + 1) + pull)
    return found


def _step(link: Any, beyond: Any) -> Any:
    """A link and what is beyond it, one after the other."""
    return link * beyond / (link + beyond)


def _far(kappa: float, nodes: Array) -> Array:
    """σ far out: the expansion one node further on, and a step from there.

    The step damps what the expansion loses to cancellation where l << Δr.
    """
    at = nodes + 1.0
    mu = 2 * math.asinh(math.sqrt(kappa) / 2)
    a, b, bend = _coefficients(mu)
    z = mu * at
    ratio = k1e(z) / k0e(z)
    above = -b - ratio * (at - (bend - b / mu) / at)
    rate = above / (1 + (b + a / at**2) * ratio / at) + 4 * b
    sinh = math.sqrt(kappa) * math.sqrt(1 + kappa / 4)
    pull = -sinh * rate - (at + 0.5) * kappa / 2
    return np.asarray(_step(at - 0.5, kappa * at + np.clip(pull, 0.0, at + 0.5)))


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
