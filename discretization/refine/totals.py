"""Energy and force that free surfaces account for, with the contacts they bound.

Conventions
-----------
Depths grow as the indenter goes down, forces are positive where it is pressed. A row of `lines` is
a free surface with its left line in column 0 and its right line in column 1 [length], -inf and inf
where a tail has none; its left line is the right end of a contact and the other way round.
`Integrals.contact` has the energy C(x) and the force ∂C/∂d of a contact from the lowest point of
the profile up to x, with the other sign on its left. `ties` has σ = tanh(L/2), its `ground`, and
τ = 1/sinh L, its `tie`, of surfaces of width L l, 1 and 0 of a tail. `scene.opened` is the scene
with the work of adhesion of opening, `scene.stiffness` k; `profile.touch` is the height of the
lowest point, the depth of first touch, and `profile.lowest` its x.
"""

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
        """The totals for the same depths as the equations."""
        # Integrals are made for heights up to a level: no line gets higher than this one.
        level = equations.size + max(equations.size, equations.profile.touch)
        return cls(equations, Integrals.of(equations.scene, equations.profile, level))

    def of_surfaces(self, lines: Array, depths: Array, direction: int = 1) -> tuple[Array, Array]:
        """Energy and force that free surfaces account for.

        With q the left line, p the right one, and u and v the displacements d - f there,

            U = C(q) - C(p) + kl [σ (u² + v²) + τ (u - v)²]/2,
            P = ∂C/∂d (q) - ∂C/∂d (p) + kl σ (u + v);

        what belongs to a line that a tail has not is 0. The sum over all free surfaces of a state
        is its U and P, as C of both ends of a contact is left of its two neighbours.

        Parameters
        ----------
        lines : ndarray (n, 2)
            [length].
        depths : ndarray (n,)
            [length].
        direction : {1, -1}
            1 with the work of adhesion of closing, -1 with that of opening.

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
        # The free surfaces themselves; the lowest point stands for no line.
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
