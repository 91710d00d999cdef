"""Rotational symmetry on nodes r_i = iΔr: node areas, link weights and ratios λ_m.

    U[u] = Σ_i kA_i u_i²/2 + Σ_m t_m (u_{m+1} - u_m)²/2 - w Σ_{m in C} 2πr_{m+½}Δr,   u_i >= g_i,

A_0 = π(Δr/2)², A_i = 2πr_iΔr, t_m = 2πγ₁r_{m+½}/Δr. Nodes and links are those of a line contact
times a weight, i of node i (1/8 on the axis) and m + ½ of link m; but free surfaces decay by a
ratio λ_m that depends on the place (radial_spans.py). From end node m to m + 1, with the outer
surface re-equilibrated before and after,

    ΔE = t_m/(2λ_m) (λ_m g_m - g_{m+1})² - w 2πr_{m+½}Δr,

a square again, so that the line stops at λ_m g_m - g_{m+1} = Δr√(2wλ_m/γ₁): the rule of the line
contact with λ_m for λ. A line that faces the axis moves by the same rule with m - 1 for m + 1.

Of a convex profile pressed by d >= f(0) the gap grows outwards as in a line contact: for l << Δr it
is that of f alone, and for Δr << l the line rests where l f' + (f - d)/q = δ₀, q = K₀/K₁ at
s = a/l, whose left side grows by l f'' + f'/q - (f - d) q'/q² >= f' (1 - s q'/q)/q >= 0 over s, in
units of l, as f - d <= a f' and s q'/q = 1 - s (1/q - q).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e, i1e, k0e, k1e

from discretization.nodes.lattice import Lattice, LatticeTail, Pair
from discretization.nodes.radial_spans import Rings, RingSpans, ring_spans, rings
from energy import Scene
from energy.axis import Radial

Array = NDArray[Any]
_AXIS = 1 / 8  # weight of the node on the axis
_FEWEST = 256  # nodes of a table of free surfaces


@dataclass(frozen=True)
class RadialLattice(Lattice):
    """The constants of `Lattice` for weight 1: spring 2πkΔr², link 2πγ₁, cell 2πΔr²."""

    axis: ClassVar[float] = 0.0

    @classmethod
    def describes(cls, scene: Scene) -> bool:
        return scene.axisymmetric and (scene.slopes == "small" or not scene.gamma1)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.origin:
            raise ValueError(f"origin = {self.origin!r}: with rotational symmetry it is the axis")
        cell, link = 2 * math.pi * self.spacing**2, 2 * math.pi * self.gamma1
        vars(self).update(cell=cell, spring=self.k * cell, link=link)
        vars(self).update(link_over_decay=link or self.spring)

    @property
    def surfaces(self) -> Rings:
        """What free surfaces pull with."""
        return rings(self.spring / self.link)

    @property
    def tail(self) -> LatticeTail:
        return RadialTail(self.log_decay / self.spacing)

    def seen(self, scene: Scene) -> Scene:
        """The scene with r >= 0 only, as if it were a line contact that ends at the axis."""
        return replace(scene, indenter=Radial(scene.indenter), geometry="line")

    def on_nodes(self, values: Any, nodes: Any) -> Any:
        return values * _weights(nodes)

    def per_weight(self, values: Any, nodes: Any) -> Any:
        return values / _weights(nodes)

    def on_links(self, values: Any, nodes: Any) -> Any:
        nodes = np.asarray(nodes, float)
        return values * ((nodes[1:] + nodes[:-1]) / 2)

    def bound(self, first: Any, last: Any) -> Any:
        return np.abs(last - first) * (last + first) / 2

    def pull(self, nodes: Any, side: int) -> Any:
        return self.link * self.surfaces.pull(nodes, side) if self.gamma1 else 0.0

    def pair(self, left: Any, right: Any) -> Pair:
        parts = self._rings(right).pair(left, right)
        return Pair(*(self.link * part for part in parts))

    def shape(self, left: Any, right: Any, nodes: Any) -> tuple[Array, Array, Array]:
        return self._rings(np.max(nodes) if right is None else right).shape(left, right, nodes)

    def _rings(self, last: Any) -> RingSpans:
        """Tables of so many nodes, in steps, so that few are made."""
        count = max(_FEWEST, 1 << int(np.max(last, initial=1)).bit_length())
        return ring_spans(self.spring / self.link, count)

    def beyond(self, node: int, side: int, steps: Array, u: float) -> Array:
        """Node by node from the line outwards."""
        decay = 1 - self.beside(node + side * np.arange(float(steps[-1])), side).rest
        return np.asarray(u * np.concatenate([[1.0], np.cumprod(decay)])[np.asarray(steps, int)])


@dataclass(frozen=True)
class RadialTail(LatticeTail):
    """Free surfaces around the axis as functions of r, in between the nodes, too.

    K₀ outside, I₀ inside; rate: as far from the axis.
    """

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """In a ring the parts of K₀ and I₀ each that are 1 at one line and 0 at the other."""
        r = self.rate * z
        if left is None and not right.x:
            return np.zeros_like(z), np.zeros_like(z)
        if left is None or right is None:
            line, side = (left, 1) if right is None else (right, -1)
            zero, one, a = *((k0e, k1e) if side > 0 else (i0e, i1e)), self.rate * line.x
            u = (depth - line.f) * np.exp(side * (a - r)) / zero(a)
            return u * zero(r), -side * self.rate * u * one(r)
        q, p = self.rate * left.x, self.rate * right.x
        near = np.exp(q - r) / _parted(q, p) * (depth - left.f)
        far = np.exp(r - p) / _parted(q, p) * (depth - right.f)
        steep = far * _bent(r, q) - near * _bent(r, p)
        return near * _parted(r, p) + far * _parted(q, r), self.rate * steep


def _parted(s: Any, t: Any) -> Array:
    """e^{s-t} (K₀(s) I₀(t) - I₀(s) K₀(t)), s <= t."""
    return np.asarray(k0e(s) * i0e(t) - i0e(s) * k0e(t) * np.exp(-2 * (t - s)))


def _bent(s: Any, t: Any) -> Array:
    """e^{-|s-t|} (K₁(s) I₀(t) + I₁(s) K₀(t))."""
    outer, inner = np.exp(-2 * np.maximum(s - t, 0.0)), np.exp(-2 * np.maximum(t - s, 0.0))
    return np.asarray(k1e(s) * i0e(t) * outer + i1e(s) * k0e(t) * inner)


def _weights(nodes: Any) -> Array:
    """Weights of nodes."""
    nodes = np.asarray(nodes, float)
    return np.where(nodes > 0, nodes, _AXIS)
