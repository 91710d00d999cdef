"""The lines of a contact that stays alone while nothing else happens to it."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.rest_depths import TIE
from discretization.fitted.single_contact import SingleContact
from discretization.roots import crossings
from energy.arrays import Array, Indices

_LOST = 5e-15  # of the size of depths: so much earlier a contact is lost, D is not known better
_KNOWN = 1e-16  # of the same: a D - d that is rounding; a line need not be known better
NEAR = 1e-11  # of the same: D - d of lines that are read next to where they disappear


@dataclass(frozen=True, eq=False)
class SingleContactTrack:
    """The lines of a contact, one about an axis, at rest from a depth to another.

    Each has one place at every depth in between (../fitted/single_contact.py).
    size: of their depths.
    """

    contact: SingleContact
    start: float
    end: float
    first: Array
    last: Array
    size: float

    @classmethod
    def of(cls, contact: SingleContact, lines: tuple[float, ...], start: float, end: float) -> Any:
        """The lines on the path towards a depth, or to where the contact is lost.

        None where a line is held, jumps or meets a corner; ValueError where the surface turns over.
        """
        first, (place, low) = np.array(lines[-len(contact.sides) :]), contact.lowest
        sides, size = np.array(contact.sides), contact.size(start, end)
        ahead = contact.rest_depth(sides, first, 1 if end > start else -1)
        around = contact.scene.axisymmetric and first[0] < place
        pointed = first[0] == first[-1] and contact.pointed(float(first[0]))
        at_rest = contact.lines(start) == lines if pointed else np.abs(ahead - start) <= TIE * size
        if around or not np.all(at_rest):
            return None
        end = max(end, min(low + _LOST * size, start))
        last = (
            np.array([contact.find(side, end) for side in contact.sides]) if end != start else first
        )
        corners = np.reshape(contact.scene.indenter.corners, (-1, 1))
        met = ((corners - first) * (corners - last) <= 0) & (corners != first)
        if met.any() or (end != start and (last == first).any() and not pointed):
            return None
        for side, x in zip(contact.sides, last.tolist(), strict=True):
            contact.solve(side, x, end)
        return cls(contact, start, end, first, last, size)

    def lines(self, depths: Array) -> Array:
        """Lines (k, 2, 2) of both free surfaces at depths (k,) in between."""
        sides, count = np.array(self.contact.sides), depths.size
        side, goal = np.repeat(sides, count), np.tile(depths, sides.size)
        one, other = np.repeat(self.first, count), np.repeat(self.last, count)

        def off(x: Array, own: Indices) -> Array:
            aside = np.sign(span) * (x == one[own])  # the first may be a corner
            return np.asarray(self.contact.rest_depth(side[own], x, aside) - goal[own])

        span, size = self.end - self.start, self.size
        with np.errstate(divide="ignore", invalid="ignore"):  # where nothing moves
            guess = np.where(other == one, one, one + (other - one) * ((goal - self.start) / span))
            rise = np.where(other == one, 1.0, span / (other - one))
        low, high = np.minimum(one, other), np.maximum(one, other)
        x = crossings(off, low, high, guess, rise, _KNOWN * size)
        for i in np.flatnonzero(np.abs(off(x, np.arange(x.size))) > NEAR * size).tolist():
            x[i] = self._beside_apex(int(side[i]), float(goal[i]))
        found = np.tile([-math.inf, 0.0, 0.0, math.inf], (count, 1))
        found[:, 3 - sides.size : 3] = x.reshape(sides.size, count).T
        return found.reshape(count, 2, 2)

    def _beside_apex(self, side: int, depth: float) -> float:
        """A line found by the logarithm of its distance from the apex, or at the apex."""
        x = self.contact.find(side, depth)
        off = abs(float(self.contact.rest_depth(side, x)) - depth)
        if off > NEAR * self.size and not self.contact.pointed(x):
            raise NotCertifiedError(
                f"the contact between depth = {self.start!r} and {self.end!r} does not come to "
                "rest; try other depths, or method='lattice'"
            )
        return x
