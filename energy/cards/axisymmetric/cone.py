"""Cone f = r tan δ: the wedge turned about its axis. With t = tan δ and D = δ₀ − lt,

    d = a t − D q,    P = πk (a³t/3 − (a²q + 2al) D).

The line is never pinned at the tip, as that of a wedge is: for t >= α the radius grows from zero at
d = 0 and the cone does not adhere; for t < α it detaches at a > 0.

Conventions: a is the radius of the contact. The depth d of the tip and displacements u are positive
into the layer, forces P where the cone is pressed. l = √(γ₁/k), δ₀ = √(2w/k), α = √(2w/γ₁); with
s = a/l, `decay(s)` is q = K₀(s)/K₁(s) and `growth(s)` is s² q'(s), between 0 and ½. The surface is
displaced by −D q at the line. Arguments broadcast, and raise ValueError where out of range; those
of `power_law` are the cards of f = c rⁿ.

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `scaled(a, l)` is s = a/l, and ∞ where l = 0. `crossing(function, lower, upper)` is
where a function of a radius becomes positive. `wedge_slope(delta)` is tan δ. `Values` is a float
for numbers, an array for arrays. `unwrap` makes a number of an array without axes.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, positive, unwrap, wedge_slope
from energy.cards._types import Jump, PullOff, Values
from energy.cards.axisymmetric import power_law
from energy.cards.axisymmetric._bessel import decay, growth, scaled
from energy.cards.axisymmetric._roots import crossing
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length

# Where `pull_off` looks for a. At its root a² tan δ <= (2a + 2l + l/2) D, since q <= 1 and
# growth <= ½. Of 2a and 5l/2 one is the larger: a <= 4D/tan δ where it is 2a, a² <= 5l D/tan δ
# where it is 5l/2.
_MOST_WITHOUT_TENSION = 4.0  # of D/tan δ
_MOST_WITH_TENSION = 5.0  # of l D/tan δ, the square of a radius


class _Lengths(NamedTuple):
    """What the formulas of a cone are made of.

    Attributes
    ----------
    slope : ndarray
        tan δ [1].
    ell : ndarray
        l [m].
    driven : ndarray
        D = δ₀ − l tan δ [m]; negative for a cone that does not adhere.
    """

    slope: Array
    ell: Array
    driven: Array


def _lengths(delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> _Lengths:
    """The lengths from checked arguments."""
    slope = wedge_slope(delta)
    ell = np.asarray(elastocapillary_length(k, gamma1))[()]
    return _Lengths(slope, ell, unwrap(critical_separation(k, w) - ell * slope))


def _as_power_law(delta: ArrayLike) -> dict[str, Any]:
    """The arguments c and n that make f = c rⁿ this cone."""
    return {"c": wedge_slope(delta), "n": 1.0}


def radius(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Radius of the contact at a depth, on the branch where it grows with the depth.

    The a at which `depth` is d.

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
        Below that of `detachment`.
    """
    return power_law.radius(d, **_as_power_law(delta), k=k, gamma1=gamma1, w=w)


def depth(
    a: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at which a line rests at a radius, stable or not.

    d = a tan δ − D q, for a > 0.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    slope, ell, driven = _lengths(delta, k, gamma1, w)
    a = positive("a", a)
    return unwrap(slope * a - driven * decay(scaled(a, ell)))


def displacement(
    x: ArrayLike, *, d: ArrayLike, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Displacement of the surface under a cone and beside it.

    u = d − |x| tan δ in contact, (d − a tan δ) K₀(|x|/l)/K₀(a/l) outside.

    Parameters
    ----------
    x : array_like
        Distances from the axis [m].
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
        As `radius`.
    """
    return power_law.displacement(x, d=d, **_as_power_law(delta), k=k, gamma1=gamma1, w=w)


def force(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force on a cone at a depth.

    P at the radius of `radius`.

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
        P [N], compressive forces positive.
    """
    a = np.asarray(radius(d, delta=delta, k=k, gamma1=gamma1, w=w))
    return unwrap(_force(a, _lengths(delta, k, gamma1, w), positive("k", k)))


def force_of_radius(
    a: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force on a cone at a radius.

    P = πk (a³ tan δ/3 − (a²q + 2al) D), a > 0.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.
    """
    return unwrap(_force(positive("a", a), _lengths(delta, k, gamma1, w), positive("k", k)))


def _force(a: Array, lengths: _Lengths, k: Array) -> Array:
    """P [N] at a radius, the formula of the module."""
    slope, ell, driven = lengths
    q = decay(scaled(a, ell))
    return np.pi * k * (slope * a**3 / 3.0 - a * (a * q + 2.0 * ell) * driven)


def energy(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Energy of the layer under a cone.

    P = dU/dd.

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
        U [J]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        Below the depth of `detachment`.
    """
    return power_law.energy(d, **_as_power_law(delta), k=k, gamma1=gamma1, w=w)


def pull_off(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> PullOff:
    """The most tensile state (P, d, a): a² tan δ = l D (3sq + s²(q² − 1) + 2), s = a/l.

    All 0 for tan δ >= α.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N], d [m] and a [m].
    """
    lengths = _lengths(delta, k, gamma1, w)
    slope, ell, driven = lengths
    pulling = np.maximum(driven, 0.0)  # 0 for a cone that does not adhere, and a with it

    def slope_of_force(a: Array) -> Array:
        """dP/da/(πk)."""
        s = scaled(a, ell)
        steeper = ell * growth(s) + 2.0 * a * decay(s) + 2.0 * ell
        return slope * a**2 - steeper * pulling

    without_tension = _MOST_WITHOUT_TENSION * pulling / slope
    with_tension = np.sqrt(_MOST_WITH_TENSION * ell * pulling / slope)
    top = np.maximum(without_tension, with_tension)
    a = crossing(slope_of_force, np.zeros_like(top), top)
    d = slope * a - driven * decay(scaled(a, ell))
    force = _force(a, lengths, positive("k", k))
    return PullOff(unwrap(force), unwrap(np.asarray(d)), a)


def adhesion_force(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Largest pull that the contact bears.

    F_A = −P of `pull_off`.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N], >= 0.
    """
    return -pull_off(delta=delta, k=k, gamma1=gamma1, w=w).force


def adhesion_force_stiff(
    *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Largest pull that the contact bears on springs with little tension, l tan δ ≪ δ₀.

    (4/3) πk δ₀³/tan² δ (1 − ¾ l tan δ/δ₀).

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N], >= 0.
    """
    slope, ell, _ = _lengths(delta, k, gamma1, w)
    delta0 = critical_separation(k, w)
    bracket = delta0 - 0.75 * ell * slope
    return unwrap(4 / 3 * np.pi * positive("k", k) * (delta0 / slope) ** 2 * bracket)


def detachment(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Detachment under imposed depth.

    (P, d, a, released) at the least depth, l tan δ = D (q² + q/s − 1), under imposed depth.

    All 0 for tan δ >= α.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N], d [m], a [m] and the energy released [J].
    """
    return power_law.detachment(**_as_power_law(delta), k=k, gamma1=gamma1, w=w)


def jump_in(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Jump into contact on touching at imposed depth.

    The contact jumps in at d = 0; all 0 for tan δ >= α.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N], d [m], a [m] and the energy released [J].
    """
    return power_law.jump_in(**_as_power_law(delta), k=k, gamma1=gamma1, w=w)
