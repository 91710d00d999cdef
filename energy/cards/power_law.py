"""Power-law profile f = c|x|ⁿ, n >= 1: Eqs. (11) and (16) beyond the paper's n = 1 and 2.

n = 1 is the wedge with tan δ = c, tip-pinned range included; n = 2 the parabola with
R = 1/(2c). For n > 1 the line is free on the whole branch d >= −δ₀, if at a half-width below the
range of float64 for n next to 1: then u_a = d and P = 2kld, as for a wedge pinned at its tip.

Conventions: the depth d of the lowest point and displacements u are positive into the layer, forces
P per length where the indenter is pressed. The lines are at ±a, with the displacement
u_a = d − c aⁿ there; l = √(γ₁/k) (`elastocapillary_length`), δ₀ = √(2w/k) (`critical_separation`),
both in m; q = lc − δ₀ for n = 1. All arguments but n broadcast.

Imported: `joined(x, a, inside, u_a, l)` is `inside` where |x| <= a, and beyond the surface that
decays from u_a. `Values` is a float for numbers, an array for arrays.
`excess(name, value, bound, remedy)` is value − bound, 0 where it is negative by rounding, and an
error below. `refuse(name, value, bad, remedy)` raises ValueError where `bad` is true. `not_zero`
puts 1 in place of 0, for divisors of terms that are 0 there. `unwrap` makes a number of an array
without axes. `finite`, `positive` and `non_negative` check an argument, whose name comes first, and
return it as float64. `scale` of `excess` is the size of the terms whose difference the bound is:
their rounding counts, too. `[()]` makes a numpy number of an array without axes, which overflows to
inf and divides by 0 as arrays do; Python's floats would raise.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import (
    Array,
    excess,
    finite,
    non_negative,
    not_zero,
    positive,
    refuse,
    unwrap,
)
from energy.cards._surface import joined
from energy.cards._types import Values
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length

# Newton's method for the half-width ends where the logarithm of its equation is off by no more than
# this many roundings (2.2e-16), or n if that is more: the power is off by 1, the sum and product by
# ½ each, and the rounding of t makes n/2. These 2 + n/2 are below the limit by a fourth or more.
_ROUNDINGS = 8
# It takes at most 22 steps for n from 1 + 1e-9 to 300, and ratios of l to the half-width without
# tension from 1e-12 to 1e12.
_MOST_STEPS = 100


class _Parameters(NamedTuple):
    """The checked arguments of a card.

    Attributes
    ----------
    c : ndarray
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ].
    n : float
    ell, delta0 : ndarray
        l and δ₀ [m].
    """

    c: Array
    n: float
    ell: Array
    delta0: Array


class _Line(NamedTuple):
    """A contact line at a depth.

    Attributes
    ----------
    half_width : ndarray
        a [m].
    displacement : ndarray
        u_a [m].
    """

    half_width: Array
    displacement: Array


def _parameters(
    c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> _Parameters:
    """The arguments, checked; ValueError for n < 1, an array n, c <= 0, k <= 0, γ₁ < 0 or w < 0."""
    exponent = finite("n", n)
    refuse("n", exponent, exponent < 1.0, "must be >= 1: a cusp has no small slopes")
    if np.ndim(exponent) > 0:
        raise ValueError(f"n = {n!r} must be one number: loop over exponents")
    ell = elastocapillary_length(k, gamma1)
    delta0 = critical_separation(k, w)
    ell = np.asarray(ell)[()]
    delta0 = np.asarray(delta0)[()]
    return _Parameters(positive("c", c), float(exponent), ell, delta0)


def _root(level: Array, n: float, ell: Array) -> Array:
    """Half-width a >= 0 with a^(n−1) (a + nl) = level, for n > 1: Eq. (16) of f = c|x|ⁿ.

    `level` is (d + δ₀)/c >= 0 [mⁿ]. With a = t level^(1/n) and ρ = nl/level^(1/n), t is the root
    of t^(n−1) (t + ρ) = 1. In ln t the logarithm of the left side is convex and increasing, so
    Newton's steps from min(1, ρ^(−1/(n−1))), which is never below the root, decrease to it. A t
    below the range of float64 makes a = 0; RuntimeError after _MOST_STEPS.
    """
    tolerance = max(_ROUNDINGS, n) * float(np.finfo(np.float64).eps)
    with np.errstate(over="ignore", under="ignore", divide="ignore"):
        without_tension = level ** (1.0 / n)  # the half-width for l = 0
        rho = np.where(level > 0.0, n * ell / not_zero(without_tension), 0.0)
        start = np.maximum(rho, 1.0) ** (-1.0 / (n - 1.0))
    vanishing = start < np.finfo(np.float64).tiny
    # Entries that vanish are iterated with t = 1 and ρ = 0, the root of which is 1.
    t = np.where(vanishing, 1.0, start)
    rho = np.where(vanishing, 0.0, rho)
    for _ in range(_MOST_STEPS):
        residual = np.log(t ** (n - 1.0) * (t + rho))
        slope = n - 1.0 + t / (t + rho)  # d(residual)/d(ln t)
        t = t * np.exp(-residual / slope)
        if np.all(np.abs(residual) <= tolerance):
            return unwrap(np.where(vanishing, 0.0, t * without_tension))
    raise RuntimeError(f"no half-width after {_MOST_STEPS} steps for n = {n}: rescale the units")


def _state(d: ArrayLike, c: Array, n: float, ell: Array, delta0: Array) -> _Line:
    """The line at depth d; ValueError below `detachment_depth`.

    u_a = l f'(a) − δ₀ by Eq. (16) on a free line. It is d where a = 0: pinned at the tip of a wedge
    between d = 0 and q > 0, or at an a too small for a float. q = lc − δ₀ is a difference, which
    may be off by roundings of lc however small it is.
    """
    depth = finite("d", d)
    remedy = "the contact has let go, pass d >= detachment_depth(...)"
    if n > 1.0:
        level = excess("d", depth, -delta0, remedy) / c
        a = np.asarray(_root(level, n, ell))[()]
        free = ell * n * c * a ** (n - 1.0) - delta0
        return _Line(a, np.where(a > 0.0, free, depth)[()])
    q = ell * c - delta0
    excess("d", depth, np.minimum(q, 0.0), remedy, scale=ell * c)
    return _Line(np.maximum(depth - q, 0.0) / c, np.minimum(depth, q))


def half_width(
    d: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Half-width of the contact at a depth.

    a of c aⁿ + l n c a^(n−1) = d + δ₀, Eq. (16); 0 for n = 1 pinned at the tip.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        a [m].

    Raises
    ------
    ValueError
        Below `detachment_depth`, and for n < 1 and other parameters out of range.
    """
    c, n, ell, delta0 = _parameters(c, n, k, gamma1, w)
    return _state(d, c, n, ell, delta0).half_width


