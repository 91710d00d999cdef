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

Conventions
-----------
Nodes are numbered outwards from the axis, node m at r = mΔr; link m is between m and m + 1, with
its middle at r_{m+½}. u is positive down into the layer, and the outer surface of contact node m
pulls it up with 2πγ₁ σ_m u_m [force], u > 0; the energy of that surface is 2πγ₁ σ_m u_m²/2.
DECAYED is 40: after so many decay lengths what is left, e⁻⁴⁰ = 4e-18, is less than rounding.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import DECAYED
from energy.arrays import Array


class OuterSurface(NamedTuple):
    """How the stiffness of the surface outside is computed.

    Halved or doubled, each leaves the 2 or more random states and paths that read it as they are to
    1e-9: `python -m tests.sensitivity discretization.nodes.radial`.

    Attributes
    ----------
    kept : int
        Nodes of which it is kept, by the recursion; that of nodes further out is found by the
        integrals.
    fewest_steps : int
        Steps in t of the integrals at least.
    steps_per_unit : int
        Steps per unit of t; with these the error is rounding.
    """

    kept: int = 1 << 14
    fewest_steps: int = 16
    steps_per_unit: int = 4


_OUTER = OuterSurface()


def outer_pull(kappa: float, nodes: Any) -> Array:
    """σ of the surface outside of contact nodes.

    Parameters
    ----------
    kappa : float
        κ = kΔr²/γ₁, > 0.
    nodes : int or ndarray
        m.

    Returns
    -------
    ndarray
        In units of 2πγ₁.
    """
    nodes = np.asarray(nodes)
    # Nodes outside of those that are kept take the outermost; it is replaced below.
    found = _near(kappa).take(np.asarray(nodes, np.int64), mode="clip")
    far = nodes > _OUTER.kept
    if far.any():
        found = np.where(far, _far(kappa, np.maximum(nodes, _OUTER.kept)), found)
    return np.asarray(found)


@functools.lru_cache(maxsize=128)  # of so many spacings: 131 kB each, 17 MB together
def _near(kappa: float) -> Array:
    """σ of the nodes 0 to `kept`, in this order, by the recursion from the last of them inwards."""
    found = np.empty(_OUTER.kept + 1)
    pull = float(_far(kappa, np.array(_OUTER.kept)))
    found[-1] = pull
    for m in range(_OUTER.kept - 1, -1, -1):
        beyond = kappa * (m + 1) + pull
        pull = (m + 0.5) * beyond / (m + 0.5 + beyond)
        found[m] = pull
    return found


def _far(kappa: float, nodes: Array) -> Array:
    """σ of nodes by the integrals, which are cut off where z^(-m-½) is e⁻⁴⁰ of what it is at t = 0.

    All in terms of z - 1, which keeps its digits where κ is small; powers of z are over that at
    t = 0, so that none underflows. cosh μ = 1 + κ/2.
    """
    m = nodes[..., None] + 0.5
    sinh = math.sqrt(kappa * (1 + kappa / 4))  # sinh μ
    start = kappa / 2 + sinh  # z - 1 at t = 0
    reach = np.arccosh(1 + np.expm1(DECAYED / m) * (1 + start) / sinh)  # t there
    steps = max(_OUTER.fewest_steps, math.ceil(_OUTER.steps_per_unit * float(reach.max())))
    t = reach * np.linspace(0, 1, steps + 1)
    rise = start + sinh * (np.cosh(t) - 1)  # z - 1
    weight = np.exp(m * (math.log1p(start) - np.log1p(rise)))
    weight[..., 0] /= 2  # trapezoidal rule
    numerator = (weight * rise / (1 + rise)).sum(axis=-1)
    denominator = weight.sum(axis=-1)
    return np.asarray(m[..., 0] * numerator / denominator)
