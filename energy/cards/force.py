"""Force on the indenter for an arbitrary profile, Eqs. (9)-(11).

Conventions: the contact reaches from -a to a. Heights f are positive upwards, the depth d of the
level f = 0 and displacements u downwards, so that u = d - f in contact; forces are per length and
positive where they press against the indenter. u_a is u at the lines, l = √(γ₁/k).

Imported: `Values` is a float for numbers, an array for arrays. `finite`, `positive` and
`non_negative` check an argument, whose name comes first, and return it as float64.
"""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, finite, non_negative, positive
from energy.cards._types import Values

_rule = functools.cache(np.polynomial.legendre.leggauss)  # nodes and weights on (-1, 1)
Profile = Callable[[Array], Any]


def elastic(d: ArrayLike, a: ArrayLike, *, f: Profile, k: ArrayLike, order: int = 64) -> Values:
    """Force of the springs in contact with any profile.

    P_el = k ∫_{−a}^{a} (d − f(x)) dx, Eq. (9), by Gauss-Legendre quadrature.

    `order` nodes on each side of x = 0: exact for polynomials of degree 2·order − 1 on either side,
    so a corner of f at x = 0 costs nothing, corners elsewhere do. f takes and returns arrays.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Half-width of the contact [m].
    f : callable
        The profile f(x) [m] of an array of positions.
    order : int
        Points of the quadrature on each side of x = 0.
    k : array_like
        Stiffness of the foundation [N/m³].

    Returns
    -------
    float or ndarray
        P_el [N/m].

    Raises
    ------
    ValueError
        For k <= 0, a < 0 or values of f that are not finite.
    """
    d = finite("d", d)
    a = non_negative("a", a)
    k = positive("k", k)
    nodes, weights = _rule(order)
    x = np.asarray(a)[..., None] * (0.5 + 0.5 * nodes)  # on (0, a), along the last axis
    heights = finite("f(x)", f(x)) + finite("f(-x)", f(-x))
    both_sides = 2.0 * np.asarray(d)[..., None] - heights  # u(x) + u(-x)
    total: Values = k * a * (both_sides * (0.5 * weights)).sum(axis=-1)
    return total


def surface(beta: ArrayLike, *, gamma1: ArrayLike) -> Values:
    """Force of the free surfaces at any slope, both ends of the contact together.

    P_surf = −2 γ₁ sin β, Eq. (10); β = atan u'(a + 0), positive where the surface is pulled up.

    Parameters
    ----------
    beta : array_like
        Inclination β of the surface at the line [rad], positive where it is pulled up.
    gamma1 : array_like
        Surface tension [N/m].

    Returns
    -------
    float or ndarray
        P_surf [N/m].

    Raises
    ------
    ValueError
        For γ₁ < 0.
    """
    pull: Values = -2.0 * non_negative("gamma1", gamma1) * np.sin(finite("beta", beta))
    return pull


def surface_small_slope(u_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Force of the free surfaces for small slopes, both ends of the contact together.

    −2 γ₁ u'(a + 0) = 2 √(k γ₁) u_a, the last term of Eq. (11) with the tail of Eq. (6).

    Small slopes; also right at γ₁ = 0, where it vanishes.

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        Force [N/m].

    Raises
    ------
    ValueError
        For k <= 0 or γ₁ < 0.
    """
    tension = np.sqrt(positive("k", k)) * np.sqrt(non_negative("gamma1", gamma1))
    pull: Values = 2.0 * tension * finite("u_a", u_a)
    return pull


def total(
    d: ArrayLike,
    a: ArrayLike,
    *,
    f: Profile,
    k: ArrayLike,
    gamma1: ArrayLike,
    order: int = 64,
) -> Values:
    """Force on an indenter of any profile, even about x = 0.

    P = 2k ∫_0^a (d − f) dx − 2 γ₁ u'(a + 0), Eq. (11), for an even profile f.

    The slope u'(a + 0) = −(d − f(a))/l is that of the tail, Eqs. (6) and (13), so a need not be
    the equilibrium half-width. Quadrature and errors as in `elastic`.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Half-width of the contact [m].
    f : callable
        The profile f(x) [m] of an array of positions.
    order : int
        Points of the quadrature on each side of x = 0.
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.
    """
    d = finite("d", d)
    a = non_negative("a", a)
    u_a = d - finite("f(a)", f(np.asarray(a)))
    return elastic(d, a, f=f, k=k, order=order) + surface_small_slope(u_a, k=k, gamma1=gamma1)
