"""Rigid plane f = 0, Eqs. (19)-(20): one separation at which every contact size is neutral.

A depth d is positive into the layer; a separation is positive where the plane is lifted above the
flat surface.

Imported: `Values` is a float for numbers, an array for arrays. `positive` and `non_negative` check
an argument, whose name comes first, and return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import non_negative, positive
from energy.cards._types import Values


def critical_separation(k: ArrayLike, w: ArrayLike) -> Values:
    """Separation at which a rigid plane detaches.

    δ₀ = √(2w/k), Eq. (20); surface tension plays no part.

    Parameters
    ----------
    k, w : array_like
        Stiffness of the foundation [N/m³] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        δ₀ [m].

    Raises
    ------
    ValueError
        For k <= 0 or w < 0.
    """
    delta0: Values = np.sqrt(2.0 * (non_negative("w", w) / positive("k", k)))
    return delta0


def critical_depth(k: ArrayLike, w: ArrayLike) -> Values:
    """Depth at which a rigid plane detaches.

    d_c = −δ₀, Eq. (19): contact spreads for d > d_c, shrinks for d < d_c.

    Parameters
    ----------
    k, w : array_like
        Stiffness of the foundation [N/m³] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    return -critical_separation(k, w)
