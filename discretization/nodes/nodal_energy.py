"""The lattice's energy as a function of all displacements: what the shortcuts are checked by."""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solveh_banded

from discretization.certificate import NotCertifiedError
from discretization.nodes.lattice import PIECE, Lattice
from energy import terms
from energy.arrays import Array

_NEWTON = 60  # steps of Newton's method; ten do up to 80°
_ROUNDING = 1e-14  # of the energy, and of u: steps that change less are the last
_SETTLED = 5  # steps that do not lower the energy are the last, too


class Balance(NamedTuple):
    """What displacements take: terms of U, and the forces on the nodes, ∂U/∂u_i (n,).

    force: of the springs over the whole line, k∫u, those under the tails among them; sizes: the sum
    of their sizes; tension: root of the sum of the squares of the links' vertical forces.
    """

    terms: dict[str, float]
    forces: Array
    force: float
    sizes: float
    tension: float

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
        self.lattice, self.first = lattice, first
        self.contact = np.asarray(contact, bool)
        size = self.contact.size
        pulls = lattice.pull(first, -1), lattice.pull(first + size - 1, 1)
        self.pulls = np.array(pulls, float) * tails  # of the tails, over u
        self.cells, self.links = lattice.sizes(first, size), lattice.sizes(first + 0.5, size - 1)
        even = lattice.sizes(first + 0.5, size - 1, lattice.w)
        self.adhesion = even if adhesion is None else np.asarray(adhesion)
        self.tension = lattice.sizes(first + 0.5, size - 1, lattice.gamma1 / lattice.spacing)
        if lattice.slopes == "finite":  # horizontal; that of links in contact is γ₁ - w
            self.tension = self.tension - self.bonds() / lattice.spacing

    def bonds(self, at: Any = np.s_[:]) -> Array:
        """Adhesion of these links, or without tension of these nodes' springs."""
        if not self.lattice.gamma1:
            return np.asarray(self.lattice.w * self.cells[at] * self.contact[at])
        both = self.contact[1:][at] & self.contact[:-1][at]
        return np.asarray(self.adhesion[at] if both.all() else self.adhesion[at] * both)

    def balance(self, u: ArrayLike) -> Balance:
        """Energy and forces at displacements u (n,) and fixed contact."""
        lat, u = self.lattice, np.asarray(u, float)
        pulled, forces, sums = self.pulls * u[[0, -1]], np.empty(u.size), []
        for start in range(0, u.size, PIECE):
            end, new = start + PIECE, int(start > 0)  # and the link before
            own, spring = slice(start, end), lat.stored(u[start:end])
            slopes = np.diff(u[start - new : end + 1])
            slopes /= lat.spacing
            stretch = terms.surface(slopes, gamma1=1.0, slopes=lat.slopes)
            springs, bound = self.cells[own] * spring.first, self.bonds(own)
            across = np.empty(springs.size + 1)
            across[0], across[-1] = pulled * (1, -1)
            tension = across[1 - new : slopes.size + 1 - new]
            np.multiply(self.tension[start - new : end], stretch.first, out=tension)
            np.subtract(springs, across[1:] - across[:-1], out=forces[own])
            if lat.slopes == "finite":
                bound = bound * np.hypot(1, slopes[new:])
            stored, spread = self.cells[own] * spring.value, self.links[own] * stretch.value[new:]
            parts = stored.sum(), spread.sum(), -bound.sum(), springs.sum()
            more = np.abs(springs, out=springs).sum(), tension[new:] @ tension[new:]
            sums.append([*map(float, (*parts, *more))])
        sums.append([0.0, 0.0, 0.0, float(pulled.sum()), float(np.abs(pulled).sum()), 0.0])
        springs, surface, adhesion, force, sizes, squares = map(math.fsum, zip(*sums, strict=True))
        values = {"springs": springs, "surface": lat.gamma1 * surface, "adhesion": adhesion}
        values["tails"] = float(pulled @ u[[0, -1]]) / 2
        return Balance(values, forces, force, sizes, math.sqrt(squares))

    def value(self, u: ArrayLike) -> float:
        """U[u] [energy/length]."""
        return self.balance(u).energy

    def gradient(self, u: ArrayLike) -> Array:
        """∂U/∂u_i [force/length] (n,) at fixed contact: on contact nodes the indenter's force."""
        return self.balance(u).forces

    def hessian(self, u: ArrayLike = 0.0) -> Array:
        """∂²U/∂u_i∂u_j [force/length²] at u, lower banded (2, n): diagonal, then sub-diagonal.

        Of a linear lattice it is the same at every u.
        """
        lat, u = self.lattice, np.broadcast_to(np.asarray(u, float), self.contact.shape)
        stretch = terms.surface(np.diff(u) / lat.spacing, gamma1=1.0, slopes=lat.slopes)
        stiffness = self.tension / lat.spacing * stretch.second
        beside = np.concatenate([self.pulls[:1], stiffness, self.pulls[1:]])
        springs = self.cells * lat.stored(u).second
        return np.array([springs + beside[:-1] + beside[1:], np.append(-stiffness, 0.0)])

    def relaxed(self, g: ArrayLike) -> Array:
        """argmin U[u] s.t. u_i = g_i on the contact nodes: one banded Cholesky solve.

        Where it is not linear Newton's method, with finite slopes from the solution of small ones,
        and steps halved while they raise the energy, which is convex. NotCertifiedError if in vain.

        Plain elimination: it loses digits as l/Δx grows (1e-4 relative at 1e6). It is the
        independent check of the exact tails, not what the minimisers run on.
        """
        u = np.where(self.contact, g, 0.0)
        if self.lattice.slopes == "finite":
            small = replace(self.lattice, slopes="small")
            u = NodalEnergy(small, self.contact, self.first).relaxed(g)
        elif not self.lattice.gamma1:
            return u
        if self.lattice.linear:
            return u + self._step(self.gradient(u), self.hessian())
        found, before = self.balance(u), math.inf
        for turn in range(_NEWTON):
            step, rounding = self._step(found.forces, self.hessian(u)), _ROUNDING * found.scale
            while (after := self.balance(u + step)).energy > found.energy + rounding:
                step = step / 2
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
        return np.asarray(solveh_banded(band[:rows], np.where(held, 0.0, -force), lower=True))
