"""Densities of the energy and their derivatives: the integrands of

    U[u] = ∫ spring(u) dx + ∫_free surface(u') dx + ∫_contact contact(f') dx.

The measure dx of a line contact, or 2πr dr about an axis, is left to whoever integrates
(`Scene.measure`). A new energy term is written down here, and its parameters come from
`Scene.spring`; discretization/README.md says which minimisers support it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

SLOPES = ("small", "finite")
GEOMETRIES = ("line", "axisymmetric")
# Two numbers that differ by less than this share count as one: k u²/2 written in another order is
# off by some 1e-16, and a term of less than 1e-12 changes no result within its stated error.
_SAME = 1e-12


class Density(NamedTuple):
    """An energy density with its derivatives by the displacement or the slope.

    Attributes
    ----------
    value : ndarray
        Energy per area, of the shape of the argument.
    first, second : ndarray
        Its first and second derivative; the second is one number, of shape (), of a density that is
        quadratic, and one for each displacement of others.
    """

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @property
    def quadratic(self) -> bool:
        """Whether the density is quadratic: its second derivative is then one number."""
        return np.ndim(self.second) == 0

    def hookean(self, u: np.ndarray, k: float) -> bool:
        """Whether this is the density k u²/2 with its derivatives, but for rounding.

        Parameters
        ----------
        u : ndarray
            The displacements at which it was taken [length]; two of them tell quadratic densities
            apart.
        k : float
            Stiffness per area [stress/length].

        Returns
        -------
        bool
        """
        if not self.quadratic:
            return False
        hooke = (k / 2 * u * u, k * u, np.float64(k))
        for found, expected in zip(self, hooke, strict=True):
            same = found == expected  # infinite numbers, too
            if not (same | (np.abs(found - expected) <= _SAME * np.abs(expected))).all():
                return False
        return True


def spring(u: ArrayLike, *, k: float) -> Density:
    """Energy of the Winkler foundation per area, k u²/2, the source of Eqs. (5) and (9).

    Parameters
    ----------
    u : array_like
        Displacements [length], of any shape.
    k : float
        Stiffness per area [stress/length].

    Returns
    -------
    Density
        k u²/2, k u and k.
    """
    u = np.asarray(u, float)
    return Density(k / 2 * u * u, k * u, np.asarray(float(k)))


def surface(slope: ArrayLike, *, gamma1: float, slopes: str = "small") -> Density:
    """Energy of the stretched free surface per projected area, minus that of the flat one.

    For small slopes γ₁ u'²/2, whose stationarity is Eq. (5); for finite ones γ₁(√(1+u'²) - 1), the
    true length, evaluated as γ₁ u'²/(1 + √(1+u'²)) without cancellation.

    Parameters
    ----------
    slope : array_like
        Slopes u' [1], of any shape.
    gamma1 : float
        Surface tension γ₁ [energy/area].
    slopes : {"small", "finite"}

    Returns
    -------
    Density
    """
    s = np.asarray(slope, float)
    if slopes == "small":
        return Density(gamma1 / 2 * s * s, gamma1 * s, np.asarray(float(gamma1)))
    stretch = np.sqrt(1 + s * s)
    value = gamma1 * s * s / (1 + stretch)
    return Density(value, gamma1 * s / stretch, gamma1 / stretch**3)


def contact(slope: ArrayLike, *, gamma1: float, w: float, slopes: str = "small") -> np.ndarray:
    """Energy of the surface in contact per projected area, minus that of the flat free surface.

    It follows the indenter: γ₁ f'²/2 - w for small slopes, (γ₁ - w)√(1+f'²) - γ₁ for finite ones.

    Parameters
    ----------
    slope : array_like
        Slopes f' of the indenter [1], of any shape.
    gamma1, w : float
        Surface tension γ₁ and work of adhesion w [energy/area].
    slopes : {"small", "finite"}

    Returns
    -------
    ndarray
        Of the shape of `slope`.
    """
    s = np.asarray(slope, float)
    if slopes == "small":
        return gamma1 / 2 * s * s - w
    stretched = surface(s, gamma1=gamma1, slopes=slopes).value
    return stretched - w * np.sqrt(1 + s * s)
