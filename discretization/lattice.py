"""Fixed nodes: the discrete energy and what is exact on the lattice itself.

Nodes x_i = origin + iΔx, a spring kΔx under each, a link of the stretched surface between
neighbours. With t = γ₁/Δx and contact links C (both ends in contact), the nodal energy is

    U[u] = Σ_i kΔx u_i²/2 + Σ_i t (u_{i+1} - u_i)²/2 - w Δx |C|     min over u, s.t. u_i >= g_i.

Free nodes obey t(u_{i-1} - 2u_i + u_{i+1}) = kΔx u_i, so a free tail decays by
λ = exp(-2 asinh(√κ/2)), κ = kΔx²/γ₁, per node, exactly. Eliminating the tail leaves a spring
t(1-λ) on the last node: the half-infinite far field needs no nodes.

Adhesion is counted per link: a lone node has none. With γ₁ = 0 there are no links and the springs
are independent, so it is counted per node, and a contact reaches half a node past its last one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solveh_banded

from energy import Indenter, Scene, terms
from energy.checks import positive

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lattice:
    """Spacing Δx, origin, and the scene's k, γ₁, w; everything else follows from these."""

    spacing: float
    origin: float
    k: float
    gamma1: float
    w: float
    spring: float = field(init=False)
    link: float = field(init=False)
    log_decay: float = field(init=False)
    link_over_decay: float = field(init=False)

    @classmethod
    def of(cls, scene: Scene, spacing: float, origin: float | None = None) -> Lattice:
        """Lattice for a scene with a node on `origin`.

        By default that is the indenter's lowest point, which may be a tip; a body between two
        edges is centred, so that the outermost nodes are at most Δx/2 inside them.
        """
        positive("spacing", spacing)
        if origin is None:
            origin = _origin(scene.indenter, spacing)
        return cls(spacing, origin, scene.stiffness, scene.gamma1, scene.work_of_adhesion)

    def __post_init__(self) -> None:
        dx, k, gamma1 = self.spacing, self.k, self.gamma1
        spring, link = k * dx, gamma1 / dx
        half = spring / 2
        derived = {
            "spring": spring,
            "link": link,
            "log_decay": 2 * math.asinh(math.sqrt(spring / link) / 2) if link else math.inf,
            # t/λ without dividing by a λ that may underflow or vanish
            "link_over_decay": link + half + math.sqrt(half) * math.sqrt(half + 2 * link),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @property
    def decay(self) -> float:
        """λ, the factor by which a free tail decays per node."""
        return math.exp(-self.log_decay)

    @property
    def loss(self) -> float:
        """1 - λ without cancellation."""
        return -math.expm1(-self.log_decay)

    @property
    def end_stiffness(self) -> float:
        """t(1-λ): what a half-infinite free tail does to its first node."""
        return self.link * self.loss

    @property
    def tail_force(self) -> float:
        """Σ_{j>=1} kΔx λʲ: force of a tail's springs per displacement of its first node."""
        return self.spring * self.decay / self.loss

    @property
    def critical_gap(self) -> float:
        """Gap at the first free node beyond which the line does not advance: Δx√(2wλ/γ₁).

        Root of `advance_cost`; for independent springs it is δ₀.
        """
        return math.sqrt(2 * self.w * self.spacing / self.link_over_decay)

    @property
    def edge(self) -> float:
        """How far, in nodes, a contact reaches beyond its last node."""
        return 0.0 if self.gamma1 else 0.5

    def advance_cost(self, gap):
        """Energy by which a line's advance over one link changes the re-equilibrated energy.

        From end node m to m+1, with the tail re-equilibrated before and after,

            ΔE = kΔx g'²/2 + t(g'-g)²/2 + t(1-λ)(g'² - g²)/2 - wΔx = t/(2λ) (λg - g')² - wΔx,

        g = g_m, g' = g_{m+1}; `gap` = λg - g' is what the free node m+1 is away from contact.
        """
        return self.link_over_decay / 2 * gap * gap - self.w * self.spacing

    def x(self, node):
        """Position of a node (or an array of nodes)."""
        return self.origin + self.spacing * node


def _origin(indenter: Indenter, spacing: float) -> float:
    lo, hi = indenter.extent
    if len(indenter.walls) == len(indenter.corners) == 2:
        links = math.floor((hi - lo) / spacing + 1e-9)
        return lo + max(0.0, (hi - lo) - links * spacing) / 2
    return 0.0 if indenter.apex is None else indenter.apex


class NodalEnergy:
    """The energy of n nodes in a row, with exact tails beyond both ends, as a function of u.

    contact: (n,) bool, the nodes held to be in contact (they carry the adhesion).
    """

    def __init__(self, lattice: Lattice, contact: ArrayLike) -> None:
        self.lattice = lattice
        self.contact = np.asarray(contact, bool)

    def terms(self, u: ArrayLike) -> dict[str, float]:
        """Value of each term [energy/length] at displacements u (n,)."""
        lat, u = self.lattice, np.asarray(u, float)
        dx = lat.spacing
        links = int(np.count_nonzero(self.contact[1:] & self.contact[:-1]))
        nodes = int(np.count_nonzero(self.contact))
        adhesive = links if lat.gamma1 else nodes
        strain = np.diff(u) / dx
        return {
            "springs": dx * float(terms.spring(u, k=lat.k).value.sum()),
            "surface": dx * float(terms.surface(strain, gamma1=lat.gamma1).value.sum()),
            "adhesion": -lat.w * dx * adhesive,
            "tails": lat.end_stiffness / 2 * float(u[0] ** 2 + u[-1] ** 2),
        }

    def value(self, u: ArrayLike) -> float:
        """U[u] [energy/length]."""
        return sum(self.terms(u).values())

    def gradient(self, u: ArrayLike) -> Array:
        """∂U/∂u_i (n,) at fixed contact: nodal forces; on contact nodes the indenter's."""
        lat, u = self.lattice, np.asarray(u, float)
        tension = terms.surface(np.diff(u) / lat.spacing, gamma1=lat.gamma1).first
        force = lat.spacing * terms.spring(u, k=lat.k).first
        force[:-1] -= tension
        force[1:] += tension
        force[0] += lat.end_stiffness * u[0]
        force[-1] += lat.end_stiffness * u[-1]
        return force

    def hessian(self) -> Array:
        """∂²U/∂u_i∂u_j in lower banded form (2, n): diagonal, then sub-diagonal."""
        lat, n = self.lattice, self.contact.size
        band = np.empty((2, n))
        band[0] = lat.spring + 2 * lat.link
        band[1] = -lat.link
        band[0, [0, -1]] += lat.end_stiffness - lat.link
        if n == 1:
            band[0, 0] = lat.spring + 2 * lat.end_stiffness
        return band

    def relaxed(self, g: ArrayLike) -> Array:
        """argmin U[u] s.t. u_i = g_i on the contact nodes: one banded Cholesky solve.

        Plain elimination: it loses digits as l/Δx grows (1e-4 relative at 1e6). It is the
        independent check of the exact tails, not what the minimisers run on.
        """
        held, u = self.contact, np.where(self.contact, g, 0.0)
        rhs = np.where(held, u, -self.gradient(u))
        band = self.hessian()
        band[0, held] = 1
        band[1, :-1][held[1:] | held[:-1]] = 0
        return np.asarray(solveh_banded(band, rhs, lower=True))
