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
from energy import Scene
from energy.terms import contact

Array = NDArray[np.float64]
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_EXACT = 1e-15  # of a whole integral: what halving a panel may change it by
_HALVINGS = 48  # of a panel, to the spacing of floating-point numbers


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
        """Summed by Gauss points between the samples, halved until that changes nothing.

        Outwards from the lowest point.
        """
        own = cls(scene, profile, profile.x, profile.f, np.empty((5, 0)))
        low = np.minimum(profile.f[:-1], profile.f[1:]) <= level
        lo, hi = profile.x[:-1], profile.x[1:]
        ends, sums = np.array([lo[~low], hi[~low]]), np.zeros((5, int((~low).sum())))
        lo, hi = lo[low], hi[low]
        whole, size = own._between(lo, hi), None
        for _ in range(_HALVINGS):
            middle = (lo + hi) / 2
            halves = own._between(lo, middle), own._between(middle, hi)
            size = np.abs(whole).sum(axis=1, keepdims=True) if size is None else size
            off = (np.abs(whole - halves[0] - halves[1]) > _EXACT * size).any(axis=0)
            rough = off & (lo < middle) & (middle < hi)
            ends = np.hstack([ends, [lo[~rough], hi[~rough]]])
            sums = np.hstack([sums, whole[:, ~rough]])
            lo = np.concatenate([lo[rough], middle[rough]])
            hi = np.concatenate([middle[rough], hi[rough]])
            whole = np.hstack([part[:, rough] for part in halves])
            if not lo.size:
                break
        ends, sums = np.hstack([ends, [lo, hi]]), np.hstack([sums, whole])
        order = np.lexsort((ends[1], ends[0]))
        x = np.append(ends[0][order], ends[1][order[-1]])
        f = np.asarray(profile.indenter.height(x), float)
        start = int(np.argmin(f))
        before = -np.cumsum(sums[:, order][:, :start][:, ::-1], axis=1)[:, ::-1]
        after = np.cumsum(sums[:, order][:, start:], axis=1)
        return cls(scene, profile, x, f, np.hstack([before, np.zeros((5, 1)), after]))

    def _between(self, lo: Array, hi: Array) -> Array:
        """The five integrals from lo to hi (n,)."""
        scene, half = self.scene, (hi - lo)[:, None] / 2
        x = (hi + lo)[:, None] / 2 + half * _POINTS
        f = np.asarray(self.profile.indenter.height(x), float) - self.profile.touch
        slope = np.asarray(self.profile.indenter.slope(x), float)
        stretched = contact(slope, gamma1=scene.gamma1, w=0.0, slopes=scene.slopes)
        bound = np.ones_like(slope) if scene.slopes == "small" else np.sqrt(1 + slope * slope)
        if scene.pattern is not None:
            bound = bound * scene.pattern.factor(x)
        densities = np.array([np.ones_like(f), f, f * f, stretched, bound])
        return np.asarray((densities * (half * _WEIGHTS) * scene.measure(x)).sum(axis=2))

    def at(self, x: Array) -> Array:
        """The five integrals from the lowest point to x (n,)."""
        last = self.x.size - 1
        i = np.clip(np.searchsorted(self.x, x) - 1, 0, last)
        beyond = np.minimum(i + 1, last)
        i = np.where(self.f[i] <= self.f[beyond], i, beyond)  # the lower
        return self.parts[:, i] + self._between(self.x[i], x)

    def contact(self, x: Array, depth: Array, w: float) -> Array:
        """C(x), the sum of its terms' absolute values, and ∂C/∂d (3, n)."""
        width, f, square, stretched, bound = self.at(x)
        d, k = depth - self.profile.touch, self.scene.stiffness
        terms = np.array([k / 2 * d * d * width, -k * d * f, k / 2 * square, stretched, -w * bound])
        return np.array([terms.sum(axis=0), np.abs(terms).sum(axis=0), k * (d * width - f)])
