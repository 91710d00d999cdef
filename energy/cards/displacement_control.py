"""Loops under displacement control: jump-in on touching, detachment, loop area.

Without long-range attraction contact begins on touching, at d = 0. The lines then run downhill in
energy at fixed depth: two lines at ±a that advance by da release

    −dU/da = 2w − γ₁ r² = k (δ₀² − (f + l f' − d)²),    r = f'(a) + (f(a) − d)/l,

r the kink of the surface, Eqs. (12)-(14). For f = c|x|ⁿ this is positive up to the root of Eq. (16)
and negative beyond it, so the state jumps from a = 0 to a(0). Retraction follows the adhered branch
down to `detachment_depth`, where the tails are all that is left and relax. A loop that starts
detached, is loaded to any d >= 0 and ends detached has the area ∮P dd = jump-in + detachment: the
branch itself is traversed both ways, whatever the largest depth.

A flat punch touches with its whole face and is pinned at the edges. A sharp wedge, tan δ > α, is
pinned at its tip for 0 < d < l tan δ − δ₀, never pulls, and has neither jump nor loop.
γ₁ = 0: springs attach one by one on touching, without a jump-in; `two_works` with w_closing = 0.

Imported: `elastocapillary_length(k, gamma1)` is l = √(γ₁/k). `wedge_slope(delta)` is tan δ.
`tail_energy(u_a)` is ½ √(kγ₁) u_a² of one free surface. `with_tension` refuses γ₁ = 0.
`touched(a, c, n)` is the jump of f = c|x|ⁿ at d = 0 to the half-width a. `Values` is a float for
numbers, an array for arrays. `positive` and `non_negative` check an argument, whose name comes
first, and return it as float64.

A `Jump` has the force, depth and half-width (`half_width`) of the contact, just after a jump-in or
just before a detachment, and `energy_released`, >= 0; a `PullOff` the first three. Of the cards of
one body, `force(d)` is P of the adhered branch, `half_width(d)` a; `flat_punch.force_at_detachment`
is P at −δ₀, and `flat_punch.global_pull_off_depth` the depth at which U = 0.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards import flat_punch, power_law
from energy.cards._checks import non_negative, positive, wedge_slope
from energy.cards._jumps import touched, with_tension
from energy.cards._types import Jump, PullOff, Values
from energy.cards.tail import elastocapillary_length
from energy.cards.tail import energy as tail_energy


def flat_punch_jump_in(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Jump into contact of a flat punch, in every control.

    (P, d, a, released) = (0, 0, a, 2wa): the face touches at once.

    `flat_punch.energy` at d = 0, with its sign changed. γ₁ = 0 is allowed.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].
    """
    released = -np.asarray(flat_punch.energy(0.0, a=a, k=k, gamma1=gamma1, w=w))
    return Jump.of(0.0, 0.0, a, released)


def flat_punch_detachment(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Detachment of a flat punch, under imposed depth and under a dead load.

    (P, d, a, released) = (P of Eq. (22), −δ₀, a, 2wl).

    U(−δ₀) = k (a + l) δ₀² − 2wa = klδ₀² = 2wl: the face unzips for nothing, the tails relax.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].
    """
    force = flat_punch.force_at_detachment(a=a, k=k, gamma1=gamma1, w=w)
    depth = flat_punch.detachment_depth(k=k, w=w)
    return Jump.of(force, depth, a, 2.0 * np.asarray(tail_energy(depth, k=k, gamma1=gamma1)))


def flat_punch_loop_area(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy dissipated in a loop of a flat punch, under imposed depth and under a dead load.

    ∮P dd = 2w (a + l); γ₁ = 0 is allowed.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        ∮P dd [J/m].
    """
    a = positive("a", a)
    ell = elastocapillary_length(k, gamma1)
    return 2.0 * non_negative("w", w) * (a + ell)


