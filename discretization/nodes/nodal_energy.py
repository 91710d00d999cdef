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
_BLOCK = 1 << 14  # nodes looked at at once: their arrays stay in the processor's cache
_ALL = slice(None)


class Balance(NamedTuple):
    """What displacements take: terms of U, and the force on each node, ∂U/∂u_i (n,).

    springs, sizes: sums of the springs' forces, and of their sizes; tension: root of the sum of the
    squares of the links' vertical ones.
    """

    terms: dict[str, float]
    force: Array
    springs: float
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
        self.lattice = lattice
        self.contact = np.asarray(contact, bool)
        self.first = first
        ends = (first, -1), (first + self.contact.size - 1, 1)
        pulls = [
            float(lattice.pull(*end)) if tail else 0.0
            for end, tail in zip(ends, tails, strict=True)
        ]
        self.pulls = np.array(pulls)  # of the tails, over u
        self.bound = self.contact[1:] & self.contact[:-1]
        self.adhesion = None if adhesion is None else np.asarray(adhesion)

    def _cells(self, at: slice = _ALL, middle: float = 0.0) -> Any:
        """Length or area of each of these nodes, or all; middle = 1/2: of the links after them."""
        own = range(self.contact.size - (middle > 0))[at]
        places = np.arange(own.start, own.stop) + (self.first + middle)
        return self.lattice.cell * self.lattice.weight(places)

    def balance(self, u: ArrayLike) -> Balance:
        """Energy and forces at displacements u (n,) and fixed contact."""
        u = np.asarray(u, float)
        force, sums, ends = np.zeros(u.size), np.zeros(6), u[[0, -1]]
        for start in range(0, u.size, _BLOCK):
            sums += self._added(u, force, slice(start, start + _BLOCK))
        force[0] += self.pulls[0] * u[0]
        force[-1] += self.pulls[1] * u[-1]
        *own, springs, sizes, squares = sums.tolist()
        values = dict(zip(("springs", "surface", "adhesion"), own, strict=True))
        values["tails"] = float(self.pulls @ ends**2) / 2
        return Balance(values, force, springs, sizes, math.sqrt(squares))

    def _added(self, u: Array, force: Array, at: slice) -> list[float]:
        """Adds the forces of springs at some nodes and of the links after them, and sums them up.

        Energies of springs, links and adhesion; springs' forces, their sizes, and squared tensions.
        """
        lat, slopes = self.lattice, np.diff(u[at.start : at.stop + 1]) / self.lattice.spacing
        stretch, spring = self._stretch(slopes), terms.spring(u[at], k=lat.k)
        cells, links = self._cells(at), self._cells(at, 0.5)
        springs, tension = cells * spring.first, self._tension(at) * stretch.first
        force[at] += springs
        force[at][: tension.size] -= tension
        force[at.start + 1 : at.stop + 1] += tension
        return [
            float((cells * spring.value).sum()),
            lat.gamma1 * float((links * stretch.value).sum()),
            -float(self._adhesive(slopes, at).sum()),
            float(springs.sum()),
            float(np.abs(springs).sum()),
            float(tension @ tension),
        ]

    def _adhesive(self, slopes: Array, at: slice = _ALL) -> Array:
        """What adhesion gains, of each link, or of each spring without tension."""
        lat = self.lattice
        if not lat.gamma1:
            return np.asarray(lat.w * self._cells(at) * self.contact[at])
        work = lat.w * self._cells(at, 0.5) if self.adhesion is None else self.adhesion[at]
        gained = work * self.bound[at]
        return np.asarray(gained * np.hypot(1, slopes) if lat.slopes == "finite" else gained)

    def around(self, u: Array) -> Array:
        """Energy of each node's spring and of the links on both of its sides (n,)."""
        lat, slopes = self.lattice, np.diff(u) / self.lattice.spacing
        springs, gained = self._cells() * terms.spring(u, k=lat.k).value, self._adhesive(slopes)
        if not lat.gamma1:
            return np.asarray(springs - gained)
        links = lat.gamma1 * self._cells(middle=0.5) * self._stretch(slopes).value - gained
        return np.asarray(springs + np.append(links, 0.0) + np.append(0.0, links))

    def _stretch(self, slopes: Array) -> terms.Density:
        """Of links whose surface tension is 1."""
        return terms.surface(slopes, gamma1=1.0, slopes=self.lattice.slopes)

    def _tension(self, at: slice = _ALL) -> Any:
        """Horizontal, of each link or all; with finite slopes those in contact have γ₁ - w."""
        lat = self.lattice
        bound = lat.w * self.bound[at] if lat.slopes == "finite" else 0.0
        return (lat.gamma1 - bound) / lat.spacing * self._cells(at, 0.5)

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
        band = np.full((2, u.size), lat.k) * self._cells()
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
        u = NodalEnergy(linear, self.contact, self.first).relaxed(g)
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