def depth(
    a: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at which a line rests at a half-width.

    d = c aⁿ + l n c a^(n−1) − δ₀, Eq. (16). For n = 1 and a = 0 this is q = lc − δ₀, the depth from
    which on the line leaves the tip.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].

    Raises
    ------
    ValueError
        For a < 0, and parameters out of range.
    """
    c, n, ell, delta0 = _parameters(c, n, k, gamma1, w)
    a = non_negative("a", a)
    return c * a ** (n - 1.0) * (a + n * ell) - delta0


def displacement(
    x: ArrayLike,
    *,
    d: ArrayLike,
    c: ArrayLike,
    n: float,
    k: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
) -> Values:
    """Displacement of the surface under the indenter and beside it.

    u = d − c|x|ⁿ in contact, u_a exp(−(|x| − a)/l) outside, Eqs. (4), (6), (13).

    u_a = l n c a^(n−1) − δ₀; u_a = d for n = 1 pinned at the tip.

    Parameters
    ----------
    x : array_like
        Positions [m].
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        u [m], of the common shape of all arguments.

    Raises
    ------
    ValueError
        As `half_width`.
    """
    c, n, ell, delta0 = _parameters(c, n, k, gamma1, w)
    x = finite("x", x)
    a, u_a = _state(d, c, n, ell, delta0)
    inside = finite("d", d) - c * np.abs(x) ** n
    return joined(x, a, inside, u_a, ell)


def force(
    d: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force at a depth.

    P = 2k ((a + l) u_a + c a^(n+1) n/(n + 1)), Eq. (11), u_a as in `displacement`.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N/m], compressive forces positive.

    Raises
    ------
    ValueError
        As `half_width`.
    """
    c, n, ell, delta0 = _parameters(c, n, k, gamma1, w)
    a, u_a = _state(d, c, n, ell, delta0)
    pressed = c * a ** (n + 1.0) * (n / (n + 1.0))
    return 2.0 * positive("k", k) * (pressed + (a + ell) * u_a)


def energy(
    d: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Energy of the layer.

    U = ∫_{−a}^{a} (k/2 (d − f)² + γ₁/2 f'²) dx + k l u_a² − 2wa, in closed form.

    With s = l f'(a) = l n c a^(n−1) and v = a f'(a) = n c aⁿ: U = k (l u_a² + a s (s − 2δ₀)
    + 2 a u_a v/(n + 1) + 2 a v²/((n + 1)(2n + 1)) + a s²/(2n − 1)). P = dU/dd.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        U [J/m]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        As `half_width`.
    """
    c, n, ell, delta0 = _parameters(c, n, k, gamma1, w)
    a, u_a = _state(d, c, n, ell, delta0)
    s = ell * n * c * a ** (n - 1.0)
    v = c * a**n * n
    # Terms over k, and those of the contact over a: the springs' share that depends on x; the
    # springs' share u_a² with adhesion, −δ₀², and the tension of the contact, s²/(2n − 1).
    varying = 2.0 * v * (u_a + v / (2.0 * n + 1.0)) / (n + 1.0)
    uniform = s * (s - 2.0 * delta0) + s**2 / (2.0 * n - 1.0)
    free_surfaces = ell * u_a**2
    return positive("k", k) * (a * (varying + uniform) + free_surfaces)


def detachment_depth(
    *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at which the contact vanishes under imposed depth.

    d where a → 0 under displacement control: −δ₀ for n > 1, min(lc − δ₀, 0) for n = 1.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].

    Raises
    ------
    ValueError
        For n < 1 and other parameters out of range.
    """
    c, n, ell, delta0 = _parameters(c, n, k, gamma1, w)
    least: Values = -delta0 if n > 1.0 else np.minimum(ell * c - delta0, 0.0)
    return least
