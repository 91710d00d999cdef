"""Closed forms with rotational symmetry, f(r) turned about its axis; small slopes but for `finite`.

| module | meaning |
| --- | --- |
| `surface` | free surface outside a contact, and the free disc inside a ring |
| `contact_line` | the condition that places an outer line, and the inner line of a ring |
| `force` | force on an indenter of any profile |
| `flat_punch` | flat cylinder: pinned line, detachment, global pull-off |
| `cone` | cone: radius, force, energy, pull-off, jumps |
| `sphere` | parabola: the same, expansions for small and large tension, w = 0 |
| `power_law` | f = c rⁿ, n >= 1 |
| `finite` | menisci of finite slope around narrow and wide contacts |

Symbols and checks are those of `energy.cards`, with the radius a of the contact for its half-width,
forces in N and energies in J. q = K₀(a/l)/K₁(a/l) is what the circular line adds to the formulas of
the line contact; it tends to 1 for a ≫ l. The Bessel functions are evaluated scaled: a/l from 1e-4
to 1e6 and beyond keeps twelve digits.
"""

from energy.cards.axisymmetric import (
    cone,
    contact_line,
    finite,
    flat_punch,
    force,
    power_law,
    sphere,
    surface,
)

__all__ = [
    "cone",
    "contact_line",
    "finite",
    "flat_punch",
    "force",
    "power_law",
    "sphere",
    "surface",
]
