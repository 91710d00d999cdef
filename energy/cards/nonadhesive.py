"""Contact without adhesion, w = 0, Eqs. (34)-(40): a layer under a stretched membrane.

The surface leaves the indenter without a kink. Contact exists for d >= 0 (profiles with
f(0) = 0), and the tension makes it narrower and stiffer.

Conventions: heights f are positive upwards, the depth d of the level f = 0 and displacements u
downwards, forces P per length where the indenter is pressed. The lines are at ±a, u_a = d − f(a) is
the displacement there, l = √(γ₁/k), and C = −u_a exp(a/l) is the constant of Eq. (13).

Imported: `elastocapillary_length(k, gamma1)` is l = √(γ₁/k). `slope_at_line(u_a)` is the slope
−u_a/l of the free surface. `_line_residual` is f(a) + l f'(a) − d − δ₀ of Eq. (16). `Values` is a
float for numbers, an array for arrays. `excess(name, value, bound, remedy)` is value − bound, 0
where it is negative by rounding, and an error below. `not_zero` puts 1 in place of 0, for divisors
of terms that are 0 there. `finite`, `positive` and `non_negative` check an argument, whose name
comes first, and return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import excess, finite, non_negative, not_zero, positive
from energy.cards._types import Values
from energy.cards.contact_line import line_residual as _line_residual
from energy.cards.tail import elastocapillary_length, slope_at_line

_REMEDY = "without adhesion there is no contact, pass d >= 0"


def interfacial_energy(gamma1: ArrayLike, gamma2: ArrayLike) -> Values:
    """Energy of the interface for which nothing adheres.

    γ₁₂ = γ₁ + γ₂, Eq. (34).

    Parameters
    ----------
    gamma1, gamma2 : array_like
        Surface tension [N/m] and energy of the indenter's surface [J/m²].

    Returns
    -------
    float or ndarray
        γ₁₂ [J/m²].

    Raises
    ------
    ValueError
        For γ₁ < 0.
    """
    return non_negative("gamma1", gamma1) + finite("gamma2", gamma2)


def contact_angle() -> float:
    """Contact angle without adhesion.

    θ = π, Eq. (35).

    Returns
    -------
    float
        θ [rad].
    """
    return float(np.pi)


def slope_jump(slope_a: ArrayLike, u_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Kink of the surface at the line, 0 at equilibrium.

    f'(a) + (C/l) exp(−a/l) = f'(a) − u_a/l, Eq. (36).

    Parameters
    ----------
    slope_a : array_like
        Slope of the profile at the line [1].
    u_a : array_like
        Displacement of the surface at the line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        [1].

    Raises
    ------
    ValueError
        For k <= 0 or γ₁ <= 0.
    """
    return finite("slope_a", slope_a) + slope_at_line(u_a, k=k, gamma1=gamma1)


def line_residual(
    d: ArrayLike, f_a: ArrayLike, slope_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike
) -> Values:
    """Residual of the condition that places the contact line, 0 at equilibrium.

    f(a) − d + l f'(a), Eq. (37).

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    f_a : array_like
        Height of the profile at the line [m].
    slope_a : array_like
        Slope of the profile at the line [1].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        [m].

    Raises
    ------
    ValueError
        For k <= 0 or γ₁ < 0.
    """
    return _line_residual(d, f_a, slope_a, k=k, gamma1=gamma1, w=0.0)


def parabola_residual(
    a: ArrayLike, d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike
) -> Values:
    """Residual of the quadratic equation for the half-width under a parabola.

    a² + 2al − 2Rd, Eq. (38): 2R times `line_residual` of a parabola.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    R, k, gamma1 : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        [m²].

    Raises
    ------
    ValueError
        For a < 0.
    """
    a = non_negative("a", a)
    ell = elastocapillary_length(k, gamma1)
    return a * (a + 2.0 * ell) - 2.0 * positive("R", R) * finite("d", d)


def parabola_half_width(d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Half-width of the contact under a parabola.

    a = −l + √(2Rd + l²), Eq. (39), evaluated without the difference.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    R, k, gamma1 : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        a [m].

    Raises
    ------
    ValueError
        For d < 0.
    """
    d = excess("d", finite("d", d), 0.0, _REMEDY)
    ell = elastocapillary_length(k, gamma1)
    chord = np.sqrt(2.0 * positive("R", R) * d)
    divisor = ell + np.hypot(ell, chord)  # 0 where d and l are, and a with them
    a: Values = chord * (chord / not_zero(divisor))
    return a


def parabola_force(d: ArrayLike, *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Force on a parabola.

    P = (2k/3R) ((2Rd + l²)^(3/2) − l³), Eq. (40), evaluated without the difference.

    With b = √(2Rd + l²): b³ − l³ = 2Rd (b² + bl + l²)/(b + l).

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    R, k, gamma1 : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.

    Raises
    ------
    ValueError
        For d < 0.
    """
    d = excess("d", finite("d", d), 0.0, _REMEDY)
    ell = elastocapillary_length(k, gamma1)
    k = positive("k", k)
    R = positive("R", R)
    b = np.hypot(ell, np.sqrt(2.0 * R * d))
    divisor = not_zero(b + ell)  # 0 where d and l are, and P with them
    force: Values = 4.0 * k * d * (b**2 + b * ell + ell**2) / (3.0 * divisor)
    return force
