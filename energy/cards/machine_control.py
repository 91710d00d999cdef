"""Loops under a machine of finite stiffness K: the drive D moves the far end of its spring.

Conventions: d is the depth of the level f = 0, positive into the layer, P the force per length,
positive pressed, a the half-width; k is the stiffness of the foundation [N/m³], l = √(γ₁/k),
δ₀ = √(2w/k), α = √(2w/γ₁), and U the energy of the layer, 0 without contact.

P = K (D − d). The indenter touches at D = 0 with the spring relaxed, jumps in at fixed D, and
retracts along the adhered branch until dP/dd = −K or the branch ends. From the critical machine
stiffness on the branch is followed to its end, as under displacement control:

    flat punch    0                    dP/dd = 2k (a + l) > 0 down to −δ₀
    wedge         2k (δ₀/tan δ − l)    dP/dd = 2kd/tan δ, least at the end d = l tan δ − δ₀
    parabola      2k (Rδ₀ − l²)/l      dP/dd = 2k (b − Rδ₀/b), b = a + l, least at b = l

Energies released are those of U + K/2 (D − d)²; after a detachment both the layer and the spring
are relaxed, so a detachment releases U + P²/(2K). Jump-in + detachment = ∮P dD of a loop that
starts and ends detached. K → ∞ is `displacement_control`; K → 0 has the states of `load_control`,
while P²/(2K), the work of a dead load on an indenter that flies off, grows without bound.

The most tensile force does not depend on K: wedge and parabola meet their `pull_off` before they
become unstable, the flat punch its own at −δ₀.

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `wedge_touched(K)` and `parabola_touched(K)` are the jumps on touching under a machine
of stiffness K. `wedge_detached(K)` and `parabola_detached(K)` are the detachments, each a `jump`
and the force that is left in the spring. `Values` is a float for numbers, an array for arrays.

A `Jump` has the force, depth and half-width (`half_width`) of the contact, just after a jump-in or
just before a detachment, and `energy_released`, >= 0. The flat punch jumps in as under displacement
control (`flat_punch_jump_in`); `wedge.half_width(d)` is a on the branch.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards import displacement_control, wedge
from energy.cards._checks import Array, positive
from energy.cards._jumps import (
    Detachment,
    parabola_detached,
    parabola_touched,
    wedge_detached,
    wedge_touched,
)
from energy.cards._types import Jump, Values
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length

flat_punch_jump_in = displacement_control.flat_punch_jump_in


def flat_punch_detachment(
    *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike, K: ArrayLike
) -> Jump:
    """Detachment of a flat punch.

    (P of Eq. (22), −δ₀, a, 2wl + P²/(2K)): any machine reaches the end of the branch.

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w, K : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m], work of adhesion [J/m²] and
        stiffness of the machine per length of the contact [N/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].
    """
    jump = displacement_control.flat_punch_detachment(a=a, k=k, gamma1=gamma1, w=w)
    return _relaxed(Detachment(jump, np.asarray(jump.force)), K)


def flat_punch_loop_area(
    *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike, K: ArrayLike
) -> Values:
    """Energy dissipated in a loop of a flat punch.

    ∮P dD = 2w (a + l) + P²/(2K), P of Eq. (22).

    Parameters
    ----------
    a : array_like
        Half-width of the contact [m].
    k, gamma1, w, K : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m], work of adhesion [J/m²] and
        stiffness of the machine per length of the contact [N/m²].

    Returns
    -------
    float or ndarray
        ∮P dD [J/m].
    """
    first = flat_punch_jump_in(a=a, k=k, gamma1=gamma1, w=w).energy_released
    return first + flat_punch_detachment(a=a, k=k, gamma1=gamma1, w=w, K=K).energy_released


def wedge_jump_in(
    *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike, K: ArrayLike
) -> Jump:
    """Jump into contact of a wedge on touching.

    (−Kd, d, a₀ + d/tan δ, released): d = tan δ m²/(κ/2 + √(m² + κ²/4)), κ = K/k.

    m² = a₀ (a₀ + 2l), a₀ = δ₀/tan δ − l. Released −U − K d²/2 =
    k tan²δ a₀² (2a₀/3 + l) + (k d/(6 tan δ)) (3m² tan²δ + d²). All 0 for a sharp wedge,
    tan δ >= α.

    Parameters
    ----------
    delta, k, gamma1, w, K : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m], work of adhesion [J/m²] and stiffness of the machine per length of the contact
        [N/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].

    Raises
    ------
    ValueError
        For γ₁ = 0.
    """
    K = positive("K", K)
    return wedge_touched(K, delta=delta, k=positive("k", k), gamma1=gamma1, w=w)


def wedge_detachment(
    *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike, K: ArrayLike
) -> Jump:
    """Detachment of a wedge.

    a = max(a₀ − κ/2, 0), a₀ = δ₀/tan δ − l, κ = K/k: where dP/dd = 2kd/tan δ = −K.

    P of Eq. (29), which is −F_A + K² tan δ/(4k) while a > 0, d of Eq. (28), released U + P²/(2K).
    All 0 for a sharp wedge, tan δ >= α. γ₁ = 0 is allowed.

    Parameters
    ----------
    delta, k, gamma1, w, K : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m], work of adhesion [J/m²] and stiffness of the machine per length of the contact
        [N/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].
    """
    K = positive("K", K)
    return _relaxed(wedge_detached(K, delta=delta, k=positive("k", k), gamma1=gamma1, w=w), K)


def wedge_loop_area(
    *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike, K: ArrayLike
) -> Values:
    """Energy dissipated in a loop of a wedge that starts and ends detached.

    ∮P dD = energy released by `wedge_jump_in` + by `wedge_detachment`.

    Parameters
    ----------
    delta, k, gamma1, w, K : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m], work of adhesion [J/m²] and stiffness of the machine per length of the contact
        [N/m²].

    Returns
    -------
    float or ndarray
        ∮P dD [J/m].
    """
    first = wedge_jump_in(delta=delta, k=k, gamma1=gamma1, w=w, K=K)
    last = wedge_detachment(delta=delta, k=k, gamma1=gamma1, w=w, K=K)
    return first.energy_released + last.energy_released


def wedge_critical_stiffness(
    *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Stiffness of the machine from which on a wedge detaches without an instability.

    K_c = 2k max(δ₀/tan δ − l, 0): for K >= K_c the line gets to the tip without instability.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        K_c [N/m²].
    """
    width = wedge.half_width(0.0, delta=delta, k=k, gamma1=gamma1, w=w)
    return 2.0 * positive("k", k) * width


