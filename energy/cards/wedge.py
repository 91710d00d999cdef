"""Wedge f = |x| tan δ, Eqs. (24)-(30), and what they leave out.

Eqs. (25)-(29) describe a contact line that is free to move, a > 0, that is d > q with
q = l tan δ − δ₀. Blunt wedges, tan δ <= α = √(2w/γ₁), have q <= 0 and let go at d = q, a = 0.
Sharp wedges, tan δ > α, have q > 0: for 0 < d < q the line stays pinned at the tip, a = 0 and
P = 2kld, where Eqs. (25)-(27) do not hold; they never pull, and let go at d = 0.

Conventions: the depth d of the tip and displacements u are positive into the layer, forces P per
length where the wedge is pressed. The lines are at ±a, with the displacement u_a = d − a tan δ
there; l = √(γ₁/k) (`elastocapillary_length`), δ₀ = √(2w/k) (`critical_separation`). Arguments
broadcast, and raise ValueError where they are out of range; `wedge_slope` is tan δ.

Imported: `joined(x, a, inside, u_a, l)` is `inside` where |x| <= a, and beyond the surface that
decays from u_a. `Values` is a float for numbers, an array for arrays.
`excess(name, value, bound, remedy)` is value − bound, 0 where it is negative by rounding, and an
error below. `refuse(name, value, bad, remedy)` raises ValueError where `bad` is true. `finite`,
`positive` and `non_negative` check an argument, whose name comes first, and return it as float64.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, excess, finite, non_negative, positive, refuse, wedge_slope
from energy.cards._surface import joined
from energy.cards._types import PullOff, Values
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length

# A caller's δ = atan α makes tan δ = α, which `adhesion_force` allows, but for some roundings, and
# q = l tan δ − δ₀ is off by these of δ₀.
_ROUNDINGS = 32


class _Lengths(NamedTuple):
    """What the formulas of a wedge are made of.

    Attributes
    ----------
    slope : ndarray
        tan δ [1].
    ell : ndarray
        l [m].
    q : ndarray
        l tan δ − δ₀ [m]: the displacement u_a of a free line, and its least depth.
    """

    slope: Array
    ell: Array
    q: Array


class PinnedDepths(NamedTuple):
    """Depths between which the line is pinned at the tip [m]; empty where both are 0.

    Attributes
    ----------
    least, largest : float or ndarray
    """

    least: Values
    largest: Values


class _Line(NamedTuple):
    """A contact line at a depth, free or pinned at the tip.

    Attributes
    ----------
    half_width : ndarray
        a [m]; 0 where it is pinned.
    displacement : ndarray
        u_a [m]: q of a free line, d of a pinned one.
    """

    half_width: Array
    displacement: Array


def _lengths(delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> _Lengths:
    """The lengths from checked arguments."""
    slope = wedge_slope(delta)
    ell = np.asarray(elastocapillary_length(k, gamma1))
    return _Lengths(slope, ell[()], ell * slope - critical_separation(k, w))


def _state(d: ArrayLike, slope: Array, ell: Array, q: Array) -> _Line:
    """The line at depth d; ValueError below min(q, 0), where the contact has detached."""
    depth = finite("d", d)
    least = np.minimum(q, 0.0)
    remedy = "the wedge has let go, pass d >= detachment_depth(...)"
    excess("d", depth, least, remedy, scale=ell * slope)
    return _Line(np.maximum(depth - q, 0.0) / slope, np.minimum(depth, q))


def half_width(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Half-width of the contact at a depth.

    a = (d + δ₀)/tan δ − l, Eq. (25); 0 while the line is pinned at the tip.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        a [m].

    Raises
    ------
    ValueError
        Below `detachment_depth`.
    """
    slope, ell, q = _lengths(delta, k, gamma1, w)
    return _state(d, slope, ell, q).half_width


