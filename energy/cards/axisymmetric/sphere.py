"""Sphere of radius R near its lowest point, f = r²/(2R): the parabola turned about its axis.

With the elastocapillary length l = √(γ₁/k) and the critical separation δ₀ = √(2w/k):

    s = a/l,   q(s) = K₀(s)/K₁(s),   growth(s) = s² dq/ds = s² (q² − 1) + sq,   δ = Rδ₀/l² = 1/Λ².

As Λ = l/√(Rδ₀) grows from springs (Λ → 0) to surface tension (Λ → ∞), the pull-off force falls
smoothly from 2πRw to πRw. The line contact has a kink at Λ = 1 there; a sphere has none, since its
line always detaches at a > 0.

Conventions: a is the radius of the contact. The depth d of the lowest point and displacements u are
positive into the layer, forces P where the sphere is pressed. `decay` is q. Arguments broadcast,
and raise ValueError where they are out of range; the cards of `power_law` are those of f = c rⁿ.

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `scaled(a, l)` is s = a/l, and ∞ where l = 0. `crossing(function, lower, upper)` is
where a function of a radius becomes positive. `Values` is a float for numbers, an array for arrays.
`unwrap` makes a number of an array without axes. `positive` and `non_negative` check an argument,
whose name comes first, and return it as float64.

A `Jump` has the force, depth and radius of the contact and `energy_released`, >= 0; a `PullOff` the
first three.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, non_negative, positive, unwrap
from energy.cards._types import Jump, PullOff, Values
from energy.cards.axisymmetric import power_law
from energy.cards.axisymmetric._bessel import decay, growth, scaled
from energy.cards.axisymmetric._roots import crossing
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length

# Where `pull_off` looks for a. At its root a³ <= (2a + 2l + l/2) Rδ₀, since q <= 1 and growth <= ½.
# Of 2a and 5l/2 one is the larger: a <= 2√(Rδ₀) where it is 2a, a³ <= 5l Rδ₀ where it is 5l/2.
_MOST_WITHOUT_TENSION = 2.0  # of √(Rδ₀)
_MOST_WITH_TENSION = 5.0  # of l Rδ₀, the cube of a radius


class _Lengths(NamedTuple):
    """What the formulas of a sphere are made of.

    Attributes
    ----------
    R, ell, delta0 : ndarray
        R, l and δ₀ [m].
    R_delta0 : ndarray
        Rδ₀ [m²].
    """

    R: Array
    ell: Array
    delta0: Array
    R_delta0: Array


def _lengths(R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> _Lengths:
    """The lengths from checked arguments."""
    ell = elastocapillary_length(k, gamma1)
    delta0 = critical_separation(k, w)
    R = positive("R", R)
    return _Lengths(R, np.asarray(ell)[()], np.asarray(delta0)[()], R * delta0)


def _as_power_law(R: ArrayLike) -> dict[str, Any]:
    """The arguments c and n that make f = c rⁿ this sphere."""
    return {"c": 0.5 / positive("R", R), "n": 2.0}


def radius(d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Radius of the contact at a depth, on the branch where it grows with the depth.

    The a at which `depth` is d.

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
        Below that of `detachment`.
    """
    return power_law.radius(d, **_as_power_law(R), k=k, gamma1=gamma1, w=w)


