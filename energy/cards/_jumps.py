"""Jumps of a contact whose indenter hangs on a spring of stiffness K; K = 0 is a dead load.

Conventions: the contact lines are at ±a; profiles f are positive upwards, the depth d of the level
f = 0 and displacements u downwards, forces P per length where the indenter is pressed. k is the
stiffness of the foundation [N/m³], K that of the machine [N/m²], l = √(γ₁/k), δ₀ = √(2w/k),
α = √(2w/γ₁). The branch (16) is d = f(a) + l f'(a) − δ₀. `parabola` and `wedge` are its cards for
f = x²/(2R) and |x| tan δ; `tail_energy` is ½ √(kγ₁) u_a² of one free surface that is displaced by
u_a at its line. All arguments broadcast.

The drive D moves the far end of the spring. State and stability follow from

    E(a, d; D) = U(a, d) + K/2 (D − d)²,    P = K (D − d),

stable on the branch (16) while dP/dd > −K. With κ = K/k:

Jump-in. The spring is relaxed until the indenter touches at D = 0. At every half-width a on the
way the depth is in balance, P(a, d) = −Kd, that is, from Eq. (11) with f = c|x|ⁿ,

    d(a) = 2 (∫₀ᵃ f dx + l f(a))/(2 (a + l) + κ) = 2c aⁿ (a/(n + 1) + l)/(2 (a + l) + κ),

and the line stops where (f + l f')(a) = δ₀ + d(a). E falls by ∫₀ᵃ k (δ₀² − (f + l f' − d)²) dx.

Detachment. Below the instability no state with contact is left at this drive. The part of the
energy released that stays finite for K = 0 is what goes while the line follows the branch down to
its end d_e: with P_s(d) = P − K (d' − d) the straight line of the spring through the instability,

    U(d_e) + ∫_{d_e}^{d} (P(d') − P_s(d')) dd' ;

after that the spring relaxes from the force P_s(d_e), and loses P_s(d_e)²/(2K).

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `wedge_slope(delta)` is tan δ. `refuse(name, value, bad, remedy)` raises ValueError
where `bad` is true. `not_zero` puts 1 in place of 0, for divisors of terms that are 0 there.
`positive` and `non_negative` check an argument, whose name comes first, and return it as float64.

Of the cards, `half_width(d)` is a on the branch at the depth d, `depth(a)` the depth there and
`force_of_width(a)` the force; `parabola.energy_released` is 2wl, what both free surfaces lose where
the branch ends. A `Jump` has the force, depth and half-width of the contact and `energy_released`,
>= 0.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards import parabola, wedge
from energy.cards._checks import Array, non_negative, not_zero, positive, refuse, wedge_slope
from energy.cards._types import Jump
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length
from energy.cards.tail import energy as tail_energy


class Detachment(NamedTuple):
    """A detachment under a machine.

    Attributes
    ----------
    jump : Jump
        Force, depth and half-width at the instability, and the part of the energy released that
        goes while the line runs down the branch; the rest, that of the spring, is not in it.
    spring_force : ndarray
        P_s(d_e), the force that is left in the machine's spring once the line has run down the
        branch [N/m].
    """

    jump: Jump
    spring_force: Array


def with_tension(gamma1: ArrayLike) -> Array:
    """γ₁, checked to be > 0: a line runs downhill where the surface pulls its neighbour in."""
    gamma1 = non_negative("gamma1", gamma1)
    remedy = "must be > 0: springs without tension attach one by one, use two_works, w_closing = 0"
    refuse("gamma1", gamma1, gamma1 == 0.0, remedy)
    return gamma1


# Steps of Newton's method for the half-width of a parabola from at most 1.26 times of it: the error
# squares with each, and six reach rounding.
_NEWTON_STEPS = 6


def touched(a: Array, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike) -> Jump:
    """The jump of f = c|x|ⁿ on touching, at fixed d = 0, to the half-width a.

    a is that of Eq. (16) at d = 0, so that δ₀ = (f + l f')(a). The force is Eq. (11), and

        ∫₀ᵃ k (δ₀² − (f + l f')²) dx
            = k (f(a)/a)² a (2n a²/(2n + 1) + (2n − 1) a l + 2n² (n − 1) l²/(2n − 1))

    is released.
    """
    c = positive("c", c)
    k = positive("k", k)
    ell = elastocapillary_length(k, gamma1)
    f_over_a = c * a ** (n - 1.0)
    term_aa = 2.0 * n / (2.0 * n + 1.0) * a**2
    term_al = (2.0 * n - 1.0) * a * ell
    term_ll = 2.0 * n**2 * (n - 1.0) / (2.0 * n - 1.0) * ell**2
    released = k * f_over_a**2 * a * (term_aa + term_al + term_ll)
    force = -2.0 * k * f_over_a * a * (a / (n + 1.0) + ell)
    return Jump.of(force, 0.0, a, released)


def wedge_touched(K: Array, *, delta: ArrayLike, k: Array, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """The jump of a wedge on touching, at the drive D = 0 of a machine of stiffness K.

    It ends where the branch P = (k/tan δ)(d² − m² tan²δ) meets the spring's P = −Kd:

        d = tan δ m²/(κ/2 + √(m² + κ²/4)),   a = a₀ + d/tan δ,   m² = a₀ (a₀ + 2l),   κ = K/k,

    with a₀ the half-width of the branch at d = 0. With r = d/tan δ it releases
    k tan²δ r (3m² + r²)/6 more than a jump at fixed d = 0. All 0 for a sharp wedge, tan δ >= α.
    """
    ell = elastocapillary_length(k, with_tension(gamma1))
    slope = wedge_slope(delta)
    a_0 = np.asarray(wedge.half_width(0.0, delta=delta, k=k, gamma1=gamma1, w=w))
    m = np.sqrt(a_0 * (a_0 + 2.0 * ell))
    kappa = K / k
    divisor = 0.5 * kappa + np.hypot(m, 0.5 * kappa)  # 0 where m and K are
    advance = m * (m / not_zero(divisor))
    d = slope * advance
    force = 0.0 - K * slope * advance  # 0.0 and not -0.0 under a dead load
    at_zero = touched(a_0, c=slope, n=1.0, k=k, gamma1=gamma1)
    more = k * slope**2 * advance * (3.0 * m**2 + advance**2) / 6.0
    return Jump.of(force, d, a_0 + advance, at_zero.energy_released + more)


def parabola_touched(K: Array, *, R: ArrayLike, k: Array, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """The jump of a parabola on touching, at the drive D = 0 of a machine of stiffness K.

    The half-width a at which it ends is the root of `_parabola_width`, and with κ = K/k

        d = a² (a + 3l)/(3R (2 (a + l) + κ)),   P = −Kd.

    It releases k d (a² (5a + 9l)/(6R) − a d) less than a jump at fixed d = 0 to the same a.
    """
    ell = elastocapillary_length(k, with_tension(gamma1))
    R = positive("R", R)
    a_0 = np.asarray(parabola.half_width(0.0, R=R, k=k, gamma1=gamma1, w=w))
    kappa = K / k
    R_delta0 = np.asarray(R * critical_separation(k, w))
    a = _parabola_width(a_0, np.asarray(ell), R_delta0, kappa)
    stiffness = 2.0 * (a + ell) + kappa  # of layer and machine, over k
    d = a**2 * (a + 3.0 * ell) / (3.0 * R * stiffness)
    mean_depth = a * (5.0 * a + 9.0 * ell) / (6.0 * R)
    less = k * d * a * (mean_depth - d)
    at_zero = touched(a, c=0.5 / R, n=2.0, k=k, gamma1=gamma1)
    force = 0.0 - K * d  # 0.0 and not -0.0 under a dead load
    return Jump.of(force, d, a, at_zero.energy_released - less)


def _parabola_width(a_0: Array, ell: Array, R_delta0: Array, kappa: Array) -> Array:
    """Half-width at which a parabola's jump on touching ends, from that of the branch at d = 0.

    The positive root of a (a² + 3al + 3l²) − 3Rδ₀ (a + l) + (3κ/4)(a (a + 2l) − 2Rδ₀), that is of
    b³ + (3κ/4) b² − 3Rδ₀ b − l³ − (3κ/4)(l² + 2Rδ₀) with b = a + l. It is convex, and its root lies
    between a_0 and 1.26 a_0: Newton's steps from a_0 reach rounding.
    """
    a = a_0
    for _ in range(_NEWTON_STEPS):
        b = a + ell
        of_dead_load = a * (a**2 + 3.0 * ell * b) - 3.0 * R_delta0 * b
        of_machine = 0.75 * kappa * (a * (a + 2.0 * ell) - 2.0 * R_delta0)
        slope = 3.0 * (b**2 - R_delta0) + 1.5 * kappa * b
        a = a - (of_dead_load + of_machine) / slope
    return a


def wedge_detached(
    K: Array, *, delta: ArrayLike, k: Array, gamma1: ArrayLike, w: ArrayLike
) -> Detachment:
    """The detachment of a wedge, at a = max(a₀ − κ/2, 0) with a₀ = a(d = 0) and κ = K/k.

    There dP/dd = 2kd/tan δ = −K, or the branch ends at a = 0, d = q = l tan δ − δ₀. Released,
    without the spring, is k l q² + k a³ tan²δ/3. All 0 for a sharp wedge, q >= 0: it never pulls.
    """
    same: dict[str, Any] = {"delta": delta, "k": k, "gamma1": gamma1, "w": w}
    slope = wedge_slope(delta)
    q = np.asarray(wedge.depth(0.0, **same))
    a_0 = np.asarray(wedge.half_width(0.0, **same))
    a = np.maximum(a_0 - 0.5 * (K / k), 0.0)
    blunt = q < 0.0
    end = np.minimum(q, 0.0)  # depth at which the branch ends
    force = np.where(blunt, wedge.force_of_width(a, **same), 0.0)
    free_surfaces = 2.0 * np.asarray(tail_energy(end, k=k, gamma1=gamma1))
    released = free_surfaces + k * slope**2 * a**3 / 3.0
    jump = Jump.of(force, slope * a + end, a, released)
    spring_force = force + K * slope * a  # the depth falls by a tan δ down to the end
    return Detachment(jump, spring_force)


def parabola_detached(
    K: Array, *, R: ArrayLike, k: Array, gamma1: ArrayLike, w: ArrayLike
) -> Detachment:
    """The detachment of a parabola, at the b = a + l with b² + κb/2 = Rδ₀, κ = K/k.

    There dP/dd = −K. Where that b is below l, the branch ends first, at a = 0 and d = −δ₀.
    Released, without the spring, is 2wl + (2k a³/(3R²)) (a²/5 + al + l² + κ (a + 4l)/16).
    """
    R = positive("R", R)
    ell = elastocapillary_length(k, gamma1)
    kappa = K / k
    R_delta0 = R * critical_separation(k, w)
    # a = √(κ²/16 + Rδ₀) − κ/4 − l, multiplied and divided by the sum of these terms
    over = np.maximum(R_delta0 - ell * (ell + 0.5 * kappa), 0.0)
    divisor = np.hypot(0.25 * kappa, np.sqrt(R_delta0)) + ell + 0.25 * kappa
    a = over / not_zero(divisor)  # 0/0 without tension, adhesion and machine: a = 0
    shape = a**2 / 5.0 + ell * (a + ell) + kappa * (a + 4.0 * ell) / 16.0
    at_the_end = parabola.energy_released(k=k, gamma1=gamma1, w=w)
    on_the_way = 2.0 * k * a**3 * shape / (3.0 * R**2)
    same: dict[str, Any] = {"R": R, "k": k, "gamma1": gamma1, "w": w}
    force = np.asarray(parabola.force_of_width(a, **same))
    d = parabola.depth(a, **same)
    jump = Jump.of(force, d, a, at_the_end + on_the_way)
    # The depth falls by d + δ₀ = a (a + 2l)/(2R) down to the end.
    spring_force = force + K * a * (a + 2.0 * ell) / (2.0 * R)
    return Detachment(jump, spring_force)
