"""Jumps of a contact whose indenter hangs on a spring of stiffness K; K = 0 is a dead load.

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
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards import parabola, wedge
from energy.cards._checks import Array, non_negative, positive, refuse, wedge_slope
from energy.cards._types import Jump
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length
from energy.cards.tail import energy as tail_energy


class Detachment(NamedTuple):
    """A detachment under a machine.

    Attributes
    ----------
    jump : Jump
    spring_force : ndarray
        The force that is left in the machine's spring once the line has run down the branch.
    """

    jump: Jump
    spring_force: Array


def with_tension(gamma1: ArrayLike) -> Array:
    """γ₁ > 0: a line that runs downhill needs a surface that pulls its neighbour in."""
    gamma1 = non_negative("gamma1", gamma1)
    remedy = "must be > 0: springs without tension attach one by one, use two_works, w_closing = 0"
    refuse("gamma1", gamma1, gamma1 == 0.0, remedy)
    return gamma1


# Steps of Newton's method for the half-width of a parabola from at most 1.26 times of it: the error
# squares with each, and six reach rounding.
_NEWTON_STEPS = 6


def touched(a: Array, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike) -> Jump:
    """The jump on touching at fixed d = 0 that ends at the half-width a of Eq. (16)."""
    c = positive("c", c)
    k = positive("k", k)
    ell = elastocapillary_length(k, gamma1)
    lift = c * a ** (n - 1.0)
    wide = 2.0 * n / (2.0 * n + 1.0) * a**2
    mixed = (2.0 * n - 1.0) * a * ell
    narrow = 2.0 * n**2 * (n - 1.0) / (2.0 * n - 1.0) * ell**2
    released = k * lift**2 * a * (wide + mixed + narrow)
    force = -2.0 * k * lift * a * (a / (n + 1.0) + ell)
    return Jump.of(force, 0.0, a, released)


def wedge_touched(K: Array, *, delta: ArrayLike, k: Array, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """d = tan δ m²/(κ/2 + √(m² + κ²/4)), m² = a₀ (a₀ + 2l), a₀ = a(0); a = a₀ + d/tan δ.

    From P = (k/tan δ)(d² − m² tan²δ) on the branch; with rise r = d/tan δ it releases
    k tan²δ r (3m² + r²)/6 more than a jump at d = 0.
    """
    ell = elastocapillary_length(k, with_tension(gamma1))
    slope = wedge_slope(delta)
    a = np.asarray(wedge.half_width(0.0, delta=delta, k=k, gamma1=gamma1, w=w))
    m = np.sqrt(a * (a + 2.0 * ell))
    kappa = K / k
    total = 0.5 * kappa + np.hypot(m, 0.5 * kappa)
    not_zero = total + (total == 0.0)
    rise = m * (m / not_zero)
    d = slope * rise
    force = 0.0 - K * slope * rise
    at_zero = touched(a, c=slope, n=1.0, k=k, gamma1=gamma1)
    more = k * slope**2 * rise * (3.0 * m**2 + rise**2) / 6.0
    return Jump.of(force, d, a + rise, at_zero.energy_released + more)


def parabola_touched(K: Array, *, R: ArrayLike, k: Array, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """a from the cubic below, d = a² (a + 3l)/(3R (2 (a + l) + κ)).

    It releases d (a² (5a + 9l)/(6R) − a d) k less than a jump at d = 0 to the same a.
    """
    ell = elastocapillary_length(k, with_tension(gamma1))
    R = positive("R", R)
    a = np.asarray(parabola.half_width(0.0, R=R, k=k, gamma1=gamma1, w=w))
    kappa = K / k
    reach2 = np.asarray(R * critical_separation(k, w))
    a = _parabola_width(a, np.asarray(ell), reach2, kappa)
    stiffness = 2.0 * (a + ell) + kappa
    d = a**2 * (a + 3.0 * ell) / (3.0 * R * stiffness)
    mean = a * (5.0 * a + 9.0 * ell) / (6.0 * R)
    less = k * d * a * (mean - d)
    at_zero = touched(a, c=0.5 / R, n=2.0, k=k, gamma1=gamma1)
    return Jump.of(0.0 - K * d, d, a, at_zero.energy_released - less)


def _parabola_width(a: Array, ell: Array, reach2: Array, kappa: Array) -> Array:
    """The positive root of a (a² + 3al + 3l²) − 3Rδ₀ (a + l) + (3κ/4)(a (a + 2l) − 2Rδ₀).

    That is b³ + (3κ/4) b² − 3Rδ₀ b − l³ − (3κ/4)(l² + 2Rδ₀) with b = a + l. It is convex; the root
    lies between a(0), the start, and 1.26 a(0): six Newton steps reach rounding.
    """
    for _ in range(_NEWTON_STEPS):
        b = a + ell
        load = a * (a**2 + 3.0 * ell * b) - 3.0 * reach2 * b
        machine = 0.75 * kappa * (a * (a + 2.0 * ell) - 2.0 * reach2)
        slope = 3.0 * (b**2 - reach2) + 1.5 * kappa * b
        a = a - (load + machine) / slope
    return a


def wedge_detached(
    K: Array, *, delta: ArrayLike, k: Array, gamma1: ArrayLike, w: ArrayLike
) -> Detachment:
    """a = max(a(0) − κ/2, 0); released k l q² + k a³ tan²δ/3 with q = l tan δ − δ₀ <= 0."""
    same: dict[str, Any] = {"delta": delta, "k": k, "gamma1": gamma1, "w": w}
    slope = wedge_slope(delta)
    q = np.asarray(wedge.depth(0.0, **same))
    at_zero = np.asarray(wedge.half_width(0.0, **same))
    a = np.maximum(at_zero - 0.5 * (K / k), 0.0)
    blunt = q < 0.0
    end = np.minimum(q, 0.0)
    force = np.where(blunt, wedge.force_of_width(a, **same), 0.0)
    free_surfaces = 2.0 * np.asarray(tail_energy(end, k=k, gamma1=gamma1))
    released = free_surfaces + k * slope**2 * a**3 / 3.0
    jump = Jump.of(force, slope * a + end, a, released)
    return Detachment(jump, force + K * slope * a)


def parabola_detached(
    K: Array, *, R: ArrayLike, k: Array, gamma1: ArrayLike, w: ArrayLike
) -> Detachment:
    """b = a + l from b² + κb/2 = Rδ₀ where that is > l², else a = 0.

    Released: 2wl + (2k a³/(3R²)) (a²/5 + al + l² + κ (a + 4l)/16).
    """
    R = positive("R", R)
    ell = elastocapillary_length(k, gamma1)
    kappa = K / k
    reach2 = R * critical_separation(k, w)
    over = np.maximum(reach2 - ell * (ell + 0.5 * kappa), 0.0)
    total = np.hypot(0.25 * kappa, np.sqrt(reach2)) + ell + 0.25 * kappa
    not_zero = total + (total == 0.0)
    a = over / not_zero
    shape = a**2 / 5.0 + ell * (a + ell) + kappa * (a + 4.0 * ell) / 16.0
    at_the_end = parabola.energy_released(k=k, gamma1=gamma1, w=w)
    on_the_way = 2.0 * k * a**3 * shape / (3.0 * R**2)
    same: dict[str, Any] = {"R": R, "k": k, "gamma1": gamma1, "w": w}
    force = np.asarray(parabola.force_of_width(a, **same))
    d = parabola.depth(a, **same)
    jump = Jump.of(force, d, a, at_the_end + on_the_way)
    return Detachment(jump, force + K * a * (a + 2.0 * ell) / (2.0 * R))
