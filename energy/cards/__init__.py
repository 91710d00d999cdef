"""Closed forms, each a pure function with its equation number.

Of the line contact but for `axisymmetric`, with small slopes but for `finite`.

| module | equations | meaning |
| --- | --- | --- |
| `foundation` | (2), (3) | uniaxial modulus and stiffness of the thin layer |
| `tail` | (5)-(7), (13) | the free surface outside the contact |
| `contact_line` | (1), (8), (12)-(18) | contact angle; the condition that places the line |
| `force` | (9)-(11) | force on an indenter of any profile |
| `plane` | (19), (20) | rigid plane: the critical separation |
| `flat_punch` | (21)-(23) | flat punch: pinned line, detachment, global pull-off |
| `wedge` | (24)-(30) | wedge: free line, tip-pinned line, pull-off |
| `parabola` | (31)-(33) | parabola: half-width, force, energy, pull-off |
| `nonadhesive` | (34)-(40) | w = 0: no kink at the line |
| `power_law` | (11), (16) | f = c|x|ⁿ, n >= 1 |
| `displacement_control` | | jump-in, detachment, loop area at imposed depth; Maxwell point |
| `load_control` | | the same under a dead load |
| `machine_control` | | the same under a machine of finite stiffness |
| `two_works` | | closing and opening works of adhesion: pinned line, loop areas |
| `finite` | (8), (10), (16) | true surface length: Young's law at any slope |
| `layer` | (16) | the layer itself: half-space (JKR), thin and incompressible, a ≫ h |
| `axisymmetric` | | a package: sphere, cone, flat cylinder, power law, ring |

| symbol | name | meaning | unit | range |
| --- | --- | --- | --- | --- |
| k | `k` | foundation stiffness Ẽ/h | N/m³ | > 0 |
| γ₁ | `gamma1` | surface tension of the free surface | N/m | >= 0 |
| w | `w` | work of adhesion | J/m² | >= 0 |
| w_closing | `w_closing` | work of adhesion gained on closing, <= w | J/m² | >= 0 |
| K | `K` | stiffness of the machine per length of the contact | N/m² | > 0 |
| R, tan δ, c | `R`, `delta`, `c` | radius; wedge angle in rad; power-law coefficient | | > 0 |
| d | `d` | depth of the level f = 0 below the undeformed surface | m | |
| a | `a` | half-width of the contact | m | >= 0 |
| u | | surface displacement, positive downwards | m | |
| u_a | `u_a` | u at the contact line, d − f(a) | m | |
| l, δ₀, α | | √(γ₁/k), √(2w/k), √(2w/γ₁) | m, m, 1 | |
| P | | force per length, positive = compressive | N/m | |
| U | | energy per length; 0: undeformed surface, no contact | N | |

Any consistent units do. Positions, depths and half-widths come first, parameters by keyword;
all broadcast (the exponent n of a power law is one number). Arguments outside the range of a
formula raise ValueError. Depths and forces belong to the *metastable* contact, the one that
touched and then moved to its depth; cards of the lowest energy of all say `global`.

`Jump` (force, depth, half-width and energy released) and `PullOff` (the first three) are what cards
of instabilities return.
"""

from energy.cards import (
    axisymmetric,
    contact_line,
    displacement_control,
    finite,
    flat_punch,
    force,
    foundation,
    layer,
    load_control,
    machine_control,
    nonadhesive,
    parabola,
    plane,
    power_law,
    tail,
    two_works,
    wedge,
)
from energy.cards._types import Jump, PullOff

__all__ = [
    "Jump",
    "PullOff",
    "axisymmetric",
    "contact_line",
    "displacement_control",
    "finite",
    "flat_punch",
    "force",
    "foundation",
    "layer",
    "load_control",
    "machine_control",
    "nonadhesive",
    "parabola",
    "plane",
    "power_law",
    "tail",
    "two_works",
    "wedge",
]
