"""Flat punch of half-width a, Eqs. (21)-(23).

The contact line is pinned at the edge for d > −δ₀; at d = −δ₀ every contact width is neutral
and the punch lets go at once. That is the end of the *metastable* branch: the detached state
has the lower energy already at the shallower `global_pull_off_depth`.

Conventions: the depth d of the face and displacements u are positive into the layer, forces P per
length where the punch is pressed; l = √(γ₁/k), δ₀ = √(2w/k), and `critical_depth` is −δ₀.
Arguments out of range raise ValueError.

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `joined(x, a, inside, u_a, l)` is `inside` where |x| <= a, and beyond the surface that
decays from u_a. `Values` is a float for numbers, an array for arrays.
`excess(name, value, bound, remedy)` is value − bound, 0 where it is negative by rounding, and an
error below. `finite`, `positive` and `non_negative` check an argument, whose name comes first, and
return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, excess, finite, non_negative, positive
from energy.cards._surface import joined
from energy.cards._types import Values
from energy.cards.plane import critical_depth, critical_separation
from energy.cards.tail import elastocapillary_length

_REMEDY = "the punch has let go, pass d >= -sqrt(2w/k)"


def displacement(
    x: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Displacement of the surface as a flat punch detaches.

    u = −δ₀ exp(−(|x| − a)/l) outside, −δ₀ under the punch, Eq. (21).

    Parameters
    ----------
    x : array_like
        Positions [m].
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        u [m], of the common shape of all arguments.

    Raises
    ------
    ValueError
        For a <= 0, k <= 0, γ₁ < 0 or w < 0.
    """
    x = finite("x", x)
    a = positive("a", a)
    u_a = np.asarray(critical_depth(k, w))  # under the whole face, its edges included
    return joined(x, a, u_a, u_a, np.asarray(elastocapillary_length(k, gamma1)))


def force(
    d: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike | None = None
) -> Values:
    """Force on a flat punch.

    P = 2k (a + l) d, Eq. (11) with the line pinned at the edge.

    Valid for d >= −δ₀. w does not enter the value: where it is given, d is checked.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Half-width of the contact [m].
    w : array_like, optional
        Work of adhesion [J/m²].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.
    """
    d = finite("d", d)
    a = positive("a", a)
    k = positive("k", k)
    if w is not None:
        excess("d", d, critical_depth(k, w), _REMEDY)
    return 2.0 * k * (a + elastocapillary_length(k, gamma1)) * d


def force_at_detachment(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Force on a flat punch as it detaches.

    P = −2^(3/2) √w (a √k + √γ₁), Eq. (22): `force` at d = −δ₀.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.
    """
    return -adhesion_force(a=a, k=k, gamma1=gamma1, w=w)


def adhesion_force(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Largest pull that a flat punch bears on the metastable branch.

    F_A = 2^(3/2) √w (a √k + √γ₁), Eq. (23).

    The globally stable punch bears only 2k δ₀ √(a (a + l)).

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N/m], >= 0.

    Raises
    ------
    ValueError
        For a <= 0, k <= 0, γ₁ < 0 or w < 0.
    """
    a = positive("a", a)
    k = positive("k", k)
    w = non_negative("w", w)
    bracket = a * np.sqrt(k) + np.sqrt(non_negative("gamma1", gamma1))
    pull: Values = 2.0 * np.sqrt(2.0 * w) * bracket
    return pull


def energy(d: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy of the layer under a flat punch.

    U = k (a + l) d² − 2wa: springs in contact, two tails, adhesion.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        U [J/m]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        For d < −δ₀.
    """
    d = finite("d", d)
    a = positive("a", a)
    k = positive("k", k)
    excess("d", d, critical_depth(k, w), _REMEDY)
    stored = k * (a + elastocapillary_length(k, gamma1)) * d**2
    return stored - 2.0 * non_negative("w", w) * a


def detachment_depth(*, k: ArrayLike, w: ArrayLike) -> Values:
    """Depth at which a flat punch detaches, the end of the metastable branch.

    d = −δ₀, Eq. (20), with `energy` 2wl left to lose.

    Parameters
    ----------
    k, w : array_like
        Stiffness of the foundation [N/m³] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    return critical_depth(k, w)


def global_pull_off_depth(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Depth below which the detached state of a flat punch has the lower energy.

    d = −δ₀ √(a/(a + l)).

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    a = positive("a", a)
    ell = elastocapillary_length(k, gamma1)
    share: Array = np.sqrt(a / (a + ell))
    return -critical_separation(k, w) * share
