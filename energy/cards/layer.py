"""Limits of a bonded elastic layer with its exact response, and Eq. (16) for a contact wide in it.

A sphere, f = r²/(2R), is pulled off with -P = c πwR. Where tension is weak, c is 3/2 on a half-
space (JKR: a ≪ h), 2 on a thin, compressible layer (springs: `axisymmetric.sphere` with γ₁ = 0),
and 3 on a thin, incompressible one (a ≫ h, ν = ½); where tension rules c is 1. A cylinder,
f = x²/(2R), is pulled off in plane strain, forces per length.

The half-space follows Johnson, Kendall, Roberts (1971) with E* = E/(1-ν²); without adhesion, w = 0,
it is Hertz's. The thin incompressible layer flows: what is displaced inside r leaves through it,

    -h³/(3G) p' 2πr = ∫₀ʳ u dA,    p(a) = 0,    w = h³/(6G) p'(a)²,

so that the displaced volume over the length of the line is -μ, μ = √(2wh³/(3G)), G = E/3.

Conventions: a is the radius of the contact under a sphere, its half-width under a cylinder;
profiles f are positive upwards, the depth d of their lowest point and the displacement u = d - f in
contact downwards; p is the pressure on the layer, p' = dp/dr, and P the force on the indenter,
positive pressed. l = √(γ₁/k) with the stiffness k of the springs (`stiffness`), δ₀ = √(2w/k), and
c₂ is that of k(q) = k (1 - c₂q²h² + ...) of the layer (`second_order`).

Imported: `elastocapillary_length(k, gamma1)` is l = √(γ₁/k). `_depth(f_a, slope_a)` is the depth
f(a) + l f'(a) − δ₀ of Eq. (16). `Values` is a float for numbers, an array for arrays.
`refuse(name, value, bad, remedy)` raises ValueError where `bad` is true. `unwrap` makes a number of
an array without axes. `finite`, `positive` and `non_negative` check an argument, whose name comes
first, and return it as float64.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, finite, non_negative, positive, refuse, unwrap
from energy.cards._types import PullOff, Values
from energy.cards.contact_line import depth as _depth
from energy.cards.foundation import stiffness
from energy.cards.tail import elastocapillary_length
from energy.layer import second_order


def half_space_modulus(E: ArrayLike, nu: ArrayLike) -> Values:
    """Plane-strain modulus of a half-space.

    E* = E/(1-ν²).

    Parameters
    ----------
    E, nu : array_like
        Young's modulus [Pa] and Poisson's ratio.

    Returns
    -------
    float or ndarray
        E* [Pa].

    Raises
    ------
    ValueError
        For E <= 0 or ν outside (-1, ½].
    """
    E = positive("E", E)
    nu = finite("nu", nu)
    refuse("nu", nu, (nu <= -1.0) | (nu > 0.5), "must lie in (-1, 1/2]: pass Poisson's ratio")
    return E / (1.0 - nu**2)


def half_space_depth(
    a: ArrayLike, *, R: ArrayLike, E: ArrayLike, nu: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at a radius of the contact between a sphere and a half-space (JKR).

    d = a²/R - √(2πwa/E*).

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    R, E, nu, w : array_like
        Radius of curvature [m], Young's modulus [Pa], Poisson's ratio and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    a = non_negative("a", a)
    modulus = half_space_modulus(E, nu)
    lift = np.sqrt(2 * np.pi * non_negative("w", w) * a / modulus)
    return unwrap(a**2 / positive("R", R) - lift)


def half_space_force(
    a: ArrayLike, *, R: ArrayLike, E: ArrayLike, nu: ArrayLike, w: ArrayLike
) -> Values:
    """Force at a radius of the contact between a sphere and a half-space (JKR).

    P = 4E*a³/(3R) - √(8πwE*a³).

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    R, E, nu, w : array_like
        Radius of curvature [m], Young's modulus [Pa], Poisson's ratio and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.
    """
    a = non_negative("a", a)
    modulus = half_space_modulus(E, nu)
    pull = np.sqrt(8 * np.pi * non_negative("w", w) * modulus * a**3)
    return unwrap(4 * modulus * a**3 / (3 * positive("R", R)) - pull)


def half_space_pull_off(*, R: ArrayLike, E: ArrayLike, nu: ArrayLike, w: ArrayLike) -> PullOff:
    """The most tensile state of a sphere on a half-space (JKR).

    P = -(3/2)πwR at a³ = 9πwR²/(8E*).

    Parameters
    ----------
    R, E, nu, w : array_like
        Radius of curvature [m], Young's modulus [Pa], Poisson's ratio and work of adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N], d [m] and a [m].
    """
    R = positive("R", R)
    w = positive("w", w)
    a = np.cbrt(9 * np.pi * w * R**2 / (8 * half_space_modulus(E, nu)))
    return _state(-1.5 * np.pi * w * R, half_space_depth(a, R=R, E=E, nu=nu, w=w), a)


def _state(force: ArrayLike, d: ArrayLike, a: ArrayLike) -> PullOff:
    """Force, depth and half-width of pull-off, broadcast to one shape."""
    broadcast = np.array(np.broadcast_arrays(force, d, a), np.float64)
    return PullOff(*map(unwrap, broadcast))


def _flow(E: ArrayLike, h: ArrayLike, w: ArrayLike) -> tuple[Array, Array]:
    """G/h³ [N/m⁵] and μ = √(2wh³/(3G)) [m²] of an incompressible layer, G = E/3."""
    h3_over_G = np.asarray(positive("h", h)) ** 3 / (positive("E", E) / 3)
    mu = np.sqrt(2 / 3 * non_negative("w", w) * h3_over_G)
    return unwrap(1 / h3_over_G), unwrap(mu)


def incompressible_depth(
    a: ArrayLike, *, R: ArrayLike, E: ArrayLike, h: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at a radius of the contact between a sphere and a thin incompressible layer.

    d = a²/(4R) - 2μ/a, for ν = ½ and a ≫ h.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    R, E, h, w : array_like
        Radius of curvature [m], Young's modulus [Pa], thickness of the layer [m] and work of
        adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    a = positive("a", a)
    _, mu = _flow(E, h, w)
    return a**2 / (4 * positive("R", R)) - 2 * mu / a


def incompressible_force(
    a: ArrayLike, *, R: ArrayLike, E: ArrayLike, h: ArrayLike, w: ArrayLike
) -> Values:
    """Force at a radius of the contact between a sphere and a thin incompressible layer.

    P = πG/(32Rh³) (a⁶ - 24Rμa³).

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    R, E, h, w : array_like
        Radius of curvature [m], Young's modulus [Pa], thickness of the layer [m] and work of
        adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.
    """
    a = positive("a", a)
    R = positive("R", R)
    G_over_h3, mu = _flow(E, h, w)
    return np.pi * G_over_h3 / (32 * R) * (a**6 - 24 * R * mu * a**3)


def incompressible_pull_off(*, R: ArrayLike, E: ArrayLike, h: ArrayLike, w: ArrayLike) -> PullOff:
    """The most tensile state of a sphere on a thin incompressible layer.

    P = -3πwR at a³ = 12Rμ and d = μ/a.

    Parameters
    ----------
    R, E, h, w : array_like
        Radius of curvature [m], Young's modulus [Pa], thickness of the layer [m] and work of
        adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N], d [m] and a [m].
    """
    R = positive("R", R)
    w = positive("w", w)
    _, mu = _flow(E, h, w)
    a = np.cbrt(12 * R * mu)
    return _state(-3 * np.pi * w * R, mu / a, a)


def incompressible_cylinder_depth(
    a: ArrayLike, *, R: ArrayLike, E: ArrayLike, h: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at a half-width of the contact between a cylinder and a thin incompressible layer.

    d = a²/(6R) - μ/a.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    R, E, h, w : array_like
        Radius of curvature [m], Young's modulus [Pa], thickness of the layer [m] and work of
        adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    a = positive("a", a)
    _, mu = _flow(E, h, w)
    return a**2 / (6 * positive("R", R)) - mu / a


def incompressible_cylinder_pull_off(
    *, R: ArrayLike, E: ArrayLike, h: ArrayLike, w: ArrayLike
) -> PullOff:
    """The most tensile state of a cylinder on a thin incompressible layer.

    P = -(6G/(5h³)) μa² at a³ = 6Rμ and d = 0.

    The least of P = (G/h³)(2a⁵/(15R) - 2μa²).

    Parameters
    ----------
    R, E, h, w : array_like
        Radius of curvature [m], Young's modulus [Pa], thickness of the layer [m] and work of
        adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N/m], d [m] and a [m].
    """
    R = positive("R", R)
    w = positive("w", w)
    G_over_h3, mu = _flow(E, h, w)
    a = np.cbrt(6 * R * mu)
    force = -1.2 * G_over_h3 * mu * a**2  # 2a⁵/(15R) - 2μa² with a³ = 6Rμ
    return _state(force, 0.0, a)


def tension_force(a: ArrayLike, *, R: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Force on a sphere where surface tension dominates, a ≪ γ₁/E.

    P = 2πa (γ₁a/R - √(2wγ₁)): its line alone.

    The most tensile is at a = R √(w/(2γ₁)).

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    R, gamma1, w : array_like
        Radius of curvature [m], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.
    """
    a = non_negative("a", a)
    gamma1 = positive("gamma1", gamma1)
    pull = np.sqrt(2 * non_negative("w", w) * gamma1)
    return 2 * np.pi * a * (gamma1 * a / positive("R", R) - pull)


