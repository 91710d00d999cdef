"""Parabola f = x²/(2R), Eqs. (31)-(33), its force, energy and pull-off.

The half-width is the free unknown on the whole metastable branch d >= −δ₀, down to a = 0. The
force-controlled pull-off depends on Λ = l/√(R δ₀) and stops being a smooth minimum at Λ = 1.

Conventions: heights f are positive upwards, the depth d of the lowest point and displacements u
downwards, forces P per length where the indenter is pressed. The lines are at ±a, with the
displacement u_a = d − f(a) there; l = √(γ₁/k) (`elastocapillary_length`), δ₀ = √(2w/k)
(`critical_separation`), and `critical_depth` is −δ₀. Arguments broadcast, and raise ValueError
where they are out of range.

Imported: `joined(x, a, inside, u_a, l)` is `inside` where |x| <= a, and beyond the surface that
decays from u_a. `Values` is a float for numbers, an array for arrays.
`excess(name, value, bound, remedy)` is value − bound, 0 where it is negative by rounding, and an
error below. `not_zero` puts 1 in place of 0, for divisors of terms that are 0 there. `unwrap` makes
a number of an array without axes. `finite`, `positive` and `non_negative` check an argument, whose
name comes first, and return it as float64.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, excess, finite, non_negative, not_zero, positive, unwrap
from energy.cards._surface import joined
from energy.cards._types import PullOff, Values
from energy.cards.plane import critical_depth, critical_separation
from energy.cards.tail import elastocapillary_length


class _Lengths(NamedTuple):
    """The three lengths of a parabola on the layer.

    Attributes
    ----------
    R : ndarray
    ell, delta0 : ndarray
        l and δ₀.
    """

    R: Array
    ell: Array
    delta0: Array


def _lengths(R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> _Lengths:
    """The lengths from checked arguments, as numbers where these are numbers."""
    ell = elastocapillary_length(k, gamma1)
    delta0 = critical_separation(k, w)
    return _Lengths(positive("R", R), unwrap(np.asarray(ell)), unwrap(np.asarray(delta0)))


def half_width(
    d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Half-width of the contact at a depth.

    a = −l + √(l² + 2R (d + δ₀)), Eq. (33), evaluated without the difference.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        a [m].

    Raises
    ------
    ValueError
        For d < −δ₀, where the contact has let go.
    """
    R, ell, delta0 = _lengths(R, k, gamma1, w)
    remedy = "the parabola has let go, pass d >= -sqrt(2w/k)"
    chord = np.sqrt(2.0 * R * excess("d", finite("d", d), -delta0, remedy))
    divisor = ell + np.hypot(ell, chord)  # 0 where d + δ₀ and l are, and a with them
    a: Values = chord * (chord / not_zero(divisor))
    return a


def depth(a: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Depth at which a line rests at a half-width.

    d = a (a + 2l)/(2R) − δ₀, Eq. (32) solved for the depth.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].

    Raises
    ------
    ValueError
        For a < 0.
    """
    R, ell, delta0 = _lengths(R, k, gamma1, w)
    a = non_negative("a", a)
    return a * (a + 2.0 * ell) / (2.0 * R) - delta0


def displacement(
    x: ArrayLike, *, d: ArrayLike, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Displacement of the surface under a parabola and beside it.

    u = d − x²/(2R) in contact, (la/R − δ₀) exp(−(|x| − a)/l) outside, Eqs. (4), (6), (13).

    Parameters
    ----------
    x : array_like
        Positions [m].
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        u [m], of the common shape of all arguments.

    Raises
    ------
    ValueError
        For d < −δ₀.
    """
    x = finite("x", x)
    a = np.asarray(half_width(d, R=R, k=k, gamma1=gamma1, w=w))
    R, ell, delta0 = _lengths(R, k, gamma1, w)
    u_a = ell * a / R - delta0
    inside = u_a + (a - x) * (a + x) / (2.0 * R)  # d − f(x) = u_a + f(a) − f(x)
    return joined(x, a, inside, u_a, ell)