def parabola_jump_in(
    *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike, K: ArrayLike
) -> Jump:
    """Jump into contact of a parabola on touching.

    (−Kd, d, a, released), with b = a + l and κ = K/k from the one positive root of

    b³ + (3κ/4) b² − 3Rδ₀ b = l³ + (3κ/4)(l² + 2Rδ₀), and d = a² (a + 3l)/(3R (2b + κ)).

    Released: −U − K d²/2.

    Parameters
    ----------
    R, k, gamma1, w, K : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m], work of
        adhesion [J/m²] and stiffness of the machine per length of the contact [N/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].

    Raises
    ------
    ValueError
        For γ₁ = 0.
    """
    K = positive("K", K)
    return parabola_touched(K, R=R, k=positive("k", k), gamma1=gamma1, w=w)


def parabola_detachment(
    *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike, K: ArrayLike
) -> Jump:
    """Detachment of a parabola.

    b = a + l with b² + (κ/2) b = Rδ₀, κ = K/k, where K < `parabola_critical_stiffness`.

    a = 0, d = −δ₀ for stiffer machines. P and d of the branch at a, released U + P²/(2K).
    γ₁ = 0 is allowed.

    Parameters
    ----------
    R, k, gamma1, w, K : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m], work of
        adhesion [J/m²] and stiffness of the machine per length of the contact [N/m²].

    Returns
    -------
    Jump
        P [N/m], d [m], a [m] and the energy released [J/m].
    """
    K = positive("K", K)
    return _relaxed(parabola_detached(K, R=R, k=positive("k", k), gamma1=gamma1, w=w), K)


def parabola_loop_area(
    *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike, K: ArrayLike
) -> Values:
    """Energy dissipated in a loop of a parabola that starts and ends detached.

    ∮P dD = energy released by `parabola_jump_in` + by `parabola_detachment`.

    Parameters
    ----------
    R, k, gamma1, w, K : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m], work of
        adhesion [J/m²] and stiffness of the machine per length of the contact [N/m²].

    Returns
    -------
    float or ndarray
        ∮P dD [J/m].
    """
    first = parabola_jump_in(R=R, k=k, gamma1=gamma1, w=w, K=K)
    last = parabola_detachment(R=R, k=k, gamma1=gamma1, w=w, K=K)
    return first.energy_released + last.energy_released


def parabola_critical_stiffness(
    *, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Stiffness of the machine from which on a parabola detaches without an instability.

    K_c = 2k max(Rδ₀ − l², 0)/l: for K >= K_c the contact shrinks to a = 0 at d = −δ₀.

    0 for Λ = l/√(Rδ₀) >= 1; inf for γ₁ = 0 with w > 0, where no machine is stiff enough.

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        K_c [N/m²].
    """
    ell = np.asarray(elastocapillary_length(k, gamma1))
    k = positive("k", k)
    over = np.maximum(positive("R", R) * critical_separation(k, w) - ell**2, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness: Array = np.where(over > 0.0, 2.0 * k * over / ell, 0.0)[()]
    return stiffness


def _relaxed(detachment: Detachment, K: ArrayLike) -> Jump:
    """The detachment, with the energy P_s²/(2K) of the spring that relaxes after it as well.

    P_s is the force in the spring once the line has run down the branch, `spring_force`.
    """
    force, depth, a, released_by_layer = detachment.jump
    released_by_spring = 0.5 * detachment.spring_force**2 / positive("K", K)
    return Jump.of(force, depth, a, released_by_layer + released_by_spring)
