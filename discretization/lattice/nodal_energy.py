"""The lattice's energy as a function of all displacements: what the shortcuts are checked by."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

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


class Balance(NamedTuple):
    """What displacements take: terms of U, and the force on each node, ∂U/∂u_i (n,).

    springs (n,): the part of the force that is the springs'; tension (n - 1,): vertical, of links.
    """

    terms: dict[str, float]
    force: Array
    springs: Array
    tension: Array


class NodalEnergy:
    """The energy of n nodes in a row, with exact tails beyond both ends, as a function of u.

    contact: (n,) bool, the nodes held to be in contact (they carry the adhesion); first: the
    lattice's number of the first node; adhesion (n - 1,): of each link, unless it is w everywhere;
    tails: whether there is a tail beyond the first and the last node, or a part of the row with an
    energy of its own, which begins at the last node of this one, whose spring counts there.
    """

    def __init__(
        self,
        lattice: Lattice,
        contact: ArrayLike,
        first: int = 0,
        adhesion: ArrayLike | None = None,
        tails: tuple[bool, bool] = (True, True),
    ) -> None:
        self.lattice = lattice
        self.contact = np.asarray(contact, bool)
        self.nodes = first + np.arange(self.contact.size)
        self.own = self.contact.size - (not tails[1])  # of the springs
        ends = (first, -1), (first + self.contact.size - 1, 1)
        pulls = [
            float(lattice.pull(*end)) if tail else 0.0
            for end, tail in zip(ends, tails, strict=True)
        ]
        self.pulls = np.array(pulls)  # of the tails, over u
        self.bound = self.contact[1:] & self.contact[:-1]
        self.cells = lattice.on_nodes(lattice.cell, self.nodes)
        self.link_cells = lattice.on_links(lattice.cell, self.nodes)
        self.adhesion = lattice.w * self.link_cells if adhesion is None else np.asarray(adhesion)

    def balance(self, u: ArrayLike) -> Balance:
        """Energy and forces at displacements u (n,) and fixed contact."""
        lat, u = self.lattice, np.asarray(u, float)
        slopes, ends = (u[1:] - u[:-1]) / lat.spacing, u[[0, -1]]
        free = terms.surface(slopes, gamma1=lat.gamma1, slopes=lat.slopes).value
        spring = terms.spring(u, k=lat.k)
        springs, tension = self.cells * spring.first, self._links(slopes)[0]
        springs[self.own :] = 0.0
        force = springs.copy()
        force[:-1] -= tension
        force[1:] += tension
        force[0] += self.pulls[0] * u[0]
        force[-1] += self.pulls[1] * u[-1]
        values = {
            "springs": float((self.cells * spring.value)[: self.own].sum()),
            "surface": float((self.link_cells * free).sum()),
            "adhesion": -self._adhesive(slopes),
            "tails": float(self.pulls @ ends**2) / 2,
        }
        return Balance(values, force, springs, tension)

    def _adhesive(self, slopes: Array) -> float:
        """What adhesion gains."""
        lat, bonds = self.lattice, self.adhesion
        if not lat.gamma1:
            return lat.w * float(np.sum(self.cells * self.contact))
        if lat.slopes == "finite":
            bonds = bonds * np.hypot(1, slopes)
        return float(np.sum(bonds * self.bound))

    def terms(self, u: ArrayLike) -> dict[str, float]:
        """Value of each term [energy/length] at displacements u (n,)."""
        return self.balance(u).terms

    def value(self, u: ArrayLike) -> float:
        """U[u] [energy/length]."""
        return sum(self.terms(u).values())

    def gradient(self, u: ArrayLike) -> Array:
        """∂U/∂u_i [force/length] (n,) at fixed contact: on contact nodes the indenter's force."""
        return self.balance(u).force

    def hessian(self, u: ArrayLike = 0.0) -> Array:
        """∂²U/∂u_i∂u_j [force/length²] at u, lower banded (2, n): diagonal, then sub-diagonal.

        For small slopes it is the same at every u.
        """
        lat, u = self.lattice, np.broadcast_to(np.asarray(u, float), self.contact.shape)
        stiffness = self._links(np.diff(u) / lat.spacing)[1]
        band = np.full((2, u.size), lat.k) * self.cells
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

    def _links(self, slopes: Array) -> tuple[Array, Array]:
        """Tension and stiffness of the links; with finite slopes those in contact have γ₁ - w."""
        lat = self.lattice
        unit = terms.surface(slopes, gamma1=1.0, slopes=lat.slopes)
        bound = lat.w * self.bound if lat.slopes == "finite" else 0.0
        tension = (lat.gamma1 - bound) / lat.spacing * self.link_cells
        return tension * unit.first, tension / lat.spacing * unit.second

    def _step(self, u: Array, band: Array) -> Array:
        held = self.contact
        band[0, held] = 1
        band[1, :-1][held[1:] | held[:-1]] = 0
        rows = min(2, u.size)  # one node has no sub-diagonal
        step = solveh_banded(band[:rows], np.where(held, 0.0, -self.gradient(u)), lower=True)
        return np.asarray(step)