def force(d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Force on a parabola at a depth.

    Eq. (11) with a from Eq. (33).

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.

    Raises
    ------
    ValueError
        For d < −δ₀.
    """
    a = half_width(d, R=R, k=k, gamma1=gamma1, w=w)
    return force_of_width(a, R=R, k=k, gamma1=gamma1, w=w)


def force_of_width(
    a: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force on a parabola at a half-width.

    P = (2k/3R) ((a + l)³ − l³) − 2k δ₀ (a + l): Eq. (11) with d from Eq. (32).

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.

    Raises
    ------
    ValueError
        For a < 0.
    """
    R, ell, delta0 = _lengths(R, k, gamma1, w)
    a = non_negative("a", a)
    pressed = a * (a**2 + 3.0 * ell * (a + ell)) / (3.0 * R)
    return 2.0 * positive("k", k) * (pressed - delta0 * (a + ell))


def energy(d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy of the layer under a parabola.

    U = k (l δ₀² − (2δ₀/3R)((a + l)³ − l³) + (a²/R²)(2a³/15 + 2a²l/3 + 4al²/3 + l³)).

    Springs, contact and free surface, adhesion; P = dU/dd.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        U [J/m]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        For d < −δ₀.
    """
    a = np.asarray(half_width(d, R=R, k=k, gamma1=gamma1, w=w))[()]
    R, ell, delta0 = _lengths(R, k, gamma1, w)
    difference_of_cubes = a * (a**2 + 3.0 * ell * (a + ell))  # (a + l)³ − l³
    polynomial = a**2 * (2.0 * a + 10.0 * ell) + 5.0 * ell**2 * (4.0 * a + 3.0 * ell)
    without_adhesion = (a / R) ** 2 * polynomial / 15.0
    mixed = 2.0 * delta0 * difference_of_cubes / (3.0 * R)
    return positive("k", k) * (without_adhesion - mixed + ell * delta0**2)


def pull_off(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> PullOff:
    """The most tensile state (P, d, a), where a load-controlled contact lets go.

    Λ = l/√(R δ₀) <= 1: (a + l)² = R δ₀, d = −δ₀/2 − l²/(2R),
    P = −(4/3) k √R δ₀^(3/2) − (2/3) k l³/R. Λ >= 1: a = 0, d = −δ₀, P = −2 √(2wγ₁). From dP/da
    of `force_of_width`; the paper does not give it.

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N/m], d [m] and a [m].
    """
    R, ell, delta0 = _lengths(R, k, gamma1, w)
    k = positive("k", k)
    root = np.sqrt(R) * np.sqrt(delta0)  # √(Rδ₀), of a + l at the minimum
    smooth = root >= ell  # Λ <= 1
    at_minimum = -2.0 * k * (2.0 * root * delta0 + ell**3 / R) / 3.0
    at_zero_width = -2.0 * k * ell * delta0  # −2 √(2wγ₁)
    force = np.where(smooth, at_minimum, at_zero_width)
    d = np.where(smooth, -0.5 * (delta0 + ell**2 / R), -delta0)
    a = np.maximum(root - ell, 0.0)
    return PullOff(unwrap(force), unwrap(d), a)


def adhesion_force(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Largest pull that the contact bears.

    F_A = −P of `pull_off`.

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N/m], >= 0.
    """
    return -pull_off(R=R, k=k, gamma1=gamma1, w=w).force


def detachment_depth(*, k: ArrayLike, w: ArrayLike) -> Values:
    """Depth at which the contact vanishes under imposed depth.

    d = −δ₀, where a → 0 under displacement control.

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


def energy_released(*, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy that both free surfaces lose as the contact vanishes under imposed depth.

    2wl: what the two tails lose at `detachment_depth`, where `energy` jumps to 0.

    Parameters
    ----------
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        Energy [J/m].
    """
    return 2.0 * non_negative("w", w) * elastocapillary_length(k, gamma1)
