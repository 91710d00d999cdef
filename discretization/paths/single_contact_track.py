"""The lines of a contact that stays alone while nothing else happens to it.

Depths d and rest depths D of lines are positive down into the layer [length]. `sides` of a contact
are (-1, 1), of the left and the right line, or (1,) about an axis, where the right line is the only
one; a line is at rest where D = d, and D grows outwards, in the direction of its side along x.
`SingleContact.rest_depth(side, x, beside)` is D, at corners just outwards (beside 1) or inwards
(-1) of x; `find(side, depth)` is the place where a line rests; `lowest` is the innermost place
where one may rest, and D there: the depth at which contact is lost.

`SingleContact.pointed(x)` is whether a contact of the one point x stands for one that is too narrow
for doubles, and `solve` the free surface beside a line, ValueError where it would turn over. TIE is
what is rounding of depths over their size, `crossings` finds zeros of many functions between
brackets. `corners` are where the slope of the profile jumps.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import NotCertifiedError
from discretization.fitted.rest_depths import TIE
from discretization.fitted.single_contact import SingleContact
from discretization.roots import crossings
from energy.arrays import Array, Indices

# Parts of the size of depths. A tenth or ten times as large, none changes a result of 16 random
# paths (`python -m tests.sensitivity discretization.paths.single_contact_track`).
_LOST = 5e-15  # so much earlier a contact is lost: some twenty roundings, D is not known better
_KNOWN = 1e-16  # a D - d that is half a rounding; a line need not be known better
NEAR = 1e-11  # D - d of lines that are read next to where they disappear


@dataclass(frozen=True, eq=False)
class SingleContactTrack:
    """The free lines of a contact, one about an axis, at rest from a depth to another.

    Each has one place at every depth in between (../fitted/single_contact.py). So the lines at any
    depth are roots of D = d between the first and the last place, and need not be followed.

    Attributes
    ----------
    contact : SingleContact
        Finds lines at a depth.
    start, end : float
        Depths [length].
    first, last : ndarray (2,) or (1,)
        Lines there, in the order of the sides of the contact [length].
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
            Left and right line at the start; about an axis the left one is 0 [length].
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
        sides = np.array(contact.sides)
        first = np.array(lines[-sides.size :])
        innermost, lost_at = contact.lowest
        size = contact.size(start, end)
        ahead = contact.rest_depth(sides, first, 1 if end > start else -1)
        # About an axis D falls up to the innermost place: a line inside of it is not stable.
        too_far_in = contact.scene.axisymmetric and first[0] < innermost
        pointed = first[0] == first[-1] and contact.pointed(float(first[0]))
        at_rest = contact.lines(start) == lines if pointed else np.abs(ahead - start) <= TIE * size
        if too_far_in or not np.all(at_rest):  # a line that is pinned is not at rest just ahead
            return None
        end = max(end, min(lost_at + _LOST * size, start))  # no further than the loss of contact
        last = (
            np.array([contact.find(side, end) for side in contact.sides]) if end != start else first
        )
        corners = np.reshape(contact.scene.indenter.corners, (-1, 1))
        meets_corner = ((corners - first) * (corners - last) <= 0) & (corners != first)
        stays = end != start and (last == first).any() and not pointed
        if meets_corner.any() or stays:
            return None
        for side, x in zip(contact.sides, last.tolist(), strict=True):
            contact.solve(side, x, end)  # raises where a surface turns over
        return cls(contact, start, end, first, last, size)

    def lines(self, depths: Array) -> Array:
        """Lines of both free surfaces at depths in between: the roots of D = d.

        They lie between the first and the last line, and are found to rounding of D.

        Parameters
        ----------
        depths : ndarray (k,)
            [length].

        Returns
        -------
        ndarray (k, 2, 2)
            [[-inf, left], [right, inf]], the left and the right line of both tails, at each depth;
            left is 0 about an axis [length].

        Raises
        ------
        NotCertifiedError
            If a line does not come to rest.
        """
        sides = np.array(self.contact.sides)
        # In a row all depths of the first line, and then those of the second one.
        count = depths.size
        side = np.repeat(sides, count)
        goal = np.tile(depths, sides.size)
        first = np.repeat(self.first, count)
        last = np.repeat(self.last, count)
        span = self.end - self.start

        def off(x: Array, own: Indices) -> Array:
            """D - d at x of the lines with these numbers in the row."""
            # The first place may be a corner, which is read on the side to which the line moves.
            aside = np.sign(span) * (x == first[own])
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
        # Flat (-inf, left, right, inf); about an axis only the right line is set.
        surfaces = np.tile([-math.inf, 0.0, 0.0, math.inf], (count, 1))
        surfaces[:, 3 - sides.size : 3] = x.reshape(sides.size, count).T
        return surfaces.reshape(count, 2, 2)

    def _near_apex(self, side: int, depth: float) -> float:
        """The line on this side at a depth, by a search that resolves it next to the apex.

        NotCertifiedError if D is not the depth there, and it is no contact of one point.
        """
        x = self.contact.find(side, depth)
        off = abs(float(self.contact.rest_depth(side, x)) - depth)
        if off > NEAR * self.size and not self.contact.pointed(x):
            raise NotCertifiedError(
                f"the contact between depth = {self.start!r} and {self.end!r} does not come to "
                "rest; try other depths, or method='lattice'"
            )
        return x
