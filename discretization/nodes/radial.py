"""Rotational symmetry on nodes r_i = iΔr: node areas, link weights, and the surface outside.

    U[u] = Σ_i kA_i u_i²/2 + Σ_m t_m (u_{m+1} - u_m)²/2 - w Σ_{m in C} 2πr_{m+½}Δr,   u_i >= g_i,

A_0 = π(Δr/2)², A_i = 2πr_iΔr, t_m = 2πγ₁r_{m+½}/Δr. Nodes and links are those of a line contact
times a weight, i of node i (1/8 on the axis) and m + ½ of link m. Known is one contact around the
axis. From end node m to m + 1, with the outer surface in equilibrium before and after,

    ΔE = t_m/(2λ_m) (λ_m g_m - g_{m+1})² - w 2πr_{m+½}Δr,

a square again, so that the line stops at λ_m g_m - g_{m+1} = Δr√(2wλ_m/γ₁): the rule of the line
contact with the decay λ_m of the place for λ.

Of a convex profile pressed by d >= f(0) the gap grows outwards as in a line contact: for l << Δr it
is that of f alone, and for Δr << l the line rests where l f' + (f - d)/q = δ₀, q = K₀/K₁ at
s = a/l, whose left side grows by l f'' + f'/q - (f - d) q'/q² >= f' (1 - s q'/q)/q >= 0 over s, in
units of l, as f - d <= a f' and s q'/q = 1 - s (1/q - q).

The outer surface, in units of 2πγ₁ and with κ = kΔr²/γ₁, pulls at node m with σ_m u_m, the spring
there not counted. Node by node, of positive numbers alone, so that errors shrink at every step,

    σ_m = (m + ½) s/(m + ½ + s),   s = κ(m + 1) + σ_{m+1}.

It begins far out: u_m, the Legendre function Q_{m-½}(cosh μ), κ = 4 sinh²(μ/2), is, over t > 0,

    u_m = ∫ z^(-m-½) dt,   σ_m u_m = (m + ½) ∫ (1 - 1/z) z^(-m-½) dt,   z = cosh μ + sinh μ cosh t,

whose sums over equidistant t converge exponentially (NIST DLMF 14.12.6).
"""

import functools
import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import scipy

from discretization.nodes.lattice import Lattice, LatticeTail
from energy import Scene
from energy.arrays import Array
from energy.axis import Radial

_AXIS = 1 / 8  # weight of the node on the axis
_KNOWN = 1 << 14  # nodes that are kept; those further out take the integrals
_NEGLIGIBLE = 40.0  # exponent beyond which the integrands are left out
_FEWEST, _DENSE = 16, 4  # steps in t: at least, and per unit of t


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

    @property
    def tail(self) -> LatticeTail:
        return RadialTail(self.log_decay / self.spacing)

    def seen(self, scene: Scene) -> Scene:
        """The scene with r >= 0 only, as if it were a line contact that ends at the axis."""
        return replace(scene, indenter=Radial(scene.indenter), geometry="line")

    def weight(self, at: Any) -> Any:
        return np.where(np.asarray(at) > 0, at, _AXIS)

    def pair(self, links: Any, node: Any = 0, side: Any = 1) -> tuple[Any, Any]:
        """Of the surface outside; there is none on the side of the axis."""
        if not self.gamma1:
            return 0.0, np.zeros(np.shape(node))
        return 0.0, np.where(side < 0, 0.0, self.link * outer_pull(self.spring / self.link, node))


@dataclass(frozen=True)
class RadialTail(LatticeTail):
    """The free surface outside a contact as a function of r, in between the nodes, too."""

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """u_a K₀(r/l)/K₀(a/l) and its slope outside a line; nothing inside, on the axis."""
        if left is None:
            return np.zeros_like(z), np.zeros_like(z)
        r, a = self.rate * z, self.rate * left.x
        u = (depth - left.f) * np.exp(a - r) / scipy.special.k0e(a)
        return u * scipy.special.k0e(r), -self.rate * u * scipy.special.k1e(r)


def outer_pull(kappa: float, nodes: Any) -> Array:
    """σ of the surface outside of contact nodes, κ > 0."""
    nodes = np.asarray(nodes)
    found = _near(kappa).take(np.asarray(nodes, np.int64), mode="clip")
    far = nodes > _KNOWN
    if far.any():
        found = np.where(far, _far(kappa, np.maximum(nodes, _KNOWN)), found)
    return np.asarray(found)


@functools.lru_cache(maxsize=128)
def _near(kappa: float) -> Array:
    """σ of the first nodes."""
    found = np.empty(_KNOWN + 1)
    found[-1] = pull = float(_far(kappa, np.array(_KNOWN)))
    for m in range(_KNOWN - 1, -1, -1):
        beyond = kappa * (m + 1) + pull
        found[m] = pull = (m + 0.5) * beyond / (m + 0.5 + beyond)
    return found


def _far(kappa: float, nodes: Array) -> Array:
    """σ by the integrals; both fall off like exp(-(m + ½) sinh μ cosh t / cosh μ) or faster."""
    m, sinh = nodes[..., None] + 0.5, math.sqrt(kappa * (1 + kappa / 4))
    least = kappa / 2 + sinh  # z - 1 at t = 0
    reach = np.arccosh(1 + np.expm1(_NEGLIGIBLE / m) * (1 + least) / sinh)
    steps = max(_FEWEST, math.ceil(_DENSE * float(reach.max())))
    rise = least + sinh * (np.cosh(reach * np.linspace(0, 1, steps + 1)) - 1)
    weight = np.exp(m * (math.log1p(least) - np.log1p(rise)))
    weight[..., 0] /= 2
    return np.asarray(m[..., 0] * (weight * rise / (1 + rise)).sum(-1) / weight.sum(-1))
