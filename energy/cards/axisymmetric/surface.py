"""Free surfaces of rotational symmetry: outside a contact of radius a, and a disc in a ring.

γ₁ (u'' + u'/r) = k u holds there. Outside, flat far away, u = u_a K₀(r/l)/K₀(a/l); inside a ring
of inner radius b, smooth on the axis, u = u_b I₀(r/l)/I₀(b/l).

Conventions: displacements u are positive downwards, into the layer, and forces where they press the
indenter up, against its load; slopes are du/dr. l = √(γ₁/k); with s = a/l, `decay(s)` is
q = K₀(s)/K₁(s) and `disc(s)` is I₁(s)/I₀(s). Arguments broadcast, and raise ValueError where they
are out of range.

Imported: `elastocapillary_length(k, gamma1)` is l = √(γ₁/k). `scaled(a, l)` is s = a/l, and ∞ where
l = 0. `joined(x, a, inside, u_a, l)` is `inside` where |x| <= a, and beyond the surface that decays
from u_a. `Values` is a float for numbers, an array for arrays. `excess(name, value, bound, remedy)`
is value − bound, 0 where it is negative by rounding, and an error below.
`refuse(name, value, bad, remedy)` raises ValueError where `bad` is true. `unwrap` makes a number of
an array without axes. `finite`, `positive` and `non_negative` check an argument, whose name comes
first, and return it as float64.
"""

import numpy as np
import scipy
from numpy.typing import ArrayLike

from energy.cards._checks import excess, finite, non_negative, positive, refuse, unwrap
from energy.cards._types import Values
from energy.cards.axisymmetric._bessel import decay, disc, scaled
from energy.cards.axisymmetric._surface import joined
from energy.cards.tail import elastocapillary_length


def displacement(
    x: ArrayLike, *, a: ArrayLike, u_a: ArrayLike, k: ArrayLike, gamma1: ArrayLike
) -> Values:
    """Displacement of the free surface outside a contact.

    u = u_a K₀(x/l)/K₀(a/l) at the radius x >= a.

    Parameters
    ----------
    x : array_like
        Distances from the axis [m].
    a : array_like
        Radius of the contact [m].
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
        For x < a.
    """
    x = finite("x", x)
    a = positive("a", a)
    u_a = finite("u_a", u_a)
    excess("x", x, a, "the surface starts at the contact line, pass x >= a")
    ell = np.asarray(elastocapillary_length(k, gamma1))
    return joined(x, a, u_a, u_a, ell)


def slope_at_line(u_a: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Slope of the free surface at the contact line.

    u'(a + 0) = −u_a/(l q), q = K₀/K₁ of a/l.

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    a : array_like
        Radius of the contact [m].
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
    ell = elastocapillary_length(k, positive("gamma1", gamma1))
    return -finite("u_a", u_a) / (ell * decay(positive("a", a) / ell))


def energy(u_a: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Energy of the free surface outside a contact.

    πγ₁ (a/l) u_a²/q: half the work of its pull on the line.

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    a : array_like
        Radius of the contact [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        Energy [J].
    """
    tension = non_negative("gamma1", gamma1)
    ell = elastocapillary_length(k, tension)
    u_a = finite("u_a", u_a)
    a = positive("a", a)
    return unwrap(np.pi * positive("k", k) * ell * a / decay(scaled(a, ell)) * u_a**2)


def force(u_a: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Force of the free surface outside a contact on the indenter.

    −2πa γ₁ u'(a + 0) = 2πkal u_a/q.

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    a : array_like
        Radius of the contact [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        Force [N].
    """
    ell = elastocapillary_length(k, gamma1)
    a = positive("a", a)
    pull = 2.0 * np.pi * positive("k", k) * ell * a / decay(scaled(a, ell))
    return unwrap(pull * finite("u_a", u_a))


def disc_displacement(
    x: ArrayLike, *, b: ArrayLike, u_b: ArrayLike, k: ArrayLike, gamma1: ArrayLike
) -> Values:
    """Displacement of the free disc inside a ring.

    u = u_b I₀(x/l)/I₀(b/l) at the radius 0 <= x <= b.

    Parameters
    ----------
    x : array_like
        Distances from the axis [m].
    b : array_like
        Radius of the inner line of a ring [m].
    u_b : array_like
        Displacement of the surface at the inner line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        u [m], of the common shape of all arguments.

    Raises
    ------
    ValueError
        Outside, and for γ₁ = 0.
    """
    x = non_negative("x", x)
    b = positive("b", b)
    refuse("x", x, x > b, "is beyond the ring's inner line, pass x <= b")
    ell = elastocapillary_length(k, positive("gamma1", gamma1))
    # i0e(s) is exp(−s) I₀(s), which does not overflow
    scaled_ratio = scipy.special.i0e(x / ell) / scipy.special.i0e(b / ell)
    ratio = scaled_ratio * np.exp(-(b - x) / ell)
    return unwrap(finite("u_b", u_b) * ratio)


def disc_energy(u_b: ArrayLike, *, b: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Energy of the free disc inside a ring.

    πγ₁ (b/l) u_b² I₁/I₀ at b/l.

    Parameters
    ----------
    u_b : array_like
        Displacement of the surface at the inner line [m].
    b : array_like
        Radius of the inner line of a ring [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        Energy [J].
    """
    ell = elastocapillary_length(k, gamma1)
    b = positive("b", b)
    i1_over_i0 = disc(scaled(b, ell))
    squared = finite("u_b", u_b) ** 2
    return unwrap(np.pi * positive("k", k) * ell * b * (i1_over_i0 * squared))


def disc_force(u_b: ArrayLike, *, b: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Force of the free disc inside a ring on the indenter.

    2πkbl u_b I₁/I₀.

    Parameters
    ----------
    u_b : array_like
        Displacement of the surface at the inner line [m].
    b : array_like
        Radius of the inner line of a ring [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        Force [N].
    """
    ell = elastocapillary_length(k, gamma1)
    b = positive("b", b)
    i1_over_i0 = disc(scaled(b, ell))
    return unwrap(2.0 * np.pi * positive("k", k) * ell * b * (i1_over_i0 * finite("u_b", u_b)))