def depth(
    a: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at which a free line rests at a half-width.

    d = a tan δ − δ₀ + l tan δ, Eq. (28), of a free line; a = 0 gives its least depth q.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    slope, _, q = _lengths(delta, k, gamma1, w)
    return non_negative("a", a) * slope + q


def displacement(
    x: ArrayLike, *, d: ArrayLike, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Displacement of the surface under a wedge and beside it.

    u = d − |x| tan δ in contact, u_a exp(−(|x| − a)/l) outside.

    u_a = l tan δ − δ₀, Eq. (26), on a free line; u_a = d while it is pinned at the tip.

    Parameters
    ----------
    x : array_like
        Positions [m].
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        u [m], of the common shape of all arguments.

    Raises
    ------
    ValueError
        Below `detachment_depth`.
    """
    slope, ell, q = _lengths(delta, k, gamma1, w)
    x = finite("x", x)
    a, u_a = _state(d, slope, ell, q)
    inside = u_a + slope * (a - np.abs(x))  # d − f(x) = u_a + f(a) − f(x)
    return joined(x, a, inside, u_a, ell)


def force(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force on a wedge at a depth.

    P = 2k (ad − a² tan δ/2) + 2kl (l tan δ − δ₀), Eq. (27); P = 2kld pinned at the tip.

    Eq. (27) taken at a = 0 would give a force that does not depend on d: it holds for a free line
    only.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.

    Raises
    ------
    ValueError
        Below `detachment_depth`.
    """
    slope, ell, q = _lengths(delta, k, gamma1, w)
    a, u_a = _state(d, slope, ell, q)
    return positive("k", k) * (slope * a**2 + 2.0 * (a + ell) * u_a)


def force_of_width(
    a: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force on a wedge whose line is free, at a half-width.

    P = k (a² tan δ + 2 (a + l)(l tan δ − δ₀)), Eq. (29), of a free line.

    At a = 0 the force of a sharp wedge at the deep end of its pinned range.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.

    Raises
    ------
    ValueError
        For a < 0.
    """
    slope, ell, q = _lengths(delta, k, gamma1, w)
    a = non_negative("a", a)
    return positive("k", k) * (slope * a**2 + 2.0 * (a + ell) * q)


def energy(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Energy of the layer under a wedge.

    U = k (a³ tan²δ/3 + u_a (a + 2l) a tan δ + l u_a²), u_a as in `displacement`.

    Springs, contact and free surface, adhesion; P = dU/dd.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        U [J/m]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        Below `detachment_depth`.
    """
    slope, ell, q = _lengths(delta, k, gamma1, w)
    a, u_a = _state(d, slope, ell, q)
    rise = slope * a
    return positive("k", k) * (a * rise**2 / 3.0 + u_a * (a + 2.0 * ell) * rise + ell * u_a**2)


def adhesion_force(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Largest pull that a blunt wedge bears under a dead load.

    F_A = 2w/tan δ − γ₁ tan δ, Eq. (30), under load control; for tan δ <= α only.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N/m], >= 0.

    Raises
    ------
    ValueError
        For tan δ > α: Eq. (29) then rises from a = 0 on, its stationary point lies at a < 0, and
        the modulus in Eq. (30) turns a wedge that never pulls into an adhesive one.
    """
    slope, ell, q = _lengths(delta, k, gamma1, w)
    delta0 = critical_separation(k, w)
    beyond = q > _ROUNDINGS * np.finfo(np.float64).eps * delta0
    remedy = "is beyond tan δ = √(2w/γ₁): Eq. (30) fails, pass a blunter wedge or use pull_off"
    refuse("delta", np.arctan(slope), beyond, remedy)
    return positive("k", k) * np.maximum(-q, 0.0) * (delta0 + ell * slope) / slope


def pull_off(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> PullOff:
    """The most tensile state: (P, d, a) = (−F_A, 0, δ₀/tan δ − l), the minimum of Eq. (29).

    It lies at d = 0, the depth of first touch. A sharp wedge, tan δ > α, never pulls: (0, 0, 0).

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N/m], d [m] and a [m].
    """
    slope, ell, q = _lengths(delta, k, gamma1, w)
    delta0 = critical_separation(k, w)
    force = positive("k", k) * np.minimum(q, 0.0) * (delta0 + ell * slope) / slope
    depth = np.zeros_like(force)[()]
    half_width = np.maximum(-q, 0.0) / slope
    return PullOff(force, depth, half_width)


def detachment_depth(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Depth at which the contact vanishes under imposed depth.

    d where a → 0 under displacement control: min(l tan δ − δ₀, 0).

    `energy` there, k l d², is what the tails release.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    least: Values = np.minimum(_lengths(delta, k, gamma1, w).q, 0.0)
    return least


def tip_pinned_depths(
    *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> PinnedDepths:
    """Depths between which the line is pinned at the tip.

    (0, l tan δ − δ₀), the depths with a = 0 pinned at the tip; (0, 0), empty, if tan δ <= α.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    PinnedDepths
        The least and the largest one [m].
    """
    largest = np.maximum(_lengths(delta, k, gamma1, w).q, 0.0)
    return PinnedDepths(np.zeros_like(largest)[()], largest)