def tension_pull_off_force(*, R: ArrayLike, w: ArrayLike) -> Values:
    """Pull-off force of a sphere where surface tension dominates.

    P = -πwR, whatever lies below the surface.

    Parameters
    ----------
    R, w : array_like
        Radius of curvature [m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], < 0.
    """
    return -np.pi * positive("R", R) * non_negative("w", w)


def depth(
    f_a: ArrayLike,
    slope_a: ArrayLike,
    bend_a: ArrayLike,
    *,
    ell: ArrayLike,
    E: ArrayLike,
    nu: ArrayLike,
    h: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
) -> Values:
    """Depth at which a line rests on a layer with its exact response, a ≫ h and ν < ½.

    d = f(a) + ℓf'(a) + (ℓ² + c₂h² - l²) f''(a)/2 - δ₀: Eq. (16) of a layer, a ≫ h, ν < ½.

    By the method of Wiener and Hopf; for profiles whose f'' is constant, else with f''' and so on.
    ℓ is an integral over the layer's response; l and c₂ are as for the springs, on which ℓ = l.

    Parameters
    ----------
    f_a : array_like
        Height of the profile at the line [m].
    slope_a : array_like
        Slope of the profile at the line [1].
    bend_a : array_like
        Second derivative of the profile at the line [1/m].
    ell, E, nu, h, gamma1, w : array_like
        Length ℓ of `Scene.effective_length` [m], Young's modulus [Pa], Poisson's ratio, thickness
        of the layer [m], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
    """
    k = stiffness(E, nu, h)
    ell = finite("ell", ell)
    c2_h2 = second_order(finite("nu", nu)) * np.square(h)
    of_springs = np.square(elastocapillary_length(k, gamma1))  # l²
    of_height = _depth(f_a, 0.0, k=k, gamma1=gamma1, w=w)  # f(a) - δ₀
    of_slope = ell * finite("slope_a", slope_a)
    of_bend = (ell**2 + c2_h2 - of_springs) / 2 * finite("bend_a", bend_a)
    return of_height + of_slope + of_bend
