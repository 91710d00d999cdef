"""Finite slopes: the true surface length, Young's law exactly. Beyond the paper.

The free surface has the first integral k u²/2 = γ₁ (1 − cos φ), φ its inclination, or
u = 2l sin(φ/2), with l = √(γ₁/k) and u positive downwards: φ > 0 where the surface rises away from
the line, φ < 0 where it is pulled up at the line. There φ = β − (π − θ), β = atan f'(a); with
Young's angle θ of Eq. (8), and u = d − f(a), (16) becomes

    f(a) = d + 2l sin((π − θ − β)/2).

Range: surfaces that are graphs, |φ| < π/2, that is |u(a)| < √2 l; w <= 2γ₁. Heights f are positive
upwards, depths d downwards, forces where they press the indenter up. Positions are on the right of
a contact whose lines are at ±a. `angle_deficit(w, gamma1)` is π − θ.

Imported: `elastocapillary_length(k, gamma1)` is l = √(γ₁/k). `Values` is a float for numbers, an
array for arrays. `refuse(name, value, bad, remedy)` raises ValueError where `bad` is true. `unwrap`
makes a number of an array without axes. `finite`, `positive` and `non_negative` check an argument,
whose name comes first, and return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import finite, non_negative, positive, refuse, unwrap
from energy.cards._types import Values
from energy.cards.contact_line import angle_deficit
from energy.cards.tail import elastocapillary_length


def depth(
    f_a: ArrayLike, slope_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at which a contact line rests.

    d = f(a) − 2l sin((π − θ − atan f'(a))/2).

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
        For w > 2γ₁ or an overhang.
    """
    f = finite("f_a", f_a)
    beta = np.arctan(finite("slope_a", slope_a))
    pulled_up = np.asarray(angle_deficit(w, gamma1)) - beta  # −φ at the line
    overhanging = abs(pulled_up) >= np.pi / 2
    refuse("inclination", pulled_up, overhanging, "makes it overhang: pass a smaller w or slope")
    ell = elastocapillary_length(k, positive("gamma1", gamma1))
    return unwrap(f - 2 * ell * np.sin(pulled_up / 2))


def inclination(u_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Inclination of the free surface at the line.

    φ = 2 asin(u(a)/2l), of the sign of u(a).

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        φ [rad].

    Raises
    ------
    ValueError
        For |u(a)| >= √2 l.
    """
    ratio = finite("u_a", u_a) / elastocapillary_length(k, positive("gamma1", gamma1))
    refuse("u_a/l", ratio, abs(ratio) >= np.sqrt(2), "makes it overhang: pass |u_a| < √2 l")
    return unwrap(2 * np.arcsin(ratio / 2))


def surface_force(u_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Vertical force of both free surfaces on the indenter.

    2γ₁ sin φ, Eq. (10): negative, a pull downwards, where the surface is lifted, u(a) < 0.

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
    """
    phi = np.asarray(inclination(u_a, k=k, gamma1=gamma1))
    return unwrap(2 * np.asarray(gamma1, float) * np.sin(phi))


def tail_energy(u_a: ArrayLike, *, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Energy of one free surface.

    (4/3) γ₁ l (1 − cos³(φ/2)); → ½ √(kγ₁) u(a)² for small slopes.

    Parameters
    ----------
    u_a : array_like
        Displacement of the surface at the line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        Energy [J/m].
    """
    phi = np.asarray(inclination(u_a, k=k, gamma1=gamma1))
    s = np.sin(phi / 2)
    c = np.sqrt(1 - s * s)
    ell = elastocapillary_length(k, gamma1)
    gamma1 = np.asarray(gamma1, float)
    # 1 − c³ = s²/(1 + c) (1 + c + c²), which loses no digits where φ is small
    return unwrap(4 / 3 * gamma1 * ell * s * s / (1 + c) * (1 + c + c * c))


def meniscus(u: ArrayLike, *, u_a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Distance from the line at which the free surface has come down to a displacement.

    x − a = l [ln(tan(φ_a/4)/tan(φ/4)) + 2 cos(φ_a/2) − 2 cos(φ/2)], sin(φ/2) = |u|/2l.

    Parameters
    ----------
    u : array_like
        Displacement between 0 and u_a [m].
    u_a : array_like
        Displacement of the surface at the line [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        x − a [m], >= 0.

    Raises
    ------
    ValueError
        For u that is not between 0 and u_a, and for |u_a| >= √2 l.

    Notes
    -----
    Along the surface d|u|/dx = −tan φ, and |u| = 2l sin(φ/2) makes d|u| = l cos(φ/2) dφ, so that

        dx = −l cos(φ/2)/tan φ dφ = −l (1/(2 sin(φ/2)) − sin(φ/2)) dφ,

    which is minus the differential of l [ln tan(φ/4) + 2 cos(φ/2)].
    """
    ratio = finite("u", u) / finite("u_a", u_a)
    not_between = (ratio <= 0) | (ratio > 1)
    refuse("u/u_a", ratio, not_between, "must lie in (0, 1]: pass u between 0 and u_a")
    phi = np.abs(np.asarray(inclination(u, k=k, gamma1=gamma1)))
    phi_a = np.abs(np.asarray(inclination(u_a, k=k, gamma1=gamma1)))
    ell = elastocapillary_length(k, gamma1)
    logarithm = np.log(np.tan(phi_a / 4) / np.tan(phi / 4))
    return unwrap(ell * (logarithm + 2 * np.cos(phi_a / 2) - 2 * np.cos(phi / 2)))


def punch_surface_force_at_detachment(*, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Force of both free surfaces on a flat punch as it detaches.

    2√(w(2γ₁ − w)) at d = −δ₀, which stays the critical depth at any slope; w < γ₁. This is
    `surface_force` there in magnitude: a pull on the punch.

    Parameters
    ----------
    gamma1, w : array_like
        Surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        Force [N/m].
    """
    tension = positive("gamma1", gamma1)
    work = non_negative("w", w)
    # At u = −δ₀ = −√(2w/k) the inclination has 1 − cos φ = w/γ₁, and is π/2 for w = γ₁.
    refuse("w", work, work >= tension, "makes the surface overhang: pass w < gamma1")
    return unwrap(2 * np.sqrt(work * (2 * tension - work)))
