"""At which depth a contact is lost that is narrower than a link.

Between nodes a line rests at x where a link in the middle of which it is would be passed at this
depth: the depth of `Thresholds.advance`, with heights between the nodes and whatever distance to
the line that it faces. Both lines of a contact that is lost meet at one x, and the lines that they
face rest as well, so that of x, the depth d, and the faced lines q and p

    D(x; q) = d,   D(x; p) = d,   D(q; x) = d,   D(p; x) = d,

found by Newton's method; a line that is faced by nothing, or pinned at a corner, drops out. The
depth is that of the continuum to O(Δx²), while the last link of a contact opens up to half a link
too early, at an error O(Δx).

Conventions
-----------
Positions x of lines, q and p are in numbers of nodes of the row, from left to right and not whole;
depths and D are positive down into the layer, heights upwards [length]. D(x; q) is the depth at
which a line at x rests that has its free surface up to another line at q: `ContactLoss.rest_depth`.
`side` is 1 if that surface is on the right of the line, -1 if it is on its left. The contact that
is lost has the line q on its left and p on its right, each None where there is none; its own left
line has side -1 and its right one side 1, while q, a right line, has side 1, and p side -1.
`Thresholds.pulled` is the depth below which a lone node is pulled upwards, and `Thresholds.work`
the adhesion of each link, of opening here.

Of a row, `breaks` are the places of corners of profile and pattern in numbers of nodes, and
`scene.hysteretic` is whether opening takes another work of adhesion than closing, so that lines
stay over a range of depths. Of a lattice, `spring_stiffness` is kΔx, `link_stiffness` t,
`end_stiffness` t(1 - λ) that of a tail, `log_decay` μ = -ln λ, `w` the work of adhesion of closing,
and `axis` 0 about an axis, else nan.
"""

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.nodes.row import Row
from discretization.nodes.thresholds import Thresholds


class ClosingRules(NamedTuple):
    """Newton's method for both lines of a contact that is lost; lengths in links.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 4 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.lattice.loss`.

    Attributes
    ----------
    most_steps : int
        Steps at most; from within a link it takes five.
    step : float
        Step of the difference quotients.
    settled : float
        A step that moves no line by more is the last.
    farthest : float
        Lines that leave their nodes by more are not those of these nodes.
    smooth : float
        Distance from a line within which heights have to be smooth: the reach of the cubic.
    narrowest : float
        Distance at least of two lines that face each other.
    """

    most_steps: int = 12
    step: float = 1e-6
    settled: float = 1e-10
    farthest: float = 2.0
    smooth: float = 2.0
    narrowest: float = 3.0


_RULES = ClosingRules()


