"""What happens on a load path between two steps."""

from __future__ import annotations

import math
from typing import NamedTuple


class Snapshot(NamedTuple):
    """A state beside an event: depth, force P, energy U, contact lines (nan when detached).

    left, right: the outermost lines; inner: those in between, where there are several contacts.
    With rotational symmetry (axisymmetric) they are radii, and left is 0 for a contact that
    includes the axis.
    """

    depth: float
    force: float
    energy: float
    left: float
    right: float
    inner: tuple[float, ...] = ()
    axisymmetric: bool = False

    @property
    def lines(self) -> tuple[float, ...]:
        """All contact lines from left to right."""
        return self.left, *self.inner, self.right

    @property
    def half_width(self) -> float:
        """Half the total contact length a, or the radius of the outermost line; 0 if detached."""
        if math.isnan(self.left):
            return 0.0
        lines = self.lines
        widths = [right - left for left, right in zip(lines[::2], lines[1::2], strict=True)]
        return self.right if self.axisymmetric else sum(widths) / 2


class Event(NamedTuple):
    """Something that happened at one value of the control, between two steps.

    kind: "touch" or "jump-in" (contact begins, without or with energy released), "tip depinning",
    "edge depinning" and their opposites "... pinning", "detachment" (the contact has closed up),
    "pull-off" (unstable under force or machine control), "jump" (unstable, still in contact),
    "nucleation", "splitting" (another contact), "coalescence" or "closing" (one contact less).
    control: the value at which it happens; before, after: the states; energy_released: the drop
    of U at fixed depth, of U - F d at fixed force, of U + K/2 (D - d)² at a fixed drive. Under
    force control a pull-off ends where the contact closes up under the dead load.
    """

    kind: str
    control: float
    before: Snapshot
    after: Snapshot
    energy_released: float
    step: int

    @property
    def depth(self) -> float:
        """d before the event."""
        return self.before.depth

    @property
    def force(self) -> float:
        """P before the event."""
        return self.before.force


class PullOff(NamedTuple):
    """The most tensile state of a path."""

    force: float
    depth: float
    half_width: float
