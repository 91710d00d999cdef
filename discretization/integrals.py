"""What a contact costs up to a line at x, from integrals over the profile that are summed once.

A free surface between the contact lines q < p bounds the contact on its left and that on its right.
Of the energy and the force of a state it accounts for

    E = C(q) - C(p) + F,      P = ∂C/∂d (q) - ∂C/∂d (p) + S_q + S_p,
    C(x) = ∫ [k/2 (d - f)² + γ₁ ψ(f') - w s(f')] dx  from the lowest point to x,

ψ and s the density and the length of the surface in contact (energy/terms.py), F and S what the
free surface stores and pulls. Summed over all free surfaces, the tails among them, that is U and P:
what lies between the lowest point and a line cancels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.profile import Resolved
from discretization.quadrature import over, stretched, summed
from energy import Scene

Array = NDArray[np.float64]
_EXACT = 1e-15  # of a whole integral: what halving a panel may change it by


@dataclass(frozen=True, eq=False)
class Integrals:
    """∫1, ∫f, ∫f², ∫γ₁ψ(f') and ∫c s(f') of a resolved profile, heights from its lowest point.

    Only of what may be in contact, f <= level: what stands higher would but cost digits. parts
    (5, n): from the lowest point to each x (n,), increasing, with the heights f. c is the factor of
    the scene's pattern on the work of adhesion.
    """

    scene: Scene
    profile: Resolved
    x: Array
    f: Array
    parts: Array

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, level: float) -> Integrals:
        """Summed between the samples, outwards from the lowest point."""
        own = cls(scene, profile, profile.x, profile.f, np.empty((5, 0)))
        ends = np.array([profile.x[:-1], profile.x[1:]])
        low = np.minimum(profile.f[:-1], profile.f[1:]) <= level
        found = summed(own._densities, ends[:, low], _EXACT, np.zeros((5, 1)), smooth=True)
        ends = np.hstack([found.ends, ends[:, ~low]])
        sums = np.hstack([found.sums, np.zeros((5, int((~low).sum())))])
        order = np.lexsort(ends[::-1])
        x = np.append(ends[0][order], ends[1][order[-1]])
        f = np.asarray(profile.indenter.height(x), float)
        start = int(np.argmin(f))
        before = -np.cumsum(sums[:, order][:, :start][:, ::-1], axis=1)[:, ::-1]
        after = np.cumsum(sums[:, order][:, start:], axis=1)
        return cls(scene, profile, x, f, np.hstack([before, np.zeros((5, 1)), after]))

    def _densities(self, x: Array) -> Array:
        """Of the five integrals."""
        indenter = self.profile.indenter
        f = np.asarray(indenter.height(x), float) - self.profile.touch
        surface = stretched(self.scene, x, np.asarray(indenter.slope(x), float))
        densities = np.array([np.ones_like(f), f, f * f, *surface])
        return np.asarray(densities * self.scene.measure(x))

    def at(self, x: Array) -> Array:
        """The five integrals from the lowest point to x (n,)."""
        last = self.x.size - 1
        i = np.clip(np.searchsorted(self.x, x) - 1, 0, last)
        beyond = np.minimum(i + 1, last)
        i = np.where(self.f[i] <= self.f[beyond], i, beyond)  # the lower
        return self.parts[:, i] + over(self._densities, np.array([self.x[i], x]))[0]

    def contact(self, x: Array, depth: Array, w: float) -> Array:
        """C(x), the sum of its terms' absolute values, and ∂C/∂d (3, n)."""
        width, f, square, stretched, bound = self.at(x)
        d, k = depth - self.profile.touch, self.scene.stiffness
        terms = np.array([k / 2 * d * d * width, -k * d * f, k / 2 * square, stretched, -w * bound])
        return np.array([terms.sum(axis=0), np.abs(terms).sum(axis=0), k * (d * width - f)])
