"""Force on an indenter of any profile that is turned about its axis, Eqs. (9)-(11) with 2πr dr.

Conventions: the contact is the disc r <= a. Heights f are positive upwards, the depth d of the
level f = 0 downwards, so that the surface is displaced by u = d − f in contact; forces are positive
where they press against the indenter. q = K₀/K₁ of a/l, l = √(γ₁/k); `surface.force` is 2πkal
u(a)/q.

Imported: `Values` is a float for numbers, an array for arrays. `Profile` is a function f(r) of
arrays. `unwrap` makes a number of an array without axes. `finite`, `positive` and `non_negative`
check an argument, whose name comes first, and return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import finite, non_negative, positive, unwrap
from energy.cards._types import Values
from energy.cards.axisymmetric import surface
from energy.cards.force import Profile


def elastic(d: ArrayLike, a: ArrayLike, *, f: Profile, k: ArrayLike, order: int = 64) -> Values:
    """Force of the springs in contact with any profile.

    2πk ∫₀ᵃ (d − f) r dr by Gauss-Legendre quadrature; a ring is the difference of two radii.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Radius of the contact [m].
    f : callable
        The profile f(r) [m] of an array of radii.
    order : int
        Points of the quadrature.
    k : array_like
        Stiffness of the foundation [N/m³].

    Returns
    -------
    float or ndarray
        Force [N].
    """
    d = finite("d", d)
    a = non_negative("a", a)
    k = positive("k", k)
    nodes, weights = np.polynomial.legendre.leggauss(order)  # on (-1, 1)
    t = 0.5 + 0.5 * nodes  # radii over a, along the last axis
    radii = np.asarray(a)[..., None] * t
    displacement = np.asarray(d)[..., None] - finite("f(r)", f(radii))
    integral = (displacement * (t * weights)).sum(axis=-1)  # 2 ∫₀¹ u t dt
    return unwrap(np.pi * k * a**2 * integral)


def total(
    d: ArrayLike, a: ArrayLike, *, f: Profile, k: ArrayLike, gamma1: ArrayLike, order: int = 64
) -> Values:
    """Force on an indenter of any profile, with one contact around the axis.

    P = 2πk ∫₀ᵃ (d − f) r dr + 2πkal (d − f(a))/q.

    a need not be where the line rests.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Radius of the contact [m].
    f : callable
        The profile f(r) [m] of an array of radii.
    order : int
        Points of the quadrature.
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.

    Raises
    ------
    ValueError
        For a <= 0, k <= 0, γ₁ < 0.
    """
    d = finite("d", d)
    a = positive("a", a)
    outside = surface.force(d - finite("f(a)", f(np.asarray(a))), a=a, k=k, gamma1=gamma1)
    return elastic(d, a, f=f, k=k, order=order) + outside
