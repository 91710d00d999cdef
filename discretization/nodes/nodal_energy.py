"""The lattice's energy as a function of all displacements: what the shortcuts are checked by."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solveh_banded

from discretization.certificate import NotCertifiedError
from discretization.nodes.lattice import Lattice
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

    @property
    def energy(self) -> float:
        """U [energy/length]."""
        return sum(self.terms.values())

    @property
    def scale(self) -> float:
        """Sum of the terms' sizes, to which rounding is relative."""
        return sum(map(abs, self.terms.values()))


class NodalEnergy:
    """The energy of n nodes in a row, with exact tails beyond both ends, as a function of u.

    contact: (n,) bool, the nodes held to be in contact (they carry the adhesion); first: the
    lattice's number of the first node; adhesion (n - 1,): of each link, unless it is w everywhere;
    tails: whether there is a tail beyond the first and the last node, or nothing.
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
        ends = (first, -1), (first + self.contact.size - 1, 1)
        pulls = [
            float(lattice.pull(*end)) if tail else 0.0
            for end, tail in zip(ends, tails, strict=True)
        ]
        self.pulls = np.array(pulls)  # of the tails, over u
        self.bound = self.contact[1:] & self.contact[:-1]
        self.cells = lattice.cell * lattice.weight(self.nodes)
        self.link_cells = lattice.cell * lattice.weight(self.nodes[:-1] + 0.5)
        self.adhesion = lattice.w * self.link_cells if adhesion is None else np.asarray(adhesion)

    def balance(self, u: ArrayLike) -> Balance:
        """Energy and forces at displacements u (n,) and fixed contact."""
        lat, u = self.lattice, np.asarray(u, float)
        slopes, ends = (u[1:] - u[:-1]) / lat.spacing, u[[0, -1]]
        stretch, spring = self._stretch(slopes), terms.spring(u, k=lat.k)
        springs, tension = self.cells * spring.first, self._tension() * stretch.first
        force = springs.copy()
        force[:-1] -= tension
        force[1:] += tension
        force[0] += self.pulls[0] * u[0]
        force[-1] += self.pulls[1] * u[-1]
        values = {
            "springs": _sum(self.cells, spring.value),
            "surface": lat.gamma1 * _sum(self.link_cells, stretch.value),
            "adhesion": -_sum(*self._adhesive(slopes)),
            "tails": float(self.pulls @ ends**2) / 2,
        }
        return Balance(values, force, springs, tension)

    def _adhesive(self, slopes: Array) -> tuple[Any, Any]:
        """What adhesion gains where there is contact, and the contact; of links, or of springs."""
        lat = self.lattice
        if not lat.gamma1:
            return lat.w * self.cells, self.contact
        bonds = self.bound * np.hypot(1, slopes) if lat.slopes == "finite" else self.bound
        return self.adhesion, bonds

    def around(self, u: Array) -> Array:
        """Energy of each node's spring and of the links on both of its sides (n,)."""
        lat, slopes = self.lattice, np.diff(u) / self.lattice.spacing
        springs, (work, bound) = self.cells * terms.spring(u, k=lat.k).value, self._adhesive(slopes)
        if not lat.gamma1:
            return np.asarray(springs - work * bound)
        links = lat.gamma1 * self.link_cells * self._stretch(slopes).value - work * bound
        return np.asarray(springs + np.append(links, 0.0) + np.append(0.0, links))

    def _stretch(self, slopes: Array) -> terms.Density:
        """Of links whose surface tension is 1."""
        return terms.surface(slopes, gamma1=1.0, slopes=self.lattice.slopes)

    def _tension(self) -> Any:
        """Horizontal, of each link or all; with finite slopes those in contact have γ₁ - w."""
        lat = self.lattice
        bound = lat.w * self.bound if lat.slopes == "finite" else 0.0
        return (lat.gamma1 - bound) / lat.spacing * self.link_cells

    def terms(self, u: ArrayLike) -> dict[str, float]:
        """Value of each term [energy/length] at displacements u (n,)."""
        return self.balance(u).terms

    def value(self, u: ArrayLike) -> float:
        """U[u] [energy/length]."""
        return self.balance(u).energy

    def gradient(self, u: ArrayLike) -> Array:
        """∂U/∂u_i [force/length] (n,) at fixed contact: on contact nodes the indenter's force."""
        return self.balance(u).force

    def hessian(self, u: ArrayLike = 0.0) -> Array:
        """∂²U/∂u_i∂u_j [force/length²] at u, lower banded (2, n): diagonal, then sub-diagonal.

        For small slopes it is the same at every u.
        """
        lat, u = self.lattice, np.broadcast_to(np.asarray(u, float), self.contact.shape)
        slopes = np.diff(u) / lat.spacing
        stiffness = self._tension() / lat.spacing * self._stretch(slopes).second
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
            return u + self._step(self.gradient(u), self.hessian())
        linear = replace(self.lattice, slopes="small")
        u = NodalEnergy(linear, self.contact, int(self.nodes[0])).relaxed(g)
        found, before = self.balance(u), math.inf
        for turn in range(_NEWTON):
            step, rounding = self._step(found.force, self.hessian(u)), _ROUNDING * found.scale
            after = self.balance(u + step)
            while after.energy > found.energy + rounding:
                step = step / 2
                after = self.balance(u + step)
            u = u + step
            if np.abs(step).max() <= _ROUNDING * np.abs(u).max():
                return u
            if turn % _SETTLED == 0:
                if before - found.energy <= rounding:  # a link all but vertical is hardly stiff
                    return u
                before = found.energy
            found = after
        raise NotCertifiedError(
            f"no equilibrium of the free nodes after {_NEWTON} Newton steps; try another "
            "spacing, or method='fitted'"
        )

    def _step(self, force: Array, band: Array) -> Array:
        held = self.contact
        band[0, held] = 1
        band[1, :-1][held[1:] | held[:-1]] = 0
        rows = min(2, held.size)  # one node has no sub-diagonal
        step = solveh_banded(band[:rows], np.where(held, 0.0, -force), lower=True)
        return np.asarray(step)


def _sum(weights: Any, values: Array) -> float:
    """Weighted sum of values; weights: of each, or of all."""
    return float(weights @ values) if np.ndim(weights) else float(weights * values.sum())
