"""What branches on the fitted mesh have in common, of one contact and of several.

Depths are positive down into the layer, P is positive where pressed, U is 0 without contact and
counts with the work of adhesion of closing. Lines of a `Point` are a flat tuple, both ends of every
contact from left to right, () or None without contact; about an axis they are radii, and the left
line of a contact on the axis is 0. `Point.ends` are the first and the last line, nan without.
`ContactLines.gradual` is whether lines never jump, as in a line contact of a convex profile.

l = √(γ₁/k) is `Scene.elastocapillary_length`. `ContactLines.rests` gives the depths D at which
lines rest; its `size` is the largest depth that occurs, and TIE the part of it that is rounding.
`Branch.totals` are U and P of points, (2, n). Where a line is `Pinned` is a pair of words, of the
left and of the right outermost line; `Branch.pinned` gives "edge" where a line is at an end of the
body, else "". `corners` of the indenter are where its slope jumps or the body ends.

`Integrals.at(x)` are five integrals from a fixed place to each x, (5, n), over dx, or over 2πr dr
about an axis: of 1, g, g², γ₁ψ(f') and c s(f'). Here g is the indentation at the depth of first
touch, ψ the stretch of the surface, c the pattern's factor on the work of adhesion, and s is
1 with small slopes, √(1 + f'²) with finite ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from discretization.fitted.contact_lines import ContactLines
from discretization.fitted.rest_depths import TIE
from discretization.paths.branch import Branch, Pinned, Point
from discretization.quadrature import Integrals


class JumpRules(NamedTuple):
    """Which lines jump, and which only seem to by rounding.

    At a tenth or ten times its value each leaves the 2 or more random states and paths that read it
    as they are to 1e-9: `python -m tests.sensitivity discretization.paths.fitted_branch`.

    Attributes
    ----------
    unknown : float
        Of l: how well a line is known at a fold. D is flat there, so that the rounding of depths,
        1e-16 of them, moves a line by about its square root, 1e-8; with a margin of 100. Lines that
        move no further do not jump.
    resolution : float
        Of l: how far lines may be off by rounding, wherever they rest.
    """

    unknown: float = 1e-6
    resolution: float = 1e-9


JUMPS = JumpRules()


class FittedBranch(Branch):
    """Contacts on the fitted mesh under a prescribed depth.

    Attributes
    ----------
    contact_lines : ContactLines
        The lines of a contact, their rest depths and their free surfaces.
    """

    contact_lines: ContactLines

    @property
    def integrals(self) -> Integrals:
        """Integrals over the profile, by which U and P of contacts are differences.

        Every kind of branch has to give its own.
        """
        raise NotImplementedError

    @property
    def resolution(self) -> float:
        """The length by which lines may be off, by rounding [length]."""
        return JUMPS.resolution * self.scene.elastocapillary_length

    def pinned(self, point: Point) -> Pinned:
        """Where each of the outermost lines is pinned: "edge", "tip", or "" where it is free.

        A tip is a corner at the lowest point of a convex profile. A line that is pinned there is
        put at that very x, so that they are compared without a tolerance.
        """
        tip = self.contact_lines.profile.lowest
        at_edges = super().pinned(point)
        if not self.contact_lines.gradual or tip not in self.scene.indenter.corners:
            return at_edges
        both = zip(at_edges, point.ends, strict=True)
        first, last = (edge or ("tip" if x == tip else "") for edge, x in both)
        return first, last

    def jumps(self, before: Point, after: Point) -> bool:
        """Whether lines jump between two points at the same depth, before and after an event.

        They do where the number of contacts changes, but for the first and the last contact of
        lines that never jump; else where one moves further than it is unknown, and the energy
        falls by more than the rounding of the depth makes of it.
        """
        if not after.lines or not before.lines:
            return not self.contact_lines.gradual
        if len(before.lines) != len(after.lines):
            return True
        moved = np.abs(np.subtract(before.lines, after.lines)).max()
        if not moved > JUMPS.unknown * self.scene.elastocapillary_length:
            return False
        energy, force = self.totals([before, after])
        noise = TIE * self.contact_lines.rests.size * float(np.abs(force).sum())
        return bool(energy[0] - energy[1] > noise)

    def opened(self, before: Point, after: Point) -> float:
        """What opens between two points: ∫ c s(f') over it [length], an area about an axis.

        c is the pattern's factor and s as in the head. It is the sum of what each line has receded
        by; one that has advanced counts as 0. If the number of lines changes, lines cannot be
        paired, and it is what all contacts have lost of their length together, 0 if they gain.

        before, after: in the order of the path, with nothing but smooth motion or one event in
        between. 0 if either is detached: contact then begins or ends in an event, by whose energies
        that is counted.
        """
        if not before.lines or not after.lines:
            return 0.0
        # ∫ c s(f') from a fixed place to each line, the last of the five integrals.
        to_before = self.integrals.at(np.array(before.lines))[4]
        to_after = self.integrals.at(np.array(after.lines))[4]
        # On smooth motion the number changes only where nodes do not see a narrow gap, which is
        # then part of the sums: it adds no more than its own width.
        if len(before.lines) != len(after.lines):
            in_contact_before = float(np.diff(to_before)[::2].sum())
            in_contact_after = float(np.diff(to_after)[::2].sum())
            return max(0.0, in_contact_before - in_contact_after)
        # Left lines recede towards +x, right ones towards -x.
        receded = (to_before - to_after).reshape(-1, 2) * (-1, 1)
        return float(np.maximum(receded, 0.0).sum())
