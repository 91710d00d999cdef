"""The lattice's energy as a function of all displacements: what the shortcuts are checked by.

U[u], its terms, gradient and Hessian for n nodes in a row with any displacements, contacts fixed;
the formula stands in nodes/lattice.py. Free nodes are relaxed by plain elimination and Newton's
method, without the closed forms of free surfaces that the rest of the package relies on.

Conventions
-----------
u is positive down into the layer. A force is ∂U/∂u_i: positive on a contact node where the indenter
presses, negative where adhesion pulls, 0 on a free node in equilibrium. Arrays over nodes have the
length n; those over links n - 1, link i between the nodes i and i + 1 of this row. Beyond each end
there is a tail, of stiffness `pulls` over u, or nothing. Energies are per length of the line
contact; about an axis energies and forces are those of the whole contact, and sizes are areas.

`Lattice.stored(u)` is the energy of the springs per area with its first and second derivative by u,
`terms.surface(u')` that of the free surface with those by u'. `Lattice.sizes(first, n, unit)` are
lengths or areas of n nodes or links times a unit, from the node `first`, or the link whose middle
`first` is, on; `spacing` is Δx, `gamma1` γ₁, and `tail_stiffness(node, side)` what the tail beyond
that node pulls with over its u. PIECE nodes are worked on at a time, so that arrays stay small.
"""

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


class NewtonRules(NamedTuple):
    """When Newton's method for the free nodes stops.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 8 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.nodes.nodal_energy`.

    Attributes
    ----------
    most_steps : int
        Steps at most; ten do up to inclinations of 80°.
    rounding : float
        Of the terms of the energy, and of the largest u: a step that changes less is rounding.
    stalled : int
        So many steps together that do not lower the energy beyond rounding are the last.
    """

    most_steps: int = 60
    rounding: float = 1e-14
    stalled: int = 5


_NEWTON = NewtonRules()


