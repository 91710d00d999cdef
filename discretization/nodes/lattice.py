"""Fixed nodes: the discrete energy and what is exact on the lattice itself.

Nodes x_i = origin + iΔx, a spring kΔx under each, a link of the stretched surface between
neighbours. With t = γ₁/Δx and contact links C (both ends in contact), the nodal energy is

    U[u] = Σ_i kΔx u_i²/2 + Σ_i t (u_{i+1} - u_i)²/2 - w Δx |C|     min over u, s.t. u_i >= g_i.

Free nodes obey t(u_{i-1} - 2u_i + u_{i+1}) = kΔx u_i, so a free tail decays by
λ = exp(-2 asinh(√κ/2)), κ = kΔx²/γ₁, per node, exactly. Eliminating the tail leaves a spring
t(1-λ) on the last node: the half-infinite far field needs no nodes.

Finite slopes: with s = (u_{i+1} - u_i)/Δx a free link has the energy γ₁Δx(√(1+s²) - 1), and on a
contact link wΔx becomes wΔx√(1+s²): plain.py.

Adhesion is counted per link: a lone node has none. With γ₁ = 0 there are no links and the springs
are independent, so it is counted per node, and a contact reaches half a node past its last one.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from energy import Scene, terms
from energy.arrays import Array
from energy.checks import positive

PIECE = 1 << 16  # nodes at a time, few enough for the processor's cache
np.empty((1 << 22) - 1024)  # freed at once: glibc keeps up to twice as much for reuse from now on


def shares(rate: float, p: Any, q: Any) -> tuple[Array, Array, Array]:
    """a, b and 1 - a - b of the free surface u = a left + b right, p from left and q from right.

    a = sinh(rate·q)/sinh(rate·(p+q)), b = sinh(rate·p)/sinh(rate·(p+q)),
    1 - a - b = 2 sinh(rate·p/2) sinh(rate·q/2)/cosh(rate·(p+q)/2);

    p and q may be inf. A tail decays by exp(-rate): μ per link, μ/Δx per length on the lattice.
    """
    ep, eq, both = np.exp(-rate * p), np.exp(-rate * q), np.expm1(-2 * rate * (p + q))
    one, other = np.expm1(-rate * p), np.expm1(-rate * q)  # that of twice as much is x (2 + x)
    near, far = ep * other * (2 + other) / both, eq * one * (2 + one) / both
    return near, far, one * other / (1 + ep * eq)


@dataclass(frozen=True)
class LatticeTail:
    """Free nodes beyond a contact: u decays by exp(-rate) per length, Eq. (6) on the lattice."""

    rate: float

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """u and u' between two contact lines at x, where the profile has the height f; or None.

        [u_left sinh(rate·q) + u_right sinh(rate·p)]/sinh(rate·(p + q)), p from left, q from right.
        """
        p, u = (math.inf, 0.0) if left is None else (z - left.x, depth - left.f)
        q, v = (math.inf, 0.0) if right is None else (right.x - z, depth - right.f)
        near, far, _ = shares(self.rate, p, q)
        once, other = np.exp(-self.rate * p), np.exp(-self.rate * q)
        steep = once * (1 + other * other) * u - other * (1 + once * once) * v
        return near * u + far * v, self.rate * steep / np.expm1(-2 * self.rate * (p + q))


@dataclass(frozen=True)
class Lattice:
    """Spacing Δx, origin, and the scene's k, γ₁, w; everything else follows from these.

    spring: kΔx; link: t; log_decay: -ln λ, by which a free tail decays per node; end_stiffness:
    t(1-λ), what a half-infinite free tail does to its first node; cell: Δx, what a link covers.

    Displacements u, heights f of the profile and depths [length] are numbers or arrays of one
    shape; energies [energy/length] and forces [force/length] per length of the contact line.

    slopes: "finite" if U is of finite slopes; stored: by springs per area, and its derivatives, as
    `Scene.spring`; linear: neither, else only `NodalEnergy` knows the free surfaces.

    A line that advances over a link to the free node beside it, with gap v = A u + B u' - g there,
    changes the re-equilibrated energy by S v²/2 - wΔx, a perfect square, so that the line stops at
    v = √(2wΔx/S), and the force by -S (1 - A - B) v. If nothing is faced B = 0, A = λ, S = t/λ.

    A line contact; its subclass for rotational symmetry (radial.py) answers the same questions of a
    contact around the axis: nodes and links have weights, and a surface depends on its place.
    """

    axis: ClassVar[float] = math.nan
    spacing: float
    origin: float
    k: float
    gamma1: float
    w: float
    slopes: str = "small"
    stored: Any = None
    spring: float = field(init=False)
    link: float = field(init=False)
    log_decay: float = field(init=False)
    end_stiffness: float = field(init=False)
    cell: float = field(init=False)
    linear: bool = field(init=False)

    @classmethod
    def of(cls, scene: Scene, spacing: float, origin: float | None = None) -> Lattice:
        """Lattice for a scene with nodes `spacing` [length] apart, one of them on `origin`.

        By default that is the axis, or the indenter's `apex`, x = 0 where it is not known. Edges of
        a body are nodes, at most that far apart, unless its tip or more of its corners are nodes
        without that. ValueError unless spacing > 0.
        """
        spacing = positive("spacing", spacing)
        if origin is None:
            spacing, origin = _placed(scene, spacing)
        slopes = scene.slopes if scene.gamma1 else "small"
        kinds: list[type[Lattice]] = [Lattice, *Lattice.__subclasses__()]
        kind = next(kind for kind in kinds if (kind.axis == 0) == scene.axisymmetric)
        scales = scene.stiffness, scene.gamma1, scene.work_of_adhesion
        return kind(spacing, origin, *scales, slopes, scene.spring)

    def __post_init__(self) -> None:
        dx, k, gamma1 = self.spacing, self.k, self.gamma1
        spring, link = k * dx, gamma1 / dx
        log_decay = 2 * math.asinh(math.sqrt(spring / link) / 2) if link else math.inf
        vars(self).update(spring=spring, link=link, cell=dx, log_decay=log_decay)
        vars(self).update(end_stiffness=-link * math.expm1(-log_decay))
        vars(self).update(stored=self.stored or functools.partial(terms.spring, k=k))
        hookean = self.stored(np.zeros(2)).quadratic
        vars(self).update(linear=self.slopes == "small" and hookean)

    def seen(self, scene: Scene) -> Scene:
        """The scene as far as it has nodes."""
        return scene

    def weight(self, at: Any) -> Any:
        """Weights of nodes, or of links by their middles: 1."""
        return 1.0

    def sizes(self, first: float, count: int, unit: float = 1.0) -> Array:
        """Of nodes from the first on (n,), or links by their middles: length or area times unit."""
        if self.axis == 0:
            return np.asarray(unit * self.cell * self.weight(first + np.arange(count)))
        return np.ndarray(count, buffer=np.float64(unit * self.cell).tobytes(), strides=(0,))

    def pull(self, nodes: Any, side: int) -> Any:
        """Force of tails beyond these nodes on them over u, their springs' own being the same."""
        return self.pair(math.inf, nodes, side)[1]

    def pair(self, links: Any, node: Any = 0, side: Any = 1) -> tuple[Any, Any]:
        """tB and t(1 - A - B) of a free surface of so many links between two contact nodes.

        It pulls at an end displaced by u, the other one by u', with tB (u - u') + t(1 - A - B) u.
        Where the weights depend on the place, the surface is that on one side of this node.
        """
        if isinstance(links, float) and links == math.inf:
            return 0.0, self.end_stiffness
        _, far, remainder = shares(self.log_decay, 1.0, links - 1.0)
        return self.link * far, self.link * remainder

    def beside(self, node: Any, side: Any, apart: Any = math.inf) -> tuple[Any, Any, Any]:
        """B, 1 - A - B and S of the free node next to lines at these nodes.

        apart: how many links from there the line is that they face, if any.
        """
        after = node + side
        tie, ground = self.pair(apart - 1.0, after, side)
        spring, link = self.spring * self.weight(after), self.link * self.weight(node + side / 2)
        whole = spring + link + tie + ground
        return tie / whole, (spring + ground) / whole, whole

    @property
    def deepest_contact(self) -> float:
        """D [length]: contact deeper below the surface without adhesion never pays.

        Let v be the drop below that surface, largest in contact node j, and replace it by the free
        span between v_{j-r} and v_{j+r} where that is lower. This loses at most the 2r links there
        and gains at least t sinh μ coth μr (v_j - s)², s <= v_j/cosh μr the span at j. With r next
        to 2.4/μ both are equal at v_j = 1.88 δ₀ at most, whatever μ. For line contacts.
        """
        return 1.9 * math.sqrt(2 * self.w / self.k)

    @property
    def edge(self) -> float:
        """How far, in nodes, a contact reaches beyond its last node."""
        return 0.0 if self.gamma1 else 0.5

    @property
    def tail(self) -> LatticeTail:
        """The free surface beyond a contact line."""
        return LatticeTail(self.log_decay / self.spacing)

    def x(self, node: Any) -> Any:
        """Position of a node (or an array of nodes)."""
        return self.origin + self.spacing * node


def _placed(scene: Scene, spacing: float) -> tuple[float, float]:
    """Spacing and origin; see `Lattice.of`. Without tension, edges are where cells of nodes end."""
    body, cells = scene.indenter, 0 if scene.gamma1 else 1
    (lo, hi), tip = body.extent, 0.0 if body.apex is None or scene.axisymmetric else body.apex
    if len(body.walls) < 2 or spacing > hi - lo:
        return spacing, tip
    closer = (hi - lo) / (cells + 2 * math.ceil(((hi - lo) / spacing - cells) / 2 - 1e-9))
    first = 0.0 if scene.axisymmetric else lo + cells * closer / 2

    def on_nodes(chosen: tuple[float, float]) -> tuple[bool, int]:
        off = (np.append(tip, body.corners) - chosen[1]) / chosen[0]
        off[1:] -= cells / 2
        on = np.abs(off - np.rint(off)) < 1e-9
        return bool(on[0]) or tip not in body.corners, int(on[1:].sum())

    return max((closer, first), (spacing, tip), key=on_nodes)
