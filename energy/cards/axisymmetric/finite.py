"""Menisci with finite slopes around a circular line: what the Young-Laplace equation tends to.

γ₁ times twice the mean curvature is k u: the surface of a liquid under gravity, with k for ρg and l
for its capillary length. It has no first integral; these are its limits, with the inclination φ of
the surface at the line. The height is counted from the flat surface, |u_a|.

Imported: `elastocapillary_length(k, gamma1)` is l = √(γ₁/k). `Values` is a float for numbers, an
array for arrays. `refuse(name, value, bad, remedy)` raises ValueError where `bad` is true. `unwrap`
makes a number of an array without axes. `finite` and `positive` check an argument, whose name comes
first, and return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, finite, positive, refuse, unwrap
from energy.cards._types import Values
from energy.cards.tail import elastocapillary_length


def _angle(phi: ArrayLike) -> Array:
    """φ [rad], checked to lie in (0, π/2)."""
    angle = finite("phi", phi)
    bad = (angle <= 0.0) | (angle >= np.pi / 2)
    refuse("phi", angle, bad, "must lie in (0, π/2): pass the inclination in rad")
    return angle


def height_narrow(phi: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Height of the meniscus around a narrow contact, a ≪ l.

    |u_a| = a sin φ (ln(4l/(a (1 + cos φ))) − γ_E), a ≪ l (Lo 1983); next a³/l² ln²(l/a).

    Parameters
    ----------
    phi : array_like
        Inclination of the surface at the line [rad], in (0, π/2).
    a : array_like
        Radius of the contact [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        u_a in magnitude [m].

    Raises
    ------
    ValueError
        For γ₁ = 0 and φ outside (0, π/2).
    """
    angle = _angle(phi)
    a = positive("a", a)
    ell = elastocapillary_length(k, positive("gamma1", gamma1))
    logarithm = np.log(4.0 * ell / (a * (1.0 + np.cos(angle))))
    return unwrap(a * np.sin(angle) * (logarithm - np.euler_gamma))


def height_wide(phi: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> Values:
    """Height of the meniscus around a wide contact, a ≫ l.

    |u_a| = 2l sin(φ/2) (1 − l (1 − cos³(φ/2))/(3a sin²(φ/2))), a ≫ l; next (l/a)².

    Parameters
    ----------
    phi : array_like
        Inclination of the surface at the line [rad], in (0, π/2).
    a : array_like
        Radius of the contact [m].
    k, gamma1 : array_like
        Stiffness of the foundation [N/m³] and surface tension [N/m].

    Returns
    -------
    float or ndarray
        u_a in magnitude [m].

    Raises
    ------
    ValueError
        For γ₁ = 0 and φ outside (0, π/2).
    """
    angle = _angle(phi)
    a = positive("a", a)
    ell = elastocapillary_length(k, positive("gamma1", gamma1))
    sine = np.sin(0.5 * angle)
    cosine = np.cos(0.5 * angle)
    of_curvature = (1.0 + cosine + cosine * cosine) / (1.0 + cosine)  # (1 − cos³)/sin² of φ/2
    return unwrap(2.0 * ell * sine * (1.0 - ell * of_curvature / (3.0 * a)))


def adhesion_force_small_sphere(*, R: ArrayLike, w: ArrayLike) -> Values:
    """Largest pull that a true sphere bears, R ≪ l, at any w <= 2γ₁.

    F_A = πRw.

    The largest 2πγ₁ R sin β sin(π − θ − β) over the polar angle β of the line, at β = (π − θ)/2.

    Parameters
    ----------
    R, w : array_like
        Radius of curvature [m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N], >= 0.
    """
    return np.pi * positive("R", R) * positive("w", w)