class Balance(NamedTuple):
    """Energy and forces at given displacements.

    Attributes
    ----------
    terms : dict of float
        Terms of U [energy/length]: "springs", "surface", "adhesion" (at most 0) and "tails".
    forces : ndarray (n,)
        ∂U/∂u_i [force/length].
    force : float
        Of the springs over the whole line, k∫u, those under the tails among them [force/length].
    sizes : float
        The sum of the absolute values of these forces, of spring by spring and of both tails.
    tension : float
        Root of the sum of the squares of the links' vertical forces: their rounding adds up like
        that.
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


class _Sums(NamedTuple):
    """Sums over a piece of the nodes, as `Balance` has them of all: the first three are its terms.

    But surface is divided by γ₁, and tension is the sum of the squares itself.
    """

    springs: float
    surface: float
    adhesion: float
    force: float
    sizes: float
    tension: float


class NodalEnergy:
    """The energy of n nodes in a row, with exact tails beyond both ends, as a function of u.

    Parameters
    ----------
    lattice : Lattice
    contact : array_like of bool (n,)
        The nodes in contact; they carry the adhesion.
    first : int
        The lattice's number of the first node.
    adhesion : array_like (n - 1,), optional
        Of each link [energy/length], unless it is w everywhere.
    tails : tuple of bool
        Whether there is a tail beyond the first and the last node, or nothing.

    Attributes
    ----------
    pulls : ndarray (2,)
        Stiffnesses of both tails [stress].
    cells, links : ndarray (n,), (n - 1,)
        Lengths, or areas, of nodes and links.
    tension : ndarray (n - 1,)
        By which the derivative of the surface's energy by the slope, over γ₁, is multiplied to give
        the vertical force of each link [force/length].
    """

    def __init__(
        self,
        lattice: Lattice,
        contact: ArrayLike,
        first: int = 0,
        adhesion: ArrayLike | None = None,
        tails: tuple[bool, bool] = (True, True),
    ) -> None:
        """Stiffnesses of tails, sizes and adhesion of nodes and links; see the class."""
        self.lattice = lattice
        self.first = first
        self.contact = np.asarray(contact, bool)
        size = self.contact.size
        pulls = [lattice.tail_stiffness(first, -1), lattice.tail_stiffness(first + size - 1, 1)]
        self.pulls = np.array(pulls, float) * tails
        self.cells = lattice.sizes(first, size)
        self.links = lattice.sizes(first + 0.5, size - 1)
        if adhesion is None:
            self.adhesion = lattice.sizes(first + 0.5, size - 1, lattice.w)
        else:
            self.adhesion = np.asarray(adhesion)
        self.tension = lattice.sizes(first + 0.5, size - 1, lattice.gamma1 / lattice.spacing)
        if lattice.slopes == "finite":  # horizontal; that of links in contact is γ₁ - w
            self.tension = self.tension - self.bonds() / lattice.spacing

    def bonds(self, at: Any = np.s_[:]) -> Array:
        """Adhesion of links in contact, or without tension of the springs of nodes in contact.

        Parameters
        ----------
        at : slice, or ndarray of int
            Which links or nodes; all by default.

        Returns
        -------
        ndarray
            [energy/length].
        """
        if not self.lattice.gamma1:
            return np.asarray(self.lattice.w * self.cells[at] * self.contact[at])
        both_ends = self.contact[1:][at] & self.contact[:-1][at]
        if both_ends.all():
            return np.asarray(self.adhesion[at])
        return np.asarray(self.adhesion[at] * both_ends)

    def balance(self, u: ArrayLike) -> Balance:
        """Energy and forces at given displacements and fixed contact.

        Parameters
        ----------
        u : array_like (n,)
            Displacements [length].

        Returns
        -------
        Balance
        """
        u = np.asarray(u, float)
        end_pulls = self.pulls * u[[0, -1]]
        forces = np.empty(u.size)
        sums = []
        for start in range(0, u.size, PIECE):
            sums.append(self._balance_piece(u, start, end_pulls, forces))
        of_tails = float(end_pulls.sum())
        sums.append(_Sums(0.0, 0.0, 0.0, of_tails, float(np.abs(end_pulls).sum()), 0.0))
        total = _Sums(*map(math.fsum, zip(*sums, strict=True)))
        values = {
            "springs": total.springs,
            "surface": self.lattice.gamma1 * total.surface,
            "adhesion": total.adhesion,
            "tails": float(end_pulls @ u[[0, -1]]) / 2,
        }
        return Balance(values, forces, total.force, total.sizes, math.sqrt(total.tension))

    def _balance_piece(self, u: Array, start: int, end_pulls: Array, forces: Array) -> _Sums:
        """Sums over the nodes from `start` on that are taken at a time; `forces` gets theirs.

        Their links are those before and after each of them; of these the one before the first node
        was counted in the sums of the piece before. end_pulls (2,): forces of the tails.
        """
        lattice = self.lattice
        end = start + PIECE
        own = slice(start, end)
        link_before = int(start > 0)
        spring = lattice.stored(u[own])
        slopes = np.diff(u[start - link_before : end + 1])
        slopes /= lattice.spacing
        stretch = terms.surface(slopes, gamma1=1.0, slopes=lattice.slopes)
        springs = self.cells[own] * spring.first
        bound = self.bonds(own)

        # Vertical forces of the links before and after each node, and beyond the ends of the row
        # those of the tails; a link pulls the node before it in the direction of its slope.
        across = np.empty(springs.size + 1)
        across[0] = end_pulls[0]
        across[-1] = -end_pulls[1]
        tension = across[1 - link_before : slopes.size + 1 - link_before]  # a view: of the links
        np.multiply(self.tension[start - link_before : end], stretch.first, out=tension)
        np.subtract(springs, across[1:] - across[:-1], out=forces[own])

        if lattice.slopes == "finite":  # w per length of the inclined profile
            bound = bound * np.hypot(1, slopes[link_before:])
        stored = self.cells[own] * spring.value
        stretched = self.links[own] * stretch.value[link_before:]
        force = float(springs.sum())
        sizes = float(np.abs(springs, out=springs).sum())
        return _Sums(
            springs=float(stored.sum()),
            surface=float(stretched.sum()),
            adhesion=float(-bound.sum()),
            force=force,
            sizes=sizes,
            tension=float(tension[link_before:] @ tension[link_before:]),
        )

    def value(self, u: ArrayLike) -> float:
        """The energy U[u].

        Parameters
        ----------
        u : array_like (n,)
            Displacements [length].

        Returns
        -------
        float
            [energy/length].
        """
        return self.balance(u).energy

    def gradient(self, u: ArrayLike) -> Array:
        """∂U/∂u_i at fixed contact: on contact nodes the force of the indenter.

        Parameters
        ----------
        u : array_like (n,)
            Displacements [length].

        Returns
        -------
        ndarray (n,)
            [force/length].
        """
        return self.balance(u).forces

    def hessian(self, u: ArrayLike = 0.0) -> Array:
        """∂²U/∂u_i∂u_j at fixed contact. On a linear lattice it is the same at every u.

        Parameters
        ----------
        u : array_like (n,)
            Displacements [length].

        Returns
        -------
        ndarray (2, n)
            Lower banded [force/length²]: the diagonal, then the sub-diagonal.
        """
        lattice = self.lattice
        u = np.broadcast_to(np.asarray(u, float), self.contact.shape)
        slopes = np.diff(u) / lattice.spacing
        stretch = terms.surface(slopes, gamma1=1.0, slopes=lattice.slopes)
        links = self.tension / lattice.spacing * stretch.second
        links_and_tails = np.concatenate([self.pulls[:1], links, self.pulls[1:]])
        springs = self.cells * lattice.stored(u).second
        diagonal = springs + links_and_tails[:-1] + links_and_tails[1:]
        return np.array([diagonal, np.append(-links, 0.0)])

    def relaxed(self, g: ArrayLike) -> Array:
        """The displacements of least energy with given contact nodes, argmin U[u] s.t. u_i = g_i.

        On a linear lattice one banded Cholesky solve; else Newton's method, with finite slopes from
        the solution of small ones, and steps halved while they raise the energy, which is convex.
        It stops after a step of at most 1e-14 max |u|, or five that lower U by no more than 1e-14
        of its terms: a link that is all but vertical is hardly stiff.

        Plain elimination loses digits as l/Δx grows (1e-4 relative at 1e6). It is the independent
        check of the exact tails, not what the minimisers run on.

        Parameters
        ----------
        g : array_like (n,)
            Displacements of contact nodes; those of others do not matter [length].

        Returns
        -------
        ndarray (n,)
            u [length].

        Raises
        ------
        NotCertifiedError
            If 60 steps are not enough.
        """
        u = np.where(self.contact, g, 0.0)
        if self.lattice.slopes == "finite":
            small = replace(self.lattice, slopes="small")
            u = NodalEnergy(small, self.contact, self.first).relaxed(g)
        elif not self.lattice.gamma1:
            return u
        if self.lattice.linear:
            return u + self._newton_step(self.gradient(u), self.hessian())
        return self._relaxed_by_newton(u)

    def _relaxed_by_newton(self, u: Array) -> Array:
        """`relaxed` by Newton's method, from displacements that fulfil u_i = g_i in contact."""
        here = self.balance(u)
        energy_before = math.inf  # some steps ago
        for count in range(_NEWTON.most_steps):
            step = self._newton_step(here.forces, self.hessian(u))
            rounding = _NEWTON.rounding * here.scale
            trial = self.balance(u + step)
            while trial.energy > here.energy + rounding:
                step = step / 2
                trial = self.balance(u + step)
            u = u + step
            if np.abs(step).max() <= _NEWTON.rounding * np.abs(u).max():
                return u
            if count % _NEWTON.stalled == 0:
                if energy_before - here.energy <= rounding:
                    return u
                energy_before = here.energy
            here = trial
        raise NotCertifiedError(
            f"no equilibrium of the free nodes after {_NEWTON.most_steps} Newton steps; try "
            "another spacing, or method='fitted'"
        )

    def _newton_step(self, forces: Array, band: Array) -> Array:
        """-H⁻¹ ∂U/∂u with fixed contact nodes (n,) [length].

        forces (n,), band (2, n): gradient and Hessian; the latter is overwritten. Rows of contact
        nodes become those of the unit matrix, of which the step is 0.
        """
        fixed = self.contact
        band[0, fixed] = 1
        band[1, :-1][fixed[1:] | fixed[:-1]] = 0
        rows = min(2, fixed.size)  # one node has no sub-diagonal
        right_side = np.where(fixed, 0.0, -forces)
        return np.asarray(solveh_banded(band[:rows], right_side, lower=True))
