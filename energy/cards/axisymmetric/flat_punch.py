"""Flat cylinder of radius a: `energy.cards.flat_punch` turned about its axis.

The line is pinned at the edge until the surface beside it has the slope α; that is at −δ₀ q(a/l),
a smaller lift than the δ₀ of a wide face, under imposed depth and dead load alike.

Conventions: the depth d of the face and displacements u are positive into the layer, forces P where
the cylinder is pressed. l = √(γ₁/k), δ₀ = √(2w/k), α = √(2w/γ₁); with s = a/l, `decay(s)` is
q = K₀(s)/K₁(s) and `growth(s)` is s² q'(s) = s² (q² − 1) + sq. Arguments out of range raise
ValueError.

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `scaled(a, l)` is s = a/l, and ∞ where l = 0. `joined(x, a, inside, u_a, l)` is
`inside` where |x| <= a, and beyond the surface that decays from u_a. `Values` is a float for
numbers, an array for arrays. `excess(name, value, bound, remedy)` is value − bound, 0 where it is
negative by rounding, and an error below. `unwrap` makes a number of an array without axes. `finite`
and `positive` check an argument, whose name comes first, and return it as float64.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, excess, finite, positive, unwrap
from energy.cards._types import Jump, Values
from energy.cards.axisymmetric._bessel import decay, growth, scaled
from energy.cards.axisymmetric._surface import joined
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length


class _Lengths(NamedTuple):
    """What the formulas of a cylinder are made of.

    Attributes
    ----------
    a : ndarray
        Radius of the face [m].
    ell : ndarray
        l [m].
    q : ndarray
        q(a/l) [1].
    """

    a: Array
    ell: Array
    q: Array


def _lengths(a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> _Lengths:
    """The lengths from checked arguments."""
    a = positive("a", a)
    ell = np.asarray(elastocapillary_length(k, gamma1))[()]
    return _Lengths(a, ell, decay(scaled(a, ell)))


def _attached(d: ArrayLike, least: Values) -> Array:
    """d as numbers; ValueError below the least depth of the contact."""
    excess("d", finite("d", d), least, "the punch has detached, pass d >= detachment_depth(...)")
    return finite("d", d)


def displacement(
    x: ArrayLike, *, d: ArrayLike, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Displacement of the surface under a flat cylinder and beside it.

    u = d under the face, d K₀(|x|/l)/K₀(a/l) outside.

    Parameters
    ----------
    x : array_like
        Distances from the axis [m].
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Radius of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        u [m], of the common shape of all arguments.

    Raises
    ------
    ValueError
        For d < −δ₀ q.
    """
    d = _attached(d, detachment_depth(a=a, k=k, gamma1=gamma1, w=w))
    a, ell, _ = _lengths(a, k, gamma1)
    return joined(finite("x", x), a, d, d, ell)  # d under the face and at its edge


def force(d: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Force on a flat cylinder.

    P = (πka² + 2πγ₁ (a/l)/q) d with the line at the edge.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Radius of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.

    Raises
    ------
    ValueError
        For d < −δ₀ q.
    """
    d = _attached(d, detachment_depth(a=a, k=k, gamma1=gamma1, w=w))
    a, ell, q = _lengths(a, k, gamma1)
    return unwrap(np.pi * positive("k", k) * a * (a + 2.0 * ell / q) * d)


def energy(d: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy of the layer under a flat cylinder.

    U = (πk/2)(a² + 2al/q) d² − wπa².

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    a : array_like
        Radius of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        U [J]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        For d < −δ₀ q.
    """
    d = _attached(d, detachment_depth(a=a, k=k, gamma1=gamma1, w=w))
    delta0 = critical_separation(k, w)
    a, ell, q = _lengths(a, k, gamma1)
    difference = (a + 2.0 * ell / q) * d**2 - a * delta0**2  # of what is stored and w = kδ₀²/2
    return unwrap(0.5 * np.pi * positive("k", k) * a * difference)


def adhesion_force(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Largest pull that a flat cylinder bears, under imposed depth and under a dead load.

    F_A = πk δ₀ (a²q + 2al) = πka²δ₀q + 2πa √(2wγ₁).

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N], >= 0.
    """
    delta0 = critical_separation(k, w)
    a, ell, q = _lengths(a, k, gamma1)
    return unwrap(np.pi * positive("k", k) * delta0 * a * (a * q + 2.0 * ell))


def detachment_depth(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Depth at which a flat cylinder detaches, the end of the metastable branch.

    d = −δ₀ q(a/l), where the surface beside the edge has the slope α.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    q = _lengths(a, k, gamma1).q
    return -critical_separation(k, w) * q


def detachment(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Detachment of a flat cylinder under imposed depth.

    (P, d, a, released) = (−F_A, −δ₀q, a, (πk/2) δ₀² (a²(q² − 1) + 2alq)).

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N], d [m], a [m] and the energy released [J].
    """
    delta0 = critical_separation(k, w)
    radius, ell, q = _lengths(a, k, gamma1)
    # a²(q² − 1) + 2alq without cancellation, by a²(q² − 1) = l² growth − alq
    area = ell * (ell * growth(scaled(radius, ell)) + radius * q)
    force = -adhesion_force(a=a, k=k, gamma1=gamma1, w=w)
    released = 0.5 * np.pi * positive("k", k) * delta0**2 * area
    return Jump.of(force, -delta0 * q, radius, released)


def global_pull_off_depth(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Depth below which the detached state of a flat cylinder has the lower energy.

    d = −δ₀ √(a/(a + 2l/q)).

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    a, ell, q = _lengths(a, k, gamma1)
    return -critical_separation(k, w) * np.sqrt(a / (a + 2.0 * ell / q))
