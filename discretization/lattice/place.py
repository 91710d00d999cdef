"""What a contact line feels where it is: the energy of its next link and of the tail beyond."""

from __future__ import annotations

from typing import Any

import numpy as np


class Place:
    """What contact lines at some nodes, all facing the same way, need to know (small slopes).

    Everywhere the same on a lattice of a line contact, which is a place; around an axis
    `Lattice.at` says what it is. weight: of the links the lines meet next; loss: 1 - λ there; root:
    √λ as far as it depends on the place; link_over_decay: t/λ of links of weight 1, on which gaps
    are scaled; end_stiffness: of the tail; cell, w: what a link covers, and its work of adhesion.
    """

    weight: Any
    root: Any
    loss: Any
    link_over_decay: float
    end_stiffness: Any
    cell: float
    w: float

    def gap(self, f: Any, f_next: Any, depth: Any) -> Any:
        """λg - g': what node m+1 is away from contact if the contact ends at node m, over `root`.

        f, f_next: heights of the profile there, g = d - f.
        """
        return (f_next - f - self.loss * (depth - f)) / self.root

    def rest_depth(self, f: Any, f_next: Any, work: Any) -> Any:
        """D: the depth at which a line passes links of this adhesion [energy/length] each.

        There ΔE of `advance_cost` is zero: the gap is √(2 work λ/t).
        """
        reach = np.sqrt(2 * work / (self.link_over_decay * self.weight)) * self.root
        return f + (f_next - f - reach) / self.loss

    def stored(self, gap: Any) -> Any:
        """Energy that a line's advance over links of this gap takes, without their adhesion."""
        return self.link_over_decay * self.weight / 2 * gap * gap

    def advance_cost(self, gap: Any) -> Any:
        """Energy by which a line's advance over one link changes the re-equilibrated energy.

        From end node m to m+1, with the tail re-equilibrated before and after,

            ΔE = kΔx g'²/2 + t(g'-g)²/2 + F(g') - F(g) - wΔx = t/(2λ) (λg - g')² - wΔx,

        g = g_m, g' = g_{m+1}.
        """
        return self.stored(gap) - self.w * self.cell * self.weight

    def advance(self, f: Any, f_next: Any, depth: Any) -> tuple[Any, Any, Any]:
        """Gap, ΔE and ΔP of a line's advance over links at the heights f, f_next.

        ΔP = dΔE/dd = kΔx g' + F'(g') - F'(g).
        """
        gap = self.gap(f, f_next, depth)
        rate = -self.link_over_decay * self.weight * self.loss / self.root
        return gap, self.advance_cost(gap), rate * gap

    def tail_energy(self, u: Any) -> Any:
        """F(u) of a tail whose first node is displaced by u, without that node's own spring."""
        return self.end_stiffness / 2 * u * u

    def tail_reaction(self, u: Any) -> Any:
        """F'(u): pull of the tail's first link."""
        return self.end_stiffness * u

    def tail_force(self, u: Any) -> Any:
        """Σ_{j>=1} kΔx u_j: force of the tail's springs; the same number in balance."""
        raise NotImplementedError

    def tail_stiffness(self, u: Any) -> Any:
        """F''(u)."""
        return self.end_stiffness
