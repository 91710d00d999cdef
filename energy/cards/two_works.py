"""Two works of adhesion: closing contact gains w_closing, opening it costs w >= w_closing.

Conventions: the lines are at ±a; heights f are positive upwards, the depth d of the level f = 0
downwards, forces P per length where the indenter is pressed; l = √(γ₁/k). The cards of `power_law`
are those of a single work of adhesion.

Profile f = c|x|ⁿ, n >= 1; wedge: c = tan δ, n = 1; parabola: c = 1/(2R), n = 2.

The line at a advances where f + l f' <= d + δ_c and recedes where f + l f' >= d + δ₀, Eq. (16) with
δ_c = √(2 w_closing/k) and δ₀ = √(2w/k); in between it is pinned. Turning back at d frees it after
the depth has changed by δ₀ − δ_c, whatever the profile. With V the energy of springs and surface,
P = ∂V/∂d and ∂V/∂a = k (f + l f' − d)², which is 2 w_closing on an advancing line and 2w on a
receding one, so ∮P dd = −∮ ∂V/∂a da and every length that is closed and opened again costs

    2 (w − w_closing) per unit of half-width,

on top of what jumps release. w = w_closing is `displacement_control`. γ₁ = 0 demands w_closing = 0:
springs without tension attach on touching, at f(a) = d, and let go at f(a) = d + δ₀. A flat punch
is pinned at its edges under both works: its loop area is 2w (a + l) for every w_closing.

Imported: `tail_energy(u_a)` is ½ √(kγ₁) u_a² of one free surface. `touched(a, c, n)` is the jump of
f = c|x|ⁿ at d = 0 to the half-width a. `Values` is a float for numbers, an array for arrays.
`excess(name, value, bound, remedy)` is value − bound, 0 where it is negative by rounding, and an
error below. `refuse(name, value, bad, remedy)` raises ValueError where `bad` is true. `finite` and
`non_negative` check an argument, whose name comes first, and return it as float64.

`half_width(d)` of a card is a on its branch, and `energy_released` of a `Jump` what is lost, >= 0.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.cards import power_law
from energy.cards._checks import Array, excess, finite, non_negative, refuse
from energy.cards._jumps import touched
from energy.cards._types import Values
from energy.cards.tail import energy as tail_energy


class HalfWidths(NamedTuple):
    """Half-widths between which a line is pinned [m].

    Attributes
    ----------
    advancing : float or ndarray
        That from which a narrower contact would widen; 0 where none would.
    receding : float or ndarray
        That to which a wider contact would shrink, >= `advancing`.
    """

    advancing: Values
    receding: Values


def half_widths(
    d: ArrayLike,
    *,
    c: ArrayLike,
    n: float,
    k: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
    w_closing: ArrayLike,
) -> HalfWidths:
    """Half-widths between which a line is pinned at a depth.

    Those of an advancing and of a receding line, Eq. (16) with w_closing and with w.

    A line between the two is pinned. Advancing is 0 where nothing would close by itself.
    ValueError for w_closing > w, and for d below `power_law.detachment_depth` at w.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w, w_closing : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m],
        work of adhesion [J/m²] and work of adhesion gained on closing [J/m²].

    Returns
    -------
    HalfWidths
        a of an advancing and of a receding line [m].
    """
    closing, opening = _works(w_closing, w, gamma1)
    same: dict[str, Any] = {"c": c, "n": n, "k": k, "gamma1": gamma1}
    receding = np.asarray(power_law.half_width(d, w=opening, **same))
    # Below the depth at which a contact of w_closing detaches no line advances: a = 0, as there.
    least = power_law.detachment_depth(w=closing, **same)
    advancing = np.asarray(power_law.half_width(np.maximum(d, least), w=closing, **same))
    return HalfWidths(*np.array(np.broadcast_arrays(advancing, receding)))


def cycle_area(
    *,
    c: ArrayLike,
    n: float,
    k: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
    w_closing: ArrayLike,
    d_min: ArrayLike,
    d_max: ArrayLike,
) -> Values:
    """Energy dissipated in a steady cycle between two depths, contact being kept.

    ∮P dd = 2 (w − w_closing) max(a_adv(d_max) − a_rec(d_min), 0).

    The steady cycle between two depths; 0 while the line stays pinned, d_max − d_min <= δ₀ − δ_c.
    ValueError for d_max < d_min, and for d_min below `power_law.detachment_depth`.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    d_min : array_like
        Least depth of the cycle [m].
    d_max : array_like
        Largest depth [m].
    c, k, gamma1, w, w_closing : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m],
        work of adhesion [J/m²] and work of adhesion gained on closing [J/m²].

    Returns
    -------
    float or ndarray
        ∮P dd [J/m].
    """
    both: dict[str, Any] = {"w": w, "w_closing": w_closing}
    same: dict[str, Any] = {"c": c, "n": n, "k": k, "gamma1": gamma1}
    closing, opening = _works(w_closing, w, gamma1)
    top = finite("d_max", d_max)
    low = finite("d_min", d_min)
    excess("d_max", top, low, "the cycle turns back at d_max, pass d_max >= d_min")
    least = power_law.detachment_depth(w=w, **same)
    excess("d_min", low, least, "the contact lets go, use a loop_area or a larger d_min")
    widest = half_widths(top, **same, **both).advancing
    narrowest = half_widths(low, **same, **both).receding
    area: Array = 2.0 * (opening - closing) * np.maximum(widest - narrowest, 0.0)
    return area


def loop_area(
    *,
    c: ArrayLike,
    n: float,
    k: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
    w_closing: ArrayLike,
    d_max: ArrayLike,
) -> Values:
    """Energy dissipated in a loop from touching to a depth and back to detachment.

    What the jump-in releases at w_closing, 2 (w − w_closing) a_adv(d_max) of the lines, and
    k l d_e² at the end d_e of the branch at w; 0 where the line never leaves the tip.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    d_max : array_like
        Largest depth [m].
    c, k, gamma1, w, w_closing : array_like
        Coefficient of f = c|x|ⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m],
        work of adhesion [J/m²] and work of adhesion gained on closing [J/m²].

    Returns
    -------
    float or ndarray
        ∮P dd [J/m].

    Raises
    ------
    ValueError
        For d_max < 0 and w_closing > w.
    """
    closing, opening = _works(w_closing, w, gamma1)
    top = finite("d_max", d_max)
    excess("d_max", top, 0.0, "the indenter does not touch, pass d_max >= 0")
    same: dict[str, Any] = {"c": c, "n": n, "k": k, "gamma1": gamma1}
    widest = np.asarray(power_law.half_width(np.maximum(top, 0.0), w=closing, **same))
    touching = np.asarray(power_law.half_width(0.0, w=closing, **same))
    of_jump_in = touched(touching, **same).energy_released
    of_lines = 2.0 * (opening - closing) * widest
    end = power_law.detachment_depth(w=opening, **same)
    of_detachment = 2.0 * np.asarray(tail_energy(end, k=k, gamma1=gamma1))
    area = of_jump_in + of_lines + of_detachment
    # A line that never left the tip of a wedge has closed nothing, and opens nothing.
    of_loop: Array = np.where(widest > 0.0, area, 0.0)[()]
    return of_loop


def _works(w_closing: ArrayLike, w: ArrayLike, gamma1: ArrayLike) -> tuple[Array, Array]:
    """w_closing and w, checked: w_closing in [0, w], and 0 where no tension pulls a spring in."""
    closing = non_negative("w_closing", w_closing)
    opening = non_negative("w", w)
    remedy = "exceeds w: closing gains at most what opening costs, pass w_closing <= w"
    refuse("w_closing", closing, closing > opening, remedy)
    slack = (non_negative("gamma1", gamma1) == 0.0) & (closing > 0.0)
    refuse("w_closing", closing, slack, "needs gamma1 > 0: without tension pass w_closing = 0")
    return closing, opening
