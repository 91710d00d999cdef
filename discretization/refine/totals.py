"""Energy and force that free surfaces account for, with the contacts they bound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from discretization.quadrature import Integrals
from discretization.refine.equations import Equations, ties
from energy.arrays import Array


@dataclass(frozen=True, eq=False)
class Totals:
    """U and P of free surfaces, by running integrals over the profile (../quadrature.py).

    Attributes
    ----------
    equations : Equations
    integrals : Integrals
    """

    equations: Equations
    integrals: Integrals

    @classmethod
    def of(cls, equations: Equations) -> Totals:
        """For the same depths as the equations."""
        level = equations.size + max(equations.size, equations.profile.touch)
        return cls(equations, Integrals.of(equations.scene, equations.profile, level))

    def of_surfaces(self, lines: Array, depths: Array, direction: int = 1) -> tuple[Array, Array]:
        """Energy and force that free surfaces account for.

        Those of the contact up to the left line, less those up to the right line, and

            U = kl [σ (u² + v²) + τ (u - v)²]/2,      P = kl σ (u + v)

        of the free surface, displaced by u and v at its lines. The sum over all free surfaces of a
        state is its U and P.

        Parameters
        ----------
        lines : ndarray (n, 2)
            [length].
        depths : ndarray (n,)
            [length].
        direction : {1, -1}
            Whether the work of adhesion is that of closing or that of opening.

        Returns
        -------
        energy, force : ndarray (n,)
            U [energy/length] and P [force/length].
        """
        scene = self.equations.scene
        adhesion = scene.work_of_adhesion if direction > 0 else scene.opened.work_of_adhesion
        has_line = np.isfinite(lines)
        energy = np.zeros(len(lines))
        force = np.zeros(len(lines))
        for column, sign in ((0, 1.0), (1, -1.0)):
            own = np.flatnonzero(has_line[:, column])
            contact = self.integrals.contact(lines[own, column], depths[own], adhesion)
            energy[own] += sign * contact[0]
            force[own] += sign * contact[2]
        there = np.where(has_line, lines, self.equations.profile.lowest)
        height = np.asarray(self.equations.profile.indenter.height(there), float)
        displaced = np.where(has_line, depths[:, None] - height, 0.0)
        is_gap = has_line.all(axis=1)
        with np.errstate(invalid="ignore"):
            widths = (lines[:, 1] - lines[:, 0]) / self.equations.length
        found = ties(np.where(is_gap, widths, np.inf))
        rise = np.where(is_gap, height[:, 1] - height[:, 0], 0.0)
        unit = scene.stiffness * self.equations.length
        stored = found.ground * (displaced**2).sum(axis=1) + found.tie * rise**2
        energy += unit * stored / 2
        force += unit * found.ground * displaced.sum(axis=1)
        return energy, force
