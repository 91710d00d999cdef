"""How one contact line moves with the depth where it feels no other line.

D(x), the depth at which a line rests at x, is then a function of its own place alone. As the depth
grows a line advances to the first place at which D is not less; as it falls, the line recedes to
the first place at which D is not greater. So it stays at a corner, past which D jumps, moves along
a part on which D is monotone, or jumps from where D turns back to the next place that holds it.

Conventions
-----------
Depths d and D are positive down into the layer [length]. `side` is 1 for a line whose contact is on
its left, -1 for one whose contact is on its right; outwards of the contact is the direction `side`
along x. `direction` is 1 where the depth grows and the line advances outwards, -1 where it falls
and the line recedes inwards; the line moves in the direction side · direction along x. `aside` says
on which side of x D is read: 1 just outwards, -1 just inwards, 0 at x itself; they differ at
corners. direction · D is compared with direction · d throughout, so that "the line moves on" is
direction · (D - d) < 0, and it stops where this is not negative.

Joints of the profile are its corners, the edges of a pattern of adhesion, and the ends of the
window in which it is known: D may jump there, and there only. `profile.x` are its samples and
`profile.joints` the joints, both increasing; `profile.beyond(a, b)` is the slice of the samples
strictly between a and b, given in either order.

`RestDepths.one_sided(side, x, facing, aside, direction)` is D, with the positions of the lines that
are faced, infinite for none; its `size` is the largest depth that occurs, of which TIE is what is
rounding. `unknown(depth, x)` is the error of a line at the end of the known profile.

`crossings(h, low, high, guess, rise, enough)` gives zeros (n,) of n functions between low and high;
h(x, own) are values of those numbered `own`, the signs of `rise` say in which direction each goes
through 0, and |h| up to `enough` is 0. `bracketed(h, inside, outside)` is the zero of h, a function
of a float, with h <= 0 inside and h > 0 outside; another sign at an end counts as 0 there, so that
it then converges to that end. `bracketed_minimum(h, low, high, enough)` is where h, a function of
arrays, is least, and h there; it ends early where h <= `enough`, which -inf rules out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.fitted.rest_depths import TIE, RestDepths
from discretization.profile import unknown
from discretization.roots import bracketed, bracketed_minimum, crossings
from energy.arrays import Array, Indices, Mask

# Of the size of depths: a D - d that is half a rounding; a line need not be known better.
_KNOWN = 1e-16


class Arc(NamedTuple):
    """What a line does first on the way to another depth: it moves in one direction, or stays.

    Attributes
    ----------
    start, end : float
        Places from and to which it moves, the same if it stays [length].
    first, last : float
        Depths there [length].
    how : {"goal", "free", "jump"}
        Why it ends: the goal is reached, the line comes to a joint or is free to leave one, or D
        turns back, so that the line jumps.
    """

    start: float
    end: float
    first: float
    last: float
    how: str


@dataclass(frozen=True, eq=False)
class SingleLine:
    """A contact line that feels no other one.

    Attributes
    ----------
    rests : RestDepths
        Gives D(x).
    side : {1, -1}
        1 if the contact is on the left of the line, -1 if on its right.
    """

    rests: RestDepths
    side: int

    def rest_depth(self, x: Array, aside: Array | int, direction: int) -> Array:
        """D (n,) at places x (n,), read just outwards (aside 1), inwards (-1) or at them (0).

        direction: 1 with the adhesion of a contact that closes, -1 of one that opens. The surface
        beside the line is a tail: the line that it would face is at infinity.
        """
        none = np.full(x.shape, math.copysign(math.inf, self.side))
        return self.rests.one_sided(self.side, x, none, aside, direction)

    def _at(self, x: float, aside: int, direction: int) -> float:
        """D at one place, parameters as of `rest_depth`."""
        return float(self.rest_depth(np.array([x]), aside, direction)[0])

    def arc(self, x: float, depth: float, goal: float) -> Arc:
        """What a line at rest does first on the path to another depth.

        Parameters
        ----------
        x, depth : float
            Where it rests, and at which depth [length].
        goal : float
            [length].

        Returns
        -------
        Arc

        Raises
        ------
        ValueError
            If the line leaves the known profile.
        """
        direction = 1 if goal >= depth else -1
        ahead = self._at(x, direction, direction)
        tie = TIE * self.rests.size
        if direction * (ahead - depth) > tie:  # pinned at a joint, past which D jumps
            if direction * (ahead - goal) >= 0:
                return Arc(x, x, depth, goal, "goal")
            return Arc(x, x, depth, ahead, "free")
        if direction * (ahead - depth) < -tie:  # nothing holds it where it is
            return Arc(x, x, depth, depth, "jump")
        places = self._ahead(x, direction)
        if not places.size:  # beyond the last joint
            raise unknown(depth, x)
        # Samples up to the next joint are read on the side from which the line comes. It moves
        # with the depth as long as direction · D grows from sample to sample.
        values = direction * self.rest_depth(places, -direction, direction)
        before = np.append(direction * depth, values[:-1])
        turn = _first(values < before - tie)
        reached = _first(values >= direction * goal)
        if reached < min(turn, values.size):
            start = x if reached == 0 else float(places[reached - 1])
            end = self._where(goal, start, float(places[reached]), direction)
            return Arc(x, end, depth, goal, "goal")
        if turn == values.size:
            return Arc(x, float(places[-1]), depth, direction * float(values[-1]), "free")
        # The maximum of direction · D is between the samples before and after the last that grew;
        # the start of the search stands for a sample before the first one.
        around = np.concatenate([[x, x], places])[turn : turn + 3 : 2]
        top, value = self._turn(float(around[0]), float(around[1]), direction)
        if value < direction * depth:
            return Arc(x, x, depth, depth, "jump")
        if value >= direction * goal:
            return Arc(x, self._where(goal, x, top, direction), depth, goal, "goal")
        return Arc(x, top, depth, direction * value, "jump")

    def landing(self, x: float, depth: float, direction: int) -> float | None:
        """The first place ahead at which a line that jumps rests, None where there is none.

        A sample holds the line only where direction · D exceeds direction · d by more than a tie:
        where they are equal, as all along a part on which D is constant, moving on costs nothing.
        Past a joint D may jump up, and then equality is enough, as the line has come to a corner.

        Parameters
        ----------
        x, depth : float
            Where it jumps from, and at which depth [length].
        direction : {1, -1}
            1 where it advances.
        """
        if direction * (self._at(x, direction, direction) - depth) > TIE * self.rests.size:
            return x
        while True:
            places = self._ahead(x, direction)
            if not places.size:
                return None
            values = direction * (self.rest_depth(places, -direction, direction) - depth)
            rests = _first(values > TIE * self.rests.size)  # where it costs nothing it moves on
            if rests < values.size:
                start = x if rests == 0 else float(places[rests - 1])
                return self._where(depth, start, float(places[rests]), direction)
            x = float(places[-1])  # the next joint, where D may jump to where it holds the line
            if direction * (self._at(x, direction, direction) - depth) >= 0:
                return x

    def places(self, arc: Arc, depths: Array) -> Array:
        """Where the line is at depths (n,) on an arc [length]; beyond its ends it is at these."""
        if arc.start == arc.end or arc.first == arc.last:
            return np.full(depths.shape, arc.end)
        direction = 1 if arc.last >= arc.first else -1
        inside = np.clip(depths, min(arc.first, arc.last), max(arc.first, arc.last))

        def off(x: Array, own: Indices) -> Array:
            """D - d; the ends of the arc, which may be joints, are read on the side of the arc."""
            aside = np.where(x == arc.start, direction, np.where(x == arc.end, -direction, 0))
            return self.rest_depth(x, aside, direction) - inside[own]

        share = (inside - arc.first) / (arc.last - arc.first)
        guess = arc.start + (arc.end - arc.start) * share
        rise = np.full(depths.shape, (arc.last - arc.first) / (arc.end - arc.start))
        low, high = sorted((arc.start, arc.end))
        count = depths.size
        found = crossings(
            off, np.full(count, low), np.full(count, high), guess, rise, _KNOWN * self.rests.size
        )
        found = np.where(inside == arc.last, arc.end, found)
        return np.where(inside == arc.first, arc.start, found)

    def _ahead(self, x: float, direction: int) -> Array:
        """Samples of the profile ahead of a line up to the next joint, in the order of the motion.

        They increase where side · direction is 1, else they decrease; the last one is the joint.
        Empty if there is no joint ahead: the line is at the end of the known profile.
        """
        profile = self.rests.profile
        towards = self.side * direction
        joints = profile.joints
        ahead = joints[towards * (joints - x) > 0]
        if not ahead.size:
            return ahead
        joint = float(ahead[0] if towards > 0 else ahead[-1])
        between = profile.x[profile.beyond(x, joint)][::towards]
        return np.append(between, joint)

    def _where(self, depth: float, inside: float, outside: float, direction: int) -> float:
        """The place between two others at which D is a depth, and past which the line is held.

        inside: the place from which the line comes, where direction · (D - d) is <= 0 or at most a
        tie above it; outside: one where it is >= 0. If it is above 0 at both, the line is held at
        `inside` already, to which `bracketed` then converges, to 4e-16 of it: the right answer, as
        the tie is rounding.
        """

        def off(x: float) -> float:
            """direction · (D - d), at the two places on the side between them."""
            aside = -direction if x == outside else direction if x == inside else 0
            return direction * (self._at(x, aside, direction) - depth)

        if off(outside) == 0:
            return outside
        return bracketed(off, inside, outside)

    def _turn(self, start: float, end: float, direction: int) -> tuple[float, float]:
        """Where direction · D has a maximum between two places, and direction · D there."""
        low, high = sorted((start, end))
        # From the negative a minimum is sought, in all rounds: no value is below -inf.
        place, value = bracketed_minimum(
            lambda x: -direction * self.rest_depth(x, 0, direction), low, high, -math.inf
        )
        return place, -value


def _first(mask: Mask) -> int:
    """The first place where a mask is true, its length if nowhere."""
    return int(np.argmax(mask)) if mask.any() else mask.size