@dataclass(frozen=True, eq=False)
class ContactLoss:
    """Contacts of one node between two free surfaces, and when they are lost.

    Attributes
    ----------
    row : Row
    thresholds : Thresholds
        Of lines that recede.
    """

    row: Row
    thresholds: Thresholds

    @functools.lru_cache(maxsize=1 << 12)  # noqa: B019
    def depth(self, before: int | None, node: int, after: int | None) -> float:
        """Depth at which a contact is lost whose last node is this one.

        Parameters
        ----------
        before, after : int or None
            The nodes of the lines that it faces, None if there is none.
        node : int
            Its last contact node.

        Returns
        -------
        float
            [length]; nan where it is not known.
        """
        faced = [other for other in (before, after) if other is not None]
        if not self.smooth(node) or any(abs(other - node) < _RULES.narrowest for other in faced):
            return math.nan
        moving = [other for other in faced if self.smooth(other)]
        if self.row.scene.hysteretic:  # faced lines may be stuck
            moving = []
        depth = self._met(before, node, after, moving)
        if math.isnan(depth) and moving:  # a faced line jumps before: all of them where they are
            depth = self._met(before, node, after, [])
        return depth

    def _met(self, before: int | None, node: int, after: int | None, moving: list[int]) -> float:
        """Depth at which both lines meet while the faced ones that move are at rest [length].

        Parameters
        ----------
        before, after : int or None
            Nodes of the faced lines, which stay there if they are not `moving`.
        node : int
            Where the lines are near which meet.
        moving : list of int
            Those of the faced nodes whose lines move.

        Returns
        -------
        float
            nan if the equations have no solution near these nodes.
        """
        start = [float(node), *map(float, moving)]

        def residuals(unknown: Sequence[float]) -> list[float]:
            """D - d of both lines that meet and of the faced ones that move.

            unknown: the place where they meet, those of the moving lines, and the depth d.
            """
            x = unknown[0]
            depth = unknown[-1]
            at = dict(zip(moving, unknown[1:-1], strict=True))
            left = None if before is None else at.get(before, float(before))
            right = None if after is None else at.get(after, float(after))
            found = [self.rest_depth(x, -1, left), self.rest_depth(x, 1, right)]
            if left is not None and before in at:
                found.append(self.rest_depth(left, 1, x))
            if right is not None and after in at:
                found.append(self.rest_depth(right, -1, x))
            return [one - depth for one in found]

        solved = _newton(residuals, [*start, self.thresholds.pulled(before, node, after)])
        if solved is None or np.abs(np.subtract(solved[:-1], start)).max() > _RULES.farthest:
            return math.nan
        return solved[-1]

    def rest_depth(self, x: float, side: int, faced: float | None) -> float:
        """D of a line between nodes: the depth at which the link around it would just be passed.

        Parameters
        ----------
        x : float
            Where the line is, in nodes; the link goes from half a link inwards to half a link
            outwards of it.
        side : {1, -1}
            On which the free surface is.
        faced : float or None
            Where the line at its other end is; None: there is none.

        Returns
        -------
        float
            [length]; nan if the faced line is no further than a link.
        """
        own = x - side / 2
        after = x + side / 2
        height = self.height(own)
        distance = math.inf if faced is None else abs(faced - own)
        if distance <= 1:  # there is no surface between the lines
            return math.nan
        far, remainder, stiffness = self._beside(distance)
        rise = self.height(after) - height
        if faced is not None:
            rise += far * (height - self.height(faced))
        link = min(max(round(x - 0.5), 0), self.row.size - 2)  # whose middle is next to x
        work = self.thresholds.work[link]
        return height + (rise - math.sqrt(2 * work / stiffness)) / remainder

    def height(self, x: float) -> float:
        """Height of the profile between nodes [length], by the cubic through the next four.

        Of nodes at t = -1, 0, 1, 2 that is h₀ + t (slope - t bend) + turn t (t² - 1), with slope
        and bend of the parabola through the first three, and turn a sixth of the third difference.
        """
        heights = self.thresholds.heights
        first = min(max(math.floor(x) - 1, 0), len(heights) - 4)
        t = x - first - 1
        h_before, h0, h1, h_after = heights[first : first + 4]
        bend = h0 - (h_before + h1) / 2
        turn = (h_after - h_before) / 6 + (h0 - h1) / 2
        slope = (h1 - h_before) / 2
        return h0 + t * (slope - t * bend) + turn * t * (t * t - 1)

    def _beside(self, distance: float) -> tuple[float, float, float]:
        """B, 1 - A - B and S of the free node beside a line, for plain numbers.

        As `Lattice.free_node_response` of a line contact: the node is one link from the line, and
        what is beyond it has distance - 1 links. distance: to the faced line, in links; may be ∞.
        """
        lattice = self.row.lattice
        spring = lattice.spring_stiffness
        link = lattice.link_stiffness
        rate = lattice.log_decay
        if distance == math.inf:
            tie = 0.0
            ground = lattice.end_stiffness
        else:
            # `shares` at p = 1 and q = distance - 2 from the ends of the surface that is left.
            q = distance - 2
            decay_p = math.exp(-rate)
            less_p = math.expm1(-rate)
            decay_q = math.exp(-rate * q)
            less_q = math.expm1(-rate * q)
            tie = link * decay_q * less_p * (2 + less_p) / math.expm1(-2 * rate * (distance - 1))
            ground = link * less_p * less_q / (1 + decay_p * decay_q)
        stiffness = spring + link + tie + ground
        return tie / stiffness, (spring + ground) / stiffness, stiffness

    def smooth(self, node: int) -> bool:
        """Whether neither profile nor pattern has a corner or an end beside a line at this node."""
        if not _RULES.smooth <= node <= self.row.size - 1 - _RULES.smooth:
            return False
        breaks = self.row.breaks
        return not bool((np.abs(breaks - node) <= _RULES.smooth).any())


def is_lost_smoothly(row: Row) -> bool:
    """Whether contacts adhere, and both their lines are free; around an axis one is not."""
    return row.lattice.w > 0 and math.isnan(row.lattice.axis)


def _newton(
    residuals: Callable[[Sequence[float]], list[float]], start: list[float]
) -> list[float] | None:
    """The zero of residuals by Newton's method, None if it does not converge.

    Unknowns are positions, in links, and a depth last. It has converged when no position changes by
    more than 1e-10 links, and failed when one changes by ten times as much as lines may move, or
    after 12 steps. Each residual is D - d, so that its derivative by the depth is -1.
    """
    found = list(start)
    for _ in range(_RULES.most_steps):
        here = residuals(found)
        matrix = np.empty((len(found), len(found)))
        for i in range(len(found) - 1):
            there = [*found]
            there[i] += _RULES.step
            matrix[:, i] = np.subtract(residuals(there), here) / _RULES.step
        matrix[:, -1] = -1.0
        try:
            step: Any = np.linalg.solve(matrix, here)
        except np.linalg.LinAlgError:
            return None
        found = [value - change for value, change in zip(found, step.tolist(), strict=True)]
        moved = np.abs(step[:-1]).max()
        if not moved < 10 * _RULES.farthest:
            return None
        if moved <= _RULES.settled:
            return found
    return None
