"""The free surface outside the contact, Eqs. (5)-(7) and (13).

γ₁ u'' = k u holds there; the solution that is flat far away decays over the elastocapillary
length l and is fixed by its value u_a at the contact line.

Conventions: displacements u are positive downwards, into the layer; the lines are at ±a, and
slopes are those on the right, u'(a + 0). Arguments broadcast.

Imported: `joined(x, a, inside, u_a, l)` is `inside` where |x| <= a, and beyond the surface that
decays from u_a. `Values` is a float for numbers, an array for arrays.
`excess(name, value, bound, remedy)` is value − bound, 0 where it is negative by rounding, and an
error below. `refuse(name, value, bad, remedy)` raises ValueError where `bad` is true. `finite`,
`positive` and `non_negative` check an argument, whose name comes first, and return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import excess, finite, non_negative, positive, refuse
from energy.cards._surface import joined
from energy.cards._types import Values

# Largest a/l of `amplitude`: exp(709.8) is the largest float, and a factor of e⁹ is left for u_a.
_LARGEST_RATIO = 700.0


def elastocapillary_length(k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Elastocapillary length, over which the free surface decays.

    l = √(γ₁/k), Eq. (7).

    Parameters
    ----------
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        l [m].

    Raises
    ------
    ValueError
        For k <= 0 or γ₁ < 0.
    """
    ell: Values = np.sqrt(non_negative("gamma1", gamma1) / positive("k", k))
    return ell


def displacement(
    x: ArrayLike, *, a: ArrayLike, u_a: ArrayLike, k: ArrayLike, gamma1: ArrayLike
) -> Values:
    """Displacement of the free surface outside a contact.

    u = u_a exp(−(|x| − a)/l) for |x| >= a: Eq. (6) with its amplitude from Eq. (13).

    Without surface tension the springs beyond |x| = a stay undeformed.

    Parameters
    ----------
    x : array_like
        Positions [m].
    a : array_like
        Half-width of the contact [m].
    u_a : array_like
        Displacement of the surface at the line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        u [m], of the common shape of all arguments.

    Raises
    ------
    ValueError
        For |x| < a.
    """
    x = finite("x", x)
    a = non_negative("a", a)
    u_a = finite("u_a", u_a)
    excess("abs(x)", np.abs(x), a, "the tail starts at the contact line, pass |x| >= a")
    return joined(x, a, u_a, u_a, np.asarray(elastocapillary_length(k, gamma1)))


def slope_at_line(u_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Slope of the free surface at the contact line.

    u'(a + 0) = −u_a/l, from Eqs. (6) and (13).

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        u'(a + 0) [1].

    Raises
    ------
    ValueError
        For γ₁ = 0: a step has no slope.
    """
    return -finite("u_a", u_a) / elastocapillary_length(k, positive("gamma1", gamma1))


def amplitude(u_a: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Amplitude of the free surface, extrapolated to x = 0.

    C = −u_a exp(a/l) of Eqs. (6) and (13): the surface is u = −C exp(−|x|/l).

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    a : array_like
        Half-width of the contact [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        C [m].

    Raises
    ------
    ValueError
        For γ₁ = 0, and for a/l > 700 where C leaves the range of float64.
    """
    u_a = finite("u_a", u_a)
    ratio = non_negative("a", a) / elastocapillary_length(k, positive("gamma1", gamma1))
    ratio = finite("a/l", ratio)
    overflowing = ratio > _LARGEST_RATIO
    refuse("a/l", ratio, overflowing, "makes exp(a/l) overflow: use displacement, without C")
    return -u_a * np.exp(ratio)


def energy(u_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Energy of one free surface beside a contact.

    ∫ (k/2 u² + γ₁/2 u'²) dx = ½ √(k γ₁) u_a², from Eq. (6).

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        Energy [J/m].

    Raises
    ------
    ValueError
        For k <= 0 or γ₁ < 0.
    """
    u_a = finite("u_a", u_a)
    return 0.5 * np.sqrt(positive("k", k)) * np.sqrt(non_negative("gamma1", gamma1)) * u_a**2
