"""What branches on the fitted mesh have in common, of one contact and of several."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from discretization.fitted.contact_lines import ContactLines
from discretization.fitted.rest_depths import TIE
from discretization.paths.branch import Branch, Pinned, Point
from discretization.quadrature import Integrals


class JumpRules(NamedTuple):
    """Which lines jump, and which only seem to by rounding.

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
        """Integrals over the profile, by which U and P of contacts are differences."""
        raise NotImplementedError

    @property
    def resolution(self) -> float:
        """The length by which lines may be off, by rounding [length]."""
        return JUMPS.resolution * self.scene.elastocapillary_length

    def pinned(self, point: Point) -> Pinned:
        """Where each of the outermost lines is pinned: "edge", "tip" of a convex profile, or ""."""
        tip = self.contact_lines.profile.lowest
        at_edges = super().pinned(point)
        if not self.contact_lines.gradual or tip not in self.scene.indenter.corners:
            return at_edges
        both = zip(at_edges, point.ends, strict=True)
        first, last = (edge or ("tip" if x == tip else "") for edge, x in both)
        return first, last

    def jumps(self, before: Point, after: Point) -> bool:
        """Whether lines jump; not by what the energy changes within the rounding of a depth."""
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
        """The length that opens between two points, weighted with the pattern's factor [length]."""
        if not before.lines or not after.lines:
            return 0.0
        bound = [self.integrals.at(np.array(point.lines))[4] for point in (before, after)]
        if len(before.lines) != len(after.lines):  # nodes do not see a narrow gap
            in_contact = [float(np.diff(each)[::2].sum()) for each in bound]
            return max(0.0, in_contact[0] - in_contact[1])
        receded = (bound[0] - bound[1]).reshape(-1, 2) * (-1, 1)
        return float(np.maximum(receded, 0.0).sum())
