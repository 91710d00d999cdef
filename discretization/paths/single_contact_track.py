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

    Attributes
    ----------
    contact : SingleContact
        Finds lines at a depth.
    start, end : float
        Depths [length].
    first, last : ndarray (2,) or (1,)
        Lines there [length].
    size : float
        Of depths, by which rounding is judged [length].
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

        Parameters
        ----------
        contact : SingleContact
        lines : tuple of float
            At the start [length].
        start, end : float
            Depths [length].

        Returns
        -------
        SingleContactTrack or None
            None where a line is pinned, jumps or meets a corner.

        Raises
        ------
        ValueError
            If a free surface turns over.
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
        """Lines (k, 2, 2) of both free surfaces at depths (k,) in between: the roots of D = d.

        They lie between the first and the last line, and are found to rounding of D.
        """
        sides = np.array(self.contact.sides)
        count = depths.size
        side = np.repeat(sides, count)
        goal = np.tile(depths, sides.size)
        first = np.repeat(self.first, count)
        last = np.repeat(self.last, count)
        span = self.end - self.start

        def off(x: Array, own: Indices) -> Array:
            """D - d of lines with these numbers."""
            aside = np.sign(span) * (x == first[own])  # the first may be a corner
            return np.asarray(self.contact.rest_depth(side[own], x, aside) - goal[own])

        moves = last != first
        with np.errstate(divide="ignore", invalid="ignore"):  # where nothing moves
            guess = np.where(moves, first + (last - first) * ((goal - self.start) / span), first)
            rise = np.where(moves, span / (last - first), 1.0)
        low = np.minimum(first, last)
        high = np.maximum(first, last)
        x = crossings(off, low, high, guess, rise, _KNOWN * self.size)

        missed = np.abs(off(x, np.arange(x.size))) > NEAR * self.size
        for i in np.flatnonzero(missed).tolist():
            x[i] = self._near_apex(int(side[i]), float(goal[i]))
        surfaces = np.tile([-math.inf, 0.0, 0.0, math.inf], (count, 1))
        surfaces[:, 3 - sides.size : 3] = x.reshape(sides.size, count).T
        return surfaces.reshape(count, 2, 2)

    def _near_apex(self, side: int, depth: float) -> float:
        """A line found by the logarithm of its distance from the apex, or at the apex."""
        x = self.contact.find(side, depth)
        off = abs(float(self.contact.rest_depth(side, x)) - depth)
        if off > NEAR * self.size and not self.contact.pointed(x):
            raise NotCertifiedError(
                f"the contact between depth = {self.start!r} and {self.end!r} does not come to "
                "rest; try other depths, or method='lattice'"
            )
        return x
