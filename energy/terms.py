"""Densities of the energy and their derivatives: the integrands of

    U[u] = ∫ spring(u) dx + ∫_free surface(u') dx + ∫_contact contact(f') dx.

The measure dx (a line contact) belongs to whoever integrates. All functions are vectorised;
energies are per length of the contact line and per dx. A new energy term is written down here,
and its parameters come from `Scene.spring`; discretization/README.md says what answers it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

SLOPES = ("small", "finite")
GEOMETRIES = ("line", "axisymmetric")


class Density(NamedTuple):
    """An energy density with its first and second derivative by the displacement or slope.

    Of densities that are quadratic the second is one number.
    """

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @property
    def quadratic(self) -> bool:
        """Whether the second derivative is one number."""
        return np.ndim(self.second) == 0


def spring(u: ArrayLike, *, k: float) -> Density:
    """Winkler foundation: k u²/2, k u, k. Source of Eqs. (5) and (9)."""
    u = np.asarray(u, float)
    return Density(k / 2 * u * u, k * u, np.asarray(float(k)))


def surface(slope: ArrayLike, *, gamma1: float, slopes: str = "small") -> Density:
    """Stretched free surface, minus the flat one.

    small: γ₁ u'²/2, whose stationarity is Eq. (5); finite: γ₁(√(1+u'²) - 1), the true length,
    written without cancellation.
    """
    s = np.asarray(slope, float)
    if slopes == "small":
        return Density(gamma1 / 2 * s * s, gamma1 * s, np.asarray(float(gamma1)))
    root = np.sqrt(1 + s * s)
    return Density(gamma1 * s * s / (1 + root), gamma1 * s / root, gamma1 / root**3)


def contact(slope: ArrayLike, *, gamma1: float, w: float, slopes: str = "small") -> np.ndarray:
    """Surface in contact, minus the flat free surface; it follows the indenter's slope f'.

    small: γ₁ f'²/2 - w; finite: (γ₁ - w)√(1+f'²) - γ₁.
    """
    s = np.asarray(slope, float)
    if slopes == "small":
        return gamma1 / 2 * s * s - w
    return surface(s, gamma1=gamma1, slopes=slopes).value - w * np.sqrt(1 + s * s)
