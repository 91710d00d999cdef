"""The lattice's energy as a function of all displacements: what the shortcuts are checked by."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solveh_banded

from discretization.certificate import NotCertifiedError
from discretization.lattice.nodes import Lattice
from energy import terms

Array = NDArray[np.float64]
_NEWTON = 60  # steps of Newton's method; ten do up to 80°
_ROUNDING = 1e-14  # of the energy, and of u: steps that change less are the last
_SETTLED = 5  # steps that do not lower the energy are the last, too


class NodalEnergy:
    """The energy of n nodes in a row, with exact tails beyond both ends, as a function of u.

    contact: (n,) bool, the nodes held to be in contact (they carry the adhesion); first: the
    lattice's number of the first node; adhesion (n - 1,): of each link, unless it is w everywhere.
    """

    def __init__(
        self,
        lattice: Lattice,
        contact: ArrayLike,
        first: int = 0,
        adhesion: ArrayLike | None = None,
    ) -> None:
        self.lattice = lattice
        self.contact = np.asarray(contact, bool)
        self.nodes = first + np.arange(self.contact.size)
        ends = (first, -1), (int(self.nodes[-1]), 1)
        self.pulls = np.array([float(lattice.pull(*end)) for end in ends])  # of the tails, over u
        self.bound = self.contact[1:] & self.contact[:-1]
        if adhesion is None:
            adhesion = lattice.on_links(
                np.full(self.bound.size, lattice.w * lattice.cell), self.nodes
            )
        self.adhesion = np.asarray(adhesion, float)

    def terms(self, u: ArrayLike) -> dict[str, float]:
        """Value of each term [energy/length] at displacements u (n,)."""
        lat, u = self.lattice, np.asarray(u, float)
        cell, steps, nodes = lat.cell, np.diff(u), self.nodes
        free = terms.surface(steps / lat.spacing, gamma1=lat.gamma1, slopes=lat.slopes).value
        bonds = self.adhesion
        if lat.slopes == "finite":
            bonds = bonds * np.hypot(1, steps / lat.spacing)
        adhesive = float(bonds @ self.bound)
        if not lat.gamma1:
            adhesive = lat.w * cell * float(np.sum(lat.on_nodes(self.contact * 1.0, nodes)))
        stored = lat.on_nodes(terms.spring(u, k=lat.k).value, nodes)
        return {
            "springs": cell * float(stored.sum()),
            "surface": cell * float(lat.on_links(free, nodes).sum()),
            "adhesion": -adhesive,
            "tails": float(self.pulls @ u[[0, -1]] ** 2) / 2,
        }

    def value(self, u: ArrayLike) -> float:
        """U[u] [energy/length]."""
        return sum(self.terms(u).values())

    def gradient(self, u: ArrayLike) -> Array:
        """∂U/∂u_i [force/length] (n,) at fixed contact: on contact nodes the indenter's force."""
        lat, u = self.lattice, np.asarray(u, float)
        tension, tails = self._links(u)[0], self.pulls * u[[0, -1]]
        force = lat.cell * lat.on_nodes(terms.spring(u, k=lat.k).first, self.nodes)
        force[:-1] -= tension
        force[1:] += tension
        force[0] += tails[0]
        force[-1] += tails[1]
        return force

    def springs(self, u: Array) -> Array:
        """Forces of the springs (n + 2,) [force/length], all those of either tail as one."""
        own = self.lattice.spring * self.lattice.on_nodes(u, self.nodes)
        return np.concatenate([own, self.pulls * u[[0, -1]]])

    def tension(self, u: Array) -> Array:
        """Vertical force of each link (n - 1,)."""
        return self._links(u)[0]

    def hessian(self, u: ArrayLike = 0.0) -> Array:
        """∂²U/∂u_i∂u_j [force/length²] at u, lower banded (2, n): diagonal, then sub-diagonal.

        For small slopes it is the same at every u.
        """
        lat, u = self.lattice, np.broadcast_to(np.asarray(u, float), self.contact.shape)
        stiffness = self._links(u)[1]
        band = lat.on_nodes(np.full((2, u.size), lat.spring), self.nodes)
        band[0, :-1] += stiffness
        band[0, 1:] += stiffness
        band[0, 0] += self.pulls[0]
        band[0, -1] += self.pulls[1]
        band[1, :-1] = -stiffness
        return band

    def relaxed(self, g: ArrayLike) -> Array:
        """argmin U[u] s.t. u_i = g_i on the contact nodes: one banded Cholesky solve.

        With finite slopes Newton's method from that of small ones, with steps that are halved while
        they would raise the energy, which is convex. NotCertifiedError if it does not come to rest.

        Plain elimination: it loses digits as l/Δx grows (1e-4 relative at 1e6). It is the
        independent check of the exact tails, not what the minimisers run on.
        """
        if self.lattice.slopes == "small":
            u = np.where(self.contact, g, 0.0)
            return u + self._step(u, self.hessian())
        linear = replace(self.lattice, slopes="small")
        u = NodalEnergy(linear, self.contact, int(self.nodes[0])).relaxed(g)
        before = math.inf
        for turn in range(_NEWTON):
            step, parts = self._step(u, self.hessian(u)), list(self.terms(u).values())
            energy, rounding = sum(parts), _ROUNDING * sum(map(abs, parts))
            while self.value(u + step) > energy + rounding:
                step = step / 2
            u = u + step
            if np.abs(step).max() <= _ROUNDING * np.abs(u).max():
                return u
            if turn % _SETTLED == 0:
                if before - energy <= rounding:  # a link all but vertical has hardly a stiffness
                    return u
                before = energy
        raise NotCertifiedError(
            f"no equilibrium of the free nodes after {_NEWTON} Newton steps; try another "
            "spacing, or method='fitted'"
        )

    def _links(self, u: Array) -> tuple[Array, Array]:
        """Tension and stiffness of the links; with finite slopes those in contact have γ₁ - w."""
        lat = self.lattice
        unit = terms.surface(np.diff(u) / lat.spacing, gamma1=1.0, slopes=lat.slopes)
        bound = lat.w * self.bound * (lat.slopes == "finite")
        tension = (lat.gamma1 - bound) * (lat.cell / lat.spacing)
        tension = lat.on_links(tension, self.nodes)
        return tension * unit.first, tension / lat.spacing * unit.second

    def _step(self, u: Array, band: Array) -> Array:
        held = self.contact
        band[0, held] = 1
        band[1, :-1][held[1:] | held[:-1]] = 0
        rows = min(2, u.size)  # one node has no sub-diagonal
        step = solveh_banded(band[:rows], np.where(held, 0.0, -self.gradient(u)), lower=True)
        return np.asarray(step)
