"""Contact angle and the condition that places the contact line, Eqs. (1), (8), (12)-(18).

Within the small-slope energy Eq. (16) is exact for every γ₁ >= 0, γ₁ = 0 included: it is the
condition that the energy be stationary in the half-width. Section 6 of the paper limits it to
2w ≪ γ₁ because the slope √(2w/γ₁) at the line has to be small for that energy to apply.

Conventions: the contact is on the left of its line at x = a > 0. Heights f are positive upwards,
the depth d of the level f = 0 and displacements u downwards, so that u_a = d − f(a) at the line. θ
is the angle in the outer medium, π where the surface is smooth. l = √(γ₁/k), δ₀ = √(2w/k).

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `slope_at_line(u_a)` is the slope −u_a/l of the free surface. `Values` is a float for
numbers, an array for arrays. `excess(name, value, bound, remedy)` is value − bound, 0 where it is
negative by rounding, and an error below. `refuse(name, value, bad, remedy)` raises ValueError where
`bad` is true. `unwrap` makes a number of an array without axes. `finite`, `positive` and
`non_negative` check an argument, whose name comes first, and return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import excess, finite, non_negative, positive, refuse, unwrap
from energy.cards._types import Values
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length, slope_at_line


def work_of_adhesion(gamma1: ArrayLike, gamma2: ArrayLike, gamma12: ArrayLike) -> Values:
    """Work of adhesion.

    w = γ₁ + γ₂ − γ₁₂, Eqs. (1) and (17).

    Parameters
    ----------
    gamma1, gamma2, gamma12 : array_like
        Surface tension [N/m], energy of the indenter's surface [J/m²] and energy of the interface
        [J/m²].

    Returns
    -------
    float or ndarray
        w [J/m²].

    Raises
    ------
    ValueError
        For γ₁ < 0.
    """
    return non_negative("gamma1", gamma1) + finite("gamma2", gamma2) - finite("gamma12", gamma12)


def angle(gamma1: ArrayLike, gamma2: ArrayLike, gamma12: ArrayLike) -> Values:
    """Contact angle of Young's law, at any slope.

    γ₁₂ + γ₁ cos θ − γ₂ = 0, Eq. (8).

    Evaluated as π − 2 asin √(w/(2γ₁)), which keeps its digits near θ = π.

    Parameters
    ----------
    gamma1, gamma2, gamma12 : array_like
        Surface tension [N/m], energy of the indenter's surface [J/m²] and energy of the interface
        [J/m²].

    Returns
    -------
    float or ndarray
        θ [rad].

    Raises
    ------
    ValueError
        For γ₁ <= 0 and where no angle exists: w < 0 or w > 2γ₁.
    """
    gamma1 = positive("gamma1", gamma1)
    w = np.asarray(work_of_adhesion(gamma1, gamma2, gamma12))
    # w is a sum of three terms that cancel, each of them rounded by whoever computed it.
    roundings = 8 * np.finfo(np.float64).eps * (gamma1 + np.abs(gamma2) + np.abs(gamma12))
    refuse("w = gamma1 + gamma2 - gamma12", w, w < -roundings, "must be >= 0: lower gamma12")
    above = w > 2.0 * gamma1 + roundings
    refuse("w = gamma1 + gamma2 - gamma12", w, above, "exceeds 2 gamma1: no angle, lower gamma2")
    return np.pi - angle_deficit(unwrap(np.clip(w, 0.0, 2.0 * gamma1)), gamma1)


def angle_deficit(w: ArrayLike, gamma1: ArrayLike) -> Values:
    """Deficit of the contact angle of Young's law from π, at any slope.

    π − θ = 2 asin √(w/(2γ₁)), the exact solution of Eq. (8).

    Parameters
    ----------
    w, gamma1 : array_like
        Work of adhesion [J/m²] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        π − θ [rad].

    Raises
    ------
    ValueError
        For w < 0, γ₁ <= 0, or w > 2γ₁, where Eq. (8) has no solution.
    """
    w = non_negative("w", w)
    gamma1 = positive("gamma1", gamma1)
    refuse("w", w, w > 2.0 * gamma1, "exceeds 2 gamma1: Eq. (8) has no angle, pass w <= 2 gamma1")
    deficit: Values = 2.0 * np.arcsin(np.sqrt(0.5 * (w / gamma1)))
    return deficit


def angle_deficit_small(w: ArrayLike, gamma1: ArrayLike) -> Values:
    """Deficit of the contact angle from π, for small slopes.

    π − θ = α = √(2w/γ₁), Eq. (15), the small-slope form: the surface slope at a flat face.

    Too small by w/(12γ₁) relative to `angle_deficit`.

    Parameters
    ----------
    w, gamma1 : array_like
        Work of adhesion [J/m²] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        π − θ [rad].

    Raises
    ------
    ValueError
        For w < 0 or γ₁ <= 0.
    """
    alpha: Values = np.sqrt(2.0 * (non_negative("w", w) / positive("gamma1", gamma1)))
    return alpha


def boundary_condition(slope_f: ArrayLike, slope_u: ArrayLike) -> Values:
    """Contact angle between the slopes of indenter and free surface, for small slopes.

    θ = π − f'(a − 0) − u'(a + 0), Eq. (12).

    Parameters
    ----------
    slope_f : array_like
        Slope of the profile at the line [1].
    slope_u : array_like
        Slope of the free surface at the line [1].

    Returns
    -------
    float or ndarray
        θ [rad].
    """
    return np.pi - finite("slope_f", slope_f) - finite("slope_u", slope_u)


def boundary_residual(
    slope_a: ArrayLike, u_a: ArrayLike, theta: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike
) -> Values:
    """Residual of the condition on the contact angle, 0 at equilibrium.

    f'(a) + (C/l) exp(−a/l) + θ − π, Eq. (14), with C from Eq. (13): C exp(−a/l) = −u_a.

    Parameters
    ----------
    slope_a : array_like
        Slope of the profile at the line [1].
    u_a : array_like
        Displacement of the surface at the line [m].
    theta : array_like
        Contact angle θ [rad].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        [rad].

    Raises
    ------
    ValueError
        For k <= 0 or γ₁ <= 0.
    """
    slope_of_surface = slope_at_line(u_a, k=k, gamma1=gamma1)  # u'(a + 0) = −u_a/l
    kink = finite("slope_a", slope_a) + slope_of_surface
    return kink + (finite("theta", theta) - np.pi)


def line_residual(
    d: ArrayLike,
    f_a: ArrayLike,
    slope_a: ArrayLike,
    *,
    k: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
) -> Values:
    """Residual of the condition that places the contact line, 0 at equilibrium.

    f(a) − d − δ₀ + l f'(a), Eq. (16), positive where the line recedes.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    f_a : array_like
        Height of the profile at the line [m].
    slope_a : array_like
        Slope of the profile at the line [1].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        [m].

    Raises
    ------
    ValueError
        For k <= 0, γ₁ < 0 or w < 0.
    """
    return depth(f_a, slope_a, k=k, gamma1=gamma1, w=w) - finite("d", d)


def depth(
    f_a: ArrayLike, slope_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at which a contact line rests.

    d = f(a) + l f'(a) − δ₀: Eq. (16) solved for the depth.

    Parameters
    ----------
    f_a : array_like
        Height of the profile at the line [m].
    slope_a : array_like
        Slope of the profile at the line [1].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].

    Raises
    ------
    ValueError
        As `line_residual`.
    """
    ell = elastocapillary_length(k, gamma1)
    delta0 = critical_separation(k, w)
    return finite("f_a", f_a) + (ell * finite("slope_a", slope_a) - delta0)


def cut_level(d: ArrayLike, *, k: ArrayLike, w: ArrayLike) -> Values:
    """Height at which the contact ends without surface tension.

    f(a) = d + δ₀, Eq. (18): where the profile is cut if γ₁ = 0.

    For profiles with f >= 0.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    k, w : array_like
        Stiffness of the foundation [N/m³] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        f(a) [m].

    Raises
    ------
    ValueError
        For d < −δ₀, where nothing is left to cut.
    """
    remedy = "the contact has detached, pass d >= -sqrt(2w/k)"
    return excess("d", finite("d", d), -critical_separation(k, w), remedy)