def flat_punch_global_pull_off(
    *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> PullOff:
    """State of a flat punch whose energy is that of the detached state (Maxwell point).

    (P, d, a) = (−2kδ₀√(a (a + l)), −δ₀√(a/(a + l)), a), where U = 0.

    The global minimum leaves the punch there; the metastable branch goes on to −δ₀.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N/m], d [m] and a [m].
    """
    depth = flat_punch.global_pull_off_depth(a=a, k=k, gamma1=gamma1, w=w)
    force = flat_punch.force(depth, a=a, k=k, gamma1=gamma1)
    state = Jump.of(force, depth, a, 0.0)  # all of one shape
    return PullOff(state.force, state.depth, state.half_width)


def flat_punch_barrier(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy barrier between the two states of a flat punch at the Maxwell point.

    kld² = 2wl a/(a + l), from either side.

    A contact of half-width x < a under the face has U = k (x + l) d² − 2wx, which falls with x for
    |d| < δ₀: the pass between adhered and detached is x → 0, of height kld². From the adhered side
    k a (δ₀² − d²) at any depth −δ₀ <= d <= 0, which vanishes at the metastable limit only.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        Energy [J/m].
    """
    depth = flat_punch.global_pull_off_depth(a=a, k=k, gamma1=gamma1, w=w)
    barrier: Values = 2.0 * np.asarray(tail_energy(depth, k=k, gamma1=gamma1))[()]
    return barrier


def power_law_jump_in(
    *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Jump:
    """Jump into contact on touching.

    (P, 0, a, released) with a = a(0) of Eq. (16); all 0 where n = 1 and c >= α.

    P = −2k ∫₀ᵃ f dx − 2kl f(a) = −2k c aⁿ (a/(n + 1) + l), Eq. (11) at d = 0. Released is
    ∫₀ᵃ k (δ₀² − (f + l f')²) dx with δ₀ = (f + l f')(a):
    k c² a^(2n−1) (2n a²/(2n + 1) + (2n − 1) a l + 2n² (n − 1) l²/(2n − 1)).

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].

    Raises
    ------
    ValueError
        For γ₁ = 0: see `two_works`.
    """
    with_tension(gamma1)
    a = np.asarray(power_law.half_width(0.0, c=c, n=n, k=k, gamma1=gamma1, w=w))[()]
    return touched(a, c=c, n=n, k=k, gamma1=gamma1)


def power_law_detachment(
    *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Jump:
    """Detachment, at the end of the adhered branch.

    (P, d, a, released) = (2kld, d, 0, kld²) at d = `power_law.detachment_depth`.

    n > 1: d = −δ₀, P = −2√(2wγ₁), released 2wl. n = 1: d = min(lc − δ₀, 0). γ₁ = 0 is allowed.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].
    """
    depth = power_law.detachment_depth(c=c, n=n, k=k, gamma1=gamma1, w=w)
    released = 2.0 * np.asarray(tail_energy(depth, k=k, gamma1=gamma1))
    force = 2.0 * positive("k", k) * elastocapillary_length(k, gamma1) * depth
    return Jump.of(force, depth, 0.0 * positive("c", c), released)


def power_law_loop_area(
    *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Energy dissipated in a loop that starts and ends detached.

    ∮P dd = energy released by `power_law_jump_in` + by `power_law_detachment`.

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
        ∮P dd [J/m].
    """
    first = power_law_jump_in(c=c, n=n, k=k, gamma1=gamma1, w=w)
    last = power_law_detachment(c=c, n=n, k=k, gamma1=gamma1, w=w)
    return first.energy_released + last.energy_released


def wedge_jump_in(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Jump into contact of a wedge on touching.

    (−F_A, 0, a, released), F_A of Eq. (30): a = δ₀/tan δ − l, k a² tan²δ (2a/3 + l).

    All 0 for a sharp wedge, tan δ >= α: it stays pinned at the tip.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].

    Raises
    ------
    ValueError
        For γ₁ = 0.
    """
    return power_law_jump_in(c=wedge_slope(delta), n=1.0, k=k, gamma1=gamma1, w=w)


def wedge_detachment(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Detachment of a wedge, at the end of the adhered branch.

    (2klq, q, 0, klq²) with q = l tan δ − δ₀ for tan δ < α; all 0 for a sharp wedge.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].
    """
    return power_law_detachment(c=wedge_slope(delta), n=1.0, k=k, gamma1=gamma1, w=w)


def wedge_loop_area(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy dissipated in a loop of a wedge that starts and ends detached.

    ∮P dd = 2k (δ₀ − l tan δ)² (a/3 + l) with a = δ₀/tan δ − l for tan δ < α, 0 beyond.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        ∮P dd [J/m].

    Raises
    ------
    ValueError
        For γ₁ = 0.
    """
    return power_law_loop_area(c=wedge_slope(delta), n=1.0, k=k, gamma1=gamma1, w=w)


def parabola_jump_in(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Jump into contact of a parabola on touching.

    (P, 0, a, released): a = −l + √(l² + 2Rδ₀), P = −k a² (a + 3l)/(3R).

    Released: (k a³/R²)(a²/5 + 3al/4 + 2l²/3).

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].

    Raises
    ------
    ValueError
        For γ₁ = 0.
    """
    return power_law_jump_in(c=0.5 / positive("R", R), n=2.0, k=k, gamma1=gamma1, w=w)


def parabola_detachment(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Detachment of a parabola, at the end of the adhered branch.

    (−2√(2wγ₁), −δ₀, 0, 2wl): the line keeps its place down to a = 0, whatever R.

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].
    """
    return power_law_detachment(c=0.5 / positive("R", R), n=2.0, k=k, gamma1=gamma1, w=w)


def parabola_loop_area(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy dissipated in a loop of a parabola that starts and ends detached.

    ∮P dd = 2wl + (k a³/R²)(a²/5 + 3al/4 + 2l²/3), a = −l + √(l² + 2Rδ₀).

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        ∮P dd [J/m].

    Raises
    ------
    ValueError
        For γ₁ = 0.
    """
    return power_law_loop_area(c=0.5 / positive("R", R), n=2.0, k=k, gamma1=gamma1, w=w)