def depth(a: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Depth at which a line rests at a radius, stable or not.

    d = a²/(2R) − (δ₀ − la/R) q, for a > 0.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
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
        For a <= 0.
    """
    R, ell, delta0, _ = _lengths(R, k, gamma1, w)
    return unwrap(_depth(positive("a", a), R, ell, delta0))


def displacement(
    x: ArrayLike, *, d: ArrayLike, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Displacement of the surface under a sphere and beside it.

    u = d − x²/(2R) in contact, (d − a²/(2R)) K₀(|x|/l)/K₀(a/l) outside.

    Parameters
    ----------
    x : array_like
        Distances from the axis [m].
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
        As `radius`.
    """
    return power_law.displacement(x, d=d, **_as_power_law(R), k=k, gamma1=gamma1, w=w)


def force(d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Force on a sphere at a depth.

    `force_of_radius` at `radius`.

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
        P [N], compressive forces positive.

    Raises
    ------
    ValueError
        Below the depth of `detachment`.
    """
    a = np.asarray(radius(d, R=R, k=k, gamma1=gamma1, w=w))
    R, ell, _, R_delta0 = _lengths(R, k, gamma1, w)
    return unwrap(_force(a, R, ell, R_delta0, positive("k", k)))


def force_of_radius(
    a: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force on a sphere at a radius.

    P = (πk/R)(a⁴/4 − (a²q + 2al)(Rδ₀ − la)), a > 0.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.

    Raises
    ------
    ValueError
        For a <= 0.
    """
    R, ell, _, R_delta0 = _lengths(R, k, gamma1, w)
    return unwrap(_force(positive("a", a), R, ell, R_delta0, positive("k", k)))


def _force(a: Array, R: Array, ell: Array, R_delta0: Array, k: Array) -> Array:
    """P [N] at a radius, the formula of `force_of_radius`."""
    q = decay(scaled(a, ell))
    pressed = a**4 / 4.0
    pulled = a * (a * q + 2.0 * ell) * (R_delta0 - ell * a)
    return np.pi * k / R * (pressed - pulled)


def _depth(a: Array, R: Array, ell: Array, delta0: Array) -> Array:
    """d [m] at a radius, the formula of `depth`."""
    return a**2 / (2.0 * R) - (delta0 - ell * a / R) * decay(scaled(a, ell))


def energy(d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy of the layer under a sphere, −πwa² of adhesion included.

    P = dU/dd.

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
        U [J]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        Below the depth of `detachment`.
    """
    return power_law.energy(d, **_as_power_law(R), k=k, gamma1=gamma1, w=w)


def pull_off(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> PullOff:
    """The most tensile state, where a dead load detaches the contact.

    s³/δ − (3sq + s²(q² − 1) + 2)(1 − s/δ) + (s²q + 2s)/δ = 0, δ = Rδ₀/l². γ₁ = 0 is allowed.

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N], d [m] and a [m].
    """
    R, ell, delta0, R_delta0 = _lengths(R, k, gamma1, w)

    def slope_of_force(a: Array) -> Array:
        """(R/(πk)) dP/da."""
        s = scaled(a, ell)
        q = decay(s)
        steeper = ell * growth(s) + 2.0 * a * q + 2.0 * ell
        return a**3 - steeper * (R_delta0 - ell * a) + ell * a * (a * q + 2.0 * ell)

    without_tension = _MOST_WITHOUT_TENSION * np.sqrt(R_delta0)
    with_tension = (_MOST_WITH_TENSION * ell * R_delta0) ** (1.0 / 3.0)
    top = np.maximum(without_tension, with_tension)
    a = crossing(slope_of_force, np.zeros_like(top), top)
    d = _depth(a, R, ell, delta0)
    force = _force(a, R, ell, R_delta0, positive("k", k))
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
        F_A [N], >= 0.
    """
    return -pull_off(R=R, k=k, gamma1=gamma1, w=w).force


def adhesion_force_stiff(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Largest pull that the contact bears on springs with little tension, Λ → 0.

    2πRw (1 − Λ/√2 − 3Λ²/32).

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N], >= 0.

    Raises
    ------
    ValueError
        For w <= 0.
    """
    R, ell, _, R_delta0 = _lengths(R, k, gamma1, positive("w", w))
    ratio = ell / np.sqrt(R_delta0)
    return unwrap(2 * np.pi * R * np.asarray(w) * (1 - ratio / np.sqrt(2) - 3 / 32 * ratio**2))


def adhesion_force_liquid(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Largest pull that the contact bears where surface tension dominates, Λ → ∞.

    πRw (1 + (ln 4Λ² − γ_E − ¼)/(8Λ⁴)).

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N], >= 0.

    Raises
    ------
    ValueError
        For gamma1 <= 0 or w <= 0.
    """
    R, ell, _, R_delta0 = _lengths(R, k, positive("gamma1", gamma1), positive("w", w))
    square = ell**2 / R_delta0
    more = (np.log(4.0 * square) - np.euler_gamma - 0.25) / (8.0 * square**2)
    return unwrap(np.pi * R * np.asarray(w) * (1.0 + more))


def detachment(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Detachment under imposed depth.

    (P, d, a, released) at the least depth, s + q = (δ − s)(q² + q/s − 1). P and a are those just
    before it; afterwards there is no contact.

    With tension always at a > 0, for γ₁ = 0 at a = 0 and d = −δ₀.

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N], d [m], a [m] and the energy released [J].
    """
    R, ell, delta0, R_delta0 = _lengths(R, k, gamma1, w)

    def slope_of_depth(a: Array) -> Array:
        """Ra² dD/da, D the `depth`."""
        s = scaled(a, ell)
        return a**2 * (a + ell * decay(s)) - ell * (R_delta0 - ell * a) * growth(s)

    top = (ell * R_delta0) ** (1.0 / 3.0)  # above the root, where a³ <= l Rδ₀/2 as growth <= ½
    a = crossing(slope_of_depth, np.zeros_like(top), top)
    d = _depth(a, R, ell, delta0)
    same = power_law.detachment(**_as_power_law(R), k=k, gamma1=gamma1, w=w)
    force = _force(a, R, ell, R_delta0, positive("k", k))
    return Jump.of(force, d, a, same.energy_released)


def detachment_depth_stiff(
    *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Depth of detachment under imposed depth on springs with little tension, Λ → 0.

    d ≈ −δ₀ (1 − ¾ (2Λ²)^(1/3)).

    Parameters
    ----------
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
        For w <= 0.
    """
    _, ell, delta0, R_delta0 = _lengths(R, k, gamma1, positive("w", w))
    return -delta0 * (1.0 - 0.75 * np.cbrt(2.0 * ell**2 / R_delta0))


def jump_in(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Jump into contact on touching at imposed depth.

    The contact jumps in at d = 0. P and a are those just after it; before, both are 0.

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N], d [m], a [m] and the energy released [J].
    """
    return power_law.jump_in(**_as_power_law(R), k=k, gamma1=gamma1, w=w)


def depth_without_adhesion(
    a: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike
) -> Values:
    """Depth at a radius of a contact that does not adhere.

    d = (a² + 2alq)/(2R), w = 0: Eq. (38) with the factor q.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    R, k, gamma1 : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        d [m].

    Raises
    ------
    ValueError
        For a < 0.
    """
    ell = np.asarray(elastocapillary_length(k, gamma1))
    a = non_negative("a", a)
    return unwrap(a * (a + 2.0 * ell * decay(scaled(a, ell))) / (2.0 * positive("R", R)))


def force_without_adhesion(
    a: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike
) -> Values:
    """Force at a radius of a contact that does not adhere.

    P = (πk/(4R)) (a⁴ + 4la³q + 8a²l²), w = 0.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    R, k, gamma1 : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.

    Raises
    ------
    ValueError
        For a < 0.
    """
    ell = np.asarray(elastocapillary_length(k, gamma1))
    a = non_negative("a", a)
    bracket = a**2 + 4.0 * ell * a * decay(scaled(a, ell)) + 8.0 * ell**2
    return unwrap(np.pi * positive("k", k) / (4.0 * positive("R", R)) * a**2 * bracket)
