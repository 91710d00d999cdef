"""Loops under a dead load: jump-in at P = 0 on touching, pull-off, loop area.

Conventions: d is the depth of the level f = 0, positive into the layer, P the force per length,
positive pressed, a the half-width; k is the stiffness of the foundation [N/m³], l = √(γ₁/k),
δ₀ = √(2w/k), α = √(2w/γ₁), and U the energy of the layer, 0 without contact.

The load fixes P and the enthalpy U − P d falls. On touching, d = 0 and P = 0, the contact pulls the
indenter in until its force is zero, U falls to U(d) < 0. Retraction follows the adhered branch
until dP/dd = 0 or the branch ends; beyond that load there is no contact.

A dead load that wins has no rest: the indenter flies off and U − P d falls without bound. What is
counted as released is what goes while there is a contact, its line keeping up with the indenter:

    [U − P d]_{pull-off} − [U − P d]_{detached at d_e} = U(d) − P (d − d_e),  d_e: end of branch.

With the indenter held where it lets go the layer alone has the `energy` of that depth, which may be
negative: the load has to do work to part them. Then jump-in + detachment = ∮P dd of the loop that
starts and ends detached, P being the load. The largest load drops out.

γ₁ = 0 has no jump-in (`two_works`); its detachment is that of a contact that was pressed wider than
the half-width at which it lets go.

Imported: `wedge_touched(K)` and `parabola_touched(K)` are the jumps on touching under a machine of
stiffness K. `wedge_detached(K)` and `parabola_detached(K)` are the detachments, each a `jump` and
the force that is left in the spring. `Values` is a float for numbers, an array for arrays.

A `Jump` has the force, depth and half-width (`half_width`) of the contact, just after a jump-in or
just before a detachment, and `energy_released`, >= 0. The flat punch jumps as under
`displacement_control`, and has its cards: `flat_punch_jump_in`, `flat_punch_detachment` and
`flat_punch_loop_area`.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards import displacement_control
from energy.cards._checks import positive
from energy.cards._jumps import parabola_detached, parabola_touched, wedge_detached, wedge_touched
from energy.cards._types import Jump, Values

flat_punch_jump_in = displacement_control.flat_punch_jump_in
flat_punch_detachment = displacement_control.flat_punch_detachment
flat_punch_loop_area = displacement_control.flat_punch_loop_area
_DEAD_LOAD = np.zeros(())  # K = 0: a machine without stiffness


def wedge_jump_in(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Jump into contact of a wedge on touching.

    (0, d, a, released): d = m tan δ, a = a₀ + m with m² = a₀ (a₀ + 2l), a₀ = δ₀/tan δ − l.

    Released −U(d) = k tan²δ (a₀² (2a₀/3 + l) + 2m³/3). All 0 for a sharp wedge, tan δ >= α.

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
    return wedge_touched(_DEAD_LOAD, delta=delta, k=positive("k", k), gamma1=gamma1, w=w)


def wedge_detachment(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Pull-off of a wedge.

    (−F_A, 0, a₀, k tan²δ a₀² (a₀/3 + l)), a₀ = δ₀/tan δ − l, F_A of Eq. (30).

    All 0 for a sharp wedge, tan δ >= α. γ₁ = 0 is allowed.

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
    return wedge_detached(_DEAD_LOAD, delta=delta, k=positive("k", k), gamma1=gamma1, w=w).jump


def wedge_loop_area(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy dissipated in a loop of a wedge that starts and ends detached.

    ∮P dd = k tan²δ (a₀² (a₀ + 2l) + 2m³/3), with a₀ and m of `wedge_jump_in`.

    Parameters
    ----------
    delta, k, gamma1, w : array_like
        Angle between flank and surface [rad], stiffness of the foundation [N/m³], surface tension
        [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        ∮P dd [J/m].
    """
    first = wedge_jump_in(delta=delta, k=k, gamma1=gamma1, w=w)
    last = wedge_detachment(delta=delta, k=k, gamma1=gamma1, w=w)
    return first.energy_released + last.energy_released


def parabola_jump_in(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Jump into contact of a parabola on touching.

    (0, d, a, released): (a + l)³ − 3Rδ₀ (a + l) = l³, d = a² (a + 3l)/(6R (a + l)).

    Released −U(d) = k a³ (4a⁴ + 23a³l + 54a²l² + 60al³ + 30l⁴)/(45 R² (a + l)²).

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
    return parabola_touched(_DEAD_LOAD, R=R, k=positive("k", k), gamma1=gamma1, w=w)


def parabola_detachment(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Pull-off of a parabola.

    State of `parabola.pull_off`, released 2wl + (2k a³/(3R²)) (a²/5 + al + l²).

    Λ = l/√(Rδ₀) <= 1: a = √(Rδ₀) − l. Λ >= 1: a = 0, as under displacement control.
    γ₁ = 0 is allowed.

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
    return parabola_detached(_DEAD_LOAD, R=R, k=positive("k", k), gamma1=gamma1, w=w).jump


def parabola_loop_area(*, R: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy dissipated in a loop of a parabola that starts and ends detached.

    ∮P dd = energy released by `parabola_jump_in` + by `parabola_detachment`.

    Parameters
    ----------
    R, k, gamma1, w : array_like
        Radius of curvature [m], stiffness of the foundation [N/m³], surface tension [N/m] and work
        of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        ∮P dd [J/m].
    """
    first = parabola_jump_in(R=R, k=k, gamma1=gamma1, w=w)
    last = parabola_detachment(R=R, k=k, gamma1=gamma1, w=w)
    return first.energy_released + last.energy_released
